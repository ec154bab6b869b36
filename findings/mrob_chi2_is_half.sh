#!/usr/bin/env bash
# You expect a function named chi2 to return the weighted sum of squares, which belongs in a chi-square table.
# mrob 0.0.17's FGraph.chi2() and get_chi2_array() return half of it: the cost that the optimiser minimises.
# Seen for an error of (0.2, 0.1, 0.1) with information 100, 200, 300: 4.5, while the sum of squares is 9.0.
# With three degrees of freedom, 9.0 is outside the 95 % bound of 7.81, but 4.5 is inside it. A gate on these
# numbers accepts loop closures whose error is 41 % larger than the gate was set for. GTSAM halves as well,
# but its function is named error().
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check mrob==0.0.17 numpy==1.26.4
"$folder/venv/bin/python" - <<'PYTHON'
import mrob
import numpy as np

residual, information = np.array([0.2, 0.1, 0.1]), np.diag([100.0, 200, 300])
graph = mrob.FGraph()
first, second = graph.add_node_pose_2d(np.zeros(3)), graph.add_node_pose_2d(residual)
graph.add_factor_1pose_2d(np.zeros(3), first, np.eye(3))
graph.add_factor_2poses_2d(np.zeros(3), first, second, information)
chi2 = residual @ information @ residual
print(f"mrob: {graph.chi2():.3f}, sum of squares: {chi2:.3f}")
assert np.isclose(chi2, 9)
assert np.isclose(graph.chi2(), 4.5)
assert np.isclose(np.max(graph.get_chi2_array()), 4.5)
PYTHON
