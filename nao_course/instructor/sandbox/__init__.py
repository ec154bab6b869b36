"""Where students' code runs: a warm server that forks confined workers, and how the grader speaks with them."""
