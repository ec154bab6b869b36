"""What each tag of g2o, TORO, iSAM and GTSAM means: an edge with the chi2 that its program computes, or a refusal."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nao_course.datasets import read_g2o, write_g2o
from nao_course.geometry import Pose, rotation_2d
from nao_course.graphs import LANDMARK, POSE, Graph

VERTICES = ["VERTEX_SE2 0 1 2 0.5", "VERTEX_SE2 1 2 2.5 0.9", "VERTEX_XY 2 3 1"]
EDGES = ["EDGE_SE2 0 1 1 0 0.3 10 1 0 20 0 100", "EDGE_SE2_XY 1 2 2 -2 4 1 5"]


def written(folder, lines):
    path = folder / "graph.g2o"
    path.write_text("\n".join(lines) + "\n")
    return path


def pose_residual(first, second, z):
    """Return g2o's residual of an edge between poses: inverse(z) inverse(first) second, as x, y and angle."""
    rows = zip(first, second, z, strict=True)
    return [(Pose(*c).inverse() @ Pose(*a).inverse() @ Pose(*b)).as_array() for a, b, c in rows]


def landmark_residual(first, second, z):
    return [Pose(*a).to_local(b)[0] - c for a, b, c in zip(first, second, z, strict=True)]


def squares(graph: Graph, states) -> np.ndarray:
    return graph.squared_errors(states, pose_residual, landmark_residual)


def full(*upper: float) -> np.ndarray:
    matrix = np.zeros((2, 2) if len(upper) == 3 else (3, 3))
    matrix[np.triu_indices(len(matrix))] = upper
    return matrix + np.triu(matrix, 1).T


PRIOR = (1.1, 1.8, 0.7, 10, 1, 2, 20, 3, 30)
PRIOR_LINE = " ".join(map(str, PRIOR))


def chi2_of_prior(pose) -> float:
    error = (Pose(*PRIOR[:3]).inverse() @ Pose(*pose)).as_array()
    return error @ full(*PRIOR[3:]) @ error


@pytest.mark.parametrize("tag", ["EDGE_PRIOR_SE2", "EDGE_SE2_PRIOR"])
def test_a_prior_is_an_edge_from_the_pose_that_fix_holds_with_the_same_chi2(tmp_path, tag):
    """It is an edge of the held pose, wherever that pose is and wherever the other one moves."""
    lines = [*VERTICES, *EDGES, f"{tag} 1 {PRIOR_LINE}", "FIX 0"]
    graph, states = read_g2o(written(tmp_path, lines))
    assert (graph.ids.tolist(), graph.edges.tolist()) == ([0, 1, 2], [[0, 1], [1, 2], [0, 1]])
    states[3:6] = -1, 3, 2.5
    assert squares(graph, states)[2] == pytest.approx(chi2_of_prior(states[3:6]))


def test_priors_are_edges_from_the_held_pose_which_one_prior_that_agrees_with_its_vertex_is_too(tmp_path):
    graph, states = read_g2o(written(tmp_path, [*VERTICES, *EDGES, "EDGE_PRIOR_XY 2 3.5 0 4 1 9", "FIX 0"]))
    assert graph.edges.tolist() == [[0, 1], [1, 2], [0, 2]]
    error = np.array([3, 1]) - (3.5, 0)
    assert squares(graph, states)[2] == pytest.approx(error @ full(4, 1, 9) @ error)
    lines = [*VERTICES, *EDGES, f"EDGE_PRIOR_SE2 0 {PRIOR_LINE}", "FIX 0"]
    with pytest.warns(UserWarning, match="left out 1 prior of pose 0, because FIX holds it"):
        graph, _ = read_g2o(written(tmp_path, lines))
    assert graph.edges.tolist() == [[0, 1], [1, 2]]
    lines = [*VERTICES, *EDGES, "EDGE_PRIOR_SE2 1 2 2.5 0.9 1 0 0 1 0 1"]
    graph, states = read_g2o(written(tmp_path, lines))
    assert (graph.ids.tolist(), graph.edges.tolist()) == ([1, 0, 2], [[1, 0], [0, 2]])
    assert states[:3].tolist() == [2, 2.5, 0.9]
    graph, states = read_g2o(written(tmp_path, [*EDGES, "EDGE_PRIOR_SE2 1 5 6 0.5 1 0 0 1 0 1"]))
    assert graph.ids.tolist() == [1, 0, 2]
    assert states[:3].tolist() == [5, 6, 0.5]
    assert squares(graph, states) == pytest.approx([0, 0], abs=1e-20)


@pytest.mark.parametrize(
    "priors",
    [
        [f"EDGE_PRIOR_SE2 1 {PRIOR_LINE}"],
        ["EDGE_PRIOR_SE2 0 1 2 0.5 1 0 0 1 0 1", f"EDGE_PRIOR_SE2 1 {PRIOR_LINE}"],
        ["EDGE_PRIOR_XY 2 0 0 1 0 1", f"EDGE_PRIOR_SE2 1 {PRIOR_LINE}"],
    ],
    ids=["one, at another place than its vertex", "two", "a landmark's"],
)
def test_other_priors_are_edges_from_one_extra_pose_at_the_origin_which_is_said(tmp_path, priors):
    with pytest.warns(UserWarning, match=f"added pose 3, .* for {len(priors)} prior"):
        graph, states = read_g2o(written(tmp_path, [*VERTICES, *EDGES, *priors]))
    assert graph.ids.tolist() == [3, 0, 1, 2]
    assert states[:3].tolist() == [0, 0, 0]
    assert squares(graph, states)[-1] == pytest.approx(chi2_of_prior(states[6:9]))
    again, values = read_g2o(write_g2o(graph, states, tmp_path / "own.g2o"))
    assert again.edges.tolist() == graph.edges.tolist() and values.tolist() == states.tolist()


@pytest.mark.parametrize(
    ("second", "theta", "within"),
    [("0 0 -0.7", 0.9, 1e-12), ("0.2 0.1 -0.7", 0.91, 0.02), ("0.2 0.1 -0.7", 0.8, 0.1)],
)
def test_an_edge_between_two_sensors_has_the_chi2_of_their_poses(tmp_path, second, theta, within):
    """It is exact if the second sensor only turns, and otherwise to first order in the angle of the residual."""
    lines = ["PARAMS_SE2OFFSET 7 0.3 -0.1 1.2", f"PARAMS_SE2OFFSET 8 {second}", "VERTEX_SE2 0 1 2 0.5"]
    z = Pose(0.3, -0.1, 1.2).inverse() @ Pose(1, 2, 0.5).inverse() @ Pose(2, 2.5, 0.9)
    z = z @ Pose(*map(float, second.split()))
    z = Pose(z.x + 0.1, z.y - 0.2, z.theta)
    lines += [f"VERTEX_SE2 1 2 2.5 {theta}"]
    lines += [f"EDGE_SE2_OFFSET 0 1 7 8 {z.x} {z.y} {z.theta} 10 1 2 20 3 30"]
    graph, states = read_g2o(written(tmp_path, lines))
    one = Pose(*states[:3]) @ Pose(0.3, -0.1, 1.2)
    other = Pose(*states[3:]) @ Pose(*map(float, second.split()))
    error = (z.inverse() @ one.inverse() @ other).as_array()
    assert squares(graph, states)[0] == pytest.approx(error @ full(10, 1, 2, 20, 3, 30) @ error, rel=within)


def test_a_landmark_is_seen_from_its_sensor_and_bearings_and_priors_of_places_are_said_to_be_left(tmp_path):
    lines = ["PARAMS_SE2OFFSET 7 0.3 -0.1 1.2", *VERTICES, EDGES[0]]
    lines += ["EDGE_SE2_POINTXY_OFFSET 1 2 7 1 -2 4 1 9"]
    with pytest.warns(UserWarning, match="1 line with EDGE_SE2_POINTXY_OFFSET; g2o leaves them out"):
        graph, states = read_g2o(written(tmp_path, lines))
    error = (Pose(2, 2.5, 0.9) @ Pose(0.3, -0.1, 1.2)).to_local([3, 1])[0] - (1, -2)
    assert squares(graph, states)[1] == pytest.approx(error @ full(4, 1, 9) @ error)
    read_g2o(written(tmp_path, ["PARAMS_SE2OFFSET 7 0 0 0", *lines[1:]]))  # and nothing is said
    lines = [*VERTICES, *EDGES, "EDGE_BEARING_SE2_XY 0 2 0.5 4", "EDGE_BEARING_SE2_XY 1 2 0.5 4"]
    lines.append("EDGE_PRIOR_SE2_XY 0 1 2 1 0 1")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        graph, _ = read_g2o(written(tmp_path, lines))
    said = sorted(str(each.message).partition("g2o: ")[2] for each in caught)
    assert said[0].startswith("left out 1 line with EDGE_PRIOR_SE2_XY, because a prior of a position without")
    assert said[1].startswith("left out 2 lines with EDGE_BEARING_SE2_XY, because a bearing without a range")
    assert len(said) == 2 and len(graph.edges) == 2


# --- iSAM and GTSAM ---

STEPS = ["ODOMETRY 0 1 1 0.1 0.2", "EDGE2 1 2 1 0 0.1", "LANDMARK 1 5 2 -1"]


def with_matrices(odometry: str, landmark: str) -> list[str]:
    return [f"{STEPS[0]} {odometry}", f"{STEPS[1]} {odometry}", f"{STEPS[2]} {landmark}"]


def test_isams_matrices_are_square_roots_row_by_row_and_victoria_park_has_gtsams_information(tmp_path):
    lines = with_matrices("10 1 2 20 3 30", "4 1 5")
    graph, states = read_g2o(written(tmp_path, lines), form="isam")
    root = np.array([[10, 1, 2], [0, 20, 3], [0, 0, 30]])
    assert np.allclose(graph.information[:2], root.T @ root)
    assert np.allclose(graph.information[2, :2, :2], np.array([[16, 4], [4, 26]]))
    assert graph.kinds.tolist() == [POSE] * 3 + [LANDMARK]
    assert graph.ids.tolist() == [0, 1, 2, 5]
    assert squares(graph, states) == pytest.approx([0, 0, 0], abs=1e-20)
    step, seen = "ODOMETRY 0 1 0.000985144 -3.63222e-10 -1.54136e-06", "LANDMARK 0 5 11.5387 -3.2007"
    lines = [f"{step} 100 0 0 500 0 500", f"{seen} 1.581139 0 1.581139"]
    isam, _ = read_g2o(written(tmp_path, lines), form="isam")
    lines = [f"{step} 0.0001 0 0 4e-06 0 4e-06", f"{seen} 0.4 0 0.4"]
    gtsam, _ = read_g2o(written(tmp_path, lines), form="gtsam")
    assert np.allclose(isam.information, gtsam.information, rtol=1e-6)


@pytest.mark.parametrize(
    "odometry", ["0.04 0 0.01 0.25 0 0", "0.04 0 0 0.01 0 0.25"], ids=["TORO's order", "g2o's"]
)
def test_gtsams_matrices_are_covariances_in_either_order(tmp_path, odometry):
    graph, _ = read_g2o(written(tmp_path, with_matrices(odometry, "0.4 0.1 0.2")), form="gtsam")
    assert np.allclose(graph.information[:2], np.diag([25, 100, 4]))
    assert np.allclose(graph.information[2, :2, :2] @ [[0.4, 0.1], [0.1, 0.2]], np.eye(2))


def test_a_bearing_and_a_range_are_a_position_and_place_a_landmark_without_a_vertex_line(tmp_path):
    lines = ["VERTEX2 0 0 0 0", "BR 0 3 0.6 2 0.1 0.5"]
    graph, states = read_g2o(written(tmp_path, [*lines, "VERTEX_XY 3 1 1"]), form="gtsam")
    ahead, left = rotation_2d(0.6).T
    assert np.allclose(graph.measurements[0, :2], 2 * ahead)
    covariance = np.linalg.inv(graph.information[0, :2, :2])
    assert (ahead @ covariance @ ahead, left @ covariance @ left) == pytest.approx((0.5**2, (2 * 0.1) ** 2))
    assert ahead @ covariance @ left == pytest.approx(0, abs=1e-12)
    assert states.tolist() == [0, 0, 0, 1, 1]
    lines = ["VERTEX2 0 1 2 0", "VERTEX2 1 3 2 0"]
    lines += ["BR 0 7 0 2 0.1 0.5", "BR 1 7 0 2 0.1 0.5", "BR 1 6 0 1 0.1 0.5"]
    graph, states = read_g2o(written(tmp_path, lines), form="gtsam")
    assert graph.ids.tolist() == [0, 1, 6, 7]
    assert states[6:].tolist() == [4, 2, 3, 2]


@pytest.mark.parametrize("form", ["isam", "gtsam"])
def test_landmarks_with_the_numbers_of_poses_are_renamed_and_it_is_said(tmp_path, form):
    lines = ["ODOMETRY 0 1 1 0 0 1 0 0 1 0 1", "LANDMARK 0 1 2 0 1 0 1", "LANDMARK 1 1 1 0 1 0 1"]
    with pytest.warns(UserWarning, match="landmarks have the numbers of poses, so 2 was added to theirs"):
        graph, _ = read_g2o(written(tmp_path, lines), form=form)
    assert (graph.ids.tolist(), graph.edges.tolist()) == ([0, 1, 3], [[0, 1], [0, 2], [1, 2]])


@pytest.mark.parametrize(
    ("line", "calls"),
    [
        ("ODOMETRY 0 1 1 0 0 1 0 0 1 0 1", "form='isam' or form='gtsam'"),
        ("LANDMARK 0 2 1 0 1 0 1", "form='isam' or form='gtsam'"),
        ("BR 0 2 1 0 1 0", "form='gtsam'"),
    ],
)
def test_tags_whose_meaning_depends_on_the_program_are_refused_with_the_call_to_make(tmp_path, line, calls):
    with pytest.raises(ValueError, match=rf"line 4: .* not a tag of g2o or TORO.*read the file with {calls}"):
        read_g2o(written(tmp_path, [*VERTICES, line]))


def test_an_edge2_of_isam_is_refused_as_one_of_toro_and_so_are_unknown_forms_and_repeated_offsets(tmp_path):
    """Every diagonal matrix in iSAM's order is singular in TORO's."""
    lines = ["EDGE2 0 1 0.0929227 0.0811209 -0.023382 3.16228 0 0 3.16228 0 5"]
    with pytest.raises(ValueError, match="line 1: the information .*TORO's order.*form='isam'"):
        read_g2o(written(tmp_path, lines))
    graph, _ = read_g2o(written(tmp_path, lines), form="isam")
    assert np.allclose(np.diag(graph.information[0]), [10, 10, 25], rtol=1e-5)
    with pytest.raises(ValueError, match="form must be one of g2o, toro, isam, gtsam, got 'tum'"):
        read_g2o(written(tmp_path, VERTICES), form="tum")
    with pytest.raises(ValueError, match="line 2: offset 7 is defined twice"):
        read_g2o(written(tmp_path, ["PARAMS_SE2OFFSET 7 0 0 0"] * 2))
    lines = [f"LANDMARK {BIG} {BIG} 1 0 1 0 1"]
    with pytest.raises(ValueError, match="too large to change them"):
        read_g2o(written(tmp_path, lines), form="isam")


BIG = 2**63 - 1


@pytest.mark.parametrize(
    ("form", "line", "message"),
    [
        ("g2o", "EDGE_PRIOR_SE2 2 0 0 0 1 0 0 1 0 1", "vertex 2 must be a pose, but it is a landmark"),
        ("g2o", "EDGE_PRIOR_SE2 1 0 0 0 1 2 0 1 0 1", "the information matrix is singular or not"),
        ("g2o", "EDGE_PRIOR_XY 1 0 0 1 0 1", "vertex 1 must be a landmark, but it is a pose"),
        ("g2o", "EDGE_PRIOR_XY 2 0 0 1 1 1", "the information matrix is singular"),
        ("g2o", "EDGE_SE2_OFFSET 0 1 7 0 0 0 1 0 0 1 0 1", "2 offsets and 9 numbers, 14 words; got 13"),
        ("g2o", "EDGE_SE2_OFFSET 0 1 7 8 0 0 0 1 0 0 1 0 1", "there is no PARAMS_SE2OFFSET 7"),
        ("g2o", "PARAMS_SE2OFFSET 7 0 0", "PARAMS_SE2OFFSET needs 1 offset and 3 numbers, 5 words; got 4"),
        ("g2o", "PARAMS_SE2OFFSET 7 0 1e16 0", "expected numbers within .*number 2"),
        ("isam", "ODOMETRY 0 1 1 0 0 0 0 0 1 0 1", "the information matrix is singular"),
        ("isam", "ODOMETRY 0 1 1 0 0 1e9 0 0 1 0 1", "expected an information matrix within"),
        ("isam", "BR 0 2 1 1 1 1", "BR is not a tag .*form='gtsam'"),
        ("gtsam", "ODOMETRY 0 1 1 0 0 1 0.5 0 1 0 1", "GTSAM's load2D reads only diagonal covariances"),
        ("gtsam", "ODOMETRY 0 1 1 0 0 1e-310 0 0 1 0 1", "expected an information matrix within"),
        ("gtsam", "LANDMARK 0 2 1 0 1 2 1", "the covariance matrix is singular or not"),
        ("gtsam", "BR 0 2 0.5 0 0.1 0.1", "the range and both standard deviations of BR must be positive"),
        ("gtsam", "BR 0 2 0.5 1 0.1 -0.1", "the range and both standard deviations of BR must be positive"),
        ("gtsam", "BR 0 2 0.5 1 1e-300 0.1", "expected an information matrix within"),
    ],
)
def test_a_wrong_line_of_any_tag_is_refused_with_its_file_and_number(tmp_path, form, line, message):
    with pytest.raises(ValueError, match=rf"graph\.g2o, line 6: .*{message}") as caught:
        read_g2o(written(tmp_path, [*VERTICES, *EDGES, line]), form=form)
    assert len(str(caught.value)) < 500


EVERY_TAG = [
    *VERTICES,
    "VERTEX2 4 0 0 0",
    *EDGES,
    "PARAMS_SE2OFFSET 7 0.3 -0.1 1.2",
    "EDGE_PRIOR_SE2 1 0 0 0 1 0 0 1 0 1",
    "EDGE_PRIOR_XY 2 0 0 1 0 1",
    "EDGE_SE2_OFFSET 0 1 7 7 0 0 0 1 0 0 1 0 1",
    "EDGE_SE2_POINTXY_OFFSET 0 2 7 1 1 1 0 1",
    "EDGE_BEARING_SE2_XY 0 2 0.5 4",
    "FIX 0",
]
OTHER_PROGRAMS = ["ODOMETRY 0 1 1 0 0 1 0 0 1 0 1", "LANDMARK 0 2 1 0 1 0 1", "BR 0 2 0.5 1 0.1 0.1"]
OF_FORM = {"g2o": 0, "isam": 2, "gtsam": 3}
WORDS = st.sampled_from(
    ["", "#", "nan", "inf", "-1", "0", "0.5", "1e-320", "1e308", "9" * 30, "x", "1 1", "\n", "é"]
)


@pytest.mark.filterwarnings("ignore::UserWarning")
@settings(max_examples=150, deadline=None)
@given(
    form=st.sampled_from(["g2o", "isam", "gtsam"]),
    edits=st.lists(st.tuples(st.integers(0, 200), WORDS), min_size=1, max_size=4),
    dropped=st.sets(st.integers(0, 16), max_size=6),
)
def test_random_edits_of_a_good_file_give_a_graph_or_a_message(form, edits, dropped, tmp_path_factory):
    matrix = "1 0 1 1 0 0" if form == "gtsam" else "2 0 2 2 0 1"
    lines = [*EVERY_TAG, f"EDGE2 1 4 1 0 0 {matrix}", *OTHER_PROGRAMS[: OF_FORM[form]]]
    words = " \n ".join(line for number, line in enumerate(lines) if number not in dropped).split(" ")
    for place, word in edits:
        words[place % len(words)] = word
    path = tmp_path_factory.mktemp("edited") / "graph.g2o"
    path.write_text(" ".join(words), encoding="utf-8")
    try:
        graph, states = read_g2o(path, form=form)
    except ValueError as error:
        refused = str(error)
    else:
        refused = f"{path} is a graph"
        assert np.isfinite(graph.information).all() and states.shape == (graph.size,)
    assert "graph.g2o" in refused
