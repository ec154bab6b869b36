"""What lesson 04 adds to the robot: posts and corners as points on the map."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.distance.stage import STAGE
from nao_course.sim import SimulatedNao, TorsoTilt, Truth
from nao_course.widgets.control_panel import Pipeline
from nao_course.widgets.control_panel.pipeline import Overlay, Stage
from tests.lessons.distance.own import own

POSE = Pose(0.6, 0.5, -0.25)


def finding(name, pixels):
    return Stage(name, "02_goalposts", (), lambda student, nao: lambda frame: Overlay(pixels, pixels=pixels))


def looked(stages, functions=None):
    nao = SimulatedNao(pose=POSE, rng=41, tilt=TorsoTilt(0.0, 0.0))
    picture = nao.take_picture("bottom")
    seen = Pipeline([*stages, STAGE], functions or own(), nao, time_limit=60.0).process(picture)
    return Truth(nao), seen


def pixels_of(kind):
    nao = SimulatedNao(pose=POSE, rng=41, tilt=TorsoTilt(0.0, 0.0))
    nao.take_picture("bottom")
    marks = [mark for mark in Truth(nao).picture.landmarks if mark.landmark.kind == kind]
    return np.array([mark.pixel for mark in marks]), np.array(
        [(mark.landmark.x, mark.landmark.y) for mark in marks]
    )


def test_posts_and_corners_stand_where_the_field_has_them():
    (posts, at_posts), (corners, at_corners) = pixels_of("post"), pixels_of("corner")
    _, seen = looked([finding("goal posts", posts), finding("corners", corners)])
    found = POSE.to_parent(seen.overlays["points on the map"].points)
    assert found == pytest.approx(np.vstack([at_posts, at_corners]), abs=1e-4)


def test_one_of_both_is_enough_and_a_pixel_of_the_sky_is_left_out():
    posts, _ = pixels_of("post")
    _, seen = looked([finding("goal posts", np.vstack([posts, [[100.0, 1.0]]]))])
    overlay = seen.overlays["points on the map"]
    assert len(overlay.points) == len(posts) and overlay.text.startswith(f"{len(posts)} points: 2.")


def test_without_posts_and_corners_it_says_who_finds_them():
    _, seen = looked([])
    assert "lessons 02 and 03" in seen.overlays["points on the map"].text
