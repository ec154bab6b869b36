"""How fast Dask workers grade a class: ``python -m benchmarks grading_cluster``.

The same class is graded by this process with two jobs, by one worker with two threads and by two workers with one, in
turn. The fastest of some rounds counts, because other programs only make a round slower. What 64 workers would grade is
calculated from processor times, not measured: 64 times what one core grades, or what one core of the grader can send
and keep, whichever is less. The latter is measured with workers that answer at once.
"""

import os
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

import psutil

from benchmarks import ROOT, Result, Table
from benchmarks.course.grading import LESSON, lay_out
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.cluster import dispatch
from nao_course.instructor.autograding.cluster.parcels import AssignmentParcel, SubmissionParcel
from nao_course.instructor.autograding.cluster.worker import grade_parcel
from nao_course.instructor.autograding.session import Machines, Session, open_session
from nao_course.instructor.collecting.submissions import Submission, gather
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import SubmissionResult

CLASS, FIRST, ROUNDS = 60, 6, 2  # submissions of a round, submissions that start servers before, rounds
MACHINES = {
    "this process, 2 jobs": Machines(jobs=2),
    "1 worker with 2 threads": Machines(jobs=2, workers=1),
    "2 workers with 1 thread": Machines(jobs=2, workers=2),
}
MANY_WORKERS = 64
AT_ONCE = 300  # submissions that are answered at once
RESULTS = 10_000  # for the journal alone
_FIRST_RESULT: list[SubmissionResult] = []  # of a worker's process
SECRET = b"any number of letters, the same each time"


def grade(session: Session, found: Sequence[Submission], folder: Path) -> dict[str, float]:
    """Grade a class, and measure the time and the processor time, in all and of the grader's own process."""
    before, start = processor_seconds(), time.monotonic()
    with Journal(folder) as journal:
        summary = session.grade(found, journal, folder / "feedback")
    seconds, after = time.monotonic() - start, processor_seconds()
    if summary.graded != len(found):
        raise RuntimeError(f"{summary.graded} of {len(found)} were graded: {summary.failed}")
    own, everything = (1000 * (new - old) / len(found) for new, old in zip(after, before, strict=True))
    return {
        "seconds": seconds,
        "per minute": 60 * len(found) / seconds,
        "ms a submission": 1000 * seconds / len(found),
        "processor ms a submission": everything,
        "grader's processor ms a submission": own,
    }


def processor_seconds() -> tuple[float, float]:
    """Return the processor time of this process, and the sum over it and all processes that it has started."""
    own, everything = 0.0, 0.0
    for process in (here := psutil.Process(), *here.children(recursive=True)):
        with suppress(psutil.NoSuchProcess):
            times = process.cpu_times()
            everything += times.user + times.system + times.children_user + times.children_system
            own += times.user + times.system if process == here else 0.0
    return own, everything


def answer_at_once(parcel: SubmissionParcel, assignment: AssignmentParcel) -> SubmissionResult:
    """Return what a worker found for its first submission, in place of grading another one."""
    if not _FIRST_RESULT:
        _FIRST_RESULT.append(grade_parcel(parcel, assignment))
    return replace(_FIRST_RESULT[0], student=parcel.submission.student)


def keep(results: Sequence[SubmissionResult], folder: Path) -> float:
    """Return how many results a minute a journal keeps that does nothing else."""
    with Journal(folder) as journal:
        start = time.monotonic()
        for number in range(RESULTS):
            journal.keep(replace(results[number % len(results)], student=f"student{number:05d}"))
        return 60 * RESULTS / (time.monotonic() - start)


def main() -> Result:
    """Grade a class in this process and with Dask, let workers answer at once, and fill a journal."""
    with tempfile.TemporaryDirectory(prefix="nao_course_bench_") as name, ExitStack() as stack:
        folder, course = Path(name), load_course(ROOT)
        lay_out(folder / "class", FIRST + CLASS)
        found = gather(folder / "class", folder, [LESSON]).submissions
        sessions = {
            title: stack.enter_context(open_session(course, [LESSON], SECRET, machines))
            for title, machines in MACHINES.items()
        }
        rounds: dict[str, list[dict[str, float]]] = {title: [] for title in MACHINES}
        for title, session in sessions.items():
            grade(session, found[:FIRST], folder / "first" / title)
        for number in range(ROUNDS):
            for title, session in sessions.items():
                rounds[title].append(grade(session, found[FIRST:], folder / str(number) / title))
        with patch.object(dispatch, "grade_parcel", answer_at_once):
            many = [replace(found[i % len(found)], student=f"s{i}") for i in range(FIRST + AT_ONCE)]
            grade(session, many[:FIRST], folder / "first answers")
            at_once = grade(session, many[FIRST:], folder / "answers")
        with Journal(folder / "0" / title) as journal:
            kept = keep(journal.results(), folder / "journal")
    runs = {title: min(each, key=lambda run: run["seconds"]) for title, each in rounds.items()}
    own, every = "grader's processor ms a submission", "processor ms a submission"
    local, one, _ = runs.values()
    by_one, by_grader = 60_000 / (one[every] - one[own]), 60_000 / at_once[own]
    values: dict[str, Any] = {
        "submissions": CLASS,
        "cores": os.cpu_count(),
        "fastest rounds": runs,
        "workers that answer at once": at_once,
        "overhead, processor ms a submission": one[every] - local[every],
        "journal alone per minute": kept,
        f"{MANY_WORKERS} workers, calculated": {
            f"{MANY_WORKERS} workers with a core each, per minute": MANY_WORKERS * by_one,
            "one core of the grader, per minute": by_grader,
            "per minute": min(MANY_WORKERS * by_one, by_grader, kept),
            "workers with a core each that one grader keeps busy": by_grader / by_one,
        },
    }
    calculated = {name: {"": each} for name, each in values[f"{MANY_WORKERS} workers, calculated"].items()}
    tables = (
        Table.of("lesson 01, start not included", runs | {"2 workers that answer at once": at_once}),
        Table.of("calculated, not measured", calculated),
    )
    notes = tuple(f"{name}: {each:,.1f}" for name, each in values.items() if isinstance(each, float))
    return Result("grading_cluster", values, tables, notes)
