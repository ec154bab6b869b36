"""Three bugs in a predicted covariance: two transposes on the wrong side, and noise that is not rotated."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_derivations.figures import ESTIMATE, cloud_keys, plot_cloud
from nao_course.lessons.ekf_derivations.samples import motion_cloud, propagated
from nao_course.plotting import Drawing, course_style, ellipse_outlines
from nao_course.plotting.legends import legend_below

Function = Callable[..., Any]

BUG_POSE = np.diag([0.03, 0.03, np.radians(2)]) ** 2  # m, m, rad
BUG_NOISE = np.diag([0.3, 0.06, 0.05]) ** 2  # along, across (m) and turn (rad)
BUG_DRIVE = np.array([1.5, 0.0])  # m, rad
BUG_STEP, BUG_STEPS = np.array([0.3, 0.0]), 12  # of the drive in several steps
HEADINGS = np.radians(np.arange(0, 181, 3))
STEP_ERRORS = np.diag([0.03, 0.02, np.radians(2)]) ** 2  # of each step
BUGS = {  # colour, line style and line width of each
    "FᵀPF": ("#c84b00", "--", 2.0),
    "noise not rotated": ("#6b7280", (0, (6, 1.5, 1.5, 1.5)), 3.5),
    "GᵀQG": ("#a14566", (0, (1.2, 1.2)), 2.0),
}


class Predictions:
    """The covariance that the student's functions predict, right or with one of `BUGS`.

    The bugs are built from the student's own functions: Gᵀ is G at -theta, and noise that is not rotated is G at 0.
    """

    def __init__(self, motion_jacobians: Function, predict_covariance: Function) -> None:
        self._jacobians, self._predict = motion_jacobians, predict_covariance

    def right(
        self, covariance: FloatArray, theta: float, control: FloatArray, noise: FloatArray
    ) -> FloatArray:
        """Return the covariance (3, 3) after a motion from a heading (rad)."""
        given = covariance.copy(), np.array([0.0, 0.0, theta]), control.copy(), noise.copy()
        return np.asarray(self._predict(*given), dtype=float)

    def wrong(
        self, bug: str, covariance: FloatArray, theta: float, control: FloatArray, noise: FloatArray
    ) -> FloatArray:
        """Return the covariance (3, 3) after the same motion, with a bug."""
        nothing = np.zeros((3, 3))
        if bug == "FᵀPF":
            by_pose = np.asarray(self._jacobians(np.array([0.0, 0.0, theta]), control.copy())[0], dtype=float)
            return propagated(by_pose.T, covariance) + self.right(nothing, theta, control, noise)
        turned = -theta if bug == "GᵀQG" else 0.0
        return self.right(covariance, theta, control, nothing) + self.right(nothing, turned, control, noise)

    def off(self, bug: str, headings: FloatArray) -> FloatArray:
        """Return the error of a bug at each heading (rad), as `wrong_by` measures it."""
        cases = [(BUG_POSE, float(theta), BUG_DRIVE, BUG_NOISE) for theta in headings]
        return np.array([wrong_by(self.right(*case), self.wrong(bug, *case)) for case in cases])

    def across(self, bug: str, theta: float) -> FloatArray:
        """Return the cross-track standard deviations (BUG_STEPS + 1,) (m) of a drive in steps; "" means no bug."""
        covariance, side = BUG_POSE, np.array([-np.sin(theta), np.cos(theta)])
        sigmas = [np.sqrt(side @ covariance[:2, :2] @ side)]
        for _ in range(BUG_STEPS):
            given = covariance, theta, BUG_STEP, STEP_ERRORS
            covariance = self.wrong(bug, *given) if bug else self.right(*given)
            sigmas.append(np.sqrt(side @ covariance[:2, :2] @ side))
        return np.array(sigmas)


def wrong_by(right: FloatArray, wrong: FloatArray) -> float:
    """Return the largest factor by which a standard deviation of the position is off, minus 1."""
    half = np.linalg.inv(np.linalg.cholesky(right[:2, :2]))
    factors = np.sqrt(np.linalg.eigvalsh(half @ wrong[:2, :2] @ half.T))
    return float(max(factors.max(), 1 / factors.min()) - 1)


@course_style()
def draw_bug_hunt(
    predict_pose: Function, motion_jacobians: Function, predict_covariance: Function
) -> Drawing:
    """Draw the predictions of three wrong formulas: at one heading, at all headings, and step after step.

    Returns
    -------
    Drawing
        The figure; its text has the error of each formula.
    """
    theta, way = np.radians(30), BUG_STEP[0] * np.arange(BUG_STEPS + 1)
    predictions = Predictions(motion_jacobians, predict_covariance)
    rng = np.random.default_rng(6)
    start = (0.0, 0.0, theta)
    cloud = motion_cloud(predict_pose, predict_covariance, start, BUG_POSE, BUG_DRIVE, BUG_NOISE, rng)
    own = 100 * predictions.across("", theta)
    said = []
    figure = Figure(figsize=(9.9, 4.1))
    ellipses, curves, drive = figure.subplots(1, 3, width_ratios=(1.25, 1, 1))
    plot_cloud(cloud, ellipses)
    drive.plot(way, own, color=ESTIMATE.colour, lw=9, alpha=0.35)
    for bug, (colour, line, width) in BUGS.items():
        wrong = predictions.wrong(bug, BUG_POSE, theta, BUG_DRIVE, BUG_NOISE)
        off, across = 100 * predictions.off(bug, HEADINGS), 100 * predictions.across(bug, theta)
        ellipses.plot(
            *ellipse_outlines(cloud.mean, wrong[None, :2, :2])[0].T, color=colour, ls=line, lw=width
        )
        curves.plot(np.degrees(HEADINGS), off, color=colour, ls=line, lw=width)
        drive.plot(way, across, color=colour, ls=line, lw=width)
        said.append(
            f"{bug}: a standard deviation wrong by {np.interp(theta, HEADINGS, off):.0f} % at 30 degrees and by up "
            f"to {off.max():.0f} %, {across[-1]:.0f} cm across after {way[-1]:.1f} m"
        )
    ellipses.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
    ellipses.set_title("1.5 m, heading 30°", fontsize=11)
    curves.set(xlabel="heading (degrees)", xticks=range(0, 181, 45), ylim=0)
    curves.set_title("Largest error of a σ (%)", fontsize=11)
    drive.set(xlabel="distance driven (m)", ylim=0)
    drive.set_title("cross-track σ at 30° (cm)", fontsize=11)
    lines = [Line2D([], [], color=c, ls=line, lw=width, label=bug) for bug, (c, line, width) in BUGS.items()]
    lines.insert(0, Line2D([], [], color=ESTIMATE.colour, lw=9, alpha=0.35, label="your prediction"))
    legend_below(figure, [*cloud_keys(), *lines])
    return Drawing(
        figure,
        f"Your ellipse holds {100 * cloud.inside():.0f} % of the samples and predicts {own[-1]:.0f} cm across after "
        f"{way[-1]:.1f} m. {'; '.join(said)}. GᵀQG is right at 0, 90 and 180 degrees and worst at 45 and 135; noise "
        "that is not rotated is right at 0 and 180; FᵀPF is equally wrong at every heading.",
    )
