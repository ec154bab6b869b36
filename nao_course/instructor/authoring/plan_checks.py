"""Refusing a declaration that would fail a student later: each mistake is told, each alternative is right."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from nao_course.exercises import lesson_names
from nao_course.exercises.case import Case
from nao_course.exercises.checking import grade_public
from nao_course.exercises.codec import CodecError, encode
from nao_course.exercises.earlier import split_use
from nao_course.exercises.exercise import Exercise, LessonPlan, Question, Written
from nao_course.instructor.authoring.plans import (
    SEEDS,
    PlanError,
    hidden_cases,
    publish_exercise,
    reference_of,
)

LARGEST_PICTURE = 64 * 48  # pixels; a lesson's public data travels with the package
FEWEST = 3  # mistakes, and alternatives


def check_plan(
    lesson: str,
    plan: LessonPlan,
    reference: Mapping[str, Callable[..., Any]],
    taken: Collection[str] = (),
) -> None:
    """Refuse a plan whose checks or grading would not work.

    Parameters
    ----------
    lesson : str
        Such as "01_hsl_filtering".
    plan : LessonPlan
        The declaration.
    reference : mapping of str to callable
        The solution's functions.
    taken : collection of str
        Names of the exercises of all other lessons.

    Raises
    ------
    PlanError
        One line for each thing that is wrong: which exercise and what.
    """
    problems = list(_name_problems(plan, taken))
    for number, exercise in enumerate(plan.exercises, start=1):
        try:
            problems += _exercise_problems(str(number), exercise, reference_of(reference, exercise))
        except PlanError as error:
            problems.append(str(error))
    if problems:
        raise PlanError("\n".join(f"{lesson}: {problem}" for problem in problems))


def use_problems(lesson: str, plans: Mapping[str, LessonPlan]) -> Iterator[str]:
    """Say which exercises of a lesson use what is not there, or comes later.

    Parameters
    ----------
    lesson : str
        Such as "03_goal_posts".
    plans : mapping of str to LessonPlan
        Of all lessons, by name.

    Yields
    ------
    str
        "LESSON: EXERCISE: what is wrong".
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
    """Why an exercise of another lesson cannot be used."""
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
    for question in plan.questions:
        if question.right not in question.choices:
            yield f"{question.name}: its right answer is not one of its choices"


def _exercise_problems(number: str, exercise: Exercise, function: Callable[..., Any]) -> Iterator[str]:
    """What is wrong with an exercise whose reference works; PlanError where that fails."""
    name = exercise.name
    if exercise.points > 0:
        for kind, many in (("mistakes", exercise.mistakes), ("alternatives", exercise.alternatives)):
            if len(many) < FEWEST:
                yield f"{name}: {len(many)} {kind}; at least {FEWEST} are wanted"
    for twice in _twice([each.name for each in exercise.mistakes]):
        yield f"{name}: two mistakes are called {twice!r}"
    for cases, kind in ((exercise.public(), "public"), (_drawn(exercise, SEEDS[0]), "hidden")):
        if not cases:
            yield f"{name}: no {kind} cases"
            return
    yield from _case_problems(exercise)
    public = publish_exercise(number, exercise, function)
    hidden = [case for seed in SEEDS for case in hidden_cases(exercise, function, seed)]
    for title, alternative in exercise.alternatives.items():
        report = grade_public(public, alternative)
        if not report:
            yield f"{name}: alternative {title!r} is not right: {' '.join(report.lines)}"
        elif not (report := grade_public(replace(public, cases=hidden), alternative)):
            yield f"{name}: alternative {title!r} is not right in a hidden case: {' '.join(report.lines)}"
    for mistake in exercise.mistakes:
        report = grade_public(public, mistake.function)
        if report:
            yield f"{name}: mistake {mistake.name!r}: no public case tells it from the right answer"
        elif mistake.message not in report.lines:
            yield f"{name}: mistake {mistake.name!r}: its message is not shown, but: {' '.join(report.lines)}"
        if grade_public(replace(public, cases=hidden), mistake.function):
            yield f"{name}: mistake {mistake.name!r}: no hidden case tells it from the right answer"


def _drawn(exercise: Exercise, seed: int) -> list[Case]:
    return exercise.hidden(np.random.default_rng(seed))


def _case_problems(exercise: Exercise) -> Iterator[str]:
    try:
        if encode(exercise.public()) != encode(exercise.public()):
            yield f"{exercise.name}: its public cases are not the same each time"
        if encode(_drawn(exercise, SEEDS[0])) != encode(_drawn(exercise, SEEDS[0])):
            yield f"{exercise.name}: its hidden cases are not the same for the same seed"
    except CodecError as error:
        raise PlanError(f"{exercise.name}: a case cannot be sent: {error}") from None
    for number, case in enumerate(exercise.public(), start=1):
        for array in _arrays((case.args, case.kwargs)):
            if array.ndim >= 2 and array.shape[0] * array.shape[1] > LARGEST_PICTURE:
                size = f"{array.shape[1]}x{array.shape[0]}"
                yield f"{exercise.name}: public case {number} has a picture of {size}; 64x48 is the most"


def _arrays(value: Any) -> Iterator[np.ndarray[Any, Any]]:
    """All arrays in a value."""
    if isinstance(value, np.ndarray):
        yield value
    elif isinstance(value, tuple | list):
        for each in value:
            yield from _arrays(each)
    elif isinstance(value, dict):
        yield from _arrays(list(value.values()))


def _twice(names: Sequence[str]) -> list[str]:
    return [name for name, count in Counter(names).items() if count > 1]
