"""``python -m benchmarks.simulator.realism --quick`` measures some of the pictures in seconds and writes nothing."""

import argparse

from rich.console import Console

from benchmarks.simulator import realism

parser = argparse.ArgumentParser(prog="python -m benchmarks.simulator.realism", description=realism.__doc__)
parser.add_argument(
    "--quick", action="store_true", help="some of the pictures only, in some seconds; writes nothing"
)
chosen = parser.parse_args()
outcome = realism.quick() if chosen.quick else realism.main()
outcome.show(Console(width=130))
if not chosen.quick:
    outcome.save()
