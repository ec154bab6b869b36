"""Scans of a log of CARMEN have the odometry's pose, the laser's pose and the angles that CARMEN gives them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nao_course.datasets import carmen, read_carmen_log

HEADING = [
    "# CARMEN Logfile",
    "PARAM robot_front_laser_max 81.9 1 host 1",
    "ODOM 0 0 0 0 0 0 10.0 host 10.0",
    "",
]
# num_readings [ranges] laser pose, robot pose, time host time
FLASER = "FLASER 3 1.0 2.0 81.91 1 2 0.5 0.9 1.9 0.4 12.5 host 0.6"
# type, start, field of view, spacing, largest range, accuracy, remission mode, num_readings [ranges]
# num_remissions [remissions] laser pose, robot pose, tv rv forward side axis, time host time
SCAN = "0 -1.5 3.0 1.5 81.9 0.01 0 3 1.0 2.0 81.91 1 0.7"
ROBOTLASER = f"ROBOTLASER1 {SCAN} 1 2 0.5 0.9 1.9 0.4 0.1 0.2 0 0 0 13.5 host 0.7"


def written(folder, lines):
    path = folder / "log.clf"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("line", "time", "angles"),
    [(FLASER, 12.5, [-np.pi / 2, 0, np.pi / 2]), (ROBOTLASER, 13.5, [-1.5, 0, 1.5])],
)
def test_a_scan_has_the_pose_of_the_robot_behind_the_pose_of_the_laser(tmp_path, line, time, angles):
    log = read_carmen_log(written(tmp_path, [*HEADING, line, line]))
    assert log.times.tolist() == [time, time]
    assert log.odometry.tolist() == [[0.9, 1.9, 0.4]] * 2
    assert log.laser_poses.tolist() == [[1, 2, 0.5]] * 2
    assert log.ranges.tolist() == [[1.0, 2.0, 81.91]] * 2
    assert log.angles == pytest.approx(angles)


@pytest.mark.parametrize(("beams", "last"), [(180, 89), (181, 90), (360, 89.5), (361, 90), (91, 90)])
def test_the_beams_of_an_old_scan_begin_at_the_right_and_are_spaced_as_carmen_says(tmp_path, beams, last):
    """CARMEN's own table: 180 and 181 beams are 1 degree apart, 360 and 361 half a degree."""
    line = f"FLASER {beams} {'1 ' * beams} 0 0 0 0 0 0 1 host 1"
    angles = np.degrees(read_carmen_log(written(tmp_path, [line])).angles)
    assert angles[[0, -1]] == pytest.approx([-90, last])


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (FLASER.replace(" 81.91", ""), "line 6: FLASER needs 3 ranges, two poses, a time, .*got 13 words"),
        (FLASER.replace("FLASER 3", "FLASER -3"), "line 6: expected a count from 0 to 10000, got '-3'"),
        (FLASER.replace("1.9", "nan"), "line 6: expected a number within .*'nan'"),
        (FLASER.replace("3 1.0 2.0", "4 1.0 1.0 2.0"), "line 6: the beams have other angles"),
        (f"FLASER 400 {'1 ' * 406} 1 host 1", "line 6: the angles of 400 beams are not known"),
        (ROBOTLASER, "line 6: the beams have other angles"),
        (ROBOTLASER.replace("81.91 1 0.7", "81.91 5 0.7"), "line 6: ROBOTLASER1 needs 3 ranges"),
        (ROBOTLASER.replace("ROBOTLASER1 0 -1.5", "ROBOTLASER1 0 inf"), "line 6: .*'inf'"),
    ],
)
def test_a_wrong_line_is_refused_with_its_file_and_number(tmp_path, line, message):
    with pytest.raises(ValueError, match=rf"log\.clf, {message}") as caught:
        read_carmen_log(written(tmp_path, [*HEADING, FLASER, line]))
    assert len(str(caught.value)) < 300


def test_a_file_without_scans_or_that_is_too_large_is_refused_by_its_name(tmp_path, monkeypatch):
    for lines, message in (([""], "empty file"), (HEADING, "no line begins with FLASER")):
        with pytest.raises(ValueError, match=rf"log\.clf: .*{message}"):
            read_carmen_log(written(tmp_path, lines))
    monkeypatch.setattr(carmen, "LARGEST_LOG", 20)
    with pytest.raises(ValueError, match=r"log\.clf: expected 1 to 20 bytes, got more"):
        read_carmen_log(written(tmp_path, [FLASER]))


@settings(max_examples=80, deadline=None)
@given(
    place=st.integers(0, 60),
    word=st.sampled_from(
        ["", "0", "-1", "2", "nan", "1e99", "x", "\n", "#", "FLASER", "9" * 20, "4 1", "\u00b2"]
    ),
    line=st.sampled_from([FLASER, ROBOTLASER]),
)
def test_random_edits_of_a_good_log_give_a_log_or_a_message(place, word, line, tmp_path_factory):
    words = " \n ".join([line, line]).split(" ")
    words[place % len(words)] = word
    path = written(tmp_path_factory.mktemp("edited"), [" ".join(words)])
    try:
        log = read_carmen_log(path)
    except ValueError as error:
        said = str(error)
    else:
        said = f"{path} is a log"
        assert log.ranges.shape == (len(log.times), len(log.angles)) and np.isfinite(log.ranges).all()
    assert str(path) in said
