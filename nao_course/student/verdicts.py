"""What the checks said of saved notebooks, kept beside them until one of these is saved again: looking up is quick."""

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

FILE = ".nao_course.json"  # in the folder of the notebooks; who deletes it loses nothing but time
LARGEST = 1_000_000  # bytes; what is written here has some thousand


def kept(notebook: Path, exercise: str) -> str | None:
    """Return what was kept of an exercise in a saved notebook.

    Parameters
    ----------
    notebook : Path
        A lesson's.
    exercise : str
        Its name.

    Returns
    -------
    str or None
        What it lacks, in words; empty where it passes its public checks. None where that is not known, as when this
        notebook, one of an earlier lesson or a helper file was saved since.
    """
    held = _read(notebook.parent).get(notebook.stem)
    if not isinstance(held, dict) or held.get("of") != _state_of(notebook):
        return None
    said = held.get(exercise)
    return said if isinstance(said, str) else None


def keep(notebook: Path, exercise: str, lacking: str) -> None:
    """Keep what an exercise in a saved notebook lacks; where the folder takes no file, nothing happens."""
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
    """A digest of all that a check of this notebook depends on: it, those before it, helpers, and the course."""
    number, folder = number_of(notebook.stem), notebook.parent
    lessons = [path for path in folder.glob(f"{PATTERN}.ipynb") if number_of(path.stem) <= number]
    digest = hashlib.sha256(_version().encode())
    for path in sorted([*lessons, *folder.glob("*.py")]):
        with suppress(OSError):  # it was just taken away
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
