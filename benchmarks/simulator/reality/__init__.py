"""Does the geometry hold on a real robot's pictures? Every hand-marked point is predicted from the others.

The whole field of the 2012 rules is laid over real pictures. Fitted once per set of pictures: camera
height, both fields of view, lens term and mean pitch offset. Fitted per picture: small corrections of
pitch, roll and heading. Each marked point is then predicted with its own picture left out of the
set's fit, and itself left out of its picture's; the error is in pixels at 320 x 240.
"""

from benchmarks.simulator.reality.fit import (
    FEWEST_POINTS,
    KINDS,
    SET_VALUES,
    START,
    WALK_BEFORE_THE_GAP,
    WALK_STOP,
    Case,
    Freedom,
    Matched,
    corrected_walk,
    errors_of,
    fit_residuals,
    fit_set,
    fitted_view,
    landmarks_of,
    match,
    predict,
    run_case,
    summary,
)
from benchmarks.simulator.reality.report import main

__all__ = [
    "FEWEST_POINTS",
    "KINDS",
    "SET_VALUES",
    "START",
    "WALK_BEFORE_THE_GAP",
    "WALK_STOP",
    "Case",
    "Freedom",
    "Matched",
    "corrected_walk",
    "errors_of",
    "fit_residuals",
    "fit_set",
    "fitted_view",
    "landmarks_of",
    "main",
    "match",
    "predict",
    "run_case",
    "summary",
]
