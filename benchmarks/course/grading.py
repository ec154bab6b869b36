"""How fast a class is graded: ``nao-course grade`` on 200 submissions of lesson 01, and how much memory it needs."""

import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import psutil

from benchmarks import ROOT, Result, Table
from nao_course.cli import DEFAULT_JOBS
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.assignment import lessons_used
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import SubmissionResult

LESSON, LATE = "01_hsl_filtering", "11_slam_on_the_field"
CLASS = 200
KINDS = ("right", "half right", "wrong", "right", "blank")  # in turn: a fifth each, the right ones two
WRONG = {  # what students write: a mistake of the catalogue each
    "average_lightness": "return float(lightness.mean())",
    "white_threshold": "return (max_lightness - beta) * mean_lightness / max_lightness",
    "hue_mask": "return (hue >= low) & (hue <= high)",
    "calibrate_hue": "return float(coloured.min() - epsilon), float(coloured.max() + epsilon)",
}
RGB_WRONG = "return 30 * np.zeros(picture.shape[:2]), largest - smallest, lightness"
EVERY = 0.05  # s between two measurements of memory: a notebook is large for a short time only


def notebooks() -> Iterator[tuple[str, str]]:
    """Yield (kind, JSON) of endless different submissions: the student's copy with answers in it."""
    course = load_course(ROOT)
    blank = nbformat.read(ROOT / "notebooks" / f"{LESSON}.ipynb", as_version=4)
    solved = lesson_text.read_lesson(course.text(LESSON))
    answers = {
        lesson_text.exercise_name(cell): cell.source for _, cell in lesson_text.code_cells(solved, "exercise")
    }
    number = 0
    while True:
        kind = KINDS[number % len(KINDS)]
        notebook = nbformat.from_dict(blank)
        for place, (_, cell) in enumerate(lesson_text.code_cells(notebook, "exercise")):
            cell.source = (
                _answer(lesson_text.exercise_name(cell), cell.source, answers, kind, place) + f"\n# {number}"
            )
        yield kind, nbformat.writes(notebook)
        number += 1


def _answer(name: str, stub: str, answers: dict[str, str], kind: str, place: int) -> str:
    if kind == "right" or (kind == "half right" and place % 2 == 0):
        return answers[name]
    if kind == "blank" or name == "color_labels":
        return stub
    return stub.replace("raise NotImplementedError", WRONG.get(name, RGB_WRONG))


def lay_out(folder: Path, many: int) -> None:
    """Write the submissions of a class, and a secret beside them."""
    folder.parent.mkdir(exist_ok=True)
    secret = folder.parent / "secret"
    secret.write_text("any number of letters, the same each time", encoding="utf-8")
    secret.chmod(0o600)
    for number, (_, text) in enumerate(islice(notebooks(), many)):
        path = folder / f"student{number:05d}" / f"{LESSON}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(text, encoding="utf-8")


def grade(
    submissions: Path, grades: Path, jobs: int, *words: str
) -> tuple[dict[str, Any], list[SubmissionResult]]:
    """Run the grading command as an assistant does; return time, peak memory and results.

    `grades` is a new folder beside the class's secret, and `words` are further options.
    """
    words = ("grade", str(submissions), "--out", str(grades), "--jobs", str(jobs), *words)
    secret = {"NAO_COURSE_SECRET": str(grades.parent / "secret")}
    start, seen = time.monotonic(), [(0.0, 0.0)]
    process = subprocess.Popen(
        [sys.executable, "-m", "nao_course.cli", *words],
        cwd=ROOT,
        env={**os.environ, **secret, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        text=True,
    )
    while process.poll() is None:
        seen.append((pss_mb(process.pid), own_mb(process.pid)))
        with suppress(subprocess.TimeoutExpired):
            process.wait(EVERY)
    seconds = time.monotonic() - start
    if process.returncode:
        output = process.stdout.read() if process.stdout else ""
        raise RuntimeError(f"nao-course grade ended with status {process.returncode}: {output}")
    with Journal(grades) as journal:
        results = journal.results()
    peak, own = (float(each) for each in np.max(seen, axis=0))
    found = {
        "submissions": len(results),
        "jobs": jobs,
        "seconds": seconds,
        "per minute": 60 * len(results) / seconds,
    }
    return {**found, "peak PSS MB": peak, "peak PSS MB of the grader itself": own}, results


def pss_mb(pid: int) -> float:
    """Return the memory of a process and its children, shared pages counted once; NaN if it is unknown."""
    try:
        return own_mb(pid) + sum(own_mb(each.pid) for each in psutil.Process(pid).children(recursive=True))
    except psutil.NoSuchProcess:
        return 0.0


def own_mb(pid: int) -> float:
    """Return the memory of one process, with its part of shared pages; 0 if it has just ended."""
    try:
        text = Path(f"/proc/{pid}/smaps_rollup").read_text()
    except OSError:
        return 0.0
    match = re.search(r"^Pss:\s+(\d+)", text, re.MULTILINE)
    return int(match[1]) / 1024 if match else 0.0


def large(folder: Path) -> Iterator[tuple[str, Path, str]]:
    """Write large notebooks: six of lesson 01 with 49.5 MB, and lesson 11 with all that it uses, 48 MB each."""
    course = load_course(ROOT)
    uses = (*lessons_used(course, LATE), LATE)
    texts = [(course.solutions / f"{lesson}.ipynb").read_text(encoding="utf-8") for lesson in uses]
    class_of = [(f"student{number}", LESSON, text) for number, (_, text) in enumerate(islice(notebooks(), 6))]
    late = [("ada", lesson, text) for lesson, text in zip(uses, texts, strict=True)]
    for name, lesson, made, megabytes in (
        ("six of 49.5 MB", LESSON, class_of, 49.5),
        ("lesson 11, eight of 48 MB", LATE, late, 48.0),
    ):
        for student, each, text in made:
            notebook = nbformat.reads(text, as_version=4)
            output = nbformat.v4.new_output("stream", name="stdout", text="")
            next(cell for cell in notebook.cells if cell.cell_type == "code").outputs = [output]
            output.text = "x" * (int(2**20 * megabytes) - len(nbformat.writes(notebook).encode()))
            path = folder / lesson / student / f"{each}.ipynb"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(nbformat.writes(notebook), encoding="utf-8")
        yield name, folder / lesson, lesson.partition("_")[0]


def main() -> Result:
    """Grade a class of 200 with one job, with two and with the default number, and large notebooks with two."""
    with tempfile.TemporaryDirectory(prefix="nao_course_bench_") as name:
        folder, found = Path(name), {}
        lay_out(folder / "class", CLASS)
        for jobs in sorted({1, 2, DEFAULT_JOBS}):
            found[f"{jobs} jobs"], results = grade(folder / "class", folder / f"grades{jobs}", jobs)
        for title, made, number in large(folder / "large"):
            found[title], _ = grade(made, folder / f"grades_{number}", 2, "--lesson", number)
    title = f"lesson 01, a fifth of it blank; sandbox level {results[0].level}; {os.cpu_count()} cores"
    return Result("grading", found, (Table.of(title, found),))
