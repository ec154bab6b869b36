"""The exercises of lesson 05, EKF derivations, with their mistakes and with alternative right solutions."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy
from scipy.linalg import block_diag

from nao_course.exercises import Case, Close, Derivative, Exercise, LessonPlan, Question, Sibling, Written
from nao_course.geometry import Pose, rotation_2d, wrap_angle
from nao_course.instructor.authoring.mistakes import catalogue
from nao_course.lessons.ekf_derivations.mistakes import jacobian_at
from nao_course.slam import range_and_bearing

Array = npt.NDArray[Any]
Function = Callable[..., Any]


def as_lists(*lines: str) -> dict[str, str]:
    """Return equivalents for lines that return lists instead of arrays; a check accepts both."""
    return dict.fromkeys(lines, "a check accepts a list in place of an array")


def single(function: Function) -> Function:
    """Return the function in single precision."""
    return lambda *given: np.float32(function(*given))


# --- poses, controls and landmarks for the cases ---
def random_pose(rng: np.random.Generator) -> Array:
    """Draw a pose on the field with any heading."""
    return np.array([rng.uniform(-4, 4), rng.uniform(-3, 3), rng.uniform(-3.1, 3.1)])


def random_control(rng: np.random.Generator) -> Array:
    """Draw a distance and a turn that are not small."""
    return np.array([rng.uniform(0.4, 2.0), rng.uniform(0.3, 1.2) * rng.choice([-1, 1])])


def random_measurement(rng: np.random.Generator) -> Array:
    """Draw a bearing and a range; the range is not near 1 m."""
    return np.array([rng.uniform(0.2, 2.9) * rng.choice([-1, 1]), rng.uniform(1.6, 5.0)])


def random_covariance(rng: np.random.Generator) -> Array:
    """Draw a covariance (3, 3) without any special structure."""
    root = rng.normal(0, 0.3, (3, 3))
    return root @ root.T + 0.02 * np.eye(3)


def landmark_from(pose: Array, measurement: Array) -> Array:
    """Return the landmark that belongs to a measurement from a pose."""
    bearing, distance = measurement
    return np.array(Pose(*pose).to_parent([distance * math.cos(bearing), distance * math.sin(bearing)])[0])


FACING = np.array([1.0, 0.5, 0.0])  # along the x axis
LEFT = np.array([0.5, -1.0, np.pi / 2])
SLANTED = np.array([-2.0, 1.5, 2.5])
NEAR_HALF_TURN = np.array([0.3, 0.4, -3.1])


def differences(model: Function, at: Array, angles: tuple[int, ...] = ()) -> Array:
    """Return the central differences of a model; differences of angles are wrapped."""
    changes = np.array([model(at + step) - model(at - step) for step in 1e-6 * np.eye(len(at))]).T
    changes[list(angles)] = wrap_angle(changes[list(angles)])
    return changes / 2e-6


# --- 5.1 predict_pose ---
def _moved(pose: Array, control: Array, noise: Any = (0.0, 0.0, 0.0)) -> Array:
    along, across, turn = noise
    return (Pose(*pose) @ Pose(control[0] + along, across, control[1] + turn)).as_array()


def _moved_by_complex(pose: Array, control: Array) -> list[float]:
    end = complex(*pose[:2]) + cmath.rect(control[0], pose[2])
    return [end.real, end.imag, cmath.phase(cmath.rect(1, pose[2] + control[1]))]


def _moves_public() -> list[Case]:
    return [
        Case((FACING, np.array([0.8, 0.5])), "a heading along x"),
        Case((LEFT, np.array([0.4, -0.3])), "a heading along y"),
        Case((SLANTED, np.array([1.2, 0.6])), "a heading of 143 degrees"),
        Case((NEAR_HALF_TURN, np.array([0.5, -0.4])), "a turn that goes beyond -180 degrees"),
        Case((SLANTED, np.array([-0.3, 0.2])), "backwards"),
        Case((SLANTED, np.array([0.0, 1.0])), "a turn on the spot"),
    ]


def _moves_hidden(rng: np.random.Generator) -> list[Case]:
    cases = [Case((random_pose(rng), random_control(rng))) for _ in range(8)]
    return [*cases, Case((random_pose(rng), np.array([-0.7, 0.4])))]


POSE = Exercise(
    name="predict_pose",
    points=1,
    public=_moves_public,
    hidden=_moves_hidden,
    comparison=Close(period=(0, 0, 2 * np.pi), names=("x", "y", "theta")),
    hints=(
        "The function returns three numbers, one for each part of equation 5.1. Unpack the inputs first: x, y, theta = pose.",
        "Return np.array([...]) with x plus distance times a cosine, y plus distance times a sine, and theta plus the turn. The angle in both is the old heading.",
    ),
    sibling=Sibling(
        "All numbers of the new state are computed from the old one, as your position from the old heading: a stone falls with the speed that it had, and then its speed changes.",
        """
        import numpy as np


        def fall(state, seconds):
            height, speed = state
            return np.array([height + speed * seconds, speed - 9.81 * seconds])


        print(fall(fall(np.array([20.0, 3.0]), 0.1), 0.1))
        """,
        "[20.5019  1.038 ]",
    ),
    mistakes=catalogue("""
        turn unpacked first: distance, turn = => turn, distance =
            You unpack the control as (turn, distance). It is (distance, turn).
        turns first: (theta) =>> (theta + turn)
            Your robot drives along theta + alpha. This robot drives first and turns afterwards, so use the old heading in cosine and sine.
        cosine and sine swapped: distance * np.sin => distance *  np.cos
            distance * np.cos => distance * np.sin
            Cosine and sine are swapped. With heading 0 the robot drives along x, and cos(0) is 1.
        heading sign: y + => y -
            y has the wrong sign. A positive heading points to the left, towards larger y, so d sin(theta) is added.
        degrees: (theta) =>> (np.radians(theta))
            You convert the heading to radians, but it already is in radians, as np.cos and np.sin expect.
        turn forgotten: theta + turn]) => theta])
            Your heading does not change. The robot turns by alpha after the drive: return theta + alpha.
        the change alone: return np.array => return -pose + np.array
            You return the change of the pose. Add the old pose to it.
        in the robot's frame: distance * np.cos(theta), y + distance * np.sin(theta) => distance, y
            You add d to x whatever the heading is. d is measured along the robot's heading, so its x and y parts are d cos(theta) and d sin(theta).
        turn subtracted: theta + turn]) => theta - turn])
            The turn has the wrong sign. Turns and headings are both positive to the left, so alpha is added.
        heading halfway: (theta) =>> (theta + turn / 2)
            Your robot drives along theta + alpha / 2, as if it turned on the way. It drives straight along its old heading and turns afterwards.
        turn for heading: theta + turn]) => turn])
            Your new heading is alpha alone. Add alpha to the old heading theta.
        heading in degrees: theta + turn]) => np.degrees(theta + turn)])
            Your new heading is in degrees. Return it in radians.
        heading and turn from degrees: (theta) =>> (np.radians(theta))
            theta + turn]) => np.radians(theta + turn)])
            You convert heading and turn to radians, but both already are in radians.
        new heading from degrees: theta + turn]) => np.radians(theta + turn)])
            You convert the new heading to radians, but theta and alpha already are in radians.
        backwards: distance * =>> -distance *
            Your robot drives backwards. Add the displacement: x + d cos(theta).
        drives across: np.cos(theta), y + distance * np.sin(theta) => np.sin(theta), y - distance * np.cos(theta)
            Your robot drives to its right. With heading 0 it must drive along x: cosine for x, sine for y.
    """),
    alternatives={"composed poses": _moved, "complex numbers": _moved_by_complex, "float32": single(_moved)},
    equivalents=as_lists("return [x + distance * np.cos(theta), y + distance * np.sin(theta), theta + turn]"),
)


# --- 5.2 expected_measurement ---
def _in_robot_frame(pose: Array, landmark: Array) -> tuple[float, float]:
    ahead, left = Pose(*pose).to_local(landmark)[0]
    return np.arctan2(left, ahead), np.hypot(ahead, left)


def _by_loop(pose: Array, landmark: Array) -> list[float]:
    bearing = np.arctan2(*(landmark - pose[:2])[::-1]) - pose[2]
    while abs(bearing) > np.pi:
        bearing -= 2 * np.pi * np.sign(bearing)
    return [bearing, np.sqrt(((landmark - pose[:2]) ** 2).sum())]


def _measurements_public() -> list[Case]:
    return [
        Case((FACING, np.array([3.0, 1.5])), "a landmark ahead to the left"),
        Case((FACING, np.array([-1.0, 1.3])), "a landmark behind the robot"),
        Case((LEFT, np.array([2.5, -2.0])), "a heading along y"),
        Case(
            (SLANTED, np.array([-3.4, 0.2])),
            "a heading of 143 degrees, a landmark in the direction of -137 degrees",
        ),
        Case((NEAR_HALF_TURN, np.array([-1.8, 0.9])), "a heading of -178 degrees, a landmark ahead"),
        Case((SLANTED, np.array([-1.5, 1.6])), "a landmark very near"),
        Case(
            (np.array([1.0, -0.5, 9.0]), np.array([-0.6, -1.9])),
            "a heading of 516 degrees, more than a full turn",
        ),
    ]


def _measurements_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for number in range(12):
        pose = random_pose(rng)
        if number % 3 == 0:
            pose[2] = rng.uniform(2.6, 3.1) * rng.choice([-1, 1])
        if number % 3 == 1:
            pose[2] = rng.uniform(7.5, 9.4) * rng.choice([-1, 1])
        cases.append(Case((pose, landmark_from(pose, random_measurement(rng)))))
    return cases


MEASUREMENT = Exercise(
    name="expected_measurement",
    points=1,
    public=_measurements_public,
    hidden=_measurements_hidden,
    comparison=Close(names=("bearing", "range")),
    hints=(
        "Compute dx and dy first, from the robot to the landmark. The rest is equation 5.2, and wrap_angle(angle) does the wrapping.",
        "np.arctan2 takes dy first. Subtract theta from its result and wrap the difference, not its two parts.",
    ),
    sibling=Sibling(
        "A bearing on a ship is computed in the same steps: the direction on the map, minus the course, and then the difference is wrapped; only the zero is different, because a compass counts from north.",
        """
        import numpy as np

        ship, course, lighthouse = np.array([2.0, 1.0]), 350.0, np.array([4.0, 4.0])
        east, north = lighthouse - ship
        direction = np.degrees(np.arctan2(east, north))  # clockwise from north, as a compass
        relative = direction - course
        print(f"{relative:.1f}, wrapped {(relative + 180) % 360 - 180:.1f} degrees to starboard")
        """,
        "-316.3, wrapped 43.7 degrees to starboard",
    ),
    mistakes=catalogue("""
        range first: dy)]) => dy)])[::-1]
            You return (range, bearing). In this course a measurement is (bearing, range).
        not wrapped: wrap_angle( => (
            Some of your bearings are outside (-pi, pi]. Wrap the difference of the two angles with wrap_angle(...).
        arctan for arctan2: arctan2(dy, dx) => arctan(dy / dx)
            np.arctan(dy / dx) gives the same angle for a landmark ahead and one behind. Use np.arctan2(dy, dx).
        arctan, not wrapped: wrap_angle(np.arctan2(dy, dx) - theta) => np.arctan(dy / dx) - theta
            There are two errors: np.arctan(dy / dx) gives the same angle for a landmark ahead and one behind, so use np.arctan2(dy, dx); and the difference of the angles has to be wrapped.
        heading forgotten: - theta => - 0
            You return the direction in the field frame. A bearing is relative to the robot's heading: subtract theta.
        heading added: - theta => + theta
            You add the heading. When a robot turns left, everything it sees moves to the right, so theta is subtracted.
        from the landmark: landmark[0] - x, landmark[1] - y => x - landmark[0], y - landmark[1]
            Your direction points from the landmark to the robot. dx is l_x - x, not x - l_x.
        arctan2 the other way: arctan2(dy, dx) => arctan2(dx, dy)
            np.arctan2 takes y first: np.arctan2(dy, dx).
        from the landmark, not wrapped: landmark[0] - x, landmark[1] - y => x - landmark[0], y - landmark[1]
            wrap_angle( => (
            There are two errors: your direction points from the landmark to the robot, because dx is l_x - x; and the difference of the angles has to be wrapped.
        wrapped to 0 to 2 pi: wrap_angle( => (lambda angle: angle % (2 * np.pi))(
            Your bearings are between 0 and 2 pi. In this course they are between -pi and pi, so a landmark to the right has a negative bearing.
        wrapped only once: wrap_angle( => (lambda angle: angle - 2 * np.pi * (angle > np.pi) + 2 * np.pi * (angle < -np.pi))(
            You add or subtract 2 pi at most once. A robot that keeps turning has a heading of several turns, so one step is not enough. wrap_angle removes any number of turns.
        degrees: np.array([ => np.array([180 / np.pi *
            Your bearing is in degrees. Return it in radians.
        root forgotten: np.hypot(dx, dy) => dx**2 + dy**2
            Your range is the squared distance. Take the square root.
        to the right: np.array([ => np.array([-
            Your bearings are positive to the right. They are positive to the left, as headings are: direction minus theta.
        from the field's origin: landmark[0] - x, landmark[1] - y => landmark
            You measure from the origin of the field. Subtract the robot's x and y from the landmark's first.
        heading taken for degrees: - theta => - np.radians(theta)
            You convert the heading to radians, but it already is in radians.
        wrapped on one side: wrap_angle( => (lambda angle: angle - 2 * np.pi * (angle > np.pi))(
            You bring angles above pi down but leave those below -pi. wrap_angle handles both.
        wrapped too early: wrap_angle(np.arctan2(dy, dx) - theta) => np.arctan2(dy, dx) - wrap_angle(theta)
            You wrap the heading before you subtract it. The difference of two angles can still be outside (-pi, pi], so wrap the difference.
        without a side: wrap_angle(np.arctan2(dy, dx) - theta) => abs(wrap_angle(np.arctan2(dy, dx) - theta))
            Your bearings are never negative, so left and right look the same. Keep the sign of the angle.
    """),
    alternatives={"robot's frame": _in_robot_frame, "a loop": _by_loop, "float32": single(range_and_bearing)},
    equivalents=as_lists("return [wrap_angle(np.arctan2(dy, dx) - theta), np.hypot(dx, dy)]")
    | {
        "return np.array([wrap_angle(np.arctan2(dy, dx) - theta), np.hypot(dy, dx)])": "a root of the same two squares"
    },
)


# --- 5.3 landmark_position ---
def _position_by_complex(pose: Array, measurement: Array) -> list[float]:
    point = complex(*pose[:2]) + cmath.rect(measurement[1], pose[2] + measurement[0])
    return [point.real, point.imag]


def _polar_public() -> list[Case]:
    return [
        Case((FACING, np.array([0.4, 2.0])), "a heading along x"),
        Case((LEFT, np.array([-0.6, 1.5])), "a heading along y"),
        Case((SLANTED, np.array([1.2, 3.0])), "a heading of 143 degrees"),
        Case((NEAR_HALF_TURN, np.array([-0.5, 2.5])), "heading and bearing beyond -180 degrees"),
        Case((SLANTED, np.array([2.6, 0.4])), "a landmark 0.4 m away, behind the robot"),
        Case((SLANTED, np.array([-0.3, 0.0])), "a range of 0 m"),
    ]


def _polar_hidden(rng: np.random.Generator) -> list[Case]:
    return [Case((random_pose(rng), random_measurement(rng))) for _ in range(10)]


POSITION = Exercise(
    name="landmark_position",
    points=1,
    public=_polar_public,
    hidden=_polar_hidden,
    comparison=Close(names=("x", "y")),
    hints=(
        "Seen from above, in which direction is the landmark if the robot's heading is theta and the bearing is beta?",
        "The landmark is r away in the direction theta + beta. Use the cosine for x and the sine for y, and add the robot's position.",
    ),
    sibling=Sibling(
        "A forearm's direction is the sum of two angles, as the landmark's is: the elbow's angle is counted from the upper arm, as a bearing is counted from the heading.",
        """
        import numpy as np


        def tip(length, angle):
            return length * np.array([np.cos(angle), np.sin(angle)])


        shoulder, elbow = np.radians(30), np.radians(60)
        hand = tip(0.3, shoulder) + tip(0.25, shoulder + elbow)
        print(hand.round(3))
        """,
        "[0.26 0.4 ]",
    ),
    mistakes=catalogue("""
        heading forgotten: theta + bearing =>> bearing
            You place the landmark as if the heading were 0. The bearing is relative to the heading, so use theta + beta.
        bearing subtracted: theta + bearing =>> theta - bearing
            You subtract the bearing. It is positive to the left, as headings are, so use theta + beta.
        heading subtracted: theta + bearing =>> bearing - theta
            You rotate by -theta. This function is the inverse of equation 5.2, so use theta + beta. As a matrix, the rotation by theta has the rows (cos, -sin) and (sin, cos).
        one term of two: np.cos(theta + bearing), => np.cos(theta) * np.cos(bearing),
            np.sin(theta + bearing) => np.sin(theta) * np.sin(bearing)
            cos(theta + beta) is not cos(theta) cos(beta), and likewise for the sine. A rotation mixes both coordinates, so x and y have two terms each.
        the report's slip: np.sin(theta + bearing) => (np.sin(theta) * np.sin(bearing) + np.cos(theta) * np.cos(bearing))
            In your y the robot frame's l_x and l_y are swapped. The second row of the rotation is (sin, cos), for l_x and l_y in this order. The report has the same mistake on page 1.3.
        cosine and sine swapped: distance * np.sin => distance *  np.cos
            distance * np.cos => distance * np.sin
            Cosine and sine are swapped. The cosine belongs to x and the sine to y.
        position forgotten: [x + => [
            , y + => ,
            The robot's own position is missing. Add x and y.
        in the robot's frame: + pose = np.zeros(3)
            You return the landmark in the robot frame. Rotate it by theta and add (x, y).
        range first: bearing, distance = => distance, bearing =
            You unpack the measurement as (range, bearing). It is (bearing, range).
        degrees: theta + bearing =>> np.radians(theta + bearing)
            You convert to radians, but heading and bearing already are in radians.
        bearing forgotten: theta + bearing =>> theta
            You place the landmark straight ahead, because the bearing is missing. Use theta + beta.
        the cosine twice: np.sin => np.cos
            Both of your coordinates have the cosine. The sine belongs to y.
        shifted, then turned: + from nao_course.geometry import rotation_2d
            theta + bearing =>> bearing
            return => return rotation_2d(theta) @
            You rotate the robot's own position together with the landmark. Rotate first, then add x and y.
        y turned downwards: y + distance * np.sin => y - distance * np.cos
            np.cos(theta + bearing), => np.sin(theta + bearing),
            Your landmark is a quarter turn to the right of where it should be. Heading 0 points along x, so the cosine belongs to x and the sine, with a plus, to y.
    """),
    alternatives={
        "frames": landmark_from,
        "complex numbers": _position_by_complex,
        "float32": single(landmark_from),
    },
    equivalents=as_lists(
        "return [x + distance * np.cos(theta + bearing), y + distance * np.sin(theta + bearing)]"
    ),
)


# --- 5.4 motion_jacobians ---
def _motion(pose: Array, control: Array) -> tuple[Array, Array]:
    """Differentiate a displacement by the heading: the result is the displacement, rotated by a quarter turn."""
    by_pose, by_noise = np.eye(3), np.eye(3)
    by_pose[:2, 2] = rotation_2d(np.pi / 2) @ (_moved(pose, control) - pose)[:2]
    by_noise[:2, :2] = rotation_2d(pose[2])
    return by_pose, by_noise


def _motion_differences(pose: Array, control: Array) -> tuple[Array, Array]:
    by_pose = differences(lambda at: _moved(at, control), pose, angles=(2,))
    return by_pose, differences(lambda noise: _moved(pose, control, noise), np.zeros(3), angles=(2,))


def _motion_complex(pose: Array, control: Array) -> list[list[list[float]]]:
    c, s = cmath.rect(1, pose[2]).real, cmath.rect(1, pose[2]).imag
    side = 1j * cmath.rect(control[0], pose[2])
    return [[[1, 0, side.real], [0, 1, side.imag], [0, 0, 1]], [[c, -s, 0], [s, c, 0], [0, 0, 1]]]


MOTION = Exercise(
    name="motion_jacobians",
    points=2,
    stars=2,
    public=_moves_public,
    hidden=_moves_hidden,
    comparison=Close(names=("F", "G")),
    hints=(
        "F is 3 x 3: row i is line i of equation 5.5, and column j is the variable x, y or theta with respect to which you differentiate. Seven of its nine entries are 0 or 1.",
        "In F only the column for theta takes work: differentiate d cos(theta) and d sin(theta). The first column of G has the factors of e_x in equation 5.5.",
    ),
    sibling=Sibling(
        "A Jacobian has a row for each output and a column for each input, and differences show whether it is right; here the inputs are a crane's length and angle.",
        """
        import numpy as np


        def hook(length, angle):
            return np.array([length * np.cos(angle), 2 + length * np.sin(angle)])


        length, angle, h = 5.0, 0.6, 1e-6
        ahead, up = np.cos(angle), np.sin(angle)
        J = np.eye(2)  # floats: an array of integers would cut off the decimals
        J[0], J[1] = (ahead, -length * up), (up, length * ahead)
        by_length = (hook(length + h, angle) - hook(length - h, angle)) / (2 * h)
        by_angle = (hook(length, angle + h) - hook(length, angle - h)) / (2 * h)
        print(J.round(3).tolist(), np.abs(J - np.stack([by_length, by_angle], axis=1)).max() < 1e-8)
        """,
        "[[0.825, -2.823], [0.565, 4.127]] True",
    ),
    mistakes=catalogue("""
        heading sign: [1, 0, -distance => [1, 0, distance
            [0, 1, distance => [0, 1, -distance
            Both entries of F's theta column have the wrong sign. The derivative of the cosine is minus the sine, and the derivative of the sine is plus the cosine.
        minus forgotten: [1, 0, -distance => [1, 0, distance
            F[0, 2] has the wrong sign. The new x contains d cos(theta), and its derivative is -d sin(theta).
        one minus too many: [0, 1, distance => [0, 1, -distance
            F[1, 2] has the wrong sign. The new y contains d sin(theta), and its derivative is +d cos(theta).
        theta + alpha: pose[2] => pose[2] + control[1]
            You evaluate at theta + alpha, the heading after the turn. The robot drives along the old heading.
        theta + alpha in F: -distance * np.sin(theta)], [0, 1, distance * np.cos(theta) => -distance * np.sin(theta + control[1])], [0, 1, distance * np.cos(theta + control[1])
            You evaluate F at theta + alpha, the heading after the turn. The robot drives along the old heading, which you use in G.
        distance in G: return F, G => G[:2, :2] = distance * G[:2, :2]
            + return F, G
            Your G contains the factor d. In equation 5.5 e_x is added to d, so its factors are cos(theta) and sin(theta) alone. The factors of e_y are -sin(theta) and cos(theta).
        F and G swapped: return F, G => return G, F
            F and G are swapped. F, the Jacobian with respect to the pose, comes first. (The paper calls our F its G.)
        whole numbers in F: return F, G => return F.astype(int), G
            The decimals of your F are cut off. np.array([[1, 0, 0], ...]) makes an array of whole numbers, and what you assign to its entries later is cut off to whole numbers, too. Begin with np.eye(3), or write all entries in np.array at once.
        whole numbers in F and G: return F, G => return F.astype(int), G.astype(int)
            The decimals of F and G are cut off. np.array([[1, 0, 0], ...]) makes an array of whole numbers, and what you assign to its entries later is cut off to whole numbers, too. Begin with np.eye(3), or write all entries in np.array at once.
        whole numbers in G: return F, G => return F, G.astype(int)
            The decimals of your G are cut off. np.array([[1, 0, 0], ...]) makes an array of whole numbers, and what you assign to its entries later is cut off to whole numbers, too. Begin with np.eye(3), or write all entries in np.array at once.
        not differentiated: -distance * np.sin(theta)], [0, 1, distance * np.cos => distance * np.cos(theta)], [0, 1, distance * np.sin
            F's theta column contains d cos(theta) and d sin(theta) themselves. Differentiate them.
        distance forgotten: control[0] => 1
            The factor d is missing in F's theta column. The farther the robot drives, the more an error of its heading matters.
        the report's e_y = 1: distance * np.cos(theta) => distance * np.cos(theta) - np.sin(theta)
            F[1, 2] is evaluated at e_y = 1, as on the report's handwritten page 1.2. The errors have mean 0, so evaluate all derivatives there.
        noise in the field frame: return F, G => return F, np.eye(3)
            Your G adds e_x to x whatever the heading is. The errors are along and across the robot, so they rotate with it.
        G the wrong way round: 0], [0, 0, 1]]) => 0], [0, 0, 1]]).T
            Your G is transposed, so it rotates the errors by -theta. Its first column is (cos, sin, 0).
        no noise across: return F, G => return F, G[:, [0, 2]]
            Your G has one column for d and one for alpha. There are three errors: along, across and in the turn.
        no noise of the turn: return F, G => return F, G[:, :2]
            Your G is (3, 2). The turn's error has a column, too: (0, 0, 1).
        F transposed: (theta)], [0, 0, 1]]) => (theta)], [0, 0, 1]]).T
            F is transposed. Rows belong to the new x, y, theta and columns to the old ones.
        without the ones: return F, G => return F - np.eye(3), G
            The ones on the diagonal of F are missing. The new x contains the old x, so the derivative is 1, and likewise for y and theta.
        degrees: pose[2] => np.radians(pose[2])
            You convert the heading to radians, but it already is in radians, as np.cos and np.sin expect.
        cosine and sine swapped: -distance * np.sin(theta)], [0, 1, distance * np.cos => distance * np.cos(theta)], [0, 1, -distance * np.sin
            The two entries of F's theta column are swapped. The new x contains the cosine, so its derivative, with -sin, is in the first row.
        swapped without the minus: -distance * np.sin(theta)], [0, 1, distance * np.cos => -distance * np.cos(theta)], [0, 1, distance * np.sin
            In F's theta column cosine and sine are swapped and the signs are wrong, too. Differentiate d cos(theta) for the first row and d sin(theta) for the second.
        the heading's one: (theta)], [0, 0, 1]] => (theta)], [0, 0, 0]]
            F[2, 2] is 0. The new theta contains the old theta, so this derivative is 1.
        the turn's own error: return F, G => G[2, 2] = 0
            + return F, G
            G[2, 2] is 0. The new theta contains e_alpha, so this derivative is 1.
        the turn itself: return F, G => G[2, 2] = control[1]
            + return F, G
            G[2, 2] is alpha. The new theta contains e_alpha, so its derivative with respect to e_alpha is 1.
        nothing across: -np.sin(theta), 0], [np.sin(theta), np.cos(theta), 0] => 0, 0], [np.sin(theta), 0, 0]
            G's second column is zero. The error across moves the robot to its left, by (-sin, cos).
        the sign across: -np.sin(theta) => np.sin(theta)
            G[0, 1] has the wrong sign. Left of a robot with heading theta is the direction (-sin, cos).
        the turn's error before the drive: return F, G => return F, np.column_stack([G[:, :2], F[:, 2]])
            Your error of the turn moves the position. The robot turns after the drive, so G's third column is (0, 0, 1).
        the pose on the diagonal: return F, G => F[[0, 1, 2], [0, 1, 2]] = pose
            + return F, G
            Your F has x, y and theta themselves on its diagonal. Differentiate them: the derivative of x with respect to x is 1.
    """),
    alternatives={"differences": _motion_differences, "complex": _motion_complex, "float32": single(_motion)},
    equivalents=as_lists(
        "F = [[1, 0, -distance * np.sin(theta)], [0, 1, distance * np.cos(theta)], [0, 0, 1]]",
        "G = [[np.cos(theta), -np.sin(theta), 0], [np.sin(theta), np.cos(theta), 0], [0, 0, 1]]",
    ),
)


# --- 5.5 predict_covariance ---
def _covariance(P: Array, pose: Array, control: Array, Q: Array) -> Array:
    both = np.hstack(_motion(pose, control))
    return both @ block_diag(P, Q) @ both.T


def _covariance_roots(P: Array, pose: Array, control: Array, Q: Array) -> Array:
    F, G = _motion(pose, control)
    tiny = 1e-14 * np.eye(3)
    root = np.hstack([F @ np.linalg.cholesky(P + tiny), G @ np.linalg.cholesky(Q + tiny)])
    return root @ root.T


def _covariances_public() -> list[Case]:
    rng = np.random.default_rng(51)
    small, none = np.diag([0.1, 0.05, 0.02]) ** 2, np.zeros((3, 3))
    ahead, back = np.array([1.5, 0.4]), np.array([-0.8, 0.2])
    across = np.diag([0.01, 0.09, 0.04])
    return [
        Case((np.diag([0.0, 0.0, 0.04]), SLANTED, ahead, none), "only the heading is uncertain"),
        Case((none, SLANTED, ahead, across), "only the motion is uncertain, mostly across"),
        Case(
            (random_covariance(rng), NEAR_HALF_TURN, ahead, random_covariance(rng)),
            "pose and motion are uncertain",
        ),
        Case((random_covariance(rng), LEFT, ahead, small), "a heading along y"),
        Case((small, FACING, ahead, small / 4), "a small uncertainty"),
        Case((random_covariance(rng), SLANTED, back, random_covariance(rng)), "backwards"),
    ]


def _covariances_hidden(rng: np.random.Generator) -> list[Case]:
    cases = [
        Case((random_covariance(rng), random_pose(rng), random_control(rng), random_covariance(rng)))
        for _ in range(8)
    ]
    backwards = np.array([-rng.uniform(0.3, 0.9), 0.4])
    return [*cases, Case((random_covariance(rng), random_pose(rng), backwards, random_covariance(rng)))]


COVARIANCE = Exercise(
    name="predict_covariance",
    points=2,
    stars=2,
    uses=("motion_jacobians",),
    public=_covariances_public,
    hidden=_covariances_hidden,
    comparison=Close(rtol=1e-4, atol=1e-7, names=("x", "y", "theta")),
    hints=(
        "Use equation 5.6 with F and G from your motion_jacobians. In NumPy @ is the matrix product and .T the transpose.",
        "F, G = motion_jacobians(pose, control). Then add two products of three matrices each, with the transposed matrix on the right.",
    ),
    sibling=Sibling(
        "The covariance of linear combinations needs the matrix on the left and its transpose on the right, and independent errors add a second product.",
        """
        import numpy as np

        A = np.array([[1.0, 1.0], [1.0, -1.0]])  # sum and difference of two lengths
        lengths = np.array([[4.0, 1.0], [1.0, 2.0]])
        B, reading = np.array([[1.0], [0.5]]), np.array([[0.2]])  # one more error, in both results
        print(A @ lengths @ A.T + B @ reading @ B.T)
        """,
        """
        [[8.2  2.1 ]
         [2.1  4.05]]
        """,
    ),
    mistakes=catalogue("""
        Gᵀ Q G: G @ control_covariance @ G.T => G.T @ control_covariance @ G
            Your second term is G.T @ Q @ G; it should be G @ Q @ G.T. G rotates the errors from the robot frame into the field frame, and its transpose rotates them the other way.
        Fᵀ P F: F @ covariance @ F.T => F.T @ covariance @ F
            Your first term is F.T @ P @ F; it should be F @ P @ F.T. The columns of F belong to the old pose, so F stands on the left of P.
        both the wrong way round: F @ covariance @ F.T => F.T @ covariance @ F
            G @ control_covariance @ G.T => G.T @ control_covariance @ G
            Both products have the transpose on the wrong side. The transposed matrix stands on the right.
        noise in the field frame: G @ control_covariance @ G.T => control_covariance
            You add the control's covariance without rotating it. It is given along and across the robot, and G rotates it into the field frame.
        noise forgotten: F.T + G @ control_covariance @ G.T => F.T
            The errors of the motion are missing. Add G @ control_covariance @ G.T.
        only the noise: F @ covariance @ F.T + G => G
            The old covariance is missing. Add F @ covariance @ F.T.
        old covariance not propagated: F @ covariance @ F.T => covariance
            You add the old covariance unchanged. While the robot drives, an uncertain heading makes its position uncertain, so use F @ covariance @ F.T.
        no transposes: .T =>>
            Neither product has a transpose. A covariance is multiplied by the Jacobian on the left and by its transpose on the right.
        no transpose, of the pose: covariance @ F.T => covariance @ F
            Your first term is F @ P @ F. The Jacobian on the right is transposed: F @ P @ F.T.
        no transpose, of the motion: covariance @ G.T => covariance @ G
            Your second term is G @ Q @ G. The Jacobian on the right is transposed: G @ Q @ G.T.
        one side only, of the pose: covariance @ F.T => covariance
            Your first term is F @ P. A covariance is also multiplied by the transposed Jacobian on the right: F @ P @ F.T.
        one side only, of the motion: covariance @ G.T => covariance
            Your second term is G @ Q. A covariance is also multiplied by the transposed Jacobian on the right: G @ Q @ G.T.
        products of entries: @ =>> *
            In NumPy * multiplies entry by entry. The matrix product is @.
        products of entries, of the pose: F @ covariance @ F.T => F * covariance * F.T
            In your first term * multiplies entry by entry. The matrix product is @.
        products of entries, of the motion: G @ control_covariance @ G.T => G * control_covariance * G.T
            In your second term * multiplies entry by entry. The matrix product is @.
        an inverse: F @ covariance @ F.T => F @ covariance @ np.linalg.inv(F)
            Your first term has the inverse of F on the right. It should be the transpose: F @ P @ F.T.
        F and G swapped: F, G = => G, F =
            F and G are swapped. F belongs to the old covariance and G to the control's.
        squared again: control_covariance @ => control_covariance**2 @
            You square control_covariance, but it already contains variances.
        subtracted: F.T + G => F.T - G
            You subtract the errors of the motion. Variances of independent errors add up.
        F for both: G @ control_covariance @ G.T => F @ control_covariance @ F.T
            You use F in both terms. F propagates the old covariance, and G the errors of the motion.
        variances only, of the motion: @ control_covariance => @ np.diag(np.diag(control_covariance))
            You use only the diagonal of control_covariance. Errors may be correlated, so use the whole matrix.
        variances only, of the pose: @ covariance => @ np.diag(np.diag(covariance))
            You use only the diagonal of the old covariance. After one motion position and heading are correlated, so use the whole matrix.
        control_covariance not used: G @ control_covariance @ G.T => G @ G.T
            Your second term does not contain control_covariance. It should be G @ control_covariance @ G.T.
        evaluated after the motion: motion_jacobians(pose, => motion_jacobians(predict_pose(pose, control),
            You evaluate the Jacobians at the pose after the motion. They belong to the pose before it.
        old covariance added again: return F => return covariance + F
            You add the old covariance once more. F @ P @ F.T contains it already.
        errors of the motion propagated by F: F @ covariance @ F.T + G @ control_covariance @ G.T => F @ (covariance + G @ control_covariance @ G.T) @ F.T
            You multiply the errors of the motion by F as well. They occur during this motion, so only G propagates them: F @ P @ F.T + G @ Q @ G.T.
    """),
    alternatives={
        "one product": _covariance,
        "square roots": _covariance_roots,
        "float32": single(_covariance),
    },
)


# --- 5.6 landmark_jacobians ---
def _position_jacobians(pose: Array, measurement: Array) -> tuple[Array, Array]:
    turned = rotation_2d(pose[2] + measurement[0]) @ np.array([[0, 1], [measurement[1], 0]])
    return np.hstack([np.eye(2), turned[:, :1]]), turned


def _position_jacobians_complex(pose: Array, measurement: Array) -> Any:
    toward = cmath.rect(1, pose[2] + measurement[0])
    x, y = (-measurement[1] * toward.imag, measurement[1] * toward.real)
    return [[1, 0, x], [0, 1, y]], [[x, toward.real], [y, toward.imag]]


def _position_differences(pose: Array, measurement: Array) -> tuple[Array, Array]:
    by_pose = differences(lambda at: landmark_from(at, measurement), pose)
    return by_pose, differences(lambda z: landmark_from(pose, z), measurement)


LANDMARK = Exercise(
    name="landmark_jacobians",
    points=2,
    stars=2,
    public=lambda: _polar_public()[:-1],
    hidden=_polar_hidden,
    comparison=Close(names=("by_pose", "by_measurement")),
    hints=(
        "There are two rows, l_x and l_y of equation 5.3. Heading and bearing appear only as a sum. What does that mean for the derivatives with respect to them?",
        "by_pose is an identity and a third column, the derivative with respect to theta. by_measurement has that third column again, for beta, and then a cosine and a sine, for r.",
    ),
    sibling=Sibling(
        "If two inputs appear only as a sum, the derivatives with respect to them are equal, so one column is computed once and used twice.",
        """
        import numpy as np


        def money(start, rate, bonus):  # after one year with continuous interest
            return start * np.exp(rate + bonus)


        growth = np.exp(0.03 + 0.01)
        by_rate = 200 * growth
        J = np.array([growth, by_rate, by_rate])  # by start, rate and bonus
        by_bonus = (money(200, 0.03, 0.01001) - money(200, 0.03, 0.00999)) / 2e-5
        print(J.round(3), round(by_bonus, 3))
        """,
        "[  1.041 208.162 208.162] 208.162",
    ),
    mistakes=catalogue("""
        range first: return by_pose, by_measurement => return by_pose, by_measurement[:, ::-1]
            The columns of by_measurement are swapped. A measurement is (bearing, range).
        cosine and sine swapped: c, s = => s, c =
            Cosine and sine are swapped in all entries. In equation 5.3 l_x contains the cosine, so its derivative with respect to an angle is -r sin, and with respect to r it is cos.
        cosine and sine swapped by the range: [[across[0], c], [across[1], s]] => [[across[0], s], [across[1], c]]
            In by_measurement's column for the range cosine and sine are swapped. l_x contains r cos(theta + beta), so its derivative with respect to r is the cosine.
        derivatives by the angles swapped: -measurement[1] * s, measurement[1] * c => measurement[1] * c, -measurement[1] * s
            The derivatives with respect to heading and bearing are swapped. l_x contains the cosine, so -r sin is in the first row and r cos in the second.
        heading first: [[1, 0, across[0]], [0, 1, across[1]]] => [[across[0], 1, 0], [across[1], 0, 1]]
            The columns of by_pose are in another order. They belong to x, y and theta.
        a row for the heading: return by_pose, by_measurement => return np.vstack([by_pose, [0, 0, 1]]), by_measurement
            Your by_pose has a row for theta. A landmark has only a position, so there are two rows, l_x and l_y.
        bearing's sign: [[across[0], c], [across[1], s]] => [[-across[0], c], [-across[1], s]]
            by_measurement's column for the bearing has the wrong sign. Heading and bearing are both positive to the left, so their derivatives are the same.
        minus forgotten: -measurement[1] => measurement[1]
            The derivative of l_x with respect to an angle has the wrong sign. The derivative of the cosine is minus the sine.
        range forgotten: -measurement[1] * s, measurement[1] * c => -s, c
            The factor r is missing in the derivatives with respect to heading and bearing. A far landmark moves more than a near one.
        heading forgotten: pose[2] + measurement[0] => measurement[0]
            Your derivatives are only right for a robot with heading 0. Use the angle theta + beta everywhere.
        heading subtracted: pose[2] + => -pose[2] +
            Your angle is beta - theta. It should be theta + beta, as in equation 5.3.
        position forgotten: [[1, 0, across[0]], [0, 1, => [[0, 0, across[0]], [0, 0,
            The identity in by_pose is missing. When the robot's position changes, the landmark's computed position changes by the same amount.
        zero by the heading: [[1, 0, across[0]], [0, 1, across[1]]] => [[1, 0, 0], [0, 1, 0]]
            by_pose's column for theta is zero. When the heading changes, the landmark's computed position moves on a circle around the robot.
        swapped: return by_pose, by_measurement => return by_measurement, by_pose
            The two matrices are swapped. by_pose (2, 3) comes first.
        transposed: return by_pose, by_measurement => return by_pose, by_measurement.T
            by_measurement is transposed. Its rows are l_x and l_y.
        both transposed: return by_pose, by_measurement => return by_pose.T, by_measurement.T
            Both matrices are transposed. Rows are l_x and l_y, columns are the variables with respect to which you differentiate.
        whole numbers in by_pose: return by_pose, by_measurement => return by_pose.astype(int), by_measurement
            The decimals of by_pose are cut off. np.array([[1, 0, 0], [0, 1, 0]]) makes an array of whole numbers, and what you assign to its entries later is cut off, too. Begin with np.eye(2, 3), or write all entries in np.array at once.
        whole numbers in both: return by_pose, by_measurement => return by_pose.astype(int), by_measurement.astype(int)
            The decimals of both matrices are cut off. np.array([[1, 0, 0], [0, 1, 0]]) makes an array of whole numbers, and what you assign to its entries later is cut off, too. Begin with np.zeros or np.eye, or write all entries in np.array at once.
        side by side: return by_pose, by_measurement => return np.hstack([by_pose, by_measurement])
            You return one matrix (2, 5). Return two matrices: return by_pose, by_measurement.
        minus forgotten once: 0, across[0] => 0, -across[0]
            by_pose[0, 2] has the wrong sign. The derivative of the cosine is minus the sine.
        minus forgotten by the bearing: [[across[0] => [[-across[0]
            by_measurement[0, 0] has the wrong sign. The derivative of the cosine is minus the sine.
        range forgotten by the heading: [[1, 0, across[0]], [0, 1, across[1]]] => [[1, 0, -s], [0, 1, c]]
            The factor r is missing in by_pose's column for theta. A far landmark moves more than a near one.
        range forgotten by the bearing: [[across[0], c], [across[1], s]] => [[-s, c], [c, s]]
            The factor r is missing in by_measurement's column for the bearing. A far landmark moves more than a near one.
        range too much: [[across[0], c], [across[1], s]] => [[across[0], measurement[1] * c], [across[1], measurement[1] * s]]
            by_measurement's column for the range still contains r. The derivative of r cos(...) with respect to r is cos(...).
        bearing forgotten: pose[2] + measurement[0] => pose[2]
            The bearing is missing in your derivatives. Use the angle theta + beta everywhere.
        bearing subtracted: pose[2] + => pose[2] -
            Your angle is theta - beta. It should be theta + beta, as in equation 5.3.
        range taken first: + measurement = measurement[::-1]
            You unpack the measurement as (range, bearing). It is (bearing, range).
        not differentiated: -measurement[1] * s, measurement[1] * c => measurement[1] * c, measurement[1] * s
            The derivatives with respect to heading and bearing contain r cos and r sin themselves. Differentiate them: -r sin and r cos.
        bearing forgotten in by_pose: by_pose = np.array([[1, 0, across[0]], [0, 1, across[1]]]) => by_pose = np.array([[1, 0, -measurement[1] * np.sin(pose[2])], [0, 1, measurement[1] * np.cos(pose[2])]])
            The bearing is missing in by_pose's column for theta. Use the angle theta + beta there, too.
        heading forgotten in by_measurement: [[across[0], c], [across[1], s]] => [[-measurement[1] * np.sin(measurement[0]), np.cos(measurement[0])], [measurement[1] * np.cos(measurement[0]), np.sin(measurement[0])]]
            The heading is missing in by_measurement. Use the angle theta + beta there, too.
    """),
    alternatives={
        "differences": _position_differences,
        "complex": _position_jacobians_complex,
        "a rotation": _position_jacobians,
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
_JACOBIAN = _MODEL.jacobian([_x, _y, _theta])


def _points(rng: np.random.Generator) -> dict[str, Array]:
    """Draw robots and landmarks in all directions, some with headings near half a turn."""
    poses = np.array([random_pose(rng) for _ in range(12)])
    poses[:4, 2] = [np.pi, -np.pi, 3.1, -3.1]
    landmarks = np.array([landmark_from(pose, random_measurement(rng)) for pose in poses])
    return dict(zip(("x", "y", "theta", "l_x", "l_y"), [*poses.T, *landmarks.T], strict=True))


def _with_half_angle() -> tuple[Any, Any]:
    """Return a model with the half-angle formula, and SymPy's own Jacobian, not simplified."""
    r = sympy.sqrt(_q)
    model = sympy.Matrix([[2 * sympy.atan2(_dy, r + _dx) - _theta, r]])
    return model, model.T.jacobian([_x, _y, _theta])


def _real_symbols() -> tuple[Any, Any]:
    real = {each: sympy.Symbol(each.name, real=True) for each in (_x, _y, _theta, _l_x, _l_y)}
    return _MODEL.subs(real), _JACOBIAN.subs(real)


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
        "The derivative of arctan(t) is 1 / (1 + t^2). Put t = dy / dx, multiply by the inner derivative, and expand with dx^2, so that the denominator is dx^2 + dy^2.",
        "dx = l_x - x has the inner derivative -1 with respect to x, so each derivative with respect to x or y is minus the derivative with respect to dx or dy. theta appears only once, in the bearing.",
    ),
    sibling=Sibling(
        "The chain rule needs the outer derivative, the derivative of the quotient inside, and -1 because the distance becomes smaller when the position p grows.",
        """
        import numpy as np

        wall, height, p = 7.0, 2.0, 3.0  # f(p) = log(height / (wall - p))
        d = wall - p
        outer = 1 / (height / d)  # derivative of log at the quotient
        quotient = -height / d**2  # derivative of height / d with respect to d
        inner = -1.0  # derivative of d with respect to p
        numeric = (np.log(height / (d - 1e-5)) - np.log(height / (d + 1e-5))) / 2e-5
        print(f"{outer * quotient * inner:.4f} = 1 / d, and by a difference {numeric:.4f}")
        """,
        "0.2500 = 1 / d, and by a difference 0.2500",
    ),
    mistakes=catalogue("""
        inner derivative forgotten: [[dy / q, -dx / q, -1], [-dx / r, -dy => [[-dy / q, dx / q, -1], [dx / r, dy
            All derivatives with respect to x and y have the wrong sign. You differentiated by dx and dy, so the inner derivative of -1 is missing.
        bearing's signs: [[dy / q, -dx => [[-dy / q, dx
            The derivatives of the bearing with respect to x and y have the wrong sign. If the robot moves left (y grows), a landmark ahead moves to the right.
        range's signs: [-dx / r, -dy => [dx / r, dy
            The derivatives of the range with respect to x and y have the wrong sign. If the robot drives towards a landmark, the range shrinks.
        r for r^2: dy / q, -dx / q => dy / r, -dx / r
            The derivatives of the bearing are divided by r. Divide them by r^2 = dx^2 + dy^2.
        r^2 for r: -dx / r, -dy / r => -dx / q, -dy / q
            The derivatives of the range are divided by r^2. Divide them by r, the root.
        the missing -1: -1] => 0]
            In your matrix the derivative of the bearing with respect to theta is 0. The heading is subtracted in the bearing, so it is -1.
        divisors exchanged: dy / q, -dx / q => dy / r, -dx / r
            [-dx / r, -dy / r, 0] => [-dx / q, -dy / q, 0]
            The two divisors are exchanged. Divide the derivatives of the bearing by r^2 = dx^2 + dy^2, and the derivatives of the range by r.
        inner derivative and the -1: [[dy / q, -dx / q, -1], [-dx / r, -dy => [[-dy / q, dx / q, 0], [dx / r, dy
            There are two errors: the inner derivative of -1 is missing in all derivatives with respect to x and y; and the derivative of the bearing with respect to theta is -1.
        bearing's signs and the -1: [[dy / q, -dx / q, -1] => [[-dy / q, dx / q, 0]
            There are two errors in the bearing's row: its derivatives with respect to x and y have the wrong sign, and the one with respect to theta is -1.
        r for r^2, inner derivative forgotten: [[dy / q, -dx / q, -1], [-dx / r, -dy => [[-dy / r, dx / r, -1], [dx / r, dy
            There are two errors: the inner derivative of -1 is missing in all derivatives with respect to x and y; and you divide the derivatives of the bearing by r, but it should be r^2.
        plus 1: -1] => 1]
            In your matrix the derivative of the bearing with respect to theta is +1. If the robot turns left, the landmark moves to the right, so it is -1.
        rows swapped: return model, jacobian => return model, jacobian[::-1, :]
            The rows of your Jacobian are swapped. The bearing comes first.
        range first: return model, jacobian => return model[::-1, :], jacobian[::-1, :]
            Your model is (range, bearing). A measurement is (bearing, range).
        dx and dy swapped: dy / q, -dx / q => -dx / q, dy / q
            In the derivatives of the bearing dx and dy are swapped. The derivative with respect to x is dy / r^2.
        atan2 the other way: atan2(dy, dx) => atan2(dx, dy)
            [[dy / q, -dx => [[-dy / q, dx
            Your model has atan2(dx, dy). y comes first.
        atan2 the other way, the Jacobian right: atan2(dy, dx) => atan2(dx, dy)
            Your Jacobian is right, but your model is not: atan2 takes y first.
        range first, the Jacobian right: [sp.atan2(dy, dx) - theta, r] => [r, sp.atan2(dy, dx) - theta]
            Your Jacobian is right, but your model is not: the bearing comes first, then the range.
        atan for atan2: atan2(dy, dx) => atan(dy / dx)
            Your Jacobian is right, but your model is not. atan(dy / dx) gives the same angle for a landmark ahead and one behind, and atan2(dy, dx) does not. Both have the same derivatives.
        from the landmark: atan2(dy, dx) => atan2(-dy, -dx)
            Your Jacobian is right, but your model is half a turn off, because its direction points from the landmark to the robot. dx is l_x - x.
        heading added: - theta => + theta
            -1] => 1]
            Your model adds theta. A bearing is relative to the heading: subtract theta.
        to the right: sp.atan2(dy, dx) - theta => theta - sp.atan2(dy, dx)
            [[dy / q, -dx / q, -1] => [[-dy / q, dx / q, 1]
            Your bearings are positive to the right. The bearing is atan2(dy, dx) - theta.
        heading forgotten: dx) - theta => dx)
            -1] => 0]
            Your bearing is measured from the x axis. It is relative to the heading: subtract theta.
        root forgotten: theta, r] => theta, q]
            -dx / r, -dy / r => -2 * dx, -2 * dy
            Your range is the squared distance. Take the square root.
    """),
    alternatives={
        "by SymPy": lambda: (_MODEL, _JACOBIAN),
        "with the wrap, as lists": lambda: (
            [sympy.Mod(_MODEL[0] + sympy.pi, 2 * sympy.pi) - sympy.pi, _MODEL[1]],
            _JACOBIAN.tolist(),
        ),
        "half the angle, a row": _with_half_angle,
        "real symbols": _real_symbols,
    },
    equivalents=as_lists(
        "model = [sp.atan2(dy, dx) - theta, r]", "jacobian = [[dy / q, -dx / q, -1], [-dx / r, -dy / r, 0]]"
    ),
)


# --- 5.8 measurement_jacobian_pose ---
def _jacobian_by_unit_vectors(pose: Array, landmark: Array) -> Array:
    r = np.linalg.norm(landmark - pose[:2])
    x, y = (landmark - pose[:2]) / r
    return np.array([[y / r, -x / r, -1.0], [-x, -y, 0.0]], dtype=np.float32)


def _jacobian_by_angles(pose: Array, landmark: Array) -> list[list[float]]:
    bearing, r = range_and_bearing(pose, landmark)
    c, s = math.cos(pose[2] + bearing), math.sin(pose[2] + bearing)
    return [[s / r, -c / r, -1.0], [-c, -s, 0.0]]


def _point_by_inverse(pose: Array, landmark: Array) -> Array:
    return np.linalg.inv(_position_jacobians(pose, range_and_bearing(pose, landmark))[1])


_SLIPS = catalogue("""
    rows swapped: return => H =
        + return H[::-1]
        The rows are swapped. A measurement is (bearing, range), so the derivatives of the bearing come first.
    degrees: return => H =
        + return H * [[180 / np.pi], [1]]
        The bearing's row is in degrees. Angles are in radians here.
    whole numbers: return => H =
        + return H.astype(int)
        The decimals of your matrix are cut off. An np.array of whole numbers such as 0 and -1 stays one of whole numbers, and what you assign to its entries later is cut off, too. Begin with np.zeros, or write all entries in np.array at once.
    r for r^2: return => H =
        + H[0, :2] *= np.hypot(*(landmark - pose[:2]))
        + return H
        The derivatives of the bearing are divided by r. Divide them by r^2 = dx^2 + dy^2.
    divisors exchanged: return => H =
        + H[0, :2] *= np.hypot(*(landmark - pose[:2]))
        + return H / [[1], [np.hypot(*(landmark - pose[:2]))]]
        The two divisors are exchanged. Divide the derivatives of the bearing by r^2 = dx^2 + dy^2, and the derivatives of the range by r, the square root.
    r^2 for r: return => H =
        + return H / [[1], [np.hypot(*(landmark - pose[:2]))]]
        The derivatives of the range are divided by r^2. Divide them by r, the root.
    dx and dy swapped: return => H =
        + return np.array([[*H[0, 1::-1], *H[0, 2:]], H[1]])
        In the bearing's row the first two entries are in each other's place.
    dx and dy swapped, signs kept: return => H =
        + return np.array([[*-H[0, 1::-1], *H[0, 2:]], H[1]])
        In the bearing's row dx and dy are swapped. The signs are right.
    dx and dy swapped in the range: return => H =
        + return np.array([H[0], [*H[1, 1::-1], *H[1, 2:]]])
        In the range's row dx and dy are swapped.
    the range's row not divided: return => H =
        + return H * [[1], [np.hypot(*(landmark - pose[:2]))]]
        The derivatives of the range are not divided. Divide them by r, the root.
    the root's half: return => H =
        + return H * [[1], [0.5]]
        The derivatives of the range are half as large as they should be. The 2 of the inner derivative cancels the 2 of the root's derivative.
    the root's two: return => H =
        + return H * [[1], [2]]
        The derivatives of the range are twice as large as they should be. The derivative of the root is 1 / (2 sqrt(q)).
""")


BY_POSE = Exercise(
    name="measurement_jacobian_pose",
    points=2,
    stars=2,
    public=_measurements_public,
    hidden=_measurements_hidden,
    comparison=Close(names=("by x", "by y", "by theta")),
    hints=(
        "This is the matrix from exercise 5.7 with numbers in place of symbols. Compute dx, dy and q = dx^2 + dy^2 first, then the rows.",
        "The first row is divided by q and ends with -1. The second row is divided by the root of q and ends with 0.",
    ),
    sibling=Sibling(
        "The loudness 1 / r of a loudspeaker depends on the position through dx, dy and q, as your measurement does, so these are computed first, and each derivative is a fraction with a power of q.",
        """
        import numpy as np


        def loudness(x, y):
            return 1 / np.hypot(4 - x, 3 - y)  # the loudspeaker is at (4, 3)


        dx, dy = 4 - 1, 3 - 2
        q = dx**2 + dy**2
        J = np.array([dx, dy]) / q**1.5
        by_x = (loudness(1 + 1e-5, 2) - loudness(1 - 1e-5, 2)) / 2e-5
        print(J.round(4), round(by_x, 4))
        """,
        "[0.0949 0.0316] 0.0949",
    ),
    mistakes=[
        *_SLIPS,
        *catalogue("""
        inner derivative forgotten: [[dy / q, -dx / q, -1], [-dx / r, -dy => [[-dy / q, dx / q, -1], [dx / r, dy
            All derivatives with respect to x and y have the wrong sign. Either you differentiated with respect to dx and dy and forgot the factor -1, because dx = l_x - x; or your dx and dy point from the landmark to the robot.
        bearing's signs: [[dy / q, -dx => [[-dy / q, dx
            The derivatives of the bearing with respect to x and y have the wrong sign. If the robot moves left (y grows), a landmark ahead moves to the right.
        range's signs: [-dx / r, -dy => [dx / r, dy
            The derivatives of the range have the wrong sign. If the robot drives towards a landmark, the range shrinks.
        the missing -1: -1] => 0]
            The derivative of the bearing with respect to theta is missing. The heading is subtracted, so it is -1.
        plus 1: -1] => 1]
            In your matrix the derivative of the bearing with respect to theta is +1. If the robot turns left, the landmark moves to the right, so it is -1.
        r for r^2, the missing -1: dy / q, -dx / q, -1 => dy / r, -dx / r, 0
            There are two mistakes in the bearing's row: divide its derivatives by r^2, and the entry for theta is -1.
        r for r^2, inner derivative forgotten: [[dy / q, -dx / q, -1], [-dx / r, -dy => [[-dy / r, dx / r, -1], [dx / r, dy
            There are two mistakes: the derivatives with respect to x and y have the wrong sign, because dx = l_x - x; and you divide the derivatives of the bearing by r, but it should be r^2.
        range by the heading: -dy / r, 0 => -dy / r, -1
            In your matrix the derivative of the range with respect to theta is -1. A robot that turns on the spot does not change its distance, so it is 0.
        the -1 in the range's row: -dx / q, -1] => -dx / q, 0]
            -dy / r, 0] => -dy / r, -1]
            The -1 is in the range's row. Only the bearing contains theta, so the -1 belongs in the first row.
        one sign in the bearing, by x: [[dy / q => [[-dy / q
            The derivative of the bearing with respect to x has the wrong sign. The worked entry of the text is dy / q.
        columns for the landmark: return => H =
            + return np.hstack([H, -H[:, :2]])
            Your matrix is 2 x 5. This function returns the columns for x, y and theta only; exercise 5.9 asks for the landmark's.
        one sign in the bearing: -dx / q => dx / q
            The derivative of the bearing with respect to y has the wrong sign. If the robot moves left (y grows), a landmark ahead moves to the right.
        no column for the heading: 0]]) => 0]])[:, :2]
            Your matrix is 2 x 2. The column for theta is missing.
        transposed: 0]]) => 0]]).T
            Your matrix is transposed. It has two rows, bearing and range, and three columns, x, y and theta.
        in the robot's frame: + angle, distance = expected_measurement(pose, landmark)
            + pose, landmark = np.zeros(3), distance * np.array([np.cos(angle), np.sin(angle)])
            Your dx and dy are in the robot frame. The pose's x and y are in the field frame, so dx is l_x - x, without a rotation.
    """),
    ],
    alternatives={
        "central differences": lambda *at: jacobian_at(*at)[:, :3],
        "a unit vector, float32": _jacobian_by_unit_vectors,
        "bearing and range": _jacobian_by_angles,
    },
    equivalents=as_lists("return [[dy / q, -dx / q, -1], [-dx / r, -dy / r, 0]]"),
)


# --- 5.9 measurement_jacobian_landmark ---
BY_LANDMARK = Exercise(
    name="measurement_jacobian_landmark",
    points=3,
    stars=3,
    uses=("expected_measurement", "landmark_jacobians", "measurement_jacobian_pose"),
    public=_measurements_public,
    hidden=_measurements_hidden,
    comparison=Close(names=("by l_x", "by l_y")),
    hints=(
        "There are three ways: differentiate again, use property 1, or read property 2 as the definition of an inverse.",
        "Property 1: when robot and landmark move together, the measurement does not change. So the derivatives with respect to the landmark's position and to the robot's position add up to zero. Which columns of which of your functions do you need?",
    ),
    sibling=Sibling(
        "The force of a spring depends only on the difference of its ends, as a measurement depends on the difference of landmark and robot: moving both changes nothing, so both derivatives add up to zero.",
        """
        import numpy as np


        def by_left(left, right, stiffness):  # derivatives of stiffness * (right - left)**3
            stretch = right - left
            return np.array([-3 * stiffness * stretch**2, stretch**3])  # by left and by stiffness


        whole = by_left(1.0, 1.5, 20.0)
        by_right = -whole[0]  # only the entry of the position changes its sign
        h = 1e-5
        by_difference = 20 * ((0.5 + h) ** 3 - (0.5 - h) ** 3) / (2 * h)
        print(f"{by_right:.3f}, and by a difference {by_difference:.3f}")
        """,
        "15.000, and by a difference 15.000",
    ),
    mistakes=[
        *_SLIPS,
        *catalogue("""
        derivatives by the robot: -measurement_jacobian_pose => measurement_jacobian_pose
            All signs are wrong. These are the derivatives with respect to the robot's x and y; moving the landmark has the opposite effect.
        bearing's signs: [:, :2] => [:, :2] * [[-1], [1]]
            The signs in the bearing's row are wrong. If a landmark ahead moves to the left, its bearing grows.
        range's signs: [:, :2] => [:, :2] * [[1], [-1]]
            The signs in the range's row are wrong. If a landmark moves away, its range grows.
        not inverted: + return landmark_jacobians(pose, expected_measurement(pose, landmark))[1]
            You return by_measurement, the derivatives of the landmark's position with respect to the measurement. You need its inverse.
        transposed, not inverted: + return landmark_jacobians(pose, expected_measurement(pose, landmark))[1].T
            You return the transpose of by_measurement. It is not the inverse, because the columns of by_measurement do not all have length 1.
        the wrong matrix inverted: + return np.linalg.inv(measurement_jacobian_pose(pose, landmark)[:, :2])
            You invert a Jacobian of the measurement, which gives a change of position for a change of the measurement. H_l goes the other way. By property 2, J_z is the matrix to invert.
        at the landmark: + return np.linalg.inv(landmark_jacobians(pose, landmark)[1])
            You call landmark_jacobians with a landmark. Its second argument is a measurement: expected_measurement(pose, landmark).
        transposed: [:, :2] => [:, :2].T
            Your matrix is transposed. Rows are bearing and range, columns l_x and l_y.
        with the heading: landmark)[:, :2] => landmark)
            Your matrix has a column for the heading. The landmark has only two coordinates.
        in the robot's frame: + angle, distance = expected_measurement(pose, landmark)
            + pose, landmark = np.zeros(3), distance * np.array([np.cos(angle), np.sin(angle)])
            You differentiate with respect to the landmark in the robot frame. l_x and l_y are in the field frame, so dx is l_x - x, without a rotation.
        no division: [:, :2] => [:, :2] * np.hypot(*(landmark - pose[:2])) ** np.array([[2], [1]])
            Your matrix is not divided. Divide the bearing's row by r^2 and the range's row by r.
        last columns of H_p: -measurement_jacobian_pose(pose, landmark)[:, :2] => measurement_jacobian_pose(pose, landmark)[:, 1:]
            You used the last two columns of the Jacobian with respect to the pose. Use the first two, for x and y, and change their signs.
    """),
    ],
    alternatives={
        "central differences": lambda *at: jacobian_at(*at)[:, 3:],
        "an inverse": _point_by_inverse,
        "from the Jacobian by the pose, float32": lambda *at: -_jacobian_by_unit_vectors(*at)[:, :2],
    },
)


PLAN = LessonPlan(
    exercises=[POSE, MEASUREMENT, POSITION, MOTION, COVARIANCE, LANDMARK, DERIVE, BY_POSE, BY_LANDMARK],
    questions=[
        Question(
            "what_is_a_column",
            "The third column of F is (-d sin(theta), d cos(theta), 1). With heading 0 and d = 2 m it is (0, 2, 1). What does the 2 mean?",
            {
                "The robot drives 2 m along y.": "With heading 0 it drives along x. The column describes the effect of an error, not where the robot goes.",
                "If the heading is off by 0.01 rad, y is off by 2 cm.": "A derivative times a small change gives a small change: 2 m/rad times 0.01 rad is 2 cm. The 1 below means that the heading is still off by 0.01 rad.",
                "y is twice as uncertain as the heading.": "Derivatives have units: 2 m for each radian. Metres and radians cannot be compared.",
            },
            "If the heading is off by 0.01 rad, y is off by 2 cm.",
        ),
        Question(
            "why_no_other_landmark",
            'In 1.6 the report gives two reasons why it needs no Jacobian with respect to other landmarks: "the assumption of landmark independence", and that a measurement "does not depend on the positions of other landmarks". Which reason is right?',
            {
                "Landmarks are independent, so these derivatives are zero.": "The derivatives are zero, but not for this reason, the first of the report's. After measurements from one uncertain pose the estimates of the landmarks are strongly correlated, as the next cell measures.",
                "The bearing and range of one landmark do not contain the coordinates of another.": "This is the report's second reason. h(p, l) is a formula with five variables, and its derivative with respect to any other variable is zero. That needs no independence.",
                "The derivatives are not zero, but small enough to be left out.": "They are exactly zero. Move another landmark as far as you like, and the measurement of this one does not change.",
            },
            "The bearing and range of one landmark do not contain the coordinates of another.",
        ),
    ],
    written=[
        Written(
            "explain_banana",
            points=2,
            question="Why do the samples form a banana when the heading is uncertain by 30 degrees, and why does the ellipse not?",
            rubric="1 point: all samples drive the same distance, each along its own heading, so they lie on an arc around the start. 1 point: a Jacobian replaces the arc by its tangent at the mean heading. A linear function of a Gaussian is a Gaussian, so the ellipse is tangential and not bent, and its centre is farther away than the samples' mean.",
        )
    ],
)
