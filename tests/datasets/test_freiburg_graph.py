"""Freiburg's graph is read whole, or refused with its file and edge."""

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st

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
    if isinstance(graph, dict) and isinstance(graph.get("edges"), list):
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
        (lambda graph: graph.pop("edges"), "g must be a struct with the fields x, edges and idLookup"),
        (lambda graph: graph.update(edges=[]), "a graph needs edges"),
    ],
)
def test_what_is_wrong_is_refused_with_file_and_edge(tmp_path, change, message):
    graph = a_graph()
    change(graph)
    with pytest.raises(ValueError, match=rf"graph\.mat.*{message}"):
        read_freiburg_graph(saved(tmp_path, graph))


def as_one_array(graph: dict[str, Any]) -> dict[str, Any]:
    """Return the graph with its edges in one array of structs, as in the course's file, instead of cells."""
    fields = [(name, object) for name in graph["edges"][0]]
    return graph | {"edges": np.array([tuple(edge.values()) for edge in graph["edges"]], fields)}


def test_edges_in_cells_in_one_array_or_alone_are_read_alike(tmp_path):
    graph, states = read_freiburg_graph(saved(tmp_path, a_graph()))
    other, same = read_freiburg_graph(saved(tmp_path, as_one_array(a_graph())))
    assert states.tolist() == same.tolist()
    assert all(np.array_equal(value, vars(other)[name]) for name, value in vars(graph).items())
    alone = a_graph()
    del alone["edges"][1], alone["idLookup"]["x5"]
    assert read_freiburg_graph(saved(tmp_path, as_one_array(alone)))[0].edges.tolist() == [[0, 1]]


def put(place: int, data: bytes) -> Callable[[bytes], bytes]:
    return lambda file: file[:place] + data + file[place + len(data) :]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda file: file[:-10], "it ends too early"),
        (put(126, b"17"), "cannot be read as a MATLAB file of version 5 to 7"),
        (put(136 + 24, b"\xff\xff\xff\x7f"), "2147483647 structs of 3 fields have 3 values"),
        (put(136 + 44, b"\0\0\0\0"), "cannot be read as a MATLAB file"),
        (lambda file: file[:128] + nested(2000), "recursion"),
    ],
)
def test_a_wrong_size_is_refused_with_the_file(tmp_path, damage, message):
    path = saved(tmp_path, as_one_array(a_graph()))
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(ValueError, match=rf"graph\.mat: .*{message}"):
        read_freiburg_graph(path)


def nested(depth: int) -> bytes:
    """Return a variable g of cells in cells."""
    head = struct.pack("<8I", 6, 8, 1, 0, 5, 8, 1, 1) + struct.pack("<HH4s", 1, 1, b"g")
    cells = b""
    for _ in range(depth):
        cells = struct.pack("<2I", 14, len(head) + len(cells)) + head + cells
    return cells


@settings(max_examples=60, deadline=None)
@given(place=st.integers(0, 5_000), bits=st.integers(1, 255), cut=st.booleans())
@pytest.mark.filterwarnings("ignore:.*parts, and vertices")
def test_random_edits_give_a_graph_or_a_message_with_the_file(tmp_path_factory, place, bits, cut):
    path = saved(tmp_path_factory.mktemp("edited"), as_one_array(a_graph()))
    data = bytearray(path.read_bytes())
    place %= len(data)
    data[place] ^= bits
    path.write_bytes(data[:place] if cut else data)
    try:
        graph, states = read_freiburg_graph(path)
    except ValueError as error:
        said = str(error)
    else:
        said = str(path)
        assert states.shape == (graph.size,) and np.isfinite(states).all()
    assert str(path) in said


@pytest.mark.parametrize("cut", [1, 130, -10])
def test_a_damaged_file_is_refused(tmp_path, cut):
    path = saved(tmp_path, a_graph())
    path.write_bytes(path.read_bytes()[:cut])
    with pytest.raises(ValueError, match=r"graph\.mat"):
        read_freiburg_graph(path)


def test_what_is_no_such_file_is_refused(tmp_path):
    with pytest.raises(ValueError, match="cannot be read"):
        read_freiburg_graph(tmp_path / "nothing")
    with pytest.raises(ValueError, match=r"graph\.mat: g must be a struct"):
        read_freiburg_graph(saved(tmp_path, 3.0))
    with pytest.raises(ValueError, match=r"graph\.mat: the variable g is missing"):
        read_freiburg_graph(saved(tmp_path, a_graph(), "h"))


def test_the_courses_file_is_read(data_dir):
    graph, states = read_freiburg_graph()
    assert (graph.poses, graph.landmarks, len(graph.edges)) == (41, 36, 297)
    assert states.shape == (195,)
