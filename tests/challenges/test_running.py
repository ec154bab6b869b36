"""Whatever an entry does, each case has a score or a sentence."""

import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from nao_course.challenges import CaseScore
from nao_course.challenges.running import MOST_LATE, run
from tests.challenges.example import CHALLENGE, COST, double


def forever(numbers):
    while True:
        pass


def forever_whatever_happens(numbers):
    count = 0
    while True:
        try:  # noqa: SIM105
            count += sum(range(10))
        except:  # noqa: E722
            pass


class NoException(BaseException):
    pass


def raises(error):
    def entry(numbers):
        raise error

    return entry


def seeds(last, **more):
    """Return the challenge with as many cases."""
    return replace(CHALLENGE, seeds=tuple(range(1, last + 1)), **more)


def same(numbers):
    return numbers


def scores(came):
    return [each.score for each in came.results]


def test_an_entry_has_the_mean_of_its_cases_and_of_their_columns():
    came = run(CHALLENGE, double)
    assert came.complete and came.score == 1.0 and came.columns == {"off": 0.0} and came.problems() == []
    came = run(CHALLENGE, same)
    assert came.score == pytest.approx(np.mean([1.0, 0.5, 0.0])) and came.worst.name == "case 3"
    assert came.columns["off"] == pytest.approx(0.5)
    came = run(COST, same)  # whose worst case is the largest
    assert came.worst.name == "case 3" and came.score == pytest.approx(0.5)
    came = run(COST, lambda numbers: None if len(numbers) == 2 else numbers)
    assert scores(came)[1] == COST.nothing == 9.0 and came.complete


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        (lambda numbers: np.zeros(7), "must return shape (1,), got (7,)"),
        (raises(KeyError("white")), "KeyError in your entry"),
        (raises(SystemExit(1)), "SystemExit"),
        (raises(NoException()), "NoException in your entry."),
        (raises(NotImplementedError("soon")), "not written yet"),
        (forever_whatever_happens, "Time is up"),
    ],
)
def test_an_answer_that_cannot_be_used_scores_as_nothing_and_the_sentence_says_why(entry, said):
    came = run(seeds(1), entry)
    words = " ".join([came.stopped, *came.problems()]).replace("Not written", "not written")
    assert said in words and came.stopped and not came.complete


def test_an_entry_that_fails_twice_in_the_same_way_and_never_answered_is_given_up_without_a_score():
    asked = []

    def wrong_shape(numbers):
        asked.append(len(numbers))
        return np.zeros(len(numbers) + 3)

    came = run(seeds(30), wrong_shape)
    assert len(asked) == 2 and not came.complete and np.isnan(came.score)
    assert came.stopped.startswith("Stopped after 2 of 30 scenes, without a score: no scene had a usable")
    assert len(came.problems()) == 2 and "must return shape" in came.problems()[0]
    came = run(seeds(30), lambda numbers: None if len(numbers) % 2 else {}["white"])  # two kinds of errors
    assert len(came.results) == 3 and not came.complete
    assert "must return shape" in came.problems()[0] and "KeyError" in came.problems()[1]
    came = run(seeds(8), lambda numbers: double(numbers) if len(numbers) == 1 else None)  # it answered once
    assert came.complete and len(came.results) == 8 and came.score == pytest.approx(1 / 8)


def test_a_function_that_changes_what_it_is_given_scores_nothing_nor_does_a_score_that_is_no_number():
    def entry(numbers):
        numbers *= 2
        return numbers

    came = run(CHALLENGE, entry)
    assert scores(came) == [1.0, 0.0, 0.0]  # twice 0 is 0
    assert "work on a copy" in came.problems()[0]
    assert run(CHALLENGE, double).score == 1.0
    broken = replace(CHALLENGE, judge=lambda answer, scene: CaseScore(float("nan")))
    came = run(broken, double)
    assert came.results[0].score == 0.0 and "not a number" in came.problems()[0]


def test_an_entry_that_is_late_is_stopped_in_any_thread_and_given_up_and_others_keep_their_time():
    came = run(seeds(30, seconds=0.2, seconds_in_all=100.0), forever)
    assert len(came.results) == MOST_LATE and not came.complete
    assert came.stopped.startswith(f"Stopped after {MOST_LATE} of 30 scenes, without a score: Time is up")
    hurried = seeds(39, seconds=10.0, seconds_in_all=0.2)
    came = run(hurried, lambda numbers: time.sleep(0.15) or double(numbers))
    assert came.complete and scores(came)[0] == 1.0 and scores(came)[-1] == 0.0
    assert "The 0.2 s for all cases are used up." in " ".join(came.problems())
    patient = replace(CHALLENGE, seconds=0.1, seconds_in_all=30.0)
    came = run(patient, lambda numbers: forever(numbers) if len(numbers) == 2 else double(numbers))
    assert scores(came) == [1.0, 0.0, 1.0]
    assert "after 0.1 s" in came.problems()[0]
    came = []
    thread = threading.Thread(target=lambda: came.append(run(seeds(1), forever)), daemon=True)
    thread.start()
    thread.join(60)
    assert came and scores(came[0]) == [0.0] and "Time is up" in came[0].problems()[0]


def test_an_interrupted_entry_has_no_score_and_a_blank_exercise_stops_one_at_once():
    def entry(numbers):
        if len(numbers) == 2:
            raise KeyboardInterrupt
        return double(numbers)

    came = run(CHALLENGE, entry)
    assert not came.complete and np.isnan(came.score) and "after 1 of 3 scenes" in came.stopped
    came = run(CHALLENGE, raises(NotImplementedError()))
    assert came.results == () and came.stopped.startswith("Not written yet")


def test_what_is_no_function_is_refused_unless_values_are_taken_and_an_entry_prints_nowhere(capsys):
    assert "without brackets" in run(CHALLENGE, np.zeros(3)).stopped
    assert "The entry is None" in run(replace(CHALLENGE, takes_values=True), None).stopped
    assert run(seeds(1, takes_values=True), [0.0]).score == 1.0
    run(CHALLENGE, lambda numbers: print("hello") or double(numbers))
    assert capsys.readouterr() == ("", "")


def test_an_entry_is_given_no_part_of_the_scene_that_is_not_meant_for_it_and_scenes_are_made_once():
    scene = {"seen": np.ones(2), "truth": np.zeros(2)}
    seen = []
    secret = seeds(
        1,
        make=lambda seed: scene,
        given=lambda scene: (scene["seen"],),
        judge=lambda answer, scene: CaseScore(1.0),
    )
    run(secret, lambda *given, **named: seen.append((given, named)))
    ((numbers,), named) = seen[0]
    assert not named and numbers is not scene["seen"] and numbers.base is None
    made = []
    lazy = replace(CHALLENGE, make=lambda seed: made.append(seed) or np.arange(float(seed)))
    assert made == []
    assert run(lazy, double).complete and run(lazy, double).complete
    assert made == [1, 2, 3]
