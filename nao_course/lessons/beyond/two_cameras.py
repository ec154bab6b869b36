"""Both cameras of a NAO look at one point of the floor: how far it is by one of them, and by both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray, as_points
from nao_course.sim import NAO_V4, CameraView

Function = Callable[..., Any]
LEAN = (float(np.radians(1.3)), float(np.radians(0.8)))  # rad: pitch and roll of the body, of a picture
PIXEL_SIGMA = 0.5  # px, whatever the resolution
SIZES = ((320, 240), (640, 480), (1280, 960))
DISTANCES = (1.0, 2.0, 3.0, 4.0, 5.0)  # m
CAMERAS = ("top", "bottom")
MIDDLE = float((NAO_V4.cameras["top"].pitch + NAO_V4.cameras["bottom"].pitch) / 2)  # rad: where both see
OFF_AXIS = float(
    (NAO_V4.cameras["bottom"].pitch - NAO_V4.cameras["top"].pitch) / 2
)  # rad: there, from either axis


def ray(view: CameraView, pixel: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where a pixel's ray begins and where it goes.

    Parameters
    ----------
    view : CameraView
        Any.
    pixel : ndarray, shape (2,)
        (u, v), lens included.

    Returns
    -------
    origin : ndarray, shape (3,)
        The camera, m in the robot frame.
    direction : ndarray, shape (3,)
        Of length 1.
    """
    across, down = ((view.undistort(as_points([pixel])) - view.centre) / view.focal)[0]
    direction = view.rotation @ np.array([1.0, -across, -down])
    return view.position, direction / np.linalg.norm(direction)


def pitch_for(distance: float) -> float:
    """Pitch of the head, rad, at which a point of the floor lies in the middle of what both cameras see."""
    low, high = NAO_V4.pitch_limits
    return float(np.clip(np.arctan2(NAO_V4.neck_height() + 0.05, distance) - MIDDLE, low, high))


@dataclass(frozen=True)
class Looks:
    """Distances of one point, measured again and again.

    Parameters
    ----------
    one, both : ndarray, shape (n,)
        By the bottom camera and the floor, and by both cameras, m; infinite for a ray that does not come down, NaN
        where a camera does not see the point.
    truth : float
        m.
    """

    one: FloatArray
    both: FloatArray
    truth: float

    @property
    def sigmas(self) -> tuple[float, float]:
        """Scatter of both around the truth, m: 1.483 times the median error, which outliers do not move."""
        return _scatter(self.one - self.truth), _scatter(self.both - self.truth)

    @property
    def seen(self) -> float:
        """Part of the looks in which both cameras see the point."""
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
    lean: tuple[float, float] = LEAN,
    looks: int = 300,
    seed: int = 0,
) -> Looks:
    """Measure a point straight ahead on the floor, each time with another lean of the body and other pixels.

    Parameters
    ----------
    intersect_rays, pixel_to_ground : callable
        The student's, of this lesson and of lesson 04.
    distance : float
        Of the point, m.
    size : (int, int)
        Of the pictures, px.
    pitch : float, optional
        Of the head, rad; by default that of `pitch_for`.
    lean : (float, float)
        Standard deviations of the body's pitch and roll, rad. The robot knows of none.
    looks, seed : int
        How many, and which.
    """
    rng = np.random.default_rng([seed, 121])
    pitch = pitch_for(distance) if pitch is None else pitch
    believed = [NAO_V4.view(camera, 0.0, pitch, size=size) for camera in CAMERAS]
    one, both = np.full(looks, np.nan), np.full(looks, np.nan)
    point = np.array([[distance, 0.0]])
    for look in range(looks):
        torso_pitch, torso_roll = rng.normal(0.0, lean)
        pixels = []
        for camera in CAMERAS:
            view = NAO_V4.view(camera, 0.0, pitch, size=size, torso_pitch=torso_pitch, torso_roll=torso_roll)
            pixels.append(view.project(point)[0] + rng.normal(0.0, PIXEL_SIGMA, 2))
        top, bottom = (
            bool(view.contains(pixel[None])[0]) for view, pixel in zip(believed, pixels, strict=True)
        )
        if bottom:
            ground = np.asarray(pixel_to_ground(pixels[1][None].copy(), believed[1]), dtype=float)[0]
            one[look] = np.hypot(*ground) if np.isfinite(ground).all() else np.inf
        if top and bottom:
            rays = [each for view, pixel in zip(believed, pixels, strict=True) for each in ray(view, pixel)]
            place, _ = intersect_rays(*rays)
            place = np.asarray(place, dtype=float)
            both[look] = np.hypot(*place[:2]) if np.isfinite(place).all() else np.inf
    return Looks(one, both, distance)


def expected_sigmas(distance: float, width: int) -> tuple[float, float]:
    """What the formulas say of one camera and of both, m: r^2 / h sigma_lean, and r^2 / |B| sqrt(2) sigma_phi.

    sigma_phi is the angle of half a pixel where both cameras see: at the pictures' rims, where it is smaller by the
    squared cosine of the angle from the middle.
    """
    views = [
        NAO_V4.view(camera, 0.0, pitch_for(distance), size=(width, width * 3 // 4)) for camera in CAMERAS
    ]
    baseline = float(np.linalg.norm(views[0].position - views[1].position))
    off_axis = float(NAO_V4.cameras["bottom"].pitch - NAO_V4.cameras["top"].pitch) / 2
    angle = np.cos(off_axis) ** 2 * PIXEL_SIGMA / views[1].focal[1]
    return distance**2 / views[1].height * LEAN[0], float(distance**2 / baseline * np.sqrt(2) * angle)
