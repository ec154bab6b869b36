"""The better corner detector: what it finds, what it makes of strange pictures, and its steps."""

import cv2
import numpy as np
import pytest

from benchmarks.challenges.corner_detector import find_corners_better, line_pieces, straight_lines, take_apart
from benchmarks.pictures.tilt import of_scenes, summary
from nao_course.geometry import Pose
from nao_course.metrics import CornerTruth, total
from nao_course.sim import NAO_V4, Field, Reality, render
from nao_course.sim.scenes import random_scene

SIZE = (320, 240)
VIEW = NAO_V4.view("bottom", 0.0, float(np.radians(-24.6)))
CARPET = (99, 152, 90)


def picture(reality=None, view=VIEW):
    reality = reality or Reality.clean()
    return render(Field(), Pose(0.9, 0.4, 0.5), view, reality, np.random.default_rng(0))[0]


def plain(colour, size=SIZE):
    return np.full((size[1], size[0], 3), colour, dtype=np.uint8)


@pytest.fixture(scope="module")
def scenes():
    return [random_scene(SIZE, Reality.lab(40), np.random.default_rng([40, i])) for i in range(6)]


def test_it_finds_most_corners_of_a_laboratory_and_hardly_a_false_one(scenes):
    truths = [CornerTruth.of(scene.truth) for scene in scenes]
    assert sum(len(truth.corners) for truth in truths) >= 10
    found = total(t.match(find_corners_better(s.pixels)) for s, t in zip(scenes, truths, strict=True))
    assert found.recall >= 0.7 and found.false <= 1


def test_a_larger_picture_gives_the_same_corners_larger():
    pixels = picture()
    before = pixels.tobytes()
    few, many = find_corners_better(pixels), find_corners_better(picture(view=VIEW.at_size((640, 480))))
    assert pixels.tobytes() == before
    scaled = (many + 0.5) / 2 - 0.5
    assert len(few) >= 3
    assert all(np.hypot(*(scaled - point).T).min() < 2.0 for point in few)


def test_paper_on_the_carpet_and_white_things_beyond_it_are_no_corners():
    pixels = plain(CARPET)
    pixels[150:175, 100:150] = 240
    cv2.fillPoly(pixels, [np.array([(220, 120), (250, 125), (240, 140), (208, 134)])], (240, 240, 238))
    assert find_corners_better(pixels).shape == (0, 2)
    pixels = plain(CARPET)
    pixels[:110] = 240
    pixels[60:64, ::2] = 20
    assert find_corners_better(pixels).shape == (0, 2)


@pytest.mark.parametrize("size", [SIZE, (0, 0), (320, 0), (1, 1), (3, 2), (23, 320), (320, 23), (24, 24)])
@pytest.mark.filterwarnings("error")
def test_a_picture_without_a_field_or_without_room_for_one_has_no_corner(size):
    noise = np.random.default_rng(0).integers(0, 256, (size[1], size[0], 3), dtype=np.uint8)
    for pixels in (plain((128, 128, 128), size), plain(CARPET, size), plain((255, 255, 255), size), noise):
        assert find_corners_better(pixels).shape == (0, 2)


@pytest.mark.parametrize("width", [3, 6, 9])
def test_a_line_of_any_width_is_one_line_along_its_middle(width):
    pixels = plain(CARPET)
    pixels[:, 160 : 160 + width] = 213
    planes = take_apart(pixels)
    ends, widths = straight_lines(line_pieces(planes), planes.scale)
    assert np.allclose(ends[:, [0, 2]], 160 + (width - 1) / 2, atol=0.25)
    assert len(ends) == 1
    assert np.allclose(widths, width, atol=0.4)


def test_pictures_of_a_laboratory_tell_their_tilt(scenes):
    found = summary(of_scenes(scenes))
    assert found["pitch rms after"] < found["pitch rms before"]
    assert found["within 2 sigma"] >= 0.8
