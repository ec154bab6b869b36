"""Grades and feedback on their way back to Moodle and Canvas: their own sheet filled in, their own names kept."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from nao_course.homework import zipped
from nao_course.instructor.gradebook.scores import Score
from nao_course.instructor.reports.html import number
from nao_course.instructor.reports.spreadsheets import TableError, read_rows

PLATFORMS = ("moodle", "canvas")
_LAST_NUMBER = re.compile(r"_(\d+)$")  # of a student's name, as the platform's zip gave it
_NO_STUDENTS = ("points possible", "student, test")  # rows of Canvas's own


@dataclass(frozen=True)
class FilledSheet:
    """A platform's sheet with points in it, and what did not fit.

    Parameters
    ----------
    table : bytes
        CSV, to be uploaded.
    filled : int
        Rows that got points.
    without_row : tuple of str
        Students who were graded and have no row in the sheet, or share their number with another one.
    without_grade : tuple of str
        Rows of people who have not been graded; they are as they were.
    """

    table: bytes
    filled: int
    without_row: tuple[str, ...]
    without_grade: tuple[str, ...]


def fill_sheet(platform: str, sheet: Path, made: Iterable[Score], column: str = "") -> FilledSheet:
    """Write points into the sheet that a platform gave out.

    Parameters
    ----------
    platform : str
        One of `PLATFORMS`.
    sheet : Path
        Moodle's grading worksheet, or Canvas's exported gradebook.
    made : iterable of Score
        Scores of one lesson. A student is found by the number that the platform put into the file name.
    column : str
        The column's name, or how it begins; with Canvas, where there is one for each assignment.

    Returns
    -------
    FilledSheet
        All other cells as they were.

    Raises
    ------
    TableError
        If it is not such a sheet, or no column is given.
    """
    rows = read_rows(sheet)
    if not rows:
        raise TableError(f"{sheet.name} is empty")
    header = rows[0]
    key, at = _columns(platform, sheet.name, header, column)
    made = list(made)
    numbers = Counter(_number_of(each.result.student) for each in made)
    points = {n: each for each in made if numbers[n := _number_of(each.result.student)] == 1 and n}
    there, filled, left = set(), 0, []
    for row in rows[1:]:
        row += [""] * (len(header) - len(row))
        found = re.fullmatch(r"(?:\D*\s)?(\d+)", row[key].strip())
        if not found or row[0].strip().casefold().startswith(_NO_STUDENTS):
            continue
        there.add(found[1])
        if found[1] in points:
            row[at], filled = number(points[found[1]].earned), filled + 1
        else:
            left.append(row[0].strip())
    without = sorted(
        each.result.student for each in made if _number_of(each.result.student) not in there & points.keys()
    )
    text = io.StringIO()
    csv.writer(text, lineterminator="\r\n").writerows(rows)
    return FilledSheet(text.getvalue().encode("utf-8-sig"), filled, tuple(without), tuple(left))


def _columns(platform: str, file: str, header: Sequence[str], wanted: str) -> tuple[int, int]:
    """Return the columns of the students' numbers and of the points in a sheet."""
    names = [each.strip().casefold() for each in header]
    key = {"moodle": "identifier", "canvas": "id"}[platform]
    if key not in names:
        which = {"moodle": "grading worksheet", "canvas": "exported gradebook"}[platform]
        raise TableError(f"{file} is not {platform.title()}'s {which}: it has no column {key!r}")
    if platform == "moodle" and not wanted:
        wanted = "grade"
    if not wanted:
        raise TableError(f"say which column the points go to: --column {_first_assignment(header)!r}")
    fits = [i for i, name in enumerate(names) if name == wanted.casefold()]
    fits = fits or [i for i, name in enumerate(names) if name.startswith(wanted.strip().casefold())]
    if len(fits) != 1:
        raise TableError(
            f"{file} has {len(fits) or 'no'} columns that begin with {wanted!r}; it has {', '.join(header)[:500]}"
        )
    return names.index(key), fits[0]


def _first_assignment(header: Sequence[str]) -> str:
    return next((name for name in header if re.search(r"\(\d+\)$", name)), "the assignment's name")


def _number_of(student: str) -> str:
    found = _LAST_NUMBER.search(student)
    return found[1] if found else ""


def moodle_feedback(pages: Mapping[str, bytes]) -> tuple[bytes, tuple[str, ...]]:
    """Make the zip that Moodle takes as "multiple feedback files": folders with the names of its own download.

    Parameters
    ----------
    pages : mapping of str to bytes
        Feedback by student.

    Returns
    -------
    archive : bytes
        A zip, the same bytes for the same pages.
    left_out : tuple of str
        Students whose names have no number of Moodle's.
    """
    files = {
        f"{each}_assignsubmission_file_/feedback.html": pages[each] for each in pages if _number_of(each)
    }
    return zipped(files), tuple(sorted(each for each in pages if not _number_of(each)))
