"""An emulated robot for tests, behind the real protocol on the loopback address."""

import socket
from contextlib import contextmanager

import pytest

from nao_course.robot import RealNao
from nao_course.robot.emulated import EmulatedNao, served
from nao_course.sim import SimulatedNao

PACE = 50.0  # times a real robot's speed


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


@contextmanager
def emulated(pace=PACE, port=None):
    """Serve an emulated robot, and yield it and its address."""
    pytest.importorskip("qi", reason="the package qi is for Linux and Python 3.11 and 3.12")
    robot = EmulatedNao(SimulatedNao(rng=1), pace)
    with served(robot, port or free_port()) as address:
        yield robot, address


@contextmanager
def connected(pace=PACE, awake=True, **options):
    """Yield an emulated robot and a client of it, which has woken it up."""
    with emulated(pace) as (robot, address), RealNao(address, model="V4", **options) as nao:
        if awake:
            nao.wake_up()
        yield robot, nao
