"""Running a student's entry on the cases of a challenge: whatever it does, each case has a score or a sentence."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Hashable
from functools import partial
from typing import Any

from nao_course.challenges.declaration import CaseResult, CaseScore, Challenge, Run
from nao_course.challenges.progress import Progress
from nao_course.exercises.codec import CodecError, encode
from nao_course.time_limits import TooSlow
from nao_course.widgets.attempts import Attempt, attempt

WHOSE = "your entry"  # in messages
JUDGING = 20.0  # s for looking at one answer: more than any honest one needs

MOST_LATE = 3  # cases in a row that end by the clock: then the entry is given up
TIME_IS_UP = "Time is up"  # how what is said of such a case begins
_NUMBERS = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")  # what may differ where an error is the same


def run(challenge: Challenge, entry: Any, progress: Progress | None = None) -> Run:
    """Run an entry on all cases of a challenge.

    Parameters
    ----------
    challenge : Challenge
        Which one.
    entry : callable or object
        The student's: a function of what is given, or the answer itself where the challenge takes that.
    progress : Progress, optional
        What is told of each case that is done.

    Returns
    -------
    Run
        Never an exception, not even when it is interrupted: then `stopped` says so.
    """
    if refused := _refusal(challenge, entry):
        return Run(challenge, (), refused)
    results: list[CaseResult] = []
    left = challenge.seconds_in_all
    for seed in challenge.seeds:
        try:
            result, took, unwritten = _case(challenge, entry, seed, left)
        except KeyboardInterrupt:
            done = f"{len(results)} of {len(challenge.seeds)} {challenge.case}s"
            return Run(challenge, tuple(results), f"Interrupted after {done}: there is no score.")
        if unwritten:
            return Run(challenge, (), f"Not written yet: {WHOSE} calls an exercise that is still blank.")
        left -= took
        results.append(result)
        if why := _always_late(results) or _always_wrong(results, challenge.case):
            done = f"{len(results)} of {len(challenge.seeds)} {challenge.case}s"
            return Run(challenge, tuple(results), f"Given up after {done}, with no score: {why}")
        if progress:
            progress.step()
    if all(each.message for each in results):
        return Run(
            challenge,
            tuple(results),
            f"No {challenge.case} had an answer that can be used: there is no score.",
        )
    return Run(challenge, tuple(results))


def _always_late(results: list[CaseResult]) -> str:
    """What was said of the latest cases, where the entry was out of time in each of them; else nothing."""
    latest = results[-MOST_LATE:]
    late = len(latest) == MOST_LATE and all(each.message.startswith(TIME_IS_UP) for each in latest)
    return latest[-1].message if late else ""


def _always_wrong(results: list[CaseResult], case: str) -> str:
    """Why no more cases are tried: none had an answer, and the latest failed as one before it did; else nothing."""
    kinds = [_NUMBERS.sub("0", each.message) for each in results]
    if not all(kinds) or kinds[-1].startswith(TIME_IS_UP) or kinds[-1] not in kinds[:-1]:
        return ""
    return f"no {case} had an answer that can be used, and this one fails as one before it did."


def _refusal(challenge: Challenge, entry: Any) -> str:
    """Why an entry cannot even be tried."""
    if callable(entry) or (challenge.takes_values and entry is not None):
        return ""
    if challenge.takes_values:
        return "An entry is the answer itself, and this one is None: was it given its name?"
    return (
        f"An entry must be a function, got {type(entry).__name__}. "
        "Enter the function itself, without brackets behind its name: enter(my_function)."
    )


def _case(challenge: Challenge, entry: Any, seed: Hashable, left: float) -> tuple[CaseResult, float, bool]:
    """One case: its result, the seconds it took the student, and whether the entry is not written yet."""
    name, scene = challenge.name_of(seed), challenge.scene(seed)
    nothing = partial(CaseResult, seed, name, challenge.nothing)
    if left <= 0:
        return (
            nothing(message=f"The {challenge.seconds_in_all:g} s that are for all are used up."),
            0.0,
            False,
        )
    answer, changed = _answer(entry, challenge.given(scene), min(challenge.seconds, left))
    if answer.message:
        return nothing(message=answer.message), answer.seconds, answer.unfinished
    if changed:
        message = f"{WHOSE} changes what it is given: work on a copy of it, as its copy() makes one."
        return nothing(message=message[0].upper() + message[1:]), answer.seconds, False
    judged = _guarded(partial(challenge.judge, answer.value, scene), JUDGING)
    earned = judged.value
    if not isinstance(earned, CaseScore):
        message = (
            str(judged.error)[:300] if isinstance(judged.error, ValueError | TypeError) else judged.message
        )
        return nothing(message=message), answer.seconds, False
    if not math.isfinite(earned.score):
        return (
            nothing(message=f"The score of its answer is no number: {earned.score}."),
            answer.seconds,
            False,
        )
    return CaseResult(seed, name, earned.score, earned.columns, earned.kept), answer.seconds, False


def _answer(entry: Any, given: tuple[Any, ...], seconds: float) -> tuple[Attempt[Any], bool]:
    """Ask an entry with copies of what is given; and say whether it changed them."""
    if not callable(entry):
        return Attempt(entry), False
    copies = copy.deepcopy(given)
    answer = _guarded(partial(entry, *copies), seconds)
    return answer, not _same(copies, given)


def _guarded(call: Callable[[], Any], seconds: float) -> Attempt[Any]:
    """Call with a time limit; what a student's own BaseException says is a message, too."""
    try:
        return attempt(call, WHOSE, limit=seconds, unfinished="not written yet", quiet=True)
    except KeyboardInterrupt:
        raise
    except TooSlow as error:  # it rang once more on the way out
        return Attempt(message=f"Time is up after {seconds:g} s.", error=error, seconds=seconds)
    except BaseException as error:  # noqa: BLE001 - a class of the student's that is no Exception
        return Attempt(message=f"{type(error).__name__} in {WHOSE}.", error=error)


def _same(left: tuple[Any, ...], right: tuple[Any, ...]) -> bool:
    try:
        return encode(list(left)) == encode(list(right))
    except CodecError:  # a list that was given what cannot even be sent
        return False
