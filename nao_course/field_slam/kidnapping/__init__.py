"""Recovery of a robot that is carried away: the likelihood of a stop, a grid of poses, and a wrapper that uses both."""

__all__ = ["grid", "likelihood", "recovery"]
