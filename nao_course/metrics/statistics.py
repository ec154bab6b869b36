"""Confidence intervals of a mean and of a proportion."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["mean_interval", "wilson_interval"]

DRAWS = 4000  # resamples of the bootstrap


def mean_interval(values: npt.ArrayLike, probability: float = 0.95) -> tuple[float, float]:
    """Return the percentile bootstrap confidence interval of a mean.

    Parameters
    ----------
    values : array_like, shape (N,)
        Samples, such as one value per picture. To compare two detectors on the same pictures, use the differences of
        their values, because pictures that are hard for one of them are often hard for both.
    probability : float
        Confidence level.

    Returns
    -------
    (float, float)
        Lower and upper bound. They are the same at every call, and NaN if there are no values.

    References
    ----------
    B. Efron, The Annals of Statistics 7, pages 1 to 26, 1979.

    Examples
    --------
    >>> low, high = mean_interval([1.0, 2.0, 3.0, 4.0])
    >>> 1.0 <= low < 2.5 < high <= 4.0
    True
    """
    from scipy.stats import bootstrap  # takes long to import

    given = np.asarray(values, dtype=float)
    if len(given) < 2:
        return (float("nan"),) * 2 if not len(given) else (float(given[0]),) * 2
    found = bootstrap(
        (given,),
        np.mean,
        n_resamples=DRAWS,
        confidence_level=probability,
        method="percentile",
        rng=np.random.default_rng(0),
    )
    return float(found.confidence_interval.low), float(found.confidence_interval.high)


def wilson_interval(hits: int, trials: int, z: float = 1.96) -> tuple[float, float]:
    """Return Wilson's (1927) confidence interval of a proportion.

    Parameters
    ----------
    hits, trials : int
        Number of successes, and number of trials.
    z : float
        Quantile of the normal distribution; 1.96 gives a confidence level of 95 %.

    Returns
    -------
    (float, float)
        Lower and upper bound; (0, 1) if there are no trials.
    """
    if not trials:
        return 0.0, 1.0
    proportion, share = hits / trials, z**2 / trials
    centre = (proportion + share / 2) / (1 + share)
    half = z / (1 + share) * float(np.sqrt(proportion * (1 - proportion) / trials + share / (4 * trials)))
    return centre - half, centre + half
