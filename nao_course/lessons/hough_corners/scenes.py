"""Pictures of lesson 03: places for its figures, pictures to measure detectors on, and the goal line from afar."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.datasets import read_pictures
from nao_course.geometry import FloatArray, Pose
from nao_course.metrics import CornerTruth, PointMatch
from nao_course.sim import NAO_V4, CameraView, Field, Reality, SimulatedNao, render, standard_scenes

Pixels = npt.NDArray[np.uint8]

# By the paper's method: all corners and one of them twice; all and no more; none. The third is lesson 01's scene.
PLACES = {
    "near the halfway line": Pose(1.77, 0.57, -0.91),
    "from the left": Pose(1.2, -0.38, -0.62),
    "the scene of lesson 01": Pose(0.6, 0.5, -0.25),
}
HEAD_PITCH = float(np.radians(-24.6))  # as in the standard scenes: the bottom camera looks 15.1 degrees down
BEHIND = 0.7  # m of carpet behind the field's outer lines
_WHOLE = Field(2012, half=False)  # there the goal line can be 6 m away
_ASIDE = -1.55  # m: from here the middle columns see the goal line and carpet, nothing else


@cache
def three_places() -> Mapping[str, Pixels]:
    """Take one picture from each place, by a title that says where: the same at every call, and read-only."""
    pictures = {
        title: SimulatedNao(Field(2012), pose, rng=41).take_picture("bottom").pixels
        for title, pose in PLACES.items()
    }
    for pixels in pictures.values():
        pixels.setflags(write=False)
    return MappingProxyType(pictures)


@dataclass(frozen=True, eq=False)
class CornerPicture:
    """A picture with the corners in it.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    truth : CornerTruth
        The corners, and what may be taken for one.
    """

    pixels: Pixels
    truth: CornerTruth

    def match(self, points: npt.ArrayLike) -> PointMatch:
        """Pair found corners (N, 2) with the true ones."""
        return self.truth.match(points)


@cache
def tuning_pictures() -> tuple[CornerPicture, ...]:
    """Make the 30 pictures of the simulator to choose a detector's values on: the same at every call."""
    return tuple(
        CornerPicture(scene.pixels, CornerTruth.of(scene.truth)) for scene in standard_scenes("tune")
    )


def real_pictures() -> tuple[CornerPicture, ...]:
    """Read eight pictures of a real NAO, one from each place; none where the recordings are not.

    The others of the set stay unseen, to report on (lesson 04).
    """
    try:
        scenes = read_pictures("scenes")
    except FileNotFoundError:
        return ()
    return tuple(
        CornerPicture(scene.pixels, CornerTruth.marked(scene.points)) for scene in scenes if scene.has_large
    )


def match_pictures(find: Callable[[Any], Any], pictures: Sequence[CornerPicture]) -> list[PointMatch]:
    """Run a detector on pictures: `find(pixels)` returns corners (K, 2)."""
    return [picture.match(find(picture.pixels.copy())) for picture in pictures]


# --- the goal line from afar ---


@dataclass(frozen=True, eq=False)
class GoalLinePicture:
    """A picture of the goal line, straight ahead.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    rows : slice
        Where the line is in the middle columns.
    """

    pixels: Pixels
    rows: slice

    def share(self, labels: npt.ArrayLike) -> float:
        """Return in which part of the middle columns some of the line is white in labels (H, W)."""
        middle = np.asarray(labels).shape[1] // 2
        line = np.asarray(labels)[self.rows, middle - 20 : middle + 20]
        return float((line == 3).any(axis=0).mean())


def goal_line_view() -> CameraView:
    """Return the camera that takes these pictures: 15.1 degrees down, 0.48 m above the ground."""
    return NAO_V4.view("bottom", 0.0, HEAD_PITCH, (320, 240))


def goal_line_at(distances: npt.ArrayLike, reality: Reality | None = None) -> list[GoalLinePicture]:
    """Take pictures of the goal line, with only carpet behind it.

    Parameters
    ----------
    distances : array_like, shape (N,)
        From below the camera to the line's far edge, metres.
    reality : Reality, optional
        How real they look; by default without any effect.
    """
    view, width = goal_line_view(), _WHOLE.dimensions.line_width
    edge = _WHOLE.dimensions.length / 2 + width / 2
    taken = []
    for i, distance in enumerate(np.asarray(distances, dtype=float)):
        pose = Pose(float(edge - distance - view.offset[0]), _ASIDE, 0.0)
        pixels, _ = render(_WHOLE, pose, view, reality or Reality.clean(), np.random.default_rng([803, i]))
        far, near = view.project([(edge - x, 0.0, 0.0) for x in (pose.x, pose.x + width)])[:, 1]
        taken.append(GoalLinePicture(pixels, slice(int(np.floor(far)) - 1, int(np.ceil(near)) + 2)))
    return taken


def rows_between(distance: npt.ArrayLike, length: float, view: CameraView | None = None) -> FloatArray:
    """Compute how many rows a stretch of the ground straight ahead takes in a picture, equation 3.2 of the lesson.

    Parameters
    ----------
    distance : array_like
        From below the camera to its near end, metres.
    length : float
        Of the stretch, metres.
    view : CameraView, optional
        Its focal length, height and pitch count; by default that of the goal line's pictures.
    """
    view, d = view or goal_line_view(), np.asarray(distance, dtype=float)
    near, far = (each * np.cos(view.pitch) + view.height * np.sin(view.pitch) for each in (d, d + length))
    return np.asarray(view.focal[1] * view.height * length / (near * far))
