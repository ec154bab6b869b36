"""The equations that the lessons display, each held against the solution that the lesson builds on it."""

from fractions import Fraction

import numpy as np
import pytest

from tests.lessons.every import own

HSL = own("01")


def exact_hsl(pixel):
    """Lightness, saturation and hue of a pixel in fractions, read off the lesson's three equations."""
    r, g, b = (Fraction(int(channel), 255) for channel in pixel)
    most, least = max(r, g, b), min(r, g, b)
    lightness = 255 * (most + least) / 2
    if most == least:
        return lightness, Fraction(0), Fraction(0)
    saturation = (most - least) / (1 - abs(most + least - 1))
    cases = {r: (g - b) / (most - least), g: 2 + (b - r) / (most - least), b: 4 + (r - g) / (most - least)}
    hue = 60 * next(cases[channel] for channel in (r, g, b) if channel == most) % 360
    return lightness, saturation, hue


@pytest.mark.asserts("eq-1-1", "eq-1-2", "eq-1-3")
def test_hue_saturation_and_lightness_are_the_lessons_fractions_and_its_worked_example_is_right(rng):
    picture = rng.integers(0, 256, (12, 12, 3)).astype(np.uint8)
    picture[0] = picture[0, :, :1]  # greys
    picture[1, :3] = np.eye(3) * 255
    picture[2, 0] = 60, 130, 70
    hue, saturation, lightness = HSL["rgb_to_hsl"](picture)
    wanted = np.array([[[float(v) for v in exact_hsl(p)] for p in row] for row in picture])
    assert np.allclose(np.stack([lightness, saturation, hue], axis=2), wanted)
    found = np.round([hue[2, 0], lightness[2, 0], saturation[2, 0]], 2)
    assert found.tolist() == pytest.approx([128.57, 95, 0.37])


@pytest.mark.asserts("eq-1-4")
def test_the_threshold_for_white_climbs_from_beta_to_the_maximum_in_a_straight_line(rng):
    for beta, most in rng.uniform((90, 200), (150, 255), (20, 2)):
        at = [HSL["white_threshold"](share * most, beta, most) for share in (0.0, 0.5, 1.0)]
        assert np.allclose(at, [beta, (beta + most) / 2, most])


@pytest.mark.asserts("eq-1-6", "eq-1-7")
def test_an_interval_of_hues_holds_both_its_limits_and_nothing_beyond(rng):
    for low, width in rng.integers((0, 1), (360, 300), (40, 2)):
        inside = (low + np.arange(width + 1)) % 360
        outside = np.setdiff1d(np.arange(360), inside)
        limits = float(low), float((low + width) % 360)
        assert HSL["hue_mask"](inside.astype(float), *limits).all()
        assert not HSL["hue_mask"](outside.astype(float), *limits).any()


@pytest.mark.asserts("eq-1-5")
def test_at_the_factor_of_the_light_that_the_equation_gives_a_lightness_is_its_own_threshold():
    for lightness, mean in ((255.0, 119.3), (152.0, 119.3), (200.0, 60.0)):
        factor = 120 / (lightness - (255 - 120) * mean / 255)
        assert np.isclose(HSL["white_threshold"](factor * mean), factor * lightness)
