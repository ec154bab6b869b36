"""The statistics that compare simulated with real pictures measure a known noise and colour correctly."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from benchmarks.simulator import realism
from benchmarks.simulator.real_scenes import Geometry, real_scenes
from benchmarks.simulator.realism import measure
from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, Field

FIELD = Field(2012, half=False)
VIEW = replace(NAO_V4.view("bottom", 0.0, -0.45), roll=0.0, k1=-0.08)
CARPET = (84, 144, 86)


def plain(colour=CARPET, size=(320, 240)):
    """One colour everywhere, with the geometry of a view over empty carpet."""
    pixels = np.full((size[1], size[0], 3), colour, dtype=float)
    return pixels, Geometry(VIEW.at_size(size), Pose(1.2, 0.9, 0.2), FIELD)


def as_picture(values: np.ndarray) -> np.ndarray:
    """Round to a camera's whole numbers."""
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


def test_white_noise_is_read_as_what_it_is_without_a_slope_or_what_is_outside_the_mask():
    pixels, _ = plain()
    for sd in (1.5, 3.3, 8.0):
        light = as_picture(pixels[..., 0] + np.random.default_rng(2).normal(0, sd, pixels.shape[:2])).astype(
            float
        )
        found = realism.noise_sd(light, np.ones(light.shape, dtype=bool))
        assert found == pytest.approx(np.hypot(sd, 0.29), rel=0.08)
    rng = np.random.default_rng(3)
    v, u = np.mgrid[:240, :320]
    slope = 0.3 * u + 0.2 * v + rng.normal(0, 2.0, u.shape)
    slope[:, 170:] += rng.normal(0, 40.0, (240, 150))
    assert realism.noise_sd(slope, u < 160) == pytest.approx(2.0, rel=0.05)


def test_colours_are_read_back_and_objects_on_the_carpet_are_left_out():
    pixels, geometry = plain((60, 150, 90))
    found = measure(as_picture(pixels), geometry)
    hue, lightness, _ = cv2.cvtColor(np.uint8([[[60, 150, 90]]]), cv2.COLOR_RGB2HLS)[0, 0]
    assert [found[f"carpet, hue {q} %"] for q in (1, 50, 99)] == [hue] * 3
    assert found["carpet, lightness 50 %"] == lightness
    assert found["picture's mean lightness"] == pytest.approx(lightness)
    pixels, geometry = plain()
    pixels[150:200, 100:160] = (200, 30, 40)
    found = measure(as_picture(pixels), geometry)
    assert found["carpet, lightness 95 %"] == found["carpet, lightness 5 %"]


def test_the_ground_under_a_pixel_projects_back_to_it():
    geometry = Geometry(VIEW, Pose(0.4, -0.7, 2.0), FIELD)
    for v, u in ((120, 20), (200, 160), (239, 319)):
        assert VIEW.project(geometry.ground[v, u][None], geometry.pose)[0] == pytest.approx((u, v), abs=1e-6)


@pytest.mark.slow
def test_real_pictures_give_the_known_numbers(data_dir, monkeypatch):
    monkeypatch.setenv("NAO_COURSE_DATA", str(data_dir))
    scenes = real_scenes()
    assert len(scenes) == 94
    found = realism.summarise(measure(s.picture.pixels, s.geometry()) for s in scenes[::7])
    assert found["carpet, hue 50 %"] == pytest.approx(61, abs=2)
    assert found["picture's mean lightness"] == pytest.approx(117, abs=4)
