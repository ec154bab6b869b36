"""What a submission uses of earlier exercises: the student's own work, and the reference's for a second run."""

import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from typing import Any

import numpy as np

from nao_course.exercises.case import Case
from nao_course.exercises.earlier import Calls, EarlierNotUsable, split_use
from nao_course.exercises.exercise import PublicExercise
from nao_course.exercises.judging import judge
from nao_course.exercises.lesson_names import meant
from nao_course.exercises.notebook_text import DEFINED
from nao_course.exercises.running import Outcome, outcome_of
from nao_course.instructor.autograding.assignment import Assignment, Task, UsedClass, loaded_in, words_of
from nao_course.instructor.collecting.files import Files
from nao_course.instructor.sandbox.protocol import Allowance, EarlierNotebook
from nao_course.instructor.sandbox.warm_server import WarmServer
from nao_course.instructor.sandbox.worker import Worker

ReferenceFunction = Callable[[tuple[Any, ...], dict[str, Any]], Outcome]

STOOD_IN = (
    "Recorded answers stood in for your earlier work, as they do in your notebook while it is not usable."
)


def in_words(use: str) -> str:
    """Name an earlier exercise as a page does.

    >>> in_words("hue_mask"), in_words("01:hue_mask")
    ('hue_mask', 'hue_mask of lesson 01')
    """
    lesson, name = split_use(use)
    return f"{name} of lesson {lesson}" if lesson else name


def handed_in_earlier(files: Files, assignment: Assignment) -> list[EarlierNotebook]:
    """Return the student's own notebooks of the lessons that an assignment uses."""
    return [
        EarlierNotebook(each.lesson, own.notebook, own.helpers, each.setup)
        for each in assignment.earlier
        if (own := files.earlier.get(each.lesson))
    ]


def origins_of(uses: Sequence[str], files: Files, assignment: Assignment) -> Iterator[str]:
    """Return a note for each used earlier lesson whether the student submitted it."""
    numbers = sorted({split_use(use)[0] for use in uses} - {""})
    for number in numbers:
        for lesson in meant(number, [each.lesson for each in assignment.earlier]):
            if lesson in files.earlier:
                yield f"Yours of lesson {number} came from the {lesson}.ipynb that you handed in."
            else:
                yield f"Of lesson {number} there is no notebook of yours that could be read."


def used_by(task: Task, assignment: Assignment, cells: Iterable[str]) -> tuple[str, ...]:
    """Return what an exercise uses: what is declared, and what else of the set-up cell the student's answer names.

    `cells` are the notebook's code cells; cells that define another exercise do not count.
    """
    others = {each.public.name for each in assignment.tasks} - {task.public.name}
    named: set[str] = set()
    for cell in cells:
        defined = set(DEFINED.findall(cell))
        if task.public.name in defined or (defined and others.isdisjoint(defined)):
            named |= words_of(cell)
    lessons = [each.lesson for each in assignment.earlier]
    loaded = [use for use in loaded_in(assignment.setup, named) if meant(split_use(use)[0], lessons)]
    return tuple(dict.fromkeys([*task.uses, *loaded]))


def dependencies_of(uses: Iterable[str], classes: Mapping[str, UsedClass]) -> list[str]:
    """Return what is used, and what classes among it use themselves."""
    found: list[str] = []
    left = list(uses)
    while left:
        use = left.pop(0)
        if use not in found:
            found.append(use)
            left += classes[use].uses if use in classes else ()
    return found


def notebook_of(sources: Iterable[str]) -> bytes:
    """Make a notebook of some cells."""
    cells: list[dict[str, Any]] = [
        {"cell_type": "code", "metadata": {}, "source": source, "outputs": [], "execution_count": None}
        for source in sources
    ]
    return json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": {}, "cells": cells}).encode()


def recorded(exercise: PublicExercise, allowance: Allowance) -> dict[str, ReferenceFunction]:
    """Return functions that answer from recorded calls, as a check does while earlier functions are not usable.

    Looking answers up takes processor time of the grader's own process, limited by the allowance.
    """
    calls = Calls(exercise.earlier)

    def of(use: str) -> ReferenceFunction:
        reason = EarlierNotUsable(f"{in_words(use)} is not usable yet.")

        def answer(args: tuple[Any, ...], kwargs: dict[str, Any]) -> Outcome:
            allowance.left()
            began = time.thread_time()  # without other threads and programs
            try:
                return outcome_of(lambda: calls.answer(use, args, kwargs, reason))
            finally:
                allowance.spend(time.thread_time() - began)

        return answer

    return {each.use: of(each.use) for each in exercise.earlier}


def count_passed(exercise: PublicExercise, outcomes: Sequence[Outcome]) -> int:
    """Count the public cases that are right; an answer that nobody can look at is not."""
    passed = 0
    for case, outcome in zip(exercise.cases, outcomes, strict=False):
        with suppress(Exception), np.errstate(all="ignore"):
            passed += bool(judge(exercise.comparison, case, outcome))
    return passed


class References:
    """The reference's functions of an assignment and the lessons before it, each lesson in a worker of its own.

    The stack ends the workers. `seconds` limit a call, and the allowance everything that is requested of the reference
    on behalf of one exercise of a submission.
    """

    def __init__(
        self,
        assignment: Assignment,
        server: WarmServer | None,
        stack: ExitStack,
        seconds: float,
        allowance: Allowance,
    ) -> None:
        self.assignment, self.server, self.stack, self.seconds = assignment, server, stack, seconds
        self.allowance = allowance
        self.workers: dict[str, Worker] = {}
        self.solved = [
            EarlierNotebook(each.lesson, each.reference.read_bytes(), setup=each.setup)
            for each in assignment.earlier
        ]

    @property
    def deaths(self) -> int:
        """How many of their processes have died."""
        return sum(each.deaths for each in self.workers.values())

    def function(self, use: str) -> ReferenceFunction:
        """Return a function as a worker may ask for it: its code stays in a worker of its own."""
        number, name = split_use(use)
        reference = self.worker(number)

        def answer(args: tuple[Any, ...], kwargs: dict[str, Any]) -> Outcome:
            return replace(reference.call(name, Case(args, kwargs=kwargs)), line="", output="")

        return answer

    def worker(self, number: str) -> Worker:
        """Return the worker of a lesson, given by its number; empty for the assignment's own."""
        if number not in self.workers:
            notebook, setup, before = self.assignment.reference, self.assignment.setup, self.solved
            for at, each in enumerate(self.assignment.earlier):
                if number and meant(number, [each.lesson]):
                    notebook, setup, before = each.reference, each.setup, self.solved[:at]
            made = Worker(
                notebook,
                seconds=self.seconds,
                server=self.server,
                setup=setup,
                earlier=before,
                allowance=self.allowance,
            )
            self.workers[number] = self.stack.enter_context(made)
        return self.workers[number]
