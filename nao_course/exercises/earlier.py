"""Functions of earlier lessons in later lessons, and recorded calls that replace them.

A lesson's set-up cell contains ``color_labels = earlier("01:color_labels")``. The code that loads the notebook decides
whether that is the student's own function, the function that was handed in, or the reference's function.
"""

from __future__ import annotations

import ast
import hashlib
import inspect
from collections.abc import Callable, Collection, Hashable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.codec import CodecError, decode, encode, register
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.lesson_names import number_of
from nao_course.exercises.library_functions import IN_LIBRARY

NAME = "earlier"  # of the function that a set-up cell calls
MOST_MISSED = 1000  # calls without a recorded answer that are remembered
MOST_NUMBERS = 1000  # in one argument of a function of the library that replaces a student's


class EarlierNotUsable(RuntimeError):  # noqa: N818 - it reads as a sentence
    """A function of an earlier lesson that cannot be used; the message says which and why."""


def split_use(use: str) -> tuple[str, str]:
    """Split the name of a used function into lesson and exercise; an empty lesson is the same lesson.

    >>> split_use("1:color_labels"), split_use("hue_mask")
    (('01', 'color_labels'), ('', 'hue_mask'))
    """
    lesson, _, name = use.rpartition(":")
    return number_of(lesson).zfill(2) if lesson else "", name


def in_words(use: str) -> str:
    """Describe a used function for a student: "color_labels of your lesson 01".

    >>> in_words("01:color_labels"), in_words("hue_mask")
    ('color_labels of your lesson 01', 'hue_mask')
    """
    lesson, name = split_use(use)
    return f"{name} of your lesson {lesson}" if lesson else name


def not_usable(use: str, why: str = "") -> Callable[[], Any]:
    """Return a function that raises EarlierNotUsable with the reason."""
    sentence = f"{in_words(use)} is not usable yet{f': {why}' if why else '.'}"

    def find() -> Any:
        raise EarlierNotUsable(sentence)

    return find


def assigned_use(statement: ast.stmt) -> tuple[str, str] | None:
    """Return name and use of a statement ``name = earlier("01:name")``; None for any other statement."""
    match statement:
        case ast.Assign(
            [ast.Name(name)],
            ast.Call(ast.Name("earlier") | ast.Attribute(_, "earlier"), [ast.Constant(str(use))]),
        ):
            return name, use
    return None


@dataclass(frozen=True)
class EarlierFunction:
    """A function of an earlier lesson, such as "01:color_labels", which is looked up at each call.

    `find` returns the function, or raises EarlierNotUsable.
    """

    use: str
    find: Callable[[], Callable[..., Any]] = field(repr=False)

    @property
    def __name__(self) -> str:
        """The function's name."""
        return split_use(self.use)[1]

    def __str__(self) -> str:
        """Describe the function: "color_labels of your lesson 01"."""
        return in_words(self.use)

    def __mro_entries__(self, bases: tuple[Any, ...]) -> tuple[Any, ...]:
        """Raise the reason why there is no class to derive from."""
        return (self.find(),)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call the function; if it is not usable, return the answer that a check has recorded, if any."""
        calls = _CALLS.get()
        token = _CALLS.set(None)  # calls inside the function are not recorded
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
    """Return an `EarlierFunction`, or the class itself, so that it can be a base class.

    `help`, ``?`` and Shift-Tab show it like `like`, a function with the same signature and docstring, which is used if
    the student's is blank or wrong, but without its source.
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
    # Raises the reason if it is used as a base class
    vars(function)["__mro_entries__"] = earlier.__mro_entries__
    return function


_RESOLVER: ContextVar[Callable[[str], Any] | None] = ContextVar("resolver", default=None)


@contextmanager
def resolved_by(resolver: Callable[[str], Any]) -> Iterator[None]:
    """Use a resolver for all functions of earlier lessons in the block: it returns the function of "01:name"."""
    token = _RESOLVER.set(resolver)
    try:
        yield
    finally:
        _RESOLVER.reset(token)


def is_resolved() -> bool:
    """Return whether a replacement for earlier functions has been chosen here."""
    return _RESOLVER.get() is not None


# --- recorded calls ---


@register
@dataclass(frozen=True)
class EarlierCall:
    """A call of an earlier lesson's function, such as "01:color_labels", that the reference makes in a public case.

    `given` are the arguments by the names of the parameters, which are in their order, and `answer` is the returned
    value.
    """

    use: str
    parameters: list[str]
    given: dict[str, Any]
    answer: Any


@dataclass
class Calls:
    """Calls of earlier functions while a block runs: known calls are answered, and new calls are recorded.

    `known` calls replace functions that are not usable, and `answered` says why they were not. They also replace the
    usable functions in `replaced`. If `keep`, calls of usable functions are recorded in `made`; `missed` has the
    digests of calls that no recorded call answers, and `called` the usable functions that were called.
    """

    known: Sequence[EarlierCall] = ()
    made: list[EarlierCall] = field(default_factory=list)
    answered: dict[str, str] = field(default_factory=dict)
    keep: bool = False
    replaced: frozenset[str] = frozenset()
    missed: set[bytes] = field(default_factory=set, init=False, repr=False)
    called: dict[str, Callable[..., Any]] = field(default_factory=dict, init=False, repr=False)

    def record(
        self, use: str, function: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> Any:
        """Call a function and record the call; a call that cannot be sent is not recorded."""
        if use in self.replaced and (answered := self.reference(use, args, kwargs)):
            return answered.answer
        self.called[use] = function
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
        """Return the reference's answer to a call, or raise EarlierNotUsable if it is not known for these inputs.

        Raise a TypeError if the function does not have these arguments.
        """
        if answered := self.reference(use, args, kwargs):
            self.answered[use] = str(reason)
            return answered.answer
        parameters = self.parameters(use)
        signature = f"{split_use(use)[1]}({', '.join(parameters)})"
        if parameters and (len(args) > len(parameters) or not set(kwargs) <= set(parameters)):
            raise TypeError(f"{signature} does not take the arguments that your code gives it")
        left = set(parameters[len(args) :]) - set(kwargs)
        # The reference omits only arguments that have a default value.
        if missing := left.intersection(*(each.given for each in self.known if each.use == use)):
            raise TypeError(f"your code calls {signature} without {' and '.join(sorted(missing))}")
        raise EarlierNotUsable(
            f"Your code calls {in_words(use)} with an input for which no answer was recorded. Either something before "
            f"that call is wrong, or you need the function itself: {reason}"
        ) from None

    def reference(self, use: str, args: tuple[Any, ...], kwargs: dict[str, Any]) -> EarlierCall | None:
        """Return the call with the reference's answer, recorded or by a function of the library, if there is one."""
        # The library's answers differ in the last bit. They come second, because later calls are found faster if their
        # inputs are exactly the recorded ones.
        found = self.find(use, args, kwargs, exactly=use in IN_LIBRARY) or self.in_library(use, args, kwargs)
        return found and replace(found, answer=decode(encode(found.answer)))

    def in_library(self, use: str, args: tuple[Any, ...], kwargs: dict[str, Any]) -> EarlierCall | None:
        """Return the call with the answer of a function of the library that is the same, if there is one."""
        parameters = self.parameters(use)
        given = dict(zip(parameters, args, strict=False)) | kwargs
        if use not in IN_LIBRARY or len(args) > len(parameters) or given.keys() != set(parameters):
            return None
        values = [given[name] for name in parameters]
        if any(np.size(value) > MOST_NUMBERS for value in values):
            return None
        return EarlierCall(use, parameters, given, IN_LIBRARY[use](*values))

    def parameters(self, use: str) -> list[str]:
        """Return the names of a recorded function's parameters; none if it is not recorded."""
        return next((each.parameters for each in self.known if each.use == use), [])

    def find(
        self, use: str, args: tuple[Any, ...], kwargs: dict[str, Any], *, exactly: bool = False
    ) -> EarlierCall | None:
        """Return the recorded call with these inputs, if there is one; `exactly` these, or these up to rounding.

        The same inputs are found by a digest; only new ones are compared with every recorded call, because a
        student's code may call a function thousands of times.
        """
        try:
            exact = _digest(use, list(args), sorted(kwargs.items()))
        except (CodecError, TypeError):
            return None
        if exact in self.by_inputs:
            return self.by_inputs[exact]
        if exactly or exact in self.missed:
            return None
        parameters = self.parameters(use)
        given = dict(zip(parameters, args, strict=False)) | kwargs
        for each in self._near(use, given) if len(args) <= len(parameters) else ():
            if _same(each.given, given):
                self.by_inputs[exact] = each
                return each
        if len(self.missed) < MOST_MISSED:
            self.missed.add(exact)
        return None

    @cached_property
    def by_inputs(self) -> dict[bytes, EarlierCall]:
        """The recorded calls by the digest of their inputs, all given by position."""
        found = {}
        for each in self.known:
            if list(each.given) == each.parameters[: len(each.given)]:
                found[_digest(each.use, list(each.given.values()), [])] = each
        return found

    def _near(self, use: str, given: dict[str, Any]) -> list[EarlierCall]:
        """Return the recorded calls of a function with nearly these numbers; all its calls if these are not numbers."""
        key, numbers = _as_numbers(use, given)
        if numbers is None:
            return [each for each in self.known if each.use == use]
        calls, rows = self._by_shapes.get(key, ([], np.zeros((0, len(numbers)))))
        near = np.isclose(rows, numbers, rtol=1e-6, atol=1e-6, equal_nan=True).all(axis=1)
        return [calls[i] for i in np.flatnonzero(near)]

    @cached_property
    def _by_shapes(self) -> dict[Hashable, tuple[list[EarlierCall], npt.NDArray[Any]]]:
        """The recorded calls whose inputs are numbers, and these numbers in a row for each call, by their shapes."""
        found: dict[Hashable, tuple[list[EarlierCall], list[npt.NDArray[Any]]]] = {}
        for each in self.known:
            key, numbers = _as_numbers(each.use, each.given)
            if numbers is not None:
                calls, rows = found.setdefault(key, ([], []))
                calls.append(each)
                rows.append(numbers)
        return {key: (calls, np.stack(rows)) for key, (calls, rows) in found.items()}


_CALLS: ContextVar[Calls | None] = ContextVar("calls", default=None)


@contextmanager
def watching(
    known: Sequence[EarlierCall] = (), *, keep: bool = False, replaced: Collection[str] = ()
) -> Iterator[Calls]:
    """Answer or record the calls of earlier functions in the block; known calls replace some usable functions, too."""
    calls = Calls(known, keep=keep, replaced=frozenset(replaced))
    token = _CALLS.set(calls)
    try:
        yield calls
    finally:
        _CALLS.reset(token)


def _as_numbers(use: str, given: dict[str, Any]) -> tuple[Hashable, npt.NDArray[Any] | None]:
    """Return a call's names and shapes, and all its numbers in one array; None if an input is not numbers."""
    names = sorted(given)
    try:
        values = [np.asarray(given[name], dtype=float) for name in names]
    except (TypeError, ValueError):
        return use, None
    numbers = np.concatenate([np.zeros(0), *map(np.ravel, values)])
    return (use, *names, *(value.shape for value in values)), numbers


def _digest(use: str, args: list[Any], kwargs: list[tuple[str, Any]]) -> bytes:
    """Return a digest of a call's inputs, which equal inputs share."""
    return hashlib.sha256(encode((use, args, kwargs))).digest()


def _same(recorded: dict[str, Any], given: dict[str, Any]) -> bool:
    """Return whether two calls are the same up to rounding."""
    try:
        return bool(Close(rtol=1e-9, atol=1e-12).compare(recorded, decode(encode(given))))
    except CodecError:
        return False
