"""The parts of a scene that do not move, as plain data: field, goal, room, robot, cameras and viewpoints."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, get_args

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.plotting.style import STYLES
from nao_course.sim import NAO_V4, Field, NaoModel, Reality
from nao_course.sim.room import PIXEL, TOP, furnish
from nao_course.widgets.world.meshes import triangles
from nao_course.widgets.world.robot import STRIDE, camera_in_head, gait, links, posture
from nao_course.widgets.world.shells import shells

Preset = Literal["behind", "above", "goal"]
PRESETS: tuple[Preset, ...] = get_args(Preset)

CARPET, FLOOR, LINE, YELLOW, WHITE = "#58a06a", "#8d8a86", "#fbfbf8", "#f2c413", "#f3f4f2"
CONE = "#f5f7fa"
# Opacities; from the front, an opaque picture would hide the robot.
GHOST, PICTURE, PICTURE_FROM_FRONT = 0.45, 0.95, 0.3
WALLS_FADE, WALLS_INVISIBLE = 2.0, 2.8  # m: heights of a viewer between which the walls fade out
PICTURE_DISTANCE = 0.34  # m along a camera's optical axis at which its picture stands
FIELD_OF_VIEW = 0.68  # rad, vertical
GRID = (9, 7)  # corners of the mesh that a picture is drawn on, because the lens bends it
_UNIT = 1e-5  # m: unit of the robot's corners
_ARC_PIECES = 48


@dataclass(frozen=True)
class Viewpoint:
    """The place from which a scene is seen: on a sphere around a target.

    Parameters
    ----------
    azimuth, elevation : float
        Direction from the target to the viewer, rad: counterclockwise from the x axis, and above the horizon.
    distance : float
        Distance from the target, m.
    target : (float, float, float)
        The point in the middle of the view, m; an offset from the robot if the view follows it.
    follows : bool
        Whether the target moves with the robot and the azimuth is relative to its heading.
    """

    azimuth: float
    elevation: float
    distance: float
    target: tuple[float, float, float] = (0.0, 0.0, 0.0)
    follows: bool = False

    def data(self) -> dict[str, Any]:
        """Return the viewpoint as plain data, in m and rad."""
        return {
            "azimuth": round(self.azimuth, 4),
            "elevation": round(self.elevation, 4),
            "distance": round(self.distance, 4),
            "target": [round(float(each), 4) for each in self.target],
            "follows": self.follows,
        }


@dataclass(frozen=True, eq=False)
class Wall:
    """A painted upright plane of the room, which is seen from inside only.

    `corner` (3,) is the upper corner at the first column, m; `across` and `down` (3,) run along the whole upper edge
    and from it to the lower one, m; `inwards` (3,) is a unit vector into the room, and `paint` (rows, columns, 4) is
    RGB and opacity.
    """

    corner: FloatArray
    across: FloatArray
    down: FloatArray
    inwards: FloatArray
    paint: npt.NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class WorldScene:
    """The field, its room and the robot, with everything that the browser needs once.

    Of `reality`, the room's seed and amount of furniture are used.
    """

    field: Field
    reality: Reality
    model: NaoModel = NAO_V4

    @cached_property
    def carpet(self) -> FloatArray:
        """Corners (4, 2) of the carpet in the world frame, m, counterclockwise."""
        return self._world(_rectangle(*self.field.carpet))

    @cached_property
    def floor(self) -> FloatArray:
        """Corners (4, 2) of the floor between the walls in the world frame, m."""
        x0, y0, x1, y1 = self.field.carpet
        return self._world(_rectangle(x0 - 1.5, y0 - 1.5, x1 + 1.5, y1 + 1.5))

    @cached_property
    def lines(self) -> FloatArray:
        """Corners (N, 4, 2) of all white line segments in the world frame, m."""
        half = self.field.dimensions.line_width / 2
        pieces = []
        for x0, y0, x1, y1 in np.vstack([self.field.lines, self.field.mark_lines]):
            low, high = np.minimum((x0, y0), (x1, y1)) - half, np.maximum((x0, y0), (x1, y1)) + half
            pieces.append(_rectangle(*low, *high))
        for x, y, radius, first, last in self.field.arcs:
            angle = np.linspace(first, last, _ARC_PIECES + 1)
            ray = np.column_stack([np.cos(angle), np.sin(angle)])
            inner, outer = (x, y) + (radius - half) * ray, (x, y) + (radius + half) * ray
            pieces += list(np.stack([inner[:-1], outer[:-1], outer[1:], inner[1:]], axis=1))
        return self._world(np.array(pieces).reshape(-1, 2)).reshape(-1, 4, 2)

    @cached_property
    def posts(self) -> FloatArray:
        """Rods of the goals (N, 7): both ends in the world frame and the radius, m."""
        d = self.field.dimensions
        rods = [(x, y, 0.0, x, y, d.post_height, d.post_diameter / 2) for x, y in self.field.posts]
        rods += [(*ends[0], *ends[1], d.bar_diameter / 2) for ends in self.field.bars]
        found = np.array(rods).reshape(-1, 7)
        for columns in (slice(0, 2), slice(3, 5)):
            found[:, columns] = self._world(found[:, columns])
        return found

    @cached_property
    def walls(self) -> tuple[Wall, ...]:
        """The room's planes, the outermost of each side first."""
        turn = self.field.pose.to_parent
        zero = turn([[0.0, 0.0]])[0]
        found = []
        for curtain in furnish(self.field.carpet, self.reality.clutter, self.reality.seed):
            pixel = 2 * PIXEL  # the second copy is half as fine
            rows = round(TOP / pixel)
            paint = curtain.paint[1][:rows]
            opaque = 255 - paint[..., 3:].astype(np.float32)
            colour = np.clip(paint[..., :3] * 255.0 / np.maximum(opaque, 1.0), 0, 255)
            start, along, outwards = (
                turn([curtain.start])[0],
                turn([curtain.along])[0] - zero,
                turn([curtain.outwards])[0] - zero,
            )
            found.append(
                Wall(
                    np.array([*start, TOP]),
                    np.array([*along, 0.0]) * pixel * paint.shape[1],
                    np.array([0.0, 0.0, -pixel * rows]),
                    np.array([*-outwards, 0.0]),
                    np.dstack([colour, opaque]).astype(np.uint8),
                )
            )
        return tuple(found)

    @property
    def goal_colour(self) -> str:
        """Colour of the goals' rods."""
        return YELLOW if self.field.dimensions.goal_colour == "yellow" else WHITE

    @property
    def presets(self) -> dict[Preset, Viewpoint]:
        """The viewpoints that have a button, the first one at the beginning."""
        x0, y0, x1, y1 = self.field.carpet
        middle = self._world(np.array([[(x0 + x1) / 2, (y0 + y1) / 2], [x1 - 2.2, 0.0]]))
        turned = self.field.pose.theta
        largest = max((x1 - x0) / 1.6, y1 - y0)
        above = 1.06 * largest / 2 / np.tan(FIELD_OF_VIEW / 2)
        return {
            "behind": Viewpoint(np.pi - 0.5, 0.36, 1.9, (0.22, 0.0, 0.30), follows=True),
            "above": Viewpoint(turned - np.pi / 2, 1.55, float(above), (*middle[0], 0.0)),
            "goal": Viewpoint(turned + 0.22, 0.40, 3.3, (*middle[1], 0.2)),
        }

    def picture_rays(self, camera: str) -> FloatArray:
        """Return the rays (rows, columns, 2) of a picture's mesh: right and down, in focal lengths."""
        view = self.model.view(camera)
        (width, height), (columns, rows) = view.size, GRID
        u, v = np.meshgrid(np.linspace(-0.5, width - 0.5, columns), np.linspace(-0.5, height - 0.5, rows))
        pinhole = view.undistort(np.column_stack([u.ravel(), v.ravel()]))
        return np.asarray(((pinhole - view.centre) / view.focal).reshape(rows, columns, 2))

    def data(self) -> dict[str, Any]:
        """Return the scene as plain data: numbers, texts, lists, and bytes for the robot's corners and the paint."""
        return {
            "carpet": _rounded(self.carpet),
            "floor": _rounded(self.floor),
            "lines": _rounded(self.lines),
            "posts": _rounded(self.posts),
            "walls": [
                {
                    "corner": _rounded(wall.corner),
                    "across": _rounded(wall.across),
                    "down": _rounded(wall.down),
                    "inwards": _rounded(wall.inwards),
                    "paint": _webp(wall.paint),
                }
                for wall in self.walls
            ],
            "colours": {
                "carpet": CARPET,
                "floor": FLOOR,
                "lines": LINE,
                "goal": self.goal_colour,
                "cone": CONE,
            },
            "opacities": {"ghost": GHOST, "behind": PICTURE, "front": PICTURE_FROM_FRONT},
            "wallsFade": [WALLS_FADE, WALLS_INVISIBLE],
            "sources": {
                name: {"label": style.label, "colour": style.colour} for name, style in STYLES.items()
            },
            "robot": self._robot(),
            "cameras": {
                name: {
                    "pose": _rounded(camera_in_head(name, self.model), 6),
                    "rays": _rounded(self.picture_rays(name), 5),
                    "distance": PICTURE_DISTANCE,
                }
                for name in self.model.cameras
            },
            "fieldOfView": FIELD_OF_VIEW,
            "presets": {name: view.data() for name, view in self.presets.items()},
        }

    def _robot(self) -> dict[str, Any]:
        moving, table = gait(self.model)
        corners = np.stack([shape.points() for shape in shells()])
        return {
            "links": [
                {
                    "name": each.name,
                    "parent": each.parent,
                    "origin": list(each.origin),
                    "axis": list(each.axis),
                }
                for each in links(self.model)
            ],
            "shapes": [{"link": shape.link, "colour": shape.colour} for shape in shells()],
            "corners": np.rint(corners / _UNIT).astype("<i2").tobytes(),
            "unit": _UNIT,
            "triangles": triangles().astype("<u2").tobytes(),
            "rest": {name: round(angle, 4) for name, angle in posture(model=self.model).items()},
            "gait": {"joints": list(moving), "angles": _rounded(table, 4), "stride": STRIDE},
        }

    def _world(self, points: FloatArray) -> FloatArray:
        return self.field.pose.to_parent(points)


def _rectangle(x0: float, y0: float, x1: float, y1: float) -> FloatArray:
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])


def _rounded(values: FloatArray, digits: int = 4) -> Any:
    return np.round(values, digits).tolist()


def _webp(paint: npt.NDArray[np.uint8]) -> bytes:
    done, data = cv2.imencode(
        ".webp", cv2.cvtColor(paint, cv2.COLOR_RGBA2BGRA), [cv2.IMWRITE_WEBP_QUALITY, 60]
    )
    if not done:
        raise ValueError(f"OpenCV could not write a picture of shape {paint.shape}")
    return bytes(data)
