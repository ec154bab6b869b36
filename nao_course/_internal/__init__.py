"""Helpers: counts in words, lazy imports, names of older releases, encodings of text, time limits, a single thread."""

__all__ = ["counts", "lazy_names", "renamed_names", "single_threaded", "text_encodings", "time_limits"]
