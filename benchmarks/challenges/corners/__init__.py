"""A better corner detector, in two: one needs only the picture, the other also the camera's view of the ground."""

from benchmarks.challenges.corners.in_picture import find_corners_better
from benchmarks.challenges.corners.on_ground import find_corners_on_ground, middle_lines

__all__ = ["find_corners_better", "find_corners_on_ground", "middle_lines"]
