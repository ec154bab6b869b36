"""Two students on a real JupyterHub, end to end: accounts, lessons, cells, a panel, and what they see of each other."""

import asyncio
import json
import os
import pwd
import stat
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest
import yaml

pytest.importorskip("aiohttp", reason="JupyterHub is not installed: make .venv/hub.stamp")

from benchmarks.hub.running import installation, missing, running_hub
from benchmarks.hub.student import Student
from tests.paths import PROJECT

pytestmark = [pytest.mark.slow, pytest.mark.skipif(bool(missing()), reason=missing())]

LESSON = "00_meet_the_nao"
PANEL = """from nao_course.sim import SimulatedNao
from nao_course.widgets import ControlPanel

panel = ControlPanel(SimulatedNao(rng=1))
panel"""


@pytest.fixture(scope="module")
def hub(tmp_path_factory):
    with installation() as folder, running_hub(folder, tmp_path_factory.mktemp("hub")) as running:
        yield running


async def open_and_drive(hub, claim):
    async with Student(hub.url, claim, hub.password) as student:
        await student.log_in()
        await student.start_server()
        cells = await student.open_lesson(LESSON)
        await student.run([*cells[:2], PANEL])
        await student.drive(2)
        return student


@pytest.fixture(scope="module")
def students(hub):
    async def both():
        return await asyncio.gather(*(open_and_drive(hub, f"{name}@hub.example") for name in ("ada", "root")))

    return asyncio.run(both())


def processes_of(hub, name):
    return [each for each in hub.process.children(recursive=True) if each.username() == name]


def test_each_student_gets_the_lessons_and_drives_the_robot(students):
    for student in students:
        assert student.seen.errors == []
        assert len(student.seen.pictures) > 2
        notebooks = Path(pwd.getpwnam(student.name).pw_dir) / "notebooks"
        assert (notebooks / f"{LESSON}.ipynb").is_file()


def test_each_student_is_a_user_whose_home_is_closed_to_the_others(hub, students):
    names = {student.name for student in students}
    assert len(names) == 2 and all(name.startswith("nao-") for name in names)
    for student in students:
        account = pwd.getpwnam(student.name)
        assert account.pw_uid >= 1000
        assert stat.S_IMODE(os.stat(account.pw_dir).st_mode) == 0o700
        assert processes_of(hub, student.name)
    ada, other = (pwd.getpwnam(student.name) for student in students)
    listed = subprocess.run(
        ["setpriv", f"--reuid={ada.pw_uid}", f"--regid={ada.pw_gid}", "--clear-groups", "ls", other.pw_dir],
        capture_output=True,
        check=False,
    )
    assert listed.returncode != 0 and b"ermission" in listed.stderr


def test_a_kernels_outputs_go_through_files_in_the_home_folder_and_no_port(hub, students):
    """Any user of the machine may connect to a port, and a kernel's ports send its outputs to whoever connects."""
    for student in students:
        runtime = Path(pwd.getpwnam(student.name).pw_dir) / ".local" / "share" / "jupyter" / "runtime"
        connections = [json.loads(path.read_text()) for path in runtime.glob("kernel-*.json")]
        assert connections and all(each["transport"] == "ipc" for each in connections)
        assert all(Path(each["ip"]).parent == runtime for each in connections)
        kernels = [each for each in processes_of(hub, student.name) if "ipykernel_launcher" in each.cmdline()]
        for kernel in kernels:
            # ipykernel's own, for what child processes print: it only receives
            assert len([each for each in kernel.net_connections("inet") if each.status == "LISTEN"]) <= 1


def test_a_students_server_is_not_inside_another_process_of_theirs(hub, students):
    """`nao-course lab` becomes the server; a process that only waits for it would cost memory."""
    for student in students:
        servers = [
            each for each in processes_of(hub, student.name) if "ipykernel_launcher" not in each.cmdline()
        ]
        assert len(servers) == 1


def test_the_exporter_gives_its_numbers_to_the_monitorings_token_and_to_nobody_else(hub, students):
    address = f"{hub.url}/hub/metrics"
    with pytest.raises(urllib.error.HTTPError, match="403"):
        urllib.request.urlopen(address)
    own = hub.log.parent
    token = (own / "monitoring.token").read_text()
    with urllib.request.urlopen(
        urllib.request.Request(address, headers={"Authorization": f"token {token}"})
    ) as answer:
        numbers = answer.read().decode()
    rules = yaml.safe_load((PROJECT / "deploy" / "hub" / "alerts.yml").read_text())["groups"][0]["rules"]
    asked = [
        word for rule in rules for word in rule["expr"].replace("(", " ").split() if "jupyterhub_" in word
    ]
    names = {each.partition("{")[0].partition("[")[0] for each in asked if each.startswith("jupyterhub_")}
    assert names and all(f"\n{name}" in numbers for name in names)
    assert (own / "monitoring.token").stat().st_mode & 0o077 == 0


def test_a_student_is_removed_with_server_home_and_account(hub, students):
    async def log_in():
        async with Student(hub.url, "eve@hub.example", hub.password) as student:
            await student.log_in()
            await student.start_server()
            return student.name

    name = asyncio.run(log_in())
    home = Path(pwd.getpwnam(name).pw_dir)
    assert home.is_dir() and processes_of(hub, name)
    program = PROJECT / "deploy" / "hub" / "remove.py"
    options = ["--api", f"{hub.url}/hub/api", "--hub", str(hub.log.parent), "--yes"]
    done = subprocess.run(
        [sys.executable, program, "eve@hub.example", *options], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert not home.exists() and name not in {each.pw_name for each in pwd.getpwall()}
    assert not processes_of(hub, name)
    assert all(processes_of(hub, each.name) for each in students), "the others work on"
