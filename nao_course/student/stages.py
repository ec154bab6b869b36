"""Which stages the student's robot has, lesson by lesson, and which of them the student's own functions make ready."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_course.exercises.checking import lessons
from nao_course.exercises.lesson_names import number_of
from nao_course.student.notebooks import looked_at, own_function

if TYPE_CHECKING:  # it brings the panels along, which take long to import
    from nao_course.widgets.control_panel import Stage

# What comes when, in the course's order. A lesson NN_name brings its stage as nao_course/lessons/name/stage.py: STAGE.
PLANNED = {
    "01": "labels",
    "02": "goal posts",
    "03": "corners",
    "04": "points on the map",
    "06": "pose",
    "07": "the growing map",
    "08": "the map after the drive",
    "10": "corners, best setting",
    "11": "the estimate",
    "12": "next move",
}


@dataclass(frozen=True)
class Readiness:
    """What of the robot's stages is ready.

    Parameters
    ----------
    stages : tuple of Stage
        Those that can run.
    functions : mapping of str to callable
        The student's own, that they call.
    missing : mapping of str to str
        The name of each other stage that there is, and why it cannot run, in a sentence.
    remarks : tuple of str
        What ready stages do without, a sentence each.
    """

    stages: tuple[Stage, ...] = ()
    functions: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    missing: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


def all_stages() -> list[Stage]:
    """Return the stages of all lessons that there are, in the lessons' order."""
    modules = (f"nao_course.lessons.{lesson.partition('_')[2]}" for lesson in lessons())
    return [
        importlib.import_module(f"{module}.stage").STAGE
        for module in modules
        if find_spec(module) and find_spec(f"{module}.stage")
    ]


def readiness(stages: Sequence[Stage], given: Mapping[str, Any], folder: Path) -> Readiness:
    """Find out which stages can run.

    Parameters
    ----------
    stages : sequence of Stage
        All that there are.
    given : mapping of str to object
        Functions at hand, by name, such as those of the present notebook. One that does not pass its public checks
        gives way to that of the saved notebook.
    folder : Path
        Of the saved notebooks.
    """
    found = Readiness()
    for stage in stages:
        found = add_ready(found, stage, given, folder)
    return found


def add_ready(
    found: Readiness, stage: Stage, given: Mapping[str, Any], folder: Path, most_seconds: float = np.inf
) -> Readiness:
    """Return what is ready with one more stage; `most_seconds` as in `nao_course.student.functions`."""
    lacking = _lacks_first(found, stage)
    functions: dict[str, Any] = {}
    remarks: list[str] = []
    for use in () if lacking else _full(stage, (*stage.uses, *stage.helped_by)):
        name = use.partition(":")[2]
        function, lacking = own_function(use, given, folder, most_seconds)
        if lacking and use in _full(stage, stage.helped_by):
            remarks.append(f"{stage.name} goes on without {name}: {lacking}")
            lacking = ""
        elif lacking:
            break
        else:
            functions[name] = function
    return _with(found, stage, lacking, functions, remarks)


def add_looked_at(found: Readiness, stage: Stage, folder: Path) -> Readiness | None:
    """Return what is ready with one more stage, without its functions, by an earlier look at the saved notebooks.

    Returns
    -------
    Readiness or None
        None where nobody has looked since they were saved.
    """
    lacking = _lacks_first(found, stage)
    for use in () if lacking else _full(stage, stage.uses):
        said = looked_at(use, folder)
        if said is None:
            return None
        if lacking := said:
            break
    return _with(found, stage, lacking, {})


def _full(stage: Stage, uses: Sequence[str]) -> list[str]:
    """Exercises that a stage uses, each with the number of its lesson."""
    return [use if ":" in use else f"{number_of(stage.lesson)}:{use}" for use in uses]


def _lacks_first(found: Readiness, stage: Stage) -> str:
    """Which stage would come before this one and is not ready, in words; empty where all are."""
    return next((f"{name} would come first" for name in stage.after if name in found.missing), "")


def _with(
    found: Readiness,
    stage: Stage,
    lacking: str,
    functions: Mapping[str, Callable[..., Any]],
    remarks: Sequence[str] = (),
) -> Readiness:
    """What is ready with one more stage, or with what it lacks."""
    if lacking:
        return replace(found, missing={**found.missing, stage.name: lacking})
    return replace(
        found,
        stages=(*found.stages, stage),
        functions={**found.functions, **functions},
        remarks=(*found.remarks, *remarks),
    )


def next_planned(ready: Sequence[Stage]) -> tuple[str, str] | None:
    """Number of the lesson, and name, of what the robot gets next; None when it has all."""
    there = {number_of(stage.lesson) for stage in ready}
    return next(((number, name) for number, name in PLANNED.items() if number not in there), None)


def brings_nothing(number: str, stages: Sequence[Stage]) -> bool:
    """Whether a lesson adds nothing to the robot: no stage, there or planned. Lesson 00 brings the robot itself."""
    return number not in {"", "00", *PLANNED, *(number_of(stage.lesson) for stage in stages)}


def names_of(stages: Sequence[Stage]) -> list[str]:
    """Names of stages with the numbers of their lessons: "labels (01)"."""
    return [f"{stage.name} ({number_of(stage.lesson)})" for stage in stages]
