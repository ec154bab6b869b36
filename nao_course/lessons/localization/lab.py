"""The diagnosis lab of lesson 06: the student's filter with one fault in it, and its readings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray, pose_errors, wrap_angle
from nao_course.lessons.localization.drives import LANDMARKS, Trace, follow, lap
from nao_course.sim.drives import Drive
from nao_course.slam import range_and_bearing

LAB_SEEDS = range(200, 220)  # drives of each patient
_SHIFT = 1e-3  # rad
Localize = Callable[..., Any]


@dataclass(frozen=True, eq=False)
class Bug:
    """Describe one fault of a filter and apply it.

    ``in_update(localize)`` returns a faulty `localize`, ``in_measurements(measurements)`` faulty measurements (n, 2),
    and `noise` is a factor of the control's covariance. `shows` says what the plots show, for a student who has named
    the fault.
    """

    name: str
    shows: str
    in_update: Callable[[Localize], Localize] = lambda localize: localize
    in_measurements: Callable[[FloatArray], FloatArray] = lambda measurements: measurements
    noise: float = 1.0


# --- faults; each needs a correct `localize` only, however it is written ---


def _mirrored(localize: Localize) -> Localize:
    """Give the innovation the other sign by mirroring the measurement at the expected one."""

    def faulty(
        pose: FloatArray,
        covariance: FloatArray,
        measured: FloatArray,
        landmark: FloatArray,
        noise: FloatArray,
    ) -> Any:
        expected = range_and_bearing(pose, landmark)
        return localize(pose, covariance, 2 * expected - measured, landmark, noise)

    return faulty


def _with_noise(change: Callable[[FloatArray], FloatArray]) -> Callable[[Localize], Localize]:
    """Return a fault that changes R."""

    def in_update(localize: Localize) -> Localize:
        return lambda pose, covariance, measured, landmark, noise: localize(
            pose, covariance, measured, landmark, change(noise)
        )

    return in_update


def _not_updating_p(localize: Localize) -> Localize:
    """Return the old covariance."""
    return lambda pose, covariance, *rest: (localize(pose, covariance, *rest)[0], covariance)


def _twice(localize: Localize) -> Localize:
    """Update twice with each measurement."""
    return lambda pose, covariance, *rest: localize(*localize(pose, covariance, *rest), *rest)


def _not_wrapping(localize: Localize) -> Localize:
    """Add the full turns that wrapping removes; the new pose is linear in the innovation."""

    def faulty(
        pose: FloatArray,
        covariance: FloatArray,
        measured: FloatArray,
        landmark: FloatArray,
        noise: FloatArray,
    ) -> Any:
        new, new_covariance = localize(pose, covariance, measured, landmark, noise)
        direction, _ = range_and_bearing((pose[0], pose[1], 0.0), landmark)
        turns = round((measured[0] - (direction - pose[2])) / (2 * np.pi))
        if turns:
            shifted, _ = localize(pose, covariance, measured + (_SHIFT, 0.0), landmark, noise)
            new = np.asarray(new) + pose_errors(shifted, new) / _SHIFT * 2 * np.pi * turns
            new[2] = wrap_angle(new[2])
        return new, new_covariance

    return faulty


def _with_jacobian_of_another(localize: Localize) -> Localize:
    """Linearise at the next landmark of the list; the innovation stays the same."""

    def faulty(
        pose: FloatArray,
        covariance: FloatArray,
        measured: FloatArray,
        landmark: FloatArray,
        noise: FloatArray,
    ) -> Any:
        number = int(np.abs(LANDMARKS - landmark).sum(axis=1).argmin())
        other = LANDMARKS[(number + 1) % len(LANDMARKS)]
        moved = range_and_bearing(pose, other) - range_and_bearing(pose, landmark)
        return localize(pose, covariance, measured + moved, other, noise)

    return faulty


HEALTHY = Bug("no fault", "The innovations are centred on zero, and NIS and NEES are in their bands.")
BUGS = (
    Bug(
        "the innovation's sign",
        "Every correction goes the wrong way, so the innovations grow with each measurement, and NIS and NEES "
        "leave the plot within a few steps, while the ellipse stays small.",
        in_update=_mirrored,
    ),
    Bug(
        "the bearing is not wrapped",
        "The filter works until the heading passes 180 degrees. Then one innovation is off by a full turn, "
        "and the estimate jumps.",
        in_update=_not_wrapping,
    ),
    Bug(
        "R holds standard deviations",
        "R contains 0.026 rad and 0.1 m instead of their squares, so the filter hardly uses its "
        "measurements. NIS and NEES are both below their bands, or at their lower edge.",
        in_update=_with_noise(np.sqrt),
    ),
    Bug(
        "Q is missing",
        "The ellipse only shrinks, so later measurements get less and less weight. NIS and NEES start at 1 "
        "and grow from the second step on.",
        noise=1e-9,
    ),
    Bug(
        "H belongs to another landmark",
        "Corrections point in wrong directions, so innovations, NIS and NEES are several times too large from "
        "the first measurement on; but the filter does not diverge.",
        in_update=_with_jacobian_of_another,
    ),
    Bug(
        "bearings in degrees",
        "The innovations of the bearing are spread over the whole circle from the first measurement on.",
        in_measurements=lambda measurements: measurements * (np.degrees(1.0), 1.0),
    ),
    Bug(
        "P is not updated",
        "The ellipse only grows, so NIS and NEES fall from step to step.",
        in_update=_not_updating_p,
    ),
    Bug(
        "R is missing in S",
        "The filter treats each measurement as exact, so its ellipse is far too small. NIS is less than "
        "twice its expected value, because the readings use the correct S, which is mostly R; but NEES is enormous.",
        in_update=_with_noise(lambda noise: noise * 1e-6),
    ),
    Bug(
        "ranges 15 % too long",
        "The innovations of the range are not centred on zero. The measurement has a bias, and no covariance "
        "can describe a bias.",
        in_measurements=lambda measurements: measurements * (1.0, 1.15),
    ),
    Bug(
        "each measurement is used twice",
        "Innovations and NIS look right. Only NEES, which is nearly twice its expected value, shows that the "
        "ellipse is too small.",
        in_update=_twice,
    ),
)


def patient(
    bug: Bug, functions: Mapping[str, Callable[..., Any]], drives: int = len(LAB_SEEDS)
) -> list[Trace]:
    """Run a filter with a bug along the lab's drives.

    There is a trace for each drive; innovations and S are computed with the correct R.
    """
    localize = functions["localize"]
    faulty = bug.in_update(localize)
    traces = []
    for seed in LAB_SEEDS[:drives]:
        drive, error = lap(seed)
        steps = (
            replace(
                step,
                control_covariance=step.control_covariance * bug.noise,
                measurements=bug.in_measurements(step.measurements),
            )
            for step in drive.steps
        )
        changed = Drive(LANDMARKS, tuple(steps))
        with np.errstate(all="ignore"):
            traces.append(
                follow(
                    changed, faulty, functions["predict_pose"], functions["predict_covariance"], error=error
                )
            )
    return traces


@dataclass(frozen=True)
class Readings:
    """Summarise the traces of a patient over all its drives.

    `bearing` and `range` are median innovations in standard deviations of S, so 0 is expected. The others are median
    NIS and NEES of the first and the last third of the drive, and of the step with the largest NIS, divided by the
    expected median.
    """

    bearing: float
    range: float
    nis_early: float
    nis_late: float
    nis_peak: float
    nees_early: float
    nees_late: float


MEDIAN_NIS, MEDIAN_NEES = 1.386, 2.366  # of chi-square with two and three degrees of freedom


def read(traces: list[Trace]) -> Readings:
    """Return the readings of a patient's traces."""
    steps = np.concatenate([trace.steps for trace in traces])
    nis = np.concatenate([trace.nis for trace in traces])
    scaled = np.concatenate(
        [
            trace.innovations / np.sqrt(np.diagonal(trace.innovation_covariances, axis1=1, axis2=2))
            for trace in traces
        ]
    )
    nees = np.array([trace.nees for trace in traces])
    third = nees.shape[1] // 3
    early, late = steps <= third, steps > 2 * third
    bearing, distance = np.median(scaled, axis=0)
    peak = max(float(np.median(nis[steps == step])) for step in np.unique(steps))
    return Readings(
        float(bearing),
        float(distance),
        float(np.median(nis[early]) / MEDIAN_NIS),
        float(np.median(nis[late]) / MEDIAN_NIS),
        peak / MEDIAN_NIS,
        float(np.median(nees[:, 1 : third + 1]) / MEDIAN_NEES),
        float(np.median(nees[:, -third:]) / MEDIAN_NEES),
    )
