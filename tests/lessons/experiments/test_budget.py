"""The budget's predictions are what sampled pictures give."""

import numpy as np
import pytest

from nao_course.exercises import load_definitions, try_out
from nao_course.geometry import Pose
from nao_course.lessons.experiments import budget
from nao_course.lessons.experiments.budget import in_pixels, pixel_errors, sampled_poses, usual_sight
from tests.lessons.experiments.own import OWN, TEXT
from tests.paths import SOLUTIONS

FOUR = load_definitions(SOLUTIONS / "04_distance.ipynb")


def test_the_sight_shows_landmarks_that_are_in_the_picture():
    sight = usual_sight()
    pixels = in_pixels(sight)
    assert len(pixels) >= 3 and sight.view.contains(pixels).all()


def test_pixels_come_back_to_the_ground_they_show():
    sight = usual_sight()
    there = Pose.from_array(sight.pose).to_local(sight.landmarks)
    assert np.allclose(budget._ground(in_pixels(sight), sight.view), there, atol=2e-3)


def test_without_noise_the_pose_is_the_true_one(monkeypatch):
    monkeypatch.setattr(budget, "SAMPLES", 2)
    sight = usual_sight()
    weights = np.eye(2 * len(sight.landmarks))
    assert np.abs(sampled_poses(sight, 0.0, 0.0, weights)).max() < 2e-3


def test_samples_scatter_as_predicted(monkeypatch):
    monkeypatch.setattr(budget, "SAMPLES", 120)
    found = budget.measure_budget(OWN["error_budget"], FOUR["measurement_covariance"], 1.0, np.radians(0.5))
    for name in ("pixels", "tilt", "both"):
        large = found.predicted[name] > 0.2 * found.predicted["both"]
        assert found.measured[name][large] == pytest.approx(found.predicted[name][large], rel=0.25), name
    alt = budget.draw_budget(found).alt
    assert "pixels: x" in alt and "both: x" in alt


def test_a_hits_error_is_that_of_the_closest_report():
    scenes = (((np.zeros((9, 9, 3), np.uint8)), np.array([(4.0, 4.0), (90.0, 90.0)])),)
    errors = pixel_errors(lambda picture: np.array([(6.0, 4.0), (5.0, 3.0), (40.0, 40.0)]), scenes)
    assert errors.tolist() == [[1.0, -1.0]]
    assert pixel_errors(lambda picture: np.zeros((0, 2)), scenes).shape == (0, 2)


def test_a_range_is_worth_less_farther_away_and_the_tilt_is_the_larger_part():
    alt = budget.draw_range_budget(FOUR["measurement_covariance"], 2.0).alt
    assert "tilt: 0.04 m at 1 m, 0.15 m at 2 m, 0.59 m at 4 m" in alt
    assert "One degree is 15 cm at 2 m and 59 cm at 4 m" in TEXT


def test_without_pixels_or_a_budget_each_figure_says_what_is_missing():
    def blank():
        raise NotImplementedError

    missing = try_out(blank, "Finish exercise 10.6.")
    for show in (
        budget.draw_budget,
        budget.larger_source,
        lambda it: budget.draw_range_budget(FOUR["measurement_covariance"], it),
        lambda it: budget.tell_tilt_left(FOUR["measurement_covariance"], it),
        lambda it: budget.measure_budget(OWN["error_budget"], FOUR["measurement_covariance"], it),
    ):
        assert repr(try_out(lambda show=show: show(missing))) == "Finish exercise 10.6."


def test_the_larger_source_is_that_of_the_error_in_x():
    parts = {"pixels": np.array([1.0, 5.0, 5.0]), "tilt": np.array([2.0, 1.0, 1.0])}
    assert budget.larger_source(budget.Budget(parts, parts)) == "tilt"
