"""Light, lens and sensor: what each colour channel loses, and in which direction a moving picture is blurred."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, Field, Reality
from nao_course.sim.light import Lamps, develop
from nao_course.sim.shapes import Eye

CLEAN = Reality.clean()
VIEW = NAO_V4.view("bottom", pitch=float(np.radians(-31.0)), size=(320, 240))
GREY = np.full((240, 320, 3), 0.25, dtype=np.float32)


def lamps(**effects):
    return Lamps(Field(), Eye(Pose(), VIEW), replace(CLEAN, **effects))


def test_each_channel_loses_its_part_towards_the_corners_and_in_the_pile_and_noise_is_strongest_in_blue():
    middle, corner = lamps(vignette=0.3).at(np.array([120 * 320 + 160, 0]))
    assert middle == pytest.approx(1.0, abs=0.01)
    assert corner[0] < corner[1] - 0.05 < corner[2] - 0.1
    light = GREY.copy()
    lamps(pile=1.0).light_ground(light)
    far, near = light[40, 160], light[-1, 160]
    assert near[0] < near[2] < near[1] < far[1]
    noisy = develop(GREY, Eye(Pose(), VIEW), replace(CLEAN, noise=8.0), np.random.default_rng(0))
    red, green, blue = noisy.reshape(-1, 3).std(axis=0)
    assert green + 1 < red < blue - 0.5
    assert (red + green + blue) / 3 == pytest.approx(8.0, rel=0.03)


@pytest.mark.parametrize(("about_left", "about_up"), [(0.1, 0.1), (0.1, -0.1), (-0.1, 0.1)])
def test_a_point_is_smeared_in_the_direction_in_which_it_moves_through_the_picture(about_left, about_up):
    view = NAO_V4.view("top", size=(320, 240))
    light = np.zeros((240, 320, 3), dtype=np.float32)
    light[120, 160] = 1.0
    turning = np.array([0.0, about_left, about_up])
    rows, columns = np.nonzero(develop(light, Eye(Pose(), view, turning), CLEAN, None)[..., 0])
    point = [[2.0, 0.0, view.height]]
    later = replace(view, pitch=view.pitch + about_left / 100, yaw=view.yaw + about_up / 100)
    right, down = (later.project(point) - view.project(point))[0]
    assert np.ptp(columns) > 3 and np.ptp(rows) > 3
    assert np.polyfit(columns, rows, 1)[0] == pytest.approx(down / right, rel=0.15)


def test_exposure_is_automatic_in_its_part_and_glare_shines_on_the_ground_and_white_balance_keeps_the_light():
    dark = GREY * 0.3
    parts = [replace(CLEAN, exposure=part) for part in (0, 0.5, 1)]
    means = [develop(dark, Eye(Pose(), VIEW), part, None).mean() for part in parts]
    assert means[2] == pytest.approx(117, abs=2)
    assert means[1] == pytest.approx(np.sqrt(means[0] * means[2]), rel=0.02)
    for seed in range(4):
        light = np.zeros_like(GREY)
        view = NAO_V4.view("top", size=(320, 240))  # the horizon is at row 119
        effects = replace(CLEAN, glare=1.0, seed=seed)
        Lamps(Field(), Eye(Pose(), view), effects).light_ground(light)
        assert light[:100].max() == 0
        assert light[130:].max() > 0
    gains = [lamps(white_balance=0.1, seed=seed).at(np.array([0]))[0] for seed in range(5)]
    assert np.allclose(np.mean(gains, axis=1), 1, atol=1e-6)
    assert np.std(gains, axis=1).min() > 0.003
