"""Stops code that runs too long: in any thread, on any system, and not in the middle of an import."""

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

IMPORTING = 20.0  # seconds for which it is waited until an import has ended
_OWN_FRAMES = (__file__, contextlib.__file__)
_PAUSE = 0.01  # s between two rings
_GLANCE = 0.25  # s between two looks at what runs
_DEAF = 10  # rings after which it rings by signals, too
_ALARM = (
    1e-3,
    2.3e-4,
)  # s until the first of them, and between two: so many that one meets the code outside of a try


class TooSlow(BaseException):
    """Raised into a student's code whose time is up; no `except Exception` of theirs stops it."""


def importing(frame: FrameType | None) -> bool:
    """Whether a frame runs while a module is being imported."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


@contextmanager
def time_limit(
    seconds: float,
    *,
    sooner: Callable[[FrameType], bool] | None = None,
    error: type[BaseException] = TooSlow,
) -> Iterator[None]:
    """Raise an error in the block after a time, in whichever thread it runs.

    Sliders and buttons are served by a thread of the kernel that "Interrupt the kernel" does not reach, so an
    endless loop there could only be ended with the kernel. A loop whose `except:` takes everything is told again and
    again, until it hears it outside of its `try`. In the main thread, where there is an alarm clock (not on Windows),
    a call that waits is interrupted, too. A call into C that calculates comes to its end first; elsewhere so does one
    that waits, and a loop that takes everything around such calls hears it never. In the middle of an import it waits
    for at most IMPORTING seconds: a compiled module that is begun and not ended can never be imported again.

    Parameters
    ----------
    seconds : float
        Wall clock.
    sooner : callable, optional
        Asked four times a second with the frame that runs in the block: whether its time is up already.
    error : type of BaseException
        What is raised.
    """
    bell = _Bell(threading.get_ident(), seconds, sooner, error)
    with _alarm_clock(bell):
        bell.start()
        try:
            yield
        finally:
            bell.over = True  # before anything that it could ring in
            bell.wake.set()
            bell.join()
            ctypes.pythonapi.PyThreadState_SetAsyncExc(
                bell.thread, None
            )  # if it rang just now, it rings no more


@contextmanager
def _alarm_clock(bell: _Bell) -> Iterator[None]:
    """Let a bell ring by signals, too, where there are any, and nobody else waits for one."""
    is_main = threading.current_thread() is threading.main_thread()
    if not (is_main and hasattr(signal, "setitimer")) or any(signal.getitimer(signal.ITIMER_REAL)):
        yield
        return

    def ring(_: int, frame: FrameType | None) -> None:
        if bell.may_ring(frame):
            raise bell.error

    before = signal.signal(signal.SIGALRM, ring)
    bell.has_clock = True
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


class _Bell(threading.Thread):
    """Rings in a thread from a time on, until it is over; never in this module's own frames, which clean up."""

    def __init__(
        self,
        thread: int,
        seconds: float,
        sooner: Callable[[FrameType], bool] | None,
        error: type[BaseException],
    ) -> None:
        super().__init__(daemon=True)
        self.thread, self.over, self.wake = ctypes.c_ulong(thread), False, threading.Event()
        self.has_clock = False  # whether signals arrive
        self.error = error
        self._end, self._sooner = time.monotonic() + seconds, sooner
        self._last = self._end + IMPORTING

    def run(self) -> None:
        self._wait()
        self._last = time.monotonic() + IMPORTING
        rings = 0
        while not self.over:
            self._ring()
            rings += 1
            if rings == _DEAF and self.has_clock:
                signal.setitimer(signal.ITIMER_REAL, *_ALARM)
            self.wake.wait(_PAUSE)

    def may_ring(self, frame: FrameType | None) -> bool:
        """Whether this is a frame to ring in."""
        if frame is None or self.over or frame.f_code.co_filename in _OWN_FRAMES:
            return False
        return not importing(frame) or time.monotonic() >= self._last

    def _wait(self) -> None:
        """Wait until the time is up."""
        while (left := self._end - time.monotonic()) > 0 and not self.over:
            self.wake.wait(min(left, _GLANCE) if self._sooner else min(left, threading.TIMEOUT_MAX))
            frame = self._frame()
            if self._sooner and frame is not None and self._sooner(frame):
                return

    def _ring(self) -> None:
        """Ask where the thread is and ring there: nothing else runs in between, and it hears it where it was seen."""
        if self.may_ring(self._frame()):
            ctypes.pythonapi.PyThreadState_SetAsyncExc(self.thread, ctypes.py_object(self.error))

    def _frame(self) -> FrameType | None:
        return sys._current_frames().get(int(self.thread.value))
