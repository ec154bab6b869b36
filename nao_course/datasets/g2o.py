"""Pose graphs in g2o's text format. A malformed file raises an error with the line; writing loses no precision."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nao_course.datasets.files import brief, text_of
from nao_course.geometry import FloatArray, Pose
from nao_course.graphs import LANDMARK, POSE, Graph

# Limits far above any real file, but low enough that a malicious file cannot use much memory or time.
LARGEST_GRAPH = 100_000_000  # bytes
LARGEST_NUMBER = 1e15
LEAST_EIGENVALUE = 1e-12  # of a usable information matrix, after its diagonal has been scaled to 1

# For each tag, the number of vertex names, and the number of values after them.
WIDTHS = {"VERTEX_SE2": (1, 3), "VERTEX_XY": (1, 2), "EDGE_SE2": (2, 9), "EDGE_SE2_XY": (2, 5), "FIX": (1, 0)}
KIND_OF_VERTEX = {"VERTEX_SE2": POSE, "VERTEX_XY": LANDMARK}
NAME_OF_KIND = {POSE: "pose", LANDMARK: "landmark"}
KIND_OF_END = {"EDGE_SE2": POSE, "EDGE_SE2_XY": LANDMARK}


class Record(NamedTuple):
    """A line of a file: its line number, the names of its vertices, and its values."""

    line: int
    ids: list[int]
    numbers: list[float]


def read_g2o(path: Path | str) -> tuple[Graph, FloatArray]:
    """Read a pose graph in the plane from a g2o file.

    The tags VERTEX_SE2, VERTEX_XY, EDGE_SE2, EDGE_SE2_XY and FIX are known, and ``#`` starts a comment.

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
        If the file is missing, empty or too large. If a line has an unknown tag, a wrong number of values, a value that
        is not finite, an unknown or duplicate vertex, or an information matrix that is not positive definite. If there
        are no VERTEX lines and the edges do not connect all poses. The message contains the file and the line.
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
    return Graph(np.array(ends, dtype=int), measurements, information, np.array(kinds), np.array(ids)), states


def write_g2o(graph: Graph, states: npt.ArrayLike, path: Path | str) -> Path:
    """Write a graph and its states to a g2o file, from which `read_g2o` restores both to the last bit.

    Parameters
    ----------
    graph : Graph
        Graph of measurements.
    states : array_like, shape (graph.size,)
        Initial guess or optimum, m and rad.
    path : path
        Path of the file, which is overwritten if it exists.

    Returns
    -------
    Path
        Path of the file.

    Raises
    ------
    ValueError
        If a value is not finite, because it could not be read again.
    """
    path = Path(path)
    poses, landmarks = graph.split(states)
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
            ("VERTEX_SE2", graph.ids[: graph.poses], poses),
            ("VERTEX_XY", graph.ids[graph.poses :], landmarks),
        )
        for name, row in zip(names.tolist(), rows.tolist(), strict=True)
    ]
    if graph.poses:
        lines.append(f"FIX {graph.ids[0]}")
    lines += _edge_lines(graph)
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


def _edge_lines(graph: Graph) -> Iterator[str]:
    """Yield the line of each edge, in the order of the graph."""
    upper = {width: np.triu_indices(width) for width in (2, 3)}
    for (first, second), z, information in zip(
        graph.edges, graph.measurements, graph.information, strict=True
    ):
        tag, width = ("EDGE_SE2", 3) if graph.kinds[second] == POSE else ("EDGE_SE2_XY", 2)
        values = np.concatenate([z[:width], information[upper[width]]])
        yield f"{tag} {graph.ids[first]} {graph.ids[second]} {_words(values.tolist())}"


def _words(values: Sequence[float]) -> str:
    return " ".join(map(repr, values))


# --- lines ---


def _records(path: Path) -> dict[str, list[Record]]:
    """Read the lines of a file that are not empty, grouped by tag."""
    lines = text_of(path, LARGEST_GRAPH).splitlines()
    records: dict[str, list[Record]] = {tag: [] for tag in WIDTHS}
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        tag = words[0]
        if tag not in WIDTHS:
            raise ValueError(
                f"{path}, line {number}: the tag must be one of {', '.join(WIDTHS)}, got {brief(tag)}"
            )
        names, count = WIDTHS[tag]
        if len(words) != 1 + names + count:
            wanted = f"{names} {'vertex' if names == 1 else 'vertices'} and {count} numbers"
            raise ValueError(
                f"{path}, line {number}: {tag} needs {wanted}, {1 + names + count} words; got {len(words)}"
            )
        records[tag].append(_record(path, number, words[1 : 1 + names], words[1 + names :]))
    return records


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
    for number, fixed in enumerate(records["FIX"]):
        at = [row for row, record in enumerate(poses) if record.ids == fixed.ids]
        if number or not at:
            problem = "FIX may appear only once" if number else f"there is no pose {fixed.ids[0]}"
            raise ValueError(f"{path}, line {fixed.line}: {problem}")
        poses.insert(0, poses.pop(at[0]))
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
