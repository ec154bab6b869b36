"""Beliefs that entries return (pose and covariance): conversion, checks, and scores by the density at the truth."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from nao_course.challenges.declaration import CaseScore, Run
from nao_course.challenges.worst_cases import draw_worst
from nao_course.geometry import FloatArray, Pose, rotation_2d
from nao_course.metrics import band, log_density
from nao_course.plotting import Drawing
from nao_course.plotting.legends import source_key
from nao_course.slam import Estimate, Motion

DEEPEST = -20.0  # bits: smallest score of a case, so that a single case does not decide the total
MOST_NEES = 1000.0  # largest value in a column


def as_belief(answer: Any, with_map: bool = False) -> tuple[FloatArray, FloatArray]:
    """Return the pose (3,) and the covariance (3, 3) of an answer.

    The answer is an `Estimate`, or a pair of a pose or `Pose` and covariance; `with_map`, also a state (n,) that begins
    with the pose, with covariance (n, n). Raise a TypeError or ValueError with a message for the student if it is
    something else.
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
        raise TypeError(f"Your entry must return two values: the {mean} and its covariance.") from None
    if is_complex:
        raise TypeError("Your belief contains complex numbers. Did you take the root of a negative number?")
    size = len(state) if with_map and state.ndim == 1 and len(state) > 3 else 3
    if state.shape != (size,) or covariance.shape != (size, size):
        raise ValueError(
            f"Your {mean} has shape {state.shape} and your covariance {covariance.shape}; expected {wanted}."
        )
    pose, spread = state[:3], covariance[:3, :3]
    if not (np.isfinite(pose).all() and np.isfinite(spread).all()):
        raise ValueError("Your pose or its covariance contains NaN or infinite numbers.")
    if not np.allclose(spread, spread.T, rtol=1e-6, atol=1e-12):
        raise ValueError("Your pose's covariance is not symmetric.")
    if np.linalg.eigvalsh(spread)[0] <= 0:
        raise ValueError(
            "Your pose's covariance is not positive definite: in one direction it claims no uncertainty."
        )
    return pose, spread


def score_belief(
    pose: FloatArray,
    covariance: FloatArray,
    truth: FloatArray,
    before: tuple[FloatArray, FloatArray],
    kept: object,
) -> CaseScore:
    """Score a belief by the log ratio (bits) of its density at the truth to the density of the belief before the entry.

    Poses are (3,), covariances (3, 3), and `kept` is data for the figure. The columns are "off" and "stated"
    (position, cm) and "NEES".
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
    """Score an entry's belief at the end of a drive by the log density ratio (bits) to odometry's belief.

    The answer is a pose (3,), or a state that begins with it, and a covariance, in the frame of odometry's (3,) and
    (3, 3); the figure gets (drive, pose, covariance). Raise a TypeError or ValueError with a message for the student if
    it is something else.
    """
    pose, covariance = as_belief(answer, with_map=True)
    return score_belief(pose, covariance, truth, odometry, (drive, pose, covariance))


def say_bits(drives: int) -> str:
    """Return a text that explains the score of `score_end`."""
    low, high = band(3, drives)
    return (
        "bits: how much denser your belief is at the robot's true pose than the belief of odometry alone. It is a "
        "logarithm to the base 2, averaged over all drives. A small error helps only if your filter is consistent: its "
        f"NEES should be between {low:.1f} and {high:.1f}."
    )


def draw_worst_ends(run: Run, plot_drive: Callable[[Axes, Any], None]) -> Drawing:
    """Draw the drives with the fewest bits: the true path, and the belief at its end.

    ``plot_drive(ax, kept)`` draws a drive scored by `score_end`; `kept` is (drive, pose, covariance).
    """
    keys = [source_key("truth", "true path"), source_key("ekf", "estimate at the end, 95 %")]
    return draw_worst(run, plot_drive, keys, digits=1)


def odometry_belief(
    start: Pose, motions: Sequence[Motion], covariances: npt.ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return the last odometry pose (3,) and its covariance (3, 3).

    An error along or across a step shifts the rest of the path, and an error of a turn rotates it about the end of that
    step. The start is known. Covariances (M, 3, 3) are of the M steps' errors along, across and in the turn, in the
    robot frame.
    """
    path = [start]
    for motion in motions:
        path.append(path[-1] @ motion.as_pose())
    poses = np.array([each.as_array() for each in path])
    away = poses[-1, :2] - poses[1:, :2]
    slips = np.tile(np.eye(3), (len(away), 1, 1))
    slips[:, :2, :2] = [rotation_2d(theta) for theta in poses[:-1, 2]]
    slips[:, 0, 2], slips[:, 1, 2] = -away[:, 1], away[:, 0]
    return poses[-1], np.asarray(np.einsum("kij,kjl,kml->im", slips, np.asarray(covariances), slips))
