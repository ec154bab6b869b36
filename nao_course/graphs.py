"""Pose graphs in the plane: poses, landmarks, and the measurements between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy.sparse
import scipy.sparse.linalg
import scipy.special

from nao_course._internal.lazy_names import list_public
from nao_course.codec import register
from nao_course.geometry import FloatArray

__all__ = ["LANDMARK", "POSE", "SYMMETRIC", "Edges", "Graph", "matrices"]
__dir__ = list_public(__name__)

POSE, LANDMARK = 0, 1

# Options of `scipy.sparse.linalg.splu` for a symmetric, positive definite matrix, which needs no pivoting.
SYMMETRIC = {"diag_pivot_thresh": 0.0, "relax": 1, "panel_size": 1, "options": {"SymmetricMode": True}}

# chi2 per degree of freedom that may come from wrong matrices: below LEAST_FIT or above its inverse, and not by chance.
LEAST_FIT = 0.25
LEAST_CHANCE = 1e-6

IntArray = npt.NDArray[np.int64]
Residual = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]


class Edges(NamedTuple):
    """All edges of one kind as arrays, in which row k belongs to edge k.

    Parameters
    ----------
    first, second : ndarray, shape (E,)
        Indices of the two ends: `first` counts the poses, `second` the poses or the landmarks.
    z : ndarray, shape (E, 3) or (E, 2)
        Measured pose (x, y, theta) or position (x, y) of the second end in the frame of the first one; m and rad.
    information : ndarray, shape (E, 3, 3) or (E, 2, 2)
        Inverse of the covariance of each residual. For a pose it is given in the frame in which z ends, as in g2o; for
        a landmark in the frame of the first pose.
    places : ndarray, shape (E, 6) or (E, 5)
        Indices of both ends' values in the states: the values of `first`, then the values of `second`.
    """

    first: IntArray
    second: IntArray
    z: FloatArray
    information: FloatArray
    places: IntArray


@register
@dataclass(frozen=True, eq=False)
class Graph:
    """Measurements between poses, and between poses and landmarks.

    The unknowns are numbered, poses before landmarks. The graph does not contain their values. These are kept in a flat
    array of `states`: x, y, theta of each pose, then x, y of each landmark; m and rad.

    Parameters
    ----------
    edges : ndarray of int, shape (E, 2)
        Indices of the two unknowns of each edge; the first one is a pose.
    measurements : ndarray, shape (E, 3)
        Second unknown in the frame of the first one: (x, y, theta) of a pose, (x, y, 0) of a landmark.
    information : ndarray, shape (E, 3, 3)
        Inverses of the residuals' covariances. For a pose it is given in the frame in which the measurement ends, which
        is g2o's convention: a covariance in the frame of the first pose must first be turned by minus the measured
        angle. The third row and column of a landmark are 0.
    kinds : ndarray of int, shape (N,)
        `POSE` or `LANDMARK` for each unknown, poses first.
    ids : ndarray of int, shape (N,)
        Numbers of the unknowns in a file; by default their indices.

    Raises
    ------
    ValueError
        If the shapes do not fit each other, if landmarks come before poses, or if an edge has an unknown index.

    Examples
    --------
    A graph of two poses and a landmark. The second pose is a metre ahead, and the landmark is to its left.

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
        """Check the shapes and indices."""
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
            raise ValueError(
                f"Graph: the indices of edges must be 0 to {len(kinds) - 1}, got {self.edges.max()}"
            )
        if count and (kinds[self.edges[:, 0]] == LANDMARK).any():
            raise ValueError("Graph: the first end of an edge must be a pose, got a landmark")

    # --- sizes ---

    @cached_property
    def poses(self) -> int:
        """Number of poses."""
        return int(np.count_nonzero(self.kinds == POSE))

    @cached_property
    def landmarks(self) -> int:
        """Number of landmarks."""
        return len(self.kinds) - self.poses

    @cached_property
    def size(self) -> int:
        """Length of the states."""
        return 3 * self.poses + 2 * self.landmarks

    @cached_property
    def degrees_of_freedom(self) -> int:
        """Number of measured values minus the number of free states, which are all states but the first pose's.

        If the information matrices are right, the smallest chi2 divided by this number is near 1; `chi2_hint` says what
        may be wrong if it is not.
        """
        measured = 3 * len(self.pose_edges.z) + 2 * len(self.landmark_edges.z)
        return measured - max(self.size - 3, 0)

    def chi2_hint(self, chi2: float) -> str:
        """Return what may be wrong with a graph whose smallest chi2 does not fit its degrees of freedom.

        Parameters
        ----------
        chi2 : float
            Sum of the squared errors at the optimum.

        Returns
        -------
        str
            A sentence if chi2 per degree of freedom is less than 1/4 or more than 4, and such a value has a
            probability of at most one in a million. Otherwise an empty text.

        Examples
        --------
        >>> graph = Graph([[0, 1]] * 51, np.zeros((51, 3)), [np.eye(3)] * 51, [POSE, POSE])
        >>> graph.degrees_of_freedom, graph.chi2_hint(150.0), graph.chi2_hint(15.0)[:66]
        (150, '', 'chi2 is 0.1 per degree of freedom, but about 1 is expected. Are th')
        """
        freedom = self.degrees_of_freedom
        if freedom <= 0 or chi2 <= 0:
            return ""
        quotient = chi2 / freedom
        chance = min(scipy.special.chdtr(freedom, chi2), scipy.special.chdtrc(freedom, chi2))
        if LEAST_FIT <= quotient <= 1 / LEAST_FIT or chance > LEAST_CHANCE:
            return ""
        factor = max(quotient, 1 / quotient) ** 0.5
        others = "" if quotient < 1 else ", some edges are false, or this is not the optimum"
        return (
            f"chi2 is {quotient:.2g} per degree of freedom, but about 1 is expected. Are the matrices covariances, or "
            "square roots of information matrices, in place of information matrices? If not, the standard deviations "
            f"are about {factor:.2g} times too {'large' if quotient < 1 else 'small'}{others}."
        )

    # --- values ---

    def split(self, states: npt.ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Split flat states (3 P + 2 L,) into poses (P, 3) and landmarks (L, 2)."""
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
        """Edges between two poses."""
        return self._of_kind(POSE, 3)

    @cached_property
    def landmark_edges(self) -> Edges:
        """Edges from a pose to a landmark; `second` counts the landmarks from 0."""
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
        """Add the block of each edge to one large sparse matrix, at the rows and columns of its `places`.

        The result equals a `scipy.sparse.coo_array` of all entries that is converted to a `csc_array`. This method
        is faster, because the position of each entry is found only once for a graph, not in each iteration.

        Parameters
        ----------
        pose_blocks : ndarray, shape (E, 6, 6)
            Blocks of `pose_edges`.
        landmark_blocks : ndarray, shape (E', 5, 5)
            Blocks of `landmark_edges`.

        Returns
        -------
        csc_array, shape (size, size)
            Sum of all blocks.
        """
        indices, indptr, slots = self._sparsity
        entries = np.concatenate([np.ravel(pose_blocks), np.ravel(landmark_blocks)])
        sums = np.bincount(slots, entries, len(indices))
        return scipy.sparse.csc_array((sums, indices, indptr), shape=(self.size, self.size))

    @cached_property
    def _sparsity(self) -> tuple[IntArray, IntArray, IntArray]:
        """Row indices and column starts of the sparse matrix, and the position of each block entry in its data."""
        groups = [edges.places for edges in (self.pose_edges, self.landmark_edges)]
        rows = np.concatenate([np.repeat(places, places.shape[1], axis=1).ravel() for places in groups])
        columns = np.concatenate([np.tile(places, places.shape[1]).ravel() for places in groups])
        shape = (self.size, self.size)
        numbered = scipy.sparse.coo_array((np.ones(len(rows)), (rows, columns)), shape).tocsc()
        numbered.data = np.arange(numbered.nnz)
        return numbered.indices, numbered.indptr, numbered[rows, columns]

    @cached_property
    def elimination_order(self) -> IntArray:
        """Order of all states but the first pose's that keeps the factor of H sparse, shape (size - 3,).

        It is the minimum-degree order (lesson 08) of whole poses and landmarks. The three values of a pose have
        the same neighbours, so they can stay together, and only a third of the rows must be ordered.
        """
        count = len(self.kinds)
        i, j = self.edges.T
        links = scipy.sparse.coo_array((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), (count, count))
        # A diagonally dominant matrix with the same sparsity can be factorised, whatever the measurements are.
        dominant = (links + scipy.sparse.diags_array(1 + links.sum(axis=0))).tocsc()[1:, 1:]
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
        """Return the weighted squared errors e' Omega e of all edges, (E,), in the order of `edges`.

        Parameters
        ----------
        states : array_like, shape (size,)
            Poses and landmarks, m and rad.
        pose_residual, landmark_residual : callable
            Functions from first ends (E, 3), second ends and measurements z of some edges to their residuals.
        """
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
    """Make a matrix from numbers, or a stack of N matrices from arrays of N numbers.

    Parameters
    ----------
    rows : sequence of rows
        R rows of C entries; each entry is a number or an array of shape (N,).

    Returns
    -------
    ndarray, shape (R, C) or (N, R, C)
        Matrix, or a stack in which matrix k contains element k of each array. Numbers are the same in all matrices.

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
