"""How long it takes from a picture to posts and corners by the lessons' own solutions, stage by stage, on one core.

Lesson 01 writes the change to hue, saturation and lightness out, and shows that it is OpenCV's; from then on OpenCV's
counts, so the sum has its labels. Beside it stand the sum of OpenCV's own calls alone, and the same stages pixel by
pixel in Python.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from benchmarks import ROOT, Result, Table
from benchmarks.pictures.posts import COLOURS, MOST_MS, OWN, label, loop_over_columns, milliseconds
from nao_course.colours import GREEN, YELLOW
from nao_course.exercises import load_definitions
from nao_course.sim import standard_scenes

Pixels = npt.NDArray[np.uint8]
CORNERS = load_definitions(ROOT / "solutions" / "03_hough_corners.ipynb")
FLOOR = 0.16  # of the saturation
EVERY = 3  # of the tuning pictures
SLOW_PICTURES = 1  # pixel by pixel: a large picture takes half a minute


def quick_labels(picture: Pixels) -> Pixels:
    """Return labels by OpenCV's conversion of colours: hue in half degrees, saturation and lightness as integers."""
    hls = cv2.cvtColor(picture, cv2.COLOR_RGB2HLS)
    lightness = cv2.extractChannel(hls, 1)
    labels = np.zeros(lightness.shape, dtype=np.uint8)
    for number, (low, high) in ((1, GREEN), (2, YELLOW)):
        labels[_in_range(hls, (low / 2, 0, 255 * FLOOR), (high / 2, 255, 255))] = number
    labels[lightness > COLOURS["white_threshold"](cv2.mean(lightness)[0])] = 3
    return labels


def _in_range(hls: Any, low: tuple[float, ...], high: tuple[float, ...]) -> npt.NDArray[np.bool_]:
    """Return where all three channels are within limits."""
    return np.asarray(cv2.inRange(hls, np.ceil(low), np.floor(high))).view(np.bool_)


def lines_of(picture: Pixels) -> Pixels:
    """Return the input of Canny's edge detector."""
    return CORNERS["line_picture"](CORNERS["erase_background"](quick_labels(picture)))


def calls_alone(picture: Pixels, lines: Pixels) -> None:
    """Run only OpenCV's calls of the whole pipeline."""
    hls = cv2.cvtColor(picture, cv2.COLOR_RGB2HLS)
    for low, high in ((45, 80), (22, 34), (0, 180)):
        cv2.inRange(hls, (low, 0, 41), (high, 255, 255))
    cv2.HoughLinesP(cv2.Canny(lines, 50, 150), 1, np.pi / 180, 20, minLineLength=40, maxLineGap=5)


def pixel_by_pixel(picture: Pixels) -> Any:
    """Run the pipeline with loops over pixels for labels, feet, background and lines; Canny and Hough are OpenCV's."""
    threshold = COLOURS["white_threshold"](picture.max(axis=2).mean() / 2 + picture.min(axis=2).mean() / 2)
    height, width = picture.shape[:2]
    labels = np.zeros((height, width), dtype=np.uint8)
    for v in range(height):
        for u in range(width):
            red, green, blue = map(int, picture[v, u])
            labels[v, u] = _label_of(red, green, blue, threshold)
    loop_over_columns(labels)
    kept = labels.copy()
    for u in range(width):
        count = v = 0
        while v < height and count < 7:
            count = count + 1 if labels[v, u] == 1 else 0
            v += 1
        kept[: v - 7 if count == 7 else height, u] = 0
    return CORNERS["hough_segments"](CORNERS["line_picture"](kept))


def _label_of(red: int, green: int, blue: int, threshold: float) -> int:
    """Return the label of one pixel."""
    most, least = max(red, green, blue), min(red, green, blue)
    if (most + least) / 2 > threshold:
        return 3
    chroma = most - least
    if not chroma or chroma < FLOOR * (most + least if most + least < 255 else 510 - most - least):
        return 0
    if most == red:
        hue = 60 * ((green - blue) / chroma % 6)
    else:
        hue = 60 * ((blue - red) / chroma + 2 if most == green else (red - green) / chroma + 4)
    return 2 if YELLOW[0] <= hue <= YELLOW[1] else int(GREEN[0] <= hue <= GREEN[1])


def timed(pictures: Sequence[Pixels]) -> dict[str, float]:
    """Return the milliseconds per picture, by stage."""
    labels, lines = ([make(each) for each in pictures] for make in (quick_labels, lines_of))
    prepared = {id(picture): white for picture, white in zip(pictures, lines, strict=True)}

    def all_of_it(picture: Pixels) -> None:
        found = quick_labels(picture)
        OWN["find_goalposts"](found)
        CORNERS["find_corners"](found)

    stages: dict[str, tuple[Callable[[Any], Any], Sequence[Any]]] = {
        "labels, written out": (label, pictures),
        "labels": (quick_labels, pictures),
        "posts": (OWN["find_goalposts"], labels),
        "corners": (CORNERS["find_corners"], labels),
        "picture to posts and corners": (all_of_it, pictures),
        "OpenCV's calls alone": (lambda picture: calls_alone(picture, prepared[id(picture)]), pictures),
        "pixel by pixel": (pixel_by_pixel, pictures[:SLOW_PICTURES]),
    }
    return {name: milliseconds(function, given) for name, (function, given) in stages.items()}


def agreement(pictures: Sequence[Pixels]) -> float:
    """Return the share of the pixels that have the same label by OpenCV's colours as by the lesson's."""
    return float(np.mean([(quick_labels(each) == label(each)).mean() for each in pictures]))


def main() -> Result:
    """Time all stages at three sizes."""
    scenes = [scene.pixels for scene in standard_scenes("tune")][::EVERY]
    found = {}
    for width, most in MOST_MS.items():
        pictures = [
            cv2.resize(each, (width, width * 3 // 4), interpolation=cv2.INTER_LINEAR) for each in scenes
        ]
        found[width] = {**timed(pictures), "most": most}
    table = Table(
        "picture to posts and corners, ms a picture on one core",
        ("width", *next(iter(found.values()))),
        tuple((width, *each.values()) for width, each in found.items()),
    )
    same = agreement(scenes)
    note = f"{same:.2%} of the labels are the same by OpenCV's colours as by those written out in lesson 01"
    return Result("pipeline", {"ms": found, "same labels": same}, (table,), (note,))
