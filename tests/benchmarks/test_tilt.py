"""Lines of the field tell the tilt: exactly where they are exact, with honest doubt where they cannot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.challenges.tilt import PITCH_SD, align, tilt_from_lines, to_ground
from benchmarks.pictures.tilt import Tilts, simulated
from nao_course.sim import NAO_V4, Reality
from nao_course.sim.scenes import random_scene

VIEW = NAO_V4.view("bottom", 0.0, float(np.radians(-24.6)))
# On the ground, metres ahead and to the left: a box's front and sides, and a line far behind it.
BOX = np.array([(1.2, -0.8, 1.2, 0.6), (1.2, 0.6, 2.4, 0.6), (1.2, -0.8, 2.4, -0.8), (2.8, -1.2, 2.8, 1.3)])


def turned(lines, angle):
    """Lines (N, 4) on the ground, turned about a point two metres ahead."""
    c, s = np.cos(angle), np.sin(angle)
    points = (lines.reshape(-1, 2) - (2.0, 0.0)) @ np.array([(c, s), (-s, c)]) + (2.0, 0.0)
    return points.reshape(-1, 4)


def seen(lines, view):
    """The same in a picture without the lens."""
    straight = replace(view, k1=0.0, offset=(0.0, 0.0), yaw=0.0)
    return straight.project(lines.reshape(-1, 2)).reshape(-1, 4)


def leant(pitch, roll):
    return replace(VIEW, pitch=VIEW.pitch + np.radians(pitch), roll=VIEW.roll + np.radians(roll))


@pytest.mark.parametrize("angle", [-0.6, -0.2, 0.0, 0.3, 0.7])
@pytest.mark.parametrize(("pitch", "roll"), [(0.0, 0.0), (1.5, 0.0), (-1.5, 0.5), (0.5, -1.0), (2.5, 0.3)])
def test_exact_lines_give_the_exact_tilt_and_say_that_they_are_sure(pitch, roll, angle):
    true = leant(pitch, roll)
    found_pitch, found_roll, sigma = tilt_from_lines(seen(turned(BOX, angle), true), VIEW)
    # The prior pulls a little towards no lean.
    assert np.degrees(found_pitch - true.pitch) == pytest.approx(0, abs=0.15)
    assert np.degrees(found_roll - true.roll) == pytest.approx(0, abs=0.25)
    assert sigma < np.radians(0.5)


@pytest.mark.parametrize("angle", [-0.6, 0.1, 0.7, 1.2])
def test_the_direction_of_the_lines_is_a_compass_modulo_ninety_degrees(angle):
    found = align(seen(turned(BOX, angle), leant(1.0, 0.4)), VIEW)
    away = (found.heading - angle + np.pi / 4) % (np.pi / 2) - np.pi / 4
    assert np.degrees(away) == pytest.approx(0, abs=0.3)


@pytest.mark.parametrize(
    "lines",
    [
        np.zeros((0, 4)),
        BOX[:1],  # one line
        BOX[[0, 3]],  # both across the view: parallel in the picture whatever the pitch
        turned(BOX[:1] * (1, 0.05, 1, 0.05), 0.4),  # a short one
    ],
    ids=["none", "one", "parallel", "short"],
)
def test_where_lines_cannot_tell_the_answer_is_the_prior(lines):
    pitch, roll, sigma = tilt_from_lines(seen(lines, VIEW), VIEW)
    assert np.degrees(pitch - VIEW.pitch) == pytest.approx(0, abs=0.3)
    assert np.degrees(roll - VIEW.roll) == pytest.approx(0, abs=0.3)
    assert 0.7 * PITCH_SD < sigma <= 1.05 * PITCH_SD


def test_a_line_that_is_none_of_the_field_s_pulls_little():
    cable = np.array([(1.4, -0.5, 2.2, 0.3)])  # at 45 degrees
    true = leant(1.2, 0.0)
    pitch, _, _ = tilt_from_lines(seen(np.vstack([BOX, cable]), true), VIEW)
    assert np.degrees(pitch - true.pitch) == pytest.approx(0, abs=0.25)


def test_sigma_says_how_far_noisy_lines_are_off():
    rng, ratios = np.random.default_rng(0), []
    for _ in range(60):
        true = leant(*rng.normal(0, (1.3, 0.8)))
        lines = seen(turned(BOX, rng.uniform(-0.7, 0.7)), true) + rng.normal(0, 0.25, BOX.shape)
        pitch, _, sigma = tilt_from_lines(lines, VIEW)
        ratios.append((pitch - true.pitch) / sigma)
    assert 0.5 < np.sqrt(np.mean(np.square(ratios))) < 1.4


def test_the_order_of_lines_and_of_their_ends_does_not_matter():
    lines = seen(turned(BOX, 0.3), leant(1.0, 0.3))
    one = tilt_from_lines(lines, VIEW)
    assert tilt_from_lines(lines[::-1], VIEW) == pytest.approx(one, abs=5e-5)
    assert tilt_from_lines(lines[:, [2, 3, 0, 1]], VIEW) == pytest.approx(one, abs=5e-5)


@pytest.mark.parametrize("pitch", [-1.5, -0.5, 0.0, 0.2, 1.5, np.pi / 2])
@pytest.mark.filterwarnings("error")
def test_lines_at_and_above_the_horizon_are_no_lines_on_the_ground(pitch):
    lines = seen(BOX, VIEW)
    found = tilt_from_lines(lines, replace(VIEW, pitch=float(pitch)))
    assert np.isfinite(found).all()
    assert tilt_from_lines(np.zeros((3, 4)), VIEW)[2] == pytest.approx(PITCH_SD)


@pytest.mark.parametrize(
    "segments", [np.zeros(4), np.zeros((2, 3)), [[np.nan, 0, 1, 1]], [[0, 0, np.inf, 1]]]
)
def test_what_are_no_segments_is_refused(segments):
    with pytest.raises(ValueError, match=r"segments must be finite numbers \(N, 4\)"):
        tilt_from_lines(segments, VIEW)


def test_the_ground_is_where_the_camera_sees_it():
    view = replace(VIEW, k1=0.0, roll=0.02)
    points = np.array([(0.8, 0.3), (2.0, -0.5), (4.0, 1.0)])
    level = replace(view, offset=(0.0, 0.0), yaw=0.0)
    np.testing.assert_allclose(to_ground(level.project(points), view), points, atol=1e-9)
    assert np.isnan(to_ground(np.array([(160.0, -400.0)]), view)).all()
    assert to_ground(level.project(points), view, np.zeros((2, 5)), 0.0).shape == (2, 5, 3, 2)


def test_pictures_of_a_laboratory_tell_their_tilt():
    scenes = [random_scene((320, 240), Reality.lab(40), np.random.default_rng([41, i])) for i in range(12)]
    found = Tilts.of(simulated(scenes)).summary()
    assert found["pitch rms after"] < found["pitch rms before"]
    assert found["share sure"] >= 0.3
    assert found["pitch rms where sure"] < 0.5
    assert found["within 2 sigma"] >= 0.8
