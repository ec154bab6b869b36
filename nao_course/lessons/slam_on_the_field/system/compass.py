"""How the body leans and where it is heading, from the field's lines: they are parallel or at right angles."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.lessons.slam_on_the_field.system.lines import to_ground
from nao_course.lessons.slam_on_the_field.system.observation import TILT_SIGMAS, leaning
from nao_course.sim import CameraView

QUARTER = np.pi / 2
COMPASS_SIGMA = float(np.radians(3))  # a direction less known than this is no compass
END_SIGMA = 0.25  # px at 320: of a middle line's end, across it
DIRECTION_SIGMA = float(np.radians(0.3))  # of a line's direction besides: lens, lines laid by hand
# A line that is shorter tells nothing: more than half are pieces of the circle, or upright things. px at 320, and m.
LEAST_PIXELS, LEAST_LENGTH = 14.0, 0.3
LENGTHS, DOUBTS = (
    (0.45, 0.7),
    (0.2, 0.04, 0.01),
)  # m: how likely a longer one is none of the field's straight ones
GRID = np.linspace(-2.6, 2.6, 9)  # standard deviations of the lean at which the search begins
MOST_LINES, MOST_STARTS = 24, 12  # the best known; those whose direction is tried as the field's
MODES, STEPS = 3, 8  # places that are refined, and in how many steps
LARGEST_STEP = float(np.radians(3.0))
AGREES, DISAGREES = float(np.radians(4)), float(np.radians(6))  # from a line to the direction, on the ground
LEAST_SUPPORT = 0.5  # m of lines: a piece of the centre circle is shorter
FARTHEST_END = 6.0  # m: of a line that ends farther away the length is not known


@dataclass(frozen=True, eq=False)
class Lean:
    """What lines tell of a body.

    Parameters
    ----------
    pitch, roll : float
        How it leans, to the front and to the right, rad.
    direction : float
        Of the lines, rad from straight ahead to the left, modulo 90 degrees.
    covariance : ndarray, shape (3, 3)
        Of pitch, roll and direction, rad^2.
    """

    pitch: float
    roll: float
    direction: float
    covariance: FloatArray

    @property
    def direction_sigma(self) -> float:
        """How well the direction is known, rad; infinite where that is too little for a compass."""
        sigma = float(np.sqrt(self.covariance[2, 2]))
        return sigma if sigma <= COMPASS_SIGMA else float("inf")


def wrap_quarter(angle: npt.ArrayLike) -> FloatArray:
    """Bring angles modulo 90 degrees into [-45, 45) degrees; rad."""
    return np.asarray((np.asarray(angle) + QUARTER / 2) % QUARTER - QUARTER / 2)


def lean_from_lines(
    lines: npt.ArrayLike,
    view: CameraView,
    sigmas: tuple[float, float] = TILT_SIGMAS,
    least_support: float = LEAST_SUPPORT,
    least_length: float = LEAST_LENGTH,
) -> Lean:
    """Lean a body so that lines lie on the ground in two directions at right angles.

    Parameters
    ----------
    lines : array_like, shape (N, 4)
        (u1, v1, u2, v2), px to a fraction of one, without the lens.
    view : CameraView
        What the robot believes.
    sigmas : (float, float)
        How well it knows its pitch and roll before it looks, standard deviations in rad.
    least_support : float
        How many metres of lines must agree more than disagree; see `support`.
    least_length : float
        Of a line that is asked, m on the ground as believed.

    Returns
    -------
    Lean
        Where lines cannot tell, or too few of them agree: no lean, as sure as before, and a direction
        that may be any.
    """
    ends = np.asarray(lines, dtype=float).reshape(-1, 4)
    prior = np.array(sigmas)
    length = ground_lengths(ends, view)
    normals, sd = (
        line_normals(ends, view),
        np.where(length >= least_length, direction_sigmas(ends, view), np.nan),
    )
    best = np.argsort(np.where(np.isfinite(sd), sd, np.inf), kind="stable")[
        : min(MOST_LINES, np.isfinite(sd).sum())
    ]
    normals, sd, doubt = normals[best], sd[best], np.array(DOUBTS)[np.searchsorted(LENGTHS, length[best])]
    starts = _starts(normals, sd, doubt, prior)
    unknown = Lean(0.0, 0.0, 0.0, np.diag([*prior**2, QUARTER**2 / 12]))
    if not len(starts):
        return unknown
    states, covariances, costs = _refine(normals, sd, doubt, prior, starts)
    mean, covariance = _mixture(states, covariances, costs)
    lean = Lean(float(mean[0]), float(mean[1]), float(wrap_quarter(mean[2])), covariance)
    return lean if support(ends, view, lean) >= least_support else unknown


def support(lines: npt.ArrayLike, view: CameraView, lean: Lean) -> float:
    """How many metres of lines agree with a direction more than disagree: a circle's pieces contradict each other.

    Parameters
    ----------
    lines : array_like, shape (N, 4)
        (u1, v1, u2, v2), px without the lens.
    view : CameraView
        What the robot believes.
    lean : Lean
        What the lines seem to tell.

    Returns
    -------
    float
        Length on the ground of lines within 4 degrees of the direction or a right angle to it, less that of lines
        more than 6 degrees off, m.
    """
    level = leaning(view, lean.pitch, lean.roll)
    rays = _rays(np.asarray(lines, dtype=float).reshape(-1, 4), level)
    ground = (
        level.height * rays[..., :2] / np.maximum(-rays[..., 2:], 1e-3)
    )  # a ray that does not fall ends far away
    ground = ground[(np.linalg.norm(ground, axis=2) < FARTHEST_END).all(axis=1)]
    ahead, left = (ground[:, 1] - ground[:, 0]).T
    away, length = np.abs(wrap_quarter(np.arctan2(left, ahead) - lean.direction)), np.hypot(ahead, left)
    return float(length[away < AGREES].sum() - length[away > DISAGREES].sum())


def line_directions(normals: FloatArray, pitch: npt.ArrayLike, roll: npt.ArrayLike) -> FloatArray:
    """Directions of lines on the ground below a body that leans a little.

    A line and the camera span a plane; its normal, leant along, lies across the line.

    Parameters
    ----------
    normals : ndarray, shape (N, 3)
        Of those planes, in the frame of the robot as it believes to stand.
    pitch, roll : array_like, shape (...)
        Rad.

    Returns
    -------
    ndarray, shape (..., N)
        Rad from straight ahead to the left.
    """
    x, y, z = normals.T
    return np.arctan2(-x - np.asarray(pitch)[..., None] * z, y - np.asarray(roll)[..., None] * z)


def _rays(ends: FloatArray, view: CameraView) -> FloatArray:
    """Rays (N, 2, 3) to both ends of lines (N, 4), in the robot frame."""
    right, below = ((ends.reshape(-1, 2) - view.centre) / view.focal).T
    rays = np.stack((np.ones_like(right), -right, -below), axis=1) @ view.rotation.T
    return np.asarray(rays.reshape(-1, 2, 3))


def line_normals(ends: FloatArray, view: CameraView) -> FloatArray:
    """Unit normals (N, 3) of the planes that lines (N, 4) and the camera span, in the robot frame."""
    rays = _rays(ends, view)
    normals = np.cross(rays[:, 0], rays[:, 1])
    return np.asarray(normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-12)[:, None])


def direction_sigmas(ends: FloatArray, view: CameraView) -> FloatArray:
    """How well the directions (N,) of lines on the ground are known, rad; NaN for what can be none."""
    way = ends[:, 2:] - ends[:, :2]
    length = np.maximum(np.hypot(*way.T), 1e-9)[:, None]
    aside = END_SIGMA * view.size[0] / 320 * np.column_stack([-way[:, 1], way[:, 0]]) / length
    straight, variance = (
        line_directions(line_normals(ends, view), 0.0, 0.0),
        np.full(len(ends), DIRECTION_SIGMA**2),
    )
    for moved in (np.hstack([aside, 0 * aside]), np.hstack([0 * aside, aside])):
        change = line_directions(line_normals(ends + moved, view), 0.0, 0.0) - straight
        variance = variance + ((change + np.pi / 2) % np.pi - np.pi / 2) ** 2
    sd = np.sqrt(variance)
    enough = length[:, 0] >= LEAST_PIXELS * view.size[0] / 320
    return np.where(enough & (sd < np.radians(20)), sd, np.nan)


def ground_lengths(ends: FloatArray, view: CameraView) -> FloatArray:
    """Lengths (N,) of lines (N, 4) on the ground as believed, m; infinite for what reaches the horizon."""
    ground = to_ground(ends.reshape(-1, 2), view).reshape(-1, 4)
    return np.nan_to_num(np.hypot(ground[:, 2] - ground[:, 0], ground[:, 3] - ground[:, 1]), nan=np.inf)


def _likelihoods(away: FloatArray, sd: FloatArray, doubt: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Densities (..., N) of lines that lie `away` rad aside: of straight ones, and of what has any direction."""
    straight = (1 - doubt) * np.exp(-0.5 * (away / sd) ** 2) / (np.sqrt(2 * np.pi) * sd)
    return np.asarray(straight), np.asarray(doubt / QUARTER)


def _loss(away: FloatArray, sd: FloatArray, doubt: FloatArray) -> FloatArray:
    """Cost (...) of lines that lie `away` (..., N) rad aside: a square that flattens out, sooner for a short one."""
    straight, other = _likelihoods(away, sd, doubt)
    return np.asarray(-2 * np.log(straight + other).sum(axis=-1))


def _starts(normals: FloatArray, sd: FloatArray, doubt: FloatArray, prior: FloatArray) -> FloatArray:
    """The cheapest states (K, 3) of a grid, none near a cheaper one; the direction is one of the lines'."""
    pitch, roll = (each.ravel() for each in np.meshgrid(*(GRID * each for each in prior), indexing="ij"))
    directions = line_directions(normals, pitch, roll)  # (grid, N)
    tried = directions[:, :MOST_STARTS]
    cost = _loss(wrap_quarter(directions[:, None] - tried[..., None]), sd, doubt)  # (grid, tried)
    cost = (cost + ((pitch / prior[0]) ** 2 + (roll / prior[1]) ** 2)[:, None]).ravel()
    states = np.stack(np.broadcast_arrays(pitch[:, None], roll[:, None], tried), axis=-1).reshape(-1, 3)
    near = np.array([*1.2 * prior, np.radians(8.0)])
    kept: list[FloatArray] = []
    while len(kept) < MODES and len(states):
        kept.append(states[cost.argmin()])
        away = np.abs(states - kept[-1])
        away[:, 2] = np.abs(wrap_quarter(away[:, 2]))
        other = (away > near).any(axis=1)
        states, cost = states[other], cost[other]
    return np.array(kept).reshape(-1, 3)


def _refine(
    normals: FloatArray, sd: FloatArray, doubt: FloatArray, prior: FloatArray, states: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """States (K, 3), covariances (K, 3, 3) and costs (K,) where Gauss-Newton with robust weights leads."""
    held = np.diag([*prior**-2.0, 1e-6])
    for _ in range(STEPS):
        away, J = _misses(normals, states)
        straight, other = _likelihoods(away, sd, doubt)
        robust = straight / (straight + other)
        freedom = np.maximum(robust.sum(axis=1) - 1, 1.0)
        spread = np.maximum(1.0, (robust * (away / sd) ** 2).sum(axis=1) / freedom)
        weighted = J * (robust / sd**2 / spread[:, None])[:, None]
        information = weighted @ J.mT + held
        gradient = (weighted @ away[..., None])[..., 0] + states @ held * (1, 1, 0)
        change = np.linalg.solve(information, gradient[..., None])[..., 0]
        states = states - np.clip(change, -LARGEST_STEP, LARGEST_STEP)
    away, _ = _misses(normals, states)
    cost = _loss(away, sd, doubt) + ((states[:, :2] / prior) ** 2).sum(axis=1)
    return states, np.linalg.inv(information), cost


def _misses(normals: FloatArray, states: FloatArray) -> tuple[FloatArray, FloatArray]:
    """By what lines lie aside of the nearest direction (K, N), and its slopes (K, 3, N) by the states (K, 3)."""
    x, y, z = normals.T
    left, ahead = -x - states[:, :1] * z, y - states[:, 1:2] * z
    square = left**2 + ahead**2
    J = np.stack([-ahead * z / square, left * z / square, -np.ones_like(square)], axis=1)
    return wrap_quarter(np.arctan2(left, ahead) - states[:, 2:]), J


def _mixture(states: FloatArray, covariances: FloatArray, costs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Mean (3,) and covariance (3, 3) over several places, each weighed by how well it fits."""
    weight = np.exp(-(costs - costs.min()) / 2)
    weight /= weight.sum()
    best = states[costs.argmin()]
    states = np.column_stack([states[:, :2], best[2] + wrap_quarter(states[:, 2] - best[2])])
    mean = weight @ states
    away = states - mean
    return mean, np.einsum("k,kij->ij", weight, covariances + away[:, :, None] * away[:, None])
