"""The line on top of a lesson: what the student's robot has so far, and what comes next."""

from __future__ import annotations

import time
from dataclasses import dataclass
from html import escape

import numpy as np

from nao_course.exercises.checking import strict
from nao_course.exercises.lesson_names import number_of
from nao_course.exercises.running import TimeIsUp, alarm
from nao_course.student.notebooks import notebooks_folder
from nao_course.student.stages import Readiness, add_ready, all_stages, brings_nothing, names_of, next_planned

SECONDS = 0.45  # for looking at the notebooks: a lesson begins with this
_TOO_LONG = "looking at your notebooks takes longer: progress() takes its time"


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
        What that still lacks, in a sentence; empty where its lesson has not been begun. Without anything that comes
        next: why nobody knows.
    idle : str
        Number of the lesson that begins, where it brings nothing new to the robot; empty otherwise.
    """

    ready: tuple[str, ...] = ()
    coming: str = ""
    why: str = ""
    idle: str = ""

    def __repr__(self) -> str:
        """The line as text."""
        there = ", ".join(f"✔ {name}" for name in self.ready) or "nothing yet"
        why = f" ({self.why})" if self.why else ""
        coming = f"next: {self.coming}{why}" if self.coming else self.why or "that is all the course gives it"
        idle = f"lesson {self.idle} adds nothing to it · " if self.idle else ""
        return f"Your NAO so far: {there} · {idle}{coming}"

    def _repr_html_(self) -> str:
        """The line in a quiet box."""
        style = "border-left: 4px solid #0b5fa5; padding: 0.2em 0.8em; margin: 0.3em 0; font-size: 90%"
        return f'<div role="note" class="nao-strip" style="{style}">{escape(repr(self))}</div>'


def so_far(lesson: str = "", seconds: float | None = None) -> Strip:
    """Say what your robot has so far, by your saved notebooks, and what comes next; `my_nao` lets you drive it.

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
    folder, found, late, end = notebooks_folder(), Readiness(), "", time.monotonic() + seconds
    try:
        with alarm(min(seconds, 3600.0)):
            for stage in stages:
                more = add_ready(found, stage, {}, folder, seconds)
                if time.monotonic() >= end:  # what was looked at last may be called too slow by this alone
                    raise TimeIsUp
                found = more
    except TimeIsUp:
        late = _TOO_LONG
    coming = next_planned(found.stages)
    if coming is None:
        return Strip(tuple(names_of(found.stages)), idle=idle)
    number, name = coming
    if late and name not in found.missing:
        return Strip(tuple(names_of(found.stages)), why=late, idle=idle)  # it may be solved: nobody looked
    return Strip(tuple(names_of(found.stages)), f"{name} ({number})", found.missing.get(name, ""), idle)
