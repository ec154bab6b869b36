"""Numbers of things in words."""

from __future__ import annotations


def say_count(number: int, noun: str) -> str:
    """Return a number with its noun, such as "1 robot" or "3 robots"."""
    return f"{number} {noun}" + ("" if number == 1 else "s")
