"""Pose graphs in the text formats of g2o, TORO, iSAM and GTSAM. A malformed file raises an error with the line.

Writing loses no precision. FIX is written last, because GTSAM 4.3 reads no edge below it. A new text format begins
with `FORMS` and `TAGS` in `graph_lines`; any other has a module of its own, such as `freiburg_graph`.
"""

from __future__ import annotations

import itertools
import warnings
from collections import deque
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.datasets.graph_lines import (
    FORMS,
    LARGEST_NUMBER,
    ORIGIN,
    Form,
    MeasuredEdges,
    Record,
    read_edges,
    read_records,
    values_of,
)
from nao_course.geometry import FloatArray, Pose, rotation_2d
from nao_course.graphs import LANDMARK, POSE, Graph

TO_TORO = [0, 1, 3, 5, 2, 4]  # places of TORO's order (11 12 22 33 13 23) in g2o's (11 12 13 22 23 33)
NAME_OF_KIND = {POSE: "pose", LANDMARK: "landmark"}
SAME_POSE = 1e-9  # m and rad


def read_g2o(path: Path | str, *, form: Form = "g2o") -> tuple[Graph, FloatArray]:
    """Read a pose graph in the plane from a file of g2o, TORO, iSAM or GTSAM.

    ``#`` starts a comment. Lines with tags that are not known are left out with a warning, and so are all FIX names but
    the first, because a `Graph` holds only its first pose. A warning also says if there are no edges, or if they do not
    connect all vertices. docs/real_data.md lists the tags.

    If a pose is fixed, a prior on another vertex becomes an edge from that pose, with the same chi2. If no pose is
    fixed, and there is only one prior, which agrees with its vertex, its pose is held. All other priors become edges
    from one extra pose at the origin, and a warning contains its name.

    Some published graphs, such as CSAIL and KITTI, have no VERTEX lines at all. The initial guess then follows the
    edges, breadth first, from the pose of the FIX line, of the first prior, or with the lowest id. That pose is at the
    origin unless it has a prior. In files of iSAM and GTSAM, landmarks alone may also have no VERTEX lines.

    Parameters
    ----------
    path : path
        Path of the file.
    form : "g2o", "toro", "isam" or "gtsam"
        Program whose format the file has. The tags distinguish files of g2o and TORO. In files of iSAM, the
        matrices of EDGE2, ODOMETRY and LANDMARK are square roots of information matrices. In files for GTSAM's
        `load2D` they are covariances, and BR lines have a bearing, a range and their standard deviations.

    Returns
    -------
    graph : Graph
        Poses, landmarks and edges in the order of the file, or by id if there are no VERTEX lines. The held pose comes
        first. `Graph.ids` contains the names of the vertices in the file.
    states : ndarray, shape (graph.size,)
        Initial guess of the file, or the guess that follows the edges; m and rad.

    Raises
    ------
    ValueError
        If the file is missing, empty or too large. If a line has a wrong number of values, a value that is not finite,
        an unknown or duplicate vertex, or a matrix that is not positive definite. If there are no VERTEX lines and the
        edges do not connect all poses. The message contains the file and the line.
    """
    if form not in FORMS:
        raise ValueError(f"read_g2o: form must be one of {', '.join(FORMS)}, got {form!r}")
    path = Path(path)
    records, left_out = read_records(path, form)
    edges, notes = read_edges(path, records, form)
    if form in ("isam", "gtsam"):
        edges, renamed = _with_own_landmark_names(path, records, edges)
        notes += renamed
    fixed, fixing = _fixed(records["FIX"])
    if not (records["VERTEX_SE2"] or records["VERTEX_XY"]):
        records |= _vertices_from_edges(path, edges, fixed)
    elif form in ("isam", "gtsam"):
        records["VERTEX_XY"] += _landmarks_from_edges(edges, records["VERTEX_SE2"], records["VERTEX_XY"])
    poses, landmarks = _vertices(path, records, fixed)
    edges, poses, holding = _with_priors_as_edges(edges, poses, landmarks, bool(fixed))
    ids = [record.ids[0] for record in (*poses, *landmarks)]
    kinds = [POSE] * len(poses) + [LANDMARK] * len(landmarks)
    ends = _ends(path, edges, ids, kinds)
    graph = Graph(ends, edges.z, edges.information, np.array(kinds), np.array(ids))
    states = np.concatenate([values_of(path, poses, 3).ravel(), values_of(path, landmarks, 2).ravel()])
    for note in (*left_out, *notes, *fixing, *holding, *parts_of(graph)):
        warnings.warn(f"{path}: {note}", stacklevel=2)
    return graph, states


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
        If a value could not be read again, because it is not finite or too large, or if a graph with landmarks is
        written for TORO.
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
        if not (np.abs(values) <= LARGEST_NUMBER).all():
            raise ValueError(
                f"{path}: not written, because the {name} contain numbers that are not finite or beyond "
                f"+-{LARGEST_NUMBER:g}"
            )
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


def parts_of(graph: Graph) -> list[str]:
    """Return a note if no solver can find one solution: there are no edges, or they do not connect all vertices."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not len(graph.edges):
        return ["there are no edges, so nothing is measured"]
    count = len(graph.ids)
    pairs = coo_array((np.ones(len(graph.edges)), graph.edges.T), shape=(count, count))
    number, part = connected_components(pairs, directed=False)
    if number == 1:
        return []
    other = graph.ids[int(np.argmax(part != part[0]))]
    return [
        f"the edges do not connect all vertices: {number} parts, and vertices {graph.ids[0]} and {other} are in "
        "different ones"
    ]


# --- vertices ---


def _fixed(records: Sequence[Record]) -> tuple[list[Record], list[str]]:
    """Return the records of FIX lines, each pose once, and a note if there are several."""
    first = dict[int, Record]()
    for record in records:
        first.setdefault(record.ids[0], record)
    fixed = list(first.values())
    if len(fixed) < 2:
        return fixed, []
    return fixed, [f"FIX names {len(fixed)} poses; only the first one, {fixed[0].ids[0]}, is held"]


def _with_own_landmark_names(
    path: Path, records: dict[str, list[Record]], edges: MeasuredEdges
) -> tuple[MeasuredEdges, list[str]]:
    """Rename the landmarks if some have the numbers of poses, because iSAM and GTSAM count them separately."""
    to_landmark = edges.kinds == LANDMARK
    poses = {record.ids[0] for record in records["VERTEX_SE2"]}
    poses |= {*edges.names[:, 0].tolist(), *edges.names[~to_landmark, 1].tolist()}
    landmarks = {record.ids[0] for record in records["VERTEX_XY"]} | {*edges.names[to_landmark, 1].tolist()}
    if poses.isdisjoint(landmarks):
        return edges, []
    shift = max(poses) + 1
    if max(landmarks) + shift >= 2**63:
        raise ValueError(
            f"{path}: landmarks have the numbers of poses, and the numbers are too large to change them"
        )
    records["VERTEX_XY"] = [record._replace(ids=[record.ids[0] + shift]) for record in records["VERTEX_XY"]]
    names = edges.names.copy()
    names[to_landmark, 1] += shift
    return edges._replace(names=names), [
        f"landmarks have the numbers of poses, so {shift} was added to theirs"
    ]


def _vertices_from_edges(
    path: Path, edges: MeasuredEdges, fixed: Sequence[Record]
) -> dict[str, list[Record]]:
    """Return VERTEX records for a file without them: poses and landmarks at the ends of chains of edges."""
    leading = dict[int, list[tuple[int, int, list[float], bool]]]()
    priors = dict[int, Pose]()
    for line, (first, second), kind, z in _rows(edges):
        if first == ORIGIN and kind == POSE:
            priors.setdefault(second, Pose(*z))
        elif first != ORIGIN:
            leading.setdefault(first, [])
            if kind == POSE:
                leading[first].append((line, second, z, True))
                leading.setdefault(second, []).append((line, first, z, False))
    if not leading:
        return {}
    begin = [name for name in (*(record.ids[0] for record in fixed), *priors) if name in leading]
    start = begin[0] if begin else min(leading)
    poses, lines = {start: Pose() if fixed else priors.get(start, Pose())}, {start: 1}
    queue = deque([start])
    while queue:
        current = queue.popleft()
        for line, name, z, ahead in leading[current]:
            if name not in poses:
                motion = Pose(*z) if ahead else Pose(*z).inverse()
                poses[name], lines[name] = poses[current] @ motion, line
                queue.append(name)
    if unreachable := leading.keys() - poses.keys():
        raise ValueError(
            f"{path}: vertex {min(unreachable)} has no VERTEX line, and no chain of edges connects it with "
            f"vertex {start}"
        )
    records = [Record(lines[name], [name], poses[name].as_array().tolist()) for name in sorted(poses)]
    return {"VERTEX_SE2": records, "VERTEX_XY": _landmarks_from_edges(edges, records, [])}


def _landmarks_from_edges(
    edges: MeasuredEdges, poses: Sequence[Record], landmarks: Sequence[Record]
) -> list[Record]:
    """Return VERTEX_XY records of landmarks without one, by name, each where its first measurement places it."""
    place_of = {record.ids[0]: record.numbers for record in poses} | {ORIGIN: [0.0, 0.0, 0.0]}
    known = {*place_of, *(record.ids[0] for record in landmarks)}
    found = dict[int, Record]()
    for line, (first, second), kind, z in _rows(edges):
        if kind == LANDMARK and second not in known and second not in found and first in place_of:
            place = Pose(*place_of[first]).to_parent(z[:2])[0].tolist()
            found[second] = Record(line, [second], place)
    return [found[name] for name in sorted(found)]


def _rows(edges: MeasuredEdges) -> Iterator[tuple[int, list[int], int, list[float]]]:
    """Yield line, names, kind and z of each edge."""
    return zip(
        edges.lines.tolist(), edges.names.tolist(), edges.kinds.tolist(), edges.z.tolist(), strict=True
    )


def _vertices(
    path: Path, records: dict[str, list[Record]], fixed: Sequence[Record]
) -> tuple[list[Record], list[Record]]:
    """Return the poses, of which the first one of a FIX line comes first, and the landmarks."""
    poses, landmarks = list(records["VERTEX_SE2"]), records["VERTEX_XY"]
    if not poses:
        raise ValueError(f"{path}: a graph needs poses, but no line begins with VERTEX_SE2 or EDGE_SE2")
    values_of(path, poses, 3)  # which refuses values that are not finite
    values_of(path, landmarks, 2)
    seen: dict[int, int] = {}
    for record in sorted([*poses, *landmarks]):
        name = record.ids[0]
        if name in seen:
            raise ValueError(
                f"{path}, line {record.line}: vertex {name} is already defined in line {seen[name]}"
            )
        seen[name] = record.line
    row_of = {record.ids[0]: row for row, record in enumerate(poses)}
    for each in fixed:
        if each.ids[0] not in row_of:
            raise ValueError(f"{path}, line {each.line}: there is no pose {each.ids[0]}")
    if fixed:
        poses.insert(0, poses.pop(row_of[fixed[0].ids[0]]))
    return poses, landmarks


# --- edges ---


def _with_priors_as_edges(
    edges: MeasuredEdges, poses: list[Record], landmarks: list[Record], fixed: bool
) -> tuple[MeasuredEdges, list[Record], list[str]]:
    """Return edges without priors, the poses with the held one first, and notes on what changed."""
    prior = edges.names[:, 0] == ORIGIN
    if not prior.any():
        return edges, poses, []
    if fixed:
        return _seen_from(poses[0], edges, prior), poses, _notes_on_held(poses[0], edges, prior)
    which = np.flatnonzero(prior)
    row_of = {record.ids[0]: row for row, record in enumerate(poses)}
    row = row_of.get(int(edges.names[which[0], 1]))
    if len(which) == 1 and row is not None and edges.kinds[which[0]] == POSE:
        error = Pose(*edges.z[which[0]]).inverse() @ Pose(*poses[row].numbers)
        if np.abs(error.as_array()).max() <= SAME_POSE:
            return _seen_from(poses[row], edges, prior), [poses[row], *poses[:row], *poses[row + 1 :]], []
    names = {record.ids[0] for record in (*poses, *landmarks)}
    extra = next(name for name in itertools.count() if name not in names)
    note = f"added pose {extra}, which is held at the origin, for {say_count(len(which), 'prior')}"
    held = Record(1, [extra], [0.0, 0.0, 0.0])
    return _seen_from(held, edges, prior), [held, *poses], [note]


def _seen_from(held: Record, edges: MeasuredEdges, prior: npt.NDArray[np.bool_]) -> MeasuredEdges:
    """Return edges in which priors are measured from the held pose; those on the held pose itself are left out."""
    name, pose = held.ids[0], Pose(*held.numbers)
    names, z, information = edges.names.copy(), edges.z.copy(), edges.information.copy()
    names[prior, 0] = name
    turn = np.eye(3)
    turn[:2, :2] = rotation_2d(-pose.theta)
    for number in np.flatnonzero(prior):
        if edges.kinds[number] == POSE:
            z[number] = (pose.inverse() @ Pose(*z[number])).as_array()
        else:
            z[number, :2] = pose.to_local(z[number, :2])[0]
            information[number] = turn @ information[number] @ turn.T
    kept = ~(prior & (names[:, 1] == name))
    return MeasuredEdges(edges.lines[kept], names[kept], edges.kinds[kept], z[kept], information[kept])


def _notes_on_held(held: Record, edges: MeasuredEdges, prior: npt.NDArray[np.bool_]) -> list[str]:
    """Return a note if there are priors on the held pose."""
    count = int(np.count_nonzero(prior & (edges.names[:, 1] == held.ids[0])))
    return [
        f"left out {say_count(count, 'prior')} of pose {held.ids[0]}, because FIX holds it where its vertex is"
    ] * bool(count)


def _ends(
    path: Path, edges: MeasuredEdges, ids: Sequence[int], kinds: Sequence[int]
) -> npt.NDArray[np.int64]:
    """Return the indices of both ends of each edge, after checking that they have the kinds of the edge's tag."""
    number_of = {name: number for number, name in enumerate(ids)}
    ends = list[tuple[int, int]]()
    for line, (first, second), kind, _ in _rows(edges):
        for name, wanted in ((first, POSE), (second, kind)):
            number = number_of.get(name)
            if number is None:
                raise ValueError(f"{path}, line {line}: there is no vertex {name}")
            if kinds[number] != wanted:
                is_a, should = NAME_OF_KIND[kinds[number]], NAME_OF_KIND[wanted]
                raise ValueError(f"{path}, line {line}: vertex {name} must be a {should}, but it is a {is_a}")
        if first == second:
            raise ValueError(f"{path}, line {line}: the edge connects vertex {first} with itself")
        ends.append((number_of[first], number_of[second]))
    return np.array(ends, dtype=np.int64).reshape(-1, 2)
