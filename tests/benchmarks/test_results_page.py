"""The page of results: its rows are the recorded figures, and each command exists."""

import json
import re

import pytest

from benchmarks import RESULTS
from benchmarks.__main__ import MODULES
from tests.paths import PROJECT

PAGE = (PROJECT / "docs" / "results.md").read_text(encoding="utf-8")
COLUMNS = {
    "position": 100,
    "position 95 %": 100,
    "position worst": 100,
    "lost": 100,
    "NEES mean": 1,
    "NEES median": 1,
    "outside": 100,
}


def rows_of(name):
    """Return the rows of numbers in the section with a benchmark's command: numbers by the first cell."""
    (section,) = (each for each in PAGE.split("\n## ") if f"\n`python -m benchmarks {name}`" in each)
    cells = (line.strip("| ").split(" | ") for line in section.splitlines() if line.startswith("| "))
    return {
        first: list(map(float, values))
        for first, *values in cells
        if re.match(r"[\d.]+$", values[-1]) and len(values) >= 6
    }


@pytest.mark.parametrize(
    ("name", "key"),
    [("field_slam", "variants"), ("field_tails", "conditions"), ("field_false", "conditions")],
)
def test_each_row_is_the_recorded_one(name, key):
    found, rows = json.loads((RESULTS / f"{name}.json").read_text(encoding="utf-8"))[key], rows_of(name)
    assert len(rows) > 5 and {*rows} <= {*found}
    for row, shown in rows.items():
        recorded = [found[row][column] * by for column, by in COLUMNS.items() if column in found[row]]
        assert shown == pytest.approx(recorded, abs=0.0501), row


def test_each_command_is_a_benchmark_with_a_result():
    named = {*re.findall(r"python -m benchmarks (\w+)", PAGE)}
    assert named <= {*MODULES} and named <= {path.stem for path in RESULTS.glob("*.json")}
