"""A small course's solutions, its plan and its reference; whoever changes one makes its own."""

import pytest

from nao_course.instructor.authoring.plans import load_plan, reference
from tests.toy import toy


@pytest.fixture(scope="session")
def solutions(tmp_path_factory):
    return toy.solutions(tmp_path_factory.mktemp("course") / "solutions")


@pytest.fixture(scope="session")
def plan(solutions):
    return load_plan(solutions / "exercises" / "90_toy.py")


@pytest.fixture(scope="session")
def right(solutions):
    return reference("90", solutions)
