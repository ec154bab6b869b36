"""Export to Moodle and Canvas: fill in the platform's sheet, and name feedback files as the platform expects."""

from __future__ import annotations

import csv
import io
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from nao_course._internal.tables import (
    TableError,
    plain_number,
    read_rows,
    refuse_doubled_columns,
    refuse_doubled_numbers,
)
from nao_course.homework import zipped
from nao_course.instructor.collecting.layouts import canvas_name, moodle_name, person_in
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.gradebook.records import SubmissionResult
from nao_course.instructor.gradebook.scores import Score
from nao_course.instructor.reports.html import number

PLATFORMS = ("moodle", "canvas")
# Moodle's columns, in the languages whose words are known here: the number, the points, the maximum.
MOODLES_COLUMNS = {
    "English": ("Identifier", "Grade", "Maximum Grade"),
    "German": ("ID", "Bewertung", "Bestwertung"),
    "French": ("Identifiant", "Note", "Note maximale"),
    "Spanish": ("Identificador", "Calificación", "Calificación máxima"),
}
UPLOADS = {  # where a platform takes the zip of feedback
    "moodle": "Moodle's 'Upload multiple feedback files in a zip'",
    "canvas": "Canvas's 'Upload Submissions' of the assignment",
}
POSSIBLE = "Points Possible"  # the row of Canvas's gradebook with the maxima
_LAST_NUMBER = re.compile(r"_(\d+)$")  # of a student's name, as the platform's zip gave it
_TEST_STUDENT = "student, test"  # a row of Canvas's own


@dataclass(frozen=True)
class FilledSheet:
    """A platform's sheet, CSV, to be uploaded, with the number of rows that got points, and what did not fit.

    `without_row` are students who were graded and have no row, or share their number with another student;
    `without_grade` are unchanged rows of people who have not been graded.
    """

    table: bytes
    filled: int
    without_row: tuple[str, ...]
    without_grade: tuple[str, ...]


@dataclass(frozen=True)
class _Columns:
    """Where the students' numbers, the points and the maxima are; Canvas has the maxima in a row."""

    number: int
    points: int
    maximum: int | None


def fill_sheet(
    platform: str,
    sheet: Path,
    made: Iterable[Score],
    column: str = "",
    *,
    roster: Roster | None = None,
    scale: bool = False,
) -> FilledSheet:
    """Write points of one lesson into Moodle's grading worksheet or Canvas's exported gradebook, and nothing else.

    A student is found by the number that the platform, one of `PLATFORMS`, put into the file's name or that the roster
    has. `column` is its
    column's name, or how it begins; Canvas has a column for each assignment. With `scale`, points are scaled to the
    platform's maximum. Raise a TableError if it is not such a sheet, if a student or a column that matters is there
    twice, if no column is given, or if its maximum is not the lesson's and `scale` is false.
    """
    rows = read_rows(sheet)
    if not rows:
        raise TableError(f"{sheet.name} is empty")
    header = rows[0]
    columns = _columns(platform, sheet.name, header, column)
    rows = [row + [""] * (len(header) - len(row)) for row in rows]
    made = list(made)
    worth = max((each.points for each in made), default=0.0)
    maximum_of = _maxima(rows, columns, sheet.name)
    scores = defaultdict[str, list[Score]](list)
    for score in made:
        for its in _numbers(platform, score.result, roster):
            scores[its].append(score)
    points = {its: found[0] for its, found in scores.items() if len(found) == 1}
    students = {
        at: found[1]
        for at, row in enumerate(rows)
        if at
        and (found := re.fullmatch(r"\D*(\d+)", row[columns.number].strip()))
        and not row[0].strip().casefold().startswith((POSSIBLE.casefold(), _TEST_STUDENT))
    }
    refuse_doubled_numbers(sheet.name, ((at + 1, its) for at, its in students.items()))
    filled, left = 0, []
    for at, its in students.items():
        row = rows[at]
        if its in points:
            maximum = maximum_of(row)
            earned = points[its].earned
            if abs(_value(maximum) - worth) > 0.005:
                if not scale:
                    raise TableError(_other_maximum(platform, sheet.name, maximum, made[0], worth))
                earned *= _value(maximum) / worth if worth else 0.0
            row[columns.points] = number(earned).replace(".", "," if "," in maximum else ".")
            filled += 1
        else:
            left.append(row[0].strip())
    in_row = {points[its].result.student for its in students.values() if its in points}
    without = sorted(each.result.student for each in made if each.result.student not in in_row)
    text = io.StringIO()
    csv.writer(text, lineterminator="\r\n").writerows(rows)
    return FilledSheet(text.getvalue().encode("utf-8-sig"), filled, tuple(without), tuple(left))


def _other_maximum(platform: str, file: str, maximum: str, some: Score, worth: float) -> str:
    """Return the message for a platform's maximum that is not the lesson's."""
    return (
        f"{file}: the maximum in {platform.title()} is {number(_value(maximum))} points, and {some.result.lesson} "
        f"is worth {number(worth)}. Set the maximum in {platform.title()} to {number(worth)} and download the sheet "
        "again, or scale the points with --scale"
    )


def _maxima(rows: Sequence[Sequence[str]], columns: _Columns, file: str) -> Callable[[Sequence[str]], str]:
    """Return a function that finds the maximum for a row, as it is written in the sheet."""

    def checked(cell: str, where: str) -> str:
        if not _value(cell) > 0:
            raise TableError(
                f"{file}: {where} should be a maximum above 0, such as 1300 or 12.5, and it is {cell.strip()!r}"
            )
        return cell

    if (at := columns.maximum) is not None:
        return lambda row: checked(row[at], f"{rows[0][at].strip()!r} of {row[columns.number].strip()!r}")
    row = next((row for row in rows if row[0].strip().casefold() == POSSIBLE.casefold()), None)
    if row is None:
        raise TableError(f"{file} has no row {POSSIBLE!r}, which has the maximum: export the gradebook again")
    cell = checked(row[columns.points], f"{POSSIBLE!r} of {rows[0][columns.points]!r}")
    return lambda _: cell


def _value(cell: str) -> float:
    """Return a maximum that is written with a point or a comma; 0 for anything else."""
    return plain_number(cell) or 0.0


def _columns(platform: str, file: str, header: Sequence[str], wanted: str) -> _Columns:
    """Return the columns of a sheet that matter."""
    names = [each.strip().casefold() for each in header]
    if platform == "moodle":
        key, grade, maximum = _moodles_columns(file, header, names)
        wanted = wanted or grade
    else:
        key, maximum = "id", None
    if key.casefold() not in names:
        raise TableError(f"{file} is not Canvas's exported gradebook: it has no column 'ID'")
    if not wanted:
        raise TableError(f"say which column the points go to: --column {_first_assignment(header)!r}")
    keys = [each.casefold() for each in (key, maximum) if each]
    refuse_doubled_columns(file, names, keys)
    fits = [i for i, name in enumerate(names) if name == wanted.strip().casefold()]
    fits = fits or [i for i, name in enumerate(names) if name.startswith(wanted.strip().casefold())]
    if len(fits) != 1:
        raise TableError(
            f"{file} has {len(fits) or 'no'} columns that begin with {wanted!r}; it has {', '.join(header)[:500]}"
        )
    return _Columns(
        names.index(key.casefold()), fits[0], names.index(maximum.casefold()) if maximum else None
    )


def _moodles_columns(file: str, header: Sequence[str], names: Sequence[str]) -> tuple[str, str, str]:
    """Return the names of the number's, the points' and the maximum's column in the worksheet's language."""
    for columns in MOODLES_COLUMNS.values():
        if all(each.casefold() in names for each in columns):
            return columns
    known = "; ".join(
        f"{', '.join(map(repr, columns))} ({language})" for language, columns in MOODLES_COLUMNS.items()
    )
    raise TableError(
        f"{file} is not Moodle's grading worksheet, or it is in another language. Its columns are "
        f"{', '.join(header)[:150]}. It should have {known}. Switch Moodle to one of these languages and download "
        "the worksheet again"
    )


def _first_assignment(header: Sequence[str]) -> str:
    return next((name for name in header if re.search(r"\(\d+\)$", name)), "the assignment's name")


def _numbers(platform: str, result: SubmissionResult, roster: Roster | None) -> set[str]:
    """Return the numbers of a student on a platform: in the file's name, in the roster, or in the student's name."""
    name = moodle_name(result.file) if platform == "moodle" else canvas_name(result.file)
    person = person_in(result.file, result.lesson) if name else None
    if person and person.number:
        return {person.number}
    start = f"{platform} "
    student = roster.students.get(result.student) if roster else None
    aliases = student.aliases if student else ()
    known = {alias.removeprefix(start) for alias in aliases if alias.startswith(start)}
    found = _LAST_NUMBER.search(result.student)
    return known or ({found[1]} if found else set())


def feedback_zip(
    platform: str, pages: Iterable[tuple[SubmissionResult, bytes]], roster: Roster | None = None
) -> tuple[bytes, tuple[str, ...]]:
    """Make the zip of feedback pages with the names of a platform's own download, the same for the same pages.

    Moodle finds a student by the folder's name; Canvas finds student and submission by the two numbers in the name of
    the file that counted. The second result has the students whose names, or files with Canvas, are not the platform's.
    """
    files, left_out = {}, []
    for result, content in pages:
        if name := _name_in_zip(platform, result, roster):
            files[name] = content
        else:
            left_out.append(result.student)
    return zipped(files), tuple(sorted(left_out))


def _name_in_zip(platform: str, result: SubmissionResult, roster: Roster | None) -> str:
    """Return the name of a student's page in a platform's zip; an empty string if the platform would not know it."""
    if platform == "canvas":
        name = canvas_name(result.file)
        return f"{name}.html" if name else ""
    numbers = _numbers(platform, result, roster)
    name = moodle_name(result.file) or (result.student if _LAST_NUMBER.search(result.student) else "")
    if not name and len(numbers) == 1:
        name = f"{result.student}_{min(numbers)}"
    return f"{name}_assignsubmission_file_/feedback.html" if name else ""
