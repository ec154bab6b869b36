"""What lesson 07, EKF SLAM, alone uses."""

from nao_course.lessons.ekf_slam.evaluation import (
    distances_table,
    draw_gain,
    draw_nis,
    first_lines,
    landmarks_in_log,
    mean_nis,
)
from nao_course.lessons.ekf_slam.film import draw_film, record_film
from nao_course.lessons.ekf_slam.noise import joint_noise
from nao_course.lessons.ekf_slam.panel import FilmPanel
from nao_course.lessons.ekf_slam.starts import draw_starts, final_nees

__all__ = [
    "FilmPanel",
    "distances_table",
    "draw_film",
    "draw_gain",
    "draw_nis",
    "draw_starts",
    "final_nees",
    "first_lines",
    "joint_noise",
    "landmarks_in_log",
    "mean_nis",
    "record_film",
]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
