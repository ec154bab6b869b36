"""Folders that hold the work of several students: removed where they are around everything, and refused elsewhere."""

import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import takewhile

from nao_course.exercises.lesson_names import lesson_of
from nao_course.instructor.collecting.archives import Item
from nao_course.instructor.collecting.layouts import handed_in, is_a_lesson, is_a_platforms, without_wrappers
from nao_course.instructor.collecting.marks import read_marks
from nao_course.instructor.collecting.names import clean_name

_MOST_NAMED = 3
_ZIP = ".zip"
_OF_A_LESSON = "it is named after a lesson, not after a student. Grade this folder by itself"
# Folders of lessons that are named by a number only.
_LESSON = re.compile(
    r"(?:lesson|assignment|homework|hw|exercise|lab|week|sheet|unit|session|lektion|aufgabe|\u00fcbung|blatt|woche)"
    r"[ _-]?\d{1,2}",
    re.IGNORECASE,
)
# What students call their folders and copies.
_OWN = re.compile(
    r"(?:\d|my|old|new|backup|draft|final|copy|work|homework|hw|submission(?:-\d+)*"
    r"|(?:version|v|attempt|try|lesson|week|exercise)[ _-]?\d+)[ _-]?\d?(?: ?\(\d+\))?",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Unwrapped:
    """The files of a folder or zip of submissions, by student.

    The first part of each item is a student's folder, or the file itself. `wrapper` is the folder that was around all
    of them and might be a student's, if any. `refused` are folders that hold the work of several students although
    others lie beside them, with the reason. `platforms` are by students' folders, if the folder around them has the
    name that the platform gives it.
    """

    items: list[Item]
    wrapper: str
    refused: dict[str, str]
    platforms: dict[str, str]


def unwrap(
    items: Iterable[Item],
    lessons: Sequence[str],
    known: Callable[[str], bool] = lambda name: False,
    root: str = "",
) -> Unwrapped:
    """Remove a folder around all students, and name folders that cannot belong to one student.

    `known` returns whether a student has a name: then the folder of this name is that student's, whatever it contains.
    `root` names the folder or zip that holds the files.
    """
    items, platforms = without_wrappers(items, known, root)
    if _are_lessons_around_students(items, lessons, known):
        return unwrap([_without(item.parts[:1], item) for item in items], lessons, known)
    folders: dict[str, list[Item]] = defaultdict(list)
    for item in items:
        folders[item.parts[0]].append(item)
    refused, several = dict[str, str](), dict[str, list[str]]()
    for folder, inside in folders.items():
        if is_a_platforms(folder) or known(folder):
            continue
        paths = [each.parts[1:] for each in inside if not each.ignored and len(each.parts) > 1]
        if names := students_in(paths, lessons, folder):
            refused[folder], several[folder] = reason_for(names), names
        elif paths and _is_about_a_lesson(folder, lessons):
            refused[folder], several[folder] = _OF_A_LESSON, []
    used = {item.parts[0] for item in items if not item.ignored}
    (first,) = used if len(used) == 1 else ("",)
    if first in several:
        paths = [item.parts for item in folders[first] if not item.ignored]
        around = paths[0][: _common_folders(paths) if several[first] else 1]
        if not {each.casefold() for each in around} & {each.casefold() for each in several[first]}:
            inner = unwrap([_without(around, item) for item in folders[first]], lessons, known, around[-1])
            return replace(inner, wrapper="/".join(filter(None, [*around, inner.wrapper])))
    return Unwrapped(items, "", refused, platforms)


def _is_about_a_lesson(folder: str, lessons: Sequence[str]) -> bool:
    return bool(_LESSON.fullmatch(folder)) or is_a_lesson(folder, lessons)


def _are_lessons_around_students(
    items: Sequence[Item], lessons: Sequence[str], known: Callable[[str], bool]
) -> bool:
    """Return whether all files lie in several folders of lessons, and in folders or files of students in these."""
    paths = [item.parts for item in items if not item.ignored and len(item.parts) > 1]
    return len({parts[0] for parts in paths}) > 1 and all(
        _is_about_a_lesson(parts[0], lessons)
        and not known(parts[0])
        and (named := handed_in(parts[1:], lessons)) is not None
        and not _is_a_students_own(named.student, lessons)
        for parts in paths
    )


def _without(around: tuple[str, ...], item: Item) -> Item:
    """Return a file without the folders around all files; an empty folder may lie in the outer ones only."""
    same = list(takewhile(lambda pair: pair[0] == pair[1], zip(around, item.parts[:-1], strict=False)))
    return replace(item, parts=item.parts[len(same) :])


def students_in(paths: Iterable[tuple[str, ...]], lessons: Sequence[str], folder: str = "") -> list[str]:
    """Return the names of the students whose work a folder or archive seems to hold; nothing if it is one student's.

    It holds the work of several students if notebooks of the same lesson are in several of its folders or are named
    after several students, if a zip is in one of its folders and more work in another one, or if a learning platform
    named what is in it. A student's own folders, such as `old` and `new`, do not count. Paths are by folders; `folder`
    is the name of the folder or of the archive's student, and a student's own file may repeat it.
    """
    inside = list(paths)
    depth = _common_folders(inside)
    inside = [parts[depth:] for parts in inside]
    if platforms := sorted({parts[0] for parts in inside if len(parts) > 1 and is_a_platforms(parts[0])}):
        return platforms
    files = [(parts[0], kind) for parts in inside if len(parts) == 1 and (kind := _kind(parts[0], lessons))]
    found = [each for each in (handed_in((file,), lessons) for file, _ in files) if each]
    named = {each.student for each in found if each.is_certain}
    if len(named) > 1 or any(not _is_named_after(each, folder) for each in named):
        return sorted(named)
    folders: dict[str, list[tuple[str, ...]]] = defaultdict(list)
    for parts in inside:
        if len(parts) > 1 and _kind(parts[-1], lessons):
            folders[parts[0]].append(parts[1:])
    kinds = {each: {_kind(parts[-1], lessons) for parts in within} for each, within in folders.items()}
    groups = [
        {each for each, found in kinds.items() if lesson in found}
        | _named_in([file for file, kind in files if kind == lesson], lessons, folder)
        for lesson in lessons
    ]
    if {_ZIP} in kinds.values():  # a zip may be of any lesson
        groups.append(set(kinds))
    several = {
        each
        for group in groups
        if len(group) > 1 and not all(_is_a_students_own(name, lessons) for name in group)
        for each in group
    }
    if several:
        return sorted(several)
    return next(filter(None, (students_in(within, lessons, each) for each, within in folders.items())), [])


def _named_in(files: Sequence[str], lessons: Sequence[str], folder: str) -> set[str]:
    """Return the students whom files of one lesson are named after; none if one of the files is the folder's own."""
    found = [handed_in((file,), lessons) for file in files]
    students = {each.student for each in found if each}
    own = not all(each and not each.problem for each in found) or any(
        folder.casefold() == each.casefold() for each in students
    )
    return set() if own else students


def _is_a_students_own(name: str, lessons: Sequence[str]) -> bool:
    """Return whether a student would call a folder or copy so: no person is called "old" or "week 2"."""
    return bool(_OWN.fullmatch(name)) or is_a_lesson(name, lessons) or not read_marks(name).name


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
    """Return the lesson of a notebook or zip, ".zip" for any other zip, and an empty string for any other file."""
    if file.lower().endswith(_ZIP):
        return lesson_of(file, lessons) or _ZIP
    return lesson_of(file, lessons) if file.lower().endswith(".ipynb") else ""


def _is_named_after(student: str, folder: str) -> bool:
    """Return whether a platform's name of a student repeats the name of a folder, without number and in any order."""
    return folder.casefold() == student.casefold() or _letters(folder) in (
        _letters(student.rpartition("_")[0]),
        _letters(student),
    )


def students_of_zips(zips: Collection[str], lessons: Sequence[str], folder: str) -> list[str]:
    """Return the students after whom zips with work of one lesson in one folder seem to be named, if several.

    The zips are without ".zip"; the folder's student does not count.
    """
    named = {
        each
        for each in zips
        if not (
            _is_a_students_own(each, lessons)
            or lesson_of(f"{each}.zip", lessons)
            or _letters(each) == _letters(folder)
        )
    }
    return sorted(named) if len(named) > 1 else []


def _letters(name: str) -> list[str]:
    return sorted(each for each in name.casefold() if each.isalnum())


def reason_for(
    names: Sequence[str], instead: str = "Move their folders up, or grade this folder by itself"
) -> str:
    """Return the reason why the work of several students is not graded as one student's, and what to do instead."""
    shown = ", ".join(clean_name(name) for name in names[:_MOST_NAMED])
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    return f"it holds the work of several students ({shown}{more}), not of one. {instead}"
