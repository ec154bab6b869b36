"""Questions reply to each choice; predictions take only what can be one, and come back beside the result."""

import json

import numpy as np
import pytest

from nao_course.exercises import Checks
from nao_course.exercises.asking import Prediction, ask, prediction, reply
from nao_course.exercises.exercise import PublicLesson, PublicQuestion

WHY = PublicQuestion("why", "Why clamp?", {"Safety": "Yes.", "Speed": "It takes longer."}, "Safety")


def test_every_choice_has_its_reply():
    for number, (choice, text) in enumerate(WHY.choices.items(), start=1):
        sign = "✔ Right." if choice == WHY.right else "✘ Not quite."
        assert repr(reply(WHY, choice)) == repr(reply(WHY, str(number))) == f"{sign} {text}"
    for neither in ("", "0", "3", "no idea", "²"):
        assert "1. Safety, 2. Speed" in repr(reply(WHY, neither))


def test_buttons_answer_each_choice():
    _, buttons, answer = ask(WHY).children
    assert buttons.value is None
    assert answer.value == ""
    for choice, text in WHY.choices.items():
        buttons.value = choice
        assert text in answer.value
    buttons.value = None
    assert answer.value == ""


def test_a_question_is_text_where_no_widget_lives():
    check = Checks(PublicLesson("90_toy", [], [WHY]))
    bundle = check.question("why")._repr_mimebundle_()
    assert bundle["text/plain"] == "Why clamp?\n  1. Safety\n  2. Speed"
    json.dumps(bundle)
    assert "Not quite" in repr(check.question("why", 2))


@pytest.fixture
def ask_for(request):
    """A prediction that no other test asks for."""

    def ask(**options):
        return prediction(request.node.nodeid, **options)

    return ask


@pytest.mark.parametrize("own", ["Right. It counts.", "right: it counts.", "It counts."])
def test_no_reply_says_twice_that_it_is_right(own):
    question = PublicQuestion(
        "why", "Why?", {"So": own, "Not": "Not quite: the right half is missing."}, "So"
    )
    assert repr(reply(question, "So")) == "✔ Right. It counts."
    assert repr(reply(question, "Not")) == "✘ Not quite. The right half is missing."


@pytest.mark.parametrize(
    ("typed", "value"), [(" 0.5 m ", 0.5), ("0,5 metres", 0.5), ("−3", -3.0), ("1e-2", 0.01), (4, 4.0)]
)
def test_a_number_is_taken_with_its_unit_or_without(ask_for, typed, value):
    guess = ask_for(unit="m")
    assert repr(guess.write(typed)) == f"You predicted {value:g} m. Now run the next cell."
    assert guess.value == value


@pytest.mark.parametrize(
    ("typed", "said"),
    [
        ("", "a guess is enough"),
        ("asdf", "'asdf' is not a number in m"),
        ("nan", "is not a number in m"),
        ("1 2", "is not a number in m"),
        ("50 cm", "'50 cm' has another unit"),
        ("-1", "It cannot be -1 m, because it is from 0 to 4 m."),
        ("5", "It cannot be 5 m"),
    ],
)
def test_what_cannot_be_a_prediction_gets_a_sentence_and_is_not_kept(ask_for, typed, said):
    guess = ask_for(unit="m", low=0, high=4)
    assert said in repr(guess.write(typed))
    assert guess.value is None


def test_one_limit_is_said_alone(ask_for):
    assert "it is at least 0." in repr(ask_for(low=0).write("-1"))
    assert "it is at most 0°." in repr(ask_for(unit="°", high=0).write("1 deg"))


def test_a_choice_is_given_by_its_words_or_its_number(ask_for):
    guess = ask_for(choices=["along", "across", "heading"])
    assert "1. along, 2. across, 3. heading" in repr(guess.write("up"))
    assert guess.value is None
    guess.write("Heading")
    assert guess.value == "heading"
    guess.write("2")
    assert repr(guess.beside("heading")) == "You predicted across; it is heading."


@pytest.mark.parametrize(
    ("unit", "measured", "said"),
    [
        ("m", 1.9345, "1.93 m"),
        ("%", np.float32(56.17), "56.2 %"),
        ("°", -9.7, "-9.7°"),
        ("", np.int64(1700), "1700"),
        ("", -1e-12, "-1e-12"),
    ],
)
def test_what_came_out_stands_beside_the_prediction(ask_for, unit, measured, said):
    guess = ask_for(unit=unit)
    guess.write("2")
    assert repr(guess.beside(measured)).endswith(f"; it is {said}.")
    assert repr(guess).endswith(f"; it is {said}.")


@pytest.mark.parametrize(
    ("unit", "said"),
    [
        ("particles", "1 particle"),
        ("degrees", "1 degree"),
        ("m", "1 m"),
        ("ms", "1 ms"),
        ("%", "1 %"),
        ("°", "1°"),
    ]
    + [("", "1")],
)
def test_one_is_said_in_the_singular_and_any_other_number_in_the_plural(ask_for, unit, said):
    guess = ask_for(unit=unit)
    guess.write(said)  # it may be typed like that, too
    assert repr(guess.beside(2)).startswith(f"You predicted {said}; it is 2")
    assert repr(guess.beside(1)) == f"You predicted {said}, and so it is."
    alone = Prediction("How many?", unit)
    alone.beside(np.int64(1))
    assert repr(alone.give_up()).startswith(f"You wrote no prediction: it is {said}. ")


def test_half_of_a_thing_is_said_in_the_plural(ask_for):
    guess = ask_for(unit="particles")
    guess.write("0.5")
    assert repr(guess.beside(0)) == "You predicted 0.5 particles; it is 0 particles."


def test_without_a_prediction_the_result_waits_for_one(ask_for):
    guess = ask_for(unit="m")
    field, _, said = shown(guess)
    assert "2" not in repr(guess.beside(2.0)) and "2" not in repr(guess) and "A guess is enough" in said.value
    assert not field.disabled
    assert repr(guess.write("1")) == "You predicted 1 m; it is 2 m."


def test_who_gives_up_is_told_the_result_kindly_and_can_no_longer_write_one(ask_for):
    guess = ask_for(unit="m")
    field, _, said = shown(guess)
    *_, quit_button = guess._view.box.children[1].children
    assert quit_button.layout.display == "none"
    assert "first" in repr(guess.give_up())
    guess.beside(2.0)
    assert quit_button.layout.display == ""
    quit_button.click()
    assert "You wrote no prediction: it is 2 m. Next time, guess first; a guess is enough." in said.value
    assert field.disabled and quit_button.layout.display == "none"
    assert "already seen the result" in repr(guess.write("1"))


def test_it_can_be_changed_until_the_result_is_there(ask_for):
    guess = ask_for()
    guess.write("1")
    guess.write("2")
    guess.beside(3)
    assert "You have already seen the result. You predicted 2" in repr(guess.write("3"))
    assert repr(guess.beside(3)) == "You predicted 2; it is 3."  # the cell is run again


def test_a_cell_that_is_run_again_shows_what_was_written(ask_for):
    ask_for(unit="m").write("1")
    assert ask_for(unit="m").value == 1.0
    assert ask_for(unit="cm").value is None


def test_it_is_text_where_no_widget_lives(ask_for):
    bundle = ask_for(unit="m")._repr_mimebundle_()
    assert bundle["text/plain"].startswith("Predict: ")
    assert bundle["text/plain"].endswith("(in m)")
    json.dumps(bundle)


def shown(guess):
    """The widgets of a prediction: field, button and what is said."""
    guess._repr_mimebundle_()
    _, row, said = guess._view.box.children
    return row.children[0], row.children[2], said


def test_enter_writes_what_stands_in_the_field(ask_for):
    guess = ask_for(unit="m")
    field, _, said = shown(guess)
    assert not field.continuous_update  # so that a change is Enter, or leaving the field
    field.value = "<b>far</b>"
    assert "is not a number in m" in said.value and "<b>" not in said.value
    field.value = "2"
    assert guess.value == 2.0
    assert "You predicted 2 m. Now" in said.value


def test_the_button_writes_too_and_the_field_is_closed_when_the_result_is_there(ask_for):
    guess = ask_for(choices=["a", "b"])
    field, button, said = shown(guess)
    button.click()
    assert "a guess is enough" in said.value
    field.value = "b"
    assert not field.disabled
    guess.beside("a")
    assert "You predicted b; it is a." in said.value
    assert field.disabled and button.disabled
