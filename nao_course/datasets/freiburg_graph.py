"""The pose-landmark graph of Freiburg's SLAM course, an Octave file in MATLAB's version 5 format."""

from __future__ import annotations

import itertools
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.datasets.files import brief, data_folder
from nao_course.datasets.g2o import parts_of
from nao_course.datasets.graph_lines import LARGEST_NUMBER, positive_definite
from nao_course.datasets.matlab import matlab_variables
from nao_course.geometry import FloatArray
from nao_course.graphs import LANDMARK, POSE, Graph

LARGEST_FILE = 50_000_000  # bytes
WIDTH = {"P": 3, "L": 2}
FIELDS = ("type", "from", "to", "measurement", "information")  # of an edge


def read_freiburg_graph(path: Path | str | None = None) -> tuple[Graph, FloatArray]:
    """Read a graph in the format of Freiburg's SLAM course: a struct g with the fields x, edges and idLookup.

    A warning says if the edges do not connect all vertices.

    Parameters
    ----------
    path : path, optional
        Path of the file; by default ``simulation-pose-landmark.dat`` in `data_folder()`.

    Returns
    -------
    graph : Graph
        Poses, then landmarks, both in the order of the file's state vector. `Graph.ids` contains the file's names.
    states : ndarray, shape (graph.size,)
        Initial guess of the file, m and rad.

    Raises
    ------
    FileNotFoundError
        If no path is given and there is no data folder.
    ValueError
        If the file is missing, empty, too large or malformed. The message contains the file and, if possible, the edge.
    """
    if path is None:
        path = data_folder() / "slam" / "freiburg" / "simulation-pose-landmark.dat"
    path = Path(path)
    struct = _struct(path)
    x = _array(path, "g.x", struct["x"], (np.size(struct["x"]),))
    places = _places(path, struct["idLookup"], len(x))
    several = struct["edges"] if isinstance(struct["edges"], list) else [struct["edges"]]
    edges = [_Edge(f"{path}, edge {number}", edge, places) for number, edge in enumerate(several, 1)]
    if not edges:
        raise ValueError(f"{path}: a graph needs edges, because only they say which vertices are poses")
    is_pose = {
        place for edge in edges for place in (edge.first, *([edge.second] if edge.kind == "P" else []))
    }
    is_landmark = {edge.second for edge in edges if edge.kind == "L"}
    for edge in edges:
        if edge.kind == "L" and edge.second in is_pose:
            raise ValueError(
                f"{edge.where}: vertex {edge.names[1]} is a landmark here, but a pose in another edge"
            )
    order = [*sorted(is_pose), *sorted(is_landmark)]
    widths = [3] * len(is_pose) + [2] * len(is_landmark)
    spans = sorted((place, place + width) for place, width in zip(order, widths, strict=True))
    if any(end > begin for (_, end), (begin, _) in itertools.pairwise([*spans, (len(x), 0)])):
        raise ValueError(
            f"{path}: the state vector is too short for the vertices, or two of them overlap in it"
        )
    number_of = {place: number for number, place in enumerate(order)}
    name_of = {place: name for name, place in places.items()}
    graph = Graph(
        np.array([(number_of[edge.first], number_of[edge.second]) for edge in edges], dtype=int),
        np.array([edge.measurement for edge in edges]),
        np.array([edge.information for edge in edges]),
        np.repeat([POSE, LANDMARK], [len(is_pose), len(is_landmark)]),
        np.array([name_of[place] for place in order]),
    )
    for note in parts_of(graph):
        warnings.warn(f"{path}: {note}", stacklevel=2)
    return graph, np.concatenate(
        [x[place : place + width] for place, width in zip(order, widths, strict=True)]
    )


class _Edge:
    """A checked edge of the file: its kind, the indices of its ends in the state vector, and its measurement."""

    def __init__(self, where: str, edge: Any, places: dict[int, int]) -> None:
        if not isinstance(edge, dict) or any(name not in edge for name in FIELDS):
            raise ValueError(f"{where}: needs the fields {', '.join(FIELDS)}")
        self.where, self.kind = where, str(edge["type"])
        if self.kind not in WIDTH:
            raise ValueError(f"{where}: type must be P or L, got {brief(self.kind)}")
        self.names = [_name(where, edge[end]) for end in ("from", "to")]
        for name in self.names:
            if name not in places:
                raise ValueError(f"{where}: there is no vertex {name} in idLookup")
        self.first, self.second = (places[name] for name in self.names)
        if self.first == self.second:
            raise ValueError(f"{where}: connects vertex {self.names[0]} with itself")
        width = WIDTH[self.kind]
        self.measurement, self.information = np.zeros(3), np.zeros((3, 3))
        self.measurement[:width] = _array(where, "measurement", edge["measurement"], (width,))
        information = _array(where, "information", edge["information"], (width, width))
        if (
            not np.allclose(information, information.T, rtol=1e-9)
            or not positive_definite(information[None])[0]
        ):
            raise ValueError(
                f"{where}: the information matrix must be symmetric and positive definite: {information}"
            )
        self.information[:width, :width] = information


def _struct(path: Path) -> dict[str, Any]:
    """Return the fields of the struct g."""
    struct = matlab_variables(path, LARGEST_FILE, ("g",))["g"]
    if not isinstance(struct, dict) or any(name not in struct for name in ("x", "edges", "idLookup")):
        raise ValueError(f"{path}: g must be a struct with the fields x, edges and idLookup")
    return struct


def _places(path: Path, lookup: Any, size: int) -> dict[int, int]:
    """Return the index in the state vector, from 0, at which each vertex begins."""
    places = {}
    for key, vertex in (lookup if isinstance(lookup, dict) else {}).items():
        name = _name(f"{path}, idLookup", key)
        offset = vertex.get("offset") if isinstance(vertex, dict) else None
        place = float(_array(f"{path}, idLookup, vertex {name}", "offset", offset, ()))
        if not (place.is_integer() and 0 <= place < size):
            raise ValueError(f"{path}, idLookup: vertex {name} begins at {place:g}, outside the state vector")
        places[name] = int(place)
    if len(set(places.values())) < len(places):
        raise ValueError(f"{path}, idLookup: two vertices begin at the same place")
    return places


def _name(where: str, value: Any) -> int:
    """Return the number of a vertex, given as a number or as a field's name such as x17."""
    try:
        number = float(str(value).lstrip("x"))
    except ValueError:
        number = np.nan
    if not (0 <= number < 2**53 and number.is_integer()):
        raise ValueError(f"{where}: the number of a vertex must be an integer, got {brief(str(value))}")
    return int(number)


def _array(where: str | Path, name: str, value: Any, shape: tuple[int, ...]) -> FloatArray:
    """Return a value as an array of finite numbers, or raise an error if it has another shape."""
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        array = np.full(1, np.nan)
    if array.shape != shape or not (np.abs(array) <= LARGEST_NUMBER).all():
        raise ValueError(f"{where}: {name} must be finite numbers of shape {shape}, got {brief(str(value))}")
    return array
