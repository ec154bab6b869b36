"""Exercises of lesson 02, goal posts, with common mistakes and alternative correct solutions."""

from __future__ import annotations

import re
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from scipy.cluster.hierarchy import fcluster, linkage

from nao_course.exercises import Case, Exercise, LessonPlan, Points, Question, Sibling, Written
from nao_course.instructor.authoring.mistakes import catalogue

Array = npt.NDArray[Any]
OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3


# --- labels for the cases ---
def field(rows: int, columns: int, horizon: int) -> Array:
    """Return labels of carpet below a wall."""
    labels = np.zeros((rows, columns), dtype=np.uint8)
    labels[horizon:] = GREEN
    return labels


def stand(labels: Array, left: int, width: int, top: int, foot: int) -> Array:
    """Add a post in columns left to left + width - 1 and rows top to foot."""
    labels[top : foot + 1, left : left + width] = YELLOW
    return labels


def scattered(seed: int | np.random.Generator, rows: int, columns: int) -> Array:
    """Return random labels: runs of all four in each column, mostly yellow and green."""
    rng, labels = np.random.default_rng(seed), np.zeros((rows, columns), dtype=np.uint8)
    for u in range(columns):
        v = 0
        while v < rows:
            length = int(rng.integers(1, max(3, rows // 4)))
            labels[v : v + length, u] = rng.choice([OTHER, GREEN, GREEN, YELLOW, YELLOW, WHITE])
            v += length
    return labels


# --- 2.1 post_candidates ---
def _candidates_loop(labels: Array, min_green: int, look_down: int, min_height: float) -> Array:
    found = []
    for u, column in enumerate(labels.T):
        for v in np.flatnonzero(column == YELLOW)[-1:]:
            green = (column[v + 1 : v + 1 + look_down] == GREEN).sum()
            run = np.cumprod(column[v::-1] == YELLOW).sum()
            if green >= min_green and run >= min_height * len(column):
                found.append((u, v))
    return np.array(found, dtype=int).reshape(-1, 2)


def _candidates_regex(labels: Array, min_green: int, look_down: int, min_height: float) -> Array:
    """Search each column as bytes, and return the points from right to left."""
    found: list[tuple[int, int]] = []
    for u, column in enumerate(map(bytes, labels.T)):
        if lowest := re.search(rb"\x02+(?=[^\x02]*\Z)", column):
            green = column.count(GREEN, lowest.end(), lowest.end() + look_down)
            if green >= min_green and len(lowest[0]) >= min_height * len(column):
                found.insert(0, (u, lowest.end() - 1))
    return np.array(found, dtype=np.float32).reshape(-1, 2)


def _candidates_by_sums(labels: Array, min_green: int, look_down: int, min_height: float) -> Array:
    """Use cumulative sums of green pixels and the last row that is not yellow."""
    height, rows = len(labels), np.arange(len(labels))[:, None]
    foot = np.where(labels == YELLOW, rows, -1).max(axis=0)
    green = np.cumsum(np.pad(labels == GREEN, ((1, look_down), (0, 0))), axis=0)
    below = np.take_along_axis(green, foot[None] + [[1], [1 + look_down]], axis=0)
    gap = np.where((labels != YELLOW) & (rows < foot), rows, -1).max(axis=0)
    good = (foot >= 0) & (np.diff(below, axis=0)[0] >= min_green) & (foot - gap >= min_height * height)
    return np.stack([np.flatnonzero(good), foot[good]], axis=1)


def _columns(columns: str) -> Array:
    """Return labels that are written as columns from the top: o other, g green, y yellow, w white."""
    return np.array([["ogyw".index(letter) for letter in each] for each in columns.split()], dtype=np.uint8).T


def _candidates_public() -> list[Case]:
    goal = stand(stand(field(32, 44, 12), 6, 4, 0, 21), 33, 3, 0, 17)
    goal[0:2, 6:36] = YELLOW  # the bar
    goal[22:24] = WHITE  # the line they stand on
    goal[4:11, 16:22] = YELLOW  # a bag behind the field
    goal[25:27, 24:27] = YELLOW  # too low for a post
    four = _columns("ooyyyygg ooyyyygw ooyyyyww ooyyyogg")
    lower = _columns("oyyyyggoyggg yyyygggwyooo yyyyggggoyow")
    turns = _columns("gyyyygwgww gyyyywgwgg ggyyygwggg gggyygwggg ggggyyyggg")
    return [
        Case((goal, 3, 8, 0.25), "a goal, a bag behind the field and something low"),
        Case((four, 2, 2, 0.5), "four columns of 8 pixels"),
        Case((lower, 3, 4, 0.25), "yellow with green below, and lower yellow without it"),
        Case((_columns("yyyyoyygggww yyyyyyygggww yyoyyyygggww"), 2, 4, 0.5), "posts with holes"),
        Case((_columns("ooyyyygg oooyyyyg ooooyyyy"), 1, 4, 0.25), "at the lower edge"),
        Case((_columns("ooyyyygg oooyyyyg"), 2, 4, 0.25), "at the lower edge, two of four green"),
        Case((_columns("yyyyyyyy oyyyyyyy"), 0, 3, 0.5), "yellow down to the lower edge, no green required"),
        Case((_columns("oyyogyog gooyyygg"), 0, 2, 0.0), "neither green nor height required"),
        Case(
            (_columns("gggyyyyy gggyyyyw"), 1, 3, 0.25), "the edge of the picture below, and green at the top"
        ),
        Case((turns, 2, 3, 0.25), "green and white alternating, runs of 4, 3 and 2 of 10"),
        Case((field(12, 10, 4), 2, 3, 0.25), "no yellow at all"),
        Case((_columns("yyyyggwg oyyygggg"), 2, 3, 0.5), "a run of half the height that begins in row 0"),
        Case((scattered(21, 24, 40), 2, 5, 0.125), "random labels"),
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
            Case((scattered(rng, n, 60), *map(int, rng.integers((1, 5), (5, 9))), 0.125))
            for n in (24, 28, 40, 44)
        ),
        Case((scattered(rng, 40, 30), 0, 5, 0.125)),
        Case((scattered(rng, 20, 64), 2, 2, 0.25)),
        Case((scattered(rng, 64, 20), 3, 30, 0.0625)),
        Case((stand(field(20, 30, 6), int(rng.integers(4, 20)), 3, 4, 11), 0, 4, 0.0)),
        Case((_columns("ooyyyygg oooyyyyg ooooyyyy ogyyyygw yyyygggw"), int(rng.integers(1, 3)), 4, 0.5)),
        *(Case((np.full((12, int(rng.integers(5, 9))), YELLOW, dtype=np.uint8), n, 4, 0.25)) for n in (1, 0)),
        Case((_columns("ooyyyygg oooyyyyg ogyyyygw"), 2, int(rng.integers(4, 7)), 0.25)),
        Case((_columns("yyyggwgg oyyggggg yyygwggg"), 2, int(rng.integers(3, 5)), 0.375)),
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
        "Write it for one column first. np.flatnonzero(labels[:, u] == 2) returns its yellow rows, and the last one is the foot, because rows count downwards. Then write the two tests with slices of that column, and a loop over the columns around them.",
        "The pixels below the foot are labels[foot + 1 : foot + 1 + look_down, u]; the slice ends at the edge of the picture. For the height, count yellow pixels from the foot upwards until the first other one. There must be at least min_height * labels.shape[0] of them, including the foot.",
    ),
    sibling=Sibling(
        "A week's last rainy day takes the place of a column's lowest yellow pixel: the days after it are counted with a slice, which may end early, and the run of rainy days is counted backwards from it.",
        """
        for week in ("srrrssr", "rsrrrss", "sssssss", "rrrsrrs"):  # s sunny, r rain
            last = week.rfind("r")
            if last < 0:
                continue  # no rain in this week, but the next week is tested
            sunny = week[last + 1 : last + 3].count("s")
            run = 0
            while run <= last and week[last - run] == "r":  # without run <= last it would go on at the end
                run += 1
            print(f"{week}: last rain on day {last}, {sunny} sunny days after it, {run} rainy days in a row")
        """,
        """
        srrrssr: last rain on day 6, 0 sunny days after it, 1 rainy days in a row
        rsrrrss: last rain on day 4, 2 sunny days after it, 3 rainy days in a row
        rrrsrrs: last rain on day 5, 1 sunny days after it, 2 rainy days in a row
        """,
    ),
    mistakes=catalogue("""
        nothing found: + return np.zeros((0, 2))
            You return no candidates for any picture, so one of the two tests never passes. Print the number of green pixels and the length of the run for one column.
        height of 240 rows: np.ceil(min_height * height) => min(min_height * 240, height)
            yellow.all(axis=1) => yellow.all(axis=1) & (foot + 1 >= min_height * 240)
            You require min_height * 240 pixels, but these pictures have fewer rows. Use labels.shape[0].
        fraction at the edge: green.sum(axis=1) >= min_green => green.sum(axis=1) / (below < height).sum(axis=1) >= min_green / look_down
            At the lower edge you compare the fraction of green among the few existing pixels. Compare the number of green pixels with min_green; missing pixels are not green.
        climbs over the edge: & yellow.all(axis=1) => & yellow.all(axis=1)
            + for u, v in zip(columns[good], foot[good]):
            +     while labels[v, u] == 2:
            +         v -= 1
            If a column is yellow up to its top, you go on counting beyond the picture, because labels[-1, u] is the last row. Stop at row 0.
        height rounded down: np.ceil(min_height * height) => int(min_height * height)
            You round the smallest height down, for example with int() or round(). A quarter of 10 rows is 2.5, so a run of 2 pixels is too short. Compare with the number without rounding.
        row 0 not counted: labels[run, columns[:, None]] == 2 => (labels[run, columns[:, None]] == 2) & (run > 0)
            Your count ends before row 0, so a run that begins there is one pixel too short. range(v, 0, -1) ends at 1; range(v, -1, -1) includes row 0.
        always ten pixels: np.arange(1, look_down + 1) => np.arange(1, 11)
            You always test ten pixels below the foot. Test look_down pixels.
        not yellow is enough: columns[:, None]] == 1) & (below < height) => columns[:, None]] != 2) & (below < height)
            You count all pixels that are not yellow. Count only the green ones, label 1.
        missing pixels are green: & (below < height) => | (below >= height)
            At the lower edge you count missing pixels as green, for example because you limit the number of pixels that are not green. Compare the number of green pixels with min_green.
        fraction of the row: & yellow.all(axis=1) => & np.array([np.cumprod(labels[v::-1, u] == 2).sum() >= min_height * v for u, v in zip(columns, foot)], dtype=bool)
            You multiply min_height by the row of the foot. It is a fraction of the picture's height, labels.shape[0].
        one row too low: columns[good], foot[good] => columns[good], foot[good] + 1
            Your points are one row below the foot. The foot is the lowest yellow pixel itself.
        more than both: >= min_green => > min_green
            np.ceil(min_height * height) => int(min_height * height) + 1
            A column with exactly min_green green pixels, or exactly the smallest height, passes. Use >= in both tests.
        top-down: height - 1 - (labels[::-1, columns] => (labels[:, columns]
            & yellow.all(axis=1) => & ((run >= 0) & yellow).all(axis=1)
            You scan from the top, so your points are the upper ends of the yellow. Scan from the bottom: the first yellow pixel is the foot.
        goes on after the failure: & yellow.all(axis=1) => & yellow.all(axis=1)
            + labels = labels.copy()
            + labels[foot, columns] = labels[:, columns[good]] = 0
            + points = np.column_stack([columns[good], foot[good]]).astype(float)
            + return np.vstack([points, post_candidates(labels, min_green, look_down, min_height)]) if len(foot) else points
            In some columns you continue to search after the first yellow pixel has failed. Reject such a column, because what is above its lowest yellow pixel is hardly ever a foot.
        stops at a column without yellow: (labels == 2).any(axis=0) => np.cumprod((labels == 2).any(axis=0))
            You stop at the first column without yellow. If your loop has a break or a return there, use continue.
        stops at the first failed test for green: (green.sum(axis=1) >= min_green) & => np.cumprod(green.sum(axis=1) >= min_green).astype(bool) &
            You stop at the first column without enough green below its foot. If your loop has a break or a return there, use continue.
        the lowest yellow with green below: + found = []
            + for u in range(labels.shape[1]):
            +     rows = [v for v in np.flatnonzero(labels[:, u] == 2) if (labels[v + 1 :, u][:look_down] == 1).sum() >= min_green]
            +     if rows and np.cumprod(labels[rows[-1] :: -1, u] == 2).sum() >= min_height * len(labels):
            +         found.append((u, rows[-1]))
            + return np.array(found).reshape(-1, 2)
            In some columns you search further up for a yellow pixel with green below it. Test only the lowest yellow pixel, and reject the column if it fails.
        goes on after a candidate: + found = []
            + for u in range(labels.shape[1]):
            +     for v in np.flatnonzero(labels[:, u] == 2)[::-1]:
            +         run = np.cumprod(labels[v::-1, u] == 2).sum()
            +         if (labels[v + 1 :, u][:look_down] == 1).sum() < min_green or run < min_height * len(labels):
            +             break
            +         found.append((u, v))
            + return np.array(found).reshape(-1, 2)
            After a candidate you go on to the yellow pixel above it. Test only the lowest yellow pixel of each column. In a loop over the rows, a break belongs after both tests, whether they pass or fail.
        stops at the lowest pixel: & yellow.all(axis=1) => & yellow.all(axis=1) & (foot == height - 1)
            Your scan of a column ends at its lowest pixel if this is not yellow. Go on upwards until you find yellow: an else with a break may be in the wrong place.
        stops at a short run: & yellow.all(axis=1) => & yellow.all(axis=1)
            + short = (green.sum(axis=1) >= min_green) & ~yellow.all(axis=1)
            + good = good & (np.cumsum(short) == 0)
            You stop at the first column whose run is too short. If your loop has a break or a return there, use continue.
        stops at a foot near the edge: & yellow.all(axis=1) => & yellow.all(axis=1)
            + good = good & (np.cumsum(foot + look_down >= height) == 0)
            You stop at the first foot with fewer than look_down pixels below it. Count the green pixels that exist, and go on with the next column.
        return in the loop: + labels = labels[:, :1]
            You test the first column only. If your loop over the columns contains the return, move it behind the loop.
        first column with yellow: & yellow.all(axis=1) => & yellow.all(axis=1) & (np.arange(len(foot)) == 0)
            You test only the first column that contains yellow. If your loop contains a return, move it behind the loop.
        the highest yellow pixel, downwards: + found = []
            + for u in range(labels.shape[1]):
            +     for v in np.flatnonzero(labels[:, u] == 2)[:1]:
            +         run = np.cumprod(labels[v:, u] == 2).sum()
            +         if (labels[v + 1 :, u][:look_down] == 1).sum() >= min_green and run >= min_height * len(labels):
            +             found.append((u, v))
            + return np.array(found).reshape(-1, 2)
            You test the highest yellow pixel of a column and count downwards. Rows count downwards, so the foot is the largest row that np.flatnonzero returns, and the run goes up from it.
        stops at a rejected column: & yellow.all(axis=1) => & yellow.all(axis=1)
            + good = np.cumprod(good).astype(bool)
            You stop at the first column that fails a test. If your loop has a break or a return there, use continue.
        columns at the lower edge left out: & yellow.all(axis=1) => & yellow.all(axis=1) & (foot + look_down < height)
            You reject a foot with fewer than look_down pixels below it. The pixels that exist may include min_green green ones, so count those; a slice ends at the edge by itself.
        run with gaps: yellow.all(axis=1) => ((labels == 2).sum(axis=0)[columns] >= min_height * height)
            You count all yellow pixels of a column. Count only from the foot up to the first pixel that is not yellow.
        height in pixels: & yellow.all(axis=1) =>
            Your runs may be as short as one pixel. min_height is a fraction of the picture's height, so a run needs at least min_height * labels.shape[0] pixels.
        part of the width: min_height * height => min_height * labels.shape[1]
            You multiply min_height by the width. It is a fraction of the picture's height, labels.shape[0].
        (row, column): columns[good], foot[good] => foot[good], columns[good]
            Your points are (row, column). A point in this course is (u, v): column first, then row.
        green without a gap: green.sum(axis=1) => np.cumprod(green, axis=1).sum(axis=1)
            You count green only up to the first other pixel. Count all green pixels among the look_down pixels, because a white line may be between them.
        any green: >= min_green => >= 1
            You accept a single green pixel. At least min_green are required.
        a number as a fraction: >= min_green => >= min_green * look_down
            You use min_green as a fraction of look_down. It is a number of pixels: compare it with the number of green pixels, without dividing or multiplying.
        a number as a fraction, the mean: green.sum(axis=1) >= min_green => green.sum(axis=1) / (below < height).sum(axis=1) >= min_green
            You compare the mean of a column's green pixels, which is a fraction, with min_green. It is a number of pixels: use their sum.
        more than min_green: >= min_green => > min_green
            A column with exactly min_green green pixels passes. Use >=.
        more than min_height: np.ceil(min_height * height) => int(min_height * height) + 1
            A run of exactly the smallest height passes. Use >=.
        the foot not counted: np.ceil(min_height * height) => np.ceil(min_height * height) + 1
            You do not count the foot as part of the run, so your runs are one pixel too short.
        the foot among those below: np.arange(1, look_down + 1) => np.arange(look_down)
            Only look_down - 1 of the pixels that you test are below the foot. Test foot + 1 : foot + 1 + look_down; the foot is not one of them, and a slice ends before its second number.
        one pixel too many: look_down + 1 => look_down + 2
            You test look_down + 1 pixels. A slice ends before its second number, so it is foot + 1 : foot + 1 + look_down.
        looks up: foot[:, None] + np.arange => foot[:, None] - np.arange
            (below < height) => (below >= 0)
            You test the pixels above the foot. Rows count downwards, so the pixels below have larger row numbers.
        below the last row: np.minimum(below, height - 1) => below
            You read pixels below the picture's last row. Near the lower edge there are fewer than look_down pixels below the foot. The slice foot + 1 : foot + 1 + look_down ends at the edge by itself.
        the last row repeated: & (below < height) =>
            At the lower edge you count the last row more than once. Missing pixels are not green, so count only pixels that exist.
        no foot in the last row: & yellow.all(axis=1) => & yellow.all(axis=1) & (foot < height - 1)
            You reject a foot in the picture's last row. If min_green is 0, no pixel below it has to be green, so only its run decides.
        round the edge: np.minimum(below, height - 1) => below % height
            & (below < height) =>
            At the lower edge you count green pixels from the top of the picture. Below the last row there are no pixels.
        no look-down rule: (green.sum(axis=1) >= min_green) & =>
            You accept columns without green below the foot. Use min_green.
        no tests: good = (green.sum(axis=1) >= min_green) & yellow.all(axis=1) => good = np.ones(len(foot), dtype=bool)
            You return the lowest yellow pixel of every column. Return it only if it passes both tests.
        every yellow pixel: + return np.argwhere(labels.T == 2)
            You return all yellow pixels. Return at most one point for a column, its lowest yellow pixel, and only if it passes both tests.
        every yellow pixel tested: + found = []
            + for u, v in np.argwhere(labels.T == 2):
            +     run = np.cumprod(labels[v::-1, u] == 2).sum()
            +     if (labels[v + 1 :, u][:look_down] == 1).sum() >= min_green and run >= min_height * len(labels):
            +         found.append((u, v))
            + return np.array(found).reshape(-1, 2)
            You test every yellow pixel. Test only the lowest one of each column, and reject the column if it fails.
        from the highest to the lowest: yellow.all(axis=1) => (foot - (labels[:, columns] == 2).argmax(axis=0) + 1 >= min_height * height)
            You measure from the highest to the lowest yellow pixel, so other labels between them count too. Count from the foot up to the first pixel that is not yellow.
        rows instead of columns: + found = []
            + for u, row in enumerate(labels):
            +     for v in np.flatnonzero(row == 2)[-1:]:
            +         run = np.cumprod(row[v::-1] == 2).sum()
            +         if (row[v + 1 :][:look_down] == 1).sum() >= min_green and run >= min_height * len(labels):
            +             found.append((u, v))
            + return np.array(found).reshape(-1, 2)
            Your loop goes over the rows of the picture. A loop over labels.T goes over its columns.
        as many columns as rows: + found = []
            + for u in range(len(labels)):
            +     for v in np.flatnonzero(labels[:, u] == 2)[-1:]:
            +         run = np.cumprod(labels[v::-1, u] == 2).sum()
            +         if (labels[v + 1 :, u][:look_down] == 1).sum() >= min_green and run >= min_height * len(labels):
            +             found.append((u, v))
            + return np.array(found).reshape(-1, 2)
            You go through as many columns as the picture has rows. labels.shape is (rows, columns): H, W = labels.shape, and the columns are range(W).
        width and height exchanged: + found = []
            + for u in range(len(labels)):
            +     for v in np.flatnonzero(labels[:, u] == 2)[-1:]:
            +         run = np.cumprod(labels[v::-1, u] == 2).sum()
            +         if (labels[v + 1 :, u][:look_down] == 1).sum() >= min_green and run >= min_height * labels.shape[1]:
            +             found.append((u, v))
            + return np.array(found).reshape(-1, 2)
            You go through as many columns as the picture has rows. labels.shape is (rows, columns): H, W = labels.shape, and the columns are range(W). You have exchanged the two.
        row u instead of column u: + found = []
            + for u in range(labels.shape[1]):
            +     row = labels[u]
            +     for v in np.flatnonzero(row == 2)[-1:]:
            +         run = np.cumprod(row[v::-1] == 2).sum()
            +         if (row[v + 1 :][:look_down] == 1).sum() >= min_green and run >= min_height * len(labels):
            +             found.append((u, v))
            + return np.array(found).reshape(-1, 2)
            labels[u] is row u of the picture. Column u is labels[:, u].
        the post's top: & yellow.all(axis=1) => & yellow.all(axis=1)
            + while (higher := good & (foot > 0) & (labels[foot - 1, columns] == 2)).any():
            +     foot = foot - higher
            Your columns are right, but your rows are the upper ends of the runs. Return the foot, their lower end.
        no shape: .astype(float) => .astype(float) if good.any() else np.array([])
            Your answers are right except without candidates: np.array([]) has shape (0,). Use .reshape(-1, 2) to make it (0, 2).
        a mask: return np.column_stack([columns[good], foot[good]]).astype(float) => mask = np.zeros(labels.shape, dtype=bool)
            + mask[foot[good], columns[good]] = True
            + return mask
            You return a mask with the size of the picture. Return points, one row (u, v) for each candidate.
    """),
    alternatives={
        "a loop over columns, integers": _candidates_loop,
        "regular expressions": _candidates_regex,
        "cumulative sums": _candidates_by_sums,
    },
    equivalents={
        "green = (labels[np.minimum(below, height - 1), columns[:, None]] == 1) * (below < height)": "* of two boolean arrays is their &",
        "green = (labels[np.minimum(below, height - 1), columns[:, None]] == 1) // (below < height)": "1 // 1 is 1, and all other quotients of NumPy's booleans are 0",
        "good = (green.sum(axis=1) >= min_green) * yellow.all(axis=1)": "* of two boolean arrays is their &",
        "below = foot[:, None] + np.arange(0, look_down + 1)": "the foot itself is yellow, so it adds no green",
        "return np.column_stack([columns[good], foot[good]])": "integers are the same points",
        "run = foot[:, None] - np.arange(min_height * height, dtype=int)": "np.arange has as many numbers below a fractional stop as below the next integer",
        "green = (labels[np.minimum(height - 1, below), columns[:, None]] == 1) & (below < height)": "the smaller of two numbers does not depend on their order",
    },
)


# --- 2.2 cluster_points ---
def _clusters_scipy(points: Array, max_distance: float) -> Array:
    if len(points) < 2:
        return points
    names = fcluster(linkage(points, "single"), max_distance, "distance")
    return np.array([points[names == name].mean(axis=0) for name in np.unique(names)])


def _clusters_closure(points: Array, max_distance: float) -> Array:
    """Compute reachability by squaring the matrix of neighbours until nothing changes."""
    reached = np.linalg.norm(points[:, None] - points, axis=2) <= max_distance
    for _ in range(len(points).bit_length() + 1):
        reached = reached.astype(np.float32) @ reached > 0
    means = [points[row].mean(axis=0) for row in np.unique(reached, axis=0)]
    return np.array(means, dtype=np.float32).reshape(-1, 2)


def _clusters_joined(points: Array, max_distance: float) -> Array:
    """Let each point join all groups that it is near, and return the means from right to left."""
    groups: list[Array] = []
    for point in points:
        joined, apart = [point[None]], []
        for group in groups:
            (joined if np.hypot(*(group - point).T).min() <= max_distance else apart).append(group)
        groups = [*apart, np.vstack(joined)]
    return np.array([group.mean(axis=0) for group in groups]).reshape(-1, 2)[::-1]


def _points(*points: tuple[float, float]) -> Array:
    return np.array(points, dtype=float)


def _chain(rng: np.random.Generator, length: int, step: float) -> Array:
    """Return points in a row, shuffled."""
    way = rng.uniform(-1, 1, 2)
    points = rng.uniform(0, 200, 2) + np.outer(np.arange(length), way / np.hypot(*way) * step)
    return rng.permutation(points)


def _clusters_public() -> list[Case]:
    rng = np.random.default_rng(22)
    posts = _points((40, 120), (41, 121), (42, 121), (43, 120), (200, 90), (201, 92), (203, 90))
    chain = _points((0, 50), (20, 50), (10, 50), (5, 50), (15, 50))
    slanted = _points((0, 0), (4, 4), (30, 30), (33.5, 33.5), (60, 0), (60, 6))
    turns = _points((1, 5), (2, 60), (3, 5), (4, 60), (5, 6), (9, 60))
    star = _points((50, 40), (70, 40), (60, 52), (60, 44))
    return [
        Case((posts, 5.0), "two posts"),
        Case((posts[[3, 6, 0, 5, 1, 4, 2]], 1.5), "the same points in another order, a shorter distance"),
        Case((chain, 5.0), "a chain: its ends are far apart"),
        Case((_points((10, 20), (13, 24), (20, 20)), 5.0), "exactly max_distance apart"),
        Case((_points((10, 10), (10, 40), (11, 70), (12, 42)), 6.0), "above each other"),
        Case((slanted, 5.0), "diagonal steps"),
        Case((turns, 5.0), "one cluster above the other"),
        Case((_chain(rng, 9, 3.0), 4.0), "a shuffled chain"),
        Case((_chain(np.random.default_rng(60), 60, 3.0), 4.0), "a shuffled chain of 60 points"),
        Case((_points((0, 0), (1, 10), (5, 5)), 8.0), "two points joined by a third one"),
        Case((_points((0, 0), (10, 1), (5, 5)), 8.0), "the same, mirrored"),
        Case((_points((0, 0), (1, 6), (3, -4)), 7.0), "a point between two others"),
        Case((star, 11.0), "three points joined by a fourth one"),
        Case((np.zeros((0, 2)), 5.0), "no points"),
        Case((np.array([(7.0, 9.0)]), 5.0), "one point"),
    ]


def _clusters_hidden(rng: np.random.Generator) -> list[Case]:
    posts = [rng.normal(middle, 3.0, (12, 2)) for middle in ((40, 100), (150, 90), (152, 180))]

    def chains() -> Array:
        return np.vstack([_chain(rng, int(rng.integers(6, 14)), 3.0) for _ in range(3)])

    def turns() -> Array:
        return np.column_stack([np.arange(12.0), [float(rng.integers(0, 9)), 40] * 6])

    return [
        Case((rng.permutation(np.vstack(posts)), 14.0)),
        *(Case((chains(), 3.5)) for _ in range(3)),
        Case((rng.permutation(np.vstack([_chain(rng, 8, 5.0), 400 + _chain(rng, 5, 5.0)])), 6.0)),
        Case((_points((10, 20), (13, 24), (16, 28), (40, 20)), 5.0)),
        Case((turns(), 4.0)),
        Case((rng.permutation(rng.uniform(10, 60, 2) + np.array([(0, 0), (1, 10), (5, 5)])), 8.0)),
        Case((rng.permutation(rng.uniform(10, 60, 2) + np.array([(0, 0), (1, 6), (3, -4)])), 7.0)),
        Case((rng.uniform(10, 60, 2) + np.array([(0.0, 0), (20, 0), (10, 12), (10, 4)]), 11.0)),
        Case((rng.uniform(0, 60, (25, 2)).round(1), 7.03)),
        Case((rng.uniform(0, 60, (25, 2)).round(1), 10.03)),
        Case((np.zeros((0, 2)), float(rng.uniform(1, 9)))),
        Case((rng.uniform(0, 60, (1, 2)), 3.0)),
        Case((_chain(rng, 60, 3.0), 3.5)),
    ]


CLUSTER_POINTS = Exercise(
    name="cluster_points",
    points=4,
    stars=3,
    public=_clusters_public,
    hidden=_clusters_hidden,
    comparison=Points(tolerance=0.05),
    hints=(
        "points[:, None] - points has all differences, shape (N, N, 2), and np.linalg.norm(..., axis=2) their lengths. One comparison then shows which points are neighbours. A cluster contains all points that are connected over neighbours, also over several of them.",
        "Give each point its own number. Then let each point take the smallest number among its neighbours, again and again, until nothing changes: np.where(near, numbers, len(points)).min(axis=1, initial=len(points)). Points with the same number are a cluster; average points[numbers == number].",
    ),
    sibling=Sibling(
        "Friends of friends are one group, as points that are connected by a chain are one cluster: everybody takes the smallest number among their friends until nothing changes.",
        """
        import numpy as np

        friends = [(4, 5), (1, 4), (0, 2)]
        ages = np.array([20, 30, 24, 50, 36, 42])
        group, old = np.arange(6), None
        while not np.array_equal(group, old):
            old = group.copy()
            for a, b in friends:
                group[[a, b]] = min(group[a], group[b])
        print(group)
        print([float(ages[group == number].mean()) for number in np.unique(group)])
        """,
        """
        [0 1 0 3 1 1]
        [22.0, 36.0, 50.0]
        """,
    ),
    mistakes=catalogue("""
        near the first point only: while not np.array_equal(names, before): => for i, row in enumerate(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = np.flatnonzero(row & (names == np.arange(len(points))))[0]
            You compare a point only with the first point of a cluster, so chains break. A point belongs to a cluster if it is near any of its points.
        clusters never join: while not np.array_equal(names, before): => for i, row in enumerate(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = names[row].min()
            Your result depends on the order of the points. A point that is near two clusters has to merge them.
        sorted by column, clusters never join: + points = points[np.argsort(points[:, 0], kind="stable")]
            while not np.array_equal(names, before): => for i, row in enumerate(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = names[row].min()
            Sorting by column is not enough. A point that is near two of your clusters has to merge them, but you add it to the first.
        near the last point only: + points = points[np.argsort(points[:, 0], kind="stable")]
            while not np.array_equal(names, before): => for i, row in enumerate(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => last = [j for j in range(i) if names[j] not in names[j + 1 : i]]
            + names[i] = min((names[j] for j in last if row[j]), default=i)
            You sort by column and compare only with the last point of a cluster. A point belongs to a cluster if it is near any of its points, and it merges all clusters that it is near.
        at most two joined: while not np.array_equal(names, before): => for i, row in enumerate(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[np.isin(names, np.unique(names[:i][row[:i]])[:2])] = i
            You merge at most two clusters. A point can be near three or more, and then all of them become one.
        near to all points: while not np.array_equal(names, before): => for i, row in enumerate(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[np.isin(names, [name for name in names[:i] if row[names == name].all()])] = i
            You require that a point is near all points of a cluster, or near their mean. It only has to be near one of them.
        near the mean: while not np.array_equal(names, before): => for i, point in enumerate(points):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => distances = [np.hypot(*(points[names == name].mean(axis=0) - point)) for name in names[:i]]
            + names[i] = next((name for name, each in zip(names, distances) if each <= max_distance), i)
            You compare a point with the mean of a cluster. In single linkage a point has to be near any point of the cluster.
        one round: while not np.array_equal(names, before): => if len(points):
            Your numbers are passed on only once. Repeat this until no number changes, so that a long chain gets a single number.
        two rounds: while not np.array_equal(names, before): => for _ in range(2):
            Your numbers are passed on only twice. Repeat this until no number changes.
        a fixed number of rounds: while not np.array_equal(names, before): => for _ in range(10):
            You pass the numbers on for a fixed number of rounds, which is too few for a long chain. Repeat this until no number changes.
        three rounds: while not np.array_equal(names, before): => for _ in range(3):
            You pass the numbers on for a fixed number of rounds, which is too few for a long chain. Repeat this until no number changes. Three rounds are not always enough.
        five rounds: while not np.array_equal(names, before): => for _ in range(5):
            You pass the numbers on for a fixed number of rounds, which is too few for a long chain. Repeat this until no number changes. Five rounds are not always enough.
        twenty rounds: while not np.array_equal(names, before): => for _ in range(20):
            You pass the numbers on for a fixed number of rounds, which is too few for a long chain. Repeat this until no number changes. Twenty rounds are not always enough.
        two passes over the pairs: while not np.array_equal(names, before): => for i, j in 2 * np.argwhere(near).tolist():
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = min(names[i], names[j])
            You pass the numbers on for a fixed number of rounds, which is too few for a long chain. Repeat this until no number changes. Two passes are not always enough.
        three passes over the pairs: while not np.array_equal(names, before): => for i, j in 3 * np.argwhere(near).tolist():
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = min(names[i], names[j])
            You pass the numbers on for a fixed number of rounds, which is too few for a long chain. Repeat this until no number changes. Three passes are not always enough.
        ten passes over the pairs: while not np.array_equal(names, before): => for i, j in 10 * np.argwhere(near).tolist():
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = min(names[i], names[j])
            You pass the numbers on for a fixed number of rounds, which is too few for a long chain. Repeat this until no number changes. Ten passes are not always enough.
        old clusters kept: + clusters = []
            + for point in points:
            +     joined = [point]
            +     for each in clusters:
            +         if min(np.linalg.norm(point - other) for other in each) <= max_distance:
            +             joined = joined + each
            +     clusters.append(joined)
            + return np.array([np.mean(each, axis=0) for each in clusters]).reshape(-1, 2)
            You merge clusters but keep the old ones, too, so some points are in several clusters. Remove the old ones.
        added to every cluster: + clusters = []
            + for point in points:
            +     joined = [each for each in clusters if min(np.linalg.norm(point - other) for other in each) <= max_distance]
            +     for each in joined:
            +         each.append(point)
            +     if not joined:
            +         clusters.append([point])
            + return np.array([np.mean(each, axis=0) for each in clusters]).reshape(-1, 2)
            You add a point to every cluster that it is near, so clusters share points. These clusters have to become one.
        number of one neighbour: while not np.array_equal(names, before): => for i, row in enumerate(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = names[[i, *np.flatnonzero(row[:i])][-1]]
            Each point takes over the number of one earlier neighbour. If it is near two clusters, all their points need the same number, so repeat until no number changes.
        minimum of nothing: len(points)).min(axis=1, initial=len(points)) => len(points)).min(axis=1)
            Your answers are right, but without points your function raises an error: an empty array has no minimum, and scipy's linkage needs two points. Return np.zeros((0, 2)) first.
        linkage of fewer than two points: + if len(points) < 2:
            +     raise ValueError
            Your answers are right, but with fewer than two points your function raises an error. If you use scipy's linkage, it needs at least two. Return the points themselves if there are fewer.
        linkage of one point: + if len(points) == 1:
            +     raise ValueError
            Your answers are right, but with one point your function raises an error. If you use scipy's linkage, it needs at least two points. Return the point itself if there is only one.
        single points left out: for name in np.unique(names)] => for name in np.unique(names) if (names == name).sum() > 1]
            You leave out clusters of one point. A point without neighbours is also a cluster.
        decimals of the points: + points = points.astype(int)
            You cut off the decimals of the points with int. Use the points as they are.
        one pass over the pairs: while not np.array_equal(names, before): => for i, j in np.argwhere(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[j] = names[i]
            You visit each pair of neighbours once, so a number may not reach the other end of a long chain. Repeat the loop until no number changes.
        the smaller number in one pass: while not np.array_equal(names, before): => for i, j in np.argwhere(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = names[j] = min(names[i], names[j])
            You give both neighbours the smaller number, but only in one pass over the pairs. A point that took its number before may need a smaller one now, so repeat the loop until no number changes.
        the smaller number in one pass over half the pairs: while not np.array_equal(names, before): => for i, j in np.argwhere(np.triu(near, 1)):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = names[j] = min(names[i], names[j])
            You give both neighbours the smaller number, but only in one pass over the pairs. A point that took its number before may need a smaller one now, so repeat the loop until no number changes. You pass each pair once.
        removed by value: + clusters = []
            + for point in points:
            +     joined = [point]
            +     for each in [each for each in clusters if min(np.linalg.norm(point - other) for other in each) <= max_distance]:
            +         joined = joined + each
            +         clusters.remove(each)
            +     clusters.append(joined)
            + return np.array([np.mean(each, axis=0) for each in clusters]).reshape(-1, 2)
            A list's remove(c) compares c with the other clusters, and arrays cannot be compared to a single True or False. Build a new list of the clusters that the point is not near.
        nothing found: + return np.zeros((0, 2))
            You return no points. Return one for each cluster; a point without neighbours is also a cluster.
        rounded means: .mean(axis=0) => .mean(axis=0).round()
            You round the means to whole numbers. Return them as they are.
        means of means: + clusters = []
            + for point in points:
            +     near = [each for each in clusters if np.linalg.norm(point - each) <= max_distance]
            +     clusters = [each for each in clusters if np.linalg.norm(point - each) > max_distance]
            +     clusters.append(np.mean([point, *near], axis=0))
            + return np.array(clusters).reshape(-1, 2)
            You keep only the mean of each cluster. A point belongs to a cluster if it is near any of its points, and a mean of means gives all clusters the same weight. Keep all points of a cluster until the end.
        whole numbers: .mean(axis=0) => .mean(axis=0).astype(int)
            You cut off the decimals of the means with int. Return floats.
        only neighbours averaged: [points[names == name].mean(axis=0) for name in np.unique(names)] => [points[row].mean(axis=0) for row in near]
            + means = np.unique(np.array(means).reshape(-1, 2), axis=0)
            You average each point with its own neighbours. The neighbours of neighbours belong to the cluster, too, and so on.
        sorted and cut: + points = points[np.argsort(points[:, 0], kind="stable")]
            <= max_distance => <= max_distance
            + near = np.tril(np.triu(near, -1), 1)
            You sort by u and start a new cluster where the next point is far. Points of two clusters above each other then alternate. Compare every point with every other one.
        columns only: np.linalg.norm(points[:, None] - points, axis=2) => np.abs(points[:, None] - points)[:, :, 0]
            You compare only the columns. Points above each other can also be far apart.
        sum of differences: np.linalg.norm(points[:, None] - points, axis=2) => np.abs(points[:, None] - points).sum(axis=2)
            Your distance is the sum of both differences. Use the square root of the sum of their squares.
        larger difference: np.linalg.norm(points[:, None] - points, axis=2) => np.abs(points[:, None] - points).max(axis=2)
            Your distance is the larger of both differences. Use the square root of the sum of their squares.
        root forgotten: np.linalg.norm(points[:, None] - points, axis=2) => np.square(points[:, None] - points).sum(axis=2)
            You compare the squared distance with max_distance. Take the square root first.
        less than: <= max_distance => <= max_distance - 1e-9
            Points that are exactly max_distance apart belong together. Use <=.
        one point kept: while not np.array_equal(names, before): => for i, row in enumerate(near):
            names = np.where(near, before, len(points)).min(axis=1, initial=len(points)) => names[i] = np.flatnonzero(row & (names == np.arange(len(points))))[0]
            .mean(axis=0) => [0]
            You return one point of each cluster. Return the mean of its points.
        wrong axis: .mean(axis=0) => .mean(axis=1)[[0, 0]]
            You average u and v of a point, because mean(axis=1) averages along a row. The mean over the points is mean(axis=0).
        mean of all numbers, groups: + groups = []
            + for point in points:
            +     apart = [each for each in groups if np.hypot(*(each - point).T).min() > max_distance]
            +     joined = [each for each in groups if np.hypot(*(each - point).T).min() <= max_distance]
            +     groups = [*apart, np.vstack([point[None], *joined])]
            + return np.array([each.mean() for each in groups]).reshape(-1, 2)
            mean() without an axis averages all coordinates to one number. The mean over the points is mean(axis=0).
        one number for each cluster: .mean(axis=0) => .mean()
            Your mean of a cluster is one number, because mean() without an axis averages u and v together. Use axis=0.
        one number for each cluster, no columns: + groups = []
            + for point in points:
            +     apart = [each for each in groups if np.hypot(*(each - point).T).min() > max_distance]
            +     joined = [each for each in groups if np.hypot(*(each - point).T).min() <= max_distance]
            +     groups = [*apart, np.vstack([point[None], *joined])]
            + return np.array([each.mean() for each in groups])
            You return one number for each cluster instead of (u, v). With axis=0, the mean is taken over the points and has both coordinates.
        one number for each cluster, no points first: + if not len(points):
            +     return np.zeros((0, 2))
            .mean(axis=0) => .mean()
            .reshape(-1, 2) =>
            You return one number for each cluster instead of (u, v). With axis=0, the mean is taken over the points and has both coordinates. Your early return without points is right.
        one number for each cluster, scipy: + from scipy.cluster.hierarchy import fcluster, linkage
            + if len(points) < 2:
            +     return points
            + names = fcluster(linkage(points), max_distance, "distance")
            + return np.array([points[names == name].mean() for name in np.unique(names)])
            You return one number for each cluster instead of (u, v). With axis=0, the mean is taken over the points and has both coordinates. What you do with fcluster is right.
        numbers from 0, scipy: + from scipy.cluster.hierarchy import fcluster, linkage
            + if len(points) < 2:
            +     return points
            + names = fcluster(linkage(points), max_distance, "distance")
            + return np.array([points[names == name].mean(axis=0) for name in range(names.max())])
            fcluster numbers the clusters from 1 to the largest number, and range ends before its second number. Use np.unique to go through the numbers that exist.
        the largest number left out, scipy: + from scipy.cluster.hierarchy import fcluster, linkage
            + if len(points) < 2:
            +     return points
            + names = fcluster(linkage(points), max_distance, "distance")
            + return np.array([points[names == name].mean(axis=0) for name in range(1, names.max())])
            fcluster numbers the clusters from 1 to the largest number, and range ends before its second number. Use np.unique to go through the numbers that exist. You leave the largest number out.
        three numbers, scipy: + from scipy.cluster.hierarchy import fcluster, linkage
            + if len(points) < 2:
            +     return points
            + names = fcluster(linkage(points), max_distance, "distance")
            + return np.array([points[names == name].mean(axis=0) for name in range(3)])
            Some of the numbers that you go through belong to no point, so their mean is NaN, and others may be missing. Go through np.unique of your numbers.
        another criterion, scipy: + from scipy.cluster.hierarchy import fcluster, linkage
            + if len(points) < 2:
            +     return points
            + names = fcluster(linkage(points), max_distance)
            + return np.array([points[names == name].mean(axis=0) for name in np.unique(names)])
            fcluster does not compare distances with max_distance by default. Pass criterion="distance".
        three numbers: np.unique(names)] => range(3)]
            Some of the numbers that you go through belong to no point, so their mean is NaN, and others may be missing. Go through np.unique of your numbers. There are not always three clusters.
        as many numbers as clusters: np.unique(names)] => range(len(np.unique(names)))]
            Some of the numbers that you go through belong to no point, so their mean is NaN, and others may be missing. Go through np.unique of your numbers. The numbers in use need not be 0, 1, 2 and so on.
        all numbers: np.unique(names)] => range(len(points))]
            Some of the numbers that you go through belong to no point, so their mean is NaN, and others may be missing. Go through np.unique of your numbers. Not every number below the number of points is in use.
        all numbers up to the largest: np.unique(names)] => range(max(names) + 1)]
            Some of the numbers that you go through belong to no point, so their mean is NaN, and others may be missing. Go through np.unique of your numbers. The numbers up to the largest have gaps.
        the median: points[names == name].mean(axis=0) => np.median(points[names == name], axis=0)
            You return the median of each cluster. The paper uses the mean.
        midpoint of the ends: points[names == name].mean(axis=0) => (points[names == name].min(axis=0) + points[names == name].max(axis=0)) / 2
            You return the midpoint between the smallest and the largest values. Use the mean of all points.
        no shape: .reshape(-1, 2) =>
            Your answers are right except without points: np.array([]) has shape (0,). Use .reshape(-1, 2) to make it (0, 2).
        mean of nothing: + if not len(points):
            +     return np.full((1, 2), np.nan)
            Your answers are right except without points: the mean of no points is NaN. Return an array of shape (0, 2).
    """),
    alternatives={
        "scipy": _clusters_scipy,
        "powers of a matrix, float32": _clusters_closure,
        "groups that are joined": _clusters_joined,
    },
    equivalents={
        "return np.array(means).reshape(~1, 2)": "NumPy computes any negative length",
        "return np.array(means).reshape(-2, 2)": "NumPy computes any negative length",
        "near = np.linalg.norm(points[:, None] - points, axis=1 - 2) <= max_distance": "-1 is the last axis, which is 2",
        "while not np.array_equal(before, names):": "equality is symmetric",
        "near = np.linalg.norm(points - points[:, None], axis=2) <= max_distance": "a difference has the same length as its negative",
    },
)


# --- 2.3 find_goalposts ---
def _feet_by_blobs(labels: Array) -> Array:
    """Find yellow blobs, and test the green below the centre of their lowest row."""
    height, feet = len(labels), []
    number, names = cv2.connectedComponents((labels == YELLOW).astype(np.uint8), connectivity=4)
    for blob in (names == name for name in range(1, number)):
        tall = blob.sum(axis=0) >= 0.1 * height  # a goal is one blob with two runs of tall columns
        edges = np.flatnonzero(np.diff(tall, prepend=False, append=False))
        for left, right in edges.reshape(-1, 2):
            v = np.flatnonzero(blob[:, left:right].any(axis=1))[-1]
            below = labels[v + 1 : v + 1 + max(height // 24, 1), left:right]
            if below.size and (below == GREEN).mean() > 0.6:
                feet.append(((left + right - 1) / 2, float(v)))
    return np.array(feet).reshape(-1, 2)


def _feet_by_sums(labels: Array) -> Array:
    """Use other parameters, cumulative sums and scipy."""
    height = len(labels)
    found = _candidates_by_sums(labels, round(height / 30), round(height / 20), 0.1)
    return _clusters_scipy(found, height / 12)


def _feet_by_columns(labels: Array) -> Array:
    """Split candidates where the next one is far, and return the median column and the lowest row."""
    scale = len(labels) / 240
    found = _candidates_loop(labels, max(round(6 * scale), 1), max(round(8 * scale), 1), 0.12)
    posts = np.split(found, np.flatnonzero(np.diff(found[:, 0]) > 16 * scale) + 1)
    return np.array([(np.median(post[:, 0]), post[:, 1].max()) for post in posts if len(post)]).reshape(-1, 2)


def _goal(rng: np.random.Generator, rows: int, left: float, right: float, depth: float = 0.5) -> Array:
    """Return a goal with its bar in front of a wall; positions are fractions of the width and height."""
    columns, width, foot = rows * 4 // 3, max(rows // 16, 3), round(depth * rows)
    labels = field(rows, columns, round(0.34 * rows))
    line, low = foot + rows // 10 + 1, round(0.8 * rows)
    labels[line : line + rows // 60] = WHITE  # in front of the posts, which stand on green
    labels[: rows // 24 + 1, round(left * columns) : round(right * columns) + width] = YELLOW
    for post in (left, right):
        stand(labels, round(post * columns), width, 0, foot)
    bag, peel = (slice(round(a * columns), round(b * columns)) for a, b in ((0.4, 0.5), (0.55, 0.62)))
    labels[round(0.06 * rows) : round(0.19 * rows), bag] = YELLOW
    labels[low : low + max(rows // 30, 1), peel] = YELLOW
    labels[(rng.random(labels.shape) < 0.003) & (labels == OTHER)] = YELLOW
    return labels


def _several(rows: int, *posts: tuple[float, float]) -> Array:
    """Return several posts on carpet, each with its left edge and height as fractions of the picture's height."""
    labels = field(rows, rows * 4 // 3, rows // 4)
    for left, tall in posts:
        foot = round((0.4 + 0.5 * tall) * rows)  # a taller post is nearer, so its foot is lower
        top = foot + 1 - int(np.ceil(tall * rows))
        stand(labels, round(left * rows), max(rows // 24, 2), top, foot)
    return labels


def _near_edge(rows: int, below: float) -> Array:
    """Return one post on carpet, with only a fraction of the height below its foot."""
    labels = field(rows, rows * 4 // 3, rows // 4)
    return stand(labels, rows // 2, max(rows // 12, 3), 0, rows - 1 - round(below * rows))


def _narrow(rows: int, left: int, gap: int = 0, columns: int = 0) -> Array:
    """Return a goal seen from the side, with posts a fifth of the height apart."""
    labels, width = field(rows, columns or rows * 4 // 3, rows // 4), max(rows // 24, 2)
    for shift in (0, (gap or -(-rows // 5)) + width):
        stand(labels, left + shift, width, 0, rows // 2)
    return labels


def _strip(rows: int, below: str, foot: float = 0.5, high: float = 0.4, columns: int = 12) -> Array:
    """Return a strip of a picture with a yellow object of `high` times the height, and labels below it by letters.

    Each letter stands for a 240th of the height, and the rest of the ground is green: o other, g green, w white.
    """
    labels, v = field(rows, columns, rows // 5), round(foot * rows)
    stand(labels, columns // 4, columns // 2, max(v + 1 - round(high * rows), 0), v)
    for i, letter in enumerate(below):
        from_row, to_row = (v + 1 + round(each * rows / 240) for each in (i, i + 1))
        labels[from_row:to_row] = "ogyw".index(letter)
    return labels


def _with_gap(labels: Array) -> Array:
    """Add noise below the middle third of a post's columns, so that no foot is found there."""
    rows, columns = np.nonzero(labels == YELLOW)
    below, third = rows.max() + 1, (np.ptp(columns) + 1) // 3
    between = slice(columns.min() + third, columns.max() + 1 - third)
    labels[below : below + max(len(labels) // 40, 1), between] = OTHER
    return labels


def _strips(rows: int, columns: int, foot: float) -> dict[str, Array]:
    """Return strips with a line below a foot, distant and split posts, and two background objects, by their names."""
    return {
        "a thin line right below the foot": _strip(rows, "ggww", foot, columns=columns),
        "a thin line a little below the foot": _strip(rows, "gggggggggggww", foot, columns=columns),
        "a post far away": _strip(rows, "", foot, high=0.13, columns=columns),
        "noise below the middle of a post": _with_gap(_strip(rows, "", foot, columns=columns)),
        "a bag above a thin strip of green": _strip(rows, "ogggggwwwwwww", foot, columns=columns),
        "a bag above the wall": _strip(rows, "o" * 14, foot, columns=columns),
    }


def _posts_public() -> list[Case]:
    rng = np.random.default_rng(23)
    nothing = field(48, 64, 14)
    nothing[4:14, 20:26] = YELLOW
    return [
        Case((_goal(rng, 48, 0.12, 0.78),), "a goal, a bag behind the field and a banana peel"),
        Case((_near_edge(48, 0.09),), "a post near the lower edge"),
        Case((_near_edge(48, 0.0),), "a post whose foot is below the picture"),
        Case((_narrow(48, 21),), "a goal seen from the side"),
        Case((stand(field(48, 64, 12), 30, 4, 2, 33),), "one post"),
        Case((nothing,), "a bag and no post"),
        Case((np.repeat(np.repeat(_goal(rng, 24, 0.2, 0.7), 2, 0), 2, 1),), "another goal"),
        Case((_goal(rng, 36, 0.15, 0.7, 0.6),), "a smaller picture"),
        Case((_several(48, (0.3, 0.6), (1.0, 0.15)),), "a near post and a distant one"),
        Case((_several(48, (0.1, 0.3), (0.6, 0.3), (1.1, 0.3)),), "three posts"),
        Case((_narrow(48, 10, 17),), "posts a third of the height apart"),
        Case((_narrow(36, 40, columns=84),), "a wide picture, posts a fifth of the height apart"),
        *(Case((labels,), f"a strip of 240 rows, {name}") for name, labels in _strips(240, 12, 0.5).items()),
        *(
            Case((labels,), f"a strip of 480 rows, {name}")
            for name, labels in _strips(480, 6, 0.5).items()
            if name in ("a post far away", "a bag above a thin strip of green")
        ),
    ]


def _posts_hidden(rng: np.random.Generator) -> list[Case]:
    low, high = (0.08, 0.65, 0.45), (0.25, 0.85, 0.65)
    return [
        *(Case((_goal(rng, rows, *rng.uniform(low, high)),)) for rows in (36, 48, 60, 120, 240, 480)),
        *(Case((_near_edge(*edge),)) for edge in ((48, 0.085), (240, 0.06), (480, 0.0))),
        *(Case((_narrow(rows, int(rng.integers(5, rows))),)) for rows in (48, 72, 240)),
        Case((_narrow(120, int(rng.integers(5, 300)), columns=400),)),
        Case((field(120, int(rng.integers(100, 160)), 40),)),
        *(
            Case((_several(n, (rng.uniform(0.1, 0.5), 0.6), (rng.uniform(0.8, 1.2), 0.15)),))
            for n in (60, 240)
        ),
        *(
            Case((_several(n, *((left, rng.uniform(0.2, 0.4)) for left in (0.1, 0.6, 1.1))),))
            for n in (60, 240)
        ),
        *(Case((each,)) for n in (240, 480) for each in _strips(n, n // 16, rng.uniform(0.4, 0.7)).values()),
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
        "First find candidates and then cluster them, with your two functions and your own parameters. Begin with values for pictures of 240 rows, from the panel above or by measuring.",
        "A picture of 480 rows has twice as many pixels below a foot, and one of 48 rows a fifth. Multiply values in pixels by labels.shape[0] / 240 and round them. min_height is a fraction already.",
    ),
    sibling=Sibling(
        "A length in frames grows with the frame rate as a length in pixels grows with the picture, but a fraction stays the same.",
        """
        for rate in (25, 30, 60):  # frames per second; the values were chosen at 25
            scale = rate / 25
            shortest, pause = round(5 * scale), round(40 * scale)
            print(f"{rate}: a clap has {shortest} frames or more, a pause {pause}; a third of all is silent")
        """,
        """
        25: a clap has 5 frames or more, a pause 40; a third of all is silent
        30: a clap has 6 frames or more, a pause 48; a third of all is silent
        60: a clap has 12 frames or more, a pause 96; a third of all is silent
        """,
    ),
    mistakes=catalogue("""
        values for 240 rows: len(labels) / 240 => 1
            Your parameters work only for 240 rows. In smaller pictures they require more green than there is. Scale them with labels.shape[0].
        green not scaled: [8 * scale, 10 * scale] => [8, 10]
            You scale the distance for clustering, but min_green and look_down are the same for every size. Scale them too.
        all green: 8 * scale => 10 * scale
            You require too many green pixels below a foot. A fifth of the pixels there may be something else, such as a thin line or noise.
        one green pixel far down: [8 * scale, 10 * scale] => [scale, 24 * scale]
            You test many pixels below the foot and require few green ones. There is carpet far below almost every object, so test fewer pixels and require more green.
        half green: 8 * scale => 5 * scale
            You report a bag above a thin strip of green. Half of the pixels below it are green, so require more than that.
        a fifth of the height: 0.1 => 0.2
            You lose distant posts. A post of a tenth of the picture's height has to be found.
        three twentieths of the height: 0.1 => 0.15
            Your smallest height is more than a tenth of the picture's height, so you lose posts that are hardly taller than that. Lower it.
        look_down rounded down: np.ceil([8 * scale, 10 * scale]).astype(int) => 8 * scale, int(10 * scale)
            In small pictures you require more green pixels than you test: for 36 rows, 8 * scale is 1.2, but int(10 * scale) is 1. Round both numbers in the same way.
        height scaled: 0.1 => 0.1 * scale
            You scale min_height, which is a fraction of the picture's height already. Use the same fraction for every size.
        scale upside down: len(labels) / 240 => 240 / len(labels)
            Your parameters become larger in smaller pictures. The scale is labels.shape[0] / 240, not the inverse.
        less ground: / 240 => / 480
            You test less ground than the requirements describe, so a thin line covers too much of it. Test a twenty-fourth of the picture's height.
        short linkage: 20 * scale => 2 * scale
            You report one post twice if noise hides the columns in its middle. Increase the distance for clustering.
        short linkage of a few pixels: 20 * scale => 2
            You report one post twice where noise hides the columns in its middle. Your distance for clustering is a few pixels; it has to be longer than the hidden part, and scaled.
        linkage below a pixel: 20 * scale => 5 * scale
            In small pictures your distance for clustering is less than one pixel, so each column becomes a post. Use a larger one, because posts are far apart.
        linkage not scaled: 20 * scale => 20
            You do not scale the distance for clustering. In a picture of 48 rows, 20 pixels merge two posts.
        long linkage: 20 * scale => 60 * scale
            You merge two posts into one. They may be only a fifth of the picture's height apart, so use a smaller distance for clustering.
        a low height: 0.1 => 1 / 40
            You report objects that lie on the carpet, because your smallest height is too low. A post is at least a tenth of the picture's height tall.
        a thirtieth of the height: 0.1 => 0.03
            You report objects on the carpet that are only a thirtieth of the picture's height tall. A post is at least a tenth of it.
        arguments swapped: min_green, look_down = np.ceil => look_down, min_green = np.round
            You require more green pixels than you test. The order of the arguments is min_green, look_down.
        part of the width: len(labels) / 240 => labels.shape[1] / 320
            You scale with the width, but some pictures are narrow strips. Scale with the height, labels.shape[0].
        width by 240: len(labels) / 240 => labels.shape[1] / 240
            np.ceil => np.round
            You divide the width by 240, so your scale depends on the wrong side of the picture. Use labels.shape[0].
        part of the width, rounded: len(labels) / 240 => labels.shape[1] / 320
            np.ceil => np.round
            Your scale is a fraction of the width, so it is almost 0 in a narrow strip. Use the height, labels.shape[0].
        never below 240 rows: len(labels) / 240 => max(1, round(len(labels) / 240))
            Your scale is a whole number and at least 1, so smaller pictures get the values for 240 rows. Divide with /, and round only min_green and look_down.
        distant posts only without near ones: return cluster_points(candidates, 20 * scale) => near = cluster_points(post_candidates(labels, min_green, look_down, 0.2), 20 * scale)
            + return near if len(near) else cluster_points(candidates, 20 * scale)
            You look for short posts only if there is no tall one. A picture can show a near post and a distant one, so use one smallest height for all.
        at most two: cluster_points(candidates, 20 * scale) => cluster_points(candidates, 20 * scale)[:2]
            You return at most two feet. A picture can show three posts.
        integer scale: / 240 => // 240
            In small pictures your parameters are 0, because // rounds down and 48 // 240 is 0. Divide with / and round integers at the end.
        nothing found: + return np.zeros((0, 2))
            You return no feet for any picture. Print the candidates before they are clustered.
        not clustered: cluster_points(candidates, 20 * scale) => candidates
            You return several points for each post, one per column. Cluster them.
        one foot for all: 20 * scale => np.inf
            You average all candidates to one point, which is between the posts. Use a smaller distance for clustering.
        no look-down rule: min_green, look_down, 0.1 => 0, look_down, 0.1
            You report yellow objects that do not stand on the carpet. Require green below the foot.
        any height: 0.1 => 0
            You report low objects on the carpet. Require a smallest height.
        (row, column): candidates = post_candidates => candidates = post_candidates
            + candidates = candidates[:, ::-1]
            Your points are (row, column). A point is (u, v), with the column first.
        the post's top: look_down, 0.1) => look_down, 0.1)
            + for point in candidates:
            +     while point[1] > 0 and labels[int(point[1]) - 1, int(point[0])] == 2:
            +         point[1] -= 1
            You found the posts, but you return their tops. Return the feet.
        no shape: candidates = post_candidates => candidates = post_candidates
            + if not len(candidates):
            +     return np.array([])
            Your answers are right except without posts: the result has shape (0,). It must be (0, 2).
    """),
    alternatives={
        "yellow blobs": _feet_by_blobs,
        "other values, cumulative sums and scipy": _feet_by_sums,
        "cut by columns, the lowest row": _feet_by_columns,
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
        "the requirements allow several values",
    ),
)


PLAN = LessonPlan(
    exercises=[POST_CANDIDATES, CLUSTER_POINTS, FIND_GOALPOSTS],
    questions=[
        Question(
            "why_given_up",
            "In the picture, a yellow bag behind the field is right below the bar. If the lowest yellow pixel of a column has no green below it, why is the column rejected and not searched further up to the bar?",
            {
                "To save time, because most columns have no post.": "It saves little time, because few columns contain yellow. Think of what the search would find further up.",
                "Because what is above it is hardly ever a foot.": "A foot is on the carpet, and the carpet is below everything else. If the lowest yellow pixel is not above carpet, then a higher one hardly ever is. The exception is a yellow speck in front of a post: it makes the rule lose a true foot.",
                "Because a post is always the lowest yellow thing in a picture.": "A banana peel on the carpet is lower, and so is a bag in front of the goal. The rule only considers the lowest yellow pixel of each column.",
            },
            "Because what is above it is hardly ever a foot.",
        ),
        Question(
            "why_part_of_height",
            "The paper's smallest height is a fraction of the picture's height. How does your search change in pictures of twice the size, 640 x 480, if min_green and look_down stay 8 and 10 pixels?",
            {
                "It does not change, because the rule counts pixels.": "It does change. Each pixel now covers half as much of the field, so ten pixels cover as much as five did before.",
                "It tests only half as much ground, so a thin strip of green is enough.": "Ten pixels now cover as much carpet as five did before, so the rule becomes weaker: a bag above a thin strip of green may pass. So scale all values in pixels with the height of the picture.",
                "It finds no posts, because they are too wide.": "The rule does not test the width. Wider posts only have more candidates.",
            },
            "It tests only half as much ground, so a thin strip of green is enough.",
        ),
    ],
    written=[
        Written(
            "explain_slanted_side",
            points=2,
            question="Why does a near post have candidates high up on its side if min_green is 0, and why does the test for green remove most of them?",
            rubric="1 point: the camera looks down, so in the picture posts are slanted or become wider upwards; in a column that crosses only the slanted side, the lowest yellow pixel is on the side and not on the ground. 1 point: below such a pixel are the post's blurred edge and then the background, so several of the pixels below are not green; where carpet is behind the edge, some candidates still pass.",
        )
    ],
)
