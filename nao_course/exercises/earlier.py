"""Functions of earlier lessons: what stands for one in a later lesson, and recorded calls that answer in its place.

A lesson's set-up cell says ``color_labels = earlier("01:color_labels")``. Who loads a notebook says what that means:
the student's own function, the one that was handed in, or the reference's.
"""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from typing import Any

from nao_course.exercises.codec import CodecError, decode, encode, register
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.lesson_names import number_of

NAME = "earlier"  # of the function that a set-up cell calls


class EarlierNotUsable(RuntimeError):  # noqa: N818 - it reads as a sentence
    """A function of an earlier lesson that cannot be used; the message says which and why."""


def split_use(use: str) -> tuple[str, str]:
    """Return lesson and exercise of what an exercise uses: an empty lesson is its own.

    Examples
    --------
    >>> split_use("1:color_labels"), split_use("hue_mask")
    (('01', 'color_labels'), ('', 'hue_mask'))
    """
    lesson, _, name = use.rpartition(":")
    return number_of(lesson).zfill(2) if lesson else "", name


def in_words(use: str) -> str:
    """Name what an exercise uses, for a student: "color_labels of your lesson 01".

    Examples
    --------
    >>> in_words("01:color_labels"), in_words("hue_mask")
    ('color_labels of your lesson 01', 'hue_mask')
    """
    lesson, name = split_use(use)
    return f"{name} of your lesson {lesson}" if lesson else name


def not_usable(use: str, why: str = "") -> Callable[[], Any]:
    """Return what raises the sentence that says why an earlier function is not usable."""
    sentence = f"{in_words(use)} is not usable yet{f': {why}' if why else '.'}"

    def find() -> Any:
        raise EarlierNotUsable(sentence)

    return find


def assigned_use(statement: ast.stmt) -> tuple[str, str] | None:
    """Return name and use of a statement ``name = earlier("01:name")``; None for any other."""
    match statement:
        case ast.Assign(
            [ast.Name(name)],
            ast.Call(ast.Name("earlier") | ast.Attribute(_, "earlier"), [ast.Constant(str(use))]),
        ):
            return name, use
    return None


@dataclass(frozen=True)
class EarlierFunction:
    """Stands for a function of an earlier lesson: calling it calls that function.

    Parameters
    ----------
    use : str
        Which: "01:color_labels".
    find : callable
        Returns the function, or raises EarlierNotUsable; asked at each call.
    """

    use: str
    find: Callable[[], Callable[..., Any]] = field(repr=False)

    @property
    def __name__(self) -> str:
        """The function's name."""
        return split_use(self.use)[1]

    def __str__(self) -> str:
        """In words: "color_labels of your lesson 01"."""
        return in_words(self.use)

    def __mro_entries__(self, bases: tuple[Any, ...]) -> tuple[Any, ...]:
        """Say why there is no class to derive one from."""
        return (self.find(),)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call it; where it is not usable, a check may have recorded what it would answer."""
        calls = _CALLS.get()
        token = _CALLS.set(None)  # what the function itself uses is its own affair
        try:
            resolver = _RESOLVER.get()
            function = resolver(self.use) if resolver else self.find()
            return calls.record(self.use, function, args, kwargs) if calls else function(*args, **kwargs)
        except EarlierNotUsable as reason:
            if calls is None:
                raise
            return calls.answer(self.use, args, kwargs, reason)
        finally:
            _CALLS.reset(token)


def stand_in(use: str, find: Callable[[], Any], like: Any = None) -> Any:
    """Return what stands for an earlier function; a class is handed on itself, so that it can be a base class.

    Parameters
    ----------
    use : str
        Which: "01:color_labels".
    find : callable
        Returns the function, or raises EarlierNotUsable; asked at each call.
    like : callable, optional
        What has its signature and docstring where it is not usable: one that is blank or wrong.

    Returns
    -------
    callable
        A function that `help`, ``?`` and Shift-Tab show as the one that it stands for, without that one's source.
    """
    with suppress(EarlierNotUsable):
        like = find()
        if isinstance(like, type):
            return like
    return _looking_like(like, EarlierFunction(use, find))


def _looking_like(like: Any, earlier: EarlierFunction) -> Callable[..., Any]:
    """Return a function that calls another and has the signature and docstring of a third, if it has any."""

    def function(*args: Any, **kwargs: Any) -> Any:
        return earlier(*args, **kwargs)

    said = "" if like is None else inspect.getdoc(like) or ""
    function.__name__ = function.__qualname__ = earlier.__name__
    function.__doc__ = f"{said}\n\nThis is {earlier}.".strip()
    with suppress(TypeError, ValueError):
        vars(function)["__signature__"] = inspect.signature(like)
    vars(function)["__mro_entries__"] = (
        earlier.__mro_entries__
    )  # where it stands for a class, to say why there is none
    return function


_RESOLVER: ContextVar[Callable[[str], Any] | None] = ContextVar("resolver", default=None)


@contextmanager
def resolved_by(resolver: Callable[[str], Any]) -> Iterator[None]:
    """Let all that stands for earlier functions, in declarations too, mean what a resolver returns for "01:name"."""
    token = _RESOLVER.set(resolver)
    try:
        yield
    finally:
        _RESOLVER.reset(token)


def is_resolved() -> bool:
    """Whether somebody has said what stands for earlier functions here."""
    return _RESOLVER.get() is not None


# --- recorded calls ---


@register
@dataclass(frozen=True)
class EarlierCall:
    """A call of an earlier lesson's function that the reference makes in a public case.

    Parameters
    ----------
    use : str
        Which function: "01:color_labels".
    parameters : list of str
        Names of its parameters, in their order.
    given : dict of str to object
        What it was called with, by the parameters' names.
    answer : object
        What it returned.
    """

    use: str
    parameters: list[str]
    given: dict[str, Any]
    answer: Any


@dataclass
class Calls:
    """Calls of earlier functions while a block runs: known ones answer, and those that are made are kept.

    Parameters
    ----------
    known : sequence of EarlierCall
        What is answered in the place of functions that are not usable.
    made : list of EarlierCall
        Calls of usable functions, where they are wanted.
    answered : dict of str to str
        What was answered from `known`, and why that was needed.
    keep : bool
        Whether `made` is wanted.
    """

    known: Sequence[EarlierCall] = ()
    made: list[EarlierCall] = field(default_factory=list)
    answered: dict[str, str] = field(default_factory=dict)
    keep: bool = False

    def record(
        self, use: str, function: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> Any:
        """Call a function and keep the call; one that cannot be sent is not kept."""
        if not self.keep:
            return function(*args, **kwargs)
        given = None
        with suppress(CodecError, TypeError, ValueError):
            signature = inspect.signature(function)
            given = decode(encode(dict(signature.bind(*args, **kwargs).arguments)))
        answer = function(*args, **kwargs)
        if given is not None:
            with suppress(CodecError):
                self.made.append(EarlierCall(use, list(signature.parameters), given, decode(encode(answer))))
        return answer

    def answer(
        self, use: str, args: tuple[Any, ...], kwargs: dict[str, Any], reason: EarlierNotUsable
    ) -> Any:
        """Return what was recorded for a call.

        Raises
        ------
        EarlierNotUsable
            If there is none with these inputs.
        """
        for each in self.known:
            given = dict(zip(each.parameters, args, strict=False)) | kwargs
            if each.use == use and len(args) <= len(each.parameters) and _same(each.given, given):
                self.answered[use] = str(reason)
                return decode(encode(each.answer))
        raise EarlierNotUsable(
            f"{reason} It is asked for something that no answer was recorded of."
        ) from None


_CALLS: ContextVar[Calls | None] = ContextVar("calls", default=None)


@contextmanager
def watching(known: Sequence[EarlierCall] = (), *, keep: bool = False) -> Iterator[Calls]:
    """Answer, or keep, the calls of earlier functions that are made in the block."""
    calls = Calls(known, keep=keep)
    token = _CALLS.set(calls)
    try:
        yield calls
    finally:
        _CALLS.reset(token)


def _same(recorded: dict[str, Any], given: dict[str, Any]) -> bool:
    """Whether two calls are one, but for rounding."""
    try:
        return bool(Close(rtol=1e-9, atol=1e-12).compare(recorded, decode(encode(given))))
    except CodecError:
        return False
