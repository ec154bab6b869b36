"""The class's page: its numbers are those of the results, whatever the class and whatever it wrote."""

import base64
import re
import xml.etree.ElementTree as ElementTree
from typing import get_args

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Override, State
from nao_course.instructor.gradebook.scores import score, scores
from nao_course.instructor.reports import class_report
from nao_course.instructor.reports.class_report import _KINDS, MOST_MISTAKES, exercises_of, report_page
from tests.pages import FOR_ASSISTANTS, HOSTILE, RUBRIC, Page, answer, exercise, mark, result, results

LESSON = "01_hsl_filtering"


def class_of(*states, **changed):
    return scores([result(f"s{i}", exercise(state, **changed)) for i, state in enumerate(states)])


def text_of(made):
    return Page(report_page(made)).text


def pictures(page):
    return [attributes for tag, attributes in page.elements if tag == "img"]


def test_mean_median_and_range_count_what_people_changed_and_marked(tmp_path):
    def written(journal):
        return Page(class_report.write_report(journal, tmp_path / "r.html").read_text("utf-8")).text

    three = [result(f"s{i}", exercise(points=10.0, earned=earned)) for i, earned in enumerate((0, 1, 8))]
    assert "mean 3, median 1 of 10; from 0 to 8" in text_of(scores(three))
    with Journal(tmp_path) as journal:
        journal.keep(result("ada", exercise("wrong"), answer(), level="full"))
        journal.override(Override("ada", LESSON, "rgb_to_hsl", 1.0, "why not"))
        assert "1 of 4; from 1 to 1" in written(journal)
        journal.mark([mark(1.5)])
        text = written(journal)
    assert "mean 2.5, median 2.5 of 4" in text and "full (1)" in text
    assert "Written answers to mark 0" in text and "50 % of its points were earned" in text


def test_times_and_lateness_stand_in_a_table_with_the_late_ones_first():
    in_time = result("ada", exercise(), handed_in="2026-11-20 22:10+00:00")
    made = [in_time, result("ben", exercise(), late=True), result("eve", exercise())]
    text = " ".join(Page(report_page(scores(made))).text.split())
    assert "Handed in, 1 late student handed in late deducted ben yes ada 2026-11-20 22:10+00:00" in text
    assert "Handed in" not in Page(report_page(scores(made[2:]))).text


def test_every_state_is_counted_once_and_shares_of_an_exercise_add_up():
    states = [state for _, _, known in _KINDS.values() for state in known]
    assert sorted(states) == sorted(get_args(State))
    (only,) = exercises_of(class_of("right", "right", "wrong", "raised", "timed out", "not attempted"))
    assert list(only.counts.values()) == [2, 1, 2, 1, 0] and only.share == pytest.approx(1 / 3)
    (only,) = exercises_of(class_of("right", "wrong", "wrong", "raised", points=0.0, earned=0.0))
    assert only.share == pytest.approx(1 / 4), "without points it is the share of right answers"
    assert "Bars: share of 1 submission that have" in report_page(class_of("right"))


def test_the_hardest_exercises_come_first_and_solved_ones_are_not_named():
    parts = [exercise(name=f"e{i}", number=f"1.{i}", points=10.0, earned=float(i)) for i in range(8)]
    made = scores([result("ada", *parts, exercise(name="easy", number="1.9"))])
    text = Page(report_page(made)).text
    hardest = text[text.index("Hardest") : text.index("exercise points")]
    assert re.findall(r"e\d", hardest) == ["e0", "e1", "e2", "e3", "e4"] and "easy" not in hardest


def test_the_mistakes_of_the_class_are_counted_the_most_frequent_first():
    made = [("hue in degrees", "Your hue is in degrees.")] * 3
    made += [("sign", "The sign is turned."), ("", "1.1 f: 2 of 3 cases pass.")]
    results = [
        result(f"s{i}", exercise("wrong", number="1.1", name="f", mistake=name, hint=hint))
        for i, (name, hint) in enumerate(made)
    ]
    counted = class_report.mistakes_of(scores(results))
    assert [(each.name, each.many) for each in counted] == [("hue in degrees", 3), ("sign", 1)]
    page = Page(report_page(scores(results)))
    assert "1.1 f 3 hue in degrees Your hue is in degrees." in page.text and page.offences() == []
    assert "Mistakes that the class made" not in report_page(class_of("right"))
    many = [exercise("wrong", mistake=f"m{i}", hint=f"h{i}") for i in range(MOST_MISTAKES + 4)]
    assert "and 4 rarer ones" in text_of(scores([result(each.mistake, each) for each in many]))


def test_refused_submissions_are_listed_with_reasons_and_lower_no_mean():
    refused = result("eve", exercise("not found"), status="refused", reason="it is empty")
    made = [*class_of("right"), score(refused)]
    text = text_of(made)
    assert "2: 1 graded, 1 refused" in text and "eve it is empty" in text and "mean 2, median 2" in text
    (only,) = exercises_of([each for each in made if each.result.status == "graded"])
    assert sum(only.counts.values()) == 1


def test_figures_are_whole_pictures_with_words_and_the_same_each_time():
    made = class_of("right", "wrong", "raised")
    assert report_page(made) == report_page(made)
    first, second = shown = pictures(Page(report_page(made)))
    for each in shown:
        assert len(each["alt"]) > 60
        data = base64.b64decode(each["src"].removeprefix("data:image/svg+xml;base64,"))
        assert ElementTree.fromstring(data).tag.endswith("svg")
        assert b"<script" not in data and b"http-equiv" not in data
    assert "mean 0.67" in first["alt"] and "rgb_to_hsl 33 %" in second["alt"]
    five = [result(f"s{i}", exercise(points=3.0, earned=e)) for i, e in enumerate((0, 3, 3, 3, 9))]
    assert "most submissions, 4, from 2.5 to 3" in pictures(Page(report_page(scores(five))))[0]["alt"]


# Four examples are enough, because figures are slow.
@settings(max_examples=4, deadline=None, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(st.lists(results(), max_size=3))
def test_any_class_has_a_page_without_secrets(some):
    text = report_page(scores(some))
    assert Page(text).offences() == []
    assert not [secret for secret in (RUBRIC, FOR_ASSISTANTS) if secret in text]


# Each in its own way hard to draw
DRAWN = (HOSTILE[0], "half \ud83d of a character", "$x_{$", "\\frac{", "漢字")
REST = [pytest.param(text, marks=pytest.mark.slow) for text in (*HOSTILE, "x" * 500) if text not in DRAWN]


@pytest.mark.slow
@pytest.mark.parametrize("text", [*DRAWN, *REST])
def test_the_page_keeps_its_elements_whatever_anybody_wrote(text):
    def page(said):
        refused = result(f"x{said}", status="refused", reason=f"x{said}", level=said)
        named = result(f"y{said}", exercise("wrong", name=f"x{said}", number="1.1"), level=f"x{said}")
        return Page(report_page(scores([refused, named])))

    def bare(found):
        return [(tag, {k: v for k, v in a.items() if k not in ("src", "alt")}) for tag, a in found.elements]

    found = page(text)
    assert found.offences() == [] and bare(found) == bare(page("fine"))


def test_small_and_odd_classes_have_a_page_and_lessons_stand_one_after_the_other():
    text = text_of(scores([result("ada", exercise(), lesson=name) for name in ("02_posts", LESSON)]))
    assert text.index("Lesson 01") < text.index("Lesson 02") and "1 student, 2 submissions" in text
    odd = (result("ada"), result("ada", answer()), result("ada", status="refused", reason="x"))
    for made in ([], class_of("right", points=0.0, earned=0.0), *([score(each)] for each in odd)):
        page = Page(report_page(made))
        assert page.offences() == [] and "The class's results" in page.text
        assert ("Nothing has been graded yet." in page.text) == (not made)
