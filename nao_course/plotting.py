"""Figures of the course: maps of the field, paths, estimates with their ellipses, and pictures.

Verbs that begin with ``plot_`` add to an axis; verbs that begin with ``draw_`` need one line and give a
finished `Drawing`. Nothing here touches pyplot, so no figure shows twice and none stays in memory.
"""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import matplotlib
import matplotlib.style
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap, hsv_to_rgb, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Arc, Circle, Ellipse, FancyArrowPatch, Patch, Rectangle, Wedge
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Affine2D
from scipy.stats import chi2

from nao_course.geometry import FloatArray, Pose, as_points
from nao_course.sim import LABELS, NAO_V4, CameraView, Field, Landmark, Picture, SimulatedNao, VisibleLandmark
from nao_course.slam import Estimate, Measurement

if TYPE_CHECKING:
    from matplotlib.artist import Artist

PathLike = Pose | Sequence[Pose] | npt.ArrayLike


@dataclass(frozen=True)
class Style:
    """How one source of poses looks, in every figure of the course.

    Parameters
    ----------
    label : str
        Its name in legends.
    colour : str
        Told apart also by readers with a colour vision deficiency, and by its lightness.
    marker, line : str or tuple
        Matplotlib's marker and line style; each source has its own, for black and white print.
    """

    label: str
    colour: str
    marker: str
    line: Any


# After Okabe and Ito (2008) and Tol (2021); tests/plotting/test_plotting.py measures them for three kinds of vision.
STYLES: Mapping[str, Style] = MappingProxyType(
    {
        "truth": Style("truth", "#1a1a1a", "o", "-"),
        "odometry": Style("odometry", "#c84b00", "s", (0, (5, 2))),
        "ekf": Style("EKF", "#0b5fa5", "^", (0, (7, 1.5, 1, 1.5))),
        "graph": Style("graph", "#a14566", "D", (0, (1.2, 1.2))),
    }
)
LANDMARK_MARKERS: Mapping[str, str] = MappingProxyType({"corner": "P", "post": "o", "cross": "x"})

_CARPET, _LINE, _YELLOW, _GREY = "#b5d1ac", "#ffffff", "#f0c419", "#6b7280"
LABEL_COLOURS = ("#4b4b55", "#3f9b55", "#f2c413", "#ffffff")  # other, green, yellow, white
_HALO = [withStroke(linewidth=2.5, foreground="white", alpha=0.8)]
_OWN_STYLE = {
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same letters on every machine
    "font.size": 10.5,
    "axes.titlesize": 12,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "legend.fontsize": 10,
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "nao_course",
}


@contextmanager
def course_style() -> Iterator[None]:
    """Matplotlib's settings for the course's figures, whatever the reader's own are."""
    with matplotlib.style.context(["default", _OWN_STYLE]):
        yield


@dataclass(frozen=True, eq=False)
class Drawing:
    """A finished figure and what it shows in words.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure; add to it if you like.
    alt : str
        Its contents for a reader who cannot see it.
    photo : bool
        Whether it holds camera pictures: in a notebook these are small as JPEG and large as PNG.
    """

    figure: Figure
    alt: str
    photo: bool = False

    def __post_init__(self) -> None:
        """Lay the figure out once and for all: matplotlib's layout goes on moving at every drawing."""
        with course_style():
            self.figure.draw_without_rendering()
            self.figure.set_layout_engine("none")

    def image(self, kind: str = "png") -> bytes:
        """Return the figure as a "png", "jpeg" or "svg" file; the same figure gives the same bytes."""
        options: dict[str, dict[str, Any]] = {
            "png": {"metadata": {"Software": None}},
            "svg": {"metadata": {"Date": None, "Creator": None}},
            "jpeg": {"pil_kwargs": {"quality": 88, "subsampling": 0, "optimize": True}},
        }
        if kind not in options:
            raise ValueError(f"a drawing can be made into {', '.join(options)}; got {kind!r}")
        buffer = io.BytesIO()
        with course_style():
            self.figure.savefig(buffer, format=kind, dpi=100, **options[kind])
        return buffer.getvalue()

    def save(self, path: str | Path) -> Path:
        """Write the figure to a file; its suffix (.png, .jpeg or .svg) says how.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ValueError
            For another suffix.
        """
        path = Path(path)
        kind = path.suffix.lower().lstrip(".").replace("jpg", "jpeg")
        path.write_bytes(self.image(kind))
        return path

    def __repr__(self) -> str:
        """Say what the figure shows."""
        return f"Drawing({self.alt!r})"

    def _repr_html_(self) -> str:
        """Show the figure in a notebook, with its text for screen readers."""
        kind = "jpeg" if self.photo else "png"
        return image_tag(self.image(kind), self.alt, kind)


def image_tag(data: bytes, alt: str, kind: str) -> str:
    """HTML of a picture that needs no file; `kind` is "png" or "jpeg"."""
    encoded = base64.b64encode(data).decode("ascii")
    source = f"data:image/{kind};base64,{encoded}"
    return f'<img alt="{html.escape(alt, quote=True)}" style="max-width: 100%" src="{source}">'


@dataclass(frozen=True)
class Table:
    """A few values in rows and columns, for a reader: an HTML table in a notebook, lines of text elsewhere.

    Parameters
    ----------
    columns : tuple of str
        Their heads.
    rows : tuple of tuple of str
        As many cells each.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __repr__(self) -> str:
        """The same in lines, columns below each other."""
        lines = (self.columns, *self.rows)
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        return "\n".join(
            "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
            for line in lines
        )

    def _repr_html_(self) -> str:
        """A table whose first column names its rows."""

        def cell(tag: str, text: str, number: int) -> str:
            side = "left" if number == 0 else "right"
            return f'<{tag} style="text-align: {side}; padding: 0.15em 0.8em">{html.escape(text)}</{tag}>'

        head = "".join(cell("th", text, number) for number, text in enumerate(self.columns))
        body = "".join(
            f"<tr>{''.join(cell('td', text, number) for number, text in enumerate(row))}</tr>"
            for row in self.rows
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> Table:
    """Set values in a table.

    Parameters
    ----------
    columns : sequence of str
        Their heads.
    rows : iterable of sequences
        As many values each; they are shown as `str` gives them.

    Returns
    -------
    Table
        To be a cell's last line.

    Raises
    ------
    ValueError
        If a row has another number of values than there are columns.
    """
    texts = tuple(tuple(str(value) for value in row) for row in rows)
    for number, row in enumerate(texts, start=1):
        if len(row) != len(columns):
            raise ValueError(f"row {number} has {len(row)} values for {len(columns)} columns")
    return Table(tuple(columns), texts)


# --- values in, arrays and words out ---


def style_of(source: str) -> Style:
    """Return the style of "truth", "odometry", "ekf" or "graph"; another name is a ValueError."""
    if source not in STYLES:
        raise ValueError(f"source must be one of {', '.join(map(repr, STYLES))}, got {source!r}")
    return STYLES[source]


def as_path(poses: PathLike, name: str = "path") -> FloatArray:
    """Poses in any of the shapes they come in, as one array.

    Parameters
    ----------
    poses : Pose, sequence of Pose, or array_like of shape (N, 2) or (N, 3)
        Positions in metres and, in a third column, headings in radians.
    name : str
        What they are, for the message.

    Returns
    -------
    ndarray, shape (N, 3)
        x, y, theta; theta is NaN where no heading was given.

    Raises
    ------
    ValueError
        If it is none of these.
    """
    if isinstance(poses, Pose):
        return poses.as_array()[None]
    values: Any = poses
    if isinstance(values, Sequence) and any(isinstance(pose, Pose) for pose in values):
        values = [pose.as_array() if isinstance(pose, Pose) else pose for pose in values]
    try:
        array = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        array = np.empty((1, 1))
    if array.size == 0:
        return np.empty((0, 3))
    if array.ndim != 2 or array.shape[1] not in (2, 3):
        raise ValueError(
            f"{name} must be poses or an array of shape (N, 2) or (N, 3) in metres; got {poses!r:.80}"
        )
    if array.shape[1] == 2:
        array = np.column_stack([array, np.full(len(array), np.nan)])
    return array


def ellipse_outlines(
    centres: npt.ArrayLike, covariances: npt.ArrayLike, probability: float = 0.95, corners: int = 49
) -> FloatArray:
    """Outlines of the regions that hold a given part of Gaussian distributions in the plane.

    A circle is pushed through the covariance's square root, which for two by two has a closed form.

    Parameters
    ----------
    centres : array_like, shape (N, 2)
        Means in metres.
    covariances : array_like, shape (N, 2, 2)
        In m^2.
    probability : float
        Part inside, between 0 and 1.
    corners : int
        Points of each outline, the last being the first again.

    Returns
    -------
    ndarray, shape (N, corners, 2)
        NaN for a matrix that is no covariance: not finite, not symmetric, or with a negative variance.

    Raises
    ------
    ValueError
        If the shapes do not fit, or `probability` is no probability.
    """
    if not 0 < probability < 1:
        raise ValueError(f"probability must be between 0 and 1, such as 0.95; got {probability}")
    middle = as_points(centres, name="centres")
    matrices = np.asarray(covariances, dtype=float).reshape(-1, 2, 2)
    if len(matrices) != len(middle):
        raise ValueError(f"{len(middle)} centres need covariances of shape ({len(middle)}, 2, 2)")
    with np.errstate(all="ignore"):
        trace = matrices[:, 0, 0] + matrices[:, 1, 1]
        tolerance = 1e-9 * np.maximum(trace, 1e-300) ** 2
        determinant = matrices[:, 0, 0] * matrices[:, 1, 1] - matrices[:, 0, 1] * matrices[:, 1, 0]
        sound = np.isfinite(matrices).all(axis=(1, 2)) & (np.diagonal(matrices, axis1=1, axis2=2) >= 0).all(
            axis=1
        )
        sound &= (determinant >= -tolerance) & (
            np.abs(matrices[:, 0, 1] - matrices[:, 1, 0]) ** 2 <= tolerance
        )
        s = np.sqrt(np.maximum(determinant, 0))
        roots = (matrices + s[:, None, None] * np.eye(2)) / np.sqrt(np.maximum(trace + 2 * s, 1e-300))[
            :, None, None
        ]
    angle = np.linspace(0, 2 * np.pi, corners)
    circle = np.sqrt(chi2.ppf(probability, 2)) * np.array([np.cos(angle), np.sin(angle)])
    outlines = middle[:, None] + np.swapaxes(roots @ circle, 1, 2)
    outlines[~sound] = np.nan
    return np.asarray(outlines)


def _degrees(angle: float) -> str:
    return f"{np.degrees(angle):.0f} deg"


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}" + ("" if number == 1 else "s")


def _say_place(pose: FloatArray) -> str:
    heading = "" if np.isnan(pose[2]) else f", heading {_degrees(pose[2])}"
    return f"({pose[0]:.2f}, {pose[1]:.2f}) m{heading}"


def _say_path(label: str, path: FloatArray) -> str:
    if not len(path):
        return f"{label}: no poses."
    if len(path) == 1:
        return f"{label}: at {_say_place(path[0])}."
    return f"{label}: {len(path)} poses from {_say_place(path[0])} to {_say_place(path[-1])}."


def _say_kinds(kinds: Iterable[str]) -> str:
    names = list(kinds)
    return " and ".join(_count(names.count(kind), kind) for kind in dict.fromkeys(names)) or "none"


def _say_field(field: Field) -> str:
    part = "the half field" if field.half else "the field"
    return f"{part} by the rules of {field.year}, x towards the goal, y to the left"


# --- onto an axis ---


def _in_world(pose: Pose, ax: Axes) -> Any:
    """Transform for what is given in a pose's own frame."""
    return Affine2D().rotate(pose.theta).translate(pose.x, pose.y) + ax.transData


def _strips(lines: FloatArray, width: float) -> Iterator[Rectangle]:
    """Lines (N, 4) of a field, parallel to an axis, as rectangles of their true width."""
    for x1, y1, x2, y2 in lines:
        low = np.minimum([x1, y1], [x2, y2]) - width / 2
        size = np.abs([x2 - x1, y2 - y1]) + width
        yield Rectangle((float(low[0]), float(low[1])), float(size[0]), float(size[1]))


def plot_field(field: Field, ax: Axes, landmarks: bool = False) -> None:
    """Draw a field from above, its lines at their true width.

    Parameters
    ----------
    field : Field
        What to draw; it lies where ``field.pose`` puts it.
    ax : matplotlib Axes
        In metres; its limits become the carpet's.
    landmarks : bool
        Mark the corners and posts, too.
    """
    d = field.dimensions
    frame = _in_world(field.pose, ax)
    x0, y0, x1, y1 = field.carpet

    def add(patch: Patch, colour: str, order: float) -> None:
        patch.set(facecolor=colour, edgecolor="none", zorder=order, transform=frame)
        ax.add_patch(patch)

    add(Rectangle((x0, y0), x1 - x0, y1 - y0), _CARPET, 0.1)
    for strip in _strips(np.vstack([field.lines, field.mark_lines]), d.line_width):
        add(strip, _LINE, 0.2)
    for x, y, radius, first, last in field.arcs:
        ring = Wedge(
            (x, y), radius + d.line_width / 2, np.degrees(first), np.degrees(last), width=d.line_width
        )
        add(ring, _LINE, 0.2)
    goal = _YELLOW if d.goal_colour == "yellow" else "#d9dde3"
    for bar in field.bars:
        ax.plot(bar[:, 0], bar[:, 1], color=goal, lw=3, transform=frame, zorder=0.3, solid_capstyle="butt")
    for x, y in field.posts:
        post = Circle((x, y), d.post_diameter / 2 + 0.02)
        add(post, goal, 0.4)
        post.set(edgecolor="#6d5600" if d.goal_colour == "yellow" else _GREY, linewidth=0.9)
    if landmarks:
        known = [mark for mark in field.landmarks if mark.kind != "cross"]
        positions = field.pose.to_parent([(mark.x, mark.y) for mark in known])
        plot_landmarks(positions, [mark.kind for mark in known], ax, colour=_GREY, size=5)
    corners = field.pose.to_parent([(x, y) for x in (x0, x1) for y in (y0, y1)])
    _metres(ax, corners)


def _metres(ax: Axes, around: FloatArray, margin: float = 0.0) -> None:
    """Equal axes in metres, around points (N, 2)."""
    (left, low), (right, high) = np.nanmin(around, axis=0) - margin, np.nanmax(around, axis=0) + margin
    ax.set(aspect="equal", xlim=(left, right), ylim=(low, high), xlabel="x (m)", ylabel="y (m)")
    step = 1.0 if max(right - left, high - low) > 3 else 0.5
    ax.set_xticks(np.arange(np.ceil(left / step) * step, right + 1e-9, step))
    ax.set_yticks(np.arange(np.ceil(low / step) * step, high + 1e-9, step))


def plot_pose(pose: Pose, ax: Axes, source: str = "truth", length: float = 0.35) -> None:
    """Draw a robot: its source's marker, and a line of `length` metres where it is heading."""
    style = style_of(source)
    tip = pose.to_parent([length, 0.0])[0]
    ax.plot([pose.x, tip[0]], [pose.y, tip[1]], color=style.colour, lw=2.4, zorder=6, path_effects=_HALO)
    ax.plot(
        pose.x,
        pose.y,
        style.marker,
        color=style.colour,
        ms=9,
        mec="white",
        mew=1.2,
        zorder=6.1,
        label=f"_{style.label}",
    )


def plot_path(path: PathLike, ax: Axes, source: str = "truth", robot: bool = True) -> None:
    """Draw where a robot was; an empty path draws nothing.

    Parameters
    ----------
    path : Pose, sequence of Pose, or array_like of shape (N, 2) or (N, 3)
        Metres and radians.
    ax : matplotlib Axes
        In metres.
    source : str
        A key of `STYLES`.
    robot : bool
        Draw the robot at the last pose, where that has a heading.
    """
    style, poses = style_of(source), as_path(path)
    if not len(poses):
        return
    ax.plot(
        poses[:, 0], poses[:, 1], color=style.colour, ls=style.line, lw=1.9, zorder=4, label=f"_{style.label}"
    )
    every = poses[:: max(1, len(poses) // 12)]
    ax.plot(
        every[:, 0], every[:, 1], style.marker, color=style.colour, ms=4, zorder=4.1, label=f"_{style.label}"
    )
    if robot and np.isfinite(poses[-1]).all():
        plot_pose(Pose.from_array(poses[-1]), ax, source)


def plot_ellipse(
    centre: npt.ArrayLike, covariance: npt.ArrayLike, ax: Axes, source: str = "ekf", probability: float = 0.95
) -> None:
    """Draw the region that holds a given part of a Gaussian distribution.

    Parameters
    ----------
    centre : array_like, shape (2,)
        Mean in metres.
    covariance : array_like, shape (2, 2)
        In m^2; where it holds NaN nothing is drawn.
    ax : matplotlib Axes
        In metres.
    source : str
        A key of `STYLES`.
    probability : float
        Part inside the ellipse.

    Raises
    ------
    ValueError
        If the matrix is finite but no covariance.
    """
    matrix = np.asarray(covariance, dtype=float)
    if matrix.shape != (2, 2):
        raise ValueError(f"covariance must have shape (2, 2), in m^2; got {matrix.shape}")
    outline = ellipse_outlines(centre, matrix[None], probability)
    if np.isfinite(matrix).all() and np.isnan(outline).any():
        raise ValueError(
            f"covariance must be symmetric, with no negative variance in any direction; got {matrix.tolist()}"
        )
    ax.add_collection(_ellipses(outline, style_of(source).colour))


def _ellipses(outlines: FloatArray, colour: str, order: float = 3.5) -> PolyCollection:
    """Outlines (N, corners, 2) as filled, see-through shapes; NaN is left out."""
    sound = outlines[np.isfinite(outlines).all(axis=(1, 2))] if len(outlines) else outlines
    rgb = matplotlib.colors.to_rgb(colour)
    return PolyCollection(
        list(sound), facecolors=[(*rgb, 0.16)], edgecolors=[(*rgb, 0.9)], linewidths=1.2, zorder=order
    )


def plot_landmarks(
    positions: npt.ArrayLike,
    kinds: Sequence[str],
    ax: Axes,
    colour: str = STYLES["ekf"].colour,
    size: float = 8,
) -> None:
    """Mark landmarks: a plus for a corner, a disc for a goal post, a thin cross for a crossing.

    Parameters
    ----------
    positions : array_like, shape (N, 2)
        Metres.
    kinds : sequence of str
        N of "corner", "post", "cross".
    ax : matplotlib Axes
        In metres.
    colour, size
        Of the markers; the size in points.

    Raises
    ------
    ValueError
        If there is not one kind for each position, or an unknown one.
    """
    points = as_points(positions, name="positions")
    if len(kinds) != len(points):
        raise ValueError(f"{len(points)} landmarks need {len(points)} kinds, got {len(kinds)}")
    if unknown := set(kinds) - set(LANDMARK_MARKERS):
        raise ValueError(f"a landmark's kind must be one of {tuple(LANDMARK_MARKERS)}, got {sorted(unknown)}")
    for kind, marker in LANDMARK_MARKERS.items():
        chosen = points[np.array([each == kind for each in kinds], dtype=bool)] if len(points) else points
        edge = {"mec": colour} if kind == "cross" else {"mec": "white", "mew": 0.9}
        ax.plot(*chosen.T, marker, color=colour, ms=size, ls="", zorder=5, label=f"_{kind}", **edge)


def plot_measurements(measurements: Iterable[Measurement], pose: Pose, ax: Axes, source: str = "ekf") -> None:
    """Draw what a robot at `pose` measures: a thin ray to each landmark, an open marker at its end."""
    seen = list(measurements)
    ends = measured_points(seen, pose)
    colour = style_of(source).colour
    for each, (x, y) in zip(seen, ends, strict=True):
        ax.plot([pose.x, x], [pose.y, y], color=colour, lw=0.9, alpha=0.65, zorder=3.6)
        ax.plot(x, y, LANDMARK_MARKERS[each.kind], color="none", mec=colour, ms=9, mew=1.4, zorder=5.2)


def measured_points(measurements: Iterable[Measurement], pose: Pose) -> FloatArray:
    """Where measurements taken at `pose` put their landmarks: (N, 2) in metres."""
    polar = as_points([(each.bearing, each.range) for each in measurements])
    return pose.to_parent(polar[:, 1:] * np.column_stack([np.cos(polar[:, 0]), np.sin(polar[:, 0])]))


def plot_estimate(
    estimate: Estimate, ax: Axes, source: str = "ekf", probability: float = 0.95, frame: Pose | None = None
) -> None:
    """Draw what a SLAM algorithm believes: robot, landmarks, and an ellipse for each.

    Parameters
    ----------
    estimate : Estimate
        With any number of landmarks. What is no covariance gets no ellipse.
    ax : matplotlib Axes
        In metres.
    source : "ekf" or "graph"
        Whose colours.
    probability : float
        Part inside each ellipse.
    frame : Pose, optional
        Of the frame the algorithm maps in, in the axis's frame; by default they are the same.
    """
    style = style_of(source)
    placed = place_estimate(estimate, frame)
    ax.add_collection(_ellipses(estimate_outlines(placed, probability), style.colour))
    plot_landmarks(placed.landmarks, placed.kinds, ax, style.colour)
    plot_pose(placed.pose, ax, source)


def place_estimate(estimate: Estimate, frame: Pose | None) -> Estimate:
    """Return an estimate in the frame in which `frame`, its own frame's pose, is given."""
    if not isinstance(estimate, Estimate):
        raise ValueError(f"estimate must be an Estimate, got {type(estimate).__name__}")
    if frame is None:
        return estimate
    c, s = np.cos(frame.theta), np.sin(frame.theta)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    with np.errstate(invalid="ignore", over="ignore"):  # what is no number stays none
        return Estimate(
            frame @ estimate.pose,
            turn @ estimate.covariance @ turn.T,
            frame.to_parent(estimate.landmarks),
            turn[:2, :2] @ estimate.landmark_covariances @ turn[:2, :2].T,
            estimate.kinds,
        )


def estimate_outlines(estimate: Estimate, probability: float = 0.95) -> FloatArray:
    """Ellipses of an estimate's robot and landmarks: (1 + N, corners, 2) in metres; NaN: none."""
    centres = np.vstack([estimate.pose.as_array()[None, :2], estimate.landmarks])
    covariances = np.concatenate([estimate.covariance[None, :2, :2], estimate.landmark_covariances])
    return ellipse_outlines(centres, covariances, probability)


# --- finished figures ---


def _legend_below(figure: Figure, handles: Sequence[Artist], columns: int = 4) -> None:
    if handles:
        figure.legend(handles=list(handles), loc="outside lower center", ncols=min(columns, len(handles)))


def _key(style: Style, label: str | None = None) -> Line2D:
    return Line2D(
        [],
        [],
        color=style.colour,
        ls=style.line,
        marker=style.marker,
        lw=1.9,
        ms=7,
        mec="white",
        label=label or style.label,
    )


def _landmark_keys(kinds: Iterable[str], colour: str, whose: str) -> list[Line2D]:
    present = [kind for kind in LANDMARK_MARKERS if kind in set(kinds)]
    return [
        Line2D(
            [],
            [],
            color=colour,
            marker=LANDMARK_MARKERS[kind],
            ls="",
            ms=8,
            mec="white",
            label=f"{whose} {kind}",
        )
        for kind in present
    ]


def draw_map(
    field: Field,
    truth: PathLike | None = None,
    odometry: PathLike | None = None,
    estimate: Estimate | None = None,
    measurements: Iterable[Measurement] = (),
    title: str | None = None,
    *,
    landmarks: bool = False,
    source: str = "ekf",
    frame: Pose | None = None,
    probability: float = 0.95,
) -> Drawing:
    """Draw the field from above with what is known, believed and measured.

    Parameters
    ----------
    field : Field
        The ground.
    truth, odometry : Pose, sequence of Pose, or array_like of shape (N, 2) or (N, 3), optional
        Paths in the world: metres, radians.
    estimate : Estimate, optional
        What a SLAM algorithm believes, in the frame `frame`.
    measurements : iterable of Measurement
        Drawn from the estimate's pose, else from the odometry's last, else from the truth's.
    title : str, optional
        Over the figure.
    landmarks : bool
        Mark the field's own corners and posts.
    source : "ekf" or "graph"
        Whose colours the estimate gets.
    frame : Pose, optional
        In the world, of the frame the estimate is in; by default they are the same. Both seeds map in the
        frame the robot started in: ``frame=Truth(nao).odometry_start``.
    probability : float
        Part inside each ellipse.

    Returns
    -------
    Drawing
        The figure.

    Raises
    ------
    ValueError
        For values of another shape, or measurements without any pose to draw them from.

    Examples
    --------
    >>> draw_map(Field(), odometry=[Pose(), Pose(1.0, 0.0, 0.5)])
    Drawing('Map of the half field by the rules of 2012, x towards the goal, y to the left. \
    odometry: 2 poses from (0.00, 0.00) m, heading 0 deg to (1.00, 0.00) m, heading 29 deg.')
    """
    seen = list(measurements)
    paths = {
        name: as_path(path, name)
        for name, path in (("truth", truth), ("odometry", odometry))
        if path is not None
    }
    placed = None if estimate is None else place_estimate(estimate, frame)
    words = [f"Map of {_say_field(field)}."]
    keys: list[Artist] = []
    with course_style():
        figure = Figure(figsize=(6.4, 6.9) if field.half else (9.2, 6.6))
        ax = figure.add_subplot()
        plot_field(field, ax, landmarks)
        if landmarks:
            keys += _landmark_keys(("corner", "post"), _GREY, "the field's")
        for name, path in paths.items():
            plot_path(path, ax, name)
            keys.append(_key(STYLES[name]))
            words.append(_say_path(STYLES[name].label, path))
        if placed is not None:
            style = style_of(source)
            plot_estimate(placed, ax, source, probability)
            keys += [
                _key(style, f"{style.label}, {100 * probability:.0f} % ellipse"),
                *_landmark_keys(placed.kinds, style.colour, style.label),
            ]
            words.append(_say_estimate(placed, style, probability))
        if seen:
            whose, pose = _observer(paths, placed, source)
            plot_measurements(seen, pose, ax, whose)
            words.append(
                f"{_count(len(seen), 'measurement')} from there: {_say_kinds(each.kind for each in seen)}."
            )
            keys.append(Line2D([], [], color=STYLES[whose].colour, lw=0.9, label="measurement"))
        ax.set_title(title or "")
        _legend_below(figure, keys, columns=3 if field.half else 5)
    return Drawing(figure, " ".join([f"{title}.", *words] if title else words))


def _observer(paths: Mapping[str, FloatArray], placed: Estimate | None, source: str) -> tuple[str, Pose]:
    """Who measured, and from where."""
    if placed is not None:
        return source, placed.pose
    for name in ("odometry", "truth"):
        if len(path := paths.get(name, np.empty((0, 3)))) and np.isfinite(path[-1]).all():
            return name, Pose.from_array(path[-1])
    raise ValueError("measurements need a pose to be drawn from: give an estimate, or a path with headings")


def _say_estimate(estimate: Estimate, style: Style, probability: float) -> str:
    sigmas = np.sqrt(np.maximum(np.diagonal(estimate.covariance)[:2], 0))
    spread = (
        f" (standard deviations {sigmas[0]:.2f} and {sigmas[1]:.2f} m)" if np.isfinite(sigmas).all() else ""
    )
    missing = int(np.isnan(estimate_outlines(estimate, probability)).any(axis=(1, 2)).sum())
    note = f" No ellipse for {missing} of them: no covariance." if missing else ""
    place = _say_place(estimate.pose.as_array())
    return f"{style.label}: robot at {place}{spread}; landmarks: {_say_kinds(estimate.kinds)}.{note}"


# --- pictures ---


def _pixels(picture: Picture | npt.ArrayLike) -> npt.NDArray[Any]:
    """An RGB picture, or one channel, as an array."""
    array = picture.pixels if isinstance(picture, Picture) else np.asarray(picture)
    if array.ndim not in (2, 3) or (array.ndim == 3 and array.shape[2] != 3) or 0 in array.shape:
        raise ValueError(
            f"a picture must be a Picture or an array of shape (H, W, 3) or (H, W), got {array.shape}"
        )
    if array.ndim == 3 and array.dtype != np.uint8:
        raise ValueError(f"a picture's colours must be uint8 (0 to 255), got {array.dtype}")
    return array


def _say_picture(picture: Picture | npt.NDArray[Any]) -> str:
    if isinstance(picture, Picture):
        return (
            f"picture of the {picture.camera} camera, {picture.view.size[0]} x {picture.view.size[1]} pixels"
        )
    height, width = picture.shape[:2]
    return f"{'picture' if picture.ndim == 3 else 'values of one channel'}, {width} x {height} pixels"


def plot_picture(picture: Picture | npt.ArrayLike, ax: Axes, ticks: bool = True, **options: Any) -> None:
    """Show a picture, (H, W, 3) of uint8 or (H, W), on an axis in pixels; `options` go to ``imshow``."""
    array = _pixels(picture)
    height, width = array.shape[:2]
    if array.ndim == 2:
        options.setdefault("cmap", "gray")
    options.setdefault("interpolation", "nearest" if width <= 64 else "antialiased")
    ax.imshow(array, **options)
    ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xticks=[], yticks=[])
    ax.spines[["left", "bottom"]].set_visible(False)
    if ticks:
        ax.set(xlabel="u (px)", ylabel="v (px)")
        ax.set(xticks=_pixel_ticks(width, 4), yticks=_pixel_ticks(height, 3))
        ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))


def _pixel_ticks(length: int, parts: int) -> list[int]:
    """Round numbers of pixels, and the last pixel."""
    return [*(length * part // parts for part in range(parts)), length - 1]


def _marked(landmarks: Iterable[VisibleLandmark] | npt.ArrayLike) -> tuple[FloatArray, list[str]]:
    """Pixels (N, 2) and kinds of what is to be marked in a picture."""
    values: Any = landmarks
    if not isinstance(values, np.ndarray):
        values = list(values)
        if values and all(isinstance(each, VisibleLandmark) for each in values):
            return as_points([each.pixel for each in values]), [
                "hidden" if each.occluded else each.landmark.kind for each in values
            ]
    points = as_points(values, name="landmarks (pixels u, v)")
    return points, ["point"] * len(points)


_MARKS = {  # kind: (marker, colour); open shapes, so that what is marked stays visible
    "corner": ("s", "#ff3b81"),
    "post": ("o", "#2c7bff"),
    "cross": ("D", "#ff8c1a"),
    "hidden": ("x", "#111111"),
    "point": ("o", "#ff3b81"),
}


def _mark(ax: Axes, points: FloatArray, kinds: Sequence[str]) -> list[Line2D]:
    keys = []
    for kind, (marker, colour) in _MARKS.items():
        chosen = np.array([each == kind for each in kinds], dtype=bool)
        if not chosen.any():
            continue
        look: dict[str, Any] = {
            "marker": marker,
            "color": colour,
            "mfc": "none",
            "ls": "",
            "ms": 12,
            "mew": 2.2,
        }
        ax.plot(*points[chosen].T, **look, path_effects=_HALO)
        look |= {"ms": 9, "mew": 1.8}
        keys.append(Line2D([], [], **look, label="behind a post" if kind == "hidden" else kind))
    return keys


def draw_picture(
    picture: Picture | npt.ArrayLike,
    landmarks: Iterable[VisibleLandmark] | npt.ArrayLike = (),
    title: str | None = None,
) -> Drawing:
    """Draw one picture, with landmarks or other points marked in it.

    Parameters
    ----------
    picture : Picture or array_like, shape (H, W, 3) of uint8, or (H, W)
        What to show.
    landmarks : iterable of VisibleLandmark, or array_like of shape (N, 2)
        The truth's landmarks, or pixels (u, v).
    title : str, optional
        Over the figure.

    Returns
    -------
    Drawing
        The figure.

    Raises
    ------
    ValueError
        For values of another shape.
    """
    array = _pixels(picture)
    points, kinds = _marked(landmarks)
    with course_style():
        figure = Figure(figsize=(7.2, 7.2 * array.shape[0] / array.shape[1] + (1.1 if len(points) else 0.8)))
        ax = figure.add_subplot()
        plot_picture(array, ax)
        _legend_below(figure, _mark(ax, points, kinds), columns=5)
        ax.set_title(title or "")
    words = f"{title or 'One'}: {_say_picture(picture if isinstance(picture, Picture) else array)}."
    if len(points):
        where = ", ".join(f"{kind} ({u:.0f}, {v:.0f})" for kind, (u, v) in zip(kinds, points, strict=True))
        words += f" Marked at (u, v): {where}."
    return Drawing(figure, words, photo=array.ndim == 3)


def draw_pictures(
    pictures: Sequence[Picture | npt.ArrayLike], titles: Sequence[str] = (), columns: int = 3
) -> Drawing:
    """Draw several pictures in a grid, to compare them.

    Parameters
    ----------
    pictures : sequence of Picture or array_like, (H, W, 3) of uint8, or (H, W)
        At least one.
    titles : sequence of str
        One for each, or none.
    columns : int
        Of the grid.

    Returns
    -------
    Drawing
        The figure.

    Raises
    ------
    ValueError
        If there is no picture, or there are titles but not one for each.
    """
    arrays = [_pixels(picture) for picture in pictures]
    if not arrays:
        raise ValueError("pictures must hold at least one picture, got none")
    if len(titles) not in (0, len(arrays)):
        raise ValueError(f"{len(arrays)} pictures need {len(arrays)} titles or none, got {len(titles)}")
    if columns < 1:
        raise ValueError(f"columns must be at least 1, got {columns}")
    columns = min(columns, len(arrays))
    rows = -(-len(arrays) // columns)
    names = list(titles) or [f"{number + 1}" for number in range(len(arrays))]
    width = {1: 7.0, 2: 4.7}.get(columns, 9.9 / columns)
    with course_style():
        figure = Figure(figsize=(width * columns, rows * (width * 0.75 + 0.45)))
        grid = figure.subplots(rows, columns, squeeze=False)
        for ax, array, name in zip(grid.flat, arrays, names, strict=False):
            plot_picture(array, ax, ticks=False)
            ax.set_title(name, fontsize=11)
        for ax in grid.flat[len(arrays) :]:
            ax.set_axis_off()
    said = "; ".join(
        f"{name}: {_say_picture(picture if isinstance(picture, Picture) else array)}"
        for name, picture, array in zip(names, pictures, arrays, strict=True)
    )
    return Drawing(figure, f"{_count(len(arrays), 'picture')} side by side. {said}.", photo=True)


def draw_labels(labels: npt.ArrayLike, title: str | None = None) -> Drawing:
    """Draw the class of each pixel: other, green, yellow, white.

    Parameters
    ----------
    labels : array_like of int, shape (H, W)
        0 other, 1 green, 2 yellow, 3 white.
    title : str, optional
        Over the figure.

    Returns
    -------
    Drawing
        The figure; its text says how much of the picture each class covers.

    Raises
    ------
    ValueError
        For another shape, or a label that is none of these.
    """
    array = _labels(labels)
    parts = [float((array == label).mean()) for label in range(len(LABELS))]
    with course_style():
        figure = Figure(figsize=(7.2, 7.2 * array.shape[0] / array.shape[1] + 1.1))
        ax = figure.add_subplot()
        plot_picture(
            array, ax, cmap=ListedColormap(LABEL_COLOURS), vmin=-0.5, vmax=3.5, interpolation="nearest"
        )
        keys = [
            Patch(facecolor=colour, edgecolor="#333333", label=f"{label} {name} ({part:.1%})")
            for label, (name, colour, part) in enumerate(zip(LABELS, LABEL_COLOURS, parts, strict=True))
        ]
        _legend_below(figure, keys)
        ax.set_title(title or "")
    said = ", ".join(f"{name} {part:.1%}" for name, part in zip(LABELS, parts, strict=True))
    return Drawing(
        figure, f"{title or 'Labels'}: classes of {array.shape[1]} x {array.shape[0]} pixels: {said}."
    )


def painted(labels: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Turn labels into a picture in their colours.

    Parameters
    ----------
    labels : array_like of int, shape (H, W)
        0 other, 1 green, 2 yellow, 3 white.

    Returns
    -------
    ndarray of uint8, shape (H, W, 3)
        RGB.

    Raises
    ------
    ValueError
        For another shape, or a label that is none of these.
    """
    colours = np.round(255 * np.array([to_rgb(colour) for colour in LABEL_COLOURS])).astype(np.uint8)
    return colours[_labels(labels).astype(np.intp)]


def _labels(labels: npt.ArrayLike) -> npt.NDArray[Any]:
    array = np.asarray(labels)
    if array.ndim != 2 or array.size == 0:
        raise ValueError(f"labels must have shape (H, W), got {array.shape}")
    if not np.isin(array, range(len(LABELS))).all():
        wrong = sorted(set(np.unique(array).tolist()) - set(range(len(LABELS))))
        raise ValueError(f"labels must be 0 other, 1 green, 2 yellow or 3 white; got {wrong[:5]}")
    return array


# --- figures of single lessons ---


def draw_hsl(
    picture: npt.ArrayLike, hue: npt.ArrayLike, saturation: npt.ArrayLike, lightness: npt.ArrayLike
) -> Drawing:
    """Draw a picture beside its hue, saturation and lightness.

    Parameters
    ----------
    picture : array_like of uint8, shape (H, W, 3)
        RGB.
    hue, saturation, lightness : array_like, shape (H, W)
        Degrees [0, 360), 0 to 1, and 0 to 255. Hues are painted as pure colours.

    Returns
    -------
    Drawing
        The figure; its text gives the medians.

    Raises
    ------
    ValueError
        For another shape.
    """
    array = _pixels(picture)
    channels = [np.asarray(each, dtype=float) for each in (hue, saturation, lightness)]
    for name, channel in zip(("hue", "saturation", "lightness"), channels, strict=True):
        if channel.shape != array.shape[:2]:
            raise ValueError(
                f"{name} must have shape {array.shape[:2]} as the picture has; got {channel.shape}"
            )
    painted = hsv_to_rgb(
        np.dstack([channels[0] % 360 / 360, np.ones_like(channels[0]), 0.9 + 0 * channels[0]])
    )
    shown = (array, np.round(255 * painted).astype(np.uint8), channels[1], channels[2])
    titles = ("picture", "hue (degrees, as pure colours)", "saturation (0 to 1)", "lightness (0 to 255)")
    with course_style():
        figure = Figure(figsize=(9.9, 8.0))
        for ax, image, title, largest in zip(
            figure.subplots(2, 2).flat, shown, titles, (None, None, 1.0, 255.0), strict=True
        ):
            grey = {} if largest is None else {"cmap": "gray", "vmin": 0, "vmax": largest}
            plot_picture(image, ax, ticks=False, **grey)
            ax.set_title(title, fontsize=11)
    middle = [float(np.median(channel)) for channel in channels]
    words = (
        f"A picture of {array.shape[1]} x {array.shape[0]} pixels beside its hue, saturation and lightness; "
        f"their medians are {middle[0]:.0f} degrees, {middle[1]:.2f} and {middle[2]:.0f}."
    )
    return Drawing(figure, words, photo=True)


def draw_hue_circle(
    hues: Mapping[str, npt.ArrayLike],
    limits: Mapping[str, tuple[float, float]] | None = None,
    title: str = "",
) -> Drawing:
    """Draw where hues lie on the circle, and intervals of them.

    Parameters
    ----------
    hues : mapping of str to array_like
        Hues in degrees, by what they are of; each has a ring of its own, from the inside.
    limits : mapping of str to (low, high), optional
        Intervals in degrees, counterclockwise from low to high, by the same names; low > high goes through 0.
    title : str
        Over the figure.

    Returns
    -------
    Drawing
        The figure; its text gives the intervals.

    Raises
    ------
    ValueError
        If there is nothing to draw, or a limit belongs to no ring.
    """
    if not hues:
        raise ValueError("hues must have at least one entry, got none")
    if unknown := sorted((limits or {}).keys() - hues.keys()):
        raise ValueError(f"limits are for {list(hues)}; got {unknown}, too")
    angles = {name: np.asarray(values, dtype=float).ravel() % 360 for name, values in hues.items()}
    with course_style():
        figure = Figure(figsize=(5.4, 5.6))
        ax: Any = figure.add_subplot(projection="polar")
        outer = np.radians(np.arange(0, 360, 2.0))
        colours = hsv_to_rgb(
            np.column_stack([outer / (2 * np.pi), np.ones_like(outer), np.full_like(outer, 0.9)])
        )
        ax.bar(outer, 0.25, width=np.radians(2.2), bottom=len(angles) + 3.0, color=colours)
        keys: list[Artist] = []
        for ring, (name, values) in enumerate(angles.items(), start=3):
            style = list(STYLES.values())[(ring - 3) % len(STYLES)]
            spread = ring + 0.35 * np.sin(12.9898 * np.arange(len(values)))  # apart, but the same each time
            ax.plot(np.radians(values), spread, style.marker, ms=4, color=style.colour, alpha=0.6, mec="none")
            keys.append(Line2D([], [], color=style.colour, marker=style.marker, ls="", label=name))
            if limits and name in limits:
                low, high = limits[name]
                arc = np.radians(np.linspace(low, low + (high - low) % 360, 200))
                ax.plot(arc, np.full_like(arc, ring + 0.47), color=style.colour, lw=3)
        ax.set_rlim(0, len(angles) + 3.25)
        ax.set_rticks([])
        ax.grid(color="#e3e5e8")
        ax.spines["polar"].set_visible(False)
        ax.set_thetagrids(range(0, 360, 30), [f"{degrees}°" for degrees in range(0, 360, 30)])
        ax.set_title(title)
        _legend_below(figure, keys, columns=2)
    said = "; ".join(
        f"{name}: {_count(len(values), 'hue')}"
        + (
            f", limits from {limits[name][0]:.1f} to {limits[name][1]:.1f} degrees"
            if limits and name in limits
            else ""
        )
        for name, values in angles.items()
    )
    return Drawing(figure, f"{title or 'Hues on the circle of colours'}. {said}.")


def draw_drift(
    paths: npt.ArrayLike,
    field: Field | None = None,
    *,
    start: Pose | None = None,
    commanded: PathLike | None = None,
    title: str | None = None,
) -> Drawing:
    """Draw robots that got the same commands, and where they went.

    Parameters
    ----------
    paths : array_like, shape (N, M + 1, 3)
        Each robot's poses, such as `nao_course.sim.repeat_drive` gives.
    field : Field, optional
        Drawn below them.
    start : Pose, optional
        Where the paths' origin is in the world.
    commanded : Pose, sequence of Pose, or array_like of shape (M + 1, 2) or (M + 1, 3), optional
        Where the commands lead without any error, from the same origin: each robot's odometry.
    title : str, optional
        Over the figure.

    Returns
    -------
    Drawing
        The figure; its text gives the spread at the end.

    Raises
    ------
    ValueError
        For another shape.
    """
    array = np.asarray(paths, dtype=float)
    if array.ndim != 3 or array.shape[2] != 3 or not array.shape[0] or not array.shape[1]:
        raise ValueError(
            f"paths must have shape (robots, steps + 1, 3), with at least one robot; got {array.shape}"
        )
    origin = start or Pose()
    robots, ends = len(array), origin.to_parent(array[:, -1, :2])
    believed = None if commanded is None else as_path(commanded, "commanded")
    truth, odometry = STYLES["truth"], STYLES["odometry"]
    keys: list[Artist] = [
        Line2D([], [], color=truth.colour, lw=0.9, marker="o", ms=5, label="true paths, ends")
    ]
    with course_style():
        figure = Figure(figsize=(6.4, 6.9) if field is None or field.half else (9.2, 6.6))
        ax = figure.add_subplot()
        everywhere = origin.to_parent(array[:, :, :2].reshape(-1, 2))
        _metres(ax, everywhere, margin=0.4)
        if field is None:
            ax.grid(color="#e3e5e8")
        if field is not None:
            plot_field(field, ax)
        for path in array:
            ax.plot(*origin.to_parent(path[:, :2]).T, color=truth.colour, lw=0.9, alpha=0.4, zorder=4)
        ax.plot(*ends.T, truth.marker, color=truth.colour, ms=5, mec="white", mew=0.7, zorder=5)
        if robots >= 3:
            outline = ellipse_outlines(ends.mean(axis=0), np.cov(ends.T)[None])
            ax.add_collection(_ellipses(outline, truth.colour))
            keys.append(Patch(facecolor="#d4d4d4", edgecolor=truth.colour, label="95 % of the ends"))
        if believed is not None and len(believed):
            placed = np.column_stack([origin.to_parent(believed[:, :2]), believed[:, 2] + origin.theta])
            plot_path(placed, ax, "odometry")
            keys.append(_key(odometry, "what each believes"))
        ax.plot(origin.x, origin.y, "*", color=_YELLOW, mec="black", ms=13, zorder=7)
        keys.append(Line2D([], [], color=_YELLOW, marker="*", mec="black", ms=12, ls="", label="start"))
        _legend_below(figure, keys, columns=2 if field is None or field.half else 4)
        ax.set_title(title or "")
    spread = ends.std(axis=0, ddof=1) if robots > 1 else np.zeros(2)
    words = (
        f"{title or 'Drift'}: {_count(robots, 'robot')}, the same {_count(array.shape[1] - 1, 'command')} each. "
        f"They end around ({ends[:, 0].mean():.2f}, {ends[:, 1].mean():.2f}) m, with standard deviations "
        f"{spread[0]:.2f} m in x and {spread[1]:.2f} m in y."
    )
    if believed is not None and len(believed):
        words += f" Each believes it is at {_say_place(placed[-1])}."
    return Drawing(figure, words)


def _inside(view: CameraView, x: FloatArray, y: FloatArray) -> FloatArray:
    """How many pixels inside the picture points of the ground fall; negative outside it."""
    pixels = view.project(np.column_stack([x.ravel(), y.ravel()]))
    width, height = view.size
    sides = [pixels[:, 0] + 0.5, width - 0.5 - pixels[:, 0], pixels[:, 1] + 0.5, height - 0.5 - pixels[:, 1]]
    inside: FloatArray = np.clip(np.nan_to_num(np.min(sides, axis=0), nan=-50.0), -50, 50)
    return inside.reshape(x.shape)


_CAMERA_COLOURS = {"top": "#0b5fa5", "bottom": "#c84b00"}


def plot_footprint(
    view: CameraView, ax: Axes, colour: str = STYLES["ekf"].colour, reach: float = 6.0
) -> None:
    """Draw the part of the ground a camera sees, up to `reach` metres.

    The axis is in the robot's frame, seen from above: ahead is up, so its x axis holds y and points left.
    """
    x, y = np.meshgrid(np.linspace(-1.0, reach, 281), np.linspace(-reach, reach, 321))
    values = np.minimum(_inside(view, x, y), (reach - np.hypot(x, y)) * 100)
    if (values > 0).any():
        ax.contourf(y, x, values, levels=[0, 1e9], colors=[colour], alpha=0.22, zorder=2)
        ax.contour(y, x, values, levels=[0], colors=[colour], linewidths=1.6, zorder=3)


def draw_cameras(nao: SimulatedNao, size: tuple[int, int] = (320, 240), title: str | None = None) -> Drawing:
    """Draw what both cameras see, and which part of the ground that is.

    Parameters
    ----------
    nao : SimulatedNao
        It takes a picture with each camera, so its random numbers go on.
    size : (int, int)
        Of the pictures, pixels.
    title : str, optional
        Over the figure.

    Returns
    -------
    Drawing
        The figure.
    """
    pictures = {camera: nao.take_picture(camera, size) for camera in ("top", "bottom")}
    reach = 4.0
    with course_style():
        figure = Figure(figsize=(9.8, 6.2))
        grid = figure.add_gridspec(2, 2, width_ratios=(1.0, 1.32))
        for row, (camera, picture) in enumerate(pictures.items()):
            ax = figure.add_subplot(grid[row, 0])
            plot_picture(picture, ax, ticks=False)
            ax.set_title(f"{camera} camera", fontsize=11, color=_CAMERA_COLOURS[camera])
            for spine in ax.spines.values():
                spine.set(visible=True, color=_CAMERA_COLOURS[camera], linewidth=2.5)
        ax = figure.add_subplot(grid[:, 1])
        for radius in range(1, int(reach) + 1):
            ax.add_patch(Circle((0, 0), radius, fill=False, color="#d5d8dc", lw=0.9, zorder=1))
        for camera, picture in pictures.items():
            plot_footprint(picture.view, ax, _CAMERA_COLOURS[camera], reach)
        ax.plot(0, 0, "o", color="#1a1a1a", ms=9, zorder=5)
        ax.plot([0, 0], [0, 0.3], color="#1a1a1a", lw=2.4, zorder=5)
        ax.annotate("robot", (0, 0), (8, -12), textcoords="offset points")
        ax.set(
            aspect="equal",
            xlim=(2.6, -2.6),
            ylim=(-0.6, reach + 0.1),
            xlabel="y (m), left is positive",
            ylabel="x ahead (m)",
        )
        ax.set_title("the ground they see, robot frame", fontsize=11)
        keys = [
            Patch(facecolor=colour, alpha=0.5, label=f"{camera} camera")
            for camera, colour in _CAMERA_COLOURS.items()
        ]
        _legend_below(figure, keys)
        if title:
            figure.suptitle(title, fontweight="bold", fontsize=12, x=0.01, ha="left")
    yaw, pitch = nao.head
    words = [
        f"Both cameras with the head at yaw {_degrees(yaw)}, pitch {_degrees(pitch)} (positive is down)."
    ]
    words += [_say_footprint(camera, picture.view) for camera, picture in pictures.items()]
    return Drawing(figure, " ".join([f"{title}.", *words] if title else words), photo=True)


def _say_footprint(camera: str, view: CameraView) -> str:
    ahead = np.linspace(0.0, 20.0, 2001)
    along = np.column_stack([ahead * np.cos(view.yaw), ahead * np.sin(view.yaw)]) + view.offset
    seen = ahead[view.contains(view.project(along))]
    if not len(seen):
        return f"The {camera} camera sees no ground."
    far = "the horizon" if seen[-1] > 19.9 else f"{seen[-1]:.1f} m"
    return f"The {camera} camera sees the ground from {seen[0]:.1f} m to {far} before it."


def _arrow(
    ax: Axes, start: npt.ArrayLike, end: npt.ArrayLike, colour: str, width: float = 2.2, line: Any = "-"
) -> None:
    """An arrow between two points of the axis."""
    ax.add_patch(
        FancyArrowPatch(
            tuple(np.asarray(start, dtype=float)),
            tuple(np.asarray(end, dtype=float)),
            arrowstyle="-|>",
            mutation_scale=14,
            shrinkA=0,
            shrinkB=0,
            color=colour,
            lw=width,
            ls=line,
            zorder=5,
        )
    )


def _angle(
    ax: Axes, at: npt.ArrayLike, first: float, last: float, radius: float, colour: str, label: str
) -> None:
    """An arc from one direction to another (rad, in the axis's frame), with its name beside the middle."""
    x, y = np.asarray(at, dtype=float)
    low, high = np.degrees(sorted((first, last)))
    ax.add_patch(Arc((x, y), 2 * radius, 2 * radius, theta1=low, theta2=high, color=colour, lw=2, zorder=5))
    end, back = last, last - np.sign(last - first) * 0.12
    tip, tail = ((x + radius * np.cos(a), y + radius * np.sin(a)) for a in (end, back))
    _arrow(ax, tail, tip, colour, 1.0)
    middle = (first + last) / 2
    _name(ax, (x + radius * 1.12 * np.cos(middle), y + radius * 1.12 * np.sin(middle)), label, colour)


def _name(ax: Axes, at: npt.ArrayLike, label: str, colour: str, **options: Any) -> None:
    x, y = np.asarray(at, dtype=float)
    ax.text(x, y, label, color=colour, zorder=8, path_effects=_HALO, **({"va": "center"} | options))


_FIELD_FRAME, _ROBOT_FRAME, _SIGHT = "#1a1a1a", "#0b5fa5", "#a14566"


def draw_frames(field: Field | None = None, title: str | None = None) -> Drawing:
    """Draw the course's frames and angles: field, robot, bearing and range, head yaw and pitch.

    Parameters
    ----------
    field : Field, optional
        Of which rule year; one half of it is drawn. By default the first seed's.
    title : str, optional
        Over the figure.

    Returns
    -------
    Drawing
        A figure for the first lesson.
    """
    field = Field(2012 if field is None else field.year)
    with course_style():
        figure = Figure(figsize=(10.2, 6.4))
        grid = figure.add_gridspec(2, 2, width_ratios=(1.18, 1.0))
        landmark = _frames_on_field(figure.add_subplot(grid[:, 0]), field)
        _head_from_above(figure.add_subplot(grid[0, 1]))
        _head_from_the_side(figure.add_subplot(grid[1, 1]))
        if title:
            figure.suptitle(title, fontweight="bold", fontsize=12, x=0.01, ha="left")
    words = (
        f"The frames of the course on {_say_field(field)}, seen from above. The field frame's x axis points to "
        "the goal, its y axis to the left; the robot's x axis points ahead and its y axis to its left, turned by "
        f"the heading theta against the field's. A {landmark} is measured by its range, the distance over the "
        "ground, and its bearing, the angle from straight ahead, positive to the left. The head's yaw is "
        "positive to the left, its pitch positive downwards from the horizon."
    )
    return Drawing(figure, f"{title}. {words}" if title else words)


def _frames_on_field(ax: Axes, field: Field) -> str:
    """Field frame, robot frame, and one measurement; returns what is measured."""
    d = field.dimensions
    plot_field(field, ax)
    ax.set_title("on the field, from above", fontsize=11)
    unit = 0.8 * d.length / 6
    for axis, label, where in (((unit, 0), "x", (0, -9)), ((0, unit), "y", (-11, 0))):
        _arrow(ax, (0, 0), axis, _FIELD_FRAME)
        ax.annotate(
            label, axis, where, textcoords="offset points", ha="center", va="center", color=_FIELD_FRAME
        )
    _name(ax, (-0.05, -0.2), "field frame", _FIELD_FRAME, ha="left", va="top")
    robot = Pose(0.14 * d.length, -0.33 * d.width, np.radians(18))
    target = Landmark(d.length / 2 - d.goal_area[0], d.goal_area[1] / 2, "corner", "L")
    local = robot.to_local([target.x, target.y])[0]
    bearing, distance = float(np.arctan2(local[1], local[0])), float(np.hypot(*local))
    ahead, left = robot.to_parent([[1.7 * unit, 0], [0, unit]])
    ax.plot(
        [robot.x, robot.x + 1.65 * unit],
        [robot.y, robot.y],
        color=_FIELD_FRAME,
        lw=1,
        ls=(0, (4, 3)),
        zorder=4,
    )
    ax.plot([robot.x, target.x], [robot.y, target.y], color=_SIGHT, lw=1.8, ls=(0, (1.5, 1.5)), zorder=4)
    ax.plot(target.x, target.y, "s", color="none", mec=_SIGHT, ms=13, mew=2.2, zorder=6)
    for end, label in ((ahead, "x"), (left, "y")):
        _arrow(ax, (robot.x, robot.y), end, _ROBOT_FRAME)
        outwards = end + 0.14 * unit * (end - (robot.x, robot.y)) / np.hypot(*(end - (robot.x, robot.y)))
        _name(ax, outwards, label, _ROBOT_FRAME, ha="center")
    plot_pose(robot, ax, "ekf", length=0.05)
    _name(ax, (robot.x, robot.y - 0.2), "robot frame", _ROBOT_FRAME, ha="center", va="top")
    _angle(ax, (robot.x, robot.y), 0.0, robot.theta, 1.4 * unit, _FIELD_FRAME, r" heading $\theta$")
    _angle(ax, (robot.x, robot.y), robot.theta, robot.theta + bearing, 0.85 * unit, _SIGHT, " bearing")
    middle = robot.to_parent(0.62 * local)[0]
    _name(ax, middle + (-0.1, 0.05), "range", _SIGHT, ha="right")
    _name(ax, (target.x - 0.12, target.y + 0.24), "landmark", _SIGHT, ha="center")
    return f"corner at bearing {_degrees(bearing)} and range {distance:.1f} m"


def _bare(ax: Axes, title: str, x: tuple[float, float], y: tuple[float, float]) -> None:
    ax.set_title(title, fontsize=11)
    ax.set(aspect="equal", xlim=x, ylim=y)
    ax.set_axis_off()


def _head_from_above(ax: Axes) -> None:
    """The head's yaw, ahead being to the right."""
    _bare(ax, "head yaw, from above", (-0.45, 2.0), (-0.5, 0.95))
    yaw, half = np.radians(32), NAO_V4.hfov / 2
    ax.add_patch(Wedge((0, 0), 1.12, *np.degrees([yaw - half, yaw + half]), color=_SIGHT, alpha=0.14, lw=0))
    ax.add_patch(Ellipse((0, 0), 0.24, 0.62, color="#c9ced6", zorder=2))
    ax.add_patch(Circle((0, 0), 0.14, color="#8b94a3", zorder=3))
    _arrow(ax, (0, 0), (1.2, 0), _ROBOT_FRAME)
    _name(ax, (1.25, 0), "x: straight ahead", _ROBOT_FRAME)
    direction = np.array([np.cos(yaw), np.sin(yaw)])
    _arrow(ax, (0, 0), 1.2 * direction, _SIGHT)
    _name(ax, 1.26 * direction, "camera", _SIGHT)
    _angle(ax, (0, 0), 0.0, yaw, 0.62, _SIGHT, "  yaw: positive left")


def _head_from_the_side(ax: Axes) -> None:
    """The camera's pitch, ahead being to the right; heights to scale."""
    height, pitch = NAO_V4.view("top").height, np.radians(20)
    _bare(ax, "pitch, from the side", (-0.35, 1.65), (-0.16, 0.78))
    ax.fill_between([-0.3, 1.6], -0.05, 0, color=_CARPET, lw=0)
    for corner, width, tall in (
        ((-0.05, 0), 0.15, 0.05),
        ((-0.03, 0.04), 0.07, 0.2),
        ((-0.06, 0.2), 0.13, 0.22),
    ):
        ax.add_patch(Rectangle(corner, width, tall, color="#c9ced6", zorder=2))
    ax.add_patch(Ellipse((0.0, 0.5), 0.17, 0.15, color="#8b94a3", zorder=3))
    eye = np.array([0.06, height])
    ax.plot([eye[0], 1.3], [height, height], color=_FIELD_FRAME, lw=1, ls=(0, (4, 3)))
    _name(ax, (1.3, height + 0.05), "horizon", _FIELD_FRAME, ha="right")
    reach = height / np.tan(pitch)
    ax.plot([eye[0], eye[0] + reach], [height, 0], color=_SIGHT, lw=1.2, ls=(0, (1.5, 1.5)))
    axis = np.array([np.cos(pitch), -np.sin(pitch)])
    _arrow(ax, eye, eye + 0.85 * axis, _SIGHT)
    _name(ax, eye + 0.86 * axis + (0.02, 0.06), "camera", _SIGHT, ha="left")
    _angle(ax, eye, 0.0, -pitch, 0.45, _SIGHT, " pitch: positive down")
    _arrow(ax, (-0.2, 0.0), (-0.2, height), _ROBOT_FRAME, 1.4)
    ax.plot([-0.22, eye[0]], [height, height], color=_ROBOT_FRAME, lw=0.8)
    _name(ax, (-0.23, height / 2), f"height\n{height:.2f} m", _ROBOT_FRAME, ha="right")
    _name(ax, (eye[0] + reach, -0.1), "where the axis meets the ground", _SIGHT, ha="center")
