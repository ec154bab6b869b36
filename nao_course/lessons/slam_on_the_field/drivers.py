"""How `measure` is called: on pictures of the field that are taken where it runs, for they are too large to be sent."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course.exercises import register_driver
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, Field, Picture, Reality, render

HEAD_PITCH = float(np.radians(-31.0 + 6.4))  # where a real NAO's head really was (docs/real_data.md)


def taken_from(pose: Pose, yaw: float, brightness: float = 1.0, seed: int = 0) -> Picture:
    """Take a picture of a clean half field with a body that stands upright.

    Parameters
    ----------
    pose : Pose
        The robot's, on the field.
    yaw : float
        Of its head, rad.
    brightness : float
        What all pixels are multiplied by.
    seed : int
        Of the room and the sensor's noise.

    Returns
    -------
    Picture
        320 x 240, of the bottom camera.
    """
    view = NAO_V4.view("bottom", yaw, HEAD_PITCH, (320, 240))
    pixels, _ = render(Field(2012), pose, view, Reality.clean(seed), np.random.default_rng(seed))
    return Picture(np.clip(pixels * brightness, 0, 255).astype(np.uint8), view, "bottom")


@register_driver
def on_taken_picture(function: Callable[..., Any], *place: Any) -> Any:
    """Call ``function(picture, view)`` on the picture that `taken_from` takes.

    Parameters
    ----------
    function : callable
        The student's; of a uint8 array (H, W, 3) and a CameraView.
    *place : object
        What `taken_from` is called with.

    Returns
    -------
    object
        What it returned.
    """
    picture = taken_from(*place)
    return function(picture.pixels, picture.view)
