"""Lesson 09's own solution, for its tests."""

from tests.lessons import every

OWN = every.own("09")
