"""The posts panel: the student's detector of goal posts in several scenes, with its four parameters on sliders."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.geometry import as_points
from nao_course.lessons.goalposts.figures import CANDIDATE
from nao_course.lessons.goalposts.scenes import PostScene
from nao_course.plotting import painted
from nao_course.plotting.marks import TRUE, at_scale, enlarged, rgb, with_crosses
from nao_course.plotting.style import FOUND
from nao_course.widgets import Choice, FunctionPanel, Legend, Slider

Pixels = npt.NDArray[np.uint8]
SIZE = 2  # times: how much larger than the camera's the shown pictures are
_SLIDERS = (
    Slider(
        "min_green",
        "Green pixels",
        0,
        20,
        1,
        8,
        unit="px",
        tooltip="Smallest number of green pixels below the foot",
    ),
    Slider(
        "look_down", "Look down", 1, 30, 1, 10, unit="px", tooltip="Number of pixels tested below the foot"
    ),
    Slider(
        "min_height",
        "Smallest height",
        0.0,
        0.5,
        0.01,
        0.1,
        tooltip="Smallest height of the yellow run, as a fraction of the picture's height",
    ),
    Slider(
        "max_distance",
        "Distance",
        0,
        60,
        1,
        20,
        unit="px",
        tooltip="Candidates that are not farther apart belong to one post",
    ),
)
_UNFINISHED = {
    "label": "Finish exercises 1.3 and 1.5 of lesson 01 to see this, because the search uses your labels.",
    "post_candidates": "Finish exercise 2.1 to see your candidates.",
    "cluster_points": "Finish exercise 2.2 to see the feet.",
}


def mark_feet(
    pixels: npt.ArrayLike, feet: npt.ArrayLike, candidates: npt.ArrayLike = (), true: npt.ArrayLike = ()
) -> Pixels:
    """Return a picture (H, W, 3) at twice its size: candidates as dots, feet as circles, true feet as crosses.

    Points are (u, v) px of the picture as it was given.
    """
    shown = enlarged(pixels, SIZE)
    scale = max(1, round(len(shown) / 240))
    dots = at_scale(candidates, SIZE, "candidates (u, v)")
    for colour, radius in (((255, 255, 255), 3 * scale), (rgb(CANDIDATE), 2 * scale)):
        for u, v in dots:
            cv2.circle(shown, (round(u), round(v)), radius, colour, -1, cv2.LINE_AA)
    for u, v in at_scale(feet, SIZE, "feet (u, v)"):
        for colour, thickness in (((255, 255, 255), 3 * scale), (rgb(FOUND), 2 * scale)):
            cv2.circle(shown, (round(u), round(v)), 7 * scale, colour, thickness, cv2.LINE_AA)
    return with_crosses(shown, at_scale(true, SIZE, "true feet (u, v)"), scale)


class PostPanel(FunctionPanel):
    """Show scenes, their labels, and the points that your search finds, with sliders for its four parameters.

    Parameters
    ----------
    scenes : mapping of str to PostScene
        Scenes by their names.
    label : callable
        ``label(pixels)`` returns labels (H, W), as lesson 01 makes them.
    post_candidates : callable
        ``post_candidates(labels, min_green, look_down, min_height)`` returns points (N, 2).
    cluster_points : callable
        ``cluster_points(points, max_distance)`` returns points (K, 2).

    Raises
    ------
    ValueError
        If there is no scene.
    """

    def __init__(
        self,
        scenes: Mapping[str, PostScene],
        label: Callable[..., Any],
        post_candidates: Callable[..., Any],
        cluster_points: Callable[..., Any],
    ) -> None:
        """Search the first scene and build the widgets."""
        if not scenes:
            raise ValueError("scenes must hold at least one scene, got none")
        self._scenes = dict(scenes)
        super().__init__(
            "Posts panel",
            self._search,
            [
                Choice("scene", "Scene", list(scenes), tooltip="Which picture is searched", stays=True),
                *_SLIDERS,
            ],
            student={"label": label, "post_candidates": post_candidates, "cluster_points": cluster_points},
            unfinished=_UNFINISHED,
        )

    def _search(self, values: Any, student: Any) -> Iterator[Any]:
        """Show the scene, its labels, the candidates, and at last the feet."""
        scene = self._scenes[values.scene]
        yield {"What you find": mark_feet(scene.pixels, ())}
        yield Legend({"candidate (dot)": CANDIDATE, "detected foot (ring)": FOUND, "true foot (cross)": TRUE})
        labels = student.label(scene.pixels)
        yield {"Your labels": mark_feet(painted(labels), ())}
        candidates = student.post_candidates(labels, values.min_green, values.look_down, values.min_height)
        yield {"Your labels": mark_feet(painted(labels), (), candidates)}
        feet = student.cluster_points(as_points(candidates), values.max_distance)
        yield {"What you find": mark_feet(scene.pixels, feet, candidates, scene.feet.pixels)}
        counts = f"{say_count(len(candidates), 'candidate')} in {say_count(len(feet), 'cluster')}"
        asks_too_much = values.min_green > values.look_down
        more = (
            f" No column can pass: of the {say_count(values.look_down, 'pixel')} below the foot, "
            f"{values.min_green} would have to be green."
            if asks_too_much
            else ""
        )
        yield f"{counts}: {scene.match(feet)}.{more}"
