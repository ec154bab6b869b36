"""How quick the panels are in a real browser: from button to new picture, and pictures a second."""

from __future__ import annotations

import platform
import re
import shutil
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from benchmarks import Result, Table
from tests.browser.filter_page import FilterPage, reference
from tests.browser.lab import Lab, browser_page, jupyter_lab
from tests.paths import PROJECT

PRESSES = 40
DRIVES, STEPS_A_DRIVE = 5, 20  # of a metre each, as the panel cuts it
WANTED = {
    "button_to_picture_ms": 100.0,
    "pictures_per_second": 20.0,
    "labelled_pictures_per_second": 20.0,
    "solved_pictures_per_second": 8.0,
    "filter_updates_per_second": 12.0,
}
PANEL = """from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import DeadReckoning
from nao_course.widgets import ControlPanel

nao = SimulatedNao(rng=4)
panel = ControlPanel(nao, truth=Truth(nao), slam=DeadReckoning())
panel"""

MY_NAO = "from nao_course.student import my_nao\n\npanel = my_nao()\npanel"

# In the page's own clock: from the click until the chosen camera's next picture is decoded and its frame painted.
_PRESS = """name => new Promise(resolve => {
  const image = document.querySelector('.nao-image-bottom img');
  const began = performance.now();
  image.addEventListener('load', () => requestAnimationFrame(() => resolve(performance.now() - began)), {once: true});
  document.querySelector('.nao-do-' + name).click();
})"""
_WATCH = """() => {
  window.naoLoads = {top: [], bottom: [], map: []};
  for (const name of ['top', 'bottom'])
    document.querySelector(`.nao-image-${name} img`).addEventListener(
      'load', () => window.naoLoads[name].push(performance.now()));
  new MutationObserver(() => window.naoLoads.map.push(performance.now())).observe(
    document.querySelector('.nao-map-canvas'), {attributes: true, attributeFilter: ['aria-label']});
}"""


def measure(lab: Lab, page: Any) -> dict[str, Any]:
    """Measure the times of one session, ms, and the frames per second."""
    _open(lab, page, "panel.ipynb", PANEL)
    results: dict[str, Any] = {}
    for name, (there, back) in {"head": ("look-left", "look-right"), "walk": ("left", "right")}.items():
        times = [_press(page, press) for _ in range(PRESSES // 2) for press in (there, back)]
        results[f"{name}_button_to_picture_ms"] = {
            "median": round(float(np.median(times)), 1),
            "p90": round(float(np.quantile(times, 0.9)), 1),
            "presses": len(times),
        }
    results["pictures_per_second"], results["longest_gap_ms"] = _drives(page)
    return results


def measure_labelled(lab: Lab, page: Any) -> dict[str, Any]:
    """Measure the frames per second of a drive with lesson 01's labels over the picture."""
    _open(lab, page, "mine.ipynb", "import numpy as np", reference(), MY_NAO)
    rates, gap = _drives(page)
    return {"labelled_pictures_per_second": rates["bottom"], "labelled_longest_gap_ms": gap}


def measure_solved(lab: Lab, page: Any) -> dict[str, Any]:
    """Measure the frames per second of a drive with the solutions of all lessons, loaded as saved notebooks."""
    for path in sorted((PROJECT / "solutions").glob("*.ipynb")):
        shutil.copy(path, lab.folder / path.name)
    _open(lab, page, "solved.ipynb", MY_NAO)
    # Loading and checking every notebook takes a while before the first picture that is seen through all stages.
    page.wait_for_function(
        "() => document.querySelector('.nao-ready').innerText.includes('✔')", timeout=120_000
    )
    page.wait_for_timeout(3000)
    before = _kernels_seconds()
    rates, gap = _drives(page)
    spent = 1000 * (_kernels_seconds() - before) / (DRIVES * STEPS_A_DRIVE)
    ready = page.locator(".nao-ready").inner_text()
    return {
        "solved_pictures_per_second": rates["bottom"],
        "solved_longest_gap_ms": gap,
        "solved_kernel_cpu_ms": round(spent, 1),
        "solved_stages": re.findall(r"✔ ([^✔,]+)", ready.partition("\n")[0]),
    }


def _kernels_seconds() -> float:
    """Return the processor time of all kernels so far, s, which a busy machine hardly changes."""
    family = psutil.Process().children(recursive=True)
    kernels = [each for each in family if any("ipykernel" in part for part in each.cmdline())]
    return float(sum(sum(each.cpu_times()[:2]) for each in kernels))


def _open(lab: Lab, page: Any, name: str, *cells: str) -> None:
    lab.write(name, *cells)
    lab.open(page, name)
    lab.run_all(page)
    page.wait_for_selector(".nao-image-bottom img")
    page.wait_for_timeout(2000)


def _drives(page: Any) -> tuple[dict[str, float], float]:
    """Return the frames per second of each picture, the median of some drives, and the longest wait, ms."""
    page.evaluate(_WATCH)
    page.locator(".nao-do-more").click()
    page.locator(".nao-panel select").nth(2).select_option("1 m")
    page.locator(".nao-do-more").click()
    rates, gaps = zip(*(_rate(page, drive) for drive in range(DRIVES)), strict=True)
    medians = {image: round(float(np.median([rate[image] for rate in rates])), 1) for image in rates[0]}
    return medians, round(max(gaps), 1)


def measure_filter(lab: Lab, page: Any) -> dict[str, Any]:
    """Measure how fast lesson 01's labels follow a slider that is dragged."""
    loads = FilterPage(lab, page, "filter.ipynb").updates(steps=480)
    return {
        "filter_updates_per_second": round(float((len(loads) - 1) / (loads[-1] - loads[0]) * 1000), 1),
        "filter_longest_gap_ms": round(float(np.diff(loads).max()), 1),
    }


def _press(page: Any, name: str) -> float:
    page.wait_for_timeout(700)  # what was asked before is over
    return float(page.evaluate(_PRESS, name))


def _rate(page: Any, drive: int) -> tuple[dict[str, float], float]:
    """Return the frames per second of each picture during a drive of a metre, and the longest wait, ms."""
    page.evaluate("() => { for (const times of Object.values(window.naoLoads)) times.length = 0; }")
    page.locator(f".nao-do-{'back' if drive % 2 else 'forward'}").click()
    page.wait_for_function(
        "() => document.querySelector('.nao-status').innerText.includes('…')", timeout=10_000
    )
    page.wait_for_function(
        "() => document.querySelector('.nao-status').innerText.includes('done')", timeout=60_000
    )
    page.wait_for_timeout(500)
    loads = page.evaluate("() => window.naoLoads")
    rates = {image: (len(times) - 1) / (times[-1] - times[0]) * 1000 for image, times in loads.items()}
    return rates, float(np.diff(loads["bottom"]).max())


def main() -> Result:
    """Measure the panel in a real browser."""
    executable = chromium()
    with tempfile.TemporaryDirectory() as scratch:
        folder, settings = Path(scratch) / "notebooks", Path(scratch) / "jupyter"
        folder.mkdir()
        with jupyter_lab(folder, settings) as lab, browser_page(executable) as page:
            results = measure(lab, page) | measure_labelled(lab, page)
            results |= measure_solved(lab, page) | measure_filter(lab, page)
    results["wanted"] = WANTED
    results["machine"] = {"cpu": processor(), "python": platform.python_version(), "picture": "320 x 240"}
    return Result("panel", results, (_table(results),))


def chromium() -> str:
    """Return the path of this machine's Chromium."""
    found = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    if found is None:
        raise FileNotFoundError(
            "there is no Chromium on this machine (on Debian and Ubuntu: apt install chromium)"
        )
    return found


def processor() -> str:
    """Return the name of this machine's processor."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    return next((line.split(": ")[1] for line in lines if line.startswith("model name")), platform.machine())


def _table(results: dict[str, Any]) -> Table:
    rows: list[tuple[object, ...]] = []
    for name in ("head", "walk"):
        times = results[f"{name}_button_to_picture_ms"]
        wanted = f"<= {WANTED['button_to_picture_ms']:.0f} ms"
        rows.append((f"{name} button to new picture", f"{times['median']} ms", f"{times['p90']} ms", wanted))
    rates = results["pictures_per_second"]
    for name in ("bottom", "top", "map"):
        wanted = f">= {WANTED['pictures_per_second']:.0f}" if name == "bottom" else ""
        rows.append((f"{name} pictures a second while driving", f"{rates[name]}", "", wanted))
    rows.append(("longest gap between two pictures of a drive", f"{results['longest_gap_ms']} ms", "", ""))
    wanted = f">= {WANTED['labelled_pictures_per_second']:.0f}"
    rows.append(
        ("the same with lesson 01's labels over it", f"{results['labelled_pictures_per_second']}", "", wanted)
    )
    rows.append(("longest gap between two of them", f"{results['labelled_longest_gap_ms']} ms", "", ""))
    wanted = f">= {WANTED['solved_pictures_per_second']:.0f}"
    stages = ", ".join(results["solved_stages"])
    rows.append((f"the same with {stages}", f"{results['solved_pictures_per_second']}", "", wanted))
    rows.append(("longest gap between two of them", f"{results['solved_longest_gap_ms']} ms", "", ""))
    rows.append(("the kernel's processor time a step", f"{results['solved_kernel_cpu_ms']} ms", "", ""))
    wanted = f">= {WANTED['filter_updates_per_second']:.0f}"
    rate, gap = results["filter_updates_per_second"], results["filter_longest_gap_ms"]
    rows.append(("labels a second while a filter's slider is dragged", f"{rate}", "", wanted))
    rows.append(("longest gap between two of them", f"{gap} ms", "", ""))
    title = "Control panel and filter panel in JupyterLab and Chromium, pictures of 320 x 240"
    return Table(title, ("measured", "median", "90 %", "wanted"), tuple(rows))
