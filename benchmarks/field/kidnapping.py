"""A robot that is carried away during a drive: when it notices, when it is back, and how often it is wrong.

``python -m benchmarks kidnapping`` uses the drives of ``field_slam``. A kidnapped robot sees the first stops of one
drive and then the stops of another drive, from a place at least 0.5 m away. The motion between them is the usual one of
the second drive, so nothing but the pictures shows that the robot was carried away. In an ordinary drive an alarm is
false if the filter without `KidnapRecovery` is right at that stop.
"""

from __future__ import annotations

import time
from collections import Counter, defaultdict
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from benchmarks import Result, Table, in_processes
from benchmarks.field.detections import Seen, detections, prepare
from benchmarks.field.field_tails import WHOLE
from benchmarks.field.variants import Read, joint_update, surest_first
from nao_course.field_slam.drives import YAWS
from nao_course.field_slam.kidnapping.recovery import TRUSTED, KidnapRecovery
from nao_course.field_slam.likelihood import CLUTTER, Clutter
from nao_course.field_slam.line_observation import StopView
from nao_course.geometry import FloatArray, wrap_angle
from nao_course.slam import SlamAlgorithm

# Nothing was tuned on these drives. All parameters were tuned on drives 200 to 299.
ORDINARY = range(2000, 2300)
CARRIED = range(2000, 2100)
FIRST, LAST = 20, 40  # the robot is carried away after at least and at most this many stops
ELSEWHERE = 0.5  # m: least distance between the places
AFTERWARDS = 15  # least number of stops after the robot was carried away
SOON, MORE = 2, 5  # wanted: it notices within so many stops, and is back within so many more
BACK = 0.05  # m: the robot is back if its error is smaller
RIGHT = (0.15, float(np.radians(10)))  # m and rad: errors up to which a filter counts as right
PICTURES = 3  # of a stop
NEVER = 99
# m: range within which clutter is counted, and least distance of two things of the same kind
NEAR, SAME = 3.0, 0.15

Stop = Sequence[Seen]


@dataclass(frozen=True)
class Step:
    """The state of the robot after a stop."""

    error: float  # errors of position and heading, m and rad
    turned: float
    lost: bool  # whether the robot does not know where it is
    alarms: int  # how often it has noticed that it was carried away
    kept: bool  # whether it kept more than one hypothesis
    milliseconds: float  # time of the SLAM algorithm for each of the stop's pictures
    there: tuple[bool, ...]  # whether it is back after each picture, from the first stop elsewhere on


@dataclass(frozen=True)
class Kidnapping:
    """The result of one kidnapping; a number of stops or pictures is NEVER if it did not happen."""

    noticed: int  # number of stops until the robot noticed, at least 1
    back: int  # number of stops from then until the error was smaller than BACK and the robot was not lost
    error: float  # error at the last stop at which it should be back, and at the end of the drive, m
    end: float
    wrong: int  # number of stops after the alarm at which the robot was sure of a wrong pose
    early: int  # number of alarms before the kidnapping
    pictures: int = NEVER  # number of pictures until it was back, at least 1

    @property
    def success(self) -> bool:
        """Whether the robot noticed and was back in time, without an alarm before."""
        return self.noticed <= SOON and self.back <= MORE and not self.early


def stops_of(seed: int) -> list[Stop]:
    """Return the stops of a drive."""
    seen = detections(seed)
    return [seen[first : first + PICTURES] for first in range(0, len(seen), PICTURES)]


def spliced(seed: int, other: int) -> tuple[list[Stop], int]:
    """Return the stops of a robot that is carried from one drive into another, and how many precede that."""
    rng = np.random.default_rng([seed, 31])
    drive, second = stops_of(seed), stops_of(other)
    first = int(rng.integers(FIRST, LAST + 1))
    here = drive[first][0].pose
    places = np.array([(stop[0].pose.x - here.x, stop[0].pose.y - here.y) for stop in second])
    far = 1 + np.flatnonzero(np.hypot(*places[1 : len(second) - AFTERWARDS].T) >= ELSEWHERE)
    return [*drive[:first], *second[int(rng.choice(far)) :]], first


def steps(slam: SlamAlgorithm, stops: Sequence[Stop], first: int = NEVER) -> list[Step]:
    """Run an algorithm over some stops, and ask for its estimate after each picture from the first one's on."""
    found, rng = [], np.random.default_rng(0)
    for number, stop in enumerate(stops):
        pose, observations = stop[0].pose, [WHOLE(Read.of(seen), rng) for seen in stop]
        recovery, there = slam if isinstance(slam, KidnapRecovery) else None, []
        began = time.thread_time()
        if stop[0].motion is not None:
            slam.move(stop[0].motion)
        for each in observations:
            slam.observe(each)
            if recovery and number >= first:
                estimate = slam.estimate().pose
                near = bool(np.hypot(estimate.x - pose.x, estimate.y - pose.y) < BACK)
                there.append(near and not recovery.lost and recovery.kidnappings > 0)
        estimate = slam.estimate().pose
        took = 1000 * (time.thread_time() - began) / PICTURES
        error = float(np.hypot(estimate.x - pose.x, estimate.y - pose.y))
        turned = float(abs(wrap_angle(estimate.theta - pose.theta)))
        lost, alarms = (recovery.lost, recovery.kidnappings) if recovery else (False, 0)
        kept = recovery is not None and recovery.lost_probability > TRUSTED
        found.append(Step(error, turned, lost, alarms, kept, took, tuple(there)))
    return found


def kidnapped(seeds: tuple[int, int]) -> tuple[Kidnapping, list[Step]]:
    """Carry a robot from one drive into another."""
    stops, first = spliced(*seeds)
    found = steps(KidnapRecovery(joint_update(stops[0][0].pose)), stops, first)
    early, there = found[first - 1].alarms, found[first:]
    noticed = _first(there, lambda step: step.alarms > early)
    after = there[noticed:]
    back = _first(after, lambda step: not step.lost and step.error < BACK)
    right = [each for step in there for each in step.there]
    pictures = 1 + right.index(True) if True in right else NEVER
    wrong = sum(not step.lost and step.error > RIGHT[0] for step in after)
    last = there[min(noticed + MORE, len(there) - 1)]
    result = Kidnapping(min(noticed + 1, NEVER), back, last.error, there[-1].error, wrong, early, pictures)
    return result, found


def ordinary(seed: int) -> tuple[int, int, list[Step]]:
    """Return the number of alarms of an ordinary drive, how many of them are false, and its stops."""
    stops = stops_of(seed)
    found = steps(KidnapRecovery(joint_update(stops[0][0].pose)), stops)
    if not found[-1].alarms:
        return 0, 0, found
    plain = steps(surest_first(joint_update)(stops[0][0].pose), stops)
    alarms = [number for number in range(1, len(found)) if found[number].alarms > found[number - 1].alarms]
    false = [n for n in alarms if plain[n].error <= RIGHT[0] and plain[n].turned <= RIGHT[1]]
    return len(alarms), len(false), found


def clutter(seed: int) -> dict[Clutter, float]:
    """Return the density of the measurements of a drive that belong to nothing measured before, per m^2 and per m."""
    known: dict[tuple[Clutter, int], list[FloatArray]] = defaultdict(list)
    stops, rng, new = stops_of(seed), np.random.default_rng(0), Counter[Clutter]()
    for stop in stops:
        pose, view = stop[0].pose, StopView.of([WHOLE(Read.of(seen), rng) for seen in stop])
        at = pose.to_parent(view.points)
        sigmas = np.sqrt(np.trace(view.covariances, axis1=1, axis2=2) / 2)
        axes, offsets, variances = view.lines_from(pose.theta)
        lines = offsets[:, None] + np.array([pose.x, pose.y])[axes][:, None]
        near = np.hypot(*view.points.T) < NEAR
        measured: list[tuple[Clutter, int, FloatArray, float]] = [
            (view.kinds[i], 0, at[i], sigmas[i]) for i in np.flatnonzero(near)
        ]
        measured += [("line", *each) for each in zip(axes.tolist(), lines, np.sqrt(variances), strict=True)]
        for kind, axis, place, sigma in measured:
            before = known[kind, axis]
            if all(np.linalg.norm(place - other) > max(SAME, 3 * sigma) for other in before):
                before.append(place)
                new[kind] += 1
    area = NEAR**2 * (YAWS[0] + stops[0][0].view.hfov / 2)
    return {kind: new[kind] / len(stops) / (2 * NEAR if kind == "line" else area) for kind in CLUTTER}


def _first(found: Sequence[Step], holds: Callable[[Step], bool]) -> int:
    """Return the number of the first stop at which a condition holds, or NEVER."""
    return next((number for number, step in enumerate(found) if holds(step)), NEVER)


def main() -> Result:
    """Carry a hundred robots away, and let three hundred drive in peace."""
    prepare(ORDINARY)
    pairs = [(seed, CARRIED[(number + 1) % len(CARRIED)]) for number, seed in enumerate(CARRIED)]
    carried = in_processes(kidnapped, pairs, "kidnapped")
    left = in_processes(ordinary, ORDINARY, "ordinary")
    every = [step for _, found in carried for step in found] + [step for *_, found in left for step in found]
    densities = in_processes(clutter, CARRIED, "clutter")
    values: dict[str, Any] = {
        "kidnapped": summary([result for result, _ in carried]),
        "ordinary": {
            "drives": len(left),
            "alarms": sum(alarms for alarms, _, _ in left),
            "false alarms": sum(false for _, false, _ in left),
            "off by more than 0.15 m at the end": sum(drive[-1].error > RIGHT[0] for *_, drive in left),
        },
        "pictures until it is back": {
            "median": float(np.median([result.pictures for result, _ in carried])),
            "95 %": float(np.quantile([result.pictures for result, _ in carried], 0.95)),
        },
        "clutter": {kind: float(np.mean([each[kind] for each in densities])) for kind in CLUTTER},
        "ms a picture": {
            "with hypotheses": _times([step for step in every if step.kept]),
            "without": _times([step for step in every if not step.kept]),
        },
        "each": {str(seed): asdict(result) for (seed, _), (result, _) in zip(pairs, carried, strict=True)},
    }
    tables = (
        Table.of("carried away once", {each: {"": value} for each, value in values["kidnapped"].items()}),
        Table.of("pictures until it is back", {"": values["pictures until it is back"]}),
        Table.of("clutter of a stop, per m^2 and of lines per m", {"": values["clutter"]}),
        Table.of("ordinary drives", {"": values["ordinary"]}),
        Table.of("time of the SLAM algorithm for a picture, ms of one core", values["ms a picture"]),
    )
    return Result("kidnapping", values, tables)


def summary(found: Sequence[Kidnapping]) -> dict[str, float]:
    """Return how many robots noticed and were back in time, and their errors."""
    error = np.array([each.error for each in found])
    return {
        "drives": len(found),
        "noticed at once": sum(each.noticed == 1 for each in found),
        f"noticed within {SOON} stops": sum(each.noticed <= SOON for each in found),
        f"back within {MORE} more": sum(each.back <= MORE for each in found),
        "both, and no alarm before": sum(each.success for each in found),
        "error then, median (m)": float(np.median(error)),
        "95 %": float(np.quantile(error, 0.95)),
        "worst": float(error.max()),
        "stops sure of a wrong pose": sum(each.wrong for each in found),
        "off by more than 0.15 m at the end": sum(each.end > RIGHT[0] for each in found),
    }


def _times(found: Sequence[Step]) -> dict[str, float]:
    each = np.array([step.milliseconds for step in found])
    return {
        "stops": len(each),
        "median": float(np.median(each)),
        "95 %": float(np.quantile(each, 0.95)),
        "worst": float(each.max()),
    }
