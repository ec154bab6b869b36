"""Run a student's entry on the cases of a challenge; its errors become messages."""

from __future__ import annotations

import copy
import math
import re
from collections.abc import Callable, Hashable
from functools import partial
from typing import Any

from nao_course._internal.time_limits import TooSlow
from nao_course.challenges.declaration import CaseResult, CaseScore, Challenge, Run
from nao_course.challenges.progress import Progress
from nao_course.codec import CodecError, encode
from nao_course.widgets.attempts import Attempt, attempt

WHOSE = "your entry"  # in messages
JUDGING = 20.0  # s for judging one answer: more than any legitimate answer needs

MOST_LATE = 3  # number of successive cases that run out of time after which the run is stopped
TIME_IS_UP = "Time is up"  # first words of the message about such a case
_NUMBERS = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")  # what may differ where an error is the same


def run(challenge: Challenge, entry: Any, progress: Progress | None = None) -> Run:
    """Run an entry, a function or the answer itself, on all cases of a challenge, updating the progress bar after each.

    No exception is raised; after an interruption, `stopped` explains it.
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
            return Run(challenge, tuple(results), f"Interrupted after {done}, so there is no score.")
        if unwritten:
            return Run(challenge, (), f"Not written yet: {WHOSE} calls an exercise that is still blank.")
        left -= took
        results.append(result)
        if why := _always_late(results) or _always_wrong(results, challenge.case):
            done = f"{len(results)} of {len(challenge.seeds)} {challenge.case}s"
            return Run(challenge, tuple(results), f"Stopped after {done}, without a score: {why}")
        if progress:
            progress.step()
    if all(each.message for each in results):
        return Run(
            challenge, tuple(results), f"No {challenge.case} had a usable answer, so there is no score."
        )
    return Run(challenge, tuple(results))


def _always_late(results: list[CaseResult]) -> str:
    """Return a message if the entry ran out of time in all of the latest cases, else an empty text."""
    latest = results[-MOST_LATE:]
    late = len(latest) == MOST_LATE and all(each.message.startswith(TIME_IS_UP) for each in latest)
    return latest[-1].message if late else ""


def _always_wrong(results: list[CaseResult], case: str) -> str:
    """Return a message if no case had a usable answer and the same error repeated, else an empty text."""
    kinds = [_NUMBERS.sub("0", each.message) for each in results]
    if not all(kinds) or kinds[-1].startswith(TIME_IS_UP) or kinds[-1] not in kinds[:-1]:
        return ""
    return f"no {case} had a usable answer, and the same error occurred again."


def _refusal(challenge: Challenge, entry: Any) -> str:
    """Return why an entry cannot be run."""
    if callable(entry) or (challenge.takes_values and entry is not None):
        return ""
    if challenge.takes_values:
        return (
            "The entry is None, but this challenge needs the answer itself: did you assign it to that name?"
        )
    return (
        f"An entry must be a function, got {type(entry).__name__}. "
        "Enter the function itself, without brackets after its name: enter(my_function)."
    )


def _case(challenge: Challenge, entry: Any, seed: Hashable, left: float) -> tuple[CaseResult, float, bool]:
    """Run one case: return its result, the student's seconds, and whether the entry is not written yet."""
    name, scene = challenge.name_of(seed), challenge.scene(seed)
    nothing = partial(CaseResult, seed, name, challenge.nothing)
    if left <= 0:
        return (nothing(message=f"The {challenge.seconds_in_all:g} s for all cases are used up."), 0.0, False)
    answer, changed = _answer(entry, challenge.given(scene), min(challenge.seconds, left))
    if answer.message:
        return nothing(message=answer.message), answer.seconds, answer.unfinished
    if changed:
        message = f"{WHOSE} changes its arguments: work on a copy, made with .copy()."
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
            nothing(message=f"The score of its answer is not a number: {earned.score}."),
            answer.seconds,
            False,
        )
    return CaseResult(seed, name, earned.score, earned.columns, earned.kept), answer.seconds, False


def _answer(entry: Any, given: tuple[Any, ...], seconds: float) -> tuple[Attempt[Any], bool]:
    """Call an entry with copies of the case's inputs, and report whether it changed them."""
    if not callable(entry):
        return Attempt(entry), False
    copies = copy.deepcopy(given)
    answer = _guarded(partial(entry, *copies), seconds)
    return answer, not _same(copies, given)


def _guarded(call: Callable[[], Any], seconds: float) -> Attempt[Any]:
    """Call a function with a time limit; every exception becomes a message."""
    try:
        return attempt(call, WHOSE, limit=seconds, unfinished="not written yet", quiet=True)
    except KeyboardInterrupt:
        raise
    except TooSlow as error:  # the alarm rang again during the clean-up
        return Attempt(message=f"Time is up after {seconds:g} s.", error=error, seconds=seconds)
    except BaseException as error:  # noqa: BLE001 - the student's class may not derive from Exception
        return Attempt(message=f"{type(error).__name__} in {WHOSE}.", error=error)


def _same(left: tuple[Any, ...], right: tuple[Any, ...]) -> bool:
    try:
        return encode(list(left)) == encode(list(right))
    except CodecError:  # the entry put a value into a list that cannot be encoded
        return False
