"""A process that has imported everything a lesson needs, and forks a sandboxed worker when it is asked to.

It listens on one inherited socket and nothing else, holds nothing of any submission, and each worker gets a socket of
its own, whose other end the grader keeps: no worker can speak to the server.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import select
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, NoReturn, Self

from nao_course.exercises.codec import encode
from nao_course.instructor.sandbox import confinement as walls_module
from nao_course.instructor.sandbox.confinement import SCRATCH, Bounds, Sandbox, SandboxError, Walls
from nao_course.instructor.sandbox.worker import SINGLE_THREADED, ServerEnded, answer_calls, describe_end

if sys.platform == "linux":
    from nao_course.instructor.sandbox import linux as syscalls

_WARM = (
    "cv2",
    "matplotlib.pyplot",
    "matplotlib.backends.backend_agg",
    "numpy.random",
    "scipy.linalg",
    "scipy.ndimage",
    "scipy.optimize",
    "scipy.sparse.linalg",
    "scipy.spatial",
    "scipy.stats",
    "sympy",
    "nao_course.datasets",
    "nao_course.exercises",
    "nao_course.plotting",
    "nao_course.sim",
    "nao_course.slam",
    "nao_course.student",
    "nao_course.widgets",
)
_KEPT = ("PYTHONPATH", "PATH", "LANG", "LC_ALL", "LD_LIBRARY_PATH", "HOME", "XDG_CACHE_HOME", "MPLCONFIGDIR")
_SECONDS_TO_START = 90.0  # all those imports, on a machine that is busy
_SECONDS_TO_REPLY = 20.0
_SECONDS_TO_END = 2.0
_WATCH = 0.05  # seconds between two looks at how much memory the workers hold
_MOST_BYTES = 2**16  # of a message
TOO_MUCH_MEMORY = "the process and its children used more than {0} MB of memory"


@dataclass(frozen=True)
class Fork:
    """A worker of a warm server.

    Parameters
    ----------
    number : int
        The server's name for it.
    generation : int
        Which start of the server it belongs to.
    socket : socket
        The grader's end of the worker's channel.
    """

    number: int
    generation: int
    socket: socket.socket


@dataclass
class WarmServer:
    """The grader's side of the server: one for all threads, started again when it died.

    Parameters
    ----------
    sandbox : Sandbox
        Whose layers close around each worker; a worker that lacks one does not start.
    bounds : Bounds
        How much each worker may use.

    Examples
    --------
    ::

        with WarmServer(probe()) as server, Worker(notebook, server=server) as worker:
            outcome = worker.call("white_threshold", Case((120.0,)))
    """

    sandbox: Sandbox
    bounds: Bounds = field(default_factory=Bounds)
    generation: int = field(default=0, init=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False, repr=False)
    _process: subprocess.Popen[bytes] | None = field(default=None, init=False, repr=False)
    _control: socket.socket | None = field(default=None, init=False, repr=False)
    _folder: str = field(default="", init=False, repr=False)
    _forks: int = field(default=0, init=False, repr=False)

    @property
    def forks(self) -> bool:
        """Whether workers are forked; elsewhere each is a process of its own with limits."""
        return sys.platform == "linux"

    @property
    def process(self) -> int | None:
        """Number of the server's process while it runs."""
        return self._process.pid if self._process else None

    def __enter__(self) -> Self:
        """Start the server."""
        if self.forks:
            with self._lock:
                self._running()
        return self

    def __exit__(self, *_: object) -> None:
        """End the server and all its workers."""
        self.close()

    def close(self) -> None:
        """End the server and all its workers; a further fork starts it again."""
        with self._lock:
            self._stop()

    def fork(self) -> Fork:
        """Start a worker.

        Raises
        ------
        SandboxError
            If the server or a worker cannot be confined as it was when it was tried.
        ServerEnded
            If the server died meanwhile.
        """
        ours, theirs = socket.socketpair()
        with self._lock, theirs:
            try:
                self._running()
                self._forks += 1
                reply = self._ask({"fork": self._forks}, theirs)
                if "failed" in reply:
                    raise SandboxError(f"no worker could be forked: {reply['failed']}")
            except BaseException:
                ours.close()
                raise
            return Fork(self._forks, self.generation, ours)

    def end(self, fork: Fork) -> str:
        """End a worker with all its processes, and say how it ended.

        Raises
        ------
        ServerEnded
            If its server is gone, and the worker with it.
        """
        fork.socket.close()
        with self._lock:
            if fork.generation != self.generation or not self._process:
                raise ServerEnded("the warm server died, and this worker with it")
            return str(self._ask({"end": fork.number}).get("ended"))

    def _running(self) -> None:
        """Start the server if it is not there; the lock is held."""
        if self._process and self._process.poll() is None:
            return
        self._stop()
        self.generation += 1
        control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._control = control
        if "mount namespace" not in self.sandbox.on:
            self._folder = tempfile.mkdtemp(prefix="nao-course-")
        told = {"on": sorted(self.sandbox.on), "bounds": asdict(self.bounds), "folder": self._folder}
        environment = {name: os.environ[name] for name in _KEPT if name in os.environ} | SINGLE_THREADED
        environment["MALLOC_ARENA_MAX"] = "2"  # else each thread takes 64 MB of its address space
        with theirs:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", __name__, str(theirs.fileno()), json.dumps(told)],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(),),
                cwd="/",
                env=environment,
                start_new_session=True,
            )
        try:
            reply = self._receive(_SECONDS_TO_START)
        except ServerEnded:
            reply = {"failed": "it ended without a word"}
        if "failed" in reply:
            self._stop()
            raise SandboxError(f"the warm server could not start: {reply['failed']}")

    def _ask(self, request: Mapping[str, Any], end: socket.socket | None = None) -> dict[str, Any]:
        assert self._control  # the server runs
        try:
            descriptors = [end.fileno()] if end else []
            socket.send_fds(self._control, [json.dumps(request).encode()], descriptors)
        except OSError:
            self._died()
        return self._receive(_SECONDS_TO_REPLY)

    def _receive(self, seconds: float) -> dict[str, Any]:
        assert self._control  # the server runs
        self._control.settimeout(seconds)
        try:
            message = self._control.recv(_MOST_BYTES)
        except OSError:  # a time-out, too
            message = b""
        if not message:
            self._died()
        return json.loads(message)

    def _died(self) -> NoReturn:
        self._stop()
        raise ServerEnded("the warm server died; what was being graded has to be graded again")

    def _stop(self) -> None:
        if self._control:
            self._control.close()  # it ends when nobody can ask any more
            self._control = None
        if self._process:
            try:
                self._process.wait(_SECONDS_TO_END)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
            self._process = None
        if self._folder:
            shutil.rmtree(self._folder, ignore_errors=True)
            self._folder = ""


# --- the server's side ---


@dataclass(frozen=True)
class _Keeper:
    """The first process of a PID namespace, with a descriptor of its own and one of the namespace."""

    process: int
    itself: int
    namespace: int

    def kill(self) -> None:
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self.itself, signal.SIGKILL)

    def wait(self) -> None:
        """Wait until it, and with it the namespace, is gone."""
        poll = select.poll()
        poll.register(self.itself, select.POLLIN)
        poll.poll()
        os.close(self.itself)


class _Nursery:
    """A small process that forks keepers: forking the whole server for each would double what a worker costs."""

    def __init__(self, walls: Walls, users: list[int]) -> None:
        self.channel, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        if os.fork() == 0:
            try:
                _close_all_but([theirs.fileno()])
                _make_keepers(theirs, walls, users[-1] if users else None)
            finally:
                os._exit(1)
        theirs.close()

    def keeper(self) -> _Keeper:
        """Return a new keeper; OSError where there can be none."""
        self.channel.send(b"next")
        message, descriptors, _, _ = socket.recv_fds(self.channel, 100, 1)
        if not descriptors:
            raise OSError(message.decode() or "the process that makes PID namespaces has ended")
        process = int(message)
        return _Keeper(process, os.pidfd_open(process), descriptors[0])


def _make_keepers(channel: socket.socket, walls: Walls, user: int | None) -> NoReturn:
    """Answer each message with a new PID namespace, until nobody asks any more."""
    syscalls.die_with_parent(signal.SIGKILL)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # ended keepers are cleared away by the kernel
    own = os.open("/proc/self/ns/pid", os.O_RDONLY)
    while channel.recv(100):
        try:
            syscalls.unshare(syscalls.CLONE_NEWPID)
            keeper = os.fork()
            if keeper == 0:
                _keep(walls, user)
            made = os.open("/proc/self/ns/pid_for_children", os.O_RDONLY)
            syscalls.setns(own, syscalls.CLONE_NEWPID)
            socket.send_fds(channel, [str(keeper).encode()], [made])
            os.close(made)
        except OSError as error:
            channel.send(str(error).encode()[:100])
    os._exit(0)


def _keep(walls: Walls, user: int | None) -> NoReturn:
    """Only be there: all other processes of the namespace end with this one."""
    try:
        _close_all_but([])
        walls.idle(user)
        while True:
            signal.pause()
    finally:
        os._exit(1)


@dataclass
class _Forked:
    """A worker as the server knows it."""

    process: int
    keeper: _Keeper | None
    slot: int
    folder: str
    over: bool = False


class _Server:
    def __init__(
        self, control: socket.socket, walls: Walls, users: list[int], folder: str, nursery: _Nursery | None
    ) -> None:
        self.control, self.walls, self.users, self.folder = control, walls, users, folder
        self.nursery = nursery
        self.watched = 0.0
        self.workers: dict[int, _Forked] = {}
        self.mounts = "mount namespace" in walls.on
        self.ours = os.open("/proc/self/ns/pid", os.O_RDONLY) if "pid namespace" in walls.on else None

    def serve(self) -> NoReturn:
        """Fork and end workers until nobody can ask any more."""
        poll = select.poll()
        poll.register(self.control, select.POLLIN)
        while True:
            if poll.poll(_WATCH * 1000 if self.workers else None):
                message, descriptors, _, _ = socket.recv_fds(self.control, _MOST_BYTES, 1)
                if not message:
                    self.leave()
                self.say(self.answer(json.loads(message), descriptors))
            if time.monotonic() - self.watched > _WATCH:
                self.watch()

    def say(self, reply: Mapping[str, Any]) -> None:
        try:
            self.control.send(json.dumps(reply).encode())
        except OSError:
            self.leave()

    def leave(self) -> NoReturn:
        """End, with all workers; where there is a PID namespace, they do so by themselves."""
        if self.ours is None:
            for number in list(self.workers):
                self.end(number)
        os._exit(0)

    def answer(self, request: dict[str, Any], descriptors: list[int]) -> dict[str, Any]:
        if "end" in request:
            return {"ended": self.end(request["end"])}
        try:
            self.fork(request["fork"], descriptors[0])
        except OSError as error:
            return {"failed": str(error)}
        finally:
            for each in descriptors:
                os.close(each)
        return {"forked": request["fork"]}

    def fork(self, number: int, channel: int) -> None:
        taken = {worker.slot for worker in self.workers.values()}
        slot = next(slot for slot in range(len(taken) + 1) if slot not in taken)
        user = self.users[slot % len(self.users)] if self.users else None
        folder = SCRATCH if self.mounts else self.make_folder(number, user)
        keeper = None
        try:
            if self.nursery:
                keeper = self.nursery.keeper()
                syscalls.setns(keeper.namespace, syscalls.CLONE_NEWPID)
            process = self.child(lambda: self.work(user, folder, channel), [channel])
        except OSError:
            if keeper:
                keeper.kill()
                keeper.wait()
            raise
        finally:
            if keeper and self.ours is not None:
                os.close(keeper.namespace)
                syscalls.setns(self.ours, syscalls.CLONE_NEWPID)
        self.workers[number] = _Forked(process, keeper, slot, folder)

    def make_folder(self, number: int, user: int | None) -> str:
        path = f"{self.folder}/{number}"
        os.mkdir(path, 0o700)
        if user is not None:
            os.chown(path, user, user)
        return path

    def child(self, work: Any, descriptors: list[int]) -> int:
        """Fork a process that does something, with no descriptor but some, and never returns."""
        process = os.fork()
        if process:
            return process
        try:
            with contextlib.suppress(OSError):
                os.setsid()
            _close_all_but(descriptors)
            work()
        finally:
            os._exit(70)

    def work(self, user: int | None, folder: str, channel: int) -> NoReturn:
        try:
            self.walls.close_around(user, folder)
        except OSError as error:
            os.write(channel, encode(("unsafe", str(error))))
            os._exit(70)
        _new_environment(folder)
        answer_calls(channel, channel, self.walls.paths)

    def end(self, number: int) -> str:
        worker = self.workers.pop(number)
        with contextlib.suppress(ProcessLookupError):
            os.kill(worker.process, signal.SIGKILL)
        if worker.keeper:
            worker.keeper.kill()
        else:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(worker.process, signal.SIGKILL)
        _, status = os.waitpid(worker.process, 0)
        if worker.keeper:
            worker.keeper.wait()
        self.sweep()
        if not self.mounts:
            shutil.rmtree(worker.folder, ignore_errors=True)
        if worker.over:
            return TOO_MUCH_MEMORY.format(self.walls.bounds.memory // 2**20)
        return describe_end(os.waitstatus_to_exitcode(status))

    def sweep(self) -> None:
        """End what workers left behind; where there is no PID namespace, it becomes the server's child."""
        if self.ours is not None:
            return
        known = {worker.process for worker in self.workers.values()}
        while strays := [child for child in _children(os.getpid()) if child not in known]:
            for stray in strays:
                os.kill(stray, signal.SIGKILL)
                os.waitpid(stray, 0)

    def watch(self) -> None:
        """End workers whose processes together hold too much memory."""
        self.watched = time.monotonic()
        if self.ours is None:
            return
        parents, own = dict(_processes()), _held("self")
        for worker in self.workers.values():
            roots = {worker.process, worker.keeper.process if worker.keeper else None}
            held = sum(max(_held(str(each)) - own, 0) for each in parents if _descends(each, roots, parents))
            if worker.keeper and not worker.over and held > self.walls.bounds.memory:
                worker.over = True
                worker.keeper.kill()


def _close_all_but(descriptors: list[int]) -> None:
    start = 3
    for each in sorted(descriptors):
        os.closerange(start, each)
        start = each + 1
    os.closerange(start, 2**16)


def _new_environment(folder: str) -> None:
    os.environ.clear()
    os.environ.update(SINGLE_THREADED)
    os.environ.update(
        dict.fromkeys(("HOME", "TMPDIR", "MPLCONFIGDIR"), folder), PATH=os.defpath, LANG="C.UTF-8"
    )
    tempfile.tempdir = None


def _children(process: int) -> list[int]:
    return [child for child, parent in _processes() if parent == process]


def _processes() -> Iterator[tuple[int, int]]:
    """Every process that is in sight, with its parent."""
    for name in os.listdir("/proc"):
        if name.isdigit():
            with contextlib.suppress(OSError), open(f"/proc/{name}/stat", "rb") as file:
                yield int(name), int(file.read().rpartition(b")")[2].split()[1])


def _descends(process: int, roots: set[int | None], parents: Mapping[int, int]) -> bool:
    """Whether a process is one of some, or comes from one."""
    while process in parents:
        if process in roots:
            return True
        process = parents[process]
    return False


def _held(process: str) -> int:
    """Bytes of memory that a process holds, but for files; 0 for one that has just ended."""
    held = 0
    with contextlib.suppress(OSError), open(f"/proc/{process}/status", "rb") as file:
        for line in file:
            if line.startswith((b"RssAnon:", b"RssShmem:", b"VmSwap:")):
                held += int(line.split()[1]) * 1024
    return held


def _warm_up() -> None:
    """Import what the lessons use, with one thread."""
    for name in _WARM:
        importlib.import_module(name)
    importlib.import_module("cv2").setNumThreads(1)
    if len(os.listdir("/proc/self/task")) > 1:
        raise OSError("a library has started threads: no process may be forked")
    gc.collect()
    gc.freeze()


def _serve(control: socket.socket, told: Mapping[str, Any], users: list[int]) -> NoReturn:
    try:
        syscalls.die_with_parent(signal.SIGKILL)
        syscalls.adopt_orphans()
        on = frozenset(told["on"])
        paths = tuple(walls_module.readable())
        program = walls_module.seccomp_program(on) if "seccomp" in on else b""
        walls = Walls(on, paths, program, Bounds(**told["bounds"]))
        nursery = _Nursery(walls, users) if "pid namespace" in on else None
        _warm_up()
        if "mount namespace" in on:
            walls_module.narrow_view(paths)
        server = _Server(control, walls, users, told["folder"], nursery)
    except BaseException as error:  # noqa: BLE001 - the grader says what it was
        control.send(json.dumps({"failed": f"{type(error).__name__}: {error}"[:1000]}).encode())
        os._exit(1)
    server.say({"ready": True})
    server.serve()


def main() -> NoReturn:
    """Serve the grader that holds the other end of an inherited socket."""
    control = socket.socket(fileno=int(sys.argv[1]))
    control.set_inheritable(False)
    told, grader = json.loads(sys.argv[2]), os.getppid()
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGCHLD})
    try:
        users = walls_module.enter_namespaces(told["on"])
        child = os.fork()  # the first process of the new PID namespace
    except OSError as error:
        control.send(json.dumps({"failed": str(error)}).encode())
        os._exit(1)
    if child == 0:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGCHLD})
        try:
            _serve(control, told, users)
        finally:
            os._exit(1)
    control.close()
    while os.waitpid(child, os.WNOHANG) == (0, 0) and os.getppid() == grader:
        signal.sigtimedwait({signal.SIGCHLD}, 1.0)
    os._exit(0)


if __name__ == "__main__":
    main()
