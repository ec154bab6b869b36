"""Packages that one lesson alone uses, named like the lesson without its number."""

__all__ = ["hsl_filtering", "meet_the_nao"]
