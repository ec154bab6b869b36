"""What was recorded says what the lesson claims of cost and honesty."""

from __future__ import annotations

import json

from nao_course.lessons.pose_graphs.measured import draw_solver_costs
from nao_course.lessons.pose_graphs.measured.recorded import COSTS, EKF_AND_GRAPH
from nao_course.metrics import band
from tests.lessons.every import quotes
from tests.paths import PROJECT, SOLUTIONS

TEXT = (SOLUTIONS / "09_pose_graphs.md").read_text(encoding="utf-8")


def test_poses_ordered_once_are_the_fastest_way_with_scipy_alone_on_large_graphs() -> None:
    recorded = json.loads(COSTS.read_text(encoding="utf-8"))
    own = {row["poses"]: row["seconds"] for row in recorded["sparse, poses ordered once"]}
    assert list(own) == [100, 300, 1000, 3000, 10_000, 30_000, 100_000]
    for name in ("dense", "sparse, in scipy's own order", "sparse, numbers ordered at each step"):
        assert all(row["seconds"] > own[row["poses"]] for row in recorded[name] if row["poses"] >= 1000)
    assert f"sparse, poses ordered once: {own[100_000]:.3g} s for 100,000 poses" in draw_solver_costs().alt


def test_the_graph_is_honest_to_four_hundred_steps_and_the_filter_is_not() -> None:
    recorded = json.loads(EKF_AND_GRAPH.read_text(encoding="utf-8"))
    low, high = band(3, recorded["runs"])
    of = {
        name: dict(zip(recorded["steps"], rows["nees"], strict=True))
        for name, rows in recorded["methods"].items()
    }
    assert all(low < of["graph"][steps] < high for steps in (25, 50, 100, 200, 400))
    assert all(of["ekf"][steps] > high for steps in (50, 100, 200, 400, 800))
    results = PROJECT / "benchmarks" / "results"
    careful = json.loads((results / "ekf_and_graph.json").read_text(encoding="utf-8"))["a careful NAO"]
    quotes(
        TEXT, f"NEES at 800 is {careful['methods']['graph']['nees'][-1]:.1f}", "1° per step, bearings to 1.5°"
    )


def test_the_lesson_says_how_fast_the_solver_is_beside_gtsam() -> None:
    graphs = json.loads((PROJECT / "benchmarks" / "results" / "pose_graphs.json").read_text())["graphs"]
    small, large = (
        [graphs[name][f"ms_{who}"] for who in ("own", "gtsam")] for name in ("intel", "city10000")
    )
    quotes(TEXT, f"{small[0]:.0f} against {small[1]:.0f} ms", f"{large[0]:.0f} against {large[1]:.0f} ms")


def test_the_own_solver_stands_beside_gtsam() -> None:
    graphs = json.loads((PROJECT / "benchmarks" / "results" / "pose_graphs.json").read_text())["graphs"]
    assert len(graphs) == 4
    for row in graphs.values():
        assert row["ms_own"] <= 1.1 * row["ms_gtsam"]
        assert abs(row["chi2_own"] / row["chi2_gtsam"] - 1) < 2e-6
