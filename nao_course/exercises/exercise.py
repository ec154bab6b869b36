"""What an exercise is: declared once, by the instructor; everything else is made from it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nao_course.exercises.case import Case
from nao_course.exercises.codec import register
from nao_course.exercises.comparisons.comparison import Comparison
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.earlier import EarlierCall

SECONDS = 10.0  # wall clock of a call in the grader, where an exercise says nothing else
ANSWER_HERE = "*Write your answer here: double-click this text.*"  # where no written answer stands yet


@dataclass(frozen=True)
class Mistake:
    """A wrong implementation that students write, and what helps them.

    Parameters
    ----------
    name : str
        In a few words: "half degrees".
    function : callable
        The wrong implementation.
    message : str
        What the check says to a student whose answers are this mistake's.
    """

    name: str
    function: Callable[..., Any]
    message: str


@dataclass(frozen=True)
class Exercise:
    """An exercise of a lesson.

    Parameters
    ----------
    name : str
        Of the function or class that the student writes; unique in the course.
    points : float
        What it is worth.
    public : callable
        Makes the public cases, the same each time: list of Case. Their pictures have at most 64 x 48 pixels.
    hidden : callable
        Makes hidden cases from a random generator: list of Case.
    comparison : Comparison
        How answers are compared; see `nao_course.exercises.comparisons`.
    hints : (str, str)
        Given one after the other on demand.
    mistakes : sequence of Mistake
        At least three.
    alternatives : mapping of str to callable
        Right implementations of another shape, at least three.
    stars : int
        Difficulty, 1 to 3.
    uses : sequence of str
        Earlier exercises that the function calls: "hue_mask" of this lesson, "01:color_labels" of an earlier one. The
        lesson's set-up cell then says ``color_labels = earlier("01:color_labels")``.
    driver : str
        Where not empty: name of a function, registered with `register_driver`, that runs in the worker and turns what
        the student wrote, a class or a SymPy expression, into arrays. It is called with the student's object before
        the case's arguments.
    in_place : bool
        Whether a function that changes its input fails; else it is only told so.
    with_reference : float
        Fraction of the points that are earned where it is right with the reference's `uses`, but not with the student's
        own: one error is not punished twice.
    equivalents : mapping of str to str
        Lines of the solution's mutants that are right, just written in another way, each with the reason. `nao-course
        mutate` counts these mutants apart, and runs them on more hidden cases than the others.
    seconds : float
        Wall clock that the grader gives one case, all its calls together. The solution must stay below a third of it.
    """

    name: str
    points: float
    public: Callable[[], list[Case]]
    hidden: Callable[[np.random.Generator], list[Case]]
    hints: tuple[str, str]
    mistakes: Sequence[Mistake]
    alternatives: Mapping[str, Callable[..., Any]]
    comparison: Comparison = field(default_factory=Close)
    stars: int = 1
    uses: Sequence[str] = ()
    driver: str = ""
    in_place: bool = False
    with_reference: float = 1.0
    equivalents: Mapping[str, str] = field(default_factory=dict)
    seconds: float = SECONDS


@dataclass(frozen=True)
class Written:
    """A question that is answered in words, and marked by a person.

    Parameters
    ----------
    name : str
        Unique in the course: that of its cell in the lesson.
    points : float
        What it is worth.
    question : str
        What is asked, as the marking sheet says it.
    rubric : str
        What to mark the answer by, for whoever marks it.
    """

    name: str
    points: float
    question: str
    rubric: str


@dataclass(frozen=True)
class Question:
    """A concept question: every wrong choice has its own answer.

    Parameters
    ----------
    name : str
        Unique in the lesson.
    text : str
        The question.
    choices : mapping of str to str
        What can be chosen, and the reply to it.
    right : str
        The right one among them.
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
    """

    exercises: Sequence[Exercise]
    questions: Sequence[Question] = ()
    written: Sequence[Written] = ()

    @property
    def points(self) -> dict[str, float]:
        """What each exercise and each written answer is worth, by its name."""
        exercises = {each.name: each.points for each in self.exercises}
        return exercises | {each.name: each.points for each in self.written}

    def __getitem__(self, name: str) -> Exercise:
        """Return an exercise by its name."""
        for exercise in self.exercises:
            if exercise.name == name:
                return exercise
        raise KeyError(name)


# --- what a student's copy carries: inputs and outputs, no code ---


@register
@dataclass(frozen=True)
class PublicMistake:
    """A mistake's message, and what it answers to the public cases where that is not the right answer.

    Parameters
    ----------
    message : str
        For the student.
    answers : dict of str to object
        By the number of the case, as text; {"raises": name} where it raises.
    """

    message: str
    answers: dict[str, Any]


@register
@dataclass(frozen=True)
class PublicExercise:
    """An exercise as `check` knows it.

    Parameters
    ----------
    name, number : str
        Of the function, and in the lesson: "1.3".
    points : float
        What it is worth.
    stars : int
        Difficulty.
    comparison : Comparison
        How answers are compared.
    cases : list of Case
        With what is expected.
    mistakes : list of PublicMistake
        To recognise.
    hints : list of str
        Two.
    driver : str
        As in Exercise.
    in_place : bool
        As in Exercise.
    seconds : float
        As in Exercise.
    earlier : list of EarlierCall
        Calls of earlier lessons' functions that the reference makes in these cases.
    uses : list of str
        As in Exercise.
    """

    name: str
    number: str
    points: float
    stars: int
    comparison: Comparison
    cases: list[Case]
    mistakes: list[PublicMistake]
    hints: list[str]
    driver: str
    in_place: bool
    seconds: float = SECONDS
    earlier: list[EarlierCall] = field(default_factory=list)
    uses: list[str] = field(default_factory=list)


@register
@dataclass(frozen=True)
class PublicQuestion:
    """A concept question as the lesson asks it."""

    name: str
    text: str
    choices: dict[str, str]
    right: str


@register
@dataclass(frozen=True)
class PublicWritten:
    """A written question as a student knows it: without what it is marked by."""

    name: str
    number: str
    points: float


@register
@dataclass(frozen=True)
class PublicLesson:
    """What a lesson's checks and questions need: the content of its data file."""

    name: str
    exercises: list[PublicExercise]
    questions: list[PublicQuestion]
    written: list[PublicWritten] = field(default_factory=list)
