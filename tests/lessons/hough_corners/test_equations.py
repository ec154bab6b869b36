"""The equations of lesson 03, each held against what stands on it."""

import numpy as np
import pytest

from nao_course.exercises import load_definitions
from nao_course.lessons.hough_corners.scenes import goal_line_view, rows_between
from nao_course.sim import CameraView
from tests.paths import SOLUTIONS


@pytest.fixture(scope="module")
def solution():
    return load_definitions(SOLUTIONS / "03_hough_corners.ipynb")


@pytest.mark.asserts("eq-3-1")
def test_a_point_of_the_ground_is_seen_where_the_camera_projects_it(rng):
    for pitch, height, d in rng.uniform((0.0, 0.3, 0.8), (0.5, 0.6, 8.0), (40, 3)):
        view = CameraView((320, 240), 1.0, 0.8, height=height, pitch=pitch)
        ((_, v),) = view.project([(d, 0.0, 0.0)])
        below = height * np.cos(pitch) - d * np.sin(pitch)
        assert v - (240 - 1) / 2 == pytest.approx(
            view.focal[1] * below / (d * np.cos(pitch) + height * np.sin(pitch))
        )


@pytest.mark.asserts("eq-3-2")
def test_a_stretch_of_ground_takes_as_many_rows_as_between_its_projected_ends(rng):
    for pitch, height, d, length in rng.uniform((0.0, 0.3, 0.8, 0.02), (0.5, 0.6, 6.0, 1.0), (40, 4)):
        view = CameraView((320, 240), 1.0, 0.8, height=height, pitch=pitch)
        near, far = view.project([(d, 0.0, 0.0), (d + length, 0.0, 0.0)])[:, 1]
        assert rows_between(d, length, view) == pytest.approx(near - far)


def test_the_numbers_of_the_text_are_those_of_the_equation():
    view = goal_line_view()
    assert view.focal[1] == pytest.approx(276, abs=0.5) and np.degrees(view.pitch) == pytest.approx(
        15, abs=0.2
    )
    assert rows_between([1.0, 3.0], 0.05) == pytest.approx([5.3, 0.7], abs=0.05)
    assert rows_between(3.3, 0.7) == pytest.approx(7, abs=0.05)
    assert rows_between(5.3, 0.7) == pytest.approx(3, abs=0.05)


@pytest.mark.asserts("eq-3-3")
def test_segments_through_one_point_meet_there_whatever_their_directions(solution, rng):
    for meeting in rng.uniform(50, 200, (40, 2)):
        first, second = rng.uniform(0, np.pi) + np.array([0.0, rng.uniform(0.3, np.pi - 0.3)])
        ends = [
            np.concatenate([meeting - 20 * way, meeting + 30 * way])
            for way in (np.array([np.cos(angle), np.sin(angle)]) for angle in (first, second))
        ]
        assert np.allclose(solution["segment_intersection"](*ends), meeting)
        assert np.allclose(solution["segment_intersection"](*ends[::-1]), meeting)


def test_the_reach_is_measured_along_the_segment_in_pixels(solution):
    upright = np.array([50.0, 0.0, 50.0, 40.0])
    for length in (10.0, 100.0):
        level = np.array([46.0 - length, 20.0, 46.0, 20.0])
        assert solution["segment_intersection"](level, upright, 3.9) is None
        assert np.allclose(solution["segment_intersection"](level, upright, 4.1), (50, 20))


def test_segments_nearly_parallel_do_not_meet(solution):
    level = np.array([0.0, 20.0, 100.0, 20.0])
    for degrees, meets in ((8.0, False), (12.0, True)):
        up = 50 * np.tan(np.radians(degrees))
        found = solution["segment_intersection"](level, np.array([0.0, 20 - up, 100.0, 20 + up]))
        assert (found is not None) == meets
