"""Stored check results of saved notebooks, which are valid until one of the notebooks is saved again."""

from __future__ import annotations

import hashlib
import json
import os
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from nao_course.exercises.lesson_names import PATTERN, number_of

__all__ = ["FILE", "keep", "kept"]

FILE = ".nao_course.json"  # in the folder of the notebooks; deleting it only costs time
LARGEST = 1_000_000  # bytes; a usual file has a few thousand


def kept(notebook: Path, exercise: str) -> str | None:
    """Return why an exercise in a saved notebook is not ready by its stored result, or an empty text if it passes.

    Return None without a valid result, for example because this notebook, an earlier lesson's notebook or a helper file
    was saved since.
    """
    held = _read(notebook.parent).get(notebook.stem)
    if not isinstance(held, dict) or held.get("of") != _state_of(notebook):
        return None
    said = held.get(exercise)
    return said if isinstance(said, str) else None


def keep(notebook: Path, exercise: str, lacking: str) -> None:
    """Store why an exercise in a saved notebook is not ready; do nothing if the folder is read-only."""
    if not notebook.is_file():
        return
    every, now = _read(notebook.parent), _state_of(notebook)
    held = every.get(notebook.stem)
    held = held if isinstance(held, dict) and held.get("of") == now else {"of": now}
    if held.get(exercise) == lacking:
        return
    every[notebook.stem] = held | {exercise: lacking}
    path = notebook.parent / FILE
    beside = path.with_name(f"{FILE}.{os.getpid()}")
    with suppress(OSError):
        try:
            beside.write_text(json.dumps(every, indent=1) + "\n", encoding="utf-8")
            os.replace(beside, path)
        finally:
            beside.unlink(missing_ok=True)


def _read(folder: Path) -> dict[str, Any]:
    path = folder / FILE
    with suppress(OSError, ValueError, RecursionError):
        if path.is_file() and path.stat().st_size <= LARGEST:
            held = json.loads(path.read_bytes())
            return held if isinstance(held, dict) else {}
    return {}


def _state_of(notebook: Path) -> str:
    """Return a digest of everything that a check depends on: this and earlier notebooks, helpers, and the course."""
    number, folder = number_of(notebook.stem), notebook.parent
    # What is named after no number may be a copy of an earlier lesson.
    lessons = [
        path
        for path in folder.glob("*.ipynb")
        if not path.match(f"{PATTERN}.ipynb") or number_of(path.stem) <= number
    ]
    digest = hashlib.sha256(_version().encode())
    for path in sorted([*lessons, *folder.glob("*.py")]):
        with suppress(OSError):  # the file was just deleted
            found = path.stat()
            digest.update(f"{path.name} {_digest(path, found.st_mtime_ns, found.st_size)}\n".encode())
    return digest.hexdigest()


@lru_cache(maxsize=256)
def _digest(path: Path, changed: int, size: int) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _version() -> str:
    try:
        return version("nao-course")
    except PackageNotFoundError:
        return ""
