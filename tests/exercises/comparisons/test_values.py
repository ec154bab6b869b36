"""Comparisons tell right from wrong, say what kind of wrong, and never what was expected."""

import tracemalloc
from dataclasses import dataclass

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from nao_course.codec import register
from nao_course.exercises.comparisons.values import Between, Close, Exact, Points

nan, inf = np.nan, np.inf
numbers = st.floats(-1e300, 1e300) | st.sampled_from([nan, inf, -inf])
floats = hnp.arrays(float, hnp.array_shapes(min_dims=0, max_side=4), elements=numbers)


@register
@dataclass(frozen=True)
class Seen:
    bearing: float
    kind: str


@given(floats)
def test_an_answer_is_like_itself_as_an_array_or_a_list(array):
    assert Close().compare(array, array)
    assert Close().compare(array, array.tolist())
    assert bool(Exact().compare(array, array)) == (not np.isnan(array).any())


@given(hnp.arrays(float, hnp.array_shapes(), elements=st.floats(-1e6, 1e6)))
def test_single_precision_is_enough(array):
    assert Close().compare(array, array.astype(np.float32))


@given(floats, st.data())
def test_one_wrong_element_is_found_and_counted(array, data):
    place = data.draw(st.sampled_from(list(np.ndindex(array.shape))))
    other = array.copy()
    other[place] = 0.0 if not np.isfinite(array[place]) else array[place] + 1 + 0.01 * abs(array[place])
    verdict = Close().compare(array, other)
    assert verdict.kind == ("nan" if np.isnan(array[place]) else "value")
    assert Close(allowed=1.0).compare(array, other)


def test_close_tells_what_kind_of_difference_it_is():
    for expected, got, kind in [
        *((1.0, 1, "right"), (True, np.bool_(True), "right")),
        *((np.array([True, False]), [True, False], "right"), (np.zeros((0, 2)), np.zeros((0, 2)), "right")),
        *(((1.0, 2.0), [1.0, 2.0], "right"), ((1.0, 2.0), np.array([1.0, 2.0]), "right")),
        *(((1.0, None), (1.0, None), "right"), ([], [], "right"), (None, None, "right")),
        (Seen(0.5, "post"), Seen(0.5, "post"), "right"),
        *((1.0, np.array([1.0]), "shape"), (np.zeros((2, 3)), np.zeros((3, 2)), "shape")),
        (np.zeros((0, 2)), [], "shape"),
        *((1.0, True, "type"), (True, 1.0, "type"), (np.array([True, False]), np.array([1, 0]), "type")),
        *((1.0, 1j, "type"), (1.0, 10**400, "type"), (np.zeros(2), [[0.0], [0.0, 1.0]], "type")),
        *(((1.0, 2.0), (1.0,), "type"), ((1.0, 2.0), 1.0, "type")),
        *(((1.0, 2.0), np.zeros((10**6, 1)), "type"), (None, 0.0, "type"), ("green", 3, "type")),
        *(({"a": 1.0}, {"b": 1.0}, "type"), (Seen(0.5, "post"), (0.5, "post"), "type")),
        ([Seen(0.5, "post")], [Seen("x", "post")], "type"),
        (1.0, None, "nothing"),
        *((1.0, nan, "nan"), (nan, 1.0, "nan")),
        *((inf, -inf, "value"), (np.zeros(2, np.uint8), np.array([0, 1]), "value")),
        *((np.array([200], np.uint8), np.array([-56], np.int8), "value"), ((1.0, 2.0), (1.0, 2.5), "value")),
        *(("green", "red", "value"), (Seen(0.5, "post"), Seen(0.5, "corner"), "value")),
    ]:
        assert Close().compare(expected, got).kind == kind
    tracemalloc.start()
    assert Close().compare(np.zeros(1001), ["x" * 10**5] + [""] * 1000).kind == "type"
    assert tracemalloc.get_traced_memory()[1] < 10**6  # numpy would make room for it a thousand times
    tracemalloc.stop()


def test_angles_are_compared_on_their_circle_and_a_random_answer_lies_between_its_bounds():
    hues, turn = Close(period=360.0, atol=0.1), Close(period=2 * np.pi)
    assert hues.compare(np.array([359.99, 0.0, 90.0]), np.array([-0.01, 360.0, 450.0]))
    assert hues.compare(np.array([0.0, 359.95]), np.array([359.95, 0.0]))
    assert not hues.compare(10.0, 190.0)
    assert not hues.compare(10.0, 11.0)
    assert turn.compare(np.pi, -np.pi)
    assert hues.compare(10.0, inf).kind == "value"
    for got, kind in [*((np.float32(2), "right"), (inf, "value"), (None, "nothing"), ([1.5], "shape"))]:
        assert Between().compare((1.0, 2.0), got).kind == kind


def test_labels_are_whole_numbers_that_are_not_rounded_and_a_fraction_may_differ():
    labels = np.zeros((10, 10), np.uint8)
    wrong = labels.copy()
    wrong.flat[:5] = 3
    assert Exact(allowed=0.05).compare(labels, wrong)
    wrong.flat[5] = 3
    verdict = Exact(allowed=0.05).compare(labels, wrong)
    assert verdict.text == "6 of 100 elements of your answer are wrong, the first at [0, 0]: you have 3"
    assert not Exact().compare(labels, wrong)
    assert Exact().compare(2**53, 2**53)
    assert not Exact().compare(2**53, 2**53 + 1)
    assert not Exact().compare(1.0, 1.0000001)
    wanted = np.array([[0, 1], [2, 3]], dtype=np.uint8)
    assert Exact().compare(wanted, wanted.astype(np.int64)) and Exact().compare(wanted, wanted.tolist())
    assert Exact().compare(wanted, wanted.astype(float)).kind == "type"
    text = Exact().compare(np.zeros(3, dtype=np.uint8), np.zeros(3)).text
    assert "floating-point numbers (dtype float64)" in text and "np.zeros(shape, dtype=int)" in text


POINTS = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 10.0]])


def test_points_are_compared_one_to_one_in_any_order():
    for got, kind in [
        *((POINTS[::-1], "right"), (POINTS + 0.5, "right")),
        *((POINTS[:, ::-1] + [0, 5], "value"), (np.vstack([POINTS, POINTS[:1]]), "value")),
        *((POINTS[[0, 0, 1]], "value"), (np.where(POINTS > 5, 1e308, POINTS), "value")),
        *(([], "shape"), (np.zeros((3, 3)), "shape")),
        (None, "nothing"),
        (np.where(POINTS > 5, nan, POINTS), "nan"),
    ]:
        assert Points(tolerance=1.0).compare(POINTS, got).kind == kind
    law = Points(tolerance=1.0)
    assert not law.compare(np.array([(0.0, 0.0), (0.5, 0.0)]), np.array([(0.2, 0.0), (9.0, 9.0)]))
    assert not law.compare(np.array([(0.0, 0.0), (9.0, 9.0)]), np.array([(0.2, 0.0), (0.5, 0.0)]))
    expected, got = np.array([[0.0, 0.0], [0.9, 0.0]]), np.array([[0.8, 0.0], [1.8, 0.0]])
    assert law.compare(expected, got)  # the nearest pair would leave 1.8 for the other
    assert Points().compare(np.zeros((0, 2)), np.zeros((0, 2)))
    assert Points().compare(np.zeros((0, 2)), POINTS).kind == "value"
    one, two = np.array([[0.0, 0.0]]), np.array([[0.0, 0.0], [9.0, 9.0]])
    for expected, got, said in (
        *((two, one, "has 1 point, which"), (one, two, "has 2 points, which")),
        *(
            (one, one + 5, "your point is in the wrong"),
            (two, two + [[5, 0], [0, 0]], "1 of your 2 points is in"),
        ),
        (two, two + 5, "2 of your 2 points are in"),
    ):
        assert said in Points().compare(expected, got).text


def test_a_wrong_answer_of_a_mistake_is_known_again():
    assert Between().alike(5.0, 5.05)
    assert not Between().alike(5.0, 5.5)
    assert Points().alike(None, None)
    assert not Points().alike(None, POINTS)
    assert Points().alike(POINTS, POINTS[::-1])
    assert Points().alike(3.0, 3.0)
    above = np.array([[1.0, 2.0], [nan, nan]])  # beyond the horizon
    assert Points().alike(above, above[::-1])
    assert not Points().alike(above, np.array([[1.0, 2.0], [3.0, 4.0]]))
    assert Close().alike("text", "text")
    assert not Close().alike(1.0, None)


SECRET = 987.125
ANSWERS = [None, "x", 1.0, nan, True, [], [1.0], (1.0, 2.0), POINTS, np.zeros(5), {"a": 1}, Seen(1.0, "x")]


def test_an_expected_value_is_never_said_but_how_exact_an_answer_has_to_be():
    for comparison, expected in [
        *((Close(), SECRET), (Close(), np.full(5, SECRET)), (Close(), (SECRET, SECRET))),
        *((Close(), [np.full(2, SECRET)]), (Exact(), SECRET), (Points(), np.full((2, 2), SECRET))),
        *((Between(), (SECRET, SECRET)), (Close(), Seen(SECRET, "987"))),
    ]:
        for answer in ANSWERS:
            verdict = comparison.compare(expected, answer)
            assert not verdict
            assert verdict.text
            assert "987" not in verdict.text
    assert "is close, but must be right within 0.01 %" in Close().compare(np.pi / 2, 3.14 / 2).text
    assert "is close" not in Close().compare(np.pi / 2, 3 / 2).text
    assert "is close, but must be right within 0.02" in Close(rtol=0, atol=0.02).compare(350.0, 350.1).text
    assert "is close" not in Close(rtol=0.25).compare(1.0, 1.5).text  # what scatters has a coarse tolerance
    assert "is close" not in Close().compare(np.array([1.0, 2.0]), np.array([1.0002, 3.0])).text
    comparison = Close(names=("your hue", "your saturation"))
    assert "of your saturation are wrong" in comparison.compare((1.0, np.zeros(3)), (1.0, np.ones(3))).text
    assert "expected 2 values (your hue, your saturation)" in comparison.compare((1.0, 2.0), 3.0).text
    assert comparison.compare((1.0, np.zeros(2)), (1.0, np.array([0.0, np.nan]))).at == (1,)
    assert Close().compare(None, np.zeros(2)).text == "your answer is an array; expected None"
