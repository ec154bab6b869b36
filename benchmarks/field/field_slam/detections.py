"""What the lessons' detectors and the library's line reader see on a drive.

The pictures are rendered once and kept in build/; what is seen in them too, until a detector changes.
"""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

import cv2
from rich.progress import track

from benchmarks import BUILD, ROOT
from benchmarks.pictures.pipeline import CORNERS, quick_labels
from benchmarks.pictures.posts import OWN
from nao_course.field_slam import lines
from nao_course.field_slam.drives import Shot, drive_over_field
from nao_course.field_slam.lines import read_lines
from nao_course.geometry import FloatArray, Pose
from nao_course.sim import CameraView, Field, Picture
from nao_course.slam import Motion

FOLDER = BUILD / "field_slam"
LANDMARKS = Field(2012).landmarks
SOURCES = ("01_hsl_filtering", "02_goalposts", "03_hough_corners")  # of the detectors, beside the lines'


@dataclass(frozen=True, eq=False)
class Seen:
    """What was found in a picture, and what is true of it.

    Parameters
    ----------
    motion : Motion or None
        The command before it.
    pose : Pose
        The true one, in the field's frame.
    view, true_view : CameraView
        What the robot believes, and how its camera looked.
    posts, corners : ndarray, shape (N, 2)
        By lessons 02 and 03, px.
    lines : ndarray, shape (N, 4)
        By the library, px without the lens.
    marks : tuple of (int, (float, float))
        Numbers of the field's landmarks in the picture, and their true pixels.
    """

    motion: Motion | None
    pose: Pose
    view: CameraView
    true_view: CameraView
    posts: FloatArray
    corners: FloatArray
    lines: FloatArray
    marks: tuple[tuple[int, tuple[float, float]], ...]


def see(shot: Shot) -> Seen:
    """Run the detectors on a picture."""
    pixels, view = shot.picture.pixels, shot.picture.view
    labels = quick_labels(pixels)
    marks = tuple((LANDMARKS.index(mark.landmark), mark.pixel) for mark in shot.truth.landmarks)
    posts, corners = OWN["find_goalposts"](labels), CORNERS["find_corners"](labels)
    return Seen(
        shot.motion, shot.pose, view, shot.truth.view, posts, corners, read_lines(pixels, view), marks
    )


def shots(seed: int, factor: float = 1.0) -> list[Shot]:
    """Return the pictures of a drive: from its file in build/ if that is there, else rendered."""
    path = FOLDER / "pictures" / f"{factor:g}_{seed}.pickle"
    if not path.is_file():
        _write(path, [_packed(shot) for shot in drive_over_field(seed, factor=factor)])
    return [_unpacked(shot) for shot in _read(path)]


def detections(seed: int, factor: float = 1.0) -> list[Seen]:
    """Return what is seen on a drive: from its file in build/ if that is there, and no detector is younger."""
    path = FOLDER / _detectors() / f"{factor:g}_{seed}.pickle"
    if not path.is_file():
        _write(path, [see(shot) for shot in shots(seed, factor)])
    return _read(path)


def prepare(seeds: Sequence[int], factor: float = 1.0, jobs: int = 2) -> None:
    """Render what is missing of some drives, and look at it, with progress."""
    with ProcessPoolExecutor(jobs) as pool:
        waiting = pool.map(_prepare, seeds, [factor] * len(seeds))
        for _ in track(waiting, f"drives, odometry {factor:g}", len(seeds)):
            pass


def _prepare(seed: int, factor: float) -> None:
    cv2.setNumThreads(1)
    detections(seed, factor)


def _detectors() -> str:
    """Return a name that changes with the code of the detectors."""
    own = Path(lines.__file__), *(ROOT / "solutions" / f"{each}.md" for each in SOURCES)
    return sha256(b"".join(path.read_bytes() for path in own)).hexdigest()[:12]


def _packed(shot: Shot) -> Any:
    """Return a shot with losslessly compressed pixels."""
    ok, png = cv2.imencode(".png", shot.picture.pixels)
    assert ok
    return shot.motion, png, shot.picture.view, shot.picture.camera, shot.pose, shot.truth


def _unpacked(packed: Any) -> Shot:
    motion, png, view, camera, pose, truth = packed
    pixels = cv2.imdecode(png, cv2.IMREAD_UNCHANGED)
    return Shot(motion, Picture(pixels, view, camera), pose, truth)


def _write(path: Path, drive: list[Any]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = path.with_suffix(".part")
    whole.write_bytes(pickle.dumps(drive))
    whole.replace(path)


def _read(path: Path) -> list[Any]:
    found = pickle.loads(path.read_bytes())  # written by this module alone
    assert isinstance(found, list)
    return found
