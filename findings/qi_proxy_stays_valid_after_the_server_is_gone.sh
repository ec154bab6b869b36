#!/usr/bin/env bash
# A proxy of a service has isValid(). You expect it to become False when the server is gone, as the session's
# isConnected() does. qi 3.1.5 (libqi-python): isConnected() is False, but the proxy's isValid() stays True,
# and its calls raise. A proxy does not recover either: after the same session connected to a new server at
# once, a proxy fetched before raises, while a new one from session.service() works. A watchdog that stops the
# robot's controller when isValid() becomes False never acts.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check qi==3.1.5
"$folder/venv/bin/python" - <<'PYTHON'
import time

import qi


class Motion:
    def ping(self):
        return 1


def serve():
    server = qi.Session()
    server.listenStandalone("tcp://127.0.0.1:0")
    server.registerService("Motion", Motion())
    return server


def works(proxy):
    try:
        return proxy.ping() == 1
    except RuntimeError:
        return False


server, client = serve(), qi.Session()
client.connect(server.endpoints()[0])
motion = client.service("Motion")
assert works(motion)
server.close()
deadline = time.monotonic() + 10
while client.isConnected() and time.monotonic() < deadline:
    time.sleep(0.05)
gone = (client.isConnected(), motion.isValid(), works(motion))
print("server gone: connected, valid, works:", gone)
assert gone == (False, True, False)
server = serve()
client.connect(server.endpoints()[0])
again = (works(motion), works(client.service("Motion")))
print("server back: old proxy, new proxy work:", again)
assert again == (False, True)
client.close()
server.close()
PYTHON
