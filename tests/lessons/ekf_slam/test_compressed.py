"""The compressed filter is the full filter, to rounding, whatever is driven among near landmarks."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nao_course.geometry import wrap_angle
from nao_course.lessons.ekf_slam.filters import CompressedFilter
from nao_course.slam import range_and_bearing

Q, R = np.diag([0.05, 0.03, 0.04]) ** 2, np.diag([0.03, 0.05]) ** 2


def large_map(rng, k):
    """A state of pose and k landmarks, all correlated."""
    state = np.concatenate([[0.1, -0.2, 0.3], rng.uniform(-4, 4, 2 * k)])
    root = rng.normal(0, 0.05, (len(state), 8))
    return state, root @ root.T + np.diag(rng.uniform(0.01, 0.05, len(state)) ** 2)


def along(rng, state, covariance, regions, own, new, steps=6):
    """Drive through regions of near landmarks with both filters; yields both beliefs after each region."""
    names = ("predict", "update_landmarks", "add_landmark")
    predict, update_landmarks, add_landmark = (own[name] for name in names)
    k = (len(state) - 3) // 2
    truth = state.copy()
    full, small = (state.copy(), covariance.copy()), None
    for near in regions:
        if small is None:
            small = CompressedFilter(predict, update_landmarks, add_landmark, state, covariance, near)
        else:
            small.move_to(near)
        for _ in range(steps):
            control = np.array([rng.uniform(-0.3, 0.4), rng.uniform(-0.6, 0.6)])
            truth = predict(truth, covariance, control, Q, k)[0]
            full = predict(*full, control, Q, k)
            small.predict(control, Q)
            indices = sorted(rng.choice(near, rng.integers(0, len(near) + 1), replace=False).tolist())
            if indices:
                seen = range_and_bearing(truth[:3], truth[3:].reshape(-1, 2)[indices])
                seen = (seen + rng.normal(size=seen.shape) * (0.03, 0.05)).reshape(-1)
                full = update_landmarks(*full, indices, seen, R)
                small.update_landmarks(indices, seen, R)
        if new:
            seen = np.array([rng.uniform(-2, 2), rng.uniform(0.5, 3)])
            full, k = add_landmark(*full, seen, R), k + 1
            truth = add_landmark(truth, full[1][:-2, :-2], seen, R)[0]
            assert small.add_landmark(seen, R) == k - 1
            again = np.array([0.1, 1.0])
            full = update_landmarks(*full, [k - 1, *near], np.tile(again, 1 + len(near)), R)
            small.update_landmarks([k - 1, *near], np.tile(again, 1 + len(near)), R)
        yield full, small


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**6), near=st.integers(1, 5), new=st.booleans())
def test_on_any_drive_among_near_landmarks_it_equals_the_full_filter(own, seed, near, new):
    rng = np.random.default_rng(seed)
    k = int(rng.integers(near, 12))
    regions = [rng.choice(k, near, replace=False).tolist() for _ in range(3)]
    for (state, covariance), small in along(rng, *large_map(rng, k), regions, own, new):
        assert np.allclose(small.local[0][:3], state[:3], atol=1e-9)
        assert np.allclose(small.local[1][:3, :3], covariance[:3, :3], atol=1e-9)
        whole, whole_covariance = small.whole()
        off = whole - state
        off[2] = wrap_angle(off[2])
        assert np.abs(off).max() < 1e-9
        assert np.abs(whole_covariance - covariance).max() < 1e-9


def test_far_landmarks_are_not_touched_before_the_robot_leaves(functions):
    rng = np.random.default_rng(6)
    state, covariance = large_map(rng, 400)
    sizes = []

    def spied(function):
        def watched(state, *rest):
            sizes.append(len(state))
            return function(state, *rest)

        return watched

    small = CompressedFilter(*map(spied, functions), state, covariance, [7, 3, 399])
    small.predict(np.array([0.2, 0.1]), Q)
    small.update_landmarks([399, 7], np.array([0.3, 2.0, 1.0, 3.0]), R)
    assert sizes == [19, 19]  # twice 9, and one more
    assert small.near == [7, 3, 399]


def test_a_landmark_that_is_not_near_is_refused_and_what_comes_in_stays_as_it_is(functions):
    state, covariance = large_map(np.random.default_rng(7), 6)
    small = CompressedFilter(*functions, state, covariance, [0, 1])
    with pytest.raises(ValueError, match=r"landmarks \[4\] are not near; call move_to\(\) first"):
        small.update_landmarks([0, 4], np.zeros(4), R)
    state, covariance = large_map(np.random.default_rng(8), 6)
    given = state.copy(), covariance.copy()
    small = CompressedFilter(*functions, state, covariance, [0, 1])
    small.predict(np.array([0.2, 0.1]), Q)
    small.update_landmarks([0], np.array([0.3, 2.0]), R)
    whole = small.whole()
    whole[1][:] = 0
    assert np.array_equal(state, given[0]) and np.array_equal(covariance, given[1])
    assert small.whole()[1].any()


def test_from_nothing_a_map_grows_as_in_the_full_filter(functions):
    predict, update_landmarks, add_landmark = functions
    small, full = CompressedFilter(*functions), (np.zeros(3), np.zeros((3, 3)))
    for number, bearing in enumerate((0.3, -0.5, 1.2)):
        small.predict(np.array([0.3, 0.2]), Q)
        full = predict(*full, np.array([0.3, 0.2]), Q, number)
        assert small.add_landmark(np.array([bearing, 2.0]), R) == number
        full = add_landmark(*full, np.array([bearing, 2.0]), R)
        small.update_landmarks([0], np.array([0.2, 1.8]), R)
        full = update_landmarks(*full, [0], np.array([0.2, 1.8]), R)
        if number == 1:
            small.move_to([0])
    assert small.near == [0, 2]
    assert all(np.allclose(*both, atol=1e-12) for both in zip(small.whole(), full, strict=True))
