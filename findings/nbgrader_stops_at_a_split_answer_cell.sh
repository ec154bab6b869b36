#!/usr/bin/env bash
# JupyterLab copies a cell's metadata when a student splits or duplicates an answer cell, so two cells share one
# grade_id. You expect nbgrader to report that student and to grade the others.
# nbgrader 0.9.6 ends the whole run: "nbgrader autograde" exits with 1 at this student, and everybody who comes later
# in the alphabet is not graded. The message says that the notebook has an old metadata format.
# Seen for the students a, b (split cell) and c: a has 5 points, b is listed with 0 points, c is not listed at all.
# The exported grades look like a finished table, in which b failed and c never submitted.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check \
    nbgrader==0.9.6 nbformat==5.11.1 nbclient==0.11.0 nbconvert==7.17.2 ipykernel==7.4.0 sqlalchemy==2.1.9
export PATH="$folder/venv/bin:$PATH" JUPYTER_CONFIG_DIR="$folder/config" JUPYTER_DATA_DIR="$folder/data"
cd "$folder"
python - <<'PYTHON'
import copy
from pathlib import Path

import nbformat
from nbformat.v4 import new_code_cell, new_notebook


def cell(name, source, **flags):
    flags = {"grade": False, "solution": False, "locked": False, "task": False} | flags
    marks = {"schema_version": 3, "grade_id": name, "cell_type": "code"} | flags
    return new_code_cell(source, id=name, metadata={"nbgrader": marks})


def save(path, cells):
    notebook = new_notebook(cells=cells)
    notebook.metadata.kernelspec = {"name": "python3", "display_name": "Python 3", "language": "python"}
    Path(path).parent.mkdir(parents=True)
    nbformat.write(notebook, path)


answer = cell("answer", "def f(x):\n    return x * x", solution=True)
test = cell("test", "assert f(2) == 4", grade=True, locked=True, points=5)
save("source/ps1/p.ipynb", [answer, test])
for student in "abc":
    cells = [copy.deepcopy(answer), copy.deepcopy(test)]
    if student == "b":
        second = copy.deepcopy(answer)
        second.id, second.source = "second", "y = f(1)"
        cells.insert(1, second)
    save(f"submitted/{student}/ps1/p.ipynb", cells)
PYTHON
options=(--CourseDirectory.course_id=course --CourseDirectory.root="$folder")
nbgrader generate_assignment ps1 "${options[@]}" > log 2>&1
code=0
nbgrader autograde ps1 "${options[@]}" >> log 2>&1 || code=$?
nbgrader export "${options[@]}" >> log 2>&1
grades=$(python -c 'import csv; print(*(row["student_id"] + "=" + row["score"] for row in csv.DictReader(open("grades.csv"))))')
echo "autograde exited with $code, graded folders: $(ls autograded | tr '\n' ' ')exported: $grades"
[ "$code" = 1 ] && [ "$(ls autograded)" = a ] && [ "$grades" = "a=5.0 b=0.0" ] && grep -q "old version" log
