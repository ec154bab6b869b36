"""What a run of the grader needs before its first submission: prepared assignments, a tried sandbox, a warm server."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from multiprocessing import get_context, parent_process
from pathlib import Path

from nao_course.instructor.authoring.course import Course
from nao_course.instructor.autograding.assignment import Assignment, prepare
from nao_course.instructor.autograding.batch import Summary, feedback_writer, grade_all
from nao_course.instructor.collecting.submissions import Submission
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.sandbox.layers import SandboxError, probe
from nao_course.instructor.sandbox.warm_server import WarmServer


@dataclass(frozen=True)
class Session:
    """A run of the grader, ready for submissions.

    Parameters
    ----------
    assignments : mapping of str to Future of Assignment
        By lesson.
    server : WarmServer
        Whose workers run students' code.
    """

    assignments: Mapping[str, Future[Assignment]]
    server: WarmServer

    def grade(
        self,
        submissions: Sequence[Submission],
        journal: Journal,
        feedback: Path,
        jobs: int,
        tell: Callable[[Submission], None] = lambda submission: None,
    ) -> Summary:
        """Grade submissions into a journal and a folder of feedback pages.

        Parameters
        ----------
        submissions : sequence of Submission
            Of the lessons of this session.
        journal : Journal
            What it has already is not graded again.
        feedback : Path
            Where the pages go.
        jobs : int
            How many are graded at a time.
        tell : callable
            Called with each submission that is done.

        Returns
        -------
        Summary
            What was done.
        """
        return grade_all(
            submissions,
            lambda lesson: self.assignments[lesson].result(),
            journal,
            jobs=jobs,
            server=self.server,
            level=self.server.sandbox.level,
            publish=feedback_writer(journal, feedback),
            tell=tell,
        )


@contextmanager
def open_session(
    course: Course,
    lessons: Sequence[str],
    secret: bytes,
    require_sandbox: str = "",
    say: Callable[[str], object] = lambda line: None,
) -> Iterator[Session]:
    """Begin to prepare assignments, try the sandbox meanwhile, and start the server of its workers.

    Parameters
    ----------
    course : Course
        Built.
    lessons : sequence of str
        Whole names.
    secret : bytes
        The instructor's.
    require_sandbox : str
        The lowest level to run at; any where empty.
    say : callable
        Called with the level of the sandbox.

    Yields
    ------
    Session
        To grade with; its server ends with the block.

    Raises
    ------
    ValueError
        If the sandbox is weaker than what is required, or than it was when it was tried.
    """
    assignments = prepare_in_background(course, lessons, secret)
    sandbox = probe()
    say(str(sandbox))
    try:
        if require_sandbox:
            sandbox.require(require_sandbox)
        with WarmServer(sandbox) as server:
            yield Session(assignments, server)
    except SandboxError as error:
        raise ValueError(str(error)) from None


def prepare_in_background(
    course: Course, lessons: Sequence[str], secret: bytes
) -> dict[str, Future[Assignment]]:
    """Begin to prepare assignments in a process that ends: what solutions import is not held while grading."""
    pool = ProcessPoolExecutor(1, get_context("spawn"), _end_with_the_grader)
    begun = {lesson: pool.submit(prepare, course, lesson, secret) for lesson in lessons}
    pool.shutdown(wait=False)
    return begun


def _end_with_the_grader() -> None:
    """Leave Ctrl-C to the grader, and end this process if the grader is killed, which cannot end it itself."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_wait_for_the_grader, daemon=True).start()


def _wait_for_the_grader() -> None:
    if grader := parent_process():
        grader.join()
        os._exit(1)
