"""Run the quick tier with other versions: ``python -m tests.versions lowest-direct``, or ``highest``.

``python -m tests.versions highest --python python3.13 -x`` gives the interpreter, and pytest whatever follows. The
environment stays in ``build/versions``, and the next run uses it again.
"""

import argparse
import os
import subprocess
import sys
import tomllib
from pathlib import Path

from tests.paths import PROJECT
from tests.test_installed import Environment, declared


def main() -> int:
    """Install into an environment, run the tests there, and return pytest's exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.versions", description=__doc__)
    parser.add_argument("resolution", choices=("lowest-direct", "highest"))
    parser.add_argument("--python", default=sys.executable)
    options, more = parser.parse_known_args()
    groups = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["dependency-groups"]
    core = [each for each in declared() if not each.startswith("nao-course")]
    folder = PROJECT / "build" / "versions" / f"{options.resolution}-{Path(options.python).name}"
    environment = Environment(folder, options.python)
    for words in (
        ("--upgrade", "--resolution", options.resolution, *core),
        (*groups["test"], *groups["build"], *groups["dev"]),
        ("--no-deps", "--no-build-isolation", "-e", PROJECT),
    ):
        if (done := environment.install(*words)).returncode:
            print(done.stderr, file=sys.stderr)
            return done.returncode
    python = environment.programs / "python"
    tests = [
        str(python),
        "-m",
        "pytest",
        "-n",
        "2",
        "-p",
        "no:nbval",
        "-m",
        "not slow and not browser",
        *more,
    ]
    one_thread = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    return subprocess.run(tests, cwd=PROJECT, env=os.environ | one_thread, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
