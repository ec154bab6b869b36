"""Freiburg's graph is read whole, or refused with its file and edge."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

from nao_course.datasets import read_freiburg_graph
from nao_course.graphs import LANDMARK, POSE


def a_graph() -> dict[str, Any]:
    """Landmark 5 stands before pose 7 and pose 8 in the state vector, as in the course's file."""
    edge = {"from": 7, "to": 8, "measurement": [1, 0, 0.5], "information": np.diag([1.0, 2, 3]), "type": "P"}
    sight = {"from": 8, "to": 5, "measurement": [1.0, 2.0], "information": [[2.0, 1], [1, 2]], "type": "L"}
    lookup = {"x5": {"offset": 0, "dimension": 2}, "x7": {"offset": 2, "dimension": 3}, "x8": {"offset": 5}}
    return {"x": np.arange(8.0), "edges": [edge, sight], "idLookup": lookup}


def saved(folder: Path, graph: Any, name: str = "g") -> Path:
    path = folder / "graph.mat"
    if isinstance(graph, dict) and "edges" in graph:
        graph["edges"] = np.array(graph["edges"], dtype=object)
    scipy.io.savemat(path, {name: graph})
    return path


def test_poses_come_first_and_landmarks_behind_them_and_unconnected_vertices_are_said(tmp_path):
    graph, states = read_freiburg_graph(saved(tmp_path, a_graph()))
    assert graph.ids.tolist() == [7, 8, 5]
    assert graph.kinds.tolist() == [POSE, POSE, LANDMARK]
    assert graph.edges.tolist() == [[0, 1], [1, 2]]
    assert graph.measurements.tolist() == [[1, 0, 0.5], [1, 2, 0]]
    assert graph.information[1].tolist() == [[2, 1, 0], [1, 2, 0], [0, 0, 0]]
    assert states.tolist() == [2, 3, 4, 5, 6, 7, 0, 1]
    graph = a_graph()
    graph["idLookup"] |= {"x9": {"offset": 8}, "x10": {"offset": 11}}
    graph["x"] = np.arange(14.0)
    graph["edges"].append(graph["edges"][0] | {"from": 9, "to": 10})
    with pytest.warns(UserWarning, match=r"graph\.mat: .*2 parts, and vertices 7 and 9 are in different"):
        read_freiburg_graph(saved(tmp_path, graph))


def edge(number: int, **to: Any) -> Callable[[dict[str, Any]], None]:
    return lambda graph: graph["edges"][number].update(to)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (edge(0, to=9), "edge 1: there is no vertex 9 in idLookup"),
        (edge(0, to=7), "edge 1: connects vertex 7 with itself"),
        (edge(0, to=5), "edge 2: vertex 5 is a landmark here, but a pose in another edge"),
        (edge(1, type="B"), "edge 2: type must be P or L, got 'B'"),
        (edge(1, measurement=[1.0, np.nan]), "edge 2: measurement must be finite"),
        (edge(1, measurement=[1.0, 2, 3]), "edge 2: measurement must be .* shape"),
        (edge(0, information=np.eye(2)), "edge 1: information must be .* shape"),
        (edge(0, information=np.diag([1.0, 1, 0])), "edge 1: the information matrix must be symmetric and"),
        (edge(0, **{"from": 7.5}), "edge 1: the number of a vertex must be an integer"),
        (lambda graph: graph["edges"][0].pop("information"), "edge 1: needs the fields"),
        (lambda graph: graph.update(x=np.arange(7.0)), "the state vector is too short"),
        (lambda graph: graph["idLookup"]["x8"].update(offset=2), "two vertices begin at the same place"),
        (lambda graph: graph["idLookup"]["x8"].update(offset=99), "vertex 8 begins at 99, outside"),
        (lambda graph: graph["idLookup"]["x8"].pop("offset"), "vertex 8: offset must be finite numbers"),
        (lambda graph: graph["x"].__setitem__(3, np.inf), "g.x must be finite"),
        (lambda graph: graph.pop("edges"), "expected a MATLAB file"),
        (lambda graph: graph.update(edges=[]), "a graph needs edges"),
    ],
)
def test_what_is_wrong_is_refused_with_file_and_edge(tmp_path, change, message):
    graph = a_graph()
    change(graph)
    with pytest.raises(ValueError, match=rf"graph\.mat.*{message}"):
        read_freiburg_graph(saved(tmp_path, graph))


@pytest.mark.parametrize("cut", [1, 130, -10])
def test_a_damaged_file_is_refused(tmp_path, cut):
    path = saved(tmp_path, a_graph())
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(ValueError, match=r"graph\.mat"):
        read_freiburg_graph(path)


def test_what_is_no_such_file_is_refused(tmp_path):
    with pytest.raises(ValueError, match="cannot be read"):
        read_freiburg_graph(tmp_path / "nothing")
    with pytest.raises(ValueError, match="expected a MATLAB file"):
        read_freiburg_graph(saved(tmp_path, 3.0))
    with pytest.raises(ValueError, match="expected a MATLAB file"):
        read_freiburg_graph(saved(tmp_path, a_graph(), "h"))


def test_the_courses_file_is_read(data_dir):
    graph, states = read_freiburg_graph()
    assert (graph.poses, graph.landmarks, len(graph.edges)) == (41, 36, 297)
    assert states.shape == (195,)
