"""Logs of the UTIAS multi-robot data set (MRCLAM): odometry, landmarks with barcodes, and the true motion."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.datasets.files import brief, lines_of, number_of
from nao_course.geometry import FloatArray

# Limits far above any real log, but low enough that a malicious file cannot use much memory or time.
LARGEST_FILE = 20_000_000  # bytes
LARGEST_NUMBER = 1e10  # s, m or rad; times are seconds since 1970


@dataclass(frozen=True, eq=False)
class MrclamLog:
    """A drive of one robot with measurements of landmarks whose identities are known.

    Parameters
    ----------
    landmarks : ndarray, shape (k, 2)
        True positions, m.
    names : ndarray of int, shape (k,)
        Numbers of the landmarks in the data set, 6 to 20.
    odometry : ndarray, shape (M, 3)
        Time, velocity along the heading, and angular velocity, s, m/s and rad/s.
    times : ndarray, shape (N,)
        Time of each measurement, s. Landmarks that are seen in one picture have the same time.
    indices : ndarray of int, shape (N,)
        Index of the measured landmark in `landmarks`.
    measurements : ndarray, shape (N, 2)
        Bearing and range of the landmark, rad and m.
    truth : ndarray, shape (T, 4)
        Time and true pose (x, y, theta), s, m and rad.
    """

    landmarks: FloatArray
    names: npt.NDArray[np.intp]
    odometry: FloatArray
    times: FloatArray
    indices: npt.NDArray[np.intp]
    measurements: FloatArray
    truth: FloatArray


def read_mrclam_log(folder: Path | str, robot: int = 1) -> MrclamLog:
    """Read the log of one robot from a folder of the MRCLAM data set.

    The second column of ``Robot*_Measurement.dat`` contains barcodes, although its heading is "Subject #";
    ``Barcodes.dat`` maps them to landmarks and robots. Measurements of other robots, and of barcodes that are not in
    ``Barcodes.dat``, are left out with a warning.

    Parameters
    ----------
    folder : path
        Folder with ``Barcodes.dat``, ``Landmark_Groundtruth.dat`` and the three files of the robot.
    robot : int
        Number of the robot, 1 to 5.

    Returns
    -------
    MrclamLog
        Contents of the files, with the landmarks and all times in the order of the files.

    Raises
    ------
    ValueError
        If a file is missing, empty, too large or malformed; it names file and line.
    """
    folder = Path(folder)
    barcodes = _table(folder / "Barcodes.dat", "a subject and its barcode", 2)
    places = _table(folder / "Landmark_Groundtruth.dat", "a landmark, x, y and two standard deviations", 5)
    odometry = _table(folder / f"Robot{robot}_Odometry.dat", "a time and two velocities", 3)
    seen = _table(folder / f"Robot{robot}_Measurement.dat", "a time, a barcode, a range and a bearing", 4)
    truth = _table(folder / f"Robot{robot}_Groundtruth.dat", "a time, x, y and an angle", 4)
    for name, values in (("Barcodes.dat", barcodes[:, 1]), ("Landmark_Groundtruth.dat", places[:, 0])):
        if len(np.unique(values)) < len(values) or (values % 1).any():
            raise ValueError(
                f"{folder / name}: expected another integer in each line, got {brief(str(values.tolist()))}"
            )
    subject_of, row_of = (
        dict(barcodes[:, ::-1].tolist()),
        {name: row for row, name in enumerate(places[:, 0].tolist())},
    )
    subjects = [subject_of.get(barcode) for barcode in seen[:, 1].tolist()]
    kept = np.array([subject in row_of for subject in subjects], dtype=bool)
    unknown = subjects.count(None)
    if robots := len(subjects) - unknown - int(kept.sum()):
        warnings.warn(f"{folder}: left out {say_count(robots, 'measurement')} of other robots", stacklevel=2)
    if unknown:
        said = (
            f"{folder}: left out {say_count(unknown, 'measurement')} whose barcodes are not in Barcodes.dat"
        )
        warnings.warn(said, stacklevel=2)
    indices = np.array([row_of[subject] for subject in subjects if subject in row_of], dtype=np.intp)
    names = places[:, 0].astype(np.intp)
    return MrclamLog(places[:, 1:3], names, odometry, seen[kept, 0], indices, seen[kept][:, [3, 2]], truth)


def _table(path: Path, wanted: str, columns: int) -> FloatArray:
    """Return the numbers of a file, shape (N, columns)."""
    rows = list[list[float]]()
    for where, words in lines_of(path, LARGEST_FILE, comment="#"):
        if len(words) != columns:
            raise ValueError(f"{where}: expected {wanted}, got {brief(' '.join(words))}")
        rows.append([number_of(word, where, LARGEST_NUMBER) for word in words])
    return np.array(rows, dtype=float).reshape(-1, columns)
