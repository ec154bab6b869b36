"""A student's filter runs on a log of the MRCLAM data set, which the reader may have downloaded."""

import re

import numpy as np
import pytest

from nao_course.exercises import try_out
from nao_course.geometry import Pose, wrap_angle
from nao_course.lessons import ekf_slam as tools
from nao_course.slam import range_and_bearing
from tests.lessons.every import text

LANDMARKS = {6: (2.0, 1.0), 9: (1.0, 3.0), 20: (-1.5, 1.0)}
BARCODES = {1: 5, 6: 45, 9: 63, 20: 7}


def written(folder, measured=tuple(LANDMARKS)):
    """Write an exact log of a circle of 1 m radius, driven in 40 s, with a measurement of a robot in between."""
    times = np.arange(0.0, 40.0, 0.1)
    speed = 2 * np.pi / 40
    lines = {"Barcodes": [f"{subject} {code}" for subject, code in BARCODES.items()]}
    lines["Landmark_Groundtruth"] = [f"{name} {x} {y} 0 0" for name, (x, y) in LANDMARKS.items()]
    lines["Robot2_Odometry"] = [f"{time:.3f} {speed} {speed}" for time in times]
    turns = speed * times
    poses = np.column_stack([np.sin(turns), 1 - np.cos(turns), wrap_angle(turns)])
    lines["Robot2_Groundtruth"] = [
        f"{time:.3f} {' '.join(map(repr, pose))}" for time, pose in zip(times, poses.tolist(), strict=True)
    ]
    lines["Robot2_Measurement"] = [f"1.0 {BARCODES[1]} 1 1"]
    for time, pose in zip(times[20::10], poses[20::10], strict=True):
        for name in (*measured, *measured[:1]):  # one of them twice at each time
            bearing, distance = range_and_bearing(Pose(*pose).as_array(), np.array([LANDMARKS[name]]))[0]
            lines["Robot2_Measurement"].append(f"{time:.3f} {BARCODES[name]} {distance} {bearing}")
    for name, rows in lines.items():
        (folder / f"{name}.dat").write_text("\n".join(["# heading", *rows]) + "\n", encoding="utf-8")
    return folder


@pytest.mark.filterwarnings("ignore:.*left out 1 measurement of other robots")
def test_an_exact_log_gives_an_exact_map(tmp_path, functions):
    said = tools.draw_mrclam(written(tmp_path), *functions, robot=2).alt
    assert "3 landmarks: median error 0 cm, largest 0 cm" in said, said
    assert float(re.search(r"is ([\d.]+)\.$", said)[1]) < 0.01
    early = tools.draw_mrclam(tmp_path, *functions, robot=2, minutes=0.05).alt
    assert "3 landmarks" in early
    with pytest.raises(ValueError, match="robot 2 measures no landmark in the first 0.01 minutes"):
        tools.draw_mrclam(tmp_path, *functions, robot=2, minutes=0.01)


def test_the_lessons_lines_say_where_the_log_is_to_be_had_and_do_nothing_else(
    functions, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (cell,) = re.findall(r"^try_out\(lambda: tools.draw_mrclam.*", text("07"), re.MULTILINE)
    names = ("predict", "update_landmarks", "add_landmark")
    message = eval(cell, {"try_out": try_out, "tools": tools} | dict(zip(names, functions, strict=True)))
    assert "no folder MRCLAM_Dataset3 here" in str(message) and "utias.utoronto.ca/datasets/mrclam" in str(
        message
    )


def test_a_damaged_log_is_named(tmp_path, functions):
    (written(tmp_path) / "Robot2_Odometry.dat").write_text("1 2\n", encoding="utf-8")
    said = str(try_out(lambda: tools.draw_mrclam(tmp_path, *functions, robot=2)))
    assert "Robot2_Odometry.dat, line 1: expected a time and two velocities" in said
