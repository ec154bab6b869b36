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


def plain(colour, size=SIZE):
    return np.full((size[1], size[0], 3), colour, dtype=np.uint8)


@pytest.fixture(scope="module")
def scenes():
    return [random_scene(SIZE, Reality.lab(40), np.random.default_rng([40, i])) for i in range(6)]


def test_it_finds_most_corners_of_a_laboratory_and_hardly_a_false_one_and_their_tilt():
    scenes = [random_scene(SIZE, Reality.lab(40), np.random.default_rng([40, i])) for i in range(6)]
    truths = [CornerTruth.of(scene.truth) for scene in scenes]
    assert sum(len(truth.corners) for truth in truths) >= 10
    found = total(t.match(find_corners_better(s.pixels)) for s, t in zip(scenes, truths, strict=True))
    assert found.recall >= 0.7 and found.false <= 1
    tilt = summary(of_scenes(scenes))
    assert tilt["pitch rms after"] < tilt["pitch rms before"] and tilt["within 2 sigma"] >= 0.8


def test_a_larger_picture_gives_the_same_corners_larger():
    pixels, larger = (
        render(Field(), Pose(0.9, 0.4, 0.5), view, Reality.clean(), np.random.default_rng(0))[0]
        for view in (VIEW, VIEW.at_size((640, 480)))
    )
    before = pixels.tobytes()
    few, many = find_corners_better(pixels), find_corners_better(larger)
    assert pixels.tobytes() == before and len(few) >= 3
    scaled = (many + 0.5) / 2 - 0.5
    assert all(np.hypot(*(scaled - point).T).min() < 2.0 for point in few)


def test_paper_on_the_carpet_and_white_things_beyond_it_are_no_corners():
    paper, beyond = plain(CARPET), plain(CARPET)
    paper[150:175, 100:150] = beyond[:110] = 240
    cv2.fillPoly(paper, [np.array([(220, 120), (250, 125), (240, 140), (208, 134)])], (240, 240, 238))
    beyond[60:64, ::2] = 20
    assert find_corners_better(paper).shape == find_corners_better(beyond).shape == (0, 2)


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
