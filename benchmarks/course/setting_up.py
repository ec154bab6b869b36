"""Time of ``make lab`` in a new clone, until JupyterLab could start, and of its first release, before and now.

``python -m benchmarks setting_up`` takes long, because the build before proves all lessons for its first release. It
downloads the locked packages twice, into empty caches. Seconds are of the clock, because a processor waits for the
network and the disk here.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from pathlib import Path

from benchmarks import Result
from benchmarks.course.waiting import HOUR, compared, environment, module_seconds


def measure(root: Path) -> dict[str, float]:
    """Return the costs of one build, with empty caches and then with full ones, and of the release."""
    (root / ".venv").unlink(missing_ok=True)
    found = {}
    with tempfile.TemporaryDirectory() as cache:
        caches = {name: str(Path(cache, name)) for name in ("PIP_CACHE_DIR", "UV_CACHE_DIR")}
        for state in ("empty caches", "full caches"):
            began = time.perf_counter()
            subprocess.run(
                ["make", "lab", "LAB_ARGS=--version", "PIP_ARGS=--quiet"],
                cwd=root,
                env=environment(root) | caches,
                check=True,
                stdout=subprocess.DEVNULL,
            )
            found[f"make lab in a new clone, {state}, s"] = time.perf_counter() - began
            shutil.rmtree(root / ".venv")
        began = time.perf_counter()
        module_seconds(root, "nao_course.cli", "release", "--out", f"{cache}/release", seconds=HOUR, worst=0)
        found["first release, s"] = time.perf_counter() - began
    return found


def main() -> Result:
    """Set up both builds, one after the other."""
    return compared("setting_up", "How long the first make lab and the first release take", measure, 1)
