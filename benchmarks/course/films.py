"""How large the films and the live map's messages are, and how long the kernel takes for a message."""

from __future__ import annotations

import gzip
import json
import time
from typing import Any

import numpy as np

from benchmarks import Result, Table
from nao_course.films import recorded_film, recorded_names, script, style_sheet
from nao_course.films.recorded import FOLDER, LARGEST
from nao_course.geometry import Pose
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement
from nao_course.widgets.vector_map import MapContents, VectorMap

STEPS, LANDMARKS = 200, 12
SOURCES = {"truth": "truth", "odometry": "odometry", "ekf": "your EKF"}


def film_sizes() -> dict[str, dict[str, int]]:
    """Return the frames, the bytes and the compressed bytes of every recorded film."""
    sizes = {}
    for name in recorded_names():
        content = (FOLDER / f"{name}.json").read_bytes()
        frames = len(recorded_film(name)["captions"])
        sizes[name] = {
            "frames": frames,
            "bytes": len(content),
            "gzip_bytes": len(gzip.compress(content, 6, mtime=0)),
        }
    return sizes


def contents(count: int) -> MapContents:
    """Return the map after some steps of a drive with twelve landmarks and four measurements."""
    path = [Pose(0.5 + 0.01 * step, np.sin(step / 40), 0.01 * step) for step in range(count)]
    landmarks = np.column_stack([np.linspace(0, 3, LANDMARKS), np.linspace(-2, 2, LANDMARKS)])
    spread = np.tile(np.diag([0.01, 0.02]) / count, (LANDMARKS, 1, 1))
    estimate = Estimate(path[-1], np.diag([0.01, 0.01, 0.01]), landmarks, spread, ("corner",) * LANDMARKS)
    seen = [Measurement(0.2 * number, 1.0 + 0.01 * count) for number in range(4)]
    return MapContents(dict.fromkeys(SOURCES, path), estimate, seen, "ekf", view=(0.0, 0.5))


def live_map() -> dict[str, float]:
    """Return the kernel's median time, ms, and the median bytes of an update of the live map."""
    sizes: list[int] = []
    live = VectorMap(Field(), SOURCES)
    live.widget.send = lambda message: sizes.append(len(json.dumps(message)))
    times = []
    for each in [contents(count) for count in range(1, STEPS + 1)]:
        began = time.perf_counter()
        live.update(each)
        times.append(time.perf_counter() - began)
    return {"ms": 1000 * float(np.median(times[1:])), "bytes": float(np.median(sizes[1:]))}


def main() -> Result:
    """Measure the films and the live map."""
    sizes, update = film_sizes(), live_map()
    code = {"player": len(script("map", "player").encode()), "live": len(script("map", "live").encode())}
    code["style"] = len(style_sheet().encode())
    notes = (
        f"The script has {code['player']:,} bytes for films and {code['live']:,} for the live map.",
        f"An update of the live map, median of {STEPS} steps: {update['ms']:.2f} ms in the kernel, "
        f"{update['bytes']:,.0f} bytes.",
    )
    values: dict[str, Any] = {"films": sizes, "live_map_update": update, "script_bytes": code}
    return Result("films", values, (Table.of(f"Films, at most {LARGEST:,} bytes", sizes),), notes)
