"""Several hypotheses about the association: their likelihoods, when they appear, and how they are decided."""

from copy import deepcopy

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from nao_course.field_slam import likelihood as model
from nao_course.field_slam.compass import wrap_quarter
from nao_course.field_slam.hypotheses import MOST, Hypothesis, MultipleHypotheses, without
from nao_course.field_slam.joint_update import JointUpdate
from nao_course.field_slam.likelihood import compass_log_densities, landmark_log_densities, line_log_densities
from nao_course.field_slam.line_observation import LineObservation
from nao_course.field_slam.observation import observation
from nao_course.geometry import Pose
from nao_course.slam import Measurement, Motion, range_and_bearing

START, CORNERS = Pose(0.0, 0.0, 0.0), ((2.0, -0.6), (2.0, 0.6), (3.0, 1.5), (3.0, -1.5))
TWIN = (2.0, 0.95)  # a corner that is not on the map, near a corner of the map
STEP = Motion(0.3, 0.0)


def seen_from(pose: Pose, corners=CORNERS, compass=float("inf"), lines=()) -> LineObservation:
    """Return what a robot without errors sees, with the stated covariance."""
    found = [Measurement(*range_and_bearing(pose.as_array(), at), "corner") for at in corners]
    direction = float(wrap_quarter(-pose.theta))
    seen = observation(found, (1e-3, 1e-3), direction=direction, direction_sigma=compass)
    lines = np.array([[*line, 0.0, 0.0] for line in lines]).reshape(-1, 5)
    return LineObservation(seen.measurements, seen.covariance, direction, compass, seen.tilt, lines=lines)


@pytest.fixture
def joint(jointly):
    return JointUpdate(jointly(START))


other = alone = joint  # a second filter like the first


def test_the_gaussian_log_density_is_scipys_and_densities_integrate_to_what_they_stand_for(rng):
    root = rng.normal(size=(4, 4))
    S, nu = root @ root.T + np.eye(4), rng.normal(size=4)
    assert model.gaussian_log_density(nu, S) == pytest.approx(multivariate_normal(np.zeros(4), S).logpdf(nu))
    assert model.gaussian_log_density(np.zeros(0), np.zeros((0, 0))) == 0.0
    angles = np.linspace(-np.pi / 4, np.pi / 4, 20001)
    each = np.exp([compass_log_densities(float(at), 0.03**2) for at in angles])
    assert np.trapezoid(each[:, 0], angles) == pytest.approx(1.0, abs=1e-3)
    assert np.trapezoid(each[:, 1], angles) == pytest.approx(0.01, abs=1e-3)
    # The expected number of unexplained corners within r is the density times the area of the disc.
    ranges = np.linspace(1e-3, 2.0, 2001)
    of_range = [
        np.exp(landmark_log_densities(observation([Measurement(0.0, float(r), "corner")]), [False])[0])
        for r in ranges
    ]
    assert 2 * np.pi * np.trapezoid(of_range, ranges) == pytest.approx(
        model.CLUTTER["corner"] * np.pi * 2.0**2, rel=1e-3
    )


def test_the_likelihood_of_the_rest_of_a_picture_is_of_a_filter_that_never_saw_the_ignored_part(joint, other):
    line = (2.0, 0.3, np.pi / 2)
    for each in (joint, other):
        each.observe(seen_from(START, compass=0.01, lines=[line]))
        each.move(STEP)
    there = Pose(0.3, 0.01, 0.005)
    second = seen_from(there, compass=0.01, lines=[(1.69, 0.3, np.pi / 2)])
    joint.observe(second)
    other.observe(without(second, ["landmarks"]))
    likelihood = joint.likelihood
    assert set(likelihood.parts) == {"landmarks", "lines"}
    assert likelihood.log_density(["landmarks"]) == pytest.approx(
        other.likelihood.log_density() + likelihood.ignored(["landmarks"]), abs=1e-6
    )
    assert likelihood.log_density() > likelihood.log_density(["landmarks"])


def test_clear_pictures_keep_one_hypothesis_which_is_the_filter_itself(joint, alone):
    many, pose = MultipleHypotheses(joint), START
    for each in (many, alone):
        pose = START
        for _ in range(4):
            each.observe(seen_from(pose))
            each.move(STEP)
            pose = pose @ STEP.as_pose()
    many.observe(seen_from(pose))
    alone.observe(seen_from(pose))
    assert len(many.hypotheses) == 1
    assert np.allclose(many.estimate().pose.as_array(), alone.estimate().pose.as_array(), atol=1e-9)
    assert np.allclose(many.estimate().covariance, alone.estimate().covariance, atol=1e-12)


def lost_by_a_twin(slam) -> Pose:
    """Let a robot see a corner beside one of its map while its position is uncertain; return the true pose."""
    slam.observe(seen_from(START))
    for each in getattr(slam, "hypotheses", [(0.0, slam)]):
        each[1].inner.covariance[1, 1] += 0.15**2  # it may have slid sideways
    pose = START
    for _ in range(4):
        slam.move(Motion(-0.3, 0.0))
        pose = pose @ Pose(-0.3, 0.0, 0.0)
    slam.observe(seen_from(pose, [TWIN], compass=0.005))
    return pose


def test_a_wrong_association_is_taken_back_when_later_pictures_contradict_it(joint, alone):
    many = MultipleHypotheses(joint)
    pose = lost_by_a_twin(alone)
    lost_by_a_twin(many)
    assert len(many.hypotheses) > 1
    # The position is uncertain as long as there is more than one hypothesis.
    assert many.estimate().covariance[1, 1] > 2 * alone.estimate().covariance[1, 1]
    for each in (alone, many):
        each.observe(seen_from(pose, CORNERS[:3], compass=0.005))
    assert many.estimate().pose.as_array() == pytest.approx(pose.as_array(), abs=0.03)
    assert np.hypot(*alone.estimate().pose.as_array()[:2] - pose.as_array()[:2]) > 0.1


def test_a_turn_that_is_wrong_by_more_than_the_compass_can_tell_is_recognised_by_the_landmarks(joint, alone):
    many, true = MultipleHypotheses(joint), Pose(0.0, 0.0, 1.7)
    for each in (many, alone):
        each.observe(seen_from(START))
        # Wrong by 48 degrees, so the nearest heading of the compass is wrong by 90.
        each.move(Motion(0.0, 0.87))
        for _ in range(2):
            each.observe(seen_from(true, compass=0.01))
    assert alone.estimate().pose.theta == pytest.approx(true.theta - np.pi / 2, abs=0.05)
    assert many.estimate().pose.as_array() == pytest.approx(true.as_array(), abs=0.02)
    assert many.best.odometry.factor > 1.5


def test_the_odds_of_ignoring_landmarks_are_those_of_the_likelihoods(joint):
    """They would be twice as large if ignoring landmarks and absent lines counted as another hypothesis."""
    many = MultipleHypotheses(joint, most=20)
    many.observe(seen_from(START))
    many.best.inner.covariance[:3, :3] += np.diag([0.02, 0.15, 0.01]) ** 2
    second = seen_from(START, [TWIN], compass=0.005)
    used, ignoring = deepcopy(many.best), deepcopy(many.best)
    used.observe(second)
    ignoring.observe(without(second, ["landmarks"]))
    expected = used.likelihood.log_density() - used.likelihood.log_density(["landmarks"])
    many.observe(second)
    odds = []
    for of in (used, ignoring):
        alike = (each for each in many.hypotheses if np.allclose(each.slam.inner.state, of.inner.state))
        odds.append(next(alike).log_probability)
    assert odds[0] - odds[1] == pytest.approx(expected, abs=0.01)


def test_probabilities_add_up_and_no_more_than_the_most_are_kept(joint):
    many = MultipleHypotheses(joint)
    pose = lost_by_a_twin(many)
    for offset in (0.0, 0.1, 0.2):
        many.observe(seen_from(pose, [(TWIN[0], TWIN[1] + offset)], compass=0.005))
        total = sum(np.exp(each.log_probability) for each in many.hypotheses)
        assert total == pytest.approx(1.0)
        assert 1 <= len(many.hypotheses) <= MOST
        probabilities = [each.log_probability for each in many.hypotheses]
        assert probabilities == sorted(probabilities, reverse=True)


def test_what_is_ignored_counts_whether_or_not_the_map_explains_it_and_without_leaves_the_rest():
    seen = seen_from(START, compass=0.01, lines=[(1.0, 0.0, 0.0)])
    assert len(without(seen, ["landmarks"])) == 0 and len(without(seen, ["landmarks"]).lines) == 1
    assert len(without(seen, ["lines"])) == 4 and len(without(seen, ["lines"]).lines) == 0
    assert np.isinf(without(seen, ["compass", "lines"]).direction_sigma)
    plain = observation([], direction_sigma=0.1)
    assert without(plain, ["lines"]) is plain
    seen = seen_from(START)
    for explained in ([True] * 4, [False] * 4):
        used, ignored = landmark_log_densities(seen, explained)
        assert (used == 0.0) == explained[0]
        assert ignored == pytest.approx(
            landmark_log_densities(seen, [False] * 4)[0] + 4 * np.log(model.IGNORED)
        )
    assert line_log_densities(2, 1, 2, 1)[0] == 0.0 > line_log_densities(2, 1, 1, 1)[0]
    assert compass_log_densities(0.1, float("inf")) == (0.0, 0.0)
    line, circle = (model.IGNORED * model.CLUTTER[kind] for kind in ("line", "centre"))
    expected = 2 * np.log(line) + np.log(circle)
    assert line_log_densities(2, 1, 2, 1)[1] == pytest.approx(expected)


def test_the_second_nearest_heading_of_the_compass_is_a_quarter_turn_away(joint):
    joint.observe(seen_from(START))
    joint.move(Motion(0.0, 0.87))
    joint.observe(seen_from(Pose(0.0, 0.0, 1.7), corners=[], compass=0.01), quarter=1)
    assert joint.inner.state[2] == pytest.approx(1.7, abs=0.02)
    assert joint.likelihood.other_heading[0] == -1


def moved(slam, x):
    """Return a copy of a filter whose position differs by x, with a standard deviation of 1 cm."""
    copy = deepcopy(slam)
    copy.inner.state = copy.inner.state + np.array([x, 0.0, 0.0])
    copy.inner.covariance = 1e-4 * np.eye(3)
    return copy


def test_the_pose_covariance_contains_the_distance_of_the_hypotheses_and_equal_ones_are_merged(joint):
    many, half = MultipleHypotheses(joint), float(np.log(0.5))
    many.hypotheses = [Hypothesis(half, moved(joint, 0.0)), Hypothesis(half, moved(joint, 0.4))]
    assert many.estimate().covariance[0, 0] == pytest.approx(1e-4 + 0.5 * 0.4**2)
    three = [Hypothesis(float(np.log(p)), moved(joint, x)) for p, x in ((0.4, 0.4), (0.3, 0.0), (0.3, 1e-4))]
    kept = many._most_probable(three)
    assert np.exp([each.log_probability for each in kept]) == pytest.approx([0.6, 0.4])


def test_a_reading_halfway_between_two_headings_keeps_both(joint):
    joint.inner.covariance = np.diag([1e-4, 1e-4, 0.4**2])
    many = MultipleHypotheses(joint)
    many.observe(seen_from(Pose(0.0, 0.0, 0.75), corners=[], compass=0.01))
    headings = sorted(each.slam.inner.state[2] for each in many.hypotheses)
    assert headings[0] == pytest.approx(0.75 - np.pi / 2, abs=0.01)
    assert headings[-1] == pytest.approx(0.75, abs=0.01)
