"""Helpers of this package: lazy imports, names of older releases, time limits, and a single thread for libraries."""

__all__ = ["lazy_names", "renamed_names", "single_threaded", "time_limits"]
