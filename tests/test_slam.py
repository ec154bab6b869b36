"""The values that SLAM is about, and the loop that runs an algorithm."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.slam import (
    DeadReckoning,
    Estimate,
    Measurement,
    Motion,
    SlamAlgorithm,
    measured_points,
    place_estimate,
    range_and_bearing,
    run_slam,
)


def test_a_motion_drives_along_the_old_heading_and_a_square_closes():
    pose = Pose(1, 2, np.pi / 2) @ Motion(2.0, 0.3).as_pose()
    assert np.allclose(pose.as_array(), (1, 4, np.pi / 2 + 0.3))
    log = [(Motion(1.0, np.pi / 2), [])] * 4
    final = run_slam(DeadReckoning(Pose(1, 1, 0.5)), log)[-1]
    assert np.allclose(final.pose.as_array(), (1, 1, 0.5))


def test_the_loop_moves_before_it_observes():
    class Recorder(SlamAlgorithm):
        def __init__(self):
            self.calls = []

        def move(self, motion):
            self.calls.append("move")

        def observe(self, measurements):
            self.calls.append(len(measurements))

        def estimate(self):
            return Estimate(Pose(), np.eye(3), [], [])

    recorder = Recorder()
    estimates = run_slam(recorder, [(None, []), (Motion(1), [Measurement(0, 1)])])
    assert recorder.calls == [0, "move", 1]
    assert len(estimates) == 2
    with pytest.raises(TypeError, match="abstract"):
        SlamAlgorithm()


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: Motion(np.nan, 0), "distance"),
        (lambda: Motion(0, np.inf), "turn"),
        (lambda: Measurement(0, -1), "negative"),
        (lambda: Measurement(0, 1, "goal"), "kind must be one of"),
        (lambda: Measurement(np.nan, 1), "bearing"),
        (lambda: Estimate(Pose(), np.eye(2), [], []), r"covariance must have shape \(3, 3\), got \(2, 2\)"),
        (lambda: Estimate(Pose(), np.eye(3), [[1, 2]], [np.eye(2)]), "1 landmarks need 1 kinds"),
        (lambda: Estimate(Pose(), np.eye(3), [[1, 2]], [np.eye(3)], ("post",)), "landmark_covariances"),
    ],
)
def test_bad_values_are_refused_with_what_was_expected(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def estimate(**changes):
    values = {
        "pose": Pose(1, 2, 0.1),
        "covariance": np.eye(3),
        "landmarks": [[1.0, 2.0]],
        "landmark_covariances": [np.eye(2)],
        "kinds": ("post",),
    }
    return Estimate(**values | changes)


def test_estimates_with_equal_values_are_equal_to_no_other_thing_and_no_keys():
    assert estimate() == estimate()
    assert Estimate(Pose(), np.eye(3), [], []) == Estimate(Pose(), np.eye(3), np.empty((0, 2)), [])
    assert estimate() != "estimate"
    with pytest.raises(TypeError, match="unhashable"):
        hash(estimate())


@pytest.mark.parametrize(
    "change",
    [
        {"pose": Pose()},
        {"covariance": 2 * np.eye(3)},
        {"landmarks": [[1.0, 2.5]]},
        {"landmark_covariances": [2 * np.eye(2)]},
        {"kinds": ("corner",)},
        {"landmarks": np.zeros((2, 2)), "landmark_covariances": np.zeros((2, 2, 2)), "kinds": ("post",) * 2},
    ],
)
def test_estimates_that_differ_in_one_value_differ(change):
    assert (estimate() == estimate(**change)) is False
    assert estimate() != estimate(**change)


def test_measurements_put_their_landmarks_where_range_and_bearing_say_and_back(rng):
    pose = Pose(1.0, 2.0, np.pi / 2)
    points = measured_points([Measurement(0.0, 2.0), Measurement(np.pi / 2, 1.0)], pose)
    assert np.allclose(points, [(1, 4), (0, 2)])
    assert measured_points([], pose).shape == (0, 2)
    assert np.isclose(Measurement(1.5 * np.pi, 1).bearing, -np.pi / 2)
    poses, landmarks = rng.uniform(-3, 3, (20, 3)), rng.uniform(-3, 3, (20, 2))
    for pose, landmark, seen in zip(poses, landmarks, range_and_bearing(poses, landmarks), strict=True):
        assert np.allclose(measured_points([Measurement(*seen)], Pose(*pose)), landmark)
    assert range_and_bearing(poses[0], landmarks).shape == (20, 2)


def random_estimate(rng, landmarks=3):
    def covariances(n, size):
        roots = rng.normal(size=(n, size, size))
        return roots @ np.swapaxes(roots, 1, 2)

    kinds = ("post", "corner", "corner")[:landmarks]
    positions = rng.normal(size=(landmarks, 2))
    return Estimate(
        Pose(*rng.normal(size=3)), covariances(1, 3)[0], positions, covariances(landmarks, 2), kinds
    )


def variances(covariance, direction):
    return np.einsum("i,...ij,j->...", direction, covariance, direction)


def test_a_placed_estimate_has_the_same_variance_in_every_turned_direction_and_moves_back(rng):
    estimate, frame = random_estimate(rng), Pose(0.5, -1.0, 0.7)
    placed = place_estimate(estimate, frame)
    for direction in rng.normal(size=(5, 2)):
        turned = frame.to_parent(direction)[0] - (frame.x, frame.y)
        for name in ("covariance", "landmark_covariances"):
            before, after = getattr(estimate, name)[..., :2, :2], getattr(placed, name)[..., :2, :2]
            assert np.allclose(variances(after, turned), variances(before, direction))
        with_heading = [np.append(each, 0.3) for each in (direction, turned)]
        assert np.isclose(
            variances(placed.covariance, with_heading[1]), variances(estimate.covariance, with_heading[0])
        )
    assert np.allclose(frame.to_local(placed.landmarks), estimate.landmarks)
    assert np.allclose(placed.pose.as_array(), (frame @ estimate.pose).as_array())
    back = place_estimate(placed, frame.inverse())
    for name in ("covariance", "landmarks", "landmark_covariances"):
        assert np.allclose(getattr(back, name), getattr(estimate, name))
    assert place_estimate(estimate, None) is estimate
    with pytest.raises(ValueError, match="must be an Estimate, got str"):
        place_estimate("here", frame)
