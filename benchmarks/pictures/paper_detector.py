"""The seed paper's corner detector, written only to judge the simulator with: a throw-away test version.

The course's detector is what students write in lessons 01 to 03, and its reference is their solution
notebook. This one exists so that a change to the renderer can be judged in a minute: do the 27 settings of
Table A.1 (Aliyev et al. 2014) cost the same on simulated pictures as on real ones?
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, product

import cv2
import numpy as np
import numpy.typing as npt
from scipy.stats import spearmanr

from nao_course.lessons.experiments.paper_table import BEST, BETAS, GAPS, LENGTHS, PAPER_MEANS, SETTINGS

FloatArray = npt.NDArray[np.float64]
Pixels = npt.NDArray[np.uint8]
Labels = npt.NDArray[np.uint8]

OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3
MAX_LIGHTNESS = 255.0

PAPER_COSTS = tuple(PAPER_MEANS.values())

HIT, FALSE, MISSED = -1.333, 5.0, 1.0  # the paper's Table 6.1
TOLERANCE = 8.0  # px at 320 wide


@dataclass(frozen=True)
class Hues:
    """Calibrated ranges of hue in OpenCV's half degrees (0..180), and the floor under saturation (0..255)."""

    green: tuple[float, float] = (45.0, 80.0)
    yellow: tuple[float, float] = (22.0, 33.0)
    min_saturation: float = 0.16 * 255


@dataclass(frozen=True)
class Scene:
    """A picture and the corners (K, 2) that are to be found in it."""

    pixels: Pixels
    corners: FloatArray


# --- 4.1 colours ---


def white_threshold(lightness: npt.NDArray[np.uint8], beta: float = 120.0) -> float:
    """Compute the threshold of Aliyev et al. 2014, eq. 4.1, with the mean of all pixels (the paper samples them)."""
    return beta + (MAX_LIGHTNESS - beta) * float(lightness.mean()) / MAX_LIGHTNESS


def color_labels(hls: Pixels, threshold: float, hues: Hues) -> Labels:
    """Label a picture in OpenCV's hue, lightness, saturation: white wins over yellow over green."""
    hue, lightness, saturation = (hls[..., i] for i in range(3))
    coloured = saturation >= hues.min_saturation
    labels = np.zeros(hue.shape, np.uint8)
    for label, (low, high) in ((GREEN, hues.green), (YELLOW, hues.yellow)):
        labels[coloured & (hue >= low) & (hue <= high)] = label
    labels[lightness > threshold] = WHITE
    return labels


# --- 4.3 lines and corners ---


def erase_background(labels: Labels, run: int = 7) -> Labels:
    """Erase in every column all pixels above the first `run` contiguous green pixels from the top."""
    green = labels == GREEN
    counts = np.cumsum(green, axis=0)
    full = np.zeros_like(green)  # full[r]: rows r .. r + run - 1 are green
    before = np.vstack([np.zeros((1, green.shape[1]), counts.dtype), counts])
    full[: len(green) - run + 1] = before[run:] - before[:-run] == run
    first = np.where(full.any(axis=0), full.argmax(axis=0), len(green))
    kept = labels.copy()
    kept[np.arange(len(green))[:, None] < first] = OTHER
    return kept


def hough_segments(lines: Pixels, max_line_gap: float, min_line_length: float) -> FloatArray:
    """Return the segments (N, 4) of a picture of edges, in the same shape for OpenCV 4 and 5."""
    found = cv2.HoughLinesP(
        lines, 1, np.pi / 180, threshold=20, minLineLength=min_line_length, maxLineGap=max_line_gap
    )
    return np.empty((0, 4)) if found is None else np.asarray(found, dtype=float).reshape(-1, 4)


def intersections(segments: FloatArray, reach: float = 5.0, parallel: float = 0.17) -> FloatArray:
    """Return the crossings (K, 2) of pairs of segments, extended by `reach` px, at more than `parallel` rad."""
    if len(segments) < 2:
        return np.empty((0, 2))
    start, way = segments[:, :2], segments[:, 2:] - segments[:, :2]
    length = np.maximum(np.hypot(*way.T), 1e-9)
    ahead = way / length[:, None]
    i, j = np.array(list(combinations(range(len(segments)), 2))).T
    cross = ahead[i, 0] * ahead[j, 1] - ahead[i, 1] * ahead[j, 0]
    between = start[j] - start[i]
    safe = np.where(np.abs(cross) > np.sin(parallel), cross, np.nan)
    along_i = (between[:, 0] * ahead[j, 1] - between[:, 1] * ahead[j, 0]) / safe
    along_j = (between[:, 0] * ahead[i, 1] - between[:, 1] * ahead[i, 0]) / safe
    near = (along_i >= -reach) & (along_i <= length[i] + reach)
    near &= (along_j >= -reach) & (along_j <= length[j] + reach)
    return start[i][near] + along_i[near, None] * ahead[i][near]


def remove_doubles(points: FloatArray, radius: float = 10.0) -> FloatArray:
    """Keep one point of all that are within `radius` of it, as the paper does."""
    kept: list[FloatArray] = []
    for point in points:
        if all(np.hypot(*(point - other)) > radius for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 2)


def find_corners(labels: Labels, max_line_gap: float = 5, min_line_length: float = 40) -> FloatArray:
    """Return the corners (K, 2) of a labelled picture."""
    return corners_of_edges(edges(labels), labels.shape, max_line_gap, min_line_length)


def edges(labels: Labels) -> Pixels:
    """Return Canny's edges of the white pixels that remain after the background is erased."""
    white = np.where(erase_background(labels) == WHITE, 255, 0).astype(np.uint8)
    return np.asarray(cv2.Canny(white, 50, 150), dtype=np.uint8)


def corners_of_edges(
    edge: Pixels, shape: tuple[int, ...], max_line_gap: float, min_line_length: float
) -> FloatArray:
    """Return the corners (K, 2) of Canny's edges that are inside the picture."""
    points = intersections(hough_segments(edge, max_line_gap, min_line_length))
    inside = ((points >= 0) & (points < (shape[1], shape[0]))).all(axis=1)
    return remove_doubles(points[inside])


# --- scoring ---


def match(found: FloatArray, truth: FloatArray, tolerance: float = TOLERANCE) -> int:
    """Return the number of hits of a one-to-one match, the nearest pairs first."""
    if not len(found) or not len(truth):
        return 0
    apart = np.hypot(*(found[:, None] - truth[None]).transpose(2, 0, 1))
    hits = 0
    while apart.size and apart.min() <= tolerance:
        i, j = np.unravel_index(apart.argmin(), apart.shape)
        apart = np.delete(np.delete(apart, i, axis=0), j, axis=1)
        hits += 1
    return hits


@dataclass(frozen=True)
class Grid:
    """Counts of a set of scenes under every setting: (settings, scenes) each, and corners (scenes,)."""

    found: npt.NDArray[np.int64]
    hits: npt.NDArray[np.int64]
    corners: npt.NDArray[np.int64]

    @property
    def costs(self) -> FloatArray:
        """Cost of every scene under every setting."""
        return HIT * self.hits + FALSE * (self.found - self.hits) + MISSED * (self.corners - self.hits)

    @property
    def mean_costs(self) -> FloatArray:
        """Mean cost under every setting."""
        return np.asarray(self.costs.mean(axis=1))

    def at(self, setting: tuple[int, int, int] = BEST) -> dict[str, float]:
        """Return found, false, missed and mean cost under one setting."""
        row = SETTINGS.index(setting)
        hits, false = int(self.hits[row].sum()), int((self.found[row] - self.hits[row]).sum())
        return {
            "corners": int(self.corners.sum()),
            "hits": hits,
            "false": false,
            "cost": self.mean_costs[row],
        }


def run_grid(scenes: Sequence[Scene], hues: Hues) -> Grid:
    """Run the 27 settings of Table A.1 on every scene."""
    found, hits = (np.zeros((len(SETTINGS), len(scenes)), dtype=np.int64) for _ in range(2))
    for s, scene in enumerate(scenes):
        hls = np.asarray(cv2.cvtColor(scene.pixels, cv2.COLOR_RGB2HLS))
        for beta in BETAS:
            edge = edges(color_labels(hls, white_threshold(hls[..., 1], beta), hues))
            for gap, length in product(GAPS, LENGTHS):
                row = SETTINGS.index((beta, gap, length))
                points = corners_of_edges(edge, edge.shape, gap, length)
                found[row, s] = len(points)
                hits[row, s] = match(points, scene.corners)
    return Grid(found, hits, np.array([len(scene.corners) for scene in scenes]))


FUNNEL = ("in the white mask", "after the background is erased", "near a segment", "near two not parallel")


def funnel(scenes: Sequence[Scene], hues: Hues, radius: float = 6.0) -> dict[str, float]:
    """Return where true corners are lost, as shares of all (lesson 03), at the paper's best setting."""
    counts = np.zeros(len(FUNNEL) + 1)
    for scene in scenes:
        hls = np.asarray(cv2.cvtColor(scene.pixels, cv2.COLOR_RGB2HLS))
        labels = color_labels(hls, white_threshold(hls[..., 1], BEST[0]), hues)
        kept = erase_background(labels)
        segments = hough_segments(edges(labels), BEST[1], BEST[2])
        for corner in scene.corners:
            masks = [_any_near(each == WHITE, corner, 3.0) for each in (labels, kept)]
            near = segments[_distance_to_segments(corner, segments) <= radius]
            angles = np.arctan2(near[:, 3] - near[:, 1], near[:, 2] - near[:, 0])
            apart = np.abs(np.sin(angles[:, None] - angles[None]))
            counts += [*masks, len(near) > 0, bool((apart > np.sin(0.17)).any()), 1]
    return dict(zip(FUNNEL, (counts[:-1] / max(counts[-1], 1)).tolist(), strict=True))


def _any_near(mask: npt.NDArray[np.bool_], point: FloatArray, radius: float) -> bool:
    """Return whether any pixel of the mask is within `radius` of a point."""
    v, u = np.nonzero(mask)
    return bool((np.hypot(u - point[0], v - point[1]) <= radius).any())


def _distance_to_segments(point: FloatArray, segments: FloatArray) -> FloatArray:
    """Return the distance (N,) of a point from each segment."""
    start, way = segments[:, :2], segments[:, 2:] - segments[:, :2]
    along = ((point - start) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-9)
    return np.asarray(np.hypot(*(start + np.clip(along, 0, 1)[:, None] * way - point).T))


def rank_correlation(first: FloatArray, second: FloatArray) -> float:
    """Return Spearman's rank correlation."""
    return float(spearmanr(first, second).statistic)


def reliability(grid: Grid, repeats: int = 200) -> float:
    """Return the median rank correlation of the 27 costs between random halves of the scenes.

    Two sets of half as many real scenes agree no better than this, so nothing simulated can be asked to.
    """
    rng = np.random.default_rng(0)
    found = []
    for _ in range(repeats):
        order = rng.permutation(grid.costs.shape[1])
        halves = (grid.costs[:, half].mean(axis=1) for half in np.array_split(order, 2))
        found.append(rank_correlation(*halves))
    return float(np.nanmedian(found))
