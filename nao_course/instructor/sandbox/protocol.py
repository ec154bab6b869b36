"""What the grader and a student's process both speak: frames of the codec over pipes or a socket, read with a deadline.

The worker gets the notebook and the inputs of calls, but never the expected answers. What it answers is read as a
stranger's.
"""

from __future__ import annotations

import contextlib
import math
import os
import select
import signal
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NoReturn

from nao_course._internal.single_threaded import SINGLE_THREADED
from nao_course.codec import PREFIX_SIZE, CodecError, Limits, decode, frame_lengths
from nao_course.exercises.running import Outcome, Status

REPLY = Limits(size=32 * 2**20, header=4 * 2**20)  # a picture of 1280 x 960 in float64 has 28 MB
MOST_OUTPUT = 8 * 2**10  # bytes of what a call prints that are kept
MOST_NOTES = 20  # reports of denied attempts from a worker
LONGEST_REASON = 500  # characters: why a notebook cannot be loaded
MOST_REQUEST = 2**16  # bytes of a message to or from the warm server
UNREADABLE = "its answer could not be read"
LIMITED = "--limited"  # argument of a worker's process that sets limits for itself
SECONDS_TO_START = 60.0  # Python and numpy, on a machine that is busy
# What each has in its environment, on every machine: the order of a set of strings and what is printed depend on it
OF_A_WORKER = {
    "MPLBACKEND": "Agg",
    "PYTHONHASHSEED": "0",
    "PYTHONUTF8": "1",
    "TZ": "UTC",
    "LANG": "C.UTF-8",
    "LC_ALL": "C.UTF-8",
    **SINGLE_THREADED,
}
SECONDS_IN_ALL = 120.0  # for one submission's own code, all tries and processes together
USED_UP = "the time that it may take is used up"
MOST_WAITING = 9  # times the limit of a call: so long may its worker wait for a processor without losing time
_RESOLUTION = 1e-3  # s
_MOST_OVERDUE = (
    1000  # parts of an answer that are read after the deadline, of 64 kB; an answer has at most half of them
)
_KEPT = ("PYTHONPATH", "PATH", "LD_LIBRARY_PATH")


@dataclass(frozen=True)
class EarlierNotebook:
    """A notebook of an earlier lesson, such as "01_hsl_filtering", that a later one uses, with its helpers by name.

    `setup` is the source of that lesson's released set-up cell.
    """

    lesson: str
    content: bytes
    helpers: Mapping[str, bytes] = field(default_factory=dict)
    setup: str = ""


def printable(text: str) -> str:
    """Return the beginning of an untrusted text, without control characters."""
    return "".join(each if each.isprintable() else " " for each in text[:LONGEST_REASON])


def scrubbed_environment(*names: str) -> dict[str, str]:
    """Return the part of this process's environment that a new process needs, and some names."""
    kept = {name: os.environ[name] for name in (*_KEPT, *names) if name in os.environ}
    return kept | OF_A_WORKER


class ServerEnded(RuntimeError):  # noqa: N818 - no error of the submission: it has to be graded again
    """The warm server died while a submission was being graded; nothing was found out about the submission."""


class Ended(Exception):  # noqa: N818 - no error: students' processes end
    """A worker gave no answer that can be used.

    The status is "timed out", "died", or "not found" without a notebook to load; the text says how it ended.
    """

    def __init__(self, status: Status, text: str) -> None:
        super().__init__(text)
        self.outcome = Outcome(status, text=text)


@dataclass
class Allowance:
    """Time that the code of one purpose may take, in seconds.

    When its own time is used up, it uses the common one, which it shares with others; `reason` is the outcome's text
    when all is used up. `spent` is the part of its own time that is used, and `total` all time that is used.
    """

    seconds: float = SECONDS_IN_ALL
    common: Allowance | None = None
    reason: str = USED_UP
    spent: float = 0.0
    total: float = 0.0

    def left(self, most: float = math.inf) -> float:
        """Return the seconds that may still be used, at most the given number; raise Ended if there are none."""
        left = self.seconds - self.spent
        if self.common:
            left += self.common.seconds - self.common.spent
        if left <= 0:
            raise Ended("timed out", self.reason)
        return min(most, left)

    def spend(self, seconds: float) -> None:
        """Take time from its own, and what its own does not suffice for from the common time."""
        self.total += seconds
        own = min(seconds, max(self.seconds - self.spent, 0.0)) if self.common else seconds
        self.spent += own
        if self.common:
            self.common.spend(seconds - own)


class Channel:
    """Channel to a worker. No operation blocks past the deadline, even if student code controls the other end.

    Its clock counts the time in which the worker runs or sleeps. Where the kernel says how long a process has waited
    for a processor (Linux), that time is not counted, so that a busy machine takes no time from a student's code. It is
    counted from MOST_WAITING times the limit on, because no worker may last for ever. `requests` and `replies` are
    descriptors to write to and to read from; `schedule`, of the process's file "schedstat", is closed with the channel.
    """

    def __init__(self, requests: int, replies: int, schedule: int | None = None) -> None:
        self.requests, self.replies, self.schedule = requests, replies, schedule
        self.size, self.overdue = 0, 0
        self.unread = bytearray()  # what has come besides the frame that was asked for
        self.waited = 0.0  # for a processor, s
        if sys.platform != "win32":
            os.set_blocking(self.requests, False)
        self.start_clock(SECONDS_TO_START)

    def start_clock(self, seconds: float) -> None:
        """Begin to count the time of a request, which has some seconds."""
        self.waited_since()
        self.seconds, self.began, self.free = seconds, time.monotonic(), MOST_WAITING * seconds
        self.deadline, self.overdue = self.began + seconds, 0

    def used(self) -> float:
        """Return the time since the clock was started, without time that was excluded."""
        waited = min(self.waited_since(), self.free)
        self.free -= waited
        self.exclude(waited)
        return max(time.monotonic() - self.began, 0.0)  # it may have waited before, too

    def exclude(self, seconds: float) -> None:
        """Leave time out that is not the worker's."""
        self.began += seconds
        self.deadline += seconds

    def waited_since(self) -> float:
        """Return how long the worker has waited for a processor since this was called before."""
        before = self.waited
        if self.schedule is not None:
            with contextlib.suppress(OSError, IndexError):  # it has ended
                self.waited = int(os.pread(self.schedule, 100, 0).split()[1]) * 1e-9
        return max(self.waited - before, 0.0)

    def ask(self, frame: bytes | bytearray, seconds: float) -> None:
        """Send a request whose answers must be here within some seconds."""
        self.start_clock(seconds)
        self.send(frame)

    def send(self, frame: bytes | bytearray) -> None:
        """Send a frame within the time that is left."""
        rest = memoryview(frame)
        while rest:
            try:
                rest = rest[os.write(self.requests, rest) :]
            except BlockingIOError:
                self.wait(self.requests, "write")
            except OSError:  # it reads no more
                raise Ended("died", self.how_it_ended()) from None

    def receive(self) -> Any:
        """Return what the worker says next."""
        try:
            self.read(PREFIX_SIZE)
            length = sum(frame_lengths(self.unread[:PREFIX_SIZE], REPLY))
            self.size += length
            self.read(PREFIX_SIZE + length)
            frame = self.unread[: PREFIX_SIZE + length]
            del self.unread[: PREFIX_SIZE + length]
            return decode(frame, REPLY)
        except CodecError:
            self.give_up()

    def read(self, length: int) -> None:
        """Read until there are that many bytes; they take up memory as they come, not as they are announced."""
        while len(self.unread) < length:
            self.wait(self.replies, "read")
            try:
                part = os.read(self.replies, 2**16)
            except BlockingIOError:
                continue
            except OSError:  # a socket whose other end was closed with something unread
                part = b""
            if not part:
                raise Ended("died", self.how_it_ended())
            self.unread += part

    def wait(self, pipe: int, what: str) -> None:
        """Wait until a pipe can be read or written."""
        while not _ready(pipe, what, max(self.deadline - time.monotonic(), 0.0)):
            if self.used() > self.seconds - _RESOLUTION:
                raise Ended("timed out", f"no answer within {self.seconds:g} s")
        # What is here already may be read even late, because the grader may have been slow; but not for ever.
        if time.monotonic() > self.deadline and self.used() > self.seconds:
            self.overdue += 1
            if self.overdue > _MOST_OVERDUE:
                raise Ended("timed out", f"no end of its answer within {self.seconds:g} s")

    def give_up(self) -> NoReturn:
        """Say that an answer makes no sense."""
        raise Ended("died", UNREADABLE)

    def how_it_ended(self) -> str:
        """End a process that closed its channel, and describe how it ended."""
        raise NotImplementedError

    def kill(self) -> None:
        """End the process and all that it started, and close what belongs to the channel."""
        if self.schedule is not None:
            os.close(self.schedule)
            self.schedule = None


def schedule_of(process: int) -> int | None:
    """Open the file that says how long a process has waited for a processor; None where there is none."""
    with contextlib.suppress(OSError):
        return os.open(f"/proc/{process}/schedstat", os.O_RDONLY | os.O_CLOEXEC)
    return None


_BY_SIGNAL = "the process was ended by signal"
_FROM_OUTSIDE = (1, 2, 9, 15)  # SIGHUP, SIGINT, SIGKILL, SIGTERM


def describe_end(code: int) -> str:
    """Say what became of a process, from the status it ended with."""
    if code < 0:
        return f"{_BY_SIGNAL} {-code} ({signal.strsignal(-code)})"
    return f"the process ended itself with status {code}"


def ended_from_outside(description: str) -> bool:
    """Return True if the described end may have an outside cause, such as the kernel's limit of memory."""
    return description.startswith(tuple(f"{_BY_SIGNAL} {each} " for each in _FROM_OUTSIDE))


def _ready(pipe: int, what: str, seconds: float) -> bool:
    """Return True if a pipe can be read or written within the given seconds."""
    if sys.platform == "win32":
        import _winapi
        import msvcrt

        end = time.monotonic() + seconds
        with contextlib.suppress(OSError):  # closed: reading it says so
            while what == "read" and not _winapi.PeekNamedPipe(msvcrt.get_osfhandle(pipe), 0)[0]:
                if time.monotonic() > end:
                    return False
                time.sleep(0.001)
        return True
    else:
        poll = select.poll()
        poll.register(pipe, select.POLLIN if what == "read" else select.POLLOUT)
        return bool(poll.poll(seconds * 1000))
