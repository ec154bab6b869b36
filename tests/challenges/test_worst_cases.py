"""The worst cases of an entry: the lowest scores, or the highest costs."""

from __future__ import annotations

import pytest

from nao_course.challenges import CaseResult, Run
from nao_course.challenges.worst_cases import draw_worst
from tests.challenges.example import CHALLENGE, COST


@pytest.mark.parametrize(("challenge", "worst"), [(CHALLENGE, [1, 4, 3]), (COST, [2, 3, 4])])
def test_the_three_worst_cases_are_drawn_the_worst_first(challenge, worst):
    scores = {1: 0.1, 2: 0.9, 3: 0.8, 4: 0.3}
    results = tuple(CaseResult(seed, f"case {seed}", score, {}, seed) for seed, score in scores.items())
    drawn = []
    said = draw_worst(Run(challenge, results), lambda ax, kept: drawn.append(kept), []).alt
    assert drawn == worst
    assert said.index(f"case {worst[0]} with") < said.index(f"case {worst[2]} with")
