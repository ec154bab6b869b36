"""What lesson 10 adds to the robot: it searches while it drives, and looks with the best setting so far."""

import numpy as np

from nao_course.geometry import Pose
from nao_course.lessons.experiments import stage
from nao_course.lessons.experiments.paper_table import SETTINGS
from nao_course.sim import Field, SimulatedNao
from nao_course.widgets.control_panel import Pipeline

SMALL = np.zeros((12, 16, 3), np.uint8), np.zeros((0, 2))


def pipeline(monkeypatch, asked, best=(130, 7, 50), **changed):
    monkeypatch.setattr(stage, "simulated_scene", lambda number: SMALL)

    def grid_search(scenes, betas, gaps, lengths):
        asked.append(betas)
        tried = [key for key in SETTINGS if key[0] in betas]
        return {key: np.full(len(scenes), 0.0 if key == best else 1.0) for key in tried}

    functions = {
        "grid_search": grid_search,
        "white_threshold": lambda mean, beta: asked.append(beta) or 200.0,
        "color_labels": lambda picture, *limits: np.zeros(picture.shape[:2], np.uint8),
        "find_corners": lambda labels, *values: asked.append(values) or np.array([(30.0, 40.0)]),
    }
    nao = SimulatedNao(Field(2012), Pose(1.3, -0.4, -0.6), rng=41)
    return nao, Pipeline([stage.STAGE], functions | changed, nao, time_limit=60.0)


def test_it_looks_with_the_best_setting_and_says_on_how_many_scenes_it_is(monkeypatch):
    asked = []
    nao, live = pipeline(monkeypatch, asked)
    picture = nao.take_picture("bottom")
    texts = [live.process(picture).overlays[stage.STAGE.name].text for _ in range(3 * stage.EVERY + 1)]
    assert texts[0] == "1 corner with 130, 7, 50, your best on 1 scene"
    assert texts[-2:] == [texts[0], "1 corner with 130, 7, 50, your best on 2 scenes"]
    assert asked[-2:] == [130, (7, 50)]


def test_no_picture_but_the_first_waits_for_more_than_one_threshold_on_one_scene(monkeypatch):
    asked = []
    nao, live = pipeline(monkeypatch, asked)
    picture = nao.take_picture("bottom")
    live.process(picture)
    for _ in range(4 * stage.EVERY):
        asked.clear()
        live.process(picture)
        assert sum(isinstance(each, list) for each in asked) <= 1


def test_after_thirty_scenes_it_has_tried_all(monkeypatch):
    monkeypatch.setattr(stage, "EVERY", 1)
    nao, live = pipeline(monkeypatch, [])
    picture = nao.take_picture("bottom")
    texts = [live.process(picture).overlays[stage.STAGE.name].text for _ in range(90)]
    assert texts[-1].endswith("on 30 scenes") and texts[-1] == texts[-2]


def test_a_search_that_failed_once_is_tried_again(monkeypatch):
    answers = iter([None])
    nao, live = pipeline(monkeypatch, [])
    right = live._student._functions["grid_search"]
    live._student._functions["grid_search"] = lambda *given: next(answers, right(*given))
    picture = nao.take_picture("bottom")
    assert live.process(picture).complaints
    live.retry()
    assert live.process(picture).overlays[stage.STAGE.name].text.endswith("on 1 scene")
