"""Logs of drives with measurements of landmarks, in the formats of Carnegie Mellon's and Freiburg's courses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.datasets.files import brief, data_folder, lines_of, number_of
from nao_course.geometry import FloatArray

# Limits far above any real log, but low enough that a malicious file cannot use much memory or time.
LARGEST_LOG = 8_000_000  # bytes
MOST_LANDMARKS = 1_000
LARGEST_NUMBER = 1e6  # m or rad


@dataclass(frozen=True, eq=False)
class HomeworkLog:
    """A drive with measurements of all landmarks after each step; the identities of the landmarks are known.

    Parameters
    ----------
    measurements : ndarray, shape (M + 1, 2k)
        Bearing and range of each of k landmarks, rad and m, at the start and after each control.
    controls : ndarray, shape (M, 2)
        Commanded (distance, turn) of each step, m and rad: drive along the heading, then turn.

    Raises
    ------
    ValueError
        If the shapes do not fit each other.
    """

    measurements: FloatArray
    controls: FloatArray

    def __post_init__(self) -> None:
        """Check the shapes."""
        for name in ("measurements", "controls"):
            object.__setattr__(self, name, np.array(getattr(self, name), dtype=float))
        measured, commanded = self.measurements.shape, self.controls.shape
        if len(measured) != 2 or measured[1] % 2 or not measured[1] or commanded != (measured[0] - 1, 2):
            raise ValueError(
                "a HomeworkLog has measurements (M + 1, 2k) and controls (M, 2); "
                f"got the shapes {measured} and {commanded}"
            )

    @property
    def k(self) -> int:
        """Number of landmarks."""
        return self.measurements.shape[1] // 2


class Observations(NamedTuple):
    """The measurements from one pose.

    Parameters
    ----------
    indices : ndarray of int, shape (n,)
        Index of each measured landmark in `FreiburgLog.landmarks`.
    measurements : ndarray, shape (2n,)
        Bearing and range of each landmark in turn, rad and m. A range can be negative if the robot is very near to a
        landmark, because the noise of Freiburg's log does not depend on the range.
    """

    indices: npt.NDArray[np.intp]
    measurements: FloatArray


@dataclass(frozen=True, eq=False)
class FreiburgLog:
    """A drive with measurements of some landmarks after each step; the identities of the landmarks are known.

    Parameters
    ----------
    landmarks : ndarray, shape (k, 2)
        True positions, m.
    odometry : ndarray, shape (M, 3)
        Measured motion (turn, distance, turn) of each step, rad, m and rad: turn, drive, turn again.
    observations : tuple of Observations
        Measurements after each step.
    """

    landmarks: FloatArray
    odometry: FloatArray
    observations: tuple[Observations, ...]


# --- the homework's format ---


def read_homework_log(path: Path | str | None = None) -> HomeworkLog:
    """Read a log in the format of Carnegie Mellon's homework 16-833.

    The odd lines, and the last one of them at the end, contain the bearings and ranges of k landmarks in turn, 2k
    numbers. The even lines contain the distance and the turn of a control.

    Parameters
    ----------
    path : path, optional
        Path of the file; by default the log of the homework in `data_folder()`.

    Returns
    -------
    HomeworkLog
        Contents of the file.

    Raises
    ------
    FileNotFoundError
        If no path is given and there is no data folder.
    ValueError
        If the file is missing, empty, too large or malformed. The message contains the file and the line.
    """
    path = data_folder() / "slam" / "cmu16833_hw2" / "data.txt" if path is None else Path(path)
    measurements, controls = list[list[float]](), list[list[float]]()
    for where, words in _lines(path):
        if len(measurements) == len(controls):
            wanted = len(measurements[0]) if measurements else None
            measurements.append(_bearings_and_ranges(words, wanted, where))
        elif len(words) == 2:
            controls.append([_number(word, where) for word in words])
        else:
            raise ValueError(f"{where}: a control is a distance and a turn, got {_count(words)}")
    if len(measurements) == len(controls):
        raise ValueError(f"{path}: the log ends with a control; the measurements after it are missing")
    return HomeworkLog(np.array(measurements), np.array(controls).reshape(-1, 2))


def write_homework_log(log: HomeworkLog, path: Path | str, decimals: int = 4) -> Path:
    """Write a log in the homework's format, which `read_homework_log` reads.

    Parameters
    ----------
    log : HomeworkLog
        Log to write.
    path : path
        Path of the file, which is overwritten if it exists.
    decimals : int
        Number of decimals; the homework's log has 4.

    Returns
    -------
    Path
        Path of the file.
    """
    path = Path(path)
    rows = [log.measurements[0]]
    for control, measured in zip(log.controls, log.measurements[1:], strict=True):
        rows += [control, measured]
    lines = ["\t".join(f"{value:z.{decimals}f}" for value in row) for row in rows]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")
    return path


def _bearings_and_ranges(words: list[str], wanted: int | None, where: str) -> list[float]:
    """Return the numbers of a line of measurements; `wanted` is the count in the first line."""
    if len(words) % 2:
        raise ValueError(f"{where}: each landmark has a bearing and a range, got {_count(words)}")
    if wanted is not None and len(words) != wanted:
        raise ValueError(f"{where}: expected {wanted} numbers, as in the first line, got {len(words)}")
    if len(words) > 2 * MOST_LANDMARKS:
        raise ValueError(f"{where}: expected at most {MOST_LANDMARKS} landmarks, got {len(words) // 2}")
    values = [_number(word, where) for word in words]
    for number, distance in enumerate(values[1::2]):
        if distance < 0:
            raise ValueError(f"{where}: the range of landmark {number} is negative (m): {distance}")
    return values


# --- Freiburg's format ---


def read_freiburg_log(folder: Path | str | None = None) -> FreiburgLog:
    """Read the EKF log of Freiburg's SLAM course: ``sensor_data.dat`` and ``world.dat``.

    A line ``ODOMETRY turn distance turn`` begins a step, and a line ``SENSOR landmark range bearing`` follows for each
    measured landmark. The lines of ``world.dat`` are ``landmark x y``.

    Parameters
    ----------
    folder : path, optional
        Folder with both files; by default the one in `data_folder()`.

    Returns
    -------
    FreiburgLog
        Log with the landmarks in the order of ``world.dat``, and with bearing before range.

    Raises
    ------
    FileNotFoundError
        If no folder is given and there is no data folder.
    ValueError
        If a file is missing, empty, too large or malformed; it names file and line.
    """
    folder = data_folder() / "slam" / "freiburg" if folder is None else Path(folder)
    places = _read_world(folder / "world.dat")
    rows = {name: row for row, name in enumerate(places)}
    odometry, observations = list[list[float]](), list[dict[int, tuple[float, float]]]()
    for where, (word, *words) in _lines(folder / "sensor_data.dat"):
        if word not in ("ODOMETRY", "SENSOR") or len(words) != 3:
            raise ValueError(
                f"{where}: expected ODOMETRY or SENSOR and three numbers, got {brief(' '.join([word, *words]))}"
            )
        if word == "ODOMETRY":
            odometry.append([_number(each, where) for each in words])
            observations.append({})
        elif not odometry:
            raise ValueError(f"{where}: a measurement before the first ODOMETRY")
        else:
            _add_observation(observations[-1], rows, words, where)
    return FreiburgLog(
        np.array(list(places.values())), np.array(odometry), tuple(map(_observations, observations))
    )


def _read_world(path: Path) -> dict[str, tuple[float, float]]:
    """Return the position of each landmark by its name."""
    places = dict[str, tuple[float, float]]()
    for where, words in _lines(path):
        if len(words) != 3:
            raise ValueError(f"{where}: expected a landmark, x and y, got {_count(words)}")
        if words[0] in places:
            raise ValueError(f"{where}: landmark {brief(words[0])} is defined twice")
        if len(places) == MOST_LANDMARKS:
            raise ValueError(f"{where}: expected at most {MOST_LANDMARKS} landmarks")
        places[words[0]] = _number(words[1], where), _number(words[2], where)
    return places


def _add_observation(
    seen: dict[int, tuple[float, float]], rows: dict[str, int], words: list[str], where: str
) -> None:
    """Add the bearing and range of a SENSOR line to the measurements of a step."""
    name, distance, bearing = words[0], _number(words[1], where), _number(words[2], where)
    if name not in rows:
        raise ValueError(f"{where}: landmark {brief(name)} is not in world.dat")
    if rows[name] in seen:
        raise ValueError(f"{where}: landmark {brief(name)} is measured twice in one step")
    seen[rows[name]] = bearing, distance


def _observations(seen: dict[int, tuple[float, float]]) -> Observations:
    return Observations(
        np.array(list(seen), dtype=np.intp), np.array(list(seen.values()), dtype=float).reshape(-1)
    )


def _lines(path: Path) -> Iterator[tuple[str, list[str]]]:
    return lines_of(path, LARGEST_LOG)


def _number(word: str, where: str) -> float:
    return number_of(word, where, LARGEST_NUMBER)


def _count(words: list[str]) -> str:
    return say_count(len(words), "number")
