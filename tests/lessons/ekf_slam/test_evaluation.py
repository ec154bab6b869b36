"""Distances and NIS, as the lesson's text says them."""

import pytest

from nao_course.lessons.ekf_slam.evaluation import distances_table, draw_nis, first_lines, mean_nis
from nao_course.lessons.ekf_slam.film import record_film
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS, homework_start, record_pentagon, run_log


@pytest.fixture(scope="module")
def film(film_functions):
    return record_film(*film_functions)


def test_the_first_lines_are_measurements_a_control_and_measurements():
    rows = [line.split() for line in first_lines(3).splitlines()]
    assert [len(row) for row in rows] == [12, 2, 12]


def test_nis_is_twelve_and_a_hundredth_with_sigmas_ten_times_too_large(film_functions):
    assert mean_nis(1.0, *film_functions) == pytest.approx(12.1, abs=0.05)
    assert mean_nis(10.0, *film_functions) == pytest.approx(0.12, abs=0.005)
    assert "12.09 with standard deviations times 1" in draw_nis(*film_functions).alt


def test_the_table_has_a_row_for_each_landmark_and_the_homeworks_distance_beside(film, own):
    words = repr(distances_table(film, own["evaluate_landmarks"])).splitlines()
    assert len(words) == 7 and "the homework's" in words[0]


def test_the_average_distance_of_one_drive_says_little(film, film_functions, own):
    def average(run, truth):
        return own["evaluate_landmarks"](run.landmarks, run.landmark_covariances, truth)[1].mean()

    init_landmarks, predict, update = film_functions
    assert average(film.run, film.truth) == pytest.approx(1.6, abs=0.05)
    others = []
    for seed in range(9, 14):
        made = record_pentagon(seed)
        start = homework_start(made.log, init_landmarks, OWN_SIGMAS)
        others.append(average(run_log(made.log, start, predict, update, OWN_SIGMAS), made.landmarks))
    assert (min(others), max(others)) == pytest.approx((0.51, 1.01), abs=0.01)
