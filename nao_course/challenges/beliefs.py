"""A belief that an entry returned, pose and covariance: checked, and scored by how dense it is at the truth."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_course.challenges.declaration import CaseScore
from nao_course.geometry import FloatArray
from nao_course.metrics import log_density

DEEPEST = -20.0  # bits: no case counts less, so that one is not everything
MOST_NEES = 1000.0  # that a column shows


def as_belief(answer: Any, with_map: bool = False) -> tuple[FloatArray, FloatArray]:
    """Return an answer's pose (3,) and its covariance (3, 3).

    Parameters
    ----------
    answer : object
        What an entry returned.
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
    try:
        state, covariance = (np.array(each, subok=False) for each in answer)
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
