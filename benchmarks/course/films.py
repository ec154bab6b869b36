"""How large the films and the live map's messages are, and how long the browser and the kernel take to draw."""

from __future__ import annotations

import gzip
import json
import shutil
import time
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks import Result, Table
from nao_course.films import film_page, recorded_film, recorded_names, script, style_sheet
from nao_course.films.recorded import FOLDER, LARGEST
from nao_course.geometry import Pose
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement
from nao_course.widgets.vector_map import MapContents, VectorMap
from tests.browser.lab import browser_page

STEPS, LANDMARKS = 200, 12
SOURCES = {"truth": "truth", "odometry": "odometry", "ekf": "your EKF"}
# Drawing is synchronous, and reading a pixel waits until it is done.
_DRAW = """data => {
  const root = document.createElement('div');
  document.body.append(root);
  const player = new NaoFilm.Player(root, data), times = [];
  for (let i = 0; i < 100; i++) {
    const began = performance.now();
    player.go(player.last * i / 99);
    player.map.canvas.getContext('2d').getImageData(0, 0, 1, 1);
    times.push(performance.now() - began);
  }
  root.remove();
  return times;
}"""


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


def drawing_times(executable: str) -> dict[str, float]:
    """Return the median time to draw a frame of each film in Chromium without a graphics card, ms."""
    found = {}
    with TemporaryDirectory() as folder, browser_page(executable) as page:
        for name in recorded_names():
            data = recorded_film(name)
            path = Path(folder) / f"{name}.html"
            path.write_text(film_page(data), encoding="utf-8")
            page.goto(path.as_uri())
            found[name] = float(np.median(page.evaluate(_DRAW, data)))
    return found


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
    executable = next(
        filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None
    )
    if executable is None:
        raise FileNotFoundError(
            "there is no Chromium on this machine (on Debian and Ubuntu: apt install chromium)"
        )
    sizes, times, update = film_sizes(), drawing_times(executable), live_map()
    code = {"player": len(script("map", "player").encode()), "live": len(script("map", "live").encode())}
    code["style"] = len(style_sheet().encode())
    values: dict[str, Any] = {
        "films": sizes,
        "draw_ms": times,
        "live_map_update": update,
        "script_bytes": code,
    }
    films = [
        (name, each["frames"], f"{each['bytes']:,}", f"{each['gzip_bytes']:,}", f"{times[name]:.1f}")
        for name, each in sizes.items()
    ]
    return Result(
        "films",
        values,
        (
            Table(
                f"Films, at most {LARGEST:,} bytes",
                ("film", "frames", "bytes", "gzip", "ms a frame"),
                tuple(films),
            ),
        ),
        (
            f"The script has {code['player']:,} bytes for films and {code['live']:,} for the live map.",
            f"An update of the live map, median of {STEPS} steps: {update['ms']:.2f} ms in the kernel, "
            f"{update['bytes']:,.0f} bytes.",
        ),
    )
