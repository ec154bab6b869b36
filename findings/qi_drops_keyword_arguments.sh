#!/usr/bin/env bash
# You call a service's method with a keyword argument. You expect the argument to arrive, or a TypeError. qi
# 3.1.5 (libqi-python) drops keyword arguments without a message and calls the method with the positional
# ones. Seen for a method moveTo(self, *target) that returns what it received: moveTo(1, 2, speed=0.1)
# receives (1, 2). Default values do not exist for the client either: a method with two parameters, the second
# with a default, cannot be called with one argument. A robot that is told to move with speed=0.1 moves with
# its standard speed.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check qi==3.1.5
"$folder/venv/bin/python" - <<'PYTHON'
import qi


class Motion:
    def moveTo(self, x, y):
        return [x, y]

    def turn(self, angle, speed=1.0):
        return [angle, speed]


server, client = qi.Session(), qi.Session()
server.listenStandalone("tcp://127.0.0.1:0")
server.registerService("Motion", Motion())
client.connect(server.endpoints()[0])
motion = client.service("Motion")
received = motion.moveTo(1, 2, speed=0.1)
try:
    turned = motion.turn(1)
except RuntimeError:
    turned = "refused"
print("moveTo(1, 2, speed=0.1) received", received, "and turn(1) was", turned)
assert received == [1, 2]
assert turned == "refused"
client.close()
server.close()
PYTHON
