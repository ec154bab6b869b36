"""Precision and recall of a colour filter's labels, as numbers and as a table, and legends for labels and errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.plotting.style import LABEL_COLOURS
from nao_course.sim import LABELS
from nao_course.widgets import Legend
from nao_course.widgets.shown import colour_key

COLOURS = LABELS[1:]  # green, yellow, white
# Right, wrongly labelled, missed, neither: after Okabe and Ito (2008), with different lightnesses.
ERROR_COLOURS = ("#ffffff", "#e69f00", "#3a8fd0", "#2b2b31")


@dataclass(frozen=True)
class PrecisionRecall:
    """Precision and recall of the labels of one colour, as fractions of pixels.

    Precision is NaN if no pixel has the label, recall if no pixel should have it.
    """

    precision: float
    recall: float

    @classmethod
    def of(cls, called: npt.NDArray[np.bool_], there: npt.NDArray[np.bool_]) -> PrecisionRecall:
        """Return the score for masks (H, W) of the pixels with this label and of the pixels with this true label."""
        both = int((called & there).sum())
        return cls(*(both / total if (total := int(of.sum())) else float("nan") for of in (called, there)))

    def __str__(self) -> str:
        """Return both in words."""
        return f"precision {percent(self.precision)}, recall {percent(self.recall)}"


def percent(part: float) -> str:
    """Return a fraction in percent; a dash for NaN."""
    return "-" if np.isnan(part) else f"{100 * part:.1f} %"


def error_classes(called: npt.NDArray[np.bool_], there: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """Return classes (H, W) of pixels in the order of `ERROR_COLOURS`: right, wrong, missed, neither."""
    return np.select([called & there, called, there], [0, 1, 2], 3)


def legend(colour: str) -> Legend:
    """Return a legend of the labels, or of the errors in one colour."""
    if not colour:
        return Legend(dict(zip(LABELS, LABEL_COLOURS, strict=True)))
    words = (f"{colour}, found", f"wrongly labelled {colour}", f"{colour}, missed", "neither")
    return Legend(dict(zip(words, ERROR_COLOURS, strict=True)))


@dataclass(frozen=True)
class ScoreTable:
    """Scores by colour, shown as a table on a page and as lines elsewhere."""

    scores: Mapping[str, PrecisionRecall]

    def __repr__(self) -> str:
        """Return one line per colour."""
        return "\n".join(f"{name}: {score}" for name, score in self.scores.items())

    def _repr_html_(self) -> str:
        """Return a table of precision and recall; dashes where they are undefined."""
        rows = []
        for name, colour in zip(COLOURS, LABEL_COLOURS[1:], strict=True):
            score = self.scores.get(name, PrecisionRecall(float("nan"), float("nan")))
            cells = "".join(f"<td>{percent(part)}</td>" for part in (score.precision, score.recall))
            rows.append(f'<tr><th scope="row">{colour_key(colour)}{name}</th>{cells}</tr>')
        head = '<th></th><th scope="col">Precision</th><th scope="col">Recall</th>'
        return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"
