"""The three verdicts on a notebook: its own checks in Jupyter, `nao-course check` in a terminal, the grader."""

import contextlib
import io
import json
import os
import sys
from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any
from unittest import mock

from IPython.core.interactiveshell import InteractiveShell
from traitlets.config import Config

from nao_course import student
from nao_course.exercises.cells import SHOWN, grade_id, metadata, source_of
from nao_course.exercises.checking import lesson as open_lesson
from nao_course.exercises.checking import read_public
from nao_course.exercises.judging import Report
from nao_course.student import notebooks
from tests.real_life.notebooks import blank_of


def processes(number: int) -> ProcessPoolExecutor:
    """Return processes that each run one notebook: what it does to its process harms no other."""
    context = get_context("forkserver")
    context.set_forkserver_preload(["tests.real_life.preloaded"])
    return ProcessPoolExecutor(number, context, max_tasks_per_child=1)


def the_shell() -> InteractiveShell:
    return InteractiveShell.instance(config=Config(HistoryManager={"enabled": False}))


def both(path: Path, exercise: str) -> tuple[bool, bool, str]:
    """Return the verdicts in Jupyter and in a terminal, and what the terminal says."""
    passes, said = in_a_terminal(path, exercise)
    return in_jupyter(path, exercise), passes, said


def in_jupyter(path: Path, exercise: str) -> bool:
    """Run a notebook's cells in order as IPython does; return what the exercise's check says."""
    os.chdir(path.parent)
    sys.path.insert(0, str(path.parent))
    sys.stdin = io.StringIO()
    lesson = path.stem
    left_out = {source_of(cell) for cell in blank_of(lesson) if _is_left_out(cell, exercise)}
    shell = the_shell()
    reports: list[Report] = []
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        for cell in json.loads(path.read_bytes())["cells"]:
            source = source_of(cell)
            if cell["cell_type"] != "code" or source in left_out or not source.strip():
                continue
            with contextlib.suppress(SystemExit):
                result = shell.run_cell(source, store_history=True)
                if isinstance(result.result, Report):
                    reports.append(result.result)
        said = [report for report in reports if report.name == exercise]
        if not said and exercise in shell.user_ns:
            check, _ = open_lesson(lesson)
            said = [check(exercise, shell.user_ns[exercise])]
    return any(map(bool, said[-1:]))


def _is_left_out(cell: Mapping[str, Any], exercise: str) -> bool:
    """Return whether a cell only shows something, or checks another exercise: that takes long."""
    role = metadata(cell, "nao_course").get("role")
    return role in SHOWN or (role == "check" and grade_id(cell) != f"check_{exercise}")


def in_a_terminal(path: Path, exercise: str) -> tuple[bool, str]:
    """Return whether `nao-course check` says that an exercise passes, and what else it says of it."""
    os.chdir(path.parent)
    os.environ.pop("NAO_COURSE_STRICT", None)
    lesson = read_public(path.stem)
    only = replace(lesson, exercises=[each for each in lesson.exercises if each.name == exercise])
    with mock.patch.object(
        notebooks, "read_public", lambda name: only if name == path.stem else read_public(name)
    ):
        found = student.functions(path.stem, path.parent)
    said = [line for report in found.reports if report.name == exercise for line in report.lines]
    return exercise in found.right, "\n".join(
        [*said, *(f"cell {each.cell}: {each.reason}" for each in found.skipped)]
    )
