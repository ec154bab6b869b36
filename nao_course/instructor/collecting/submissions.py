"""What students handed in: found in folders and in the zips of learning platforms, bounded and hashed."""

from __future__ import annotations

import json
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from operator import itemgetter
from pathlib import Path
from typing import Any

from nao_course.exercises.notebook_text import LARGEST_HELPER, MOST_BYTES, MOST_HELPERS
from nao_course.homework import REQUEST
from nao_course.instructor.collecting.archives import LARGEST_ZIP, Item, Refused, in_folder, in_zip
from nao_course.instructor.collecting.names import (
    NamedFile,
    clean_name,
    is_a_platforms,
    is_online_text,
    lesson_of,
    mentions_a_lesson,
    name_file,
    student_of_a_platforms,
)
from nao_course.instructor.collecting.wrappers import reason_for, students_in, students_of_zips, unwrap

_MOST_NOTES = 20
_ALIKE = "{} folders or files have names that are too similar to assign them to students: rename them"
_MOVE_ZIPS = "Put each zip into a folder that is named after its student"
_STAMPED = re.compile(rb'"nao_course"\s*:\s*\{[^{}]{0,200}?"lesson"\s*:\s*"([^"\\]{1,100})"')
_MODULE = re.compile(r"[A-Za-z_]\w*\.py", re.ASCII)


@dataclass(frozen=True)
class Submission:
    """A student's notebook of a lesson.

    Parameters
    ----------
    student, lesson : str
        Whose, and of which lesson ("01_hsl_filtering").
    path : Path
        The notebook, or what is there instead of one.
    helpers : tuple of (str, Path)
        Python files that were handed in beside it, by the name they are imported by.
    notes : tuple of str
        For the assistant: what else there was and does not count.
    reason : str
        Why it is refused, where it is.
    file : str
        Its name as it was handed in.
    earlier : tuple of Submission
        The same student's submissions of earlier lessons whose functions this one uses.
    handed_in : str
        When a zip of `nao-course submit` was packed, in UTC and by the student's clock; empty for other files.
    late : bool
        Whether the platform says that it was handed in late.
    """

    student: str
    lesson: str
    path: Path
    helpers: tuple[tuple[str, Path], ...] = ()
    notes: tuple[str, ...] = ()
    reason: str = ""
    file: str = ""
    earlier: tuple[Submission, ...] = ()
    handed_in: str = ""
    late: bool = False


@dataclass(frozen=True)
class Gathered:
    """All that was handed in, sorted by student and lesson.

    Parameters
    ----------
    submissions, refused : tuple of Submission
        Submissions to grade, and refused submissions with their reasons.
    unknown : tuple of str
        Files of which nobody can say whose or of which lesson they are, each with the reason; first `not_graded`.
    not_graded : tuple of str
        Files that may be a student's work, and students of whom there is no notebook of a wanted lesson.
    wrapper : str
        Name of the folder that was around everything, and was not taken for a student's; often empty.
    """

    submissions: tuple[Submission, ...]
    refused: tuple[Submission, ...] = ()
    unknown: tuple[str, ...] = ()
    not_graded: tuple[str, ...] = ()
    wrapper: str = ""


def with_earlier(
    submissions: Iterable[Submission],
    earlier: Mapping[tuple[str, str], Submission],
    needed: Callable[[str], Sequence[str]],
) -> list[Submission]:
    """Give each submission the same student's earlier work that it uses.

    Parameters
    ----------
    submissions : iterable of Submission
        To be graded.
    earlier : mapping of (str, str) to Submission
        What was handed in, by student and lesson.
    needed : callable
        Called with a lesson's name; returns the names of the lessons that it uses.
    """
    return [
        replace(
            each,
            earlier=tuple(
                earlier[each.student, name] for name in needed(each.lesson) if (each.student, name) in earlier
            ),
        )
        for each in submissions
    ]


def gather(
    path: Path,
    scratch: Path,
    lessons: Sequence[str],
    wanted: Sequence[str] | None = None,
    *,
    one_student: bool = False,
    known: Collection[str] = (),
) -> Gathered:
    """Find all submissions. If a student has several of a lesson, use the newest readable one.

    Parameters
    ----------
    path : Path
        A folder, or the zip of a learning platform.
    scratch : Path
        An empty folder of the caller's, where what counts is unpacked to; nothing is written elsewhere.
    lessons : sequence of str
        Names of the lessons that there are.
    wanted : sequence of str, optional
        Those to find; all by default. Where it is one, a zip that cannot be opened counts as a submission of it.
    one_student : bool
        Whether the one folder in it is a student's, whatever is in that.
    known : collection of str
        Students of earlier runs: a folder with such a name is that student's, whatever is in it.

    Returns
    -------
    Gathered
        Sorted by student and lesson.

    Raises
    ------
    ValueError
        If the path does not exist, or is neither a folder nor a zip.
    """
    search = _Search(scratch, tuple(lessons), tuple(lessons if wanted is None else wanted))
    if path.is_dir():
        items = list(in_folder(path))
    elif path.is_file():
        try:
            items = in_zip(path.resolve(), students=False)
        except Refused as refused:
            raise ValueError(f"{path} is not a folder of submissions or a zip of them; {refused}") from None
    else:
        raise ValueError(f"{path} does not exist. Give a folder of submissions or a zip of them")
    if one_student:
        known = {clean_name(item.parts[0]) for item in items}
    search.known = {clean_name(each).casefold() for each in known}
    unwrapped = unwrap(items, search.lessons, known)
    search.refused = unwrapped.refused
    for item in unwrapped.items:
        search.look_at(item)
    return replace(search.result(), wrapper=clean_name(unwrapped.wrapper))


# --- who handed in what ---


@dataclass(frozen=True)
class _Candidate:
    """A notebook that may be a student's submission."""

    item: Item
    order: tuple[Any, ...]  # first what the platform says, then the time
    home: tuple[Any, ...]  # helpers with the same one belong to it
    shown: str
    late: bool
    packed: float  # when its zip of `nao-course submit` was made; 0 without one
    is_named: bool  # after its lesson; otherwise only its metadata name the lesson

    @property
    def is_dated(self) -> bool:
        """Return whether the time is known: the times in Moodle's zip are the times of the download."""
        return bool(self.packed) or self.item.entry is None or not is_a_platforms(self.item.parts[0])


class _Search:
    """What has been found so far."""

    def __init__(self, scratch: Path, lessons: tuple[str, ...], wanted: tuple[str, ...]) -> None:
        self.scratch, self.lessons, self.wanted = scratch, lessons, wanted
        self.candidates: dict[tuple[str, str], list[_Candidate]] = defaultdict(list)
        self.helpers: dict[tuple[Any, ...], list[tuple[str, Item]]] = defaultdict(list)
        self.unknown: list[str] = []
        self.lost: list[str] = []  # files that may be a student's work
        self.owner = ""  # the student whose file is being looked at; empty for a file that names none
        self.owners: dict[str, bool] = {"": True}  # whether there is something of theirs that may be work
        self.named: set[str] = set()  # students with a line in `lost`
        self.known: set[str] = set()  # students whose folders and zips are their own, in lower case
        self.refused: dict[str, str] = {}  # folders that are not one student's
        self.spellings: dict[str, set[str]] = defaultdict(set)  # of a student's name
        # Names of the zips that hold a lesson, by folder and lesson: they may be of several students.
        self.zips: dict[tuple[tuple[str, ...], str], set[str]] = defaultdict(set)
        self.unpacked = 0

    def look_at(self, item: Item) -> None:
        """Sort a file in."""
        first = item.parts[0]
        if first in self.refused:
            self.leave_out_folder(first)
            return
        name = name_file(item.parts, self.lessons)
        self.owner = name.student if name else ""
        self.owners.setdefault(self.owner, False)
        is_work = item.parts[-1].lower().endswith((".ipynb", ".zip"))
        if item.ignored or (is_online_text(first) and not is_work):
            return
        shown = clean_name("/".join(item.parts))
        if name is None:
            spoiled = mentions_a_lesson(first, self.lessons) and not first.lower().endswith(
                (".ipynb", ".zip")
            )
            reason = "it is no notebook" if spoiled else "it names no student and lesson"
            size = 0 if spoiled or item.problem else item.size  # a student's work, or a link to it
            self.leave_out(shown, item.problem or reason, size)
        elif name.file.lower().endswith(".zip"):
            self.look_into(item, name, shown)
        else:
            self.take(item, name, (item.source.parent, item.parts[:-1]), item.time, shown)

    def look_into(self, item: Item, name: NamedFile, shown: str) -> None:
        """Sort in what a student's zip holds."""
        try:
            path = self.unpack(item, "handed_in.zip", LARGEST_ZIP)
            inside = in_zip(path, students=True)
        except Refused as refused:
            lesson = lesson_of(name.file, self.lessons) or (self.wanted[0] if len(self.wanted) == 1 else "")
            if lesson:
                self.add(
                    replace(item, problem=str(refused)), name, lesson, (), (name.order, item.time), shown
                )
            else:
                self.leave_out(shown, str(refused))
            return
        is_certain = (
            bool(student_of_a_platforms(item.parts[0], self.lessons))
            or is_a_platforms(item.parts[0])
            or clean_name(name.student).casefold() in self.known
        )
        if not is_certain:
            several = students_in(
                [each.parts for each in inside if not each.ignored], self.lessons, name.student
            )
            if several:
                self.leave_out(shown, reason_for(several, "Grade this zip by itself"))
                return
        packed = _receipt_time(inside)
        if not any(
            each.parts[-1].lower().endswith((".ipynb", ".zip")) for each in inside if not each.ignored
        ):
            self.leave_out(shown, "no notebook is in it")
        for each in inside:
            within = f"{shown}/{clean_name('/'.join(each.parts))}"
            inner = replace(name, file=each.parts[-1])
            if each.ignored:
                continue
            if inner.file.lower().endswith(".zip"):
                self.leave_out(within, "a zip within a zip is not opened")
            else:
                self.take(each, inner, (path, each.parts[:-1]), packed or item.time, within, packed)
                if not is_certain and (lesson := lesson_of(inner.file, self.lessons)):
                    self.zips[item.parts[:-1], lesson].add(item.parts[-1].rpartition(".")[0])

    def take(
        self,
        item: Item,
        name: NamedFile,
        place: tuple[Any, ...],
        time: float,
        shown: str,
        packed: float = 0.0,
    ) -> None:
        """Sort in a notebook or helper."""
        home = (name.student, *place)
        if name.file.lower().endswith(".ipynb"):
            named = lesson_of(name.file, self.lessons)
            if lesson := named or self.wanted_by_metadata(item):
                self.add(item, name, lesson, home, (name.order, time), shown, packed, is_named=bool(named))
            else:
                self.leave_out(shown, "it is named after no lesson of this course")
        elif _MODULE.fullmatch(name.file):
            self.helpers[home].append((name.file, item))
        else:
            self.leave_out(shown, item.problem or "it is no notebook", item.size)

    def wanted_by_metadata(self, item: Item) -> str:
        """Return the only wanted lesson if the metadata of a notebook name it; otherwise an empty string."""
        if len(self.wanted) != 1:
            return ""
        try:
            # A notebook's own text cannot match: quotation marks in it are escaped.
            found = set(_STAMPED.findall(item.content(MOST_BYTES)))
        except Refused:
            return ""
        return self.wanted[0] if found == {self.wanted[0].encode()} else ""

    def leave_out(self, shown: str, reason: str, size: int = 0) -> None:
        """Record a path that is not graded. A notebook, a zip or a folder may be a student's work."""
        file = shown.rpartition("/")[2].lower()
        if file in ("receipt.json", REQUEST):
            return
        may_be_work = file.endswith((".ipynb", ".zip")) or not size  # a folder, a link, a pipe
        (self.lost if may_be_work else self.unknown).append(f"{shown}: {reason}")
        self.owners[self.owner] |= may_be_work
        if may_be_work:
            self.named.add(self.owner)

    def leave_out_folder(self, folder: str) -> None:
        """Record once that a folder is not graded, because it is not one student's."""
        line = f"{clean_name(folder)}: {self.refused[folder]}"
        if line not in self.lost:
            self.lost.append(line)

    def add(
        self,
        item: Item,
        name: NamedFile,
        lesson: str,
        home: tuple[Any, ...],
        order: tuple[Any, ...],
        shown: str,
        packed: float = 0.0,
        *,
        is_named: bool = True,
    ) -> None:
        """Remember a notebook."""
        if not item.problem and item.size == 0:
            item = replace(item, problem="it is empty")
        if not item.problem and item.size > MOST_BYTES and item.entry is not None:
            item = replace(
                item, problem=f"it has {item.size / 2**20:.0f} MB; {MOST_BYTES // 2**20} MB are the most"
            )
        self.owners[self.owner] = True
        key = (clean_name(name.student), lesson)
        self.spellings[key[0]].add(name.student)
        found = self.candidates[key]
        order = (*order, shown, len(found))  # a zip's later one counts
        found.append(_Candidate(item, order, home, shown, name.late, packed, is_named))

    def result(self) -> Gathered:
        """Choose what counts and unpack it."""
        self.leave_out_zips_of_several()
        keys = sorted(key for key in self.candidates if key[1] in self.wanted)
        chosen = [self.choose(*key) for key in keys]
        empty = [
            f"{clean_name(owner)}: there is no notebook of a lesson"
            for owner, has_work in self.owners.items()
            if not has_work
        ]
        lost = _each_student_first([*self.lost, *empty, *self.without_a_wanted_lesson()])
        return Gathered(
            tuple(each for each in chosen if not each.reason),
            tuple(each for each in chosen if each.reason),
            (*lost, *self.unknown),
            lost,
        )

    def leave_out_zips_of_several(self) -> None:
        """Leave out each folder whose zips hold the same lesson and are named after several students."""
        several: dict[tuple[str, ...], set[str]] = defaultdict(set)
        for (folder, _), zips in self.zips.items():
            if folder:
                several[folder].update(students_of_zips(zips, self.lessons, folder[0]))
        for folder, names in several.items():
            if names:
                self.lost.append(f"{clean_name('/'.join(folder))}: {reason_for(sorted(names), _MOVE_ZIPS)}")
                for key in [each for each in self.candidates if each[0] == clean_name(folder[0])]:
                    del self.candidates[key]

    def without_a_wanted_lesson(self) -> list[str]:
        """Name the students who handed in notebooks, but none of a wanted lesson."""
        handed_in: dict[str, set[str]] = defaultdict(set)
        for student, lesson in self.candidates:
            handed_in[student].add(lesson)
        named = {clean_name(owner) for owner in self.named}
        return [
            f"{student}: nothing was handed in for {', '.join(self.wanted)}, only for {', '.join(sorted(lessons))}"
            for student, lessons in handed_in.items()
            if student not in named and lessons.isdisjoint(self.wanted)
        ]

    def choose(self, student: str, lesson: str) -> Submission:
        """Return the newest readable submission, or else the newest one with the reason why it is refused."""
        newest = sorted(
            self.candidates[student, lesson], key=lambda each: (each.is_named, each.order), reverse=True
        )
        best = next((each for each in newest if not each.item.problem), newest[0])
        others = [each for each in newest if each is not best]
        notes = [f"{each.shown} does not count: {_why_not(each, best)}" for each in others[:_MOST_NOTES]]
        if not best.is_named:
            notes.insert(0, f"{best.shown} counts as {lesson}, because its metadata name that lesson")
        made = Submission(
            student,
            lesson,
            best.item.source,
            file=best.shown,
            reason=best.item.problem,
            handed_in=datetime.fromtimestamp(best.packed, UTC).isoformat(" ", "minutes")
            if best.packed
            else "",
            late=best.late,
        )
        if len(self.spellings[student]) > 1:
            made = replace(made, reason=_ALIKE.format(len(self.spellings[student])))
        if made.reason:
            return replace(made, notes=tuple(notes))
        helpers: list[tuple[str, Item]] = []
        for name, item in self.helpers.get(best.home, []):
            if len(helpers) >= MOST_HELPERS or item.size > LARGEST_HELPER or item.problem:
                problem = item.problem or f"{MOST_HELPERS} of at most {LARGEST_HELPER // 2**20} MB are taken"
                notes.append(f"{name} does not come along: {problem}")
            else:
                helpers.append((name, item))
        try:
            path = self.unpack(best.item, f"{lesson}.ipynb", MOST_BYTES)
            beside = tuple((name, self.unpack(item, name, LARGEST_HELPER)) for name, item in helpers)
        except Refused as refused:
            return replace(made, notes=tuple(notes), reason=str(refused))
        return replace(made, path=path, helpers=beside, notes=tuple(notes))

    def unpack(self, item: Item, name: str, most: int) -> Path:
        """Copy what is in a zip into the scratch folder, under a name of our own; a plain file stays where it is."""
        if item.problem:
            raise Refused(item.problem)
        if item.entry is None:
            return item.source
        content = item.content(most)
        self.unpacked += 1
        folder = self.scratch / f"unpacked-{self.unpacked // 1000}" / str(self.unpacked)
        folder.mkdir(parents=True)
        (folder / name).write_bytes(content)
        return folder / name


def _why_not(other: _Candidate, best: _Candidate) -> str:
    """Return the reason why one notebook does not count and the other one does."""
    if other.item.problem:
        return other.item.problem
    if best.is_named > other.is_named:
        return "another one has the lesson's name"
    if best.order[0] == other.order[0] and not (best.is_dated and other.is_dated):
        return "another one counts"
    return "another one is newer" if best.order[:2] > other.order[:2] else "another one counts"


def _each_student_first(lines: list[str]) -> tuple[str, ...]:
    """Order lines about files: the first line about each student, then the second ones, and so on."""
    counted: Counter[str] = Counter()
    turns = []
    for line in lines:
        student = re.split("[/:]", line, maxsplit=1)[0]
        turns.append(counted[student])
        counted[student] += 1
    return tuple(line for _, line in sorted(zip(turns, lines, strict=True), key=itemgetter(0)))


def _receipt_time(items: Iterable[Item]) -> float:
    """Return the time at which a zip of `nao-course submit` was made, from its receipt; 0 without one."""
    for item in items:
        if item.parts[-1] == "receipt.json":
            try:
                told = json.loads(item.content(2**16))
                return datetime.fromisoformat(told["time"]).timestamp()
            except (Refused, ValueError, TypeError, KeyError, RecursionError, OverflowError):
                return 0.0
    return 0.0


def of_lessons(gathered: Gathered, lessons: Sequence[str]) -> list[Submission]:
    """Return what has to have a result, refused or not, in the order of students and lessons."""
    both = sorted((*gathered.submissions, *gathered.refused), key=lambda each: (each.student, each.lesson))
    return [each for each in both if each.lesson in lessons]
