"""Pictures of lesson 03: three places, the tuning pictures, and the goal line from several distances."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.datasets import read_pictures
from nao_course.geometry import FloatArray, Pose
from nao_course.metrics import CornerTruth, PointMatch
from nao_course.sim import NAO_V4, CameraView, Field, Reality, SimulatedNao, Truth, render, standard_scenes

Pixels = npt.NDArray[np.uint8]

# The paper's method finds all corners and one of them twice in the first, all of them in the second, none in the third.
PLACES = {
    "near the goal area": Pose(1.77, 0.57, -0.91),
    "from the left": Pose(1.2, -0.38, -0.62),
    "the scene of lesson 01": Pose(0.6, 0.5, -0.25),
}
MORE_ROOMS = range(101, 106)  # seeds of the five sets in `more_rooms`
HEAD_PITCH = float(np.radians(-24.6))  # as in the standard scenes: the bottom camera looks 15.1 degrees down
_WHOLE = Field(2012, half=False)  # there the goal line can be 6 m away
_ASIDE = -1.55  # m: from here the middle columns see the goal line and carpet, nothing else


@dataclass(frozen=True, eq=False)
class CornerPicture:
    """A picture with the true corners in it.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    truth : CornerTruth
        The true corners, and the points that count neither as found nor as false.
    """

    pixels: Pixels
    truth: CornerTruth

    def match(self, points: npt.ArrayLike) -> PointMatch:
        """Pair found corners (N, 2) with the true ones."""
        return self.truth.match(points)


@cache
def three_places() -> Mapping[str, CornerPicture]:
    """Take one picture from each of `PLACES`, by its title; the pictures are read-only and always the same."""
    return MappingProxyType({title: _picture_at(pose) for title, pose in PLACES.items()})


def running_picture() -> CornerPicture:
    """Return the picture near the goal area, to which the lesson returns after each exercise."""
    return next(iter(three_places().values()))


def running_robot() -> SimulatedNao:
    """Return a robot where the running picture was taken; the corners disappear when it walks backwards."""
    return _robot_at(next(iter(PLACES.values())))


def _robot_at(pose: Pose) -> SimulatedNao:
    return SimulatedNao(Field(2012), pose, rng=41)


def _picture_at(pose: Pose) -> CornerPicture:
    """Take a read-only picture at a pose of the standard field."""
    nao = _robot_at(pose)
    pixels = nao.take_picture("bottom").pixels
    pixels.setflags(write=False)
    truth = Truth(nao).picture
    assert truth is not None  # a picture was taken
    return CornerPicture(pixels, CornerTruth.of(truth))


def ready_made_segments(pixels: npt.ArrayLike, least: float = 20.0) -> FloatArray:
    """Find line segments (N, 4) in a picture (H, W, 3) or (H, W) with OpenCV's ready-made line segment detector.

    It knows nothing about fields: it marks every straight edge that is at least `least` pixels long.
    """
    picture = np.asarray(pixels, dtype=np.uint8)
    grey = cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY) if picture.ndim == 3 else picture
    found = cv2.createLineSegmentDetector().detect(grey)[0]
    segments = np.zeros((0, 4)) if found is None else np.asarray(found, dtype=float).reshape(-1, 4)
    return segments[np.hypot(*(segments[:, 2:] - segments[:, :2]).T) >= least]


@cache
def tuning_pictures() -> tuple[CornerPicture, ...]:
    """Return the simulator's 30 pictures for tuning a detector; they are always the same."""
    return tuple(
        CornerPicture(scene.pixels, CornerTruth.of(scene.truth)) for scene in standard_scenes("tune")
    )


@cache
def other_rooms() -> tuple[CornerPicture, ...]:
    """Return 30 pictures from other rooms, which no detector was tuned on; the challenge uses the same."""
    return tuple(
        CornerPicture(scene.pixels, CornerTruth.of(scene.truth)) for scene in standard_scenes("report")
    )


@cache
def more_rooms() -> tuple[CornerPicture, ...]:
    """Return 150 pictures from rooms and places that are in no other set."""
    return tuple(
        CornerPicture(scene.pixels, CornerTruth.of(scene.truth))
        for seed in MORE_ROOMS
        for scene in standard_scenes("report", reality=Reality.lab(seed))
    )


def real_pictures() -> tuple[CornerPicture, ...]:
    """Read eight pictures of a real NAO, one from each place; return none if the recordings are not installed.

    The other pictures of the set are kept for reporting results in lesson 04.
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


# --- the goal line from several distances ---


@dataclass(frozen=True, eq=False)
class GoalLinePicture:
    """An RGB picture (H, W, 3) of the goal line straight ahead, and the rows of the line in the middle columns."""

    pixels: Pixels
    rows: slice

    def share(self, labels: npt.ArrayLike) -> float:
        """Return the fraction of the middle columns in which the line has a white pixel in labels (H, W)."""
        middle = np.asarray(labels).shape[1] // 2
        line = np.asarray(labels)[self.rows, middle - 20 : middle + 20]
        return float((line == 3).any(axis=0).mean())


def goal_line_view() -> CameraView:
    """Return the camera of these pictures: pitched 15.1 degrees down, 0.48 m above the ground."""
    return NAO_V4.view("bottom", 0.0, HEAD_PITCH, (320, 240))


def goal_line_at(distances: npt.ArrayLike, reality: Reality | None = None) -> list[GoalLinePicture]:
    """Take pictures of the goal line with only carpet behind it.

    The distances (N,) are from the point below the camera to the line's far edge, in metres.
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
    """Compute how many rows of a picture a stretch of ground straight ahead covers (equation 3.2).

    Parameters
    ----------
    distance : array_like
        From the point below the camera to the near end of the stretch, metres.
    length : float
        Length of the stretch, metres.
    view : CameraView, optional
        Its focal length, height and pitch are used; by default the camera of the goal line's pictures.
    """
    view, d = view or goal_line_view(), np.asarray(distance, dtype=float)
    near, far = (each * np.cos(view.pitch) + view.height * np.sin(view.pitch) for each in (d, d + length))
    return np.asarray(view.focal[1] * view.height * length / (near * far))
