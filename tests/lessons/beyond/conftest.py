"""The lesson's solution, the filter of lesson 07, and a generator without noise."""

import numpy as np
import pytest

from nao_course.instructor.authoring.plans import load_solution
from tests.paths import SOLUTIONS


class Still:
    """A generator that draws no noise."""

    def standard_normal(self, shape=None):
        return np.zeros(shape)

    def random(self, shape=None):
        return np.full(shape, 0.5) if shape else 0.5


@pytest.fixture(scope="session")
def own():
    return load_solution(SOLUTIONS / "12_beyond.ipynb")


@pytest.fixture(scope="session")
def ekf():
    """Return lesson 07's predict, update_landmarks and add_landmark."""
    seven = load_solution(SOLUTIONS / "07_ekf_slam.ipynb")
    return tuple(seven[name] for name in ("predict", "update_landmarks", "add_landmark"))


@pytest.fixture
def still():
    return Still()
