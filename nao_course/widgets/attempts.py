"""A student's code at arm's length: it is given a time, what it raises becomes a sentence, what it prints is kept."""

from __future__ import annotations

import contextlib
import ctypes
import io
import sys
import sysconfig
import threading
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Generic, TextIO, TypeVar

TIME_LIMIT = 10.0  # s for one call of a student's code before it is given up
KEPT_LETTERS = 1000  # of what it prints, the last ones
_LIBRARIES = (
    str(Path(__file__).parents[1]),
    *{sysconfig.get_path(name) for name in ("purelib", "platlib", "stdlib")},
)


Value = TypeVar("Value")


@dataclass(frozen=True)
class Attempt(Generic[Value]):
    """What came of one call of a student's code.

    Parameters
    ----------
    value : object
        What it returned; None if it did not come to its end.
    message : str
        Why it did not, in a sentence; empty if it did.
    error : BaseException or None
        What it raised.
    unfinished : bool
        Whether that was its NotImplementedError: an exercise that is not written yet.
    printed : str
        The end of what it printed.
    seconds : float
        How long it took.
    """

    value: Value | None = None
    message: str = ""
    error: BaseException | None = None
    unfinished: bool = False
    printed: str = ""
    seconds: float = 0.0

    @property
    def done(self) -> bool:
        """Whether it came to its end."""
        return not self.message


def attempt(
    call: Callable[[], Value],
    what: str,
    *,
    limit: float = TIME_LIMIT,
    unfinished: str | None = None,
    quiet: bool = False,
) -> Attempt[Value]:
    """Call a student's code: whatever it does, except for being interrupted, nothing is raised.

    Every panel asks a student's functions through this.

    Parameters
    ----------
    call : callable
        Takes nothing; looks at what comes back, too, and raises ValueError or TypeError where that cannot be used.
    what : str
        Whose code it is, for messages: "your filter", "move()".
    limit : float
        Seconds until it is stopped.
    unfinished : str, optional
        The message for a NotImplementedError; by default that is an error like any other.
    quiet : bool
        Whether what it prints is only kept, and shown nowhere else.

    Returns
    -------
    Attempt
        What it returned or what went wrong, what it printed, and how long it took.
    """
    printed = PrintedCopy(sys.stdout, quiet)
    value: Value | None = None
    message, error = "", None
    began = time.perf_counter()
    try:
        with contextlib.redirect_stdout(printed), time_limit(limit):
            value = call()
    except (Exception, SystemExit, TooSlow) as caught:  # noqa: BLE001 - its mistake is a message, never a dead panel
        error = caught
    took = time.perf_counter() - began
    unwritten = unfinished is not None and isinstance(error, NotImplementedError)
    if unfinished is not None and unwritten:
        message = unfinished
    elif error is not None:
        message = complaint(what, error) if not isinstance(error, TooSlow) else _too_slow(what, error, limit)
    return Attempt(value, message, error, unwritten, printed.text, took)


def _too_slow(what: str, error: TooSlow, limit: float) -> str:
    line = _line_of(error)
    return (
        f"Time is up: {what} was not done after {limit:g} s and was stopped in line {line}. Does a loop end?"
    )


class PrintedCopy(io.TextIOBase):
    """Keeps the end of what its thread prints: a button's or a slider's prints have no cell to appear under.

    Parameters
    ----------
    out : text stream
        Where else it goes, and what other threads print meanwhile.
    quiet : bool
        Whether what its own thread prints is only kept.
    """

    def __init__(self, out: TextIO, quiet: bool = False) -> None:
        """Begin with nothing."""
        self._out, self._quiet, self._thread = out, quiet, threading.get_ident()
        self.text = ""

    def write(self, text: str) -> int:
        """Take some text."""
        if threading.get_ident() == self._thread:
            self.text = (self.text + text)[-KEPT_LETTERS:]
            if self._quiet:
                return len(text)
        return self._out.write(text)

    def flush(self) -> None:
        """Pass on that it should appear."""
        self._out.flush()


class TooSlow(BaseException):
    """Raised into a student's code whose time is up; no `except Exception` of theirs stops it."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TooSlow in the block after a time, in whichever thread it runs.

    Sliders and buttons are served by a thread of the kernel that "Interrupt the kernel" does not reach, so an
    endless loop there could only be ended with the kernel. One call into C ends before it is stopped.
    """
    thread, lock, over = ctypes.c_ulong(threading.get_ident()), threading.Lock(), False

    def ring() -> None:
        with lock:
            if not over:
                ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, ctypes.py_object(TooSlow))

    timer = threading.Timer(seconds, ring)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        with lock:
            over = True
            ctypes.pythonapi.PyThreadState_SetAsyncExc(thread, None)  # if it rang just now, it rings no more
        timer.cancel()


def complaint(what: str, error: BaseException) -> str:
    """Return a sentence of at most 200 letters: which error, where in the student's code, and its message."""
    text = " ".join(str(error).split())
    text = text if len(text) <= 200 else f"{text[:199]}…"
    return f"{type(error).__name__} in {what}, line {_line_of(error)}: {text}"


def _line_of(error: BaseException) -> int | None:
    """Line of the student's code an exception came through last; of any code, if it met none of theirs."""
    frames = traceback.extract_tb(error.__traceback__)
    theirs = [frame for frame in frames if not frame.filename.startswith(_LIBRARIES)]
    return (theirs or frames)[-1].lineno
