"""What a challenge is: its documentation's example, rows and columns, how it is found, and what is no answer."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.challenges import CaseResult, Challenge, Column, Row, Run, challenge, finding, recorded_rows
from nao_course.challenges.answers import as_found_points
from nao_course.challenges.running import run
from nao_course.challenges.worst_cases import draw_worst
from tests.challenges.example import CHALLENGE, COST
from tests.paths import PROJECT


def test_the_example_in_the_documentation_is_a_challenge(tmp_path):
    text = (PROJECT / "docs" / "write_a_challenge.md").read_text(encoding="utf-8")
    example = text.split("```python\n")[1].split("```")[0]
    scene = SimpleNamespace(pixels=np.zeros((2, 2, 3)), distance=1.0)
    names = {"__file__": str(tmp_path / "challenge.py"), "make_scene": lambda seed: scene}
    exec(compile(example, "docs", "exec"), names)
    made = names["CHALLENGE"]
    assert isinstance(made, Challenge) and made.rows == ()
    came = run(made, lambda picture: 1.75)
    assert came.score == 0.75 and came.columns == {"farther than 0.5 m": 100.0}
    blind_once = iter(["far"])
    assert run(made, lambda picture: next(blind_once, 1.75)).results[0].score == 3.0


def test_rows_are_read_as_recorded_a_column_says_its_number_and_no_cases_are_refused(tmp_path):
    path = tmp_path / "challenge.json"
    assert recorded_rows(path) == ()
    path.write_text(json.dumps([{"name": "nothing", "score": 0.5, "columns": {"off": 1.0}, "cases": [0, 1]}]))
    assert recorded_rows(path) == (Row("nothing", 0.5, {"off": 1.0}, (0, 1)),)
    column = Column("off", " m", 1)
    assert [column.say(value) for value in (1.25, -0.01, None, float("nan"))] == ["1.2 m", "0.0 m", "-", "-"]
    with pytest.raises(ValueError, match="77_doubling has no seeds"):
        replace(CHALLENGE, seeds=())


def test_the_three_worst_cases_are_drawn_the_worst_first_which_of_a_cost_are_the_highest():
    scores = {1: 0.1, 2: 0.9, 3: 0.8, 4: 0.3}
    results = tuple(CaseResult(seed, f"case {seed}", score, {}, seed) for seed, score in scores.items())
    for made, worst in ((CHALLENGE, [1, 4, 3]), (COST, [2, 3, 4])):
        drawn = []
        said = draw_worst(Run(made, results), lambda ax, kept, drawn=drawn: drawn.append(kept), []).alt
        assert drawn == worst
        assert said.index(f"case {worst[0]} with") < said.index(f"case {worst[2]} with")


@pytest.mark.parametrize("word", ["01_hsl_filtering", "01", "1", 1])
def test_a_number_or_a_name_finds_a_lessons_challenge(word):
    assert challenge(word).challenge.lesson == "01_hsl_filtering"


def test_a_lesson_without_a_challenge_or_without_a_folder_has_none(monkeypatch):
    with pytest.raises(ValueError, match="no challenge '99'; choose one of 00_meet_the_nao, 01_hsl"):
        challenge("99")
    monkeypatch.setattr(finding, "lessons", lambda: ["01_hsl_filtering", "98_nowhere", "99_challenges"])
    for word in ("98", "99"):
        with pytest.raises(ValueError, match="there is no challenge"):
            challenge(word)


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        (None, "returns None"),
        ("feet", "got str"),
        (np.zeros((2, 3)), r"or \(0, 2\) without any points"),
        ([(np.nan, 1.0)], "NaN or infinite"),
        (np.zeros((1001, 2)), "at most 1000"),
    ],
)
def test_what_is_no_points_is_said(answer, said):
    with pytest.raises((TypeError, ValueError), match=said):
        as_found_points(answer, "feet")
