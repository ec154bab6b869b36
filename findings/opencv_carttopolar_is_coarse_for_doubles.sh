#!/usr/bin/env bash
# You give cartToPolar float64 arrays and get float64 angles, so you expect them to agree with numpy.arctan2.
# OpenCV 5.0 computes them with the polynomial of fastAtan2: the largest error seen is 1.7e-4 rad, or 0.01
# degrees, and 45 degrees is returned as 44.990 degrees. cv2.phase has the same error for float64. The angles
# are in [0, 2 pi) rather than (-pi, pi], which is documented; the precision of doubles is not. An error of
# 1.7e-4 rad is harmless for hues of gradients. As a bearing it fails a test of a Jacobian by finite
# differences, because the error is not smooth, and it is 1.7 mm at 10 m.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check opencv-python-headless==5.0.0.93 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import cv2
import numpy as np

angles = np.linspace(0, 2 * np.pi, 100_001)[:-1]
x, y = np.cos(angles), np.sin(angles)
_, polar = cv2.cartToPolar(x, y)
phase = cv2.phase(x, y)
error = np.angle(np.exp(1j * (polar.ravel() - angles)))
other = np.angle(np.exp(1j * (phase.ravel() - angles)))
print(f"{polar.dtype}: largest error {abs(error).max():.2e} rad, phase {abs(other).max():.2e}")
print("45 degrees:", cv2.cartToPolar(np.ones(1), np.ones(1), angleInDegrees=True)[1])
assert polar.dtype == np.float64
assert 1.6e-4 < abs(error).max() < 1.7e-4
assert 1.6e-4 < abs(other).max() < 1.7e-4
PYTHON
