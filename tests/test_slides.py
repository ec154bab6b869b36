"""Slides: which figures of a lesson they show, in which format, and where their headings come from."""

import io
from pathlib import Path

import nbformat
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from images.slides import MOST, PIXELS, as_slide, headings_of, slides_of, spread
from nao_course.instructor.authoring.course import load_course
from nao_course.plotting import Drawing, draw_map
from nao_course.sim import Field
from tests.paths import PROJECT


@pytest.mark.parametrize("number", [0, 1, 6, 7, 23])
def test_a_lesson_has_at_most_six_slides_from_its_first_figure_to_its_last(number):
    paths = [Path(str(i)) for i in range(number)]
    chosen = spread(paths)
    assert len(chosen) == min(number, MOST) == len(set(chosen))
    assert chosen == sorted(chosen, key=paths.index)
    assert number == 0 or (chosen[0], chosen[-1]) == (paths[0], paths[-1])


def test_each_code_cell_has_the_last_heading_above_it():
    md, code = nbformat.v4.new_markdown_cell, nbformat.v4.new_code_cell
    cells = [
        code("0"),
        md("# One\n\ntext\n\n## Two"),
        code("1"),
        md("text"),
        code("2"),
        md("### Three"),
        code("3"),
    ]
    assert headings_of(nbformat.v4.new_notebook(cells=cells)) == ["", "Two", "Two", "Three"]


@pytest.mark.parametrize("size", [(6.4, 6.9), (13.0, 3.0), (4.0, 9.0)])
def test_a_slide_has_the_format_of_a_screen_and_holds_the_whole_figure_in_larger_type(size):
    figure = Figure(figsize=size, layout="constrained")
    ax = figure.add_subplot()
    ax.set_title("a title that is wider than the axes below it", loc="left")
    with Image.open(io.BytesIO(as_slide(Drawing(figure, "")))) as slide:
        assert slide.size == PIXELS
        dark = np.argwhere(np.asarray(slide.convert("L")) < 128)
    assert dark[:, 1].max() < PIXELS[0] - 1, "the title is cut off"
    drawing = draw_map(Field())
    before = drawing.figure.get_size_inches()
    as_slide(drawing)
    # The points of its letters are as before, so they fill more of a page with fewer inches.
    assert (drawing.figure.get_size_inches()[1] < 0.85 * before[1]).all()


@pytest.mark.slow
def test_a_lessons_slides_have_captions():
    files = slides_of(load_course(PROJECT), "05_ekf_derivations")
    (captions,) = (content.decode() for path, content in files.items() if path.suffix == ".md")
    assert captions.startswith("# EKF derivations\n")
    pictures = [path.name for path in files if path.suffix == ".png"]
    assert 3 <= len(pictures) <= MOST
    assert all(f"]({name})" in captions for name in pictures)
