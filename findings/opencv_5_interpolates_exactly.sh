#!/usr/bin/env bash
# remap, warpAffine and warpPerspective take floating-point coordinates. In OpenCV 4 they round them to 1/32 pixel;
# you expect OpenCV 5 to give the same pixels for the same call, or a flag that chooses.
# OpenCV 5.0 interpolates at the exact coordinate. Seen on a ramp of 100 per pixel, sampled at 10.00, 10.01, 10.02:
# 4.12 gives 1000, 1000, 1003.125; 5.0 gives 1000, 1001, 1002.
# So a picture that is undistorted or rotated with one version is not the picture of the other one, and stored
# reference pictures or thresholds on differences of frames have to be made again.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

samples() {
    python3 -m venv --clear "$folder/venv"
    "$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
    "$folder/venv/bin/python" - <<'PYTHON'
import cv2
import numpy as np

ramp = np.tile(100 * np.arange(64, dtype=np.float32), (8, 1))
x = np.array([[10, 10.01, 10.02]], np.float32)
print(*(f"{each:.3f}" for each in cv2.remap(ramp, x, np.full_like(x, 3), cv2.INTER_LINEAR)[0]))
PYTHON
}

old=$(samples opencv-python-headless==4.12.0.88 numpy==2.2.6)
new=$(samples opencv-python-headless==5.0.0.93 numpy==2.4.6)
echo "OpenCV 4.12: $old; OpenCV 5.0: $new"
[ "$old" = "1000.000 1000.000 1003.125" ] && [ "$new" = "1000.000 1001.000 1002.000" ]
