"""A lesson's declaration and its reference: loaded, and turned into what a student's checks carry."""

import importlib.util
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.codec import CodecError, decode, encode
from nao_course.exercises import judging, lesson_names
from nao_course.exercises.case import Case
from nao_course.exercises.comparisons import Close
from nao_course.exercises.definitions import Definitions, demonstrated, load_definitions
from nao_course.exercises.earlier import in_words, resolved_by, split_use, stand_in, watching
from nao_course.exercises.exercise import (
    Exercise,
    LessonPlan,
    MistakePair,
    PublicExercise,
    PublicLesson,
    PublicMistake,
    PublicQuestion,
    PublicWritten,
)
from nao_course.exercises.outline import FOLDER
from nao_course.exercises.running import Outcome, call_all, describe, own_line
from nao_course.instructor.authoring.declarations import case_problems, declaration_problems, undeclared_uses
from nao_course.instructor.authoring.mistake_pairs import recognisable
from nao_course.instructor.authoring.mistakes import ChangeError, with_functions, without_numeric_warnings
from nao_course.instructor.authoring.perturbation import perturbed_cases

SOLUTIONS = Path("solutions")
CHECKS = Path("nao_course", "exercises", "checks")  # in the course's folder: the data of each lesson's checks
OUTLINES = Path("nao_course", "exercises", FOLDER)  # the cells of each released notebook
PAIR_SECONDS = 1.0  # of a call with two mistakes at once: together they may never end
PATIENCE = 3  # times an exercise's seconds, after which a call of the author's own functions is stopped
SEEDS = (1, 2, 3)  # of the hidden cases that a plan is checked with; the grader draws others
SAME = Close(rtol=1e-9, atol=1e-12)  # numbers that differ by as little as rounding errors do


class PlanError(ValueError):
    """A lesson's declaration that cannot be used; its message names each exercise and what is wrong with it."""


def lesson_name(lesson: str, solutions: Path = SOLUTIONS) -> str:
    """Return a lesson's whole name for its number or name, "01" -> "01_hsl_filtering", or raise a PlanError."""
    names = sorted(path.stem for path in (solutions / "exercises").glob(f"{lesson_names.PATTERN}.py"))
    meant = lesson_names.meant(lesson, names)
    if len(meant) != 1:
        raise PlanError(f"there is no one lesson {lesson!r} with exercises in {solutions}; there are {names}")
    return meant[0]


def load_plan(path: str | Path) -> LessonPlan:
    """Load the PLAN of a declaration file; its cases are not made yet, see `proving.plan_checks.check_plan`.

    Raise a PlanError if it cannot be run, declares no PLAN, or declares wrong values: one line for each problem.
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
        with resolved_by(_not_yet):
            spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise PlanError(f"{file.name}: {raised_at(error)}") from error
    plan = getattr(module, "PLAN", None)
    if not isinstance(plan, LessonPlan):
        raise PlanError(f"{file.name}: it must give the name PLAN to a LessonPlan")
    problems = list(declaration_problems(plan))
    if problems:
        raise PlanError("\n".join(f"{file.name}: {problem}" for problem in problems))
    return plan


def _not_yet(use: str) -> Any:
    raise PlanError(
        f"{in_words(use)} is called while exercises are declared; only cases, mistakes and the like may"
    )


def solution_notebook(lesson: str, solutions: Path = SOLUTIONS) -> Path:
    """Return the path of a lesson's solution notebook; raise a FileNotFoundError if it has not been built."""
    path = solutions / f"{lesson_name(lesson, solutions)}.ipynb"
    if not path.is_file():
        raise FileNotFoundError(f"there is no {path}: run `nao-course build` first")
    return path


def reference(lesson: str, solutions: Path = SOLUTIONS) -> Definitions:
    """Load a lesson's solution: the functions that its solution notebook defines, by name."""
    return load_solution(solution_notebook(lesson, solutions))


def load_solution(path: Path) -> Definitions:
    """Load a solution notebook; functions of earlier lessons come from the solution notebooks beside it."""
    resolve = solutions_beside(path)

    def earlier(use: str) -> Any:
        function = resolve(use)
        return stand_in(use, lambda: function)

    return load_definitions(path, earlier=earlier)


def solutions_beside(notebook: Path) -> Callable[[str], Any]:
    """Return what finds "01:name" in the solution notebooks of earlier lessons beside one; each is loaded once."""
    loaded: dict[str, Definitions] = {}

    def resolve(use: str) -> Any:
        lesson, name = split_use(use)
        if lesson >= lesson_names.number_of(notebook.stem):
            raise PlanError(f"{notebook.stem}: {use!r} is of no earlier lesson")
        if lesson not in loaded:
            loaded[lesson] = load_solution(earlier_notebook(notebook, lesson))
        if name not in loaded[lesson]:
            raise PlanError(f"{notebook.stem}: the solution of lesson {lesson} does not define {name}")
        return loaded[lesson][name]

    return resolve


def earlier_notebook(notebook: Path, lesson: str) -> Path:
    """Return the path of another lesson's notebook, given by its number, in the folder of one.

    Raise a FileNotFoundError unless there is exactly one.
    """
    found = sorted(notebook.parent.glob(f"{lesson_names.PATTERN}.ipynb"))
    paths = [path for path in found if lesson_names.number_of(path.stem) == lesson]
    if len(paths) != 1:
        raise FileNotFoundError(
            f"there is no one notebook of lesson {lesson} in {notebook.parent}: run `nao-course build` first"
        )
    return paths[0]


def with_answers(exercise: Exercise, cases: Sequence[Case], function: Callable[..., Any]) -> list[Case]:
    """Return cases with the reference's answers, except for `Between`, whose cases contain an interval.

    The answers are copied through the codec, so they share no memory with the reference. Raise a PlanError if the
    reference raises, is wrong by its own comparison, or answers what cannot be sent.
    """
    solved = []
    for number, case in enumerate(cases, start=1):
        where = f"{exercise.name}: the reference, case {number} {case.name!r},"
        outcome = call_in_time(exercise, function, case)
        if outcome.status != ("raised" if case.raises else "value"):
            raise PlanError(
                f"{where} gives no answer: {outcome.status} {outcome.text} {outcome.line}".rstrip()
            )
        try:
            answer = decode(encode(outcome.value))
        except CodecError as error:
            raise PlanError(f"{where} gives an answer that cannot be sent: {error}") from None
        try:
            known = replace(case, expected=exercise.comparison.expects(case, answer))
            verdict = judging.judge(exercise.comparison, known, outcome)
        except Exception as error:
            kind = type(exercise.comparison).__name__
            raise PlanError(f"{where} gives what {kind} cannot compare: {describe(error)}") from error
        if not verdict:
            said = verdict.text if verdict is not None else f"it raises {outcome.text}, not {case.raises}"
            raise PlanError(f"{where} is not right by its own comparison: {said}")
        if outcome.changed:
            raise PlanError(f"{where} changes its input")
        solved.append(known)
    return solved


def raised_at(error: Exception) -> str:
    """Say what the author's own function raised, and in which line: "line 12: ValueError: high <= 0"."""
    line = own_line(error).partition(":")[0]
    return f"{line}: {describe(error)}" if line else describe(error)


def call_in_time(exercise: Exercise, function: Callable[..., Any], case: Case) -> Outcome:
    """Call a reference, mistake or alternative; stop a call that does not end."""
    answer = partial(judging.answer, exercise.comparison)
    return call_all(function, [case], exercise.driver, PATIENCE * exercise.seconds, answer)[0]


def made_cases(exercise: Exercise, seed: int | None = None) -> list[Case]:
    """Make an exercise's public cases without answers, or with a seed draw hidden ones.

    Raise a PlanError if the author's function raises, or returns anything but cases.
    """
    kind = "public" if seed is None else "hidden"
    try:
        cases = exercise.public() if seed is None else exercise.hidden(np.random.default_rng(seed))
    except Exception as error:
        raise PlanError(f"{exercise.name}: its {kind} cases: {raised_at(error)}") from error
    problems = list(case_problems(exercise, cases, kind))
    if problems:
        raise PlanError("\n".join(problems))
    return cases


def hidden_cases(exercise: Exercise, function: Callable[..., Any], seed: int) -> list[Case]:
    """Draw an exercise's hidden cases, with the reference's answers."""
    return with_answers(exercise, made_cases(exercise, seed), function)


def with_mistakes(plan: LessonPlan, reference: Mapping[str, Callable[..., Any]]) -> LessonPlan:
    """Return a plan whose mistakes can be called: changes of the solution are applied to it.

    Raise a PlanError with one line for each change that does not fit the solution.
    """
    try:
        return with_functions(plan, reference)
    except ChangeError as error:
        raise PlanError(str(error)) from error


def publish(
    lesson: str, plan: LessonPlan, reference: Mapping[str, Callable[..., Any]], *, pairs: bool = True
) -> PublicLesson:
    """Make the part of a plan that a student's copy contains: inputs and outputs, no code, ready for `checking.pack`.

    The number of the lesson becomes the exercises'. `pairs` says whether to look for pairs of mistakes that can be
    recognised, which takes most of the time. Raise a PlanError if the reference lacks an exercise or fails in one.
    """
    plan = with_mistakes(plan, reference)
    exercises = [
        publish_exercise(
            exercise_number(lesson, number), exercise, reference_of(reference, exercise), pairs=pairs
        )
        for number, exercise in enumerate(plan.exercises, start=1)
    ]
    return public_lesson(lesson, plan, reference, exercises)


def public_lesson(
    lesson: str,
    plan: LessonPlan,
    reference: Mapping[str, Callable[..., Any]],
    exercises: Sequence[PublicExercise],
) -> PublicLesson:
    """Make what a student's copy carries of a plan whose exercises are published; see `publish`."""
    for exercise, public in zip(plan.exercises, exercises, strict=True):
        for problem in undeclared_uses(plan, exercise, public, reference[exercise.name]):
            raise PlanError(problem)
    questions = [
        PublicQuestion(each.name, each.text, dict(each.choices), each.right) for each in plan.questions
    ]
    written = [
        PublicWritten(each.name, exercise_number(lesson, f"W{number}"), float(each.points))
        for number, each in enumerate(plan.written, start=1)
    ]
    shown = demonstrated(reference.text.cells) if isinstance(reference, Definitions) else []
    return PublicLesson(lesson, list(exercises), questions, written, shown)


def exercise_number(lesson: str, number: int | str) -> str:
    """Return how a text calls an exercise or a written answer: "01_hsl_filtering", 3 -> "1.3"."""
    return f"{int(lesson_names.number_of(lesson))}.{number}"


def publish_exercise(
    number: str, exercise: Exercise, function: Callable[..., Any], *, pairs: bool = True
) -> PublicExercise:
    """Make the part of an exercise, such as "1.3", that a student's copy contains, with every mistake's answers.

    `pairs` says whether to look for pairs of mistakes.
    """
    with watching(keep=True) as calls:
        cases = with_answers(exercise, made_cases(exercise), function)
    with without_numeric_warnings():
        perturbed = [_perturbed(exercise, case, function) for case in cases]
        mistakes = [
            PublicMistake(mistake.message, _answers(exercise, cases, perturbed, mistake.function))
            for mistake in exercise.mistakes
        ]
        found = _recognisable_pairs(exercise, cases, perturbed, mistakes) if pairs else []
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
        seconds=float(exercise.seconds),
        earlier=list({encode(each): each for each in calls.made}.values()),
        uses=list(exercise.uses),
        pairs=found,
        sibling=exercise.sibling,
    )


def _recognisable_pairs(
    exercise: Exercise,
    cases: Sequence[Case],
    perturbed: Sequence[Sequence[Case]],
    mistakes: Sequence[PublicMistake],
) -> list[MistakePair]:
    """Return the pairs of mistakes that a check can recognise; see `mistakes.pairs`.

    A class has none: a check reports each of its methods by itself, and running some 700 pairs took four fifths of
    the time of proving a lesson.
    """
    if exercise.driver == "methods":
        return []
    answer = partial(judging.answer, exercise.comparison)

    def run(function: Callable[..., Any]) -> list[Outcome]:
        return call_all(function, cases, exercise.driver, PAIR_SECONDS, answer)

    def is_stable(function: Callable[..., Any], number: int, wrong: Any) -> bool:
        outcomes = call_all(function, perturbed[number], exercise.driver, PAIR_SECONDS, answer)
        return all(_right_or_same(exercise, cases[number], wrong, each) for each in outcomes)

    def keeps_verdict(function: Callable[..., Any], number: int, right: bool) -> bool:
        outcomes = call_all(function, perturbed[number], exercise.driver, PAIR_SECONDS, answer)
        return all(
            bool(judging.judge(exercise.comparison, cases[number], each)) == right for each in outcomes
        )

    return recognisable(exercise, cases, mistakes, run, is_stable, keeps_verdict)


def reference_of(reference: Mapping[str, Callable[..., Any]], exercise: Exercise) -> Callable[..., Any]:
    """Return an exercise's reference function; raise a PlanError if the solution lacks it."""
    if exercise.name not in reference:
        raise PlanError(f"{exercise.name}: the solution notebook does not define it")
    return reference[exercise.name]


def _perturbed(exercise: Exercise, case: Case, function: Callable[..., Any]) -> list[Case]:
    """Return the perturbed variants of a case; an empty list if the reference's answer is not right for all of them.

    Such a case is at a limit on purpose, for example a hue at the threshold. Its inputs are the same on every
    processor, so a mistake's answers to other inputs mean nothing.
    """
    variants = list(perturbed_cases(case))
    outcomes = [call_in_time(exercise, function, each) for each in variants]
    right = all(judging.judge(exercise.comparison, case, outcome) for outcome in outcomes)
    return variants if right else []


def _answers(
    exercise: Exercise,
    cases: Sequence[Case],
    perturbed: Sequence[Sequence[Case]],
    function: Callable[..., Any],
) -> dict[str, Any]:
    """Return a mistake's wrong answers by the number of the case; see `PublicMistake`."""
    answers: dict[str, Any] = {}
    for number, (case, variants) in enumerate(zip(cases, perturbed, strict=True)):
        outcome = call_in_time(exercise, function, case)
        if outcome.status == "timed out":
            raise PlanError(
                f"{exercise.name}: a mistake does not end in public case {number + 1} {case.name!r}"
            )
        if judging.judge(exercise.comparison, case, outcome):
            continue
        raised = {"raises": re.split("[: ]", outcome.text)[0]}
        answer = outcome.value if outcome.status == "value" else raised
        others = (call_in_time(exercise, function, each) for each in variants)
        stable = all(_right_or_same(exercise, case, answer, other) for other in others)
        answers[str(number)] = answer if stable else {"unstable": answer}
    return answers


def _right_or_same(exercise: Exercise, case: Case, answer: Any, outcome: Outcome) -> bool:
    """Return whether a mistake's answer to a perturbed case is the same wrong answer, or right.

    A comparison that allows no difference at all would count the perturbation itself, which `SAME` does not.
    """
    return (
        bool(judging.judge(exercise.comparison, case, outcome))
        or judging.same_answer(exercise, answer, outcome)
        or (outcome.status == "value" and SAME.alike(answer, outcome.value))
    )
