"""Pictures of the course as students see it: JupyterLab in a Chromium of this machine, without a window."""

from __future__ import annotations

import io
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from PIL import Image

from benchmarks import chromium
from tests.browser.lab import Lab, browser_page, jupyter_lab, wait_for
from tests.paths import PROJECT

QUALITY = 88  # of 100
WINDOW = {"width": 1240, "height": 780}
PANEL = ("from nao_course.student import my_nao\nmy_nao()",)
TOGGLE_FILES = "() => window.jupyterapp.commands.execute('application:toggle-left-area').then(() => null)"
TO_THE_TOP = "each => each.scrollIntoView({block: 'start'})"


def my_nao() -> bytes:
    """Return the control panel with all lessons solved, after the robot has seen the whole field by itself."""

    def act(lab: Lab, page: Any) -> Any:
        shutil.copytree(PROJECT / "solutions", lab.folder, dirs_exist_ok=True)
        lab.write("my_nao.ipynb", *PANEL)
        lab.open(page, "my_nao.ipynb")
        page.evaluate(TOGGLE_FILES)
        lab.run_all(page)
        panel = page.locator(".nao-panel")
        panel.wait_for(timeout=90_000)
        panel.evaluate(TO_THE_TOP)
        panel.locator(".nao-do-itself").click()
        wait_for(
            lambda: panel.locator(".nao-finish").count() > 0, "a drive that has seen the whole field", 300
        )
        page.wait_for_timeout(1000)  # until the robot on the map stands still
        return panel

    return _photograph(act)


def lesson() -> bytes:
    """Return the beginning of lesson 07 in the students' copy."""

    def act(lab: Lab, page: Any) -> Any:
        shutil.copytree(PROJECT / "notebooks", lab.folder, dirs_exist_ok=True)
        lab.open(page, "07_ekf_slam.ipynb")
        page.evaluate(TOGGLE_FILES)
        lab.run_all(page)
        page.get_by_role("heading", name="A map that bends").evaluate(TO_THE_TOP)
        page.wait_for_timeout(1000)
        return page

    return _photograph(act)


def _photograph(act: Callable[[Lab, Any], Any]) -> bytes:
    """Open JupyterLab, let `act` return what is to be seen, and return its picture as WebP."""
    with tempfile.TemporaryDirectory() as folder:
        notebooks, settings = (Path(folder, name) for name in ("notebooks", "settings"))
        notebooks.mkdir()
        with jupyter_lab(notebooks, settings) as lab, browser_page(chromium()) as page:
            page.set_viewport_size(WINDOW)
            shot = act(lab, page).screenshot()
    picture = io.BytesIO()
    Image.open(io.BytesIO(shot)).convert("RGB").save(picture, "WEBP", quality=QUALITY, method=6)
    return picture.getvalue()
