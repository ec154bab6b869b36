#!/usr/bin/env bash
# minAreaRect returns (centre, (width, height), angle). Since OpenCV 4.5.1 the angle is in (0, 90]; you expect a
# rectangle that did not change to keep its angle.
# OpenCV 5.0 returns angles in [-90, 0) and swaps width and height with them, as versions before 4.5.1 did.
# Seen for a rectangle of 60 x 20 pixels at 30 degrees: 4.12 gives (60, 20) and 30; 5.0 gives (20, 60) and -60.
# boxPoints draws the same corners for both, so a picture does not show it, but a heading that is read from the
# angle, or "the width is the long side", turns by 90 degrees.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

rectangle() {
    python3 -m venv --clear "$folder/venv"
    "$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check "$@"
    "$folder/venv/bin/python" - <<'PYTHON'
import cv2
import numpy as np

angle = np.radians(30)
along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
corners = np.array([100 + 30 * a * along + 10 * b * across for a, b in [(1, 1), (1, -1), (-1, -1), (-1, 1)]])
_, (width, height), angle = cv2.minAreaRect(corners.astype(np.float32))
print(round(width), round(height), round(angle))
PYTHON
}

old=$(rectangle opencv-python-headless==4.12.0.88 numpy==2.2.6)
new=$(rectangle opencv-python-headless==5.0.0.93 numpy==2.4.6)
echo "width, height, angle: OpenCV 4.12: $old; OpenCV 5.0: $new"
[ "$old" = "60 20 30" ] && [ "$new" = "20 60 -60" ]
