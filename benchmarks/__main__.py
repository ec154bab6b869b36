"""``python -m benchmarks`` runs every benchmark, ``python -m benchmarks NAME ...`` those named."""

import argparse
import importlib
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

import benchmarks


def _modules() -> dict[str, str]:
    """Return the module or package of each benchmark by its name: every one that has a `main`."""
    found = {}
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        if path.name != "__main__.py" and re.search(
            r"^def main\(", path.read_text(encoding="utf-8"), re.MULTILINE
        ):
            module = path.parent if path.name == "__init__.py" else path.with_suffix("")
            found[module.name] = ".".join(module.relative_to(benchmarks.ROOT).parts)
    return found


MODULES = _modules()


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
