"""Calls of a student's code: with a time limit, with errors as messages, and with the printed text kept."""

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

from nao_course._internal.time_limits import TooSlow, time_limit
from nao_course.exercises.case import copied
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.exercises.running import own_frames

# s of wall clock for one call of a student's code before it is stopped; a busy machine may set more.
TIME_LIMIT = float(os.environ.get("NAO_COURSE_TIME_LIMIT", "10"))
KEPT_LETTERS = 1000  # last characters of the printed text

Value = TypeVar("Value")
Words = str | Callable[[], str]  # a function is called after the attempt


@dataclass(frozen=True)
class Attempt(Generic[Value]):
    """The outcome of one call of a student's code.

    A failed call has no value, but a message, a sentence, and the exception. `unfinished` means that this is a
    NotImplementedError: the exercise is not written yet. `printed` is the end of the printed text, and `seconds` the
    run time.
    """

    value: Value | None = None
    message: str = ""
    error: BaseException | None = None
    unfinished: bool = False
    printed: str = ""
    seconds: float = 0.0

    @property
    def done(self) -> bool:
        """Whether the call succeeded."""
        return not self.message


def attempt(
    call: Callable[[], Value],
    what: Words,
    *,
    limit: float = TIME_LIMIT,
    unfinished: Words | None = None,
    quiet: bool = False,
) -> Attempt[Value]:
    """Call a student's code and return the outcome; only KeyboardInterrupt is raised.

    Every panel calls the student's functions in this way. `call` also checks the student's result and raises a
    ValueError or TypeError if it is unusable. `what` names the code in messages, such as "your filter", or returns the
    name after the call. The call is stopped after `limit` seconds. Without an `unfinished` message, a
    NotImplementedError is reported like any other error; with `quiet`, the printed text is kept without being shown.
    """
    printed = PrintedCopy(quiet)
    value: Value | None = None
    message, error = "", None
    began = time.perf_counter()
    try:
        with _redirected(printed), time_limit(limit):
            value = call()
    except (Exception, SystemExit, TooSlow) as caught:  # noqa: BLE001 - the student's error must not break the panel
        error = caught
    took = time.perf_counter() - began
    unwritten = unfinished is not None and isinstance(error, NotImplementedError)
    if unfinished is not None and unwritten:
        message = _in_words(unfinished)
    elif error is not None:
        describe = partial(_too_slow, limit=limit) if isinstance(error, TooSlow) else complaint
        message = describe(_in_words(what), error)
    return Attempt(value, message, error, unwritten, printed.text, took)


class StudentCode(Mapping[str, Callable[..., Any]]):
    """A student's functions, each called with copies of arrays: ``student.paper_distance(pixels, view)``.

    If a function is defined again in the notebook, the new definition is used from then on. `running` is the function
    that is running or that failed, `last` the last that succeeded, and `seconds` the total run time since `begin`.
    """

    def __init__(self, functions: Mapping[str, Callable[..., Any]]) -> None:
        """Check that every function is callable."""
        for name, function in functions.items():
            if not callable(function):
                raise ValueError(f"{name} must be a function, got {type(function).__name__}")
        self._functions = dict(functions)
        self.begin()

    def begin(self) -> None:
        """Reset the record of calls and run times."""
        self.running, self.last, self.seconds = "", "", 0.0

    @property
    def called(self) -> str:
        """Name of the function that failed, else of the last that succeeded, else an empty string."""
        return self.running or self.last

    def __getitem__(self, name: str) -> Callable[..., Any]:
        """Return a function."""
        return partial(self._call, name, newest_definition(self._functions[name]))

    def __getattr__(self, name: str) -> Callable[..., Any]:
        """Return a function."""
        if name.startswith("_") or name not in self._functions:
            raise AttributeError(f"this panel has no function {name!r}; it has {list(self._functions)}")
        return self[name]

    def __iter__(self) -> Iterator[str]:
        """Return an iterator over the functions' names."""
        return iter(self._functions)

    def __len__(self) -> int:
        """Return the number of functions."""
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
    """Return the present definition under a function's name in its module, or the function itself if there is none."""
    name = getattr(function, "__qualname__", "")
    today = getattr(function, "__globals__", {}).get(name)
    same = callable(today) and getattr(today, "__qualname__", "") == name
    return today if same and today is not None else function


def _in_words(words: Words) -> str:
    return words if isinstance(words, str) else words()


def _too_slow(what: str, error: BaseException, limit: float) -> str:
    where = f" in line {line}" if (line := _line_of(error)) else ""
    return f"Time is up: {what} was not done after {limit:g} s and was stopped{where}. Does a loop end?"


class PrintedCopy(io.TextIOBase):
    """A text stream that keeps the end of its thread's output, because callbacks have no cell to print under.

    `out` receives the output of other threads and, unless `quiet`, of its own thread. After `over`, no further text is
    kept.
    """

    def __init__(self, quiet: bool = False) -> None:
        """Begin with an empty text."""
        self.out: TextIO = sys.stdout
        self._quiet, self._thread = quiet, threading.get_ident()
        self.text, self.over = "", False

    def write(self, text: str) -> int:
        """Keep text of the own thread, and pass text on."""
        if threading.get_ident() == self._thread and not self.over:
            self.text = (self.text + text)[-KEPT_LETTERS:]
            if self._quiet:
                return len(text)
        return self.out.write(text)

    def flush(self) -> None:
        """Pass the request on to the stream that receives the text."""
        self.out.flush()


_COPIES: list[PrintedCopy] = []  # each passes text on to the copy before it
_LOCK = threading.Lock()


@contextlib.contextmanager
def _redirected(printed: PrintedCopy) -> Iterator[None]:
    """Redirect standard output to a copy; attempts in several threads may overlap and end in any order.

    A copy that ends while a later one is in use only passes text on, and is removed together with the later one.
    """
    with _LOCK:
        printed.out, sys.stdout = sys.stdout, printed
        _COPIES.append(printed)
    try:
        yield
    finally:
        with _LOCK:
            printed.over = True
            while _COPIES and _COPIES[-1].over:
                sys.stdout = _COPIES.pop().out


def complaint(what: str, error: BaseException) -> str:
    """Return a sentence with an error's class, its line in the student's code and its message of up to 200 letters.

    The message about an earlier lesson that is not usable is a sentence already.
    """
    text = " ".join(str(error).split())
    if isinstance(error, EarlierNotUsable):
        return text
    text = text if len(text) <= 200 else f"{text[:199]}…"
    line, (_, earlier) = _line_of(error), own_frames(error)
    where = f"{what}, line {line}" if line else what
    where += f", inside {earlier}" if earlier else ""
    return f"{type(error).__name__} in {where}: {text}"


def _line_of(error: BaseException) -> int | None:
    """Return the last line of the student's code in a traceback; None if the traceback contains none of it."""
    theirs, _ = own_frames(error)
    return theirs[-1].lineno if theirs else None
