#!/usr/bin/env bash
# TORO's EDGE2 lists the information as xx xy yy tt xt yt; g2o's EDGE_SE2 as xx xy xt yy yt tt.
# You expect GTSAM's readG2o, which accepts both tags, to use each tag's own order.
# GTSAM 4.3.0 reads EDGE2 in g2o's order. Seen: a TORO line with the diagonal 400, 100, 900 comes back with the
# diagonal 400, 900, 50, and its entry of x and heading is 100 instead of 0.
# The old 2D benchmark graphs (Intel, MIT, Manhattan) circulate as TORO files. Nothing fails when one is read,
# but a heading with information 900 is weighted with 50.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check gtsam==4.3.0 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import tempfile

import gtsam
import numpy as np


def information(text):
    with tempfile.NamedTemporaryFile("w", suffix=".graph") as file:
        file.write(text)
        file.flush()
        graph, _ = gtsam.readG2o(file.name, False)
    root = graph.at(0).noiseModel().R()
    return np.round(root.T @ root, 6)


toro = information("VERTEX2 0 0 0 0\nVERTEX2 1 1 0 0\nEDGE2 0 1 1 0 0 400 0 100 900 0 50\n")
g2o = information("VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\nEDGE_SE2 0 1 1 0 0 400 0 100 900 0 50\n")
print("EDGE2 is read as", toro.tolist())
assert np.array_equal(toro, [[400, 0, 100], [0, 900, 0], [100, 0, 50]])
assert np.array_equal(toro, g2o)
PYTHON
