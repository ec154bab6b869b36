"""The instruments that compare simulated with real pictures read a known noise, edge, width and colour correctly."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy import ndimage

from benchmarks.pictures import paper_detector as paper
from benchmarks.simulator import realism
from benchmarks.simulator.real_scenes import Geometry, Picture, line_profiles, real_scenes
from benchmarks.simulator.realism import measure
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, CameraView, Field, Reality, render

FIELD = Field(2012, half=False)
VIEW = replace(NAO_V4.view("bottom", 0.0, -0.45), roll=0.0, k1=-0.08)
AT_CENTRE_LINE = Pose(0.0, 0.9, np.pi / 2)  # the halfway line runs ahead: a near, wide line
CARPET = (84, 144, 86)


def painted(
    pose: Pose,
    blur: float = 0.0,
    line: float = 235.0,
    size: tuple[int, int] = (320, 240),
    width: float = 0.05,
) -> tuple[np.ndarray, Geometry]:
    """Paint the field's lines, grey in gamma values, by brute force in samples, then blur by a Gaussian (px)."""
    view = VIEW.at_size(size)
    n = 5 if size[0] < 1000 else 2
    fine = Geometry(view.at_size((size[0] * n, size[1] * n)), pose, FIELD)
    x, y = fine.ground[..., 0], fine.ground[..., 1]
    white = np.zeros(x.shape, dtype=bool)
    for x0, y0, x1, y1 in FIELD.lines:
        white |= (np.maximum(np.maximum(x0 - x, x - x1), np.maximum(y0 - y, y - y1))) < width / 2
    for cx, cy, radius, *_ in FIELD.arcs:
        white |= np.abs(np.hypot(x - cx, y - cy) - radius) < width / 2
    area = white.reshape(size[1], n, size[0], n).mean(axis=(1, 3))
    if blur:
        area = ndimage.gaussian_filter(area, blur)
    pixels = np.array(CARPET) + area[..., None] * (np.array([line] * 3) - CARPET)
    return np.rint(pixels).astype(np.uint8), Geometry(view, pose, FIELD)


def plain(
    colour: tuple[int, int, int] = CARPET, size: tuple[int, int] = (320, 240)
) -> tuple[np.ndarray, Geometry]:
    """One colour everywhere, with the geometry of a view over empty carpet."""
    pixels = np.full((size[1], size[0], 3), colour, dtype=float)
    return pixels, Geometry(VIEW.at_size(size), Pose(1.2, 0.9, 0.2), FIELD)


def as_picture(values: np.ndarray) -> np.ndarray:
    """Round to a camera's whole numbers."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


# --- noise ---


@pytest.mark.parametrize("sd", [1.5, 3.3, 8.0])
def test_white_noise_is_read_as_what_it_is(sd: float) -> None:
    pixels, _ = plain()
    noise = np.random.default_rng(2).normal(0, sd, pixels.shape[:2])[..., None]
    light = Picture(as_picture(np.repeat(pixels[..., :1] + noise, 3, 2))).lightness
    assert realism.noise_sd(light, np.ones(light.shape, dtype=bool)) == pytest.approx(
        np.hypot(sd, 0.29), rel=0.08
    )


def test_noise_sees_neither_a_slope_nor_what_is_outside_the_mask() -> None:
    rng = np.random.default_rng(3)
    v, u = np.mgrid[:240, :320]
    slope = 0.3 * u + 0.2 * v + rng.normal(0, 2.0, u.shape)
    mask = u < 160
    slope[:, 170:] += rng.normal(0, 40.0, (240, 150))
    assert realism.noise_sd(slope, mask) == pytest.approx(2.0, rel=0.05)


# --- edges and widths ---


@pytest.mark.parametrize(
    ("sigma", "width"), [(0.6, 320), (0.8, 320), (1.1, 320), pytest.param(1.2, 1280, marks=pytest.mark.slow)]
)
def test_a_gaussian_edge_rises_as_the_formula_says(sigma: float, width: int) -> None:
    size = (width, width * 3 // 4)
    pixels, geometry = painted(AT_CENTRE_LINE, sigma, size=size)
    # 10 to 90 % of a Gaussian is 2.563 sigma; a pixel's own width adds a variance of 1 / 12.
    expected = 2.563 * np.sqrt(sigma**2 + 1 / 12)
    found = realism.line_edges(Picture(pixels), geometry)
    assert found["rise px"] == pytest.approx(expected, rel=0.06)


def test_noise_does_not_widen_a_measured_edge() -> None:
    pixels, geometry = painted(AT_CENTRE_LINE, 0.8)
    noisy = as_picture(pixels + np.random.default_rng(5).normal(0, 3.3, pixels.shape))
    clean, found = (realism.line_edges(Picture(p), geometry)["rise px"] for p in (pixels, noisy))
    assert found == pytest.approx(clean, rel=0.05)


def test_a_far_lines_width_is_that_of_the_blur_and_its_peak_what_it_covers() -> None:
    sigma = 1.0
    pixels, geometry = painted(Pose(-1.0, 0.6, 0.0), sigma)
    found = realism.lines_by_distance(Picture(pixels), geometry)
    lines = geometry.lines.chosen(geometry.lines.clear & geometry.lines.across)
    true = 2 * np.median(lines.half_width[(lines.distance >= 3) & (lines.distance < 4)])
    assert true < 1.2
    expected = 2.355 * np.sqrt(sigma**2 + 1 / 12 + true**2 / 12)
    assert np.median(found["width px, 3-4 m"]) == pytest.approx(expected, rel=0.06)
    peak = 114 + (235 - 114) * true / (expected / 2.355 * np.sqrt(2 * np.pi))
    assert np.median(found["peak, 3-4 m"]) == pytest.approx(peak, rel=0.04)


# --- colour and light ---


def test_the_carpets_colour_is_read_back() -> None:
    pixels, geometry = plain((60, 150, 90))
    found = measure(as_picture(pixels), geometry)
    hue, lightness, _ = cv2.cvtColor(np.uint8([[[60, 150, 90]]]), cv2.COLOR_RGB2HLS)[0, 0]
    assert [found[f"hue {q} %"].item() for q in (1, 50, 99)] == [hue] * 3
    assert found["lightness 50 %"] == lightness
    assert found["picture's mean lightness"] == pytest.approx(lightness)


def test_dark_sides_are_read_as_a_fraction_of_the_centre() -> None:
    pixels, geometry = plain()
    across = np.abs(np.linspace(-1, 1, 320))
    found = measure(as_picture(pixels * (1 - 0.2 * (across > 0.5))[None, :, None]), geometry)
    assert found["sides / centre"] == pytest.approx(0.8, abs=0.02)


def test_objects_on_the_carpet_are_left_out() -> None:
    pixels, geometry = plain()
    pixels[150:200, 100:160] = (200, 30, 40)
    found = measure(as_picture(pixels), geometry)
    assert found["lightness 95 %"] == found["lightness 5 %"]


# --- geometry ---


def test_lines_lie_where_the_renderer_paints_them() -> None:
    pose = Pose(-0.6, 0.3, 0.4)
    pixels, _ = render(FIELD, pose, VIEW, Reality.clean())
    geometry = Geometry(VIEW, pose, FIELD)
    lines = geometry.lines.chosen(geometry.lines.clear & (geometry.lines.half_width > 1.5))
    profiles = line_profiles(Picture(pixels), lines, 1.0, search=2.5)
    assert profiles.good.mean() > 0.9
    assert np.abs(profiles.centre[profiles.good]).max() < 0.2


def test_the_ground_under_a_pixel_projects_back_to_it() -> None:
    geometry = Geometry(VIEW, Pose(0.4, -0.7, 2.0), FIELD)
    for v, u in ((120, 20), (200, 160), (239, 319)):
        assert VIEW.project(geometry.ground[v, u][None], geometry.pose)[0] == pytest.approx((u, v), abs=1e-6)


# --- the paper's detector ---


def test_a_perfect_corner_is_found() -> None:
    pixels = np.full((240, 320, 3), (60, 150, 90), np.uint8)
    pixels[100:105, 60:250] = pixels[100:220, 60:65] = 255
    (corner,) = paper.find_corners(pixels)
    assert np.hypot(*(corner - (62.0, 102.0))) < 8


def test_erasing_stops_at_the_first_seven_green_in_a_column() -> None:
    labels = np.full((20, 2), paper.WHITE, np.uint8)
    labels[5:11, 0] = paper.GREEN  # six are too few
    labels[5:12, 1] = paper.GREEN
    kept = paper.erase_background(labels)
    assert not kept[:, 0].any()
    assert not kept[:5, 1].any()
    assert (kept[5:, 1] == labels[5:, 1]).all()


# --- real numbers ---


@pytest.mark.slow
def test_real_pictures_are_aligned_with_their_lines_and_give_the_known_numbers(data_dir, monkeypatch) -> None:
    monkeypatch.setenv("NAO_COURSE_DATA", str(data_dir))
    scenes = real_scenes()
    assert len(scenes) == 94
    found = realism.summarise(measure(s.picture.pixels, s.geometry()) for s in scenes[::7])
    assert found["hue 50 %"] == pytest.approx(61, abs=2)
    assert found["picture's mean lightness"] == pytest.approx(117, abs=4)
    assert found["rise px"] == pytest.approx(1.3, abs=0.15)
    assert found["peak, 1-1.5 m"] == 255
    assert found["above threshold %, 2-3 m"] > 97


def test_a_view_of_another_size_measures_in_its_own_pixels() -> None:
    small, large = (
        Geometry(CameraView(s, 1.06, 0.83, 0.48, 0.25), Pose(), FIELD) for s in ((320, 240), (1280, 960))
    )
    assert large.scale == 4 * small.scale
    assert large.carpet.sum() == pytest.approx(16 * small.carpet.sum(), rel=0.03)
