"""A real JupyterHub with the class's configuration: installed, started, and removed with its accounts."""

import os
import secrets
import shutil
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import psutil

from benchmarks import ROOT
from nao_course.homework import NOTEBOOKS, zipped
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.release import FOLDER, contents

HUB = ROOT / "deploy" / "hub"
PROXY = HUB / "node_modules" / ".bin" / "configurable-http-proxy"
CONFIG = Path(__file__).with_name("load_test_config.py")
INSTALLED = "NAO_COURSE_HUB"  # variable with a folder of an earlier installation, which saves a minute


@dataclass(frozen=True)
class Hub:
    """A running hub."""

    url: str  # its address, without a slash at the end
    password: str  # the password of every student
    # the hub itself; the proxy, the culler and the students' servers are its children
    process: psutil.Process
    log: Path  # file with all that the hub and the servers say


def missing() -> str:
    """Return what a hub needs and this machine lacks; empty if there is nothing."""
    if not sys.platform.startswith("linux") or os.geteuid() != 0:
        return "JupyterHub needs root on Linux to create the students' accounts"
    if not PROXY.exists() or not shutil.which("node"):
        return "its proxy is not installed: run make .venv/hub.stamp, which needs node and npm"
    if not all(map(shutil.which, ("useradd", "userdel"))):
        return "this machine has no useradd"
    return ""


@contextmanager
def installation() -> Iterator[Path]:
    """Install the course of this repository as docs/setup.md does, in a folder that all users can read."""
    if os.environ.get(INSTALLED):
        yield Path(os.environ[INSTALLED])
        return
    with tempfile.TemporaryDirectory(prefix="nao_course_hub_") as scratch:
        folder = Path(scratch)
        folder.chmod(0o755)
        install(folder)
        yield folder


def install(folder: Path) -> None:
    """Run install.sh with a release of this repository."""
    course = load_course(ROOT)
    files = contents(course, course.names())
    release = folder / f"{FOLDER}-{course.version}.zip"
    release.write_bytes(zipped({f"{FOLDER}/{name}": content for name, content in files.items()}))
    environment = {**os.environ, "PYTHON": _interpreter()}
    subprocess.run(["sh", str(HUB / "install.sh"), str(release), str(folder)], env=environment, check=True)


@contextmanager
def running_hub(folder: Path, scratch: Path) -> Iterator[Hub]:
    """Start a hub; stop it at the end, with all servers, and remove the accounts that it has created."""
    port, password = _free_ports(3), secrets.token_hex(8)
    accounts = set(_homes())
    environment = {
        **os.environ,
        "NAO_COURSE_FOLDER": str(folder),
        "HUB_CONFIG": str(HUB / "jupyterhub_config.py"),
        "HUB_PASSWORD": password,
        "HUB_PORT": str(port),
        # For env_keep of JupyterHub, which hands PATH to the students' servers
        "PATH": f"{folder / 'current' / '.venv' / 'bin'}{os.pathsep}{os.environ['PATH']}",
    }
    log = scratch / "hub.log"
    with log.open("w") as output:
        process = subprocess.Popen(
            [folder / "current" / ".venv" / "bin" / "jupyterhub", "--config", CONFIG],
            env=environment,
            cwd=scratch,
            stdout=output,
            stderr=subprocess.STDOUT,
        )
    hub = Hub(f"http://127.0.0.1:{port}", password, psutil.Process(process.pid), log)
    try:
        _wait_until_it_answers(hub, process)
        yield hub
    finally:
        family = hub.process.children(recursive=True) if process.poll() is None else []
        process.terminate()
        try:
            process.wait(30)
        except subprocess.TimeoutExpired:
            process.kill()
        for each in psutil.wait_procs(family, timeout=10)[1]:
            with suppress(psutil.NoSuchProcess):
                each.kill()
        for name in set(_homes()) - accounts:
            subprocess.run(["userdel", "--remove", name], check=False, capture_output=True)


def give_solutions(home: Path, lessons: list[str]) -> None:
    """Put the solved notebooks into a student's folder, as if the student had written them."""
    owner = home.stat()
    for lesson in lessons:
        path = home / NOTEBOOKS / f"{lesson}.ipynb"
        shutil.copyfile(ROOT / "solutions" / path.name, path)
        os.chown(path, owner.st_uid, owner.st_gid)


def _interpreter() -> str:
    """Return this Python if every user may run it, else the system's."""
    base = Path(sys.base_prefix).resolve()
    is_public = all(each.stat().st_mode & 0o005 == 0o005 for each in (base, *base.parents))
    return str(base / "bin" / "python3") if is_public else "/usr/bin/python3"


def _homes() -> list[str]:
    """Return the names of all accounts that a hub has created."""
    import pwd

    return [each.pw_name for each in pwd.getpwall() if each.pw_name.startswith("nao-")]


def _free_ports(count: int) -> int:
    """Return the first of some neighbouring free ports."""
    while True:
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            first = int(probe.getsockname()[1])
        if first + count < 65536 and all(_is_free(first + i) for i in range(count)):
            return first


def _is_free(port: int) -> bool:
    with socket.socket() as probe, suppress(OSError):
        probe.bind(("127.0.0.1", port))
        return True
    return False


def _wait_until_it_answers(hub: Hub, process: subprocess.Popen[bytes], seconds: float = 60) -> None:
    end = time.monotonic() + seconds
    while time.monotonic() < end and process.poll() is None:
        with suppress(urllib.error.URLError, OSError), urllib.request.urlopen(f"{hub.url}/hub/health"):
            return
        time.sleep(0.2)
    raise RuntimeError(f"JupyterHub does not answer:\n{hub.log.read_text()[-3000:]}")
