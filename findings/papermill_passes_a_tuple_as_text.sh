#!/usr/bin/env bash
# papermill runs a notebook with parameters. You expect a tuple to arrive as a tuple or as a list, or to
# raise. papermill 2.7.0 passes every value of a type that it does not know as the text of that value. Seen:
# the list [1, 2] arrives as [1, 2], but the tuple (1, 2) as the string '(1, 2)', which has length 6 and whose
# first element is a bracket; {1: 2} arrives as {'1': 2}. The output notebook's metadata shows the list [1, 2]
# for the tuple, so the record of the run does not reveal it. A sweep over camera resolutions, start poses or
# ranges passes tuples.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check papermill==2.7.0 ipykernel==7.4.0 nbformat==5.11.1
"$folder/venv/bin/python" - <<'PYTHON'
import tempfile

import nbformat
import papermill

GIVEN = {"a": [1, 2], "b": (1, 2), "c": {1: 2}}
cells = [
    nbformat.v4.new_code_cell("a = b = c = None", metadata={"tags": ["parameters"]}),
    nbformat.v4.new_code_cell("print(a, repr(b), len(b), c)"),
]
notebook = nbformat.v4.new_notebook(cells=cells)
notebook.metadata.kernelspec = {"name": "python3", "display_name": "Python 3", "language": "python"}
with tempfile.TemporaryDirectory() as folder:
    nbformat.write(notebook, f"{folder}/in.ipynb")
    papermill.execute_notebook(f"{folder}/in.ipynb", f"{folder}/out.ipynb", parameters=GIVEN, progress_bar=False)
    run = nbformat.read(f"{folder}/out.ipynb", as_version=4)
seen = run.cells[-1].outputs[0].text.strip()
recorded = run.metadata.papermill.parameters.b
print("seen:", seen, "recorded:", recorded)
assert seen == "[1, 2] '(1, 2)' 6 {'1': 2}"
assert recorded == [1, 2]
PYTHON
