"""Scenes to search on: pairs that nobody can paint on, counted while somebody goes through them."""

from itertools import product

import numpy as np
import pytest

from nao_course.exercises import try_out
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.lessons.experiments import scenes
from nao_course.lessons.experiments.paper_table import SETTINGS
from nao_course.lessons.experiments.reading import recorded_means
from nao_course.lessons.experiments.scenes import (
    nothing_costs,
    real_scenes,
    search_scenes,
    simulated_scene,
    simulated_scenes,
)
from nao_course.sim.scenes import standard_scene
from tests.lessons.every import blank

PAIRS = [(np.zeros((4, 5, 3), np.uint8), np.zeros((k, 2))) for k in (2, 0, 3)]


def test_a_scene_is_that_of_the_standard_set_and_read_only_and_nothing_costs_one_for_each_corner():
    picture, corners = simulated_scene(3, size=(64, 48))
    assert (picture == standard_scene("tune", 3, (64, 48)).pixels).all() and corners.shape[1] == 2
    assert simulated_scene(3, size=(64, 48))[0] is picture, "it is made once"
    with pytest.raises(ValueError, match="read-only"):
        picture[0] = 0
    assert nothing_costs(PAIRS).tolist() == [2.0, 0.0, 3.0]


def test_a_search_counts_each_scene_once_however_often_the_students_loops_go_through_them(monkeypatch):
    """A bar that counted what is taken from a list ran backwards with a loop over settings outside."""
    counted = []

    class Counts(scenes.Progress):
        def step(self):
            super().step()
            counted.append(self.done)

    monkeypatch.setattr(scenes, "Progress", Counts)

    def settings_outside(pairs, betas, gaps, lengths):
        settings = product(betas, gaps, lengths)
        return {setting: [len(corners) + setting[0] for _, corners in pairs] for setting in settings}

    table = search_scenes(settings_outside, PAIRS)
    assert counted == [1, 2, 3] and set(table) == set(SETTINGS)
    assert table[120, 5, 40].tolist() == [122, 120, 123] and next(iter(table))[0] == 110


def test_an_unwritten_search_shows_no_bar_and_without_the_recordings_there_are_no_real_scenes(monkeypatch):
    def nowhere(name):
        raise FileNotFoundError("not here")

    monkeypatch.setattr(scenes, "Progress", None)
    assert "Finish it" in repr(try_out(lambda: search_scenes(blank, PAIRS), "Finish it."))
    monkeypatch.setattr(scenes, "read_pictures", nowhere)
    assert real_scenes("scenes") == ()


def test_real_scenes_have_the_corners_that_were_marked(data_dir, monkeypatch):
    monkeypatch.setenv("NAO_COURSE_DATA", str(data_dir))
    found = real_scenes("straightwalk")
    assert len(found) == 30 and nothing_costs(found).sum() == 94


def test_without_lesson_03_the_table_is_the_solutions_and_a_note_says_so(capsys):
    def grid_search(scenes, betas, gaps, lengths):
        raise EarlierNotUsable("find_corners of your lesson 03 is not usable yet.")

    table = search_scenes(grid_search, simulated_scenes())
    assert "is not usable yet. The table is therefore our solution's" in capsys.readouterr().out
    means = recorded_means("320 x 240, the same pixels")
    assert all(costs.mean() == pytest.approx(means[setting], abs=1e-4) for setting, costs in table.items())
    with pytest.raises(EarlierNotUsable):
        search_scenes(grid_search, PAIRS)
