#!/usr/bin/env bash
# You write Python integers to a workbook and read them with the same library. You expect the same integers:
# the file stores them as text, and the limit of 15 digits is Excel's own. openpyxl 3.1.5 writes numbers with
# 16 significant digits. Seen: the student number 12345678901234567 comes back as the float
# 12345678901234570.0, and the time stamp 1403636579758555392 (nanoseconds, as in EuRoC logs) as
# 1.403636579758555e18, which is 512 ns earlier. Integers of up to 15 digits come back unchanged. Two
# students whose long numbers differ in the last digit share one number afterwards. Write such numbers as
# text.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check openpyxl==3.1.5
"$folder/venv/bin/python" - <<'PYTHON'
import io

import openpyxl

GIVEN = [123456789012345, 12345678901234567, 12345678901234568, 1403636579758555392]
workbook, file = openpyxl.Workbook(), io.BytesIO()
workbook.active.append(GIVEN)
workbook.save(file)
seen = [cell.value for cell in openpyxl.load_workbook(file).active[1]]
print(GIVEN, "->", seen)
assert seen[0] == GIVEN[0] and isinstance(seen[0], int)
assert seen[1] == seen[2] == 12345678901234570.0
assert GIVEN[3] - int(seen[3]) == 512
PYTHON
