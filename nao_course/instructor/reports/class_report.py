"""The class's page: how many handed in, what they earned, which exercises were hard, and what was refused."""

from __future__ import annotations

import base64
import io
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import mean, median
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import ExerciseResult, State
from nao_course.instructor.gradebook.scores import Score, all_scores
from nao_course.instructor.reports.html import (
    Markup,
    card,
    element,
    lesson_title,
    number,
    page,
    visible,
    write_whole,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HARDEST = 5  # exercises that are named
MOST_LISTED = 200  # submissions of one kind
MOST_MISTAKES = 30  # of a lesson that are named
_KINDS: dict[
    str, tuple[str, str, tuple[State, ...]]
] = {  # colour, hatch, states; safe for colour-blind readers
    "right": ("#009e73", "", ("right",)),
    "wrong": ("#e69f00", "//", ("wrong", "changes its input", "no usable answer")),
    "raised, ended or too slow": ("#d55e00", "xx", ("raised", "timed out", "died", "not run")),
    "not attempted": ("#b8bec2", "", ("not attempted", "not found")),
    "to be decided": ("#56b4e9", "..", ("undecided",)),
}
_STYLE: Any = {
    "font.size": 10,
    "font.family": "sans-serif",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "hatch.linewidth": 0.6,
    "svg.hashsalt": "nao_course",
    "svg.fonttype": "path",
}


@dataclass(frozen=True)
class ExerciseSummary:
    """The results of a class in one exercise, by number and name, and the numbers of submissions by result.

    `share` is the mean share of its points that were earned, 0 to 1, or the share of right ones if it is worth nothing.
    """

    title: str
    points: float
    share: float
    counts: dict[str, int]


@dataclass(frozen=True)
class MistakeSummary:
    """A declared mistake with its message to the student, and how many submissions of a class made it."""

    title: str
    name: str
    message: str
    many: int


def write_report(journal: Journal, path: Path) -> Path:
    """Write the page of a class."""
    return write_whole(path, report_page(all_scores(journal)))


def report_page(made: Sequence[Score]) -> str:
    """Return the page about some scores; the same bytes for the same scores."""
    lessons = sorted({each.result.lesson for each in made})
    students = {each.result.student for each in made}
    said = f"{say_count(len(students), 'student')}, {say_count(len(made), 'submission')}"
    return page(
        "The class's results",
        element("header", element("h1", "The class's results"), element("p", f"{said}.", class_="soft")),
        None if made else element("p", "Nothing has been graded yet."),
        *(
            part
            for lesson in lessons
            for part in _lesson(lesson, [each for each in made if each.result.lesson == lesson])
        ),
        wide=True,
    )


def _lesson(lesson: str, made: Sequence[Score]) -> Iterator[Markup]:
    graded = [each for each in made if each.result.status == "graded"]
    refused = [each for each in made if each.result.status == "refused"]
    yield element("h2", lesson_title(lesson))
    yield card(_summary(made, graded))
    if graded and max(each.points for each in graded) > 0:
        yield _scores_figure(graded)
    if exercises := exercises_of(graded):
        yield _exercises_figure(exercises, len(graded))
        yield from _hardest(exercises)
        yield _exercises_table(exercises)
        yield from _mistakes_table(mistakes_of(graded))
    yield from _handed_in([each for each in made if each.result.handed_in or each.is_late])
    if refused:
        rows = [(each.result.student, each.result.reason or "no reason was recorded") for each in refused]
        yield from _named(f"Refused: {len(refused)}", rows)
    attempts = [(each.result.student, said) for each in made for said in each.result.attempts]
    if attempts:
        yield from _named("Seen by the sandbox, and denied", attempts)


def _summary(made: Sequence[Score], graded: Sequence[Score]) -> Markup:
    """Return a summary of the lesson in numbers."""
    levels = Counter(each.result.level or "not recorded" for each in graded)
    waiting = sum(len(each.waiting) for each in made)
    rows = [
        ("Submissions", f"{len(made)}: {len(graded)} graded, {len(made) - len(graded)} refused"),
        (
            "Sandbox level",
            ", ".join(f"{name} ({many})" for name, many in sorted(levels.items())) or "none ran",
        ),
        ("Written answers to mark", str(waiting)),
    ]
    if graded:
        earned, points = [each.earned for each in graded], max(each.points for each in graded)
        middle = f"mean {number(mean(earned))}, median {number(median(earned))} of {number(points)}"
        rows.insert(1, ("Points", f"{middle}; from {number(min(earned))} to {number(max(earned))}"))
    cells = [element("tr", element("th", name, scope="row"), element("td", text)) for name, text in rows]
    return element("table", element("tbody", *cells))


def _handed_in(known: Sequence[Score]) -> Iterator[Markup]:
    """Return a table of the submissions that have a time or are late, the late ones first."""
    if not known:
        return
    head = element(
        "tr", *(element("th", name, scope="col") for name in ("student", "handed in", "late", "deducted"))
    )
    rows = [
        element(
            "tr",
            element("th", element("bdi", each.result.student), scope="row"),
            element("td", each.result.handed_in),
            element("td", "yes" if each.is_late else ""),
            element("td", _deducted(each)),
        )
        for each in sorted(known, key=lambda each: not each.is_late)[:MOST_LISTED]
    ]
    yield element("h3", f"Handed in, {sum(each.is_late for each in known)} late")
    yield card(element("table", element("thead", head), element("tbody", *rows)))
    if len(known) > MOST_LISTED:
        yield element("p", f"and {len(known) - MOST_LISTED} more", class_="soft")


def _deducted(score: Score) -> str:
    if score.lateness and score.lateness.is_unmeasured:
        return "nothing: only the platform says that it is late"
    return number(score.deducted) if score.deducted else ""


def exercises_of(graded: Sequence[Score]) -> list[ExerciseSummary]:
    """Return the results of a class for each exercise, in the lesson's order. Refused submissions are left out."""
    by_name: dict[str, list[tuple[Score, ExerciseResult]]] = {}
    for score in graded:
        for each in score.result.exercises:
            by_name.setdefault(each.name, []).append((score, each))
    return [_exercise(given) for given in by_name.values()]


def _exercise(given: Sequence[tuple[Score, ExerciseResult]]) -> ExerciseSummary:
    last = given[-1][1]
    counts = {kind: sum(each.state in states for _, each in given) for kind, (_, _, states) in _KINDS.items()}
    shares = [
        score.of(each) / each.points if each.points > 0 else float(each.state == "right")
        for score, each in given
    ]
    return ExerciseSummary(f"{last.number} {last.name}".strip(), last.points, mean(shares), counts)


def mistakes_of(graded: Sequence[Score]) -> list[MistakeSummary]:
    """Count the mistakes that a class made, the most frequent first. Refused submissions are left out."""
    made = Counter(
        (f"{each.number} {each.name}".strip(), each.mistake, each.hint)
        for score in graded
        for each in score.result.exercises
        if each.mistake
    )
    ordered = sorted(made.items(), key=lambda item: (-item[1], item[0]))
    return [MistakeSummary(*words, many) for words, many in ordered]


def _mistakes_table(mistakes: Sequence[MistakeSummary]) -> Iterator[Markup]:
    """Return the mistakes that were made, each with the message of its check."""
    if not mistakes:
        return
    names = ["exercise", "times", "mistake", "what the check said"]
    head = element("tr", *(element("th", name, scope="col") for name in names))
    rows = [
        element(
            "tr",
            element("th", element("code", each.title), scope="row"),
            element("td", str(each.many), class_="number"),
            element("td", each.name),
            element("td", each.message),
        )
        for each in mistakes[:MOST_MISTAKES]
    ]
    table = element("table", element("thead", head), element("tbody", *rows))
    yield element("h3", "Mistakes that the class made")
    yield card(table)
    if len(mistakes) > MOST_MISTAKES:
        yield element("p", f"and {len(mistakes) - MOST_MISTAKES} rarer ones", class_="soft")


def _hardest(exercises: Sequence[ExerciseSummary]) -> Iterator[Markup]:
    """Name the exercises that the class lost most in."""
    hard = sorted((each for each in exercises if each.share < 1), key=lambda each: each.share)[:HARDEST]
    if hard:
        rows = [
            element("li", element("code", each.title), f" {_percent(each.share)} of its points were earned")
            for each in hard
        ]
        yield element("h3", "Hardest")
        yield element("ol", *rows)


def _exercises_table(exercises: Sequence[ExerciseSummary]) -> Markup:
    """Return the numbers of the figure as a table."""
    names = ["exercise", "points", "earned", *_KINDS]
    head = [element("th", names[0], scope="col")]
    head += [element("th", name, scope="col", class_="number") for name in names[1:]]
    rows = [
        element(
            "tr",
            element("th", element("code", each.title), scope="row"),
            *(
                element("td", text, class_="number")
                for text in (number(each.points), _percent(each.share), *map(str, each.counts.values()))
            ),
        )
        for each in exercises
    ]
    table = element("table", element("thead", element("tr", *head)), element("tbody", *rows))
    return _scrolling(table, "Exercises in numbers")


def _scrolling(content: Markup, label: str) -> Markup:
    """Let what is wider than a phone be scrolled in its own place, from the keyboard too."""
    return element("div", content, class_="scroll", tabindex="0", role="region", aria_label=label)


def _named(title: str, rows: Sequence[tuple[str, str]]) -> Iterator[Markup]:
    """Return the notes on single students."""
    cells = [
        element("tr", element("th", element("bdi", student), scope="row"), element("td", text))
        for student, text in rows[:MOST_LISTED]
    ]
    yield element("h3", title)
    yield card(element("table", element("tbody", *cells)))
    if len(rows) > MOST_LISTED:
        yield element("p", f"and {len(rows) - MOST_LISTED} more", class_="soft")


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


# --- figures ---


def _scores_figure(graded: Sequence[Score]) -> Markup:
    """Draw a histogram of the points of all submissions."""
    earned = np.array([each.earned for each in graded])
    most = max(each.points for each in graded)
    # One bar for each point, around it, as long as there are not too many.
    bins = np.arange(int(most) + 2) - 0.5 if most == int(most) <= 20 else np.linspace(0, most, 21)
    counts, edges = np.histogram(np.clip(earned, 0, most), bins)
    best = int(counts.argmax())
    alt = (
        f"Histogram of points, 0 to {number(most)}: mean {number(float(earned.mean()))}, "
        f"median {number(float(np.median(earned)))}; most submissions, {counts[best]}, "
        f"from {number(max(edges[best], 0))} to {number(min(edges[best + 1], most))}."
    )

    def draw(axes: Axes) -> None:
        axes.bar(edges[:-1], counts, np.diff(edges), align="edge", color="#0072b2", edgecolor="white")
        axes.axvline(float(earned.mean()), color="#1d2327", linestyle="-", label=f"mean {earned.mean():.1f}")
        middle = float(np.median(earned))
        axes.axvline(middle, color="#1d2327", linestyle=":", linewidth=2, label=f"median {middle:.1f}")
        axes.set(xlabel="points", ylabel="submissions", xlim=(edges[0], edges[-1]))
        axes.locator_params(axis="y", integer=True)
        axes.legend(frameon=False, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2)

    return _figure(
        draw, 2.9, "Points of the graded submissions; written answers count once they are marked.", alt
    )


def _exercises_figure(exercises: Sequence[ExerciseSummary], submissions: int) -> Markup:
    """Draw the fractions of the class that solved, failed or left out each exercise."""
    shares = {kind: np.array([each.counts[kind] for each in exercises]) for kind in _KINDS}
    total = np.maximum(sum(shares.values()), 1)
    parts = [
        f"{each.title} {_percent(each.counts['right'] / max(sum(each.counts.values()), 1))}"
        for each in exercises
    ]
    alt = f"Bars: share of {say_count(submissions, 'submission')} that have each exercise right: {', '.join(parts)}."

    def draw(axes: Axes) -> None:
        left, rows = np.zeros(len(exercises)), np.arange(len(exercises))
        for kind, (colour, hatch, _) in _KINDS.items():
            width = 100 * shares[kind] / total
            axes.barh(rows, width, 0.72, left=left, color=colour, hatch=hatch, edgecolor="white", label=kind)
            left += width
        titles = [_shortened(visible(each.title)) for each in exercises]
        axes.set_yticks(rows, titles, parse_math=False)
        axes.set(xlim=(0, 100), xlabel="share of submissions in %")
        axes.invert_yaxis()
        axes.legend(frameon=False, loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, borderaxespad=0.2)

    return _figure(draw, 1.3 + 0.32 * len(exercises), "Results of each exercise.", alt)


def _shortened(title: str) -> str:
    return title if len(title) <= 32 else f"{title[:31]}…"


def _figure(draw: Callable[[Axes], object], height: float, caption: str, alt: str) -> Markup:
    """Draw a picture that is the same bytes each time, and put it into the page with its words."""
    from matplotlib import rc_context  # takes long to import: only a report needs it
    from matplotlib.figure import Figure

    drawn = io.StringIO()
    with rc_context(_STYLE), warnings.catch_warnings():
        # A letter that the font lacks is drawn as a box
        warnings.filterwarnings("ignore", "Glyph", UserWarning)
        figure = Figure(figsize=(7.0, height), layout="constrained")
        draw(figure.subplots())
        figure.savefig(drawn, format="svg", metadata={"Date": None, "Creator": None})
    data = base64.b64encode(drawn.getvalue().encode()).decode()
    picture = element("img", src=f"data:image/svg+xml;base64,{data}", alt=alt)
    return element("figure", _scrolling(picture, "Figure"), element("figcaption", caption))
