"""Where students' code runs: a warm server that forks confined workers, and how the grader speaks with them."""

__all__: list[str] = [
    "confinement",
    "fork_server",
    "layers",
    "linux",
    "protocol",
    "warm_server",
    "worker",
    "worker_process",
]
