#!/usr/bin/env bash
# kinematic_kf(dim=2, order=1) builds a constant-velocity filter for the plane. You expect it to measure x and
# y. filterpy 2.0.0 returns a filter with one measurement, whose matrix H is [1 0 1 0]: it measures x + y.
# Seen: an update with 5, the sum of the position (2, 3), moves the estimate to (1.67, 1.67), and nothing
# raises. dim_z is documented as the size of z for each dimension, so its default 1 looks right; with dim_z=2
# the filter has two rows, and both are [1 0 1 0]. Set H yourself. One-dimensional filters are not affected.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check filterpy==2.0.0 numpy==2.4.6 scipy==1.17.1 matplotlib==3.11.2
"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
from filterpy.common import kinematic_kf

kf = kinematic_kf(dim=2, order=1, dt=1.0)
two = kinematic_kf(dim=2, order=1, dt=1.0, dim_z=2)
print("H:", kf.H.tolist(), "with dim_z=2:", two.H.tolist())
assert np.array_equal(kf.H, [[1, 0, 1, 0]])
assert np.array_equal(two.H, [[1, 0, 1, 0], [1, 0, 1, 0]])
kf.update(np.array([5.0]))
print("position after measuring 5:", kf.x[[0, 2], 0].round(2))
assert np.allclose(kf.x[[0, 2], 0], 5 / 3)
PYTHON
