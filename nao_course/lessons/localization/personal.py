"""Drives of a student's personal world, and the consistency of a filter over the steps of one drive."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course._internal.personal_world import PersonalWorld
from nao_course.lessons.localization.drives import follow_many

DRIVES = 40


def personal_numbers(
    world: PersonalWorld,
    localize: Callable[..., Any],
    predict_pose: Callable[..., Any],
    predict_covariance: Callable[..., Any],
) -> dict[str, float]:
    """Return the mean NEES of forty drives, the standard deviation of each drive's mean, and how errors carry over."""
    first = world.seed("06: drives")
    traces = follow_many(range(first, first + DRIVES), localize, predict_pose, predict_covariance)
    nees = np.array([trace.nees[1:] for trace in traces])
    errors = np.array([np.hypot(*trace.errors[1:, :2].T) for trace in traces])
    independent = np.sqrt(2 * 3 / nees.shape[1])
    return {
        "mean NEES": float(nees.mean()),
        f"standard deviation of the mean of a drive ({independent:.3f} with independent steps)": float(
            nees.mean(axis=1).std(ddof=1)
        ),
        "correlation of the position errors of a step and the next": float(
            np.corrcoef(errors[:, :-1].ravel(), errors[:, 1:].ravel())[0, 1]
        ),
    }
