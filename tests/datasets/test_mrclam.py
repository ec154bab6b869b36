"""A drive of the MRCLAM data set is read with its landmarks, or refused with file and line."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nao_course.datasets import mrclam, read_mrclam_log

# The headings and the first lines of data set 1 of UTIAS; robot 2 has barcode 14, landmark 11 has barcode 90.
FILES = {
    "Barcodes.dat": ["# Subject #    Barcode #", "  2 \t  14", "  9 \t  63", " 11 \t  90"],
    "Landmark_Groundtruth.dat": [
        "# Subject #    x [m]    y [m]    x std-dev [m]    y std-dev [m]",
        "  9 \t 2.31446307 \t 3.37498700 \t 0.00011799 \t 0.00012106",
        " 11 \t 1.32133260 \t 1.39570160 \t 0.00011402 \t 0.00018145",
    ],
    "Robot1_Odometry.dat": [
        "# Time [s]    forward velocity [m/s]    angular velocity[rad/s]",
        "1248272272.841 \t  0.074 \t  0.229",
        "1248272272.852 \t  0.074 \t  -0.229",
    ],
    "Robot1_Measurement.dat": [
        "# Time [s]    Subject #    range [m]    bearing [rad]",
        "1248272276.038 \t  90 \t  2.148 \t  0.025",
        "1248272277.773 \t  63 \t  3.309 \t -0.015",
        "1248272277.773 \t  90 \t  2.033 \t  0.024",
    ],
    "Robot1_Groundtruth.dat": [
        "# Time [s]    x [m]    y [m]    orientation [rad]",
        "1248272272.841 \t 1.41277290 \t -3.89107760 \t 2.26960000",
    ],
}


def folder_of(folder, files):
    for name, lines in files.items():
        (folder / name).write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder


def with_line(name: str, line: int, to: str) -> dict[str, list[str]]:
    lines = FILES[name]
    return FILES | {name: [*lines[: line - 1], to, *lines[line:]]}


def test_barcodes_name_landmarks_and_a_missing_empty_or_large_file_is_refused_by_name(tmp_path, monkeypatch):
    log = read_mrclam_log(folder_of(tmp_path, FILES))
    assert log.names.tolist() == [9, 11]
    assert log.landmarks.tolist() == [[2.31446307, 3.374987], [1.3213326, 1.3957016]]
    assert log.odometry.tolist() == [[1248272272.841, 0.074, 0.229], [1248272272.852, 0.074, -0.229]]
    assert log.times.tolist() == [1248272276.038, 1248272277.773, 1248272277.773]
    assert log.indices.tolist() == [1, 0, 1]
    assert log.measurements.tolist() == [[0.025, 2.148], [-0.015, 3.309], [0.024, 2.033]]
    assert log.truth.tolist() == [[1248272272.841, 1.4127729, -3.8910776, 2.2696]]
    with pytest.raises(ValueError, match=r"Robot3_Odometry\.dat: cannot be read"):
        read_mrclam_log(folder_of(tmp_path, FILES), robot=3)
    with pytest.raises(ValueError, match=r"Barcodes\.dat: expected lines of numbers, got an empty file"):
        read_mrclam_log(folder_of(tmp_path, FILES | {"Barcodes.dat": [""]}))
    monkeypatch.setattr(mrclam, "LARGEST_FILE", 80)
    with pytest.raises(ValueError, match=r"Landmark_Groundtruth\.dat: expected 1 to 80 bytes, got more"):
        read_mrclam_log(folder_of(tmp_path, FILES))


@pytest.mark.parametrize(
    ("barcode", "message"),
    [
        (14, "left out 1 measurement of other robots"),
        (99, "left out 1 measurement whose barcodes are not in Barcodes"),
    ],
)
def test_measurements_of_robots_and_of_unknown_barcodes_are_left_out_and_said(tmp_path, barcode, message):
    files = with_line("Robot1_Measurement.dat", 3, f"1248272277.773 {barcode} 3.309 -0.015")
    with pytest.warns(UserWarning, match=message):
        log = read_mrclam_log(folder_of(tmp_path, files))
    assert log.indices.tolist() == [1, 1]


@pytest.mark.parametrize(
    ("name", "line", "to", "message"),
    [
        ("Barcodes.dat", 2, "2 14 3", "Barcodes.dat, line 2: expected a subject and its barcode"),
        ("Barcodes.dat", 2, "2 90", "Barcodes.dat: expected another integer in each line"),
        ("Landmark_Groundtruth.dat", 2, "9 0 0", "line 2: expected a landmark, x, y and two"),
        ("Robot1_Odometry.dat", 3, "1 nan 0", "Robot1_Odometry.dat, line 3: expected a number .*'nan'"),
        ("Robot1_Odometry.dat", 3, "1 0.074", "line 3: expected a time and two velocities"),
        ("Robot1_Measurement.dat", 4, "1 90 1_0 0", "line 4: expected a number within .*'1_0'"),
        ("Robot1_Groundtruth.dat", 2, "1 0 0 x", "Robot1_Groundtruth.dat, line 2: expected a number .*'x'"),
    ],
)
def test_a_wrong_line_is_refused_with_its_file_and_number(tmp_path, name, line, to, message):
    with pytest.raises(ValueError, match=message) as caught:
        read_mrclam_log(folder_of(tmp_path, with_line(name, line, to)))
    assert len(str(caught.value)) < 300


@settings(max_examples=80, deadline=None)
@given(
    name=st.sampled_from(sorted(FILES)),
    line=st.integers(1, 4),
    to=st.text("0123456789.-+e# \tnaif\n", max_size=30),
)
def test_random_edits_of_a_good_log_give_a_log_or_a_message(name, line, to, tmp_path_factory):
    folder = folder_of(tmp_path_factory.mktemp("edited"), with_line(name, line, to))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        try:
            log = read_mrclam_log(folder)
        except ValueError as error:
            said = str(error)
        else:
            said = f"{folder} is a log"
            assert len(log.times) == len(log.indices) == len(log.measurements)
            assert np.isfinite(log.measurements).all()
    assert str(folder) in said
