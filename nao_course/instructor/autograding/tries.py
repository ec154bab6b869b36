"""The time of a submission, and retries: after an end from outside, or the death of a warm server."""

import contextlib
from collections.abc import Callable, Iterable
from dataclasses import replace

from nao_course.exercises.judging.report import ENDS_PYTHON
from nao_course.instructor.gradebook.records import SubmissionResult
from nao_course.instructor.sandbox.protocol import SECONDS_IN_ALL, Allowance, ServerEnded
from nao_course.instructor.sandbox.warm_server import WarmServer

SECONDS_ONCE_MORE = (
    60.0  # for the student's code with the reference's functions in place of the student's own
)
SECONDS_OF_REFERENCES = 120.0  # for the reference's functions
SECONDS_OF_RECORDED = 10.0  # for finding recorded answers, in the grader's own process
MOST_SERVERS = 3  # that may die under one submission
SERVER_ENDED = (
    "its code, or a lack of memory, ended the process that starts students' code. "
    "If it was the memory, grade the submission again with `nao-course regrade`"
)
MOST_TRIES = 4  # at a submission whose processes are ended
LOADING = "loading the notebook"  # what also has a share of a submission's time
NOT_RUN = "Not run, because "  # how the reason begins
NO_TIME_TO_LOAD = "there is no time left to load the notebook"


class Shares(dict[str, Allowance]):
    """Time that some exercises share fairly: half of it is divided among them, the rest is for who needs it first.

    What one exercise uses up therefore never takes the share of another.
    """

    def __init__(self, seconds: float, names: Iterable[str]) -> None:
        names, common = list(names), Allowance(seconds / 2)
        super().__init__((name, Allowance(seconds / 2 / len(names), common)) for name in names)


class Allowances:
    """Time that grading one submission may take, all tries together.

    `own` is for the student's code and for loading it, `again` for the student's code with the reference's functions,
    `references` for the reference's functions, which the student's code may call in place of earlier exercises, and
    `recorded` for looking up recorded answers, which may replace earlier exercises in public cases.
    """

    def __init__(self, names: Iterable[str]) -> None:
        names = list(names)
        self.own = Shares(SECONDS_IN_ALL, [LOADING, *names])
        self.own[LOADING].reason = NO_TIME_TO_LOAD
        self.again = Shares(SECONDS_ONCE_MORE, [LOADING, *names])
        self.references = Shares(SECONDS_OF_REFERENCES, [LOADING, *names])
        self.recorded = Shares(SECONDS_OF_RECORDED, [LOADING, *names])


def not_run(shares: Shares) -> str:
    """Say that an exercise was not run, and what used most of the time."""
    largest = max(shares, key=lambda name: shares[name].total)
    return f"{NOT_RUN}{largest} used up the time of the submission ({SECONDS_IN_ALL:g} s for all exercises)."


def retry_until_stable(work: Callable[[bool], tuple[SubmissionResult, int]]) -> SubmissionResult:
    """Grade until nobody outside may have ended a process, or two tries agree: what is a submission's own recurs.

    `work` is called with True for a retry, and returns the result and the number of processes that may have been ended.
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


def retry_on_server_death(
    work: Callable[[WarmServer | None], tuple[SubmissionResult, int]], server: WarmServer | None
) -> tuple[SubmissionResult, int]:
    """Start again if the warm server died, with a server of the submission's own: another one may have ended it.

    Raise ServerEnded if its own server died, too; the message is the reason why it is refused.
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
