"""What the commands that grade do and say: grade, and regrade without points."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from nao_course._internal.counts import say_count
from nao_course.exercises.versions import in_words, installed_versions, newer_than_here
from nao_course.instructor.authoring.course import Course, load_course
from nao_course.instructor.authoring.stamps import refuse_what_is_not_built
from nao_course.instructor.autograding.assignment import lessons_used
from nao_course.instructor.autograding.batch import LessonSummary, Summary, summarise
from nao_course.instructor.autograding.scratch import scratch_folder
from nao_course.instructor.autograding.secret import load_secret
from nao_course.instructor.autograding.session import Machines, open_session
from nao_course.instructor.collecting.files import submission_hash
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.collecting.sheets import read_sheet
from nao_course.instructor.collecting.submissions import (
    Gathered,
    Submission,
    gather,
    of_lessons,
    with_earlier,
)
from nao_course.instructor.commands import classes, students, submission_times
from nao_course.instructor.commands.feedback_pages import FEEDBACK, write_pages
from nao_course.instructor.commands.looking_up import result_of, results_of, unknown_extensions
from nao_course.instructor.gradebook.journal import Journal, JournalError
from nao_course.instructor.gradebook.records import SubmissionResult
from nao_course.instructor.reports import status
from nao_course.instructor.reports.html import write_whole

NOT_GRADED = "not_graded.txt"
_SHOWN = 20  # reasons of each kind, and names of those who wait


def grade_folder(
    console: Console,
    path: Path,
    out: Path,
    lessons: Sequence[str],
    machines: Machines,
    *,
    sheet: Path | None = None,
    dry_run: bool = False,
) -> None:
    """Grade a folder or zip of submissions into a folder of grades.

    `sheet` is the platform's, with the students and the times of the only lesson. With `dry_run`, what was recognised
    is printed, and nothing is graded or written. Raise a ValueError or OSError if there is nothing to grade, or it
    cannot be kept; exit with status 1 if a submission has neither a score nor a reason, or something that may be a
    submission was left out.
    """
    with scratch_folder() as scratch:
        if not dry_run:
            load_secret()  # what is missing is said before there is a journal
        course = load_course()
        wanted = course.names(lessons)
        given = read_sheet(sheet, wanted[0] if len(wanted) == 1 else "") if sheet else None
        roster = _roster(out)
        if given:
            roster = roster.with_sheet(given.rows)[0]
        found = gather(path, scratch, course.names(), wanted, known=roster)
        waiting = of_lessons(found, wanted)
        if not waiting and not found.unknown and not found.asked:
            raise ValueError(
                f"{path} contains no submissions. Give a folder of STUDENT/01_hsl_filtering.ipynb"
            )
        names = sorted({each.lesson for each in waiting})
        if given and given.times and len(names) > 1:
            raise ValueError(
                f"the times in {sheet} are of one lesson: name it with --lesson ({', '.join(names)})"
            )
        waiting = submission_times.with_sheet(waiting, given, roster)
        if dry_run:
            _show_found(console, found, submission_times.in_words(waiting))
            _list(console, _not_counted(found))
            console.print("Nothing was graded or written.")
        else:
            refuse_edited_lessons(course, names)
            with Journal(out, policy=course.late_policy) as journal:
                journal.began(path)
                if given:
                    for line in students.learn(journal, out, given):
                        console.print(line, markup=False, highlight=False, soft_wrap=True)
                waiting = add_earlier(waiting, course, journal, scratch)
                if found.wrapper and not roster.is_listed:
                    waiting, found = _without_replacements(waiting, found, journal)
                graded = {each.student for each in waiting}
                journal.know(each for each in found.learned if each.student in graded)
                summary = run(console, journal, out, waiting, machines)
                unread = classes.read_requests(journal, out, path, scratch)
                _show_found(console, found, submission_times.in_words(waiting))
                _show(console, journal, summary, names, found, unread)
                not_graded = (*summary.failed, *found.asked, *found.not_graded)
                _list_not_graded(console, not_graded, out / NOT_GRADED)
            if summary.failed or journal.problems:
                raise typer.Exit(1)
    if found.not_graded or found.asked:
        raise typer.Exit(1)


def _without_replacements(
    waiting: Sequence[Submission], found: Gathered, journal: Journal
) -> tuple[list[Submission], Gathered]:
    """Leave out submissions that would replace a result, because the folder around them may be a student's own.

    A sheet of the class shows that it is not: then only a student's folder has a student's name.
    """
    replaces = _replacing(journal)
    lines = [
        f"{each.student}, {each.lesson}: there is a result already, and the folder {found.wrapper} around this other "
        "notebook may be a student's. If it is not, give the sheet of the class with --sheet, or grade that folder by "
        "itself (unpack a zip first)"
        for each in waiting
        if replaces(each)
    ]
    others = found.unknown[len(found.not_graded) :]
    not_graded = (*found.not_graded, *lines)
    kept = [each for each in waiting if not replaces(each)]
    return kept, replace(found, unknown=(*not_graded, *others), not_graded=not_graded)


def _replacing(journal: Journal) -> Callable[[Submission], bool]:
    """Return a function that says whether a submission would replace the result of another notebook."""
    results = {(each.student, each.lesson): each.submission for each in journal.each_result()}

    def replaces(submission: Submission) -> bool:
        before = results.get((submission.student, submission.lesson))
        return before is not None and before != submission_hash(submission)

    return replaces


def _roster(out: Path) -> Roster:
    """Return the students whom a folder of grades knows."""
    with suppress(JournalError), Journal(out, make=False) as journal:
        return journal.roster()
    return Roster()


def refuse_edited_lessons(course: Course, names: Sequence[str]) -> None:
    """Refuse lessons that were edited since they were built, and earlier lessons they use that were."""
    refuse_what_is_not_built(course, names)
    refuse_what_is_not_built(course, sorted({used for name in names for used in lessons_used(course, name)}))


def add_earlier(
    waiting: Sequence[Submission], course: Course, journal: Journal, scratch: Path
) -> list[Submission]:
    """Give submissions the earlier work that they use: the student's newest, in the last run that had it.

    The journal has the folders of the submissions of all runs; missing or broken ones contribute nothing. `scratch` is
    a folder of the caller's.
    """
    needed = {lesson: lessons_used(course, lesson) for lesson in {each.lesson for each in waiting}}
    wanted = sorted({lesson for lessons in needed.values() for lesson in lessons})
    found = handed_in_before(course, journal, scratch, wanted) if wanted else {}
    return with_earlier(waiting, found, needed.__getitem__)


def handed_in_before(
    course: Course, journal: Journal, scratch: Path, wanted: Sequence[str]
) -> dict[tuple[str, str], Submission]:
    """Return the newest submissions in the folders of all runs by student and lesson; missing folders have none."""
    found: dict[tuple[str, str], Submission] = {}
    known = journal.roster()
    for number, place in enumerate(journal.places()):
        folder = scratch / f"earlier-{number}"
        with suppress(ValueError, OSError):
            gathered = gather(place, folder, course.names(), wanted, known=known)
            replaces = _replacing(journal) if gathered.wrapper and not known.is_listed else None
            for each in gathered.submissions:
                if not (replaces and replaces(each)):
                    found.setdefault((each.student, each.lesson), each)
    return found


def run(
    console: Console, journal: Journal, out: Path, waiting: Sequence[Submission], machines: Machines
) -> Summary:
    """Grade submissions with a progress bar; Ctrl-C ends it, and what is graded is kept."""
    lessons = sorted({each.lesson for each in waiting})
    waiting = submission_times.as_before(waiting, journal)

    def say(line: str) -> None:
        console.print(line, markup=False, highlight=False, soft_wrap=True)

    with (
        open_session(load_course(), lessons, load_secret(), machines, say) as session,
        _progress(console, len(waiting)) as done,
    ):
        try:
            summary = session.grade(waiting, journal, out / FEEDBACK, done)
        except KeyboardInterrupt:
            console.print("Stopped. What is graded is kept; the same command goes on with the rest.")
            raise typer.Exit(130) from None
    # Of a submission that was graded before, only the time may be new.
    write_pages(journal, out, results_of(journal, submission_times.record(waiting, journal)))
    return summary


@contextmanager
def _progress(console: Console, total: int) -> Iterator[Callable[[Submission], None]]:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as progress:
        task = progress.add_task("grading", total=total)
        yield lambda submission: progress.advance(task)


def _show_found(console: Console, found: Gathered, times: str) -> None:
    """Print what was recognised in a download, and who is who in it."""
    around = f"The folder {found.wrapper} is around all submissions and was not taken for a student's."
    for line in (*([around] if found.wrapper else ()), *found.recognised, times):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    new = "New students (if one is known under another name: nao-course students GRADES --same NAME STUDENT)"
    _list(console, [("The same student by name", found.by_name), (new, found.new)])


def _list(console: Console, titled: Iterable[tuple[str, Sequence[str]]]) -> None:
    """Print lists that are not empty, each with its title, and only the first lines of long ones."""
    for title, lines in titled:
        if lines:
            console.print(title + ":", markup=False, highlight=False, soft_wrap=True)
            most = len(lines) if title == "Refused" else _SHOWN
            for line in lines[:most]:
                console.print(f"  {line}", markup=False, highlight=False, soft_wrap=True)
            if len(lines) > most:
                console.print(f"  and {len(lines) - most} more")


def _show(
    console: Console,
    journal: Journal,
    summary: Summary,
    lessons: Iterable[str],
    found: Gathered,
    unread: Sequence[str] = (),
) -> None:
    """Print the result of a run, with a line for each refused submission."""
    for line in _versions(summary.written):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    table = Table("", "submissions")
    table.add_row("graded", str(summary.graded))
    table.add_row("refused", str(len(summary.refused)))
    table.add_row("unchanged", str(summary.unchanged))
    changed, untimed, lowering = list[str](), list[str](), list[str]()
    for lesson in sorted(lessons):
        about = summarise(journal, lesson)
        table.add_row(f"{lesson}, mean so far", _mean(about))
        changed += list(_changed(lesson, about))
        lowering += [
            f"{lesson}: {line}" for score in about.lowering for line in status.lowering_in_words(score)
        ]
        untimed += list(submission_times.without_time(journal, lesson))
    console.print(table)
    reasons = [f"{each.student}, {each.lesson}: {each.reason}" for each in summary.refused]
    _list(
        console,
        [
            ("Refused", reasons),
            ("NEEDS A DECISION (look at the answer, then nao-course regrade --set)", summary.undecided),
            *_not_counted(found, summary)[:2],
            ("Too slow, or not run", summary.too_slow),
            ("Seen by the sandbox", summary.attempts),
            ("Decisions on earlier answers", changed),
            ("Points by hand below the grader's (take back with nao-course regrade --unset)", lowering),
            ("Requests (answer with nao-course regrade --set or --keep)", classes.open_requests(journal)),
            ("Requests NOT READ", unread),
            ("NO TIME, so nothing is late", untimed),
            ("Extensions in course.toml for names that no student has", unknown_extensions(journal)),
            ("FAILED for one student", journal.problems),
            *_not_counted(found, summary)[2:],
        ],
    )


def _not_counted(found: Gathered, summary: Summary | None = None) -> list[tuple[str, Sequence[str]]]:
    """Return lists of what does not count, each with its title: the last two are a reason to look."""
    kept, failed = (summary.kept, summary.failed) if summary else ([], [])
    return [
        ("An older notebook or result counts", (*found.older, *kept)),
        ("Left out", found.unknown[len(found.not_graded) :]),
        ("WHO IS THIS? (not graded)", found.asked),
        ("NOT GRADED", (*failed, *found.not_graded)),
    ]


def _versions(written: Counter[tuple[str, str]]) -> Iterator[str]:
    """Yield with which versions notebooks were written and are graded, and a warning if the grader's are older."""
    counts, newer = Counter[str](), list[str]()
    for (name, version), count in sorted(written.items()):
        counts[in_words({name: version})] += count
        if newer_than_here({name: version}):
            newer.append(in_words({name: version}))
    if counts:
        stated = ", ".join(f"{version} ({count})" for version, count in counts.items())
        yield f"Written with {stated}; graded with {in_words(installed_versions())}."
    if newer:
        yield (
            f"WARNING: notebooks were written with {', '.join(dict.fromkeys(newer))}, and the grader is older. Right "
            "code may fail here, so grade with the versions of the class."
        )


def _mean(about: LessonSummary) -> str:
    """Return the mean of the graded submissions; and of all, since exports contain the refused ones, too."""
    graded, every = about.graded, about.graded + about.refused
    said = f"{sum(graded) / max(len(graded), 1):.2f} of {about.worth:g} ({len(graded)} graded in all)"
    if about.refused:
        said += f"; {sum(every) / len(every):.2f} with {len(about.refused)} refused, as in exports"
    return said


def _changed(lesson: str, about: LessonSummary) -> Iterator[str]:
    """Yield a line for each kind of decision that does not count any more."""
    if about.changed_marks:
        verb = "has" if about.changed_marks == 1 else "have"
        count = say_count(about.changed_marks, "marked answer")
        yield f"{lesson}: {count} {verb} changed: run nao-course marks GRADES"
    for result, change in about.changed_overrides:
        earned = next(each.earned for each in result.exercises if each.name == change.exercise)
        yield (
            f"{result.student}, {lesson}, {change.exercise}: {change.points:g} by hand for an earlier answer; now the "
            f"grader's {earned:g} count, unless you say nao-course regrade --set {change.exercise}=POINTS"
        )


def _list_not_graded(console: Console, not_graded: Sequence[str], file: Path) -> None:
    """Write the list of what a run did not grade if the screen shows only a part of it."""
    if len(not_graded) > _SHOWN:
        console.print(f"All {len(not_graded)} are listed in {escape(str(file))}.")
        write_whole(file, "".join(f"{line}\n" for line in not_graded))
    else:
        file.unlink(missing_ok=True)


# --- one student ---


def regrade_student(console: Console, grades: Path, student: str, lesson: str) -> None:
    """Grade a student's submission again.

    Raise a ValueError if there is no such result; exit with status 1 if the submission could not be graded.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        result = result_of(journal, student, lesson)
        refuse_edited_lessons(course := load_course(), course.names([result.lesson]))
        journal.want_again(result.student, result.lesson)
        places = [each for each in journal.places() if each.exists()]
        if not places:
            console.print("It is graded again by the next `nao-course grade`.")
            return
        with scratch_folder() as scratch:
            mine = _handed_in(places, scratch, result, journal.roster())
            if not mine:
                where = ", ".join(map(str, places))
                raise ValueError(f"{where}: no {result.lesson} of {student!r} is there any more")
            mine = add_earlier(mine, load_course(), journal, scratch)
            summary = run(console, journal, grades, mine, Machines())
            _show(console, journal, summary, [result.lesson], Gathered((), ()))
    if summary.failed or journal.problems:
        raise typer.Exit(1)


def _handed_in(
    places: Iterable[Path], scratch: Path, result: SubmissionResult, known: Roster
) -> list[Submission]:
    """Find a submission again where one of the runs had it."""
    for number, place in enumerate(places):
        folder, course = scratch / str(number), load_course()
        found = gather(place, folder, course.names(), [result.lesson], known=known)
        mine = [each for each in of_lessons(found, [result.lesson]) if each.student == result.student]
        # The folder around all students may be a student's own: it replaces nobody's submission.
        if mine and (not found.wrapper or known.is_listed or submission_hash(mine[0]) == result.submission):
            return mine
    return []
