"""Pairs of notebooks that share more code than the release and the known right answers explain.

The engine's filter (copydetect) replaces the names of variables, functions and classes and the texts of strings by a
letter each, and drops comments and white space. Every run of LENGTH characters of the rest is a fingerprint. The work
for a class grows with the length of its code and with the number of pairs, and never with the number of cells: what a
pair shares is found by its fingerprints, and passages are located only for the pairs that are shown.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from copydetect.utils import filter_code
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.sparse import csr_array
from scipy.spatial.distance import squareform

LENGTH = 20  # characters of a fingerprint
# A pair is listed from these values on; `python -m benchmarks similar` measures what they find and miss.
LEAST_SHARE, LEAST_SHARED = 0.3, 30
# A fingerprint of more notebooks than this is common, as in MOSS; notebooks with equal fingerprints count as one.
COMMON, COMMON_SHARE = 10, 0.1
LONGEST = 100_000  # characters of a notebook's own code that are compared
MOST_SHOWN = 100  # pairs of a lesson whose passages are located
# A comma that only a formatter adds. A space in its place keeps all positions.
_LAST_COMMA = re.compile(r",(?=(?:\s|#[^\n]*+)*+[)\]}])")
_BETWEEN = "\n\n"  # cells, where the code is shown

Passages = list[tuple[int, int]]


@dataclass(frozen=True)
class Work:
    """A student's own code in a lesson, by cell or file: fingerprints do not reach from one into the next."""

    student: str
    cells: tuple[str, ...]

    @property
    def code(self) -> str:
        """All of it."""
        return "".join(f"{cell}{_BETWEEN}" for cell in self.cells)


@dataclass(frozen=True)
class SimilarPair:
    """Two students, in the order of their names, whose own code is similar.

    `shares` are the shares, 0 to 1, of each one's fingerprints that the other has too, and `shared` is the number of
    the fingerprints that both have. `passages` are, for each, start and end of the common passages in its `code`, empty
    after the first MOST_SHOWN pairs. `group` is the number of students in the group of the two, whose notebooks are
    similar to each other on average.
    """

    first: Work
    second: Work
    shares: tuple[float, float]
    shared: int
    passages: tuple[Passages, Passages] = ((), ())  # type: ignore[assignment]
    group: int = 2


@dataclass(frozen=True)
class CommonCode:
    """Notebooks, in the order of their names, that consist to a large part of the same common code.

    `shares` are the shares, 0 to 1, of each one's fingerprints that are common; `passages` are start and end of the
    common passages in the `code` of the first one.
    """

    works: tuple[Work, ...]
    shares: tuple[float, ...]
    passages: Passages


@dataclass(frozen=True)
class Comparison:
    """The similarities among the notebooks of a lesson: pairs, the most similar first, and common code.

    The common code in `common`, the largest group first, was removed before the pairs were compared.
    """

    compared: int
    pairs: Sequence[SimilarPair] = ()
    common: Sequence[CommonCode] = ()


@dataclass(frozen=True)
class _Prints:
    """The fingerprints of a work, with start and end of each in its `code`."""

    hashes: np.ndarray
    starts: np.ndarray
    ends: np.ndarray

    def having(self, some: np.ndarray, *, kept: bool = True) -> _Prints:
        """Return the fingerprints that are in some others, or all that are not."""
        chosen = np.isin(self.hashes, some, invert=not kept)
        return _Prints(self.hashes[chosen], self.starts[chosen], self.ends[chosen])

    @property
    def different(self) -> np.ndarray:
        """The fingerprints once each, in ascending order."""
        return np.unique(self.hashes)

    def passages(self) -> Passages:
        """Return the places of the fingerprints as passages that do not overlap."""
        merged: Passages = []
        for start, end in sorted(zip(self.starts.tolist(), self.ends.tolist(), strict=True)):
            if merged and start <= merged[-1][1]:
                merged[-1] = merged[-1][0], max(end, merged[-1][1])
            elif end > start:
                merged.append((start, end))
        return merged


def fingerprints(code: str) -> set[int]:
    """Return the fingerprints of a code, which need not be correct Python."""
    return set(_prints(_bounded(Work("", (code,)))).hashes.tolist())


def compare(works: Iterable[Work], known: Iterable[str]) -> Comparison:
    """Compare all pairs of students, each with at most one work, in one lesson.

    `known` is code that students may have in common: the release's and right answers. Return the pairs with at least
    LEAST_SHARED fingerprints and LEAST_SHARE of one of the two in common, and the notebooks of which at least as much
    is common code.
    """
    expected = np.fromiter(set[int]().union(*map(fingerprints, known)), np.int64)
    ordered = sorted((_bounded(each) for each in works), key=lambda each: each.student)
    own = [_prints(each).having(expected, kept=False) for each in ordered]
    common = _common(own)
    in_common = [each.having(common) for each in own]
    return Comparison(
        len(ordered),
        _similar_pairs(ordered, [each.having(common, kept=False) for each in own]),
        _common_code(ordered, own, in_common),
    )


def overlap(first: set[int], second: set[int]) -> tuple[int, float]:
    """Return the number of fingerprints that two sets share, and its share of the smaller set."""
    shared = len(first & second)
    return shared, shared / max(min(len(first), len(second)), 1)


def _similar_pairs(works: Sequence[Work], prints: Sequence[_Prints]) -> list[SimilarPair]:
    shared = _shared(prints)
    shares = shared / np.maximum(np.diag(shared), 1)[:, None]  # [i, j]: the share of i that j has too
    sizes, groups = _groups(np.minimum(shares, shares.T))
    listed = np.triu((shared >= LEAST_SHARED) & (np.maximum(shares, shares.T) >= LEAST_SHARE), 1)
    ordered = sorted(
        np.argwhere(listed).tolist(), key=lambda ij: (-max(shares[*ij], shares[*ij[::-1]]), -shared[*ij], ij)
    )
    return [
        SimilarPair(
            works[i],
            works[j],
            (float(shares[i, j]), float(shares[j, i])),
            int(shared[i, j]),
            _passages(prints[i], prints[j]) if number < MOST_SHOWN else ([], []),
            int(sizes[groups[i]]) if groups[i] == groups[j] else 2,
        )
        for number, (i, j) in enumerate(ordered)
    ]


def _common_code(
    works: Sequence[Work], own: Sequence[_Prints], in_common: Sequence[_Prints]
) -> list[CommonCode]:
    """Return the notebooks that consist to a large part of common code, grouped by this code."""
    counts = [(len(part.different), len(whole.different)) for part, whole in zip(in_common, own, strict=True)]
    mostly = [
        number
        for number, (part, whole) in enumerate(counts)
        if part >= LEAST_SHARED and part >= LEAST_SHARE * whole
    ]
    shared = _shared([in_common[number] for number in mostly])
    _, groups = _groups(shared / np.maximum.outer(np.diag(shared), np.diag(shared)))
    found = []
    for group in dict.fromkeys(groups.tolist()):
        members = [number for number, of in zip(mostly, groups, strict=True) if of == group]
        shares = tuple(counts[number][0] / counts[number][1] for number in members)
        found.append(
            CommonCode(tuple(works[number] for number in members), shares, in_common[members[0]].passages())
        )
    return sorted(found, key=lambda each: -len(each.works))


def _bounded(work: Work) -> Work:
    """Return a work with at most LONGEST characters, laid out as the engine counts them."""
    cells, left = [], LONGEST
    for cell in work.cells:
        if plain := _plain(cell[:left]):
            cells.append(plain)
        left -= min(len(cell), left)
    return Work(work.student, tuple(cells))


def _plain(code: str) -> str:
    """Return a code with the line ends that the engine counts in, and without empty lines around it."""
    return code.replace("\r\n", "\n").replace("\r", "\n").strip("\n\ufeff")


def _prints(work: Work) -> _Prints:
    """Return the fingerprints of a bounded work."""
    hashes, starts, ends, at = [np.empty(0, np.int64)], [np.empty(0, int)], [np.empty(0, int)], 0
    for cell in work.cells:
        filtered, removed = _filtered(cell)
        many = max(len(filtered) - LENGTH + 1, 0)
        hashes.append(np.fromiter((hash(filtered[i : i + LENGTH]) for i in range(many)), np.int64, many))
        for places, first in ((starts, 0), (ends, LENGTH)):
            index = np.arange(first, first + many)
            row = np.clip(np.searchsorted(removed[:, 0], index), 0, len(removed) - 1)
            # The engine may misplace an end by the length of a class's name.
            places.append(np.clip(index + removed[row, 1], 0, len(cell)) + at)
        at += len(cell) + len(_BETWEEN)
    return _Prints(*map(np.concatenate, (hashes, starts, ends)))


@lru_cache(2**14)
def _filtered(cell: str) -> tuple[str, np.ndarray]:
    """Return a cell without what does not count, and how many characters are missing before each place."""
    filtered, removed = filter_code(_LAST_COMMA.sub(" ", cell), "own.py", "python")
    return filtered, removed


def _common(prints: Iterable[_Prints]) -> np.ndarray:
    """Return the fingerprints that more notebooks have than can be compared pair by pair."""
    different = {hashes.tobytes(): hashes for hashes in (each.different for each in prints)}
    found, counts = np.unique(np.concatenate(list(different.values())), return_counts=True)
    return found[counts > max(COMMON, COMMON_SHARE * len(different))]


def _shared(prints: Sequence[_Prints]) -> np.ndarray:
    """Return how many fingerprints each two notebooks share, and on the diagonal how many each one has."""
    found = [each.different for each in prints]
    _, columns = np.unique(np.concatenate([np.empty(0, np.int64), *found]), return_inverse=True)
    starts = np.cumsum([0, *map(len, found)])
    has = csr_array((np.ones(len(columns), np.int32), columns, starts), (len(found), len(columns)))
    return (has @ has.T).toarray()


def _groups(similarities: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the sizes of groups with an average similarity of LEAST_SHARE, and the group of each notebook.

    Average linkage: a notebook that contains two others does not put these into one group.
    """
    groups = np.zeros(len(similarities), int)
    if len(similarities) > 1:
        distances = squareform(1 - similarities, checks=False)
        groups = fcluster(linkage(distances, "average"), 1 - LEAST_SHARE, "distance")
    return np.bincount(groups), groups


def _passages(first: _Prints, second: _Prints) -> tuple[Passages, Passages]:
    """Return what two works have in common, as passages of the code of each."""
    return first.having(second.hashes).passages(), second.having(first.hashes).passages()
