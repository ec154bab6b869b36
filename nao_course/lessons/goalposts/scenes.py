"""Pictures of goal posts from known distances: what the lesson measures a detector on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.goalposts.measuring import REACH, Feet, FootMatch, match_feet
from nao_course.sim import NAO_V4, Field, Reality, render
from nao_course.sim.nao import TorsoTilt

HEAD_PITCH = float(np.radians(-24.6))  # as in the standard scenes: the bottom camera looks 15.1 degrees down
FIELD = Field(2012, half=False)  # the whole one: there a post can be 6 m away
_ROOMS = 8  # pictures in one room


@dataclass(frozen=True, eq=False)
class PostScene:
    """A picture with the feet of the posts in it.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    labels : ndarray of uint8, shape (H, W)
        The true ones: 0 other, 1 green, 2 yellow, 3 white.
    feet : Feet
        The truth.
    """

    pixels: npt.NDArray[np.uint8]
    labels: npt.NDArray[np.uint8]
    feet: Feet

    def match(self, points: npt.ArrayLike) -> FootMatch:
        """Hold points (N, 2) against the true feet, within 8 pixels at 240 rows."""
        return match_feet(points, self.feet, REACH * len(self.pixels) / 240)


def picture_from(pose: Pose, reality: Reality, rng: np.random.Generator, **angles: float) -> PostScene:
    """Take a picture of the whole field of 2012 with the bottom camera.

    Parameters
    ----------
    pose : Pose
        The robot's, in the field frame.
    reality : Reality
        How real it looks.
    rng : numpy.random.Generator
        Of the sensor's noise.
    **angles : float
        Head's yaw and pitch, torso's pitch and roll (``yaw``, ``pitch``, ``torso_pitch``, ``torso_roll``), rad.
    """
    angles = {"yaw": 0.0, "pitch": HEAD_PITCH, **angles}
    view = NAO_V4.view("bottom", angles.pop("yaw"), angles.pop("pitch"), (320, 240), **angles)
    pixels, truth = render(FIELD, pose, view, reality, rng)
    return PostScene(pixels, truth.labels, Feet.of(truth, FIELD))


def scenes_by_distance(number: int = 40, seed: int = 0) -> list[PostScene]:
    """Take pictures of posts from 0.6 to 6 m, evenly spread, in several rooms: the same at every call.

    Parameters
    ----------
    number : int
        How many.
    seed : int
        Which rooms and places.
    """
    lean = TorsoTilt()
    scenes = []
    for i, distance in enumerate(np.linspace(0.6, 6.0, number)):
        rng = np.random.default_rng([702, seed, i])
        pose, yaw = _place(distance, rng)
        scenes.append(
            picture_from(
                pose,
                Reality(seed=720 + 50 * seed + i % _ROOMS),
                rng,
                yaw=yaw,
                pitch=rng.normal(HEAD_PITCH, np.radians(1.0)),
                torso_pitch=rng.normal(0.0, lean.pitch),
                torso_roll=rng.normal(0.0, lean.roll),
            )
        )
    return scenes


def approach(distances: npt.ArrayLike, reality: Reality | None = None) -> list[PostScene]:
    """Take pictures of the left goal post on the way towards it, upright and straight ahead.

    Parameters
    ----------
    distances : array_like, shape (N,)
        From the robot to the middle of the post, metres.
    reality : Reality, optional
        How real they look; by default without any effect.
    """
    x, y = FIELD.posts[FIELD.posts[:, 0].argmax()]
    reality = reality or Reality.clean()
    return [
        picture_from(Pose(float(x - distance), float(y), 0.0), reality, np.random.default_rng([703, i]))
        for i, distance in enumerate(np.asarray(distances, dtype=float))
    ]


def measure(find: Callable[[Any], Any], scenes: Sequence[PostScene]) -> list[FootMatch]:
    """Run a detector on pictures: `find(pixels)` returns feet (K, 2)."""
    return [scene.match(find(scene.pixels.copy())) for scene in scenes]


def _place(distance: float, rng: np.random.Generator) -> tuple[Pose, float]:
    """A place on the field at this distance from one post of the goal at +x, and a head's yaw that shows the post."""
    posts: FloatArray = FIELD.posts[FIELD.posts[:, 0] > 0]
    while True:
        post = posts[rng.integers(len(posts))]
        direction = rng.uniform(np.pi / 2, 3 * np.pi / 2)  # behind the goal line there is nothing to see
        x, y = post + distance * np.array([np.cos(direction), np.sin(direction)])
        if -3.0 < x < 2.95 and abs(y) < 2.0:
            yaw = rng.uniform(-0.4, 0.4)
            aside = rng.uniform(-0.35, 0.35)
            return Pose(x, y, float(np.arctan2(post[1] - y, post[0] - x)) - yaw + aside), yaw
