"""Pages are escaped by construction, whole or not there, and can be read by everyone."""

import re

import pytest

from nao_course.instructor.reports import html
from nao_course.instructor.reports.html import element, join, number, write_whole
from tests.pages import HOSTILE, Page


def luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in parts]
    return sum(weight * each for weight, each in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


def contrast(one, other):
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("mode", [0, 1], ids=["light", "dark"])
def test_every_text_can_be_read_on_what_it_stands_on(mode):
    start = [match.start() for match in re.finditer("--paper:", html.STYLE)][mode]
    colours = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6})", html.STYLE[start:].partition("}")[0]))
    papers = ["paper", "card", "code", *(f"{each}-paper" for each in ("good", "warn", "bad", "calm"))]
    pairs = [("ink", on) for on in papers]
    pairs += [(text, on) for text in ("soft", "good", "warn", "bad", "calm") for on in ("paper", "card")]
    assert {pair: contrast(*(colours[each] for each in pair)) for pair in pairs if weak(colours, pair)} == {}
    assert contrast(colours["good"], colours["track"]) >= 3, "the bar"
    assert contrast("#ffffff", "#000000") == pytest.approx(21)
    assert contrast("#777777", "#ffffff") == pytest.approx(4.48, abs=0.01)


def weak(colours, pair):
    return contrast(*(colours[each] for each in pair)) < 4.5


@pytest.mark.parametrize("text", HOSTILE)
def test_what_is_no_markup_is_escaped_wherever_it_stands_and_markup_stays(text):
    made = Page(element("p", text, element("code", text), title=text))
    assert made.tags == ["p", "code"] and set(dict(made.elements)["p"]) == {"title"}
    assert join(element("p", "a"), "<", None) == "<p>a</p>&lt;"


def test_points_are_written_as_short_as_they_are():
    assert list(map(number, (2, 1.5, 1 / 3, -0.001, 100))) == ["2", "1.5", "0.33", "0", "100"]


def test_a_file_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    path = write_whole(tmp_path / "new" / "page.html", "old")
    monkeypatch.setattr(html.os, "replace", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write_whole(path, "new")
    assert path.read_text() == "old" and list(path.parent.iterdir()) == [path]
