"""The diagnosis lab of lesson 06: the student's own filter with one thing wrong in it, and its instruments."""

from __future__ import annotations

import types
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray
from nao_course.lessons.localization.drives import (
    LANDMARKS,
    Drive,
    Sight,
    Trace,
    follow,
    lap,
)
from nao_course.slam import range_and_bearing

LAB_SEEDS = range(200, 220)  # drives of each patient
Localize = Callable[..., Any]


@dataclass(frozen=True, eq=False)
class Bug:
    """One thing that is wrong with a filter.

    Parameters
    ----------
    name : str
        What it is.
    shows : str
        What its instruments show, for a student who has named it.
    in_update : callable
        ``in_update(localize)`` returns the `localize` that is ill.
    in_sight : callable
        ``in_sight(sight)`` returns what is measured instead.
    in_parts : mapping of str to callable
        Functions that the student's `localize` finds in place of its own.
    noise : float
        Factor of the control's covariance.
    """

    name: str
    shows: str
    in_update: Callable[[Localize], Localize] = lambda localize: localize
    in_sight: Callable[[Sight], Sight] = lambda sight: sight
    in_parts: Mapping[str, Callable[..., Any]] | None = None
    noise: float = 1.0


def with_parts(localize: Localize, parts: Mapping[str, Callable[..., Any]]) -> Localize:
    """Return a copy of a notebook's function that finds other functions under some names; the own one stays.

    Raises
    ------
    ValueError
        If it does not use one of these names.
    """
    code = getattr(localize, "__code__", None)
    if not isinstance(localize, types.FunctionType) or code is None or not set(parts) <= set(code.co_names):
        raise ValueError(
            f"this patient needs a localize that calls {' and '.join(f'{name}()' for name in parts)}"
        )
    return types.FunctionType(
        code,
        {**localize.__globals__, **parts},
        localize.__name__,
        localize.__defaults__,
        localize.__closure__,
    )


# --- what can be wrong ---


def _mirrored(localize: Localize) -> Localize:
    """As if the innovation had the other sign: what is measured lies on the other side of what is expected."""

    def ill(
        pose: FloatArray,
        covariance: FloatArray,
        measured: FloatArray,
        landmark: FloatArray,
        noise: FloatArray,
    ) -> Any:
        expected = range_and_bearing(pose, landmark)
        return localize(pose, covariance, 2 * expected - measured, landmark, noise)

    return ill


def _with_noise(change: Callable[[FloatArray], FloatArray]) -> Callable[[Localize], Localize]:
    """Another R."""

    def in_update(localize: Localize) -> Localize:
        return lambda pose, covariance, measured, landmark, noise: localize(
            pose, covariance, measured, landmark, change(noise)
        )

    return in_update


def _stale(localize: Localize) -> Localize:
    """The covariance stays what it was."""
    return lambda pose, covariance, *rest: (localize(pose, covariance, *rest)[0], covariance)


def _twice(localize: Localize) -> Localize:
    """Each measurement is taken in twice."""
    return lambda pose, covariance, *rest: localize(*localize(pose, covariance, *rest), *rest)


def _not_wrapped(pose: FloatArray, landmark: FloatArray) -> FloatArray:
    direction, distance = range_and_bearing((pose[0], pose[1], 0.0), landmark)
    return np.array([direction - pose[2], distance])


def _of_another(pose: FloatArray, landmark: FloatArray) -> FloatArray:
    """Slopes of (bearing, range) by the pose at the next landmark of the list."""
    number = int(np.abs(LANDMARKS - landmark).sum(axis=1).argmin())
    away = LANDMARKS[(number + 1) % len(LANDMARKS)] - np.asarray(pose)[:2]
    ahead = away / np.hypot(*away)
    across = np.array([ahead[1], -ahead[0]]) / np.hypot(*away)
    return np.vstack([np.append(across, -1.0), np.append(-ahead, 0.0)])


def _in_degrees(sight: Sight) -> Sight:
    return replace(sight, measurement=sight.measurement * (np.degrees(1.0), 1.0))


def _too_far(sight: Sight) -> Sight:
    return replace(sight, measurement=sight.measurement * (1.0, 1.15))


HEALTHY = Bug(
    "nothing: it is healthy",
    "Residuals around zero, NIS and NEES in their bands.",
)
BUGS = (
    Bug(
        "the innovation's sign",
        "Every correction goes the wrong way: residuals grow from look to look, and both NIS and NEES "
        "leave the paper within a few steps, while the ellipse stays small.",
        in_update=_mirrored,
    ),
    Bug(
        "the bearing is not wrapped",
        "All is well until the heading passes 180 degrees. Then one innovation is off by a full turn, "
        "and the estimate jumps.",
        in_parts={
            "expected_measurement": _not_wrapped,
            "innovation": lambda expected, measured: np.asarray(measured) - np.asarray(expected),
        },
    ),
    Bug(
        "R holds standard deviations",
        "0.026 rad and 0.1 m stand where their squares belong: the filter hardly believes what it sees. "
        "NIS and NEES both lie far below their bands.",
        in_update=_with_noise(np.sqrt),
    ),
    Bug(
        "Q is forgotten",
        "The ellipse only ever shrinks, so later measurements count for ever less. NIS and NEES begin in "
        "their bands and climb step by step.",
        noise=1e-9,
    ),
    Bug(
        "H belongs to another landmark",
        "Corrections point to wrong places: residuals are several times too large, NIS and NEES too, "
        "from the first look on; yet the filter does not run away for good.",
        in_parts={"measurement_jacobian_pose": _of_another},
    ),
    Bug(
        "bearings in degrees",
        "The bearing's residuals are spread over the whole circle, from the first look on.",
        in_sight=_in_degrees,
    ),
    Bug(
        "P is not updated",
        "The ellipse only ever grows: NIS and NEES fall from step to step.",
        in_update=_stale,
    ),
    Bug(
        "R is left out of S",
        "Each measurement is believed as if it were exact: the ellipse is far too small. NIS is only a "
        "little high, because R is most of S; NEES is enormous.",
        in_update=_with_noise(lambda noise: noise * 1e-6),
    ),
    Bug(
        "ranges 15 % too long",
        "Residuals of the range are not around zero. That is the sign of a bias: no covariance can mend it.",
        in_sight=_too_far,
    ),
    Bug(
        "each measurement is used twice",
        "Residuals and NIS look healthy. Only NEES, about twice what it should be, shows that the "
        "ellipse is too small.",
        in_update=_twice,
    ),
)


def patient(
    bug: Bug, functions: Mapping[str, Callable[..., Any]], drives: int = len(LAB_SEEDS)
) -> list[Trace]:
    """Let a filter with a bug drive.

    Parameters
    ----------
    bug : Bug
        What is wrong.
    functions : mapping of str to callable
        The student's localize, predict_pose and predict_covariance.
    drives : int
        How many of the lab's drives.

    Returns
    -------
    list of Trace
        One for each of the lab's drives; the instruments show what the filter measures, with the true R.
    """
    localize = functions["localize"]
    ill = bug.in_update(localize if bug.in_parts is None else with_parts(localize, bug.in_parts))
    traces = []
    for seed in LAB_SEEDS[:drives]:
        drive, error = lap(seed)
        seen = tuple(tuple(map(bug.in_sight, sights)) for sights in drive.sights)
        changed = Drive(drive.truth, drive.controls, drive.control_covariances * bug.noise, seen)
        with np.errstate(all="ignore"):
            traces.append(
                follow(changed, ill, functions["predict_pose"], functions["predict_covariance"], error=error)
            )
    return traces


@dataclass(frozen=True)
class Readings:
    """What the instruments show of a patient, over all its drives.

    Parameters
    ----------
    bearing, range : float
        Median innovation in standard deviations, as S has them: 0 is healthy.
    nis_early, nis_late : float
        Median NIS of the first and the last third of the drive, over the median it should have: 1 is healthy.
    nis_peak : float
        The same of the one step where it is largest.
    nees_early, nees_late : float
        As of NIS.
    """

    bearing: float
    range: float
    nis_early: float
    nis_late: float
    nis_peak: float
    nees_early: float
    nees_late: float


MEDIAN_NIS, MEDIAN_NEES = 1.386, 2.366  # of chi-square with two and with three degrees of freedom


def read(traces: list[Trace]) -> Readings:
    """Read the instruments."""
    steps = np.concatenate([trace.steps for trace in traces])
    nis = np.concatenate([trace.nis for trace in traces])
    scaled = np.concatenate(
        [trace.innovations / np.sqrt(np.diagonal(trace.spreads, axis1=1, axis2=2)) for trace in traces]
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
