"""Demonstration cells: run what a student wrote and show what comes of it, or a sentence instead of a traceback."""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from types import CodeType, FrameType, TracebackType
from typing import Any, TypeGuard, TypeVar

from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.exercises.failed_cells import FAILED_CELLS
from nao_course.exercises.running import SECONDS, is_own, own_frames, own_line
from nao_course.time_limits import TooSlow, time_limit

T = TypeVar("T")
DISPLAY_SECONDS = 600.0  # wall clock of a demonstration, whatever it is made of


@dataclass(frozen=True)
class Message:
    """A sentence for the reader: a box in Jupyter, plain text elsewhere.

    Parameters
    ----------
    text : str
        What to say.
    """

    text: str

    def __repr__(self) -> str:
        """The text alone."""
        return self.text

    def _repr_html_(self) -> str:
        """The text in a quiet box."""
        style = "border-left: 4px solid #888; padding: 0.4em 0.8em; margin: 0.3em 0"
        return f'<div role="note" style="{style}">{escape(self.text)}</div>'


class _SaidBefore(Exception):  # noqa: N818 - it is a sentence on its way
    """What a demonstration needs was not made; the message says why."""


def made(what: T | Message) -> T:
    """Return what an earlier `try_out` made; where it made nothing, its sentence is said again by this one.

    Examples
    --------
    >>> def unwritten():
    ...     raise NotImplementedError
    >>> table = try_out(unwritten, "Finish exercise 0.1.")
    >>> try_out(lambda: len(made(table)))
    Finish exercise 0.1.
    """
    if isinstance(what, Message):
        raise _SaidBefore(what.text)
    return what


@dataclass(frozen=True)
class Remarked:
    """Something that is shown, and a sentence above it.

    Parameters
    ----------
    text : str
        What to say.
    shown : object
        What stands below it.
    """

    text: str
    shown: object

    def __repr__(self) -> str:
        """Both as text."""
        return f"{self.text}\n{self.shown!r}"

    def _repr_html_(self) -> str:
        """Both, one above the other."""
        html = getattr(self.shown, "_repr_html_", None)
        below = html() if html else f"<pre>{escape(repr(self.shown))}</pre>"
        return f"<div>{Message(self.text)._repr_html_()}{below}</div>"


def show(what: object) -> None:
    """Show something below the cell that runs; print it where there is no notebook."""
    ipython = sys.modules.get("IPython")  # where it is not imported, there is no notebook
    if ipython and ipython.get_ipython():
        ipython.display.display(what)
    else:
        sys.stdout.write(f"{what!r}\n")


_BRACKETS = "binds more tightly than >= and <=: put each comparison in brackets."
_POWER = "A power is ** in Python: x**2. The sign ^ means something else."
_PLACE = "of a pose (x, y, theta), pose[:2] is the place."
_ADVICE = {  # what NumPy says of the commonest slips is right, and no help to a beginner
    "The truth value of an array": "An array has no single True or False. For and, or, a < b < c and if, say & and | "
    "between comparisons in brackets, or np.where.",
    "ufunc 'bitwise_and' not supported": f"& {_BRACKETS}",
    "ufunc 'bitwise_or' not supported": f"| {_BRACKETS}",
    "unsupported operand type(s) for &": f"& {_BRACKETS}",
    "ufunc 'bitwise_xor' not supported": _POWER,
    "unsupported operand type(s) for ^": _POWER,
    "shapes (3,) (2,)": f"Three numbers and two do not fit together: {_PLACE}",
    "shapes (2,) (3,)": f"Three numbers and two do not fit together: {_PLACE}",
    "Cannot convert expression to float": "A function that wants numbers got symbols of SymPy: leave it out, or take "
    "SymPy's own.",
    "' is not defined": "Is that name spelt right, and did the cells above run since the kernel was "
    "started? The grader runs what you define, and no demonstrations.",
    "depth() == CV_8U": "OpenCV takes a picture of bytes there: .astype(np.uint8).",
    "NumPy boolean array indexing assignment cannot assign": "On the left stand only the mask's pixels, on the right "
    "all of them: say values[mask] there, too, or np.where(mask, values, others).",
    "with size 0": "That array is empty: ask for its length before you take something out of it.",
    "is out of bounds for axis": "Indices count from 0: the last of n is n - 1, and drawn with rng.integers(0, n) none "
    "is larger.",
    "arrays used as indices must be of integer": "Indices are whole numbers: round(...) what you compute them from.",
    "slice indices must be integers": "Limits of a slice are whole numbers: round(...) makes one of a float.",
    "mismatch in its core dimension": "Two shapes do not fit: the left of @ wants as many columns as "
    "the right has rows. Print each .shape; is one transposed that should not be, or not where it should?",
    "could not be broadcast together": "Entry by entry (+, -, *) two arrays need one shape. Print each .shape; and "
    "do the arguments stand in the order of the function's first line?",
    "'function' object has no attribute": "That is a function, not an array. Is it the name that you mean?",
    "has no attribute 'to_local'": "A Pose is wanted there, not an array: Pose(*pose).",
    "inhomogeneous shape": "One entry of your matrix is itself an array, where one number is wanted: pose[2] is the "
    "heading, pose all three numbers.",
    "loop of ufunc does not support argument 0 of type": "np.sin and its like take numbers, no symbols: in SymPy say "
    "sin, cos, sqrt and atan2.",
    "has no attribute 'arctan2'": "np.arctan2 takes numbers, no symbols: in SymPy it is atan2.",
    "high <= 0": "The upper end of rng.integers is not included: say the size itself, not one less.",
}
_INSIDE_EARLIER = re.compile(r"\(inside (\w+) of your lesson \d+\)")
_HOMES = {  # of what a student may call in any notebook
    **dict.fromkeys(("functions", "my_nao", "progress", "so_far"), "nao_course.student"),
    "challenge": "nao_course.challenges",
}
_RUN_ABOVE = (
    "If the kernel was restarted, first run the cells above: menu Run, Run All Above Selected Cell. "
    "Else look at its spelling."
)


def advice_on(complaint: str) -> list[str]:
    """Say what to do about an exception whose own words do not help a beginner: the first piece of advice that fits.

    Examples
    --------
    >>> advice_on("ValueError: high <= 0")
    ['The upper end of rng.integers is not included: say the size itself, not one less.']
    """
    if inside := _INSIDE_EARLIER.search(complaint):
        return [
            f"{inside[1]} cannot work with what that line passes to it: print it, or see what help({inside[1]}) says "
            "that it takes."
        ]
    return [advice for start, advice in _ADVICE.items() if start in complaint][:1]


def not_known(error: NameError) -> str:
    """Say what to do about a name that the notebook does not know, and in which line it stands."""
    name = error.name or "a name"
    if name in _HOMES:
        return f"This notebook has not imported {name}: from {_HOMES[name]} import {name}"
    if why := FAILED_CELLS.why_old(name):
        return f"{why} Mend that cell and run it first."
    line = own_line(error)
    return f"This notebook does not know {name!r} yet{f' ({line})' if line else ''}. {_RUN_ABOVE}"


def _is_unknown(error: Exception) -> TypeGuard[NameError]:
    """Whether a name is missing in the notebook, and not only in a function that assigns it later."""
    return isinstance(error, NameError) and not isinstance(error, UnboundLocalError)


def _said_of(error: Exception) -> str:
    if _is_unknown(error):
        return not_known(error)
    said, (_, earlier) = f"{type(error).__name__}: {error}", own_frames(error)
    if not earlier:
        return said
    line = own_line(error)
    said += f" (inside {earlier})."
    return " ".join([said, *([f"It is called from your {line}."] if line else []), *advice_on(said)])


def explain_unknown_names() -> None:
    """Add that sentence to each NameError of this notebook; outside of Jupyter, nothing happens."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if shell is not None:
        shell.set_custom_exc((NameError,), show_unknown_name)


def show_unknown_name(
    shell: Any,
    kind: type[BaseException],
    error: Exception,
    trace: TracebackType | None,
    tb_offset: int | None = None,
) -> None:
    """Show a NameError in a notebook: the sentence that helps, and no long traceback above it.

    It is called by IPython, see `explain_unknown_names`, and by the start of a kernel, before any cell has run.
    """
    if not _is_unknown(error):
        shell.showtraceback((kind, error, trace), tb_offset=tb_offset)
        return
    shell.showtraceback((kind, error, trace), exception_only=True)  # %tb shows all of it
    show(Message(not_known(error)))


class _LongCall:
    """Watches a demonstration, and says whether one call of a student's function has lasted too long.

    A demonstration may take its time, and call a student's function as often as it likes. One call is the outermost
    frame of a student's function from another cell; while that frame is the same, it is the same call.

    Parameters
    ----------
    seconds : float
        What one call may take.
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._call: FrameType | None = None
        self._began = 0.0
        self.name = ""  # of the function that took too long

    def __call__(self, frame: FrameType) -> bool:
        """Look at what runs now."""
        now, call = time.monotonic(), _outermost_call(frame)
        if call is not self._call:
            self._call, self._began = call, now
            return False
        if call is None or now - self._began < self.seconds:
            return False
        self.name = call.f_code.co_qualname.rpartition("<locals>.")[2]
        return True


def _outermost_call(frame: FrameType) -> FrameType | None:
    """Return the outermost frame of a student's named function in a `try_out`; None while there is none.

    What stands in the cell of the demonstration itself belongs to it: that may loop for long.
    """
    found: list[FrameType] = []
    each: FrameType | None = frame
    while each is not None and each.f_code is not try_out.__code__:
        found.append(each)
        each = each.f_back
    demonstration = found[-1].f_code.co_filename if found else ""
    return next((each for each in reversed(found) if _is_called(each.f_code, demonstration)), None)


def _is_called(code: CodeType, demonstration: str) -> bool:
    own = code.co_filename != demonstration and is_own(code.co_filename)
    return own and not code.co_name.startswith("<")


def _stopped(watch: _LongCall, error: TooSlow) -> Message:
    """Say which call did not end, and what to do."""
    what, seconds = (
        (f"one call of {watch.name}()", watch.seconds) if watch.name else ("this", DISPLAY_SECONDS)
    )
    line = own_line(error)
    return Message(
        f"Time is up: {what} was not done after {seconds:g} s{f', and was stopped in {line}' if line else ''}. "
        "Does a loop never end? Mend it, run its cell and its check, then this cell again."
    )


def try_out(
    action: Callable[[], object], unfinished: str = "Finish the exercise above to see this."
) -> object | Message:
    """Run a demonstration that uses a student's function.

    It may take long; but one call of a student's function has the time that a case of a check has.

    Parameters
    ----------
    action : callable
        What to show; called without arguments.
    unfinished : str
        What to say when it raises NotImplementedError: an exercise has not been written yet.

    Returns
    -------
    object
        What `action` returned; a `Message` when it raised, so that the notebook runs on.

    Examples
    --------
    >>> try_out(lambda: 1 / 0)
    ZeroDivisionError: division by zero
    """
    watch = _LongCall(SECONDS)
    try:
        with time_limit(DISPLAY_SECONDS, sooner=watch):
            return action()
    except NotImplementedError:
        return Message(unfinished)
    except TooSlow as error:
        return _stopped(watch, error)
    except (
        FileNotFoundError,
        EarlierNotUsable,
        _SaidBefore,
    ) as error:  # recorded data or earlier work that not everybody has
        return Message(str(error))
    except Exception as error:  # noqa: BLE001 - whatever a student's code raises is what it is about
        return Message(_said_of(error))
