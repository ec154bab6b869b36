"""Predict and sample how errors of pixels and tilt affect measured ranges and an estimated pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.exercises.trying import made
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.experiments.scenes import CornerScene
from nao_course.metrics import REACH
from nao_course.plotting import STYLES, Drawing, Table, course_style, table
from nao_course.plotting.legends import legend_below
from nao_course.sim import NAO_V4, CameraView, Field

Function = Callable[..., Any]
HEAD_PITCH = float(np.radians(-24.6))  # as in the standard scenes
POSE = Pose(1.0, 0.2, -0.1)
TILT = float(np.radians(1.0))  # of the simulator's torso
SAMPLES = 200
_COLOURS = {"pixels": STYLES["ekf"].colour, "tilt": STYLES["odometry"].colour}
_AXES = ("x", "y", "heading")


@dataclass(frozen=True, eq=False)
class LandmarkScene:
    """A scene: a robot's pose, its view, and the landmarks in it.

    The pose (3,) is in m and rad, the landmarks (k, 2) are corners and posts in m, both in the field frame.
    """

    pose: FloatArray
    landmarks: FloatArray
    view: CameraView


@cache
def usual_scene() -> LandmarkScene:
    """Return a pose in front of the goal, with the corners and posts that the lower camera sees from there."""
    view = NAO_V4.view("bottom", 0.0, HEAD_PITCH, (320, 240))
    places = Field(2012).detectable_positions
    seen = view.contains(view.project(POSE.to_local(places)))
    return LandmarkScene(POSE.as_array(), places[seen], view)


def in_pixels(scene: LandmarkScene) -> FloatArray:
    """Return the landmarks' pixels, shape (k, 2)."""
    return scene.view.project(Pose.from_array(scene.pose).to_local(scene.landmarks))


def pixel_errors(find: Callable[[Any], Any], scenes: tuple[CornerScene, ...]) -> FloatArray:
    """Measure how far the corners that a detector finds are from the true ones.

    Parameters
    ----------
    find : callable
        ``find(picture)`` returns corners (K, 2).
    scenes : tuple of CornerScene
        With the true corners.

    Returns
    -------
    ndarray, shape (N, 2)
        (u, v) in pixels: the detected minus the true position of each hit.
    """
    errors = []
    for picture, corners in scenes:
        found = np.asarray(find(picture.copy()), dtype=float).reshape(-1, 2)
        for corner in corners:
            away = np.hypot(*(found - corner).T)
            if len(away) and away.min() <= REACH:
                errors.append(found[away.argmin()] - corner)
    return np.array(errors).reshape(-1, 2)


def sampled_poses(
    scene: LandmarkScene, pixel_sigma: float, tilt_sigma: float, weights: FloatArray
) -> FloatArray:
    """Return errors (SAMPLES, 3) of least-squares poses from noisy pictures: x, y (m), theta (rad), field frame.

    `pixel_sigma` is the standard deviation of each pixel in px, `tilt_sigma` of each picture's pitch in rad. The
    weights (2k, 2k) are the inverse of the covariance that the robot assumes for (bearing, range, ...) in all pictures.
    """
    from scipy.optimize import least_squares  # takes long to import

    rng, root = np.random.default_rng(7), np.linalg.cholesky(weights).T
    true = in_pixels(scene)
    errors = []
    for _ in range(SAMPLES):
        leaning = replace(scene.view, pitch=scene.view.pitch + rng.normal(0, tilt_sigma))
        pixels = leaning.project(Pose.from_array(scene.pose).to_local(scene.landmarks))
        pixels = pixels + rng.normal(0, pixel_sigma, true.shape)
        seen = _bearings_and_ranges(_ground(pixels, scene.view))

        def misses(pose: FloatArray, seen: FloatArray = seen) -> FloatArray:
            expected = _bearings_and_ranges(Pose.from_array(pose).to_local(scene.landmarks))
            off = seen - expected
            off[:, 0] = wrap_angle(off[:, 0])
            return np.asarray(root @ off.ravel())

        errors.append(least_squares(misses, scene.pose, method="lm").x - scene.pose)
    return np.array(errors)


def _ground(pixels: FloatArray, view: CameraView) -> FloatArray:
    """Return the ground points (k, 2) where the rays of pixels meet the floor, by a homography."""
    corners = np.array([(0.5, -0.5), (0.5, 0.5), (4.0, -1.0), (4.0, 1.0)])
    import cv2

    flat = view.undistort(view.project(corners))
    back = cv2.getPerspectiveTransform(flat.astype(np.float32), corners.astype(np.float32))
    found = cv2.perspectiveTransform(view.undistort(pixels)[None], back)
    return np.asarray(found[0], dtype=float)


def _bearings_and_ranges(points: FloatArray) -> FloatArray:
    polar = points @ (1, 1j)
    return np.stack((np.angle(polar), np.abs(polar)), axis=1)


@course_style()
def draw_range_budget(
    measurement_covariance: Function, pixel_sigma: float, tilt_sigma: float = TILT
) -> Drawing:
    """Draw the range error due to pixels, a tilt, and twice the tilt at each distance, by lesson 04's covariance."""
    pixel_sigma = made(pixel_sigma)
    view = usual_scene().view
    distances = np.linspace(0.8, 5.0, 43)
    pixels = view.project(np.array([(d + view.offset[0], 0.0) for d in distances]))
    parts = {
        "pixels": [_range_sigma(measurement_covariance, each, view, pixel_sigma, 0.0) for each in pixels],
        "tilt": [_range_sigma(measurement_covariance, each, view, 0.0, tilt_sigma) for each in pixels],
    }
    words = []
    figure = Figure(figsize=(7.6, 3.6))
    ax = figure.add_subplot()
    for name, sigmas in parts.items():
        ax.plot(
            distances, sigmas, color=_COLOURS[name], lw=2.4, label=_say_source(name, pixel_sigma, tilt_sigma)
        )
        at = [float(np.interp(d, distances, sigmas)) for d in (1.0, 2.0, 4.0)]
        words.append(f"{name}: {at[0]:.2f} m at 1 m, {at[1]:.2f} m at 2 m, {at[2]:.2f} m at 4 m")
    twice = _say_source("tilt", pixel_sigma, 2 * tilt_sigma)
    ax.plot(distances, 2 * np.array(parts["tilt"]), "--", color=_COLOURS["tilt"], label=twice)
    ax.axhspan(0.1, 0.3, color="#e3e5e8", lw=0, zorder=0, label="10 - 30 cm, as in the paper")
    ax.set(xlabel="distance over the ground (m)", ylabel="sigma of the range (m)", ylim=(0, None))
    legend_below(figure, ax.get_legend_handles_labels()[0])
    return Drawing(
        figure,
        f"Standard deviation of a range due to each source. {'; '.join(words)}; {twice}: twice as much.",
    )


def _range_sigma(covariance: Function, pixel: FloatArray, view: CameraView, *sigmas: float) -> float:
    return float(np.sqrt(np.asarray(covariance(pixel[None], view, *sigmas))[1, 1]))


def _say_source(name: str, pixel_sigma: float, tilt_sigma: float) -> str:
    return {"pixels": f"pixels, {pixel_sigma:.1f} px", "tilt": f"tilt, {np.degrees(tilt_sigma):.1f} degrees"}[
        name
    ]


@dataclass(frozen=True, eq=False)
class Budget:
    """Standard deviations of x, y (m) and theta (rad) for each source of error.

    Parameters
    ----------
    predicted : dict of str to ndarray, shape (3,)
        By "pixels", "tilt" and "both".
    measured : dict of str to ndarray, shape (3,)
        The same, of sampled pictures.
    """

    predicted: dict[str, FloatArray]
    measured: dict[str, FloatArray]


def measure_budget(
    error_budget: Function, measurement_covariance: Function, pixel_sigma: float, tilt_sigma: float = TILT
) -> Budget:
    """Compute the budget of the usual scene with a student's function, and sample the same errors."""
    pixel_sigma = made(pixel_sigma)
    scene = usual_scene()
    given = (scene.pose.copy(), scene.landmarks.copy(), scene.view)
    parts = [np.asarray(each, dtype=float) for each in error_budget(*given, pixel_sigma, tilt_sigma)]
    predicted = dict(zip(("pixels", "tilt"), map(_sigmas, parts), strict=True)) | {
        "both": _sigmas(sum(parts))
    }
    weights = np.linalg.inv(measurement_covariance(in_pixels(scene), scene.view, pixel_sigma, tilt_sigma))
    sources = {"pixels": (pixel_sigma, 0.0), "tilt": (0.0, tilt_sigma), "both": (pixel_sigma, tilt_sigma)}
    measured = {name: sampled_poses(scene, *each, weights).std(axis=0) for name, each in sources.items()}
    return Budget(predicted, measured)


def tilt_left(
    measurement_covariance: Function, pixel_sigma: float, tilt_sigma: float = TILT
) -> dict[str, FloatArray]:
    """Measure the pose error due to a tilt, for weights that include the tilt fully, partly or not at all.

    Return standard deviations (3,) of x, y (m) and theta (rad), from sampled pictures whose pixels are exact.
    """
    scene = usual_scene()
    pixels = in_pixels(scene)
    exact, leaning = (
        np.asarray(measurement_covariance(pixels, scene.view, pixel_sigma, tilt))
        for tilt in (0.0, tilt_sigma)
    )
    own_blocks = np.kron(np.eye(len(pixels)), np.ones((2, 2))) > 0
    known = {
        "none": exact,
        "an independent tilt for each landmark": np.where(own_blocks, leaning, 0.0),
        "one tilt for all landmarks": leaning,
    }
    return {
        name: sampled_poses(scene, 0.0, tilt_sigma, np.linalg.inv(covariance)).std(axis=0)
        for name, covariance in known.items()
    }


def tell_tilt_left(measurement_covariance: Function, pixel_sigma: float) -> Table:
    """Make a table of the pose error due to one degree of tilt, for weights that include the tilt or do not."""
    found = tilt_left(measurement_covariance, made(pixel_sigma))
    rows = [
        (name, f"{100 * x:.1f} cm", f"{100 * y:.1f} cm", f"{np.degrees(theta):.1f}°")
        for name, (x, y, theta) in found.items()
    ]
    return table(("tilt in the weights", "x", "y", "heading"), rows)


def _sigmas(covariance: Any) -> FloatArray:
    return np.sqrt(np.diag(covariance))


def larger_source(budget: Budget) -> str:
    """Return the source with the larger predicted error in x: "pixels" or "tilt"."""
    predicted = made(budget).predicted
    return max(("pixels", "tilt"), key=lambda name: float(predicted[name][0]))


@course_style()
def draw_budget(budget: Budget) -> Drawing:
    """Draw the error of x, y and heading due to each source: bars are predicted, diamonds are sampled."""
    budget = made(budget)
    words = []
    figure = Figure(figsize=(9.0, 3.7))
    place, heading = figure.subplots(1, 2, width_ratios=(2, 1))
    for row, (name, colour) in enumerate({**_COLOURS, "both": STYLES["truth"].colour}.items()):
        scale = np.array([100.0, 100.0, np.degrees(1.0)])
        wanted, have = budget.predicted[name] * scale, budget.measured[name] * scale
        for i, (value, dot) in enumerate(zip(wanted, have, strict=True)):
            ax = place if i < 2 else heading
            at = (i if i < 2 else 0) + (row - 1) * 0.26
            ax.bar(at, value, 0.24, color=colour, alpha=0.75, label=name if i == 0 else None)
            ax.plot(at, dot, "D", color="white", mec="black", ms=7)
        said = zip(_AXES, wanted, have, ("cm", "cm", "degrees"), strict=True)
        words.append(f"{name}: " + ", ".join(f"{axis} {a:.1f} {unit} ({b:.1f})" for axis, a, b, unit in said))
    place.set_xticks([0, 1], ["x", "y"])
    place.set(ylabel="sigma (cm)")
    heading.set_xticks([0], ["heading"])
    heading.set(ylabel="sigma (degrees)", xlim=(-0.6, 0.6))
    keys = [*place.get_legend_handles_labels()[0]]
    measured = place.plot(
        [], [], "D", color="white", mec="black", ms=7, label=f"measured, {SAMPLES} pictures"
    )
    legend_below(figure, [*keys, *measured])
    return Drawing(
        figure, f"Error of the pose by its source, predicted and, in brackets, measured. {'; '.join(words)}."
    )
