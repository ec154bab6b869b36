"""A student's code at arm's length: what it raises becomes a sentence, what it prints is kept."""

from __future__ import annotations

import ctypes
import io
import sysconfig
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TextIO

KEPT_LETTERS = 1000
_LIBRARIES = (
    str(Path(__file__).parents[1]),
    *{sysconfig.get_path(name) for name in ("purelib", "platlib", "stdlib")},
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
