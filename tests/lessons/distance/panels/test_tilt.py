"""The tilt panel: its sliders reach the student's functions, and the map follows."""

import numpy as np
import pytest

from nao_course.lessons.distance.looks import points_covariance
from nao_course.lessons.distance.panels.tilt import COLOUR, POSE, TiltPanel, upright_picture
from tests.lessons.distance.own import OWN, polar


def panel(**changed):
    names = ("pixel_to_ground", "ground_to_measurement", "measurement_covariance")
    return TiltPanel(*(changed.get(name, OWN[name]) for name in names))


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
        return OWN["measurement_covariance"](pixels, view, pixel_sigma, tilt_sigma)

    shown = panel(measurement_covariance=covariance)
    shown.set(pixel=(100, 200), sigma=2.0, pixel_sigma=1.5)
    assert got[-1] == ([100, 200], 1.5, pytest.approx(np.radians(2.0)))


def test_the_maps_legend_has_a_key_for_the_points_and_a_pixel_above_the_horizon_shows_no_ground():
    shown = panel()
    below_the_axes = shown.shown.pictures["Your map"][-50:].astype(int)
    assert (np.abs(below_the_axes - COLOUR).max(axis=2) < 30).any()
    shown.set(pixel=(160, 2))
    assert "above the horizon" in shown.summary()
    shown.set(pixel=(160, 200))
    assert "shows a point 0." in shown.summary()


def test_the_assumed_horizon_is_dotted_into_the_picture_and_moves_with_the_tilt():
    def dotted_row(shown):
        changed = (shown.shown.pictures["The picture"] != upright_picture().pixels).any(axis=2)
        changed[75:] = False  # the marks
        return float(np.flatnonzero(changed[:, 100:220].any(axis=1)).mean())

    shown = panel()
    shown.set(tilt=0.0)
    middle, view = dotted_row(shown), upright_picture().view
    assert middle == pytest.approx(view.centre[1] - view.focal[1] * np.tan(view.pitch), abs=3)
    shown.set(tilt=2.0)
    assert dotted_row(shown) == pytest.approx(middle + np.radians(2) * view.focal[1], abs=3)


def distances_in_sigmas(tilt):
    """Return how many standard deviations the true landmarks are from the panel's points, with a sigma of 1 degree."""
    look = upright_picture().with_tilt(np.radians(tilt))
    full = OWN["measurement_covariance"](look.marks, look.view, 0.7, np.radians(1.0))
    covariances = points_covariance(polar(look.marks, look.view), full)
    off = POSE.to_local(look.landmarks) - OWN["pixel_to_ground"](look.marks, look.view)
    return np.sqrt([each @ np.linalg.solve(c, each) for each, c in zip(off, covariances, strict=True)])


def test_true_landmarks_leave_their_ellipses_where_the_text_says():
    edge = np.sqrt(-2 * np.log(0.05))
    assert (distances_in_sigmas(-2.0) < edge).all() and (distances_in_sigmas(-2.3) > edge).all()
    assert (distances_in_sigmas(2.5) < edge).all() and (distances_in_sigmas(3.0) > edge).sum() == 1
