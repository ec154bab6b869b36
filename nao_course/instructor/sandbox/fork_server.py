"""The warm server's process: it has imported what a lesson needs, and forks a sandboxed worker when it is asked to.

It listens on one inherited socket and nothing else, holds nothing of any submission, and each worker gets a socket of
its own, whose other end the grader keeps: no worker can speak to the server.
"""

import contextlib
import gc
import importlib
import json
import os
import pkgutil
import select
import shutil
import signal
import socket
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

import nao_course
from nao_course.codec import encode
from nao_course.exercises.comparisons.sampling import prepare_seeds
from nao_course.exercises.outline import read_all_outlines
from nao_course.instructor.sandbox.confinement import (
    INSTRUCTORS,
    SCRATCH,
    Bounds,
    Confinement,
    enter_namespaces,
    narrow_view,
    readable,
)
from nao_course.instructor.sandbox.protocol import MOST_REQUEST, OF_A_WORKER, describe_end, schedule_of
from nao_course.instructor.sandbox.worker_process import answer_calls

if sys.platform == "linux":
    from nao_course.instructor.sandbox import linux
    from nao_course.instructor.sandbox.system_calls import seccomp_program

_LIBRARIES = (
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
)
_MOST_WAITING = 10.0  # seconds for a namespace to end
_LAST = 19  # priority of the processes that a worker starts
_WATCH = 0.05  # seconds between two measurements of the workers' memory
# Bytes above the limit at which a worker's processes are ended. One process alone stays below, because it gets a
# MemoryError at the limit: then only the statement that took all memory is left out.
_ABOVE = 16 * 2**20
TOO_MUCH_MEMORY = "the process and its children used more than {0} MB of memory"


@dataclass(frozen=True)
class NamespaceInit:
    """The first process of a PID namespace, with a descriptor of its own and one of the namespace."""

    process: int
    itself: int
    namespace: int

    def kill(self) -> None:
        """End it, and with it the namespace."""
        with contextlib.suppress(ProcessLookupError):
            signal.pidfd_send_signal(self.itself, signal.SIGKILL)

    def wait(self, meanwhile: Callable[[], object]) -> None:
        """Wait for a limited time until the process and its namespace have ended, and call a function meanwhile."""
        poll, end = select.poll(), time.monotonic() + _MOST_WAITING
        poll.register(self.itself, select.POLLIN)
        while not poll.poll(10) and time.monotonic() < end:
            meanwhile()
        os.close(self.itself)


class NamespaceFactory:
    """A small process that makes PID namespaces: forking the whole server for each would double what a worker costs."""

    def __init__(self, confinement: Confinement, users: list[int]) -> None:
        self.channel, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self.process = os.fork()
        if self.process == 0:
            try:
                _close_all_but([theirs.fileno()])
                _make_namespaces(theirs, confinement, users[-1] if users else None)
            finally:
                os._exit(1)
        theirs.close()

    def new_namespace(self) -> NamespaceInit:
        """Return the first process of a new namespace, or raise OSError if it cannot be created."""
        self.channel.send(b"next")
        message, descriptors, _, _ = socket.recv_fds(self.channel, 100, 1)
        if not descriptors:
            raise OSError(message.decode() or "the process that makes PID namespaces has ended")
        process = int(message)
        return NamespaceInit(process, os.pidfd_open(process), descriptors[0])


def _make_namespaces(channel: socket.socket, confinement: Confinement, user: int | None) -> NoReturn:
    """Answer each message with a new PID namespace, until nobody asks any more."""
    linux.die_with_parent(signal.SIGKILL)
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # ended first processes are cleared away by the kernel
    own = os.open("/proc/self/ns/pid", os.O_RDONLY)
    while channel.recv(100):
        try:
            linux.unshare(linux.CLONE_NEWPID)
            init = os.fork()
            if init == 0:
                _be_init(confinement, user)
            made = os.open("/proc/self/ns/pid_for_children", os.O_RDONLY)
            linux.setns(own, linux.CLONE_NEWPID)
            socket.send_fds(channel, [str(init).encode()], [made])
            os.close(made)
        except OSError as error:
            channel.send(str(error).encode()[:100])
    os._exit(0)


def _be_init(confinement: Confinement, user: int | None) -> NoReturn:
    """Wait for ever, because all other processes of the namespace end with this one."""
    try:
        _close_all_but([])
        confinement.enter_as_init(user)
        while True:
            signal.pause()
    finally:
        os._exit(1)


@dataclass
class ForkedWorker:
    """A worker as the server knows it."""

    process: int
    init: NamespaceInit | None
    slot: int
    folder: str
    over: bool = False


class ForkServer:
    """Forks, watches and ends workers as the grader asks.

    `control` is the socket to the grader, `users` are unprivileged users that workers become in turn, and `folder` has
    the folders of workers without mounts of their own. There is a factory where there are PID namespaces.
    """

    def __init__(
        self,
        control: socket.socket,
        confinement: Confinement,
        users: list[int],
        folder: str,
        factory: NamespaceFactory | None,
    ) -> None:
        self.control, self.confinement, self.users, self.folder = control, confinement, users, folder
        self.factory = factory
        self.watched = 0.0
        self.workers: dict[int, ForkedWorker] = {}
        self.mounts = "mount namespace" in confinement.on
        self.ours = os.open("/proc/self/ns/pid", os.O_RDONLY) if "pid namespace" in confinement.on else None

    def serve(self) -> NoReturn:
        """Fork and end workers until nobody can ask any more."""
        poll = select.poll()
        poll.register(self.control, select.POLLIN)
        while True:
            if poll.poll(_WATCH * 1000 if self.workers else None):
                message, descriptors, _, _ = socket.recv_fds(self.control, MOST_REQUEST, 1)
                if not message:
                    self.leave()
                self.say(self.answer(json.loads(message), descriptors))
            if time.monotonic() - self.watched > _WATCH:
                self.watch()

    def say(self, reply: Mapping[str, Any]) -> None:
        """Send a message to the grader, or end if it no longer exists; a new worker's schedule goes along."""
        worker = self.workers.get(reply.get("forked", 0))
        schedule = schedule_of(worker.process) if worker else None
        descriptors = [] if schedule is None else [schedule]
        try:
            socket.send_fds(self.control, [json.dumps(reply).encode()], descriptors)
        except OSError:
            self.leave()
        for each in descriptors:
            os.close(each)

    def leave(self) -> NoReturn:
        """End, with all workers; where there is a PID namespace, they do so by themselves."""
        if self.ours is None:
            for number in list(self.workers):
                self.end(number)
        os._exit(0)

    def answer(self, request: dict[str, Any], descriptors: list[int]) -> dict[str, Any]:
        """Do what the grader asks, and return what to say about it."""
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
        """Start a worker; OSError where the kernel refuses."""
        taken = {worker.slot for worker in self.workers.values()}
        slot = next(slot for slot in range(len(taken) + 1) if slot not in taken)
        user = self.users[slot % len(self.users)] if self.users else None
        folder = SCRATCH if self.mounts else self.make_folder(number, user)
        init = None
        try:
            if self.factory:
                init = self.factory.new_namespace()
                linux.setns(init.namespace, linux.CLONE_NEWPID)
            process = self.child(lambda: self.work(user, folder, channel), [channel])
        except OSError:
            if init:
                init.kill()
                init.wait(self.sweep)
            raise
        finally:
            if init and self.ours is not None:
                os.close(init.namespace)
                linux.setns(self.ours, linux.CLONE_NEWPID)
        self.workers[number] = ForkedWorker(process, init, slot, folder)

    def make_folder(self, number: int, user: int | None) -> str:
        """Make a worker's folder, where it has no mount of its own."""
        path = f"{self.folder}/{number}"
        os.mkdir(path, 0o700)
        if user is not None:
            os.chown(path, user, user)
        return path

    def child(self, work: Callable[[], object], descriptors: list[int]) -> int:
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
        """Run a worker. It is confined before any code of a student runs."""
        try:
            self.confinement.enter(user, folder)
        except OSError as error:
            os.write(channel, encode(("unsafe", str(error))))
            os._exit(70)
        _new_environment(folder)
        answer_calls(channel, channel, self.confinement.paths)

    def end(self, number: int) -> str:
        """End a worker with all its processes, and say how it ended."""
        worker = self.workers.pop(number)
        with contextlib.suppress(ProcessLookupError):
            os.kill(worker.process, signal.SIGKILL)
        if worker.init:
            worker.init.kill()
        else:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(worker.process, signal.SIGKILL)
        _, status = os.waitpid(worker.process, 0)
        if worker.init:
            worker.init.wait(self.sweep)
        self.sweep()
        if not self.mounts:
            shutil.rmtree(worker.folder, ignore_errors=True)
        if worker.over:
            return TOO_MUCH_MEMORY.format(self.confinement.bounds.memory // 2**20)
        return describe_end(os.waitstatus_to_exitcode(status))

    def sweep(self) -> None:
        """End what workers left to the server: orphans, and children that were made in its name."""
        # The first process of a worker's namespace is left to the server if the factory has ended. It cannot end before
        # its worker is waited for, so waiting for it here would never end.
        known = {worker.process for worker in self.workers.values()}
        known |= {worker.init.process for worker in self.workers.values() if worker.init}
        if self.factory:
            known.add(self.factory.process)
        while strays := [child for child in _children(os.getpid()) if child not in known]:
            for stray in strays:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(stray, signal.SIGKILL)
                os.waitpid(stray, 0)

    def watch(self) -> None:
        """End workers whose processes together hold too much memory, and let their further processes come last."""
        self.watched = time.monotonic()
        if self.ours is None:
            return
        parents, own = dict(_processes()), _held("self")
        for worker in self.workers.values():
            roots = {worker.process, worker.init.process if worker.init else None}
            family = [each for each in parents if _descends(each, roots, parents)]
            # Else a worker's own processes would keep it and its neighbours waiting for a processor
            for each in set(family) - roots:
                with contextlib.suppress(OSError):
                    os.setpriority(os.PRIO_PROCESS, each, _LAST)
            held = sum(max(_held(str(each)) - own, 0) for each in family)
            if worker.init and not worker.over and held > self.confinement.bounds.memory + _ABOVE:
                worker.over = True
                worker.init.kill()


def _close_all_but(descriptors: list[int]) -> None:
    start = 3
    for each in sorted(descriptors):
        os.closerange(start, each)
        start = each + 1
    os.closerange(start, 2**16)


def _new_environment(folder: str) -> None:
    os.environ.clear()
    os.environ.update(OF_A_WORKER)
    os.environ.update(dict.fromkeys(("HOME", "TMPDIR", "MPLCONFIGDIR"), folder), PATH=os.defpath)
    tempfile.tempdir = None


def _children(process: int) -> list[int]:
    return [child for child, parent in _processes() if parent == process]


def _processes() -> Iterator[tuple[int, int]]:
    """Return every visible process with its parent."""
    for name in os.listdir("/proc"):
        if name.isdigit():
            with contextlib.suppress(OSError), open(f"/proc/{name}/stat", "rb") as file:
                yield int(name), int(file.read().rpartition(b")")[2].split()[1])


def _descends(process: int, roots: set[int | None], parents: Mapping[int, int]) -> bool:
    """Return True if a process is one of the given ones or a descendant of one."""
    while process in parents:
        if process in roots:
            return True
        process = parents[process]
    return False


def _held(process: str) -> int:
    """Return the bytes of memory that a process holds, without files; 0 if it has just ended."""
    held = 0
    with contextlib.suppress(OSError), open(f"/proc/{process}/status", "rb") as file:
        for line in file:
            if line.startswith((b"RssAnon:", b"RssShmem:", b"VmSwap:")):
                held += int(line.split()[1]) * 1024
    return held


def students_modules() -> Iterator[str]:
    """Return the names of all modules of this package that a student's code may import."""
    for found in pkgutil.iter_modules(nao_course.__path__, "nao_course."):
        if found.name.rpartition(".")[2] not in INSTRUCTORS:
            yield found.name
            if found.ispkg:
                path = importlib.import_module(found.name).__path__
                yield from (each.name for each in pkgutil.walk_packages(path, f"{found.name}."))


def _warm_up(names: Iterable[str]) -> None:
    """Import modules, with one thread, and prepare what nearly every worker needs."""
    for name in names:
        importlib.import_module(name)
    if "cv2" in sys.modules:
        sys.modules["cv2"].setNumThreads(1)
        read_all_outlines()
        prepare_seeds()
    if len(os.listdir("/proc/self/task")) > 1:
        raise OSError("a library has started threads: no process may be forked")
    gc.collect()
    gc.freeze()
    # A fork copies the table of pages, and the worker's end clears it away: with few large pages both cost less.
    linux.use_large_pages()


def _serve(control: socket.socket, told: Mapping[str, Any], users: list[int]) -> NoReturn:
    try:
        linux.die_with_parent(signal.SIGKILL)
        linux.adopt_orphans()
        on = frozenset(told["on"])
        paths = tuple(readable())
        program = seccomp_program(on) if "seccomp" in on else b""
        confinement = Confinement(on, paths, program, Bounds(**told["bounds"]))
        factory = NamespaceFactory(confinement, users) if "pid namespace" in on else None
        _warm_up((*_LIBRARIES, *students_modules()) if told["warm"] else ())
        if "mount namespace" in on:
            narrow_view(paths)
        server = ForkServer(control, confinement, users, told["folder"], factory)
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
        users = enter_namespaces(told["on"])
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
