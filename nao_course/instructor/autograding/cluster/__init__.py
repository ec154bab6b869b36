"""Grading with Dask workers: what the grader sends, and what runs in a worker's process."""

__all__: list[str] = ["dispatch", "parcels", "worker"]
