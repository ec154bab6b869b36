"""A student's progress: the results of all lessons' public checks, the points, and the next task."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path

from nao_course.exercises.checking import lessons, read_public
from nao_course.exercises.exercise import PublicLesson
from nao_course.exercises.judging.report import CheckState
from nao_course.exercises.notebook_text import read_notebook
from nao_course.exercises.outline import read_outline
from nao_course.student import verdicts
from nao_course.student.notebooks import functions, notebook_of, notebooks_folder

PUBLIC_ONLY = "These are the public checks; the grader uses further checks with other inputs."
# The states of the exercises that do not pass, the unwritten questions, and why the notebook cannot be read
_Standing = tuple[Mapping[str, CheckState], tuple[str, ...], str]
_HEADINGS = ("lesson", "state", "exercises that pass", "points", "in your own words")


@dataclass(frozen=True)
class LessonProgress:
    """Progress in one lesson, such as "01_hsl_filtering".

    `passed` counts the exercises that pass their public checks, with `earned` of all `points`; `answered` counts the
    written answers that are filled in, whose points a person marks. `problem` says why the notebook cannot be read (it
    is there if `is_unread`), and `upcoming` is the next task; both may be empty.
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
    is_unread: bool = False

    @property
    def state(self) -> str:
        """The state in a word or two, or why the notebook cannot be read."""
        if self.problem:
            return self.problem
        if not self.upcoming:
            return "✔ done"
        return "begun" if self.passed or self.answered else "○ not begun"

    def cells(self) -> tuple[str, ...]:
        """Return the lesson's row of the table."""
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
    """Progress in all lessons, shown as a table."""

    lessons: tuple[LessonProgress, ...]

    def total(self, first: str = "") -> str:
        """Return the points of all lessons, with a note on the grader's checks.

        With a lesson `first`, begin with its points, and name the notebooks that are there and could not be read.
        """
        sums = [f"{each.lesson}: {_sum([each])}." for each in self.lessons if each.lesson == first]
        unread = [f"Not counted: {each.problem}" for each in self.lessons if first and each.is_unread]
        return " ".join([*sums, f"All lessons: {_sum(self.lessons)}.", *unread, PUBLIC_ONLY])

    def upcoming(self) -> str:
        """Return the next task as text."""
        for each in self.lessons:
            if each.problem:
                return f"Next: {each.lesson}. {each.problem[:1].upper()}{each.problem[1:]}"
            if each.upcoming:
                return f"Next: {each.upcoming}, in {each.lesson}."
        return "Next: nothing, all lessons are complete."

    def __repr__(self) -> str:
        """Return the table as text."""
        rows = [_HEADINGS, *(each.cells() for each in self.lessons)]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        lines = [
            "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows
        ]
        return "\n".join([*(line.rstrip() for line in lines), self.total(), self.upcoming()])

    def _repr_html_(self) -> str:
        """Return the table as HTML."""
        head = "".join(f'<th scope="col" style="text-align: left">{escape(each)}</th>' for each in _HEADINGS)
        body = "".join(f"<tr>{''.join(_html_cells(each))}</tr>" for each in self.lessons)
        table = f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
        return f"{table}<div><b>{escape(self.total())}</b></div><div>{escape(self.upcoming())}</div>"


def progress(folder: str | Path | None = None) -> Progress:
    """Return your progress in all lessons, according to your saved notebooks.

    Parameters
    ----------
    folder : str or Path, optional
        Folder of the notebooks; by default the working folder.

    Returns
    -------
    Progress
        A table. For a notebook that is missing, broken or never ends it contains the reason.
    """
    where = notebooks_folder(folder)
    return Progress(tuple(lesson_progress(lesson, where) for lesson in lessons()))


def lesson_progress(lesson: str, folder: Path) -> LessonProgress:
    """Return the progress in a lesson's saved notebook."""
    public = read_public(lesson)
    path = notebook_of(lesson, folder)
    states, unwritten, problem = _known(public, path) or _checked(lesson, folder)
    passed = [each for each in public.exercises if each.name not in states]
    left = [
        *(
            f"exercise {each.number} {each.name} ({states[each.name]})"
            for each in public.exercises
            if each.name in states
        ),
        *(f"{number}, in your own words" for number in unwritten),
    ]
    return LessonProgress(
        lesson,
        passed=len(passed),
        exercises=len(public.exercises),
        earned=sum(each.points for each in passed),
        points=sum(each.points for each in public.exercises),
        answered=len(public.written) - len(unwritten),
        written=len(public.written),
        written_points=sum(each.points for each in public.written),
        problem=problem,
        upcoming=left[0] if left else "",
        is_unread=bool(problem) and path.exists(),
    )


def _checked(lesson: str, folder: Path) -> _Standing:
    """Run a notebook's definitions and the public checks on them."""
    found = functions(lesson, folder)
    return {report.name: report.state for report in found.reports}, found.unwritten, found.problem


def _known(public: PublicLesson, path: Path) -> _Standing | None:
    """Return the result of the public checks if it is known without them: all passed, or nothing was changed."""
    released = read_outline(public.name)
    try:
        text = read_notebook(path, released)
    except (OSError, ValueError):
        return None
    names = [each.name for each in public.exercises]
    unwritten = tuple(each.number for each in public.written if not text.written.get(each.name))
    if all(released.is_released(source) for _, source in text.cells):
        return dict.fromkeys(names, "not attempted"), unwritten, ""
    if all(verdicts.kept(path, name) == "" for name in names):
        return {}, unwritten, ""
    return None


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
