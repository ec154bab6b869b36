"""The better corner detectors: what they find on a few pictures, what they make of strange ones, and their laws."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest

from benchmarks.challenges.corners import find_corners_better, find_corners_on_ground, middle_lines
from benchmarks.challenges.corners.carpet import take_apart
from benchmarks.challenges.corners.crossings import find_crossings, without_doubles
from benchmarks.challenges.corners.lines import LineSettings, merge
from benchmarks.challenges.corners.pieces import SAMPLES, Pieces, PieceSettings, line_pieces
from benchmarks.challenges.tilt import to_ground
from nao_course.geometry import Pose
from nao_course.metrics import CornerTruth, total
from nao_course.sim import NAO_V4, Field, Reality, render
from nao_course.sim.scenes import random_scene

SIZE = (320, 240)
VIEW = NAO_V4.view("bottom", 0.0, float(np.radians(-24.6)))
CARPET = (99, 152, 90)


def picture(reality=None, pose=None, view=VIEW):
    reality = reality or Reality.clean()
    return render(Field(), pose or Pose(0.9, 0.4, 0.5), view, reality, np.random.default_rng(0))


def plain(colour, size=SIZE):
    return np.full((size[1], size[0], 3), colour, dtype=np.uint8)


FINDERS = {
    "better": find_corners_better,
    "ground": lambda pixels: find_corners_on_ground(pixels, VIEW),
    "middles": lambda pixels: middle_lines(pixels, VIEW),
}


@pytest.fixture(scope="module")
def scenes():
    return [random_scene(SIZE, Reality.lab(40), np.random.default_rng([40, i])) for i in range(6)]


# --- what they find ---


def test_both_find_most_corners_of_a_laboratory_and_hardly_a_false_one(scenes):
    truths = [CornerTruth.of(scene.truth) for scene in scenes]
    assert sum(len(truth.corners) for truth in truths) >= 10
    for finder in (
        lambda s: find_corners_on_ground(s.pixels, s.view),
        lambda s: find_corners_better(s.pixels),
    ):
        found = total(truth.match(finder(scene)) for scene, truth in zip(scenes, truths, strict=True))
        assert found.recall >= 0.7
        assert found.false <= 1


def test_corners_on_the_ground_lie_within_a_pixel_or_two_of_the_true_ones():
    pixels, truth = picture()
    corners, away = CornerTruth.of(truth).corners, []
    for point in find_corners_on_ground(pixels, VIEW):
        away.append(np.hypot(*(corners - point).T).min())
    assert len(away) >= 3
    assert max(away) < 2.0


def test_middle_lines_lie_on_the_field_s_lines_to_a_fraction_of_a_pixel():
    pixels, truth = picture()
    field, pose = Field(), truth.pose
    lines = middle_lines(pixels, VIEW)
    steps = np.linspace(0.05, 0.95, 7)[:, None]
    straight = 0
    for u1, v1, u2, v2 in lines:
        points = (1 - steps) * (u1, v1) + steps * (u2, v2)
        robot = to_ground(points, VIEW) + np.array(VIEW.offset)  # the head looks straight ahead
        world = pose.to_parent(robot)
        beside = [
            np.abs(world[:, 0] - x1).max() if x1 == x2 else np.abs(world[:, 1] - y1).max()
            for x1, y1, x2, y2 in field.lines
        ]
        straight += min(beside) < 0.006
    assert straight >= 4
    assert straight >= len(lines) - 3  # the circle's chords


def test_a_larger_picture_gives_the_same_corners_larger():
    large = VIEW.at_size((640, 480))
    (small, _), (big, _) = picture(), picture(view=large)
    for few, many in (
        (find_corners_on_ground(small, VIEW), find_corners_on_ground(big, large)),
        (find_corners_better(small), find_corners_better(big)),
    ):
        scaled = (many + 0.5) / 2 - 0.5
        assert len(few) >= 3
        assert all(np.hypot(*(scaled - point).T).min() < 2.0 for point in few)


def test_the_lean_that_the_robot_does_not_know_is_taken_out():
    leant = NAO_V4.view("bottom", 0.0, float(np.radians(-24.6)), torso_pitch=0.03, torso_roll=0.015)
    pixels, truth = picture(view=leant)
    match = CornerTruth.of(truth).match(find_corners_on_ground(pixels, VIEW))
    assert match.hits >= 3
    assert match.false == 0


def test_paper_on_the_carpet_is_no_corner():
    # Two sheets, one upright in the picture and one aslant, with nothing else there.
    pixels = plain(CARPET)
    pixels[150:175, 100:150] = 240
    cv2.fillPoly(pixels, [np.array([(220, 120), (250, 125), (240, 140), (208, 134)])], (240, 240, 238))
    assert find_corners_on_ground(pixels, VIEW).shape == (0, 2)
    assert find_corners_better(pixels).shape == (0, 2)


def test_what_is_white_beyond_the_carpet_is_no_line():
    pixels = plain(CARPET)
    pixels[:110] = 240  # a bright wall, and the carpet's edge
    pixels[60:64, ::2] = 20
    for find in FINDERS.values():
        assert len(find(pixels)) == 0


# --- strange pictures ---

EMPTY = {
    "grey": plain((128, 128, 128)),
    "black": plain((0, 0, 0)),
    "white": plain((255, 255, 255)),
    "green": plain(CARPET),
    "noise": np.random.default_rng(0).integers(0, 256, (240, 320, 3), dtype=np.uint8),
}


@pytest.mark.parametrize("name", EMPTY)
@pytest.mark.parametrize("finder", FINDERS)
@pytest.mark.filterwarnings("error")
def test_a_picture_without_a_field_has_no_corner(name, finder):
    found = FINDERS[finder](EMPTY[name])
    assert found.shape[1] == (4 if finder == "middles" else 2)
    assert len(found) <= (3 if (name, finder) == ("noise", "middles") else 0)


@pytest.mark.parametrize("size", [(0, 0), (320, 0), (0, 240), (1, 1), (3, 2), (23, 320), (320, 23), (24, 24)])
@pytest.mark.filterwarnings("error")
def test_an_empty_or_tiny_picture_has_no_corner(size):
    assert find_corners_better(plain(CARPET, size)).shape == (0, 2)
    if min(size) > 0:
        assert find_corners_on_ground(plain(CARPET, size), VIEW.at_size(size)).shape == (0, 2)


@pytest.mark.parametrize(
    "pixels",
    [
        np.zeros((240, 320), dtype=np.uint8),
        np.zeros((240, 320, 3)),
        np.zeros((240, 320, 4), dtype=np.uint8),
        np.zeros((240, 320, 3), dtype=np.int64),
        None,
        "picture",
    ],
)
@pytest.mark.parametrize("finder", FINDERS)
def test_what_is_no_rgb_picture_of_bytes_is_refused(pixels, finder):
    with pytest.raises(ValueError, match="RGB, uint8"):
        FINDERS[finder](pixels)


def test_a_picture_of_another_size_than_the_view_s_is_refused():
    with pytest.raises(ValueError, match=r"view's size \(320, 240\), got \(64, 48\)"):
        find_corners_on_ground(plain(CARPET, (64, 48)), VIEW)


@pytest.mark.parametrize("pitch", [-1.5, -0.6, -0.1, 0.0, 0.1, 1.2, np.pi / 2])
@pytest.mark.filterwarnings("error")
def test_a_camera_that_looks_up_level_or_straight_down_finds_no_false_corner_and_does_not_fail(pitch):
    pixels, truth = picture(Reality.lab(40))
    wrong = replace(VIEW, pitch=float(pitch))
    assert find_corners_on_ground(pixels, wrong).shape[1] == 2
    assert np.isfinite(find_corners_on_ground(pixels, wrong)).all()
    seen, truth = picture(Reality.lab(40), view=wrong)
    assert CornerTruth.of(truth).match(find_corners_on_ground(seen, wrong)).false <= 1


def test_the_picture_that_is_given_stays_as_it_was():
    pixels, _ = picture(Reality.lab(40))
    before = pixels.tobytes()
    find_corners_better(pixels)
    find_corners_on_ground(pixels, VIEW)
    assert pixels.tobytes() == before


# --- the steps ---


def striped(width, contrast=80):
    """A carpet with one upright white line of a width (px)."""
    pixels = plain(CARPET)
    pixels[:, 160 : 160 + width] = np.minimum(np.array(CARPET) + contrast, 255)
    pixels[:, 160 : 160 + width] = pixels[:, 160 : 160 + width].min(axis=2, keepdims=True) + 60
    return take_apart(pixels)


@pytest.mark.parametrize("width", [3, 6, 9])
def test_a_piece_s_middle_and_width_are_those_of_the_line(width):
    pieces = line_pieces(striped(width), 0, lambda points, _: np.full(len(points), 12.0), PieceSettings())
    assert len(pieces) >= 1
    middle = pieces.middles[pieces.good]
    assert np.allclose(middle[:, 0], 160 + (width - 1) / 2, atol=0.25)
    assert np.allclose(pieces.width, width, atol=0.4)


def test_a_line_wider_than_lines_can_be_is_none():
    assert len(line_pieces(striped(9), 0, lambda points, _: np.full(len(points), 6.0), PieceSettings())) == 0


def pieces_along(*ends):
    """Pieces of a straight line, exact."""
    edges = np.array(ends, dtype=float).reshape(-1, 2, 2)
    t = np.linspace(0, 1, SAMPLES)[None, :, None]
    middles = edges[:, :1] + t * (edges[:, 1:] - edges[:, :1])
    n = len(edges)
    return Pieces(middles, np.ones((n, SAMPLES), dtype=bool), np.full(n, 3.0), edges)


def test_pieces_on_one_line_are_merged_and_others_are_not():
    pieces = pieces_along(
        (10, 10, 50, 18), (60, 20, 110, 30), (10, 30, 50, 38), (200, 48, 240, 56), (10, 10, 18, 50)
    )
    lines = merge(pieces, 1.0, LineSettings(), 0.0)
    # The first two are one; a gap of 90 px keeps another apart, though it is on the line.
    assert len(lines) == 4
    np.testing.assert_allclose(lines.ends[0], (10, 10, 110, 30), atol=1e-6)
    assert len(merge(pieces, 1.0, replace(LineSettings(), merged=False), 0.0)) == 5
    long_enough = merge(pieces, 1.0, LineSettings(), 45.0)
    np.testing.assert_array_equal(long_enough.ends, lines.ends[lines.length >= 45.0])
    assert 0 < len(long_enough) < len(lines)


def test_a_curve_bends_and_a_line_does_not():
    angle = np.linspace(0.0, 0.6, SAMPLES)
    arc = 60 * np.column_stack([np.cos(angle), np.sin(angle)]) + 100
    curve = Pieces(arc[None], np.ones((1, SAMPLES), dtype=bool), np.full(1, 3.0), arc[[0, -1]][None])
    assert merge(curve, 1.0, LineSettings(), 0.0).bend[0] == pytest.approx(60 * (1 - np.cos(0.3)), rel=0.1)
    assert merge(pieces_along((0, 0, 50, 10)), 1.0, LineSettings(), 0.0).bend[0] < 1e-9


def crossings(*ends, reach=2.0, arm=5.0):
    lines = np.array(ends, dtype=float)
    return find_crossings(
        lines,
        np.ones(len(lines)),
        lambda points: np.full(len(points), 0.5),
        lambda points: np.full(len(points), reach),
        lambda points: np.full(len(points), arm),
    )


@pytest.mark.parametrize(
    ("second", "found"),
    [
        ((10, 0, 10, 20), True),  # a T
        ((0, 0, 0, 20), True),  # an L
        ((0, 2, 0, 20), True),  # an L with a gap
        ((10, -20, 10, 20), False),  # an X
        ((10, 6, 10, 20), False),  # too far apart
        ((10, -2, 10, 2), False),  # too short an arm
        ((0, 1, 20, 1), False),  # parallel
    ],
)
def test_a_corner_is_where_two_lines_meet_with_arms(second, found):
    met = crossings((0, 0, 20, 0), second)
    assert len(met.points) == found
    if found:
        np.testing.assert_allclose(met.points[0], (second[0], 0), atol=1e-9)


def test_of_doubles_the_strongest_is_kept():
    points = np.array([(0.0, 0.0), (3.0, 0.0), (20.0, 0.0)])
    kept = without_doubles(points, np.array([1.0, 2.0, 1.0]), 5.0)
    assert sorted(kept.tolist()) == [[3.0, 0.0], [20.0, 0.0]]
    assert without_doubles(np.zeros((0, 2)), np.zeros(0), 5.0).shape == (0, 2)
