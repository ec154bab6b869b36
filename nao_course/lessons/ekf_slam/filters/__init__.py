"""Filters that are built from a student's own three functions."""

from nao_course.lessons.ekf_slam.filters.compressed import CompressedFilter
from nao_course.lessons.ekf_slam.filters.first_estimates import FirstEstimates

__all__ = ["CompressedFilter", "FirstEstimates"]


def __dir__() -> list[str]:
    """Return the public names, for tab completion."""
    return __all__
