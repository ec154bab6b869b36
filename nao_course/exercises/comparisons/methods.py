"""Cases, drivers and comparisons for classes and generators, whose calls are compared one by one."""

from __future__ import annotations

import dis
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from typing import Any

from nao_course.codec import CodecError, decode, encode, register
from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import RIGHT, Comparison, Verdict, with_article
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.running import Unsendable, register_driver

Call = tuple[str, tuple[Any, ...]]  # a method's name and its arguments


# --- cases ---


def calls(*turns: str | tuple[Any, ...], given: Sequence[Any] = (), name: str = "") -> Case:
    """Make a case for the driver `methods`: an object is made, and its methods are called in turn.

    Parameters
    ----------
    *turns : str or tuple
        Calls, each a method's name or a tuple of the name and the arguments. A name that begins with a dot is an
        attribute: ".state" reads it, and (".state", value) assigns it, so that a case can test one method alone.
    given : sequence
        Arguments of the constructor.
    name : str
        As in `Case`. If it begins with the part that the case tests, as in "move: a turn", the check lists the parts
        that are right.

    Returns
    -------
    Case
        Case whose answer consists of the results of all calls, in turn.

    Examples
    --------
    >>> calls(("move", 1.0), "estimate", given=(0.0,)).args
    ((0.0,), [('move', (1.0,)), ('estimate', ())])
    """
    told = [(turn, ()) if isinstance(turn, str) else (turn[0], tuple(turn[1:])) for turn in turns]
    return Case((tuple(given), told), name)


def over_log(
    log: Iterable[tuple[Any, Sequence[Any]]], given: Sequence[Any] = (), name: str = "", every: int = 1
) -> Case:
    """Make a case for the driver `methods` of a recorded log, for a `SlamAlgorithm`.

    Parameters
    ----------
    log : iterable of (Motion or None, sequence of Measurement)
        Log as for `run_slam`: each step is a motion (None if the robot stands still) and its measurements.
    given : sequence
        Arguments of the constructor.
    name : str
        As in `Case`.
    every : int
        Number of steps between two calls of `estimate`.

    Returns
    -------
    Case
        Case for `Methods({"estimate": ...})`.

    Examples
    --------
    >>> over_log([(None, [])]).args
    ((), [('observe', ([],)), ('estimate', ())])
    """
    turns: list[tuple[Any, ...]] = []
    for step, (motion, measurements) in enumerate(log, start=1):
        turns += [] if motion is None else [("move", motion)]
        turns.append(("observe", list(measurements)))
        turns += [("estimate",)] if step % every == 0 else []
    return calls(*turns, given=given, name=name)


def first_items(count: int, *args: Any, name: str = "") -> Case:
    """Make a case for the driver `items`, whose answer consists of the first `count` items of a generator.

    Parameters
    ----------
    count : int
        Number of items; fewer if the generator ends earlier.
    *args : object
        Arguments of the generator function.
    name : str
        As in `Case`.
    """
    return Case((count, *args), name)


# --- drivers ---


@register_driver
def methods(made_by: Callable[..., Any], given: tuple[Any, ...], turns: list[Call]) -> list[tuple[str, Any]]:
    """Make an object of the student's class, call its methods in turn, and return each name with a copy of the result.

    A blank method raises a NotImplementedError with its name, or without one if all are blank, a missing method an
    AttributeError, and a result that cannot be encoded an Unsendable.
    """
    title = getattr(made_by, "__name__", "it")
    if not callable(made_by):
        raise TypeError(
            f"expected a class, got {with_article(made_by)}: pass the class itself, without brackets"
        )
    for name in sorted(getattr(made_by, "__abstractmethods__", ())):
        raise AttributeError(f"{title} has no method {name}")
    thing = _call(made_by, "__init__", made_by, given, "making one")
    count: Counter[str] = Counter()
    answers = []
    for name, args in turns:
        count[name] += 1
        where = f"{name}, call {count[name]}"
        if name.startswith("."):
            if args:
                setattr(thing, name[1:], _copy(args[0], name))
            elif not hasattr(thing, name[1:]):
                raise AttributeError(f"{title} has no attribute {name[1:]}")
            answers.append((name, None if args else _copy(getattr(thing, name[1:]), name)))
            continue
        method = getattr(thing, name, None)
        if not callable(method):
            raise AttributeError(f"{title} has no method {name}")
        answers.append((name, _copy(_call(made_by, name, method, args, where), where)))
    return answers


@register_driver
def items(function: Callable[..., Any], count: int, *args: Any) -> list[Any] | None:
    """Call a generator function and return copies of its first `count` items, or None if it returns None."""
    made = function(*args)
    if made is None:
        return None
    return [_copy(item, f"item {number}") for number, item in enumerate(islice(made, count), start=1)]


def _call(made_by: Any, name: str, function: Callable[..., Any], args: tuple[Any, ...], where: str) -> Any:
    """Call a method, and add the call to the message of an exception."""
    try:
        return function(*args)
    except NotImplementedError as error:
        if error.args or not is_blank(getattr(made_by, name, None)):
            error.add_note(f"in {where}")
            raise
        own = [getattr(made_by, each) for each in dir(made_by) if not each.startswith("__")]
        if all(is_blank(each) for each in own if callable(each)):
            raise NotImplementedError from None
        raise NotImplementedError(f"{made_by.__name__}.{name} is not written yet") from None
    except Exception as error:
        error.add_note(f"in {where}")
        raise


def is_blank(function: Any) -> bool:
    """Return whether a function is still unwritten: it ends in `raise NotImplementedError`."""
    code = getattr(function, "__code__", None)
    if code is None or "NotImplementedError" not in code.co_names:
        return False
    return not any(each.opname.startswith("RETURN") for each in dis.get_instructions(code))


def _copy(value: Any, where: str) -> Any:
    """Copy an answer as it is now, because the next call may change the array that this call returned."""
    try:
        return decode(encode(value))
    except CodecError as error:
        raise Unsendable(
            f"{where}: {error}; return numbers, arrays, lists or one of the course's values, not an object of a class "
            "of your own"
        ) from None


# --- their comparison ---


@register
@dataclass(frozen=True)
class Methods(Comparison):
    """Comparison of the results of the driver `methods`, call by call.

    If the reference returns None, only None is right. Such a method is judged by the results of later calls.

    Parameters
    ----------
    by : dict of str to Comparison
        Comparison of each method's answers, by its name.
    default : Comparison
        Comparison of all other methods' answers.
    """

    by: Mapping[str, Comparison] = field(default_factory=dict)
    default: Comparison = field(default_factory=Close)

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare (name, answer) of each call with the expected ones; the first difference is reported."""
        case = calls(*(name for name, _ in expected))
        return self.judge(replace(case, expected=expected), got)

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Judge each call's answer by its method's comparison, which finds the call's arguments in its case."""
        if not _is_of(case.expected, answer):
            return Verdict("type", "the answers of your methods could not be read")
        turns = zip(_in_turn(case.expected, answer), case.args[1], strict=True)
        for (where, name, one, other), (_, args) in turns:
            of_call = Case(args, expected=one)
            verdict = self._of(name).judge(of_call, other) if one is not None else _nothing(name, other)
            if name.startswith(".") and other is None and one is not None:
                return Verdict("nothing", f"{where}: self.{where} is None; expected {with_article(one)}")
            if not verdict:
                return replace(verdict, text=f"{where}: {verdict.text}", at=())
        return RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether each call's answer is the same wrong answer as a mistake's."""
        return _is_of(answer, got) and all(
            self._of(name).alike(one, other) if one is not None else other is None
            for _, name, one, other in _in_turn(answer, got)
        )

    def _of(self, name: str) -> Comparison:
        return self.by.get(name, self.default)


def _is_of(expected: Any, got: Any) -> bool:
    """Return whether the answers belong to these calls; they may not be trusted."""
    if not isinstance(got, list) or not isinstance(expected, list) or len(got) != len(expected):
        return False
    pairs = zip(expected, got, strict=True)
    return all(isinstance(other, tuple) and len(other) == 2 and other[0] == one[0] for one, other in pairs)


def _in_turn(expected: Any, got: Any) -> Iterator[tuple[str, str, Any, Any]]:
    """Yield each call's description, its method's name, the expected answer and the answer."""
    count: Counter[str] = Counter()
    for (name, one), (_, other) in zip(expected, got, strict=True):
        count[name] += 1
        yield name[1:] if name.startswith(".") else f"{name}, call {count[name]}", name, one, other


def _nothing(name: str, got: Any) -> Verdict:
    if got is None:
        return RIGHT
    wanted = f"{name[1:]} should be None here" if name.startswith(".") else "this method returns nothing"
    return Verdict("type", f"your answer is {with_article(got)}; {wanted}")
