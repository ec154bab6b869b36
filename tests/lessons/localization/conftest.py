"""The solutions of lessons 06 and 05, which the tests run."""

import pytest

from nao_course.instructor.authoring.plans import load_solution
from tests.paths import SOLUTIONS


@pytest.fixture(scope="session")
def own():
    return load_solution(SOLUTIONS / "06_localization.ipynb")


@pytest.fixture(scope="session")
def report():
    """Return lesson 05's functions."""
    return load_solution(SOLUTIONS / "05_ekf_derivations.ipynb")


@pytest.fixture(scope="session")
def filter_of(own, report):
    """Return the functions that follow a drive."""
    return own["localize"], report["predict_pose"], report["predict_covariance"]
