"""Driver and property for the checks of lesson 11; `measure` gets pictures that are rendered in its own process."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course.exercises import register, register_driver
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, Field, Picture, Reality, render

HEAD_PITCH = float(np.radians(-31.0 + 6.4))  # of a real NAO's head (docs/real_data.md)


def taken_from(pose: Pose, yaw: float, brightness: float = 1.0, seed: int = 0) -> Picture:
    """Render the 320 x 240 picture of a clean half field by an upright robot's bottom camera; `yaw` is in rad.

    `brightness` is a factor for all pixel values; `seed` is for the room and the sensor's noise.
    """
    view = NAO_V4.view("bottom", yaw, HEAD_PITCH, (320, 240))
    pixels, _ = render(Field(2012), pose, view, Reality.clean(seed), np.random.default_rng(seed))
    return Picture(np.clip(pixels * brightness, 0, 255).astype(np.uint8), view, "bottom")


@register
def associate_nothing(
    state: Any, covariance: Any, kinds: Any, measurements: Any, measurement_covariance: Any, gate: float
) -> Any:
    """Return -1 for every measurement, as an association that finds no landmark."""
    return np.full(len(measurements), -1)


@register_driver
def on_taken_picture(function: Callable[..., Any], *place: Any) -> Any:
    """Call the student's ``function(picture, view)`` on a uint8 picture (H, W, 3) from ``taken_from(*place)``."""
    picture = taken_from(*place)
    return function(picture.pixels, picture.view)


@register
def whole_numbers(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Reject floats as numbers of landmarks, because later cells use them as indices."""
    numbers = np.asarray(answer)
    if numbers.size and numbers.dtype.kind not in "iu":
        return "your numbers are right, but they are floats; indices must be integers, for example from np.full(m, -1)"
    return ""
