"""Processor time of the grader: its start, and what grader, server and worker need for each submission.

``python -m benchmarks grading_profile`` grades 20 submissions of lesson 01 and then 200. The difference is the cost
of the 180 further submissions; the rest is the start.
"""

from __future__ import annotations

import os
import resource
import tempfile
from pathlib import Path

import psutil

from benchmarks import Result, Table
from benchmarks.course.grading import CLASS, lay_out, watched

FEW = 20
JOBS = 2
PARTS = ("grader", "server", "worker")
EVERY = 0.05  # s: what happens after the last measurement is not counted


def seconds_by_part(pid: int) -> dict[tuple[str, int], float]:
    """Return the processor time so far, s, of the grader, of each warm server and of the workers that have ended.

    The server runs in a child of the process that the grader started. Its first child makes the workers' namespaces,
    so that it belongs to the server.
    """
    found: dict[tuple[str, int], float] = {}
    try:
        grader = psutil.Process(pid)
        found["grader", pid] = _own(grader)
        for started in grader.children():
            if any("fork_server" in word for word in started.cmdline()):
                for server in started.children():
                    times = server.cpu_times()
                    factory = sum(_own(each) for each in server.children()[:1])
                    found["server", server.pid] = times.user + times.system + factory
                    found["worker", server.pid] = times.children_user + times.children_system
    except psutil.Error:  # one of them has just ended
        pass
    return found


def _own(process: psutil.Process) -> float:
    times = process.cpu_times()
    return float(times.user + times.system)


def seconds_of(folder: Path, many: int) -> dict[str, float]:
    """Grade a class, and return the processor time of each part and in all, s, and the time that it took."""
    lay_out(folder / "class", many)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    wall, seen = watched(folder / "class", folder / "grades", JOBS, seconds_by_part, every=EVERY)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    last: dict[tuple[str, int], float] = {}
    for _, found in seen:
        last |= found
    parts = {name: sum(spent for (part, _), spent in last.items() if part == name) for name in PARTS}
    whole = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {**parts, "all": whole, "wall": wall}


def main() -> Result:
    """Compare a small class with a large one."""
    with tempfile.TemporaryDirectory(prefix="nao_course_bench_") as name:
        runs = {}
        for many in (FEW, CLASS):
            folder = Path(name, str(many))
            folder.mkdir()
            runs[many] = seconds_of(folder, many)
    each = {part: (runs[CLASS][part] - runs[FEW][part]) / (CLASS - FEW) for part in (*PARTS, "all", "wall")}
    start = {part: runs[FEW][part] - FEW * each[part] for part in ("all", "wall")}
    rows = [(f"{part}, ms for each submission", 1000 * each[part]) for part in (*PARTS, "all")]
    rows.append(("start, ms", 1000 * start["all"]))
    busy = runs[CLASS]["all"] / runs[CLASS]["wall"] / (os.cpu_count() or 1)
    note = (
        f"{CLASS} submissions take {runs[CLASS]['wall']:.1f} s with {JOBS} jobs on {os.cpu_count()} processors, "
        f"of which they use {100 * busy:.0f} %; the start takes {start['wall']:.1f} s."
    )
    values = {
        "ms for each submission": {part: 1000 * seconds for part, seconds in each.items()},
        "start, s": start,
        "processors in use": busy,
        "runs": {str(many): run for many, run in runs.items()},
    }
    table = Table(f"processor time, {CLASS} submissions of lesson 01", ("", "ms"), tuple(rows))
    return Result("grading_profile", values, (table,), (note,))
