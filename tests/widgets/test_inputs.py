"""What can be set on a panel: what fits is rounded as a browser does it, what does not is refused with the limits."""

import pytest

from nao_course.widgets import Action, Choice, Pixel, RangeSlider, Slider, Toggle
from nao_course.widgets.inputs import check_controls

TILT = Slider("tilt", "Tilt", -5, 5, 0.1, 0.0, unit="°")
GAP = Slider("gap", "Gap", 0, 20, 2, 4, unit="px")
HUES = RangeSlider("hues", "Hues", 0, 360, 1, (10, 20))
ROW = Choice("row", "Row", (100, 150, 200))
LENS = Toggle("lens", "Lens", True)
PIXEL = Pixel("pixel", "Pixel", (320, 240))
AGAIN = Action("again", "Draw again", key="n")


@pytest.mark.parametrize(
    ("control", "given", "kept", "said"),
    [
        (TILT, 1.234, 1.2, "Tilt 1.2°"),
        (GAP, 7.2, 8, "Gap 8 px"),
        (GAP, 5, 6, "Gap 6 px"),  # 2.5 steps: a browser rounds halves up
        (HUES, (2.5, 3.5), (3, 4), "Hues 3 to 4"),
        (ROW, 150.0, 150, "Row 150"),
        (LENS, False, False, "Lens off"),
        (PIXEL, (319.0, 0), (319, 0), "Pixel (319, 0)"),
        (PIXEL, " (319, 0) ", (319, 0), "Pixel (319, 0)"),
        (AGAIN, 2, 2, "Draw again × 2"),
    ],
)
def test_what_fits_is_kept_as_a_browser_would_round_it(control, given, kept, said):
    value = control.checked(given)
    assert (value, type(value)) == (kept, type(kept))
    assert control.say(value) == said
    if control is not AGAIN:
        widget = control.widget()
        widget.value = control.to_widget(value)
        assert control.checked(widget.value) == kept


@pytest.mark.parametrize(
    ("control", "given", "said"),
    [
        (TILT, 5.1, "tilt must be from -5 to 5°, got 5.1"),
        (TILT, True, "tilt must be"),
        (HUES, 5, "hues must be two numbers from 0 to 360, got 5"),
        (HUES, (20, 10), "hues must have its smaller number first"),
        (HUES, (0, 361), "hues must be from 0 to 360, got 361"),
        (ROW, 101, "row must be one of 100, 150, 200; got 101"),
        (LENS, 1, "lens must be True or False, got 1"),
        (PIXEL, (320, 0), "u a whole number from 0 to 319 and v from 0 to 239; got"),
        (PIXEL, "12", "v from 0 to 239; got '12'"),
        (AGAIN, -1, "again must be a number of presses"),
    ],
)
def test_what_does_not_fit_is_refused_with_the_limits(control, given, said):
    with pytest.raises(ValueError, match=said.replace("(", r"\(")):
        control.checked(given)


@pytest.mark.parametrize("control", [TILT, GAP, HUES, ROW, LENS, PIXEL, AGAIN])
def test_every_control_has_a_label_and_a_tooltip(control):
    widget = control.widget()
    assert widget.description.startswith(control.label)
    assert widget.tooltip


def test_a_control_without_a_usable_name_or_limits_is_refused_and_so_are_two_of_one_name_or_key():
    with pytest.raises(ValueError, match="a control's name must be a valid variable name, got 'a b'"):
        Toggle("a b", "A")
    with pytest.raises(ValueError, match=r"values\.rng has another meaning"):
        Toggle("rng", "Noise")
    with pytest.raises(ValueError, match="low < high"):
        Slider("a", "A", 1, 1, 1, 1)
    with pytest.raises(ValueError, match="a must be from 0 to 1, got 2"):
        Slider("a", "A", 0, 1, 1, 2)
    with pytest.raises(ValueError, match="at least one option"):
        Choice("a", "A", ())
    check_controls([TILT, AGAIN, Action("zero", "Zero", key="z", sets={"tilt": 0})])
    with pytest.raises(ValueError, match="its own name; two have 'tilt'"):
        check_controls([TILT, TILT])
    with pytest.raises(ValueError, match="its own key; two have 'n'"):
        check_controls([AGAIN, Action("new", "New", key="N")])
    with pytest.raises(ValueError, match="zero sets gap, which is not a control"):
        check_controls([TILT, Action("zero", "Zero", sets={"gap": 0})])
    with pytest.raises(ValueError, match="tilt must be from -5 to 5"):
        check_controls([TILT, Action("far", "Far", sets={"tilt": 9})])
