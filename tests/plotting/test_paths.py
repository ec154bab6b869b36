"""Paths: they come in any shape, with headings or without."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from nao_course.geometry import Pose
from nao_course.plotting import as_path, draw_map, plot_pose
from nao_course.sim import Field


@pytest.mark.parametrize(
    "poses", [Pose(1, 2, 0.3), [Pose(1, 2, 0.3)], [[1, 2, 0.3]], np.array([[1, 2, 0.3]])]
)
def test_a_path_comes_in_any_shape(poses):
    assert np.allclose(as_path(poses), [[1, 2, 0.3]])


def test_a_path_without_headings_draws_no_robot():
    assert np.isnan(as_path([[1, 2], [3, 4]])[:, 2]).all()
    assert "heading" not in draw_map(Field(), truth=[[1, 2], [3, 4]]).alt


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: plot_pose(Pose(), Figure().add_subplot(), "gps"), "'gps'"),
    ],
)
def test_a_wrong_value_is_refused_in_words(call, said):
    with pytest.raises(ValueError, match=said):
        call()
