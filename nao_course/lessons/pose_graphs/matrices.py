"""The matrix H: which blocks it has, what its factor adds, and what moves freely in it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse
import scipy.sparse.linalg
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.graphs import Graph
from nao_course.lessons.pose_graphs.worlds import building, loop
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.style import GREY

Linearize = Callable[[Graph, FloatArray], tuple[Any, FloatArray]]


def factor_of(H: Any, ordering: str) -> Any:
    """The sparse factors of a symmetric matrix, its variables taken in an order: "NATURAL" or "MMD_AT_PLUS_A"."""
    return scipy.sparse.linalg.splu(
        H.tocsc(), permc_spec=ordering, diag_pivot_thresh=0.0, options={"SymmetricMode": True}
    )


def draw_patterns(linearize: Linearize, poses: int = 400) -> Drawing:
    """Draw H of a drive through a building, and its factor in two orders of elimination.

    Parameters
    ----------
    linearize : callable
        The student's.
    poses : int
        Of the drive.

    Returns
    -------
    Drawing
    """
    world = building(5, poses)
    H = scipy.sparse.csc_array(linearize(world.graph, world.truth)[0])[3:, 3:]
    natural, minimum = (factor_of(H, each) for each in ("NATURAL", "MMD_AT_PLUS_A"))
    lower = scipy.sparse.tril(H).tocsc()
    pictures = [
        ("H", H, lower.nnz),
        ("its factor, as driven", natural.L, natural.L.nnz),
        ("its factor, fewest neighbours first", minimum.L, minimum.L.nnz),
    ]
    with course_style():
        figure = Figure(figsize=(12.4, 4.4))
        for ax, (title, matrix, count) in zip(figure.subplots(1, 3), pictures, strict=True):
            _plot_pattern(matrix, ax)
            ax.set_title(f"{title}\n{count:,} entries in the lower half", fontsize=10.5)
    part = 100 * H.nnz / np.prod(H.shape)
    return Drawing(
        figure,
        f"H of {poses} poses, {part:.1f} % of it not zero, and its factor: {lower.nnz:,} entries in H's lower half, "
        f"{natural.L.nnz:,} in the factor as driven, {minimum.L.nnz:,} with the fewest neighbours first.",
    )


def _plot_pattern(matrix: Any, ax: Axes) -> None:
    ax.spy(matrix, markersize=0.45, color=STYLES["graph"].colour, aspect="equal", rasterized=True)
    ax.set(xlabel="number of the unknown", xticks=[0, matrix.shape[0]], yticks=[0, matrix.shape[0]])
    ax.xaxis.set_ticks_position("bottom")
    for spine in ax.spines.values():
        spine.set(visible=True, color=GREY)


def block_picture(H: Any, poses: int, side: int = 400) -> npt.NDArray[np.uint8]:
    """Paint which blocks of H are not zero, one cell for each pair of unknowns: RGB, `side` pixels wide and a frame.

    Parameters
    ----------
    H : sparse matrix
        As `linearize` gives it, of poses (three numbers each) and landmarks (two).
    poses : int
        How many of the unknowns are poses.
    side : int
        Width, px, at least one for each unknown.

    Returns
    -------
    ndarray of uint8, shape (S, S, 3)
    """
    entries = scipy.sparse.coo_array(H)
    rows, columns = (_unknown(each, poses) for each in (entries.row, entries.col))
    count = poses + (H.shape[0] - 3 * poses) // 2
    filled = np.zeros((count, count), dtype=bool)
    filled[rows, columns] = np.abs(entries.data) > 0
    painted = np.full((count, count, 3), 255, dtype=np.uint8)
    near = np.abs(np.subtract.outer(np.arange(count), np.arange(count))) <= 1
    pair = np.arange(count) < poses
    painted[filled & near] = (60, 60, 66)
    painted[filled & ~near & (pair & pair[:, None])] = (42, 138, 130)
    painted[filled & ~near & ~(pair & pair[:, None])] = (161, 69, 102)
    cells = np.arange(max(side, count)) * count // max(side, count)
    painted = painted[cells][:, cells]
    return np.pad(painted, ((1, 1), (1, 1), (0, 0)), constant_values=150)


def _unknown(places: npt.NDArray[np.int64], poses: int) -> npt.NDArray[np.int64]:
    """Numbers of the unknowns to which places in the states belong."""
    return np.where(places < 3 * poses, places // 3, poses + (places - 3 * poses) // 2)


def count_of_free_moves(linearize: Linearize) -> int:
    """How many eigenvalues of H of a small closed loop, with nothing held, are zero but for rounding."""
    world = loop(1, side=2)
    values = np.linalg.eigvalsh(scipy.sparse.csc_array(linearize(world.graph, world.odometry)[0]).toarray())
    return int(np.count_nonzero(np.abs(values) < 1e-10 * values[-1]))


def draw_free_moves(linearize: Linearize, amounts: Sequence[float] = (0.9, 0.9, 0.25)) -> Drawing:
    """Draw the three ways in which a whole map can move without any residual noticing."""
    world = loop(1, side=4)
    H = scipy.sparse.csc_array(linearize(world.graph, world.odometry)[0])
    poses = world.graph.split(world.odometry)[0]
    turn = np.column_stack([-poses[:, 1], poses[:, 0], np.ones(len(poses))])
    moves = {
        "shifted along x": np.tile([1.0, 0.0, 0.0], (len(poses), 1)),
        "shifted along y": np.tile([0.0, 1.0, 0.0], (len(poses), 1)),
        "turned": turn,
    }
    said, graph = [], STYLES["graph"]
    with course_style():
        figure = Figure(figsize=(10.4, 3.8))
        for ax, (title, move), amount in zip(figure.subplots(1, 3), moves.items(), amounts, strict=True):
            flat = move.ravel() / np.linalg.norm(move)
            force = float(np.abs(H @ flat).max() / np.abs(H).max())
            ax.plot(*poses[:, :2].T, color=GREY, lw=1.5, label="before")
            ax.plot(*(poses + amount * move)[:, :2].T, color=graph.colour, marker=".", lw=1.5, label="after")
            ax.set(xlabel="x (m)", ylabel="y (m)")
            ax.set_aspect("equal", adjustable="datalim")
            nothing = "0" if force < 1e-12 else f"{force:.1e}"
            ax.set_title(f"{title}: |H v| = {nothing}", fontsize=11)
            said.append(f"{title}, H times it is {nothing}")
    return Drawing(figure, f"Three moves of a whole map that change no residual: {'; '.join(said)}.")
