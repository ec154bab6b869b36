"""Pose graphs in the text formats of g2o and TORO. A malformed file raises an error with the line.

Writing loses no precision. FIX is written last, because GTSAM 4.3 reads no edge below it.
"""

from __future__ import annotations

import re
import warnings
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from nao_course._internal.counts import say_count
from nao_course.datasets.files import brief, text_of
from nao_course.geometry import FloatArray, Pose
from nao_course.graphs import LANDMARK, POSE, Graph

# Limits far above any real file, but low enough that a malicious file cannot use much memory or time.
LARGEST_GRAPH = 100_000_000  # bytes
LARGEST_NUMBER = 1e15
LEAST_EIGENVALUE = 1e-12  # of a usable information matrix, after its diagonal has been scaled to 1

MOST_UNKNOWN_TAGS = 20  # of a file that may be a graph

# For each tag, the number of vertex names, and the number of values after them.
WIDTHS = {"VERTEX_SE2": (1, 3), "VERTEX_XY": (1, 2), "EDGE_SE2": (2, 9), "EDGE_SE2_XY": (2, 5), "FIX": (1, 0)}
TORO = {"VERTEX2": "VERTEX_SE2", "EDGE2": "EDGE_SE2"}
# Places of g2o's upper triangle (11 12 13 22 23 33) in TORO's order (11 12 22 33 13 23), and the other way round.
FROM_TORO, TO_TORO = [0, 1, 4, 2, 5, 3], [0, 1, 3, 5, 2, 4]
_TAG = re.compile(r"[A-Za-z][A-Za-z0-9_:]{0,60}")
KIND_OF_VERTEX = {"VERTEX_SE2": POSE, "VERTEX_XY": LANDMARK}
NAME_OF_KIND = {POSE: "pose", LANDMARK: "landmark"}
KIND_OF_END = {"EDGE_SE2": POSE, "EDGE_SE2_XY": LANDMARK}


class Record(NamedTuple):
    """A line of a file: its line number, the names of its vertices, and its values."""

    line: int
    ids: list[int]
    numbers: list[float]


def read_g2o(path: Path | str) -> tuple[Graph, FloatArray]:
    """Read a pose graph in the plane from a file of g2o or TORO.

    The tags VERTEX_SE2, VERTEX_XY, EDGE_SE2, EDGE_SE2_XY and FIX of g2o are known, and VERTEX2 and EDGE2 of TORO, whose
    information matrices have another order. ``#`` starts a comment. Lines with other tags are left out with a warning,
    and so are all FIX names but the first, because a `Graph` holds only its first pose. A warning also says if the
    edges do not connect all vertices.

    Some published graphs, such as CSAIL and KITTI, have no VERTEX lines at all. The initial guess then follows the
    edges, breadth first, from the pose of the FIX line, or from the pose with the lowest id. That pose is the origin.

    Parameters
    ----------
    path : path
        Path of the file.

    Returns
    -------
    graph : Graph
        Poses, landmarks and edges in the order of the file, or by id if there are no VERTEX lines. The pose of a FIX
        line comes first. `Graph.ids` contains the names of the vertices in the file.
    states : ndarray, shape (graph.size,)
        Initial guess of the file, or the guess that follows the edges; m and rad.

    Raises
    ------
    ValueError
        If the file is missing, empty or too large. If a line has a wrong number of values, a value that is not finite,
        an unknown or duplicate vertex, or an information matrix that is not positive definite. If there are no VERTEX
        lines and the edges do not connect all poses. The message contains the file and the line.
    """
    path = Path(path)
    records = _records(path)
    if not (records["VERTEX_SE2"] or records["VERTEX_XY"]):
        records |= _vertices_from_edges(path, records)
    ids, kinds, states = _vertices(path, records)
    number_of = {name: number for number, name in enumerate(ids)}
    edges = sorted((record, tag) for tag in KIND_OF_END for record in records[tag])
    ends = [_ends(path, record, KIND_OF_END[tag], number_of, kinds) for record, tag in edges]
    measurements, information = np.zeros((len(edges), 3)), np.zeros((len(edges), 3, 3))
    of_kind = np.array([KIND_OF_END[tag] for _, tag in edges], dtype=int)
    for kind, width in ((POSE, 3), (LANDMARK, 2)):
        chosen = np.flatnonzero(of_kind == kind)
        rows = [edges[number][0] for number in chosen]
        values = _numbers(path, rows, width + width * (width + 1) // 2)
        measurements[chosen, :width] = values[:, :width]
        information[chosen, :width, :width] = _information(path, rows, values[:, width:], width)
    _warn_of_islands(path, ends, ids)
    return Graph(np.array(ends, dtype=int), measurements, information, np.array(kinds), np.array(ids)), states


def write_g2o(
    graph: Graph, states: npt.ArrayLike, path: Path | str, *, form: Literal["g2o", "toro"] = "g2o"
) -> Path:
    """Write a graph and its states to a file of g2o or TORO, from which `read_g2o` restores both to the last bit.

    Parameters
    ----------
    graph : Graph
        Graph of measurements.
    states : array_like, shape (graph.size,)
        Initial guess or optimum, m and rad.
    path : path
        Path of the file, which is overwritten if it exists.
    form : "g2o" or "toro"
        Format of the file. TORO has no landmarks and no FIX.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    ValueError
        If a value is not finite, because it could not be read again, or a graph with landmarks is written for TORO.
    """
    path = Path(path)
    poses, landmarks = graph.split(states)
    toro = form == "toro"
    if toro and graph.landmarks:
        raise ValueError(f"{path}: not written, because TORO has no landmarks; use form='g2o'")
    for name, values in (
        ("states", np.asarray(states)),
        ("edges", graph.measurements),
        ("edges", graph.information),
    ):
        if not np.isfinite(values).all():
            raise ValueError(f"{path}: not written, because the {name} contain numbers that are not finite")
    lines = [
        f"{tag} {name} {_words(row)}"
        for tag, names, rows in (
            ("VERTEX2" if toro else "VERTEX_SE2", graph.ids[: graph.poses], poses),
            ("VERTEX_XY", graph.ids[graph.poses :], landmarks),
        )
        for name, row in zip(names.tolist(), rows.tolist(), strict=True)
    ]
    lines += _edge_lines(graph, toro)
    if graph.poses and not toro:
        lines.append(f"FIX {graph.ids[0]}")
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


def _edge_lines(graph: Graph, toro: bool) -> Iterator[str]:
    """Yield the line of each edge, in the order of the graph."""
    upper = {width: np.triu_indices(width) for width in (2, 3)}
    for (first, second), z, information in zip(
        graph.edges, graph.measurements, graph.information, strict=True
    ):
        tag, width = ("EDGE_SE2", 3) if graph.kinds[second] == POSE else ("EDGE_SE2_XY", 2)
        triangle = information[upper[width]]
        if toro:
            tag, triangle = "EDGE2", triangle[TO_TORO]
        values = np.concatenate([z[:width], triangle])
        yield f"{tag} {graph.ids[first]} {graph.ids[second]} {_words(values.tolist())}"


def _words(values: Sequence[float]) -> str:
    return " ".join(map(repr, values))


# --- lines ---


def _records(path: Path) -> dict[str, list[Record]]:
    """Read the lines of a file that are not empty, grouped by g2o's tags."""
    lines = text_of(path, LARGEST_GRAPH).splitlines()
    records: dict[str, list[Record]] = {tag: [] for tag in WIDTHS}
    unknown: Counter[str] = Counter()
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        tag = words[0]
        kind = TORO.get(tag, tag)
        if kind not in WIDTHS:
            unknown[tag] += 1
            if not _TAG.fullmatch(tag) or len(unknown) > MOST_UNKNOWN_TAGS:
                known = ", ".join([*WIDTHS, *TORO])
                raise ValueError(f"{path}, line {number}: the tag must be one of {known}, got {brief(tag)}")
            continue
        if tag == "FIX" and len(words) > 2:
            records[tag] += [_record(path, number, [name], []) for name in words[1:]]
            continue
        names, count = WIDTHS[kind]
        if len(words) != 1 + names + count:
            wanted = f"{names} {'vertex' if names == 1 else 'vertices'} and {count} numbers"
            raise ValueError(
                f"{path}, line {number}: {tag} needs {wanted}, {1 + names + count} words; got {len(words)}"
            )
        record = _record(path, number, words[1 : 1 + names], words[1 + names :])
        if tag == "EDGE2":
            triangle = [record.numbers[3 + place] for place in FROM_TORO]
            record = record._replace(numbers=[*record.numbers[:3], *triangle])
        records[kind].append(record)
    if unknown:
        left_out = ", ".join(f"{brief(tag)} ({say_count(times, 'line')})" for tag, times in unknown.items())
        warnings.warn(f"{path}: left out lines whose tags are not known: {left_out}", stacklevel=3)
    return records


def _warn_of_islands(path: Path, ends: Sequence[tuple[int, int]], ids: Sequence[int]) -> None:
    """Check that the edges connect all vertices, and warn otherwise, because no solver finds one solution then."""
    edges = np.array(ends, dtype=int).reshape(-1, 2)
    pairs = coo_array((np.ones(len(edges)), edges.T), shape=(len(ids), len(ids)))
    count, part = connected_components(pairs, directed=False)
    if count > 1:
        other = ids[int(np.argmax(part != part[0]))]
        warnings.warn(
            f"{path}: the edges do not connect all vertices: {count} parts, and vertices {ids[0]} and {other} are in "
            "different ones",
            stacklevel=3,
        )


def _record(path: Path, line: int, names: list[str], words: list[str]) -> Record:
    """Convert the words of a line to vertex names and values."""
    said = " ".join([*names, *words])
    try:
        if "_" in said:  # because Python would accept 1_000
            raise ValueError
        record = Record(line, [int(name) for name in names], [float(word) for word in words])
    except ValueError:
        raise ValueError(
            f"{path}, line {line}: expected integers for the vertices and numbers, got {brief(said)}"
        ) from None
    if not all(0 <= name < 2**63 for name in record.ids):
        raise ValueError(
            f"{path}, line {line}: the number of a vertex must be 0 to 2^63 - 1, got {brief(said)}"
        )
    return record


def _numbers(path: Path, records: Sequence[Record], width: int) -> FloatArray:
    """Return the values of records of one kind, shape (N, width), or raise an error if one is not finite."""
    values = np.array([record.numbers for record in records], dtype=float).reshape(-1, width)
    wrong = np.argwhere(~(np.abs(values) <= LARGEST_NUMBER))
    if len(wrong):
        row, column = wrong[0]
        where, value = f"{path}, line {records[row].line}", values[row, column]
        raise ValueError(
            f"{where}: expected numbers within +-{LARGEST_NUMBER:g}, got {value} as number {column + 1}"
        )
    return values


# --- vertices and edges ---


def _vertices_from_edges(path: Path, records: dict[str, list[Record]]) -> dict[str, list[Record]]:
    """Return VERTEX records for a file without them: poses and landmarks at the ends of chains of edges."""
    _numbers(path, records["EDGE_SE2"], 9)
    _numbers(path, records["EDGE_SE2_XY"], 5)
    leading: dict[int, list[tuple[int, int, Pose]]] = {record.ids[0]: [] for record in records["EDGE_SE2_XY"]}
    for line, (first, second), numbers in records["EDGE_SE2"]:
        motion = Pose(*numbers[:3])
        leading.setdefault(first, []).append((line, second, motion))
        leading.setdefault(second, []).append((line, first, motion.inverse()))
    if not leading:
        return {}
    fixed = [record.ids[0] for record in records["FIX"] if record.ids[0] in leading]
    start = fixed[0] if fixed else min(leading)
    poses, lines, queue = {start: Pose()}, {start: 1}, deque([start])
    while queue:
        current = queue.popleft()
        for line, name, motion in leading[current]:
            if name not in poses:
                poses[name], lines[name] = poses[current] @ motion, line
                queue.append(name)
    if unreachable := leading.keys() - poses.keys():
        raise ValueError(
            f"{path}: vertex {min(unreachable)} has no VERTEX line, and no chain of edges connects it with "
            f"vertex {start}"
        )
    landmarks: dict[int, Record] = {}
    for line, (first, second), numbers in records["EDGE_SE2_XY"]:
        place = poses[first].to_parent(numbers[:2])[0].tolist()
        landmarks.setdefault(second, Record(line, [second], place))
    return {
        "VERTEX_SE2": [
            Record(lines[name], [name], poses[name].as_array().tolist()) for name in sorted(poses)
        ],
        "VERTEX_XY": [landmarks[name] for name in sorted(landmarks.keys() - poses.keys())],
    }


def _vertices(path: Path, records: dict[str, list[Record]]) -> tuple[list[int], list[int], FloatArray]:
    """Return names, kinds and states of all vertices: first the pose of a FIX line, other poses, then landmarks."""
    poses, landmarks = list(records["VERTEX_SE2"]), records["VERTEX_XY"]
    if not poses:
        raise ValueError(f"{path}: a graph needs poses, but no line begins with VERTEX_SE2 or EDGE_SE2")
    seen: dict[int, int] = {}
    for record in sorted([*poses, *landmarks]):
        name = record.ids[0]
        if name in seen:
            raise ValueError(
                f"{path}, line {record.line}: vertex {name} is already defined in line {seen[name]}"
            )
        seen[name] = record.line
    row_of = {record.ids[0]: row for row, record in enumerate(poses)}
    for fixed in records["FIX"]:
        if fixed.ids[0] not in row_of:
            raise ValueError(f"{path}, line {fixed.line}: there is no pose {fixed.ids[0]}")
    held = list(dict.fromkeys(fixed.ids[0] for fixed in records["FIX"]))
    if held:
        poses.insert(0, poses.pop(row_of[held[0]]))
    if len(held) > 1:
        warnings.warn(
            f"{path}: FIX names {len(held)} poses; only the first one, {held[0]}, is held", stacklevel=4
        )
    states = np.concatenate([_numbers(path, poses, 3).ravel(), _numbers(path, landmarks, 2).ravel()])
    ids = [record.ids[0] for record in (*poses, *landmarks)]
    return ids, [POSE] * len(poses) + [LANDMARK] * len(landmarks), states


def _ends(
    path: Path, record: Record, kind: int, number_of: dict[int, int], kinds: Sequence[int]
) -> tuple[int, int]:
    """Return the indices of an edge's two ends, after checking that they have the kinds of the edge's tag."""
    first, second = record.ids
    for name, wanted in ((first, POSE), (second, kind)):
        number = number_of.get(name)
        if number is None:
            raise ValueError(f"{path}, line {record.line}: there is no vertex {name}")
        if kinds[number] != wanted:
            is_a, should = NAME_OF_KIND[kinds[number]], NAME_OF_KIND[wanted]
            raise ValueError(
                f"{path}, line {record.line}: vertex {name} must be a {should}, but it is a {is_a}"
            )
    if first == second:
        raise ValueError(f"{path}, line {record.line}: the edge connects vertex {first} with itself")
    return number_of[first], number_of[second]


def _information(path: Path, records: Sequence[Record], upper: FloatArray, width: int) -> FloatArray:
    """Return full information matrices (N, width, width) from the upper triangles in the file."""
    full = np.zeros((len(upper), width, width))
    rows, columns = np.triu_indices(width)
    full[:, rows, columns] = full[:, columns, rows] = upper
    for record, good in zip(records, positive_definite(full), strict=True):
        if not good:
            raise ValueError(
                f"{path}, line {record.line}: the information matrix is singular or not positive definite: "
                f"{' '.join(f'{value:g}' for value in record.numbers[width:])} (its upper triangle)"
            )
    return full


def positive_definite(matrices: FloatArray) -> npt.NDArray[np.bool_]:
    """Return for each symmetric matrix (N, n, n) whether it is positive definite and not nearly singular.

    The diagonals are scaled to 1 before, so the result does not depend on the units.
    """
    diagonal = np.diagonal(matrices, axis1=1, axis2=2)
    above = np.asarray((diagonal > 0).all(axis=1))
    scale = 1 / np.sqrt(np.where(above[:, None], diagonal, 1.0))
    scaled = matrices * scale[:, :, None] * scale[:, None, :]
    smallest = np.asarray(np.linalg.eigvalsh(scaled), dtype=float)[:, 0]
    return np.asarray(above & (smallest > LEAST_EIGENVALUE), dtype=bool)
