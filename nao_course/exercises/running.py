"""Call a student's function once and describe the outcome in words that a student can use."""

from __future__ import annotations

import errno
import importlib
import linecache
import os
import re
import signal
import sysconfig
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import FrameType
from typing import Any, Literal

import numpy as np

from nao_course._internal import time_limits
from nao_course.codec import CodecError, Limits, decode, encode, register
from nao_course.exercises.case import Case
from nao_course.exercises.interactive import unattended

Status = Literal[
    "value", "not attempted", "raised", "interrupted", "timed out", "died", "not found", "unsendable"
]
# independent of the methods of an untrusted class
_NAME, _MRO = (type.__dict__[name].__get__ for name in ("__name__", "__mro__"))
_MOST_CLASSES = 20  # reported classes of an exception, its bases included
_DRIVERS: dict[str, Callable[..., Any]] = {}
_EARLIER = str(Path(__file__).with_name("earlier.py"))  # whose objects call functions of earlier lessons
REFERENCE = "<reference>"  # file name of reference implementations that replace a student's functions
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

_NO_SPACE = "the disk space that this code may use is used up"
SECONDS = 20.0  # wall clock of a public case in a lesson; more where the grader gives more than half of it


class Unsendable(CodecError):  # noqa: N818 - it reads as a sentence
    """Raised by a driver for a result that cannot be encoded; the message is for the student."""


@register
@dataclass(frozen=True)
class Outcome:
    """The outcome of a call.

    Parameters
    ----------
    status : str
        "value", or the reason why there is no value.
    value : object
        The answer as plain arrays, numbers and lists, without any type of the student's.
    text : str
        Type and message of an exception, or a description of an answer that cannot be encoded.
    line : str
        The student's own line that raised, with its number.
    changed : bool
        Whether the function changed its arguments.
    output : str
        The beginning of the printed text, if that is kept.
    errors : tuple of str
        Names of an exception's class and of its base classes.
    shown : tuple of str
        Names of calls that would have shown something to a person and did nothing.
    """

    status: Status
    value: Any = None
    text: str = ""
    line: str = ""
    changed: bool = False
    output: str = ""
    errors: tuple[str, ...] = ()
    shown: tuple[str, ...] = ()


def call(function: Callable[..., Any], case: Case, driver: str = "") -> Outcome:
    """Call a function with a case's arguments.

    Parameters
    ----------
    function : callable
        The student's function.
    case : Case
        Case with the arguments; the function receives copies.
    driver : str
        Name of a registered function that is called instead, with the student's function as its first argument.

    Returns
    -------
    Outcome
        The outcome. No exception is raised, and KeyboardInterrupt becomes "interrupted". The value is a plain copy.
    """
    return decode(encoded(call_as_it_is(function, case.frame, driver)))


def call_all(
    function: Callable[..., Any],
    cases: Sequence[Case],
    driver: str = "",
    seconds: float = SECONDS,
    answer: Callable[[Callable[[Case], Outcome], Case], Outcome] = lambda once, case: once(case),
) -> list[Outcome]:
    """Call a function for each case until a call is not attempted, interrupted or out of time.

    Each case has `seconds` of wall clock. `answer` makes the calls of a case and returns their outcome; see
    `judging.answer`.
    """
    outcomes: list[Outcome] = []
    for case in cases:
        try:
            with alarm(seconds):
                outcome = answer(lambda each: call(function, each, driver), case)
        except TimeIsUp:  # the alarm rang while the answer was copied
            outcome = Outcome("timed out")
        outcomes.append(outcome)
        if outcomes[-1].status in ("not attempted", "interrupted", "timed out"):
            break
    return outcomes


def register_driver(function: Callable[..., Any]) -> Callable[..., Any]:
    """Register a function as a driver of exercises; use as a decorator.

    Raises
    ------
    ValueError
        If another driver has the same name.
    """
    if _DRIVERS.setdefault(function.__name__, function) is not function:
        raise ValueError(f"a driver named {function.__name__!r} is registered already")
    return function


def find_driver(name: str) -> Callable[..., Any]:
    """Return a registered driver such as "jacobian", or raise a ValueError if there is none of that name.

    If a module outside of `nao_course.exercises` registers the driver, the module and a colon come first.
    """
    module, _, function = name.rpartition(":")
    if module.startswith("nao_course."):
        importlib.import_module(module)
    if function not in _DRIVERS:
        raise ValueError(f"there is no driver {name!r}; choose one of {sorted(_DRIVERS)}")
    return _DRIVERS[function]


class TimeIsUp(BaseException):
    """Raised inside a student's code that runs too long; `except Exception` does not catch it."""


@contextmanager
def alarm(seconds: float) -> Iterator[None]:
    """Raise TimeIsUp in the block after a time; an inner alarm rings no later than an outer alarm.

    The alarm waits for the end of a running import, for at most `time_limits.IMPORTING` seconds, because a compiled
    module whose import was interrupted cannot be imported again. On Windows and outside of the main thread,
    `time_limit` is used, which can interrupt only between two steps of Python.
    """
    if not hasattr(signal, "setitimer") or threading.current_thread() is not threading.main_thread():
        with time_limits.time_limit(seconds, error=TimeIsUp):
            yield
        return

    over = False

    outer, _ = signal.getitimer(signal.ITIMER_REAL)  # 0 without an outer alarm
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


def call_as_it_is(
    function: Callable[..., Any], frame: bytes | bytearray, driver: str = "", *, trusted: bool = False
) -> Outcome:
    """Call a function like `call`, but with the arguments in a case's frame, and return its value unchanged.

    `frame` is as `Case.frame`, and `trusted` as in `codec.decode`.
    """
    args, kwargs = given = decode(frame, trusted=trusted)
    with unattended(function) as shown:
        outcome = outcome_of(
            lambda: find_driver(driver)(function, *args, **kwargs) if driver else function(*args, **kwargs),
            function,
        )
    if outcome.status != "value":
        return outcome
    return replace(outcome, changed=_changed(given, frame, trusted=trusted), shown=tuple(shown))


def outcome_of(call: Callable[[], Any], function: Any = None) -> Outcome:
    """Make a call and describe its outcome.

    It replaces nothing in the process, so threads may use it. `function` is the student's function that is called.
    """
    try:
        return Outcome("value", call())
    except NotImplementedError as error:
        return _not_written(error, function)
    except Unsendable as error:
        return Outcome("unsendable", text=describe(error).partition(": ")[2])
    except KeyboardInterrupt:
        return Outcome("interrupted")
    except TimeIsUp:
        return Outcome("timed out")
    except BaseException as error:  # noqa: BLE001 - SystemExit, too, is an answer
        return _raised(error)


def encoded(outcome: Outcome, limits: Limits | None = None, number: int | None = None) -> bytes:
    """Return the frame of an outcome, or of a call's number and its outcome.

    If the value cannot be sent, the outcome is "unsendable".
    """

    def frame_of(outcome: Outcome) -> bytes:
        return encode(outcome if number is None else (number, outcome), limits)

    try:
        return frame_of(outcome)
    except CodecError as error:
        return frame_of(Outcome("unsendable", text=str(error), output=outcome.output))


def describe(error: BaseException) -> str:
    """Return an exception's type and message as text, even if a student's class formats it wrongly."""
    try:
        full = isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
        text = f"{_name_of(type(error))}: {_NO_SPACE if full else error}"
    except Exception:  # noqa: BLE001 - a message whose text raises cannot be shown
        text = _name_of(type(error))
    return _printable(text[:500])


def _not_written(error: NotImplementedError, function: Any) -> Outcome:
    """Distinguish a function that is still blank from a function that calls a blank one."""
    frames = [frame.name for frame in traceback.extract_tb(error.__traceback__) if is_own(frame.filename)]
    if error.args:
        return _raised(error)
    if len(frames) > 1 and frames[-1] not in (frames[0], "<lambda>", getattr(function, "__name__", "")):
        return Outcome("raised", text=f"NotImplementedError: {frames[-1]} is not written yet")
    return Outcome("not attempted")


def is_own(filename: str) -> bool:
    """Return whether a file's code is the student's: a cell, or a file beside the notebook."""
    if filename.startswith("<"):
        return bool(_CELL.fullmatch(filename))
    return not filename.startswith(_NOT_THE_STUDENTS) and not filename.endswith(".pyx")


def own_frames(error: BaseException) -> tuple[list[traceback.FrameSummary], str]:
    """Return the frames of an exception in this notebook, and the earlier lesson's function that raised it, if any.

    The frames are outside of libraries, up to the call of the earlier function, such as "predict_pose of your lesson
    05".
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
    """Return the last line of an exception's traceback outside of libraries, with its number; empty without one.

    For code that was generated as text (by sympy.lambdify, exec or a dataclass) and for functions of earlier lessons,
    which are in another notebook, the calling line is returned.
    """
    own, _ = own_frames(error)
    line = f"line {own[-1].lineno}: {own[-1].line or ''}".rstrip(": ") if own else ""
    return _printable(line[:500])


def _raised(error: BaseException) -> Outcome:
    """Return an exception's text, its classes and the student's own line."""
    own, earlier = own_frames(error)
    if not earlier and own and own[-1].filename != own[0].filename:  # in another cell
        earlier = own[-1].name
    inside = [f"(inside {earlier})"] if earlier else []
    text = " ".join([describe(error) + _arguments(error) + _whose(error), *inside, *_notes(error)])
    return Outcome("raised", text=text, line=own_line(error), errors=_names_of_classes(type(error)))


def _arguments(error: BaseException) -> str:
    """Say which arguments the student's function has that used an unknown name: the name may be a part of one."""
    if not isinstance(error, NameError) or isinstance(error, UnboundLocalError):
        return ""
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    if not frames or not is_own(frames[-1].f_code.co_filename) or frames[-1].f_code.co_name == "<module>":
        return ""
    code = frames[-1].f_code
    names = code.co_varnames[: code.co_argcount]
    listed = " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))
    return _printable(
        f"; the function's arguments are {listed}" if names else "; the function has no arguments"
    )[:200]


def _whose(error: BaseException) -> str:
    """Say whose value an attribute or a call failed for: a name of the notebook's, or an argument."""
    if not isinstance(error, AttributeError | TypeError) or not error.__traceback__:
        return ""
    frame, number = [*traceback.walk_tb(error.__traceback__)][-1]
    line, code = linecache.getline(frame.f_code.co_filename, number), frame.f_code
    if not is_own(code.co_filename):
        return ""
    value = getattr(error, "obj", None)  # of an AttributeError
    for name in dict.fromkeys([*code.co_names, *code.co_varnames[: code.co_argcount]]):
        used = re.search(rf"(?<![\w.]){name}\s*{'[.]' if isinstance(error, AttributeError) else '[(]'}", line)
        # The notebook gave no value to a name that is not there, such as len: print stands for it
        held = (frame.f_locals if name in code.co_varnames else frame.f_globals).get(name, print)
        if not used or callable(held) or (isinstance(error, AttributeError) and held is not value):
            continue
        whose = "the argument" if name in code.co_varnames else "the notebook's name"
        return _printable(f"; {whose} {name} is of type {_name_of(type(held))}")[:200]
    return ""


def _notes(error: BaseException) -> list[str]:
    """Return a driver's notes about the place where an exception was raised."""
    notes = getattr(error, "__notes__", ())
    if type(notes) is not list:
        return []
    return [_printable(note[:100]) for note in notes if type(note) is str]


def _names_of_classes(kind: type) -> tuple[str, ...]:
    """Return the names of an exception's class and its base classes."""
    return tuple(_name_of(each) for each in _MRO(kind)[:_MOST_CLASSES])


def _name_of(kind: type) -> str:
    return _printable(_NAME(kind)[:100])


def _printable(text: str) -> str:
    return text.encode("utf-8", "replace").decode()


def _changed(
    given: tuple[tuple[Any, ...], dict[str, Any]], frame: bytes | bytearray, *, trusted: bool
) -> bool:
    """Return whether arguments differ from those in the frame that they were decoded from."""
    try:
        if encode(given) == frame:  # nearly always: then the frame need not be decoded again
            return False
    except CodecError:  # a value that cannot be encoded was put into a list
        return True
    return _state(*given) != _state(*decode(frame, trusted=trusted))


def _state(args: tuple[Any, ...], kwargs: dict[str, Any]) -> bytes:
    """Encode a function's arguments, which it must not change, except random generators."""
    return encode([arg for arg in (*args, *kwargs.values()) if not isinstance(arg, np.random.Generator)])
