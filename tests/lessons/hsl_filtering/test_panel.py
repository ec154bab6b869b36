"""The filter panel: settings reach the student's code, its errors become sentences, its labels become numbers."""

import colorsys
import html
import time
from functools import partial

import numpy as np
import pytest

from nao_course.lessons.hsl_filtering import FilterPanel, in_light
from nao_course.lessons.hsl_filtering import instruments as drawn
from nao_course.lessons.hsl_filtering import panel as panel_module
from nao_course.lessons.hsl_filtering.light import BINS, MARKS
from nao_course.lessons.hsl_filtering.scores import ERROR_COLOURS
from nao_course.plotting import LABEL_COLOURS
from nao_course.widgets.shown import on_white
from tests.widgets.robots import decoded

GREEN, YELLOW = (105.0, 150.0), (45.0, 60.0)


def scene(rng, size=(24, 32)):
    """A picture of noise, and labels that its colours do not explain."""
    return rng.integers(0, 256, (*size, 3), dtype=np.uint8), rng.integers(0, 4, size, dtype=np.uint8)


def brightness(picture, green, yellow, beta, min_saturation):
    """Labels that depend on beta and on nothing else."""
    grey = picture.mean(axis=2)
    return np.select([grey > beta, grey > beta / 2, grey > beta / 3], [3, 2, 1], 0).astype(np.uint8)


def make(rng, label=brightness, grey=(0, 0), **options):
    picture, truth = scene(rng)
    picture[grey[::-1]] = 77
    return FilterPanel(picture, truth, label, **{"green": GREEN, "yellow": YELLOW, **options})


def blank_filter_panel():
    return make(np.random.default_rng(0), calibrate=lambda *given: (1.0, 2.0), examples={"green": np.s_[:4]})


def colour(text):
    return tuple(int(text[i : i + 2], 16) for i in (1, 3, 5))


def test_every_slider_reaches_the_students_function_as_a_browser_would_round_it(rng):
    got = []
    panel = make(rng, lambda *arguments: got.append(arguments[1:]) or brightness(*arguments))
    assert got == [(GREEN, YELLOW, 120.0, 0.16)]
    names = "green_low", "green_high", "yellow_low", "yellow_high", "beta", "min_saturation"
    for name, value in zip(names, (100.0, 20.0, 350.0, 70.0, 33.0, 0.5), strict=True):
        panel._widgets[name].value = value
    assert got[-1] == ((100.0, 20.0), (350.0, 70.0), 33.0, 0.5) and len(got) == 7
    panel = make(rng, green=(114.3, 359.7), beta=99.6, min_saturation=0.1649)
    assert panel.settings.green == (114.0, 359.0) and panel._widgets["green_low"].value == 114.0
    assert (panel.settings.beta, panel.settings.min_saturation) == (100.0, 0.16)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"green": (0, 360)}, "green must be two hues in degrees"),
        ({"yellow": 5}, "yellow must be two hues"),
        ({"beta": 256}, "beta must be from 0 to 255, got 256"),
        ({"light": 0.2}, "light must be from 0.3 to 1.6, got 0.2"),
    ],
)
def test_what_no_slider_can_show_and_pictures_and_labels_that_do_not_fit_are_refused(rng, settings, said):
    panel, (picture, truth) = make(rng), scene(rng)
    for refused in (panel.set, *([] if "light" in settings else [partial(make, rng)])):  # light begins at 1
        with pytest.raises(ValueError, match=said):
            refused(**settings)
    assert panel.settings.green == GREEN
    for given, said in (
        ((picture / 255, truth, brightness), r"uint8 of shape \(H, W, 3\), got float64"),
        ((picture, truth[1:], brightness), "truth must have the picture's shape"),
        ((picture, truth, truth), "label must be a function"),
        (({"a": picture}, {"b": truth}, brightness), "of the same names"),
    ):
        with pytest.raises(ValueError, match=said):
            FilterPanel(*given, green=GREEN, yellow=YELLOW)


def test_scores_are_those_of_counting_pixel_by_pixel_and_a_colour_that_is_nowhere_has_none(rng):
    panel = make(rng, beta=150)
    pairs = list(zip(panel.labels.ravel().tolist(), panel._scene[1].ravel().tolist(), strict=True))
    for label, name in enumerate(("green", "yellow", "white"), start=1):
        both = sum(a == b == label for a, b in pairs)
        precision, recall = (both / sum(pair[i] == label for pair in pairs) for i in (0, 1))
        scores = panel.scores[name]
        assert (scores.precision, scores.recall) == pytest.approx((precision, recall))
        assert f"{name}: precision {100 * precision:.1f} %, recall {100 * recall:.1f} %" in panel.summary()
        assert f"<td>{100 * precision:.1f} %</td><td>{100 * recall:.1f} %</td>" in panel._table.value
    panel = make(rng, lambda picture, *_: np.zeros(picture.shape[:2], int))
    assert "white: precision -, recall 0.0 %" in panel.summary()


def test_labels_and_errors_keep_their_colours_to_the_pixel_and_are_shown_without_another_call(rng):
    calls = []
    panel = make(rng, lambda *arguments: calls.append(1) or brightness(*arguments))
    wanted = np.array([colour(each) for each in LABEL_COLOURS])

    def shown():
        return decoded(panel._row.places[1].image)

    assert np.array_equal(shown(), wanted[panel.labels])
    panel._widgets["shown"].value = "True labels"
    assert np.array_equal(shown(), wanted[panel._scene[1]])
    panel._widgets["shown"].value = "Errors in white"
    right, wrong, missed, _ = ((shown() == colour(each)).all(axis=2) for each in ERROR_COLOURS)
    called, there = panel.labels == 3, panel._scene[1] == 3
    assert np.array_equal(right, called & there)
    assert np.array_equal(wrong, called & ~there)
    assert np.array_equal(missed, ~called & there)
    assert "wrongly labelled white" in panel._legend.value and "Your code" in panel._status.value
    assert len(calls) == 1


def test_another_scene_is_labelled_with_the_same_settings_and_a_pixel_is_chosen_without_the_filter(rng):
    (day, truth), (night, _) = scene(rng), scene(rng)
    panel = FilterPanel({"day": day, "night": night // 3}, truth, brightness, green=GREEN, yellow=YELLOW)
    before, picture = panel.summary(), panel._row.places[0].image.value
    panel._widgets["scene"].value = "night"
    assert panel._row.places[0].image.value != picture
    assert np.array_equal(panel.labels, brightness(night // 3, GREEN, YELLOW, 120, 0.16))
    assert before.startswith("scene: day\n") and panel.summary() != before
    calls = []
    panel = make(rng, lambda *arguments: calls.append(1) or brightness(*arguments), grey=(4, 3))
    panel.set(pixel=(4, 3))
    assert "The pixel (4, 3) has lightness 77 and is grey: it has no hue." in panel.summary()
    assert len(calls) == 1
    panel = make(rng, lambda *arguments: time.sleep(0.12) or brightness(*arguments))
    assert "This is slow." in panel._status.value and "beta" not in panel._status.value  # one line, as before
    assert "ms" not in repr(panel)
    assert "This is slow." not in make(rng)._status.value


def test_in_another_light_the_student_gets_another_picture_and_histogram_and_threshold_follow(rng):
    got = []
    panel = make(
        rng,
        lambda *arguments: got.append(arguments[0]) or brightness(*arguments),
        threshold=lambda mean, beta: mean + beta / 10,
    )

    def mean():
        return float(panel.summary().split("Mean lightness ")[1].split(".")[0])

    bright, before = mean(), decoded(panel._small_row.places[0].image)
    panel.set(light=0.5)
    assert np.array_equal(got[-1], in_light(panel._scene[0], 0.5))
    assert mean() == pytest.approx(bright / 2, abs=1.5)
    assert f"Threshold {mean() + 12:.0f}." in panel.summary()
    assert not np.array_equal(decoded(panel._small_row.places[0].image), before)


def test_a_slider_makes_only_those_parts_again_that_depend_on_it(rng, monkeypatch):
    panel, made = make(rng, threshold=lambda mean, beta: beta), []
    for name in ("lightness_counts", "histogram_picture", "circle_picture"):
        do = getattr(panel_module, name)
        monkeypatch.setattr(
            panel_module, name, lambda *given, name=name, do=do: made.append(name) or do(*given)
        )
    for setting, again in (
        ({"green": (90.0, 150.0)}, {"circle_picture"}),
        ({"beta": 60.0}, {"histogram_picture"}),
        ({"min_saturation": 0.4}, {"circle_picture"}),
        ({"pixel": (3, 4)}, {"circle_picture"}),
        ({"light": 0.5}, {"lightness_counts", "histogram_picture", "circle_picture"}),
        ({"light": 0.5}, set()),
    ):
        made.clear()
        panel.set(**setting)
        assert set(made) == again, setting
    kept, panel._made = dict(panel.shown.pictures), {}
    panel.set()
    assert all(np.array_equal(kept[title], pixels) for title, pixels in panel.shown.pictures.items())


def test_a_histogram_stands_upright_over_its_lightnesses_and_a_hue_is_on_the_circle_where_its_angle_says():
    counts = np.zeros((4, BINS), dtype=int)
    counts[1, 20], counts[3, 20], counts[0, 40] = 100, 100, 200
    picture = drawn.histogram_picture(counts, {"threshold": 128.0})
    first, second = (round(drawn.LEFT + (drawn.RIGHT - drawn.LEFT) * (k + 0.5) / BINS) for k in (20, 40))
    above = int(drawn.BOTTOM - 0.75 * (drawn.BOTTOM - drawn.TOP) / 1.15)
    for place, wanted in (
        ((drawn.BOTTOM - 20, first), LABEL_COLOURS[1]),
        ((above, first), LABEL_COLOURS[3]),
        ((above, second), LABEL_COLOURS[0]),
        ((drawn.TOP + 2, (drawn.LEFT + drawn.RIGHT) // 2), MARKS["threshold"][0]),
    ):
        assert tuple(picture[place]) == (*colour(wanted), 255)
    # The page is seen through the paper
    assert picture[drawn.TOP + 2, drawn.LEFT + 2, 3] == picture[0, 0, 3] == 0
    assert (on_white(picture)[drawn.TOP + 2, drawn.LEFT + 2] == 255).all()
    hue = np.full((3, 3), 91.0, dtype=np.float32)
    everywhere = np.ones((3, 3), dtype=bool)
    counts = drawn.hue_counts(hue, everywhere)
    picture = drawn.circle_picture(counts, {LABEL_COLOURS[2]: (350.0, 20.0)}, pixel=180.0)
    (u, v), blank = drawn.CENTRE, drawn.circle_picture(drawn.hue_counts(hue, ~everywhere), {})
    painted = (picture != blank).any(axis=2)
    assert painted[v - drawn.OUTER + 3, u - 2] and not painted[v + drawn.OUTER - 3, u]  # 90 degrees are up
    assert painted[v, u - drawn.OUTER] and tuple(picture[v, u - drawn.OUTER, :3]) == colour(drawn.PIXEL)
    assert tuple(picture[v - 5, u + drawn.OUTER + 7, :3]) == colour(LABEL_COLOURS[2])
    assert not painted[v + 60, u + drawn.OUTER // 2 + 30]


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


@pytest.mark.parametrize(
    ("returned", "said"),
    [
        (np.zeros((32, 24), np.uint8), "must have shape (24, 32), one for each pixel; got (32, 24)"),
        (np.zeros((24, 32)), "must be integers (uint8), got float64"),
        (np.full((24, 32), 255, np.uint8), "0 other, 1 green, 2 yellow or 3 white; got [255]"),
    ],
)
def test_labels_that_cannot_be_are_a_sentence(rng, returned, said):
    panel = make(rng, lambda *_: returned)
    assert said in panel.summary()
    assert said in html.unescape(panel._status.value)
