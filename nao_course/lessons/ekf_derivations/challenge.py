"""The challenge of lesson 05: name the mistakes in eight Jacobians with as few calls as possible."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nao_course._internal.counts import say_count
from nao_course.challenges import CaseScore, Challenge, Column, Run, recorded_rows
from nao_course.exercises import register
from nao_course.lessons.ekf_derivations.mistakes import COLUMNS, MISTAKES, ROWS, with_mistake
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below

POINTS = 20  # for a right name; each call costs one
MOST_CALLS = 20
_RIGHT, _WRONG = STYLES["ekf"].colour, STYLES["odometry"].colour
WRONG = (  # drawn at random from the catalogue
    "plus 1 for -1",
    "range by x, y: r^2 for r",
    "bearing in degrees",
    "range by x, y: sign",
    "bearing by x, y: dx and dy swapped",
    "bearing by x, y: sign",
    "bearing by l_x, l_y: sign",
    "robot and landmark exchanged",
)


@register
@dataclass(frozen=True)
class Asked:
    """A wrong Jacobian that returns one entry for each call: ``ask(row, column, pose, landmark)``.

    It answers at most `most_calls` calls.
    """

    most_calls: int = MOST_CALLS

    def __post_init__(self) -> None:
        """Start with no calls; calls and mistake are not fields, so copies and comparisons do not show them."""
        object.__setattr__(self, "_calls", [])

    def with_mistake(self, mistake: str) -> Asked:
        """Return a new object that answers with this mistake."""
        asked = Asked(self.most_calls)
        object.__setattr__(asked, "_mistake", mistake)
        return asked

    @property
    def calls(self) -> int:
        """Number of calls so far."""
        calls: list[None] = self._calls  # type: ignore[attr-defined]
        return len(calls)

    def __deepcopy__(self, memo: Any) -> Asked:
        """Return the object itself, so that the calls of an entry are counted."""
        return self

    def __call__(self, row: int, column: int, pose: npt.ArrayLike, landmark: npt.ArrayLike) -> float:
        """Return an entry of the wrong Jacobian: rows are bearing and range; columns are x, y, theta, l_x and l_y.

        The pose (3,) is x, y (m) and theta (rad), the landmark (2,) is in m. Raise a ValueError for wrong arguments or
        a robot at the landmark, and a RuntimeError if all calls are used up.
        """
        if row not in range(len(ROWS)) or column not in range(len(COLUMNS)):
            raise ValueError(f"ask got row {row} and column {column}; rows are 0 and 1, columns 0 to 4")
        if np.shape(pose) != (3,) or np.shape(landmark) != (2,):
            raise ValueError(
                f"ask got shapes {np.shape(pose)} and {np.shape(landmark)}; pose is (3,) and landmark (2,)"
            )
        if np.array_equal(np.asarray(pose)[:2], landmark):
            raise ValueError(
                "ask got a landmark at the robot's own position, where its bearing is undefined; move one of them"
            )
        if self.calls >= self.most_calls:
            raise RuntimeError(f"ask: all {self.most_calls} calls are used up; return a name now")
        self._calls.append(None)  # type: ignore[attr-defined]
        mistake: str = self._mistake  # type: ignore[attr-defined]
        return float(with_mistake(mistake, pose, landmark)[row, column])


@dataclass
class WrongJacobian:
    """One case: the mistake, and the Jacobian that the entry last asked."""

    mistake: str
    asked: Asked = field(default_factory=Asked)

    def ask(self) -> Asked:
        """Return a fresh Jacobian to ask, with all of its calls left."""
        self.asked = Asked().with_mistake(self.mistake)
        return self.asked


def judge(answer: Any, case: WrongJacobian) -> CaseScore:
    """Return the score of a name: points if it is right, minus one for each call.

    Raise a TypeError or ValueError with a message for the student if the answer is not a name of the catalogue.
    """
    if answer is None:
        raise TypeError(
            "Your entry returns None. It should return a name of MISTAKES; is the return missing?"
        )
    if not isinstance(answer, str):
        raise TypeError(
            f"Your entry returns {type(answer).__name__}. It should return a name of MISTAKES, a string."
        )
    name = str.__str__(answer)
    if name not in MISTAKES:
        raise ValueError(
            f"{name[:60]!r} is not one of the names in MISTAKES; print(list(MISTAKES)) shows them."
        )
    right, calls = name == case.mistake, case.asked.calls
    columns = {"named right": 100.0 * right, "calls": float(calls)}
    return CaseScore(float(POINTS * right - calls), columns, (right, name, calls))


@course_style()
def draw_calls(run: Run) -> Drawing:
    """Draw the number of calls for each Jacobian that has an answer."""
    named = [each for each in run.results if each.kept]
    said = []
    figure = Figure(figsize=(9.6, 0.42 * max(len(named), 1) + 1.3))
    ax = figure.subplots()
    for place, each in enumerate(named):
        right, name, calls = each.kept
        ax.barh(place, calls, color=_RIGHT if right else _WRONG, hatch="" if right else "///", ec="white")
        text = name if right else f"{name}, which is wrong"
        ax.text(calls + 0.15, place, text, va="center", fontsize=9.5)
        said.append(f"{each.name}: {say_count(calls, 'call')}, {text}")
    ax.set(
        xlabel="calls",
        xlim=(0, 2.2 * max([each.kept[2] for each in named] + [5])),
        ylim=(len(named) - 0.4, -0.6),
    )
    ax.set_yticks(range(len(named)), [each.name for each in named])
    keys = [
        Patch(facecolor=_RIGHT, label="right name"),
        Patch(facecolor=_WRONG, hatch="///", ec="white", label="wrong name"),
    ]
    legend_below(figure, keys)
    return Drawing(
        figure, "Calls for each Jacobian, and the mistake that was named. " + "; ".join(said) + "."
    )


CHALLENGE = Challenge(
    lesson="05_ekf_derivations",
    title="Challenge 05: eight wrong Jacobians",
    task="Each of eight Jacobians of (bearing, range) with respect to x, y, theta, l_x and l_y has one mistake of "
    "MISTAKES. "
    "Write a function of ask that returns the name of the mistake; ask(row, column, pose, landmark) returns one "
    "entry.",
    scoring=f"{POINTS} points for a right name, minus one for each call; the score is the mean over all eight. "
    f"There are at most {MOST_CALLS} calls for each Jacobian.",
    seeds=WRONG,
    make=WrongJacobian,
    given=lambda case: (case.ask(),),
    judge=judge,
    figure=draw_calls,
    columns=(Column("named right", " %", 0), Column("calls", digits=1)),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    case="Jacobian",
    sampled=False,
    name_of=lambda mistake: f"number {WRONG.index(mistake) + 1}",
    seconds=2.0,
    seconds_in_all=16.0,
)
