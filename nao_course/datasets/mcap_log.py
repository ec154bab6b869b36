"""Logs of ROS 2 in MCAP files: laser scans with the poses of the odometry. They need the optional package `mcap`."""

from __future__ import annotations

import io
import struct
import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.datasets.carmen import MOST_RANGES, CarmenLog
from nao_course.datasets.files import brief, contents
from nao_course.geometry import FloatArray

# Limits far above any real log of a small robot, but low enough that a malicious file cannot use much memory or time.
LARGEST_LOG = 500_000_000  # bytes
LARGEST_CHUNK = 50_000_000  # bytes of a chunk after decompression
LARGEST_CONTENTS = 2_000_000_000  # bytes of all chunks after decompression
LARGEST_NUMBER = 1e10

SCAN, ODOMETRY = "sensor_msgs/msg/LaserScan", "nav_msgs/msg/Odometry"


class _Message(NamedTuple):
    """A message of a topic, and its place in the file for messages to a person."""

    where: str
    topic: str
    kind: str
    data: bytes


def read_mcap_log(path: Path | str, *, scans: str | None = None, odometry: str | None = None) -> CarmenLog:
    """Read the laser scans of a ROS 2 log in an MCAP file, each with the pose of the odometry at its time.

    The poses are interpolated between the odometry's messages. Scans before the first or after the last one are left
    out with a warning. Where the laser is mounted is not read, so `laser_poses` are the robot's poses. Ranges that are
    not finite, because a beam hit nothing, become the largest range of the laser.

    Parameters
    ----------
    path : path
        Path of the file.
    scans, odometry : str, optional
        Topics of type sensor_msgs/msg/LaserScan and nav_msgs/msg/Odometry; needed only if the file has several.

    Returns
    -------
    CarmenLog
        All scans, as from `read_carmen_log`.

    Raises
    ------
    ModuleNotFoundError
        If the package `mcap` is not installed.
    ValueError
        If the file is missing, empty, too large or malformed, if it has no scans or no odometry or several topics of
        them, or if two scans have different angles. The message contains the file and the number of the message.
    """
    path = Path(path)
    data = contents(path, LARGEST_LOG)
    topics = {SCAN: scans, ODOMETRY: odometry}
    found: dict[str, list[_Message]] = {SCAN: [], ODOMETRY: []}
    for message in _messages(path, data):
        if topics[message.kind] in (None, message.topic):
            found[message.kind].append(message)
    for kind, messages in found.items():
        names = sorted({message.topic for message in messages})
        if len(names) != 1:
            several = f"several topics of type {kind}, {brief(', '.join(names))}; name the one to read"
            raise ValueError(f"{path}: " + (several if names else f"no message has the type {kind}"))
    poses = np.array([_pose(message) for message in found[ODOMETRY]])
    poses = poses[np.argsort(poses[:, 0], kind="stable")]
    rows = list[FloatArray]()
    angles, times = np.zeros(0), list[float]()
    for number, message in enumerate(found[SCAN]):
        time, here, ranges = _scan(message)
        if number and not np.array_equal(here, angles):
            raise ValueError(f"{message.where}: the beams have other angles than in the scans before")
        angles = here
        times.append(time)
        rows.append(ranges)
    moments = np.array(times)
    inside = (moments >= poses[0, 0]) & (moments <= poses[-1, 0])
    if left_out := int(np.count_nonzero(~inside)):
        warnings.warn(
            f"{path}: left out {say_count(left_out, 'scan')} without odometry at the time", stacklevel=2
        )
    if not inside.any():
        raise ValueError(f"{path}: the scans and the odometry have no time in common")
    columns = (poses[:, 1], poses[:, 2], np.unwrap(poses[:, 3]))
    at = np.column_stack([np.interp(moments[inside], poses[:, 0], column) for column in columns])
    return CarmenLog(moments[inside], at, at.copy(), angles, np.array(rows)[inside])


# --- the container ---


def _messages(path: Path, data: bytes) -> Iterator[_Message]:
    """Yield the messages of both types in the order of the file."""
    try:
        from mcap.records import Channel, Message, Schema
    except ModuleNotFoundError:
        raise ModuleNotFoundError(
            "read_mcap_log needs the package mcap, which is not installed: run pip install 'nao-course[logs]'"
        ) from None
    schemas, channels, count = dict[int, str](), dict[int, Any](), 0
    for record in _records(path, data):
        if isinstance(record, Schema):
            schemas[record.id] = record.name
        elif isinstance(record, Channel):
            channels[record.id] = record
        elif isinstance(record, Message):
            count += 1
            where = f"{path}, message {count}"
            channel = channels.get(record.channel_id)
            if channel is None:
                raise ValueError(f"{where}: there is no channel {record.channel_id}")
            kind = schemas.get(channel.schema_id, "")
            if kind not in (SCAN, ODOMETRY):
                continue
            if channel.message_encoding != "cdr":
                raise ValueError(
                    f"{where}: expected ROS 2's encoding cdr, got {brief(channel.message_encoding)}"
                )
            yield _Message(where, channel.topic, kind, record.data)


def _records(path: Path, data: bytes) -> Iterator[Any]:
    """Yield the records of a file and of its chunks, which are decompressed here, because `mcap` has no limit."""
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader, breakup_chunk

    total = 0
    try:
        for record in StreamReader(io.BytesIO(data), emit_chunks=True, record_size_limit=LARGEST_LOG).records:
            if isinstance(record, Chunk):
                raw = _decompressed(record.compression, record.data)
                total += len(raw)
                if len(raw) > LARGEST_CHUNK or total > LARGEST_CONTENTS:
                    raise ValueError("its chunks are too large after decompression")
                yield from breakup_chunk(
                    replace(record, compression="", data=raw, uncompressed_size=len(raw)), validate_crc=True
                )
            else:
                yield record
    except Exception as error:  # noqa: BLE001 - a malformed file makes `mcap` raise errors of many kinds
        raise ValueError(
            f"{path}: not a valid MCAP file ({brief(str(error) or type(error).__name__)})"
        ) from None


def _decompressed(compression: str, data: bytes) -> bytes:
    """Return the contents of a chunk, or the first `LARGEST_CHUNK` bytes and one more if it is larger."""
    if compression == "zstd":
        import zstandard

        with zstandard.ZstdDecompressor(max_window_size=2**27).stream_reader(data) as stream:
            return bytes(stream.read(LARGEST_CHUNK + 1))
    if compression == "lz4":
        import lz4.frame

        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=LARGEST_CHUNK + 1))
    if compression:
        raise ValueError(f"a chunk has the unknown compression {compression}")
    return data


# --- the messages ---


class _Cdr:
    """The values of a ROS 2 message, one after the other."""

    def __init__(self, message: _Message) -> None:
        self._where, self._data, self._at = message.where, message.data[4:], 0
        if message.data[:2] not in (b"\0\0", b"\0\1") or len(message.data) < 4:
            raise ValueError(f"{self._where}: the message does not begin with the header of cdr")
        self._order = "<" if message.data[1] else ">"

    def numbers(self, letter: str, count: int = 1) -> list[Any]:
        """Return numbers of one type, which `struct` has a letter for."""
        begin = self._skip(count, struct.calcsize(letter))
        return list(struct.unpack_from(f"{self._order}{count}{letter}", self._data, begin))

    def skip_text(self) -> None:
        """Skip a text."""
        (length,) = self.numbers("I")
        self._skip(length, 1)

    def _skip(self, count: int, size: int) -> int:
        """Go on behind values of a size, which begin at a multiple of it, and return where they begin."""
        begin = self._at + -self._at % size
        self._at = begin + count * size
        if self._at > len(self._data):
            raise ValueError(f"{self._where}: the message ends too early")
        return begin

    def time(self) -> float:
        """Return the time of a message's header in seconds, and skip its frame."""
        (seconds,), (nanoseconds,) = self.numbers("i"), self.numbers("I")
        self.skip_text()
        return float(seconds + 1e-9 * nanoseconds)


def _scan(message: _Message) -> tuple[float, FloatArray, FloatArray]:
    """Return time, angles (n,) and ranges (n,) of a scan."""
    values = _Cdr(message)
    time = values.time()
    start, _, spacing, _, _, _, largest = values.numbers("f", 7)
    (count,) = values.numbers("I")
    if count > MOST_RANGES:
        raise ValueError(f"{message.where}: expected at most {MOST_RANGES} ranges, got {count}")
    _check(message, np.array([start, spacing, largest]))
    ranges = np.array(values.numbers("f", count), dtype=float)
    ranges[~np.isfinite(ranges)] = largest
    _check(message, ranges)
    return time, start + spacing * np.arange(count, dtype=float), ranges


def _pose(message: _Message) -> FloatArray:
    """Return time, x, y and heading of an odometry's message, (4,)."""
    values = _Cdr(message)
    time = values.time()
    values.skip_text()
    x, y, _, *turn = values.numbers("d", 7)
    _check(message, np.array([x, y, *turn]))
    qx, qy, qz, qw = turn
    if not 0.9 < float(np.hypot(np.hypot(qx, qy), np.hypot(qz, qw))) < 1.1:
        raise ValueError(
            f"{message.where}: the orientation is not a quaternion of length 1: {brief(str(turn))}"
        )
    heading = np.arctan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy**2 + qz**2))
    return np.array([time, x, y, heading])


def _check(message: _Message, values: FloatArray) -> None:
    """Raise a ValueError if a value is not finite or too large."""
    wrong = ~(np.abs(values) <= LARGEST_NUMBER)
    if wrong.any():
        raise ValueError(
            f"{message.where}: expected numbers within +-{LARGEST_NUMBER:g}, got {values[np.argmax(wrong)]}"
        )
