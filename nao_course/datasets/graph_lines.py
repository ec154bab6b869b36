"""The lines of a pose graph's text file, and what the numbers of each edge mean in g2o, TORO, iSAM and GTSAM.

The matrix of an EDGE2 line is an information matrix in TORO, the square root of one in iSAM, and a covariance in
GTSAM's `load2D`, and nothing in the file says which. Its order is 11 12 22 33 13 23 in TORO and 11 12 13 22 23 33 in
iSAM; GTSAM accepts both orders of a diagonal matrix, and the places of the zeros tell them apart.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.datasets.files import brief, text_of
from nao_course.geometry import FloatArray, Pose, rotation_2d
from nao_course.graphs import LANDMARK, POSE, IntArray

# Limits far above any real file, but low enough that a malicious file cannot use much memory or time.
LARGEST_GRAPH = 100_000_000  # bytes
LARGEST_NUMBER = 1e15
LARGEST_WEIGHT = 1e30  # beyond any information that is accepted
LEAST_EIGENVALUE = 1e-12  # of a usable information matrix, after its diagonal has been scaled to 1

MOST_UNKNOWN_TAGS = 20  # of a file that may be a graph

Form = Literal["g2o", "toro", "isam", "gtsam"]
FORMS = ("g2o", "toro", "isam", "gtsam")


class Tag(NamedTuple):
    """How many words of each kind come after a tag."""

    vertices: int
    offsets: int
    numbers: int


TAGS = {
    "VERTEX_SE2": Tag(1, 0, 3),
    "VERTEX_XY": Tag(1, 0, 2),
    "EDGE_SE2": Tag(2, 0, 9),
    "EDGE_SE2_XY": Tag(2, 0, 5),
    "FIX": Tag(1, 0, 0),
    "EDGE_PRIOR_SE2": Tag(1, 0, 9),
    "EDGE_PRIOR_XY": Tag(1, 0, 5),
    "PARAMS_SE2OFFSET": Tag(0, 1, 3),
    "EDGE_SE2_OFFSET": Tag(2, 2, 9),
    "EDGE_SE2_POINTXY_OFFSET": Tag(2, 1, 5),
    "EDGE2": Tag(2, 0, 9),
    "LANDMARK": Tag(2, 0, 5),
    "BR": Tag(2, 0, 4),
}
# EDGE_SE2_PRIOR is RTAB-Map's spelling; g2o itself knows only EDGE_PRIOR_SE2.
OTHER_NAMES = {"VERTEX2": "VERTEX_SE2", "EDGE_SE2_PRIOR": "EDGE_PRIOR_SE2", "ODOMETRY": "EDGE2"}
KIND_OF_EDGE = {
    "EDGE_SE2": POSE,
    "EDGE_SE2_XY": LANDMARK,
    "EDGE_PRIOR_SE2": POSE,
    "EDGE_PRIOR_XY": LANDMARK,
    "EDGE_SE2_OFFSET": POSE,
    "EDGE_SE2_POINTXY_OFFSET": LANDMARK,
    "EDGE2": POSE,
    "LANDMARK": LANDMARK,
    "BR": LANDMARK,
}
READ_AS = {"ODOMETRY": ("isam", "gtsam"), "LANDMARK": ("isam", "gtsam"), "BR": ("gtsam",)}
LEFT_OUT = {
    "EDGE_BEARING_SE2_XY": "a bearing without a range does not measure a position",
    "EDGE_PRIOR_SE2_XY": "a prior of a position without a heading has no 3 x 3 information matrix of full rank",
}
# Places of g2o's upper triangle (11 12 13 22 23 33) in TORO's order (11 12 22 33 13 23).
FROM_TORO = [0, 1, 4, 2, 5, 3]
ORIGIN = -1  # first end of a prior
_TAG = re.compile(r"[A-Za-z][A-Za-z0-9_:]{0,60}")


class Record(NamedTuple):
    """A line of a file: its line number, the names of its vertices and offsets, and its values."""

    line: int
    ids: list[int]
    numbers: list[float]


class MeasuredEdges(NamedTuple):
    """Edges in the order of their lines: names of both ends (E, 2), kinds of the second ends, z and information.

    The first end of a prior is `ORIGIN`. The arrays z (E, 3) and information (E, 3, 3) are as in `Graph`.
    """

    lines: IntArray
    names: IntArray
    kinds: IntArray
    z: FloatArray
    information: FloatArray


# --- lines ---


def read_records(path: Path, form: Form) -> tuple[dict[str, list[Record]], list[str]]:
    """Return the lines that are not empty, grouped by their tags, and notes on the lines that are left out."""
    records: dict[str, list[Record]] = {tag: [] for tag in TAGS}
    others: Counter[str] = Counter()
    for number, line in enumerate(text_of(path, LARGEST_GRAPH).splitlines(), start=1):
        words = line.partition("#")[0].split()
        if not words:
            continue
        tag = words[0]
        kind = OTHER_NAMES.get(tag, tag)
        if kind not in TAGS:
            others[tag] += 1
            if not _TAG.fullmatch(tag) or len(others) > MOST_UNKNOWN_TAGS:
                known = ", ".join([*TAGS, *OTHER_NAMES])
                raise ValueError(f"{path}, line {number}: the tag must be one of {known}, got {brief(tag)}")
            continue
        if form not in READ_AS.get(tag, FORMS):
            calls = " or ".join(f"form={each!r}" for each in READ_AS[tag])
            raise ValueError(
                f"{path}, line {number}: {tag} is not a tag of g2o or TORO, and its meaning depends on the "
                f"program that wrote it; read the file with {calls}"
            )
        if tag == "FIX" and len(words) > 2:
            records[tag] += [_record(path, number, [name], []) for name in words[1:]]
            continue
        wanted = TAGS[kind]
        integers = wanted.vertices + wanted.offsets
        if len(words) != 1 + integers + wanted.numbers:
            parts = [f"{wanted.vertices} {'vertex' if wanted.vertices == 1 else 'vertices'}"] * (
                wanted.vertices > 0
            )
            parts += [say_count(wanted.offsets, "offset")] * (wanted.offsets > 0)
            raise ValueError(
                f"{path}, line {number}: {tag} needs {', '.join(parts)} and {wanted.numbers} numbers, "
                f"{1 + integers + wanted.numbers} words; got {len(words)}"
            )
        records[kind].append(_record(path, number, words[1 : 1 + integers], words[1 + integers :]))
    return records, list(_notes(others))


def _notes(others: Counter[str]) -> list[str]:
    """Say how many lines of each tag are left out, and why."""
    notes = [
        f"left out {say_count(others[tag], 'line')} with {tag}, because {why}"
        for tag, why in LEFT_OUT.items()
        if tag in others
    ]
    unknown = [
        f"{brief(tag)} ({say_count(times, 'line')})" for tag, times in others.items() if tag not in LEFT_OUT
    ]
    return notes + [f"left out lines whose tags are not known: {', '.join(unknown)}"] * bool(unknown)


def _record(path: Path, line: int, names: list[str], words: list[str]) -> Record:
    """Convert the words of a line to names and values."""
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


def values_of(path: Path, records: Sequence[Record], width: int) -> FloatArray:
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


# --- edges ---


def read_edges(path: Path, records: dict[str, list[Record]], form: Form) -> tuple[MeasuredEdges, list[str]]:
    """Return all edges and priors, with information matrices in g2o's convention, and notes on them."""
    offsets = _offsets(path, records["PARAMS_SE2OFFSET"])
    ends, parts = list[tuple[int, int, int, int]](), list[tuple[FloatArray, FloatArray]]()
    for tag, kind in KIND_OF_EDGE.items():
        rows = records[tag]
        values = values_of(path, rows, TAGS[tag].numbers)
        width = 3 if kind == POSE else 2
        z, information = np.zeros((len(rows), 3)), np.zeros((len(rows), 3, 3))
        if tag == "BR":
            z[:, :2], information[:, :2, :2] = _positions(path, rows, values)
        else:
            z[:, :width] = values[:, :width]
            information[:, :width, :width] = _information(path, rows, values[:, width:], tag, form)
        if TAGS[tag].offsets and tag in KIND_OF_EDGE:
            _apply_offsets(path, rows, offsets, z, information)
        parts.append((z, information))
        ends += [
            (row.line, *(row.ids[:2] if TAGS[tag].vertices == 2 else (ORIGIN, row.ids[0])), kind)
            for row in rows
        ]
    table = np.array(ends, dtype=np.int64).reshape(-1, 4)
    order = np.argsort(table[:, 0], kind="stable")
    z, information = (np.concatenate(arrays)[order] for arrays in zip(*parts, strict=True))
    lines, first, second, kinds = table[order].T
    wrong = ~(np.abs(information) <= LARGEST_NUMBER).all(axis=(1, 2))
    if wrong.any():
        where = f"{path}, line {lines[np.argmax(wrong)]}"
        raise ValueError(f"{where}: expected an information matrix within +-{LARGEST_NUMBER:g}")
    notes = []
    turned = [row for row in records["EDGE_SE2_POINTXY_OFFSET"] if offsets[row.ids[2]] != Pose()]
    if turned:
        notes.append(
            f"applied the offsets of {say_count(len(turned), 'line')} with EDGE_SE2_POINTXY_OFFSET; g2o leaves them "
            "out of the errors of these edges, so its chi2 is another one"
        )
    return MeasuredEdges(lines, np.column_stack([first, second]), kinds, z, information), notes


def _information(path: Path, rows: Sequence[Record], upper: FloatArray, tag: str, form: Form) -> FloatArray:
    """Return information matrices (N, n, n) from the upper triangles that a program writes after a tag."""
    meaning = (
        {"isam": "square root", "gtsam": "covariance"}.get(form) if tag in ("EDGE2", "LANDMARK") else None
    )
    size = 2 if upper.shape[1] == 3 else 3
    hint = ""
    if tag == "EDGE2" and meaning is None:
        upper = upper[:, FROM_TORO]
        hint = "; it was read in TORO's order, and files of iSAM or GTSAM need form='isam' or form='gtsam'"
    elif tag == "EDGE2" and meaning == "covariance":
        upper = _in_one_order(path, rows, upper)
    above = np.zeros((len(upper), size, size))
    above[:, *np.triu_indices(size)] = upper
    full = above + np.triu(above, 1).mT
    if meaning == "square root":
        full = above.mT @ above
    what = "covariance" if meaning == "covariance" else "information"
    for row, good in zip(rows, positive_definite(full), strict=True):
        if not good:
            raise ValueError(
                f"{path}, line {row.line}: the {what} matrix is singular or not positive definite: "
                f"{' '.join(f'{value:g}' for value in row.numbers[size:])} (its upper triangle){hint}"
            )
    if meaning == "covariance":
        with np.errstate(over="ignore"):
            inverse = np.asarray(np.linalg.inv(full), dtype=float)
        full = (inverse + inverse.mT) / 2
    return full


def _in_one_order(path: Path, rows: Sequence[Record], upper: FloatArray) -> FloatArray:
    """Return diagonal covariances in g2o's order; the places of the zeros tell both orders apart, as in `load2D`."""
    there = upper != 0
    toro = (there == [True, False, True, True, False, False]).all(axis=1)
    g2o = (there == [True, False, False, True, False, True]).all(axis=1)
    for row, known in zip(rows, toro | g2o, strict=True):
        if not known:
            raise ValueError(
                f"{path}, line {row.line}: GTSAM's load2D reads only diagonal covariances, a 0 b c 0 0 or a 0 0 b 0 c; "
                f"got {' '.join(f'{value:g}' for value in row.numbers[3:])}"
            )
    return np.where(toro[:, None], upper[:, FROM_TORO], upper)


def _positions(path: Path, rows: Sequence[Record], values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return positions (N, 2) and information (N, 2, 2) of bearings and ranges with their standard deviations.

    The information is linearised at the measurement. It is diagonal along and across the direction of the bearing.
    """
    for row, (_, *lengths) in zip(rows, values, strict=True):
        if min(lengths) <= 0:
            raise ValueError(
                f"{path}, line {row.line}: the range and both standard deviations of BR must be positive, got "
                f"{' '.join(f'{value:g}' for value in lengths)}"
            )
    bearing, distance, sigma, along = values.T
    cosine, sine = np.cos(bearing), np.sin(bearing)
    turn = np.array([[cosine, -sine], [sine, cosine]]).transpose(2, 0, 1)
    with np.errstate(divide="ignore", over="ignore"):  # too large a weight is refused with all other matrices
        weights = np.minimum(1 / np.column_stack([along, distance * sigma]) ** 2, LARGEST_WEIGHT)
    return distance[:, None] * turn[:, :, 0], (turn * weights[:, None]) @ turn.mT


def _offsets(path: Path, records: Sequence[Record]) -> dict[int, Pose]:
    """Return the pose of each sensor in the frame of the robot, by its name."""
    offsets = dict[int, Pose]()
    for record, values in zip(records, values_of(path, records, 3).tolist(), strict=True):
        if record.ids[0] in offsets:
            raise ValueError(f"{path}, line {record.line}: offset {record.ids[0]} is defined twice")
        offsets[record.ids[0]] = Pose(*values)
    return offsets


def _apply_offsets(
    path: Path, rows: Sequence[Record], offsets: dict[int, Pose], z: FloatArray, information: FloatArray
) -> None:
    """Change measurements between sensors, in place, to measurements between the robot's poses, or to a landmark.

    The residual of an edge whose second sensor is not at the centre of its robot is right to first order in its angle.
    """
    for number, row in enumerate(rows):
        for name in row.ids[2:]:
            if name not in offsets:
                raise ValueError(f"{path}, line {row.line}: there is no PARAMS_SE2OFFSET {name}")
        first, *second = (offsets[name] for name in row.ids[2:])
        if second:
            z[number] = (first @ Pose(*z[number]) @ second[0].inverse()).as_array()
            back = np.eye(3)
            back[:2, :2] = rotation_2d(second[0].theta)
            back[:2, 2] = second[0].y, -second[0].x
            back = np.asarray(np.linalg.inv(back), dtype=float)
        else:
            z[number, :2] = first.to_parent(z[number, :2])[0]
            back = np.eye(3)
            back[:2, :2] = rotation_2d(-first.theta)
        information[number] = back.T @ information[number] @ back


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
