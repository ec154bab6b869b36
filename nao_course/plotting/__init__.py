"""Figures of the course: maps of the field, paths, estimates with their ellipses, and pictures.

Functions that begin with ``plot_`` add to an axis, and functions that begin with ``draw_`` return a finished `Drawing`.
The package does not use pyplot, so that a figure is never shown twice and does not stay in memory.
"""

from typing import TYPE_CHECKING

from nao_course._internal.lazy_names import import_as_typed, list_public

if TYPE_CHECKING:
    from nao_course.plotting.drawing import Drawing, Table, image_tag, table
    from nao_course.plotting.ellipses import ellipse_outlines, estimate_outlines, plot_ellipse
    from nao_course.plotting.guesses import Guess, guessed, with_guess
    from nao_course.plotting.maps import (
        draw_map,
        plot_estimate,
        plot_field,
        plot_landmarks,
        plot_measurements,
    )
    from nao_course.plotting.paths import PathLike, as_path, plot_path, plot_pose
    from nao_course.plotting.pictures import (
        draw_labels,
        draw_picture,
        draw_pictures,
        painted,
        plot_found,
        plot_picture,
    )
    from nao_course.plotting.style import (
        LABEL_COLOURS,
        LANDMARK_MARKERS,
        STYLES,
        Style,
        course_style,
        style_of,
    )

__all__ = [
    "LABEL_COLOURS",
    "LANDMARK_MARKERS",
    "STYLES",
    "Drawing",
    "Guess",
    "PathLike",
    "Style",
    "Table",
    "as_path",
    "course_style",
    "draw_labels",
    "draw_map",
    "draw_picture",
    "draw_pictures",
    "ellipse_outlines",
    "estimate_outlines",
    "guessed",
    "image_tag",
    "painted",
    "plot_ellipse",
    "plot_estimate",
    "plot_field",
    "plot_found",
    "plot_landmarks",
    "plot_measurements",
    "plot_path",
    "plot_picture",
    "plot_pose",
    "style_of",
    "table",
    "with_guess",
]
__getattr__ = import_as_typed(__name__, __file__)
__dir__ = list_public(__name__)
