"""A panel from a function: its controls reach it, what it shows is shown, and a student's mistake is a sentence."""

import asyncio
import html
import re
import threading
import time

import cv2
import ipywidgets
import numpy as np
import pytest

from nao_course.plotting import draw_map, draw_picture, table
from nao_course.sim import Field
from nao_course.widgets import (
    Action,
    Choice,
    FunctionPanel,
    Legend,
    Pixel,
    RangeSlider,
    Slider,
    Toggle,
    picture_row,
)
from nao_course.widgets import __all__ as public
from nao_course.widgets.parts import LabelledImage
from nao_course.widgets.shown import Shown, encoded
from tests.paths import PROJECT
from tests.widgets.robots import all_widgets, decoded, press

LEVEL = Slider("level", "Level", 0, 250, 10, 100)
NOISE = np.random.default_rng(0).integers(0, 256, (24, 32, 3), dtype=np.uint8)


def show(values, student):
    yield {"The scene": NOISE}
    bright = student.brighter(NOISE, values.level)
    yield {"Your mask": bright}
    yield table(["", "pixels"], [["bright", int(bright.sum())]])
    yield f"{bright.mean():.0%} are bright."


def brighter(picture, level):
    return picture.mean(axis=2) > level


def make(student=brighter, controls=(LEVEL,), function=show, **options):
    return FunctionPanel("Brightness", function, list(controls), student={"brighter": student}, **options)


def image(panel, number):
    return [each for each in all_widgets(panel.widget) if isinstance(each, LabelledImage)][number]


def status(panel):
    return html.unescape(panel._status.value)


def test_the_panel_of_the_documentation_is_made_of_ten_lines_and_says_what_the_page_says():
    page = (PROJECT / "docs" / "write_a_panel.md").read_text(encoding="utf-8")
    example, *_ = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 11  # the import is the eleventh
    room = {}
    exec(example, room)
    scene = np.random.default_rng(0).integers(0, 256, (240, 320, 3), dtype=np.uint8)
    panel = room["mask_panel"](scene, brighter)
    mask = brighter(scene, 120)
    said = f"{mask.mean():.0%} is bright; the pixel (160, 120) is {mask[120, 160]}."
    assert panel.summary() == f"Level 120, Pixel (160, 120)\n{said}"
    with pytest.raises(ValueError, match="level must be from 0 to 255, got 300"):
        panel.set(level=300)
    assert room["mask_panel"](scene, unwritten).summary().endswith("Finish exercise 1.3 to see this.")
    assert "IndexError in brighter(), line" in room["mask_panel"](scene, lambda *given: [][1]).summary()
    assert all(f"`{name}(" in page for name in public if name not in ("ControlPanel", "RealityDial"))


def test_every_control_reaches_the_function_from_the_page_and_from_code():
    got = []
    controls = [
        LEVEL,
        RangeSlider("hues", "Hues", 0, 360, 1, (10, 20)),
        Choice("row", "Row", (100, 150)),
        Toggle("lens", "Lens", True),
        Pixel("pixel", "Pixel", (32, 24)),
        Action("again", "Draw again"),
    ]
    panel = FunctionPanel("All", lambda values, student: got.append(dict(values)) or "", controls)
    first = {"level": 100, "hues": (10, 20), "row": 100, "lens": True, "pixel": (16, 12), "again": 0}
    assert got == [first]
    moved = {"level": 120, "hues": (30, 40), "row": 150, "lens": False, "pixel": "3, 4"}
    for name, value in moved.items():
        panel._widgets[name].value = value
    press(panel, "again")
    last = {**moved, "pixel": (3, 4), "again": 1}
    assert got[-1] == panel.values == last
    assert len(got) == 1 + len(last)
    panel.set(**first)
    assert got[-1] == first and len(got) == 2 + len(last)
    assert [panel._widgets[name].value for name in moved] == [100, (10, 20), 100, True, "16, 12"]


def test_bad_values_are_refused_and_nothing_is_set_and_what_is_typed_and_impossible_is_a_sentence():
    panel = make(controls=[LEVEL, Toggle("lens", "Lens")])
    with pytest.raises(ValueError, match="level must be from 0 to 250, got 251"):
        panel.set(lens=True, level=251)
    with pytest.raises(TypeError, match="this panel has no size; it has level, lens"):
        panel.set(size=3)
    assert panel.values == {"level": 100, "lens": False}
    panel = make(controls=[LEVEL, Pixel("pixel", "Pixel", (32, 24))])
    panel._widgets["pixel"].value = "40, 2"
    assert "u a whole number from 0 to 31" in status(panel)
    assert panel.values.pixel == (16, 12)
    assert panel._widgets["pixel"].value == "16, 12"
    panel._widgets["level"].value = 20
    assert "must be" not in status(panel)


def test_reset_and_buttons_that_set_ask_once_and_reset_leaves_what_is_looked_at():
    calls = []
    dark = Action("dark", "Dark", key="d", sets={"level": 10})
    panel = make(lambda *given: calls.append(1) or brighter(*given), [LEVEL, dark])
    press(panel, "dark")
    assert panel.values == {"level": 10}
    assert panel._widgets["level"].value == 10
    panel._widgets["level"].value = 20
    press(panel, "reset")
    assert panel.values == {"level": 100}
    assert len(calls) == 4
    scenes = Choice("scene", "Scene", ("a", "b"), stays=True)
    panel = make(controls=[LEVEL, scenes, Choice("show", "Show", (1, 2))])
    panel.set(level=7, scene="b", show=2)
    press(panel, "reset")
    assert panel.values == {"level": 100, "scene": "b", "show": 1}
    assert panel._widgets["scene"].value == "b"
    button = next(each for each in all_widgets(panel.widget) if getattr(each, "description", "") == "Reset")
    assert button.tooltip == "Set all controls to their start values; Scene stays"


def test_random_numbers_are_the_same_until_a_button_draws_again():
    again = Action("again", "Draw again")

    def draw(values, student):
        return f"{values.rng.integers(10**9)}"

    first, second = (FunctionPanel("Noise", draw, [again], seed=3) for _ in range(2))
    seen = first.summary()
    assert seen == second.summary()
    press(first, "again")
    assert first.shown.texts != second.shown.texts
    second.set(again=1)
    assert first.summary() == second.summary()
    first.reset()
    assert first.summary() == seen
    assert FunctionPanel("Noise", draw, [again], seed=4).summary() != seen


def test_pictures_tables_and_sentences_are_shown_and_summed_up_and_a_figures_words_are_its_alternative():
    panel = make()
    assert np.array_equal(decoded(image(panel, 1))[..., 0] == 255, NOISE.mean(axis=2) > 100)
    assert image(panel, 0).alt == "Brightness: The scene"
    assert "bright</td>" in panel._table.value
    assert "are bright." in status(panel)
    lines = panel.summary().splitlines()
    assert lines[0] == "Level 100" and lines[1].endswith("are bright.") and lines[-1].startswith("bright")
    panel.set(level=250)
    assert "0% are bright." in panel.summary()
    drawing = draw_picture(NOISE, title="Noise")
    assert image(FunctionPanel("One", lambda values, student: drawing, [LEVEL]), 0).alt == drawing.alt


def test_a_legend_table_or_row_of_small_pictures_without_contents_takes_no_place():
    def show(values, student):
        yield NOISE
        if values.level > 100:
            yield Legend({"bright": "#ffffff"})
        else:
            yield table(["level"], [[str(values.level)]])

    panel = FunctionPanel("One", show, [LEVEL])
    parts = {"nao-legend", "nao-scores", "nao-pictures"}
    for level, shown in ((50, "nao-scores"), (200, "nao-legend")):
        panel.set(level=level)
        _, side = panel.widget.children[1].children
        empty = [set(each._dom_classes) for each in all_widgets(side) if "nao-empty" in each._dom_classes]
        assert set().union(*empty) & parts == parts - {shown}


def test_controls_are_beside_one_picture_and_below_two_and_small_pictures_are_among_the_controls():
    def pictures(values, student):
        return {str(number): NOISE for number in range(values.count)}

    panel = FunctionPanel("Some", pictures, [Slider("count", "Count", 1, 2, 1, 1)])
    assert "nao-beside" in panel.widget._dom_classes
    panel.set(count=2)
    assert "nao-beside" not in panel.widget._dom_classes
    panel = FunctionPanel("Two", lambda values, student: {"A": NOISE, "B": NOISE}, [LEVEL], small=("B",))
    main, side = panel.widget.children[1].children
    assert [each.alt for each in all_widgets(main) if isinstance(each, LabelledImage)] == ["Two: A"]
    assert [each.alt for each in all_widgets(side) if isinstance(each, LabelledImage)] == ["Two: B"]
    assert "nao-beside" in panel.widget._dom_classes


def test_only_pictures_that_changed_are_sent_and_keys_press_the_buttons_that_have_one(monkeypatch):
    panel, sent = make(), []
    monkeypatch.setattr(picture_row, "encoded", lambda *given: sent.append(given[0]) or encoded(*given))
    panel.set(level=100)
    assert sent == []
    panel.set(level=110)
    assert [np.array_equal(each, panel.shown.pictures["Your mask"]) for each in sent] == [True]

    def words(panel):
        return "".join(each.value for each in all_widgets(panel.widget) if isinstance(each, ipywidgets.HTML))

    said = words(make(controls=[LEVEL, Action("draw_again", "Again", key="N")]))
    assert html.escape('{"n": "draw-again"}') in said and "n: Again" in said
    assert 'nao-keys"' not in words(make())


def test_a_pixel_is_marked_over_its_picture_and_a_legend_says_what_colours_mean():
    controls = [LEVEL, Pixel("pixel", "Pixel", (32, 24), (0, 0), picture="Your mask")]
    panel = make(controls=controls)
    frames = [each for each in all_widgets(panel.widget) if "nao-frame" in each._dom_classes]
    assert [len(frame.children) for frame in frames] == [1, 3]
    before = panel.drawing().image()
    panel.set(pixel=(31, 23))
    assert "left: 98.438%; top: 97.917%" in panel._pads["pixel"][1].value
    assert panel.drawing().image() != before
    large = FunctionPanel("Large", lambda values, student: NOISE, [Pixel("pixel", "Pixel", (4, 3), (1, 2))])
    (ax,) = large.drawing().figure.axes
    height, width = NOISE.shape[:2]
    marked = [value[0] for value in ax.lines[-1].get_data()]
    assert marked == pytest.approx([1.5 * width / 4 - 0.5, 2.5 * height / 3 - 0.5])
    nothing = FunctionPanel(
        "None", lambda values, student: "no picture", [Pixel("pixel", "Pixel", (4, 3), (1, 2))]
    )
    assert "no picture" in nothing.drawing().alt
    panel = FunctionPanel("Two", lambda values, student: iter([NOISE, Legend({"a < b": "#ff0000"})]), [LEVEL])
    assert "a &lt; b" in panel._legend.value and "#ff0000" in panel._legend.value
    assert "a < b" in [text.get_text() for text in panel.drawing().figure.legends[0].get_texts()]


def test_a_picture_with_opacity_is_sent_with_it_however_many_colours_it_has(rng):
    pixels = rng.integers(0, 255, (20, 30, 4), dtype=np.uint8)
    kind, data = encoded(pixels, False)
    sent = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    assert kind == "png" and np.array_equal(sent[..., [2, 1, 0, 3]], pixels)


@pytest.mark.parametrize(
    ("shown", "said"),
    [
        (None, "the function returned None"),
        (3.5, "a panel shows a picture, a Drawing, a table, a text"),
        (np.zeros((4, 4)), "a picture must be uint8 of shape (H, W, 3), (H, W, 4) or (H, W)"),
        (np.zeros((4, 4, 2), dtype=np.uint8), "got uint8 (4, 4, 2)"),
    ],
)
def test_what_cannot_be_shown_is_a_sentence(shown, said):
    panel = FunctionPanel("Wrong", lambda values, student: shown, [LEVEL])
    assert said in panel.summary()
    assert "nao-alarm" in panel._status.value


def unwritten(picture, level):
    raise NotImplementedError


def failing(picture, level):
    if level > 200:
        raise IndexError("no <b>pixel</b>")
    return brighter(picture, level)


@pytest.mark.parametrize(
    ("unfinished", "said"),
    [
        ("Finish exercise 1.3.", "Finish exercise 1.3."),
        ({"other": "Finish exercise 1.5."}, "Finish brighter() to see this."),
    ],
)
def test_an_exercise_that_is_not_written_is_a_sentence_and_the_rest_is_shown(unfinished, said):
    panel = make(unwritten, unfinished=unfinished)
    assert panel.summary().endswith(said)
    assert said in status(panel) and "raise panel.error" not in status(panel)
    assert list(panel.shown.pictures) == ["The scene"]
    panel.set(level=20)
    assert "<img alt=" in panel._repr_mimebundle_()["text/html"]


def test_a_mistake_is_a_sentence_with_its_line_and_the_panel_goes_on():
    panel = make(failing)
    panel._widgets["level"].value = 210
    line = failing.__code__.co_firstlineno + 2
    assert f"IndexError in brighter(), line {line}: no <b>pixel</b>" in panel.summary()
    assert "&lt;b&gt;" in panel._status.value and "raise panel.error" in panel._status.value
    assert "(nothing yet)" in image(panel, 1).alt
    assert "table" not in panel._table.value
    with pytest.raises(IndexError):
        raise panel.error
    panel._widgets["level"].value = 100
    assert "are bright." in panel.summary()
    assert "nothing yet" not in image(panel, 1).alt


def test_a_function_that_writes_into_the_picture_spoils_nothing_and_what_it_prints_is_in_the_panel(capsys):
    before = NOISE.copy()

    def spoil(picture, level):
        picture[:] = 0
        return picture.mean(axis=2) > level

    make(spoil)
    assert np.array_equal(NOISE, before)
    panel = make(lambda *given: print("mean < 80") or brighter(*given))
    assert "mean &lt; 80" in panel._status.value
    assert capsys.readouterr().out == ""


def test_a_function_that_is_defined_again_is_used_at_once():
    notebook = {"np": np}
    code = "def brighter(picture, level):\n    return picture.mean(axis=2) {} level"
    exec(code.format(">"), notebook)
    panel = make(notebook["brighter"])
    exec(code.format("<"), notebook)
    before = panel.shown.pictures["Your mask"]
    panel.set(level=100)
    assert (panel.shown.pictures["Your mask"] != before).any()


def test_a_function_that_never_ends_is_stopped_in_any_thread():
    def endless(picture, level):
        while level > 200:
            pass
        return brighter(picture, level)

    panel = make(endless)
    panel.time_limit = 0.1
    thread = threading.Thread(target=panel.set, kwargs={"level": 210})
    thread.start()
    thread.join(30)
    assert "brighter() was not done after 0.1 s and was stopped" in panel.summary()
    panel.time_limit = 60
    panel.reset()
    assert "are bright." in panel.summary()


def test_in_a_kernels_loop_only_the_newest_value_is_shown():
    got = []

    def count(values, student):
        got.append(values.level)
        return "Counted."

    panel = FunctionPanel("Newest", count, [LEVEL])
    got.clear()

    async def scenario():
        for burst in range(2):
            for step in range(1, 6):
                panel._widgets["level"].value = 100 * burst + 10 * step
            await asyncio.sleep(0)
        while panel._newest.busy:
            await asyncio.sleep(0.01)

    asyncio.run(scenario())
    assert got == [50, 150]
    assert "Level 150" in panel.summary()


def test_a_button_that_arrives_before_the_pixel_that_was_clicked_first_acts_on_that_pixel():
    taken = []

    def take(values, student):
        if values.take > len(taken):
            taken.append(values.pixel)
        return {"The scene": NOISE}

    panel = FunctionPanel("Take", take, [Pixel("pixel", "Pixel", (32, 24)), Action("take", "Take")])

    async def scenario():
        panel._widgets["take"].click()
        await asyncio.sleep(0)
        panel._widgets["pixel"].value = "3, 4"
        while not taken:
            await asyncio.sleep(0.01)

    asyncio.run(asyncio.wait_for(scenario(), 60))
    assert taken == [(3, 4)]


def test_names_that_are_not_there_are_errors_that_list_others_and_wrong_results_are_said_to_be_of_their_function():
    panel = FunctionPanel("A", lambda values, student: values.size, [LEVEL])
    assert "no control 'size'; it has ['level']" in panel.summary()
    panel = make(function=lambda values, student: student.darker())
    assert "no function 'darker'; it has ['brighter']" in panel.summary()
    with pytest.raises(ValueError, match="brighter must be a function, got int"):
        make(3)
    panel = make(lambda picture, level: None)
    assert "AttributeError in the panel, in the code that uses the result of brighter()" in panel.summary()


def test_the_still_picture_of_a_panel_keeps_photographs_on_a_dark_page_and_inverts_drawings():
    given = {"photo": np.zeros((20, 30, 3), np.uint8), "map": draw_map(Field())}
    still = Shown.of([given]).drawing("words", {})
    (kept,) = still._in_true_colours()
    photo, drawn = still.figure.axes
    assert np.allclose(kept.extents, photo.bbox.extents) and not np.allclose(kept.extents, drawn.bbox.extents)


@pytest.mark.parametrize(("drawn", "expected"), [(("matrix",), True), ((), False)])
def test_a_drawn_array_and_its_legend_follow_a_dark_page(drawn, expected):
    panel = FunctionPanel("Signs", _signs, [Slider("size", "Size", 1, 9, 1, 3)], drawn=drawn)
    image = panel._row.places[0].image
    assert ("nao-drawn" in image._dom_classes) is expected
    assert ("nao-drawn-keys" in panel._legend._dom_classes) is expected


def _signs(values, student):
    yield {"matrix": np.full((values.size, values.size, 3), 255, np.uint8)}
    yield Legend({"positive": "#2c6e8f"})


def test_how_long_the_code_takes_is_said_and_a_title_that_comes_again_takes_the_place_of_the_first():
    panel = make(lambda *given: time.sleep(0.12) or brighter(*given))
    assert int(re.search(r"Your code took (\d+) ms", panel._status.value)[1]) >= 120
    assert "ms" not in repr(panel)
    assert "Your code" not in FunctionPanel("None", lambda values, student: "Yes.", [LEVEL])._status.value

    def later(values, student):
        yield {"A": np.zeros((4, 4), np.uint8), "B": NOISE}
        yield {"A": np.ones((4, 4), bool)}

    panel = FunctionPanel("Two", later, [LEVEL])
    assert list(panel.shown.pictures) == ["A", "B"]
    assert (decoded(image(panel, 0)) == 255).all()
