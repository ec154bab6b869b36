"""Annotated pictures that a real NAO took in Amsterdam in 2013."""

from __future__ import annotations

import json
import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path, PureWindowsPath
from typing import Literal, NoReturn, assert_never, get_args

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.datasets.files import brief, contents, data_folder, text_of
from nao_course.geometry import Pose
from nao_course.sim.camera import LARGEST_SIZE
from nao_course.sim.field import Shape

Pixels = npt.NDArray[np.uint8]
PointKind = Literal["X", "L", "T", "post_foot", "post_top"]
PictureSet = Literal["scenes", "straightwalk"]

LARGE_SUFFIX = "_1280x960"  # of the folder with the larger versions of a set's pictures

# Limits far above any real file, but low enough that a malicious file cannot use much memory or time.
LARGEST_ANNOTATIONS = 4_000_000  # bytes
LARGEST_PICTURE = 64_000_000  # bytes
MOST_PICTURES = 10_000
MOST_POINTS = 1_000


def shape_on_ground(kind: PointKind) -> Shape | None:
    """Return the shape of the landmark that a point of this kind shows; None for a point above the ground."""
    match kind:
        case "X" | "L" | "T":
            return kind
        case "post_foot":
            return "post"
        case "post_top":
            return None
    assert_never(kind)


@dataclass(frozen=True)
class AnnotatedPoint:
    """A point of the field that a person has marked in a picture.

    Parameters
    ----------
    kind : "X", "L", "T", "post_foot" or "post_top"
        A crossing (a mark, or the circle with the halfway line), a corner of two lines (L or T), the foot of a goal
        post, or the place where the crossbar meets a post.
    u, v : float
        Column and row in `RealPicture.pixels`, px. A point at the very edge may lie just outside.
    """

    kind: PointKind
    u: float
    v: float


@dataclass(frozen=True)
class RealPicture:
    """A picture by a real NAO with its annotations.

    Parameters
    ----------
    name : str
        File name of the picture.
    path : Path
        Path of the picture.
    pose : Pose
        Pose of the robot in the field frame, where it was put by hand; m and rad.
    head_yaw, head_pitch : float
        Angles of the head's joints as reported by the robot, rad; positive to the left and down.
    points : tuple of AnnotatedPoint
        Points that were marked by hand; there may be none.
    """

    name: str
    path: Path
    pose: Pose
    head_yaw: float
    head_pitch: float
    points: tuple[AnnotatedPoint, ...]

    @cached_property
    def pixels(self) -> Pixels:
        """RGB picture of shape (height, width, 3). It is read at first use, and it is read-only."""
        pixels = self.read()
        pixels.setflags(write=False)
        return pixels

    @property
    def large_path(self) -> Path:
        """Path of the picture's larger version, which may not exist."""
        folder = self.path.parent
        return folder.parent / f"{folder.name}{LARGE_SUFFIX}" / self.name

    @property
    def has_large(self) -> bool:
        """Whether the picture has a larger version."""
        return self.large_path.is_file()

    def read(self, large: bool = False) -> Pixels:
        """Read the picture from its file.

        Parameters
        ----------
        large : bool
            Whether to read the version of 1280 x 960 pixels.

        Returns
        -------
        ndarray of uint8, shape (height, width, 3)
            RGB picture.

        Raises
        ------
        ValueError
            If there is no larger version, or the file cannot be read as a PNG picture.
        """
        if large and not self.has_large:
            raise ValueError(
                f"{self.name} has no version of 1280 x 960 pixels (check .has_large): use read() without large=True"
            )
        return _read_png(self.large_path if large else self.path)


def read_pictures(name: PictureSet, folder: Path | str | None = None) -> tuple[RealPicture, ...]:
    """Read a set of annotated pictures from Amsterdam, 2013.

    Parameters
    ----------
    name : "scenes" or "straightwalk"
        Name of the set: 64 pictures from eight places in eight directions, or 30 pictures of a walk along the field.
    folder : path, optional
        Folder with ``amsterdam_2013``; by default `data_folder()`.

    Returns
    -------
    tuple of RealPicture
        Pictures in the order of the annotations.

    Raises
    ------
    FileNotFoundError
        If no folder is given and there is no data folder.
    ValueError
        If there is no such set, or if its annotations or a picture are missing or malformed. The message contains the
        file and the entry.
    """
    if name not in get_args(PictureSet):
        raise ValueError(f"name must be one of {list(get_args(PictureSet))}, got {name!r}")
    root = (data_folder() if folder is None else Path(folder)) / "amsterdam_2013" / name
    path = root / "annotations.json"
    entries = _read_json(path)
    if not isinstance(entries, list) or not 0 < len(entries) <= MOST_PICTURES:
        raise ValueError(f"{path}: expected a list of 1 to {MOST_PICTURES} pictures, got {brief(entries)}")
    pictures = tuple(_picture(root, path, number, entry) for number, entry in enumerate(entries))
    names = [picture.name for picture in pictures]
    for number, file in enumerate(names):
        if file in names[:number]:
            raise ValueError(f"{path}, entry {number}: the picture {file!r} is annotated twice")
    return pictures


# --- one picture's annotations ---


def _picture(root: Path, path: Path, number: int, entry: object) -> RealPicture:
    """Convert an entry of annotations.json to a picture."""
    where = f"{path}, entry {number}"
    if not isinstance(entry, dict):
        raise ValueError(f"{where}: expected an object, got {brief(entry)}")
    name = _file_name(entry, where)
    where += f" ({name})"
    if not (root / name).is_file():
        raise ValueError(f"{where}: there is no such picture in {root}")
    points = entry.get("points")
    if not isinstance(points, list) or len(points) > MOST_POINTS:
        raise ValueError(f"{where}: points must be a list of at most {MOST_POINTS}, got {brief(points)}")
    return RealPicture(
        name=name,
        path=root / name,
        pose=Pose(
            _number(entry, "x_m", where),
            _number(entry, "y_m", where),
            math.radians(_number(entry, "theta_deg", where)),
        ),
        head_yaw=_number(entry, "head_yaw_rad", where, largest=math.pi),
        head_pitch=_number(entry, "head_pitch_rad", where, largest=math.pi),
        points=tuple(_point(point, f"{where}, point {i}") for i, point in enumerate(points)),
    )


def _point(entry: object, where: str) -> AnnotatedPoint:
    """Convert an entry of a picture's points to an annotated point."""
    if not isinstance(entry, dict):
        raise ValueError(f"{where}: expected an object, got {brief(entry)}")
    kind = entry.get("kind")
    for known in get_args(PointKind):
        if kind == known:
            u, v = (_number(entry, key, where, largest=LARGEST_SIZE) for key in ("u", "v"))
            return AnnotatedPoint(known, u, v)
    raise ValueError(f"{where}: kind must be one of {list(get_args(PointKind))}, got {brief(kind)}")


def _file_name(entry: Mapping[str, object], where: str) -> str:
    """Return the file name of an entry, or raise an error if it is not a plain name of a PNG file."""
    name = entry.get("file")
    if not isinstance(name, str) or len(name) > 255 or not name.lower().endswith(".png"):
        raise ValueError(f"{where}: file must be the name of a .png picture, got {brief(name)}")
    if not name.isprintable() or PureWindowsPath(name).name != name:
        raise ValueError(f"{where}: file must be a plain file name without a folder, got {brief(name)}")
    return name


def _number(entry: Mapping[str, object], key: str, where: str, largest: float = 1e6) -> float:
    """Return a finite number of an entry, or raise an error with the value that was found."""
    value = entry.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= largest:
        raise ValueError(f"{where}: {key} must be a number within +-{largest:g}, got {brief(value)}")
    return float(value)


# --- files ---


def _read_json(path: Path) -> object:
    """Read a JSON file from an unknown source."""

    def refuse(constant: str) -> NoReturn:
        raise ValueError(f"{constant} is not a JSON number")

    try:
        loaded: object = json.loads(text_of(path, LARGEST_ANNOTATIONS), parse_constant=refuse)
    except RecursionError:
        raise ValueError(f"{path}: is nested too deeply") from None
    except ValueError as error:  # also JSONDecodeError and UnicodeDecodeError
        message = str(error)
        raise ValueError(
            message if message.startswith(str(path)) else f"{path}: is not JSON: {message}"
        ) from None
    return loaded


def _read_png(path: Path) -> Pixels:
    """Read a PNG file as RGB, after checking the size in its header, because a small file may expand enormously."""
    data = contents(path, LARGEST_PICTURE)
    if data[:8] != b"\x89PNG\r\n\x1a\n" or len(data) < 24:
        raise ValueError(f"{path}: is not a PNG picture")
    width, height = struct.unpack(">II", data[16:24])
    if not (0 < width <= LARGEST_SIZE and 0 < height <= LARGEST_SIZE):
        raise ValueError(f"{path}: a side must have 1 to {LARGEST_SIZE} pixels, got {width} x {height}")
    try:
        picture = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    except cv2.error:
        picture = None
    if picture is None:
        raise ValueError(f"{path}: the PNG picture is damaged")
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_BGR2RGB), dtype=np.uint8)
