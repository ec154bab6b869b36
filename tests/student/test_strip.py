"""The line on top of a lesson: true, short, and there in a moment whatever a notebook holds."""

import dataclasses

import pytest

from nao_course.student import progress, so_far, stages, strip, verdicts
from tests.student.test_notebooks import ENDLESS, needs_alarm
from tests.toy import toy

LONG = 60.0


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch, stage):
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


def test_it_says_what_the_robot_has_and_what_comes_next_and_escapes_what_a_student_wrote(here, monkeypatch):
    (here / "90_toy.ipynb").write_text('{"nbformat": 4, "cells": "<b>"}')
    line = so_far(seconds=LONG)
    assert "&lt;" not in repr(line) and "<b>" not in line._repr_html_()
    assert 'role="note"' in line._repr_html_() and "next: distances (90)" in line._repr_html_()
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    has, comes = "Your NAO so far: ✔ distances (90)", "next: goal posts (91)"
    assert repr(so_far(seconds=LONG)) == repr(so_far("91", LONG)) == f"{has} · {comes}"
    assert repr(so_far("90")) == "Your NAO so far: nothing yet · next: distances (90)"
    assert repr(so_far("92", LONG)) == f"{has} · lesson 92 adds no stage · {comes}"
    assert "adds no stage" not in repr(so_far("00", LONG))
    monkeypatch.setattr(stages, "PLANNED", {"90": "distances"})
    assert repr(so_far(seconds=LONG)) == f"{has} · all stages are ready"


@needs_alarm
@pytest.mark.parametrize(
    ("cell", "seconds"),
    [(ENDLESS, 0.2), ("def clamp(x, low, high):\n    while True:\n        pass", 0.2), (toy.CLAMP, 1e-6)],
)
def test_a_notebook_that_needs_more_time_keeps_nobody_from_beginning_a_lesson(here, cell, seconds):
    toy.write(here / "90_toy.ipynb", cell, toy.MEAN)
    # It may end on a faster machine, and what was not looked at may be solved: the line says neither.
    said = repr(so_far(seconds=seconds))
    assert said == "Your NAO so far: not checked yet (run progress()): distances (90)"


def test_a_notebook_without_an_answer_is_not_begun_however_little_time_there_is(here):
    blank = [
        f"{source[: source.index(':', source.index(')')) + 1]}\n    raise NotImplementedError"
        for source in (toy.CLAMP, toy.MEAN)
    ]
    toy.write(here / "90_toy.ipynb", *(("solution", each) for each in blank))
    assert repr(so_far(seconds=-1)) == "Your NAO so far: nothing yet · next: distances (90) (not begun)"


LACKS = "mean_of_positive of lesson 90 does not pass its check yet"


@pytest.mark.parametrize(
    ("cell", "said"),
    [
        (toy.MEAN, "✔ distances (90) · next: goal posts (91)"),
        ("def mean_of_positive(values):\n    return 0.0", f"nothing yet · next: distances (90) ({LACKS})"),
    ],
)
@pytest.mark.parametrize("look", [progress, lambda: so_far(seconds=LONG)])
def test_what_was_looked_at_before_is_known_at_once_until_a_notebook_is_saved(here, cell, said, look):
    toy.write(here / "90_toy.ipynb", toy.CLAMP, cell)
    look()
    assert repr(so_far(seconds=-1)) == f"Your NAO so far: {said}"
    toy.write(here / "91_later.ipynb", "x = 1")  # a later lesson changes nothing
    assert repr(so_far(seconds=-1)) == f"Your NAO so far: {said}"
    toy.write(here / "90_toy.ipynb", toy.CLAMP, cell, "y = 1")
    assert "not checked yet" in repr(so_far(seconds=-1))


def test_what_was_kept_of_a_notebook_holds_until_an_earlier_one_is_saved(here):
    for name in ("90_toy", "91_later", "92_last"):
        toy.write(here / f"{name}.ipynb", "x = 1")
    verdicts.keep(here / "91_later.ipynb", "clamp", "")
    toy.write(here / "92_last.ipynb", "x = 2")
    assert verdicts.kept(here / "91_later.ipynb", "clamp") == ""
    toy.write(here / "90_toy.ipynb", "x = 2")
    assert verdicts.kept(here / "91_later.ipynb", "clamp") is None


def test_a_stage_after_one_that_nobody_has_looked_at_is_not_looked_at_either(here, monkeypatch, stage):
    later = dataclasses.replace(stage, name="goal posts", lesson="91_posts", uses=(), after=("distances",))
    monkeypatch.setattr(strip, "all_stages", lambda: [stage, later])
    said = repr(so_far(seconds=-1))
    assert said == "Your NAO so far: not checked yet (run progress()): distances (90), goal posts (91)"


def test_a_broken_file_of_what_was_kept_is_as_none_and_a_strict_course_keeps_none(here, monkeypatch):
    toy.write(here / "90_toy.ipynb", *toy.SOLUTION)
    for broken in ("{", "[]", '{"90_toy": []}', '{"90_toy": {"of": 1}}'):
        (here / verdicts.FILE).write_text(broken)
        assert "not checked yet" in repr(so_far(seconds=-1))
        assert "✔ distances (90)" in repr(so_far(seconds=LONG)) and "✔ dist" in repr(so_far(seconds=-1))
    (here / verdicts.FILE).unlink()
    monkeypatch.setenv("NAO_COURSE_STRICT", "1")
    so_far()
    assert not (here / verdicts.FILE).exists()
