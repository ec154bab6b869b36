"""Pose graphs in g2o's text format: read whole or refused with file and line, and written so that nothing is lost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nao_course.datasets.files import brief, contents
from nao_course.geometry import FloatArray
from nao_course.graphs import LANDMARK, POSE, Graph

# What a file may not exceed: far beyond any real one, and small enough that a hostile one costs little.
LARGEST_GRAPH = 100_000_000  # bytes
LARGEST_NUMBER = 1e15
LEAST_PART = 1e-12  # the smallest eigenvalue of a usable information matrix whose diagonal is scaled to 1

# Tag: how many names of vertices, and how many numbers after them.
WIDTHS = {"VERTEX_SE2": (1, 3), "VERTEX_XY": (1, 2), "EDGE_SE2": (2, 9), "EDGE_SE2_XY": (2, 5), "FIX": (1, 0)}
KIND_OF_VERTEX = {"VERTEX_SE2": POSE, "VERTEX_XY": LANDMARK}
NAME_OF_KIND = {POSE: "pose", LANDMARK: "landmark"}
KIND_OF_END = {"EDGE_SE2": POSE, "EDGE_SE2_XY": LANDMARK}


class Record(NamedTuple):
    """One line: its number in the file, the vertices it names, and its numbers."""

    line: int
    ids: list[int]
    numbers: list[float]


def read_g2o(path: Path | str) -> tuple[Graph, FloatArray]:
    """Read a pose graph in the plane.

    The tags VERTEX_SE2, VERTEX_XY, EDGE_SE2, EDGE_SE2_XY and FIX are known; ``#`` begins a comment.

    Parameters
    ----------
    path : path
        The file.

    Returns
    -------
    graph : Graph
        Poses and landmarks in the file's order each, but a pose that FIX names stands first; edges in the file's order.
        `Graph.ids` are the names of the vertices in the file.
    states : ndarray, shape (graph.size,)
        The file's guess, in m and rad.

    Raises
    ------
    ValueError
        If the file is missing, empty or too large; if a line has an unknown tag, too few or too many numbers, one that
        is not finite, a vertex that is not there or stands there twice, or an information matrix that is not positive
        definite. It names file and line.
    """
    path = Path(path)
    records = _records(path)
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
    """Write a graph and its states; `read_g2o` gives both back, to the last bit.

    Parameters
    ----------
    graph : Graph
        What was measured.
    states : array_like, shape (graph.size,)
        A guess, or the optimum; m and rad.
    path : path
        The file; an older one is replaced.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        If a number is not finite, so that it could not be read again.
    """
    path = Path(path)
    poses, landmarks = graph.split(states)
    for name, values in (
        ("states", np.asarray(states)),
        ("edges", graph.measurements),
        ("edges", graph.information),
    ):
        if not np.isfinite(values).all():
            raise ValueError(f"{path}: not written, because the {name} hold numbers that are not finite")
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
    """Each edge, in the graph's order."""
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
    """Every line that says something, by its tag."""
    try:
        lines = contents(path, LARGEST_GRAPH).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: is not text ({error.reason} at byte {error.start})") from None
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
    """Turn the words of a line into numbers."""
    said = " ".join([*names, *words])
    try:
        if "_" in said:  # Python reads 1_000
            raise ValueError
        record = Record(line, [int(name) for name in names], [float(word) for word in words])
    except ValueError:
        raise ValueError(
            f"{path}, line {line}: expected whole numbers of vertices and numbers, got {brief(said)}"
        ) from None
    if not all(0 <= name < 2**63 for name in record.ids):
        raise ValueError(f"{path}, line {line}: a vertex has a number from 0 to 2^63 - 1, got {brief(said)}")
    return record


def _numbers(path: Path, records: Sequence[Record], width: int) -> FloatArray:
    """Return the numbers of lines of one kind, (N, width), all of them finite."""
    values = np.array([record.numbers for record in records], dtype=float).reshape(-1, width)
    wrong = np.argwhere(~(np.abs(values) <= LARGEST_NUMBER))
    if len(wrong):
        row, column = wrong[0]
        where, value = f"{path}, line {records[row].line}", values[row, column]
        raise ValueError(
            f"{where}: expected numbers within +-{LARGEST_NUMBER:g}, got {value} as number {column + 1}"
        )
    return values


# --- what the lines say ---


def _vertices(path: Path, records: dict[str, list[Record]]) -> tuple[list[int], list[int], FloatArray]:
    """Names, kinds and states of all vertices, poses first; of these the one that FIX names."""
    poses, landmarks = list(records["VERTEX_SE2"]), records["VERTEX_XY"]
    if not poses:
        raise ValueError(f"{path}: a graph has poses, but no line begins with VERTEX_SE2")
    seen: dict[int, int] = {}
    for record in sorted([*poses, *landmarks]):
        name = record.ids[0]
        if name in seen:
            raise ValueError(f"{path}, line {record.line}: vertex {name} stands in line {seen[name]} already")
        seen[name] = record.line
    for number, fixed in enumerate(records["FIX"]):
        at = [row for row, record in enumerate(poses) if record.ids == fixed.ids]
        if number or not at:
            problem = (
                "one pose is held, and FIX stands there twice"
                if number
                else f"there is no pose {fixed.ids[0]}"
            )
            raise ValueError(f"{path}, line {fixed.line}: {problem}")
        poses.insert(0, poses.pop(at[0]))
    states = np.concatenate([_numbers(path, poses, 3).ravel(), _numbers(path, landmarks, 2).ravel()])
    ids = [record.ids[0] for record in (*poses, *landmarks)]
    return ids, [POSE] * len(poses) + [LANDMARK] * len(landmarks), states


def _ends(
    path: Path, record: Record, kind: int, number_of: dict[int, int], kinds: Sequence[int]
) -> tuple[int, int]:
    """Return the numbers of an edge's two unknowns; the first is a pose, the second of the tag's kind."""
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
        raise ValueError(f"{path}, line {record.line}: the edge leads from vertex {first} to itself")
    return number_of[first], number_of[second]


def _information(path: Path, records: Sequence[Record], upper: FloatArray, width: int) -> FloatArray:
    """Fill up information matrices, (N, width, width), of which the file has the upper halves."""
    full = np.zeros((len(upper), width, width))
    rows, columns = np.triu_indices(width)
    full[:, rows, columns] = full[:, columns, rows] = upper
    for record, good in zip(records, positive_definite(full), strict=True):
        if not good:
            raise ValueError(
                f"{path}, line {record.line}: the information matrix is singular or not positive definite: "
                f"{' '.join(f'{value:g}' for value in record.numbers[width:])} (its upper half)"
            )
    return full


def positive_definite(matrices: FloatArray) -> npt.NDArray[np.bool_]:
    """Whether symmetric matrices (N, n, n) are positive definite, and not nearly singular, whatever their units."""
    diagonal = np.diagonal(matrices, axis1=1, axis2=2)
    above = np.asarray((diagonal > 0).all(axis=1))
    scale = 1 / np.sqrt(np.where(above[:, None], diagonal, 1.0))
    scaled = matrices * scale[:, :, None] * scale[:, None, :]
    smallest = np.asarray(np.linalg.eigvalsh(scaled), dtype=float)[:, 0]
    return np.asarray(above & (smallest > LEAST_PART), dtype=bool)
