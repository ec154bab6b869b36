"""Panels of lesson 11: a picture from an uncertain pose, and the landmark that each measurement is matched with."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.drives import HEAD_PITCH, YAWS, OdometryNoisePerMove
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.slam_on_the_field.associating import (
    BAD,
    GATE,
    GOOD,
    HEADING_SIGMA,
    POSITION_SIGMA,
    RUNS,
    Associate,
)
from nao_course.lessons.slam_on_the_field.one_drive import GATE as DRIVE_GATE
from nao_course.lessons.slam_on_the_field.one_drive import the_drive
from nao_course.lessons.slam_on_the_field.worlds import (
    FIELD,
    KINDS,
    LANDMARKS,
    AssociationProblem,
    association_problem,
)
from nao_course.plotting import LANDMARK_MARKERS, Drawing, course_style, plot_ellipse, plot_field, plot_pose
from nao_course.plotting.legends import legend_below, source_key
from nao_course.slam import measured_points, run_slam
from nao_course.widgets import FunctionPanel, PlayerPanel, Ray, Slider, Toggle, WorldPlayer, WorldView

LANDMARK_SIGMA = 0.04  # m
MAP_COLOUR, SEEN_COLOUR = "#0b5fa5", "#222222"
NOT_SHOWN = -2  # in place of a landmark's number: a pair that has not been added yet
WRONG_PICTURE = 14  # nearest neighbour goes wrong at its third pair, joint compatibility does not


class AssociationPanel(FunctionPanel):
    """One picture from an uncertain pose: lines lead from each measurement to the landmark that was chosen for it.

    Parameters
    ----------
    associate : callable
        ``associate(state, covariance, kinds, measurements, measurement_covariance, gate)`` returns a number for each
        measurement.
    """

    def __init__(self, associate: Callable[..., Any]) -> None:
        """Begin with a heading whose standard deviation is 8 degrees."""
        super().__init__(
            "Which landmark is it?",
            _shown,
            [
                Slider("picture", "Picture", 0, RUNS - 1, 1, 4, tooltip="Another place, other errors"),
                Slider("heading", "Heading: σ", 0.5, 20, 0.5, 8, unit="°", tooltip="Standard deviation"),
                Slider(
                    "position",
                    "Position: σ",
                    0.01,
                    0.5,
                    0.01,
                    0.15,
                    unit="m",
                    tooltip="Standard deviation along each axis",
                ),
                Slider("gate", "Gate", 0.5, 10, 0.5, 3, unit="σ", tooltip="Largest distance of a pair"),
                Toggle("together", "Judge them together"),
            ],
            student={"associate": associate},
            unfinished="Finish exercises 11.3 and 11.4 to see which landmarks are chosen.",
        )


class ReplayPanel(PlayerPanel):
    """Nearest neighbour and joint compatibility on one picture, one pair at a time.

    Parameters
    ----------
    associate, joint_distance : callable
        The student's.
    """

    def __init__(self, associate: Callable[..., Any], joint_distance: Callable[..., Any]) -> None:
        """Begin where nearest neighbour makes its first mistake."""
        super().__init__(
            "One picture, pair by pair",
            _replayed,
            Slider("step", "Pairs", 1, 8, 1, 3, tooltip="How many pairs have been added"),
            [
                Slider(
                    "picture", "Picture", 0, RUNS - 1, 1, WRONG_PICTURE, tooltip="Another place, other errors"
                )
            ],
            speeds={"1 a second": 1.0},
            backwards=False,
            student={"associate": associate, "joint_distance": joint_distance},
            unfinished="Finish exercises 11.3 and 11.4 to see the replay.",
        )


class RoomPanel(WorldPlayer):
    """The lesson's drive with the student's filter, in the room, picture by picture.

    Parameters
    ----------
    EkfSlam : type
        The student's.
    associate : callable
        Association that the filter uses; by default joint compatibility.
    """

    def __init__(
        self,
        EkfSlam: Callable[..., Any],  # noqa: N803 - the students' name
        associate: Associate = associate_jointly,
    ) -> None:
        """Begin at the start of the drive."""
        self._associate = associate
        super().__init__(
            "The drive in the room",
            WorldView(FIELD),
            self._show_step,
            Slider(
                "step", "Picture", 0, len(the_drive().log) - 1, 1, 0, tooltip=f"{len(YAWS)} pictures a stop"
            ),
            speeds={"2 a second": 2.0, "5 a second": 5.0},
            student={"EkfSlam": EkfSlam},
            unfinished="Finish exercise 11.5 to see your filter drive.",
        )

    def _show_step(self, values: Any, student: Any) -> Iterator[str]:
        """Show the true robot with its measurements, then the estimate after the update with them."""
        drive, step = the_drive(), int(values.step)
        _, seen = drive.log[step]
        true_rays = [Ray(tuple(LANDMARKS[number].tolist())) for number in drive.origins[step] if number >= 0]
        paths = {"truth": drive.poses[: step + 1]}
        head = (YAWS[step % len(YAWS)], HEAD_PITCH)
        self.world.update(Pose.from_array(drive.poses[step]), None, head=head, rays=true_rays, paths=paths)
        slam = student.EkfSlam(drive.start, OdometryNoisePerMove(), DRIVE_GATE, association=self._associate)
        estimates = run_slam(slam, drive.log[: step + 1])
        now = estimates[-1]
        measured = [
            Ray((x, y), source="ekf")
            for x, y in measured_points(seen, now.pose).tolist()
            if np.isfinite((x, y)).all()
        ]
        path = [each.pose for each in estimates]
        self.world.update(estimate=now, rays=[*true_rays, *measured], paths={**paths, "ekf": path})
        off = 100 * float(np.hypot(*(now.pose.as_array() - drive.poses[step])[:2]))
        deviation = 100 * float(np.sqrt(max(np.linalg.eigvalsh(now.covariance[:2, :2])[-1], 0.0)))
        yield f"Off by {off:.0f} cm, with a standard deviation of {deviation:.0f} cm at most."


def _given(each: AssociationProblem, gate: float) -> tuple[Any, ...]:
    """Return the arguments of an association."""
    return (each.state, each.covariance, list(KINDS), each.observation, each.observation.covariance, gate)


def _chosen(associate: Callable[..., Any], each: AssociationProblem, gate: float) -> npt.NDArray[np.int64]:
    """Associate, and refuse an answer of another length in words."""
    indices = np.asarray(associate(*_given(each, gate)))
    if indices.shape != (len(each.origins),):
        raise ValueError(f"{len(each.origins)} measurements need as many numbers, got shape {indices.shape}")
    return indices.astype(int)


def _shown(values: Any, student: Any) -> Iterator[Any]:
    """Draw the picture's measurements, then their matches."""
    each = association_problem(
        int(values.picture), values.position, float(np.radians(values.heading)), LANDMARK_SIGMA
    )
    yield {"The map, and one picture's measurements": draw_problem(each, None)}
    indices = _chosen(associate_jointly if values.together else student.associate, each, values.gate)
    yield {"The map, and one picture's measurements": draw_problem(each, indices)}
    how = "Judged together" if values.together else "Judged one by one"
    new = int(np.count_nonzero(indices < 0))
    yield f"{how}: {each.right(indices)} of {len(each.origins)} right, {new} without a landmark."


def _replayed(values: Any, student: Any) -> Iterator[Any]:
    """Draw the first pairs of both methods, and say how far they are apart, alone and together."""
    each = association_problem(int(values.picture), POSITION_SIGMA, HEADING_SIGMA)
    drawings, said = {}, []
    for name, method in (
        ("Nearest neighbour", student.associate),
        ("Joint compatibility", associate_jointly),
    ):
        indices = _chosen(method, each, GATE)
        alone = {
            i: _distance(student.joint_distance, each, indices, [i]) for i in np.flatnonzero(indices >= 0)
        }
        order = sorted(alone, key=lambda i: alone[i])[: int(values.step)]
        drawings[name] = draw_problem(
            each, np.where(np.isin(np.arange(len(indices)), order), indices, NOT_SHOWN)
        )
        if not order:
            said.append(f"{name}: no pair.")
            continue
        together, right = _distance(student.joint_distance, each, indices, order), each.origins[order[-1]]
        said.append(
            f"{name}: pair {len(order)} is {'right' if indices[order[-1]] == right else 'WRONG'}, "
            f"{alone[order[-1]]:.1f} σ alone; {len(order)} together: {together:.1f} σ."
        )
    yield drawings
    yield " ".join(said)


def _distance(
    joint_distance: Callable[..., Any], each: AssociationProblem, indices: Any, pairs: list[Any]
) -> float:
    """Return the joint distance of some of the pairs, by the student's function."""
    kept = [int(index) if i in pairs else -1 for i, index in enumerate(indices)]
    seen = each.observation
    return float(joint_distance(each.state, each.covariance, kept, seen, seen.covariance))


@course_style()
def draw_problem(each: AssociationProblem, indices: Any) -> Drawing:
    """Draw map, estimated pose, and a line from each measurement to its landmark; green where it is right."""
    estimated = Pose.from_array(each.state[:3])
    ends = measured_points(each.observation, estimated)
    marks: FloatArray = np.reshape(each.state[3:], (-1, 2))
    figure = Figure(figsize=(5.2, 5.7))
    ax = figure.add_subplot()
    plot_field(FIELD, ax)
    for place, kind in zip(marks, KINDS, strict=True):
        plot_ellipse(place, LANDMARK_SIGMA**2 * np.eye(2), ax, "ekf")
        ax.plot(*place, LANDMARK_MARKERS[kind], color="none", mec=MAP_COLOUR, ms=8, mew=1.4, zorder=5)
    for n, end in enumerate(ends):
        kind = each.observation[n].kind
        ax.plot([estimated.x, end[0]], [estimated.y, end[1]], color="#444", lw=0.7, alpha=0.5, zorder=3)
        has_match = indices is not None and 0 <= indices[n] < len(marks)
        is_alone = indices is not None and not has_match and indices[n] != NOT_SHOWN
        edge = BAD if is_alone else SEEN_COLOUR
        ax.plot(*end, LANDMARK_MARKERS[kind], color="white", mec=edge, ms=7, mew=1.6, zorder=5.5)
        if has_match:
            colour = GOOD if indices[n] == each.origins[n] else BAD
            ax.plot(*np.column_stack([end, marks[indices[n]]]), color=colour, lw=3, zorder=4.5)
    plot_pose(each.pose, ax)
    plot_pose(estimated, ax, "ekf")
    plot_ellipse((estimated.x, estimated.y), each.covariance[:2, :2], ax, "ekf")
    keys = [source_key("truth", "true pose"), source_key("ekf", "estimate, 95 %")]
    keys += [
        Line2D([], [], color=colour, mec=edge, marker="o", mew=1.4, ls="", ms=7, label=name)
        for name, colour, edge in (
            ("landmark on the map", "none", MAP_COLOUR),
            ("measurement", "white", SEEN_COLOUR),
            ("measurement, no match", "white", BAD),
        )
    ]
    keys += [
        Line2D([], [], color=colour, lw=3, label=name)
        for name, colour in (("right match", GOOD), ("wrong match", BAD))
    ]
    legend_below(figure, keys, columns=2)
    off = np.hypot(estimated.x - each.pose.x, estimated.y - each.pose.y)
    said = f"{len(each.origins)} measurements from an estimated pose that is off by {off:.2f} m"
    if indices is not None:
        said += f"; {each.right(indices)} of them are matched with the right landmark"
    return Drawing(figure, f"The half field with {len(LANDMARKS)} landmarks on the map: {said}.")
