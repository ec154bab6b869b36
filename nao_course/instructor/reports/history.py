"""The history of one student on one page: what was handed in and graded, and what people decided, in order."""

from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path

from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.collecting.roster import Student
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Mark, Override, SubmissionResult
from nao_course.instructor.gradebook.scores import Score, each_journal_score
from nao_course.instructor.reports.html import Markup, card, element, lesson_title, number, page

FOLDER = "history"  # in GRADES
_Event = tuple[str, str, str, str]  # time, what, points, and what is said about it


def page_of(grades: Path, student: str) -> Path:
    """Return the path of a student's page."""
    return grades / FOLDER / f"{safe_name(student)}.html"


def history_page(journal: Journal, student: Student) -> str:
    """Return the page of a student, for people who grade; students must not see it, because it names who marked."""
    name = student.student
    scores = {each.result.lesson: each for each in each_journal_score(journal, student=name)}
    events: dict[str, list[_Event]] = {lesson: [] for lesson in scores}
    for time, result, counts in journal.graded(name):
        events.setdefault(result.lesson, []).append((time, *_graded(result, counts)))
    for decision in journal.decisions(name):
        event = (decision.time, *_decided(decision, scores.get(decision.lesson)))
        events.setdefault(decision.lesson, []).append(event)
    for request in journal.requests():
        if request.student == name:
            answer = (
                f"Answered by {request.given_by or 'a person'}: {request.answer}"
                if request.answer
                else "Open."
            )
            what = f"Request: {request.exercise}"
            events.setdefault(request.lesson, []).append((request.time, what, "", f"{request.text} {answer}"))
    known = ", ".join(filter(None, [student.name, student.email, student.login, student.section]))
    also = ", ".join(student.aliases)
    return page(
        f"History of {name}",
        element(
            "header",
            element("h1", "History of ", element("bdi", name)),
            element("p", known, class_="soft") if known else None,
            element("p", "Also known as ", also, class_="soft small") if also else None,
        ),
        None if events else element("p", "Nothing was handed in."),
        *(
            part
            for lesson in sorted(events)
            for part in _lesson(lesson, scores.get(lesson), sorted(events[lesson], key=itemgetter(0)))
        ),
        wide=True,
    )


def _lesson(lesson: str, score: Score | None, events: list[_Event]) -> Iterator[Markup]:
    now = f"{number(score.earned)} of {number(score.points)} points now" if score else "no result now"
    if score and score.deducted:
        now += f", {number(score.deducted)} deducted because it was late"
    yield element("h2", lesson_title(lesson), element("span", f" ({now})", class_="soft"))
    head = element(
        "tr", *(element("th", name, scope="col") for name in ("when (UTC)", "what", "points", "more"))
    )
    rows = [
        element("tr", *(element("td", cell) for cell in (_minutes(time), *more))) for time, *more in events
    ]
    yield card(element("table", element("thead", head), element("tbody", *rows)))


def _minutes(time: str) -> str:
    """Return a time of the journal, which is in UTC, without seconds."""
    return time[:16].replace("T", " ")


def _graded(result: SubmissionResult, counts: bool) -> tuple[str, str, str]:
    handed_in = f"handed in {result.handed_in}" if result.handed_in else "handed in at an unknown time"
    what = "Refused" if result.status == "refused" else "Graded"
    said = [result.reason, result.file, handed_in, "" if counts else "replaced since"]
    return what, f"{number(result.earned)} of {number(result.points)}", "; ".join(filter(None, said))


def _decided(decision: Override | Mark, score: Score | None) -> tuple[str, str, str]:
    """Return what a person decided, and whether it counts now."""
    who = f"by {decision.given_by or 'a person of whom the journal has no name'}"
    if decision.is_withdrawn:
        return f"Taken back: {decision.item}", "", who
    if isinstance(decision, Mark):
        what = f"{'Second mark' if decision.is_second else 'Mark'}: {decision.item}"
        marks = (score.second_marks if decision.is_second else score.marks) if score else {}
        said, counts = decision.comment, marks.get(decision.item) == decision
    else:
        what, said = (
            f"Points by hand: {decision.item}",
            f"the grader gave {number(decision.earned)}; {decision.reason}",
        )
        counts = score is not None and score.overrides.get(decision.item) == decision
    return (
        what,
        number(decision.points),
        "; ".join(filter(None, [who, said, "" if counts else "does not count now"])),
    )
