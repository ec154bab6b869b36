"""Lesson 10's challenge, and what it adds to the robot: it searches while it drives."""

from itertools import product
from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.experiments import stage
from nao_course.lessons.experiments.challenge import Room, interval_score, judge
from nao_course.lessons.experiments.paper_table import SETTINGS
from tests.lessons.driven import pipeline, robot

PICTURE = np.zeros((240, 320, 3), dtype=np.uint8)
ROOM = Room("lab 1", ((PICTURE, np.array([(50.0, 90.0), (200.0, 80.0)])), (PICTURE, np.zeros((0, 2)))))
NONE = np.zeros((0, 2))


def test_the_cost_is_the_mean_and_a_quarter_of_the_width_of_a_right_interval_and_no_claim_is_refused():
    scored = judge(([[(50, 90)], NONE], 1.0, 3.0), ROOM)
    assert scored.columns["mean cost"] == pytest.approx((-1.333 + 5) / 2)
    assert scored.score == pytest.approx(scored.columns["mean cost"] + 0.5)
    assert scored.columns["inside"] == 100.0 and scored.columns["false"] == 0.0
    for answer in ([NONE, NONE], ([NONE], 0.0, 1.0), ([NONE, NONE], 1.0, 0.0), ([NONE, 3], 0, 1)):
        with pytest.raises((TypeError, ValueError)):
            judge(answer, ROOM)


def test_a_wrong_interval_costs_ten_times_its_distance_and_none_costs_less_than_that_of_80_percent(rng):
    assert interval_score(0.0, 1.0, 1.5) == interval_score(0.0, 1.0, -0.5) == pytest.approx(6.0)
    scored = judge(([NONE, NONE], 6.0, 7.0), ROOM)
    assert scored.columns["mean cost"] == 5.0 and scored.score == pytest.approx(5.0 + (1.0 + 10.0) / 4)
    values = rng.normal(0, 1, 4000)
    means = [np.mean([interval_score(-half, half, value) for value in values]) for half in (1.28, 0.9, 1.8)]
    assert min(means) == means[0]


SMALL = np.zeros((12, 16, 3), np.uint8), np.zeros((0, 2))


@pytest.fixture
def live(monkeypatch):
    """Return a function that processes the robot's picture, and what its stage asked of the student's functions."""
    monkeypatch.setattr(stage, "simulated_scene", lambda number: SMALL)
    asked = []

    def grid_search(scenes, betas, gaps, lengths):
        asked.append([betas, gaps, lengths])
        tried = product(betas, gaps, lengths)
        return {key: np.full(len(scenes), 0.0 if key == (130, 7, 50) else 1.0) for key in tried}

    nao = robot(Pose(1.3, -0.4, -0.6))
    line = pipeline(
        stage.STAGE.name,
        nao,
        grid_search=grid_search,
        white_threshold=lambda mean, beta: asked.append(beta) or 200.0,
        color_labels=lambda picture, *limits: np.zeros(picture.shape[:2], np.uint8),
        find_corners=lambda labels, *values: asked.append(values) or np.array([(30.0, 40.0)]),
    )
    picture = nao.take_picture("bottom")
    return SimpleNamespace(see=lambda: line.process(picture), line=line, asked=asked)


def text_of(seen):
    return seen.overlays[stage.STAGE.name].text


def test_it_looks_with_the_best_setting_so_far_and_after_thirty_scenes_it_has_tried_all(live, monkeypatch):
    texts = [text_of(live.see()) for _ in range(len(SETTINGS) * stage.EVERY + 1)]
    assert texts[0] == "1 corner with 130, 7, 50, your best on 1 scene"
    assert texts[-2:] == [texts[0], "1 corner with 130, 7, 50, your best on 2 scenes"]
    assert live.asked[-2:] == [130, (7, 50)]
    monkeypatch.setattr(stage, "EVERY", 1)
    texts = [text_of(live.see()) for _ in range(29 * len(SETTINGS))]
    assert texts[-1].endswith("on 30 scenes") and texts[-1] == texts[-2]


def test_no_picture_but_the_first_waits_for_more_than_one_setting_on_one_scene(live):
    live.see()
    for _ in range(4 * stage.EVERY):
        live.asked.clear()
        live.see()
        searches = [each for each in live.asked if isinstance(each, list)]
        assert len(searches) <= 1 and all(len(values) == 1 for each in searches for values in each)


def test_a_search_that_failed_once_is_tried_again(live):
    answers, functions = iter([None]), live.line._student._functions
    right = functions["grid_search"]
    functions["grid_search"] = lambda *given: next(answers, right(*given))
    assert live.see().complaints
    live.line.retry()
    assert text_of(live.see()).endswith("on 1 scene")
