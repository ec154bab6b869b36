"""The time and memory that solving takes by the size of the system, recorded and on this computer."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse
from matplotlib.figure import Figure

from nao_course.exercises.trying import strict
from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.systems import not_a_solution
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import style_of

System = tuple[scipy.sparse.csc_array, FloatArray]

RECORDED = Path(__file__).with_suffix(".json")
_STYLES = {"dense": "odometry", "sparse, as numbered": "ekf", "sparse, a good ordering": "graph"}


OWN_SIZES = (300, 1000, 3000, 10_000, 30_000, 100_000)
PATIENCE = 0.1  # s: a solver that took longer is not given a larger system, for which it may need minutes


def corridor_system(variables: int, rng: np.random.Generator) -> System:
    """Return the system of a straight walk with a pair of landmarks every three poses.

    Each landmark is measured from the nearest eight or nine poses.
    """
    poses = 3 * variables // 5
    landmarks = variables - poses
    i, j = ([np.arange(k, poses - 1 + k)] for k in (0, 1))
    for number in range(landmarks):
        at = 3 * (number // 2)
        near = np.arange(max(at - 4, 0), min(at + 5, poses))
        i.append(near)
        j.append(np.full(len(near), poses + number))
    first, second = np.concatenate(i), np.concatenate(j)
    weight = 1 / rng.uniform(0.5, 2.0, len(first))
    value = rng.normal(size=len(first))
    entries = np.concatenate([weight, weight, -weight, -weight, [1.0]])
    rows = np.concatenate([first, second, first, second, [0]])
    columns = np.concatenate([first, second, second, first, [0]])
    omega = scipy.sparse.coo_array((entries, (rows, columns)), shape=(variables, variables)).tocsc()
    ends = [np.bincount(each, weight * value, variables) for each in (first, second)]
    return omega, np.subtract(ends[1], ends[0], dtype=np.float64)


def seconds_of(solve_sparse: Callable[..., Any]) -> list[float]:
    """Return the seconds that the student's solver takes here for each of `OWN_SIZES`, or [] if it is blank.

    The larger half is left out after a system that took longer than `PATIENCE`.
    """
    rng, found = np.random.default_rng(8), list[float]()
    for number, size in enumerate(OWN_SIZES):
        if 2 * number >= len(OWN_SIZES) and found[-1] > PATIENCE:
            break
        omega, xi = corridor_system(size, rng)
        start = time.process_time()
        try:
            answer = solve_sparse(omega, xi)
        except NotImplementedError:
            return []
        found.append(max(time.process_time() - start, 1e-5))
        if wrong := not_a_solution(answer, size):
            raise ValueError(wrong.replace("solve must", "solve_sparse must").replace("8.4", "8.6"))
    return found


@course_style()
def draw_costs(solve_sparse: Callable[..., Any] | None = None) -> Drawing:
    """Draw the recorded seconds and megabytes by the number of variables, with three methods.

    Parameters
    ----------
    solve_sparse : callable, optional
        The student's function, whose times on this computer are drawn, too. A build of the course leaves them out,
        because they would differ each time.

    Returns
    -------
    Drawing
        Two panels with logarithmic axes.
    """
    own = seconds_of(solve_sparse) if solve_sparse and not strict() else []
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))
    words = []
    figure = Figure(figsize=(9.8, 4.1))
    times, sizes = figure.subplots(1, 2)
    for name, source in _STYLES.items():
        rows = recorded[name]
        style = style_of(source)
        options = {"color": style.colour, "marker": style.marker, "ms": 6, "lw": 2, "label": name}
        variables = [row["variables"] for row in rows]
        times.plot(variables, [row["seconds"] for row in rows], **options)
        sizes.plot(variables, [row["megabytes"] for row in rows], **options)
        last = rows[-1]
        words.append(
            f"{name}: {last['seconds']:.2g} s and {last['megabytes']:.2g} MB for {last['variables']} variables"
        )
    if own:
        times.plot(
            OWN_SIZES[: len(own)], own, "k*", ms=12, mec="white", zorder=6, label="yours, on this computer"
        )
        words.append(f"yours, on this computer: {own[-1]:.2g} s for {OWN_SIZES[len(own) - 1]} variables")
    times.set(ylabel="seconds for one axis")
    sizes.set(ylabel="megabytes of the factor")
    for ax in (times, sizes):
        ax.set(xscale="log", yscale="log", xlabel="variables")
        ax.grid(color="#e3e5e8")
    legend_below(figure, times.get_legend_handles_labels()[0])
    return Drawing(figure, f"Cost of solving a corridor by its size, on one core. {'; '.join(words)}.")
