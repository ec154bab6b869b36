"""The layouts of submissions that are understood, as one table, and whose file lies where in them.

The form of each platform's names is known from its source code or from public scripts that read its downloads; none of
these platforms' downloads is part of the tests. `docs/grade_a_class.md` describes the table for teachers.
"""

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from nao_course._internal.text_encodings import NotTextError, decode_text
from nao_course.exercises.lesson_names import found_in, lesson_of, with_plain_signs
from nao_course.instructor.collecting.archives import Item, Refused
from nao_course.instructor.collecting.marks import read_marks, read_time, without_weak_marks
from nao_course.instructor.collecting.roster import Person, Roster, first_name_first, is_nameless

_RECEIPT = re.compile(r"submission-\d{8}-\d{6}", re.IGNORECASE)  # a zip of `nao-course submit`
_REQUEST = re.compile(r"regrade[ _-]?requests?[^/]*\.(?:txt|md)", re.IGNORECASE)
_FOLDER_NAME = "put it into a folder that has the student's name"
_METADATA = ("submission_metadata.yml",)  # names the students of Gradescope's export
_LARGEST_TEXT = 2**24  # bytes of a file of a platform that names students


@dataclass(frozen=True)
class Layout:
    """The names that a platform gives to submissions, as regular expressions.

    `path` matches a file's path, with "/" between folders; its groups are `student`, `file` (the rest of the path) and,
    if the platform names them, `number` (of the person), `attempt`, `time` and `late`. `wrapper` matches the folder
    that the platform puts around all students, and `ignored` the files that it adds. Unless `is_certain`, a file of
    this form may be anybody's.
    """

    platform: str
    path: str
    wrapper: str = ""
    ignored: str = ""
    is_certain: bool = True


_DAY = r"(?:[^\W\d_]{3,10}\.? \d{1,2}, \d{4}|\d{1,2}\.? [^\W\d_]{3,10}\.?,? \d{4})"  # "Nov 20, 2026", "20 Nov, 2026"
_MOODLE = r"(?P<student>[^/]+_(?P<number>\d+))_assignsubmission_[a-z]++_?"
_BRIGHTSPACE = rf"(?P<number>\d+)-\d+ - (?P<student>[^/]+?) - (?P<time>{_DAY},? \d{{3,4}}(?: [AP]M)?)"
_BLACKBOARD = r"(?P<student>[^/]+?)_attempt_(?P<time>\d{4}(?:-\d\d){5})"
LAYOUTS = (
    Layout(
        "Moodle",
        rf"{_MOODLE}/(?P<file>.*)",
        ignored=r"(?P<student>[^/]+_\d+)_assignsubmission_onlinetext(?!.*\.(?i:ipynb|zip)$)(?:_[^/]*)?(?:/.*)?",
    ),
    # A student's file that is named like one of Moodle's could pass for another student's.
    Layout(
        "Moodle", rf"(?![^/]*_\d++_assignsubmission_[^/]*_\d++_assignsubmission_){_MOODLE}(?P<file>[^/]*)"
    ),
    Layout(
        "Canvas",
        r"(?P<student>[^_/]+)(?P<late>_LATE)?_(?P<number>\d+)_(?P<time>\d+)_(?P<file>[^/]+)",
        ignored=r"(?P<student>(?:[^_/]+_(?:LATE_)?|(?:LATE_)?anon_[A-Za-z0-9]+)\d*)_(?:text|link)\.html",
    ),
    Layout(
        "Canvas", r"(?P<late>LATE_)?(?P<student>anon_(?P<number>[A-Za-z0-9]+))_(?P<time>\d+)_(?P<file>[^/]+)"
    ),
    Layout("Brightspace", rf"{_BRIGHTSPACE}(?: - |/)(?P<file>.*)", ignored=r"index\.html"),
    Layout(
        "Blackboard",
        rf"{_BLACKBOARD}[_/](?P<file>.*)",
        ignored=rf"{_BLACKBOARD}(?:\.txt|/[^/]*_attempt_[-\d]+\.txt)",
    ),
    Layout(
        "Sakai",
        r"(?P<student>[^/]+\((?P<number>[^/()]+)\))/Submission attachment\(s\)/(?P<file>.*)",
        wrapper=r"(?:lesson|assignment|homework|exercise|lab|week|\d\d)\b.*|\d\d_.*",
        ignored=r"(?P<student>[^/]+\([^/()]+\))/(?:(?:timestamp|comments)\.txt|[^/]*\.html|Feedback Attachment\(s\)/.*)"
        r"|grades\.(?:csv|xlsx?)",
    ),
    Layout("nbgrader", r"(?!)", wrapper="submitted", is_certain=False),
    Layout(
        "nbgrader",
        r"(?P<student>[^+/]+)\+[^+/]+\+(?P<time>\d{4}-\d\d-\d\d[ _]\d\d[:_.-]\d\d[^/+]*)(?:\+[^/]*)?/(?P<file>.*)",
        wrapper="inbound",
        ignored=r"(?P<student>[^+/]+)(?:\+[^/]*)?/(?:.*/)?(?:timestamp|submission_secret)\.txt",
    ),
    Layout(
        "Gradescope",
        r"(?P<student>submission_\d+)/(?P<file>.*)",
        wrapper=r"assignment_\d+_export",
        ignored=r"submission_metadata\.yml",
        is_certain=False,
    ),
    Layout(
        "Teams",
        r"(?P<student>[^/]+)/[^/]+/Version (?P<attempt>\d+)/(?P<file>.*)",
        wrapper="Submitted files",
        ignored=r"Working files/.*",
        is_certain=False,
    ),
    Layout(
        "ILIAS",
        r"(?P<student>[^_/]+_[^_/]+_[^_/]+_(?P<number>\d+))/(?:.*/)?(?P<file>(?:(?P<time>\d{14})_)?[^/]*)",
        is_certain=False,
    ),
    Layout(
        "Files and folders named after students",
        r"(?!)",
        wrapper=r"(?:.+-)?submissions",  # GitHub Classroom's, too
        ignored=r"(?:worlds|handed_in)\.csv|(?P<student>[^/]+)/(?:README\.md|LICENSE|\.git(?:ignore|attributes|hub/.*))",
        is_certain=False,
    ),
)
_PATHS = [(layout, re.compile(layout.path, re.DOTALL)) for layout in LAYOUTS]
_IGNORED = [re.compile(layout.ignored, re.DOTALL) for layout in LAYOUTS if layout.ignored]
_WRAPPERS = [(layout, re.compile(layout.wrapper, re.IGNORECASE)) for layout in LAYOUTS if layout.wrapper]
PLAIN = LAYOUTS[-1].platform
_CANVAS_AGAIN = re.compile(r"-(\d{1,3})$")
# Moodle puts the chosen group before the name.
_NUMBERED = re.compile(r"[ _-]\d{1,2}$", re.ASCII)  # "jan_2" beside "jan" may be a copy or another student
_GROUP = re.compile(
    r"(?:(?=[^-]*\d)|(?:group|gruppe|groupe|grupo|gruppo|groep|team)\b)[^-]*-(?=[^\W\d])", re.IGNORECASE
)


@dataclass(frozen=True)
class HandedIn:
    """The student whose file it is, the file's name without what a platform added, and which attempt it is.

    `number` is the platform's number or login of the person, and often empty; `written` is the student as the path
    writes it, with dates and titles. Of two files of one student and lesson the one with the larger `order` counts:
    attempt, then time, by the platform. `time` is when it was handed in, by the platform, with the offset from UTC if
    the platform names it, and often empty. If `is_certain`, only a platform names files so. `problem` says why nobody
    can say whose file it is, and what to do; `is_asked` means that it is a question who the student is.
    """

    student: str
    file: str
    platform: str = PLAIN
    number: str = ""
    written: str = ""
    order: tuple[int, float] = (0, 0.0)
    late: bool = False
    is_certain: bool = False
    problem: str = ""
    time: str = ""
    is_asked: bool = False


def handed_in(parts: Sequence[str], lessons: Sequence[str]) -> HandedIn | None:
    """Return whose file has a path; None if the path names no student.

    The path is given by folders; its last part is the file's own name.
    """
    path = _path(parts)
    for layout, pattern in _PATHS:
        if found := pattern.fullmatch(path):
            made = _by_layout(layout, found)
            if layout.platform == "Canvas" and not _is_canvass(made.file, path, lessons):
                continue
            if (
                layout.is_certain
                or layout.platform == "Gradescope"
                or read_marks(made.student).name == made.student
            ):
                return made
    return _in_folder(parts) if len(parts) > 1 else _before_lesson(parts[0], lessons)


def is_a_lesson(folder: str, lessons: Sequence[str]) -> bool:
    """Return whether a folder is named after a lesson and nothing else.

    >>> is_a_lesson("01_HSL_filtering", ["01_hsl_filtering"]), is_a_lesson("ada_01_hsl_filtering", ["01_hsl_filtering"])
    (True, False)
    """
    return any(not before and not after for _, before, after in found_in(f"{folder}.", lessons))


def is_a_platforms(folder: str) -> bool:
    """Return whether a folder, or the name of a file, has a form that only a platform's folder of one student has."""
    return any(
        layout.is_certain and layout.platform != "Canvas" and pattern.fullmatch(_path((folder, "x")))
        for layout, pattern in _PATHS
    )


def added_for(parts: Sequence[str]) -> str | None:
    """Return the student for whom a platform adds such a file, for example a receipt; None for any other file.

    The name is empty for a file about the whole class.
    """
    path = _path(parts)
    found = next(filter(None, (pattern.fullmatch(path) for pattern in _IGNORED)), None)
    return found and (found.groupdict().get("student") or "")


def is_request(file: str) -> bool:
    """Return whether a file is a student's file of requests, whatever an editor or browser added to its name.

    >>> is_request("Regrade_Request (1).txt")
    True
    """
    return bool(_REQUEST.fullmatch(file))


def moodle_name(path: str) -> str:
    """Return the name and number that Moodle gave to the student of a file; empty if it is not one of Moodle's.

    >>> moodle_name("Ada Lovelace_1234567_assignsubmission_file_/01_hsl_filtering.ipynb")
    'Ada Lovelace_1234567'
    """
    found = re.match(rf"(?![^/]*_\d++_assignsubmission_[^/]*_\d++_assignsubmission_){_MOODLE}", path)
    return found["student"] if found else ""


def canvas_name(path: str) -> str:
    """Return the name that Canvas gave to a file that was handed in, without its suffix; empty if it is not one.

    It may be in a zip that was handed in: ``x.zip/01_hsl_filtering.ipynb``.

    >>> canvas_name("lovelaceada_123456_7890123_01_hsl_filtering.ipynb")
    'lovelaceada_123456_7890123_01_hsl_filtering'
    """
    first = path.partition("/")[0]
    stem = first.rpartition(".")[0] or first
    is_canvass = any(
        each.platform == "Canvas" and pattern.fullmatch(_path((first,))) for each, pattern in _PATHS
    )
    return stem if is_canvass else ""


def _path(parts: Sequence[str]) -> str:
    """Return a path with ordinary spaces and digits, and without spaces beside the first part's underscores."""
    first = "_".join(part.strip() for part in with_plain_signs(parts[0]).split("_"))
    return "/".join((first, *map(with_plain_signs, parts[1:])))


def _by_layout(layout: Layout, found: re.Match[str]) -> HandedIn:
    """Return what a path of a platform's form says."""
    given = found.groupdict()
    written, number = given["student"], given.get("number") or ""
    student = written
    file = given["file"].rpartition("/")[2]
    attempt, time = int(given.get("attempt") or 0), 0.0
    problem, moment = "", ""
    if layout.platform == "Canvas":
        student = written if written.startswith("anon_") else f"{written}_{number}"
        stem, dot, suffix = file.rpartition(".")
        again = _CANVAS_AGAIN.search(stem)
        attempt, time = int(again[1]) if again else 0, float(given["time"][:18])
        file = _CANVAS_AGAIN.sub("", stem) + dot + suffix
    elif given.get("time"):
        stated = given["time"].replace("_", ":", 3) if layout.platform == "nbgrader" else given["time"]
        marks, moment = read_marks(stated), read_time(stated)
        time = marks.time
        if not marks.is_clear or not marks.time:
            problem = f"the time {given['time']!r} cannot be read; {_FOLDER_NAME}"
    if layout.platform == "Blackboard":
        student = written.rpartition("_")[2]  # behind the assignment's title
    if layout.platform == "Gradescope":
        problem = f"submission_metadata.yml, which names Gradescope's students, does not name this one; {_FOLDER_NAME}"
    order, late = (attempt, time), bool(given.get("late"))
    return HandedIn(
        student, file, layout.platform, number, written, order, late, layout.is_certain, problem, moment
    )


def _is_canvass(file: str, path: str, lessons: Sequence[str]) -> bool:
    """Return False for mueller_123456_01_hsl_filtering.ipynb, which has numbers like Canvas's, but no lesson behind."""
    return bool(lesson_of(file, lessons) or _RECEIPT.match(file)) or not _before_lesson(path, lessons)


def _in_folder(parts: Sequence[str]) -> HandedIn:
    """Return whose file lies in a folder that has a student's name; dates and attempts in its folders order it."""
    marks = read_marks(parts[0])
    inner = [read_marks(folder) for folder in parts[1:-1]]
    order = next(
        ((each.attempt, each.time) for each in (marks, *inner) if each.attempt or each.time), (0, 0.0)
    )
    return _named(parts[0], parts[-1], marks.name, order, marks.is_clear)


def _before_lesson(name: str, lessons: Sequence[str]) -> HandedIn | None:
    """Return whose file it is if the student's name stands before the lesson's; None if there is no such name."""
    stem = name.rpartition(".")[0]
    # Moodle's mark in a student's own file could name another student
    if not stem or "_assignsubmission_" in stem:
        return None
    places = [(before, name[len(before) :]) for _, before, after in found_in(name, lessons) if not after]
    places += [(stem[: found.start()], name[found.start() :]) for found in _RECEIPT.finditer(stem[:1000])]
    for before, file in places:
        # A digit right before it would be the end of another number, such as a platform's student number.
        if (student := before.strip("_- ")) and not before[-1:].isdigit():
            marks = read_marks(student)
            return _named(student, file, marks.name, (marks.attempt, marks.time), marks.is_clear)
    return None


def _named(whole: str, file: str, name: str, order: tuple[int, float], is_clear: bool) -> HandedIn:
    """Return a file of a student who is named by a person, or the problem if the name is not clear."""
    problem = ""
    if not name:
        problem = f"{whole!r} is a date or an attempt, not a student; {_FOLDER_NAME}"
    elif not is_clear:
        problem = f"the date or attempt in {whole!r} cannot be read; {_FOLDER_NAME}"
    return HandedIn(name or whole, file, written=whole, order=order, problem=problem)


# --- what only a whole download shows ---


class Students:
    """The students of the files of one download, given without the folders around the students.

    `roster` has the students of earlier runs and of sheets; without one, students are named as in the download.
    `platforms` are the platforms whose folder was around a student's folder, by the student's folder. `recognised` says
    which students the people of the download are.
    """

    def __init__(
        self,
        items: Iterable[Item],
        lessons: Sequence[str],
        roster: Roster | None = None,
        platforms: Mapping[str, str] | None = None,
    ) -> None:
        self.lessons, self.platforms = lessons, platforms or {}
        self._roster = roster or Roster()
        self._items = list(items)
        files = [(item.parts, made) for item in self._items if (made := handed_in(item.parts, lessons))]
        heads = {made.written for _, made in files if made.platform == "Blackboard"}
        self._blackboard = {head: self._blackboards_user(head) for head in heads}
        self._gradescope = _gradescopes_people(self._items)
        self._moodle = _same_participants(made.student for _, made in files if made.platform == "Moodle")
        self._numbers = _grouped((made.student, made.number) for _, made in files if made.number)
        people = {made.student for _, made in files if not made.is_certain}
        self._unnumbered = {_without_weak_marks(each) for each in people}
        self._alike = _grouped((self._base(each), each.casefold()) for each in people)
        self._times = {
            item.parts[:-1]: read_time(_text_of(item))
            for item in self._items
            if item.parts[-1] == "timestamp.txt" and added_for(item.parts)
        }
        self.recognised = self._roster.recognise(self._people()) if roster is not None else None

    def is_known(self, name: str) -> bool:
        """Return whether a student of an earlier run or a sheet has this name."""
        return self._roster.is_known(name)

    def of(self, parts: Sequence[str]) -> HandedIn | None:
        """Return whose file it is; None if its path names no student."""
        made = self._in_download(parts)
        if made is None or made.problem or self.recognised is None:
            return made
        if question := self.recognised.asked.get(made.student):
            return replace(made, problem=question, is_asked=True)
        return replace(made, student=self.recognised.students.get(made.student, made.student))

    def _people(self) -> list[Person]:
        """Return the people of the download."""
        found = dict[str, Person]()
        lessons: dict[str, set[str]] = defaultdict(set)
        for item in self._items:
            made = self._in_download(item.parts)
            if made and not made.problem:
                found.setdefault(made.student, _person(made))
                lessons[made.student] |= {lesson for lesson, _, _ in found_in(made.file, self.lessons)}
        return [replace(each, lessons=frozenset(lessons[name])) for name, each in found.items()]

    def _in_download(self, parts: Sequence[str]) -> HandedIn | None:
        """Return whose file it is, by the name that a student has in the download."""
        made = handed_in(parts, self.lessons)
        if len(parts) > 1 and not (made and made.is_certain) and self.is_known(parts[0]):
            named = made or HandedIn(parts[0], parts[-1])
            made = replace(named, student=parts[0], file=parts[-1], written=parts[0], problem="")
        if made is None:
            return None
        if made.platform == PLAIN:
            made = replace(made, platform=self.platforms.get(parts[0], PLAIN))
        student, problem, time = made.student, made.problem, made.time
        match made.platform:
            case "Gradescope" if parts[0] in self._gradescope:
                student, order, time, problem = self._gradescope[parts[0]]
                made = replace(made, order=(0, order))
            case "Blackboard":
                student = self._blackboard.get(made.written, "")
                if not student:
                    problem = (
                        f"the title and the user in {made.written!r} cannot be distinguished; {_FOLDER_NAME}"
                    )
            case "Moodle":
                student = self._moodle.get(student, student)
            case "Brightspace" if len(self._numbers[student]) > 1:
                problem = f"there are several students {student!r} with different numbers; {_FOLDER_NAME}"
            case "Sakai" | "nbgrader":
                time = time or self._times.get(tuple(parts[: 1 if made.platform == "Sakai" else 2]), "")
        alike = set() if made.is_certain or self.is_known(student) else self._alike[self._base(student)]
        if len(alike) > 1 and not problem:
            names = ", ".join(sorted(alike)[:3])
            problem = (
                f"these names may be attempts of one student: {names}. If so, {_FOLDER_NAME}; if they are several "
                "students, rename them, such as 'jan_2' to 'jan b'"
            )
        return replace(made, student=student or made.written, problem=problem, time=time)

    def _base(self, student: str) -> str:
        """Return a name without what may mark a copy; a number at its end only if there is the name without it."""
        name = _without_weak_marks(student)
        base = _NUMBERED.sub("", name)
        return base if base in self._unnumbered else name

    def _blackboards_user(self, head: str) -> str:
        """Return the user of "TITLE_USER"; empty if underscores leave several possible users."""
        users = [head[at + 1 :] for at, each in enumerate(head) if each == "_"]
        if known := [each for each in users if self.is_known(each)]:
            return known[0]
        if len(users) < 2:
            return users[0] if users else head
        if (user := self._blackboards_receipt(head)) in users:
            return user
        titles = [after for _, before, after in found_in(f"{head}.", self.lessons) if not before and after]
        return next((each.removeprefix("_") for each in titles if each.startswith("_")), "")

    def _blackboards_receipt(self, head: str) -> str:
        """Return the user in brackets at the end of the first line of Blackboard's own text about an attempt.

        A text that a student handed in has its own name behind the time, or lies in that student's folder.
        """
        own = re.compile(rf"(?:{re.escape(head)}_attempt_[-\d]+/)?{re.escape(head)}_attempt_[-\d]+\.txt")
        for item in self._items:
            if own.fullmatch(_path(item.parts)):
                lines = _text_of(item).splitlines()[:1]
                if found := re.search(r"\(([^()]+)\)\s*$", lines[0] if lines else ""):
                    return found[1].strip()
        return ""


def _without_weak_marks(student: str) -> str:
    return without_weak_marks(student).casefold()


def _grouped(pairs: Iterable[tuple[str, str]]) -> dict[str, set[str]]:
    groups: dict[str, set[str]] = defaultdict(set)
    for key, value in pairs:
        groups[key].add(value)
    return groups


def person_in(path: str, lesson: str) -> Person | None:
    """Return the person whom a platform names in the path of a file of a lesson; None if no platform does.

    >>> person_in("Group A-Ada_12_assignsubmission_file_/01_hsl_filtering.ipynb", "01_hsl_filtering").alias
    'moodle 12'
    """
    made = handed_in(path.split("/"), [lesson])
    if made is None or made.problem or made.platform == PLAIN:
        return None
    if made.platform == "Moodle":
        made = replace(made, student=_GROUP.sub("", made.student, count=1))
    return replace(_person(made), lessons=frozenset([lesson]))


def _person(made: HandedIn) -> Person:
    """Return what a platform's name of a student says about the person."""
    student, number = made.student, made.number
    match made.platform:
        case "Moodle":
            return Person(student, made.platform, number, student.rpartition("_")[0])
        case "Canvas":
            return Person(
                student, made.platform, number, "" if is_nameless(student) else student.rpartition("_")[0]
            )
        case "Brightspace":
            return Person(student, made.platform, number, student)
        case "ILIAS":
            last, first, login, _ = student.split("_")
            return Person(student, made.platform, number, f"{first} {last}", login)
        case "Sakai":
            return Person(student, made.platform, "", first_name_first(student.rpartition("(")[0]), number)
        case "Gradescope":
            name, _, mail = student.rpartition(" (")
            return Person(
                student, made.platform, "", name or student, email=mail.removesuffix(")") if name else ""
            )
        case "Blackboard" | "nbgrader" | "GitHub Classroom":
            return Person(student, made.platform, login=student)
    return Person(student, made.platform, name=student)


def _same_participants(students: Iterable[str]) -> dict[str, str]:
    """Return one name for all names of a Moodle participant: with a group's name before it, and without it."""
    names = {}
    for same in _grouped((each.rpartition("_")[2], each) for each in students).values():
        for each in same:
            alike = [it for it in same if it == each or it.endswith(f"-{each}") or each.endswith(f"-{it}")]
            names[each] = min((_GROUP.sub("", it, count=1) for it in alike), key=lambda it: (len(it), it))
    return names


def _gradescopes_people(items: Iterable[Item]) -> dict[str, tuple[str, float, str, str]]:
    """Return name, order, time and problem of each folder of Gradescope's export, from its file of metadata."""
    people: dict[str, tuple[str, float, str, str]] = {}
    for item in items:
        if item.parts == _METADATA:
            for folder, block in _blocks(_text_of(item)):
                head = re.split(r"(?m)^  :?(?!submitters)\w+:", block, maxsplit=1)[0]
                names = [_unquoted(each) for each in re.findall(r"(?m)^ *- *:?name: *(.*)$", head)]
                mails = [_unquoted(each) for each in re.findall(r"(?m)^ *:?email: *(.*)$", head)]
                made = re.search(r"(?m)^  :?created_at: *(.*)$", block)
                stated = _unquoted(made[1]) if made else ""
                name = f"{names[0]} ({mails[0]})" if names and mails else "".join(names[:1])
                several = (
                    f"several students handed it in ({', '.join(names)}); put a copy into a folder of each"
                )
                people[folder] = (
                    name,
                    read_marks(stated).time,
                    read_time(stated),
                    several if len(names) > 1 else "" if name else "it names nobody",
                )
    return people


def _blocks(text: str) -> Iterator[tuple[str, str]]:
    """Yield each submission of Gradescope's metadata with the lines that belong to it."""
    places = [*re.finditer(r"(?m)^(submission_\d+):[ \t]*$", text)]
    for place, after in zip(places, [*places[1:], None], strict=True):
        yield place[1], text[place.end() : after.start() if after else None]


def _unquoted(value: str) -> str:
    return value.strip().strip("'\"")


def _text_of(item: Item) -> str:
    try:
        return decode_text(item.content(_LARGEST_TEXT))
    except (Refused, NotTextError):
        return ""


# --- the folders around all students ---


def without_wrappers(
    items: Iterable[Item], known: Callable[[str], bool], root: str = ""
) -> tuple[list[Item], dict[str, str]]:
    """Remove the folders that platforms put around all students.

    `known` returns whether a student of an earlier run has a name: then a folder of this name is that student's. The
    first part of each returned item is a student's folder or the file itself; files that a platform adds about the
    whole class are left out. The second result has the platforms by students' folders.
    """
    kept, platforms = [], dict[str, str]()
    for item in items:
        around, parts = root, item.parts
        if len(parts) > 1 and not known(parts[0]):
            for layout, pattern in _WRAPPERS:
                if pattern.fullmatch(parts[0]) and (not layout.is_certain or _fits(layout, parts[1:])):
                    around, parts = parts[0], parts[1:]
                    platforms[parts[0]] = layout.platform
                    break
        title = f"{around.removesuffix('-submissions')}-" if around.endswith("-submissions") else ""
        # Each repository has the assignment's title
        if title and len(parts) > 1 and parts[0].startswith(title):
            parts = (parts[0].removeprefix(title), *parts[1:])
            platforms[parts[0]] = "GitHub Classroom"
        if added_for(parts) != "" or parts == _METADATA:
            kept.append(replace(item, parts=parts))
    return kept, platforms


def _fits(layout: Layout, inner: Sequence[str]) -> bool:
    """Return whether a path below a folder has the form that the folder's platform gives it."""
    forms = (layout.path, layout.ignored)
    return any(form and re.fullmatch(form, _path(inner), re.DOTALL) for form in forms)
