"""A filter's consistency over many drives, and how first estimates change it."""

import json
from dataclasses import replace

import numpy as np
import pytest

from nao_course.lessons.ekf_slam.consistency import (
    NOISY,
    compare,
    draw_consistency,
    field_drive,
    follow,
    mean_nees,
    say_rotation,
    with_first_estimates,
    without_pose_map,
)
from nao_course.lessons.ekf_slam.consistency import NOMINAL as NOMINAL_SIGMAS
from nao_course.lessons.ekf_slam.filters import FirstEstimates
from nao_course.lessons.ekf_slam.invariant import INVARIANT, LEVELS
from nao_course.metrics import band
from nao_course.sim.drives import Sigmas
from tests.lessons.every import PROJECT, quotes, text

EXACT = Sigmas(0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("variant", [lambda functions: functions, with_first_estimates])
def test_without_noise_every_pose_is_the_truth(functions, variant):
    drive = field_drive(1, EXACT, laps=1)
    told = [
        replace(
            step,
            control_covariance=NOISY.control_covariance,
            covariances=NOISY.covariances(step.measurements),
        )
        for step in drive.steps
    ]
    assert np.abs(follow(replace(drive, steps=tuple(told)), variant(functions)).errors).max() < 1e-9


def test_the_same_seed_drives_the_same_and_another_does_not():
    first, again, other = field_drive(3, laps=1), field_drive(3, laps=1), field_drive(4, laps=1)
    assert np.array_equal(first.poses, again.poses) and not np.array_equal(first.poses, other.poses)
    assert all(len(step.numbers) for step in first.steps[1:4]) and first.landmarks.shape == (10, 2)


def test_while_all_estimates_are_first_ones_both_filters_are_the_same(functions):
    predict, update_landmarks, add_landmark = functions
    first = FirstEstimates(*functions)
    state, P = np.zeros(3), np.diag([0.1, 0.1, 0.05]) ** 2
    Q, R = NOISY.control_covariance, NOISY.measurement_covariance
    control, seen, again = np.array([0.4, 0.3]), np.array([0.3, 2.0]), np.array([0.1, 1.7])
    one = add_landmark(state, P, seen, R)
    other = first.add_landmark(state, P, seen, R)
    assert np.allclose(one[0], other[0]) and np.allclose(one[1], other[1])
    one, other = predict(*one, control, Q, 1), first.predict(*other, control, Q, 1)
    assert np.allclose(one[0], other[0]) and np.allclose(one[1], other[1])
    one = update_landmarks(*one, [0], again, R)
    other = first.update_landmarks(*other, [0], again, R)
    assert np.allclose(one[0], other[0]) and np.allclose(one[1], other[1])
    one, other = predict(*one, control, Q, 1), first.predict(*other, control, Q, 1)
    assert np.allclose(one[0], other[0]) and not np.allclose(one[1], other[1])


def known_of_the_maps_turn(functions, laps=1, sigma=0.5):
    """Information on a turn of the whole map about the start, before (1 / sigma^2) and after a drive."""
    predict, update_landmarks, add_landmark = functions
    drive = field_drive(7, NOISY, laps)
    Q, R = NOISY.control_covariance, NOISY.measurement_covariance
    state, P = np.zeros(3), np.diag([0.5, 0.5, sigma]) ** 2
    on_map, firsts, predicted = [], [], np.zeros(3)
    for step in drive.steps[1:]:
        seen, measured = step.numbers, step.measurements
        state, P = predict(state, P, step.control, Q, len(on_map))
        predicted = state[:3].copy()
        for landmark, values in zip(seen, measured, strict=True):
            if landmark in on_map:
                continue
            state, P = add_landmark(state, P, values, R)
            on_map.append(landmark)
            firsts.append(state[-2:])
        indices = [on_map.index(landmark) for landmark in seen]
        state, P = update_landmarks(state, P, indices, measured.reshape(-1), R)
    points = np.vstack([predicted[:2], *firsts])
    turn = np.insert(np.column_stack([-points[:, 1], points[:, 0]]).reshape(-1), 2, 1.0)
    return 1 / sigma**2, float(turn @ np.linalg.solve(P, turn))


def test_first_estimates_add_no_information_on_a_rotation_and_only_pose_map_covariances_are_zero(functions):
    before, after = known_of_the_maps_turn(with_first_estimates(functions))
    assert after <= before * (1 + 1e-6)
    before, after = known_of_the_maps_turn(functions)
    assert after > 2 * before
    _, _, add_landmark = functions
    grown = without_pose_map(functions)[2](np.zeros(3), np.eye(3), np.array([0.1, 1.0]), np.eye(2))[1]
    wanted = add_landmark(np.zeros(3), np.eye(3), np.array([0.1, 1.0]), np.eye(2))[1]
    assert np.array_equal(grown[:3, :3], wanted[:3, :3]) and np.array_equal(grown[3:, 3:], wanted[3:, 3:])
    assert not grown[:3, 3:].any() and not grown[3:, :3].any() and wanted[3:, :3].any()


def test_an_update_makes_a_rotation_observable_to_the_next_jacobians(functions):
    _, first, old, new = say_rotation(functions[1]).splitlines()
    assert first.startswith(" 0.000  0.000") and new.startswith(" 0.000  0.000")
    assert all(abs(float(value)) > 0.03 for value in old.split()[:2])


def test_the_figure_says_the_means_and_the_band(functions):
    found = compare(*functions, runs=2, variants=("your filter", "first estimates"), with_nis=True)
    low, high = band(3, 2)
    assert 0.5 < np.concatenate([trace.nis for trace in found["your filter"]]).mean() < 1.5
    said = draw_consistency(found).alt
    assert all(f"{name} {mean_nees(traces):.2f}" in said for name, traces in found.items())
    assert f"between {low:.2f} and {high:.2f}" in said


def test_the_lesson_quotes_the_recorded_means_of_200_drives_at_three_levels():
    recorded = json.loads((PROJECT / "benchmarks" / "results" / "ekf_consistency.json").read_text("utf-8"))
    found = recorded["invariant"]
    low, high = found["band"]
    plain, first, invariant = (
        [found[f"{level}, {name}"]["nees"] for level in LEVELS]
        for name in ("your filter", "first estimates", INVARIANT)
    )
    quotes(
        text("07"),
        f"{found['runs']} drives (band {low:.2f} to {high:.2f})",
        "is {:.1f}, {:.1f} and {:.1f}".format(*plain),
        "have {:.1f}, {:.1f} and {:.0f}".format(*first),
        "filter {:.1f}, {:.1f} and {:.1f}".format(*invariant),
        f"alone is {found[f'harsh, {INVARIANT}']['heading']:.2f}",
    )
    assert low < invariant[1] < high < 2 * high < plain[1]


@pytest.mark.slow
def test_over_a_hundred_drives_the_filter_is_consistent_on_the_nominal_field(functions):
    low, high = band(3, 100)
    assert (round(low, 2), round(high, 2)) == (2.54, 3.50)
    found = compare(*functions, sigmas=NOMINAL_SIGMAS, variants=("your filter", "first estimates"))
    assert low < mean_nees(found["your filter"]) < high
    assert low < mean_nees(found["first estimates"]) < high


@pytest.mark.slow
def test_over_a_hundred_noisy_drives_only_first_estimates_stay_in_the_band_and_nis_sees_nothing(functions):
    low, high = band(3, 100)
    found = compare(*functions, sigmas=NOISY, with_nis=True)
    nees = {name: mean_nees(traces) for name, traces in found.items()}
    assert nees["your filter"] > 2 * high
    assert low < nees["first estimates"] < high
    assert nees["no covariance between pose and map"] > 20
    for traces in found.values():
        assert 0.85 < np.concatenate([trace.nis for trace in traces]).mean() < 1.15
