"""Helpers of this package: counts in words, lazy imports, names of older releases, time limits, a single thread."""

__all__ = ["counts", "lazy_names", "renamed_names", "single_threaded", "time_limits"]
