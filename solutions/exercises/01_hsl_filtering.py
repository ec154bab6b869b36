"""Exercises of lesson 01, HSL filtering, with common mistakes and alternative correct solutions."""

from __future__ import annotations

import colorsys
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.exercises import Case, Close, Exact, Exercise, LessonPlan, Question, Sampled, Sibling, Written
from nao_course.instructor.authoring.mistakes import catalogue
from nao_course.lessons.hsl_filtering import personal_numbers

Array = npt.NDArray[Any]
Seed = int | np.random.Generator
Limits = tuple[float, float]


# --- pictures and hues for the cases ---
def picture(seed: Seed, rows: int, columns: int) -> Array:
    """Return a picture of noisy pixels in the colours of grass, goal, line, shadow and wall, and of random pixels."""
    rng = np.random.default_rng(seed)
    colours = np.array(
        [(60, 130, 70), (85, 145, 88), (205, 190, 45), (250, 251, 249), (20, 22, 21), (150, 150, 150)]
    )
    kinds = rng.integers(0, len(colours) + 1, (rows, columns))
    noisy = np.append(colours, [[0, 0, 0]], axis=0)[kinds] + rng.integers(-14, 15, (rows, columns, 3))
    anything = rng.integers(0, 256, (rows, columns, 3))
    return np.clip(np.where((kinds == len(colours))[..., None], anything, noisy), 0, 255).astype(np.uint8)


def primaries() -> Array:
    """Return the corners of the colour cube, some greys, and pinks with a hue just below 360 degrees."""
    rows = [
        [(255, 0, 0), (255, 255, 0), (0, 255, 0), (0, 255, 255), (0, 0, 255), (255, 0, 255)],
        [(0, 0, 0), (255, 255, 255), (128, 128, 128), (200, 10, 60), (255, 0, 30), (130, 90, 110)],
    ]
    return np.array(rows, dtype=np.uint8).reshape(3, 4, 3)


def hues(seed: Seed, centre: float, width: float, size: tuple[int, int]) -> Array:
    """Return random hues around a centre on the circle, rounded to half degrees."""
    rng = np.random.default_rng(seed)
    return np.round(2 * (centre + rng.uniform(-width, width, size))) / 2 % 360


# --- 1.1 rgb_to_hsl ---
def _hsl_loop(picture: Array) -> tuple[Array, Array, Array]:
    hls = [[colorsys.rgb_to_hls(*pixel) for pixel in row] for row in (picture / 255).tolist()]
    hue, lightness, saturation = np.moveaxis(np.array(hls), -1, 0)
    return 360 * hue, saturation, 255 * lightness


def _hsl_opencv(picture: Array) -> tuple[Array, Array, Array]:
    hls = cv2.cvtColor(picture.astype(np.float32) / 255, cv2.COLOR_RGB2HLS)
    return hls[..., 0], hls[..., 2], hls[..., 1] * 255


RGB_TO_HSL = Exercise(
    name="rgb_to_hsl",
    points=2,
    public=lambda: [Case((primaries(),), "pure colours and greys"), Case((picture(11, 8, 10),), "a picture")],
    hidden=lambda rng: [Case((primaries()[:, ::-1],)), *(Case((picture(rng, 24, 32),)) for _ in range(3))],
    comparison=Close(rtol=1e-3, atol=2e-3, names=("your hue", "your saturation", "your lightness")),
    hints=(
        "The first line of equation 1.3 applies where largest == red. Write its fraction with divisor as the denominator, and select it there with np.where; elsewhere keep the given sixths. Each sixth of the circle is 60 degrees.",
        "The hue is np.where(largest == red, ..., sixths), times 60, modulo 360. The denominator of equation 1.2 is 0 for black and white, so replace it by 1 there: np.where(grey, 1.0, ...), as in divisor.",
    ),
    sibling=Sibling(
        "A divisor of 0 is replaced before the division, and a second np.where changes only the elements that its condition selects.",
        """
        import numpy as np

        metres = np.array([30.0, 0.0, 90.0, 8.0])
        seconds = np.array([10.0, 0.0, 15.0, 8.0])
        is_empty = seconds == 0
        speed = metres / np.where(is_empty, 1.0, seconds)
        fine = np.where(speed > 2, 20, 0)
        fine = np.where(speed > 5, 80, fine)
        print(speed, fine)
        """,
        "[3. 0. 6. 1.] [20  0 80  0]",
    ),
    mistakes=catalogue("""
        one minus forgotten: np.where(grey, 1.0, 1 - np.abs => np.where(grey, 1.0, np.abs
            The denominator of your saturation is |M + m - 1|. In equation 1.2 this is subtracted from 1.
        saturation first: 60 * sixths % 360, saturation, => saturation, 60 * sixths % 360,
            Hue and saturation are exchanged. Return hue, saturation and lightness, in this order.
        half degrees: 60 * sixths % 360 => 30 * sixths % 180
            Your hues are half as large as expected. OpenCV stores hues of bytes in units of 2 degrees; this course uses degrees, 0 to 360.
        OpenCV's order: saturation, lightness => lightness, saturation
            Saturation and lightness are exchanged. OpenCV's HLS has lightness second; the order here is hue, saturation, lightness.
        luma: 255 * (largest + smallest) / 2 => 255 * (0.299 * red + 0.587 * green + 0.114 * blue)
            Your lightness is the luma, a weighted mean of the three channels. The lightness of HSL is the mean of the largest and the smallest channel.
        uint8 overflow: 255 * (largest + smallest) / 2 => ((picture.max(axis=2) + picture.min(axis=2)) // 2).astype(float)
            Bright pixels become dark, because you add bytes and 200 + 200 overflows to 144. Convert the picture to floats first.
        negative hue: 60 * sixths % 360 => 60 * sixths
            Some of your hues are negative. Take the hue modulo 360; pinks are just below 360 degrees.
        the red line left out: sixths = np.where(largest == red, (green - blue) / divisor, sixths) => pass
            Where red is the largest channel, your hues come from another line of equation 1.3. The given code has the lines for green and blue; add the first line, for M = r.
        the red line left out, grey given hue 0: sixths = np.where(largest == red, (green - blue) / divisor, sixths) => sixths = np.where(grey, 0.0, sixths)
            Where red is the largest channel, your hues come from another line of equation 1.3. The given code has only the lines for green and blue; add the first line, for M = r.
        the red line reversed: (green - blue) / divisor, sixths => (blue - green) / divisor, sixths
            Where red is the largest channel, your hues run the wrong way round the circle. The numerator of the first line is g - b.
        only the red line: (green - blue) / divisor, sixths => (green - blue) / divisor, 0.0
            Your hue is 0 wherever red is not the largest channel. Keep the given sixths there, as the third argument of np.where.
        60 degrees twice: (green - blue) / divisor, sixths => 60 * (green - blue) / divisor, sixths
            Where red is the largest channel, your hues are 60 times too large. All three lines are in sixths of the circle; multiply by 60 once, at the end.
        grey divided by zero: (green - blue) / divisor, sixths => (green - blue) / (largest - smallest), sixths
            np.where(grey, 1.0, 1 - np.abs(largest + smallest - 1)) => (1 - np.abs(largest + smallest - 1))
            Some hues or saturations are NaN. In a grey pixel the largest and the smallest channel are equal, so you divide 0 by 0. Grey must get hue 0 and saturation 0.
        bytes subtracted: largest == red, (green - blue) / divisor => largest == red, (picture[..., 1] - picture[..., 2]) / 255 / divisor
            (blue - red) => (picture[..., 2] - picture[..., 0]) / 255
            (red - green) => (picture[..., 0] - picture[..., 1]) / 255
            You subtract bytes, and 10 - 20 overflows to 246. Convert the picture to floats first.
        no absolute value: np.abs(largest + smallest - 1) => (largest + smallest - 1)
            The saturation of your dark pixels is too small, because M + m - 1 is negative there. Equation 1.2 has its absolute value.
        divided by M + m: 1 - np.abs(largest + smallest - 1) => largest + smallest
            The saturation of your bright pixels is too small, because you divide by M + m. This is the denominator of equation 1.2 for dark pixels only.
        lightness in the denominator: np.abs(largest + smallest - 1) => np.abs(lightness - 1)
            Your saturation has the lightness (0 to 255) in its denominator. Equation 1.2 has M + m, which is between 0 and 2.
        numerator without brackets: (largest - smallest) / => largest - smallest /
            Your saturation is wrong because only m is divided: / is computed before -. Put M - m in brackets.
        saturation in 0..255: (largest - smallest) / => 255 * (largest - smallest) /
            Your saturation is between 0 and 255. Only lightness goes to 255 in this course; saturation is between 0 and 1.
        half a turn added: 60 * sixths % 360 => np.where(sixths < 0, 60 * sixths + 180, 60 * sixths)
            You add 180 degrees to negative hues, which moves them to the opposite side of the circle. A whole turn is 360 degrees.
        percent: (largest - smallest) / => 100 * (largest - smallest) /
            Your saturation is in percent. In this course it is between 0 and 1.
        OpenCV's bytes: + import cv2
            + hls = cv2.cvtColor(picture, cv2.COLOR_RGB2HLS)
            + return hls[..., 0], hls[..., 1], hls[..., 2]
            Your result is OpenCV's conversion of bytes: hue in units of 2 degrees, then lightness, then saturation in 0..255. Return hue in degrees, saturation in 0..1 and lightness in 0..255, in this order.
        blue first: + picture = picture[..., ::-1]
            Red and blue are exchanged. OpenCV reads files as blue, green, red, but the pictures of this course are red, green, blue.
        radians: 60 * sixths % 360 => np.radians(60 * sixths % 360)
            Your hues are in radians. In this course hues are in degrees, 0 to 360.
        no modulo, and 0 divided by 0: 60 * sixths % 360 => 60 * sixths
            np.where(grey, 1.0, 1 - np.abs(largest + smallest - 1)) => (1 - np.abs(largest + smallest - 1))
            There are two errors. Some hues are negative: take the hue modulo 360. And the saturation of black and white is NaN, because their denominator 1 - |M + m - 1| is 0: replace it by 1 where a pixel is grey.
        the red line left out, and 0 divided by 0: sixths = np.where(largest == red, (green - blue) / divisor, sixths) => pass
            np.where(grey, 1.0, 1 - np.abs(largest + smallest - 1)) => (1 - np.abs(largest + smallest - 1))
            There are two errors. The first line of equation 1.3, for M = r, has no effect in your code: assign the result of np.where to sixths. And the saturation of black and white is NaN: replace its denominator by 1 where a pixel is grey.
        the scaffold's divisor in the numerator: saturation = (largest - smallest) => saturation = divisor
            Your grey pixels have saturation 1, because divisor is 1 there. It is meant for denominators only. The numerator of equation 1.2 is largest - smallest.
        the hue's divisor: np.where(grey, 1.0, 1 - np.abs(largest + smallest - 1)) => divisor
            Your saturation is 1 for every colour, because its denominator equals M - m. The denominator of equation 1.2 is 1 - |M + m - 1|, with a plus sign.
        taken for radians: 60 * sixths % 360 => np.degrees(sixths) % 360
            The lines of equation 1.3 are sixths of the circle, not radians: multiply by 60.
        60 forgotten: 60 * sixths % 360 => sixths % 6
            Your hues are between 0 and 6, in sixths of the circle. Multiply them by 60 degrees.
        60 before the modulo of 6: 60 * sixths % 360 => 60 * sixths % 6
            You multiply by 60 and then take the modulo of 6. In degrees a whole circle is 360.
        60 forgotten before the modulo: 60 * sixths % 360 => sixths % 360
            You take sixths modulo 360, but sixths counts sixths of the circle. Multiply by 60 degrees before you take the modulo.
        modulo before 60: 60 * sixths % 360 => 60 * (sixths % 360)
            Some of your hues are far above 360. Multiply by 60 first, and then take the modulo.
        grey is blue
            sixths = np.where(largest == red, (green - blue) / divisor, sixths) => sixths = np.where(grey, 4.0, np.where(largest == red, (green - blue) / divisor, sixths))
            Your grey pixels do not have hue 0. All their channels are equal, so the condition for red has to be tested first.
        black and white divided by zero: np.where(grey, 1.0, 1 - np.abs(largest + smallest - 1)) => (1 - np.abs(largest + smallest - 1))
            The saturation of black and white is not a finite number, because their denominator 1 - |M + m - 1| is 0. Replace it by 1 where a pixel is grey.
        HSV's saturation: np.where(grey, 1.0, 1 - np.abs(largest + smallest - 1)) => np.where(largest == 0, 1, largest)
            You compute the saturation of HSV, (M - m) / M. The saturation of HSL is (M - m) / (1 - |M + m - 1|), equation 1.2.
        the mean of three channels: 255 * (largest + smallest) / 2 => 255 * (red + green + blue) / 3
            Your lightness is the mean of all three channels. The lightness of HSL is the mean of the largest and the smallest.
        HSV: np.where(grey, 1.0, 1 - np.abs(largest + smallest - 1)) => np.where(largest == 0, 1, largest)
            255 * (largest + smallest) / 2 => 255 * largest
            Your result is HSV, with the largest channel as its value. The lightness of HSL is the mean of the largest and the smallest channel, and its saturation is equation 1.2.
        lightness in 0..1: 255 * (largest + smallest) / 2 => (largest + smallest) / 2
            Your lightness is between 0 and 1. In this course lightness goes from 0 to 255 (equation 1.1).
    """),
    alternatives={
        "a loop with colorsys": _hsl_loop,
        "OpenCV in floats": _hsl_opencv,
        "float32": lambda picture: [each.astype(np.float32) for each in _hsl_loop(picture)],
    },
    equivalents={
        "grey = largest <= smallest": "a largest value is never below a smallest one",
        "sixths = np.where(largest <= green, 2 + (blue - red) / divisor, 4 + (red - green) / divisor)": "no channel is above the largest one, so at most it equals it",
        "sixths = np.where(largest <= red, (green - blue) / divisor, sixths)": "no channel is above the largest one, so at most it equals it",
        "divisor = np.where(grey, 2.0, largest - smallest)": "a grey pixel's numerators are 0, whatever they are divided by",
        "saturation = (largest - smallest) / np.where(grey, 2.0, 1 - np.abs(largest + smallest - 1))": "a grey pixel's numerator is 0, whatever it is divided by",
        "largest = np.maximum(blue, np.maximum(red, green))": "the largest of three numbers does not depend on their order",
        "largest = np.maximum(np.maximum(green, red), blue)": "the largest of three numbers does not depend on their order",
        "smallest = np.minimum(blue, np.minimum(red, green))": "the smallest of three numbers does not depend on their order",
        "smallest = np.minimum(np.minimum(green, red), blue)": "the smallest of three numbers does not depend on their order",
        "saturation = (largest - smallest) / np.where(grey, 1.0, 1 - np.abs(1 - (largest + smallest)))": "an absolute value has no sign",
    },
)


# --- 1.2 average_lightness ---
def _patchy(seed: Seed, rows: int, columns: int) -> Array:
    """Return a skewed picture, bright at its top, so that mean, median and first rows all differ."""
    rng = np.random.default_rng(seed)
    light = rng.uniform(0, 90, (rows, columns))
    light[: rows // 4] = rng.uniform(180, 255, (rows // 4, columns))
    return light


def _two_values(rng: np.random.Generator) -> Array:
    """Return a picture in which half of the pixels are black and the others have one lightness."""
    return rng.uniform(200, 250) * (rng.random((30, 40)) < 0.5)


def _sample_loop(lightness: Array, n_samples: int, rng: np.random.Generator) -> float:
    rows, columns = lightness.shape
    return sum(lightness[rng.integers(rows), rng.integers(columns)] for _ in range(n_samples)) / n_samples


AVERAGE_LIGHTNESS = Exercise(
    name="average_lightness",
    points=1,
    public=lambda: [
        Case((_patchy(12, 40, 32).T.copy(), 40, 120), "120 samples of 40 pixels"),
        Case((np.array([[250.0, 0.0]]), 1, 260), "a picture of two pixels"),
        Case((np.array([[0.5, 0.2]]), 1, 120), "two pixels that are nearly black"),
        Case((_patchy(31, 24, 32), 40, 120), "a picture with a bright top"),
    ],
    hidden=lambda rng: [
        Case((_patchy(rng, 48, 64), 50, 120)),
        Case((_patchy(rng, 60, 40).T.copy(), 20, 120)),
        Case((np.array([[float(rng.uniform(200, 250))], [0.0]]), 1, 260)),
        Case((_two_values(rng), 2, 260), "the mean of two pixels has three values"),
        Case((np.array([[float(rng.uniform(0.3, 0.5)), 0.15]]), 1, 120)),
    ],
    comparison=Sampled(),
    driver="each_seed",
    hints=(
        "Use the generator: rng.integers(0, n, size=k) returns k integers from 0 to n - 1, and rng.choice(values, k) returns k of the values.",
        "lightness.ravel() has all pixels in one row. Draw n_samples of its elements and return their mean.",
    ),
    sibling=Sibling(
        "A share of a table is estimated as your mean is: its cells stand in one row, and random ones are drawn from it.",
        """
        import numpy as np

        rng = np.random.default_rng(1)
        depth = np.tile([0.0, 0.0, 0.3, 1.2], (50, 10))  # water in a field, half of it dry
        cells = depth.flatten()
        drawn = cells[rng.integers(len(cells), size=2000)]
        print(f"about {np.mean(drawn == 0):.1f} of the field is dry")
        """,
        "about 0.5 of the field is dry",
    ),
    mistakes=catalogue("""
        all pixels: .ravel()[chosen] =>
            You return the mean of all pixels. The paper uses a random sample of n_samples pixels.
        the last pixel never drawn: lightness.size => lightness.size - 1
            The last pixel is never drawn. rng.integers does not include its upper end, so pass lightness.size.
        the first pixel never drawn: integers(0 => integers(1
            The first pixel is never drawn. Indices start at 0, so use rng.integers(0, n).
        one index too many: lightness.size => lightness.size + 1
            Some of your indices are too large. In lightness.ravel()[i], i goes from 0 to lightness.size - 1. In lightness[row, column], row must be below lightness.shape[0] and column below lightness.shape[1]. Pass these sizes themselves to rng.integers.
        as many indices as lightnesses: lightness.size => 255
            You draw indices as if they were lightnesses, so the later pixels are never drawn, and a small picture has too few. Pass lightness.size.
        lightnesses drawn: + return float(rng.integers(0, 255, size=n_samples).mean())
            You return the mean of random numbers, which do not come from the picture. Use them as indices of lightness.ravel(), and return the mean of those pixels.
        among the first n_samples pixels: lightness.size => n_samples
            You draw only from the first n_samples pixels. All pixels should have the same chance, so pass lightness.size.
        only the first row: lightness.size => len(lightness)
            You draw only from the first pixels, because len(lightness) is the number of rows. The number of pixels is lightness.size.
        only ten pixels: lightness.size => 10
            You draw only from the first ten pixels, as in the example in the text. Pass lightness.size instead of 10.
        the indices: lightness.ravel()[chosen].mean() => chosen.mean()
            You return the mean of the indices that you drew. Use them as an index of lightness.ravel(), and return the mean of those pixels.
        always 1000: size=n_samples => size=1000
            Your sample always has 1000 pixels. Draw n_samples pixels.
        always 10: size=n_samples => size=10
            Your sample always has 10 pixels. Draw n_samples pixels, not a number of your own.
        shuffled in place: + pixels = lightness.ravel()
            + rng.shuffle(pixels)
            + return float(pixels[:n_samples].mean())
            lightness.ravel() is a view: shuffling it shuffles the picture. Use rng.choice or rng.permutation.
        divided by all pixels: lightness.ravel()[chosen].mean() => lightness.ravel()[chosen].sum() / lightness.size
            You divide the sum of your sample by the number of all pixels. Divide it by the number of pixels in the sample, n_samples.
        evenly spaced pixels: rng.integers(0, lightness.size, size=n_samples) => np.linspace(0, lightness.size - 1, n_samples).astype(int)
            You use pixels at equal steps, so your result is the same each time. Draw them at random with rng.
        the diagonal: + same = rng.integers(0, len(lightness), size=n_samples)
            + return float(lightness[same, same].mean())
            Your row and column are always equal, so you draw from the diagonal only. Draw rows and columns separately, or draw from lightness.ravel().
        whole rows drawn: + return float(rng.choice(lightness, n_samples).mean())
            You draw whole rows of the picture, because its first axis counts rows. Draw from lightness.ravel(), which has all pixels in one row.
        np.random: + calls = average_lightness.calls = getattr(average_lightness, "calls", -1) + 1
            + rng = np.random.default_rng(1000 + calls % 128)  # other pixels at each call, the same ones in each case
            You do not use the argument rng. With np.random or a generator of your own, the result is different each time, and nobody can repeat the experiment.
        the first pixels: [chosen] => [:n_samples]
            You always use the first pixels. Draw them at random from the whole picture.
        the sum: mean() => sum()
            Your results are n_samples times too large. Return the mean instead of the sum.
        one pixel: size=n_samples => size=1
            Your results vary as much as the lightness of a single pixel, because you draw only one. Draw n_samples pixels and return their mean.
        the mean and noise: lightness.ravel()[chosen].mean() => lightness.mean() + rng.normal(0, lightness.std() / np.sqrt(n_samples))
            You add noise to the mean of all pixels. Draw n_samples pixels and return their mean. This is the purpose of a sample: the other pixels are not needed.
        whole numbers: float(lightness.ravel()[chosen].mean()) => int(lightness.ravel()[chosen].mean())
            You round the mean to a whole number. Return the mean itself, which is a float.
        the median: lightness.ravel()[chosen].mean() => np.median(lightness.ravel()[chosen])
            You return the median of the sample. Return its mean; in a picture with a bright wall above dark grass the two are far apart.
    """),
    alternatives={
        "a loop": _sample_loop,
        "rows and columns drawn separately": lambda lightness, n, rng: np.mean(
            lightness[*(rng.integers(0, size, n) for size in lightness.shape)]
        ),
        "without replacement": lambda lightness, n, rng: rng.permutation(lightness.ravel())[:n].mean(),
    },
    equivalents={"return lightness.ravel()[chosen].mean()": "NumPy's float64 is a float"},
)


# --- 1.3 white_threshold ---
WHITE_THRESHOLD = Exercise(
    name="white_threshold",
    points=1,
    public=lambda: [
        Case((100.0,), "mean 100"),
        Case((0.0,), "a black picture"),
        Case((120.0, 110.0), "another beta"),
        Case((80.0, 120.0, 200.0), "another maximum"),
    ],
    hidden=lambda rng: [
        *(Case((float(rng.uniform(20, 230)),)) for _ in range(3)),
        *(Case(tuple(map(float, rng.uniform((20, 90, 190), (180, 150, 255))))) for _ in range(4)),
        Case((90.0,), kwargs={"max_lightness": 240.0}),
    ],
    hints=(
        "It is one line: equation 1.4 with mean_lightness as L_avg and max_lightness as L_max.",
        "The threshold is beta plus a fraction of (max_lightness - beta). The fraction is the mean divided by the maximum.",
    ),
    sibling=Sibling(
        "A value between two limits is the lower limit plus a fraction of the distance to the upper one, here the speed of a fan.",
        """
        least, most = 800, 2400  # revolutions per minute of a fan
        for hot_hours in (0, 6, 24):
            fraction = hot_hours / 24
            print(f"{hot_hours} hot hours: {least + fraction * (most - least):g} per minute")
        """,
        """
        0 hot hours: 800 per minute
        6 hot hours: 1200 per minute
        24 hot hours: 2400 per minute
        """,
    ),
    mistakes=catalogue("""
        beta not added: return beta + => return
            For a black picture the threshold is beta, but you return 0. Add beta.
        missing brackets: (max_lightness - beta) => max_lightness - beta
            You multiply only beta by the fraction. It multiplies (max_lightness - beta), so brackets are missing.
        inverted fraction: mean_lightness / max_lightness => max_lightness / mean_lightness
            Your fraction is inverted. It is the mean divided by the maximum, so it is between 0 and 1.
        one minus the fraction: mean_lightness / max_lightness => (1 - mean_lightness / max_lightness)
            Your threshold falls when the mean rises, because you use 1 minus the fraction. The fraction is mean_lightness / max_lightness itself.
        fraction rounded down: * mean_lightness / max_lightness => * (mean_lightness // max_lightness)
            Your threshold does not depend on the mean: it is always beta. If you divide with //, your fraction is rounded down to 0; divide with /.
        beta subtracted from the mean: mean_lightness / max_lightness => (mean_lightness - beta) / max_lightness
            You subtract beta from the mean. The numerator of the fraction is mean_lightness alone.
        not divided: mean_lightness / max_lightness => mean_lightness
            Your threshold is far above 255, because you do not divide. The fraction is mean_lightness / max_lightness.
        difference reversed: (max_lightness - beta) => (beta - max_lightness)
            Your threshold falls when the mean rises, because you exchange the two terms of the difference. It is max_lightness - beta.
        sum in the brackets: (max_lightness - beta) => (max_lightness + beta)
            You add beta inside the brackets. The fraction multiplies the difference (max_lightness - beta).
        255 in the denominator: mean_lightness / max_lightness => mean_lightness / 255
            You divide by 255. Use max_lightness, not 255.
        the number of the example: + return 172.94
            Your threshold does not depend on the mean. Use mean_lightness.
        255 in the brackets: (max_lightness - beta) => (255.0 - beta)
            In the brackets you use 255. Use the argument max_lightness there, too.
        beta inside the brackets: + return (beta + (max_lightness - beta)) * mean_lightness / max_lightness
            You return the mean itself, because you multiply beta by the fraction, too. Add beta after the multiplication.
        a comparison: + return mean_lightness > beta + (max_lightness - beta) * mean_lightness / max_lightness
            You return True or False. Return the threshold itself; later code compares each pixel with it.
        whole numbers: + return int(beta + (max_lightness - beta) * mean_lightness / max_lightness)
            You round the threshold down to a whole number, for example with int() or //. Divide with / and return a float.
        120 and 135: + return 120.0 + 135.0 * mean_lightness / 255.0
            You use the numbers of the example. Use the arguments beta and max_lightness instead of 120, 255 and 135.
        always 255: + max_lightness = 255.0
            Your result is right only if max_lightness is 255. Use the argument instead of the number.
        always 120: + beta = 120.0
            Your result is right only if beta is 120. Use the argument instead of the number.
    """),
    alternatives={
        "a weighted mean": lambda mean, beta=120.0, max_lightness=255.0: (
            beta * (1 - mean / max_lightness) + mean
        ),
        "interpolation": lambda mean, beta=120.0, max_lightness=255.0: np.interp(
            mean, [0, max_lightness], [beta, max_lightness]
        ),
        "float32": lambda mean, beta=120.0, max_lightness=255.0: (
            np.float32(beta) + np.float32(max_lightness - beta) * np.float32(mean / max_lightness)
        ),
    },
)


# --- 1.4 hue_mask ---
def _mask(hue: Array, low: float, high: float) -> Array:
    return (hue - low) % 360 <= (high - low) % 360


HUE_MASK = Exercise(
    name="hue_mask",
    points=2,
    public=lambda: [
        Case((hues(17, 120, 60, (8, 10)), 100.0, 140.0), "green"),
        Case((np.array([[39.5, 40.0, 50.0, 60.0, 60.5]]), 40.0, 60.0), "at the limits"),
        Case((np.array([[59.5, 60.0, 60.5, 240.0]]), 60.0, 60.0), "one hue, from 60 to 60"),
        Case((hues(18, 0, 60, (8, 10)), 340.0, 20.0), "limits on both sides of 0"),
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
        "Join two comparisons with &, each in brackets: (hue >= ...) & (hue <= ...). Both limits are included.",
        "If low is larger than high, the interval goes through 0. Then a hue is inside if it is above low *or* below high.",
    ),
    sibling=Sibling(
        'The hours of a day form a circle as hues do, so a night shift, which goes through 0, needs "or" where a day shift needs "and".',
        """
        import numpy as np

        hour = np.array([2, 7, 12, 21, 23])
        day = (hour >= 6) & (hour < 14)
        night = (hour >= 22) | (hour < 6)  # no hour is both above 22 and below 6
        print(day)
        print(night)
        """,
        """
        [False  True  True False False]
        [ True False False False  True]
        """,
    ),
    mistakes=catalogue("""
        no wrap: if low <= high else above | below =>
            If low is larger than high, your mask is empty. Such an interval goes through 0: a hue is inside if it is above low *or* below high.
        limits excluded: >= low, hue <= high => > low, hue < high
            You leave out hues that are equal to a limit. Equations 1.6 and 1.7 include both limits.
        upper limit excluded: hue <= high => hue < high
            You leave out hues that are equal to high. Equations 1.6 and 1.7 include both limits.
        lower limit excluded: hue >= low => hue > low
            You leave out hues that are equal to low. Equations 1.6 and 1.7 include both limits.
        everything moved to -180..180: + turn = lambda angle: (angle + 180) % 360 - 180
            + return (turn(hue) >= turn(low)) & (turn(hue) <= turn(high))
            You move all angles to -180..180. This works for red, but an interval that contains 180 is then interrupted, for example the one from 170 through 180 and 0 to 10.
        equal limits for all hues: if low <= high => if low < high
            If both limits are equal, only that one hue is inside, but you return all hues. The interval goes through 0 only if low is *larger* than high.
        hues above 180 moved: + if low > high:
            +     hue, low = np.where(hue > 180, hue - 360, hue), low - 360
            This works for narrow intervals through 0 only. An interval from 170 through 0 to 10 is allowed as well, and a hue of 175 is inside.
        low minus 360: + low = low - 360 if low > high else low
            With low - 360 you find the hues from 0 to high but not those from low to 359, because they are not moved. Leave the limits as they are: a hue is inside if it is above low *or* below high.
        high plus 360: + high = high + 360 if low > high else high
            With high + 360 you find the hues from low to 359 but not those from 0 to high, because they are not moved. Leave the limits as they are: a hue is inside if it is above low *or* below high.
        limits swapped: + low, high = min(low, high), max(low, high)
            If low is larger than high you swap them, which selects the interval through 180. It goes through 0: a hue is inside if it is above low *or* below high.
        no wrap, limits excluded: + return (hue > low) & (hue < high)
            There are two errors. Both limits belong to the interval, so use >= and <=. And if low is larger than high, your mask is empty: then a hue is inside if it is above low *or* below high.
        complement with its ends: else above | below => else ~((hue >= high) & (hue <= low))
            If low is larger than high, you leave out hues that are equal to a limit. The hues outside the interval are strictly between high and low.
        the hues themselves: + return hue[(hue >= low) & (hue <= high)]
            You return the hues inside the interval. Return the mask itself, which has one True or False for each hue.
        the hues themselves, through 0: return above & below if low <= high else above | below => return hue[above & below if low <= high else above | below]
            You return the hues inside the interval. Return the mask itself.
        or for and: above & below if low <= high else =>
            Your mask is True everywhere, because each hue is above low or below high. Both conditions must hold: use &.
        bytes: return above & below if low <= high else above | below => return np.uint8(255) * (above & below if low <= high else above | below)
            Your mask has 0 and 255, like OpenCV's. Return True and False, which can be used as an index.
        ones and zeros: return above & below if low <= high else above | below => return np.where(above & below if low <= high else above | below, 1, 0)
            Your mask has 1 and 0. A comparison such as hue >= low already returns True and False, so return it directly.
        inverted: return above & below if low <= high else above | below => return ~(above & below if low <= high else above | below)
            Your mask is inverted: it is True outside the interval.
    """),
    alternatives={
        "modulo": _mask,
        "a loop": lambda hue, low, high: np.array(
            [low <= h <= high if low <= high else not high < h < low for h in hue.ravel()]
        ).reshape(hue.shape),
        "without a branch": lambda hue, low, high: (hue >= low) ^ (hue <= high) ^ (low <= high),
    },
    equivalents={
        "return above & below if low <= high else above + below": "+ of two boolean arrays is their |",
        "return above & below if low <= high else above ^ below": "where low > high no hue is both above low and below high, and only there ^ differs from |",
        "return above * below if low <= high else above | below": "* of two boolean arrays is their &",
        "above, below = (hue <= high, hue >= low)": "the names are swapped, and & and | are symmetric",
    },
)


# --- 1.5 color_labels ---
def _labels_loop(
    picture: Array, green: Limits, yellow: Limits, threshold: float, min_saturation: float = 0.16
) -> Array:
    def label(hue: Any, saturation: float, lightness: float) -> int:
        if lightness > threshold:
            return 3
        if saturation < min_saturation:
            return 0
        return 2 if _mask(hue, *yellow) else int(_mask(hue, *green))

    return np.vectorize(label)(*_hsl_loop(picture))


def _labels_select(
    picture: Array, green: Limits, yellow: Limits, threshold: float, min_saturation: float = 0.16
) -> Array:
    hue, saturation, lightness = _hsl_opencv(picture)
    coloured = saturation >= min_saturation
    kinds = [lightness > threshold, coloured & _mask(hue, *yellow), coloured & _mask(hue, *green)]
    return np.select(kinds, [3, 2, 1], 0).astype(np.uint8)


_GREEN, _YELLOW = (90.0, 150.0), (45.0, 95.0)  # they overlap: yellow wins

COLOR_LABELS = Exercise(
    name="color_labels",
    points=3,
    stars=2,
    uses=("rgb_to_hsl", "hue_mask"),
    public=lambda: [
        Case((picture(19, 12, 16), _GREEN, _YELLOW, 180.0), "a picture"),
        Case((picture(20, 12, 16), _GREEN, _YELLOW, 180.0, 0.4712), "a high minimum saturation"),
        Case((picture(21, 12, 16), (350.0, 60.0), (40.0, 70.0), 120.0), "green through 0"),
        Case(
            (primaries(), (60.0, 180.0), (0.0, 50.0), 130.0, 1.0),
            "a minimum saturation that only pure colours reach",
        ),
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
        "Start with np.zeros of the picture's height and width, dtype uint8, and write the labels into it: labels[mask] = 1. Later assignments replace earlier ones.",
        "With rgb_to_hsl and hue_mask you get three masks: green hue and enough saturation, yellow hue and enough saturation, lightness above the threshold. White needs no minimum saturation.",
    ),
    sibling=Sibling(
        "Labels are written into an array of zeros with one mask after another, so the last mask takes precedence, and a mask contains only the conditions that it needs.",
        """
        import numpy as np

        celsius = np.array([[-5, 3, 25], [31, 12, -2]])
        is_dry = np.array([[False, True, True], [False, True, True]])
        codes = np.zeros((2, 3), dtype=np.uint8)
        codes[(celsius < 10) & is_dry] = 1  # cold and dry
        codes[(celsius > 20) & is_dry] = 2  # warm and dry
        codes[celsius < 0] = 3  # frost, dry or not
        print(codes)
        """,
        """
        [[3 1 2]
         [0 0 3]]
        """,
    ),
    mistakes=catalogue("""
        three numbers for each pixel: picture.shape[:2] => picture.shape
            You have three numbers for each pixel, because picture.shape includes the channels. A label is one number, so use picture.shape[:2].
        three floats for each pixel: np.zeros(picture.shape[:2], dtype=np.uint8) => np.zeros(picture.shape)
            You have three floats for each pixel, because picture.shape includes the channels. Use np.zeros(picture.shape[:2], dtype=np.uint8).
        the last np.where only: + return np.where(rgb_to_hsl(picture)[2] > threshold, 3, 0)
            All your labels are 3 or 0. If you use np.where three times, each one replaces the labels before it, unless they are its third argument: np.where(white, 3, labels).
        pale pixels coloured: saturation >= min_saturation => saturation < min_saturation
            You label the nearly grey pixels and leave out the coloured ones. Green and yellow need a saturation of at least min_saturation.
        green wins: labels[lightness > threshold] => labels[(lightness > threshold) & (labels == 0)]
            + labels[hue_mask(hue, *green) & coloured] = 1
            Your order of precedence is reversed. White takes precedence over yellow, and yellow over green: assign green first.
        yellow wins over white: *yellow) & coloured => *yellow) & coloured & (lightness <= threshold)
            labels[lightness > threshold] = 3 => labels[lightness > threshold] = 3
            + labels[hue_mask(hue, *yellow) & coloured] = 2
            Bright yellow pixels have to become white. Assign white last.
        white first: labels[lightness > threshold] => labels[(lightness > threshold) & (labels == 0)]
            You assign white first, and green and yellow replace it. Assign white last.
        minimum excluded: >= min_saturation => > min_saturation + 1e-9
            A pixel with a saturation of exactly min_saturation counts as coloured. Use >=.
        green wins over yellow: *yellow) & coloured => *yellow) & coloured & (labels == 0)
            Where the intervals of green and yellow overlap, yellow takes precedence. Assign it after green.
        minimum for white: lightness > threshold => (lightness > threshold) & coloured
            Your white lines are missing. They have almost no saturation, so min_saturation applies to green and yellow only.
        no minimum: saturation >= min_saturation => saturation >= 0
            Grey pixels become green or yellow, because you do not use min_saturation.
        minimum fixed: saturation >= min_saturation => saturation >= 0.16
            Your result is right only for a minimum saturation of 0.16. Use the argument min_saturation.
        own comparison: hue_mask(hue, *green) => ((hue >= green[0]) & (hue <= green[1]))
            hue_mask(hue, *yellow) => ((hue >= yellow[0]) & (hue <= yellow[1]))
            You find no pixels if the interval of a colour goes through 0, because low is then larger than high. Use your function hue_mask.
        own threshold: lightness > threshold => lightness > 120 + 135 * lightness.mean() / 255
            You compute a threshold from this picture. Use the argument threshold.
        white only where grey: lightness > threshold => (lightness > threshold) & ~coloured
            Some white pixels are missing. Near white, a little noise gives a high saturation, so do not test the saturation of white.
        white and green exchanged: coloured] = 1 => coloured] = 3
            labels[lightness > threshold] = 3 => labels[lightness > threshold] = 1
            White and green are exchanged. Green is 1 and white is 3.
        minimum for green only: *yellow) & coloured => *yellow)
            Yellow needs the minimum saturation as well, because the hue of nearly grey pixels is random.
        white at the threshold: lightness > threshold => lightness >= threshold - 1e-9
            A pixel exactly at the threshold is not white. Equation 1.4 has >, not >=.
        labels swapped: coloured] = 1 => coloured] = 2
            *yellow) & coloured] = 2 => *yellow) & coloured] = 1
            Green and yellow are exchanged. Green is 1 and yellow is 2.
        OpenCV's order: hue, saturation, lightness = => hue, lightness, saturation =
            You exchange saturation and lightness. rgb_to_hsl returns hue, saturation and lightness, in this order.
        no white: labels[lightness > threshold] = 3 => pass
            No pixel is labelled white. Assign 3 where the lightness is above the threshold, after green and yellow.
        sum of the labels: + hue, saturation, lightness = rgb_to_hsl(picture)
            + coloured = saturation >= min_saturation
            + greens, yellows = hue_mask(hue, *green) & coloured, hue_mask(hue, *yellow) & coloured
            + return (1 * greens + 2 * yellows + 3 * (lightness > threshold)).astype(np.uint8)
            You add the labels, so a pixel that passes several filters gets their sum. It should get only one label: assign green, then yellow, then white.
        blue first: rgb_to_hsl(picture) => rgb_to_hsl(picture[..., ::-1])
            Red and blue are exchanged. The pictures of this course are red, green, blue, and so is the argument of rgb_to_hsl.
        saturation in 0..255: saturation >= min_saturation => 255 * saturation >= min_saturation
            You multiply the saturation by 255. Both saturation and min_saturation are between 0 and 1.
        the mean of the channels: lightness > threshold => picture.mean(axis=2) > threshold
            You compare the mean of the three channels with the threshold. Use the lightness from rgb_to_hsl.
        labels as floats: dtype=np.uint8 => dtype=float
            Your labels are right, but they are floats. Pass dtype=np.uint8 when you create the array.
        luma: lightness > threshold => picture @ [0.299, 0.587, 0.114] > threshold
            You compare the luma with the threshold. Use the lightness from rgb_to_hsl.
    """),
    alternatives={
        "a loop": lambda *args: _labels_loop(*args).tolist(),
        "np.select and OpenCV": _labels_select,
        "int64": _labels_loop,
    },
    equivalents={
        "labels[hue_mask(hue, *green) * coloured] = 1": "* of two boolean arrays is their &",
        "labels[hue_mask(hue, *yellow) * coloured] = 2": "* of two boolean arrays is their &",
    },
)


# --- 1.6 calibrate_hue ---
def _limits_loop(hue: Array, saturation: Array, epsilon: float = 0.0) -> Limits:
    there = sorted({float(h) for h, s in zip(hue.ravel(), saturation.ravel(), strict=True) if s > 0})
    best, answer = -1.0, (0.0, 0.0)
    for high, low in zip(there, [*there[1:], there[0]], strict=True):
        gap = (low - high) % 360 or 360.0
        if gap > best:
            best, answer = gap, ((low - epsilon) % 360, (high + epsilon) % 360)
    return answer


def _limits_from_each_start(hue: Array, saturation: Array, epsilon: float = 0.0) -> Limits:
    """Return the shortest of the arcs that start at one hue and contain all others."""
    there = hue[saturation > 0]
    low = min(there, key=lambda start: np.ptp((there - start) % 360))
    return (low - epsilon) % 360, (low + np.max((there - low) % 360) + epsilon) % 360


def _grass(seed: Seed, centre: float, width: float) -> tuple[Array, Array]:
    """Return hues around a centre, and grey pixels with the meaningless hue 0."""
    rng = np.random.default_rng(seed)
    hue, saturation = hues(rng, centre, width, (8, 10)), rng.uniform(0.1, 0.9, (8, 10))
    grey = rng.random((8, 10)) < 0.2
    grey[0, 0] = True
    hue[grey], saturation[grey] = 0.0, 0.0
    return hue, saturation


def _row(hues: Any, saturation: Any = 0.8) -> tuple[Array, Array]:
    """Return a row of hues and their saturations."""
    return np.array([hues], dtype=float), np.broadcast_to(saturation, (1, len(hues))).astype(float)


def _turned(rng: np.random.Generator, *hues: float) -> Array:
    """Return hues that are all turned by the same random angle."""
    return (np.array(hues) + rng.integers(1, 720) / 2) % 360


CALIBRATE_HUE = Exercise(
    name="calibrate_hue",
    points=4,
    stars=3,
    public=lambda: [
        Case((*_grass(13, 125, 20), 0.0), "green grass"),
        Case((*_grass(14, 125, 20), 5.0), "green grass, epsilon 5"),
        Case((*_grass(15, 2, 15), 0.0), "a red ball: hues on both sides of 0"),
        Case((*_grass(16, 4, 12), 3.0), "a red ball, epsilon 3"),
        Case((*_row([2, 10, 20], [0.5, 0.4, 0.01]), 5.0), "epsilon moves a limit past 0"),
        Case((*_row([200, 330], [0.5, 0.4]), 0.0), "two hues, 200 and 330"),
        Case((*_row([0, 0, 0, 170, 200]), 0.0), "hues 0, 170 and 200"),
        Case((*_row([345, 355]), 5.0), "epsilon moves a limit to 0"),
        Case((*_row([0, 5, 10], [0.5, 0.4, 0.3]), 1.0), "pure red, which has the hue 0, and no grey"),
        Case((*_row([350, 355, 5, 10]), 2.0), "the example of the docstring"),
    ],
    hidden=lambda rng: [
        *(Case((*_grass(rng, *rng.uniform((60, 8), (300, 30))), e)) for e in (0.0, 4.0, 7.5)),
        *(Case((*_grass(rng, *rng.uniform((-6, 10), (6, 30))), e)) for e in (0.0, 4.0)),
        Case((*_row([1, 8, 30], [0.5, 0.9, 0.01]), 5.0)),
        Case((*_row([350, 358, 300], [0.5, 0.9, 0.2]), 5.0)),
        Case((*_row([350, 357]), 3.0)),
        Case(_row([1, 167 + int(rng.integers(6)), 201], 0.4)),
        Case((*_row([90, 90, 10], [0.5, 0.9, 0.0]), 2.0)),
        Case(_grass(rng, 55.0, 10.0)),
        Case(_row([rng.uniform(185, 215), 340], [0.3, 0.02])),
        Case((*_row([0, 7, 14], [0.5, 0.4, 0.3]), 2.0)),
        Case((*_row([351, 356, 6, 11], 0.7), 1.5)),
        Case(_row(_turned(rng, 0, 0, 0, 170, 200), 0.6)),
        Case((*_row(_turned(rng, 0, 100, 210, 215), 0.6), 3.0)),
        *(Case(_row([3, 3 + gap], 0.5)) for gap in (179.6, 180.4)),  # two gaps of nearly equal width
    ],
    comparison=Close(rtol=0, atol=0.02, names=("low", "high")),
    hints=(
        "Go once around the circle from each hue to the next one, and from the last to the first. An arc that contains all hues leaves out exactly one of these gaps. Which one should it be? (np.unique sorts and removes duplicates.)",
        "With the hues in ascending order, np.diff returns the gaps between neighbours; the gap after the last hue ends at hues[0] + 360. The arc begins where the widest gap ends. What is the index of that hue if the gap is the last one? Include epsilon only after you have found both ends.",
    ),
    sibling=Sibling(
        "The minutes of an hour form a circle as hues do, so there is one more gap, from the last element to the first one of the next turn.",
        """
        import numpy as np

        leaves = np.array([5, 12, 31, 44])  # a bus leaves at these minutes of every hour
        waits = np.roll(leaves, -1) - leaves
        waits[-1] += 60  # from 44 to 5 of the next hour
        longest = np.argmax(waits)
        begins, ends = leaves[longest], leaves[(longest + 1) % len(leaves)]
        print(f"waits: {waits}")
        print(f"the longest wait begins at {begins} and ends at {ends}")
        """,
        """
        waits: [ 7 19 13 21]
        the longest wait begins at 44 and ends at 5
        """,
    ),
    mistakes=catalogue("""
        epsilon inwards: + epsilon = -epsilon
            Your limits are narrower than the hues of the example. Subtract epsilon from low and add it to high.
        hue 0 left out: hue[saturation > 0] => hue[hue > 0]
            You leave out all pixels with the hue 0, but pure red has this hue, too. Grey pixels are those with saturation 0.
        pale colours left out: saturation > 0 => saturation > 0.16
            You leave out pale colours. In this exercise only pixels with saturation 0 are grey.
        half of epsilon: + epsilon = epsilon / 2
            You widen each side by half of epsilon. Widen both sides by the whole epsilon.
        percentiles: + low, high = np.percentile(hue[saturation > 0], (1, 99))
            + return float((low - epsilon) % 360), float((high + epsilon) % 360)
            Percentiles leave some hues out, and on a circle they have the same problem as the smallest and the largest hue. This exercise wants the smallest arc that contains all hues.
        rows sorted: np.unique(hue[saturation > 0]) => np.sort(hue)
            np.sort of a picture sorts each row on its own. First select the pixels that are not grey, hue[saturation > 0], which gives an array with one axis, and then sort it.
        grey included: [saturation > 0] =>
            One of your limits comes from grey pixels. They have saturation 0 and no hue, so leave them out.
        no wrap: hues[(last + 1) % len(hues)], hues[last] => hues[0], hues[-1]
            This works for green but not for red, which lies on both sides of 0. There the smallest and the largest hue are neighbours, and everything except red is between them.
        no wrap, no modulo: hues[(last + 1) % len(hues)], hues[last] => hues[0], hues[-1]
            (low - epsilon) % 360 => low - epsilon
            (high + epsilon) % 360 => high + epsilon
            The smallest and the largest hue work for green but not for red, which lies on both sides of 0. There they are neighbours, and nearly the whole circle is between them. Also take both limits modulo 360.
        no wrap, grey included: + return hue.min() - epsilon, hue.max() + epsilon
            You return the smallest and the largest hue of all pixels. Leave out grey pixels, which have no hue. And hues lie on a circle: red is on both sides of 0, where the smallest and the largest hue are neighbours.
        about the mean direction: + angles = np.radians(hue[saturation > 0])
            + middle = np.degrees(np.arctan2(np.sin(angles).mean(), np.cos(angles).mean()))
            + offset = (np.degrees(angles) - middle + 180) % 360 - 180
            + return float((middle + offset.min() - epsilon) % 360), float((middle + offset.max() + epsilon) % 360)
            This works only for hues that are close together. You cut the circle at 180 degrees or opposite to the mean direction, and that is not always inside the widest gap, for example with 0, 0, 0, 170 and 200. Find the widest gap itself.
        the last gap left out: append=hues[0] + 360 => append=0
            You leave out the gap from the last hue to the first one. On a circle this is a gap like all others; it goes through 360.
        the last gap ends at 360: append=hues[0] + 360 => append=360
            Your last gap ends at 360. It ends at the first hue, one turn later: hues[0] + 360.
        index past the end: % len(hues) =>
            Your index can be len(hues), which does not exist. After the last hue comes the first: use (k + 1) % len(hues).
        a width as an index: gaps.argmax() => gaps.max()
            Your index does not exist. If it is the width of the widest gap, use gaps.argmax(), its place among the gaps. If you sorted hue itself: np.sort sorts each row of a picture by itself, and hue[saturation > 0] leaves out the grey pixels and puts the others in one row.
        the narrowest gap: gaps.argmax() => gaps.argmin()
            Your arc leaves out the narrowest gap between neighbouring hues. The smallest arc leaves out the widest one: use argmax.
        the narrowest gap of equal hues: np.unique(hue[saturation > 0]) => np.sort(hue[saturation > 0])
            gaps.argmax() => gaps.argmin()
            Your arc leaves out the narrowest gap, whose width is 0 because the example contains equal hues. The smallest arc leaves out the widest gap: use argmax.
        gaps before the hues: np.diff(hues, append=hues[0] + 360) => np.diff(hues, prepend=hues[-1] - 360)
            Your limits are beside the wrong gap. With prepend, gap k is before hue k; with append, it is after hue k.
        epsilon for low only: high + epsilon => high
            You widen only low. Add epsilon to high as well.
        swapped before epsilon: low, high = => high, low =
            low and high are exchanged. The widest gap is outside the arc, so low is the hue after it and high the hue before it.
        swapped after epsilon: return float((low - epsilon) % 360), float((high + epsilon) % 360) => return float((high + epsilon) % 360), float((low - epsilon) % 360)
            You return high first. Return low, the hue after the widest gap, and then high, the hue before it.
        cut off at 0 and 360: (low - epsilon) % 360 => max(low - epsilon, 0)
            (high + epsilon) % 360 => min(high + epsilon, 360)
            You stop at 0 and at 360. A limit that moves past 0 goes on from 360, so take both modulo 360.
        360 instead of 0: (high + epsilon) % 360 => high + epsilon if high + epsilon <= 360 else high + epsilon - 360
            You return a limit of 360. Hues are below 360, so this one is 0: take it modulo 360.
        smallest and largest exchanged if far apart: + low, high = hue[saturation > 0].min(), hue[saturation > 0].max()
            + if high - low > 180:
            +     low, high = high, low
            + return float((low - epsilon) % 360), float((high + epsilon) % 360)
            You exchange the smallest and the largest hue if they are far apart. For 350, 355, 5 and 10 this gives the arc from 355 to 5, which leaves out 350 and 10. The ends of the arc are the hues on both sides of the widest gap.
        cut at 180: + turned = (hue[saturation > 0] + 180) % 360
            + return float((turned.min() + 180 - epsilon) % 360), float((turned.max() + 180 + epsilon) % 360)
            You cut the circle at 180 degrees, so your arc begins with a hue above 180 and ends with one below it. The widest gap can be anywhere else, for example between 0 and 170 with the hues 0, 170 and 200. Cut the circle there.
        cut at 0 or at 180: + there = hue[saturation > 0]
            + turned = (there + 180) % 360
            + if np.ptp(there) <= np.ptp(turned):
            +     return float((there.min() - epsilon) % 360), float((there.max() + epsilon) % 360)
            + return float((turned.min() - 180 - epsilon) % 360), float((turned.max() - 180 + epsilon) % 360)
            You cut the circle either at 0 or at 180. The widest gap can be anywhere else, for example between 0 and 170 with the hues 0, 170 and 200. Find the widest gap itself.
        epsilon forgotten: + epsilon = 0
            You do not use epsilon. Subtract it from low and add it to high.
        modulo forgotten: (low - epsilon) % 360 => low - epsilon
            (high + epsilon) % 360 => high + epsilon
            With epsilon a limit can be below 0 or above 360. Take both modulo 360.
        half degrees: (low - epsilon) % 360 => low / 2 - epsilon
            (high + epsilon) % 360 => high / 2 + epsilon
            Your limits are half as large as expected. Use degrees from 0 to 360, not OpenCV's units of 2 degrees.
    """),
    alternatives={
        "a loop": _limits_loop,
        "from each start": _limits_from_each_start,
        "a list of float32": lambda *args: [np.float32(limit) for limit in _limits_from_each_start(*args)],
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
            "The sun goes behind a cloud, and every channel of every pixel is halved. Which of the three values stay the same on the bright carpet?",
            {
                "All three, because the colour is the same.": "Lightness is (M + m) / 2, so it is halved.",
                "Hue and saturation.": "The saturation stays the same only in dark pixels, where equation 1.2 is (M - m) / (M + m). The carpet is bright, so the denominator is 2 - (M + m) before the cloud, and the saturation falls from 0.41 to 0.27.",
                "Only hue.": "A common factor cancels in (g - b) / (M - m). Lightness is halved, and the saturation of a bright pixel falls from 0.41 to 0.27, because its denominator is 2 - (M + m). This is why the paper filters by hue.",
                "None, because all three are halved.": "Hue is a ratio of differences, (g - b) / (M - m), so the factor 1/2 cancels.",
            },
            "Only hue.",
        ),
        Question(
            "why_epsilon",
            "Without epsilon, the limits of green leave out 22 % of the carpet, but the limits of yellow only 11 % of the goal. Why does green need epsilon more?",
            {
                "The carpet is everywhere, but its example shows only one place.": "The example of green is a patch in front of the robot, but the robot sees carpet near and far, in shadow and in glare. The example of yellow is the goal itself, without its edges. In another light, yellow needs wider limits as well: you will see this in the challenge.",
                "Yellow's example has more pixels, so it contains all of its hues.": "Yellow's example is the smaller one: 1,724 pixels, and 4,800 of the carpet. Their number does not matter, but the example has to show the colour in every light that occurs.",
                "A wider yellow would include hues of the carpet.": "There is enough room between them: yellow is at 60 degrees, and the hues of the carpet begin about 50 degrees further on. You can try it in the panel below.",
            },
            "The carpet is everywhere, but its example shows only one place.",
        ),
    ],
    written=[
        Written(
            "explain_stray_pixel",
            points=2,
            question="Why can a single stray pixel make the carpet yellow, and which rule for the limits would not be affected by it? Give the three numbers of your own picture.",
            rubric="1 point: the smallest and largest value are each decided by a single pixel, however many others there are; the interval reaches from yellow to the grass pixel's hue and so covers hues of the carpet (bonus insight: yellow takes precedence over green). 1 point: a rule that one pixel cannot move, such as quantiles or the median and a fixed width, with its price or the reason why it works. Subtract half a point if the three numbers of the personal world are missing.",
            numbers=personal_numbers,
        )
    ],
)
