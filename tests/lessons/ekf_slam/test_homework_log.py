"""The homework's drive: its Table 1 to the printed digits, what its own log says, and the course's own log."""

import numpy as np
import pytest

from nao_course.datasets import HomeworkLog, read_homework_log, write_homework_log
from nao_course.geometry import wrap_angle
from nao_course.instructor.authoring.plans import load_solution
from nao_course.lessons.ekf_slam import homework_log
from nao_course.lessons.ekf_slam.homework_log import (
    OWN_LOG,
    OWN_SIGMAS,
    START_COVARIANCE,
    homework_start,
    innovation_and_covariance,
    landmark_errors,
    own_log,
    record_pentagon,
    run_log,
    textbook_start,
)
from nao_course.metrics import band
from nao_course.sim.drives import Sigmas, landmark_blocks
from tests.paths import SOLUTIONS

# The report's Table 1, as it is printed.
EUCLIDEAN = ["0.0021917", "0.0041727", "0.0025231", "0.0027936", "0.0019271", "0.0039974"]
PRINTED = ["8.5549e-05", "2.3433e-04", "1.1250e-04", "1.1257e-04", "1.1666e-04", "1.5250e-04"]


@pytest.fixture(scope="module")
def log(data_dir):
    return read_homework_log(data_dir / "slam" / "cmu16833_hw2" / "data.txt")


@pytest.fixture(scope="module")
def run(log, own):
    return run_log(log, homework_start(log, own["init_landmarks"]), own["predict"], own["update"])


def test_the_reports_table_1_comes_out_to_its_printed_digits(run):
    found = landmark_errors(run.landmarks, run.landmark_covariances)
    assert [f"{value:.7f}" for value in found.euclidean] == EUCLIDEAN
    assert [f"{value:.4e}" for value in found.printed] == PRINTED
    assert [f"{value:.5f}" for value in found.mahalanobis] == [
        *("0.05750", "0.07660", "0.05785", "0.07265", "0.03285", "0.10768")
    ]


def test_the_homeworks_log_says_that_its_sigmas_are_far_too_large(run):
    low, high = band(12, len(run.nis))
    assert (round(low, 1), round(high, 1)) == (10.3, 13.8)
    assert round(run.nis.mean(), 3) == 0.084


def test_the_textbooks_start_is_farther_from_the_truth_on_this_log(log, own):
    run = run_log(log, textbook_start(log, own["add_landmark"]), own["predict"], own["update"])
    found = landmark_errors(run.landmarks, run.landmark_covariances)
    assert [f"{value:.4f}" for value in found.euclidean] == [
        *("0.0042", "0.0062", "0.0086", "0.0114", "0.0091", "0.0102")
    ]


# --- the own log ---


def test_the_shipped_log_is_the_one_that_the_seed_makes(tmp_path):
    made = write_homework_log(record_pentagon().log, tmp_path / "made.txt")
    assert made.read_text() == OWN_LOG.read_text()
    assert (own_log().k, own_log().controls.shape) == (6, (25, 2))


def test_the_own_log_lies_in_its_band_with_the_sigmas_it_was_made_with(own):
    log = own_log()
    start = homework_start(log, own["init_landmarks"], OWN_SIGMAS)
    run = run_log(log, start, own["predict"], own["update"], OWN_SIGMAS)
    low, high = band(12, len(run.nis))
    assert low < run.nis.mean() < high


def test_without_noise_every_pose_and_landmark_is_the_truth(own):
    exact = Sigmas(0.0, 0.0, 0.0, 0.0, 0.0)
    recording = record_pentagon(sigmas=exact)
    start = textbook_start(recording.log, own["add_landmark"], exact)
    run = run_log(recording.log, start, own["predict"], own["update"])
    off = run.states[:, :3] - recording.path
    assert np.abs(off[:, :2]).max() < 1e-9 and np.abs(wrap_angle(off[:, 2])).max() < 1e-9
    assert np.abs(run.landmarks - recording.landmarks).max() < 1e-9


# --- what is kept, and what judges ---


def test_all_steps_are_kept_and_left_out_updates_change_nothing(own):
    log = own_log()
    start = homework_start(log, own["init_landmarks"], OWN_SIGMAS)
    run = run_log(log, start, own["predict"], own["update"], OWN_SIGMAS, every=5)
    assert run.states.shape == (26, 15) and run.predicted_covariances.shape == (25, 15, 15)
    assert run.updated.nonzero()[0].tolist() == [4, 9, 14, 19, 24] and len(run.nis) == 5
    assert np.array_equal(run.states[1:][~run.updated], run.predicted_states[~run.updated])
    assert not np.array_equal(run.states[5], run.predicted_states[4])
    assert np.array_equal(landmark_blocks(run.covariances[3])[1], run.covariances[3][5:7, 5:7])


def test_innovation_and_covariance_are_those_of_lesson_05s_jacobians(rng):
    report = load_solution(SOLUTIONS / "05_ekf_derivations.ipynb")
    state = rng.uniform(-2, 2, 9)
    root = rng.normal(size=(9, 9))
    covariance, R = root @ root.T, np.diag([0.01, 0.04])
    seen = rng.uniform(0.5, 2, 4)
    innovation, S = innovation_and_covariance(state, covariance, [2, 0], seen, R)
    H, expected = np.zeros((4, 9)), np.zeros(4)
    for row, number in ((0, 2), (2, 0)):
        landmark = state[3 + 2 * number : 5 + 2 * number]
        expected[row : row + 2] = report["expected_measurement"](state[:3], landmark)
        H[row : row + 2, :3] = report["measurement_jacobian_pose"](state[:3], landmark)
        H[row : row + 2, 3 + 2 * number : 5 + 2 * number] = report["measurement_jacobian_landmark"](
            state[:3], landmark
        )
    wanted = seen - expected
    wanted[::2] = wrap_angle(wanted[::2])
    assert np.allclose(innovation, wanted)
    assert np.allclose(S, H @ covariance @ H.T + np.kron(np.eye(2), R), rtol=1e-6)


def test_what_a_function_returns_wrongly_is_said_with_its_name(own):
    log = HomeworkLog([[0.1, 2.0]] * 2, [[0.5, 0.0]])
    start = (np.array([0.0, 0.0, 0.0, 2.0, 0.0]), np.eye(5))
    with pytest.raises(ValueError, match=r"predict must return \(state, covariance\), got NoneType"):
        run_log(log, start, lambda *_: None, own["update"])
    with pytest.raises(ValueError, match=r"update must return shapes \(5,\) and \(5, 5\), got \(3,\)"):
        run_log(log, start, own["predict"], lambda *_: (np.zeros(3), np.eye(3)))
    with pytest.raises(ValueError, match=r"init_landmarks must return \(1, \(2,\), \(2, 2\)\)"):
        homework_start(log, lambda *_: (2, np.zeros(4), np.eye(4)))
    with pytest.raises(ValueError, match="add_landmark must return"):
        textbook_start(log, lambda *_: (np.zeros(3), START_COVARIANCE))


def test_one_sigma_is_scaled_and_the_others_stay():
    assert Sigmas().scaled("turn", 10) == Sigmas(turn=1.0)
    assert np.diag(homework_log.Sigmas().control_covariance).round(6).tolist() == [0.0625, 0.01, 0.01]
