"""What a submission earns once a person's changes and marks count beside what the grader found."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from nao_course.instructor.gradebook.late import Lateness, LatePolicy
from nao_course.instructor.gradebook.records import (
    ExerciseResult,
    Mark,
    Override,
    Request,
    SubmissionResult,
    WrittenAnswer,
)

Comments = Mapping[tuple[str, str, str], str]  # by lesson, exercise and kind of the wrong answer


@dataclass(frozen=True)
class Score:
    """A result with what people said of it.

    Parameters
    ----------
    result : SubmissionResult
        What the grader found.
    overrides : mapping of str to Override
        Points that a person set, by exercise; the latest.
    marks : mapping of str to Mark
        Of written answers, by question; the latest.
    lateness : Lateness, optional
        When it was due, and what it loses; None without a deadline.
    comments : mapping of str to str
        Comments on wrong answers, by exercise.
    requests : mapping of str to Request
        The student's last request about an exercise, by exercise.
    """

    result: SubmissionResult
    overrides: Mapping[str, Override] = field(default_factory=dict)
    marks: Mapping[str, Mark] = field(default_factory=dict)
    lateness: Lateness | None = None
    comments: Mapping[str, str] = field(default_factory=dict)
    requests: Mapping[str, Request] = field(default_factory=dict)

    def of(self, exercise: ExerciseResult) -> float:
        """Return the points of an exercise; points from a person replace the grader's."""
        override = self.overrides.get(exercise.name)
        return exercise.earned if override is None else override.points

    def of_answer(self, answer: WrittenAnswer) -> float | None:
        """Return the points of a written answer: None until it is marked, 0 if it is empty."""
        mark = self.marks.get(answer.name)
        if mark is not None:
            return mark.points
        return None if answer.text.strip() else 0.0

    @property
    def earned(self) -> float:
        """Points so far: exercises and marked answers, less what is deducted because it was late."""
        return self._before_deduction - self.deducted

    @property
    def deducted(self) -> float:
        """Points that are deducted because it was late."""
        return self._before_deduction * (self.lateness.share if self.lateness else 0.0)

    @property
    def is_late(self) -> bool:
        """Whether it was handed in late: by the deadline in course.toml, or else by the platform."""
        return self.lateness.late if self.lateness else self.result.late

    @property
    def _before_deduction(self) -> float:
        return sum(map(self.of, self.result.exercises)) + sum(
            self.of_answer(each) or 0.0 for each in self.result.written
        )

    @property
    def points(self) -> float:
        """What all exercises and questions are worth."""
        return self.result.points + sum(each.points for each in self.result.written)

    @property
    def waiting(self) -> tuple[WrittenAnswer, ...]:
        """Written answers that a person has still to mark."""
        return tuple(each for each in self.result.written if self.of_answer(each) is None)


def score(
    result: SubmissionResult,
    overrides: Iterable[Override] = (),
    marks: Iterable[Mark] = (),
    policy: LatePolicy | None = None,
    comments: Comments | None = None,
    requests: Iterable[Request] = (),
) -> Score:
    """Put together what belongs to a result.

    Parameters
    ----------
    result : SubmissionResult
        Of one student and lesson.
    overrides, marks : iterable of Override, Mark
        Of anyone; what is another's does not count.
    policy : LatePolicy, optional
        What late submissions lose; nothing by default.
    comments : mapping of (str, str, str) to str, optional
        Comments by lesson, exercise and kind of the wrong answer.
    requests : iterable of Request
        Of anyone, the oldest first.
    """
    return scores([result], overrides, marks, policy, comments, requests)[0]


def scores(
    results: Iterable[SubmissionResult],
    overrides: Iterable[Override] = (),
    marks: Iterable[Mark] = (),
    policy: LatePolicy | None = None,
    comments: Comments | None = None,
    requests: Iterable[Request] = (),
) -> list[Score]:
    """Put together what belongs to each of many results, in their order."""
    return list(each_score(results, overrides, marks, policy, comments, requests))


def each_score(
    results: Iterable[SubmissionResult],
    overrides: Iterable[Override] = (),
    marks: Iterable[Mark] = (),
    policy: LatePolicy | None = None,
    comments: Comments | None = None,
    requests: Iterable[Request] = (),
) -> Iterator[Score]:
    """Yield the same one by one, because all results may not fit into memory."""
    changed: dict[tuple[str, str], dict[str, Override]] = defaultdict(dict)
    marked: dict[tuple[str, str], dict[str, Mark]] = defaultdict(dict)
    asked: dict[tuple[str, str], dict[str, Request]] = defaultdict(dict)
    for request in requests:
        asked[request.student, request.lesson][request.exercise] = request
    for override in sorted(overrides, key=lambda each: each.time):
        changed[override.student, override.lesson][override.exercise] = override
    for mark in sorted(marks, key=lambda each: each.time):
        marked[mark.student, mark.lesson][mark.question] = mark
    for each in results:
        key = (each.student, each.lesson)
        said = {
            exercise.name: text
            for exercise in each.exercises
            if comments and (text := comments.get((each.lesson, exercise.name, exercise.kind)))
        }
        lateness = policy.lateness(each) if policy else None
        yield Score(each, changed.get(key, {}), marked.get(key, {}), lateness, said, asked.get(key, {}))
