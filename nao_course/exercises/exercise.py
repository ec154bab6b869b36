"""Declarations of exercises, from which check data, grading and documentation are made."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import cleandoc
from typing import Any

import numpy as np

from nao_course.codec import register
from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import Comparison
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.earlier import EarlierCall

SECONDS = 10.0  # default time limit of a call in the grader, wall clock
ANSWER_HERE = "*Write your answer here: double-click this text.*"  # text of a cell without a written answer


@dataclass(frozen=True)
class Mistake:
    """A wrong implementation that students write, with the message that helps them.

    Parameters
    ----------
    name : str
        Name in a few words: "half degrees".
    function : callable
        The wrong implementation. A declaration may instead give a change of the solution, which is applied first; see
        `nao_course.instructor.authoring.mistakes.catalogue`.
    message : str
        Message of the check to a student whose answers equal this mistake's.
    """

    name: str
    function: Callable[..., Any]
    message: str


@register
@dataclass(frozen=True)
class Sibling:
    """A short solved problem that needs an exercise's decisive idea, with other data and another formula.

    Parameters
    ----------
    alike : str
        What is alike in both problems, in one sentence.
    code : str
        Solution of the other problem in Python, which imports NumPy at most and prints its result.
    output : str
        The text that the code prints.
    """

    alike: str
    code: str
    output: str

    @property
    def blocks(self) -> tuple[str, str]:
        """The code and its output without the declaration's indentation."""
        return cleandoc(self.code), cleandoc(self.output)


@dataclass(frozen=True)
class Exercise:
    """An exercise of a lesson.

    Parameters
    ----------
    name : str
        Name of the function or class that the student writes; unique in the course.
    points : float
        Points of the exercise.
    public : callable
        Returns the public cases, a list of Case, the same at each call. Their pictures have at most 64 x 48 pixels.
    hidden : callable
        Returns hidden cases, a list of Case, from a random generator.
    comparison : Comparison
        Comparison of the answers; see `nao_course.exercises.comparisons`.
    hints : (str, str)
        Hints, shown one after the other on demand.
    mistakes : sequence of Mistake
        At least three mistakes, unless the lesson waives rule 8; `nao-course build` warns if there are fewer.
    alternatives : mapping of str to callable
        At least three right implementations of another form, as for mistakes.
    stars : int
        Difficulty, 1 to 3.
    uses : sequence of str
        Earlier exercises that the function calls: "hue_mask" of this lesson, "01:color_labels" of an earlier one. The
        lesson's set-up cell then contains ``color_labels = earlier("01:color_labels")``.
    driver : str
        Name of a function, registered with `register_driver`, that runs in the worker and converts the student's
        class or SymPy expressions to arrays. It is called with the student's object and the case's arguments. By
        default, the student's function itself is called.
    with_reference : float
        Fraction of the points that are earned if the function is right with the reference's `uses`, but not with the
        student's own, so that one error does not cost points twice.
    equivalents : mapping of str to str
        Lines of the solution's mutants that are right but written in another way, each with the reason. `nao-course
        mutate` counts these mutants separately, and runs them on more hidden cases than the others.
    seconds : float
        Time limit of the grader for all calls of one case, wall clock. The solution must need less than a third of it.
    pairs : callable
        Yields the numbers of two mistakes and the solution with both of them. Declarations omit it; it is set when the
        changes are applied to the solution.
    parts : mapping of str to float
        Weights of the parts of a class, such as {"move": 1, "estimate": 2}. The name of each case begins with its part,
        as in "move: a turn". A part earns its share of the points if all hidden cases of this part pass. Where empty,
        the points are earned only if all hidden cases pass.
    sibling : Sibling, optional
        A solved problem with the same idea, shown as the third hint.
    """

    name: str
    points: float
    public: Callable[[], list[Case]]
    hidden: Callable[[np.random.Generator], list[Case]]
    hints: tuple[str, str]
    mistakes: Sequence[Mistake] = ()
    alternatives: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    comparison: Comparison = field(default_factory=Close)
    stars: int = 1
    uses: Sequence[str] = ()
    driver: str = ""
    with_reference: float = 1.0
    equivalents: Mapping[str, str] = field(default_factory=dict)
    seconds: float = SECONDS
    pairs: Callable[[], Iterable[tuple[int, int, Callable[..., Any]]]] = tuple
    parts: Mapping[str, float] = field(default_factory=dict)
    sibling: Sibling | None = None


@dataclass(frozen=True)
class Written:
    """A question that is answered in words, and marked by a person.

    Parameters
    ----------
    name : str
        Unique in the course: the name of its cell in the lesson.
    points : float
        Points of the exercise.
    question : str
        The question, as on the marking sheet.
    rubric : str
        Criteria for marking the answer.
    numbers : callable, optional
        ``numbers(world, predict, ...)`` returns the numbers that a student's answer must contain, by what they are.
        Its first argument is the student's `PersonalWorld`; the others are functions of the solution with the names of
        the parameters, also functions of earlier lessons that the solution loads. The marking page says which of the
        numbers are in the answer.
    """

    name: str
    points: float
    question: str
    rubric: str
    numbers: Callable[..., Mapping[str, float]] | None = None


@dataclass(frozen=True)
class Question:
    """A concept question, with a reply to every choice.

    Parameters
    ----------
    name : str
        Unique in the lesson.
    text : str
        The question.
    choices : mapping of str to str
        Reply to each choice.
    right : str
        The right choice.
    """

    name: str
    text: str
    choices: Mapping[str, str]
    right: str


@dataclass(frozen=True)
class LessonPlan:
    """All exercises and questions of a lesson; a declaration file calls it PLAN.

    Parameters
    ----------
    exercises : sequence of Exercise
        In the order of the lesson.
    questions : sequence of Question
        In the order of the lesson.
    written : sequence of Written
        In the order of the lesson.
    waived : mapping of str to str
        Numbers of the rules in docs/write_a_lesson.md that do not hold for this lesson, each with the reason, such as
        {"3": "a lab of half an hour"}. Only rules about a lesson's size and parts can be waived.
    """

    exercises: Sequence[Exercise]
    questions: Sequence[Question] = ()
    written: Sequence[Written] = ()
    waived: Mapping[str, str] = field(default_factory=dict)

    @property
    def points(self) -> dict[str, float]:
        """Points of each exercise and each written answer, by name."""
        exercises = {each.name: each.points for each in self.exercises}
        return exercises | {each.name: each.points for each in self.written}

    def __getitem__(self, name: str) -> Exercise:
        """Return an exercise by its name."""
        for exercise in self.exercises:
            if exercise.name == name:
                return exercise
        raise KeyError(name)


# --- public data in a student's copy: inputs and outputs without code ---


@register
@dataclass(frozen=True)
class PublicMistake:
    """A mistake's message for the student, and its wrong answers to public cases by the case's number, as text.

    An exception is {"raises": name}. A rounding error, which differs between processors, is {"unstable": answer or
    exception}.
    """

    message: str
    answers: dict[str, Any]


@register
@dataclass(frozen=True)
class MistakePair:
    """Two mistakes of an exercise, by their indices, made together, with the answers by which they are recognised.

    `wrong` are the numbers of all cases whose answers are wrong. `answers` are to a few of these cases, by their
    numbers as text; no single mistake and no other pair has all of them.
    """

    mistakes: tuple[int, int]
    wrong: list[int]
    answers: dict[str, Any]


@register
@dataclass(frozen=True)
class PublicExercise:
    """The public data of an exercise: public cases with expected answers, recognised mistakes, points, hints.

    The number in the lesson is such as "1.3"; `comparison` says how answers are compared. `driver`, `seconds`,
    `sibling` and `uses` are as in `Exercise`. `earlier` are calls of earlier lessons' functions that the reference
    makes in these cases, and `pairs` are recognised if no single mistake fits.
    """

    name: str
    number: str
    points: float
    stars: int
    comparison: Comparison
    cases: Sequence[Case]
    mistakes: Sequence[PublicMistake]
    hints: list[str]
    driver: str
    seconds: float = SECONDS
    earlier: Sequence[EarlierCall] = field(default_factory=list)
    uses: list[str] = field(default_factory=list)
    pairs: Sequence[MistakePair] = field(default_factory=list)
    sibling: Sibling | None = None


@register
@dataclass(frozen=True)
class PublicQuestion:
    """The public data of a concept question."""

    name: str
    text: str
    choices: dict[str, str]
    right: str


@register
@dataclass(frozen=True)
class PublicWritten:
    """The public data of a written question, without the criteria for marking."""

    name: str
    number: str
    points: float


@register
@dataclass(frozen=True)
class PublicLesson:
    """The public data of a lesson's checks and questions: the contents of its data file.

    `demonstrated` has the names that only cells assign which the grader does not run.
    """

    name: str
    exercises: list[PublicExercise]
    questions: list[PublicQuestion]
    written: list[PublicWritten] = field(default_factory=list)
    demonstrated: list[str] = field(default_factory=list)
