"""A platform's own sheet comes back with points in it and nothing else changed; what does not fit is named."""

import csv
import io
import zipfile

import pytest

from nao_course.instructor.gradebook.scores import scores
from nao_course.instructor.reports.platforms import fill_sheet, moodle_feedback
from nao_course.instructor.reports.spreadsheets import TableError
from tests.pages import exercise, result

MOODLE = (
    "Identifier,Full name,Email address,Status,Grade,Maximum Grade,Grade can be changed,Feedback comments\n"
    'Participant 1234567,Ada Lovelace,ada@uni.example,"Submitted, graded",,10.00,Yes,\n'
    "Participant 1234568,Žofie Nováková,zofie@uni.example,Submitted,5.00,10.00,Yes,keep this\n"
    "Participant 12345,Ben,ben@uni.example,No submission,,10.00,Yes,=1+1\n"
)
CANVAS = (
    "Student,ID,SIS User ID,SIS Login ID,Section,Lesson 01 (4711),Lesson 02 (4712),Current Score\n"
    "    Points Possible,,,,,13.00,9.00,(read only)\n"
    '"Lovelace, Ada",1234567,s001,ada,A,,3,10\n'
    '"Student, Test",99,,x,A,,,\n'
    '"Nováková, Žofie",1234568,s002,zofie,A,2,,\n'
)
MADE = scores(
    [
        result("Ada Lovelace_1234567", exercise(points=2.0, earned=1.5)),
        result("Žofie Nováková_1234568", exercise(points=2.0, earned=2.0)),
        result("Eve_777", exercise(points=2.0, earned=1.0)),
        result("without a number", exercise(points=2.0, earned=1.0)),
    ]
)


def rows(table):
    return list(csv.reader(io.StringIO(table.decode("utf-8-sig"), newline="")))


def sheet(tmp_path, text, encoding="utf-8"):
    path = tmp_path / "theirs.csv"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("separator", [",", ";"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_moodles_worksheet_gets_grades_and_keeps_all_else(tmp_path, encoding, separator):
    given = MOODLE if separator == "," else MOODLE.replace(",", ";").replace("d; g", "d, g")
    filled = fill_sheet("moodle", sheet(tmp_path, given, encoding), MADE)
    before, after = rows(MOODLE.encode()), rows(filled.table)
    assert [row[4] for row in after] == ["Grade", "1.5", "2", ""] and filled.filled == 2
    assert [row[:4] + row[5:] for row in after] == [row[:4] + row[5:] for row in before]
    assert filled.without_row == ("Eve_777", "without a number")
    assert filled.without_grade == ("Participant 12345",)


def test_of_two_students_with_one_number_neither_gets_the_others_points(tmp_path):
    both = [
        *MADE,
        *scores([result("Zed_99_assignsubmission_file_x_1234567", exercise(points=2.0, earned=0.0))]),
    ]
    filled = fill_sheet("moodle", sheet(tmp_path, MOODLE), both)
    assert [row[4] for row in rows(filled.table)] == ["Grade", "", "2", ""]
    assert {"Ada Lovelace_1234567", "Zed_99_assignsubmission_file_x_1234567"} <= set(filled.without_row)


def test_canvas_gets_the_column_that_is_named(tmp_path):
    filled = fill_sheet("canvas", sheet(tmp_path, CANVAS), MADE, "lesson 02")
    after = rows(filled.table)
    assert [row[6] for row in after] == ["Lesson 02 (4712)", "9.00", "1.5", "", "2"]
    assert [row[5] for row in after] == ["Lesson 01 (4711)", "13.00", "", "", "2"]
    assert filled.without_grade == () and filled.filled == 2


@pytest.mark.parametrize(
    ("platform", "text", "column", "said"),
    [
        ("moodle", "a,b\n1,2\n", "", "no column 'identifier'"),
        ("canvas", MOODLE, "Grade", "not Canvas's exported gradebook"),
        ("canvas", CANVAS, "", "--column 'Lesson 01 .4711.'"),
        ("canvas", CANVAS, "Lesson", "2 columns that begin with 'Lesson'"),
        ("canvas", CANVAS, "Essay", "no columns that begin with 'Essay'"),
        ("moodle", "", "", "is empty"),
        ("moodle", 'Identifier,Grade\n"open,1\n', "", "is not a CSV table"),
        ("moodle", "Identifier,Grade\n" + "x" * 200_000 + ",1\n", "", "is not a CSV table"),
        ("moodle", "x" * 200_000, "", "is not a CSV table"),
    ],
)
def test_what_is_no_sheet_of_theirs_is_refused(tmp_path, platform, text, column, said):
    with pytest.raises(TableError, match=said):
        fill_sheet(platform, sheet(tmp_path, text), MADE, column)


def test_feedback_lies_in_folders_that_moodle_knows(tmp_path):
    pages = {"Ada Lovelace_1234567": b"<p>good</p>", "eve": b"x"}
    archive, left_out = moodle_feedback(pages)
    with zipfile.ZipFile(io.BytesIO(archive)) as made:
        assert made.namelist() == ["Ada Lovelace_1234567_assignsubmission_file_/feedback.html"]
        assert made.read(made.namelist()[0]) == b"<p>good</p>"
    assert left_out == ("eve",) and moodle_feedback(pages)[0] == archive
