"""A complete run: the robot drives or walks by its pictures alone, maps the field, and reports its errors."""

__all__ = ["drive", "film", "report"]
