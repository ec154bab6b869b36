"""Where the filter panel's sliders stand, and what each of them is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.widgets import Slider

Limits = tuple[float, float]

HUE_MOST = 359.0  # degrees; the next one is 0
_HUES = ((0.0, HUE_MOST, 1.0), {"unit": "°", "look": "nao-hue"})
LIGHTS = (0.3, 1.6)  # factors of the light
_SLIDERS: Any = (  # name, label, (limits and step, options), tooltip
    ("light", "Light", ((*LIGHTS, 0.01), {}), "Factor of the light that falls on the scene"),
    ("green_low", "Green from", _HUES, "Smallest hue called green, in degrees"),
    ("green_high", "Green to", _HUES, "Largest hue called green; below the smallest: through 0"),
    ("yellow_low", "Yellow from", _HUES, "Smallest hue called yellow, in degrees"),
    ("yellow_high", "Yellow to", _HUES, "Largest hue called yellow; below the smallest: through 0"),
    ("beta", "White: β", ((0.0, 255.0, 1.0), {}), "Lower bound of the threshold for white, equation 1.4"),
    (
        "min_saturation",
        "Least saturation",
        ((0.0, 1.0, 0.01), {}),
        "Green and yellow are at least this saturated",
    ),
)


@dataclass(frozen=True)
class FilterSettings:
    """Where the sliders stand: rounded to their steps, as a browser would do it.

    Parameters
    ----------
    green, yellow : (float, float)
        Limits of the hue in whole degrees; the first is larger where the interval goes through 0.
    beta : float
        Of equation 1.4, a whole lightness, 0 to 255.
    min_saturation : float
        Of green and yellow, 0 to 1 in hundredths.
    light : float
        Factor of the light, 0.3 to 1.6 in hundredths.
    """

    green: Limits
    yellow: Limits
    beta: float
    min_saturation: float
    light: float = 1.0

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
        ends = {"beta": (0, 255, 0), "min_saturation": (0, 1, 2), "light": (*LIGHTS, 2)}
        for name, (least, most, digits) in ends.items():
            if not least <= getattr(self, name) <= most:
                raise ValueError(f"{name} must be from {least} to {most}, got {getattr(self, name)!r}")
            object.__setattr__(self, name, round(float(getattr(self, name)), digits))

    def __str__(self) -> str:
        """Say them in words."""
        hues = ", ".join(f"{name} {low:.0f}° to {high:.0f}°" for name, (low, high) in self._hues())
        return f"{hues}, beta {self.beta:.0f}, least saturation {self.min_saturation:.2f}, light {self.light:.2f}"

    @classmethod
    def of_sliders(cls, values: Mapping[str, float]) -> FilterSettings:
        """The settings of sliders, by the names of `by_slider`."""
        green, yellow = (
            (values[f"{colour}_low"], values[f"{colour}_high"]) for colour in ("green", "yellow")
        )
        return cls(green, yellow, values["beta"], values["min_saturation"], values["light"])

    def by_slider(self) -> dict[str, float]:
        """What each slider shows."""
        ends = {
            f"{colour}_{end}": hue
            for colour, hues in self._hues()
            for end, hue in zip(("low", "high"), hues, strict=True)
        }
        return {**ends, "beta": self.beta, "min_saturation": self.min_saturation, "light": self.light}

    def sliders(self) -> list[Slider]:
        """The sliders, these settings their start."""
        start = self.by_slider()
        return [
            Slider(name, label, low, high, step, start[name], tooltip=tooltip, **looks)
            for name, label, ((low, high, step), looks), tooltip in _SLIDERS
        ]

    def _hues(self) -> tuple[tuple[str, Limits], ...]:
        return ("green", self.green), ("yellow", self.yellow)
