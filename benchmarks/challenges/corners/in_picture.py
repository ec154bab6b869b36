"""A corner detector that needs nothing but the picture."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from benchmarks.challenges.corners.carpet import check_picture, take_apart
from benchmarks.challenges.corners.crossings import find_crossings, without_doubles
from benchmarks.challenges.corners.lines import LineSettings, merge
from benchmarks.challenges.corners.pieces import PieceSettings, line_pieces
from nao_course.geometry import FloatArray


@dataclass(frozen=True)
class PictureSettings:
    """What `find_corners_better` goes by; pixels are those of a picture 320 wide.

    Parameters
    ----------
    pieces : PieceSettings
        Of line pieces.
    lines : LineSettings
        Of merging.
    horizon : float
        How far above the carpet's first row the horizon is taken to be, as a fraction of the picture's height.
    widening : float
        How wide a line may be, in pixels for each row below the horizon: over flat ground a line of 0.05 m seen from
        0.48 m has 0.104, whatever the lens.
    slack : float
        How much wider lens and light may make it, px.
    steepest : float
        Smallest angle between two lines, rad.
    shortest : float
        Of a line, px.
    reach, reach_width : float
        How far lines are extended: px, and line widths.
    arm, arm_width : float
        How long an arm is at least: px, and line widths.
    bend, bend_length : float
        How far a line's points may lie beside it, root mean square: px, and as a fraction of its length.
    doubles : float
        Corners nearer to each other are one, px.
    """

    pieces: PieceSettings = field(default_factory=PieceSettings)
    lines: LineSettings = field(default_factory=LineSettings)
    horizon: float = 0.12
    widening: float = 0.16
    slack: float = 2.0
    steepest: float = float(np.radians(12.0))
    shortest: float = 12.0
    reach: float = 6.0
    reach_width: float = 1.0
    arm: float = 8.0
    arm_width: float = 0.5
    bend: float = 0.5
    bend_length: float = 0.01
    doubles: float = 10.0


CHOSEN = PictureSettings()


def find_corners_better(picture: npt.ArrayLike, settings: PictureSettings = CHOSEN) -> FloatArray:
    """Find the corners (K, 2), (u, v) px, of the field's lines in a picture (H, W, 3).

    Raises
    ------
    ValueError
        If the picture is not RGB of uint8.
    """
    planes = take_apart(check_picture(picture))
    if planes is None:
        return np.zeros((0, 2))
    scale, (rows, columns), s = planes.scale, planes.carpet.shape, settings
    top = planes.first_row - s.horizon * rows

    def widest(points: FloatArray, _: FloatArray) -> FloatArray:
        return s.widening * np.maximum(points[:, 1] - top, 0.0) + s.slack * scale

    first_row = max(0, int(planes.first_row - 4 * scale))
    pieces = line_pieces(planes, first_row, widest, s.pieces)
    lines = merge(pieces, scale, s.lines)
    length = np.hypot(lines.ends[:, 2] - lines.ends[:, 0], lines.ends[:, 3] - lines.ends[:, 1])
    lines = lines.where(
        (length >= s.shortest * scale) & (lines.bend <= s.bend * scale + s.bend_length * length)
    )
    found = find_crossings(
        lines.ends,
        s.reach_width * lines.width,
        float(np.sin(s.steepest)),
        lambda points: np.full(len(points), s.reach * scale),
        lambda points: np.full(len(points), s.arm * scale),
    )
    inside = ((found.points >= 0) & (found.points <= (columns - 1, rows - 1))).all(axis=1)
    return without_doubles(found.points[inside], found.strength[inside], s.doubles * scale)
