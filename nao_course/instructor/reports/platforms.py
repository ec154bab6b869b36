"""Export to platforms: fill in the platform's own sheet, and name feedback files as the platform expects."""

import csv
import io
import re
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from nao_course._internal.tables import (
    NAMES_OF_MOODLE,
    TableError,
    plain_number,
    read_rows,
    refuse_doubled_columns,
    refuse_doubled_numbers,
)
from nao_course.homework import zipped
from nao_course.instructor.collecting.layouts import canvas_name, moodle_name, person_in
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.collecting.sheets import COLUMNS
from nao_course.instructor.gradebook.records import SubmissionResult
from nao_course.instructor.gradebook.scores import Score
from nao_course.instructor.reports.html import number

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


_UNIVERSITYS = ("orgdefinedid", "username")  # columns by which Brightspace finds students
MAXIMA = "points"  # a cell in the row with the maxima, where a sheet has such a row


@dataclass(frozen=True)
class _Form:
    """A platform's sheet in which students stand with a login, e-mail address or number of the university.

    `points` fits the header of columns with points, and `maximum` the maximum in it. With `only_points`, the platform
    takes nothing but the columns that identify students, and the points. `marks` are cells to be set in each row that
    gets points, by column, and `others` are cells of rows that belong to nobody.
    """

    points: str
    maximum: str = ""
    only_points: bool = False
    marks: Mapping[str, str] = field(default_factory=dict)
    others: tuple[str, ...] = ()


_FORMS = {
    "brightspace": _Form(
        r".+ points grade\b.*", r"maxpoints:\s*([\d.,]+)", True, {"End-of-Line Indicator": "#"}
    ),
    "blackboard": _Form(r".+\[total pts: .*", r"\[total pts: (?:up to )?([\d.,]+)"),
    "ilias": _Form("mark", marks={"update": "1"}),
    "google": _Form(r"(?!(?:last|first) name|email address).+", others=("date", MAXIMA, "class average")),
}
PLATFORMS = ("moodle", "canvas", *_FORMS)
NAMES = {each: each.title() for each in PLATFORMS} | {"ilias": "ILIAS", "google": "Google Classroom"}


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
    """Where the students' numbers, the points and the maxima are; Canvas has the maxima in a row.

    `keys` are columns with logins, addresses and numbers of the university, for platforms with a `_Form`.
    """

    number: int
    points: int
    maximum: int | None
    keys: tuple[int, ...] = ()


def fill_sheet(
    platform: str,
    sheet: Path,
    made: Iterable[Score],
    column: str = "",
    *,
    roster: Roster | None = None,
    scale: bool = False,
) -> FilledSheet:
    """Write points of one lesson into a platform's own sheet of grades, and nothing else.

    A student is found by the number that Moodle or Canvas put into the file's name or that the roster has, and on
    other platforms by what the roster knows of the students. `column` is the column's name, or how it begins; it may be
    empty if there is only one for points. With `scale`, points are scaled to the platform's maximum. Raise a TableError
    if it is not such a sheet, if a student or a column that matters is there twice, if no column is given, or if its
    maximum is not the lesson's and `scale` is false.
    """
    rows = read_rows(sheet)
    if not rows:
        raise TableError(f"{sheet.name} is empty")
    header = rows[0]
    columns = _columns(platform, sheet.name, header, column)
    rows = [row + [""] * (len(header) - len(row)) for row in rows]
    made = list(made)
    roster = roster or Roster.of(each.result.student for each in made)
    worth = max((each.points for each in made), default=0.0)
    maximum_of = _maxima(platform, rows, columns, sheet.name)
    scores = defaultdict[str, list[Score]](list)
    for score in made:
        for its in _numbers(platform, score.result, roster):
            scores[its].append(score)
    points = {its: found[0] for its, found in scores.items() if len(found) == 1}
    students = _students(platform, rows, columns, roster)
    refuse_doubled_numbers(sheet.name, ((at + 1, its) for at, its in students.items() if its))
    filled, left = set[int](), []
    name_at = next((at for at, name in enumerate(header) if name.strip().casefold() in NAMES_OF_MOODLE), 0)
    for at, its in students.items():
        row = rows[at]
        if its in points:
            maximum, earned = maximum_of(row), points[its].earned
            if maximum and abs(_value(maximum) - worth) > 0.005:
                if not scale:
                    raise TableError(_other_maximum(platform, sheet.name, maximum, made[0], worth))
                earned *= _value(maximum) / worth if worth else 0.0
            row[columns.points] = number(earned).replace(".", "," if "," in maximum else ".")
            filled.add(at)
        else:
            left.append(
                (columns.keys and row[columns.number].strip()) or row[name_at].strip() or row[0].strip()
            )
    in_row = {points[its].result.student for its in students.values() if its in points}
    without = sorted(each.result.student for each in made if each.result.student not in in_row)
    if form := _FORMS.get(platform):
        rows = _as_taken(form, rows, columns, filled)
    text = io.StringIO()
    csv.writer(text, lineterminator="\r\n").writerows(rows)
    return FilledSheet(text.getvalue().encode("utf-8-sig"), len(filled), tuple(without), tuple(left))


def _students(
    platform: str, rows: Sequence[Sequence[str]], columns: _Columns, roster: Roster
) -> dict[int, str]:
    """Return what `_numbers` has of each student, by the student's row; empty where the roster knows nobody."""
    if not columns.keys:
        return {
            at: found[1]
            for at, row in enumerate(rows)
            if at
            and (found := re.fullmatch(r"\D*(\d+)", row[columns.number].strip()))
            and not row[0].strip().casefold().startswith((POSSIBLE.casefold(), _TEST_STUDENT))
        }
    students = dict[int, str]()
    names = [each.strip().casefold() for each in rows[0]]
    parts = [
        at for kind in ("first name", "last name") for at, name in enumerate(names) if name in COLUMNS[kind]
    ]
    for at, row in enumerate(rows[1:], start=1):
        words = [row[key].strip().removeprefix("#") for key in columns.keys]
        words.append(" ".join(row[part].strip() for part in parts).strip())
        if any(words) and not _has_cell(row, _FORMS[platform].others):
            students[at] = next((student for word in words if word and (student := roster.meant(word))), "")
    return students


def _has_cell(row: Iterable[str], cells: Collection[str]) -> bool:
    return any(each.strip().casefold() in cells for each in row)


def _as_taken(
    form: _Form, rows: Sequence[list[str]], columns: _Columns, filled: Collection[int]
) -> list[list[str]]:
    """Return the rows of a sheet as the platform takes them back."""
    header = list(rows[0])
    names = [each.strip().casefold() for each in header]
    for name in form.marks:
        if name.casefold() not in names:
            header.append(name)
            names.append(name.casefold())
    kept = [
        at
        for at, name in enumerate(names)
        if not form.only_points
        or at == columns.points
        or name in (*_UNIVERSITYS, *map(str.casefold, form.marks))
    ]
    made = [header]
    for at, row in enumerate(rows[1:], start=1):
        whole = row + [""] * (len(header) - len(row))
        for name, mark in form.marks.items() if at in filled else ():
            whole[names.index(name.casefold())] = mark
        if at in filled or not form.only_points:
            made.append(whole)
    return [[row[at] for at in kept] for row in made]


def _other_maximum(platform: str, file: str, maximum: str, some: Score, worth: float) -> str:
    """Return the message for a platform's maximum that is not the lesson's."""
    return (
        f"{file}: the maximum in {NAMES[platform]} is {number(_value(maximum))} points, and {some.result.lesson} "
        f"is worth {number(worth)}. Set the maximum in {NAMES[platform]} to {number(worth)} and download the sheet "
        "again, or scale the points with --scale"
    )


def _maxima(
    platform: str, rows: Sequence[Sequence[str]], columns: _Columns, file: str
) -> Callable[[Sequence[str]], str]:
    """Return a function that finds the maximum for a row, as it is written in the sheet; empty if it has none."""
    if form := _FORMS.get(platform):
        head = rows[0][columns.points]
        found = re.search(form.maximum, head, re.IGNORECASE) if form.maximum else None
        cells = [row[columns.points] for row in rows if _has_cell(row, (MAXIMA,)) and form.others]
        said = found[1] if found else next((cell for cell in cells if _value(cell) > 0), "")
        return lambda _: said

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
    if form := _FORMS.get(platform):
        return _columns_of(form, platform, file, header, names, wanted)
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
    at = _column(file, header, names, wanted)
    return _Columns(names.index(key.casefold()), at, names.index(maximum.casefold()) if maximum else None)


def _columns_of(
    form: _Form, platform: str, file: str, header: Sequence[str], names: Sequence[str], wanted: str
) -> _Columns:
    """Return the columns of a sheet with a form."""
    known = {name for kind in ("student", "login", "email", "aliases") for name in COLUMNS[kind]}
    keys = tuple(at for at, name in enumerate(names) if name in known)
    points = [at for at, name in enumerate(names) if at not in keys and re.fullmatch(form.points, name)]
    if not keys or not points:
        what = "for points" if keys else "with logins, e-mail addresses or numbers of the students"
        raise TableError(
            f"{file} is not {NAMES[platform]}'s sheet of grades: it has no column {what}. It has "
            f"{', '.join(header)[:500]}"
        )
    if not wanted and len(points) > 1:
        raise TableError(f"say which column the points go to: --column {header[points[0]]!r}")
    refuse_doubled_columns(file, names, [names[at] for at in keys])
    return _Columns(keys[0], _column(file, header, names, wanted) if wanted else points[0], None, keys)


def _column(file: str, header: Sequence[str], names: Sequence[str], wanted: str) -> int:
    """Return the only column with the wanted name, or whose name begins with it."""
    fits = [at for at, name in enumerate(names) if name == wanted.strip().casefold()]
    fits = fits or [at for at, name in enumerate(names) if name.startswith(wanted.strip().casefold())]
    if len(fits) != 1:
        raise TableError(
            f"{file} has {len(fits) or 'no'} columns that begin with {wanted!r}; it has {', '.join(header)[:500]}"
        )
    return fits[0]


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
    """Return the numbers of a student on a platform: in the file's name, in the roster, or in the student's name.

    On a platform with a form, that is the student's name alone.
    """
    if platform in _FORMS:
        return {result.student}
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
