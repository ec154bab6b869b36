"""The small course that lessons and exercises are begun in."""

from tests.instructor.authoring.conftest import _quickly, built, built_course, course, kernel

__all__ = ["_quickly", "built", "built_course", "course", "kernel"]
