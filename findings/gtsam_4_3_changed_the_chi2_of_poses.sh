#!/usr/bin/env bash
# You expect the chi2 of a pose graph to stay the same when you update the library that computes it.
# GTSAM 4.2 computes the error of a BetweenFactorPose2 as x, y and angle, like g2o; GTSAM 4.3.0 as a logarithm.
# Seen for an error of 1 m and an angle, with unit information: 1.0900 and 1.0975 at 0.3 rad, 2.0000 and 2.0877 at
# 1 rad, 10.0000 and 11.2613 at 3 rad. They agree only if the angle has no error.
# So a chi2, a threshold for loop closures, or a table of a paper that was computed with one version cannot be
# compared with the other. Note the version next to each number.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
for version in 4.2 4.3.0; do
    numpy=2.4.6
    if [ "$version" = 4.2 ]; then numpy=1.26.4; fi
    python3 -m venv "$folder/$version"
    "$folder/$version/bin/python" -m pip install --quiet --disable-pip-version-check "gtsam==$version" "numpy==$numpy"
    "$folder/$version/bin/python" - "$version" <<'PYTHON'
import sys

import gtsam
import numpy as np

ANGLES = (0, 0.1, 0.3, 1, 2, 3)
factor = gtsam.BetweenFactorPose2(0, 1, gtsam.Pose2(), gtsam.noiseModel.Unit.Create(3))


def chi2(angle):
    values = gtsam.Values()
    values.insert(0, gtsam.Pose2())
    values.insert(1, gtsam.Pose2(1, 0, angle))
    return 2 * factor.error(values)


found = [chi2(angle) for angle in ANGLES]
print(f"gtsam {sys.argv[1]}:", *(f"{angle} rad {value:.4f}" for angle, value in zip(ANGLES, found)))
plain = 1 + np.square(ANGLES)
assert np.allclose(found, plain) == (sys.argv[1] == "4.2")
assert np.allclose(found[3], 2.0 if sys.argv[1] == "4.2" else 2.0877, atol=1e-4)
PYTHON
done
