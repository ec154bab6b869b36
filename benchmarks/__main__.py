"""``python -m benchmarks`` runs every benchmark, ``python -m benchmarks NAME ...`` those named."""

from __future__ import annotations

import argparse
import importlib
import sys
from collections.abc import Sequence

from rich.console import Console

import benchmarks

BENCHMARKS = {  # folder: names of its benchmarks, each a module or package with a `main`
    "pictures": ("colour_filter", "corners", "distance", "experiments", "pipeline", "posts", "tilt"),
    "simulator": ("realism", "reality", "rendering"),
    "ekf": ("ekf_consistency", "ekf_ideas", "ekf_logs", "ekf_speed"),
    "graphs": ("ekf_and_graph", "linear_graphs", "pose_graphs"),
    "field": (
        "association",
        "calibration",
        "compass",
        "field_ideas",
        "field_slam",
        "field_speed",
        "field_tails",
        "field_walk",
        "own_fields",
        "kidnapping",
    ),
    "beyond": ("beyond_cameras", "beyond_exploring", "beyond_moves", "beyond_particles"),
    "course": (
        *(
            "films",
            "grading",
            "grading_cluster",
            "grading_memory",
            "grading_profile",
            "panel",
            "siege",
            "personal_worlds",
            "similar",
            "slow_students",
        ),
        "world",
    ),
    "": ("challenges", "hub"),
}
MODULES = {
    name: ".".join(filter(None, ("benchmarks", folder, name)))
    for folder, names in BENCHMARKS.items()
    for name in names
}


def run(name: str, console: Console) -> bool:
    """Run one benchmark, show and save its result. False: its data is not here."""
    module = importlib.import_module(MODULES[name])
    try:
        result: benchmarks.Result = module.main()
    except FileNotFoundError as error:
        console.print(f"[bold]{name}[/bold]: not run, because {error}", soft_wrap=True, highlight=False)
        return False
    result.show(console)
    console.print(f"written to {result.save().relative_to(benchmarks.ROOT)}", highlight=False)
    return True


def main(arguments: Sequence[str] | None = None) -> int:
    """Run what the command line names; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description="Run the course's benchmarks.")
    parser.add_argument(
        "name", nargs="*", help=f"one or more of: {', '.join(sorted(MODULES))}; all of them without"
    )
    chosen: list[str] = parser.parse_args(arguments).name
    if unknown := sorted(set(chosen) - set(MODULES)):
        parser.error(f"there is no benchmark {', '.join(unknown)}; there are: {', '.join(sorted(MODULES))}")
    console = Console()
    done = [run(name, console) for name in chosen or sorted(MODULES)]
    return 0 if all(done) else 1


if __name__ == "__main__":
    sys.exit(main())
