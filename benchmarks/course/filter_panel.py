"""How much processor time a value of each slider of lesson 01's filter panel takes, with the lesson's solutions."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution
from nao_course.lessons.hsl_filtering import FilterPanel
from nao_course.sim import SimulatedNao, Truth

VALUES = 40  # of each slider
SLIDERS: dict[str, list[dict[str, Any]]] = {
    "hue of green": [{"green": (90.0 + number, 150.0)} for number in range(VALUES)],
    "beta": [{"beta": 80.0 + number} for number in range(VALUES)],
    "minimum saturation": [{"min_saturation": number / 100} for number in range(VALUES)],
    "light": [{"light": 0.5 + number / 50} for number in range(VALUES)],
}


def milliseconds(panel: FilterPanel, values: list[dict[str, Any]]) -> float:
    """Return the median processor time of a value, ms."""
    taken = []
    for value in values:
        began = time.process_time()
        panel.set(**value)
        taken.append(1e3 * (time.process_time() - began))
    return float(np.median(taken))


def main() -> Result:
    """Move each slider in turn."""
    own, nao = solution("01"), SimulatedNao(rng=1)
    picture = nao.take_picture()
    panel = FilterPanel(
        picture.pixels,
        Truth(nao).picture,
        own["color_labels"],
        green=(100.0, 150.0),
        yellow=(45.0, 60.0),
        threshold=own["white_threshold"],
    )
    found = {name: {"processor, ms": milliseconds(panel, values)} for name, values in SLIDERS.items()}
    return Result("filter_panel", found, (Table.of("The filter panel, without a browser", found),))
