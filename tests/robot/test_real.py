"""A robot behind the real protocol: safe before all, and each fault has its own message."""

import threading
import time

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.robot import RealNao, RobotError, naoqi
from nao_course.robot import real as module
from nao_course.robot.emulated import SUBSCRIBERS
from nao_course.slam import Motion
from tests.robot.emulated import connected, emulated, free_port


def test_nothing_moves_before_it_is_awake_and_long_commands_are_refused_and_sent_in_parts():
    with connected(awake=False) as (robot, nao):
        for command in (nao.walk, nao.turn, nao.look):
            with pytest.raises(RobotError, match="the robot sleeps: call wake_up"):
                command(0.1)
        assert robot.nao.odometry == Pose() and robot.life == "solitary"
        nao.wake_up()
        assert robot.life == "disabled"
        for command, value in ((nao.walk, 2.1), (nao.turn, 7.0), (nao.walk, np.nan)):
            with pytest.raises(ValueError, match="must be"):
                command(value)
        sent = []
        own = robot.move
        robot.move = lambda motion: (sent.append(motion), own(motion))[1]
        nao.move(Motion(0.5, 1.2))
        assert [each.distance for each in sent] == [0.25, 0.25, 0.0, 0.0]
        assert [each.turn for each in sent] == [0.0, 0.0, 0.6, 0.6]
        nao.rest()
        with pytest.raises(RobotError, match="sleeps"):
            nao.turn(0.1)


def test_stop_ends_a_walk_that_is_running_and_the_motion_is_what_the_odometry_says():
    with connected(pace=1.0) as (robot, nao):
        done = []
        walking = threading.Thread(target=lambda: done.append(nao.walk(2.0)))
        walking.start()
        while not robot.nao.odometry.x:
            time.sleep(0.005)
        with pytest.raises(RobotError, match="already moves"):
            nao.turn(0.1)
        nao.stop()
        walking.join()
        assert 0 < done[0].distance < 2.0
        assert done[0].distance == pytest.approx(robot.nao.odometry.x)
        assert nao.odometry.x == pytest.approx(robot.nao.odometry.x)


def test_the_end_of_the_block_an_error_and_a_fall_stop_the_robot():
    with emulated() as (robot, address):
        stopped = []
        robot.stopped.set = lambda: stopped.append(1)
        with pytest.raises(ValueError, match="distance must be within"), RealNao(address, model="V4") as nao:
            nao.walk(3.0)
        assert stopped and not robot.subscribers
    with connected(pace=1.0) as (robot, nao):
        falling = threading.Timer(0.1, robot.fall)
        falling.start()
        with pytest.raises(RobotError, match="has fallen, and its motors are released"):
            nao.walk(2.0)  # of 17 s
        assert not robot.awake
        assert nao.odometry.x == pytest.approx(robot.nao.odometry.x)
        assert nao.warnings() == ("it has fallen: put it on its feet and call wake_up()",)
        nao.wake_up()
        robot.battery, robot.temperatures["HeadYaw"] = 0.1, 80.0
        assert [each.split(":")[0] for each in nao.warnings()] == [
            "its battery has 10 %",
            "HeadYaw has 80 °C",
        ]


def test_cameras_of_crashed_programs_are_given_back_and_two_programs_do_not_drive_at_once():
    with connected() as (robot, nao):
        robot.subscribers |= {
            f"nao_course_old_{number}_0": ("top", (320, 240)) for number in range(SUBSCRIBERS)
        }
        assert nao.take_picture().pixels.shape == (240, 320, 3)
        assert len(robot.subscribers) == 1
        robot.subscribers |= {f"somebody_{number}_0": ("top", (320, 240)) for number in range(SUBSCRIBERS)}
        with pytest.raises(RobotError, match="too many programs use it"):
            nao.take_picture("top")
        with pytest.raises(RobotError, match="size must be one of 160 x 120"):
            nao.take_picture("top", (300, 200))
        second = RealNao(nao._naoqi.address, model="V4")
        with pytest.raises(RobotError, match="another program drives this robot"):
            second.wake_up()
        second.close()


def test_where_no_robot_is_and_where_qi_is_missing_is_said(monkeypatch):
    pytest.importorskip("qi")
    with pytest.raises(RobotError, match="no robot answers at tcp://127.0.0.1"):
        RealNao(f"tcp://127.0.0.1:{free_port()}")
    for wrong in ("192.168.1.2", "tcp://robot", None):
        with pytest.raises(RobotError, match="address must be like"):
            RealNao(wrong)
    with pytest.raises(RobotError, match="model must be one of V4, V5, V6"):
        RealNao("tcp://127.0.0.1:1", model="V3")
    monkeypatch.setitem(__import__("sys").modules, "qi", None)
    with pytest.raises(RobotError, match='the package "qi" is missing'):
        RealNao("tcp://127.0.0.1:1")


def test_a_server_that_ends_in_mid_walk_is_named_and_the_same_robot_object_goes_on_with_its_successor():
    port = free_port()
    first = emulated(port=port)
    robot, _ = first.__enter__()
    nao = RealNao(f"tcp://127.0.0.1:{port}", model="V4")
    nao.wake_up()
    nao.walk(0.2)
    nao.take_picture()
    robot.pace = 1.0
    ending = threading.Timer(0.2, lambda: first.__exit__(None, None, None))
    ending.start()
    with pytest.raises(naoqi.ConnectionLostError):
        nao.walk(2.0)
    ending.join()
    with emulated(port=port) as (robot, _):
        nao.wake_up()
        before = nao.odometry.x
        assert nao.walk(0.1) == Motion(0.1, 0.0)
        assert robot.nao.odometry.x == pytest.approx(0.1)
        assert nao.odometry.x == pytest.approx(before + 0.1)
        assert nao.take_picture().pixels.shape == (240, 320, 3)
        nao.close()


def test_a_reply_that_never_comes_is_named_and_the_robot_is_stopped(monkeypatch):
    with connected(seconds=0.3) as (robot, nao):
        late = threading.Event()
        robot.move = lambda motion: late.wait(20)
        robot.look = lambda camera, size: late.wait(20)
        stopped = []
        robot.stopped.set = lambda: stopped.append(1)
        with pytest.raises(RobotError, match="getImageRemote did not answer in time"):
            nao.take_picture()
        monkeypatch.setattr(module, "SETTLING", -4.9)  # of a walk of 0.1 m, which has 5 s
        with pytest.raises(RobotError, match="the robot did not arrive within"):
            nao.walk(0.1)
        assert stopped
        late.set()


def test_what_happens_to_real_robots_can_be_practised():
    with connected() as (robot, nao):
        assert "write  fall" in robot.practise("") and "write  fall" in robot.practise("battery 101")
        assert robot.practise("battery 10") == "the battery has 10 %"
        assert robot.practise("heat HeadYaw") == "HeadYaw has 80 °C"
        assert robot.practise("fall") == "the robot lies on the ground"
        assert len(nao.warnings()) == 3
        with pytest.raises(RobotError, match="has fallen"):
            nao.walk(0.1)


def test_every_wrong_reply_is_refused(rng):
    class Connection:
        numbers = naoqi.Naoqi.numbers

    pixels = bytes(range(256)) * 900
    good = (320, 240, 3, 11, 1, 2, pixels, 0, 0.1, 0.1, 0.1, 0.1)
    assert naoqi.pixels_of(good, (320, 240))[0, 0].tolist() == [0, 1, 2]
    assert naoqi.pixels_of(list(good[:6]) + [bytearray(pixels)], (320, 240)).shape == (240, 320, 3)
    for place, values in {
        0: (319, None, "320", -1),
        2: (1, 4),
        3: (9, None),
        6: ("text", b"", pixels[1:], 3, None),
    }.items():
        for value in values:
            with pytest.raises(RobotError):
                naoqi.pixels_of((*good[:place], value, *good[place + 1 :]), (320, 240))
    for reply in (None, [], 3, "picture", good[:6], {}):
        with pytest.raises(RobotError):
            naoqi.pixels_of(reply, (320, 240))
    rigid = np.eye(4).ravel().tolist()
    assert naoqi.transform_of(rigid, Connection()).shape == (4, 4)
    junk = [
        None,
        "x",
        [],
        [1.0],
        rigid[:-1],
        [np.nan, *rigid[1:]],
        [2.0, *rigid[1:]],
        [[1.0] * 16],
        [{}] * 16,
    ]
    junk += [[-1.0, *rigid[1:]], ["1.0", "x", *rigid[2:]], [10**400, *rigid[1:]]]
    for reply in junk:
        with pytest.raises(RobotError):
            naoqi.transform_of(reply, Connection())


def test_the_parts_of_a_motion_add_up_to_it(rng):
    for _ in range(100):
        motion = Motion(rng.uniform(-2, 2), rng.uniform(-6, 6))
        parts = list(module._parts(motion))
        assert sum(each.distance for each in parts) == pytest.approx(motion.distance)
        assert sum(each.turn for each in parts) == pytest.approx(motion.turn)
        assert all(abs(each.distance) <= module.PART + 1e-9 for each in parts)
        assert all(abs(each.turn) <= module.TURN_PART + 1e-9 for each in parts)
