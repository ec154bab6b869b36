"""How quick the view of the world is in a real browser without a graphics card, and how large its messages are."""

from __future__ import annotations

import gzip
import platform
import tempfile
import time
from pathlib import Path
from typing import Any

import psutil

from benchmarks import Result, Table, chromium, processor
from nao_course.widgets.world.widget import BUNDLE
from tests.browser.lab import Lab, browser_page, jupyter_lab

SIZE = (640, 400)  # px
UPDATES, PERIOD = 100, 0.05  # of a drive, and s between two
WANTED = {"frames_per_second": 20.0}
CELL = f"""import asyncio
import numpy as np
from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import Estimate
from nao_course.widgets import Ray, WorldView

nao = SimulatedNao(rng=4)
truth = Truth(nao)
pictures = [nao.take_picture("bottom").pixels for _ in range(8)]
landmarks = np.array([(mark.x, mark.y) for mark in nao.field.detectable])
kinds = tuple(mark.detected_as for mark in nao.field.detectable)
world = WorldView(nao.field, size={SIZE})

def update(step):
    nao.walk(0.015)
    nao.turn(0.01)
    odometry = truth.odometry_start @ nao.odometry
    spread = np.tile(np.diag([0.01, 0.02]), (len(landmarks), 1, 1))
    estimate = Estimate(odometry, 0.01 * np.eye(3), landmarks, spread, kinds)
    rays = [Ray(tuple(landmark)) for landmark in landmarks[:3]]
    head = (0.6 * np.sin(step / 10), -0.4)
    paths = {{"truth": truth.path}}
    picture = pictures[step % len(pictures)]
    world.update(truth.pose, estimate, head=head, pictures={{"bottom": picture}}, rays=rays, paths=paths)

async def drive():
    for step in range({UPDATES}):
        update(step)
        await asyncio.sleep({PERIOD})

update(0)
world"""
FRAMES = "() => [document.querySelector('.nao-world').naoWorld.view.frames, performance.now()]"


def measure(lab: Lab, page: Any) -> dict[str, Any]:
    """Measure one drive: frames per second, the browser's processor time, and the bytes that it received."""
    received: list[int] = []
    page.on("websocket", lambda socket: socket.on("framereceived", lambda data: received.append(len(data))))
    lab.write("world.ipynb", CELL, "driving = asyncio.ensure_future(drive())")
    lab.open(page, "world.ipynb")
    before = sum(received)
    _run(page, 0)
    page.wait_for_selector(".nao-world canvas")
    page.wait_for_timeout(4000)
    first = sum(received) - before
    ran, used, (frames, began) = sum(received), _browsers_seconds(), page.evaluate(FRAMES)
    _run(page, 1)
    time.sleep(UPDATES * PERIOD)
    (more, ended), spent = page.evaluate(FRAMES), _browsers_seconds() - used
    page.wait_for_timeout(3000)
    return {
        "frames_per_second": (more - frames) / (ended - began) * 1000,
        "browser_cpu_ms_a_frame": 1000 * spent / max(more - frames, 1),
        "first_message_kilobytes": first / 1000,
        "update_kilobytes": (sum(received) - ran) / UPDATES / 1000,
    }


def _run(page: Any, cell: int) -> None:
    page.evaluate(
        """cell => { window.jupyterapp.shell.currentWidget.content.activeCellIndex = cell;
        return window.jupyterapp.commands.execute('notebook:run-cell').then(() => null); }""",
        cell,
    )


def _browsers_seconds() -> float:
    """Return the processor time of the browser's processes so far, s."""
    family = psutil.Process().children(recursive=True)
    browser = [each for each in family if "chrom" in each.name()]
    return float(sum(sum(each.cpu_times()[:2]) for each in browser))


def main() -> Result:
    """Measure the view in JupyterLab and Chromium, with WebGL on the processor."""
    executable = chromium()
    with tempfile.TemporaryDirectory() as scratch:
        folder, settings = Path(scratch) / "notebooks", Path(scratch) / "jupyter"
        folder.mkdir()
        with jupyter_lab(folder, settings) as lab, browser_page(executable, webgl=True) as page:
            results = measure(lab, page)
    bundle = BUNDLE.read_bytes()
    results["bundle_kilobytes"] = len(bundle) / 1000
    results["bundle_gzip_kilobytes"] = len(gzip.compress(bundle)) / 1000
    results["wanted"] = WANTED
    results["machine"] = {"cpu": processor(), "python": platform.python_version()}
    rows = (
        ("frames a second while driving", f"{results['frames_per_second']:.0f}", ">= 20"),
        ("the browser's processor time a frame", f"{results['browser_cpu_ms_a_frame']:.0f} ms", ""),
        ("an update with a picture of 320 x 240", f"{results['update_kilobytes']:.1f} kB", ""),
        ("the first message, with the script", f"{results['first_message_kilobytes']:.0f} kB", ""),
        ("the script", f"{results['bundle_kilobytes']:.0f} kB", ""),
        ("the script, compressed", f"{results['bundle_gzip_kilobytes']:.0f} kB", ""),
    )
    title = f"View of the world in JupyterLab and Chromium, {SIZE[0]} x {SIZE[1]}, drawn by the processor"
    return Result("world", results, (Table(title, ("measured", "value", "wanted"), rows),))
