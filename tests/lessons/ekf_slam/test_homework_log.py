"""The homework's drive, the course's own log, and the report's ten ablations of the standard deviations."""

import numpy as np
import pytest

from nao_course.datasets import HomeworkLog, read_homework_log, write_homework_log
from nao_course.geometry import wrap_angle
from nao_course.instructor.authoring.plans import load_solution
from nao_course.lessons.ekf_slam import homework_log
from nao_course.lessons.ekf_slam.ablations import ablate, ablation_table, draw_ablations
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS, own_log
from nao_course.metrics import band
from nao_course.sim.drives import Sigmas, landmark_blocks
from tests.paths import SOLUTIONS

# The report's Table 1, as it is printed.
EUCLIDEAN = ["0.0021917", "0.0041727", "0.0025231", "0.0027936", "0.0019271", "0.0039974"]
PRINTED = ["8.5549e-05", "2.3433e-04", "1.1250e-04", "1.1257e-04", "1.1666e-04", "1.5250e-04"]
MAHALANOBIS = ["0.05750", "0.07660", "0.05785", "0.07265", "0.03285", "0.10768"]
TEXTBOOK = ["0.0042", "0.0062", "0.0086", "0.0114", "0.0091", "0.0102"]  # with the textbook's start


@pytest.fixture(scope="module")
def log(data_dir):
    return read_homework_log(data_dir / "slam" / "cmu16833_hw2" / "data.txt")


@pytest.fixture(scope="module")
def run(log, own):
    return homework_log.run_log(
        log, homework_log.homework_start(log, own["init_landmarks"]), own["predict"], own["update"]
    )


def test_the_reports_table_1_comes_out_of_the_homeworks_log_whose_sigmas_are_far_too_large(run, log, own):
    found = homework_log.landmark_errors(run.landmarks, run.landmark_covariances)
    assert [f"{value:.7f}" for value in found.euclidean] == EUCLIDEAN
    assert [f"{value:.4e}" for value in found.printed] == PRINTED
    assert [f"{value:.5f}" for value in found.mahalanobis] == MAHALANOBIS
    low, high = band(12, len(run.nis))
    assert (round(low, 1), round(high, 1)) == (10.3, 13.8)
    assert round(run.nis.mean(), 3) == 0.084
    start = homework_log.textbook_start(log, own["add_landmark"])
    run = homework_log.run_log(log, start, own["predict"], own["update"])
    found = homework_log.landmark_errors(run.landmarks, run.landmark_covariances)
    assert [f"{value:.4f}" for value in found.euclidean] == TEXTBOOK


def test_the_shipped_log_is_the_one_that_the_seed_makes_and_lies_in_its_band_with_its_sigmas(tmp_path, own):
    made = write_homework_log(homework_log.record_pentagon().log, tmp_path / "made.txt")
    assert made.read_text() == homework_log.OWN_LOG.read_text()
    assert (homework_log.own_log().k, homework_log.own_log().controls.shape) == (6, (25, 2))
    log = homework_log.own_log()
    start = homework_log.homework_start(log, own["init_landmarks"], homework_log.OWN_SIGMAS)
    run = homework_log.run_log(log, start, own["predict"], own["update"], homework_log.OWN_SIGMAS)
    low, high = band(12, len(run.nis))
    assert low < run.nis.mean() < high
    assert Sigmas().scaled("turn", 10) == Sigmas(turn=1.0)
    assert np.diag(homework_log.Sigmas().control_covariance).round(6).tolist() == [0.0625, 0.01, 0.01]


def test_without_noise_every_pose_and_landmark_is_the_truth(own):
    exact = Sigmas(0.0, 0.0, 0.0, 0.0, 0.0)
    recording = homework_log.record_pentagon(sigmas=exact)
    start = homework_log.textbook_start(recording.log, own["add_landmark"], exact)
    run = homework_log.run_log(recording.log, start, own["predict"], own["update"])
    off = run.states[:, :3] - recording.path
    assert np.abs(off[:, :2]).max() < 1e-9 and np.abs(wrap_angle(off[:, 2])).max() < 1e-9
    assert np.abs(run.landmarks - recording.landmarks).max() < 1e-9


def test_all_steps_are_kept_and_left_out_updates_change_nothing_and_wrong_results_are_said_by_name(own):
    log = homework_log.own_log()
    start = homework_log.homework_start(log, own["init_landmarks"], homework_log.OWN_SIGMAS)
    run = homework_log.run_log(log, start, own["predict"], own["update"], homework_log.OWN_SIGMAS, every=5)
    assert run.states.shape == (26, 15) and run.predicted_covariances.shape == (25, 15, 15)
    assert run.updated.nonzero()[0].tolist() == [4, 9, 14, 19, 24] and len(run.nis) == 5
    assert np.array_equal(run.states[1:][~run.updated], run.predicted_states[~run.updated])
    assert not np.array_equal(run.states[5], run.predicted_states[4])
    assert np.array_equal(landmark_blocks(run.covariances[3])[1], run.covariances[3][5:7, 5:7])
    log = HomeworkLog([[0.1, 2.0]] * 2, [[0.5, 0.0]])
    start = (np.array([0.0, 0.0, 0.0, 2.0, 0.0]), np.eye(5))
    with pytest.raises(ValueError, match=r"predict must return \(state, covariance\), got NoneType"):
        homework_log.run_log(log, start, lambda *_: None, own["update"])
    with pytest.raises(ValueError, match=r"update must return shapes \(5,\) and \(5, 5\), got \(3,\)"):
        homework_log.run_log(log, start, own["predict"], lambda *_: (np.zeros(3), np.eye(3)))
    with pytest.raises(ValueError, match=r"init_landmarks must return \(1, \(2,\), \(2, 2\)\)"):
        homework_log.homework_start(log, lambda *_: (2, np.zeros(4), np.eye(4)))
    with pytest.raises(ValueError, match="add_landmark must return"):
        homework_log.textbook_start(log, lambda *_: (np.zeros(3), homework_log.START_COVARIANCE))


def test_innovation_and_covariance_are_those_of_lesson_05s_jacobians(rng):
    report = load_solution(SOLUTIONS / "05_ekf_derivations.ipynb")
    state = rng.uniform(-2, 2, 9)
    root = rng.normal(size=(9, 9))
    covariance, R = root @ root.T, np.diag([0.01, 0.04])
    seen = rng.uniform(0.5, 2, 4)
    innovation, S = homework_log.innovation_and_covariance(state, covariance, [2, 0], seen, R)
    H, expected = np.zeros((4, 9)), np.zeros(4)
    for row, number in ((0, 2), (2, 0)):
        landmark = state[3 + 2 * number : 5 + 2 * number]
        expected[row : row + 2] = report["expected_measurement"](state[:3], landmark)
        H[row : row + 2, :3] = report["measurement_jacobian_pose"](state[:3], landmark)
        at = slice(3 + 2 * number, 5 + 2 * number)
        H[row : row + 2, at] = report["measurement_jacobian_landmark"](state[:3], landmark)
    wanted = seen - expected
    wanted[::2] = wrap_angle(wanted[::2])
    assert np.allclose(innovation, wanted)
    assert np.allclose(S, H @ covariance @ H.T + np.kron(np.eye(2), R), rtol=1e-6)


@pytest.fixture(scope="module")
def ablations(film_functions):
    return ablate(own_log(), *film_functions, OWN_SIGMAS)


def test_there_are_the_reports_ten_in_its_order_and_table_and_figure_say_the_same(ablations):
    assert [each.title for each in ablations] == [
        *("unchanged", "σx × 10", "σx / 10", "σy × 10", "σy / 10", "σα × 10", "σα / 10"),
        *("σβ × 10", "σβ / 10", "σr × 10", "σr / 10"),
    ]
    table = ablation_table(ablations)
    assert [row[0] for row in table.rows] == [each.title for each in ablations]
    assert table.rows[0][1] == f"{100 * ablations[0].position:.3g}"
    drawing = draw_ablations(ablations)
    assert [ax.get_title(loc="left") for ax in drawing.figure.axes if ax.axison] == [
        *("unchanged", "σx × 10", "σy × 10", "σα × 10", "σβ × 10", "σr × 10"),
        *("σx / 10", "σy / 10", "σα / 10", "σβ / 10", "σr / 10"),
    ]
    assert f"σx × 10: {ablations[1].position / ablations[0].position:.2g} and" in drawing.alt


def test_control_noise_widens_the_prediction_along_or_across_and_measurement_noise_the_map(ablations):
    base, *changed = ablations
    larger = {each.name: each for each in changed if each.factor > 1}
    for name in ("along", "across"):
        assert larger[name].position > 3 * base.position
        assert larger[name].landmark < 1.1 * base.landmark
    for name in ("bearing", "range"):
        assert larger[name].landmark > 1.5 * base.landmark
    for name, axis in (("along", 0), ("across", 1)):
        run = next(each for each in ablations if each.name == name and each.factor > 1).run
        theta, P = run.predicted_states[12, 2], run.predicted_covariances[12, :2, :2]
        robot = np.array([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
        variances = np.diag(robot @ P @ robot.T)
        assert variances[axis] > 20 * variances[1 - axis]


def test_sigma_alpha_looks_harmless_only_while_each_turn_is_corrected_at_once(ablations, film_functions):
    def growth(runs):
        [turn] = [each for each in runs if (each.name, each.factor) == ("turn", 10)]
        return turn.position / runs[0].position

    assert growth(ablations) < 1.05
    assert growth(ablate(own_log(), *film_functions, OWN_SIGMAS, every=5)) > 3


def test_the_nis_shows_what_the_lesson_says(ablations):
    nis = {each.title: round(each.nis, 1) for each in ablations}
    assert (nis["σβ / 10"], nis["σr / 10"]) == pytest.approx((295, 390), abs=0.5)
    assert [nis[name] for name in ("σβ × 10", "σr × 10", "σα / 10", "σx / 10", "σy / 10")] == [
        *(6.0, 5.8, 20.5, 14.3, 13.8)
    ]
    assert [nis[name] for name in ("σx × 10", "σy × 10", "σα × 10")] == [11.0, 11.2, 11.3]
    low, high = band(12, len(ablations[0].run.nis))
    assert (round(low, 1), round(high, 1)) == (10.2, 14.0) and nis["σx / 10"] > high > nis["σy / 10"]
    positions = {each.title: f"{100 * each.position:.1f}" for each in ablations}
    assert (positions["unchanged"], positions["σα × 10"]) == ("5.4", "5.5")
    assert f"{100 * ablations[0].updated_position:.1f}" == "4.1"


def test_on_the_homeworks_log_the_reports_findings_hold(film_functions, data_dir):
    log = read_homework_log(data_dir / "slam" / "cmu16833_hw2" / "data.txt")
    base, *changed = ablate(log, *film_functions)
    growth = {each.title: each.position / base.position for each in changed}
    assert growth["σx × 10"] > 7 and growth["σy × 10"] > 3 and growth["σα × 10"] < 1.01
    assert next(each for each in changed if each.title == "σβ / 10").landmark < base.landmark / 3
