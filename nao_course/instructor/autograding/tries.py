"""What gets a second try: a time-out, a process that somebody else may have ended, a warm server that died."""

from __future__ import annotations

import contextlib
import threading
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from nao_course.exercises.judging.report import ENDS_PYTHON
from nao_course.instructor.gradebook.records import SubmissionResult
from nao_course.instructor.sandbox.protocol import ServerEnded

SECOND_CHANCES = 300.0  # seconds of a run that time-outs get besides
MOST_SERVERS = 3  # that may die under one submission
MOST_TRIES = 4  # at a submission whose processes are ended


@dataclass
class SecondChances:
    """Time that a run has for calls that took too long, because the machine may have been busy.

    Parameters
    ----------
    seconds : float
        Spent by calls that take too long once more; who is only slow gives them back.
    least : float
        That a second chance lasts; at least twice as long as the first.
    """

    seconds: float = SECOND_CHANCES
    least: float = 10.0
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False, repr=False)

    def take(self, seconds: float) -> float:
        """How long a call that had some seconds may be tried again; 0 where that much is not left."""
        wanted = max(2 * seconds, self.least)
        with self._lock:
            granted = wanted if wanted <= self.seconds else 0.0
            self.seconds -= granted
        return granted

    def give_back(self, seconds: float) -> None:
        """Return what a call was granted that only needed a little longer."""
        with self._lock:
            self.seconds += seconds


def until_agreed(work: Callable[[bool], tuple[SubmissionResult, int]]) -> SubmissionResult:
    """Grade until nobody outside may have ended a process, or two tries agree: what is a submission's own recurs.

    Parameters
    ----------
    work : callable
        Told whether it is not the first time; returns the result and how many processes may have been ended so.
    """
    first, deaths = work(False)
    result = first
    for _ in range(MOST_TRIES - 1):
        if not deaths:
            break
        before = result
        again, deaths = work(True)
        result = as_told_before(again, first)
        if _verdicts(result) == _verdicts(before):
            break
    return result


def _verdicts(result: SubmissionResult) -> list[tuple[str, str, float]]:
    return [(each.name, each.state, each.earned) for each in result.exercises]


def as_told_before(second: SubmissionResult, first: SubmissionResult) -> SubmissionResult:
    """A further try's result with what the first said of public cases: a second one may know hidden inputs by then.

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
    work: Callable[[], tuple[SubmissionResult, int]],
) -> tuple[SubmissionResult, int]:
    """Begin again where the warm server died: that is no fault of this submission, as far as anyone can tell."""
    for _ in range(MOST_SERVERS - 1):
        with contextlib.suppress(ServerEnded):
            return work()
    return work()
