"""The three wings of the project as a drawing: a box may import what stands below it and `exercises`."""

from __future__ import annotations

import ast
from io import BytesIO
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

ROOT = Path(__file__).resolve().parents[1]
COURSE, GRADER, SOURCES = "#2a6f97", "#9a3d3d", "#4f772d"
WINGS = {  # colour: title, left edge and width
    SOURCES: ("The lessons' sources", 0.0, 3.4),
    COURSE: ("The course: what students import", 4.6, 7.4),
    GRADER: ("The grader: nao_course/instructor", 13.2, 4.4),
}
# Colour, folder or module, what it holds, left, bottom, width, height.
BOXES: tuple[tuple[str, str, str, float, float, float, float], ...] = (
    (SOURCES, "solutions/NN_name.md", "text and solution", 0.2, 6.0, 3.0, 1.6),
    (SOURCES, "solutions/exercises", "cases, hints, mistakes", 0.2, 4.0, 3.0, 1.6),
    (COURSE, "student", "my_nao(), progress", 4.8, 8.0, 3.9, 0.8),
    (COURSE, "lessons", "a folder for each lesson", 4.8, 7.1, 3.9, 0.8),
    (COURSE, "challenges", "open tasks with a board", 4.8, 6.2, 3.9, 0.8),
    (COURSE, "widgets", "panels", 4.8, 5.3, 3.9, 0.8),
    (COURSE, "field_slam", "SLAM of the demo", 4.8, 4.4, 3.9, 0.8),
    (COURSE, "films", "moving maps", 4.8, 3.5, 1.9, 0.8),
    (COURSE, "plotting", "figures, alt texts", 6.8, 3.5, 1.9, 0.8),
    (COURSE, "datasets", "graphs, logs", 4.8, 2.6, 1.2, 0.8),
    (COURSE, "metrics", "errors, NEES", 6.15, 2.6, 1.2, 0.8),
    (COURSE, "robot", "a real NAO", 7.5, 2.6, 1.2, 0.8),
    (COURSE, "sim", "the simulated NAO", 4.8, 1.7, 3.9, 0.8),
    (COURSE, "homework", "packing a notebook", 9.0, 7.1, 2.8, 0.8),
    (COURSE, "exercises", "checks, comparisons,\nreading a notebook", 9.0, 1.7, 2.8, 5.3),
    (COURSE, "codec", "values as bytes", 4.8, 0.9, 7.0, 0.7),
    (COURSE, "_internal", "lazy imports, time limits", 4.8, 0.1, 7.0, 0.7),
    (GRADER, "commands", "grade, export ...", 13.4, 7.8, 1.9, 1.0),
    (GRADER, "similarity", "shared code", 15.5, 7.8, 1.9, 1.0),
    (GRADER, "autograding", "grades a class", 13.4, 6.3, 4.0, 1.3),
    (GRADER, "authoring", "builds lessons", 13.4, 4.6, 1.9, 1.5),
    (GRADER, "reports", "pages, exports", 15.5, 4.6, 1.9, 1.5),
    (GRADER, "collecting", "platforms' files", 13.4, 2.9, 1.9, 1.5),
    (GRADER, "gradebook", "journal, late days", 15.5, 2.9, 1.9, 1.5),
    (GRADER, "sandbox", "runs hostile code", 13.4, 1.2, 4.0, 1.5),
)
ROOMS = {name: (left, low, width, height) for _, name, _, left, low, width, height in BOXES}


def imported(folder: str) -> set[str]:
    """Return the parts of nao_course, such as "sim", that the Python files of a folder import."""
    names = set()
    for file in sorted((ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("nao_course"):
                names |= {f"{node.module}.{alias.name}".split(".")[1] for alias in node.names}
    return names & {*ROOMS, "instructor"}


def draw_house() -> bytes:
    """Return the drawing as a PNG."""
    figure = Figure(figsize=(11.5, 6.4), dpi=130, facecolor="white")
    axes = figure.add_axes((0.01, 0.01, 0.98, 0.98))
    axes.set(xlim=(-0.3, 17.9), ylim=(-0.5, 10.0))
    axes.axis("off")
    for colour, (title, left, width) in WINGS.items():
        axes.add_patch(Rectangle((left, 0), width, 9.1, color=colour, alpha=0.1))
        axes.text(left + width / 2, 9.4, title, ha="center", weight="bold", color=colour, fontsize=10.5)
    for colour, name, what, left, low, width, height in BOXES:
        axes.add_patch(Rectangle((left, low), width, height, facecolor="white", edgecolor=colour))
        centre = (left + width / 2, low + height / 2)
        axes.text(*centre, f"{name}\n{what}", ha="center", va="center", fontsize=7.5, linespacing=1.3)
    for part in sorted(imported("nao_course/instructor") - {"instructor"}):
        left, low, width, height = ROOMS[part]
        _arrow(axes, (13.2, low + height / 2), (left + width, low + height / 2))
    _arrow(axes, (3.2, 4.8), (4.6, 4.8))
    axes.plot([1.7, 1.7, 12.6, 12.6], [4.0, -0.1, -0.1, 4.9], color="#333", lw=1)
    _arrow(axes, (12.6, 4.9), (13.4, 4.9))
    _arrow(axes, (13.4, 5.7), (11.8, 5.7), style="--")
    axes.text(12.6, 5.85, "checks,\noutlines", ha="center", fontsize=7.5)
    axes.text(2.6, 0.05, "writes mistakes with", ha="center", fontsize=7.5)
    axes.text(4.0, 4.95, "declares\nwith", ha="center", fontsize=7.5)
    axes.text(
        8.8,
        -0.42,
        "solid: imports        dashed: files that `nao-course build` writes",
        ha="center",
        fontsize=8,
    )
    content = BytesIO()
    figure.savefig(content, format="png", metadata={"Software": None})
    return content.getvalue()


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], style: str = "-") -> None:
    axes.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": "#333", "linestyle": style})
