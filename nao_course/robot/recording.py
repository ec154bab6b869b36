"""Recordings of a robot's drive: written so that a crash loses at most the last line, and played back as a robot.

A recording is a folder. ``robot.json`` has the model and the format's version; ``events.jsonl`` has one line of JSON
for each picture, motion and movement of the head, in the order in which they happened; the pictures are PNG files.
"""

from __future__ import annotations

import json
import os
import time
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from nao_course.geometry import Pose
from nao_course.robot.interface import MODELS, PlacedNao, Robot, RobotError
from nao_course.sim import NAO_V4, CameraView, Field, Picture
from nao_course.slam import Motion

VERSION = 1
HEADER, EVENTS = "robot.json", "events.jsonl"
_MODELS = {model.name: model for model in MODELS.values()}
_LARGEST_LINE = 10_000  # letters: an event is a picture's name, a view and a few numbers


class Recorder:
    """Writes a recording of a robot's drive.

    Parameters
    ----------
    folder : str or Path
        New or empty folder.
    robot : Robot
        Robot that is recorded.

    Raises
    ------
    RobotError
        If the folder already holds something, because nothing recorded is overwritten.
    """

    def __init__(self, folder: str | Path, robot: Robot) -> None:
        """Make the folder and its header."""
        self.folder = Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        if any(self.folder.iterdir()):
            raise RobotError(
                f"{self.folder} is not empty: give a new folder, nothing recorded is overwritten"
            )
        head, self._origin = list(map(float, robot.head)), robot.odometry
        header = {"version": VERSION, "model": robot.model.name, "head": head}
        (self.folder / HEADER).write_text(json.dumps(header), encoding="utf-8")
        self._events = (self.folder / EVENTS).open("a", encoding="utf-8")
        self._pictures = 0

    def picture(self, picture: Picture, head: tuple[float, float]) -> None:
        """Write a picture and its view."""
        self._pictures += 1
        name = f"{self._pictures:06d}.png"
        done, written = cv2.imencode(".png", cv2.cvtColor(picture.pixels, cv2.COLOR_RGB2BGR))
        assert done  # of uint8 pixels
        part = self.folder / f"{name}.part"
        part.write_bytes(written.tobytes())
        part.replace(self.folder / name)
        self._write("picture", file=name, camera=picture.camera, head=list(head), view=asdict(picture.view))

    def motion(self, motion: Motion, odometry: Pose) -> None:
        """Write a motion, and the odometry after it, from (0, 0, 0) where the recording began."""
        after = (self._origin.inverse() @ odometry).as_array().tolist()
        self._write("motion", distance=motion.distance, turn=motion.turn, odometry=after)

    def look(self, head: tuple[float, float]) -> None:
        """Write the head's angles."""
        self._write("look", head=list(head))

    def close(self) -> None:
        """Close the file; what was recorded is on the disk already."""
        self._events.close()

    def _write(self, kind: str, **values: Any) -> None:
        self._events.write(json.dumps({"kind": kind, "time": time.time(), **values}) + "\n")
        self._events.flush()
        os.fsync(self._events.fileno())


class RecordedNao(PlacedNao):
    """A recorded drive as a robot: each motion is the next one of the recording, whatever is commanded.

    Parameters
    ----------
    folder : str or Path
        Folder of a recording.
    field : Field, optional
        Field on which the robot was; by default half a field by the rules of 2012.
    start : Pose, optional
        Where the drive began, in the world frame; by default on the halfway line, facing the goal.

    Raises
    ------
    RobotError
        If the folder is not a recording, or a line is not valid; the message names file and line. A last line that was
        cut by a crash is left out.
    """

    def __init__(self, folder: str | Path, field: Field | None = None, *, start: Pose | None = None) -> None:
        """Read the events; pictures are read when they are taken."""
        self.folder = Path(folder)
        header = _header(self.folder)
        super().__init__(field, _MODELS[header["model"]], start)
        self._events = list(_events(self.folder))
        self._place = 0  # of the next event
        self._head = _pair(header["head"])

    def __repr__(self) -> str:
        """Show the folder and the place in it."""
        return f"RecordedNao({self.folder.name}, {self._place} of {len(self._events)} events)"

    @property
    def is_over(self) -> bool:
        """Whether no motion is left."""
        return not any(event["kind"] == "motion" for event in self._events[self._place :])

    @property
    def head(self) -> tuple[float, float]:
        """Angles (yaw, pitch) of the head's joints, rad; positive to the left and down."""
        return self._head

    def view(self, camera: str = "bottom", size: tuple[int, int] = (320, 240)) -> CameraView:
        """Return the view of the camera's next picture, else the one of an upright body."""
        found = self._next_picture(self.model.check_camera(camera))
        if found is not None:
            return CameraView(**self._events[found]["view"]).at_size(size)
        return self.upright_view(camera, size)

    def move(self, motion: Motion) -> Motion:
        """Run the recording's next motion and return it; raise a RobotError at the end of the recording."""
        for place in range(self._place, len(self._events)):
            event = self._events[place]
            if event["kind"] == "motion":
                self._place = place + 1
                self._odometry.append(Pose(*event["odometry"]))
                return Motion(event["distance"], event["turn"])
            self._head = _pair(event["head"])
        raise RobotError(f"the recording {self.folder.name} ends here")

    def look(self, yaw: float = 0.0, pitch: float = 0.0) -> None:
        """Go to the next recorded movement of the head before the next motion, if there is one."""
        self.model.check_head(yaw, pitch)
        for place in range(self._place, len(self._events)):
            event = self._events[place]
            if event["kind"] == "motion":
                return
            if event["kind"] == "look":
                self._place, self._head = place + 1, _pair(event["head"])
                return

    def take_picture(
        self, camera: str = "bottom", size: tuple[int, int] = (320, 240), walking: bool = False
    ) -> Picture:
        """Return the camera's next picture before the next motion, else its last one, at the given size.

        Raises
        ------
        RobotError
            If this camera has taken no picture yet, or a file is missing or damaged.
        """
        found = self._next_picture(self.model.check_camera(camera))
        if found is None:
            raise RobotError(f"the recording {self.folder.name} has no picture of the {camera} camera here")
        event = self._events[found]
        self._place = max(self._place, found + 1)
        path = self.folder / event["file"]
        pixels = cv2.imread(str(path), cv2.IMREAD_COLOR) if path.is_file() else None
        view = CameraView(**event["view"])
        if pixels is None or pixels.shape != (view.size[1], view.size[0], 3):
            raise RobotError(f"{path} is missing, damaged, or not of the size in {EVENTS}")
        rgb = cv2.cvtColor(pixels, cv2.COLOR_BGR2RGB)
        if tuple(size) != view.size:
            rgb = cv2.resize(rgb, tuple(size), interpolation=cv2.INTER_AREA)
        return Picture(np.asarray(rgb, np.uint8), view.at_size(size), camera)

    def has_picture(self, camera: str) -> bool:
        """Return whether a camera takes a picture before the next motion, or has taken one."""
        return self._next_picture(self.model.check_camera(camera)) is not None

    def play(self, camera: str = "bottom") -> Iterator[tuple[tuple[Motion, ...], Picture]]:
        """Yield the remaining pictures of a camera, each with the motions since the one before."""
        motions: list[Motion] = []
        while True:
            found = self._next_picture(camera)
            if found is not None and found >= self._place:
                picture = self.take_picture(camera, CameraView(**self._events[found]["view"]).size)
                yield tuple(motions), picture
                motions = []
            elif self.is_over:
                return
            else:
                motions.append(self.move(Motion(0.0)))

    def stop(self) -> None:
        """Do nothing: a recording does not move by itself."""

    def _next_picture(self, camera: str) -> int | None:
        """Return the place of a camera's next picture before the next motion, else of its last one so far."""
        for place in range(self._place, len(self._events)):
            event = self._events[place]
            if event["kind"] == "motion":
                break
            if event["kind"] == "picture" and event["camera"] == camera:
                return place
        before = range(min(self._place, len(self._events)) - 1, -1, -1)
        found = (place for place in before if self._events[place].get("camera") == camera)
        return next(found, None)


def _header(folder: Path) -> dict[str, Any]:
    path = folder / HEADER
    try:
        header = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RobotError(
            f"{folder} is not a recording of a robot: {path} cannot be read ({error})"
        ) from error
    known = isinstance(header, dict) and header.get("version") == VERSION and header.get("model") in _MODELS
    if not known or not _is_numbers(header.get("head"), 2):
        raise RobotError(
            f"{path} must have version {VERSION}, a model of {list(_MODELS)} and the head's angles"
        )
    return header


def _events(folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the valid events of a recording; a last line without its end was cut by a crash."""
    path = folder / EVENTS
    try:
        lines = path.read_text(encoding="utf-8").split("\n")
    except (OSError, ValueError) as error:
        raise RobotError(f"{path} cannot be read ({error})") from error
    for number, line in enumerate(lines[:-1], 1):
        try:
            if len(line) > _LARGEST_LINE:
                raise ValueError("it is too long")
            yield _checked(json.loads(line))
        except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
            raise RobotError(f"{path}, line {number}: not an event of a recording ({error})") from error


def _checked(event: Any) -> dict[str, Any]:
    """Return an event unchanged; raise ValueError, TypeError or KeyError if it is something else."""
    kind = event["kind"]
    if kind == "motion":
        if not _is_numbers([event["distance"], event["turn"], *event["odometry"]], 5):
            raise ValueError("a motion has a distance, a turn and the odometry (x, y, heading)")
    elif kind in ("picture", "look"):
        if not _is_numbers(event["head"], 2):
            raise ValueError("the head has two angles")
        if kind == "picture":
            CameraView(**event["view"])
            if event["camera"] not in NAO_V4.cameras or Path(event["file"]).name != event["file"]:
                raise ValueError("a picture has a camera, top or bottom, and a file in the folder")
    else:
        raise ValueError(f"there is no kind {kind!r}")
    return dict(event)


def _is_numbers(values: Any, count: int) -> bool:
    return (
        isinstance(values, list)
        and len(values) == count
        and all(isinstance(each, int | float) and np.isfinite(each) for each in values)
    )


def _pair(values: Any) -> tuple[float, float]:
    return float(values[0]), float(values[1])
