"""Lesson 01, HSL filtering: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

import colorsys
from itertools import count
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.exercises import Case, Close, Exact, Exercise, LessonPlan, Mistake, Question, Sampled, Written

Array = npt.NDArray[Any]


# --- pictures and hues to try things on ---


def picture(rng: np.random.Generator, rows: int, columns: int) -> Array:
    """A picture of patches that look like grass, goal, line, shadow, wall and nothing in particular."""
    colours = np.array(
        [(60, 130, 70), (85, 145, 88), (205, 190, 45), (250, 251, 249), (20, 22, 21), (150, 150, 150)]
    )
    kinds = rng.integers(0, len(colours) + 1, (rows, columns))
    noisy = np.append(colours, [[0, 0, 0]], axis=0)[kinds] + rng.integers(-14, 15, (rows, columns, 3))
    anything = rng.integers(0, 256, (rows, columns, 3))
    return np.clip(np.where((kinds == len(colours))[..., None], anything, noisy), 0, 255).astype(np.uint8)


def primaries() -> Array:
    """The corners of the colour cube, some greys, and pinks whose hue is just below 360 degrees."""
    rows = [
        [(255, 0, 0), (255, 255, 0), (0, 255, 0), (0, 255, 255)],
        [(0, 0, 255), (255, 0, 255), (0, 0, 0), (255, 255, 255)],
        [(128, 128, 128), (200, 10, 60), (255, 0, 30), (130, 90, 110)],
    ]
    return np.array(rows, dtype=np.uint8)


def hues(rng: np.random.Generator, middle: float, width: float, size: tuple[int, int]) -> Array:
    """Hues in half degrees about a middle, on the circle."""
    return np.round(2 * (middle + rng.uniform(-width, width, size))) / 2 % 360


# --- 1.1 rgb_to_hsl ---


def _hsl(picture: Array, **changed: Any) -> tuple[Array, Array, Array]:
    """The conversion, with one thing done in another way."""
    rgb = picture.astype(float) / 255
    red, green, blue = rgb[..., 0], rgb[..., 1], rgb[..., 2]
    top, bottom = rgb.max(axis=2), rgb.min(axis=2)
    spread = top - bottom
    safe = np.where(spread == 0, 1, spread)
    hue = np.where(
        top == red,
        (green - blue) / safe,
        np.where(top == green, 2 + (blue - red) / safe, 4 + (red - green) / safe),
    )
    hue = np.where(spread == 0, 0, 60 * hue)
    if not changed.get("negative"):
        hue = hue % 360
    lightness = (top + bottom) / 2
    room = 1 - np.abs(2 * lightness - 1)
    saturation = np.where(spread == 0, 0, spread / np.where(room == 0, 1, room))
    if changed.get("hsv"):
        saturation = spread / np.where(top == 0, 1, top)
        lightness = top
    if changed.get("luma"):
        lightness = rgb @ [0.299, 0.587, 0.114]
    if changed.get("half"):
        hue = hue / 2
    return hue, saturation, lightness * (1.0 if changed.get("unit") else 255.0)


def _no_red_line(picture: Array) -> tuple[Array, Array, Array]:
    """The scaffold's two lines alone."""
    _, saturation, lightness = _hsl(picture)
    red, green, blue = np.moveaxis(picture / 255, -1, 0)
    top, bottom = picture.max(axis=2) / 255, picture.min(axis=2) / 255
    spread = np.where(top > bottom, top - bottom, 1.0)
    by_green, by_blue = 2 + (blue - red) / spread, 4 + (red - green) / spread
    return 60 * np.where(green == top, by_green, by_blue) % 360, saturation, lightness


def _overflow(picture: Array) -> tuple[Array, Array, Array]:
    hue, saturation, _ = _hsl(picture)
    return hue, saturation, ((picture.max(axis=2) + picture.min(axis=2)) // 2).astype(float)


def _grey_nan(picture: Array) -> tuple[Array, Array, Array]:
    hue, saturation, lightness = _hsl(picture)
    grey = picture.max(axis=2) == picture.min(axis=2)
    hue[grey] = np.nan
    saturation[grey & np.isin(lightness, (0.0, 255.0))] = np.nan
    return hue, saturation, lightness


def _two_at_once(picture: Array) -> tuple[Array, Array, Array]:
    """No modulo, and 0 divided by 0 where a pixel is grey."""
    _, saturation, lightness = _grey_nan(picture)
    return _hsl(picture, negative=True)[0], saturation, lightness


def _two_at_once_in_grey(picture: Array) -> tuple[Array, Array, Array]:
    """The same without the scaffold's divisor: a grey pixel's hue is 0 / 0, too."""
    _, saturation, lightness = _grey_nan(picture)
    grey = picture.max(axis=2) == picture.min(axis=2)
    return np.where(grey, np.nan, _hsl(picture, negative=True)[0]), saturation, lightness


def _divisor_above(picture: Array) -> tuple[Array, Array, Array]:
    hue, saturation, lightness = _hsl(picture)
    return hue, np.where(picture.max(axis=2) == picture.min(axis=2), 1.0, saturation), lightness


def _divisor_above_and_nothing_below(picture: Array) -> tuple[Array, Array, Array]:
    hue, saturation, lightness = _hsl(picture)
    grey = picture.max(axis=2) == picture.min(axis=2)
    room = 1 - np.abs(2 * lightness / 255 - 1)
    with np.errstate(divide="ignore"):
        return hue, np.where(grey, 1.0 / room, saturation), lightness


def _hue_divisor(picture: Array) -> tuple[Array, Array, Array]:
    hue, saturation, lightness = _hsl(picture)
    return hue, (saturation > 0).astype(float), lightness


def _grey_blue(picture: Array) -> tuple[Array, Array, Array]:
    hue, saturation, lightness = _hsl(picture)
    return np.where(picture.max(axis=2) == picture.min(axis=2), 240.0, hue), saturation, lightness


def _divided_by_nothing(picture: Array) -> tuple[Array, Array, Array]:
    hue, saturation, lightness = _hsl(picture)
    return hue, np.where(np.isin(lightness, (0.0, 255.0)), np.nan, saturation), lightness


def _hsv_saturation(picture: Array) -> tuple[Array, Array, Array]:
    hue, _, lightness = _hsl(picture)
    return hue, _hsl(picture, hsv=True)[1], lightness


def _mean_of_three(picture: Array) -> tuple[Array, Array, Array]:
    return *_hsl(picture)[:2], picture.astype(float).mean(axis=2)


def _bytes_subtracted(picture: Array) -> tuple[Array, Array, Array]:
    red, green, blue = picture[..., 0], picture[..., 1], picture[..., 2]
    top, spread = picture.max(axis=2), picture.max(axis=2) - picture.min(axis=2)
    safe = np.where(spread == 0, 1, spread)
    hue = np.where(
        top == red,
        (green - blue) / safe,
        np.where(top == green, 2 + (blue - red) / safe, 4 + (red - green) / safe),
    )
    return np.where(spread == 0, 0.0, 60 * hue % 360), *_hsl(picture)[1:]


def _opencv_bytes(picture: Array) -> tuple[Array, Array, Array]:
    hls = cv2.cvtColor(picture, cv2.COLOR_RGB2HLS)
    return hls[..., 0], hls[..., 1], hls[..., 2]


def _opencv_order(picture: Array) -> tuple[Array, Array, Array]:
    hue, saturation, lightness = _hsl(picture)
    return hue, lightness, saturation


def _hsl_loop(picture: Array) -> tuple[Array, Array, Array]:
    out = np.zeros((3, *picture.shape[:2]))
    for i in range(picture.shape[0]):
        for j in range(picture.shape[1]):
            h, l, s = colorsys.rgb_to_hls(*(float(c) / 255 for c in picture[i, j]))  # noqa: E741
            out[:, i, j] = h * 360, s, l * 255
    return out[0], out[1], out[2]


def _hsl_opencv(picture: Array) -> tuple[Array, Array, Array]:
    hls = cv2.cvtColor(picture.astype(np.float32) / 255, cv2.COLOR_RGB2HLS)
    return hls[..., 0], hls[..., 2], hls[..., 1] * 255


def _hsl_float32(picture: Array) -> tuple[Array, Array, Array]:
    hue, saturation, lightness = _hsl(picture)
    return hue.astype(np.float32), saturation.astype(np.float32), lightness.astype(np.float32)


RGB_TO_HSL = Exercise(
    name="rgb_to_hsl",
    points=2,
    stars=1,
    public=lambda: [
        Case((primaries(),), "pure colours and greys"),
        Case((picture(np.random.default_rng(11), 8, 10),), "a picture"),
    ],
    hidden=lambda rng: [Case((primaries()[:, ::-1],)), *(Case((picture(rng, 24, 32),)) for _ in range(3))],
    comparison=Close(rtol=1e-3, atol=2e-3, names=("your hue", "your saturation", "your lightness")),
    hints=(
        "largest == red says where equation 1.3's first line holds. Write that line with divisor below the fraction, and take it there "
        "with np.where; elsewhere stay the sixths of the scaffold. Sixths of a circle are 60 degrees each.",
        "np.where(largest == red, ..., sixths), times 60, modulo 360. For the saturation, the denominator of equation 1.2 is 0 for black "
        "and white: np.where(grey, 1.0, ...) there, as in divisor.",
    ),
    mistakes=[
        Mistake(
            "half degrees",
            lambda picture: _hsl(picture, half=True),
            "Your hues are half of what they should be: OpenCV stores them in units of 2 degrees so that they fit into "
            "a byte. This course has degrees, 0 to 360.",
        ),
        Mistake(
            "OpenCV's order",
            _opencv_order,
            "Saturation and lightness have changed places. OpenCV's HLS has lightness second; here the order is hue, "
            "saturation, lightness.",
        ),
        Mistake(
            "luma",
            lambda picture: _hsl(picture, luma=True),
            "That is the luma, a weighted mean of the three channels. The lightness of HSL is halfway between the "
            "largest and the smallest channel.",
        ),
        Mistake(
            "uint8 overflow",
            _overflow,
            "Bright pixels come out dark: two bytes were added, and 200 + 200 is 144 in a byte. Turn the picture into "
            "floats before you calculate.",
        ),
        Mistake(
            "negative hue",
            lambda picture: _hsl(picture, negative=True),
            "Some hues are negative. Pinks lie just below 360 degrees: take the hue modulo 360.",
        ),
        Mistake(
            "the red line left out",
            _no_red_line,
            "Where red is the largest channel your hues are those of another line: the scaffold has the lines for green and blue, and "
            "the first line of equation 1.3, for M = r, is yours.",
        ),
        Mistake(
            "grey divided by zero",
            _grey_nan,
            "Some hues or saturations are NaN: for a grey pixel the largest and the smallest channel are equal, and you divide 0 by "
            "0. Grey gets hue 0 and saturation 0.",
        ),
        Mistake(
            "bytes subtracted",
            _bytes_subtracted,
            "Differences of the channels go wrong: 10 - 20 is 246 in a byte. Turn the picture into floats before you calculate.",
        ),
        Mistake(
            "OpenCV's bytes",
            _opencv_bytes,
            "That is OpenCV's conversion of bytes: hue in units of 2 degrees, then lightness, then saturation in 0..255. Here it is "
            "degrees, saturation in 0..1, lightness in 0..255, in this order.",
        ),
        Mistake(
            "blue first",
            lambda picture: _hsl(picture[..., ::-1]),
            "Red and blue have changed places. OpenCV reads files as blue, green, red; this course's pictures are red, green, blue.",
        ),
        Mistake(
            "radians",
            lambda picture: (np.radians(_hsl(picture)[0]), *_hsl(picture)[1:]),
            "Your hues are in radians. Hues are the one kind of angle that this course has in degrees, 0 to 360, as the field does.",
        ),
        Mistake(
            "no modulo, and 0 divided by 0",
            _two_at_once,
            "Two things. Some hues are negative: take the hue modulo 360. And the saturation of black and white is NaN: their divisor "
            "1 - |M + m - 1| is 0, so put a 1 there where a pixel is grey.",
        ),
        Mistake(
            "no modulo, and grey divided by zero",
            _two_at_once_in_grey,
            "Two things. Some hues are negative: take the hue modulo 360. And hues or saturations of grey pixels are NaN: you divide 0 "
            "by 0. The divisor of the scaffold has a 1 there, and equation 1.2 needs the like.",
        ),
        Mistake(
            "the scaffold's divisor in the numerator",
            _divisor_above,
            "Grey pixels have the saturation 1. In divisor a grey pixel has a 1, so that one can divide by it: it stands below the "
            "fraction of the hue. Above the fraction of equation 1.2 stands largest - smallest itself.",
        ),
        Mistake(
            "the scaffold's divisor in the numerator, and 0 below",
            _divisor_above_and_nothing_below,
            "Grey pixels have a saturation of 1 and more. In divisor a grey pixel has a 1, so that one can divide by it: above the "
            "fraction of equation 1.2 stands largest - smallest itself. Below it put a 1 where a pixel is grey.",
        ),
        Mistake(
            "the hue's divisor",
            _hue_divisor,
            "That is divided by divisor, M - m. The saturation has a denominator of its own: 1 - |M + m - 1|, equation 1.2.",
        ),
        Mistake(
            "60 forgotten",
            lambda picture: (_hsl(picture)[0] / 60, *_hsl(picture)[1:]),
            "Your hues go from 0 to 6: these are sixths of the circle. One sixth is 60 degrees.",
        ),
        Mistake(
            "grey is blue",
            _grey_blue,
            "Grey has the hue 0. Yours is that of another line of equation 1.3, for all three channels are the largest: look at red first.",
        ),
        Mistake(
            "black and white divided by zero",
            _divided_by_nothing,
            "Black and white: their divisor 1 - |M + m - 1| is 0. Put a 1 there, too, where a pixel is grey.",
        ),
        Mistake(
            "HSV's saturation",
            _hsv_saturation,
            "That is the saturation of HSV, (M - m) / M. HSL's is equation 1.2: (M - m) / (1 - |M + m - 1|).",
        ),
        Mistake(
            "the mean of three channels",
            _mean_of_three,
            "That is the mean of all three channels. The lightness of HSL is halfway between the largest and the smallest.",
        ),
        Mistake(
            "HSV",
            lambda picture: _hsl(picture, hsv=True),
            "That is HSV: its value is the largest channel and its saturation is relative to that. HSL's lightness is "
            "halfway between the largest and the smallest.",
        ),
        Mistake(
            "lightness in 0..1",
            lambda picture: _hsl(picture, unit=True),
            "Your lightness lies in 0..1. Equation 1.4 has 255 as its maximum, so this course's lightness "
            "goes from 0 to 255.",
        ),
    ],
    alternatives={
        "a loop with colorsys": _hsl_loop,
        "OpenCV in floats": _hsl_opencv,
        "float32": _hsl_float32,
    },
    equivalents={
        "grey = largest <= smallest": "a largest value is never below a smallest one",
        "sixths = np.where(largest <= green, 2 + (blue - red) / divisor, 4 + (red - green) / divisor)": "no channel is above the largest one, so at most it equals it",
        "sixths = np.where(largest <= red, (green - blue) / divisor, sixths)": "no channel is above the largest one, so at most it equals it",
        "divisor = np.where(grey, 2.0, largest - smallest)": "a grey pixel's numerators are 0, whatever they are divided by",
        "saturation = (largest - smallest) / np.where(grey, 2.0, 1 - np.abs(largest + smallest - 1))": "a grey pixel's spread is 0, whatever it is divided by",
        "largest = np.maximum(blue, np.maximum(red, green))": "the largest of three numbers does not depend on their order",
        "largest = np.maximum(np.maximum(green, red), blue)": "the largest of three numbers does not depend on their order",
        "smallest = np.minimum(blue, np.minimum(red, green))": "the smallest of three numbers does not depend on their order",
        "smallest = np.minimum(np.minimum(green, red), blue)": "the smallest of three numbers does not depend on their order",
        "saturation = (largest - smallest) / np.where(grey, 1.0, 1 - np.abs(1 - (largest + smallest)))": "an absolute value has no sign",
    },
)


# --- 1.2 average_lightness ---


def _sample(lightness: Array, n_samples: int, rng: np.random.Generator) -> float:
    return float(rng.choice(lightness.ravel(), n_samples).mean())


def _patchy(rng: np.random.Generator, rows: int, columns: int) -> Array:
    """A skewed picture, bright at its top: mean, median and first rows all differ."""
    light = rng.uniform(0, 90, (rows, columns))
    light[: rows // 4] = rng.uniform(180, 255, (rows // 4, columns))
    return light


_CALLS = count()


def _sample_of_its_own(lightness: Array, n_samples: int, rng: np.random.Generator) -> float:
    """As np.random would: other pixels at each call. Sampled calls 140 times, or 280: each case sees the same ones."""
    return _sample(lightness, n_samples, np.random.default_rng(1000 + next(_CALLS) % 140))


def _sample_loop(lightness: Array, n_samples: int, rng: np.random.Generator) -> float:
    total = 0.0
    for _ in range(n_samples):
        row, column = rng.integers(lightness.shape[0]), rng.integers(lightness.shape[1])
        total += lightness[row, column]
    return total / n_samples


def _sample_apart(lightness: Array, n_samples: int, rng: np.random.Generator) -> float:
    rows = rng.integers(0, lightness.shape[0], n_samples)
    columns = rng.integers(0, lightness.shape[1], n_samples)
    return float(np.mean(lightness[rows, columns]))


def _sample_without_replacement(lightness: Array, n_samples: int, rng: np.random.Generator) -> float:
    chosen = rng.permutation(lightness.size)[:n_samples]
    return float(lightness.reshape(-1)[chosen].mean())


AVERAGE_LIGHTNESS = Exercise(
    name="average_lightness",
    points=1,
    stars=1,
    public=lambda: [
        Case((_patchy(np.random.default_rng(12), 40, 32).T.copy(), 40, 120), "120 samples of 40 pixels"),
        Case((np.array([[250.0, 0.0]]), 1, 260), "a picture of two pixels"),
    ],
    hidden=lambda rng: [
        Case((_patchy(rng, 48, 64), 50, 120)),
        Case((_patchy(rng, 60, 40).T.copy(), 20, 120)),
        Case((np.array([[float(rng.uniform(200, 250))], [0.0]]), 1, 260)),
    ],
    comparison=Sampled(),
    driver="each_seed",
    hints=(
        "The generator draws for you: rng.integers(0, n, size=k) gives k whole numbers from 0 to n - 1, and "
        "rng.choice(values, k) gives k of the values.",
        "lightness.ravel() is the picture as one long row. Draw n_samples of its elements and take their mean.",
    ),
    mistakes=[
        Mistake(
            "all pixels",
            lambda lightness, n_samples, rng: float(lightness.mean()),
            "Your answer is the mean of all pixels. The paper draws a random sample: n_samples of them.",
        ),
        Mistake(
            "the last pixel never drawn",
            lambda lightness, n_samples, rng: float(
                lightness.ravel()[rng.integers(0, max(lightness.size - 1, 1), n_samples)].mean()
            ),
            "The last pixel is never drawn: the upper end of rng.integers is not included, so it is lightness.size itself.",
        ),
        Mistake(
            "the first pixel never drawn",
            lambda lightness, n_samples, rng: float(
                lightness.ravel()[rng.integers(1, max(lightness.size, 2), n_samples)].mean()
            ),
            "The first pixel is never drawn: Python counts from 0, and so does rng.integers(0, n).",
        ),
        Mistake(
            "one index too many",
            lambda lightness, n_samples, rng: float(
                lightness.ravel()[rng.integers(0, lightness.size + 1, n_samples)].mean()
            ),
            "The last index of n pixels is n - 1, and rng.integers(0, n) draws 0 to n - 1 by itself: say lightness.size, without + 1.",
        ),
        Mistake(
            "whole rows drawn",
            lambda lightness, n_samples, rng: float(rng.choice(lightness, n_samples).mean()),
            "Whole rows of the picture are drawn, not pixels: its first axis counts rows. Draw from one long row of all its pixels.",
        ),
        Mistake(
            "np.random",
            _sample_of_its_own,
            "Draw with the rng that is handed in, not with np.random or a generator of your own: then an experiment can be repeated.",
        ),
        Mistake(
            "the first pixels",
            lambda lightness, n_samples, rng: float(lightness.ravel()[:n_samples].mean()),
            "Those are always the first pixels. Draw them at random, all over the picture.",
        ),
        Mistake(
            "the sum",
            lambda lightness, n_samples, rng: n_samples * _sample(lightness, n_samples, rng),
            "Your answers are n_samples times too large: a sum where a mean is wanted.",
        ),
        Mistake(
            "one pixel",
            lambda lightness, n_samples, rng: float(rng.choice(lightness.ravel())),
            "Your answers scatter like a single pixel's. Draw n_samples of them and average.",
        ),
        Mistake(
            "the median",
            lambda lightness, n_samples, rng: float(np.median(rng.choice(lightness.ravel(), n_samples))),
            "That is the median. On a picture with a bright wall above dark grass, mean and median are far apart.",
        ),
    ],
    alternatives={
        "a loop": _sample_loop,
        "rows and columns apart": _sample_apart,
        "without replacement": _sample_without_replacement,
    },
    equivalents={
        "return lightness.ravel()[chosen].mean()": "NumPy's float64 is a float",
    },
)


# --- 1.3 white_threshold ---

WHITE_THRESHOLD = Exercise(
    name="white_threshold",
    points=1,
    stars=1,
    public=lambda: [
        Case((100.0,), "mean 100"),
        Case((0.0,), "a black picture"),
        Case((120.0, 110.0), "another beta"),
        Case((80.0, 120.0, 200.0), "another maximum"),
    ],
    hidden=lambda rng: [
        *(Case((float(rng.uniform(20, 230)),)) for _ in range(3)),
        *(
            Case((float(rng.uniform(20, 180)), float(rng.uniform(90, 150)), float(rng.uniform(190, 255))))
            for _ in range(4)
        ),
        Case((90.0,), kwargs={"max_lightness": 240.0}),
    ],
    hints=(
        "It is one line: equation 1.4 with mean_lightness for the average and max_lightness for the maximum.",
        "The mean decides how far the threshold climbs from beta towards the maximum: beta plus a fraction of (max_lightness "
        "- beta).",
    ),
    mistakes=[
        Mistake(
            "beta not added",
            lambda mean_lightness, beta=120.0, max_lightness=255.0: (
                (max_lightness - beta) * mean_lightness / max_lightness
            ),
            "A black picture must give beta itself, and you give 0: beta is not added.",
        ),
        Mistake(
            "missing brackets",
            lambda mean_lightness, beta=120.0, max_lightness=255.0: (
                beta + max_lightness - beta * mean_lightness / max_lightness
            ),
            "Brackets are missing: the fraction multiplies (max_lightness - beta), not beta alone.",
        ),
        Mistake(
            "inverted fraction",
            lambda mean_lightness, beta=120.0, max_lightness=255.0: (
                beta + (max_lightness - beta) * max_lightness / max(mean_lightness, 1e-9)
            ),
            "The fraction is upside down: it is the mean over the maximum, between 0 and 1.",
        ),
        Mistake(
            "255 in the fraction",
            lambda mean_lightness, beta=120.0, max_lightness=255.0: (
                beta + (max_lightness - beta) * mean_lightness / 255.0
            ),
            "In the fraction, too, the maximum is the argument max_lightness, not 255.",
        ),
        Mistake(
            "120 and 135",
            lambda mean_lightness, beta=120.0, max_lightness=255.0: 120.0 + 135.0 * mean_lightness / 255.0,
            "That is the worked example. Use the arguments beta and max_lightness instead of 120, 255 and their difference 135.",
        ),
        Mistake(
            "255 for the maximum",
            lambda mean_lightness, beta=120.0, max_lightness=255.0: (
                beta + (255.0 - beta) * mean_lightness / 255.0
            ),
            "It is right as long as max_lightness is 255. Use the argument instead of the number.",
        ),
        Mistake(
            "120 for beta",
            lambda mean_lightness, beta=120.0, max_lightness=255.0: (
                120.0 + (max_lightness - 120.0) * mean_lightness / max_lightness
            ),
            "It is right as long as beta is 120. Use the argument instead of the number.",
        ),
    ],
    alternatives={
        "a weighted mean": lambda mean_lightness, beta=120.0, max_lightness=255.0: (
            beta * (1 - mean_lightness / max_lightness) + mean_lightness
        ),
        "interpolation": lambda mean_lightness, beta=120.0, max_lightness=255.0: np.interp(
            mean_lightness, [0, max_lightness], [beta, max_lightness]
        ),
        "float32": lambda mean_lightness, beta=120.0, max_lightness=255.0: (
            np.float32(beta) + np.float32(max_lightness - beta) * np.float32(mean_lightness / max_lightness)
        ),
    },
)


# --- 1.4 hue_mask ---


def _mask_about_0(hue: Array, low: float, high: float) -> Array:
    """What works where the interval through 0 ends before 180: hues above 180 become negative."""
    if low > high:
        hue, low = np.where(hue > 180, hue - 360, hue), low - 360
    return (hue >= low) & (hue <= high)


def _mask(hue: Array, low: float, high: float) -> Array:
    if low <= high:
        return (hue >= low) & (hue <= high)
    return (hue >= low) | (hue <= high)


HUE_MASK = Exercise(
    name="hue_mask",
    points=2,
    stars=1,
    public=lambda: [
        Case((hues(np.random.default_rng(17), 120, 60, (8, 10)), 100.0, 140.0), "green"),
        Case((np.array([[39.5, 40.0, 50.0, 60.0, 60.5]]), 40.0, 60.0), "at the limits"),
        Case((np.array([[59.5, 60.0, 60.5, 240.0]]), 60.0, 60.0), "one hue, from 60 to 60"),
        Case((hues(np.random.default_rng(18), 0, 60, (8, 10)), 340.0, 20.0), "limits on both sides of 0"),
        Case(
            (np.array([[90.0, 165.0, 170.0, 175.0, 300.0, 0.0, 10.0, 15.0]]), 170.0, 10.0),
            "more than half the circle",
        ),
    ],
    hidden=lambda rng: [
        *(Case((hues(rng, m, 80, (20, 30)), float(m - 25), float(m + 25))) for m in (60, 120, 200)),
        Case((hues(rng, 0, 90, (20, 30)), 330.0, 15.0)),
        Case((hues(rng, 10, 60, (20, 30)), 350.0, 40.0)),
        Case((np.array([0.0, 10.0, 10.5, 349.5, 350.0, 359.5]), 350.0, 10.0)),
        Case((np.array([[90.0, 90.5, 89.5]]), 90.0, 90.0)),
        Case((hues(rng, 0, 180, (20, 30)), float(rng.uniform(80, 170)), float(rng.uniform(0, 60)))),
    ],
    comparison=Exact(),
    hints=(
        "Two comparisons joined by & (and), each in brackets: (hue >= ...) & (hue <= ...). Both limits belong to it.",
        "If low is larger than high, the interval goes through 0: then a hue belongs to it if it is above low *or* below "
        "high.",
    ),
    mistakes=[
        Mistake(
            "no wrap",
            lambda hue, low, high: (hue >= low) & (hue <= high),
            "With low above high your mask is empty. Such limits go through 0: above low *or* below high.",
        ),
        Mistake(
            "limits excluded",
            lambda hue, low, high: (hue > low) & (hue < high) if low <= high else (hue > low) | (hue < high),
            "Pixels that lie exactly on a limit are left out. Equations 1.6 and 1.7 include both.",
        ),
        Mistake(
            "equal limits for all hues",
            lambda hue, low, high: (
                (hue >= low) & (hue <= high) if low < high else (hue >= low) | (hue <= high)
            ),
            "Equal limits are one hue, not all of them: only where low is *larger* than high does the interval go through 0.",
        ),
        Mistake(
            "hues above 180 moved",
            _mask_about_0,
            "Right for narrow intervals through 0. One from 170 through 0 to 10 is allowed, too: its hues of 175 are above low.",
        ),
        Mistake(
            "low minus 360",
            lambda hue, low, high: (hue >= (low - 360 if low > high else low)) & (hue <= high),
            "With low - 360 the hues from 0 to high are in, but those from low to 359 are not: they were not moved with it. No limit "
            "needs to move: above low *or* below high.",
        ),
        Mistake(
            "high plus 360",
            lambda hue, low, high: (hue >= low) & (hue <= (high + 360 if low > high else high)),
            "With high + 360 the hues from low to 359 are in, but those from 0 to high are not: they were not moved with it. No limit "
            "needs to move: above low *or* below high.",
        ),
        Mistake(
            "limits swapped",
            lambda hue, low, high: (hue >= min(low, high)) & (hue <= max(low, high)),
            "Where low is above high you have swapped them: that marks what lies between them the other way round, through 180. "
            "Such limits go through 0: above low *or* below high.",
        ),
        Mistake(
            "or for and",
            lambda hue, low, high: (hue >= low) | (hue <= high),
            "Your mask lets everything through: each hue is above low or below high. Both must hold.",
        ),
        Mistake(
            "bytes",
            lambda hue, low, high: _mask(hue, low, high).astype(np.uint8) * 255,
            "Your mask has 0 and 255, as OpenCV's do. True and False are wanted: they can be used as an index.",
        ),
        Mistake(
            "ones and zeros",
            lambda hue, low, high: np.where(_mask(hue, low, high), 1, 0),
            "Your mask has 1 and 0. A comparison such as hue >= low gives True and False by itself: leave the rest away.",
        ),
        Mistake(
            "inverted",
            lambda hue, low, high: ~_mask(hue, low, high),
            "Your mask is exactly the opposite.",
        ),
    ],
    alternatives={
        "modulo": lambda hue, low, high: (np.asarray(hue) - low) % 360 <= (high - low) % 360,
        "a loop": lambda hue, low, high: np.array(
            [low <= h <= high if low <= high else h >= low or h <= high for h in hue.ravel()], dtype=bool
        ).reshape(hue.shape),
        "without a branch": lambda hue, low, high: np.logical_or(
            np.logical_and(hue >= low, hue <= high), (low > high) & ((hue >= low) | (hue <= high))
        ),
    },
    equivalents={
        "return above & below if low <= high else above + below": "+ of two boolean arrays is their |",
        "return above & below if low <= high else above ^ below": "where low > high no hue is both above low and below high, and only there ^ differs from |",
        "return above * below if low <= high else above | below": "* of two boolean arrays is their &",
        "above, below = (hue <= high, hue >= low)": "the names are swapped, and & and | do not mind",
    },
)


# --- 1.5 color_labels ---


def _labels(
    picture: Array,
    green: tuple[float, float],
    yellow: tuple[float, float],
    threshold: float,
    min_saturation: float = 0.16,
    order: str = "gyw",
    floored: str = "gy",
    white_is_grey: bool = False,
    hls: bool = False,
    luma: bool = False,
) -> Array:
    """The labels, with one thing done in another way: `floored` says which of green, yellow and white need the floor."""
    hue, saturation, lightness = _hsl(picture, luma=luma)
    if hls:
        saturation, lightness = lightness, saturation
    coloured = saturation >= min_saturation
    masks = {
        "g": _mask(hue, *green),
        "y": _mask(hue, *yellow),
        "w": (lightness > threshold) & (~coloured if white_is_grey else True),
    }
    labels = np.zeros(picture.shape[:2], dtype=np.uint8)
    for kind in order:
        labels[masks[kind] & (coloured if kind in floored else True)] = 1 + "gyw".index(kind)
    return labels


def _labels_loop(
    picture: Array,
    green: tuple[float, float],
    yellow: tuple[float, float],
    threshold: float,
    min_saturation: float = 0.16,
) -> list[list[int]]:
    hue, saturation, lightness = _hsl(picture)
    rows = []
    for i in range(picture.shape[0]):
        row = []
        for j in range(picture.shape[1]):
            label = 0
            if lightness[i, j] > threshold:
                label = 3
            elif saturation[i, j] >= min_saturation and _mask(hue[i, j], *yellow):
                label = 2
            elif saturation[i, j] >= min_saturation and _mask(hue[i, j], *green):
                label = 1
            row.append(label)
        rows.append(row)
    return rows


def _labels_select(
    picture: Array,
    green: tuple[float, float],
    yellow: tuple[float, float],
    threshold: float,
    min_saturation: float = 0.16,
) -> Array:
    hls = cv2.cvtColor(picture.astype(np.float32) / 255, cv2.COLOR_RGB2HLS)
    hue, lightness, coloured = hls[..., 0], hls[..., 1] * 255, hls[..., 2] >= min_saturation
    return np.select(
        [lightness > threshold, coloured & _mask(hue, *yellow), coloured & _mask(hue, *green)], [3, 2, 1], 0
    ).astype(np.uint8)


_GREEN, _YELLOW = (90.0, 150.0), (45.0, 95.0)  # they overlap: yellow wins

COLOR_LABELS = Exercise(
    name="color_labels",
    points=3,
    stars=2,
    uses=("rgb_to_hsl", "hue_mask"),
    public=lambda: [
        Case((picture(np.random.default_rng(19), 12, 16), _GREEN, _YELLOW, 180.0), "a picture"),
        Case(
            (picture(np.random.default_rng(20), 12, 16), _GREEN, _YELLOW, 180.0, 0.4712),
            "a high saturation floor",
        ),
        Case(
            (picture(np.random.default_rng(21), 12, 16), (350.0, 60.0), (40.0, 70.0), 120.0),
            "green through 0",
        ),
        Case((primaries(), (60.0, 180.0), (0.0, 50.0), 130.0, 1.0), "a floor that only pure colours reach"),
        Case((primaries(), (60.0, 180.0), (0.0, 50.0), 255.0, 0.5), "no pixel is above 255"),
    ],
    hidden=lambda rng: [
        Case((primaries()[::-1], (70.0, 180.0), (0.0, 60.0), 130.0, 1.0)),
        Case((picture(rng, 30, 40), _GREEN, _YELLOW, 180.0)),
        Case((picture(rng, 30, 40), _GREEN, _YELLOW, 120.0, 0.3071)),
        Case((picture(rng, 30, 40), (330.0, 120.0), (40.0, 80.0), 200.0, 0.0)),
        Case((picture(rng, 30, 40), _GREEN, _YELLOW, 255.0)),
        Case((primaries(), (60.0, 180.0), (0.0, 60.0), 126.0, 0.9)),
    ],
    comparison=Exact(allowed=0.006),
    hints=(
        "Begin with np.zeros of the picture's height and width, dtype uint8, and write the labels into it: labels[mask] = 1. "
        "What is written last wins.",
        "Your own rgb_to_hsl and hue_mask give three masks: green hue and enough saturation, yellow hue and enough "
        "saturation, lightness above the threshold. The floor is not for white, which has no colour.",
    ),
    mistakes=[
        Mistake(
            "green wins",
            lambda *args: _labels(*args, order="wyg"),
            "The order of precedence is upside down: white wins over yellow, and yellow over green. Write green first.",
        ),
        Mistake(
            "yellow wins over white",
            lambda *args: _labels(*args, order="gwy"),
            "Bright yellow pixels must become white: white is written last.",
        ),
        Mistake(
            "white first",
            lambda *args: _labels(*args, order="wgy"),
            "White is written first, and green and yellow go over it. What is written last wins: that must be white.",
        ),
        Mistake(
            "green last",
            lambda *args: _labels(*args, order="ywg"),
            "Green is written last and wins over all. Write green first, then yellow, then white.",
        ),
        Mistake(
            "floor excluded",
            lambda picture, green, yellow, threshold, min_saturation=0.16: _labels(
                picture, green, yellow, threshold, min_saturation + 1e-9
            ),
            "A pixel that is exactly as saturated as min_saturation counts: at least means >=.",
        ),
        Mistake(
            "green wins over yellow",
            lambda *args: _labels(*args, order="ygw"),
            "Where green's and yellow's hues overlap, yellow wins: write it after green.",
        ),
        Mistake(
            "floor for white",
            lambda *args: _labels(*args, floored="gyw"),
            "White lines are missing: they have hardly any saturation. The floor is for green and yellow only.",
        ),
        Mistake(
            "no floor",
            lambda *args: _labels(*args, floored=""),
            "Grey pixels get a colour: min_saturation is not used.",
        ),
        Mistake(
            "floor fixed",
            lambda picture, green, yellow, threshold, min_saturation=0.16: _labels(
                picture, green, yellow, threshold
            ),
            "It is right as long as the floor is 0.16. Use the argument min_saturation.",
        ),
        Mistake(
            "white only where grey",
            lambda *args: _labels(*args, white_is_grey=True),
            "White lines are missing: near white a little noise is a high saturation. The floor is for green and yellow only.",
        ),
        Mistake(
            "white and green exchanged",
            lambda *args: np.array([0, 3, 2, 1], dtype=np.uint8)[_labels(*args)],
            "White and green have changed places: green is 1, white is 3.",
        ),
        Mistake(
            "floor for green only",
            lambda *args: _labels(*args, floored="g"),
            "Yellow needs the minimal saturation, too: nearly grey pixels have any hue.",
        ),
        Mistake(
            "white at the threshold",
            lambda picture, green, yellow, threshold, min_saturation=0.16: _labels(
                picture, green, yellow, threshold - 1e-9, min_saturation
            ),
            "Equation 1.4 has >, not >=: a pixel exactly at the threshold is not white.",
        ),
        Mistake(
            "labels swapped",
            lambda *args: np.array([0, 2, 1, 3], dtype=np.uint8)[_labels(*args)],
            "Green and yellow have changed places: green is 1, yellow is 2.",
        ),
        Mistake(
            "OpenCV's order",
            lambda *args: _labels(*args, hls=True),
            "Saturation and lightness have changed places: your rgb_to_hsl gives hue, saturation, lightness, in this order.",
        ),
        Mistake(
            "labels with a point",
            lambda *args: _labels(*args).astype(float),
            "Your labels are right, but they are whole numbers: say dtype=np.uint8 where you make the array.",
        ),
        Mistake(
            "luma",
            lambda *args: _labels(*args, luma=True),
            "Your white is decided by the luma. Use the lightness of your rgb_to_hsl.",
        ),
    ],
    alternatives={
        "a loop": _labels_loop,
        "np.select and OpenCV": _labels_select,
        "int64": lambda *args: _labels(*args).astype(np.int64),
    },
    equivalents={
        "labels[hue_mask(hue, *green) * coloured] = 1": "* of two boolean arrays is their &",
        "labels[hue_mask(hue, *yellow) * coloured] = 2": "* of two boolean arrays is their &",
    },
)


# --- 1.6 calibrate_hue ---


def _limits(hue: Array, saturation: Array, epsilon: float = 0.0) -> tuple[float, float]:
    """Limits on the circle: the widest gap between neighbouring hues is outside."""
    coloured = np.unique(hue[saturation > 0])
    gaps = np.diff(coloured, append=coloured[0] + 360)
    widest = int(gaps.argmax())
    low, high = coloured[(widest + 1) % len(coloured)], coloured[widest]
    return float((low - epsilon) % 360), float((high + epsilon) % 360)


def _limits_by_steps(hue: Array, saturation: Array, epsilon: float, end: float) -> tuple[float, float]:
    """With a last step that ends at `end`; with end 0 it goes backwards and is never the largest."""
    coloured = np.unique(hue[saturation > 0])
    gaps = np.diff(coloured, append=end)
    last = int(gaps.argmax())
    low, high = coloured[(last + 1) % len(coloured)], coloured[last]
    return float((low - epsilon) % 360), float((high + epsilon) % 360)


def _limits_without_modulo(hue: Array, saturation: Array, epsilon: float = 0.0) -> tuple[float, float]:
    coloured = np.unique(hue[saturation > 0])
    last = int(np.diff(coloured, append=coloured[0] + 360).argmax())
    return float((coloured[last + 1] - epsilon) % 360), float((coloured[last] + epsilon) % 360)


def _limits_loop(hue: Array, saturation: Array, epsilon: float = 0.0) -> tuple[float, float]:
    there = sorted({float(h) for h, s in zip(hue.ravel(), saturation.ravel(), strict=True) if s > 0})
    best, answer = -1.0, (0.0, 0.0)
    for i, high in enumerate(there):
        low = there[(i + 1) % len(there)]
        gap = (low - high) % 360 or 360.0
        if gap > best:
            best, answer = gap, ((low - epsilon) % 360, (high + epsilon) % 360)
    return answer


def _limits_from_each_start(hue: Array, saturation: Array, epsilon: float = 0.0) -> tuple[float, float]:
    """An arc from each hue, as long as it must be to hold all; the shortest of them."""
    there = np.asarray(hue, dtype=float)[np.asarray(saturation) > 0]
    low = min(set(there.tolist()), key=lambda start: float(np.max((there - start) % 360)))
    return (low - epsilon) % 360, (low + float(np.max((there - low) % 360)) + epsilon) % 360


def _limits_about_mean(hue: Array, saturation: Array, epsilon: float = 0.0) -> tuple[float, float]:
    angles = np.radians(hue[saturation > 0])
    middle = np.degrees(np.arctan2(np.sin(angles).mean(), np.cos(angles).mean()))
    offset = (np.degrees(angles) - middle + 180) % 360 - 180
    return float((middle + offset.min() - epsilon) % 360), float((middle + offset.max() + epsilon) % 360)


def _limits_list(hue: Array, saturation: Array, epsilon: float = 0.0) -> list[np.float32]:
    return [np.float32(limit) for limit in _limits(hue, saturation, epsilon)]


def _grass(rng: np.random.Generator, middle: float, width: float) -> tuple[Array, Array]:
    """Hues about a middle, with grey pixels whose hue, 0, means nothing."""
    hue, saturation = hues(rng, middle, width, (8, 10)), rng.uniform(0.1, 0.9, (8, 10))
    grey = rng.random((8, 10)) < 0.2
    grey[0, 0] = True
    hue[grey], saturation[grey] = 0.0, 0.0
    return hue, saturation


def _turned(rng: np.random.Generator, hues: tuple[float, ...]) -> Array:
    """Hues, all turned on the circle by the same angle."""
    return (np.array([hues]) + rng.integers(1, 720) / 2) % 360


CALIBRATE_HUE = Exercise(
    name="calibrate_hue",
    points=4,
    stars=3,
    public=lambda: [
        Case((*_grass(np.random.default_rng(13), 125, 20), 0.0), "green grass"),
        Case((*_grass(np.random.default_rng(14), 125, 20), 5.0), "green grass, epsilon 5"),
        Case((*_grass(np.random.default_rng(15), 2, 15), 0.0), "a red ball: hues on both sides of 0"),
        Case((*_grass(np.random.default_rng(16), 4, 12), 3.0), "a red ball, epsilon 3"),
        Case((np.array([[2.0, 10.0, 20.0]]), np.array([[0.5, 0.4, 0.01]]), 5.0), "epsilon reaches over 0"),
        Case((np.array([[200.0, 330.0]]), np.array([[0.5, 0.4]]), 0.0), "two hues, 200 and 330"),
        Case(
            (np.array([[0.0, 5.0, 10.0]]), np.array([[0.5, 0.4, 0.3]]), 1.0),
            "pure red, which has the hue 0, and no grey",
        ),
        Case(
            (np.array([[350.0, 355.0, 5.0, 10.0]]), np.full((1, 4), 0.8), 2.0), "the example of the docstring"
        ),
        Case((np.array([[0.0, 0.0, 0.0, 170.0, 200.0]]), np.full((1, 5), 0.8), 0.0), "hues 0, 170 and 200"),
    ],
    hidden=lambda rng: [
        *(
            Case((*_grass(rng, float(rng.uniform(60, 300)), float(rng.uniform(8, 30))), e))
            for e in (0.0, 4.0, 7.5)
        ),
        *(Case((*_grass(rng, float(rng.uniform(-6, 6)), float(rng.uniform(10, 30))), e)) for e in (0.0, 4.0)),
        Case((np.array([[1.0, 8.0, 30.0]]), np.array([[0.5, 0.9, 0.01]]), 5.0)),
        Case((np.array([[350.0, 358.0, 300.0]]), np.array([[0.5, 0.9, 0.2]]), 5.0)),
        Case((np.array([[90.0, 90.0, 10.0]]), np.array([[0.5, 0.9, 0.0]]), 2.0)),
        Case(_grass(rng, 55.0, 10.0)),
        Case((np.array([[float(rng.uniform(185, 215)), 340.0]]), np.array([[0.3, 0.02]]))),
        Case((np.array([[0.0, 7.0, 14.0]]), np.array([[0.5, 0.4, 0.3]]), 2.0)),
        Case((np.array([[351.0, 356.0, 6.0, 11.0]]), np.full((1, 4), 0.7), 1.5)),
        Case((_turned(rng, (0.0, 0.0, 0.0, 170.0, 200.0)), np.full((1, 5), 0.6))),
        Case((_turned(rng, (0.0, 100.0, 210.0, 215.0)), np.full((1, 4), 0.6), 3.0)),
        *(
            Case((np.array([[3.0, 3.0 + gap]]), np.full((1, 2), 0.5))) for gap in (179.6, 180.4)
        ),  # a close race
    ],
    comparison=Close(rtol=0, atol=0.02, names=("low", "high")),
    hints=(
        "Go once around the circle, from each hue to the next; behind the last comes the first again. An arc that holds all hues leaves "
        "out exactly one of these steps. Which one makes it smallest? (np.unique sorts, and drops what is there twice.)",
        "np.diff(hues, append=hues[0] + 360) has the step behind each hue, and argmax() the place of the widest. High is the hue before "
        "it, low the one behind: index (k + 1) % len(hues). Then epsilon, outwards, and both modulo 360.",
    ),
    mistakes=[
        Mistake(
            "epsilon inwards",
            lambda hue, saturation, epsilon=0.0: _limits(hue, saturation, -epsilon),
            "Your limits are narrower than the picture's hues. Make low smaller and high larger by epsilon.",
        ),
        Mistake(
            "grey included",
            lambda hue, saturation, epsilon=0.0: _limits(hue, np.ones_like(saturation), epsilon),
            "One of your limits comes from grey pixels. They have saturation 0 and no hue: leave them out.",
        ),
        Mistake(
            "no wrap",
            lambda hue, saturation, epsilon=0.0: (
                float((hue[saturation > 0].min() - epsilon) % 360),
                float((hue[saturation > 0].max() + epsilon) % 360),
            ),
            "Right for green. Red lies on both sides of 0: there, smallest and largest hue are neighbours, and everything "
            "but red is between them.",
        ),
        Mistake(
            "no wrap, no modulo",
            lambda hue, saturation, epsilon=0.0: (
                float(hue[saturation > 0].min() - epsilon),
                float(hue[saturation > 0].max() + epsilon),
            ),
            "Smallest and largest hue are right for green. Red lies on both sides of 0, where they are neighbours: between your "
            "limits lies nearly the whole circle. And limits below 0 or above 360 are taken modulo 360.",
        ),
        Mistake(
            "no wrap, grey included",
            lambda hue, saturation, epsilon=0.0: (float(hue.min() - epsilon), float(hue.max() + epsilon)),
            "These are the smallest and largest hue of all pixels. Grey ones have no hue: leave them out. And hues live on a circle, "
            "where red is on both sides of 0, and its hues are neighbours.",
        ),
        Mistake(
            "no wrap, no epsilon",
            lambda hue, saturation, epsilon=0.0: (
                float(hue[saturation > 0].min()),
                float(hue[saturation > 0].max()),
            ),
            "Smallest and largest hue are right for green and no epsilon. Red lies on both sides of 0, where its hues are neighbours. "
            "And epsilon widens the limits.",
        ),
        Mistake(
            "about the mean direction",
            _limits_about_mean,
            "Right for hues that are close together. Where they are far apart, what lies opposite their mean need not be the widest gap: "
            "of 0, 0, 0, 170 and 200 it is between 170 and 200. Look for the gap itself.",
        ),
        Mistake(
            "the last step left out",
            lambda hue, saturation, epsilon=0.0: _limits_by_steps(hue, saturation, epsilon, 0.0),
            "Between which neighbours did you look? On a circle the last hue has one, too, and from there on it goes upwards through 360.",
        ),
        Mistake(
            "the last step ends at 360",
            lambda hue, saturation, epsilon=0.0: _limits_by_steps(hue, saturation, epsilon, 360.0),
            "From the last hue it is not 360 that comes next, but the first hue, one turn later.",
        ),
        Mistake(
            "behind the last nothing",
            _limits_without_modulo,
            "Behind the last hue comes the first: take the index (k + 1) % len(hues).",
        ),
        Mistake(
            "epsilon for low only",
            lambda hue, saturation, epsilon=0.0: (
                _limits(hue, saturation, epsilon)[0],
                _limits(hue, saturation)[1],
            ),
            "Epsilon widens the interval on both sides: high becomes larger, too.",
        ),
        Mistake(
            "epsilon on one side",
            lambda hue, saturation, epsilon=0.0: (
                _limits(hue, saturation)[0],
                _limits(hue, saturation, epsilon)[1],
            ),
            "Epsilon widens the interval on both sides: low becomes smaller, too.",
        ),
        Mistake(
            "swapped before epsilon",
            lambda hue, saturation, epsilon=0.0: (
                (_limits(hue, saturation)[1] - epsilon) % 360,
                (_limits(hue, saturation)[0] + epsilon) % 360,
            ),
            "Low and high have changed places: the widest gap is what is outside. Low comes behind it, high before it.",
        ),
        Mistake(
            "swapped",
            lambda hue, saturation, epsilon=0.0: _limits(hue, saturation, epsilon)[::-1],
            "Low and high have changed places: the widest gap is what is outside, and low comes behind it.",
        ),
        Mistake(
            "epsilon forgotten",
            lambda hue, saturation, epsilon=0.0: _limits(hue, saturation),
            "The limits are those of the picture itself: epsilon is not used.",
        ),
        Mistake(
            "modulo forgotten",
            lambda hue, saturation, epsilon=0.0: (
                _limits(hue, saturation)[0] - epsilon,
                _limits(hue, saturation)[1] + epsilon,
            ),
            "With epsilon a limit leaves [0, 360): take both modulo 360, or hue_mask will miss what lies beyond 0.",
        ),
        Mistake(
            "half degrees",
            lambda hue, saturation, epsilon=0.0: (
                _limits(hue, saturation)[0] / 2 - epsilon,
                _limits(hue, saturation)[1] / 2 + epsilon,
            ),
            "Your limits are half of what they should be: degrees from 0 to 360, not OpenCV's units of 2 degrees.",
        ),
    ],
    alternatives={
        "a loop": _limits_loop,
        "from each start": _limits_from_each_start,
        "a list of float32": _limits_list,
    },
    equivalents={
        "low, high = (hues[last + 1 - len(hues)], hues[last])": "an index below 0 counts from the end: last + 1 - n and (last + 1) % n are the same element",
        "hues = np.unique(hue[saturation != 0])": "no saturation is below 0",
        "return ((low - epsilon) % 360, float((high + epsilon) % 360))": "NumPy's float64 is a float",
        "return (float((low - epsilon) % 360), (high + epsilon) % 360)": "NumPy's float64 is a float",
    },
)


PLAN = LessonPlan(
    exercises=[RGB_TO_HSL, AVERAGE_LIGHTNESS, WHITE_THRESHOLD, HUE_MASK, COLOR_LABELS, CALIBRATE_HUE],
    questions=[
        Question(
            "why_hsl",
            "The sun goes behind a cloud, and every channel of every pixel is halved. Which of the three survive on the sunlit carpet?",
            {
                "All three: the colour is the same.": "Lightness is (M + m) / 2, so it is halved. That is what one sees first of a "
                "cloud.",
                "Hue and saturation.": "Saturation does so only in dark pixels, where equation 1.2 is (M - m) / (M + m). The carpet is "
                "brighter than half: there it divides by 2 - (M + m), which grows. From 0.41 it falls to 0.27.",
                "Hue alone.": "The ratio (g - b) / (M - m) does not notice a common factor. Lightness is halved, and saturation falls "
                "from 0.41 to 0.27: on a bright pixel it is divided by 2 - (M + m). That is why the paper filters by hue.",
                "None: all three are halved.": "Hue is a ratio of differences of channels: (g - b) / (M - m). Halve them all, and the "
                "halves cancel.",
            },
            "Hue alone.",
        ),
        Question(
            "why_epsilon",
            "Why does the paper widen green by epsilon, and yellow not?",
            {
                "The carpet is everywhere, and its example shows only one place.": "It is seen near and far, in shadow and in glare, and "
                "its hue differs a little from place to place. A goal is small, in one place and one light.",
                "Yellow's example has more pixels, so it shows all of its hues.": "It is the smaller one. What counts is not how many "
                "pixels an example has, but whether it shows the colour in every light that will occur.",
                "A wider yellow would take in the carpet's hues.": "It has room: from yellow, at 60 degrees, to the carpet it is some "
                "50 degrees. You can try it in the panel below.",
            },
            "The carpet is everywhere, and its example shows only one place.",
        ),
    ],
    written=[
        Written(
            "explain_stray_pixel",
            points=2,
            question="Why can one stray pixel among so many turn the carpet yellow, and which rule for the limits would not mind it?",
            rubric="1 point: the smallest and largest value are each decided by a single pixel, however many others there are; the "
            "interval reaches from yellow to the grass pixel's hue and so covers hues of the carpet (bonus insight: yellow wins over "
            "green). 1 point: a rule that one pixel cannot move, such as quantiles or the median and a fixed width, with its price or "
            "the reason why it works.",
        )
    ],
)
