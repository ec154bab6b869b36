"""A lesson's declaration and its reference: loaded, checked, and turned into what a student's checks carry."""

from __future__ import annotations

import importlib.util
import sys
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.exercises.case import Case
from nao_course.exercises.checking import grade_public
from nao_course.exercises.codec import CodecError, decode, encode
from nao_course.exercises.comparisons import Between
from nao_course.exercises.definitions import Definitions, load_definitions
from nao_course.exercises.exercise import (
    Exercise,
    LessonPlan,
    PublicExercise,
    PublicLesson,
    PublicMistake,
    PublicQuestion,
    PublicWritten,
    Question,
    Written,
)
from nao_course.exercises.running import call

SOLUTIONS = Path("solutions")
LARGEST_PICTURE = 64 * 48  # pixels; a lesson's public data travels with the package
FEWEST = 3  # mistakes, and alternatives
SEEDS = (1, 2, 3)  # of the hidden cases that a plan is checked with; the grader draws others


class PlanError(ValueError):
    """A lesson's declaration that cannot be used; its message names each exercise and what is wrong with it."""


def lesson_name(lesson: str, solutions: Path = SOLUTIONS) -> str:
    """Return a lesson's whole name for its number or name: "01" -> "01_hsl_filtering".

    Raises
    ------
    PlanError
        If no lesson in `solutions` is meant, or several are.
    """
    names = sorted(path.stem for path in (solutions / "exercises").glob("[0-9][0-9]_*.py"))
    meant = [name for name in names if name == lesson or name.split("_")[0] == lesson.zfill(2)]
    if len(meant) != 1:
        raise PlanError(f"there is no one lesson {lesson!r} with exercises in {solutions}; there are {names}")
    return meant[0]


def load_plan(path: str | Path) -> LessonPlan:
    """Load the PLAN of a declaration file.

    Parameters
    ----------
    path : str or Path
        Such as solutions/exercises/01_hsl_filtering.py.

    Returns
    -------
    LessonPlan
        Not checked yet; see `check_plan`.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    PlanError
        If it cannot be run or declares no PLAN.
    """
    file = Path(path)
    if not file.is_file():
        raise FileNotFoundError(f"no declaration of exercises: {file}")
    name = f"nao_course_plan_{file.stem}"
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec and spec.loader  # both are there for every .py file
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # dataclasses of the file look themselves up in it
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise PlanError(f"{file.name}: {type(error).__name__}: {error}") from error
    plan = getattr(module, "PLAN", None)
    if not isinstance(plan, LessonPlan):
        raise PlanError(f"{file.name}: it must give the name PLAN to a LessonPlan")
    return plan


def solution_notebook(lesson: str, solutions: Path = SOLUTIONS) -> Path:
    """Return the path of a lesson's solution notebook.

    Raises
    ------
    FileNotFoundError
        If it has not been built.
    """
    path = solutions / f"{lesson_name(lesson, solutions)}.ipynb"
    if not path.is_file():
        raise FileNotFoundError(f"there is no {path}: run `nao-course build` first")
    return path


def reference(lesson: str, solutions: Path = SOLUTIONS) -> Definitions:
    """Load a lesson's solution: what its solution notebook defines.

    Parameters
    ----------
    lesson : str
        Number or name.
    solutions : Path
        Folder of the lessons.

    Returns
    -------
    Definitions
        The reference functions by name.
    """
    return load_definitions(solution_notebook(lesson, solutions))


def with_answers(exercise: Exercise, cases: Sequence[Case], function: Callable[..., Any]) -> list[Case]:
    """Fill in what is expected: the reference's answers, but for `Between`, which brings its own.

    Parameters
    ----------
    exercise : Exercise
        Whose cases they are.
    cases : sequence of Case
        Without expected answers.
    function : callable
        The reference.

    Returns
    -------
    list of Case
        With them, as they come out of the codec: plain and their own.

    Raises
    ------
    PlanError
        If the reference raises, is wrong by its own comparison, or answers what cannot be sent.
    """
    solved = []
    for number, case in enumerate(cases, start=1):
        where = f"{exercise.name}: the reference, case {number} {case.name!r},"
        outcome = call(function, case, exercise.driver)
        if outcome.status != "value":
            raise PlanError(
                f"{where} gives no answer: {outcome.status} {outcome.text} {outcome.line}".rstrip()
            )
        try:
            answer = decode(encode(outcome.value))
        except CodecError as error:
            raise PlanError(f"{where} gives an answer that cannot be sent: {error}") from None
        expected = case.expected if isinstance(exercise.comparison, Between) else answer
        verdict = exercise.comparison.compare(expected, answer)
        if not verdict:
            raise PlanError(f"{where} is not right by its own comparison: {verdict.text}")
        if outcome.changed:
            raise PlanError(f"{where} changes its input")
        solved.append(replace(case, expected=expected))
    return solved


def hidden_cases(exercise: Exercise, function: Callable[..., Any], seed: int) -> list[Case]:
    """Draw an exercise's hidden cases, with the reference's answers."""
    return with_answers(exercise, exercise.hidden(np.random.default_rng(seed)), function)


def publish(lesson: str, plan: LessonPlan, reference: Mapping[str, Callable[..., Any]]) -> PublicLesson:
    """Make what a student's copy carries of a plan: inputs and outputs, no code.

    Parameters
    ----------
    lesson : str
        Such as "01_hsl_filtering"; its number becomes the exercises'.
    plan : LessonPlan
        The declaration.
    reference : mapping of str to callable
        The solution's functions.

    Returns
    -------
    PublicLesson
        Ready for `checking.pack`.

    Raises
    ------
    PlanError
        If the reference lacks an exercise or fails in one.
    """
    lesson_number = int(lesson.split("_")[0])
    exercises = [
        publish_exercise(f"{lesson_number}.{number}", exercise, _of(reference, exercise))
        for number, exercise in enumerate(plan.exercises, start=1)
    ]
    questions = [
        PublicQuestion(each.name, each.text, dict(each.choices), each.right) for each in plan.questions
    ]
    written = [
        PublicWritten(each.name, f"{lesson_number}.W{number}", float(each.points))
        for number, each in enumerate(plan.written, start=1)
    ]
    return PublicLesson(lesson, exercises, questions, written)


def publish_exercise(number: str, exercise: Exercise, function: Callable[..., Any]) -> PublicExercise:
    """Make what a student's copy carries of one exercise.

    Parameters
    ----------
    number : str
        In the lesson: "1.3".
    exercise : Exercise
        The declaration.
    function : callable
        The reference.

    Returns
    -------
    PublicExercise
        With the answers of every mistake to the public cases.
    """
    cases = with_answers(exercise, exercise.public(), function)
    mistakes = [
        PublicMistake(mistake.message, _answers(exercise, cases, mistake.function))
        for mistake in exercise.mistakes
    ]
    return PublicExercise(
        name=exercise.name,
        number=number,
        points=float(exercise.points),
        stars=exercise.stars,
        comparison=exercise.comparison,
        cases=cases,
        mistakes=mistakes,
        hints=list(exercise.hints),
        driver=exercise.driver,
        in_place=exercise.in_place,
    )


def _of(reference: Mapping[str, Callable[..., Any]], exercise: Exercise) -> Callable[..., Any]:
    if exercise.name not in reference:
        raise PlanError(f"{exercise.name}: the solution notebook does not define it")
    return reference[exercise.name]


def _answers(exercise: Exercise, cases: Sequence[Case], function: Callable[..., Any]) -> dict[str, Any]:
    """A mistake's answers where they are not right, by the number of the case."""
    answers: dict[str, Any] = {}
    for number, case in enumerate(cases):
        outcome = call(function, case, exercise.driver)
        if outcome.status == "value":
            if not exercise.comparison.compare(case.expected, outcome.value):
                answers[str(number)] = outcome.value
        else:
            answers[str(number)] = {"raises": outcome.text.split(":")[0]}
    return answers


# --- refusing what would fail a student later ---


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
            problems += _exercise_problems(str(number), exercise, _of(reference, exercise))
        except PlanError as error:
            problems.append(str(error))
    if problems:
        raise PlanError("\n".join(f"{lesson}: {problem}" for problem in problems))


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
