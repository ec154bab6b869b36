"""Lesson 06's filter on whole drives: exact without noise, consistent with it, and always with a valid covariance."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.lessons.localization.consistency import inside_naive_band
from nao_course.lessons.localization.drives import (
    KINDS,
    LANDMARKS,
    REACH,
    follow,
    follow_many,
    lap,
    make_drive,
)
from nao_course.lessons.localization.forms import SIGMAS, as_written, eigenvalue_table, smallest_eigenvalue
from nao_course.metrics import band
from nao_course.sim import Field, OdometryNoise, SensorNoise
from nao_course.slam import range_and_bearing
from tests.lessons.localization.test_equations import short_form
from tests.paths import SOLUTIONS


def without_noise(rng):
    """A drive without any error, and the covariances of one with."""
    exact = make_drive(rng, odometry=OdometryNoise(0, 0, 0, 0), sensor=SensorNoise(0, 0))
    odometry, sensor = OdometryNoise(), SensorNoise()
    start, *steps = exact.steps
    given = [
        replace(
            step,
            control_covariance=odometry.covariance(step.motion),
            covariances=sensor.covariances(step.measurements),
        )
        for step in steps
    ]
    return replace(exact, steps=(start, *given))


def test_without_noise_the_estimate_is_the_truth_over_a_whole_drive(filter_of, rng):
    trace = follow(without_noise(rng), *filter_of)
    assert len(trace.nis) > 60
    assert np.abs(trace.errors).max() < 1e-9 and np.abs(trace.innovations).max() < 1e-9


def test_without_noise_a_wrong_start_is_forgotten(filter_of, rng):
    errors = follow(without_noise(rng), *filter_of, error=(0.1, -0.1, 0.05)).errors
    assert np.abs(errors[0]).max() == pytest.approx(0.1) and np.abs(errors[-1]).max() < 0.01


@pytest.mark.parametrize("steps", [500, pytest.param(10_000, marks=pytest.mark.slow)])
def test_a_covariance_is_symmetric_and_positive_after_many_steps(own, report, rng, steps):
    pose, covariance = np.array([1.0, 0.0, 0.0]), np.diag([0.1, 0.1, 0.05])
    noise = np.diag([1e-6, 1e-6, 1e-6])
    for step in range(steps):
        landmark = LANDMARKS[step % len(LANDMARKS)]
        covariance = report["predict_covariance"](covariance, pose, np.array([0.01, 0.3]), noise)
        measured = range_and_bearing(pose, landmark) + rng.normal(size=2) * (0.026, 0.05)
        pose, covariance = own["localize"](pose, covariance, measured, landmark, np.diag([0.026**2, 0.05**2]))
    assert np.abs(covariance - covariance.T).max() < 1e-12 * covariance.max()
    assert np.linalg.eigvalsh(covariance).min() > 0


def test_over_a_few_drives_nees_and_nis_are_in_their_bands(filter_of):
    traces = follow_many(range(10), *filter_of)
    low, high = band(3, 10)
    nees = np.mean([trace.nees for trace in traces], axis=0)
    assert np.mean((low <= nees) & (nees <= high)) > 0.85
    nis = np.concatenate([trace.nis for trace in traces])
    low, high = band(2, len(nis))
    assert low < nis.mean() < high


@pytest.mark.slow
def test_over_a_hundred_drives_nees_and_nis_are_in_their_bands_as_the_lesson_says(filter_of):
    traces = follow_many(range(100), *filter_of)
    low, high = band(3, 100)
    nees = np.mean([trace.nees for trace in traces], axis=0)
    assert np.mean((low <= nees) & (nees <= high)) > 0.9 and low < nees.mean() < high
    nis = np.concatenate([trace.nis for trace in traces])
    low, high = band(2, len(nis))
    assert low < nis.mean() < high
    assert (round(nees.mean(), 2), round(nis.mean(), 2)) == (2.97, 2.00)
    assert round(100 * inside_naive_band(traces)) == 78


def test_the_short_form_breaks_where_the_lesson_says_and_josephs_does_not(own):
    text = (SOLUTIONS / "06_localization.md").read_text(encoding="utf-8")
    for sigma in SIGMAS:
        cells = [smallest_eigenvalue(each, sigma) for each in (short_form, own["kalman_update"])]
        said = list(map(as_written, cells))
        assert f"| {sigma:.8f} | ".replace("0000000 |", " |").split(" |")[0].rstrip("0") in text
        assert f"| {said[0]} | {said[1]} |" in text
    assert eigenvalue_table(own["kalman_update"]).rows[-1] == ("1e-08", said[1])


def test_in_single_precision_the_short_form_breaks_at_a_millimetre_and_josephs_does_not(own):
    def single(update):
        return lambda *given: tuple(
            np.float32(value) for value in update(*(np.asarray(each, dtype=np.float32) for each in given))
        )

    joseph = own["kalman_update"]
    assert smallest_eigenvalue(single(short_form), 0.01) > 0 > smallest_eigenvalue(single(short_form), 0.001)
    assert smallest_eigenvalue(single(joseph), 0.001) > 0 and smallest_eigenvalue(single(joseph), 0.0001) > 0


def test_the_map_is_the_fields_corners_and_posts():
    posts = [tuple(each) for each, kind in zip(LANDMARKS.tolist(), KINDS, strict=True) if kind == "post"]
    assert posts == [tuple(each) for each in Field(2012).posts.tolist()] and len(LANDMARKS) == 10


def test_a_drive_sees_what_is_near_and_before_it_and_is_the_same_again():
    drive, error = lap(3)
    again, _ = lap(3)
    assert drive is again and error.shape == (3,)
    for step in drive.steps[1:]:
        seen = range_and_bearing(step.pose, LANDMARKS)
        near = (np.abs(seen[:, 0]) <= np.radians(60)) & (seen[:, 1] <= REACH)
        assert step.numbers.tolist() == np.flatnonzero(near).tolist()


def test_an_answer_of_another_shape_is_said_in_words(filter_of):
    _, predict_pose, predict_covariance = filter_of
    drive, _ = lap(0)
    for nonsense, words in (
        (lambda *given: None, "must return \\(pose, covariance\\)"),
        (lambda *given: (np.zeros(2), np.eye(3)), "localize: pose must have shape"),
    ):
        with pytest.raises(ValueError, match=words):
            follow(drive, nonsense, predict_pose, predict_covariance)


@pytest.mark.slow
@pytest.mark.parametrize("first", [400, 1000, 2000, 3000])
def test_with_other_seeds_as_many_drives_are_in_the_band_as_the_text_states(filter_of, first):
    traces = follow_many(range(first, first + 100), *filter_of)
    assert 70 <= round(100 * inside_naive_band(traces)) <= 85
