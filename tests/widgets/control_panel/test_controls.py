"""The control panel's widgets: each has a name, and each key presses one of them."""

import ipywidgets

from nao_course.widgets import ControlPanel
from nao_course.widgets.control_panel.controls import KEYS
from nao_course.widgets.keyboard import key_names
from nao_course.widgets.parts import LabelledImage
from tests.widgets.robots import all_widgets, clean_nao


def test_every_control_has_a_name_and_every_key_presses_one_button():
    panel = ControlPanel(clean_nao())
    for widget in all_widgets(panel.widget):
        if isinstance(widget, ipywidgets.Button):
            assert widget.description and "key:" in widget.tooltip
        elif isinstance(widget, ipywidgets.Dropdown | ipywidgets.Checkbox):
            assert widget.description
        elif isinstance(widget, LabelledImage):
            assert widget.alt and widget.tooltip is None
    classes = [name for widget in all_widgets(panel.widget) for name in widget._dom_classes]
    assert all(classes.count(f"nao-do-{name}") == 1 for name in KEYS)
    keys = [key for several in KEYS.values() for key in several]
    assert len(keys) == len(set(keys))
    words = {("w", "arrowup"): "w or arrow up", (" ",): "space", ("x",): "x"}
    assert {each: key_names(each) for each in words} == words
