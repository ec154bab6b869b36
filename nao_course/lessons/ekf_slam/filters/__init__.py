"""Other filters, made of a student's own three functions."""

from nao_course.lessons.ekf_slam.filters.compressed import CompressedFilter
from nao_course.lessons.ekf_slam.filters.first_estimates import FirstEstimates

__all__ = ["CompressedFilter", "FirstEstimates"]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
