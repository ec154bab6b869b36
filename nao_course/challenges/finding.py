"""Find a lesson's challenge, which is declared in the lesson's folder."""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil

from nao_course.challenges.board import Board
from nao_course.challenges.declaration import Challenge
from nao_course.exercises.checking import lessons
from nao_course.exercises.lesson_names import meant

LESSONS = "nao_course.lessons"  # by name: its folders import this package


def challenge(lesson: str | int) -> Board:
    """Return the board of a lesson's challenge.

    Parameters
    ----------
    lesson : str or int
        Number or name of the lesson: 1, "01" or "01_hsl_filtering".

    Returns
    -------
    Board
        The board, which a notebook shows; its `enter` runs your entry.

    Raises
    ------
    ValueError
        If the lesson has no challenge.
    """
    for name in meant(str(lesson), lessons()):
        if made := _declared_in(name.partition("_")[2]):
            return Board(made)
    raise ValueError(f"there is no challenge {lesson!r}; choose one of {', '.join(declared())}")


def declared() -> dict[str, Challenge]:
    """Return all challenges by lesson: the `CHALLENGE` of each module `challenge` in a lesson's folder."""
    folders = pkgutil.iter_modules(importlib.import_module(LESSONS).__path__)
    found = [_declared_in(folder.name) for folder in folders if folder.ispkg]
    return {made.lesson: made for made in sorted(filter(None, found), key=lambda each: each.lesson)}


def _declared_in(folder: str) -> Challenge | None:
    """Import the challenge of a lesson's folder, and no other lesson."""
    name = f"{LESSONS}.{folder}.challenge"
    try:
        there = importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:  # not even the folder
        return None
    made: Challenge | None = importlib.import_module(name).CHALLENGE if there else None
    return made
