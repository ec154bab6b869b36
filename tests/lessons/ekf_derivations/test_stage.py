"""What lesson 05 adds to the robot: dead reckoning, whose ellipse grows with every command and holds the robot."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.ekf_derivations.stage import STAGE
from nao_course.sim import SimulatedNao, Truth
from nao_course.widgets.control_panel import Pipeline

NAMES = ("predict_pose", "predict_covariance")


@pytest.fixture
def nao():
    return SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=41)


def looked(nao, functions):
    return Pipeline([STAGE], functions, nao, time_limit=60.0)


def test_the_ellipse_starts_at_zero_grows_and_holds_the_robot(solution, nao):
    pipeline = looked(nao, {name: solution[name] for name in NAMES})
    first = pipeline.process(nao.take_picture()).overlays[STAGE.name]
    assert first.text == "standard deviation 0.00 m and 0°"
    sizes = [0.0]
    for _ in range(5):
        nao.walk(0.2)
        nao.turn(0.4)
        overlay = pipeline.process(nao.take_picture()).overlays[STAGE.name]
        pose, covariance = overlay.result
        sizes.append(float(np.trace(covariance[:2, :2])))
    assert np.all(np.diff(sizes) > 0)
    error = (pose - Truth(nao).pose.as_array())[:2]
    assert error @ np.linalg.inv(covariance[:2, :2]) @ error < 13.8  # 99.9 %
    assert overlay.estimate.pose.as_array() == pytest.approx(pose)


def test_an_answer_of_another_shape_is_reported_and_tried_again(solution, nao):
    functions = {name: solution[name] for name in NAMES}
    pipeline = looked(nao, functions | {"predict_pose": lambda pose, control: pose[:2]})
    nao.walk(0.2)
    seen = pipeline.process(nao.take_picture())
    assert STAGE.name not in seen.overlays
    assert "shape (2,)" in seen.complaints[0] and "(3,)" in seen.complaints[0]
