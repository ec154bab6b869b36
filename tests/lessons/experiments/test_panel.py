"""The settings panel: its values reach the student's functions, and what is missing is named."""

import numpy as np

from nao_course.lessons.experiments import panel as module
from nao_course.lessons.experiments.panel import SettingPanel

SCENES = [(np.full((48, 64, 3), 90, np.uint8), np.array([(20.0 + k, 20.0)])) for k in range(4)]


def grid(scenes, betas, gaps, lengths):
    return {(betas[0], gaps[0], lengths[0]): np.arange(len(scenes), dtype=float)}


def panel(grid_search=grid, bootstrap_interval=lambda values, p, rng: (0.5, 2.5), find=None, scenes=SCENES):
    find = find or (lambda picture, *setting: [(5.0, 6.0)])
    return SettingPanel(scenes, grid_search, bootstrap_interval, find)


def test_every_slider_reaches_the_students_functions_and_cost_and_interval_are_said():
    got = []
    shown = panel(
        grid_search=lambda scenes, *values: got.append(values) or grid(scenes, *values),
        find=lambda picture, *setting: got.append(setting) or np.zeros((0, 2)),
    )
    shown.set(beta=150, gap=3, length=25)
    assert got[-3:] == [([150], [3], [25]), (150, 3, 25), (150, 3, 25)]
    shown = panel()
    assert "Mean cost 1.50, 95 % from 0.50 to 2.50. Reporting nothing costs 1.00" in shown.summary()
    assert {"Picture 4 costs 3.00", "Picture 3 costs 2.00"} <= set(shown.shown.pictures)


def test_thirty_new_pictures_replace_the_scenes_until_the_reset(monkeypatch):
    monkeypatch.setattr(module, "simulated_scenes", lambda seed: SCENES[:3] * seed)
    shown = panel()
    shown.set(fresh=2)
    assert "Mean cost 2.50" in shown.summary() and "Picture 6 costs 5.00" in shown.shown.pictures
    shown.reset()
    assert "Mean cost 1.50" in shown.summary()
