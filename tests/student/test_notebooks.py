"""The student's own functions of an earlier lesson: those that are right, and a sentence about the rest."""

import os
import signal
from pathlib import Path

import pytest

from nao_course.student import notebooks as student
from tests.toy import toy

WRONG = "def clamp(x, low, high):\n    return x"
BLANK = "def mean_of_positive(values):\n    raise NotImplementedError"


def test_right_functions_are_handed_on_and_what_their_notebook_prints_is_not_shown(tmp_path, capsys):
    noisy = toy.CLAMP.replace("    return", "    print('called')\n    return")
    toy.write(tmp_path / "90_toy.ipynb", "if True:\n    print('loaded')", noisy, toy.MEAN)
    own = student.functions("90_toy", tmp_path)
    assert capsys.readouterr() == ("", "")
    assert own.complete and list(own) == ["clamp", "mean_of_positive"]
    assert own["clamp"](5, 0, 1) == 1
    assert repr(own) == "Your lesson 90_toy: all 2 functions are ready."


def test_wrong_and_blank_ones_are_told_and_not_replaced(tmp_path):
    toy.write(tmp_path / "90_toy.ipynb", WRONG, BLANK)
    own = student.functions("90_toy", tmp_path)
    assert not own.complete
    assert dict(own) == {}
    assert own.get("clamp") is None
    assert "clamp (wrong), mean_of_positive (not attempted)" in repr(own)
    assert "recorded data" in own._repr_html_()
    with pytest.raises(KeyError, match="clamp of lesson 90_toy is not usable yet.*1 of 3 public checks"):
        own["clamp"]
    with pytest.raises(KeyError, match="no exercise 'squash'"):
        own["squash"]


@pytest.mark.parametrize(
    ("content", "reason"),
    [(None, "90.1 clamp: 90_toy.ipynb is not in your folder test_a_missing"), ("{", "not a notebook")],
)
def test_a_missing_or_broken_notebook_is_told(tmp_path, content, reason):
    if content is not None:
        (tmp_path / "90_toy.ipynb").write_text(content)
    own = student.functions("90_toy", tmp_path)
    assert len(own) == 0
    with pytest.raises(KeyError, match=reason):
        own["clamp"]
    toy.write(tmp_path / "90_toy.ipynb", toy.CLAMP, "def mean_of_positive(values:\n    pass")
    with pytest.raises(KeyError, match="not found in 90_toy.ipynb. Code cell 2, .* SyntaxError"):
        student.functions("90_toy", tmp_path)["mean_of_positive"]


def test_the_folder_is_named_or_the_working_one(tmp_path, monkeypatch):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    for folder, cells in (("a", toy.SOLUTION), ("b", [WRONG])):
        os.utime(toy.write(tmp_path / folder / "90_toy.ipynb", *cells), ns=(1, 1))
    monkeypatch.chdir(tmp_path / "a")
    assert student.functions("90_toy").complete
    monkeypatch.chdir(tmp_path / "b")
    assert not student.functions("90_toy").complete
    monkeypatch.setenv("NAO_COURSE_NOTEBOOKS", str(tmp_path / "a"))
    assert student.functions("90_toy").complete


def test_a_notebook_is_loaded_once_and_again_when_it_was_saved(tmp_path):
    path = toy.write(tmp_path / "90_toy.ipynb", *toy.SOLUTION)
    first = student.functions("90_toy", tmp_path)
    assert student.functions("90_toy", tmp_path)["clamp"] is first["clamp"]
    toy.write(path, WRONG, toy.MEAN)
    os.utime(path, ns=(1, 1))
    assert list(student.functions("90_toy", tmp_path)) == ["mean_of_positive"]


needs_alarm = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no alarm clock")
ENDLESS = "if True:\n    for _ in iter(int, 1):\n        pass"


@needs_alarm
def test_a_notebook_that_never_ends_is_given_up_with_a_sentence(tmp_path):
    toy.write(tmp_path / "90_toy.ipynb", ENDLESS, *toy.SOLUTION)
    assert student.functions("90_toy", tmp_path, most_seconds=0.2).problem == (
        "90_toy.ipynb takes longer than 0.2 s: run progress(), which allows more time."
    )
    own = student.functions("90_toy", tmp_path, most_seconds=1.0)
    assert own.problem.startswith("90_toy.ipynb takes longer than 1 s: is the computer busy, or does a")
    assert len(own) == 0 and "takes longer than" in own.reports[0].lines[0]


@needs_alarm
def test_a_function_that_never_ends_costs_no_more_than_its_time_and_may_pass_a_longer_check(tmp_path):
    toy.write(tmp_path / "90_toy.ipynb", "def clamp(x, low, high):\n    while True:\n        pass", toy.MEAN)
    assert "clamp (interrupted)" in repr(student.functions("90_toy", tmp_path, most_seconds=0.2))
    _, why = student.own_function("90:clamp", {}, tmp_path, 0.2)
    assert why == "clamp of lesson 90 takes too long in its check"
    assert student.stored_result("90:clamp", tmp_path) is None


def clamp(x, low, high):
    return max(low, min(high, x))


def test_a_right_function_at_hand_is_taken_before_the_saved_one(tmp_path):
    toy.write(tmp_path / "90_toy.ipynb", *toy.SOLUTION)
    assert student.own_function("90:clamp", {"clamp": clamp}, tmp_path) == (clamp, "")
    saved = student.functions("90_toy", tmp_path)["clamp"]
    for at_hand in ({}, {"clamp": lambda *given: 0.0}, {"clamp": 3}):
        assert student.own_function("90:clamp", at_hand, tmp_path) == (saved, "")


def test_why_there_is_no_right_function_is_said_in_words(tmp_path, monkeypatch):
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    for where, named in ((work, "work"), (Path("."), "work"), (Path("/"), "/")):
        _, why = student.own_function("90:clamp", {}, where)
        assert why == f"90_toy.ipynb is not in your folder {named}"
    for body, why in (
        ("return x", "does not pass its check yet"),
        ("return 1 / 0", "does not pass its check yet"),
        ("raise NotImplementedError", "is not written yet"),
    ):
        toy.write(work / "90_toy.ipynb", f"def clamp(x, low, high):\n    {body}")
        assert student.own_function("90:clamp", {}, work) == (None, f"clamp of lesson 90 {why}")
