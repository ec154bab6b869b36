"""What the lessons' detectors and the library's line reader see on a drive; pictures and detections stay in build/."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from benchmarks import BUILD, ROOT, in_processes, solution
from nao_course.colours import GREEN, YELLOW
from nao_course.field_slam import lines
from nao_course.field_slam.drives import Shot, drive_over_field
from nao_course.field_slam.lines import Pixels, read_lines
from nao_course.geometry import FloatArray, Pose
from nao_course.sim import CameraView, Field, Picture
from nao_course.slam import Motion

FOLDER = BUILD / "drives"
LANDMARKS = Field(2012).landmarks
SOURCES = ("01_hsl_filtering", "02_goalposts", "03_hough_corners")  # of the detectors, beside the lines'
FLOOR = 0.16  # of the saturation


@dataclass(frozen=True, eq=False)
class Seen:
    """Detections and truth of a picture."""

    motion: Motion | None  # the command before it
    pose: Pose  # true pose in the field's frame
    view: CameraView  # what the robot believes, and how its camera looked
    true_view: CameraView
    posts: FloatArray  # (N, 2): by lessons 02 and 03, px
    corners: FloatArray
    lines: FloatArray  # (N, 4): by the library, px without the lens


def quick_labels(picture: Pixels) -> Pixels:
    """Return lesson 01's labels by OpenCV's colours: hue in half degrees, saturation and lightness as integers."""
    hls = cv2.cvtColor(picture, cv2.COLOR_RGB2HLS)
    lightness = cv2.extractChannel(hls, 1)
    labels = np.zeros(lightness.shape, dtype=np.uint8)
    for number, (low, high) in ((1, GREEN), (2, YELLOW)):
        limits = np.ceil((low / 2, 0, 255 * FLOOR)), np.floor((high / 2, 255, 255))
        labels[cv2.inRange(hls, *limits).view(np.bool_)] = number
    labels[lightness > solution("01")["white_threshold"](cv2.mean(lightness)[0])] = 3
    return labels


def see(shot: Shot) -> Seen:
    """Run the detectors on a picture."""
    pixels, view = shot.picture.pixels, shot.picture.view
    labels = quick_labels(pixels)
    posts, corners = solution("02")["find_goalposts"](labels), solution("03")["find_corners"](labels)
    return Seen(shot.motion, shot.pose, view, shot.truth.view, posts, corners, read_lines(pixels, view))


def shots(seed: int, factor: float = 1.0) -> list[Shot]:
    """Return the pictures of a drive: from its file in build/ if that is there, else rendered."""
    path = FOLDER / "pictures" / f"{factor:g}_{seed}.pickle"
    if not path.is_file():
        _write(path, [_packed(shot) for shot in drive_over_field(seed, factor=factor)])
    return [_unpacked(shot) for shot in _read(path)]


def detections(seed: int, factor: float = 1.0) -> list[Seen]:
    """Return what is seen on a drive: from its file in build/ if that is there, and no detector is younger."""
    own = Path(lines.__file__), *(ROOT / "solutions" / f"{each}.md" for each in SOURCES)
    detectors = sha256(b"".join(path.read_bytes() for path in own)).hexdigest()[:12]
    path = FOLDER / detectors / f"{factor:g}_{seed}.pickle"
    if not path.is_file():
        _write(path, [see(shot) for shot in shots(seed, factor)])
    return _read(path)


def prepare(seeds: Sequence[int], factor: float = 1.0) -> None:
    """Render what is missing of some drives, and look at it."""
    in_processes(partial(_prepare, factor), seeds, f"drives, odometry {factor:g}")


def _prepare(factor: float, seed: int) -> None:
    detections(seed, factor)


def _packed(shot: Shot) -> Any:
    """Return a shot with losslessly compressed pixels."""
    ok, png = cv2.imencode(".png", shot.picture.pixels)
    assert ok
    return shot.motion, png, shot.picture.view, shot.picture.camera, shot.pose, shot.truth


def _unpacked(packed: Any) -> Shot:
    motion, png, view, camera, pose, truth = packed
    return Shot(motion, Picture(cv2.imdecode(png, cv2.IMREAD_UNCHANGED), view, camera), pose, truth)


def _write(path: Path, drive: list[Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = path.with_suffix(".part")
    whole.write_bytes(pickle.dumps(drive))
    whole.replace(path)


def _read(path: Path) -> list[Any]:
    found = pickle.loads(path.read_bytes())  # written by this module alone
    assert isinstance(found, list)
    return found
