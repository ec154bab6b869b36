"""Pairs of notebooks that share more code than the release and the known right answers explain.

The engine is copydetect: it replaces the names of variables, functions and classes and the texts of strings by a letter
each, drops comments and white space, and hashes every run of LENGTH characters of the rest (a fingerprint).
"""

from __future__ import annotations

import io
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from copydetect import CodeFingerprint, compare_files
from scipy.sparse import csr_array

LENGTH = 20  # characters of a fingerprint
# A pair is listed from these values on; `python -m benchmarks similar` measures what they find and miss.
LEAST_SHARE, LEAST_SHARED = 0.3, 30
# A fingerprint of more notebooks than this belongs to the task, as in MOSS; equal notebooks count as one.
COMMON, COMMON_SHARE = 10, 0.1
LONGEST = 100_000  # characters of a notebook's own code that are compared
# Kept everywhere: winnowing to fewer fingerprints would depend on Python's hashes, which differ from run to run.
_WINDOW = 1
# A comma that only a formatter adds. A space in its place keeps all positions.
_LAST_COMMA = re.compile(r",(?=(?:\s|#[^\n]*+)*+[)\]}])")
_BETWEEN = "\n\n"  # cells, where the code is shown


@dataclass(frozen=True)
class Work:
    """A student's own code in a lesson.

    Parameters
    ----------
    student : str
        Name of the student.
    cells : tuple of str
        The code, by cell or file: fingerprints do not reach from one into the next.
    """

    student: str
    cells: tuple[str, ...]

    @property
    def code(self) -> str:
        """All of it."""
        return "".join(f"{cell}{_BETWEEN}" for cell in self.cells)


@dataclass(frozen=True)
class SimilarPair:
    """Two students whose own code is similar.

    Parameters
    ----------
    first, second : Work
        Their work, in the order of their names.
    share : float
        Share of the fingerprints of the notebook with fewer of them that the other one has too, 0 to 1.
    shared : int
        Number of the fingerprints that both have.
    passages : tuple of list of (int, int)
        For each of the two, start and end of the passages in its `code` that the other one has too.
    """

    first: Work
    second: Work
    share: float
    shared: int
    passages: tuple[list[tuple[int, int]], list[tuple[int, int]]]


def fingerprints(code: str) -> set[int]:
    """Return the fingerprints of a code, which need not be correct Python."""
    return set(_fingerprinted(code).hashes)


def similar_pairs(works: Iterable[Work], known: Iterable[str]) -> list[SimilarPair]:
    """Compare all pairs of students in one lesson.

    Parameters
    ----------
    works : iterable of Work
        At most one of each student.
    known : iterable of str
        Code that students may have in common: the release's and right answers.

    Returns
    -------
    list of SimilarPair
        The pairs with at least LEAST_SHARED fingerprints and LEAST_SHARE in common, the largest share first.
    """
    expected = set[int]().union(*map(fingerprints, known))
    ordered = sorted((_bounded(each) for each in works), key=lambda each: each.student)
    read = [[_fingerprinted(cell) for cell in each.cells] for each in ordered]
    _leave_out(read, expected)
    _leave_out(read, _common(read))
    pairs = []
    for i, j, shared, share in _counted([_united(each) for each in read]):
        if shared >= LEAST_SHARED and share >= LEAST_SHARE:
            pairs.append(SimilarPair(ordered[i], ordered[j], share, shared, _passages(read[i], read[j])))
    return sorted(
        pairs, key=lambda each: (-each.share, -each.shared, each.first.student, each.second.student)
    )


def overlap(first: set[int], second: set[int]) -> tuple[int, float]:
    """Return the number of fingerprints that two sets share, and its share of the smaller set."""
    shared = len(first & second)
    return shared, shared / max(min(len(first), len(second)), 1)


def _bounded(work: Work) -> Work:
    """Return a work with at most LONGEST characters, laid out as the engine counts them."""
    cells, left = [], LONGEST
    for cell in work.cells:
        cells.append(_plain(cell[:left]))
        left -= min(len(cell), left)
    return Work(work.student, tuple(cells))


def _plain(code: str) -> str:
    """Return a code with the line ends that the engine counts in, and without empty lines around it."""
    return code.replace("\r\n", "\n").replace("\r", "\n").strip("\n\ufeff")


def _fingerprinted(code: str) -> CodeFingerprint:
    text = io.StringIO(_LAST_COMMA.sub(" ", _plain(code)))
    return CodeFingerprint("own.py", LENGTH, _WINDOW, language="python", fp=text)


def _united(cells: Iterable[CodeFingerprint]) -> set[int]:
    """Return the fingerprints of all cells of a work."""
    return set[int]().union(*(each.hashes for each in cells))


def _leave_out(works: Iterable[Iterable[CodeFingerprint]], known: set[int]) -> None:
    """Remove fingerprints. The engine's own parameter for it also removes repetitions that are not known."""
    for cell in (cell for cells in works for cell in cells):
        cell.hashes = cell.hashes - known
        cell.hash_idx = {each: places for each, places in cell.hash_idx.items() if each in cell.hashes}


def _common(works: Iterable[Sequence[CodeFingerprint]]) -> set[int]:
    """Return the fingerprints that so many different notebooks have that the task must be the reason."""
    different = {tuple(cell.filtered_code for cell in cells): _united(cells) for cells in works}
    most = max(COMMON, COMMON_SHARE * len(different))
    counts = Counter(each for hashes in different.values() for each in hashes)
    return {each for each, count in counts.items() if count > most}


def _counted(found: Sequence[set[int]]) -> Iterator[tuple[int, int, int, float]]:
    """Yield (i, j, shared, share) of all pairs i < j that share a fingerprint."""
    columns = {each: number for number, each in enumerate(set[int]().union(*found))}
    indices = [columns[each] for hashes in found for each in hashes]
    starts = np.cumsum([0, *map(len, found)])
    has = csr_array((np.ones(len(indices), np.int32), indices, starts), shape=(len(found), len(columns)))
    shared = (has @ has.T).tocoo()
    for i, j, count in zip(*map(np.ndarray.tolist, (*shared.coords, shared.data)), strict=True):
        if i < j:
            yield i, j, count, count / min(len(found[i]), len(found[j]))


def _passages(
    first: Sequence[CodeFingerprint], second: Sequence[CodeFingerprint]
) -> tuple[list[tuple[int, int]], list[tuple[int, int]]]:
    """Return what two works have in common, as passages of the code of each."""
    found: tuple[list[tuple[int, int]], list[tuple[int, int]]] = ([], [])
    starts = [
        np.cumsum([0, *(len(each.raw_code) + len(_BETWEEN) for each in cells)]) for cells in (first, second)
    ]
    for (i, one), (j, other) in product(enumerate(first), enumerate(second)):
        _, _, slices = compare_files(one, other)
        for passages, at, cell, bounds in zip(
            found, (starts[0][i], starts[1][j]), (one, other), slices, strict=True
        ):
            inside = np.clip(np.asarray(bounds, int).reshape(2, -1), 0, len(cell.raw_code)) + at
            passages += map(tuple, inside.T.tolist())
    return _merged(found[0]), _merged(found[1])


def _merged(passages: Iterable[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return passages that do not overlap; the engine may misplace an end by the length of a class's name."""
    merged: list[tuple[int, int]] = []
    for start, end in sorted(passages):
        if merged and start <= merged[-1][1]:
            merged[-1] = merged[-1][0], max(end, merged[-1][1])
        elif end > start:
            merged.append((start, end))
    return merged
