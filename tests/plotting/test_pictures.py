"""Pictures and labels: in their colours, their size and their units."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from nao_course.plotting import LABEL_COLOURS, draw_labels, draw_picture, draw_pictures, painted
from nao_course.plotting.pictures import plot_picture
from nao_course.sim import Field, VisibleLandmark
from tests.plotting.examples import a_picture


@pytest.mark.parametrize("ticks", [True, False])
def test_a_pictures_first_row_is_on_top_and_its_first_column_on_the_left(ticks):
    ax = Figure().add_subplot()
    plot_picture(np.zeros((4, 6, 3), np.uint8), ax, ticks=ticks)
    assert ax.get_xlim() == (-0.5, 5.5) and ax.get_ylim() == (3.5, -0.5)
    assert [ax.get_xlabel() for ax in a_picture().figure.axes] == ["u (px)"]


def test_words_say_what_is_hidden_and_which_part_has_each_label_and_labels_are_painted_in_their_colours():
    landmark = Field().landmarks[0]
    seen = [VisibleLandmark(landmark, (10.0 * n, 20.0), 1.0, 0.0, occluded=n == 1) for n in (1, 2)]
    said = draw_picture(np.zeros((40, 40, 3), np.uint8), seen).alt
    assert f"hidden (10, 20), {landmark.kind} (20, 20)" in said
    said = draw_labels([[0, 1, 1, 3], [3, 3, 3, 3]]).alt
    assert "other 12.5%, green 25.0%, yellow 0.0%, white 62.5%" in said
    shown = painted([[0, 1], [2, 3]])
    assert shown.dtype == np.uint8 and shown.shape == (2, 2, 3)
    assert np.allclose(shown.reshape(4, 3) / 255, [to_rgb(each) for each in LABEL_COLOURS], atol=1 / 255)
    with pytest.raises(ValueError, match="labels must be"):
        painted([[4]])


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: draw_picture(np.zeros((4, 4, 4))), "shape"),
        (lambda: draw_picture(np.zeros((4, 4, 3))), "uint8"),
        (lambda: draw_picture(np.zeros((4, 4, 3), np.uint8), landmarks=[[1, 2, 3]]), "landmarks"),
        (lambda: draw_pictures([]), "at least one"),
        (lambda: draw_pictures([np.zeros((4, 4))], ["a", "b"]), "1 pictures need 1 titles"),
        (lambda: draw_pictures([np.zeros((4, 4))], columns=0), "columns"),
        (lambda: draw_labels(np.zeros((4, 4, 3))), "shape"),
        (lambda: draw_labels(np.full((4, 4), 7)), "0 other"),
    ],
)
def test_a_wrong_value_is_refused_in_words(call, said):
    with pytest.raises(ValueError, match=said):
        call()
