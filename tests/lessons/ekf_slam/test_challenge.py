"""The challenge of lesson 07: two laps at three times the noise, and a score that only honest beliefs get."""

import numpy as np
import pytest

from benchmarks.challenges.ekf_slam import EKF_ENTRIES, odometry
from nao_course.lessons.ekf_slam.challenge import CHALLENGE, DEEPEST, judge, make_drive


def test_odometry_alone_gains_nothing_and_to_be_sure_of_a_wrong_place_costs_more():
    drive = make_drive(5)
    pose, covariance = odometry(drive.log)
    assert np.abs(covariance - drive.odometry_covariance).max() < 1e-9
    assert judge((pose, covariance), drive).score == pytest.approx(0, abs=1e-9)
    drive = make_drive(5)
    scored = judge((drive.path[-1] + (0.3, 0, 0), np.diag([0.02, 0.02, 0.02]) ** 2), drive)
    assert scored.score == DEEPEST and scored.columns["NEES"] == pytest.approx(225)
    assert scored.columns["off"] == pytest.approx(30)


def test_the_log_is_of_two_laps_and_sees_only_what_is_near_and_ahead():
    drive = make_drive(5)
    assert len(drive.log) == len(drive.path) == 51
    assert not drive.log[0][0].any() and not drive.log[0][1].any()
    for _, _, numbers, measurements, R in drive.log:
        assert len(measurements) == 2 * len(numbers) and R.shape == (2, 2)
        assert set(numbers) <= set(range(10))
    assert np.array_equal(make_drive(5).path, drive.path)
    assert not np.array_equal(make_drive(6).path, drive.path)


def test_the_recorded_rows_say_what_the_lesson_says():
    rows = {row.name: row for row in CHALLENGE.rows}
    assert list(rows) == list(EKF_ENTRIES)
    assert rows["the reference"].columns["NEES"] == pytest.approx(6.3, abs=0.05)
    assert rows["a better one"].columns["NEES"] == pytest.approx(3.0, abs=0.05)
    assert rows["a better one"].score - rows["the reference"].score == pytest.approx(2.04, abs=0.01)
    cases = zip(rows["a better one"].cases, rows["the reference"].cases, strict=True)
    assert sum(better > reference for better, reference in cases) == 22
    assert min(rows["the reference"].cases) == pytest.approx(-19.3, abs=0.1)


@pytest.mark.slow
def test_a_larger_covariance_makes_the_reference_consistent_and_does_not_reach_the_better_entry():
    scored = []
    for seed in CHALLENGE.seeds:
        drive = make_drive(seed)
        state, covariance = EKF_ENTRIES["the reference"](drive.log)
        scored.append(judge((state, 2.1 * covariance), drive))
    rows = {row.name: row.score for row in CHALLENGE.rows}
    bits = np.mean([each.score for each in scored])
    before = next(row.cases for row in CHALLENGE.rows if row.name == "the reference")
    assert sum(each.score > was for each, was in zip(scored, before, strict=True)) == 16
    assert np.mean([each.columns["NEES"] for each in scored]) == pytest.approx(3.0, abs=0.05)
    assert bits - rows["the reference"] == pytest.approx(0.8, abs=0.05)
    assert rows["a better one"] - bits > 1.2


def test_the_lessons_own_entry_scores_as_the_reference(own):
    def my_slam(log):
        state, covariance, known = np.zeros(3), np.zeros((3, 3)), []
        for control, Q, numbers, measurements, R in log:
            state, covariance = own["predict"](state, covariance, control, Q, len(known))
            pairs = measurements.reshape(-1, 2)
            again = [j for j, number in enumerate(numbers) if number in known]
            if again:
                indices = [known.index(numbers[j]) for j in again]
                again = pairs[again].ravel()
                state, covariance = own["update_landmarks"](state, covariance, indices, again, R)
            for number, pair in zip(numbers, pairs, strict=True):
                if number not in known:
                    state, covariance = own["add_landmark"](state, covariance, pair, R)
                    known.append(number)
        return state, covariance

    recorded = next(row for row in CHALLENGE.rows if row.name == "the reference")
    for seed in (0, 7, 21):
        drive = make_drive(seed)
        assert judge(my_slam(drive.log), drive).score == pytest.approx(recorded.cases[seed], abs=1e-3)
