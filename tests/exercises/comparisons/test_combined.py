"""Comparisons made of others: every one of them counts, in any order where that is said, and so do laws."""

from dataclasses import dataclass

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from nao_course.codec import decode, encode, register
from nao_course.exercises.case import Case
from nao_course.exercises.comparisons import All, Between, Close, Each, Exact, Property, Unordered

nan = np.nan
numbers = st.floats(-100, 100)
rows = st.lists(st.tuples(numbers, numbers), max_size=6)


@register
@dataclass(frozen=True)
class Line:
    start: object
    kind: str


@register
@dataclass(frozen=True)
class OtherLine:
    start: object
    kind: str


@register
def solves(args, kwargs, answer):
    """H delta = -b."""
    information, b = args
    return "" if np.allclose(information @ answer, -b) else "H times your delta is not -b"


@register
def symmetric(args, kwargs, answer):
    return "" if np.allclose(answer, answer.T) else "your answer is not symmetric"


@given(st.integers(1, 4), st.integers(0, 2**32))
def test_a_law_judges_by_the_inputs_alone(n, seed):
    rng = np.random.default_rng(seed)
    information, b = np.eye(n) + np.diag(rng.uniform(0, 3, n)), rng.normal(size=n)
    case, law = Case((information, b)), Property(solves)
    assert law.judge(case, np.linalg.solve(information, -b))
    wrong = law.judge(case, np.linalg.solve(information, -b) + 0.1)
    assert wrong.kind == "law" and wrong.text == "H times your delta is not -b"
    for answer, kind in ((None, "nothing"), ("x", "type"), ([1, [2]], "type")):
        assert law.judge(case, answer).kind == kind


@register
def follows(args, kwargs, answer):
    return "" if answer > args[0] else "it is not above what went in"


def test_a_law_sees_the_inputs_also_within_another_comparison_and_cannot_change_the_case():
    for law in [All((Property(follows),)), Each((Property(follows),)), Unordered(Property(follows))]:
        case = Case((10.0,), expected=11.0 if isinstance(law, All) else (11.0,))
        right, wrong = (12.0, 9.0) if isinstance(law, All) else ((12.0,), (9.0,))
        assert law.judge(case, right)
        assert not law.judge(case, wrong)

    def greedy(args, kwargs, answer):
        args[0][:] = 0
        return ""

    case = Case((np.ones(2),))
    assert Property(greedy).judge(case, 1.0) and case.args[0].tolist() == [1, 1]
    law, case = Property(symmetric), Case((), expected=np.eye(2))
    assert law.judge(case, [[1.0, 2.0], [2.0, 1.0]])
    assert law.judge(case, ([1.0, 2.0], [3.0, 1.0])).kind == "law"
    assert law.judge(case, [[1.0, 2.0], [2.0]]).kind == "type"


LARGE = np.zeros((10**5, 1))  # compared with its transpose: 10^10 elements


def test_a_law_is_not_asked_about_an_answer_far_larger_than_the_references():
    for answer in [LARGE, [LARGE], {"a": "x" * 10**5}, sparse.coo_array((10**5, 10**5))]:

        def unasked(args, kwargs, answer):
            raise AssertionError

        case = Case((), expected=np.eye(3))
        assert "far too many" in Property(unasked).judge(case, answer).text
        assert Property(symmetric).judge(case, np.eye(9))


def test_all_comparisons_count_the_first_that_fails_is_told_and_they_travel_with_the_check_data():
    both = All((Close(mask="upper"), Property(symmetric)))
    wanted = np.array([[2.0, 1.0], [1.0, 3.0]])
    assert both.compare(wanted, wanted)
    assert both.compare(wanted, np.array([[2.0, 1.0], [0.0, 3.0]])).text == "your answer is not symmetric"
    assert both.compare(wanted, np.array([[2.0, 0.0], [0.0, 3.0]])).kind == "value"
    assert both.alike(wanted, wanted) and not both.alike(wanted, 2 * wanted)
    near = All((Property(symmetric), Close(atol=0.1)))
    assert near.alike(wanted, wanted + 0.05), "both obey the law"
    assert not near.alike(wanted, wanted + [[0.0, 0.05], [0.0, 0.0]]), "only one does"
    for law in (All((Close(mask="diagonal"), Close())), All((Close(), Close(mask="diagonal")))):
        assert not law.alike(wanted, wanted - [[0.0, 1.0], [0.0, 0.0]])
    case = Case((), expected=(0.0, 1.0))
    assert All((Property(symmetric), Between())).expects(case, 0.5) == (0.0, 1.0)
    assert All((Close(), Exact())).expects(case, 0.5) == 0.5
    for comparison in (
        All((Close(mask="upper"), Property(solves))),
        Each((Close(rtol=(0.1, 0.2)), Unordered())),
        Close(mask=((True, False), (False, True)), period=(0.0, 6.28)),
    ):
        assert decode(encode(comparison)) == comparison


@given(st.lists(numbers, min_size=1, max_size=5), st.data())
def test_each_value_has_its_own_comparison(values, data):
    at = data.draw(st.integers(0, len(values) - 1))
    moved = [value + (0.5 if i == at else 0.0) for i, value in enumerate(values)]
    loose = tuple(Close(atol=1.0) if i == at else Close() for i in range(len(values)))
    assert Each(loose).compare(values, moved)
    assert Each(loose).compare(tuple(values), np.array(moved))
    tight = Each(()).compare(values, [value + (5 if i == at else 0) for i, value in enumerate(values)])
    assert tight.kind == "value" and f"value {at + 1} of your answer" in tight.text


def test_values_are_named_by_key_and_field():
    law = Each({"start": Close(atol=0.1), "kind": Exact()})
    assert law.compare(Line(1.0, "post"), Line(1.05, "post"))
    assert law.compare(Line(1.0, "post"), Line(1.05, "corner")).text.startswith(".kind of your answer")
    assert not law.compare(Line(1.0, "post"), (1.0, "post"))
    assert not law.compare({"start": 1.0, "kind": "post"}, Line(1.0, "post"))
    assert not law.compare(Line(1.0, "post"), OtherLine(1.0, "post"))
    known = Each({3: Close(atol=1.0)})
    assert known.compare({3: 1.0, 4: 1.0}, {4: 1.0, 3: 1.9})
    assert known.compare({3: 1.0, 4: 1.0}, {4: 1.9, 3: 1.0}).text.startswith("[4] of your answer")
    assert known.compare({3: 1.0}, {4: 1.0}).kind == "type"
    assert known.compare({3: 1.0}, None).kind == "nothing"
    assert Each((Close(atol=1.0),)).alike((1.0, 2.0), (1.5, 2.0))
    named = Each((Close(), Close()), names=("the state", "the covariance"))
    assert "the covariance of your answer" in named.compare((1.0, 2.0), (1.0, 3.0)).text
    assert not Each((Close(),)).alike((1.0, 2.0), 3.0) and Each((Close(),)).alike(3.0, 3.0)


@settings(deadline=None)  # the first one imports scipy
@given(rows, st.randoms())
def test_an_order_that_does_not_matter_does_not(points, random):
    law, shuffled = Unordered(Close()), list(points)
    random.shuffle(shuffled)
    assert law.compare(points, shuffled)
    array = np.array(points, dtype=float).reshape(-1, 2)
    assert law.compare(array, np.array(shuffled, dtype=float).reshape(-1, 2))
    assert law.compare(dict(enumerate(points)), {f"n{i}": each for i, each in enumerate(shuffled)})
    if points:
        assert not law.compare(points, shuffled[1:])
        assert not law.compare(points, [*shuffled[1:], (500.0, 0.0)])


def test_as_few_as_can_be_are_without_a_partner_and_another_kind_of_collection_is_told():
    law = Unordered(Close(rtol=0.0, atol=1.0))
    assert law.compare([0.0, 0.9], [1.8, 0.8])  # the nearest partner would leave 1.8 for 0.0
    assert "1 of 3 values of your answer match no" in law.compare([0.0, 10.0, 20.0], [20.0, 3.0, 0.0]).text
    assert law.compare([1.0, 1.0], [1.0, 2.5]).kind == "value"
    for expected, got, kind in [
        ([1.0], None, "nothing"),
        *(([1.0], {"a": 1.0}, "type"), ({1: 1.0}, [1.0], "type")),
        (np.zeros((2, 3)), np.zeros((2, 2)), "shape"),
        *((np.zeros((2, 3)), np.zeros((3, 3)), "value"), ([1.0], [nan], "value")),
        ([Line(1.0, "a"), Line(2.0, "b")], [Line(2.0, "a"), Line(1.0, "b")], "value"),
        ([], [], "right"),
    ]:
        assert Unordered(Close()).compare(expected, got).kind == kind
