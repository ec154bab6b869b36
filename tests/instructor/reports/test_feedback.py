"""A student's page: it says everything that helps, nothing that is hidden, and is safe whatever was handed in."""

import re
from dataclasses import replace
from itertools import pairwise
from typing import get_args

import pytest
from hypothesis import given, settings

from nao_course.instructor.gradebook.records import Override, State
from nao_course.instructor.gradebook.scores import score
from nao_course.instructor.reports import html
from nao_course.instructor.reports.feedback import _STATES, feedback_page, write
from tests import pages
from tests.pages import FOR_ASSISTANTS, HOSTILE, MISTAKE, RUBRIC, Page, answer, exercise, mark, result

HINT = "This looks like degrees where radians belong."


def override(points=1.0, reason="The sheet allowed it.", **changed):
    values = {"student": "ada", "lesson": "01_hsl_filtering", "exercise": "rgb_to_hsl", "time": "2026-01-01"}
    return Override(**{**values, "points": points, "reason": reason, **changed})


def page(*parts, overrides=(), marks=(), **changed):
    return Page(feedback_page(score(result("ada", *parts, **changed), overrides, marks)))


def test_what_works_stands_first_and_what_is_not_written_last_and_in_short():
    blank = exercise("not attempted", name="later", public=("later: not written yet.",))
    text = page(blank, exercise("wrong", public=("2 of 3.", HINT), hint=HINT), exercise(name="second")).text
    order = "What works, second, What to look at, rgb_to_hsl, Not written yet, later 0 of 2 points"
    places = [text.index(each) for each in order.split(", ")]
    assert places == sorted(places)
    assert text.count("not written yet") == 0 and text.count(HINT) == 1, "once is enough"
    changed = page(exercise("not attempted"), overrides=[override()]).text
    assert "1 of 2 points" in changed and "The sheet allowed it." in changed


@pytest.mark.parametrize("state", sorted({*get_args(State)} - {"right", "not attempted"}))
def test_every_way_to_fail_has_its_own_words_and_says_what_to_do(state):
    _, short, meaning = _STATES[state]
    assert sum(short == each[1] for each in _STATES.values()) == 1
    text = page(exercise(state, text="The shape is (3,).", line="line 3: return x")).text
    for said in (short, "The shape is (3,).", "line 3: return x", "0 of 2 points"):
        assert said in text
    assert len(meaning) > 20


def test_an_earlier_mistake_is_told_with_the_points_that_remain():
    earned = page(exercise(with_reference=True, earned=1.0)).text
    assert "does not work with your own earlier functions; with ours it does: 1 point." in earned
    assert "An earlier mistake costs a part of it" in earned
    assert "An earlier mistake is not counted twice" in page(exercise(with_reference=True)).text
    assert "does not work with those either" in page(exercise("wrong", with_reference=True)).text
    assert "It is right in 3 of 5 hidden cases." in page(exercise("wrong", passed=3)).text
    all_right = page(exercise(passed=5), overrides=[override(earned=2.0)]).text
    assert "hidden cases." not in all_right.split("Hidden cases have")[0]


def test_a_changed_score_counts_tells_its_reason_and_quotes_no_check_of_what_is_not_written():
    text = page(exercise("wrong"), overrides=[override()]).text
    assert "1 of 2 points" in text and "The sheet allowed it." in text
    assert "The grader gave 0, a person 1 point." in text
    text = page(exercise("not attempted", public=("1.1: blank.",)), overrides=[override()]).text
    assert "A person looked at this" in text and "1.1: blank." not in text


def test_a_written_answer_waits_for_a_person_and_then_shows_mark_and_comment_but_no_rubric():
    open_ = page(answer()).text
    assert "Because of the shadows." in open_ and "A person marks this." in open_ and "so far" in open_
    done = page(answer(), marks=[mark(comment="And the sun?")]).text
    assert "1.5 of 2 points" in done and "And the sun?" in done and RUBRIC not in done
    assert "A person marks this." not in done and "so far" not in done
    assert "so far" not in page(answer(text=" \n")).text, "an empty answer waits for nobody"
    assert score(result("ada", answer(text="")), (), [mark(2.0, text="")]).earned == 2.0


def test_a_refused_submission_says_why_and_what_to_do():
    said = page(exercise("not found"), status="refused", reason="larger than 50 MB").text
    assert "larger than 50 MB" in said and "Clear all outputs" in said and "0 of 2 points" in said
    assert "Your notebook does not define it" not in said, "nobody looked into it"
    assert "nao-course submit" in page(status="refused", reason="").text


def test_the_students_own_files_that_did_not_count_are_named_and_nothing_of_the_notes():
    left_out = ("mine.py does not come along: 20 of at most 1 MB are taken",)
    notes = (
        *left_out,
        "the sandbox saw it try: open /873.93 does not count: ",
        "code cell 1, line 2: KeyError: 873.93 does not come along: ",
    )
    said = page(exercise(), notes=notes, left_out=left_out).text
    assert "Notes on your files" in said and "mine.py does not come along" in said and "873" not in said
    assert "left out" not in page(exercise(), notes=notes).text


def test_the_sum_is_that_of_exercises_changes_and_marks():
    whole = result("ada", exercise(), exercise("wrong", name="other"), answer(), answer(name="more"))
    changes = [override(0.5, exercise="other"), override(9.0, exercise="of another lesson")]
    found = score(whole, changes, [mark(1.25)])
    assert (found.earned, found.points) == (3.75, 8.0)
    assert [each.name for each in found.waiting] == ["more"]
    assert "3.75" in Page(feedback_page(found)).text


@settings(max_examples=50, deadline=None)
@given(pages.results())
def test_no_page_holds_a_rubric_a_mistakes_name_or_what_is_for_assistants(any_result):
    text = feedback_page(score(any_result))
    assert not [secret for secret in (RUBRIC, MISTAKE, FOR_ASSISTANTS) if secret in text]
    assert Page(text).offences() == []


def page_with(text):
    parts = {"text": text, "line": text, "public": (text, text), "hint": f"{text}!", "notes": (text,)}
    made = result(
        "ada",
        *(exercise(state, name=text, number=text, **parts) for state in get_args(State)),
        exercise("wrong", name="changed"),
        answer(name="w", question=text, text=f"x{text}", number=text),
        file=text,
        submission=text,
    )
    made = replace(made, student=text)
    changes = override(reason=f"x{text}", student=text, exercise="changed")
    marked = mark(1, f"x{text}", text=f"x{text}", student=text, question="w")
    return feedback_page(score(made, [changes], [marked]))


@pytest.mark.parametrize("text", HOSTILE)
def test_whatever_a_notebook_says_the_page_keeps_its_elements(text):
    hostile, harmless = Page(page_with(text)), Page(page_with("fine"))
    assert hostile.offences() == [] and hostile.elements == harmless.elements
    refused = Page(feedback_page(score(result(text, status="refused", reason=text, file=text))))
    assert refused.offences() == []


def test_what_cannot_be_seen_is_made_visible_and_a_long_text_is_cut_with_a_word():
    text = feedback_page(score(result("a\u202eb\x1b", exercise("wrong", line="x = '\ud800'\x00"))))
    assert "⟨U+202E⟩" in text and "⟨U+001B⟩" in text and "⟨U+D800⟩" in text and "⟨U+0000⟩" in text
    assert not html._UNSEEN.search(text)
    assert html.visible("ك\u200c é 👩\u200d🚀\n\tx") == "ك\u200c é 👩\u200d🚀\n\tx", "honest text stays"
    assert len(html.visible("a" + "\u0301" * 1000)) == 5
    long = page(answer(text="y" * 10**6, question="Why `picture.copy()` and not `picture`? 3 * 4 ` 5"))
    assert len(long.text) < 30_000 and "980000 more characters" in long.text
    assert long.tags.count("code") == 2 and "3 * 4 ` 5" in long.text


def test_a_screen_reader_finds_language_title_and_headings_and_nothing_can_run_or_be_fetched():
    text = feedback_page(score(result("ada", exercise(), answer())))
    elements = [each for _, each in Page(text).elements]
    (policy,) = (each["content"] for each in elements if each.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none'; style-src 'sha256-") and "unsafe" not in policy
    assert "://" not in text and "url(" not in text and "@import" not in text
    found = page(exercise(), exercise("wrong", name="other"), answer())
    assert ("html", {"lang": "en"}) in found.elements and "title" in found.tags
    levels = [int(tag[1]) for tag in found.tags if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1 and levels.count(1) == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    signs = [attributes for tag, attributes in found.elements if tag == "svg"]
    assert all(each["aria-hidden"] == "true" for each in signs), "its words stand beside it"


def test_the_same_score_gives_the_same_bytes_and_what_cannot_be_written_leaves_them(tmp_path, monkeypatch):
    path = write(result("ada", exercise(), seconds=1.0), tmp_path)
    before = path.read_bytes()
    assert path == tmp_path / "ada" / "01_hsl_filtering.html"
    assert write(result("ada", exercise(), seconds=2.0), tmp_path).read_bytes() == before
    monkeypatch.setattr(html.os, "replace", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write(result("ada", exercise("wrong")), tmp_path)
    assert path.read_bytes() == before and list(path.parent.iterdir()) == [path]


def test_every_student_has_a_folder_of_their_own_inside(tmp_path):
    odd = ["..", ".", "", "/", "a/b", "a\\b", "a b", "con", "NUL.txt", "x.", "x ", "é", "e\u0301", "a" * 300]
    odd += ["ü" * 90, *HOSTILE, "Łucja Nguyễn", "-rf", "~", "a:b", "a?b", "a*b", "\ud800"]
    for name in odd:
        path = write(result(name), tmp_path)
        assert path.parent.parent == tmp_path and path.resolve().is_relative_to(tmp_path.resolve())
        assert not re.search(r'[<>:"|?*\x00-\x1f]|[. ]$', path.parent.name), path
    assert len(list(tmp_path.iterdir())) == len(set(odd))


@pytest.mark.browser
@pytest.mark.slow
def test_a_page_fits_a_phone_and_says_nothing_to_the_console(tmp_path, chromium):
    playwright = pytest.importorskip("playwright.sync_api")
    long = "a_name_without_any_place_to_break_" * 8
    parts = [exercise(each, name=long, line=long, text=long, public=(long,)) for each in get_args(State)]
    path = write(result("ada", *parts, answer(text=long, question=long)), tmp_path)
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox", "--disable-gpu"])
        try:
            tab = browser.new_page(viewport={"width": 360, "height": 740})
            said = []
            tab.on("console", lambda message: said.append(message.text))
            tab.goto(path.as_uri())
            assert tab.evaluate("document.documentElement.scrollWidth") == 360
            assert tab.evaluate("getComputedStyle(document.querySelector('.score')).fontWeight") == "700", (
                "styled"
            )
            assert said == []
        finally:
            browser.close()
