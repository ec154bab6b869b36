#!/usr/bin/env bash
# You expect an EDGE_SE2_POINTXY_OFFSET, whose sensor has the offset of its PARAMS_SE2OFFSET line, to be the
# measurement of a landmark in the frame of that sensor, as EDGE_SE2_OFFSET is for poses.
# g2o (g2opy 2.3.0) computes its error in the frame of the robot: chi2 is the same for every offset.
# Seen: a landmark 3 m ahead, measured at 2 m by a sensor that is mounted 1 m ahead, has chi2 1 instead of 0, and
# measured at 3 m it has chi2 0. A map that is built from such edges is wrong by the offset of the sensor.
# Use plain EDGE_SE2_XY, and transform the measurements into the robot's frame yourself.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check g2opy==2.3.0 numpy==2.4.6
"$folder/venv/bin/python" - "$folder/graph.g2o" <<'PYTHON'
import sys
from pathlib import Path

import g2opy


def chi2(offset, edge):
    lines = [f"PARAMS_SE2OFFSET 7 {offset}", "VERTEX_SE2 0 0 0 0", "VERTEX_SE2 1 0 0 0", "VERTEX_XY 2 3 0", edge]
    Path(sys.argv[1]).write_text("\n".join(lines) + "\n")
    optimizer = g2opy.SparseOptimizer()
    assert optimizer.load(sys.argv[1])
    (read,) = optimizer.edges()
    read.compute_error()
    return read.chi2()


right = chi2("1 0 0", "EDGE_SE2_POINTXY_OFFSET 0 2 7 2 0 1 0 1")
wrong = [chi2(offset, "EDGE_SE2_POINTXY_OFFSET 0 2 7 3 0 1 0 1") for offset in ("0 0 0", "1 0 0", "9 9 1")]
poses = chi2("1 0 0.5", "EDGE_SE2_OFFSET 0 1 7 7 0 0 0 1 0 0 1 0 1")
print(f"measured by the sensor: chi2 {right}; measured by the robot, with three offsets: {wrong}")
assert (right, wrong, poses) == (1, [0, 0, 0], 0)
PYTHON
