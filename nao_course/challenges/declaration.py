"""A challenge and its results: the task, its cases, and the scores that an entry is compared with."""

from __future__ import annotations

import json
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray
from nao_course.plotting import Drawing


@dataclass(frozen=True)
class Column:
    """A number beside the score that shows how consistent or reliable the answers are, such as false detections.

    Parameters
    ----------
    name : str
        Heading of the column, and its key in `CaseScore.columns`.
    unit : str
        Unit after each number, such as " m" or " %".
    digits : int
        Number of decimals.
    """

    name: str
    unit: str = ""
    digits: int = 2

    def say(self, value: float | None) -> str:
        """Return a number with its unit; a dash without a number."""
        return "-" if value is None or not np.isfinite(value) else f"{value:z.{self.digits}f}{self.unit}"


@dataclass(frozen=True)
class CaseScore:
    """The score of an answer in one case.

    Parameters
    ----------
    score : float
        The score.
    columns : mapping of str to float
        Values of the board's other columns, by the names of `Challenge.columns`; the board shows their means.
    kept : object
        Data of the answer for the challenge's figure, in plain types.
    """

    score: float
    columns: Mapping[str, float] = field(default_factory=dict)
    kept: Any = None


@dataclass(frozen=True)
class Row:
    """A recorded row of the board, such as the score of the paper's method.

    Parameters
    ----------
    name : str
        Name of the method, such as "the paper's rule".
    score : float
        Total score.
    columns : mapping of str to float
        Values of the other columns.
    cases : tuple of float
        Score of each case, in the order of `Challenge.seeds`.
    """

    name: str
    score: float
    columns: Mapping[str, float] = field(default_factory=dict)
    cases: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Challenge:
    """An open task with a score on fixed cases, which is not graded.

    Parameters
    ----------
    lesson : str
        Name of the lesson, such as "01_hsl_filtering".
    title, task, scoring : str
        A headline, the task in a sentence, and an explanation of the score.
    seeds : sequence
        Seed of each case, of any type that `make` accepts.
    make : callable
        ``make(seed)`` returns a case's scene, which contains the inputs and the truth. It is called once per case, at
        first use.
    judge : callable
        ``judge(answer, scene)`` returns a `CaseScore`, or raises ValueError or TypeError with a sentence that explains
        why an answer is unusable.
    given : callable
        ``given(scene)`` returns the arguments of the student's function, without the truth; the function receives
        copies.
    figure : callable, optional
        ``figure(run)`` draws the worst cases.
    columns : tuple of Column
        Columns beside the score.
    rows : tuple of Row
        Recorded rows: no answer, the paper's method, the reference.
    nothing : float
        Score of a case without a usable answer.
    higher_is_better : bool
        False for a cost or an error.
    total : callable
        Total score, computed from an array of the cases' scores; by default their mean.
    takes_values : bool
        Whether an entry may be the answer itself instead of a function that returns it.
    unit : str
        Unit of the score.
    digits : int
        Number of decimals of the score.
    case : str
        Noun for a case: "scene", "robot".
    sampled : bool
        Whether the cases are a random sample, so that a difference between two scores may be chance.
    name_of : callable
        ``name_of(seed)`` returns the name of a case.
    version : int
        Version of the scoring: a best score of another version is set aside, because it cannot be compared.
    seconds, seconds_in_all : float
        Longest run time of the student's function for one case, and for all cases.
    """

    lesson: str
    title: str
    task: str
    scoring: str
    seeds: Sequence[Hashable]
    make: Callable[[Any], Any]
    judge: Callable[[Any, Any], CaseScore]
    given: Callable[[Any], tuple[Any, ...]] = lambda scene: ()
    figure: Callable[[Run], Drawing] | None = None
    columns: tuple[Column, ...] = ()
    rows: tuple[Row, ...] = ()
    nothing: float = 0.0
    higher_is_better: bool = True
    total: Callable[[FloatArray], float] = lambda scores: float(np.mean(scores))
    takes_values: bool = False
    unit: str = ""
    digits: int = 2
    case: str = "scene"
    sampled: bool = True
    name_of: Callable[[Any], str] = str
    version: int = 1
    seconds: float = 5.0
    seconds_in_all: float = 60.0
    _scenes: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        """Check that there are cases."""
        if not self.seeds:
            raise ValueError(
                f"the challenge of {self.lesson} has no seeds: give one seed for each {self.case}"
            )

    def scene(self, seed: Hashable) -> Any:
        """Return a case's scene, which is made only once."""
        if seed not in self._scenes:
            self._scenes[seed] = self.make(seed)
        return self._scenes[seed]

    def beats(self, score: float, other: float) -> bool:
        """Return whether a score is better than another."""
        return score > other if self.higher_is_better else score < other

    def worst(self, scores: Sequence[float]) -> int:
        """Return the index of the worst score."""
        return int(np.argmin(scores) if self.higher_is_better else np.argmax(scores))

    def say(self, score: float) -> str:
        """Return a score with its unit."""
        return Column("", self.unit, self.digits).say(score)


@dataclass(frozen=True)
class CaseResult:
    """The result of one case.

    Parameters
    ----------
    seed : hashable
        Seed of the case.
    name : str
        Name of the case.
    score : float
        Score of the case.
    columns : mapping of str to float
        Values of the other columns; empty without a usable answer.
    kept : object
        Data for the figure; None without a usable answer.
    message : str
        Why there was no usable answer; empty if there was one.
    """

    seed: Hashable
    name: str
    score: float
    columns: Mapping[str, float] = field(default_factory=dict)
    kept: Any = None
    message: str = ""


@dataclass(frozen=True, eq=False)
class Run:
    """The results of an entry in the cases of a challenge.

    Parameters
    ----------
    challenge : Challenge
        The challenge.
    results : tuple of CaseResult
        Results of the cases that were run.
    stopped : str
        Why the run ended early; empty if it did not.
    """

    challenge: Challenge
    results: tuple[CaseResult, ...]
    stopped: str = ""

    @property
    def complete(self) -> bool:
        """Whether all cases were run with at least one usable answer, so that there is a score."""
        return not self.stopped and len(self.results) == len(self.challenge.seeds)

    @property
    def score(self) -> float:
        """The total score; NaN if not all cases were run."""
        if not self.complete:
            return float("nan")
        return self.challenge.total(np.array([each.score for each in self.results]))

    @property
    def columns(self) -> dict[str, float]:
        """The mean of each other column over the cases that have a value."""
        found: dict[str, list[float]] = {}
        for each in self.results:
            for name, value in each.columns.items():
                if np.isfinite(value):
                    found.setdefault(name, []).append(value)
        return {name: float(np.mean(values)) for name, values in found.items()}

    @property
    def worst(self) -> CaseResult:
        """The first of the cases with the worst score."""
        return self.results[self.challenge.worst([each.score for each in self.results])]

    def problems(self) -> list[str]:
        """Return the reasons for unusable answers, each once with its number of cases."""
        met: dict[str, list[str]] = {}
        for each in self.results:
            if each.message:
                met.setdefault(each.message, []).append(each.name)
        case, of = self.challenge.case, len(self.challenge.seeds)
        cost = f"have no usable answer and count {self.challenge.nothing:g} each"
        return [
            f"{len(names)} of {of} {case}s {cost}, the first is {names[0]}: {message}"
            for message, names in met.items()
        ]


def recorded_rows(path: Path) -> tuple[Row, ...]:
    """Read the rows recorded by ``python -m benchmarks challenges``.

    Parameters
    ----------
    path : Path
        The JSON file beside the challenge's module.

    Returns
    -------
    tuple of Row
        The rows; empty if nothing was recorded yet.
    """
    if not path.is_file():
        return ()
    rows = json.loads(path.read_text(encoding="utf-8"))
    return tuple(Row(each["name"], each["score"], each["columns"], tuple(each["cases"])) for each in rows)
