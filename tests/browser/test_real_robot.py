"""A real robot in a browser: `nao-course robot serve` in one terminal, and the notebook as with a simulated one."""

import shutil
import subprocess
import sys
from contextlib import contextmanager

import pytest

from tests.browser.lab import browser_page, jupyter_lab, wait_for
from tests.browser.notebook_page import expect, run_notebook, screenshot
from tests.paths import PROJECT
from tests.robot.emulated import free_port

pytestmark = [
    pytest.mark.browser,
    pytest.mark.skipif(sys.platform == "win32", reason="qi is not for Windows"),
]


@contextmanager
def served(port):
    """Run the command until the block ends; yield its process when it listens."""
    command = [sys.executable, "-u", "-m", "nao_course.cli", "robot", "serve", "--port", str(port)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True, "cwd": PROJECT}
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, **pipes) as server:
        try:
            assert any("listens" in line for line in iter(server.stdout.readline, ""))
            yield server
        finally:
            server.kill()


def test_a_robot_that_is_lost_in_mid_walk_and_comes_back_drives_on_in_the_same_notebook(tmp_path, chromium):
    pytest.importorskip("qi", reason="the package qi is for Linux and Python 3.11 and 3.12")
    notebooks, port = tmp_path / "notebooks", free_port()
    notebooks.mkdir()
    for path in (PROJECT / "solutions").glob("*.ipynb"):
        shutil.copy2(path, notebooks)
    first = f"""from nao_course.robot import RealNao
from nao_course.student import my_nao
nao = RealNao("tcp://127.0.0.1:{port}", model="V4")
nao.wake_up()
my_nao(nao)"""
    with jupyter_lab(notebooks, tmp_path / "jupyter") as lab, browser_page(chromium) as page:
        with served(port) as server:
            run_notebook(lab, page, "real.ipynb", first)
            panel = page.locator(".nao-panel")
            panel.wait_for(timeout=240_000)
            assert "✔ estimate ✔ next move" in panel.locator(".nao-ready").text_content().replace(",", "")
            assert "measure it: panel.measured_pose" in panel.locator(".nao-numbers").inner_text()
            panel.locator(".nao-chosen").click()
            page.keyboard.press("r")
            expect(panel.locator(".nao-status").inner_text, "Recording into recordings")
            page.keyboard.press("w")
            expect(panel.locator(".nao-status").inner_text, "Walk 0.20 m ahead: done.")
            page.keyboard.press("g")
            expect(panel.locator(".nao-board").inner_text, "Next move")
            page.wait_for_timeout(3000)
            screenshot(page, "real_robot", panel)
            page.keyboard.press("Escape")
            expect(panel.locator(".nao-status").inner_text, "Stopped.")
            page.keyboard.press("w")
            page.wait_for_timeout(300)
            server.kill()
            expect(panel.locator(".nao-status").inner_text, "raise panel.error")
        with served(port):
            page.evaluate(
                """() => {
                const cells = window.jupyterapp.shell.currentWidget.content.model.sharedModel;
                cells.insertCell(1, {cell_type: 'code', source: 'nao.wake_up()'}); }"""
            )
            page.evaluate("window.jupyterapp.shell.currentWidget.content.activeCellIndex = 1")
            page.evaluate("() => window.jupyterapp.commands.execute('notebook:run-cell').then(() => null)")
            wait_for(lambda: len(lab.counts(page)) > 1 and all(lab.counts(page)), "the robot that wakes up")
            assert lab.errors(page) == []
            panel.locator(".nao-chosen").click()
            page.keyboard.press("w")
            expect(panel.locator(".nao-status").inner_text, "Walk 0.20 m ahead: done.")
            page.keyboard.press("r")
            expect(panel.locator(".nao-status").inner_text, "plays it")
