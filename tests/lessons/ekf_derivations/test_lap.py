"""The lap: the estimate gets better with each of the student's functions, and the ellipse holds 95 % of the robots."""

import numpy as np
import pytest

from nao_course.lessons.ekf_derivations.lap import (
    LAP,
    LapPanel,
    draw_lap,
    estimates,
    share_inside,
    true_paths,
    typical_distance,
)


@pytest.fixture
def functions(solution):
    return solution["predict_pose"], solution["predict_covariance"]


def test_the_cloud_grows_across_the_way_as_the_text_says():
    assert true_paths().shape == (200, len(LAP) + 1, 3)
    paths = true_paths(20_000)
    assert paths[:, 6, :2].std(axis=0) == pytest.approx([0.07, 0.09], abs=0.006)
    assert paths[:, 12, :2].std(axis=0) == pytest.approx([0.29, 0.12], abs=0.006)
    dots = 100 * true_paths()[:, [6, 12], :2].std(axis=0)
    assert dots.round().tolist() == [[8, 9], [29, 13]]
    assert np.degrees(paths[:, -1, 2].std()) == pytest.approx(20, abs=0.5)


def test_the_lap_ends_where_it_starts_and_the_ellipse_holds_about_95_percent_all_the_way_round(functions):
    found = estimates(*functions)
    assert found.poses[-1] == pytest.approx([0, 0, 2 * np.pi], abs=1e-12)
    assert typical_distance() == pytest.approx(0.44, abs=0.01)
    assert "is 0.41 m from" in draw_lap(found).alt
    for steps in (1, 12, len(LAP)):
        assert share_inside(estimates(*functions, steps), robots=5000) == pytest.approx(0.945, abs=0.015)
    with pytest.raises(ValueError, match="have none"):
        share_inside(estimates(functions[0], None))


def test_the_panel_gets_better_with_each_function(functions):
    first, second, third = LapPanel(), LapPanel(functions[0]), LapPanel(*functions)
    assert "is 1.36 m from its estimated position" in first.summary()
    assert "no covariance yet" in first.summary() and "no covariance yet" in second.summary()
    assert "is 0.41 m from its estimated position" in second.summary()
    assert "190 of 200 robots (95 %)" in third.summary(), "the text states this number below the panel"
    third.set(command=18)
    assert "187 of 200 robots (94 %)" in third.summary()
    third.set(command=0)
    assert "inside" not in third.summary()


def test_a_transpose_on_the_wrong_side_loses_robots(functions, solution):
    def wrong(covariance, pose, control, noise):
        F, G = solution["motion_jacobians"](pose, control)
        return F.T @ covariance @ F + G @ noise @ G.T

    assert share_inside(estimates(functions[0], wrong)) < 0.8
