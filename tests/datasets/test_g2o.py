"""A graph that is written is read again to the last bit; a file that is not whole is refused with its line."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nao_course.datasets import graph_lines, read_g2o, write_g2o
from nao_course.geometry import Pose
from nao_course.graphs import LANDMARK, POSE, Graph
from tests.lessons import every
from tests.paths import PROJECT

GOOD = [
    "# a comment",
    "VERTEX_SE2 7 0 0 0",
    "VERTEX_SE2 3 1.5 0 0.25  # another",
    "VERTEX_XY 9 2 2",
    "",
    "EDGE_SE2_XY 3 9 0.5 2 4 0 4",
    "EDGE_SE2 7 3 1.5 0 0.25 10 1 0 10 0 100",
]


def written(folder, lines):
    path = folder / "graph.g2o"
    path.write_text("\n".join(lines))
    return path


def changed(line: int, *to: str) -> list[str]:
    return [*GOOD[: line - 1], *to, *GOOD[line:]]


def some_graph(rng: np.random.Generator, poses: int, landmarks: int, edges: int) -> tuple[Graph, np.ndarray]:
    """Any numbers that a graph may hold, of all sizes."""
    count = poses + landmarks
    first = rng.integers(poses, size=edges)
    second = (first + rng.integers(1, max(count, 2), size=edges)) % max(count, 2)
    z = rng.normal(size=(edges, 3)) * 10.0 ** rng.integers(-6, 6, size=(edges, 1))
    roots = rng.normal(size=(edges, 3, 3)) + 3 * np.eye(3)
    information = roots @ roots.mT
    information = (information + information.mT) / 2
    to_landmark = second >= poses
    z[to_landmark, 2] = 0
    information[to_landmark, 2], information[to_landmark, :, 2] = 0, 0
    ids = rng.choice(10 * count, size=count, replace=False)
    kinds = [POSE] * poses + [LANDMARK] * landmarks
    graph = Graph(np.column_stack([first, second]), z, information, kinds, ids)
    return graph, rng.normal(size=graph.size) * 1e3


def assert_same(one, other):
    for name in ("edges", "measurements", "information", "kinds", "ids"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name


ISLANDS = pytest.mark.filterwarnings("ignore:.*edges do not connect all", "ignore:.*there are no edges")


@ISLANDS
@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    poses=st.integers(2, 12),
    landmarks=st.integers(0, 8),
    edges=st.integers(0, 30),
)
def test_a_written_graph_is_read_again_to_the_last_bit(seed, poses, landmarks, edges, tmp_path_factory):
    graph, states = some_graph(np.random.default_rng(seed), poses, landmarks, edges)
    again, values = read_g2o(write_g2o(graph, states, tmp_path_factory.mktemp("g2o") / "own.g2o"))
    assert_same(graph, again)
    assert np.array_equal(states, values)


def test_poses_and_landmarks_keep_the_files_order_and_the_pose_that_fix_names_stands_first(tmp_path):
    graph, states = read_g2o(written(tmp_path, GOOD))
    assert graph.ids.tolist() == [7, 3, 9]
    assert graph.kinds.tolist() == [POSE, POSE, LANDMARK]
    assert graph.edges.tolist() == [[1, 2], [0, 1]]  # in the file's order, though of two kinds
    assert graph.measurements.tolist() == [[0.5, 2, 0], [1.5, 0, 0.25]]
    assert graph.information[0].tolist() == [[4, 0, 0], [0, 4, 0], [0, 0, 0]]
    assert graph.information[1].tolist() == [[10, 1, 0], [1, 10, 0], [0, 0, 100]]
    assert states.tolist() == [0, 0, 0, 1.5, 0, 0.25, 2, 2]
    graph, states = read_g2o(written(tmp_path, [*GOOD, "FIX 3"]))
    assert graph.ids.tolist() == [3, 7, 9]
    assert graph.edges.tolist() == [[0, 2], [1, 0]]
    assert states[:3].tolist() == [1.5, 0, 0.25]
    graph, states = read_g2o(written(tmp_path, GOOD))
    lines = write_g2o(graph, states, tmp_path / "own.g2o").read_text().splitlines()
    assert lines[-1] == "FIX 7" and sum(line.startswith("FIX") for line in lines) == 1


@pytest.mark.parametrize(
    ("line", "to", "message"),
    [
        (2, "7 0 0 0", "line 2: the tag must be one of VERTEX_SE2, .*EDGE_SE2_PRIOR, ODOMETRY, got '7'"),
        (3, "VERTEX_SE2 3 1.5 0", "line 3: VERTEX_SE2 needs 1 vertex and 3 numbers, 5 words; got 4"),
        (6, "EDGE_SE2_XY 3 9 0.5 2 4 0", "line 6: EDGE_SE2_XY needs 2 vertices and 5 .* 8 words; got 7"),
        (6, "EDGE_SE2_XY 8 9 0.5 2 4 0 4", "line 6: there is no vertex 8"),
        (4, "VERTEX_XY 3 2 2", "line 4: vertex 3 is already defined in line 3"),
        (6, "EDGE_SE2_XY 9 3 0.5 2 4 0 4", "line 6: vertex 9 must be a pose, but it is a landmark"),
        (6, "EDGE_SE2_XY 3 7 0.5 2 4 0 4", "line 6: vertex 7 must be a landmark, but it is a pose"),
        (7, "EDGE_SE2 7 7 1.5 0 0.25 10 1 0 10 0 100", "line 7: the edge connects vertex 7 with itself"),
        (7, "EDGE_SE2 7 3 1.5 0 0.25 10 10 0 10 0 100", "line 7: the information matrix is singular"),
        (7, "EDGE_SE2 7 3 1.5 0 0.25 10 11 0 10 0 100", "line 7: .* matrix is .*not positive definite"),
        (6, "EDGE_SE2_XY 3 9 0.5 2 4 4 4", "line 6: the information matrix is singular"),
        (2, "VERTEX_SE2 7 0 nan 0", "line 2: expected numbers within .*got nan as number 2"),
        (4, "VERTEX_XY 9 2 inf", "line 4: expected numbers within .*got inf as number 2"),
        (7, "EDGE_SE2 7 3 1.5 0 0.25 nan 1 0 10 0 100", "line 7: expected numbers within .*number 4"),
        (2, "VERTEX_SE2 x 0 0 0", "line 2: expected integers for the vertices and numbers, got 'x 0 0 0'"),
        (2, "VERTEX_SE2 7 1_0 0 0", "line 2: expected integers for the vertices"),
        (2, "VERTEX_SE2 -1 0 0 0", "line 2: the number of a vertex must be 0"),
        (2, f"VERTEX_SE2 {2**63} 0 0 0", "line 2: the number of a vertex must be 0"),
        (2, f"VERTEX_SE2 {'9' * 9000} 0 0 0", "line 2: expected integers for the vertices"),
        (5, "FIX 9", "line 5: there is no pose 9"),
        (5, "FIX 7 x", "line 5: expected integers for the vertices"),
        (5, "FIX", "line 5: FIX needs 1 vertex"),
    ],
)
def test_a_wrong_line_is_refused_with_its_file_and_number(tmp_path, line, to, message):
    with pytest.raises(ValueError, match=rf"graph\.g2o, {message}") as caught:
        read_g2o(written(tmp_path, changed(line, to)))
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize("fixed", [["FIX 3", "FIX 7", "FIX 3"], ["FIX 3 7"]])
def test_several_poses_that_fix_names_are_said_and_the_first_is_held(tmp_path, fixed):
    with pytest.warns(UserWarning, match="FIX names 2 poses; only the first one, 3, is held"):
        graph, _ = read_g2o(written(tmp_path, [*GOOD, *fixed]))
    assert graph.ids.tolist() == [3, 7, 9]


def test_lines_with_other_tags_are_left_out_unless_there_are_many_and_unconnected_vertices_are_said(tmp_path):
    more = ["VERTEX_TAG 7 0 0", "EDGE_SE2_XY_CALIB 7 9 3 0 0 1 0 1", "EDGE_SE2_XY_CALIB 3 9 7 0 0 1 0 1"]
    with pytest.warns(UserWarning, match=r"'VERTEX_TAG' \(1 line\), 'EDGE_SE2_XY_CALIB' \(2 lines\)"):
        graph, states = read_g2o(written(tmp_path, [*more, *GOOD]))
    plain, values = read_g2o(written(tmp_path, GOOD))
    assert_same(graph, plain)
    assert np.array_equal(states, values)
    lines = [f"TAG{number} 1 2 3" for number in range(graph_lines.MOST_UNKNOWN_TAGS + 1)]
    with pytest.raises(ValueError, match=f"line {len(lines)}: the tag must be one of"):
        read_g2o(written(tmp_path, lines))
    with pytest.warns(UserWarning, match="2 parts, and vertices 7 and 3 are in different ones"):
        read_g2o(written(tmp_path, GOOD[:-1]))
    with pytest.warns(UserWarning, match="there are no edges"):
        read_g2o(written(tmp_path, GOOD[:-2]))


@ISLANDS
def test_toros_information_has_its_own_order_and_is_read_again_exactly_without_landmarks(tmp_path, rng):
    """TORO's upper triangle is 11 12 22 33 13 23, which its own documentation calls ff fs ss rr fr sr."""
    lines = ["VERTEX2 0 0 0 0", "VERTEX2 1 1 0 0", "EDGE2 0 1 1 0 0.5 10 1 20 30 2 3"]
    graph, states = read_g2o(written(tmp_path, lines))
    assert graph.information[0].tolist() == [[10, 1, 2], [1, 20, 3], [2, 3, 30]]
    assert states.tolist() == [0, 0, 0, 1, 0, 0]
    assert write_g2o(graph, states, tmp_path / "own.graph", form="toro").read_text().splitlines()[-1] == (
        "EDGE2 0 1 1.0 0.0 0.5 10.0 1.0 20.0 30.0 2.0 3.0"
    )
    graph, states = some_graph(rng, 6, 0, 12)
    again, values = read_g2o(write_g2o(graph, states, tmp_path / "own.graph", form="toro"))
    assert_same(graph, again)
    assert np.array_equal(states, values)
    graph, states = read_g2o(written(tmp_path, GOOD))
    with pytest.raises(ValueError, match="TORO has no landmarks"):
        write_g2o(graph, states, tmp_path / "own.graph", form="toro")


def errors(states: np.ndarray, graph: Graph) -> np.ndarray:
    """Return the errors (x, y, angle) of all edges in g2o's convention, (E, 3); a landmark's angle is 0."""
    poses, landmarks = graph.split(states)
    ends = np.vstack([poses, np.column_stack([landmarks, np.zeros(graph.landmarks)])])
    found = []
    for (first, second), z in zip(graph.edges, graph.measurements, strict=True):
        if second < graph.poses:
            relative = Pose(*poses[first]).inverse() @ Pose(*ends[second])
            found.append((Pose(*z).inverse() @ relative).as_array())
        else:
            found.append([*(Pose(*poses[first]).to_local(ends[second, :2])[0] - z[:2]), 0])
    return np.array(found)


def logarithms(residuals: np.ndarray) -> np.ndarray:
    """Return the logarithms of relative poses (x, y, angle), as GTSAM 4.3 computes its errors, (E, 3)."""
    half = residuals[:, 2] / 2
    along = np.where(np.abs(half) < 1e-8, 1, half / np.tan(np.where(half == 0, 1, half)))
    x, y = residuals[:, :2].T
    return np.column_stack([along * x + half * y, along * y - half * x, residuals[:, 2]])


def chi2(residuals: np.ndarray, information: np.ndarray) -> float:
    return float(np.einsum("ki,kij,kj->", residuals, information, residuals))


def chi2_of_gtsam(gtsam, states: np.ndarray, graph: Graph) -> float:
    """Return the chi2 of the edges between poses by the formula of the installed version."""
    chosen = graph.edges[:, 1] < graph.poses
    factor = gtsam.BetweenFactorPose2(0, 1, gtsam.Pose2(), gtsam.noiseModel.Unit.Create(3))
    values = gtsam.Values()
    values.insert(0, gtsam.Pose2())
    values.insert(1, gtsam.Pose2(1, 0, 1))
    residuals = errors(states, graph)
    if not np.isclose(2 * factor.error(values), 2):
        residuals = logarithms(residuals)
    return chi2(residuals[chosen], graph.information[chosen])


@pytest.mark.slow
def test_gtsam_reads_what_is_written_except_for_edges_to_landmarks(tmp_path, rng):
    gtsam = pytest.importorskip("gtsam")
    graph, states = some_graph(rng, 20, 10, 60)
    factors, values = gtsam.readG2o(str(write_g2o(graph, states, tmp_path / "own.g2o")), False)
    assert (factors.size(), values.size()) == (len(graph.pose_edges.z), len(graph.ids))
    assert 2 * factors.error(values) == pytest.approx(chi2_of_gtsam(gtsam, states, graph), rel=1e-6)


@pytest.mark.slow
def test_gtsam_reads_toros_form_if_its_noise_format_is_given(tmp_path, rng):
    gtsam = pytest.importorskip("gtsam")
    graph, states = some_graph(rng, 20, 0, 60)
    path = write_g2o(graph, states, tmp_path / "own.graph", form="toro")
    factors, values = gtsam.load2D(str(path), None, 0, False, True, gtsam.NoiseFormat.NoiseFormatTORO)
    assert (factors.size(), values.size()) == (60, 20)
    assert 2 * factors.error(values) == pytest.approx(chi2_of_gtsam(gtsam, states, graph), rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["openslam_intel", "MIT", "input_M3500_g2o"])
def test_gtsam_reads_the_standard_graphs_as_they_are_written(data_dir, tmp_path, name):
    gtsam = pytest.importorskip("gtsam")
    graph, states = read_g2o(data_dir / "slam" / "g2o" / f"{name}.g2o")
    factors, values = gtsam.readG2o(str(write_g2o(graph, states, tmp_path / "own.g2o")), False)
    assert (factors.size(), values.size()) == (len(graph.edges), graph.poses)
    assert 2 * factors.error(values) == pytest.approx(chi2_of_gtsam(gtsam, states, graph), rel=1e-6)


@pytest.mark.slow
def test_gtsams_own_files_of_covariances_bearings_and_ranges_have_its_chi2(tmp_path):
    """The errors are small, because we linearise bearings and ranges at the measurement."""
    gtsam = pytest.importorskip("gtsam")
    lines = [
        "VERTEX2 0 0 0 0",
        "VERTEX2 1 1 0 0.2",
        "VERTEX_XY 0 3 1",
        "EDGE2 0 1 1.01 0.02 0.201 0.04 0 0.01 0.09 0 0",
    ]
    lines += ["BR 0 0 0.323 3.16 0.01 0.1", "BR 1 0 0.264 2.24 0.01 0.1"]
    path = written(tmp_path, lines)
    factors, values = gtsam.load2D(str(path))
    with pytest.warns(UserWarning, match="2 was added to theirs"):
        graph, states = read_g2o(path, form="gtsam")
    assert (factors.size(), values.size()) == (3, 3)
    assert chi2(errors(states, graph), graph.information) == pytest.approx(
        2 * factors.error(values), rel=0.01
    )


def read_by_g2o(path) -> tuple[int, int, float]:
    """Return the numbers of vertices and edges that g2o itself reads, and its chi2."""
    g2opy = pytest.importorskip("g2opy")
    optimizer = g2opy.SparseOptimizer()
    assert optimizer.load(str(path))
    for edge in optimizer.edges():
        edge.compute_error()
    return len(optimizer.vertices()), len(optimizer.edges()), sum(edge.chi2() for edge in optimizer.edges())


@pytest.mark.slow
def test_g2o_itself_reads_what_is_written(tmp_path, rng):
    graph, states = some_graph(rng, 20, 10, 60)
    vertices, edges, found = read_by_g2o(write_g2o(graph, states, tmp_path / "own.g2o"))
    assert (vertices, edges) == (30, 60)
    assert found == pytest.approx(chi2(errors(states, graph), graph.information), rel=1e-9)


@pytest.mark.slow
def test_g2o_itself_reads_nothing_of_toros_form(tmp_path, rng):
    graph, states = some_graph(rng, 20, 0, 60)
    assert read_by_g2o(write_g2o(graph, states, tmp_path / "own.graph", form="toro")) == (0, 0, 0)


@pytest.mark.slow
def test_priors_and_offsets_have_the_chi2_of_g2o_itself(tmp_path):
    lines = ["PARAMS_SE2OFFSET 7 0.3 -0.1 1.2", "PARAMS_SE2OFFSET 8 0 0 -0.7", *GOOD[1:], "FIX 7"]
    lines += ["EDGE_PRIOR_SE2 3 1.4 0.1 0.3 10 1 2 20 3 30", "EDGE_PRIOR_XY 9 2.1 1.8 4 1 9"]
    lines += ["EDGE_SE2_OFFSET 7 3 7 8 0.5 -1 -1.5 10 1 2 20 3 30"]
    path = written(tmp_path, lines)
    graph, states = read_g2o(path)
    vertices, edges, found = read_by_g2o(path)
    assert (vertices, edges) == (3, 5) == (len(graph.ids), len(graph.edges))
    assert found == pytest.approx(chi2(errors(states, graph), graph.information), rel=1e-9)


@pytest.mark.slow
def test_g2o_leaves_the_offset_out_of_the_error_of_a_landmark(tmp_path):
    """g2o computes the error in the frame of the robot, so we warn that our chi2 differs."""
    edge = "EDGE_SE2_POINTXY_OFFSET 3 9 8 0.5 2 4 0 4"
    near = read_by_g2o(written(tmp_path, ["PARAMS_SE2OFFSET 8 0 0 0", *GOOD, edge]))
    assert near == pytest.approx(read_by_g2o(written(tmp_path, ["PARAMS_SE2OFFSET 8 9 9 1", *GOOD, edge])))


def rows_of_documents(begin: str) -> list[list[str]]:
    """Return the cells of the lines of docs/real_data.md that begin with some text."""
    lines = (PROJECT / "docs" / "real_data.md").read_text(encoding="utf-8").splitlines()
    return [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines if line.startswith(begin)]


def test_the_documents_name_every_tag_and_the_chi2_of_gtsam_is_that_of_a_logarithm():
    """A slow test compares the formula with GTSAM itself."""
    [[_, *angles]] = rows_of_documents("| angle, rad |")
    residuals = np.array([[1, 0, float(angle)] for angle in angles])
    rows = ("| g2o and GTSAM 4.2 |", residuals), ("| GTSAM 4.3.0 | 1", logarithms(residuals))
    for begin, errors_ in rows:
        [[_, *values]] = rows_of_documents(begin)
        assert values == [f"{value:.4f}" for value in (errors_**2).sum(axis=1)]
    table = "".join(cell for row in rows_of_documents("| ") for cell in row)
    for tag in (*graph_lines.TAGS, *graph_lines.OTHER_NAMES, *graph_lines.LEFT_OUT):
        assert tag in table
    assert f"if the file has at most {graph_lines.MOST_UNKNOWN_TAGS} of them" in table


@pytest.mark.parametrize("name", ["openslam_intel", "MIT", "input_M3500_g2o", "city10000"])
def test_the_optimum_per_degree_of_freedom_is_in_the_documents(data_dir, name):
    [[*_, optimum, quotient]] = rows_of_documents(f"| `{name}.g2o` |")
    graph, _ = read_g2o(data_dir / "slam" / "g2o" / f"{name}.g2o")
    assert float(quotient) == pytest.approx(float(optimum) / graph.degrees_of_freedom, rel=0.03)
    assert graph.chi2_hint(float(optimum))


def test_the_degrees_of_freedom_are_measured_minus_free_values_and_units_make_no_matrix_singular(tmp_path):
    """A chain has none, and each further measurement adds its values."""
    lines = ["VERTEX_SE2 0 0 0 0", "VERTEX_SE2 1 1 0 0", "VERTEX_XY 2 1 1"]
    lines += ["EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1", "EDGE_SE2_XY 0 2 1 1 1 0 1", "EDGE_SE2_XY 1 2 0 1 1 0 1"]
    assert read_g2o(written(tmp_path, lines[:-1]))[0].degrees_of_freedom == 0
    assert read_g2o(written(tmp_path, lines))[0].degrees_of_freedom == 2
    graph, _ = read_g2o(written(tmp_path, changed(7, "EDGE_SE2 7 3 1 0 0 1e-6 0 0 1e-6 0 1e12")))
    assert graph.information[1, 2, 2] == 1e12
    read_g2o(written(tmp_path, changed(7, "EDGE_SE2 7 3 1 0 0 1e-14 0 0 1e-14 0 1")))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "isam", "squared"),
    [
        ("input_M3500_g2o", "44.72135955 0 0 44.72135955 0 44.72135955", 1.07),  # manhattanOlson3500.txt
        ("city10000", "50 0 0 50 0 100", 1.00),  # city10000.txt
    ],
)
def test_two_published_graphs_contain_square_roots_as_information(data_dir, tmp_path, name, isam, squared):
    """iSAM's files of these graphs have the same numbers, and iSAM squares them."""
    graph, states = read_g2o(data_dir / "slam" / "g2o" / f"{name}.g2o")
    read, _ = read_g2o(written(tmp_path, [f"EDGE2 0 1 1 0 0 {isam}"]), form="isam")
    right = graph.information @ graph.information
    assert np.allclose(right[0], read.information[0], rtol=1e-4)
    graph = dataclasses.replace(graph, information=right)
    _, history = every.own("09")["gauss_newton"](graph, states, 8)
    assert history[-1] / graph.degrees_of_freedom == pytest.approx(squared, abs=0.005)


QUARTER = np.pi / 2
CHAIN = [  # a step of 1 m ahead and a quarter turn left each; the loop is closed wrongly on purpose
    f"EDGE_SE2 4 5 1 0 {QUARTER} 1 0 0 1 0 1",
    f"EDGE_SE2 2 4 1 0 {QUARTER} 1 0 0 1 0 1",
    "EDGE_SE2 6 5 -0.5 0 0 1 0 0 1 0 1",
    "EDGE_SE2 5 2 9 9 0 1 0 0 1 0 1",
    "EDGE_SE2_XY 4 1 0 2 1 0 1",
]


def test_without_vertex_lines_the_guess_follows_the_fewest_edges_from_the_pose_that_is_held(tmp_path):
    graph, states = read_g2o(written(tmp_path, CHAIN[:3] + CHAIN[4:]))
    assert graph.ids.tolist() == [2, 4, 5, 6, 1]
    assert graph.kinds.tolist() == [POSE] * 4 + [LANDMARK]
    assert graph.edges.tolist() == [[1, 2], [0, 1], [3, 2], [1, 4]]
    poses, landmarks = graph.split(states)
    assert np.allclose(poses, [(0, 0, 0), (1, 0, QUARTER), (1, 1, np.pi), (0.5, 1, np.pi)])
    assert np.allclose(landmarks, [(-1, 0)])
    graph, states = read_g2o(written(tmp_path, CHAIN))
    poses, _ = graph.split(states)
    # By the edge from 5 back to 2, not through 4
    assert np.allclose(poses[graph.ids[:4] == 5], [(-9, -9, 0)])
    ends = [(0, 1, 1), (0, 2, 1), (2, 3, 1), (3, 4, 7), (1, 4, 1)]
    edges = [f"EDGE_SE2 {first} {second} {x} 0 0 1 0 0 1 0 1" for first, second, x in ends]
    for lines in (edges, edges[::-1]):
        graph, states = read_g2o(written(tmp_path, lines))
        poses, _ = graph.split(states)
        assert np.allclose(poses[graph.ids == 4], [(2, 0, 0)])
    graph, states = read_g2o(written(tmp_path, [*CHAIN, "FIX 5"]))
    poses, _ = graph.split(states)
    assert graph.ids.tolist() == [5, 2, 4, 6, 1]
    assert np.allclose(poses, [(0, 0, 0), (9, 9, 0), (0, 1, -QUARTER), (0.5, 0, 0)])


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["EDGE_SE2 7 8 1 0 0 1 0 0 1 0 1"], "vertex 7 has no VERTEX line, and no chain .* with vertex 2"),
        # A landmark has no heading, so no chain leads through it.
        (["EDGE_SE2_XY 7 1 1 0 1 0 1"], "vertex 7 has no VERTEX line, and no chain"),
        (["EDGE_SE2 5 7 1 nan 0 1 0 0 1 0 1"], "line 6: expected numbers within .*number 2"),
        (["EDGE_SE2 1 2 1 0 0 1 0 0 1 0 1"], "line 5: vertex 1 must be a landmark, but it is a pose"),
        (["FIX 1"], "line 6: there is no pose 1"),
        (["VERTEX_SE2 2 0 0 0"], "there is no vertex 4"),
    ],
)
def test_edges_without_vertices_that_give_no_whole_guess_are_refused(tmp_path, more, message):
    with pytest.raises(ValueError, match=rf"graph\.g2o.*{message}"):
        read_g2o(written(tmp_path, [*CHAIN, *more]))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        (b"", "got an empty file"),
        (b"# nothing\n\n", "no line begins with VERTEX_SE2"),
        (b"\x93NUMPY" + bytes(200) + b"1", "is not text"),
    ],
)
def test_what_is_no_graph_is_refused_with_its_file(tmp_path, data, message):
    (tmp_path / "graph.g2o").write_bytes(data)
    with pytest.raises(ValueError, match=rf"graph\.g2o.*{message}"):
        read_g2o(tmp_path / "graph.g2o")


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_a_graph_may_have_the_encoding_of_any_editor(tmp_path, encoding):
    (tmp_path / "graph.g2o").write_bytes("\n".join([*GOOD, "# Größe"]).encode(encoding))
    assert_same(read_g2o(tmp_path / "graph.g2o")[0], read_g2o(written(tmp_path, GOOD))[0])


def test_a_missing_or_large_file_is_refused_and_nothing_unreadable_is_written(tmp_path, monkeypatch, rng):
    with pytest.raises(ValueError, match="graph.g2o: cannot be read"):
        read_g2o(tmp_path / "graph.g2o")
    monkeypatch.setattr(graph_lines, "LARGEST_GRAPH", 20)
    with pytest.raises(ValueError, match="expected 1 to 20 bytes, got more"):
        read_g2o(written(tmp_path, GOOD))
    graph, states = some_graph(rng, 3, 1, 4)
    for wrong in (np.nan, 2 * graph_lines.LARGEST_NUMBER):
        states[2] = wrong
        with pytest.raises(ValueError, match="not written, because the states"):
            write_g2o(graph, states, tmp_path / "own.g2o")
    assert not (tmp_path / "own.g2o").exists()


@pytest.mark.parametrize(
    ("name", "poses", "edges"),
    [
        ("openslam_intel", 943, 1837),
        ("MIT", 808, 827),
        pytest.param("input_M3500_g2o", 3500, 5453, marks=pytest.mark.slow),
        pytest.param("city10000", 10_000, 20_687, marks=pytest.mark.slow),
    ],
)
def test_the_standard_graphs_are_read_and_written(data_dir, tmp_path, name, poses, edges):
    graph, states = read_g2o(data_dir / "slam" / "g2o" / f"{name}.g2o")
    assert (graph.poses, graph.landmarks, len(graph.edges)) == (poses, 0, edges)
    again, values = read_g2o(write_g2o(graph, states, tmp_path / "own.g2o"))
    assert_same(graph, again)
    assert np.array_equal(states, values)
