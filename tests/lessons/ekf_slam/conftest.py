"""The lesson's own solution, which its tests run."""

import pytest

from nao_course.instructor.authoring.plans import load_solution
from tests.paths import SOLUTIONS


@pytest.fixture(scope="session")
def own():
    return load_solution(SOLUTIONS / "07_ekf_slam.ipynb")


@pytest.fixture(scope="session")
def film_functions(own):
    """What makes the film."""
    return own["init_landmarks"], own["predict"], own["update"]
