"""A laser scanner's log becomes a graph, which the student's solver straightens; a missing log is named."""

import re

import numpy as np
import pytest

from nao_course.datasets import read_carmen_log
from nao_course.exercises import try_out
from nao_course.geometry import Pose, wrap_angle
from nao_course.lessons import pose_graphs as tools
from nao_course.lessons.pose_graphs.scans import graph_of_scans, match, scan_of, used_scans
from nao_course.lessons.pose_graphs.worlds import chained
from tests.lessons.every import text
from tests.lessons.pose_graphs.own import OWN

CORNERS = (
    np.array([(-2, -2), (9, -2), (9, 4), (10, 4), (10, 9), (3, 9), (3, 8), (1, 8), (1, 9), (-2, 9)]),
    np.array([(2, 2), (5, 2), (5, 4), (4, 5), (2, 5)]),
)
WALLS = np.concatenate([np.stack([each, np.roll(each, -1, axis=0)], axis=1) for each in CORNERS]).astype(
    float
)
ANGLES = np.radians(np.arange(-90, 90))


def ranges_from(pose):
    """Return how far a ray in each direction gets before it meets a wall, m."""
    heading = pose[2] + ANGLES
    ray = np.column_stack([np.cos(heading), np.sin(heading)])[:, None]
    begin, along = WALLS[:, 0] - pose[:2], WALLS[:, 1] - WALLS[:, 0]
    cross = ray[..., 0] * along[:, 1] - ray[..., 1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = (begin[:, 0] * along[:, 1] - begin[:, 1] * along[:, 0]) / cross
        place = (begin[:, 0] * ray[..., 1] - begin[:, 1] * ray[..., 0]) / cross
    meets = (distance > 0) & (place >= 0) & (place <= 1)
    return np.where(meets, distance, np.inf).min(axis=1)


def drive():
    """Return the steps of two laps round a square building, in small motions."""
    side = [[0.25, 0, 0]] * 28 + [[0.0, 0, np.pi / 8]] * 4
    return np.array(side * 8, dtype=float)


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    rng = np.random.default_rng(1)
    true = chained(np.zeros(3), drive())
    steps = drive() + rng.normal(size=(len(true) - 1, 3)) * (0.01, 0.01, 0.01) + (0, 0, 0.002)
    odometry = chained(np.zeros(3), steps)
    lines = []
    for number, (pose, told) in enumerate(zip(true, odometry, strict=True)):
        ranges = ranges_from(pose) + 0.01 * rng.normal(size=len(ANGLES))
        words = " ".join(f"{value:.3f}" for value in ranges)
        place = " ".join(f"{value:.4f}" for value in told)
        lines.append(f"FLASER 180 {words} {place} {place} {number} host {number}")
    path = tmp_path_factory.mktemp("log") / "square.clf"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path, true


def test_a_scan_is_found_where_it_was_taken_from(log):
    path, true = log
    read = read_carmen_log(path)
    first, second = scan_of(read, 40), scan_of(read, 43)
    motion = Pose(*true[40]).inverse() @ Pose(*true[43])
    found = match(first, second, motion @ Pose(0.1, -0.1, 0.1))
    error = (motion.inverse() @ found.pose).as_array()
    assert np.abs(error).max() < 0.02 and found.share > 0.7
    assert (np.linalg.eigvalsh(found.information) > 0).all()
    nothing = match(first, second._replace(points=second.points[:3]), motion)
    assert nothing.pose == motion and nothing.share == 0


def test_the_solver_straightens_a_log_of_two_laps(log):
    path, true = log
    graph, odometry, states = graph_of_scans(read_carmen_log(path), OWN["gauss_newton"])
    true = true[used_scans(read_carmen_log(path))]
    off = [np.hypot(*(each.reshape(-1, 3) - true)[:, :2].T).max() for each in (odometry, states)]
    assert off[0] > 1 and off[1] < 0.2, off
    assert np.abs(wrap_angle(states[2::3] - true[:, 2])).max() < 0.05
    assert len(graph.edges) > graph.poses + 20


def test_the_figure_says_what_changed(log):
    said = tools.draw_scans(log[0], OWN["gauss_newton"]).alt
    assert re.search(
        r"laser scans, by odometry and by the graph: \d+ closures, χ² per degree of freedom 0?[.\d]+", said
    )


def test_the_lessons_cell_says_where_a_log_is_to_be_had_and_does_nothing_else(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (cell,) = re.findall(r"^try_out\(lambda: tools.draw_scans.*", text("09"), re.MULTILINE)
    message = str(eval(cell, {"try_out": try_out, "tools": tools, "gauss_newton": OWN["gauss_newton"]}))
    assert "no file intel.clf here" in message and "ipb.uni-bonn.de/datasets" in message


def test_a_log_without_motion_or_that_is_damaged_is_named(tmp_path):
    still, damaged, empty = tmp_path / "still.log", tmp_path / "damaged.log", tmp_path / "empty.mcap"
    empty.touch()
    still.write_text("FLASER 2 1 1 0 0 0 0 0 0 1 host 1\n" * 3, encoding="utf-8")
    damaged.write_text("FLASER 2 1 one 0 0 0 0 0 0 1 host 1\n", encoding="utf-8")
    for path, message in (
        (still, "does not move"),
        (damaged, "damaged.log, line 1: expected a number"),
        (empty, "empty.mcap: expected 1 to"),
    ):
        assert message in str(try_out(lambda path=path: tools.draw_scans(path, OWN["gauss_newton"])))
