"""Settings of the filter panel and its sliders."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.widgets import Slider

Limits = tuple[float, float]

HUE_MOST = 359.0  # degrees; the next whole hue is 0
_HUES = ((0.0, HUE_MOST, 1.0), {"unit": "°", "look": "nao-hue"})
LIGHTS = (0.3, 1.6)  # factors of the light
_SLIDERS: Any = (  # name, label, (limits and step, options), tooltip
    ("light", "Light", ((*LIGHTS, 0.01), {}), "Factor of the light that falls on the scene"),
    ("green_low", "Green from", _HUES, "Smallest hue labelled green, in degrees"),
    (
        "green_high",
        "Green to",
        _HUES,
        "Largest hue labelled green. If it is below the smallest, the interval goes through 0",
    ),
    ("yellow_low", "Yellow from", _HUES, "Smallest hue labelled yellow, in degrees"),
    (
        "yellow_high",
        "Yellow to",
        _HUES,
        "Largest hue labelled yellow. If it is below the smallest, the interval goes through 0",
    ),
    ("beta", "White: β", ((0.0, 255.0, 1.0), {}), "Lower bound of the threshold for white, equation 1.4"),
    ("min_saturation", "Min. saturation", ((0.0, 1.0, 0.01), {}), "Smallest saturation of green and yellow"),
)


@dataclass(frozen=True)
class FilterSettings:
    """Values of the sliders, rounded to their steps as in a browser.

    Hue limits are whole degrees, of which the first is larger if the interval goes through 0. `beta`, the lower bound
    of the threshold in equation 1.4, is a whole number from 0 to 255; `min_saturation` is 0 to 1, and `light`, a
    factor, 0.3 to 1.6, both in hundredths.
    """

    green: Limits
    yellow: Limits
    beta: float
    min_saturation: float
    light: float = 1.0

    def __post_init__(self) -> None:
        """Raise ValueError for values that no slider can show."""
        for name in ("green", "yellow"):
            limits = np.asarray(getattr(self, name), dtype=float)
            if limits.shape != (2,) or not ((limits >= 0) & (limits < 360)).all():
                raise ValueError(
                    f"{name} must be two hues in degrees, from 0 to below 360; got {getattr(self, name)!r}"
                )
            low, high = np.minimum(np.round(limits), HUE_MOST)
            object.__setattr__(self, name, (float(low), float(high)))
        ends = {"beta": (0, 255, 0), "min_saturation": (0, 1, 2), "light": (*LIGHTS, 2)}
        for name, (least, most, digits) in ends.items():
            if not least <= getattr(self, name) <= most:
                raise ValueError(f"{name} must be from {least} to {most}, got {getattr(self, name)!r}")
            object.__setattr__(self, name, round(float(getattr(self, name)), digits))

    def __str__(self) -> str:
        """Return the values in words."""
        hues = ", ".join(f"{name} {low:.0f}° to {high:.0f}°" for name, (low, high) in self._hues())
        return f"{hues}, beta {self.beta:.0f}, minimum saturation {self.min_saturation:.2f}, light {self.light:.2f}"

    @classmethod
    def of_sliders(cls, values: Mapping[str, float]) -> FilterSettings:
        """Return the settings for slider values with the names of `by_slider`."""
        green, yellow = (
            (values[f"{colour}_low"], values[f"{colour}_high"]) for colour in ("green", "yellow")
        )
        return cls(green, yellow, values["beta"], values["min_saturation"], values["light"])

    def by_slider(self) -> dict[str, float]:
        """Return the value of each slider by its name."""
        ends = {
            f"{colour}_{end}": hue
            for colour, hues in self._hues()
            for end, hue in zip(("low", "high"), hues, strict=True)
        }
        return {**ends, "beta": self.beta, "min_saturation": self.min_saturation, "light": self.light}

    def sliders(self) -> list[Slider]:
        """Return the sliders, which start at these settings."""
        start = self.by_slider()
        return [
            Slider(name, label, low, high, step, start[name], tooltip=tooltip, **looks)
            for name, label, ((low, high, step), looks), tooltip in _SLIDERS
        ]

    def _hues(self) -> tuple[tuple[str, Limits], ...]:
        return ("green", self.green), ("yellow", self.yellow)
