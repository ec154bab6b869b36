"""Lesson 07's film, initialisations, distances and covariance blocks, as its text says them."""

import numpy as np
import pytest

from nao_course.lessons.ekf_slam import draw_blocks, draw_loop, last_deviation
from nao_course.lessons.ekf_slam.blocks import block_steps, changed
from nao_course.lessons.ekf_slam.evaluation import distances_table, draw_nis, mean_nis
from nao_course.lessons.ekf_slam.film import (
    CORRELATION,
    between_landmarks,
    correlations,
    draw_frames,
    record_film,
    say_frame,
)
from nao_course.lessons.ekf_slam.homework_log import (
    OWN_SIGMAS,
    homework_start,
    own_log,
    record_pentagon,
    run_log,
)
from nao_course.lessons.ekf_slam.loop import close_loop, deviations, errors
from nao_course.lessons.ekf_slam.starts import DRIVES, draw_starts, uncertain_start
from nao_course.metrics import band
from nao_course.slam import range_and_bearing
from tests.lessons.every import quotes, text


@pytest.fixture(scope="module")
def film(film_functions):
    return record_film(*film_functions)


def test_frames_are_the_start_then_predicted_and_updated_in_turn_and_words_say_so(film):
    assert film.last == 50
    assert [film.at(frame)[0] for frame in range(5)] == [0, 1, 1, 2, 2]
    assert np.array_equal(film.at(0)[1][:3], np.zeros(3))
    assert np.array_equal(film.at(3)[2], film.run.predicted_covariances[1])
    assert np.array_equal(film.at(4)[1], film.run.states[2])
    assert say_frame(film, 0).startswith("At the start: standard deviation of the robot 2.8 cm and 5.7")
    assert "after step 3, predicted" in say_frame(film, 5).lower()
    assert "after step 3, updated" in say_frame(film, 6).lower() and say_frame(film, 6).endswith("cm off.")


def test_correlations_are_one_on_the_diagonal_and_zero_alone_is_white():
    P = np.array([[4.0, 2.0, 0.0], [2.0, 9.0, 0.0], [0.0, 0.0, 0.0]])
    assert correlations(P) == pytest.approx(np.array([[1, 1 / 3, 0], [1 / 3, 1, 0], [0, 0, 0]]))
    white = (1, 1, 1, 1)
    colours = [CORRELATION((1 + value) / 2) for value in (0.0, 0.02, -0.02)]
    assert colours[0] == pytest.approx(white)
    assert all(max(abs(a - b) for a, b in zip(each, white, strict=True)) > 0.1 for each in colours[1:])


def test_landmarks_become_correlated_and_their_ellipses_shrink_as_the_lesson_says(film):
    assert between_landmarks(film.at(0)[2]) == between_landmarks(film.at(1)[2]) == 0
    grown = [between_landmarks(film.at(frame)[2]) for frame in (2, 12, 24, 50)]
    assert 0 < grown[0] < grown[1] and grown[-1] > 0.4
    assert between_landmarks(np.eye(5)) == 0
    every = film.run.covariances
    areas = np.array([[np.linalg.det(P[i : i + 2, i : i + 2]) for i in range(3, 15, 2)] for P in every])
    assert (np.diff(areas, axis=0) <= 1e-15).all() and (areas[-1] < areas[0]).all()
    sure = [100 * np.sqrt(np.trace(film.at(frame)[2][:2, :2])) for frame in range(3, 51)]
    assert np.mean(sure[0::2]) == pytest.approx(5.5, abs=1.0)
    assert np.mean(sure[1::2]) == pytest.approx(4, abs=0.7)


def test_the_drawn_robot_looks_where_it_is_heading_and_an_error_names_its_function(film, film_functions):
    frames = (3, 50)
    for frame, ax in zip(frames, draw_frames(film, frames).figure.axes[:2], strict=True):
        x, y, theta = film.at(frame)[1][:3]
        ends = [np.transpose(line.get_data()) for line in ax.lines]
        (heading,) = [each for each in ends if len(each) == 2 and np.allclose(each[0], (x, y))]
        assert np.arctan2(*(heading[1] - heading[0])[::-1]) == pytest.approx(theta, abs=1e-6)
    init_landmarks, predict, _ = film_functions
    with pytest.raises(ValueError, match="update must return"):
        record_film(init_landmarks, predict, lambda *given: None)


def test_the_log_begins_with_measurements_and_nis_and_the_table_are_the_texts(film_functions, film, own):
    log = own_log()
    rows = [log.measurements[0], log.controls[0], log.measurements[1]]
    assert [len(row) for row in rows] == [12, 2, 12]
    quotes(text("07"), *("  ".join(f"{value:.2f}" for value in row) for row in rows))
    assert mean_nis(1.0, *film_functions) == pytest.approx(12.1, abs=0.05)
    assert mean_nis(10.0, *film_functions) == pytest.approx(0.12, abs=0.005)
    assert "12.09 with standard deviations times 1" in draw_nis(*film_functions).alt
    words = repr(distances_table(film, own["evaluate_landmarks"])).splitlines()
    assert len(words) == 8 and "the homework's" in words[0] and words[-1].split()[2] == "1.62"


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


def test_first_poses_are_drawn_from_the_first_covariance_and_measurements_fit_the_truth():
    starts = np.array([uncertain_start(seed).path[0] for seed in range(DRIVES)])
    assert starts.std(axis=0) == pytest.approx([0.02, 0.02, 0.1], rel=0.35)
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


def test_a_motion_leaves_the_map_an_update_changes_all_and_a_new_landmark_leaves_the_old_entries(functions):
    before, moved, updated, added = block_steps(*functions).values()
    motion, update, first = changed(before, moved), changed(moved, updated), changed(updated, added)
    assert motion[:3, :3].all() and motion[:2, 3:].all() and motion[3:, :2].all()
    assert not motion[2, 3:].any() and not motion[3:, 3:].any()
    assert update.all()
    assert not first[:9, :9].any() and first[9:].all() and first[:, 9:].all() and added.shape == (11, 11)
    assert "Motion: 100 % of P_pp, 67 % of P_pl, 0 % of P_ll." in draw_blocks(*functions).alt


def test_a_filter_that_forgets_a_block_is_seen_in_the_figure(functions):
    predict, update_landmarks, add_landmark = functions

    def forgetting(state, covariance, *more):
        new, P = predict(state, covariance, *more)
        P[:3, 3:], P[3:, :3] = covariance[:3, 3:], covariance[3:, :3]
        return new, P

    before, moved, *_ = block_steps(forgetting, update_landmarks, add_landmark).values()
    assert not changed(before, moved)[:3, 3:].any()


def test_one_picture_of_an_early_landmark_shrinks_all_late_ellipses_and_leaves_the_map_consistent(functions):
    loop = close_loop(functions)
    before, after = deviations(loop.before), deviations(loop.after)
    assert len(before) == 12 and (after < before).all() and loop.numbers[0] == 0
    assert (before[-1], after[-1]) == (pytest.approx(0.56, abs=0.005), pytest.approx(0.156, abs=0.001))
    assert last_deviation(*functions) == pytest.approx(15.6, abs=0.05)
    traces = [np.trace(belief[1][3:, 3:]) for belief in (loop.before, loop.after)]
    assert traces == pytest.approx([2.13, 0.98], abs=0.005)
    off = [100 * errors(loop, each).mean() for each in (loop.before, loop.after)]
    assert off == pytest.approx([27, 19], abs=0.5)
    assert after[0] > 0.95 * before[0] and "trace" not in draw_loop(*functions).alt
    loop, (low, high) = close_loop(functions), band(24, 1)
    for state, covariance in (loop.before, loop.after):
        error = state[3:] - loop.landmarks[loop.numbers].ravel()
        assert low < error @ np.linalg.solve(covariance[3:, 3:], error) < high


def test_the_loop_is_typical_of_many(functions):
    ratios = []
    for seed in range(30):
        try:
            loop = close_loop(functions, seed)
        except RuntimeError:  # the robot has left the circle
            continue
        ratios.append(deviations(loop.after).mean() / deviations(loop.before).mean())
    shown = close_loop(functions)
    ratio = deviations(shown.after).mean() / deviations(shown.before).mean()
    assert len(ratios) > 15 and np.median(ratios) == pytest.approx(ratio, abs=0.06)
