#!/usr/bin/env bash
# Functions of OpenCV that return a list of lines give arrays of shape (N, 1, k), or (N, k) after the change in 5.0.
# You expect one of both for all of them.
# In OpenCV 5.0 HoughLinesP, HoughLinesWithAccumulator, HoughLinesPointSet and the LSD detector return two axes,
# but HoughLines still returns three; in 4.12 all of them return three.
# Seen for one line: HoughLines (1, 1, 2), HoughLinesP (1, 4), HoughLinesWithAccumulator (1, 3).
# "for line in lines: rho, theta = line[0]" works for HoughLines in both versions. The same loop over
# HoughLinesWithAccumulator fails in 5.0; lines[:, 0] then silently takes the first number of each line.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

axes() {
    python3 -m venv --clear "$folder/venv"
    "$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
    "$folder/venv/bin/python" - <<'PYTHON'
import cv2
import numpy as np

picture = np.zeros((100, 100), np.uint8)
cv2.line(picture, (10, 10), (90, 90), 255)
points = np.array([[[i, i]] for i in range(0, 100, 5)], np.float32)
step = np.pi / 180
found = [
    cv2.HoughLines(picture, 1, step, 50),
    cv2.HoughLinesP(picture, 1, step, 50),
    cv2.HoughLinesWithAccumulator(picture, 1, step, 50),
    cv2.HoughLinesPointSet(points, 20, 1, 0, 200, 1, 0, np.pi, step),
    cv2.createLineSegmentDetector().detect(picture)[0],
]
print(*(each.ndim for each in found))
PYTHON
}

old=$(axes opencv-python-headless==4.12.0.88 numpy==2.2.6)
new=$(axes opencv-python-headless==5.0.0.93 numpy==2.4.6)
echo "axes of HoughLines, -P, -WithAccumulator, -PointSet, LSD: OpenCV 4.12: $old; OpenCV 5.0: $new"
[ "$old" = "3 3 3 3 3" ] && [ "$new" = "3 2 2 2 2" ]
