"""The half field on a sheet of A3, to be printed and photographed: its PDF, and a photograph to stand in for one."""

from __future__ import annotations

import io
from functools import cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle, Wedge

from nao_course.geometry import FloatArray, Pose
from nao_course.plotting.style import course_style
from nao_course.sim import CameraView, Field

FIELD = Field(2012)
SCALE = 1 / 15  # of the sheet: a metre of the field is 67 mm
PAPER = (0.420, 0.297)  # m: A3, lying
BELOW = 0.020  # m of paper below the halfway line
# m of the field: wider and longer than real ones, for small pictures.
LINE_WIDTH, POST_WIDTH, POST_LENGTH = (0.08, 0.16, 1.05)
GREEN, WHITE, YELLOW = "#4d9a50", "#ffffff", "#e8cc22"
PIXELS_PER_M = 4000  # of the sheet as a picture
# Corners of the field that are clicked, in metres of the field: x towards the goal, y to the left.
CLICKED = {"A": (0.0, 2.0), "B": (0.0, -2.0), "C": (3.0, -2.0), "D": (3.0, 2.0)}


@course_style()
def sheet_pdf() -> bytes:
    """Return the sheet as a PDF of one page, A3; the same bytes at every call."""
    buffer = io.BytesIO()
    _sheet().savefig(buffer, format="pdf", metadata={"CreationDate": None, "Creator": None, "Producer": None})
    return buffer.getvalue()


def on_paper(points: npt.ArrayLike) -> FloatArray:
    """Return points (N, 2) of the field in m as places on the paper, cm: to the right, and up from the halfway line."""
    x, y = np.asarray(points, dtype=float).T
    return 100 * SCALE * np.column_stack([-y, x])


@cache
@course_style()
def sheet_pixels() -> npt.NDArray[np.uint8]:
    """Return the sheet as a picture, (H, W, 3) RGB, read-only."""
    figure = _sheet()
    figure.set_dpi(PIXELS_PER_M * 0.0254)
    canvas: Any = FigureCanvasAgg(figure)  # matplotlib gives its methods no types
    canvas.draw()
    pixels = np.array(canvas.buffer_rgba())[:, :, :3]
    pixels.setflags(write=False)
    return pixels


def _sheet() -> Figure:
    """Draw the sheet: the field with its goal lying on its back, letters at the four corners, and a ruler."""
    figure = Figure(figsize=(PAPER[0] / 0.0254, PAPER[1] / 0.0254))
    figure.set_layout_engine("none")
    ax = figure.add_axes((0, 0, 1, 1))
    # The axis has the field's own metres: to the right is -y, up is x.
    half, low = PAPER[0] / SCALE / 2, -BELOW / SCALE
    ax.set(xlim=(-half, half), ylim=(low, low + PAPER[1] / SCALE))
    ax.set_axis_off()
    ax.add_patch(Rectangle((-half, low), 2 * half, PAPER[1] / SCALE, fc=GREEN, ec="none"))
    _add_lines(ax)
    for x, y in FIELD.posts:
        ax.add_patch(Rectangle((-y - POST_WIDTH / 2, x), POST_WIDTH, POST_LENGTH, fc=YELLOW, ec="none"))
    for name, (x, y) in CLICKED.items():
        side = np.sign(-y)
        ax.text(-y + 0.22 * side, x, name, color="#17461d", ha="center", va="center", fontsize=22)
    _add_ruler(ax, low)
    return figure


def _add_lines(ax: Axes) -> None:
    for x1, y1, x2, y2 in np.vstack([FIELD.lines, FIELD.mark_lines]):
        left, bottom = min(-y1, -y2) - LINE_WIDTH / 2, min(x1, x2) - LINE_WIDTH / 2
        across, up = abs(y2 - y1) + LINE_WIDTH, abs(x2 - x1) + LINE_WIDTH
        ax.add_patch(Rectangle((left, bottom), across, up, fc=WHITE, ec="none"))
    for x, y, radius, first, last in FIELD.arcs:
        turned = np.degrees([first, last]) + 90
        ax.add_patch(Wedge((-y, x), radius + LINE_WIDTH / 2, *turned, width=LINE_WIDTH, fc=WHITE, ec="none"))


def _add_ruler(ax: Axes, low: float) -> None:
    """Draw ten centimetres of paper, to check the size of the print."""
    length = 0.10 / SCALE
    ax.add_patch(Rectangle((0.5, low + 0.10), length, 0.02, fc="#17461d", ec="none"))
    ax.text(
        0.5 + length / 2,
        low + 0.17,
        "10 cm on paper, 1 : 15",
        color="#17461d",
        ha="center",
        va="center",
        fontsize=8,
    )


def stand_in_photo(
    view: CameraView, pose: Pose, rng: np.random.Generator, noise: float = 2.0
) -> npt.NDArray[np.uint8]:
    """Return an RGB photo (H, W, 3) of the sheet on a table, taken by a camera without a lens term.

    The view is in metres of the field, 15 times as high as over the paper; the pose is the camera's foot in the field
    frame. `noise` is a standard deviation, of 255.
    """
    sheet = sheet_pixels()
    rows, columns = sheet.shape[:2]
    on_sheet = np.array(
        [(-0.5, -0.5), (columns - 0.5, -0.5), (columns - 0.5, rows - 0.5), (-0.5, rows - 0.5)]
    )
    finer = 3  # samples a pixel in each direction
    seen = view.project(_corners(), pose) * finer + (finer - 1) / 2
    turn = cv2.getPerspectiveTransform(on_sheet.astype(np.float32), seen.astype(np.float32))
    width, height = view.size
    large = np.empty((height * finer, width * finer, 3), np.float32)
    large[:] = (126, 104, 84)  # the table
    table = cv2.warpPerspective(
        sheet.astype(np.float32),
        turn,
        (width * finer, height * finer),
        dst=large,
        flags=cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_TRANSPARENT,
    )
    photo = cv2.resize(table, (width, height), interpolation=cv2.INTER_AREA)
    light = np.linspace(0.86, 1.0, width)[None, :, None] * np.linspace(1.0, 0.9, height)[:, None, None]
    return np.clip(photo * light + noise * rng.standard_normal(photo.shape), 0, 255).astype(np.uint8)


def _corners() -> FloatArray:
    """Return the corners (4, 2) of the paper in the field frame in m, clockwise from the upper left."""
    half, low = PAPER[0] / SCALE / 2, -BELOW / SCALE
    high = low + PAPER[1] / SCALE
    return np.array([(high, half), (high, -half), (low, -half), (low, half)])


@cache
def usual_photo() -> npt.NDArray[np.uint8]:
    """Photograph the sheet as a phone does that is held 33 cm above the table: the same picture, read-only."""
    pixels = stand_in_photo(*usual_phone(), np.random.default_rng(11))
    pixels.setflags(write=False)
    return pixels


def usual_phone() -> tuple[CameraView, Pose]:
    """Return the view (in metres of the field) and pose of the phone of `usual_photo`: 33 cm up, 58 degrees down."""
    view = CameraView.from_fov((1200, 900), hfov=1.13, height=0.33 / SCALE, pitch=float(np.radians(58.0)))
    return view, Pose(-0.09 / SCALE, 0.25, -0.05)
