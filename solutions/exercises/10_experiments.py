"""Lesson 10, experiments: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

from collections.abc import Callable
from itertools import cycle, product
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.colours import GREEN, YELLOW
from nao_course.exercises import Case, Close, Exercise, LessonPlan, Mistake, Question, Written
from nao_course.geometry import Pose
from nao_course.lessons.experiments.intervals import SEEDS, Interval, case_of
from nao_course.sim import NAO_V4, CameraView
from nao_course.student import earlier

Array = npt.NDArray[Any]
HIT, FALSE, MISSED = -1.333, 5.0, 1.0

(
    color_labels,
    white_threshold,
    find_corners,
    measurement_covariance,
    measurement_jacobian_pose,
) = map(
    earlier,
    (
        "01:color_labels",
        "01:white_threshold",
        "03:find_corners",
        "04:measurement_covariance",
        "05:measurement_jacobian_pose",
    ),
)


# --- 10.1 paying_precision ---


def _paying_public() -> list[Case]:
    return [
        Case((-1.333, 5.0, 1.0), "the paper's table"),
        Case((0.0, 1.0, 1.0), "a hit that only spares the miss"),
        Case((-2.0, 3.0, 0.0), "misses that cost nothing"),
        Case((-1.0, 18.0, 1.0), "false ones that are dear"),
    ]


def _paying_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case((-float(rng.uniform(0.2, 3)), float(rng.uniform(1, 9)), float(rng.uniform(0.2, 3))))
        for _ in range(6)
    ]


PAYING_PRECISION = Exercise(
    name="paying_precision",
    points=1,
    stars=1,
    public=_paying_public,
    hidden=_paying_hidden,
    comparison=Close(),
    hints=(
        "A report of precision p costs hit in p of all cases and false in the others. Keeping quiet costs missed in p of all cases, and nothing in the others. Where are both "
        "equal?",
        "p * hit + (1 - p) * false = p * missed. Bring all that has p to one side.",
    ),
    mistakes=[
        Mistake(
            "the miss that is spared forgotten",
            lambda hit, false, missed: false / (false - hit),
            "You compare a report with a picture that has no cost at all. Where there is a corner, keeping quiet costs `missed`.",
        ),
        Mistake(
            "the hit forgotten",
            lambda hit, false, missed: false / (false + missed),
            "What a hit gains is not in yours: where there is a corner, a report costs `hit`, and not nothing.",
        ),
        Mistake(
            "the paper's costs always",
            lambda hit, false, missed: 5.0 / 7.333,
            "Your answer is that of the paper's costs, whatever was given.",
        ),
        Mistake(
            "signs lost",
            lambda hit, false, missed: false / (false + missed + hit),
            "A hit has a negative cost. It makes reporting better, so it is subtracted: false + missed - hit.",
        ),
        Mistake(
            "the other part",
            lambda hit, false, missed: (missed - hit) / (false + missed - hit),
            "That is the part of reports that may be false. Precision is the part that is right.",
        ),
        Mistake(
            "per cent",
            lambda hit, false, missed: 100 * false / (false + missed - hit),
            "Your answer is in per cent. A precision is a number from 0 to 1.",
        ),
        Mistake(
            "false ones for each right one",
            lambda hit, false, missed: false / (missed - hit),
            "That is how many hits make up for one false report. Of all reports, hits are that many of that many and one.",
        ),
        Mistake(
            "rounded",
            lambda hit, false, missed: round(false / (false + missed - hit), 2),
            "Right, but rounded. Return all digits; round where you print.",
        ),
        Mistake(
            "a half",
            lambda hit, false, missed: 0.5,
            "A half would be right if a false report cost as much as a hit gains. Put the three costs in.",
        ),
    ],
    alternatives={
        "by the gain": lambda hit, false, missed: 1 / (1 + (missed - hit) / false),
        "as a root": lambda hit, false, missed: float(np.roots([hit - false - missed, false])[0]),
        "one less": lambda hit, false, missed: 1 - (missed - hit) / (missed - hit + false),
    },
)


# --- 10.2 detection_cost ---


def _cost(detected: Any, truth: Any, tolerance: float, **changed: Any) -> Any:
    """Pair by pair from the closest on, with one thing done in another way."""
    detected, truth = np.asarray(detected, float), np.asarray(truth, float)
    pairs = [
        (float(changed.get("apart", lambda d: np.hypot(*d))(p - q)), i, j)
        for i, p in enumerate(detected)
        for j, q in enumerate(truth)
    ]
    if not changed.get("as_they_come"):
        pairs.sort(key=lambda pair: pair[0])
    used: set[int] = set()
    taken: set[int] = set()
    hits = 0
    for apart, i, j in pairs:
        near = apart < tolerance if changed.get("strict") else apart <= tolerance
        if not near or (i in used and not changed.get("again")) or (j in taken and not changed.get("double")):
            continue
        used.add(i)
        taken.add(j)
        hits += 1
    weights = changed.get("weights", (HIT, FALSE, MISSED))
    hit, false, missed = hits, len(detected) - hits, len(truth) - hits
    if changed.get("double"):
        hit, false, missed = len(used), len(detected) - len(used), len(truth) - len(taken)
    return changed.get("total", lambda *n: float(np.dot(weights, n)))(hit, false, missed)


def _costs(**changed: Any) -> Callable[..., Any]:
    return lambda detected, truth, tolerance: _cost(detected, truth, tolerance, **changed)


def _cost_by_assignment(detected: Any, truth: Any, tolerance: float) -> float:
    """Corners in turn take the closest of all pairs that are left: by a masked array."""
    apart = np.ma.masked_greater(
        np.sqrt(((np.asarray(truth, float)[:, None] - np.asarray(detected, float)) ** 2).sum(axis=-1)),
        tolerance,
    )
    hits = 0
    while apart.count():
        row, column = np.unravel_index(np.ma.argmin(apart), apart.shape)
        apart[row, :] = np.ma.masked
        apart[:, column] = np.ma.masked
        hits += 1
    return 5.0 * len(detected) + 1.0 * len(truth) - 7.333 * hits


def _cost_recursive(detected: Any, truth: Any, tolerance: float) -> float:
    p, q = [tuple(each) for each in np.asarray(detected)], [tuple(each) for each in np.asarray(truth)]
    near = [(np.hypot(a[0] - b[0], a[1] - b[1]), i, j) for i, a in enumerate(p) for j, b in enumerate(q)]
    if not near or min(near)[0] > tolerance:
        return 5 * len(p) + len(q)
    _, i, j = min(near)
    rest = [np.array(each).reshape(-1, 2) for each in (p[:i] + p[i + 1 :], q[:j] + q[j + 1 :])]
    return -1.333 + _cost_recursive(*rest, tolerance)


def _cost_in_turn(detected: Any, truth: Any, tolerance: float) -> float:
    """Each report in turn takes the closest corner that is still free."""
    left = [np.asarray(each, float) for each in truth]
    hits = 0
    for p in np.asarray(detected, float):
        apart = [float(np.hypot(*(p - q))) for q in left]
        if apart and min(apart) <= tolerance:
            left.pop(apart.index(min(apart)))
            hits += 1
    return float(HIT * hits + FALSE * (len(detected) - hits) + MISSED * len(left))


def _cost_by_corner(detected: Any, truth: Any, tolerance: float) -> float:
    """Each corner in turn takes the closest report that is still free."""
    p, q = np.asarray(detected, float).reshape(-1, 2), np.asarray(truth, float).reshape(-1, 2)
    hits = round((5 * len(q) + len(p) - _cost_in_turn(q, p, tolerance)) / 7.333)
    return 5.0 * len(p) + len(q) - 7.333 * hits


def _cost_matched(forbid: bool) -> Callable[..., float]:
    """The assignment with the smallest sum of distances, with pairs beyond the tolerance allowed or not."""

    def cost(detected: Any, truth: Any, tolerance: float) -> float:
        from scipy.optimize import linear_sum_assignment

        p, q = np.asarray(detected, float).reshape(-1, 2), np.asarray(truth, float).reshape(-1, 2)
        apart = np.hypot(*(p[:, None] - q).transpose(2, 0, 1))
        pairs = linear_sum_assignment(np.where(apart > tolerance, 1e6, apart) if forbid else apart)
        hits = int((apart[pairs] <= tolerance).sum())
        return 5.0 * len(p) + len(q) - 7.333 * hits

    return cost


def _points(*points: tuple[float, float]) -> Array:
    return np.array(points, dtype=float).reshape(-1, 2)


_TRUTH = _points((40, 30), (100, 60), (160, 90))


def _cost_public() -> list[Case]:
    return [
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
    ]


def _cost_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for tolerance in (3.0, 8.0, 8.0, 16.0):
        truth = rng.uniform(0, 90, (int(rng.integers(2, 7)), 2))
        near = truth[: int(rng.integers(1, len(truth) + 1))] + rng.uniform(-0.7, 0.7, 2) * tolerance
        detected = rng.permutation(np.vstack([near, rng.uniform(0, 90, (int(rng.integers(0, 4)), 2))]))
        cases.append(Case((detected, truth, tolerance)))
    one = rng.uniform(20, 60, 2)
    reach = float(rng.uniform(4, 9))
    edge = one + reach * np.array([0.6, 0.8])
    turn = float(rng.uniform(-3, 3))
    along = one + np.outer((1.8, 0.75, 0.0, 1.25), reach * np.array([np.cos(turn), np.sin(turn)]))
    return [
        *cases,
        Case((along[:2], along[2:], reach)),
        Case((along[1::-1], along[2:], reach)),
        Case((along[1::-1], along[:1:-1], reach)),
        Case((one + [(0, 0.1 * reach), (0, -1.1 * reach)], one + [(0, 0), (0, 1.2 * reach)], reach)),
        Case((along[2:] - 0.01, along[:2], reach)),
        Case((along[:1:-1] - 0.01, along[:2], reach)),
        Case((np.floor(one)[None] + (np.ceil(reach) + 0.3, 0), np.floor(one)[None], float(np.ceil(reach)))),
        Case((np.vstack([one, one + 1, one - 1]), one[None] + 0.5, reach)),
        Case(
            (
                np.vstack([one + (0.9 * reach, 0), one]),
                np.vstack([one + (0.1, 0), one + (1.7 * reach, 0)]),
                reach,
            )
        ),
        Case((one[None] + (0.75 * reach, 0.75 * reach), one[None], reach)),
        Case((np.round(one)[None] + (3, 4), np.round(one)[None], 5.0)),
        Case((edge[None], np.vstack([one - 60, one]), 1.2 * reach)),
        Case((np.zeros((0, 2)), rng.uniform(0, 90, (int(rng.integers(1, 6)), 2)), reach)),
        Case((rng.uniform(0, 90, (int(rng.integers(1, 6)), 2)), np.zeros((0, 2)), reach)),
        Case((np.zeros((0, 2)), np.zeros((0, 2)), reach)),
    ]


DETECTION_COST = Exercise(
    name="detection_cost",
    points=2,
    stars=2,
    public=_cost_public,
    hidden=_cost_hidden,
    comparison=Close(),
    hints=(
        "First all distances, (N, K): np.linalg.norm(detected[:, None] - truth, axis=2). Then, as long as the smallest is within the tolerance: that is a hit, and both its row and "
        "its column are used up.",
        "np.unravel_index(apart.argmin(), apart.shape) says row and column of the smallest; apart[i, :] = np.inf and apart[:, j] = np.inf use them up. An array without entries has no argmin: ask apart.size first. What "
        "was reported and is no hit is false, what is there and is no hit is missed.",
    ),
    mistakes=[
        Mistake(
            "doubles are hits",
            _costs(double=True),
            "Several reports at one corner all count as hits in yours. Each corner can be hit once: the others are false.",
        ),
        Mistake(
            "one report hits two",
            lambda detected, truth, tolerance: _cost(
                truth,
                detected,
                tolerance,
                double=True,
                total=lambda hit, missed, false: HIT * hit + FALSE * false + MISSED * missed,
            ),
            "One report that is near two corners counts as two hits in yours. Each report is used once.",
        ),
        Mistake(
            "in the order of the reports",
            _costs(as_they_come=True),
            "You give each report, in their order, a corner that another one is closer to. Pair from the closest on: then the order does not matter.",
        ),
        Mistake(
            "each report in turn",
            _cost_in_turn,
            "Your reports choose in their order, each the closest corner that is free. Another pair may be closer: take the closest of all pairs first.",
        ),
        Mistake(
            "each corner in turn",
            _cost_by_corner,
            "Your corners choose in their order, each the closest report that is free. Another pair may be closer: take the closest of all pairs first.",
        ),
        Mistake(
            "as many pairs as there can be",
            _cost_matched(forbid=True),
            "You make as many pairs as there can be. Here they are made from the closest on, even where then one is left over.",
        ),
        Mistake(
            "the smallest sum of distances",
            _cost_matched(forbid=False),
            "You make the pairs whose distances have the smallest sum. Here they are made from the closest on, even where then one is left over.",
        ),
        Mistake(
            "whole pixels",
            lambda detected, truth, tolerance: _cost(np.trunc(detected), np.trunc(truth), tolerance),
            "You cut the pixels to whole numbers. Corners lie between pixels, too: keep them as they are.",
        ),
        Mistake(
            "less than the tolerance",
            _costs(strict=True),
            "A report just at the tolerance is a hit: within means <=.",
        ),
        Mistake(
            "a square for a circle",
            _costs(apart=lambda d: float(np.abs(d).max())),
            "You ask for u and v apart, so that your tolerance is a square. It is a distance: np.hypot of both.",
        ),
        Mistake(
            "squares against the tolerance",
            _costs(apart=lambda d: float((d**2).sum())),
            "You hold squared distances against the tolerance: take the root, or square both.",
        ),
        Mistake(
            "along both axes added",
            _costs(apart=lambda d: float(np.abs(d).sum())),
            "You add the distances along u and along v. As the crow flies it is np.hypot of both.",
        ),
        Mistake(
            "the tolerance is always 8",
            lambda detected, truth, tolerance: _cost(detected, truth, 8.0),
            "Your tolerance is 8, whatever was given.",
        ),
        Mistake(
            "false and missed changed",
            _costs(weights=(HIT, MISSED, FALSE)),
            "You take 5 for a missed corner and 1 for a false one. It is the other way round.",
        ),
        Mistake(
            "a gain for a cost",
            _costs(weights=(1.333, FALSE, MISSED)),
            "A hit has the cost -1.333: it makes the sum smaller.",
        ),
        Mistake(
            "four thirds",
            _costs(weights=(-4 / 3, FALSE, MISSED)),
            "You take four thirds for a hit. Table 6.1 prints 1.333, and later in this lesson the difference matters.",
        ),
        Mistake(
            "the mean",
            _costs(total=lambda *n: float(np.dot((HIT, FALSE, MISSED), n)) / max(sum(n), 1)),
            "You divide by how many there are. A picture's cost is a sum.",
        ),
        Mistake(
            "misses free",
            _costs(weights=(HIT, FALSE, 0.0)),
            "A corner that is there and not reported costs 1, and nothing in yours.",
        ),
        Mistake(
            "all reports false",
            _costs(total=lambda hit, false, missed: HIT * hit + FALSE * (hit + false) + MISSED * missed),
            "You count all reports as false, those that are hits as well.",
        ),
        Mistake(
            "all corners missed",
            _costs(total=lambda hit, false, missed: HIT * hit + FALSE * false + MISSED * (hit + missed)),
            "You count all corners as missed, those that are hit as well.",
        ),
    ],
    alternatives={
        "sorted pairs": _costs(),
        "a masked array": _cost_by_assignment,
        "by recursion": _cost_recursive,
    },
    equivalents={
        "apart = np.linalg.norm(detected[:, None] - truth, axis=1 - 2)": "axis -1 is the last one, which is 2",
        "apart = np.linalg.norm(truth - detected[:, None], axis=2)": "a difference the other way round is as long",
    },
)


# --- 10.3 grid_search ---


def _labels(picture: Any, beta: float) -> Array:
    white = white_threshold(float(np.mean([picture.max(axis=2), picture.min(axis=2)])), beta)
    return np.asarray(color_labels(picture, *(GREEN, YELLOW), white))


def _scene(rng: np.random.Generator, height: int, width: int) -> tuple[Array, Array]:
    """Carpet with a bright corner, a dim one, and a dashed line; what is found at some setting counts as a corner."""
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


def _grid(scenes: Any, betas: Any, gaps: Any, lengths: Any, /, **changed: Any) -> Any:
    """All settings, the scenes within, with one thing done in another way."""
    table: dict[Any, Any] = {}
    for beta, gap, length in product(betas, gaps, lengths):
        costs = []
        for picture, corners in scenes:
            shown = scenes[0][0] if changed.get("labels_of_first") else picture
            labels = _labels(shown, changed.get("beta", beta))
            values = (length, gap) if changed.get("swapped") else (gap, length)
            found = find_corners(labels) if changed.get("defaults") else find_corners(labels, *values)
            found = np.asarray(found)
            tolerance = changed.get("tolerance", 8 * picture.shape[changed.get("axis", 0)] / 240)
            if "tolerance_of" in changed:
                tolerance = changed["tolerance_of"](picture)
            if changed.get("truth_first"):
                costs.append(_cost(corners, found, tolerance))
            else:
                costs.append(_cost(found, corners, tolerance))
        key = changed.get("key", lambda *setting: setting)(beta, gap, length)
        table[key] = changed.get("gather", np.array)(costs)
    return table


def _grids(**changed: Any) -> Callable[..., Any]:
    return lambda scenes, betas, gaps, lengths: _grid(scenes, betas, gaps, lengths, **changed)


def _grid_zip(scenes: Any, betas: Any, gaps: Any, lengths: Any) -> Any:
    found = {}
    for beta, gap, length in zip(betas, gaps, lengths, strict=False):
        found.update(_grid(scenes, [beta], [gap], [length]))
    return found


def _grid_array(scenes: Any, betas: Any, gaps: Any, lengths: Any) -> Array:
    return np.array(list(_grid(scenes, betas, gaps, lengths).values()))


def _grid_running(scenes: Any, betas: Any, gaps: Any, lengths: Any) -> Any:
    """One list for all settings, never emptied."""
    table, costs = {}, []
    for setting in product(betas, gaps, lengths):
        costs += list(_grid(scenes, *([each] for each in setting))[setting])
        table[setting] = np.array(costs)
    return table


def _grid_best(scenes: Any, betas: Any, gaps: Any, lengths: Any) -> Any:
    table = _grid(scenes, betas, gaps, lengths)
    return min(table, key=lambda key: table[key].mean())


def _grid_scenes_first(scenes: Any, betas: Any, gaps: Any, lengths: Any) -> Any:
    costs = np.array(
        [
            [
                [
                    [_cost(find_corners(labels, g, n), corners, len(picture) / 30) for n in lengths]
                    for g in gaps
                ]
                for labels in (_labels(picture, beta) for beta in betas)
            ]
            for picture, corners in scenes
        ]
    )
    return {
        (beta, gap, length): costs[:, i, j, k]
        for i, beta in enumerate(betas)
        for j, gap in enumerate(gaps)
        for k, length in enumerate(lengths)
    }


def _grid_public() -> list[Case]:
    rng = np.random.default_rng(103)
    scenes = [_scene(rng, 48, 64) for _ in range(4)]
    narrow = _scene(rng, 48, 56)
    return [
        Case((scenes[:3], [100, 150], [1, 6], [8, 20]), "three scenes, eight settings"),
        Case(([narrow, scenes[0]], [100], [6], [8, 20]), "pictures of two shapes"),
        Case((scenes[1:], [150], [2, 6, 4], [8]), "one beta, three gaps"),
        Case((scenes[:1], [100], [6], [16]), "one scene, one setting"),
    ]


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
        "product(betas, gaps, lengths) goes through all settings. For each, the costs of all scenes in their order: labels, then corners, then detection_cost.",
        "table = {setting: [] for setting in product(betas, gaps, lengths)}; then, with the scenes outside and the betas within, labels are made once for each beta: "
        "table[beta, gap, length].append(...). np.array makes costs of each list.",
    ),
    mistakes=[
        Mistake(
            "means only",
            _grids(gather=lambda costs: float(np.mean(costs))),
            "You return one mean for each setting. The costs of all scenes are wanted: without them nobody can say how sure a mean is.",
        ),
        Mistake(
            "gap and length changed",
            _grids(swapped=True),
            "Gap and length have changed places on their way to find_corners: it takes the gap first.",
        ),
        Mistake(
            "values not handed on",
            _grids(defaults=True),
            "find_corners does not get your gap and length: the costs do not depend on them.",
        ),
        Mistake(
            "beta not handed on",
            _grids(beta=120.0),
            "Your costs do not depend on beta: label takes it as its second argument.",
        ),
        Mistake(
            "always 8 pixels",
            _grids(tolerance=8.0),
            "Your tolerance is 8 px in every picture. It is 8 px at 240 rows, and in proportion in others.",
        ),
        Mistake(
            "by the width",
            _grids(axis=1),
            "Your tolerance goes by the picture's width. It is 8 px at 240 rows: its height counts.",
        ),
        Mistake(
            "by the width of 320",
            _grids(tolerance_of=lambda picture: 8 * picture.shape[1] / 320),
            "8 px at 320 columns is the same only where pictures are 4 to 3. The tolerance goes by the height: 8 px at 240 rows.",
        ),
        Mistake(
            "whole pixels",
            _grids(tolerance_of=lambda picture: 8 * len(picture) // 240),
            "Your tolerance is cut to a whole number. 8 * H / 240 is 1.6 px for 48 rows.",
        ),
        Mistake(
            "one picture's labels for all",
            _grids(labels_of_first=True),
            "All scenes have the labels of the first picture in yours. Each picture has its own.",
        ),
        Mistake(
            "truth and reports changed",
            _grids(truth_first=True),
            "detection_cost takes what was found first, and what is true second.",
        ),
        Mistake(
            "side by side",
            _grid_zip,
            "You take the first beta with the first gap and the first length, and so on. All combinations are wanted: itertools.product.",
        ),
        Mistake(
            "another order of the key",
            _grids(key=lambda beta, gap, length: (beta, length, gap)),
            "Your keys are (beta, length, gap). A setting is (beta, gap, length).",
        ),
        Mistake(
            "an array",
            _grid_array,
            "You return the costs without their settings. A dict is wanted: table[beta, gap, length] are the costs of one setting.",
        ),
        Mistake(
            "a list that goes on",
            _grid_running,
            "The costs of one setting go on in the next one's: begin a new list for each.",
        ),
        Mistake(
            "the sums",
            _grids(gather=lambda costs: float(np.sum(costs))),
            "You return one sum for each setting. One cost for each scene is wanted.",
        ),
        Mistake(
            "the best only",
            _grid_best,
            "You return the best setting. The whole table is wanted; what is best in it comes later.",
        ),
        Mistake(
            "keys of text",
            _grids(key=lambda beta, gap, length: f"{beta}, {gap}, {length}"),
            "Your keys are texts. A key is a tuple of three numbers: (beta, gap, length).",
        ),
    ],
    alternatives={
        "settings outside": _grids(),
        "an array first": _grid_scenes_first,
        "lists of costs": _grids(gather=list),
    },
    equivalents={
        "return {setting: costs for setting, costs in table.items()}": "a list of costs will do",
        "return color_labels(picture, (90.0, 160.0), (44.0, 68.0), white_threshold(beta, lightness.mean()))": "b + (255 - b) m / 255 is the same for m and b changed",
        "lightness = picture.max(axis=1 - 2) / 2 + picture.min(axis=2) / 2": "axis -1 is the last one, which is 2",
        "lightness = picture.max(axis=2) / 2 + picture.min(axis=1 - 2) / 2": "axis -1 is the last one, which is 2",
    },
    seconds=20.0,
)


# --- 10.4 bootstrap_interval ---

DRAWS = 2000


def _boot(values: Any, probability: float, rng: np.random.Generator, **changed: Any) -> Any:
    """Draw all resamples at once, with one thing done in another way."""
    values = np.asarray(values, dtype=float)
    draws = changed.get("draws", DRAWS)
    shape = (draws, changed.get("size", len)(values))
    drawn = (
        rng.permuted(np.tile(values, (draws, 1)), axis=1)
        if changed.get("each")
        else rng.choice(values, shape)
    )
    means = changed.get("of", np.mean)(drawn, axis=1)
    out = (1 - probability) / changed.get("sides", 2)
    return tuple(float(each) for each in np.quantile(means, [out, 1 - out]))


def _boots(**changed: Any) -> Callable[..., Any]:
    return lambda values, probability, rng: _boot(values, probability, rng, **changed)


_OWN = cycle(range(len(SEEDS)))  # a generator that nobody seeds, but the same at each build


def _boot_of_its_own(values: Any, probability: float, rng: Any) -> Any:
    return _boot(values, probability, np.random.default_rng(next(_OWN)))


def _boot_counts(values: Any, probability: float, rng: np.random.Generator) -> Any:
    n = len(values)
    means = rng.multinomial(n, np.full(n, 1 / n), 4000) @ np.asarray(values, dtype=float) / n
    return list(np.percentile(means, [50 - 50 * probability, 50 + 50 * probability]))


def _boot_sorted(values: Any, probability: float, rng: np.random.Generator) -> Any:
    n, draws = len(values), 3000
    means = sorted(sum(values[i] for i in rng.integers(0, n, n)) / n for _ in range(draws))
    return means[round(draws * (1 - probability) / 2)], means[round(draws * (1 + probability) / 2) - 1]


def _boot_normal(values: Any, probability: float, rng: np.random.Generator) -> Any:
    from scipy.stats import norm

    half = norm.ppf((1 + probability) / 2) * np.std(values) / np.sqrt(len(values))
    return float(np.mean(values) - half), float(np.mean(values) + half)


def _skewed(rng: np.random.Generator, n: int) -> Array:
    return np.concatenate([rng.normal(0, 0.5, n - n // 5), rng.uniform(10, 20, n // 5)])


def _boot_public() -> list[Case]:
    rng = np.random.default_rng(104)
    return [
        case_of(_skewed(rng, 20), 0.95, "20 skewed costs, 95 %"),
        case_of(rng.normal(-1, 2, 30), 0.8, "30 costs, 80 %"),
        case_of(_skewed(rng, 10), 0.68, "10 skewed costs, 68 %"),
        case_of(np.full(6, 2.5), 0.9, "six equal costs"),
        case_of(rng.normal(1, 3, 12), 0.5, "12 costs, 50 %"),
    ]


def _boot_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        case_of(_skewed(rng, int(rng.integers(10, 40))), 0.95),
        case_of(rng.normal(float(rng.uniform(-2, 2)), 1.0, 30), 0.8),
        case_of(rng.normal(3, 2, 56), 0.99),
        case_of(-_skewed(rng, 15), 0.7),
        case_of(rng.normal(1, 3, int(rng.integers(8, 30))), 0.4),
    ]


BOOTSTRAP_INTERVAL = Exercise(
    name="bootstrap_interval",
    points=3,
    stars=2,
    public=_boot_public,
    hidden=_boot_hidden,
    comparison=Interval(),
    driver="nao_course.lessons.experiments.intervals:with_generators",
    hints=(
        "One resample is rng.choice(values, len(values)): it draws with replacement, so that some come twice and some never. Its mean is one of thousands.",
        "rng.choice(values, (2000, len(values))).mean(axis=1) are the means of 2000 resamples. np.quantile takes what lies below each end: half of 1 - probability is out on either "
        "side.",
    ),
    mistakes=[
        Mistake(
            "spread of the values",
            lambda values, probability, rng: tuple(
                np.quantile(rng.choice(values, DRAWS), [(1 - probability) / 2, (1 + probability) / 2])
            ),
            "Between these ends lie single costs. Take the mean of each resample first: the question is how sure the mean is.",
        ),
        Mistake(
            "nothing drawn",
            lambda values, probability, rng: tuple(
                np.quantile(values, [(1 - probability) / 2, (1 + probability) / 2])
            ),
            "Those are quantiles of the costs themselves: between them lie single costs. Draw resamples, and take quantiles of their means.",
        ),
        Mistake(
            "a hundred resamples",
            _boots(draws=100),
            "Your ends scatter too much from rng to rng. Draw at least 2000 resamples.",
        ),
        Mistake(
            "without replacement",
            _boots(each=True),
            "All your resamples have the same mean: they are drawn without replacement, so each holds every value once.",
        ),
        Mistake(
            "all of the rest on each side",
            _boots(sides=1),
            "You leave all of the rest out on either side. Half of 1 - probability belongs to each.",
        ),
        Mistake(
            "from the lowest on",
            lambda values, probability, rng: tuple(
                np.quantile(rng.choice(values, (DRAWS, len(values))).mean(axis=1), [0, probability])
            ),
            "Your interval begins at the lowest mean. The part that is left out is left out on both sides.",
        ),
        Mistake(
            "a normal curve",
            _boot_normal,
            "Those are the ends that a normal curve would have. Draw resamples with the rng: costs are skewed.",
        ),
        Mistake(
            "medians",
            _boots(of=np.median),
            "You take the median of each resample. The mean cost is asked for.",
        ),
        Mistake(
            "sums",
            _boots(of=np.sum),
            "You take the sum of each resample. Divide by how many there are: the mean is asked for.",
        ),
        Mistake(
            "smaller resamples",
            _boots(size=lambda values: len(values) // 2),
            "Your resamples are half as large as what was given. A mean of fewer scatters more: draw as many as there are.",
        ),
        Mistake(
            "larger resamples",
            _boots(size=lambda values: 10 * len(values)),
            "Your resamples are larger than what was given, as if there were more pictures: draw as many as there are.",
        ),
        Mistake(
            "from 0 to 1 and 0 to 100 mixed",
            lambda values, probability, rng: tuple(
                np.percentile(
                    rng.choice(values, (DRAWS, len(values))).mean(axis=1),
                    [(1 - probability) / 2, (1 + probability) / 2],
                )
            ),
            "np.percentile counts from 0 to 100, and np.quantile from 0 to 1.",
        ),
        Mistake(
            "np.random",
            _boot_of_its_own,
            "Draw with the rng that is handed in, not with np.random or a generator of your own: then an experiment can be repeated.",
        ),
        Mistake(
            "the upper end first",
            lambda values, probability, rng: _boot(values, probability, rng)[::-1],
            "The lower end comes first: (low, high).",
        ),
        Mistake(
            "how far from the mean",
            lambda values, probability, rng: tuple(
                each - float(np.mean(values)) for each in _boot(values, probability, rng)
            ),
            "Those are distances from the mean. The ends themselves are wanted.",
        ),
    ],
    alternatives={
        "all at once": _boots(),
        "how often each is drawn": _boot_counts,
        "sorted": _boot_sorted,
    },
    equivalents={
        "drawn = rng.integers(0, len(values), (2001, len(values)))": "at least 2000 are asked for",
        "drawn = rng.integers(0, len(values), (1999, len(values)))": "one resample less cannot be told from chance",
    },
)


# --- 10.5 possible_hits ---


def _possible(mean_cost: float, n_pictures: int, most_hits: int, /, **changed: Any) -> Array:
    """Try one number of hits after the other, with one thing done in another way."""
    weight = changed.get("weight", 1.333)
    found = []
    for hits in range(changed.get("first", 0), most_hits + changed.get("more", 1)):
        rest = n_pictures * mean_cost + changed.get("sign", 1) * weight * hits
        whole = changed.get("whole", round)(rest)
        off = abs(rest - whole) / n_pictures
        if off <= changed.get("near", 0.0005) + changed.get("slack", 1e-9) and (
            whole >= 0 or changed.get("negative")
        ):
            found.append(changed.get("shown", lambda hits, whole: hits)(hits, whole))
    return np.array(found, dtype=int)


def _possibles(**changed: Any) -> Callable[..., Any]:
    return lambda mean_cost, n_pictures, most_hits: _possible(mean_cost, n_pictures, most_hits, **changed)


def _possible_fives(mean_cost: float, n_pictures: int, most_hits: int) -> Array:
    """Missed corners forgotten: the rest must be false ones, five each."""
    hits = np.arange(most_hits + 1)
    fives = np.round((n_pictures * mean_cost + 1.333 * hits) / 5)
    return hits[np.abs((5 * fives - 1.333 * hits) / n_pictures - mean_cost) <= 0.0005]


def _possible_equal(mean_cost: float, n_pictures: int, most_hits: int) -> Array:
    hits = np.arange(most_hits + 1)
    rest = np.round(n_pictures * mean_cost + 1.333 * hits)
    return hits[(np.round((rest - 1.333 * hits) / n_pictures, 3) == mean_cost) & (rest >= 0)]


def _possible_mask(mean_cost: float, n_pictures: int, most_hits: int) -> Array:
    hits = np.arange(most_hits + 1)
    return np.isin(hits, _possible(mean_cost, n_pictures, most_hits))


def _possible_rounded(mean_cost: float, n_pictures: int, most_hits: int) -> Array:
    """By what would be printed, for all whole numbers near by."""
    hits, more = np.arange(most_hits + 1)[:, None], np.array([-1, 0, 1])
    whole = np.floor(n_pictures * mean_cost + 1.333 * hits) + more
    printed = np.floor(1000 * (whole - 1.333 * hits) / n_pictures + 0.5 + 1e-7)
    below = np.ceil(1000 * (whole - 1.333 * hits) / n_pictures - 0.5 - 1e-7)
    wanted = round(1000 * mean_cost)
    return hits[(((printed == wanted) | (below == wanted)) & (whole >= 0)).any(axis=1), 0]


def _possible_thousandths(mean_cost: float, n_pictures: int, most_hits: int) -> list[int]:
    """All in thousandths, as whole numbers: within n / 2 of a multiple of 1000."""
    total, found = round(1000 * mean_cost) * n_pictures, []
    for hits in range(most_hits + 1):
        rest = total + 1333 * hits
        whole = (rest + 500) // 1000
        if 2 * abs(rest - 1000 * whole) <= n_pictures and whole >= 0:
            found.append(hits)
    return found


def _possible_public() -> list[Case]:
    return [
        Case((2.122, 30, 10), "2.122, up to 10 hits"),
        Case((2.122, 30, 40), "2.122, up to 40 hits"),
        Case((4.755, 30, 240), "4.755, thirty pictures"),
        Case((4.223, 30, 100), "4.223, thirty pictures"),
        Case((-1.333, 3, 8), "a negative mean of three pictures"),
        Case((1.834, 2, 30), "two pictures"),
        Case((5.002, 30, 136), "5.002, up to 136 hits"),
        Case((2.0, 1, 6), "one picture"),
        Case((3.501, 500, 9), "500 pictures"),
    ]


def _printed(rng: np.random.Generator, pictures: int) -> float:
    """A mean as it would be printed, not at the edge of rounding."""
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
    ]


POSSIBLE_HITS = Exercise(
    name="possible_hits",
    points=3,
    stars=2,
    public=_possible_public,
    hidden=_possible_hidden,
    comparison=Close(),
    hints=(
        "With a number of hits given, 5 n_f + n_m is the whole number nearest to n_pictures * mean_cost + 1.333 * hits, or there is none. Compute the mean from it, and ask whether it is "
        "near enough.",
        "hits = np.arange(most_hits + 1), and all at once from there: np.round(...) gives the nearest whole numbers. They must not be below 0. The means may be "
        "0.0005 off, and a breath more (1e-9) for what floats do.",
    ),
    mistakes=[
        Mistake(
            "four thirds",
            _possibles(weight=4 / 3),
            "You take four thirds for a hit. Table 6.1 prints 1.333, and with many hits the difference shows.",
        ),
        Mistake(
            "rounded down",
            _possibles(whole=np.floor),
            "You take the whole number below n * mean + 1.333 n_h only. The nearest may be above: np.round.",
        ),
        Mistake(
            "rounded up",
            _possibles(whole=np.ceil),
            "You take the whole number above n * mean + 1.333 n_h only. The nearest may be below: np.round.",
        ),
        Mistake(
            "no breath for floats",
            _possibles(slack=0.0),
            "A mean that is off by 0.0005 exactly is lost to a float's last digit in yours: allow 1e-9 more.",
        ),
        Mistake(
            "rounded and held against it",
            _possible_equal,
            "You round the mean and ask for ==. A mean that lies exactly between two printed ones may be printed as either: use the bound of equation 10.3.",
        ),
        Mistake(
            "nothing may be rounded",
            _possibles(near=0.0),
            "You ask for the printed mean exactly. It was rounded to three digits: 0.0005 to either side.",
        ),
        Mistake(
            "a digit too coarse",
            _possibles(near=0.005),
            "You allow 0.005. The means are printed with three digits: they are off by 0.0005 at most.",
        ),
        Mistake(
            "a whole unit",
            _possibles(near=0.001),
            "You allow 0.001. A number that is rounded to three digits is off by half of that at most.",
        ),
        Mistake(
            "the last one left out",
            _possibles(more=0),
            "most_hits itself may be, too: np.arange(n) ends at n - 1.",
        ),
        Mistake(
            "from one on",
            _possibles(first=1),
            "No hit at all is a number of hits, too: begin with 0.",
        ),
        Mistake(
            "signs lost",
            _possibles(sign=-1),
            "The sum is 5 n_f + n_m - 1.333 n_h. What is left for 5 n_f + n_m is the sum plus 1.333 n_h.",
        ),
        Mistake(
            "missed corners forgotten",
            _possible_fives,
            "You ask for multiples of 5. A missed corner costs 1, so 5 n_f + n_m can be any whole number from 0 on.",
        ),
        Mistake(
            "a mask",
            _possible_mask,
            "That is true and false. The numbers of hits are wanted: hits[mask].",
        ),
        Mistake(
            "below nothing",
            _possibles(negative=True),
            "For few hits your 5 n_f + n_m is below 0. Nobody misses fewer than no corners.",
        ),
        Mistake(
            "how many there are",
            lambda mean_cost, n_pictures, most_hits: len(_possible(mean_cost, n_pictures, most_hits)),
            "You return how many there are. The numbers of hits themselves are wanted, as an array.",
        ),
        Mistake(
            "thirty pictures always",
            lambda mean_cost, n_pictures, most_hits: _possible(mean_cost, 30, most_hits),
            "You take thirty pictures, whatever n_pictures is.",
        ),
        Mistake(
            "the rest",
            _possibles(shown=lambda hits, whole: whole),
            "You return 5 n_f + n_m. The numbers of hits are wanted.",
        ),
    ],
    alternatives={
        "a loop": _possibles(),
        "as it would be printed": _possible_rounded,
        "in thousandths": _possible_thousandths,
    },
    equivalents={
        "return hits[(off <= 0.0005 + 1e-09) * (others >= 0)]": "and of truths is their product",
        "return hits[(off < 0.0005 + 1e-09) & (others >= 0)]": "no mean lies at 0.000500001 exactly",
        "off = np.abs(mean_cost - (others - 1.333 * hits) / n_pictures)": "a difference the other way round is as far from 0",
    },
)


# --- 10.6 error_budget ---


def _budget(
    pose: Any, landmarks: Any, view: CameraView, pixel_sigma: float, tilt_sigma: float, /, **changed: Any
) -> Any:
    """Gain and both parts of R, with one thing done in another way."""
    pose, landmarks = np.asarray(pose, float), np.asarray(landmarks, float)
    where = landmarks if changed.get("world") else Pose.from_array(pose).to_local(landmarks)
    pixels = view.project(where)
    by_pixels = np.asarray(measurement_covariance(pixels, view, pixel_sigma, 0.0))
    by_tilt = np.asarray(measurement_covariance(pixels, view, 0.0, tilt_sigma))
    if changed.get("blocks"):
        by_tilt = by_tilt * np.kron(np.eye(len(landmarks)), np.ones((2, 2)))
    H = np.vstack([measurement_jacobian_pose(pose, each) for each in landmarks])
    R = changed.get("weigh", lambda D, T: D + T)(by_pixels, by_tilt)
    information = H.T @ np.linalg.solve(R, H)
    gain = np.linalg.solve(information, np.linalg.solve(R, H).T)
    if changed.get("alone"):
        left = [np.linalg.inv(H.T @ np.linalg.pinv(each, rcond=1e-12) @ H) for each in (by_pixels, R)]
        return changed.get("shown", lambda D, R: (D, R))(*left)
    parts = tuple(gain @ each @ gain.T for each in (by_pixels, by_tilt))
    return changed.get("shown", lambda D, T: (D, T))(*parts)


def _budgets(**changed: Any) -> Callable[..., Any]:
    return lambda pose, landmarks, view, pixel_sigma, tilt_sigma: _budget(
        pose, landmarks, view, pixel_sigma, tilt_sigma, **changed
    )


def _budget_less(pose: Any, landmarks: Any, view: CameraView, pixel_sigma: float, tilt_sigma: float) -> Any:
    """The whole, and what is not from the tilt."""
    pixels = view.project(landmarks, Pose(*map(float, pose)))
    R = measurement_covariance(pixels, view, pixel_sigma, tilt_sigma)
    H = np.concatenate([measurement_jacobian_pose(pose, each) for each in landmarks])
    W = np.linalg.inv(R)
    P = np.linalg.inv(H.T @ W @ H)
    tilt = P @ H.T @ W @ measurement_covariance(pixels, view, 0.0, tilt_sigma) @ W @ H @ P
    return P - tilt, tilt


def _budget_whitened(
    pose: Any, landmarks: Any, view: CameraView, pixel_sigma: float, tilt_sigma: float
) -> Any:
    """Least squares of what was whitened."""
    pixels = view.project(Pose.from_array(np.asarray(pose)).to_local(landmarks))
    parts = [measurement_covariance(pixels, view, *each) for each in ((pixel_sigma, 0.0), (0.0, tilt_sigma))]
    white = np.linalg.inv(np.linalg.cholesky(parts[0] + parts[1]))
    H = np.vstack([measurement_jacobian_pose(pose, each) for each in landmarks])
    gain = np.linalg.pinv(white @ H) @ white
    return [gain @ each @ gain.T for each in parts]


def _sight(rng: np.random.Generator, k: int, pose: Any = None) -> tuple[Array, Array, CameraView]:
    """A pose, k landmarks before it, and a view."""
    view = NAO_V4.view(
        "bottom", float(rng.uniform(-0.3, 0.3)), float(np.radians(rng.uniform(-27, -20))), (320, 240)
    )
    pose = (
        np.array([rng.uniform(-1, 2), rng.uniform(-1.5, 1.5), rng.uniform(-3, 3)])
        if pose is None
        else np.array(pose)
    )
    ahead = np.array([(rng.uniform(1.0, 3.5), rng.uniform(-0.35, 0.35)) for _ in range(k)])
    turn = view.yaw + ahead[:, 1]
    local = np.column_stack([ahead[:, 0] * np.cos(turn), ahead[:, 0] * np.sin(turn)])
    return pose, Pose.from_array(pose).to_parent(local), view


def _budget_public() -> list[Case]:
    rng = np.random.default_rng(106)
    return [
        Case((*_sight(rng, 3, (1.0, 0.2, -0.1)), 2.0, 0.0175), "three landmarks"),
        Case((*_sight(rng, 2), 1.0, 0.03), "two landmarks"),
        Case((*_sight(rng, 5), 4.0, 0.005), "five landmarks, hardly any tilt"),
        Case((*_sight(rng, 3), 2.0, 0.0), "no tilt"),
    ]


def _budget_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case((*_sight(rng, k), float(rng.uniform(0.5, 4)), float(rng.uniform(0.005, 0.04))))
        for k in (2, 3, 3, 4, 6)
    ] + [Case((*_sight(rng, 3), 1.5, 0.0))]


ERROR_BUDGET = Exercise(
    name="error_budget",
    points=4,
    stars=3,
    public=_budget_public,
    hidden=_budget_hidden,
    comparison=Close(rtol=2e-3, atol=1e-9),
    uses=["04:measurement_covariance", "05:measurement_jacobian_pose"],
    hints=(
        "view.project(landmarks, Pose(*pose)) says where the landmarks are in the picture. measurement_covariance with one of its sigmas 0 is D, or the tilt's part. H has two rows for each landmark.",
        "W is the inverse of R, in both parts: the robot weighs by what it knows of all errors. P = inv(Hᵀ W H), K = P Hᵀ W, and the parts are K D Kᵀ and K (R - D) Kᵀ.",
    ),
    mistakes=[
        Mistake(
            "one source at a time",
            _budgets(alone=True),
            "You compute what would be left if there were one source only, with weights made for it. The weights are those of R in both parts.",
        ),
        Mistake(
            "weighed by the pixels",
            _budgets(weigh=lambda D, T: D),
            "Your weights know of the pixels only. The robot weighs by R, which has the tilt, too.",
        ),
        Mistake(
            "not weighed",
            _budgets(weigh=lambda D, T: np.eye(len(D))),
            "All your measurements have the same weight, radians and metres alike. The weights are the inverse of R.",
        ),
        Mistake(
            "variances only",
            _budgets(weigh=lambda D, T: np.diag(np.diag(D + T))),
            "Your weights know the variances only. The tilt moves all measurements together: invert R whole.",
        ),
        Mistake(
            "what is left without one source",
            _budgets(alone=True, shown=lambda D, R: (D, R - D)),
            "You subtract what would be left if there were no tilt, with weights made for that. The weights are those of R in both parts.",
        ),
        Mistake(
            "the whole first",
            _budgets(shown=lambda D, T: (D + T, T)),
            "Your first part is the whole covariance. Only what comes from the pixels is wanted.",
        ),
        Mistake(
            "roots",
            _budgets(shown=lambda D, T: (np.sqrt(np.abs(D)), np.sqrt(np.abs(T)))),
            "You take roots of the covariances. They are wanted as they are: only they add up.",
        ),
        Mistake(
            "each landmark its own tilt",
            _budgets(blocks=True),
            "You keep the blocks of the tilt's covariance only, as if each landmark leaned on its own. It is one tilt for all of a picture.",
        ),
        Mistake(
            "landmarks in the field frame",
            _budgets(world=True),
            "The pixels are wrong: view.project takes points in the robot frame, or the robot's pose as its second argument.",
        ),
        Mistake(
            "changed places",
            _budgets(shown=lambda D, T: (T, D)),
            "The two parts have changed places: pixels first, then the tilt.",
        ),
        Mistake(
            "standard deviations",
            _budgets(shown=lambda D, T: (np.sqrt(np.abs(np.diag(D))), np.sqrt(np.abs(np.diag(T))))),
            "Those are standard deviations. The covariances are wanted, (3, 3) each: only they add up.",
        ),
        Mistake(
            "both added",
            _budgets(shown=lambda D, T: (D, D + T)),
            "Your second part is the whole covariance. Only what the tilt adds is wanted.",
        ),
        Mistake(
            "shares",
            _budgets(shown=lambda D, T: (D / np.trace(D + T), T / np.trace(D + T))),
            "Those are parts of the whole, without units. The covariances themselves are wanted.",
        ),
    ],
    alternatives={
        "by the declaration's own functions": _budgets(),
        "the whole less the tilt": _budget_less,
        "whitened": _budget_whitened,
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
            "The paper prints a sigma beside each mean, 0.322 beside 2.122, and does not say of what. Your costs of single pictures have one of 1.5 to 5.7. Which reading fits?",
            {
                "The sigma of a single picture's cost.": "Then all thirty pictures would cost nearly the same, between 1.5 and 2.8. One false corner more costs 5.",
                "The standard error of the mean.": "It is a picture's sigma divided by the root of 30, and yours is 0.3 to 1.0. The paper's are from 0.3 to 2.6: "
                "the small ones fit, the large ones would need pictures with a sigma of 14.",
                "Neither fits all 27 rows.": "The smallest are too small for single pictures, the largest too large for a mean of thirty. A number without its definition cannot be "
                "used.",
            },
            "Neither fits all 27 rows.",
        ),
        Question(
            "why_paired",
            "Two settings cost 1.1 and 1.6 on the same thirty pictures, each with an interval of 1.6 in width. Is the first one better?",
            {
                "No: the intervals overlap by far.": "Both intervals are wide because some pictures are hard. They are hard for both settings, so most of that width is "
                "common to both.",
                "Yes: its mean is smaller.": "With thirty other pictures the order may turn. How likely that is has to be asked.",
                "Ask the interval of the difference, picture by picture.": "Taken off picture by picture, what is hard for both is gone. If that interval contains 0, "
                "nobody knows which is better.",
            },
            "Ask the interval of the difference, picture by picture.",
        ),
        Question(
            "why_so_little",
            "Of a single range at 2 m the tilt is the larger part, and of the pose from four landmarks by far the smaller. Why?",
            {
                "The pose is an average, and averaging makes every error small.": "It does so with errors that are independent, as those of pixels are. The tilt is one number, and no average of "
                "four ranges that are off alike makes it smaller.",
                "The four landmarks tell the tilt themselves.": "Eight measurements, three unknowns of the pose and one tilt: what it does to all four at once cannot be explained by any pose. "
                "The weights know that, and leave it out.",
                "One degree is less than 3.3 pixels.": "A pixel is 0.2 degrees here, so 3.3 pixels are 0.7: no large difference, and the figure of ranges says so.",
            },
            "The four landmarks tell the tilt themselves.",
        ),
    ],
    written=[
        Written(
            "experiment_report",
            points=6,
            question="A report of one page on your search: question, method, results with figures and intervals, what they mean, and what would make you change your mind.",
            rubric="1 point, method: pictures (how many, which, that they are the simulator's), what counts as a hit (8 px, one-to-one, a crossing X counts as false), the weights, the 27 settings. "
            "1 point, baseline: the cost of reporting nothing on the same pictures, and each result held against it. 1 point, uncertainty: an interval with its probability for the setting that is "
            "named, and the difference from others or from nothing in pairs. 1 point, choice: it says that the best of 27 on the pictures it was chosen on looks better than it is, and gives the number or reports on other pictures. "
            "1 point, the paper: what of Table A.1 agrees and what does not (rank correlation, means that thirty pictures cannot give, sigma undefined), with another explanation than carelessness considered. "
            "1 point, conclusion: it follows from the numbers, names at least one limit (simulator, one resolution, few pictures, one detector) and what result would change it. Take a point off where a figure that is needed is not named, or a number stands without its unit.",
        )
    ],
)
