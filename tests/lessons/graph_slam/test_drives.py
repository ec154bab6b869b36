"""Drives: what they hold is what they say, and without noise it is true."""

import numpy as np
import pytest

from nao_course.lessons.graph_slam.drives import MOTION_SIGMA, corridor, field_drive, odometry, odometry_first
from nao_course.lessons.graph_slam.map_errors import assumed_headings, with_headings


def test_without_noise_every_constraint_is_true_and_a_turn_is_taken_out_by_the_true_heading(rng):
    drive = field_drive(noise=0.0)
    for each in drive.constraints:
        before = 0 if each.kind == "start" else drive.truth[each.first]
        assert drive.truth[each.second] - before == pytest.approx(each.value)
    assert odometry(drive.constraints) == pytest.approx(drive.path)
    steps = np.diff(field_drive().path, axis=0)
    noisy = (each for seed in range(60) for each in field_drive(seed).constraints if each.kind == "motion")
    missed = [each.value - steps[each.first] for each in noisy]
    assert np.std(missed) == pytest.approx(MOTION_SIGMA, rel=0.06)
    drive = field_drive(noise=0.0, turn=0.8)
    headings = assumed_headings("true heading", 0.8, len(drive.path), rng)
    told = with_headings(drive, headings)
    straight = field_drive(noise=0.0)
    pairs = zip(drive.constraints, straight.constraints, strict=True)
    assert any((turned.value - true.value).any() for turned, true in pairs)
    for ours, true in zip(told.constraints, straight.constraints, strict=True):
        assert ours.value == pytest.approx(true.value, abs=1e-12)


def test_commands_come_first_and_then_landmarks_and_constraints_and_variables_have_names(rng):
    drive = field_drive()
    ordered = odometry_first(drive)
    kinds = [each.kind for each in ordered]
    stops, landmarks = len(drive.path), len(drive.landmarks)
    assert kinds[:stops] == ["start"] + ["motion"] * (stops - 1)
    assert len({each.second for each in ordered[stops : stops + landmarks]}) == landmarks
    assert {id(each) for each in ordered} == {id(each) for each in drive.constraints}
    drive = corridor(6, rng)
    assert drive.names[:2] == ("x0", "x1") and drive.names[6] == "L0" and len(drive.names) == drive.size
    assert drive.say(drive.constraints[0]) == "start: x0 is at (0.00, 0.00) m"
    assert any(drive.say(each).startswith("measurement: L0 - x0 = (") for each in drive.constraints)
