"""The joint update: lines and the centre circle as landmarks, and the tilt that all measurements share."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.field_slam.compass import BodyTilt, estimate_body_tilt, wrap_quarter
from nao_course.field_slam.joint_update import INTERNAL, JointUpdate, LinearisedMeasurement
from nao_course.field_slam.known_shapes.circle import RADIUS, Circle, find_circle
from nao_course.field_slam.line_observation import LineObservation, field_lines, scene, visible_ends
from nao_course.field_slam.lines import to_ground
from nao_course.field_slam.observation import observation, tilted
from nao_course.geometry import Pose, wrap_angle
from nao_course.sim import NAO_V4, Field
from nao_course.slam import Measurement, Motion, range_and_bearing

VIEW = replace(NAO_V4.view("bottom", 0.0, float(np.radians(-31.0))), k1=0.0)
SQUARE = BodyTilt(0.0, 0.0, 0.0, np.diag([1e-6, 1e-6, 1e-4]))


def pieces(pose: Pose, number: int = 12, length: float = 0.12, part: float = 2 * np.pi) -> np.ndarray:
    """Short chords of the centre circle, as they are in a picture from a pose; those in sight."""
    middles = pose.theta + np.pi + np.linspace(-part / 2, part / 2, number, endpoint=False)
    half = np.arcsin(length / 2 / RADIUS)
    around = (RADIUS * np.column_stack([np.cos(a), np.sin(a)]) for a in (middles - half, middles + half))
    ends = [VIEW.project(each, pose) for each in around]
    inside = VIEW.contains(ends[0]) & VIEW.contains(ends[1])
    return np.hstack(ends)[inside]


def exact(pose: Pose, sigma: float = 1e-3, lines=None, centre=True) -> LineObservation:
    """What a robot that makes no error sees of all lines x = c and y = c, and of the circle."""
    rows = []
    for axis, c in lines if lines is not None else ((0, 3.0), (1, 2.0), (0, 0.0)):
        foot = np.array([pose.x, pose.y])
        foot[axis] = c
        direction = (np.pi / 2 if axis == 0 else 0.0) - pose.theta
        rows.append([*pose.to_local(foot)[0], direction, 0.0, 0.0])
    circle = Circle(pose.to_local(np.zeros((1, 2)))[0], np.zeros((2, 2))) if centre else None
    seen = observation([], (1e-4, 1e-4), direction=float(wrap_quarter(-pose.theta)), direction_sigma=sigma)
    return LineObservation(
        seen.measurements, seen.covariance, seen.direction, sigma, seen.tilt,
        lines=np.array(rows).reshape(-1, 5), circle=circle,
    )  # fmt: skip


@pytest.fixture
def slam(jointly):
    return lambda start: JointUpdate(jointly(start), factors=(1.0,))


@pytest.mark.parametrize("pose", [Pose(1.3, 0.1, np.pi), Pose(-1.5, -0.4, 0.3), Pose(0.9, 0.9, -2.3)])
def test_pieces_of_the_circle_tell_its_middle_whichever_end_comes_first(pose):
    for order in ([2, 3, 0, 1], [0, 1, 2, 3]):
        found = find_circle(pieces(pose)[:, order], VIEW)
        assert np.allclose(found.centre, pose.to_local(np.zeros((1, 2)))[0], atol=0.006)


def test_long_arcs_on_one_side_suggest_the_centre_and_two_pieces_or_a_straight_line_tell_none():
    pose = Pose(1.5, 0.0, np.pi)
    found = find_circle(pieces(pose, 7, 0.4, np.pi), VIEW)
    assert found is not None
    assert np.allclose(found.centre, pose.to_local(np.zeros((1, 2)))[0], atol=0.06)
    pose = Pose(1.6, 0.0, np.pi)
    assert find_circle(pieces(pose)[:2], VIEW) is None
    assert find_circle(pieces(pose, 6, 0.1, 0.15), VIEW) is None
    straight = [VIEW.project(np.array([(1.2, y), (1.2, y + 0.2)])).ravel() for y in (-0.4, -0.1, 0.2)]
    assert find_circle(np.array(straight), VIEW) is None
    assert find_circle(np.zeros((0, 4)), VIEW) is None


@pytest.mark.parametrize(
    ("ends", "kept"),
    [
        ([(2.0, 0.0), (2.9, 0.0)], True),
        ([(2.9, 0.0), (3.4, 0.0)], False),  # longer than 0.45 m, but shorter than 20 px
        ([(3.9, -0.7), (3.9, 0.7)], True),
        ([(4.1, -0.7), (4.1, 0.7)], False),  # farther than 4 m
    ],
)
def test_a_line_that_is_short_in_the_picture_or_far_away_is_not_kept(ends, kept):
    pixels = VIEW.project(np.array(ends)).reshape(1, 4)
    assert len(field_lines(pixels, SQUARE, VIEW)) == kept


def test_lines_along_the_fields_directions_are_kept_at_their_nearest_points_if_there_is_a_compass():
    pixels = VIEW.project(np.array([(1.2, 0.2), (1.2, 0.8)])).reshape(1, 4)  # its foot, (1.2, 0), is not seen
    found = field_lines(pixels, SQUARE, VIEW)
    assert np.allclose(found[0, :2], (1.2, 0.2), atol=1e-6)
    assert np.allclose(visible_ends(found)[0], [(1.2, 0.2), (1.2, 0.8)], atol=1e-6)
    pixels = VIEW.project(np.array([(1.0, -0.4), (1.0, 0.4)])).reshape(1, 4)
    for sigma, number in ((0.01, 1), (np.inf, 0)):
        assert len(scene(observation([], direction_sigma=sigma), SQUARE, pixels, VIEW).lines) == number
    ahead, slanted, short = [(1.0, -0.4, 1.0, 0.4)], [(1.0, -0.4, 1.2, 0.4)], [(1.0, -0.1, 1.0, 0.1)]
    pixels = [VIEW.project(np.reshape(each, (-1, 2))).reshape(1, 4) for each in (ahead, slanted, short)]
    found = field_lines(np.vstack(pixels), SQUARE, VIEW)
    assert len(found) == 1 and np.allclose(found[0, :2], (1.0, 0.0), atol=1e-6)
    assert np.allclose(visible_ends(found)[0], [(1.0, -0.4), (1.0, 0.4)], atol=1e-6)
    assert float(wrap_quarter(found[0, 2])) == pytest.approx(0.0, abs=1e-9)
    horizon = np.array([[10.0, 1.0, 300.0, 2.0]])
    assert not len(field_lines(horizon, SQUARE, tilted(VIEW, -0.5, 0.0)))
    # The last one is 28 degrees off
    lines = [(1.0, -0.7, 1.0, 0.7), (1.6, -0.7, 1.6, 0.7), (1.2, 0.0, 1.5, 0.16)]
    pixels = np.vstack([VIEW.project(np.reshape(each, (-1, 2))).reshape(1, 4) for each in lines])
    assert np.degrees(estimate_body_tilt(pixels, VIEW).direction) == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize("length", [0.25, 0.15])
@pytest.mark.parametrize("degrees", [80.0, 97.0])
def test_a_short_piece_bends_no_compass(length, degrees):
    """A tilt of a degree or two would make it perpendicular to the long line, but it is a segment of the circle."""
    long = VIEW.project(np.array([(1.4, -0.7), (1.4, 0.7)])).reshape(1, 4)
    way = length / 2 * np.array([np.cos(np.radians(degrees - 90)), np.sin(np.radians(degrees - 90))])
    piece = VIEW.project(np.array([(1.1, 0.2) - way, (1.1, 0.2) + way])).reshape(1, 4)
    alone, both = estimate_body_tilt(long, VIEW), estimate_body_tilt(np.vstack([long, piece]), VIEW)
    assert (both.direction, both.pitch) == pytest.approx((alone.direction, alone.pitch))


def test_the_jacobian_of_a_point_is_that_of_finite_differences(slam):
    own, point, step = slam(Pose(0.4, -0.3, 0.7)), np.array([1.3, 0.5]), 1e-6
    _, H, by_range = own._on_the_field(point)
    for axis in range(3):
        places = []
        for sign in (1, -1):
            state = own.inner.state.copy()
            own.inner.state[axis] += sign * step
            places.append(own._on_the_field(point)[0])
            own.inner.state = state
        assert np.allclose(H[:, axis], (places[0] - places[1]) / (2 * step), atol=1e-8)
    moved = [own._on_the_field(point * share)[0] for share in (1 + step, 1 - step)]
    numeric = (moved[0] - moved[1]) / (2 * step * np.hypot(*point))
    assert np.allclose(by_range[:, 0], numeric)


@pytest.mark.parametrize("pose", [Pose(1.3, 0.1, np.pi), Pose(0.9, 0.9, -2.3), Pose(-1.5, -0.4, 0.3)])
def test_the_tilt_jacobian_of_the_circles_centre_is_that_of_finite_differences(pose):
    pixels, step = pieces(pose, 24, 0.2), np.radians(0.1)
    tilts = ((step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step))
    moved = [find_circle(pixels, tilted(VIEW, *tilt)).centre for tilt in tilts]
    numeric = -np.column_stack([moved[0] - moved[1], moved[2] - moved[3]]) / (2 * step)
    assert np.allclose(find_circle(pixels, VIEW).tilt_jacobian, numeric, rtol=0.2, atol=0.3)


@pytest.mark.parametrize("sight", ["lines", "circle", "both"])
def test_without_noise_lines_and_circle_lead_back_to_the_truth(slam, sight):
    start, rng = Pose(0.6, -0.4, 0.3), np.random.default_rng(5)
    truth, odometry, mine = start, start, slam(start)
    lines = () if sight == "circle" else None
    mine.observe(exact(truth, lines=lines, centre=sight != "lines"))
    for _ in range(25):
        told = Motion(0.2, float(rng.uniform(-0.5, 0.5)))
        done = Motion(told.distance * (1 + 0.1 * rng.normal()), told.turn * (1 + 0.1 * rng.normal()))
        truth, odometry = truth @ done.as_pose(), odometry @ told.as_pose()
        mine.move(told)
        mine.observe(exact(truth, lines=lines, centre=sight != "lines"))
    found = mine.estimate().pose
    lost = np.hypot(odometry.x - truth.x, odometry.y - truth.y)
    off = np.hypot(found.x - truth.x, found.y - truth.y)
    assert lost > 0.15 and off < 0.03 and off < lost / 20
    assert abs(wrap_angle(found.theta - truth.theta)) < 2e-3
    assert list(mine.inner.kinds) == [INTERNAL] * {"lines": 3, "circle": 1, "both": 4}[sight]
    assert mine.estimate().kinds == () and mine.estimate().landmarks.shape == (0, 2)


def test_compass_and_places_together_are_one_update_with_all_they_share(slam):
    """The compass first and what is left of the rest then: the same as everything at once."""
    rng = np.random.default_rng(2)
    mine, sigma, T = slam(Pose()), 0.05, np.array([[4e-4, 1e-4], [1e-4, 3e-4]])
    shared = np.array([6e-4, -3e-4])
    root = rng.normal(size=(3, 3))
    before, x0 = 1e-3 * root @ root.T, np.array([0.1, 0.2, 0.03])
    H, own, J = rng.normal(size=(4, 3)), np.diag(rng.uniform(1, 2, 4)) * 1e-4, rng.normal(size=(4, 2))
    nu, direction = 0.02 * rng.normal(size=4), -0.05
    mine.inner.state, mine.inner.covariance = x0.copy(), before.copy()
    mine.inner.use_compass(direction, sigma)
    left = LinearisedMeasurement(nu - H @ (mine.inner.state - x0), H, own, J, "landmarks", np.full(4, True))
    seen = LineObservation((), np.zeros((0, 0)), direction, sigma, T, shared=shared)
    mine._correct([left], seen)
    all_H = np.vstack([[0.0, 0.0, -1.0], H])
    R = np.zeros((5, 5))
    R[0, 0], R[1:, 1:] = sigma**2, own + J @ T @ J.T
    R[0, 1:] = R[1:, 0] = -J @ shared
    S = all_H @ before @ all_H.T + R
    K = before @ all_H.T @ np.linalg.inv(S)
    assert np.allclose(mine.inner.state, x0 + K @ np.concatenate([[direction + x0[2]], nu]))
    assert np.allclose(mine.inner.covariance, before - K @ S @ K.T)


def test_the_covariance_of_tilt_and_compass_has_the_right_sign():
    """If the estimated tilt is too large, the estimated direction errs as their covariance predicts."""
    line, rng, told = np.array([(1.0, 0.3), (2.2, 0.9)]), np.random.default_rng(0), []
    for _ in range(60):
        tilt = rng.normal(0, np.radians(1.3)), rng.normal(0, np.radians(0.8))
        pixels = tilted(VIEW, *tilt).project(line).reshape(1, 4)
        found = estimate_body_tilt(pixels, VIEW)
        wrong = wrap_quarter(found.direction - np.arctan2(0.6, 1.2))
        told.append((found.pitch - tilt[0], found.roll - tilt[1], float(wrong), *found.covariance[:2, 2]))
    told = np.array(told)
    for axis in (0, 1):
        stated = told[:, 3 + axis].mean()
        assert np.mean(told[:, axis] * told[:, 2]) == pytest.approx(stated, rel=0.5, abs=2e-5)


def test_landmarks_alone_are_corrected_as_the_lessons_filter_does(jointly, slam):
    pose = Pose(0.5, 0.2, 0.1)
    marks = [mark for mark in Field(2012).landmarks if mark.kind != "cross"][:5]
    places = [range_and_bearing(pose.as_array(), (mark.x, mark.y)) for mark in marks]
    seen = observation([Measurement(*at, mark.kind) for at, mark in zip(places, marks, strict=True)])
    lesson, mine = jointly(pose), slam(pose)
    for share in (1.0, 1.01, 1.02):
        part = observation([replace(one, range=one.range * share) for one in seen])
        for each in (lesson, mine):
            each.observe(part)
            each.move(Motion(0.05, 0.02))
    assert np.allclose(lesson.state, mine.inner.state, atol=1e-9)
    assert np.allclose(lesson.covariance, mine.inner.covariance, atol=1e-9)


def test_a_line_counts_once_and_one_that_may_be_two_does_not_count(slam):
    mine, here = slam(Pose(1.0, 0.0, 0.0)), Pose(1.0, 0.0, 0.0)
    for _ in range(2):  # of two that are new and run the same way one comes onto the map
        mine.observe(exact(here, lines=[(0, 2.4), (0, 3.0)], centre=False))
    assert mine.inner.kinds == [INTERNAL] * 2
    mine.inner.covariance[0, 0] += 0.3**2  # now either may be seen
    before = mine.inner.state.copy(), mine.inner.covariance.copy()
    mine.observe(exact(here, sigma=np.inf, lines=[(0, 2.7)], centre=False))
    assert mine.inner.kinds == [INTERNAL] * 2
    assert np.allclose(mine.inner.state, before[0]) and np.allclose(mine.inner.covariance, before[1])
    mine.inner.covariance[0, 0] -= 0.3**2
    mine.move(Motion(0.1, 0.0))
    once, twice = ([(0, 2.4)] * times for times in (1, 2))
    ends = []
    for lines in (once, twice):
        state, covariance = mine.inner.state.copy(), mine.inner.covariance.copy()
        mine.observe(exact(Pose(1.1, 0.0, 0.0), lines=lines, centre=False))
        ends.append(mine.inner.covariance.copy())
        mine.inner.state, mine.inner.covariance = state, covariance
    assert np.allclose(*ends)


def test_the_map_has_the_ends_of_the_part_of_a_line_that_was_seen(slam):
    pose, mine = Pose(1.0, 0.5, 0.3), slam(Pose(1.0, 0.5, 0.3))
    foot = pose.to_local(np.array([[3.0, 0.5]]))[0]
    for span in ([(0.0, 0.7)], [(-1.1, 0.2)], [(0.1, 0.2), (-0.1, 0.9)]):
        lines = np.array([[*foot, np.pi / 2 - 0.3, *each] for each in span])
        mine.observe(replace(exact(pose, lines=(), centre=False), lines=lines))
    assert np.allclose(mine.known_map.spans, [(0.5 - 1.1, 0.5 + 0.9)], atol=0.01)


@pytest.mark.parametrize(("apart", "lines"), [(0.25, 1), (0.35, 2)])
def test_a_line_nearer_than_30_cm_to_a_parallel_one_is_not_added_to_the_map(slam, apart, lines):
    mine, here = slam(Pose(1.0, 0.0, 0.0)), Pose(1.0, 0.0, 0.0)
    for place in (2.4, 2.4 + apart):
        mine.observe(exact(here, lines=[(0, place)], centre=False))
    assert len(mine.inner.kinds) == lines


def test_nothing_new_comes_onto_the_map_of_a_lost_robot_and_a_new_line_does_not_hide_a_known_one(slam):
    mine = slam(Pose())
    mine.inner.covariance[:2, :2] = 0.2**2 * np.eye(2)
    mine.observe(exact(Pose()))
    assert mine.inner.kinds == []
    mine, here = slam(Pose(1.0, 0.0, 0.0)), Pose(1.0, 0.0, 0.0)
    mine.observe(exact(here, lines=()))
    before = mine.inner.state.copy()
    mine.observe(replace(exact(here, lines=()), circle=Circle(np.array([-0.4, 0.3]), np.zeros((2, 2)))))
    assert np.allclose(mine.inner.state, before) and mine.inner.kinds == [INTERNAL]
    spreads = []
    for lines in ([(0, 2.4), (0, 3.0)], [(0, 3.0), (0, 2.4)]):
        mine = slam(Pose(1.0, 0.0, 0.0))
        mine.observe(exact(Pose(1.0, 0.0, 0.0), lines=[(0, 2.4)], centre=False))
        mine.move(Motion(0.2, 0.0))
        mine.observe(exact(Pose(1.2, 0.0, 0.0), lines=lines, centre=False))
        spreads.append(mine.inner.covariance[0, 0])
    assert spreads[0] == pytest.approx(spreads[1], rel=1e-3)


def seen_by_tilted(pose: Pose, tilt, marks, line=None, circle=False) -> LineObservation:
    """Measure corners, a line or the circle from a body that is tilted (pitch, roll; rad) but assumed to be upright."""
    camera = tilted(VIEW, *tilt)

    def pixels(places):
        return camera.project(np.reshape(places, (-1, 2)), pose)

    found = to_ground(pixels(marks), VIEW) + VIEW.offset
    corners = [Measurement(*range_and_bearing((0, 0, 0), place), "corner") for place in found]
    seen = observation(corners, corner_sigma=0.1)
    ends = np.zeros((0, 4)) if line is None else pixels(line).reshape(1, 4)
    if circle:
        around = np.linspace(0, 2 * np.pi, 24, endpoint=False)[:, None] + (-0.13, 0.13)
        ends = pixels(RADIUS * np.stack([np.cos(around), np.sin(around)], axis=-1)).reshape(-1, 4)
    told = replace(SQUARE, direction=float(wrap_quarter(-pose.theta)))
    whole = scene(replace(seen, direction=told.direction, direction_sigma=0.01), told, ends, VIEW)
    # Without a compass, only the positions depend on the tilt.
    return replace(whole, direction_sigma=float("inf"))


def with_map(slam, pose: Pose, marks, rest, axis):
    """A filter that knows a map well, its heading too, and its own place to 10 cm."""
    mine, places = slam(pose), np.vstack([np.reshape(marks, (-1, 2)), rest])
    mine.inner.state = np.concatenate([mine.inner.state, places.ravel()])
    mine.inner.covariance = np.diag([1e-2, 1e-2, 1e-8] + [1e-8] * places.size)
    mine.inner.kinds = ["corner"] * len(marks) + [INTERNAL]
    mine._axes, mine._circle = ({len(marks): axis}, None) if axis is not None else ({}, len(marks))
    return mine


def ends_off(mine, seen: LineObservation, pose: Pose) -> float:
    """Metres from the truth after a picture."""
    mine.observe(seen)
    found = mine.estimate().pose
    return float(np.hypot(found.x - pose.x, found.y - pose.y))


@pytest.mark.parametrize("pitch", [1.2, -1.2])
@pytest.mark.parametrize("heading", [0.0, np.pi / 2, np.pi])
def test_a_known_corner_and_a_line_distinguish_a_tilt_from_a_step(slam, heading, pitch):
    """A step moves near and far points alike; a tilt moves a point that is twice as far four times as much."""
    pose, tilt = Pose(0.3, -0.2, heading), (np.radians(pitch), 0.0)
    mark, line = pose.to_parent([(1.0, 0.0)]), pose.to_parent([(2.0, -0.6), (2.0, 0.6)])
    axis = int(heading == np.pi / 2)
    maps = mark, np.eye(2)[0] * line[0, axis], axis
    without = ends_off(with_map(slam, pose, *maps), seen_by_tilted(pose, tilt, mark), pose)
    seen = seen_by_tilted(pose, tilt, mark, line)
    assert len(seen.lines) == 1
    assert ends_off(with_map(slam, pose, *maps), seen, pose) < without / 4


@pytest.mark.parametrize("pitch", [0.6, 0.3, -0.3, -0.6])
@pytest.mark.parametrize("heading", [0.0, 1.1])
def test_a_known_corner_and_the_circle_distinguish_a_tilt_from_a_step(slam, heading, pitch):
    pose, tilt = Pose(-1.8 * np.cos(heading), -1.8 * np.sin(heading), heading), (np.radians(pitch), 0.0)
    mark = pose.to_parent([(0.8, 0.0)])
    maps = mark, (0.0, 0.0), None
    without = ends_off(with_map(slam, pose, *maps), seen_by_tilted(pose, tilt, mark), pose)
    seen = seen_by_tilted(pose, tilt, mark, circle=True)
    assert seen.circle is not None
    assert ends_off(with_map(slam, pose, *maps), seen, pose) < without / 2


@pytest.mark.parametrize("pitch", [0.6, -0.6])
def test_the_circles_middle_is_the_same_whichever_piece_is_asked_first(pitch):
    told = []
    for heading in (0.0, np.pi / 2, np.pi, 0.4):
        pose = Pose(-1.8 * np.cos(heading), -1.8 * np.sin(heading), heading)
        seen = seen_by_tilted(pose, (np.radians(pitch), 0.0), pose.to_parent([(0.8, 0.0)]), circle=True)
        told.append(seen.circle.centre)
    assert np.ptp(np.vstack(told), axis=0).max() < 0.02
