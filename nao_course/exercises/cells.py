"""The source, the metadata and the role of a notebook's cells."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

# Roles of cells that only display something and define nothing.
SHOWN = ("display", "example", "payoff")
# Roles of cells that the grader does not run, and of all cells that are as they were released. A cell with any other
# role, also an unknown one, is the student's. Of the set-up, the grader runs the imports.
NOT_RUN = ("check", "written", *SHOWN)
GIVEN = ("setup", *NOT_RUN)
_DEFINES = re.compile(r"^[ \t]*+(?:async[ ]+)?(?:def|class)[ ]", re.MULTILINE)


def metadata(part: Mapping[str, Any], key: str) -> dict[str, Any]:
    """Return the metadata of a cell or notebook from any source under a key, such as "nbgrader"; empty without any."""
    held = part.get("metadata")
    value = held.get(key) if isinstance(held, dict) else None
    return value if isinstance(value, dict) else {}


def grade_id(cell: Mapping[str, Any]) -> str:
    """Return a cell's name for nbgrader; empty without a name."""
    return str(metadata(cell, "nbgrader").get("grade_id") or "")


def cell_id(cell: Mapping[str, Any]) -> str:
    """Return a cell's id, which some editors keep in the metadata; empty without one."""
    held = cell.get("metadata")
    found = cell.get("id") or (held.get("id") if isinstance(held, dict) else "")
    return found if isinstance(found, str) else ""


def is_solution(cell: Mapping[str, Any]) -> bool:
    """Return whether a student writes the cell: an exercise or a written answer."""
    return bool(metadata(cell, "nbgrader").get("solution"))


def is_graded(cell: Mapping[str, Any]) -> bool:
    """Return whether the cell earns points: a check or a written answer."""
    return bool(metadata(cell, "nbgrader").get("grade"))


def stated_role(cell: Mapping[str, Any]) -> str:
    """Return the role that a cell's metadata state: "solution" or one of `GIVEN`; empty if they state none."""
    if is_solution(cell):
        is_code = cell.get("cell_type") == "code" and _DEFINES.search(source_of(cell))
        return "written" if is_graded(cell) and not is_code else "solution"
    if is_graded(cell):
        return "check"
    role = metadata(cell, "nao_course").get("role")
    if role == "exercise":
        return "solution"
    return role if isinstance(role, str) and role in GIVEN else ""


def source_of(cell: Mapping[str, Any]) -> str:
    """Return a cell's text, which a file may store as a list of lines."""
    text = cell.get("source")
    return "".join(map(str, text)) if isinstance(text, list) else str(text or "")
