"""Drawings and tables: the same at every run, readable without eyes, saved in any format."""

import base64
import io
import re

import numpy as np
import pytest
from PIL import Image

from nao_course.plotting import Drawing, draw_labels, draw_map, table
from nao_course.sim import Field
from tests.drawings import assert_same_bytes_with_words
from tests.plotting.examples import DRAWINGS, a_map


@pytest.mark.parametrize("name", DRAWINGS)
def test_the_same_drawing_is_the_same_bytes_with_its_words(name):
    assert_same_bytes_with_words(DRAWINGS[name])


def test_words_are_escaped_in_html():
    assert "&quot;map&quot; &amp; more" in a_map()._repr_html_()


def test_nothing_stays_behind_in_pyplot():
    import matplotlib.pyplot as plt

    assert a_map()
    assert plt.get_fignums() == []


@pytest.mark.parametrize("suffix", ["png", "jpeg", "jpg", "svg"])
def test_a_drawing_can_be_saved(tmp_path, suffix):
    path = draw_map(Field()).save(tmp_path / f"map.{suffix}")
    assert path.stat().st_size > 1000


def test_another_kind_of_file_is_refused(tmp_path):
    with pytest.raises(ValueError, match="png, svg, jpeg"):
        draw_map(Field()).save(tmp_path / "map.bmp")


def test_a_drawing_says_what_it_shows():
    drawing = draw_labels([[0, 1], [2, 3]])
    assert isinstance(drawing, Drawing)
    assert "green 25.0%" in repr(drawing)


def test_a_table_is_text_and_html_with_nothing_unescaped():
    shown = table(["<b>", "n"], [["a & b", 1.5], ["c", None]])
    assert repr(shown) == "<b>    n\na & b  1.5\nc      None"
    assert (
        "<td" in shown._repr_html_()
        and "<b>" not in shown._repr_html_()
        and "a &amp; b" in shown._repr_html_()
    )
    with pytest.raises(ValueError, match="row 2 has 1 values, but there are 2 columns"):
        table(["a", "b"], [[1, 2], [3]])


def test_a_notebook_gets_a_smaller_picture_that_looks_the_same():
    drawing = a_map()
    shown = base64.b64decode(re.search(r'base64,([^"]+)"', drawing._repr_html_())[1])
    small, large = (
        np.asarray(Image.open(io.BytesIO(data)).convert("RGB")).astype(int)
        for data in (shown, drawing.image())
    )
    assert len(shown) < 0.7 * len(drawing.image())
    assert np.abs(small - large).mean() < 0.5
    assert (small[0, 0] == 255).all()  # white stays white
