"""Simulated drives past known landmarks: what is in view, how it errs, and where the robot goes."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import SensorNoise
from nao_course.sim.drives import Drive, FieldOfView, Sigmas, Step, measure_in_view, true_path
from nao_course.slam import Measurement, Motion, range_and_bearing

VIEW = FieldOfView(np.radians(60), 3.0, nearest=0.5)
LANDMARKS = np.array([(1.0, 0.0), (0.2, 0.0), (3.5, 0.0), (0.0, 1.0), (2.0, 1.0)])
NONE = Sigmas(0.0, 0.0, 0.0, 0.0, 0.0)


def test_landmarks_out_of_view_are_not_measured_and_bearings_are_wrapped_with_covariances_of_their_own(rng):
    numbers, seen = measure_in_view(np.zeros(3), LANDMARKS, NONE, VIEW, rng)
    assert numbers.tolist() == [0, 4]
    assert np.allclose(seen, range_and_bearing(np.zeros(3), LANDMARKS[numbers]))
    assert VIEW.sees(np.zeros((2, 1, 3)), LANDMARKS).tolist() == 2 * [[True, False, False, False, True]]
    behind, draws = np.array([[np.pi - 0.01, 1.0]]), np.array([[1.0, 0.0]])
    for noise in (Sigmas(bearing=0.02), SensorNoise(0.02)):
        assert noise.disturbed(behind, draws)[0, 0] == pytest.approx(-np.pi + 0.01)
    seen, sensor = np.array([(0.1, 1.0), (-0.3, 2.0)]), SensorNoise()
    assert np.allclose(sensor.covariances(seen), [sensor.covariance(Measurement(*row)) for row in seen])
    assert Sigmas().covariances(seen).tolist() == 2 * [Sigmas().measurement_covariance.tolist()]
    for noise in (sensor, Sigmas()):
        assert noise.covariances(np.zeros((0, 2))).shape == (0, 2, 2)
    assert Sigmas().scaled("turn", 2) == Sigmas(turn=0.2)
    assert Sigmas(1, 2, 3, 4, 5).times(2) == Sigmas(2, 4, 6, 8, 10)


@pytest.mark.parametrize("draw_unseen", [False, True])
def test_errors_are_the_draws_times_the_deviations(draw_unseen):
    draws = np.random.default_rng(4).standard_normal((5 if draw_unseen else 2, 2))
    drawn = draws[[0, 4]] if draw_unseen else draws
    exact = range_and_bearing(np.zeros(3), LANDMARKS[[0, 4]])
    sigmas, sensor = Sigmas(bearing=0.02, range=0.1), SensorNoise(0.02, 0.1)
    for noise, deviations in (
        (sigmas, (0.02, 0.1)),
        (sensor, np.column_stack([[0.02] * 2, 0.1 * exact[:, 1]])),
    ):
        rng = np.random.default_rng(4)
        _, seen = measure_in_view(np.zeros(3), LANDMARKS, noise, VIEW, rng, draw_unseen)
        assert np.allclose(seen - exact, drawn * deviations)


def test_without_noise_the_true_path_is_as_commanded_and_a_drive_begins_at_its_start_without_a_command():
    motions = [Motion(1.0, 0.5), Motion(0.5, -0.2)]
    there = Pose(1.0, 0.0, 0.5) @ Pose(0.5, 0.0, -0.2)
    assert np.allclose(true_path(motions, NONE, np.random.default_rng(0))[-1].as_array(), there.as_array())
    sigmas = Sigmas(0.1, 0.05, 0.02)
    rng = np.random.default_rng(1)
    ends = np.array([true_path(motions[:1], sigmas, rng)[1].as_array() for _ in range(2000)])
    assert np.allclose(ends.std(axis=0), (0.1, 0.05, 0.02), rtol=0.1)
    start = Step.at_start(np.array([1.0, 2.0, 0.3]))
    step = Step(np.ones(3), Motion(0.2, 0.1), np.eye(3), start.numbers, start.measurements, start.covariances)
    drive = Drive(LANDMARKS, (start, step))
    assert drive.poses.tolist() == [[1.0, 2.0, 0.3], [1.0, 1.0, 1.0]]
    assert drive.controls.tolist() == [[0.2, 0.1]] and start.control.tolist() == [0.0, 0.0]
    assert Drive(LANDMARKS, (start,)).controls.shape == (0, 2)
