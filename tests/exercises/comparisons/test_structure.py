"""Tolerances by the column, masks, complex numbers and sparse matrices: the right is accepted, the wrong is named."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from nao_course.codec import register
from nao_course.exercises.comparisons import Between, Close, Exact

TURN = 2 * np.pi
POLAR = Close(rtol=0.0, atol=(0.01, 0.5), period=(TURN, 0.0), names=("the bearing", "the range"))
seeds = st.integers(0, 2**32)
nan = np.nan


@register
@dataclass(frozen=True)
class Seen:
    kind: str
    bearing: float
    range: float


class Row(NamedTuple):
    bearing: float
    range: float


@given(st.integers(1, 5), seeds)
def test_each_column_has_its_own_tolerance_and_period(n, seed):
    rng = np.random.default_rng(seed)
    wanted = np.column_stack([rng.uniform(-np.pi, np.pi, n), rng.uniform(0, 9, n)])
    near = wanted + rng.uniform(-1, 1, (n, 2)) * (0.009, 0.49) + (TURN, 0)
    for shape in ((n, 2), (2 * n,), (1, n, 2)):
        assert POLAR.compare(wanted.reshape(shape), near.reshape(shape))
    for column, step in ((0, 0.02), (1, 1.1), (1, TURN)):
        wrong = near.copy()
        wrong[-1, column] += step
        verdict = POLAR.compare(wanted, wrong)
        assert verdict.kind == "value" and verdict.at == (n - 1, column)
        assert f"({POLAR.names[column]})" in verdict.text
        assert not POLAR.compare(wanted.ravel(), wrong.ravel())


def test_the_numbers_of_a_tuple_or_dataclass_are_columns():
    law = Close(rtol=0.0, atol=(0.01, 0.5), period=(TURN, 0.0))
    assert law.compare((0.0, 3.0), (TURN + 0.009, 3.4))
    assert law.compare({7: [Seen("post", 0.0, 3.0)]}, {7: [Seen("post", TURN, 3.4)]})
    assert ".bearing of" in law.compare(Seen("post", 0.0, 3.0), Seen("post", 0.1, 3.0)).text
    assert ".range of" in law.compare(Seen("post", 0.0, 3.0), Seen("post", 0.0, 3.0 + TURN)).text
    assert law.compare(Row(0.0, 3.0), (0.0, 3.4)) and not law.compare(Row(0.0, 3.0), Row(0.1, 3.0))


def test_tolerances_fit_what_is_empty_and_those_or_a_mask_that_fit_nothing_are_an_error():
    for expected in [np.zeros(3), 1.0, np.array(1.0), (1.0, 2.0, 3.0)]:
        with pytest.raises(ValueError, match="2 values"):
            Close(rtol=(0.1, 0.2)).compare(expected, expected)
        assert Close(rtol=(0.1, 0.2)).alike(expected, expected)
    assert POLAR.compare(np.zeros((0, 2)), np.zeros((0, 2)))
    assert POLAR.compare(np.zeros(0), np.zeros(0))
    assert POLAR.compare(np.zeros((0, 2)), np.zeros((0, 3))).kind == "shape"
    assert "(x)" not in Close(names=("x", "y")).compare(np.zeros(3), np.ones(3)).text
    assert "(x)" in Close(names=("x", "y")).compare(np.zeros(4), np.ones(4)).text
    for mask in ("middle", ((True, False),)):
        with pytest.raises(ValueError, match="mask|shape|broadcast"):
            Close(mask=mask).compare(np.zeros((2, 3)), np.zeros((2, 3)))


@pytest.mark.parametrize(
    "law",
    [Close(), POLAR, Close(allowed=0.3), Close(mask="upper"), Close(period=360.0), Close(rtol=0.0, atol=0.5)],
)
def test_an_answer_is_a_mistakes_where_comparing_them_finds_no_difference(law):
    rng = np.random.default_rng(0)
    shifts = [0.0, 0.0, 1e-5, 0.4]
    answers = [rng.integers(0, 3, (2, 2)) * 180.0 + shift for shift in shifts for _ in range(8)]
    for number, answer in enumerate(answers):
        answer[rng.random((2, 2)) < 0.1] = np.nan
        answers[number] = (answer, 3.0) if number % 4 == 0 else answer
    pairs = [(one, other) for one in (*answers, None, 2.0, 1j, True, "x") for other in (*answers, None, "x")]
    found = [law.alike(*pair) for pair in pairs]
    assert found == [bool(_compared(law, *pair)) for pair in pairs]
    assert any(found) and not all(found)


def _compared(law, answer, got):
    try:
        return law.compare(answer, got)
    except ValueError:
        return Close().compare(answer, got)


SIDES = {"upper": np.triu, "lower": np.tril, "diagonal": lambda ones: np.diag(np.diag(ones))}


@given(st.sampled_from(sorted(SIDES)), st.integers(1, 4), seeds)
def test_only_what_a_mask_says_counts(side, n, seed):
    rng = np.random.default_rng(seed)
    wanted, counts = rng.normal(size=(n, n)), SIDES[side](np.ones((n, n))).astype(bool)
    other = np.where(counts, wanted, rng.choice([nan, np.inf, 99.0], (n, n)))
    given_mask = tuple(map(tuple, counts.tolist()))
    for law in (Close(mask=side), Close(mask=given_mask), Exact(mask=side)):
        assert law.compare(wanted, other)
        place = tuple(rng.choice(np.argwhere(counts)))
        wrong = other.copy()
        wrong[place] += 1
        assert law.compare(wanted, wrong).at == place
    for law in (Close, Exact):
        assert not law(allowed=0.99 / counts.sum(), mask=side).compare(wanted, wrong)
        assert law(allowed=1 / counts.sum(), mask=side).compare(wanted, wrong)
    assert f"1 of {counts.sum()} element" in Close(mask=side).compare(wanted, wrong).text
    matrices = sparse.csr_array(wanted), sparse.coo_array(np.where(counts, wanted, 99.0))
    assert Close(mask=side).compare(*matrices) and Close(mask=given_mask).compare(*matrices)
    assert not Close(mask=side).compare(matrices[0], sparse.csr_array(wrong))


def test_values_of_every_kind_are_told_apart_and_long_lists_are_not_read():
    wanted = np.array([[nan, 1.0], [2.0, nan]])
    assert Close().compare(wanted, wanted.copy())
    assert Close().compare(wanted, np.nan_to_num(wanted)).text.startswith("your answer is not NaN at [0, 0]")
    assert "is NaN at [0, 1]" in Close().compare(wanted, np.full((2, 2), nan)).text
    assert "1+2j, which is not right" in Close().compare(1j, 1 + 2j).text
    complex_ = Close().compare(np.ones(2), np.ones(2) + 0j).text  # what eig returns since NumPy 2.5
    assert "complex numbers, not floating-point numbers: since NumPy 2.5, np.linalg.eig" in complex_
    many = [np.zeros(10**6)] * 3
    verdict = Close().compare(np.zeros(3), many)
    assert verdict.kind == "type" and "a list of 3000000 values; return an array" in verdict.text
    for expected, got, kind in [
        *((1 + 2j, np.complex64(1 + 2j), "right"), (1 + 0j, 1.0, "right")),
        (complex(0, nan), complex(0, nan), "right"),
        ({1: 1.0, (2, 3): None}, {1: 1.0, (2, 3): None}, "right"),
        *((1.0, 1 + 0j, "type"), (1.0, np.hypot, "type"), ({1: 1.0}, {"1": 1.0}, "type")),
        *((1 + 2j, 1 - 2j, "value"), (np.array([1j, 2.0]), [1j, 2.0 + 1e-3j], "value")),
        *((np.hypot, np.exp, "value"), (np.hypot, 1.0, "value")),
        (1j, complex(0, nan), "nan"),
    ]:
        assert Close().compare(expected, got).kind == kind


@settings(deadline=None)
@given(seeds, st.sampled_from(["csr", "csc", "coo"]), st.sampled_from(["csr", "csc", "coo"]))
def test_sparse_matrices_are_compared_by_their_elements_whatever_their_format(seed, one, other):
    rng = np.random.default_rng(seed)
    dense = rng.normal(size=(4, 3)) * (rng.uniform(size=(4, 3)) < 0.4)
    wanted, have = sparse.coo_array(dense).asformat(one), sparse.coo_matrix(dense).asformat(other)
    assert Close().compare(wanted, have) and Exact().compare(wanted, have)
    place = (int(rng.integers(4)), int(rng.integers(3)))
    dense[place] += 1
    verdict = Close().compare(wanted, sparse.csr_array(dense))
    assert verdict.at == place and "1 of 12 elements" in verdict.text


def test_sparse_matrices_sum_duplicate_entries_and_stay_sparse():
    places = (np.array([0, 0, 1]), np.array([1, 1, 0]))
    doubled = sparse.coo_array((np.array([1.0, 2.0, 5.0]), places), shape=(2, 2))
    assert Close().compare(sparse.csr_array([[0.0, 3.0], [5.0, 0.0]]), doubled)
    assert Close(allowed=0.25).compare(sparse.csr_array([[0.0, 3.0], [4.0, 0.0]]), doubled)
    assert Close().compare(doubled, sparse.csr_array([[0.0, 3.0], [5.0, 0.0]]))
    corners = np.array([0, 999_999]), np.array([999_999, 0])
    wanted = sparse.coo_array((np.ones(2), corners), shape=(10**6, 10**6))
    assert Close().compare(wanted, wanted.copy())
    assert Close(mask="upper").compare(wanted, wanted.copy())
    assert Close().compare(np.eye(3), sparse.csr_array(np.eye(3))).kind == "type"
    for got, kind in [
        *((np.eye(3), "type"), (sparse.csr_array(np.eye(3) * 1j), "type")),
        (sparse.csr_array(np.eye(3, dtype=bool)), "type"),
        (sparse.eye_array(4), "shape"),
        (sparse.csr_array((3, 3)), "value"),
        (sparse.csr_array(np.eye(3) * nan), "nan"),
        (sparse.csr_array(np.eye(3, dtype=np.int8)), "right"),
    ]:
        assert Close().compare(sparse.csr_array(np.eye(3)), got).kind == kind


def test_each_of_several_random_answers_lies_between_its_own_bounds():
    for got, kind in [
        (np.array([1.0, 3.0]), "right"),
        ([1.5, 3.5], "value"),
        ([1.5, nan], "nan"),
        *(([1.5], "shape"), (1.5, "shape")),
        *(([True, True], "type"), ([1j, 2.0], "type")),
    ]:
        assert Between().compare(([1.0, 2.0], np.array([2.0, 3.0])), got).kind == kind
        if kind == "value":
            assert Between().compare((1.0, [2.0, 3.0]), got).at == (1,)
