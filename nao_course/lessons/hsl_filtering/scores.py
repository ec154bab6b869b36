"""How good a colour filter's labels are, in numbers and as a table, and what the colours of labels and errors mean."""

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
# Right, called so but is not, is so but missed, neither: after Okabe and Ito (2008), apart in lightness too.
ERROR_COLOURS = ("#ffffff", "#e69f00", "#3a8fd0", "#2b2b31")


@dataclass(frozen=True)
class PrecisionRecall:
    """How good the labels of one colour are.

    Parameters
    ----------
    precision : float
        Of the pixels called so, the part that is; NaN if none is called so.
    recall : float
        Of the pixels that are so, the part that is called so; NaN if there are none.
    """

    precision: float
    recall: float

    @classmethod
    def of(cls, called: npt.NDArray[np.bool_], there: npt.NDArray[np.bool_]) -> PrecisionRecall:
        """Count: which pixels are called so, and which are so, both (H, W)."""
        both = int((called & there).sum())
        return cls(*(both / total if (total := int(of.sum())) else float("nan") for of in (called, there)))

    def __str__(self) -> str:
        """Both in words."""
        return f"precision {percent(self.precision)}, recall {percent(self.recall)}"


def percent(part: float) -> str:
    """A part, 0 to 1, in percent; a dash for NaN."""
    return "-" if np.isnan(part) else f"{100 * part:.1f} %"


def error_classes(called: npt.NDArray[np.bool_], there: npt.NDArray[np.bool_]) -> npt.NDArray[Any]:
    """Classes (H, W) of pixels, in the order of `ERROR_COLOURS`: right, wrong, missed, neither."""
    return np.select([called & there, called, there], [0, 1, 2], 3)


def legend(colour: str) -> Legend:
    """What the colours of labels mean, or those of errors in one colour."""
    if not colour:
        return Legend(dict(zip(LABELS, LABEL_COLOURS, strict=True)))
    words = (f"{colour}, and called so", f"called {colour}, but is not", f"{colour}, but missed", "neither")
    return Legend(dict(zip(words, ERROR_COLOURS, strict=True)))


@dataclass(frozen=True)
class ScoreTable:
    """Scores by colour, as a table on a page and a line each elsewhere."""

    scores: Mapping[str, PrecisionRecall]

    def __repr__(self) -> str:
        """A line each."""
        return "\n".join(f"{name}: {score}" for name, score in self.scores.items())

    def _repr_html_(self) -> str:
        """Precision and recall of each colour; dashes where there are none."""
        rows = []
        for name, colour in zip(COLOURS, LABEL_COLOURS[1:], strict=True):
            score = self.scores.get(name, PrecisionRecall(float("nan"), float("nan")))
            cells = "".join(f"<td>{percent(part)}</td>" for part in (score.precision, score.recall))
            rows.append(f'<tr><th scope="row">{colour_key(colour)}{name}</th>{cells}</tr>')
        head = '<th></th><th scope="col">Precision</th><th scope="col">Recall</th>'
        return f"<table><thead><tr>{head}</tr></thead><tbody>{''.join(rows)}</tbody></table>"
