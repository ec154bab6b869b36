"""What lesson 08 adds to the robot: a map of the drive, by two linear graphs."""

import numpy as np
import pytest

from nao_course.exercises import load_definitions
from nao_course.geometry import Pose
from nao_course.lessons.graph_slam.stage import STAGE
from nao_course.sim import OdometryNoise, SensorNoise, SimulatedNao, TorsoTilt, Truth
from nao_course.widgets.control_panel import Pipeline
from tests.paths import PROJECT

OWN = load_definitions(PROJECT / "solutions" / "08_graph_slam.ipynb")
PERFECT = {
    "odometry_noise": OdometryNoise(0, 0, 0, 0),
    "sensor_noise": SensorNoise(0, 0),
    "tilt": TorsoTilt(0, 0),
}


def drive(functions=OWN, steps=6, **robot):
    """Walk and turn a little, and process a picture after each step; return the robot and the last result."""
    nao = SimulatedNao(pose=Pose(0.4, 0.3, -0.2), rng=41, **robot)
    pipeline = Pipeline([STAGE], functions, nao, time_limit=60.0)
    picture = nao.take_picture("bottom")
    seen = pipeline.process(picture)
    for _ in range(steps):
        nao.walk(0.25)
        nao.turn(0.1)
        seen = pipeline.process(picture)
    return nao, seen


def test_without_errors_the_map_has_each_landmark_in_its_place_once():
    nao, seen = drive(**PERFECT)
    found = seen.overlays[STAGE.name]
    placed = found.estimate.landmarks
    true = np.array([(each.x, each.y) for each in nao.field.landmarks if each.kind != "cross"])
    nearest = np.linalg.norm(placed[:, None] - true, axis=2)
    assert nearest.min(axis=1).max() < 1e-6
    assert len(set(nearest.argmin(axis=1))) == len(placed) >= 6
    assert found.text.startswith(f"{len(placed)} landmarks from 7 poses, ")


def test_a_frame_from_the_same_place_adds_nothing():
    nao, _ = drive(steps=0)
    again = Pipeline([STAGE], OWN, nao, time_limit=60.0)
    texts = {again.process(nao.take_picture("bottom")).overlays[STAGE.name].text for _ in range(3)}
    assert len(texts) == 1 and "from 1 pose, " in texts.pop()


def test_measuring_does_not_change_how_the_robot_slips():
    blind = SimulatedNao(pose=Pose(0.4, 0.3, -0.2), rng=41)
    blind.take_picture("bottom")
    for _ in range(6):
        blind.walk(0.25)
        blind.turn(0.1)
    assert Truth(drive()[0]).pose == Truth(blind).pose


def test_a_metre_ahead_makes_a_map_and_two_turns_on_the_spot_a_second_one_as_the_lesson_says():
    nao = SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=41)
    true = np.array([(each.x, each.y) for each in nao.field.landmarks if each.kind != "cross"])
    pipeline, picture = Pipeline([STAGE], OWN, nao, time_limit=60.0), nao.take_picture("bottom")
    pipeline.process(picture)
    for _ in range(5):
        nao.walk(0.2)
        found = pipeline.process(picture).estimate.landmarks
    away = np.linalg.norm(found[:, None] - true, axis=2).min(axis=1)
    assert len(found) in (5, 6) and away.max() < 0.2
    for _ in range(16):
        nao.turn(np.radians(-45))
        seen = pipeline.process(picture)
    assert len(seen.estimate.landmarks) >= 15, "the half field has ten landmarks"


def test_the_map_stands_in_the_frame_of_the_start_and_a_landmark_is_within_its_ellipse():
    nao, seen = drive()
    true = np.array([(each.x, each.y) for each in nao.field.landmarks if each.kind != "cross"])
    found = seen.estimate
    away = np.linalg.norm(found.landmarks[:, None] - true, axis=2).min(axis=1)
    spread = np.sqrt(found.landmark_covariances[:, 0, 0])
    assert away.max() < 0.3 and (away < 4 * spread + 0.05).mean() > 0.7
    assert (spread < 0.3).all(), "what nobody knows of the start is not the map's"
    assert not seen.overlays[STAGE.name].points.size, "stars are of other lessons"


@pytest.mark.parametrize("name", STAGE.uses)
def test_a_function_that_failed_leaves_nothing_behind_and_is_tried_again(name):
    def fails_once(*arguments):
        if not failed:
            failed.append(name)
            raise RuntimeError("not yet")
        return OWN[name](*arguments)

    failed = []
    _, seen = drive({**OWN, name: fails_once}, **PERFECT)
    assert failed == [name] and seen.complaints == ()
    true = np.array([(each.x, each.y) for each in SimulatedNao().field.landmarks])
    placed = seen.overlays[STAGE.name].estimate.landmarks
    assert np.linalg.norm(placed[:, None] - true, axis=2).min(axis=1).max() < 1e-6


def test_nonsense_is_said_in_words():
    for wrong in (lambda omega, xi: None, lambda omega, xi: np.zeros((2, 2)), lambda omega, xi: "x"):
        _, seen = drive({**OWN, "solve": wrong}, steps=0)
        (said,) = seen.complaints
        assert said.startswith(f"Without {STAGE.name}: ")
