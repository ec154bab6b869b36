"""Self-calibration of the camera: a constant offset of pitch and roll is estimated from lines and goals alone."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from benchmarks import RESULTS
from nao_course.field_slam.drives import INSIDE, YAWS
from nao_course.field_slam.known_shapes import calibration
from nao_course.field_slam.known_shapes.calibration import CameraCalibration
from nao_course.field_slam.observation import POST_RADIUS, TILT_SIGMAS, tilted
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, Field
from tests.field_slam.test_compass import lines_in
from tests.field_slam.test_observation import HEAD_PITCH
from tests.paths import PROJECT

FIELD = Field(2012)
OFFSETS = [(8.0, 3.0), (-8.0, -3.0), (4.0, -2.0)]  # degrees


def pictures(seed, number, offset=(0.0, 0.0)):
    """Return lines and posts as a camera with an offset (degrees) sees them, and the view by the joints."""
    rng = np.random.default_rng(seed)
    pitch, roll = np.radians(offset)
    found = []
    while len(found) < number:
        pose = Pose(*rng.uniform(*INSIDE), rng.uniform(-np.pi, np.pi))
        joints = replace(NAO_V4.view("bottom", rng.choice(YAWS), HEAD_PITCH), k1=0.0)
        mounted = replace(joints, pitch=joints.pitch + pitch, roll=joints.roll + roll)
        true = tilted(mounted, *rng.normal(0, TILT_SIGMAS))
        lines = lines_in(true, pose)
        if len(lines) < 2:
            continue
        bearings = FIELD.posts - pose.as_array()[:2]
        feet = FIELD.posts - POST_RADIUS * bearings / np.linalg.norm(bearings, axis=1, keepdims=True)
        posts = true.project(feet, pose)
        posts = posts[true.contains(posts)]
        lines += rng.normal(0, 0.25, lines.shape)
        found.append((lines, posts + rng.normal(0, 0.7, posts.shape), joints))
    return found


def calibrated(seed, number, offset):
    own = CameraCalibration()
    for each in pictures(seed, number, offset):
        own.update(*each)
    return own


def squared_error(own, offset):
    error = own.mean - np.radians(offset)
    return float(error @ np.linalg.solve(own.covariance, error))


@pytest.mark.parametrize("offset", OFFSETS)
def test_an_offset_is_found_within_its_stated_covariance(offset):
    own = calibrated(1, 25, offset)
    assert squared_error(own, offset) < chi2.ppf(0.99, 2)
    assert np.degrees(np.sqrt(np.diag(own.covariance))).max() < 0.6
    assert np.degrees(own.mean) == pytest.approx(offset, abs=1.0)


@pytest.mark.slow
def test_the_errors_of_many_calibrations_agree_with_their_covariance():
    runs = 24
    offsets = np.random.default_rng(3).uniform((-8, -3), (8, 3), (runs, 2))
    nees = [squared_error(calibrated(seed, 12, offset), offset) for seed, offset in enumerate(offsets)]
    low, high = chi2.ppf((0.0005, 0.9995), 2 * runs) / runs
    # An estimate may be a little modest, because it contains an error that simulated pictures do not have.
    assert low / 2 < np.mean(nees) < high


def test_a_wrong_or_empty_picture_does_not_pull_the_offset_and_a_goal_alone_gives_the_pitch():
    offset = (5.0, -1.0)
    own = calibrated(2, 20, offset)
    before, sigmas = own.mean, np.sqrt(np.diag(own.covariance))
    other = pictures(8, 1, (0.5, -1.0))
    for each in other:
        own.update(*each)
    assert np.abs(own.mean - before).max() < 0.5 * sigmas.max()
    alone = CameraCalibration()
    for each in other:
        alone.update(*each)
    assert np.degrees(alone.mean[0]) < 2.5  # so the picture does show something else
    own = calibrated(4, 5, (2.0, 1.0))
    mean, covariance = own.mean, own.covariance
    own.update(np.zeros((0, 4)), np.zeros((0, 2)), NAO_V4.view("bottom", 0.3, HEAD_PITCH))
    assert np.allclose(own.mean, mean, atol=1e-4) and np.allclose(own.covariance, covariance, rtol=0.02)
    own, view = CameraCalibration(), replace(NAO_V4.view("bottom", 0.0, HEAD_PITCH), k1=0.0)
    lower = replace(view, pitch=view.pitch + np.radians(6.0))
    feet = lower.project([[2.95, 0.69], [2.95, -0.69]], Pose(-0.5, 0.0, 0.0))
    own.update(np.zeros((0, 4)), feet, view)
    assert np.degrees(own.mean[0]) == pytest.approx(6.0, abs=1.2)
    assert np.sqrt(own.covariance[0, 0]) < 0.7 * calibration.PRIOR_SIGMAS[0]


def test_the_offset_turns_with_the_head_and_the_view_for_reading_approaches_the_calibrated_one():
    own = CameraCalibration((0.05, 0.01), (0.02, 0.02))
    ahead, left = (own.tilt_covariance(NAO_V4.view("bottom", yaw, HEAD_PITCH)) for yaw in (0.0, np.pi / 2))
    assert np.allclose(np.diag(ahead), np.diag(left)[::-1], rtol=1e-6) and ahead[0, 0] > 2 * ahead[1, 1]
    view = NAO_V4.view("bottom", 0.0, HEAD_PITCH)
    own = CameraCalibration()
    lower = own.reading_view(view).pitch - view.pitch
    assert lower == pytest.approx(2 * calibration.PRIOR_SIGMAS[0], rel=0.05)
    own = calibrated(1, 25, (4.0, -2.0))
    corrected = own.corrected(view)
    assert np.degrees([corrected.pitch - view.pitch, corrected.roll]) == pytest.approx((4.0, -2.0), abs=0.8)
    assert own.is_certain and not CameraCalibration().is_certain
    assert 0 < own.reading_view(view).pitch - own.corrected(view).pitch < np.radians(1.2)


def test_the_docs_state_how_well_simulated_cameras_are_calibrated():
    found = json.loads((RESULTS / "calibration.json").read_text(encoding="utf-8"))
    docs = (PROJECT / "docs" / "real_data.md").read_text(encoding="utf-8")
    keys = ("pitch rms", "roll rms", "pitch sigma", "roll sigma", "NEES mean")
    for number, row in found["after"].items():
        assert f"| {number} | {' | '.join(f'{row[key]:.2f}' for key in keys)} |" in docs
    low, high = found["NEES band"]
    assert f"lies between {low:.2f} and {high:.2f}" in docs
    assert all(low / 1.01 < row["NEES mean"] < high for one, row in found["after"].items() if one != "1")
