"""A belief is taken only as pose and covariance that can be one, and scored by its density at the truth."""

import numpy as np
import pytest

from nao_course.challenges import beliefs
from nao_course.geometry import Pose
from nao_course.slam import Estimate, Motion

POSE, GOOD = np.zeros(3), np.eye(3)


@pytest.mark.parametrize("with_map", [False, True])
@pytest.mark.parametrize(
    ("answer", "kind", "words"),
    [
        (None, TypeError, "returns None"),
        (3, TypeError, "two values"),
        ((np.zeros(2), np.eye(2)), ValueError, "shape"),
        ((POSE + np.nan, GOOD), ValueError, "NaN"),
        ((POSE, GOOD * np.nan), ValueError, "NaN"),
        ((POSE, np.triu(np.ones((3, 3)))), ValueError, "not symmetric"),
        ((POSE, np.diag([1.0, 1.0, 0.0])), ValueError, "not positive"),
        ((POSE + 1j, GOOD), TypeError, "complex numbers"),
    ],
)
def test_what_is_no_belief_is_said_in_words(answer, kind, words, with_map):
    with pytest.raises(kind, match=words):
        beliefs.as_belief(answer, with_map)


def test_a_pose_and_an_estimate_are_beliefs_and_a_map_is_left_out_where_there_may_be_one():
    covariance, nothing = np.diag([0.01, 0.04, 0.02]), np.zeros((0, 2))
    estimate = Estimate(Pose(1.0, 2.0, 0.5), covariance, nothing, nothing)
    for answer in ((estimate.pose, covariance), estimate):
        pose, spread = beliefs.as_belief(answer)
        assert np.array_equal(pose, [1.0, 2.0, 0.5]) and np.array_equal(spread, covariance)
    state, covariance = np.append(POSE, [np.nan, 9.0]), np.eye(5)
    pose, spread = beliefs.as_belief((state.tolist(), covariance), with_map=True)
    assert pose.shape == (3,) and spread.shape == (3, 3)
    with pytest.raises(ValueError, match=r"expected \(3,\) and \(3, 3\)"):
        beliefs.as_belief((state, covariance))


def test_bits_are_those_of_gaussian_densities_and_the_end_of_a_drive_is_scored_against_odometry():
    before = POSE, 4 * GOOD
    same = beliefs.score_belief(*before, POSE, before, None)
    assert same.score == 0 and same.columns["NEES"] == 0
    sharper = beliefs.score_belief(POSE, GOOD, POSE, before, None)
    assert sharper.score == pytest.approx(3.0)  # half the sigma in each of three directions
    assert sharper.columns["stated"] == pytest.approx(100 * np.sqrt(2))
    lost = beliefs.score_belief(POSE + (1.0, 0, 0), 1e-6 * GOOD, POSE, before, None)
    assert lost.score == beliefs.DEEPEST and lost.columns == {
        "off": 100.0, "stated": pytest.approx(100 * np.sqrt(2e-6)), "NEES": 1000.0
    }  # fmt: skip
    odometry = POSE + (0.1, 0.0, 0.0), GOOD
    assert beliefs.score_end(odometry, POSE, odometry, "drive").score == pytest.approx(0.0)
    whole = beliefs.score_end((np.append(POSE, [7.0, 7.0]), np.eye(5)), POSE, odometry, "drive")
    assert whole.score > 0 and whole.kept[0] == "drive" and whole.kept[1].shape == (3,)
    assert "NEES should be between 2.3 and 3.8" in beliefs.say_bits(40)


def test_odometrys_covariance_is_that_of_many_drives_with_small_errors(rng):
    motions = [Motion(0.3, 0.6), Motion(0.2, -0.9), Motion(0.4, 0.2)]
    sigmas = 1e-3 * np.array([(3.0, 1.0, 2.0), (1.0, 2.0, 4.0), (2.0, 3.0, 1.0)])
    start, ends = Pose(0.5, -0.2, 0.4), []
    for errors in sigmas * rng.standard_normal((1500, 3, 3)):
        pose = start
        for motion, (along, across, turn) in zip(motions, errors.tolist(), strict=True):
            pose = pose @ Pose(motion.distance + along, across, motion.turn + turn)
        ends.append(pose.as_array())
    last, stated = beliefs.odometry_belief(start, motions, [np.diag(each**2) for each in sigmas])
    assert np.allclose(last, np.mean(ends, axis=0), atol=1e-3)
    scale = np.sqrt(np.outer(np.diag(stated), np.diag(stated)))
    assert np.allclose(np.cov(np.transpose(ends)) / scale, stated / scale, atol=0.12)
