"""A person's word counts before the grader's, and only where it belongs."""

from nao_course.instructor.gradebook.records import Mark, Override
from nao_course.instructor.gradebook.scores import score, scores
from tests.pages import answer, exercise, result

LESSON = "01_hsl_filtering"


def override(student="ada", lesson=LESSON, points=1.0, time="2026-01-01"):
    return Override(student, lesson, "rgb_to_hsl", points, "why", time)


def mark(points, time="2026-01-01", student="ada"):
    return Mark(student, LESSON, "why_hsl", points, "", time)


def test_the_latest_word_counts_in_whatever_order_they_come():
    words = [override(points=1.5, time="2026-01-02"), override(points=0.5)]
    for some in (words, words[::-1]):
        assert score(result("ada", exercise("wrong")), some).earned == 1.5


def test_the_latest_mark_of_an_answer_counts_in_whatever_order_the_marks_come():
    marks = [mark(1.5, "2026-01-03"), mark(0.5, "2026-01-01"), mark(1.0, "2026-01-02")]
    for some in (marks, marks[::-1], sorted(marks, key=lambda each: each.time)):
        assert score(result("ada", answer(text="Because.")), (), some).earned == 1.5


def test_what_is_said_of_another_student_or_lesson_does_not_count():
    others = [override(student="bob"), override(lesson="02_posts")]
    assert score(result("ada", exercise("wrong")), others).earned == 0.0


def test_an_answer_waits_for_its_mark_and_an_empty_one_for_nobody():
    written, empty = (result("ada", answer(text=text)) for text in ("Because.", " "))
    assert [len(score(each).waiting) for each in (written, empty)] == [1, 0]
    marked = score(written, (), [mark(1.5, "2026-01-02"), mark(0.5), mark(2.0, student="bob")])
    assert marked.earned == 1.5 and marked.waiting == () and marked.points == 2.0


def test_each_of_many_results_finds_what_belongs_to_it():
    many = [result(f"s{i}", exercise("wrong")) for i in range(100)]
    changes = [override(student=f"s{i}", points=i / 100) for i in range(0, 100, 2)]
    assert [each.earned for each in scores(many, changes)] == [i / 100 * (i % 2 == 0) for i in range(100)]


class Counted(list):
    """Results that count how often they are gone through."""

    passes = 0

    def __iter__(self):
        self.passes += 1
        return super().__iter__()


def test_ten_thousand_words_are_gone_through_once():
    changes = Counted(override(student=f"s{i}") for i in range(100))
    scores([result(f"s{i}", exercise("wrong")) for i in range(100)], changes)
    assert changes.passes == 1
