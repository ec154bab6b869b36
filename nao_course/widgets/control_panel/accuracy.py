"""The three numbers of the control panel: how far off an estimate is, how uncertain, and whether both fit."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from nao_course.geometry import FloatArray, Pose, pose_errors
from nao_course.metrics import band, squared_distances
from nao_course.slam import Estimate

PROBABILITY = 0.95  # of the ellipse, and of the band for the NEES
LEAST_VARIANCE = 1e-8  # m^2 or rad^2: a smaller one belongs to a value that is known or not estimated
LEAST_LENGTH = 0.005  # m: a shorter one is shown as "< 1 cm"
_CIRCLE = float(-2 * np.log(1 - PROBABILITY))  # squared radius of a standard normal's circle, two dimensions

Verdict = Literal["", "consistent", "overconfident", "underconfident"]
_SIZES: Mapping[str, str] = {
    "consistent": "as large as",
    "overconfident": "larger than",
    "underconfident": "smaller than",
}


@dataclass(frozen=True)
class Accuracy:
    """The accuracy of an estimated pose: the distance from the true position, m, and the NEES of its `degrees` values.

    `radius` is the longest half axis of the position's 95 % ellipse, m. Each is None if it cannot be computed or the
    truth is hidden; values without a variance do not count. `worst` names the axis whose error is largest in units of
    its standard deviation, with both: the error may be shorter than the longest half axis and still be too large.
    """

    error: float | None = None
    radius: float | None = None
    nees: float | None = None
    degrees: int = 0
    worst: str = ""

    @property
    def bounds(self) -> tuple[float, float]:
        """The 95 % band for the NEES of one consistent estimate."""
        return band(self.degrees, 1, PROBABILITY)

    @property
    def verdict(self) -> Verdict:
        """Whether error and covariance fit together; empty if this is unknown."""
        if self.nees is None:
            off = self.radius == 0.0 and self.error is not None and self.error >= LEAST_LENGTH
            return "overconfident" if off else ""
        low, high = self.bounds
        return "overconfident" if self.nees > high else "underconfident" if self.nees < low else "consistent"


def accuracy(estimate: Estimate | Pose, truth: Pose | None) -> Accuracy:
    """Return the accuracy of an estimate, or of a pose without a covariance, in world coordinates.

    The truth is None if it must not be shown.
    """
    pose = estimate if isinstance(estimate, Pose) else estimate.pose
    errors = None if truth is None else pose_errors(pose.as_array(), truth.as_array())
    error = None if errors is None else float(np.hypot(*errors[:2]))
    if isinstance(estimate, Pose) or not _is_covariance(estimate.covariance):
        return Accuracy(error)
    covariance = estimate.covariance
    radius = float(np.sqrt(_CIRCLE * max(np.linalg.eigvalsh(covariance[:2, :2])[-1], 0.0)))
    uncertain = np.diag(covariance) > LEAST_VARIANCE
    degrees = int(uncertain.sum())
    if not degrees:
        return Accuracy(error, 0.0)
    if errors is None:
        return Accuracy(error, radius)
    try:
        nees = float(
            squared_distances(errors[None, uncertain], covariance[np.ix_(uncertain, uncertain)][None])[0]
        )
    except np.linalg.LinAlgError:  # two values depend on each other exactly
        return Accuracy(error, radius)
    if nees < 0:
        return Accuracy(error, radius)
    return Accuracy(error, radius, nees, degrees, _worst_axis(errors, covariance, pose.theta))


def _worst_axis(errors: FloatArray, covariance: FloatArray, heading: float) -> str:
    """Return the errors' worst axis, with its error and what is claimed there; empty if no axis alone is too large."""
    variances, axes = np.linalg.eigh(covariance[:2, :2])
    along = np.abs(axes.T @ (np.cos(heading), np.sin(heading))) > np.sqrt(0.5)
    off = [*np.abs(axes.T @ errors[:2]), abs(errors[2])]
    half = np.sqrt(_CIRCLE * np.maximum([*variances, covariance[2, 2]], 0.0))
    ratios = [
        error / size if size**2 > _CIRCLE * LEAST_VARIANCE else 0.0
        for error, size in zip(off, half, strict=True)
    ]
    worst = int(np.argmax(ratios))
    if ratios[worst] < 1:
        return ""
    if worst == 2:
        error, claimed, where = f"{np.degrees(off[2]):.0f}°", f"{np.degrees(half[2]):.1f}°", "of heading"
    else:
        error, claimed = say_length(off[worst]), say_length(half[worst])
        where = "along the heading" if along[worst] else "across the heading"
    return f"{error} {where}, where ± {claimed} is claimed".replace("± <", "<")


def _is_covariance(matrix: FloatArray) -> bool:
    if not np.isfinite(matrix).all():
        return False
    return bool(np.linalg.eigvalsh((matrix + matrix.T) / 2)[0] > -LEAST_VARIANCE)


def say_length(metres: float) -> str:
    """Return a length in centimetres, or from a metre on in metres.

    >>> say_length(0.034), say_length(0.002), say_length(1.342)
    ('3 cm', '< 1 cm', '1.34 m')
    """
    if metres >= 0.995:
        return f"{metres:.2f} m"
    return "< 1 cm" if metres < LEAST_LENGTH else f"{100 * metres:.0f} cm"


def numbers_html(shown: Accuracy, has_truth: bool, estimated: bool) -> str:
    """Return three tiles: the error, the uncertainty, and whether they are consistent.

    With `has_truth`, the reader may choose to show the truth; unless `estimated`, the pose is the odometry's.
    """
    hidden = "tick Show the truth" if has_truth else "this panel has no truth"
    whose = "estimate" if estimated else "odometry"
    off = ("–", hidden) if shown.error is None else (say_length(shown.error), f"{whose} to true position")
    if shown.radius is None:
        uncertain = ("–", "not a valid covariance" if estimated else "no estimate yet")
    elif shown.radius == 0.0:
        uncertain = ("0 cm", "claims to be exact")
    else:
        uncertain = (f"± {say_length(shown.radius)}".replace("± <", "<"), "half axis, 95 % ellipse")
    why = hidden if shown.error is None else "nothing to compare yet"
    title = ""
    if shown.nees is not None:
        low, high = shown.bounds
        why = f"error {_SIZES[shown.verdict]} the ellipse says; NEES {_digits(shown.nees)}"
        if shown.verdict == "overconfident" and shown.worst:
            why = f"{shown.worst}; NEES {_digits(shown.nees)}"
        title = (
            f"NEES, the normalised estimation error squared, measures the error in units of the estimated covariance. "
            f"Here 95 % of consistent estimates have a NEES from {low:.1f} to {high:.1f}."
        )
    elif shown.verdict:
        why = "is off, but claims to be exact"
    fits = (shown.verdict or "–", why)
    good = {"consistent": " nao-good", "": ""}.get(shown.verdict, " nao-bad")
    return (
        _tile("How far off?", *off)
        + _tile("How uncertain?", *uncertain)
        + _tile("Consistent?", *fits, kind=good, title=title)
    )


def _digits(value: float) -> str:
    return f"{value:.1f}" if value < 100 else f"{value:.3g}" if value < 1000 else "over 1000"


def _tile(question: str, answer: str, more: str, kind: str = "", title: str = "") -> str:
    return (
        f'<div class="nao-tile{kind}" title="{html.escape(title)}"><span>{question}</span><b>{html.escape(answer)}</b>'
        f"<small>{html.escape(more)}</small></div>"
    )
