"""The time of a submission, and retries: after a time-out, an end from outside, or the death of a warm server."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from nao_course.exercises.judging.report import ENDS_PYTHON
from nao_course.instructor.gradebook.records import SubmissionResult
from nao_course.instructor.sandbox.protocol import Allowance, ServerEnded
from nao_course.instructor.sandbox.warm_server import WarmServer

SECONDS_OF_A_SUBMISSION = 130.0  # from its first cell to its result, whatever its code asks for
SECONDS_OF_RECORDED = 10.0  # for finding recorded answers, in the grader's own process
RETRY_SECONDS = 300.0  # seconds of a run for retries after time-outs, besides one retry of each submission
MOST_SERVERS = 3  # that may die under one submission
SERVER_ENDED = (
    "its code, or a lack of memory, ended the process that starts students' code. "
    "If it was the memory, grade the submission again with `nao-course regrade`"
)
MOST_TRIES = 4  # at a submission whose processes are ended


class Allowances:
    """Time that grading one submission may take, all tries together, counted from now.

    Attributes
    ----------
    own : Allowance
        For the student's code.
    references : Allowance
        For the reference's functions, which the student's code may call in place of earlier exercises.
    recorded : Allowance
        For looking up recorded answers, which may stand in for earlier exercises in public cases.
    """

    def __init__(self) -> None:
        until = time.monotonic() + SECONDS_OF_A_SUBMISSION
        self.own, self.references = Allowance(until=until), Allowance(until=until)
        self.recorded = Allowance(SECONDS_OF_RECORDED, until)
        self.retried_in_vain = False  # a call timed out twice: no other call of the submission is retried


@dataclass
class Retries:
    """Time that a run has for calls that took too long, because the machine may have been busy.

    Parameters
    ----------
    seconds : float
        Used by calls that take too long again; a call that is only slow gives them back.
    least : float
        Time limit of a retry, unless twice the call's own limit is more.
    """

    seconds: float = RETRY_SECONDS
    least: float = 10.0
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False, repr=False)

    def wanted(self, seconds: float) -> float:
        """Return the time limit for retrying a call whose own limit is `seconds`."""
        return max(2 * seconds, self.least)

    def take(self, seconds: float) -> float:
        """Return the time limit for retrying a call; 0 if the remaining time is too short."""
        wanted = self.wanted(seconds)
        with self._lock:
            granted = wanted if wanted <= self.seconds else 0.0
            self.seconds -= granted
        return granted

    def begin(self, longest: float) -> None:
        """Add the time of one retry for another submission, so that its retry in vain takes nothing from the others.

        Parameters
        ----------
        longest : float
            The longest time limit of a call of its exercises, s.
        """
        self.give_back(self.wanted(longest))

    def give_back(self, seconds: float) -> None:
        """Return what a call was granted that only needed a little longer."""
        with self._lock:
            self.seconds += seconds


def until_agreed(work: Callable[[bool], tuple[SubmissionResult, int]]) -> SubmissionResult:
    """Grade until nobody outside may have ended a process, or two tries agree: what is a submission's own recurs.

    Parameters
    ----------
    work : callable
        Called with True for a retry; returns the result and the number of processes that may have been ended.
    """
    first, deaths = work(False)
    result = first
    for _ in range(MOST_TRIES - 1):
        if not deaths:
            break
        before = result
        again, deaths = work(True)
        result = with_first_report(again, first)
        if _verdicts(result) == _verdicts(before):
            break
    return result


def _verdicts(result: SubmissionResult) -> list[tuple[str, str, float]]:
    return [(each.name, each.state, each.earned) for each in result.exercises]


def with_first_report(second: SubmissionResult, first: SubmissionResult) -> SubmissionResult:
    """Return a retry's result with the first try's report of public cases: a retry may know hidden inputs.

    Where the first was ended in them, it said nothing else.
    """
    before = {each.name: each for each in first.exercises}
    told = []
    for each in second.exercises:
        said = before[each.name]
        # Nothing that a student's code says can begin a report like this.
        ended = any(line.startswith(f"{each.number} {each.name}: {ENDS_PYTHON}") for line in said.public[:1])
        told.append(
            each
            if each.state == "right" or ended
            else replace(each, public=said.public, hint=said.hint, mistake=said.mistake)
        )
    return replace(second, exercises=tuple(told))


def in_spite_of_the_server(
    work: Callable[[WarmServer | None], tuple[SubmissionResult, int]], server: WarmServer | None
) -> tuple[SubmissionResult, int]:
    """Start again if the warm server died, with a server of the submission's own: another one may have ended it.

    Raises
    ------
    ServerEnded
        If its own server died, too; the message is the reason why it is refused.
    """
    try:
        return work(server)
    except ServerEnded:
        if server is None:
            raise
    with WarmServer(server.sandbox, server.bounds) as own:
        for _ in range(MOST_SERVERS - 1):
            with contextlib.suppress(ServerEnded):
                return work(own)
    raise ServerEnded(SERVER_ENDED)
