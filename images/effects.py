"""What each effect of the simulator's pictures does, alone and all together, as one figure."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import Pose
from nao_course.sim import NAO_V4, Field, Reality, render

Pixels = npt.NDArray[np.uint8]

_POSE = Pose(0.55, 0.5, -0.22)
_PITCH = float(np.radians(-24.6))
_TURNING = (0.02, 0.03, -0.12)  # of the head of a robot that walks, rad: seen only with `motion`
_SEED = 3
# An effect that is small in a laboratory is shown stronger; the label says how strong.
_SHOWN = {
    "grain": 20.0,
    "mottle": 12.0,
    "seams": 1.0,
    "specks": 40.0,
    "crumbs": 2.0,
    "tape": 1.5,
    "glare": 0.5,
    "litter": 1.5,
    "sheets": 0.5,
    "gradient": 0.6,
    "white_balance": 0.15,
    "overexposure": 1.0,
    "vignette": 0.6,
    "blur": 3.0,
    "noise": 12.0,
}
_COLUMNS = 5


def _picture(reality: Reality) -> Pixels:
    """One place, seen as real as asked for."""
    turning = _TURNING if reality.motion and not reality.noise else (0.0, 0.0, 0.0)
    view = NAO_V4.view("bottom", 0.0, _PITCH)
    return render(Field(), _POSE, view, reality, np.random.default_rng(_SEED), turning)[0]


def _labelled(pixels: Pixels, label: str) -> Pixels:
    """A picture with its label on a strip above it."""
    strip = np.full((22, pixels.shape[1], 3), 255, dtype=np.uint8)
    cv2.putText(strip, label, (4, 16), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (20, 20, 20), 1, cv2.LINE_AA)
    return np.pad(np.vstack([strip, pixels]), ((0, 4), (0, 4), (0, 0)), constant_values=255)


def draw_effects() -> bytes:
    """Return a WebP picture: clean, every effect alone, and the presets with all of them; the same at every call."""
    panels = [_labelled(_picture(Reality.clean(_SEED)), "clean: no effect")]
    for name in Reality.effects():
        strength = _SHOWN.get(name, getattr(Reality(), name))
        alone = replace(Reality.clean(_SEED), **{name: strength})
        panels.append(_labelled(_picture(alone), f"{name} {strength:g}"))
    for preset in ("lab", "dark", "harsh", "messy"):
        panels.append(_labelled(_picture(getattr(Reality, preset)(_SEED)), f"{preset}: all together"))
    panels += [np.full_like(panels[0], 255)] * (-len(panels) % _COLUMNS)
    rows = [np.hstack(panels[i : i + _COLUMNS]) for i in range(0, len(panels), _COLUMNS)]
    small = np.asarray(cv2.resize(np.vstack(rows), None, fx=0.6, fy=0.6, interpolation=cv2.INTER_AREA))
    _, webp = cv2.imencode(".webp", small[..., ::-1], [cv2.IMWRITE_WEBP_QUALITY, 85])
    return webp.tobytes()
