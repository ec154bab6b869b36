"""A pose graph in the plane: poses and landmarks, and what was measured between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.sparse
import scipy.sparse.linalg

from nao_course.exercises.codec import register
from nao_course.geometry import FloatArray

__all__ = ["LANDMARK", "POSE", "SYMMETRIC", "Edges", "Graph", "matrices"]

POSE, LANDMARK = 0, 1

# For `scipy.sparse.linalg.splu` of a symmetric, positive definite matrix: no pivots, one column after the other.
SYMMETRIC = {"diag_pivot_thresh": 0.0, "relax": 1, "panel_size": 1, "options": {"SymmetricMode": True}}

IntArray = npt.NDArray[np.int64]
Residual = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


class Edges(NamedTuple):
    """All edges of one kind, as arrays: row k of each belongs to edge k.

    Parameters
    ----------
    first, second : ndarray, shape (E,)
        Numbers of the two ends: `first` among the poses; `second` among the poses, or among the landmarks.
    z : ndarray, shape (E, 3) or (E, 2)
        What was measured in the frame of the first pose: a pose (x, y, theta) or a landmark's (x, y); m, rad.
    information : ndarray, shape (E, 3, 3) or (E, 2, 2)
        Inverse of the residual's covariance: of a pose in the frame in which z ends, as in g2o; of a landmark in
        the frame of the first pose.
    places : ndarray, shape (E, 6) or (E, 5)
        Where the numbers of both ends stand in the states: those of the first, then those of the second.
    """

    first: IntArray
    second: IntArray
    z: FloatArray
    information: FloatArray
    places: IntArray


@register
@dataclass(frozen=True, eq=False)
class Graph:
    """What was measured between poses, and between poses and landmarks.

    The unknowns are numbered: poses first, then landmarks. Their values are kept apart from the graph, in one flat
    array of `states`: x, y, theta of each pose, then x, y of each landmark; metres and radians.

    Parameters
    ----------
    edges : ndarray of int, shape (E, 2)
        Numbers of the two unknowns of each edge; the first is a pose.
    measurements : ndarray, shape (E, 3)
        The second unknown in the frame of the first: (x, y, theta) of a pose, (x, y, 0) of a landmark.
    information : ndarray, shape (E, 3, 3)
        Inverses of the residuals' covariances, of a pose in the frame in which the measurement ends (g2o's convention:
        a covariance in the frame of the first pose is turned by minus the measured angle first); a landmark's third row
        and column are 0.
    kinds : ndarray of int, shape (N,)
        `POSE` or `LANDMARK` for each unknown, poses first.
    ids : ndarray of int, shape (N,)
        What the unknowns are called in a file; their numbers, unless given.

    Raises
    ------
    ValueError
        If the shapes do not fit each other, landmarks stand before poses, or an edge names what is not there.

    Examples
    --------
    Two poses and a landmark: the second pose is a metre ahead, the landmark is to the left of it.

    >>> graph = Graph([[0, 1], [1, 2]], [[1, 0, 0], [0, 2, 0]], [np.eye(3), np.diag([4, 4, 0])], [POSE, POSE, LANDMARK])
    >>> poses, landmarks = graph.split(np.array([0, 0, 0, 1, 0, 0, 1, 2.0]))
    >>> landmarks.tolist()
    [[1.0, 2.0]]
    """

    edges: IntArray
    measurements: FloatArray
    information: FloatArray
    kinds: IntArray
    ids: IntArray = ()  # type: ignore[assignment]

    def __post_init__(self) -> None:
        """Check that everything fits."""
        kinds = np.array(self.kinds, dtype=np.int64).ravel()
        count = np.size(self.edges) // 2
        ids = np.arange(len(kinds)) if len(self.ids) == 0 else np.array(self.ids, dtype=np.int64)
        arrays = {
            "edges": (np.array(self.edges, dtype=np.int64).reshape(-1, 2), (count, 2)),
            "measurements": (_floats(self.measurements, (0, 3)), (count, 3)),
            "information": (_floats(self.information, (0, 3, 3)), (count, 3, 3)),
            "kinds": (kinds, (len(kinds),)),
            "ids": (ids, (len(kinds),)),
        }
        for name, (array, shape) in arrays.items():
            if array.shape != shape:
                raise ValueError(f"Graph: {name} must have shape {shape}, got {array.shape}")
            object.__setattr__(self, name, array)
        if not np.isin(kinds, (POSE, LANDMARK)).all() or (np.diff(kinds) < 0).any():
            raise ValueError("Graph: kinds must be POSE or LANDMARK, poses first")
        if count and not (self.edges.min() >= 0 and self.edges.max() < len(kinds)):
            raise ValueError(f"Graph: edges name unknowns 0 to {len(kinds) - 1}, got {self.edges.max()}")
        if count and (kinds[self.edges[:, 0]] == LANDMARK).any():
            raise ValueError("Graph: an edge begins at a pose")

    # --- sizes ---

    @cached_property
    def poses(self) -> int:
        """How many poses there are."""
        return int(np.count_nonzero(self.kinds == POSE))

    @cached_property
    def landmarks(self) -> int:
        """How many landmarks there are."""
        return len(self.kinds) - self.poses

    @cached_property
    def size(self) -> int:
        """How many numbers the states have."""
        return 3 * self.poses + 2 * self.landmarks

    # --- values ---

    def split(self, states: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Poses (P, 3) and landmarks (L, 2) of flat states (3 P + 2 L,)."""
        array = np.asarray(states, dtype=float)
        if array.shape != (self.size,):
            raise ValueError(
                f"states must have shape ({self.size},): {self.poses} poses and {self.landmarks} landmarks; "
                f"got {array.shape}"
            )
        return array[: 3 * self.poses].reshape(-1, 3), array[3 * self.poses :].reshape(-1, 2)

    # --- edges ---

    @cached_property
    def pose_edges(self) -> Edges:
        """The edges between two poses."""
        return self._of_kind(POSE, 3)

    @cached_property
    def landmark_edges(self) -> Edges:
        """The edges from a pose to a landmark; `second` counts landmarks from 0."""
        return self._of_kind(LANDMARK, 2)

    def _of_kind(self, kind: int, width: int) -> Edges:
        chosen = np.flatnonzero(self.kinds[self.edges[:, 1]] == kind)
        first, second = self.edges[chosen].T
        if kind == LANDMARK:
            second = second - self.poses
        begin = 3 * self.poses if kind == LANDMARK else 0
        places = np.hstack(
            [3 * first[:, None] + np.arange(3), begin + width * second[:, None] + np.arange(width)]
        )
        information = self.information[chosen][:, :width, :width]
        return Edges(first, second, self.measurements[chosen, :width], information, places)

    # --- sparse systems ---

    def add_blocks(self, pose_blocks: FloatArray, landmark_blocks: FloatArray) -> scipy.sparse.csc_array:
        """Add each edge's block into one large sparse matrix, at its `places`.

        The same as putting all entries with their rows and columns into a `scipy.sparse.coo_array` and turning that
        into a `csc_array`, but where each entry belongs is found once for a graph, and not again in each iteration.

        Parameters
        ----------
        pose_blocks : ndarray, shape (E, 6, 6)
            One for each of `pose_edges`.
        landmark_blocks : ndarray, shape (E', 5, 5)
            One for each of `landmark_edges`.

        Returns
        -------
        csc_array, shape (size, size)
        """
        indices, indptr, slots = self._sparsity
        entries = np.concatenate([np.ravel(pose_blocks), np.ravel(landmark_blocks)])
        sums = np.bincount(slots, entries, len(indices))
        return scipy.sparse.csc_array((sums, indices, indptr), shape=(self.size, self.size))

    @cached_property
    def _sparsity(self) -> tuple[IntArray, IntArray, IntArray]:
        """Rows and column starts of the sparse matrix, and for each entry of all blocks its place among the rows."""
        groups = [edges.places for edges in (self.pose_edges, self.landmark_edges)]
        rows = np.concatenate([np.repeat(places, places.shape[1], axis=1).ravel() for places in groups])
        columns = np.concatenate([np.tile(places, places.shape[1]).ravel() for places in groups])
        shape = (self.size, self.size)
        numbered = scipy.sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape).tocsc()
        numbered.data = np.arange(numbered.nnz)
        return numbered.indices, numbered.indptr, numbered[rows, columns]

    @cached_property
    def elimination_order(self) -> IntArray:
        """All states but the first pose's, in an order that keeps the factor of H sparse: (size - 3,).

        Minimum degree (lesson 08), over poses and landmarks as wholes: the three numbers of a pose have the same
        neighbours, so they stay together, and there is a third of the rows to put into order.
        """
        count = len(self.kinds)
        i, j = self.edges.T
        links = scipy.sparse.coo_array((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), (count, count))
        dominant = (links + scipy.sparse.diags_array(1 + links.sum(axis=0))).tocsc()[
            1:, 1:
        ]  # it has a factor
        factor = scipy.sparse.linalg.splu(dominant, "MMD_AT_PLUS_A", **SYMMETRIC)
        order = 1 + np.argsort(factor.perm_c)
        widths = np.where(self.kinds == POSE, 3, 2)
        begins = np.cumsum(widths) - widths
        widths, begins = widths[order], begins[order]
        return np.repeat(begins - (np.cumsum(widths) - widths), widths) + np.arange(self.size - 3)

    # --- errors ---

    def squared_errors(
        self, states: npt.ArrayLike, pose_residual: Residual, landmark_residual: Residual
    ) -> FloatArray:
        """Weighted squares e' Omega e of all edges, (E,), in the order of `edges`, by somebody's residuals."""
        poses, landmarks = self.split(states)
        squares = np.zeros(len(self.edges))
        to_landmark = self.kinds[self.edges[:, 1]] == LANDMARK
        for edges, ends, residual, chosen in (
            (self.pose_edges, poses, pose_residual, ~to_landmark),
            (self.landmark_edges, landmarks, landmark_residual, to_landmark),
        ):
            if len(edges.z):
                e = np.asarray(residual(poses[edges.first], ends[edges.second], edges.z))
                squares[chosen] = np.einsum("ki,kij,kj->k", e, edges.information, e)
        return squares


def matrices(rows: Sequence[Sequence[npt.ArrayLike]]) -> FloatArray:
    """Put numbers, or arrays of N numbers each, together to one matrix, or to N of them.

    Parameters
    ----------
    rows : sequence of rows
        R rows of C entries; each entry is a number or an array of shape (N,).

    Returns
    -------
    ndarray, shape (R, C) or (N, R, C)
        With arrays among the entries, matrix k has entry k of each of them; a number stands in all.

    Examples
    --------
    >>> matrices([[1, 0], [0, 1]]).shape
    (2, 2)
    >>> matrices([[np.array([1, 2, 3]), 0], [0, 1]])[2].tolist()
    [[3.0, 0.0], [0.0, 1.0]]
    """
    entries = np.broadcast_arrays(*[np.asarray(entry, dtype=float) for row in rows for entry in row])
    return np.stack(entries, axis=-1).reshape(*entries[0].shape, len(rows), len(rows[0]))


def _floats(values: npt.ArrayLike, empty: tuple[int, ...]) -> FloatArray:
    array = np.array(values, dtype=float)
    return array if array.size else np.empty(empty)


def __dir__() -> list[str]:
    """What tab completion shows: not what this module imports."""
    return __all__
