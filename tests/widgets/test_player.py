"""A player plays its slider at a pace, forwards and backwards, and has one master: who takes over stops it."""

import asyncio

import numpy as np
import pytest

from nao_course.widgets import PlayerPanel, Slider
from tests.widgets.robots import all_widgets

FAST = {"fast": 1e4, "slow": 2.0}


def show(values, student):
    yield np.full((4, 4), values.step, dtype=np.uint8)
    yield f"At {values.step}{values.get('turn', '')}."


def make(*others, start=0, speeds=FAST, **more):
    return PlayerPanel("Player", show, Slider("step", "Step", 0, 20, 1, start), others, speeds=speeds, **more)


def press(panel, name):
    panel._widgets[name].click()


def reset_button(panel):
    return next(each for each in all_widgets(panel.widget) if getattr(each, "description", "") == "Reset")


def label(panel, name="forwards"):
    return panel._widgets[name].description


def test_buttons_go_on_and_back_and_stop_at_both_ends():
    panel = make(start=19)
    for expected in (20, 20):
        press(panel, "on")
        assert panel.values.step == expected and panel.summary().endswith(f"At {expected}.")
    press(panel, "back")
    assert panel.values.step == 19
    panel.set(step=0)
    press(panel, "back")
    assert panel.values.step == 0


def test_it_plays_to_the_end_and_back_and_its_button_says_pause_meanwhile():
    async def drive():
        panel = make(start=17)
        press(panel, "forwards")
        assert panel.playing and label(panel) == "Pause" and label(panel, "backwards") == "Backwards"
        await panel._playing
        assert panel.values.step == 20 and not panel.playing and label(panel) == "Play"
        press(panel, "backwards")
        assert label(panel, "backwards") == "Pause" and label(panel) == "Play"
        await panel._playing
        assert panel.values.step == 0 and label(panel, "backwards") == "Backwards"
        panel.set(step=20)
        press(panel, "forwards")  # from the end it begins anew
        await asyncio.sleep(0)
        assert panel.values.step < 20
        press(panel, "backwards")  # it turns round
        assert panel.playing and label(panel) == "Play" and label(panel, "backwards") == "Pause"
        await panel._playing
        assert panel.values.step == 0

    asyncio.run(drive())


TAKE_OVER = {
    "its button": (lambda panel: press(panel, "forwards"), None),
    "one back": (lambda panel: press(panel, "back"), None),
    "Reset": (lambda panel: reset_button(panel).click(), 3),
    "the slider": (lambda panel: setattr(panel._widgets["step"], "value", 11), 11),
}


@pytest.mark.parametrize("who", TAKE_OVER)
def test_who_takes_over_stops_it(who):
    take_over, place = TAKE_OVER[who]

    async def drive():
        panel = make(start=3)
        press(panel, "forwards")
        await asyncio.sleep(0)
        assert panel.playing
        take_over(panel)
        stopped = panel.values.step
        assert not panel.playing and label(panel) == "Play" and stopped == (place or stopped)
        for _ in range(5):
            await asyncio.sleep(0.005)
        assert panel.values.step == stopped

    asyncio.run(drive())


def test_a_key_that_is_held_has_the_pace_of_the_speed_and_with_one_speed_there_is_nothing_to_choose():
    panel = make()
    assert "nao-repeat-0" in panel.widget._dom_classes
    panel._widgets["speed"].value = "slow"
    assert [name for name in panel.widget._dom_classes if "repeat" in name] == ["nao-repeat-500"]
    panel.reset()  # leaves the speed
    assert [name for name in panel.widget._dom_classes if "repeat" in name] == ["nao-repeat-500"]
    panel = make(speeds={"one": 1.4}, backwards=False)
    assert "speed" not in panel.values and "backwards" not in panel.values and panel.speed == 1.4
    assert "nao-repeat-714" in panel.widget._dom_classes
    hint = "Keys: space Play, b Backwards, \N{LEFTWARDS ARROW} Step back, \N{RIGHTWARDS ARROW} Step on"
    keyed = next(each for each in all_widgets(make().widget) if "nao-key-line" in each._dom_classes)
    assert hint in keyed.value and keyed.layout.min_width == f"min(100%, {len(hint)}ch)"
    assert "arrow left: Step back" in keyed.value  # what a screen reader says


def test_presses_that_come_faster_than_pictures_each_count_and_are_drawn_once():
    drawn = []

    def counted(values, student):
        drawn.append(values.step)
        return np.zeros((2, 2), dtype=np.uint8)

    async def drive():
        panel = PlayerPanel("Player", counted, Slider("step", "Step", 0, 20, 1, 0), speeds=FAST)
        for _ in range(9):
            press(panel, "on")
        assert panel.values.step == 9 and drawn == [0]
        await asyncio.sleep(0.1)
        assert drawn == [0, 9]

    asyncio.run(drive())
