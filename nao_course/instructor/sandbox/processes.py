"""The processes that workers run in, and how each is started and ended."""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path

from nao_course.instructor.sandbox.layers import SandboxError
from nao_course.instructor.sandbox.protocol import (
    LIMITED,
    Channel,
    ServerEnded,
    describe_end,
    schedule_of,
    scrubbed_environment,
)
from nao_course.instructor.sandbox.warm_server import Fork, WarmServer

_KEPT = ("SYSTEMROOT", "TEMP", "TMP", "TMPDIR", "NAO_COURSE_DATA")  # of the environment


def start_process(server: WarmServer | None, folder: Path) -> Channel:
    """Start a worker's process: a confined one of a server, or without a server one for trusted code.

    A process for trusted code works in `folder`; the others have a folder of their own. Raise a SandboxError or
    ServerEnded as `WarmServer.fork` does.
    """
    if server is None:
        return _OwnProcess(folder)
    if server.forks:
        return _ForkedProcess(server, server.fork())
    return _LimitedProcess()


def wait_until_ready(channel: Channel) -> None:
    """Wait until a worker's process is ready; raise a SandboxError if it is not confined, and Ended if it is silent."""
    match channel.receive():
        case "ready":
            pass
        case ("unsafe", str(reason)):
            raise SandboxError(f"a worker could not be confined: {reason}")
        case _:
            channel.give_up()


class _OwnProcess(Channel):
    """A new Python and the pipes to it."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "nao_course.instructor.sandbox.worker_process", *arguments],
            bufsize=0,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            cwd=folder,
            env=scrubbed_environment(*_KEPT),
            start_new_session=True,
            creationflags=getattr(subprocess, "CREATE_NEW_PROCESS_GROUP", 0),
        )
        assert self.process.stdin and self.process.stdout  # pipes, as asked for
        super().__init__(
            self.process.stdin.fileno(), self.process.stdout.fileno(), schedule_of(self.process.pid)
        )

    def how_it_ended(self) -> str:
        """End a process that closed its channel, and describe how it ended."""
        self.kill()
        return describe_end(self.process.returncode)

    def kill(self) -> None:
        """End the process and its group. The group's number is its own until the process has been waited for."""
        if self.process.returncode is None:
            if sys.platform == "win32":
                subprocess.run(["taskkill", "/F", "/T", "/PID", str(self.process.pid)], capture_output=True)
            else:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(self.process.pid, signal.SIGKILL)
        with self.process:  # closes the pipes and waits
            pass
        super().kill()


class _LimitedProcess(_OwnProcess):
    """A new Python with limits in a folder that is thrown away: what there is where no worker can be forked."""

    def __init__(self) -> None:
        self.folder = tempfile.mkdtemp(prefix="nao-course-")
        super().__init__(Path(self.folder), LIMITED)

    def kill(self) -> None:
        """End the process and its group, and take its folder away."""
        super().kill()
        shutil.rmtree(self.folder, ignore_errors=True)


class _ForkedProcess(Channel):
    """A worker of a warm server."""

    def __init__(self, server: WarmServer, fork: Fork) -> None:
        super().__init__(fork.socket.fileno(), fork.socket.fileno(), fork.schedule)
        self.server, self.fork, self.ended = server, fork, ""

    def how_it_ended(self) -> str:
        """End a process that closed its channel, and describe how it ended."""
        self.ended = self.ended or self.server.end(self.fork)
        return self.ended

    def kill(self) -> None:
        """End the process and its whole namespace."""
        super().kill()
        with contextlib.suppress(ServerEnded):  # and its workers with it
            self.how_it_ended()
