"""The colours of carpet and goal posts in lessons 02 to 11, and the mean lightness of a picture."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

# Limits of the hue in degrees. They are wider than the limits calibrated for one scene in lesson 01, because the
# light differs from place to place. With the narrow limits, half of the goal posts have ragged edges.
GREEN, YELLOW = (90.0, 160.0), (44.0, 68.0)


def mean_lightness(picture: npt.NDArray[np.uint8]) -> float:
    """Return the mean lightness (max + min) / 2 of all pixels of a picture (H, W, 3), 0 to 255.

    >>> mean_lightness(np.array([[[10, 20, 40], [0, 0, 1]]], dtype=np.uint8))
    12.75
    """
    red, green, blue = cv2.split(picture)
    most, least = cv2.max(cv2.max(red, green), blue), cv2.min(cv2.min(red, green), blue)
    return (cv2.sumElems(most)[0] + cv2.sumElems(least)[0]) / 2 / most.size
