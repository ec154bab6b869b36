"""Grades for other systems: what they specify, and nothing that harms."""

import csv
import io
import json
import re
import zipfile

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner

from nao_course import cli
from nao_course.instructor.collecting.roster import Student
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Override
from nao_course.instructor.gradebook.scores import all_scores, score, scores
from nao_course.instructor.reports import exports
from nao_course.instructor.reports.exports import ExportError, csv_table, gradescope_results, write_gradescope
from tests.pages import FOR_ASSISTANTS, HOSTILE, MISTAKE, RUBRIC, answer, exercise, mark, result, results

LESSON = "01_hsl_filtering"


@pytest.fixture
def journal(tmp_path):
    with Journal(tmp_path / "grades") as opened:
        yield opened


def rows_of(made):
    return list(csv.DictReader(io.StringIO(csv_table(made).decode("utf-8-sig"), newline="")))


def test_a_student_is_a_row_and_an_exercise_a_column(journal):
    def cells(row, names):
        return [row[name] for name in names.split("; ")]

    journal.keep(result("ada", exercise(), exercise("wrong", name="other", number="1.2"), answer()))
    journal.keep(result("bob", exercise("raised"), answer(text="")))
    journal.keep(result("ada", exercise(number="2.1"), lesson="02_posts", notes=("x.py does not count",)))
    journal.override(Override("bob", LESSON, "rgb_to_hsl", 1.5, "late bus"))
    ada, bob = rows_of(all_scores(journal))
    exercises = "1.1 rgb_to_hsl; 1.2 other; 1.W1 why_hsl"
    assert cells(ada, f"student; {exercises}; 2.1 rgb_to_hsl; total") == ["ada", "2", "0", "", "2", "4"]
    assert cells(ada, f"{LESSON} points; {LESSON} out of; {LESSON} notes; 02_posts notes") == [
        *("2", "6", "1 written answer not marked yet", "x.py does not count")
    ]
    assert cells(bob, f"{exercises}; 02_posts status") == ["1.5", "", "0", "not handed in"]
    assert "late bus" in bob[f"{LESSON} notes"]
    journal.mark([mark(1.25)])
    (ada, _) = rows_of(all_scores(journal, LESSON))
    assert (ada["1.W1 why_hsl"], ada["total"]) == ("1.25", "3.25") and "02_posts points" not in ada


def test_exercises_stand_before_questions_and_a_refusal_or_lateness_with_its_reason():
    (header, _) = csv_table(scores([result("ada", answer(), exercise())])).decode("utf-8-sig").splitlines()
    assert header.startswith("student,name,email,login,section,1.1 rgb_to_hsl,1.W1 why_hsl,")
    (row,) = rows_of([score(result("ada", exercise("not found"), status="refused", reason="it is empty"))])
    assert (row["total"], row[f"{LESSON} status"], row[f"{LESSON} notes"]) == ("0", "refused", "it is empty")
    late = result("ada", exercise(), handed_in="2026-11-20 23:59+00:00", late=True)
    ada, bob = rows_of(scores([late, result("bob", exercise())]))
    assert (ada[f"{LESSON} handed in"], ada[f"{LESSON} late"]) == ("2026-11-20 23:59+00:00", "yes")
    assert (bob[f"{LESSON} handed in"], bob[f"{LESSON} late"]) == ("", "")
    assert ada["total"] == bob["total"] == "2"


def test_every_student_gets_a_file_and_an_empty_journal_is_a_header(journal, tmp_path):
    assert csv_table([]).decode("utf-8-sig") == "student,name,email,login,section,total\r\n"
    assert exports.write_csv(journal, tmp_path / "x").read_bytes() == csv_table([])
    assert write_gradescope(journal, tmp_path / "x") == []
    names = ["ada", "Ada", "../eve", *(each for each in HOSTILE if each.isprintable())]
    for name in names:
        journal.keep(result(name, exercise()))
    paths = write_gradescope(journal, tmp_path / "out")
    assert len({str(path).lower() for path in paths}) == len(set(names))
    assert all(path.resolve().is_relative_to((tmp_path / "out").resolve()) for path in paths)
    assert json.loads(paths[0].read_text(encoding="utf-8"))["score"] == 2.0


@settings(max_examples=30, deadline=None)
@given(st.lists(results(), max_size=4, unique_by=lambda each: (each.student, each.lesson)))
def test_no_cell_of_any_table_is_a_formula_and_every_row_has_all_columns(some):
    table = list(csv.reader(io.StringIO(csv_table(scores(some)).decode("utf-8-sig"), newline="")))
    assert len(table) == 1 + len({each.student for each in some})
    assert {len(row) for row in table} == {len(table[0])}
    for row in table:
        for cell in row:
            assert not re.match(r"\s*[=+\-@\t\r]", cell), cell


def test_the_sum_of_a_row_is_its_total_and_odd_names_stay_apart(journal):
    made = scores([result("ada", *(exercise(name=f"e{i}", earned=i / 7, points=9) for i in range(9)))])
    (row,) = rows_of(made)
    cells = [float(value) for name, value in row.items() if " e" in name]
    assert sum(cells) == pytest.approx(float(row["total"]), abs=1e-5) and len(cells) == 9
    names = [*("Łucja Nguyễn", "ada", "Ada", "=1+1", "'=1+1", "a,b", 'a"b', "a\nb", "001", "1"), "x" * 300]
    for name in names:
        journal.keep(result(name, exercise()))
    assert len({row["student"] for row in rows_of(all_scores(journal))}) == len(names)


KEYS = {  # of the autograder documentation
    *("score", "output", "output_format", "test_output_format", "test_name_format", "visibility"),
    *("stdout_visibility", "extra_data", "tests"),
}
TEST_KEYS = {"name", "number", "score", "max_score", "status", "output", "output_format", "visibility"}


@settings(max_examples=40, deadline=None)
@given(results())
def test_any_result_is_what_gradescope_specifies_and_holds_nothing_hidden(any_result):
    made = gradescope_results(score(any_result))
    assert set(made) == KEYS and all(set(each) == TEST_KEYS for each in made["tests"])
    assert all(each["status"] in ("passed", "failed") for each in made["tests"])
    assert made["score"] == pytest.approx(sum(each["score"] for each in made["tests"]), abs=1e-4)
    text = json.dumps(made, ensure_ascii=False)
    text.encode()
    assert not [secret for secret in (RUBRIC, MISTAKE, FOR_ASSISTANTS) if secret in text]


def test_a_test_says_what_the_feedback_says_and_what_a_person_marked_or_changed_counts():
    wrong = exercise("wrong", text="Its answer has the wrong shape.", hint="Swap the axes.", line="line 2: x")
    made = gradescope_results(score(result("ada", wrong, exercise(name="fine", number="1.2"), answer())))
    first, second = made["tests"]
    for said in ("Not right yet", "wrong shape", "Hint\nSwap the axes.", "line 2: x"):
        assert said in first["output"]
    assert [first[key] for key in ("status", "number", "score", "max_score")] == ["failed", "1.1", 0.0, 2.0]
    assert (second["status"], second["name"]) == ("passed", "fine")
    assert made["output"] == "1 written answer to be marked by a person."
    assert made["stdout_visibility"] == "hidden"
    made = gradescope_results(score(result("ada", answer()), (), [mark(comment="Well.")]))
    (test,) = made["tests"]
    assert (test["score"], test["status"], test["output"], made["score"]) == (1.5, "failed", "Well.", 1.5)
    changes = [Override("ada", LESSON, "rgb_to_hsl", 2.0, "late bus")]
    (test,) = gradescope_results(score(result("ada", exercise("wrong")), changes))["tests"]
    assert (test["status"], test["score"]) == ("passed", 2.0)
    made = gradescope_results(score(result("ada", exercise("not found"), status="refused", reason="no zip")))
    assert made["output"] == "Refused: no zip" and made["tests"][0]["output"] == ""


def test_another_format_is_refused_with_those_there_are():
    for name, more in [("nbgrader", ".*later version"), ("xls", r"\.$")]:
        with pytest.raises(
            ExportError, match=f"no format '{name}'; there are csv, json, gradescope, mo.*{more}"
        ):
            exports.check_format(name)


def test_a_students_address_login_and_section_are_in_the_tables_and_all_points_in_the_json(journal, tmp_path):
    journal.keep(result("ada", exercise(earned=1.5), answer(), handed_in="2026-11-20 23:59+00:00"))
    journal.keep(result("ada", exercise(), lesson="02_x"))
    journal.keep(result("bob", lesson="02_x", status="refused", reason="it is empty"))
    journal.know([Student("ada", "Ada L.", "ada@uni.example", "al12", "A")])
    who = {"student": "ada", "name": "Ada L.", "email": "ada@uni.example", "login": "al12", "section": "A"}
    with exports.write_csv(journal, tmp_path).open(encoding="utf-8-sig", newline="") as file:
        assert who.items() <= next(csv.DictReader(file)).items()
    ada, bob = json.loads(exports.write_json(journal, tmp_path).read_text("utf-8"))
    assert who.items() <= ada.items() and ada["total"] == 3.5 and list(ada["lessons"]) == [LESSON, "02_x"]
    lesson = ada["lessons"][LESSON]
    assert (lesson["points"], lesson["out_of"], lesson["handed_in"]) == (1.5, 4, "2026-11-20 23:59+00:00")
    assert lesson["exercises"] == [
        {"name": "rgb_to_hsl", "number": "1.1", "out_of": 2, "points": 1.5, "state": "right"}
    ]
    assert lesson["questions"][0]["points"] is None and bob["lessons"]["02_x"]["notes"] == ["it is empty"]


def command(*words, status=None):
    done = CliRunner().invoke(cli.app, [str(word) for word in words])
    assert status in (None, done.exit_code), done.output
    return done.stdout + done.stderr


@pytest.mark.usefixtures("secret")
def test_the_commands_write_and_refuse_in_a_sentence(tmp_path):
    grades = tmp_path / "grades"
    export = ("export", grades, "--format")
    assert "there is no journal" in command(*export, "csv", status=1)
    with Journal(grades) as journal:
        journal.keep(result("ada", exercise(), answer()))
    assert "grades.csv" in command(*export, "csv") and (grades / "exports" / "grades.csv").is_file()
    assert "there are csv, json, gradescope" in command(*export, "nbgrader", status=1)
    assert "no lesson '7' was graded" in command(*export, "csv", "--lesson", "7")
    sheet = grades / "marking" / "01_hsl_filtering_why_hsl.csv"
    assert "1 answer, 1 to mark" in command("marks", grades)
    assert "Still to mark: 1 answer (ada)" in command("marks", grades, sheet)
    sheet.write_bytes(sheet.read_bytes().replace(b"shadows.,,", b'shadows.,"1,5",Fine'))
    done = command("marks", grades, sheet)
    assert "read, 1 of them new or changed" in done and "Nothing is left" in done
    page = (grades / "feedback" / "ada" / f"{LESSON}.html").read_text(encoding="utf-8")
    assert "1.5 of 2 points" in page and "Fine" in page
    assert "report.html" in command("report", grades)


@pytest.mark.usefixtures("secret")
def test_the_commands_have_switches_for_scaled_points_and_anonymous_marking(tmp_path):
    grades, sheet = tmp_path / "grades", tmp_path / "theirs.csv"
    with Journal(grades) as journal:
        journal.keep(result("Ada_77", exercise(), answer(), file=f"Ada_77_88_{LESSON}.ipynb"))
    sheet.write_text("Student,ID,Lesson (1)\nPoints Possible,,100\nAda,77,\n")
    words = ("export", grades, "--format", "canvas", "--sheet", sheet, "--column", "Lesson")
    assert "is 100 points, and 01_hsl_filtering is worth 4" in command(*words, status=1)
    assert "1 row filled in" in command(*words, "--scale")
    filled = (grades / "exports" / f"canvas_{LESSON}.csv").read_text("utf-8-sig").splitlines()
    assert filled[-1] == "Ada,77,50"
    with zipfile.ZipFile(grades / "exports" / f"canvas_feedback_{LESSON}.zip") as pages:
        assert pages.namelist() == [f"Ada_77_88_{LESSON}.html"]
    assert "1 answer, 1 to mark" in command("marks", grades, "--anonymous")
    table = (grades / "marking" / f"{LESSON}_why_hsl.csv").read_text("utf-8-sig")
    assert "Ada_77" not in table and "student-" in table
