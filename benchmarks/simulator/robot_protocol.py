"""How fast a robot behind the real protocol is: pictures, commands and stops over the loopback address.

``nao-course robot serve`` runs in a process of its own, as it does for a class. It draws each picture while the client
waits, so a stored picture of the same size says what the protocol costs. The panel with the solution's labels takes
pictures from the emulated robot and from a simulated one in its own process.
"""

import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import chdir

import numpy as np

from benchmarks import ROOT, Result, Table
from nao_course.robot import RealNao, Robot, RobotError
from nao_course.sim import SimulatedNao
from nao_course.student import my_nao

PICTURES, STOPS = 60, 20
SIZES = ((320, 240), (640, 480))
START = 60.0  # s in which the robot's process begins to answer
SERVE = """
import sys
from nao_course.robot.emulated import EmulatedNao, served
from nao_course.sim import SimulatedNao

class Stored(EmulatedNao):
    def look(self, camera, size):
        if size not in (kept := self.__dict__.setdefault("kept", {})):
            kept[size] = super().look(camera, size)
        return kept[size]

kind = Stored if sys.argv[2] == "stored" else EmulatedNao
with served(kind(SimulatedNao(rng=1)), int(sys.argv[1])):
    sys.stdin.read()
"""


def milliseconds(call: Callable[[], object], count: int) -> list[float]:
    """Return how long each of some calls takes on the clock, ms."""
    taken = []
    for _ in range(count):
        began = time.perf_counter()
        call()
        taken.append(1e3 * (time.perf_counter() - began))
    return taken


def connected(port: int) -> RealNao:
    """Return a client as soon as the robot answers."""
    end = time.monotonic() + START
    while True:
        try:
            return RealNao(f"tcp://127.0.0.1:{port}", model="V4", seconds=10)
        except RobotError:
            if time.monotonic() > end:
                raise
            time.sleep(0.2)


def stop_milliseconds(nao: RealNao) -> float:
    """Return the time from `stop` in one thread until a walk in another one has ended, ms."""
    ended: list[float] = []
    walking = threading.Thread(target=lambda: (nao.walk(1.0), ended.append(time.perf_counter())))
    walking.start()
    time.sleep(0.3)
    began = time.perf_counter()
    nao.stop()
    walking.join()
    return 1e3 * (ended[0] - began)


def panel_milliseconds(nao: Robot) -> list[float]:
    """Return how long the panel with the solution's labels takes for each picture, ms."""
    with chdir(ROOT / "solutions"):
        panel = my_nao(nao, upto="01")
    return milliseconds(panel.take_picture, PICTURES)


def measure(kind: str) -> dict[str, dict[str, float]]:
    """Return median and 95th percentile of each wait, with pictures that are drawn or stored."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    command = [sys.executable, "-c", SERVE, str(port), kind]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as server:
        try:
            with connected(port) as nao:
                nao.wake_up()
                taken = {
                    f"a picture of {width} x {height}, {kind}": milliseconds(
                        lambda size=(width, height): nao.take_picture(size=size), PICTURES
                    )
                    for width, height in SIZES
                }
                if kind == "stored":
                    taken["a command on the wire"] = milliseconds(lambda: nao.head, PICTURES)
                    taken["from stop to the end of a walk"] = [stop_milliseconds(nao) for _ in range(STOPS)]
                else:
                    taken["the panel with own labels, emulated"] = panel_milliseconds(nao)
                    taken["the panel with own labels, simulated"] = panel_milliseconds(SimulatedNao(rng=1))
        finally:
            server.communicate()
    return {
        name: {
            "median, ms": float(np.median(each)),
            "95 %, ms": float(np.percentile(each, 95)),
            "a second": 1e3 / float(np.median(each)),
        }
        for name, each in taken.items()
    }


def main() -> Result:
    """Measure with stored pictures, and with pictures that are drawn."""
    found = measure("stored") | measure("drawn")
    return Result("robot_protocol", found, (Table.of("A robot behind libqi on this machine", found),))
