"""The personal room: other pictures for each student, with the same number for all right detectors."""

import numpy as np
import pytest

from nao_course._internal.personal_world import PersonalWorld
from nao_course.lessons.experiments.personal import BEST, personal_costs, personal_numbers, personal_scenes
from nao_course.lessons.experiments.scenes import nothing_costs, simulated_scene


@pytest.mark.slow
def test_students_have_different_pictures_and_none_of_the_lessons():
    scenes = [personal_scenes(PersonalWorld(name), 2) for name in ("ada", "bob")]
    pictures = [picture for of in scenes for picture, _ in of] + [simulated_scene(n)[0] for n in range(2)]
    for i, picture in enumerate(pictures):
        assert not any(np.array_equal(picture, other) for other in pictures[:i])
    simulated_scene.cache_clear()
    again = personal_scenes(PersonalWorld("ada"), 2)
    assert all(np.array_equal(one[0], other[0]) for one, other in zip(scenes[0], again, strict=True))


def corners_everywhere(scenes, betas, gaps, lengths):
    """Return a table in which each picture costs as many as it has corners, less one."""
    costs = np.array([len(corners) - 1.0 for _, corners in scenes])
    return {(beta, gap, length): costs for beta in betas for gap in gaps for length in lengths}


def constant(values, probability, rng):
    return values.min(), values.max()


@pytest.mark.slow
def test_the_table_has_the_baseline_and_each_setting_with_its_interval_and_so_have_the_markers_numbers():
    world = PersonalWorld("ada")
    shown = str(personal_costs(world, [BEST, (110, 4, 30)], corners_everywhere, constant))
    baseline = nothing_costs(personal_scenes(world))
    rows = [line.split() for line in shown.splitlines()[1:]]
    for row, words, costs in (
        (rows[0], ["reporting", "nothing"], baseline),
        (rows[1], ["120,", "7,", "50"], baseline - 1),
        (rows[2], ["110,", "4,", "30"], baseline - 1),
    ):
        assert row == [*words, f"{costs.mean():.2f}", f"{costs.min():.2f}", "to", f"{costs.max():.2f}"]
    assert "room of ada" in shown
    numbers = personal_numbers(world, corners_everywhere)
    assert list(numbers.values()) == pytest.approx([baseline.mean(), baseline.mean() - 1])
