"""A picture of a scene without a browser: a small renderer in NumPy and OpenCV."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from nao_course.geometry import FloatArray, Pose
from nao_course.plotting.style import style_of
from nao_course.widgets.world.canvas import SUPERSAMPLING, Canvas, Pixels, rgb
from nao_course.widgets.world.contents import WorldContents
from nao_course.widgets.world.meshes import triangles
from nao_course.widgets.world.robot import camera_in_head, forward_kinematics, posture
from nao_course.widgets.world.scene import (
    CARPET,
    CONE,
    FLOOR,
    GHOST,
    LINE,
    PICTURE,
    PICTURE_DISTANCE,
    PICTURE_FROM_FRONT,
    WALLS_FADE,
    WALLS_INVISIBLE,
    Viewpoint,
    WorldScene,
)
from nao_course.widgets.world.shells import shells

ON_GROUND, ON_CARPET = 0.002, 0.004  # m, heights of what lies there
_ROD_SIDES = 12


def render_world(
    scene: WorldScene, contents: WorldContents, viewpoint: Viewpoint, source: str, size: tuple[int, int]
) -> Pixels:
    """Render a scene and what moves in it as an RGB picture (H, W, 3) of (width, height) px."""
    width, height = (SUPERSAMPLING * each for each in size)
    canvas = Canvas(viewer(contents, viewpoint), (width, height))
    canvas.flat(_raised(scene.floor, 0.0)[None], FLOOR)
    shown = float(np.clip((WALLS_INVISIBLE - canvas.eye[2]) / (WALLS_INVISIBLE - WALLS_FADE), 0, 1))
    for wall in sorted(scene.walls, key=lambda each: -canvas.distance(each.corner + each.across / 2)):
        if wall.inwards @ (canvas.eye - wall.corner) > 0 and shown > 0:
            canvas.texture(wall.corner, wall.across, wall.down, wall.paint, shown)
    canvas.flat(_raised(scene.carpet, ON_GROUND)[None], CARPET)
    canvas.flat(_raised(scene.lines, ON_GROUND), LINE)
    _lay_on_carpet(canvas, contents, source)
    solid = [_rods(scene.posts, scene.goal_colour)]
    if contents.truth is not None:
        solid.append(_robot(contents, contents.truth, scene, contents.tilt))
        canvas.blend(_disc(contents.truth, 0.17)[None], "#10251a", 0.35)
    canvas.triangles([each for each in solid if len(each[0])])
    estimate = contents.estimate
    if estimate is not None:
        upright = _robot(contents, estimate.pose, scene, (0.0, 0.0), style_of(source).colour)
        canvas.triangles([upright], GHOST)
    _show_cameras(canvas, scene, contents, source)
    small = cv2.resize(canvas.pixels, size, interpolation=cv2.INTER_AREA)
    return np.asarray(small, dtype=np.uint8)


def viewer(contents: WorldContents, viewpoint: Viewpoint) -> tuple[FloatArray, FloatArray]:
    """Return the viewer's position and the target (3,), m, in the world frame."""
    robot = contents.truth or (contents.estimate.pose if contents.estimate is not None else Pose())
    base = robot if viewpoint.follows else Pose()
    target = np.array([*base.to_parent([viewpoint.target[:2]])[0], viewpoint.target[2]])
    azimuth, level = base.theta + viewpoint.azimuth, np.cos(viewpoint.elevation)
    away = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(viewpoint.elevation)])
    return target + viewpoint.distance * away, target


def _lay_on_carpet(canvas: Canvas, contents: WorldContents, source: str) -> None:
    """Draw paths, ellipses and landmarks."""
    for name, path in contents.paths.items():
        canvas.stroke(_raised(path, ON_CARPET), style_of(name).colour, 2.0)
    colour = style_of(source).colour
    angle = np.linspace(0, 2 * np.pi, 49)
    circle = np.stack([np.ones(49), np.cos(angle), np.sin(angle)])
    for ellipse in contents.ellipses[np.isfinite(contents.ellipses).all(axis=(1, 2))]:
        outline = _raised(circle.T @ ellipse, ON_CARPET)
        canvas.blend(outline[None, :-1], colour, 0.28)
        canvas.stroke(outline, colour, 1.3)
    if contents.estimate is not None:
        for x, y in contents.estimate.landmarks[np.isfinite(contents.estimate.landmarks).all(axis=1)]:
            canvas.flat(_disc(Pose(x, y), 0.035)[None], "#ffffff")
            canvas.flat(_disc(Pose(x, y), 0.025)[None], colour)


def _show_cameras(canvas: Canvas, scene: WorldScene, contents: WorldContents, source: str) -> None:
    """Draw the view cones with their pictures, and the rays."""
    shown = contents.truth or (contents.estimate.pose if contents.estimate is not None else None)
    if shown is None:
        return
    for name, pose in cameras(
        scene, contents, shown, contents.tilt if contents.truth else (0.0, 0.0)
    ).items():
        grid = scene.picture_rays(name)
        corners = grid[[0, 0, -1, -1], [0, -1, -1, 0]]
        rays = np.column_stack([np.ones(4), -corners])
        ends = pose[:3, 3] + PICTURE_DISTANCE * rays @ pose[:3, :3].T
        if name in contents.pictures:
            paint = _undistorted(scene, name, contents.pictures[name])
            in_front = pose[:3, 0] @ (canvas.eye - ends[0]) > 0
            opacity = PICTURE_FROM_FRONT if in_front else PICTURE
            canvas.texture(ends[0], ends[1] - ends[0], ends[3] - ends[0], paint, opacity)
        for end in ends:
            canvas.stroke(np.stack([pose[:3, 3], end]), CONE, 0.8, 0.9, hidden=True)
        canvas.stroke(ends[[0, 1, 2, 3, 0]], CONE, 1.0, 0.9, hidden=True)
    for ray in contents.rays:
        robot, tilt = contents.truth, contents.tilt
        if ray.source != "truth":
            robot = contents.estimate.pose if contents.estimate is not None else contents.truth
            tilt = (0.0, 0.0)
        if robot is not None:
            start = cameras(scene, contents, robot, tilt)[ray.camera][:3, 3]
            colour = style_of(ray.source).colour
            canvas.stroke(np.stack([start, ray.point]), colour, 1.6, hidden=True)
            canvas.flat(_disc(Pose(*ray.point[:2]), 0.03)[None], colour)


def cameras(
    scene: WorldScene, contents: WorldContents, robot: Pose, tilt: tuple[float, float]
) -> dict[str, FloatArray]:
    """Return the pose (4, 4) of each camera (axes ahead, left, up) in the world frame."""
    head = forward_kinematics(posture(contents.head, model=scene.model), scene.model, tilt)["HeadPitch"]
    return {name: _lifted(robot) @ head @ camera_in_head(name, scene.model) for name in scene.model.cameras}


def _undistorted(scene: WorldScene, camera: str, pixels: Pixels) -> Pixels:
    """Return the picture (H, W, 4) of a pinhole camera with the same corners."""
    height, width = pixels.shape[:2]
    view = scene.model.view(camera, size=(width, height))
    corners = scene.picture_rays(camera)[[0, -1], [0, -1]] * view.focal + view.centre
    (u0, v0), (u1, v1) = corners
    u, v = np.meshgrid(np.linspace(u0, u1, width), np.linspace(v0, v1, height))
    bent = view.distort(np.column_stack([u.ravel(), v.ravel()])).reshape(height, width, 2)
    maps = bent.astype(np.float32)
    flat = cv2.remap(pixels, maps[..., 0], maps[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.dstack([flat, np.full((height, width), 255, dtype=np.uint8)])


def _robot(
    contents: WorldContents,
    pose: Pose,
    scene: WorldScene,
    tilt: tuple[float, float],
    colour: str | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return the triangles (M, 3, 3) of a robot and their colours (M, 3); `colour` is for all of them."""
    frames = forward_kinematics(posture(contents.head, model=scene.model), scene.model, tilt)
    placed = _lifted(pose)
    corners, colours = [], []
    for shape in shells():
        frame = placed @ frames[shape.link]
        points = shape.points() @ frame[:3, :3].T + frame[:3, 3]
        corners.append(points[triangles()])
        colours.append(np.tile(rgb(colour or shape.colour), (len(triangles()), 1)))
    return np.concatenate(corners), np.concatenate(colours)


def _rods(rods: FloatArray, colour: str) -> tuple[FloatArray, FloatArray]:
    """Return the triangles of round rods (N, 7), and their colours."""
    angle = np.arange(_ROD_SIDES) * 2 * np.pi / _ROD_SIDES
    steps = np.linspace(0, 1, 9)
    found = []
    for start, end, radius in _ends(rods):
        along = (end - start) / np.linalg.norm(end - start)
        first = np.cross(along, (1.0, 0.0, 0.0) if abs(along[0]) < 0.5 else (0.0, 1.0, 0.0))
        first /= np.linalg.norm(first)
        ring = np.outer(np.cos(angle), first) + np.outer(np.sin(angle), np.cross(along, first))
        rings = start + steps[:, None, None] * (end - start) + radius * ring
        low, high = rings[:-1], rings[1:]
        low_after, high_after = np.roll(low, -1, axis=1), np.roll(high, -1, axis=1)
        found += [np.stack([low, low_after, high_after], axis=2), np.stack([low, high_after, high], axis=2)]
    corners = np.concatenate([each.reshape(-1, 3, 3) for each in found])
    return corners, np.tile(rgb(colour), (len(corners), 1))


def _ends(rods: FloatArray) -> Iterator[tuple[FloatArray, FloatArray, float]]:
    for rod in rods:
        yield rod[:3], rod[3:6], float(rod[6])


def _lifted(pose: Pose) -> FloatArray:
    """Return a pose in the plane as a matrix (4, 4)."""
    c, s = np.cos(pose.theta), np.sin(pose.theta)
    return np.array([[c, -s, 0, pose.x], [s, c, 0, pose.y], [0, 0, 1, 0], [0, 0, 0, 1.0]])


def _raised(points: FloatArray, height: float) -> FloatArray:
    """Return points (..., 2) with a height."""
    return np.concatenate([points, np.full((*points.shape[:-1], 1), height)], axis=-1)


def _disc(pose: Pose, radius: float) -> FloatArray:
    """Return a disc (24, 3) on the carpet."""
    angle = np.arange(24) * 2 * np.pi / 24
    ring = np.column_stack([np.cos(angle), np.sin(angle)]) * radius
    return _raised(ring + (pose.x, pose.y), ON_CARPET)
