"""The line on top of a lesson: what the student's robot has so far, and what comes next."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from nao_course.exercises.checking import strict
from nao_course.exercises.lesson_names import number_of
from nao_course.exercises.running import TimeIsUp, alarm
from nao_course.student.notebooks import notebooks_folder
from nao_course.student.stages import (
    Readiness,
    add_looked_at,
    add_ready,
    all_stages,
    brings_nothing,
    names_of,
    next_planned,
)

if TYPE_CHECKING:  # it brings the panels along, which take long to import
    from nao_course.widgets.control_panel import Stage

SECONDS = 0.45  # for looking at the notebooks: a lesson begins with this


@dataclass(frozen=True)
class Strip:
    """A line about the robot.

    Parameters
    ----------
    ready : tuple of str
        What it has: "labels (01)".
    coming : str
        What comes next: "goal posts (02)"; empty when nothing does.
    why : str
        What that still lacks, in a sentence; empty where its lesson has not been begun.
    idle : str
        Number of the lesson that begins, where it brings nothing new to the robot; empty otherwise.
    unseen : tuple of str
        What nobody has looked at yet, for want of time: it may be there or not.
    """

    ready: tuple[str, ...] = ()
    coming: str = ""
    why: str = ""
    idle: str = ""
    unseen: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """The line as text."""
        return f"Your NAO so far: {' · '.join(self._parts())}"

    def _parts(self) -> Iterator[str]:
        if self.ready or not self.unseen:
            yield ", ".join(f"✔ {name}" for name in self.ready) or "nothing yet"
        if self.unseen:
            yield f"not looked at yet, which progress() does: {', '.join(self.unseen)}"
        if self.idle:
            yield f"lesson {self.idle} adds nothing to it"
        if self.coming:
            yield f"next: {self.coming}{f' ({self.why})' if self.why else ''}"
        elif not self.unseen:
            yield "that is all the course gives it"

    def _repr_html_(self) -> str:
        """The line in a quiet box."""
        style = "border-left: 4px solid #0b5fa5; padding: 0.2em 0.8em; margin: 0.3em 0; font-size: 90%"
        return f'<div role="note" class="nao-strip" style="{style}">{escape(repr(self))}</div>'


def so_far(lesson: str = "", seconds: float | None = None) -> Strip:
    """Say what your robot has so far, by your saved notebooks, and what comes next; `my_nao` lets you drive it.

    What was looked at before and not saved since is known at once; for all else there is a moment only.

    Parameters
    ----------
    lesson : str
        Number of the lesson that begins: only those before it count; all by default.
    seconds : float, optional
        Wall clock for looking at the notebooks; by default less than half a second.

    Returns
    -------
    Strip
        To be the last line of a set-up cell.
    """
    if seconds is None:
        seconds = np.inf if strict() else SECONDS  # a built lesson says the same on a busy machine
    every = all_stages()
    stages = [each for each in every if not lesson or number_of(each.lesson) < lesson]
    idle = lesson if brings_nothing(lesson, every) else ""
    found, unseen = _look(stages, notebooks_folder(), seconds)
    ready, names = tuple(names_of(found.stages)), tuple(names_of(unseen))
    number, name = next_planned(found.stages) or ("", "")
    if not name or name in {stage.name for stage in unseen}:  # that may be there
        return Strip(ready, idle=idle, unseen=names)
    return Strip(ready, f"{name} ({number})", found.missing.get(name, ""), idle, names)


def _look(stages: Sequence[Stage], folder: Path, seconds: float) -> tuple[Readiness, list[Stage]]:
    """Return what is ready, and the stages that there was no time to look at."""
    unseen: list[Stage] = []
    found, end = Readiness(), time.monotonic() + seconds
    for stage in stages:
        after_unseen = any(each.name in stage.after for each in unseen)
        more = None if after_unseen else add_looked_at(found, stage, folder)
        if more is None and not after_unseen:
            more = _in_time(found, stage, folder, end - time.monotonic())
        if more is None:
            unseen.append(stage)
        else:
            found = more
    return found, unseen


def _in_time(found: Readiness, stage: Stage, folder: Path, seconds: float) -> Readiness | None:
    """Return what is ready with one more stage; None where that takes too long."""
    if seconds <= 0:
        return None
    began = time.monotonic()
    try:
        with alarm(min(seconds, 3600.0)):
            more = add_ready(found, stage, {}, folder, seconds)
    except TimeIsUp:
        return None
    in_time = (
        time.monotonic() - began < seconds
    )  # what was looked at last may be called too slow by this alone
    return more if in_time else None
