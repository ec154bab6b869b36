"""The equations of lesson 10 are what its code computes."""

from itertools import product

import numpy as np
import pytest

from nao_course.lessons.experiments.budget import in_pixels, usual_scene
from tests.lessons.every import own
from tests.lessons.experiments.own import OWN

FOUR, FIVE = own("04"), own("05")


@pytest.mark.asserts("eq-10-1")
@pytest.mark.parametrize(("hits", "false", "missed"), list(product((0, 1, 3), (0, 2), (0, 1, 4))))
def test_a_cost_is_the_sum_of_table_6_1(hits, false, missed):
    truth = np.array([(50.0 * i, 100.0) for i in range(hits + missed)]).reshape(-1, 2)
    wrong = np.array([(50.0 * i, 200.0) for i in range(false)]).reshape(-1, 2)
    detected = np.vstack([truth[:hits] + 1.0, wrong])
    cost = OWN["detection_cost"](detected, truth, 8.0)
    assert cost == pytest.approx(-1.333 * hits + 5 * false + missed)


@pytest.mark.asserts("eq-10-2")
def test_at_the_paying_precision_reporting_costs_what_keeping_quiet_does(rng):
    assert OWN["paying_precision"](-1.333, 5.0, 1.0) == pytest.approx(5 / 7.333)
    for hit, false, missed in rng.uniform((-3, 1, 0), (0, 9, 3), (20, 3)):
        p = OWN["paying_precision"](hit, false, missed)
        assert p * hit + (1 - p) * false == pytest.approx(p * missed)


@pytest.mark.asserts("eq-10-3")
def test_a_mean_is_found_possible_with_the_hits_that_give_it_and_with_no_others(rng):
    for _ in range(200):
        pictures, hits, others = int(rng.integers(1, 60)), int(rng.integers(0, 90)), int(rng.integers(0, 300))
        printed = round((others - 1.333 * hits) / pictures, 3)
        assert hits in OWN["possible_hits"](printed, pictures, 90)
    for mean in (2.122, 4.223, 5.002):
        for hits in OWN["possible_hits"](mean, 30, 240):
            others = round(30 * mean + 1.333 * hits)
            assert abs((others - 1.333 * hits) / 30 - mean) <= 0.0005 + 1e-9


@pytest.mark.asserts("eq-10-4", "eq-10-5")
def test_both_parts_of_the_budget_add_up_to_the_covariance_of_weighted_least_squares():
    scene = usual_scene()
    parts = OWN["error_budget"](scene.pose, scene.landmarks, scene.view, 2.0, 0.0175)
    R = FOUR["measurement_covariance"](in_pixels(scene), scene.view, 2.0, 0.0175)
    H = np.vstack([FIVE["measurement_jacobian_pose"](scene.pose, each) for each in scene.landmarks])
    P = np.linalg.inv(H.T @ np.linalg.inv(R) @ H)
    assert np.allclose(parts[0] + parts[1], P, rtol=1e-6)
    for part in parts:
        assert np.allclose(part, part.T) and np.linalg.eigvalsh(part).min() > -1e-12
    pixels, tilt = OWN["error_budget"](scene.pose, scene.landmarks, scene.view, 2.0, 0.0)
    assert np.allclose(tilt, 0.0) and np.trace(pixels) > 0
