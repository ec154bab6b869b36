"""JupyterLab with the course's settings, which are given to this one server and installed nowhere."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from urllib.parse import quote

__all__ = ["command", "environment", "on_a_hub"]

HERE = Path(__file__).parent
# Bytes of one message: a phone's photo comes in one. Of more than 10 MB, its own limit, JupyterLab's server says
# nothing and closes the connection.
LARGEST_MESSAGE = 60_000_000
_HAS_RUN = re.compile(rb'"execution_count": *[0-9]')

# Over TCP, every user of the hub's server could read a kernel's outputs, because its ports ask for no password.
_ON_A_HUB = ("--KernelManager.transport=ipc", "--LabApp.extension_manager=readonly")


def on_a_hub(inherited: Mapping[str, str] = os.environ) -> bool:
    """Return whether JupyterHub has started this process."""
    return "JUPYTERHUB_SERVICE_URL" in inherited


def command(folder: Path, arguments: Sequence[str] = (), *, hub: bool | None = None) -> list[str]:
    """Return the command that opens a folder in JupyterLab, and in it the lesson that the student goes on with.

    The lesson is alone on the page, without the list of files. A hub opens what it is configured to.

    Parameters
    ----------
    folder : Path
        The folder of the notebooks.
    arguments : sequence of str
        Further arguments of JupyterLab, such as ``--no-browser``.
    hub : bool, optional
        Whether JupyterHub manages the server; by default as `on_a_hub` says.

    Returns
    -------
    list of str
        The program and its arguments.

    Raises
    ------
    ModuleNotFoundError
        If JupyterLab is not installed.
    """
    if find_spec("jupyterlab") is None:
        raise ModuleNotFoundError("JupyterLab is not installed", name="jupyterlab")
    hub = on_a_hub() if hub is None else hub
    if hub:
        opened = ["jupyterhub.singleuser", f"--ServerApp.root_dir={folder}", *_ON_A_HUB]
    else:
        lesson = lesson_to_open(folder)
        page = [f"--LabApp.default_url=/doc/tree/{quote(lesson.name)}"] if lesson else []
        opened = ["jupyterlab", str(folder), *page]
    return [
        *(sys.executable, "-m", *opened),
        f"--LabApp.app_settings_dir={HERE / 'settings'}",
        "--LabApp.custom_css=True",
        "--ServerApp.jpserver_extensions={'nao_course.lab': True}",
        f"--ServerApp.tornado_settings={{'websocket_max_message_size': {LARGEST_MESSAGE}}}",
        *arguments,
    ]


def lesson_to_open(folder: Path) -> Path | None:
    """Return the lesson of a folder that was saved last after a cell had run, else the first lesson, or None."""
    from nao_course.exercises.lesson_names import PATTERN  # NumPy comes with it

    lessons = sorted(path for path in folder.glob(f"{PATTERN}.ipynb") if path.is_file())
    begun = [path for path in lessons if _has_run(path)]
    return max(begun, key=lambda path: path.stat().st_mtime_ns, default=next(iter(lessons), None))


def _has_run(path: Path) -> bool:
    """Return whether a notebook was saved after a cell had run, as far as it can be read."""
    with suppress(OSError):
        return _HAS_RUN.search(path.read_bytes()) is not None
    return False


def _jupyter_server_extension_points() -> list[dict[str, str]]:
    """Return the modules with which this package extends JupyterLab's server."""
    return [{"module": "nao_course.lab"}]


def _load_jupyter_server_extension(server: Any) -> None:
    """Let the server also look for its ``custom.css`` here; the user's own file goes first."""
    server.web_app.settings["static_custom_path"].append(str(HERE / "custom"))


def environment(inherited: Mapping[str, str] = os.environ) -> dict[str, str]:
    """Return the environment of JupyterLab, in which each kernel begins with the course's startup file.

    Parameters
    ----------
    inherited : mapping of str to str
        The variables to begin with. A startup file of the user's own is kept.

    Returns
    -------
    dict of str to str
        All variables.
    """
    return {"PYTHONSTARTUP": str(HERE / "startup.py"), **inherited}
