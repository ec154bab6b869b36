"""The grader's end of the warm server: starts it, asks it for sandboxed workers, and starts it again when it dies."""

import json
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, NoReturn, Self

from nao_course.instructor.sandbox.confinement import Bounds
from nao_course.instructor.sandbox.layers import Sandbox, SandboxError
from nao_course.instructor.sandbox.protocol import MOST_REQUEST, ServerEnded, scrubbed_environment

_KEPT = ("HOME", "XDG_CACHE_HOME", "MPLCONFIGDIR")  # of the environment
_SECONDS_TO_START = 90.0  # all those imports, on a machine that is busy
_SECONDS_TO_REPLY = 60.0
_SECONDS_TO_END = 2.0


@dataclass(frozen=True)
class Fork:
    """A worker of a warm server, by its number and the generation of the server, with the grader's end of the channel.

    `schedule` is the descriptor of its process's file "schedstat".
    """

    number: int
    generation: int
    socket: socket.socket
    schedule: int | None = None


@dataclass
class WarmServer:
    """The grader's side of the server: one for all threads, started again when it died.

    A worker that lacks one of the sandbox's layers does not start. A `warm` server imports what lessons use before it
    forks: workers start as fast without, but import it themselves. Trying the sandbox needs none of it.

    ::

        with WarmServer(probe()) as server, Worker(notebook, server=server) as worker:
            outcome = worker.call("white_threshold", Case((120.0,)))
    """

    sandbox: Sandbox
    bounds: Bounds = field(default_factory=Bounds)
    warm: bool = True
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

        Raise a SandboxError if the server or a worker cannot be confined as it was when it was tried, and ServerEnded
        if the server died meanwhile.
        """
        ours, theirs = socket.socketpair()
        with self._lock, theirs:
            try:
                self._running()
                self._forks += 1
                reply, descriptors = self._ask({"fork": self._forks}, theirs)
                if "failed" in reply:
                    raise SandboxError(f"no worker could be forked: {reply['failed']}")
            except BaseException:
                ours.close()
                raise
            return Fork(self._forks, self.generation, ours, next(iter(descriptors), None))

    def end(self, fork: Fork) -> str:
        """End a worker with all its processes, and say how it ended.

        Raise ServerEnded if its server has ended, and the worker with it.
        """
        fork.socket.close()
        with self._lock:
            if fork.generation != self.generation or not self._process:
                raise ServerEnded("the warm server died, and this worker with it")
            return str(self._ask({"end": fork.number})[0].get("ended"))

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
        told = {
            "on": sorted(self.sandbox.on),
            "bounds": asdict(self.bounds),
            "folder": self._folder,
            "warm": self.warm,
        }
        environment = scrubbed_environment(*_KEPT)
        environment["MALLOC_ARENA_MAX"] = "2"  # else each thread takes 64 MB of its address space
        with theirs:
            self._process = subprocess.Popen(
                [
                    sys.executable,
                    "-P",
                    "-m",
                    "nao_course.instructor.sandbox.fork_server",
                    str(theirs.fileno()),
                    json.dumps(told),
                ],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(),),
                cwd="/",
                env=environment,
                start_new_session=True,
            )
        try:
            reply, _ = self._receive(_SECONDS_TO_START)
        except ServerEnded:
            reply = {"failed": "it ended without a word"}
        if "failed" in reply:
            self._stop()
            raise SandboxError(f"the warm server could not start: {reply['failed']}")

    def _ask(
        self, request: Mapping[str, Any], end: socket.socket | None = None
    ) -> tuple[dict[str, Any], list[int]]:
        assert self._control  # the server runs
        try:
            descriptors = [end.fileno()] if end else []
            socket.send_fds(self._control, [json.dumps(request).encode()], descriptors)
        except OSError:
            self._died()
        return self._receive(_SECONDS_TO_REPLY)

    def _receive(self, seconds: float) -> tuple[dict[str, Any], list[int]]:
        """Return the server's next message and the descriptors that come with it."""
        assert self._control  # the server runs
        self._control.settimeout(seconds)
        try:
            message, descriptors, _, _ = socket.recv_fds(self._control, MOST_REQUEST, 1)
        except OSError:  # a time-out, too
            message = b""
        if not message:
            self._died()
        return json.loads(message), descriptors

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
