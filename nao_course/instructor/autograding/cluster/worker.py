"""What runs in a Dask worker's process: it is admitted or refused, and grades whole submissions in its own sandbox.

This process is trusted as the grader is, because it compares answers with what is expected. Students' code runs in the
sandboxed processes below it, as it does when one machine grades alone.
"""

from __future__ import annotations

import asyncio
import atexit
import hashlib
import threading
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from nao_course.instructor.autograding.assignment import Assignment, package_digest
from nao_course.instructor.autograding.batch import installed
from nao_course.instructor.autograding.cluster.parcels import AssignmentParcel, SubmissionParcel
from nao_course.instructor.autograding.grader import grade
from nao_course.instructor.autograding.scratch import scratch_folder
from nao_course.instructor.gradebook.records import SubmissionResult
from nao_course.instructor.sandbox.layers import SandboxError, probe
from nao_course.instructor.sandbox.warm_server import WarmServer

if TYPE_CHECKING:
    from distributed import Worker

_UNLIMITED = (
    1e9  # of a worker's resource: its number of threads limits how many submissions it grades at a time
)


@dataclass(frozen=True)
class Requirement:
    """The properties of a worker whose results are the same as on the grader's machine.

    They are the `package_digest` of the course, the versions of Python and of the libraries that scores can depend on,
    and the lowest sandbox level.
    """

    code: str
    versions: str
    level: str

    @classmethod
    def of_this_machine(cls, level: str) -> Requirement:
        """Return the requirement that this machine's course and libraries fulfil."""
        return cls(package_digest(), installed(), level)

    @property
    def resource(self) -> str:
        """Name of the Dask resource that only workers have which fulfil the requirement."""
        told = "\0".join((self.code, self.versions, self.level))
        return f"nao-course-{hashlib.sha256(told.encode()).hexdigest()[:16]}"

    def unfulfilled(self) -> str:
        """Return the reason why this machine does not fulfil the requirement; an empty string if it does."""
        here = Requirement.of_this_machine(self.level)
        if here.versions != self.versions:
            return f"it has {here.versions}, and the grader has {self.versions}"
        if here.code != self.code:
            return "its course differs from the grader's: install the same version and start the worker again"
        try:
            probe().require(self.level)
        except SandboxError as error:
            return f"{error}. Allow it with --require-sandbox {probe().level}"
        return ""


async def admit(requirement: Requirement, dask_worker: Worker) -> str:
    """Let a Dask worker, in whose process this runs, take submissions, or return the reason why it is refused."""
    reason = await asyncio.to_thread(requirement.unfulfilled)
    if not reason and requirement.resource not in dask_worker.state.total_resources:
        await dask_worker.set_resources(**{requirement.resource: _UNLIMITED})
    return reason


# --- grading ---


class _Bench:
    """The folder for temporary files and the warm server of this process, for all runs that it takes part in."""

    def __init__(self) -> None:
        self._lock, self._stack = threading.Lock(), ExitStack()
        atexit.register(self._stack.close)

    @cached_property
    def _folder(self) -> Path:
        return self._stack.enter_context(scratch_folder())

    @cached_property
    def _server(self) -> WarmServer:
        return self._stack.enter_context(WarmServer(probe()))

    def prepare(self, parcel: AssignmentParcel) -> tuple[Assignment, WarmServer]:
        with self._lock:
            return parcel.written_to(self._folder / parcel.assignment.hash), self._server


_BENCH = _Bench()


def grade_parcel(parcel: SubmissionParcel, assignment: AssignmentParcel) -> SubmissionResult:
    """Grade a submission in this process's sandbox, with the same result as `grader.grade` on one machine."""
    prepared, server = _BENCH.prepare(assignment)
    with parcel.laid_out() as submission:
        result = grade(submission, prepared, server, server.sandbox.level)
    return replace(result, file=parcel.submission.file or parcel.submission.path.name)
