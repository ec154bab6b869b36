"""A table is opened by any spreadsheet without harm, and comes back as it was."""

import csv
import io

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from nao_course._internal import tables
from nao_course._internal.tables import TableError, escape_formula, read_table, unescape_formula
from nao_course.instructor.reports.spreadsheets import table


@settings(max_examples=200, deadline=None)
@given(st.text() | st.text("x'=+-@; |,\t\r\n"))
@example("'=x")
@example(" =x")
@example("'\t")
@example("x;'=1")
def test_escaping_a_formula_can_be_undone(text):
    assert unescape_formula(escape_formula(text)) == text
    assert escape_formula(text)[:1] not in tuple("=+-@\t\r")


@pytest.mark.parametrize("separator", [",", ";", "\t", "|"])
@pytest.mark.parametrize(
    "text", ["x;=cmd|'!A0", "x\t=1", "a|+1", "a\n=1+1", "a\r\n -1", "a; @SUM(1)", ";;=1"]
)
def test_no_cell_is_a_formula_whatever_a_sheet_is_split_at(text, separator):
    made = table([["Ada", text, 1.5], [text, "late, but =1", None]]).decode("utf-8-sig")
    for line in made.splitlines():
        for cell in line.split(separator):
            assert cell.strip(' "')[:1] not in tuple("=+-@") or cell.startswith("'"), cell


def test_a_long_answer_is_cut_with_a_word_and_numbers_keep_six_digits():
    cells = ["y" * 40_000, 8.125, 1 / 3, 66.666_666_7, 10.0, -0.0]
    ((long, *numbers),) = csv.reader(io.StringIO(table([cells]).decode("utf-8-sig")))
    assert len(long) < 32_767 and "cut here" in long
    assert numbers == ["8.125", "0.333333", "66.666667", "10", "0"]


def test_what_was_written_is_read_again_unless_it_is_far_too_large(tmp_path, monkeypatch):
    rows = [("name", "points"), ("=1+1", 1.5), ('a "b", c\nd', None)]
    (tmp_path / "t.csv").write_bytes(table(rows))
    read = read_table(tmp_path / "t.csv", ("name", "points"))
    assert [(row["name"], row["points"]) for row in read] == [("=1+1", "1.5"), ('a "b", c\nd', "")]
    monkeypatch.setattr(tables, "LARGEST", 10)
    with pytest.raises(TableError, match="larger than"):
        read_table(tmp_path / "t.csv", ("name", "points"))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "cp1252"])
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_table_is_read_in_any_encoding_and_with_any_separator(tmp_path, encoding, separator):
    text = separator.join(("name", "points")) + "\r\n" + separator.join(("Zoë", "1")) + "\r\n"
    (tmp_path / "t.csv").write_bytes(text.encode(encoding))
    (row,) = read_table(tmp_path / "t.csv", ("name", "points"))
    assert (row["name"], row["points"], row.number) == ("Zoë", "1", 2)
    assert tables.read_rows(tmp_path / "t.csv") == [["name", "points"], ["Zoë", "1"]]
