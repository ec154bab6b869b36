"""The solution's filter and graph: exact without noise, and what one gate and one tilt do to them."""

import numpy as np
import pytest

from nao_course.exercises.checking import read_public
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.observation import observation
from nao_course.geometry import Pose
from nao_course.lessons.slam_on_the_field.associating import follow, right_share
from nao_course.lessons.slam_on_the_field.worlds import KINDS, LANDMARKS, association_problem, drawn_drive
from nao_course.slam import Measurement, Motion, measured_points, range_and_bearing, run_slam


def exact_log(start):
    """A drive without any error: all landmarks ahead of the robot at each stop."""
    pose, log = start, []
    for number in range(5):
        motion = Motion(0.2, 0.3) if number else None
        pose = pose @ motion.as_pose() if motion else pose
        seen = range_and_bearing(pose.as_array(), LANDMARKS)
        near = [
            Measurement(float(b), float(r), kind)
            for (b, r), kind in zip(seen, KINDS, strict=True)
            if abs(b) < 1.2 and r > 0.3
        ]
        log.append((motion, observation(near)))
    return log, pose


def test_the_docstrings_example_is_what_it_returns_and_measurements_of_a_problem_lie_at_their_landmarks(own):
    state, covariance = 2.0 * np.eye(5)[3], 0.01 * np.eye(5)
    distance = own["joint_distance"](state, covariance, [0], [Measurement(0.1, 2.2)], np.diag([0.0025, 0.01]))
    assert f"give {distance:.3f}." in own["joint_distance"].__doc__
    each = association_problem(3, 0.1, 0.1)
    places = measured_points(each.observation, each.pose)
    assert np.linalg.norm(places - LANDMARKS[list(each.origins)], axis=1).max() < 1.5


def test_a_picture_of_the_public_cases_needs_all_measurements_associated_together(own):
    """Else `number` alone would pass although it associates one measurement at a time, which fails on whole drives."""
    exercise = next(each for each in read_public("11_slam_on_the_field").exercises if each.name == "EkfSlam")
    differ = []
    for case in exercise.cases:
        given = {name: args for name, args in case.args[1] if args}
        if case.part == "number" and given[".kinds"][0]:
            picture, gate = given["number"][0], case.args[0][2] if len(case.args[0]) > 2 else 4.0
            belief = given[".state"][0], given[".covariance"][0], given[".kinds"][0]
            together = own["associate"](*belief, picture, picture.covariance, gate)
            parts = [picture.part([i]) for i in range(len(picture))]
            alone = [own["associate"](*belief, part, part.covariance, gate)[0] for part in parts]
            differ.append(list(together) != alone)
    assert any(differ)


@pytest.mark.parametrize("name", ["EkfSlam", "GraphSlam"])
def test_without_noise_a_drive_is_the_truth(own, name):
    start = Pose(0.5, -0.3, 0.2)
    log, end = exact_log(start)
    slam = own[name](start)
    for motion, seen in log:
        if motion is not None:
            slam.move(motion)
        slam.observe(seen)
    estimated = slam.estimate()
    assert np.allclose(estimated.pose.as_array(), end.as_array(), atol=1e-6)
    away = np.linalg.norm(estimated.landmarks[:, None] - LANDMARKS, axis=2).min(axis=1)
    assert away.max() < 1e-6


def test_drawn_measurements_have_the_stated_covariance():
    errors = []
    for seed in range(60):
        each = association_problem(seed, 0.1, 0.1)
        exact = range_and_bearing(each.pose.as_array(), LANDMARKS[list(each.origins)])
        away = (each.observation.values - exact).ravel()
        errors.append(away @ np.linalg.solve(each.observation.covariance, away) / len(away))
    assert 0.7 < np.median(errors) < 1.4


@pytest.mark.slow
def test_joint_compatibility_is_right_more_often_than_nearest_neighbour(own):
    assert right_share(associate_jointly) > right_share(own["associate"]) + 5


@pytest.mark.slow
def test_a_gate_of_one_breeds_a_second_map(own):
    drive = drawn_drive(0, 15)
    tight, jointly = follow(own["EkfSlam"], drive, 1.0), follow(own["EkfSlam"], drive, 3.0, associate_jointly)
    assert len(tight.estimate.kinds) > len(LANDMARKS) + 3
    assert len(jointly.estimate.kinds) < len(tight.estimate.kinds)
    assert len(run_slam(own["EkfSlam"](drive.start), drive.log[:3])) == 3
