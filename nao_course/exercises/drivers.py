"""Functions that run beside a student's code and turn what it does into arrays that can be compared."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt


def sampling_law(
    function: Callable[..., float], values: npt.NDArray[Any], n_samples: int, repeats: int
) -> npt.NDArray[np.float64]:
    """Call a function that draws a random sample, many times.

    Parameters
    ----------
    function : callable
        ``function(values, n_samples, rng) -> float``.
    values : ndarray
        What it draws from.
    n_samples : int
        How many it draws.
    repeats : int
        How many generators it is called with, seeds 0 to repeats - 1.

    Returns
    -------
    ndarray, shape (3,)
        Mean and standard deviation of its answers, and the fraction that come out the same for the same seed.
    """
    first, again = (
        np.array(
            [function(values.copy(), n_samples, np.random.default_rng(seed)) for seed in seeds], dtype=float
        )
        for seeds in (range(repeats), range(min(repeats, 20)))
    )
    return np.array([first.mean(), first.std(), float((first[: len(again)] == again).mean())])
