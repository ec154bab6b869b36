"""Lesson 09's solutions against what is known: the equations, the truth, and the standard graphs' optima."""

import numpy as np
import pytest

from nao_course import datasets
from nao_course.geometry import Pose, rotation_2d, wrap_angle
from nao_course.graphs import POSE, Graph
from nao_course.lessons.pose_graphs import building, disturbed, field_drive, loop, position_error
from tests.lessons.pose_graphs.own import OWN

RESIDUAL, JACOBIANS = OWN["pose_residual"], OWN["pose_residual_jacobians"]
LANDMARK_RESIDUAL, LANDMARK_JACOBIANS = OWN["landmark_residual"], OWN["landmark_residual_jacobians"]
LINEARIZE, SOLVE, BLOCKS, REWEIGHT = (
    OWN[name] for name in ("linearize", "gauss_newton", "marginal_covariances", "reweight")
)
POINTS = 1000


def poses(rng, count=POINTS):
    """Poses all over the plane; a third of the headings within a milliradian of pi."""
    found = rng.normal(0.0, 5.0, (count, 3))
    found[:, 2] = rng.uniform(-np.pi, np.pi, count)
    found[::3, 2] = wrap_angle(np.pi + rng.uniform(-1e-3, 1e-3, len(found[::3])))
    return found


def differences(residual, first, second, z, step=1e-6):
    """Central differences of a residual by both ends, (E, d, n) each; angles on the circle."""
    found = []
    for by_first, size in ((True, first.shape[1]), (False, second.shape[1])):
        columns = []
        for move in step * np.eye(size):
            high, low = (
                residual(first + sign * move, second, z)
                if by_first
                else residual(first, second + sign * move, z)
                for sign in (1, -1)
            )
            change = high - low
            change[:, 2:] = wrap_angle(change[:, 2:])
            columns.append(change / (2 * step))
        found.append(np.stack(columns, axis=2))
    return found


@pytest.mark.asserts("eq-9-1")
def test_a_landmarks_residual_is_its_position_in_the_robots_frame_minus_the_measurement(rng):
    places = rng.normal(0, 5, (2, 30, 2))
    for pose, landmark, z in zip(poses(rng, 30), *places, strict=True):
        expected = rotation_2d(pose[2]).T @ (landmark - pose[:2]) - z
        assert LANDMARK_RESIDUAL(pose, landmark, z) == pytest.approx(expected)


@pytest.mark.asserts("eq-9-3", "eq-9-4")
def test_a_poses_residual_is_the_three_numbers_of_the_product_of_matrices(rng):
    for first, second, z in zip(poses(rng, 60), poses(rng, 60), poses(rng, 60), strict=True):
        i, j, measured = (Pose.from_array(each) for each in (first, second, z))
        product = (measured.inverse() @ i.inverse() @ j).as_array()
        moved = rotation_2d(z[2]).T @ (rotation_2d(first[2]).T @ (second[:2] - first[:2]) - z[:2])
        found = RESIDUAL(first, second, z)
        assert found[:2] == pytest.approx(product[:2]) and found[:2] == pytest.approx(moved)
        assert wrap_angle(found[2] - product[2]) == pytest.approx(0.0, abs=1e-12)
        assert -np.pi < found[2] <= np.pi


@pytest.mark.asserts("eq-9-2")
def test_jacobians_are_central_differences_at_a_thousand_points_near_pi_too(rng):
    ends = poses(rng), poses(rng), poses(rng)
    marked = ends[0], rng.normal(0, 5, (POINTS, 2)), rng.normal(0, 5, (POINTS, 2))
    for jacobians, residual, given in (
        (JACOBIANS, RESIDUAL, ends),
        (LANDMARK_JACOBIANS, LANDMARK_RESIDUAL, marked),
    ):
        for own, numeric in zip(jacobians(*given), differences(residual, *given), strict=True):
            assert np.abs(own - numeric).max() < 1e-6
    x, y, theta = ends[0].T
    dx, dy, c, s = marked[1][:, 0] - x, marked[1][:, 1] - y, np.cos(theta), np.sin(theta)
    column = LANDMARK_JACOBIANS(*marked)[0][:, :, 2]
    assert column == pytest.approx(np.stack([-s * dx + c * dy, -c * dx - s * dy], axis=1))


@pytest.mark.asserts("eq-9-5")
def test_h_and_b_are_sums_over_the_edges_and_half_the_gradient_of_chi2():
    drive = field_drive(3, 8)
    graph, states = drive.graph, drive.odometry
    H, b = LINEARIZE(graph, states)
    sum_h, sum_b = np.zeros(H.shape), np.zeros(len(b))
    nodes, marks = np.split(states[: 3 * graph.poses], graph.poses), graph.split(states)[1]
    for edges, ends, residual, jacobians in (
        (graph.pose_edges, nodes, RESIDUAL, JACOBIANS),
        (graph.landmark_edges, marks, LANDMARK_RESIDUAL, LANDMARK_JACOBIANS),
    ):
        for k, places in enumerate(edges.places):
            pair = nodes[edges.first[k]], ends[edges.second[k]], edges.z[k]
            J, omega = np.hstack(jacobians(*pair)), edges.information[k]
            sum_h[np.ix_(places, places)] += J.T @ omega @ J
            sum_b[places] += J.T @ omega @ residual(*pair)
    assert H.toarray() == pytest.approx(sum_h) and b == pytest.approx(sum_b)
    move = np.random.default_rng(1).normal(0, 1e-6, len(b))
    moved = (states + move, states - move)
    high, low = (graph.squared_errors(each, RESIDUAL, LANDMARK_RESIDUAL).sum() for each in moved)
    assert (high - low) / 4 == pytest.approx(b @ move, rel=1e-4)


@pytest.mark.asserts("eq-9-6")
def test_a_weight_is_the_derivative_of_cauchys_kernel():
    world, width, step = loop(2, side=3), 2.5, 1e-6
    squares = world.graph.squared_errors(world.odometry, RESIDUAL, LANDMARK_RESIDUAL)
    high, low = (width**2 * np.log1p((squares + sign * step) / width**2) for sign in (1, -1))
    reweighted = REWEIGHT(world.graph, world.odometry, width).information[:, 0, 0]
    assert reweighted / world.graph.information[:, 0, 0] == pytest.approx((high - low) / (2 * step), rel=1e-5)


@pytest.mark.parametrize(
    "world", [building(3, 120, noise=0.0), loop(1, noise=0.0), field_drive(1, noise=0.0)]
)
def test_without_noise_the_odometry_and_the_solution_are_the_truth(world, rng):
    assert is_true(world, world.odometry)
    states, history = SOLVE(world.graph, disturbed(world, 1.0, 0.1, rng), 8)
    assert position_error(world, states) < 1e-9 and history[-1] < 1e-12
    assert world.graph.split(states)[1] == pytest.approx(world.graph.split(world.truth)[1], abs=1e-9)


def is_true(world, states):
    """Whether states are the truth, headings on the circle."""
    away = states - world.truth
    headings = slice(2, 3 * world.graph.poses, 3)
    away[headings] = wrap_angle(away[headings])
    return np.abs(away).max() < 1e-9


def test_the_first_pose_stays_and_nothing_given_is_changed_and_without_it_h_has_three_zeros_anywhere(rng):
    world = building(2, 60)
    before = world.odometry.copy()
    states, history = SOLVE(world.graph, world.odometry, 3)
    assert (states[:3] == before[:3]).all() and (world.odometry == before).all() and history.shape == (4,)
    graph = Graph([[0, 1]], [[1.0, 0.0, 0.0]], [np.eye(3)], [POSE, POSE])
    states, history = SOLVE(graph, np.array([0.0, 0.0, 0.0, 5.0, 0.0, 0.0]), 1)
    assert states[3:] == pytest.approx([1, 0, 0]) and history == pytest.approx([16, 0])
    world = loop(4, side=2)
    for states in (world.odometry, world.truth, disturbed(world, 3.0, 1.0, rng)):
        values = np.linalg.eigvalsh(LINEARIZE(world.graph, states)[0].toarray())
        assert np.count_nonzero(np.abs(values) < 1e-9 * values[-1]) == 3


def test_covariances_are_blocks_of_the_inverse_and_consistent_unlike_blocks_of_h():
    scores = {"marginal": [], "conditional": []}
    for seed in range(40):
        world = loop(1000 + seed, side=3)
        rows = 3 * (world.graph.poses // 2 - 1) + np.arange(3)
        states, _ = SOLVE(world.graph, world.odometry, 5)
        H = LINEARIZE(world.graph, states)[0][3:, 3:].tocsc()
        [block] = BLOCKS(H, [rows])
        assert block == pytest.approx(np.linalg.inv(H.toarray())[np.ix_(rows, rows)])
        error = (states - world.truth)[rows + 3]
        error[2] = wrap_angle(error[2])
        scores["marginal"].append(error @ np.linalg.solve(block, error))
        scores["conditional"].append(error @ H.toarray()[np.ix_(rows, rows)] @ error)
    assert 2.3 < np.mean(scores["marginal"]) < 3.8  # 95 % band of a consistent estimate: 2.3 to 3.8
    assert np.mean(scores["conditional"]) > 15


def standard(name):
    try:
        if name == "freiburg":
            return datasets.read_freiburg_graph()
        return datasets.read_g2o(datasets.data_folder() / "slam" / "g2o" / name)
    except FileNotFoundError as missing:
        pytest.skip(str(missing))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "steps", "before", "after", "within"),
    [
        ("openslam_intel.g2o", 5, 1331.50, 546.461, 2e-6),
        ("input_M3500_g2o.g2o", 8, 2566670.0, 137.913, 2e-6),
        ("MIT.g2o", 40, 4.41418e9, 770.6635, 2e-6),
        ("city10000.g2o", 8, 6.54163e8, 511.985, 2e-6),
        ("freiburg", 8, 3030, 474, 1e-3),
    ],
)
def test_the_standard_graphs_reach_their_known_optimum(name, steps, before, after, within):
    graph, states = standard(name)
    _, history = SOLVE(graph, states, steps)
    assert (history[0], history[-1]) == pytest.approx((before, after), rel=within)
