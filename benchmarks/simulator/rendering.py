"""How quickly the simulator takes a picture with its truth, on one core, in the preset `lab`."""

from __future__ import annotations

import time
import tracemalloc

import cv2
import numpy as np
import numpy.typing as npt

from benchmarks import Result, Table
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, CameraView, Field, Reality, render

Pixels = npt.NDArray[np.uint8]
Taken = tuple[Pose, CameraView]

SIZES = ((320, 240), (640, 480), (1280, 960))
PICTURES = 24
FIELD = Field(2012)


def places(size: tuple[int, int]) -> list[Taken]:
    """Draw poses all over half a field, with the head this way and that."""
    rng = np.random.default_rng(3)
    found = []
    for _ in range(PICTURES):
        x, y, theta, yaw = rng.uniform((0.2, -1.6, -np.pi, -0.5), (2.6, 1.6, np.pi, 0.5))
        pitch, lean = np.radians(-28.0), rng.normal(0, 0.02)
        found.append((Pose(x, y, theta), NAO_V4.view("bottom", yaw, pitch, size, torso_pitch=lean)))
    return found


def ours(taken: Taken) -> Pixels:
    """Return the simulator's picture with its ground truth."""
    pose, view = taken
    return render(FIELD, pose, view, Reality(), np.random.default_rng(0))[0]


def times_ms(size: tuple[int, int]) -> list[float]:
    """Return the milliseconds for each picture after all caches are filled."""
    taken = places(size)
    for each in taken[:3]:
        ours(each)
    found = []
    for each in taken:
        start = time.perf_counter()
        ours(each)
        found.append(1e3 * (time.perf_counter() - start))
    return found


def peak_mb(size: tuple[int, int]) -> float:
    """Return the most memory that a picture needs while it is rendered, besides the caches, in 10^6 bytes."""
    taken = places(size)[0]
    ours(taken)
    tracemalloc.start()
    ours(taken)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def main() -> Result:
    """Measure time and memory at three sizes."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return _measured()
    finally:
        cv2.setNumThreads(threads)


def _measured() -> Result:
    values: dict[str, dict[str, float]] = {}
    for size in SIZES:
        mine = times_ms(size)
        values[f"{size[0]}x{size[1]}"] = {
            "median ms": float(np.median(mine)),
            "10 % ms": float(np.percentile(mine, 10)),
            "90 % ms": float(np.percentile(mine, 90)),
            "peak MB": peak_mb(size),
        }
    notes = (
        "Peak memory is beyond what is kept: a carpet 4 to 6 MB, a room some 10 MB, rays 24 bytes a pixel.",
    )
    title = f"One picture, one core, preset lab: median of {PICTURES} places"
    return Result("rendering", values, (Table.of(title, values),), notes)
