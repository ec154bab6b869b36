"""Figures of lesson 04 on noise: what a tilt and a pixel do to a range, and to all landmarks of one picture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path as PathOf

from nao_course.geometry import FloatArray
from nao_course.lessons.distance.looks import Function, ahead, measure_pixels, tilted_measurements, usual_view
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import STYLES, course_style

PAPER, EXACT, TRUTH = STYLES["odometry"].colour, STYLES["ekf"].colour, STYLES["truth"].colour
SAYS = (0.10, 0.30)  # m: Aliyev et al. 2014, section 10, of two degrees
SIZES = ((320, 240), (640, 480), (1280, 960))


@course_style()
def draw_tilt_band(
    pixel_to_ground: Function, ground_to_measurement: Function, degrees: float = 2.0, samples: int = 600
) -> Drawing:
    """Draw the error of a distance if the camera's angle is off by up to `degrees`, with the paper's claim.

    Parameters
    ----------
    pixel_to_ground, ground_to_measurement : callable
        The student's.
    degrees : float
        The angles are evenly spaced from minus to plus this.
    samples : int
        How many.

    Returns
    -------
    Drawing
        The figure; its text has the median absolute error by distance.
    """
    away, errors = tilt_errors(pixel_to_ground, ground_to_measurement, degrees, samples)
    low, middle, high = np.nanquantile(errors, [0.05, 0.5, 0.95], axis=0)
    figure = Figure(figsize=(7.8, 4.5))
    ax = figure.add_subplot()
    ax.axhspan(*SAYS, color=PAPER, alpha=0.25, lw=0)
    ax.axhspan(-SAYS[1], -SAYS[0], color=PAPER, alpha=0.25, lw=0)
    ax.fill_between(away, low, high, color=EXACT, alpha=0.25, lw=0)
    ax.plot(away, middle, color=EXACT, lw=2)
    sizes = np.nanmedian(np.abs(errors), axis=0)
    ax.plot(away, sizes, color=STYLES["odometry"].colour, lw=2, ls="--")
    ax.axhline(0, color=TRUTH, lw=0.8)
    ax.set(
        xlabel="true distance (m)", ylabel="error of the distance (m)", xlim=(away[0], away[-1]), ylim=(-2, 3)
    )
    ax.grid(color="#e3e5e8")
    keys = [
        Patch(facecolor=EXACT, alpha=0.25, label=f"90 % of pictures, ±{degrees:g}°"),
        Line2D([], [], color=EXACT, lw=2, label="median error"),
        Line2D([], [], color=STYLES["odometry"].colour, lw=2, ls="--", label="median absolute error"),
        Patch(facecolor=PAPER, alpha=0.25, label="the paper: 10 to 30 cm"),
    ]
    legend_below(figure, keys, columns=2)
    said = ", ".join(f"{typical_error(away, errors, at):.2f} m at {at} m" for at in range(1, 6))
    return Drawing(
        figure, f"Distances with a tilt of up to {degrees:g} degrees. Median absolute error: {said}."
    )


def tilt_errors(
    pixel_to_ground: Function, ground_to_measurement: Function, degrees: float = 2.0, samples: int = 600
) -> tuple[FloatArray, FloatArray]:
    """Compute errors of the distance, measured minus true, for evenly spaced errors of the camera's angle.

    Returns
    -------
    distances : ndarray, shape (K,)
        True distances from the point below the camera, in m.
    errors : ndarray, shape (samples, K)
        Errors in m; NaN for points above the assumed horizon.
    """
    view = replace(usual_view(), offset=(0.0, 0.0))
    away = np.arange(0.75, 5.01, 0.25)
    tilts = np.radians(degrees) * np.linspace(-1, 1, samples)
    measured = tilted_measurements(pixel_to_ground, ground_to_measurement, view, ahead(away, view), tilts)
    return away, measured[..., 1] - away


def typical_error(away: FloatArray, errors: FloatArray, at: float) -> float:
    """Return the median absolute error in m at the distance in `away` that is nearest to `at`."""
    column = errors[:, int(np.argmin(np.abs(away - at)))]
    return float(np.nanmedian(np.abs(column)))


@course_style()
def draw_asymmetry(
    pixel_to_ground: Function,
    ground_to_measurement: Function,
    range_sigma: Function,
    tilt_sigma: float,
    distances: Sequence[float] = (1.0, 2.0, 4.0),
) -> Drawing:
    """Draw histograms of sampled ranges beside the normal distribution that `range_sigma` promises.

    Parameters
    ----------
    pixel_to_ground, ground_to_measurement, range_sigma : callable
        The student's.
    tilt_sigma : float
        Of the camera's angle, rad.
    distances : sequence of float
        From below the camera, m.

    Returns
    -------
    Drawing
        The figure; its text has sampled and computed deviations.
    """
    view = replace(usual_view(), offset=(0.0, 0.0))
    tilts = tilt_sigma * np.random.default_rng(5).standard_normal(2000)
    measured = tilted_measurements(
        pixel_to_ground, ground_to_measurement, view, ahead(distances, view), tilts
    )[..., 1]
    said = []
    figure = Figure(figsize=(9.9, 3.5))
    for ax, away, ranges in zip(figure.subplots(1, len(distances)), distances, measured.T, strict=True):
        sigma = float(range_sigma(away, view.height, tilt_sigma))
        shown = (away - 4 * sigma, away + 5.5 * sigma)
        ax.hist(ranges, bins=np.linspace(*shown, 40), density=True, color=EXACT, alpha=0.45)
        x = np.linspace(*shown, 200)
        ax.plot(x, np.exp(-(((x - away) / sigma) ** 2) / 2) / sigma / np.sqrt(2 * np.pi), color=TRUTH, lw=2)
        ax.axvline(float(np.nanmean(ranges)), color=PAPER, ls="--", lw=1.6)
        ax.set(xlabel="measured distance (m)", yticks=[], xlim=shown)
        ax.spines["left"].set_visible(False)
        ax.set_title(f"{away:g} m away: σ = {sigma:.2f} m", fontsize=11)
        below, above = np.nanquantile(ranges, [0.025, 0.975])
        said.append(
            f"at {away:g} m computed {sigma:.3f} m, sampled {np.nanstd(ranges):.3f} m, 95 % from "
            f"{below - away:+.2f} to {above - away:+.2f} m, mean {np.nanmean(ranges) - away:+.3f} m"
        )
    keys = [
        Patch(facecolor=EXACT, alpha=0.45, label="2000 pictures"),
        Line2D([], [], color=TRUTH, lw=2, label="normal distribution with your σ"),
        Line2D([], [], color=PAPER, ls="--", lw=1.6, label="mean of the pictures"),
    ]
    legend_below(figure, keys)
    return Drawing(
        figure, f"Standard deviations with {np.degrees(tilt_sigma):.2g} degrees of tilt: {'; '.join(said)}."
    )


@course_style()
def draw_pixel_worth(
    pixel_to_ground: Function, ground_to_measurement: Function, range_sigma: Function
) -> Drawing:
    """Draw what one pixel is worth by distance, at three resolutions, beside one degree of tilt.

    Parameters
    ----------
    pixel_to_ground, ground_to_measurement, range_sigma : callable
        The student's.

    Returns
    -------
    Drawing
        The figure; its text has the values at 3 m.
    """
    away = np.linspace(0.75, 6.0, 80)
    said = []
    figure = Figure(figsize=(7.8, 4.5))
    ax = figure.add_subplot()
    view = replace(usual_view(), offset=(0.0, 0.0))
    tilt = np.array([float(range_sigma(float(r), view.height, float(np.radians(1.0)))) for r in away])
    ax.plot(away, 100 * tilt, color=PAPER, lw=2.4, label="one degree of tilt")
    for size, line in zip(SIZES, ("-", "--", ":"), strict=True):
        worth = pixel_worth(pixel_to_ground, ground_to_measurement, away, size)
        ax.plot(away, 100 * worth, color=EXACT, lw=2, ls=line, label=f"one pixel of {size[0]} x {size[1]}")
        said.append(f"one pixel of {size[0]} x {size[1]} {100 * float(np.interp(3.0, away, worth)):.1f} cm")
    ax.set(
        xlabel="distance (m)", ylabel="change of the distance (cm)", yscale="log", xlim=(away[0], away[-1])
    )
    ax.set_yticks([0.3, 1, 3, 10, 30, 100])
    ax.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
    ax.grid(color="#e3e5e8")
    legend_below(figure, ax.get_lines(), columns=2)
    return Drawing(
        figure,
        f"At 3 m: {', '.join(said)}, one degree of tilt {100 * float(np.interp(3.0, away, tilt)):.0f} cm.",
    )


def pixel_worth(
    pixel_to_ground: Function, ground_to_measurement: Function, away: npt.ArrayLike, size: tuple[int, int]
) -> FloatArray:
    """Return the change of the distance in m per pixel, straight ahead at distances `away` (N,) in m."""
    view = replace(usual_view(size), offset=(0.0, 0.0))
    pixels = view.project(ahead(away, view))
    high, low = (
        measure_pixels(pixel_to_ground, ground_to_measurement, pixels + (0.0, half), view)[:, 1]
        for half in (-0.5, 0.5)
    )
    return high - low


@course_style()
def draw_shared_tilt(
    pixel_to_ground: Function,
    ground_to_measurement: Function,
    measurement_covariance: Function,
    pixel_sigma: float,
    tilt_sigma: float,
    pictures: int = 40,
) -> Drawing:
    """Draw the errors of two ranges in many pictures, and the correlation of all measurements of a picture.

    Parameters
    ----------
    pixel_to_ground, ground_to_measurement, measurement_covariance : callable
        The student's.
    pixel_sigma, tilt_sigma : float
        Of a mark, px, and of the camera's angle, rad.
    pictures : int
        How many.

    Returns
    -------
    Drawing
        The figure; its text has the correlation of the ranges.
    """
    places, tilts, measured = _in_pictures(
        pixel_to_ground, ground_to_measurement, pixel_sigma, tilt_sigma, pictures
    )
    missed = measured[..., 1] - np.linalg.norm(places, axis=1)
    view = usual_view()
    full = np.asarray(measurement_covariance(view.project(places), view, pixel_sigma, tilt_sigma))
    deviations = np.sqrt(np.diag(full))
    correlation = full / np.outer(deviations, deviations)
    figure = Figure(figsize=(9.9, 4.5))
    left, right = figure.subplots(1, 2, width_ratios=[1.25, 1])
    left.axhline(0, color=TRUTH, lw=0.8)
    left.axvline(0, color=TRUTH, lw=0.8)
    for low, colour in ((True, PAPER), (False, EXACT)):
        chosen = missed[(tilts > 0) == low]
        left.plot(100 * chosen[:, 0], 100 * chosen[:, 2], "o", color=colour, ms=6, mec="white", mew=0.6)
    left.set(xlabel="error of the range at 1 m (cm)", ylabel="error of the range at 3 m (cm)")
    left.grid(color="#e3e5e8")
    names = [f"{kind} {number}" for number in (1, 2, 3) for kind in ("bearing", "range")]
    _plot_correlation(right, correlation, names)
    keys = [
        Line2D([], [], color=PAPER, marker="o", ls="", label="the camera looks lower than assumed"),
        Line2D([], [], color=EXACT, marker="o", ls="", label="the camera looks higher than assumed"),
    ]
    legend_below(figure, keys)
    ranges = ", ".join(f"{correlation[2 * i + 1, 2 * j + 1]:.2f}" for i, j in ((0, 1), (0, 2), (1, 2)))
    words = (
        f"Errors of two ranges in {pictures} pictures: in each picture both are too short, or both too long. "
        f"Correlation of their ranges by the student's covariance, 1-2, 1-3 and 2-3: {ranges}."
    )
    return Drawing(figure, words)


@course_style()
def draw_landmark_clouds(
    pixel_to_ground: Function,
    ground_to_measurement: Function,
    measurement_covariance: Function,
    landmark_ellipse: Function,
    pixel_sigma: float,
    tilt_sigma: float,
    pictures: int = 400,
) -> Drawing:
    """Draw the points of three landmarks in many pictures, and the ellipses that follow from the covariance of one.

    Parameters
    ----------
    pixel_to_ground, ground_to_measurement, measurement_covariance : callable
        The student's.
    landmark_ellipse : callable
        Returns the outline (M, 2), m, robot frame, from (bearing, range) and their covariance (2, 2).
    pixel_sigma, tilt_sigma : float
        Standard deviations of a mark, px, and of the camera's angle, rad.
    pictures : int
        Number of pictures.

    Returns
    -------
    Drawing
        The figure; its text has the share of the points in each ellipse.
    """
    places, _, measured = _in_pictures(
        pixel_to_ground, ground_to_measurement, pixel_sigma, tilt_sigma, pictures
    )
    view = usual_view()
    points = measured[..., 1:] * np.stack([np.cos(measured[..., 0]), np.sin(measured[..., 0])], axis=-1)
    true = np.column_stack([np.arctan2(places[:, 1], places[:, 0]), np.linalg.norm(places, axis=1)])
    full = np.asarray(measurement_covariance(view.project(places), view, pixel_sigma, tilt_sigma))
    figure = Figure(figsize=(9.6, 3.9))
    shares = []
    for i, (ax, (bearing, away)) in enumerate(zip(figure.subplots(1, 3), true, strict=True)):
        outline = np.asarray(landmark_ellipse(bearing, away, full[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]))
        shares.append(float(np.mean(PathOf(outline).contains_points(points[:, i]))))
        way = np.array([np.cos(bearing), np.sin(bearing)])
        axes = 100 * np.column_stack([way, [-way[1], way[0]]])
        ax.plot(*((points[:, i] - places[i]) @ axes).T, ".", color="#888888", ms=4, zorder=1)
        ax.plot(*((outline - places[i]) @ axes).T, color=EXACT, lw=1.8, zorder=3)
        ax.plot(0, 0, "o", mfc="none", mec=TRUTH, ms=9, mew=1.4, zorder=4)
        ax.set_title(f"{away:.0f} m away: {shares[-1]:.0%} inside", fontsize=11)
        ax.set(xlabel="along the line of sight (cm)", ylabel="" if i else "across it (cm)")
        ax.grid(color="#e3e5e8")
    keys = [
        Line2D([], [], color="#888888", marker=".", ls="", label=f"points of {pictures} pictures"),
        Line2D([], [], color=EXACT, lw=1.8, label="your 95 % ellipse"),
        Line2D([], [], mec=TRUTH, mfc="none", marker="o", ls="", ms=9, label="true landmark"),
    ]
    legend_below(figure, keys)
    said = ", ".join(f"{share:.0%}" for share in shares)
    return Drawing(
        figure,
        f"Points of three landmarks, 1, 2 and 3 m from the robot, in {pictures} pictures: three clouds that are "
        f"much longer along the line of sight than across it. Share of the points in each ellipse: {said}.",
    )


def three_landmarks() -> FloatArray:
    """Return points (3, 2) in the robot frame at 1, 2 and 3 m, to the left and to the right."""
    bearing = np.radians([24.0, -23.0, 9.0])
    return np.array([1.0, 2.0, 3.0])[:, None] * np.column_stack([np.cos(bearing), np.sin(bearing)])


def _in_pictures(
    to_ground: Function, to_measurement: Function, pixel_sigma: float, tilt_sigma: float, pictures: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the three landmarks, the tilt of each picture, and their measurements in it (pictures, 3, 2)."""
    places, rng = three_landmarks(), np.random.default_rng(6)
    tilts = tilt_sigma * rng.standard_normal(pictures)
    errors = pixel_sigma * rng.standard_normal((pictures, len(places), 2))
    return places, tilts, tilted_measurements(to_ground, to_measurement, usual_view(), places, tilts, errors)


def _plot_correlation(ax: Axes, matrix: FloatArray, names: Sequence[str]) -> None:
    ax.imshow(matrix, cmap="RdBu_r", vmin=-1, vmax=1)
    for i, row in enumerate(matrix):
        for j, value in enumerate(row):
            shown, colour = f"{value:.2f}".replace("-0.00", "0.00"), "white" if abs(value) > 0.6 else TRUTH
            ax.text(j, i, shown, ha="center", va="center", fontsize=9, color=colour)
    ax.set(xticks=range(len(names)), yticks=range(len(names)))
    ax.set_xticklabels(names, rotation=40, ha="right", fontsize=9)
    ax.set_yticklabels(names, fontsize=9)
    ax.spines[["left", "bottom"]].set_visible(False)
    ax.tick_params(length=0)
    ax.set_title("correlation of their errors", fontsize=11)
