"""What lesson 10 adds to the robot: it searches while it drives, and looks with the best setting so far."""

from types import SimpleNamespace

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.experiments import stage
from nao_course.lessons.experiments.paper_table import SETTINGS
from tests.lessons.driven import pipeline, robot

SMALL = np.zeros((12, 16, 3), np.uint8), np.zeros((0, 2))


@pytest.fixture
def live(monkeypatch):
    """Return a function that processes the robot's picture, and what its stage asked of the student's functions."""
    monkeypatch.setattr(stage, "simulated_scene", lambda number: SMALL)
    asked = []

    def grid_search(scenes, betas, gaps, lengths):
        asked.append(betas)
        tried = [key for key in SETTINGS if key[0] in betas]
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


def test_it_looks_with_the_best_setting_and_says_on_how_many_scenes_it_is(live):
    texts = [text_of(live.see()) for _ in range(3 * stage.EVERY + 1)]
    assert texts[0] == "1 corner with 130, 7, 50, your best on 1 scene"
    assert texts[-2:] == [texts[0], "1 corner with 130, 7, 50, your best on 2 scenes"]
    assert live.asked[-2:] == [130, (7, 50)]


def test_no_picture_but_the_first_waits_for_more_than_one_threshold_on_one_scene(live):
    live.see()
    for _ in range(4 * stage.EVERY):
        live.asked.clear()
        live.see()
        assert sum(isinstance(each, list) for each in live.asked) <= 1


def test_after_thirty_scenes_it_has_tried_all(live, monkeypatch):
    monkeypatch.setattr(stage, "EVERY", 1)
    texts = [text_of(live.see()) for _ in range(90)]
    assert texts[-1].endswith("on 30 scenes") and texts[-1] == texts[-2]


def test_a_search_that_failed_once_is_tried_again(live):
    answers, functions = iter([None]), live.line._student._functions
    right = functions["grid_search"]
    functions["grid_search"] = lambda *given: next(answers, right(*given))
    assert live.see().complaints
    live.line.retry()
    assert text_of(live.see()).endswith("on 1 scene")
