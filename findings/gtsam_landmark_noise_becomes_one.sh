#!/usr/bin/env bash
# A LANDMARK line ends with three numbers for the noise of the landmark's position: xx xy yy. You expect
# GTSAM's load2D, which turns the line into a bearing and a range, to turn this noise into theirs. GTSAM 4.3.0
# does so only if xx and yy are equal. Otherwise the factor gets the unit noise model without a warning: a
# standard deviation of 1 rad and 1 m. Seen: the variances 0.01, 0.01 give 0.032 rad and 0.1 m; the variances
# 0.01, 0.02 give 1 rad and 1 m. Cameras measure depth and direction with different precision, so their
# landmarks hardly count.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check gtsam==4.3.0 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import tempfile

import gtsam
import numpy as np


def sigmas(xx, yy):
    with tempfile.NamedTemporaryFile("w", suffix=".graph") as file:
        file.write(f"VERTEX2 0 0 0 0\nLANDMARK 0 5 2 0 {xx} 0 {yy}\n")
        file.flush()
        graph, _ = gtsam.load2D(file.name)
    return graph.at(0).noiseModel().sigmas()


equal, different = sigmas(0.01, 0.01), sigmas(0.01, 0.02)
print("standard deviations (bearing, range) for equal variances:", equal, "for different variances:", different)
assert np.allclose(equal, [0.031623, 0.1], atol=1e-6)
assert np.array_equal(different, [1, 1])
PYTHON
