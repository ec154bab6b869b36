"""A picture of the signs of a matrix's entries, in which the newest rows and columns are framed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb

from nao_course.plotting.style import FOUND

CELL = 20  # px
POSITIVE, NEGATIVE = "#2c6e8f", "#e39a2d"


def paint_matrix(matrix: npt.ArrayLike, border: int, newest: Sequence[int] = ()) -> npt.NDArray[np.uint8]:
    """Paint which entries of a matrix (N, N) are positive, negative and zero, one cell each: RGB (20 N, 20 N, 3).

    A line separates the first `border` rows, of the poses, from the landmarks; the cells of the rows and columns in
    `newest`, the newest constraint or edge, are framed.
    """
    colours = np.array([_rgb(NEGATIVE), (255, 255, 255), _rgb(POSITIVE)], dtype=np.uint8)
    signs = np.nan_to_num(np.sign(matrix)).astype(int) + 1
    painted = colours[signs].repeat(CELL, axis=0).repeat(CELL, axis=1)
    painted[::CELL], painted[:, ::CELL] = 225, 225
    if border < len(signs):
        painted[border * CELL], painted[:, border * CELL] = 110, 110
    for row in newest:
        for column in newest:
            cell = painted[row * CELL : (row + 1) * CELL, column * CELL : (column + 1) * CELL]
            inside = cell[3:-2, 3:-2].copy()
            cell[1:, 1:] = _rgb(FOUND)
            cell[3:-2, 3:-2] = inside
    return painted


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in to_rgb(colour))
    return red, green, blue
