"""What was recorded says what the lesson claims of cost and honesty."""

import json

from nao_course.lessons.pose_graphs.measured import draw_solver_costs
from nao_course.lessons.pose_graphs.measured.recorded import COSTS, EKF_AND_GRAPH
from nao_course.metrics import band
from tests.lessons.every import quotes, text
from tests.paths import PROJECT


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


RESULTS = PROJECT / "benchmarks" / "results"


def test_poses_ordered_once_are_the_fastest_way_with_scipy_alone_on_large_graphs():
    recorded = read(COSTS)
    own = {row["poses"]: row["seconds"] for row in recorded["sparse, poses ordered once"]}
    assert list(own) == [100, 300, 1000, 3000, 10_000, 30_000, 100_000]
    for name in ("dense", "sparse, in scipy's own order", "sparse, numbers ordered at each step"):
        assert all(row["seconds"] > own[row["poses"]] for row in recorded[name] if row["poses"] >= 1000)
    assert f"sparse, poses ordered once: {own[100_000]:.3g} s for 100,000 poses" in draw_solver_costs().alt


def test_the_graph_is_consistent_to_four_hundred_steps_and_the_filter_is_not():
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


def test_the_own_solver_stands_beside_gtsam_and_the_lesson_says_how_fast_it_is():
    graphs = read(RESULTS / "pose_graphs.json")["graphs"]
    assert len(graphs) == 4
    for name, row in graphs.items():
        assert row["ms_own"] <= 1.1 * row["ms_gtsam"]
        assert abs(row["chi2_own"] / row["chi2_gtsam"] - 1) < 2e-6
        if name in ("intel", "city10000"):
            quotes(text("09"), f"{row['ms_own']:.0f} against {row['ms_gtsam']:.0f} ms")
