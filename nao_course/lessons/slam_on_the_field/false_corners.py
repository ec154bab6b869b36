"""Figure of recorded drives with false corners: how many are lost, and how many end outside of their own ellipse."""

from __future__ import annotations

import json
from pathlib import Path

from matplotlib.figure import Figure

from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.style import GREY, Style

RECORDED = Path(__file__).with_suffix(".json")  # written by the benchmark field_false
CONSISTENT = 5.0  # % of consistent poses are outside of their 95 % ellipse
_EKF = STYLES["ekf"]
_LINES = {
    "surest first": Style("your filter", _EKF.colour, _EKF.marker, _EKF.line),
    "joint update": Style("joint update", STYLES["graph"].colour, "D", (0, (1.2, 1.2))),
    "several hypotheses": Style("several hypotheses", STYLES["truth"].colour, "o", "-"),
    "Monte Carlo, known map": Style("Monte Carlo, known map", GREY, "x", ":"),
    "gated EKF, known map": Style("gated EKF, known map", STYLES["odometry"].colour, "s", (0, (5, 2))),
}


@course_style()
def draw_false_corners() -> Drawing:
    """Draw the shares of lost and of overconfident drives over the number of false corners in a picture."""
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))
    figure, said = Figure(figsize=(10.2, 4.0)), []
    axes = figure.subplots(1, 2)
    for name, style in _LINES.items():
        of = recorded["algorithms"][name]
        lost, outside = ([100 * each for each in of[share]] for share in ("lost", "outside"))
        for ax, values in zip(axes, (lost, outside), strict=True):
            ax.plot(
                recorded["false corners"], values, color=style.colour, marker=style.marker, ls=style.line, lw=2,
                label=style.label,
            )  # fmt: skip
        said.append(
            f"{style.label} {lost[0]:.1f} % to {lost[-1]:.1f} %, and {outside[0]:.0f} % to {outside[-1]:.0f} %"
        )
    axes[1].axhline(CONSISTENT, color=GREY, lw=1)
    last = recorded["false corners"][-1]
    axes[1].annotate(
        "consistent",
        (last, CONSISTENT),
        (0, 3),
        textcoords="offset points",
        ha="right",
        color=GREY,
        fontsize=9,
    )
    for ax, label in zip(
        axes, ("lost: more than 15 cm off (%)", "outside of their 95 % ellipse (%)"), strict=True
    ):
        ax.set(xlabel="false corners in a picture (mean)", ylabel=f"drives {label}", ylim=(0, None))
    axes[0].legend()
    return Drawing(
        figure,
        f"Of {recorded['drives']} drives, shares that are lost, and that end outside of their 95 % ellipse, with "
        f"0 to {last:g} false corners in a picture: {'; '.join(said)}.",
    )
