"""Turn the lessons' text (solutions/NN_name.md) into the students' notebooks (notebooks/NN_name.ipynb)."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import jupytext
import nbformat

HERE = Path(__file__).resolve().parent
SOLUTION = re.compile(r"^( *)### BEGIN SOLUTION\n.*?^ *### END SOLUTION$", re.MULTILINE | re.DOTALL)


def solved(source: Path) -> nbformat.NotebookNode:
    """Make a lesson's notebook with its solutions, without outputs; cell ids are made from lesson and ordinal."""
    notebook = jupytext.read(source, fmt="md:myst")
    lesson = source.stem.split("_")[0]
    for ordinal, cell in enumerate(notebook.cells):
        cell["id"] = f"lesson{lesson}-{ordinal:03d}"
        cell["metadata"] = {}
        if cell.cell_type == "code":
            cell["outputs"], cell["execution_count"] = [], None
    notebook.metadata = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    nbformat.validate(notebook)
    return notebook


def student_copy(source: Path) -> nbformat.NotebookNode:
    """Make a lesson's notebook with its solutions taken out."""
    notebook = solved(source)
    for ordinal, cell in enumerate(notebook.cells):
        if cell.cell_type == "code":
            cell["source"] = SOLUTION.sub(r"\1raise NotImplementedError", cell["source"])
            if "### BEGIN SOLUTION" in cell["source"] or "### END SOLUTION" in cell["source"]:
                raise ValueError(
                    f"{source.name}, cell {ordinal}: a solution begins or ends without its other half"
                )
    return notebook


def build(target: Path) -> list[Path]:
    """Write every lesson's student copy into a folder."""
    target.mkdir(exist_ok=True)
    written = []
    for source in sorted(HERE.glob("[0-9][0-9]_*.md")):
        path = target / f"{source.stem}.ipynb"
        path.write_text(nbformat.writes(student_copy(source)) + "\n", encoding="utf-8")
        written.append(path)
    return written


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parent / "notebooks"
    for made in build(folder):
        print(f"built {made.name}")
