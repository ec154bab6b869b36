"""A benchmark's tables can be read at any width."""

import io
import re

import pytest
from rich.console import Console

from benchmarks import Result, Table

STAGES = (
    "the same with labels (01), goal posts (02), corners (03), points on the map (04), and the estimate (11)"
)
WORDS = Table(
    "words before numbers",
    ("measured", "median", "90 %", "wanted"),
    ((STAGES, 1234.5678, "61.8 ms", ">= 12"), ("longest gap", "7890.12 ms", "", "")),
)
NUMBERS = Table(
    "more numbers than a terminal is wide",
    ("width", *(f"stage number {i} of the pipeline" for i in range(12))),
    tuple((width, *(width * 1000 + i / 7 for i in range(12))) for width in (320, 640)),
)


def printed(table: Table, width: int) -> list[str]:
    """Return the lines of a table that is shown in a console of some width."""
    console = Console(file=io.StringIO(), width=width)
    Result("tables", {}, (table,)).show(console)
    assert console.width == width
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue().splitlines()


@pytest.mark.parametrize("table", [WORDS, NUMBERS], ids=["words", "numbers"])
@pytest.mark.parametrize("width", [80, 110])
def test_each_number_and_word_is_printed_whole(table, width):
    shown = "\n".join(printed(table, width))
    assert "…" not in shown
    cells = [f"{cell:.2f}" if isinstance(cell, float) else str(cell) for row in table.rows for cell in row]
    for piece in " ".join([*table.columns, *cells]).split():
        assert re.search(rf"(?<![\w.]){re.escape(piece)}(?![\w.])", shown), piece
    lines = printed(WORDS, 200)  # where it fits, a row has one line
    assert any(STAGES in line and "1234.57" in line for line in lines)
    assert len(lines) == len(WORDS.rows) + 5  # the title, three rules and the columns' heads
