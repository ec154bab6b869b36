#!/usr/bin/env bash
# A service written in Python has a method moveTo, which takes a second, and a method stopMove. A client calls moveTo
# without waiting and then stopMove. You expect stopMove to run while moveTo runs, as on the robot. qi 3.1.5
# (libqi-python) runs the calls of one object one after the other, in the order in which they arrive: stopMove begins
# when the motion has ended, and no call fails. With the decorator qi.multiThreaded() for the class, both run at the
# same time. An emulated robot without it never stops early, and a test on it says nothing about stopping.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check qi==3.1.5
"$folder/venv/bin/python" - <<'PYTHON'
import threading

import qi


class Motion:
    def __init__(self):
        self.moving, self.stopped = threading.Event(), threading.Event()

    def moveTo(self, distance):
        self.moving.set()
        return self.stopped.wait(1.0)  # whether it was stopped on the way

    def stopMove(self):
        self.stopped.set()


def was_stopped(motion_type):
    server, client = qi.Session(), qi.Session()
    motion = motion_type()
    server.listenStandalone("tcp://127.0.0.1:0")
    server.registerService("Motion", motion)
    client.connect(server.endpoints()[0])
    proxy = client.service("Motion")
    walk = proxy.call("moveTo", 1.0, _async=True)
    motion.moving.wait()
    proxy.call("stopMove", _async=True).value(10_000)
    stopped = walk.value(10_000)
    client.close()
    server.close()
    return stopped


plain = was_stopped(Motion)
threaded = was_stopped(qi.multiThreaded()(Motion))
print("stopped on the way: as a plain class", plain, "and with multiThreaded", threaded)
assert plain is False
assert threaded is True
PYTHON
