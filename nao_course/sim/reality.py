"""How real a picture looks: the strength of each effect, and presets of them."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from nao_course.geometry import finite

# The strongest effects that can be rendered: beyond them a picture takes minutes, or shows no more than here.
_MOST = {
    **dict.fromkeys(("seams", "gradient", "white_balance", "exposure", "vignette"), 1.0),
    **dict.fromkeys(("grain", "mottle", "noise"), 255.0),
    **dict.fromkeys(("crumbs", "tape", "pile", "glare", "litter", "overexposure", "blur"), 20.0),
    "specks": 200.0,
    "clutter": 5.0,
    "sheets": 5.0,
    "motion": 5.0,  # the head may turn by 0.5 rad while a picture is read: far more than it ever sways
}
_LARGEST_SEED = 2**63 - 1


def _strength(name: str, value: float, most: float) -> float:
    """An effect's strength, as a float from 0 to `most`."""
    if isinstance(value, bool | np.bool_ | str):
        raise ValueError(f"Reality: {name} must be a number, got {value!r}")
    strength = finite(f"Reality: {name}", value)
    if not 0 <= strength <= most:
        fraction = " (it is a fraction)" if most == 1 else ""
        raise ValueError(f"Reality: {name} must be 0 (off) to {most:g}{fraction}, got {value}")
    return strength


def _seed(value: Any) -> int:
    """A room's seed, as an int; 3.0 is one."""
    whole = isinstance(value, int | np.integer) or (isinstance(value, float | np.floating) and value % 1 == 0)
    if isinstance(value, bool) or not whole or not 0 <= value <= _LARGEST_SEED:
        raise ValueError(f"Reality: seed must be a whole number from 0 to 2**63 - 1, got {value!r:.60}")
    return int(value)


@dataclass(frozen=True)
class Reality:
    """How real a picture looks: each effect has a strength, and zero switches it off.

    The defaults are the preset `lab`, fitted to the real pictures of 2013 (benchmarks/realism).

    Parameters
    ----------
    grain : float
        Carpet: standard deviation of its brightness from fibre to fibre, in levels of 255.
    mottle : float
        Carpet: the same from patch to patch, some decimetres wide.
    seams : float
        Carpet: how open the joints between its strips are, 0 to 1.
    specks : float
        Carpet: pale and dark specks a square metre.
    crumbs : float
        Carpet: clusters of crumbs a square metre.
    tape : float
        Carpet: dark patches of tape a metre along the outer lines.
    pile : float
        Carpet: how much darker and greener it is seen from above than from the side; 1 is a real one.
    glare : float
        How bright lamps and windows shine back from the ground, as a fraction of full light.
    clutter : float
        How crowded the room behind the field is; 1 is a laboratory.
    litter : float
        Things that lie on the carpet beyond the lines, a metre of the outer lines.
    sheets : float
        Sheets of paper that lie anywhere on the carpet, a square metre; in no preset but `messy`.
    gradient : float
        How much the light falls off across the field, as a fraction.
    white_balance : float
        Standard deviation of the colour channels' gains from room to room.
    exposure : float
        How far the camera corrects its exposure so that every picture is equally bright on average; 1 is fully.
    overexposure : float
        How far white lines lie beyond the brightest light the camera can show, as a fraction.
    vignette : float
        How much darker the picture's corners are than its middle, as a fraction of lightness.
    blur : float
        Of lens and sensor, in units of the real camera's.
    noise : float
        Standard deviation of the sensor's noise in levels of 255, mean over the channels.
    motion : float
        How much the camera shakes in pictures taken while walking, in units of a NAO's.
    seed : int
        Which room, carpet and lamps; not an effect.

    Raises
    ------
    ValueError
        If a strength is no number, negative, or more than 1 for a fraction (seams, gradient, white_balance, exposure,
        vignette), 255 for levels (grain, mottle, noise), 5 for clutter, sheets and motion, 200 for specks, and 20
        for everything else; if the seed is no whole number from 0 to 2**63 - 1.
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
        """Refuse what is no strength of an effect, or a stronger one than can be rendered."""
        for name, most in _MOST.items():
            object.__setattr__(self, name, _strength(name, getattr(self, name), most))
        object.__setattr__(self, "seed", _seed(self.seed))

    @classmethod
    def effects(cls) -> tuple[str, ...]:
        """Names of all effects."""
        return tuple(each.name for each in fields(cls) if each.name != "seed")

    @classmethod
    def clean(cls, seed: int = 0) -> Reality:
        """Every effect off."""
        return cls(**dict.fromkeys(cls.effects(), 0.0), seed=seed)

    @classmethod
    def lab(cls, seed: int = 0) -> Reality:
        """A laboratory like that of the real pictures: the default."""
        return cls(seed=seed)

    @classmethod
    def dark(cls, seed: int = 0) -> Reality:
        """An evening with few lamps: uneven light and a noisy sensor."""
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
        """Sun through the windows of a crowded hall: glare, worn carpet, wrong colours."""
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
        """A laboratory in the middle of work: paper and robots lie on the carpet, and the room is full."""
        return cls(sheets=0.12, litter=0.8, clutter=1.8, seams=0.8, crumbs=0.6, glare=0.1, seed=seed)
