"""The film: half steps in order, correlations that are none at first, and figures of single half steps."""

import numpy as np
import pytest

from nao_course.lessons.ekf_slam.film import (
    CORRELATION,
    between_landmarks,
    correlations,
    draw_frames,
    record_film,
    say_frame,
)


@pytest.fixture(scope="module")
def film(film_functions):
    return record_film(*film_functions)


def test_frames_are_the_start_then_predicted_and_updated_in_turn(film):
    assert film.last == 50
    assert [film.at(frame)[0] for frame in range(5)] == [0, 1, 1, 2, 2]
    assert np.array_equal(film.at(0)[1][:3], np.zeros(3))
    assert np.array_equal(film.at(3)[2], film.run.predicted_covariances[1])
    assert np.array_equal(film.at(4)[1], film.run.states[2])


def test_correlations_are_one_on_the_diagonal_and_zero_beside_a_variance_of_zero():
    P = np.array([[4.0, 2.0, 0.0], [2.0, 9.0, 0.0], [0.0, 0.0, 0.0]])
    assert correlations(P) == pytest.approx(np.array([[1, 1 / 3, 0], [1 / 3, 1, 0], [0, 0, 0]]))


def test_before_the_first_update_no_two_landmarks_are_correlated_and_at_the_end_all_are(film):
    assert between_landmarks(film.at(0)[2]) == between_landmarks(film.at(1)[2]) == 0
    grown = [between_landmarks(film.at(frame)[2]) for frame in (2, 12, 24, 50)]
    assert 0 < grown[0] < grown[1] and grown[-1] > 0.4
    assert between_landmarks(np.eye(5)) == 0


def test_each_landmarks_ellipse_only_shrinks(film):
    areas = np.array(
        [[np.linalg.det(P[i : i + 2, i : i + 2]) for i in range(3, 15, 2)] for P in film.run.covariances]
    )
    assert (np.diff(areas, axis=0) <= 1e-15).all() and (areas[-1] < areas[0]).all()


def test_the_lessons_words_about_the_film_hold(film):
    sure = [100 * np.sqrt(np.trace(film.at(frame)[2][:2, :2])) for frame in range(3, 51)]
    assert np.mean(sure[0::2]) == pytest.approx(5.5, abs=1.0) and np.mean(sure[1::2]) == pytest.approx(
        4, abs=0.7
    )


def test_the_drawn_robot_looks_where_it_is_heading(film):
    frames = (3, 50)
    for frame, ax in zip(frames, draw_frames(film, frames).figure.axes[:2], strict=True):
        x, y, theta = film.at(frame)[1][:3]
        ends = [np.transpose(line.get_data()) for line in ax.lines]
        (heading,) = [each for each in ends if len(each) == 2 and np.allclose(each[0], (x, y))]
        assert np.arctan2(*(heading[1] - heading[0])[::-1]) == pytest.approx(theta, abs=1e-6)


def test_words_say_step_standard_deviation_and_error(film):
    assert say_frame(film, 0).startswith(
        "At the start: standard deviation of the robot 2.8 cm and 5.7 degrees"
    )
    assert "after step 3, predicted" in say_frame(film, 5).lower()
    assert "after step 3, updated" in say_frame(film, 6).lower() and say_frame(film, 6).endswith("cm off.")


def test_an_error_names_the_function_that_returned_the_wrong_type(film_functions):
    init_landmarks, predict, _ = film_functions
    with pytest.raises(ValueError, match="update must return"):
        record_film(init_landmarks, predict, lambda *given: None)


def test_a_small_correlation_is_no_white_and_none_is():
    white = (1, 1, 1, 1)
    colours = [CORRELATION((1 + value) / 2) for value in (0.0, 0.02, -0.02)]
    assert colours[0] == pytest.approx(white)
    assert all(max(abs(a - b) for a, b in zip(each, white, strict=True)) > 0.1 for each in colours[1:])
