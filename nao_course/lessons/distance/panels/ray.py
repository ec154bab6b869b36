"""The ray of one pixel in space, and how far its point on the ground moves when the body tilts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray, Pose, as_points
from nao_course.lessons.distance.looks import HEAD_PITCH, usual_view
from nao_course.sim import NAO_V4, Field, Reality, render
from nao_course.widgets import Choice, Ray, Slider, WorldPanel, WorldView

POSE = Pose(0.5, 0.15, 0.0)
REALITY = Reality(seed=4, motion=0.0)
LANDMARKS = {
    "foot of the left goal post": (3.0, 0.7),
    "foot of the right goal post": (3.0, -0.7),
    "left corner of the goal area": (2.4, 1.1),
    "penalty mark": (1.2, 0.0),
}


class RayPanel(WorldPanel):
    """A robot whose body tilts, the ray from its camera to a landmark, and the ray that `pixel_to_ground` follows.

    Parameters
    ----------
    pixel_to_ground : callable
        The student's.
    """

    def __init__(self, pixel_to_ground: Callable[..., Any]) -> None:
        """Begin with an upright robot."""
        super().__init__(
            "The ray of a pixel",
            WorldView(Field(2012), reality=REALITY),
            self._follow,
            [
                Slider("tilt", "Body tilt", -3.0, 3.0, 0.1, 0.0, unit="°", tooltip="Positive to the front"),
                Choice("landmark", "Landmark", tuple(LANDMARKS)),
            ],
            student={"pixel_to_ground": pixel_to_ground},
            unfinished="Finish exercise 4.4 to see your ray.",
        )

    def _follow(self, values: Any, student: Any) -> Iterator[str]:
        """Draw the true ray, and the one of the student's function, which assumes an upright body."""
        tilt = float(np.radians(values.tilt))
        landmark = np.array(LANDMARKS[values.landmark])
        true_view = NAO_V4.view("bottom", 0.0, HEAD_PITCH, torso_pitch=tilt)
        pixel = true_view.project(POSE.to_local(landmark))
        true_ray = Ray((float(landmark[0]), float(landmark[1])))
        shown: dict[str, Any] = {"head": (0.0, HEAD_PITCH), "tilt": (tilt, 0.0)}
        self.world.update(POSE, pictures={"bottom": _picture(values.tilt)}, rays=[true_ray], **shown)
        u, v = pixel[0]
        yield f"The {values.landmark} appears at the pixel ({u:.1f}, {v:.1f})."
        point = as_points(student.pixel_to_ground(pixel, usual_view()), name="points on the ground")[0]
        if not np.isfinite(point).all():
            yield "For the assumed, upright camera, this pixel is at or above the horizon."
            return
        x, y = POSE.to_parent(point)[0].tolist()
        self.world.update(rays=[true_ray, Ray((x, y), source="ekf")])
        yield _compared(point, POSE.to_local(landmark)[0])


@cache
def _picture(tilt_deg: float) -> Any:
    """Return the picture (240, 320, 3) of a robot whose body is tilted to the front, degrees."""
    view = NAO_V4.view("bottom", 0.0, HEAD_PITCH, torso_pitch=float(np.radians(tilt_deg)))
    return render(Field(2012), POSE, view, REALITY, np.random.default_rng(0))[0]


def _compared(point: FloatArray, true: FloatArray) -> str:
    away, really = float(np.hypot(*point)), float(np.hypot(*true))
    off = 100 * (away - really)
    if abs(off) < 0.5:
        return f"Your function puts it {away:.2f} m away, which is right."
    return (
        f"Your function puts it {away:.2f} m away (blue), {abs(off):.0f} cm too {'far' if off > 0 else 'near'}: "
        f"it is {really:.2f} m away (black)."
    )
