"""How large the films and the live map's messages are."""

import json

import numpy as np

from benchmarks import Result, Table
from nao_course.films import recorded_names
from nao_course.films.recorded import FOLDER, LARGEST
from nao_course.geometry import Pose
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement
from nao_course.widgets.vector_map import MapContents, VectorMap

STEPS, LANDMARKS = 200, 12
SOURCES = {"truth": "truth", "odometry": "odometry", "ekf": "your EKF"}


def contents(count: int) -> MapContents:
    """Return the map after some steps of a drive with twelve landmarks and four measurements."""
    path = [Pose(0.5 + 0.01 * step, np.sin(step / 40), 0.01 * step) for step in range(count)]
    landmarks = np.column_stack([np.linspace(0, 3, LANDMARKS), np.linspace(-2, 2, LANDMARKS)])
    spread = np.tile(np.diag([0.01, 0.02]) / count, (LANDMARKS, 1, 1))
    estimate = Estimate(path[-1], np.diag([0.01, 0.01, 0.01]), landmarks, spread, ("corner",) * LANDMARKS)
    seen = [Measurement(0.2 * number, 1.0 + 0.01 * count) for number in range(4)]
    return MapContents(dict.fromkeys(SOURCES, path), estimate, seen, "ekf", view=(0.0, 0.5, 2.0))


def main() -> Result:
    """Measure the films and the live map."""
    films = {name: {"bytes": (FOLDER / f"{name}.json").stat().st_size} for name in recorded_names()}
    sizes: list[int] = []
    live = VectorMap(Field(), SOURCES)
    live.widget.send = lambda message: sizes.append(len(json.dumps(message)))
    for count in range(1, STEPS + 1):
        live.update(contents(count))
    update = float(np.median(sizes[1:]))
    values = {"films": films, "live_map_update_bytes": update}
    note = f"An update of the live map, median of {STEPS} steps: {update:,.0f} bytes."
    return Result("films", values, (Table.of(f"Films, at most {LARGEST:,} bytes", films),), (note,))
