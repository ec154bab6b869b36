"""What was scored: records, the journal that keeps them, and the sum."""
