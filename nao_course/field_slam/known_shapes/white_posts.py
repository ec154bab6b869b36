"""White goal posts in a labelled picture, distinguished by their shape from lines and from white things in the room."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.sim import CameraView, FieldDimensions

Labels = npt.NDArray[np.uint8]

OTHER, GREEN, GOAL, WHITE = 0, 1, 2, 3  # labels of lesson 01; GOAL is its yellow
STEP = 2.0  # px at 320: largest difference between the lower ends of neighbouring columns of one post
BESIDE = 4  # px at 320, and the width of a post: how far beside a post carpet is looked for
# How much narrower and wider than expected a post may appear: factors, and px at 320. At the side of a picture posts
# slant, so that fewer columns are white from the horizon to the foot.
WIDTHS, SLACK = (0.4, 1.6), 1.5


def as_goal_colour(labels: Labels, view: CameraView, dimensions: FieldDimensions) -> Labels:
    """Give the white posts of a picture the label of the goal's colour, and take it from everything else.

    Lines are below the horizon. White walls and furniture reach above it, as posts do, but they are beyond the carpet,
    so that no carpet is visible behind their lower ends. The width of a post also fits the row of its foot, because
    both are inversely proportional to the distance. The labels (H, W) are as in lesson 01: 0 other, 1 green, 2
    yellow, 3 white; in the result, 2 is a white post. Of the dimensions, the diameter of the posts and the border
    behind them are used.
    """
    scale = view.size[0] / 320
    horizon = view.centre[1] - view.focal[1] * np.tan(view.pitch)
    found = np.where(labels == GOAL, OTHER, labels).astype(np.uint8)
    row = round(float(horizon))
    if not 0 <= row < len(labels) - 1:
        return found
    white = (
        cv2.morphologyEx((labels == WHITE).astype(np.uint8), cv2.MORPH_CLOSE, np.ones((3, 1), np.uint8)) > 0
    )
    lower, upper = _run_length(white[row:]), _run_length(white[row::-1])
    end = row + lower - 1  # last row of the run through the horizon
    # Width of a post for each row that its foot is below the horizon.
    share = dimensions.post_diameter / view.height * view.focal[0] / view.focal[1]
    borders = np.flatnonzero((np.abs(np.diff(end)) > STEP * scale) | (np.diff(lower > 0))) + 1
    for columns in np.split(np.arange(white.shape[1]), borders):
        below = float(np.median(end[columns])) - horizon
        if not lower[columns[0]] or below <= 0:
            continue
        narrowest, widest = (factor * share * below for factor in WIDTHS)
        distance = view.focal[1] * view.height / below
        # Rows of the carpet behind the post
        behind = below * dimensions.border / (distance + dimensions.border)
        fits = narrowest - SLACK * scale <= len(columns) <= widest + SLACK * scale
        beside = round(BESIDE * scale + share * below)
        if fits and _has_carpet_behind(labels, columns, end, (beside, round(behind))):
            for column in columns:
                found[row + 1 - upper[column] : end[column] + 1, column] = GOAL
    return found


def _has_carpet_behind(
    labels: Labels, columns: npt.NDArray[np.intp], end: npt.NDArray[np.intp], area: tuple[int, int]
) -> bool:
    """Return whether there is carpet on both sides of a post in an area (wide, high) px above its lower end.

    A side that is out of view does not count.
    """
    wide, high = area
    for column, left in ((columns[0], columns[0] - wide), (columns[-1], columns[-1] + 1)):
        side = labels[max(end[column] - high, 0) : end[column], max(left, 0) : max(left + wide, 0)]
        if side.size and not (side == GREEN).any():
            return False
    return True


def _run_length(white: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Return for each column of (H, W) how many pixels from the first row on are white."""
    return np.where(white.all(axis=0), len(white), (~white).argmax(axis=0))
