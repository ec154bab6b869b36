"""The filter of lesson 11's solution, which all wrappers are tested with."""

import pytest

from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.instructor.authoring.plans import load_solution
from tests.paths import SOLUTIONS


@pytest.fixture(scope="session")
def ekf():
    """The class `EkfSlam`; it takes a start and, if they are not the usual ones, odometry, gate and association."""
    return load_solution(SOLUTIONS / "11_slam_on_the_field.ipynb")["EkfSlam"]


@pytest.fixture
def jointly(ekf):
    """A filter at a start, with joint association."""
    return lambda start: ekf(start, OdometryNoisePerMove(), 4.0, associate_jointly)
