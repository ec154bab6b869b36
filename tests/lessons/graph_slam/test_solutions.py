"""Lesson 08's solutions against what is known: the truth, the paper, a public project, and the lesson's equations."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse

from nao_course.lessons.graph_slam.drivers import numbers_in
from nao_course.lessons.graph_slam.drives import corridor, field_drive, odometry_first
from nao_course.lessons.graph_slam.systems import Builders, assemble, map_error, solve_axes
from tests.lessons.every import own

OWN = own("08")
START, MOTION, MEASUREMENT = (
    OWN[name] for name in ("add_initial_position", "add_relative_motion", "add_relative_measurement")
)
SOLVE, MARGINALIZE, SOLVE_SPARSE = (OWN[name] for name in ("solve", "marginalize", "solve_sparse"))
BUILDERS = Builders(START, MOTION, MEASUREMENT)


def nothing(size):
    return np.zeros((size, size)), np.zeros(size)


def squares(links, x, start):
    """Return the sum of equation 8.1."""
    return (x[0] - start) ** 2 + sum((x[j] - x[i] - z) ** 2 / epsilon for i, j, z, epsilon in links)


def some_links(rng):
    return [
        (i, j, rng.normal(0, 3), rng.uniform(0.1, 4))
        for i, j in ((0, 1), (1, 2), (2, 3), (0, 3), (1, 4), (3, 4))
    ]


def filled(links, size, start):
    system = START(*nothing(size), 0, start)
    for i, j, z, epsilon in links:
        system = MOTION(*system, i, j, z, epsilon)
    return system


def test_the_papers_ten_steps_give_its_entries_and_repeated_measurements_make_the_map_several_times_better():
    omega, xi = MOTION(*nothing(2), 0, 1, 10.0, 4.0)
    assert omega.tolist() == [[0.25, -0.25], [-0.25, 0.25]] and xi.tolist() == [-2.5, 2.5]
    omega, xi = MOTION(*nothing(2), 0, 1, 10.0)
    assert omega.tolist() == [[1, -1], [-1, 1]] and xi.tolist() == [-10, 10]
    with pytest.raises(ValueError, match="0, 1"):
        SOLVE(omega, xi)
    assert SOLVE(*START(omega, xi, 0, 3.0)).tolist() == pytest.approx([3.0, 13.0])
    errors = []
    for drive in map(field_drive, range(12)):
        every = odometry_first(drive)
        maps = [solve_axes(each, drive.size, BUILDERS, SOLVE)[0] for each in (every[: drive.size], every)]
        errors.append([map_error(drive, each) for each in maps])
    first, last = np.median(errors, axis=0)
    assert last < 0.06 < 0.3 < first


@pytest.mark.asserts("eq-8-1", "eq-8-2")
def test_the_additions_are_half_the_derivatives_of_the_sum_of_squares(rng):
    links, start = some_links(rng), 1.5
    omega, xi = filled(links, 5, start)
    for x in rng.normal(0, 3, (10, 5)):
        steps = 1e-5 * np.eye(5)
        derivatives = [(squares(links, x + h, start) - squares(links, x - h, start)) / 2e-5 for h in steps]
        assert omega @ x - xi == pytest.approx(np.array(derivatives) / 2, abs=1e-6)


@pytest.mark.asserts("eq-8-3")
def test_where_every_row_holds_the_sum_of_squares_is_least(rng):
    links, start = some_links(rng), -2.0
    x = SOLVE(*filled(links, 5, start))
    least = squares(links, x, start)
    assert all(squares(links, x + away, start) > least for away in rng.normal(0, 0.1, (200, 5)))


@pytest.mark.asserts("eq-8-4")
def test_a_pose_between_odometry_and_landmark_is_their_weighted_mean(rng):
    for epsilon in rng.uniform(0.01, 20, 20):
        system = MOTION(*START(*nothing(3), 0, 0.0), 0, 1, 5.0, epsilon)
        system = MEASUREMENT(*MEASUREMENT(*system, 0, 2, 9.0), 1, 2, 3.0)
        assert SOLVE(*system)[1] == pytest.approx((5 / epsilon + 6 / 2) / (1 / epsilon + 1 / 2))


@pytest.mark.asserts("eq-8-5")
def test_what_stays_keeps_its_answer_and_its_uncertainty_when_others_are_removed_at_once_or_in_two_steps(rng):
    system = filled(some_links(rng), 5, 4.0)
    x, covariance = SOLVE(*system), np.linalg.inv(system[0])
    for keep in ([0], [4, 1], [2, 0, 3], [0, 1, 2, 3, 4]):
        left = MARGINALIZE(*system, keep)
        assert SOLVE(*left) == pytest.approx(x[keep])
        assert np.linalg.inv(left[0]) == pytest.approx(covariance[np.ix_(keep, keep)])
    twice, once = MARGINALIZE(*MARGINALIZE(*system, [0, 1, 2]), [2, 0]), MARGINALIZE(*system, [2, 0])
    assert twice[0] == pytest.approx(once[0]) and twice[1] == pytest.approx(once[1])


def test_the_worked_examples_are_right_and_shifting_the_start_shifts_the_map_however_heavy_it_is(rng):
    system = MEASUREMENT(*MEASUREMENT(*MOTION(*START(*nothing(3), 0, 0.0), 0, 1, 5.0), 0, 2, 9.0), 1, 2, 3.0)
    assert SOLVE(*system) == pytest.approx([0, 16 / 3, 26 / 3])
    assert MARGINALIZE(*system, [0, 2])[0] == pytest.approx(np.array([[2.5, -1.5], [-1.5, 1.5]]))
    links = some_links(rng)
    x = SOLVE(*filled(links, 5, 0.0))
    assert SOLVE(*filled(links, 5, 7.0)) == pytest.approx(x + 7)
    heavy = filled(links, 5, 7.0)
    for _ in range(99):
        heavy = START(*heavy, 0, 7.0)
    assert SOLVE(*heavy) == pytest.approx(x + 7)


def test_without_noise_dense_and_sparse_give_the_truth_and_they_agree_where_measurements_do_not(rng):
    drive = field_drive(noise=0.0)
    for epsilon, most in ((1.0, 1e-12), (None, 1e-11)):
        constraints = [replace(each, epsilon=epsilon or each.epsilon) for each in drive.constraints]
        for axis in (0, 1):
            omega, xi = assemble(constraints, drive.size, BUILDERS, axis)
            for found in (SOLVE(omega, xi), SOLVE_SPARSE(scipy.sparse.csr_array(omega), xi)):
                assert np.abs(found - drive.truth[:, axis]).max() < most
    walk = corridor(60, rng)
    omega, xi = assemble(walk.constraints, walk.size, BUILDERS, 0)
    for form in ("csc", "csr", "coo"):
        found = SOLVE_SPARSE(scipy.sparse.coo_array(omega).asformat(form), xi)
        assert found == pytest.approx(SOLVE(omega, xi), abs=1e-9)


@pytest.mark.parametrize("loose", [[3, 5], [0, 1, 2, 3, 4, 5], [4]])
def test_a_system_that_nothing_holds_names_its_variables(loose):
    held = [each for each in range(6) if each not in loose]
    system = START(*nothing(6), held[0], 1.0) if held else nothing(6)
    for part in (held, loose):
        for before, after in pairwise(part):
            system = MOTION(*system, before, after, 1.0, 0.3)
    for solve, omega in ((SOLVE, system[0]), (SOLVE_SPARSE, scipy.sparse.csc_array(system[0]))):
        with pytest.raises(ValueError, match="nothing holds") as raised:
            solve(omega, system[1])
        assert numbers_in(str(raised.value)) == loose


@pytest.mark.parametrize("name", ["test_data1", "test_data2"])
def test_the_drives_of_a_public_project_have_their_exact_solution(data_dir, name):
    path = data_dir / "slam" / "udacity" / "test_data.json"
    if not path.is_file():
        pytest.skip("the recorded data here have no slam/udacity")
    case = json.loads(path.read_text())[name]
    poses, size = case["N"], case["N"] + case["num_landmarks"]
    answers = []
    for axis in (0, 1):
        system = START(*nothing(size), 0, case["world_size"] / 2)
        for step, (seen, motion) in enumerate(case["data"]):
            for landmark, *offset in seen:
                system = MEASUREMENT(*system, step, poses + landmark, offset[axis], case["measurement_noise"])
            system = MOTION(*system, step, step + 1, motion[axis], case["motion_noise"])
        dense = SOLVE(*system)
        assert SOLVE_SPARSE(scipy.sparse.csc_array(system[0]), system[1]) == pytest.approx(dense, abs=1e-9)
        answers.append(dense)
    assert np.abs(np.column_stack(answers) - case["exact_solution"]).max() < 1e-9
    printed = np.array(case["expected_poses"] + case["expected_landmarks"])
    assert 0.3 < np.abs(printed - np.array(case["exact_solution"])).max() < 1.4, "as the lesson says"
