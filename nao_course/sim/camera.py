"""The NAO's head and cameras: where each camera is, where it looks, and which pixel a point falls on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Literal

import numpy as np
import numpy.typing as npt

from nao_course.exercises.codec import register
from nao_course.geometry import FloatArray, Pose, as_points, finite, rotation_3d, yaw_pitch_roll

Stance = Literal["standing", "walking"]
LARGEST_SIZE = 8192


def check_size(size: tuple[int, int]) -> tuple[int, int]:
    """Return a picture's (width, height) in pixels as ints.

    Raises
    ------
    ValueError
        If it is not two whole numbers from 1 to 8192.
    """
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
    """What is known, or believed, of the camera that took a picture.

    A pinhole camera with one radial lens term; the principal point is the picture's middle,
    ((width - 1) / 2, (height - 1) / 2). Its position and angles are given in the robot frame
    (origin on the ground below the robot, x ahead, y left, z up).

    Parameters
    ----------
    size : (int, int)
        Width and height in pixels.
    hfov, vfov : float
        Horizontal and vertical field of view without the lens term, radians.
    height : float
        Of the camera above the ground, metres.
    pitch : float
        Of the optical axis below the horizon, radians (positive: down).
    yaw : float
        Of the optical axis, radians (positive: left).
    roll : float
        About the optical axis, radians (positive: the camera leans to its right,
        so the horizon rises to the right in the picture).
    offset : (float, float)
        Of the camera over the ground in the robot frame, metres.
    k1 : float
        Lens: a point at r from the middle (in focal lengths) appears at r (1 + k1 r^2). Negative: barrel.

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
        """Check every value."""
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
        """Make the view of a camera with square pixels, such as a phone's, from its horizontal field of view (rad)."""
        width, rows = check_size(size)
        if not 0 < finite("hfov (rad)", hfov) < np.pi:
            raise ValueError(f"hfov must be between 0 and pi radians, got {hfov}")
        vfov = 2 * np.arctan(np.tan(hfov / 2) * rows / width)
        return cls((width, rows), hfov, float(vfov), height, pitch, k1=k1)

    # --- what follows from the values ---

    @property
    def focal(self) -> tuple[float, float]:
        """Focal lengths (fx, fy) in pixels."""
        width, height = self.size
        return float(width / 2 / np.tan(self.hfov / 2)), float(height / 2 / np.tan(self.vfov / 2))

    @property
    def centre(self) -> tuple[float, float]:
        """Principal point (u, v) in pixels."""
        return (self.size[0] - 1) / 2, (self.size[1] - 1) / 2

    @property
    def rotation(self) -> FloatArray:
        """Camera axes (ahead, left, up) as the columns of a (3, 3) matrix, in the robot frame."""
        return rotation_3d(self.yaw, self.pitch, self.roll)

    @property
    def position(self) -> FloatArray:
        """Camera position (3,) in the robot frame, metres."""
        return np.array([*self.offset, self.height])

    def at_size(self, size: tuple[int, int]) -> CameraView:
        """Return the same camera read out at another resolution."""
        return replace(self, size=size)

    # --- points to pixels ---

    def project(self, points: npt.ArrayLike, pose: Pose | None = None) -> FloatArray:
        """Pixels on which points fall, lens included.

        Parameters
        ----------
        points : array_like, shape (N, 2) or (N, 3)
            Metres; without a third column they lie on the ground.
        pose : Pose, optional
            The robot's pose in the frame of the points; without it they are in the robot frame.

        Returns
        -------
        ndarray, shape (N, 2)
            (u, v), also outside the picture; NaN for a point behind the camera or so far aside that the
            lens model does not hold.

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
        """Pixels (N, 2) of a picture without the lens term, where the lens puts them."""
        return (
            self._distorted((as_points(pixels, name="pixels") - self.centre) / self.focal) * self.focal
            + self.centre
        )

    def undistort(self, pixels: npt.ArrayLike) -> FloatArray:
        """Remove the lens: where pixels (N, 2) would be in a picture of the pinhole camera.

        Returns
        -------
        ndarray, shape (N, 2)
            NaN where no ray of the lens model can come from.
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
        """Return, for pixels (N, 2), which lie in the picture; NaN does not."""
        uv = as_points(pixels, name="pixels")
        return np.asarray(((uv >= -0.5) & (uv <= np.array(self.size) - 0.5)).all(axis=1))

    @property
    def lens_limit(self) -> float:
        """Beyond this radius (in focal lengths) a barrel lens would fold the picture back onto itself."""
        return 1e6 if self.k1 > -1e-12 else float(1 / np.sqrt(-3 * self.k1))

    def _distorted(self, rays: FloatArray) -> FloatArray:
        """Apply the lens to (N, 2) coordinates in focal lengths."""
        r2 = (rays**2).sum(axis=1, keepdims=True)
        return np.where(r2 <= self.lens_limit**2, rays * (1 + self.k1 * r2), np.nan)


def _without_lens(fov: float, k1: float) -> float:
    """Field of view (rad) that the same picture would have without its lens term."""
    edge = np.tan(fov / 2)
    return float(2 * np.arctan(edge * (1 + k1 * edge**2)))


@dataclass(frozen=True)
class CameraMount:
    """A camera in the head frame: x ahead and z up of the neck joint (m), and pitch (rad, positive down)."""

    x: float
    z: float
    pitch: float


@dataclass(frozen=True)
class NaoModel:
    """One row of a table for each generation of the robot: links, cameras, joint limits and lens.

    Parameters
    ----------
    name : str
        The maker's name of the generation.
    hfov, vfov, k1 : float
        Of both cameras: fields of view as the maker gives them, lens included (rad), and lens term.
    neck_offset, hip_offset, thigh, tibia, foot : float
        The maker's NeckOffsetZ, HipOffsetZ, ThighLength, TibiaLength and FootHeight, metres.
    crouch : float
        How much lower the body is in the walking stance, metres.
    cameras : mapping of str to CameraMount
        "top" and "bottom".
    yaw_limits, pitch_limits : (float, float)
        Of the head's joints, radians; positive pitch looks down.
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
        """Height of the neck joint above the ground in metres."""
        if stance not in ("standing", "walking"):
            raise ValueError(f'stance must be "standing" or "walking", got {stance!r}')
        straight = self.neck_offset + self.hip_offset + self.thigh + self.tibia + self.foot
        return straight - (self.crouch if stance == "walking" else 0.0)

    def check_camera(self, camera: str) -> str:
        """Return the camera's name.

        Raises
        ------
        ValueError
            If this model has no such camera.
        """
        if camera not in self.cameras:
            raise ValueError(f"camera must be one of {sorted(self.cameras)}, got {camera!r}")
        return camera

    def check_head(self, yaw: float, pitch: float) -> tuple[float, float]:
        """Return the head's joint angles (rad) as floats.

        Raises
        ------
        ValueError
            If one is beyond its joint's limits.
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
        """View of a camera, by the chain ground, torso, neck, head, camera.

        Parameters
        ----------
        camera : "top" or "bottom"
            Which one.
        yaw, pitch : float
            The head's joints, radians.
        size : (int, int)
            Of the picture, pixels.
        stance : "standing" or "walking"
            Straight legs, or the bent knees a NAO walks with.
        torso_pitch, torso_roll : float
            How the whole body leans, about the point on the ground below it, radians (positive: to the
            front, to the right).

        Returns
        -------
        CameraView
            In the robot frame.

        Raises
        ------
        ValueError
            For an unknown camera or stance, an impossible size, or an angle beyond its joint.

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


# The maker's documentation, NAO V4 (MT9M114) and V6 (OV5640). The lens term is not the maker's: it is what
# the real V4 pictures show (benchmarks/reality); for V6 it is assumed to be the same.
NAO_V4 = NaoModel("NAO V4", hfov=float(np.radians(60.97)), vfov=float(np.radians(47.64)), k1=-0.08)
NAO_V6 = NaoModel("NAO V6", hfov=float(np.radians(56.3)), vfov=float(np.radians(43.7)), k1=-0.08)
