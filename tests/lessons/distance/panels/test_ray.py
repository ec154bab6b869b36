"""The panel with a pixel's ray: the true ray ends at the landmark, the student's slides with the tilt."""

import numpy as np
import pytest

from nao_course.lessons.distance import RayPanel
from nao_course.lessons.distance.looks import HEAD_PITCH
from nao_course.lessons.distance.panels.ray import LANDMARKS, POSE
from nao_course.sim import NAO_V4


def exact_ground(pixels, view):
    """Return the points by a search on the ground, without the inverse projection of the solution."""
    x, y = np.meshgrid(np.linspace(0.3, 4.0, 371), np.linspace(-1.5, 1.5, 301))
    points = np.column_stack([x.ravel(), y.ravel()])
    seen = view.project(points)
    return np.array([points[np.nanargmin(np.hypot(*(seen - pixel).T))] for pixel in pixels])


def test_every_landmark_is_in_the_picture_at_every_tilt_and_a_point_above_the_horizon_has_no_ray():
    for tilt in np.radians([-3, 0, 3]):
        view = NAO_V4.view("bottom", 0.0, HEAD_PITCH, torso_pitch=tilt)
        assert view.contains(view.project(POSE.to_local(list(LANDMARKS.values())))).all()
    panel = RayPanel(lambda pixels, view: np.full((len(pixels), 2), np.nan))
    assert [ray.source for ray in panel.world.contents.rays] == ["truth"]
    assert "horizon" in panel.summary()


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
