"""Perturbed inputs are what they were but for their last digits, whatever holds the numbers."""

from dataclasses import dataclass

import numpy as np
import pytest
import scipy.sparse

from nao_course.codec import encode
from nao_course.exercises import Case, register
from nao_course.geometry import Pose
from nao_course.instructor.authoring.perturbation import SIZE, perturbed, perturbed_cases
from nao_course.slam import Measurement


@register
@dataclass(frozen=True)
class Half:
    """A class that refuses all other numbers."""

    value: float

    def __post_init__(self):
        if self.value != 0.5:
            raise ValueError("not a half")


def rng():
    return np.random.default_rng(0)


NUMBERS = [2.5, 1 + 2j, np.float64(3.0), np.array(4.0), np.array([1j, 2.0])]
NUMBERS += [np.array([[1.0, -2.0], [1e-200, 1e200]]), scipy.sparse.csr_array(np.diag([1.0, 2.0]))]


def test_each_number_differs_by_less_than_fifty_rounding_errors_and_all_else_stays_as_it_is():
    for value in NUMBERS:
        other = perturbed(value, rng())
        assert type(other) is type(value) and encode(other) != encode(value)
        one, two = (
            np.asarray(each.toarray() if hasattr(each, "toarray") else each) for each in [value, other]
        )
        assert one.shape == two.shape and one.dtype == two.dtype
        assert (np.abs(two - one) <= 1.01 * SIZE * np.abs(one)).all()
    for value in [*ELSE, np.full((4, 4, 3), 200, np.uint8)]:
        assert encode(perturbed([value], rng())) == encode([value])
        assert list(perturbed_cases(Case((value,), expected=2.0))) == []


@pytest.mark.parametrize("wrapped", [lambda x: [x], lambda x: (1, x), lambda x: {"a": {3: x}}])
def test_numbers_are_found_in_whatever_holds_them(wrapped):
    value = wrapped([Pose(1.0, 2.0, 0.5), Measurement(0.25, 3.0)])
    other = perturbed(value, rng())
    assert encode(other) != encode(value)
    assert np.array_equal(repr(type(other)), repr(type(value)))
    (pose,), (was,) = ([each for each in _flat(one) if isinstance(each, Pose)] for one in (other, value))
    assert pose != was and abs(pose.x - was.x) <= SIZE and abs(pose.theta - was.theta) <= SIZE


def _flat(value):
    if isinstance(value, dict):
        value = list(value.values())
    return [each for item in value for each in _flat(item)] if isinstance(value, list | tuple) else [value]


ELSE = [7, True, "text", None, 0.0, np.array([1, 2]), np.array([True]), Half(0.5), np.random.default_rng(5)]


def test_a_case_is_perturbed_in_the_same_ways_each_time_and_only_its_inputs():
    case = Case((np.ones(3),), "ones", {"sigma": 0.5}, expected=0.25)
    first, second = (list(perturbed_cases(case)) for _ in range(2))
    assert encode(first) == encode(second) and len({encode(each) for each in first}) == len(first) >= 2
    for each in first:
        assert (each.name, each.expected) == ("ones", 0.25)
        assert each.kwargs["sigma"] != 0.5 and each.args[0].tolist() != [1, 1, 1]
    assert case.args[0].tolist() == [1, 1, 1]
