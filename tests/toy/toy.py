"""A lesson of two small exercises, so that the course's machinery can be tried without a real one."""

import json
import shutil
from pathlib import Path

HERE = Path(__file__).parent
LESSON = "90_toy"
METADATA = {
    "solution": {"nbgrader": {"solution": True, "grade": False}},
    "check": {"nbgrader": {"solution": False, "grade": True}},
    "setup": {"nao_course": {"role": "setup"}},
    "display": {"nao_course": {"role": "display"}},
    "student": {},
}
SETUP = "import numpy as np\n\nfrom nao_course.exercises import lesson\n\ncheck, hint = lesson('90_toy')"
CLAMP = '''\
def clamp(x: float, low: float, high: float) -> float:
    """Return the number in low..high that is nearest to x."""
    return max(low, min(high, x))
'''
MEAN = '''\
def mean_of_positive(values):
    """Return the mean of the positive ones among N values; 0.0 where there are none."""
    positive = values[values > 0]
    return float(positive.mean()) if len(positive) else 0.0
'''
SOLUTION = [
    ("setup", SETUP),
    ("solution", CLAMP),
    ("check", "check('clamp', clamp)"),
    ("solution", MEAN),
    ("check", "check('mean_of_positive', mean_of_positive)"),
]


def write(path: Path, *cells: str | tuple[str, str]) -> Path:
    """Write a notebook of code cells: source, or (role, source)."""
    pairs = [("student", cell) if isinstance(cell, str) else cell for cell in cells]
    code = {"cell_type": "code", "outputs": [], "execution_count": None}
    named = enumerate((METADATA[role], source) for role, source in pairs)
    cells = [{"id": f"c{n}", "metadata": of, "source": source, **code} for n, (of, source) in named]
    notebook = {"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": cells}
    path.write_text(json.dumps(notebook), encoding="utf-8")
    return path


def solutions(folder: Path) -> Path:
    """Make a folder like solutions/ that holds this one lesson."""
    shutil.copytree(HERE / "exercises", folder / "exercises", ignore=shutil.ignore_patterns("__pycache__"))
    write(folder / f"{LESSON}.ipynb", *SOLUTION)
    return folder
