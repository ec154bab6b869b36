"""Logs of CARMEN, the robot toolkit of Carnegie Mellon University: laser scans with the poses of the odometry."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nao_course.datasets.files import brief, lines_of, number_of
from nao_course.geometry import FloatArray

# Limits far above any real log, but low enough that a malicious file cannot use much memory or time.
LARGEST_LOG = 60_000_000  # bytes
LARGEST_NUMBER = 1e10  # m, rad or s; times are seconds since 1970
MOST_RANGES = 10_000
SPACING = {180: np.pi / 180, 360: np.pi / 360}  # of a FLASER line, which omits the last of 181 or 361 beams


@dataclass(frozen=True, eq=False)
class CarmenLog:
    """The scans of the front laser, in the order of the file.

    Parameters
    ----------
    times : ndarray, shape (N,)
        Time of each scan, s.
    odometry : ndarray, shape (N, 3)
        Pose of the robot by its odometry (x, y, theta), m and rad.
    laser_poses : ndarray, shape (N, 3)
        Pose of the laser (x, y, theta), m and rad. In published logs that a SLAM program has corrected, it is the
        corrected pose.
    angles : ndarray, shape (n,)
        Direction of each beam in the frame of the laser, rad; the first one points to the right.
    ranges : ndarray, shape (N, n)
        Distance along each beam, m. A beam that hits nothing has the largest range of the laser or more.
    """

    times: FloatArray
    odometry: FloatArray
    laser_poses: FloatArray
    angles: FloatArray
    ranges: FloatArray


def read_carmen_log(path: Path | str) -> CarmenLog:
    """Read the FLASER or ROBOTLASER1 lines of a log of CARMEN; lines of other messages are skipped.

    A FLASER line does not contain the angles of its beams. As in CARMEN, they begin at -90 degrees and are 1 degree
    (180 or 181 beams) or half a degree (360 or 361 beams) apart. Any other number of beams
    spans 180 degrees, except that 400 and 401 beams are refused.

    Parameters
    ----------
    path : path
        Path of the file.

    Returns
    -------
    CarmenLog
        All scans.

    Raises
    ------
    ValueError
        If the file is missing, empty, too large or malformed, if it has no scans, or if two scans have different
        angles. The message contains the file and the line.
    """
    path = Path(path)
    rows, angles = list[FloatArray](), np.zeros(0)
    for where, (tag, *words) in lines_of(path, LARGEST_LOG, comment="#"):
        if tag not in ("FLASER", "ROBOTLASER1"):
            continue
        before = 0 if tag == "FLASER" else 7
        count = _count(words, before, where)
        beams = words[before + 1 : before + 1 + count]
        rest = words[before + 1 + count :]
        if tag == "ROBOTLASER1":
            rest = rest[1 + _count(rest, 0, where) :]
        poses, tail = rest[:6], rest[6 + (0 if tag == "FLASER" else 5) :]
        if len(beams) < count or len(tail) != 3:
            raise ValueError(
                f"{where}: {tag} needs {count} ranges, two poses{'' if tag == 'FLASER' else ', 5 numbers'}, a time, a "
                f"host and a time; got {1 + len(words)} words"
            )
        if tag == "FLASER" and count in (400, 401):
            raise ValueError(
                f"{where}: the angles of {count} beams are not known; such a laser covers 100 degrees, but CARMEN "
                "lets it begin at -90"
            )
        if tag == "FLASER":
            start, spacing = -np.pi / 2, SPACING.get(count, np.pi / max(count - 1, 1))
        else:
            start, spacing = (number_of(words[place], where, LARGEST_NUMBER) for place in (1, 3))
        here = start + spacing * np.arange(count, dtype=float)
        if rows and not np.array_equal(here, angles):
            raise ValueError(f"{where}: the beams have other angles than in the scans before")
        angles = here
        rows.append(np.array([number_of(word, where, LARGEST_NUMBER) for word in (tail[0], *poses, *beams)]))
    if not rows:
        raise ValueError(f"{path}: no line begins with FLASER or ROBOTLASER1")
    table = np.array(rows)
    return CarmenLog(table[:, 0], table[:, 4:7], table[:, 1:4], angles, table[:, 7:])


def _count(words: list[str], place: int, where: str) -> int:
    """Return the number of ranges or remissions, which is one of the words."""
    word = words[place] if place < len(words) else ""
    if not (word.isascii() and word.isdigit() and len(word) < 10 and int(word) <= MOST_RANGES):
        raise ValueError(f"{where}: expected a count from 0 to {MOST_RANGES}, got {brief(word)}")
    return int(word)
