"""Proving that a lesson's declaration and its solution fit, once for each state of the two."""

__all__: list[str] = ["plan_checks", "proofs"]
