"""Deadlines, extensions, and what a late submission costs."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta

from nao_course.instructor.gradebook.records import SubmissionResult

Deadlines = Mapping[str, datetime]  # by lesson


@dataclass(frozen=True)
class Lateness:
    """When a submission was due for this student, and the share of the earned points that it loses, 0 to 1.

    `extended` means later than the deadline of the class, and `late` after the deadline and the grace period, or late
    by the platform without an extension. `days` are begun since the deadline, 0 if only the platform says that it is
    late.
    """

    due: datetime
    extended: bool
    handed_in: datetime | None
    late: bool
    days: int
    share: float

    @property
    def is_unmeasured(self) -> bool:
        """Whether only the platform says that it is late, which does not say by how much: nothing is deducted."""
        return self.late and not self.days


@dataclass(frozen=True)
class LatePolicy:
    """When lessons are due, and what late submissions lose; a lesson without a deadline is never late.

    `extensions` are deadlines of single students, by student and lesson. `per_day` is the share of the earned points, 0
    to 1, that is deducted for each day begun after the deadline, `most` the largest such share, and in the first
    `grace_hours` nothing is deducted. A time without an offset from UTC has the deadline's.
    """

    deadlines: Deadlines = field(default_factory=dict)
    extensions: Mapping[str, Deadlines] = field(default_factory=dict)
    per_day: float = 0.0
    grace_hours: float = 0.0
    most: float = 1.0

    def by_student(self, meant: Callable[[str], str | None]) -> LatePolicy:
        """Return the policy with the extensions by the names that the students have in the journal.

        `meant` returns the student whom a name, login or e-mail address means.
        """
        extensions = dict[str, Deadlines]()
        for word, times in self.extensions.items():
            student = meant(word) or word
            extensions[student] = {**extensions.get(student, {}), **times}
        return replace(self, extensions=extensions)

    def lateness(self, result: SubmissionResult) -> Lateness | None:
        """Return when a submission was due and what it loses; None if it has no deadline.

        >>> policy = LatePolicy({"01_toy": datetime.fromisoformat("2026-11-20 23:59+01:00")}, per_day=0.1)
        >>> result = SubmissionResult("ada", "01_toy", "graded", handed_in="2026-11-22 08:00+00:00")
        >>> found = policy.lateness(result)
        >>> found.days, found.share
        (2, 0.2)
        """
        own = self.extensions.get(result.student, {}).get(result.lesson)
        general = self.deadlines.get(result.lesson)
        due = own or general
        if due is None:
            return None
        extended = own is not None and (general is None or own > general)
        handed_in = None
        with suppress(ValueError, OverflowError):  # a time in the year 9999 has no equal in another time zone
            given = datetime.fromisoformat(result.handed_in)
            handed_in = given.astimezone(due.tzinfo) if given.tzinfo else given.replace(tzinfo=due.tzinfo)
        if handed_in is None or handed_in <= due:  # the platform knows better than a student's clock
            return Lateness(due, extended, handed_in, result.late and not extended, 0, 0.0)
        if handed_in - due <= timedelta(hours=self.grace_hours):
            return Lateness(due, extended, handed_in, False, 0, 0.0)
        days = math.ceil((handed_in - due) / timedelta(days=1))
        return Lateness(due, extended, handed_in, True, days, min(days * self.per_day, self.most))
