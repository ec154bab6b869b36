"""What stages get that are given the landmarks' numbers: the new commands, and measurements by the simulator."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import SensorNoise, SimulatedNao, Truth, visible_landmarks
from nao_course.slam import Motion, range_and_bearing
from nao_course.widgets.control_panel import named_landmarks


@pytest.fixture
def nao():
    return SimulatedNao(pose=Pose(0.5, 0.3, -0.1), rng=3, sensor_noise=SensorNoise(0.0, 0.0))


def test_commands_are_those_that_were_not_done_yet(nao):
    told = [Motion(0.3, 0.2), Motion(-0.1, 0.0), Motion(0.0, -0.5)]
    for motion in told:
        nao.move(motion)
    for done in range(4):
        found, wanted = (
            np.array([each.as_pose().as_array() for each in motions]).reshape(-1, 3)
            for motions in (named_landmarks.new_motions(nao, done), told[done:])
        )
        assert np.allclose(found, wanted)
    for (control, covariance), motion in zip(named_landmarks.new_commands(nao, 1), told[1:], strict=True):
        assert np.allclose(control, (motion.distance, motion.turn))
        assert np.allclose(covariance, nao.odometry_noise.covariance(motion))


def test_landmarks_in_view_and_reach_are_measured_by_number_and_hidden_ones_are_not(nao, rng, monkeypatch):
    nao.look(0.0, 0.0)
    pose, view = Truth(nao).pose, nao.view("top")
    marks = visible_landmarks(nao.field, pose, view)
    far = named_landmarks.measure_by_name(nao, view, 9.0, rng)
    assert len(far.numbers) >= 3 and np.allclose(
        far.measurements, range_and_bearing(pose.as_array(), nao.field.detectable_positions[far.numbers])
    )
    wanted = [each for each in marks if each.landmark.detected_as and not each.occluded]
    assert far.pixels == [each.pixel for each in wanted]
    reach = float(np.median(far.measurements[:, 1]))
    near = named_landmarks.measure_by_name(nao, view, reach, rng)
    assert 0 < len(near.numbers) < len(far.numbers) and near.measurements[:, 1].max() <= reach
    nao.sensor_noise = SensorNoise(0.1, 0.2)
    noisy = named_landmarks.measure_by_name(nao, view, 9.0, np.random.default_rng(1))
    draws = np.random.default_rng(1).standard_normal(far.measurements.shape)
    assert np.allclose(noisy.measurements, nao.sensor_noise.disturbed(far.measurements, draws))
    assert np.allclose(noisy.covariances, nao.sensor_noise.covariances(noisy.measurements))

    def first_hidden(*given):
        first, *others = visible_landmarks(*given)
        return [replace(first, occluded=True), *others]

    nao.sensor_noise = SensorNoise(0.0, 0.0)
    everything = named_landmarks.measure_by_name(nao, nao.view("top"), 9.0, rng)
    monkeypatch.setattr(named_landmarks, "visible_landmarks", first_hidden)
    assert named_landmarks.measure_by_name(nao, nao.view("top"), 9.0, rng).numbers == everything.numbers[1:]


class Recorder:
    """A filter that only notes what it gets, and fails while `broken`."""

    broken = False

    def __init__(self, got=()):
        self.got = list(got)

    def copy(self):
        return Recorder(self.got)

    def move(self, control, covariance):
        self.got.append(float(control[0]))

    def observe(self, numbers, measurements, covariances):
        if Recorder.broken:
            raise ValueError("a student's error")
        self.got.append(len(numbers))


def test_a_filter_follows_each_command_once_and_stays_as_it_is_if_an_update_fails(nao, monkeypatch):
    robot, view = named_landmarks.FollowedRobot(Recorder(), nao, 9.0, 1), nao.view("top")
    seen, walked = robot.follow(view)
    count = len(seen.numbers)
    assert (robot.slam.got, walked) == ([count], 0.0)
    nao.move(Motion(0.3, 0.2))
    monkeypatch.setattr(Recorder, "broken", True)
    with pytest.raises(ValueError, match="a student's error"):
        robot.follow(view)
    assert robot.slam.got == [count]
    monkeypatch.setattr(Recorder, "broken", False)
    nao.move(Motion(-0.1, 0.0))
    assert robot.follow(view)[1] == pytest.approx(0.4)
    assert robot.slam.got == pytest.approx([count, 0.3, -0.1, count])
    assert robot.follow(view)[1] == 0.0
