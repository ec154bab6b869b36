"""A case: one call of a student's function with the expected outcome."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from nao_course.codec import decode, encode, register


def copied(value: Any) -> Any:
    """Return a copy of an array, and any other value unchanged."""
    return value.copy() if isinstance(value, np.ndarray) else value


@register
@dataclass(frozen=True)
class Case:
    """One call of a student's function.

    Parameters
    ----------
    args : tuple
        Positional arguments; each call receives its own copies.
    name : str
        Description of the case for the student: "a grey pixel".
    kwargs : dict
        Keyword arguments.
    expected : object
        Interval (low, high) for `Between`. Otherwise it is omitted, and the reference's answer is expected.
    raises : str
        Name of the exception that the call must raise, or of its base class: "ValueError". Then no answer is right.
    """

    args: tuple[Any, ...]
    name: str = ""
    kwargs: dict[str, Any] = field(default_factory=dict)
    expected: Any = None
    raises: str = ""

    @property
    def part(self) -> str:
        """The part of the exercise that the case tests: "move" if its name is "move: a turn", else an empty text."""
        part, colon, _ = self.name.partition(": ")
        return part if colon else ""

    @cached_property
    def frame(self) -> bytes:
        """The arguments and keyword arguments, encoded: a case is sent to many workers."""
        return encode((self.args, self.kwargs))

    def fresh(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """Return copies of the arguments, which the function may change."""
        args, kwargs = decode(self.frame)
        return args, kwargs
