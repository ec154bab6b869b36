"""Runs a command and prints, as JSON, how it ended, what it left running and what it printed.

The command may run as another user. It then has process numbers, message queues and temporary folders of its own, and
all its processes end with it, so hostile code can run where the sandbox leaves it free. The network is the machine's.
"""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from nao_course.instructor.sandbox import linux
from tests.paths import PROJECT

MOST_PROCESSES = 400  # of the other user
_SECONDS_TO_END = 3.0
_TEMPORARY = [path for path in map(Path, ("/tmp", "/var/tmp", "/dev/shm")) if path.exists()]


def children(process: int) -> list[tuple[int, str]]:
    """Return the running children of a process with their command lines."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = path.read_text(errors="replace").rpartition(")")[2].split()
            if int(words[1]) == process and words[0] not in "ZX":
                line = (path.parent / "cmdline").read_bytes().decode("utf-8", "replace")
                found.append((int(path.parent.name), line))
        except OSError:
            continue
    return found


def run(command: Sequence[str], seconds: float, user: int | None) -> tuple[int, float, list[Any], str]:
    """Run a command as a user, or as this one; return its exit status, its seconds, what is left, and its output."""
    linux.adopt_orphans()
    start = time.monotonic()
    more = {} if user is None else {"user": user, "group": user, "extra_groups": []}
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, **more
    ) as process:
        try:
            output, _ = process.communicate(timeout=seconds)
        except subprocess.TimeoutExpired:
            _end_all()
            output, _ = process.communicate()
    taken = time.monotonic() - start
    while (left := children(os.getpid())) and time.monotonic() < start + taken + _SECONDS_TO_END:
        time.sleep(0.05)
    if user is not None:
        left += [(0, str(path)) for folder in _TEMPORARY for path in folder.glob("*nao_attack*")]
    return process.returncode, taken, left, output.decode("utf-8", "replace")


def _end_all() -> None:
    """End the command: in a PID namespace of its own, all that it started; elsewhere, the children of this process."""
    if os.getpid() == 1:
        os.kill(-1, signal.SIGKILL)
    for process, _ in children(os.getpid()):
        os.kill(process, signal.SIGKILL)


def enter(folders: Sequence[Path]) -> None:
    """Continue in a child that is the first process of new namespaces and sees some folders; this one only waits."""
    linux.unshare(linux.CLONE_NEWPID | linux.CLONE_NEWNS | linux.CLONE_NEWIPC)
    if child := os.fork():
        _, status = os.waitpid(child, 0)
        os._exit(os.waitstatus_to_exitcode(status) & 255)
    linux.die_with_parent(signal.SIGKILL)
    linux.mount("none", "/", flags=linux.MS_REC | linux.MS_PRIVATE)
    linux.mount("proc", "/proc", "proc", linux.MS_NOSUID | linux.MS_NODEV | linux.MS_NOEXEC)
    _open_the_way([Path(sys.base_prefix), Path(sys.prefix), PROJECT, *folders])
    resource.setrlimit(resource.RLIMIT_NPROC, (MOST_PROCESSES, MOST_PROCESSES))
    Path("/proc/self/oom_score_adj").write_text("500")


def _open_the_way(folders: Sequence[Path]) -> None:
    """Let every user see some folders, and put empty folders in the places of temporary ones and of closed ones."""
    sources = {folder: os.open(folder, os.O_PATH) for folder in folders}
    closed = [[each for each in folder.parents if not each.stat().st_mode & 0o001] for folder in folders]
    for folder in {*_TEMPORARY, *(each[-1] for each in closed if each)}:
        mode = "1777" if folder in _TEMPORARY else "755"
        linux.mount("none", str(folder), "tmpfs", linux.MS_NOSUID | linux.MS_NODEV, f"mode={mode}")
    for folder, source in sorted(sources.items()):
        if not folder.exists():
            folder.mkdir(parents=True)
            linux.mount(f"/proc/self/fd/{source}", str(folder), flags=linux.MS_BIND | linux.MS_REC)
        os.close(source)


if __name__ == "__main__":
    linux.die_with_parent(signal.SIGKILL)
    told = json.loads(sys.argv[1])
    if told["user"] is not None:
        enter([Path(each) for each in told["folders"]])
    print(json.dumps(run(sys.argv[2:], told["seconds"], told["user"])))
