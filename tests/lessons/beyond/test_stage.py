"""The stage of lesson 12: the choice of the next move when the robot explores by itself."""

import numpy as np
import pytest

from nao_course.field_slam.drives import INSIDE
from nao_course.geometry import Pose
from nao_course.lessons.beyond.exploring import FREE, cell_centres
from nao_course.lessons.beyond.stage import MOST_SIGMA, PICTURES, STAGE, Explorer
from nao_course.sim import OdometryNoise, SensorNoise, Truth
from nao_course.sim.drives import NamedEkf
from nao_course.student.stages import PLANNED
from nao_course.widgets import ControlPanel
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel import Overlay, Pipeline, Stage
from tests.lessons.driven import functions_of, off, robot


@pytest.fixture
def functions():
    return functions_of(STAGE)


def live(nao, functions, *before):
    return Pipeline([*before, STAGE], functions, nao, time_limit=60.0)


class Drive:
    """A robot that goes where the stage says, a picture after each motion."""

    def __init__(self, functions, **noise):
        self.nao = robot(**noise)
        self.pipeline = live(self.nao, functions)
        self.look()

    def look(self):
        self.seen = self.pipeline.process(self.nao.take_picture())

    def go(self):
        self.nao.walk(self.seen.motion.distance)
        self.nao.turn(self.seen.motion.turn)
        self.look()

    @property
    def part(self):
        return float(self.seen.overlays[STAGE.name].text.partition("%")[0])

    @property
    def error(self):
        return off(self.nao, self.seen.estimate.pose.as_array())


def test_it_goes_where_nothing_was_seen_within_its_reach_and_without_noise_knows_its_place(functions):
    drive = Drive(functions)
    parts = [drive.part]
    for _ in range(12):
        drive.go()
        parts.append(drive.part)
        pose = Truth(drive.nao).pose
        assert INSIDE[0][0] - 0.3 < pose.x < INSIDE[1][0] + 0.3
        assert INSIDE[0][1] - 0.3 < pose.y < INSIDE[1][1] + 0.3
    assert parts == sorted(parts) and parts[0] < 40 and parts[-1] > parts[0] + 30
    explorer = Explorer(StudentCode(functions))
    explorer.see(np.array([0.5, 0.0, 0.0]), np.pi / 2, 0.0)  # it looks to its left
    away = cell_centres()[explorer.grid == FREE] - (0.5, 0.0)
    assert len(away) > 50 and away[:, 1].min() > -0.1 and np.hypot(*away.T).max() < 2.1
    assert np.abs(np.arctan2(away[:, 0], away[:, 1]))[np.hypot(*away.T) > 0.5].max() < np.radians(36)
    drive = Drive(functions, odometry_noise=OdometryNoise(0, 0, 0, 0), sensor_noise=SensorNoise(1e-9, 1e-9))
    for _ in range(4):
        drive.go()
    assert np.allclose(drive.error, 0, atol=1e-5)


@pytest.mark.slow
def test_it_sees_all_of_where_it_may_drive_and_then_stands_still(functions):
    nao = robot()
    panel = ControlPanel(nao, Truth(nao), pipeline=live(nao, functions))
    panel.explore(80)
    assert "100% seen" in panel.summary() and "everything is seen" in panel.summary()
    before = nao.odometry
    panel.explore(3)
    assert nao.odometry == before


def test_the_map_of_a_robot_that_maps_by_its_pictures_stays_that_map(functions):
    def mapped(student, nao):
        return lambda frame: Overlay(result="a map of lesson 11")

    nao = robot()
    eleven = Stage(PICTURES, "11_slam_on_the_field", (), mapped)
    seen = live(nao, functions, eleven).process(nao.take_picture())
    assert seen.estimate is None and seen.motion is not None
    assert "standard deviation" not in " ".join(seen.lines()), "that of another map would mislead"
    alone = live(nao, functions).process(nao.take_picture())
    assert "lesson 11" not in " ".join(alone.lines())  # then it is this lesson's own
    assert PLANNED["11"] == PICTURES


def test_choose_move_drives_a_while_when_the_pose_is_uncertain_and_else_the_nearest_frontier(functions, ekf):
    slam, explorer = NamedEkf(Pose(1.5, 0.0, 0.0), *ekf), Explorer(StudentCode(functions))
    explorer.see(slam.state, 0.0, 0.0)
    for sigma, why in (
        (0, "the nearest frontier"),
        (MOST_SIGMA, "localise better"),
        (MOST_SIGMA / 3, "the nearest frontier"),
    ):
        slam.covariance = np.eye(3) * sigma**2
        move = explorer.next(slam.state, slam.covariance)
        assert explorer.why == f"to {why}"
        assert move.distance == pytest.approx(0.3) or sigma != MOST_SIGMA
    slam.covariance = np.eye(3) * MOST_SIGMA**2
    explorer, reasons = Explorer(StudentCode(functions)), []
    for _ in range(9):
        explorer.see(slam.state, 0.0, 0.3)
        explorer.next(slam.state, slam.covariance)
        reasons.append(explorer.why)
    returning, exploring = ["to localise better"] * 3, ["to the nearest frontier"] * 3
    assert reasons == returning + exploring + returning


def test_what_fails_is_said_and_no_command_is_taken_in_twice(functions):
    broken = []

    def update_landmarks(*given):
        if broken:
            raise ZeroDivisionError("no")
        return functions["update_landmarks"](*given)

    drive = Drive(functions | {"update_landmarks": update_landmarks})
    broken.append("now")
    drive.nao.walk(0.2)
    drive.look()
    assert "ZeroDivisionError in update_landmarks()" in drive.seen.complaints[0]
    assert drive.seen.motion is None
    broken.clear()
    drive.look()
    assert drive.seen.motion is not None and np.hypot(*drive.error[:2]) < 0.05
