"""The table of all lessons: points by public checks, written answers, and a sentence for each notebook that is none."""

import json
from dataclasses import replace

import pytest

from nao_course.exercises import checking
from nao_course.exercises.exercise import ANSWER_HERE, PublicWritten
from nao_course.student import notebooks, overview, progress
from tests.paths import PROJECT
from tests.student.test_notebooks import BLANK, ENDLESS, needs_alarm
from tests.toy import toy

LESSONS = checking.lessons()


@pytest.fixture
def written(public, monkeypatch):
    """The lesson has a written question, too."""
    asked = replace(public, written=[PublicWritten("why", "90.W1", 2.0)])
    monkeypatch.setattr(overview, "read_public", {"90_toy": asked}.__getitem__)
    monkeypatch.setattr(notebooks, "read_public", {"90_toy": asked}.__getitem__)


def answer(path, text):
    """Put a written answer into a notebook."""
    notebook = json.loads(path.read_text())
    metadata = {"nbgrader": {"grade_id": "why", "grade": True, "solution": True}}
    notebook["cells"].append({"id": "w", "cell_type": "markdown", "metadata": metadata, "source": text})
    path.write_text(json.dumps(notebook))


def last_lines(found):
    return repr(found).splitlines()[-2:]


def test_a_lesson_that_is_done(tmp_path):
    toy.write(tmp_path / "90_toy.ipynb", *toy.SOLUTION)
    row = repr(progress(tmp_path)).splitlines()[1]
    assert row.split("  ")[0] == "90_toy" and "✔ done" in row and "2 of 2" in row and "5 of 5" in row
    total, upcoming = last_lines(progress(tmp_path))
    assert total == f"All lessons: 5 of 5 points pass their public checks. {overview.PUBLIC_ONLY}"
    assert upcoming == "Next: nothing, all lessons are complete."
    page = progress(tmp_path)._repr_html_()
    assert page.count('scope="col"') == 5 and page.count('scope="row"') == 1, "for screen readers"


def test_a_lesson_that_is_begun_says_what_comes_next_and_its_sum_before_that_of_all(tmp_path):
    toy.write(tmp_path / "90_toy.ipynb", toy.CLAMP, BLANK)
    found = progress(tmp_path)
    assert "begun" in repr(found) and "1 of 2" in repr(found)
    assert last_lines(found)[1] == "Next: exercise 90.2 mean_of_positive (not attempted), in 90_toy."
    total = found.total("90_toy")
    assert total.startswith("90_toy: 2 of 5 points pass their public checks. All lessons: 2 of 5 points")
    assert total.endswith("the grader uses further checks with other inputs.")


def test_written_answers_are_counted_apart_and_named_when_blank(tmp_path, written):
    path = tmp_path / "90_toy.ipynb"
    for cells, text, said in (
        ([BLANK], ANSWER_HERE, "○ not begun"),
        ([BLANK], "Because.", "begun"),
        (toy.SOLUTION, ANSWER_HERE, "0 of 1 written answer filled in (2 more, marked by a person)"),
        (toy.SOLUTION, "Because.", "1 of 1 filled in"),
    ):
        answer(toy.write(path, *cells), text)
        found = repr(progress(tmp_path))
        assert said in found and ("○ not begun" in found) is (said == "○ not begun")
        named = last_lines(progress(tmp_path))[1] == "Next: 90.W1, in your own words, in 90_toy."
        assert named is (cells is toy.SOLUTION and text == ANSWER_HERE)
    assert "✔ done" in repr(progress(tmp_path))


@pytest.mark.parametrize(
    "name", [each if each[:2] == "11" else pytest.param(each, marks=pytest.mark.slow) for each in LESSONS]
)
def test_a_notebook_as_it_was_released_is_not_run_and_running_it_would_give_the_same(name, monkeypatch):
    monkeypatch.undo()
    folder = PROJECT / "notebooks"
    with monkeypatch.context() as without:
        without.setattr(overview, "functions", None)
        unread = overview.lesson_progress(name, folder)
    monkeypatch.setattr(overview, "_known", lambda public, path: None)
    assert unread == overview.lesson_progress(name, folder) and "not attempted" in unread.upcoming


def test_a_notebook_whose_exercises_all_passed_is_not_run_again_before_it_is_saved(tmp_path, monkeypatch):
    path = toy.write(tmp_path / "90_toy.ipynb", *toy.SOLUTION)
    first = progress(tmp_path)
    with monkeypatch.context() as without:
        without.setattr(overview, "functions", None)
        assert progress(tmp_path) == first
    toy.write(path, toy.CLAMP, BLANK)
    assert "1 of 2" in repr(progress(tmp_path))


@needs_alarm
def test_a_notebook_that_is_missing_broken_or_never_ends_is_a_sentence(tmp_path, monkeypatch):
    (work := tmp_path / "work").mkdir()
    for content, said in (
        (None, "90_toy.ipynb is not in your folder work."),
        ("{", "90_toy.ipynb: not a notebook of format 4"),
    ):
        if content is not None:
            (work / "90_toy.ipynb").write_text(content)
        found = progress(work)
        assert said in repr(found) and said in found._repr_html_()
        assert f"Next: 90_toy. {said}" in last_lines(found)[1] and "0 of 5 points" in repr(found)
    toy.write(work / "90_toy.ipynb", ENDLESS, *toy.SOLUTION)
    monkeypatch.setattr(notebooks, "SECONDS", 0.2)
    found = progress(work)
    assert "90_toy.ipynb takes longer than 0.2 s" in repr(found)
    assert "Not counted: 90_toy.ipynb takes longer than 0.2 s" in found.total("90_toy")
    (work / "90_toy.ipynb").unlink()
    assert "Not counted" not in progress(work).total("90_toy")
