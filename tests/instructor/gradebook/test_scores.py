"""A person's word counts before the grader's, and only where it belongs."""

from dataclasses import replace
from itertools import permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nao_course.instructor.gradebook.records import Override, fingerprint
from nao_course.instructor.gradebook.scores import score, scores
from tests import pages
from tests.pages import answer, exercise, result

LESSON = "01_hsl_filtering"


def override(student="ada", lesson=LESSON, points=1.0, time="2026-01-01"):
    return Override(student, lesson, "rgb_to_hsl", points, "why", time)


def mark(points, time="2026-01-01", student="ada"):
    return pages.mark(points, text="Because.", time=time, student=student)


def test_the_latest_word_counts_in_whatever_order_they_come():
    words = [override(points=1.5, time="2026-01-03"), override(points=0.5), override(time="2026-01-02")]
    marks = [mark(1.5, "2026-01-03"), mark(0.5, "2026-01-01"), mark(1.0, "2026-01-02")]
    for order in permutations(range(3)):
        changes, given = ([each[at] for at in order] for each in (words, marks))
        assert score(result("ada", exercise("wrong")), changes).earned == 1.5
        assert score(result("ada", answer(text="Because.")), (), given).earned == 1.5


def test_what_is_said_of_another_student_or_lesson_does_not_count():
    others = [override(student="bob"), override(lesson="02_posts")]
    assert score(result("ada", exercise("wrong")), others).earned == 0.0


def test_an_answer_waits_for_its_mark_and_an_empty_one_for_nobody():
    written, empty = (result("ada", answer(text=text)) for text in ("Because.", " "))
    assert [len(score(each).waiting) for each in (written, empty)] == [1, 0]
    marked = score(written, (), [mark(1.5, "2026-01-02"), mark(0.5), mark(2.0, student="bob")])
    assert marked.earned == 1.5 and marked.waiting == () and marked.points == 2.0


def decided(points, on, earned=0.0, minute=0):
    time = f"2026-01-01T00:{minute:02d}"
    return Override("ada", LESSON, "rgb_to_hsl", points, "why", time, decided_on=on, earned=earned)


@given(st.lists(st.tuples(st.sampled_from("xyz"), st.floats(0, 2)), max_size=6), st.sampled_from("xyz"))
def test_a_decision_counts_for_the_answer_that_it_was_made_for_and_is_a_proposal_for_others(words, now):
    """Also when the student goes back to an answer that was decided on before others."""
    marks = [mark(points, f"2026-01-01T00:0{i}") for i, (_, points) in enumerate(words)]
    marks = [replace(each, decided_on=fingerprint(on)) for each, (on, _) in zip(marks, words, strict=True)]
    changes = [decided(points, on, minute=i) for i, (on, points) in enumerate(words)]
    found = score(result("ada", exercise("wrong", answer=now), answer(text=now)), changes, marks)
    own = [points for on, points in words if on == now]
    assert found.earned == 2 * (own[-1] if own else 0.0)
    assert len(found.waiting) == len(found.overrides or [0]) - len(found.marks) == (not own)
    others = [] if own else [points for _, points in words[-1:]]
    for earlier in (found.earlier_marks, found.earlier_overrides):
        assert [each.points for each in earlier.values()] == others


@pytest.mark.parametrize(
    ("override", "earned", "counts"),
    [
        (decided(2.0, "x", earned=0.0), 1.0, 2.0),  # the grader was mended, and gives less than the person
        (decided(1.0, "x", earned=0.0), 2.0, 2.0),  # something else in the notebook was mended
        (decided(0.0, "x", earned=2.0), 2.0, 0.0),  # not the student's own work
        (decided(0.0, "x", earned=2.0), 1.0, 0.0),
        (decided(2.0, "another", earned=0.0), 1.0, 1.0),
        (decided(0.0, "another", earned=2.0), 2.0, 2.0),
    ],
)
def test_points_by_hand_hold_no_better_result_down_and_leave_with_their_answer(override, earned, counts):
    made = score(result("ada", exercise("wrong", answer="x", earned=earned)), [override])
    assert made.earned == counts and bool(made.earlier_overrides) == (counts != override.points)


def test_blank_lines_and_spaces_at_line_ends_are_no_other_answer():
    assert fingerprint("def f():\n    return 1") == fingerprint("\ndef f():  \r\n\r\n    return 1\n")
    assert fingerprint("def f():\n    return 1") != fingerprint("def f():\nreturn 1")


class Counted(list):
    """Results that count how often they are gone through."""

    passes = 0

    def __iter__(self):
        self.passes += 1
        return super().__iter__()


def test_each_of_many_results_finds_what_belongs_to_it_in_one_pass():
    many = [result(f"s{i}", exercise("wrong")) for i in range(100)]
    changes = Counted(override(student=f"s{i}", points=i / 100) for i in range(0, 100, 2))
    assert [each.earned for each in scores(many, changes)] == [i / 100 * (i % 2 == 0) for i in range(100)]
    assert changes.passes == 1
