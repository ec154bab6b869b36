"""How quickly the simulator takes a picture with its truth, on one core, in the preset `lab`, and a peer beside it.

The peer is the usual way: a texture of the ground that is warped, smoothed and developed, without posts, room, lens
distortion and labels.
"""

import time
import tracemalloc
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import cv2
import numpy as np

from benchmarks import Result, Table
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, CameraView, Field, Reality, render
from nao_course.sim.carpet import TEXEL, Wear, carpet_levels
from nao_course.sim.light import develop
from nao_course.sim.render import SHOWN
from nao_course.sim.shapes import Eye

SIZES = ((320, 240), (640, 480), (1280, 960))
PICTURES = 24
FIELD = Field(2012)
FINER = 4  # the warped texture has this times the picture's width and height before it is made smaller


def places(size: tuple[int, int]) -> list[tuple[Pose, CameraView]]:
    """Draw poses all over half a field, with the head this way and that."""
    rng = np.random.default_rng(3)
    found = []
    for _ in range(PICTURES):
        x, y, theta, yaw = rng.uniform((0.2, -1.6, -np.pi, -0.5), (2.6, 1.6, np.pi, 0.5))
        pitch, tilt = np.radians(-28.0), rng.normal(0, 0.02)
        found.append((Pose(x, y, theta), NAO_V4.view("bottom", yaw, pitch, size, torso_pitch=tilt)))
    return found


def simulated(pose: Pose, view: CameraView) -> None:
    """Take the simulator's picture with its truth."""
    render(FIELD, pose, view, Reality(), np.random.default_rng(0))


@lru_cache(maxsize=1)
def ground_texture() -> Any:
    """Return the whole field from above, 5 mm a pixel: the simulator's carpet with lines."""
    (x0, x1), (y0, y1) = FIELD.x_range, FIELD.y_range
    wear = Wear(7.5, 3.5, 0.6, 9.0, 0.15, 0.7)
    texture = carpet_levels(FIELD.carpet, (x0, y0, x1, y1), SHOWN["carpet"], wear, 0)[0][..., :3].copy()
    style = (255, 255, 255), round(FIELD.dimensions.line_width / TEXEL), cv2.LINE_AA
    for line in (*FIELD.lines, *FIELD.mark_lines):
        ends = np.round((np.reshape(line, (2, 2)) - FIELD.carpet[:2]) / TEXEL).astype(int).tolist()
        cv2.line(texture, *ends, *style)
    for x, y, radius, first, last in FIELD.arcs:
        centre = round((x - FIELD.carpet[0]) / TEXEL), round((y - FIELD.carpet[1]) / TEXEL)
        axes = (round(radius / TEXEL),) * 2
        cv2.ellipse(texture, centre, axes, 0.0, np.degrees(first), np.degrees(last), *style)
    return texture


def warped(pose: Pose, view: CameraView) -> None:
    """Warp the ground texture, smooth it by area, and develop it as the simulator does."""
    eye, (width, height) = Eye(pose, view), view.size
    rays = np.array([[0, 0, 1], [-1, 0, view.centre[0]], [0, -1, view.centre[1]]], dtype=float)
    rays[1:] /= np.array(view.focal)[:, None]
    turned = view.rotation @ rays
    cos, sin = np.cos(pose.theta), np.sin(pose.theta)
    ground = np.array([[cos, -sin], [sin, cos]]) @ turned[:2] * view.height
    ground -= np.outer(np.subtract(eye.ground_position, FIELD.carpet[:2]), turned[2])
    to_texture = np.vstack([ground / TEXEL, -turned[2]])
    coarser = np.array([[1, 0, (1 - FINER) / 2], [0, 1, (1 - FINER) / 2], [0, 0, FINER]]) / FINER
    size = FINER * width, FINER * height
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    fine = cv2.warpPerspective(ground_texture(), to_texture @ coarser, size, flags=flags)
    shown = cv2.resize(fine, (width, height), interpolation=cv2.INTER_AREA)
    develop((shown.astype(np.float32) / 255) ** 2, eye, Reality(), np.random.default_rng(0))


def milliseconds(take: Callable[[Pose, CameraView], None], place: tuple[Pose, CameraView]) -> float:
    """Return the time of a picture."""
    start = time.perf_counter()
    take(*place)
    return 1e3 * (time.perf_counter() - start)


def measured(size: tuple[int, int]) -> dict[str, float]:
    """Return the time of a picture, and its peak memory besides the caches, when these are filled; and the peer's."""
    taken = places(size)
    ours, theirs = (
        [milliseconds(take, each) for each in (*taken[:3], *taken)][3:] for take in (simulated, warped)
    )
    tracemalloc.start()
    simulated(*taken[0])
    peak = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    low, median, high = np.percentile(ours, (10, 50, 90)).tolist()
    texture = float(np.median(theirs))
    return {
        "median ms": median,
        "10 % ms": low,
        "90 % ms": high,
        "peak MB": peak,
        "texture, median ms": texture,
        "ratio": median / texture,
    }


def main() -> Result:
    """Measure time and memory at three sizes, and the time of a plain texture."""
    cv2.setNumThreads(1)
    values = {f"{size[0]}x{size[1]}": measured(size) for size in SIZES}
    title = f"One picture, one core, preset lab: median of {PICTURES} places"
    return Result("rendering", values, (Table.of(title, values),))
