"""The robot without a hand in it: it drives or walks, maps the field, and shows what came of it."""

__all__ = ["drive", "film", "report"]
