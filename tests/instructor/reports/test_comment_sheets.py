"""Comments on kinds of wrong answers: each reaches the students whose answer fails that way, and nobody else."""

import csv
from dataclasses import replace

import pytest

from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.scores import all_scores
from nao_course.instructor.reports.comment_sheets import (
    HEADER,
    CommentsError,
    is_comment_sheet,
    read_comments,
    write_comment_sheets,
    wrong_answers,
)
from nao_course.instructor.reports.feedback import feedback_page
from nao_course.instructor.reports.marking_sheets import HEADER as MARKS
from nao_course.instructor.reports.spreadsheets import table
from tests.pages import HOSTILE, Page, exercise, result

LESSON, NAMED = "01_hsl_filtering", "rgb_to_hsl"
CLASS = {
    "ada": exercise("wrong", mistake="half degrees", hint="Twice as much."),
    "ben": exercise("wrong", mistake="half degrees", hint="Twice as much."),
    "eve": exercise("raised", text="IndexError: out of range"),
    "fay": exercise("not attempted"),
    "zoe": exercise("right"),
}


@pytest.fixture
def journal(tmp_path):
    with Journal(tmp_path) as journal:
        for student, each in CLASS.items():
            journal.keep(result(student, each))
        yield journal


def write(journal, code=lambda result, name: f"def {name}(): # of {result.student}", name_of=str):
    ((path, kinds, answers),) = write_comment_sheets(journal, journal.path.parent / "comments", code, name_of)
    return path, kinds, answers


def rows_of(path):
    with path.open(encoding="utf-8-sig") as file:
        return list(csv.DictReader(file))


def fill_in(path, *comments):
    rows = rows_of(path)
    for row, comment in zip(rows, comments, strict=True):
        row["comment"] = comment
    path.write_bytes(table([HEADER, *([row[name] for name in HEADER] for row in rows)]))
    return path


def pages(journal):
    return {each.result.student: Page(feedback_page(each)).text for each in all_scores(journal)}


def test_wrong_answers_of_one_kind_stand_together_and_the_page_shows_each_students_code(journal):
    found = wrong_answers([result(student, each) for student, each in CLASS.items()])
    assert [(kind[2], [each.student for each, _ in answers]) for kind, answers in found.items()] == [
        ("mistake: half degrees", ["ada", "ben"]),
        ("raised: IndexError: out of range", ["eve"]),
    ]
    path, kinds, answers = write(journal)
    assert (kinds, answers) == (2, 3)
    text = Page(path.with_suffix(".html").read_text("utf-8")).text
    assert "mistake: half degrees (2 students) The check says: Twice as much." in text
    assert "# of ada" in text and "# of eve" in text and "# of zoe" not in text and "# of fay" not in text


def test_a_comment_reaches_all_of_its_kind_and_nobody_else_while_the_check_says_the_same(journal):
    def commented():
        return {student for student, text in pages(journal).items() if "Look at the hue." in text}

    path, _, _ = write(journal)
    assert is_comment_sheet(path) and len(read_comments(journal, fill_in(path, "Look at the hue.", ""))) == 1
    journal.keep(result("tom", CLASS["ada"]))
    assert commented() == {"ada", "ben", "tom"}, "also those who hand in later"
    for student in ("ada", "ben", "tom"):
        journal.keep(result(student, replace(CLASS["ada"], hint="Half as much.")))
    assert not commented()
    path, _, _ = write(journal)
    assert rows_of(path)[0]["comment"] == ""
    assert "Look at the hue." in path.with_suffix(".html").read_text("utf-8")
    read_comments(journal, fill_in(path, "Look at the hue.", ""))
    assert commented() == {"ada", "ben", "tom"}


def test_what_was_read_in_stands_in_the_next_table_and_can_be_taken_back(journal):
    path, _, _ = write(journal)
    read_comments(journal, fill_in(path, "=1+1", "Count from 0."))
    path, _, _ = write(journal)
    assert read_comments(journal, path) == []
    read_comments(journal, fill_in(path, "", "Count from 0."))
    assert [each.text for each in journal.comments().values()] == ["Count from 0."]


def test_unread_comments_are_not_overwritten_and_a_row_of_no_known_kind_is_named(journal, tmp_path):
    path, _, _ = write(journal)
    fill_in(path, "Look at the hue.", "")
    with pytest.raises(CommentsError, match="row 2, has a comment that was not read in"):
        write(journal)
    assert rows_of(path)[0]["comment"] == "Look at the hue."
    path.write_text(path.read_text("utf-8-sig").replace("half degrees", "half turns"), "utf-8")
    with pytest.raises(CommentsError, match="nothing was read in\nrow 2: 'rgb_to_hsl'.*no wrong answer of"):
        read_comments(journal, path)
    assert journal.comments() == {}
    path = tmp_path / "marks.csv"
    path.write_bytes(table([MARKS]))
    assert not is_comment_sheet(path) and not is_comment_sheet(tmp_path / "none.csv")


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_answers_stay_text_and_can_be_commented_on(tmp_path, text):
    with Journal(tmp_path / "grades") as journal:
        in_file = text.encode("utf-8", "replace").decode()  # as it comes out of the grader
        journal.keep(result("eve", exercise("raised", text=in_file, line=in_file, hint=in_file)))
        path, _, _ = write(journal, lambda result, name: text, lambda student: text)
        assert Page(path.with_suffix(".html").read_text("utf-8")).offences() == []
        read_comments(journal, fill_in(path, "Read the message."))
        (page,) = (Page(feedback_page(each)) for each in all_scores(journal))
        assert "Read the message." in page.text and page.offences() == []
