"""Rounding errors differ between processors: which answers consist of them, and which files differ by nothing else."""

__all__: list[str] = ["alike", "perturbation"]
