"""A run over many submissions: what is missing or has changed is graded, and each result is kept as it comes."""

import threading
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Protocol

from nao_course.exercises.versions import installed_versions, newer_than_here
from nao_course.instructor.autograding.assignment import Assignment
from nao_course.instructor.autograding.grader import GraderError, Stopped, grade
from nao_course.instructor.collecting.files import submission_hash
from nao_course.instructor.collecting.submissions import Submission
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Mark, Override, SubmissionResult
from nao_course.instructor.gradebook.scores import Score, each_journal_score, scores
from nao_course.instructor.sandbox.warm_server import WarmServer

Submit = Callable[[Submission, Assignment], Future[SubmissionResult]]
_NEWER = "The newer"  # how a note on an earlier notebook begins
ResultOrError = SubmissionResult | GraderError


class Workers(Protocol):
    """What grades submissions in place of this process's threads, such as `cluster.dispatch.Cluster`."""

    @property
    def most(self) -> int:
        """How many submissions may wait or run."""

    def submit(self, submission: Submission, assignment: Assignment) -> Future[SubmissionResult]:
        """Return the future of a submission's result."""


@dataclass
class Summary:
    """The outcome of a run of the grader.

    `graded` submissions were scored in this run; `unchanged` ones were scored or refused before; `refused` ones were
    refused in this run. `kept` are students whose earlier result counts, because nothing in their new notebook can be
    graded; `failed` are submissions with neither, because the grader itself failed. `attempts` are attempts on the
    sandbox, `undecided` submissions with exercises whose points a person has to decide, with the reason, and `too_slow`
    exercises whose time was used up, with the limit. `written` counts submissions by the name and number of a version
    with which they were written.
    """

    graded: int = 0
    unchanged: int = 0
    refused: list[SubmissionResult] = field(default_factory=list)
    kept: list[str] = field(default_factory=list)
    failed: list[str] = field(default_factory=list)
    attempts: list[str] = field(default_factory=list)
    undecided: list[str] = field(default_factory=list)
    written: Counter[tuple[str, str]] = field(default_factory=Counter)
    too_slow: list[str] = field(default_factory=list)


def grade_all(
    submissions: Iterable[Submission],
    assignment_of: Callable[[str], Assignment],
    journal: Journal,
    *,
    jobs: int = 1,
    server: WarmServer | None = None,
    level: str = "own process",
    workers: Workers | None = None,
    publish: Callable[[SubmissionResult], object] = lambda result: None,
    tell: Callable[[Submission], None] = lambda submission: None,
) -> Summary:
    """Grade what the journal does not have yet, with some threads over one server or with other workers.

    Submissions are taken one by one, so that any number fits into memory, and `jobs` are graded at a time.
    `assignment_of` is called with a lesson's name. `publish` is called with each result before the calling thread keeps
    it in the journal: a run that is killed between the two does both again. `tell` is called with each submission that
    is done; `server` and `level` are as in `grader.grade`, and `workers`, with servers of their own, replace the
    threads.
    """
    summary = Summary()
    stop = threading.Event()

    def missing() -> Iterator[tuple[Submission, Assignment]]:
        for each in submissions:
            assignment = assignment_of(each.lesson)
            if journal.missing(each.student, each.lesson, submission_hash(each), assignment.hash):
                yield each, assignment
            else:
                summary.unchanged += 1
                tell(each)

    task = partial(grade, server=server, level=level, stopped=stop.is_set)
    executor = ThreadPoolExecutor(jobs, thread_name_prefix="grade")
    submit = workers.submit if workers else partial(executor.submit, task)
    try:
        for submission, outcome in as_they_come(
            missing(), submit, lambda: workers.most if workers else 2 * jobs
        ):
            if isinstance(outcome, GraderError):
                summary.failed.append(str(outcome))
            else:
                kept = _earlier_result(outcome, journal)
                with journal.for_one(outcome.student, outcome.lesson, "the feedback page was not written"):
                    publish(kept or outcome)
                if kept:
                    summary.kept.append(_in_words(kept, journal))
                    journal.keep(kept, newest=outcome)
                    tell(submission)
                    continue
                journal.keep(outcome)
                summary.attempts += [
                    f"{outcome.student}, {outcome.lesson}: {each}" for each in outcome.attempts
                ]
                if outcome.undecided:
                    names = ", ".join(each.name for each in outcome.undecided)
                    summary.undecided.append(
                        f"{outcome.student}, {outcome.lesson}, {names}: the notebook is written in "
                        f"{newer_than_here(outcome.versions).against('the grader')}"
                    )
                summary.written.update(outcome.versions.items())
                summary.too_slow += [
                    f"{outcome.student}, {outcome.lesson}: {each.name}: {each.text}"
                    for each in outcome.exercises
                    if each.state in ("timed out", "not run")
                ]
                if outcome.status == "refused":
                    summary.refused.append(outcome)
                else:
                    summary.graded += 1
            tell(submission)
    finally:
        stop.set()
        executor.shutdown(cancel_futures=True)
    for told in (summary.kept, summary.failed, summary.attempts, summary.undecided, summary.too_slow):
        told.sort()  # results come in any order
    summary.refused.sort(key=lambda each: (each.student, each.lesson))
    return summary


def _earlier_result(outcome: SubmissionResult, journal: Journal) -> SubmissionResult | None:
    """Return a student's earlier result, with a note, if nothing in the new notebook can be graded."""
    if outcome.status == "graded" and (outcome.is_answered or not outcome.exercises):
        return None
    for before in journal.each_result(outcome.lesson, outcome.student):
        if (
            before.status == "graded"
            and before.submission != outcome.submission
            and (outcome.status == "refused" or before.is_answered)
        ):
            why = f"cannot be graded ({outcome.reason})" if outcome.reason else "has no answer in it"
            note = f"{_NEWER} {outcome.file} {why}, so this earlier notebook counts"
            left_out, notes = (
                tuple(each for each in told if not each.startswith(_NEWER))
                for told in (before.left_out, before.notes)
            )
            return replace(before, left_out=(*left_out, note), notes=(*notes, note))
    return None


def _in_words(kept: SubmissionResult, journal: Journal) -> str:
    lesson = kept.lesson
    (now,) = scores([kept], journal.overrides(lesson), journal.marks(lesson), journal.policy)
    return f"{kept.student}, {kept.lesson}: {now.earned:g} points before; {kept.left_out[-1]}"


def as_they_come(
    work: Iterable[tuple[Submission, Assignment]], submit: Submit, most: Callable[[], int]
) -> Iterator[tuple[Submission, ResultOrError]]:
    """Submit for grading, a limited number at a time, and yield each result when it is ready.

    Work is taken only as results come. `submit` returns the future of a result, and `most` how many may wait or run.
    """
    waiting: dict[Future[SubmissionResult], Submission] = {}
    rest = iter(work)
    more = True
    while more or waiting:
        while more and len(waiting) < most():
            item = next(rest, None)
            if item is None:
                more = False
            else:
                waiting[submit(*item)] = item[0]
        if waiting:
            done, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in done:
                yield waiting.pop(future), _result_or_error(future)


def _result_or_error(future: Future[SubmissionResult]) -> ResultOrError:
    error = future.exception()
    if isinstance(error, GraderError):
        return error
    if isinstance(error, Stopped):
        return GraderError("stopped")
    return future.result()


def installed() -> str:
    """Name the versions that a result was made with."""
    return ", ".join(f"{name} {version}" for name, version in installed_versions().items())


@dataclass
class LessonSummary:
    """The results of a class in one lesson: points of each graded and each refused submission, as in exports.

    `worth` are the lesson's points. `changed_marks` counts written answers that a person has marked and that the
    student has changed since. `changed_overrides` are points by hand that do not count any more, because the answer has
    changed, or because the grader gives more. `lowering` are scores with points by hand that are fewer than
    the grader's.
    """

    graded: list[float] = field(default_factory=list)
    refused: list[float] = field(default_factory=list)
    worth: float = 0.0
    changed_marks: int = 0
    changed_overrides: list[tuple[SubmissionResult, Override]] = field(default_factory=list)
    lowering: list[Score] = field(default_factory=list)


def summarise(journal: Journal, lesson: str) -> LessonSummary:
    """Return what a class has in a lesson."""
    summary = LessonSummary()
    for score in each_journal_score(journal, lesson):
        (summary.graded if score.result.status == "graded" else summary.refused).append(score.earned)
        summary.worth = max(summary.worth, score.points)
        summary.changed_marks += sum(each.name in score.earlier_marks for each in score.waiting)
        points = {each.name: each.earned for each in score.result.exercises}
        summary.changed_overrides += [
            (score.result, each)
            for each in score.earlier_overrides.values()
            if each.points != points[each.item]
        ]
        summary.lowering += [score] if score.lowering else []
    return summary


def feedback_writer(journal: Journal, folder: Path) -> Callable[[SubmissionResult], Path]:
    """Return what writes a result's feedback page, with what people changed and marked before the run."""
    from nao_course.instructor.reports import feedback

    comments, requests = journal.comments(), journal.requests()
    overrides: dict[tuple[str, str], list[Override]] = defaultdict(list)
    marks: dict[tuple[str, str], list[Mark]] = defaultdict(list)
    for change in journal.overrides():
        overrides[change.student, change.lesson].append(change)
    for mark in journal.marks():
        marks[mark.student, mark.lesson].append(mark)

    def write(result: SubmissionResult) -> Path:
        key = (result.student, result.lesson)
        return feedback.write(
            result, folder, overrides.get(key, ()), marks.get(key, ()), journal.policy, comments, requests
        )

    return write
