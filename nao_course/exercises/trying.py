"""Run demonstrations of a student's code, and show a sentence instead of a traceback if they fail."""

from __future__ import annotations

import os
import re
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from html import escape
from types import CodeType, FrameType, TracebackType
from typing import Any, TypeGuard, TypeVar

from nao_course._internal.time_limits import TooSlow, time_limit
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.exercises.failed_cells import FAILED_CELLS
from nao_course.exercises.running import SECONDS, is_own, own_frames, own_line

T = TypeVar("T")
DISPLAY_SECONDS = 600.0  # time limit of a whole demonstration, wall clock


@dataclass(frozen=True)
class Message:
    """A message, shown as a box in Jupyter and as plain text elsewhere.

    Parameters
    ----------
    text : str
        The message.
    """

    text: str

    def __repr__(self) -> str:
        """Return the text alone."""
        return self.text

    def _repr_html_(self) -> str:
        """Return the text in a plain box."""
        style = "border-left: 4px solid #888; padding: 0.4em 0.8em; margin: 0.3em 0"
        return f'<div role="note" style="{style}">{escape(self.text)}</div>'


class _SaidBefore(Exception):  # noqa: N818 - it is a sentence on its way
    """Raised if the result of an earlier demonstration is missing; the message explains why."""


def made(what: T | Message) -> T:
    """Return the result of an earlier `try_out`; if that failed, its message is shown again.

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
    """A shown value with a sentence above it."""

    text: str
    shown: object

    def __repr__(self) -> str:
        """Return both as text."""
        return f"{self.text}\n{self.shown!r}"

    def _repr_html_(self) -> str:
        """Return both as HTML, one above the other."""
        html = getattr(self.shown, "_repr_html_", None)
        below = html() if html else f"<pre>{escape(repr(self.shown))}</pre>"
        return f"<div>{Message(self.text)._repr_html_()}{below}</div>"


def show(what: object) -> None:
    """Show a value below the running cell; print it outside of a notebook."""
    ipython = sys.modules.get("IPython")  # not imported outside of notebooks
    if ipython and ipython.get_ipython():
        ipython.display.display(what)
    else:
        sys.stdout.write(f"{what!r}\n")


_BRACKETS = "binds more tightly than >= and <=: put each comparison in brackets."
_POWER = "A power is written ** in Python: x**2. The sign ^ means something else."
_PLACE = "the position of a pose (x, y, theta) is pose[:2]."
_IN_A_LIST = (
    "remove, index and in compare an array with each element of the list, and an array has no single True or False. "
    "Build a new list with the elements that stay, or compare positions in the list."
)
_SIDE_BY_SIDE = (
    "Columns that stand side by side need the same length: print each .shape. Is one of them a single number? "
    "np.full(n, 1.0) makes a column of n ones."
)
_ONE_ELEMENT = (
    "Since NumPy 2.4, an array with one element is not a number: take the element, as in values[0] or values.item(). "
    "Older versions did that for you."
)
_ADVICE = {  # NumPy's own messages about the most common errors are correct, but do not help a beginner
    "The truth value of an array": "An array has no single True or False. Instead of and, or, a < b < c and if, "
    "write & and | between comparisons in brackets, or use np.where.",
    "ufunc 'bitwise_and' not supported": f"& {_BRACKETS}",
    "ufunc 'bitwise_or' not supported": f"| {_BRACKETS}",
    "unsupported operand type(s) for &": f"& {_BRACKETS}",
    "ufunc 'bitwise_xor' not supported": _POWER,
    "unsupported operand type(s) for ^": _POWER,
    "shapes (3,) (2,)": f"Three numbers and two do not fit together: {_PLACE}",
    "shapes (2,) (3,)": f"Three numbers and two do not fit together: {_PLACE}",
    "Cannot convert expression to float": "A function for numbers was called with SymPy symbols: leave it out, or use "
    "SymPy's function of that name.",
    **dict.fromkeys(
        ("name 'pi' is not defined", "name 'π' is not defined"), "Python has no pi of its own: use np.pi."
    ),
    "' is not defined": "Did the cell that defines that name run since the kernel started, and is the "
    "name spelt correctly? The grader runs your definitions, but not the demonstrations.",
    "depth() == CV_8U": "OpenCV needs a picture of bytes there: use .astype(np.uint8).",
    "NumPy boolean array indexing assignment": "The left side has only the mask's pixels, but the right "
    "side has all pixels: write values[mask] there, too, or np.where(mask, values, others).",
    "with size 0": "That array is empty: check its length before you use an element of it.",
    "too many values to unpack": "An array is taken apart row by row. For its columns write x, y = points.T.",
    "too many indices for array": "The array has fewer axes than you use: print its .shape. OpenCV 4 returns lines as "
    "(N, 1, 4) and OpenCV 5 as (N, 4); .reshape(-1, 4) turns both into (N, 4).",
    "is out of bounds for axis": "Indices count from 0, so the last of n is n - 1.",
    "arrays used as indices must be of integer": "Indices must be whole numbers: apply round(...) or int(...) to them.",
    "slice indices must be integers": "The limits of a slice must be whole numbers: round(...) turns a float into one.",
    "mismatch in its core dimension": "Two shapes do not fit: the left side of @ needs as many columns as "
    "the right side has rows. Print each .shape: is a .T missing, or is one too many?",
    "1-dimensional array given": "That needs a matrix. Two lists as indices select single entries; a block is "
    "matrix[np.ix_(rows, columns)].",
    "only 0-dimensional arrays can be converted": _ONE_ELEMENT,
    "Casting complex values to real": "np.linalg.eig returns complex arrays since NumPy 2.5, even if the numbers are "
    "real. For a symmetric matrix, such as a covariance, use np.linalg.eigh.",
    "maximum recursion depth": "Your function calls itself too often. Use a loop instead.",
    "Singular matrix": "That matrix has no inverse. Print it: is a row 0, or a multiple of another row?",
    "could not be broadcast together": "Two arrays need the same shape for +, - and *. Print each .shape, and check "
    "that the arguments are in the order of the function's first line.",
    "array dimensions except for the concatenation axis": "Arrays that are joined need the same length along the "
    "other axis: print each .shape.",
    "FrozenInstanceError": "That object cannot be changed. replace(view, pitch=...) returns a copy with another pitch.",
    "'function' object has no attribute": (
        "That is a function, not an array. Did you mean another name, or forget to call it?"
    ),
    "tuple indices must be integers": "That is a tuple of several values, not one array. Unpack it first, as in hue, "
    "saturation, lightness = rgb_to_hsl(picture).",
    "'tuple' object has no attribute": "That is a tuple: several values in one. Unpack it first, as in F, G = "
    "motion_jacobians(pose, control).",
    "has no attribute 'to_local'": "That line needs a Pose, not an array: Pose(*pose).",
    "inhomogeneous shape": "The entries of your array have different shapes: print each of them. In one matrix every "
    "entry is one number, such as v[2], not an array v and not None.",
    "setting an array element with a sequence": _ONE_ELEMENT,
    "loop of ufunc does not support argument 0 of type": "np.sin and similar functions need numbers, not "
    "symbols: use SymPy's sin, cos, sqrt and atan2.",
    "has no attribute 'arctan2'": "np.arctan2 needs numbers, not symbols: use SymPy's atan2.",
    "missing 1 required positional argument": "That call has too few arguments. A tuple counts as one argument: a star "
    "before it, as in f(x, *limits), passes its values one by one.",
    "SystemExit": "exit(), quit() and sys.exit() end Python, so there is no answer: leave a function with return.",
    "BdbQuit": "A debugger has nobody to talk to in a check: remove it.",
    "high <= 0": "rng.integers excludes its upper end: pass the size itself, not one less.",
    "NoneType": "A value in that line is None, perhaps the result of a function that found nothing or has no return.",
}
_PARTS = {  # names that lessons give to the parts of an argument
    "pose": ("x, y, theta = pose", ("x", "y", "theta")),
    "control": ("d, alpha = control", ("d", "alpha", "distance", "turn")),
    "measurement": ("beta, r = measurement", ("beta", "r", "bearing")),
    "landmark": ("l_x, l_y = landmark", ("l_x", "l_y", "lx", "ly")),
}
_UNKNOWN = re.compile(r"name '(\w+)' is not defined; the function(?:'s arguments are (.*)| has no arguments)")
_WHOSE = re.compile(r"; (?:(the notebook's name)|the argument) (\w+) is of type (\w+)")
_UNBOUND = re.compile(r"UnboundLocalError: .*?local variable '(\w+)'")
_INSIDE_EARLIER = re.compile(r"\(inside (\w+) of your lesson \d+\)")
_HOMES = {  # functions that a student may call in any notebook
    **dict.fromkeys(("functions", "my_nao", "progress", "so_far"), "nao_course.student"),
    "challenge": "nao_course.challenges",
}
_RUN_ABOVE = (
    "If the kernel was restarted, first run the cells above: menu Run, Run All Above Selected Cell. "
    "Otherwise check its spelling."
)


def advice_on(complaint: str, line: str = "") -> list[str]:
    """Return the first advice, one sentence at most, on an exception, because its own message does not help a beginner.

    The complaint is the exception's class and message, and `line` the student's line that raised it, if it is known.

    >>> advice_on("ValueError: high <= 0")
    ['rng.integers excludes its upper end: pass the size itself, not one less.']
    """
    if inside := _INSIDE_EARLIER.search(complaint):
        return [
            f"{inside[1]} cannot use the arguments of that line: print them, and compare them with "
            f"help({inside[1]})."
        ]
    if advice := _on_unknown_part(complaint):
        return [advice]
    if (unbound := _UNBOUND.search(complaint)) and re.search(rf"\b{unbound[1]}\(", line):
        return [
            f"Inside your function {unbound[1]} is now a variable, so the function of that name cannot be called. "
            "Give the result another name."
        ]
    if whose := _WHOSE.search(complaint):
        if whose[1]:
            return [
                f"A cell of your notebook gives the name {whose[2]} to a value of type {whose[3]}. If you meant a "
                "module or function, give that value another name, restart the kernel and run all cells."
            ]
        if whose[3] == "int":
            return ["That is a whole number. Are the arguments in the order of the function's first line?"]
    if "The truth value of an array" in complaint and re.search(
        r"\.(?:remove|index)\(| not in |\bif \w+ in ", line
    ):
        return [_IN_A_LIST]
    if "except for the concatenation axis" in complaint and re.search(r"has size 1\b", complaint):
        return [_SIDE_BY_SIDE]
    return [advice for start, advice in _ADVICE.items() if start in complaint][:1]


def _on_unknown_part(complaint: str) -> str:
    """Return the advice to take a name from an argument, or to make a symbol; nothing if neither fits."""
    if not (found := _UNKNOWN.search(complaint)):
        return ""
    name, arguments = found[1], re.findall(r"\w+", found[2] or "")
    for argument, (line, parts) in _PARTS.items():
        if name in parts and argument in arguments:
            return f"{name} is a part of {argument}. Take it from there first: {line}."
        if name in parts and not arguments:
            return f"If {name} is a symbol, make it inside the function: {name} = sp.symbols({name!r})."
    return ""


def not_known(error: NameError) -> str:
    """Return advice about an undefined name, with its line."""
    name = error.name or "a name"
    if name in _HOMES:
        return f"This notebook has not imported {name}: from {_HOMES[name]} import {name}"
    if why := FAILED_CELLS.why_old(name):
        return f"{why} Correct that cell and run it first."
    line = own_line(error)
    return f"{name!r} is not defined in this notebook yet{f' ({line})' if line else ''}. {_RUN_ABOVE}"


def _is_unknown(error: Exception) -> TypeGuard[NameError]:
    """Return whether a name is missing in the notebook, and not only in a function that assigns it later."""
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
    """Add the advice to each NameError of this notebook; do nothing outside of Jupyter."""
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
    """Show the advice on a NameError in a notebook, without a long traceback.

    IPython calls it after `explain_unknown_names`, and from the start of a kernel on, before any cell has run.
    """
    if not _is_unknown(error):
        shell.showtraceback((kind, error, trace), tb_offset=tb_offset)
        return
    shell.showtraceback((kind, error, trace), exception_only=True)  # %tb shows the whole traceback
    show(Message(not_known(error)))


class _LongCall:
    """A test whether a call of a student's function in a demonstration has lasted too long.

    A demonstration may be slow and may call a student's function many times, but each call has a time limit. A call is
    identified by the outermost frame of a student's function from another cell.
    """

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self._call: FrameType | None = None
        self._began = 0.0
        self.name = ""  # name of the function that took too long

    def __call__(self, frame: FrameType) -> bool:
        """Return whether the running call has lasted too long."""
        now, call = time.monotonic(), _outermost_call(frame)
        if call is not self._call:
            self._call, self._began = call, now
            return False
        if call is None or now - self._began < self.seconds:
            return False
        self.name = call.f_code.co_qualname.rpartition("<locals>.")[2]
        return True


def _outermost_call(frame: FrameType) -> FrameType | None:
    """Return the outermost frame of a student's named function in a `try_out`; None if no such function is running.

    Functions in the demonstration's own cell do not count, because they may loop for a long time.
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
    """Return a message about the call that did not end."""
    what, seconds = (
        (f"one call of {watch.name}()", watch.seconds) if watch.name else ("this", DISPLAY_SECONDS)
    )
    line = own_line(error)
    return Message(
        f"Time is up: {what} was not done after {seconds:g} s{f', and was stopped in {line}' if line else ''}. "
        "Is there a loop that never ends? Correct it, run its cell and its check, then run this cell again."
    )


def strict() -> bool:
    """Return whether a check that does not pass must raise: under nbgrader, in a build, and in tests."""
    return under_nbgrader() or bool(os.environ.get("NAO_COURSE_STRICT"))


def under_nbgrader() -> bool:
    """Return whether nbgrader runs the notebook."""
    return bool(os.environ.get("NBGRADER_EXECUTION"))


def try_out(
    action: Callable[[], object], unfinished: str = "Finish the exercise above to see this."
) -> object | Message:
    """Run a demonstration that uses a student's function.

    The demonstration may take long, but each call of a student's function has the time limit of a check's case.

    Parameters
    ----------
    action : callable
        The demonstration, called without arguments.
    unfinished : str
        Message for a NotImplementedError, because an exercise is not written yet.

    Returns
    -------
    object
        The result of `action`, or a `Message` if it raised an exception, so that the notebook continues.

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
    ) as error:  # recorded data or earlier work may be missing
        return Message(str(error))
    except Exception as error:  # noqa: BLE001 - whatever a student's code raises is what it is about
        return Message(_said_of(error))
