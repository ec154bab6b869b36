"""How fast the student's control panel answers in a browser: pictures a second, and from a key to its picture.

``python -m benchmarks panel`` opens JupyterLab and Chromium, drives `my_nao()` with the solutions' functions by keys,
and counts the pictures that the browser has loaded. The machine's load is stated, because browser, server and kernel
share its cores; the processor time of each for one picture depends less on the load.
"""

import os
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from rich.progress import track

from benchmarks import ROOT, Result, Table, chromium
from tests.browser.lab import browser_page, jupyter_lab

PANELS = {  # each with the last of its stages
    "the cameras' pictures": ('panel = my_nao(upto="00")', ""),
    "own labels": ('panel = my_nao(upto="01")', "✔ labels"),
    "all stages": ("panel = my_nao()", "✔ next move"),
}
SECONDS = 10.0  # of driving
PRESS = 0.3  # s between two presses: each walks a metre, so motions always wait
KEYS = 20  # single keys, each after the panel has come to rest
PARTS = {"ipykernel": "kernel", "jupyterlab": "server", "chrom": "browser"}  # by a word of their commands
STEP = "panel._controls.step.value = 1.0\npanel"
LISTEN = """root => {
  const noted = window.noted = { keys: [], shown: [] };
  root.addEventListener('keydown', () => noted.keys.push(performance.now()), true);
  root.addEventListener('load', event => {
    if (event.target.closest('.nao-chosen')) noted.shown.push(performance.now());
  }, true);
}"""


def processor_seconds() -> dict[str, float]:
    """Return the processor time so far of the kernel, of the server and of the browser, s."""
    seconds = dict.fromkeys(("kernel", "server", "browser"), 0.0)
    for process in psutil.Process().children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            command, times = " ".join(process.cmdline()), process.cpu_times()
            part = next((part for word, part in PARTS.items() if word in command), None)
            if part is not None:
                seconds[part] += times.user + times.system
    return seconds


def measure(page: Any, panel: Any) -> dict[str, float]:
    """Return the pictures a second, the delay from a key to its picture, ms, and the processor time of a picture, ms.

    Only pictures of the chosen camera are counted.
    """
    panel.evaluate(LISTEN)
    panel.locator(".nao-chosen").click()
    waits = []
    for number in range(KEYS):
        page.evaluate("noted.keys.length = noted.shown.length = 0")
        page.keyboard.press("jl"[number % 2])
        page.wait_for_function("noted.shown.length > 0", timeout=60_000)
        waits.append(page.evaluate("noted.shown[0] - noted.keys[0]"))
        page.wait_for_timeout(700)
    page.evaluate("noted.shown.length = 0")
    before = processor_seconds()
    begin = page.evaluate("performance.now()")
    while (passed := page.evaluate("performance.now()") - begin) < 1000 * SECONDS:
        page.keyboard.press("ws"[int(passed / 1000 / PRESS) % 2])
        page.wait_for_timeout(1000 * PRESS)
    shown = page.evaluate("noted.shown.length")
    used = processor_seconds()
    return {
        "pictures a second": 1000 * shown / passed,
        "from a key to its picture, ms (median)": float(np.median(waits)),
        "from a key to its picture, ms (95 %)": float(np.quantile(waits, 0.95)),
        **{f"{part}, ms": 1000 * (used[part] - before[part]) / max(shown, 1) for part in used},
    }


def main() -> Result:
    """Measure each panel in turn."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        notebooks = Path(folder, "notebooks")
        notebooks.mkdir()
        for path in (ROOT / "solutions").glob("*.ipynb"):
            shutil.copy2(path, notebooks)
        with jupyter_lab(notebooks, Path(folder, "settings")) as lab, browser_page(chromium()) as page:
            page.set_viewport_size({"width": 1280, "height": 800})
            for number, (name, (call, stage)) in enumerate(track(PANELS.items(), "panels")):
                lab.write(f"panel{number}.ipynb", f"from nao_course.student import my_nao\n{call}", STEP)
                lab.open(page, f"panel{number}.ipynb")
                lab.run_all(page)
                panel = page.locator(".nao-panel")
                panel.locator("img").first.wait_for(timeout=240_000)
                if stage not in (panel.locator(".nao-ready").text_content() or ""):
                    raise RuntimeError(f"the panel {name!r} lacks the stage {stage!r}")
                load = os.getloadavg()[0]
                found[name] = measure(page, panel) | {"load": load}
                lab.close_notebooks()
    return Result("panel", found, (Table.of("The control panel in a browser", found),))
