"""What lesson 07 adds to the robot: a map that grows from zeros, by the student's filter."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.ekf_slam.stage import STAGE
from nao_course.sim import OdometryNoise, SensorNoise, SimulatedNao, Truth
from nao_course.widgets.control_panel import Pipeline


@pytest.fixture
def functions(own):
    return {name: own[name] for name in ("predict", "update_landmarks", "add_landmark")}


def robot(**more):
    return SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=41, **more)


def drive(nao, functions, steps=8):
    pipeline = Pipeline([STAGE], functions, nao, time_limit=60.0)
    seen = [pipeline.process(nao.take_picture())]
    for _ in range(steps):
        nao.walk(0.2)
        nao.turn(0.3)
        seen.append(pipeline.process(nao.take_picture()))
    return [each.overlays[STAGE.name] for each in seen]


def off(nao, overlay):
    return float(np.hypot(*(overlay.estimate.pose.as_array() - Truth(nao).pose.as_array())[:2]))


def test_the_first_picture_puts_what_it_shows_on_the_map_and_later_ones_add_only_what_is_new(functions):
    sizes = [len(each.estimate.landmarks) for each in drive(robot(), functions)]
    assert sizes[0] >= 2 and sizes == sorted(sizes) and sizes[0] < sizes[-1] <= 10


def test_the_map_lies_in_the_world_and_each_landmark_within_its_ellipse(functions):
    nao = robot()
    last = drive(nao, functions)[-1].estimate
    true = nao.field.pose.to_parent([(m.x, m.y) for m in nao.field.landmarks if m.kind != "cross"])
    for place, own in zip(last.landmarks, last.landmark_covariances, strict=True):
        away = true - place
        nearest = away[np.hypot(*away.T).argmin()]
        assert nearest @ np.linalg.solve(own, nearest) < 18.4  # 99.99 %


def test_without_noise_pose_and_map_are_exact(functions):
    noiseless = {"odometry_noise": OdometryNoise(0, 0, 0, 0), "sensor_noise": SensorNoise(1e-9, 1e-9)}
    nao = robot(**noiseless)
    last = drive(nao, functions)[-1]
    assert off(nao, last) < 1e-6
    true = nao.field.pose.to_parent([(m.x, m.y) for m in nao.field.landmarks if m.kind != "cross"])
    away = np.linalg.norm(last.estimate.landmarks[:, None] - true, axis=2)
    assert away.min(axis=1).max() < 1e-6 and len(set(away.argmin(axis=1))) == len(away)
