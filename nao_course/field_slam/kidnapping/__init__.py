"""Recovery of a robot that is carried away: the likelihood of a stop, candidate poses, and a wrapper that uses both."""

__all__ = ["candidates", "likelihood", "recovery"]
