"""One call of a student's function: what came of it, in words that a student can use."""

from __future__ import annotations

import importlib
import os
import re
import signal
import sysconfig
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, Literal

import numpy as np

from nao_course import time_limits
from nao_course.exercises.case import Case
from nao_course.exercises.codec import CodecError, Limits, decode, encode, register

Status = Literal[
    "value", "not attempted", "raised", "interrupted", "timed out", "died", "not found", "unsendable"
]
_NAME, _MRO = (
    type.__dict__[name].__get__ for name in ("__name__", "__mro__")
)  # not as a stranger's class says
_MOST_CLASSES = 20  # of an exception and its bases that are told
_DRIVERS: dict[str, Callable[..., Any]] = {}
_EARLIER = str(Path(__file__).with_name("earlier.py"))  # whose objects call functions of earlier lessons
REFERENCE = "<reference>"  # file name of what is lent to a student
_NOT_THE_STUDENTS = (
    REFERENCE,
    *(
        f"{folder}{os.sep}"
        for folder in (
            *(sysconfig.get_path(name) for name in ("stdlib", "purelib", "platlib")),
            str(Path(__file__).parents[1]),
        )
    ),
)
# What has no file: a cell of IPython or of `load_definitions`; all else is code that a library made as text.
_CELL = re.compile(r"<(?:ipython-input-.*|stdin|.*, cell \d+)>")

SECONDS = 20.0  # wall clock of a public case in a lesson; more where the grader gives more than half of it


class Unsendable(CodecError):  # noqa: N818 - it reads as a sentence
    """Raised by a driver where something came back that cannot be sent; the message is for the student."""


@register
@dataclass(frozen=True)
class Outcome:
    """What came of a call.

    Parameters
    ----------
    status : str
        "value", or what came instead of one.
    value : object
        The answer: plain arrays, numbers, lists, nothing of a student's own types.
    text : str
        Of an exception: its type and message. Of an answer that cannot be sent: what it is.
    line : str
        The student's own line that raised, with its number.
    changed : bool
        Whether the function changed its arguments.
    output : str
        The beginning of what it printed, where that is kept.
    errors : tuple of str
        Of an exception: the names of its class and of all that is derived from.
    """

    status: Status
    value: Any = None
    text: str = ""
    line: str = ""
    changed: bool = False
    output: str = ""
    errors: tuple[str, ...] = ()


def call(function: Callable[..., Any], case: Case, driver: str = "") -> Outcome:
    """Call a function with a case's arguments.

    Parameters
    ----------
    function : callable
        The student's.
    case : Case
        What to call it with; it gets copies.
    driver : str
        Name of a registered function that is called instead, with the student's as its first argument.

    Returns
    -------
    Outcome
        Never an exception, but for KeyboardInterrupt turned into "interrupted". Its value is a plain copy.
    """
    return decode(encoded(call_as_it_is(function, case, driver)))


def call_all(
    function: Callable[..., Any],
    cases: Sequence[Case],
    driver: str = "",
    seconds: float = SECONDS,
    answer: Callable[[Callable[[Case], Outcome], Case], Outcome] = lambda once, case: once(case),
) -> list[Outcome]:
    """Call a function for each case, up to the first that is not attempted, interrupted or out of time.

    Each case has `seconds` of wall clock. `answer` makes the calls of a case and says what came of them; see
    `judging.answer`.
    """
    outcomes: list[Outcome] = []
    for case in cases:
        try:
            with alarm(seconds):
                outcome = answer(lambda each: call(function, each, driver), case)
        except TimeIsUp:  # it rang while the answer was being copied
            outcome = Outcome("timed out")
        outcomes.append(outcome)
        if outcomes[-1].status in ("not attempted", "interrupted", "timed out"):
            break
    return outcomes


def register_driver(function: Callable[..., Any]) -> Callable[..., Any]:
    """Let exercises name a function as their driver; use as a decorator.

    Raises
    ------
    ValueError
        If another driver has its name.
    """
    if _DRIVERS.setdefault(function.__name__, function) is not function:
        raise ValueError(f"a driver named {function.__name__!r} is registered already")
    return function


def find_driver(name: str) -> Callable[..., Any]:
    """Return a driver.

    Parameters
    ----------
    name : str
        "jacobian"; or with the module of nao_course that registers it before a colon, where that is not one of
        `nao_course.exercises`.

    Raises
    ------
    ValueError
        If there is none of that name.
    """
    module, _, function = name.rpartition(":")
    if module.startswith("nao_course."):
        importlib.import_module(module)
    if function not in _DRIVERS:
        raise ValueError(f"there is no driver {name!r}; there are {sorted(_DRIVERS)}")
    return _DRIVERS[function]


class TimeIsUp(BaseException):
    """Raised into a student's code that runs too long; no `except Exception` of theirs stops it."""


@contextmanager
def alarm(seconds: float) -> Iterator[None]:
    """Raise TimeIsUp in the block after a time; one that is in another rings no later than that.

    It does not ring in the middle of an import, but after it: a compiled module that is begun and not ended can never
    be imported again. It waits for `time_limits.IMPORTING` seconds at most. Where there is no alarm clock (Windows, or
    another thread than the main one), it is `time_limit`, which rings between two steps of Python only.
    """
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        with time_limits.time_limit(seconds, error=TimeIsUp):
            yield
        return

    over = False

    outer, _ = signal.getitimer(signal.ITIMER_REAL)  # 0 where this one is in no other
    began = time.monotonic()
    last = began + seconds + time_limits.IMPORTING

    def ring(_: int, frame: FrameType | None) -> None:
        if over:
            return
        if time.monotonic() < last and time_limits.importing(frame):
            signal.setitimer(signal.ITIMER_REAL, 0.05)
            return
        raise TimeIsUp

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, min(seconds, outer) if outer else seconds)
    try:
        yield
    finally:
        over = True  # it may ring between here and the next line
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        if outer:
            signal.setitimer(signal.ITIMER_REAL, max(outer - (time.monotonic() - began), 1e-3))


def call_as_it_is(function: Callable[..., Any], case: Case, driver: str = "") -> Outcome:
    """Call a function as `call` does; the value is what it returned, of whatever type."""
    args, kwargs = case.fresh()
    before = _state(args, kwargs)
    if driver:
        args = (function, *args)
        function = find_driver(driver)
    try:
        value = function(*args, **kwargs)
    except NotImplementedError as error:
        return _not_written(error, args[0] if driver else function)
    except Unsendable as error:
        return Outcome("unsendable", text=describe(error).partition(": ")[2])
    except KeyboardInterrupt:
        return Outcome("interrupted")
    except TimeIsUp:
        return Outcome("timed out")
    except BaseException as error:  # noqa: BLE001 - SystemExit, too, is an answer
        return _raised(error)
    return Outcome("value", value, changed=_state(args[1:] if driver else args, kwargs) != before)


def encoded(outcome: Outcome, limits: Limits | None = None) -> bytes:
    """Return an outcome's frame; that of "unsendable" where its value cannot be sent."""
    try:
        return encode(outcome, limits)
    except CodecError as error:
        return encode(Outcome("unsendable", text=str(error), output=outcome.output), limits)


def describe(error: BaseException) -> str:
    """Name an exception's type and say its message, of which a student's own class may make anything."""
    try:
        text = f"{_name_of(type(error))}: {error}"
    except Exception:  # noqa: BLE001 - a message that raises is no message
        text = _name_of(type(error))
    return _printable(text[:500])


def _not_written(error: NotImplementedError, function: Any) -> Outcome:
    """Tell a function that is still blank from one that calls a blank one."""
    frames = [frame.name for frame in traceback.extract_tb(error.__traceback__) if is_own(frame.filename)]
    if error.args:
        return _raised(error)
    if len(frames) > 1 and frames[-1] not in (frames[0], "<lambda>", getattr(function, "__name__", "")):
        return Outcome("raised", text=f"NotImplementedError: {frames[-1]} is not written yet")
    return Outcome("not attempted")


def is_own(filename: str) -> bool:
    """Whether code of this file is a student's: a cell, or a file beside the notebook."""
    if filename.startswith("<"):
        return bool(_CELL.fullmatch(filename))
    return not filename.startswith(_NOT_THE_STUDENTS) and not filename.endswith(".pyx")


def own_frames(error: BaseException) -> tuple[list[traceback.FrameSummary], str]:
    """Return the frames of this notebook that an exception came through, and what it calls that is of an earlier one.

    Returns
    -------
    list of FrameSummary
        Those in no library; they end where a function of an earlier lesson is called.
    str
        That function: "predict_pose of your lesson 05"; empty if the exception did not arise in one.
    """
    walked = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    frames = traceback.extract_tb(error.__traceback__)
    calls = (
        i for i, each in enumerate(walked) if each.f_code.co_filename == _EARLIER and "self" in each.f_locals
    )
    end = next(calls, len(frames))
    own = [frame for frame in frames[:end] if is_own(frame.filename)]
    inside = any(is_own(frame.filename) for frame in frames[end:])
    return own, str(walked[end].f_locals["self"]) if inside else ""


def own_line(error: BaseException) -> str:
    """Say where an exception came from: the last line, with its number, that is in no library; nothing if all are.

    Code that was made as text (by sympy.lambdify, exec, a dataclass) has no line that anybody wrote: the line that
    called it is said. So it is of a function of an earlier lesson, which stands in another notebook.
    """
    own, _ = own_frames(error)
    line = f"line {own[-1].lineno}: {own[-1].line or ''}".rstrip(": ") if own else ""
    return _printable(line[:500])


def _raised(error: BaseException) -> Outcome:
    """Name an exception, its classes and the student's own line."""
    _, earlier = own_frames(error)
    inside = [f"(inside {earlier})"] if earlier else []
    text = " ".join([describe(error), *inside, *_notes(error)])
    return Outcome("raised", text=text, line=own_line(error), errors=_names_of_classes(type(error)))


def _notes(error: BaseException) -> list[str]:
    """What a driver says of where it happened."""
    notes = getattr(error, "__notes__", ())
    if type(notes) is not list:
        return []
    return [_printable(note[:100]) for note in notes if type(note) is str]


def _names_of_classes(kind: type) -> tuple[str, ...]:
    """Names of an exception's class and of those it is derived from."""
    return tuple(_name_of(each) for each in _MRO(kind)[:_MOST_CLASSES])


def _name_of(kind: type) -> str:
    return _printable(_NAME(kind)[:100])


def _printable(text: str) -> str:
    return text.encode("utf-8", "replace").decode()


def _state(args: tuple[Any, ...], kwargs: dict[str, Any]) -> bytes:
    """What a function must leave as it is: its arguments, but for random generators, which it may draw from."""
    kept = [arg for arg in (*args, *kwargs.values()) if not isinstance(arg, np.random.Generator)]
    try:
        return encode(kept)
    except CodecError:  # a list that was given what cannot even be sent
        return b""
