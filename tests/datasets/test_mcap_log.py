"""The scans of a ROS 2 log in an MCAP file are read, or the file is refused with the message."""

import builtins
import contextlib
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nao_course.datasets import mcap_log, read_mcap_log


def text(value):
    return struct.pack("<I", len(value) + 1) + value.encode() + b"\0"


def header(time, frame):
    seconds = int(time)
    return struct.pack("<iI", seconds, round((time - seconds) * 1e9)) + text(frame)


def padded(data, size):
    return data + b"\0" * (-len(data) % size)


def scan(time=1.5, ranges=(1.0, 2.0, np.inf), start=-0.5, frame="laser"):
    numbers = struct.pack("<7f", start, 0.5, 0.5, 0, 0, 0.1, 8.0)
    values = struct.pack(f"<I{len(ranges)}f", len(ranges), *ranges)
    return b"\0\1\0\0" + padded(header(time, frame), 4) + numbers + values + struct.pack("<I", 0)


def odometry(time=1.0, x=0.0, y=0.0, heading=0.0, length=1.0):
    turn = length * np.sin(heading / 2), length * np.cos(heading / 2)
    begin = padded(padded(header(time, "odom"), 4) + text("base"), 8)
    return b"\0\1\0\0" + begin + struct.pack("<7d", x, y, 0.3, 0, 0, *turn) + bytes(8 * 78)


MESSAGES = [
    ("/odom", mcap_log.ODOMETRY, odometry(1.0)),
    ("/scan", mcap_log.SCAN, scan(1.5)),
    ("/chat", "std_msgs/msg/String", b"\0\1\0\0" + text("hello")),
    ("/odom", mcap_log.ODOMETRY, odometry(2.0, 1.0, 2.0, 1.0)),
    ("/scan", mcap_log.SCAN, scan(2.0, (3.0, 4.0, 5.0))),
]


def written(folder, messages=MESSAGES, compression="ZSTD", encoding="cdr"):
    writer_module = pytest.importorskip("mcap.writer")
    path = folder / "log.mcap"
    with path.open("wb") as file:
        writer = writer_module.Writer(file, compression=writer_module.CompressionType[compression])
        writer.start()
        kinds, topics = {}, {}
        for number, (topic, kind, data) in enumerate(messages):
            if kind not in kinds:
                kinds[kind] = writer.register_schema(kind, "ros2msg", b"")
            if topic not in topics:
                topics[topic] = writer.register_channel(topic, encoding, kinds[kind])
            writer.add_message(topics[topic], log_time=number, data=data, publish_time=number)
        writer.finish()
    return path


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_each_scan_has_the_pose_of_the_odometry_at_its_time(tmp_path, compression):
    log = read_mcap_log(written(tmp_path, compression=compression))
    assert log.times.tolist() == [1.5, 2.0] and log.angles.tolist() == [-0.5, 0.0, 0.5]
    assert log.odometry == pytest.approx(np.array([[0.5, 1.0, 0.5], [1.0, 2.0, 1.0]]))
    assert np.array_equal(log.odometry, log.laser_poses)
    assert log.ranges.tolist() == [[1, 2, 8], [3, 4, 5]]


def test_scans_without_odometry_are_left_out_and_a_topic_is_chosen_by_name(tmp_path):
    early = [("/scan", mcap_log.SCAN, scan(0.5)), *MESSAGES]
    with pytest.warns(UserWarning, match="log.mcap: left out 1 scan without odometry at the time"):
        assert len(read_mcap_log(written(tmp_path, early)).times) == 2
    path = written(tmp_path, [*MESSAGES, ("/rear", mcap_log.SCAN, scan(1.2))])
    with pytest.raises(ValueError, match="several topics of type sensor_msgs/msg/LaserScan, '/rear, /scan'"):
        read_mcap_log(path)
    assert read_mcap_log(path, scans="/rear").times.tolist() == [1.2]


@pytest.mark.parametrize(
    ("messages", "message"),
    [
        (MESSAGES[:1], "log.mcap: no message has the type sensor_msgs/msg/LaserScan"),
        (MESSAGES[1:2], "no message has the type nav_msgs/msg/Odometry"),
        ([MESSAGES[0], ("/scan", mcap_log.SCAN, scan(9.0))], "no time in common"),
        (
            [*MESSAGES, ("/scan", mcap_log.SCAN, scan(1.7, start=0.1))],
            "message 6: the beams have other angles",
        ),
        ([*MESSAGES, ("/scan", mcap_log.SCAN, scan()[:40])], "message 6: the message ends too early"),
        (
            [*MESSAGES, ("/scan", mcap_log.SCAN, b"{}")],
            "message 6: the message does not begin with the header",
        ),
        (
            [*MESSAGES, ("/scan", mcap_log.SCAN, scan(1.7, start=np.nan))],
            "message 6: expected numbers within",
        ),
        ([*MESSAGES, ("/scan", mcap_log.SCAN, scan(1.7, (1e20,)))], "message 6: expected numbers within"),
        (
            [*MESSAGES, ("/odom", mcap_log.ODOMETRY, odometry(2.5, np.inf))],
            "message 6: expected numbers within",
        ),
        (
            [*MESSAGES, ("/odom", mcap_log.ODOMETRY, odometry(2.5, length=0.5))],
            "message 6: .* not a quaternion",
        ),
    ],
)
@pytest.mark.filterwarnings("ignore:.*left out")
def test_a_wrong_message_is_refused_with_its_file_and_number(tmp_path, messages, message):
    with pytest.raises(ValueError, match=message):
        read_mcap_log(written(tmp_path, messages))


def test_a_message_of_too_many_ranges_or_with_a_text_of_gigabytes_is_refused(tmp_path):
    begin = b"\0\1\0\0" + struct.pack("<iI", 1, 0)
    long = begin + struct.pack("<I", 2**32 - 1)
    many = begin + padded(text("laser"), 4) + struct.pack("<7fI", 0, 0, 1, 0, 0, 0, 8, 2**31)
    for data, message in ((long, "ends too early"), (many, "at most 10000 ranges, got 2147483648")):
        with pytest.raises(ValueError, match=message):
            read_mcap_log(written(tmp_path, [MESSAGES[0], ("/scan", mcap_log.SCAN, data)]))


def test_a_file_that_is_no_log_of_ros_2_is_refused(tmp_path, monkeypatch):
    path = written(tmp_path, encoding="ros1")
    with pytest.raises(ValueError, match="message 1: expected ROS 2's encoding cdr, got 'ros1'"):
        read_mcap_log(path)
    whole = written(tmp_path).read_bytes()
    for data in (whole[:-20], b"#ROSBAG V2.0\n" * 9, whole[:60], whole.replace(b"zstd", b"zstx")):
        path.write_bytes(data)
        with pytest.raises(ValueError, match="log.mcap: not a valid MCAP file"):
            read_mcap_log(path)
    path.write_bytes(b"")
    with pytest.raises(ValueError, match="got an empty file"):
        read_mcap_log(path)
    monkeypatch.setattr(mcap_log, "LARGEST_LOG", 100)
    path.write_bytes(whole)
    with pytest.raises(ValueError, match="expected 1 to 100 bytes, got more"):
        read_mcap_log(path)


@pytest.mark.parametrize("compression", ["zstd", "lz4"])
def test_a_chunk_that_would_fill_the_memory_is_refused(tmp_path, compression, monkeypatch):
    pytest.importorskip("mcap")
    import lz4.frame
    import zstandard

    monkeypatch.setattr(mcap_log, "LARGEST_CHUNK", 10_000)
    zeros = bytes(5_000_000)
    data = zstandard.compress(zeros) if compression == "zstd" else lz4.frame.compress(zeros)
    assert len(mcap_log._decompressed(compression, data)) == 10_001
    body = struct.pack("<QQQII", 0, 0, len(zeros), 0, len(compression)) + compression.encode()
    body += struct.pack("<Q", len(data)) + data
    magic = bytes([0x89]) + b"MCAP0\r\n"
    path = tmp_path / "log.mcap"
    path.write_bytes(
        magic + b"\x01" + struct.pack("<Q", 8) + bytes(8) + b"\x06" + struct.pack("<Q", len(body)) + body
    )
    with pytest.raises(ValueError, match="not a valid MCAP file .'its chunks are too large"):
        read_mcap_log(path)


def test_without_the_package_the_message_says_what_to_install(tmp_path, monkeypatch):
    path = tmp_path / "log.mcap"
    path.write_bytes(b"x")
    real = builtins.__import__

    def without(name, *rest, **more):
        if name.partition(".")[0] == "mcap":
            raise ModuleNotFoundError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ModuleNotFoundError, match="needs the package mcap.* pip install 'nao-course.logs.'"):
        read_mcap_log(path)


@settings(max_examples=60, deadline=None)
@given(place=st.integers(0, 10_000), byte=st.integers(0, 255), cut=st.booleans(), compressed=st.booleans())
@pytest.mark.filterwarnings("ignore:.*left out")
def test_random_edits_of_a_good_log_give_a_log_or_a_message(tmp_path_factory, place, byte, cut, compressed):
    path = written(tmp_path_factory.mktemp("edits"), compression="ZSTD" if compressed else "NONE")
    data = bytearray(path.read_bytes())
    place %= len(data)
    data[place] = byte
    path.write_bytes(data[:place] if cut else data)
    with contextlib.suppress(ValueError):
        assert np.isfinite(read_mcap_log(path).ranges).all()


def test_the_checksum_of_a_chunk_is_compared(tmp_path):
    path = written(tmp_path, compression="NONE")
    data = path.read_bytes()
    number = struct.pack("<f", 4.0)
    assert data.count(number) == 1
    path.write_bytes(data.replace(number, struct.pack("<f", 6.0)))
    with pytest.raises(ValueError, match="crc validation failed"):
        read_mcap_log(path)
