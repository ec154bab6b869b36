"""A student's code at arm's length: what it raises becomes a sentence, what it prints is kept."""

from __future__ import annotations

import io
import signal
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
    """Keeps the end of what is printed, and passes it on where there is a place for it.

    Parameters
    ----------
    out : text stream, optional
        Where else it goes: a button's or a slider's prints have no cell to appear under.
    """

    def __init__(self, out: TextIO | None = None) -> None:
        """Begin with nothing."""
        self._out = out
        self.text = ""

    def write(self, text: str) -> int:
        """Take some text."""
        self.text = (self.text + text)[-KEPT_LETTERS:]
        return len(text) if self._out is None else self._out.write(text)

    def flush(self) -> None:
        """Pass on that it should appear."""
        if self._out is not None:
            self._out.flush()


@contextmanager
def interruptible() -> Iterator[None]:
    """Let "Interrupt the kernel" reach a student's code: while no cell runs, a kernel ignores it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN if before is None else before)


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
