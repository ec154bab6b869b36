"""What an exercise is, and what a lesson does with a student's code."""

from nao_course.exercises.trying import try_out

__all__ = ["try_out"]
