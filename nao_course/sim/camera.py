"""Camera models: position and orientation of the NAO's cameras, and the projection of points to pixels."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
import numpy.typing as npt

from nao_course.codec import register
from nao_course.geometry import FloatArray, Pose, as_points, finite, rotation_3d, yaw_pitch_roll

Stance = Literal["standing", "walking"]
LARGEST_SIZE = 8192


def check_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return (width, height) in pixels as ints; raise a ValueError unless both are integers from 1 to 8192."""
    wrong = f"size must be (width, height), whole pixels from 1 to {LARGEST_SIZE}, such as (320, 240); got {size!r}"
    try:
        width, height = (int(value) for value in size)
        whole = (width, height) == tuple(size)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(wrong) from None
    if not whole or not all(1 <= value <= LARGEST_SIZE for value in (width, height)):
        raise ValueError(wrong)
    return width, height


@register
@dataclass(frozen=True)
class CameraView:
    """The true or assumed parameters of a camera: size, field of view, lens, position and angles.

    The model is a pinhole camera with one radial distortion term. The principal point is the centre of the picture,
    ((width - 1) / 2, (height - 1) / 2). Position and angles are given in the robot frame: the origin is on the ground
    below the robot, x points ahead, y to the left and z up.

    Parameters
    ----------
    size : (int, int)
        Width and height of the picture, px.
    hfov, vfov : float
        Horizontal and vertical field of view without lens distortion, rad.
    height : float
        Height of the camera above the ground, m.
    pitch : float
        Angle of the optical axis below the horizon, rad; positive is down.
    yaw : float
        Angle of the optical axis, rad; positive is to the left.
    roll : float
        Rotation about the optical axis, rad. If it is positive, the camera is tilted to its right, so the horizon rises
        to the right in the picture.
    offset : (float, float)
        Position (x, y) of the camera in the robot frame, m.
    k1 : float
        Lens distortion: a point at the radius r from the centre, in focal lengths, appears at r (1 + k1 r^2). Negative
        for a barrel distortion.

    Raises
    ------
    ValueError
        If a value is not finite or not possible.
    """

    size: tuple[int, int]
    hfov: float
    vfov: float
    height: float
    pitch: float
    yaw: float = 0.0
    roll: float = 0.0
    offset: tuple[float, float] = (0.0, 0.0)
    k1: float = 0.0

    def __post_init__(self) -> None:
        """Check the values."""
        object.__setattr__(self, "size", check_size(self.size))
        for name in ("hfov", "vfov", "height", "pitch", "yaw", "roll", "k1"):
            object.__setattr__(self, name, finite(f"CameraView: {name}", getattr(self, name)))
        for name in ("hfov", "vfov"):
            if not 0 < getattr(self, name) < np.pi:
                raise ValueError(
                    f"CameraView: {name} must be between 0 and pi radians, got {getattr(self, name)}"
                )
        for name in ("pitch", "roll"):
            if abs(getattr(self, name)) > 2 * np.pi:
                raise ValueError(f"CameraView: {name} must be in radians, got {getattr(self, name)}")
        if self.height <= 0:
            raise ValueError(f"CameraView: height must be above the ground (m), got {self.height}")
        x, y = self.offset
        object.__setattr__(self, "offset", (finite("offset x (m)", x), finite("offset y (m)", y)))

    @classmethod
    def from_fov(
        cls, size: tuple[int, int], hfov: float, height: float, pitch: float, k1: float = 0.0
    ) -> CameraView:
        """Make the view of a camera with square pixels, such as a phone's, from a horizontal field of view in rad."""
        width, rows = check_size(size)
        if not 0 < finite("hfov (rad)", hfov) < np.pi:
            raise ValueError(f"hfov must be between 0 and pi radians, got {hfov}")
        vfov = 2 * np.arctan(np.tan(hfov / 2) * rows / width)
        return cls((width, rows), hfov, float(vfov), height, pitch, k1=k1)

    # --- derived values ---

    @property
    def focal(self) -> tuple[float, float]:
        """Focal lengths (fx, fy), px."""
        width, height = self.size
        return float(width / 2 / np.tan(self.hfov / 2)), float(height / 2 / np.tan(self.vfov / 2))

    @property
    def centre(self) -> tuple[float, float]:
        """Principal point (u, v), px."""
        return (self.size[0] - 1) / 2, (self.size[1] - 1) / 2

    @property
    def rotation(self) -> FloatArray:
        """Camera axes (ahead, left, up) as the columns of a (3, 3) matrix, in the robot frame."""
        return rotation_3d(self.yaw, self.pitch, self.roll)

    @property
    def position(self) -> FloatArray:
        """Position (3,) of the camera in the robot frame, m."""
        return np.array([*self.offset, self.height])

    def at_size(self, size: tuple[int, int]) -> CameraView:
        """Return the view of the same camera at another resolution."""
        return replace(self, size=size)

    # --- points to pixels ---

    def project(self, points: npt.ArrayLike, pose: Pose | None = None) -> FloatArray:
        """Project points to pixels, with lens distortion.

        Parameters
        ----------
        points : array_like, shape (N, 2) or (N, 3)
            Points, m. Points with two coordinates are on the ground.
        pose : Pose, optional
            Pose of the robot in the frame of the points. By default, the points are given in the robot frame.

        Returns
        -------
        ndarray, shape (N, 2)
            Pixels (u, v), which may be outside the picture. NaN for a point behind the camera, and for a point so far
            to the side that the lens model is not valid.

        Examples
        --------
        >>> view = CameraView((320, 240), np.radians(61), np.radians(47.6), height=0.48, pitch=0.3)
        >>> view.project([[0.48 / np.tan(0.3), 0.0]]).round(1).tolist()
        [[159.5, 119.5]]
        """
        array = np.asarray(points, dtype=float)
        ground = array.size == 0 or array.shape[-1] == 2
        array = as_points(array, 2 if ground else 3)
        xy = array[:, :2] if pose is None else pose.to_local(array[:, :2])
        z = np.zeros(len(array)) if ground else array[:, 2]
        ahead, left, up = ((np.column_stack([xy, z]) - self.position) @ self.rotation).T
        with np.errstate(divide="ignore", invalid="ignore"):
            rays = np.where(ahead > 1e-9, np.array([-left / ahead, -up / ahead]), np.nan).T
        return self._distorted(rays) * self.focal + self.centre

    def distort(self, pixels: npt.ArrayLike) -> FloatArray:
        """Apply the lens distortion to pixels (N, 2) of an undistorted picture."""
        return (
            self._distorted((as_points(pixels, name="pixels") - self.centre) / self.focal) * self.focal
            + self.centre
        )

    def undistort(self, pixels: npt.ArrayLike) -> FloatArray:
        """Remove the lens distortion from pixels (N, 2).

        Returns
        -------
        ndarray, shape (N, 2)
            Pixels in a picture of the pinhole camera; NaN if no ray of the lens model reaches a pixel.
        """
        seen = (as_points(pixels, name="pixels") - self.centre) / self.focal
        if self.k1 == 0:
            return seen * self.focal + self.centre
        r_seen = np.hypot(seen[:, 0], seen[:, 1])
        r = r_seen.copy()
        limit = self.lens_limit
        with np.errstate(divide="ignore", invalid="ignore"):
            for _ in range(12):  # Newton on r (1 + k1 r^2) = r_seen
                r -= (r * (1 + self.k1 * r**2) - r_seen) / (1 + 3 * self.k1 * r**2)
                r = np.clip(r, 0.0, limit)
            wrong = np.abs(r * (1 + self.k1 * r**2) - r_seen) > 1e-9
            scale = np.where(wrong, np.nan, np.where(r_seen == 0, 1.0, r / r_seen))
        return seen * scale[:, None] * self.focal + self.centre

    def contains(self, pixels: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return for each pixel (N, 2) whether it is inside the picture; False for NaN."""
        uv = as_points(pixels, name="pixels")
        return np.asarray(((uv >= -0.5) & (uv <= np.array(self.size) - 0.5)).all(axis=1))

    def visible_ground(self) -> tuple[float, float] | None:
        """Return the distances at which the visible ground begins and ends along the direction of the camera, m.

        Distances up to 20 m are examined: the end is infinite if the ground is visible there. None if no ground is.
        """
        ahead = np.linspace(0.0, 20.0, 2001)
        along = ahead[:, None] * [np.cos(self.yaw), np.sin(self.yaw)] + self.offset
        seen = ahead[self.contains(self.project(along))]
        if not len(seen):
            return None
        return float(seen[0]), float(seen[-1]) if seen[-1] < ahead[-1] else np.inf

    @property
    def lens_limit(self) -> float:
        """Radius, in focal lengths, beyond which the model of a barrel lens would fold the picture back onto itself."""
        return 1e6 if self.k1 > -1e-12 else float(1 / np.sqrt(-3 * self.k1))

    def _distorted(self, rays: FloatArray) -> FloatArray:
        """Apply the lens distortion to coordinates (N, 2) in focal lengths."""
        r2 = (rays**2).sum(axis=1, keepdims=True)
        return np.where(r2 <= self.lens_limit**2, rays * (1 + self.k1 * r2), np.nan)


def _without_lens(fov: float, k1: float) -> float:
    """Return the field of view, rad, of the same picture without lens distortion."""
    edge = np.tan(fov / 2)
    return float(2 * np.arctan(edge * (1 + k1 * edge**2)))


@dataclass(frozen=True)
class CameraMount:
    """Position of a camera ahead of and above the neck joint, m, and its pitch, rad, positive down; head frame."""

    x: float
    z: float
    pitch: float


@dataclass(frozen=True)
class NaoModel:
    """The dimensions of one generation of the robot: links, cameras, joint limits and lens.

    Parameters
    ----------
    name : str
        Name of the generation.
    hfov, vfov : float
        Fields of view of both cameras from the maker's documentation, with lens distortion, rad.
    k1 : float
        Lens distortion of both cameras; see `CameraView`.
    neck_offset, hip_offset, thigh, tibia, foot : float
        Lengths NeckOffsetZ, HipOffsetZ, ThighLength, TibiaLength and FootHeight of the maker's documentation, m.
    crouch : float
        How much lower the body is while walking, because the knees are bent, m.
    cameras : mapping of str to CameraMount
        Mounts of the cameras "top" and "bottom".
    yaw_limits, pitch_limits : (float, float)
        Limits of the head's joints, rad; a positive pitch looks down.
    """

    name: str
    hfov: float
    vfov: float
    k1: float
    neck_offset: float = 0.1265
    hip_offset: float = 0.085
    thigh: float = 0.100
    tibia: float = 0.1029
    foot: float = 0.04519
    crouch: float = 0.018
    cameras: Mapping[str, CameraMount] = field(
        default_factory=lambda: MappingProxyType(
            {
                "top": CameraMount(0.0587, 0.0636, float(np.radians(1.2))),
                "bottom": CameraMount(0.0507, 0.0177, float(np.radians(39.7))),
            }
        )
    )
    yaw_limits: tuple[float, float] = (float(np.radians(-119.5)), float(np.radians(119.5)))
    pitch_limits: tuple[float, float] = (float(np.radians(-38.5)), float(np.radians(29.5)))

    def neck_height(self, stance: Stance = "walking") -> float:
        """Return the height of the neck joint above the ground, m."""
        if stance not in ("standing", "walking"):
            raise ValueError(f'stance must be "standing" or "walking", got {stance!r}')
        straight = self.neck_offset + self.hip_offset + self.thigh + self.tibia + self.foot
        return straight - (self.crouch if stance == "walking" else 0.0)

    def check_camera(self, camera: str) -> str:
        """Return the name of a camera unchanged after checking it.

        Raises
        ------
        ValueError
            If the model has no camera of that name.
        """
        if camera not in self.cameras:
            raise ValueError(f"camera must be one of {sorted(self.cameras)}, got {camera!r}")
        return camera

    def check_head(self, yaw: float, pitch: float) -> tuple[float, float]:
        """Return the joint angles of the head, rad, as floats after checking them.

        Raises
        ------
        ValueError
            If an angle exceeds the limits of its joint.
        """
        for name, angle, (low, high) in (("yaw", yaw, self.yaw_limits), ("pitch", pitch, self.pitch_limits)):
            if not low - 1e-9 <= finite(f"head {name} (rad)", angle) <= high + 1e-9:
                raise ValueError(
                    f"head {name} must be within {low:.3f}..{high:.3f} rad "
                    f"({np.degrees(low):.1f}..{np.degrees(high):.1f} deg), the joint's limits; got {angle:.3f}"
                )
        return float(yaw), float(pitch)

    def view(
        self,
        camera: str = "bottom",
        yaw: float = 0.0,
        pitch: float = 0.0,
        size: tuple[int, int] = (320, 240),
        stance: Stance = "walking",
        torso_pitch: float = 0.0,
        torso_roll: float = 0.0,
    ) -> CameraView:
        """Return the view of a camera, computed along the chain ground, torso, neck, head, camera.

        Parameters
        ----------
        camera : "top" or "bottom"
            Name of the camera.
        yaw, pitch : float
            Angles of the head's joints, rad.
        size : (int, int)
            Width and height of the picture, px.
        stance : "standing" or "walking"
            Posture: with straight legs, or with bent knees as in walking.
        torso_pitch, torso_roll : float
            Tilt of the whole body about the point on the ground below it, rad; positive to the front and to the right.

        Returns
        -------
        CameraView
            View in the robot frame.

        Raises
        ------
        ValueError
            If the camera or the stance is unknown, the size impossible, or an angle beyond the limits of its joint.

        Examples
        --------
        >>> round(NAO_V4.view("top", stance="standing").height, 3)
        0.523
        """
        mount = self.cameras[self.check_camera(camera)]
        yaw, pitch = self.check_head(yaw, pitch)
        torso = rotation_3d(
            0.0, finite("torso_pitch (rad)", torso_pitch), finite("torso_roll (rad)", torso_roll)
        )
        head = rotation_3d(yaw, pitch, 0.0)
        x, y, z = torso @ (head @ [mount.x, 0.0, mount.z] + [0.0, 0.0, self.neck_height(stance)])
        angles = yaw_pitch_roll(torso @ head @ rotation_3d(0.0, mount.pitch, 0.0))
        return CameraView(
            size,
            _without_lens(self.hfov, self.k1),
            _without_lens(self.vfov, self.k1),
            height=float(z),
            yaw=angles[0],
            pitch=angles[1],
            roll=angles[2],
            offset=(float(x), float(y)),
            k1=self.k1,
        )


# The values are from the maker's documentation of NAO V4 (MT9M114) and V6 (OV5640), except for the lens distortion. It
# was fitted to real pictures of a V4 (benchmarks/simulator/reality.py), and is assumed to be the same for V6.
NAO_V4 = NaoModel("NAO V4", hfov=float(np.radians(60.97)), vfov=float(np.radians(47.64)), k1=-0.08)
NAO_V6 = NaoModel("NAO V6", hfov=float(np.radians(56.3)), vfov=float(np.radians(43.7)), k1=-0.08)
