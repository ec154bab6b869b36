"""The file course.toml: read, checked, and what is wrong in it said with its key and what is allowed."""

import math
import tomllib
import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from nao_course.exercises import lesson_names
from nao_course.instructor.gradebook.late import LatePolicy

NAME = "course.toml"
_KEYS = ("title", "version", "lessons", "points", "deadlines", "extensions", "late")
_LATE = ("per_day", "grace_hours", "most")
_MOST_HOURS = 24.0 * 366


class CourseFileError(ValueError):
    """A course.toml that is not understood; its message names the key and what is allowed."""


@dataclass(frozen=True)
class CourseFile:
    """The content of a course.toml: the releases' title and version, numbers of the lessons (all if empty), points.

    The points, by exercise, differ from the declarations'; the late policy has deadlines, extensions and deductions.
    """

    title: str
    version: str
    lessons: tuple[str, ...]
    points: Mapping[str, float]
    late_policy: LatePolicy


def read_course_file(root: Path) -> CourseFile:
    """Read the course.toml of a folder; raise a CourseFileError if it is not TOML, or a key or value is not allowed."""
    try:
        table = tomllib.loads((root / NAME).read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise CourseFileError(f"{NAME}: it is not TOML: {error}") from None
    _only(table, _KEYS)
    there = sorted(path.stem for path in (root / "solutions").glob(f"{lesson_names.PATTERN}.md"))
    late = _table(table, "late")
    _only(late, _LATE, "late.")
    policy = LatePolicy(
        _deadlines(table, "deadlines", there),
        {
            unicodedata.normalize("NFC", student): _deadlines(
                _table(table, "extensions"), student, there, "extensions."
            )
            for student in _table(table, "extensions")
        },
        **{
            key: _value(late, key, _amount(most), f"a number from 0 to {most:g}", "late.")
            for key, most in {"per_day": 1.0, "grace_hours": _MOST_HOURS, "most": 1.0}.items()
            if key in late
        },
    )
    points = _table(table, "points")
    return CourseFile(
        _value(table, "title", _is_text, 'a text, such as "Robotics"'),
        _value(table, "version", _is_text, 'a text, such as "1.0"'),
        tuple(_value(table, "lessons", _are_texts, 'a list of numbers such as ["00", "01"]', default=())),
        {name: _value(points, name, _amount(math.inf), "a number, 0 or more", "points.") for name in points},
        policy,
    )


def _deadlines(
    table: Mapping[str, Any], key: str, there: Sequence[str], above: str = ""
) -> dict[str, datetime]:
    """Return a table of times by the lessons' whole names."""
    found = {}
    given = _table(table, key, above)
    for word in given:
        meant = lesson_names.meant(word, there)
        if not meant:
            raise CourseFileError(
                f"{NAME}: {above}{key}: there is no lesson {word!r}; there are {', '.join(there) or 'none'}"
            )
        wanted = "a time with its offset from UTC, such as 2026-11-20T23:59:00+01:00"
        found[meant[0]] = _value(given, word, _is_time, wanted, f"{above}{key}.")
    return found


def _table(table: Mapping[str, Any], key: str, above: str = "") -> dict[str, Any]:
    return _value(table, key, lambda value: isinstance(value, dict), "a table", above, default={})


def _value(
    table: Mapping[str, Any],
    key: str,
    is_right: Callable[[Any], bool],
    wanted: str,
    above: str = "",
    default: Any = None,
) -> Any:
    """Return a value, or say what it must be."""
    if key not in table and default is not None:
        return default
    if key not in table:
        raise CourseFileError(f"{NAME}: {above}{key} is missing; it must be {wanted}")
    if not is_right(table[key]):
        raise CourseFileError(f"{NAME}: {above}{key} must be {wanted}, got {str(table[key])[:80]!r}")
    return table[key]


def _only(table: Mapping[str, Any], keys: Sequence[str], above: str = "") -> None:
    for key in table:
        if key not in keys:
            raise CourseFileError(f"{NAME}: {above}{key} is not understood; there are {', '.join(keys)}")


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _are_texts(value: Any) -> bool:
    return isinstance(value, list) and all(map(_is_text, value))


def _is_time(value: Any) -> bool:
    return isinstance(value, datetime) and value.tzinfo is not None


def _amount(most: float) -> Callable[[Any], bool]:
    return lambda value: type(value) in (int, float) and 0 <= value <= most and math.isfinite(value)
