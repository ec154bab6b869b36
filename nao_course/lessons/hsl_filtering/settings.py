"""Where the filter panel's sliders stand, and what each of them is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

Limits = tuple[float, float]

HUE_MOST = 359.0  # degrees; the next one is 0
SLIDERS: Mapping[str, tuple[str, str, float, float, str]] = {  # name: label, tooltip, most, step, format
    "green low": ("Green from (°)", "Smallest hue called green, in degrees", HUE_MOST, 1.0, ".0f"),
    "green high": ("Green to (°)", "Largest hue called green; below the smallest: through 0", HUE_MOST, 1.0, ".0f"),
    "yellow low": ("Yellow from (°)", "Smallest hue called yellow, in degrees", HUE_MOST, 1.0, ".0f"),
    "yellow high": ("Yellow to (°)", "Largest hue called yellow; below the smallest: through 0", HUE_MOST, 1.0, ".0f"),
    "beta": ("White: β", "Lower bound of the threshold for white, equation 4.1", 255.0, 1.0, ".0f"),
    "min_saturation": ("Least saturation", "Green and yellow are at least this saturated", 1.0, 0.01, ".2f"),
}  # fmt: skip


@dataclass(frozen=True)
class FilterSettings:
    """Where the sliders stand: rounded to their steps, as a browser would do it.

    Parameters
    ----------
    green, yellow : (float, float)
        Limits of the hue in whole degrees; the first is larger where the interval goes through 0.
    beta : float
        Of equation 4.1, a whole lightness, 0 to 255.
    min_saturation : float
        Of green and yellow, 0 to 1 in hundredths.
    """

    green: Limits
    yellow: Limits
    beta: float
    min_saturation: float

    def __post_init__(self) -> None:
        """Refuse what no slider can show."""
        for name in ("green", "yellow"):
            limits = np.asarray(getattr(self, name), dtype=float)
            if limits.shape != (2,) or not ((limits >= 0) & (limits < 360)).all():
                raise ValueError(
                    f"{name} must be two hues in degrees, from 0 to below 360; got {getattr(self, name)!r}"
                )
            low, high = np.minimum(np.round(limits), HUE_MOST)
            object.__setattr__(self, name, (float(low), float(high)))
        for name, most, digits in (("beta", 255, 0), ("min_saturation", 1, 2)):
            if not 0 <= getattr(self, name) <= most:
                raise ValueError(f"{name} must be from 0 to {most}, got {getattr(self, name)!r}")
            object.__setattr__(self, name, round(float(getattr(self, name)), digits))

    def __str__(self) -> str:
        """Say them in words."""
        hues = ", ".join(f"{name} {low:.0f}° to {high:.0f}°" for name, (low, high) in self._hues())
        return f"{hues}, beta {self.beta:.0f}, least saturation {self.min_saturation:.2f}"

    def of_slider(self, name: str) -> float:
        """What the slider of that name, a key of `SLIDERS`, shows."""
        if name in ("beta", "min_saturation"):
            return float(getattr(self, name))
        colour, end = name.split()
        return float(getattr(self, colour)[end == "high"])

    def _hues(self) -> tuple[tuple[str, Limits], ...]:
        return ("green", self.green), ("yellow", self.yellow)
