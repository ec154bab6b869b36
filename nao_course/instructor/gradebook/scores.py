"""What a submission earns once a person's changes and marks count beside what the grader found."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from typing import TypeVar

from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.late import Lateness, LatePolicy
from nao_course.instructor.gradebook.records import (
    Comment,
    ExerciseResult,
    Mark,
    Override,
    Request,
    SubmissionResult,
    WrittenAnswer,
    fingerprint,
)

Given = TypeVar("Given", Override, Mark)
MOST_DIFFERENCE = 0.5  # points between two markers that nobody has to look at
Comments = Mapping[tuple[str, str, str], Comment]  # by lesson, exercise and kind of the wrong answer


@dataclass(frozen=True)
class Score:
    """A result with the latest decisions of people on this answer: points and comments by exercise, marks by question.

    `lateness` is None without a deadline. `requests` are the student's last, by exercise. `earlier_overrides` and
    `earlier_marks` are proposals: decisions on an earlier answer, if there is none on this one. They count for nothing,
    and neither do `second_marks`, another person's marks of the same answers.
    """

    result: SubmissionResult
    overrides: Mapping[str, Override] = field(default_factory=dict)
    marks: Mapping[str, Mark] = field(default_factory=dict)
    lateness: Lateness | None = None
    comments: Mapping[str, str] = field(default_factory=dict)
    requests: Mapping[str, Request] = field(default_factory=dict)
    earlier_overrides: Mapping[str, Override] = field(default_factory=dict)
    earlier_marks: Mapping[str, Mark] = field(default_factory=dict)
    second_marks: Mapping[str, Mark] = field(default_factory=dict)

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
    def differing(self) -> list[tuple[Mark, Mark]]:
        """The marks of two people on the same answer that differ by more than MOST_DIFFERENCE."""
        both = [
            (self.marks[name], second) for name, second in self.second_marks.items() if name in self.marks
        ]
        return [pair for pair in both if abs(pair[0].points - pair[1].points) > MOST_DIFFERENCE + 1e-9]

    @property
    def lowering(self) -> list[tuple[ExerciseResult, Override]]:
        """The exercises with fewer points by hand than the grader gives."""
        both = [(each, self.overrides.get(each.name)) for each in self.result.exercises]
        return [(each, by_hand) for each, by_hand in both if by_hand and by_hand.points < each.earned]

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
    """Combine a result with the decisions on it; overrides, marks and requests of other students are ignored.

    By default, late submissions lose nothing. Comments are by lesson, exercise and kind of the wrong answer; requests
    are ordered, the oldest first.
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
    for_one: Callable[[str, str, str], AbstractContextManager[None]] = lambda *_: nullcontext(),
) -> Iterator[Score]:
    """Yield the same one by one, because all results may not fit into memory; `Journal.for_one` may guard each."""
    changed: dict[tuple[str, str], list[Override]] = defaultdict(list)
    marked: dict[tuple[str, str], list[Mark]] = defaultdict(list)
    asked: dict[tuple[str, str], dict[str, Request]] = defaultdict(dict)
    for request in requests:
        asked[request.student, request.lesson][request.exercise] = request
    for override in sorted(overrides, key=lambda each: each.time):
        changed[override.student, override.lesson].append(override)
    for mark in sorted(marks, key=lambda each: each.time):
        marked[mark.student, mark.lesson].append(mark)
    for each in results:
        key = (each.student, each.lesson)
        made: list[Score] = []
        with for_one(*key, "it is left out, because its points cannot be added up"):
            overrides_now, earlier_overrides = _by_answer(each, changed.get(key, ()))
            of_both = marked.get(key, ())
            marks_now, earlier_marks = _by_answer(each, (mark for mark in of_both if not mark.is_second))
            second_marks, _ = _by_answer(each, (mark for mark in of_both if mark.is_second))
            lateness, said = policy.lateness(each) if policy else None, _comments(each, comments or {})
            made = [
                Score(
                    each,
                    overrides_now,
                    marks_now,
                    lateness,
                    said,
                    asked.get(key, {}),
                    earlier_overrides,
                    earlier_marks,
                    second_marks,
                )
            ]
        yield from made


def _comments(result: SubmissionResult, comments: Comments) -> dict[str, str]:
    """Return the comments on a result's wrong answers by exercise."""
    found = {each.name: comments.get((result.lesson, each.name, each.kind)) for each in result.exercises}
    hints = {each.name: each.hint for each in result.exercises}
    return {
        name: comment.text
        for name, comment in found.items()
        if comment and comment.decided_on == fingerprint(hints[name])
    }


def _by_answer(
    result: SubmissionResult, decisions: Iterable[Given]
) -> tuple[dict[str, Given], dict[str, Given]]:
    """Return the last decisions on a result's own answers, and on earlier answers where there is none on its own."""
    decisions = list(decisions)
    count = {each.item: each for each in decisions if each.fits(result)}
    return count, {each.item: each for each in decisions if each.item not in count}


def each_journal_score(
    journal: Journal, lesson: str | None = None, student: str | None = None
) -> Iterator[Score]:
    """Yield the scores of a journal, or of a lesson or student in it, ordered by student and lesson."""
    yield from each_score(
        journal.each_result(lesson, student),
        journal.overrides(lesson),
        journal.marks(lesson),
        journal.policy,
        journal.comments(),
        journal.requests(),
        journal.for_one,
    )


def all_scores(journal: Journal, lesson: str | None = None) -> list[Score]:
    """Return all scores of a journal or of a lesson, ordered by student and lesson."""
    return list(each_journal_score(journal, lesson))
