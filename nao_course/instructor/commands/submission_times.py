"""When submissions were made: who says so, whom to trust, and of which nobody says it."""

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import replace

from nao_course._internal.counts import say_count
from nao_course.instructor.collecting.files import submission_hash
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.collecting.sheets import Sheet
from nao_course.instructor.collecting.submissions import TRUST, Submission
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import SubmissionResult
from nao_course.instructor.gradebook.scores import each_journal_score

_SOURCES = {
    "sheet": "from the platform's sheet",
    "platform": "from the platform's names and files",
    "receipt": "from receipts (the student's own clock)",
    "": "unknown",
}
_MOST_NAMED = 5


def with_sheet(submissions: Iterable[Submission], sheet: Sheet | None, roster: Roster) -> list[Submission]:
    """Give submissions of one lesson the times that a platform's sheet has for their students."""
    times = {roster.meant(word): time for word, time in sheet.times.items()} if sheet else {}
    return [
        replace(each, handed_in=times[each.student], timed_by="sheet") if each.student in times else each
        for each in submissions
    ]


def as_before(submissions: Iterable[Submission], journal: Journal) -> list[Submission]:
    """Give submissions that have a result already their time there, if its source is at least as trusted."""
    found = []
    for each in submissions:
        for result in journal.each_result(each.lesson, each.student):
            is_trusted = result.handed_in and _rank(_source(result)) <= _rank(each.timed_by)
            if is_trusted and each.timed_by != "sheet" and result.submission == submission_hash(each):
                each = replace(each, handed_in=result.handed_in, timed_by=_source(result))
        found.append(each)
    return found


def record(submissions: Iterable[Submission], journal: Journal) -> list[tuple[str, str]]:
    """Record in the journal who says when submissions were made; return student and lesson of each changed time."""
    return [
        (each.student, each.lesson)
        for each in submissions
        if each.handed_in
        and journal.date(each.student, each.lesson, submission_hash(each), each.handed_in, each.timed_by)
    ]


def record_sheet(sheet: Sheet, lesson: str, journal: Journal) -> list[tuple[str, str]]:
    """Record the times that a sheet has for the submissions of a lesson that have a result; return what changed."""
    roster, changed = journal.roster(), list[tuple[str, str]]()
    for word, time in sheet.times.items():
        for result in journal.each_result(lesson, roster.meant(word) or word):
            if journal.date(result.student, lesson, result.submission, time, "sheet"):
                changed.append((result.student, lesson))
    return changed


def in_words(submissions: Iterable[Submission]) -> str:
    """Return a sentence about who says when submissions were made, and whom to trust first.

    >>> in_words([])
    "Times: none. The platform's sheet counts before its names and files, and these before receipts."
    """
    counts = Counter(each.timed_by for each in submissions)
    said = ", ".join(f"{counts[each]} {_SOURCES[each]}" for each in (*TRUST, "") if counts[each])
    order = "The platform's sheet counts before its names and files, and these before receipts."
    return f"Times: {said or 'none'}. {order}"


def without_time(journal: Journal, lesson: str | None = None) -> Iterator[str]:
    """Yield a line for each lesson that has a deadline and submissions of which nobody says when they were made."""
    timed, missing = Counter[str](), defaultdict[str, list[str]](list)
    for score in each_journal_score(journal, lesson):
        if score.lateness:
            timed[score.result.lesson] += 1
            if score.lateness.handed_in is None and not score.is_late:
                missing[score.result.lesson].append(score.result.student)
    for each, names in missing.items():
        named = ", ".join(names[:_MOST_NAMED])
        more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
        yield (
            f"{each} has a deadline, and {len(names)} of {say_count(timed[each], 'submission')} "
            f"{'has' if len(names) == 1 else 'have'} no time: {named}{more}. Give a sheet with times "
            "with --sheet; Canvas's has none, so there only files that it calls late are late"
        )


def _source(result: SubmissionResult) -> str:
    """Return who says when a submission was made; earlier versions knew only receipts."""
    return result.timed_by or ("receipt" if result.handed_in else "")


def _rank(source: str) -> int:
    return (*TRUST, "").index(source)
