"""Recovery of a robot that is carried away: candidate poses, and a wrapper that uses them."""

__all__ = ["candidates", "recovery"]
