"""Figures, logs and filters of lesson 07, EKF SLAM."""

from nao_course.lessons.ekf_slam.ablations import ablate, ablation_table, draw_ablations, draw_turn_last
from nao_course.lessons.ekf_slam.bent_map import (
    draw_bearings,
    draw_bent_map,
    draw_covariance_test,
    draw_second_error,
)
from nao_course.lessons.ekf_slam.consistency import compare, draw_consistency
from nao_course.lessons.ekf_slam.costs import draw_costs
from nao_course.lessons.ekf_slam.evaluation import (
    distances_table,
    draw_gain,
    draw_nis,
    first_lines,
    mean_nis,
    personal_table,
    turn_factor,
)
from nao_course.lessons.ekf_slam.film import draw_film, record_film
from nao_course.lessons.ekf_slam.filters import CompressedFilter, FirstEstimates
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS, own_log
from nao_course.lessons.ekf_slam.noise import joint_noise
from nao_course.lessons.ekf_slam.panel import FilmPanel
from nao_course.lessons.ekf_slam.starts import draw_starts

__all__ = [
    "OWN_SIGMAS",
    "CompressedFilter",
    "FilmPanel",
    "FirstEstimates",
    "ablate",
    "ablation_table",
    "compare",
    "distances_table",
    "draw_ablations",
    "draw_bearings",
    "draw_bent_map",
    "draw_consistency",
    "draw_costs",
    "draw_covariance_test",
    "draw_film",
    "draw_gain",
    "draw_nis",
    "draw_second_error",
    "draw_starts",
    "draw_turn_last",
    "first_lines",
    "joint_noise",
    "mean_nis",
    "own_log",
    "personal_table",
    "record_film",
    "turn_factor",
]


def __dir__() -> list[str]:
    """Return the public names, for tab completion."""
    return __all__
