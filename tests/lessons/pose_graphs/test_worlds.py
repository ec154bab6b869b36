"""Drives with a known truth: what they measure is what they say."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.pose_graphs import worlds
from nao_course.lessons.pose_graphs.challenge import make_graph
from tests.lessons.pose_graphs.own import OWN


def test_a_pose_between_two_others_is_the_product_of_inverse_and_pose_and_steps_add_up_to_poses(rng):
    first, second = rng.uniform(-3, 3, (2, 20, 3))
    for i, j, found in zip(first, second, worlds.between(first, second), strict=True):
        wanted = Pose.from_array(i).inverse() @ Pose.from_array(j)
        assert found == pytest.approx(wanted.as_array())
    assert worlds.moved(first, worlds.between(first, second)) == pytest.approx(second, abs=1e-12)
    path = np.cumsum(rng.normal(0, 0.5, (30, 3)), axis=0)
    again = worlds.chained(path[0], worlds.between(path[:-1], path[1:]))
    assert again[:, :2] == pytest.approx(path[:, :2])
    assert np.cos(again[:, 2] - path[:, 2]) == pytest.approx(1.0)


def test_odometry_misses_by_what_its_information_says_along_and_across_the_way_at_corners_too():
    world = worlds.building(1, 2000)
    poses = world.graph.split(world.truth)[0]
    missed = OWN["pose_residual"](poses[:-1], poses[1:], world.graph.pose_edges.z[:1999])
    corners = np.abs(np.diff(poses[:, 2])) > 0.1
    assert 100 < corners.sum() < 400
    for steps in (corners, ~corners):
        assert missed[steps].std(axis=0) == pytest.approx(np.array(worlds.ODOMETRY_SIGMA), rel=0.12)
    assert 1 / np.sqrt(np.diag(world.graph.information[0])) == pytest.approx(np.array(worlds.ODOMETRY_SIGMA))


@pytest.mark.parametrize(
    "make",
    [worlds.building, worlds.loop, worlds.field_drive, lambda seed: make_graph(seed).world],
    ids=range(4),
)
def test_chi2_at_the_truth_is_one_for_each_number_that_was_measured(make):
    """Within three standard deviations of its mean over all seeds; false closures left out."""
    total, numbers = 0.0, 0
    for seed in range(1, 16):
        world = make(seed)
        squares = world.graph.squared_errors(world.truth, OWN["pose_residual"], OWN["landmark_residual"])
        true = squares < 100
        to_pose = world.graph.edges[:, 1] < world.graph.poses
        total, numbers = total + squares[true].sum(), numbers + int((2 + to_pose)[true].sum())
    assert abs(total - numbers) < 3 * np.sqrt(2 * numbers)


def test_closures_join_poses_that_are_near_and_far_apart_in_time_and_a_seed_makes_the_same_world():
    world = worlds.building(5)
    poses = world.graph.split(world.truth)[0]
    first, second = world.graph.edges[world.closures()].T
    assert world.closures().sum() == 130 and (first - second >= 20).all()
    assert np.hypot(*(poses[first] - poses[second])[:, :2].T).max() < 1.5
    edges = worlds.with_false_closures(world, 7, 3).graph.edges
    first, second = edges[-7:].T
    assert np.hypot(*(poses[first] - poses[second])[:, :2].T).min() > 12
    assert (edges[:-7] == world.graph.edges).all()
    world = worlds.drifting_loop(np.radians(70), side=5)
    turned = world.graph.split(world.odometry)[0][-1, 2] - world.graph.split(world.truth)[0][-1, 2]
    assert np.cos(turned - np.radians(70)) == pytest.approx(1.0)
    assert OWN["gauss_newton"](world.graph, world.truth, 0)[1][0] > 0, "the odometry is not true"
    assert (worlds.building(4, 50).odometry == worlds.building(4, 50).odometry).all()
    assert (worlds.loop(1).odometry != worlds.loop(2).odometry).any()
    drive = worlds.field_drive(1)
    assert set(drive.graph.landmark_edges.second) == set(range(drive.graph.landmarks)) == set(range(10))
    assert worlds.position_error(drive, drive.truth) == 0.0
