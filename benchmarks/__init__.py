"""Measurements that the course's claims rest on: ``python -m benchmarks`` runs all of them.

Each folder holds the benchmarks of one subject and the modules that they share.
"""

from __future__ import annotations

import json
import platform
import shutil
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cache
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import track
from rich.table import Table as RichTable

ROOT = Path(__file__).resolve().parents[1]
RESULTS = Path(__file__).resolve().parent / "results"
BUILD = ROOT / "build"  # ignored by git: for figures that hold recorded pictures


@dataclass(frozen=True)
class Table:
    """A table to show: a title, the columns' heads, and rows of as many cells."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[object, ...], ...]

    @classmethod
    def of(cls, title: str, found: Mapping[str, Mapping[str, Any]], *columns: str, shown: str = "") -> Table:
        """Lay out values by row and column, some of the columns or all of them; `shown` is a format of numbers."""
        names = columns or tuple(next(iter(found.values())))
        cells = (
            (row, *(format(of[name], shown) if name in of else "" for name in names))
            if shown
            else (row, *(of.get(name, "") for name in names))
            for row, of in found.items()
        )
        return cls(title, ("", *names), tuple(cells))


@dataclass(frozen=True)
class Result:
    """What one benchmark's ``main()`` returns: its name, also of the JSON file, and what it measured.

    `values` holds everything that was measured, as JSON can; it has no dates, so that it changes only when a figure
    does. `tables` and the `notes` below them are shown to a reader.
    """

    name: str
    values: dict[str, Any]
    tables: tuple[Table, ...]
    notes: tuple[str, ...] = ()

    def show(self, console: Console) -> None:
        """Print the tables and notes; a table that is wider than the terminal keeps its lines."""
        window = console.width
        for table in self.tables:
            shown = RichTable(title=table.title, title_justify="left", title_style="bold")
            for i, column in enumerate(table.columns):
                shown.add_column(column, justify="left" if i == 0 else "right", no_wrap=True)
            for row in table.rows:
                shown.add_row(*(f"{cell:.2f}" if isinstance(cell, float) else str(cell) for cell in row))
            console.width = 10_000
            console.print(shown)
            console.width = window
        for note in self.notes:
            console.print(note, highlight=False)

    def save(self, folder: Path = RESULTS) -> Path:
        """Write the values to ``folder/name.json``, floats rounded to what was measured."""
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / f"{self.name}.json"
        path.write_text(
            json.dumps(_rounded(self.values, lambda x: round(x, 4)), indent=2, allow_nan=False) + "\n",
            encoding="utf-8",
        )
        return path


@cache
def solution(lesson: str) -> Mapping[str, Any]:
    """Return what the solution of a lesson defines, by the lesson's number, such as "07"."""
    from nao_course.instructor.authoring.plans import load_solution

    (path,) = (ROOT / "solutions").glob(f"{lesson}_*.ipynb")
    return load_solution(path)


def in_processes(run: Callable[[Any], Any], given: Sequence[Any], title: str, jobs: int = 2) -> list[Any]:
    """Call a function for each item in a few processes, with a progress bar; the results are in the items' order."""
    with ProcessPoolExecutor(jobs, get_context("spawn"), _on_one_core) as pool:
        return list(track(pool.map(run, given), title, len(given)))


def _on_one_core() -> None:
    import cv2

    cv2.setNumThreads(1)


def digits(value: Any, count: int = 3) -> Any:
    """Round every float in a JSON value to some significant digits."""
    return _rounded(value, lambda x: float(f"{x:.{count}g}"))


def _rounded(value: Any, each: Callable[[float], float]) -> Any:
    """Round every float in a JSON value."""
    if isinstance(value, dict):
        return {str(key): _rounded(item, each) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item, each) for item in value]
    return each(float(value)) if isinstance(value, float) else value


def write_json(path: Path, value: Any, indent: int | None = None) -> None:
    """Write what a lesson's figure reads."""
    path.write_text(json.dumps(value, indent=indent) + "\n", encoding="utf-8")


def chromium() -> str:
    """Return the path of this machine's Chromium."""
    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if found is None:
        raise FileNotFoundError(
            "there is no Chromium on this machine (on Debian and Ubuntu: apt install chromium)"
        )
    return found


def processor() -> str:
    """Return the name of this machine's processor."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    return next((line.split(": ")[1] for line in lines if line.startswith("model name")), platform.machine())
