"""The board of a challenge: its task, the recorded scores, and the results of the student's entries."""

from __future__ import annotations

import copy
from dataclasses import dataclass
from functools import cached_property
from html import escape
from math import comb
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
SIGNIFICANT = 0.05  # largest p-value of a difference that is not called chance


class Board:
    """The board of a challenge, which shows the task and the scores and accepts entries.

    Parameters
    ----------
    challenge : Challenge
        The challenge.
    folder : Path, optional
        Folder of the file with the best score; by default the notebook's folder.
    """

    def __init__(self, challenge: Challenge, folder: Path | None = None) -> None:
        """Store the challenge; files are read later."""
        self.challenge = challenge
        self._best = BestFile(challenge, folder)

    def enter(self, entry: Any) -> EntryReport:
        """Run an entry on all cases, and store its score if it is your best.

        Parameters
        ----------
        entry : callable or object
            Your function, or the answer itself if the challenge accepts values.

        Returns
        -------
        EntryReport
            Report that a notebook shows. No error is raised: a case in which the entry fails or takes too long has the
            score of no answer.
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
        """Return the arguments of an entry in a case, on which you can try your function.

        Parameters
        ----------
        number : int
            Number of the case, from 1.

        Raises
        ------
        ValueError
            If the case does not exist.
        """
        seeds = self.challenge.seeds
        if not 1 <= number <= len(seeds):
            raise ValueError(f"number must be from 1 to {len(seeds)}, got {number}")
        given = copy.deepcopy(self.challenge.given(self.challenge.scene(seeds[number - 1])))
        return given[0] if len(given) == 1 else given

    def table(self) -> Table:
        """Return the rows of the board, the worst row first."""
        best, _ = self._best.read()
        return standings(self.challenge, best=best)

    def __repr__(self) -> str:
        """Return the lines of the board."""
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
    """The result of an entry: its score beside the others, and a figure of its worst cases.

    Parameters
    ----------
    run : Run
        Results of the cases.
    before : Best or None
        Best score before this entry.
    remark : str
        Remark about the file of the best score.
    """

    run: Run
    before: Best | None = None
    remark: str = ""

    @property
    def score(self) -> float:
        """The total score; NaN if not all cases were run."""
        return self.run.score

    @cached_property
    def figure(self) -> Drawing | None:
        """Figure of the worst cases; None without a score or a figure."""
        draw = self.run.challenge.figure
        return draw(self.run) if draw and self.run.complete else None

    def sentences(self) -> list[str]:
        """Return the result as sentences."""
        said = [self.run.stopped] if self.run.stopped else [self._verdict()]
        if not self.run.complete and self.before:
            said.append(f"Your best so far stays {self.run.challenge.say(self.before.score)}.")
        return [*said, *self.run.problems(), *([self.remark] if self.remark else [])]

    def table(self) -> Table:
        """Return the board with a row for this entry."""
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
        """Return the sentences, the board and the figure's alt text."""
        figure = self.figure
        return "\n".join([*self.sentences(), repr(self.table()), *([figure.alt] if figure else [])])

    def _repr_html_(self) -> str:
        figure = self.figure
        said = "".join(Message(line)._repr_html_() for line in self.sentences())
        return f"<div>{said}{self.table()._repr_html_()}{figure._repr_html_() if figure else ''}</div>"


def standings(challenge: Challenge, best: Best | None = None, entry: Best | None = None) -> Table:
    """Return a board as a table, the worst row first, with the student's best score so far and perhaps another entry.

    The columns are the score, the worst case and the challenge's own. Without a best score, the last row says so.
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
    """Return the cells beside a score: the worst case and the columns."""
    worst = challenge.say(row.cases[challenge.worst(row.cases)]) if row.cases else "-"
    return [worst, *(column.say(row.columns.get(column.name)) for column in challenge.columns)]


def _neighbours(run: Run) -> str:
    """Return the recorded rows next to a score, compared by the digits that are shown.

    Two scores may differ by chance, so the sentence also counts the cases in which each is better, and gives the result
    of a sign test on them. Equal cases say nothing about which is better and are left out.
    """
    challenge, score = run.challenge, run.score
    shown = {row.name: round(row.score, challenge.digits) for row in challenge.rows}
    mine = round(score, challenge.digits)
    rows = sorted(challenge.rows, key=lambda row: shown[row.name], reverse=not challenge.higher_is_better)
    behind = [row for row in rows if challenge.beats(mine, shown[row.name])]
    level = [row for row in rows if shown[row.name] == mine]
    ahead = [row for row in rows if challenge.beats(shown[row.name], mine)]
    said = [f"it is better than {_named(challenge, row)}{_in_cases(run, row, 1)}" for row in behind[-1:]]
    said += [f"it is level with {_named(challenge, row)}" for row in level[:1]]
    said += [f"next is {_named(challenge, row)}{_in_cases(run, row, -1)}" for row in ahead[:1]]
    first = "; ".join(said)
    return f"{first[0].upper()}{first[1:]}." if said else ""


def _named(challenge: Challenge, row: Row) -> str:
    return f'"{row.name}" ({challenge.say(row.score)})'


def _in_cases(run: Run, row: Row, sign: int) -> str:
    """Return in how many cases an entry is better than a row and worse, or the reverse with sign -1."""
    challenge, mine = run.challenge, [each.score for each in run.results]
    if len(row.cases) != len(mine):
        return ""
    pairs = [pair[::sign] for pair in zip(mine, row.cases, strict=True)]
    wins = sum(challenge.beats(one, other) for one, other in pairs)
    losses = sum(challenge.beats(other, one) for one, other in pairs)
    said = f"better in {_count(wins, challenge.case)} and worse in {losses}"
    if not losses:
        said = f"better in {'all ' if wins == len(mine) else ''}{_count(wins, challenge.case)}"
    by_chance = challenge.sampled and _by_chance(wins, losses) > SIGNIFICANT
    return f", {'which is ' if sign < 0 else ''}{said}" + (
        ": this difference may be chance" if by_chance else ""
    )


def _by_chance(wins: int, losses: int) -> float:
    """Return the p-value of a sign test: how likely equal entries differ by at least as many wins."""
    count = wins + losses
    return min(1.0, 2 * sum(comb(count, each) for each in range(wins, count + 1)) / 2**count)


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _head(challenge: Challenge) -> tuple[str, str, str]:
    return challenge.title, challenge.task, f"Score: {challenge.scoring} It is not graded."


def _how_to_enter(challenge: Challenge) -> str:
    what = "my_plan" if challenge.takes_values else "my_function"
    return f'To enter: challenge("{number_of(challenge.lesson)}").enter({what})'
