"""Both methods map the same drives, and what was recorded says what the lesson claims of them."""

import json

import numpy as np
import pytest

from nao_course.geometry import wrap_angle
from nao_course.lessons.pose_graphs.measured import draw_ekf_and_graph, ekf_and_graph
from nao_course.lessons.pose_graphs.measured.recorded import EKF_AND_GRAPH
from nao_course.metrics import band
from nao_course.sim.drives import Sigmas
from tests.lessons.every import own, quotes, text
from tests.lessons.pose_graphs.own import OWN
from tests.paths import PROJECT

HARD = ekf_and_graph.NOISES["3° a step, 5° bearing"]
TINY = Sigmas(*(1e-7 * np.ones(5)))


@pytest.fixture(scope="module")
def ekf():
    return ekf_and_graph.Filter(*(own("07")[name] for name in ekf_and_graph.Filter._fields))


@pytest.fixture(scope="module")
def smoother():
    return ekf_and_graph.Smoother(*(own("09")[name] for name in ekf_and_graph.Smoother._fields))


def away(poses, others):
    """Return the largest difference of poses, headings on the circle."""
    apart = poses - others
    apart[:, 2] = wrap_angle(apart[:, 2])
    return np.abs(apart).max()


def true_states(drive):
    return np.concatenate([drive.poses.ravel(), drive.landmarks.ravel()])


def test_without_noise_both_find_the_truth(ekf, smoother):
    drive = ekf_and_graph.hall_drive(1, 40, TINY)
    filtered = ekf_and_graph.run_filter(drive, ekf)
    for mapped in (filtered, ekf_and_graph.run_smoother(drive, smoother, filtered)):
        assert away(mapped.poses, drive.poses) < 2e-5
        assert mapped.landmarks == pytest.approx(drive.landmarks, abs=2e-5)


def test_the_graph_of_a_drive_fits_its_truth_as_well_as_its_noise_says():
    """The mean of chi2 at the truth is one for each number that was measured."""
    residuals, found, numbers = (OWN["pose_residual"], OWN["landmark_residual"]), 0.0, 0
    for seed in range(10):
        # Along and across are far apart
        drive = ekf_and_graph.hall_drive(seed, 80, Sigmas(0.1, 0.002, 0.01, 0.02, 0.05))
        squares = ekf_and_graph.drive_graph(drive).squared_errors(true_states(drive), *residuals)
        found, numbers = found + squares.sum(), numbers + 240 + 2 * (len(squares) - 80)
    assert found / numbers == pytest.approx(1.0, abs=0.05)


def test_a_long_drive_is_not_in_a_wrong_minimum_and_the_graph_is_nearer_where_noise_is_large(ekf, smoother):
    drive = ekf_and_graph.hall_drive(7, 800, HARD)
    mapped = ekf_and_graph.run_smoother(drive, smoother, ekf_and_graph.run_filter(drive, ekf))
    states, _ = smoother.gauss_newton(ekf_and_graph.drive_graph(drive), true_states(drive), 15)
    assert away(states[: mapped.poses.size].reshape(-1, 3), mapped.poses) < 1e-2
    assert ekf_and_graph.scores(drive, mapped)["nees"] > 10
    assert np.degrees(abs(wrap_angle(mapped.poses[-1, 2] - drive.poses[-1, 2]))) > 15
    found = ekf_and_graph.compare(ekf, smoother, HARD, (120,), range(6))
    assert found["graph"]["path"].shape == (1, 6)
    assert all(found["graph"][name].mean() < found["ekf"][name].mean() for name in ("path", "nees"))
    alt = draw_ekf_and_graph().alt
    assert "EKF after 800 steps" in alt and "graph after 800 steps" in alt


def test_landmarks_are_numbered_as_they_are_seen_first_and_nees_of_the_truth_is_nothing(ekf):
    drive = ekf_and_graph.hall_drive(2, 60, HARD)
    numbers = np.concatenate([step.numbers for step in drive.steps])
    new = numbers[np.unique(numbers, return_index=True)[1]]
    assert new.tolist() == list(range(len(drive.landmarks)))
    assert np.maximum.accumulate(numbers)[-1] == len(drive.landmarks) - 1
    drive = ekf_and_graph.hall_drive(3, 15, HARD)
    turned = drive.poses + (0.0, 0.0, 2 * np.pi)
    exact = ekf_and_graph.run_filter(drive, ekf)._replace(poses=turned, landmarks=drive.landmarks)
    found = ekf_and_graph.scores(drive, exact)
    assert [found[name] for name in ("path", "last", "landmarks", "nees")] == pytest.approx([0] * 4)


def test_a_graph_that_is_solved_at_every_stop_is_the_whole_one_at_the_end(ekf, smoother):
    drive = ekf_and_graph.hall_drive(4, 20, HARD)
    sizes = []

    def watched(graph, states, iterations):
        sizes.append((graph.poses, graph.landmarks, len(graph.edges)))
        return smoother.gauss_newton(graph, states, iterations)

    filtered, spied = ekf_and_graph.run_filter(drive, ekf), smoother._replace(gauss_newton=watched)
    assert ekf_and_graph.at_every_stop(drive, spied, filtered) > 0
    whole = ekf_and_graph.drive_graph(drive)
    assert [poses for poses, _, _ in sizes] == list(range(2, 22))
    assert sizes[-1] == (whole.poses, whole.landmarks, len(whole.edges))
    assert sizes == sorted(sizes)


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


RESULTS = PROJECT / "benchmarks" / "results"


def test_what_was_recorded_says_that_poses_ordered_once_are_fastest_and_the_graph_is_consistent_longest():
    recorded = read(RESULTS / "pose_graphs.json")["costs"]
    own = {row["poses"]: row["seconds"] for row in recorded["sparse, poses ordered once"]}
    assert list(own) == [100, 300, 1000, 3000, 10_000, 30_000, 100_000]
    for name in ("dense", "sparse, in scipy's own order", "sparse, numbers ordered at each step"):
        assert all(row["seconds"] > own[row["poses"]] for row in recorded[name] if row["poses"] >= 1000)
    recorded = read(EKF_AND_GRAPH)
    low, high = band(3, recorded["runs"])
    of = {
        name: dict(zip(recorded["steps"], rows["nees"], strict=True))
        for name, rows in recorded["methods"].items()
    }
    assert all(low < of["graph"][steps] < high for steps in (25, 50, 100, 200, 400))
    assert all(of["ekf"][steps] > high for steps in (50, 100, 200, 400, 800))
    careful = read(RESULTS / "ekf_and_graph.json")["a careful NAO"]["methods"]["graph"]
    quotes(text("09"), f"NEES at 800 is {careful['nees'][-1]:.1f}", "1° per step, bearings to 1.5°")
    graphs = read(RESULTS / "pose_graphs.json")["graphs"]
    assert len(graphs) == 4
    for name, row in graphs.items():
        assert row["ms_own"] <= 1.1 * row["ms_gtsam"]
        assert abs(row["chi2_own"] / row["chi2_gtsam"] - 1) < 2e-6
        if name in ("intel", "city10000"):
            quotes(text("09"), f"{row['ms_own']:.0f} against {row['ms_gtsam']:.0f} ms")
