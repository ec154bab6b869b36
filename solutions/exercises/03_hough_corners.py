"""Lesson 03, Hough corners: its exercises with their cases, common mistakes and alternative solutions."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.exercises import Case, Exact, Exercise, LessonPlan, Points, Question, Sibling, Written
from nao_course.instructor.authoring.mistakes import catalogue
from nao_course.lessons.hough_corners.segments import BytePicture, Crossing, Segments

Array = npt.NDArray[Any]
Lines = list[tuple[float, float, float, float]]
OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3
SIZE = (48, 64)  # rows and columns of public pictures


# --- labels and pictures for the cases ---
def columns(columns: str) -> Array:
    """Return labels from columns written from the top: o other, g green, y yellow, w white."""
    return np.array([["ogyw".index(letter) for letter in each] for each in columns.split()], dtype=np.uint8).T


def scattered(seed: int | np.random.Generator, rows: int, width: int) -> Array:
    """Return random labels in which each column consists of short runs; green is twice as likely as the others."""
    rng, labels = np.random.default_rng(seed), np.zeros((rows, width), dtype=np.uint8)
    for u in range(width):
        v = 0
        while v < rows:
            length = int(rng.integers(1, 11))
            labels[v : v + length, u] = rng.choice([OTHER, GREEN, GREEN, YELLOW, WHITE])
            v += length
    return labels


def drawn(lines: Lines, thickness: int = 5, shape: Any = SIZE) -> Array:
    """Return a picture of white lines on black."""
    picture = np.zeros(shape, dtype=np.uint8)
    for u1, v1, u2, v2 in lines:
        cv2.line(picture, (round(u1), round(v1)), (round(u2), round(v2)), 255, thickness)
    return picture


def field(lines: Lines, horizon: int, thickness: int = 5, shape: Any = SIZE) -> Array:
    """Return labels of white lines on carpet below a wall."""
    labels = np.full(shape, GREEN, dtype=np.uint8)
    labels[drawn(lines, thickness, shape) > 0] = WHITE
    labels[:horizon] = OTHER
    return labels


# --- 3.1 line_picture ---
LINE_PICTURE = Exercise(
    name="line_picture",
    points=1,
    public=lambda: [
        Case((columns("owgy wwoo ygow"),), "three columns of 4 pixels"),
        Case((field([(5, 20, 60, 26), (30, 24, 20, 46)], 14),), "lines on carpet below a wall"),
        Case((columns("oggy gyog"),), "nothing white"),
        Case((scattered(30, 40, 30),), "labels by chance"),
    ],
    hidden=lambda rng: [
        *(Case((scattered(rng, int(rng.integers(4, 60)), int(rng.integers(4, 60))),)) for _ in range(4)),
        Case((np.full((5, 7), WHITE, dtype=np.uint8),)),
        Case((np.full((6, 3), int(rng.choice([OTHER, GREEN, YELLOW])), dtype=np.uint8),)),
        Case((np.zeros((0, 4), dtype=np.uint8),)),
    ],
    comparison=BytePicture(),
    hints=(
        "labels == 3 is True where a pixel is white. How do you turn True into 255 and False into 0?",
        "np.where(condition, a, b) takes a where the condition holds and b elsewhere. Its result is int64 here, so convert it with .astype(np.uint8).",
    ),
    sibling=Sibling(
        "One of two numbers is chosen for each element, and the result gets the type that the next function needs.",
        """
        import numpy as np

        ages = np.array([[3, 40], [17, 5]])
        price = np.where(ages < 6, 0, 12).astype(np.int16)
        print(price, price.dtype)
        """,
        """
        [[ 0 12]
         [12  0]] int16
        """,
    ),
    mistakes=catalogue("""
        true and false: np.where(labels == 3, 255, 0).astype(np.uint8) => labels == 3
            You return True and False, but OpenCV needs a picture. Return 255 for white and 0 elsewhere, as np.uint8.
        ones: 255, 0 => 1, 0
            Your white pixels are 1, which is almost black. Use 255.
        the labels left: 255, 0 => labels, 0
            Your white pixels keep their label 3. Use 255 for them.
        other labels left: 255, 0 => 255, labels
            Green and yellow pixels keep their labels 1 and 2. Every pixel that is not white must be 0.
        eight bytes a pixel: .astype(np.uint8) =>
            The values are right, but their type is not. OpenCV needs one byte per pixel: end with .astype(np.uint8).
        floats: .astype(np.uint8) => .astype(float)
            The values are right, but their type is not: np.zeros makes floats unless you ask for another type, np.zeros(labels.shape, dtype=np.uint8).
        all black: 255, 0 => 0, 0
            Your picture is black. If you write 255 into `labels` itself, no pixel there has label 3 any more. Make a new array instead.
        black lines: 255, 0 => 0, 255
            Black and white are swapped. White labels become 255, and all others 0.
        yellow too: == 3 => >= 2
            Yellow (label 2) becomes 255 as well. The posts are yellow and are not lines, so keep label 3 only.
        all but green: == 3 => != 1
            Everything that is not green becomes 255. Only label 3 is white.
        all labels but 0: == 3 => > 0
            Green and yellow pixels become 255 as well. Only label 3 is white.
        labels multiplied: np.where(labels == 3, 255, 0) => (labels * 85)
            Green and yellow pixels become grey, because you multiply every label. Pixels that are not white must be 0.
        labels times 255: np.where(labels == 3, 255, 0) => (labels * 255)
            You multiply every label by 255. In uint8 the products overflow, so white becomes 253, and green and yellow do not become 0. Make a mask first: labels == 3.
        three channels: .astype(np.uint8) => .astype(np.uint8)[..., None].repeat(3, axis=2)
            Your picture has three numbers for each pixel. Return one, shape (H, W).
    """),
    alternatives={
        "a product": lambda labels: (labels == 3).astype(np.uint8) * np.uint8(255),
        "OpenCV": lambda labels: cv2.inRange(labels, 3, 3) if labels.size else labels,
        "a table": lambda labels: np.array([0, 0, 0, 255], dtype=np.uint8)[labels],
    },
    equivalents={"return np.where(labels >= 3, 255, 0).astype(np.uint8)": "no label is larger than 3"},
)


# --- 3.2 erase_background ---
def _erase_loop(labels: Array, run: int = 7) -> Array:
    kept = np.zeros_like(labels)
    for u, column in enumerate(labels.T):
        begins = (v for v in range(len(column) - run + 1) if (column[v : v + run] == GREEN).all())
        first = next(begins, len(column))
        kept[first:, u] = column[first:]
    return kept


def _erase_sums(labels: Array, run: int = 7) -> Array:
    """Count the green pixels above each row: a run begins where the count grows by `run` over the next `run` rows."""
    above = np.cumsum(np.pad(labels == GREEN, ((1, run - 1), (0, 0))), axis=0)
    begins = above[run:] - above[:-run] == run
    return labels * np.maximum.accumulate(begins, axis=0)


def _erase_morphology(labels: Array, run: int = 7) -> Array:
    """Compute the erosion of the green mask by a column of `run` pixels whose anchor is its top pixel."""
    green, element = (labels == GREEN).astype(np.uint8), np.ones((run, 1), np.uint8)
    safe = cv2.erode(green, element, anchor=(0, 0), borderType=cv2.BORDER_CONSTANT, borderValue=0)
    return np.where(np.cumsum(safe.reshape(labels.shape), axis=0), labels, 0)


ERASE_BACKGROUND = Exercise(
    name="erase_background",
    points=3,
    stars=2,
    public=lambda: [
        Case(
            (columns("owgggwyg ggoggoww wwwggggw gggwoogw oggowggo"), 3),
            "five columns of 8 pixels, a run of 3",
        ),
        Case((columns("oggwgggggggwgo ogggggggwwoggg oggggggwgggggw wgwgwgwgwgwggg"), 7), "runs of 7"),
        Case((columns("ooogggg gggowww wwwwwww"), 4), "a run that ends at the picture's edge"),
        Case((columns("ggwowwog gwowowgg wgggwggg"), 3), "green at both ends, a run of 3"),
        Case((field([(5, 20, 60, 26), (30, 24, 20, 46)], 14), 7), "lines on carpet below a wall"),
        Case((columns("ywgw gwgo"), 1), "a run of one pixel"),
        Case((columns("wggggggwggggggg gggggggwogggggg ggggggggwoggggg"),), "the default run"),
        Case((scattered(31, 40, 30), 6), "labels by chance"),
    ],
    hidden=lambda rng: [
        *(Case((scattered(rng, 60, 50), run)) for run in (1, 3, 5, 7, 9)),
        Case((scattered(rng, 240, 320), 7)),
        Case((scattered(rng, 80, 60),)),
        Case((scattered(rng, 5, 30), 7)),
        Case((np.pad(scattered(rng, 9, 40) % 3 // 2 * WHITE, ((3, 4), (0, 0)), constant_values=GREEN), 6)),
        Case((np.full((20, 15), int(rng.choice([OTHER, WHITE])), dtype=np.uint8), 7)),
        Case((np.full((20, int(rng.integers(5, 15))), GREEN, dtype=np.uint8), 7)),
    ],
    comparison=Exact(),
    hints=(
        "Go down one column and count its green pixels. Start the count again at any other pixel, and stop when it is `run`: which row is the first of this run? Everything above it must be 0.",
        "Without a loop over columns: let green be labels == 1. green[i:] is the picture moved up by i rows. A run of 3 begins where green, green moved up by 1 and green moved up by 2 are all True. Pad the bottom with rows of False, np.pad(green, ((0, run - 1), (0, 0))), so that all shifted copies have H rows. np.logical_or.accumulate(begins, axis=0) is True from the first True of each column downwards.",
    ),
    sibling=Sibling(
        "A run of equal elements is found by comparing the array with shifted copies of itself, and everything from its first element on is kept.",
        """
        import numpy as np

        celsius = np.array([31, 22, 33, 35, 31, 36, 24, 32])
        hot = celsius > 30
        wave = hot[:-2] & hot[1:-1] & hot[2:]  # three hot days, beginning here
        wave = np.append(wave, [False, False])  # as long as before
        begun = np.logical_or.accumulate(wave)
        print(np.where(begun, celsius, -1))
        """,
        "[-1 -1 33 35 31 36 24 32]",
    ),
    mistakes=catalogue("""
        seven in total: np.logical_and.reduce([green[i : i + height] for i in range(run)]) => np.cumsum(green, axis=0)[run - 1 : run - 1 + height] >= run
            You count all green pixels of a column. They must follow each other without a gap, so start the count again at every pixel that is not green.
        seven in total, to the last of them
            np.logical_and.reduce([green[i : i + height] for i in range(run)]) => np.cumsum(green, axis=0)[:height] >= run
            You count all green pixels of a column, and erase down to the pixel at which the count is complete. Start the count again at every pixel that is not green, and keep the whole run.
        seven in total, and column left alone
            np.logical_and.reduce([green[i : i + height] for i in range(run)]) => np.cumsum(green, axis=0)[:height] >= run
            accumulate(begins) => accumulate(begins) | ~begins.any(axis=0)
            Your code has two errors. It counts all green pixels of a column, but the count must start again at every pixel that is not green. And a column without a run keeps its labels, but must be erased.
        to the end of the run, and column left alone
            accumulate(begins) => accumulate(np.pad(begins, ((run - 1, 0), (0, 0)))[:height]) | ~begins.any(axis=0)
            Your code has two errors. It erases down to the last pixel of the run, but the run began run - 1 rows higher. And a column without a run keeps its labels, but must be erased.
        cut off at the bottom: ((0, run), (0, 0)) => ((0, run), (0, 0)), constant_values=True
            You accept a short run at the bottom of a column. Near the last row, labels[v : v + run, u] has fewer than `run` pixels, and .all() tests only these. A run can begin in row H - run at the latest.
        a search that returns -1: accumulate(begins) => accumulate(begins) | ~begins.any(axis=0) & (np.arange(height)[:, None] == height - 1)
            A column without a run keeps its last pixel. A search such as str.find returns -1 there, and -1 is the index of the last pixel. Erase the whole column.
        cut off, and column left alone: ((0, run), (0, 0)) => ((0, run), (0, 0)), constant_values=True
            accumulate(begins) => accumulate(begins) | ~begins.any(axis=0)
            Your code has two errors. Near the last row, labels[v : v + run, u] has fewer than `run` pixels, but a run can begin in row H - run at the latest. And a column without a run keeps its labels, but must be erased.
        only where runs begin: np.logical_or.accumulate(begins) => begins
            You keep only the pixels at which a run begins. Keep everything from the first of them downwards: np.logical_or.accumulate(begins, axis=0) is True there.
        erases below: np.logical_or.accumulate(begins), labels, 0 => np.logical_or.accumulate(begins) | ~begins.any(axis=0), 0, labels
            You erase the part below the start of the run. Row numbers grow downwards, so the part above has the smaller ones.
        from the bottom: + labels = labels[::-1]
            labels, 0) => labels, 0)[::-1]
            You scan each column from the bottom to the top. The background is above the field, so start at row 0.
        rows for columns: + labels = labels.T
            labels, 0) => labels, 0).T
            You scan along the rows. Scan down each column instead: labels[:, u].
        the run too: accumulate(begins) => accumulate(np.pad(begins, ((run, 0), (0, 0)))[:height])
            You erase the run as well. The run is carpet and belongs to the field: erase only what is above its first pixel.
        column left alone: accumulate(begins) => accumulate(begins) | ~begins.any(axis=0)
            A column without a run keeps its labels. No part of it is known to be field, so erase the whole column.
        one more: range(run) => range(run + 1)
            Your runs must have run + 1 green pixels. Exactly `run` of them are enough.
        one fewer
            [green[i : i + height] for i in range(run)] => [np.arange(height)[:, None] >= (labels[0] != 1), *(green[i : i + height] for i in range(run - 1))]
            You accept runs that are one green pixel too short. A run needs `run` of them.
        the first green: np.logical_or.accumulate(begins) => np.arange(height)[:, None] >= (labels == 1).argmax(axis=0)
            You stop at the first green pixel of a column. Stop where `run` green pixels follow each other.
        the first green pixel: np.logical_and.reduce([green[i : i + height] for i in range(run)]) => labels == 1
            You stop at the first green pixel of a column, and do not test whether `run` green pixels follow each other there.
        the last run, and column left alone: np.logical_or.accumulate(begins) => np.cumsum(begins, axis=0) == begins.sum(axis=0)
            Your code has two errors. It uses the last run of each column, but the field begins at the first run from the top. And a column without a run keeps its labels, but must be erased.
        the last run: np.logical_or.accumulate(begins) => np.cumsum(begins, axis=0) == np.maximum(begins.sum(axis=0), 1)
            You use the last run of each column. The field begins at the first run from the top.
        seven whatever run is: + run = 7
            You always look for 7 green pixels. Use the argument `run`.
        to the end of the run: accumulate(begins) => accumulate(np.pad(begins, ((run - 1, 0), (0, 0)))[:height])
            You erase down to the last pixel of the run. The run began run - 1 rows higher, and all of its pixels stay.
        rolled downwards: green[i : i + height] => np.roll(labels == 1, i, axis=0)
            np.roll with a positive shift moves the picture down, so you find the end of each run instead of its start. It also brings the bottom rows back at the top. Shift upwards, and fill the empty rows at the bottom with False.
        a row too high: np.logical_or.accumulate(begins) => begins.any(axis=0) & (np.arange(height)[:, None] >= (begins.argmax(axis=0) - 1) % height)
            You keep one row too many. A run whose last pixel is in row v begins in row v - run + 1.
        not in the last row: in range(run)]) => in range(run)])
            + begins[height - run :] = False
            You miss a run that ends in the last row. It begins in row H - run, and range(H - run) stops before that row.
        not in the last row, and column left alone: in range(run)]) => in range(run)])
            + begins[height - run :] = False
            accumulate(begins) => accumulate(begins) | ~begins.any(axis=0)
            Your code has two errors. It misses a run that ends in the last row, because range(H - run) stops before row H - run. And a column without a run keeps its labels, but must be erased.
        rolled: green[i : i + height] => np.roll(labels == 1, -i, axis=0)
            np.roll brings the top rows back below the last row, so a run can continue there. Nothing below the picture is green: pad with False instead.
        rolled without an axis: green[i : i + height] => np.roll(labels == 1, -i)
            Without an axis, np.roll shifts the flattened picture, so the columns move sideways. Give axis=0, and replace the rows that come back at the bottom with False.
        any colour: labels == 1 => labels != 0
            You count every label except 0. Only green (label 1) is carpet: a white wall is not a run.
        green kept: np.logical_or.accumulate(begins), labels => np.logical_or.accumulate(begins) | (labels == 1), labels
            Above the first long enough run, your green pixels keep their label. A shorter run of green is background, too: everything above becomes 0.
        white alone erased: np.logical_or.accumulate(begins), labels => np.logical_or.accumulate(begins) | (labels != 3), labels
            You erase only the white pixels above the run. Green and yellow pixels there become 0 as well.
        painted green: labels, 0) => labels, begins.any(axis=0))
            The erased pixels become green. They must become 0 (other).
        all but white: accumulate(begins) => accumulate(begins) & (labels == 3)
            You also remove green and yellow below the start of the run. Keep all labels there.
        a mask: labels, 0) => labels, 0) > 0
            You return True and False. Return labels: the old ones where they are kept, 0 elsewhere.
        the count never reset: + kept, count = labels.copy(), 0
            + for u in range(labels.shape[1]):
            +     for v in range(len(labels)):
            +         count = count + 1 if labels[v, u] == 1 else 0
            +         if count == run:
            +             break
            +     else:
            +         v = len(labels) + run - 1
            +     kept[: v - run + 1, u] = 0
            + return kept
            You do not set the count back to 0 at the top of each column, so a run can continue from the bottom of one column to the top of the next.
        all green pixels of all columns: + kept, green = labels.copy(), 0
            + for u in range(labels.shape[1]):
            +     for v in range(len(labels)):
            +         green += int(labels[v, u] == 1)
            +         if green == run:
            +             kept[: v - run + 1, u] = 0
            +             break
            +     else:
            +         kept[:, u] = 0
            + return kept
            You set the count to 0 only once. It must start again at every pixel that is not green, and at the top of each column.
        all green pixels of all columns, at least: + kept, green = labels.copy(), 0
            + for u in range(labels.shape[1]):
            +     for v in range(len(labels)):
            +         green += int(labels[v, u] == 1)
            +         if green >= run:
            +             kept[: v - run + 1, u] = 0
            +             break
            +     else:
            +         kept[:, u] = 0
            + return kept
            You set the count to 0 only once, so from some column on it is always large enough. It must start again at every pixel that is not green, and at the top of each column.
        no end of the loop: + kept = labels.copy()
            + for u in range(labels.shape[1]):
            +     green, found = 0, False
            +     for v in range(len(labels)):
            +         green = green + 1 if labels[v, u] == 1 else 0
            +         if green == run:
            +             kept[: v - run + 1, u], found = 0, True
            +     if not found:
            +         kept[:, u] = 0
            + return kept
            You erase at every run of a column, so the last run decides. Stop at the first one, for example with break.
        no end of the loop, and column left alone: + kept = labels.copy()
            + for u in range(labels.shape[1]):
            +     green = 0
            +     for v in range(len(labels)):
            +         green = green + 1 if labels[v, u] == 1 else 0
            +         if green == run:
            +             kept[: v - run + 1, u] = 0
            + return kept
            Your code has two errors. It erases at every run of a column, but must stop at the first one. And a column without a run keeps its labels, but must be erased.
        only runs that end: in range(run)]) => in range(run)])
            + begins &= ~np.logical_and.accumulate(green[:height][::-1])[::-1]
            You test the count only at a pixel that is not green, so you miss a run that reaches the last row. Test it at each green pixel, or once more after the last row.
    """),
    alternatives={
        "a loop over columns": _erase_loop,
        "cumulative sums": _erase_sums,
        "erosion": _erase_morphology,
    },
)


# --- 3.3 hough_segments ---
def _hough(
    picture: Array, max_line_gap: float = 5, min_line_length: float = 40, canny: Any = (50, 150)
) -> Array:
    edges = cv2.Canny(picture, *canny)
    found = cv2.HoughLinesP(edges, 1, np.pi / 180, 20, minLineLength=min_line_length, maxLineGap=max_line_gap)
    return np.zeros((0, 4)) if found is None else np.asarray(found, dtype=float).reshape(-1, 4)


def _longest_first(*args: Any) -> Array:
    found = _hough(*args)
    return found[np.argsort(-np.hypot(*(found[:, 2:] - found[:, :2]).T))]


def _hough_public() -> list[Case]:
    corner = drawn([(6, 10, 58, 14), (32, 12, 22, 44)], 7)
    long_and_short = drawn([(4, 10, 60, 10), (20, 30, 38, 30)], 6)
    gaps = drawn([(3, 12, 29, 12), (42, 12, 61, 12), (5, 34, 22, 34), (28, 34, 60, 34)], 7)
    return [
        Case((corner, 3, 15), "two lines that meet"),
        Case((gaps, 3, 15), "lines with gaps, a largest gap of 3"),
        Case((gaps, 24, 15), "the same, a largest gap of 24"),
        Case((drawn([(4, 8, 60, 40)], 8), 3, 30), "a wide diagonal line"),
        Case((long_and_short, 3, 30), "a long and a short line, at least 30 long"),
        Case((np.zeros(SIZE, dtype=np.uint8), 5, 40), "no line at all"),
        Case((drawn([(30, 20, 34, 20)], 3), 5, 15), "a spot, and no line"),
        Case((drawn([(20, 20, 36, 20)], 3), 5, 10), "a line of 17 px, too short for 20 votes"),
        *(Case((picture,), f"the default {name}") for name, picture in _at_defaults_of_hough().items()),
    ]


def _at_defaults_of_hough() -> dict[str, Array]:
    """Return pictures in which changing a default value by one pixel changes the result."""
    return {
        "length, a line too short": drawn([(10, 20, 47, 20)]),
        "length, a line just long enough": drawn([(10, 20, 48, 20)]),
        "gap, pieces that are joined": drawn([(0, 14, 29, 14), (37, 14, 61, 14)], 3),
        "gap, pieces too far apart": drawn([(0, 14, 29, 14), (36, 14, 61, 14)], 1),
    }


def _hough_hidden(rng: np.random.Generator) -> list[Case]:
    def lines(shape: tuple[int, int], number: int) -> Lines:
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
        "You need two calls of OpenCV, with the numbers in the docstring. Pass minLineLength and maxLineGap by name, because the fifth positional argument is another one. Print the result before you return it.",
        "cv2.HoughLinesP(edges, 1, np.pi / 180, 20, minLineLength=..., maxLineGap=...) returns None if it finds no line. Return np.zeros((0, 4)) then. Otherwise found.reshape(-1, 4) has the right shape in every version of OpenCV.",
    ),
    sibling=Sibling(
        "A library's function that finds nothing returns None, and your function returns an empty array with the usual number of columns in its place.",
        """
        import numpy as np

        timetable = {"bus 5": [8, 15, 9, 45]}  # hour, minute, hour, minute


        def departures(line):
            found = timetable.get(line)
            return np.empty((0, 2)) if found is None else np.reshape(found, (-1, 2))


        print(departures("bus 5"), departures("bus 6").shape)
        """,
        """
        [[ 8 15]
         [ 9 45]] (0, 2)
        """,
    ),
    mistakes=catalogue("""
        no Canny: cv2.Canny(picture, 50, 150) => picture
            Your segments run through the inside of the lines, because HoughLinesP got the line picture itself. Give it the edges from cv2.Canny.
        gap and length swapped: minLineLength=min_line_length, maxLineGap=max_line_gap => minLineLength=max_line_gap, maxLineGap=min_line_length
            The maximum gap and the minimum length are swapped. Pass them by name: minLineLength=..., maxLineGap=...
        theta of one: np.pi / 180 => 1.0
            You find almost no lines. The usual cause is the step of the angle, which is in radians: one degree is np.pi / 180. If that is right, you require too many votes: use 20.
        the gap not used: maxLineGap=max_line_gap => maxLineGap=0
            max_line_gap does not reach HoughLinesP, so it does not join line segments across a gap.
        the length not used: minLineLength=min_line_length => minLineLength=0
            min_line_length does not reach HoughLinesP, so some of your segments are too short.
        no Canny and one radian: cv2.Canny(picture, 50, 150) => picture
            np.pi / 180 => 1.0
            Your code has two errors. HoughLinesP must get the edges from cv2.Canny, and its step of the angle is in radians: one degree is np.pi / 180.
        no Canny, gap and length swapped: cv2.Canny(picture, 50, 150) => picture
            minLineLength=min_line_length, maxLineGap=max_line_gap => minLineLength=max_line_gap, maxLineGap=min_line_length
            Your code has two errors. HoughLinesP must get the edges from cv2.Canny, and the maximum gap and the minimum length are swapped.
        no Canny and None: if not picture.any(): => if False:
            cv2.Canny(picture, 50, 150) => picture
            np.zeros((0, 4)) if found is None else =>
            Your code has two errors. HoughLinesP must get the edges from cv2.Canny, and it returns None if it finds no line: test for that, and return np.zeros((0, 4)).
        by position and None reshaped, no Canny: if not picture.any(): => if False:
            cv2.Canny(picture, 50, 150) => picture
            minLineLength=min_line_length, maxLineGap=max_line_gap => min_line_length, max_line_gap
            Your code has two errors. HoughLinesP must get the edges from cv2.Canny, and its fifth positional argument is not the length: write minLineLength=... and maxLineGap=...
        endless lines: + found = cv2.HoughLines(cv2.Canny(picture, 50, 150), 1, np.pi / 180, 20)
            + return np.zeros((0, 2)) if found is None else found[..., :2].reshape(-1, 2).astype(float)
            You call HoughLines, which returns a distance and an angle for each infinite line. HoughLinesP, with a P, returns segments.
        None: np.zeros((0, 4)) =>> None
            HoughLinesP returns None if it finds no line. Return an array of shape (0, 4) in that case.
        None reshaped: if not picture.any(): => if False:
            np.zeros((0, 4)) if found is None else =>
            HoughLinesP returns None if it finds no line, and None has no reshape. Test for None first, and return np.zeros((0, 4)).
        by position: if not picture.any(): => if False:
            minLineLength=min_line_length, maxLineGap=max_line_gap => min_line_length, max_line_gap
            The fifth positional argument of HoughLinesP is not the length. Pass both by name: minLineLength=... and maxLineGap=...
        no shape: np.zeros((0, 4)) =>> np.array([])
            If there is no line, np.array([]) has shape (0,). Return np.zeros((0, 4)).
        (N, 1, 4): np.zeros((0, 4)) =>> np.zeros((0, 1, 4))
            reshape(len(found), 4) => reshape(len(found), 1, 4)
            Your result has shape (N, 1, 4), as in some versions of OpenCV. reshape(-1, 4) makes it (N, 4) in all of them.
        (row, column): .astype(float) => .astype(float)[:, [1, 0, 3, 2]]
            Your segments are (v1, u1, v2, u2). OpenCV uses the same order as this course: (u1, v1, u2, v2), columns first.
        a tutorial's call: if not picture.any(): => if False:
            minLineLength=min_line_length, maxLineGap=max_line_gap => max_line_gap, min_line_length
            np.zeros((0, 4)) if found is None else found.reshape(len(found), 4).astype(float) => found[:, 0]
            The fifth positional argument of HoughLinesP is `lines`, which is meant for the result, so your two values do not arrive where they should: write minLineLength=... and maxLineGap=... Then remove [:, 0], which is for OpenCV 4, and test for None.
        a tutorial's call in the other order: if not picture.any(): => if False:
            minLineLength=min_line_length, maxLineGap=max_line_gap => min_line_length, max_line_gap
            np.zeros((0, 4)) if found is None else found.reshape(len(found), 4).astype(float) => found[:, 0]
            The fifth positional argument of HoughLinesP is `lines`, so your length and your gap do not arrive where they should: write minLineLength=... and maxLineGap=... Then remove [:, 0], which is for OpenCV 4, and test for None.
        the first column: .astype(float) => .astype(float)[:, 0]
            Tutorials write [:, 0] because OpenCV 4 returns (N, 1, 4). Here the result is already (N, 4), so [:, 0] keeps one number of each segment.
        the first column, always: if not picture.any(): => if False:
            np.zeros((0, 4)) if found is None else found.reshape(len(found), 4).astype(float) => found[:, 0]
            Your code has two errors. [:, 0] is for OpenCV 4, which returns (N, 1, 4); here the result is already (N, 4). If there is no line it is None: test for that first.
        the first number: np.zeros((0, 4)) =>> np.array([])
            found.reshape(len(found), 4).astype(float) => np.array([tuple(line[0]) for line in found])
            Tutorials write line[0] because OpenCV 4 returns (N, 1, 4). Here each line is already an array of four numbers.
        the first number, always: if not picture.any(): => if False:
            np.zeros((0, 4)) if found is None else found.reshape(len(found), 4).astype(float) => np.array([tuple(line[0]) for line in found])
            Your code has two errors. line[0] is for OpenCV 4; here each line is already an array of four numbers. If there is no line, HoughLinesP returns None, and a loop over None fails.
        too many votes: 180, 20 => 180, 50
            You require 50 votes or more. Use 20; the votes are the fourth argument of HoughLinesP.
        transposed: cv2.Canny(picture, 50, 150) => cv2.Canny(picture.T.copy(), 50, 150)
            Your u and v are exchanged, because you transposed the picture. OpenCV takes the picture as it is, (H, W), and returns (u1, v1, u2, v2).
        squeezed: np.zeros((0, 4)) =>> np.array([])
            found.reshape(len(found), 4).astype(float) => found.squeeze()
            .squeeze() also removes the first axis if there is one segment, and np.array([]) has shape (0,). Use found.reshape(-1, 4), and np.zeros((0, 4)) if there is no line.
        too few votes: 180, 20 => 180, 10
            You accept lines with fewer than 20 votes. The votes are the fourth argument of HoughLinesP.
        the first only: .astype(float) => .astype(float)[:1]
            You return one segment. Return all of them, shape (N, 4).
        the defaults always: minLineLength=min_line_length, maxLineGap=max_line_gap => minLineLength=40, maxLineGap=5
            Your result does not depend on max_line_gap and min_line_length. Pass both to HoughLinesP.
        endless lines, or none: + found = cv2.HoughLines(cv2.Canny(picture, 50, 150), 1, np.pi / 180, 20)
            + return np.zeros((0, 4)) if found is None else found[..., :2].reshape(-1, 2).astype(float)
            HoughLines returns infinite lines, each as a distance and an angle. Call HoughLinesP, with a P, which returns segments.
    """),
    alternatives={
        "other limits of Canny": lambda *args: _hough(*args, canny=(100, 200)),
        "whole numbers, both ends exchanged": lambda *args: _hough(*args).astype(int)[:, [2, 3, 0, 1]],
        "the longest first": _longest_first,
    },
    equivalents={
        "edges = cv2.Canny(picture, 51, 150)": "Canny on white and black marks the same pixels with any limits between its gradients",
        "edges = cv2.Canny(picture, 49, 150)": "Canny on white and black marks the same pixels with any limits between its gradients",
        "edges = cv2.Canny(picture, 50, 151)": "Canny on white and black marks the same pixels with any limits between its gradients",
        "edges = cv2.Canny(picture, 50, 149)": "Canny on white and black marks the same pixels with any limits between its gradients",
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


def _meet_solved(first: Array, second: Array, reach: float = 5.0) -> Any:
    """Solve a linear system for the two parameters."""
    a, b = first.reshape(2, 2), second.reshape(2, 2)
    matrix = np.column_stack([a[1] - a[0], b[0] - b[1]])
    lengths = np.linalg.norm(matrix, axis=0)
    if abs(np.linalg.det(matrix / lengths)) < PARALLEL:
        return None
    along = np.linalg.solve(matrix, b[0] - a[0])
    inside = np.all(np.abs(along - 0.5) * lengths <= lengths / 2 + reach)
    return tuple((a[0] + along[0] * (a[1] - a[0])).tolist()) if inside else None


def _meet_homogeneous(first: Array, second: Array, reach: float = 5.0) -> Any:
    """Use homogeneous coordinates: the line through two points, and the point on two lines, are cross products."""
    segments = [np.column_stack([each.reshape(2, 2), np.ones(2)]) for each in (first, second)]
    lines = [np.cross(*ends) for ends in segments]
    u, v, w = np.cross(*lines)
    if abs(w) < PARALLEL * np.hypot(*lines[0][:2]) * np.hypot(*lines[1][:2]):
        return None
    for start, end in segments:
        way = (end - start) / np.linalg.norm(end - start)
        if not start @ way - reach <= (u / w, v / w, 1) @ way <= end @ way + reach:
            return None
    return np.array([u / w, v / w])


def _meet_extended(first: Array, second: Array, reach: float = 5.0) -> Any:
    """Make both longer first, then cut them without a reach."""
    ways = [(each[2:] - each[:2]) / np.hypot(*(each[2:] - each[:2])) for each in (first, second)]
    longer = [each + reach * np.append(-way, way) for each, way in zip((first, second), ways, strict=True)]
    return _meet_solved(*longer, reach=0.0)


def segment(*numbers: float) -> Array:
    return np.array(numbers, dtype=float)


def _meet_public() -> list[Case]:
    level, beyond = segment(10, 20, 50, 20), segment(52, 27, 40, 50)
    return [
        Case((level, segment(30, 5, 30, 40), 5.0), "a horizontal and a vertical segment that cross"),
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
        Case((level, beyond, 5.0), "the crossing lies 2 px beyond the end, but 8 px beyond the other"),
        Case((segment(0, 0, 30, 30), segment(34, 26, 60, 0), 5.0), "slanted, 5.7 px short"),
        Case((segment(0, 0, 30, 30), segment(34.5, 34.5, 60, 9), 5.0), "slanted, 6.4 px short"),
        Case((level, segment(54.5, 2, 54.5, 40)), "4.5 px short, with the default reach"),
        Case((level, segment(55.5, 2, 55.5, 40)), "5.5 px short, with the default reach"),
        Case((level, segment(10, 16.7, 50, 23.3)), "at 9.4 degrees"),
        Case((level, segment(10, 16.3, 50, 23.7)), "at 10.5 degrees"),
        Case((level, segment(50, 22, 10, 18)), "at 6 degrees, in the opposite direction"),
        Case((segment(50, 20, 10, 20), segment(50, 22, 10, 18)), "at 6 degrees, both to the left"),
        Case((segment(29, 0, 31, 40), segment(31, 0, 29, 40)), "two vertical ones at 6 degrees"),
        Case((level, segment(30, 24, 30, 34)), "a long and a short segment, 4 px apart"),
        Case((level, segment(58, 16, 58, 26)), "8 px beyond the long segment's end"),
        Case((segment(0, 0, 30, 30), segment(33, 10, 33, 64)), "4.2 px beyond a slanted segment's end"),
        Case(
            (segment(10, 50, 110, 50), segment(60, 40, 60, 56)), "a long and a short segment at a right angle"
        ),
        Case((segment(60, 40, 60, 56), segment(10, 50, 110, 50)), "the same, the short one first"),
        Case((segment(10, 20, 14, 20), segment(90, 10, 90, 30)), "two short segments, 76 px apart"),
    ]


def _meet_hidden(rng: np.random.Generator) -> list[Case]:
    cases: list[Case] = []
    while len(cases) < 40:
        meeting, angles = rng.uniform(20, 200, 2), rng.uniform(0, 2 * np.pi, 2)
        if abs(abs(np.sin(angles[0] - angles[1])) - PARALLEL) < 0.03:
            continue
        ends = []
        for angle in angles:
            start = rng.choice([-60.0, -20.0, 2.0, 4.0, 8.0, 12.0])
            way = np.stack([np.cos(angle), np.sin(angle)])
            two = [meeting + start * way, meeting + (start + rng.uniform(24, 90)) * way]
            ends.append(np.concatenate(two[::-1] if rng.random() < 0.5 else two))
        cases.append(Case((ends[0], ends[1], float(rng.choice([0.0, 3.0, 5.0, 10.0])))))
    u, v = rng.integers(20, 80, 2).astype(float)
    flat = segment(u, v, u + 60, v)
    return [
        *cases,
        *(Case((flat, segment(u + 60 + beyond, v - 20, u + 60 + beyond, v + 30))) for beyond in (4.5, 5.5)),
        *(Case((flat, segment(u, v - up, u + 60, v + up))) for up in (4.95, 5.55)),  # at 9.4 and 10.5 degrees
        Case((segment(5, 5, 5, 40), segment(9, 5, 9, 40), 5.0)),
        Case((flat, segment(u + 60, v + 3, u, v - 3))),
        Case((segment(u + 60, v, u, v), segment(u + 60, v + 3, u, v - 3))),
        Case((segment(u - 1, v, u + 2, v + 60), segment(u + 2, v, u - 1, v + 60))),
        *(Case((flat, segment(u + 30, v + short, u + 30, v + short + 12), 7.0)) for short in (6, 8)),
        *(Case((flat, segment(u + 60 + far, v - 5, u + 60 + far, v + 6), 7.0)) for far in (6, 10)),
        Case((segment(u - 60, v, u + 60, v), segment(u, v - 10, u, v + 8))),
        Case((segment(u, v - 10, u, v + 8), segment(u - 60, v, u + 60, v))),
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
    comparison=Crossing(rtol=0.0, atol=1e-3),
    hints=(
        "Equation 3.3 gives t, the parameter along the first segment. The second segment has its own parameter s, with the same denominator. Compute the denominator first: its size is the product of both lengths and the sine of the angle between the segments, so it shows whether they are parallel.",
        "The second segment is tested in the same way: s may be from -reach / length to 1 + reach / length, with the length of the second segment. Both conditions must hold.",
    ),
    sibling=Sibling(
        "Two cars that drive towards each other are like two segments: if the denominator is too small, they do not meet, and the meeting must be within both journeys, each tested by itself.",
        """
        def meeting(start_a, speed_a, hours_a, start_b, speed_b, hours_b):
            closing = speed_a - speed_b
            if abs(closing) < 1:  # km/h: nearly the same speed, so the quotient would be useless
                return None
            t = (start_b - start_a) / closing
            if not (0 <= t <= hours_a and 0 <= t <= hours_b):  # one of them has already stopped
                return None
            return start_a + speed_a * t


        print(meeting(0, 80, 3, 120, -40, 2), meeting(0, 80, 3, 120, -40, 0.5), meeting(0, 80, 3, 9, 80, 3))
        """,
        "80.0 None None",
    ),
    mistakes=catalogue("""
        unbounded lines: if on_both else None =>
            You intersect infinite lines. A crossing counts only if it is on both segments, or at most reach pixels beyond an end.
        one extended: -reach <= s * m <= m + reach => 0 <= s * m <= m
            You extend the first segment only. Extend both by reach pixels at both ends.
        only the first tested: and -reach <= s * m <= m + reach =>
            You test the first segment only, so the crossing may be far beyond the end of the second.
        no reach: + reach = 0
            You extend the segments too little or not at all. Extend both by reach pixels at each end.
        five whatever reach is: + reach = 5
            You always extend by 5 pixels. Use the argument reach.
        the other sign of s: (w[0] * d[1] - w[1] * d[0]) => (w[1] * d[0] - w[0] * d[1])
            You miss crossings that exist. The usual cause is an s with the wrong sign: put the numbers of the text into your formula, which must give -0.081.
        both the wrong way round: w = q - p => w = p - q
            Both of your parameters have the wrong sign. The vector in t and s is Q - P, from the first start to the second.
        the other sign of t: (w[0] * e[1] - w[1] * e[0]) => (w[1] * e[0] - w[0] * e[1])
            Your t has the wrong sign: for the numbers of the text it must be 1.075.
        t with the first direction: (w[0] * e[1] - w[1] * e[0]) => (w[0] * d[1] - w[1] * d[0])
            In t, the numerator is (Q - P) x E. With D you get s.
        the crossing alone: abs(across) <= np.sin(np.radians(10)) * n * m => False
            if on_both else None =>
            You intersect infinite lines. Test that t and s are on the segments, extended by reach. Return None if they are not, or if the segments are less than 10 degrees apart.
        only t and no reach: -reach <= t * n <= n + reach and -reach <= s * m <= m + reach => 0 <= t <= 1
            You test only t, and without reach. The crossing must also be on the second segment, which s shows, and both segments are extended by reach.
        only t, no reach and parallel: abs(across) <= np.sin(np.radians(10)) * n * m => False
            -reach <= t * n <= n + reach and -reach <= s * m <= m + reach => 0 <= t <= 1
            You test only t, and without reach. The crossing must also be on the second segment, which s shows, and both segments are extended by reach. Return None also if they are less than 10 degrees apart.
        one length for both: -reach <= s * m <= m + reach => -reach <= s * n <= n + reach
            You divide reach by the same length for both segments. Each segment has its own length.
        divided by the other length
            -reach <= t * n <= n + reach and -reach <= s * m <= m + reach => -reach <= t * m <= m + reach and -reach <= s * n <= n + reach
            You divide reach by the length of the other segment. The parameter t needs the length of the first segment, and s needs the length of the second.
        on the second with t: p + t * d => q + t * e
            You use t along the second segment. The crossing is P + t D on the first segment, and Q + s E on the second.
        on the first with s: p + t * d => p + s * d
            You use s along the first segment. The crossing is P + t D on the first segment, and Q + s E on the second.
        ends as directions: first[2:] - p, second[2:] - q => first[2:], second[2:]
            You use the end points as directions. D is the end of the first segment minus its start P, and E the same for the second.
        the length as a sum: np.hypot(*d), np.hypot(*e) => np.abs(d).sum(), np.abs(e).sum()
            * n * m => * np.hypot(*d) * np.hypot(*e)
            You add the two differences to get a length. The length of a segment is np.hypot of them.
        opposite directions: abs(across) <= np.sin(np.radians(10)) => d @ e > np.cos(np.radians(10))
            Two segments in opposite directions are parallel too: the angle between them is near 180 degrees. Hough returns both directions.
        angles from arctan: abs(across) <= np.sin(np.radians(10)) * n * m => abs(np.arctan(d[1] / d[0]) - np.arctan(e[1] / e[0])) < np.radians(10)
            Two nearly vertical segments can have angles near 90 and -90 degrees. These differ by almost 180 degrees, although the segments are parallel.
        the sign of the denominator: abs(across) => across
            D x E is negative if the second segment turns the other way. The segments are parallel if its absolute value is small.
        one end only: -reach <= =>> 0 <=
            You extend the segments at their ends, but not at their starts.
        reach as a part: -reach <= t * n <= n + reach and -reach <= s * m <= m + reach => -reach <= t <= 1 + reach and -reach <= s <= 1 + reach
            You compare reach, which is in pixels, with the parameter, which is a fraction of the length. Divide reach by the length first.
        parallel by chance: np.sin(np.radians(10)) * n * m => 0
            You return a crossing of segments that are less than 10 degrees apart. These are mostly the two edges of one line: return None. If you do test D x E, it also contains both lengths: compare its absolute value with the product of the lengths times np.sin(np.radians(10)).
        the first length twice: np.sin(np.radians(10)) * n * m => np.sin(np.radians(10)) * n * n
            You compare D x E with the square of the first length, so a long segment is parallel to every short one. Multiply the lengths of both segments.
        the second length twice: np.sin(np.radians(10)) * n * m => np.sin(np.radians(10)) * m * m
            You compare D x E with the square of the second length, so a long segment is parallel to every short one. Multiply the lengths of both segments.
        unbounded and parallel: np.sin(np.radians(10)) * n * m => 0
            if on_both else None =>
            Your code has two errors. It intersects infinite lines: a crossing must be on both segments, or at most reach pixels beyond an end. It also returns crossings of segments that are less than 10 degrees apart: return None for them.
        no reach and parallel: + reach = 0
            np.sin(np.radians(10)) * n * m => 0
            Your code has two errors. It does not extend the segments by reach pixels at each end, and it returns crossings of segments that are less than 10 degrees apart.
        reach as a part and parallel: np.sin(np.radians(10)) * n * m => 0
            -reach <= t * n <= n + reach and -reach <= s * m <= m + reach => -reach <= t <= 1 + reach and -reach <= s <= 1 + reach
            Your code has two errors. It compares reach, in pixels, with a fraction of the length: divide reach by the length. It also returns crossings of segments that are less than 10 degrees apart.
        first tested only and parallel: np.sin(np.radians(10)) * n * m => 0
            and -reach <= s * m <= m + reach =>
            Your code has two errors. It does not test whether the crossing is on the second segment, and it returns crossings of segments that are less than 10 degrees apart.
        sign of s and parallel: np.sin(np.radians(10)) * n * m => 0
            (w[0] * d[1] - w[1] * d[0]) => (w[1] * d[0] - w[0] * d[1])
            Your code has two errors. Your s seems to have the wrong sign: for the numbers of the text it must be -0.081. Your code also returns crossings of segments that are less than 10 degrees apart.
        sign of s and reach as a part: (w[0] * d[1] - w[1] * d[0]) => (w[1] * d[0] - w[0] * d[1])
            -reach <= t * n <= n + reach and -reach <= s * m <= m + reach => -reach <= t <= 1 + reach and -reach <= s <= 1 + reach
            Your code has two errors. Your s seems to have the wrong sign: for the numbers of the text it must be -0.081. The code also compares reach, in pixels, with a fraction of the length: divide reach by the length.
        sign of s and no reach: + reach = 0
            (w[0] * d[1] - w[1] * d[0]) => (w[1] * d[0] - w[0] * d[1])
            Your code has two errors. Your s seems to have the wrong sign: for the numbers of the text it must be -0.081. Your code also does not extend the segments by reach pixels.
        one length and parallel: np.sin(np.radians(10)) * n * m => 0
            -reach <= s * m <= m + reach => -reach <= s * n <= n + reach
            Your code has two errors. It divides reach by the same length for both segments, but each has its own. It also returns crossings of segments that are less than 10 degrees apart.
        the other length and parallel: np.sin(np.radians(10)) * n * m => 0
            -reach <= t * n <= n + reach and -reach <= s * m <= m + reach => -reach <= t * m <= m + reach and -reach <= s * n <= n + reach
            Your code has two errors. It divides reach by the length of the other segment. It also returns crossings of segments that are less than 10 degrees apart.
        one end and parallel: np.sin(np.radians(10)) * n * m => 0
            -reach <= =>> 0 <=
            Your code has two errors. It extends the segments at their ends, but not at their starts. It also returns crossings of segments that are less than 10 degrees apart.
        t on the second and parallel: np.sin(np.radians(10)) * n * m => 0
            p + t * d => q + t * e
            Your code has two errors. It uses t along the second segment, but the crossing is P + t D or Q + s E. It also returns crossings of segments that are less than 10 degrees apart.
        sign of s and one length: (w[0] * d[1] - w[1] * d[0]) => (w[1] * d[0] - w[0] * d[1])
            -reach <= s * m <= m + reach => -reach <= s * n <= n + reach
            Your code has two errors. Your s seems to have the wrong sign: for the numbers of the text it must be -0.081. The code also divides reach by the same length for both segments, but each has its own.
        divided by zero: across = d[0] * e[1] - d[1] * e[0] => across = float(d[0] * e[1] - d[1] * e[0])
            + t = float((q - p) @ (e[1], -e[0])) / across
            You divide before you test whether the segments are parallel, so the denominator can be 0. Test first, and return None.
        NaN for nothing: return None => return np.array([np.nan, np.nan])
            else None => else np.array([np.nan, np.nan])
            You return NaN if there is no crossing. Return None.
        an empty array: return None => return np.zeros((0, 2))
            else None => else np.zeros((0, 2))
            You return an empty array if there is no crossing. Return None.
        (row, column): p + t * d => (p + t * d)[::-1]
            Your point is (v, u). A point is (u, v), the column first.
        v = m u + b
            w = q - p => w = q - p
            + a, b = d[1] / d[0], e[1] / e[0]
            + u = (q[1] - b * q[0] - p[1] + a * p[0]) / (a - b)
            p + t * d => np.array([u, p[1] + a * (u - p[0])])
            You write a line as v = m u + b, which divides by zero for a vertical segment. Use the direction vectors of the segments, as in equation 3.3.
        boxes: -reach <= t * n <= n + reach => (abs(t - 0.5) * abs(d) <= abs(d) / 2 + reach).all()
            -reach <= s * m <= m + reach => (abs(s - 0.5) * abs(e) <= abs(e) / 2 + reach).all()
            You test whether the crossing is in a box around each segment, widened by reach. Extend a slanted segment along its own direction instead, by reach pixels.
        whole pixels: p + t * d => np.round(p + t * d)
            Your point is rounded. Crossings lie between pixels, so keep the fractions.
        fractions cut off: p + t * d => (p + t * d).astype(int)
            You convert the point to integers, which removes the fractions. Crossings lie between pixels, so return floats.
        shape (1, 2): p + t * d => (p + t * d)[None]
            Your point has shape (1, 2). One point has shape (2,).
        angles near 360 degrees: across = d[0] * e[1] - d[1] * e[0] => across = d[0] * e[1] - d[1] * e[0]
            + angle = abs(np.degrees(np.arctan2(d[1], d[0]) - np.arctan2(e[1], e[0])))
            abs(across) <= np.sin(np.radians(10)) * n * m => min(angle, abs(angle - 180)) < 10
            Two segments that point to the left can have angles near 180 and -180 degrees. These differ by almost 360 degrees, although the segments are parallel. Use D x E instead.
        angles near 180 and 360 degrees: across = d[0] * e[1] - d[1] * e[0] => across = d[0] * e[1] - d[1] * e[0]
            + angle = abs(np.degrees(np.arctan2(d[1], d[0]) - np.arctan2(e[1], e[0])))
            abs(across) <= np.sin(np.radians(10)) * n * m => angle < 10
            The angles of two parallel segments from arctan2 can differ by almost 180 or 360 degrees: the segments may run in opposite directions, or both to the left. Use D x E instead.
        extended at the start: -reach <= t * n <= n + reach and -reach <= s * m <= m + reach => -reach <= t * n <= n and -reach <= s * m <= m
            You extend the segments at their starts, but not at their ends. If you move the start back by reach, the segment must become longer by twice the reach.
    """),
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
        "if abs(across) <= np.radians(10) * n * m:": "10 degrees or 10.05: no case can ask for that",
    },
)


# --- 3.5 remove_doubles ---
def _doubles_matrix(points: Array, radius: float) -> Array:
    """Make a table of near pairs, then delete points in one pass."""
    near = np.linalg.norm(points[:, None] - points, axis=2) <= radius
    alive = np.ones(len(points), dtype=bool)
    for i in range(len(points)):
        alive[i + 1 :] &= ~(alive[i] & near[i, i + 1 :])
    return points[alive].astype(np.float32)


def _doubles_recursive(points: Array, radius: float) -> Array:
    """Keep the first point and call the function again with the points that are not near it."""
    if not len(points):
        return points
    rest = points[((points - points[0]) ** 2).sum(axis=1) > radius**2]
    return np.vstack([points[:1], _doubles_recursive(rest, radius)])


def _doubles_complex(points: Array, radius: float) -> Array:
    """Write points as complex numbers and take them from a list until it is empty."""
    left, stay = [complex(u, v) for u, v in points], []
    while left:
        stay.append(left.pop(0))
        left = [point for point in left if abs(point - stay[-1]) > radius]
    return np.array([(point.real, point.imag) for point in stay]).reshape(-1, 2)


def points(*points: tuple[float, float]) -> Array:
    return np.array(points, dtype=float)


def _doubles_public() -> list[Case]:
    fractions = points((5.25, 7.75), (60, 7), (60, 9), (60, 14))
    return [
        Case((points((10, 10), (16, 16), (40, 10)), 10.0), "two near points and one far away"),
        Case((points((10, 10), (18, 10), (26, 10), (34, 10)), 10.0), "a chain, 8 px from one to the next"),
        Case((points((10, 10), (40, 40), (12, 13), (43, 41)), 10.0), "two corners, in turns"),
        Case((points((0, 0), (0, 10), (30, 0)), 10.0), "exactly 10 px apart"),
        Case((points((0, 0), (8, 8), (3.5, 0)), 10.0), "8 px apart in both directions"),
        Case((points((18, 10), (10, 10), (26, 10)), 10.0), "the middle one of three comes first"),
        Case((fractions, 4.0), "a radius of 4, with fractions"),
        Case((np.zeros((0, 2)), 10.0), "no points"),
    ]


def _doubles_hidden(rng: np.random.Generator) -> list[Case]:
    chances = [rng.uniform(0, 60, (int(rng.integers(10, 40)), 2)) for _ in range(4)]
    chain = np.column_stack([np.arange(0.0, 90.0, 7.0), np.full(13, rng.uniform(0, 50))])
    return [
        *map(Case, zip(chances, (3.0, 6.0, 10.0, 15.0), strict=True)),
        Case((chain, 10.0)),
        Case((rng.permutation(chain), 15.0)),
        Case((points((3, 4), (0, 0), (6, 8)), 5.0)),
        Case((rng.uniform(0, 300, (1, 2)), 10.0)),
        Case((np.zeros((0, 2)), 10.0)),
    ]


REMOVE_DUPLICATES = Exercise(
    name="remove_doubles",
    points=2,
    stars=2,
    public=_doubles_public,
    hidden=_doubles_hidden,
    comparison=Points(tolerance=0.05),
    hints=(
        "Start with an empty list of kept points and go through the points in their order. When do you add a point to the list?",
        "Add a point if np.hypot(*(point - other)) > radius for every other point in the list of kept ones; ignore earlier points that were deleted. At the end, return np.array(kept).reshape(-1, 2).",
    ),
    sibling=Sibling(
        "Each element is compared only with the elements that were kept, so an element that was deleted deletes nothing.",
        """
        import numpy as np

        kept = []
        for number in (6, 10, 35, 21, 11):
            if all(np.gcd(number, other) == 1 for other in kept):  # no common divisor
                kept.append(number)
        print(kept)  # 10 is deleted because of 6, so it does not delete 35
        """,
        "[6, 35, 11]",
    ),
    mistakes=catalogue("""
        averaged: np.array(kept) => np.array([points[np.linalg.norm(points - each, axis=1) <= radius].mean(axis=0) for each in kept])
            You average points that are near each other, as in lesson 02. Here the first of them stays unchanged, and the others are deleted.
        each averaged: + return np.unique(np.array([points[np.linalg.norm(points - each, axis=1) <= radius].mean(axis=0) for each in points]).reshape(-1, 2), axis=0)
            You replace each point by the average of the points near it. Keep the first of several near points as it is, and delete the others.
        averaged one after the other: + rest, means = points, []
            + while len(rest):
            +     near = np.linalg.norm(rest - rest[0], axis=1) <= radius
            +     means.append(rest[near].mean(axis=0))
            +     rest = rest[~near]
            + return np.array(means).reshape(-1, 2)
            You average each point with the points near it, as in lesson 02. Here the first of them stays unchanged, and the others are deleted.
        removed in the loop: + rest = [tuple(point) for point in points]
            + for point in rest:
            +     for other in rest:
            +         if other != point and np.hypot(point[0] - other[0], point[1] - other[1]) <= radius:
            +             rest.remove(other)
            + return np.array(rest).reshape(-1, 2)
            You remove points from the list while you loop over it, so the loop skips some of them. Start a new list and append the points that you keep.
        both deleted: for point in points => for i, point in enumerate(points)
            for other in kept => for other in np.delete(points, i, axis=0)
            If two points are near each other, you delete both. Keep the first.
        near itself: for other in kept => for other in points
            You delete every point. If you compare a point with all points, one of them is the point itself, at a distance of 0. If you start with an empty list of kept points, the first point has nothing to be compared with and must be kept.
        near a deleted one: for point in points => for i, point in enumerate(points)
            for other in kept => for other in points[:i]
            You compare each point with all earlier points, including the deleted ones. Compare it with the kept points only.
        only the previous point: for point in points => for i, point in enumerate(points)
            for other in kept => for other in points[max(0, i - 1) : i]
            You compare each point with the previous one only. Compare it with all points that you kept.
        only the last kept: in kept => in kept[-1:]
            You compare each point with the last kept one only. Compare it with all kept points.
        the last stays: in points => in points[::-1]
            Of several near points you keep the last. Keep the first.
        sorted: in points => in sorted(points, key=tuple)
            You sort the points first. Go through them in the order in which they are given.
        ten whatever radius is: > radius => > 10
            You always use 10 pixels. Use the argument radius.
        far from one of them: if all( => if not kept or any(
            You keep a point if it is far from any one of the kept points. It must be far from all of them.
        kept for each far one: + rest = list(points[:1])
            + for point in points[1:]:
            +     for other in rest:
            +         if np.hypot(*(point - other)) > radius:
            +             rest.append(point)
            + return np.array(rest).reshape(-1, 2)
            You keep a point as soon as it is far from one kept point. It must be far from all of them: append it once, after the inner loop.
        kept for each far one, from the first: + rest = [points[0]]
            + for point in points[1:]:
            +     for other in rest:
            +         if np.hypot(*(point - other)) > radius:
            +             rest.append(point)
            + return np.array(rest).reshape(-1, 2)
            Your code has two errors. It keeps a point as soon as it is far from one kept point, but it must be far from all of them: append it once, after the inner loop. And points[0] does not exist if there are no points.
        deleted in the loop: + for i in range(len(points)):
            +     for j in range(i + 1, len(points)):
            +         if np.hypot(*(points[i] - points[j])) <= radius:
            +             points = np.delete(points, j, axis=0)
            + return points
            You delete points while the loop still counts to the old length. Collect the kept points in a new list.
        deleted in the loop, the number noted before it: + n = len(points)
            + for i in range(n):
            +     for j in range(i + 1, n):
            +         if np.hypot(*(points[i] - points[j])) <= radius:
            +             points = np.delete(points, j, axis=0)
            + return points
            You note the number of points before the loops, but np.delete makes the array shorter. Collect the kept points in a new list.
        along the wrong axis: if all(np.hypot(*(point - other)) > radius for other in kept): => if not kept or (np.linalg.norm(np.array(kept) - point, axis=0) > radius).all():
            np.linalg.norm needs axis=1 here. With axis=0 it adds up all rows, and you get one number for u and one for v instead of one distance for each point.
        squared distance: np.hypot(*(point - other)) => ((point - other) ** 2).sum()
            You compare a squared distance with radius. Take the square root first.
        one direction at a time: np.hypot(*(point - other)) => np.abs(point - other).max()
            You compare the differences in u and v separately, which tests a square. Compute the distance, np.hypot of both differences.
        columns plus rows: np.hypot(*(point - other)) => np.abs(point - other).sum()
            You add the differences in u and v. The distance is np.hypot of both.
        at the rim: > radius => >= radius
            You keep a point that is exactly radius away from a kept one. It is a duplicate: keep only points that are farther away.
        whole pixels: 2) => 2).round()
            Your points are rounded. Return the kept points unchanged.
        no shape: .reshape(len(kept), 2) =>
            If there are no points, np.array([]) has shape (0,). Use .reshape(-1, 2) to get (0, 2).
    """),
    alternatives={
        "a table of who is near whom": _doubles_matrix,
        "recursion": _doubles_recursive,
        "complex numbers": _doubles_complex,
    },
    equivalents={
        "if all((np.hypot(*other - point) > radius for other in kept)):": "a distance has no direction"
    },
)


# --- 3.6 find_corners ---
def _corners(labels: Array, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    """Find corners with the alternatives of the earlier exercises."""
    white = cv2.inRange(_erase_loop(labels), WHITE, WHITE)
    pairs = combinations(_hough(white, max_line_gap, min_line_length), 2)
    points = np.array([point for pair in pairs if (point := _meet_solved(*pair))]).reshape(-1, 2)
    return _doubles_recursive(points[((points >= 0) & (points < labels.shape[::-1])).all(axis=1)], 10.0)


def _corners_as_they_come(labels: Array, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    """Decide about each crossing when it is found."""
    segments = _hough(cv2.inRange(_erase_morphology(labels, 7), WHITE, WHITE), max_line_gap, min_line_length)
    kept: list[Array] = []
    for i in range(len(segments)):
        for j in range(i + 1, len(segments)):
            point = _meet_extended(segments[i], segments[j])
            if point is None or not (0 <= point[0] < labels.shape[1] and 0 <= point[1] < labels.shape[0]):
                continue
            if not any(np.hypot(*np.subtract(point, other)) <= 10 for other in kept):
                kept.append(np.asarray(point))
    return np.array(kept).reshape(-1, 2)


def _corners_of_all_pairs(labels: Array, max_line_gap: float = 5, min_line_length: float = 40) -> Array:
    """Take each pair in both orders: the second crossing of a pair is a duplicate of the first."""
    segments = _hough(cv2.inRange(_erase_sums(labels), WHITE, WHITE), max_line_gap, min_line_length)
    meetings = [_meet_homogeneous(first, second) for first in segments for second in segments]
    found = np.array([each for each in meetings if each is not None]).reshape(-1, 2)
    height, width = labels.shape
    u, v = found.T
    return _doubles_complex(found[(u >= 0) & (v >= 0) & (u < width) & (v < height)], 10.0)


def corner_scene(shape: Any, at: tuple[float, float], thickness: int, horizon: float = 0.15) -> Array:
    """Return labels of a corner on carpet: a level line that runs from an upright one to the farther side of the picture."""
    height, width = shape
    u, v = at
    end = 0.05 * width if u > width / 2 else 0.95 * width
    lines = [(u, v, end, v), (u, v, u, 0.97 * height)]  # level and upright: Hough does not break these
    return field(lines, round(horizon * height), thickness, shape)


def at_the_edge() -> dict[str, Array]:
    """Return labels of two lines whose edges cross near the picture's border or just outside it, by the place."""
    return {
        "left of the picture": field([(-2, 40, 60, 29), (-2, 40, 60, 55)], 3, 1),
        "right of the picture": field([(66, 26, 3, 15), (66, 26, 3, 46)], 3, 1),
        "below the picture": field([(40, 51, 29, 12), (40, 51, 81, 12)], 3, 2),
        "in the leftmost pixel": field([(1, 39, 60, 31), (1, 39, 60, 52)], 3, 1),
        "inside the picture, and another one outside": field([(-2, 23, 49, 24), (-2, 23, 48, 44)], 3, 2),
        "near the left side, and another one outside": field([(1, 21, 42, 43), (1, 21, 61, 15)], 3, 2),
    }


def _corners_at_defaults() -> list[Array]:
    """Return labels in which changing a default value by one pixel changes the result."""
    lengths = [(41, 43, 51, 20, 5), (42, 37, 45, 22, 3), (42, 40, 44, 21, 5), (42, 39, 50, 23, 5)]
    found = [field([(u, v, u - n, v), (u, v, u, v + m)], 6, thick, (70, 64)) for n, m, u, v, thick in lengths]
    gaps = [(5, 26, 23, 3, 59), (5, 30, 21, 5, 50), (6, 29, 16, 3, 55), (6, 28, 17, 5, 50)]
    for gap, start, v, thick, u in gaps:
        found.append(field([(u, v, 1, v), (u, v, u, 68)], 6, thick, (70, 64)))
        found[-1][v - 5 : v + 6, start : start + gap] = GREEN
    return found


def small_scenes() -> dict[str, Array]:
    """Return labels of corners that are near each other, or have little carpet above them, by description."""
    below = {rows: field([(5, 20, 50, 20), (50, 20, 50, 46)], 18 - rows, 3) for rows in (6, 7)}
    return {
        "two corners": field([(5, 18, 58, 18), (14, 18, 14, 46), (50, 18, 50, 46)], 5, 3),
        "two corners 16 px apart": field([(5, 18, 58, 18), (24, 18, 24, 46), (40, 18, 40, 46)], 5, 1),
        "one corner of wide lines": corner_scene(SIZE, (44, 22), 6),
        **{f"{rows} rows of carpet above a line": labels for rows, labels in below.items()},
    }


def _corners_public() -> list[Case]:
    framed = field([], 34)
    framed[drawn([(10, 5, 56, 5), (10, 5, 10, 32)], 4) > 0] = WHITE
    yellow = corner_scene(SIZE, (44, 20), 4)
    yellow[yellow == WHITE] = YELLOW
    short = field([(4, 12, 60, 12), (40, 25, 40, 47)], 3, 3)
    meeting = field([(4, 20, 60, 20), (40, 20, 40, 47)], 7, 4)
    broken = field([(4, 20, 26, 20), (38, 20, 60, 20), (48, 20, 48, 47)], 7, 4)
    return [
        Case((corner_scene(SIZE, (44, 20), 4), 5, 15), "one corner"),
        Case((field([(43, 12, 1, 12), (43, 12, 43, 60)], 2, 5, (64, 48)),), "one corner, by the defaults"),
        *(Case((labels, 5, 15), name) for name, labels in small_scenes().items()),
        Case((framed, 5, 15), "a white frame on the wall"),
        Case((yellow, 5, 15), "a yellow corner"),
        Case((meeting, 5, 15), "a long and a short line that meet"),
        Case((meeting, 5, 35), "the same, with lines of 35 px at least"),
        Case((broken, 5, 28), "a broken line, lines of 28 px at least"),
        Case((short, 5, 15), "a line that ends 12 px below another"),
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
        *(Case((np.pad(labels, ((0, 5), (0, 0)), "edge"), 5, 15)) for labels in small_scenes().values()),
    ]


def _pairs(others: str, pair: str = "(first, second)") -> str:
    """Return the solution's line that pairs segments, with another range for the second segment."""
    return f"pairs = [{pair} for i, first in enumerate(segments) for second in segments[{others}]]"


FIND_CORNERS = Exercise(
    name="find_corners",
    points=4,
    stars=3,
    uses=("line_picture", "erase_background", "hough_segments", "segment_intersection", "remove_doubles"),
    public=_corners_public,
    hidden=_corners_hidden,
    comparison=Points(tolerance=1.0),
    hints=(
        "Use your five functions in the order of the lesson: erase the background, make the line picture, find segments, intersect every pair of segments, remove duplicates. Two nested loops, or itertools.combinations(segments, 2), give the pairs in the order that is asked for.",
        "segment_intersection returns None for most pairs: keep only the other results. Remove crossings outside the picture next, then the duplicates. If there are no crossings, np.array([]) needs .reshape(-1, 2).",
    ),
    sibling=Sibling(
        "All pairs are tested, most of them give None, and the array has two columns even if nothing is left.",
        """
        import numpy as np


        def overlap(a, b):
            low, high = max(a[0], b[0]), min(a[1], b[1])
            return (low, high) if low < high else None


        for bookings in ([(8, 10), (9, 12), (11, 13)], [(8, 9), (10, 11)]):
            pairs = [overlap(a, b) for i, a in enumerate(bookings) for b in bookings[i + 1 :]]
            print(np.array([pair for pair in pairs if pair]).reshape(-1, 2).tolist())
        """,
        """
        [[9, 10], [11, 12]]
        []
        """,
    ),
    mistakes=catalogue("""
        background kept: erase_background(labels) => labels
            You find corners on the wall. Call erase_background first.
        yellow too: line_picture(erase_background(labels)) => np.uint8(255) * (erase_background(labels) >= 2)
            You find a corner of something yellow. Only white (label 3) is a line.
        doubles kept: remove_doubles(points[inside], 10.0) => points[inside]
            You return several points for one corner, because each line has two edges. Call remove_doubles at the end.
        nothing at all: + return np.zeros((0, 2))
            You find no corner in any picture. hough_segments needs the line picture of 0 and 255: Canny finds almost no step between labels 1 and 3. If it has it, look at the result of each step: the labels after erasing, the line picture, and the number of segments.
        the first only: 10.0) => 10.0)[:1]
            You return one corner. Return all of them, shape (K, 2).
        outside kept: points[inside] => points
            You keep crossings outside the picture. A crossing counts if u is at least 0 and less than W, and v is at least 0 and less than H.
        outside removed last
            return remove_doubles(points[inside], 10.0) => kept = remove_doubles(points, 10.0)
            + return kept[((kept >= 0) & (kept < labels.shape[::-1])).all(axis=1)]
            You remove duplicates before you remove crossings outside the picture. A crossing outside can then delete one inside that is near it. Remove the crossings outside first.
        clipped: points[inside] => np.clip(points, 0, np.subtract(labels.shape[::-1], 1))
            You move crossings from outside to the border of the picture. They are not corners there: remove them.
        doubles and outside kept: remove_doubles(points[inside], 10.0) => points
            Your code has two errors. It keeps crossings outside the picture, and it returns several points for one corner: call remove_doubles at the end.
        height and width exchanged: labels.shape[::-1] => labels.shape
            You lose corners on the right of the picture, because u is compared with the height. labels.shape is (H, W), but a point is (u, v): u belongs to W, and v to H.
        a larger radius: 10.0 => 20.0
            You merge two corners into one. Duplicates are at most 10 pixels apart.
        a smaller radius: 10.0 => 5.0
            You return several points for one corner. Duplicates can be up to 10 pixels apart.
        a radius of 8: 10.0 => 8.0
            Your radius is too small, so you return two points for one corner. Duplicates can be up to 10 pixels apart.
        a run of 6: erase_background(labels) => erase_background(labels, 6)
            You erase with a run of fewer than 7 green pixels, so a line that is too near the background is kept. Use a run of 7, which is the default.
        a run of 8: erase_background(labels) => erase_background(labels, 8)
            You erase with a run of more than 7 green pixels, so a line just below the background is lost. Use a run of 7, which is the default.
        a reach of 4: segment_intersection(first, second) => segment_intersection(first, second, 4.0)
            You extend the segments by fewer than 5 pixels. Use segment_intersection with its default reach.
        a reach of 10: segment_intersection(first, second) => segment_intersection(first, second, 10.0)
            You extend the segments by more than 5 pixels. Use segment_intersection with its default reach.
        ends of segments: max_line_gap, min_line_length) => max_line_gap, min_line_length)
            + return remove_doubles(segments.reshape(-1, 2), 10.0)
            Your points are the ends of segments. A corner is a point where two segments meet.
        values not handed on: , max_line_gap, min_line_length) => )
            Your result does not depend on max_line_gap and min_line_length. Pass both to hough_segments.
        values not handed on, outside kept: , max_line_gap, min_line_length) => )
            points[inside] => points
            Your code has two errors. It does not pass max_line_gap and min_line_length to hough_segments, and it keeps crossings outside the picture.
        gap and length swapped: max_line_gap, min_line_length) => min_line_length, max_line_gap)
            max_line_gap and min_line_length are swapped in your call of hough_segments.
        unbounded lines: segment_intersection(first, second) => segment_intersection(first, second, np.inf)
            You return crossings that are more than 5 pixels beyond the end of a segment. Use segment_intersection with its default reach.
        None kept: [each for each in meetings if each is not None] => [(each[0], each[1]) for each in meetings]
            segment_intersection returns None for most pairs, and you use None as a point. Keep a result only if `point is not None`.
        None in the array: np.array([each for each in meetings if each is not None]) => np.array(meetings)
            ((points >= 0) & (points < labels.shape[::-1])).all(axis=1) => slice(None)
            You make an array of points and None, which segment_intersection returns for two segments that do not meet. Append a point only `if point is not None`.
        None as a condition: each is not None => each
            segment_intersection returns a point or None, and an array of two numbers is neither true nor false. Write `if point is not None`.
        None asked: each is not None => each.any()
            segment_intersection returns None for most pairs, and None has no .any(). Test whether `point is not None`.
        pairs by their second segment
            [(first, second) for i, first in enumerate(segments) for second in segments[i + 1 :]] => [(first, second) for i, second in enumerate(segments) for first in segments[:i]]
            Your pairs come in another order: all pairs that end in the second segment, then all that end in the third. The order decides which of several near crossings is kept. Pair the first segment with all later ones, then the second with all later ones, and so on.
        pairs from the last: segments[i + 1 :]] => segments[i + 1 :]][::-1]
            Of several near crossings you keep the last, or your pairs start with the last segments. Pair the first segment with all later ones, then the second, and give the crossings to remove_doubles in this order.
        (row, column): 10.0) => 10.0)[:, ::-1]
            Your points are (v, u). A point is (u, v), the column first.
        no shape: 10.0) => 10.0) if inside.any() else np.array([])
            If there is no corner, np.array([]) has shape (0,). Use .reshape(-1, 2) to get (0, 2).
        no shape before the test: .reshape(-1, 2) =>
            inside = ((points >= 0) & (points < labels.shape[::-1])).all(axis=1) => inside = (points[:, 0] >= 0) & (points[:, 1] >= 0) & (points < labels.shape[::-1]).all(axis=1)
            If there are no crossings, np.array([]) has shape (0,), so [:, 0] fails. Use .reshape(-1, 2) before you remove crossings outside the picture.
    """),
    alternatives={
        "the alternatives of all steps": _corners,
        "each crossing judged when it is found": _corners_as_they_come,
        "every pair twice": _corners_of_all_pairs,
    },
    equivalents={
        "inside = ((points >= 0) * (points < labels.shape[::-1])).all(axis=1)": "a product is a logical and",
        "inside = ((points >= 0) // (points < labels.shape[::-1])).all(axis=1)": "of whole numbers 0 and 1, only 1 // 1 is 1",
        "points = np.array([each for each in meetings if each is not None]).reshape(~1, 2)": "NumPy computes any negative dimension",
        "points = np.array([each for each in meetings if each is not None]).reshape(-2, 2)": "NumPy computes any negative dimension",
        "inside = ((points > 0) & (points < labels.shape[::-1])).all(axis=1)": "a crossing on the picture's very edge: rounding decides",
        "inside = ((points >= 0) & (points <= labels.shape[::-1])).all(axis=1)": "a crossing on the picture's very edge: rounding decides",
        "meetings = [segment_intersection(second, first) for first, second in pairs]": "the crossing does not depend on the order of the two",
        _pairs("i + 1:", "(second, first)"): "the crossing does not depend on the order of the two",
        **{
            _pairs(others): "a segment is parallel to itself, and a crossing found twice is a duplicate"
            for others in (
                "i:",
                ":",
                "1:",
                *(f"i {sign} 1:" for sign in ("*", "//", "%", "**", ">>", "|", "&", "^")),
                "i + 0:",
            )
        },
    },
)


# --- 3.7 merge_edges ---
def _merge_axes(segments: Array, max_width: float = 20.0) -> Array:
    """Rotate each segment onto the u axis, so that the conditions on the second edge become intervals."""
    merged = []
    for first, second in combinations(segments, 2):
        angle = np.arctan2(first[3] - first[1], first[2] - first[0])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        level = (second.reshape(2, 2) - first[:2]) @ turn
        length = np.hypot(*(first[2:] - first[:2]))
        tilt = np.arctan2(*(level[1] - level[0])[::-1])
        offset = level[:, 1].mean()
        if abs(np.sin(tilt)) >= PARALLEL or not 1 <= abs(offset) <= max_width:
            continue
        low, high = level[:, 0].min(), level[:, 0].max()
        if high < 0 or low > length:
            continue
        ends = np.array([[min(low, 0.0), offset / 2], [max(high, length), offset / 2]])
        merged.append((ends @ turn.T + first[:2]).ravel())
    return np.array(merged).reshape(-1, 4)


def _merge_complex(segments: Array, max_width: float = 20.0) -> list[list[float]] | Array:
    """Write pixels as complex numbers: a division by the direction gives the coordinates along and across at once."""
    ends = [(complex(a, b), complex(c, d)) for a, b, c, d in segments]
    merged = []
    for (p, p_end), (q, q_end) in combinations(ends, 2):
        way = (p_end - p) / abs(p_end - p)
        if abs(((q_end - q) / way).imag) >= PARALLEL * abs(q_end - q):
            continue
        start, end = (q - p) / way, (q_end - p) / way
        across = (start.imag + end.imag) / 2
        along = sorted((start.real, end.real))
        if 1 <= abs(across) <= max_width and along[0] <= abs(p_end - p) and along[1] >= 0:
            both = [
                p + complex(u, across / 2) * way for u in (min(0, along[0]), max(along[1], abs(p_end - p)))
            ]
            merged.append([both[0].real, both[0].imag, both[1].real, both[1].imag])
    return merged or np.zeros((0, 4))


def _merge_table(segments: Array, max_width: float = 20.0) -> Array:
    """Merge all pairs at once, in float32, with both ends of each result exchanged."""
    first, second = (segments[each] for each in np.triu_indices(len(segments), 1))
    d, e = first[:, 2:] - first[:, :2], second[:, 2:] - second[:, :2]
    n = np.hypot(d[:, 0], d[:, 1])
    d = d / n[:, None]
    w = second.reshape(-1, 2, 2) - first[:, None, :2]
    along = (w * d[:, None]).sum(axis=2)
    across = (d[:, :1] * w[..., 1] - d[:, 1:] * w[..., 0]).mean(axis=1)
    angle = np.abs(d[:, 0] * e[:, 1] - d[:, 1] * e[:, 0]) / np.hypot(e[:, 0], e[:, 1])
    good = (angle < PARALLEL) & (abs(across) >= 1) & (abs(across) <= max_width)
    good &= (along.max(axis=1) >= 0) & (along.min(axis=1) <= n)
    centre = first[:, :2] + across[:, None] / 2 * np.column_stack([-d[:, 1], d[:, 0]])
    far, near = np.maximum(along.max(axis=1), n), np.minimum(along.min(axis=1), 0)
    return np.hstack([centre + far[:, None] * d, centre + near[:, None] * d])[good].astype(np.float32)


def _several(*each: tuple[float, float, float, float]) -> Array:
    return np.array(each, dtype=float).reshape(-1, 4)


def _merge_public() -> list[Case]:
    level = (10, 20, 50, 20)
    return [
        Case((_several(level, (20, 26, 60, 26)), 20.0), "two edges of one line, 6 px apart"),
        Case(
            (_several(level, (60, 14, 20, 14)), 20.0),
            "the second edge above the first, in the other direction",
        ),
        Case((_several((10, 10, 40, 50), (18, 4, 48, 44)), 20.0), "two edges of a slanted line"),
        Case((_several(level, (30, 5, 30, 60)), 20.0), "two segments at a right angle"),
        Case((_several(level, (30, 22, 34, 42)), 20.0), "a short segment across a long one"),
        Case((_several(level, (10, 46, 50, 46)), 20.0), "parallel segments 26 px apart"),
        Case((_several(level, (10, 46, 50, 46)), 30.0), "the same, with lines up to 30 px wide"),
        Case((_several(level, (10, 34, 50, 34)),), "parallel segments 14 px apart, with the default width"),
        Case((_several(level, (10, 43, 50, 43)),), "parallel segments 23 px apart, with the default width"),
        Case((_several(level, (70, 26, 110, 26)), 20.0), "parallel segments that do not overlap"),
        Case((_several((70, 26, 110, 26), level), 20.0), "the same in the other order"),
        Case((_several(level, (20, 20.5, 70, 20.5)), 20.0), "two segments on the same edge"),
        Case((_several(level, (12, 24, 48, 28)), 20.0), "edges that are 6 degrees apart"),
        Case((_several(level, (12, 24, 48, 32)), 20.0), "segments that are 12.5 degrees apart"),
        Case(
            (_several(level, (15, 60, 70, 62), (12, 26, 40, 26), (90, 10, 90, 60)), 20.0),
            "a line and two other segments",
        ),
        Case((_several(level, (10, 26, 28, 26), (33, 26, 50, 26)), 20.0), "one edge in two segments"),
        Case((_several(level, (40, 14, 22, 14)), 20.0), "a shorter second edge in the other direction"),
        Case((_several(level, (40, 26, 0, 26)), 20.0), "the second edge in the other direction, to the left"),
        Case((_several(level, (20, 26, 60, 26), (5, 34, 45, 34)), 20.0), "three parallel segments"),
        Case((_several((10, 20, 90, 20), (30, 24, 60, 24)), 20.0), "a long and a short edge"),
        Case((_several((20, 20, 60, 20), (10, 26, 80, 26)), 20.0), "a short and a long edge"),
        Case((_several((10, 50, 60, 50), (40, 60, 40, 20)), 20.0), "a right angle, the second one upwards"),
        Case((_several((10, 20, 13, 20), (10, 22, 13, 22)), 20.0), "two edges of 3 px"),
        Case((_several(level, (12, 25, 48, 27)), 20.0), "edges that are 3 degrees apart"),
        Case((_several((0, 0, 100, 0), (0, 15, 100, 23)), 20.0), "one end 15 px away, the other 23 px"),
        Case((_several(level, (12, 18, 48, 23)), 20.0), "segments that cross at 8 degrees"),
        Case((_several(level, (20, 21.4, 70, 21.4)), 20.0), "edges that are 1.4 px apart"),
        Case((_several(level), 20.0), "a single segment"),
        Case((np.zeros((0, 4)), 20.0), "no segments"),
    ]


def _merge_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for width in (20.0, 12.0, 20.0, 30.0, 20.0, 20.0, 8.0, 20.0):
        lines = []
        for _ in range(4):
            angle, start, length = rng.uniform(0, 2 * np.pi), rng.uniform(60, 240, 2), rng.uniform(40, 100)
            way = np.array([np.cos(angle), np.sin(angle)])
            aside = rng.choice([-1, 1]) * rng.uniform(2, 0.9 * width) * np.array([-way[1], way[0]])
            other = start + aside + rng.uniform(-20, 20) * way
            bent = angle + rng.uniform(-0.05, 0.05)
            lines.append((*start, *(start + length * way)))
            end = other + length * np.array([np.cos(bent), np.sin(bent)])
            lines.append((*end, *other) if rng.random() < 0.5 else (*other, *end))
        cases.append(Case((np.array(lines), width)))
    u, v = rng.uniform(20, 60, 2)
    level = (u, v, u + 50, v)
    pairs = [
        *((u, v + aside, u + 50, v + aside) for aside in (0.7, -0.7, 1.3, -1.3, 19.6, -19.6, 20.4, -20.4)),
        *((u + far, v + 5, u + far + 40, v + 5) for far in (-40.5, -39.5, 49.5, 50.5)),
        *((u, v + 12 - up, u + 50, v + 12 + up) for up in (4.1, 4.7, -4.1, -4.7)),  # 9.3 and 10.6 degrees
        (u + 10, v + 2, u + 14, v + 14),
        (u + 40, v - 6, u + 12, v - 6),
        (u + 30, v + 10, u + 30, v - 28),
        (u + 30, v - 28, u + 30, v + 10),
        (u - 10, v + 6, u + 70, v + 6),
        (u, v + 17, u + 50, v + 22),
        (u, v - 2, u + 50, v + 3),
    ]
    cases += [Case((_several(level, pair),)) for pair in pairs]
    cases.append(Case((_several(level, (u + 8, v + 6, u + 58, v + 6), (u - 5, v + 14, u + 40, v + 14)),)))
    return [*cases, Case((_several(level), 20.0)), Case((np.zeros((0, 4)), 20.0))]


MERGE_EDGES = Exercise(
    name="merge_edges",
    points=5,
    stars=3,
    public=_merge_public,
    hidden=_merge_hidden,
    comparison=Segments(tolerance=0.5, share=0.99),
    hints=(
        "Use coordinates along and across the first segment. With the vectors A and B of the exercise, an end of the second segment is at A . B along the first and at A x B across it. Both segments then become intervals, and the average of the second one's two values across says how far away it is.",
        "The centre line starts at min(0, smallest along) and ends at max(length, largest along). Add half of the average offset across, times the vector (-A_v, A_u), which is perpendicular to A. The sine of the angle is the difference of the two values across, divided by the length of the second segment.",
    ),
    sibling=Sibling(
        "A ship is described along and across a straight route, as the ends of the second segment are along and across the first: by a dot product with the unit vector, and by a cross product, whose sign shows the side.",
        """
        import numpy as np

        harbour, island = np.array([1.0, 2.0]), np.array([4.0, 6.0])
        unit = (island - harbour) / np.linalg.norm(island - harbour)
        for ship in ([4.0, 5.0], [0.0, 7.0]):
            offset = ship - harbour
            along, across = unit @ offset, unit[0] * offset[1] - unit[1] * offset[0]
            nearest = harbour + along * unit
            print(f"{along:.1f} km along, {across:.1f} km across, nearest point {nearest.round(1)}")
        """,
        """
        4.2 km along, -0.6 km across, nearest point [3.5 5.4]
        3.4 km along, 3.8 km across, nearest point [3.  4.7]
        """,
    ),
    mistakes=catalogue("""
        single edges kept: np.array(merged) => np.array([*segments, *merged])
            You also return the segments themselves. Return centre lines only: a segment without a second edge is dropped.
        on the second edge: across.mean() / 2 => across.mean()
            Your line is on the second edge. Move the first segment by half of the distance only.
        on the first edge: across.mean() / 2 => 0
            Your line is still on the first edge. Move it by half of the distance towards the second.
        on the wrong side: np.array([-d[1], d[0]]) => np.array([d[1], -d[0]])
            Your line is on the side of the first segment where there is no second edge. The vector (-A_v, A_u) points to the side where A x B is positive.
        distance without a sign: across.mean() / 2 => abs(across.mean()) / 2
            Your line is on the wrong side if the second edge lies on the other side of the first. The sign of the distance says which side it is: take the absolute value only to compare it with 1 and max_width.
        ends averaged: [*(centre + min(0, along.min()) * d), *(centre + max(length, along.max()) * d)] => [*((p + q[0]) / 2), *((end + q[1]) / 2)]
            You average the ends of the two segments. The second segment may run the other way, and one of the two may be longer. Keep the direction of the first segment, and extend it from the first end of the two to the last.
        ends averaged in one direction: [*(centre + min(0, along.min()) * d), *(centre + max(length, along.max()) * d)] => [*((p + q[along.argmin()]) / 2), *((end + q[along.argmax()]) / 2)]
            You average the ends of both segments, so your line is too short if one of them begins or ends farther away. Move the first segment sideways, and extend it from the first end of the two to the last.
        not perpendicular: - d[1] * (q - p)[:, 0] => + d[1] * (q - p)[:, 0]
            np.array([-d[1], d[0]]) => np.array([d[1], d[0]])
            You measure across the segment with (A_v, A_u), which is not perpendicular to it. One sign must change: (-A_v, A_u).
        along from the picture's corner: along, across = (q - p) @ d => along, across = q @ d
            You measure the positions along the first segment from the picture's corner (0, 0). Measure them from the start P of the first segment: A . B, where B goes from P to an end of the second.
        across from the picture's corner: d[0] * (q - p)[:, 1] - d[1] * (q - p)[:, 0] => d[0] * q[:, 1] - d[1] * q[:, 0]
            You measure the distances across from a line through the picture's corner (0, 0). In A x B, the vector B begins at the start P of the first segment: subtract P first.
        both from the picture's corner: (q - p) @ d, d[0] * (q - p)[:, 1] - d[1] * (q - p)[:, 0] => q @ d, d[0] * q[:, 1] - d[1] * q[:, 0]
            You use the ends of the second segment themselves in place of B, so both of your values are measured from the picture's corner (0, 0). B begins at the start P of the first segment.
        one end's distance: across.mean() =>> across[0]
            You use the distance of one end of the second segment. Take the average of both ends.
        no absolute value: abs(across[1] - across[0]) < => across[1] - across[0] <
            You join segments that meet at a large angle. The difference of the two values across is negative if the second segment turns the other way, so take its absolute value.
        sine of 10 radians: np.sin(np.radians(10)) => np.sin(10)
            np.sin(10) is the sine of 10 radians, which is negative, so no two segments are parallel for you. Use np.sin(np.radians(10)).
        five degrees: np.sin(np.radians(10)) => np.sin(np.radians(5))
            You miss edges that are more than 5 degrees apart. Less than 10 degrees counts as parallel.
        pixels for a sine: np.sin(np.radians(10)) * np.hypot(*(q[1] - q[0])) => np.sin(np.radians(10))
            You compare a length in pixels with the sine of 10 degrees. Divide it by the length of the second segment first.
        one direction only: if parallel and => if parallel and (q[1] - q[0]) @ d > 0 and
            You miss a second edge that runs the other way: its angle to the first is near 180 degrees. Use the sine of the angle, or the absolute value of its cosine.
        start and end not sorted: along.max() >= 0 and along.min() <= length => along[1] >= 0 and along[0] <= length
            min(0, along.min()) => min(0, along[0])
            max(length, along.max()) => max(length, along[1])
            You take the first point of the second segment as its start along the line. The segment may run the other way: use the smaller and the larger of its two values along.
        start not sorted: min(0, along.min()) => min(0, along[0])
            Your line begins too late. A second segment that runs the other way ends where its smaller value along is: extend the first segment to the smaller of both values.
        end not sorted: max(length, along.max()) => max(length, along[1])
            Your line ends too early. A second segment that runs the other way begins where its larger value along is: extend the first segment to the larger of both values.
        as long as the second: min(0, along.min()) => along.min()
            max(length, along.max()) => along.max()
            Your line is as long as the second segment. It must extend from the first end of the two to the last.
        one partner only: merged.append( => merged.append(
            + break
            You stop at the first partner of a segment. A segment can be paired with several others: take every pair.
        the farther end: 1 <= abs(across.mean()) <= max_width => 1 <= abs(across.mean()) and abs(across).max() <= max_width
            You compare the farther end of the second segment with max_width. Compare the average of both ends.
        an end beside the first: along.max() >= 0 and along.min() <= length => (0 <= along[0] <= length or 0 <= along[1] <= length)
            You miss a second segment that is longer than the first at both ends. The two overlap if the larger value along is at least 0 and the smaller one at most the length of the first.
        at least two pixels: 1 <= => 2 <=
            You miss edges that are between 1 and 2 pixels apart. The lower limit is 1 pixel.
        a quarter of the way: across.mean() / 2 => across.mean() / 4
            You move the first segment by a quarter of the distance. Move it by half of the average.
        one side only: abs(across.mean()) => across.mean()
            You find the second edge on one side of the first segment only. Compare the absolute value of the distance.
        any width: <= max_width => <= 1e9
            You join segments that are too far apart to be the edges of one line. Their distance is at most max_width.
        twenty whatever max_width is: <= max_width => <= 20
            You always use a width of 20 pixels. Use the argument max_width.
        the same edge: 1 <= => 0 <=
            You join two segments on the same edge. The two edges of a line are at least 1 pixel apart.
        not side by side: and along.max() >= 0 and along.min() <= length =>
            You join parallel segments that do not overlap along the line. The two edges of one line lie beside each other.
        overlap only: min(0, along.min()) => max(0, along.min())
            max(length, along.max()) => min(length, along.max())
            Your line covers only the part that both segments share. It must extend from the first end of the two to the last.
        as long as the first: min(0, along.min()) => 0
            max(length, along.max()) => length
            Your line is as long as the first segment. It must extend from the first end of the two to the last.
        three at once: min(0, along.min()) => 0
            max(length, along.max()) => length
            if parallel and 1 => if parallel and (q[1] - q[0]) @ d > 0 and 1
            and along.max() >= 0 and along.min() <= length =>
            Your code has three errors. Your line is as long as the first segment, but it must extend from the first end of the two to the last. You miss second edges that run the other way: use the absolute value of the cosine. And you join segments that do not overlap along the line.
        not parallel: parallel and 1 => 1
            You join segments at any angle. The two edges of a line are less than 10 degrees apart.
        direction not of length one: d = (end - p) / length => d = end - p
            Your direction has the length of the segment, so distances along and across are multiplied by it. Divide it by the length first.
        every pair twice: ends[i + 1 :] => np.delete(ends, i, axis=0)
            You use each pair twice, once from each segment. Take each pair once: the first segment with all later ones, then the second with all later ones.
        (row, column): np.array(merged).reshape(-1, 4) => np.array(merged).reshape(-1, 4)[:, [1, 0, 3, 2]]
            Your segments are (v1, u1, v2, u2). The order is (u1, v1, u2, v2), columns first.
        no shape: np.array(merged).reshape(-1, 4) => np.array(merged)
            If there is no centre line, np.array([]) has shape (0,). Use .reshape(-1, 4) to get (0, 4).
        absolute values averaged: 1 <= abs(across.mean()) => 1 <= abs(across).mean()
            You average the distances of both ends without their signs. Average them with their signs first, and take the absolute value last.
        absolute values averaged, also for the position: 1 <= abs(across.mean()) => 1 <= abs(across).mean()
            across.mean() / 2 => abs(across).mean() / 2
            You average the distances of both ends without their signs, so your line is always on the same side of the first segment. Average them with their signs, and take the absolute value only to compare it with 1 and max_width.
        each segment in one pair: + used = set()
            for q in ends[i + 1 :]: => for j, q in enumerate(ends[i + 1 :], i + 1):
            if parallel and => if not used & {i, j} and parallel and
            merged.append( => merged.append(
            + used |= {i, j}
            You use each segment once only. A segment can be paired with several others: take every pair.
    """),
    alternatives={
        "the first segment turned into an axis": _merge_axes,
        "complex numbers": _merge_complex,
        "all pairs at once": _merge_table,
    },
    equivalents={
        **{
            f"for q in ends[{others}:]:": "a segment lies 0 px from itself, so it is never its own second edge"
            for others in ("i", "i + 0", "i * 1", "i // 1", "i ** 1", "i | 1")
        },
        **{
            f"if parallel and 1 {low} abs(across.mean()) {high} max_width and (along.max() {right} 0) and (along.min() {left} length):": "exactly at a limit: rounding decides"
            for low, high, right, left in (
                ("<", "<=", ">=", "<="),
                ("<=", "<", ">=", "<="),
                ("<=", "<=", ">", "<="),
                ("<=", "<=", ">=", "<"),
            )
        },
        "parallel = abs(across[1] - across[0]) <= np.sin(np.radians(10)) * np.hypot(*q[1] - q[0])": "exactly 10 degrees apart: rounding decides",
        "parallel = abs(across[1] - across[0]) < np.radians(10) * np.hypot(*q[1] - q[0])": "10 degrees or 10.05: no case can ask for that",
        "parallel = abs(across[0] - across[1]) < np.sin(np.radians(10)) * np.hypot(*q[1] - q[0])": "an absolute value has no sign",
        "parallel = abs(across[1] - across[0]) < np.sin(np.radians(10)) * np.hypot(*q[0] - q[1])": "a length has no direction",
        "length = np.hypot(*p - end)": "a length has no direction",
        "merged, ends = ([], segments.reshape(~1, 2, 2))": "NumPy computes any negative dimension",
        "merged, ends = ([], segments.reshape(-2, 2, 2))": "NumPy computes any negative dimension",
        "return np.array(merged).reshape(~1, 4)": "NumPy computes any negative dimension",
        "return np.array(merged).reshape(-2, 4)": "NumPy computes any negative dimension",
        "merged.extend([*centre + min(0, along.min()) * d, *centre + max(length, along.max()) * d])": "a flat list of numbers has the same rows of four",
        "merged.append([*centre + max(length, along.max()) * d, *centre + min(0, along.min()) * d])": "a segment may start at either end",
        "merged.append([*centre + min(along.min(), 0) * d, *centre + max(length, along.max()) * d])": "the order of two numbers does not change their minimum",
        "merged.append([*centre + min(0, along.min()) * d, *centre + max(along.max(), length) * d])": "the order of two numbers does not change their maximum",
    },
)


PLAN = LessonPlan(
    exercises=[
        LINE_PICTURE,
        ERASE_BACKGROUND,
        HOUGH_SEGMENTS,
        SEGMENT_INTERSECTION,
        REMOVE_DUPLICATES,
        FIND_CORNERS,
        MERGE_EDGES,
    ],
    questions=[
        Question(
            "why_two_edges",
            "Canny marks the edges of one white line that is well in view. At least how many segments does the Hough transform find along this line?",
            {
                "One, along the centre of the line.": "There is no edge along the centre, because all pixels inside the line are alike. Canny marks the border between white and green.",
                "Two, one along each side.": "White begins at one side and ends at the other, and both are edges. A corner of two lines can therefore have four crossings, about a line's width apart.",
                "None, because a line is too wide for Hough.": "Hough counts edge pixels that lie on one straight line. The distance between the two sides does not matter.",
            },
            "Two, one along each side.",
        ),
        Question(
            "why_report_little",
            "A hit counts -1.333, a false corner 5 and a missed one 1. A detector has found some points, and 60 % of them are true corners. Is its cost lower if it reports them all or if it reports nothing?",
            {
                "It should report them, because most of them are true.": "Most are true, but the two kinds of outcome do not cost the same. Ten points contain six hits, and each lowers the cost by 2.333 because it also removes a miss: 14.0 in total. The four false corners raise it by 20.",
                "It should report nothing, because the false ones cost more than all the hits gain.": "Of ten points, six are hits. Each lowers the cost by 2.333, because a miss disappears as well: 14.0 in total. The four false corners raise it by 20. The two sides balance at a precision of 5 / 7.333, which is 68 %.",
                "It should report nothing, whatever the precision: a false corner always costs more than a hit gains.": "One false corner does cost more than one hit gains, but the numbers of both count. At a precision of 80 %, ten points lower the cost by 8 x 2.333 = 18.7 and raise it by 10, so reporting pays.",
                "That depends on how many corners it misses.": "A corner that the detector does not find costs 1 whether the other points are reported or not, so it does not affect the decision.",
            },
            "It should report nothing, because the false ones cost more than all the hits gain.",
        ),
        Question(
            "where_corners_go",
            "Your detector of exercise 3.6 finds 14 of 61 corners. Which step loses most of the others?",
            {
                "Labels: there is no white pixel at the corner.": "All 61 corners have a white pixel within 3 pixels.",
                "Erasing: the corner is removed with the background.": "Erasing loses 12 corners. A later step loses twice as many.",
                "Segments: one of the two lines gives no segment.": "37 corners have a segment near them, but only 12 have two segments that are not parallel. The other 25 lack the second one.",
                "Crossings: both lines have a segment, but the segments end too early.": "Only 12 corners have two segments near them that are not parallel, so at most 12 can be lost here.",
            },
            "Segments: one of the two lines gives no segment.",
        ),
    ],
    written=[
        Written(
            "explain_null_baseline",
            points=2,
            question="The paper's best setting has a mean cost of 2.122 over thirty pictures. The paper does not say how many corners are in them. What can you conclude about the detector from 2.122 alone, what else do you need to know, and why?",
            rubric="1 point: nothing can be concluded from 2.122 alone. Reporting nothing costs 1 for each corner, so its mean cost is the mean number of corners in a picture; the detector is better than nothing if that number is above 2.122, and worse if it is below. 1 point: besides the cost of nothing on the same pictures, the uncertainty of the difference is needed (its variation from picture to picture, or its confidence interval); with thirty pictures the interval can contain 0, as in this lesson. An answer that asks for the numbers of hits and false corners instead of the interval also gets the second point if it says that the same mean can come about in different ways.",
        )
    ],
)
