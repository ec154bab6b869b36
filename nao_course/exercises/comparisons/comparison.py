"""Base class of comparisons, which make the calls of a case and compare the answer with the expected answer."""

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
    """The result of a comparison.

    Parameters
    ----------
    kind : str
        "right", or the kind of the difference.
    text : str
        Sentence for the student about the answer, which never contains the expected answer.
    at : tuple of int
        Index of the first element of an array that differs; empty if there is no such element.
    """

    kind: Kind
    text: str = ""
    at: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        """Return whether the answer is right."""
        return self.kind == "right"


RIGHT = Verdict("right")


class Comparison(ABC):
    """A comparison of an exercise's answers, which never runs in the process that computed them."""

    @abstractmethod
    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Compare an answer with a case's expected answer; subclasses may also use the case's inputs."""
        return self.compare(case.expected, answer)

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether an answer is the same wrong answer as a mistake's."""
        return bool(self.compare(answer, got))

    def expects(self, case: Case, answer: Any) -> Any:
        """Return a case's expected answer: the reference's answer unless the declaration gives another value."""
        return answer

    def calls(self, case: Case) -> Sequence[Case]:
        """Return the calls to make for a case: more than one for a function whose answers are random."""
        return (case,)

    def gather(self, case: Case, answers: Iterable[Any]) -> Any:
        """Combine the answers to a case's calls into the value that is compared. It must accept any answers.

        Consume all answers, but keep only the compared part of each, because untrusted answers may be many and large.
        """
        first = next(iterator := iter(answers))
        for _ in iterator:
            pass
        return first


def with_article(value: Any) -> str:
    """Return the name of a value's type with its article."""
    if value is None:
        return "None"
    kind = "array" if isinstance(value, np.ndarray) else type(value).__name__
    return f"an {kind}" if kind[0].lower() in "aeiou" else f"a {kind}"


def as_text(value: Any) -> str:
    """Format a number for a message to the student."""
    if isinstance(value, complex | np.complexfloating):
        return f"{complex(value):.6g}"
    return str(value) if isinstance(value, np.bool_) else f"{float(value):.6g}"
