"""Demonstration cells never stop a notebook."""

from unittest import mock

import cv2
import numpy as np
import pytest
import sympy
from IPython.core.interactiveshell import InteractiveShell

from nao_course.exercises import try_out, trying


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


def test_a_name_that_a_restarted_kernel_does_not_know_is_told_apart_from_a_slip_in_a_function():
    def slip():
        value = value + 1  # noqa: F821, F841

    assert "does not know 'field' yet. If the kernel was restarted" in repr(try_out(lambda: field))  # noqa: F821
    assert repr(try_out(slip)).startswith("UnboundLocalError")


def test_an_unknown_name_inside_a_function_comes_with_its_line_and_one_of_the_courses_with_its_import():
    def typed():
        return thresh  # noqa: F821

    assert "does not know 'thresh' yet (line " in repr(try_out(typed))
    assert "return thresh" in repr(try_out(typed))
    assert repr(try_out(lambda: progress())).endswith("from nao_course.student import progress")  # noqa: F821


def test_in_jupyter_each_unknown_name_gets_its_sentence_below_the_traceback(capsys):
    shell = InteractiveShell()
    try:
        with mock.patch.object(trying.sys.modules["IPython"], "get_ipython", return_value=shell):
            trying.explain_unknown_names()
        result = shell.run_cell("field")
        assert isinstance(result.error_in_exec, NameError)
        said = capsys.readouterr().out
        assert "NameError" in said and "does not know 'field' yet" in said
        shell.run_cell("1 / 0")
        assert "does not know" not in capsys.readouterr().out
    finally:
        InteractiveShell.clear_instance()


@pytest.mark.parametrize(
    ("slip", "advice"),
    [
        (lambda: np.ones((2, 3)) @ np.ones((2, 3)), "one transposed that should not be"),
        (lambda: np.linalg.solve(np.eye(2), np.ones(3)), "Print each .shape"),
        (lambda: np.ones(4) - np.ones(2), "need one shape"),
        (lambda: np.zeros(0)[0], "That array is empty"),
        (lambda: np.zeros(3)[3], "the last of n is n - 1"),
        (lambda: np.zeros(3)[0:1.6], "Limits of a slice are whole numbers"),
        (lambda: np.zeros(3)[np.array([0.5])], "Indices are whole numbers"),
        (lambda: (lambda: 0).shape, "a function, not an array"),
        (lambda: np.ones(2) ^ 2, "A power is **"),
        (lambda: 1.5 ^ 2, "A power is **"),
        (lambda: np.zeros(3) + np.zeros(2), "pose[:2] is the place"),
        (lambda: float(sympy.Symbol("x")), "symbols of SymPy"),
        (lambda: cv2.Canny(np.zeros((3, 3)), 50, 150), "a picture of bytes"),
    ],
)
def test_numpys_complaint_gets_one_piece_of_advice_that_fits(slip, advice):
    with pytest.raises((IndexError, TypeError, AttributeError, ValueError, cv2.error)) as caught:
        slip()
    (said,) = trying.advice_on(f"{type(caught.value).__name__}: {caught.value}")
    assert advice in said
