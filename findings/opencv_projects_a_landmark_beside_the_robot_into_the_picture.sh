#!/usr/bin/env bash
# You simulate a camera: projectPoints gives each landmark's pixel, and those inside the picture are seen. The
# polynomial of barrel distortion turns back, so a landmark far outside the view can be projected inside. Seen
# with OpenCV 5.0, f = 280 pixels, a picture of 320 x 240 and the mild k1 = -0.08: a landmark 74 degrees to
# the right of the optical axis has x = 179.6, near the middle of the picture, although the view ends at 30
# degrees. A landmark behind the camera is inside too, and one with z = 0 is projected as if z were 1. None of
# the three raises. Test z > 0 and the angle before you project.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check opencv-python-headless==5.0.0.93 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import cv2
import numpy as np

CAMERA = np.array([[280.0, 0, 160], [0, 280, 120], [0, 0, 1]])
DISTORTION = np.array([-0.08, 0, 0, 0])


def pixel(x, y, z):
    point = np.array([[x, y, z]], float)
    return cv2.projectPoints(point, np.zeros(3), np.zeros(3), CAMERA, DISTORTION)[0].ravel()


edge, beside, behind, level = pixel(0.59, 0, 1), pixel(3.5, 0, 1), pixel(0.1, 0.1, -1), pixel(0.1, 0.1, 0)
print(f"30 degrees: {edge}, 74 degrees: {beside}, behind: {behind}, z = 0: {level}, z = 1: {pixel(0.1, 0.1, 1)}")
assert 315 < edge[0] < 325
assert np.allclose(beside, [179.6, 120])
assert np.all(behind > 0) and np.all(behind < [320, 240])
assert np.array_equal(level, pixel(0.1, 0.1, 1))
PYTHON
