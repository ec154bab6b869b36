"""A belief that an entry returned, pose and covariance: checked, and scored by how dense it is at the truth."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nao_course.challenges.declaration import CaseScore, Run
from nao_course.challenges.worst_cases import draw_worst
from nao_course.geometry import FloatArray, Pose, rotation_2d
from nao_course.metrics import band, log_density
from nao_course.plotting import Drawing
from nao_course.plotting.legends import source_key
from nao_course.slam import Estimate

DEEPEST = -20.0  # bits: no case counts less, so that one is not everything
MOST_NEES = 1000.0  # that a column shows


def as_belief(answer: Any, with_map: bool = False) -> tuple[FloatArray, FloatArray]:
    """Return an answer's pose (3,) and its covariance (3, 3).

    Parameters
    ----------
    answer : object
        What an entry returned; the pose may be a `Pose`, the whole an `Estimate`.
    with_map : bool
        Whether it may be a state (n,) with its covariance (n, n), pose first; of the rest nothing is looked at.

    Raises
    ------
    TypeError, ValueError
        If it is something else; the message is for the student.
    """
    mean, wanted = ("state", "(n,) and (n, n), the pose first,") if with_map else ("pose", "(3,) and (3, 3)")
    if answer is None:
        raise TypeError(f"Your entry returns None: does it end with return {mean}, covariance?")
    if isinstance(answer, Estimate):
        answer = answer.pose, answer.covariance
    try:
        state, covariance = (
            np.array(each.as_array() if isinstance(each, Pose) else each, subok=False) for each in answer
        )
        is_complex = "c" in (state.dtype.kind, covariance.dtype.kind)
        state, covariance = state.real.astype(float), covariance.real.astype(float)
    except (TypeError, ValueError):
        raise TypeError(f"Your entry must return two things: the {mean} and its covariance.") from None
    if is_complex:
        raise TypeError("Your belief has complex numbers in it: the root of something negative, perhaps?")
    size = len(state) if with_map and state.ndim == 1 and len(state) > 3 else 3
    if state.shape != (size,) or covariance.shape != (size, size):
        raise ValueError(
            f"Your {mean} has shape {state.shape} and your covariance {covariance.shape}; {wanted} are wanted."
        )
    pose, spread = state[:3], covariance[:3, :3]
    if not (np.isfinite(pose).all() and np.isfinite(spread).all()):
        raise ValueError("Your pose or its covariance has NaN or infinite numbers in it.")
    if not np.allclose(spread, spread.T, rtol=1e-6, atol=1e-12):
        raise ValueError("Your pose's covariance is not symmetric.")
    if np.linalg.eigvalsh(spread)[0] <= 0:
        raise ValueError(
            "Your pose's covariance has an eigenvalue that is not positive: a direction without any doubt."
        )
    return pose, spread


def score_belief(
    pose: FloatArray,
    covariance: FloatArray,
    truth: FloatArray,
    before: tuple[FloatArray, FloatArray],
    kept: object,
) -> CaseScore:
    """Score a belief by how many bits it is denser at the truth than another.

    Parameters
    ----------
    pose, covariance, truth : ndarray, shapes (3,), (3, 3) and (3,)
        The belief, and the true pose.
    before : (ndarray (3,), ndarray (3, 3))
        What is believed without the entry.
    kept : object
        For the figure.

    Returns
    -------
    CaseScore
        With columns "off" and "stated", position in cm, and "NEES".
    """
    bits, nees = log_density(pose, covariance, truth)
    without, _ = log_density(*before, truth)
    columns = {
        "off": 100 * float(np.hypot(*(pose - truth)[:2])),
        "stated": 100 * float(np.sqrt(np.trace(covariance[:2, :2]))),
        "NEES": min(nees, MOST_NEES),
    }
    return CaseScore(max(bits - without, DEEPEST), columns, kept)


def score_end(
    answer: Any, truth: FloatArray, odometry: tuple[FloatArray, FloatArray], drive: object
) -> CaseScore:
    """Score what an entry believes at the end of a drive: by how many bits it is denser there than odometry's.

    Parameters
    ----------
    answer : object
        What the entry returned: a pose or a state, pose first, and its covariance.
    truth : ndarray, shape (3,)
        The true pose at the end.
    odometry : (ndarray (3,), ndarray (3, 3))
        What is believed by who sees nothing, in the same frame.
    drive : object
        For the figure, which gets (drive, pose, covariance).

    Raises
    ------
    TypeError, ValueError
        If the answer is no belief; the message is for the student.
    """
    pose, covariance = as_belief(answer, with_map=True)
    return score_belief(pose, covariance, truth, odometry, (drive, pose, covariance))


def say_bits(drives: int) -> str:
    """Say how `score_end` scores, for a challenge of so many drives."""
    low, high = band(3, drives)
    return (
        "bits: how much denser your belief is at the robot's true pose than that of odometry alone, as a logarithm "
        "to the base 2, the mean over all drives. A small error counts only where your covariance is honest about it: "
        f"NEES between {low:.1f} and {high:.1f} is."
    )


def draw_worst_ends(run: Run, plot_drive: Callable[[Axes, Any], None]) -> Drawing:
    """Draw the drives with the fewest bits: the true path, and what is believed at its end.

    Parameters
    ----------
    run : Run
        All drives of the challenge, scored by `score_end`.
    plot_drive : callable
        ``plot_drive(ax, kept)`` draws one; kept is (drive, pose, covariance).
    """
    keys = [source_key("truth", "where it drove"), source_key("ekf", "believed at the end, 95 %")]
    return draw_worst(run, plot_drive, keys, digits=1)


def odometry_covariance(told: FloatArray, noise: FloatArray) -> FloatArray:
    """Covariance of the last pose that odometry tells.

    A step's slip along and across carries it along; a turn that was wrong swings it about the end of that step.

    Parameters
    ----------
    told : ndarray, shape (M + 1, 3)
        Poses as the commands add up, from a start that is known; m and rad.
    noise : ndarray, shape (M, 3, 3)
        Of each step: along, across and of the turn, robot frame.

    Returns
    -------
    ndarray, shape (3, 3)
        In the frame of the poses.
    """
    away = told[-1, :2] - told[1:, :2]
    slips = np.tile(np.eye(3), (len(away), 1, 1))
    slips[:, :2, :2] = [rotation_2d(theta) for theta in told[:-1, 2]]
    slips[:, 0, 2], slips[:, 1, 2] = -away[:, 1], away[:, 0]
    return np.asarray(np.einsum("kij,kjl,kml->im", slips, noise, slips))
