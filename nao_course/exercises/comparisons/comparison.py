"""What a comparison is: it makes the calls that a case needs, and says how an answer differs from what is expected."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from nao_course.exercises.case import Case

Kind = Literal["right", "nothing", "type", "shape", "nan", "value", "law", "no error"]


@dataclass(frozen=True)
class Verdict:
    """What a comparison found.

    Parameters
    ----------
    kind : str
        "right", or in which way the answer differs.
    text : str
        For the student: what came out, never what was expected to.
    at : tuple of int
        Index of the first element of an array that differs; empty where there is none.
    """

    kind: Kind
    text: str = ""
    at: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        """Whether the answer is right."""
        return self.kind == "right"


RIGHT = Verdict("right")


class Comparison(ABC):
    """How an exercise's answers are compared. It runs where the judging is done, never where the answers come from."""

    @abstractmethod
    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Compare an answer with what a case expects; a comparison that needs the case's inputs finds them there."""
        return self.compare(case.expected, answer)

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether an answer is the same wrong one as a mistake's."""
        return bool(self.compare(answer, got))

    def expects(self, case: Case, answer: Any) -> Any:
        """What a case expects, given the reference's answer to it: that answer, but for what a declaration says."""
        return answer

    def calls(self, case: Case) -> Sequence[Case]:
        """The calls to make for a case: more than itself for a function whose answers are random."""
        return (case,)

    def gather(self, case: Case, answers: Iterable[Any]) -> Any:
        """What is compared: made of the answers to a case's calls, as they come. It must not raise, whatever they are.

        Take all of them, and keep of each what is compared: a stranger's answers may be large, and many.
        """
        first = next(iterator := iter(answers))
        for _ in iterator:
            pass
        return first


def with_article(value: Any) -> str:
    """Name a value's type, with its article."""
    if value is None:
        return "None"
    kind = type(value).__name__
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


def as_text(value: Any) -> str:
    """Write a number as a student is told it."""
    if isinstance(value, complex | np.complexfloating):
        return f"{complex(value):.6g}"
    return str(value) if isinstance(value, np.bool_) else f"{float(value):.6g}"
