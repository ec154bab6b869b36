"""The offsets of a robot's cameras from its joints, kept in a TOML file for each robot."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path

from nao_course.geometry import finite
from nao_course.robot.interface import RobotError
from nao_course.sim import NAO_V4

Offset = tuple[float, float]
LARGEST = 0.5  # rad
_HEAD = "# How much lower than its joints report a camera looks (pitch), and is rolled to the right (roll); rad.\n"


def write_offsets(path: str | Path, offsets: Mapping[str, Offset]) -> Path:
    """Write the offsets (pitch, roll) of some cameras, rad, beside the ones in the file; return its path."""
    path = Path(path)
    kept = {**(read_offsets(path) if path.exists() else {}), **offsets}
    tables = (
        f"\n[{camera}]\npitch = {pitch:.5f}\nroll = {roll:.5f}\n" for camera, (pitch, roll) in kept.items()
    )
    path.write_text(_HEAD + "".join(tables), encoding="utf-8")
    return path


def read_offsets(path: str | Path) -> dict[str, Offset]:
    """Return the offsets (pitch, roll) of the cameras in a file, rad; raise a RobotError if it is not such a file."""
    try:
        tables = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        if wrong := sorted(tables.keys() - NAO_V4.cameras.keys()):
            raise ValueError(f"there is no camera {wrong[0]}")
        offsets = {
            camera: (finite("pitch (rad)", table["pitch"]), finite("roll (rad)", table["roll"]))
            for camera, table in tables.items()
        }
        if any(abs(each) > LARGEST for offset in offsets.values() for each in offset):
            raise ValueError(f"an offset is larger than {LARGEST} rad")
        return offsets
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise RobotError(
            f"{path} must have a table [bottom] or [top] with pitch and roll in rad ({error})"
        ) from error
