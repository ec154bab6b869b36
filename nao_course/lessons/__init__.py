"""Rooms of single lessons: what one lesson alone uses stands in the folder of its name, without the number."""

__all__ = ["hsl_filtering", "meet_the_nao"]
