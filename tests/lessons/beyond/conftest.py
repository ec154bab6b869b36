"""The lesson's solution, the filter of lesson 07, and a generator without noise."""

import numpy as np
import pytest

from tests.lessons import every


class Still:
    """A generator that draws no noise."""

    def standard_normal(self, shape=None):
        return np.zeros(shape)

    def random(self, shape=None):
        return np.full(shape, 0.5) if shape else 0.5


@pytest.fixture(scope="session")
def own():
    return every.own("12")


@pytest.fixture(scope="session")
def ekf():
    """Return lesson 07's predict, update_landmarks and add_landmark."""
    return tuple(every.own("07")[name] for name in ("predict", "update_landmarks", "add_landmark"))


@pytest.fixture
def still():
    return Still()


@pytest.fixture(scope="session")
def cameras(own):
    """Return the functions that measure a distance with two cameras and with one."""
    return own["intersect_rays"], every.own("04")["pixel_to_ground"]
