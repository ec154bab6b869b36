"""Grading: a submission from its notebook to its score, and a class of them."""
