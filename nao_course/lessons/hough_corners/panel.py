"""The corners panel: shows the student's segments and corners, with the paper's parameters on sliders."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.geometry import as_points
from nao_course.lessons.hough_corners.figures import SEGMENTS
from nao_course.lessons.hough_corners.scenes import CornerPicture
from nao_course.metrics import corner_cost
from nao_course.plotting import painted
from nao_course.plotting.marks import TRUE, at_scale, enlarged, rgb, with_crosses, with_rings
from nao_course.plotting.style import FOUND
from nao_course.widgets import Choice, FunctionPanel, Legend, Slider

Pixels = npt.NDArray[np.uint8]
SIZE = 2  # times: how much larger than the camera's the shown pictures are


class CornerPanel(FunctionPanel):
    """Show a picture, its labels without background, the segments and the corners, with a slider per parameter.

    Parameters
    ----------
    pictures : mapping of str to CornerPicture
        The pictures to choose from, by name.
    label : callable
        ``label(pixels, beta)`` returns labels (H, W), as lesson 01 makes them.
    erase_background : callable
        ``erase_background(labels, run)`` returns labels (H, W).
    find_segments : callable
        ``find_segments(labels, gap, length)`` returns segments (N, 4) in the labels that were not erased.
    find_corners : callable
        ``find_corners(labels, run, gap, length, reach)`` returns corners (K, 2).

    Raises
    ------
    ValueError
        If there is no picture.
    """

    def __init__(
        self,
        pictures: Mapping[str, CornerPicture],
        label: Callable[..., Any],
        erase_background: Callable[..., Any],
        find_segments: Callable[..., Any],
        find_corners: Callable[..., Any],
    ) -> None:
        """Search the first picture and build the widgets."""
        if not pictures:
            raise ValueError("pictures must hold at least one picture, got none")
        self._searched = dict(pictures)
        super().__init__(
            "Corners panel",
            self._search,
            [
                Choice("picture", "Picture", list(pictures), tooltip="The picture to search", stays=True),
                _whole(
                    "beta", "Beta", 60, 200, 120, "Parameter of the white threshold, a lightness", unit=""
                ),
                _whole("run", "Run of green", 1, 15, 7, "Length of the green run where the field begins"),
                _whole("gap", "Max. gap", 0, 20, 5, "Largest gap within a segment"),
                _whole(
                    "length", "Min. length", 10, 80, 40, "Length of the shortest segment that is returned"
                ),
                _whole("reach", "Reach", 0, 60, 5, "How far segments are extended at each end"),
            ],
            student={
                "label": label,
                "erase_background": erase_background,
                "find_segments": find_segments,
                "find_corners": find_corners,
            },
            unfinished={
                "label": "Finish lesson 01 to see this: the search starts from your labels.",
                "erase_background": "Finish exercise 3.2 to see the labels after erasing.",
                "find_segments": "Finish exercises 3.1 and 3.3 to see your segments.",
                "find_corners": "Finish exercise 3.6 to see the corners.",
            },
        )

    def _search(self, values: Any, student: Any) -> Iterator[Any]:
        """Show the picture, then its labels, the segments and the corners, as far as the functions are written."""
        picture = self._searched[values.picture]
        true = picture.truth.corners
        yield {"What you find": mark_found(picture.pixels, (), (), true)}
        yield Legend(
            {"true corner (cross)": TRUE, "corner found (ring)": FOUND}
            | {f"segments {i + 1}, {i + 4}, ... (line)": colour for i, colour in enumerate(SEGMENTS)}
        )
        labels = student.label(picture.pixels, values.beta)
        left = student.erase_background(labels, values.run)
        yield {"Labels after erasing": painted(left)}
        segments = as_points(
            student.find_segments(left, values.gap, values.length), 4, "segments (u1, v1, u2, v2)"
        )
        yield {"What you find": mark_found(picture.pixels, segments, (), true)}
        corners = student.find_corners(labels, values.run, values.gap, values.length, float(values.reach))
        yield {"What you find": mark_found(picture.pixels, segments, corners, true)}
        match = picture.match(corners)
        yield (
            f"{say_count(len(segments), 'segment')}, {say_count(len(corners), 'corner')}: {match.hits} of "
            f"{say_count(len(match.found), 'true corner')} found, {match.false} false, cost {corner_cost(match):.2f}."
        )


def mark_found(
    pixels: npt.ArrayLike, segments: npt.ArrayLike, corners: npt.ArrayLike, true: npt.ArrayLike = ()
) -> Pixels:
    """Return a picture (H, W, 3) at twice its size: segments (N, 4) as lines, corners as rings, true ones as crosses.

    Corners are (K, 2), (u, v) px of the picture as it was given.
    """
    shown = enlarged(pixels, SIZE)
    ends = at_scale(as_points(segments, 4).reshape(-1, 2), SIZE).round().astype(int).reshape(-1, 4)
    for i, (u1, v1, u2, v2) in enumerate(ends.tolist()):
        cv2.line(shown, (u1, v1), (u2, v2), rgb(SEGMENTS[i % len(SEGMENTS)]), SIZE, cv2.LINE_AA)
    shown = with_rings(shown, at_scale(corners, SIZE, "corners (u, v)"), scale=SIZE)
    return with_crosses(shown, at_scale(true, SIZE), SIZE)


def _whole(name: str, label: str, low: int, high: int, start: int, tooltip: str, unit: str = "px") -> Slider:
    """Make a slider for whole numbers."""
    return Slider(name, label, low, high, 1, start, unit=unit, tooltip=tooltip)
