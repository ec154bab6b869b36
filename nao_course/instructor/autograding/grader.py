"""Grades one submission: its functions run in a worker, and what is expected of them stays here.

A worker runs the public cases of all exercises before the first hidden case. The detailed report therefore comes from
calls made before the code had seen any hidden input. For a hidden case, the page shows only the kind of failure, in
fixed words, and the failing line.
"""

import contextlib
import re
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.exercises import judging
from nao_course.exercises.case import Case
from nao_course.exercises.definitions import NO_DEFINITION
from nao_course.exercises.earlier import split_use
from nao_course.exercises.exercise import PublicExercise
from nao_course.exercises.failed_cells import where_reused
from nao_course.exercises.interactive import remark_on
from nao_course.exercises.judging import explain
from nao_course.exercises.lesson_names import number_of
from nao_course.exercises.notebook_text import DEFINED
from nao_course.exercises.running import Outcome
from nao_course.exercises.versions import Newer, installed_versions, newer_than_here, stated_versions
from nao_course.instructor.autograding.answers import with_answers
from nao_course.instructor.autograding.assignment import Assignment, Task
from nao_course.instructor.autograding.failures import (
    CHANGES_INPUT,
    HiddenResult,
    code_cells,
    describe_failure,
    describe_outcome,
    with_causes,
)
from nao_course.instructor.autograding.references import (
    STOOD_IN,
    ReferenceFunction,
    References,
    count_passed,
    dependencies_of,
    handed_in_earlier,
    in_words,
    notebook_of,
    origins_of,
    recorded,
    used_by,
)
from nao_course.instructor.autograding.scratch import laid_out
from nao_course.instructor.autograding.tries import (
    LOADING,
    NO_TIME_TO_LOAD,
    NOT_RUN,
    Allowances,
    not_run,
    retry_on_server_death,
    retry_until_stable,
)
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.files import Files, read, submission_hash
from nao_course.instructor.collecting.submissions import Submission
from nao_course.instructor.gradebook.records import ATTEMPT, ExerciseResult, SubmissionResult, WrittenAnswer
from nao_course.instructor.sandbox.large_notebooks import without_outputs
from nao_course.instructor.sandbox.layers import SandboxError
from nao_course.instructor.sandbox.protocol import (
    UNREADABLE,
    USED_UP,
    Allowance,
    EarlierNotebook,
    Ended,
    ServerEnded,
)
from nao_course.instructor.sandbox.warm_server import WarmServer
from nao_course.instructor.sandbox.worker import Found, Worker

LONGEST_ANSWER = 20_000  # characters of a written answer
LONGEST_TEXT = 1000  # of what a public check says
_MOST_NOTES = 20
# What a call says that finds too little of what all calls of a process share
_USED_UP = re.compile(
    r"(?i)memory|disk space|too many open files|can't start new thread|temporarily unavailable"
)


class GraderError(RuntimeError):
    """The grader itself failed at a submission: nobody is given 0 points for that."""


class Stopped(Exception):  # noqa: N818 - it is a request, not an error
    """Grading was given up before the submission had a result."""


def grade(
    submission: Submission,
    assignment: Assignment,
    server: WarmServer | None = None,
    level: str = "own process",
    stopped: Callable[[], bool] = lambda: False,
) -> SubmissionResult:
    """Grade a submission from `submissions.gather` with the assignment of its lesson, and return a score or a reason.

    The server forks the sandboxed worker; without it, a new Python process is started. `level` is the sandbox level for
    the result, and `stopped` is called before each call, and returns whether to give up. Raise a GraderError if the
    grader itself fails, a SandboxError if a worker could not be confined, so that nothing may be graded, and Stopped if
    it was to give up.
    """
    start = time.monotonic()
    allowances = Allowances(task.public.name for task in assignment.tasks)
    told: list[Found] = []

    def work(assignment: Assignment) -> tuple[SubmissionResult, int]:
        return retry_on_server_death(
            lambda mine: _grade(submission, assignment, mine, stopped, allowances, told), server
        )

    try:
        result = retry_until_stable(lambda again: work(assignment.anew() if again else assignment))
    except (Stopped, SandboxError):
        raise
    except ServerEnded as error:
        result = refuse(submission, assignment, str(error))
    except Exception as error:
        raise GraderError(
            f"{submission.student}, {submission.lesson}: the grader failed ({type(error).__name__}: {error})"
        ) from error
    return replace(result, level=level, seconds=time.monotonic() - start)


def _grade(
    submission: Submission,
    assignment: Assignment,
    server: WarmServer | None,
    stopped: Callable[[], bool],
    allowances: Allowances,
    told: list[Found],
) -> tuple[SubmissionResult, int]:
    """Grade once, and count the processes that something outside may have ended.

    What the first try found in the notebook is kept in `told`, because a retry may know hidden inputs.
    """
    loading = allowances.own[LOADING]

    def shorten(name: str, size: int, parts: Iterator[bytes]) -> bytes:
        try:
            return without_outputs(name, size, parts, server, loading)
        except Ended as ended:
            raise Refused(ended.outcome.text) from None

    try:
        files = read(submission, shorten)
    except Refused as refused:
        return refuse(submission, assignment, str(refused)), 0
    with laid_out(files, assignment.lesson) as notebook:
        helpers = tuple(notebook.with_name(name) for name in files.helpers)
        earlier = handed_in_earlier(files, assignment)
        with _worker(notebook, assignment, server, loading, helpers, earlier) as worker:
            found = worker.definitions
            if reason := _why_refused(worker, found, assignment, files):
                return refuse(submission, assignment, reason, files.hash), worker.deaths
            told += [found] if found.names else []
            said = told[0] if told else found
            grader = SubmissionGrader(worker, assignment, files, server, stopped, allowances)
            # The notebook knows the Python of its own kernel
            versions = {**submission.versions, **stated_versions({"python": found.python})}
            newer = newer_than_here(versions)
            exercises = with_causes(grader.all_exercises(), found.skipped, files.notebook, newer)
            exercises = tuple(_with_remarks(each, said.remarks.get(each.name, ())) for each in exercises)
            exercises = with_answers(exercises, files.notebook)
            too_slow = tuple(
                f"{each.name}: {each.text}" for each in exercises if each.state in ("timed out", "not run")
            )
            attempts = tuple(f"{ATTEMPT}{each}" for each in worker.notes)
            attempts += tuple(f"{ATTEMPT}{each}" for each in grader.attempts if each not in worker.notes)
    result = SubmissionResult(
        submission.student,
        submission.lesson,
        "graded",
        file=submission.file or submission.path.name,
        submission=files.hash,
        assignment=assignment.hash,
        exercises=exercises,
        written=_written(assignment, said),
        notes=(
            *submission.notes,
            *_remarks(said, assignment),
            *_for_a_decision(exercises, newer),
            *too_slow,
            *attempts,
        ),
        left_out=submission.notes,
        handed_in=submission.handed_in,
        late=submission.late,
        versions=versions,
        graded_with=installed_versions(),
    )
    return result, worker.deaths + grader.deaths


def refuse(submission: Submission, assignment: Assignment, reason: str, digest: str = "") -> SubmissionResult:
    """Return the result of a submission that cannot be graded: 0 points, and why."""
    tasks = ((each.public, len(each.hidden)) for each in assignment.tasks)
    exercises = [ExerciseResult(it.name, it.number, it.points, 0.0, "not found", 0, n) for it, n in tasks]
    return SubmissionResult(
        submission.student,
        submission.lesson,
        "refused",
        reason,
        file=submission.file or submission.path.name,
        submission=digest or submission_hash(submission),
        assignment=assignment.hash,
        exercises=tuple(exercises),
        written=_written(assignment, Found()),
        notes=submission.notes,
        left_out=submission.notes,
        handed_in=submission.handed_in,
        late=submission.late,
        graded_with=installed_versions(),
    )


def _worker(
    notebook: Path,
    assignment: Assignment,
    server: WarmServer | None,
    allowance: Allowance,
    helpers: tuple[Path, ...] = (),
    earlier: Sequence[EarlierNotebook] = (),
    instead: Mapping[str, str] | None = None,
) -> Worker:
    return Worker(
        notebook,
        seconds=assignment.seconds,
        server=server,
        setup=assignment.setup,
        helpers=helpers,
        earlier=earlier,
        instead=instead or {},
        allowance=allowance,
        loading=allowance,
    )


def _why_refused(worker: Worker, found: Found, assignment: Assignment, files: Files) -> str:
    """Return the reason why there is nothing to grade; an empty string for a notebook of the lesson."""
    exercises = {task.public.name for task in assignment.tasks}
    defined = {*found.names, *found.remarks, *DEFINED.findall("\n".join(code_cells(files.notebook)))}
    if found.lesson not in ("", assignment.lesson) and exercises.isdisjoint(defined):
        said = f"it says that it is lesson {found.lesson[:60]!r}, and it defines no exercise of {assignment.lesson}"
        return f"{said}. Hand in the notebook of this lesson"
    if not found.names and found.skipped and found.skipped[0].cell == 0:
        outcome = worker.call("", Case(()))
        return outcome.text if outcome.status == "not found" else ""
    return ""


def _with_remarks(result: ExerciseResult, remarks: tuple[str, ...]) -> ExerciseResult:
    """Add what is unusual about an exercise's cells, which is the reason where it is not found."""
    if result.state == "not found" and remarks:
        return replace(result, text=" ".join(remarks), public=())
    return replace(result, notes=(*result.notes, *remarks))


def _written(assignment: Assignment, found: Found) -> tuple[WrittenAnswer, ...]:
    number = int(assignment.lesson.split("_")[0])
    return tuple(
        WrittenAnswer(
            each.name,
            f"{number}.W{at}",
            each.points,
            each.question,
            each.rubric,
            found.written.get(each.name, "").strip()[:LONGEST_ANSWER],
            " ".join(found.remarks.get(each.name, ())),
        )
        for at, each in enumerate(assignment.written, start=1)
    )


def _remarks(found: Found, assignment: Assignment) -> Iterator[str]:
    """Return notes for the assistant: another lesson or release, and statements that failed."""
    if found.lesson not in ("", assignment.lesson):
        yield f"the notebook says that it is lesson {found.lesson[:60]!r}"
    if found.version not in ("", assignment.version):
        yield f"made from release {found.version[:20]!r}; graded as {assignment.version!r}"
    yield from islice(
        (f"{name}: {text}" for name, texts in found.remarks.items() for text in texts), _MOST_NOTES
    )
    failed = [each for each in found.skipped if each.reason != NO_DEFINITION]
    for each in failed[:_MOST_NOTES]:
        yield f"code cell {each.cell}, line {each.line}: {each.reason[:200]}"


def _for_a_decision(exercises: Iterable[ExerciseResult], newer: Newer) -> Iterator[str]:
    """Return a note that names the exercises whose points a person has to decide."""
    if names := [each.name for each in exercises if each.state == "undecided"]:
        yield f"needs a decision ({', '.join(names)}): the notebook is written in {newer.against('the grader')}"


class SubmissionGrader:
    """One submission's exercises with one worker, within the submission's time."""

    def __init__(
        self,
        worker: Worker,
        assignment: Assignment,
        files: Files,
        server: WarmServer | None,
        stopped: Callable[[], bool],
        allowances: Allowances,
    ) -> None:
        self.stopped = stopped
        self.allowances, self.shares = allowances, allowances.own
        self.worker, self.assignment, self.files, self.server = worker, assignment, files, server
        self.deaths = 0  # of processes that an exercise was run in once more
        self.attempts: list[str] = []  # seen there

    def all_exercises(self) -> tuple[ExerciseResult, ...]:
        """Grade them: public cases, hidden cases, and then those again that failed by earlier ones."""
        tasks = self.assignment.tasks
        public = [self.public(task.public) for task in tasks]
        results = {
            task.public.name: self.result(task, lines, last)
            for task, (lines, last) in zip(tasks, public, strict=True)
        }
        for task in tasks:
            mine = results[task.public.name]
            if _is_right(mine) or mine.state in ("not found", "not attempted", "not run"):
                continue
            uses = used_by(task, self.assignment, code_cells(self.files.notebook))
            own = [results[name] for name in uses if name in results]
            slow = mine.state == "timed out" and bool(uses)
            if slow or not all(map(_is_right, own)) or any(":" in use for use in uses):
                results[task.public.name] = self.once_more(task, mine, uses)
        return tuple(results.values())

    def public(self, exercise: PublicExercise) -> tuple[list[str], Outcome]:
        """Run an exercise's public cases: what the check says of them, and the last outcome without its value."""
        outcomes = list(self.outcomes(exercise, exercise.cases))
        lines = self.explained(exercise, outcomes)
        last = replace(
            outcomes[-1], value=None, shown=tuple(name for each in outcomes for name in each.shown)
        )
        if exercise.earlier and (passed := count_passed(exercise, outcomes)) < len(exercise.cases):
            # As in the notebook, recorded answers are used where earlier work is not usable.
            self.stand_in(recorded(exercise, self.allowances.recorded[exercise.name]))
            outcomes = list(self.outcomes(exercise, exercise.cases))
            self.worker.stand_in({})
            if count_passed(exercise, outcomes) > passed:
                lines = [*self.explained(exercise, outcomes), STOOD_IN]
        return lines, last

    def result(self, task: Task, lines: Sequence[str], last: Outcome) -> ExerciseResult:
        """Grade one exercise; its public cases have been run."""
        hint = next((line for line in lines if line in task.mistakes), "")
        hopeless = last.status in ("not attempted", "not found", "timed out", "died")
        hidden = self.failure(task, last) if hopeless else self.hidden(task)
        right = hidden.state == "right"
        remark = remark_on(last.shown) if right else ""
        return ExerciseResult(
            task.public.name,
            task.public.number,
            task.public.points,
            task.public.points if right else task.points_of(hidden.parts),
            hidden.state,
            hidden.passed,
            len(task.hidden),
            hidden.text,
            hidden.line,
            tuple(line for line in lines if line != hint),
            hint,
            task.mistakes.get(hint, ""),
            notes=(remark,) if remark else task.notes_on(hidden.parts),
        )

    def explained(self, exercise: PublicExercise, outcomes: Sequence[Outcome]) -> list[str]:
        """Return the report of the public check, or that it cannot read the answers."""
        try:
            stopped = f"stopped after {exercise.seconds:g} seconds"
            if outcomes[-1].text == USED_UP:
                stopped = "stopped, because its calls took too long together"
            if outcomes[-1].text.startswith(NOT_RUN):
                return [f"{exercise.number} {exercise.name}: not run."]
            with np.errstate(all="ignore"):
                report = explain(exercise, outcomes, stopped)
        except Exception:  # noqa: BLE001 - whatever a stranger's answer is, the grader goes on
            return [f"{exercise.number} {exercise.name}: {UNREADABLE}."]
        lines = [*report.lines, *where_reused(report.lines, code_cells(self.files.notebook))]
        return [line[:LONGEST_TEXT] for line in lines]

    def once_more(self, task: Task, before: ExerciseResult, uses: Sequence[str]) -> ExerciseResult:
        """Run an exercise with the reference's earlier functions instead of the student's own."""
        self.shares = self.allowances.again
        needed = dependencies_of(uses, self.assignment.classes)
        classes = {
            use: self.assignment.classes[use].source for use in needed if use in self.assignment.classes
        }
        with contextlib.ExitStack() as stack:
            references = References(
                self.assignment,
                self.server,
                stack,
                max(self.assignment.seconds, task.public.seconds),
                self.allowances.references[task.public.name],
            )
            own = self.worker
            if classes:
                self.worker = stack.enter_context(self.with_classes(classes))
            try:
                self.stand_in({use: references.function(use) for use in needed if use not in classes})
                hidden = self.hidden(task)
            finally:
                if classes:
                    self.deaths += self.worker.deaths
                    self.attempts += self.worker.notes
                self.worker = own
            self.deaths += references.deaths
        right = hidden.state == "right"
        earned = (task.public.points if right else task.points_of(hidden.parts)) * task.with_reference
        parts = task.notes_on(hidden.parts) if earned > before.earned else before.notes
        names = " and ".join(map(in_words, uses))
        verdict = "right" if right else "not right either"
        note = " ".join(
            [
                f"Run again with the reference's {names} instead of yours: it is {verdict}.",
                *origins_of(uses, self.files, self.assignment),
            ]
        )
        return replace(
            before,
            state=hidden.state,
            passed=hidden.passed,
            text=hidden.text,
            line=hidden.line,
            earned=max(earned, before.earned),
            with_reference=True,
            notes=(note, *parts),
        )

    def stand_in(self, functions: Mapping[str, ReferenceFunction]) -> None:
        """Let functions answer in place of the student's until grading is stopped."""

        def until_stopped(function: ReferenceFunction) -> ReferenceFunction:
            def answer(args: tuple[Any, ...], kwargs: dict[str, Any]) -> Outcome:
                if self.stopped():
                    raise Stopped
                return function(args, kwargs)

            return answer

        self.worker.stand_in({use: until_stopped(function) for use, function in functions.items()})

    def with_classes(self, classes: Mapping[str, str]) -> Worker:
        """Start a worker with the student's notebook in which only some classes are the reference's."""
        given = handed_in_earlier(self.files, self.assignment)
        notebooks = {each.lesson: each for each in given}
        for each in self.assignment.earlier:
            number = number_of(each.lesson)
            mine = {use: source for use, source in classes.items() if split_use(use)[0] == number}
            if mine:
                uses = {
                    other
                    for use in mine
                    for other in self.assignment.classes[use].uses
                    if other not in classes
                }
                imports = [f'{split_use(use)[1]} = earlier("{use}")' for use in sorted(uses)]
                notebooks[each.lesson] = EarlierNotebook(
                    each.lesson, notebook_of(mine.values()), setup="\n".join([each.setup, *imports])
                )
        earlier = [notebooks[each.lesson] for each in self.assignment.earlier if each.lesson in notebooks]
        instead = {use: source for use, source in classes.items() if ":" not in use}
        own = self.worker
        return _worker(
            own.notebook,
            self.assignment,
            self.server,
            self.shares[LOADING],
            tuple(own.helpers),
            earlier,
            instead,
        )

    def outcomes(self, exercise: PublicExercise, cases: Sequence[Case]) -> Iterator[Outcome]:
        """Call a function for each case and yield the outcomes one by one, up to the last that is needed."""
        for case in cases:
            outcome = self.outcome(exercise, case)
            yield outcome
            if outcome.status in ("not attempted", "not found", "timed out", "died"):
                break

    def outcome(self, exercise: PublicExercise, case: Case) -> Outcome:
        """Call a function; in a new process if other exercises may have left it too little memory, files or threads."""
        outcome = self.answer(exercise, case)
        if _USED_UP.search(outcome.text) and self.worker.has_served_others(exercise.name):
            self.worker.close()
            outcome = self.answer(exercise, case)
        if outcome.text == NO_TIME_TO_LOAD:
            outcome = replace(outcome, text=not_run(self.shares))
        return (
            replace(outcome, status="raised", text="KeyboardInterrupt")
            if outcome.status == "interrupted"
            else outcome
        )

    def answer(self, exercise: PublicExercise, case: Case) -> Outcome:
        """Make the calls of a case; all of them together have the time of one."""
        if self.stopped():
            raise Stopped
        share = self.worker.allowance = self.shares[exercise.name]
        end = share.total + exercise.seconds

        def call(each: Case) -> Outcome:
            if share.total >= end:
                return Outcome("timed out")
            return self.worker.call(exercise.name, each, exercise.driver, end - share.total)

        try:
            return judging.answer(exercise.comparison, call, case)
        except (Stopped, SandboxError, ServerEnded):
            raise
        except Exception:  # noqa: BLE001 - whatever a stranger's answer is, the grader goes on
            return Outcome("died", text=UNREADABLE)

    def hidden(self, task: Task) -> HiddenResult:
        """Run the hidden cases and report the first failure."""
        failed: HiddenResult | None = None
        passed, changed = Counter[str](), False
        outcomes = self.outcomes(task.public, task.hidden)
        for case, outcome in zip(task.hidden, outcomes, strict=False):
            changed |= outcome.changed
            if wrong := describe_outcome(task.public, case, outcome, self.files, task.public.seconds):
                failed = failed or wrong
            else:
                passed[case.part] += 1
        if failed is None and changed:
            failed = HiddenResult("changes its input", 0, CHANGES_INPUT)
        tested = Counter(case.part for case in task.hidden)
        parts = tuple(part for part in task.parts if passed[part] == tested[part])
        kept = () if not failed or changed else parts
        result = failed or HiddenResult("right", 0)
        return replace(result, passed=passed.total(), parts=kept)

    def failure(self, task: Task, outcome: Outcome) -> HiddenResult:
        """Say how a case failed that has no answer."""
        return describe_failure(task.public.name, outcome, self.files, task.public.seconds)


def _is_right(result: ExerciseResult) -> bool:
    return result.state == "right" and not result.with_reference
