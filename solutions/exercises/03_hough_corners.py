"""Lesson 03, Hough corners: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.exercises import (
    All,
    Case,
    Close,
    Exact,
    Exercise,
    LessonPlan,
    Mistake,
    Points,
    Property,
    Question,
    Written,
)
from nao_course.lessons.hough_corners.segments import Segments, of_bytes

Array = npt.NDArray[Any]
OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3
SIZE = (48, 64)  # rows and columns of public pictures


# --- labels and pictures to try things on ---


def columns(*columns: str) -> Array:
    """Labels written as columns from the top: o other, g green, y yellow, w white."""
    return np.array([["ogyw".index(letter) for letter in column] for column in columns], dtype=np.uint8).T


def scattered(rng: np.random.Generator, rows: int, width: int) -> Array:
    """Labels in runs of all four in each column, green the most."""
    labels = np.zeros((rows, width), dtype=np.uint8)
    for u in range(width):
        v = 0
        while v < rows:
            length = int(rng.integers(1, 11))
            labels[v : v + length, u] = rng.choice([OTHER, GREEN, GREEN, YELLOW, WHITE])
            v += length
    return labels


def drawn(lines: list[tuple[float, float, float, float]], thickness: int = 5, shape: Any = SIZE) -> Array:
    """A picture of white lines on black."""
    picture = np.zeros(shape, dtype=np.uint8)
    for u1, v1, u2, v2 in lines:
        cv2.line(picture, (round(u1), round(v1)), (round(u2), round(v2)), 255, thickness)
    return picture


def field(
    lines: list[tuple[float, float, float, float]], horizon: int, thickness: int = 5, shape: Any = SIZE
) -> Array:
    """Labels of white lines on carpet, below a wall."""
    labels = np.full(shape, GREEN, dtype=np.uint8)
    labels[drawn(lines, thickness, shape) > 0] = WHITE
    labels[:horizon] = OTHER
    return labels


# --- 3.1 line_picture ---


def _lines_public() -> list[Case]:
    return [
        Case((columns("owgy", "wwoo", "ygow"),), "three columns of 4 pixels"),
        Case((field([(5, 20, 60, 26), (30, 24, 20, 46)], 14),), "lines on carpet below a wall"),
        Case((columns("oggy", "gyog"),), "nothing white"),
        Case((scattered(np.random.default_rng(30), 40, 30),), "labels by chance"),
    ]


def _lines_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        *(Case((scattered(rng, int(rng.integers(4, 60)), int(rng.integers(4, 60))),)) for _ in range(4)),
        Case((np.full((5, 7), WHITE, dtype=np.uint8),)),
        Case((np.full((6, 3), int(rng.choice([OTHER, GREEN, YELLOW])), dtype=np.uint8),)),
        Case((np.zeros((0, 4), dtype=np.uint8),)),
    ]


LINE_PICTURE = Exercise(
    name="line_picture",
    points=1,
    stars=1,
    public=_lines_public,
    hidden=_lines_hidden,
    comparison=All((Property(of_bytes), Exact())),
    hints=(
        "labels == 3 is true where a pixel is white. How does true become 255?",
        "np.where takes what is asked, what holds where it is true, and what holds elsewhere. The result counts in int64: .astype(np.uint8) makes a picture of it.",
    ),
    mistakes=[
        Mistake(
            "true and false",
            lambda labels: np.asarray(labels) == WHITE,
            "You return true and false. A picture is wanted: 255 and 0, as np.uint8.",
        ),
        Mistake(
            "ones",
            lambda labels: (np.asarray(labels) == WHITE).astype(np.uint8),
            "Your white is 1, which looks black in a picture. It has to be 255.",
        ),
        Mistake(
            "the labels left",
            lambda labels: np.where(np.asarray(labels) == WHITE, labels, 0).astype(np.uint8),
            "You keep the label 3 where it is white. A picture wants 255 there.",
        ),
        Mistake(
            "other labels left",
            lambda labels: np.where(np.asarray(labels) == WHITE, 255, labels).astype(np.uint8),
            "Green and yellow keep their labels, 1 and 2. All that is not white becomes 0.",
        ),
        Mistake(
            "eight bytes a pixel",
            lambda labels: (np.asarray(labels) == WHITE) * 255,
            "The numbers are right. OpenCV takes a picture of bytes only: end with .astype(np.uint8).",
        ),
        Mistake(
            "black lines",
            lambda labels: np.where(np.asarray(labels) == WHITE, 0, 255).astype(np.uint8),
            "Your lines are black on white. They have to be 255, and all else 0.",
        ),
        Mistake(
            "yellow too",
            lambda labels: np.where(np.asarray(labels) >= YELLOW, 255, 0).astype(np.uint8),
            "Yellow, label 2, becomes 255 as well. Goal posts are no lines: only label 3 is.",
        ),
        Mistake(
            "all but green",
            lambda labels: np.where(np.asarray(labels) != GREEN, 255, 0).astype(np.uint8),
            "All that is not green becomes 255. Only label 3 is white.",
        ),
    ],
    alternatives={
        "a product": lambda labels: (np.asarray(labels) == 3).astype(np.uint8) * np.uint8(255),
        "pixel by pixel": lambda labels: np.array(
            [[255 if label == 3 else 0 for label in row] for row in labels], dtype=np.uint8
        ).reshape(np.shape(labels)),
        "OpenCV": lambda labels: (
            cv2.inRange(np.asarray(labels), 3, 3) if np.size(labels) else np.array(labels)
        ),
        "a table": lambda labels: np.array([0, 0, 0, 255], dtype=np.uint8)[labels],
    },
    equivalents={
        "return np.where(labels >= 3, 255, 0).astype(np.uint8)": "no label is larger than 3",
    },
)


# --- 3.2 erase_background ---


def _erase(labels: Any, run: int, **changed: Any) -> Array:
    """Column by column, with one thing done in another way."""
    out = np.array(labels)
    if changed.get("rows"):
        return _erase(out.T, run).T
    if changed.get("upside_down"):
        return _erase(out[::-1], run)[::-1]
    run = changed.get("always", run)
    needed = run + changed.get("more", 0)
    for u in range(out.shape[1]):
        column = out[:, u].copy()
        count, first = 0, None
        for v, label in enumerate(column):
            green = label != OTHER if changed.get("any_colour") else label == GREEN
            count = count + 1 if green else (count if changed.get("in_all") else 0)
            if count >= needed and (first is None or changed.get("the_last")):
                first = v - run + 1 if changed.get("in_all") or changed.get("the_last") else v - count + 1
                first += changed.get("lower", 0)  # below 0 it counts from the bottom, as a slice does
        if first is None or (changed.get("rim") and first == len(column) - run):
            if not changed.get("left_alone"):
                out[:, u] = OTHER
        elif changed.get("below"):
            out[first:, u] = OTHER
        else:
            out[: first + (run if changed.get("run_too") else 0), u] = changed.get("paint", OTHER)
    return out


def _erased(**changed: Any) -> Any:
    return lambda labels, run=7: _erase(labels, run, **changed)


def _erase_all_but_white(labels: Any, run: int = 7) -> Array:
    kept = _erase(labels, run)
    return np.where(kept == WHITE, kept, 0).astype(np.uint8)


def _erase_mask(labels: Any, run: int = 7) -> Array:
    """Where something is left, as true and false."""
    return _erase(labels, run) > 0


def _erase_rolled(labels: Any, run: int = 7) -> Array:
    """Shifted copies that come back at the other end."""
    green = np.asarray(labels) == GREEN
    begins = np.logical_and.reduce([np.roll(green, -i, axis=0) for i in range(run)])
    return np.where(np.logical_or.accumulate(begins, axis=0), labels, 0)


def _erase_to_green(labels: Any, run: int = 7) -> Array:
    """By argmax, which is 0 as well where nothing is green."""
    labels = np.asarray(labels)
    first = (labels == GREEN).argmax(axis=0) if labels.size else 0
    return np.where(np.arange(len(labels))[:, None] >= first, labels, OTHER)


def _erase_window(labels: Any, run: int = 7) -> Array:
    """Windows of `run` rows that are all green, and all rows from the first of them on."""
    labels = np.asarray(labels)
    green = np.pad(labels == GREEN, ((0, run - 1), (0, 0)))
    safe = np.lib.stride_tricks.sliding_window_view(green, run, axis=0).all(axis=-1)
    return labels * np.maximum.accumulate(safe, axis=0)


def _erase_sums(labels: Any, run: int = 7) -> Array:
    """How many green pixels are above each row; where two of these counts, run apart, differ by run, all between are."""
    labels = np.asarray(labels)
    above = np.cumsum(np.pad(labels == GREEN, ((1, run - 1), (0, 0))), axis=0)
    begins = above[run:] - above[:-run] == run
    return np.where(np.logical_or.accumulate(begins, axis=0), labels, 0)


def _erase_morphology(labels: Any, run: int = 7) -> Array:
    """OpenCV's erosion with a column as its element, whose anchor is at the top."""
    labels = np.asarray(labels)
    green = (labels == GREEN).astype(np.uint8)
    safe = cv2.erode(
        green, np.ones((run, 1), np.uint8), anchor=(0, 0), borderType=cv2.BORDER_CONSTANT, borderValue=0
    )
    kept = labels.copy()
    kept[np.cumsum(safe.reshape(labels.shape), axis=0) == 0] = 0
    return kept


def _erase_public() -> list[Case]:
    return [
        Case(
            (columns("owgggwyg", "ggoggoww", "wwwggggw", "gggwoogw", "oggowggo"), 3),
            "five columns of 8 pixels, a run of 3",
        ),
        Case(
            (columns("oggwgggggggwgo", "ogggggggwwoggg", "oggggggwgggggw", "wgwgwgwgwgwggg"), 7), "runs of 7"
        ),
        Case((columns("ooogggg", "gggowww", "wwwwwww"), 4), "a run that ends at the picture's edge"),
        Case((columns("ggwowwog", "gwowowgg", "wgggwggg"), 3), "green at both ends, a run of 3"),
        Case((field([(5, 20, 60, 26), (30, 24, 20, 46)], 14), 7), "lines on carpet below a wall"),
        Case((columns("ywgw", "gwgo"), 1), "a run of one pixel"),
        Case((columns("wggggggwggggggg", "gggggggwogggggg", "ggggggggwoggggg"),), "the default run"),
        Case((scattered(np.random.default_rng(31), 40, 30), 6), "labels by chance"),
    ]


def _erase_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        *(Case((scattered(rng, 60, 50), run)) for run in (1, 3, 5, 7, 9)),
        Case((scattered(rng, 240, 320), 7)),
        Case((scattered(rng, 80, 60),)),
        Case((scattered(rng, 5, 30), 7)),
        Case((np.pad(scattered(rng, 9, 40) % 3 // 2 * WHITE, ((3, 4), (0, 0)), constant_values=GREEN), 6)),
        Case((np.full((20, 15), int(rng.choice([OTHER, WHITE])), dtype=np.uint8), 7)),
        Case((np.full((20, int(rng.integers(5, 15))), GREEN, dtype=np.uint8), 7)),
    ]


ERASE_BACKGROUND = Exercise(
    name="erase_background",
    points=3,
    stars=2,
    public=_erase_public,
    hidden=_erase_hidden,
    comparison=Exact(),
    hints=(
        "For one column first: where does the first run of green begin that is long enough? All above it becomes 0. The sum of "
        "labels[v : v + run, u] == 1 is run where a run begins at v.",
        "Without a loop over columns: green[i : i + H] is the picture i rows further down. A run of 3 begins where green, green one further down and green two "
        "further down are all true. Below the last row nothing is green: np.pad(green, ((0, run - 1), (0, 0))). np.logical_or.accumulate(begins, axis=0) is true from the "
        "first true row on.",
    ),
    mistakes=[
        Mistake(
            "seven in total",
            _erased(in_all=True),
            "You count all green pixels of a column. They have to follow each other: a pixel that is not green begins the count anew.",
        ),
        Mistake(
            "erases below",
            _erased(below=True),
            "You erase what is below the run. Rows count downwards: above it are the smaller ones.",
        ),
        Mistake(
            "from the bottom",
            _erased(upside_down=True),
            "You look from the bottom to the top. The background is above the field: begin at row 0.",
        ),
        Mistake(
            "rows for columns",
            _erased(rows=True),
            "You go along the rows. The scan goes down each column: labels[:, u].",
        ),
        Mistake(
            "the run too",
            _erased(run_too=True),
            "You erase the run as well. It is carpet already: only what is above its first pixel goes.",
        ),
        Mistake(
            "column left alone",
            _erased(left_alone=True),
            "A column without such a run stays as it was. Nothing in it is known to be field: it becomes all 0.",
        ),
        Mistake(
            "one more",
            _erased(more=1),
            "A run of exactly `run` green pixels is enough. You ask for one more.",
        ),
        Mistake("one fewer", _erased(more=-1), "You stop one green pixel too early: it takes `run` of them."),
        Mistake(
            "the first green",
            _erase_to_green,
            "You stop at the first green pixel. It takes `run` of them, one after the other.",
        ),
        Mistake(
            "the last run",
            _erased(the_last=True),
            "You take the last run of a column. The field begins at the first one from the top.",
        ),
        Mistake(
            "seven whatever run is",
            _erased(always=7),
            "You look for 7 green pixels, whatever `run` is.",
        ),
        Mistake(
            "to the end of the run",
            lambda labels, run=7: _erase(labels, run, lower=run - 1),
            "You erase to the end of the run, where you know of it. It began run - 1 rows higher, and all of it stays.",
        ),
        Mistake(
            "a row too high",
            _erased(lower=-1),
            "You erase one row too few: a run whose last pixel is in row v begins in row v - run + 1.",
        ),
        Mistake(
            "not in the last row",
            _erased(rim=True),
            "You miss a run that ends in the last row: it begins in row H - run, and range(H - run) ends before that.",
        ),
        Mistake(
            "rolled",
            _erase_rolled,
            "np.roll brings the top rows back below the last one, so that a run goes on there. Below the picture nothing is green.",
        ),
        Mistake(
            "any colour",
            _erased(any_colour=True),
            "You count every label but 0. Only green, label 1, is carpet: a white wall is no run.",
        ),
        Mistake(
            "painted green", _erased(paint=GREEN), "What you erase becomes green. It has to become 0, other."
        ),
        Mistake(
            "all but white",
            _erase_all_but_white,
            "Below the run, labels stay as they are. You remove green and yellow there; that is the next step's work.",
        ),
        Mistake(
            "a mask",
            _erase_mask,
            "That is true and false. Labels are wanted: 0, 1, 2 and 3 where they are kept.",
        ),
    ],
    alternatives={
        "a loop over columns": lambda labels, run=7: _erase(labels, run),
        "cumulative sums": _erase_sums,
        "sliding windows": _erase_window,
        "erosion": _erase_morphology,
    },
)


# --- 3.3 hough_segments ---


def _hough(picture: Any, gap: float, length: float, /, **changed: Any) -> Array:
    """Canny and Hough, with one thing done in another way."""
    image = np.asarray(picture)
    edges = image if changed.get("no_canny") else cv2.Canny(image, *changed.get("canny", (50, 150)))
    found = cv2.HoughLinesP(
        edges,
        1,
        changed.get("theta", np.pi / 180),
        changed.get("votes", 20),
        minLineLength=changed.get("length", length),
        maxLineGap=changed.get("gap", gap),
    )
    return np.zeros((0, 4)) if found is None else np.asarray(found, dtype=float).reshape(-1, 4)


def _found(change: Any = lambda found: found, **changed: Any) -> Any:
    return lambda line_picture, max_line_gap=5, min_line_length=40: change(
        _hough(line_picture, max_line_gap, min_line_length, **changed)
    )


def _swapped_gap(line_picture: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    return _hough(line_picture, min_line_length, max_line_gap)


def _none(line_picture: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Any:
    found = _hough(line_picture, max_line_gap, min_line_length)
    return found if len(found) else None


def _no_shape(line_picture: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    found = _hough(line_picture, max_line_gap, min_line_length)
    return found if len(found) else np.array([])


def _infinite_lines(line_picture: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    found = cv2.HoughLines(cv2.Canny(np.asarray(line_picture), 50, 150), 1, np.pi / 180, 20)
    return np.zeros((0, 2)) if found is None else np.asarray(found, dtype=float)[..., :2].reshape(-1, 2)


def _reshaped_none(line_picture: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    """What comes back is taken for an array, always."""
    edges = cv2.Canny(np.asarray(line_picture), 50, 150)
    found: Any = cv2.HoughLinesP(
        edges, 1, np.pi / 180, 20, minLineLength=min_line_length, maxLineGap=max_line_gap
    )
    return np.asarray(found.reshape(-1, 4), dtype=float)


def _by_position(line_picture: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Any:
    """Six arguments by position: the fifth is where OpenCV would put the lines."""
    edges: Any = cv2.Canny(np.asarray(line_picture), 50, 150)
    search: Any = cv2.HoughLinesP
    found = search(edges, 1, np.pi / 180, 20, min_line_length, max_line_gap)
    return np.zeros((0, 4)) if found is None else np.asarray(found, dtype=float).reshape(-1, 4)


def _first_column_always(line_picture: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Any:
    return _none(line_picture, max_line_gap, min_line_length)[:, 0]


def _as_in_tutorials(line_picture: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    """As OpenCV 4 gave it, (N, 1, 4)."""
    found = _hough(line_picture, max_line_gap, min_line_length)
    return np.array([tuple(line[0]) for line in found.tolist()])


def _as_in_tutorials_always(line_picture: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    found: Any = _none(line_picture, max_line_gap, min_line_length)
    return np.array([tuple(line[0]) for line in found.tolist()] if len(found) else [])


def _hough_public() -> list[Case]:
    corner = drawn([(6, 10, 58, 14), (32, 12, 22, 44)], 7)
    gaps = drawn([(3, 12, 29, 12), (42, 12, 61, 12), (5, 34, 22, 34), (28, 34, 60, 34)], 7)
    return [
        Case((corner, 3, 15), "two lines that meet"),
        Case((gaps, 3, 15), "lines with gaps, a largest gap of 3"),
        Case((gaps, 24, 15), "the same, a largest gap of 24"),
        Case((drawn([(4, 8, 60, 40)], 8), 3, 30), "a wide diagonal line"),
        Case(
            (drawn([(4, 10, 60, 10), (20, 30, 38, 30)], 6), 3, 30),
            "a long and a short line, at least 30 long",
        ),
        Case((np.zeros(SIZE, dtype=np.uint8), 5, 40), "no line at all"),
        Case((drawn([(30, 20, 34, 20)], 3), 5, 15), "a spot, and no line"),
        Case((drawn([(20, 20, 36, 20)], 3), 5, 10), "a line of 17 px, too short for 20 votes"),
        *(Case((picture,), f"the default {name}") for name, picture in _at_defaults_of_hough().items()),
    ]


def _at_defaults_of_hough() -> dict[str, Array]:
    """Pictures in which a pixel more or less of a default would be seen."""
    return {
        "length, a line too short": drawn([(10, 20, 47, 20)]),
        "length, a line just long enough": drawn([(10, 20, 48, 20)]),
        "gap, pieces that are joined": drawn([(0, 14, 29, 14), (37, 14, 61, 14)], 3),
        "gap, pieces too far apart": drawn([(0, 14, 29, 14), (36, 14, 61, 14)], 1),
    }


def _hough_hidden(rng: np.random.Generator) -> list[Case]:
    def lines(shape: tuple[int, int], number: int) -> list[tuple[float, float, float, float]]:
        height, width = shape
        rows = np.linspace(0.15, 0.85, number) * height
        return [(0.1 * width, v, 0.9 * width, v + rng.uniform(-0.06, 0.06) * height) for v in rows]

    large = (240, 320)
    broken = drawn([(20, 60, 120, 60), (150, 60, 300, 60), (30, 160, 90, 160), (98, 160, 280, 160)], 8, large)
    return [
        Case((drawn(lines(large, 3), int(rng.integers(7, 11)), large), 5, 40)),
        Case((drawn(lines((120, 200), 2), 7, (120, 200)), 4, 30)),
        Case((drawn([(v, u, w, z) for u, v, w, z in lines((320, 240), 3)], 8, large), 5, 50)),
        Case((broken, 4, 30)),
        Case((broken, 40, 30)),
        Case((drawn([(40, 60, 200, 70), (100, 150, 125, 150)], 8, large), 5, 60)),
        Case((np.zeros((int(rng.integers(20, 60)), 50), dtype=np.uint8), 5, 40)),
        Case((drawn([(30, 20, 34, 20)], 3), 5, 15)),
        *(Case((drawn([(20, 20, 20 + length, 20)], 3), 5, 10)) for length in (15, 16, 22)),
        *(Case((np.pad(picture, ((0, 9), (0, 0))),)) for picture in _at_defaults_of_hough().values()),
    ]


HOUGH_SEGMENTS = Exercise(
    name="hough_segments",
    points=2,
    stars=2,
    public=_hough_public,
    hidden=_hough_hidden,
    comparison=Segments(),
    hints=(
        "Two calls of OpenCV, with the numbers that the docstring says. Give minLineLength and maxLineGap by their names: the fifth argument by "
        "position is something else. Look at what comes back before you return it.",
        "cv2.HoughLinesP(edges, 1, np.pi / 180, 20, minLineLength=..., maxLineGap=...) returns None where there is no line: that is np.zeros((0, 4)). "
        "Otherwise found.reshape(-1, 4) has the right shape in every version.",
    ),
    mistakes=[
        Mistake(
            "no Canny",
            _found(no_canny=True),
            "Your segments run through the inside of the lines: HoughLinesP got the lines themselves. It wants their edges, from cv2.Canny.",
        ),
        Mistake(
            "gap and length swapped",
            _swapped_gap,
            "The largest gap and the least length have changed places. Give them by name: minLineLength=..., maxLineGap=...",
        ),
        Mistake(
            "theta of one",
            _found(theta=1.0),
            "Only a few directions are found: the step of the angle is in radians. One degree is np.pi / 180.",
        ),
        Mistake(
            "the gap not used",
            _found(gap=0),
            "max_line_gap does not reach HoughLinesP: pieces with a gap stay apart that it should join.",
        ),
        Mistake(
            "the length not used",
            _found(length=0),
            "min_line_length does not reach HoughLinesP: there are segments that are too short.",
        ),
        Mistake(
            "endless lines",
            _infinite_lines,
            "That is what HoughLines returns: a distance and an angle for each endless line. HoughLinesP, with P, returns segments.",
        ),
        Mistake(
            "None",
            _none,
            "Where there is no line, HoughLinesP returns None. Return an array of shape (0, 4) there.",
        ),
        Mistake(
            "None reshaped",
            _reshaped_none,
            "Where there is no line, HoughLinesP returns None, and None has no reshape: ask for it first, and return np.zeros((0, 4)) there.",
        ),
        Mistake(
            "by position",
            _by_position,
            "By position the fifth argument of HoughLinesP is not the length: give it by name, minLineLength=..., and maxLineGap=... too.",
        ),
        Mistake(
            "no shape",
            _no_shape,
            "Right, except where there is no line: np.array([]) has shape (0,). It is np.zeros((0, 4)).",
        ),
        Mistake(
            "(N, 1, 4)",
            _found(lambda found: found[:, None]),
            "The shape is (N, 1, 4), as some versions of OpenCV give it. reshape(-1, 4) makes it (N, 4) in all of them.",
        ),
        Mistake(
            "(row, column)",
            _found(lambda found: found[:, [1, 0, 3, 2]]),
            "Your segments are (v1, u1, v2, u2). OpenCV's order is the course's: (u1, v1, u2, v2), columns first.",
        ),
        Mistake(
            "the first column",
            _found(lambda found: found[:, 0] if len(found) else found),
            "Tutorials take [:, 0], for OpenCV 4 gives (N, 1, 4). Here it is (N, 4) already, and [:, 0] leaves one number of each segment.",
        ),
        Mistake(
            "the first column, always",
            _first_column_always,
            "[:, 0] is for OpenCV 4, which gives (N, 1, 4). Here it is (N, 4) already, or None where there is no line: ask for that first.",
        ),
        Mistake(
            "the first number",
            _as_in_tutorials,
            "Tutorials take line[0], for OpenCV 4 gives (N, 1, 4). Here a line is its four numbers already.",
        ),
        Mistake(
            "the first number, always",
            _as_in_tutorials_always,
            "line[0] is for OpenCV 4. Here a line is its four numbers already; and where there is no line, HoughLinesP returns None, which has no items.",
        ),
        Mistake(
            "too few votes",
            _found(votes=10),
            "Your segments need fewer votes than 20: that is HoughLinesP's fourth argument.",
        ),
        Mistake(
            "the first only",
            _found(lambda found: found[:1]),
            "You return one segment. All of them are wanted, (N, 4).",
        ),
    ],
    alternatives={
        "other limits of Canny": _found(canny=(100, 200)),
        "whole numbers, both ends exchanged": _found(lambda found: found.astype(int)[:, [2, 3, 0, 1]]),
        "the longest first": _found(
            lambda found: found[np.argsort(-np.hypot(found[:, 2] - found[:, 0], found[:, 3] - found[:, 1]))]
        ),
    },
    equivalents={
        "edges = cv2.Canny(line_picture, 51, 150)": "Canny on white and black marks the same pixels with any limits between its gradients",
        "edges = cv2.Canny(line_picture, 49, 150)": "Canny on white and black marks the same pixels with any limits between its gradients",
        "edges = cv2.Canny(line_picture, 50, 151)": "Canny on white and black marks the same pixels with any limits between its gradients",
        "edges = cv2.Canny(line_picture, 50, 149)": "Canny on white and black marks the same pixels with any limits between its gradients",
        "if False:": "a black picture gives None by HoughLinesP, too; only a picture without any pixel needs the first line",
        "pass": "the same: a black picture gives None by HoughLinesP, too",
        "return np.ones((0, 4))": "an array without rows has no ones and no zeros",
        "return np.ones((0, 4)) if found is None else found.reshape(len(found), 4).astype(float)": "an array without rows has no ones and no zeros",
        "return np.zeros((0, 4)) if found is None else found.reshape(len(found), 4)": "whole numbers are right as well",
        "return np.zeros((0, 4)) if found is None else found.astype(float)": "OpenCV 5 gives (N, 4) at once; only older versions need the new shape",
    },
)


# --- 3.4 segment_intersection ---

PARALLEL = float(np.sin(np.radians(10.0)))


def _meet(first: Any, second: Any, reach: float, **changed: Any) -> Any:
    """Where two segments meet, with one thing done in another way."""
    a, b = (np.array(each, dtype=float) for each in (first, second))
    p, q, d, e = a[:2], b[:2], a[2:] - a[:2], b[2:] - b[:2]
    length = changed.get("length", np.hypot)
    n, m = float(length(*d)), float(length(*e))
    cross = d[0] * e[1] - d[1] * e[0]
    apart = changed["apart"](d, e) if "apart" in changed else abs(cross) / (n * m)
    if apart < changed.get("parallel", PARALLEL) or cross == 0:
        return changed.get("nothing")
    w = q - p
    t, s = (
        (w[0] * e[1] - w[1] * e[0]) / cross * n,
        (w[0] * d[1] - w[1] * d[0]) / cross * m,
    )  # px from the starts
    s = -s if changed.get("minus") else s
    before, after = changed.get("before", reach), changed.get("after", reach)
    if changed.get("one_length"):
        changed = {**changed, "second": before * m / n}
    if changed.get("parts"):  # reach taken as a part of the length
        t, s, n, m = t / n, s / m, 1.0, 1.0
    near_first = -before <= t <= n + after or changed.get("unbounded")
    near_second = -changed.get("second", before) <= s <= m + changed.get("second", after)
    if not near_first or not (near_second or changed.get("unbounded") or changed.get("first_only")):
        return changed.get("nothing")
    x = p + (t / n if not changed.get("parts") else t) * d
    return x[::-1] if changed.get("swapped") else changed.get("wrap", lambda point: point)(x)


def _meeting(**changed: Any) -> Any:
    return lambda first, second, reach=5.0: _meet(first, second, reach, **changed)


def _cosine(d: Array, e: Array) -> float:
    """The sine's place is taken by 1 where the angle is between 10 and 350 degrees, by 0 elsewhere."""
    return float(d @ e <= np.cos(np.radians(10.0)) * np.hypot(*d) * np.hypot(*e))


def _slope_angles(d: Array, e: Array) -> float:
    """As above, by the angles of both slopes."""
    with np.errstate(all="ignore"):
        angles = [float(np.degrees(np.arctan(np.float64(each[1]) / np.float64(each[0])))) for each in (d, e)]
    return float(abs(angles[0] - angles[1]) >= 10.0)


def _signed(d: Array, e: Array) -> float:
    return float((d[0] * e[1] - d[1] * e[0]) / (np.hypot(*d) * np.hypot(*e)))


def _divided(first: Any, second: Any, reach: float = 5.0) -> Any:
    """Plain numbers, and the question for parallel segments after the division."""
    (u1, v1, u2, v2), (u3, v3, u4, v4) = (np.asarray(each, float).tolist() for each in (first, second))
    t = ((u3 - u1) * (v4 - v3) - (v3 - v1) * (u4 - u3)) / ((u2 - u1) * (v4 - v3) - (v2 - v1) * (u4 - u3))
    return None if np.isinf(t) else _meet(first, second, reach)


def _meet_slopes(first: Any, second: Any, reach: float = 5.0) -> Any:
    """With v = m u + b: upright segments have no slope."""
    (u1, v1, u2, v2), (u3, v3, u4, v4) = np.asarray(first, float), np.asarray(second, float)
    with np.errstate(all="ignore"):
        m1, m2 = (v2 - v1) / (u2 - u1), (v4 - v3) / (u4 - u3)
        u = (v3 - m2 * u3 - v1 + m1 * u1) / (m1 - m2)
        point = np.array([u, v1 + m1 * (u - u1)])
    wanted = _meet(first, second, reach)
    return None if wanted is None else point


def _meet_box(first: Any, second: Any, reach: float = 5.0) -> Any:
    """Inside both boxes around the segments, each `reach` wider."""
    point = _meet(first, second, reach, unbounded=True)
    if point is None:
        return None
    for each in (first, second):
        ends = np.asarray(each, float).reshape(2, 2)
        if (point < ends.min(axis=0) - reach).any() or (point > ends.max(axis=0) + reach).any():
            return None
    return point


def _meet_solved(first: Any, second: Any, reach: float = 5.0) -> Any:
    """With a linear system of the two parameters."""
    a, b = (np.asarray(each, dtype=float).reshape(2, 2) for each in (first, second))
    matrix = np.column_stack([a[1] - a[0], b[0] - b[1]])
    lengths = np.linalg.norm(matrix, axis=0)
    if abs(np.linalg.det(matrix / np.maximum(lengths, 1e-12))) < PARALLEL:
        return None
    along = np.linalg.solve(matrix, b[0] - a[0])
    inside = np.all(np.abs(along - 0.5) * lengths <= lengths / 2 + reach)
    return tuple((a[0] + along[0] * (a[1] - a[0])).tolist()) if inside else None


def _meet_homogeneous(first: Any, second: Any, reach: float = 5.0) -> Any:
    """Lines and points of the projective plane: both are cross products."""
    a, b = (np.column_stack([np.asarray(each, float).reshape(2, 2), np.ones(2)]) for each in (first, second))
    line_a, line_b = np.cross(a[0], a[1]), np.cross(b[0], b[1])
    x, y, w = np.cross(line_a, line_b)
    if abs(w) < PARALLEL * np.hypot(*line_a[:2]) * np.hypot(*line_b[:2]) or w == 0:
        return None
    point = np.array([x / w, y / w])
    for ends in (a[:, :2], b[:, :2]):
        way = np.diff(ends, axis=0)[0] / np.linalg.norm(np.diff(ends, axis=0))
        start, end, here = ends[0] @ way, ends[1] @ way, point @ way
        if not start - reach <= here <= end + reach:
            return None
    return point


def _meet_extended(first: Any, second: Any, reach: float = 5.0) -> Any:
    """Make both longer first, then cut them without a reach."""
    longer = []
    for each in (first, second):
        ends = np.asarray(each, float).reshape(2, 2)
        step = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0]) * reach
        longer.append(np.concatenate([ends[0] - step, ends[1] + step]))
    return _meet(*longer, 0.0)


def segment(*numbers: float) -> Array:
    return np.array(numbers, dtype=float)


def _meet_public() -> list[Case]:
    level = segment(10, 20, 50, 20)
    return [
        Case((level, segment(30, 5, 30, 40), 5.0), "a level and an upright segment that cross"),
        Case((segment(0, 0, 40, 30), segment(0, 24, 36, 0), 5.0), "two slanted segments that cross"),
        Case((level, segment(53, 23, 53, 60), 5.0), "ends 3 px short of each other"),
        Case((segment(50, 20, 10, 20), segment(7, 60, 7, 24), 5.0), "starts and ends exchanged"),
        Case((level, segment(30, 32, 30, 60), 5.0), "the second ends 12 px before the first"),
        Case((segment(30, 32, 30, 60), level, 5.0), "the same, in the other order"),
        Case((segment(30, 32, 30, 60), level, 15.0), "the same, with a reach of 15"),
        Case((level, segment(30, 24, 30, 60), 0.0), "without any reach"),
        Case((segment(10, 20, 15, 20), segment(28, 10, 28, 30), 8.0), "a short segment, too far away"),
        Case((level, segment(12, 26, 48, 26), 5.0), "parallel segments"),
        Case((level, segment(10, 18, 50, 22), 5.0), "segments that cross at 6 degrees"),
        Case((segment(10, 10, 40, 40), segment(43, 46, 70, 80), 5.0), "slanted, at 7 degrees"),
        Case(
            (level, segment(52, 27, 40, 50), 5.0),
            "the crossing lies 2 px beyond the end, but 8 px beyond the other",
        ),
        Case((segment(0, 0, 30, 30), segment(34, 26, 60, 0), 5.0), "slanted, 5.7 px short"),
        Case((segment(0, 0, 30, 30), segment(34.5, 34.5, 60, 9), 5.0), "slanted, 6.4 px short"),
        Case((level, segment(54.5, 2, 54.5, 40)), "4.5 px short, with the default reach"),
        Case((level, segment(55.5, 2, 55.5, 40)), "5.5 px short, with the default reach"),
        Case((level, segment(10, 16.7, 50, 23.3)), "at 9.4 degrees"),
        Case((level, segment(10, 16.3, 50, 23.7)), "at 10.5 degrees"),
        Case((level, segment(50, 22, 10, 18)), "at 6 degrees, in the opposite direction"),
        Case((segment(29, 0, 31, 40), segment(31, 0, 29, 40)), "two upright ones at 6 degrees"),
        Case((level, segment(30, 24, 30, 34)), "a long and a short segment, 4 px apart"),
        Case((level, segment(58, 16, 58, 26)), "8 px beyond the long segment's end"),
        Case((segment(0, 0, 30, 30), segment(33, 10, 33, 60)), "4.2 px beyond a slanted segment's end"),
    ]


def _meet_hidden(rng: np.random.Generator) -> list[Case]:
    cases: list[Case] = []
    while len(cases) < 40:
        meeting, angles = rng.uniform(20, 200, 2), rng.uniform(0, 2 * np.pi, 2)
        if min(abs(abs(np.sin(angles[0] - angles[1])) - PARALLEL), 1) < 0.03:
            continue
        ends = []
        for angle in angles:
            start = rng.choice([-60.0, -20.0, 2.0, 4.0, 8.0, 12.0])
            way = np.stack([np.cos(angle), np.sin(angle)])
            ends.append(
                np.concatenate([meeting + start * way, meeting + (start + rng.uniform(24, 90)) * way])
            )
            if rng.random() < 0.5:
                ends[-1] = ends[-1][[2, 3, 0, 1]]
        cases.append(Case((ends[0], ends[1], float(rng.choice([0.0, 3.0, 5.0, 10.0])))))
    u, v = rng.integers(20, 80, 2).astype(float)
    flat = segment(u, v, u + 60, v)
    return [
        *cases,
        *(Case((flat, segment(u + 60 + beyond, v - 20, u + 60 + beyond, v + 30))) for beyond in (4.5, 5.5)),
        *(Case((flat, segment(u, v - up, u + 60, v + up))) for up in (4.95, 5.55)),  # at 9.4 and 10.5 degrees
        Case((segment(5, 5, 5, 40), segment(9, 5, 9, 40), 5.0)),
        Case((flat, segment(u + 60, v + 3, u, v - 3))),
        Case((segment(u - 1, v, u + 2, v + 60), segment(u + 2, v, u - 1, v + 60))),
        *(Case((flat, segment(u + 30, v + short, u + 30, v + short + 12), 7.0)) for short in (6, 8)),
        *(Case((flat, segment(u + 60 + far, v - 5, u + 60 + far, v + 6), 7.0)) for far in (6, 10)),
        *(Case((segment(u, v, u + 30, v + 30), segment(u + k, v - 9, u + k, v + 90))) for k in (33.3, 33.8)),
        Case((segment(u, v - 20, u, v + 30), segment(u - 25, v, u + 18, v + 6), 5.0)),
        Case((segment(u - 25, v, u + 18, v + 6), segment(u, v + 30, u, v - 20), 0.0)),
    ]


SEGMENT_INTERSECTION = Exercise(
    name="segment_intersection",
    points=4,
    stars=2,
    public=_meet_public,
    hidden=_meet_hidden,
    comparison=Close(rtol=0.0, atol=1e-3),
    hints=(
        "Equation 3.3 has t, the part along the first segment; the second has its own, s, with the same denominator. Compute that first: it says whether they "
        "are parallel. Its size is both lengths times the sine of the angle between them.",
        "A parameter runs from 0 to 1 along its segment. With reach pixels more at each end it runs from -reach / length to 1 + reach / length, "
        "and each segment has its own length. Both have to hold.",
    ),
    mistakes=[
        Mistake(
            "unbounded lines",
            _meeting(unbounded=True),
            "You cut endless lines. A crossing counts only where it lies on both segments, or at most reach pixels beyond an end.",
        ),
        Mistake(
            "one extended",
            _meeting(second=0.0),
            "Only the first segment is extended. Both are, by reach pixels at both ends.",
        ),
        Mistake(
            "only the first tested",
            _meeting(first_only=True),
            "You test the first segment only: the crossing may lie far beyond the second one's end.",
        ),
        Mistake(
            "no reach",
            _meeting(before=0.0, after=0.0),
            "The segments are made longer by too little, or not at all. It has to be reach pixels at each end.",
        ),
        Mistake(
            "five whatever reach is", _meeting(before=5.0, after=5.0), "You use 5 pixels, whatever reach is."
        ),
        Mistake(
            "the other sign of s",
            _meeting(minus=True),
            "You miss crossings that are there, as with an s of the wrong sign. Put the numbers of the text into yours: it must be -0.081.",
        ),
        Mistake(
            "one length for both",
            _meeting(one_length=True),
            "reach pixels are another part of each segment's length. You divide by the same length for both.",
        ),
        Mistake(
            "the length as a sum",
            _meeting(length=lambda u, v: abs(u) + abs(v), apart=lambda d, e: abs(_signed(d, e))),
            "A segment's length is np.hypot of its differences, not their sum.",
        ),
        Mistake(
            "opposite directions",
            _meeting(apart=_cosine, parallel=0.5),
            "Segments in opposite directions are parallel as well: the angle between them is near 180 degrees. Hough returns both directions.",
        ),
        Mistake(
            "angles of slopes",
            _meeting(apart=_slope_angles, parallel=0.5),
            "Two upright segments that lean to different sides have angles near 90 and -90 degrees. Their difference is near 180, and they are parallel.",
        ),
        Mistake(
            "the sign of the denominator",
            _meeting(apart=_signed),
            "D x E is negative where the second segment turns the other way. They are parallel where its absolute value is small.",
        ),
        Mistake(
            "one end only",
            _meeting(before=0.0),
            "You extend the segments at their ends, but not at their starts.",
        ),
        Mistake(
            "reach as a part",
            _meeting(parts=True),
            "You compare reach with the parameter, which is a part of the length. reach is in pixels: divide it by the length.",
        ),
        Mistake(
            "parallel by chance",
            _meeting(parallel=0.0),
            "Segments that are less than 10 degrees apart count as parallel: they are mostly both edges of one line. Return None.",
        ),
        Mistake(
            "divided by zero",
            _divided,
            "You divide before you ask whether the segments are parallel: then the denominator is 0. Ask first, and return None.",
        ),
        Mistake(
            "NaN for nothing",
            _meeting(nothing=np.array([np.nan, np.nan])),
            "Where there is no crossing, return None, not NaN.",
        ),
        Mistake(
            "an empty array",
            _meeting(nothing=np.zeros((0, 2))),
            "Where there is no crossing, return None, not an empty array.",
        ),
        Mistake(
            "(row, column)",
            _meeting(swapped=True),
            "Your point is (v, u). A point is (u, v): the column first.",
        ),
        Mistake(
            "slopes",
            _meet_slopes,
            "An upright segment has no slope: v = m u + b divides by zero there. Use the segments' directions, as equation 3.3 does.",
        ),
        Mistake(
            "boxes",
            _meet_box,
            "You test whether the crossing lies in a box around each segment, reach wider. A slanted segment is extended along itself, "
            "by reach pixels in its own direction.",
        ),
        Mistake(
            "whole pixels",
            _meeting(wrap=np.round),
            "Your point is rounded. Crossings lie between pixels: keep the fractions.",
        ),
        Mistake(
            "shape (1, 2)",
            _meeting(wrap=lambda point: point[None]),
            "The shape is (1, 2). One point has shape (2,).",
        ),
    ],
    alternatives={
        "a linear system": _meet_solved,
        "cross products of the projective plane": _meet_homogeneous,
        "both made longer first": _meet_extended,
    },
    equivalents={
        "if abs(across) < np.sin(np.radians(10)) * n * m:": "segments exactly 10 degrees apart: rounding decides",
        "on_both = -reach < t * n <= n + reach and -reach <= s * m <= m + reach": "a crossing exactly at the end of the reach: rounding decides",
        "on_both = -reach <= t * n < n + reach and -reach <= s * m <= m + reach": "a crossing exactly at the end of the reach: rounding decides",
        "on_both = -reach <= t * n <= n + reach and -reach < s * m <= m + reach": "a crossing exactly at the end of the reach: rounding decides",
        "on_both = -reach <= t * n <= n + reach and -reach <= s * m < m + reach": "a crossing exactly at the end of the reach: rounding decides",
        "if abs(across) <= np.radians(10) * n * m:": "10 degrees or 10.05: nobody can ask for that",
    },
)


# --- 3.5 remove_doubles ---


def _kept(points: Any, radius: float, **changed: Any) -> Array:
    """The points that stay, with one thing done in another way."""
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    stay: list[Array] = []
    for i, point in enumerate(points):
        others = stay
        if changed.get("all_before"):
            others = list(points[:i])
        if changed.get("any_other"):
            others = [other for j, other in enumerate(points) if j != i]
        if changed.get("last"):
            others = stay[-1:]
        apart = [changed.get("distance", lambda d: np.hypot(*d))(point - other) for other in others]
        far = [a >= radius if changed.get("at_the_rim") else a > radius for a in apart]
        if not far or changed.get("enough", all)(far):
            stay.append(point)
    return np.array(stay).reshape(-1, 2)


def _doubles(change: Any = lambda kept: kept, **changed: Any) -> Any:
    return lambda points, radius: change(_kept(points, radius, **changed))


def _averaged(points: Any, radius: float) -> Array:
    """Each kept point becomes the mean of those near it."""
    points = np.asarray(points, dtype=float).reshape(-1, 2)
    means = [
        points[np.linalg.norm(points - kept, axis=1) <= radius].mean(axis=0) for kept in _kept(points, radius)
    ]
    return np.array(means).reshape(-1, 2)


def _last_kept(points: Any, radius: float) -> Array:
    return _kept(np.asarray(points, dtype=float)[::-1], radius)


def _no_shape_doubles(points: Any, radius: float) -> Array:
    kept = _kept(points, radius)
    return kept if len(kept) else np.array([])


def _doubles_matrix(points: Any, radius: float) -> Array:
    """A table of who is near whom, and one pass that crosses out."""
    points = np.asarray(points, dtype=float)
    near = np.linalg.norm(points[:, None] - points[None], axis=2) <= radius
    alive = np.ones(len(points), dtype=bool)
    for i in range(len(points)):
        if alive[i]:
            alive[i + 1 :] &= ~near[i, i + 1 :]
    return points[alive].astype(np.float32)


def _doubles_recursive(points: Any, radius: float) -> Any:
    """The first, and what is left of the rest without its neighbours."""
    points = np.asarray(points, dtype=float)
    if not len(points):
        return np.zeros((0, 2))
    rest = points[1:][((points[1:] - points[0]) ** 2).sum(axis=1) > radius**2]
    return np.vstack([points[:1], _doubles_recursive(rest, radius)])


def _doubles_complex(points: Any, radius: float) -> Array:
    """Points as complex numbers, taken from a list until it is empty."""
    left = [complex(u, v) for u, v in np.asarray(points, dtype=float)]
    stay = []
    while left:
        stay.append(left.pop(0))
        left = [point for point in left if abs(point - stay[-1]) > radius]
    return np.array([(point.real, point.imag) for point in stay]).reshape(-1, 2)


def _doubles_public() -> list[Case]:
    return [
        Case(
            (np.array([[10.0, 10.0], [16.0, 16.0], [40.0, 10.0]]), 10.0), "two near points and one far away"
        ),
        Case(
            (np.array([[10.0, 10.0], [18.0, 10.0], [26.0, 10.0], [34.0, 10.0]]), 10.0),
            "a chain, 8 px from one to the next",
        ),
        Case(
            (np.array([[10.0, 10.0], [40.0, 40.0], [12.0, 13.0], [43.0, 41.0]]), 10.0),
            "two corners, in turns",
        ),
        Case((np.array([[0.0, 0.0], [0.0, 10.0], [30.0, 0.0]]), 10.0), "exactly 10 px apart"),
        Case((np.array([[0.0, 0.0], [8.0, 8.0], [3.5, 0.0]]), 10.0), "8 px apart in both directions"),
        Case(
            (np.array([[18.0, 10.0], [10.0, 10.0], [26.0, 10.0]]), 10.0),
            "the middle one of three comes first",
        ),
        Case(
            (np.array([[5.25, 7.75], [60.0, 7.0], [60.0, 9.0], [60.0, 14.0]]), 4.0),
            "a radius of 4, with fractions",
        ),
        Case((np.zeros((0, 2)), 10.0), "no points"),
    ]


def _doubles_hidden(rng: np.random.Generator) -> list[Case]:
    cases = [
        Case((rng.uniform(0, 60, (int(rng.integers(10, 40)), 2)), float(radius))) for radius in (3, 6, 10, 15)
    ]
    chain = np.column_stack([np.arange(0.0, 90.0, 7.0), np.full(13, rng.uniform(0, 50))])
    return [
        *cases,
        Case((chain, 10.0)),
        Case((rng.permutation(chain), 15.0)),
        Case((np.array([[3.0, 4.0], [0.0, 0.0], [6.0, 8.0]]), 5.0)),
        Case((rng.uniform(0, 300, (1, 2)), 10.0)),
        Case((np.zeros((0, 2)), 10.0)),
    ]


REMOVE_DOUBLES = Exercise(
    name="remove_doubles",
    points=2,
    stars=2,
    public=_doubles_public,
    hidden=_doubles_hidden,
    comparison=Points(tolerance=0.05),
    hints=(
        "Begin with an empty list of kept points and go through all points in their order. When does a point join the list?",
        "A point joins where np.hypot(*(point - other)) > radius for every other in the list of kept ones, not for every point that came before. At the end, "
        "np.array(kept).reshape(-1, 2).",
    ),
    mistakes=[
        Mistake(
            "averaged",
            _averaged,
            "You average near points, as lesson 02 does. Here the first one of them stays as it is, and the others are deleted.",
        ),
        Mistake(
            "both deleted",
            _doubles(any_other=True),
            "Where two points are near each other you delete both. The first of them stays.",
        ),
        Mistake(
            "near a deleted one",
            _doubles(all_before=True),
            "You delete a point that is near one which is deleted itself. Compare with the kept points only.",
        ),
        Mistake(
            "only the last kept",
            _doubles(last=True),
            "You compare a point with the last kept one only. It may be near any of them.",
        ),
        Mistake(
            "the last stays",
            _last_kept,
            "Of near points the last one stays with you. It has to be the first.",
        ),
        Mistake(
            "sorted",
            lambda points, radius: _kept(sorted(np.asarray(points, dtype=float).tolist()), radius),
            "You sort the points first. They are taken in the order in which they come.",
        ),
        Mistake(
            "ten whatever radius is",
            lambda points, radius: _kept(points, 10.0),
            "You use 10 pixels, whatever radius is.",
        ),
        Mistake(
            "far from one of them",
            _doubles(enough=any),
            "You keep a point that is far from one of the kept ones. It has to be far from all of them.",
        ),
        Mistake(
            "squared distance",
            _doubles(distance=lambda d: (d**2).sum()),
            "You compare a squared distance with radius: take its square root, or the radius squared.",
        ),
        Mistake(
            "one direction at a time",
            _doubles(distance=lambda d: np.abs(d).max()),
            "You compare columns and rows apart, which is a square. What counts is the distance, np.hypot of both differences.",
        ),
        Mistake(
            "columns plus rows",
            _doubles(distance=lambda d: np.abs(d).sum()),
            "You add the differences of columns and rows. The distance is np.hypot of both.",
        ),
        Mistake(
            "at the rim",
            _doubles(at_the_rim=True),
            "A point exactly radius away is a double too: it stays only if it is farther away than that.",
        ),
        Mistake(
            "whole pixels",
            _doubles(np.round),
            "Your points are rounded. Points that stay are not changed at all.",
        ),
        Mistake(
            "no shape",
            _no_shape_doubles,
            "Right, except where there are no points: np.array([]) has shape (0,). Make it (0, 2) with .reshape(-1, 2).",
        ),
    ],
    alternatives={
        "a table of who is near whom": _doubles_matrix,
        "recursion": _doubles_recursive,
        "complex numbers": _doubles_complex,
    },
    equivalents={
        "if all((np.hypot(*other - point) > radius for other in kept)):": "a distance has no direction",
    },
)


# --- 3.6 find_corners ---


def _corners(labels: Any, gap: float, length: float, /, **changed: Any) -> Array:
    """The whole way, with one thing done in another way."""
    labels = np.asarray(labels)
    kept = labels if changed.get("no_erasing") else _erase(labels, changed.get("run", 7))
    white = np.isin(kept, (WHITE, YELLOW) if changed.get("yellow") else (WHITE,))
    segments = _hough(white.astype(np.uint8) * np.uint8(255), gap, length)
    if changed.get("ends"):
        return _kept(segments.reshape(-1, 2), 10.0)
    found = [_meet(a, b, 5.0, **changed.get("meet", {})) for a, b in combinations(segments, 2)]
    points = np.array([each for each in found if each is not None]).reshape(-1, 2)
    if not changed.get("outside"):
        points = points[((points >= 0) & (points < labels.shape[::-1])).all(axis=1)]
    return (
        points
        if changed.get("doubles")
        else changed.get("remove", _kept)(points, changed.get("radius", 10.0))
    )


def _cornered(change: Any = lambda points: points, **changed: Any) -> Any:
    return lambda labels, max_line_gap=5, min_line_length=40: change(
        _corners(labels, max_line_gap, min_line_length, **changed)
    )


def _swapped_values(labels: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    return _corners(labels, min_line_length, max_line_gap)


def _at_defaults(labels: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    return _corners(labels, 5, 40)


def _no_shape_corners(labels: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    found = _corners(labels, max_line_gap, min_line_length)
    return found if len(found) else np.array([])


def corner_scene(shape: Any, at: tuple[float, float], thickness: int, horizon: float = 0.15) -> Array:
    """Labels of a corner on carpet: a level line that ends at an upright one, towards the nearer side of the picture."""
    height, width = shape
    u, v = at
    end = 0.05 * width if u > width / 2 else 0.95 * width
    lines = [(u, v, end, v), (u, v, u, 0.97 * height)]  # level and upright: Hough does not break these
    return field(lines, round(horizon * height), thickness, shape)


def at_the_edge() -> dict[str, Array]:
    """Labels of two lines whose edges cross once, near the picture's edge or a little beyond it, by where that is."""
    return {
        "left of the picture": field([(-2, 40, 60, 29), (-2, 40, 60, 55)], 3, 1),
        "right of the picture": field([(66, 26, 3, 15), (66, 26, 3, 46)], 3, 1),
        "below the picture": field([(40, 51, 29, 12), (40, 51, 81, 12)], 3, 2),
        "in the leftmost pixel": field([(1, 39, 60, 31), (1, 39, 60, 52)], 3, 1),
    }


def _corners_at_defaults() -> list[Array]:
    """Labels in which a pixel more or less of a default would be seen."""
    lengths = [(41, 43, 51, 20, 5), (42, 37, 45, 22, 3), (42, 40, 44, 21, 5), (42, 39, 50, 23, 5)]
    found = [field([(u, v, u - n, v), (u, v, u, v + m)], 6, thick, (70, 64)) for n, m, u, v, thick in lengths]
    for gap, start, v, thick, u in (
        (5, 26, 23, 3, 59),
        (5, 30, 21, 5, 50),
        (6, 29, 16, 3, 55),
        (6, 28, 17, 5, 50),
    ):
        found.append(field([(u, v, 1, v), (u, v, u, 68)], 6, thick, (70, 64)))
        found[-1][v - 5 : v + 6, start : start + gap] = GREEN
    return found


def near_each_other() -> dict[str, Array]:
    """Labels of two corners, and of one whose crossings are far apart, by what they are."""
    return {
        "two corners": field([(5, 18, 58, 18), (14, 18, 14, 46), (50, 18, 50, 46)], 5, 3),
        "two corners 16 px apart": field([(5, 18, 58, 18), (24, 18, 24, 46), (40, 18, 40, 46)], 5, 1),
        "one corner of wide lines": corner_scene(SIZE, (44, 22), 6),
    }


def below_little_carpet() -> dict[str, Array]:
    """Labels of a corner that has so many rows of carpet above it, by what they are."""
    return {
        f"{rows} rows of carpet above a line": field([(5, 20, 50, 20), (50, 20, 50, 46)], 19 - rows, 3)
        for rows in (6, 8)
    }


def _none_kept(labels: Any, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    """The crossings that are none stand among the others."""
    labels = np.asarray(labels)
    white = (_erase(labels, 7) == WHITE).astype(np.uint8) * np.uint8(255)
    pairs = combinations(_hough(white, max_line_gap, min_line_length), 2)
    points: Any = [_meet(a, b, 5.0) for a, b in pairs]
    return _kept(np.array([[point[0], point[1]] for point in points]).reshape(-1, 2), 10.0)


def _corners_public() -> list[Case]:
    framed = field([], 34)
    framed[drawn([(10, 5, 56, 5), (10, 5, 10, 32)], 4) > 0] = WHITE
    yellow = corner_scene(SIZE, (44, 20), 4)
    yellow[yellow == WHITE] = YELLOW
    meeting = field([(4, 20, 60, 20), (40, 20, 40, 47)], 7, 4)
    broken = field([(4, 20, 26, 20), (38, 20, 60, 20), (48, 20, 48, 47)], 7, 4)
    return [
        Case((corner_scene(SIZE, (44, 20), 4), 5, 15), "one corner"),
        Case((field([(43, 12, 1, 12), (43, 12, 43, 60)], 2, 5, (64, 48)),), "one corner, by the defaults"),
        *(Case((labels, 5, 15), name) for name, labels in near_each_other().items()),
        *(Case((labels, 5, 15), name) for name, labels in below_little_carpet().items()),
        Case((framed, 5, 15), "a white frame on the wall"),
        Case((yellow, 5, 15), "a yellow corner"),
        Case((meeting, 5, 15), "a long and a short line that meet"),
        Case((meeting, 5, 35), "the same, with lines of 35 px at least"),
        Case((broken, 5, 28), "a broken line, lines of 28 px at least"),
        Case(
            (field([(4, 12, 60, 12), (40, 25, 40, 47)], 3, 3), 5, 15), "a line that ends 12 px below another"
        ),
        Case((field([(4, 22, 60, 22), (4, 40, 60, 40)], 10), 5, 20), "two parallel lines"),
        Case((field([], 14), 5, 15), "a field without lines"),
        *(Case((labels, 5, 15), f"a crossing {where}") for where, labels in at_the_edge().items()),
    ]


def _corners_hidden(rng: np.random.Generator) -> list[Case]:
    def place() -> tuple[float, float]:
        return float(rng.uniform(190, 260)), float(rng.uniform(75, 120))

    large = (240, 320)
    u, v = place()
    two = field([(20, v, 300, v), (u, v, u, 232), (u - 110, v, u - 116, 232)], 40, 5, large)
    yellow = corner_scene(large, place(), 5)
    yellow[170:178, 20:150] = YELLOW
    yellow[150:230, 60:66] = YELLOW
    framed = corner_scene(large, (u, 140.0), 5, horizon=0.45)
    framed[drawn([(40, 10, 40, 90), (40, 10, 200, 10)], 5, large) > 0] = WHITE
    broken = corner_scene(large, (u, v), 5)
    broken[round(v) - 12 : round(v) + 12, 100:112] = GREEN
    apart = field([(20, 70, 300, 74), (u, 100, u - 4, 230)], 40, 5, large)
    return [
        Case((corner_scene(large, place(), 5), 5, 40)),
        Case((framed, 5, 30)),
        Case((two, 5, 40)),
        Case((two, 5, 200)),
        Case((yellow, 5, 30)),
        Case((broken, 5, 145)),
        Case((broken, 25, 120)),
        Case((apart, 5, 40)),
        Case((field([(20, 90, 300, 94), (20, 180, 300, 184)], 50, 5, large), 5, 40)),
        Case((field([], int(rng.integers(20, 80)), 5, large), 5, 40)),
        *(Case((labels,)) for labels in _corners_at_defaults()),
        *(Case((labels, 5, 15)) for labels in at_the_edge().values()),
        *(
            Case((np.pad(labels, ((0, 5), (0, 0)), "edge"), 5, 15))
            for labels in (*near_each_other().values(), *below_little_carpet().values())
        ),
    ]


def _pairs(others: str, pair: str = "(first, second)") -> str:
    """The solution's line that pairs segments, with other ones for the second."""
    return f"pairs = [{pair} for i, first in enumerate(segments) for second in segments[{others}]]"


FIND_CORNERS = Exercise(
    name="find_corners",
    points=5,
    stars=3,
    uses=("line_picture", "erase_background", "hough_segments", "segment_intersection", "remove_doubles"),
    public=_corners_public,
    hidden=_corners_hidden,
    comparison=Points(tolerance=10.0),
    hints=(
        "The order of the paper: background away, lines only, segments, crossings of every two of them, doubles away. itertools.combinations(segments, 2) "
        "has every pair once.",
        "segment_intersection returns None for most pairs: keep the others. A crossing outside the picture, u below 0 or from W on, v below 0 or from H on, goes before the doubles "
        "do. Where nothing is left, np.array([]) needs .reshape(-1, 2).",
    ),
    mistakes=[
        Mistake(
            "background kept",
            _cornered(no_erasing=True),
            "You find corners on the wall. erase_background has to come first.",
        ),
        Mistake(
            "yellow too",
            _cornered(yellow=True),
            "You find a corner of something yellow. Only white, label 3, is a line.",
        ),
        Mistake(
            "doubles kept",
            _cornered(doubles=True),
            "There are several points at one corner: each line has two edges. remove_doubles takes them away.",
        ),
        Mistake(
            "nothing at all",
            lambda labels, max_line_gap=5, min_line_length=40: np.zeros((0, 2)),
            "No corner is found anywhere. Look at what each step hands on: the erased labels, their white as a picture, and how many segments that gives.",
        ),
        Mistake(
            "the first only",
            _cornered(lambda points: points[:1]),
            "You return one corner. All of them are wanted, (K, 2).",
        ),
        Mistake(
            "outside kept",
            _cornered(outside=True),
            "You keep crossings outside the picture: u is at least 0 and less than W, v at least 0 and less than H.",
        ),
        Mistake(
            "a shorter run",
            _cornered(run=3),
            "You erase less than a run of 7 does: lines are left that have hardly any carpet above them.",
        ),
        Mistake(
            "a longer run",
            _cornered(run=10),
            "You erase more than a run of 7 does: a line with 8 rows of carpet above it is gone.",
        ),
        Mistake(
            "a larger radius",
            _cornered(radius=20.0),
            "Two corners become one: doubles are nearer to each other than that, within 10 pixels.",
        ),
        Mistake(
            "a smaller radius",
            _cornered(radius=5.0),
            "Crossings of one corner's edges are left: doubles have a radius of 10 pixels.",
        ),
        Mistake(
            "ends of segments",
            _cornered(ends=True),
            "Your points are ends of segments. A corner is where two of them meet.",
        ),
        Mistake(
            "values not handed on",
            _at_defaults,
            "max_line_gap and min_line_length do not reach hough_segments: your answer does not depend on them.",
        ),
        Mistake(
            "gap and length swapped",
            _swapped_values,
            "max_line_gap and min_line_length have changed places on their way to hough_segments.",
        ),
        Mistake(
            "unbounded lines",
            _cornered(meet={"unbounded": True}),
            "Your segments are too long, or endless: a crossing farther than 5 pixels beyond an end is no corner.",
        ),
        Mistake(
            "None kept",
            _none_kept,
            "For most pairs segment_intersection returns None, and you use it as a point: leave those out where `point is not None` does not hold.",
        ),
        Mistake(
            "(row, column)",
            _cornered(lambda points: points[:, ::-1]),
            "Your points are (v, u). A point is (u, v): the column first.",
        ),
        Mistake(
            "no shape",
            _no_shape_corners,
            "Right, except where there is no corner: np.array([]) has shape (0,). Make it (0, 2) with .reshape(-1, 2).",
        ),
    ],
    alternatives={
        "by the declaration's own functions": lambda labels, max_line_gap=5, min_line_length=40: _corners(
            labels, max_line_gap, min_line_length
        ),
        "near points averaged": _cornered(remove=_averaged),
        "the last of near points": _cornered(remove=_last_kept),
    },
    equivalents={
        "inside = ((points >= 0) * (points < labels.shape[::-1])).all(axis=1)": "and, said as a product",
        "inside = ((points >= 0) // (points < labels.shape[::-1])).all(axis=1)": "and, by whole numbers: 1 // 1 alone is 1",
        "points = np.array([each for each in meetings if each is not None]).reshape(~1, 2)": "NumPy takes any negative number for the one that it computes",
        "points = np.array([each for each in meetings if each is not None]).reshape(-2, 2)": "NumPy takes any negative number for the one that it computes",
        "inside = ((points > 0) & (points < labels.shape[::-1])).all(axis=1)": "a crossing on the picture's very edge: rounding decides",
        "inside = ((points >= 0) & (points <= labels.shape[::-1])).all(axis=1)": "a crossing on the picture's very edge: rounding decides",
        "meetings = [segment_intersection(second, first) for first, second in pairs]": "both segments are treated alike",
        _pairs("i + 1:", "(second, first)"): "both segments are treated alike",
        **{
            _pairs(others): "a segment is parallel to itself, and what meets twice is a double"
            for others in (
                "i:",
                ":",
                "1:",
                *(f"i {sign} 1:" for sign in ("*", "//", "%", "**", ">>", "|", "&", "^")),
                "i + 0:",
            )
        },
        "return remove_doubles(points[inside], 11.0)": "which of several near crossings stays is left open",
    },
)


PLAN = LessonPlan(
    exercises=[
        LINE_PICTURE,
        ERASE_BACKGROUND,
        HOUGH_SEGMENTS,
        SEGMENT_INTERSECTION,
        REMOVE_DOUBLES,
        FIND_CORNERS,
    ],
    questions=[
        Question(
            "why_two_edges",
            "One white line, well in view, is drawn to HoughLinesP as Canny's edges. How many segments does it give at least?",
            {
                "One, along its middle.": "There is no edge along the middle: inside the line all pixels are alike. Canny marks where white begins and "
                "where it ends.",
                "Two, one along each side.": "White begins at one side and ends at the other, and both are edges. So a corner of two "
                "lines has up to four crossings, a line's width apart.",
                "None: a line is too wide for Hough.": "Hough counts edge pixels on straight lines. How far apart the two sides are does not matter to it.",
            },
            "Two, one along each side.",
        ),
        Question(
            "why_report_little",
            "A hit is worth -1.333, a false corner costs 5, a missed one 1. A detector finds points of which 60 % are right. Should it report them?",
            {
                "Yes: it is right more often than wrong.": "Of ten points, six turn a miss into a hit: 6 x 2.333 = 14.0 better. "
                "Four are false: 4 x 5 = 20 worse.",
                "No: a false corner costs more than a hit gains.": "A hit gains 2.333, for the miss is gone as well. A false one costs 5. It pays from a precision of "
                "5 / 7.333 on, that is 68 %.",
                "It makes no difference: the mean is what counts.": "The mean is a sum of these. Each report changes it by -2.333 or by 5.",
            },
            "No: a false corner costs more than a hit gains.",
        ),
        Question(
            "where_corners_go",
            "Your detector finds 14 of 61 corners. At which step are most of the others lost?",
            {
                "Labels: there is no white where the corner is.": "There is white within 3 pixels of all 61.",
                "Erasing: the corner goes with the background.": "12 go there. A later step takes twice as many.",
                "Segments: one of the two lines gives none.": "37 corners have a segment near by, and 12 of these have two that are not parallel. "
                "25 lack the second.",
                "Crossings: both segments are there, and end too early.": "Two segments that are not parallel pass near 12 corners only. Too few are "
                "left to be lost there.",
            },
            "Segments: one of the two lines gives none.",
        ),
    ],
    written=[
        Written(
            "explain_null_baseline",
            points=2,
            question="The paper's best setting has a mean cost of 2.122 over thirty pictures, whose number of corners it does not say. What follows from 2.122 alone "
            "about that detector, what does one need to know besides, and why?",
            rubric="1 point: from 2.122 alone nothing follows, for reporting nothing costs 1 for each corner, so as much as there are corners in a picture on average: with "
            "more than 2.122 corners a picture the detector is better than nothing, with fewer it is worse. 1 point: besides the cost of nothing on the same pictures "
            "one needs how sure the difference is: how much it varies from picture to picture, or its interval; with thirty pictures that can contain 0, as it does here. "
            "Naming hits and false corners instead of the interval is worth the second point too, if the answer says that a mean can hide how it comes about.",
        )
    ],
)
