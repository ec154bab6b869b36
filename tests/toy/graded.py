"""A small class that hands in the lesson of `chain`, and what a journal says of it."""

import sqlite3
from pathlib import Path
from typing import Any

from nao_course.instructor.gradebook.journal import NAME, Journal
from nao_course.instructor.gradebook.records import as_json
from tests.toy import chain


def hand_in(root: Path) -> Path:
    """A class: right, blank, wrong, ending, no notebook, and one that only two exercises are right of."""
    chain.hand_in(root, "ada", chain.notebook(answer="Because."))
    chain.hand_in(root, "bob", chain.notebook(chain.BLANK))
    chain.hand_in(root, "cleo", chain.notebook(chain.MISTAKES))
    chain.hand_in(root, "dan", chain.notebook({"double": "import os\ndef double(x):\n    os._exit(3)"}))
    chain.hand_in(root, "eve", b"{")
    chain.hand_in(root, "fay", chain.notebook({"double": chain.MISTAKES["double"]}))
    return root


def kept(grades: Path) -> dict[tuple[str, str], dict[str, Any]]:
    """All that the journal says, but for times."""
    with Journal(grades, make=False) as journal:
        return {(each.student, each.lesson): as_json(each) | {"seconds": 0} for each in journal.results()}


def rows(grades: Path, table: str) -> int:
    database = sqlite3.connect(grades / NAME)
    try:
        return database.execute(f"SELECT count(*) FROM {table}").fetchone()[0]
    finally:
        database.close()
