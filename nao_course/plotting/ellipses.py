"""Covariance ellipses, which contain a given probability of a Gaussian distribution in the plane."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb

from nao_course.geometry import FloatArray, as_points
from nao_course.plotting.style import style_of
from nao_course.slam import Estimate


def ellipse_outlines(
    centres: npt.ArrayLike, covariances: npt.ArrayLike, probability: float = 0.95, corners: int = 49
) -> FloatArray:
    """Return the outlines of covariance ellipses in the plane.

    Each outline is a circle transformed by the covariance's square root, which has a closed form for 2 x 2 matrices.

    Parameters
    ----------
    centres : array_like, shape (N, 2)
        Means in metres.
    covariances : array_like, shape (N, 2, 2)
        Covariances in m^2.
    probability : float
        Probability inside each ellipse, between 0 and 1.
    corners : int
        Number of points of each outline; the last point equals the first.

    Returns
    -------
    ndarray, shape (N, corners, 2)
        Outlines in metres; NaN for an invalid covariance: not finite, not symmetric, or with a negative variance.

    Raises
    ------
    ValueError
        If the shapes do not fit, or `probability` is not between 0 and 1.
    """
    if not 0 < probability < 1:
        raise ValueError(f"probability must be between 0 and 1, such as 0.95; got {probability}")
    means = as_points(centres, name="centres")
    matrices = np.asarray(covariances, dtype=float).reshape(-1, 2, 2)
    if len(matrices) != len(means):
        raise ValueError(f"{len(means)} centres need covariances of shape ({len(means)}, 2, 2)")
    with np.errstate(all="ignore"):
        trace = matrices[:, 0, 0] + matrices[:, 1, 1]
        tolerance = 1e-9 * np.maximum(trace, 1e-300) ** 2
        determinant = matrices[:, 0, 0] * matrices[:, 1, 1] - matrices[:, 0, 1] * matrices[:, 1, 0]
        sound = np.isfinite(matrices).all(axis=(1, 2)) & (np.diagonal(matrices, axis1=1, axis2=2) >= 0).all(
            axis=1
        )
        sound &= (determinant >= -tolerance) & (
            np.abs(matrices[:, 0, 1] - matrices[:, 1, 0]) ** 2 <= tolerance
        )
        s = np.sqrt(np.maximum(determinant, 0))
        roots = (matrices + s[:, None, None] * np.eye(2)) / np.sqrt(np.maximum(trace + 2 * s, 1e-300))[
            :, None, None
        ]
    angle = np.linspace(0, 2 * np.pi, corners)
    # Square root of the chi-square quantile for two degrees of freedom
    radius = np.sqrt(-2 * np.log1p(-probability))
    circle = radius * np.array([np.cos(angle), np.sin(angle)])
    outlines = means[:, None] + np.swapaxes(roots @ circle, 1, 2)
    outlines[~sound] = np.nan
    return np.asarray(outlines)


def estimate_outlines(estimate: Estimate, probability: float = 0.95) -> FloatArray:
    """Return the ellipses (1 + N, corners, 2) of an estimate's robot and landmarks, m; NaN for invalid covariances."""
    centres = np.vstack([estimate.pose.as_array()[None, :2], estimate.landmarks])
    covariances = np.concatenate([estimate.covariance[None, :2, :2], estimate.landmark_covariances])
    return ellipse_outlines(centres, covariances, probability)


def plot_ellipse(
    centre: npt.ArrayLike, covariance: npt.ArrayLike, ax: Axes, source: str = "ekf", probability: float = 0.95
) -> None:
    """Draw the covariance ellipse of a Gaussian distribution.

    Parameters
    ----------
    centre : array_like, shape (2,)
        Mean in metres.
    covariance : array_like, shape (2, 2)
        Covariance in m^2; nothing is drawn if it contains NaN.
    ax : matplotlib Axes
        Axes in metres.
    source : str
        A key of `STYLES`.
    probability : float
        Probability inside the ellipse.

    Raises
    ------
    ValueError
        If the matrix is finite but not a covariance.
    """
    matrix = np.asarray(covariance, dtype=float)
    if matrix.shape != (2, 2):
        raise ValueError(f"covariance must have shape (2, 2), in m^2; got {matrix.shape}")
    outline = ellipse_outlines(centre, matrix[None], probability)
    if np.isfinite(matrix).all() and np.isnan(outline).any():
        raise ValueError(f"covariance must be symmetric and positive semidefinite; got {matrix.tolist()}")
    ax.add_collection(filled_outlines(outline, style_of(source).colour))


def filled_outlines(outlines: FloatArray, colour: str, order: float = 3.5) -> PolyCollection:
    """Return outlines (N, corners, 2) as translucent filled shapes; outlines with NaN are omitted."""
    sound = outlines[np.isfinite(outlines).all(axis=(1, 2))] if len(outlines) else outlines
    rgb = to_rgb(colour)
    return PolyCollection(
        list(sound), facecolors=[(*rgb, 0.16)], edgecolors=[(*rgb, 0.9)], linewidths=1.2, zorder=order
    )
