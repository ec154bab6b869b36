"""Copied work: pairs of students whose own code is more alike than independent right answers are."""

__all__: list[str] = []
