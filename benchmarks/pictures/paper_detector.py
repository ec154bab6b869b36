"""The paper's corner detector as it stands (Aliyev et al. 2014, sections 4.1 and 4.3), to judge pictures with.

The course's detector is what students write in lessons 01 to 03. This one does all 27 settings of a picture quickly.
"""

from __future__ import annotations

from itertools import combinations

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray

Pixels = npt.NDArray[np.uint8]
OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3
HUES = {GREEN: (45.0, 80.0), YELLOW: (22.0, 33.0)}  # in OpenCV's half degrees
FLOOR = 0.16 * 255  # least saturation of green and yellow
RUN = 7  # green pixels, contiguous from the top, where the carpet begins
REACH, PARALLEL, DOUBLES = 5.0, 0.17, 10.0  # px beyond a segment's end; rad; px


def white_threshold(lightness: npt.NDArray[np.uint8], beta: float = 120.0) -> float:
    """Compute the threshold of equation 4.1, with the mean of all pixels (the paper samples them)."""
    return beta + (255.0 - beta) * float(lightness.mean()) / 255.0


def color_labels(hls: Pixels, threshold: float) -> Pixels:
    """Label a picture in OpenCV's hue, lightness, saturation: white wins over yellow over green."""
    hue, lightness, saturation = (hls[..., i] for i in range(3))
    labels = np.zeros(hue.shape, np.uint8)
    for label, (low, high) in HUES.items():
        labels[(saturation >= FLOOR) & (hue >= low) & (hue <= high)] = label
    labels[lightness > threshold] = WHITE
    return labels


def erase_background(labels: Pixels) -> Pixels:
    """Erase in every column all pixels above the first RUN contiguous green pixels from the top."""
    green = labels == GREEN
    before = np.vstack([np.zeros((1, green.shape[1]), int), np.cumsum(green, axis=0)])
    full = np.zeros_like(green)  # full[r]: rows r .. r + RUN - 1 are green
    full[: len(green) - RUN + 1] = before[RUN:] - before[:-RUN] == RUN
    first = np.where(full.any(axis=0), full.argmax(axis=0), len(green))
    kept = labels.copy()
    kept[np.arange(len(green))[:, None] < first] = OTHER
    return kept


def edges(labels: Pixels) -> Pixels:
    """Return Canny's edges of the white pixels that remain after the background is erased."""
    white = np.where(erase_background(labels) == WHITE, 255, 0).astype(np.uint8)
    return np.asarray(cv2.Canny(white, 50, 150), dtype=np.uint8)


def corners_of_edges(edge: Pixels, max_line_gap: float = 5, min_line_length: float = 40) -> FloatArray:
    """Return the corners (K, 2) inside the picture where Hough's segments meet, without doubles."""
    found = cv2.HoughLinesP(
        edge, 1, np.pi / 180, threshold=20, minLineLength=min_line_length, maxLineGap=max_line_gap
    )
    points = _intersections(np.reshape([] if found is None else found, (-1, 4)).astype(float))
    kept: list[FloatArray] = []
    for point in points[((points >= 0) & (points < edge.shape[::-1])).all(axis=1)]:
        if all(np.hypot(*(point - other)) > DOUBLES for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 2)


def _intersections(segments: FloatArray) -> FloatArray:
    """Return the crossings (K, 2) of pairs of segments, extended by REACH, that are not PARALLEL."""
    if len(segments) < 2:
        return np.empty((0, 2))
    start, way = segments[:, :2], segments[:, 2:] - segments[:, :2]
    length = np.maximum(np.hypot(*way.T), 1e-9)
    ahead = way / length[:, None]
    i, j = np.array(list(combinations(range(len(segments)), 2))).T
    cross = ahead[i, 0] * ahead[j, 1] - ahead[i, 1] * ahead[j, 0]
    between = start[j] - start[i]
    safe = np.where(np.abs(cross) > np.sin(PARALLEL), cross, np.nan)
    along_i = (between[:, 0] * ahead[j, 1] - between[:, 1] * ahead[j, 0]) / safe
    along_j = (between[:, 0] * ahead[i, 1] - between[:, 1] * ahead[i, 0]) / safe
    near = (along_i >= -REACH) & (along_i <= length[i] + REACH)
    near &= (along_j >= -REACH) & (along_j <= length[j] + REACH)
    return start[i][near] + along_i[near, None] * ahead[i][near]


def find_corners(picture: Pixels) -> FloatArray:
    """Return the corners (K, 2) of a picture with the best setting of Table A.1."""
    hls = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2HLS), dtype=np.uint8)
    return corners_of_edges(edges(color_labels(hls, white_threshold(hls[..., 1]))))
