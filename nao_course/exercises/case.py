"""A case: one call of a student's function, with what is expected of it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from nao_course.exercises.codec import decode, encode, register


def copied(value: Any) -> Any:
    """Return an array's copy, and anything else as it is: what a function is given that may change its arguments."""
    return value.copy() if isinstance(value, np.ndarray) else value


@register
@dataclass(frozen=True)
class Case:
    """One call of a student's function.

    Parameters
    ----------
    args : tuple
        Its arguments; each call gets copies of its own.
    name : str
        What the case is about, in a few words for the student: "a grey pixel".
    kwargs : dict
        Its keyword arguments.
    expected : object
        For `Between`, (low, high). Else left out: the reference's answer is expected.
    raises : str
        Name of the exception that the call must raise, or of a class of it: "ValueError". Then no answer is right.
    """

    args: tuple[Any, ...]
    name: str = ""
    kwargs: dict[str, Any] = field(default_factory=dict)
    expected: Any = None
    raises: str = ""

    def fresh(self) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """Copies of the arguments that the function may do with what it likes."""
        args, kwargs = decode(encode((self.args, self.kwargs)))
        return args, kwargs
