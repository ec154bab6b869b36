"""A recording is what was driven, survives a crash at any letter, and is refused with its line where it is wrong."""

import json

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.robot import RecordedNao, Recorder, RobotError
from nao_course.sim import SimulatedNao
from nao_course.slam import Motion


@pytest.fixture
def folder(tmp_path):
    nao = SimulatedNao(rng=1)
    recorder = Recorder(tmp_path / "drive", nao)
    for distance in (0.1, 0.2):
        recorder.motion(nao.walk(distance), nao.odometry)
        recorder.picture(nao.take_picture("top"), nao.head)
    nao.look(0.2, 0.1)
    recorder.look(nao.head)
    recorder.picture(nao.take_picture("bottom"), nao.head)
    recorder.close()
    return tmp_path / "drive"


def test_pictures_come_back_without_loss_and_motions_are_those_of_the_recording(folder):
    nao, twin = RecordedNao(folder), SimulatedNao(rng=1)
    with pytest.raises(RobotError, match="no picture of the top camera here"):
        nao.take_picture("top")
    assert nao.walk(5.0) == twin.walk(0.1) and nao.odometry == twin.odometry
    taken, own = nao.take_picture("top"), twin.take_picture("top")
    assert np.array_equal(taken.pixels, own.pixels) and taken.view == own.view
    assert np.array_equal(nao.take_picture("top").pixels, own.pixels)  # the last one, again
    assert nao.take_picture("top", (160, 120)).view.size == (160, 120)
    assert not nao.is_over
    nao.turn(1.0)
    nao.look(0.0, 0.0)
    assert nao.head == (0.2, 0.1) and nao.is_over and nao.odometry == Pose(0.30000000000000004, 0.0, 0.0)
    with pytest.raises(RobotError, match="ends here"):
        nao.move(Motion(0.1))


def test_a_crash_at_any_letter_of_the_last_line_loses_this_line_alone(folder):
    path = folder / "events.jsonl"
    whole = path.read_bytes()
    before = len(whole[:-1].rpartition(b"\n")[0]) + 1
    for cut in range(before, len(whole)):
        path.write_bytes(whole[:cut])
        assert len(RecordedNao(folder)._events) == 5
    path.write_bytes(whole)
    with pytest.raises(RobotError, match="is not empty"):
        Recorder(folder, SimulatedNao())


def test_what_is_not_a_recording_is_refused_with_file_and_line(folder, rng):
    path = folder / "events.jsonl"
    lines = path.read_text().splitlines()
    for number, line in enumerate(lines, 1):
        event = json.loads(line)
        keys = event.keys() - {"time"}
        wrong = [{**event, key: value} for key in keys for value in (None, [], "../x", {"a": 1}, -1e999)]
        wrong += [{other: value for other, value in event.items() if other != key} for key in keys]
        for each in [*map(json.dumps, wrong), "{", "[]", "3", "[" * 5000, "x" * 20_000]:
            path.write_text("\n".join([*lines[: number - 1], each, *lines[number:]]) + "\n")
            with pytest.raises(RobotError, match=f"line {number}: not an event"):
                RecordedNao(folder)
    path.write_text("\n".join(lines) + "\n")
    (folder / "000001.png").write_bytes(b"no picture")
    nao = RecordedNao(folder)
    nao.walk(0.1)
    with pytest.raises(RobotError, match=r"000001\.png is missing, damaged"):
        nao.take_picture("top")
    for header in (
        "",
        "{}",
        "[]",
        '{"version": 2, "model": "NAO V4", "head": [0, 0]}',
        '{"version": 1, "model": "x"}',
    ):
        (folder / "robot.json").write_text(header)
        with pytest.raises(RobotError, match=r"robot\.json"):
            RecordedNao(folder)
    with pytest.raises(RobotError, match="is not a recording"):
        RecordedNao(folder / "nothing")
