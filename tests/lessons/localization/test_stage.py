"""What lesson 06 adds to the robot: the student's estimate on the map, from pictures of known landmarks."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.localization.stage import STAGE, START_COVARIANCE, START_ERROR
from nao_course.sim import SimulatedNao, Truth
from nao_course.widgets import ControlPanel
from nao_course.widgets.control_panel import Pipeline


@pytest.fixture
def functions(filter_of):
    return dict(zip(("localize", "predict_pose", "predict_covariance"), filter_of, strict=True))


def robot(pose=Pose(0.6, 0.5, -0.25)):
    return SimulatedNao(pose=pose, rng=41)


def off(nao, seen):
    pose = seen.overlays[STAGE.name].estimate.pose.as_array()
    return float(np.hypot(*(pose - Truth(nao).pose.as_array())[:2]))


def test_the_first_picture_shows_the_estimate_at_the_start_and_the_second_corrects_it(functions):
    nao = robot()
    pipeline = Pipeline([STAGE], functions, nao, time_limit=60.0)
    first = pipeline.process(nao.take_picture())
    assert np.hypot(*START_ERROR[:2]) == pytest.approx(0.5) and np.degrees(START_ERROR[2]) == pytest.approx(
        12
    )
    assert off(nao, first) == pytest.approx(0.5)
    assert np.array_equal(first.overlays[STAGE.name].estimate.covariance, START_COVARIANCE)
    assert "start" in first.lines()[0]
    second = pipeline.process(nao.take_picture())
    assert off(nao, second) < 0.2 and len(second.overlays[STAGE.name].pixels) == 3
    assert second.lines()[0].startswith(f"{STAGE.name}: 3 landmarks, σ 0.1")


def test_it_follows_a_drive_command_by_command(functions):
    nao = robot()
    pipeline = Pipeline([STAGE], functions, nao, time_limit=60.0)
    pipeline.process(nao.take_picture())
    for _ in range(4):
        nao.walk(0.2)
        nao.turn(0.1)
        seen = pipeline.process(nao.take_picture())
    assert off(nao, seen) < 0.1
    pose, covariance = seen.overlays[STAGE.name].result
    error = pose - Truth(nao).pose.as_array()
    assert error @ np.linalg.inv(covariance) @ error < 16.3  # 99.9 %


def test_without_landmarks_the_covariance_only_grows(functions):
    nao = robot(Pose(0.3, 0.0, np.pi))
    pipeline = Pipeline([STAGE], functions, nao, time_limit=60.0)
    pipeline.process(nao.take_picture())
    first = pipeline.process(nao.take_picture()).overlays[STAGE.name]
    nao.walk(0.5)
    second = pipeline.process(nao.take_picture()).overlays[STAGE.name]
    assert first.text.startswith("0 landmarks")
    assert np.linalg.det(second.result[1]) > np.linalg.det(first.result[1])


def test_the_panel_has_a_place_for_the_estimate_on_its_map(functions):
    nao = robot()
    panel = ControlPanel(nao, Truth(nao), pipeline=Pipeline([STAGE], functions, nao, time_limit=60.0))
    contents = panel._screen.contents()
    assert contents.observer == "ekf" and contents.paths["ekf"] == (contents.estimate.pose,)
    assert np.hypot(contents.estimate.pose.x - 0.6, contents.estimate.pose.y - 0.5) == pytest.approx(0.5)
    panel.view = "beside"  # as my_nao does
    assert panel._screen.contents().estimate.pose == contents.estimate.pose
    assert panel.drawing().alt.startswith("Control panel")
