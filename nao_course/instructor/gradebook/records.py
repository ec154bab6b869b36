"""What the grader and then people say of a submission: plain values that the journal keeps and exports read."""

import hashlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from typing import Any, Literal

State = Literal[
    "right",
    "wrong",
    "raised",
    "timed out",
    "not run",
    "died",
    "no usable answer",
    "changes its input",
    "not attempted",
    "not found",
    "undecided",
]
Status = Literal["graded", "refused"]
_LONGEST_KIND = 200  # characters
ATTEMPT = "the sandbox saw it try: "  # how a note about that begins


def fingerprint(text: str) -> str:
    """Return a digest of an answer; blank lines and spaces at the ends of lines do not change it.

    It begins with a letter, so that no spreadsheet takes it for a number.
    """
    lines = filter(None, map(str.rstrip, text.splitlines()))
    return "a" + hashlib.sha256("\n".join(lines).encode("utf-8", "replace")).hexdigest()[:24]


@dataclass(frozen=True)
class ExerciseResult:
    """The result of one exercise, numbered such as "1.3", without hidden inputs or expected values.

    `points` is what it is worth, `earned` its points, and `passed` the number of hidden cases that passed. `text` says,
    for the student, how the first hidden case failed, by its kind and the shape of the answer; `line` is the student's
    line that raised; `public` is what the public check says, which may show values, because students have them all.
    `hint` is the message of the `mistake` that the public answers fit, by its name in the declaration. `with_reference`
    means that it failed with the student's earlier functions and was run again with the reference's. `notes` are
    further remarks for the student, and `answer` is the fingerprint of the cells that define it, empty without such a
    cell, and in results of earlier versions.
    """

    name: str
    number: str
    points: float
    earned: float
    state: State
    passed: int = 0
    cases: int = 0
    text: str = ""
    line: str = ""
    public: tuple[str, ...] = ()
    hint: str = ""
    mistake: str = ""
    with_reference: bool = False
    notes: tuple[str, ...] = ()
    answer: str = ""

    @property
    def kind(self) -> str:
        """The kind of a wrong answer, equal for answers that fail alike; empty if there is no wrong answer."""
        if (
            self.state in ("right", "not attempted", "not found", "not run", "undecided")
            or self.earned >= self.points > 0
        ):
            return ""
        said = f"mistake: {self.mistake}" if self.mistake else f"{self.state}: {self.text}"
        plain = said.encode("utf-8", "replace").decode()  # no halves of characters, which a file cannot hold
        return " ".join(plain.split())[:_LONGEST_KIND].rstrip(" :")


@dataclass(frozen=True)
class WrittenAnswer:
    """A written answer, numbered such as "1.W1", that a person marks by the rubric.

    Students never see the rubric before the answer is marked. `points` is what it is worth, `text` what the student
    wrote, and `note` where the text was, if it was not only in the cell for the answer.
    """

    name: str
    number: str
    points: float
    question: str
    rubric: str
    text: str = ""
    note: str = ""

    @property
    def fingerprint(self) -> str:
        """The fingerprint of the text, which a mark belongs to."""
        return fingerprint(self.text)


@dataclass(frozen=True)
class SubmissionResult:
    """The result of one student's submission of one lesson, such as "01_hsl_filtering".

    A file that is not a notebook that can be graded is "refused" with a reason; its exercises are there with 0 points.
    `submission` and `assignment` are hashes of the submission and of everything that it was graded with: solution,
    declaration, points, secret. `notes` are for the assistant: other files of the student that did not count,
    statements that did not run, attempts on the sandbox, whose level is `level`. `left_out` are notes on files that
    were made before any code ran; the student sees them, too. `seconds`, the duration, may differ between two runs that
    agree. `handed_in` is when it was handed in, with the offset from UTC if that is known, and `timed_by` who says so,
    as in `collecting.submissions.TRUST`; both are empty if unknown, and the latter in results of earlier versions.
    `late` is what the platform says. `versions` are of "python", "numpy" and others with which the notebook was
    written, as far as it or the receipt says so, and `graded_with` of the grader, empty in results of earlier versions.
    """

    student: str
    lesson: str
    status: Status
    reason: str = ""
    file: str = ""
    submission: str = ""
    assignment: str = ""
    exercises: tuple[ExerciseResult, ...] = ()
    written: tuple[WrittenAnswer, ...] = ()
    notes: tuple[str, ...] = ()
    level: str = ""
    seconds: float = field(default=0.0, compare=False)
    left_out: tuple[str, ...] = ()
    handed_in: str = ""
    timed_by: str = ""
    late: bool = False
    versions: Mapping[str, str] = field(default_factory=dict)
    graded_with: Mapping[str, str] = field(default_factory=dict)

    @property
    def undecided(self) -> tuple[ExerciseResult, ...]:
        """The exercises that wait for a person's decision."""
        return tuple(each for each in self.exercises if each.state == "undecided")

    def answer_to(self, exercise: str) -> str:
        """Return what a decision about an exercise is for: the answer's fingerprint, or the submission's hash."""
        found = [each.answer for each in self.exercises if each.name == exercise]
        return (found and found[0]) or self.submission

    def has_answer(self, exercise: str, decided_on: str) -> bool:
        """Return whether a decision about one of the exercises was made for the answer in this submission."""
        found = [each.answer for each in self.exercises if each.name == exercise]
        return bool(found) and decided_on in (found[0], self.submission)

    @property
    def attempts(self) -> tuple[str, ...]:
        """What the sandbox saw the student's code try, among the notes."""
        return tuple(each.removeprefix(ATTEMPT) for each in self.notes if each.startswith(ATTEMPT))

    @property
    def is_answered(self) -> bool:
        """Whether an exercise was attempted or a question was answered."""
        attempted = any(each.state not in ("not attempted", "not found") for each in self.exercises)
        return attempted or any(each.text.strip() for each in self.written)

    @property
    def earned(self) -> float:
        """Return the points of all exercises; written answers count when they are marked."""
        return sum(each.earned for each in self.exercises)

    @property
    def points(self) -> float:
        """What all exercises are worth."""
        return sum(each.points for each in self.exercises)


# --- what people say: each decision carries what it was made for, and counts for nothing else ---


def now() -> str:
    """Return the time in UTC, as records carry it."""
    return datetime.now(UTC).isoformat(timespec="seconds")


@dataclass(frozen=True)
class Override:
    """Points that a person gave an exercise instead of the grader, why, and when, in UTC.

    `decided_on` is the fingerprint of the answer, or the hash of the submission, if the answer's is unknown; `earned`
    are the points that the grader gave that answer. `given_by` is the person's name, empty in journals of earlier
    versions. `is_withdrawn` means that all earlier ones of the exercise are taken back.
    """

    student: str
    lesson: str
    exercise: str
    points: float
    reason: str
    time: str = field(default_factory=now)
    decided_on: str = ""
    earned: float = 0.0
    given_by: str = ""
    is_withdrawn: bool = False

    @property
    def item(self) -> str:
        """The exercise."""
        return self.exercise

    def fits(self, result: SubmissionResult) -> bool:
        """Return whether it counts: the answer is the same, and the grader has not found more in it since."""
        earned = [each.earned for each in result.exercises if each.name == self.exercise]
        return result.has_answer(self.exercise, self.decided_on) and earned[0] <= max(
            self.points, self.earned
        )


@dataclass(frozen=True)
class Mark:
    """Points that a person gave for a written answer, a comment for the student, and when, in UTC.

    `decided_on` is `WrittenAnswer.fingerprint` of the answer, and `given_by` and `is_withdrawn` are as of an
    `Override`. A second mark (`is_second`) of another person counts for nothing; it is compared with the first one.
    """

    student: str
    lesson: str
    question: str
    points: float
    comment: str = ""
    time: str = field(default_factory=now)
    decided_on: str = ""
    given_by: str = ""
    is_withdrawn: bool = False
    is_second: bool = False

    @property
    def item(self) -> str:
        """The question."""
        return self.question

    def fits(self, result: SubmissionResult) -> bool:
        """Return whether it counts: the answer is the same."""
        return any(
            each.name == self.question and each.fingerprint == self.decided_on for each in result.written
        )


@dataclass(frozen=True)
class Comment:
    """A comment for students on all wrong answers of a kind, and when, in UTC; empty if an earlier one is withdrawn.

    `kind` is `ExerciseResult.kind` of an exercise, and `decided_on` the fingerprint of the check's hint for this kind.
    """

    lesson: str
    exercise: str
    kind: str
    text: str
    time: str = field(default_factory=now)
    decided_on: str = ""
    given_by: str = ""


@dataclass(frozen=True)
class Request:
    """A student's request that a person looks at an exercise again; without an exercise, the unreadable part of a file.

    `answer` is the decision and why, and `decided_on` and `given_by` are as of an `Override`; they are empty while the
    request is open. `time` is when it was read.
    """

    student: str
    lesson: str
    exercise: str
    text: str
    answer: str = ""
    decided_on: str = ""
    time: str = field(default_factory=now, compare=False)
    given_by: str = ""


# --- as JSON ---


def as_json(result: SubmissionResult) -> dict[str, Any]:
    """Turn a result into values that JSON knows."""
    return asdict(result)


def from_json(table: Mapping[str, Any]) -> SubmissionResult:
    """Return a result from its table; raise a TypeError or KeyError if it is not a result's."""
    exercises = tuple(
        ExerciseResult(**{**each, "public": tuple(each["public"]), "notes": tuple(each["notes"])})
        for each in table["exercises"]
    )
    written = tuple(WrittenAnswer(**each) for each in table["written"])
    texts = {"notes": tuple(table["notes"]), "left_out": tuple(table.get("left_out", ()))}
    return SubmissionResult(**{**table, "exercises": exercises, "written": written, **texts})
