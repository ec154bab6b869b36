"""Grading: a submission from its notebook to its score, and a class of them."""

__all__: list[str] = [
    "assignment",
    "batch",
    "cluster",
    "failures",
    "grader",
    "references",
    "scratch",
    "secret",
    "session",
    "tries",
]
