"""The drive: buttons and code alike, one motion after the other, and what stops it."""

import asyncio
import time

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import Motion
from nao_course.widgets import ControlPanel
from nao_course.widgets.control_panel import motion_runner
from nao_course.widgets.control_panel.cockpit import STEP
from nao_course.widgets.parts import PERIOD
from tests.widgets.robots import clean_nao, in_a_loop, press, until_it_stands


def go(panel, *presses):
    """Press buttons in a kernel's loop, which runs where a name is empty, and wait until the robot stands."""

    async def scenario():
        for name in presses:
            await asyncio.sleep(0) if not name else press(panel, name)
        await until_it_stands(panel)

    in_a_loop(scenario)


def test_buttons_and_code_drive_alike_and_a_drive_is_paced():
    by_code, by_button = (ControlPanel(SimulatedNao(rng=3)) for _ in range(2))
    began = time.perf_counter()
    go(by_button, "forward")
    assert time.perf_counter() - began >= 4 * PERIOD * 0.95
    by_code.forward()
    assert by_code.summary() == by_button.summary()
    assert np.array_equal(by_code.cockpit.pictures["top"].pixels, by_button.cockpit.pictures["top"].pixels)


def test_stop_stops_after_the_present_step_and_forgets_what_was_to_come_and_no_later_drive():
    panel = ControlPanel(clean_nao())
    go(panel, "forward", "left", "", "stop")
    assert panel.cockpit.nao.odometry.x == pytest.approx(STEP)
    assert panel.cockpit.nao.odometry.theta == 0
    assert panel.cockpit.message == "Stopped."
    go(panel, "stop", "forward")
    assert panel.cockpit.nao.odometry.x == pytest.approx(STEP + 0.2)


def test_during_a_drive_commands_wait_in_their_order_and_the_head_obeys_at_once():
    panel = ControlPanel(clean_nao())

    async def scenario():
        press(panel, "forward")
        await asyncio.sleep(0)
        for name in ("forward", "forward", "left", "look-up"):
            press(panel, name)
        assert np.degrees(panel.cockpit.nao.head[1]) == pytest.approx(-36)
        assert panel.cockpit.nao.odometry.theta == 0
        press(panel, "forward")
        shown = panel._controls.status.value
        assert "Then: Walk 0.20 m ahead (2 times); Turn 15° left; Walk 0.20 m ahead." in shown
        await until_it_stands(panel)

    in_a_loop(scenario)
    end = Pose(0.6, 0.0, np.radians(15)) @ Pose(0.2, 0.0, 0.0)
    assert panel.cockpit.nao.odometry.x == pytest.approx(end.x)
    assert panel.cockpit.nao.odometry.y == pytest.approx(end.y)
    assert "Then" not in panel._controls.status.value


def test_a_newer_panel_closes_the_older_and_leaves_no_task():
    nao = clean_nao()

    async def scenario():
        older = ControlPanel(nao)
        press(older, "forward")
        await asyncio.sleep(0)
        newer = ControlPanel(nao)
        await until_it_stands(older)
        assert asyncio.all_tasks() == {asyncio.current_task()}
        return older, newer

    older, newer = in_a_loop(scenario)
    moved = nao.odometry.x
    assert moved == pytest.approx(STEP)
    press(older, "forward")
    assert nao.odometry.x == moved
    assert older.closed and not newer.closed
    assert "newer panel" in older.cockpit.message
    with pytest.raises(ValueError, match="closed"):
        older.forward()


def test_a_panel_of_another_robot_stops_what_still_drives_but_closes_nothing():
    older = ControlPanel(clean_nao())

    async def scenario():
        press(older, "forward")
        await asyncio.sleep(0)
        ControlPanel(clean_nao())
        await until_it_stands(older)

    in_a_loop(scenario)
    assert older.cockpit.nao.odometry.x == pytest.approx(STEP) and not older.closed


def test_a_mistake_of_the_panel_itself_is_a_message_too(monkeypatch):
    panel = ControlPanel(clean_nao())
    monkeypatch.setattr(panel._own, "perceive", lambda picture: 1 / 0)
    press(panel, "forward")
    press(panel, "look-up")
    assert "ZeroDivisionError in the panel" in panel.cockpit.message
    panel.cockpit.say("")
    go(panel, "forward")
    assert "ZeroDivisionError in the panel" in panel.cockpit.message


def answer(panel):
    """Let a page say that it has shown the latest pictures."""
    for image in panel._controls.images.values():
        image._note(image, {"shown": image.asked}, [])


def test_a_drive_is_at_most_one_picture_ahead_of_a_page_that_has_answered_once():
    panel = ControlPanel(clean_nao())
    answer(panel)

    async def scenario():
        press(panel, "forward")
        while panel.cockpit.nao.odometry.x < 1.5 * STEP:
            await asyncio.sleep(PERIOD)
        await asyncio.sleep(6 * PERIOD)
        assert panel.cockpit.nao.odometry.x == pytest.approx(2 * STEP)
        while panel.driving:
            answer(panel)
            await asyncio.sleep(0.01)

    in_a_loop(scenario)
    assert panel.cockpit.nao.odometry.x == pytest.approx(4 * STEP)


def test_a_page_that_was_closed_holds_no_drive_up(monkeypatch):
    monkeypatch.setattr(motion_runner, "PATIENCE", 0.1)
    panel = ControlPanel(clean_nao())
    answer(panel)
    go(panel, "forward")
    assert panel.cockpit.nao.odometry.x == pytest.approx(4 * STEP)


def test_a_robot_stops_where_the_carpet_ends_and_turns_there_also_if_it_drives_by_itself(monkeypatch):
    nao = clean_nao(pose=Pose(3.0, 0.0, 0.0))
    panel = ControlPanel(nao, Truth(nao))
    edge = nao.field.pose.to_parent([nao.field.carpet[2], 0.0])[0][0]
    panel.forward(2.0)
    assert panel.cockpit.message == "Walk 2.00 m ahead: stopped, because the carpet ends here."
    stopped = panel.cockpit.odometry[-1]
    assert edge - 0.1 < Truth(nao).pose.x <= edge and stopped.x < edge + 0.1
    panel.forward()
    assert panel.cockpit.odometry[-1] == stopped and panel.cockpit.walked < 1.0
    panel.left(np.pi / 2)
    panel.left(np.pi / 2)
    panel.forward()
    assert panel.cockpit.message == "Walk 0.20 m ahead: done."
    panel = ControlPanel(clean_nao(pose=Pose(3.0, 0.0, 0.0)))
    panel._drive._waiting._next_motion = lambda: Motion(0.5)

    async def scenario():
        panel._drive.go_by_itself()
        await until_it_stands(panel)

    in_a_loop(scenario)
    assert "the carpet ends here" in panel.cockpit.message
