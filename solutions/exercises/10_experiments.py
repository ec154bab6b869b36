"""Declare the exercises of lesson 10, experiments: cases, known mistakes, and alternative solutions."""

from __future__ import annotations

from itertools import product
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.colours import GREEN, YELLOW
from nao_course.exercises import All, Case, Close, Exercise, LessonPlan, Property, Question, Sibling, Written
from nao_course.geometry import Pose
from nao_course.instructor.authoring.mistakes import catalogue
from nao_course.lessons.experiments.intervals import Interval, case_of, each_once
from nao_course.lessons.experiments.personal import personal_numbers
from nao_course.sim import NAO_V4, CameraView
from nao_course.student import earlier

Array = npt.NDArray[Any]

color_labels = earlier("01:color_labels")
white_threshold = earlier("01:white_threshold")
find_corners = earlier("03:find_corners")
measurement_covariance = earlier("04:measurement_covariance")
measurement_jacobian_pose = earlier("05:measurement_jacobian_pose")


# --- 10.1 paying_precision ---
PAYING_PRECISION = Exercise(
    name="paying_precision",
    points=1,
    public=lambda: [
        Case((-1.333, 5.0, 1.0), "the paper's table"),
        Case((0.0, 1.0, 1.0), "a hit that only avoids the cost of a miss"),
        Case((-2.0, 3.0, 0.0), "misses that cost nothing"),
        Case((-1.0, 18.0, 1.0), "expensive false reports"),
    ],
    hidden=lambda rng: [
        Case((-float(rng.uniform(0.2, 3)), float(rng.uniform(1, 9)), float(rng.uniform(0.2, 3))))
        for _ in range(6)
    ],
    comparison=Close(),
    hints=(
        "With precision p, a report costs hit with probability p and false otherwise. Reporting nothing costs missed with probability p and nothing otherwise. For which p are the two expected costs equal?",
        "Solve p * hit + (1 - p) * false = p * missed for p.",
    ),
    sibling=Sibling(
        "Write the expected cost of both decisions as a function of the probability, and solve for the probability at which they are equal: here an insurance with a deductible.",
        """
        premium, damage, deductible = 30.0, 800.0, 200.0
        p = premium / (damage - deductible)  # premium + p deductible = p damage
        print(p, premium + p * deductible, p * damage)
        """,
        "0.05 40.0 40.0",
    ),
    mistakes=catalogue("""
        the miss that is spared forgotten: (false + missed - hit) => (false - hit)
            You compare a report with no cost at all. If there is a corner, reporting nothing costs `missed`.
        no brackets: false / (false + missed - hit) => false / false + missed - hit
            The denominator needs brackets, because division comes before addition: false / (false + missed - hit).
        each point that is not reported is missed: return false / (false + missed - hit) => return (false - missed) / (false - hit)
            You charge `missed` for each point that is not reported. It is only due if there is a corner, with probability p.
        costs as numbers of reports: return false / (false + missed - hit) => return hit / (hit + false)
            You use the costs as if they were numbers of hits and of false reports. Compare the expected costs of reporting and of not reporting.
        a fixed number: + return 0.68
            Your function always returns the same number. Compute it from hit, false and missed.
        the hit in the numerator: return false => return (false - hit)
            Your numerator contains the cost of a hit. Set the expected costs equal, p hit + (1 - p) false = p missed, and solve for p: the numerator is `false`.
        the hit forgotten: (false + missed - hit) => (false + missed)
            Your formula does not contain the cost of a hit. If there is a corner, a report costs `hit`, not 0.
        the paper's costs always: + hit, false, missed = -1.333, 5.0, 1.0
            Your function uses the paper's costs and ignores its arguments.
        signs lost: missed - hit => missed + hit
            A hit has a negative cost. It makes reporting better, so it is subtracted: false + missed - hit.
        sign of the miss: false + missed - hit => false - missed - hit
            The sign of `missed` is the wrong way round. A missed corner makes reporting better, so its cost is added: false + missed - hit.
        both signs changed: missed - hit => hit - missed
            The signs of `hit` and `missed` are the wrong way round. A missed corner and a cheap hit both make reporting better: false + missed - hit.
        reciprocal: return false / (false + missed - hit) => return (false + missed - hit) / false
            You return the reciprocal, which is above 1. A precision is at most 1.
        the other part: return false => return (missed - hit)
            This is the fraction of reports that may be false. Precision is the fraction that is right.
        the miss in the numerator: return false => return missed
            Your numerator is the cost of a miss. Set the expected costs equal, p hit + (1 - p) false = p missed, and solve for p: the numerator is the cost of a false report.
        per cent: return false => return 100 * false
            Your function returns a percentage. A precision is a number from 0 to 1.
        false ones for each right one: (false + missed - hit) => (missed - hit)
            This is the number of false reports per hit that breaks even, or its inverse. The precision is the number of hits divided by the number of all reports.
        rounded: false / (false + missed - hit) => round(false / (false + missed - hit), 2)
            Your answer is right but rounded. Return all digits, and round only when you print.
    """),
    alternatives={
        "by the gain": lambda hit, false, missed: 1 / (1 + (missed - hit) / false),
        "as a root": lambda hit, false, missed: float(np.roots([hit - false - missed, false])[0]),
        "one less": lambda hit, false, missed: 1 - (missed - hit) / (missed - hit + false),
    },
)


# --- 10.2 detection_cost ---
def _sorted(detected: Array, truth: Array, tolerance: float) -> float:
    apart = {(i, j): np.hypot(*(p - q)) for i, p in enumerate(detected) for j, q in enumerate(truth)}
    hits: dict[int, int] = {}
    for i, j in sorted(apart, key=apart.__getitem__):
        if apart[i, j] <= tolerance and i not in hits and j not in hits.values():
            hits[i] = j
    return 5.0 * len(detected) + len(truth) - 7.333 * len(hits)


def _masked(detected: Array, truth: Array, tolerance: float) -> float:
    apart = np.ma.masked_greater(np.sqrt(((truth[:, None] - detected) ** 2).sum(axis=-1)), tolerance)
    hits = 0
    while apart.count():
        row, column = np.unravel_index(np.ma.argmin(apart), apart.shape)
        apart[row, :] = apart[:, column] = np.ma.masked
        hits += 1
    return 5.0 * len(detected) + 1.0 * len(truth) - 7.333 * hits


def _recursive(detected: Array, truth: Array, tolerance: float) -> float:
    near = [(np.hypot(*(a - b)), i, j) for i, a in enumerate(detected) for j, b in enumerate(truth)]
    if not near or min(near)[0] > tolerance:
        return 5 * len(detected) + len(truth)
    _, i, j = min(near)
    return -1.333 + _recursive(np.delete(detected, i, axis=0), np.delete(truth, j, axis=0), tolerance)


def _points(*points: tuple[float, float]) -> Array:
    return np.array(points, dtype=float).reshape(-1, 2)


_TRUTH = _points((40, 30), (100, 60), (160, 90))


def _cost_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for tolerance in (3.0, 8.0, 8.0, 16.0):
        truth = rng.uniform(0, 90, (int(rng.integers(2, 7)), 2))
        near = truth[: int(rng.integers(1, len(truth) + 1))] + rng.uniform(-0.7, 0.7, 2) * tolerance
        detected = rng.permutation(np.vstack([near, rng.uniform(0, 90, (int(rng.integers(0, 4)), 2))]))
        cases.append(Case((detected, truth, tolerance)))
    one = rng.uniform(20, 60, 2)
    reach = float(rng.uniform(4, 9))
    turn = float(rng.uniform(-3, 3))
    across = reach * np.array([np.cos(turn), np.sin(turn)])
    along = one + np.outer((1.8, 0.75, 0.0, 1.25), across)
    return [
        *cases,
        Case((along[:2], along[2:], reach)),
        Case((one + np.outer((0, 0.8), across), one + np.outer((0.9, -0.95), across), reach)),
        Case((along[1::-1], along[2:], reach)),
        Case((along[1::-1], along[:1:-1], reach)),
        Case((one + [(0, 0.1 * reach), (0, -1.1 * reach)], one + [(0, 0), (0, 1.2 * reach)], reach)),
        Case((along[2:] - 0.01, along[:2], reach)),
        Case((along[:1:-1] - 0.01, along[:2], reach)),
        Case((np.floor(one)[None] + (np.ceil(reach) + 0.3, 0), np.floor(one)[None], float(np.ceil(reach)))),
        Case((np.vstack([one, one + 1, one - 1]), one[None] + 0.5, reach)),
        Case((one + [(0.9 * reach, 0), (0, 0)], one + [(0.1, 0), (1.7 * reach, 0)], reach)),
        Case((one[None] + (0.75 * reach, 0.75 * reach), one[None], reach)),
        Case((np.round(one)[None] + (3, 4), np.round(one)[None], 5.0)),
        Case((one[None] + reach * np.array([0.6, 0.8]), np.vstack([one - 60, one]), 1.2 * reach)),
        Case((np.zeros((0, 2)), rng.uniform(0, 90, (int(rng.integers(1, 6)), 2)), reach)),
        Case((rng.uniform(0, 90, (int(rng.integers(1, 6)), 2)), np.zeros((0, 2)), reach)),
        Case((np.zeros((0, 2)), np.zeros((0, 2)), reach)),
    ]


DETECTION_COST = Exercise(
    name="detection_cost",
    points=2,
    stars=2,
    public=lambda: [
        Case((_points((42, 30), (100, 63), (200, 20)), _TRUTH, 8.0), "two hits, one false, one missed"),
        Case((_points((42, 30), (38, 31), (41, 27)), _TRUTH, 8.0), "three reports at one corner"),
        Case(
            (_points((107, 60), (101, 60)), _points((100, 60), (112, 60)), 8.0), "two corners near each other"
        ),
        Case((_points((46, 38), (100, 68)), _TRUTH, 8.0), "one 10 px away, one just within"),
        Case((_points((46, 37)), _TRUTH, 8.0), "6 px across and 7 down"),
        Case((_points((46, 35)), _TRUTH, 8.0), "6 px across and 5 down"),
        Case((_points(), _TRUTH, 8.0), "nothing reported"),
        Case((_points((10, 10), (20, 20)), _points(), 8.0), "nothing there"),
        Case((_points(), _points(), 8.0), "nothing at all"),
        Case((_points((60, 40)), _points((40, 60)), 8.0), "row and column changed"),
        Case((_points((0, 0)), _points((3, 0)), 2.0), "another tolerance"),
        Case((_points((50, 50)), _points((46, 50), (54, 51)), 8.0), "one report between two corners"),
        Case((_points((0, 0), (6, 0)), _points((7, 0), (-7.5, 0)), 8.0), "the closest pair first"),
        Case(
            (_points((14.5, 0), (6, 0)), _points((0, 0), (10, 0)), 8.0),
            "the closest pair first, and one is left",
        ),
        Case((_points((6, 0), (14.5, 0)), _points((10, 0), (0, 0)), 8.0), "one is left over"),
        Case((_points((0, 1), (0, -9)), _points((0, 0), (0, 10)), 8.0), "one close, one far"),
        Case((_points((8.4, 0)), _points((0, 0)), 8.0), "0.4 px too far"),
    ],
    hidden=_cost_hidden,
    comparison=Close(),
    hints=(
        "First compute all distances, an (N, K) array: np.linalg.norm(detected[:, None] - truth, axis=2). As long as the smallest distance is within the tolerance, count a hit and remove its row and its column.",
        "np.unravel_index(distances.argmin(), distances.shape) returns the row i and the column j of the smallest distance; set distances[i, :] and distances[:, j] to np.inf to remove them. An empty array has no argmin, so test distances.size first. Reports without a hit are false, and corners without a hit are missed.",
    ),
    sibling=Sibling(
        "The closest pair is matched first, then both are removed, and so on as long as the smallest distance is small enough: here socks by their length.",
        """
        import numpy as np

        left, right = np.array([20.0, 24.0, 31.0]), np.array([23.5, 20.5])
        table, alone = np.abs(left[:, None] - right), [20, 24, 31]
        while table.min(initial=np.inf) < 2:
            row, column = divmod(int(table.argmin()), table.shape[1])
            print(f"{left[row]:g} and {right[column]:g}")
            table[row] = np.inf
            table[:, column] = np.inf
            alone.remove(left[row])
        print("alone:", alone)
        """,
        """
        20 and 20.5
        24 and 23.5
        alone: [31]
        """,
    ),
    mistakes=catalogue("""
        doubles are hits: hits = 0 => taken = []
            np.delete(np.delete(apart, report, axis=0), corner, axis=1) => np.delete(apart, report, axis=0)
            hits += 1 => taken.append(corner)
            len(truth) - hits => len(truth) - len(set(taken))
            hits =>> len(taken)
            You count several reports at one corner as hits. Each corner can be hit only once, so the other reports are false.
        one report hits two: hits = 0 => taken = []
            np.delete(np.delete(apart, report, axis=0), corner, axis=1) => np.delete(apart, corner, axis=1)
            hits += 1 => taken.append(report)
            len(detected) - hits => len(detected) - len(set(taken))
            hits =>> len(taken)
            You count one report near two corners as two hits. Each report can be used only once.
        reports at one corner are all hits: np.delete(np.delete(apart, report, axis=0), corner, axis=1) => np.delete(apart, report, axis=0)
            Your function counts several reports at one corner as hits, and the corner several times. A corner that was hit is no longer free, so the other reports near it are false.
        a report hits all corners near it: np.delete(np.delete(apart, report, axis=0), corner, axis=1) => np.delete(apart, corner, axis=1)
            Your function counts one report near two corners as two hits, and the report twice. A report that was used is no longer free, so the other corner is missed.
        each report on its own: hits = 0 => hits = sum(bool(row.min() <= tolerance) for row in apart)
            + return -1.333 * hits + 5 * (len(detected) - hits) + (len(truth) - hits)
            You search the nearest corner of each report on its own, so several reports hit the same corner. Use each corner only once. A picture without corners needs a test of its own, because there is no nearest corner.
        each report on its own, no empty array: hits = 0 => hits = (apart.min(axis=1) <= tolerance).sum()
            + return -1.333 * hits + 5 * (len(detected) - hits) + (len(truth) - hits)
            Two things are wrong. You test each report on its own, so several reports hit the same corner: use each corner only once. And your function fails without corners, because an empty array has no smallest value.
        each corner on its own, no empty array: hits = 0 => hits = (apart.min(axis=0) <= tolerance).sum()
            + return -1.333 * hits + 5 * (len(detected) - hits) + (len(truth) - hits)
            Two things are wrong. You test each corner on its own, so one report can hit two corners: use each report only once. And your function fails without reports, because an empty array has no smallest value.
        each side on its own, no empty array: hits = 0 => hits = (apart.min(axis=1) <= tolerance).sum()
            + return -1.333 * hits + 5 * (len(detected) - hits) + (apart.min(axis=0) > tolerance).sum()
            Two things are wrong. You test each report and each corner on its own, so several reports can hit one corner: make pairs, and use each point only once. And your function fails without reports or corners, because an empty array has no smallest value.
        each side on its own, no empty array, hits by corners: hits = 0 => hits = (apart.min(axis=0) <= tolerance).sum()
            + return -1.333 * hits + 5 * (apart.min(axis=1) > tolerance).sum() + (len(truth) - hits)
            Two things are wrong. You test each corner and each report on its own, so extra reports at a corner cost nothing: make pairs, and use each point only once. And your function fails without reports or corners, because an empty array has no smallest value.
        every close pair: hits = 0 => hits = (apart <= tolerance).sum()
            + return -1.333 * hits + 5 * (len(detected) - hits) + (len(truth) - hits)
            You count all pairs within the tolerance, so one point can belong to several pairs. Use each report and each corner only once.
        each side on its own: hits = 0 => close = apart <= tolerance
            + return -1.333 * close.any(axis=1).sum() + 5 * (~close.any(axis=1)).sum() + (~close.any(axis=0)).sum()
            You test each report and each corner on its own for a partner, so several reports can hit the same corner. Make pairs: after each hit, its report and its corner are no longer free.
        each side on its own, hits by corners: hits = 0 => close = apart <= tolerance
            + return -1.333 * close.any(axis=0).sum() + 5 * (~close.any(axis=1)).sum() + (~close.any(axis=0)).sum()
            You test each corner and each report on its own for a partner, so one report can hit several corners, and extra reports at a corner cost nothing. Make pairs: after each hit, its report and its corner are no longer free.
        a second report is free: hits = 0 => false = sum(not row.size or row.min() > tolerance for row in apart)
            + hits = len({row.argmin() for row in apart if row.size and row.min() <= tolerance})
            + return -1.333 * hits + 5 * false + (len(truth) - hits)
            In your function a second report at a corner that was already hit costs nothing. It is false, too: the number of false reports is len(detected) - hits.
        more hits than reports: hits = 0 => hits = (apart <= tolerance).any(axis=0).sum()
            + return -1.333 * hits + 5 * max(len(detected) - hits, 0) + (len(truth) - hits)
            In your function one report near two corners is two hits, so there can be more hits than reports; max(..., 0) hides this. Use each report only once.
        the nearest partner only: hits = 0 => hits = len({row.argmin() for row in apart if row.size and row.min() <= tolerance})
            + return -1.333 * hits + 5 * (len(detected) - hits) + (len(truth) - hits)
            You only try the nearest partner of a point. If this partner is taken, another one within the tolerance may still be free. After each hit, take the closest of all remaining pairs.
        the smallest of an empty array: axis=2) => axis=2)
            + apart.min()
            Your function fails if there are no reports or no corners, because an empty array has no smallest value. Test for this case first, for example with distances.size.
        no corner in the picture: axis=2) => axis=2)
            + apart.min(initial=np.inf) if not len(detected) else apart.min()
            Your function fails if there are reports but no corners, because an empty array has no smallest value. In this case all reports are false.
        the smallest when no pair is left: while apart.size and apart.min() => while apart.min()
            Your loop fails when no pair is left, because an empty array has no smallest value. Test the size of the distances first.
        in the order of the reports: np.unravel_index(apart.argmin(), apart.shape) => np.argwhere(apart <= tolerance)[0]
            You assign corners to the reports in the order of the reports, even if another report is closer. Start with the closest pair of all, so that the order does not matter.
        each report in turn: report, corner = np.unravel_index(apart.argmin(), apart.shape) => report = (apart <= tolerance).any(axis=1).argmax()
            + corner = apart[report].argmin()
            You go through the reports and give each one the closest free corner. Another pair may be closer, so always take the closest of all remaining pairs.
        each corner in turn: report, corner = np.unravel_index(apart.argmin(), apart.shape) => corner = (apart <= tolerance).any(axis=0).argmax()
            + report = apart[:, corner].argmin()
            You go through the corners and give each one the closest free report. Another pair may be closer, so always take the closest of all remaining pairs.
        as many pairs as there can be: hits = 0 => from scipy.optimize import linear_sum_assignment
            + pairs = linear_sum_assignment(np.where(apart > tolerance, 1e6, apart))
            + return 5.0 * len(detected) + len(truth) - 7.333 * (apart[pairs] <= tolerance).sum()
            You find the largest possible number of pairs. This exercise takes the closest pairs first, even if a report then stays without a partner.
        the smallest sum of distances: hits = 0 => from scipy.optimize import linear_sum_assignment
            + return 5.0 * len(detected) + len(truth) - 7.333 * (apart[linear_sum_assignment(apart)] <= tolerance).sum()
            You minimise the sum of the distances. This exercise takes the closest pairs first, even if a report then stays without a partner.
        whole pixels: + detected, truth = np.trunc(detected), np.trunc(truth)
            You cut the coordinates to whole pixels. Corners also lie between pixels, so use the coordinates as they are.
        less than the tolerance: apart.min() <= => apart.min() <
            A report at a distance of exactly the tolerance is a hit, so compare with <=.
        a square for a circle: np.linalg.norm(detected[:, None] - truth, axis=2) => np.abs(detected[:, None] - truth).max(axis=2)
            You compare u and v separately with the tolerance, which makes it a square. Compare the distance np.hypot(du, dv) with it.
        squares against the tolerance: axis=2) => axis=2) ** 2
            You compare squared distances with the tolerance. Take the square root, or square the tolerance, too.
        along both axes added: np.linalg.norm(detected[:, None] - truth, axis=2) => np.abs(detected[:, None] - truth).sum(axis=2)
            You add the distances along u and along v. The straight distance is np.hypot(du, dv).
        the tolerance is always 8: + tolerance = 8.0
            Your tolerance is always 8. Use the argument `tolerance`.
        false and missed changed: 5 * (len(detected) - hits) + (len => (len(detected) - hits) + 5 * (len
            Your function charges 5 for a missed corner and 1 for a false report. A false report costs 5 and a missed corner 1.
        a gain for a cost: -1.333 => 1.333
            You add 1.333 for a hit. A hit costs -1.333, so it makes the sum smaller.
        four thirds: -1.333 => -4 / 3
            You use 4/3 for a hit. Table 6.1 prints 1.333, and later in this lesson the difference matters.
        the mean: return -1.333 => total = -1.333
            + return total / max(len(detected) + len(truth) - hits, 1)
            You return a mean. The cost of a picture is a sum, so do not divide it.
        misses free: (len(truth) - hits) => 0
            Missed corners cost nothing in your function. Each corner without a report costs 1.
        as many missed as reports are lacking: (len(truth) - hits) => max(len(truth) - len(detected), 0)
            You count a corner as missed only if there are fewer reports than corners. A false report finds no corner, so subtract the number of hits: len(truth) - hits.
        all reports false: (len(detected) - hits) => len(detected)
            You count all reports as false, including the hits. Subtract the number of hits.
        all corners missed: (len(truth) - hits) => len(truth)
            You count all corners as missed, including the corners that were hit. Subtract the number of hits.
    """),
    alternatives={"sorted pairs": _sorted, "a masked array": _masked, "by recursion": _recursive},
    equivalents={
        "apart = np.linalg.norm(detected[:, None] - truth, axis=1 - 2)": "axis -1 is the last one, which is 2",
        "apart = np.linalg.norm(truth - detected[:, None], axis=2)": "the sign of a difference does not change its length",
    },
)


# --- 10.3 grid_search ---
def _labels(picture: Any, beta: float) -> Array:
    white = white_threshold(float(np.mean([picture.max(axis=2), picture.min(axis=2)])), beta)
    return np.asarray(color_labels(picture, GREEN, YELLOW, white))


def _scene(rng: np.random.Generator, height: int, width: int) -> tuple[Array, Array]:
    """Draw a carpet with a bright corner, a dim corner and a dashed line; what one setting finds counts as true corners."""
    picture = np.empty((height, width, 3), dtype=np.uint8)
    picture[:] = (60, 160, 60)
    u, v = int(rng.integers(10, 16)) * width // 64, int(rng.integers(13, 17)) * height // 48
    right, low = width - int(rng.integers(3, 8)), height - int(rng.integers(2, 6))
    for start, end, level in (
        ((u, v), (right, v + 3), 240),
        ((u, v), (u + 2, low), 240),
        ((u + 22 * width // 64, v - 4), (u + 20 * width // 64, low), 182),
    ):
        cv2.line(picture, start, end, (level, level, level), 3 * height // 48)
    for column in range(u + 8 * width // 64, right, 12 * width // 64):
        picture[v - 4 : v + 8, column : column + int(rng.integers(2, 4))] = (60, 160, 60)
    found = np.asarray(find_corners(_labels(picture, 100.0), 6.0, 8.0))
    off = np.array([[0.93], [1.06]])[: len(found)] * 8 * height / 240 * np.array([[0.8, -0.6]])
    return picture, np.vstack([found[:2] + off, [[width - 5.0, height - 5.0]]])


def _grid(scenes: Any, betas: Any, gaps: Any, lengths: Any) -> Any:
    """Search with the settings in the outer loop and the scenes in the inner loop."""

    def cost(picture: Array, corners: Array, beta: float, *others: float) -> float:
        return _masked(find_corners(_labels(picture, beta), *others), corners, len(picture) / 30)

    settings = product(betas, gaps, lengths)
    return {setting: np.array([cost(*scene, *setting) for scene in scenes]) for setting in settings}


def _grid_in_lists(scenes: Any, betas: Any, gaps: Any, lengths: Any) -> Any:
    costs: dict[Any, Any] = {setting: [] for setting in product(betas, gaps, lengths)}
    for picture, corners in scenes:
        labels = {beta: _labels(picture, beta) for beta in betas}
        for beta, *others in costs:
            found = find_corners(labels[beta], *others)
            costs[beta, *others].append(_sorted(found, corners, 8 / 240 * len(picture)))
    return costs


def _grid_as_array(scenes: Any, betas: Any, gaps: Any, lengths: Any) -> Any:
    costs = [list(_grid([scene], betas, gaps, lengths).values()) for scene in scenes]
    return dict(zip(product(betas, gaps, lengths), np.array(costs)[..., 0].T, strict=True))


def _grid_public() -> list[Case]:
    rng = np.random.default_rng(103)
    scenes = [_scene(rng, 48, 64) for _ in range(4)]
    narrow = _scene(rng, 40, 48)
    cases = [
        Case((scenes[:3], [100, 150], [1, 6], [8, 20]), "three scenes, eight settings"),
        Case(([narrow, scenes[0]], [100], [6], [8, 20]), "pictures of two shapes"),
        Case((scenes[1:], [150], [2, 6, 4], [8]), "one beta, three gaps"),
        Case((scenes[:1], [100], [6], [16]), "one scene, one setting"),
    ]
    for each, betas, gaps, lengths in (case.args for case in cases):
        _grid(each, betas, lengths, gaps)  # find_corners with gap and length exchanged is recorded, too
    return cases


def _grid_hidden(rng: np.random.Generator) -> list[Case]:
    small = [_scene(rng, 48, 64) for _ in range(4)]
    large = [_scene(rng, 120, 160) for _ in range(3)]
    return [
        Case((small, [100, 120, 150], [1, 6], [8, 20])),
        Case((large, [100, 150], [2, 12], [15, 40])),
        Case((large[:1], [100], [6], [15])),
        Case(([_scene(rng, 48, 96), _scene(rng, 60, 64)], [100, 150], [6], [8, 20])),
        Case((small[:2] + large[:1], [150, 100], [1, 6], [8])),
    ]


GRID_SEARCH = Exercise(
    name="grid_search",
    points=3,
    stars=2,
    public=_grid_public,
    hidden=_grid_hidden,
    comparison=Close(),
    uses=["detection_cost", "01:color_labels", "01:white_threshold", "03:find_corners"],
    hints=(
        "product(betas, gaps, lengths) yields all settings. For each of them, go through the scenes: compute the labels, find the corners, and call detection_cost.",
        "Start with table = {setting: [] for setting in product(betas, gaps, lengths)}. If the outer loop goes over the scenes and the next one over the betas, the labels are computed only once for each beta: table[beta, gap, length].append(...). Convert each list with np.array at the end.",
    ),
    sibling=Sibling(
        "The expensive step depends on one setting only, so it stands in the outer loop and is done once for each value of that setting: here an oven is heated.",
        """
        heated = 0
        table = {(celsius, minutes): [] for celsius in (180, 220) for minutes in (10, 20, 30)}
        for dough in (3, 4):
            for celsius in (180, 220):
                heated += 1  # not once more for each number of minutes
                for minutes in (10, 20, 30):
                    table[celsius, minutes].append(celsius * minutes // dough)
        print(heated, table[220, 20], len(table))
        """,
        "4 [1466, 1100] 6",
    ),
    mistakes=catalogue("""
        means only: np.array(costs) => float(np.mean(costs))
            You return one mean for each setting. Return the costs of all scenes, because the uncertainty of a mean can only be computed from them.
        means only, always 8 pixels: np.array(costs) => float(np.mean(costs))
            8 * len(picture) / 240 => 8.0
            Two things are wrong. Return the costs of all scenes and not their mean. And the tolerance should be proportional to the picture's height: 8 px for 240 rows.
        the number of a scene: for picture, corners in scenes: => for number, scene in enumerate(scenes):
            tolerance = 8 * len(picture) / 240 => picture = scene.max(axis=2)
            If the line uses a scene as a picture: each scene is a pair. Unpack it, for picture, corners in scenes.
        sums only: np.array(costs) => float(np.sum(costs))
            You return one sum for each setting. Return the costs of all scenes, because the uncertainty of a mean can only be computed from them.
        one cost for each setting: .append(detection_cost(found, corners, tolerance)) => = detection_cost(found, corners, tolerance)
            You keep only the cost of the last scene for each setting. Append the costs of all scenes to a list.
        a new list for each scene: .append(detection_cost(found, corners, tolerance)) => = [detection_cost(found, corners, tolerance)]
            You start a new list for each scene, so only the last scene's cost is left. Make the list once for each setting, before the loop over the scenes.
        gap and length changed: (labels, gap, length) => (labels, length, gap)
            You pass length and gap to find_corners in the wrong order. Its second argument is the gap, its third the length.
        values not handed on: (labels, gap, length) => (labels)
            You call find_corners without gap and length, so the costs do not depend on them. Pass both.
        beta not handed on: labels = label(picture, beta) => labels = label(picture, 120.0)
            Your costs do not depend on beta. Pass it to label as its second argument.
        the first beta for all: labels = label(picture, beta) => labels = label(picture, betas[0])
            You compute the labels with one beta and use them for all settings. Compute new labels for each beta.
        one tolerance for all scenes: 8 * len(picture) / 240 => 8 * len(scenes[0][0]) / 240
            You use the first picture's tolerance for all scenes. Compute it from the height of each picture.
        always 8 pixels: 8 * len(picture) / 240 => 8.0
            Your tolerance is 8 px in every picture. It should be proportional to the height: 8 px for 240 rows.
        by the width: len(picture) / 240 => picture.shape[1] / 240
            Your tolerance is proportional to the picture's width. It should be proportional to its height: 8 px for 240 rows.
        by the width of 320: len(picture) / 240 => picture.shape[1] / 320
            You use 8 px for 320 columns, which is the same only for pictures with an aspect ratio of 4:3. Use 8 px for 240 rows.
        upside down: len(picture) / 240 => 240 / len(picture)
            Your tolerance decreases with the height. It should be proportional to it: 8 * H / 240.
        length and gap from product: for gap, length in product => for length, gap in product
            The names in your loop, or your keys, are in another order than what product yields. product(gaps, lengths) yields (gap, length), and product(betas, gaps, lengths) yields (beta, gap, length), which is the order of the keys.
        whole pixels: / 240 => // 240
            You round the tolerance to a whole number. For 48 rows it is 8 * 48 / 240 = 1.6 px.
        one picture's labels for all: labels = label(picture, beta) => labels = label(scenes[0][0], beta)
            You use the labels of the first picture for all scenes. Compute the labels of each picture.
        truth and reports changed: (found, corners, tolerance) => (corners, found, tolerance)
            You call detection_cost with its arguments exchanged. The first is what was found, the second the true corners.
        side by side: product(betas, gaps, lengths) => zip(betas, gaps, lengths)
            product(gaps, lengths) => [each[1:] for each in table if each[0] == beta]
            You combine the first beta with the first gap and the first length, and so on. Use itertools.product to get all combinations.
        gaps and lengths side by side: for gap, length in product => for gap, length in zip
            zip pairs the gaps and lengths element by element. Use product(gaps, lengths) to get all combinations.
        another order of the key: {setting: np.array(costs) for setting, costs => {(b, n, g): np.array(costs) for (b, g, n), costs
            Your keys are (beta, length, gap). They should be (beta, gap, length).
        the key from the last to the first: {setting: np.array(costs) for setting, costs => {(n, g, b): np.array(costs) for (b, g, n), costs
            Your keys are (length, gap, beta). They should be (beta, gap, length).
        the key with beta last: {setting: np.array(costs) for setting, costs => {(g, n, b): np.array(costs) for (b, g, n), costs
            Your keys are (gap, length, beta). They should be (beta, gap, length).
        the key with the gap first: {setting: np.array(costs) for setting, costs => {(g, b, n): np.array(costs) for (b, g, n), costs
            Your keys are (gap, beta, length). They should be (beta, gap, length).
        an array: {setting: np.array(costs) for setting, costs in table.items()} => np.array(list(table.values()))
            You return the costs without their settings. Return a dict, in which table[beta, gap, length] contains the costs of one setting.
        a list that goes on: return {setting: np.array(costs) for setting, costs in table.items()} => costs = sum(table.values(), [])
            + return {setting: np.array(costs[: (i + 1) * len(scenes)]) for i, setting in enumerate(table)}
            The costs of each setting also contain the costs of the settings before it. Start a new list for each setting.
        the best only: {setting: np.array(costs) for setting, costs in table.items()} => min(table, key=lambda each: np.mean(table[each]))
            You return only the best setting. Return the whole table; the best setting is chosen later.
    """),
    alternatives={
        "settings outside": _grid,
        "scenes outside, lists": _grid_in_lists,
        "an array first": _grid_as_array,
    },
    equivalents={
        "return {setting: costs for setting, costs in table.items()}": "a list of costs is accepted, too",
        "return color_labels(picture, (90.0, 160.0), (44.0, 68.0), white_threshold(beta, lightness.mean()))": "b + (255 - b) m / 255 is the same for m and b changed",
        "lightness = picture.max(axis=1 - 2) / 2 + picture.min(axis=2) / 2": "axis -1 is the last one, which is 2",
        "lightness = picture.max(axis=2) / 2 + picture.min(axis=1 - 2) / 2": "axis -1 is the last one, which is 2",
    },
    seconds=20.0,
)


# --- 10.4 bootstrap_interval ---
def _boot(values: Any, probability: float, rng: np.random.Generator) -> Any:
    means = [np.mean(rng.choice(values, len(values))) for _ in range(2500)]
    return tuple(np.quantile(means, [(1 - probability) / 2, (1 + probability) / 2]))


def _boot_counts(values: Any, probability: float, rng: np.random.Generator) -> Any:
    n = len(values)
    means = rng.multinomial(n, np.full(n, 1 / n), 4000) @ np.asarray(values, dtype=float) / n
    return list(np.percentile(means, [50 - 50 * probability, 50 + 50 * probability]))


def _boot_sorted(values: Any, probability: float, rng: np.random.Generator) -> Any:
    n, draws = len(values), 3000
    means = sorted(sum(values[i] for i in rng.integers(0, n, n)) / n for _ in range(draws))
    return means[round(draws * (1 - probability) / 2)], means[round(draws * (1 + probability) / 2) - 1]


def _skewed(rng: np.random.Generator, n: int) -> Array:
    return np.concatenate([rng.normal(0, 0.5, n - n // 5), rng.uniform(10, 20, n // 5)])


def _one_high(rng: np.random.Generator) -> Array:
    """Return 20 costs of which one is high: the distribution of their mean is far from a normal one."""
    return np.append(rng.normal(0, 0.3, 19), rng.uniform(12, 18))


def _boot_public() -> list[Case]:
    rng = np.random.default_rng(104)
    return [
        case_of(_skewed(rng, 20), 0.95, "20 skewed costs, 95 %"),
        case_of(rng.normal(-1, 2, 30), 0.8, "30 costs, 80 %"),
        case_of(_skewed(rng, 10), 0.55, "10 skewed costs, 55 %"),
        case_of(np.full(6, 2.5), 0.9, "six equal costs"),
        case_of(rng.normal(1, 3, 12), 0.5, "12 costs, 50 %"),
        case_of(_one_high(rng), 0.9, "20 costs, one of them high, 90 %"),
    ]


BOOTSTRAP_INTERVAL = Exercise(
    name="bootstrap_interval",
    points=3,
    stars=2,
    public=_boot_public,
    hidden=lambda rng: [
        case_of(_skewed(rng, int(rng.integers(10, 40))), 0.95),
        case_of(rng.normal(float(rng.uniform(-2, 2)), 1.0, 30), 0.8),
        case_of(rng.normal(3, 2, 56), 0.99),
        case_of(-_skewed(rng, 15), 0.7),
        case_of(rng.normal(1, 3, int(rng.integers(8, 30))), 0.4),
        case_of(_one_high(rng), 0.9),
    ],
    comparison=Interval(),
    driver="nao_course.lessons.experiments.intervals:with_generators",
    hints=(
        "One resample is rng.choice(values, len(values)). It draws with replacement, so some values appear twice and some not at all. Compute the means of thousands of resamples.",
        "rng.choice(values, (2000, len(values))).mean(axis=1) returns the means of 2000 resamples. Half of 1 - probability lies below the lower end and half above the upper end; pass these two fractions to np.quantile.",
    ),
    sibling=Sibling(
        "Resamples with replacement show how much a result varies: here the standard deviation of a median.",
        """
        import numpy as np

        rng = np.random.default_rng(3)
        minutes = np.array([4.0, 7, 5, 9, 6, 30, 5, 8, 6, 7])
        medians = [np.median(rng.choice(minutes, 10)) for _ in range(3000)]
        print(f"median {np.median(minutes)}, standard deviation about {np.std(medians):.0f} minute")
        """,
        "median 6.5, standard deviation about 1 minute",
    ),
    mistakes=catalogue("""
        spread of the values: (2000, len(values)) => (2000, 1)
            Your interval describes single costs. Take the mean of each resample first, because the interval should describe the uncertainty of the mean.
        nothing drawn: np.quantile(means => np.quantile(values
            You return quantiles of the costs themselves, which describe single costs. Draw resamples and return quantiles of their means.
        a hundred resamples: (2000, => (100,
            The ends of your interval vary too much between generators. Draw at least 2000 resamples.
        without replacement: values[drawn].mean(axis=1) => rng.permuted(np.tile(values, (2000, 1)), axis=1).mean(axis=1)
            All your resamples have the same mean, because you draw without replacement and each contains every value once. Draw with replacement.
        choice without replacement: rng.integers(0, len(values), (2000, len(values))) => rng.choice(len(values), (2000, len(values)), replace=False)
            You draw with replace=False. A bootstrap draws with replacement, so leave this argument out.
        always 95 per cent: + probability = 0.95
            Your interval always contains 95 % of the means. Use the argument `probability`.
        half of the probability: (1 - probability) / 2 => probability / 2
            You leave out probability / 2 on each side. Leave out half of 1 - probability instead.
        about two standard deviations: np.quantile(means, [outside, 1 - outside]) => means.mean() - 1.96 * means.std(), means.mean() + 1.96 * means.std()
            You return the mean and 1.96 standard deviations on both sides. This holds for 95 % of a normal distribution only, and costs are skewed. Return quantiles of the means.
        from the smallest to the largest: [outside, 1 - outside] => [0, 1]
            Your interval contains all means, from the smallest to the largest. Leave out half of 1 - probability on each side.
        all of the rest on each side: (1 - probability) / 2 => 1 - probability
            You leave 1 - probability out on each side. Leave half of it out on each side.
        too much left out at the upper end: [outside, 1 - outside] => [outside, probability]
            Your upper end is the quantile `probability`, which leaves out 1 - probability above it. Leave out half of 1 - probability on each side.
        from the lowest on: [outside, 1 - outside] => [0, probability]
            Your interval starts at the smallest mean. Leave out half of 1 - probability on each side.
        a normal curve: + from scipy.stats import norm
            np.quantile(means, [outside, => values.mean() + values.std() / np.sqrt(len(values)) * norm.ppf([outside,
            These are the ends of a normal distribution with the standard error of the mean. Draw resamples with rng instead, because costs are skewed.
        a normal curve with noise: values[drawn].mean(axis=1) => rng.normal(values.mean(), values.std() / np.sqrt(len(values)), 2000)
            You draw means from a normal distribution. Draw resamples of the values and take their means, because costs are skewed.
        medians: values[drawn].mean(axis=1) => np.median(values[drawn], axis=1)
            You take the median of each resample. Take its mean.
        sums: .mean(axis=1) => .sum(axis=1)
            You take the sum of each resample. Divide it by the number of values to get the mean.
        one mean of all: .mean(axis=1) => .mean()
            You take one mean over all resamples together, so both ends are equal. Take the mean of each resample: .mean(axis=1).
        means over the resamples: .mean(axis=1) => .mean(axis=0)
            You average over the resamples, so nearly nothing of their variation is left. Take the mean of each resample: .mean(axis=1).
        smaller resamples: (2000, len(values)) => (2000, len(values) // 2)
            Your resamples have half as many values as the data, so their means vary too much. Draw len(values) values for each.
        always thirty: (2000, len(values)) => (2000, 30)
            Each of your resamples has 30 values, however many there are. Draw len(values) values for each.
        always ten: (2000, len(values)) => (2000, 10)
            Each of your resamples has 10 values, however many there are. Draw len(values) values for each.
        last value never drawn: rng.integers(0, len(values), => rng.integers(0, len(values) - 1,
            You never draw the last value. rng.integers(0, n) ends at n - 1, so n is len(values).
        five per cent at each end: (1 - probability) / 2 => 0.05
            You always leave out 5 % on each side. Leave out half of 1 - probability instead.
        larger resamples: (2000, len(values)) => (2000, 10 * len(values))
            Your resamples have more values than the data, as if there were more pictures. Draw len(values) values for each.
        from 0 to 1 and 0 to 100 mixed: np.quantile => np.percentile
            You pass fractions to np.percentile, which expects 0 to 100. Use np.quantile, which expects 0 to 1.
        np.random: + from itertools import cycle
            + own = bootstrap_interval.__dict__.setdefault("own", cycle(range(6)))
            + rng = np.random.default_rng(next(own))
            You do not use the argument rng. With np.random or a generator of your own, nobody can repeat the experiment.
        a fixed seed: + rng = np.random.default_rng(0)
            You replace rng by a generator with a fixed seed, so you always draw the same resamples. Draw with the argument rng.
        reflected: return low, high => return 2 * values.mean() - high, 2 * values.mean() - low
            You reflect the two ends at the mean, which is the basic bootstrap interval. The percentile interval has the quantiles themselves: return (low, high).
        the upper end first: return low, high => return high, low
            You return (high, low). Return the lower end first: (low, high).
        how far from the mean: return low, high => return low - values.mean(), high - values.mean()
            You return distances from the mean. Return the two ends themselves.
    """),
    alternatives={"one by one": _boot, "how often each is drawn": _boot_counts, "sorted": _boot_sorted},
    equivalents={
        "drawn = rng.integers(0, len(values), (2001, len(values)))": "at least 2000 are asked for",
        "drawn = rng.integers(0, len(values), (1999, len(values)))": "one resample less makes no difference that could be measured",
    },
)


# --- 10.5 possible_hits ---
def _as_printed(mean_cost: float, n_pictures: int, most_hits: int) -> Array:
    """Compare the printed forms of all means that nearby whole numbers give."""
    hits, more = np.arange(most_hits + 1)[:, None], np.array([-1, 0, 1])
    whole = np.floor(n_pictures * mean_cost + 1.333 * hits) + more
    printed = np.floor(1000 * (whole - 1.333 * hits) / n_pictures + 0.5 + 1e-7)
    below = np.ceil(1000 * (whole - 1.333 * hits) / n_pictures - 0.5 - 1e-7)
    wanted = round(1000 * mean_cost)
    return hits[(((printed == wanted) | (below == wanted)) & (whole >= 0)).any(axis=1), 0]


def _in_thousandths(mean_cost: float, n_pictures: int, most_hits: int) -> list[int]:
    """Count in thousandths with whole numbers, which must be within n / 2 of a multiple of 1000."""
    rests = [round(1000 * mean_cost) * n_pictures + 1333 * hits for hits in range(most_hits + 1)]
    off = [abs((rest + 500) % 1000 - 500) for rest in rests]
    return [hits for hits, rest in enumerate(rests) if 2 * off[hits] <= n_pictures and rest >= -500]


def _printed(rng: np.random.Generator, pictures: int) -> float:
    """Draw a mean as it would be printed, away from the limits of rounding."""
    while True:
        hits, rest = int(rng.integers(0, 3 * pictures)), int(rng.integers(0, 4 * pictures))
        mean = (rest - 1.333 * hits) / pictures
        if abs(1000 * mean % 1 - 0.5) > 0.05:
            return round(mean, 3)


def _possible_hidden(rng: np.random.Generator) -> list[Case]:
    sizes = (1, 2, 7, 15, 30, 30, 64)
    return [
        *(Case((_printed(rng, n), n, int(rng.integers(3 * n, 9 * n)))) for n in sizes),
        *(Case((round(float(rng.uniform(0, 6)), 3), 30, 240)) for _ in range(4)),
        Case((-_printed(rng, 5) - 1.0, 5, 40)),
        Case((-1.333, int(rng.integers(2, 7)), 20)),
        Case((_printed(rng, 700) + 4.0, 700, int(rng.integers(30, 60)))),
    ]


POSSIBLE_HITS = Exercise(
    name="possible_hits",
    points=3,
    stars=2,
    public=lambda: [
        Case((2.122, 30, 10), "2.122, up to 10 hits"),
        Case((2.122, 30, 40), "2.122, up to 40 hits"),
        Case((4.755, 30, 240), "4.755, thirty pictures"),
        Case((4.223, 30, 100), "4.223, thirty pictures"),
        Case((-1.333, 3, 8), "a negative mean of three pictures"),
        Case((1.834, 2, 30), "two pictures"),
        Case((5.002, 30, 136), "5.002, up to 136 hits"),
        Case((2.0, 1, 6), "one picture"),
        Case((3.501, 500, 9), "500 pictures"),
    ],
    hidden=_possible_hidden,
    comparison=All((Property(each_once), Close())),
    hints=(
        "For a given number of hits, 5 n_f + n_m can only be the whole number nearest to n_pictures * mean_cost + 1.333 * hits. Compute the mean that follows from it and test whether it is within the bound.",
        "Start with hits = np.arange(most_hits + 1) and compute everything with arrays. np.round(...) returns the nearest whole numbers, which must not be negative. The means may be off by 0.0005, plus 1e-9 for rounding errors.",
    ),
    sibling=Sibling(
        "A sum of whole numbers is a whole number, so only some means are possible: here the numbers of families for which a mean of 2.17 children can be printed.",
        """
        import numpy as np

        families = np.arange(1, 31)
        children = np.round(2.17 * families)  # the nearest whole number
        possible = np.abs(children / families - 2.17) <= 0.005 + 1e-9
        print(families[possible])
        """,
        "[ 6 12 18 23 24 29 30]",
    ),
    mistakes=catalogue("""
        four thirds: 1.333 =>> (4 / 3)
            You use 4/3 for a hit. Table 6.1 prints 1.333, and with many hits the difference matters.
        rounded down: np.round => np.floor
            You round n * mean + 1.333 n_h down, or take its remainder % 1, so only a whole number just below it counts. The nearest whole number may also be above it, so use np.round.
        rounded up: np.round => np.ceil
            You round n * mean + 1.333 n_h up. The nearest whole number may be below it, so use np.round.
        the remainder to the next one: np.abs((others - 1.333 * hits) / n_pictures - mean_cost) => (1 - (n_pictures * mean_cost + 1.333 * hits) % 1) / n_pictures
            You take the distance from n * mean + 1.333 n_h to the next whole number above it. The nearest one may also be below it, so use np.round.
        the sign kept: np.abs((others - 1.333 * hits) / n_pictures - mean_cost) => (others - 1.333 * hits) / n_pictures - mean_cost
            Your difference from mean_cost has a sign, so every mean that is too small passes. Take its absolute value, as in equation 10.3.
        the other sign kept: np.abs((others - 1.333 * hits) / n_pictures - mean_cost) => mean_cost - (others - 1.333 * hits) / n_pictures
            Your difference from mean_cost has a sign, so every mean that is too large passes. Take its absolute value, as in equation 10.3.
        no breath for floats: 0.0005 + 1e-9 => 0.0005
            Your function loses means that are off by exactly 0.0005, because of rounding errors of floats. Add 1e-9 to the bound.
        rounded and held against it: (off <= 0.0005 + 1e-9) => (np.round((others - 1.333 * hits) / n_pictures, 3) == mean_cost)
            You round the mean and compare it with ==. A mean exactly halfway between two printed values may be printed as either of them, so use the bound of equation 10.3.
        nothing may be rounded: 0.0005 + 1e-9 => 1e-9
            Your bound is too narrow. The printed mean may be off by 0.0005, so the sum over all pictures may be off by 0.0005 * n_pictures.
        the bound of the sum: 0.0005 + 1e-9 => 0.0005 * n_pictures + 1e-9
            You allow 0.0005 * n_pictures, which is the bound of the sum over all pictures. You compare means, so their bound is 0.0005.
        a whole unit: 0.0005 => 0.001
            You allow an error of 0.001. A number rounded to three digits is off by at most 0.0005.
        the last one left out: most_hits + 1 => most_hits
            You leave out most_hits itself. np.arange(n) ends at n - 1.
        from one on: np.arange(most_hits + 1) => np.arange(1, most_hits + 1)
            You leave out 0 hits. Start with 0.
        signs lost: 1.333 =>> -1.333
            You subtract 1.333 n_h. The sum is 5 n_f + n_m - 1.333 n_h, so 5 n_f + n_m is the sum plus 1.333 n_h.
        missed corners forgotten: np.round(n_pictures * mean_cost + 1.333 * hits) => 5 * np.round((n_pictures * mean_cost + 1.333 * hits) / 5)
            0.0005 + 1e-9) & (others >= 0) => 0.0005)
            You only accept multiples of 5. A missed corner costs 1, so 5 n_f + n_m can be any whole number from 0 on.
        a mask: hits[(off <= 0.0005 + 1e-9) & (others >= 0)] => (off <= 0.0005 + 1e-9) & (others >= 0)
            You return a mask. Return the numbers of hits: hits[mask].
        below nothing: (others >= 0) => True
            You accept negative values of 5 n_f + n_m. Numbers of false and missed corners cannot be negative.
        something must be wrong: (others >= 0) => (others > 0)
            You leave out 5 n_f + n_m = 0. It is possible that no report is false and no corner is missed.
        searched up to a limit: (others >= 0) => (others >= 0) & (others < 1000)
            Your search for 5 n_f + n_m ends too early: with many pictures it can be in the thousands. Compute it instead: it is close to n_pictures * mean_cost + 1.333 n_h.
        searched up to 300: (others >= 0) => (others >= 0) & (others < 300)
            Your search for 5 n_f + n_m ends too early. Compute it instead: it is close to n_pictures * mean_cost + 1.333 n_h.
        how many there are: return hits[(off <= 0.0005 + 1e-9) & (others >= 0)] => return sum((off <= 0.0005 + 1e-9) & (others >= 0))
            You return the number of possible values. Return the values themselves as an array.
        240 hits always: + most_hits = 240
            You ignore the argument most_hits, the largest number of hits to try.
        thirty pictures always: + n_pictures = 30
            You always use 30 pictures. Use the argument n_pictures.
        the rest: return hits => return others
            You return 5 n_f + n_m. Return the numbers of hits.
    """),
    alternatives={
        "a loop": lambda mean_cost, n_pictures, most_hits: [
            hits
            for hits in range(most_hits + 1)
            if (rest := n_pictures * mean_cost + 1.333 * hits) >= -0.5
            and abs(rest - round(rest)) <= n_pictures * (0.0005 + 1e-9)
        ],
        "as it would be printed": _as_printed,
        "in thousandths": _in_thousandths,
    },
    equivalents={
        "return hits[(off <= 0.0005 + 1e-09) * (others >= 0)]": "the product of two masks is their logical and",
        "return hits[(off < 0.0005 + 1e-09) & (others >= 0)]": "no mean lies at 0.000500001 exactly",
        "off = np.abs(mean_cost - (others - 1.333 * hits) / n_pictures)": "the sign of a difference does not change its absolute value",
    },
)


# --- 10.6 error_budget ---
def _budget(gain: Any) -> Any:
    """Compute both parts with a gain from H and R."""

    def function(pose: Any, landmarks: Any, view: CameraView, *sigmas: float) -> Any:
        pixels = view.project(Pose.from_array(np.asarray(pose, float)).to_local(landmarks))
        parts = [measurement_covariance(pixels, view, *each) for each in np.diag(sigmas)]
        K = gain(np.vstack([measurement_jacobian_pose(pose, each) for each in landmarks]), sum(parts))
        return [K @ each @ K.T for each in parts]

    return function


def _whitened(H: Array, R: Array) -> Array:
    white = np.linalg.inv(np.linalg.cholesky(R))
    return np.linalg.pinv(white @ H) @ white


def _budget_less(pose: Any, landmarks: Any, view: CameraView, pixel_sigma: float, tilt_sigma: float) -> Any:
    """Compute the whole covariance, and subtract the part of the tilt."""
    pixels = view.project(landmarks, Pose(*map(float, pose)))
    R = measurement_covariance(pixels, view, pixel_sigma, tilt_sigma)
    H = np.concatenate([measurement_jacobian_pose(pose, each) for each in landmarks])
    W = np.linalg.inv(R)
    P = np.linalg.inv(H.T @ W @ H)
    tilt = P @ H.T @ W @ measurement_covariance(pixels, view, 0.0, tilt_sigma) @ W @ H @ P
    return P - tilt, tilt


def _sight(rng: np.random.Generator, k: int, pose: Any = None) -> tuple[Array, Array, CameraView]:
    """Return a pose, k landmarks in front of it, and a view."""
    yaw, pitch = float(rng.uniform(-0.3, 0.3)), float(np.radians(rng.uniform(-27, -20)))
    view = NAO_V4.view("bottom", yaw, pitch, (320, 240))
    pose = np.array(pose or (rng.uniform(-1, 2), rng.uniform(-1.5, 1.5), rng.uniform(-3, 3)))
    ahead = np.array([(rng.uniform(1.0, 3.5), rng.uniform(-0.35, 0.35)) for _ in range(k)])
    turn = view.yaw + ahead[:, 1]
    local = np.column_stack([ahead[:, 0] * np.cos(turn), ahead[:, 0] * np.sin(turn)])
    return pose, Pose.from_array(pose).to_parent(local), view


def _budget_public() -> list[Case]:
    rng = np.random.default_rng(106)
    cases = [
        Case((*_sight(rng, 3, (1.0, 0.2, -0.1)), 2.0, 0.0175), "three landmarks"),
        Case((*_sight(rng, 2), 1.0, 0.03), "two landmarks"),
        Case((*_sight(rng, 5), 4.0, 0.005), "five landmarks, hardly any tilt"),
        Case((*_sight(rng, 3), 2.0, 0.0), "no tilt"),
    ]
    for case in cases:
        _budget_less(*case.args)  # calls measurement_covariance with both sigmas, which is then recorded, too
    return cases


ERROR_BUDGET = Exercise(
    name="error_budget",
    points=4,
    stars=3,
    public=_budget_public,
    hidden=lambda rng: [
        *(
            Case((*_sight(rng, k), *map(float, rng.uniform((0.5, 0.005), (4, 0.04)))))
            for k in (2, 3, 3, 4, 6)
        ),
        Case((*_sight(rng, 3), 1.5, 0.0)),
    ],
    comparison=Close(rtol=2e-3, atol=1e-9),
    uses=["04:measurement_covariance", "05:measurement_jacobian_pose"],
    hints=(
        "view.project(landmarks, Pose(*pose)) returns the landmarks' pixels. measurement_covariance with one of its sigmas set to 0 returns D or the part of the tilt. H has two rows for each landmark.",
        "W is the inverse of R in both parts, because the robot weights its measurements for all errors together. P = inv(Hᵀ W H), K = P Hᵀ W, and the parts are K D Kᵀ and K (R - D) Kᵀ.",
    ),
    sibling=Sibling(
        "The weights are chosen once, and with the same weights each source's covariance becomes a part of the result's, so that the parts add up to the whole.",
        """
        import numpy as np

        share = np.array([0.5, 0.3, 0.2])  # of three portfolios
        own, market = np.diag([4.0, 1.0, 9.0]), np.full((3, 3), 2.0)
        parts = [share @ covariance @ share for covariance in (own, market)]
        print(np.round(parts, 3), round(float(share @ (own + market) @ share), 3))
        """,
        "[1.45 2.  ] 3.45",
    ),
    mistakes=catalogue("""
        one source at a time: return K @ D @ K.T, K @ by_tilt @ K.T => return np.linalg.inv(H.T @ np.linalg.inv(D) @ H), np.linalg.inv(H.T @ W @ H)
            You compute each part as if there were no other source of error, with weights for this source alone. Use the weights of the whole R in both parts.
        each source with its own inverse: return K @ D @ K.T, K @ by_tilt @ K.T => return np.linalg.inv(H.T @ np.linalg.inv(D) @ H), np.linalg.inv(H.T @ np.linalg.inv(by_tilt) @ H)
            Your first part uses the weights D^-1. The robot does not know which error occurred, so use R^-1 in both parts.
        K without W: np.linalg.inv(H.T @ W @ H) @ H.T @ W => np.linalg.inv(H.T @ W @ H) @ H.T
            Your K is P Hᵀ. It also needs the weights: K = P Hᵀ W.
        weighed by the pixels: D + by_tilt => D
            Your weights contain only the pixels' errors. Use the inverse of the whole R, which includes the tilt.
        the covariance as weights: np.linalg.inv(D + by_tilt) => (D + by_tilt)
            You use the covariance R as weights. The weights are its inverse.
        radians of radians: by_tilt = measurement_covariance(pixels, view, 0.0, tilt_sigma) => by_tilt = measurement_covariance(pixels, view, 0.0, np.radians(tilt_sigma))
            You convert tilt_sigma to radians, but it is in radians already.
        not weighed: np.linalg.inv(D + by_tilt) => np.eye(len(D))
            You give all measurements the same weight, radians and metres alike. Use the inverse of R.
        H as a stack: np.vstack => np.array
            If two shapes do not fit: H is (2k, 3), with two rows for each landmark, one below the other. np.vstack does this; np.array makes (k, 2, 3), and np.hstack puts the rows side by side. K is (3, 2k) and D (2k, 2k), so a part is K D Kᵀ. If Pose refuses an array: it takes three numbers, Pose(*pose).
        P not inverted: np.linalg.inv(H.T @ W @ H) => (H.T @ W @ H)
            Your P is Hᵀ W H, which is the information of the pose. P is its inverse.
        variances only: inv(D + by_tilt) => inv(np.diag(np.diag(D + by_tilt)))
            Your weights use only the variances. The tilt changes all measurements together, so invert the whole matrix R.
        the remainder without one source: return K @ D @ K.T, K @ by_tilt @ K.T => alone = np.linalg.inv(H.T @ np.linalg.inv(D) @ H)
            + return alone, np.linalg.inv(H.T @ W @ H) - alone
            You subtract the covariance without any tilt, which has other weights. Use the weights of the whole R in both parts.
        the whole first: K @ D @ K.T => K @ (D + by_tilt) @ K.T
            Your first part is the whole covariance. Return only the part of the pixels.
        each landmark its own tilt: by_tilt = measurement => by_tilt = np.kron(np.eye(len(landmarks)), np.ones((2, 2))) * measurement
            You keep only the 2 x 2 blocks of the tilt's covariance, as if each landmark had its own tilt. One tilt changes all measurements of a picture, so keep the whole matrix.
        all bearings first: H = np.vstack([measurement_jacobian_pose(pose, landmark) for landmark in landmarks]) => H = np.vstack([measurement_jacobian_pose(pose, landmark) for landmark in landmarks])
            + H = np.vstack([H[0::2], H[1::2]])
            Your H has all bearings first and all ranges after them. R has the bearing and the range of one landmark after the other, and H needs the same order.
        landmarks in the field frame: (landmarks, Pose(*pose)) => (landmarks)
            Your pixels are wrong, because view.project expects points in the robot frame. Pass the robot's pose as its second argument.
        metres for pixels: pixels = view.project(landmarks, Pose(*pose)) => pixels = landmarks
            measurement_covariance expects pixels. Project the landmarks first: view.project(landmarks, Pose(*pose)).
        changed places: K @ D @ K.T, K @ by_tilt @ K.T => K @ by_tilt @ K.T, K @ D @ K.T
            You return the two parts in the wrong order. Return the pixels' part first, then the tilt's.
        standard deviations: return K @ D @ K.T, K @ by_tilt @ K.T => return np.sqrt(np.diag(K @ D @ K.T)), np.sqrt(np.abs(np.diag(K @ by_tilt @ K.T)))
            You return standard deviations. Return the two 3 x 3 covariances, because only they can be added.
        both added: K @ by_tilt @ K.T => K @ (D + by_tilt) @ K.T
            Your second part is the whole covariance. Return only the part of the tilt.
        shares: return K @ D @ K.T, K @ by_tilt @ K.T => parts = K @ D @ K.T, K @ by_tilt @ K.T
            + return tuple(each / np.trace(sum(parts)) for each in parts)
            You return fractions of the whole covariance. Return the two covariances themselves.
    """),
    alternatives={
        "by the information": _budget(
            lambda H, R: np.linalg.solve(H.T @ np.linalg.solve(R, H), np.linalg.solve(R, H).T)
        ),
        "the whole less the tilt": _budget_less,
        "whitened": _budget(_whitened),
    },
)


PLAN = LessonPlan(
    exercises=[
        PAYING_PRECISION,
        DETECTION_COST,
        GRID_SEARCH,
        BOOTSTRAP_INTERVAL,
        POSSIBLE_HITS,
        ERROR_BUDGET,
    ],
    questions=[
        Question(
            "what_sigma",
            "The paper prints a sigma beside each mean, for example 0.322 beside 2.122, but does not define it. The costs of your single pictures have standard deviations from 1.5 to 5.7. Which interpretation fits?",
            {
                "The sigma of a single picture's cost.": "Then nearly all of the thirty pictures would cost between 1.5 and 2.8. But a single additional false corner costs 5.",
                "The standard error of the mean.": "The standard error is the standard deviation of a picture divided by √30; yours is 0.3 to 1.0. The paper's values range from 0.3 to 2.6. The small ones fit, but the large ones would need pictures with a standard deviation of 14.",
                "Neither fits all 27 rows.": "The smallest values are too small for single pictures, and the largest are too large for a mean of thirty. A number without a definition cannot be used.",
            },
            "Neither fits all 27 rows.",
        ),
        Question(
            "why_paired",
            "Two settings have mean costs of 1.1 and 1.6 on the same thirty pictures, each with an interval 1.6 wide. Is the first setting better?",
            {
                "No: the intervals overlap widely.": "Both intervals are wide because some pictures are hard. They are hard for both settings, so most of the width is common to both and says nothing about the difference.",
                "Yes: its mean is smaller.": "With thirty other pictures, the order may be reversed. You have to estimate how likely that is.",
                "Look at the interval of the difference, computed picture by picture.": "The difference picture by picture removes what is hard for both settings. If its interval contains 0, the data do not show which setting is better.",
            },
            "Look at the interval of the difference, computed picture by picture.",
        ),
        Question(
            "why_so_little",
            "For a single range at 2 m, the tilt contributes more than the pixels. For a pose from four landmarks, it contributes far less. Why?",
            {
                "The pose is an average, and averaging makes every error small.": "Averaging reduces independent errors, such as the pixels'. The tilt is the same for all four ranges, so averaging them does not reduce it.",
                "The four landmarks together reveal the tilt.": "There are eight measurements for three unknowns of the pose and one tilt. No pose can explain the common effect of a tilt on all four landmarks, so the weights of R separate it from the pose.",
                "One degree is less than 3.3 pixels.": "One degree is larger, not smaller: a pixel is 0.2 degrees here, so the 3.3 pixels that the budget assumes are 0.7 degrees. In the figure of the ranges the tilt causes the larger part.",
            },
            "The four landmarks together reveal the tilt.",
        ),
    ],
    written=[
        Written(
            "experiment_report",
            points=6,
            question="Write a report of one page about your search: the question, the method, results with figures and intervals, what they mean, and which result would change your mind.",
            rubric="1 point, method: pictures (how many, which, that they are the simulator's), what counts as a hit (8 px, one-to-one, a crossing (X) counts as false), the weights, the 27 settings. 1 point, baseline: the cost of reporting nothing on the same pictures, and each result compared with it. 1 point, uncertainty: an interval with its probability for the chosen setting, and paired differences from other settings or from reporting nothing. 1 point, choice: it says that the best of 27 settings looks better than it is on the pictures it was chosen on, and gives its cost in the personal room, where nothing was chosen. 1 point, the paper: which parts of Table A.1 agree and which do not (rank correlation, means that thirty pictures cannot have, an undefined sigma), and at least one explanation other than carelessness. 1 point, conclusion: it follows from the numbers, names at least one limit (simulator, one resolution, few pictures, one detector) and what result would change it. Subtract a point if a necessary figure is not named, or if a number has no unit.",
            numbers=personal_numbers,
        )
    ],
)
