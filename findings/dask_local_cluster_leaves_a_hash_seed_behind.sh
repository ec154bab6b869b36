#!/usr/bin/env bash
# A LocalCluster of distributed 2026.8.0 gives its worker processes the hash seed 6640 and one thread for BLAS, through
# the environment. You expect close() to leave the calling process as it was. Seen: afterwards its os.environ still
# holds PYTHONHASHSEED=6640, OMP_NUM_THREADS=1, OPENBLAS_NUM_THREADS=1, MKL_NUM_THREADS=1, MALLOC_TRIM_THRESHOLD_ and
# __DASK_PARENT_PID. Every Python that is started later, for instance to run a simulation again, orders its sets of
# texts in one fixed way and computes with one thread. Results that depend on the order of a set therefore repeat
# after a cluster was used, and differ from run to run without it; benchmarks before and after do not compare.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check dask==2026.8.0 distributed==2026.8.0
cat > "$folder/seen.py" <<'PYTHON'
import os
import subprocess
import sys

from distributed import LocalCluster

LANDMARKS = "print(list({'corner', 'post', 'cross', 'circle', 'penalty mark'}))"


def orders():
    runs = [subprocess.run([sys.executable, "-c", LANDMARKS], capture_output=True, text=True) for _ in range(8)]
    return len({each.stdout for each in runs})


if __name__ == "__main__":
    before, orders_before = dict(os.environ), orders()
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None):
        pass
    left = {name: value for name, value in os.environ.items() if before.get(name) != value}
    print("left in the environment:", sorted(left), "hash seed", left.get("PYTHONHASHSEED"))
    print("orders of one set in eight new processes: before", orders_before, "after", orders())
    assert left.pop("__DASK_PARENT_PID") == str(os.getpid()) and left.pop("MALLOC_TRIM_THRESHOLD_")
    threads = {f"{library}_NUM_THREADS": "1" for library in ("MKL", "OMP", "OPENBLAS")}
    assert left == threads | {"PYTHONHASHSEED": "6640"}
    assert orders_before > 1 and orders() == 1
PYTHON
names=(PYTHONHASHSEED MALLOC_TRIM_THRESHOLD_ MKL_NUM_THREADS OMP_NUM_THREADS OPENBLAS_NUM_THREADS)
env "${names[@]/#/-u}" "$folder/venv/bin/python" "$folder/seen.py"
