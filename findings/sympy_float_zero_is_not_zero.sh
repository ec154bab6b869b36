#!/usr/bin/env bash
# You check a symbolic matrix at a point: F.subs(dt, 0.0) == eye(2). You expect 0.0 and 0 to count as equal,
# as in Python. Since SymPy 1.13 a Float never equals an Integer or a Rational, so sympy.Float(0) == 0 is
# False. Seen with SymPy 1.14: for F = [[1, dt], [0, 1]], F.subs(dt, 0) equals eye(2), but F.subs(dt, 0.0)
# does not. For F = [[1, -dt], [0, 1]] both do, because SymPy makes the product of a number and 0.0 exact;
# Float(1) - 1 == 0 is True for a similar reason. So the same test passes for one entry and fails for the
# next. Graders that compare with == reject an answer of 0.5 where the reference is 1/2. Compare numbers
# instead.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check sympy==1.14.0 mpmath==1.3.0
"$folder/venv/bin/python" - <<'PYTHON'
import sympy

dt = sympy.Symbol("dt")
motion, back = sympy.Matrix([[1, dt], [0, 1]]), sympy.Matrix([[1, -dt], [0, 1]])
unit = sympy.eye(2)
seen = [matrix.subs(dt, zero) == unit for matrix in (motion, back) for zero in (0, 0.0)]
print("motion at 0 and 0.0, back at 0 and 0.0 equal eye(2):", seen, "Float(0) == 0:", sympy.Float(0) == 0)
assert seen == [True, False, True, True]
assert not sympy.Float(0) == 0
assert sympy.Float(1) - 1 == 0
assert not sympy.Float(0.5) == sympy.Rational(1, 2)
PYTHON
