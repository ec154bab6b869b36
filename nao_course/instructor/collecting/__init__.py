"""What students handed in: folders, archives, and the names that learning platforms give."""

__all__: list[str] = ["archives", "names", "submissions"]
