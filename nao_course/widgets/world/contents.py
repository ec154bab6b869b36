"""What moves in a scene, as plain data: robots, estimate, rays and paths at one time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose, finite
from nao_course.plotting import as_path, ellipse_outlines
from nao_course.plotting.drawing import say_angle, say_place
from nao_course.plotting.style import style_of
from nao_course.slam import Estimate


@dataclass(frozen=True)
class Ray:
    """A ray from a robot's camera to a point.

    Parameters
    ----------
    point : (float, float) or (float, float, float)
        End of the ray in the world frame, m; a point with two coordinates is on the ground.
    camera : str
        Name of the camera, "top" or "bottom".
    source : str
        Robot whose camera it is, and whose colour the ray has: "truth", or the source of the estimate. Without an
        estimate, the ray of another source begins at the true pose with an upright body.
    """

    point: tuple[float, ...]
    camera: str = "bottom"
    source: str = "truth"

    def __post_init__(self) -> None:
        """Check the values, and add the height of a point on the ground."""
        values = [finite("Ray: point (m)", value) for value in self.point]
        if len(values) not in (2, 3):
            raise ValueError(f"Ray: point must have 2 or 3 coordinates in m, got {self.point!r}")
        object.__setattr__(self, "point", (*values, 0.0)[:3])
        style_of(self.source)


@dataclass(frozen=True, eq=False)
class WorldContents:
    """What a view of the world shows at one time.

    Poses are in the world frame, and the estimate's robot is translucent. `head` is yaw and pitch, rad, positive to the
    left and down; `tilt` is pitch and roll of the true body, rad, positive to the front and to the right. Each camera
    has its latest picture (H, W, 3), and each path by its source positions (N, 2), m.
    """

    truth: Pose | None = None
    estimate: Estimate | None = None
    head: tuple[float, float] = (0.0, 0.0)
    tilt: tuple[float, float] = (0.0, 0.0)
    pictures: Mapping[str, npt.NDArray[np.uint8]] = field(default_factory=dict)
    rays: tuple[Ray, ...] = ()
    paths: Mapping[str, FloatArray] = field(default_factory=dict)

    @property
    def ellipses(self) -> FloatArray:
        """Ellipses (N, 3, 2) that contain 95 %, m: the robot's and the landmarks' centres and two half axes.

        The half axes are conjugate: centre + cos(a) first + sin(a) second is the outline.
        """
        if self.estimate is None:
            return np.empty((0, 3, 2))
        centres = np.vstack([self.estimate.pose.as_array()[None, :2], self.estimate.landmarks])
        covariances = np.concatenate(
            [self.estimate.covariance[None, :2, :2], self.estimate.landmark_covariances]
        )
        quarters = ellipse_outlines(centres, covariances, corners=5)
        axes = quarters[:, :2] - centres[:, None]
        return np.concatenate([centres[:, None], axes], axis=1)

    def data(self) -> dict[str, Any]:
        """Return everything but pictures and paths as plain data, in m and rad, to a tenth of a millimetre."""
        estimate = self.estimate
        ellipses = self.ellipses
        return {
            "truth": _pose(self.truth),
            "estimate": None if estimate is None else _pose(estimate.pose),
            "head": np.round(self.head, 4).tolist(),
            "tilt": np.round(self.tilt, 5).tolist(),
            "ellipses": np.round(ellipses[np.isfinite(ellipses).all(axis=(1, 2))], 4).tolist(),
            "landmarks": []
            if estimate is None
            else [
                [round(float(x), 3), round(float(y), 3), kind]
                for (x, y), kind in zip(estimate.landmarks, estimate.kinds, strict=True)
                if np.isfinite((x, y)).all()
            ],
            "rays": [[each.source, each.camera, *(round(v, 4) for v in each.point)] for each in self.rays],
        }

    def summary(self) -> str:
        """Return the contents as text, for readers who cannot see the view."""
        words = []
        if self.truth is not None:
            words.append(f"robot at {say_place(self.truth.as_array())}")
        if self.estimate is not None:
            pose = self.estimate.pose
            words.append(f"estimated at {say_place(pose.as_array())}")
            if self.truth is not None:
                apart = np.hypot(pose.x - self.truth.x, pose.y - self.truth.y)
                words.append(f"{100 * apart:.0f} cm apart")
            if len(self.estimate.landmarks):
                words.append(f"{len(self.estimate.landmarks)} landmarks on the map")
        words.append(f"head yaw {say_angle(self.head[0])}, pitch {say_angle(self.head[1])}")
        if any(self.tilt):
            pitch, roll = np.degrees(self.tilt)
            words.append(f"body tilt {pitch:z.1f} deg to the front, {roll:z.1f} deg to the right")
        if self.pictures:
            words.append(f"picture of the {' and the '.join(self.pictures)} camera")
        if self.rays:
            words.append(f"{len(self.rays)} ray{'s' if len(self.rays) > 1 else ''} to the ground")
        return "; ".join(words)


def positions(path: Any) -> FloatArray:
    """Return the positions (N, 2) of a path in any form that `as_path` accepts, m."""
    return as_path(path)[:, :2]


def _pose(pose: Pose | None) -> list[float] | None:
    return None if pose is None else np.round(pose.as_array(), 4).tolist()
