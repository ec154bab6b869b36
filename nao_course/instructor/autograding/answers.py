"""Fingerprints of a student's answers to the exercises, so that people's decisions belong to them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from nao_course.exercises.definitions import read_cells
from nao_course.instructor.gradebook.records import ExerciseResult, fingerprint


def with_answers(exercises: Iterable[ExerciseResult], notebook: Path) -> tuple[ExerciseResult, ...]:
    """Return results with the fingerprint of all cells that define the exercise, or that assign to its name.

    Other changes in the notebook change nothing. Without such a cell, the fingerprint stays empty.
    """
    cells: list[str] = []
    with suppress(ValueError):
        cells = [source for _, source in read_cells(notebook)]
    return tuple(replace(each, answer=_answer(each.name, cells)) for each in exercises)


def _answer(name: str, cells: Iterable[str]) -> str:
    word = re.escape(name)
    defines = re.compile(rf"^[ \t]*+(?:(?:(?:async +)?def|class) +{word}\b|{word} *(?::|=(?!=)))", re.M)
    own = [cell for cell in cells if defines.search(cell)]
    return fingerprint("\n".join(own)) if own else ""
