"""What a challenge is, and what comes of an entry: the task, its cases, the scores that an entry is compared with."""

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
    """A number beside the score that says what was honest about it, such as false detections.

    Parameters
    ----------
    name : str
        Head of the column, and its key in `CaseScore.columns`.
    unit : str
        Behind each number, such as " m" or " %".
    digits : int
        After the point.
    """

    name: str
    unit: str = ""
    digits: int = 2

    def say(self, value: float | None) -> str:
        """Return a number with its unit; a dash where there is none."""
        return "-" if value is None or not np.isfinite(value) else f"{value:z.{self.digits}f}{self.unit}"


@dataclass(frozen=True)
class CaseScore:
    """What an answer earned in one case.

    Parameters
    ----------
    score : float
        Its score.
    columns : mapping of str to float
        The other numbers of the board, by the names of `Challenge.columns`; the board shows their mean.
    kept : object
        What the challenge's figure needs of the answer, in types of the judge's own.
    """

    score: float
    columns: Mapping[str, float] = field(default_factory=dict)
    kept: Any = None


@dataclass(frozen=True)
class Row:
    """An entry on the board that is not the student's: recorded numbers, no code.

    Parameters
    ----------
    name : str
        Whose it is, such as "the paper's rule".
    score : float
        Of all cases.
    columns : mapping of str to float
        The other numbers.
    cases : tuple of float
        The score of each case, in the order of `Challenge.seeds`.
    """

    name: str
    score: float
    columns: Mapping[str, float] = field(default_factory=dict)
    cases: tuple[float, ...] = ()


@dataclass(frozen=True, eq=False)
class Challenge:
    """A task with a score, on cases that are the same for everybody; never graded.

    Parameters
    ----------
    lesson : str
        Such as "01_hsl_filtering".
    title, task, scoring : str
        A head line; what to do, in a sentence; what the score is.
    seeds : sequence
        One for each case; what they are is the challenge's own.
    make : callable
        ``make(seed)`` gives a case's scene: what is given and what is true. It is made when it is needed, and kept.
    judge : callable
        ``judge(answer, scene)`` gives a `CaseScore`. A ValueError or TypeError says in a sentence why an answer cannot
        be used.
    given : callable
        ``given(scene)`` gives the arguments of the student's function, of which it gets copies; nothing of the truth.
    figure : callable, optional
        ``figure(run)`` draws where points are lost.
    columns : tuple of Column
        Numbers beside the score.
    rows : tuple of Row
        What others reached: nothing, the paper's method, the reference.
    nothing : float
        The score of a case whose answer cannot be used.
    higher_is_better : bool
        False for a cost or an error.
    total : callable
        Score of all cases from those of each, an array; by default their mean.
    takes_values : bool
        Whether an entry may be the answer itself instead of a function that returns it.
    unit : str
        Behind each score.
    digits : int
        Of each score, after the point.
    case : str
        What a case is called: "scene", "robot".
    name_of : callable
        ``name_of(seed)`` names a case.
    seconds, seconds_in_all : float
        How long the student's function may take for a case, and for all.
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
    name_of: Callable[[Any], str] = str
    seconds: float = 5.0
    seconds_in_all: float = 60.0
    _scenes: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    def __post_init__(self) -> None:
        """Refuse what no board can show."""
        if not self.seeds:
            raise ValueError(
                f"the challenge of {self.lesson} has no seeds: it needs one for each {self.case}"
            )

    def scene(self, seed: Hashable) -> Any:
        """Return a case's scene: made once, and kept."""
        if seed not in self._scenes:
            self._scenes[seed] = self.make(seed)
        return self._scenes[seed]

    def beats(self, score: float, other: float) -> bool:
        """Whether a score is better than another."""
        return score > other if self.higher_is_better else score < other

    def worst(self, scores: Sequence[float]) -> int:
        """Return which of some scores is the worst: its index."""
        return int(np.argmin(scores) if self.higher_is_better else np.argmax(scores))

    def say(self, score: float) -> str:
        """Return a score with its unit."""
        return Column("", self.unit, self.digits).say(score)


@dataclass(frozen=True)
class CaseResult:
    """What came of one case.

    Parameters
    ----------
    seed : hashable
        Which case.
    name : str
        What it is called.
    score : float
        What it earned.
    columns : mapping of str to float
        The other numbers; empty where there was no usable answer.
    kept : object
        What the figure needs; None where there was no usable answer.
    message : str
        Why it scored as nothing, in a sentence; empty where it did not.
    """

    seed: Hashable
    name: str
    score: float
    columns: Mapping[str, float] = field(default_factory=dict)
    kept: Any = None
    message: str = ""


@dataclass(frozen=True, eq=False)
class Run:
    """An entry's way through the cases of a challenge.

    Parameters
    ----------
    challenge : Challenge
        What was run.
    results : tuple of CaseResult
        One for each case, up to where it ended.
    stopped : str
        Why it ended early, in a sentence; empty where it did not.
    """

    challenge: Challenge
    results: tuple[CaseResult, ...]
    stopped: str = ""

    @property
    def complete(self) -> bool:
        """Whether all cases were run, and an answer could be used: only then there is a score."""
        return not self.stopped and len(self.results) == len(self.challenge.seeds)

    @property
    def score(self) -> float:
        """The score of all cases; NaN where not all were run."""
        if not self.complete:
            return float("nan")
        return self.challenge.total(np.array([each.score for each in self.results]))

    @property
    def columns(self) -> dict[str, float]:
        """The other numbers: the mean over the cases that have them."""
        found: dict[str, list[float]] = {}
        for each in self.results:
            for name, value in each.columns.items():
                if np.isfinite(value):
                    found.setdefault(name, []).append(value)
        return {name: float(np.mean(values)) for name, values in found.items()}

    @property
    def worst(self) -> CaseResult:
        """The case with the worst score; of several, the first."""
        return self.results[self.challenge.worst([each.score for each in self.results])]

    def problems(self) -> list[str]:
        """Return why cases scored as nothing: each reason once, with how many cases it met."""
        met: dict[str, list[str]] = {}
        for each in self.results:
            if each.message:
                met.setdefault(each.message, []).append(each.name)
        case, of = self.challenge.case, len(self.challenge.seeds)
        cost = f"bring no answer and count {self.challenge.nothing:g} each"
        return [
            f"{len(names)} of {of} {case}s {cost}, the first is {names[0]}: {message}"
            for message, names in met.items()
        ]


def recorded_rows(path: Path) -> tuple[Row, ...]:
    """Read the rows that ``python -m benchmarks challenges`` recorded.

    Parameters
    ----------
    path : Path
        The JSON file beside the challenge's module.

    Returns
    -------
    tuple of Row
        None where nothing was recorded yet.
    """
    if not path.is_file():
        return ()
    rows = json.loads(path.read_text(encoding="utf-8"))
    return tuple(Row(each["name"], each["score"], each["columns"], tuple(each["cases"])) for each in rows)
