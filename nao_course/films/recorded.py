"""The films that the course ships: drives of the lessons, recorded with the solutions by ``python images/make.py``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from nao_course.films.film import read_film

FOLDER = Path(__file__).with_name("recordings")
LARGEST = 400_000  # bytes of a film


def recorded_names() -> list[str]:
    """Return the names of the recorded films, such as "08_graph_slam" or "demo"."""
    return sorted(path.stem for path in FOLDER.glob("*.json"))


def recorded_film(name: str) -> dict[str, Any]:
    """Return the data of a recorded film.

    Parameters
    ----------
    name : str
        One of `recorded_names`.

    Raises
    ------
    ValueError
        If there is no such film, or its file is not a film.
    """
    if name not in recorded_names():
        raise ValueError(f"there is no film {name!r}; there are {', '.join(recorded_names())}")
    return read_film(FOLDER / f"{name}.json")
