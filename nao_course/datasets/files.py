"""Where the recordings are, and files of them that may hold anything."""

from __future__ import annotations

import os
from pathlib import Path

DATA_VARIABLE = "NAO_COURSE_DATA"


def data_folder() -> Path:
    """Return the folder that holds the recordings, which are no part of the project.

    It is the one the environment variable NAO_COURSE_DATA names; without it, ``shared/data`` beside
    the project's own folder.

    Returns
    -------
    Path
        An existing folder.

    Raises
    ------
    FileNotFoundError
        If there is none; it says what to do.
    """
    named = os.environ.get(DATA_VARIABLE)
    folder = Path(named).expanduser() if named else Path(__file__).resolve().parents[3] / "shared" / "data"
    if not folder.is_dir():
        where = (
            f"{DATA_VARIABLE} names {named!r}, which is no folder" if named else f"{DATA_VARIABLE} is not set"
        )
        raise FileNotFoundError(
            f"The recordings are not here: {where}. They are no part of the course; whoever has them sets "
            f"the environment variable {DATA_VARIABLE} to the folder that holds amsterdam_2013 and slam."
        )
    return folder


def contents(path: Path, largest: int) -> bytes:
    """Read a file of no more than `largest` bytes; another is a ValueError that names it."""
    try:
        with path.open("rb") as file:
            data = file.read(largest + 1)
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror or error})") from None
    if not data or len(data) > largest:
        raise ValueError(f"{path}: expected 1 to {largest} bytes, got {'more' if data else 'an empty file'}")
    return data


def brief(value: object) -> str:
    """Show the beginning of a value of any size."""
    if isinstance(value, list | dict):
        return f"{'a list' if isinstance(value, list) else 'an object'} of {len(value)}"
    if isinstance(value, int) and abs(value) > 10**40:
        return "an integer of more than 40 digits"
    return "nothing" if value is None else f"{value!r:.60}"
