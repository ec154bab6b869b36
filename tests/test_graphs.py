"""A graph says what it is made of, adds its edges' blocks up as scipy does, and knows an order that keeps H sparse."""

import re

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

from nao_course.codec import decode, encode
from nao_course.graphs import LANDMARK, POSE, Graph, matrices


def some_graph(rng: np.random.Generator, poses: int = 8, landmarks: int = 4, edges: int = 30) -> Graph:
    """A chain of poses, and edges between any two: many of them twice."""
    first = np.concatenate([np.arange(poses - 1), rng.integers(poses, size=edges)])
    second = np.concatenate([np.arange(1, poses), rng.integers(1, poses + landmarks, size=edges)])
    second = np.where(first == second, (second + 1) % (poses + landmarks), second)
    roots = rng.normal(size=(len(first), 3, 3))
    information = roots @ roots.mT
    information[second >= poses, 2], information[second >= poses, :, 2] = 0.0, 0.0
    z = rng.normal(size=(len(first), 3))
    kinds = [POSE] * poses + [LANDMARK] * landmarks
    return Graph(np.column_stack([first, second]), z, information, kinds)


def grid(side: int) -> Graph:
    """Poses on a grid, each linked with its neighbours."""
    number = np.arange(side * side).reshape(side, side)
    pairs = (number[:, :-1], number[:, 1:]), (number[:-1], number[1:])
    links = np.concatenate([np.column_stack([one.ravel(), other.ravel()]) for one, other in pairs])
    unit = np.broadcast_to(np.eye(3), (len(links), 3, 3))
    return Graph(links, np.zeros((len(links), 3)), unit, np.full(side * side, POSE))


def test_states_are_split_into_poses_and_landmarks_which_edges_find(rng):
    graph = some_graph(rng, 3, 2)
    poses, landmarks = graph.split(np.arange(13.0))
    assert poses.tolist() == [[0, 1, 2], [3, 4, 5], [6, 7, 8]]
    assert landmarks.tolist() == [[9, 10], [11, 12]]
    with pytest.raises(ValueError, match=r"states must have shape \(13,\): 3 poses and 2 landmarks"):
        graph.split(np.zeros(12))
    graph = some_graph(rng)
    states = rng.normal(size=graph.size)
    poses, landmarks = graph.split(states)
    for edges, ends in ((graph.pose_edges, poses), (graph.landmark_edges, landmarks)):
        both = np.concatenate([poses[edges.first], ends[edges.second]], axis=1)
        assert len(both) and np.array_equal(states[edges.places], both)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"edges": [[0, 5]]}, "indices of edges must be 0 to 2, got 5"),
        ({"edges": [[2, 0]]}, "first end of an edge must be a pose"),
        ({"kinds": [POSE, LANDMARK, POSE]}, "poses first"),
        ({"kinds": [POSE, POSE, 7]}, "POSE or LANDMARK"),
        ({"measurements": [[1.0, 2.0]]}, r"measurements must have shape \(1, 3\)"),
        ({"information": np.eye(3)}, r"information must have shape \(1, 3, 3\)"),
        ({"ids": [1, 2]}, r"ids must have shape \(3,\)"),
    ],
)
def test_what_does_not_fit_is_said(changed, message):
    whole = {"edges": [[0, 1]], "measurements": [[1.0, 0, 0]], "information": [np.eye(3)]}
    with pytest.raises(ValueError, match=message):
        Graph(**({"kinds": [POSE, POSE, LANDMARK]} | whole | changed))  # type: ignore[arg-type]


def test_a_graph_survives_being_stored_and_squared_errors_stand_in_the_order_of_its_edges(rng):
    graph = some_graph(rng)
    again = decode(encode(graph))
    for name in ("edges", "measurements", "information", "kinds", "ids"):
        assert np.array_equal(getattr(graph, name), getattr(again, name))
    graph = some_graph(rng)
    squares = graph.squared_errors(
        np.zeros(graph.size), lambda first, second, z: z, lambda pose, landmark, z: z
    )
    wanted = [
        z @ information @ z for z, information in zip(graph.measurements, graph.information, strict=True)
    ]
    assert squares == pytest.approx(wanted)


def test_matrices_puts_numbers_and_arrays_together():
    assert matrices([[1, 2], [3, 4]]).tolist() == [[1, 2], [3, 4]]
    many = matrices([[np.array([1, 2, 3]), 0, 7]])
    assert many.shape == (3, 1, 3) and many[1].tolist() == [[2, 0, 7]]


@pytest.mark.parametrize("landmarks", [0, 4])
def test_blocks_add_up_as_in_scipys_own_sum(rng, landmarks):
    graph = some_graph(rng, landmarks=landmarks)
    for _ in range(2):  # the second time from what was found in the first
        groups = [graph.pose_edges.places, graph.landmark_edges.places]
        blocks = [rng.normal(size=(*places.shape, places.shape[1])) for places in groups]
        wanted = np.zeros((graph.size, graph.size))
        for places, each in zip(groups, blocks, strict=True):
            np.add.at(wanted, (places[:, :, None], places[:, None, :]), each)
        found = graph.add_blocks(*blocks)
        assert isinstance(found, scipy.sparse.csc_array) and found.has_canonical_format
        assert found.toarray() == pytest.approx(wanted, abs=1e-12)


def test_the_order_of_elimination_has_every_state_once_and_keeps_poses_and_landmarks_whole(rng):
    graph = some_graph(rng)
    assert sorted(graph.elimination_order) == list(range(3, graph.size))
    order = graph.elimination_order.tolist()
    for number in range(graph.poses + graph.landmarks):
        begin, width = (
            (3 * number, 3) if number < graph.poses else (3 * graph.poses + 2 * (number - graph.poses), 2)
        )
        if number:
            at = order.index(begin)
            assert order[at : at + width] == list(range(begin, begin + width))


def test_a_factor_in_this_order_is_far_smaller_than_as_numbered():
    graph = grid(25)
    blocks = np.tile(np.block([[np.eye(3), -np.eye(3)], [-np.eye(3), np.eye(3)]]), (len(graph.edges), 1, 1))
    H = graph.add_blocks(blocks, np.zeros((0, 5, 5)))

    def entries(order: np.ndarray) -> int:
        options = {"diag_pivot_thresh": 0.0, "options": {"SymmetricMode": True}}
        return int(scipy.sparse.linalg.splu(H[order][:, order], "NATURAL", **options).L.nnz)

    assert entries(graph.elimination_order) < 0.6 * entries(np.arange(3, graph.size))


@pytest.mark.parametrize(
    ("chi2", "edges", "hint"),
    [
        (300.0, 101, ""),  # 300 degrees of freedom
        (76.0, 101, ""),
        (1190.0, 101, ""),
        (3.0, 101, "chi2 is 0.01 per degree of freedom, .* about 10 times too large.$"),
        (
            30000.0,
            101,
            "chi2 is 1e[+]02 per degree .* covariances, or square .* 10 times too small, some edges are false",
        ),
        (20.0, 2, ""),  # 3 degrees of freedom: chance
        (9.0, 1, ""),  # none
        (0.0, 101, ""),  # no errors at all
    ],
)
def test_a_chi2_far_from_the_degrees_of_freedom_is_hinted_at_unless_it_is_chance(chi2, edges, hint):
    unit = np.broadcast_to(np.eye(3), (edges, 3, 3))
    graph = Graph([[0, 1]] * edges, np.zeros((edges, 3)), unit, [POSE, POSE])
    assert re.match(hint + "$" * (not hint), graph.chi2_hint(chi2))
