"""Pictures of goal posts at known distances, on which the lesson measures a detector."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.goalposts.measuring import Feet, FootMatch, match_feet
from nao_course.metrics import REACH
from nao_course.sim import NAO_V4, CameraView, Field, PictureTruth, Reality, SimulatedNao, render
from nao_course.sim.nao import TorsoTilt
from nao_course.sim.render import YELLOW

HEAD_PITCH = float(np.radians(-24.6))  # as in the standard scenes: the bottom camera looks 15.1 degrees down
FIELD = Field(2012, half=False)  # the whole one: there a post can be 6 m away
_ROOMS = 4


@dataclass(frozen=True, eq=False)
class PostScene:
    """A picture with the feet of the posts in it.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    labels : ndarray of uint8, shape (H, W)
        True labels: 0 other, 1 green, 2 yellow, 3 white.
    feet : Feet
        The truth.
    view : CameraView
        The camera's true view.
    """

    pixels: npt.NDArray[np.uint8]
    labels: npt.NDArray[np.uint8]
    feet: Feet
    view: CameraView

    @classmethod
    def of(cls, pixels: npt.NDArray[np.uint8], truth: PictureTruth, field: Field) -> PostScene:
        """Return the scene of a picture, its ground truth and the field on which it was taken."""
        return cls(pixels, truth.labels, Feet.of(truth, field), truth.view)

    @property
    def nearest(self) -> FloatArray:
        """Pixel (u, v) of the nearest foot in the picture."""
        return self.feet.pixels[self.feet.distances.argmin()]

    def post_pixels(self) -> int:
        """Return the number of yellow pixels in the column of the nearest foot."""
        return int((self.labels[:, round(self.nearest[0])] == YELLOW).sum())

    def match(self, points: npt.ArrayLike) -> FootMatch:
        """Match points (N, 2) with the true feet, within 8 pixels at 240 rows."""
        return match_feet(points, self.feet, REACH * len(self.pixels) / 240)


def picture_from(
    pose: Pose,
    reality: Reality,
    rng: np.random.Generator,
    yaw: float = 0.0,
    pitch: float = HEAD_PITCH,
    torso_pitch: float = 0.0,
    torso_roll: float = 0.0,
) -> PostScene:
    """Take a picture of the whole field of 2012 with the bottom camera.

    Parameters
    ----------
    pose : Pose
        Pose of the robot in the field frame.
    reality : Reality
        Effects of the picture.
    rng : numpy.random.Generator
        Generator of the sensor's noise.
    yaw, pitch : float
        Angles of the head in rad, positive to the left and down.
    torso_pitch, torso_roll : float
        Body tilt in rad.
    """
    view = NAO_V4.view("bottom", yaw, pitch, (320, 240), torso_pitch=torso_pitch, torso_roll=torso_roll)
    pixels, truth = render(FIELD, pose, view, reality, rng)
    return PostScene.of(pixels, truth, FIELD)


def scenes_by_distance(number: int = 40, seed: int = 0) -> list[PostScene]:
    """Take pictures of posts at evenly spaced distances from 0.6 to 6 m, in four rooms; every call returns the same.

    Parameters
    ----------
    number : int
        Number of pictures.
    seed : int
        Seed of the rooms and places.
    """
    distances = np.linspace(0.6, 6.0, number)
    return [
        _scene(distances[i], Reality(seed=720 + 50 * seed + room), np.random.default_rng([702, seed, i]))
        for room in range(_ROOMS)
        for i in range(room, number, _ROOMS)  # a room after the other: to furnish one takes longest
    ]


def _scene(distance: float, reality: Reality, rng: np.random.Generator) -> PostScene:
    """Return a picture of a post at a distance, from a robot with an unknown body tilt."""
    lean = TorsoTilt()
    pose, yaw = _place(distance, rng)
    return picture_from(
        pose,
        reality,
        rng,
        yaw=yaw,
        pitch=rng.normal(HEAD_PITCH, np.radians(1.0)),
        torso_pitch=rng.normal(0.0, lean.pitch),
        torso_roll=rng.normal(0.0, lean.roll),
    )


def approach(distances: npt.ArrayLike, reality: Reality | None = None) -> list[PostScene]:
    """Take pictures of the left goal post from several distances, with the robot upright and facing it.

    Parameters
    ----------
    distances : array_like, shape (N,)
        Distances from the robot to the centre of the post in m.
    reality : Reality, optional
        Effects in the pictures; none by default.
    """
    x, y = FIELD.posts[FIELD.posts[:, 0].argmax()]
    reality = reality or Reality.clean()
    return [
        picture_from(Pose(float(x - distance), float(y), 0.0), reality, np.random.default_rng([703, i]))
        for i, distance in enumerate(np.asarray(distances, dtype=float))
    ]


def turning_head(degrees: Sequence[float] = (25.0, 0.0, -25.0)) -> dict[str, npt.NDArray[np.uint8]]:
    """Return a picture of the goal for each yaw of the head, in degrees to the left, by a title with the angle."""
    nao = SimulatedNao(Field(2012), Pose(1.0, -0.1, 0.0), rng=8)
    pictures = {}
    for yaw in degrees:
        nao.look(yaw=float(np.radians(yaw)), pitch=HEAD_PITCH)
        title = (
            f"head {abs(yaw):.0f}° to the {'left' if yaw > 0 else 'right'}" if yaw else "head straight ahead"
        )
        pictures[title] = nao.take_picture("bottom").pixels
    return pictures


def robot_before(pixels: npt.NDArray[np.uint8], foot: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    """Return a copy of a picture with a grey robot, roughly drawn, that hides the foot at (u, v)."""
    shown = pixels.copy()
    size = len(shown) / 240
    u, v = (round(float(each)) for each in np.asarray(foot))
    for (dx, dy), (width, height), grey in (
        ((0, -8), (26, 34), 205),
        ((-14, 22), (9, 16), 185),
        ((14, 22), (9, 16), 185),
        ((0, -50), (15, 13), 225),
    ):
        centre, axes = (
            (round(u + dx * size), round(v + dy * size)),
            (round(width * size), round(height * size)),
        )
        cv2.ellipse(shown, centre, axes, 0, 0, 360, (grey, grey, grey), -1, cv2.LINE_AA)
    return shown


def post_height(
    distance: npt.ArrayLike, view: CameraView, height: float = FIELD.dimensions.post_height
) -> FloatArray:
    """Compute the height of a goal post in pixels, in the middle of the picture, by equation 2.1 of the lesson.

    Parameters
    ----------
    distance : array_like
        Distance on the ground from the camera to the post in m.
    view : CameraView
        View with the camera's focal length, height and pitch.
    height : float
        Height of the post in m.
    """
    d, h, p = np.asarray(distance, dtype=float), view.height, view.pitch
    depth_foot = d * np.cos(p) + h * np.sin(p)
    depth_top = d * np.cos(p) + (h - height) * np.sin(p)
    return np.asarray(view.focal[1] * height * d / (depth_foot * depth_top))


def match_scenes(find: Callable[[Any], Any], scenes: Sequence[PostScene]) -> list[FootMatch]:
    """Run a detector on pictures: `find(pixels)` returns feet (K, 2)."""
    return [scene.match(find(scene.pixels.copy())) for scene in scenes]


def _place(distance: float, rng: np.random.Generator) -> tuple[Pose, float]:
    """Return a pose at this distance from a post of the goal at +x, and a head yaw that shows the post."""
    posts: FloatArray = FIELD.posts[FIELD.posts[:, 0] > 0]
    while True:
        post = posts[rng.integers(len(posts))]
        direction = rng.uniform(np.pi / 2, 3 * np.pi / 2)  # behind the goal line there is nothing to see
        x, y = post + distance * np.array([np.cos(direction), np.sin(direction)])
        if -3.0 < x < 2.95 and abs(y) < 2.0:
            yaw = rng.uniform(-0.4, 0.4)
            aside = rng.uniform(-0.35, 0.35)
            return Pose(x, y, float(np.arctan2(post[1] - y, post[0] - x)) - yaw + aside), yaw
