"""What a picture's carpet is, and how light and how coloured every pixel is."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray

Pixels = npt.NDArray[np.uint8]

SMALLEST = 24  # px: a picture with fewer rows or columns shows no line
LEAST_CARPET = 0.004  # of the picture's pixels
# Hue in half degrees; lightness; saturation: 0.16 of 255, as in lesson 01.
GREEN, DARKEST, PALEST = ((32, 100), 25, 41)
SPREAD = 14  # half degrees about the carpet's most frequent hue


@dataclass(frozen=True, eq=False)
class Planes:
    """A picture taken apart.

    Parameters
    ----------
    lightness, chroma : ndarray of uint8, shape (H, W)
        Half of, and difference between, the largest and the smallest channel; lightness is their mean.
    carpet : ndarray of uint8, shape (H, W)
        1 where the hue is the carpet's.
    """

    lightness: Pixels
    chroma: Pixels
    carpet: Pixels

    @property
    def scale(self) -> float:
        """How many pixels of this picture are one of a picture 320 wide."""
        return self.carpet.shape[1] / 320

    @property
    def first_row(self) -> int:
        """The first row that holds some carpet: a tenth of its pixels."""
        rows = np.flatnonzero(cv2.reduce(self.carpet, 1, cv2.REDUCE_AVG, dtype=cv2.CV_32F).ravel() > 0.1)
        return int(rows[0]) if len(rows) else len(self.carpet)


def take_apart(picture: Pixels) -> Planes | None:
    """Find the carpet in a picture (H, W, 3) by the most frequent of its greens; None if there is hardly any."""
    if min(picture.shape[:2]) < SMALLEST:
        return None
    hls = cv2.cvtColor(picture, cv2.COLOR_RGB2HLS)
    some_green = cv2.inRange(hls, (GREEN[0], DARKEST, PALEST), (GREEN[1], 255, 255))
    if cv2.countNonZero(some_green) < LEAST_CARPET * some_green.size:
        return None
    frequency: FloatArray = cv2.calcHist([hls], [0], some_green, [180], [0, 180]).ravel().astype(float)
    hue = int(np.convolve(frequency, np.ones(9), "same").argmax())
    carpet = cv2.inRange(hls, (hue - SPREAD, DARKEST, PALEST), (hue + SPREAD, 255, 255)) & 1
    red, green, blue = cv2.split(picture)
    chroma = cv2.subtract(cv2.max(cv2.max(red, green), blue), cv2.min(cv2.min(red, green), blue))
    return Planes(cv2.extractChannel(hls, 1), chroma, carpet)
