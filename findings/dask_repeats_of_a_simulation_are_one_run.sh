#!/usr/bin/env bash
# You run a noisy simulation 30 times on a Dask cluster: client.map(simulate, [steps] * 30). You expect 30
# results. distributed 2026.8.0 assumes that functions are pure and names a task by its function and
# arguments, so equal calls are one task: the simulation runs once, and 30 futures share its result. The same
# holds for submit in a loop. Seen: 1 distinct result for 30 futures; 30 with pure=False. The mean of a Monte
# Carlo study is then one run, its standard deviation is 0, and it finishes very fast. Pass the seed as an
# argument, or pure=False.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check distributed==2026.8.0 dask==2026.8.0
"$folder/venv/bin/python" - <<'PYTHON'
import random

from dask.distributed import Client, LocalCluster


def simulate(steps):
    return sum(random.gauss(0, 1) for _ in range(steps))


def distinct(client, **options):
    results = client.gather(client.map(simulate, [100] * 30, **options))
    return len(results), len(set(results))


if __name__ == "__main__":
    cluster = LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None)
    with cluster, Client(cluster) as client:
        default = distinct(client)
        impure = distinct(client, pure=False)
    print("results, distinct:", default, "with pure=False:", impure)
    assert default == (30, 1) and impure == (30, 30)
PYTHON
