"""CSV that spreadsheets open without harm; `tables` reads it back whatever a spreadsheet made of it."""

import codecs
import csv
import io
from collections.abc import Iterable, Sequence

from nao_course._internal.tables import escape_formula
from nao_course.instructor.reports.html import visible

LONGEST = 30_000  # characters of a cell; spreadsheets hold 32,767


def table(rows: Iterable[Sequence[str | float | None]]) -> bytes:
    """Make a CSV file (RFC 4180), in UTF-8 with the byte order mark that spreadsheets know it by.

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
