"""How quickly the simulator takes a picture, on one core, beside the usual way: a ground texture, warped.

``python -m benchmarks rendering``; the preset is `lab`.
"""

from __future__ import annotations

import time
import tracemalloc
from collections.abc import Callable
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from benchmarks import Result, Table
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, CameraView, Field, Reality, render
from nao_course.sim.carpet import TEXEL, Wear, carpet_levels
from nao_course.sim.light import develop
from nao_course.sim.render import SHOWN
from nao_course.sim.shapes import Eye

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


# --- the usual way ---


@lru_cache(maxsize=1)
def ground_texture() -> Pixels:
    """Return the whole field from above, rows along y, 5 mm per pixel: the simulator's carpet with lines."""
    (x0, x1), (y0, y1) = FIELD.x_range, FIELD.y_range
    wear = Wear(7.5, 3.5, 0.6, 9.0, 0.15, 0.7)
    texture = carpet_levels(FIELD.carpet, (x0, y0, x1, y1), SHOWN["carpet"], wear, 0)[0][..., :3].copy()
    wide = round(FIELD.dimensions.line_width / TEXEL)

    def pixel(x: float, y: float) -> tuple[int, int]:
        return round((x - FIELD.carpet[0]) / TEXEL), round((y - FIELD.carpet[1]) / TEXEL)

    for a, b, c, d in (*FIELD.lines, *FIELD.mark_lines):
        cv2.line(texture, pixel(a, b), pixel(c, d), (255, 255, 255), wide, cv2.LINE_AA)
    for x, y, radius, first, last in FIELD.arcs:
        reach, start, end = round(radius / TEXEL), np.degrees(first), np.degrees(last)
        cv2.ellipse(texture, pixel(x, y), (reach, reach), 0.0, start, end, (255, 255, 255), wide, cv2.LINE_AA)
    return texture


def warped(taken: Taken, finer: int = 4) -> Pixels:
    """Warp the ground texture to `finer` times the size, shrink it by area, and develop it as the simulator does.

    It knows neither room nor posts, neither the lens' distortion nor any label.
    """
    pose, view = taken
    width, height = view.size
    eye = Eye(pose, view)
    ahead, left = (np.array([np.cos(pose.theta + t), np.sin(pose.theta + t)]) for t in (0.0, np.pi / 2))
    x, y = eye.ground_position
    # From a pixel to its ray, to the ground, to the texture.
    rays = np.array([[0, 0, 1], [-1, 0, view.centre[0]], [0, -1, view.centre[1]]], dtype=float)
    rays[1:] /= np.array(view.focal)[:, None]
    turned = view.rotation @ rays
    ground = np.array([[*ahead], [*left]]).T @ turned[:2] * view.height
    ground -= np.outer((x - FIELD.carpet[0], y - FIELD.carpet[1]), turned[2])
    to_texture = np.vstack([ground / TEXEL, -turned[2]])
    shrink = np.array([[1 / finer, 0, 0.5 / finer - 0.5], [0, 1 / finer, 0.5 / finer - 0.5], [0, 0, 1]])
    fine = cv2.warpPerspective(
        ground_texture(),
        to_texture @ shrink,
        (finer * width, finer * height),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_CONSTANT,
    )
    shown = cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA)
    light = (shown.astype(np.float32) / 255) ** 2
    return develop(light, eye, Reality(), np.random.default_rng(0))


# --- measuring ---


def times_ms(take: Callable[[Taken], Pixels], size: tuple[int, int]) -> list[float]:
    """Return the milliseconds for each picture after all caches are filled."""
    taken = places(size)
    for each in taken[:3]:
        take(each)
    found = []
    for each in taken:
        start = time.perf_counter()
        take(each)
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
    """Measure both ways at three sizes, and the memory of ours."""
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return _measured()
    finally:
        cv2.setNumThreads(threads)


def _measured() -> Result:
    values: dict[str, dict[str, float]] = {}
    for size in SIZES:
        mine, usual = (times_ms(take, size) for take in (ours, warped))
        values[f"{size[0]}x{size[1]}"] = {
            "median ms": float(np.median(mine)),
            "10 % ms": float(np.percentile(mine, 10)),
            "90 % ms": float(np.percentile(mine, 90)),
            "ground texture, 4x supersampled, median ms": float(np.median(usual)),
            "peak MB": peak_mb(size),
        }
    notes = (
        "The ground texture is drawn without room, posts, lens distortion or truth; the sensor model is the same.",
        "Peak memory is beyond what is kept: a carpet 4 to 6 MB, a room some 10 MB, rays 24 bytes a pixel.",
    )
    title = f"One picture, one core, preset lab: median of {PICTURES} places"
    return Result("rendering", values, (Table.of(title, values),), notes)
