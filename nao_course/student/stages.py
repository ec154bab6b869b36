"""The stages of the student's robot, and which of them the student's own functions make ready."""

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
from nao_course.exercises.trying import strict
from nao_course.student.notebooks import own_function, stored_result

if TYPE_CHECKING:  # the panels take long to import
    from nao_course.widgets.control_panel import Stage

# The stage of each lesson, in the course's order; lesson NN_name defines STAGE in nao_course/lessons/name/stage.py.
PLANNED = {
    "01": "labels",
    "02": "goal posts",
    "03": "corners",
    "04": "points on the map",
    "05": "dead reckoning",
    "06": "pose",
    "07": "growing map",
    "08": "map after the drive",
    "10": "corners, best setting",
    "11": "estimate",
    "12": "next move",
}


@dataclass(frozen=True)
class Readiness:
    """The stages of the robot that are ready, and the reasons why others are not.

    `functions` are the student's functions that the ready `stages` call, `missing` says why each other stage cannot
    run, and `remarks` are sentences about optional functions that ready stages lack.
    """

    stages: tuple[Stage, ...] = ()
    functions: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    missing: Mapping[str, str] = field(default_factory=dict)
    remarks: tuple[str, ...] = ()


def all_stages() -> list[Stage]:
    """Return the stages of all lessons, in the lessons' order."""
    modules = (f"nao_course.lessons.{lesson.partition('_')[2]}" for lesson in lessons())
    return [
        importlib.import_module(f"{module}.stage").STAGE
        for module in modules
        if find_spec(module) and find_spec(f"{module}.stage")
    ]


def split_after(stages: Sequence[Stage], upto: str) -> tuple[list[Stage], list[Stage]]:
    """Return the stages of the lessons up to the number `upto`, and the later ones; all and none if it is empty."""
    if upto not in {"", *map(number_of, lessons())}:
        known = ", ".join(map(number_of, lessons()))
        raise ValueError(f"upto must be the number of a lesson, as a text: {known}; got {upto!r}")
    first = [stage for stage in stages if not upto or number_of(stage.lesson) <= upto]
    return first, [stage for stage in stages if stage not in first]


def any_ready(found: Readiness, later: Sequence[Stage], folder: Path) -> bool:
    """Return whether a later stage is ready too, by stored results of earlier checks alone; False in a build."""
    ready = len(found.stages)
    for stage in () if strict() else later:
        found = add_from_stored(found, stage, folder) or found
    return len(found.stages) > ready


def readiness(stages: Sequence[Stage], given: Mapping[str, Any], folder: Path) -> Readiness:
    """Determine which stages can run.

    `given` are functions by name, for example from the present notebook. If one does not pass its public checks, the
    function of the saved notebook in the folder is used instead.
    """
    found = Readiness()
    for stage in stages:
        found = add_ready(found, stage, given, folder)
    return found


def add_ready(
    found: Readiness, stage: Stage, given: Mapping[str, Any], folder: Path, most_seconds: float = np.inf
) -> Readiness:
    """Add one stage to a `Readiness`; `most_seconds` as in `nao_course.student.functions`."""
    lacking = _lacks_first(found, stage)
    functions: dict[str, Any] = {}
    remarks: list[str] = []
    for use in () if lacking else _full(stage, (*stage.uses, *stage.helped_by)):
        name = use.partition(":")[2]
        function, lacking = own_function(use, given, folder, most_seconds)
        if lacking and use in _full(stage, stage.helped_by):
            remarks.append(f"{stage.name} runs without {name}, because {lacking}")
            lacking = ""
        elif lacking:
            break
        else:
            functions[name] = function
    return _with(found, stage, lacking, functions, remarks)


def add_from_stored(found: Readiness, stage: Stage, folder: Path) -> Readiness | None:
    """Add one stage, without its functions, by stored results of earlier checks; None if a notebook was saved since."""
    lacking = _lacks_first(found, stage)
    for use in () if lacking else _full(stage, stage.uses):
        stored = stored_result(use, folder)
        if stored is None:
            return None
        if lacking := stored:
            break
    return _with(found, stage, lacking, {})


def _full(stage: Stage, uses: Sequence[str]) -> list[str]:
    """Return the exercises that a stage uses, each with the number of its lesson."""
    return [use if ":" in use else f"{number_of(stage.lesson)}:{use}" for use in uses]


def _lacks_first(found: Readiness, stage: Stage) -> str:
    """Return the first stage that this stage needs and that is not ready, as a clause; empty if all are ready."""
    return next((f"it needs {name}" for name in stage.after if name in found.missing), "")


def _with(
    found: Readiness,
    stage: Stage,
    lacking: str,
    functions: Mapping[str, Callable[..., Any]],
    remarks: Sequence[str] = (),
) -> Readiness:
    """Return a `Readiness` with one more stage, or with the reason why it is missing."""
    if lacking:
        return replace(found, missing={**found.missing, stage.name: lacking})
    return replace(
        found,
        stages=(*found.stages, stage),
        functions={**found.functions, **functions},
        remarks=(*found.remarks, *remarks),
    )


def next_planned(ready: Sequence[Stage]) -> tuple[str, str] | None:
    """Return the lesson's number and the name of the next stage; None if the robot has all stages."""
    there = {number_of(stage.lesson) for stage in ready}
    return next(((number, name) for number, name in PLANNED.items() if number not in there), None)


def adds_no_stage(number: str, stages: Sequence[Stage]) -> bool:
    """Return whether a lesson adds no stage to the robot; False for lesson 00, which introduces the robot itself."""
    return number not in {"", "00", *PLANNED, *(number_of(stage.lesson) for stage in stages)}


def names_of(stages: Sequence[Stage]) -> list[str]:
    """Return the names of stages with the numbers of their lessons: "labels (01)"."""
    return [f"{stage.name} ({number_of(stage.lesson)})" for stage in stages]
