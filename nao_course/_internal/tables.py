"""One reader of people's tables: class lists, platforms' sheets and marks, whatever a spreadsheet made of them."""

from __future__ import annotations

import csv
import io
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from nao_course._internal.text_encodings import NotTextError, decode_text

LARGEST = 64 * 2**20  # bytes of a table that is read
_SEPARATORS = (",", ";", "\t", "|")
STUDENT = "student"  # the column of a class list
# Names of the columns with the number and the name of a student in Moodle's grading worksheet, in several languages
NUMBERS_OF_MOODLE = ("identifier", "id", "identifiant", "identificador")
NAMES_OF_MOODLE = (
    *("full name", "vollständiger name", "nom complet", "nombre completo", "nome completo", "volledige naam"),
)
# Headings that are not a student's name, so that a list with one of them lacks the column "student"
_HEADINGS = {
    *NUMBERS_OF_MOODLE,
    *NAMES_OF_MOODLE,
    "name",
    "names",
    "username",
    "user",
    "login",
    "email",
    "e-mail",
    "nom",
    "nombre",
}
_NOBODY = ("points possible", "student, test", "test student")  # rows of Canvas's gradebook
_SHORTENED = re.compile(r"\d+(?:[.,]\d+)?E\+?\d+", re.IGNORECASE | re.ASCII)
_NUMBER = re.compile(r"\d{1,6}(?:[.,]\d{0,6})?|[.,]\d{1,6}", re.ASCII)
_GROUPED = re.compile(r"[1-9]\d{0,2}[.,]\d{3}", re.ASCII)
# Start of a cell under any separator or line end that a spreadsheet may use.
# Only commas are safe: what holds one stands in quotation marks.
_BEGINS = r"(?:\A|(?<=[;|\t\r\n]))"
_FORMULA = r"'*[^\S;|\t\r\n]*[=+\-@\uff1d\uff0b\uff0d\uff20]"
_BARE = re.compile(rf"{_BEGINS}(?={_FORMULA})|\A(?='*[\t\r])")
_ESCAPED = re.compile(rf"{_BEGINS}'(?={_FORMULA})|\A'(?='*[\t\r])")


class TableError(ValueError):
    """A table that is not understood; its message says where and what to do."""


@dataclass(frozen=True)
class Row:
    """A row of a table, numbered as in a spreadsheet, from 1 for the header; cells are as before `escape_formula`."""

    number: int
    cells: Mapping[str, str]

    def __getitem__(self, name: str) -> str:
        """Return a cell."""
        return self.cells[name]


def escape_formula(text: str) -> str:
    """Put an apostrophe before all that a spreadsheet would run as a formula, whatever it splits at.

    `unescape_formula` takes them away again.

    >>> escape_formula("=1+1"), escape_formula("Ada"), unescape_formula(escape_formula("'=1+1"))
    ("'=1+1", 'Ada', "'=1+1")
    >>> escape_formula("x;=1+1")
    "x;'=1+1"
    """
    return _BARE.sub("'", text)


def unescape_formula(cell: str) -> str:
    """Take away the apostrophes that `escape_formula` put there."""
    return _ESCAPED.sub("", cell)


@dataclass(frozen=True)
class Person:
    """A student in a class list, with all cells of the row, such as the e-mail address.

    `number` is the platform's, "moodle" or "canvas"; both are empty in a list that is not a platform's.
    """

    name: str
    number: str = ""
    platform: str = ""
    cells: tuple[str, ...] = ()


def read_people(path: Path) -> list[Person]:
    """Read a class list: one name in each line, a table with a column "student", or Moodle's or Canvas's sheet.

    Raise a TableError for a table without these columns, if one of them or a student's number is there twice, or if a
    spreadsheet has shortened a number to "1,00E+03".
    """
    rows = [
        [unicodedata.normalize("NFC", unescape_formula(cell)).strip() for cell in row]
        for row in read_rows(path)
    ]
    if not rows:
        return []
    header = [_name(cell) for cell in rows[0]]
    names, number, platform = header.index(STUDENT) if STUDENT in header else None, None, ""
    if names is not None and {"id", "section"} <= set(header):
        platform, number = "canvas", header.index("id")
    elif names is None and (numbers := [at for at, name in enumerate(header) if name in NUMBERS_OF_MOODLE]):
        full = [at for at, name in enumerate(header) if name in NAMES_OF_MOODLE]
        number = numbers[0]
        names = full[0] if full else None
        platform = "moodle"
    refuse_doubled_columns(path.name, header, (header[at] for at in (names, number) if at is not None))
    if names is None and (len(header) > 1 or header[0] in _HEADINGS):
        raise TableError(
            f"{path.name}, row 1: the columns are {_few(rows[0])}; a class list should have a column {STUDENT!r}, "
            "or one name in each line, or be Moodle's grading worksheet or Canvas's gradebook"
        )
    people, seen = list[Person](), list[tuple[int, str]]()
    for line, row in enumerate(rows[names is not None :], start=1 + (names is not None)):
        at = names or 0
        name = row[at] if at < len(row) else ""
        digits = re.fullmatch(r"\D*(\d+)", row[number]) if number is not None and number < len(row) else None
        if names is None and any(row[1:]):
            raise TableError(
                f"{path.name}, row {line}: {_few(row)} are several cells. Write one name in each line, and put a name "
                f"with a comma into quotation marks; or write a table with a column {STUDENT!r}"
            )
        if not name or (platform and (not digits or _name(name).startswith(_NOBODY))):
            continue
        if _SHORTENED.fullmatch(name):
            raise TableError(
                f"{path.name}, row {line}: {name!r} is a number that a spreadsheet has shortened. "
                "Format the column as text, or export the list again"
            )
        people.append(Person(name, digits[1] if digits else "", platform, tuple(row)))
        seen += [(line, digits[1])] if digits else []
    refuse_doubled_numbers(path.name, seen)
    return people


def refuse_doubled_columns(file: str, names: Sequence[str], wanted: Iterable[str]) -> None:
    """Raise TableError if a table has one of some columns more than once."""
    if twice := [name for name in wanted if names.count(name) > 1]:
        raise TableError(
            f"{file}, row 1: the columns {', '.join(map(repr, twice))} are there twice. Rename or remove all but "
            "one of each"
        )


def refuse_doubled_numbers(file: str, numbers: Iterable[tuple[int, str]]) -> None:
    """Raise TableError if two rows have the number of one student; `numbers` has the row of each number."""
    rows: dict[str, int] = {}
    for row, number in numbers:
        if (first := rows.setdefault(number, row)) != row:
            raise TableError(
                f"{file}, rows {first} and {row}: both have the number {number}, and only one can be the student's. "
                "Remove the other one, or export the table again"
            )


def plain_number(text: str) -> float | None:
    """Return a number with a decimal point or comma; None for other text, and for "1,300", which may be 1.3 or 1300.

    >>> plain_number("1,5"), plain_number("0.125"), plain_number("1,300"), plain_number("1.300,5")
    (1.5, 0.125, None, None)
    """
    text = text.strip()
    if not _NUMBER.fullmatch(text) or _GROUPED.fullmatch(text):
        return None
    return float(text.replace(",", "."))


def read_rows(path: Path) -> list[list[str]]:
    """Read all rows but empty ones of any program's CSV file, with the separator that yields the most header columns.

    Raise a TableError if it is not a table.
    """
    text, separators = _without_hint(_text(path))
    try:
        best = max(separators, key=lambda each: len(_first_row(text, each)))
        return [
            row for row in csv.reader(io.StringIO(text, newline=""), delimiter=best, strict=True) if any(row)
        ]
    except csv.Error as error:
        raise _no_table(path, error) from None


def read_table(path: Path, header: Sequence[str], more: Sequence[str] = ()) -> list[Row]:
    """Read a CSV file that a spreadsheet may have saved in its own way; its columns may have any order.

    It is in UTF-8, UTF-16 or Windows' encoding, separated by commas, semicolons or tabs; columns in `more` may be
    missing. Rows are not empty, and names in them are composed (NFC), as in the gradebook. Raise a TableError if it is
    not a table or has another header.
    """
    text, separators = _without_hint(unicodedata.normalize("NFC", _text(path)))
    separator, first = _separator(text, separators, header)
    if not first:
        raise TableError(f"{path.name} is empty")
    if separator is None:
        raise TableError(
            f"{path.name}, row 1: the columns are {_few(first)}; "
            f"they should be {', '.join(map(repr, header))}. Leave the header as it was written."
        )
    try:
        rows = list(csv.reader(io.StringIO(text, newline=""), delimiter=separator, strict=True))
    except csv.Error as error:
        raise _no_table(path, error) from None
    return list(_rows(path.name, rows, (*header, *more)))


def _no_table(path: Path, error: csv.Error) -> TableError:
    return TableError(f"{path.name} is not a CSV table: {error}. Save it as CSV again.")


def _few(names: Sequence[str]) -> str:
    """Return the first names, shortened: a file that is not a table may have anything in its first row."""
    shown = [repr(name if len(name) <= 30 else name[:30] + "...") for name in names[:8]]
    return ", ".join(shown) + (f" and {len(names) - 8} more" if len(names) > 8 else "")


def _separator(text: str, separators: Sequence[str], header: Sequence[str]) -> tuple[str | None, list[str]]:
    """Return the separator for which the first row is the header, and that row; else None and the best guess."""
    best: list[str] = []
    for separator in separators:
        try:
            first = _first_row(text, separator)
        except csv.Error:
            continue
        if {_name(cell) for cell in first} >= set(header):
            return separator, first
        best = max(best, first, key=len)
    return None, best


def _first_row(text: str, separator: str) -> list[str]:
    """Return the first row of a table, or raise csv.Error."""
    return next(csv.reader(io.StringIO(text, newline=""), delimiter=separator), [])


def _text(path: Path) -> str:
    """Return a file's text."""
    if path.stat().st_size > LARGEST:
        raise TableError(f"{path.name} is larger than {LARGEST // 2**20} MB")
    try:
        return decode_text(path.read_bytes())
    except NotTextError as error:
        raise TableError(f"{path.name}: {error}") from None


def _without_hint(text: str) -> tuple[str, Sequence[str]]:
    """Return the table and its possible separators. Excel's line "sep=;" decides and is removed."""
    named = re.match(r"\"?sep=(.)\"?[ ,;\t]*\r?\n", text, re.IGNORECASE)
    return (text[named.end() :], (named.group(1),)) if named else (text, _SEPARATORS)


def _name(cell: str) -> str:
    return cell.strip().casefold()


def _rows(file: str, rows: Sequence[Sequence[str]], header: Sequence[str]) -> Iterator[Row]:
    """Yield rows by the names of the header, without other columns; cells beyond the header are refused."""
    names = [_name(cell) for cell in rows[0]]
    refuse_doubled_columns(file, names, header)
    for number, cells in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in cells):
            continue
        filled = dict.fromkeys(header, "")
        for at, cell in enumerate(cells):
            name = names[at] if at < len(names) else ""
            if name in filled:
                filled[name] = unescape_formula(cell)
            elif not name and cell.strip():
                where = f"{file}, row {number}: {cell[:40]!r} stands in a column without a name"
                raise TableError(f"{where}. Is a quotation mark missing?")
        yield Row(number, filled)
