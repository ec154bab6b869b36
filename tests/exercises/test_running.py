"""Drivers are found by their name, from wherever they are registered."""

import sys
from types import ModuleType

import pytest

from nao_course.exercises import Case, call, register_driver
from nao_course.exercises.comparisons.jacobians import jacobian
from nao_course.exercises.comparisons.sampling import sampling_law
from nao_course.exercises.running import find_driver


def test_the_librarys_drivers_are_found_by_their_bare_names():
    assert find_driver("sampling_law") is sampling_law
    assert find_driver("jacobian") is jacobian


def test_a_lessons_driver_is_found_in_its_module_and_runs_with_the_students_function_first(monkeypatch):
    monkeypatch.setattr("nao_course.exercises.running._DRIVERS", {})
    module = ModuleType("nao_course.a_lesson_of_this_test")
    monkeypatch.setitem(sys.modules, module.__name__, module)

    @register_driver
    def twice(function, value):
        return function(function(value))

    name = f"{module.__name__}:twice"
    assert find_driver(name) is twice
    assert call(lambda value: value + 1, Case((1,)), name).value == 3


@pytest.mark.parametrize("name", ["no_driver", "os:system", "nao_course.exercises.running:call"])
def test_what_is_registered_nowhere_is_no_driver(name):
    with pytest.raises(ValueError, match=r"there is no driver .*'jacobian', .*'sampling_law'"):
        find_driver(name)


def test_two_drivers_cannot_have_one_name():
    def jacobian():
        """Another."""

    with pytest.raises(ValueError, match="a driver named 'jacobian' is registered already"):
        register_driver(jacobian)
