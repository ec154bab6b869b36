#!/usr/bin/env bash
# GTSAM names variables with a letter and a number: symbol("a", 0) and symbol("b", 0) are two robots' first
# poses. You expect writeG2o to give them different ids, or to refuse. GTSAM 4.3.0 writes only the number.
# Seen: four poses of two robots become the ids 0 1 0 1, and the edge between the robots becomes an edge from
# pose 1 to itself. GTSAM itself refuses to read the file again. The prior factor is left out without a
# message, so the file no longer says which pose is fixed. Renumber the keys before you save a graph of
# several robots or of several kinds of poses.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check gtsam==4.3.0 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import tempfile

import gtsam

unit = gtsam.noiseModel.Unit.Create(3)
graph, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
for y, robot in enumerate("ab"):
    for i in range(2):
        values.insert(gtsam.symbol(robot, i), gtsam.Pose2(i, y, 0))
    graph.add(gtsam.BetweenFactorPose2(gtsam.symbol(robot, 0), gtsam.symbol(robot, 1), gtsam.Pose2(1, 0, 0), unit))
graph.add(gtsam.BetweenFactorPose2(gtsam.symbol("a", 1), gtsam.symbol("b", 1), gtsam.Pose2(0, 1, 0), unit))
graph.add(gtsam.PriorFactorPose2(gtsam.symbol("a", 0), gtsam.Pose2(), unit))
with tempfile.NamedTemporaryFile("r", suffix=".g2o") as file:
    gtsam.writeG2o(graph, values, file.name)
    lines = [line.split() for line in file.read().splitlines()]
    try:
        gtsam.readG2o(file.name, False)
        readable = True
    except RuntimeError:
        readable = False
vertices = [line[1] for line in lines if line[0] == "VERTEX_SE2"]
edges = [line[1:3] for line in lines if line[0] == "EDGE_SE2"]
print("ids of four poses:", vertices, "edges:", edges, "readable again:", readable)
assert vertices == ["0", "1", "0", "1"]
assert edges == [["0", "1"], ["0", "1"], ["1", "1"]]
assert len(lines) == 7 and not readable
PYTHON
