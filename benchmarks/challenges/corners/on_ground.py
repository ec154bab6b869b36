"""A corner detector that also knows how its camera looks at the ground."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from benchmarks.challenges.corners.carpet import Planes, take_apart
from benchmarks.challenges.corners.crossings import find_crossings, without_doubles
from benchmarks.challenges.corners.lines import Lines, LineSettings, merge
from benchmarks.challenges.corners.pieces import Pieces, PieceSettings, line_pieces
from benchmarks.challenges.pictures import check_picture
from benchmarks.challenges.tilt import PITCH_SD, ROLL_SD, align, to_ground
from nao_course.geometry import FloatArray
from nao_course.sim import CameraView

LINE_WIDTH = 0.05  # metres
# Between two lines at least, rad: those that lie in the field's two directions meet at a right angle anyway.
RIGHT_ANGLE, ANY_ANGLE = float(np.radians(45)), float(np.radians(15))
UPRIGHT = 1e-6  # rad: a prior under which the camera does not lean


@dataclass(frozen=True)
class GroundSettings:
    """What `find_corners_on_ground` goes by; pixels are those of a picture 320 wide.

    Parameters
    ----------
    pieces : PieceSettings
        Of line pieces.
    lines : LineSettings
        Of merging.
    widening : float
        How much wider a line may seem than it is, for the lean is not known yet.
    slack : float
        How much wider lens and light may make it besides, px.
    far : float
        How far away a corner may be, metres.
    shortest : float
        Of a line, px.
    bend, bend_length : float
        How far the middle of a line may lie beside its ends: px, and as a fraction of its length.
    square : float
        How far from the field's two directions a line may lie on the ground, rad, where its direction is known well.
    square_sd : float
        The same in standard deviations of its direction.
    square_most : float
        The same at most, rad.
    reach, reach_range : float
        How far lines are extended on the ground: metres, and metres for each metre of distance.
    arm, arm_range : float
        How long an arm is at least: the same.
    doubles : float
        Corners nearer to each other are one, px.
    lean, right_angles : bool
        Whether the camera's lean is looked for; whether lines must lie in two directions, and meet at a right angle.
    """

    pieces: PieceSettings = field(default_factory=PieceSettings)
    lines: LineSettings = field(default_factory=LineSettings)
    widening: float = 1.5
    slack: float = 2.0
    far: float = 7.0
    shortest: float = 7.0
    bend: float = 1.0
    bend_length: float = 0.006
    square: float = float(np.radians(11.0))
    square_sd: float = 2.5
    square_most: float = float(np.radians(25.0))
    reach: float = 0.08
    reach_range: float = 0.03
    arm: float = 0.09
    arm_range: float = 0.03
    doubles: float = 8.0
    lean: bool = True
    right_angles: bool = True


# Frozen. Chosen on the simulator's sets "tune" and "whole_tune" (also with other seeds) and on the 8 real scenes that
# are also there at 1280 x 960, on no other picture.
CHOSEN = GroundSettings()


def find_corners_on_ground(
    picture: npt.ArrayLike, view: CameraView, settings: GroundSettings = CHOSEN
) -> FloatArray:
    """Find the corners of the field's lines in a picture: right angles on the ground.

    Parameters
    ----------
    picture : ndarray of uint8, shape (H, W, 3)
        RGB.
    view : CameraView
        What the robot believes of its camera, its constant offset taken out.

    Returns
    -------
    ndarray, shape (K, 2)
        (u, v), px.

    Raises
    ------
    ValueError
        If the picture is not RGB of uint8, or not of the view's size.
    """
    lines = _lines(picture, view, settings)
    if len(lines) < 2:
        return np.zeros((0, 2))
    s, scale = settings, view.size[0] / 320
    found = align(lines.ends, view, *((PITCH_SD, ROLL_SD) if s.lean else (UPRIGHT, UPRIGHT)))
    limit = np.clip(s.square_sd * found.angle_sd, s.square, s.square_most) if s.right_angles else np.inf
    ground = to_ground(lines.ends.reshape(-1, 2), replace(view, pitch=found.pitch, roll=found.roll)).reshape(
        -1, 4
    )
    wanted = (np.abs(found.aside) <= limit) & np.isfinite(ground).all(axis=1)
    crossings = find_crossings(
        ground[wanted],
        np.full(int(wanted.sum()), LINE_WIDTH),
        lambda points: np.full(len(points), np.sin(RIGHT_ANGLE if s.right_angles else ANY_ANGLE)),
        lambda points: s.reach + s.reach_range * np.hypot(*points.T),
        lambda points: s.arm + s.arm_range * np.hypot(*points.T),
    )
    near = np.hypot(*crossings.points.T) <= s.far
    level = replace(view, pitch=found.pitch, roll=found.roll, yaw=0.0, offset=(0.0, 0.0))
    pixels = level.project(crossings.points[near])
    inside = view.contains(pixels)
    return without_doubles(pixels[inside], crossings.strength[near][inside], s.doubles * scale)


def middle_lines(picture: npt.ArrayLike, view: CameraView, settings: GroundSettings = CHOSEN) -> FloatArray:
    """Find the middles of straight lines in a picture.

    Parameters
    ----------
    picture : ndarray of uint8, shape (H, W, 3)
        RGB.
    view : CameraView
        What the robot believes of its camera.

    Returns
    -------
    ndarray, shape (N, 4)
        (u1, v1, u2, v2), px to a fraction of one, where they would be without the lens.

    Raises
    ------
    ValueError
        If the picture is not RGB of uint8, or not of the view's size.
    """
    return _lines(picture, view, settings).ends


def _lines(picture: npt.ArrayLike, view: CameraView, settings: GroundSettings) -> Lines:
    """Return the centre lines of straight lines, without lens distortion."""
    pixels = check_picture(picture)
    if pixels.shape[1::-1] != view.size:
        raise ValueError(f"the picture must be of the view's size {view.size}, got {pixels.shape[1::-1]}")
    planes = take_apart(pixels)
    if planes is None:
        return Lines.none()
    pieces = line_pieces(planes, _first_row(planes, view), _Widest(view, settings), settings.pieces)
    lines = merge(_undistorted(pieces, view), planes.scale, settings.lines, settings.shortest)
    straight = lines.bend <= settings.bend * planes.scale + settings.bend_length * lines.length
    return lines.where(straight)


def _first_row(planes: Planes, view: CameraView) -> int:
    """Return the first row that may show a line: the first of the carpet, or a lower one with ground 10 m away."""
    steep = view.pitch - np.arctan(view.height / 10.0)
    row = view.centre[1] - view.focal[1] * np.tan(np.clip(steep, -1.5, 1.5))
    return int(np.clip(max(row, planes.first_row) - 4 * planes.scale, 0, len(planes.carpet)))


@dataclass(frozen=True)
class _Widest:
    """How wide a line of the field may be in a picture."""

    view: CameraView
    settings: GroundSettings

    def __call__(self, points: FloatArray, normals: FloatArray) -> FloatArray:
        """Return the widths (N,) of lines, px, at points (N, 2) across unit normals (N, 2)."""
        along = np.column_stack([-normals[:, 1], normals[:, 0]])
        here, ahead, aside = (to_ground(points + each, self.view) for each in (0 * normals, along, normals))
        way, across = ahead - here, aside - here
        metres = np.abs(way[:, 0] * across[:, 1] - way[:, 1] * across[:, 0]) / np.hypot(*way.T)
        width = np.where(np.isnan(metres), 0.0, LINE_WIDTH / np.maximum(metres, 1e-4))
        widest = self.settings.widening * width + self.settings.slack * self.view.size[0] / 320
        return np.minimum(widest, self.view.size[0] / 4)


def _undistorted(pieces: Pieces, view: CameraView) -> Pieces:
    """Return the segments without lens distortion."""
    n = len(pieces)
    flat = view.undistort(np.concatenate([pieces.middles.reshape(-1, 2), pieces.edges.reshape(-1, 2)]))
    middles, edges = (
        flat[: pieces.good.size].reshape(*pieces.good.shape, 2),
        flat[pieces.good.size :].reshape(n, 2, 2),
    )
    good = pieces.good & np.isfinite(middles).all(axis=-1)
    kept = good.any(axis=1) & np.isfinite(edges).all(axis=(1, 2))
    return Pieces(np.nan_to_num(middles)[kept], good[kept], pieces.width[kept], edges[kept])
