"""Whether a SLAM filter is as sure as it may be: its pose's NEES over many drives on the field, with its band."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.ekf_slam.filters import FirstEstimates
from nao_course.lessons.ekf_slam.homework_log import (
    Belief,
    Function,
    Sigmas,
    as_belief,
    innovation_and_spread,
    true_path,
)
from nao_course.metrics import band, squared_distances
from nao_course.plotting import STYLES, Drawing, Table, course_style, table
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY
from nao_course.sim import Field
from nao_course.slam import range_and_bearing

RUNS = 100
START = Pose(1.4, -0.8, 0.0)  # in the field's frame; the filter's own frame begins here
LAPS, STEPS, STEP = 8, 25, 0.2  # circles of 0.8 m; steps to each, and metres to a step
REACH = 4.0  # m: as far as the half field goes
SIDEWAYS = float(np.radians(60))  # two pictures side by side, 61 degrees wide each

# A range is good to 2 cm once the field's lines have told how the camera leans (lesson 04).
NOMINAL = Sigmas(0.02, 0.01, float(np.radians(1.0)), float(np.radians(1.5)), 0.02)
NOISY = Sigmas(0.02, 0.01, float(np.radians(3.0)), float(np.radians(5.0)), 0.02)

Functions = tuple[Function, Function, Function]  # predict, update_landmarks, add_landmark


@dataclass(frozen=True, eq=False)
class FieldDrive:
    """A drive over the half field as the simulator knows it, in the frame of the start.

    Parameters
    ----------
    landmarks : ndarray, shape (k, 2)
        The field's corners and posts, m.
    path : ndarray, shape (M + 1, 3)
        True poses.
    controls : ndarray, shape (M, 2)
        (distance, turn) as commanded, m and rad.
    sights : tuple of (ndarray of int (n,), ndarray (n, 2))
        Which landmarks are seen after each step, and their (bearing, range).
    sigmas : Sigmas
        Of all errors; what the filter is told.
    """

    landmarks: FloatArray
    path: FloatArray
    controls: FloatArray
    sights: tuple[tuple[npt.NDArray[np.intp], FloatArray], ...]
    sigmas: Sigmas


def field_drive(seed: int, sigmas: Sigmas = NOMINAL, laps: int = LAPS) -> FieldDrive:
    """Drive circles on the half field and look ahead after each step.

    Parameters
    ----------
    seed : int
        Of all errors.
    sigmas : Sigmas
        Their size.
    laps : int
        How many circles of 25 steps.

    Returns
    -------
    FieldDrive
        The same seed gives the same one.
    """
    rng = np.random.default_rng(seed)
    marks = [mark for mark in Field(2012).landmarks if mark.kind != "cross"]
    landmarks = START.to_local([(mark.x, mark.y) for mark in marks])
    controls = np.tile([STEP, 2 * np.pi / STEPS], (laps * STEPS, 1))
    path = np.array([pose.as_array() for pose in true_path(controls, sigmas, rng)])
    exact = range_and_bearing(path[1:, None], landmarks)
    noisy = exact + rng.standard_normal(exact.shape) * (sigmas.bearing, sigmas.range)
    noisy[..., 0] = wrap_angle(noisy[..., 0])
    seen = (np.abs(exact[..., 0]) <= SIDEWAYS) & (exact[..., 1] <= REACH)
    sights = tuple((np.flatnonzero(row), each[row]) for row, each in zip(seen, noisy, strict=True))
    return FieldDrive(landmarks, path, controls, sights, sigmas)


@dataclass(frozen=True, eq=False)
class Trace:
    """What a filter believed of its pose along a drive of M steps.

    Parameters
    ----------
    errors : ndarray, shape (M, 3)
        Believed less true pose, the heading wrapped.
    covariances : ndarray, shape (M, 3, 3)
        Believed.
    nis : ndarray, shape (K,)
        Normalised innovation squared over its degrees of freedom, of each update; empty unless asked for.
    """

    errors: FloatArray
    covariances: FloatArray
    nis: FloatArray

    @property
    def nees(self) -> FloatArray:
        """Normalised estimation error squared of each pose, (M,); 3 degrees of freedom."""
        return squared_distances(self.errors, self.covariances)


def follow(drive: FieldDrive, functions: Functions, with_nis: bool = False) -> Trace:
    """Run a filter along a drive: move, correct by what is on the map, then add what is not.

    Parameters
    ----------
    drive : FieldDrive
        Which landmark is which is known.
    functions : (predict, update_landmarks, add_landmark)
        The student's, or others that are called in the same way.
    with_nis : bool
        Whether innovations are judged, too; it takes twice as long.

    Returns
    -------
    Trace
        From the first step on.

    Raises
    ------
    ValueError
        If a function returns something of another shape.
    """
    predict, update_landmarks, add_landmark = functions
    Q, R = drive.sigmas.control_covariance, drive.sigmas.measurement_covariance
    state, covariance = np.zeros(3), np.zeros((3, 3))
    on_map: list[int] = []  # which of the field's landmarks each one of the map is
    errors, covariances, nis = [], [], []
    for control, (seen, measured), truth in zip(drive.controls, drive.sights, drive.path[1:], strict=True):
        answer = predict(state.copy(), covariance.copy(), control.copy(), Q.copy(), len(on_map))
        state, covariance = as_belief(answer, len(state), "predict")
        known = [number for number, landmark in enumerate(seen) if landmark in on_map]
        if known:
            indices, values = [on_map.index(seen[number]) for number in known], measured[known].reshape(-1)
            if with_nis:
                surprise, spread = innovation_and_spread(state, covariance, indices, values, R)
                nis.append(squared_distances(surprise[None], spread[None])[0] / len(values))
            answer = update_landmarks(state.copy(), covariance.copy(), indices, values, R.copy())
            state, covariance = as_belief(answer, len(state), "update_landmarks")
        for number in set(range(len(seen))) - set(known):
            answer = add_landmark(state.copy(), covariance.copy(), measured[number].copy(), R.copy())
            state, covariance = as_belief(answer, len(state) + 2, "add_landmark")
            on_map.append(int(seen[number]))
        off = state[:3] - truth
        errors.append([off[0], off[1], float(wrap_angle(off[2]))])
        covariances.append(covariance[:3, :3])
    return Trace(np.array(errors), np.array(covariances), np.array(nis))


# --- filters to compare ---


def without_pose_map(functions: Functions) -> Functions:
    """The same three functions, with the covariances between pose and map set to zero after each."""

    def cut(function: Function) -> Function:
        def ill(*arguments: object) -> Belief:
            state, covariance = function(*arguments)
            covariance = np.array(covariance, dtype=float)
            covariance[:3, 3:] = covariance[3:, :3] = 0.0
            return state, covariance

        return ill

    predict, update_landmarks, add_landmark = functions
    return cut(predict), cut(update_landmarks), cut(add_landmark)


def with_first_estimates(functions: Functions) -> Functions:
    """The same three functions with slopes at first estimates; for one drive."""
    own = FirstEstimates(*functions)
    return own.predict, own.update_landmarks, own.add_landmark


VARIANTS: Mapping[str, Callable[[Functions], Functions]] = {
    "as it is": lambda functions: functions,
    "first estimates": with_first_estimates,
    "no covariance of pose and map": without_pose_map,
}
COLOURS = {
    "as it is": STYLES["ekf"].colour,
    "first estimates": "#2e8540",
    "no covariance of pose and map": "#c84b00",
}


def compare(
    predict: Function,
    update_landmarks: Function,
    add_landmark: Function,
    sigmas: Sigmas = NOISY,
    runs: int = RUNS,
    variants: Sequence[str] = tuple(VARIANTS),
    with_nis: bool = False,
) -> dict[str, list[Trace]]:
    """Run variants of a student's filter along the same drives.

    Parameters
    ----------
    predict, update_landmarks, add_landmark : callable
        The student's.
    sigmas : Sigmas
        `NOMINAL` or `NOISY`.
    runs : int
        How many drives.
    variants : sequence of str
        Of `VARIANTS`.
    with_nis : bool
        Whether innovations are judged, too.

    Returns
    -------
    dict of str to list of Trace
        One for each drive.
    """
    functions = (predict, update_landmarks, add_landmark)
    drives = [field_drive(seed, sigmas) for seed in range(runs)]
    return {
        name: [follow(drive, VARIANTS[name](functions), with_nis) for drive in drives] for name in variants
    }


# --- how they are shown ---


def mean_nees(traces: Sequence[Trace]) -> float:
    """Mean over all drives and steps."""
    return float(np.mean([trace.nees for trace in traces]))


def nees_table(found: Mapping[str, Sequence[Trace]]) -> Table:
    """Set the mean NEES of each variant in a table, with its band and, where judged, the NIS per degree of freedom."""
    low, high = band(3, len(next(iter(found.values()))))
    rows = []
    for name, traces in found.items():
        mean = mean_nees(traces)
        nis = np.concatenate([trace.nis for trace in traces])
        rows.append(
            (
                name,
                f"{mean:.2f}",
                "inside" if low <= mean <= high else "outside",
                f"{nis.mean():.2f}" if len(nis) else "-",
            )
        )
    return table(("filter", "mean NEES", f"band {low:.2f} to {high:.2f}", "NIS per degree of freedom"), rows)


def draw_consistency(found: Mapping[str, Sequence[Trace]]) -> Drawing:
    """Draw the mean NEES of each step over many drives, with the band that an honest filter keeps.

    Parameters
    ----------
    found : mapping of str to sequence of Trace
        What `compare` gives.

    Returns
    -------
    Drawing
        One plot with a logarithmic axis; the text says every mean.
    """
    runs = len(next(iter(found.values())))
    low, high = band(3, runs)
    with course_style():
        figure = Figure(figsize=(8.4, 4.4))
        ax = figure.add_subplot()
        ax.axhspan(low, high, color="#e3e5e8", zorder=1, label="95 % band")
        ax.axhline(3.0, color=GREY, lw=1, ls="--", zorder=2, label="ideal")
        for (name, traces), line in zip(found.items(), ("-", "--", ":"), strict=False):
            nees = np.mean([trace.nees for trace in traces], axis=0)
            steps = np.arange(1, len(nees) + 1)
            ax.plot(steps, nees, line, color=COLOURS.get(name, GREY), lw=1.8, zorder=3, label=name)
        ax.set(yscale="log", xlabel="step", ylabel=f"pose NEES, mean of {runs} drives", xlim=(1, None))
        ticks = [1, 2, 3, 5, 10, 20, 50, 100]
        ax.set_yticks(ticks, labels=[str(tick) for tick in ticks])
        ax.minorticks_off()
        legend_below(figure, ax.get_legend_handles_labels()[0], columns=5)
    told = "; ".join(f"{name} {mean_nees(traces):.2f}" for name, traces in found.items())
    return Drawing(
        figure,
        f"Pose NEES by step, mean of {runs} drives; an honest filter's lies between {low:.2f} and {high:.2f}. "
        f"Mean over all steps: {told}.",
    )
