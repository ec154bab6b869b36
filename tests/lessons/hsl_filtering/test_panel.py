"""The filter panel: settings reach the student's code, its errors become sentences, its labels become numbers."""

import colorsys
import html
import time

import numpy as np
import pytest

from nao_course.lessons.hsl_filtering import FilterPanel, in_light
from nao_course.lessons.hsl_filtering.instruments import (
    BOTTOM,
    CENTRE,
    LEFT,
    OUTER,
    PIXEL,
    RIGHT,
    TOP,
    circle_picture,
    histogram_picture,
    hue_counts,
)
from nao_course.lessons.hsl_filtering.light import BINS, MARKS
from nao_course.lessons.hsl_filtering.scores import ERROR_COLOURS
from nao_course.plotting import LABEL_COLOURS
from tests.widgets.robots import decoded

GREEN, YELLOW = (105.0, 150.0), (45.0, 60.0)


def scene(rng, size=(24, 32)):
    """A picture of noise, and labels that its colours do not explain."""
    return rng.integers(0, 256, (*size, 3), dtype=np.uint8), rng.integers(0, 4, size, dtype=np.uint8)


def brightness(picture, green, yellow, beta, min_saturation):
    """Labels that depend on beta and on nothing else."""
    grey = picture.mean(axis=2)
    return np.select([grey > beta, grey > beta / 2, grey > beta / 3], [3, 2, 1], 0).astype(np.uint8)


def make(rng, label=brightness, **options):
    picture, truth = scene(rng)
    return FilterPanel(picture, truth, label, **{"green": GREEN, "yellow": YELLOW, **options})


def blank_filter_panel():
    return make(np.random.default_rng(0), calibrate=lambda *given: (1.0, 2.0), examples={"green": np.s_[:4]})


def colour(text):
    return tuple(int(text[i : i + 2], 16) for i in (1, 3, 5))


# --- settings ---


def test_every_slider_reaches_the_students_function(rng):
    got = []
    panel = make(rng, lambda *arguments: got.append(arguments[1:]) or brightness(*arguments))
    assert got == [(GREEN, YELLOW, 120.0, 0.16)]
    for name, value in {
        "green low": 100.0,
        "green high": 20.0,
        "yellow low": 350.0,
        "yellow high": 70.0,
        "beta": 33.0,
        "min_saturation": 0.5,
    }.items():
        panel._widgets[name.replace(" ", "_")].value = value
    assert got[-1] == ((100.0, 20.0), (350.0, 70.0), 33.0, 0.5)
    assert len(got) == 7


def test_settings_are_what_a_browser_would_round_them_to(rng):
    panel = make(rng, green=(114.3, 359.7), beta=99.6, min_saturation=0.1649)
    assert panel.settings.green == (114.0, 359.0)
    assert (panel.settings.beta, panel.settings.min_saturation) == (100.0, 0.16)
    assert panel._widgets["green_low"].value == 114.0


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"green": (0, 360)}, "green must be two hues in degrees"),
        ({"yellow": 5}, "yellow must be two hues"),
        ({"green": (float("nan"), 1)}, "green must be two hues"),
        ({"beta": 256}, "beta must be from 0 to 255, got 256"),
        ({"min_saturation": -0.1}, "min_saturation must be from 0 to 1"),
        ({"light": 0.2}, "light must be from 0.3 to 1.6, got 0.2"),
    ],
)
def test_what_no_slider_can_show_is_refused(rng, settings, said):
    panel = make(rng)
    with pytest.raises(ValueError, match=said):
        panel.set(**settings)
    assert panel.settings.green == GREEN
    if "light" not in settings:  # it begins at 1
        with pytest.raises(ValueError, match=said):
            make(rng, **settings)


def test_pictures_and_labels_that_do_not_fit_are_refused(rng):
    picture, truth = scene(rng)
    options = {"green": GREEN, "yellow": YELLOW}
    with pytest.raises(ValueError, match=r"picture must be uint8 of shape \(H, W, 3\), got float64"):
        FilterPanel(picture / 255, truth, brightness, **options)
    with pytest.raises(ValueError, match="truth must have the picture's shape"):
        FilterPanel(picture, truth[1:], brightness, **options)
    with pytest.raises(ValueError, match="label must be a function"):
        FilterPanel(picture, truth, truth, **options)
    with pytest.raises(ValueError, match="of the same names"):
        FilterPanel({"a": picture}, {"b": truth}, brightness, **options)


# --- numbers ---


def test_scores_are_those_of_counting_pixel_by_pixel(rng):
    panel = make(rng, beta=150)
    truth = panel._scene[1]
    for label, name in enumerate(("green", "yellow", "white"), start=1):
        pairs = list(zip(panel.labels.ravel().tolist(), truth.ravel().tolist(), strict=True))
        both = sum(a == b == label for a, b in pairs)
        precision, recall = (both / sum(pair[i] == label for pair in pairs) for i in (0, 1))
        assert panel.scores[name].precision == pytest.approx(precision)
        assert panel.scores[name].recall == pytest.approx(recall)
        words = f"{name}: precision {100 * precision:.1f} %, recall {100 * recall:.1f} %"
        assert words in panel.summary()
        assert f"<td>{100 * precision:.1f} %</td><td>{100 * recall:.1f} %</td>" in panel._table.value


def test_a_colour_that_is_nowhere_has_no_score(rng):
    panel = make(rng, lambda picture, *_: np.zeros(picture.shape[:2], int))
    assert "white: precision -, recall 0.0 %" in panel.summary()


# --- pictures ---


def test_labels_keep_their_colours_to_the_pixel(rng):
    panel = make(rng)
    wanted = np.array([colour(each) for each in LABEL_COLOURS])
    assert np.array_equal(decoded(panel._row.places[1].image), wanted[panel.labels])
    panel._widgets["shown"].value = "True labels"
    assert np.array_equal(decoded(panel._row.places[1].image), wanted[panel._scene[1]])


def test_errors_of_white_are_where_labels_and_truth_differ_in_white(rng):
    calls = []
    panel = make(rng, lambda *arguments: calls.append(1) or brightness(*arguments))
    panel._widgets["shown"].value = "Errors in white"
    right, wrong, missed, _ = (
        (decoded(panel._row.places[1].image) == colour(each)).all(axis=2) for each in ERROR_COLOURS
    )
    called, there = panel.labels == 3, panel._scene[1] == 3
    assert np.array_equal(right, called & there)
    assert np.array_equal(wrong, called & ~there)
    assert np.array_equal(missed, ~called & there)
    assert "wrongly labelled white" in panel._legend.value
    assert "Your code" in panel._status.value
    assert len(calls) == 1


def test_another_scene_is_labelled_with_the_same_settings(rng):
    (day, truth), (night, _) = scene(rng), scene(rng)
    panel = FilterPanel({"day": day, "night": night // 3}, truth, brightness, green=GREEN, yellow=YELLOW)
    assert panel.summary().startswith("scene: day\n")
    before, picture = panel.summary(), panel._row.places[0].image.value
    panel._widgets["scene"].value = "night"
    assert panel._row.places[0].image.value != picture
    assert np.array_equal(panel.labels, brightness(night // 3, GREEN, YELLOW, 120, 0.16))
    assert panel.summary() != before


# --- light and hue ---


def test_in_another_light_the_student_gets_another_picture_and_histogram_and_threshold_follow(rng):
    got = []
    panel = make(
        rng,
        lambda *arguments: got.append(arguments[0]) or brightness(*arguments),
        threshold=lambda mean, beta: mean + beta / 10,
    )
    picture = panel._scene[0]
    mean = float(panel.summary().split("Mean lightness ")[1].split(".")[0])
    before = decoded(panel._small_row.places[0].image)
    panel.set(light=0.5)
    assert np.array_equal(got[-1], in_light(picture, 0.5))
    darker = float(panel.summary().split("Mean lightness ")[1].split(".")[0])
    assert darker == pytest.approx(mean / 2, abs=1.5)
    assert f"Threshold {darker + 12:.0f}." in panel.summary()
    assert not np.array_equal(decoded(panel._small_row.places[0].image), before)


def test_a_histogram_stands_upright_over_its_lightnesses_with_each_mark_where_it_belongs():
    counts = np.zeros((4, BINS), dtype=int)
    counts[1, 20], counts[3, 20], counts[0, 40] = 100, 100, 200
    picture = histogram_picture(counts, {"threshold": 128.0})
    column = {k: round(LEFT + (RIGHT - LEFT) * (k + 0.5) / BINS) for k in (20, 40)}
    height = (BOTTOM - TOP) / 1.15
    assert tuple(picture[BOTTOM - 20, column[20]]) == colour(LABEL_COLOURS[1])
    assert tuple(picture[int(BOTTOM - 0.75 * height), column[20]]) == colour(LABEL_COLOURS[3])
    assert tuple(picture[int(BOTTOM - 0.75 * height), column[40]]) == colour(LABEL_COLOURS[0])
    middle = (LEFT + RIGHT) // 2
    assert tuple(picture[TOP + 2, middle]) == colour(MARKS["threshold"][0])


def test_a_hue_is_on_the_circle_where_its_angle_says_and_its_arc_goes_from_low_to_high():
    hue = np.full((3, 3), 91.0, dtype=np.float32)
    everywhere = np.ones((3, 3), dtype=bool)
    picture = circle_picture(hue_counts(hue, everywhere), {LABEL_COLOURS[2]: (350.0, 20.0)}, pixel=180.0)
    (u, v), blank = CENTRE, circle_picture(hue_counts(hue, ~everywhere), {})
    painted = (picture != blank).any(axis=2)
    assert painted[v - OUTER + 3, u - 2] and not painted[v + OUTER - 3, u]  # 90 degrees are up
    assert painted[v, u - OUTER] and tuple(picture[v, u - OUTER]) == colour(PIXEL)
    assert tuple(picture[v - 5, u + OUTER + 7]) == colour(LABEL_COLOURS[2])
    assert not painted[v + 60, u + OUTER // 2 + 30]


def test_a_pixel_that_is_added_to_an_example_is_calibrated_with_and_the_sliders_jump(rng):
    got = []

    def calibrate(hue, saturation, epsilon):
        got.append((hue.copy(), saturation.copy(), epsilon))
        return 100.2, 199.8

    panel = make(rng, calibrate=calibrate, examples={"green": np.s_[:2, :3], "yellow": np.s_[5:6, 5:6]})
    panel.set(pixel=(7, 9), light=0.8)
    hue, saturation, _ = panel.chosen_pixel
    red, green, blue = in_light(panel._scene[0], 0.8)[9, 7] / 255.0
    wanted = colorsys.rgb_to_hls(red, green, blue)
    assert (hue / 360, saturation) == pytest.approx((wanted[0], wanted[2]), abs=1e-4)
    panel.add("green")
    assert len(got[-1][0]) == 7 and (got[-1][0][-1], got[-1][1][-1]) == pytest.approx((hue, saturation))
    assert got[-1][2] == 10.0
    assert panel.settings.green == (100.0, 200.0) and panel.settings.yellow == YELLOW
    assert panel._widgets["green_low"].value == 100.0
    panel._widgets["to_yellow"].click()
    assert len(got[-1][0]) == 2 and got[-1][2] == 0.0 and panel.settings.yellow == (100.0, 200.0)
    panel.reset()
    panel.add("green")
    assert len(got[-1][0]) == 7


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (NotImplementedError(), "Finish exercise 1.6 to calibrate with this pixel."),
        (IndexError("too far"), "IndexError in calibrate_hue(), line"),
    ],
)
def test_a_calibration_that_fails_is_a_sentence_and_the_pixel_is_not_in_the_example(rng, error, said):
    def calibrate(hue, saturation, epsilon):
        if len(hue) > 6:
            raise error
        return 1.0, 2.0

    panel = make(rng, calibrate=calibrate, examples={"green": np.s_[:2, :3]})
    panel._widgets["to_green"].click()
    assert said in html.unescape(panel._status.value)
    assert panel.settings.green == GREEN and panel._added == []
    panel.set(beta=90)
    assert said not in html.unescape(panel._status.value)
    with pytest.raises(ValueError, match="colour must be one of .*, got 'yellow'"):
        panel.add("yellow")


def test_a_pixel_is_chosen_without_asking_the_filter_again_and_a_grey_one_has_no_hue(rng):
    calls = []
    picture, truth = scene(rng)
    picture[3, 4] = 77
    panel = FilterPanel(
        picture,
        truth,
        lambda *arguments: calls.append(1) or brightness(*arguments),
        green=GREEN,
        yellow=YELLOW,
    )
    panel.set(pixel=(4, 3))
    assert "The pixel (4, 3) has lightness 77 and is grey: it has no hue." in panel.summary()
    assert len(calls) == 1


# --- the student's code ---


@pytest.mark.parametrize(
    ("returned", "said"),
    [
        (np.zeros((32, 24), np.uint8), "must have shape (24, 32), one for each pixel; got (32, 24)"),
        (None, "must have shape (24, 32), one for each pixel; got ()"),
        (np.zeros((24, 32)), "must be integers (uint8), got float64"),
        (np.full((24, 32), 255, np.uint8), "0 other, 1 green, 2 yellow or 3 white; got [255]"),
    ],
)
def test_labels_that_cannot_be_are_a_sentence(rng, returned, said):
    panel = make(rng, lambda *_: returned)
    assert said in panel.summary()
    assert said in html.unescape(panel._status.value)


def test_how_long_a_picture_takes_is_said_and_why_the_panel_lags(rng):
    panel = make(rng, lambda *arguments: time.sleep(0.12) or brightness(*arguments))
    assert "This is slow." in panel._status.value
    assert "ms" not in repr(panel)
    assert "This is slow." not in make(rng)._status.value
