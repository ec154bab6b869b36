"""The raw log of Victoria Park is read with its trunks, or refused with the file and the variable."""

import struct
import zlib

import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st

from nao_course.datasets import matlab, read_victoria_park, victoria_park

AHEAD, LEFT = victoria_park.LASER
ANGLES = np.arange(361) * np.pi / 360 - np.pi / 2


def scan(*trunks):
    """Return the ranges of a laser among round trunks (x, y, radius) in cm; a beam without an echo has 8191."""
    ranges = np.full(361, 81.91)
    for x, y, radius in trunks:
        along = x * np.cos(ANGLES) + y * np.sin(ANGLES)
        inside = radius**2 - (x**2 + y**2 - along**2)
        hit = (inside > 0) & (along > 0)
        ranges[hit] = np.minimum(ranges[hit], along[hit] - np.sqrt(inside[hit]))
    return np.round(100 * ranges).astype(np.uint16)


def a_log():
    """Return a log in the form of the data set's three files: columns, times in ms, ranges in cm with 3 more bits."""
    return {
        "aa3_dr.mat": {
            "time": np.array([[21940], [21965], [21990]], dtype=np.int32),
            "speed": np.array([[0.0], [2.0], [2.0]]),
            "steering": np.array([[0.0], [0.0], [0.3]]),
        },
        "aa3_lsr2.mat": {
            "LASER": np.array([scan(), scan((8, 3, 0.3), (20, -10, 0.4)) | 0xE000, scan((8, 3, 0.3))]),
            "TLsr": np.array([[21819], [22033], [22246]], dtype=np.uint32),
        },
        "aa3_gpsx.mat": {
            "timeGps": np.array([[20967], [21968]], dtype=np.int32),
            "La_m": np.array([[-41.7], [-41.6]]),
            "Lo_m": np.array([[-67.6], [-67.7]]),
        },
    }


def folder_of(folder, log, compress=False):
    for name, variables in log.items():
        scipy.io.savemat(folder / name, variables, do_compression=compress)
    return folder


@pytest.mark.parametrize("compress", [False, True])
def test_trunks_odometry_and_gps_have_their_times_and_the_cars_frame(tmp_path, compress):
    log = read_victoria_park(folder_of(tmp_path, a_log(), compress))
    assert log.times == pytest.approx(np.array([22.033, 22.033, 22.246]))
    bearing, distance = log.measurements.T
    x, y = distance * np.cos(bearing), distance * np.sin(bearing)
    true = np.array([[20, -10], [8, 3], [8, 3]]) + [AHEAD, LEFT]
    assert np.column_stack([x, y]) == pytest.approx(true, abs=0.1)
    assert log.widths == pytest.approx([0.8, 0.6, 0.6], abs=0.1)
    assert log.gps.tolist() == [[20.967, -67.6, -41.7], [21.968, -67.7, -41.6]]
    assert log.odometry[:2].tolist() == [[21.94, 0, 0], [21.965, 2, 0]]


def test_the_wheel_of_the_encoder_and_the_axle_turn_around_one_centre(tmp_path):
    files = a_log()
    files["aa3_dr.mat"]["steering"] = np.array([[-0.5], [-0.2], [0.4]])
    files["aa3_dr.mat"]["speed"] = np.array([[1.0], [2.0], [-3.0]])
    _, velocity, turn = read_victoria_park(folder_of(tmp_path, files)).odometry.T
    assert velocity - turn * 0.76 == pytest.approx([1.0, 2.0, -3.0])  # the speed of the left rear wheel
    assert np.arctan2(turn * 2.83, velocity)[:2] == pytest.approx([-0.5, -0.2])  # direction of the front axle


@pytest.mark.parametrize(
    "trunks",
    [
        [(10, 0, 0.6)],  # wider than a trunk
        [(0.2, 10, 0.3)],  # at the end of the scan
        [(0.2, -10, 0.3)],  # at its beginning
        [(10, 0, 0.2), (7, 0.4, 0.3)],  # partly hidden behind another trunk, which is found
        [(10, 0, 0.2), (7, -0.4, 0.3)],  # on its other side
        [(0.9, 0, 0.1)],  # on the car
    ],
)
def test_what_is_wide_or_partly_hidden_or_on_the_car_is_no_trunk(tmp_path, trunks):
    files = a_log()
    files["aa3_lsr2.mat"]["LASER"][:] = scan(*trunks)
    log = read_victoria_park(folder_of(tmp_path, files))
    assert len(log.times) == 3 * (len(trunks) - 1)
    for x, y, _ in trunks[1:]:
        assert log.measurements[0, 1] == pytest.approx(np.hypot(x + AHEAD, y + LEFT), abs=0.05)


def test_a_wall_that_goes_away_is_no_trunk(tmp_path):
    files = a_log()
    wall = np.full(361, 8191, dtype=np.uint16)
    wall[180:190] = 1000 + 12 * np.arange(10)
    files["aa3_lsr2.mat"]["LASER"][:] = wall
    assert len(read_victoria_park(folder_of(tmp_path, files)).times) == 0


@pytest.mark.parametrize(
    ("file", "name", "value", "message"),
    [
        ("aa3_dr.mat", "steering", None, "the variable steering is missing; expected time, speed, steering"),
        ("aa3_dr.mat", "steering", [0.0, 0, 1.5], r"steering must be within \+-1 rad, got 1.5"),
        ("aa3_dr.mat", "speed", [0.0, np.nan, 1], "speed must be numbers within"),
        ("aa3_dr.mat", "speed", [0.0, 1], r"speed must have the shape \(3,\), got \(2,\)"),
        ("aa3_dr.mat", "speed", [0.0, 1j, 1], "speed is not an array of real numbers"),
        ("aa3_dr.mat", "time", [0, 2, 1], "time must be at least 2 times that do not decrease"),
        ("aa3_dr.mat", "time", "abc", "time is not an array of real numbers"),
        ("aa3_gpsx.mat", "La_m", {"a": 1.0}, "La_m is not an array of real numbers"),
        ("aa3_gpsx.mat", "Lo_m", np.array([1.0, "a"], dtype=object), "Lo_m is not an array of real numbers"),
        ("aa3_gpsx.mat", "timeGps", [], "timeGps must be at least 2 times"),
        ("aa3_lsr2.mat", "LASER", np.zeros((3, 181)), r"LASER must have the shape \(3, 361\)"),
        (
            "aa3_lsr2.mat",
            "LASER",
            np.full((3, 361), -1),
            "LASER must be values from 0 to 65535, got -1 to -1",
        ),
    ],
)
def test_a_wrong_variable_is_refused_with_its_file_and_name(tmp_path, file, name, value, message):
    log = a_log()
    log[file][name] = value
    if value is None:
        del log[file][name]
    with pytest.raises(ValueError, match=rf"{file}: .*{message}") as caught:
        read_victoria_park(folder_of(tmp_path, log))
    assert len(str(caught.value)) < 400


def test_a_missing_foreign_or_large_file_is_refused_by_name(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"aa3_dr\.mat: cannot be read"):
        read_victoria_park(tmp_path)
    folder_of(tmp_path, a_log())
    good = (tmp_path / "aa3_gpsx.mat").read_bytes()
    for data in (good[:100], good[:-8], b"a text " * 50, b"\x89HDF\r\n\x1a\n" + bytes(200)):
        (tmp_path / "aa3_gpsx.mat").write_bytes(data)
        with pytest.raises(ValueError, match=r"aa3_gpsx\.mat: cannot be read as a MATLAB file"):
            read_victoria_park(tmp_path)
    monkeypatch.setattr(victoria_park, "LARGEST_FILE", 100)
    with pytest.raises(ValueError, match=r"aa3_dr\.mat: expected 1 to 100 bytes, got more"):
        read_victoria_park(tmp_path)


def element(kind, data):
    return struct.pack("<II", kind, len(data)) + data + bytes(0 if kind == 15 else -len(data) % 8)


def test_a_file_that_would_fill_the_memory_is_refused(tmp_path, monkeypatch):
    folder_of(tmp_path, a_log())
    path = tmp_path / "aa3_gpsx.mat"
    monkeypatch.setattr(victoria_park, "LARGEST_FILE", 1_000_000)
    path.write_bytes(path.read_bytes()[:128] + element(15, zlib.compress(bytes(5_000_000))))
    with pytest.raises(ValueError, match=r"aa3_gpsx\.mat: .*too large after it has been decompressed"):
        read_victoria_park(tmp_path)


@settings(max_examples=80, deadline=None)
@given(
    name=st.sampled_from(sorted(a_log())),
    place=st.integers(0, 5_000),
    bits=st.integers(1, 255),
    cut=st.booleans(),
    compress=st.booleans(),
)
def test_random_edits_of_a_good_log_give_a_log_or_a_message(
    tmp_path_factory, name, place, bits, cut, compress
):
    folder = folder_of(tmp_path_factory.mktemp("edited"), a_log(), compress)
    data = bytearray((folder / name).read_bytes())
    place %= len(data)
    data[place] ^= bits
    (folder / name).write_bytes(data[:place] if cut else data)
    try:
        log = read_victoria_park(folder)
    except ValueError as error:
        said = str(error)
    else:
        said = str(folder / name)
        assert len(log.times) == len(log.measurements) == len(log.widths)
        assert all(np.isfinite(values).all() for values in (log.odometry, log.measurements, log.gps))
    assert str(folder / name) in said


def test_the_limit_also_holds_for_several_small_compressed_variables():
    part = element(15, zlib.compress(bytes(600)))
    with pytest.raises(ValueError, match="too large after"):
        list(matlab._matrices(memoryview(part + part), "<", 1000))
