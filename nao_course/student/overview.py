"""How far a student is: all lessons with what their public checks say, the points, and what to do next."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from nao_course.exercises.checking import lessons, read_public
from nao_course.student.notebooks import functions, notebooks_folder

SECONDS = 5.0  # wall clock of loading a notebook, and of each case of a check
HONESTLY = "These are the public checks; the grader has others, with other inputs."
_HEADINGS = ("lesson", "state", "exercises that pass", "points", "in your own words")


@dataclass(frozen=True)
class LessonProgress:
    """How far a lesson is.

    Parameters
    ----------
    lesson : str
        Such as "01_hsl_filtering".
    passed, exercises : int
        How many exercises pass their public checks, and of how many.
    earned, points : float
        What those are worth, and all exercises together.
    answered, written : int
        How many written answers are filled in, and of how many.
    written_points : float
        What the written answers are worth, which a person marks.
    problem : str
        Why the notebook cannot be read, in a sentence; empty where it can.
    upcoming : str
        What to do next in it; empty when nothing is left.
    """

    lesson: str
    passed: int
    exercises: int
    earned: float
    points: float
    answered: int
    written: int
    written_points: float
    problem: str = ""
    upcoming: str = ""

    @property
    def state(self) -> str:
        """In a word or two; why its notebook cannot be read, where it cannot."""
        if self.problem:
            return self.problem
        if not self.upcoming:
            return "✔ done"
        return "begun" if self.passed or self.answered else "○ not begun"

    def cells(self) -> tuple[str, ...]:
        """Its row of the table."""
        written = f"{self.answered} of {self.written} filled in" if self.written else "none"
        return (
            self.lesson,
            self.state,
            f"{self.passed} of {self.exercises}",
            f"{self.earned:g} of {self.points:g}",
            written,
        )


@dataclass(frozen=True)
class Progress:
    """How far all lessons are; shown by being a cell's last line.

    Parameters
    ----------
    lessons : tuple of LessonProgress
        In the course's order.
    """

    lessons: tuple[LessonProgress, ...]

    def total(self, first: str = "") -> str:
        """Return the sum of a lesson, if one is named, and of all; and what a sum does not say."""
        sums = [f"{each.lesson}: {_sum([each])}." for each in self.lessons if each.lesson == first]
        return " ".join([*sums, f"All lessons: {_sum(self.lessons)}.", HONESTLY])

    def upcoming(self) -> str:
        """Say what to do next."""
        for each in self.lessons:
            if each.problem:
                return f"Next: {each.lesson}. {each.problem[:1].upper()}{each.problem[1:]}"
            if each.upcoming:
                return f"Next: {each.upcoming}, in {each.lesson}."
        return "Next: nothing is left."

    def __repr__(self) -> str:
        """The table as text."""
        rows = [_HEADINGS, *(each.cells() for each in self.lessons)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows
        ]
        return "\n".join([*(line.rstrip() for line in lines), self.total(), self.upcoming()])

    def _repr_html_(self) -> str:
        """The table for a notebook."""
        head = "".join(f'<th scope="col" style="text-align: left">{escape(each)}</th>' for each in _HEADINGS)
        body = "".join(f"<tr>{''.join(_html_cells(each))}</tr>" for each in self.lessons)
        table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        return f"{table}<div><b>{escape(self.total())}</b></div><div>{escape(self.upcoming())}</div>"


def progress(folder: str | Path | None = None) -> Progress:
    """Say how far you are in all lessons, from your saved notebooks.

    Parameters
    ----------
    folder : str or Path, optional
        Where the notebooks are; by default the one you work in.

    Returns
    -------
    Progress
        Shown as a table. A notebook that is missing, broken or never ends is a sentence in it.
    """
    where = notebooks_folder(folder)
    return Progress(tuple(lesson_progress(lesson, where, SECONDS) for lesson in lessons()))


def lesson_progress(lesson: str, folder: Path, most_seconds: float) -> LessonProgress:
    """Say how far a lesson's saved notebook is; `most_seconds` as in `functions`."""
    public = read_public(lesson)
    found = functions(lesson, folder, most_seconds)
    states = {report.name: report.state for report in found.reports}
    left = [
        *(
            f"exercise {each.number} {each.name} ({states[each.name]})"
            for each in public.exercises
            if each.name in states
        ),
        *(f"{number}, in your own words" for number in found.unwritten),
    ]
    return LessonProgress(
        lesson,
        passed=len(found),
        exercises=len(public.exercises),
        earned=sum(each.points for each in public.exercises if each.name in found),
        points=sum(each.points for each in public.exercises),
        answered=len(public.written) - len(found.unwritten),
        written=len(public.written),
        written_points=sum(each.points for each in public.written),
        problem=found.problem,
        upcoming=left[0] if left else "",
    )


def _sum(lessons: Sequence[LessonProgress]) -> str:
    earned, points = (sum(getattr(each, name) for each in lessons) for name in ("earned", "points"))
    answered, written = (sum(getattr(each, name) for each in lessons) for name in ("answered", "written"))
    words = f"{earned:g} of {points:g} points pass their public checks"
    if not written:
        return words
    by_hand = sum(each.written_points for each in lessons)
    answers = f"{answered} of {written} written answer{'' if written == 1 else 's'}"
    return f"{words}, {answers} filled in ({by_hand:g} more, marked by a person)"


def _html_cells(row: LessonProgress) -> Iterator[str]:
    first, *rest = (escape(cell) for cell in row.cells())
    yield f'<th scope="row" style="text-align: left">{first}</th>'
    yield from (f'<td style="text-align: left">{cell}</td>' for cell in rest)
