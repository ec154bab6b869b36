"""What students handed in: found in folders and in the zips of learning platforms, bounded and hashed."""

from __future__ import annotations

import json
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import UTC, datetime
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from nao_course._internal.counts import say_count
from nao_course.exercises.answered import Inspection, precedence, why_not
from nao_course.exercises.lesson_names import LONGEST_FILE, found_in, lesson_and_more, lesson_of
from nao_course.exercises.notebook_text import LARGEST_HELPER, MOST_BYTES, MOST_HELPERS
from nao_course.exercises.versions import stated_versions
from nao_course.instructor.collecting.archives import (
    LARGEST_ZIP,
    Item,
    Refused,
    in_folder,
    in_zip,
    other_archive,
)
from nao_course.instructor.collecting.choosing import NOT_INSPECTED, inspect_notebook
from nao_course.instructor.collecting.layouts import HandedIn, Students, added_for, is_request
from nao_course.instructor.collecting.marks import without_weak_marks
from nao_course.instructor.collecting.names import clean_name
from nao_course.instructor.collecting.roster import Recognised, Roster, Student
from nao_course.instructor.collecting.wrappers import (
    Unwrapped,
    reason_for,
    students_in,
    students_of_zips,
    unwrap,
)

# Who says when a submission was made, the most trusted first: a platform's sheet, its names and files, or the receipt
# of `nao-course submit`, which has the time of the student's own clock.
TRUST = ("sheet", "platform", "receipt")
_MOST_NOTES = 20
_MOST_INSPECTED = 8  # notebooks of one student and lesson, the newest ones
_BEYOND = Inspection("", -1)  # of the others
_EARLIEST, _LATEST = (datetime(year, 1, 1, tzinfo=UTC) for year in (2020, 2100))  # of a receipt
_ALIKE = "{} folders or files have names that are too similar to assign them to students: rename them"
_MOVE_ZIPS = "Put each zip into a folder that is named after its student"
_STAMPED = re.compile(rb'"nao_course"\s*:\s*\{[^{}]{0,200}?"lesson"\s*:\s*"([^"\\]{1,100})"')
_MODULE = re.compile(r"[A-Za-z_]\w*\.py", re.ASCII)


@dataclass(frozen=True)
class Submission:
    """A student's notebook of a lesson, such as "01_hsl_filtering", or another file with the reason why it is refused.

    `helpers` are Python files that were handed in beside it, by the name they are imported by; `notes`, for the
    assistant, are about other files that do not count; `file` is its name as it was handed in. `earlier` are the same
    student's submissions of earlier lessons whose functions this one uses. `handed_in` is when it was handed in, and
    `timed_by` who says so, one of `TRUST`; both are empty if nobody does. `late` is what the platform says, and
    `versions`, of Python and libraries, are in the receipt of `nao-course submit`.
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
    timed_by: str = ""
    late: bool = False
    versions: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Gathered:
    """All that was handed in, by student and lesson: submissions to grade, and refused ones with their reasons.

    `unknown` are files whose student or lesson nobody can determine, each with the reason; first `not_graded`: files
    that may be a student's work, and students of whom there is no notebook of a wanted lesson. `wrapper` is a folder
    that was around everything and may be a student's; it is often empty. `recognised` has a line for each platform
    whose names were recognised, and `older` for each student whose newest notebook does not count, with the reason.
    `asked` has a question for each person who may be several students, `by_name` a line for each who was recognised by
    the name alone, `new` the students of no earlier run, and `learned` what the download says of the students.
    """

    submissions: tuple[Submission, ...]
    refused: tuple[Submission, ...] = ()
    unknown: tuple[str, ...] = ()
    not_graded: tuple[str, ...] = ()
    wrapper: str = ""
    recognised: tuple[str, ...] = ()
    older: tuple[str, ...] = ()
    asked: tuple[str, ...] = ()
    by_name: tuple[str, ...] = ()
    new: tuple[str, ...] = ()
    learned: tuple[Student, ...] = ()


def with_earlier(
    submissions: Iterable[Submission],
    earlier: Mapping[tuple[str, str], Submission],
    needed: Callable[[str], Sequence[str]],
) -> list[Submission]:
    """Give each submission the same student's earlier work that it uses.

    `earlier` is what was handed in, by student and lesson, and `needed` returns the names of the lessons that a lesson
    uses.
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
    known: Roster | None = None,
) -> Gathered:
    """Find all submissions. If a student has several of a lesson, use the newest one in which something is answered.

    What counts is unpacked to `scratch`, an empty folder of the caller's; nothing is written elsewhere. If a single
    lesson is `wanted`, a zip that cannot be opened counts as a submission of it. With `one_student`, the one folder in
    it is a student's, whatever is in that; so is a folder named after a student in `known`, the students of earlier
    runs and of sheets. Without `known`, students are named as in the download. Raise a ValueError if the path does not
    exist, or is neither a folder nor a zip.
    """
    unwrapped, students = open_download(path, lessons, known, one_student=one_student)
    search = _Search(scratch, tuple(lessons), tuple(lessons if wanted is None else wanted), students)
    search.refused = unwrapped.refused
    for item in unwrapped.items:
        search.look_at(item)
    return replace(search.result(), wrapper=clean_name(unwrapped.wrapper))


def open_download(
    path: Path, lessons: Sequence[str], known: Roster | None = None, *, one_student: bool = False
) -> tuple[Unwrapped, Students]:
    """List the files of a download, and find out whose they are.

    The arguments are as in `gather`. Raise a ValueError if the path does not exist, or is neither a folder nor a zip.
    """
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
        known = Roster.of(clean_name(item.parts[0]) for item in items)
    root = path.resolve().name
    unwrapped = unwrap(items, lessons, (known or Roster()).is_known, root.removesuffix(".zip"))
    return unwrapped, Students(unwrapped.items, lessons, known, unwrapped.platforms)


# --- who handed in what ---


@dataclass(frozen=True)
class _Receipt:
    """When `nao-course submit` packed a zip, or 0 and a note why that is unknown; and the versions it stated."""

    packed: float = 0.0
    note: str = ""
    versions: Mapping[str, str] = field(default_factory=dict)


class _StudentsZip(NamedTuple):
    """A zip that a student made."""

    time: float
    receipt: _Receipt


@dataclass(frozen=True)
class _Candidate:
    """A notebook that may be a student's submission."""

    item: Item
    name: HandedIn
    home: tuple[Any, ...]  # helpers with the same one belong to it
    shown: str
    number: int  # among the student's notebooks of the lesson
    is_named: bool = True  # exactly after its lesson
    more: str = ""  # words behind the lesson's name
    zip: _StudentsZip | None = None
    inspection: Inspection = NOT_INSPECTED

    @property
    def time(self) -> float:
        """The time of the receipt or file; 0 in Moodle's zip, whose times are the times of the download."""
        undated = self.name.platform == "Moodle" and self.item.entry is not None
        time, receipt = self.zip or (self.item.time, _Receipt())
        return receipt.packed or (0.0 if undated else time)

    @property
    def age(self) -> tuple[Any, ...]:
        """What makes a notebook newer than another one: the platform's attempt and time, then the file's time.

        Of two notebooks in one zip of a student, the time that the zip holds decides.
        """
        return (self.name.order, self.time, self.item.time if self.zip else 0.0)

    def is_dated_like(self, other: _Candidate) -> bool:
        """Return whether the ages of both say something about each other."""
        return self.name.order != other.name.order or bool(self.time and other.time)


class _Search:
    """What has been found so far."""

    def __init__(
        self, scratch: Path, lessons: tuple[str, ...], wanted: tuple[str, ...], students: Students
    ) -> None:
        self.scratch, self.lessons, self.wanted, self.students = scratch, lessons, wanted, students
        self.candidates: dict[tuple[str, str], list[_Candidate]] = defaultdict(list)
        self.helpers: dict[tuple[Any, ...], list[tuple[str, Item]]] = defaultdict(list)
        self.unknown: list[str] = []
        self.lost: list[str] = []  # files that may be a student's work
        self.older: list[str] = []
        self.asked: dict[str, None] = {}
        self.owner = ""  # the student whose file is being looked at; empty for a file that names none
        self.owners: dict[str, bool] = {"": True}  # whether there is something of theirs that may be work
        self.named: set[str] = set()  # students with a line in `lost`
        self.refused: dict[str, str] = {}  # folders that are not one student's
        self.spellings: dict[str, set[str]] = defaultdict(set)  # of a student's name
        # Names of the zips that hold a lesson, by folder and lesson: they may be of several students.
        self.zips: dict[tuple[tuple[str, ...], str], set[str]] = defaultdict(set)
        self.unpacked = 0

    def look_at(self, item: Item) -> None:
        """Sort a file in; if that fails, name it, because one student's file does not stop the class."""
        self.owner = ""
        try:
            self.sort_in(item)
        except Exception as error:  # noqa: BLE001 - whatever is in a stranger's file, the next one is looked at
            self.failed(clean_name("/".join(item.parts)), error)

    def failed(self, shown: str, error: Exception) -> None:
        """Record a file or a student at which the grader itself failed."""
        said = f"{type(error).__name__}: {error}"[:200]
        self.lost.append(f"{shown}: the grader failed here ({clean_name(said)}); look at it yourself")
        self.owners[self.owner] = True
        self.named.add(self.owner)

    def sort_in(self, item: Item) -> None:
        """Sort a file in."""
        first = item.parts[0]
        if first in self.refused:
            self.leave_out_folder(first)
            return
        shown = clean_name("/".join(item.parts))
        name = self.students.of(item.parts)
        if name and name.is_asked:
            self.asked[name.problem] = None
            return
        if name and name.problem:
            if not item.ignored and added_for(item.parts) is None:
                self.leave_out(shown, name.problem, is_lost=True)
            return
        self.owner = name.student if name else ""
        self.owners.setdefault(self.owner, False)
        if item.ignored or added_for(item.parts) is not None:
            return
        if name is None:
            mentioned = any(found_in(_without_suffixes(first), self.lessons))
            spoiled = mentioned and not first.lower().endswith((".ipynb", ".zip"))
            reason = "it is no notebook" if spoiled else "it names no student and lesson"
            if mentioned and not spoiled:
                reason = (
                    "no student's name stands before the lesson's; put it into a folder that has that name"
                )
            self.leave_out(
                shown, item.problem or other_archive(first) or reason, is_lost=spoiled or bool(item.problem)
            )
        elif name.file.lower().endswith(".zip"):
            self.look_into_zip(item, name, shown)
        elif problem := other_archive(name.file):
            self.refuse_archive(item, name, shown, item.problem or problem)
        else:
            self.take(item, name, (item.folder,), shown)

    def look_into_zip(self, item: Item, name: HandedIn, shown: str) -> None:
        """Sort in what a student's zip holds."""
        try:
            path = self.unpack(item, "handed_in.zip", LARGEST_ZIP)
            inside = in_zip(path, students=True)
        except Refused as refused:
            self.refuse_archive(item, name, shown, str(refused))
            return
        is_certain = name.is_certain or self.students.is_known(name.student)
        if not is_certain:
            several = students_in(
                [each.parts for each in inside if not each.ignored], self.lessons, name.student
            )
            if several:
                self.leave_out(shown, reason_for(several, "Grade this zip by itself"))
                return
        made = _StudentsZip(item.time, _receipt(inside))
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
                self.take(each, inner, (path, each.parts[:-1]), within, made)
                if not is_certain and (lesson := lesson_of(inner.file, self.lessons)):
                    self.zips[item.parts[:-1], lesson].add(item.parts[-1].rpartition(".")[0])

    def refuse_archive(self, item: Item, name: HandedIn, shown: str, problem: str) -> None:
        """Record an archive that cannot be opened: as a submission, if its lesson is known."""
        lessons = self.lessons_in(name.file) or set(self.wanted)
        if len(lessons) == 1:
            self.add(replace(item, problem=problem), name, min(lessons), (), shown)
        else:
            self.leave_out(shown, problem, is_lost=True)

    def lessons_in(self, file: str) -> set[str]:
        """Return the lessons that the name of a file or folder mentions."""
        return {lesson for lesson, _, _ in found_in(_without_suffixes(file), self.lessons)}

    def take(
        self, item: Item, name: HandedIn, place: tuple[Any, ...], shown: str, made: _StudentsZip | None = None
    ) -> None:
        """Sort in a notebook or helper."""
        home = (name.student, *place)
        if name.file.lower().endswith(".ipynb"):
            if lesson := lesson_of(name.file, self.lessons):
                self.add(item, name, lesson, home, shown, made)
                return
            lesson, more = lesson_and_more(name.file, self.lessons)
            if lesson := lesson or self.wanted_by_metadata(item):
                self.add(item, name, lesson, home, shown, made, is_named=False, more=more)
            else:
                self.leave_out(shown, "it is named after no lesson of this course")
        elif _MODULE.fullmatch(name.file):
            self.helpers[home].append((name.file, item))
        elif name.file != "receipt.json" and not is_request(name.file):
            self.leave_out(shown, item.problem or "it is no notebook")

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

    def leave_out(self, shown: str, reason: str, *, is_lost: bool = False) -> None:
        """Record a path that is not graded.

        A notebook, an archive, a link or a folder may be a student's work, unless its name mentions only lessons
        which are not graded now.
        """
        file = shown.rpartition("/")[2].lower()
        lessons = self.lessons_in(file)
        is_others = bool(lessons) and lessons.isdisjoint(self.wanted)
        is_work = is_lost or file.endswith((".ipynb", ".zip")) or bool(other_archive(file))
        may_be_work = is_work and not is_others
        (self.lost if may_be_work else self.unknown).append(f"{shown}: {reason}")
        self.owners[self.owner] |= is_work or is_others
        if may_be_work:
            self.named.add(self.owner)

    def leave_out_folder(self, folder: str) -> None:
        """Record once that a folder is not graded, because it is not one student's."""
        line = f"{clean_name(folder)}: {self.refused[folder]}"
        if line not in (*self.lost, *self.unknown):
            self.leave_out(clean_name(folder), self.refused[folder], is_lost=True)

    def add(
        self,
        item: Item,
        name: HandedIn,
        lesson: str,
        home: tuple[Any, ...],
        shown: str,
        made: _StudentsZip | None = None,
        *,
        is_named: bool = True,
        more: str = "",
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
        found.append(_Candidate(item, name, home, shown, len(found), is_named, more, made))

    def result(self) -> Gathered:
        """Choose what counts and unpack it."""
        self.leave_out_zips_of_several()
        chosen = []
        for student, lesson in sorted(key for key in self.candidates if key[1] in self.wanted):
            try:
                chosen += self.choose(student, lesson)
            except Exception as error:  # noqa: BLE001 - whatever is in a stranger's file, the next student is graded
                self.failed(f"{student}, {lesson}", error)
        empty = [
            f"{clean_name(owner)}: there is no notebook of a lesson"
            for owner, has_work in self.owners.items()
            if not has_work
        ]
        lost = _each_student_first([*self.lost, *empty])
        recognised = self.students.recognised or Recognised({}, {})
        with_work = {student for student, _ in self.candidates}
        return Gathered(
            tuple(each for each in chosen if not each.reason),
            tuple(each for each in chosen if each.reason),
            (*lost, *self.without_a_wanted_lesson(), *self.unknown),
            lost,
            recognised=tuple(self.recognised()),
            older=tuple(self.older),
            asked=tuple(self.asked),
            by_name=recognised.by_name,
            new=tuple(each for each in recognised.new if each in with_work),
            learned=tuple(said for student, said in recognised.learned.items() if student in with_work),
        )

    def recognised(self) -> Iterator[str]:
        """Yield a line for each platform: how many students and attempts it has, and which attempt counts."""
        attempts: dict[str, list[tuple[str, str]]] = defaultdict(list)
        for key, found in self.candidates.items():
            if key[1] in self.wanted:
                for each in found:
                    attempts[each.name.platform].append(key)
        for platform, keys in attempts.items():
            lessons = len({lesson for _, lesson in keys})
            counts = [say_count(len({student for student, _ in keys}), "student")]
            counts += [say_count(lessons, "lesson")] if lessons > 1 else []
            counts.append(say_count(len(keys), "attempt"))
            more = "; the newest of each counts" if len(set(keys)) < len(keys) else ""
            yield f"{platform}: {', '.join(counts)}{more}."

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

    def choose(self, student: str, lesson: str) -> list[Submission]:
        """Return the newest readable and answered notebook, or else the newest one with the reason why it is refused.

        A notebook in which nothing is answered counts before an unreadable one. The list is empty if the notebooks may
        be of several students.
        """
        found = sorted(
            self.candidates[student, lesson],
            key=lambda each: (not each.item.problem, each.is_named, each.age),
            reverse=True,
        )
        words = {without_weak_marks(each.more).casefold() for each in found if each.more}
        if len(words) > 1 and not any(each.is_named for each in found):
            names = " and ".join(sorted(each.shown for each in found)[:3])
            self.lost.append(
                f"{student}: {names} have different words behind the lesson's name. If they are of several students, "
                "put each into a folder that has the student's name; otherwise remove all but one"
            )
            return []
        if len(found) > 1:
            found = [
                replace(
                    each, inspection=inspect_notebook(each.item, lesson) if at < _MOST_INSPECTED else _BEYOND
                )
                for at, each in enumerate(found)
            ]
        best, *others = sorted(found, key=lambda each: (*precedence(each), each.number), reverse=True)
        notes = [
            f"{each.shown} does not count: {why_not(each, best, is_dated=each.is_dated_like(best))}"
            for each in others[:_MOST_NOTES]
        ]
        newest = max(found, key=lambda each: each.age)
        if newest.age > best.age and newest.inspection.problem:
            self.older.append(
                f"{student}, {lesson}: {best.shown} counts, because the newer {newest.shown} cannot be used "
                f"({newest.inspection.problem})"
            )
        receipt = best.zip.receipt if best.zip else _Receipt()
        if receipt.note:
            notes.insert(0, receipt.note)
        if not best.is_named:
            why = "its name begins with that lesson's" if best.more else "its metadata name that lesson"
            notes.insert(0, f"{best.shown} counts as {lesson}, because {why}")
        handed_in, timed_by = best.name.time, "platform" if best.name.time else ""
        if receipt.packed and not handed_in:
            handed_in = datetime.fromtimestamp(receipt.packed, UTC).isoformat(" ", "minutes")
            timed_by = "receipt"
        made = Submission(
            student,
            lesson,
            best.item.source,
            file=best.shown,
            reason=best.item.problem,
            handed_in=handed_in,
            timed_by=timed_by,
            late=best.name.late,
            versions=receipt.versions,
        )
        if len(self.spellings[student]) > 1:
            made = replace(made, reason=_ALIKE.format(len(self.spellings[student])))
        if made.reason:
            return [replace(made, notes=tuple(notes))]
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
            return [replace(made, notes=tuple(notes), reason=str(refused))]
        return [replace(made, path=path, helpers=beside, notes=tuple(notes))]

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


def _without_suffixes(file: str) -> str:
    """Return a file's name without what editors, browsers and archives put behind ".ipynb"."""
    return re.sub(r"(?:\.\w{1,8}){1,3}$", "", file[:LONGEST_FILE], flags=re.ASCII) + "."


def _each_student_first(lines: list[str]) -> tuple[str, ...]:
    """Order lines about files: the first line about each student, then the second ones, and so on."""
    counted: Counter[str] = Counter()
    turns = []
    for line in lines:
        student = re.split("[/:]", line, maxsplit=1)[0]
        turns.append(counted[student])
        counted[student] += 1
    return tuple(line for _, line in sorted(zip(turns, lines, strict=True), key=itemgetter(0)))


def _receipt(items: Iterable[Item]) -> _Receipt:
    """Read the receipt in a zip; it is a student's file.

    A time without an offset from UTC would be another one on each grader's machine, and the year 9999 is nobody's.
    """
    for item in items:
        if item.parts[-1] == "receipt.json":
            versions: Mapping[str, str] = {}
            try:
                told = json.loads(item.content(2**16))
                versions = stated_versions(told.get("versions"))
                time = datetime.fromisoformat(told["time"])
            except (Refused, ValueError, TypeError, KeyError, AttributeError, RecursionError):
                note = "the receipt does not count, because it has no time that can be read"
                return _Receipt(0.0, note, versions)
            problem = (
                "it has no offset from UTC"
                if time.tzinfo is None
                else ("" if _EARLIEST <= time < _LATEST else "it is not between 2020 and 2100")
            )
            if problem:
                note = f"the receipt's time {time} does not count, because {problem}"
                return _Receipt(0.0, note, versions)
            return _Receipt(time.timestamp(), "", versions)
    return _Receipt()


def of_lessons(gathered: Gathered, lessons: Sequence[str]) -> list[Submission]:
    """Return what has to have a result, refused or not, in the order of students and lessons."""
    both = sorted((*gathered.submissions, *gathered.refused), key=lambda each: (each.student, each.lesson))
    return [each for each in both if each.lesson in lessons]
