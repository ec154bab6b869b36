"""What lesson 07 adds to the student's robot: a map that grows while it drives, by the student's own filter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.ekf_slam.homework_log import as_belief, landmark_blocks
from nao_course.plotting.drawing import say_count
from nao_course.sim import SimulatedNao, Truth, VisibleLandmark, visible_landmarks
from nao_course.slam import Estimate, LandmarkKind, Measurement, Motion, place_estimate
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Look, Overlay, Sight, Stage

REACH = 3.5  # m: beyond it a range from one picture is poor (lesson 04)
SEED = 71  # of the measurements' noise


@dataclass(frozen=True, eq=False)
class _Belief:
    """State and covariance in the frame of the start, and which landmark of the field each landmark is."""

    state: FloatArray = field(default_factory=lambda: np.zeros(3))
    covariance: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    known: tuple[tuple[float, float], ...] = ()
    kinds: tuple[LandmarkKind, ...] = ()

    def estimate(self) -> Estimate:
        """What the map shows."""
        landmarks, own = self.state[3:].reshape(-1, 2), landmark_blocks(self.covariance)
        return Estimate(Pose.from_array(self.state[:3]), self.covariance[:3, :3], landmarks, own, self.kinds)


def _moved(student: StudentCode, nao: SimulatedNao, belief: _Belief, step: Pose) -> _Belief:
    """The belief after a command."""
    motion = Motion(step.x, step.theta)
    answer = student.predict(
        belief.state.copy(),
        belief.covariance.copy(),
        np.array([step.x, step.theta]),
        nao.odometry_noise.covariance(motion),
        len(belief.known),
    )
    return _Belief(*as_belief(answer, len(belief.state), "predict"), belief.known, belief.kinds)


def _looked(student: StudentCode, belief: _Belief, seen: Sequence[_Seen]) -> _Belief:
    """The belief after one picture: what is on the map corrects it, what is not is put on it."""
    again = [each for each in seen if each.place in belief.known]
    state, covariance = belief.state, belief.covariance
    if again:
        answer = student.update_landmarks(
            state.copy(),
            covariance.copy(),
            [belief.known.index(each.place) for each in again],
            np.concatenate([each.measured for each in again]),
            np.array([each.covariance for each in again]),
        )
        state, covariance = as_belief(answer, len(state), "update_landmarks")
    known, kinds = list(belief.known), list(belief.kinds)
    for each in seen:
        if each.place not in belief.known:
            answer = student.add_landmark(state.copy(), covariance.copy(), each.measured, each.covariance)
            state, covariance = as_belief(answer, len(state) + 2, "add_landmark")
            known.append(each.place)
            kinds.append(each.kind)
    return _Belief(state, covariance, tuple(known), tuple(kinds))


@dataclass(frozen=True, eq=False)
class _Seen:
    """A landmark that the simulator names and measures: its place on the field is its name."""

    place: tuple[float, float]
    kind: LandmarkKind
    measured: FloatArray
    covariance: FloatArray


def _measured(nao: SimulatedNao, mark: VisibleLandmark, rng: np.random.Generator) -> _Seen:
    noise = nao.sensor_noise
    bearing = mark.bearing + noise.bearing * rng.standard_normal()
    distance = max(mark.distance * (1 + noise.range_fraction * rng.standard_normal()), 0.05)
    measured = Measurement(float(bearing), float(distance))
    kind: LandmarkKind = "post" if mark.landmark.kind == "post" else "corner"
    values = np.array([measured.bearing, measured.range])
    return _Seen((mark.landmark.x, mark.landmark.y), kind, values, noise.covariance(measured))


def _grow(student: StudentCode, nao: SimulatedNao) -> Look:
    """Begin with zeros and no landmark; follow the commands, and take each picture in."""
    truth, rng = Truth(nao), np.random.default_rng(SEED)
    belief, done = _Belief(), 0

    def look(sight: Sight) -> Overlay:
        nonlocal belief, done
        now, path = belief, nao.odometry_path
        for before, after in pairwise(path[done:]):
            now = _moved(student, nao, now, before.inverse() @ after)
        marks = [
            mark
            for mark in visible_landmarks(nao.field, truth.pose, sight.picture.view)
            if mark.landmark.kind != "cross" and not mark.occluded and mark.distance <= REACH
        ]
        now = _looked(student, now, [_measured(nao, mark, rng) for mark in marks])
        belief, done = now, len(path) - 1
        estimate = now.estimate()
        sure = np.sqrt(np.trace(estimate.covariance[:2, :2]))
        return Overlay(
            result=estimate,
            pixels=[mark.pixel for mark in marks],
            text=f"{say_count(len(estimate.landmarks), 'landmark')} on the map, {len(marks)} in view; "
            f"the robot is sure to {sure:.2f} m",
            estimate=place_estimate(estimate, truth.odometry_start),
        )

    return look


STAGE = Stage(
    name="the growing map",
    lesson="07_ekf_slam",
    uses=("predict", "update_landmarks", "add_landmark"),
    wire=_grow,
    estimates=True,
)
