"""Angles, rotations and poses, as the whole package uses them."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nao_course._internal.lazy_names import list_public
from nao_course.codec import register

__all__ = [
    "FloatArray",
    "Pose",
    "as_points",
    "finite",
    "pose_errors",
    "rotation_2d",
    "rotation_3d",
    "wrap_angle",
    "yaw_pitch_roll",
]
__dir__ = list_public(__name__)

FloatArray = npt.NDArray[np.float64]


@register
def wrap_angle(angle: npt.ArrayLike) -> FloatArray:
    """Wrap angles into (-pi, pi].

    Parameters
    ----------
    angle : array_like
        Angles of any shape, rad.

    Returns
    -------
    ndarray
        The same directions in (-pi, pi], with the same shape. Angles that are already there do not change by a bit.

    Examples
    --------
    >>> float(wrap_angle(3 * np.pi))
    3.141592653589793
    >>> wrap_angle([0.0, -np.pi]).tolist()
    [0.0, 3.141592653589793]
    """
    given = np.asarray(angle, dtype=float)
    # Filters wrap single angles very often, and this is seven times as fast.
    if given.ndim == 0 and -math.pi < given.item() <= math.pi:
        return given[()]
    wrapped = np.pi - (np.pi - given) % (2 * np.pi)
    wrapped = np.where(wrapped <= -np.pi, np.pi, wrapped)  # because the remainder may be rounded up to 2 pi
    return np.where((given > -np.pi) & (given <= np.pi), given, wrapped)[()]


def pose_errors(estimated: npt.ArrayLike, true: npt.ArrayLike) -> FloatArray:
    """Return estimated minus true poses (..., 3), with wrapped headings."""
    errors = np.asarray(np.asarray(estimated, dtype=float) - np.asarray(true, dtype=float))
    errors[..., 2] = wrap_angle(errors[..., 2])
    return errors


def finite(name: str, value: float) -> float:
    """Return `value` as a float, or raise an error if it is not a finite number.

    Parameters
    ----------
    name : str
        Name of the value in the error message.
    value : float
        Number to be checked.

    Returns
    -------
    float
        The same number.

    Raises
    ------
    ValueError
        If the value is not a finite number.
    """
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{name} must be a number, got {value!r}") from None
    except OverflowError:
        raise ValueError(
            f"{name} must be a finite number, got an integer that is too large for a float"
        ) from None
    if not np.isfinite(number):
        raise ValueError(f"{name} must be a finite number, got {number}")
    return number


def as_points(points: npt.ArrayLike, columns: int = 2, name: str = "points") -> FloatArray:
    """Return points as an array (N, `columns`); a single point becomes (1, `columns`).

    Parameters
    ----------
    points : array_like, shape (N, columns) or (columns,)
        Points, or a single point. An empty list gives the shape (0, columns).
    columns : int
        Number of coordinates of each point.
    name : str
        Name of the points in the error message.

    Returns
    -------
    ndarray, shape (N, columns)
        The points as floats.

    Raises
    ------
    ValueError
        If the array has another shape.
    """
    array = np.asarray(points, dtype=float)
    if array.size == 0:
        return np.empty((0, columns))
    array = np.atleast_2d(array)
    if array.ndim != 2 or array.shape[1] != columns:
        raise ValueError(f"{name} must have shape (N, {columns}), got {np.shape(points)}")
    return array


@register
def rotation_2d(angle: float) -> FloatArray:
    """Return the (2, 2) matrix of a counterclockwise rotation by `angle` in rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


def rotation_3d(yaw: float, pitch: float, roll: float) -> FloatArray:
    """Return the (3, 3) matrix of the rotation Rz(yaw) Ry(pitch) Rx(roll); angles in rad.

    The axes are x ahead, y to the left and z up. A positive yaw turns to the left, a positive pitch looks down, and a
    positive roll lowers the right side.
    """
    (cy, sy), (cp, sp), (cr, sr) = ((np.cos(a), np.sin(a)) for a in (yaw, pitch, roll))
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    return about_z @ about_y @ about_x


def yaw_pitch_roll(rotation: npt.ArrayLike) -> tuple[float, float, float]:
    """Return the angles (yaw, pitch, roll) in rad for which ``rotation_3d(*angles)`` equals `rotation`."""
    r = np.asarray(rotation, dtype=float)
    pitch = float(np.arcsin(np.clip(-r[2, 0], -1.0, 1.0)))
    return float(np.arctan2(r[1, 0], r[0, 0])), pitch, float(np.arctan2(r[2, 1], r[2, 2]))


@register
@dataclass(frozen=True)
class Pose:
    """A position and heading in the plane, or the rigid motion from the origin to them.

    Parameters
    ----------
    x, y : float
        Position in metres.
    theta : float
        Heading, rad counterclockwise from the x axis; wrapped into (-pi, pi].

    Raises
    ------
    ValueError
        If a value is not finite.

    Examples
    --------
    >>> Pose(1.0, 2.0, np.pi / 2) @ Pose(1.0, 0.0, 0.0)
    Pose(x=1.00, y=3.00, theta=1.571)
    """

    x: float = 0.0
    y: float = 0.0
    theta: float = 0.0

    def __post_init__(self) -> None:
        """Check the values and wrap the heading."""
        object.__setattr__(self, "x", finite("Pose: x (m)", self.x))
        object.__setattr__(self, "y", finite("Pose: y (m)", self.y))
        object.__setattr__(self, "theta", float(wrap_angle(finite("Pose: theta (rad)", self.theta))))

    def __repr__(self) -> str:
        """Show the pose rounded to centimetres and milliradians, without negative zeros."""
        return f"Pose(x={self.x:z.2f}, y={self.y:z.2f}, theta={self.theta:z.3f})"

    # --- values ---

    def as_array(self) -> FloatArray:
        """Return (x, y, theta) as an array of shape (3,)."""
        return np.array([self.x, self.y, self.theta])

    @classmethod
    def from_array(cls, values: npt.ArrayLike) -> Pose:
        """Make a pose from an array (x, y, theta)."""
        array = np.asarray(values, dtype=float)
        if array.shape != (3,):
            raise ValueError(f"a pose must have the shape (3,): x, y, theta; got {array.shape}")
        return cls(*array.tolist())

    # --- operations ---

    def __matmul__(self, other: Pose) -> Pose:
        """Compose two poses: return `other`, which is given in this pose's frame, in the parent frame."""
        x, y = self.to_parent([other.x, other.y])[0]
        return Pose(float(x), float(y), self.theta + other.theta)

    def inverse(self) -> Pose:
        """Return the pose p with ``p @ self == Pose()``."""
        x, y = -rotation_2d(-self.theta) @ np.array([self.x, self.y])
        return Pose(float(x), float(y), -self.theta)

    def to_parent(self, points: npt.ArrayLike) -> FloatArray:
        """Transform points (N, 2) from this pose's own frame to the frame in which the pose is given."""
        return as_points(points) @ rotation_2d(self.theta).T + (self.x, self.y)

    def to_local(self, points: npt.ArrayLike) -> FloatArray:
        """Transform points (N, 2) from the frame in which the pose is given to this pose's own frame."""
        return (as_points(points) - (self.x, self.y)) @ rotation_2d(self.theta)
