"""Pictures and labels: in their colours, their size and their units."""

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from nao_course.plotting import LABEL_COLOURS, draw_labels, draw_picture, draw_pictures, painted
from tests.plotting.examples import a_picture


def test_the_axes_of_a_picture_name_their_units():
    assert [ax.get_xlabel() for ax in a_picture().figure.axes] == ["u (px)"]


def test_labels_are_painted_in_their_colours():
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
