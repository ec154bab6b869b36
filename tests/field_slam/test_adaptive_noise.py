"""Odometry noise that is estimated during the drive, alone and in the joint update."""

import numpy as np
import pytest

from nao_course.field_slam.adaptive_noise import AdaptiveOdometryNoise
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.field_slam.joint_update import JointUpdate
from nao_course.field_slam.observation import Observation
from nao_course.geometry import Pose
from nao_course.slam import Motion

TURN, KNOWN = Motion(0.2, 0.5), np.radians(1.0) ** 2
# The robot has turned 23 degrees more than TURN.
MORE = Observation((), np.zeros((0, 0)), direction=-0.5 - 0.4, direction_sigma=0.01)


@pytest.mark.parametrize(("factor", "wrong"), [(1.0, []), (2.0, []), (3.0, []), (1.0, [0.6, -0.7])])
def test_the_factor_of_the_odometrys_noise_is_estimated_also_if_a_few_readings_are_wrong(factor, wrong):
    noise, rng = AdaptiveOdometryNoise(OdometryNoisePerMove()), np.random.default_rng(4)
    sigma = np.sqrt(factor**2 * OdometryNoisePerMove().covariance(TURN)[2, 2] + KNOWN)
    for error in [*rng.normal(0, sigma, 60), *wrong]:
        noise.learn(error, KNOWN, TURN)
    assert noise.factor == pytest.approx(factor, rel=0.2)


def test_an_error_that_the_known_variance_explains_says_nothing_and_the_factor_scales_all():
    noise = AdaptiveOdometryNoise(OdometryNoisePerMove())
    before = noise.factor
    for _ in range(10):
        noise.learn(0.3, 1e4, TURN)
    assert noise.factor == pytest.approx(before, rel=1e-3)
    noise = AdaptiveOdometryNoise(OdometryNoisePerMove(), (2.0,))
    assert np.allclose(noise.covariance(TURN), OdometryNoisePerMove(factor=2.0).covariance(TURN))


def test_a_motion_is_predicted_once_with_the_noise_that_its_compass_reading_shows_unless_it_is_stated(ekf):
    joint, alone = JointUpdate(ekf(Pose(0, 0, 0))), ekf(Pose(0, 0, 0))
    before = joint.odometry.factor
    joint.move(TURN)
    joint.observe(MORE)
    assert joint.odometry.factor > before
    alone.odometry = joint.odometry
    alone.move(TURN)
    alone.use_compass(MORE.direction, MORE.direction_sigma)
    assert np.allclose(joint.inner.state, alone.state)
    assert np.allclose(joint.inner.covariance, alone.covariance)
    after = joint.odometry.factor
    joint.observe(MORE)  # of the same stop: it measures the same error of the motion
    assert joint.odometry.factor == after
    joint, alone = JointUpdate(ekf(Pose(0, 0, 0)), (1.0,)), ekf(Pose(0, 0, 0))
    for each in (joint, alone):
        for _ in range(3):
            each.move(TURN)
            each.observe(MORE)
    assert np.array_equal(joint.inner.state, alone.state)
    assert np.array_equal(joint.inner.covariance, alone.covariance)
