"""A class on one JupyterHub: 1, 10 and 30 simulated students with lesson 11, through HTTP and WebSockets.

``python -m benchmarks hub`` needs root, because it creates the students' accounts, and the proxy from npm
(``make .venv/hub.stamp``). The hub has the configuration of deploy/hub with a password instead of LTI, and it starts
servers without systemd. All students come within a few seconds, which is the worst case: in a lab they come in minutes.
"""

import asyncio
import os
import pwd
import tempfile
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import psutil

from benchmarks import ROOT, Result, Table, processor
from benchmarks.course.grading import own_mb
from benchmarks.hub.running import Hub, give_solutions, installation, missing, running_hub

CLASSES = (1, 10, 30)
LESSON = "11_slam_on_the_field"
CELLS = 13  # the set-up and all cells up to exercise 11.2's; then the panel with every stage of the student's code
PANEL = 'my_nao(upto="11")'
PRESSES = 4
BETWEEN = 1.0  # s between two students' logins
SERVER = {"cores": 8, "memory_gb": 64, "for_the_system_gb": 4}  # what the calculation is about
WANTED_MB = 250


async def _session(hub: Hub, number: int, counts: dict[str, Any]) -> Any:
    """Let a student log in, open the lesson, run cells and drive; return what was seen."""
    from benchmarks.hub.student import Student

    await asyncio.sleep(BETWEEN * number)
    async with Student(hub.url, f"load-{number}@bench.example", hub.password) as student:
        await student.log_in()
        await student.start_server()
        give_solutions(Path(pwd.getpwnam(student.name).pw_dir), counts["lessons"])
        cells = await student.open_lesson(LESSON)
        counts["open"][student.name] = memory(hub, student.name)
        await student.run(cells[:1])
        counts["set up"][student.name] = memory(hub, student.name)
        await student.run(cells[1:CELLS])
        await student.run([each for each in cells if each.strip() == PANEL])
        await student.drive(PRESSES)
        await _together(counts)
        counts["driven"][student.name] = memory(hub, student.name)
        if counts["all cells"] is not None:
            kept = len(student.seen.cells)
            await student.run(cells[CELLS:])
            counts["all cells"][student.name] = memory(hub, student.name)
            del student.seen.cells[kept:]  # the table compares the same cells for all classes
        return student.seen


async def _together(counts: dict[str, Any]) -> None:
    """Wait until all students have come so far: memory is shared by those who are there."""
    counts["arrived"] += 1
    while counts["arrived"] < counts["students"]:
        await asyncio.sleep(0.2)


def memory(hub: Hub, name: str) -> dict[str, float]:
    """Return the memory of a student's server and of their kernels, PSS in MB."""
    found = {"server": 0.0, "kernel": 0.0}
    for process in hub.process.children(recursive=True):
        try:
            if process.username() == name:
                kind = "kernel" if "ipykernel_launcher" in process.cmdline() else "server"
                found[kind] += own_mb(process.pid)
        except psutil.NoSuchProcess:
            continue
    return found


def measured(hub: Hub, students: int, *, whole: bool) -> dict[str, Any]:
    """Run a class, and return its figures; `whole` runs all cells of the lesson at the end."""
    lessons = sorted(path.stem for path in (ROOT / "solutions").glob("*.ipynb"))
    counts: dict[str, Any] = {"students": students, "arrived": 0, "lessons": lessons}
    counts |= {"open": {}, "set up": {}, "driven": {}, "all cells": {} if whole else None}

    async def everybody() -> list[Any]:
        return await asyncio.gather(*(_session(hub, number, counts) for number in range(students)))

    seen = asyncio.run(everybody())
    errors = [error for each in seen for error in each.errors]
    if errors:
        raise RuntimeError(f"{len(errors)} cells failed, the first with {errors[0]}")
    cells = [seconds for each in seen for seconds in each.cells]
    waits = [after - before for each in seen for before, after in pairwise(each.pictures)]
    figures: dict[str, Any] = {
        "students": students,
        "server_s": _quantiles([each.server for each in seen]),
        "set_up_s": _quantiles([each.cells[0] for each in seen]),
        "cell_s": _quantiles(cells),
        "pictures_per_second": float(1 / np.mean(waits)),
    }
    for state in ("open", "set up", "driven", "all cells"):
        if counts[state]:
            parts = {
                part: float(np.mean([each[part] for each in counts[state].values()]))
                for part in ("server", "kernel")
            }
            figures[f"mb_{state.replace(' ', '_')}"] = parts | {"both": sum(parts.values())}
    return figures


def _quantiles(values: list[float]) -> dict[str, float]:
    return {"median": float(np.median(values)), "p95": float(np.quantile(values, 0.95))}


def on_a_large_server(figures: dict[str, Any], cpu_s: float) -> dict[str, float]:
    """Calculate how many students a larger server holds, by its memory and by its processors.

    `figures` are of the largest class that was measured, and `cpu_s` is a student's processor time for the whole
    lesson, s.
    """
    free = 1024 * (SERVER["memory_gb"] - SERVER["for_the_system_gb"])
    return {
        **SERVER,
        "students_by_memory": int(free / figures["mb_driven"]["both"]),
        "students_in_an_hour_by_processors": int(SERVER["cores"] * 3600 / cpu_s),
    }


def main() -> Result:
    """Measure the classes, each with a hub of its own."""
    if reason := missing():
        raise FileNotFoundError(reason)
    with installation() as folder:
        classes = [one_class(folder, students) for students in CLASSES]
    large = on_a_large_server(classes[-1], classes[0]["processor_s_per_student"])
    machine = {"cpu": processor(), "cores": os.cpu_count(), "lesson": LESSON}
    values = {"classes": classes, "calculated": large, "wanted_mb": WANTED_MB, "machine": machine}
    columns = [_rows(each) for each in classes]
    rows = tuple((name, *(each[name] for each in columns)) for name in columns[0])
    heads = ("students at once", *(str(each["students"]) for each in classes))
    note = (
        f"By calculation, a server with {large['cores']} cores and {large['memory_gb']} GB holds "
        f"{large['students_by_memory']} students by memory, and its processors run the whole lesson "
        f"{large['students_in_an_hour_by_processors']} times an hour."
    )
    return Result("hub", values, (Table("A JupyterHub with lesson 11, memory as PSS", heads, rows),), (note,))


def one_class(folder: Path, students: int) -> dict[str, Any]:
    """Start a hub, and measure a class; one student alone also runs all other cells of the lesson."""
    with (
        tempfile.TemporaryDirectory(prefix="nao_course_hub_") as scratch,
        running_hub(folder, Path(scratch)) as hub,
    ):
        before = _processor_seconds(hub)
        figures = measured(hub, students, whole=students == 1)
        return figures | {"processor_s_per_student": (_processor_seconds(hub) - before) / students}


def _processor_seconds(hub: Hub) -> float:
    """Return the processor time of the hub and of all students' servers and kernels so far, s."""
    total = 0.0
    for process in [hub.process, *hub.process.children(recursive=True)]:
        try:
            total += sum(process.cpu_times()[:2])
        except psutil.NoSuchProcess:
            continue
    return total


def _rows(each: dict[str, Any]) -> dict[str, str]:
    """Return the column of a class in the table."""

    def pair(name: str) -> str:
        return f"{each[name]['median']:.2f} / {each[name]['p95']:.2f} s"

    def mb(name: str) -> str:
        return (
            f"{each[name]['both']:.0f} ({each[name]['server']:.0f} + {each[name]['kernel']:.0f})"
            if name in each
            else ""
        )

    return {
        "start of the server, median / 95 %": pair("server_s"),
        "set-up cell": pair("set_up_s"),
        "any cell": pair("cell_s"),
        "pictures a second of a panel that drives": f"{each['pictures_per_second']:.1f}",
        "MB (server + kernel), lesson open": mb("mb_open"),
        "MB after the set-up cell": mb("mb_set_up"),
        "MB after a drive with all stages": mb("mb_driven"),
        "MB after all cells": mb("mb_all_cells"),
        "processor time of a student, s": f"{each['processor_s_per_student']:.0f}",
    }
