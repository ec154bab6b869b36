"""Pairs of mistakes: which of them a check can recognise, and the few answers that it needs for that."""

import zlib
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.codec import CodecError, encode
from nao_course.exercises import judging
from nao_course.exercises.case import Case
from nao_course.exercises.exercise import Exercise, MistakePair, PublicMistake
from nao_course.exercises.running import Outcome

MOST_BYTES = 700  # of the answers that are stored for one pair
ENOUGH = 3  # different numbers in the stored answers; if there are fewer, the answers to all wrong cases are stored
DIGITS = 16  # binary digits of a stored float: a relative error of 1e-5, a tenth of what a comparison allows


@dataclass(frozen=True)
class _Tried:
    """The outcomes of the public cases for a pair of mistakes, by their numbers, and the numbers of the wrong cases."""

    mistakes: tuple[int, int]
    function: Callable[..., Any]
    outcomes: Sequence[Outcome]
    wrong: tuple[int, ...]


def recognisable(
    exercise: Exercise,
    cases: Sequence[Case],
    mistakes: Sequence[PublicMistake],
    run: Callable[[Callable[..., Any]], Sequence[Outcome]],
    is_stable: Callable[[Callable[..., Any], int, Any], bool],
    keeps_verdict: Callable[[Callable[..., Any], int, bool], bool],
) -> list[MistakePair]:
    """Return the pairs of an exercise's mistakes that a check can recognise.

    A pair is left out if one of its mistakes hides the other, if a single mistake or another pair gives the same
    answers, if it does not end, if rounding errors decide in which cases it is right, or if its answers are too large
    to store. `mistakes` are the single mistakes' answers,
    and like the result in the order of the declaration. `run` runs a function on all public cases, and returns fewer
    outcomes if a case takes too long. `is_stable` returns whether a function's wrong answer to a case, given by its
    number, is the same on every processor; `keeps_verdict`, whether its answer is right, or wrong, on every one.
    """
    if min(_size(_shortened(case.expected)) for case in cases) > MOST_BYTES:
        return []  # no answer is small enough, so the pairs need not be run
    tried = [each for each in _all_tried(exercise, cases, run) if not _is_single(exercise, each, mistakes)]
    beside: dict[tuple[int, ...], list[_Tried]] = defaultdict(list)
    for each in tried:
        beside[each.wrong].append(each)
    kept = []
    for each in tried:
        others = [other for other in beside[each.wrong] if other is not each]
        answers = _telling_answers(exercise, each, mistakes, others, is_stable)
        if answers and all(keeps_verdict(each.function, n, n not in each.wrong) for n in range(len(cases))):
            kept.append(MistakePair(each.mistakes, list(each.wrong), answers))
    return kept


def _all_tried(
    exercise: Exercise, cases: Sequence[Case], run: Callable[[Callable[..., Any]], Sequence[Outcome]]
) -> Iterator[_Tried]:
    """Run all pairs; a pair that is right or does not finish every case is left out."""
    for first, second, function in exercise.pairs():
        outcomes = run(function)
        if len(outcomes) < len(cases) or any(each.status not in ("value", "raised") for each in outcomes):
            continue
        verdicts = (
            judging.judge(exercise.comparison, case, outcome)
            for case, outcome in zip(cases, outcomes, strict=True)
        )
        wrong = tuple(number for number, verdict in enumerate(verdicts) if not verdict)
        if wrong:
            yield _Tried((first, second), function, outcomes, wrong)


def _is_single(exercise: Exercise, tried: _Tried, mistakes: Sequence[PublicMistake]) -> bool:
    """Return whether a single mistake has the same answers, so that its own message is shown."""
    return any(
        _wrong_cases(mistake) == tried.wrong
        and all(
            judging.is_unstable(answer) or judging.same_answer(exercise, answer, tried.outcomes[int(number)])
            for number, answer in mistake.answers.items()
        )
        for mistake in mistakes
    )


def _wrong_cases(mistake: PublicMistake) -> tuple[int, ...]:
    return tuple(sorted(map(int, mistake.answers)))


def _telling_answers(
    exercise: Exercise,
    tried: _Tried,
    mistakes: Sequence[PublicMistake],
    others: Iterable[_Tried],
    is_stable: Callable[[Callable[..., Any], int, Any], bool],
) -> dict[str, Any]:
    """Return answers to a few small cases that no single mistake and no other pair gives; nothing if there are none.

    At least one of these answers is neither the first nor the second mistake's, and one is the largest that there is
    room for.
    """
    rivals: list[Mapping[int, Any] | _Tried] = [
        {int(number): answer for number, answer in mistake.answers.items()}
        for number, mistake in enumerate(mistakes)
        if number in tried.mistakes or _wrong_cases(mistake) == tried.wrong
    ]
    rivals += others
    answers = sorted(_compact_answers(exercise, tried), key=lambda each: each[:2])
    stored: dict[str, Any] = {}
    size, numbers = 0, set[float]()
    for length, number, answer in answers:
        if size + length > MOST_BYTES:
            break
        left = [rival for rival in rivals if _agrees(exercise, rival, number, answer)]
        found = _numbers_in(answer)
        adds = len(left) < len(rivals) or (len(numbers) < ENOUGH and not found <= numbers)
        if adds and is_stable(tried.function, number, tried.outcomes[number].value):
            stored[str(number)] = answer
            rivals, numbers, size = left, numbers | found, size + length
        if not rivals and len(numbers) >= ENOUGH:
            # Another error may fit small cases by chance, so the largest that there is room for has to fit as well.
            for length, number, answer in reversed(answers):
                fits = str(number) in stored or size + length <= MOST_BYTES
                if fits and is_stable(tried.function, number, tried.outcomes[number].value):
                    return stored | {str(number): answer}
    if rivals or sum(length for length, _, _ in answers) > MOST_BYTES:
        return {}
    every = {str(number): answer for _, number, answer in answers}
    stable = (is_stable(tried.function, number, tried.outcomes[number].value) for _, number, _ in answers)
    return every if len(every) == len(tried.wrong) and all(stable) else {}


def _compact_answers(exercise: Exercise, tried: _Tried) -> Iterator[tuple[int, int, Any]]:
    """Yield size, case and answer of all wrong answers that are values; floats lose digits if that is harmless."""
    for number in tried.wrong:
        outcome = tried.outcomes[number]
        if outcome.status != "value":
            continue
        answer = _shortened(outcome.value)
        try:
            if not judging.same_answer(exercise, answer, outcome):
                answer = outcome.value
            yield _size(answer), number, answer
        except CodecError:
            continue


def _size(answer: Any) -> int:
    """Return the bytes of an answer: compressed unless rounding errors, which differ between processors, count."""
    frame = encode(answer)
    return len(frame) if _holds_floats(answer) else len(zlib.compress(frame))


def _holds_floats(value: Any) -> bool:
    if isinstance(value, dict):
        return any(map(_holds_floats, value.values()))
    if isinstance(value, list | tuple):
        return any(map(_holds_floats, value))
    return isinstance(value, float) or (isinstance(value, np.ndarray) and value.dtype.kind in "fc")


def _agrees(exercise: Exercise, rival: Mapping[int, Any] | _Tried, number: int, answer: Any) -> bool:
    """Return whether a single mistake, or another pair, may give this answer to a case."""
    if isinstance(rival, _Tried):
        return judging.same_answer(exercise, answer, rival.outcomes[number])
    if number not in rival:
        return False  # its answer is right there
    theirs = rival[number]
    if judging.is_unstable(theirs):
        return True
    if isinstance(theirs, dict) and set(theirs) == {"raises"}:
        return False
    return judging.same_answer(exercise, answer, Outcome("value", theirs))


def _shortened(value: Any) -> Any:
    """Return a value whose arrays of floats have fewer digits."""
    if isinstance(value, np.ndarray) and value.dtype == np.float64:
        with np.errstate(all="ignore"):
            mantissa, exponent = np.frexp(value)
            return np.ldexp(np.round(mantissa * 2**DIGITS) / 2**DIGITS, exponent).astype(np.float32)
    if isinstance(value, list | tuple):
        return type(value)(map(_shortened, value))
    if type(value) is dict:
        return {name: _shortened(each) for name, each in value.items()}
    return value


def _numbers_in(value: Any) -> set[float]:
    """Return the different numbers in an answer; an answer with few numbers is easily given by chance."""
    if isinstance(value, dict):
        return set().union(*map(_numbers_in, value.values()))
    if isinstance(value, list | tuple):
        return set().union(*map(_numbers_in, value))
    if isinstance(value, np.ndarray) and value.dtype.kind in "biu" and value.ndim > 1:
        # In a picture, the pattern of each row counts.
        return {float(zlib.crc32(row.tobytes())) for row in value}
    if isinstance(value, np.ndarray) and value.dtype.kind in "biuf":
        return {float(f"{each:.4g}") for each in value.ravel()}
    return {float(f"{value:.4g}")} if isinstance(value, int | float) else set()
