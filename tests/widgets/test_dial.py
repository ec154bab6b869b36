"""The reality dial: sliders, presets and code say the same, and a picture stays where no widget lives."""

import asyncio
import html
import re

import numpy as np
import pytest

from nao_course.sim import Reality
from nao_course.widgets import RealityDial
from nao_course.widgets.parts import jpeg
from tests.widgets.robots import all_widgets


def picture(dial):
    return dial._row.places[0].image


def message(dial):
    """The latest message, which a screen reader reads aloud."""
    return html.unescape(re.search(r'role="status"[^>]*>(.*?)</div>', dial._said.value)[1])


def test_it_begins_as_the_laboratory_and_a_slider_changes_its_effect_but_a_browsers_rounding_does_not():
    dial = RealityDial()
    assert dial.reality == Reality.lab()
    assert dial.pixels.tobytes() == RealityDial().pixels.tobytes()
    before = picture(dial).value
    dial._sliders["noise"].value = 4.0
    assert dial.reality.noise == pytest.approx(4.0)
    assert picture(dial).value != before
    dial = RealityDial()
    before = repr(dial)
    for slider in dial._sliders.values():
        slider.value = round(slider.value / slider.step) * slider.step
    dial._tilt.value = 4e-16
    assert repr(dial) == before and message(dial) == ""


@pytest.mark.parametrize("name", ["clean", "harsh"])
def test_a_preset_moves_every_slider(name):
    dial = RealityDial()
    dial.preset(name)
    wanted = getattr(Reality, name)()
    assert dial.reality == wanted
    for effect, slider in dial._sliders.items():
        assert slider.value == pytest.approx(getattr(wanted, effect))


def test_what_is_not_possible_is_refused_and_sliders_are_in_groups_that_fold_with_plain_names():
    dial = RealityDial()
    with pytest.raises(ValueError, match="preset must be one of"):
        dial.preset("real")
    with pytest.raises(ValueError, match="noise must be 0"):
        dial.set(noise=-1.0)
    with pytest.raises(TypeError, match="dust"):
        dial.set(dust=1.0)
    assert dial.reality == Reality.lab()
    (folds,) = [each for each in all_widgets(dial.widget) if hasattr(each, "titles")]
    grouped = [slider for group in folds.children for slider in group.children]
    assert sorted(map(id, grouped)) == sorted(map(id, dial._sliders.values()))
    assert not {slider.description for slider in grouped} & {"pile", "mottle", "litter", "grain", "vignette"}
    dial.set(pile=1.0)
    assert "darker from above 1" in dial.summary() and "pile" not in dial.summary()


def test_in_a_kernels_loop_only_the_newest_slider_is_rendered():
    dial = RealityDial()
    shown = []
    picture(dial).observe(lambda change: shown.append(change["new"]), "value")

    async def scenario():
        for burst in range(2):  # while one picture is rendered, a browser sends several values
            for step in range(1, 11):
                dial._sliders["noise"].value = 0.1 * (10 * burst + step)
                dial._tilt.value = 0.1 * step
            await asyncio.sleep(0)
        while dial._newest.busy:
            await asyncio.sleep(0.01)

    asyncio.run(scenario())
    assert dial.reality.noise == pytest.approx(2.0)
    assert dial.tilt == pytest.approx(np.radians(1.0))
    assert 1 <= len(shown) <= 3
    assert shown[-1] == jpeg(dial.pixels)
    assert "noise 2" in dial._said.value


@pytest.mark.slow
def test_every_slider_says_what_it_does_where_it_is_and_while_it_is_moved():
    dial = RealityDial()
    sliders = [*dial._sliders.values(), dial._tilt]
    assert len(sliders) == 19
    for slider in sliders:
        slider.value = slider.max / 2
        dial._show()
        name, meaning = slider.tooltip.split("; from")[0].split(": ")
        assert message(dial) == f"{name}: {meaning}"
    dial.preset("clean")
    assert message(dial) == ""
