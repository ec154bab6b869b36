"""A student's code at arm's length: it is given a time, what it raises becomes a sentence, what it prints is kept."""

from __future__ import annotations

import contextlib
import io
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, TextIO, TypeVar

from nao_course.exercises.case import copied
from nao_course.exercises.running import own_frames
from nao_course.time_limits import TooSlow, time_limit

# s of wall clock for one call of a student's code before it is given up; a busy machine may say more.
TIME_LIMIT = float(os.environ.get("NAO_COURSE_TIME_LIMIT", "10"))
KEPT_LETTERS = 1000  # of what it prints, the last ones

Value = TypeVar("Value")
Words = str | Callable[[], str]  # a function is asked when it is over


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
    what: Words,
    *,
    limit: float = TIME_LIMIT,
    unfinished: Words | None = None,
    quiet: bool = False,
) -> Attempt[Value]:
    """Call a student's code: whatever it does, except for being interrupted, nothing is raised.

    Every panel asks a student's functions through this.

    Parameters
    ----------
    call : callable
        Takes nothing; looks at what comes back, too, and raises ValueError or TypeError where that cannot be used.
    what : str or callable
        Whose code it is, for messages: "your filter", "move()"; a function says so afterwards.
    limit : float
        Seconds until it is stopped.
    unfinished : str or callable, optional
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
        message = _said(unfinished)
    elif error is not None:
        tell = partial(_too_slow, limit=limit) if isinstance(error, TooSlow) else complaint
        message = tell(_said(what), error)
    return Attempt(value, message, error, unwritten, printed.text, took)


class StudentCode(Mapping[str, Callable[..., Any]]):
    """A student's functions, each called with copies of arrays: ``student.paper_distance(pixels, view)``.

    A function that was defined again in the notebook is used from then on.

    Attributes
    ----------
    running, last : str
        Which is being called or did not come to its end; which did, last.
    seconds : float
        Spent in all of them since `begin`.
    """

    def __init__(self, functions: Mapping[str, Callable[..., Any]]) -> None:
        """Refuse what cannot be called."""
        for name, function in functions.items():
            if not callable(function):
                raise ValueError(f"{name} must be a function, got {type(function).__name__}")
        self._functions = dict(functions)
        self.begin()

    def begin(self) -> None:
        """Forget what was called."""
        self.running, self.last, self.seconds = "", "", 0.0

    @property
    def called(self) -> str:
        """The function that failed, else the last that did not, else nothing."""
        return self.running or self.last

    def __getitem__(self, name: str) -> Callable[..., Any]:
        """Return a function."""
        return partial(self._call, name, newest_definition(self._functions[name]))

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return a function."""
        if name.startswith("_") or name not in self._functions:
            raise AttributeError(f"this panel was given no function {name!r}, but {list(self._functions)}")
        return self[name]

    def __iter__(self) -> Iterator[str]:
        """Their names."""
        return iter(self._functions)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._functions)

    def _call(self, name: str, function: Callable[..., Any], *given: Any, **named: Any) -> Any:
        self.running, began = name, time.perf_counter()
        try:
            value = function(*map(copied, given), **{key: copied(each) for key, each in named.items()})
        finally:
            self.seconds += time.perf_counter() - began
        self.running, self.last = "", name
        return value


def newest_definition(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return what a function's name means today where it was defined; the function itself if it has none there."""
    name = getattr(function, "__qualname__", "")
    today = getattr(function, "__globals__", {}).get(name)
    same = callable(today) and getattr(today, "__qualname__", "") == name
    return today if same and today is not None else function


def _said(words: Words) -> str:
    return words if isinstance(words, str) else words()


def _too_slow(what: str, error: BaseException, limit: float) -> str:
    where = f" in line {line}" if (line := _line_of(error)) else ""
    return f"Time is up: {what} was not done after {limit:g} s and was stopped{where}. Does a loop end?"


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


def complaint(what: str, error: BaseException) -> str:
    """Return a sentence of at most 200 letters: which error, where in the student's code, and its message."""
    text = " ".join(str(error).split())
    text = text if len(text) <= 200 else f"{text[:199]}…"
    line, (_, earlier) = _line_of(error), own_frames(error)
    where = f"{what}, line {line}" if line else what
    where += f", inside {earlier}" if earlier else ""
    return f"{type(error).__name__} in {where}: {text}"


def _line_of(error: BaseException) -> int | None:
    """Line of the student's code an exception came through last; None if it met none: a call that does not fit."""
    theirs, _ = own_frames(error)
    return theirs[-1].lineno if theirs else None
