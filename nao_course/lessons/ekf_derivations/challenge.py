"""The challenge of lesson 05: eight wrong Jacobians, to be named in the fewest calls."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.exercises import register
from nao_course.lessons.ekf_derivations.challenge_figure import draw_calls
from nao_course.lessons.ekf_derivations.mistakes import COLUMNS, MISTAKES, ROWS, with_mistake

POINTS = 20  # for a mistake that is named; each call costs one
MOST_CALLS = 20
WRONG = (  # drawn from the catalogue without looking
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
    """A wrong Jacobian that tells one entry a call: ``ask(row, column, pose, landmark)``.

    Parameters
    ----------
    most_calls : int
        After which it tells nothing more.
    """

    most_calls: int = MOST_CALLS

    def __post_init__(self) -> None:
        """Begin with no call; neither calls nor mistake are fields, so no copy and no comparison sees them."""
        object.__setattr__(self, "_calls", [])

    def about(self, mistake: str) -> Asked:
        """Return one that answers with a mistake in it."""
        asked = Asked(self.most_calls)
        object.__setattr__(asked, "_mistake", mistake)
        return asked

    @property
    def calls(self) -> int:
        """How often it was asked."""
        calls: list[None] = self._calls  # type: ignore[attr-defined]
        return len(calls)

    def __deepcopy__(self, memo: Any) -> Asked:
        """Return itself: the calls that an entry makes are counted."""
        return self

    def __call__(self, row: int, column: int, pose: npt.ArrayLike, landmark: npt.ArrayLike) -> float:
        """Return one entry of the wrong Jacobian.

        Parameters
        ----------
        row : int
            0 for the bearing, 1 for the range.
        column : int
            0 to 4: by x, y, theta, l_x or l_y.
        pose : array_like, shape (3,)
            x, y (m) and theta (rad).
        landmark : array_like, shape (2,)
            l_x and l_y (m).

        Raises
        ------
        ValueError
            If there is no such entry, the shapes are others, or robot and landmark are at one place.
        RuntimeError
            If all calls are used up.
        """
        if row not in range(len(ROWS)) or column not in range(len(COLUMNS)):
            raise ValueError(f"ask: row 0 or 1 and column 0 to 4, got {row} and {column}")
        if np.shape(pose) != (3,) or np.shape(landmark) != (2,):
            raise ValueError(
                f"ask: pose (3,) and landmark (2,), got shapes {np.shape(pose)} and {np.shape(landmark)}"
            )
        if np.array_equal(np.asarray(pose)[:2], landmark):
            raise ValueError("ask: the landmark is where the robot stands, and has no bearing there")
        if self.calls >= self.most_calls:
            raise RuntimeError(f"ask: all {self.most_calls} calls are used up")
        self._calls.append(None)  # type: ignore[attr-defined]
        mistake: str = self._mistake  # type: ignore[attr-defined]
        return float(with_mistake(mistake, pose, landmark)[row, column])


@dataclass
class WrongJacobian:
    """A case: the mistake, and what was last asked about it."""

    mistake: str
    asked: Asked = field(default_factory=Asked)

    def ask(self) -> Asked:
        """Return a Jacobian to ask, with all its calls."""
        self.asked = Asked().about(self.mistake)
        return self.asked


def judge(answer: Any, case: WrongJacobian) -> CaseScore:
    """Score a name: points where it is right, less one for each call.

    Raises
    ------
    TypeError, ValueError
        If it is no name of the catalogue; the message is for the student.
    """
    if answer is None:
        raise TypeError("Your entry returns None: does it end with return and a name of MISTAKES?")
    if not isinstance(answer, str):
        raise TypeError(f"Your entry must return a name of MISTAKES, got {type(answer).__name__}.")
    name = str.__str__(answer)
    if name not in MISTAKES:
        raise ValueError(f"{name[:60]!r} is no name of MISTAKES.")
    right, calls = name == case.mistake, case.asked.calls
    columns = {"named right": 100.0 * right, "calls": float(calls)}
    return CaseScore(float(POINTS * right - calls), columns, (right, name, calls))


CHALLENGE = Challenge(
    lesson="05_ekf_derivations",
    title="Challenge 05: eight wrong Jacobians",
    task="Each of eight Jacobians of (bearing, range) by x, y, theta, l_x and l_y has one mistake of MISTAKES in it. "
    "Write one function of ask that returns its name; ask(row, column, pose, landmark) tells one entry.",
    scoring=f"{POINTS} points for a right name, less one a call, the mean over all. After {MOST_CALLS} calls there is "
    "nothing more to ask.",
    seeds=WRONG,
    make=WrongJacobian,
    given=lambda case: (case.ask(),),
    judge=judge,
    figure=draw_calls,
    columns=(Column("named right", " %", 0), Column("calls", digits=1)),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    case="Jacobian",
    name_of=lambda mistake: f"number {WRONG.index(mistake) + 1}",
    seconds=2.0,
    seconds_in_all=16.0,
)
