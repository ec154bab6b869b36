"""Grades one submission: its functions run in a worker, and what is expected of them stays here.

In a worker the public cases of all exercises come before the first hidden one. What a student may see in full, the
answers to public cases, was said before any hidden input was there to be passed on; of what comes later only the kind
of failure is told, in words of ours, and a line that stands in the submission.
"""

from __future__ import annotations

import builtins
import contextlib
import hashlib
import json
import re
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_course.exercises.case import Case
from nao_course.exercises.checking import explain
from nao_course.exercises.comparisons import Verdict
from nao_course.exercises.definitions import NO_DEFINITION, load_definitions, read_cells
from nao_course.exercises.exercise import ANSWER_HERE, Exercise, PublicExercise, Written
from nao_course.exercises.running import Outcome
from nao_course.instructor.authoring.plans import hidden_cases, publish
from nao_course.instructor.autograding.secret import keyed
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.submissions import Files, Submission, read
from nao_course.instructor.gradebook.records import (
    ATTEMPT,
    ExerciseResult,
    State,
    SubmissionResult,
    WrittenAnswer,
)
from nao_course.instructor.sandbox.confinement import SandboxError
from nao_course.instructor.sandbox.worker import UNREADABLE, Found, ServerEnded, Worker

if TYPE_CHECKING:
    from nao_course.instructor.authoring.course import Course
    from nao_course.instructor.sandbox.warm_server import WarmServer

RULES = "1"  # how it is graded; another number has everything graded again
SECONDS = 10.0  # wall clock of a call
LONGEST_ANSWER = 20_000  # characters of a written answer
LONGEST_TEXT = 1000  # of what a public check says
_MOST_NOTES = 20
_MOST_TRIES = 4  # at a submission whose processes die
_MOST_SERVERS = 3  # warm servers that may die under one submission
_CHANGES = "Your function changes its input. Return a new array instead."
_ERRORS = {
    name for name, kind in vars(builtins).items() if isinstance(kind, type) and issubclass(kind, Exception)
}
_KNOWN_ERRORS = _ERRORS | {
    "LinAlgError",
    "AxisError",
    "error",
    "SympifyError",
    "SystemExit",
    "KeyboardInterrupt",
}
_LINE = re.compile(r"line (\d{1,5}): (.+)")
_WHOLE = rb'(?<!\\)(?:"|\\n)(?: |\\t)*%b(?: |\\t|\\r)*(?:\\n|")'  # a line in a notebook: no part of one, of any choice


class GraderError(RuntimeError):
    """The grader itself failed at a submission: nobody is given 0 points for that."""


class Stopped(Exception):  # noqa: N818 - somebody wanted it
    """Grading was given up before the submission had a result."""


@dataclass(frozen=True)
class Task:
    """An exercise as it is graded; no code, so that it can be sent to another process.

    Parameters
    ----------
    public : PublicExercise
        What a student's check knows.
    hidden : tuple of Case
        With what is expected.
    uses : tuple of str
        Earlier exercises that it calls.
    with_reference : float
        Fraction of the points where it is right with the reference's `uses` only.
    mistakes : mapping of str to str
        Names of the mistakes by their messages.
    """

    public: PublicExercise
    hidden: tuple[Case, ...]
    uses: tuple[str, ...] = ()
    with_reference: float = 1.0
    mistakes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Assignment:
    """A lesson as it is graded.

    Parameters
    ----------
    lesson : str
        Such as "01_hsl_filtering".
    tasks : tuple of Task
        Its exercises, in the lesson's order.
    written : tuple of Written
        Its written questions.
    reference : Path
        The solution notebook.
    setup : str
        The released set-up cell.
    blank : str
        What stands where no written answer was given.
    hash : str
        Of all that a score depends on beside the submission.
    seconds : float
        Wall clock of a call.
    version : str
        The course's: what a notebook of this release is stamped with.
    """

    lesson: str
    tasks: tuple[Task, ...]
    written: tuple[Written, ...] = ()
    reference: Path = Path()
    setup: str = ""
    blank: str = ""
    hash: str = ""
    seconds: float = SECONDS
    version: str = ""


def prepare(course: Course, lesson: str, secret: bytes) -> Assignment:
    """Draw a lesson's hidden cases and work out what is expected of them.

    Parameters
    ----------
    course : Course
        From `course.load_course`.
    lesson : str
        Number or name.
    secret : bytes
        The instructor's: the same secret draws the same cases.

    Returns
    -------
    Assignment
        To grade with.

    Raises
    ------
    LessonError, PlanError, FileNotFoundError
        If there is no such lesson, its declaration does not fit its solution, or it has not been built.
    """
    (name,) = course.names([lesson])
    plan, notebook = course.plan(name), course.solutions / f"{name}.ipynb"
    released = course.root / "notebooks" / f"{name}.ipynb"
    for path in (notebook, released):
        if not path.is_file():
            raise FileNotFoundError(f"there is no {path}: run `nao-course build` first")
    reference = load_definitions(notebook)
    public = publish(name, plan, reference)
    tasks = tuple(
        _task(each, known, reference[each.name], int(keyed(secret, "hidden cases", name, each.name), 16))
        for each, known in zip(plan.exercises, public.exercises, strict=True)
    )
    setup = "\n\n".join(source for role, source in read_cells(released) if role == "setup")
    declaration = course.solutions / "exercises" / f"{name}.py"
    told = [
        (RULES, metadata.version("nao-course"), name, keyed(secret, "assignment"), setup),
        read_cells(notebook),
        declaration.read_text(encoding="utf-8") if declaration.exists() else "",
        plan.points,
    ]
    digest = hashlib.sha256(json.dumps(told).encode()).hexdigest()
    return Assignment(
        name,
        tasks,
        tuple(plan.written),
        notebook,
        setup,
        ANSWER_HERE,
        digest,
        version=course.version,
    )


def _task(exercise: Exercise, public: PublicExercise, function: Callable[..., Any], seed: int) -> Task:
    return Task(
        public,
        tuple(hidden_cases(exercise, function, seed)),
        tuple(exercise.uses),
        exercise.with_reference,
        {mistake.message: mistake.name for mistake in exercise.mistakes},
    )


# --- side by side, and alone ---


class Turns:
    """Lets the calls of several submissions run side by side, and one alone: so that no time-out is another's fault."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._running, self._alone = 0, False

    @contextlib.contextmanager
    def beside(self) -> Iterator[None]:
        """Run the block beside others', once nobody is alone."""
        with self._changed:
            self._changed.wait_for(lambda: not self._alone)
            self._running += 1
        try:
            yield
        finally:
            with self._changed:
                self._running -= 1
                self._changed.notify_all()

    @contextlib.contextmanager
    def alone(self) -> Iterator[None]:
        """Run the block once all others' have ended; none begins meanwhile."""
        with self._changed:
            self._changed.wait_for(lambda: not self._alone)
            self._alone = True
            self._changed.wait_for(lambda: not self._running)
        try:
            yield
        finally:
            with self._changed:
                self._alone = False
                self._changed.notify_all()


# --- one submission ---


def grade(
    submission: Submission,
    assignment: Assignment,
    server: WarmServer | None = None,
    level: str = "own process",
    stopped: Callable[[], bool] = lambda: False,
    turns: Turns | None = None,
) -> SubmissionResult:
    """Grade a submission.

    Parameters
    ----------
    submission : Submission
        From `submissions.gather`.
    assignment : Assignment
        From `prepare`, of its lesson.
    server : WarmServer, optional
        Where its worker comes from; without one it is a new process.
    level : str
        The sandbox level that this is, for the result.
    stopped : callable
        Asked before each call: whether to give up.
    turns : Turns, optional
        Shared by all that are graded at the same time.

    Returns
    -------
    SubmissionResult
        With a score or a reason, whatever was handed in.

    Raises
    ------
    GraderError
        If the grader itself fails: there is no score then.
    SandboxError
        If a worker could not be confined: nothing may be graded then.
    Stopped
        If it was to give up.
    """
    start = time.monotonic()
    try:
        result = _agreed(
            lambda: _in_spite_of_the_server(
                lambda: _grade(submission, assignment, server, stopped, turns or Turns())
            )
        )
    except (Stopped, SandboxError):
        raise
    except Exception as error:
        raise GraderError(
            f"{submission.student}, {submission.lesson}: the grader failed ({type(error).__name__}: {error})"
        ) from error
    return replace(result, level=level, seconds=time.monotonic() - start)


def _agreed(work: Callable[[], tuple[SubmissionResult, int]]) -> SubmissionResult:
    """Grade until no process has died, or two results agree.

    A process may have been ended by somebody outside, or because the machine was short of memory. What is the
    submission's own doing happens again.
    """
    result, deaths = work()
    for _ in range(_MOST_TRIES - 1):
        if not deaths:
            break
        before = result
        result, deaths = work()
        if result == before:
            break
    return result


def _in_spite_of_the_server(
    work: Callable[[], tuple[SubmissionResult, int]],
) -> tuple[SubmissionResult, int]:
    """Begin again where the warm server died: that is no fault of this submission, as far as anyone can tell."""
    for _ in range(_MOST_SERVERS - 1):
        with contextlib.suppress(ServerEnded):
            return work()
    return work()


def _grade(
    submission: Submission,
    assignment: Assignment,
    server: WarmServer | None,
    stopped: Callable[[], bool],
    turns: Turns,
) -> tuple[SubmissionResult, int]:
    """Grade once; also say how many processes died on the way."""
    try:
        files = read(submission)
    except Refused as refused:
        return refuse(submission, assignment, str(refused)), 0
    with _laid_out(files, assignment.lesson) as notebook:
        helpers = tuple(notebook.with_name(name) for name in files.helpers)
        with _worker(notebook, assignment, server, helpers) as worker:
            found = worker.definitions
            if not found.names and (reason := _why_unreadable(worker, found)):
                return refuse(submission, assignment, reason, files.hash), worker.deaths
            sitting = _Sitting(worker, assignment, files, server, stopped, turns)
            exercises = sitting.all_exercises()
            attempts = tuple(f"{ATTEMPT}{each}" for each in worker.notes)
            deaths = worker.deaths + sitting.deaths
    result = SubmissionResult(
        submission.student,
        submission.lesson,
        "graded",
        file=submission.file or submission.path.name,
        submission=files.hash,
        assignment=assignment.hash,
        exercises=exercises,
        written=_written(assignment, found.written),
        notes=(*submission.notes, *_remarks(found, assignment), *attempts),
    )
    return result, deaths


def refuse(submission: Submission, assignment: Assignment, reason: str, digest: str = "") -> SubmissionResult:
    """Return the result of a submission that cannot be graded: 0 points, and why."""
    exercises = [
        ExerciseResult(
            each.public.name, each.public.number, each.public.points, 0.0, "not found", 0, len(each.hidden)
        )
        for each in assignment.tasks
    ]
    return SubmissionResult(
        submission.student,
        submission.lesson,
        "refused",
        reason,
        file=submission.file or submission.path.name,
        submission=digest or submission_hash(submission),
        assignment=assignment.hash,
        exercises=tuple(exercises),
        written=_written(assignment, {}),
        notes=submission.notes,
    )


def submission_hash(submission: Submission) -> str:
    """Return the hash of what was handed in; of the reason, where it cannot be read."""
    try:
        return read(submission).hash
    except Refused as refused:
        return hashlib.sha256(f"{submission.file}\0{refused}".encode()).hexdigest()


@contextlib.contextmanager
def _laid_out(files: Files, lesson: str) -> Iterator[Path]:
    """Write what was read, and hashed, into a folder of its own; whatever happens there, it goes."""
    with tempfile.TemporaryDirectory(prefix="nao_course_", ignore_cleanup_errors=True) as folder:
        notebook = Path(folder, f"{lesson}.ipynb")
        notebook.write_bytes(files.notebook)
        for name, content in files.helpers.items():
            notebook.with_name(name).write_bytes(content)
        yield notebook


def _worker(
    notebook: Path, assignment: Assignment, server: WarmServer | None, helpers: tuple[Path, ...] = ()
) -> Worker:
    return Worker(
        notebook, seconds=assignment.seconds, server=server, setup=assignment.setup, helpers=helpers
    )


def _why_unreadable(worker: Worker, found: Found) -> str:
    """Why there is nothing to grade; nothing where it is a notebook, only without definitions."""
    if found.skipped and found.skipped[0].cell == 0:
        outcome = worker.call("", Case(()))
        return outcome.text if outcome.status == "not found" else ""
    return ""


def _written(assignment: Assignment, answers: Mapping[str, str]) -> tuple[WrittenAnswer, ...]:
    number = int(assignment.lesson.split("_")[0])
    return tuple(
        WrittenAnswer(
            each.name,
            f"{number}.W{at}",
            each.points,
            each.question,
            each.rubric,
            _without_blank(answers.get(each.name, ""), assignment.blank)[:LONGEST_ANSWER],
        )
        for at, each in enumerate(assignment.written, start=1)
    )


def _without_blank(text: str, blank: str) -> str:
    text = text.strip()
    return text.removeprefix(blank).strip() if blank else text


def _remarks(found: Found, assignment: Assignment) -> Iterator[str]:
    """Where a notebook is of another lesson or release, and its statements that failed, for the assistant."""
    if found.lesson not in ("", assignment.lesson):
        yield f"the notebook says that it is lesson {found.lesson[:60]!r}"
    if found.version not in ("", assignment.version):
        yield f"made from release {found.version[:20]!r}; graded as {assignment.version!r}"
    failed = [each for each in found.skipped if each.reason != NO_DEFINITION]
    for each in failed[:_MOST_NOTES]:
        yield f"code cell {each.cell}, line {each.line}: {each.reason[:200]}"


@dataclass(frozen=True)
class _Hidden:
    """What came of an exercise's hidden cases."""

    state: State
    passed: int
    text: str = ""
    line: str = ""
    changed: bool = False


class _Sitting:
    """One submission's exercises with one worker, within the submission's time."""

    def __init__(
        self,
        worker: Worker,
        assignment: Assignment,
        files: Files,
        server: WarmServer | None,
        stopped: Callable[[], bool],
        turns: Turns,
    ) -> None:
        self.stopped, self.turns = stopped, turns
        self.worker, self.assignment, self.files, self.server = worker, assignment, files, server
        self.deaths = 0  # of the reference's processes

    def all_exercises(self) -> tuple[ExerciseResult, ...]:
        """Grade them: public cases, hidden cases, and then those again that failed by earlier ones."""
        tasks = self.assignment.tasks
        public = [self.outcomes(task.public, task.public.cases) for task in tasks]
        results = {
            task.public.name: self.result(task, outcomes)
            for task, outcomes in zip(tasks, public, strict=True)
        }
        for task in tasks:
            mine = results[task.public.name]
            own = [results[name] for name in task.uses if name in results]
            if (
                not _is_right(mine)
                and not all(map(_is_right, own))
                and mine.state not in ("not found", "not attempted")
            ):
                results[task.public.name] = self.once_more(task, mine)
        return tuple(results.values())

    def result(self, task: Task, outcomes: Sequence[Outcome]) -> ExerciseResult:
        """Grade one exercise; its public cases have been run."""
        lines = self.explained(task.public, outcomes)
        hint = next((line for line in lines if line in task.mistakes), "")
        hopeless = outcomes[-1].status in ("not attempted", "not found", "timed out", "died")
        hidden = self.fail(outcomes[-1], 0) if hopeless else self.hidden(task)
        right = hidden.state == "right"
        return ExerciseResult(
            task.public.name,
            task.public.number,
            task.public.points,
            task.public.points if right else 0.0,
            hidden.state,
            hidden.passed,
            len(task.hidden),
            hidden.text,
            hidden.line,
            tuple(line for line in lines if line != hint),
            hint,
            task.mistakes.get(hint, ""),
            notes=(_CHANGES,) if right and hidden.changed else (),
        )

    def explained(self, exercise: PublicExercise, outcomes: Sequence[Outcome]) -> list[str]:
        """What the public check says; of answers that it cannot even look at, that."""
        try:
            with np.errstate(all="ignore"):
                report = explain(exercise, outcomes, f"stopped after {self.assignment.seconds:g} seconds")
        except Exception:  # noqa: BLE001 - whatever a stranger's answer is, the grader goes on
            return [f"{exercise.number} {exercise.name}: {UNREADABLE}."]
        return [line[:LONGEST_TEXT] for line in report.lines]

    def once_more(self, task: Task, before: ExerciseResult) -> ExerciseResult:
        """Run an exercise with the reference's earlier functions instead of the student's own."""
        with _worker(self.assignment.reference, self.assignment, self.server) as reference:
            self.worker.lend({name: _lent(reference, name) for name in task.uses})
            hidden = self.hidden(task)
            self.deaths += reference.deaths
        right = hidden.state == "right"
        names = " and ".join(task.uses)
        came = "right" if right else "not right either"
        note = f"Run again with the reference's {names} instead of yours: it is {came}."
        return replace(
            before,
            state=hidden.state,
            passed=hidden.passed,
            text=hidden.text,
            line=hidden.line,
            earned=task.public.points * task.with_reference if right else 0.0,
            with_reference=True,
            notes=(note, *((_CHANGES,) if right and hidden.changed else ())),
        )

    def outcomes(self, exercise: PublicExercise, cases: Sequence[Case]) -> list[Outcome]:
        """Call a function for each case, up to one that is the last."""
        found: list[Outcome] = []
        for case in cases:
            found.append(self.outcome(exercise, case))
            if found[-1].status in ("not attempted", "not found", "timed out", "died"):
                break
        return found

    def outcome(self, exercise: PublicExercise, case: Case) -> Outcome:
        """Call a function; a time-out is tried once more in a fresh worker, while no other submission runs."""
        for turn in (self.turns.beside, self.turns.alone):
            if self.stopped():
                raise Stopped
            with turn():
                outcome = self.worker.call(exercise.name, case, exercise.driver)
            if outcome.status != "timed out":
                break
        return (
            replace(outcome, status="raised", text="KeyboardInterrupt")
            if outcome.status == "interrupted"
            else outcome
        )

    def hidden(self, task: Task) -> _Hidden:
        """Run the hidden cases: the first one that fails is what is told."""
        failed: _Hidden | None = None
        passed, changed = 0, False
        outcomes = self.outcomes(task.public, task.hidden)
        for case, outcome in zip(task.hidden, outcomes, strict=False):
            changed |= outcome.changed
            if outcome.status != "value":
                failed = failed or self.fail(outcome, 0)
            elif verdict := _compared(task.public, case, outcome.value):
                passed += 1
            else:
                failed = failed or _Hidden(
                    _state_of(verdict), 0, _told(verdict, case.expected, outcome.value)
                )
        if failed is None and changed and task.public.in_place:
            failed = _Hidden("changes its input", 0, _CHANGES)
        return (
            replace(failed, passed=passed, changed=changed)
            if failed
            else _Hidden("right", passed, changed=changed)
        )

    def fail(self, outcome: Outcome, passed: int) -> _Hidden:
        """Say how a case failed, in our words only."""
        match outcome.status:
            case "raised":
                kind = outcome.text.split(":")[0]
                kind = kind if kind in _KNOWN_ERRORS else "an exception of its own"
                return _Hidden("raised", passed, f"It raises {kind}.", self.own_line(outcome.line))
            case "timed out":
                return _Hidden(
                    "timed out", passed, f"It took longer than {self.assignment.seconds:g} seconds."
                )
            case "not attempted":
                return _Hidden("not attempted", passed)
            case "not found":
                return _Hidden("not found", passed)
            case "died" if outcome.text != UNREADABLE:
                return _Hidden("died", passed, _how_it_died(outcome.text))
        return _Hidden("no usable answer", passed, "Its answer is of a kind that cannot be sent.")

    def own_line(self, line: str) -> str:
        """A student's line that raised, if it stands in the submission: anything else might be an input."""
        found = _LINE.fullmatch(line)
        most = max(
            self.files.notebook.count(rb"\n"), *(each.count(b"\n") for each in self.files.helpers.values()), 0
        )
        if not found or int(found[1]) > most + 1:
            return ""
        for ascii_only in (True, False):
            text = json.dumps(found[2], ensure_ascii=ascii_only)[1:-1].encode()
            if text in self.files.notebook and re.search(_WHOLE % re.escape(text), self.files.notebook):
                return line
        text = found[2].encode()
        helpers = (line.strip() for content in self.files.helpers.values() for line in content.splitlines())
        return line if text in helpers else ""


def _is_right(result: ExerciseResult) -> bool:
    return result.state == "right" and not result.with_reference


def _lent(reference: Worker, name: str) -> Callable[[tuple[Any, ...], dict[str, Any]], Outcome]:
    """The reference's function as a worker may ask for it: it runs in a worker of its own, and its code stays there."""

    def answer(args: tuple[Any, ...], kwargs: dict[str, Any]) -> Outcome:
        return replace(reference.call(name, Case(args, kwargs=kwargs)), line="", output="")

    return answer


def _compared(exercise: PublicExercise, case: Case, answer: Any) -> Verdict:
    """Compare an answer; one that the comparison cannot even look at is none."""
    try:
        with np.errstate(all="ignore"):
            return exercise.comparison.compare(case.expected, answer)
    except Exception:  # noqa: BLE001 - whatever a stranger's answer is, the grader goes on
        return Verdict("type", UNREADABLE)


def _state_of(verdict: Verdict) -> State:
    return "no usable answer" if verdict.text == UNREADABLE else "wrong"


def _told(verdict: Verdict, expected: Any, got: Any) -> str:
    """Say in which way an answer differs, and nothing that depends on the values of a hidden input."""
    match verdict.kind:
        case "nothing":
            return "It returns None, or None in a place where a value is wanted. Is a return missing?"
        case "shape":
            return f"Its answer has the wrong shape: {_shapes(expected, got) or 'another one is wanted'}."
        case "nan":
            return "Its answer is NaN where it should not be, or is not where it should be."
        case "type":
            return "Its answer is of the wrong kind."
    return "Its answer has the right kind and shape, but not the right values."


def _shapes(expected: Any, got: Any) -> str:
    """In which dimension two answers differ; sizes are not said, for a function can make any size of its input."""
    if isinstance(expected, tuple | list) and isinstance(got, tuple | list):
        pairs = zip(expected, got, strict=False)
        return next((text for one, other in pairs if (text := _shapes(one, other))), "")
    if isinstance(expected, dict) and isinstance(got, dict):
        return _shapes(list(expected.values()), [got.get(name) for name in expected])
    try:
        wanted, have = np.shape(expected), np.shape(got)
    except ValueError:
        return ""
    if len(wanted) != len(have):
        return f"{len(have)} dimensions where {len(wanted)} are wanted"
    wrong = [str(axis) for axis, (one, other) in enumerate(zip(wanted, have, strict=True)) if one != other]
    return f"another size along axis {', '.join(wrong)}" if wrong else ""


def _how_it_died(text: str) -> str:
    found = re.match(r"the process was ended by signal (\d{1,2})\b", text)
    name = signal.strsignal(int(found[1])) if found and int(found[1]) in signal.valid_signals() else ""
    return f"It ends Python itself{f' ({name})' if name else ''}."
