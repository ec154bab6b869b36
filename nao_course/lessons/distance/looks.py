"""Pictures of the field with marked landmarks, and the errors that an unknown tilt causes in them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose, as_points
from nao_course.sim import NAO_V4, CameraView, Field, Reality, SimulatedNao, TorsoTilt, Truth
from nao_course.slam import LandmarkKind

HEAD_PITCH = float(np.radians(-31.0 + 6.4))  # where a real NAO's head really was (docs/real_data.md)
PIXEL_SIGMA = 0.7  # px, of marks that are set by hand
TILT_SIGMA = float(np.radians(1.0))  # of the simulator's torso

Function = Callable[..., Any]


@dataclass(frozen=True, eq=False)
class MarkedPicture:
    """A picture with its corners and posts marked.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    view : CameraView
        Assumed view of the camera.
    pose : Pose
        The robot's, in the world.
    marks : ndarray, shape (N, 2)
        (u, v) of the landmarks, as they were marked.
    landmarks : ndarray, shape (N, 2)
        Where they are, world frame, metres.
    kinds : tuple of str
        N of "corner" and "post".
    """

    pixels: npt.NDArray[np.uint8]
    view: CameraView
    pose: Pose
    marks: FloatArray
    landmarks: FloatArray
    kinds: tuple[LandmarkKind, ...]

    def with_tilt(self, tilt: float) -> MarkedPicture:
        """Return the same picture from a camera that points lower than assumed by `tilt` (rad)."""
        return replace(self, view=replace(self.view, pitch=self.view.pitch - tilt))

    def within(self, reach: float) -> MarkedPicture:
        """Return the same picture with only those marks whose landmarks are within a distance of the robot, m."""
        near = np.linalg.norm(self.landmarks - self.pose.as_array()[:2], axis=1) < reach
        kinds = tuple(kind for kind, is_near in zip(self.kinds, near, strict=True) if is_near)
        return replace(self, marks=self.marks[near], landmarks=self.landmarks[near], kinds=kinds)


def usual_view(size: tuple[int, int] = (320, 240), lens: bool = True) -> CameraView:
    """Return the view of a standing NAO's bottom camera, 15 degrees down, with or without its lens term."""
    view = NAO_V4.view("bottom", 0.0, HEAD_PITCH, size)
    return view if lens else replace(view, k1=0.0)


def look_around(
    pose: Pose,
    yaws: Sequence[float],
    rng: int = 0,
    reality: Reality | None = None,
    tilt: TorsoTilt | None = None,
    pixel_sigma: float = PIXEL_SIGMA,
) -> list[MarkedPicture]:
    """Take a picture for each yaw of the head, and mark its landmarks as by hand.

    Parameters
    ----------
    pose : Pose
        The robot's, in the world.
    yaws : sequence of float
        Of the head, rad.
    rng : int
        Seed of the noise and of the tilt of each picture.
    reality : Reality, optional
        How real the pictures look.
    tilt : TorsoTilt, optional
        Standard deviations of the tilt.
    pixel_sigma : float
        Standard deviation of the marks, px.
    """
    nao = SimulatedNao(Field(2012), pose, rng=rng, reality=reality, tilt=tilt)
    by_hand = np.random.default_rng([rng, 4])
    return [_look(nao, yaw, by_hand, pixel_sigma) for yaw in yaws]


def _look(nao: SimulatedNao, yaw: float, by_hand: np.random.Generator, pixel_sigma: float) -> MarkedPicture:
    nao.look(yaw, HEAD_PITCH)
    picture, truth = nao.take_picture("bottom"), Truth(nao)
    assert truth.picture is not None  # a picture was taken
    seen = [each for each in truth.picture.landmarks if each.landmark.detected_as and not each.occluded]
    marks = as_points([each.pixel for each in seen])
    kinds = tuple(kind for each in seen if (kind := each.landmark.detected_as))
    places = truth.field.pose.to_parent([(each.landmark.x, each.landmark.y) for each in seen])
    return MarkedPicture(
        picture.pixels,
        picture.view,
        truth.pose,
        marks + pixel_sigma * by_hand.standard_normal(marks.shape),
        places,
        kinds,
    )


def tilted_measurements(
    pixel_to_ground: Function,
    ground_to_measurement: Function,
    view: CameraView,
    points: npt.ArrayLike,
    tilts: npt.ArrayLike,
    pixel_errors: npt.ArrayLike = 0.0,
) -> FloatArray:
    """Return (bearing, range) (M, k, 2), rad and m, of points in M pictures, each with an unknown tilt of the camera.

    The points (k, 2) are on the ground, in the robot frame, in metres. The tilts (M,) are angles in rad by which the
    camera looks lower than assumed, and the errors of the pixels can be broadcast to (M, k, 2).
    """
    places, angles = as_points(points), np.asarray(tilts, dtype=float)
    pixels = np.array([replace(view, pitch=view.pitch + tilt).project(places) for tilt in angles])
    pixels = pixels + np.broadcast_to(pixel_errors, pixels.shape)
    measured = measure_pixels(pixel_to_ground, ground_to_measurement, pixels.reshape(-1, 2), view)
    return measured.reshape(len(angles), len(places), 2)


def measure_pixels(
    pixel_to_ground: Function, ground_to_measurement: Function, pixels: npt.ArrayLike, view: CameraView
) -> FloatArray:
    """Measure pixels (N, 2) with the student's functions: (N, 2) of bearing and range, rad and m.

    Raise a ValueError with the function's name if its answer has another shape or nothing but NaN.
    """
    ground = rows_of_two("pixel_to_ground", pixel_to_ground(as_points(pixels), view), len(as_points(pixels)))
    return rows_of_two("ground_to_measurement", ground_to_measurement(ground), len(ground))


def rows_of_two(name: str, answer: Any, number: int) -> FloatArray:
    """Return a student's answer as an array (number, 2).

    Raise a ValueError with the function's name if it has another shape or nothing but NaN.
    """
    if answer is None:
        raise ValueError(f"{name} gave None: a return may be missing")
    array = np.asarray(answer, dtype=float)
    if array.shape != (number, 2):
        raise ValueError(
            f"{name} should give a row of two for each of {number} points, got shape {array.shape}"
        )
    if number and np.isnan(array).all():
        raise ValueError(f"{name} gave NaN for each of {number} points, of which most lie on the ground")
    return array


def ahead(distances: npt.ArrayLike, view: CameraView) -> FloatArray:
    """Return points (N, 2) in the robot frame along the camera's direction, at these ground distances from it in m."""
    away = np.asarray(distances, dtype=float)
    way = np.array([np.cos(view.yaw), np.sin(view.yaw)])
    return np.array(view.offset) + away[:, None] * way


def points_covariance(measurements: npt.ArrayLike, covariance: npt.ArrayLike) -> FloatArray:
    """Return the first-order covariances (k, 2, 2), in m^2, of points (x, y) in the robot frame.

    The measurements (k, 2) have a covariance (2k, 2k) in the order bearing, range, bearing, range, ...
    """
    polar, full = as_points(measurements), np.asarray(covariance, dtype=float)
    if full.shape != (2 * len(polar), 2 * len(polar)):
        raise ValueError(
            f"{len(polar)} measurements have a covariance of that many blocks of 2 x 2, got shape {full.shape}"
        )
    found = np.empty((len(polar), 2, 2))
    for i, (bearing, away) in enumerate(polar):
        c, s = np.cos(bearing), np.sin(bearing)
        jacobian = np.array([[-away * s, c], [away * c, s]])
        found[i] = jacobian @ full[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] @ jacobian.T
    return found
