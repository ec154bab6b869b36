"""Lesson 09's own solution, for its tests."""

from nao_course.exercises import load_definitions
from tests.paths import SOLUTIONS

OWN = load_definitions(SOLUTIONS / "09_pose_graphs.ipynb")
