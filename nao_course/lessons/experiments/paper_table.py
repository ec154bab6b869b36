"""Table A.1 of the paper (Aliyev et al. 2014): 27 settings with the mean cost and the sigma that it prints."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from types import MappingProxyType

Setting = tuple[int, int, int]  # beta, maxLineGap (px), minLineLength (px)

BETAS, GAPS, LENGTHS = (110, 120, 130), (4, 5, 7), (30, 40, 50)
# In the order of its rows
SETTINGS: tuple[Setting, ...] = tuple(
    (beta, gap, length) for length, gap, beta in product(LENGTHS, GAPS, BETAS)
)
PICTURES = 30
BEST: Setting = (120, 5, 40)

_MEANS = (
    *(6.233, 5.333, 4.755, 6.831, 5.822, 5.133, 9.655, 7.328, 5.487),
    *(4.223, 3.655, 3.754, 3.124, 2.122, 2.433, 4.032, 3.422, 3.971),
    *(5.322, 4.932, 5.143, 5.122, 4.722, 5.002, 5.483, 4.820, 5.103),
)
_SIGMAS = (
    *(1.720, 1.566, 1.322, 2.008, 1.611, 1.568, 2.634, 2.304, 1.703),
    *(0.982, 0.623, 0.809, 0.510, 0.322, 0.389, 1.343, 0.780, 1.084),
    *(1.472, 1.328, 1.407, 1.902, 2.103, 1.514, 1.495, 1.278, 1.300),
)
PAPER_MEANS: Mapping[Setting, float] = MappingProxyType(dict(zip(SETTINGS, _MEANS, strict=True)))
PAPER_SIGMAS: Mapping[Setting, float] = MappingProxyType(dict(zip(SETTINGS, _SIGMAS, strict=True)))


def say_setting(setting: Setting) -> str:
    """Return a short label for a setting: "120, 5, 40"."""
    return ", ".join(f"{each:g}" for each in setting)
