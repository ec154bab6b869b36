"""The lesson's own solution, which its tests run."""

import pytest

from nao_course.instructor.authoring.plans import load_solution
from tests.paths import SOLUTIONS


@pytest.fixture(scope="session")
def own():
    return load_solution(SOLUTIONS / "11_slam_on_the_field.ipynb")
