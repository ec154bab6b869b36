"""What a person waits for at a terminal and at a lesson's first cells, in this build and in one before it.

``python -m benchmarks waiting`` checks the older commit out beside this one (a git worktree), with the same
environment, and measures both in turn. Seconds are of a processor, of the process and all that it started, so that
other programs change them little; the machine's load is stated. Memory is the proportional set size of the kernel.
"""

import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import nbformat
from jupyter_client.manager import start_new_kernel
from rich.progress import track

from benchmarks import ROOT, Result, Table
from nao_course._internal.single_threaded import SINGLE_THREADED

BEFORE = "19c84e2"
LESSONS = ("00_meet_the_nao", "05_ekf_derivations", "07_ekf_slam", "11_slam_on_the_field")
GRADED = ("01_hsl_filtering", "07_ekf_slam", "11_slam_on_the_field")
ROUNDS = 3
MOST_CELLS = 12  # in which a lesson's first figure is looked for
SECONDS, HOUR = 300.0, 3600.0  # at most: for a cell, and for what proves or tests everything
DRIVE = """from nao_course.student import my_nao
panel = my_nao()
display(panel)
panel.forward()
panel.back()"""


def environment(root: Path) -> dict[str, str]:
    """Return a build's environment: one thread, as `nao-course lab` gives, and modules that are compiled once."""
    return os.environ | SINGLE_THREADED | {"PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": ""}


def command_seconds(root: Path, *words: str) -> float:
    """Return the processor seconds of a command of the course."""
    return module_seconds(root, "nao_course.cli", *words)


def first_result_seconds(root: Path, lesson: str) -> float:
    """Return the processor seconds until one student's notebook of a lesson is graded, the build's own solution."""
    with tempfile.TemporaryDirectory() as folder:
        student = Path(folder, "class", "student")
        student.mkdir(parents=True)
        shutil.copy2(root / "solutions" / f"{lesson}.ipynb", student)
        return command_seconds(root, "grade", str(student.parent), "--out", str(Path(folder, "grades")))


def module_seconds(root: Path, *words: str, seconds: float = SECONDS, worst: int = 1) -> float:
    """Return the processor seconds of a module that is run as a program, and of all that it starts.

    Raise a RuntimeError if its exit status is above `worst`: 1 is that of tests that fail and notebooks not finished.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    ran = subprocess.run(
        [sys.executable, "-m", *words],
        cwd=root,
        env=environment(root),
        stdout=subprocess.DEVNULL,
        check=False,
        timeout=seconds,
    )
    if ran.returncode not in range(worst + 1):
        raise RuntimeError(f"in {root}, {' '.join(words)} ends with the exit status {ran.returncode}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def kernel_costs(root: Path, lesson: str) -> dict[str, float]:
    """Return the seconds of the set-up cell and up to the first figure, and the kernel's memory in MB after each."""
    cells = nbformat.read(root / "notebooks" / f"{lesson}.ipynb", as_version=4).cells
    sources = [cell.source for cell in cells if cell.cell_type == "code"][:MOST_CELLS]
    with kernel(root, "notebooks") as (client, pid):
        start, found, outputs = _seconds(pid), dict[str, float](), list[str]()
        for number, source in enumerate(sources):
            reply = client.execute_interactive(
                source, timeout=SECONDS, output_hook=lambda message: outputs.append(str(message["content"]))
            )
            if number == 0 and reply["content"]["status"] != "ok":
                raise RuntimeError(f"the set-up cell of {root / lesson} fails: {reply['content']['evalue']}")
            drawn = any("<svg" in each or "image/png" in each for each in outputs)
            if number == 0:
                found |= {"set-up cell, s": _seconds(pid) - start, "memory after it, MB": _memory(pid)}
            if drawn:
                return found | {"to the first figure, s": _seconds(pid) - start}
        return found


def driven_memory(root: Path) -> float:
    """Return the memory in MB of a kernel after a drive with all stages, which run the solutions."""
    with kernel(root, "solutions") as (client, pid):
        reply = client.execute_interactive(DRIVE, timeout=SECONDS, output_hook=lambda message: None)
        if reply["content"]["status"] != "ok":
            raise RuntimeError(f"a drive of {root} fails: {reply['content']['evalue']}")
        return _memory(pid)


@contextmanager
def kernel(root: Path, folder: str) -> Iterator[tuple[Any, int]]:
    """Start a kernel in a folder of a build; yield its client and its process's number."""
    manager, client = start_new_kernel(env=environment(root), cwd=str(root / folder))
    try:
        yield client, manager.provisioner.process.pid  # type: ignore[union-attr]
    finally:
        client.stop_channels()
        manager.shutdown_kernel(now=True)


def _seconds(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def _memory(pid: int) -> float:
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("Pss:")) / 1000


def measure(root: Path) -> dict[str, float]:
    """Return all costs of one build."""
    found = {
        "nao-course --help, s": command_seconds(root, "--help"),
        "nao-course check of lesson 02, s": command_seconds(root, "check", "notebooks/02_goalposts.ipynb"),
    }
    for lesson in GRADED:
        found[f"grade one notebook of lesson {lesson[:2]}, s"] = first_result_seconds(root, lesson)
    for lesson in LESSONS:
        found |= {f"{lesson[:2]} {what}": value for what, value in kernel_costs(root, lesson).items()}
    found["memory after a drive with all stages, MB"] = driven_memory(root)
    return found


@contextmanager
def two_builds() -> Iterator[dict[str, Path]]:
    """Check out the older commit and this one, each in a folder of its own."""
    folder = Path(tempfile.mkdtemp())
    git = ["git", "-C", str(ROOT), "worktree"]
    builds = {"before": folder / "before", "now": folder / "now"}
    try:
        for path, commit in zip(builds.values(), (BEFORE, "HEAD"), strict=True):
            subprocess.run([*git, "add", "--quiet", "--detach", str(path), commit], check=True)
            (path / ".venv").symlink_to(ROOT / ".venv")
        yield builds
    finally:
        for path in builds.values():
            subprocess.run([*git, "remove", "--force", str(path)], check=False)
        shutil.rmtree(folder, ignore_errors=True)


def compared(name: str, title: str, measure: Callable[[Path], dict[str, float]], rounds: int) -> Result:
    """Measure both builds in turn, and return the medians and their ratios."""
    if sys.platform != "linux":
        raise FileNotFoundError("the times and the memory of processes are read from Linux's /proc")
    seen: dict[str, dict[str, list[float]]] = {"before": defaultdict(list), "now": defaultdict(list)}
    loads = []
    with two_builds() as builds:
        for _ in track(range(rounds), "rounds"):
            for build, root in builds.items():
                loads.append(os.getloadavg()[0])
                for what, value in measure(root).items():
                    seen[build][what].append(value)
    before, now = ({what: statistics.median(each) for what, each in of.items()} for of in seen.values())
    rows = {
        what: {"before": before[what], "now": now[what], "ratio": now[what] / before[what]}
        for what in now
        if what in before
    }
    note = f"Load of the machine: {min(loads):.1f} to {max(loads):.1f}; commit before: {BEFORE}; rounds: {rounds}."
    values = {"before": BEFORE, "loads": loads, "costs": rows}
    return Result(name, values, (Table.of(title, rows, shown=".2f"),), (note,))


def main() -> Result:
    """Measure both builds in turn."""
    return compared("waiting", "What a person waits for", measure, ROUNDS)
