"""Particles of lesson 12: the law of a comb, what a student's functions may return, and FastSLAM without noise."""

import numpy as np
import pytest

from nao_course.lessons.beyond.figures import LAP, START, lap
from nao_course.lessons.beyond.particles import (
    FastSlam,
    chosen,
    effective,
    log_weights,
    normalised,
    run_fast_slam,
    systematic,
    weigh_unnamed,
)
from nao_course.lessons.beyond.worlds import KINDS, LANDMARKS, SENSOR, drive
from nao_course.slam import range_and_bearing

WEIGHTS = np.array([0.5, 0.1, 0.4])
SEEDS = [*range(200), *range(5)]


def judged(function, weights=WEIGHTS):
    answers = [function(weights, np.random.default_rng(seed)) for seed in SEEDS]
    return systematic((weights, SEEDS), {}, answers)


def comb(teeth):
    return lambda weights, rng: np.searchsorted(np.cumsum(weights), teeth(len(weights), rng))


def test_the_lessons_comb_obeys_its_law_whatever_the_weights_and_any_comb_will_do_in_any_order(own, rng):
    for n, peak in ((1, 1.0), (2, 0.3), (7, 1.0), (40, 2.0), (150, 4.0)):
        assert judged(own["resample"], normalised(peak * rng.normal(0, 1, n))) == ""
    assert judged(own["resample"], np.array([0.0, 0.0, 1.0])) == ""
    assert judged(own["resample"], np.full(8, 1 / 8)) == ""

    def from_above(weights, rng):
        n, shift = len(weights), rng.uniform(0, 1 / len(weights))
        return rng.permutation(np.searchsorted(np.cumsum(weights), 1 - np.arange(n) / n - shift))

    assert judged(from_above) == ""


def test_a_wrong_draw_is_described_by_a_particle_and_its_count_and_what_are_no_numbers_of_particles_is_refused():
    assert "; systematic resampling allows" in judged(lambda weights, rng: rng.choice(3, 3, p=weights))
    weights = np.array([0.25, 0.1, 0.3, 0.35])
    stratified = judged(comb(lambda n, rng: (np.arange(n) + rng.random(n)) / n), weights)
    assert stratified.startswith("particle 2 of 4, of weight 0.3, was kept")
    assert stratified.endswith("times; systematic resampling allows 1 or 2")
    assert "times on average, not" in judged(comb(lambda n, rng: (np.arange(n) + 0.5) / n))
    assert "times on average, not" in judged(comb(lambda n, rng: (np.arange(n) + rng.random() / 2) / n))
    other = np.random.default_rng(1)
    assert "same seed" in judged(comb(lambda n, rng: (np.arange(n) + other.random()) / n))
    assert systematic((WEIGHTS, SEEDS), {}, [[0, 1, 2]]) == "there are 1 answers to 205 calls"

    def two_at_once(weights, rng):  # too often, and no particle too rarely
        left = 4 * weights - np.floor(4 * weights)
        return [0, 1, *[rng.choice(4, p=left / 2)] * 2]

    said = judged(two_at_once, np.array([0.4, 0.4, 0.1, 0.1]))
    assert "times; systematic resampling allows" in said and ("3 times;" in said or "2 times;" in said)
    for answer, words in (
        ([0, 1], "3 whole"),
        ([0.0, 1.0, 2.0], "whole numbers"),
        ([0, 1, 3], "from 0 to 2"),
    ):
        with pytest.raises(ValueError, match=words):
            chosen(answer, 3)
        assert words in judged(lambda weights, rng, answer=answer: answer)


def test_weights_sum_to_one_and_a_landmark_without_a_name_weighs_as_the_mean_of_its_kind(rng, own):
    logs = -1000 + rng.normal(0, 1, 30)
    weights = normalised(logs)
    assert np.isclose(weights.sum(), 1) and np.allclose(np.diff(np.log(weights)), np.diff(logs))
    assert effective(np.full(7, 1 / 7)) == pytest.approx(7) and effective(np.array([0, 1.0, 0])) == 1
    assert log_weights([0, -np.inf], 2).dtype == float
    for wrong, said in ((np.zeros(3), r"2 log weights, got shape \(3,\)"), ([0.0, np.nan], "NaN")):
        with pytest.raises(ValueError, match=said):
            log_weights(wrong, 2)
    particles = np.array([[1.5, 0.0, 0.0], [1.0, 0.5, 0.3]])
    seen = range_and_bearing(particles[0], LANDMARKS[KINDS.index("post")])
    logs, R = weigh_unnamed(own["weigh"], particles, "post", seen), SENSOR.covariances(seen[None])[0]
    places = LANDMARKS[[kind == "post" for kind in KINDS]]
    each = [np.exp(own["weigh"](particles, place, seen, R)) for place in places]
    assert np.allclose(np.exp(logs), np.mean(each, axis=0) + 1e-3)


def test_without_noise_every_particle_drives_the_truth_and_maps_it(own, still):
    steps = list(drive(START, lambda: LAP, 12, still))
    slam = FastSlam(START, own["update_particle_landmark"], own["resample"], 4, still)
    run = run_fast_slam(slam, steps)
    assert np.allclose(run.errors, 0, atol=1e-12) and np.allclose(run.nees, 0, atol=1e-9)
    assert np.allclose(slam.poses, steps[-1].pose) and slam.known.sum() >= 5
    assert np.allclose(slam.means[:, slam.known], LANDMARKS[slam.known], atol=1e-9)
    assert np.allclose(slam.paths, np.array([START.as_array(), *(step.pose for step in steps)]))
    assert set(run.ancestors) == {4} and np.allclose(run.effective, 4)


def test_ancestors_never_come_back_and_the_mean_of_headings_is_on_the_circle(own, still):
    asked = []

    def resample(weights, rng):
        asked.append(effective(weights))
        return own["resample"](weights, rng)

    slam = FastSlam(START, own["update_particle_landmark"], resample, 10, np.random.default_rng(3))
    run = run_fast_slam(slam, lap(3, 20))
    assert (np.diff(run.ancestors) <= 0).all() and run.ancestors[-1] < 10
    assert run.paths.shape == (10, 22, 3) and asked and max(asked) < 5
    slam = FastSlam(START, None, None, 2, still)
    slam.poses[:, 2] = (np.pi - 0.1, -np.pi + 0.1)
    belief = slam.belief()
    assert abs(belief.pose[2]) == pytest.approx(np.pi)
    assert belief.covariance[2, 2] == pytest.approx(0.01)
