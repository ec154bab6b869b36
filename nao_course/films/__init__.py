"""Films: drives that were recorded as numbers, which a browser draws and plays without Python.

A `Film` consists of layers, such as paths, ellipses and landmarks, each with its numbers for every step, and of one
caption for each step. It is stored as JSON with whole millimetres and milliradians. The same script draws the films and
the live map of the panels (`nao_course.widgets.vector_map`).
"""

from nao_course._internal.lazy_names import list_public
from nao_course.films.drives import drive_film
from nao_course.films.film import Film, Matrix, read_film
from nao_course.films.layers import (
    Layer,
    cell_layer,
    curve_layer,
    ellipse_layer,
    landmark_layer,
    line_layer,
    path_layer,
    point_layer,
)
from nao_course.films.pages import film_html, film_page, script, style_sheet
from nao_course.films.recorded import recorded_film, recorded_names

__all__ = [
    "Film",
    "Layer",
    "Matrix",
    "cell_layer",
    "curve_layer",
    "drive_film",
    "ellipse_layer",
    "film_html",
    "film_page",
    "landmark_layer",
    "line_layer",
    "path_layer",
    "point_layer",
    "read_film",
    "recorded_film",
    "recorded_names",
    "script",
    "style_sheet",
]
__dir__ = list_public(__name__)
