"""Pose graphs from the laser scans of a log: motions and loop closures that the scans measure."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from nao_course.datasets import CarmenLog
from nao_course.geometry import FloatArray, Pose
from nao_course.graphs import POSE, Graph
from nao_course.lessons.pose_graphs.worlds import between, chained

GaussNewton = Callable[[Graph, FloatArray, int], tuple[FloatArray, FloatArray]]

SPACING, TURN = 0.5, 0.5  # m and rad between two scans that are used
REACH = 40.0  # m; longer ranges hit nothing, or too far away
PAIRS = 1.0, 0.5, 0.3, 0.2, 0.15, 0.1  # m between points that are matched, in turn
SIGMA = 0.05  # m, of a point
TOGETHER = 10.0  # points that count as one, because the errors of neighbouring points are correlated
MOTION, CLOSURE = 0.6, 0.75  # share of the points that must match, for a motion and for a loop closure
ODOMETRY = np.diag([100.0, 100.0, 100.0])  # information of a step whose scans do not match: 0.1 m and 0.1 rad
NEAR, APART = 3.0, 20  # largest distance in m, and smallest number of steps, between the poses of a closure
CHANGE = 2.0, 0.5  # m and rad by which a closure may correct the current estimate
BLOCK, STEPS = 30, 3  # poses between two searches of closures, and steps of the solver after each search


class Scan(NamedTuple):
    """Points (n, 2) of a scan in the robot's frame, their normals (n, 2), and a tree that finds them."""

    points: FloatArray
    normals: FloatArray
    tree: cKDTree


class Edge(NamedTuple):
    """Pose z (3,) of a scan in the frame of another one, by their numbers, and its information (3, 3)."""

    first: int
    second: int
    z: FloatArray
    information: FloatArray


class Match(NamedTuple):
    """Pose of a scan in the frame of another one, its information (3, 3), and the share of points that match."""

    pose: Pose
    information: FloatArray
    share: float


def graph_of_scans(log: CarmenLog, gauss_newton: GaussNewton) -> tuple[Graph, FloatArray, FloatArray]:
    """Return a graph whose edges are measured by a log's scans, its states by odometry, and its solution.

    Each scan is matched with the next one. After each `BLOCK` of poses, each pose is also matched with the nearest
    much earlier pose of the current solution, and the graph is solved.

    The graph has a pose for each scan that is used, which is at least 0.5 m or 0.5 rad after the last one. Both states
    (graph.size,) are in m and rad. Raise a ValueError if the robot does not move.
    """
    used = used_scans(log)
    if len(used) < 2:
        raise ValueError("The robot of this log does not move, so there is no graph")
    scans = [scan_of(log, number) for number in used]
    odometry = log.odometry[used]
    told = between(odometry[:-1], odometry[1:])
    edges = [_motion(number, scans, step) for number, step in enumerate(told)]
    steps = np.array([edge.z for edge in edges])
    poses = odometry[:1]
    for end in [*range(BLOCK, len(used), BLOCK), len(used), len(used)]:
        poses = np.concatenate([poses, chained(poses[-1], steps[len(poses) - 1 : end - 1])[1:]])
        known = {(edge.first, edge.second) for edge in edges}
        for first, second in closures(poses, known):
            edges += _closure(first, second, scans, poses)
        graph = _graph([edge for edge in edges if edge.second < end], end)
        states, _ = gauss_newton(graph, poses.ravel().copy(), STEPS)
        poses = np.asarray(states, dtype=float).reshape(-1, 3)
    return graph, odometry.ravel(), poses.ravel()


def closures(poses: FloatArray, known: set[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return a pair for each pose (N, 3): the nearest pose at least `APART` steps earlier, if it is near and new."""
    pairs = list[tuple[int, int]]()
    for second in range(APART, len(poses)):
        distance = np.hypot(*(poses[: second - APART + 1, :2] - poses[second, :2]).T)
        first = int(np.argmin(distance))
        if distance[first] <= NEAR and (first, second) not in known:
            pairs.append((first, second))
    return pairs


def _motion(number: int, scans: list[Scan], step: FloatArray) -> Edge:
    """Return the motion after a scan as the scans measure it, or as the odometry does if they do not match."""
    found = match(scans[number], scans[number + 1], Pose(*step))
    if found.share < MOTION:
        return Edge(number, number + 1, step, ODOMETRY)
    return Edge(number, number + 1, found.pose.as_array(), found.information)


def _closure(first: int, second: int, scans: list[Scan], poses: FloatArray) -> list[Edge]:
    """Return the edge between two scans, or no edge if they do not match near the current estimate."""
    guess = Pose(*poses[first]).inverse() @ Pose(*poses[second])
    found = match(scans[first], scans[second], guess)
    change = guess.inverse() @ found.pose
    if found.share < CLOSURE or np.hypot(change.x, change.y) > CHANGE[0] or abs(change.theta) > CHANGE[1]:
        return []
    return [Edge(first, second, found.pose.as_array(), found.information)]


def _graph(edges: list[Edge], poses: int) -> Graph:
    ends = np.array([(edge.first, edge.second) for edge in edges])
    measurements, information = (np.array(each) for each in list(zip(*edges, strict=True))[2:])
    return Graph(ends, measurements, information, np.full(poses, POSE))


def used_scans(log: CarmenLog) -> npt.NDArray[np.intp]:
    """Return the indices of scans that are at least `SPACING` or `TURN` apart by the odometry."""
    used = [0]
    for number, pose in enumerate(log.odometry):
        motion = Pose(*log.odometry[used[-1]]).inverse() @ Pose(*pose)
        if np.hypot(motion.x, motion.y) >= SPACING or abs(motion.theta) >= TURN:
            used.append(number)
    return np.array(used)


def scan_of(log: CarmenLog, number: int) -> Scan:
    """Return a scan of a log, without beams that hit nothing."""
    ranges = log.ranges[number]
    hit = (ranges > 0.1) & (ranges < min(REACH, 0.95 * log.ranges.max()))
    angles, ranges = log.angles[hit], ranges[hit]
    points = (ranges * np.array([np.cos(angles), np.sin(angles)])).T
    along = np.gradient(points, axis=0) if len(points) > 1 else np.zeros_like(points)
    length = np.hypot(*along.T)
    normals = np.column_stack([-along[:, 1], along[:, 0]]) / np.maximum(length, 1e-9)[:, None]
    return Scan(points, normals, cKDTree(points) if len(points) else None)


def match(first: Scan, second: Scan, guess: Pose) -> Match:
    """Find the pose of a scan in the frame of another one: iterative closest points, with errors along the normals.

    `guess` is the pose to begin with. Points without a partner within the last of `PAIRS` do not count as matched.
    """
    pose, information, share = guess, np.zeros((3, 3)), 0.0
    if min(len(first.points), len(second.points)) < 20:
        return Match(guess, information, share)
    for limit in np.repeat(PAIRS, 2):
        c, s = np.cos(pose.theta), np.sin(pose.theta)
        turn = np.array([[c, -s], [s, c]])
        placed = second.points @ turn.T + (pose.x, pose.y)
        distance, partner = first.tree.query(placed, distance_upper_bound=limit)
        near = distance < limit
        share = float(near.mean())
        if near.sum() < 20:
            return Match(guess, np.zeros((3, 3)), 0.0)
        normals, partners = first.normals[partner[near]], first.points[partner[near]]
        errors = ((placed[near] - partners) * normals).sum(axis=1)
        across = second.points[near] @ np.array([[0.0, 1.0], [-1.0, 0.0]])  # d(R p) / d theta = R across
        turned = normals @ turn
        jacobian = np.column_stack([turned, (turned * across).sum(axis=1)])
        H = jacobian.T @ jacobian + 1e-6 * np.eye(3)
        pose = pose @ Pose(*np.linalg.solve(H, -jacobian.T @ errors))
        information = H / (SIGMA**2 * TOGETHER)
    return Match(pose, information, share)
