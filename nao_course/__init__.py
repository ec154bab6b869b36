"""A robotics lab course in a box: a NAO on half a football field, and the SLAM that its students build."""

__all__ = [
    "datasets",
    "exercises",
    "field_slam",
    "geometry",
    "homework",
    "lessons",
    "plotting",
    "sim",
    "slam",
    "student",
    "widgets",
]
