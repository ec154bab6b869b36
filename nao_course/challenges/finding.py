"""Which challenge a word means: each is declared in the folder of its lesson."""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil

from nao_course.challenges.board import Board
from nao_course.challenges.declaration import Challenge
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
    there = declared()
    found = meant(str(lesson), there)
    if len(found) != 1:
        raise ValueError(f"there is no challenge {lesson!r}; there are {', '.join(there)}")
    return Board(there[found[0]])


def declared() -> dict[str, Challenge]:
    """Return all challenges by their lessons: each lesson's folder may have a `challenge` module with a `CHALLENGE`."""
    found: dict[str, Challenge] = {}
    for folder in pkgutil.iter_modules(importlib.import_module(LESSONS).__path__):
        name = f"{LESSONS}.{folder.name}.challenge"
        if importlib.util.find_spec(name) is not None:
            made: Challenge = importlib.import_module(name).CHALLENGE
            found[made.lesson] = made
    return dict(sorted(found.items()))
