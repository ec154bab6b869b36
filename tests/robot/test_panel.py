"""The control panel and my_nao with a real robot, emulated behind the real protocol, and with a recorded one."""

import asyncio
import re

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.robot import RecordedNao, RobotError, write_offsets
from nao_course.student import my_nao
from nao_course.widgets import ControlPanel
from tests.robot.emulated import connected
from tests.widgets.robots import in_a_loop, press, until_it_stands


def said(panel):
    return re.sub("<[^>]+>", " ", panel._controls.numbers.value)


def go(panel, *presses):
    async def scenario():
        for name in presses:
            press(panel, name)
        await until_it_stands(panel)

    in_a_loop(scenario)


def test_a_real_robot_has_no_truth_and_is_compared_with_what_a_person_measures_until_it_moves():
    start = Pose(1.0, 0.5, 0.3)
    with connected(start=start) as (_, nao):
        panel = ControlPanel(nao)
        assert panel.cockpit.odometry[-1] == start
        assert "How far off?  –" in said(panel) and "measure it: panel.measured_pose" in said(panel)
        panel.measured_pose = start @ Pose(0.03, 0.0, 0.0)
        assert "How far off?  3 cm" in said(panel)
        panel.forward(0.05)
        assert panel.measured_pose is None and "How far off?  –" in said(panel)
        panel.measured_pose = start
        nao.walk(0.05)  # past the panel
        assert panel.measured_pose is None
        with pytest.raises(ValueError, match="must be a Pose"):
            panel.measured_pose = (1.0, 0.5)
        assert panel.run_slam() == () and "make the panel with a function measure" in panel.cockpit.message


def test_stop_ends_a_real_robots_step_at_once_and_its_buttons_answer_while_it_walks():
    with connected(pace=0.02) as (_, nao):  # a step of 5 cm takes 20 s
        panel = ControlPanel(nao)

        async def scenario():
            press(panel, "forward")
            await asyncio.sleep(0.1)
            press(panel, "look-left")  # it is answered in the middle of the step
            assert panel.driving and np.degrees(nao.head[0]) > 8
            press(panel, "stop")
            press(panel, "left")
            await until_it_stands(panel)

        in_a_loop(scenario)
        assert panel.cockpit.message == "Stopped." and nao.odometry.x < 0.05
        assert not panel._drive.waiting_text(), "nothing is run later that was pressed before it stood"


def test_a_fall_and_a_lost_robot_become_messages_that_say_what_to_do():
    with connected() as (robot, nao):
        robot.battery = 0.1
        panel = ControlPanel(nao)
        assert panel.cockpit.message == "Ready. Its battery has 10 %: charge it before the next drive."
        robot.fall()
        go(panel, "forward", "left", "forward")
        assert panel.cockpit.alarm and panel.cockpit.message.startswith("The robot has fallen")
        assert not panel.driving
        nao.wake_up()
        before = nao.odometry
        go(panel, "forward")
        assert panel.cockpit.message == "Walk 0.20 m ahead: done."
        moved = before.inverse() @ nao.odometry
        assert np.allclose(moved.as_array(), (0.2, 0.0, 0.0), atol=1e-6), (
            "commands before the fall are forgotten"
        )


def test_the_record_button_keeps_the_drive_and_a_panel_plays_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with connected() as (_, nao):
        panel = ControlPanel(nao)
        panel.forward(0.1)
        press(panel, "record")
        assert panel.cockpit.message.startswith("Recording into")
        panel.forward(0.1)
        panel.turn_head(0.2)
        press(panel, "record")
        path, picture = nao.odometry_path, panel.cockpit.pictures["bottom"]
    (folder,) = (tmp_path / "recordings").iterdir()
    assert f'RecordedNao("recordings/{folder.name}") plays it' in panel.cockpit.message
    again = ControlPanel(RecordedNao(folder))
    assert again.cockpit.pictures["top"].pixels.any()
    events = folder / "events.jsonl"
    lines = events.read_text().splitlines(keepends=True)
    events.write_text("".join(line for line in lines if '"top"' not in line))
    assert not ControlPanel(RecordedNao(folder)).cockpit.pictures["top"].pixels.any()
    events.write_text("".join(lines))
    again.forward(0.1)
    moved = path[2].inverse() @ path[-1]
    assert np.allclose(again.cockpit.nao.odometry.as_array(), moved.as_array(), atol=1e-9)
    again.turn_head(0.2)
    assert np.array_equal(again.cockpit.pictures["bottom"].pixels, picture.pixels)
    go(again, "forward")
    assert again.cockpit.message == f"The recording {folder.name} ends here."


def test_my_nao_leaves_out_on_a_real_robot_only_what_the_simulator_measures():
    with connected() as (_, nao):
        panel = my_nao(nao, upto="00")
        assert not panel._own.drives
        stages = my_nao(nao)._own._pipeline
        simulated = {name for name, why in stages.missing.items() if "only the simulator measures" in why}
        assert simulated == {"pose", "growing map", "map after the drive"}


def test_a_panel_says_that_its_robot_is_lost_and_a_closed_robot_refuses_everything():
    with connected() as (_, nao):
        panel = ControlPanel(nao)
        nao.close()
        go(panel, "forward")
        assert panel.cockpit.message == "This robot is closed: connect to it again with RealNao(...)."
        assert "this robot is closed" in panel.summary().lower()
        panel.close()
        for command in (nao.wake_up, nao.take_picture, nao.stop):
            with pytest.raises(RobotError, match="is closed"):
                command()


def test_a_robot_that_was_switched_off_keeps_its_pose_until_it_wakes_up_again():
    with connected() as (robot, nao):
        nao.walk(0.5)
        here = nao.odometry
        robot.awake = False
        with pytest.raises(RobotError, match="sleeps: call wake_up"):
            nao.walk(0.1)
        assert nao.odometry == here
        nao.wake_up()
        nao.walk(0.1)
        assert nao.odometry.x == pytest.approx(0.6, abs=1e-6)


def test_a_recording_has_views_without_the_offset_and_a_folder_that_is_taken_keeps_the_old_one(tmp_path):
    path = write_offsets(tmp_path / "robot.toml", {"bottom": (0.2, 0.0)})
    with connected(cameras=path, record=tmp_path / "drive") as (_, nao):
        view = nao.take_picture("bottom").view
        with pytest.raises(RobotError, match="is not empty"):
            nao.record(tmp_path / "drive")
        nao.walk(0.1)
    recorded = RecordedNao(tmp_path / "drive").take_picture("bottom").view
    assert view.pitch - recorded.pitch == pytest.approx(0.2)
