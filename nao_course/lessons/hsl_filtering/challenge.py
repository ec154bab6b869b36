"""The challenge of lesson 01: labels in dark and harsh rooms."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.challenges.rooms import Place, places
from nao_course.lessons.hsl_filtering.challenge_figure import draw_lost_points
from nao_course.sim import LABELS, Scene

ENOUGH = 300  # pixels of white and of yellow that every scene has at least
# Seeds by preset; our parameters were tuned in other rooms.
ROOMS = {"dark": (601, 602, 603), "harsh": (604, 605, 606)}
SCENES_PER_ROOM = 5
YELLOW, WHITE = LABELS.index("yellow"), LABELS.index("white")


def shows_enough(scene: Scene) -> bool:
    """Return True if a picture shows enough white and enough yellow."""
    return all((scene.truth.labels == label).sum() >= ENOUGH for label in (WHITE, YELLOW))


def make_scene(place: Place) -> Scene:
    """Return a picture of a room that shows enough white and yellow."""
    return place.scene(shows_enough)


def on_the_field(truth: npt.NDArray[np.uint8]) -> npt.NDArray[np.bool_]:
    """Return a mask (H, W) of everything below the far edge of the carpet, column by column."""
    return np.logical_or.accumulate((truth == LABELS.index("green")) | (truth == WHITE), axis=0)


def f1(called: npt.NDArray[np.bool_], there: npt.NDArray[np.bool_]) -> float:
    """Return the harmonic mean of precision and recall; 0 if both are undefined."""
    both, total = int((called & there).sum()), int(called.sum() + there.sum())
    return 2 * both / total if total else 0.0


def as_labels(answer: Any, shape: tuple[int, ...]) -> npt.NDArray[np.int64]:
    """Return a student's answer as labels with the shape of a picture.

    Raise a TypeError or ValueError with a message for the student if it is something else.
    """
    if answer is None:
        raise TypeError("Your entry returns None. Does it end with return labels?")
    try:
        labels = np.array(answer, subok=False)
    except (TypeError, ValueError):
        labels = np.array(None)
    if labels.dtype.kind not in "biuf":
        raise TypeError(f"Your entry must return an array of labels, got {type(answer).__name__}.")
    if labels.shape != shape:
        raise ValueError(
            f"Your entry must return one label for each pixel, shape {shape}; got shape {labels.shape}."
        )
    if not np.isfinite(labels).all():
        raise ValueError("Your entry returns labels that are NaN or infinite.")
    if not np.isin(labels, range(len(LABELS))).all():
        raise ValueError(
            f"Labels are 0 other, 1 green, 2 yellow, 3 white; got {labels.min():g} to {labels.max():g}."
        )
    return labels.astype(np.int64)


def judge(answer: Any, scene: Scene) -> CaseScore:
    """Score the labels of a scene: the mean of F1 of white, on the field, and of yellow, everywhere."""
    truth = scene.truth.labels
    labels, field = as_labels(answer, truth.shape), on_the_field(truth)
    is_white, is_yellow = (labels == WHITE) & field, labels == YELLOW
    white, yellow = f1(is_white, truth == WHITE), f1(is_yellow, truth == YELLOW)
    columns = {
        "white": white,
        "yellow": yellow,
        "false white": 100 * float((is_white & (truth != WHITE))[field].mean()),
        "false yellow": 100 * float((is_yellow & (truth != YELLOW)).mean()),
        "white behind": 100 * float((labels == WHITE)[~field].mean()) if not field.all() else np.nan,
    }
    return CaseScore((white + yellow) / 2, columns, (scene.pixels, labels, truth, field))


CHALLENGE = Challenge(
    lesson="01_hsl_filtering",
    title="Challenge 01: dark and harsh rooms",
    task="Label thirty pictures, fifteen in dark rooms and fifteen in harsh ones, with one function of the picture: "
    "labels (H, W), 0 other, 1 green, 2 yellow, 3 white.",
    scoring="the mean of the F1 of white and the F1 of yellow over all scenes. F1 is the harmonic mean of precision "
    "and recall, in pixels. White counts below the far edge of the carpet, and yellow in the whole picture. Each scene "
    "shows at least 300 pixels of both.",
    seeds=places(ROOMS, SCENES_PER_ROOM),
    make=make_scene,
    given=lambda scene: (scene.pixels,),
    judge=judge,
    figure=draw_lost_points,
    columns=(
        Column("white"),
        Column("yellow"),
        Column("false white", " %", 1),
        Column("false yellow", " %", 1),
        Column("white behind", " %", 0),
    ),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
)
