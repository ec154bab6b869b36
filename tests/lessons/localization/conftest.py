"""The lesson's own solution, with that of lesson 05, which its tests run."""

import pytest

from nao_course.instructor.authoring.plans import load_solution
from tests.paths import SOLUTIONS


@pytest.fixture(scope="session")
def own():
    return load_solution(SOLUTIONS / "06_localization.ipynb")


@pytest.fixture(scope="session")
def report():
    """Lesson 05's functions."""
    return load_solution(SOLUTIONS / "05_ekf_derivations.ipynb")


@pytest.fixture(scope="session")
def filter_of(own, report):
    """What follows a drive."""
    return own["localize"], report["predict_pose"], report["predict_covariance"]
