"""The tilt panel: marks of a picture as points on the map while the camera looks lower than assumed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb

from nao_course.geometry import FloatArray, Pose, as_points
from nao_course.lessons.distance.looks import MarkedPicture, look_around, points_covariance
from nao_course.lessons.distance.panels.live_map import POINT_MARKER, LiveMap
from nao_course.plotting import LANDMARK_MARKERS, STYLES, table
from nao_course.sim import CameraView, Field, Reality, TorsoTilt
from nao_course.slam import Estimate, LandmarkKind
from nao_course.widgets import FunctionPanel, Pixel, Slider
from nao_course.widgets.vector_map import MapContents

POSE = Pose(0.75, 0.25, -0.05)
START = (150, 150)  # px: on the carpet
AHEAD = 1.3  # m of the map beyond the carpet, for points that are measured too far away
COLOUR = tuple(round(255 * each) for each in to_rgb(STYLES["ekf"].colour))


@cache
def upright_picture() -> MarkedPicture:
    """Take the picture of the panel without any tilt; its marks are exact."""
    (look,) = look_around(
        POSE, [0.0], rng=2, reality=Reality(seed=4), tilt=TorsoTilt(0.0, 0.0), pixel_sigma=0.0
    )
    return look


class TiltPanel(FunctionPanel):
    """Show a picture and the map with your points and ellipses, with sliders for the tilt and its sigma.

    Parameters
    ----------
    pixel_to_ground, ground_to_measurement, measurement_covariance : callable
        The student's.
    """

    def __init__(
        self,
        pixel_to_ground: Callable[..., Any],
        ground_to_measurement: Callable[..., Any],
        measurement_covariance: Callable[..., Any],
    ) -> None:
        """Put the marks on the map and build the widgets."""
        self._look = upright_picture()
        self._map = LiveMap(
            Field(2012),
            {"truth": "true landmark", "ekf": "your points"},
            ahead=AHEAD,
            largest=(4.4, 3.6),  # the panel fits on a small screen
            markers={
                "truth": POINT_MARKER,
                "ekf": "".join(LANDMARK_MARKERS[kind] for kind in ("corner", "post")),
            },
        )
        super().__init__(
            "Tilt panel",
            self._measure,
            [
                Slider(
                    "tilt",
                    "Looks lower by",
                    -3.0,
                    3.0,
                    0.1,
                    1.0,
                    unit="°",
                    tooltip="The angle by which the camera looks lower than assumed",
                ),
                Slider(
                    "sigma",
                    "Tilt sigma",
                    0.0,
                    3.0,
                    0.1,
                    1.0,
                    unit="°",
                    tooltip="Standard deviation of the tilt for your covariance",
                ),
                Slider(
                    "pixel_sigma",
                    "Pixel sigma",
                    0.0,
                    3.0,
                    0.1,
                    0.7,
                    unit="px",
                    tooltip="Standard deviation of u and v of a mark",
                ),
                Pixel("pixel", "Pixel", self._look.view.size, START, tooltip="One more point for the map"),
            ],
            student={
                "pixel_to_ground": pixel_to_ground,
                "ground_to_measurement": ground_to_measurement,
                "measurement_covariance": measurement_covariance,
            },
            unfinished={
                "pixel_to_ground": "Finish exercise 4.4 to see points on the map.",
                "ground_to_measurement": "Finish exercise 4.1 to see points on the map.",
                "measurement_covariance": "Finish exercise 4.6 to see the ellipses.",
            },
            drawn=("Your map",),
        )

    def _measure(self, values: Any, student: Any) -> Iterator[Any]:
        """Show the picture, then the map without and with ellipses, and each landmark's error."""
        look = self._look.with_tilt(float(np.radians(values.tilt)))
        yield {"The picture": mark_pixels(_with_horizon(look.pixels, look.view), look.marks)}
        marks = np.vstack([look.marks, [values.pixel]])
        ground = as_points(student.pixel_to_ground(marks, look.view), name="points on the ground")
        if len(ground) != len(marks):
            raise ValueError(f"{len(marks)} pixels need as many points on the ground, got {len(ground)}")
        seen = np.asarray(np.isfinite(ground).all(axis=1))
        kinds: tuple[LandmarkKind, ...] = tuple(
            kind for kind, there in zip((*look.kinds, "corner"), seen, strict=True) if there
        )
        yield {"Your map": self._drawn(ground[seen], np.full((seen.sum(), 2, 2), np.nan), kinds)}
        measured = np.asarray(student.ground_to_measurement(ground[seen]), dtype=float)
        full = student.measurement_covariance(
            marks[seen], look.view, values.pixel_sigma, float(np.radians(values.sigma))
        )
        covariances = points_covariance(measured, full)
        yield {"Your map": self._drawn(ground[seen], covariances, kinds)}
        deviations = np.sqrt(np.maximum(np.diagonal(np.asarray(full, dtype=float))[1::2], 0.0))
        yield _table(look, ground, measured, deviations, seen)
        yield _words(seen, measured, deviations)

    def _drawn(
        self, points: FloatArray, covariances: FloatArray, kinds: tuple[LandmarkKind, ...]
    ) -> npt.NDArray[np.uint8]:
        """Draw the map with points in the robot frame."""
        c, s = np.cos(POSE.theta), np.sin(POSE.theta)
        turn = np.array([[c, -s], [s, c]])
        nowhere = np.full((3, 3), np.nan)  # the robot's own place is known: no ellipse
        estimate = Estimate(POSE, nowhere, POSE.to_parent(points), turn @ covariances @ turn.T, kinds)
        true = POSE.to_local(self._look.landmarks)
        return self._map.draw(MapContents({"truth": [POSE]}, estimate, observer="truth", points=true))


def mark_pixels(
    pixels: npt.NDArray[np.uint8], marks: npt.ArrayLike, radius: int = 6
) -> npt.NDArray[np.uint8]:
    """Return a copy of a picture (H, W, 3) with rings of a radius (px) around (u, v)."""
    shown = np.ascontiguousarray(pixels).copy()
    for u, v in as_points(marks, name="marks (u, v)"):
        for colour, thickness in (((255, 255, 255), radius // 2), (COLOUR, radius // 3)):
            cv2.circle(shown, (round(u), round(v)), radius, colour, thickness, cv2.LINE_AA)
    return shown


def _with_horizon(pixels: npt.NDArray[np.uint8], view: CameraView) -> npt.NDArray[np.uint8]:
    """Return a copy of a picture with the horizon dotted into it, where a camera of this view has it."""
    shown = np.ascontiguousarray(pixels).copy()
    bearing = view.yaw + np.linspace(-0.7, 0.7, 80)
    far = np.column_stack([1e6 * np.cos(bearing), 1e6 * np.sin(bearing), np.full(80, view.height)])
    horizon = view.project(far)
    for u, v in horizon[view.contains(horizon)]:
        cv2.circle(shown, (round(u), round(v)), 1, COLOUR, -1, cv2.LINE_AA)
    return shown


def _table(
    look: MarkedPicture,
    ground: FloatArray,
    measured: FloatArray,
    deviations: FloatArray,
    seen: npt.NDArray[np.bool_],
) -> Any:
    """Return range, sigma and error of each landmark below the horizon."""
    rows = []
    numbers = np.flatnonzero(seen)
    for number, (_, away), sigma in zip(numbers, measured, deviations, strict=True):
        if number < len(look.kinds):
            true = float(np.linalg.norm(look.landmarks[number] - POSE.as_array()[:2]))
            rows.append(
                (
                    f"{look.kinds[number]} at {true:.2f} m",
                    f"{away:.2f} m",
                    f"{sigma:.2f} m",
                    f"{away - true:+.2f} m",
                )
            )
    return table(("landmark", "range", "sigma", "error"), rows)


def _words(seen: npt.NDArray[np.bool_], measured: FloatArray, deviations: FloatArray) -> str:
    """Describe the selected pixel."""
    if not seen[-1]:
        return "The chosen pixel is at or above the horizon: it shows no point of the ground."
    bearing, away = measured[-1]
    degrees = round(abs(float(np.degrees(bearing))))
    side = f"{degrees} degrees to the {'left' if bearing > 0 else 'right'}" if degrees else "straight ahead"
    return f"The chosen pixel shows a point {away:.2f} m away (sigma {deviations[-1]:.2f} m), {side}."
