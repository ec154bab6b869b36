"""``python -m benchmarks`` runs every benchmark, ``python -m benchmarks NAME ...`` those named."""

from __future__ import annotations

import argparse
import importlib
import pkgutil
import sys
from collections.abc import Sequence

from rich.console import Console

import benchmarks


def names() -> list[str]:
    """Return the modules of this package that may be benchmarks."""
    return sorted(
        module.name for module in pkgutil.iter_modules(benchmarks.__path__) if module.name != "__main__"
    )


def run(name: str, console: Console) -> bool:
    """Run one benchmark, if the module is one; show and save its result. False: its data is not here."""
    module = importlib.import_module(f"benchmarks.{name}")
    if not hasattr(module, "main"):
        return True
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
    parser.add_argument("name", nargs="*", help=f"one or more of: {', '.join(names())}; all of them without")
    chosen: list[str] = parser.parse_args(arguments).name
    if unknown := sorted(set(chosen) - set(names())):
        parser.error(f"there is no benchmark {', '.join(unknown)}; there are: {', '.join(names())}")
    console = Console()
    console.width = max(console.width, 110)  # a file or a narrow window: rather long lines than broken tables
    done = [run(name, console) for name in chosen or names()]
    return 0 if all(done) else 1


if __name__ == "__main__":
    sys.exit(main())
