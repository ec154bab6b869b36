"""The camera's tilt from the field's own lines: on the ground they are parallel or perpendicular to each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.sim import CameraView

# Frozen; chosen on the simulator's sets "tune" and "whole_tune" only.
# The prior: what a robot knows of its lean before it looks (docs/real_data.md, corrections of each picture).
PITCH_SD, ROLL_SD = float(np.radians(1.3)), float(np.radians(0.8))
END_SD = 0.25  # px at 320: of a middle line's end, across the line
ANGLE_SD = float(np.radians(0.3))  # of a line's direction besides: lens, lines that were laid by hand
OUTLIER = 2.0  # standard deviations beyond which a line pulls no harder: it is none of the field's
GRID = np.linspace(-2.6, 2.6, 9)  # standard deviations of the prior at which the search begins
CANDIDATES = 12  # lines whose direction is tried as the field's
STEPS, STEP = 8, float(np.radians(0.05))  # of the refinement; of its numerical derivatives, rad
LARGEST_STEP = float(np.radians(3.0))
QUARTER = np.pi / 2
MOST_LINES = 24  # the best known


@dataclass(frozen=True, eq=False)
class Alignment:
    """How lines lie on the ground once the camera is leant so that they are parallel or perpendicular.

    Parameters
    ----------
    pitch, roll : float
        The camera's, rad.
    heading : float
        Direction of the lines, rad from straight ahead of the camera, to the left; known modulo 90 degrees.
    covariance : ndarray, shape (3, 3)
        Of pitch, roll and heading, rad^2.
    aside : ndarray, shape (N,)
        What each line's direction differs from the nearest of the two, rad, signed.
    angle_sd : ndarray, shape (N,)
        How well each line's direction is known, rad.
    """

    pitch: float
    roll: float
    heading: float
    covariance: FloatArray
    aside: FloatArray
    angle_sd: FloatArray

    @property
    def sigma(self) -> float:
        """Standard deviation of the pitch, rad."""
        return float(np.sqrt(self.covariance[0, 0]))


def tilt_from_lines(segments: npt.ArrayLike, view: CameraView) -> tuple[float, float, float]:
    """Estimate the tilt of a camera from centre lines of the field's lines.

    Before it looks, the robot knows its lean by 1.3 degrees in pitch and 0.8 degrees in roll (standard deviations):
    where lines cannot tell, the answer is the view's own tilt and that uncertainty.

    Parameters
    ----------
    segments : array_like, shape (N, 4)
        (u1, v1, u2, v2), px to a fraction of one, without the lens: see `CameraView.undistort`.
    view : CameraView
        What the robot believes.

    Returns
    -------
    pitch, roll : float
        The camera's, rad: `replace(view, pitch=pitch, roll=roll)` is the better view.
    sigma : float
        Standard deviation of the pitch, rad.

    Raises
    ------
    ValueError
        If segments have another shape or are not finite.
    """
    found = align(segments, view)
    return found.pitch, found.roll, found.sigma


def align(
    segments: npt.ArrayLike, view: CameraView, pitch_sd: float = PITCH_SD, roll_sd: float = ROLL_SD
) -> Alignment:
    """Estimate the tilt at which lines on the ground are perpendicular or parallel; see `tilt_from_lines`.

    `pitch_sd` and `roll_sd` (rad) are how well the view's own are known before.
    """
    prior = np.array([pitch_sd, roll_sd])
    lines = _as_segments(segments)
    sd = _angle_sd(lines, view)
    known = np.flatnonzero(np.isfinite(sd))
    use = known[np.argsort(sd[known], kind="stable")[:MOST_LINES]]
    best = _modes(lines[use], sd[use], view, prior) if len(use) else None
    if best is None:
        state, covariance = np.zeros(3), np.diag([*prior**2, QUARTER**2 / 12])
    else:
        state, covariance = best
    with np.errstate(invalid="ignore"):
        aside = _wrapped(_directions(lines, view, state[0], state[1]) - state[2])
    return Alignment(
        view.pitch + float(state[0]), view.roll + float(state[1]), float(state[2]), covariance, aside, sd
    )


def to_ground(
    pixels: FloatArray, view: CameraView, pitch: npt.ArrayLike = 0.0, roll: npt.ArrayLike = 0.0
) -> FloatArray:
    """Return the points on the ground below a camera that is tilted by `pitch` and `roll` from its assumed view.

    Parameters
    ----------
    pixels : ndarray, shape (N, 2)
        Without the lens.
    view : CameraView
        What the robot believes.
    pitch, roll : array_like, shape (...)
        Rad.

    Returns
    -------
    ndarray, shape (..., N, 2)
        Metres ahead of and to the left of the point below the camera, along its own axis; NaN at and above the horizon.
    """
    x, y = ((pixels - view.centre) / view.focal).T
    p, r = view.pitch + np.asarray(pitch)[..., None], view.roll + np.asarray(roll)[..., None]
    left, down = -x * np.cos(r) + y * np.sin(r), x * np.sin(r) + y * np.cos(r)
    ahead, below = np.cos(p) - down * np.sin(p), down * np.cos(p) + np.sin(p)
    reach = view.height / np.where(below > 1e-3, below, np.nan)
    return np.stack([ahead * reach, left * reach], axis=-1)


def _as_segments(segments: npt.ArrayLike) -> FloatArray:
    """Return segments (N, 4) after checking them."""
    lines = np.asarray(segments, dtype=float)
    if lines.size == 0:
        return np.zeros((0, 4))
    if lines.ndim != 2 or lines.shape[1] != 4 or not np.isfinite(lines).all():
        raise ValueError(
            f"segments must be finite numbers (N, 4): u1, v1, u2, v2 in px, got shape {lines.shape}"
        )
    return lines


def _directions(lines: FloatArray, view: CameraView, pitch: npt.ArrayLike, roll: npt.ArrayLike) -> FloatArray:
    """Directions (..., N) of lines (N, 4) on the ground, rad."""
    ground = to_ground(lines.reshape(-1, 2), view, pitch, roll)
    way = ground[..., 1::2, :] - ground[..., ::2, :]
    return np.asarray(np.arctan2(way[..., 1], way[..., 0]))


def _wrapped(angle: FloatArray) -> FloatArray:
    """An angle modulo 90 degrees, in [-45, 45) degrees."""
    return np.asarray((angle + QUARTER / 2) % QUARTER - QUARTER / 2)


def _angle_sd(lines: FloatArray, view: CameraView) -> FloatArray:
    """How well the directions (N,) of lines are known, rad; NaN for what is no line on the ground."""
    if not len(lines):
        return np.zeros(0)
    way = lines[:, 2:] - lines[:, :2]
    length = np.maximum(np.hypot(*way.T), 1e-9)[:, None]
    aside = END_SD * view.size[0] / 320 * np.column_stack([-way[:, 1], way[:, 0]]) / length
    straight, variance = _directions(lines, view, 0.0, 0.0), np.full(len(lines), ANGLE_SD**2)
    for moved in (np.hstack([aside, 0 * aside]), np.hstack([0 * aside, aside])):
        change = _directions(lines + moved, view, 0.0, 0.0) - straight
        variance = variance + ((change + np.pi / 2) % np.pi - np.pi / 2) ** 2
    sd = np.sqrt(variance)
    return np.where((length[:, 0] > 1) & (sd < np.radians(20)), sd, np.nan)


def _loss(away: FloatArray) -> FloatArray:
    """Return the robust cost (...) of lines that are off by `away` (..., N) standard deviations."""
    square = np.where(np.isnan(away), OUTLIER, away) ** 2
    return np.asarray(OUTLIER**2 * np.log1p(square / OUTLIER**2).sum(axis=-1))


def _modes(
    lines: FloatArray, sd: FloatArray, view: CameraView, prior: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Return the mean (3,) and covariance (3, 3) of pitch, roll and heading over the best local minima."""
    start = _starts(lines, sd, view, prior)
    if not len(start):
        return None
    states, covariances, costs = _refined(lines, sd, view, start, prior)
    weight = np.exp(-(costs - costs.min()) / 2)
    weight /= weight.sum()
    best = states[costs.argmin()]
    states[:, 2] = best[2] + _wrapped(states[:, 2] - best[2])
    mean = weight @ states
    away = states - mean
    covariance = np.einsum("k,kij->ij", weight, covariances + away[:, :, None] * away[:, None])
    return mean, np.asarray(covariance)


def _starts(
    lines: FloatArray, sd: FloatArray, view: CameraView, prior: FloatArray, most: int = 3
) -> FloatArray:
    """Return the states (K, 3) of a grid with the lowest costs, none near a better one."""
    pitch, roll = (each.ravel() for each in np.meshgrid(*(GRID * each for each in prior), indexing="ij"))
    direction = _directions(lines, view, pitch, roll)  # (grid, N)
    heading = direction[:, :CANDIDATES]
    away = _wrapped(direction[:, None] - heading[..., None]) / sd  # (grid, candidates, N)
    cost = _loss(away) + ((pitch / prior[0]) ** 2 + (roll / prior[1]) ** 2)[:, None]
    states = np.stack(np.broadcast_arrays(pitch[:, None], roll[:, None], heading), axis=-1).reshape(-1, 3)
    cost = np.where(np.isnan(heading), np.inf, cost).ravel()
    near = np.array([*1.2 * prior, np.radians(8.0)])
    kept: list[FloatArray] = []
    while len(kept) < most and np.isfinite(cost.min()):
        kept.append(states[cost.argmin()])
        away = np.abs(states - kept[-1])
        away[:, 2] = np.abs(_wrapped(away[:, 2]))
        cost = np.where((away <= near).all(axis=1), np.inf, cost)
    return np.array(kept).reshape(-1, 3)


def _refined(
    lines: FloatArray, sd: FloatArray, view: CameraView, states: FloatArray, prior: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Refine states by robust Gauss-Newton; return states (K, 3), covariances (K, 3, 3) and costs (K,)."""
    held = np.diag([*prior**-2.0, 1e-6])
    moves = STEP * np.array([(0, 0), (1, 0), (-1, 0), (0, 1), (0, -1)])
    for _ in range(STEPS):
        moved = states[:, None, :2] + moves  # (K, 5, 2)
        angle = _directions(lines, view, moved[..., 0], moved[..., 1])  # (K, 5, N)
        away = _wrapped(angle[:, 0] - states[:, 2:])
        slope = _wrapped(angle[:, (1, 3)] - angle[:, (2, 4)]) / (2 * STEP)
        jacobian = np.concatenate([slope, np.full((len(states), 1, len(lines)), -1.0)], axis=1)  # (K, 3, N)
        fine = np.isfinite(jacobian).all(axis=1) & np.isfinite(away)
        jacobian, away = np.where(fine[:, None], jacobian, 0.0), np.where(fine, away, 0.0)
        robust = fine / (1 + (away / sd / OUTLIER) ** 2)
        weight = robust / sd**2
        freedom = np.maximum(robust.sum(axis=1) - 1, 1.0)
        spread = np.maximum(1.0, (weight * away**2).sum(axis=1) / freedom)[:, None]
        weighted = jacobian * (weight / spread)[:, None]
        information = weighted @ jacobian.transpose(0, 2, 1) + held
        gradient = (weighted @ away[..., None])[..., 0] + states @ held * (1, 1, 0)
        change = np.linalg.solve(information, gradient[..., None])[..., 0]
        states = states - np.clip(change, -LARGEST_STEP, LARGEST_STEP)
        if np.abs(change).max() < 1e-5:
            break
    final = _wrapped(_directions(lines, view, states[:, 0], states[:, 1]) - states[:, 2:]) / sd
    cost = _loss(final) + ((states[:, :2] / prior) ** 2).sum(axis=1)
    return states, np.linalg.inv(information), cost
