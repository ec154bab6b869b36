"""Paths: they come in any shape, with headings or without."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from nao_course.geometry import Pose
from nao_course.plotting import as_path, draw_map, plot_path, plot_pose
from nao_course.sim import Field


def test_a_path_comes_in_any_shape_and_a_robots_line_points_where_it_is_heading():
    for poses in (Pose(1, 2, 0.3), [Pose(1, 2, 0.3)], [[1, 2, 0.3]], np.array([[1, 2, 0.3]])):
        assert np.allclose(as_path(poses), [[1, 2, 0.3]])
    assert np.isnan(as_path([[1, 2], [3, 4]])[:, 2]).all()
    assert "heading" not in draw_map(Field(), truth=[[1, 2], [3, 4]]).alt
    ax = Figure().add_subplot()
    plot_pose(Pose(1.0, 2.0, 0.7), ax)
    start, tip = np.transpose(ax.lines[0].get_data())
    assert np.allclose(start, (1.0, 2.0))
    assert np.arctan2(*(tip - start)[::-1]) == pytest.approx(0.7)
    with pytest.raises(ValueError, match="'gps'"):
        plot_pose(Pose(), ax, "gps")


@pytest.mark.parametrize(("poses", "fewest", "most"), [(5, 5, 5), (60, 12, 13), (1000, 12, 13)])
def test_a_path_has_a_marker_for_each_pose_or_about_twelve_along_all_of_it(poses, fewest, most):
    ax = Figure().add_subplot()
    way = np.column_stack([np.arange(poses), np.zeros(poses)])
    plot_path(way, ax)
    line, markers = ax.lines
    assert line.get_xdata().tolist() == way[:, 0].tolist()
    assert fewest <= len(markers.get_xdata()) <= most
    assert markers.get_xdata()[0] == 0 and markers.get_xdata()[-1] >= 0.9 * (poses - 1)
