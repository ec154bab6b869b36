"""What the commands about decisions of people do and say: points by hand, answers to requests, undo, history."""

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from nao_course._internal.counts import say_count
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.commands.feedback_pages import folder_of, write_pages
from nao_course.instructor.commands.looking_up import list_problems, login, result_of, without_result
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Mark, Override, SubmissionResult
from nao_course.instructor.reports.history import history_page, page_of
from nao_course.instructor.reports.html import write_whole


def set_points(
    grades: Path, student: str, lesson: str, change: str, reason: str, by: str = ""
) -> Iterator[str]:
    """Give a student's exercise or written answer other points, and answer a request; yield what to say about it.

    `change` is EXERCISE=POINTS, and `by` the name of the person, by default the login. Raise a ValueError if there is
    no such result or exercise, points are out of range, or there is no reason for them.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        result = result_of(journal, student, lesson)
        decision = decided(result, change, _given(reason), by or login())
        with journal.command(f"regrade --student {student} --set {change}", decision.given_by):
            if isinstance(decision, Mark):
                journal.mark([replace(decision, is_second=True, is_withdrawn=True), decision])
            else:
                journal.override(decision)
                journal.answer(
                    result.student,
                    result.lesson,
                    decision.exercise,
                    decision.reason,
                    decision.decided_on,
                    decision.given_by,
                )
        (page,) = write_pages(journal, grades, [result])
        counts = f"{decision.item} counts {decision.points:g} points from now on"
        yield f"{student}, {result.lesson}: {counts}. {page} says so."
        if isinstance(decision, Override) and decision.points < decision.earned:
            yield f"The grader gives {decision.earned:g}: status and grade list this until it is unset."


def decided(result: SubmissionResult, change: str, reason: str, by: str) -> Override | Mark:
    """Read EXERCISE=POINTS; raise a ValueError for an unknown exercise, or points that are not in 0..its worth."""
    name, _, points = change.partition("=")
    exercises = {each.name: each for each in result.exercises}
    questions = {each.name: each for each in result.written}
    worth = {each.name: each.points for each in result.exercises}
    worth |= {each.name: each.points for each in result.written}
    if name not in worth:
        raise ValueError(f"{result.lesson} has no exercise {name!r}; it has {', '.join(worth)}")
    try:
        number = float(points)
    except ValueError:
        raise ValueError(
            f"--set wants EXERCISE=POINTS, such as {name}=1.5; got {change!r}. To take points back that people gave, "
            f"say --unset {name}"
        ) from None
    if not 0 <= number <= worth[name]:
        raise ValueError(f"{name} is worth 0 to {worth[name]:g} points, got {points}")
    if name in questions:
        answer = questions[name].fingerprint
        return Mark(result.student, result.lesson, name, number, reason, decided_on=answer, given_by=by)
    return Override(
        result.student,
        result.lesson,
        name,
        number,
        reason,
        decided_on=result.answer_to(name),
        earned=exercises[name].earned,
        given_by=by,
    )


def unset_points(grades: Path, student: str, lesson: str, item: str, by: str = "") -> Iterator[str]:
    """Take back all points that people gave an exercise or written answer; yield what to say about it.

    Raise a ValueError if nobody gave points for it.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        result = result_of(journal, student, lesson)
        key, by = (result.student, result.lesson), by or login()
        overrides = [
            each for each in journal.overrides() if (each.student, each.lesson, each.item) == (*key, item)
        ]
        marks = [each for each in journal.marks() if (each.student, each.lesson, each.item) == (*key, item)]
        if not (overrides or marks):
            raise ValueError(
                f"nobody gave {student!r} points for {item!r} in {result.lesson}, or they were taken back"
            )
        with journal.command(f"regrade --student {student} --unset {item}", by):
            if overrides:
                journal.override(Override(*key, item, 0.0, "", given_by=by, is_withdrawn=True))
            for is_second in sorted({bool(each.is_second) for each in marks}):
                journal.mark([Mark(*key, item, 0.0, given_by=by, is_withdrawn=True, is_second=is_second)])
        write_pages(journal, grades, [result])
        earned = [each.earned for each in result.exercises if each.name == item]
        now = f"the grader's {earned[0]:g} points count" if earned else "it is to be marked"
        yield f"{student}, {result.lesson}: what people gave for {item} is taken back; {now}."
        yield from list_problems(journal)


def keep_points(grades: Path, student: str, exercise: str, reason: str, by: str = "") -> Iterator[str]:
    """Answer a request without a change of points; yield what to say about it.

    Raise a ValueError if there is no such open request, or no reason.
    """
    reason, by = _given(reason), by or login()
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        with journal.command(f"regrade --student {student} --keep {exercise}", by):
            answered = [
                result
                for result in journal.each_result(student=journal.roster().meant(student) or "")
                if journal.answer(
                    result.student, result.lesson, exercise, reason, result.answer_to(exercise), by
                )
            ]
        if not answered:
            raise ValueError(f"there is no open request of {student!r} about {exercise!r}")
        for page in write_pages(journal, grades, answered):
            yield f"{student}, {exercise}: the points stay. {page} gives the reason."
        yield from list_problems(journal)


def _given(reason: str) -> str:
    if reason.strip():
        return reason.strip()
    raise ValueError("say why with --reason: the journal keeps it, and the student reads it")


def undo(grades: Path) -> Iterator[str]:
    """Take back what the last command changed in the journal, and write all feedback pages again.

    Yield what to say about it; raise a ValueError if there is nothing to undo.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        before = journal.students()
        yield f"undone: nao-course {journal.undo()}"
        for student in before - journal.students():
            shutil.rmtree(folder_of(grades, student), ignore_errors=True)
        pages = write_pages(journal, grades, journal.each_result())
        yield f"wrote {say_count(len(pages), 'feedback page')} again"
        yield from list_problems(journal)


def history(grades: Path, student: str) -> Iterator[str]:
    """Write a page with all that was graded and decided for a student; yield what to say about it.

    Raise a ValueError if the journal has nothing of the student.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        roster = journal.roster()
        known = roster.students.get(roster.meant(student) or "")
        if known is None:
            raise ValueError("\n".join(without_result("--student", [student], journal)))
        path = page_of(grades, known.student)
        yield f"wrote {write_whole(path, history_page(journal, known))}"
