"""Demonstration cells never stop a notebook."""

import pytest

from nao_course.exercises import try_out


def test_what_works_is_shown_as_it_is():
    assert try_out(lambda: [1, 2]) == [1, 2]


def test_an_unwritten_exercise_gets_its_sentence():
    def unwritten():
        raise NotImplementedError

    assert repr(try_out(unwritten, "Finish exercise 0.1.")) == "Finish exercise 0.1."


def test_an_error_is_named_and_escaped():
    def broken():
        raise ValueError("<script>alert(1)</script>")

    message = try_out(broken)
    assert repr(message).startswith("ValueError: <script>")
    assert "<script>" not in message._repr_html_()


def test_an_interrupt_goes_through():
    def interrupted():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        try_out(interrupted)
