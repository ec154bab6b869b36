"""Time limits for code in any thread and on any system, which do not interrupt an import."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import sys
import threading
import time
from _thread import start_new_thread
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
    watch = _Watch(threading.get_ident(), seconds, sooner, error)
    with _signals(watch):
        try:
            _WATCHDOG.add(watch)
            yield
        finally:
            watch.over = True  # first of all, because the cleaning up must not be interrupted
            try:  # noqa: SIM105 - it would arrive in `suppress` before that suppresses anything
                _let_pass()
            except watch.error:
                pass
            _WATCHDOG.remove(watch)


def _let_pass() -> None:
    """Receive an interruption that was requested just before: it arrives where a function begins."""


@contextmanager
def _signals(watch: _Watch) -> Iterator[None]:
    """Let a time limit interrupt by signals too, if there are any and nobody else waits for one."""
    is_main = threading.current_thread() is threading.main_thread()
    if not (is_main and hasattr(signal, "setitimer")) or any(signal.getitimer(signal.ITIMER_REAL)):
        yield
        return

    def interrupt(_: int, frame: FrameType | None) -> None:
        if watch.may_interrupt(frame):
            raise watch.error

    before = signal.signal(signal.SIGALRM, interrupt)
    watch.has_signals = True
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


class _Watch:
    """One time limit: it interrupts a thread until it is over, but never in this module's own frames, which clean up.

    `due` is the time of the next step.
    """

    def __init__(
        self,
        thread: int,
        seconds: float,
        sooner: Callable[[FrameType], bool] | None,
        error: type[BaseException],
    ) -> None:
        self.thread, self.over, self.has_signals = ctypes.c_ulong(thread), False, False
        self.error = error
        self._end, self._sooner = time.monotonic() + seconds, sooner
        self._last_import, self._interruptions = self._end + IMPORTING, 0
        self.due = self._next_look()

    def step(self) -> None:
        """Interrupt the thread if its time is up."""
        frame = self._frame()
        if not self._interruptions:
            self.due = self._next_look()
            if time.monotonic() < self._end and not (self._sooner and frame and self._sooner(frame)):
                return
            self._last_import = time.monotonic() + IMPORTING
        self._interrupt()
        self._interruptions += 1
        if self._interruptions == _BEFORE_SIGNALS and self.has_signals:
            signal.setitimer(signal.ITIMER_REAL, *_SIGNALS)
        self.due = time.monotonic() + _PAUSE

    def may_interrupt(self, frame: FrameType | None) -> bool:
        """Return whether the thread may be interrupted in this frame."""
        if frame is None or self.over or frame.f_code.co_filename in _OWN_FRAMES:
            return False
        return not importing(frame) or time.monotonic() >= self._last_import

    def _next_look(self) -> float:
        return min(self._end, time.monotonic() + _POLL) if self._sooner else self._end

    def _interrupt(self) -> None:
        """Request the error in the thread, if it is in a frame where it may be interrupted.

        The watchdog holds the interpreter from the inspection of the frame to the request, so the error arrives there.
        """
        if self.may_interrupt(self._frame()):
            ctypes.pythonapi.PyThreadState_SetAsyncExc(self.thread, ctypes.py_object(self.error))

    def _frame(self) -> FrameType | None:
        return sys._current_frames().get(int(self.thread.value))


class _Watchdog:
    """The thread that keeps all time limits of the process, because starting one for each would take a panel too long.

    Only locks are used: an interruption in the middle of a method of `threading` could leave its lock closed for ever.
    """

    def __init__(self) -> None:
        self.start_again()
        if hasattr(os, "register_at_fork"):
            os.register_at_fork(after_in_child=self.start_again)  # a child of a fork has none of the threads

    def start_again(self) -> None:
        """Forget all time limits and the thread."""
        self._lock, self._asleep = threading.Lock(), threading.Lock()
        self._watches: list[_Watch] = []
        self._runs = False
        self._wakes = 0.0  # time at which the thread will look again
        self._asleep.acquire()

    def add(self, watch: _Watch) -> None:
        """Begin to keep a time limit."""
        with self._lock:
            self._watches.append(watch)
            if not self._runs:
                self._runs = True
                start_new_thread(self._run, ())
            elif watch.due < self._wakes and self._asleep.locked():
                self._asleep.release()

    def remove(self, watch: _Watch) -> None:
        """Forget a time limit; afterwards it interrupts nothing."""
        with self._lock:
            if watch in self._watches:  # the child of a fork does not know its parent's
                self._watches.remove(watch)

    def _run(self) -> None:
        while True:
            with self._lock:
                for watch in self._watches:
                    if watch.due <= time.monotonic():
                        with contextlib.suppress(Exception):  # an error of `sooner` ends no time limit
                            watch.step()
                self._wakes = min((watch.due for watch in self._watches), default=float("inf"))
            left = max(self._wakes - time.monotonic(), 0.0)
            self._asleep.acquire(timeout=min(left, threading.TIMEOUT_MAX))


_WATCHDOG = _Watchdog()
