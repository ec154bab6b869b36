"""What a challenge is: its documentation's example, its rows, its columns."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.challenges import Challenge, Column, Row, recorded_rows
from nao_course.challenges.running import run
from tests.challenges.example import CHALLENGE
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


def test_rows_are_read_from_what_was_recorded(tmp_path):
    path = tmp_path / "challenge.json"
    assert recorded_rows(path) == ()
    path.write_text(json.dumps([{"name": "nothing", "score": 0.5, "columns": {"off": 1.0}, "cases": [0, 1]}]))
    assert recorded_rows(path) == (Row("nothing", 0.5, {"off": 1.0}, (0, 1)),)


def test_a_column_says_its_number_with_its_unit_and_a_dash_for_none():
    column = Column("off", " m", 1)
    assert [column.say(value) for value in (1.25, -0.01, None, float("nan"))] == ["1.2 m", "0.0 m", "-", "-"]


def test_a_challenge_without_cases_is_refused():
    with pytest.raises(ValueError, match="77_doubling has no seeds"):
        replace(CHALLENGE, seeds=())
