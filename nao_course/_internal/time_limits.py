"""Time limits for code in any thread and on any system, which do not interrupt an import."""

from __future__ import annotations

import contextlib
import ctypes
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

__all__ = ["IMPORTING", "TooSlow", "importing", "time_limit"]

IMPORTING = 20.0  # s: the longest time that an import may delay the interruption
_OWN_FRAMES = (__file__, contextlib.__file__)
_PAUSE = 0.01  # s between two interruptions: code that catches one needs time to leave its handler
_POLL = 0.25  # s between two calls of `sooner`
# Interruptions by exception reach a thread only between two bytecodes, so a thread that waits inside a C call never
# sees them. After this many of them, signals are sent as well, which also interrupt waiting calls.
_BEFORE_SIGNALS = 10
# s until the first signal, and between two. They come so densely that one of them meets a loop like
# `while True: try: ... except BaseException: pass` outside its try block.
_SIGNALS = (1e-3, 2.3e-4)


class TooSlow(BaseException):
    """Raised inside code whose time is up. It is no Exception, so that `except Exception` does not catch it."""


def importing(frame: FrameType | None) -> bool:
    """Return whether a frame runs while a module is being imported."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


@contextmanager
def time_limit(
    seconds: float, *, sooner: Callable[[FrameType], bool] | None = None, error: type[BaseException] = TooSlow
) -> Iterator[None]:
    """Raise an error inside the block once its time is up, in whichever thread it runs.

    Sliders and buttons are served by a thread of the kernel that "Interrupt the kernel" does not reach. Without a time
    limit, an endless loop in a student's function would freeze the panel until the kernel is restarted.

    The error is raised again and again until it arrives outside the `try` of a loop that catches everything. In the
    main thread, on systems that have signals (not on Windows), a call that waits is interrupted as well. Anything else
    in C runs to its end first: a long calculation, and in other threads a call that waits. An import is not interrupted
    for up to IMPORTING seconds, because a compiled module whose import was broken off cannot be imported again.
    `seconds` are wall-clock time. `sooner` is called four times a second with the frame that runs in the block; if it
    returns True, the time is up already.
    """
    watchdog = _Watchdog(threading.get_ident(), seconds, sooner, error)
    with _signals(watchdog):
        watchdog.start()
        try:
            yield
        finally:
            watchdog.over = True  # first of all, because the cleaning up must not be interrupted
            watchdog.wake.set()
            watchdog.join()
            # An interruption that was requested just before, and has not arrived, is taken back.
            ctypes.pythonapi.PyThreadState_SetAsyncExc(watchdog.thread, None)


@contextmanager
def _signals(watchdog: _Watchdog) -> Iterator[None]:
    """Let a watchdog interrupt by signals too, if there are any and nobody else waits for one."""
    is_main = threading.current_thread() is threading.main_thread()
    if not (is_main and hasattr(signal, "setitimer")) or any(signal.getitimer(signal.ITIMER_REAL)):
        yield
        return

    def interrupt(_: int, frame: FrameType | None) -> None:
        if watchdog.may_interrupt(frame):
            raise watchdog.error

    before = signal.signal(signal.SIGALRM, interrupt)
    watchdog.has_signals = True
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


class _Watchdog(threading.Thread):
    """Interrupts a thread from a time on until it is over, but never in this module's own frames, which clean up."""

    def __init__(
        self,
        thread: int,
        seconds: float,
        sooner: Callable[[FrameType], bool] | None,
        error: type[BaseException],
    ) -> None:
        super().__init__(daemon=True)
        self.thread, self.over, self.wake = ctypes.c_ulong(thread), False, threading.Event()
        self.has_signals = False
        self.error = error
        self._end, self._sooner = time.monotonic() + seconds, sooner
        self._last_import = self._end + IMPORTING

    def run(self) -> None:
        self._wait()
        self._last_import = time.monotonic() + IMPORTING
        interruptions = 0
        while not self.over:
            self._interrupt()
            interruptions += 1
            if interruptions == _BEFORE_SIGNALS and self.has_signals:
                signal.setitimer(signal.ITIMER_REAL, *_SIGNALS)
            self.wake.wait(_PAUSE)

    def may_interrupt(self, frame: FrameType | None) -> bool:
        """Return whether the thread may be interrupted in this frame."""
        if frame is None or self.over or frame.f_code.co_filename in _OWN_FRAMES:
            return False
        return not importing(frame) or time.monotonic() >= self._last_import

    def _wait(self) -> None:
        """Wait until the time is up."""
        while (left := self._end - time.monotonic()) > 0 and not self.over:
            self.wake.wait(min(left, _POLL) if self._sooner else min(left, threading.TIMEOUT_MAX))
            frame = self._frame()
            if self._sooner and frame is not None and self._sooner(frame):
                return

    def _interrupt(self) -> None:
        """Request the error in the thread, if it is in a frame where it may be interrupted.

        This thread holds the interpreter from the inspection of the frame to the request, so the error arrives there.
        """
        if self.may_interrupt(self._frame()):
            ctypes.pythonapi.PyThreadState_SetAsyncExc(self.thread, ctypes.py_object(self.error))

    def _frame(self) -> FrameType | None:
        return sys._current_frames().get(int(self.thread.value))
