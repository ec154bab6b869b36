"""Drawings and tables: the same at every run, readable without eyes, saved in any format."""

import base64
import io
import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from nao_course.plotting import Drawing, draw_labels, draw_map, draw_picture, table
from nao_course.sim import Field
from tests.drawings import assert_same_bytes_with_words
from tests.plotting.examples import DRAWINGS, a_map


@pytest.mark.slow
@pytest.mark.parametrize("name", DRAWINGS)
def test_the_same_drawing_is_the_same_bytes_with_its_words(name):
    assert_same_bytes_with_words(DRAWINGS[name])


def test_a_drawing_says_what_it_shows_in_escaped_words_and_a_notebook_gets_a_smaller_picture_of_it():
    assert "&quot;map&quot; &amp; more" in a_map()._repr_html_()
    import matplotlib.pyplot as plt

    assert a_map()
    assert plt.get_fignums() == []
    drawing = draw_labels([[0, 1], [2, 3]])
    assert isinstance(drawing, Drawing)
    assert "green 25.0%" in repr(drawing)
    drawing = a_map()
    shown = base64.b64decode(re.search(r'base64,([^"]+)"', drawing._repr_html_())[1])
    small, large = (
        np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)
        for data in (shown, drawing.image())
    )
    assert len(shown) < 0.7 * len(drawing.image())
    assert np.abs(small - large).mean() < 0.5
    assert (small[0, 0] == 255).all()  # white stays white


@pytest.mark.parametrize("suffix", ["png", "jpeg", "jpg", "svg"])
def test_a_drawing_can_be_saved_and_another_kind_of_file_is_refused(tmp_path, suffix):
    assert draw_map(Field()).save(tmp_path / f"map.{suffix}").stat().st_size > 1000
    with pytest.raises(ValueError, match="png, svg, jpeg"):
        draw_map(Field()).save(tmp_path / "map.bmp")


def test_a_table_is_text_and_html_with_numbers_at_the_right():
    shown = table(["<b>", "n"], [["a & b", 1.5], ["c", None]])
    assert repr(shown) == "<b>    n\na & b  1.5\nc      None"
    page = shown._repr_html_()
    assert "<td" in page and "<b>" not in page and "a &amp; b" in page
    with pytest.raises(ValueError, match="row 2 has 1 values, but there are 2 columns"):
        table(["a", "b"], [[1, 2], [3]])
    rows = [["a", "23 of 98", "1.6e+03", "yes"], ["b", "-", "12 cm", "3"]]
    sides = re.findall(r"<td style=\"text-align: (\w+)", table(["", "of", "cm", "mixed"], rows)._repr_html_())
    assert sides == ["left", "right", "right", "left"] * 2


@pytest.mark.slow
def test_a_drawing_is_marked_for_dark_pages_and_a_photograph_in_it_is_left_out():
    assert '<img class="nao-figure"' in a_map()._repr_html_()
    picture = np.full((40, 80, 3), (255, 0, 0), np.uint8)
    drawing = draw_picture(picture, title="red")
    shown = drawing._repr_html_()
    assert not list(a_map()._in_true_colours())
    assert len(list(draw_labels([[0, 1], [2, 3]])._in_true_colours())) == 1 + 4  # the picture and its keys
    assert "nao-figure" not in shown
    numbers = re.findall(r"([\d.]+)%", shown.split("evenodd")[1])
    corners = np.reshape([float(each) for each in numbers], (-1, 2))
    (left, top), (right, bottom) = corners[5:-1].min(axis=0), corners[5:-1].max(axis=0)
    pixels = np.asarray(Image.open(io.BytesIO(drawing.image()))).astype(int)
    height, width = pixels.shape[:2]
    rows, columns = np.nonzero((pixels[..., 0] > 200) & (pixels[..., 1] < 60))
    found = columns.min() / width, (columns.max() + 1) / width, rows.min() / height, (rows.max() + 1) / height
    np.testing.assert_allclose(np.array([left, right, top, bottom]) / 100, found, atol=0.006)


@pytest.mark.parametrize("inches", [4.0, 14.4])
def test_letters_of_9_points_are_9_px_high_in_a_drawing_that_a_narrow_column_makes_smaller(inches):
    shown = Drawing(Figure(figsize=(inches, 2)), "a figure")._repr_html_()
    (least,) = map(float, re.findall(r"--nao-wider: (\d+)px", shown))
    assert 9.0 <= 9 * 100 / 72 * least / (100 * inches) < 9.1
