"""How much of a notebook is answered, and which of several notebooks of one lesson counts; no code of them runs."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from nao_course.exercises.lesson_names import PATTERN, lesson_and_more, lesson_of
from nao_course.exercises.notebook_text import DEFINED, DEFINES, contents, read_bounded
from nao_course.exercises.outline import Outline, read_outline

BLANK = "nothing in it is answered"
_UNWRITTEN = "raise NotImplementedError"  # in the released cell of an exercise


@dataclass(frozen=True)
class Inspection:
    """Whether a notebook can be read, and how many of its cells and questions are answered, -1 if it cannot be read.

    `problem` is empty for an answered notebook. `digest` is the content's SHA-256, so that equal notebooks are
    recognised whatever they are called.
    """

    problem: str = ""
    answers: int = 0
    digest: str = ""

    @property
    def rank(self) -> int:
        """0 for an unreadable notebook, 1 for one without an answer, 2 for any other."""
        return 0 if self.answers < 0 else 1 if self.answers == 0 else 2


def inspect_content(name: str, content: bytes, released: Outline, whole: bytes = b"") -> Inspection:
    """Read a notebook of the lesson's file `name`, and count its answers against the notebook as it was released.

    If the notebook says that it is another lesson's, only cells that define this lesson's exercises are answers.
    `content` may lack the outputs; `whole` then has them, for the digest.
    """
    try:
        text = contents(name, content, released)
    except ValueError as error:
        return Inspection(str(error), -1)
    other = bool(released.cells) and text.lesson not in ("", Path(name).stem)
    answers = 0 if other else sum(map(bool, text.written.values()))
    for role, source in text.cells:
        if (
            role not in ("solution", "student", "edited")
            or _UNWRITTEN in source
            or released.is_released(source)
        ):
            continue
        if other:  # of another lesson's notebook, only what defines this lesson's exercises
            answers += bool(released.exercises.intersection(DEFINED.findall(source)))
        else:
            answers += bool(source.strip() if role == "solution" else DEFINES.search(source))
    return Inspection("" if answers else BLANK, answers, hashlib.sha256(whole or content).hexdigest())


# --- which of several notebooks of one lesson counts ---


class Copy(Protocol):
    """One of several notebooks of a student and lesson."""

    @property
    def inspection(self) -> Inspection:
        """What is known of its content."""

    @property
    def is_named(self) -> bool:
        """Whether it is named after the lesson and nothing else, apart from marks of copies."""

    @property
    def age(self) -> tuple[Any, ...]:
        """What makes it newer than another one: the larger one is newer."""


def precedence(copy: Copy) -> tuple[Any, ...]:
    """Return the key by which the largest copy counts: the newest one with answers, then the one with more of them."""
    said = copy.inspection
    return said.rank, copy.is_named, copy.age, said.answers, said.digest


def why_not(other: Copy, best: Copy, *, is_dated: bool = True) -> str:
    """Return the reason why one copy does not count and the other one does; without dates, none of them is newer."""
    if other.inspection.problem and other.inspection.rank < best.inspection.rank:
        return other.inspection.problem
    if best.is_named > other.is_named:
        return "another one has the lesson's name"
    if is_dated and best.age > other.age:
        return "another one is newer"
    more = best.inspection.answers > other.inspection.answers
    return "another one has more answers" if more else "another one counts"


@dataclass(frozen=True)
class CopyInFolder:
    """A notebook of a lesson in a student's folder."""

    path: Path
    inspection: Inspection
    is_named: bool
    age: tuple[Any, ...]


def lesson_of_notebook(file: str, lessons: Sequence[str]) -> str:
    """Return the lesson that a notebook is named after, with other words behind it or not; often empty.

    >>> lesson_of_notebook("Kopie von 01_hsl_filtering (1).ipynb", ["01_hsl_filtering"])
    '01_hsl_filtering'
    """
    return lesson_of(file, lessons) or lesson_and_more(file, lessons)[0]


def notebooks_in(folder: Path, lessons: Sequence[str]) -> dict[str, list[Path]]:
    """Return the notebooks of a folder that a grader accepts, by lesson, with the notebook that counts first.

    A notebook with the number of a lesson that is not listed is of a lesson of its own.
    """
    found: dict[str, list[Path]] = {}
    for path in sorted(folder.iterdir()) if folder.is_dir() else ():
        if path.suffix.lower() == ".ipynb" and path.is_file():
            own = path.stem if path.match(f"{PATTERN}.ipynb") else ""
            if lesson := lesson_of_notebook(path.name, lessons) or own:
                found.setdefault(lesson, []).append(path)
    return {
        lesson: [each.path for each in copies_of(lesson, paths)] if len(paths) > 1 else paths
        for lesson, paths in sorted(found.items())
    }


def copies_of(lesson: str, paths: Sequence[Path]) -> list[CopyInFolder]:
    """Return the notebooks of a lesson, with the notebook that counts first."""
    copies = []
    for path in paths:
        try:
            inspection = inspect_content(f"{lesson}.ipynb", read_bounded(path), read_outline(lesson))
            seconds = int(path.stat().st_mtime) // 2  # as exactly as a zip stores it
        except (OSError, ValueError) as error:
            inspection, seconds = Inspection(str(error), -1), 0
        copies.append(CopyInFolder(path, inspection, bool(lesson_of(path.name, [lesson])), (seconds,)))
    return sorted(copies, key=precedence, reverse=True)


def several_copies(lesson: str, paths: Sequence[Path]) -> list[str]:
    """Return lines about a lesson that is in several notebooks: which one counts for the grader, and why."""
    if len(paths) < 2:
        return []
    best, *others = copies_of(lesson, paths)
    return [
        f"{lesson} is in {len(paths)} notebooks here. The grader counts the newest one with answers: {best.path.name}.",
        *(f"{each.path.name} does not count: {why_not(each, best)}." for each in others),
        "If another one should count, move the others out of this folder.",
    ]
