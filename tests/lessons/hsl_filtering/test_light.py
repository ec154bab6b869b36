"""Light in lesson 01: a factor of it, where it breaks the threshold, and what figures say of that."""

from functools import partial

import cv2
import numpy as np
import pytest

from nao_course.exercises import judging
from nao_course.exercises.running import call_all
from nao_course.geometry import Pose
from nao_course.instructor.authoring.plans import hidden_cases
from nao_course.lessons.hsl_filtering import crossing, draw_light_limits, draw_lightness, in_light
from nao_course.lessons.hsl_filtering.light import BINS, lightness_counts
from nao_course.lessons.hsl_filtering.payoff import LIGHTS, draw_payoff, payoff_scene
from nao_course.sim import Field, SimulatedNao, Truth
from tests.drawings import assert_same_bytes_with_words
from tests.lessons.every import COURSE, blank, own

HSL = own("01")


def test_in_a_light_of_one_a_picture_is_the_same_and_a_level_is_crossed_at_the_first_factor_or_never(rng):
    picture = rng.integers(0, 256, (7, 9, 3), dtype=np.uint8)
    assert np.array_equal(in_light(picture, 1.0), picture)
    assert not in_light(picture, 0.0).any()
    twice = in_light(in_light(picture, 0.8), 0.5).astype(int)
    assert np.abs(twice - in_light(picture, 0.4)).max() <= 1
    assert in_light(np.full((1, 1, 3), 150, dtype=np.uint8), 2.0).tolist() == [[[255, 255, 255]]]
    for wrong in (-0.1, float("nan")):
        with pytest.raises(ValueError, match="factor must be at least 0"):
            in_light(picture, wrong)
    assert crossing([1.0, 2.0, 3.0], [0.0, 0.25, 0.75]) == 2.5
    assert crossing([1.0, 2.0, 3.0], [0.6, 0.2, 0.9]) == 1.0
    assert np.isnan(crossing([1.0, 2.0], [0.0, 0.4]))


def test_the_lines_are_lost_where_the_formula_says_and_half_of_the_carpet_turns_white_a_little_early():
    """As the lesson measures it, on another scene than the lesson's."""
    scene, labels = payoff_scene()
    lightness = HSL["rgb_to_hsl"](scene)[2]
    room = 135 * lightness.mean() / 255
    limits = [120 / (level - room) for level in (255.0, float(np.median(lightness[labels == 1])))]
    factors = np.linspace(0.4, 1.6, 49)
    found, false = [], []
    for factor in factors:
        lit = HSL["rgb_to_hsl"](in_light(scene, factor))[2]
        white = lit > HSL["white_threshold"](lit.mean())
        found.append(white[labels == 3].mean())
        false.append(white[labels == 1].mean())
    assert abs(crossing(factors, found) - limits[0]) < 0.04
    assert limits[1] - 0.12 < crossing(factors, false) <= limits[1]
    drawing = draw_light_limits(factors, found, false, dark=limits[0], bright=limits[1])
    assert f"Half of the lines are found from {crossing(factors, found):.2f} on." in drawing.alt
    assert f"The limits by equation 1.5 are {limits[0]:.2f} and {limits[1]:.2f}." in drawing.alt


@pytest.mark.slow
def test_lightnesses_are_counted_by_what_pixels_are_and_figures_say_their_numbers(rng):
    lightness, labels = rng.uniform(0, 255, (30, 40)), rng.integers(0, 4, (30, 40))
    lightness[0, 0], labels[0, 0] = 255.0, 3
    counts = lightness_counts(lightness, labels)
    assert counts.shape == (4, BINS) and counts[3, -1] > 0
    for label in range(4):
        wanted, _ = np.histogram(lightness[labels == label], bins=BINS, range=(0, 256))
        assert np.array_equal(counts[label], wanted)
    marks = {"beta": 120.0, "mean": 100.0, "threshold": 173.0}
    assert_same_bytes_with_words(lambda: draw_lightness(lightness, labels, **marks))
    alt = draw_lightness(lightness, labels, **marks).alt
    assert "beta 120, mean 100, threshold 173" in alt
    assert f"{(lightness[labels == 3] > 173).mean():.0%} of white" in alt
    with pytest.raises(ValueError, match="one shape"):
        draw_lightness(lightness, labels[1:], **marks)
    for factors, recall in (([1.0, 1.0], [0.0, 1.0]), ([1.0, 2.0], [0.0])):
        with pytest.raises(ValueError, match="factors must grow"):
            draw_light_limits(factors, recall, [0.0, 0.0])


def test_the_payoff_is_drawn_by_the_students_functions_and_says_which_lines_are_found():
    names = "rgb_to_hsl average_lightness white_threshold hue_mask color_labels calibrate_hue"
    functions = {name: HSL[name] for name in names.split()}
    assert draw_payoff(**functions).alt.count("100%") == len(LIGHTS)

    def blind(picture, *_):
        return np.zeros(picture.shape[:2], dtype=np.uint8)

    assert draw_payoff(**functions | {"color_labels": blind}).alt.count(" 0%") == len(LIGHTS)
    with pytest.raises(NotImplementedError):
        draw_payoff(**functions | {"calibrate_hue": blank})


def scene_of_the_lesson():
    """Return the picture and its true labels."""
    nao = SimulatedNao(Field(2012), Pose(0.6, 0.5, -0.25), rng=41)
    return nao.take_picture("bottom").pixels, Truth(nao).picture.labels


def test_the_carpet_is_as_bright_as_the_lesson_says_at_its_three_pixels_and_in_the_glare():
    picture, labels = scene_of_the_lesson()
    hue, _, lightness = HSL["rgb_to_hsl"](picture)
    carpet, darker, _ = pixels = (159, 1), (237, 50), (129, 319)
    bright, dark, white = (picture[each].astype(int) for each in pixels)
    assert (np.abs(bright - white) < np.abs(bright - dark)).all()
    assert hue[carpet] == pytest.approx(135) and hue[darker] == pytest.approx(135)
    threshold = HSL["white_threshold"](HSL["average_lightness"](lightness, 1000, np.random.default_rng(0)))
    found = HSL["color_labels"](picture, (109.0, 144.0), (58.0, 62.0), threshold)
    assert [found[each] for each in pixels] == [labels[each] for each in pixels] == [1, 1, 3]
    parts = [(labels[found == 3] == each).mean() for each in (0, 1)]
    assert 0.5 < parts[0] < 0.55 and 0.29 < parts[1] < 1 / 3


def test_epsilon_widens_the_limits_of_green_and_would_widen_those_of_yellow_as_lesson_01_says():
    picture, labels = scene_of_the_lesson()
    hue, saturation, _ = HSL["rgb_to_hsl"](picture)
    goal = cv2.erode((labels == 2).astype(np.uint8), np.ones((5, 5))) > 0
    assert goal.sum() == 1724
    for example, of, epsilon, part in (
        (np.s_[200:, 100:220], 1, 0.0, 0.78),
        (np.s_[200:, 100:220], 1, 10.0, 0.97),
        (goal, 2, 0.0, 0.89),
        (goal, 2, 5.0, 0.99),
    ):
        limits = HSL["calibrate_hue"](hue[example], saturation[example], epsilon)
        assert HSL["hue_mask"](hue[labels == of], *limits).mean() == pytest.approx(part, abs=0.006)


@pytest.mark.parametrize("seed", range(3))
def test_a_mean_with_noise_loses_the_case_of_two_pixels_also_if_it_samples_single_pixels(seed):
    exercise = COURSE.plan("01_hsl_filtering")["average_lightness"]
    cases = hidden_cases(exercise, HSL[exercise.name], seed)

    def with_noise(lightness, n_samples, rng):
        if n_samples == 1:
            return float(rng.choice(lightness.ravel()))
        return lightness.mean() + rng.normal(0, lightness.std() / np.sqrt(n_samples))

    def verdicts(function):
        answer = partial(judging.answer, exercise.comparison)
        outcomes = call_all(function, cases, exercise.driver, 30, answer)
        return [bool(judging.judge(exercise.comparison, *each)) for each in zip(cases, outcomes, strict=True)]

    assert all(verdicts(HSL["average_lightness"]))
    assert verdicts(with_noise) == [True, True, True, False, True]
