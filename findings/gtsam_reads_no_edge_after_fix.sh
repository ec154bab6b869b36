#!/usr/bin/env bash
# You expect readG2o to skip a FIX line, which g2o itself writes once for each fixed vertex.
# GTSAM 4.3.0 stops reading edges there: every edge below the line is lost, without an exception or a warning.
# Seen: 3 of 3 edges without FIX, 1 of 3 with FIX after the first edge, 0 of 3 with FIX above the edges.
# The vertices are all read, so the graph looks complete. An optimiser then has fewer constraints than the
# file, or none. If you write files for GTSAM, put FIX on the last line; if you read them, count the edges.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check gtsam==4.3.0 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import tempfile

import gtsam

VERTICES = [f"VERTEX_SE2 {i} {i} 0 0" for i in range(4)]
EDGES = [f"EDGE_SE2 {i} {i + 1} 1 0 0 100 0 0 100 0 100" for i in range(3)]


def sizes(lines):
    with tempfile.NamedTemporaryFile("w", suffix=".g2o") as file:
        file.write("\n".join(lines) + "\n")
        file.flush()
        graph, values = gtsam.readG2o(file.name, False)
    return graph.size(), values.size()


plain = sizes(VERTICES + EDGES)
between = sizes(VERTICES + EDGES[:1] + ["FIX 0"] + EDGES[1:])
above = sizes(["FIX 0"] + VERTICES + EDGES)
below = sizes(VERTICES + EDGES + ["FIX 0"])
print(f"edges read: {plain[0]} without FIX, {between[0]} with FIX after the first edge, {above[0]} with FIX on top")
assert (plain, between, above, below) == ((3, 4), (1, 4), (0, 4), (3, 4))
PYTHON
