"""What was scored: records, the journal that keeps them, and the sum."""

__all__: list[str] = ["journal", "records", "scores"]
