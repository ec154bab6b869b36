"""One call of a student's function: what came of it, in words that a student can use."""

from __future__ import annotations

import importlib
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from nao_course.exercises.codec import CodecError, encode, register
from nao_course.exercises.exercise import Case

Came = Literal[
    "value", "not attempted", "raised", "interrupted", "timed out", "died", "not found", "unsendable"
]
_DRIVERS = "nao_course.exercises.drivers"


@register
@dataclass(frozen=True)
class Outcome:
    """What came of a call.

    Parameters
    ----------
    came : str
        "value", or what came instead of one.
    value : object
        The answer.
    text : str
        Of an exception: its type and message.
    line : str
        The student's own line that raised, with its number.
    changed : bool
        Whether the function changed its arguments.
    """

    came: Came
    value: Any = None
    text: str = ""
    line: str = ""
    changed: bool = False


def call(function: Callable[..., Any], case: Case, driver: str = "") -> Outcome:
    """Call a function with a case's arguments.

    Parameters
    ----------
    function : callable
        The student's.
    case : Case
        What to call it with; it gets copies.
    driver : str
        Name of a library function that is called instead, with the student's as its first argument.

    Returns
    -------
    Outcome
        Never an exception, but for KeyboardInterrupt turned into "interrupted".
    """
    args, kwargs = case.fresh()
    before = _state(args, kwargs)
    try:
        if driver:
            value = getattr(importlib.import_module(_DRIVERS), driver)(function, *args, **kwargs)
        else:
            value = function(*args, **kwargs)
    except NotImplementedError as error:
        if str(error):
            return _raised(error, function)
        return Outcome("not attempted")
    except KeyboardInterrupt:
        return Outcome("interrupted")
    except BaseException as error:  # noqa: BLE001 - SystemExit, too, is an answer
        return _raised(error, function)
    return Outcome("value", value, changed=_state(args, kwargs) != before)


def call_all(function: Callable[..., Any], cases: Sequence[Case], driver: str = "") -> list[Outcome]:
    """Call a function for each case, up to the first that is not attempted or interrupted."""
    outcomes: list[Outcome] = []
    for case in cases:
        outcomes.append(call(function, case, driver))
        if outcomes[-1].came in ("not attempted", "interrupted"):
            break
    return outcomes


def _state(args: tuple[Any, ...], kwargs: dict[str, Any]) -> bytes:
    """What a function must leave as it is: its arguments, but for random generators, which it may draw from."""
    kept = [arg for arg in (*args, *kwargs.values()) if not isinstance(arg, np.random.Generator)]
    try:
        return encode(kept)
    except CodecError:  # a list that was given what cannot even be sent
        return b""


def _raised(error: BaseException, function: Callable[..., Any]) -> Outcome:
    """Name an exception and the student's own line: the last one in a file that the function's is in."""
    file = getattr(getattr(function, "__code__", None), "co_filename", None)
    frames = traceback.extract_tb(error.__traceback__)
    own = [frame for frame in frames if frame.filename == file] or [
        frame for frame in frames if frame.filename.startswith("<")
    ]
    line = f"line {own[-1].lineno}: {own[-1].line or ''}".rstrip(": ") if own else ""
    return Outcome("raised", text=f"{type(error).__name__}: {error}"[:500], line=line)
