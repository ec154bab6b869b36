#!/usr/bin/env bash
# You expect a pose graph that is saved and loaded again to be the same graph, as with repr() in Python.
# GTSAM 4.3.0 (writeG2o) and g2o itself (g2opy 2.3.0, SparseOptimizer.save) write six significant digits.
# Seen: x = 345678.912345 is written as 345679 by both, and a heading of 1/3 as 0.333333.
# In a local frame that is a hundredth of a millimetre. A graph in map coordinates (UTM eastings have six digits
# before the point, northings seven) is rounded to 1 m or 10 m, which destroys every relative pose in the initial
# estimate. Subtract an origin before saving, and do not compare chi2 across a round trip.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check gtsam==4.3.0 g2opy==2.3.0 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import tempfile

import g2opy
import gtsam

X, THETA = 345678.912345, 1 / 3


def by_gtsam(name):
    values = gtsam.Values()
    for i in range(2):
        values.insert(i, gtsam.Pose2(X, 0, THETA))
    gtsam.writeG2o(gtsam.NonlinearFactorGraph(), values, name)


def by_g2o(name):
    optimizer, edge = g2opy.SparseOptimizer(), g2opy.EdgeSE2()
    for i in range(2):
        vertex = g2opy.VertexSE2()
        vertex.set_id(i)
        vertex.set_estimate(g2opy.SE2(X, 0, THETA))
        optimizer.add_vertex(vertex)
        edge.set_vertex(i, optimizer.vertex(i))
    optimizer.add_edge(edge)
    assert optimizer.save(name)


for save in (by_gtsam, by_g2o):
    with tempfile.NamedTemporaryFile("r", suffix=".g2o") as file:
        save(file.name)
        first = file.readline().strip()
    print(save.__name__, "writes", first)
    assert first == "VERTEX_SE2 0 345679 0 0.333333"
PYTHON
