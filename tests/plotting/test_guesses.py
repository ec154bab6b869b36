"""A prediction is a dashed line in the figure that answers it; without one the figure stays as it is."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from nao_course.exercises.asking import Prediction
from nao_course.plotting import Drawing, with_guess


def drawing(log=False):
    figure = Figure()
    ax = figure.add_subplot()
    ax.set(xlim=(0, 10), ylim=(1, 100), yscale="log" if log else "linear")
    return Drawing(figure, "A figure.")


def guess(typed=None, **options):
    made = Prediction("How far?", **options)
    if typed is not None:
        made.write(typed)
    return made


def label_in(drawn):
    return drawn.figure.axes[0].texts[-1].get_text()


def test_without_a_number_the_figure_stays_and_a_length_on_a_map_is_a_circle_around_the_origin():
    plain = drawing()
    assert with_guess(plain, guess(), "x") is plain
    assert with_guess(plain, guess("left", choices=("left", "right")), "x") is plain
    assert not plain.figure.axes[0].lines
    drawn = with_guess(drawing(), guess("0.2", unit="m"), "y", place=lambda metres: 100 * metres)
    assert list(drawn.figure.axes[0].lines[-1].get_ydata()) == [20, 20]
    with pytest.raises(ValueError, match='axis must be "x", "y" or "radius"'):
        with_guess(drawing(), guess("1"), "z")
    for typed, label in (("3", "you"), ("300", "you ↑")):
        drawn = with_guess(drawing(), guess(typed), "radius")
        ax = drawn.figure.axes[0]
        assert ax.patches[-1].radius == float(typed) and label_in(drawn) == label
        assert "A dashed circle labelled" in drawn.alt
        assert np.array_equal(ax.axis(), (0, 10, 1, 100))


@pytest.mark.parametrize(
    ("axis", "typed", "at", "label"),
    [
        ("x", "4", [4, 4], "you"),
        ("x", "-2", [0, 0], "← you"),
        ("x", "12", [10, 10], "you →"),
        ("y", "50", [50, 50], "you"),
        ("y", "0.1", [1, 1], "you ↓"),
        ("y", "200", [100, 100], "you ↑"),
    ],
)
@pytest.mark.parametrize("log", [False, True])
def test_a_number_is_a_line_on_its_axis_or_at_the_end_of_the_axis(axis, typed, at, label, log):
    drawn = with_guess(drawing(log), guess(typed), axis)
    line = drawn.figure.axes[0].lines[-1]
    assert list(line.get_xdata() if axis == "x" else line.get_ydata()) == at
    assert label_in(drawn) == label
    assert drawn.alt.startswith("A figure. ") and f"prediction, {float(typed):g}." in drawn.alt
    drawn.image()
