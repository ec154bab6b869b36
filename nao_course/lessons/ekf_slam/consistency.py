"""Measure the consistency of a SLAM filter: the NEES of its pose over many drives, with its band."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, Pose, pose_errors
from nao_course.lessons.ekf_slam.filters import FirstEstimates
from nao_course.lessons.ekf_slam.homework_log import innovation_and_covariance
from nao_course.metrics import band, squared_distances
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY
from nao_course.sim import Field
from nao_course.sim.drives import (
    Belief,
    Drive,
    FieldOfView,
    Function,
    Functions,
    NamedEkf,
    Sigmas,
    Step,
    as_belief,
    checked_functions,
    measure_in_view,
    true_path,
)
from nao_course.slam import Motion, range_and_bearing

RUNS = 100
START = Pose(1.4, -0.8, 0.0)  # in the field frame; the origin of the filter's map frame
LAPS, STEPS, STEP = 8, 25, 0.2  # circles of 0.8 m; steps to each, and metres to a step
# Two pictures side by side, 61 degrees wide each; 4 m cover the half field.
VIEW = FieldOfView(float(np.radians(60)), 4.0)

# A range is accurate to 2 cm once the body tilt has been estimated from the field's lines (lesson 04).
NOMINAL = Sigmas(0.02, 0.01, float(np.radians(1.0)), float(np.radians(1.5)), 0.02)
NOISY = Sigmas(0.02, 0.01, float(np.radians(3.0)), float(np.radians(5.0)), 0.02)


def field_drive(seed: int, sigmas: Sigmas = NOMINAL, laps: int = LAPS, view: FieldOfView = VIEW) -> Drive:
    """Drive circles of 25 steps on the half field and measure the landmarks in view after each step.

    The drive is in the frame of the start, where no landmark is measured. The same seed gives the same drive.
    """
    rng = np.random.default_rng(seed)
    landmarks = START.to_local(Field(2012).detectable_positions)
    motion = Motion(STEP, 2 * np.pi / STEPS)
    start, *path = (pose.as_array() for pose in true_path([motion] * laps * STEPS, sigmas, rng))
    steps = [Step.at_start(start)]
    for pose in path:
        numbers, seen = measure_in_view(pose, landmarks, sigmas, view, rng, draw_unseen=True)
        steps.append(Step(pose, motion, sigmas.control_covariance, numbers, seen, sigmas.covariances(seen)))
    return Drive(landmarks, tuple(steps))


@dataclass(frozen=True, eq=False)
class FilterTrace:
    """Pose errors (M, 3) of a filter along a drive, with wrapped headings, and their covariances (M, 3, 3).

    `nis` (K,) is the normalised innovation squared per degree of freedom of each update; it is empty unless requested.
    """

    errors: FloatArray
    covariances: FloatArray
    nis: FloatArray

    @property
    def nees(self) -> FloatArray:
        """Return the normalised estimation error squared of each pose, (M,); 3 degrees of freedom."""
        return squared_distances(self.errors, self.covariances)


def follow(drive: Drive, functions: Functions, with_nis: bool = False) -> FilterTrace:
    """Run a filter along a drive: predict, update with the landmarks on the map, then add the others.

    `functions` are predict, update_landmarks and add_landmark. The drive's measurements come with the landmarks'
    numbers; `with_nis` doubles the time. Raise a ValueError if a function returns something of another shape.
    """
    slam = NamedEkf(Pose(), *checked_functions(functions))
    errors, covariances, nis = [], [], []
    for step in drive.steps[1:]:
        slam.move(step.control, step.control_covariance)
        again, slots = slam.on_map(step.numbers)
        if with_nis and again:
            values, noise = step.measurements[again].reshape(-1), step.covariances[0]
            innovation, S = innovation_and_covariance(slam.state, slam.covariance, slots, values, noise)
            nis.append(squared_distances(innovation[None], S[None])[0] / len(values))
        slam.observe(step.numbers, step.measurements, step.covariances)
        errors.append(pose_errors(slam.state[:3], step.pose))
        covariances.append(slam.covariance[:3, :3])
    return FilterTrace(np.array(errors), np.array(covariances), np.array(nis))


# --- filters to compare ---


def without_pose_map(functions: Functions) -> Functions:
    """Return the three functions with the covariance between pose and map set to zero after each call."""

    def cut(function: Function) -> Function:
        def without(*arguments: object) -> Belief:
            state, covariance = function(*arguments)
            covariance = np.array(covariance, dtype=float)
            covariance[:3, 3:] = covariance[3:, :3] = 0.0
            return state, covariance

        return without

    predict, update_landmarks, add_landmark = functions
    return cut(predict), cut(update_landmarks), cut(add_landmark)


def with_first_estimates(functions: Functions) -> Functions:
    """Return the three functions with Jacobians at first estimates; for one drive."""
    own = FirstEstimates(*functions)
    return own.predict, own.update_landmarks, own.add_landmark


VARIANTS: Mapping[str, Callable[[Functions], Functions]] = {
    "your filter": lambda functions: functions,
    "first estimates": with_first_estimates,
    "no covariance between pose and map": without_pose_map,
}
COLOURS = {
    "your filter": STYLES["ekf"].colour,
    "first estimates": "#2e8540",
    "no covariance between pose and map": "#c84b00",
}


def compare(
    predict: Function,
    update_landmarks: Function,
    add_landmark: Function,
    sigmas: Sigmas = NOISY,
    runs: int = RUNS,
    variants: Sequence[str] = tuple(VARIANTS),
    with_nis: bool = False,
) -> dict[str, list[FilterTrace]]:
    """Run variants of a student's filter along the same drives.

    Parameters
    ----------
    predict, update_landmarks, add_landmark : callable
        The student's functions.
    sigmas : Sigmas
        `NOMINAL` or `NOISY`.
    runs : int
        Number of drives.
    variants : sequence of str
        Keys of `VARIANTS`.
    with_nis : bool
        Whether to compute the NIS, too.

    Returns
    -------
    dict of str to list of FilterTrace
        One trace for each drive.
    """
    functions = (predict, update_landmarks, add_landmark)
    drives = [field_drive(seed, sigmas) for seed in range(runs)]
    return {
        name: [follow(drive, VARIANTS[name](functions), with_nis) for drive in drives] for name in variants
    }


# --- the unobservable rotation ---


def say_rotation(update_landmarks: Function) -> str:
    """Return equation 7.9 in numbers: (H_p H_l) N at first estimates of a pose and a landmark, and after an update."""

    def rotation(state: FloatArray) -> FloatArray:
        x, y, _, l_x, l_y = state
        return np.array([-y, x, 1.0, -l_y, l_x])

    def seen(state: FloatArray) -> FloatArray:
        return range_and_bearing(state[:3], state[None, 3:])[0]

    def product(state: FloatArray, direction: FloatArray) -> str:
        step = 1e-6 * direction
        bearing, distance = (seen(state + step) - seen(state - step)) / 2e-6
        return f"{bearing:z6.3f} {distance:z6.3f}"

    first = np.array([1.0, 0.5, 0.3, 3.0, 2.0])
    answer = update_landmarks(first.copy(), 0.01 * np.eye(5), [0], seen(first) + (0.1, 0.2), 0.01 * np.eye(2))
    updated, _ = as_belief(answer, len(first), "update_landmarks")
    return (
        f"(H_p H_l) N, bearing and range:\n{product(first, rotation(first))}  all at the first estimates\n"
        f"{product(updated, rotation(first))}  H after an update, the old N\n"
        f"{product(updated, rotation(updated))}  both after the update"
    )


# --- figures ---


def mean_nees(traces: Sequence[FilterTrace]) -> float:
    """Return the mean NEES over all drives and steps."""
    return float(np.mean([trace.nees for trace in traces]))


@course_style()
def draw_consistency(found: Mapping[str, Sequence[FilterTrace]]) -> Drawing:
    """Draw the mean NEES of each step over many drives, with the band of a consistent filter.

    Parameters
    ----------
    found : mapping of str to sequence of FilterTrace
        Result of `compare`.

    Returns
    -------
    Drawing
        One plot with a logarithmic axis; the text contains every mean.
    """
    runs = len(next(iter(found.values())))
    low, high = band(3, runs)
    figure = Figure(figsize=(8.4, 4.4))
    ax = figure.add_subplot()
    ax.axhspan(low, high, color="#e3e5e8", zorder=1, label="95 % band")
    ax.axhline(3.0, color=GREY, lw=1, ls="--", zorder=2, label="ideal")
    for (name, traces), line in zip(found.items(), ("-", "--", ":"), strict=False):
        nees = np.mean([trace.nees for trace in traces], axis=0)
        steps = np.arange(1, len(nees) + 1)
        label = f"{name}: mean {mean_nees(traces):.3g}"
        if nis := [trace.nis.mean() for trace in traces if len(trace.nis)]:
            label += f", NIS {np.mean(nis):.2f}"
        ax.plot(steps, nees, line, color=COLOURS.get(name, GREY), lw=1.8, zorder=3, label=label)
    ax.set(yscale="log", xlabel="step", ylabel=f"pose NEES, mean of {runs} drives", xlim=(1, None))
    ticks = [1, 2, 3, 5, 10, 20, 50, 100]
    ax.set_yticks(ticks, labels=[str(tick) for tick in ticks])
    ax.minorticks_off()
    legend_below(figure, ax.get_legend_handles_labels()[0], columns=2)
    means = "; ".join(f"{name} {mean_nees(traces):.2f}" for name, traces in found.items())
    return Drawing(
        figure,
        f"Pose NEES by step, mean of {runs} drives; for a consistent filter it lies between {low:.2f} and {high:.2f}. "
        f"Mean over all steps: {means}.",
    )
