"""Comparisons that are made of others, and laws that an answer has to obey."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any

import numpy as np

from nao_course.exercises.case import Case
from nao_course.exercises.codec import register
from nao_course.exercises.codec.sparse import is_sparse
from nao_course.exercises.comparisons.comparison import RIGHT, Comparison, Verdict, with_article
from nao_course.exercises.comparisons.structure import as_numbers, parts_of
from nao_course.exercises.comparisons.values import Close, most_pairs

MOST_MORE = 1000  # numbers that an answer may have beside four times those of the reference's
Law = Callable[[tuple[Any, ...], dict[str, Any], Any], str]


@register
@dataclass(frozen=True)
class Property(Comparison):
    """A law that the answer has to obey, whatever the reference answers: P is symmetric, H delta = -b.

    Parameters
    ----------
    law : callable
        ``law(args, kwargs, answer) -> str``: nothing where the answer obeys it, else what is wrong, as a public case
        tells the student; of a hidden case no word of it is told. A function of a module, with `register` before it. It
        gets any answer that is not far larger than the reference's, an array where the reference returns one and the
        answer is lists of numbers; where it raises, the answer is of the wrong kind.
    """

    law: Law

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Judge an answer by a law that looks at no inputs."""
        return self.judge(Case((), expected=expected), got)

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Judge an answer by the law."""
        if answer is None:
            return Verdict("nothing", "your answer is None: a return may be missing")
        if _size(answer) > 4 * _size(case.expected) + MOST_MORE:
            return Verdict("type", f"your answer is {with_article(answer)} with far too many numbers")
        if isinstance(case.expected, np.ndarray) and isinstance(answer, list | tuple):
            answer = as_numbers(answer, "your answer", also="c")
            if isinstance(answer, Verdict):
                return answer
        args, kwargs = case.fresh()
        try:
            with np.errstate(all="ignore"):
                wrong = self.law(args, kwargs, answer)
        except Exception:  # noqa: BLE001 - what a stranger answers may be anything
            return Verdict(
                "type", f"your answer is {with_article(answer)} that the check can do nothing with"
            )
        return Verdict("law", wrong) if wrong else RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether an answer is the same wrong one as a mistake's."""
        return Close().alike(answer, got)


@register
@dataclass(frozen=True)
class All(Comparison):
    """Several comparisons of one answer; the first that it fails is told.

    Parameters
    ----------
    comparisons : tuple of Comparison
        ``All((Close(mask="upper"), Property(symmetric)))``.
    """

    comparisons: tuple[Comparison, ...]

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""
        return self.judge(Case((), expected=expected), got)

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Judge an answer by each."""
        return next(
            (verdict for each in self.comparisons if not (verdict := each.judge(case, answer))), RIGHT
        )

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether an answer is the same wrong one as a mistake's."""
        return all(each.alike(answer, got) for each in self.comparisons)

    def expects(self, case: Case, answer: Any) -> Any:
        """What the first expects that takes it from the case; else the reference's answer."""
        found = (each.expects(case, answer) for each in self.comparisons)
        return next((each for each in found if each is not answer), answer)


@register
@dataclass(frozen=True)
class Each(Comparison):
    """A comparison of its own for each value of a tuple, list, dict or dataclass.

    Parameters
    ----------
    comparisons : tuple of Comparison, or dict
        By position, or by key or field; values that it does not name are compared with Close().
    """

    comparisons: tuple[Comparison, ...] | Mapping[Any, Comparison]

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""
        return self.judge(Case((), expected=expected), got)

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Judge each value by its own comparison."""
        return next((verdict for verdict in self._verdicts(case, answer) if not verdict), RIGHT)

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether an answer is the same wrong one as a mistake's."""
        parts, have = parts_of(answer), parts_of(got)
        if parts is None or have is None or set(parts) != set(have):
            return Close().alike(answer, got)
        pairs = zip(self._for(answer, len(parts)), parts, strict=True)
        return all(each.alike(parts[name], have[name]) for each, name in pairs)

    def _verdicts(self, case: Case, answer: Any) -> Iterator[Verdict]:
        parts = parts_of(case.expected)
        if parts is not None and isinstance(answer, np.ndarray) and answer.shape[:1] == (len(parts),):
            answer = tuple(answer)
        have = parts_of(answer)
        of_a_kind = isinstance(case.expected, dict) or is_dataclass(case.expected)
        mixed = of_a_kind and type(answer) is not type(case.expected)
        if parts is None or have is None or mixed or set(parts) != set(have):
            yield _not_of(case.expected, parts, answer)
            return
        for each, name in zip(self._for(case.expected, len(parts)), parts, strict=True):
            yield _about(each.judge(replace(case, expected=parts[name]), have[name]), name)

    def _for(self, value: Any, count: int) -> list[Comparison]:
        """The comparison of each value."""
        if isinstance(self.comparisons, Mapping):
            keys: list[Any] = list(range(count))
            if isinstance(value, dict):
                keys = list(value)
            elif is_dataclass(value):
                keys = [each.name for each in fields(value)]
            return [self.comparisons.get(key, Close()) for key in keys]
        given = list(self.comparisons[:count])
        return given + [Close()] * (count - len(given))


@register
@dataclass(frozen=True)
class Unordered(Comparison):
    """Values in any order: of a list or tuple, the rows of an array, the values of a dict whatever their keys.

    Each expected value gets one of the answer's for itself, so that as few as can be are left over.

    Parameters
    ----------
    comparison : Comparison
        Of two values.
    """

    comparison: Comparison = field(default_factory=Close)

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""
        return self.judge(Case((), expected=expected), got)

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Find as many partners as can be."""
        if answer is None:
            return Verdict("nothing", "your answer is None: a return may be missing")
        wanted, have = _members(case.expected), _members(answer)
        if wanted is None or have is None or isinstance(answer, dict) != isinstance(case.expected, dict):
            return _not_of(case.expected, parts_of(case.expected), answer)
        shapes = [each.shape for each in (case.expected, answer) if isinstance(each, np.ndarray)]
        if len(shapes) == 2 and shapes[0][1:] != shapes[1][1:]:
            return Verdict("shape", f"your answer has shape {shapes[1]}; rows of {shapes[0][1:]} are wanted")
        if len(have) != len(wanted):
            return Verdict("value", f"your answer has {len(have)} values, which is not the right number")
        missed = self._missed(case, wanted, have)
        if missed:
            return Verdict("value", f"{missed} of the {len(have)} values of your answer have no right place")
        return RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether an answer is the same wrong one as a mistake's."""
        if _members(answer) is None or _members(got) is None:
            return Close().alike(answer, got)
        return bool(self.compare(answer, got))

    def _missed(self, case: Case, wanted: list[Any], have: list[Any]) -> int:
        fits = np.zeros((len(wanted), len(have)), dtype=bool)
        for i, expected in enumerate(wanted):
            part = replace(case, expected=expected)
            fits[i] = [bool(self.comparison.judge(part, each)) for each in have]
        return len(wanted) - most_pairs(fits)


def _size(value: Any) -> int:
    """How many numbers, texts and the like a value is made of; of a sparse matrix, zeros count, too."""
    if isinstance(value, np.ndarray) or is_sparse(type(value)):
        return math.prod(value.shape)
    parts = parts_of(value)
    if parts is None:
        return len(value) if isinstance(value, str | bytes) else 1
    return sum(map(_size, parts.values())) + 1


def _members(value: Any) -> list[Any] | None:
    if isinstance(value, dict):
        return list(value.values())
    if isinstance(value, tuple | list) or (isinstance(value, np.ndarray) and value.ndim):
        return list(value)
    return None


def _not_of(expected: Any, parts: dict[str, Any] | None, answer: Any) -> Verdict:
    if answer is None:
        return Verdict("nothing", "your answer is None: a return may be missing")
    wanted = with_article(expected) + (f" of {len(parts)} values" if parts is not None else "")
    have = parts_of(answer)
    size = f" of {len(have)}" if have is not None else ""
    return Verdict("type", f"your answer is {with_article(answer)}{size}; {wanted} is wanted")


def _about(verdict: Verdict, name: str) -> Verdict:
    """A verdict on a part, said of the whole."""
    return replace(verdict, text=verdict.text.replace("your answer", f"{name} of your answer"))
