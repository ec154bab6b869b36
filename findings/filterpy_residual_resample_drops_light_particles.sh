#!/usr/bin/env bash
# Resampling must be unbiased: on average, particle i is drawn N w_i times. You expect this of every function
# in filterpy.monte_carlo. In filterpy 2.0.0, residual_resample is biased: it takes the remainder of w_i
# instead of N w_i, so the random part favours the heavy particles, and those lighter than 1/N are never
# drawn. Seen for N = 4 and N w = 1.6, 1.2, 0.8, 0.4: the mean counts are 2.2, 1.8, 0, 0. Seen for N = 1000
# random weights: the particles with N w < 1 should get a quarter of the draws and get none.
# systematic_resample gives the right means. A particle filter with the biased function converges too fast,
# because it loses the hypotheses that a kidnapped or symmetric start needs.
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/python" -m pip install --quiet --disable-pip-version-check filterpy==2.0.0 numpy==2.4.6 scipy==1.17.1 matplotlib==3.11.2
"$folder/venv/bin/python" - <<'PYTHON'
import numpy as np
from filterpy.monte_carlo import residual_resample, systematic_resample

np.random.seed(1)


def mean_counts(resample, weights, runs):
    size = len(weights)
    return sum(np.bincount(resample(weights), minlength=size) for _ in range(runs)) / runs


four = np.array([0.4, 0.3, 0.2, 0.1])
biased = mean_counts(residual_resample, four, 2000)
fair = mean_counts(systematic_resample, four, 2000)
print("expected", 4 * four, "residual", biased.round(2), "systematic", fair.round(2))
assert np.allclose(biased, [2.2, 1.8, 0, 0], atol=0.05)
assert np.allclose(fair, 4 * four, atol=0.05)
many = np.random.rand(1000)
many /= many.sum()
light = 1000 * many < 1
drawn = mean_counts(residual_resample, many, 100)[light].sum() / 1000
print(f"share of the light particles: {many[light].sum():.3f} expected, {drawn:.3f} drawn")
assert many[light].sum() > 0.2 and drawn == 0
PYTHON
