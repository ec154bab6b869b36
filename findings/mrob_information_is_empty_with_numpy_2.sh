#!/usr/bin/env bash
# mrob's FGraph.get_information_matrix() returns a SciPy sparse matrix, whose inverse is the estimate's covariance.
# You expect a wheel that installs and optimises correctly with NumPy 2 to return this matrix too, or to raise.
# mrob 0.0.17 (pins nothing, built before NumPy 2) returns a matrix of the right shape without any entry. The
# adjacency and weight matrices are empty too, but dense results, such as the estimate and chi2, are right.
# Seen for two poses and two factors, after the same solve: 36 stored entries with NumPy 1.26.4, 0 with 2.4.6.
# A script that adds a small number to the diagonal before it inverts hides this and reports an arbitrary covariance.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

entries() {
    python3 -m venv --clear "$folder/venv"
    "$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check mrob==0.0.17 scipy==1.16.3 "numpy==$1"
    "$folder/venv/bin/python" - <<'PYTHON'
import mrob
import numpy as np

graph = mrob.FGraph()
first, second = graph.add_node_pose_2d(np.zeros(3)), graph.add_node_pose_2d(np.array([1.2, 0.1, 0.1]))
graph.add_factor_1pose_2d(np.zeros(3), first, 4 * np.eye(3))
graph.add_factor_2poses_2d(np.array([1.0, 0, 0]), first, second, np.diag([100.0, 200, 300]))
graph.solve(mrob.LM)
assert np.allclose(np.ravel(graph.get_estimated_state()), [0, 0, 0, 1, 0, 0], atol=1e-6)
matrix = graph.get_information_matrix()
assert matrix.shape == (6, 6)
print(matrix.nnz)
PYTHON
}

old=$(entries 1.26.4)
new=$(entries 2.4.6)
echo "stored entries of the information matrix: $old with NumPy 1.26.4, $new with NumPy 2.4.6"
[ "$old" = 36 ] && [ "$new" = 0 ]
