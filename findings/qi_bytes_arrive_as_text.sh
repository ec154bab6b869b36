#!/usr/bin/env bash
# The NAO's middleware carries raw data, such as camera pictures. You expect a Python service that returns
# bytes to give the client bytes, or to raise. qi 3.1.5 (libqi-python) turns bytes into text: UTF-8 is
# decoded, anything else becomes its Python source text. Seen: b"abc" arrives as "abc", and the three bytes ff
# 00 61 arrive as the 12 characters b'\xff\x00a'. A picture that happens to be valid UTF-8, such as a black
# one, arrives differently from all others. A method that is bound with a tuple signature which contains "r"
# delivers a bytearray instead.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check qi==3.1.5
"$folder/venv/bin/python" - <<'PYTHON'
import qi


class Camera:
    def letters(self):
        return b"abc"

    def picture(self):
        return bytes([255, 0, 97])

    @qi.bind("(ir)")
    def typed(self):
        return (3, bytes([255, 0, 97]))


server, client = qi.Session(), qi.Session()
server.listenStandalone("tcp://127.0.0.1:0")
server.registerService("Camera", Camera())
client.connect(server.endpoints()[0])
camera = client.service("Camera")
letters, picture, typed = camera.letters(), camera.picture(), camera.typed()
print("letters:", repr(letters), "picture:", repr(picture), "typed:", repr(typed))
assert letters == "abc"
assert isinstance(picture, str) and len(picture) == 12 and picture == repr(bytes([255, 0, 97]))
client.close()
server.close()
PYTHON
