"""The status page counts what waits for a person, names whom it is about, and says what to do next."""

import os
from dataclasses import replace

import pytest

from nao_course.instructor.collecting.roster import Student
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.late import LatePolicy
from nao_course.instructor.gradebook.records import Override, Request
from nao_course.instructor.reports.exports import last_exports
from nao_course.instructor.reports.status import KINDS, status, status_page, what_to_do
from tests.instructor.gradebook.test_late import DUE
from tests.pages import HOSTILE, Page, answer, exercise, mark, result

LESSON, OTHER = "01_hsl_filtering", "04_homography"


@pytest.fixture
def journal(tmp_path):
    """Return a journal in which something of each kind waits in the lesson, and nothing but an export in the other."""
    with Journal(tmp_path, policy=LatePolicy({LESSON: DUE})) as opened:
        parts = (exercise(points=4.0, earned=4.0, answer="a"), answer())
        timed = {"handed_in": "2026-11-22 12:00+01:00", "submission": "s"}
        for student in ("ada", "ben", "cleo"):
            opened.keep(result(student, *parts, **timed))
        opened.keep(result("dan", exercise("undecided"), answer(text=""), submission="s"))
        opened.keep(result("fay", exercise("undecided"), handed_in="2026-11-20 12:00+01:00", submission="s"))
        opened.override(Override("fay", LESSON, "rgb_to_hsl", 1.0, "x", decided_on="s"))
        opened.keep(result("eve", status="refused", reason="it is empty"))
        opened.know([Student("gil", "Gil", listed=True)])
        opened.mark([mark(2.0, given_by="ben"), mark(1.0, given_by="cleo", is_second=True)])
        opened.mark([mark(1.5, student="ben", text="Old")])
        opened.override(
            Override("ada", LESSON, "rgb_to_hsl", 1.0, "x", decided_on="a", earned=4.0, given_by="ben")
        )
        opened.override(Override("ben", LESSON, "rgb_to_hsl", 1.0, "x", decided_on="old"))
        opened.request([Request("cleo", LESSON, "rgb_to_hsl", "Is this right?")])
        for student in ("ada", "ben", "cleo", "dan", "eve", "fay", "gil"):
            opened.keep(result(student, exercise(), lesson=OTHER, submission="s"))
        yield opened


def test_each_kind_is_counted_and_named(journal):
    first, second = status(journal, {})
    assert {kind: len(lines) for kind, lines in first.lines.items() if kind != "not exported"} == {
        "handed in": 6,
        "not handed in": 1,
        "refused": 1,
        "late": 3,
        "without a time": 2,
        "to decide": 1,
        "to mark": 2,
        "changed since marked": 1,
        "marks that differ": 1,
        "requests": 1,
        "points for an earlier answer": 1,
        "points below the grader's": 1,
    }
    assert first.lines["late"][0] == "ada: 2 days" and first.lines["to decide"] == ["dan, rgb_to_hsl"]
    assert first.lines["to mark"] == ["ben, why_hsl", "cleo, why_hsl"]
    assert first.lines["marks that differ"] == ["ada, why_hsl: 2 by ben, 1 by cleo"]
    assert first.lines["points below the grader's"] == [
        "ada, rgb_to_hsl: 1 by hand by ben, the grader gives 4"
    ]
    assert first.lines["requests"] == ["cleo, rgb_to_hsl: Is this right?"]
    assert {kind for kind in KINDS if second.count(kind)} == {"handed in", "not exported"}
    steps = what_to_do([first, second])
    assert len(steps) == sum(bool(advice) for advice in KINDS.values())
    assert steps[-1].startswith(f"Not exported: {LESSON} (1), {OTHER} (1). Write the grades")


def test_a_lesson_waits_for_an_export_until_one_is_newer_than_its_last_change(journal, tmp_path):
    def waits():
        return [
            each.count("not exported")
            for each in status(journal, last_exports(tmp_path / "exports", lessons))
        ]

    lessons = (LESSON, OTHER)
    assert waits() == [1, 1]
    (tmp_path / "exports").mkdir()
    for name, left in ((f"moodle_{OTHER}.csv", [1, 0]), ("grades.csv", [0, 0])):
        (tmp_path / "exports" / name).touch()
        os.utime(tmp_path / "exports" / name, (2e9, 2e9))
        assert waits() == left
    journal.mark([replace(mark(1.0), time="2099-01-01T00:00:00+00:00")])
    assert waits() == [1, 0]


def test_the_page_shows_all_of_it_and_hostile_words_stay_text(journal):
    text = Page(status_page(status(journal, {}))).text
    assert "to mark 2 marks that differ 1" in text.replace("changed since marked 1 ", "")
    assert "Not handed in, 1: gil" in text and "eve: it is empty" in text
    for hostile in HOSTILE:
        name = hostile.encode("utf-8", "replace").decode()
        journal.keep(result(name, exercise(), answer(), status="refused", reason=name))
    page = Page(status_page(status(journal, {})))
    assert page.offences() == []
    assert "Nothing waits." in Page(status_page([])).text
