"""Class lists are read in any form that people and platforms give them; others are refused by their columns."""

import csv
import io

import pytest

from nao_course._internal.tables import TableError, plain_number, read_people

HEADINGS = {
    "ours": (("Student", "id", "E-Mail"), ("{name}", "{number}", "{name}@x")),
    "moodle": (("Identifier", "Full name", "Grade"), ("Participant {number}", "{name}", "")),
    "German Moodle": (("ID", "Vollständiger Name", "Bewertung"), ("Teilnehmer/in{number}", "{name}", "")),
    "canvas": (("Student", "ID", "Section", "Lesson 01 (7)"), ("{name}", "{number}", "A", "")),
}
NAMES = {"Müller, Jörg": "0012", "=1+1": "345", "0042": "6789"}


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("case", [str, str.upper])
@pytest.mark.parametrize(
    ("separator", "encoding"), [(",", "utf-8"), (";", "cp1252"), ("\t", "utf-16"), ("|", "utf-8-sig")]
)
@pytest.mark.parametrize("kind", HEADINGS)
def test_a_class_list_of_any_form_has_the_same_students(tmp_path, kind, separator, encoding, case, order):
    header, row = HEADINGS[kind]
    rows = [[case(each) for each in header]]
    rows += [[each.format(name=name, number=number) for each in row] for name, number in NAMES.items()]
    if kind == "canvas":
        rows[1:1] = [["    Points Possible", "", "", "15"]]
        rows.append(["Student, Test", "99", "A", ""])
    text = io.StringIO()
    csv.writer(text, delimiter=separator).writerows(each[::order] for each in rows)
    (tmp_path / "class.csv").write_bytes(text.getvalue().encode(encoding))
    people = read_people(tmp_path / "class.csv")
    assert [each.name for each in people] == list(NAMES)
    assert kind == "ours" or [each.number for each in people] == list(NAMES.values())


def test_a_list_without_a_header_has_a_name_in_each_line_and_grouped_numbers_are_none(tmp_path):
    (tmp_path / "names.txt").write_text('ada\n\n  007 \n"Lovelace, Ada"\n', "utf-8")
    assert [each.name for each in read_people(tmp_path / "names.txt")] == ["ada", "007", "Lovelace, Ada"]
    for text in ("1,300", "1.300", "12.000", "1.300,5", "1 300", "1'300", "1e3", "-1", "", "+1"):
        assert plain_number(text) is None
    read = {"1,5": 1.5, "0.125": 0.125, ".5": 0.5, "1300": 1300, "2.": 2.0}
    assert {text: plain_number(text) for text in read} == read


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("name,email\nada,a@x\n", "row 1: the columns are 'name', 'email'"),
        ("Doe, Jane\nRoe, Max\n", "row 1: the columns are 'Doe', 'Jane'"),
        ("ada\nDoe, Jane\n", "row 2: 'Doe', 'Jane' are several cells"),
        ("student,id,Student\nada,1,bob\n", "row 1: the columns 'student' are there twice"),
        ("Identifier,Full name\nUser 7,Ada\nUser 8,Bob\nUser 7,Ada\n", "rows 2 and 4: both have"),
        ("student,id\n1.00E+03,1\n", "row 2: '1.00E\\+03' is a number that a spreadsheet has shortened"),
    ],
)
def test_what_is_not_understood_is_refused_by_row_and_columns(tmp_path, text, said):
    (tmp_path / "class.csv").write_text(text, "utf-8")
    with pytest.raises(TableError, match=f"class.csv, {said}"):
        read_people(tmp_path / "class.csv")
