"""Comparisons that combine other comparisons, and properties that an answer must have."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import Any

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.codec import register
from nao_course.codec.sparse import is_sparse
from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import RIGHT, Comparison, Verdict, with_article
from nao_course.exercises.comparisons.structure import as_numbers, parts_of
from nao_course.exercises.comparisons.values import Close, most_pairs

MOST_MORE = 1000  # numbers that an answer may have in addition to four times the reference's
Law = Callable[[tuple[Any, ...], dict[str, Any], Any], str]


@register
@dataclass(frozen=True)
class Property(Comparison):
    """A property that every right answer has, independent of the reference: P is symmetric, H delta = -b.

    Parameters
    ----------
    law : callable
        ``law(args, kwargs, answer) -> str``: an empty text if the answer obeys the law, otherwise a sentence for the
        student, which only public cases show. It is a function of a module, decorated with `register`. It gets every
        answer that is not far larger than the reference's; lists of numbers become an array if the reference returns
        an array. If it raises, the answer has the wrong type.
    """

    law: Law

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Judge an answer by a law that does not use the inputs."""
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
            return Verdict("type", f"your answer is {with_article(answer)} that the check cannot use")
        return Verdict("law", wrong) if wrong else RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether an answer is the same wrong answer as a mistake's."""
        return Close().alike(answer, got)


@register
@dataclass(frozen=True)
class All(Comparison):
    """Several comparisons of one answer; the first comparison that fails is reported.

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
        """Judge an answer by each comparison."""
        return next(
            (verdict for each in self.comparisons if not (verdict := each.judge(case, answer))), RIGHT
        )

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether an answer is the same wrong answer as a mistake's: both obey a law, or neither does."""
        laws = [each for each in self.comparisons if isinstance(each, Property)]
        others = [each for each in self.comparisons if each not in laws]
        return all(each.alike(answer, got) for each in others or laws) and all(
            bool(each.compare(None, answer)) == bool(each.compare(None, got)) for each in laws
        )

    def expects(self, case: Case, answer: Any) -> Any:
        """Return what the first comparison takes from the case; otherwise the reference's answer."""
        found = (each.expects(case, answer) for each in self.comparisons)
        return next((each for each in found if each is not answer), answer)


@register
@dataclass(frozen=True)
class Each(Comparison):
    """A separate comparison for each value of a tuple, list, dict or dataclass.

    Parameters
    ----------
    comparisons : tuple of Comparison, or dict
        By position, or by key or field; all other values are compared with Close().
    names : tuple of str
        Names of the values of a tuple in messages, such as "the covariance"; without them, "value 2".
    """

    comparisons: tuple[Comparison, ...] | Mapping[Any, Comparison]
    names: tuple[str, ...] = ()

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""
        return self.judge(Case((), expected=expected), got)

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Judge each value by its own comparison."""
        return next((verdict for verdict in self._verdicts(case, answer) if not verdict), RIGHT)

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether an answer is the same wrong answer as a mistake's."""
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
        called = dict(zip(parts, self.names, strict=False))
        for each, name in zip(self._for(case.expected, len(parts)), parts, strict=True):
            verdict = each.judge(replace(case, expected=parts[name]), have[name])
            yield _about(verdict, called.get(name, name))

    def _for(self, value: Any, count: int) -> list[Comparison]:
        """Return the comparison for each value."""
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
    """Values in any order: the items of a list or tuple, the rows of an array, or the values of a dict.

    The expected values and the answer's are assigned to each other so that as few as possible remain.

    Parameters
    ----------
    comparison : Comparison
        Comparison of two values.
    """

    comparison: Comparison = field(default_factory=Close)

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""
        return self.judge(Case((), expected=expected), got)

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Assign as many values as possible."""
        if answer is None:
            return Verdict("nothing", "your answer is None: a return may be missing")
        wanted, have = _members(case.expected), _members(answer)
        if wanted is None or have is None or isinstance(answer, dict) != isinstance(case.expected, dict):
            return _not_of(case.expected, parts_of(case.expected), answer)
        shapes = [each.shape for each in (case.expected, answer) if isinstance(each, np.ndarray)]
        if len(shapes) == 2 and shapes[0][1:] != shapes[1][1:]:
            return Verdict(
                "shape", f"your answer has shape {shapes[1]}; expected rows of shape {shapes[0][1:]}"
            )
        if len(have) != len(wanted):
            return Verdict(
                "value", f"your answer has {say_count(len(have), 'value')}; expected {len(wanted)}"
            )
        missed = self._missed(case, wanted, have)
        if missed:
            return Verdict(
                "value", f"{missed} of {say_count(len(have), 'value')} of your answer match no expected value"
            )
        return RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether an answer is the same wrong answer as a mistake's."""
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
    """Count the elements of a value, including the zeros of a sparse matrix."""
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
    return Verdict("type", f"your answer is {with_article(answer)}{size}; expected {wanted}")


def _about(verdict: Verdict, name: str) -> Verdict:
    """Rewrite a verdict on a part so that it names the part."""
    return replace(verdict, text=verdict.text.replace("your answer", f"{name} of your answer"))
