"""The three numbers of the control panel: how far off an estimate is, how uncertain, and whether both fit."""

from __future__ import annotations

import html
from dataclasses import dataclass
from statistics import NormalDist
from typing import Literal

import numpy as np

from nao_course.geometry import FloatArray, Pose, pose_errors
from nao_course.metrics import band, squared_distances
from nao_course.slam import Estimate
from nao_course.widgets.vector_map import ShortAxis

PROBABILITY = 0.95  # of the ellipse, and of the band for the NEES
LEAST_VARIANCE = 1e-8  # m^2 or rad^2: a smaller one belongs to a value that is known or not estimated
LEAST_LENGTH = 0.005  # m: a shorter one is shown as "< 1 cm"
_CIRCLE = float(-2 * np.log(1 - PROBABILITY))  # squared radius of a standard normal's circle, two dimensions
_INTERVAL = NormalDist().inv_cdf((1 + PROBABILITY) / 2)  # half of its interval, one dimension

Verdict = Literal["", "consistent", "overconfident", "underconfident"]


@dataclass(frozen=True)
class Accuracy:
    """The accuracy of an estimated pose: the distance from the true position, m, and the NEES of its `degrees` values.

    `radius` is the longest half axis of the position's 95 % ellipse, m. Each is None if it cannot be computed or the
    truth is hidden; values without a variance do not count. `is_outside` says whether the position is outside its
    ellipse, and `short` is the axis that is too small: the error may be shorter than the longest half axis and still be
    too large.
    """

    error: float | None = None
    radius: float | None = None
    nees: float | None = None
    degrees: int = 0
    is_outside: bool = False
    short: ShortAxis | None = None

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
    is_outside = _ratio(_own_axis(errors, covariance)) > 1
    return Accuracy(error, radius, nees, degrees, is_outside, _short_axis(errors, covariance, pose.theta))


def _short_axis(errors: FloatArray, covariance: FloatArray, heading: float) -> ShortAxis | None:
    """Return the axis, or the heading, whose error exceeds what is claimed by the largest factor.

    If each axis alone is large enough, but the position is outside the ellipse, the axis is the error's own direction.
    None if the position is inside the ellipse and the heading inside its interval.
    """
    half = float(_INTERVAL * np.sqrt(max(covariance[2, 2], 0.0)))
    found = [ShortAxis("of heading", heading, half, float(-errors[2]), is_heading=True)]
    variances, axes = np.linalg.eigh(covariance[:2, :2])
    for variance, axis in zip(variances, axes.T, strict=True):
        is_along = abs(axis @ (np.cos(heading), np.sin(heading))) > np.sqrt(0.5)
        name = "along the heading" if is_along else "across the heading"
        found.append(_position_axis(name, axis, np.sqrt(_CIRCLE * max(variance, 0.0)), errors))
    worst = max(found, key=_ratio)
    if _ratio(worst) <= 1:
        worst = _own_axis(errors, covariance)
    return worst if _ratio(worst) > 1 else None


def _position_axis(name: str, axis: FloatArray, claimed: float, errors: FloatArray) -> ShortAxis:
    """Return an axis (2,) of the position's ellipse, turned toward the true position."""
    off = float(-errors[:2] @ axis)
    toward = axis if off > 0 else -axis
    return ShortAxis(name, float(np.arctan2(toward[1], toward[0])), float(claimed), abs(off))


def _own_axis(errors: FloatArray, covariance: FloatArray) -> ShortAxis:
    """Return the position's error in its own direction, beside the ellipse's extent there; 0 if that is unknown."""
    distance, block = np.hypot(*errors[:2]), covariance[:2, :2]
    if distance == 0 or np.linalg.eigvalsh(block)[0] <= LEAST_VARIANCE:
        return _position_axis("in its direction", np.array([1.0, 0.0]), 0.0, errors)
    own = errors[:2] / distance
    return _position_axis(
        "in its direction", own, np.sqrt(_CIRCLE / (own @ np.linalg.solve(block, own))), errors
    )


def _ratio(axis: ShortAxis) -> float:
    """Return an axis' error divided by what is claimed; 0 for a value that is known or not estimated."""
    return abs(axis.error) / axis.claimed if axis.claimed**2 > _INTERVAL**2 * LEAST_VARIANCE else 0.0


def _say_short(short: ShortAxis) -> str:
    """Say which axis is too small, with enough digits to show that the error is larger than what is claimed.

    >>> _say_short(ShortAxis("along the heading", 0.0, 0.012, 0.014))
    '1.4 cm along the heading, where ± 1.2 cm is claimed'
    """
    if short.is_heading:
        factor, unit, digits = 180 / np.pi, "°", 1
    else:
        factor, unit, digits = (1.0, " m", 2) if short.error >= 0.995 else (100.0, " cm", 0)
    error, claimed = factor * abs(short.error), factor * short.claimed
    while float(f"{claimed:.{digits}f}") == 0 or f"{error:.{digits}f}" == f"{claimed:.{digits}f}":
        digits += 1
    return f"{error:.{digits}f}{unit} {short.name}, where ± {claimed:.{digits}f}{unit} is claimed"


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


def numbers_html(shown: Accuracy, hidden: str, estimated: bool) -> str:
    """Return three tiles: the error, the uncertainty, and whether they are consistent.

    `hidden` says how to see an error that is not known; unless `estimated`, the pose is the odometry's.
    """
    whose = "estimate" if estimated else "odometry"
    off = ("–", hidden) if shown.error is None else (say_length(shown.error), f"{whose} to true position")
    if shown.radius is None:
        uncertain = ("–", "not a valid covariance" if estimated else "no estimate yet")
    elif shown.radius == 0.0:
        uncertain = ("0 cm", "claims to be exact")
    else:
        uncertain = (f"± {say_length(shown.radius)}".replace("± <", "<"), "half axis, 95 % ellipse")
    why = hidden if shown.error is None else "nothing to compare yet"
    title = "An estimate is consistent if its error fits its uncertainty."
    if shown.nees is not None:
        low, high = shown.bounds
        why = f"{_why(shown)}; NEES {_digits(shown.nees)}"
        title += (
            f" {why[:1].upper()}{why[1:]}. NEES, the normalised estimation error squared, measures the error in units "
            f"of the estimated covariance. Here 95 % of consistent estimates have a NEES from {low:.1f} to {high:.1f}."
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


def _why(shown: Accuracy) -> str:
    """Say why an estimate has its verdict, so that this does not seem to contradict the other two numbers."""
    if shown.verdict == "overconfident":
        return _say_short(shown.short) if shown.short else "position and heading do not fit together"
    if shown.verdict == "underconfident":
        return "error smaller than the ellipse says"
    return "outside the ellipse, as 1 of 20 is" if shown.is_outside else "error inside the ellipse"


def _digits(value: float) -> str:
    return f"{value:.1f}" if value < 100 else f"{value:.3g}" if value < 1000 else "over 1000"


def _tile(question: str, answer: str, more: str, kind: str = "", title: str = "") -> str:
    return (
        f'<div class="nao-tile{kind}" title="{html.escape(title)}"><span>{question}</span><b>{html.escape(answer)}</b>'
        f"<small>{html.escape(more)}</small></div>"
    )
