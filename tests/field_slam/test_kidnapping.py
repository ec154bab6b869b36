"""A robot that is carried away: it notices, stays undecided where it has to, and finds its pose on the map again."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal, norm

from nao_course.field_slam.compass import QUARTER, wrap_quarter
from nao_course.field_slam.joint_update import INTERNAL, JointUpdate
from nao_course.field_slam.kidnapping import recovery
from nao_course.field_slam.kidnapping.candidates import Candidates, compass_likelihood
from nao_course.field_slam.kidnapping.recovery import KidnapRecovery
from nao_course.field_slam.known_shapes.circle import Circle
from nao_course.field_slam.likelihood import (
    BEYOND,
    BEYOND_SIGMA,
    CLUTTER,
    DETECTED,
    LEAST_DETECTED,
    LINE_RANGE,
    MAP_SIGMA,
    SEGMENTS,
    KnownMap,
    PositionLikelihood,
)
from nao_course.field_slam.line_observation import LineObservation, StopView
from nao_course.field_slam.observation import observation
from nao_course.field_slam.surest_first import SurestFirst
from nao_course.geometry import Pose, rotation_2d, wrap_angle
from nao_course.sim import Field
from nao_course.slam import Measurement, Motion, range_and_bearing

PLACES = [(mark.x, mark.y, mark.detected_as) for mark in Field(2012).landmarks if mark.detected_as]
# It looks the same after half a turn about the origin.
SYMMETRIC = [
    (sign * x, sign * y, "corner")
    for x, y in ((1.2, 0.5), (0.3, 1.4), (-1.0, 1.1), (1.7, -0.9), (0.5, -1.8))
    for sign in (1, -1)
]
CARRIED_TO = Pose(0.9, 0.3, 1.0)
AROUND = ((-2.0, -2.0), (2.0, 2.0))
LOOP = Motion(0.15, 0.25)  # 25 of these are a circle with a diameter of 1.2 m
START = Pose(1.5, -0.6, 0.0)
STOPS = 27


def pictures(pose: Pose, places=PLACES, farthest=4.0):
    """Return the exact picture of all landmarks within 1.2 rad and some range, and an exact compass."""
    found = []
    for x, y, kind in places:
        bearing, away = range_and_bearing(pose.as_array(), (x, y))
        if abs(bearing) < 1.2 and 0.4 < away < farthest:
            found.append(Measurement(float(bearing), float(away), kind))
    seen = observation(found, (0.01, 0.01), 0.5)
    direction, sigma = float(wrap_quarter(-pose.theta)), float(np.radians(0.5))
    return LineObservation(found, seen.covariance, direction, sigma, seen.tilt, view=(-1.2, 1.2))


def drive(slam, pose: Pose, stops: int, places=PLACES) -> Pose:
    """Drive a circle with odometry that makes no error, and take a picture at each stop."""
    for _ in range(stops):
        slam.move(LOOP)
        pose = pose @ LOOP.as_pose()
        slam.observe(pictures(pose, places))
    return pose


def off(slam, pose: Pose) -> float:
    found = slam.estimate().pose
    return float(np.hypot(found.x - pose.x, found.y - pose.y))


@pytest.fixture
def joint(jointly):
    return lambda start: JointUpdate(jointly(start))


@pytest.fixture
def mapped(joint):
    """Return a robot that has driven a circle and mapped the landmarks around it, and its pose."""

    def make(places=PLACES, start=START, area=recovery.AREA):
        slam = KidnapRecovery(joint(start), area)
        return slam, drive(slam, start, STOPS, places)

    return make


def test_without_noise_nothing_is_noticed_and_the_filter_uses_pictures_as_it_does_without_the_wrapper(joint):
    slam, plain, pose = KidnapRecovery(joint(START)), SurestFirst(joint(START)), START
    for _ in range(60):
        pose = drive(slam, pose, 1)
        plain.move(LOOP)
        plain.observe(pictures(pose))
        assert slam.kidnappings == 0 and not slam.lost
        assert slam.estimate() == plain.estimate()
    assert off(slam, pose) < 1e-3
    slam, alone, pose = KidnapRecovery(joint(START)), SurestFirst(joint(START)), START
    for _ in range(4):
        pose = pose @ LOOP.as_pose()
        exact = pictures(pose)
        for each in (slam, alone):
            each.move(LOOP)
            for sigma, error in ((0.05, 0.03), (0.005, 0.0), (0.02, -0.02)):
                each.observe(replace(exact, direction=exact.direction + error, direction_sigma=sigma))
    assert slam.estimate() == alone.estimate()


@pytest.mark.slow
def test_what_is_estimated_does_not_depend_on_when_it_is_asked(joint):
    slams = [KidnapRecovery(joint(START)) for _ in range(2)]
    for stop in range(STOPS):
        pose = START if stop < 20 else Pose(2.3, 1.2, 2.4)
        for number, slam in enumerate(slams):
            slam.move(Motion())
            for sigma in (0.02, 0.01, np.inf):
                slam.observe(replace(pictures(pose), direction_sigma=sigma))
                if number:
                    slam.estimate()
    assert slams[0].estimate() == slams[1].estimate()
    assert slams[0].kidnappings == slams[1].kidnappings == 1


def test_nothing_is_tested_before_the_fifteenth_stop(joint):
    slam = KidnapRecovery(joint(START))
    pose = drive(slam, START, 5)
    pose = drive(slam, Pose(2.3, 1.2, pose.theta + 2.0), 9)
    assert slam.lost_probability == 0
    drive(slam, pose, 1)
    assert slam.lost_probability > 0


@pytest.mark.parametrize("seed", range(4))
def test_a_kidnapping_is_noticed_within_two_stops_and_the_robot_is_back_within_five_more(mapped, seed):
    slam, before = mapped()
    rng = np.random.default_rng(seed)
    while True:
        pose = Pose(*rng.uniform((0.6, -1.4, -np.pi), (2.4, 1.4, np.pi)).tolist())
        # It has to see something: a robot that looks at an empty part of the field cannot know where it is.
        seen = [len(pictures(pose @ LOOP.as_pose())), len(pictures(pose @ LOOP.as_pose() @ LOOP.as_pose()))]
        if np.hypot(pose.x - before.x, pose.y - before.y) > 0.5 and min(seen) > 1:
            break
    noticed = back = None
    for stop in range(1, 8):
        pose = drive(slam, pose, 1)
        noticed = noticed or (stop if slam.kidnappings else None)
        if noticed and back is None and not slam.lost and off(slam, pose) < 0.05:
            back = stop
    assert noticed is not None and noticed <= 2
    assert back is not None and back - noticed <= 5
    assert slam.kidnappings == 1 and off(slam, pose) < 0.05
    turn = wrap_angle(slam.estimate().pose.theta - pose.theta)
    assert abs(turn) < np.radians(1)


def test_the_probabilities_of_the_filter_and_of_all_other_poses_add_up_to_one(mapped):
    slam, _ = mapped()
    pose = CARRIED_TO
    for _ in range(8):
        pose = drive(slam, pose, 1)
        belief = slam._after_pictures()
        assert belief.tracked + belief.elsewhere.total == pytest.approx(1.0)
    assert slam.kidnappings == 1


def test_on_a_symmetric_map_the_robot_stays_undecided_and_says_how_uncertain_it_is_and_its_map_stays(mapped):
    slam, _ = mapped(SYMMETRIC, Pose(0.0, -0.6, 0.0), AROUND)
    known = slam.estimate().landmarks
    drive(slam, CARRIED_TO, 3, SYMMETRIC)
    assert slam.lost
    assert np.array_equal(slam.estimate().landmarks, known)
    for _ in range(3):
        slam.move(Motion())
        slam.observe(observation([]))
        assert slam.lost
    slam, _ = mapped(SYMMETRIC, Pose(0.0, -0.6, 0.0), AROUND)
    pose = drive(slam, CARRIED_TO, 1, SYMMETRIC)
    for _ in range(10):
        pose = drive(slam, pose, 1, SYMMETRIC)
        assert slam.lost and slam.kidnappings == 1
    # The two poses are mirror images of each other in the origin.
    distance = 2 * np.hypot(pose.x, pose.y)
    assert min(off(slam, pose), off(slam, Pose(-pose.x, -pose.y, 0.0))) < 0.05
    covariance = slam.estimate().covariance
    assert np.trace(covariance[:2, :2]) == pytest.approx(distance**2 / 2, rel=0.25)
    assert covariance[2, 2] == pytest.approx(np.pi**2 / 2, rel=0.25)


def test_a_wrong_commitment_is_taken_back(mapped, monkeypatch):
    places = [*SYMMETRIC, (1.9, -1.9, "post")]
    wrong = 0
    for pose in (CARRIED_TO, Pose(0.0, 0.0, np.pi) @ CARRIED_TO):
        slam, _ = mapped(places, Pose(0.0, -0.6, 0.0), AROUND)
        known = slam.estimate().landmarks
        monkeypatch.setattr(recovery, "FOUND", 0.4)  # it takes either of two equal hypotheses
        away = drive(slam, pose, 3, SYMMETRIC)
        assert slam.kidnappings and not slam.lost
        wrong += off(slam, away) > 1.0
        monkeypatch.undo()
        pose = drive(slam, away, 12, places)
        assert not slam.lost and off(slam, pose) < 0.05
        assert len(slam.estimate().landmarks) == len(known)  # nothing of the wrong pose is left on the map
    assert wrong == 1


def test_what_is_mapped_from_a_wrong_pose_does_not_support_that_pose(mapped, monkeypatch):
    slam, _ = mapped()
    monkeypatch.setattr(recovery, "LOST", 2.0)  # it keeps the filter, which maps everything a second time
    known, compared = len(slam.estimate().landmarks), []

    def spy(stop, on_map, heading):
        compared.append(len(on_map.points))
        return PositionLikelihood(stop, on_map, heading)

    monkeypatch.setattr(recovery, "PositionLikelihood", spy)
    drive(slam, CARRIED_TO, 4)
    assert slam.lost_probability > 0.99
    assert len(slam.estimate().landmarks) > known + 2
    assert set(compared) == {known}


def test_what_was_mapped_between_kidnapping_and_alarm_is_not_on_the_map_afterwards(mapped, monkeypatch):
    slam, _ = mapped()
    known = len(slam.estimate().landmarks)
    monkeypatch.setattr(recovery, "LOST", 2.0)
    pose = drive(slam, CARRIED_TO, 3)
    assert len(slam.estimate().landmarks) > known
    monkeypatch.undo()
    pose = drive(slam, pose, 1)
    assert slam.kidnappings == 1
    drive(slam, pose, 4)
    assert not slam.lost
    assert len(slam.estimate().landmarks) == known


@pytest.mark.slow
def test_the_likelihood_of_a_filter_is_the_average_over_its_gaussian(joint, monkeypatch):
    slam, rng = KidnapRecovery(joint(START)), np.random.default_rng(5)
    pose = drive(slam, START, STOPS)
    known = slam._after_pictures().slam.known_map
    # The filter expects the robot to the left and turned to the left; a compass that contradicts moves both back.
    inner = slam._belief.slam.inner
    root = np.array([[0.03, 0.0, 0.0], [0.01, 0.03, 0.06], [0.0, 0.0, 0.02]])
    inner.state[:3] = pose.as_array() + 1.5 * root[:, 2]
    inner.covariance[:3, :3] = root @ root.T
    stop = StopView.of([pictures(pose)])
    monkeypatch.setattr(recovery, "SLIPS", 1e-9)
    found = slam._log_likelihood(stop, known)
    density = []
    for x, y, theta in inner.state[:3] + rng.normal(size=(3000, 3)) @ root.T:
        of_compass = compass_likelihood(float(wrap_quarter(stop.heading - theta)), stop.heading_sigma**2)
        each = PositionLikelihood(stop, known, theta).log_likelihood(np.array([[x, y]]))
        density.append(of_compass * np.exp(each[0]))
    assert found == pytest.approx(np.log(np.mean(density)), abs=0.2)
    # A slip of some standard deviations is less unlikely with heavier tails.
    inner.state[1] += 0.2
    monkeypatch.undo()
    with_slips = slam._log_likelihood(stop, known)
    monkeypatch.setattr(recovery, "SLIPS", 1e-9)
    assert with_slips > slam._log_likelihood(stop, known) + 2.0


@pytest.fixture
def known(mapped):
    slam, _ = mapped()
    return slam._after_pictures().slam.known_map


@pytest.mark.parametrize("pose", [Pose(1.0, 0.4, 0.2), Pose(2.0, -1.0, -2.8), Pose(0.7, 1.3, 1.0)])
def test_no_other_position_is_as_likely_as_the_true_one(known, pose):
    stop = StopView.of([pictures(pose)])
    offsets = np.array([(0.0, 0.0), (0.3, 0.0), (0.0, 0.3), (-0.3, 0.0), (0.0, -0.3), (1.0, 1.0)])
    positions = np.array([pose.x, pose.y]) + offsets
    found = PositionLikelihood(stop, known, pose.theta).log_likelihood(positions)
    assert found.argmax() == 0
    turned = PositionLikelihood(stop, known, pose.theta + np.pi).log_likelihood(positions[:1])
    assert turned[0] < found[0] - 5


def test_a_landmark_that_should_be_seen_and_is_not_makes_a_pose_less_likely(known):
    pose = Pose(1.0, 0.4, 0.2)
    whole = pictures(pose)
    there = np.array([[pose.x, pose.y]])
    with_all, nothing, behind = (
        PositionLikelihood(StopView.of([seen]), known, pose.theta).log_likelihood(there)
        for seen in (whole, whole.part([]), replace(whole.part([]), view=(0.0, 0.0)))
    )
    assert nothing[0] < behind[0] == 0.0 < with_all[0]


def test_a_line_and_the_circle_tell_the_position_across_them():
    pose, R = Pose(1.3, 0.2, 0.4), np.diag([1e-4, 1e-4])
    foot, centre = pose.to_local(np.array([[3.0, 0.2], [0.0, 0.0]]))
    lines = np.array([[*foot, np.pi / 2 - pose.theta, 0, 0]])
    seen = LineObservation(
        (), np.zeros((0, 0)), float(wrap_quarter(-pose.theta)), 0.01, R, lines=lines,
        circle=Circle(centre, np.zeros((2, 2))),
    )  # fmt: skip
    centre = np.zeros((1, 2)), 1e-4 * np.eye(2)[None], ("centre",)
    known = KnownMap(
        *centre, np.array([0, 1]), np.array([3.0, 0.2]), np.full(2, 1e-4), np.full((2, 2), (-10.0, 10.0))
    )
    positions = np.array([(1.3, 0.2), (1.3, 0.6), (1.6, 0.2)])
    only_line = replace(seen, circle=None)
    there, aside, nearer = PositionLikelihood(StopView.of([only_line]), known, pose.theta).log_likelihood(
        positions
    )
    assert there == pytest.approx(aside) and there > nearer + 2
    found = PositionLikelihood(StopView.of([seen]), known, pose.theta).log_likelihood(positions)
    assert found[0] > found[1] + 2


def test_a_line_is_not_longer_than_on_the_map_and_a_long_line_in_view_is_not_missed():
    pose = Pose(1.0, 0.2, 0.0)

    def likelihood(*spans: tuple[float, float], view=(-1.2, 1.2), sigma=0.01) -> float:
        """Return the log-likelihood of a robot that sees parts of the line x = 3, which ends at y = -2 and y = 2."""
        lines = np.array([[2.0, 0.0, np.pi / 2, *span] for span in spans]).reshape(-1, 5)
        seen = LineObservation(
            (), np.zeros((0, 0)), 0.0, sigma, np.diag([1e-4, 1e-4]), lines=lines, view=view
        )
        known = KnownMap(
            np.zeros((0, 2)), np.zeros((0, 2, 2)), (), np.array([0]), np.array([3.0]), np.full(1, 1e-4),
            np.array([(-2.0, 2.0)]),
        )  # fmt: skip
        stop = PositionLikelihood(StopView.of([seen]), known, 0.0)
        return float(stop.log_likelihood(np.array([[pose.x, pose.y]]))[0])

    assert likelihood((-2.0, 1.7)) == pytest.approx(likelihood((-0.5, 0.5)))
    assert likelihood((-0.5, 2.8)) < likelihood((-0.5, 1.7)) - 2
    assert likelihood((-3.2, 0.5)) < likelihood((-2.1, 0.5)) - 2
    assert likelihood() < likelihood(view=(0.8, 1.2)) - 2
    assert likelihood(view=(1.0, 1.2)) == 0.0
    assert likelihood(sigma=float("inf")) == 0.0  # a picture without a compass has no lines


def test_the_likelihood_of_a_stop_is_the_product_over_its_measurements_and_over_what_is_missed():
    R, spread, views = rotation_2d(0.2), 1e-3 * np.eye(2), np.array([(-0.7, 0.5)])
    known = KnownMap(
        np.array([(2.0, 0.3), (1.1, -0.5), (1.9, 1.0), (1.6, 0.2)]), np.multiply.outer([1, 2, 3, 20], spread),
        ("corner", "post", "corner", "centre"), np.array([0, 1]), np.array([2.0, 0.1]), np.array([1e-3, 2e-3]),
        np.array([(-1.0, 1.0), (0.0, 1.5)]),
    )  # fmt: skip
    measured = np.array([(1.9, 0.4), (1.0, -0.4), (1.4, 0.3), (1.2, 1.2)])
    ends = np.array([[(1.9, 1.2), (1.9, 0.2)], [(0.5, 0.2), (2.6, 0.2)]])
    stop = StopView(
        0.2, 0.0, measured @ R, np.tile(spread, (4, 1, 1)), ("corner", "post", "centre", "post"),
        ends[:, 0] @ R, np.tile(spread, (2, 1, 1)), np.array([np.pi / 2, 0.0]) - 0.2, ends @ R, views, views,
    )  # fmt: skip
    segments = (np.arange(SEGMENTS) + 0.5) / SEGMENTS

    def in_view(points, at):
        x, y = (points - at) @ R.T[0], (points - at) @ R.T[1]
        return (np.arctan2(y, x) > -0.7) & (np.arctan2(y, x) < 0.5), np.hypot(x, y)

    def expected(at):
        seen, away = in_view(known.points, at)
        chances = [np.interp(r, *DETECTED[kind]) for r, kind in zip(away, known.kinds, strict=True)] * seen
        for axis, c, (low, high) in zip(known.axes, known.places, known.spans, strict=True):
            centres = np.full((SEGMENTS, 2), c)
            centres[:, 1 - axis] = low + (high - low) * segments
            seen, away = in_view(centres, at)
            length = np.mean(seen & (away > LINE_RANGE[0]) & (away < LINE_RANGE[1])) * (high - low)
            chances = np.append(chances, np.interp(length, *DETECTED["line"]))
        odds = np.maximum(chances, LEAST_DETECTED) / (1 - np.maximum(chances, LEAST_DETECTED))
        total = np.log1p(-chances[[0, 1, 2, 4, 5]]).sum()  # the centre is not well known
        for point, kind in zip(measured, stop.kinds, strict=True):
            S = [spread + each + MAP_SIGMA**2 * np.eye(2) for each in known.covariances]
            total += np.log1p(sum(
                odds[j] * multivariate_normal.pdf(at + point, known.points[j], S[j]) / CLUTTER[kind]
                for j in range(4) if known.kinds[j] == kind
            ))  # fmt: skip
        for i, axis in enumerate((0, 1)):
            along, (low, high) = np.sort(at[1 - axis] + ends[i, :, 1 - axis]), known.spans[i]
            beyond = max(low - along[0], 0.0) + max(along[1] - high, 0.0)
            sd = np.sqrt(1e-3 + known.variances[i] + MAP_SIGMA**2)
            density = norm.pdf(at[axis] + ends[i, 0, axis], known.places[i], sd) / CLUTTER["line"]
            total += np.log1p(
                odds[4 + i] * density * max(np.exp(-0.5 * (beyond / BEYOND_SIGMA) ** 2), BEYOND)
            )
        return total

    at = np.array([(0.1, -0.1), (0.0, 0.0), (0.2, -0.3), (-0.6, -0.1)])
    found = PositionLikelihood(stop, known, 0.2).log_likelihood(at)
    assert found == pytest.approx([expected(each) for each in at], abs=1e-6)


def test_a_fit_ends_at_a_maximum_of_the_likelihood_between_two_landmarks_that_disagree():
    places, spread = np.array([(2.0, 0.0), (1.5, 0.8)]), np.tile(1e-3 * np.eye(2), (2, 1, 1))
    nothing = np.zeros(0, dtype=int), np.zeros(0), np.zeros(0), np.zeros((0, 2))
    known = KnownMap(places, spread, ("corner", "corner"), *nothing)
    seen = observation([], (1e-4, 1e-4))
    stop = replace(
        StopView.of([LineObservation((), seen.covariance, 0.0, 0.01, seen.tilt, view=(-1.0, 1.0))]),
        points=places + [(0.0, 0.0), (0.0, 0.3)], covariances=spread, kinds=("corner", "corner"),
    )  # fmt: skip
    likelihood = PositionLikelihood(replace(stop, heading_sigma=0.0), known, 0.0)
    at = likelihood.fit(np.zeros((1, 2)))[0][0]
    assert at == pytest.approx((0.0, -0.15), abs=1e-3)
    assert likelihood.log_likelihood(at + [(0.0, 0.0), (0.0, 0.02), (0.0, -0.02)]).argmax() == 0


def test_things_that_two_pictures_show_count_once_and_a_far_compass_not_at_all():
    def scene(*places: float, tilt: float) -> LineObservation:
        lines = np.array([(x, 0.3, np.pi / 2, 0.0, x) for x in places])
        return LineObservation((), np.zeros((0, 0)), 0.0, 0.01, tilt * np.eye(2), lines=lines)

    stop = StopView.of([scene(1.02, tilt=1e-3), scene(1.0, 1.5, tilt=1e-5)])
    assert sorted(stop.lines[:, 0]) == [1.0, 1.5]
    assert np.allclose(stop.ends[:, 1, 1], 0.3 + stop.lines[:, 0])
    pose = Pose(1.0, 0.4, 0.2)
    one = pictures(pose)
    worse = replace(one, covariance=4 * one.covariance, direction=one.direction + 0.3, direction_sigma=0.02)
    stop = StopView.of([worse, one])
    assert len(stop.points) == len(one)
    assert np.allclose(stop.covariances, StopView.of([one]).covariances)
    assert stop.heading == pytest.approx(float(wrap_quarter(pose.theta)))
    again = StopView.of([one, one])
    assert again.heading_sigma == pytest.approx(one.direction_sigma / np.sqrt(2))


def one(quarter: int = 0, heading: float = 0.3) -> Candidates:
    return replace(
        Candidates.none(AROUND), positions=np.array([[0.25, -0.35]]), covariances=1e-4 * np.eye(2)[None],
        quarters=np.array([quarter]), probabilities=np.array([0.0, 1.0]), heading=heading, heading_sigma=0.01,
    )  # fmt: skip


@pytest.mark.parametrize("quarter", range(4))
def test_a_candidate_moves_as_the_robot_does(quarter):
    found, noise = one(quarter), np.diag([0.02, 0.01, 0.05]) ** 2
    there = Pose(0.25, -0.35, 0.3 + quarter * QUARTER)
    for motion in (Motion(0.25, 0.4), Motion(0.2, -0.1)):
        along = (
            rotation_2d(there.theta)[:, 0] @ (found.moved(motion, noise).covariances - found.covariances)[0]
        )
        assert along @ rotation_2d(there.theta)[:, 0] == pytest.approx(0.02**2)
        found, there = found.moved(motion, noise), there @ motion.as_pose()
    assert np.allclose(found.positions[0], (there.x, there.y))
    assert wrap_angle(found.poses[0, 2] - there.theta) == pytest.approx(0.0, abs=1e-9)
    assert found.heading_sigma == pytest.approx(np.hypot(0.01, np.sqrt(2) * 0.05))


def test_a_compass_that_contradicts_candidates_makes_them_less_likely_and_compass_likelihoods_average_to_one():
    stop = StopView.of([observation([], direction=-0.1, direction_sigma=0.01)])
    near, far = (one(heading=heading).aligned(stop) for heading in (0.1, 0.5))
    assert near.total > 10 > 0.1 > far.total
    for found in (near, far):
        assert found.heading == pytest.approx(0.1) and found.heading_sigma == 0.01
    around = one(heading=QUARTER + 0.08).aligned(stop)  # the compass measures modulo 90 degrees
    assert around.heading == pytest.approx(QUARTER + 0.1)
    angles = np.linspace(-QUARTER / 2, QUARTER / 2, 2001)
    each = [compass_likelihood(float(angle), 0.05**2) for angle in angles]
    assert np.mean(each) == pytest.approx(1.0, abs=1e-3)
    assert compass_likelihood(0.3, float("inf")) == 1.0


def map_and_stop(pose: Pose, places, order=slice(None)) -> tuple[KnownMap, StopView]:
    """Return a map of exactly known places in some order, and the exact view from a pose."""
    x, y, kinds = zip(*places, strict=True)
    known = KnownMap(
        np.column_stack([x, y])[order], np.tile(1e-6 * np.eye(2), (len(places), 1, 1)),
        tuple(np.array(kinds)[order].tolist()), np.zeros(0, dtype=int), np.zeros(0), np.zeros(0), np.zeros((0, 2)),
    )  # fmt: skip
    return known, StopView.of([pictures(pose, places)])


def anywhere(known: KnownMap, stop: StopView) -> Candidates:
    """Return the candidates of a stop if the robot may be anywhere."""
    found, logs = Candidates.none(AROUND).aligned(stop).updated(stop, known, 1.0)
    return replace(found, probabilities=np.exp(logs - logsumexp(logs)))


@pytest.mark.parametrize("pose", [Pose(-1.5, -1.5, 0.8), Pose(1.6, 1.5, -2.4), Pose(-1.7, 0.3, 0.3)])
def test_without_noise_the_true_pose_is_a_candidate_and_the_best_and_a_symmetric_map_has_two(pose, rng):
    known, stop = map_and_stop(pose, SYMMETRIC)
    assert (
        np.isclose(PositionLikelihood(stop, known, pose.theta).positions, (pose.x, pose.y)).all(axis=1).any()
    )
    found = anywhere(known, stop)
    assert np.allclose(found.probabilities[1:3], 0.5, atol=1e-3)
    mirrored = found.positions[:2] * np.where(np.arange(2) == found.quarters[:2].argmin(), 1, -1)[:, None]
    assert np.allclose(mirrored[0], mirrored[1], atol=1e-4)
    found = anywhere(*map_and_stop(pose, [*SYMMETRIC, (1.9, -1.9, "post"), (-0.4, 0.2, "corner")]))
    assert found.probabilities[1] > 0.99
    assert np.allclose(found.positions[0], (pose.x, pose.y), atol=1e-3)
    assert wrap_angle(found.poses[0, 2] - pose.theta) == pytest.approx(0.0, abs=1e-9)


def test_the_order_of_landmarks_changes_no_candidate(rng):
    found, again = (
        anywhere(*map_and_stop(Pose(-1.5, -1.5, 0.8), PLACES, order))
        for order in (np.arange(len(PLACES)), rng.permutation(len(PLACES)))
    )
    clear = int((found.probabilities[1:] > 1e-9).sum())
    assert clear > 1
    assert np.allclose(again.probabilities[: 1 + clear], found.probabilities[: 1 + clear])
    assert np.allclose(again.poses[:clear], found.poses[:clear])


def test_a_filter_that_is_placed_keeps_its_map_which_is_its_points_and_lines(joint):
    slam = joint(START)
    drive(slam, START, 4)
    before, n = slam.estimate(), len(slam.inner.state)
    slam.place(Pose(1.0, 1.0, 1.0), 0.01 * np.eye(3))
    after = slam.estimate()
    assert np.array_equal(after.landmarks, before.landmarks)
    assert np.array_equal(after.landmark_covariances, before.landmark_covariances)
    assert after.pose == Pose(1.0, 1.0, 1.0)
    assert np.array_equal(slam.inner.covariance[:3], np.eye(3, n) * 0.01)
    assert np.array_equal(slam.inner.covariance[:, :3], np.eye(n, 3) * 0.01)
    pose, slam = Pose(1.3, 0.1, 0.0), joint(Pose(1.3, 0.1, 0.0))
    foot = pose.to_local(np.array([[3.0, 0.1]]))[0]
    seen = pictures(pose)
    slam.observe(
        LineObservation(
            seen.measurements, seen.covariance, 0.0, 1e-3, seen.tilt, lines=np.array([[*foot, np.pi / 2, 0, 0]]),
            circle=Circle(pose.to_local(np.zeros((1, 2)))[0], np.zeros((2, 2))),
        )
    )  # fmt: skip
    known = slam.known_map
    assert known.kinds.count("centre") == 1 and len(known.kinds) == len(seen) + 1
    assert np.allclose(known.points[known.kinds.index("centre")], 0.0, atol=0.01)
    assert known.axes.tolist() == [0] and known.places[0] == pytest.approx(3.0, abs=0.01)
    assert slam.inner.kinds.count(INTERNAL) == 2
