"""CSV that spreadsheets open without harm, and that is read back whatever a spreadsheet made of it."""

from __future__ import annotations

import codecs
import csv
import io
import re
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from nao_course._internal.text_encodings import NotTextError, decode_text
from nao_course.instructor.reports.html import visible

LARGEST = 64 * 2**20  # bytes of a table that is read
LONGEST = 30_000  # characters of a cell; spreadsheets hold 32,767
_SEPARATORS = (",", ";", "\t", "|")
# Where a cell begins, also in a sheet that is split at a separator or line end that this one does not split at.
# Only commas are safe: what holds one stands in quotation marks.
_BEGINS = r"(?:\A|(?<=[;|\t\r\n]))"
_FORMULA = r"'*[^\S;|\t\r\n]*[=+\-@\uff1d\uff0b\uff0d\uff20]"
_BARE = re.compile(rf"{_BEGINS}(?={_FORMULA})|\A(?='*[\t\r])")
_ESCAPED = re.compile(rf"{_BEGINS}'(?={_FORMULA})|\A'(?='*[\t\r])")


class TableError(ValueError):
    """A table that is not understood; its message says where and what to do."""


@dataclass(frozen=True)
class Row:
    """A row of a table that was read.

    Parameters
    ----------
    number : int
        As the spreadsheet counts: the header is row 1.
    cells : mapping of str to str
        By the header's names, as they were before `escape_formula`.
    """

    number: int
    cells: Mapping[str, str]

    def __getitem__(self, name: str) -> str:
        """Return a cell."""
        return self.cells[name]


def escape_formula(text: str) -> str:
    """Put an apostrophe before all that a spreadsheet would run as a formula, whatever it splits at.

    `unescape_formula` takes them away again.

    Examples
    --------
    >>> escape_formula("=1+1"), escape_formula("Ada"), unescape_formula(escape_formula("'=1+1"))
    ("'=1+1", 'Ada', "'=1+1")
    >>> escape_formula("x;=1+1")
    "x;'=1+1"
    """
    return _BARE.sub("'", text)


def unescape_formula(cell: str) -> str:
    """Take away the apostrophes that `escape_formula` put there."""
    return _ESCAPED.sub("", cell)


def table(rows: Iterable[Sequence[str | float | None]]) -> bytes:
    """Make a CSV file (RFC 4180), in UTF-8 with the byte order mark that spreadsheets know it by.

    Parameters
    ----------
    rows : iterable of sequence
        Text that would be a formula is escaped; numbers are written as they are, None as an empty cell.
    """
    text = io.StringIO()
    csv.writer(text, lineterminator="\r\n").writerows([[_cell(each) for each in row] for row in rows])
    return codecs.BOM_UTF8 + text.getvalue().encode()


def _cell(value: str | float | None) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return escape_formula(fitting(value))
    return f"{round(float(value), 6) + 0.0:.6f}".rstrip("0").rstrip(".")


def fitting(text: str) -> str:
    """Return text for a cell, without invisible characters and cut to the maximum length."""
    text = visible(text)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}\n… (cut here: a cell holds no more)"


def read_rows(path: Path) -> list[list[str]]:
    """Read a CSV file of another program's, whatever it holds, with the separator that makes most of its first row.

    Returns
    -------
    list of list of str
        All rows but empty ones, cells as they are.

    Raises
    ------
    TableError
        If it is no table.
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
    """Read a CSV file that a spreadsheet may have saved in its own way.

    Parameters
    ----------
    path : Path
        In UTF-8, UTF-16 or Windows' encoding; separated by commas, semicolons or tabs.
    header : sequence of str
        Names of the columns, in any order.
    more : sequence of str
        Names of columns that may be missing; their cells are empty then.

    Returns
    -------
    list of Row
        All rows that are not empty; names in them are composed (NFC), as they are in the gradebook.

    Raises
    ------
    TableError
        If it is no table, or its header is another one.
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
    """Yield rows by the names of the header; extra cells are refused unless they are empty."""
    names = [_name(cell) for cell in rows[0]]
    extra = sorted({name for name in names if name and (names.count(name) > 1 or name not in header)})
    if extra:
        raise TableError(
            f"{file}, row 1: {', '.join(map(repr, extra))} does not belong there, or stands twice"
        )
    for number, cells in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in cells):
            continue
        filled = dict.fromkeys(header, "")
        for at, cell in enumerate(cells):
            name = names[at] if at < len(names) else ""
            if name:
                filled[name] = unescape_formula(cell)
            elif cell.strip():
                where = f"{file}, row {number}: {cell[:40]!r} stands in a column without a name"
                raise TableError(f"{where}. Is a quotation mark missing?")
        yield Row(number, filled)
