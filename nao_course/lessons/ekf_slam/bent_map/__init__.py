"""The map that bends, with which lesson 07 opens."""

from nao_course._internal.lazy_names import list_public
from nao_course.lessons.ekf_slam.bent_map.figures import (
    draw_bearings,
    draw_bent_map,
    draw_covariance_test,
    draw_second_error,
)

__all__ = ["draw_bearings", "draw_bent_map", "draw_covariance_test", "draw_second_error"]
__dir__ = list_public(__name__)
