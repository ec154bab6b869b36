"""What lesson 07 adds to the robot: a map that grows from zeros, by the student's filter."""

import numpy as np

from nao_course.lessons.ekf_slam.stage import STAGE
from nao_course.sim import OdometryNoise, SensorNoise
from tests.lessons.driven import off, pipeline, robot


def drive(nao, steps=8):
    live = pipeline(STAGE.name, nao)
    seen = [live.process(nao.take_picture())]
    for _ in range(steps):
        nao.walk(0.2)
        nao.turn(0.3)
        seen.append(live.process(nao.take_picture()))
    return [each.overlays[STAGE.name] for each in seen]


def test_later_pictures_add_only_what_is_new_to_a_map_that_lies_in_the_world_within_its_ellipses():
    sizes = [len(each.estimate.landmarks) for each in drive(robot())]
    assert sizes[0] >= 2 and sizes == sorted(sizes) and sizes[0] < sizes[-1] <= 10
    nao = robot()
    last = drive(nao)[-1].estimate
    true = nao.field.detectable_positions
    for place, own in zip(last.landmarks, last.landmark_covariances, strict=True):
        away = true - place
        nearest = away[np.hypot(*away.T).argmin()]
        assert nearest @ np.linalg.solve(own, nearest) < 18.4  # 99.99 %


def test_without_noise_pose_and_map_are_exact():
    noiseless = {"odometry_noise": OdometryNoise(0, 0, 0, 0), "sensor_noise": SensorNoise(1e-9, 1e-9)}
    nao = robot(**noiseless)
    last = drive(nao)[-1]
    assert np.abs(off(nao, last.estimate.pose.as_array())[:2]).max() < 1e-6
    true = nao.field.detectable_positions
    away = np.linalg.norm(last.estimate.landmarks[:, None] - true, axis=2)
    assert away.min(axis=1).max() < 1e-6 and len(set(away.argmin(axis=1))) == len(away)
