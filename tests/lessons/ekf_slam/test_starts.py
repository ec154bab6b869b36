"""Two initialisations of a map: one of them is overconfident."""

import numpy as np
import pytest

from nao_course.lessons.ekf_slam.starts import DRIVES, draw_starts, uncertain_start


def test_first_poses_are_drawn_from_the_first_covariance():
    starts = np.array([uncertain_start(seed).path[0] for seed in range(DRIVES)])
    assert starts.std(axis=0) == pytest.approx([0.02, 0.02, 0.1], rel=0.35)


def test_measurements_fit_the_truth_from_where_the_robot_truly_begins():
    from nao_course.slam import range_and_bearing

    start = uncertain_start(3)
    exact = np.array([range_and_bearing(pose, start.landmarks) for pose in start.path])
    off = start.log.measurements.reshape(exact.shape) - exact
    assert np.abs(off[..., 1]).mean() == pytest.approx(0.06 * np.sqrt(2 / np.pi), rel=0.2)


def test_the_lessons_numbers(own):
    functions = [own[name] for name in ("init_landmarks", "add_landmark", "predict", "update")]
    drawing = draw_starts(*functions)
    assert "63 with init_landmarks and 5.5 with add_landmark" in drawing.alt
    assert "21 and 23 cm off" in drawing.alt
    assert "In 3 and 29 drives all true landmarks lie inside" in drawing.alt
    assert "0 of 6 true landmarks lie inside their ellipses with init_landmarks, and 6 with" in drawing.alt
