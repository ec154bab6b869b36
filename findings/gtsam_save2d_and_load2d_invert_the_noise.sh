#!/usr/bin/env bash
# You expect load2D to read a graph that save2D has written, with the same noise.
# GTSAM 4.3.0 writes information matrices, but load2D takes the numbers of an EDGE2 line for covariances unless a
# noise format is given. Standard deviations of 0.1, 0.2 and 0.05 come back as 10, 5 and 20.
# The poses and measurements are right, so the graph looks the same, but precise measurements have become vague and
# vague ones precise. Seen: the chi2 falls from 4.063 to 0.000125. With NoiseFormatTORO it is read correctly.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check gtsam==4.3.0 numpy==2.4.6
"$folder/venv/bin/python" - "$folder/graph.txt" <<'PYTHON'
import sys

import gtsam
import numpy as np

SIGMAS = np.array([0.1, 0.2, 0.05])
graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
noise = gtsam.noiseModel.Diagonal.Sigmas(SIGMAS)
graph.add(gtsam.BetweenFactorPose2(0, 1, gtsam.Pose2(1, 0.05, 0.1), noise))
values.insert(0, gtsam.Pose2())
values.insert(1, gtsam.Pose2(1, 0, 0))
gtsam.save2D(graph, values, noise, sys.argv[1])

again, poses = gtsam.load2D(sys.argv[1])
toro, same = gtsam.load2D(sys.argv[1], None, 0, False, True, gtsam.NoiseFormat.NoiseFormatTORO)
print("sigmas saved:", SIGMAS, "loaded:", again.at(0).noiseModel().sigmas())
print(f"chi2 saved: {2 * graph.error(values):.4f}, loaded: {2 * again.error(poses):.6f}")
assert np.allclose(again.at(0).noiseModel().sigmas(), 1 / SIGMAS)
assert np.allclose(toro.at(0).noiseModel().sigmas(), SIGMAS)
assert 2 * graph.error(values) > 4 and 2 * again.error(poses) < 2e-4
PYTHON
