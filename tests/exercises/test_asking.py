"""Questions reply to each choice; predictions take only what can be one, and come back beside the result."""

import json

import numpy as np
import pytest

from nao_course.exercises import Checks
from nao_course.exercises.asking import ask, prediction, reply
from nao_course.exercises.exercise import PublicLesson, PublicQuestion

WHY = PublicQuestion("why", "Why clamp?", {"Safety": "Yes.", "Speed": "It takes longer."}, "Safety")


def test_every_choice_has_its_reply_which_says_once_that_it_is_right():
    for number, (choice, text) in enumerate(WHY.choices.items(), start=1):
        sign = "✔ Right." if choice == WHY.right else "✘ Not quite."
        assert repr(reply(WHY, choice)) == repr(reply(WHY, str(number))) == f"{sign} {text}"
    for neither in ("", "0", "3", "no idea", "²"):
        assert "1. Safety, 2. Speed" in repr(reply(WHY, neither))
    for own in ("Right. It counts.", "right: it counts.", "It counts."):
        question = PublicQuestion("why", "Why?", {"So": own, "Not": "Not quite: that half."}, "So")
        assert repr(reply(question, "So")) == "✔ Right. It counts."
        assert repr(reply(question, "Not")) == "✘ Not quite. That half."


def test_buttons_answer_each_choice_and_a_question_is_text_where_no_widget_lives():
    _, buttons, answer = ask(WHY).children
    assert buttons.value is None and answer.value == ""
    for choice, text in WHY.choices.items():
        buttons.value = choice
        assert text in answer.value
    buttons.value = None
    assert answer.value == ""
    check = Checks(PublicLesson("90_toy", [], [WHY]))
    bundle = check.question("why")._repr_mimebundle_()
    assert bundle["text/plain"] == "Why clamp?\n  1. Safety\n  2. Speed" and json.dumps(bundle)
    assert "Not quite" in repr(check.question("why", 2))


@pytest.fixture
def ask_for(request):
    """A prediction that no other test asks for."""

    def ask(**options):
        return prediction(request.node.nodeid, **options)

    return ask


@pytest.mark.parametrize(("typed", "value"), [(" 0.5 m ", 0.5), ("0,5 metres", 0.5), ("−3", -3.0), (4, 4.0)])
def test_a_number_is_taken_with_its_unit_or_without(ask_for, typed, value):
    guess = ask_for(unit="m")
    assert repr(guess.write(typed)) == f"You predicted {value:g} m. Now run the next cell."
    assert guess.value == value


def test_what_cannot_be_a_prediction_gets_a_sentence_and_is_not_kept(ask_for):
    guess = ask_for(unit="m", low=0, high=4)
    for typed, said in (
        *(("", "a guess is enough"), ("asdf", "'asdf' is not a number in m"), ("1 2", "not a number in m")),
        *(("nan", "is not a number in m"), ("50 cm", "'50 cm' has another unit"), ("5", "It cannot be 5 m")),
        ("-1", "It cannot be -1 m, because it is from 0 to 4 m."),
    ):
        assert said in repr(guess.write(typed)) and guess.value is None
    assert "it is at least 0." in repr(ask_for(low=0).write("-1"))
    assert "it is at most 0°." in repr(ask_for(unit="°", high=0).write("1 deg"))


def test_a_choice_is_given_by_its_words_or_its_number_and_can_be_changed_until_the_result_is_there(ask_for):
    guess = ask_for(choices=["along", "across", "heading"])
    assert "1. along, 2. across, 3. heading" in repr(guess.write("up"))
    assert guess.value is None
    guess.write("Heading")
    assert guess.value == "heading"
    guess.write("2")
    assert repr(guess.beside("heading")) == "You predicted across; it is heading."
    guess = ask_for()
    guess.write("1")
    guess.write("2")
    assert ask_for().value == 2.0 and ask_for(unit="cm").value is None
    guess.beside(3)
    assert "You have already seen the result. You predicted 2" in repr(guess.write("3"))
    assert repr(guess.beside(3)) == "You predicted 2; it is 3."  # the cell is run again


def test_what_came_out_stands_beside_the_prediction(ask_for):
    for unit, measured, said in (
        *(("m", 1.9345, "1.93 m"), ("%", np.float32(56.17), "56.2 %"), ("°", -9.7, "-9.7°")),
        *(("", np.int64(1700), "1700"), ("", -1e-12, "-1e-12"), ("particles", 0, "0 particles")),
    ):
        guess = ask_for(unit=unit)
        guess.write("0.5")
        assert repr(guess.beside(measured)).endswith(f"; it is {said}.")
        assert repr(guess).endswith(f"; it is {said}.")
    assert "You predicted 0.5 particles;" in repr(guess), "half of a thing is in the plural"
    for unit, said in (("points", "1 point"), ("degrees", "1 degree"), ("ms", "1 ms"), ("x", "1 x")):
        guess = ask_for(unit=unit)
        guess.write(said)  # it may be typed like that, too
        assert f"You predicted {said}; it is 2" in repr(guess.beside(2))
        assert f"You predicted {said}, and so it is." in repr(guess.beside(1))


def test_without_a_prediction_the_result_waits_for_one_or_for_the_one_who_gives_up(ask_for):
    guess = ask_for(unit="m")
    field, _, said = shown(guess)
    *_, quit_button = guess._view.box.children[1].children
    assert quit_button.layout.display == "none" and "first" in repr(guess.give_up())
    assert "2" not in repr(guess.beside(2.0)) and "2" not in repr(guess) and "A guess is enough" in said.value
    assert not field.disabled and quit_button.layout.display == ""
    quit_button.click()
    assert "You wrote no prediction: it is 2 m. Next time, guess first; a guess is enough." in said.value
    assert field.disabled and quit_button.layout.display == "none"
    assert "already seen the result" in repr(guess.write("1"))
    guess = ask_for(unit="cm")
    guess.beside(2.0)
    assert repr(guess.write("1")) == "You predicted 1 cm; it is 2 cm."


def test_a_figure_waits_for_a_prediction_or_for_the_one_who_gives_up_but_not_in_a_build(ask_for, monkeypatch):
    monkeypatch.delenv("NAO_COURSE_STRICT", raising=False)
    guess, other = ask_for(unit="m"), ask_for(unit="cm")
    assert "run this cell again" in repr(guess.unlocks("a figure"))
    guess.write("1")
    other.beside(2.0)
    assert "waits" in repr(other.unlocks("a figure"))
    other.give_up()
    assert guess.unlocks("a figure") == other.unlocks("a figure") == "a figure"
    monkeypatch.setenv("NAO_COURSE_STRICT", "1")
    assert ask_for(unit="s").unlocks("a figure") == "a figure"


def shown(guess):
    """The widgets of a prediction: field, button and what is said."""
    guess._repr_mimebundle_()
    _, row, said = guess._view.box.children
    return row.children[0], row.children[2], said


def test_enter_and_the_button_write_what_stands_in_the_field_until_the_result_is_there(ask_for):
    guess = ask_for(unit="m")
    field, _, said = shown(guess)
    bundle = guess._repr_mimebundle_()
    assert bundle["text/plain"].startswith("Predict: ") and bundle["text/plain"].endswith("(in m)")
    assert json.dumps(bundle)
    assert not field.continuous_update  # so that a change is Enter, or leaving the field
    field.value = "<b>far</b>"
    assert "is not a number in m" in said.value and "<b>" not in said.value
    field.value = "2"
    assert guess.value == 2.0 and "You predicted 2 m. Now" in said.value
    guess = ask_for(choices=["a", "b"])
    field, button, said = shown(guess)
    button.click()
    assert "a guess is enough" in said.value
    field.value = "b"
    assert not field.disabled
    guess.beside("a")
    assert "You predicted b; it is a." in said.value and field.disabled and button.disabled
