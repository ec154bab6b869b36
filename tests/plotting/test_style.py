"""Styles: told apart by every kind of reader, and independent of the reader's own settings."""

import cv2
import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb

from nao_course.plotting import STYLES
from nao_course.plotting.style import DARK_CARPET, contrast, on_dark
from tests.plotting.examples import a_map

# Machado, Oliveira and Fernandes 2009: what readers without one kind of cone see, linear RGB.
CONES = {
    "all": np.eye(3),
    "no red": [[0.1523, 1.0526, -0.2049], [0.1145, 0.7863, 0.0992], [-0.0039, -0.0481, 1.0520]],
    "no green": [[0.3673, 0.8606, -0.2280], [0.2801, 0.6725, 0.0474], [-0.0118, 0.0429, 0.9689]],
    "no blue": [[1.2555, -0.0767, -0.1788], [-0.0784, 0.9308, 0.1476], [0.0047, 0.6914, 0.3039]],
}


def test_every_source_has_its_own_colour_marker_and_line_and_a_readers_own_settings_change_nothing():
    for name in ("colour", "marker", "line"):
        assert len({str(getattr(style, name)) for style in STYLES.values()}) == len(STYLES)
    assert contrast("#000000", "#ffffff") == pytest.approx(21)
    just_too_little = 4.478  # WCAG 2.1 requires 4.5 for text
    assert contrast("#777777", "#ffffff") == pytest.approx(just_too_little, abs=1e-3)
    expected = a_map().image()
    with matplotlib.rc_context({"font.size": 30, "axes.facecolor": "red", "savefig.dpi": 30}):
        assert a_map().image() == expected


@pytest.mark.parametrize("page", ["light", "dark"])
@pytest.mark.parametrize("eyes", CONES)
def test_the_colours_stay_apart_for_every_kind_of_vision(eyes, page):
    def seen(colour):
        linear = np.array(CONES[eyes]) @ (np.array(to_rgb(colour)) ** 2.2)
        rgb = np.clip(linear, 0, 1) ** (1 / 2.2)
        return cv2.cvtColor(rgb.astype(np.float32)[None, None], cv2.COLOR_RGB2LAB)[0, 0]

    own = [style.colour for style in STYLES.values()]
    colours = [seen(on_dark(colour) if page == "dark" else colour) for colour in own]
    apart = [np.linalg.norm(a - b) for i, a in enumerate(colours) for b in colours[:i]]
    assert min(apart) > 25  # CIELAB; 2.3 is a just noticeable difference


@pytest.mark.parametrize(
    "colour", [style.colour for style in STYLES.values()] + ["#c2409c", "#2e8540", "#7a35d0"]
)
def test_a_colour_for_dark_pages_is_legible_there(colour):
    assert contrast(on_dark(colour), DARK_CARPET) >= 5 > contrast(colour, DARK_CARPET)
