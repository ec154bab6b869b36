#!/usr/bin/env bash
# In ahrs 0.4.0, Quaternion(rpy=[roll, pitch, yaw]) and DCM(rpy=[roll, pitch, yaw]) take the same argument, so
# you expect the same rotation. The quaternion is Rz(yaw) Ry(pitch) Rx(roll), as usual. The matrix is Rz(roll)
# Ry(pitch) Rx(yaw): the first number turns about z. Seen for roll 0.1 rad alone: the quaternion turns about
# x, the matrix about z. For (0.1, 0.2, 0.3) the two rotations differ by 17.7 degrees.
# Quaternion(...).to_angles() returns the numbers that were given. Angles near zero look alike in both, so a
# robot that stands upright does not reveal the mistake.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check ahrs==0.4.0 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
from ahrs import DCM, Quaternion


def both(rpy):
    return np.asarray(Quaternion(rpy=rpy).to_DCM()), np.asarray(DCM(rpy=rpy))


quaternion, matrix = both([0.1, 0, 0])
print("axis that roll leaves alone: quaternion", np.diag(quaternion).argmax(), "matrix", np.diag(matrix).argmax())
assert np.diag(quaternion).argmax() == 0 and np.diag(matrix).argmax() == 2
quaternion, matrix = both([0.1, 0.2, 0.3])
angle = np.degrees(np.arccos((np.trace(quaternion.T @ matrix) - 1) / 2))
print(f"angle between both for (0.1, 0.2, 0.3): {angle:.1f} degrees")
assert round(angle, 1) == 17.7
assert np.allclose(matrix, both([0.3, 0.2, 0.1])[0])
assert np.allclose(Quaternion(rpy=[0.1, 0.2, 0.3]).to_angles(), [0.1, 0.2, 0.3])
PYTHON
