#!/usr/bin/env bash
# OpenCV stores the hue of 8-bit pictures in half degrees. You expect 0 to 179, in HSV and in HLS alike.
# OpenCV 5.0 (and 4.12) wraps the rounded hue in HSV only: RGB (255, 0, 1) has hue 0 in HSV, but 180 in HLS.
# Seen for all 16.7 million colours: HSV's largest hue is 179, HLS's is 180, which 31684 colours have. A
# histogram with 180 bins or a lookup table with 180 rows loses these reds or fails on them, and a threshold
# "hue >= 170 and hue < 180" for a red ball misses the pixels that are the closest to pure red.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check opencv-python-headless==5.0.0.93 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import cv2
import numpy as np

hsv = hls = count = 0
green, blue = np.meshgrid(np.arange(256, dtype=np.uint8), np.arange(256, dtype=np.uint8))
for red in range(256):
    colours = np.dstack([np.full_like(green, red), green, blue])
    hsv = max(hsv, cv2.cvtColor(colours, cv2.COLOR_RGB2HSV)[..., 0].max())
    hue = cv2.cvtColor(colours, cv2.COLOR_RGB2HLS)[..., 0]
    hls, count = max(hls, hue.max()), count + int((hue == 180).sum())
red = np.array([[[255, 0, 1]]], np.uint8)
pair = [int(cv2.cvtColor(red, code)[0, 0, 0]) for code in (cv2.COLOR_RGB2HSV, cv2.COLOR_RGB2HLS)]
print(f"largest hue: HSV {hsv}, HLS {hls} ({count} colours); RGB (255, 0, 1): HSV {pair[0]}, HLS {pair[1]}")
assert (hsv, hls, count) == (179, 180, 31684)
assert pair == [0, 180]
PYTHON
