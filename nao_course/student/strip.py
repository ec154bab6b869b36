"""The status line of the student's robot at the top of a lesson: its stages so far, and the next one."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from nao_course.exercises.answered import BLANK, copies_of
from nao_course.exercises.lesson_names import number_of
from nao_course.exercises.running import TimeIsUp, alarm
from nao_course.exercises.trying import strict
from nao_course.student.notebooks import notebook_of, notebooks_folder
from nao_course.student.stages import (
    Readiness,
    add_from_stored,
    add_ready,
    adds_no_stage,
    all_stages,
    names_of,
    next_planned,
)

if TYPE_CHECKING:  # the panels take long to import
    from nao_course.widgets.control_panel import Stage

SECONDS = 0.45  # for checking the notebooks: every lesson begins with this line


@dataclass(frozen=True)
class RobotStatus:
    """A line about the stages of the student's robot.

    `ready` are stages such as "labels (01)" and `coming` the next one, if any; `why` says why it is not ready, if that
    is known. `idle` is the present lesson's number if it adds no stage, and `unchecked` are stages that were not
    checked for lack of time, so that they may be ready or not.
    """

    ready: tuple[str, ...] = ()
    coming: str = ""
    why: str = ""
    idle: str = ""
    unchecked: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return the line as text."""
        return f"Your NAO so far: {' · '.join(self._parts())}"

    def _parts(self) -> Iterator[str]:
        if self.ready or not self.unchecked:
            yield ", ".join(f"✔ {name}" for name in self.ready) or "nothing yet"
        if self.unchecked:
            yield f"not checked yet (run progress()): {', '.join(self.unchecked)}"
        if self.idle:
            yield f"lesson {self.idle} adds no stage"
        if self.coming:
            yield f"next: {self.coming}{f' ({self.why})' if self.why else ''}"
        elif not self.unchecked:
            yield "all stages are ready"

    def _repr_html_(self) -> str:
        """Return the line as an HTML box."""
        style = "border-left: 4px solid var(--nao-mark, #0b5fa5); padding: 0.2em 0.8em; margin: 0.3em 0; font-size: 90%"
        return f'<div role="note" class="nao-strip" style="{style}">{escape(repr(self))}</div>'


def so_far(lesson: str = "", seconds: float | None = None) -> RobotStatus:
    """Return the stages of your robot so far, according to your saved notebooks, and the next stage.

    Notebooks that were not saved since their last check take no time. The others are checked within `seconds`. Use
    `my_nao` to drive the robot.

    Parameters
    ----------
    lesson : str
        Number of the present lesson: only earlier lessons count. By default all lessons count.
    seconds : float, optional
        Wall clock for checking the notebooks; by default less than half a second.

    Returns
    -------
    RobotStatus
        The status, shown if it is the last line of a cell.
    """
    if seconds is None:
        seconds = np.inf if strict() else SECONDS  # a built lesson must not depend on the load of the machine
    every = all_stages()
    stages = [each for each in every if not lesson or number_of(each.lesson) < lesson]
    idle = lesson if adds_no_stage(lesson, every) else ""
    found, unchecked = _check(stages, notebooks_folder(), seconds)
    ready, names = tuple(names_of(found.stages)), tuple(names_of(unchecked))
    number, name = next_planned(found.stages) or ("", "")
    if not name or name in {stage.name for stage in unchecked}:  # that may be ready
        return RobotStatus(ready, idle=idle, unchecked=names)
    return RobotStatus(ready, f"{name} ({number})", found.missing.get(name, ""), idle, names)


def _check(stages: Sequence[Stage], folder: Path, seconds: float) -> tuple[Readiness, list[Stage]]:
    """Return the ready stages, and the stages that were not checked for lack of time."""
    unchecked: list[Stage] = []
    found, end = Readiness(), time.monotonic() + seconds
    for stage in stages:
        after_unchecked = any(each.name in stage.after for each in unchecked)
        more = None if after_unchecked else add_from_stored(found, stage, folder)
        if more is None and _is_blank(stage, folder):
            more = replace(found, missing={**found.missing, stage.name: "not begun"})
        if more is None and not after_unchecked:
            more = _in_time(found, stage, folder, end - time.monotonic())
        if more is None:
            unchecked.append(stage)
        else:
            found = more
    return found, unchecked


def _is_blank(stage: Stage, folder: Path) -> bool:
    """Return whether the notebook of a stage's lesson has no answer at all; none of its code runs."""
    notebook = notebook_of(stage.lesson, folder)
    return copies_of(stage.lesson, [notebook])[0].inspection.problem == BLANK


def _in_time(found: Readiness, stage: Stage, folder: Path, seconds: float) -> Readiness | None:
    """Add one stage to a `Readiness`; return None if that takes too long."""
    if seconds <= 0:
        return None
    began = time.monotonic()
    try:
        with alarm(min(seconds, 3600.0)):
            more = add_ready(found, stage, {}, folder, seconds)
    except TimeIsUp:
        return None
    # The last function may have been stopped by this time limit alone.
    in_time = time.monotonic() - began < seconds
    return more if in_time else None
