#!/usr/bin/env bash
# You load a graph into g2o's SparseOptimizer and ask for chi2(). You expect the chi2 of the initial estimate.
# g2opy 2.3.0 returns 0.0, the score of a perfect solution, until compute_active_errors() or optimize() has run.
# Seen: 0.0 after load, 0.0 after initialize_optimization, 144.4929 after compute_active_errors.
# After vertex.set_estimate() moved a pose by 3 m, chi2() still returned 144.4929: it sums stored errors.
# A comparison "chi2 before and after" that forgets the call says that optimising made every graph worse.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check g2opy==2.3.0 numpy==2.4.6
"$folder/venv/bin/python" - <<'PYTHON'
import tempfile

import g2opy

FILE = """VERTEX_SE2 0 0 0 0
VERTEX_SE2 1 1.5 0.2 0.1
VERTEX_SE2 2 2 0 1
EDGE_SE2 0 1 1 0 0 100 0 0 100 0 100
EDGE_SE2 1 2 1 0 0 100 0 0 100 0 100
FIX 0
"""
solver = g2opy.BlockSolverX(g2opy.LinearSolverEigenX())
optimizer = g2opy.SparseOptimizer()
optimizer.set_algorithm(g2opy.OptimizationAlgorithmGaussNewton(solver))
with tempfile.NamedTemporaryFile("w", suffix=".g2o") as file:
    file.write(FILE)
    file.flush()
    assert optimizer.load(file.name)
loaded = optimizer.chi2()
optimizer.initialize_optimization()
ready = optimizer.chi2()
optimizer.compute_active_errors()
computed = optimizer.chi2()
optimizer.vertex(2).set_estimate(g2opy.SE2(2, 3, 1))
moved = optimizer.chi2()
print(f"chi2: {loaded} loaded, {ready} initialised, {computed:.4f} computed, {moved:.4f} after a pose moved")
assert loaded == ready == 0
assert round(computed, 4) == 144.4929 and moved == computed
optimizer.compute_active_errors()
assert round(optimizer.chi2(), 4) == 864.5929
PYTHON
