"""The raw log of Victoria Park: a car's odometry, the tree trunks in its laser scans, and GPS."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from nao_course.datasets.files import brief
from nao_course.datasets.matlab import matlab_variables
from nao_course.geometry import FloatArray

# Limits far above any real log, but low enough that a malicious file cannot use much memory or time.
LARGEST_FILE = 50_000_000  # bytes
LARGEST_NUMBER = 1e10  # m, m/s or ms

# The car and the laser, as info.txt and car.bmp of the data set describe them.
WHEELBASE = 2.83  # m
ENCODER = 0.76  # m from the middle of the rear axle to its left wheel, whose speed is measured
# The laser, and the antenna of the GPS above it, in m ahead and to the left of the middle of the rear axle.
LASER = 0.95 + WHEELBASE, 0.5
LARGEST_STEERING = 1.0  # rad
BEAMS = 361
SPACING = np.pi / 360  # rad; the first beam points to the right
LARGEST_VALUE = 0xFFFF  # of the laser, in cm
RANGE_BITS = 0x1FFF  # of a value; the other three are the intensity

# A trunk is a short run of beams before a more distant background.
FARTHEST, NEAREST = 75.0, 1.0  # m
GAP = 1.5  # m: least change of the range from a trunk to the background
WIDEST = 1.0  # m
SLANT = 1 / 3  # largest difference of the ranges at both sides, in parts of the width


@dataclass(frozen=True, eq=False)
class VictoriaParkLog:
    """A drive of a car among trees whose identities are not known.

    The position of the car is the middle of its rear axle, which always moves along the heading.

    Parameters
    ----------
    odometry : ndarray, shape (M, 3)
        Time, velocity along the heading, and angular velocity, s, m/s and rad/s.
    times : ndarray, shape (N,)
        Time of each measurement, s. Trunks that are found in one scan have the same time.
    measurements : ndarray, shape (N, 2)
        Bearing and range of the centre of the trunk from the middle of the rear axle, rad and m.
    widths : ndarray, shape (N,)
        Diameter of the trunk, m.
    gps : ndarray, shape (T, 3)
        Time and position of the antenna (x to the east, y to the north), s and m. The antenna is above the laser.
        The GPS has gaps and jumps.
    """

    odometry: FloatArray
    times: FloatArray
    measurements: FloatArray
    widths: FloatArray
    gps: FloatArray


def read_victoria_park(folder: Path | str) -> VictoriaParkLog:
    """Read the raw log of Victoria Park: ``aa3_dr.mat``, ``aa3_lsr2.mat`` and ``aa3_gpsx.mat``.

    The speed of the left rear wheel and the steering angle are converted to the motion of the rear axle (Ackermann
    steering). In the laser scans, a trunk is a short run of beams, at most a metre wide, with a more distant background
    on both sides.

    Parameters
    ----------
    folder : path
        Folder with the three files.

    Returns
    -------
    VictoriaParkLog
        Contents of the files in the order of time.

    Raises
    ------
    ValueError
        If a file is missing, empty, too large or malformed. The message contains the file and the variable.
    """
    folder = Path(folder)
    time, speed, steering = _columns(folder / "aa3_dr.mat", {"time": (), "speed": (), "steering": ()})
    if not (np.abs(steering) <= LARGEST_STEERING).all():
        raise ValueError(
            f"{folder / 'aa3_dr.mat'}: steering must be within +-{LARGEST_STEERING:g} rad, "
            f"got {np.abs(steering).max():g}"
        )
    velocity = speed / (1 - ENCODER / WHEELBASE * np.tan(steering))
    odometry = np.column_stack([time / 1000, velocity, velocity * np.tan(steering) / WHEELBASE])
    scan_time, scans = _columns(folder / "aa3_lsr2.mat", {"TLsr": (), "LASER": (BEAMS,)})
    if (scans < 0).any() or (scans > LARGEST_VALUE).any():
        raise ValueError(
            f"{folder / 'aa3_lsr2.mat'}: LASER must be values from 0 to {LARGEST_VALUE}, "
            f"got {scans.min():g} to {scans.max():g}"
        )
    rows, measurements, widths = _trunks((scans.astype(np.uint16) & RANGE_BITS) / 100)
    gps_time, east, north = _columns(folder / "aa3_gpsx.mat", {"timeGps": (), "Lo_m": (), "La_m": ()})
    return VictoriaParkLog(
        odometry,
        scan_time[rows] / 1000,
        measurements,
        widths,
        np.column_stack([gps_time / 1000, east, north]),
    )


def _trunks(scans: FloatArray) -> tuple[npt.NDArray[np.intp], FloatArray, FloatArray]:
    """Return the scan, the bearing and range from the rear axle, and the width of each trunk in scans (N, 361), m."""
    # A beam without an echo is far behind everything. A range of 0 at both ends of a scan makes a run there partly
    # hidden, because it may continue outside the scan.
    beams = np.pad(np.where(scans < FARTHEST, scans, 10 * FARTHEST), ((0, 0), (1, 1))).ravel()
    steps = np.diff(beams)
    edges = np.flatnonzero(np.abs(steps) > GAP)
    first, last = edges[:-1] + 1, edges[1:]
    distance = (beams[first] + beams[last]) / 2
    widths = (last - first + 1) * SPACING * distance
    kept = (
        (steps[first - 1] < 0)
        & (steps[last] > 0)
        & (distance > NEAREST)
        & (widths < WIDEST)
        & (np.abs(beams[last] - beams[first]) < SLANT * widths)
    )
    rows, column = np.divmod(first[kept], BEAMS + 2)
    angle = ((column - 1) + (last - first)[kept] / 2) * SPACING - np.pi / 2
    middle = (beams[(first + last) // 2] + beams[(first + last + 1) // 2]) / 2
    centre = (middle + widths / 2)[kept]
    x, y = LASER[0] + centre * np.cos(angle), LASER[1] + centre * np.sin(angle)
    return rows, np.column_stack([np.arctan2(y, x), np.hypot(x, y)]), widths[kept]


def _columns(path: Path, shapes: dict[str, tuple[int, ...]]) -> list[FloatArray]:
    """Return variables of a file, given with the shape of their rows; the first one contains the time of each row."""
    columns = list[FloatArray]()
    for name, values in matlab_variables(path, LARGEST_FILE, tuple(shapes)).items():
        if not isinstance(values, np.ndarray):
            raise ValueError(f"{path}: {name} is not an array of real numbers")
        if not columns and (values.ndim != 1 or len(values) < 2 or (np.diff(values) < 0).any()):
            raise ValueError(
                f"{path}: {name} must be at least 2 times that do not decrease, got {brief(str(values))}"
            )
        wanted = (len(columns[0] if columns else values), *shapes[name])
        if values.shape != wanted:
            raise ValueError(f"{path}: {name} must have the shape {wanted}, got {values.shape}")
        if not (np.abs(values) <= LARGEST_NUMBER).all():
            raise ValueError(
                f"{path}: {name} must be numbers within +-{LARGEST_NUMBER:g}, got {brief(str(values))}"
            )
        columns.append(values)
    return columns
