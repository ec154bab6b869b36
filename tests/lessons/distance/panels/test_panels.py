"""Lesson 04's panels: the live map, the ray of a pixel, and the tilt."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.distance import RayPanel
from nao_course.lessons.distance.looks import HEAD_PITCH, points_covariance
from nao_course.lessons.distance.panels.live_map import LiveMap
from nao_course.lessons.distance.panels.ray import LANDMARKS
from nao_course.lessons.distance.panels.ray import POSE as RAY_POSE
from nao_course.lessons.distance.panels.tilt import COLOUR, POSE, TiltPanel, upright_picture
from nao_course.sim import NAO_V4, Field
from nao_course.slam import Estimate, Measurement
from nao_course.widgets.vector_map import MapContents
from tests.lessons.distance.own import OWN, polar


def test_the_live_map_of_a_whole_field_forgets_what_it_drew_before_and_its_legend_names_what_is_shown():
    chart = LiveMap(Field(2025, half=False), {"truth": "truth", "odometry": "odometry", "ekf": "EKF"})
    empty = chart.draw(MapContents({}))
    assert empty.dtype == np.uint8 and empty.shape[2] == 3
    estimate = Estimate(Pose(), np.eye(3), np.array([[1.0, 1.0]]), np.eye(2)[None], ("post",))
    paths = {"truth": [Pose(), Pose(1, 0, 0)]}
    full = chart.draw(MapContents(paths, estimate, [Measurement(0.1, 1.0)], "truth"))
    assert not np.array_equal(full, empty)
    assert np.array_equal(chart.draw(MapContents({})), empty)
    chart = LiveMap(Field(), {"truth": "truth", "odometry": "odometry"})
    told = {"odometry": [Pose()]}
    for contents, names in (
        (MapContents(told), ["odometry"]),
        (MapContents({"truth": [Pose()], **told}), ["truth", "odometry"]),
        (MapContents(told, seen=[Measurement(0.1, 1.0)]), ["odometry", "measured from here"]),
    ):
        chart.draw(contents)
        (legend,) = chart._canvas.figure.legends
        assert [each.get_text() for each in legend.get_texts()] == names


def exact_ground(pixels, view):
    """Return the points by a search on the ground, without the inverse projection of the solution."""
    x, y = np.meshgrid(np.linspace(0.3, 4.0, 371), np.linspace(-1.5, 1.5, 301))
    points = np.column_stack([x.ravel(), y.ravel()])
    seen = view.project(points)
    return np.array([points[np.nanargmin(np.hypot(*(seen - pixel).T))] for pixel in pixels])


def test_every_landmark_is_in_the_picture_at_every_tilt_and_leaves_its_ellipse_where_the_text_says():
    for tilt in np.radians([-3, 0, 3]):
        view = NAO_V4.view("bottom", 0.0, HEAD_PITCH, torso_pitch=tilt)
        assert view.contains(view.project(RAY_POSE.to_local(list(LANDMARKS.values())))).all()
    panel = RayPanel(lambda pixels, view: np.full((len(pixels), 2), np.nan))
    assert [ray.source for ray in panel.world.contents.rays] == ["truth"]
    assert "horizon" in panel.summary()
    edge = np.sqrt(-2 * np.log(0.05))
    assert (distances_in_sigmas(-2.0) < edge).all() and (distances_in_sigmas(-2.3) > edge).all()
    assert (distances_in_sigmas(2.5) < edge).all() and (distances_in_sigmas(3.0) > edge).sum() == 1


def test_the_students_point_is_right_for_an_upright_body_and_slides_away_when_it_tilts_forwards():
    panel = RayPanel(exact_ground)
    true, blue = panel.world.contents.rays
    assert (true.source, blue.source) == ("truth", "ekf")
    assert true.point == (3.0, 0.7, 0.0)
    assert blue.point == pytest.approx(true.point, abs=0.02)
    panel.set(tilt=1.0)
    true, blue = panel.world.contents.rays
    assert true.point == (3.0, 0.7, 0.0)
    assert panel.world.contents.tilt == (pytest.approx(np.radians(1.0)), 0.0)
    # Equation 11.1: one degree moves a point at 2.56 m by about a quarter of a metre.
    assert np.hypot(*np.subtract(blue.point, true.point)[:2]) == pytest.approx(0.25, abs=0.03)
    assert "cm too far" in panel.summary()
    panel.set(tilt=-1.0)
    assert "cm too near" in panel.summary()


def panel(**changed):
    names = ("pixel_to_ground", "ground_to_measurement", "measurement_covariance")
    return TiltPanel(*(changed.get(name, OWN[name]) for name in names))


def errors(shown):
    (table,) = shown.shown.tables.values()
    return np.array([float(row[3].removesuffix(" m")) for row in table.rows])


def test_without_a_tilt_there_is_no_error_and_sigmas_and_pixel_reach_the_covariance():
    shown = panel()
    assert (errors(shown) > 0).all(), "the panel begins with one degree"
    shown.set(tilt=0.0)
    assert np.abs(errors(shown)).max() < 0.006
    shown.set(tilt=-1.0)
    assert (errors(shown) < 0).all()
    got = []

    def covariance(pixels, view, pixel_sigma, tilt_sigma):
        got.append((pixels[-1].tolist(), pixel_sigma, tilt_sigma))
        return OWN["measurement_covariance"](pixels, view, pixel_sigma, tilt_sigma)

    shown = panel(measurement_covariance=covariance)
    shown.set(pixel=(100, 200), sigma=2.0, pixel_sigma=1.5)
    assert got[-1] == ([100, 200], 1.5, pytest.approx(np.radians(2.0)))


def test_the_map_has_a_legend_and_the_picture_the_assumed_horizon_which_moves_with_the_tilt():
    shown = panel()
    below_the_axes = shown.shown.pictures["Your map"][-50:].astype(int)
    assert (np.abs(below_the_axes - COLOUR).max(axis=2) < 30).any()
    shown.set(pixel=(160, 2))
    assert "above the horizon" in shown.summary()
    shown.set(pixel=(160, 200))
    assert "shows a point 0." in shown.summary()

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
