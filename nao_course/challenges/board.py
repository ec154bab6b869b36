"""The board of a challenge: what is to be done, what others reached, and how an entry did."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

from nao_course.challenges.best import Best, BestFile
from nao_course.challenges.declaration import Challenge, Row, Run
from nao_course.challenges.progress import Progress
from nao_course.challenges.running import run
from nao_course.exercises.lesson_names import number_of
from nao_course.exercises.trying import Message
from nao_course.plotting import Drawing, Table, table

YOU = "you, best so far"
THIS = "this entry"


class Board:
    """A challenge as a student meets it: it shows itself, and takes entries.

    Parameters
    ----------
    challenge : Challenge
        Which one.
    folder : Path, optional
        Where the best so far is kept; by default beside the notebook.
    """

    def __init__(self, challenge: Challenge, folder: Path | None = None) -> None:
        """Read nothing and make nothing yet."""
        self.challenge = challenge
        self._best = BestFile(challenge, folder)

    def enter(self, entry: Any) -> EntryReport:
        """Run an entry on all cases, say how it did, and keep its score if it is your best.

        Parameters
        ----------
        entry : callable or object
            Your function; or the answer itself, where the board says so.

        Returns
        -------
        EntryReport
            It shows itself. An entry that fails, or takes too long, in a case scores nothing there; nothing is raised.
        """
        challenge = self.challenge
        before, remark = self._best.read()
        progress = Progress(len(challenge.seeds), f"{challenge.case}s")
        came = run(challenge, entry, progress)
        progress.end()
        if came.complete:
            remark = self._best.keep(Best(came.score, came.worst.score, came.columns))
        return EntryReport(came, before, remark)

    def example(self, number: int = 1) -> Any:
        """Return what an entry is given in a case, to try your function on it.

        Parameters
        ----------
        number : int
            Of the case, from 1.

        Raises
        ------
        ValueError
            If there is no such case.
        """
        seeds = self.challenge.seeds
        if not 1 <= number <= len(seeds):
            raise ValueError(f"number must be from 1 to {len(seeds)}, got {number}")
        given = copy.deepcopy(self.challenge.given(self.challenge.scene(seeds[number - 1])))
        return given[0] if len(given) == 1 else given

    def table(self) -> Table:
        """Return the rows of the board, the worst first."""
        best, _ = self._best.read()
        return standings(self.challenge, best=best)

    def __repr__(self) -> str:
        """The board in lines."""
        best, remark = self._best.read()
        said = [*_head(self.challenge), remark, repr(standings(self.challenge, best=best))]
        return "\n".join(line for line in [*said, _how_to_enter(self.challenge)] if line)

    def _repr_html_(self) -> str:
        best, remark = self._best.read()
        title, task, scoring = map(escape, _head(self.challenge))
        said = f"<p><b>{title}</b><br>{task}<br><small>{scoring}</small></p>"
        if remark:
            said += Message(remark)._repr_html_()
        how = f"<p><small>{escape(_how_to_enter(self.challenge))}</small></p>"
        return f"<div>{said}{standings(self.challenge, best=best)._repr_html_()}{how}</div>"


@dataclass(frozen=True, eq=False)
class EntryReport:
    """How an entry did: its score beside the others, and a figure of where points are lost.

    Parameters
    ----------
    run : Run
        Its way through the cases.
    before : Best or None
        The best before it.
    remark : str
        On the file in which the best is kept.
    """

    run: Run
    before: Best | None = None
    remark: str = ""

    @property
    def score(self) -> float:
        """The score of all cases; NaN where not all were run."""
        return self.run.score

    @cached_property
    def figure(self) -> Drawing | None:
        """Where points are lost; None where there is no score or no figure."""
        draw = self.run.challenge.figure
        return draw(self.run) if draw and self.run.complete else None

    def sentences(self) -> list[str]:
        """Return what there is to say, in sentences."""
        said = [self.run.stopped] if self.run.stopped else [self._verdict()]
        if not self.run.complete and self.before:
            said.append(f"Your best so far stays {self.run.challenge.say(self.before.score)}.")
        return [*said, *self.run.problems(), *([self.remark] if self.remark else [])]

    def table(self) -> Table:
        """Return the board with this entry on it."""
        best = self.before
        mine = None
        if self.run.complete:
            mine = Best(self.score, self.run.worst.score, self.run.columns)
            if best is None or not self.run.challenge.beats(best.score, mine.score):
                best, mine = mine, None
        return standings(self.run.challenge, best=best, entry=mine)

    def _verdict(self) -> str:
        challenge, score = self.run.challenge, self.score
        said = f"Your entry scores {challenge.say(score)}."
        if self.before is None:
            said += " It is your first."
        elif challenge.beats(score, self.before.score):
            said += f" That is your best so far; it was {challenge.say(self.before.score)}."
        elif score == self.before.score:
            said += " That is as good as your best so far."
        else:
            said += f" Your best so far stays {challenge.say(self.before.score)}."
        return f"{said} {_neighbours(self.run)}".strip()

    def __repr__(self) -> str:
        """Sentences, the board, and the figure's words."""
        figure = self.figure
        return "\n".join([*self.sentences(), repr(self.table()), *([figure.alt] if figure else [])])

    def _repr_html_(self) -> str:
        figure = self.figure
        said = "".join(Message(line)._repr_html_() for line in self.sentences())
        return f"<div>{said}{self.table()._repr_html_()}{figure._repr_html_() if figure else ''}</div>"


def standings(challenge: Challenge, best: Best | None = None, entry: Best | None = None) -> Table:
    """Set the rows of a board in a table, the worst first.

    Parameters
    ----------
    challenge : Challenge
        Its recorded rows are shown.
    best, entry : Best, optional
        The student's best so far, and another entry of theirs.

    Returns
    -------
    Table
        With the score, the worst case and the challenge's columns. Without a best its row says so, at the end.
    """
    rows = list(challenge.rows)
    for name, each in ((YOU, best), (THIS, entry)):
        if each is not None:
            rows.append(Row(name, each.score, each.columns, (each.worst,)))
    rows.sort(key=lambda row: row.score, reverse=not challenge.higher_is_better)
    lines = [[row.name, challenge.say(row.score), *_beside(challenge, row)] for row in rows]
    if best is None:
        lines.append([YOU, *["-"] * (2 + len(challenge.columns))])
    heads = [column.name for column in challenge.columns]
    return table(["", "score", f"worst {challenge.case}", *heads], lines)


def _beside(challenge: Challenge, row: Row) -> list[str]:
    """What stands beside a score: the worst case and the columns."""
    worst = challenge.say(row.cases[challenge.worst(row.cases)]) if row.cases else "-"
    return [worst, *(column.say(row.columns.get(column.name)) for column in challenge.columns)]


def _neighbours(run: Run) -> str:
    """Which recorded rows stand just below, level with and just above a score, by the digits that are shown.

    Two scores of a few cases may differ by chance: beside them stands in how many cases the better one is better.
    """
    challenge, score = run.challenge, run.score
    shown = {row.name: round(row.score, challenge.digits) for row in challenge.rows}
    mine = round(score, challenge.digits)
    rows = sorted(challenge.rows, key=lambda row: shown[row.name], reverse=not challenge.higher_is_better)
    behind = [row for row in rows if challenge.beats(mine, shown[row.name])]
    level = [row for row in rows if shown[row.name] == mine]
    ahead = [row for row in rows if challenge.beats(shown[row.name], mine)]
    said = [f"it is above {_named(challenge, row)}{_better_in(run, row, 1)}" for row in behind[-1:]]
    said += [f"it is level with {_named(challenge, row)}" for row in level[:1]]
    said += [f"next is {_named(challenge, row)}{_better_in(run, row, -1)}" for row in ahead[:1]]
    first = "; ".join(said)
    return f"{first[0].upper()}{first[1:]}." if said else ""


def _named(challenge: Challenge, row: Row) -> str:
    return f'"{row.name}" ({challenge.say(row.score)})'


def _better_in(run: Run, row: Row, sign: int) -> str:
    """In how many cases an entry is better than a row, or with sign -1 the row than it; empty where nobody knows."""
    mine = [each.score for each in run.results]
    if len(row.cases) != len(mine):
        return ""
    pairs = [pair[::sign] for pair in zip(mine, row.cases, strict=True)]
    count = sum(run.challenge.beats(one, other) for one, other in pairs)
    return f", better in {count} of {len(mine)} {run.challenge.case}s"


def _head(challenge: Challenge) -> tuple[str, str, str]:
    return challenge.title, challenge.task, f"Score: {challenge.scoring} It is not graded."


def _how_to_enter(challenge: Challenge) -> str:
    what = "my_plan" if challenge.takes_values else "my_function"
    return f'To enter: challenge("{number_of(challenge.lesson)}").enter({what})'
