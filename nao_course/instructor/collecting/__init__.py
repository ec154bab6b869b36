"""What students handed in: folders, archives, and the names that learning platforms give."""
