"""The tilt panel: its sliders reach the student's functions, and the map follows."""

import numpy as np
import pytest

from nao_course.lessons.distance.panel import TiltPanel, upright_look
from tests.lessons.distance.own import own


def panel(**changed):
    names = ("pixel_to_ground", "ground_to_measurement", "measurement_covariance")
    return TiltPanel(*(changed.get(name, own()[name]) for name in names))


def errors(shown):
    (table,) = shown.shown.tables.values()
    return np.array([float(row[3].removesuffix(" m")) for row in table.rows])


def test_without_a_tilt_there_is_no_error_and_with_one_all_share_it():
    shown = panel()
    assert (errors(shown) > 0).all(), "the panel begins with one degree"
    shown.set(tilt=0.0)
    assert np.abs(errors(shown)).max() < 0.006
    shown.set(tilt=-1.0)
    assert (errors(shown) < 0).all()


def test_sigmas_and_pixel_reach_the_covariance():
    got = []

    def covariance(pixels, view, pixel_sigma, tilt_sigma):
        got.append((pixels[-1].tolist(), pixel_sigma, tilt_sigma))
        return own()["measurement_covariance"](pixels, view, pixel_sigma, tilt_sigma)

    shown = panel(measurement_covariance=covariance)
    shown.set(pixel=(100, 200), sigma=2.0, pixel_sigma=1.5)
    assert got[-1] == ([100, 200], 1.5, pytest.approx(np.radians(2.0)))


def test_ellipses_appear_with_the_covariance():
    def blank(*given):
        raise NotImplementedError

    without, whole = panel(measurement_covariance=blank), panel()
    assert "Finish exercise 4.6" in without.summary()
    assert (without.shown.pictures["Your map"] != whole.shown.pictures["Your map"]).any()
    assert "Finish exercise 4.4" in panel(pixel_to_ground=blank).summary()


def test_a_pixel_above_the_horizon_is_said_to_show_no_ground():
    shown = panel()
    shown.set(pixel=(160, 2))
    assert "above the horizon" in shown.summary()
    shown.set(pixel=(160, 200))
    assert "shows a point 0." in shown.summary()


def test_the_true_corner_leaves_its_ellipse_where_the_text_says():
    """95 % of one uncertain direction beside another that is nearly sure is 2.4 deviations of tilt."""
    assert len(upright_look().marks) >= 3
    shown = panel()
    shown.set(tilt=2.4)
    (table,) = shown.shown.tables.values()
    ratios = [float(row[3].removesuffix(" m")) / float(row[2].removesuffix(" m")) for row in table.rows]
    assert min(ratios) > 1.5 and max(ratios) < 2.6


def test_an_answer_of_another_length_is_said():
    shown = panel(pixel_to_ground=lambda pixels, view: own()["pixel_to_ground"](pixels, view)[:1])
    assert "need as many points" in shown.summary()
