"""What people decide can be set, taken back and undone, and one page shows who decided what about a student."""

import pytest
from typer.testing import CliRunner

from nao_course import cli
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Mark, Request
from nao_course.instructor.gradebook.scores import all_scores
from nao_course.instructor.reports.history import history_page, page_of
from tests.pages import HOSTILE, Page, answer, exercise, mark, result
from tests.toy import chain

LESSON = chain.LESSON


@pytest.fixture
def grades(tmp_path, monkeypatch, secret):
    """Return a folder of grades, in which Ada has a request and a mark, with its course as the working folder."""
    made = chain.make_course(tmp_path / "course")
    (made.root / "solutions" / f"{LESSON}.md").touch()
    monkeypatch.chdir(made.root)
    folder = tmp_path / "grades"
    with Journal(folder) as journal:
        for student in ("ada", "ben"):
            parts = (exercise(points=4.0, earned=4.0, answer="a"), answer())
            journal.keep(result(student, *parts, lesson=LESSON, file=f"{student}.ipynb", submission="s"))
        journal.request([Request("ada", LESSON, "rgb_to_hsl", "Is this right?")])
        journal.mark([mark(1.5, "Good.", lesson=LESSON, given_by="cleo")])
    return folder


def run(*words, status=0):
    done = CliRunner().invoke(cli.app, [str(word) for word in words])
    assert done.exit_code == status, done.output
    return " ".join(done.output.split())


def earned(grades):
    with Journal(grades) as journal:
        return {each.result.student: each.earned for each in all_scores(journal)}


def page(grades, student="ada"):
    return Page((grades / "feedback" / safe_name(student) / f"{LESSON}.html").read_text("utf-8")).text


def test_points_by_hand_below_the_graders_are_said_and_can_be_taken_back(grades):
    command = ["regrade", grades, "--student", "ada"]
    said = run(*command, "--set", "rgb_to_hsl=2", "--reason", "Copied.", "--by", "dan")
    assert "rgb_to_hsl counts 2 points from now on" in said and "The grader gives 4" in said
    assert earned(grades)["ada"] == 3.5 and "A person looked at this" in page(grades)
    with Journal(grades) as journal:
        assert journal.requests()[0].given_by == "dan"
    assert "the grader's 4 points count" in run(*command, "--unset", "rgb_to_hsl")
    assert earned(grades)["ada"] == 5.5 and "A person looked at this" not in page(grades)
    assert "nobody gave 'ada' points for 'rgb_to_hsl'" in run(*command, "--unset", "rgb_to_hsl", status=1)
    assert "it is to be marked" in run(*command, "--unset", "why_hsl")
    assert earned(grades)["ada"] == 4


def test_two_marks_that_differ_are_settled_by_hand(grades):
    with Journal(grades) as journal:
        journal.mark([mark(0.5, lesson=LESSON, given_by="dan", is_second=True)])
        assert [score.differing for score in all_scores(journal)] != [[], []]
    run("regrade", grades, "--student", "ada", "--set", "why_hsl=1.5", "--reason", "We agreed.")
    with Journal(grades) as journal:
        assert [score.differing for score in all_scores(journal)] == [[], []]
        assert earned(grades)["ada"] == 5.5 and "We agreed." in page(grades)
        assert len([each for each in journal.decisions("ada") if isinstance(each, Mark)]) == 4


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--set", "rgb_to_hsl=5", "--reason", "x"], "rgb_to_hsl is worth 0 to 4 points, got 5"),
        (["--set", "rgb_to_hsl=", "--reason", "x"], "say --unset rgb_to_hsl"),
        (["--set", "hue=1", "--reason", "x"], "has no exercise 'hue'; it has rgb_to_hsl, why_hsl"),
        (["--set", "rgb_to_hsl=1"], "say why with --reason"),
        (["--set", "rgb_to_hsl=1", "--unset", "rgb_to_hsl"], "give one of --set, --unset and --keep"),
    ],
)
def test_a_wrong_decision_is_refused_with_what_to_do(grades, words, said):
    before = earned(grades)
    assert said in run("regrade", grades, "--student", "ada", *words, status=1)
    assert earned(grades) == before


def test_undo_takes_points_and_names_back_on_the_pages_too(grades):
    before = earned(grades)
    run("regrade", grades, "--student", "ada", "--set", "rgb_to_hsl=2", "--reason", "Copied.", "--by", "dan")
    run("students", grades, "--rename", "ada", "Ada")
    assert set(earned(grades)) == {"Ada", "ben"}
    assert "undone: nao-course students --rename ada Ada" in run("undo", grades)
    assert not (grades / "feedback" / safe_name("Ada")).exists()
    assert "2 of 4 points" in page(grades)
    assert "undone: nao-course regrade --student ada --set rgb_to_hsl=2 (by dan, 2" in run("undo", grades)
    assert "A person looked at this" not in page(grades) and earned(grades) == before
    with Journal(grades) as journal:
        assert journal.requests()[0].answer == ""
    assert "there is nothing to undo" in run("undo", grades, status=1)


def test_the_history_of_a_student_is_one_page(grades):
    run("regrade", grades, "--student", "ada", "--set", "rgb_to_hsl=2", "--reason", "Copied.", "--by", "dan")
    run("regrade", grades, "--student", "ada", "--unset", "rgb_to_hsl", "--by", "eve")
    with Journal(grades) as journal:
        (old,) = journal.each_result(student="ada")
        journal.keep(
            result("ada", *old.exercises, answer(text="New"), lesson=LESSON, submission="t", file="b.ipynb")
        )
    assert "wrote" in run("history", grades, "--student", "ada")
    text = Page(page_of(grades, "ada").read_text("utf-8")).text
    for said in (
        "4 of 6 points now",
        "ada.ipynb; handed in at an unknown time; replaced since",
        "b.ipynb; handed in at an unknown time",
        "Points by hand: rgb_to_hsl 2 by dan; the grader gave 4; Copied.; does not count now",
        "Taken back: rgb_to_hsl by eve",
        "Mark: why_hsl 1.5 by cleo; Good.; does not count now",
        "Request: rgb_to_hsl Is this right? Answered by dan: Copied.",
    ):
        assert said in text
    assert "'bem' has no result; is it 'ben'?" in run("history", grades, "--student", "bem", status=1)
    run("students", grades, "--forget", "ada")
    assert not page_of(grades, "ada").exists()


@pytest.mark.parametrize("text", HOSTILE)
def test_hostile_names_and_words_stay_text_in_a_history(grades, text):
    with Journal(grades) as journal:
        text = text.encode("utf-8", "replace").decode()
        journal.keep(result("x", exercise(), answer(text=text), file=text, reason=text))
        journal.mark([mark(1.0, text, student="x", given_by=text)])
        assert Page(history_page(journal, journal.roster().students["x"])).offences() == []
