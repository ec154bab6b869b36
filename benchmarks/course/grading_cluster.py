"""How fast Dask workers grade a class: ``python -m benchmarks grading_cluster``.

The same class is graded by this process with two jobs, by one worker with two threads and by two workers with one, each
after a few submissions that nobody times. What 64 workers would grade is calculated, not measured: as many times what
one worker grades, or what the grader's process has the processor time for, whichever is less.
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil

from benchmarks import ROOT, Result, Table
from benchmarks.course.grading import LESSON, lay_out
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.session import Machines, open_session
from nao_course.instructor.collecting.submissions import Submission, gather
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import SubmissionResult

CLASS, FIRST = 300, 12  # submissions that are timed, and those before them that start servers
MACHINES = {
    "this process, 2 jobs": Machines(jobs=2),
    "1 worker with 2 threads": Machines(jobs=2, workers=1),
    "2 workers with 1 thread": Machines(jobs=2, workers=2),
}
MANY_WORKERS = 64
RESULTS = 10_000  # for the journal alone
SECRET = b"any number of letters, the same each time"


def grade(found: Sequence[Submission], machines: Machines, folder: Path) -> dict[str, float]:
    """Grade a class, and measure the time in all and the processor time of the grader's own process."""
    course, process = load_course(ROOT), psutil.Process()
    with open_session(course, [LESSON], SECRET, machines) as session:
        with Journal(folder / "first") as journal:
            session.grade(found[:FIRST], journal, folder / "first" / "feedback")
        before, start = process.cpu_times(), time.monotonic()
        with Journal(folder / "timed") as journal:
            summary = session.grade(found[FIRST:], journal, folder / "timed" / "feedback")
        seconds, after = time.monotonic() - start, process.cpu_times()
    if summary.graded != CLASS:
        raise RuntimeError(f"{summary.graded} of {CLASS} were graded: {summary.failed}")
    own = after.user + after.system - before.user - before.system
    return {
        "seconds": seconds,
        "per minute": 60 * CLASS / seconds,
        "ms a submission": 1000 * seconds / CLASS,
        "grader's processor ms a submission": 1000 * own / CLASS,
    }


def keep(results: Sequence[SubmissionResult], folder: Path) -> float:
    """Return how many results a minute a journal keeps that does nothing else."""
    with Journal(folder) as journal:
        start = time.monotonic()
        for number in range(RESULTS):
            journal.keep(replace(results[number % len(results)], student=f"student{number:05d}"))
        return 60 * RESULTS / (time.monotonic() - start)


def main() -> Result:
    """Grade a class of 300 in three ways, and fill a journal with 10,000 results."""
    with tempfile.TemporaryDirectory(prefix="nao_course_bench_") as name:
        folder = Path(name)
        lay_out(folder / "class", FIRST + CLASS)
        found = gather(folder / "class", folder, [LESSON]).submissions
        runs = {
            title: grade(found, machines, folder / str(number))
            for number, (title, machines) in enumerate(MACHINES.items())
        }
        results = [read(folder / str(number) / "timed") for number in range(len(MACHINES))]
        kept = keep(results[0], folder / "journal")
    local, one, two = runs.values()
    overhead = one["ms a submission"] - local["ms a submission"]
    by_workers = MANY_WORKERS * one["per minute"]
    by_grader = 60_000 / max(each["grader's processor ms a submission"] for each in (one, two))
    calculated = min(by_workers, by_grader, kept)
    values: dict[str, Any] = {
        "submissions": CLASS,
        "cores": os.cpu_count(),
        "runs": runs,
        "overhead ms a submission": overhead,
        "journal alone per minute": kept,
        "64 workers, calculated": {
            "64 times one worker, per minute": by_workers,
            "one core of the grader, per minute": by_grader,
            "per minute": calculated,
        },
        "same results": all(each == results[0] for each in results),
    }
    columns = ("", "per minute", "ms a submission", "grader's processor ms a submission")
    rows = tuple(
        (title, run["per minute"], run["ms a submission"], run["grader's processor ms a submission"])
        for title, run in runs.items()
    )
    notes = (
        f"The journal alone keeps {kept:,.0f} results a minute.",
        f"One worker with two threads takes {overhead:.1f} ms longer for each submission than this process.",
        f"Calculated, not measured: {MANY_WORKERS} workers as fast as one would grade {by_workers:,.0f} a minute, "
        f"one core of the grader can handle {by_grader:,.0f}, so expect {calculated:,.0f}.",
    )
    title = (
        f"lesson 01, start not included; {os.cpu_count()} cores for grader, scheduler and workers together"
    )
    return Result("grading_cluster", values, (Table(title, columns, rows),), notes)


def read(folder: Path) -> list[SubmissionResult]:
    """Return all results of a journal; they are equal if they differ in nothing but the time that they took."""
    with Journal(folder) as journal:
        return journal.results()
