"""What ten submissions that waste time cost a class of 200: minutes in all, and how long an honest neighbour waits.

``python -m benchmarks slow_students`` grades the class with the command, two jobs, once with ten honest submissions
more and once with the ten slow ones in their place.
"""

from __future__ import annotations

import tempfile
from itertools import islice
from pathlib import Path
from typing import Any

import nbformat
import numpy as np

from benchmarks import ROOT, Result, Table
from benchmarks.course.grading import CLASS, LESSON, grade, notebooks, write_secret
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.gradebook.journal import Journal

JOBS = 2
EVERY_CALL = "def {name}(*args):\n    {body}\n"
SLOW = {  # by kind: what every exercise does, or, where there is no call, what the notebook does besides
    "sleeps": "import time; time.sleep(1000)",
    "nearly too long": "import time; time.sleep(9)",
    "loops": "while True: pass",
    "ends its process": "import os; os._exit(3)",
    "kills itself": "import os; os.kill(os.getpid(), 9)",
    "dies another way each time": "import os, time; os.kill(os.getpid(), (9, 11, 6, 15)[int(time.time()) % 4])",
    "takes all memory": "a = []\n    while True: a.append(bytes(2**24))",
    "forks": "import os\n    while True:\n        try: os.fork()\n        except OSError: pass",
}
BESIDES = {
    "loops before anything": "while True: pass",
    "two megabytes of blanks": "x = '" + " " * 2_000_000 + "'",
}


def lay_out(folder: Path, slow: bool) -> None:
    """Write a class of 200, the ten slow ones, or as many honest ones, spread among them."""
    write_secret(folder.parent)
    kinds = [*SLOW, *BESIDES]
    step = CLASS // len(kinds)
    for number, (_, text) in enumerate(islice(notebooks(), CLASS)):
        if slow and number % step == step // 2:
            text = wasteful(text, kinds[number // step])
        path = folder / f"student{number:05d}" / f"{LESSON}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(text, encoding="utf-8")


def wasteful(text: str, kind: str) -> str:
    """Return the JSON of a notebook whose exercises, or whose first lines, waste time."""
    notebook = nbformat.reads(text, as_version=4)
    cells = [cell for _, cell in lesson_text.code_cells(notebook, "exercise")]
    if kind in BESIDES:
        cells[0].source = BESIDES[kind] + "\n" + cells[0].source
    else:
        for cell in cells:
            cell.source = EVERY_CALL.format(name=lesson_text.exercise_name(cell), body=SLOW[kind])
    return nbformat.writes(notebook)


def measure(slow: bool) -> dict[str, Any]:
    """Grade the class; return the seconds in total, of the normal submissions, and of each slow one."""
    kinds = [*SLOW, *BESIDES]
    step = CLASS // len(kinds)
    with tempfile.TemporaryDirectory(prefix="nao_course_bench_") as name:
        folder = Path(name)
        lay_out(folder / "class", slow)
        run = grade(folder / "class", folder / "grades", JOBS)
        with Journal(folder / "grades") as journal:
            seconds = {int(each.student[-5:]): each.seconds for each in journal.results()}
    wasted = {kinds[n // step]: s for n, s in sorted(seconds.items()) if slow and n % step == step // 2}
    honest = np.array([s for n, s in seconds.items() if not (slow and n % step == step // 2)])
    return {
        "seconds in all": run["seconds in all"],
        "honest median ms": float(1000 * np.median(honest)),
        "honest 95 % ms": float(1000 * np.quantile(honest, 0.95)),
        "honest longest ms": float(1000 * honest.max()),
        "slow ones, s": wasted,
    }


def main() -> Result:
    """Grade a class of 200 with and without ten slow submissions."""
    load_course(ROOT)
    without, among = measure(False), measure(True)
    names = ("seconds in all", "honest median ms", "honest 95 % ms", "honest longest ms")
    rows = tuple((name, f"{without[name]:.0f}", f"{among[name]:.0f}") for name in names)
    slow = tuple((kind, f"{seconds:.1f}") for kind, seconds in among["slow ones, s"].items())
    tables = (
        Table(f"{CLASS} submissions of lesson 01, {JOBS} jobs", ("", "all honest", "ten slow ones"), rows),
        Table("what each of the ten took", ("kind", "s"), slow),
    )
    return Result("slow_students", {"without": without, "with": among}, tables)
