"""Commands about a whole class: what they write follows course.toml as it is now."""

import csv

import pytest
from typer.testing import CliRunner

from nao_course import cli
from nao_course.homework import REQUEST
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.commands import classes, exporting, marking
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.late import LatePolicy
from nao_course.instructor.reports import feedback
from tests.pages import Page, answer, exercise, result
from tests.toy import chain

LESSON = chain.LESSON


@pytest.fixture
def course(tmp_path, monkeypatch, secret):
    """Make a course in the working folder, whose lesson was due."""
    made = chain.make_course(tmp_path / "course")
    (made.root / "solutions" / f"{LESSON}.md").touch()
    with (made.root / "course.toml").open("a") as file:
        file.write(f"[deadlines]\n{LESSON} = 2026-11-20T23:59:00+01:00\n[late]\nper_day = 0.25\n")
    monkeypatch.chdir(made.root)
    return made


@pytest.fixture
def grades(course, tmp_path):
    """Return a folder of grades: Ada was a day late, Ben was in time, and Canvas calls Eve late."""
    folder = tmp_path / "grades"
    with Journal(folder) as journal:
        for student, changed in {
            "ada": {"handed_in": "2026-11-21 12:00+00:00"},
            "ben": {"handed_in": "2026-11-20 12:00+00:00"},
            "eve": {"late": True},
        }.items():
            journal.keep(result(student, exercise(points=4.0, earned=4.0), lesson=LESSON, **changed))
    return folder


def page_of(grades, student):
    path = grades / "feedback" / safe_name(student) / f"{LESSON}.html"
    return Page(path.read_text("utf-8")).text


def table_of(grades):
    list(exporting.export(grades, "csv"))
    with (grades / "exports" / "grades.csv").open(encoding="utf-8-sig") as file:
        return {row["student"]: row for row in csv.DictReader(file)}


def test_pages_report_and_export_tell_what_a_late_submission_costs(grades):
    list(classes.report(grades))
    ada = page_of(grades, "ada")
    assert "3 of 4 points" in ada and "The deadline was 2026-11-20 23:59+01:00." in ada
    assert "You handed in at 2026-11-21 13:00+01:00" in ada and "25 % of your points: 1 point." in ada
    assert "Deadline" not in page_of(grades, "ben")
    assert "4 of 4 points" in page_of(grades, "eve") and "nothing was deducted" in page_of(grades, "eve")
    text = Page((grades / "report.html").read_text("utf-8")).text
    assert "ada 2026-11-21 12:00+00:00 yes 1" in text
    assert "eve yes nothing: only the platform says that it is late" in text
    rows = table_of(grades)
    assert [rows["ada"][f"{LESSON} {name}"] for name in ("points", "late", "deducted")] == ["3", "yes", "1"]
    assert "not by how much" in rows["eve"][f"{LESSON} notes"]


FAILING = {"one score": (LatePolicy, "lateness"), "one page": (feedback, "feedback_page")}


@pytest.mark.parametrize("failing", FAILING)
@pytest.mark.parametrize("command", ["report", "export --format csv", "export --format moodle"])
def test_work_that_fails_is_listed_and_all_other_work_is_done(
    grades, tmp_path, monkeypatch, failing, command
):
    owner, name = FAILING[failing]
    whole = getattr(owner, name)

    def fails_for_ben(*words):
        if "ben" in repr(words[-1]):
            raise OverflowError("date value out of range")
        return whole(*words)

    monkeypatch.setattr(owner, name, fails_for_ben)
    monkeypatch.setattr(exporting, "feedback_page", feedback.feedback_page)
    sheet = tmp_path / "sheet.csv"
    sheet.write_text("Identifier,Full name,Grade,Maximum Grade\n", "utf-8")
    first, *more = command.split()
    is_concerned = failing == "one score" or "csv" not in command
    sheets = ["--sheet", sheet] if "moodle" in command else []
    said = run(first, grades, *more, *sheets, status=is_concerned)
    assert ("OverflowError: date value out of range" in said) == is_concerned
    if command == "report":
        assert all(page_of(grades, student) for student in ("ada", "eve"))
    elif "csv" in command:
        rows = (grades / "exports" / "grades.csv").read_text("utf-8-sig").splitlines()
        assert [row.split(",")[0] for row in rows[1:]] == ["ada", *(["ben"] * (not is_concerned)), "eve"]


def test_the_report_names_submissions_without_a_time_where_there_is_a_deadline(grades):
    assert not [line for line in classes.report(grades) if "no time" in line]
    with Journal(grades) as journal:
        journal.keep(result("fay", exercise(), lesson=LESSON))
    (line,) = [line for line in classes.report(grades) if "no time" in line]
    assert line.startswith(f"{LESSON} has a deadline, and 1 of 4 submissions has no time: fay.")


def test_an_extension_stands_on_the_page_and_a_misspelt_name_is_reported(course, grades, tmp_path):
    with (course.root / "course.toml").open("a") as file:
        file.write(
            f"[extensions]\nada.{LESSON} = 2026-11-25T12:00:00+01:00\nbenn.{LESSON} = 2026-11-25T12:00:00Z\n"
        )
    said = list(classes.report(grades))
    assert "course.toml: extensions: 'benn' has no result; is it 'ben'?" in said
    (worlds := tmp_path / "worlds.csv").write_text("student,world\nada,x\nbenn,y\n")
    said = list(marking.marks(grades, None, worlds=worlds))
    assert [line for line in said if "worlds" in line] == ["worlds.csv: 'benn' has no result; is it 'ben'?"]
    assert "Your deadline was extended to 2026-11-25 12:00+01:00." in page_of(grades, "ada")
    assert "4 of 4 points" in page_of(grades, "ada") and table_of(grades)["ada"][f"{LESSON} deducted"] == ""


def test_a_deadline_does_not_make_anything_be_graded_again(course):
    before = prepare(course, LESSON, chain.SECRET).hash
    with (course.root / "course.toml").open("a") as file:
        file.write("grace_hours = 5\n")
    assert prepare(load_course(course.root), LESSON, chain.SECRET).hash == before


def test_a_comment_is_written_once_and_stands_on_the_pages_of_its_kind(course, tmp_path):
    folder, grades = tmp_path / "in", tmp_path / "grades"
    chain.hand_in(folder, "ada", chain.notebook({"double": chain.MISTAKES["double"]}))
    wrong = exercise("wrong", name="double", mistake="slip")
    with Journal(grades) as journal:
        journal.began(folder)
        for student in ("ada", "ben"):
            journal.keep(result(student, wrong, lesson=LESSON))
    said = run("marks", grades, "--comments")
    assert "1 kind" in said and "2 wrong answers" in said
    path = grades / "comments" / f"{LESSON}_double.csv"
    page = Page(path.with_suffix(".html").read_text("utf-8")).text
    assert "return 3 * x" in page and "ben The code was not found" in page
    path.write_text(path.read_text("utf-8-sig").rstrip() + "Not three times.\n", "utf-8")
    assert "1 comment new or changed, on 2 feedback pages" in run("marks", grades, path)
    assert all("Not three times." in page_of(grades, student) for student in ("ada", "ben"))
    run("marks", grades, "--comments", "--anonymous")
    assert "ada" not in Page(path.with_suffix(".html").read_text("utf-8")).text


def test_questions_for_a_talk_are_about_what_each_student_handed_in(course, tmp_path):
    folder, grades = tmp_path / "in", tmp_path / "grades"
    chain.hand_in(folder, "ada", chain.notebook({"double": "def double(x):\n    return x + x  # my own"}))
    with Journal(grades) as journal:
        journal.began(folder)
        for student in ("ada", "ben"):
            journal.keep(result(student, exercise(name="double"), answer(text="I see."), lesson=LESSON))
    said = run("oral", grades)
    assert "ada: 2 questions" in said and "ben: no notebook that can be read is in the folders" in said
    page = Page((grades / "oral" / f"{LESSON}.html").read_text("utf-8")).text
    assert (
        "return x + x # my own The marked line becomes return x - x" in page and "You wrote: I see." in page
    )
    assert f"{LESSON}_ada.html" in run("oral", grades, "--student", "ADA", "--lesson", LESSON)
    assert "has no result of 'eve'" in run("oral", grades, "--student", "eve", status=1)
    assert "no lesson '07' was graded" in run("oral", grades, "--lesson", "07", status=1)


def run(*words, status=0):
    done = CliRunner().invoke(cli.app, [str(word) for word in words])
    assert done.exit_code == status, done.output
    return done.output


def ask(folder, student, text):
    path = folder / student / REQUEST
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, "utf-8")


def test_a_request_is_open_until_a_person_answers_it_on_the_page(grades, tmp_path):
    folder = tmp_path / "in"
    ask(folder, "ada", "rgb_to_hsl: red has hue 0 or 360.")
    said = run("requests", grades, folder)
    assert "1 open request" in said and f"ada, {LESSON}, rgb_to_hsl: red has hue 0 or 360." in said
    assert "red has hue 0 or 360. A person has still to answer." in page_of(grades, "ada")
    run("regrade", grades, "--student", "ada", "--keep", "rgb_to_hsl", "--reason", "The task says 0.")
    assert "Answer: The task says 0." in page_of(grades, "ada")
    assert "0 open requests" in run("requests", grades, folder), "the same file again is not a new request"
    ask(folder, "ada", "rgb_to_hsl: But page 3 says 360.")
    assert "1 open request" in run("requests", grades, folder)
    run("regrade", grades, "--student", "ada", "--set", "rgb_to_hsl=3", "--reason", "True.")
    page = page_of(grades, "ada")
    assert (
        "Answer: True." in page and "3 of 4 points" in page and "0 open requests" in run("requests", grades)
    )


def test_a_changed_request_replaces_the_open_one_and_an_unreadable_one_stays(grades, tmp_path):
    ask(tmp_path / "in", "ada", "rgb_to_hsl: first\nrgb_to_hs: second")
    said = run("requests", grades, tmp_path / "in", status=1)
    assert "NOT READ: ada: 'rgb_to_hs: second' (is it rgb_to_hsl?)" in said and "1 open request:" in said
    assert "'rgb_to_hs: second'" in page_of(grades, "ada") and "could not be read" in page_of(grades, "ada")
    ask(tmp_path / "in", "ada", "RGB_TO_HSL: second")
    said = run("requests", grades, tmp_path / "in")
    assert "1 open request:" in said and "first" not in said
    page = page_of(grades, "ada")
    assert "second A person has still to answer." in page and "could not be read" not in page


def test_an_answer_needs_a_request_and_a_reason(grades):
    keep = ["regrade", grades, "--student", "ada", "--keep", "rgb_to_hsl"]
    assert "say why with --reason" in run(*keep, status=1)
    said = run(*keep, "--reason", "No.", status=1)
    assert "there is no open request of 'ada' about 'rgb_to_hsl'" in said


def test_status_prints_what_waits_and_writes_the_page(grades):
    said = run("status", grades)
    assert "handed in" in said and "3" in said and "Not exported: " in said
    text = Page((grades / "status.html").read_text("utf-8")).text
    assert "Handed in, 3: ada, ben, eve" in text and "ada: 1 day" in text
    run("export", grades, "--format", "csv")
    assert "Not exported" not in run("status", grades)
    assert "there is no journal" in run("status", grades / "none", status=1)
