"""JupyterLab and Chromium for tests and benchmarks: started here, stopped here, nothing left behind."""

from __future__ import annotations

import json
import os
import re
import shutil
import socket
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import nbformat
import psutil

from nao_course.lab import command as lab_command
from nao_course.lab import environment as lab_environment
from tests.paths import PROJECT

PATIENCE = 240.0  # seconds: a page may be late on a busy machine, and no test fails for that
LAPTOP = {"width": 1366, "height": 768}
CHROMIUM_OPTIONS = [
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
NO_WEBGL = ["--disable-gpu", "--disable-3d-apis"]
# WebGL on the processor, as on a computer without a graphics card
SOFTWARE_WEBGL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
# The course's own settings (nao_course/lab/settings) already keep JupyterLab from asking for news.
QUIET = {"extensionmanager-extension/plugin": {"enabled": False}}


@dataclass
class Lab:
    """A running JupyterLab."""

    url: str
    folder: Path
    settings: Path
    console: list[str] = field(default_factory=list)
    opened: str = ""

    @property
    def log(self) -> Path:
        """The file of what the server prints."""
        return self.settings / "server.log"

    def kernel(self) -> dict[str, Any]:
        """What the server says of the open notebook's kernel; nothing while it is being made."""
        return next((each["kernel"] for each in self._sessions() if each["path"] == self.opened), {})

    def _sessions(self) -> list[dict[str, Any]]:
        try:
            with urllib.request.urlopen(f"{self.url}/api/sessions", timeout=10) as answer:
                return list(json.load(answer))
        except urllib.error.HTTPError:  # the server stumbles over kernels that are just being born
            return []

    def close_notebooks(self) -> None:
        """End all kernels, and forget what was opened and which theme was chosen."""
        for each in self._sessions():
            _request(f"{self.url}/api/sessions/{each['id']}", "DELETE")
        shutil.rmtree(self.settings / "user" / "@jupyterlab" / "apputils-extension", ignore_errors=True)
        self.opened = ""

    def write(self, name: str, *cells: str) -> None:
        """Write a notebook with code cells."""
        notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
        notebook.metadata["kernelspec"] = {
            "name": "python3",
            "display_name": "Python 3",
            "language": "python",
        }
        nbformat.write(notebook, self.folder / name)

    def open(self, page: Any, name: str) -> None:
        """Open a notebook as a student does, and wait until its kernel is connected and idle."""
        self.opened = name
        page.on("console", lambda message: self.console.append(f"{message.type}: {message.text}"))
        page.on("pageerror", self._note_error)
        page.goto(f"{self.url}/lab/tree/{name}?reset")
        page.wait_for_selector(".jp-NotebookPanel .jp-Cell", timeout=240_000)
        wait_for(self._is_ready, "a kernel that is connected and idle")

    def _note_error(self, error: Any) -> None:
        """Keep a page's error, unless JupyterLab removes its splash screen twice: two changes of theme overlapped."""
        where = re.findall(r"^ *at (.+)$", error.stack or "", re.MULTILINE)
        splash = "'removeChild'" in str(error) and len(where) == 1 and "/static/lab/jlab_core." in where[0]
        if not splash:
            self.console.append(f"error: {error}")

    def _is_ready(self) -> bool:
        kernel = self.kernel()
        return kernel.get("connections", 0) > 0 and kernel.get("execution_state") == "idle"

    def run_all(self, page: Any, timeout: float = 300) -> None:
        """Run all cells and wait for the last; repeated, because JupyterLab can lose the first command."""
        before = max((count or 0 for count in self.counts(page)), default=0)

        def started() -> bool:
            return any((count or 0) > before for count in self.counts(page)) or not self._is_ready()

        for _ in range(10):
            page.evaluate(
                "() => window.jupyterapp.commands.execute('notebook:run-all-cells').then(() => null)"
            )
            if wait_for(started, None, 3):
                break
        wait_for(lambda: all((n or 0) > before for n in self.counts(page)), "number at each cell", timeout)

    @staticmethod
    def counts(page: Any) -> list[int | None]:
        """Execution counts of the open notebook's code cells; off-screen cells are in its model only."""
        return list(
            page.evaluate(
                """() => [...window.jupyterapp.shell.currentWidget.content.model.cells]
                .filter(cell => cell.type === 'code' && cell.sharedModel.getSource().trim())
                .map(cell => cell.executionCount)"""
            )
        )

    @staticmethod
    def errors(page: Any) -> list[str]:
        """Exceptions in the open notebook's outputs."""
        return list(
            page.evaluate(
                """() => [...window.jupyterapp.shell.currentWidget.content.model.cells]
                .filter(cell => cell.type === 'code').flatMap(cell => cell.outputs.toJSON())
                .filter(output => output.output_type === 'error').map(output => output.ename + ': ' + output.evalue)"""
            )
        )

    def our_errors(self) -> list[str]:
        """Errors of the browser's console that may be ours: not those of files that JupyterLab itself misses."""
        foreign = (
            "favicon",
            "Failed to load resource",
            "ERR_",
            "preload",
            "service worker",
            "debugger state",
        )
        return [
            line
            for line in self.console
            if line.startswith("error") and not any(word in line for word in foreign)
        ]


def wait_for(condition: Any, what: str | None = None, seconds: float = PATIENCE) -> bool:
    """Poll until a condition holds; if `what` is None its failure is no error."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if condition():
            return True
        time.sleep(0.05)
    if what is not None:
        raise TimeoutError(f"no {what} within {seconds:.0f} s")
    return False


@contextmanager
def jupyter_lab(folder: Path, settings: Path) -> Iterator[Lab]:
    """Serve a folder with this interpreter's JupyterLab, on 127.0.0.1 only; `settings` keeps what it writes."""
    for name, values in QUIET.items():
        extension, plugin = name.split("/")
        path = settings / "user" / "@jupyterlab" / extension / f"{plugin}.jupyterlab-settings"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(values))
    environment = {
        **lab_environment(),
        "JUPYTER_CONFIG_DIR": str(settings / "config"),
        "JUPYTER_DATA_DIR": str(settings / "data"),
        "JUPYTER_RUNTIME_DIR": str(settings / "runtime"),
        "JUPYTERLAB_SETTINGS_DIR": str(settings / "user"),
        "JUPYTERLAB_WORKSPACES_DIR": str(settings / "workspaces"),
        "IPYTHONDIR": str(settings / "ipython"),
        "PYTHONPATH": os.pathsep.join([str(PROJECT), os.environ.get("PYTHONPATH", "")]).rstrip(os.pathsep),
        "MPLBACKEND": "Agg",
    }
    environment.pop("NAO_COURSE_TIME_LIMIT", None)  # a student's machine does not say it
    port = _free_port()
    command = lab_command(folder, ["--no-browser", "--allow-root", f"--ServerApp.port={port}"])
    command += ["--ServerApp.ip=127.0.0.1", "--ServerApp.port_retries=0", "--IdentityProvider.token="]
    command += ["--LabApp.expose_app_in_browser=True"]
    command += ["--LabApp.extension_manager=readonly", "--ServerApp.disable_check_xsrf=True"]
    lab = Lab(f"http://127.0.0.1:{port}", folder, settings)
    with lab.log.open("w") as output:
        server = subprocess.Popen(
            command, env=environment, cwd=folder, stdout=output, stderr=subprocess.STDOUT
        )
    try:
        wait_for(lambda: _answers(lab.url, server, lab.log), "JupyterLab that answers")
        yield lab
    finally:
        _stop(server, lab.url)


def _answers(url: str, server: subprocess.Popen[bytes], log: Path) -> bool:
    if server.poll() is not None:
        raise RuntimeError(f"JupyterLab ended at once:\n{log.read_text()[-3000:]}")
    try:
        with urllib.request.urlopen(f"{url}/api/status", timeout=2):
            return True
    except (urllib.error.URLError, OSError):
        return False


def _request(url: str, method: str) -> None:
    urllib.request.urlopen(urllib.request.Request(url, method=method), timeout=30).close()


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _stop(server: subprocess.Popen[bytes], url: str) -> None:
    """Ask the server to go, then make sure: its kernels are processes of their own."""
    try:
        family = psutil.Process(server.pid).children(recursive=True)
    except psutil.NoSuchProcess:
        family = []
    try:
        _request(f"{url}/api/shutdown", "POST")
        server.wait(15)
    except (urllib.error.URLError, OSError, subprocess.TimeoutExpired):
        server.kill()
        server.wait(10)
    _, alive = psutil.wait_procs(family, timeout=10)
    for process in alive:
        process.kill()
    psutil.wait_procs(alive, timeout=5)


@contextmanager
def browser(executable: str, *, webgl: bool = False) -> Iterator[Any]:
    """Start Chromium, whose pages are as large as a laptop's and share what they have loaded of JupyterLab."""
    from playwright.sync_api import sync_playwright

    options = [*CHROMIUM_OPTIONS, *(SOFTWARE_WEBGL if webgl else NO_WEBGL)]
    root = ["--no-sandbox"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []
    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=executable, args=[*options, *root])
        try:
            yield chromium.new_context(viewport=LAPTOP)
        finally:
            chromium.close()


@contextmanager
def browser_page(executable: str) -> Iterator[Any]:
    """Open a page of a Chromium of its own."""
    with browser(executable) as context:
        yield context.new_page()
