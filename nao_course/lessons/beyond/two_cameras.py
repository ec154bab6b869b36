"""The distance of a point on the floor, measured by one camera of a NAO and by both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray, as_points
from nao_course.sim import NAO_V4, CameraView

Function = Callable[..., Any]
# Standard deviations of the body's pitch and roll, rad.
TILT = (float(np.radians(1.3)), float(np.radians(0.8)))
PIXEL_SIGMA = 0.5  # px, at any resolution
SIZES = ((320, 240), (640, 480), (1280, 960))
DISTANCES = (1.0, 2.0, 3.0, 4.0, 5.0)  # m
CAMERAS = ("top", "bottom")
BETWEEN = float((NAO_V4.cameras["top"].pitch + NAO_V4.cameras["bottom"].pitch) / 2)  # rad: mean of both axes
# rad: from there to either axis
OFF_AXIS = float((NAO_V4.cameras["bottom"].pitch - NAO_V4.cameras["top"].pitch) / 2)


def ray(view: CameraView, pixel: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the origin (3,) in m and the unit direction (3,) of the ray of a pixel (2,), in the robot frame.

    The pixel (u, v) is distorted by the lens.
    """
    across, down = ((view.undistort(as_points([pixel])) - view.centre) / view.focal)[0]
    direction = view.rotation @ np.array([1.0, -across, -down])
    return view.position, direction / np.linalg.norm(direction)


def pitch_for(distance: float) -> float:
    """Return the head pitch, rad, at which a point on the floor is central in the area that both cameras see."""
    low, high = NAO_V4.pitch_limits
    return float(np.clip(np.arctan2(NAO_V4.neck_height() + 0.05, distance) - BETWEEN, low, high))


@dataclass(frozen=True)
class Distances:
    """Repeated measurements (n,) of one point's distance (m), from the bottom camera and the floor, and from both.

    They are infinite if a ray does not reach the floor, and NaN if a camera does not see the point.
    """

    one: FloatArray
    both: FloatArray
    truth: float

    @property
    def sigmas(self) -> tuple[float, float]:
        """Robust standard deviations of both, m: 1.483 times the median absolute error."""
        return _scatter(self.one - self.truth), _scatter(self.both - self.truth)

    @property
    def seen(self) -> float:
        """Fraction of the measurements in which both cameras see the point."""
        return float(np.isfinite(self.both).mean())


def _scatter(errors: FloatArray) -> float:
    kept = np.abs(errors[~np.isnan(errors)])
    return float(1.4826 * np.median(kept)) if len(kept) else float("nan")


def measure_again(
    intersect_rays: Function,
    pixel_to_ground: Function,
    distance: float,
    size: tuple[int, int],
    *,
    pitch: float | None = None,
    tilt: tuple[float, float] = TILT,
    count: int = 300,
    seed: int = 0,
) -> Distances:
    """Measure a point straight ahead on the floor repeatedly, each time with new errors of body tilt and pixels.

    Parameters
    ----------
    intersect_rays, pixel_to_ground : callable
        The student's functions of this lesson and of lesson 04.
    distance : float
        Of the point, m.
    size : (int, int)
        Width and height of the pictures, px.
    pitch : float, optional
        Of the head, rad; by default `pitch_for` the distance.
    tilt : (float, float)
        Standard deviations of the body's pitch and roll, rad, which the robot does not measure.
    count, seed : int
        Number of measurements, and seed of their errors.
    """
    rng = np.random.default_rng([seed, 121])
    pitch = pitch_for(distance) if pitch is None else pitch
    upright = [NAO_V4.view(camera, 0.0, pitch, size=size) for camera in CAMERAS]
    one, both = np.full(count, np.nan), np.full(count, np.nan)
    point = np.array([[distance, 0.0]])
    for number in range(count):
        torso_pitch, torso_roll = rng.normal(0.0, tilt)
        pixels = []
        for camera in CAMERAS:
            view = NAO_V4.view(camera, 0.0, pitch, size=size, torso_pitch=torso_pitch, torso_roll=torso_roll)
            pixels.append(view.project(point)[0] + rng.normal(0.0, PIXEL_SIGMA, 2))
        top, bottom = (
            bool(view.contains(pixel[None])[0]) for view, pixel in zip(upright, pixels, strict=True)
        )
        if bottom:
            ground = np.asarray(pixel_to_ground(pixels[1][None].copy(), upright[1]), dtype=float)[0]
            one[number] = np.hypot(*ground) if np.isfinite(ground).all() else np.inf
        if top and bottom:
            rays = [each for view, pixel in zip(upright, pixels, strict=True) for each in ray(view, pixel)]
            place, _ = intersect_rays(*rays)
            place = np.asarray(place, dtype=float)
            both[number] = np.hypot(*place[:2]) if np.isfinite(place).all() else np.inf
    return Distances(one, both, distance)


def expected_sigmas(distance: float, width: int) -> tuple[float, float]:
    """Return the predicted errors of one camera and of both, m: r^2 / h sigma_tilt, and r^2 / |B| sqrt(2) sigma_phi.

    sigma_phi is the angle of half a pixel in the overlap, near the edges of the pictures, where it is smaller by the
    squared cosine of the angle from the optical axis.
    """
    views = [
        NAO_V4.view(camera, 0.0, pitch_for(distance), size=(width, width * 3 // 4)) for camera in CAMERAS
    ]
    baseline = float(np.linalg.norm(views[0].position - views[1].position))
    off_axis = float(NAO_V4.cameras["bottom"].pitch - NAO_V4.cameras["top"].pitch) / 2
    angle = np.cos(off_axis) ** 2 * PIXEL_SIGMA / views[1].focal[1]
    return distance**2 / views[1].height * TILT[0], float(distance**2 / baseline * np.sqrt(2) * angle)
