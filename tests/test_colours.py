"""The colours that several lessons see with."""

import numpy as np

from nao_course.colours import mean_lightness


def test_the_mean_lightness_is_that_of_every_pixel_to_the_last_digit():
    picture = np.random.default_rng(3).integers(0, 256, (48, 64, 3), dtype=np.uint8)
    lightness = picture.max(axis=2) / 2 + picture.min(axis=2) / 2
    assert mean_lightness(picture) == lightness.mean()
    assert mean_lightness(np.ascontiguousarray(picture[:, ::-1])) == lightness.mean()
