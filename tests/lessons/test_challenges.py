"""What holds for the challenge of every lesson; how a lesson scores is tested in its own folder.

That each recorded row is what its entry scores, with the same scenes each time, is in tests/benchmarks.
"""

import re
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.challenges import ENTRIES, margin
from nao_course.challenges import CaseResult, Run
from nao_course.challenges.finding import declared
from nao_course.challenges.running import run
from nao_course.slam import Motion
from tests.lessons.every import COURSE

CHALLENGES = declared()
each_challenge = pytest.mark.parametrize("lesson", CHALLENGES)


def few(lesson):
    """Return a challenge with its first two cases, whose scenes are made once."""
    challenge = CHALLENGES[lesson]
    return replace(challenge, seeds=challenge.seeds[:2], make=challenge.scene)


def rows(lesson):
    return {row.name: row for row in CHALLENGES[lesson].rows}


@each_challenge
def test_it_stands_in_its_lesson_and_its_rows_have_a_score_of_each_case_and_one_beats_the_reference(lesson):
    challenge = CHALLENGES[lesson]
    assert challenge.judge.__module__.split(".")[2] == lesson.partition("_")[2]
    names = [challenge.name_of(seed) for seed in challenge.seeds]
    columns = {each.name for each in challenge.columns}
    assert len(set(names)) == len(names) and len(challenge.rows) >= 3
    assert all(len(row.cases) == len(names) and set(row.columns) == columns for row in challenge.rows)
    (reference,) = (row for row in challenge.rows if row.name.startswith("the reference"))
    assert any(challenge.beats(row.score, reference.score) for row in challenge.rows)
    # A failing entry is no better than the entry that does nothing.
    cases = [challenge.rows[0].score] if lesson == "04_distance" else challenge.rows[0].cases
    assert not any(challenge.beats(challenge.nothing, case) for case in cases)


FIVE = np.eye(5)
# Answers that are wrong in one lesson only, each with a word of its message
REFUSED = {
    "00_meet_the_nao": [
        (Motion(1.0, 0.0), "Motion"),
        (3.0, "float"),
        ([Motion(1.0, 0.0), None], "Command 2"),
        ([Motion(0.1, 0.0)] * 201, "200"),
        ([Motion(0.0, 0.4), Motion(0.67, -67.2)], r"Command 2 .*np.radians\(-67.2\)"),
    ],
    "01_hsl_filtering": [
        ([[1, 2], [3]], "list"),
        (np.zeros((2, 4)), r"\(2, 4\)"),
        (np.full((240, 320), 0.5), "1 green"),
        (np.full((240, 320), -1), "-1"),
        (np.full((240, 320), np.nan), "NaN"),
    ],
    "02_goalposts": [(np.zeros((2, 3)), "feet|shape")],
    "03_hough_corners": [(np.zeros((2, 3)), "shape"), ([(np.nan, 1.0)], "NaN")],
    "04_distance": [
        ((0.1, 0.2), "three"),
        ((0.1, np.nan, 0.01), "NaN"),
        ((15.0, 0.2, 0.01), "rad"),
        ((0.1, 0.2, 0.0), "more than 0"),
    ],
    "05_ekf_derivations": [(3, "int"), ("no such", "MISTAKES")],
    "08_graph_slam": [
        ([1.5], "whole"),
        ([60], "60"),
        ([-2], "60"),
        ([True], "whole"),
        ([1, 1], "different"),
        (3, "list"),
    ],
    "09_pose_graphs": [
        ((np.zeros(720), np.zeros(3)), "states"),
        (np.zeros(3), r"\(720,\)"),
        (np.full(720, np.nan), "NaN"),
    ],
    "12_beyond": [
        (([0], np.zeros(5)), "three"),
        (([0], np.zeros(4), np.eye(4)), "1 numbers"),
        (([0, 0], np.zeros(7), np.eye(7)), "once"),
        (([11], np.zeros(5), FIVE), "9"),
        (([0], np.full(5, np.nan), FIVE), "NaN"),
        (([0], np.zeros(5), np.triu(np.ones((5, 5)))), "symmetric"),
        (([0], np.zeros(5), -FIVE), "negative"),
    ],
}


@each_challenge
def test_an_answer_that_cannot_be_scored_is_refused_with_the_reason(lesson):
    challenge = few(lesson)
    other_kinds = [(answer, None) for answer in (None, "words", {"a": 1}, object(), np.full(3, np.nan))]
    for answer, word in [*other_kinds, *REFUSED.get(lesson, ())]:
        with pytest.raises((TypeError, ValueError), match=word):
            challenge.judge(answer, challenge.scene(challenge.seeds[0]))


@each_challenge
def test_the_figure_describes_its_cases_also_if_one_had_no_usable_answer(lesson):
    challenge = few(lesson)
    came = run(challenge, next(iter(ENTRIES[lesson].values())))
    assert came.complete and not came.problems()
    alt = challenge.figure(came).alt
    assert came.worst.name in alt or f"{challenge.say(came.score)} " in alt or "2 " in alt
    failed = CaseResult(challenge.seeds[1], came.results[1].name, challenge.nothing, message="no")
    assert challenge.figure(Run(challenge, (came.results[0], failed))).alt


# What each lesson's text quotes of its board: (row, column or the score, format)
QUOTED = {
    "03_hough_corners": [(name, "score", ".2f") for name in ("the reference", "a better detector")],
    "06_localization": [
        ("the three nearest", "NEES", ".0f"),
        ("a better filter", "score", ".1f"),
        ("a better filter", "NEES", ".1f"),
    ],
    "08_graph_slam": [
        ("nothing, as in the paper", "score", ".2f"),
        ("a better one: one by one, smallest maximum", "score", ".2f"),
    ],
    "10_experiments": [(name, "score", ".2f") for name in ("nothing", "the reference", "a better detector")],
    "12_beyond": [
        ("the paper's way, a fixed plan", "score", ".0f"),
        ("the reference", "score", ".0f"),
        ("a better one", "score", ".0f"),
        ("the paper's way, a fixed plan", "found", ".0f"),
        ("the reference", "found", ".0f"),
    ],
}


def text_of_the_challenge(lesson):
    """Return the section of a lesson about its challenge, on one line."""
    text = COURSE.text(lesson).read_text(encoding="utf-8")
    return " ".join(re.split(r"^## ", text.partition("\n## The challenge")[2], flags=re.MULTILINE)[0].split())


@pytest.mark.parametrize("lesson", QUOTED)
def test_the_text_quotes_the_board(lesson):
    for name, column, form in QUOTED[lesson]:
        row = rows(lesson)[name]
        value = row.score if column == "score" else row.columns[column]
        assert f" {value:{form}}" in text_of_the_challenge(lesson), name


@pytest.mark.parametrize("lesson", ["03_hough_corners", "10_experiments"])
def test_the_text_quotes_by_how_much_the_better_entry_beats_the_reference(lesson):
    own, better = rows(lesson)["the reference"], rows(lesson)["a better detector"]
    mean, low, high = margin(own.cases, better.cases)
    said = rf"{mean:.2f}[^()]*\(95 % interval {low:.2f} to {high:.2f}\)"
    assert re.search(said, text_of_the_challenge(lesson))
