"""Folders that hold the work of several students: removed where they are around everything, and refused elsewhere."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from nao_course.instructor.collecting.archives import Item
from nao_course.instructor.collecting.names import (
    clean_name,
    is_a_platforms,
    lesson_of,
    student_of_a_platforms,
)

_MOST_NAMED = 3


@dataclass(frozen=True)
class Unwrapped:
    """The files of a folder or zip of submissions, by student.

    Parameters
    ----------
    items : list of Item
        Each one's first part is a student's folder, or the file itself.
    wrapper : str
        Name of the folder that was around all of them, which is not a student's; empty if there was none.
    refused : dict of str to str
        Folders that hold the work of several students although others lie beside them, and the reason.
    """

    items: list[Item]
    wrapper: str
    refused: dict[str, str]


def unwrap(items: Iterable[Item], lessons: Sequence[str], known: Collection[str] = ()) -> Unwrapped:
    """Remove a folder around all students, and name folders that cannot belong to one student.

    Parameters
    ----------
    items : iterable of Item
        All files.
    lessons : sequence of str
        Names of the lessons that there are.
    known : collection of str
        Students of earlier runs: their folders are their own, whatever they contain.

    Returns
    -------
    Unwrapped
        Files, without the wrapper.
    """
    items = list(items)
    folders: dict[str, list[Item]] = defaultdict(list)
    for item in items:
        folders[item.parts[0]].append(item)
    several = {
        folder: names
        for folder, inside in folders.items()
        if not (is_a_platforms(folder) or clean_name(folder) in known)
        and (names := students_in(inside, lessons))
    }
    used = {item.parts[0] for item in items if not item.ignored}
    (wrapper,) = used if len(used) == 1 else ("",)
    if several.get(wrapper) and wrapper not in several[wrapper]:
        inside = [replace(item, parts=item.parts[1:]) for item in folders[wrapper] if len(item.parts) > 1]
        return Unwrapped(inside, wrapper, {})
    return Unwrapped(items, "", {folder: _reason(names) for folder, names in several.items()})


def students_in(items: Iterable[Item], lessons: Sequence[str]) -> list[str]:
    """Return the names of the students whose work a folder seems to hold; nothing for the folder of one student.

    It holds several if folders in it have notebooks of the same lesson, or if a learning platform named what is in it.
    """
    inside = [item.parts[1:] for item in items if not item.ignored and len(item.parts) > 1]
    folders = sorted({parts[0] for parts in inside if len(parts) > 1 and is_a_platforms(parts[0])})
    files = sorted(
        {name for parts in inside if len(parts) == 1 and (name := student_of_a_platforms(parts[0]))}
    )
    if folders or len(files) > 1:
        return folders or files
    works = {
        (parts[0], lesson_of(parts[-1], lessons) or parts[-1][-4:].lower())
        for parts in inside
        if len(parts) > 1
    }
    count = Counter(kind for _, kind in works if kind in (*lessons, ".zip"))
    return sorted({folder for folder, kind in works if count[kind] > 1})


def _reason(names: Sequence[str]) -> str:
    shown = ", ".join(clean_name(name) for name in names[:_MOST_NAMED])
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return (
        f"it holds the work of several students ({shown}{more}), not of one. Move their folders up, or grade this "
        "folder by itself"
    )
