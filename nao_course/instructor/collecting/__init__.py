"""What students handed in: folders, archives, and the layouts of learning platforms' downloads."""

__all__: list[str] = ["archives", "layouts", "names", "submissions"]
