"""Which challenge a word means: each is declared in the folder of its lesson."""

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
        Its number or name: 1, "01" or "01_hsl_filtering".

    Returns
    -------
    Board
        It shows itself, and its `enter` takes your entry.

    Raises
    ------
    ValueError
        If there is no such challenge.
    """
    for name in meant(str(lesson), lessons()):
        if made := _declared_in(name.partition("_")[2]):
            return Board(made)
    raise ValueError(f"there is no challenge {lesson!r}; there are {', '.join(declared())}")


def declared() -> dict[str, Challenge]:
    """Return all challenges by their lessons: each lesson's folder may have a `challenge` module with a `CHALLENGE`."""
    folders = pkgutil.iter_modules(importlib.import_module(LESSONS).__path__)
    found = [_declared_in(folder.name) for folder in folders if folder.ispkg]
    return {made.lesson: made for made in sorted(filter(None, found), key=lambda each: each.lesson)}


def _declared_in(folder: str) -> Challenge | None:
    """The challenge of a lesson's folder; only that one is imported."""
    name = f"{LESSONS}.{folder}.challenge"
    try:
        there = importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:  # not even the folder
        return None
    made: Challenge | None = importlib.import_module(name).CHALLENGE if there else None
    return made
