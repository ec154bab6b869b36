"""Lesson 06's filter on whole drives: exact without noise, consistent with it, and always with a valid covariance."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.lessons.localization.consistency import inside_naive_band, nees_by_step, nis_by_step
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
from tests.lessons.every import quotes, text
from tests.lessons.localization.test_equations import short_form


def in_bands(traces):
    """Return the percentages of the steps whose mean NEES and NIS are in their bands, and the mean NEES."""
    nees, (_, nis, counts) = nees_by_step(traces), nis_by_step(traces)
    (low, high), limits = band(3, len(traces)), np.array([band(2, int(count)) for count in counts])
    inside = (low <= nees) & (nees <= high), (limits[:, 0] <= nis) & (nis <= limits[:, 1])
    return *(round(100 * each.mean()) for each in inside), round(nees.mean(), 2)


def without_noise(rng):
    """A drive without any error, and the covariances of one with."""
    exact = make_drive(rng, odometry=OdometryNoise(0, 0, 0, 0), sensor=SensorNoise(0, 0))
    start, *steps = exact.steps
    given = [
        replace(
            step,
            control_covariance=OdometryNoise().covariance(step.motion),
            covariances=SensorNoise().covariances(step.measurements),
        )
        for step in steps
    ]
    return replace(exact, steps=(start, *given))


def test_without_noise_the_estimate_is_the_truth_and_a_wrong_start_is_forgotten(filter_of, rng):
    drive = without_noise(rng)
    trace = follow(drive, *filter_of)
    assert len(trace.nis) > 60
    assert np.abs(trace.errors).max() < 1e-9 and np.abs(trace.innovations).max() < 1e-9
    errors = follow(drive, *filter_of, error=(0.1, -0.1, 0.05)).errors
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


@pytest.mark.parametrize(("drives", "part"), [(10, 0.85), pytest.param(100, 0.9, marks=pytest.mark.slow)])
def test_nees_and_nis_are_in_their_bands_and_as_the_lesson_says(filter_of, drives, part):
    traces = follow_many(range(drives), *filter_of)
    low, high = band(3, drives)
    nees = np.mean([trace.nees for trace in traces], axis=0)
    assert np.mean((low <= nees) & (nees <= high)) > part
    nis = np.concatenate([trace.nis for trace in traces])
    lowest, highest = band(2, len(nis))
    assert lowest < nis.mean() < highest
    if drives == 100:
        assert (round(nees.mean(), 2), round(nis.mean(), 2)) == (2.97, 2.00)
        assert in_bands(traces) == (100, 97, 2.97)
        assert round(100 * inside_naive_band(traces)) == 78
        quotes(text("06"), "2.97", "2.00", "97 %", "78")


def test_the_short_form_breaks_where_the_lesson_says_and_josephs_does_not(own):
    joseph = own["kalman_update"]
    for sigma in SIGMAS:
        said = [as_written(smallest_eigenvalue(each, sigma)) for each in (short_form, joseph)]
        assert f"| {sigma:.8f} | ".replace("0000000 |", " |").split(" |")[0].rstrip("0") in text("06")
        assert f"| {said[0]} | {said[1]} |" in text("06")
    assert eigenvalue_table(joseph).rows[-1] == ("1e-08", said[1])

    def single(update):
        return lambda *given: tuple(
            np.float32(value) for value in update(*(np.asarray(each, dtype=np.float32) for each in given))
        )

    assert smallest_eigenvalue(single(short_form), 0.01) > 0 > smallest_eigenvalue(single(short_form), 0.001)
    assert smallest_eigenvalue(single(joseph), 0.001) > 0 and smallest_eigenvalue(single(joseph), 0.0001) > 0


def test_a_drive_sees_what_is_near_and_before_it_and_an_answer_of_another_shape_is_said_in_words(filter_of):
    posts = [tuple(each) for each, kind in zip(LANDMARKS.tolist(), KINDS, strict=True) if kind == "post"]
    assert posts == [tuple(each) for each in Field(2012).posts.tolist()] and len(LANDMARKS) == 10
    drive, error = lap(3)
    assert drive is lap(3)[0] and error.shape == (3,)
    for step in drive.steps[1:]:
        seen = range_and_bearing(step.pose, LANDMARKS)
        near = (np.abs(seen[:, 0]) <= np.radians(60)) & (seen[:, 1] <= REACH)
        assert step.numbers.tolist() == np.flatnonzero(near).tolist()
    _, predict_pose, predict_covariance = filter_of
    drive, _ = lap(0)
    for nonsense, words in (
        (lambda *given: None, "must return \\(pose, covariance\\)"),
        (lambda *given: (np.zeros(2), np.eye(3)), "localize: pose must have shape"),
    ):
        with pytest.raises(ValueError, match=words):
            follow(drive, nonsense, predict_pose, predict_covariance)


@pytest.mark.slow
@pytest.mark.parametrize("first", [100, 200, 300, 400, 1000, 2000, 3000])
def test_with_other_seeds_the_steps_are_in_their_bands_and_too_few_drives_are(filter_of, first):
    traces = follow_many(range(first, first + 100), *filter_of)
    assert 70 <= round(100 * inside_naive_band(traces)) <= 85
    *inside, nees = in_bands(traces)
    assert min(inside) >= 83 and 2.97 <= nees <= 3.12
