"""The folder of the recordings, and safe reading of files from unknown sources."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from pathlib import Path

from nao_course._internal.text_encodings import NotTextError, decode_text

DATA_VARIABLE = "NAO_COURSE_DATA"


def data_folder() -> Path:
    """Return the folder with the recordings, which are not part of the project.

    The environment variable NAO_COURSE_DATA contains its path. Without the variable, the folder is ``shared/data``
    beside the project's own folder.

    Returns
    -------
    Path
        Existing folder.

    Raises
    ------
    FileNotFoundError
        If the folder does not exist. The message says what to do.
    """
    named = os.environ.get(DATA_VARIABLE)
    folder = Path(named).expanduser() if named else Path(__file__).resolve().parents[3] / "shared" / "data"
    if not folder.is_dir():
        where = (
            f"{DATA_VARIABLE} is {named!r}, which is not a folder" if named else f"{DATA_VARIABLE} is not set"
        )
        raise FileNotFoundError(
            f"The recordings are missing: {where}. They are not part of the course. If you have them, set the "
            f"environment variable {DATA_VARIABLE} to the folder that contains amsterdam_2013 and slam."
        )
    return folder


def contents(path: Path, largest: int) -> bytes:
    """Return the bytes of a file, or raise ValueError if it is missing, empty or larger than `largest` bytes."""
    try:
        with path.open("rb") as file:
            data = file.read(largest + 1)
    except OSError as error:
        raise ValueError(f"{path}: cannot be read ({error.strerror or error})") from None
    if not data or len(data) > largest:
        raise ValueError(f"{path}: expected 1 to {largest} bytes, got {'more' if data else 'an empty file'}")
    return data


def text_of(path: Path, largest: int) -> str:
    """Return the text of a file in any usual encoding, or raise ValueError as `contents` does or if it is not text."""
    try:
        return decode_text(contents(path, largest))
    except NotTextError as error:
        raise ValueError(f"{path}: {error}") from None


def lines_of(path: Path, largest: int, comment: str | None = None) -> Iterator[tuple[str, list[str]]]:
    """Yield a description of each line's place for messages, and its words.

    Only trailing lines may be empty. If the files of a format have comments, lines without words are skipped.
    """
    lines = text_of(path, largest).rstrip().splitlines()
    if not lines:
        raise ValueError(f"{path}: expected lines of numbers, got an empty file")
    for number, line in enumerate(lines, start=1):
        words = (line.partition(comment)[0] if comment else line).split()
        if words:
            yield f"{path}, line {number}", words
        elif not comment:
            raise ValueError(f"{path}, line {number}: the line is empty")


def number_of(word: str, where: str, largest: float) -> float:
    """Return the number that a word is, or raise ValueError if it is not a number or larger than `largest`."""
    try:
        value = float(word) if "_" not in word else math.nan
    except ValueError:
        value = math.nan
    if not abs(value) <= largest:
        raise ValueError(f"{where}: expected a number within +-{largest:g}, got {brief(word)}")
    return value


def brief(value: object) -> str:
    """Describe a value of any size in a few words for an error message."""
    if isinstance(value, list | dict):
        return f"{'a list' if isinstance(value, list) else 'an object'} of {len(value)}"
    if isinstance(value, int) and abs(value) > 10**40:
        return "an integer of more than 40 digits"
    return "nothing" if value is None else f"{value!r:.60}"
