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
    name_file,
    student_of_a_platforms,
)

_MOST_NAMED = 3
_ZIP = ".zip"


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
    theirs = {clean_name(each).casefold() for each in known}
    folders: dict[str, list[Item]] = defaultdict(list)
    for item in items:
        folders[item.parts[0]].append(item)
    several = {
        folder: names
        for folder, inside in folders.items()
        if not (is_a_platforms(folder) or clean_name(folder).casefold() in theirs)
        and (names := students_in((each.parts[1:] for each in inside if not each.ignored), lessons, folder))
    }
    used = {item.parts[0] for item in items if not item.ignored}
    (first,) = used if len(used) == 1 else ("",)
    if names := several.get(first):
        inside = [item.parts for item in folders[first] if not item.ignored]
        depth = _common_folders(inside)
        around = inside[0][:depth]
        if not {each.casefold() for each in around} & {each.casefold() for each in names}:
            kept = [
                replace(item, parts=item.parts[depth:]) for item in folders[first] if len(item.parts) > depth
            ]
            return Unwrapped(kept, "/".join(around), {})
    return Unwrapped(items, "", {folder: reason_for(names) for folder, names in several.items()})


def students_in(paths: Iterable[tuple[str, ...]], lessons: Sequence[str], folder: str = "") -> list[str]:
    """Return the names of the students whose work a folder or archive seems to hold; nothing if it is one student's.

    It holds the work of several students if folders in it have notebooks of the same lesson (a zip may be of any
    lesson), if files in it are named after different students, or if a learning platform named what is in it.

    Parameters
    ----------
    paths : iterable of tuple of str
        Files in it, by folders.
    lessons : sequence of str
        Names of the lessons that there are.
    folder : str
        Name of the folder: a student's own file may repeat it.
    """
    inside = [parts for parts in paths if parts]
    depth = _common_folders(inside)
    inside = [parts[depth:] for parts in inside]
    if platforms := sorted({parts[0] for parts in inside if len(parts) > 1 and is_a_platforms(parts[0])}):
        return platforms
    files = [parts[0] for parts in inside if len(parts) == 1]
    works = [(file, _kind(file, lessons)) for file in files]
    named = {student_of_a_platforms(file) for file, kind in works if kind} - {""}
    if len(named) > 1 or any(not _is_named_after(each, folder) for each in named):
        return sorted(named)
    for lesson in lessons:
        owners = [name_file((file,), lessons) for file, kind in works if kind == lesson]
        if None not in owners and len(students := {each.student for each in owners if each}) > 1:
            return sorted(students)
    kinds: dict[str, set[str]] = defaultdict(set)
    for parts in inside:
        if len(parts) > 1 and (kind := _kind(parts[-1], lessons)):
            kinds[parts[0]].add(kind)
    count = Counter(kind for each in kinds.values() for kind in each)
    zips = [each for each, found in kinds.items() if found == {_ZIP}]
    return sorted(
        each
        for each, found in kinds.items()
        if any(count[kind] > 1 for kind in found) or (zips and zips != [each])
    )


def _common_folders(paths: Sequence[tuple[str, ...]]) -> int:
    """Return how many folders are around all files; a folder that a learning platform named is a student's."""
    folders = [parts[:-1] for parts in paths]
    depth = 0
    for level in zip(*folders, strict=False):
        if len(set(level)) > 1 or is_a_platforms(level[0]):
            break
        depth += 1
    return depth


def _kind(file: str, lessons: Sequence[str]) -> str:
    """Return a file's lesson, ".zip" for a zip, and an empty string for any other file."""
    if file.lower().endswith(_ZIP):
        return _ZIP
    return lesson_of(file, lessons) if file.lower().endswith(".ipynb") else ""


def _is_named_after(student: str, folder: str) -> bool:
    """Return whether a platform's name of a student, which ends in a number, repeats the name of a folder."""
    return folder.casefold() in (student.casefold(), student.rpartition("_")[0].casefold())


def reason_for(names: Sequence[str]) -> str:
    """Return the reason why the work of several students is not graded as one student's."""
    shown = ", ".join(clean_name(name) for name in names[:_MOST_NAMED])
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return (
        f"it holds the work of several students ({shown}{more}), not of one. Move their folders up, or grade this "
        "folder by itself"
    )
