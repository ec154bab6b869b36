"""What waits for a person: who handed in, what is to be marked or decided, and what to do next."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from nao_course._internal.counts import say_count
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Request
from nao_course.instructor.gradebook.scores import Score, each_journal_score
from nao_course.instructor.reports.html import Markup, card, element, lesson_title, number, page, prose

HANDED_IN = "handed in"
_SET = "`nao-course regrade GRADES --student NAME --set EXERCISE=POINTS --reason TEXT`"
# What is listed of each lesson, in the order of the columns, with what to do about it.
KINDS: Mapping[str, str] = {
    HANDED_IN: "",
    "not handed in": "",
    "refused": "These students have to hand in again; their feedback pages say how.",
    "late": "",
    "without a time": (
        "Read a sheet with times (Canvas's has none): `nao-course students GRADES --sheet SHEET --lesson NN`"
    ),
    "to decide": f"Look at the answers: {_SET}",
    "to mark": (
        "Write the sheets with `nao-course marks GRADES`, and read each of them with "
        "`nao-course marks GRADES FILE --by NAME`"
    ),
    "changed since marked": "These answers are to be marked again; the sheets show the earlier marks.",
    "marks that differ": f"Agree on a mark: {_SET}",
    "requests": (
        "Answer with `nao-course regrade GRADES --student NAME --reason TEXT` and `--set EXERCISE=POINTS` or "
        "`--keep EXERCISE`"
    ),
    "points for an earlier answer": f"Set points by hand again if they still hold: {_SET}",
    "points below the grader's": (
        "Take points by hand back if they do not hold: "
        "`nao-course regrade GRADES --student NAME --unset EXERCISE`"
    ),
    "not exported": "Write the grades for your platform: `nao-course export GRADES --format FORMAT --lesson NN`",
}


@dataclass(frozen=True)
class LessonStatus:
    """The lines about a lesson by the `KINDS`; most begin with the name of a student."""

    lesson: str
    lines: Mapping[str, Sequence[str]]

    def count(self, kind: str) -> int:
        """Return how many lines there are of a kind."""
        return len(self.lines.get(kind, ()))


def status(journal: Journal, exported: Mapping[str, str]) -> list[LessonStatus]:
    """Return what waits in each lesson that has a result; `exported` are times in UTC of the lessons' last exports."""
    everybody = journal.roster().students.keys()
    scores: dict[str, list[Score]] = {}
    for score in each_journal_score(journal):
        scores.setdefault(score.result.lesson, []).append(score)
    waiting = [each for each in journal.requests() if not each.answer]
    found = []
    for lesson, made in sorted(scores.items()):
        about = [each for each in waiting if each.lesson == lesson]
        lines = _lines(made, everybody, about)
        changed, last = journal.last_change(lesson), exported.get(lesson, "")
        if changed > last:
            when = f"the last export was at {_minutes(last)} UTC" if last else "never exported"
            lines["not exported"] = [f"{when}, the last change at {_minutes(changed)} UTC"]
        found.append(LessonStatus(lesson, lines))
    return found


def _lines(
    made: Sequence[Score], everybody: Collection[str], requests: Iterable[Request]
) -> dict[str, list[str]]:
    students = [each.result.student for each in made]
    lines: dict[str, list[str]] = {kind: [] for kind in KINDS}
    lines[HANDED_IN] = students
    lines["not handed in"] = sorted(set(everybody) - set(students))
    lines["requests"] = [
        f"{each.student}, {each.exercise or 'unreadable'}: {' '.join(each.text.split())}" for each in requests
    ]
    for score in made:
        name = score.result.student
        if score.result.status == "refused":
            lines["refused"].append(f"{name}: {score.result.reason}")
        if score.is_late:
            days = score.lateness.days if score.lateness else 0
            lines["late"].append(f"{name}: {say_count(days, 'day')}" if days else f"{name}: by the platform")
        elif score.lateness and score.lateness.handed_in is None:
            lines["without a time"].append(name)
        lines["to decide"] += [
            f"{name}, {each.name}" for each in score.result.undecided if each.name not in score.overrides
        ]
        lines["to mark"] += [f"{name}, {each.name}" for each in score.waiting]
        lines["changed since marked"] += [
            f"{name}, {each.name}: {number(score.earlier_marks[each.name].points)} for an earlier answer"
            for each in score.waiting
            if each.name in score.earlier_marks
        ]
        lines["marks that differ"] += [
            f"{name}, {first.question}: {number(first.points)} by {first.given_by or '?'}, "
            f"{number(second.points)} by {second.given_by or '?'}"
            for first, second in score.differing
        ]
        earned = {each.name: each.earned for each in score.result.exercises}
        lines["points for an earlier answer"] += [
            f"{name}, {each.exercise}: {number(each.points)} by hand, now {number(earned[each.exercise])} by the grader"
            for each in score.earlier_overrides.values()
            if each.exercise in earned and each.points != earned[each.exercise]
        ]
        lines["points below the grader's"] += lowering_in_words(score)
    return lines


def lowering_in_words(score: Score) -> list[str]:
    """Return a line for each exercise with fewer points by hand than the grader gives."""
    return [
        f"{score.result.student}, {each.name}: {number(by_hand.points)} by hand"
        f"{f' by {by_hand.given_by}' if by_hand.given_by else ''}, the grader gives {number(each.earned)}"
        for each, by_hand in score.lowering
    ]


def what_to_do(found: Iterable[LessonStatus]) -> list[str]:
    """Return what to do next, in the order of the work, with the lessons that it concerns."""
    found = list(found)
    steps = []
    for kind, advice in KINDS.items():
        counts = [f"{each.lesson} ({each.count(kind)})" for each in found if each.count(kind)]
        if advice and counts:
            steps.append(f"{kind.capitalize()}: {', '.join(counts)}. {advice}")
    return steps


def status_table(found: Sequence[LessonStatus]) -> list[list[str]]:
    """Return how much there is of each kind that there is, with a column for each lesson and a header."""
    kinds = [kind for kind in KINDS if any(each.count(kind) for each in found)]
    header = ["lesson", *(each.lesson.partition("_")[0] for each in found)]
    return [header, *([kind, *(str(each.count(kind) or "") for each in found)] for kind in kinds)]


def status_page(found: Sequence[LessonStatus]) -> str:
    """Return the page for assistants."""
    head, *rows = status_table(found)
    lessons = [element("a", name, href=f"#{each.lesson}") for name, each in zip(head[1:], found, strict=True)]
    heads = [element("th", each, scope="col", class_="number") for each in lessons]
    table = element(
        "table",
        element("thead", element("tr", element("th", head[0], scope="col"), *heads)),
        element(
            "tbody",
            *(
                element(
                    "tr",
                    element("th", kind, scope="row"),
                    *(element("td", count, class_="number") for count in counts),
                )
                for kind, *counts in rows
            ),
        ),
    )
    steps = what_to_do(found)
    return page(
        "Status of the class",
        element("h1", "Status of the class"),
        card(table) if found else None,
        element("h2", "What to do next"),
        element("ol", *(element("li", prose(each)) for each in steps))
        if steps
        else element("p", "Nothing waits."),
        *(part for each in found for part in _lesson(each)),
        wide=True,
    )


def _lesson(found: LessonStatus) -> Iterator[Markup]:
    yield element("h2", lesson_title(found.lesson), id=found.lesson)
    for kind, lines in found.lines.items():
        if kind in (HANDED_IN, "not handed in") and lines:
            yield element("p", f"{kind.capitalize()}, {len(lines)}: ", ", ".join(lines), class_="soft")
        elif lines:
            yield element("h3", f"{kind.capitalize()}: {len(lines)}")
            yield element("ul", *(element("li", each) for each in lines))


def _minutes(time: str) -> str:
    return time[:16].replace("T", " ")
