"""What a late submission loses: nothing in time, more each day, never more than there is."""

from datetime import UTC, datetime, timedelta, timezone

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nao_course.instructor.gradebook.late import LatePolicy
from nao_course.instructor.gradebook.records import Override
from nao_course.instructor.gradebook.scores import score
from tests.pages import answer, exercise, mark, result

LESSON = "01_hsl_filtering"
DUE = datetime(2026, 11, 20, 22, 59, tzinfo=UTC)


def handed_in(after, **changed):
    """A submission some hours after the deadline; of an unknown time for None."""
    time = "" if after is None else (DUE + timedelta(hours=after)).isoformat(" ", "minutes")
    return result("ada", exercise(points=4.0, earned=4.0), answer(), handed_in=time, **changed)


def policy(**changed):
    return LatePolicy({LESSON: DUE}, **{"per_day": 0.1, "grace_hours": 2, "most": 0.5, **changed})


@pytest.mark.parametrize(
    ("after", "days"), [(-1, 0), (0, 0), (2, 0), (2.1, 1), (24, 1), (24.1, 2), (1000, 42), (None, 0)]
)
def test_each_day_begun_after_the_grace_period_costs_its_share(after, days):
    found = policy().lateness(handed_in(after))
    assert (found.days, found.late) == (days, days > 0)
    assert found.share == pytest.approx(min(0.1 * days, 0.5))


@pytest.mark.parametrize("time", ["0001-01-01 00:00+14:00", "9999-12-31 23:59-14:00", "no time"])
@pytest.mark.parametrize("due", [DUE, DUE.replace(year=9999, month=12, day=31)])
def test_a_time_beyond_all_calendars_is_unknown_or_counts_and_stops_nothing(time, due):
    due = due.astimezone(timezone(timedelta(hours=-1)))
    strict = LatePolicy({LESSON: due}, per_day=0.1, grace_hours=48)
    found = strict.lateness(result("ada", exercise(), handed_in=time))
    assert not found.late and found.share == 0


def test_nothing_is_late_without_a_deadline_whose_offset_counts():
    assert LatePolicy(per_day=1).lateness(handed_in(1000)) is None
    assert score(handed_in(1000)).earned == 4
    for time, days in (("2026-11-20 23:59+01:00", 0), ("2026-11-20 22:59+01:00", 1)):
        due = LatePolicy({LESSON: datetime.fromisoformat(time)}, per_day=0.1)
        assert due.lateness(handed_in(0)).days == days


def test_an_extension_counts_for_its_student_and_lesson_only():
    later = {LESSON: DUE + timedelta(days=7)}
    assert policy(extensions={"ada": later}).lateness(handed_in(100)).share == 0
    assert policy(extensions={"ada": later}).lateness(handed_in(24 * 7 + 3)).days == 1
    assert policy(extensions={"ben": later}).lateness(handed_in(100)).days == 5
    assert policy(extensions={"ada": {"02_goalposts": later[LESSON]}}).lateness(handed_in(100)).days == 5


@pytest.mark.parametrize("after", [None, -5])
def test_what_only_the_platform_calls_late_loses_nothing_and_is_told(after):
    found = policy().lateness(handed_in(after, late=True))
    assert found.is_unmeasured and found.share == 0
    extended = policy(extensions={"ada": {LESSON: DUE + timedelta(days=1)}})
    assert not extended.lateness(handed_in(after, late=True)).late


def test_the_deduction_is_a_share_of_what_was_earned_with_marks_and_changes():
    override, given = Override("ada", LESSON, "rgb_to_hsl", 2.0, "why", earned=4.0), mark(1.0)
    made = score(handed_in(30), [override], [given], policy())
    assert made.deducted == pytest.approx(0.6) and made.earned == pytest.approx(2.4)
    assert made.points == score(handed_in(0)).points


@given(st.floats(-100, 10_000), st.floats(0, 1000), st.floats(0, 1), st.floats(0, 100), st.floats(0, 1))
def test_later_never_earns_more_and_never_less_than_what_is_left(after, more, per_day, grace, most):
    rules = policy(per_day=per_day, grace_hours=grace, most=most)
    first, second = (score(handed_in(each), (), (), rules).earned for each in (after, after + more))
    assert 4 * (1 - most) - 1e-9 <= second <= first <= 4


def test_a_time_without_an_offset_has_the_deadlines():
    due = DUE.astimezone(timezone(timedelta(hours=1)))
    local = (due + timedelta(minutes=1)).replace(tzinfo=None).isoformat(" ", "minutes")
    found = LatePolicy({LESSON: due}, per_day=0.1).lateness(result("ada", exercise(), handed_in=local))
    assert found.late and found.handed_in == due + timedelta(minutes=1)
