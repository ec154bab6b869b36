"""Where students' code runs: a warm server that forks confined workers, and how the grader speaks with them."""

__all__: list[str] = [
    "confinement",
    "fork_server",
    "layers",
    "linux",
    "protocol",
    "system_calls",
    "warm_server",
    "worker",
    "worker_process",
]
