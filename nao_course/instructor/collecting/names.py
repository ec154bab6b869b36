"""Whose file it is and of which lesson: the names that students, browsers and learning platforms give.

Understood are, each in a folder or in a zip:

- ``STUDENT/01_hsl_filtering.ipynb``, also some folders deeper;
- ``STUDENT_01_hsl_filtering.ipynb``;
- Moodle's ``Firstname Lastname_1234567_assignsubmission_file_/01_hsl_filtering.ipynb`` and the older
  ``Firstname Lastname_1234567_assignsubmission_file_01_hsl_filtering.ipynb``;
- Canvas's ``lastnamefirstname_123456_7890123_01_hsl_filtering.ipynb``, with ``_LATE`` after the name, and with ``-2``
  after the file's name where it was handed in again;
- a zip in place of a notebook, such as the zip of ``nao-course submit``. A zip within that zip is not opened.

The lesson is in the file's name, whatever a browser or Jupyter added: ``01_hsl_filtering (1).ipynb``,
``01_hsl_filtering-Copy1.ipynb``. A student is called by the folder or what precedes the lesson, with the platform's
number: two students may have one name. Nothing is opened here.
"""

from __future__ import annotations

import hashlib
import re
import unicodedata
from collections.abc import Sequence
from dataclasses import dataclass

LONGEST_NAME = 100
# Characters of a file's name in which a lesson is looked for: more than file systems take.
LONGEST_FILE = 1000
_MOODLE = re.compile(r"(?P<student>.+_\d+)_assignsubmission_[a-z]+_?(?P<file>.*)", re.DOTALL)
_ONLINE_TEXT = re.compile(r".+_\d+_assignsubmission_onlinetext(?:_.*)?", re.DOTALL)
_PLATFORMS = re.compile(r"_\d++_assignsubmission_")
_CANVAS = re.compile(
    r"(?P<student>[^_]+)(?P<late>_LATE)?_(?P<user>\d+)_(?P<handed_in>\d+)_(?P<file>.+)", re.DOTALL
)
# What browsers, Jupyter and people put behind a name. Possessive: a student's name of any length costs one pass.
_COPY = re.compile(r"(?:[ _-]*+(?:\(\d++\)|(?:copy|kopie|v|final) ?+\d*+|\d++))*+[ _-]*+", re.IGNORECASE)
_RECEIPT = re.compile(r"submission-\d{8}-\d{6}", re.IGNORECASE)
_RESUBMITTED = re.compile(r"-(\d{1,3})$")
_PLAIN = re.compile(r"[a-z0-9_][a-z0-9_.-]{0,59}(?<![.])")
_HASHED = re.compile(r".*-[0-9a-f]{16}")
_RESERVED = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)(\..*)?")


@dataclass(frozen=True)
class NamedFile:
    """Whose file it is and what it is called, from where it lies.

    Parameters
    ----------
    student : str
        Whose.
    file : str
        What it is called, without what a platform added.
    order : tuple of int
        Of two files of one name the larger one counts: for Canvas, how often it was handed in again and its number.
    late : bool
        Whether the platform says that it was handed in late: Canvas does so in the file's name.
    """

    student: str
    file: str
    order: tuple[int, int] = (0, 0)
    late: bool = False


def name_file(parts: tuple[str, ...], lessons: Sequence[str]) -> NamedFile | None:
    """Say whose file lies somewhere; None where no student is named.

    Parameters
    ----------
    parts : tuple of str
        Where it lies, by folders; the last one is the file's own name.
    lessons : sequence of str
        Names of the lessons that there are.
    """
    first, last = parts[0], parts[-1]
    if moodle := _MOODLE.fullmatch(_of_a_platform(first)):
        if len(parts) == 1 and _PLATFORMS.search(moodle["student"]):
            return None  # a file that its student named like one of Moodle's: it might pass for another's
        return NamedFile(moodle["student"], last if len(parts) > 1 else moodle["file"])
    if len(parts) > 1:
        return NamedFile(first, last)
    return _canvas(first, lessons) or _plain(first, lessons)


def _normal(name: str) -> str:
    """Return a platform's name with ordinary spaces and digits; its number says whose it is, however it is spelled."""
    return "".join(
        " " if each.isspace() else str(unicodedata.decimal(each)) if each.isdecimal() else each
        for each in name
    )


def _of_a_platform(name: str) -> str:
    """Return a platform's name with ordinary spaces and digits, and without spaces beside its underscores."""
    return "_".join(part.strip() for part in _normal(name).split("_"))


def student_of_a_platforms(file: str, lessons: Sequence[str]) -> str:
    """Return the student of a file that Moodle or Canvas named; an empty string for any other file."""
    if moodle := _MOODLE.fullmatch(_of_a_platform(file)):
        return moodle["student"]
    found = _canvas(file, lessons)
    return found.student if found else ""


def canvas_name(path: str) -> str:
    """Return the name that Canvas gave to a file that was handed in, without its suffix; empty if it is not one.

    Parameters
    ----------
    path : str
        The file, or a file in a zip that was handed in: ``x.zip/01_hsl_filtering.ipynb``.

    Examples
    --------
    >>> canvas_name("lovelaceada_123456_7890123_01_hsl_filtering.ipynb")
    'lovelaceada_123456_7890123_01_hsl_filtering'
    """
    first = path.partition("/")[0]
    stem = first.rpartition(".")[0] or first
    return stem if _CANVAS.fullmatch(_of_a_platform(first)) else ""


def _canvas(name: str, lessons: Sequence[str]) -> NamedFile | None:
    """Return the student of a file named by Canvas."""
    if not (found := _CANVAS.fullmatch(_of_a_platform(name))):
        return None
    stem, dot, suffix = found["file"].rpartition(".")
    again = _RESUBMITTED.search(stem)
    file = _RESUBMITTED.sub("", stem) + dot + suffix
    if not (lesson_of(file, lessons) or _RECEIPT.match(file)) and _plain(name, lessons):
        return None  # mueller_123456_01_hsl_filtering.ipynb has numbers like Canvas's, but it is not one of its names
    order = (int(again[1]) if again else 0, int(found["handed_in"][:18]))
    return NamedFile(f"{found['student']}_{found['user']}", file, order, bool(found["late"]))


def _plain(name: str, lessons: Sequence[str]) -> NamedFile | None:
    """Return the student of a file whose name has the student before the lesson."""
    stem, _, suffix = name.rpartition(".")
    for found in (*_lessons_in(stem, lessons), *_followed_by_copy(_RECEIPT, stem)):
        before = stem[: found.start()]
        # A digit right before it would be the end of another number, such as a platform's student number.
        if (student := before.strip("_- ")) and not before[-1:].isdigit():
            return NamedFile(student, name[found.start() :])
    return NamedFile(stem, name) if stem.startswith("submission-") and suffix == "zip" else None


def _lessons_in(stem: str, lessons: Sequence[str]) -> list[re.Match[str]]:
    """Return the position of a lesson's name, with nothing after it except the suffix of a copy."""
    names = "|".join(re.sub("[_-]", "[ _-]", re.escape(name).replace(r"\-", "-")) for name in lessons)
    return _followed_by_copy(re.compile(names, re.IGNORECASE), _normal(stem)) if names else []


def _followed_by_copy(name: re.Pattern[str], stem: str) -> list[re.Match[str]]:
    return [found for found in name.finditer(stem[:LONGEST_FILE]) if _COPY.fullmatch(stem, found.end())]


def lesson_of(file: str, lessons: Sequence[str]) -> str:
    """Return the lesson that a file is named after, or an empty string.

    Examples
    --------
    >>> lesson_of("01_HSL_filtering (1).ipynb", ["01_hsl_filtering"])
    '01_hsl_filtering'
    """
    stem = file.rpartition(".")[0] or file
    for found in _lessons_in(stem, lessons):
        if found.start() == 0 or stem[found.start() - 1] in "_ -":
            name = re.sub("[ -]", "_", found[0].lower())
            return next((each for each in lessons if each.replace("-", "_") == name), "")
    return ""


def is_a_lesson(folder: str, lessons: Sequence[str]) -> bool:
    """Return whether a folder is named after a lesson and nothing else.

    Examples
    --------
    >>> is_a_lesson("01_HSL_filtering", ["01_hsl_filtering"]), is_a_lesson("ada_01_hsl_filtering", ["01_hsl_filtering"])
    (True, False)
    """
    return bool(lesson_of(f"{folder}.ipynb", lessons)) and not _plain(f"{folder}.ipynb", lessons)


def mentions_a_lesson(file: str, lessons: Sequence[str]) -> bool:
    """Return whether a lesson's name stands in a file's name, whatever comes after it.

    Examples
    --------
    >>> mentions_a_lesson("ada 01_hsl_filtering.ipynb.txt", ["01_hsl_filtering"])
    True
    """
    name = re.sub("[ _-]", "_", _normal(file[:LONGEST_FILE]).lower())
    return any(each.replace("-", "_").lower() in name for each in lessons)


def is_a_platforms(folder: str) -> bool:
    """Return True if a folder is named like Moodle's folder of one student."""
    return bool(_MOODLE.fullmatch(_of_a_platform(folder)))


def is_online_text(first: str) -> bool:
    """Return whether a folder, or a file in none, has what a student typed into Moodle's text field.

    Examples
    --------
    >>> is_online_text("Ada Lovelace_1234567_assignsubmission_onlinetext_")
    True
    """
    return bool(_ONLINE_TEXT.fullmatch(_of_a_platform(first)))


def safe_name(student: str) -> str:
    """Return a file name for a student: no two have one, whatever the file system makes of upper and lower case.

    Examples
    --------
    >>> safe_name("ada_lovelace")
    'ada_lovelace'
    >>> safe_name("../Ada")
    'ada-4e4af21652b78501'
    """
    ordinary = (
        _PLAIN.fullmatch(student) and not _HASHED.fullmatch(student) and not _RESERVED.fullmatch(student)
    )
    if ordinary:
        return student
    letters = unicodedata.normalize("NFKD", student).encode("ascii", "ignore").decode().lower()
    start = re.sub(r"[^a-z0-9_]+", "-", letters).strip("-")[:40] or "student"
    return f"{start}-{hashlib.sha256(student.encode('utf-8', 'surrogatepass')).hexdigest()[:16]}"


def clean_name(name: str) -> str:
    """Return a name without control characters or halves of characters, not too long, and still its own."""
    name = name.encode("utf-8", "surrogateescape").decode("utf-8", "backslashreplace")
    blank = "".join(f"\\x{ord(each):02x}" for each in name)  # what a name of nothing but spaces is called
    name = unicodedata.normalize("NFC", name).strip() or blank
    name = "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in name)
    if len(name) > LONGEST_NAME:
        name = f"{name[: LONGEST_NAME - 20]}...{hashlib.sha256(name.encode()).hexdigest()[:16]}"
    return name
