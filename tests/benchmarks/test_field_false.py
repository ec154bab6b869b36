"""False corners and the two localizations on the known map: what they must satisfy without any tuning."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.field.field_false import BOX, PIXEL, sources, with_false_corners
from benchmarks.field.known_map import KINDS, PLACES, GatedEkf, MonteCarlo, kld_bound
from benchmarks.field.variants import Read
from nao_course.field_slam.compass import BodyTilt
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.field_slam.observation import observation
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, Field
from nao_course.slam import Measurement, Motion, range_and_bearing

VIEW = NAO_V4.view("bottom", 0.0, float(np.radians(-31)))
START = Pose(0.5, 0.3, 0.2)
MOTION = Motion(0.2, 0.3)


def drive(pictures: int, pose: Pose = START) -> list[Read]:
    """Return pictures of a robot that stands still, with two corners each."""
    seen = SimpleNamespace(true_view=VIEW, pose=pose)
    corners = np.array([(100.0, 150.0), (200.0, 120.0)])
    return [Read(seen, BodyTilt(0, 0, 0, np.eye(3)), VIEW, corners) for _ in range(pictures)]


def everything(pose: Pose) -> list[Measurement]:
    """Return exact measurements of all landmarks."""
    polar = range_and_bearing(pose.as_array(), PLACES).tolist()
    return [Measurement(*each, kind) for each, kind in zip(polar, KINDS.tolist(), strict=True)]


def test_the_number_of_particles_is_foxs_bound():
    # By hand for 101 bins, with z = 2.32635: 100 / 0.1 * (1 - 2/900 + sqrt(2/900) * 2.32635)^3
    assert kld_bound(101) == pytest.approx(1000 * (1 - 0.0022222 + 0.0471405 * 2.32635) ** 3, rel=1e-4)
    assert kld_bound(101) == pytest.approx(1358.2, abs=0.1)
    assert kld_bound(1) == 1 and (np.diff(kld_bound(np.arange(2, 50))) > 0).all()


def test_without_false_corners_a_drive_is_unchanged_and_otherwise_has_the_rate():
    reads = drive(600)
    assert all(
        np.array_equal(old.corners, new.corners)
        for old, new in zip(reads, with_false_corners(reads, 0.0, 5), strict=True)
    )
    found = with_false_corners(reads, 2.0, 5)
    added = [each.corners[2:] for each in found]
    assert np.mean([len(each) for each in added]) == pytest.approx(2.0, abs=0.2)
    pixels = np.vstack(added)
    assert ((pixels > BOX[0] - 4 * np.array(PIXEL)) & (pixels < BOX[1] + 4 * np.array(PIXEL))).all()
    again = with_false_corners(reads, 2.0, 5)
    assert all(np.array_equal(one.corners, other.corners) for one, other in zip(found, again, strict=True))


def test_false_corners_of_a_source_are_seen_again_at_the_same_place():
    added = np.vstack([each.corners[2:] for each in with_false_corners(drive(60), 3.0, 1)])
    _, papers, neighbours = sources(np.random.default_rng([1, 41]), 20)[0]
    low, high = np.array([Field(2012).x_range, Field(2012).y_range]).T
    assert ((papers > low) & (papers < high)).all() and not ((neighbours > low) & (neighbours < high)).all(
        1
    ).any()
    pixels = VIEW.project(np.vstack([papers, neighbours]), START)
    again = np.hypot(*(added[:, None] - pixels).transpose(2, 0, 1)) < 4 * PIXEL
    assert again.sum(axis=0).max() > 10


def test_localizations_with_exact_measurements_end_at_the_true_pose():
    quiet = OdometryNoisePerMove(factor=1e-3)
    for make in (GatedEkf, lambda start: MonteCarlo(start, quiet, least=3000)):
        pose, algorithm = START, make(START)
        for _ in range(6):
            pose = pose @ MOTION.as_pose()
            algorithm.move(MOTION)
            algorithm.observe(observation(everything(pose), direction=-pose.theta, direction_sigma=0.01))
        found = algorithm.estimate().pose
        assert np.hypot(found.x - pose.x, found.y - pose.y) < 0.01
        assert abs(found.theta - pose.theta) < 0.01


def test_particles_that_are_carried_away_are_drawn_anew_and_find_the_true_pose():
    algorithm, pose = MonteCarlo(START), replace(START, x=2.0, y=-1.0, theta=2.0)
    for number in range(60):
        at = START if number < 5 else pose
        algorithm.observe(observation(everything(at), direction=-at.theta, direction_sigma=0.01))
    found = algorithm.estimate().pose
    assert np.hypot(found.x - pose.x, found.y - pose.y) < 0.05


def test_a_first_picture_that_fits_nothing_leaves_the_particles_where_they_are():
    algorithm = MonteCarlo(START)
    algorithm.observe(observation([Measurement(0.0, 0.01, "post")], tilt=(1e-6, 1e-6)))
    assert algorithm.slow == 0 and algorithm.estimate().pose.x == pytest.approx(START.x, abs=0.01)
