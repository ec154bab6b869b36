#!/usr/bin/env bash
# A 2D pose graph's residual is usually (dx, dy, dtheta) in the frame of the measurement, as g2o computes it.
# You expect a BetweenFactorPose2 with unit noise to give chi2 = 1 + 0 + 1 = 2 for an error of 1 m and 1 rad.
# GTSAM 4.3.0 uses the logarithm of SE(2) instead and gives 2.0877 (factor.error() is half of chi2).
# Both residuals vanish at the same pose, but their chi2 differ: by 4 % at 1 rad, by 13 % at 3 rad.
# So the chi2 of a benchmark graph, or a gate for loop closures, that was computed with g2o cannot be compared
# with GTSAM's.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check gtsam==4.3.0 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import gtsam
import numpy as np

factor = gtsam.BetweenFactorPose2(0, 1, gtsam.Pose2(), gtsam.noiseModel.Unit.Create(3))


def chi2(x, y, theta):
    values = gtsam.Values()
    values.insert(0, gtsam.Pose2())
    values.insert(1, gtsam.Pose2(x, y, theta))
    return 2 * factor.error(values)


print(f"chi2 of (1, 0, 1): {chi2(1, 0, 1):.4f}, of (1, 0, 3): {chi2(1, 0, 3):.4f}, of (1, 0, 0): {chi2(1, 0, 0):.4f}")
assert round(chi2(1, 0, 1), 4) == 2.0877
assert np.isclose(chi2(1, 0, 1), (0.5 / np.tan(0.5)) ** 2 + 0.5**2 + 1)
assert np.isclose(chi2(1, 0, 0), 1)
PYTHON
