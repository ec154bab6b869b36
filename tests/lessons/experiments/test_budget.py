"""The budget's predictions are what sampled pictures give."""

from functools import partial

import numpy as np
import pytest

from nao_course.exercises import try_out
from nao_course.geometry import Pose
from nao_course.lessons.experiments import budget
from nao_course.lessons.experiments.budget import in_pixels, pixel_errors, sampled_poses, usual_scene
from nao_course.lessons.experiments.scenes import simulated_scenes
from tests.lessons.every import blank, label, own, quotes
from tests.lessons.experiments.own import OWN, TEXT

FOUR = own("04")


def test_landmarks_of_the_sight_are_in_the_picture_and_return_to_the_ground_and_the_true_pose(monkeypatch):
    scene = usual_scene()
    pixels = in_pixels(scene)
    assert len(pixels) >= 3 and scene.view.contains(pixels).all()
    there = Pose.from_array(scene.pose).to_local(scene.landmarks)
    assert np.allclose(budget._ground(pixels, scene.view), there, atol=2e-3)
    monkeypatch.setattr(budget, "SAMPLES", 2)
    weights = np.eye(2 * len(scene.landmarks))
    assert np.abs(sampled_poses(scene, 0.0, 0.0, weights)).max() < 2e-3  # without noise


@pytest.mark.slow
def test_samples_scatter_as_predicted(monkeypatch):
    monkeypatch.setattr(budget, "SAMPLES", 120)
    found = budget.measure_budget(OWN["error_budget"], FOUR["measurement_covariance"], 1.0, np.radians(0.5))
    for name in ("pixels", "tilt", "both"):
        large = found.predicted[name] > 0.2 * found.predicted["both"]
        assert found.measured[name][large] == pytest.approx(found.predicted[name][large], rel=0.25), name
    alt = budget.draw_budget(found).alt
    assert "pixels: x" in alt and "both: x" in alt
    parts = {"pixels": np.array([1.0, 5.0, 5.0]), "tilt": np.array([2.0, 1.0, 1.0])}
    assert budget.larger_source(budget.Budget(parts, parts)) == "tilt"  # the larger one of the error in x


def test_a_hits_error_is_that_of_the_closest_report():
    scenes = (((np.zeros((9, 9, 3), np.uint8)), np.array([(4.0, 4.0), (90.0, 90.0)])),)
    errors = pixel_errors(lambda picture: np.array([(6.0, 4.0), (5.0, 3.0), (40.0, 40.0)]), scenes)
    assert errors.tolist() == [[1.0, -1.0]]
    assert pixel_errors(lambda picture: np.zeros((0, 2)), scenes).shape == (0, 2)


def test_a_range_is_worth_less_farther_away_and_the_tilt_is_the_larger_part():
    alt = budget.draw_range_budget(FOUR["measurement_covariance"], 2.0).alt
    assert "tilt: 0.04 m at 1 m, 0.15 m at 2 m, 0.59 m at 4 m" in alt
    assert "one degree causes an error of 15 cm at 2 m and of 59 cm at 4 m" in TEXT
    assert 'exactly two degrees the paper\'s "10 - 30 cm" are right only from about 1.1 to 2 m' in TEXT
    height = usual_scene().view.height
    two = [FOUR["range_sigma"](each, height, np.radians(2)) for each in (1.0, 1.1, 1.9, 2.0)]
    assert two[0] < 0.1 < two[1] and two[2] < 0.3 < two[3]


def test_without_pixels_or_a_budget_each_figure_says_what_is_missing():
    missing, covariance = try_out(blank, "Finish exercise 10.6."), FOUR["measurement_covariance"]
    measured = partial(budget.measure_budget, OWN["error_budget"])
    of_covariance = (budget.draw_range_budget, budget.tell_tilt_left, measured)
    of_covariance = [lambda it, show=show: show(covariance, it) for show in of_covariance]
    for show in (budget.draw_budget, budget.larger_source, *of_covariance):
        assert repr(try_out(lambda show=show: show(missing))) == "Finish exercise 10.6."


@pytest.mark.slow
def test_the_text_says_what_a_sigma_for_each_of_u_and_v_changes():
    find_corners = own("03")["find_corners"]
    errors = pixel_errors(lambda picture: find_corners(label(picture), 5, 40), simulated_scenes())
    u, v = np.sqrt((errors**2).mean(axis=0))
    quotes(TEXT, f"{u:.1f} px in u", f"{errors[:, 0].mean():.1f}", f"{v:.1f} px in v")
    scene, step = usual_scene(), 0.01
    pixels = in_pixels(scene)

    def measured(shift):
        return FOUR["ground_to_measurement"](FOUR["pixel_to_ground"](pixels + shift, scene.view)).ravel()

    by = [(measured(s) - measured(-s)) / (2 * step) for s in (np.array([step, 0]), np.array([0, step]))]
    blocks = np.kron(np.eye(len(pixels)), np.ones((2, 2)))
    tilt = FOUR["measurement_covariance"](pixels, scene.view, 0.0, np.radians(1))
    jacobian = own("05")["measurement_jacobian_pose"]
    H = np.vstack([jacobian(scene.pose, each) for each in scene.landmarks])

    def covariance(sigmas):
        return blocks * sum(sigma**2 * np.outer(each, each) for sigma, each in zip(sigmas, by, strict=True))

    def pixels_part(sigmas, assumed):
        D = covariance(sigmas)
        W = np.linalg.inv(covariance(assumed) + tilt)
        K = np.linalg.inv(H.T @ W @ H) @ H.T @ W
        return np.sqrt(np.diag(K @ D @ K.T)) * [100, 100, np.degrees(1)]

    both = np.sqrt((errors**2).mean())
    for row, sigmas, assumed in (
        (f"one sigma, {both:.1f} px: the budget", (both, both), (both, both)),
        ("your errors, with the weights of the budget", (u, v), (both, both)),
        ("your errors, with weights from both sigmas", (u, v), (u, v)),
    ):
        x, y, heading = pixels_part(sigmas, assumed)
        assert f"| {row} | {x:.1f} cm | {y:.1f} cm | {heading:.1f}° |" in TEXT
    on_the_right = scene.landmarks[[0, 2]]
    assert on_the_right.tolist() == [[3.0, -1.1], [3.0, -0.7]] and "(3, -1.1) and (3, -0.7)" in TEXT
    parts = OWN["error_budget"](scene.pose, on_the_right, scene.view, both, np.radians(1))
    assert {f"{100 * np.sqrt(part[0, 0]):.0f} cm each" for part in parts} == {"24 cm each"}
    quotes(TEXT, "24 cm each", f"{len(errors)} hits")
    drawn = errors[np.random.default_rng(0).integers(0, len(errors), (4000, len(errors)))]
    low, high = np.quantile(np.sqrt((drawn**2).mean(axis=(1, 2))), [0.025, 0.975])
    quotes(TEXT, f"{both:.1f} px", f"{low:.1f} to {high:.1f}")
