"""The appearance of rendered pictures: strengths of the effects that make them look real, and presets."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from nao_course.geometry import finite

# Largest strengths. Above them, a picture takes minutes to render, or does not change any more.
_MOST = {
    **dict.fromkeys(("seams", "gradient", "white_balance", "exposure", "vignette"), 1.0),
    **dict.fromkeys(("grain", "mottle", "noise"), 255.0),
    **dict.fromkeys(("crumbs", "tape", "pile", "glare", "litter", "overexposure", "blur"), 20.0),
    "specks": 200.0,
    "clutter": 5.0,
    "sheets": 5.0,
    "motion": 5.0,  # rotations of up to 0.5 rad while a picture is read out, far more than a real sway
}
_LARGEST_SEED = 2**63 - 1


def _strength(name: str, value: float, most: float) -> float:
    """Return the strength of an effect as a float after checking that it is from 0 to `most`."""
    if isinstance(value, bool | np.bool_ | str):
        raise ValueError(f"Reality: {name} must be a number, got {value!r}")
    strength = finite(f"Reality: {name}", value)
    if not 0 <= strength <= most:
        fraction = " (it is a fraction)" if most == 1 else ""
        raise ValueError(f"Reality: {name} must be 0 (off) to {most:g}{fraction}, got {value}")
    return strength


def _seed(value: Any) -> int:
    """Return the seed of a room as an int after checking it; a float such as 3.0 is allowed."""
    whole = isinstance(value, int | np.integer) or (isinstance(value, float | np.floating) and value % 1 == 0)
    if isinstance(value, bool) or not whole or not 0 <= value <= _LARGEST_SEED:
        raise ValueError(f"Reality: seed must be an integer from 0 to 2**63 - 1, got {value!r:.60}")
    return int(value)


@dataclass(frozen=True)
class Reality:
    """The strengths of the effects that make rendered pictures look real; a strength of 0 turns an effect off.

    The defaults are the preset `lab`, which was fitted to the real pictures of 2013 (benchmarks/simulator/realism.py).

    Parameters
    ----------
    grain : float
        Standard deviation of the carpet's brightness from fibre to fibre, in levels of 255.
    mottle : float
        Standard deviation of the carpet's brightness between patches of some decimetres, in levels of 255.
    seams : float
        Visibility of the joints between the carpet's strips, 0 to 1.
    specks : float
        Number of pale and dark specks per square metre of carpet.
    crumbs : float
        Number of clusters of crumbs per square metre of carpet.
    tape : float
        Number of dark patches of tape per metre along the outer lines.
    pile : float
        How much darker and greener the carpet is when seen from above instead of from the side; a real carpet has 1.
    glare : float
        Brightness of the reflections of lamps and windows on the ground, as a fraction of full light.
    clutter : float
        Amount of furniture behind the field; a laboratory has 1.
    litter : float
        Number of things on the carpet outside the lines, per metre of the outer lines.
    sheets : float
        Number of sheets of paper per square metre of carpet; only the preset `messy` has any.
    gradient : float
        Decrease of the light across the field, as a fraction.
    white_balance : float
        Standard deviation of the gains of the colour channels between rooms.
    exposure : float
        Degree to which the camera's automatic exposure makes all pictures equally bright; 1 is a full correction.
    overexposure : float
        Brightness of white lines above the brightest value of the camera, as a fraction.
    vignette : float
        Decrease of the lightness from the centre of a picture to its corners, as a fraction.
    blur : float
        Blur of lens and sensor relative to the real camera.
    noise : float
        Standard deviation of the sensor noise in levels of 255, averaged over the channels.
    motion : float
        Shaking of the camera in pictures that are taken during a walk, relative to a real NAO.
    seed : int
        Seed of the room, the carpet and the lamps; it is not an effect.

    Raises
    ------
    ValueError
        If a strength is not a number, negative or too large. The limits are 1 for fractions (seams, gradient,
        white_balance, exposure, vignette), 255 for levels (grain, mottle, noise), 5 for clutter, sheets and motion, 200
        for specks, and 20 for all others. Also if the seed is not an integer from 0 to 2**63 - 1.
    """

    grain: float = 8.2
    mottle: float = 3.5
    seams: float = 0.6
    specks: float = 9.0
    crumbs: float = 0.15
    tape: float = 0.7
    pile: float = 1.0
    glare: float = 0.05
    clutter: float = 1.0
    litter: float = 0.35
    gradient: float = 0.1
    white_balance: float = 0.03
    exposure: float = 1.0
    overexposure: float = 0.17
    vignette: float = 0.29
    blur: float = 1.0
    noise: float = 1.4
    motion: float = 1.0
    sheets: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        """Check the strengths and the seed."""
        for name, most in _MOST.items():
            object.__setattr__(self, name, _strength(name, getattr(self, name), most))
        object.__setattr__(self, "seed", _seed(self.seed))

    @classmethod
    def effects(cls) -> tuple[str, ...]:
        """Return the names of all effects."""
        return tuple(each.name for each in fields(cls) if each.name != "seed")

    @classmethod
    def clean(cls, seed: int = 0) -> Reality:
        """Return an appearance without any effects."""
        return cls(**dict.fromkeys(cls.effects(), 0.0), seed=seed)

    @classmethod
    def lab(cls, seed: int = 0) -> Reality:
        """Return the default appearance: a laboratory similar to the one in the real pictures."""
        return cls(seed=seed)

    @classmethod
    def dark(cls, seed: int = 0) -> Reality:
        """Return the appearance of an evening with few lamps: uneven light and a noisy sensor."""
        return cls(
            gradient=0.6,
            exposure=0.5,
            vignette=0.45,
            noise=6.0,
            white_balance=0.08,
            overexposure=0,
            blur=1.4,
            seed=seed,
        )

    @classmethod
    def harsh(cls, seed: int = 0) -> Reality:
        """Return the appearance of a crowded hall in bright sun: glare, a worn carpet and wrong colours."""
        return cls(
            glare=0.35,
            gradient=0.35,
            white_balance=0.1,
            specks=15.0,
            crumbs=1.5,
            seams=0.8,
            clutter=1.6,
            seed=seed,
        )

    @classmethod
    def messy(cls, seed: int = 0) -> Reality:
        """Return the appearance of a laboratory during work: paper and robots on the carpet, and a full room."""
        return cls(sheets=0.12, litter=0.8, clutter=1.8, seams=0.8, crumbs=0.6, glare=0.1, seed=seed)
