"""The blocks of the covariance that change in each step, and the loop that closes, as the lesson's text says them."""

import numpy as np
import pytest

from nao_course.lessons.ekf_slam import draw_blocks, draw_loop, last_deviation
from nao_course.lessons.ekf_slam.blocks import block_steps, changed
from nao_course.lessons.ekf_slam.loop import close_loop, deviations, errors
from nao_course.metrics import band


@pytest.fixture(scope="module")
def functions(own):
    return own["predict"], own["update_landmarks"], own["add_landmark"]


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


def test_one_picture_of_an_early_landmark_shrinks_all_late_ellipses(functions):
    loop = close_loop(functions)
    before, after = deviations(loop.before), deviations(loop.after)
    assert len(before) == 12 and (after < before).all() and loop.numbers[0] == 0
    assert (before[-1], after[-1]) == (pytest.approx(0.56, abs=0.005), pytest.approx(0.156, abs=0.001))
    assert last_deviation(*functions) == pytest.approx(15.6, abs=0.05)
    traces = [np.trace(belief[1][3:, 3:]) for belief in (loop.before, loop.after)]
    assert traces == pytest.approx([2.13, 0.98], abs=0.005)
    assert [100 * errors(loop, each).mean() for each in (loop.before, loop.after)] == pytest.approx(
        [27, 19], abs=0.5
    )
    assert after[0] > 0.95 * before[0] and "trace" not in draw_loop(*functions).alt


def test_the_map_of_the_loop_is_consistent_before_and_after(functions):
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
