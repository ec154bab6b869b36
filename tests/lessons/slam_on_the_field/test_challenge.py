"""The challenge of lesson 11: its drives, and that only a consistent estimate gains points."""

import numpy as np
import pytest

from nao_course.lessons.slam_on_the_field.challenge import judge, make_case


@pytest.fixture(scope="module")
def case():
    return make_case(2)


def test_odometry_is_worth_nothing_and_an_overconfident_winner_loses(case):
    assert judge((case.odometry, case.odometry_covariance), case).score == pytest.approx(0.0, abs=1e-6)
    near = case.drive.poses[-1] + (0.03, 0.0, 0.0)
    consistent, overconfident = judge((near, 0.001 * np.eye(3)), case), judge((near, 1e-7 * np.eye(3)), case)
    assert consistent.score > 3 and overconfident.score < 0
