"""What a run of the grader needs before its first submission: prepared assignments, a tried sandbox, a warm server."""

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
from nao_course.instructor.autograding.batch import Summary, Workers, feedback_writer, grade_all
from nao_course.instructor.collecting.submissions import Submission
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.sandbox.layers import LEVELS, SandboxError, check_level, probe
from nao_course.instructor.sandbox.warm_server import WarmServer


@dataclass(frozen=True)
class Machines:
    """Where submissions are graded, and how many at a time; a scheduler's workers have their own number.

    `require_sandbox` is the lowest sandbox level; if it is empty, this machine may have any, and workers of a cluster
    need this machine's. Submissions are graded by workers of the Dask `scheduler` at this address, by this number of
    Dask `workers` on this machine, or without both by this process.
    """

    jobs: int = 1
    require_sandbox: str = ""
    scheduler: str = ""
    workers: int = 0


@dataclass(frozen=True)
class Session:
    """A run of the grader, ready for submissions.

    Without `workers` of a cluster, `jobs` submissions are graded at a time in processes of the server.
    """

    assignments: Mapping[str, Future[Assignment]]
    jobs: int = 1
    server: WarmServer | None = None
    workers: Workers | None = None

    def grade(
        self,
        submissions: Sequence[Submission],
        journal: Journal,
        feedback: Path,
        tell: Callable[[Submission], None] = lambda submission: None,
    ) -> Summary:
        """Grade submissions into a journal and a folder of feedback pages.

        Results that the journal has already are not computed again; `tell` is called with each submission that is done.
        """
        return grade_all(
            submissions,
            lambda lesson: self.assignments[lesson].result(),
            journal,
            jobs=self.jobs,
            server=self.server,
            level=self.server.sandbox.level if self.server else LEVELS[0],
            workers=self.workers,
            publish=feedback_writer(journal, feedback),
            tell=tell,
        )


@contextmanager
def open_session(
    course: Course,
    lessons: Sequence[str],
    secret: bytes,
    machines: Machines = Machines(),
    say: Callable[[str], object] = lambda line: None,
) -> Iterator[Session]:
    """Begin to prepare assignments, try the sandbox meanwhile, and start or find what runs students' code.

    The lessons are whole names of a course that is built. `say` is called with the level of the sandbox, and with lines
    about workers. The server and the workers that were started end with the block. Raise a ValueError if the sandbox is
    weaker than what is required, or than it was when it was tried, or a cluster cannot be used, and a
    ModuleNotFoundError if Dask is needed and not installed.
    """
    elsewhere = machines.scheduler or machines.workers
    if elsewhere:
        from nao_course.instructor.autograding.cluster.dispatch import open_cluster
    assignments = prepare_in_background(course, lessons, secret)
    sandbox = probe()
    say(str(sandbox))
    try:
        if elsewhere:
            level = machines.require_sandbox or sandbox.level
            check_level(level)
            with open_cluster(
                level, scheduler=machines.scheduler, workers=machines.workers, jobs=machines.jobs, say=say
            ) as cluster:
                yield Session(assignments, workers=cluster)
            return
        if machines.require_sandbox:
            sandbox.require(machines.require_sandbox)
        with WarmServer(sandbox) as server:
            yield Session(assignments, machines.jobs, server)
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
