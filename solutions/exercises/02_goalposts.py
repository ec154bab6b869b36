"""Lesson 02, goal posts: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from scipy.cluster.hierarchy import fcluster, linkage

from nao_course.exercises import Case, Exercise, LessonPlan, Mistake, Points, Question, Written

Array = npt.NDArray[Any]
OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3


# --- labels to try things on ---


def field(rows: int, columns: int, horizon: int) -> Array:
    """Labels of carpet below a wall."""
    labels = np.zeros((rows, columns), dtype=np.uint8)
    labels[horizon:] = GREEN
    return labels


def stand(labels: Array, left: int, width: int, top: int, foot: int) -> Array:
    """Put a post there: columns left to left + width - 1, rows top to foot."""
    labels[top : foot + 1, left : left + width] = YELLOW
    return labels


def scattered(rng: np.random.Generator, rows: int, columns: int) -> Array:
    """Labels that look like nothing: runs of all four in each column, with yellow and green the most."""
    labels = np.zeros((rows, columns), dtype=np.uint8)
    for u in range(columns):
        v = 0
        while v < rows:
            length = int(rng.integers(1, max(3, rows // 4)))
            labels[v : v + length, u] = rng.choice([OTHER, GREEN, GREEN, YELLOW, YELLOW, WHITE])
            v += length
    return labels


# --- 2.1 post_candidates ---


def _search(
    labels: Any, min_green: int, look_down: int, min_height: float, **changed: Any
) -> list[tuple[float, float]]:
    """The search column by column, with one thing done in another way."""
    labels = np.asarray(labels)
    height, width = labels.shape
    needed = min_height * (width if changed.get("of_width") else 1 if changed.get("in_pixels") else height)
    found = []
    for u in range(width):
        column = labels[:, u]
        rows = np.flatnonzero(column == YELLOW)
        order = rows if changed.get("top_down") else rows[::-1]
        for v in order:
            below = column[v + 1 : v + 1 + look_down + changed.get("longer", 0)]
            if changed.get("own_pixel"):
                below = column[v : v + look_down]
            if changed.get("above"):
                below = column[max(v - look_down, 0) : v]
            if changed.get("round_the_edge"):
                below = np.roll(column, -v - 1)[:look_down]
            green = int((below == GREEN).sum())
            if changed.get("contiguous"):
                green = int(np.cumprod(below == GREEN).sum())
            wanted = 1 if changed.get("any_green") else min_green
            enough = green > wanted if changed.get("more_green") else green >= wanted
            if changed.get("no_rule"):
                enough = True
            if changed.get("mean_of_what_is_left"):
                enough = len(below) > 0 and green / len(below) >= min_green / look_down
            above = column[: v + 1][::-1]
            run = int((above == YELLOW).sum() if changed.get("gaps") else np.cumprod(above == YELLOW).sum())
            high = run > needed if changed.get("more_height") else run >= needed
            if changed.get("run_without_foot"):
                high = run - 1 >= needed
            if changed.get(
                "no_height"
            ):  # as with a height in pixels: no run is shorter than a part of a pixel
                high = True
            if enough and high:
                at = v - run + 1 if changed.get("top_saved") else v
                found.append((float(u), float(at)))
                break
            if not changed.get("goes_on"):
                break
    return found


def _candidates(labels: Any, min_green: int, look_down: int, min_height: float, **changed: Any) -> Array:
    found = _search(labels, min_green, look_down, min_height, **changed)
    return np.array(found, dtype=float).reshape(-1, 2)


def _changed(**changed: Any) -> Any:
    """The search as a function of an exercise's arguments, with something changed."""

    def function(labels: Any, min_green: int, look_down: int, min_height: float) -> Array:
        return _candidates(labels, min_green, look_down, min_height, **changed)

    return function


def _row_first(labels: Any, min_green: int, look_down: int, min_height: float) -> Array:
    return _candidates(labels, min_green, look_down, min_height)[:, ::-1]


def _no_shape(labels: Any, min_green: int, look_down: int, min_height: float) -> Array:
    return np.array(_search(labels, min_green, look_down, min_height))


def _a_mask(labels: Any, min_green: int, look_down: int, min_height: float) -> Array:
    mask = np.zeros(np.shape(labels), dtype=bool)
    for u, v in _search(labels, min_green, look_down, min_height):
        mask[int(v), int(u)] = True
    return mask


def _over_the_edge(labels: Any, min_green: int, look_down: int, min_height: float) -> Array:
    """The climb asks no row whether it is still in the picture: labels[-1, u] is the lowest again, and so on."""
    labels = np.asarray(labels)
    for u, v in _candidates(labels, min_green, look_down, 0.0).astype(int):
        n = 0
        while labels[v - n, u] == YELLOW:
            n += 1
    return _candidates(labels, min_green, look_down, min_height)


def _with_height(needed: Any) -> Any:
    """The search with another least height in pixels, needed(min_height * H)."""

    def function(labels: Any, min_green: int, look_down: int, min_height: float) -> Array:
        height = np.shape(labels)[0]
        return _candidates(labels, min_green, look_down, needed(min_height * height) / height)

    return function


def _height_of_240(labels: Any, min_green: int, look_down: int, min_height: float) -> Array:
    return _candidates(labels, min_green, look_down, min_height * 240 / np.shape(labels)[0])


def _nothing(*given: Any) -> Array:
    return np.zeros((0, 2))


def _candidates_list(labels: Any, min_green: int, look_down: int, min_height: float) -> Any:
    found = _search(labels, min_green, look_down, min_height)
    return np.array([(int(u), int(v)) for u, v in found]).reshape(-1, 2)


def _candidates_by_rows(labels: Any, min_green: int, look_down: int, min_height: float) -> Array:
    """All columns at once, one row after the other from the bottom."""
    labels = np.asarray(labels)
    height, width = labels.shape
    foot, run, climbing = np.full(width, -1), np.zeros(width, dtype=int), np.zeros(width, dtype=bool)
    for v in range(height - 1, -1, -1):
        yellow = labels[v] == YELLOW
        starts = yellow & (foot < 0)
        foot[starts] = v
        climbing = (climbing | starts) & yellow
        run += climbing
    padded = np.vstack([labels, np.zeros((look_down, width), dtype=labels.dtype)])
    good = np.array(
        [(padded[f + 1 : f + 1 + look_down, u] == GREEN).sum() >= min_green for u, f in enumerate(foot)]
    )
    good &= (foot >= 0) & (run >= min_height * height)
    return np.array([np.flatnonzero(good), foot[good]], dtype=np.float32).T[::-1]


def _candidates_by_sums(labels: Any, min_green: int, look_down: int, min_height: float) -> Array:
    """With cumulative sums: how many green above each row, and where a column was last not yellow."""
    labels = np.asarray(labels)
    height, width = labels.shape
    rows = np.arange(height)[:, None]
    foot = np.where(labels == YELLOW, rows, -1).max(axis=0)
    there = np.flatnonzero(foot >= 0)
    foot = foot[there]
    green = np.vstack([np.zeros((1, width), dtype=int), np.cumsum(labels == GREEN, axis=0)])
    below = green[np.minimum(foot + 1 + look_down, height), there] - green[foot + 1, there]
    gap = np.where((labels[:, there] != YELLOW) & (rows < foot), rows, -1).max(axis=0)
    good = (below >= min_green) & (foot - gap >= min_height * height)
    return np.stack([there[good], foot[good]], axis=1)


def _columns(*columns: str) -> Array:
    """Labels written as columns from the top: o other, g green, y yellow, w white."""
    return np.array([["ogyw".index(letter) for letter in column] for column in columns], dtype=np.uint8).T


def _candidates_public() -> list[Case]:
    goal = stand(stand(field(32, 44, 12), 6, 4, 0, 21), 33, 3, 0, 17)
    goal[0:2, 6:36] = YELLOW  # the bar
    goal[22:24] = WHITE  # the line they stand on
    goal[4:11, 16:22] = YELLOW  # a bag behind the field
    goal[25:27, 24:27] = YELLOW  # too low for a post
    return [
        Case((goal, 3, 8, 0.25), "a goal, a bag behind the field and something low"),
        Case(
            (_columns("ooyyyygg", "ooyyyygw", "ooyyyyww", "ooyyyogg"), 2, 2, 0.5),
            "four columns of 8 pixels, all or nothing",
        ),
        Case(
            (_columns("oyyyyggoyggg", "yyyygggwyooo", "yyyyggggoyow"), 3, 4, 0.25),
            "yellow with green below, and lower yellow without it",
        ),
        Case((_columns("yyyyoyygggww", "yyyyyyygggww", "yyoyyyygggww"), 2, 4, 0.5), "posts with holes"),
        Case((_columns("ooyyyygg", "oooyyyyg", "ooooyyyy"), 1, 4, 0.25), "at the lower edge"),
        Case((_columns("ooyyyygg", "oooyyyyg"), 2, 4, 0.25), "at the lower edge, two of four green"),
        Case(
            (_columns("yyyyyyyy", "oyyyyyyy"), 0, 3, 0.5), "yellow down to the lower edge, no green asked for"
        ),
        Case((_columns("oyyogyog", "gooyyygg"), 0, 2, 0.0), "neither green nor height asked for"),
        Case(
            (_columns("gggyyyyy", "gggyyyyw"), 1, 3, 0.25), "nothing but the edge below, and green at the top"
        ),
        Case(
            (_columns("gyyyygwgww", "gyyyywgwgg", "ggyyygwggg", "gggyygwggg"), 2, 3, 0.25),
            "green and white in turns, runs of 4, 3 and 2 of 10",
        ),
        Case((field(12, 10, 4), 2, 3, 0.25), "no yellow at all"),
        Case((scattered(np.random.default_rng(21), 24, 40), 2, 5, 0.125), "labels by chance"),
    ]


def _candidates_hidden(rng: np.random.Generator) -> list[Case]:
    goal = stand(field(240, 320, 70), int(rng.integers(20, 60)), 14, 0, int(rng.integers(110, 140)))
    stand(goal, int(rng.integers(200, 240)), 12, 0, int(rng.integers(95, 110)))
    goal[140:146] = WHITE
    goal[20:60, 120:150] = YELLOW
    goal[rng.random(goal.shape) < 0.004] = OTHER
    return [
        Case((goal, 8, 10, 0.125)),
        *(
            Case((scattered(rng, rows, 60), int(rng.integers(1, 5)), int(rng.integers(5, 9)), 0.125))
            for rows in (24, 28, 40, 44)
        ),
        Case((scattered(rng, 40, 30), 0, 5, 0.125)),
        Case((scattered(rng, 20, 64), 2, 2, 0.25)),
        Case((scattered(rng, 64, 20), 3, 30, 0.0625)),
        Case((stand(field(20, 30, 6), int(rng.integers(4, 20)), 3, 4, 11), 0, 4, 0.0)),
        Case(
            (
                _columns("ooyyyygg", "oooyyyyg", "ooooyyyy", "ogyyyygw", "yyyygggw"),
                int(rng.integers(1, 3)),
                4,
                0.5,
            )
        ),
        Case((np.full((12, int(rng.integers(5, 9))), YELLOW, dtype=np.uint8), 1, 4, 0.25)),
        Case((np.full((12, int(rng.integers(5, 9))), YELLOW, dtype=np.uint8), 0, 4, 0.25)),
        Case((_columns("ooyyyygg", "oooyyyyg", "ogyyyygw"), 2, int(rng.integers(4, 7)), 0.25)),
        Case((field(16, int(rng.integers(8, 20)), 5), 1, 4, 0.25)),
    ]


POST_CANDIDATES = Exercise(
    name="post_candidates",
    points=4,
    stars=2,
    public=_candidates_public,
    hidden=_candidates_hidden,
    comparison=Points(tolerance=0.4),
    hints=(
        "Write it for one column first: np.flatnonzero(labels[:, u] == 2) has its yellow rows, and the last of them is the foot, "
        "because rows count downwards. Then two tests with slices of that column, and a loop over the columns around it.",
        "Below the foot: labels[foot + 1 : foot + 1 + look_down, u], which a slice cuts off at the picture's edge by itself. Above: climb "
        "from the foot while the pixel is yellow, and count. The post needs at least min_height * labels.shape[0] of them, the foot included.",
    ),
    mistakes=[
        Mistake(
            "nothing found",
            _nothing,
            "You find nothing, whatever the picture. One of the two tests never passes: print the green pixels and the run of one column.",
        ),
        Mistake(
            "height of 240 rows",
            _height_of_240,
            "You ask for min_height * 240 pixels. The pictures here have fewer rows: labels.shape[0] says how many.",
        ),
        Mistake(
            "share of what is left",
            _changed(mean_of_what_is_left=True),
            "At the lower edge you take the share of the few pixels that are left. Count the green ones: what is below the last row is not green.",
        ),
        Mistake(
            "climbs over the edge",
            _over_the_edge,
            "A column that is yellow from top to bottom makes your climb leave the picture: labels[-1, u] is the lowest row again. Stop at row 0.",
        ),
        Mistake(
            "height rounded down",
            _with_height(int),
            "int() rounds down: a run of 2 pixels is lower than 0.25 of 10 rows, which is 2.5. Compare with the number as it is.",
        ),
        Mistake(
            "more than both",
            _changed(more_green=True, more_height=True),
            "Exactly min_green green pixels and exactly the least height count: at least means >=, both times.",
        ),
        Mistake(
            "top-down",
            _changed(top_down=True),
            "You start at the top: your points are where yellow begins. The scan goes from the bottom to the top, and the first yellow pixel "
            "on the way is the foot.",
        ),
        Mistake(
            "goes on after the failure",
            _changed(goes_on=True),
            "In some columns you go on searching after the first yellow pixel has failed. Such a column is given up: what is higher in it is "
            "part of a mast, or of the room.",
        ),
        Mistake(
            "run with gaps",
            _changed(gaps=True),
            "You count all yellow pixels of a column. Only the run that begins at the foot counts, up to the first pixel that is not yellow.",
        ),
        Mistake(
            "height in pixels",
            _changed(in_pixels=True),
            "Runs of any height pass, even of one pixel. min_height is a part of the picture's height: a run needs min_height * labels.shape[0] pixels.",
        ),
        Mistake(
            "part of the width",
            _changed(of_width=True),
            "min_height is a part of the picture's height, labels.shape[0]. You take it of the width.",
        ),
        Mistake(
            "(row, column)",
            _row_first,
            "Your points are (row, column). In this course a point is (u, v): the column first, then the row.",
        ),
        Mistake(
            "green without a gap",
            _changed(contiguous=True),
            "You count green only up to the first pixel that is not green. All of the look_down pixels count: a white line may lie between them.",
        ),
        Mistake(
            "any green",
            _changed(any_green=True),
            "One green pixel is enough for you. It takes min_green of them.",
        ),
        Mistake(
            "more than min_green",
            _changed(more_green=True),
            "A column with exactly min_green green pixels counts: at least means >=.",
        ),
        Mistake(
            "more than min_height",
            _changed(more_height=True),
            "A run that is exactly min_height high counts: at least means >=.",
        ),
        Mistake(
            "the foot not counted",
            _changed(run_without_foot=True),
            "Your runs are one pixel too short: the foot itself belongs to the run.",
        ),
        Mistake(
            "the foot among those below",
            _changed(own_pixel=True),
            "You look at one pixel too few: the first of the look_down pixels is the one below the foot, not the foot.",
        ),
        Mistake(
            "one pixel too many",
            _changed(longer=1),
            "You look at look_down + 1 pixels: a slice ends before its second number, so it is foot + 1 : foot + 1 + look_down.",
        ),
        Mistake(
            "looks up",
            _changed(above=True),
            "You look for green above the foot. Rows count downwards: below it are the larger ones.",
        ),
        Mistake(
            "round the edge",
            _changed(round_the_edge=True),
            "At the lower edge you find green that is not there: it is that of the picture's top. Below the last row there is nothing.",
        ),
        Mistake(
            "no look-down rule",
            _changed(no_rule=True),
            "You take columns without green below the foot: min_green is not used.",
        ),
        Mistake(
            "the post's top",
            _changed(top_saved=True),
            "You found the right columns, and give the rows where the runs end. The point is the foot, where they begin.",
        ),
        Mistake(
            "no shape",
            _no_shape,
            "Right, except where there is no candidate: np.array([]) has shape (0,). Make it (0, 2) with .reshape(-1, 2).",
        ),
        Mistake(
            "a mask",
            _a_mask,
            "That is a mask of the picture's size. Points are wanted, one row (u, v) each.",
        ),
    ],
    alternatives={
        "a loop over columns, whole numbers": _candidates_list,
        "all columns, row after row": _candidates_by_rows,
        "cumulative sums": _candidates_by_sums,
    },
    equivalents={
        "green = (labels[np.minimum(below, height - 1), columns[:, None]] == 1) * (below < height)": "* of two boolean arrays is their &",
        "green = (labels[np.minimum(below, height - 1), columns[:, None]] == 1) // (below < height)": "1 // 1 is 1, and all other quotients of NumPy's booleans are 0",
        "good = (green.sum(axis=1) >= min_green) * yellow.all(axis=1)": "* of two boolean arrays is their &",
        "below = foot[:, None] + np.arange(0, look_down + 1)": "the foot itself is yellow, so it adds no green",
        "return np.column_stack([columns[good], foot[good]])": "whole numbers are the same points",
        "run = foot[:, None] - np.arange(min_height * height, dtype=int)": "np.arange has as many numbers below a stop that is not whole as below the next whole one",
        "green = (labels[np.minimum(height - 1, below), columns[:, None]] == 1) & (below < height)": "the smaller of two numbers does not depend on their order",
    },
)


# --- 2.2 cluster_points ---


def _clusters(points: Any, max_distance: float, middle: Any = None, near: Any = None) -> Array:
    """Single linkage by growing groups, with another middle or another idea of near."""
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    middle = middle or (lambda group: group.mean(axis=0))
    near = near or (lambda a, b: np.hypot(*(a - b)) <= max_distance)
    left, out = list(range(len(points))), []
    while left:
        group, waiting = [], [left.pop(0)]
        while waiting:
            one = waiting.pop()
            group.append(one)
            joined = [other for other in left if near(points[one], points[other])]
            left = [other for other in left if other not in joined]
            waiting += joined
        out.append(middle(points[group]))
    return np.array(out).reshape(-1, 2)


def _with(**changed: Any) -> Any:
    return lambda points, max_distance: _clusters(points, max_distance, **changed)


def _near(distance: Any) -> Any:
    """Clusters with another distance between two points."""
    return lambda points, max_distance: _clusters(
        points, max_distance, near=lambda a, b: distance(*np.abs(a - b)) <= max_distance
    )


def _to_first(points: Any, max_distance: float) -> Array:
    """Each point joins the first group whose first point is near."""
    groups: list[list[Array]] = []
    for point in np.asarray(points, dtype=float).reshape(-1, 2):
        home = next((g for g in groups if np.hypot(*(g[0] - point)) <= max_distance), None)
        if home is None:
            groups.append([point])
        else:
            home.append(point)
    return np.array([np.mean(g, axis=0) for g in groups]).reshape(-1, 2)


def _to_any(points: Any, max_distance: float) -> Array:
    """Each point joins the first group with a near point; groups never join."""
    groups: list[list[Array]] = []
    for point in np.asarray(points, dtype=float).reshape(-1, 2):
        home = next((g for g in groups if any(np.hypot(*(p - point)) <= max_distance for p in g)), None)
        if home is None:
            groups.append([point])
        else:
            home.append(point)
    return np.array([np.mean(g, axis=0) for g in groups]).reshape(-1, 2)


def _first_by(column: int) -> Any:
    """Points in the order of a column, each into the first group that has a near one; groups never join."""

    def function(points: Any, max_distance: float) -> Array:
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        return _to_any(points[np.argsort(points[:, column], kind="stable")], max_distance)

    return function


def _to_last(points: Any, max_distance: float) -> Array:
    """In the order of the columns, each into the first group whose last point is near."""
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    groups: list[list[Array]] = []
    for point in points[np.argsort(points[:, 0], kind="stable")]:
        home = next((g for g in groups if np.hypot(*(g[-1] - point)) <= max_distance), None)
        if home is None:
            groups.append([point])
        else:
            home.append(point)
    return np.array([np.mean(g, axis=0) for g in groups]).reshape(-1, 2)


def _joined(points: Any, max_distance: float, most: int = 99, wanted: Any = any) -> Array:
    """Each point joins the groups that are near it: at most so many, near any of their points, or all."""
    groups: list[list[Array]] = []
    for point in np.asarray(points, dtype=float).reshape(-1, 2):
        near, far = [], []
        for g in groups:
            (near if wanted(np.hypot(*(p - point)) <= max_distance for p in g) else far).append(g)
        groups = [*far, *near[most:], [point, *(p for g in near[:most] for p in g)]]
    return np.array([np.mean(g, axis=0) for g in groups]).reshape(-1, 2)


def _to_mean(points: Any, max_distance: float) -> Array:
    """Each point joins the first group whose mean is near."""
    groups: list[list[Array]] = []
    for point in np.asarray(points, dtype=float).reshape(-1, 2):
        home = next((g for g in groups if np.hypot(*(np.mean(g, axis=0) - point)) <= max_distance), None)
        if home is None:
            groups.append([point])
        else:
            home.append(point)
    return np.array([np.mean(g, axis=0) for g in groups]).reshape(-1, 2)


def _one_round(points: Any, max_distance: float) -> Array:
    """Each point takes the smallest number among its neighbours, once."""
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    near = np.linalg.norm(points[:, None] - points, axis=2) <= max_distance
    names = np.array([np.flatnonzero(row)[0] for row in near], dtype=int)
    return np.array([points[names == name].mean(axis=0) for name in np.unique(names)]).reshape(-1, 2)


def _to_first_no_shape(points: Any, max_distance: float) -> Array:
    return _to_first(points, max_distance) if len(points) else np.array([])


def _neighbours(points: Any, max_distance: float) -> Array:
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    near = np.linalg.norm(points[:, None] - points, axis=2) <= max_distance
    means = [points[row].mean(axis=0) for row in near]
    return np.unique(np.array(means).reshape(-1, 2), axis=0)


def _wrong_axis(points: Any, max_distance: float) -> Array:
    points = np.asarray(points, dtype=float)
    groups: list[Array] = []
    _clusters(points, max_distance, middle=lambda group: groups.append(group) or np.zeros(2))
    return np.array([[group.mean(axis=1)[0]] * 2 for group in groups]).reshape(-1, 2)


def _number_mean(points: Any, max_distance: float) -> Array:
    return _clusters(points, max_distance, middle=lambda group: np.full(2, group.mean()))


def _deleted(points: Any, max_distance: float) -> Array:
    kept: list[Array] = []
    for point in np.asarray(points, dtype=float).reshape(-1, 2):
        if all(np.hypot(*(point - other)) > max_distance for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 2)


def _no_shape_clusters(points: Any, max_distance: float) -> Array:
    found = _clusters(points, max_distance)
    return found if len(found) else np.array([])


def _empty_mean(points: Any, max_distance: float) -> Array:
    return _clusters(points, max_distance) if len(points) else np.full((1, 2), np.nan)


def _sorted_u(points: Any, max_distance: float) -> Array:
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    if not len(points):
        return points
    points = points[np.argsort(points[:, 0], kind="stable")]
    cuts = np.flatnonzero(np.hypot(*np.diff(points, axis=0).T) > max_distance) + 1
    return np.array([group.mean(axis=0) for group in np.split(points, cuts)])


def _clusters_scipy(points: Any, max_distance: float) -> Array:
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    if len(points) < 2:
        return points
    names = fcluster(linkage(points, "single"), max_distance, "distance")
    return np.array([points[names == name].mean(axis=0) for name in np.unique(names)])


def _clusters_closure(points: Any, max_distance: float) -> Array:
    """Who reaches whom, by squaring the matrix of neighbours until nothing is new."""
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    reached = np.linalg.norm(points[:, None] - points, axis=2) <= max_distance
    for _ in range(len(points).bit_length() + 1):
        reached = (reached.astype(np.float32) @ reached.astype(np.float32)) > 0
    return (
        np.array([points[row].mean(axis=0) for row in np.unique(reached, axis=0)])
        .reshape(-1, 2)
        .astype(np.float32)
    )


def _clusters_union(points: Any, max_distance: float) -> Array:
    """Union-find, and the answer from right to left."""
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    parent = list(range(len(points)))

    def root(i: int) -> int:
        while parent[i] != i:
            i = parent[i]
        return i

    for i in range(len(points)):
        for j in range(i):
            if np.hypot(*(points[i] - points[j])) <= max_distance:
                parent[root(i)] = root(j)
    names = np.array([root(i) for i in range(len(points))], dtype=int)
    return np.array([points[names == name].mean(axis=0) for name in np.unique(names)]).reshape(-1, 2)[::-1]


def _chain(rng: np.random.Generator, length: int, step: float) -> Array:
    """Points in a row, shuffled."""
    way = rng.uniform(-1, 1, 2)
    points = rng.uniform(0, 200, 2) + np.outer(np.arange(length), way / np.hypot(*way) * step)
    return rng.permutation(points)


def _clusters_public() -> list[Case]:
    rng = np.random.default_rng(22)
    posts = np.array(
        [(40, 120), (41, 121), (42, 121), (43, 120), (200, 90), (201, 92), (203, 90)], dtype=float
    )
    return [
        Case((posts, 5.0), "two posts"),
        Case((posts[[3, 6, 0, 5, 1, 4, 2]], 1.5), "the same points in another order, a shorter distance"),
        Case(
            (np.array([(0, 50), (20, 50), (10, 50), (5, 50), (15, 50)], dtype=float), 5.0),
            "a chain: its ends are far apart",
        ),
        Case((np.array([(10, 20), (13, 24), (20, 20)], dtype=float), 5.0), "exactly max_distance apart"),
        Case((np.array([(10, 10), (10, 40), (11, 70), (12, 42)], dtype=float), 6.0), "above each other"),
        Case(
            (np.array([(0, 0), (4, 4), (30, 30), (33.5, 33.5), (60, 0), (60, 6)], dtype=float), 5.0),
            "diagonal steps",
        ),
        Case(
            (np.array([(1, 5), (2, 60), (3, 5), (4, 60), (5, 6), (9, 60)], dtype=float), 5.0),
            "one cluster above the other",
        ),
        Case((_chain(rng, 9, 3.0), 4.0), "a shuffled chain"),
        Case(
            (np.array([(0, 0), (1, 10), (5, 5)], dtype=float), 8.0), "two points that only a third one joins"
        ),
        Case((np.array([(0, 0), (10, 1), (5, 5)], dtype=float), 8.0), "the same, turned over"),
        Case((np.array([(0, 0), (1, 6), (3, -4)], dtype=float), 7.0), "a point between two others"),
        Case(
            (np.array([(50, 40), (70, 40), (60, 52), (60, 44)], dtype=float), 11.0),
            "three points that only a fourth one joins",
        ),
        Case((np.zeros((0, 2)), 5.0), "no points"),
        Case((np.array([(7.0, 9.0)]), 5.0), "one point"),
    ]


def _clusters_hidden(rng: np.random.Generator) -> list[Case]:
    posts = [rng.normal(middle, 3.0, (12, 2)) for middle in ((40, 100), (150, 90), (152, 180))]
    return [
        Case((rng.permutation(np.vstack(posts)), 14.0)),
        *(
            Case((np.vstack([_chain(rng, int(rng.integers(6, 14)), 3.0) for _ in range(3)]), 3.5))
            for _ in range(3)
        ),
        Case((rng.permutation(np.vstack([_chain(rng, 8, 5.0), 400 + _chain(rng, 5, 5.0)])), 6.0)),
        Case((np.array([(10, 20), (13, 24), (16, 28), (40, 20)], dtype=float), 5.0)),
        Case(
            (
                np.column_stack(
                    [np.arange(12.0), np.where(np.arange(12) % 2, 40, float(rng.integers(0, 9)))]
                ),
                4.0,
            )
        ),
        Case((rng.permutation(rng.uniform(10, 60, 2) + np.array([(0, 0), (1, 10), (5, 5)])), 8.0)),
        Case((rng.permutation(rng.uniform(10, 60, 2) + np.array([(0, 0), (1, 6), (3, -4)])), 7.0)),
        Case((rng.uniform(10, 60, 2) + np.array([(0.0, 0), (20, 0), (10, 12), (10, 4)]), 11.0)),
        Case((rng.uniform(0, 60, (25, 2)).round(1), 7.03)),
        Case((rng.uniform(0, 60, (25, 2)).round(1), 10.03)),
        Case((np.zeros((0, 2)), float(rng.uniform(1, 9)))),
        Case((rng.uniform(0, 60, (1, 2)), 3.0)),
    ]


CLUSTER_POINTS = Exercise(
    name="cluster_points",
    points=4,
    stars=3,
    public=_clusters_public,
    hidden=_clusters_hidden,
    comparison=Points(tolerance=0.05),
    hints=(
        "points[:, None] - points has all differences, shape (N, N, 2); np.linalg.norm(..., axis=2) their lengths. Who is near whom is then one "
        "comparison. Clusters are what hangs together by such neighbours, also over several of them.",
        "Give each point its own number as a name. Then let each take the smallest name among its neighbours, again and again, until no name "
        "changes: np.where(near, names, len(points)).min(axis=1, initial=len(points)). Equal names are one cluster; average points[names == name].",
    ),
    mistakes=[
        Mistake(
            "near the first point only",
            _to_first,
            "A chain breaks in your clusters: you compare with a cluster's first point only. It is enough to be near any point of it.",
        ),
        Mistake(
            "clusters never join",
            _to_any,
            "It depends on the order of the points: one that is near two clusters joins them to one.",
        ),
        Mistake(
            "sorted by column, clusters never join",
            _first_by(0),
            "Sorting by column is not enough: a point that is near two of your clusters joins them to one. In yours it goes to the first.",
        ),
        Mistake(
            "sorted by row, clusters never join",
            _first_by(1),
            "You sort by row, which helps no more than sorting by column: a point that is near two of your clusters joins them to one.",
        ),
        Mistake(
            "near the last point only",
            _to_last,
            "You sort by column and compare with a cluster's last point only. It is enough to be near any point of it, and who is near two clusters joins them.",
        ),
        Mistake(
            "at most two joined",
            lambda points, max_distance: _joined(points, max_distance, most=2),
            "You join at most two clusters. A point can be near three of them, or more: then all become one.",
        ),
        Mistake(
            "near to all points",
            lambda points, max_distance: _joined(points, max_distance, wanted=all),
            "You ask that a point is near to all points of a cluster. It is enough to be near to one.",
        ),
        Mistake(
            "near the first point only, no shape",
            _to_first_no_shape,
            "A chain breaks in your clusters: it is enough to be near any point of a cluster, not only its first. And no points give shape (0, 2).",
        ),
        Mistake(
            "near the mean",
            _to_mean,
            "You compare a point with a cluster's mean. Single linkage asks whether it is near to any point of the cluster.",
        ),
        Mistake(
            "one round",
            _one_round,
            "Your numbers travel one step only: repeat it until none changes, and a chain of any length gets one number.",
        ),
        Mistake(
            "nothing found",
            _nothing,
            "You return no points at all: there is one for each cluster, and a point without neighbours is a cluster, too.",
        ),
        Mistake(
            "whole numbers",
            _with(middle=lambda group: group.mean(axis=0).astype(int)),
            "Your averages have lost what stands behind the point: int cuts it off. An average is a float.",
        ),
        Mistake(
            "only neighbours averaged",
            _neighbours,
            "You average each point with its own neighbours. A neighbour's neighbours belong to the cluster, too, and so on.",
        ),
        Mistake(
            "sorted and cut",
            _sorted_u,
            "You sort by u and cut where the next point is far. Points above each other then come in turns: compare every point with every other.",
        ),
        Mistake(
            "columns only",
            _near(lambda u, v: u),
            "You compare columns only: points above each other are far apart, too.",
        ),
        Mistake(
            "rows only",
            _near(lambda u, v: v),
            "You compare rows only. The distance has both: np.hypot of the two differences.",
        ),
        Mistake(
            "sum of differences",
            _near(lambda u, v: u + v),
            "Your distance is the sum of both differences. It is the root of the sum of their squares.",
        ),
        Mistake(
            "larger difference",
            _near(max),
            "Your distance is the larger of both differences. It is the root of the sum of their squares.",
        ),
        Mistake(
            "root forgotten",
            _near(lambda u, v: u**2 + v**2),
            "You compare the squared distance with max_distance: the root is missing.",
        ),
        Mistake(
            "less than",
            lambda points, max_distance: _clusters(points, max_distance - 1e-9),
            "Points exactly max_distance apart belong together: not farther means <=.",
        ),
        Mistake(
            "one point kept",
            _deleted,
            "You keep one point of each cluster. Its average is wanted.",
        ),
        Mistake(
            "wrong axis",
            _wrong_axis,
            "You average u with v: mean(axis=1) goes along a row. The mean over the points is mean(axis=0).",
        ),
        Mistake(
            "mean of all numbers",
            _number_mean,
            "mean() without an axis averages all columns and rows to one number. The mean over the points is mean(axis=0).",
        ),
        Mistake(
            "the median",
            _with(middle=lambda group: np.median(group, axis=0)),
            "That is the median of each cluster. The paper averages.",
        ),
        Mistake(
            "middle of the ends",
            _with(middle=lambda group: (group.min(axis=0) + group.max(axis=0)) / 2),
            "That is the middle between the smallest and the largest values. The average counts every point.",
        ),
        Mistake(
            "no shape",
            _no_shape_clusters,
            "Right, except for no points: the result is np.array([]) with shape (0,). Make it (0, 2) with .reshape(-1, 2).",
        ),
        Mistake(
            "mean of nothing",
            _empty_mean,
            "Right, except for no points: the mean of nothing is NaN. Return an array of shape (0, 2).",
        ),
    ],
    alternatives={
        "scipy": _clusters_scipy,
        "powers of a matrix, float32": _clusters_closure,
        "union-find": _clusters_union,
    },
    equivalents={
        "return np.array(means).reshape(~1, 2)": "NumPy finds out any length that is negative",
        "return np.array(means).reshape(-2, 2)": "NumPy finds out any length that is negative",
        "near = np.linalg.norm(points[:, None] - points, axis=1 - 2) <= max_distance": "-1 is the last axis, which is 2",
        "while not np.array_equal(before, names):": "equal is equal in both directions",
        "near = np.linalg.norm(points - points[:, None], axis=2) <= max_distance": "a difference is as long as its opposite",
    },
)


# --- 2.3 find_goalposts ---


def _scaled(
    labels: Any,
    scale: float | None = None,
    rule: tuple[float, float] = (8, 10),
    least: float = 0.1,
    gap: float = 20,
    **changed: Any,
) -> Array:
    """The detector with its values at 240 rows changed, or something of its search."""
    return _clusters(_not_clustered(labels, scale, rule, least, **changed), gap * _scale(labels, scale))


def _not_clustered(
    labels: Any,
    scale: float | None = None,
    rule: tuple[float, float] = (8, 10),
    least: float = 0.1,
    **changed: Any,
) -> Array:
    green, down = (max(round(each * _scale(labels, scale)), 1) for each in rule)
    return _candidates(labels, green, down, least, **changed)


def _scale(labels: Any, scale: float | None = None) -> float:
    return float(np.shape(labels)[0] / 240 if scale is None else scale)


def _with_values(**changed: Any) -> Any:
    return lambda labels: _scaled(labels, **changed)


def _fixed(labels: Any) -> Array:
    return _scaled(labels, scale=1.0)


def _by_width(labels: Any) -> Array:
    return _scaled(labels, scale=np.shape(labels)[1] / 320)


def _whole_scale(labels: Any) -> Array:
    scale = np.shape(labels)[0] // 240
    return _clusters(_candidates(labels, 8 * scale, 10 * scale, 0.1), 20 * scale)


def _one_foot(labels: Any) -> Array:
    found = _not_clustered(labels)
    return found.mean(axis=0, keepdims=True) if len(found) else found


def _no_shape_feet(labels: Any) -> Array:
    found = _scaled(labels)
    return found if len(found) else np.array([])


def _feet_by_blobs(labels: Any) -> Array:
    """Blobs of yellow, the middle of their lowest row, green below it."""
    labels = np.asarray(labels).astype(np.uint8)
    height = labels.shape[0]
    number, names, _, _ = cv2.connectedComponentsWithStats(
        (labels == YELLOW).astype(np.uint8), connectivity=4
    )
    feet = []
    for name in range(1, number):
        for left, right in _legs(names == name):
            columns = [np.flatnonzero(names[:, u] == name) for u in range(left, right)]
            v = max(column[-1] for column in columns)
            below = labels[v + 1 : v + 1 + max(height // 24, 1), left:right]
            if max(map(len, columns)) >= 0.1 * height and below.size and (below == GREEN).mean() > 0.6:
                feet.append(((left + right - 1) / 2, float(v)))
    return np.array(feet).reshape(-1, 2)


def _legs(blob: Array) -> list[tuple[int, int]]:
    """Columns (first, last + 1) of a blob that reach nearly as far down as its lowest one near by."""
    lowest = np.where(blob.any(axis=0), blob.shape[0] - 1 - blob[::-1].argmax(axis=0), -1)
    tall = (blob.sum(axis=0) >= 0.1 * blob.shape[0]) & (lowest >= 0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], tall.astype(int), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _feet_by_sums(labels: Any) -> Array:
    """Other values, other tools."""
    labels = np.asarray(labels)
    height = labels.shape[0]
    found = _candidates_by_sums(labels, round(height / 30), round(height / 20), 0.1)
    return _clusters_scipy(found, height / 12)


def _feet_lowest(labels: Any) -> Array:
    """Of each cluster the middle column and the lowest row."""
    labels = np.asarray(labels)
    scale = labels.shape[0] / 240
    found = _candidates_by_rows(labels, max(round(6 * scale), 1), max(round(8 * scale), 1), 0.12).astype(
        float
    )
    return _clusters(
        found, 16 * scale, middle=lambda group: np.array([np.median(group[:, 0]), group[:, 1].max()])
    )


def _goal(rng: np.random.Generator, rows: int, *, left: float, right: float, depth: float = 0.5) -> Array:
    """A goal before a wall, with its bar; posts at parts of the width, their feet at a part of the height."""
    columns = rows * 4 // 3
    labels = field(rows, columns, round(0.34 * rows))
    width = max(rows // 16, 3)
    at = [round(part * columns) for part in (left, right)]
    foot = round(depth * rows)
    line = foot + rows // 10 + 1
    labels[line : line + rows // 60] = WHITE  # before them: what they stand on is green
    labels[: rows // 24 + 1, at[0] : at[1] + width] = YELLOW
    for post in at:
        stand(labels, post, width, 0, foot)
    labels[round(0.06 * rows) : round(0.19 * rows), round(0.4 * columns) : round(0.5 * columns)] = (
        YELLOW  # a bag
    )
    low = round(0.8 * rows)
    labels[low : low + max(rows // 30, 1), round(0.55 * columns) : round(0.62 * columns)] = YELLOW  # a peel
    noise = rng.random(labels.shape) < 0.003
    labels[noise & (labels == OTHER)] = YELLOW
    return labels


def _goal_cases(rng: np.random.Generator, sizes: tuple[int, ...]) -> list[Array]:
    return [
        _goal(
            rng,
            rows,
            left=rng.uniform(0.08, 0.25),
            right=rng.uniform(0.65, 0.85),
            depth=rng.uniform(0.45, 0.65),
        )
        for rows in sizes
    ]


def _near_edge(rows: int, below: float) -> Array:
    """One post before carpet, with only a part of the height below its foot."""
    labels = field(rows, rows * 4 // 3, rows // 4)
    return stand(labels, rows // 2, max(rows // 12, 3), 0, rows - 1 - round(below * rows))


def _narrow(rows: int, left: int) -> Array:
    """A goal seen from the side: its posts are a fifth of the height apart."""
    labels, width = field(rows, rows * 4 // 3, rows // 4), max(rows // 24, 2)
    for shift in (0, -(-rows // 5) + width):
        stand(labels, left + shift, width, 0, rows // 2)
    return labels


def _strip(rows: int, below: str, foot: float = 0.5, high: float = 0.4, columns: int = 12) -> Array:
    """A strip of a picture with something yellow in it, `high` parts of the height; and what is below, by letters.

    Each letter stands for a 240th of the height, and the rest of the ground is green: o other, g green, w white.
    """
    labels, v = field(rows, columns, rows // 5), round(foot * rows)
    stand(labels, columns // 4, columns // 2, max(v + 1 - round(high * rows), 0), v)
    for i, letter in enumerate(below):
        from_row, to_row = (v + 1 + round(each * rows / 240) for each in (i, i + 1))
        labels[from_row:to_row] = "ogyw".index(letter)
    return labels


def _with_gap(labels: Array) -> Array:
    """The middle third of a post's columns has noise right below it, so that no foot is found there."""
    rows, columns = np.nonzero(labels == YELLOW)
    below, third = rows.max() + 1, (np.ptp(columns) + 1) // 3
    labels[below : below + max(len(labels) // 40, 1), columns.min() + third : columns.max() + 1 - third] = (
        OTHER
    )
    return labels


def _strips(rows: int, columns: int, foot: float) -> list[Array]:
    """Feet with a line below, close or a little lower, low and broken posts; and two things behind the field."""
    return [
        _strip(rows, "ggww", foot, columns=columns),
        _strip(rows, "gggggggggggww", foot, columns=columns),
        _strip(rows, "", foot, high=0.13, columns=columns),
        _with_gap(_strip(rows, "", foot, columns=columns)),
        _strip(rows, "ogggggwwwwwww", foot, columns=columns),
        _strip(rows, "o" * 14, foot, columns=columns),
    ]


STRIPS = (
    "a strip of 240 rows, a thin line right below the foot",
    "a strip of 240 rows, a thin line a little below the foot",
    "a strip of 240 rows, a post far away",
    "a strip of 240 rows, noise below the middle of a post",
    "a strip of 240 rows, a bag above a thin strip of green",
    "a strip of 240 rows, a bag above the wall",
)


def _posts_public() -> list[Case]:
    rng = np.random.default_rng(23)
    cut = _near_edge(48, 0.0)
    one = stand(field(48, 64, 12), 30, 4, 2, 33)
    nothing = field(48, 64, 14)
    nothing[4:14, 20:26] = YELLOW
    return [
        Case((_goal(rng, 48, left=0.12, right=0.78),), "a goal, a bag behind the field and a banana peel"),
        Case((_near_edge(48, 0.09),), "a post near the lower edge"),
        Case((cut,), "a post whose foot is below the picture"),
        Case((_narrow(48, 21),), "a goal seen from the side"),
        Case((one,), "one post"),
        Case((nothing,), "a bag and no post"),
        Case((np.repeat(np.repeat(_goal(rng, 24, left=0.2, right=0.7), 2, 0), 2, 1),), "another goal"),
        Case((_goal(rng, 36, left=0.15, right=0.7, depth=0.6),), "a smaller picture"),
        *(Case((labels,), name) for labels, name in zip(_strips(240, 12, 0.5), STRIPS, strict=True)),
    ]


def _posts_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        *(Case((labels,)) for labels in _goal_cases(rng, (36, 48, 60, 120, 240, 480))),
        Case((_near_edge(48, 0.085),)),
        Case((_near_edge(240, 0.06),)),
        Case((_near_edge(480, 0.0),)),
        *(Case((_narrow(rows, int(rng.integers(5, rows))),)) for rows in (48, 72, 240)),
        Case((field(120, int(rng.integers(100, 160)), 40),)),
        *(
            Case((labels,))
            for rows in (240, 480)
            for labels in _strips(rows, rows // 16, rng.uniform(0.4, 0.7))
        ),
    ]


FIND_GOALPOSTS = Exercise(
    name="find_goalposts",
    points=5,
    stars=3,
    uses=("post_candidates", "cluster_points"),
    public=_posts_public,
    hidden=_posts_hidden,
    comparison=Points(tolerance=2.5),
    hints=(
        "Candidates, then clusters: your two functions, with values of your own. Begin with values for pictures of 240 rows, and find them in the "
        "panel below or by measuring.",
        "A picture of 480 rows has twice the pixels below a foot, and one of 48 a fifth: multiply what is in pixels by labels.shape[0] / 240 and "
        "round it. min_height is a part already.",
    ),
    mistakes=[
        Mistake(
            "values for 240 rows",
            _fixed,
            "Right for 240 rows. In smaller pictures your values in pixels ask for more green than there is: let them grow with labels.shape[0].",
        ),
        Mistake(
            "all green, and deep",
            _with_values(rule=(12, 12), gap=48),
            "You ask for nothing but green below a foot, and farther down than a twenty-fourth of the height. A line may lie there.",
        ),
        Mistake(
            "all green",
            _with_values(rule=(10, 10)),
            "You ask for nothing but green below a foot. A thin line may lie there, or a pixel of noise: a fifth of the pixels may be something else.",
        ),
        Mistake(
            "one green pixel far down",
            _with_values(rule=(1, 24)),
            "You look far down, and a little green is enough for you. Below nearly everything there is carpet in the end: ask for more of it, nearer.",
        ),
        Mistake(
            "half green",
            _with_values(rule=(5, 10)),
            "You find a bag above a thin strip of green. Where only half of the pixels below are green, nothing stands on the carpet: ask for more.",
        ),
        Mistake(
            "a fifth of the height",
            _with_values(least=0.2),
            "You lose posts far away: one that is a tenth of the picture's height has to be found.",
        ),
        Mistake(
            "short linkage",
            _with_values(gap=2),
            "You report one post twice where noise takes out the columns in its middle: let candidates that are farther apart be one post.",
        ),
        Mistake(
            "linkage below a pixel",
            _with_values(gap=5),
            "In small pictures your linkage is less than one pixel, and each column is a post of its own. A larger one does no harm: posts are far apart.",
        ),
        Mistake(
            "long linkage",
            _with_values(gap=60),
            "You make one post of two: they are a fifth of the picture's height apart, and in small pictures that is not many pixels.",
        ),
        Mistake(
            "a low height",
            _with_values(least=1 / 40),
            "What lies on the carpet passes as a post. Your least height is too low: a post is a tenth of the picture's height high.",
        ),
        Mistake(
            "arguments swapped",
            _with_values(rule=(10, 8)),
            "You ask for more green pixels than you look at. The order of the arguments is min_green, look_down.",
        ),
        Mistake(
            "part of the width",
            _by_width,
            "You scale with the width. Some of the pictures are narrow strips: what grows is the height, labels.shape[0].",
        ),
        Mistake(
            "scale in whole numbers",
            _whole_scale,
            "In small pictures your values are 0: // rounds down, and 48 // 240 is 0. Divide with /, and round what has to be whole at the end.",
        ),
        Mistake(
            "nothing found",
            _nothing,
            "You find nothing, whatever the picture. Print what your candidates are before they are clustered.",
        ),
        Mistake(
            "not clustered",
            _not_clustered,
            "Each post has several of your points, one a column. Cluster them.",
        ),
        Mistake(
            "one foot for all",
            _one_foot,
            "You average all candidates to one point: between two posts there is none.",
        ),
        Mistake(
            "no look-down rule",
            lambda labels: _scaled(labels, no_rule=True),
            "You find yellow things that do not stand on the carpet. Ask for green below the foot.",
        ),
        Mistake(
            "any height",
            lambda labels: _scaled(labels, no_height=True),
            "You find what lies on the carpet and is too low for a post: ask for a least height.",
        ),
        Mistake(
            "(row, column)",
            lambda labels: _scaled(labels)[:, ::-1],
            "Your points are (row, column). A point is (u, v): the column first, then the row.",
        ),
        Mistake(
            "the post's top",
            lambda labels: _scaled(labels, top_saved=True),
            "You found the posts, and give their tops. The point is where a post stands.",
        ),
        Mistake(
            "no shape",
            _no_shape_feet,
            "Right, except where there is no post: the result has shape (0,). It must be (0, 2).",
        ),
    ],
    alternatives={
        "yellow blobs": _feet_by_blobs,
        "other values, cumulative sums and scipy": _feet_by_sums,
        "the lowest row of each cluster": _feet_lowest,
    },
    equivalents=dict.fromkeys(
        (
            "scale = len(labels) / 241",
            "scale = len(labels) / 239",
            "min_green, look_down = np.ceil([7 * scale, 10 * scale]).astype(int)",
            "min_green, look_down = np.ceil([8 * scale, 11 * scale]).astype(int)",
            "min_green, look_down = np.floor([8 * scale, 10 * scale]).astype(int)",
            "return cluster_points(candidates, 21 * scale)",
            "return cluster_points(candidates, 19 * scale)",
        ),
        "a value of one's own: what the text demands leaves room for it",
    ),
)


PLAN = LessonPlan(
    exercises=[POST_CANDIDATES, CLUSTER_POINTS, FIND_GOALPOSTS],
    questions=[
        Question(
            "why_given_up",
            "A yellow bag lies behind the field, right below the bar as the picture shows it. Why is a column given up when its lowest yellow "
            "pixel has no green below, and not searched on to the bar?",
            {
                "To save time: most columns have no post.": "It does save time, but hardly any: the columns with yellow are few. The reason is "
                "what a column would find if it went on.",
                "Because what is above it cannot be a foot.": "A foot stands on the carpet, and the carpet is below everything else. If the lowest "
                "yellow of a column hangs over something else, all yellow above it does so even more. The rule has a price: a yellow speck in the "
                "line before a post gives up a true foot.",
                "Because a post is always the lowest yellow thing in a picture.": "A peel on the carpet is lower, and so is a bag before the "
                "goal. It is the lowest in its own column that counts.",
            },
            "Because what is above it cannot be a foot.",
        ),
        Question(
            "why_part_of_height",
            "The paper's least height is a part of the picture's height. What does your search do on pictures of twice the size, 640 x 480, if "
            "min_green and look_down stay 8 and 10 pixels?",
            {
                "The same: the rule counts pixels, and pixels are pixels.": "A pixel now shows half as much of the field. Ten of them are what "
                "five were before.",
                "It looks only half as far down: thin bits of green are enough.": "Ten pixels now are as much carpet as five were, so the rule becomes "
                "weaker: the gap between a bag and a line may pass. Values in pixels have to grow with the picture.",
                "It finds no posts any more: they are too wide.": "Width is not asked for. Wider posts only have more candidates.",
            },
            "It looks only half as far down: thin bits of green are enough.",
        ),
    ],
    written=[
        Written(
            "explain_slanted_side",
            points=2,
            question="Why does a post near by have candidates high up on its side when min_green is 0, and why does green below stop most of them?",
            rubric="1 point: the camera looks down, so in the picture posts lean outwards or widen upwards; in a column that meets only the leaning "
            "side, the lowest yellow pixel lies on the side and not on the ground. 1 point: below such a pixel there is the post's blurred rim and "
            "then what is behind it, so several of the pixels below are not green; where carpet is behind the rim, some pass all the same.",
        )
    ],
)
