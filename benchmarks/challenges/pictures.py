"""What a detector takes for a picture: RGB of bytes, of any size, also without a pixel."""

from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np
import numpy.typing as npt

Pixels = npt.NDArray[np.uint8]


def check_picture(picture: npt.ArrayLike) -> Pixels:
    """Return a picture unchanged; raise a ValueError if it is not RGB (H, W, 3) of uint8."""
    pixels = np.asarray(picture)
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3:
        raise ValueError(f"the picture must be RGB, uint8 (H, W, 3), got {pixels.dtype} {pixels.shape}")
    return pixels


def finds_points(find: Callable[[Pixels], Any]) -> Callable[[npt.ArrayLike], Any]:
    """Make a detector refuse what is no picture, by a ValueError, and find no point (0, 2) where there is no pixel."""

    @wraps(find)
    def checked(picture: npt.ArrayLike) -> Any:
        pixels = check_picture(picture)
        return find(pixels) if pixels.size else np.zeros((0, 2))

    return checked
