"""Refuse a declaration that would fail a student later: each mistake is recognised, each alternative is right."""

import math
import time
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np

from nao_course.codec import CodecError, encode
from nao_course.exercises import lesson_names
from nao_course.exercises.case import Case
from nao_course.exercises.checking import grade_public
from nao_course.exercises.comparisons.methods import Methods
from nao_course.exercises.earlier import split_use
from nao_course.exercises.exercise import Exercise, LessonPlan, Mistake, PublicExercise, Question, Written
from nao_course.exercises.running import Outcome, call_all
from nao_course.instructor.authoring.declarations import declaration_problems
from nao_course.instructor.authoring.mistakes import without_numeric_warnings
from nao_course.instructor.authoring.plans import (
    PATIENCE,
    SEEDS,
    PlanError,
    call_in_time,
    exercise_number,
    hidden_cases,
    made_cases,
    publish_exercise,
    raised_at,
    reference_of,
    with_mistakes,
)
from nao_course.instructor.sandbox.protocol import SECONDS_IN_ALL

LARGEST_PICTURE = 64 * 48  # pixels; a lesson's public data travels with the package
MOST_NUMBERS = 250_000  # of any other array: a matrix of 500x500
FEWEST = 3  # mistakes, and alternatives
# of an exercise's seconds that its solution may take: students' code is slower, and machines are busy.
SHARE = 1 / 3
_TRIES = 3  # at measuring a call: the machine may be busy with other things
_BROKEN = ("NameError", "UnboundLocalError", "ImportError", "ModuleNotFoundError", "SyntaxError")


def check_plan(
    lesson: str,
    plan: LessonPlan,
    reference: Mapping[str, Callable[..., Any]],
    taken: Collection[str] = (),
    proven: Mapping[str, PublicExercise] = MappingProxyType({}),
) -> list[PublicExercise]:
    """Refuse a plan whose checks or grading would not work; return what a student's copy contains of each exercise.

    `taken` are the names of the exercises of all other lessons. Of exercises that are `proven`, only the time of the
    solution is measured. A PlanError has one line for each thing that is wrong.
    """
    problems = [*declaration_problems(plan)] or [*_name_problems(plan, taken)]
    published: list[PublicExercise] = []
    seconds = 0.0
    try:
        plan = with_mistakes(plan, reference) if not problems else plan
    except PlanError as error:
        problems += str(error).splitlines()
    for number, exercise in enumerate(plan.exercises if not problems else (), start=1):
        try:
            function = reference_of(reference, exercise)
            public, hidden = _all_cases(exercise)
            if exercise.name not in proven:
                problems += _case_problems(exercise, public)
            slowest, together = _measured(exercise, function, [*public, *hidden[0]])
            seconds += together
            problems += _time_problems(exercise, slowest)
            if exercise.name in proven:
                published.append(proven[exercise.name])
                continue
            twice = _twice([each.name for each in exercise.mistakes])
            problems += [f"{exercise.name}: two mistakes are called {each!r}" for each in twice]
            published.append(publish_exercise(exercise_number(lesson, number), exercise, function))
            problems += _exercise_problems(exercise, function, published[-1])
        except PlanError as error:
            problems += str(error).splitlines()
        except Exception as error:  # noqa: BLE001 - the author's own functions may raise what they like
            problems.append(f"{exercise.name}: {raised_at(error)}")
    if seconds > SHARE * SECONDS_IN_ALL:
        problems.append(
            f"its solutions take {seconds:.0f} s for all cases; a submission has {SECONDS_IN_ALL:g} s, and the "
            f"solutions must stay below a third of that: make fewer or smaller cases"
        )
    if problems:
        raise PlanError("\n".join(f"{lesson}: {problem}" for problem in problems))
    return published


def use_problems(lesson: str, plans: Mapping[str, LessonPlan]) -> Iterator[str]:
    """Yield "LESSON: EXERCISE: what is wrong" for exercises of a lesson that use what is not there, or comes later.

    `plans` are of all lessons, by name.
    """
    own = [each.name for each in plans[lesson].exercises]
    for exercise in plans[lesson].exercises:
        for use in exercise.uses:
            number, name = split_use(use)
            problem = ""
            if not number and name not in own:
                problem = f"lesson {lesson} has no exercise {name!r}"
            elif not number and own.index(name) >= own.index(exercise.name):
                problem = f"{name} does not come before it"
            elif number:
                problem = _earlier_problem(number, name, lesson, plans)
            if problem:
                yield f"{lesson}: {exercise.name}: it uses {use!r}: {problem}"


def _earlier_problem(number: str, name: str, lesson: str, plans: Mapping[str, LessonPlan]) -> str:
    """Return why an exercise of another lesson cannot be used."""
    found = lesson_names.meant(number, sorted(plans))
    if len(found) != 1:
        return f"there is no lesson {number!r}; there are {sorted(plans)}"
    if lesson_names.number_of(found[0]) >= lesson_names.number_of(lesson):
        return f"lesson {found[0]} does not come before {lesson}"
    if name not in [each.name for each in plans[found[0]].exercises]:
        return f"lesson {found[0]} has no exercise {name!r}"
    return ""


def _name_problems(plan: LessonPlan, taken: Collection[str]) -> Iterator[str]:
    kinds: tuple[Sequence[Exercise | Question | Written], ...] = (
        plan.exercises,
        plan.questions,
        plan.written,
    )
    names = [each.name for kind in kinds for each in kind]
    for name in _twice([*names, *(name for name in taken if name in names)]):
        yield f"{name}: the name is used twice"


def _all_cases(exercise: Exercise) -> tuple[list[Case], list[list[Case]]]:
    """Make the public cases, and hidden cases of each seed; all problems are reported at once."""
    made: dict[int | None, list[Case]] = {}
    problems: dict[str, None] = {}
    for seed in (None, *SEEDS):
        try:
            made[seed] = made_cases(exercise, seed)
        except PlanError as error:
            problems |= dict.fromkeys(str(error).splitlines())
    if problems:
        raise PlanError("\n".join(problems))
    return made[None], [made[seed] for seed in SEEDS]


def _measured(exercise: Exercise, function: Callable[..., Any], cases: Sequence[Case]) -> tuple[float, float]:
    """Return the seconds of a reference's slowest call, and of all calls together."""
    times = [_seconds(exercise, function, case) for case in cases]
    return max(times), sum(times)


def _seconds(exercise: Exercise, function: Callable[..., Any], case: Case) -> float:
    """Time that a call takes; where it seems too long, the best of some, so that other work does not count."""
    best = float("inf")
    for _ in range(_TRIES):
        wall, processor = time.perf_counter(), time.process_time()
        call_in_time(exercise, function, case)
        # Others keep the processor from us, or several of ours count at once: the smaller one is nearer.
        best = min(best, time.perf_counter() - wall, time.process_time() - processor)
        if best <= SHARE * exercise.seconds:
            break
    return best


def _time_problems(exercise: Exercise, slowest: float) -> Iterator[str]:
    if slowest > SHARE * exercise.seconds:
        yield (
            f"{exercise.name}: its solution takes {slowest:.1f} s for one case; the grader stops a call after "
            f"{exercise.seconds:g} s, and the solution must stay below a third of that: make it faster, make the cases "
            f"smaller, or say Exercise(seconds={math.ceil(3.5 * slowest)})"
        )


def plan_warnings(plan: LessonPlan) -> Iterator[str]:
    """Yield which graded exercises have few mistakes or alternatives; nothing if the plan waives rule 8."""
    for exercise in plan.exercises if "8" not in plan.waived else ():
        few = [
            f"{len(many)} {kind}"
            for kind, many in (("mistakes", exercise.mistakes), ("alternatives", exercise.alternatives))
            if exercise.points > 0 and len(many) < FEWEST
        ]
        if few:
            yield (
                f"{exercise.name}: it has {' and '.join(few)}; with {FEWEST} of each, checks name students' errors "
                f'and accept other solutions. For a lesson without them, say LessonPlan(waived={{"8": "the reason"}})'
            )


def _exercise_problems(
    exercise: Exercise, function: Callable[..., Any], public: PublicExercise
) -> Iterator[str]:
    """Yield the problems of an exercise whose reference works; raise PlanError if the reference fails."""
    name = exercise.name
    hidden = [case for seed in SEEDS for case in hidden_cases(exercise, function, seed)]
    if isinstance(exercise.comparison, Methods):
        called = {method for case in (*public.cases, *hidden) for method, _ in case.expected}
        for method in sorted(set(exercise.comparison.by) - called):
            yield f"{name}: Methods compares {method!r}, which no case calls; they call {sorted(called)}"
    for kind, cases in (("public", public.cases), ("hidden", hidden)) if exercise.parts else ():
        yield from _part_problems(exercise, kind, cases)
    patient = replace(public, seconds=PATIENCE * public.seconds)  # the machine may be busy with other things
    for title, alternative in exercise.alternatives.items():
        report = grade_public(patient, alternative)
        if not report:
            yield f"{name}: alternative {title!r} is not right: {' '.join(report.lines)}"
        elif not (report := grade_public(replace(patient, cases=hidden), alternative)):
            yield f"{name}: alternative {title!r} is not right in a hidden case: {' '.join(report.lines)}"
    with without_numeric_warnings():
        for mistake in exercise.mistakes:
            yield from _mistake_problems(name, mistake, public, hidden)


def _part_problems(exercise: Exercise, kind: str, cases: Sequence[Case]) -> Iterator[str]:
    """Yield which cases belong to no part of an exercise, and which parts have no case."""
    used = dict.fromkeys(case.part for case in cases)
    for part in used:
        if part not in exercise.parts:
            what = f"of the part {part!r}" if part else "without a part"
            yield (
                f"{exercise.name}: it has a {kind} case {what}; the case's name must begin with one of "
                f"{list(exercise.parts)} and a colon"
            )
    for part in exercise.parts:
        if part not in used:
            yield f"{exercise.name}: no {kind} case tests the part {part!r}"


def _mistake_problems(
    name: str, mistake: Mistake, public: PublicExercise, hidden: Sequence[Case]
) -> Iterator[str]:
    """Yield the problems of a mistake, which must fail in public and hidden cases and get its own message."""
    report = grade_public(public, mistake.function)
    if broken := _broken(public, mistake):
        yield f"{name}: mistake {mistake.name!r} gives no answer in any case: {broken}"
    elif report:
        yield f"{name}: mistake {mistake.name!r}: no public case distinguishes it from the right answer"
    elif mistake.message not in report.lines:
        yield f"{name}: mistake {mistake.name!r}: its message is not shown, but: {' '.join(report.lines)}"
    # One case after the other: the first case distinguishes nearly every mistake.
    if all(grade_public(replace(public, cases=[case]), mistake.function) for case in hidden):
        yield f"{name}: mistake {mistake.name!r}: no hidden case distinguishes it from the right answer"


def _broken(public: PublicExercise, mistake: Mistake) -> str:
    """Return the author's own error that a mistake raises in every case; students' errors do not count."""

    def called(cases: Sequence[Case]) -> list[Outcome]:
        return call_all(mistake.function, cases, public.driver, PATIENCE * public.seconds)

    (first,) = called(public.cases[:1])
    text = first.text
    slip = text.startswith(_BROKEN) or (text.startswith("TypeError") and "positional argument" in text)
    if first.status == "raised" and slip and {each.text for each in called(public.cases)} == {text}:
        return f"{text} {first.line}".strip()
    return ""


def _case_problems(exercise: Exercise, public: Sequence[Case]) -> Iterator[str]:
    """Yield the problems of cases that can each be called."""
    try:
        if encode(public) != encode(made_cases(exercise)):
            yield f"{exercise.name}: its public cases are not the same each time"
        if encode(made_cases(exercise, SEEDS[0])) != encode(made_cases(exercise, SEEDS[0])):
            yield f"{exercise.name}: its hidden cases are not the same for the same seed"
    except CodecError as error:
        raise PlanError(f"{exercise.name}: a case cannot be sent: {error}") from None
    for number, case in enumerate(public, start=1):
        for array in _arrays((case.args, case.kwargs)):
            if problem := _size_problem(array):
                yield f"{exercise.name}: public case {number} has {problem}"


def _size_problem(array: np.ndarray[Any, Any]) -> str:
    """Return why an array of a public case is too large for the package; an empty text if it is not."""
    is_picture = array.dtype in (np.uint8, np.bool_) and array.ndim in (2, 3)
    if is_picture and array.shape[0] * array.shape[1] > LARGEST_PICTURE:
        size = f"{array.shape[1]}x{array.shape[0]}"
        return f"a picture of {size}; 64x48 is the most: cut out a part, or draw large ones in hidden cases"
    if array.size > MOST_NUMBERS:
        return (
            f"an array of {array.size} numbers; {MOST_NUMBERS} are the most: draw large ones in hidden cases"
        )
    return ""


def _arrays(value: Any) -> Iterator[np.ndarray[Any, Any]]:
    """Yield all arrays in a value."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple | list):
        for each in value:
            yield from _arrays(each)
    elif isinstance(value, dict):
        yield from _arrays(list(value.values()))


def _twice(names: Sequence[str]) -> list[str]:
    return [name for name, count in Counter(names).items() if count > 1]
