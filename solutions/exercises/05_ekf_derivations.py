"""Lesson 05, EKF derivations: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy

from nao_course.exercises import Case, Close, Derivative, Exercise, LessonPlan, Mistake, Question, Written
from nao_course.geometry import Pose, rotation_2d, wrap_angle

Array = npt.NDArray[Any]
Function = Callable[..., Any]

POSE_COLUMNS = ("by x", "by y", "by theta")


def as_lists(*lines: str) -> dict[str, str]:
    """Mutants that return lists where arrays are asked for: a check takes both."""
    return dict.fromkeys(lines, "a list of the same numbers is taken for an array")


# --- places to try things at ---


def random_pose(rng: np.random.Generator) -> Array:
    """A pose on the field, its heading anywhere."""
    return np.array([rng.uniform(-4, 4), rng.uniform(-3, 3), rng.uniform(-3.1, 3.1)])


def random_control(rng: np.random.Generator) -> Array:
    """A step and a turn that are not small."""
    return np.array([rng.uniform(0.4, 2.0), rng.uniform(0.3, 1.2) * rng.choice([-1, 1])])


def random_measurement(rng: np.random.Generator) -> Array:
    """A landmark anywhere round the robot, its range not near 1 m."""
    return np.array([rng.uniform(0.2, 2.9) * rng.choice([-1, 1]), rng.uniform(1.6, 5.0)])


def random_covariance(rng: np.random.Generator, size: int = 3) -> Array:
    """A covariance without symmetry of any other kind."""
    root = rng.normal(0, 0.3, (size, size))
    return root @ root.T + 0.02 * np.eye(size)


def seen(pose: Array, measurement: Array) -> Array:
    """The landmark that a measurement from a pose would belong to."""
    bearing, distance = measurement
    return np.array(Pose(*pose).to_parent([distance * math.cos(bearing), distance * math.sin(bearing)])[0])


FACING = np.array([1.0, 0.5, 0.0])  # along the x axis
LEFT = np.array([0.5, -1.0, np.pi / 2])
SLANTED = np.array([-2.0, 1.5, 2.5])
NEARLY_ROUND = np.array([0.3, 0.4, -3.1])


# --- changing a right answer: the same slips are made in every Jacobian ---


def with_change(right: Function, change: Callable[..., Any]) -> Function:
    """The right answer with something changed: ``change(answer, *arguments)``."""

    def function(*arguments: Any) -> Any:
        return change(right(*arguments), *arguments)

    return function


def called_with(right: Function, *, heading: Function = lambda theta, *rest: theta) -> Function:
    """The right function, asked with another heading than the pose's."""

    def function(pose: Any, *rest: Any) -> Any:
        x, y, theta = pose
        return right(np.array([x, y, heading(theta, *rest)]), *rest)

    return function


def factors(*rows: tuple[float, ...]) -> Function:
    """Multiply each entry of a matrix by a number: -1 for a wrong sign, 0 for a missing entry."""
    return lambda matrix, *arguments: np.asarray(matrix) * np.array(rows)


def in_part(number: int, change: Function) -> Function:
    """Change one matrix of a tuple of them."""

    def changed(matrices: Any, *arguments: Any) -> Any:
        return tuple(
            change(matrix, *arguments) if place == number else matrix for place, matrix in enumerate(matrices)
        )

    return changed


def transposed(matrix: Any, *arguments: Any) -> Any:
    """Rows for columns."""
    return np.asarray(matrix).T


def rows_swapped(matrix: Any, *arguments: Any) -> Any:
    """The last row first."""
    return np.asarray(matrix)[::-1]


def columns_swapped(matrix: Any, *arguments: Any) -> Any:
    """The last column first."""
    return np.asarray(matrix)[:, ::-1]


def heading_in_degrees(theta: float, *rest: Any) -> float:
    """A heading taken as if NumPy counted in degrees."""
    return math.radians(theta)


def no_heading(theta: float, *rest: Any) -> float:
    """A robot that always looks along the x axis."""
    return 0.0


def differences(
    model: Function, at: Any, *rest: Any, angles: tuple[int, ...] = (), step: float = 1e-6
) -> Array:
    """Central differences of ``model(at, *rest)``; rows that are angles are taken the short way round."""
    at = np.asarray(at, dtype=float)
    columns = []
    for shift in step * np.eye(len(at)):
        change = np.asarray(model(at + shift, *rest)) - np.asarray(model(at - shift, *rest))
        for row in angles:
            change[row] = wrap_angle(change[row])
        columns.append(change / (2 * step))
    return np.array(columns).T


@cache
def compiled(rows: str, by: str, names: str) -> Function:
    """A Jacobian that SymPy derives and turns into a function of the named numbers."""
    symbols = {name: sympy.Symbol(name) for name in names.split()}
    model = sympy.Matrix([sympy.sympify(row, locals=symbols) for row in rows.split(";")])
    derived = model.jacobian([symbols[name] for name in by.split()])
    return sympy.lambdify(list(symbols.values()), derived, "numpy")  # type: ignore[no-any-return]


# --- 5.1 predict_pose ---


def _moved(pose: Any, control: Any) -> Array:
    x, y, theta = pose
    distance, turn = control
    return np.array([x + distance * math.cos(theta), y + distance * math.sin(theta), theta + turn])


def _moved_by_poses(pose: Any, control: Any) -> Array:
    return (Pose(*pose) @ Pose(control[0], 0.0, control[1])).as_array()


def _moved_by_rotation(pose: Any, control: Any) -> Array:
    pose, control = np.asarray(pose), np.asarray(control)
    return pose + np.append(rotation_2d(pose[2]) @ [control[0], 0.0], control[1])


def _moved_by_complex(pose: Any, control: Any) -> list[float]:
    end = complex(pose[0], pose[1]) + cmath.rect(control[0], pose[2])
    return [end.real, end.imag, cmath.phase(cmath.exp(1j * (pose[2] + control[1])))]


def _moves_turned_first(pose: Any, control: Any) -> Array:
    x, y, theta = pose
    return _moved((x, y, theta + control[1]), (control[0], 0.0))


def _moves_public() -> list[Case]:
    return [
        Case((FACING, np.array([0.8, 0.5])), "heading along the x axis"),
        Case((LEFT, np.array([0.4, -0.3])), "heading along the y axis"),
        Case((SLANTED, np.array([1.2, 0.6])), "a heading of 143 degrees"),
        Case((NEARLY_ROUND, np.array([0.5, -0.4])), "a turn that goes beyond -180 degrees"),
        Case((SLANTED, np.array([-0.3, 0.2])), "backwards"),
        Case((SLANTED, np.array([0.0, 1.0])), "a turn on the spot"),
    ]


def _moves_hidden(rng: np.random.Generator) -> list[Case]:
    cases = [Case((random_pose(rng), random_control(rng))) for _ in range(8)]
    return [*cases, Case((random_pose(rng), np.array([-0.7, 0.4])))]


PREDICT_POSE = Exercise(
    name="predict_pose",
    points=1,
    stars=1,
    public=_moves_public,
    hidden=_moves_hidden,
    comparison=Close(period=(0, 0, 2 * np.pi), names=("x", "y", "theta")),
    hints=(
        "Equation 5.1 has three rows, and the answer three numbers. x, y, theta = pose takes the pose apart.",
        "np.array([x + distance times the cosine, y + distance times the sine, theta + turn]); the angle in cosine and sine is the old heading.",
    ),
    mistakes=[
        Mistake(
            "turns first",
            _moves_turned_first,
            "You drive along theta + alpha. This robot drives first and turns last: cosine and sine are of the old heading.",
        ),
        Mistake(
            "cosine and sine swapped",
            lambda pose, control: _moved_by(pose, control, math.sin, math.cos),
            "Cosine and sine are swapped: with heading 0 the robot drives along x, and cos(0) is 1.",
        ),
        Mistake(
            "heading sign",
            lambda pose, control: _moved_by(pose, control, math.cos, lambda angle: -math.sin(angle)),
            "y goes the wrong way: a positive heading looks to the left, towards larger y, so d sin(theta) is added.",
        ),
        Mistake(
            "degrees",
            lambda pose, control: _moved_by(
                pose,
                control,
                lambda angle: math.cos(math.radians(angle)),
                lambda angle: math.sin(math.radians(angle)),
            ),
            "The heading is in radians already, as np.cos and np.sin want it.",
        ),
        Mistake(
            "turn forgotten",
            lambda pose, control: _moved(pose, (control[0], 0.0)),
            "The heading stays as it was. The robot turns by alpha after the drive.",
        ),
        Mistake(
            "the change alone",
            lambda pose, control: _moved(pose, control) - np.asarray(pose),
            "That is the change of the pose. Add the old pose to it.",
        ),
        Mistake(
            "in the robot's frame",
            lambda pose, control: np.asarray(pose) + [control[0], 0.0, control[1]],
            "You add d to x whatever the heading is. d is along the robot; the pose is in the frame of the field.",
        ),
        Mistake(
            "turn subtracted",
            lambda pose, control: _moved(pose, (control[0], -control[1])),
            "The turn has the wrong sign: positive is to the left, and headings count to the left, too.",
        ),
        Mistake(
            "heading halfway",
            lambda pose, control: (
                _moved((*pose[:2], pose[2] + control[1] / 2), control) - [0, 0, control[1] / 2]
            ),
            "You drive along theta + alpha / 2, as if the robot turned on its way. It drives straight, along its old heading, and turns afterwards.",
        ),
        Mistake(
            "turn for heading",
            lambda pose, control: _moved(pose, control) - [0, 0, pose[2]],
            "Your new heading is alpha alone. The robot turns by alpha: add it to theta.",
        ),
        Mistake(
            "heading in degrees",
            lambda pose, control: _moved(pose, control) * [1, 1, 180 / np.pi],
            "Your new heading is in degrees. It is wanted in radians.",
        ),
        Mistake(
            "backwards",
            lambda pose, control: _moved(pose, (-control[0], control[1])),
            "Your robot drives backwards: the displacement is added, x + d cos(theta).",
        ),
        Mistake(
            "never backwards",
            lambda pose, control: _moved(pose, (abs(control[0]), control[1])),
            "A negative distance drives backwards; in your answer it drives ahead.",
        ),
    ],
    alternatives={
        "composed poses": _moved_by_poses,
        "a rotation matrix": _moved_by_rotation,
        "complex numbers, wrapped": _moved_by_complex,
    },
    equivalents=as_lists("return [x + distance * np.cos(theta), y + distance * np.sin(theta), theta + turn]"),
)


def _moved_by(pose: Any, control: Any, along_x: Function, along_y: Function) -> Array:
    x, y, theta = pose
    distance, turn = control
    return np.array([x + distance * along_x(theta), y + distance * along_y(theta), theta + turn])


# --- 5.2 expected_measurement ---


def _measured(pose: Any, landmark: Any) -> Array:
    x, y, theta = pose
    dx, dy = landmark[0] - x, landmark[1] - y
    return np.array([float(wrap_angle(math.atan2(dy, dx) - theta)), math.hypot(dx, dy)])


def _measured_in_robot_frame(pose: Any, landmark: Any) -> Array:
    ahead, left = Pose(*pose).to_local(landmark)[0]
    return np.array([np.arctan2(left, ahead), np.hypot(ahead, left)])


def _measured_by_complex(pose: Any, landmark: Any) -> tuple[float, float]:
    seen_from = complex(landmark[0] - pose[0], landmark[1] - pose[1]) * cmath.exp(-1j * pose[2])
    distance, bearing = cmath.polar(seen_from)
    return bearing, distance


def _measured_float32(pose: Any, landmark: Any) -> Array:
    difference = np.asarray(landmark) - np.asarray(pose)[:2]
    bearing = np.arctan2(difference[1], difference[0]) - pose[2]
    while bearing > np.pi:
        bearing -= 2 * np.pi
    while bearing <= -np.pi:
        bearing += 2 * np.pi
    return np.array([bearing, np.sqrt((difference**2).sum())], dtype=np.float32)


def _by_direction(direction: Function, wrap: Function = wrap_angle) -> Function:
    """The measurement with another direction to the landmark: ``direction(dx, dy, theta)``, then wrapped."""

    def function(pose: Any, landmark: Any) -> Array:
        x, y, theta = pose
        dx, dy = landmark[0] - x, landmark[1] - y
        return np.array([float(wrap(direction(dx, dy, theta))), math.hypot(dx, dy)])

    return function


def _looks_public() -> list[Case]:
    return [
        Case((FACING, np.array([3.0, 1.5])), "a landmark ahead to the left"),
        Case((FACING, np.array([-1.0, 1.3])), "a landmark behind the robot"),
        Case((LEFT, np.array([2.5, -2.0])), "a robot that looks along y"),
        Case((SLANTED, np.array([-3.4, 0.2])), "a heading of 143 degrees, a landmark beyond -180 degrees"),
        Case((NEARLY_ROUND, np.array([-1.8, 0.9])), "a heading of -178 degrees, a landmark ahead"),
        Case((SLANTED, np.array([-1.5, 1.6])), "a landmark very near"),
    ]


def _looks_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for number in range(12):
        pose = random_pose(rng)
        if number % 3 == 0:
            pose[2] = rng.uniform(2.6, 3.1) * rng.choice([-1, 1])
        cases.append(Case((pose, seen(pose, random_measurement(rng)))))
    return cases


EXPECTED_MEASUREMENT = Exercise(
    name="expected_measurement",
    points=1,
    stars=1,
    public=_looks_public,
    hidden=_looks_hidden,
    comparison=Close(names=("bearing", "range")),
    hints=(
        "First dx and dy, from the robot to the landmark. Equation 5.2 has the rest; wrap_angle(angle) is there for the bearing.",
        "np.arctan2 wants dy first. Subtract theta from its result, and wrap that difference: not the parts of it.",
    ),
    mistakes=[
        Mistake(
            "range first",
            lambda pose, landmark: _measured(pose, landmark)[::-1],
            "You return (range, bearing). In this course a measurement is (bearing, range).",
        ),
        Mistake(
            "not wrapped",
            _by_direction(lambda dx, dy, theta: math.atan2(dy, dx) - theta, wrap=float),
            "A bearing of yours lies outside (-pi, pi]. The difference of two angles has to be wrapped: wrap_angle(...).",
        ),
        Mistake(
            "arctan for arctan2",
            _by_direction(lambda dx, dy, theta: math.atan(dy / dx) - theta),
            "np.arctan(dy / dx) cannot tell a landmark behind from one ahead. np.arctan2(dy, dx) can.",
        ),
        Mistake(
            "heading forgotten",
            _by_direction(lambda dx, dy, theta: math.atan2(dy, dx)),
            "That is the direction in the field's frame. A bearing counts from where the robot looks: subtract theta.",
        ),
        Mistake(
            "heading added",
            _by_direction(lambda dx, dy, theta: math.atan2(dy, dx) + theta),
            "You add the heading. A robot that turns left sees everything move to the right: theta is subtracted.",
        ),
        Mistake(
            "from the landmark",
            _by_direction(lambda dx, dy, theta: math.atan2(-dy, -dx) - theta),
            "You look from the landmark to the robot: dx is l_x - x, not x - l_x.",
        ),
        Mistake(
            "arctan2 the other way",
            _by_direction(lambda dx, dy, theta: math.atan2(dx, dy) - theta),
            "np.arctan2 takes y first: np.arctan2(dy, dx).",
        ),
        Mistake(
            "wrapped to 0 to 2 pi",
            _by_direction(
                lambda dx, dy, theta: math.atan2(dy, dx) - theta, wrap=lambda angle: angle % (2 * np.pi)
            ),
            "Your bearings go from 0 to 2 pi. The course's go from -pi to pi: a landmark to the right is negative.",
        ),
        Mistake(
            "degrees",
            _by_direction(
                lambda dx, dy, theta: math.atan2(dy, dx) - theta,
                wrap=lambda angle: math.degrees(wrap_angle(angle)),
            ),
            "The bearing is wanted in radians.",
        ),
        Mistake(
            "arctan2 the other way, not wrapped",
            _by_direction(lambda dx, dy, theta: math.atan2(dx, dy) - theta, wrap=float),
            "Two things: np.arctan2 takes y first, and the difference has to be wrapped.",
        ),
        Mistake(
            "range first, not wrapped",
            lambda pose, landmark: _by_direction(
                lambda dx, dy, theta: math.atan2(dy, dx) - theta, wrap=float
            )(pose, landmark)[::-1],
            "Two things: a measurement is (bearing, range), and the bearing has to be wrapped.",
        ),
        Mistake(
            "root forgotten",
            lambda pose, landmark: _measured(pose, landmark) ** [1, 2],
            "Your range is the squared distance: the root is missing.",
        ),
        Mistake(
            "to the right",
            _by_direction(lambda dx, dy, theta: theta - math.atan2(dy, dx)),
            "Your bearings are positive to the right. They count to the left, as headings do: the direction minus theta.",
        ),
        Mistake(
            "from the field's origin",
            lambda pose, landmark: _measured((0.0, 0.0, pose[2]), landmark),
            "You look from the middle of the field: subtract the robot's x and y from the landmark's first.",
        ),
        Mistake(
            "heading taken for degrees",
            _by_direction(lambda dx, dy, theta: math.atan2(dy, dx) - math.radians(theta)),
            "The heading is in radians already.",
        ),
        Mistake(
            "wrapped on one side",
            _by_direction(
                lambda dx, dy, theta: math.atan2(dy, dx) - theta,
                wrap=lambda angle: angle - 2 * np.pi if angle > np.pi else angle,
            ),
            "You bring angles above pi down, and none below -pi up. wrap_angle does both.",
        ),
        Mistake(
            "without a side",
            _by_direction(lambda dx, dy, theta: abs(float(wrap_angle(math.atan2(dy, dx) - theta)))),
            "Your bearings have no sign: a cosine cannot tell left from right.",
        ),
        Mistake(
            "round the corner",
            lambda pose, landmark: np.array(
                [_measured(pose, landmark)[0], np.abs(landmark - np.asarray(pose)[:2]).sum()]
            ),
            "Your range is the way along both axes. The range is the straight one: the root of the sum of the squares.",
        ),
    ],
    alternatives={
        "in the robot's frame": _measured_in_robot_frame,
        "complex numbers": _measured_by_complex,
        "float32, wrapped by a loop": _measured_float32,
    },
    equivalents=as_lists("return [wrap_angle(np.arctan2(dy, dx) - theta), np.hypot(dx, dy)]")
    | {
        "return np.array([wrap_angle(np.arctan2(dy, dx) - theta), np.hypot(dy, dx)])": "a root of the same two squares"
    },
)


# --- 5.3 landmark_position ---


def _position(pose: Any, measurement: Any) -> Array:
    x, y, theta = pose
    bearing, distance = measurement
    return np.array([x + distance * math.cos(theta + bearing), y + distance * math.sin(theta + bearing)])


def _position_by_frames(pose: Any, measurement: Any) -> Array:
    return seen(np.asarray(pose), np.asarray(measurement))


def _position_by_rotation(pose: Any, measurement: Any) -> Array:
    in_robot = measurement[1] * np.array([np.cos(measurement[0]), np.sin(measurement[0])])
    return np.asarray(pose)[:2] + rotation_2d(pose[2]) @ in_robot


def _position_by_complex(pose: Any, measurement: Any) -> list[float]:
    point = complex(pose[0], pose[1]) + cmath.rect(measurement[1], pose[2] + measurement[0])
    return [point.real, point.imag]


def _reports_swap(pose: Any, measurement: Any) -> Array:
    x, y, theta = pose
    ahead, left = measurement[1] * math.cos(measurement[0]), measurement[1] * math.sin(measurement[0])
    return np.array(
        [
            x + math.cos(theta) * ahead - math.sin(theta) * left,
            y + math.sin(theta) * left + math.cos(theta) * ahead,
        ]
    )


def _by_angle(angle: Function) -> Function:
    """The landmark in another direction: ``angle(theta, bearing)``."""

    def function(pose: Any, measurement: Any) -> Array:
        x, y, theta = pose
        return _position((x, y, 0.0), (angle(theta, measurement[0]), measurement[1]))

    return function


def _polar_public() -> list[Case]:
    return [
        Case((FACING, np.array([0.4, 2.0])), "heading along the x axis"),
        Case((LEFT, np.array([-0.6, 1.5])), "a robot that looks along y"),
        Case((SLANTED, np.array([1.2, 3.0])), "a heading of 143 degrees"),
        Case((NEARLY_ROUND, np.array([-0.5, 2.5])), "heading and bearing beyond -180 degrees"),
        Case((SLANTED, np.array([2.6, 0.4])), "a landmark near by, behind"),
        Case((SLANTED, np.array([-0.3, 0.0])), "a range of nothing"),
    ]


def _polar_hidden(rng: np.random.Generator) -> list[Case]:
    return [Case((random_pose(rng), random_measurement(rng))) for _ in range(10)]


LANDMARK_POSITION = Exercise(
    name="landmark_position",
    points=1,
    stars=1,
    public=_polar_public,
    hidden=_polar_hidden,
    comparison=Close(names=("x", "y")),
    hints=(
        "In which direction does the landmark lie, as seen from above, if the robot looks along theta and sees it at beta?",
        "It is r away from the robot, in the direction theta + beta: cosine for x, sine for y, and the robot's place added.",
    ),
    mistakes=[
        Mistake(
            "heading forgotten",
            _by_angle(lambda theta, bearing: bearing),
            "You place the landmark as if the robot looked along x: the bearing counts from its heading, so theta is added.",
        ),
        Mistake(
            "bearing subtracted",
            _by_angle(lambda theta, bearing: theta - bearing),
            "You subtract the bearing. It is positive to the left, as headings are: theta + beta.",
        ),
        Mistake(
            "heading subtracted",
            _by_angle(lambda theta, bearing: bearing - theta),
            "You subtract the heading, as in equation 5.2. Here you go the other way: theta + beta.",
        ),
        Mistake(
            "the report's page",
            _reports_swap,
            "Your y has l_x and l_y of the robot's frame swapped, as the report's handwritten page 1.3 has: the rotation's second row is (sin, cos), "
            "for (l_x, l_y) in this order.",
        ),
        Mistake(
            "cosine and sine swapped",
            _by_angle(lambda theta, bearing: np.pi / 2 - theta - bearing),
            "Cosine and sine are swapped: the cosine belongs to x.",
        ),
        Mistake(
            "place forgotten",
            lambda pose, measurement: _position((0.0, 0.0, pose[2]), measurement),
            "The robot's own place is missing: add x and y.",
        ),
        Mistake(
            "in the robot's frame",
            lambda pose, measurement: _position((0.0, 0.0, 0.0), measurement),
            "That is the landmark in the robot's frame. Turn it by theta, then shift it by (x, y).",
        ),
        Mistake(
            "range first",
            lambda pose, measurement: _position(pose, measurement[::-1]),
            "You take the measurement as (range, bearing). It is (bearing, range).",
        ),
        Mistake(
            "degrees",
            _by_angle(lambda theta, bearing: math.radians(theta + bearing)),
            "Heading and bearing are in radians already.",
        ),
        Mistake(
            "bearing forgotten",
            _by_angle(lambda theta, bearing: theta),
            "You place the landmark straight ahead: the bearing is missing, theta + beta.",
        ),
        Mistake(
            "behind",
            _by_angle(lambda theta, bearing: theta + bearing + np.pi),
            "Your landmark lies on the opposite side of the robot: the way to it is added, x + r cos(theta + beta).",
        ),
        Mistake(
            "the cosine twice",
            lambda pose, measurement: _position(pose, measurement)[0] - pose[0] + np.asarray(pose)[:2],
            "Both of your rows have the cosine: the sine belongs to y.",
        ),
        Mistake(
            "shifted, then turned",
            lambda pose, measurement: rotation_2d(pose[2]) @ (_position((*pose[:2], 0.0), measurement)),
            "You turn the robot's own place along with the landmark: turn first, then add x and y.",
        ),
    ],
    alternatives={
        "poses and frames": _position_by_frames,
        "a rotation matrix": _position_by_rotation,
        "complex numbers": _position_by_complex,
    },
    equivalents=as_lists(
        "return [x + distance * np.cos(theta + bearing), y + distance * np.sin(theta + bearing)]"
    ),
)


# --- 5.4 motion_jacobians ---


def _motion_slopes(pose: Any, control: Any) -> tuple[Array, Array]:
    c, s = math.cos(pose[2]), math.sin(pose[2])
    by_pose = np.eye(3)
    by_pose[:2, 2] = -control[0] * s, control[0] * c
    by_noise = np.eye(3)
    by_noise[:2, :2] = [[c, -s], [s, c]]
    return by_pose, by_noise


def _noisy(noise: Any, pose: Any, control: Any) -> Array:
    pose = np.asarray(pose)
    along, across, turn = noise
    return pose + np.append(rotation_2d(pose[2]) @ [control[0] + along, across], control[1] + turn)


def _motion_by_differences(pose: Any, control: Any) -> tuple[Array, Array]:
    by_pose = differences(_moved, pose, control, angles=(2,))
    return by_pose, differences(_noisy, np.zeros(3), pose, control, angles=(2,))


_MOTION = "x + (d + e_x) * cos(t) - e_y * sin(t); y + (d + e_x) * sin(t) + e_y * cos(t); t + a + e_a"
_MOTION_NAMES = "x y t d a e_x e_y e_a"


def _motion_by_sympy(pose: Any, control: Any) -> list[Array]:
    at = (*pose, *control, 0.0, 0.0, 0.0)
    return [np.array(compiled(_MOTION, by, _MOTION_NAMES)(*at)) for by in ("x y t", "e_x e_y e_a")]


def _motion_by_displacement(pose: Any, control: Any) -> tuple[Array, Array]:
    """The slope of a displacement by the heading is the displacement, a quarter turn to the left."""
    shift = _moved(pose, control)[:2] - np.asarray(pose)[:2]
    by_pose = np.eye(3, dtype=np.float32)
    by_pose[:2, 2] = rotation_2d(np.pi / 2) @ shift
    by_noise = np.zeros((3, 3))
    by_noise[:2, :2], by_noise[2, 2] = rotation_2d(pose[2]), 1.0
    return by_pose, by_noise


def _last_column(x_by_theta: Function, y_by_theta: Function) -> Function:
    """F with another last column: each entry a function of d, cosine and sine of the heading."""

    def change(by_pose: Any, pose: Any, control: Any) -> Array:
        c, s = math.cos(pose[2]), math.sin(pose[2])
        changed = np.array(by_pose)
        changed[:2, 2] = x_by_theta(control[0], c, s), y_by_theta(control[0], c, s)
        return changed

    return with_change(_motion_slopes, in_part(0, change))


def _only_control(by_noise: Any, pose: Any, control: Any) -> Array:
    return np.asarray(by_noise)[:, [0, 2]]


MOTION_JACOBIANS = Exercise(
    name="motion_jacobians",
    points=2,
    stars=2,
    public=_moves_public,
    hidden=_moves_hidden,
    comparison=Close(names=("F", "G")),
    hints=(
        "F is 3 x 3: row i is line i of equation 5.5, column j says by which of x, y, theta you differentiate. Seven of its nine entries are 0 or 1.",
        "In F only the column by theta is interesting: the derivative of d cos(theta), and that of d sin(theta). In G the first column is how x and "
        "y grow with e_x: look at the factors of e_x in equation 5.5.",
    ),
    mistakes=[
        Mistake(
            "heading sign",
            with_change(_motion_slopes, in_part(0, factors((1, 1, -1), (1, 1, -1), (1, 1, 1)))),
            "F's column by theta has the wrong signs: the derivative of the cosine is minus the sine, that of the sine the cosine.",
        ),
        Mistake(
            "minus forgotten",
            with_change(_motion_slopes, in_part(0, factors((1, 1, -1), (1, 1, 1), (1, 1, 1)))),
            "F[0, 2] has the wrong sign: the derivative of cos(theta) is -sin(theta).",
        ),
        Mistake(
            "theta + alpha",
            called_with(_motion_slopes, heading=lambda theta, control: theta + control[1]),
            "You evaluate at theta + alpha, the heading after the turn. The robot drives along the old one.",
        ),
        Mistake(
            "F and G swapped",
            lambda pose, control: _motion_slopes(pose, control)[::-1],
            "F and G are swapped: F, by the pose, comes first. (The paper calls this lesson's F its G.)",
        ),
        Mistake(
            "not differentiated",
            _last_column(lambda d, c, s: d * c, lambda d, c, s: d * s),
            "F's column by theta has d cos(theta) and d sin(theta) themselves: differentiate them.",
        ),
        Mistake(
            "distance forgotten",
            _last_column(lambda d, c, s: -s, lambda d, c, s: c),
            "In F's column by theta the factor d is missing: the farther the robot drives, the more its heading counts.",
        ),
        Mistake(
            "the report's e_y = 1",
            _last_column(lambda d, c, s: -d * s, lambda d, c, s: d * c - s),
            "F[1, 2] is taken at e_y = 1, as the report's handwritten page 1.2 says. The noise has mean 0: take all slopes there.",
        ),
        Mistake(
            "noise in the world frame",
            with_change(_motion_slopes, in_part(1, lambda by_noise, *arguments: np.eye(3))),
            "Your G adds e_x to x, whatever the heading. The errors are along and across the robot, so they turn with it.",
        ),
        Mistake(
            "G the wrong way round",
            with_change(_motion_slopes, in_part(1, transposed)),
            "Your G turns the noise by -theta: it is transposed. Its first column is (cos, sin, 0).",
        ),
        Mistake(
            "no noise across",
            with_change(_motion_slopes, in_part(1, _only_control)),
            "Your G has one column for d and one for alpha. There are three errors: along, across and of the turn.",
        ),
        Mistake(
            "F transposed",
            with_change(_motion_slopes, in_part(0, transposed)),
            "F is transposed: rows belong to the new x, y, theta, columns to the old ones.",
        ),
        Mistake(
            "theta + alpha, noise in the world frame",
            with_change(
                called_with(_motion_slopes, heading=lambda theta, control: theta + control[1]),
                in_part(1, lambda by_noise, *arguments: np.eye(3)),
            ),
            "Two things: F belongs to the old heading, not to theta + alpha; and G has to turn the errors into the field's frame.",
        ),
        Mistake(
            "minus forgotten, noise in the world frame",
            with_change(
                with_change(_motion_slopes, in_part(0, factors((1, 1, -1), (1, 1, 1), (1, 1, 1)))),
                in_part(1, lambda by_noise, *arguments: np.eye(3)),
            ),
            "Two things: the derivative of cos(theta) is -sin(theta); and G has to turn the errors into the field's frame.",
        ),
        Mistake(
            "without the ones",
            with_change(_motion_slopes, in_part(0, lambda by_pose, *arguments: by_pose - np.eye(3))),
            "F has the slopes of the displacement. The new x contains the old one, too: the ones of the diagonal are missing.",
        ),
        Mistake(
            "degrees",
            called_with(_motion_slopes, heading=heading_in_degrees),
            "The heading is in radians already, as np.cos and np.sin want it.",
        ),
        Mistake(
            "cosine and sine swapped",
            _last_column(lambda d, c, s: d * c, lambda d, c, s: -d * s),
            "In F's column by theta the rows have changed places: the new x holds the cosine, whose derivative is -sin.",
        ),
        Mistake(
            "the heading's one",
            with_change(_motion_slopes, in_part(0, factors((1, 1, 1), (1, 1, 1), (1, 1, 0)))),
            "F[2, 2] is 0, but a heading that was wrong stays wrong: the new theta contains the old one.",
        ),
        Mistake(
            "the place's ones",
            with_change(_motion_slopes, in_part(0, factors((0, 1, 1), (1, 0, 1), (1, 1, 1)))),
            "F[0, 0] and F[1, 1] are 0, but the new place contains the old one: x' = x + ...",
        ),
        Mistake(
            "nothing across",
            with_change(_motion_slopes, in_part(1, factors((1, 0, 1), (1, 0, 1), (1, 1, 1)))),
            "G's second column is zero: the error across moves the robot to its left, by (-sin, cos).",
        ),
        Mistake(
            "the sign across",
            with_change(_motion_slopes, in_part(1, factors((1, -1, 1), (1, 1, 1), (1, 1, 1)))),
            "G[0, 1] has the wrong sign: left of a robot that looks along theta is (-sin, cos).",
        ),
        Mistake(
            "the turn's error before the drive",
            with_change(
                _motion_slopes,
                lambda matrices, *arguments: (
                    matrices[0],
                    np.column_stack([matrices[1][:, :2], matrices[0][:, 2]]),
                ),
            ),
            "Your error of the turn moves the place. The robot turns after the drive: G's third column is (0, 0, 1).",
        ),
    ],
    alternatives={
        "central differences": _motion_by_differences,
        "SymPy": _motion_by_sympy,
        "the displacement turned by 90 degrees, float32": _motion_by_displacement,
    },
    equivalents=as_lists(
        "F = [[1, 0, -distance * np.sin(theta)], [0, 1, distance * np.cos(theta)], [0, 0, 1]]",
        "G = [[np.cos(theta), -np.sin(theta), 0], [np.sin(theta), np.cos(theta), 0], [0, 0, 1]]",
    ),
)


# --- 5.5 predict_covariance ---


def _spread(covariance: Any, pose: Any, control: Any, control_covariance: Any) -> Array:
    F, G = _motion_slopes(pose, control)
    return F @ np.asarray(covariance) @ F.T + G @ np.asarray(control_covariance) @ G.T


def _spread_with(formula: Function) -> Function:
    """Another formula: ``formula(F, P, G, Q)``."""

    def function(covariance: Any, pose: Any, control: Any, control_covariance: Any) -> Array:
        F, G = _motion_slopes(pose, control)
        answer: Array = formula(F, np.asarray(covariance), G, np.asarray(control_covariance))
        return answer

    return function


def _spread_in_one(F: Array, P: Array, G: Array, Q: Array) -> Array:
    slopes, both = np.hstack([F, G]), np.zeros((6, 6))
    both[:3, :3], both[3:, 3:] = P, Q
    return slopes @ both @ slopes.T


def _spread_by_sums(F: Array, P: Array, G: Array, Q: Array) -> Array:
    total = np.zeros((3, 3))
    for i in range(3):
        for j in range(3):
            for k in range(3):
                for m in range(3):
                    total[i, j] += F[i, k] * P[k, m] * F[j, m] + G[i, k] * Q[k, m] * G[j, m]
    return total


def _spread_by_einsum(F: Array, P: Array, G: Array, Q: Array) -> Array:
    return np.einsum("ik,km,jm->ij", F, P, F) + np.einsum("ik,km,jm->ij", G, Q, G)


def _spread_by_roots(F: Array, P: Array, G: Array, Q: Array) -> Array:
    roots = np.hstack(
        [F @ np.linalg.cholesky(P + 1e-14 * np.eye(3)), G @ np.linalg.cholesky(Q + 1e-14 * np.eye(3))]
    )
    return roots @ roots.T


def _spreads_public() -> list[Case]:
    rng = np.random.default_rng(51)
    small = np.diag([0.1, 0.05, 0.02]) ** 2
    cases = [
        ("only the heading is uncertain", np.diag([0.0, 0.0, 0.04]), np.zeros((3, 3)), SLANTED),
        (
            "only the drive is uncertain, sideways most",
            np.zeros((3, 3)),
            np.diag([0.01, 0.09, 0.04]),
            SLANTED,
        ),
        ("all of it is uncertain", random_covariance(rng), random_covariance(rng), NEARLY_ROUND),
        ("heading along the y axis", random_covariance(rng), small, LEFT),
        ("a small uncertainty", small, small / 4, FACING),
    ]
    drives = [Case((P, pose, np.array([1.5, 0.4]), Q), name) for name, P, Q, pose in cases]
    backwards = (random_covariance(rng), SLANTED, np.array([-0.8, 0.2]), random_covariance(rng))
    return [*drives, Case(backwards, "backwards")]


def _spreads_hidden(rng: np.random.Generator) -> list[Case]:
    cases = [
        Case((random_covariance(rng), random_pose(rng), random_control(rng), random_covariance(rng)))
        for _ in range(8)
    ]
    backwards = np.array([-rng.uniform(0.3, 0.9), 0.4])
    return [*cases, Case((random_covariance(rng), random_pose(rng), backwards, random_covariance(rng)))]


PREDICT_COVARIANCE = Exercise(
    name="predict_covariance",
    points=2,
    stars=2,
    uses=("motion_jacobians",),
    public=_spreads_public,
    hidden=_spreads_hidden,
    comparison=Close(rtol=1e-4, atol=1e-7, names=("x", "y", "theta")),
    hints=(
        "Equation 5.6, with F and G of your motion_jacobians. In NumPy @ is the product of matrices, .T the transpose.",
        "F, G = motion_jacobians(pose, control). Then two products of three matrices each, and their sum: the transposed one stands on the right.",
    ),
    mistakes=[
        Mistake(
            "Gᵀ Q G",
            _spread_with(lambda F, P, G, Q: F @ P @ F.T + G.T @ Q @ G),
            "The second term is G.T @ Q @ G. It has to be G @ Q @ G.T: G turns the robot's errors into the field's, the transposed one turns them "
            "the other way.",
        ),
        Mistake(
            "Fᵀ P F",
            _spread_with(lambda F, P, G, Q: F.T @ P @ F + G @ Q @ G.T),
            "The first term is F.T @ P @ F. It has to be F @ P @ F.T: P must meet the old pose, the columns of F.",
        ),
        Mistake(
            "both the wrong way round",
            _spread_with(lambda F, P, G, Q: F.T @ P @ F + G.T @ Q @ G),
            "Both products are the wrong way round: the transposed matrix stands on the right.",
        ),
        Mistake(
            "noise in the world frame",
            _spread_with(lambda F, P, G, Q: F @ P @ F.T + Q),
            "You add the control's covariance as it is. It is along and across the robot; G turns it into the field's frame.",
        ),
        Mistake(
            "noise forgotten",
            _spread_with(lambda F, P, G, Q: F @ P @ F.T),
            "The drive's own errors are missing: add G @ control_covariance @ G.T.",
        ),
        Mistake(
            "only the noise",
            _spread_with(lambda F, P, G, Q: G @ Q @ G.T),
            "The old uncertainty is missing: it is carried along by F.",
        ),
        Mistake(
            "old one not carried along",
            _spread_with(lambda F, P, G, Q: P + G @ Q @ G.T),
            "You keep the old covariance as it is. An uncertain heading becomes an uncertain place while the robot drives: F @ covariance @ F.T.",
        ),
        Mistake(
            "no transposes",
            _spread_with(lambda F, P, G, Q: F @ P @ F + G @ Q @ G),
            "Nothing is transposed. A covariance meets the Jacobian from both sides: F @ P @ F.T.",
        ),
        Mistake(
            "one side only",
            _spread_with(lambda F, P, G, Q: F @ P + G @ Q),
            "A covariance meets the Jacobian from both sides; yours has it on the left only.",
        ),
        Mistake(
            "products of entries",
            _spread_with(lambda F, P, G, Q: F * P * F.T + G * Q * G.T),
            "With * NumPy multiplies entry by entry. The product of matrices is @.",
        ),
        Mistake(
            "F and G swapped",
            _spread_with(lambda F, P, G, Q: G @ P @ G.T + F @ Q @ F.T),
            "F and G are swapped: F belongs to the old covariance, G to the control's.",
        ),
        Mistake(
            "squared again",
            _spread_with(lambda F, P, G, Q: F @ P @ F.T + G @ Q**2 @ G.T),
            "control_covariance holds variances already: it is not squared again.",
        ),
        Mistake(
            "subtracted",
            _spread_with(lambda F, P, G, Q: F @ P @ F.T - G @ Q @ G.T),
            "You subtract the drive's errors. Errors that do not know of each other add up.",
        ),
        Mistake(
            "F for both",
            _spread_with(lambda F, P, G, Q: F @ (P + Q) @ F.T),
            "F stands round both covariances. It carries the old one; the drive's errors are carried by G.",
        ),
        Mistake(
            "variances only, of the drive",
            _spread_with(lambda F, P, G, Q: F @ P @ F.T + G @ np.diag(np.diag(Q)) @ G.T),
            "You take the diagonal of control_covariance only. Errors may be correlated: take all of it.",
        ),
        Mistake(
            "variances only, of the pose",
            _spread_with(lambda F, P, G, Q: F @ np.diag(np.diag(P)) @ F.T + G @ Q @ G.T),
            "You take the diagonal of the old covariance only. After one drive place and heading are correlated: take all of it.",
        ),
        Mistake(
            "control_covariance not used",
            _spread_with(lambda F, P, G, Q: F @ P @ F.T + G @ G.T),
            "Your second term has no control_covariance in it: G @ control_covariance @ G.T.",
        ),
        Mistake(
            "not backwards",
            lambda P, pose, control, Q: _spread(P, pose, control, Q) if control[0] >= 0 else np.asarray(P),
            "Where the robot drives backwards, your covariance stays as it was. The formula is the same there.",
        ),
        Mistake(
            "where the drive ends",
            lambda P, pose, control, Q: _spread(P, _moved(pose, control), control, Q),
            "You take the Jacobians at the pose behind the motion. They belong to the pose before it.",
        ),
    ],
    alternatives={
        "both in one product": _spread_with(_spread_in_one),
        "sums over indices": _spread_with(_spread_by_sums),
        "einsum": _spread_with(_spread_by_einsum),
        "square roots": _spread_with(_spread_by_roots),
    },
)


# --- 5.6 landmark_jacobians ---


def _place_slopes(pose: Any, measurement: Any) -> tuple[Array, Array]:
    angle = pose[2] + measurement[0]
    toward = np.array([math.cos(angle), math.sin(angle)])
    sideways = measurement[1] * np.array([-toward[1], toward[0]])
    return np.column_stack([np.eye(2), sideways]), np.column_stack([sideways, toward])


def _place_by_differences(pose: Any, measurement: Any) -> tuple[Array, Array]:
    by_measurement = differences(lambda z: _position(pose, z), measurement)
    return differences(_position, pose, measurement), by_measurement


def _place_by_sympy(pose: Any, measurement: Any) -> tuple[Array, Array]:
    model, names = "x + r * cos(t + b); y + r * sin(t + b)", "x y t b r"
    both = [np.array(compiled(model, by, names)(*pose, *measurement)) for by in ("x y t", "b r")]
    return both[0], both[1]


def _place_by_rotation(pose: Any, measurement: Any) -> tuple[Array, Array]:
    turned = rotation_2d(pose[2] + measurement[0]) @ np.array([[0, 1], [measurement[1], 0]])
    return np.hstack([np.eye(2), turned[:, :1]]).astype(np.float32), turned


def _first_column(change: Function) -> Function:
    """by_measurement with its column by the bearing changed, and by_pose with that by the heading."""

    def changed(matrices: Any, pose: Any, measurement: Any) -> Any:
        by_pose, by_measurement = (np.array(each) for each in matrices)
        by_pose[:, 2] = by_measurement[:, 0] = change(by_measurement[:, 0], measurement)
        return by_pose, by_measurement

    return with_change(_place_slopes, changed)


def _per_metre(number: int) -> Function:
    """A column that lacks the factor of the range."""

    def change(matrix: Any, pose: Any, measurement: Any) -> Array:
        changed = np.array(matrix, dtype=float)
        changed[:, number] /= measurement[1]
        return changed

    return change


LANDMARK_JACOBIANS = Exercise(
    name="landmark_jacobians",
    points=2,
    stars=2,
    public=lambda: _polar_public()[:-1],
    hidden=_polar_hidden,
    comparison=Close(names=("by_pose", "by_measurement")),
    hints=(
        "Two rows, l_x and l_y of equation 5.3. Heading and bearing stand there only as a sum: what does that say of the slopes by them?",
        "by_pose: an identity and a third column, the slope by theta. by_measurement: the slope by beta, which is that third column again, and the "
        "slope by r, a cosine and a sine.",
    ),
    mistakes=[
        Mistake(
            "range first",
            with_change(_place_slopes, in_part(1, columns_swapped)),
            "The columns of by_measurement are swapped: a measurement is (bearing, range).",
        ),
        Mistake(
            "bearing's sign",
            with_change(_place_slopes, in_part(1, factors((-1, 1), (-1, 1)))),
            "by_measurement's column by the bearing has the wrong sign: heading and bearing both count to the left, so their slopes are the same.",
        ),
        Mistake(
            "minus forgotten",
            _first_column(lambda column, measurement: column * [-1, 1]),
            "The slope of l_x by an angle has the wrong sign: the derivative of the cosine is minus the sine.",
        ),
        Mistake(
            "both signs",
            _first_column(lambda column, measurement: -column),
            "The slopes by heading and bearing have both signs wrong: minus the sine, and plus the cosine.",
        ),
        Mistake(
            "range forgotten",
            _first_column(lambda column, measurement: column / measurement[1]),
            "The slopes by heading and bearing lack the factor r: a far landmark moves more.",
        ),
        Mistake(
            "heading forgotten",
            called_with(_place_slopes, heading=no_heading),
            "Your slopes are those of a robot that looks along x: the angle is theta + beta everywhere.",
        ),
        Mistake(
            "heading subtracted",
            called_with(_place_slopes, heading=lambda theta, measurement: -theta),
            "Your angle is beta - theta. It is theta + beta, as in equation 5.3.",
        ),
        Mistake(
            "place forgotten",
            with_change(_place_slopes, in_part(0, factors((0, 0, 1), (0, 0, 1)))),
            "Where the robot moves, the landmark it places moves along: by_pose begins with an identity.",
        ),
        Mistake(
            "identity's sign",
            with_change(_place_slopes, in_part(0, factors((-1, -1, 1), (-1, -1, 1)))),
            "by_pose begins with minus an identity, as the range's slopes would. Here the landmark moves along with the robot.",
        ),
        Mistake(
            "no slope by the heading",
            with_change(_place_slopes, in_part(0, factors((1, 1, 0), (1, 1, 0)))),
            "by_pose's column by theta is zero: when the robot turns, what it sees turns round it.",
        ),
        Mistake(
            "swapped",
            lambda pose, measurement: _place_slopes(pose, measurement)[::-1],
            "The two matrices are swapped: first the one by the pose, (2, 3).",
        ),
        Mistake(
            "transposed",
            with_change(_place_slopes, in_part(1, transposed)),
            "by_measurement is transposed: rows are l_x and l_y.",
        ),
        Mistake(
            "both transposed",
            lambda pose, measurement: tuple(each.T for each in _place_slopes(pose, measurement)),
            "Both are transposed: rows are l_x and l_y, columns what they are differentiated by.",
        ),
        Mistake(
            "side by side",
            lambda pose, measurement: np.hstack(_place_slopes(pose, measurement)),
            "You return one matrix (2, 5). Two are wanted: return by_pose, by_measurement.",
        ),
        Mistake(
            "minus forgotten once",
            with_change(_place_slopes, in_part(0, factors((1, 1, -1), (1, 1, 1)))),
            "by_pose[0, 2] has the wrong sign: the derivative of the cosine is minus the sine.",
        ),
        Mistake(
            "minus forgotten by the bearing",
            with_change(_place_slopes, in_part(1, factors((-1, 1), (1, 1)))),
            "by_measurement[0, 0] has the wrong sign: the derivative of the cosine is minus the sine.",
        ),
        Mistake(
            "range forgotten by the heading",
            with_change(_place_slopes, in_part(0, _per_metre(2))),
            "by_pose's column by theta lacks the factor r: a far landmark moves more.",
        ),
        Mistake(
            "range forgotten by the bearing",
            with_change(_place_slopes, in_part(1, _per_metre(0))),
            "by_measurement's column by the bearing lacks the factor r: a far landmark moves more.",
        ),
        Mistake(
            "range too much",
            with_change(
                _place_slopes,
                in_part(1, lambda matrix, pose, measurement: matrix * np.array([1.0, measurement[1]])),
            ),
            "by_measurement's column by the range still has r in it: the derivative of r cos(...) by r is cos(...).",
        ),
        Mistake(
            "bearing forgotten",
            lambda pose, measurement: _place_slopes(pose, (0.0, measurement[1])),
            "The bearing is missing in your slopes: the angle is theta + beta everywhere.",
        ),
        Mistake(
            "bearing forgotten by the heading",
            lambda pose, measurement: (
                _place_slopes(pose, (0.0, measurement[1]))[0],
                _place_slopes(pose, measurement)[1],
            ),
            "by_pose's column by theta has the angle theta. It is theta + beta, as in equation 5.3.",
        ),
        Mistake(
            "heading forgotten by the bearing",
            lambda pose, measurement: (
                _place_slopes(pose, measurement)[0],
                _place_slopes((0.0, 0.0, 0.0), measurement)[1],
            ),
            "by_measurement has the angle beta. It is theta + beta, as in equation 5.3.",
        ),
        Mistake(
            "bearing subtracted",
            lambda pose, measurement: _place_slopes(pose, (-measurement[0], measurement[1])),
            "Your angle is theta - beta. It is theta + beta, as in equation 5.3.",
        ),
        Mistake(
            "range taken first",
            lambda pose, measurement: _place_slopes(pose, measurement[::-1]),
            "You take the measurement as (range, bearing). It is (bearing, range).",
        ),
        Mistake(
            "not differentiated",
            _first_column(lambda column, measurement: column[::-1] * [1, -1]),
            "The slopes by heading and bearing have cosine and sine in each other's place: they are -r sin and r cos.",
        ),
    ],
    alternatives={
        "central differences": _place_by_differences,
        "SymPy": _place_by_sympy,
        "a rotation matrix, float32": _place_by_rotation,
    },
    equivalents=as_lists(
        "by_pose = [[1, 0, across[0]], [0, 1, across[1]]]",
        "by_measurement = [[across[0], c], [across[1], s]]",
    ),
)


# --- 5.7 derive_measurement_jacobian ---

_x, _y, _theta, _l_x, _l_y = sympy.symbols("x y theta l_x l_y")
_dx, _dy = _l_x - _x, _l_y - _y
_q = _dx**2 + _dy**2
_MODEL = sympy.Matrix([sympy.atan2(_dy, _dx) - _theta, sympy.sqrt(_q)])
_BY = [_x, _y, _theta]


def _derived() -> Any:
    return _MODEL.jacobian(_BY)


def _symbolic(change: Function = lambda jacobian: jacobian, model: Any = _MODEL) -> Function:
    """Another model or Jacobian than the right ones."""
    return lambda: (model, change(model.jacobian(_BY)))


def _entry(row: int, column: int, change: Function) -> Function:
    """A Jacobian with one entry changed."""

    def changed(jacobian: Any) -> Any:
        other = jacobian.copy()
        other[row, column] = change(other[row, column])
        return other

    return changed


def _row(number: int, change: Function) -> Function:
    """A Jacobian with the first two entries of a row changed."""

    def changed(jacobian: Any) -> Any:
        other = jacobian.copy()
        for column in (0, 1):
            other[number, column] = change(other[number, column])
        return other

    return changed


def _points(rng: np.random.Generator) -> dict[str, Array]:
    """Robots and landmarks in all directions, headings near half a turn among them."""
    poses = np.array([random_pose(rng) for _ in range(12)])
    poses[:4, 2] = [np.pi, -np.pi, 3.1, -3.1]
    landmarks = np.array([seen(pose, random_measurement(rng)) for pose in poses])
    return dict(zip(("x", "y", "theta", "l_x", "l_y"), [*poses.T, *landmarks.T], strict=True))


def _with_mod() -> tuple[Any, Any]:
    whole = 2 * sympy.pi
    return sympy.Matrix([sympy.Mod(_MODEL[0] + sympy.pi, whole) - sympy.pi, _MODEL[1]]), _derived()


def _with_half_angle() -> tuple[Any, Any]:
    """The angle by half of it, with SymPy's own Jacobian, not simplified."""
    r = sympy.sqrt(_q)
    model = sympy.Matrix([[2 * sympy.atan2(_dy, r + _dx) - _theta, r]])
    return model, model.T.jacobian(_BY)


def _bearing_model(bearing: Any, distance: Any = None) -> Function:
    """Another model, with the Jacobian that fits it."""
    return _symbolic(model=sympy.Matrix([bearing, sympy.sqrt(_q) if distance is None else distance]))


def _as_lists() -> tuple[Any, Any]:
    r = sympy.sqrt(_q)
    return list(_MODEL), [[_dy / r**2, -_dx / r**2, -1], [-_dx / r, -_dy / r, 0]]


def _real_symbols() -> tuple[Any, Any]:
    real = {each: sympy.Symbol(each.name, real=True) for each in (_x, _y, _theta, _l_x, _l_y)}
    return _MODEL.subs(real), _derived().subs(real)


DERIVE = Exercise(
    name="derive_measurement_jacobian",
    points=2,
    stars=2,
    driver="jacobian",
    public=lambda: [
        Case((_points(np.random.default_rng(57)), ["x", "y", "theta"]), "twelve robots and landmarks")
    ],
    hidden=lambda rng: [Case((_points(rng), ["x", "y", "theta"])) for _ in range(2)],
    comparison=Derivative(by=("x", "y", "theta"), period=(2 * np.pi, 0.0)),
    hints=(
        "The derivative of arctan(t) is 1 / (1 + t^2). Put t = dy / dx, multiply by the inner derivative, and bring all to the denominator dx^2 + dy^2.",
        "dx = l_x - x, so the inner derivative by x is -1: every slope by x or y is minus the slope by dx or dy. theta stands in the bearing alone, once.",
    ),
    mistakes=[
        Mistake(
            "inner derivative forgotten",
            _symbolic(lambda jacobian: jacobian * sympy.diag(-1, -1, 1)),
            "All slopes by x and y have the wrong sign: these are the slopes by dx and dy. The inner derivative, -1, is missing.",
        ),
        Mistake(
            "bearing's signs",
            _symbolic(_row(0, lambda entry: -entry)),
            "The bearing's slopes by x and y have the wrong signs. Go to the left (y grows), and a landmark ahead moves to the right.",
        ),
        Mistake(
            "range's signs",
            _symbolic(_row(1, lambda entry: -entry)),
            "The range's slopes by x and y have the wrong signs: drive towards a landmark, and the range shrinks.",
        ),
        Mistake(
            "r for r^2",
            _symbolic(_row(0, lambda entry: entry * sympy.sqrt(_q))),
            "The bearing's slopes are divided by r; it has to be r^2 = dx^2 + dy^2.",
        ),
        Mistake(
            "r^2 for r",
            _symbolic(_row(1, lambda entry: entry / sympy.sqrt(_q))),
            "The range's slopes are divided by r^2; it has to be r, the root.",
        ),
        Mistake(
            "the missing -1",
            _symbolic(_entry(0, 2, lambda entry: sympy.Integer(0))),
            "The bearing's slope by theta is 0 in your matrix: the heading is subtracted in the bearing, so it is -1.",
        ),
        Mistake(
            "plus 1",
            _symbolic(_entry(0, 2, lambda entry: -entry)),
            "The bearing's slope by theta is +1 in your matrix. Turn left, and the landmark moves to the right: -1.",
        ),
        Mistake(
            "rows swapped",
            lambda: (_MODEL, sympy.Matrix([_derived().row(1), _derived().row(0)])),
            "The rows of your Jacobian are swapped: the bearing comes first.",
        ),
        Mistake(
            "range first",
            lambda: (
                sympy.Matrix([_MODEL[1], _MODEL[0]]),
                sympy.Matrix([_derived().row(1), _derived().row(0)]),
            ),
            "Your model is (range, bearing). A measurement is (bearing, range).",
        ),
        Mistake(
            "dx and dy swapped",
            _symbolic(lambda jacobian: sympy.Matrix([[-_dx / _q, _dy / _q, -1], list(jacobian.row(1))])),
            "In the bearing's slopes dx and dy have changed places: by x it is dy / r^2.",
        ),
        Mistake(
            "atan2 the other way",
            _bearing_model(sympy.atan2(_dx, _dy) - _theta),
            "Your Jacobian fits your model, but your model has atan2(dx, dy): y comes first.",
        ),
        Mistake(
            "atan for atan2",
            _bearing_model(sympy.atan(_dy / _dx) - _theta),
            "Your Jacobian is right, your model is not: atan(dy / dx) cannot tell a landmark behind from one ahead, atan2(dy, dx) can. They have the "
            "same slopes.",
        ),
        Mistake(
            "from the landmark",
            _bearing_model(sympy.atan2(-_dy, -_dx) - _theta),
            "Your Jacobian is right, your model is not: it looks from the landmark to the robot, half a turn off. dx is l_x - x.",
        ),
        Mistake(
            "heading added",
            _bearing_model(sympy.atan2(_dy, _dx) + _theta),
            "Your Jacobian fits your model, but your model adds theta. A bearing counts from the heading: subtract it.",
        ),
        Mistake(
            "to the right",
            _bearing_model(_theta - sympy.atan2(_dy, _dx)),
            "Your Jacobian fits your model, but its bearings are positive to the right: it is atan2(dy, dx) - theta.",
        ),
        Mistake(
            "heading forgotten",
            _bearing_model(sympy.atan2(_dy, _dx)),
            "Your Jacobian fits your model, but your bearing counts from the x axis. It counts from the heading: subtract theta.",
        ),
        Mistake(
            "root forgotten",
            _bearing_model(sympy.atan2(_dy, _dx) - _theta, _q),
            "Your Jacobian fits your model, but your range is the squared distance: the root is missing.",
        ),
    ],
    alternatives={
        "by SymPy": lambda: (_MODEL, _derived()),
        "with the wrap": _with_mod,
        "half the angle, the model a row": _with_half_angle,
        "lists": _as_lists,
        "real symbols": _real_symbols,
    },
    equivalents=as_lists(
        "model = [atan2(dy, dx) - theta, sqrt(q)]",
        "jacobian = [[dy / q, -dx / q, -1], [-dx / sqrt(q), -dy / sqrt(q), 0]]",
    ),
)


# --- 5.8 measurement_jacobian_pose ---


def _look_slopes(pose: Any, landmark: Any) -> Array:
    dx, dy = landmark[0] - pose[0], landmark[1] - pose[1]
    r = math.hypot(dx, dy)
    return np.array([[dy / r**2, -dx / r**2, -1.0], [-dx / r, -dy / r, 0.0]])


def _look_by_differences(pose: Any, landmark: Any) -> Array:
    return differences(_measured, pose, landmark, angles=(0,))


def _look_by_sympy(pose: Any, landmark: Any) -> Array:
    model = "atan2(v - y, u - x) - t; sqrt((u - x)**2 + (v - y)**2)"
    return np.array(compiled(model, "x y t", "x y t u v")(*pose, *landmark))


def _look_by_unit_vectors(pose: Any, landmark: Any) -> Array:
    toward = np.asarray(landmark) - np.asarray(pose)[:2]
    r = np.linalg.norm(toward)
    unit = toward / r
    rows = np.vstack([[unit[1] / r, -unit[0] / r], -unit])
    return np.column_stack([rows, [-1.0, 0.0]]).astype(np.float32)


def _look_by_angles(pose: Any, landmark: Any) -> list[list[float]]:
    bearing, r = _measured(pose, landmark)
    c, s = math.cos(pose[2] + bearing), math.sin(pose[2] + bearing)
    return [[s / r, -c / r, -1.0], [-c, -s, 0.0]]


def _range_of(pose: Any, landmark: Any) -> float:
    return math.hypot(landmark[0] - pose[0], landmark[1] - pose[1])


def by_power(row: int, power: int, columns: slice = np.s_[:2]) -> Function:
    """A slip of r for r^2: entries of a row of a Jacobian of (bearing, range), multiplied by a power of the range."""

    def change(matrix: Any, pose: Any, landmark: Any) -> Array:
        changed = np.array(matrix, dtype=float)
        changed[row, columns] *= _range_of(pose, landmark) ** power
        return changed

    return change


def with_range(matrix: Any, pose: Any, landmark: Any) -> Array:
    """dx and dy as they are: both rows without their division."""
    r = _range_of(pose, landmark)
    return np.asarray(matrix) * np.array([[r**2], [r]])


def bearing_swapped(matrix: Any, *arguments: Any) -> Array:
    """dx and dy at each other's place in the bearing's row, signs as they were there."""
    changed = np.array(matrix, dtype=float)
    changed[0, :2] = changed[0, 1::-1]
    return changed


def entries_swapped(row: int, sign: float) -> Function:
    """dx and dy at each other's place in a row, the signs of the places kept: -1 where the two differ in sign."""

    def change(matrix: Any, *arguments: Any) -> Array:
        changed = np.array(matrix, dtype=float)
        changed[row, :2] = sign * changed[row, 1::-1]
        return changed

    return change


def doubled(factor: float) -> Function:
    """The range's row, larger by a factor."""
    return lambda matrix, *arguments: np.asarray(matrix) * np.array([[1.0], [factor]])


def bearing_in_degrees(matrix: Any, *arguments: Any) -> Array:
    """The bearing's row per degree."""
    return np.asarray(matrix) * np.array([[180 / np.pi], [1.0]])


_ROW_MESSAGES = {
    "rows swapped": "The rows are swapped: a measurement is (bearing, range), so the bearing's slopes come first.",
    "degrees": "The bearing's row is in degrees per metre. Angles are in radians here.",
    "r for r^2": "The bearing's slopes are divided by r; it has to be r^2 = dx^2 + dy^2.",
    "r^2 for r": "The range's slopes are divided by r^2; it has to be r, the root.",
    "dx and dy swapped": "In the bearing's row dx and dy have changed places.",
    "dx and dy swapped, signs kept": "In the bearing's row dx and dy have changed places. The signs are right.",
    "dx and dy swapped in the range": "In the range's row dx and dy have changed places.",
    "the range's row not divided": "The range's slopes are not divided: by r, the root.",
    "the root's half": "The range's slopes are half as large as they should be: the 2 of the inner derivative cancels that of the root.",
    "the root's two": "The range's slopes are twice as large as they should be: the root's derivative is 1 / (2 sqrt(q)).",
}


def slips(right: Function) -> list[Mistake]:
    """What goes wrong in both Jacobians of a measurement, by the pose and by the landmark."""
    changes = {
        "rows swapped": rows_swapped,
        "degrees": bearing_in_degrees,
        "r for r^2": by_power(0, 1),
        "r^2 for r": by_power(1, -1),
        "dx and dy swapped": bearing_swapped,
        "dx and dy swapped, signs kept": entries_swapped(0, -1.0),
        "dx and dy swapped in the range": entries_swapped(1, 1.0),
        "the range's row not divided": by_power(1, 1),
        "the root's half": doubled(0.5),
        "the root's two": doubled(2.0),
    }
    return [
        Mistake(name, with_change(right, change), _ROW_MESSAGES[name]) for name, change in changes.items()
    ]


MEASUREMENT_JACOBIAN_POSE = Exercise(
    name="measurement_jacobian_pose",
    points=2,
    stars=2,
    public=_looks_public,
    hidden=_looks_hidden,
    comparison=Close(names=POSE_COLUMNS),
    hints=(
        "The matrix that you derived in exercise 5.7, with numbers for letters. dx, dy and q = dx^2 + dy^2 first, then the rows.",
        "The first row is divided by q and ends with -1, the second by the root of q and ends with 0.",
    ),
    mistakes=[
        *slips(_look_slopes),
        Mistake(
            "inner derivative forgotten",
            with_change(_look_slopes, factors((-1, -1, 1), (-1, -1, 1))),
            "The slopes by x and y have the wrong sign: these are the slopes by dx and dy, and dx = l_x - x.",
        ),
        Mistake(
            "bearing's signs",
            with_change(_look_slopes, factors((-1, -1, 1), (1, 1, 1))),
            "The bearing's slopes by x and y have the wrong signs. Go to the left (y grows), and a landmark ahead moves to the right.",
        ),
        Mistake(
            "range's signs",
            with_change(_look_slopes, factors((1, 1, 1), (-1, -1, 1))),
            "The range's slopes have the wrong signs: drive towards a landmark, and the range shrinks.",
        ),
        Mistake(
            "the missing -1",
            with_change(_look_slopes, factors((1, 1, 0), (1, 1, 1))),
            "The bearing's slope by theta is missing: the heading is subtracted, so it is -1.",
        ),
        Mistake(
            "plus 1",
            with_change(_look_slopes, factors((1, 1, -1), (1, 1, 1))),
            "The bearing's slope by theta is +1 in your matrix. Turn left, and the landmark moves to the right: -1.",
        ),
        Mistake(
            "r for r^2, the missing -1",
            with_change(with_change(_look_slopes, by_power(0, 1)), factors((1, 1, 0), (1, 1, 1))),
            "Two things, both in the bearing's row: its slopes are divided by r^2, and by theta it is -1.",
        ),
        Mistake(
            "r for r^2, inner derivative forgotten",
            with_change(with_change(_look_slopes, by_power(0, 1)), factors((-1, -1, 1), (-1, -1, 1))),
            "Two things: the slopes by x and y have the wrong sign, for dx = l_x - x; and the bearing's are divided by r^2.",
        ),
        Mistake(
            "range by the heading",
            with_change(_look_slopes, lambda matrix, *arguments: matrix - [[0, 0, 0], [0, 0, 1]]),
            "The range's slope by theta is -1 in your matrix. A robot that turns on the spot comes no nearer: 0.",
        ),
        Mistake(
            "one sign in the bearing",
            with_change(_look_slopes, factors((1, -1, 1), (1, 1, 1))),
            "The bearing's slope by y has the wrong sign. Go to the left (y grows), and a landmark ahead moves to the right.",
        ),
        Mistake(
            "no column for the heading",
            with_change(_look_slopes, lambda matrix, *arguments: matrix[:, :2]),
            "Your matrix is 2 x 2: the column by theta is missing.",
        ),
        Mistake(
            "transposed",
            with_change(_look_slopes, transposed),
            "It is transposed: two rows, bearing and range, and three columns, x, y and theta.",
        ),
        Mistake(
            "in the robot's frame",
            lambda pose, landmark: _look_slopes((0.0, 0.0, 0.0), Pose(*pose).to_local(landmark)[0]),
            "Your dx and dy are in the robot's frame. x and y of the pose are the field's: dx = l_x - x, without turning.",
        ),
    ],
    alternatives={
        "central differences": _look_by_differences,
        "SymPy": _look_by_sympy,
        "a unit vector, float32": _look_by_unit_vectors,
        "bearing and range": _look_by_angles,
    },
    equivalents=as_lists("return [[dy / q, -dx / q, -1], [-dx / r, -dy / r, 0]]"),
)


# --- 5.9 measurement_jacobian_landmark ---


def _point_slopes(pose: Any, landmark: Any) -> Array:
    return -_look_slopes(pose, landmark)[:, :2]


def _point_by_inverse(pose: Any, landmark: Any) -> Array:
    return np.linalg.inv(_place_slopes(pose, _measured(pose, landmark))[1])


def _point_by_differences(pose: Any, landmark: Any) -> Array:
    return differences(lambda point: _measured(pose, point), landmark, angles=(0,))


def _point_by_rotation(pose: Any, landmark: Any) -> Array:
    bearing, r = _measured(pose, landmark)
    return (np.array([[0, 1 / r], [1, 0]]) @ rotation_2d(-pose[2] - bearing)).astype(np.float32)


def _point_by_complex(pose: Any, landmark: Any) -> list[list[float]]:
    slope = 1 / complex(
        landmark[0] - pose[0], landmark[1] - pose[1]
    )  # of the logarithm, whose parts are ln r and angle
    r = 1 / abs(slope)
    return [[slope.imag, slope.real], [slope.real * r, -slope.imag * r]]


MEASUREMENT_JACOBIAN_LANDMARK = Exercise(
    name="measurement_jacobian_landmark",
    points=3,
    stars=3,
    uses=(
        "expected_measurement",
        "landmark_jacobians",
        "measurement_jacobian_pose",
    ),  # whichever way is taken
    public=_looks_public,
    hidden=_looks_hidden,
    comparison=Close(names=("by l_x", "by l_y")),
    hints=(
        "Three ways lead there: differentiate again, read property 1 from left to right, or read property 2 as the definition of an inverse.",
        "Property 1: shift robot and landmark together, and nothing that is measured changes. So the slope by the landmark's place and that by the "
        "robot's place add up to zero. Which columns of which of your functions are these?",
    ),
    mistakes=[
        *slips(_point_slopes),
        Mistake(
            "slopes by the robot",
            with_change(_point_slopes, lambda matrix, *arguments: -matrix),
            "All signs are the wrong way round: these are the slopes by the robot's x and y. Landmark and robot move a measurement in opposite ways.",
        ),
        Mistake(
            "bearing's signs",
            with_change(_point_slopes, factors((-1, -1), (1, 1))),
            "The bearing's signs are the wrong way round: a landmark ahead that moves to the left gets a larger bearing.",
        ),
        Mistake(
            "range's signs",
            with_change(_point_slopes, factors((1, 1), (-1, -1))),
            "The range's signs are the wrong way round: a landmark that moves away gets a larger range.",
        ),
        Mistake(
            "not inverted",
            lambda pose, landmark: _place_slopes(pose, _measured(pose, landmark))[1],
            "That is by_measurement, how the landmark's place grows with the measurement. The other way round is its inverse.",
        ),
        Mistake(
            "transposed",
            with_change(_point_slopes, transposed),
            "It is transposed: rows are bearing and range, columns l_x and l_y.",
        ),
        Mistake(
            "transposed inverse",
            lambda pose, landmark: _place_slopes(pose, _measured(pose, landmark))[1].T,
            "That is by_measurement transposed, which would be its inverse if it were a rotation. It has the length r in it.",
        ),
        Mistake(
            "with the heading",
            lambda pose, landmark: -_look_slopes(pose, landmark),
            "Your matrix has a column for the heading. The landmark has two coordinates.",
        ),
        Mistake(
            "in the robot's frame",
            lambda pose, landmark: _point_slopes((0.0, 0.0, 0.0), Pose(*pose).to_local(landmark)[0]),
            "Your slopes are by the landmark's place in the robot's frame. l_x and l_y are the field's: dx = l_x - x, without turning.",
        ),
        Mistake(
            "no division",
            with_change(_point_slopes, with_range),
            "Nothing is divided in your matrix: the bearing's row is divided by r^2, the range's by r.",
        ),
        Mistake(
            "a row of H_p too much",
            lambda pose, landmark: _look_slopes(pose, landmark)[:, 1:],
            "You took the last two columns of the Jacobian by the pose. Those by x and y are the first two, and the signs change.",
        ),
    ],
    alternatives={
        "an inverse": _point_by_inverse,
        "central differences": _point_by_differences,
        "a rotation, float32": _point_by_rotation,
        "the complex logarithm": _point_by_complex,
    },
)


PLAN = LessonPlan(
    exercises=[
        PREDICT_POSE,
        EXPECTED_MEASUREMENT,
        LANDMARK_POSITION,
        MOTION_JACOBIANS,
        PREDICT_COVARIANCE,
        LANDMARK_JACOBIANS,
        DERIVE,
        MEASUREMENT_JACOBIAN_POSE,
        MEASUREMENT_JACOBIAN_LANDMARK,
    ],
    questions=[
        Question(
            "what_is_a_column",
            "The third column of F is (-d sin(theta), d cos(theta), 1). With heading 0 and d = 2 m it is (0, 2, 1). What does the 2 say?",
            {
                "The robot drives 2 m along y.": "With heading 0 it drives along x. The column does not say where it goes, but what an error does.",
                "A heading that is off by 0.01 rad makes y off by 2 cm.": "Yes: a slope times a small change is a small change, 2 m/rad times 0.01 rad. "
                "The 1 below says that the heading stays off by 0.01 rad.",
                "y is twice as uncertain as the heading.": "Nearly, but slopes carry units: 2 m for each radian. Metres and radians cannot be compared.",
            },
            "A heading that is off by 0.01 rad makes y off by 2 cm.",
        ),
        Question(
            "why_no_other_landmark",
            'The report gives two reasons in 1.6 why no Jacobian by other landmarks is needed: "the assumption of landmark independence", and that a measurement '
            '"does not depend on the positions of other landmarks". Which is the right one?',
            {
                "Landmarks are independent, so their slopes are zero.": "The slopes are zero, but not for this reason, the first of the report's. After one look from an uncertain "
                "place the landmarks' estimates are anything but independent: the next cell measures it.",
                "The bearing and range of one landmark do not contain the coordinates of another.": "Yes, the report's second reason. h(p, l) is a formula with five letters, and a slope "
                "by any other letter is zero. Nothing about independence is needed for it.",
                "The slopes are not zero, but small enough to be left out.": "They are exactly zero: move another landmark as far as you like, and this one is "
                "seen where it was.",
            },
            "The bearing and range of one landmark do not contain the coordinates of another.",
        ),
    ],
    written=[
        Written(
            "explain_banana",
            points=2,
            question="Why do the samples form a banana when the heading is uncertain by 30 degrees, and why does the ellipse not?",
            rubric="1 point: all samples drive the same distance, each along its own heading, so they lie on an arc round the start. 1 point: a "
            "Jacobian replaces the arc by its tangent at the mean heading; an ellipse is what a straight map makes of a Gaussian, so it is "
            "tangential, has no bend, and is centred beyond the samples' mean.",
        )
    ],
)
