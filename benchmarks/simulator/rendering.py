"""How quickly the simulator takes a picture with its truth, on one core, in the preset `lab`."""

import time
import tracemalloc

import cv2
import numpy as np

from benchmarks import Result, Table
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, CameraView, Field, Reality, render

SIZES = ((320, 240), (640, 480), (1280, 960))
PICTURES = 24
FIELD = Field(2012)


def places(size: tuple[int, int]) -> list[tuple[Pose, CameraView]]:
    """Draw poses all over half a field, with the head this way and that."""
    rng = np.random.default_rng(3)
    found = []
    for _ in range(PICTURES):
        x, y, theta, yaw = rng.uniform((0.2, -1.6, -np.pi, -0.5), (2.6, 1.6, np.pi, 0.5))
        pitch, tilt = np.radians(-28.0), rng.normal(0, 0.02)
        found.append((Pose(x, y, theta), NAO_V4.view("bottom", yaw, pitch, size, torso_pitch=tilt)))
    return found


def measured(size: tuple[int, int]) -> dict[str, float]:
    """Return the time of a picture with its truth, and its peak memory besides the caches, when these are filled."""
    taken = places(size)

    def take(place: tuple[Pose, CameraView]) -> float:
        start = time.perf_counter()
        render(FIELD, *place, Reality(), np.random.default_rng(0))
        return 1e3 * (time.perf_counter() - start)

    ms = [take(place) for place in (*taken[:3], *taken)][3:]
    tracemalloc.start()
    take(taken[0])
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    low, median, high = np.percentile(ms, (10, 50, 90)).tolist()
    return {"median ms": median, "10 % ms": low, "90 % ms": high, "peak MB": peak}


def main() -> Result:
    """Measure time and memory at three sizes."""
    cv2.setNumThreads(1)
    values = {f"{size[0]}x{size[1]}": measured(size) for size in SIZES}
    title = f"One picture, one core, preset lab: median of {PICTURES} places"
    return Result("rendering", values, (Table.of(title, values),))
