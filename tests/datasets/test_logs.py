"""A log is read as a whole or refused with its file and line; what is written is read again."""

from pathlib import Path

import numpy as np
import pytest

from nao_course.datasets import HomeworkLog, read_freiburg_log, read_homework_log, write_homework_log
from nao_course.datasets.logs import LARGEST_LOG

SEEN = "0.1 2.0 -0.2 3.5"  # two landmarks
GOOD = [SEEN, "1.0 0.5", SEEN, "0.5 -0.25", SEEN]


def written(folder: Path, lines: list[str] | str) -> Path:
    path = folder / "data.txt"
    path.write_text(lines if isinstance(lines, str) else "\n".join(lines))
    return path


def changed(line: int, to: str) -> list[str]:
    return [*GOOD[: line - 1], to, *GOOD[line:]]


def test_measurements_and_controls_stand_in_turn_and_a_written_log_is_read_if_its_shapes_fit(tmp_path, rng):
    log = read_homework_log(written(tmp_path, GOOD))
    assert log.measurements.tolist() == [[0.1, 2.0, -0.2, 3.5]] * 3
    assert log.controls.tolist() == [[1.0, 0.5], [0.5, -0.25]]
    assert log.k == 2
    log = HomeworkLog(np.abs(rng.normal(size=(8, 6))).round(4), rng.normal(size=(7, 2)).round(4))
    again = read_homework_log(write_homework_log(log, tmp_path / "own.txt"))
    assert np.array_equal(again.measurements, log.measurements)
    assert np.array_equal(again.controls, log.controls)
    assert (tmp_path / "own.txt").read_text().splitlines()[1].count("\t") == 1
    with pytest.raises(ValueError, match=r"got the shapes \(3, 4\) and \(3, 2\)"):
        HomeworkLog(np.zeros((3, 4)), np.zeros((3, 2)))
    with pytest.raises(ValueError, match="HomeworkLog has"):
        HomeworkLog(np.zeros((3, 3)), np.zeros((2, 2)))


@pytest.mark.parametrize("text", [SEEN, SEEN + "\t\r\n\r\n"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_one_line_a_mark_at_the_beginning_and_empty_lines_at_the_end_are_a_log(tmp_path, text, encoding):
    path = tmp_path / "data.txt"
    path.write_text(text, encoding=encoding, newline="")
    log = read_homework_log(path)
    assert log.measurements.shape == (1, 4) and log.controls.shape == (0, 2)


@pytest.mark.parametrize(
    ("line", "to", "message"),
    [
        (3, "0.1 2.0 -0.2", "line 3: each landmark has a bearing and a range, got 3 numbers"),
        (3, "0.1 2.0", "line 3: expected 4 numbers, as in the first line, got 2"),
        (2, "1.0", "line 2: a control is a distance and a turn, got 1 number$"),
        (3, "0.1 2.0 nan 3.5", "line 3: expected a number within .*got 'nan'"),
        (4, "1_0 0", "line 4: expected a number within .*got '1_0'"),
        (5, "0.1 2.0 -0.2 -3.5", "line 5: the range of landmark 1 is negative"),
        (3, "", "line 3: the line is empty"),
        (2, "x" * 5000 + " 0", "line 2: expected a number"),
    ],
)
def test_a_wrong_line_is_refused_with_its_file_and_number(tmp_path, line, to, message):
    with pytest.raises(ValueError, match=rf"data\.txt, {message}") as caught:
        read_homework_log(written(tmp_path, changed(line, to)))
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty file"),
        (" \n \n", "empty file"),
        ("1 " * (LARGEST_LOG // 2 + 1), "got more"),
        ("1 2 " * 1001, "line 1: expected at most 1000 landmarks, got 1001"),
        ("\n".join(GOOD[:4]), "ends with a control"),
    ],
    ids=["empty", "blank", "huge", "wide", "cut off"],
)
def test_a_wrong_file_is_refused_by_its_name(tmp_path, text, message):
    with pytest.raises(ValueError, match=rf"data\.txt.*{message}"):
        read_homework_log(written(tmp_path, text))


def test_a_file_that_is_missing_or_no_text_is_refused_by_its_name(tmp_path):
    with pytest.raises(ValueError, match=r"data\.txt: cannot be read"):
        read_homework_log(tmp_path / "data.txt")
    (tmp_path / "data.txt").write_bytes(b"\xff\xfe1\x00\x00")
    with pytest.raises(ValueError, match=r"data\.txt: it is not text"):
        read_homework_log(tmp_path / "data.txt")


def test_the_homeworks_own_log_has_six_landmarks_and_turns_last(data_dir):
    log = read_homework_log(data_dir / "slam" / "cmu16833_hw2" / "data.txt")
    assert (log.k, log.measurements.shape, log.controls.shape) == (6, (30, 12), (29, 2))
    assert log.measurements[0, :2].tolist() == [1.1072, 6.7060]


WORLD = ["1 2 1", "7 0 4"]
SENSOR = ["ODOMETRY 0.1 1.0 0.0", "SENSOR 7 4.0 0.5", "SENSOR 1 2.0 -0.5", "ODOMETRY 0 1 0"]


def freiburg(folder: Path, world: list[str], sensor: list[str]) -> Path:
    (folder / "world.dat").write_text("\n".join(world))
    (folder / "sensor_data.dat").write_text("\n".join(sensor))
    return folder


def test_freiburgs_sights_name_rows_and_have_the_bearing_first(tmp_path):
    log = read_freiburg_log(freiburg(tmp_path, WORLD, SENSOR))
    assert log.landmarks.tolist() == [[2.0, 1.0], [0.0, 4.0]]
    assert log.odometry.tolist() == [[0.1, 1.0, 0.0], [0.0, 1.0, 0.0]]
    first, second = log.observations
    assert first.indices.tolist() == [1, 0]
    assert first.measurements.tolist() == [0.5, 4.0, -0.5, 2.0]
    assert second.indices.shape == second.measurements.shape == (0,)


@pytest.mark.parametrize(
    ("file", "line", "to", "message"),
    [
        ("world.dat", 2, "7 0", "line 2: expected a landmark, x and y, got 2 numbers"),
        ("world.dat", 2, "1 0 4", "line 2: landmark '1' is defined twice"),
        ("sensor_data.dat", 1, "SENSOR 1 2.0 0", "line 1: a measurement before the first ODOMETRY"),
        ("sensor_data.dat", 2, "SENSOR 7 4.0", "line 2: expected ODOMETRY or SENSOR and three numbers"),
        ("sensor_data.dat", 2, "LASER 7 4.0 0", "line 2: expected ODOMETRY or SENSOR .*'LASER 7 4.0 0'"),
        ("sensor_data.dat", 3, "SENSOR 7 4.0 0.5", "line 3: landmark '7' is measured twice"),
        ("sensor_data.dat", 3, "SENSOR 2 4.0 0.5", "line 3: landmark '2' is not in world.dat"),
        ("sensor_data.dat", 3, "", "line 3: the line is empty"),
    ],
)
def test_a_wrong_line_of_freiburgs_is_refused_with_its_file_and_number(tmp_path, file, line, to, message):
    lines = {"world.dat": list(WORLD), "sensor_data.dat": list(SENSOR)}
    lines[file][line - 1] = to
    with pytest.raises(ValueError, match=rf"{file}, {message}"):
        read_freiburg_log(freiburg(tmp_path, lines["world.dat"], lines["sensor_data.dat"]))


def test_freiburgs_own_log_is_read_to_its_end(data_dir):
    log = read_freiburg_log(data_dir / "slam" / "freiburg")
    assert (log.landmarks.shape, log.odometry.shape) == ((9, 2), (331, 3))
    assert sum(len(each.indices) for each in log.observations) == 1212
    assert min(each.measurements[1::2].min() for each in log.observations) == pytest.approx(-0.0351, abs=1e-4)
