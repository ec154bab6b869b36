"""Filters that are built from a student's own three functions."""

from nao_course._internal.lazy_names import list_public
from nao_course.lessons.ekf_slam.filters.compressed import CompressedFilter
from nao_course.lessons.ekf_slam.filters.first_estimates import FirstEstimates

__all__ = ["CompressedFilter", "FirstEstimates"]
__dir__ = list_public(__name__)
