"""Which layers of the sandbox this machine has: each is tried in a process that is thrown away."""

import json
import os
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from nao_course.instructor.sandbox.confinement import (
    SCRATCH,
    UNUSED_USER,
    Confinement,
    enter_namespaces,
    narrow_view,
    readable,
)

if sys.platform == "linux":
    from nao_course.instructor.sandbox import linux
    from nao_course.instructor.sandbox.system_calls import seccomp_program

#   process     nothing else: a student's code can read and write what the grader can.
#   landlock    files, TCP, signals, abstract sockets are closed; UDP and the number of processes are not.
#   namespaces  files, network and processes are the worker's own; it ends as a whole; all it uses is bounded.
#   full        all of this twice, by independent means, as a user without rights, and with fewer system calls.
LEVELS = ("process", "landlock", "namespaces", "full")
NAMESPACES = ("user namespace", "pid namespace", "mount namespace", "ipc namespace", "network namespace")
LINUX_LAYERS = (*NAMESPACES, "landlock", "seccomp", "unprivileged user")
_NEEDS = {"process": (), "landlock": ("landlock",), "namespaces": NAMESPACES, "full": LINUX_LAYERS}
_TRIAL_SECONDS = 60.0


class SandboxError(RuntimeError):
    """A sandbox that is weaker than what was asked for, or than it was when it was tried."""


def check_level(level: str) -> None:
    """Raise ValueError if there is no such level."""
    if level not in LEVELS:
        raise ValueError(f"a sandbox's level is one of {', '.join(LEVELS)}; got {level!r}")


@dataclass(frozen=True)
class Layer:
    """A protection, such as "landlock", against a student's code; `detail` says what it does, or why it is off."""

    name: str
    on: bool
    detail: str = ""


@dataclass(frozen=True)
class Sandbox:
    """The layers of this machine, on or off."""

    layers: tuple[Layer, ...]

    @property
    def on(self) -> frozenset[str]:
        """Names of the layers that work."""
        return frozenset(layer.name for layer in self.layers if layer.on)

    @property
    def level(self) -> str:
        """The highest of LEVELS all of whose layers work."""
        return [level for level in LEVELS if self.on.issuperset(_NEEDS[level])][-1]

    def require(self, level: str) -> None:
        """Raise a SandboxError that says which layer of a level is missing and why; for no such level, a ValueError."""
        check_level(level)
        missing = [layer for layer in self.layers if not layer.on and layer.name in _NEEDS[level]]
        if missing:
            reasons = "; ".join(f"no {layer.name}: {layer.detail}" for layer in missing)
            raise SandboxError(
                f"sandbox level {level!r} is required, this machine has {self.level!r}: {reasons}"
            )

    def __str__(self) -> str:
        """Return the line that is printed at the start."""
        missing = [f"no {layer.name} ({layer.detail})" for layer in self.layers if not layer.on]
        there = f"Sandbox: level {self.level!r} of {LEVELS[-1]!r}"
        if not missing:
            return f"{there}: {', '.join(layer.name for layer in self.layers)}."
        loud = "" if self.level != "process" else " STUDENTS' CODE CAN READ AND WRITE WHAT YOU CAN."
        return f"{there}: {'; '.join(missing)}.{loud}"


@cache
def probe() -> Sandbox:
    """Try every layer, each in a process that is thrown away.

    Off Linux, there are no more than processes with limits.
    """
    layers = [
        Layer("own process", True, "killed with all its group when its time is up"),
        Layer(
            "limits",
            sys.platform != "win32",
            "of time, memory, files" if os.name == "posix" else "not on Windows",
        ),
        Layer("scrubbed environment", True),
        Layer("private folder", True),
    ]
    if sys.platform != "linux":
        return Sandbox((*layers, *(Layer(name, False, f"not on {sys.platform}") for name in LINUX_LAYERS)))
    trial = [sys.executable, "-P", "-m", "nao_course.instructor.sandbox.layers"]
    try:
        done = subprocess.run(trial, capture_output=True, timeout=_TRIAL_SECONDS, check=True)
        found = [Layer(*each) for each in json.loads(done.stdout)]
    except (OSError, subprocess.SubprocessError, ValueError) as error:
        found = [Layer(name, False, f"it could not be tried: {error}") for name in LINUX_LAYERS]
    return Sandbox((*layers, *found))


# --- trying ---


def _tried(attempt: Callable[[], object]) -> str:
    """Run a function in a forked process and return the reason why it fails, or an empty string."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            attempt()
            message = ""
        except BaseException as error:  # noqa: BLE001 - whatever it is, it is the reason
            message = f"{type(error).__name__}: {error}" if not isinstance(error, OSError) else str(error)
        os.write(write, message.encode()[:500])
        os._exit(0)
    os.close(write)
    with os.fdopen(read, "rb") as file:
        message = file.read().decode("utf-8", "replace")
    _, status = os.waitpid(child, 0)
    return message or ("" if status == 0 else f"a process that tried it ended with status {status}")


def _in_a_child(attempt: Callable[[], object]) -> None:
    """Do something in a child; OSError where it fails there."""
    if reason := _tried(attempt):
        raise OSError(reason)


def _must_fail(attempt: Callable[[], object], what: str) -> None:
    try:
        attempt()
    except OSError:
        return
    raise OSError(f"it was set up, but {what} is still possible")


def _try_namespace(name: str) -> None:
    enter_namespaces({"user namespace", name})
    if name == "pid namespace":
        _in_a_child(lambda: _expect(os.getpid() == 1, "it is not the first process"))
    elif name == "network namespace":
        with open("/proc/self/net/dev") as file:
            _expect(len(file.readlines()) <= 3, "there are devices in it")


def _try_view() -> None:
    enter_namespaces({"user namespace", "pid namespace", "mount namespace"})

    def look() -> None:
        narrow_view(readable())
        _must_fail(lambda: os.listdir("/home"), "looking into /home")
        _must_fail(lambda: Path("/here").touch(), "writing to the root")
        os.listdir(sysconfig.get_path("stdlib"))

    _in_a_child(look)


def _expect(true: bool, otherwise: str) -> None:
    if not true:
        raise OSError(otherwise)


def _try_landlock() -> None:
    linux.landlock([(path, linux.FS_READ) for path in readable()])
    _must_fail(lambda: os.listdir("/"), "reading the root folder")
    os.listdir(sysconfig.get_path("stdlib"))


def _try_seccomp() -> None:
    import socket

    linux.no_new_privileges()
    linux.load_filter(seccomp_program({"seccomp"}))
    _must_fail(lambda: socket.socket(socket.AF_INET, socket.SOCK_DGRAM), "opening a socket")


def _try_user(*, namespace: bool) -> None:
    """Switch to an unprivileged user who can still read Python's own files."""
    if os.geteuid() != 0:
        return
    users = enter_namespaces({"user namespace", "unprivileged user"}) if namespace else [UNUSED_USER]
    os.setgroups([])
    os.setresgid(users[0], users[0], users[0])
    os.setresuid(users[0], users[0], users[0])
    if not namespace:  # else it gets a view of its own
        os.listdir(sysconfig.get_path("stdlib"))


def _try_all(on: frozenset[str]) -> None:
    """Do once what the server does."""
    program = seccomp_program(on) if "seccomp" in on else b""
    users = enter_namespaces(on)
    confinement = Confinement(on, tuple(readable()), program)

    def serve() -> None:
        narrow_view(confinement.paths)
        _in_a_child(lambda: confinement.enter(users[0] if users else None, SCRATCH))

    _in_a_child(serve)


def _trial() -> list[Layer]:
    """Try all layers of Linux, one by one, and then together."""
    found = {name: _tried(lambda name=name: _try_namespace(name)) for name in NAMESPACES}  # type: ignore[misc]
    found["mount namespace"] = found["mount namespace"] or _tried(_try_view)
    found["landlock"] = _tried(_try_landlock)
    found["seccomp"] = _tried(_try_seccomp)
    found["unprivileged user"] = _tried(lambda: _try_user(namespace=not found["user namespace"]))
    details = dict.fromkeys(found, "")
    if not found["landlock"]:
        details["landlock"] = f"version {linux.landlock_version()}"
    details["unprivileged user"] = "" if os.geteuid() == 0 else f"started by user {os.geteuid()}"
    # A view without a PID namespace would show the host's processes.
    if any(found[name] for name in NAMESPACES):
        for name in NAMESPACES:
            found[name] = found[name] or "it holds only together with the other namespaces"
    else:
        on = frozenset(name for name, reason in found.items() if not reason)
        if reason := _tried(lambda: _try_all(on)):
            found |= dict.fromkeys(NAMESPACES, f"together: {reason}")
    if any(found[name] for name in NAMESPACES):
        found["unprivileged user"] = _tried(lambda: _try_user(namespace=False))
    return [Layer(name, not reason, reason or details[name]) for name, reason in found.items()]


if __name__ == "__main__":
    sys.stdout.write(json.dumps([[layer.name, layer.on, layer.detail] for layer in _trial()]))
