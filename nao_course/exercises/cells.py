"""What a notebook's cells say: their source, and what nbgrader and the course wrote into their metadata."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

SHOWN = (
    "display",
    "example",
    "payoff",
)  # roles of cells that show something; nothing in them is a definition


def metadata(part: Mapping[str, Any], key: str) -> dict[str, Any]:
    """Return what the metadata of a cell or notebook holds under a key.

    Parameters
    ----------
    part : mapping
        A cell or a notebook, as JSON or nbformat gives it; from anyone.
    key : str
        Such as "nbgrader" or "nao_course".

    Returns
    -------
    dict
        Empty where there is none; metadata of another kind say nothing.
    """
    held = part.get("metadata")
    value = held.get(key) if isinstance(held, dict) else None
    return value if isinstance(value, dict) else {}


def grade_id(cell: Mapping[str, Any]) -> str:
    """Return a cell's name for nbgrader; empty where it has none."""
    return str(metadata(cell, "nbgrader").get("grade_id") or "")


def is_solution(cell: Mapping[str, Any]) -> bool:
    """Whether a student writes the cell: an exercise or a written answer."""
    return bool(metadata(cell, "nbgrader").get("solution"))


def is_graded(cell: Mapping[str, Any]) -> bool:
    """Whether the cell earns points: a check or a written answer."""
    return bool(metadata(cell, "nbgrader").get("grade"))


def source_of(cell: Mapping[str, Any]) -> str:
    """Return a cell's text, which a file may hold line by line."""
    text = cell.get("source")
    return "".join(map(str, text)) if isinstance(text, list) else str(text or "")
