"""Figures of the matrix H: its blocks, the fill-in of its factor, and its null space."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.graphs import Graph
from nao_course.lessons.pose_graphs.worlds import World, loop
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY

Linearize = Callable[[Graph, FloatArray], tuple[Any, FloatArray]]


def block_picture(H: Any, poses: int, side: int = 500) -> npt.NDArray[np.uint8]:
    """Paint which blocks of H are not zero, one cell for each pair of unknowns, with a frame: an RGB picture (S, S, 3).

    H has three rows for each pose and two for each landmark; `side` is the width in px, at least one for each unknown.
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
    """Return the numbers of the unknowns to which places in the states belong."""
    return np.where(places < 3 * poses, places // 3, poses + (places - 3 * poses) // 2)


def free_loop() -> World:
    """Return the small closed loop of nine poses whose free moves are counted and drawn."""
    return loop(1, side=2)


def count_of_free_moves(linearize: Linearize) -> int:
    """Return how many eigenvalues of H of a small closed loop are zero except for rounding, with nothing held."""
    world = free_loop()
    values = np.linalg.eigvalsh(scipy.sparse.csc_array(linearize(world.graph, world.odometry)[0]).toarray())
    return int(np.count_nonzero(np.abs(values) < 1e-10 * values[-1]))


@course_style()
def draw_free_moves(linearize: Linearize, amounts: Sequence[float] = (0.45, 0.45, 0.25)) -> Drawing:
    """Draw the three motions of a whole map that change no residual."""
    world = free_loop()
    H = scipy.sparse.csc_array(linearize(world.graph, world.odometry)[0])
    poses = world.graph.split(world.odometry)[0]
    turn = np.column_stack([-poses[:, 1], poses[:, 0], np.ones(len(poses))])
    moves = {
        "shifted along x": np.tile([1.0, 0.0, 0.0], (len(poses), 1)),
        "shifted along y": np.tile([0.0, 1.0, 0.0], (len(poses), 1)),
        "turned": turn,
    }
    said, graph = [], STYLES["graph"]
    figure = Figure(figsize=(10.4, 4.1))
    zeros = count_of_free_moves(linearize)
    figure.suptitle(
        f"{zeros} of {H.shape[0]} eigenvalues are zero; v is the motion of all poses", fontsize=12
    )
    axes = figure.subplots(1, 3)
    for ax, (title, move), amount in zip(axes, moves.items(), amounts, strict=True):
        flat = move.ravel() / np.linalg.norm(move)
        force = float(np.abs(H @ flat).max() / np.abs(H).max())
        ax.plot(*poses[:, :2].T, color=GREY, lw=1.5, label="before")
        ax.plot(*(poses + amount * move)[:, :2].T, color=graph.colour, marker=".", lw=1.5, label="after")
        ax.set(xlabel="x (m)", ylabel="y (m)")
        ax.set_aspect("equal", adjustable="datalim")
        nothing = "0" if force < 1e-12 else f"{force:.1e}"
        ax.set_title(f"{title}: |H v| = {nothing}", fontsize=11)
        said.append(f"{title}, H times it is {nothing}")
    legend_below(figure, axes[0].get_legend_handles_labels()[0])
    return Drawing(
        figure,
        f"{zeros} of {H.shape[0]} eigenvalues are zero. Three moves of a map of {len(poses)} poses change no residual: "
        f"{'; '.join(said)}.",
    )
