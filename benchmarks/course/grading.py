"""How fast a class is graded: ``nao-course grade`` on 200 submissions of lesson 01 beside nbgrader on some of the same.

``python -m benchmarks grading`` runs both, one after the other on the same machine. nbgrader gets as many notebooks as
it can grade in five minutes, at most 20.
``python -m benchmarks.course.grading beside FOLDER`` alternates with another build of the course in FOLDER, such as a
git worktree, and says how busy the machine was; a further number says how often.
``python -m benchmarks.course.grading 5000`` grades that many in one go and says how memory grows; with a second number,
each notebook has stored outputs of so many MB.
"""

from __future__ import annotations

import os
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Any, TypeVar

import nbformat
import numpy as np
import psutil
from rich.console import Console

from benchmarks import ROOT, Result, Table
from nao_course.cli import DEFAULT_JOBS
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.gradebook.journal import Journal

T = TypeVar("T")
LESSON = "01_hsl_filtering"
CLASS, PEERS = 200, 20
PEER_SECONDS = 300.0  # for all notebooks that nbgrader grades
ROUNDS = 2  # of two builds side by side
BESIDE = (5, 45)  # submissions that each of them grades
JOBS_BESIDE = 2
KINDS = ("right", "half right", "wrong", "right", "blank")  # in turn: a fifth each, the right ones two
WRONG = {  # what students write: a mistake of the catalogue each
    "average_lightness": "return float(lightness.mean())",
    "white_threshold": "return (max_lightness - beta) * mean_lightness / max_lightness",
    "hue_mask": "return (hue >= low) & (hue <= high)",
    "calibrate_hue": "return float(coloured.min() - epsilon), float(coloured.max() + epsilon)",
}
RGB_WRONG = "return 30 * np.zeros(picture.shape[:2]), largest - smallest, lightness"
EVERY = 0.5  # s between two measurements of memory


# --- a class ---


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


def lay_out(folder: Path, many: int, megabytes: float = 0.0) -> None:
    """Write the submissions of a class with stored outputs of a size, and a secret beside them."""
    write_secret(folder.parent)
    for number, (_, text) in enumerate(islice(notebooks(), many)):
        path = folder / f"student{number:05d}" / f"{LESSON}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(with_outputs(text, int(2**20 * megabytes)), encoding="utf-8")


def write_secret(folder: Path) -> None:
    """Write the secret that the hidden cases are drawn from, beside a class."""
    folder.mkdir(exist_ok=True)
    secret = folder / "secret"
    secret.write_text("any number of letters, the same each time", encoding="utf-8")
    secret.chmod(0o600)


def with_outputs(text: str, size: int) -> str:
    """Return a notebook with a stored output of some characters."""
    if not size:
        return text
    notebook = nbformat.reads(text, as_version=4)
    cell = next(each for each in notebook.cells if each.cell_type == "code")
    cell.outputs = [nbformat.v4.new_output("stream", name="stdout", text="x" * size)]
    return nbformat.writes(notebook)


# --- ours ---


def watched(
    submissions: Path,
    grades: Path,
    jobs: int,
    measure: Callable[[int], T],
    *words: str,
    every: float = EVERY,
    root: Path = ROOT,
) -> tuple[float, list[tuple[float, T]]]:
    """Run the grading command as an assistant does, and call ``measure`` with its process number every so many seconds.

    Return how long the command ran, s, and the measurements with their times since the start. `grades` is a new folder
    beside the class's secret, `jobs` submissions are graded at a time, `words` are further options, and `root` is the
    course's folder.
    """
    words = ("grade", str(submissions), "--out", str(grades), "--jobs", str(jobs), *words)
    environment = {**os.environ, "NAO_COURSE_SECRET": str(grades.parent / "secret"), "COLUMNS": "200"}
    start = time.monotonic()
    process = subprocess.Popen(
        [sys.executable, "-m", "nao_course.cli", *words],
        cwd=root,
        env=environment | {"PYTHONPATH": str(root)},
        stdout=subprocess.PIPE,
        text=True,
    )
    seen = []
    while process.poll() is None:
        seen.append((time.monotonic() - start, measure(process.pid)))
        with suppress(subprocess.TimeoutExpired):
            process.wait(every)
    seconds = time.monotonic() - start
    output = process.stdout.read() if process.stdout else ""
    if process.returncode:
        raise RuntimeError(f"nao-course grade ended with status {process.returncode}: {output}")
    return seconds, seen


def grade(submissions: Path, grades: Path, jobs: int, root: Path = ROOT) -> dict[str, Any]:
    """Grade a class with the course in a folder, and measure the memory of all processes."""
    seconds, seen = watched(submissions, grades, jobs, lambda pid: (pss_mb(pid), own_mb(pid)), root=root)
    with Journal(grades) as journal:
        results = journal.results()
    each = np.array([result.seconds for result in results]) * 1000
    of_kind = {
        kind: [r.earned for i, r in enumerate(results) if KINDS[i % len(KINDS)] == kind] for kind in KINDS
    }
    return {
        "submissions": len(results),
        "jobs": jobs,
        "seconds in all": seconds,
        "per minute": 60 * len(results) / seconds,
        "median ms": float(np.median(each)),
        "95 % ms": float(np.quantile(each, 0.95)),
        "peak PSS MB": max(mb for _, (mb, _) in seen),
        "peak PSS MB of the grader itself": max(mb for _, (_, mb) in seen),
        "memory": [mb for _, (mb, _) in seen],
        "level": sorted({result.level for result in results}),
        "mean points": {kind: float(np.mean(earned)) for kind, earned in of_kind.items()},
    }


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


# --- the peer ---


def nbgrader(submissions: Path, folder: Path) -> dict[str, float]:
    """Let nbgrader autograde as many of the submissions as its first one allows, without making the assignment."""
    (folder / "source" / LESSON).mkdir(parents=True)
    shutil.copy(ROOT / "solutions" / f"{LESSON}.ipynb", folder / "source" / LESSON)
    environment = {
        **os.environ,
        "PYTHONPATH": str(ROOT),
        "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]]),
    }

    def hand_in(students: list[Path]) -> None:
        for student in students:
            target = folder / "submitted" / student.name / LESSON
            target.mkdir(parents=True)
            shutil.copy(student / f"{LESSON}.ipynb", target)

    def say(*words: str) -> float:
        command = [sys.executable, "-m", "nbgrader", *words, f"--CourseDirectory.root={folder}"]
        start = time.monotonic()
        ran = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
        if ran.returncode:
            raise RuntimeError(
                f"nbgrader {words[0]} ended with status {ran.returncode}: {ran.stderr[-2000:]}"
            )
        return time.monotonic() - start

    say("generate_assignment", LESSON)
    first, *others = sorted(submissions.iterdir())[: PEERS + 1]
    options = (LESSON, "--ExecutePreprocessor.timeout=120")
    hand_in([first])
    chosen = others[: max(1, int(PEER_SECONDS / say("autograde", *options)))]
    hand_in(chosen)
    seconds = say("autograde", *options)  # without the first one, which is graded
    return {"submissions": len(chosen), "seconds in all": seconds, "per minute": 60 * len(chosen) / seconds}


# --- figures ---


def main() -> Result:
    """Grade a class of 200 with one job, with two and with the default number, and some of it with nbgrader."""
    with tempfile.TemporaryDirectory(prefix="nao_course_bench_") as name:
        folder = Path(name)
        lay_out(folder / "class", CLASS)
        ours = {
            jobs: grade(folder / "class", folder / f"grades{jobs}", jobs)
            for jobs in sorted({1, 2, DEFAULT_JOBS})
        }
        peer = nbgrader(folder / "class", folder / "nbgrader")
    for each in ours.values():
        del each["memory"]
    times = ours[DEFAULT_JOBS]["per minute"] / peer["per minute"]
    rows = [
        (f"nao-course, {jobs} jobs", each["submissions"], each["seconds in all"], each["per minute"], each["median ms"],
         each["peak PSS MB"])
        for jobs, each in ours.items()
    ]  # fmt: skip
    rows.append(
        ("nbgrader autograde", peer["submissions"], peer["seconds in all"], peer["per minute"], "", "")
    )
    columns = ("", "submissions", "s in all", "per minute", "median ms", "peak MB")
    title = f"lesson 01, a fifth of it blank; sandbox level {ours[2]['level'][0]}; {os.cpu_count()} cores"
    values = {
        "nao-course": {str(jobs): each for jobs, each in ours.items()},
        "nbgrader": peer,
        "times nbgrader": times,
    }
    notes = (
        f"With {DEFAULT_JOBS} jobs, the default, {times:.0f} times as fast as nbgrader; start, journal and feedback "
        "are included.",
    )
    return Result("grading", values, (Table(title, columns, tuple(rows)),), notes)


def beside(other: Path, rounds: int = ROUNDS) -> Result:
    """Grade a small and a larger class with two builds in turn: the difference is the cost of the further submissions.

    Processor time says most on a machine that does other work, too; the start is not in it.
    """
    rates: dict[str, list[float]] = {"before": [], "now": []}
    each_ms: dict[str, list[float]] = {"before": [], "now": []}
    own_memory: dict[str, list[float]] = {"before": [], "now": []}
    loads = []
    with tempfile.TemporaryDirectory(prefix="nao_course_bench_") as name:
        for many in BESIDE:
            lay_out(Path(name, str(many), "class"), many)
        for build, root in (("before", other), ("now", ROOT)):  # the hidden cases are kept for the other runs
            grade(Path(name, str(BESIDE[0]), "class"), Path(name, str(BESIDE[0]), build), JOBS_BESIDE, root)
        for number in range(rounds):
            for build, root in (("before", other), ("now", ROOT)):
                loads.append(os.getloadavg()[0])
                spent: list[float] = []
                runs: list[dict[str, Any]] = []
                for many in BESIDE:
                    folder, start = Path(name, str(many)), _processor_seconds()
                    runs.append(grade(folder / "class", folder / f"{build}{number}", JOBS_BESIDE, root))
                    spent.append(_processor_seconds() - start)
                each_ms[build].append(1000 * (spent[1] - spent[0]) / (BESIDE[1] - BESIDE[0]))
                rates[build].append(runs[1]["per minute"])
                own_memory[build].append(runs[1]["peak PSS MB of the grader itself"])
    least = {build: min(each) for build, each in each_ms.items()}
    rows = tuple(
        (build, least[build], ", ".join(f"{ms:.0f}" for ms in each_ms[build]), max(rates[build]),
         max(own_memory[build]))
        for build in rates
    )  # fmt: skip
    note = (
        f"By processor time {least['before'] / least['now']:.2f} times as fast as the build before, by the best rates "
        f"{max(rates['now']) / max(rates['before']):.2f} times. The load before the runs was "
        f"{', '.join(f'{load:.1f}' for load in loads)} on {os.cpu_count()} cores."
    )
    table = Table(
        f"{BESIDE[1]} submissions, {JOBS_BESIDE} jobs",
        (
            "build",
            "least ms of a processor for each",
            "all runs",
            "best rate, per minute",
            "grader's peak MB",
        ),
        rows,
    )
    values = {
        "processor ms for each submission": each_ms,
        "per minute, with the start": rates,
        "grader's peak PSS MB": own_memory,
        "load": loads,
    }
    return Result("grading_beside", values, (table,), (note,))


def _processor_seconds() -> float:
    """Return the processor time of all children that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def many(number: int, megabytes: float = 0.0) -> Result:
    """Grade thousands of submissions at once, and measure memory and pace in each fifth of the run."""
    with tempfile.TemporaryDirectory(prefix="nao_course_bench_") as name:
        folder = Path(name)
        lay_out(folder / "class", number, megabytes)
        run = grade(folder / "class", folder / "grades", DEFAULT_JOBS)
    fifths = [float(part.max()) for part in np.array_split(np.array(run.pop("memory")), 5)]
    rows = tuple((f"{20 * i} to {20 * (i + 1)} %", mb) for i, mb in enumerate(fifths))
    values = {**run, "peak PSS MB in each fifth": fifths}
    values["MB of outputs"] = megabytes
    note = (
        f"{number} submissions of {megabytes:g} MB in one go: {run['seconds in all']:.0f} s, {run['per minute']:.0f} a "
        f"minute; the grader itself needs at most {run['peak PSS MB of the grader itself']:.0f} MB."
    )
    return Result(
        "grading_large" if megabytes else "grading_many",
        values,
        (Table("memory", ("part of the run", "peak PSS MB"), rows),),
        (note,),
    )


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    if sys.argv[1:2] == ["beside"]:
        result = beside(Path(sys.argv[2]).resolve(), *map(int, sys.argv[3:]))
    else:
        result = many(int(sys.argv[1]), *map(float, sys.argv[2:])) if len(sys.argv) > 1 else main()
    result.show(Console(width=110))
    result.save()
