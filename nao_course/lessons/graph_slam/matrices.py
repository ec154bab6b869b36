"""Figures of matrices in lesson 08: signs of the entries, fill-in by elimination, and correlations."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.drives import LinearDrive
from nao_course.lessons.graph_slam.systems import Builders, assemble, inverse_of
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.matrix_signs import NEGATIVE, POSITIVE
from nao_course.plotting.style import GREY, STYLES

FILLED = "#b3261e"
_SIGNS = ListedColormap([NEGATIVE, "#ffffff", POSITIVE])
ROUNDING = 1e-13  # of the largest entry: smaller entries may be rounding errors
Bools = npt.NDArray[np.bool_]


def plot_matrix(omega: npt.ArrayLike, ax: Axes, poses: int | None = None) -> None:
    """Show which entries of a matrix (N, N) are positive, negative and zero; a line separates poses from landmarks."""
    array = np.asarray(omega, dtype=float)
    ax.imshow(np.sign(array), cmap=_SIGNS, vmin=-1, vmax=1, interpolation="nearest")
    _frame(ax, len(array), poses)


def _frame(ax: Axes, size: int, poses: int | None) -> None:
    ax.set(xticks=[], yticks=[])
    for spine in ax.spines.values():
        spine.set(visible=True, color=GREY)
    if poses is not None and 0 < poses < size:
        ax.axhline(poses - 0.5, color=GREY, lw=0.8)
        ax.axvline(poses - 0.5, color=GREY, lw=0.8)
        middles = [(poses - 1) / 2, (poses + size - 1) / 2]
        ax.set_yticks(middles, ["poses", "landmarks"], rotation=90, va="center", fontsize=9)
        ax.set_xticks(middles, ["poses", "landmarks"], fontsize=9)
        ax.tick_params(length=0)


def sign_keys() -> list[Patch]:
    """Return the legend keys of positive and negative entries."""
    return [
        Patch(facecolor=POSITIVE, label="positive"),
        Patch(facecolor=NEGATIVE, label="negative"),
        Patch(facecolor="white", edgecolor=GREY, label="zero"),
    ]


# --- elimination ---


def fill_in(pattern: npt.ArrayLike, order: Sequence[int]) -> Bools:
    """Return the pattern of the factor, a lower triangle (N, N), after eliminating variables in the given order.

    The neighbours of an eliminated variable are connected with each other afterwards. `pattern` (N, N) shows which
    entries of a symmetric matrix are not zero.
    """
    left = np.asarray(pattern, dtype=bool)[np.ix_(order, order)].copy()
    for step in range(len(left)):
        neighbours = step + 1 + np.flatnonzero(left[step + 1 :, step])
        left[np.ix_(neighbours, neighbours)] = True
    np.fill_diagonal(left, True)
    return np.tril(left)


def fewest_neighbours_first(pattern: npt.ArrayLike) -> list[int]:
    """Order variables by minimum degree: the variable with the fewest remaining neighbours is next."""
    left = np.asarray(pattern, dtype=bool).copy()
    np.fill_diagonal(left, False)
    waiting, order = list(range(len(left))), list[int]()
    while waiting:
        chosen = min(waiting, key=lambda variable: int(left[variable].sum()))
        neighbours = np.flatnonzero(left[chosen])
        left[np.ix_(neighbours, neighbours)] = True
        left[neighbours, neighbours] = False
        left[chosen] = left[:, chosen] = False
        waiting.remove(chosen)
        order.append(chosen)
    return order


@course_style()
def draw_fill_in(omega: npt.ArrayLike, poses: int) -> Drawing:
    """Draw a matrix and its factor in two orders: as the variables are numbered, and fewest neighbours first.

    Parameters
    ----------
    omega : array_like, shape (N, N)
        An information matrix.
    poses : int
        How many of its variables are poses; they come first.

    Returns
    -------
    Drawing
        Three pictures with their counts.
    """
    pattern = np.asarray(omega) != 0
    lower = np.tril(pattern)
    counts = {"below and on the diagonal of Omega": int(lower.sum())}
    figure = Figure(figsize=(10.2, 4.2))
    axes = figure.subplots(1, 3)
    axes[0].imshow(pattern, cmap=ListedColormap(["#ffffff", POSITIVE]), interpolation="nearest")
    axes[0].set_title(rf"$\Omega$: {lower.sum()} entries in a half", fontsize=11)
    _frame(axes[0], len(pattern), poses)
    orders = {
        "as numbered": list(range(len(pattern))),
        "fewest neighbours first": fewest_neighbours_first(pattern),
    }
    for ax, (name, order) in zip(axes[1:], orders.items(), strict=True):
        factor = fill_in(pattern, order)
        before = lower | lower.T
        shown = np.where(factor, np.where(before[np.ix_(order, order)], 1, 2), 0)
        colours = ListedColormap(["#ffffff", POSITIVE, FILLED])
        ax.imshow(shown, cmap=colours, vmin=0, vmax=2, interpolation="nearest")
        _frame(ax, len(pattern), None)
        counts[name] = int(factor.sum())
        ax.set_title(f"{name}: {counts[name]}", fontsize=11)
    keys = [
        Patch(facecolor=POSITIVE, label="entries of $\\Omega$"),
        Patch(facecolor=FILLED, label="added by elimination"),
    ]
    legend_below(figure, keys)
    said = "; ".join(f"{name}: {count}" for name, count in counts.items())
    return Drawing(
        figure, f"An information matrix of {len(pattern)} variables and its factor. Entries {said}."
    )


_PARTLY = "A pose links the landmarks that were measured from it, and the motions link the poses."
FILLED_REMARKS = {  # by typical predictions of the percentage of the landmarks' block
    10.0: "These are the entries before. Removing a pose links all landmarks that were measured from it.",
    **dict.fromkeys((20.0, 25.0, 30.0, 40.0, 50.0, 60.0, 75.0), _PARTLY),
}


@course_style()
def draw_marginalised(omega: npt.ArrayLike, poses: int, kept: npt.ArrayLike) -> Drawing:
    """Draw an information matrix of poses and landmarks, and the matrix of the landmarks alone.

    Parameters
    ----------
    omega : array_like, shape (N, N)
        Of all variables, poses first.
    poses : int
        How many poses there are.
    kept : array_like, shape (N - poses, N - poses)
        The matrix after the poses were removed.

    Returns
    -------
    Drawing
        Three matrices: of all variables, its block of the landmarks, and `kept`.
    """
    array, left = np.asarray(omega, dtype=float), np.asarray(kept, dtype=float)
    block = array[poses:, poses:]
    if left.shape != block.shape:
        raise ValueError(f"the matrix without the poses has shape {left.shape}; expected {block.shape}")
    left = np.where(np.abs(left) > ROUNDING * np.abs(left).max(initial=1e-300), left, 0.0)
    shown = {r"$\Omega$": array, "the landmarks' block": block, "poses removed": left}
    figure = Figure(figsize=(10.2, 4.1))
    for ax, (name, matrix) in zip(figure.subplots(1, 3), shown.items(), strict=True):
        plot_matrix(matrix, ax, poses if len(matrix) == len(array) else None)
        ax.set_title(f"{name}: {100 * share(matrix):.0f} % not zero", fontsize=11)
    legend_below(figure, sign_keys())
    words = f"{100 * share(array):.0f} % of Omega, {100 * share(block):.0f} % of its block of landmarks"
    return Drawing(
        figure, f"Entries that are not zero: {words}, {100 * share(left):.0f} % once poses are removed."
    )


def share(matrix: npt.ArrayLike) -> float:
    """Return which part of a matrix's entries is not zero."""
    array = np.asarray(matrix)
    return float(np.count_nonzero(array) / max(array.size, 1))


# --- information and covariance ---


def held_tightly(omega: npt.ArrayLike, weight: float = 1e6) -> FloatArray:
    """Return a copy of an information matrix whose first variable is held with a variance of 1 / weight, m^2."""
    held = np.array(omega, dtype=float)
    held[0, 0] += weight - 1.0  # a start has the weight 1 already
    return held


def correlations(omega: npt.ArrayLike) -> FloatArray:
    """Return the correlation matrix by an information matrix whose start is held tightly."""
    covariance = inverse_of(held_tightly(omega))
    sigma = np.sqrt(np.diag(covariance))
    return np.asarray(covariance / np.outer(sigma, sigma), dtype=float)


@course_style()
def draw_correlations(drive: LinearDrive, builders: Builders) -> Drawing:
    """Draw an information matrix, the correlations of its inverse, and how both fill with the drive.

    Parameters
    ----------
    drive : LinearDrive
        Drive whose constraints are added one after the other.
    builders : Builders
        The student's functions.

    Returns
    -------
    Drawing
        Two matrices and two curves.
    """
    poses = len(drive.path)
    ends = [number for number, each in enumerate(drive.constraints) if each.kind == "motion"][1:]
    growth = [_growth(drive, builders, end) for end in [*ends, len(drive.constraints)]]
    stops, of_omega, correlated = np.array(growth).T
    omega, _ = assemble(drive.constraints, drive.size, builders, 0)
    figure = Figure(figsize=(10.6, 4.0))
    left, middle, right = figure.subplots(1, 3)
    plot_matrix(omega, left, poses)
    left.set_title(rf"$\Omega$: {100 * share(omega):.0f} % not zero", fontsize=11)
    image = middle.imshow(correlations(omega), cmap="RdBu", vmin=-1, vmax=1, interpolation="nearest")
    _frame(middle, len(omega), poses)
    middle.set_title(r"correlations in $\Omega^{-1}$", fontsize=11)
    figure.colorbar(image, ax=middle, shrink=0.75, ticks=[-1, 0, 1])
    style, other = STYLES["graph"], STYLES["ekf"]
    right.plot(
        stops,
        of_omega,
        color=style.colour,
        marker=style.marker,
        ms=5,
        label=r"part of $\Omega$ that is not zero",
    )
    right.plot(
        stops,
        correlated,
        color=other.colour,
        marker=other.marker,
        ms=5,
        label="mean correlation of landmarks",
    )
    right.set(xlabel="stops", ylim=(0, 1), xticks=stops[::3])
    right.legend(loc="lower left", fontsize=9)
    right.grid(color="#e3e5e8")
    return Drawing(
        figure,
        f"Information and covariance. After {stops[-1]:.0f} stops {100 * of_omega[-1]:.0f} % of Omega's entries are "
        f"not zero; the mean correlation of two landmarks is {correlated[-1]:.2f}.",
    )


def _growth(drive: LinearDrive, builders: Builders, end: int) -> tuple[float, float, float]:
    """Return the stops, the nonzero part of Omega, and the landmarks' mean correlation after some constraints."""
    used = drive.constraints[:end]
    known = sorted({variable for each in used for variable in (each.first, each.second)})
    omega = assemble(used, drive.size, builders, 0)[0][np.ix_(known, known)]
    stops = sum(variable < len(drive.path) for variable in known)
    between = correlations(omega)[stops:, stops:]
    pairs = between[~np.eye(len(between), dtype=bool)]
    return float(stops), share(omega), float(pairs.mean()) if pairs.size else float("nan")
