"""Lesson 09, pose graphs: its exercises, typical mistakes, and alternative correct solutions."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse
import scipy.sparse.linalg

from nao_course.exercises import Case, Close, Exercise, LessonPlan, Mistake, Question, Sibling, Written
from nao_course.geometry import rotation_2d, wrap_angle
from nao_course.graphs import LANDMARK, POSE, Graph, matrices
from nao_course.instructor.authoring.mistakes import catalogue
from nao_course.lessons.pose_graphs.judging.comparing import SolvedStates
from nao_course.lessons.pose_graphs.worlds import (
    building,
    disturbed,
    drifting_loop,
    field_drive,
    loop,
    with_false_closures,
)

Array = npt.NDArray[np.float64]
DRIVERS = "nao_course.lessons.pose_graphs.judging.drivers"
BLOCKS, AS_ARRAY = f"{DRIVERS}:blocks_of_inverse", f"{DRIVERS}:as_array"
FINE = Close(rtol=1e-6, atol=1e-7)


# --- shared by several exercises ---
def _rotated(theta: Any, x: Any, y: Any) -> Array:
    """Return poses as matrices: (3, 3), or (E, 3, 3)."""
    c, s = np.cos(theta), np.sin(theta)
    return matrices([[c, -s, x], [s, c, y], [0, 0, 1]])


def _any(rng: np.random.Generator, count: int, width: int = 3) -> Array:
    """Return random poses (count, 3) with headings in all directions, or positions (count, 2)."""
    values = rng.normal(0.0, 4.0, (count, width))
    if width == 3:
        values[:, 2] = rng.uniform(-np.pi, np.pi, count)
    return values


def _landmark(pose: Any, landmark: Any, z: Any) -> Any:
    """Compute the residual with rotation matrices."""
    return np.einsum("...ji,...j->...i", _rotated(pose.T[2], 0, 0)[..., :2, :2], landmark - pose[..., :2]) - z


def _landmark_complex(pose: Any, landmark: Any, z: Any) -> Any:
    x, y, theta = pose.T
    away = (landmark @ [1, 1j] - x - 1j * y) * np.exp(-1j * theta) - z @ [1, 1j]
    return np.array([away.real, away.imag]).T


def _landmark_jacobians(pose: Any, landmark: Any, z: Any) -> Any:
    """Compute the Jacobians as products of the rotation and the derivative of the way to the landmark."""
    turn = _rotated(pose.T[2], 0, 0)[..., :2, :2].mT
    dx, dy = (landmark - pose[..., :2]).T
    return -turn @ matrices([[1, 0, -dy], [0, 1, dx]]), turn


def _differences(residual: Callable[..., Array]) -> Callable[..., Any]:
    """Return a function that computes Jacobians by central differences."""

    def jacobians(first: Any, second: Any, z: Any) -> Any:
        def by(end: Array, at: Callable[[Array], Array]) -> Array:
            steps = 1e-5 * np.eye(end.shape[-1])
            return np.stack([at(end + step) - at(end - step) for step in steps], axis=-1) / 2e-5

        return by(first, lambda end: residual(end, second, z)), by(
            second, lambda end: residual(first, end, z)
        )

    return jacobians


def _edge_by_edge(function: Callable[..., Any], otypes: str, signature: str) -> Callable[..., Any]:
    return np.vectorize(function, otypes=otypes, signature=f"(i),(j),(k)->{signature}")


def _pair(rng: np.random.Generator, count: int | None, width: int, label: str = "") -> Case:
    """Return poses (E, 3), other ends (E, width) and measurements (E, width); without E, one of each."""
    ends = [_any(rng, 1 if count is None else count, each) for each in (3, width, width)]
    return Case(tuple(each[0] if count is None else each for each in ends), label)


FEW_EDGES = {
    "three edges, as many as a pose has numbers": 3,
    "an array of one edge": 1,
    "an array of no edge": 0,
}


def _shaped(name: str, arguments: str, end: str, columns: str) -> list[Mistake]:
    """Return mistakes in the shape of both residuals.

    `end` is how the last line of the solution ends, and `columns` is the change that transposes its answer.
    """
    return catalogue(
        f"""
        squeezed: return np.array => return np.squeeze(np.array
            {end} => {end})
            Your function is correct except for an array of one edge: np.squeeze turns its shape (1, 3) into (3,). Remove the squeeze.
        a list of no rows: + if z.ndim == 2: return np.array([{name}(*each) for each in zip({arguments})])
            Your function is correct except for an array with no edge, where the result has no columns. A graph without landmarks has such an array. Compute with whole arrays in place of the loop.
        a list: return np.array => return list(np.array
            {end} => {end})
            Your function returns a list. linearize computes with the result, so return one array: np.array([...]).T.
        columns: {columns}
            Your answer has one column per edge, but it should have one row per edge. End with .T, which does not change the result for a single edge.
        """
    )


# --- 9.1 landmark_residual ---
def _landmark_public() -> list[Case]:
    rng = np.random.default_rng(91)
    ahead = np.array([1.0, 2.0, np.pi / 2])
    counts = {"a crooked heading": None, "four edges at once": 4, **FEW_EDGES}
    return [
        Case((ahead, np.array([0.0, 5.0]), np.array([2.5, 1.0])), "the robot looks along y"),
        Case((np.array([1.0, 0.0, 0.0]), np.array([3.0, 1.0]), np.array([2.0, 1.0])), "measured exactly"),
        *(_pair(rng, count, 2, label) for label, count in counts.items()),
    ]


def _landmark_hidden(rng: np.random.Generator) -> list[Case]:
    return [_pair(rng, count, 2) for count in (None, None, None, 1, 3, 2, 50, 0)]


LANDMARK_RESIDUAL = Exercise(
    name="landmark_residual",
    points=1,
    public=_landmark_public,
    hidden=_landmark_hidden,
    comparison=FINE,
    driver=AS_ARRAY,
    hints=(
        "Compute the vector from the pose to the landmark in the map frame, rotate it into the robot's frame, and subtract the measurement.",
        "Let dx, dy be the vector from the pose to the landmark, and c, s the cosine and sine of the heading. Then ahead is c dx + s dy, and left is -s dx + c dy. End with .T as the worked example does.",
    ),
    sibling=Sibling(
        "The components of a vector along other axes are its dot products with these axes, and a transposed array has one row for each vector.",
        """
        import numpy as np

        street, cross = np.array([0.6, 0.8]), np.array([-0.8, 0.6])  # unit vectors of a town's grid
        hotel, shops = np.array([2.0, 1.0]), np.array([[6.0, 5.0], [1.0, 4.0], [3.0, -1.0]])
        east, north = (shops - hotel).T
        along = street[0] * east + street[1] * north
        across = cross[0] * east + cross[1] * north
        print(np.array([along, across]).T.round(2))
        """,
        """
        [[ 5.6 -0.8]
         [ 1.8  2.6]
         [-1.  -2. ]]
        """,
    ),
    mistakes=[
        *catalogue("""
        turned the wrong way: np.sin(theta) => np.sin(-theta)
            You rotate by R, but equation 9.1 has its transpose. R rotates from the robot's frame into the map frame, so you need the opposite rotation: exchange the signs of the two sines.
        sign: return np.array => return z - np.array
            .T - z => .T
            All signs are opposite. Equation 9.1 is the expected measurement minus z.
        z left out: .T - z => .T
            You return where the robot should measure the landmark. Subtract z, the actual measurement.
        position left out: lx - x, ly - y => lx, ly
            You rotate the landmark's position in the map. First subtract the robot's position, then rotate the difference.
        turned before it was shifted: lx - x, ly - y => lx, ly
            .T - z => .T - pose[..., :2] - z
            You rotate first and subtract the robot's position afterwards. The position is given in the map frame, so subtract it before you rotate.
        heading left out: c * dx + s * dy, -s * dx + c * dy => dx, dy
            Your difference is still in the map frame, but z is in the robot's frame. Rotate the difference by minus the heading before you subtract z.
        in the field's frame: return np.array([c * dx + s * dy, -s * dx + c * dy]).T - z => zx, zy = z.T
            + return np.array([dx - c * zx + s * zy, dy - s * zx - c * zy]).T
            You rotate z into the map frame and compare there. The result has the right length, but it must be in the robot's frame, because the information of z refers to that frame.
        bearing and range: return np.array([c * dx + s * dy, -s * dx + c * dy]).T - z => bearing = np.arctan2(dy, dx) - theta - np.arctan2(z.T[1], z.T[0])
            + return np.array([wrap_angle(bearing), np.hypot(dx, dy) - np.hypot(*z.T)]).T
            You compare bearings and ranges. In this lesson z is Cartesian: metres ahead and metres to the left.
        degrees: (theta) =>> (np.radians(theta))
            The heading is already in radians, so do not convert it.
        one edge only: pose.T => pose
            landmark.T => landmark
            .T - z => - z
            Your function is correct for one edge, but x, y, theta = pose does not unpack E poses, because the rows of (E, 3) are poses. Write x, y, theta = pose.T and lx, ly = landmark.T, and end with .T as the worked example does.
        the pose without .T: pose.T => pose
            You unpack the pose without .T. For E poses this takes the first three poses as x, y and theta. Write x, y, theta = pose.T.
        numbered like one edge: pose.T => pose[0], pose[1], pose[2]
            landmark.T => landmark[0], landmark[1]
            Your function is correct for one edge. For E edges pose[0], pose[2] and pose[:2] are poses, and there are E rotations. Unpack the transpose, x, y, theta = pose.T, and write the two rows as sums.
        many edges only: pose.T => pose[:, 0], pose[:, 1], pose[:, 2]
            landmark.T => landmark[:, 0], landmark[:, 1]
            Your function is correct for E edges, but pose[:, 0] does not work for one pose, whose shape is (3,). Unpack the transpose, which works for both: x, y, theta = pose.T.
        R, and one edge only: pose.T => pose
            landmark.T => landmark
            .T - z => - z
            np.sin(theta) => np.sin(-theta)
            You rotate by R, but equation 9.1 has its transpose. Besides, x, y, theta = pose does not unpack E poses: write pose.T and landmark.T, and end with .T.
        R as a matrix for one edge: + c, s = np.cos(pose[2]), np.sin(pose[2])
            + return np.array([[c, -s], [s, c]]) @ (landmark - pose[:2]) - z
            You multiply by R, but equation 9.1 has its transpose. Besides, one matrix works for one edge only: write the two rows as sums, as the worked example does.
        subtracted before .T: .T - z => - z
            For E edges your rows are an array (2, E), and z is (E, 2). Put .T before you subtract: np.array([...]).T - z.
        a matrix of all headings: + c, s = np.cos(pose.T[2]), np.sin(pose.T[2])
            + return np.array([[c, -s], [s, c]]).T @ (landmark - pose[..., :2]).T - z
            Your function is correct for one edge. For E headings, np.array([[c, -s], [s, c]]) is one array and not E matrices. Write the two rows as sums, as the worked example does.
        stacked along axis 1: return np.array([c * dx + s * dy, -s * dx + c * dy]).T - z => return np.stack([c * dx + s * dy, -s * dx + c * dy], axis=1) - z
            Your function is correct for E edges, but one edge has no axis 1. Write axis=-1, or np.array([...]).T, which work for both.
        the worked example for the landmark: c * dx + s * dy, -s * dx + c * dy => x + c * lx - s * ly, y + s * lx + c * ly
            You transform the landmark as the worked example transforms z. That goes from the robot's frame to the map frame, but here you need the opposite direction: subtract the robot's position first, then rotate by minus the heading.
        z placed on the map: return np.array([c * dx + s * dy, -s * dx + c * dy]).T - z => zx, zy = z.T
            + return np.array([c * zx - s * zy - dx, s * zx + c * zy - dy]).T
            You place z on the map and subtract the landmark there. Equation 9.1 compares in the robot's frame: rotate the vector from the robot to the landmark by minus the heading, and subtract z.
        the position by .T, and a matrix: + c, s = np.cos(pose.T[2]), np.sin(pose.T[2])
            + return np.array([[c, -s], [s, c]]).T @ (landmark - pose.T[:2]) - z
            Your function is correct for one edge. For E edges pose.T[:2] is (2, E) and landmark is (E, 2). Take dx, dy = (landmark - pose[..., :2]).T, and write the two rows as sums, as the worked example does.
        the measurement of lesson 05: c * dx + s * dy, -s * dx + c * dy => wrap_angle(np.arctan2(dy, dx) - theta), np.hypot(dx, dy)
            Your expected measurement is a bearing and a range, as in lesson 05. Here z is metres ahead and metres to the left.
        rows exchanged: c * dx + s * dy, -s * dx + c * dy => -s * dx + c * dy, c * dx + s * dy
            Your two rows are in the wrong order. z has the metres ahead first and the metres to the left second.
        left as right: -s * dx + c * dy => s * dx - c * dy
            Your second number counts metres to the right. In the robot's frame y points to the left: the second row is -s dx + c dy.
        from the landmark to the robot: lx - x, ly - y => x - lx, y - ly
            You rotate the vector from the landmark to the robot. Equation 9.1 has the landmark minus the robot.
        both sines with one sign: -s * dx => s * dx
            The two sines of your rotation have the same sign. In every rotation they have opposite signs.
        three edges for one: pose.T => pose if len(pose) == 3 else pose.T
            landmark.T => landmark if len(pose) == 3 else landmark.T
            Your function is correct except for three edges at once, because len(pose) == 3 holds for one pose and for three poses. You need no distinction: pose.T works for both.
        """),
        *_shaped("landmark_residual", "pose, landmark, z", ".T - z", ".T - z => - z.T"),
    ],
    alternatives={
        "complex numbers": _landmark_complex,
        "rotation matrices": _landmark,
        "edge by edge": _edge_by_edge(_landmark, "d", "(k)"),
    },
)


# --- 9.2 landmark_residual_jacobians ---
LANDMARK_RESIDUAL_JACOBIANS = Exercise(
    name="landmark_residual_jacobians",
    points=2,
    stars=2,
    public=_landmark_public,
    hidden=_landmark_hidden,
    comparison=Close(
        rtol=1e-6, atol=1e-7, names=("the Jacobian by the pose", "the Jacobian by the landmark")
    ),
    hints=(
        "The Jacobian by the landmark is the rotation Rᵀ, and the columns of x and y are its negative. For the column of theta, differentiate both rows on the sheet above.",
        "The derivative of the first row by theta is the second row without z: -s dx + c dy. The derivative of the second row is minus the first row without z. matrices(...) accepts numbers and arrays.",
    ),
    sibling=Sibling(
        "The derivative of a turned vector with respect to the angle is made of its own two components, exchanged and one with the other sign: here a point on a wheel that turns to the left.",
        """
        import numpy as np


        def turned(angle):
            x = 3 * np.cos(angle) - 2 * np.sin(angle)
            y = 3 * np.sin(angle) + 2 * np.cos(angle)
            return np.array([x, y])


        x, y = turned(0.4)
        by_difference = (turned(0.4 + 1e-6) - turned(0.4 - 1e-6)) / 2e-6
        print(np.array([-y, x]).round(4), by_difference.round(4))
        """,
        "[-3.0104  1.9843] [-3.0104  1.9843]",
    ),
    mistakes=catalogue("""
        sign: return matrices => return -matrices
            , matrices => , -matrices
            All signs are opposite. Your Jacobians belong to measured minus expected, but the residual is expected minus measured.
        sign of the first matrix: return matrices => return -matrices
            Your Jacobian by the pose has the opposite sign, and your Jacobian by the landmark is correct.
        sign of the second matrix: , matrices => , -matrices
            Your Jacobian by the pose is correct, but your Jacobian by the landmark has the opposite sign. If the landmark moves away ahead of the robot, the expected distance ahead increases.
        one edge only: pose.T => pose
            landmark.T => landmark
            Your function is correct for one edge, but x, y, theta = pose does not unpack E poses. Write pose.T and landmark.T, as in exercise 9.1.
        R all through: np.sin(theta) => np.sin(-theta)
            All your sines have the opposite sign, as if the residual were rotated by R. Equation 9.1 has its transpose.
        R by the landmark: [c, s], [-s, c] => [c, -s], [s, c]
            Your Jacobian by the landmark is R. The residual contains Rᵀ times the landmark, so it is Rᵀ.
        sign by the pose: [-c, -s, left], [s, -c, => [c, s, left], [-s, c,
            The columns of x and y have the wrong sign. If the robot moves towards the landmark, the expected distance ahead decreases.
        R by the pose: [-c, -s, left], [s, -c, => [-c, s, left], [-s, -c,
            The columns of x and y in your Jacobian by the pose are -R. They are -Rᵀ, the opposite of your Jacobian by the landmark.
        a sign in both rows of theta: c * (lx - x) + s * (ly - y), -s * (lx - x) + c * (ly - y) => c * (lx - x) - s * (ly - y), -s * (lx - x) - c * (ly - y)
            In both rows of your column of theta one of the two products has the wrong sign: the derivative of cos is -sin, and the derivative of sin is cos.
        theta forgotten: left], => 0],
            -ahead] => 0]
            Your column of theta is 0. If the robot turns, everything moves in its frame, so this column depends on the landmark.
        sign of theta: left], => -left],
            -ahead] => ahead]
            Your column of theta has the opposite sign. If the robot turns left, the landmark moves to the right in its frame.
        rows of theta: left], => -ahead],
            -ahead]]) => left]])
            The two rows in your column of theta are wrong. A turn changes `ahead` by how far left the landmark is, and `left` by minus how far ahead it is.
        theta from the residual: c * (lx - x) + s * (ly - y), -s * (lx - x) + c * (ly - y) => landmark_residual(pose, landmark, z).T
            Your column of theta contains the residual. z does not depend on the heading, so use the expected measurement without subtracting z.
        theta in the field's frame: c * (lx - x) + s * (ly - y), -s * (lx - x) + c * (ly - y) => lx - x, ly - y
            Your column of theta contains the vector to the landmark in the map frame. Rotate it into the robot's frame first.
        turned the wrong way: [-c, -s, left], [s, => [-c, s, left], [-s,
            [c, s], [-s, c] => [c, -s], [s, c]
            Your sines have the wrong signs, so this is R. The residual uses its transpose, which rotates from the map frame into the robot's frame.
        theta from z: c * (lx - x) + s * (ly - y), -s * (lx - x) + c * (ly - y) => z.T[0], z.T[1]
            Your column of theta contains the measurement z. The derivative contains the expected measurement, computed from the pose and the landmark.
        pose not subtracted: c * (lx - x) + s * (ly - y), -s * (lx - x) + c * (ly - y) => c * lx + s * ly, -s * lx + c * ly
            Your column of theta uses the landmark's position in the map. Subtract the pose's position first: dx = lx - x, dy = ly - y.
        theta in degrees: left], => np.radians(left)],
            -ahead] => -np.radians(ahead)]
            Your column of theta is a derivative by degrees. All angles are in radians, so leave out the factor pi / 180.
        by the pose only: -ahead]]), matrices([[c, s], [-s, c]]) => -ahead]])
            You return only the Jacobian by the pose. Return two: by the pose, and by the landmark.
        order: return matrices => return (matrices
            [-s, c]]) => [-s, c]]))[::-1]
            The order of your two matrices is wrong. Return the Jacobian by the pose first and the Jacobian by the landmark second.
        by the pose transposed: -ahead]]), => -ahead]]).mT,
            Your Jacobian by the pose is transposed. Its rows are ahead and left, its columns x, y and theta.
        transposed: -ahead]]) => -ahead]]).mT
            [-s, c]]) => [-s, c]]).mT
            Both matrices are transposed. A row belongs to a number of the residual, and a column belongs to the variable of the derivative.
        one matrix
            return matrices([[-c, -s, left], [s, -c, -ahead]]), matrices([[c, s], [-s, c]]) => return matrices([[-c, -s, left, c, s], [s, -c, -ahead, -s, c]])
            You return one matrix. Return two matrices, (2, 3) and (2, 2).
        edges last: matrices( =>> np.array(
            Your matrices are correct for one edge. For E edges the first axis must count the edges, (E, 2, 3); matrices([[...], [...]]) makes this shape.
    """),
    alternatives={
        "central differences": _differences(_landmark),
        "edge by edge": _edge_by_edge(_landmark_jacobians, "dd", "(k,i),(k,j)"),
        "products": _landmark_jacobians,
    },
)


# --- 9.3 pose_residual ---
def _pose(first: Any, second: Any, z: Any) -> Any:
    """Compute the residual with the matrices of equation 9.3."""
    Z, start, end = (_rotated(each.T[2], *each.T[:2]) for each in (z, first, second))
    e = np.linalg.inv(Z) @ np.linalg.inv(start) @ end
    return np.stack([e[..., 0, 2], e[..., 1, 2], np.arctan2(e[..., 1, 0], e[..., 0, 0])], axis=-1)


def _pose_complex(first: Any, second: Any, z: Any) -> Any:
    here, there, step = (each.T[0] + 1j * each.T[1] for each in (first, second, z))
    away = ((there - here) * np.exp(-1j * first.T[2]) - step) * np.exp(-1j * z.T[2])
    return np.array([away.real, away.imag, np.angle(np.exp(1j * (second - first - z).T[2]))]).T


def _pose_jacobians(first: Any, second: Any, z: Any) -> Any:
    """Compute the Jacobians as products of the rotation and the derivative of the way to the second pose."""
    by_second = _rotated((first + z).T[2], 0, 0).mT
    dx, dy, _ = (second - first).T
    return -by_second @ matrices([[1, 0, -dy], [0, 1, dx], [0, 0, 1]]), by_second


def _pose_public() -> list[Case]:
    rng = np.random.default_rng(93)
    left = [[1.0, 2.0, np.pi / 2], [1.0, 4.0, np.pi], [1.5, 0.0, np.pi / 2]]
    around = [[0.0, 0.0, 3.0], [-1.0, 0.2, -3.1], [1.0, 0.0, 0.1]]
    counts = {"crooked headings": None, "five edges at once": 5, **FEW_EDGES}
    return [
        Case(tuple(map(np.array, left)), "two steps where 1.5 were measured, then a left turn"),
        Case(tuple(map(np.array, around)), "headings on both sides of pi"),
        *(_pair(rng, count, 3, label) for label, count in counts.items()),
    ]


def _pose_hidden(rng: np.random.Generator) -> list[Case]:
    near = np.array([0.0, 0.0, np.pi - 1e-3])
    one = [_pair(rng, None, 3) for _ in range(3)]
    around = Case((near, _any(rng, 1)[0] * [1, 1, 0] - near, _any(rng, 1)[0] * [1, 1, 0.1]))
    return [*one, around, *(_pair(rng, count, 3) for count in (1, 3, 60, 0))]


POSE_RESIDUAL = Exercise(
    name="pose_residual",
    points=2,
    stars=2,
    public=_pose_public,
    hidden=_pose_hidden,
    comparison=FINE,
    driver=AS_ARRAY,
    hints=(
        "Change the frame twice, each time as in exercise 9.1: express the second pose in the frame of the first one, and the result in the frame of z.",
        "After the first change of frame, subtract the x and y of z and rotate by minus the angle of z. The third number is second - first - z of the headings, and wrap_angle is applied last.",
    ),
    sibling=Sibling(
        "Two frames are entered one after the other, and each time the origin is subtracted first and the rest is turned back by the frame's angle: here a cup, seen from a robot's hand.",
        """
        import numpy as np


        def seen_from(origin, angle, point):
            x, y = point - origin
            axis = np.array([np.cos(angle), np.sin(angle)])  # the frame's x axis
            return np.array([axis @ (x, y), axis @ (y, -x)])


        cup = np.array([1.0, 3.0])
        from_arm = seen_from(np.array([0.5, 1.0]), np.radians(30), cup)
        print(from_arm.round(3), seen_from(np.array([1.0, 0.2]), np.radians(-20), from_arm).round(3))
        """,
        "[1.433 1.482] [-0.032  1.353]",
    ),
    mistakes=[
        *catalogue("""
        unwrapped: wrap_angle(theta2 - theta - turn) => theta2 - theta - turn
            Your angle is not wrapped. Headings of 3.1 and -3.1 are nearly the same direction, but your residual is 6.2 rad. Apply wrap_angle to the third number.
        wrapped too early: wrap_angle(theta2 - theta - turn) => wrap_angle(theta2 - theta) - turn
            You wrap the difference of the headings and subtract the angle of z afterwards, so the result can leave (-pi, pi]. Apply wrap_angle last.
        from 0 to 2 pi: wrap_angle(theta2 - theta - turn) => (theta2 - theta - turn) % (2 * np.pi)
            Your angle goes from 0 to 2 pi, so an error of -0.1 becomes 6.18. wrap_angle returns values from -pi to pi.
        degrees: wrap_angle(theta2 - theta - turn) => np.degrees(wrap_angle(theta2 - theta - turn))
            Your angle is in degrees. Leave it in radians.
        the sine of it: wrap_angle => np.sin
            You return the sine of the angle. The third number is the wrapped angle itself.
        not in z's frame: c * ahead + s * left, -s * ahead + c * left => ahead, left
            You forgot R_zᵀ: your x and y are in the frame of the first pose. Rotate them by minus the angle of z. (Some books leave this rotation out, but then the information and the Jacobians refer to another frame.)
        first rotation left out: c * (x2 - x) + s * (y2 - y) - zx => x2 - x - zx
            -s * (x2 - x) + c * (y2 - y) - zy => y2 - y - zy
            You forgot R(theta_i)ᵀ, the first rotation. z is measured in the frame of the first pose, so rotate the difference of the positions by minus the first heading before you subtract z.
        overwritten: c, s = np.cos(turn), np.sin(turn) => c, s = np.cos(turn), np.sin(turn)
            + ahead = c * ahead + s * left
            c * ahead + s * left, -s * ahead + c * left => ahead, -s * ahead + c * left
            You replace `ahead` by its rotated value, and then you use the new value to rotate `left`. Compute both from the old values: give the rotated ones other names.
        Z at the end: - zx =>
            - zy =>
            (turn) =>> (theta2 - theta - turn)
            c * ahead + s * left, -s * ahead + c * left => ahead - c * zx + s * zy, left - s * zx - c * zy
            You compute inv(X_first) X_second inv(Z). In equation 9.3, inv(Z) is the first factor.
        turned by plus z: np.sin(turn) => np.sin(-turn)
            Your second rotation uses R_z instead of its transpose. inv(Z) rotates by minus the angle of z.
        z turned first: - zx =>
            - zy =>
            c * ahead + s * left, -s * ahead + c * left => c * ahead + s * left - zx, -s * ahead + c * left - zy
            You rotate by the angle of z before you subtract its x and y. They are in the frame of the first pose, so subtract them first.
        z subtracted twice: (y2 - y) - zx => (y2 - y) - 2 * zx
            (y2 - y) - zy => (y2 - y) - 2 * zy
            You subtract t_z twice, before the second rotation. Equation 9.4 subtracts it once. If you use landmark_residual: with z as its pose it subtracts t_z already, so give it zeros as its measurement in both calls.
        z subtracted again: c * ahead + s * left, -s * ahead + c * left => c * ahead + s * left - zx, -s * ahead + c * left - zy
            You subtract t_z again after the second rotation. Equation 9.4 subtracts it once, before it. If you use landmark_residual: with z as its pose it subtracts t_z already, so give it zeros as its measurement in both calls.
        z subtracted three times: (y2 - y) - zx => (y2 - y) - 2 * zx
            (y2 - y) - zy => (y2 - y) - 2 * zy
            c * ahead + s * left, -s * ahead + c * left => c * ahead + s * left - zx, -s * ahead + c * left - zy
            You subtract t_z three times, twice before the second rotation and once after it. Equation 9.4 subtracts it once. If you use landmark_residual: with z as its pose it subtracts t_z already, so give it zeros as its measurement in both calls.
        a pose for a landmark: + landmark_residual(first, second, z[..., :2])
            Your function fails even for one edge. landmark_residual expects a landmark (2,): if you give it a pose (3,), pass second[..., :2] and z[..., :2]. If you unpack poses, each has three numbers: x, y, theta = first.T.
        turned the wrong way: np.sin(theta) => np.sin(-theta)
            Your first rotation uses R instead of its transpose. To express the second pose in the frame of the first, rotate by minus the first heading, as in exercise 9.1.
        difference: c * ahead + s * left, -s * ahead + c * left => x2 - x - zx, y2 - y - zy
            You subtract x and y in the map frame. z is measured in the frame of the first pose, so rotate the difference into that frame first.
        plus z: theta - turn => theta + turn
            You add the angle of z, but it has to be subtracted: second - first - z.
        angle from the second to the first: theta2 - theta - turn => theta - theta2 - turn
            You subtract the headings in the wrong order. The third number is second - first - z.
        turned by the difference of the headings: (turn) =>> (theta2 - theta)
            Your second rotation uses the difference of the two headings. inv(Z) rotates by minus the angle of z, which was measured.
        angle without z: theta - turn => theta
            Your third number does not contain z. It is the turn of the robot minus the measured turn.
        sign: return np.array => return -np.array
            All signs are opposite. Equation 9.4 is the second pose as seen from the measured pose.
        z subtracted in the map frame: c * (x2 - x) + s * (y2 - y) - zx => c * (x2 - x - zx) + s * (y2 - y - zy)
            -s * (x2 - x) + c * (y2 - y) - zy => -s * (x2 - x - zx) + c * (y2 - y - zy)
            You subtract the x and y of z in the map frame, but they are in the frame of the first pose. Rotate t_j - t_i first, then subtract them.
        the first pose in the frame of the second: x, y, theta = first.T => x, y, theta = second.T
            x2, y2, theta2 = second.T => x2, y2, theta2 = first.T
            wrap_angle(theta2 - theta - turn) => wrap_angle(theta - theta2 - turn)
            Your x and y express the first pose in the frame of the second. z is the second pose in the frame of the first.
        a matrix for one edge, and not in z's frame: + c, s = np.cos(first[2]), np.sin(first[2])
            + x, y = np.array([[c, s], [-s, c]]) @ (second[:2] - first[:2]) - z[:2]
            + return np.array([x, y, wrap_angle(second[2] - first[2] - z[2])])
            You forgot R_zᵀ: rotate x and y by minus the angle of z. Besides, one matrix works for one edge only: write the rows as sums, with x, y, theta = first.T, and end with .T.
        order: + first, second = second, first
            You exchanged the two poses. z is the second pose in the frame of the first one.
        all wrapped: return np.array => return wrap_angle(np.array
            turn)]).T => turn)]).T)
            You wrap all three numbers. Only the third one is an angle; x and y are metres.
        one edge only: first.T => first
            second.T => second
            z.T => z
            turn)]).T => turn)])
            Your function is correct for one edge, but x, y, theta = first does not unpack E poses, because the rows of (E, 3) are poses. Write x, y, theta = first.T, the same for second and z, and end with .T.
        one edge only, and unwrapped: first.T => first
            second.T => second
            z.T => z
            wrap_angle(theta2 - theta - turn)]).T => theta2 - theta - turn])
            The angle is not wrapped: apply wrap_angle to the third number. Besides, x, y, theta = first does not unpack E poses: write first.T, second.T and z.T, and end with .T.
        one edge only, and not in z's frame: first.T => first
            second.T => second
            z.T => z
            c * ahead + s * left, -s * ahead + c * left => ahead, left
            ]).T => ])
            You forgot R_zᵀ: rotate x and y by minus the angle of z. Besides, x, y, theta = first does not unpack E poses: write first.T, second.T and z.T, and end with .T.
        one edge only, and turned the wrong way: first.T => first
            second.T => second
            z.T => z
            np.sin(theta) => np.sin(-theta)
            ]).T => ])
            Your first rotation uses R instead of its transpose. Besides, x, y, theta = first does not unpack E poses: write first.T, second.T and z.T, and end with .T.
        unpacked without .T, and not in z's frame: first.T => first
            second.T => second
            z.T => z
            c * ahead + s * left, -s * ahead + c * left => ahead, left
            You forgot R_zᵀ: rotate x and y by minus the angle of z. Besides, x, y, theta = first does not unpack E poses: write first.T, second.T and z.T; the .T at your end is right.
        unpacked without .T, and turned the wrong way: first.T => first
            second.T => second
            z.T => z
            np.sin(theta) => np.sin(-theta)
            Your first rotation uses R instead of its transpose. Besides, x, y, theta = first does not unpack E poses: write first.T, second.T and z.T; the .T at your end is right.
        unpacked without .T, and unwrapped: first.T => first
            second.T => second
            z.T => z
            wrap_angle(theta2 - theta - turn) => theta2 - theta - turn
            You did not wrap the angle: apply wrap_angle to the third number. Besides, x, y, theta = first does not unpack E poses: write first.T, second.T and z.T; the .T at your end is right.
        sliced like one edge: + lx, ly = second[:2].T
            Your function is correct for one edge. For E edges second[:2] is the first two poses, and a 3 by 3 matrix made of arrays is not E matrices. Use second[..., :2], or unpack x2, y2, theta2 = second.T, and write the rows of equation 9.4 as sums.
        unpacked without .T: first.T => first
            second.T => second
            z.T => z
            Your function is correct for one edge, but x, y, theta = first does not unpack E poses, because the rows of (E, 3) are poses. Unpack first.T, second.T and z.T; the .T at your end is right.
        numbered like one edge: first.T => first[0], first[1], first[2]
            second.T => second[0], second[1], second[2]
            z.T => z[0], z[1], z[2]
            Your function is correct for one edge. For E edges first[0] is the first of E poses and not the x of all poses. Unpack the transpose: x, y, theta = first.T.
        many edges only: first.T => first[:, 0], first[:, 1], first[:, 2]
            second.T => second[:, 0], second[:, 1], second[:, 2]
            z.T => z[:, 0], z[:, 1], z[:, 2]
            Your function is correct for E edges, but first[:, 0] does not work for one pose, whose shape is (3,). Unpack the transpose, which works for both: x, y, theta = first.T.
        three edges for one: first.T => first if len(first) == 3 else first.T
            second.T => second if len(second) == 3 else second.T
            z.T => z if len(z) == 3 else z.T
            return np.array => answer = np.array
            + return answer.T if first.shape == (3, 3) else answer
            Your function is correct except for three edges at once, because len(first) == 3 holds for one pose and for three poses. You need no distinction: first.T works for both.
        """),
        *_shaped("pose_residual", "first, second, z", "turn)]).T", "]).T => ])"),
    ],
    alternatives={
        "matrices": _pose,
        "complex numbers": _pose_complex,
        "edge by edge": _edge_by_edge(_pose, "d", "(k)"),
    },
)


# --- 9.4 pose_residual_jacobians ---
def _pose_jacobians_public() -> list[Case]:
    """Return cases without right angles, at which different slips would give the same Jacobians."""
    ends = [[1.0, 2.0, 1.1], [1.0, 4.0, 2.0], [1.5, 0.0, 0.7]]
    return [
        Case(tuple(map(np.array, ends)), "two steps where 1.5 were measured, then a turn"),
        *_pose_public()[1:],
    ]


POSE_RESIDUAL_JACOBIANS = Exercise(
    name="pose_residual_jacobians",
    points=3,
    stars=2,
    public=_pose_jacobians_public,
    hidden=_pose_hidden,
    comparison=Close(
        rtol=1e-6, atol=1e-7, names=("the Jacobian by the first pose", "the Jacobian by the second pose")
    ),
    hints=(
        "The two rotations together are one rotation by theta + the angle of z. With this angle, x and y are as in exercise 9.2, and the headings add a third row.",
        "The Jacobian by the second pose contains the rotation and a 1. The Jacobian by the first pose contains minus the rotation, a column of theta as in exercise 9.2, and a -1. The x and y of z appear in neither.",
    ),
    sibling=Sibling(
        "Two rotations in the plane are one rotation by the sum of the angles, so the derivatives with respect to both angles are equal: multiply by i, a quarter turn.",
        """
        import numpy as np

        point, a, b, h = 2 + 1j, 0.3, 0.5, 1e-6  # complex numbers as vectors


        def turned(a, b):
            return np.exp(1j * a) * (np.exp(1j * b) * point)


        by_b = (turned(a, b + h) - turned(a, b - h)) / (2 * h)
        print(np.round(1j * np.exp(1j * (a + b)) * point, 4), np.round(by_b, 4))
        """,
        "(-2.1314+0.6761j) (-2.1314+0.6761j)",
    ),
    mistakes=catalogue("""
        z's angle left out: theta + z.T[2] => theta
            You rotate by the heading of the first pose only. The residual is in the frame of the pose that z predicts, so the angle is theta plus the angle of z.
        only z's angle: theta + z.T[2] => z.T[2]
            You rotate by the angle of z only. The rotation from the map frame has the angle theta plus the angle of z.
        minus z's angle: theta + z.T[2] => theta - z.T[2]
            You subtract the angle of z. Two rotations in a row add up: theta plus the angle of z.
        sign: return by_first, matrices => return -by_first, -matrices
            All signs are opposite. If the second pose moves ahead, its x in the first pose's frame increases.
        theta forgotten: -s * dx + c * dy => 0
            -c * dx - s * dy => 0
            Your column of theta contains only the -1. If the first pose turns, the second one moves in its frame, so the first two rows are not 0.
        sign of theta: -s * dx + c * dy => s * dx - c * dy
            -c * dx - s * dy => c * dx + s * dy
            The column of theta has the opposite sign in its first two rows. If the first pose turns left, the second one moves to the right in its frame.
        theta from the residual: dx, dy = x2 - x, y2 - y => ahead, left, _ = pose_residual(first, second, z).T
            -s * dx + c * dy => left
            -c * dx - s * dy => -ahead
            Your column of theta contains the x and y of the residual. z does not depend on the first heading, so use the rotated vector to the second pose without subtracting z.
        theta from the unrotated z: dx, dy = x2 - x, y2 - y => dx, dy = x2 - x - z.T[0], y2 - y - z.T[1]
            Your column of theta contains the x and y of z. They are not rotated by the first heading, so they do not appear in the derivative: use t_j - t_i.
        plus 1: [0, 0, -1] => [0, 0, 1]
            If the first pose turns left, the measured turn to the second one decreases. Its derivative is -1, not 1.
        angle by theta forgotten: [0, 0, -1] => [0, 0, 0]
            The third row of your Jacobian by the first pose is 0, but the angle depends on the first heading.
        signs of both third rows: s * dy], [0, 0, -1]] => s * dy], [0, 0, 1]]
            c, 0], [0, 0, 1]] => c, 0], [0, 0, -1]]
            Both of your third rows have the wrong sign. The angle is second - first - z, so its derivative is -1 with respect to the first heading and 1 with respect to the second.
        both third rows zero: s * dy], [0, 0, -1]] => s * dy], [0, 0, 0]]
            c, 0], [0, 0, 1]] => c, 0], [0, 0, 0]]
            Both of your third rows are 0. The angle is second - first - z, so its derivative is -1 with respect to the first heading and 1 with respect to the second.
        two rows only: s * dy], [0, 0, -1]] => s * dy]]
            c, 0], [0, 0, 1]] => c, 0]]
            Your matrices have two rows. The residual of a pose has three numbers: add the row of the angle.
        the first has two rows: s * dy], [0, 0, -1]] => s * dy]]
            Your Jacobian by the first pose has two rows. The third row, of the angle, is missing.
        the second has two rows: c, 0], [0, 0, 1]] => c, 0]]
            Your Jacobian by the second pose has two rows. The third row, of the angle, is missing.
        as for a landmark: + return landmark_residual_jacobians(first + z * [0, 0, 1], second[..., :2], z[..., :2])
            Your rotation is correct, but your matrices are (2, 3) and (2, 2). The third row, of the angle, is missing in both, and the second one has no column of theta.
        as for a landmark, z's angle left out: + return landmark_residual_jacobians(first, second[..., :2], z[..., :2])
            Your matrices are (2, 3) and (2, 2). The third row, of the angle, is missing in both, and the second one has no column of theta. Besides, the rotation is by theta plus the angle of z.
        a pose for a landmark: + landmark_residual_jacobians(first, second, z)
            Your function fails even for one edge. landmark_residual_jacobians expects a landmark (2,): if you give it a pose (3,), pass second[..., :2]. If you unpack poses, each has three numbers: x, y, theta = first.T.
        the second heading: theta + z.T[2] => second.T[2]
            You rotate by the second heading. The residual is in the frame of the pose that z predicts, so the angle is theta plus the angle of z; with errors this is not the second heading.
        theta of the second: [[c, s, 0], [-s, c, 0], => [[c, s, s * dx - c * dy], [-s, c, c * dx + s * dy],
            A pose does not change its position when it turns. The column of theta in the Jacobian by the second pose contains only the 1 of the angle.
        the second without rotation: [[c, s, 0], [-s, c, 0], => [[c**0, 0, 0], [0, c**0, 0],
            Your Jacobian by the second pose is the unit matrix. That is correct only if the angle is 0, as in the example; otherwise its upper left block is the rotation.
        turned the wrong way: np.sin(angle) => np.sin(-angle)
            Your sines have the wrong signs. Rotate from the map frame into the frame of z, by minus the angle.
        order: return by_first, matrices => return (by_first, matrices
            0, 1]]) => 0, 1]]))[::-1]
            The order of your two matrices is wrong. Return the Jacobian by the first pose first and the Jacobian by the second pose second.
        transposed: return by_first => return by_first.mT
            0, 1]]) => 0, 1]]).mT
            Both matrices are transposed. The rows belong to the three numbers of the residual, and the columns to x, y and theta of a pose.
        one matrix: return by_first, matrices => return np.concatenate((by_first, matrices
            0, 1]]) => 0, 1]])), axis=-1)
            You return one matrix of shape (3, 6). Return two matrices of shape (3, 3).
        np.array for matrices, and z's angle left out: matrices( =>> np.array(
            theta + z.T[2] => theta
            You rotate by the heading of the first pose only: the angle is theta plus the angle of z. Besides, np.array cannot put the numbers and arrays of E edges into one matrix; matrices([[...], ...]) can.
        np.array for matrices: matrices( =>> np.array(
            Your matrices are correct for one edge. For E edges np.array cannot put numbers and arrays into one matrix; matrices([[...], ...]) can, and returns (E, 3, 3). Besides, second[:2] would be the first two of E poses; second.T[:2] has the x and y of all.
        one edge only: first.T => first
            second.T => second
            z.T[2] => z[2]
            Your function is correct for one edge, but x, y, theta = first does not unpack E poses. Write first.T, second.T and z.T, as in exercise 9.3.
        sign of the first matrix: return by_first => return -by_first
            Your Jacobian by the first pose has the opposite sign, and your Jacobian by the second pose is correct.
        sign of the second matrix: by_first, matrices => by_first, -matrices
            Your Jacobian by the first pose is correct, but your Jacobian by the second pose has the opposite sign. If the second pose moves ahead, its x in the first pose's frame increases.
        angle by the second theta forgotten: [0, 0, 1]] => [0, 0, 0]]
            The third row of your Jacobian by the second pose is 0, but the angle depends on the second heading, too.
        minus 1: [0, 0, 1]] => [0, 0, -1]]
            If the second pose turns left, the turn to it increases. Its derivative is 1, not -1.
    """),
    alternatives={
        "central differences": _differences(_pose),
        "edge by edge": _edge_by_edge(_pose_jacobians, "dd", "(k,i),(k,j)"),
        "products": _pose_jacobians,
    },
)


# --- 9.5 linearize ---
def _kinds(graph: Graph, states: Any) -> list[tuple[Any, Array, Array, Array]]:
    """Return the places (E, k), Jacobians, information and residuals of all edges, for each kind."""
    poses, landmarks = graph.split(states)
    kinds = []
    for edges, ends, residual, jacobians in (
        (graph.pose_edges, poses, _pose, _pose_jacobians),
        (graph.landmark_edges, landmarks, _landmark, _landmark_jacobians),
    ):
        pairs = poses[edges.first], ends[edges.second], edges.z
        J = np.concatenate(jacobians(*pairs), axis=-1)
        kinds.append((edges.places, J, edges.information, residual(*pairs)))
    return kinds


def _system(graph: Graph, states: Any) -> tuple[scipy.sparse.csc_array, Array]:
    """Compute H and b with np.add.at and a sparse matrix that adds repeated entries."""
    H, b = scipy.sparse.csc_array((graph.size, graph.size)), np.zeros(graph.size)
    for places, J, information, e in _kinds(graph, states):
        rows, columns = np.broadcast_arrays(places[:, :, None], places[:, None, :])
        at = rows.ravel(), columns.ravel()
        H += scipy.sparse.csc_array(((J.mT @ information @ J).ravel(), at), H.shape)
        np.add.at(b, places, np.einsum("kji,kjl,kl->ki", J, information, e))
    return H, b


def _edge_after_edge(graph: Graph, states: Any) -> Any:
    H, b = np.zeros((graph.size, graph.size)), np.zeros(graph.size)
    for kind in _kinds(graph, states):
        for places, J, information, e in zip(*kind, strict=True):
            H[np.ix_(places, places)] += J.T @ information @ J
            b[places] += J.T @ information @ e
    return scipy.sparse.csr_array(H), b


def _whole_jacobian(graph: Graph, states: Any) -> Any:
    """Compute H and b from one tall whitened Jacobian."""
    tall, right = [], []
    for kind in _kinds(graph, states):
        for places, J, information, e in zip(*kind, strict=True):
            root, rows = np.linalg.cholesky(information).T, np.zeros((len(e), graph.size))
            rows[:, places] = root @ J
            tall.append(scipy.sparse.csr_array(rows))
            right.append(root @ e)
    A = scipy.sparse.vstack(tall)
    return A.T @ A, A.T @ np.concatenate(right)


def _small_graph(rng: np.random.Generator, poses: int = 6, landmarks: int = 3) -> tuple[Graph, Array]:
    """Return a graph with full information matrices and edges in any order, and states that do not satisfy it."""
    edges = [(k, k + 1) for k in range(poses - 1)] + [(poses - 1, 0), (3, 1)]
    pairs = len(edges)
    if landmarks:
        edges += [(int(rng.integers(poses)), poses + k % landmarks) for k in range(2 * landmarks)]
    z = rng.normal(0.0, 1.0, (len(edges), 3))
    roots = rng.normal(0.0, 1.0, (len(edges), 3, 3)) + 2 * np.eye(3)
    information = roots @ roots.mT
    z[pairs:, 2] = information[pairs:, 2] = information[pairs:, :, 2] = 0
    order = rng.permutation(len(edges))
    kinds = np.repeat([POSE, LANDMARK], [poses, landmarks])
    states = rng.normal(0.0, 2.0, 3 * poses + 2 * landmarks)
    return Graph(np.array(edges)[order], z[order], information[order], kinds), states


def _two(rng: np.random.Generator) -> tuple[Graph, Array]:
    graph = Graph([[0, 1]], [[1.0, 0.0, 0.5]], [np.diag([4.0, 9.0, 16.0])], [POSE, POSE])
    return graph, rng.normal(0.0, 1.0, 6)


def _linearize_public() -> list[Case]:
    rng = np.random.default_rng(95)
    return [
        Case(_two(rng), "two poses and one edge"),
        Case(_small_graph(rng, 5, 0), "five poses, with two closures"),
        Case(_small_graph(rng), "poses and landmarks"),
    ]


def _linearize_hidden(rng: np.random.Generator) -> list[Case]:
    drive = field_drive(int(rng.integers(1000)), 12)
    return [
        Case(_two(rng)),
        *(Case(_small_graph(rng, poses, marks)) for poses, marks in ((4, 0), (5, 2), (9, 4))),
        Case((drive.graph, drive.odometry)),
    ]


RESIDUALS = ["pose_residual", "landmark_residual"]

LINEARIZE = Exercise(
    name="linearize",
    points=4,
    stars=3,
    public=_linearize_public,
    hidden=_linearize_hidden,
    comparison=Close(rtol=1e-6, atol=1e-6, names=("your H", "your b")),
    uses=[*RESIDUALS, "pose_residual_jacobians", "landmark_residual_jacobians"],
    hints=(
        "Compute for each kind of edges the residuals e, the Jacobians side by side as J, and then Jᵀ Omega J and Jᵀ Omega e for all edges at once with @. Then add them at their places.",
        "J.mT @ edges.information is Jᵀ Omega of all edges. Multiplied by J it gives the blocks, and graph.add_blocks adds these to a sparse matrix. For b, multiply by the residuals as columns, [:, :, None], and add with np.bincount over edges.places.",
    ),
    sibling=Sibling(
        "A spring has a small block and a share for each of its ends, as an edge has: all are computed at once, and np.bincount adds the shares at the numbers of the ends.",
        """
        import numpy as np

        ends = np.array([[0, 1], [1, 2], [0, 2]])  # three springs between three balls
        stiffness, x = np.array([2.0, 1.0, 4.0]), np.array([0.0, 1.0, 3.0])
        D = np.tile([[-1.0, 1.0]], (3, 1, 1))  # (springs, 1, 2): stretch = D x
        blocks = D.mT @ D * stiffness[:, None, None]
        forces = blocks @ x[ends][:, :, None]
        print(np.bincount(ends.ravel(), forces.ravel(), 3))
        K = np.zeros((3, 3))
        np.add.at(K, (ends[:, :, None], ends[:, None, :]), blocks)
        print(K @ x)
        """,
        """
        [-14.   0.  14.]
        [-14.   0.  14.]
        """,
    ),
    mistakes=catalogue("""
        sign of b: (*blocks), b => (*blocks), -b
            H is correct, but b has the opposite sign: b = Jᵀ Omega e. The minus is in the equation H delta = -b.
        covariance for information: edges.information => np.linalg.inv(edges.information)
            You use the inverse of the information, which is the covariance, so the least certain measurements get the largest weight. Use edges.information itself.
        no weights: J.mT @ edges.information => J.mT
            You compute JᵀJ and Jᵀe, so every measurement has the same weight. Multiply by Omega between the two factors.
        H without weights: blocks.append(weighted @ J) => blocks.append(J.mT @ J)
            b is correct, but H does not contain the information: H = Jᵀ Omega J.
        b without weights: shares = weighted => shares = J.mT
            H is correct, but b does not contain the information: b = Jᵀ Omega e.
        Jacobians exchanged: jacobians(*pairs) => jacobians(*pairs)[::-1]
            You exchanged the two Jacobians. The places of the first end come first, so the Jacobian by the first end does, too.
        blocks off the diagonal left out: blocks.append(weighted @ J) => first = np.arange(J.shape[2]) < 3
            + blocks.append(weighted @ J * (first[:, None] == first))
            Your H has no blocks that connect the two ends of an edge. These are J_iᵀ Omega J_j and its transpose.
        one triangle: blocks.append(weighted @ J) => first = np.arange(J.shape[2]) < 3
            + blocks.append(weighted @ J * (first[:, None] >= first))
            Your H is not symmetric, because the block at (second, first) is missing. It is the transpose of the block at (first, second).
        sign off the diagonal: blocks.append(weighted @ J) => first = np.arange(J.shape[2]) < 3
            + blocks.append(weighted @ J * np.where(first[:, None] == first, 1, -1))
            The blocks that connect two ends have the wrong sign. The signs are already in the Jacobians, so add Jᵀ Omega J without a change.
        assigned: blocks, b = [], => H, b = np.zeros((graph.size, graph.size)),
            blocks.append(weighted @ J) => H[edges.places[:, :, None], edges.places[:, None]] = weighted @ J
            b += np.bincount(edges.places.ravel(), shares.ravel(), graph.size) => b[edges.places] = shares[:, :, 0]
            graph.add_blocks(*blocks) => csc_array(H)
            You assign where you should add. A pose has several edges, and only the last one is left in your H and b.
        b assigned: b += np.bincount(edges.places.ravel(), shares.ravel(), graph.size) => b[edges.places] = shares[:, :, 0]
            H is correct, but in b you assign where you should add. Only the last edge of each pose is left.
        b of the last kind: b += => b =
            H is correct, but b contains only the edges to landmarks, because it starts anew for each kind of edge. Add the contributions: b += ...
        diagonal of the information: edges.information => (edges.information * np.eye(J.shape[1]))
            You use only the diagonal of the information. The other entries describe correlated errors and belong to the sum.
        += with repeated places: b += np.bincount(edges.places.ravel(), shares.ravel(), graph.size) => b[edges.places] += shares[:, :, 0]
            H is correct. But b[places] += contributions adds only once if an index occurs several times in `places`, as NumPy does for all such indexing. Use np.bincount or np.add.at.
        landmarks left out: edges.information => edges.information * (ends is poses)
            The edges to landmarks, graph.landmark_edges, are missing.
        twice: J.mT @ => 2 * J.mT @
            H and b are twice as large as they should be. The factor 2 of the derivative cancels in H delta = -b, so leave it out.
        b twice: shares = weighted => shares = 2 * weighted
            H is correct, but b is twice as large as it should be. The factor 2 of the derivative cancels in H delta = -b, so leave it out of both.
        first pose removed: graph.add_blocks(*blocks), b => graph.add_blocks(*blocks)[3:, 3:], b[3:]
            You removed the rows of the first pose. linearize returns all of them; gauss_newton will fix the first pose.
        first pose held: return graph.add_blocks(*blocks), b => H = graph.add_blocks(*blocks)
            + H[[0, 1, 2], [0, 1, 2]] += 1
            + return H, b
            You added something to the block of the first pose. linearize returns the sum over the edges and nothing else; gauss_newton will fix the first pose.
        first pose held by a large number: return graph.add_blocks(*blocks), b => H = graph.add_blocks(*blocks)
            + H[[0, 1, 2], [0, 1, 2]] += 1e6
            + return H, b
            You added a large number to the block of the first pose, as the constraint of lesson 08 did. linearize returns the sum over the edges and nothing else; gauss_newton will fix the first pose.
        residuals not as columns: residual(*pairs)[:, :, None] => residual(*pairs)
            Which line is it? In the line of b, e is (E, 3), but @ needs columns: e[..., None] is (E, 3, 1). In a line with J.T, write J.mT, because .T reverses all three axes. In a line of the residuals, the second end of an edge to a landmark is a row of `landmarks`, not of `poses`. The two Jacobians stand side by side along axis 2. np.bincount needs both arrays flat (.ravel()), and graph.size as its last argument.
        second ends of the first: ends[edges.second] => ends[edges.first]
            You take both ends of an edge from edges.first. The second end is ends[edges.second].
        b first: graph.add_blocks(*blocks), b => b, graph.add_blocks(*blocks)
            The order is wrong. Return H first and b second.
        b as a column: (*blocks), b => (*blocks), b[:, None]
            Your b is a column (n, 1). It should be flat, (n,).
    """),
    alternatives={
        "edge by edge": _edge_after_edge,
        "one tall Jacobian": _whole_jacobian,
        "np.add.at": _system,
    },
)


# --- 9.6 gauss_newton ---
def _squares(graph: Graph, states: Any) -> float:
    return float(graph.squared_errors(states, _pose, _landmark).sum())


def _steps(step: Callable[[Graph, Array], Array]) -> Callable[..., Any]:
    """Return a solver from a function that computes a step (n - 3,); the solver returns lists."""

    def function(graph: Graph, states: Any, iterations: int) -> Any:
        path = [np.array(states, dtype=float)]
        for _ in range(iterations):
            path.append(path[-1] + np.append(np.zeros(3), step(graph, path[-1])))
        return [path[-1], [_squares(graph, each) for each in path]]

    return function


def _step_anchored(graph: Graph, states: Array) -> Array:
    """Return a step in which added entries hold the first pose."""
    H, b = _system(graph, states)
    anchor = scipy.sparse.diags_array(np.where(np.arange(len(b)) < 3, 1.0, 0.0))
    return -scipy.sparse.linalg.spsolve((H + anchor).tocsc(), b)[3:]


def _step_cholesky(graph: Graph, states: Array) -> Array:
    H, b = _system(graph, states)
    L = np.linalg.cholesky(H.toarray()[3:, 3:])
    return -np.linalg.solve(L.T, np.linalg.solve(L, b[3:]))


def _step_wrapped(graph: Graph, states: Array) -> Array:
    """Return a step after which all headings are in (-pi, pi]."""
    H, b = _system(graph, states)
    there = states[3:] - scipy.sparse.linalg.splu(H.tocsc()[3:, 3:]).solve(b[3:])
    there[2 : 3 * graph.poses - 3 : 3] = wrap_angle(there[2 : 3 * graph.poses - 3 : 3])
    return there - states[3:]


def _turned(graph: Graph, states: Array) -> tuple[Graph, Array]:
    """Return a graph and its states, moved and turned as a whole, so that no residual changes."""
    poses, marks = (each.copy() for each in graph.split(states))
    turn = rotation_2d(2.5)
    poses[:, :2], marks = poses[:, :2] @ turn.T + (6.0, -4.5), marks @ turn.T + (6.0, -4.5)
    poses[:, 2] += 2.5
    return graph, np.concatenate([poses.ravel(), marks.ravel()])


def _weak_drift(drift: float) -> tuple[Graph, Array]:
    """Return a loop whose first step increases chi2, with an information so small that any damping is noticed."""
    world = drifting_loop(drift, 6)
    return dataclasses.replace(world.graph, information=1e-4 * world.graph.information), world.odometry


def _two_apart() -> tuple[Graph, Array]:
    graph = Graph([[0, 1]], [[1.0, 0.0, 0.0]], [np.eye(3)], [POSE, POSE])
    return graph, np.array([0.0, 0.0, 0.0, 5.0, 0.0, 0.0])


def _held_landmarks(drive: Any) -> Graph:
    """Return a field drive's graph with a weak measurement of each landmark from the first pose."""
    graph, count = drive.graph, drive.graph.landmarks
    edges = np.column_stack([np.zeros(count, dtype=int), graph.poses + np.arange(count)])
    z = np.column_stack([graph.split(drive.truth)[1] - drive.truth[:2], np.zeros(count)])
    weak = np.broadcast_to(np.diag([1e-2, 1e-2, 0.0]), (count, 3, 3))
    return dataclasses.replace(
        graph,
        edges=np.concatenate([graph.edges, edges]),
        measurements=np.concatenate([graph.measurements, z]),
        information=np.concatenate([graph.information, weak]),
    )


def _newton_public() -> list[Case]:
    square, drive = loop(3, side=2), field_drive(2, 8)
    return [
        Case((square.graph, square.odometry, 1), "a small loop, one step"),
        Case((*_turned(square.graph, square.odometry), 2), "the same loop, begun elsewhere, two steps"),
        Case((square.graph, square.odometry, 0), "no step"),
        Case((_held_landmarks(drive), drive.odometry, 4), "landmarks, four steps"),
        Case((*_weak_drift(np.pi / 2), 3), "weak measurements, and a step that climbs"),
        Case((*_two_apart(), 3), "two poses that fit after one step"),
    ]


def _newton_hidden(rng: np.random.Generator) -> list[Case]:
    walk = building(int(rng.integers(1000)), 60, size=(2, 2))
    square = loop(int(rng.integers(1000)), side=3)
    drive = field_drive(int(rng.integers(1000)), 14)
    return [
        Case((walk.graph, walk.odometry, 5)),
        Case((square.graph, disturbed(square, 0.3, 0.1, rng), 2)),
        Case((*_turned(square.graph, square.odometry), 3)),
        Case((_held_landmarks(drive), drive.odometry, 3)),
        Case((walk.graph, walk.odometry, 1)),
        Case((*_weak_drift(float(rng.uniform(1.4, 1.7))), 4)),
        Case((*_two_apart(), 4)),
    ]


GAUSS_NEWTON = Exercise(
    name="gauss_newton",
    points=4,
    stars=3,
    public=_newton_public,
    hidden=_newton_hidden,
    comparison=SolvedStates(),
    uses=["linearize", *RESIDUALS],
    hints=(
        "Copy the states. In each iteration linearise at the current states, remove the rows and columns of the first pose, solve as in lesson 08's solve_sparse, and move. The history begins with chi2 before the first step.",
        "Solve H[3:, 3:] x = b[3:] and subtract x from states[3:]. With free = graph.elimination_order, use H[free][:, free], b[free] and states[free] in the same way.",
    ),
    sibling=Sibling(
        "Each iteration computes residuals and derivatives at the current value, solves, and moves; the errors are stored before the first step and after each: here the rate of a decay.",
        """
        import numpy as np

        t, y = np.array([0.0, 1.0, 2.0, 3.0]), np.array([1.0, 0.61, 0.37, 0.22])
        rate = 0.1  # y = exp(-rate t) is expected
        errors = [np.sum((np.exp(-rate * t) - y) ** 2)]
        for _ in range(4):
            e, J = np.exp(-rate * t) - y, -t * np.exp(-rate * t)
            rate = rate - (J @ e) / (J @ J)
            errors.append(np.sum((np.exp(-rate * t) - y) ** 2))
        print(round(rate, 3), np.round(errors, 4))
        """,
        "0.499 [0.5595 0.0381 0.0006 0.     0.    ]",
    ),
    mistakes=catalogue("""
        uphill: -= splu => += splu
            You step uphill, because you add the solution of H x = b. The equation is H delta = -b: subtract the solution, or negate b.
        the step for the states: -= splu => = -splu
            You replace the states by the step. The step has to be added to the states: x becomes x + delta.
        chi2 of each edge: residual).sum()] => residual)]
            residual).sum()) => residual))
            Your history has one number for each edge. chi2 is their sum: add .sum().
        linearised once: H, b = linearize(graph, states) =>
            free = graph.elimination_order => free, (H, b) = graph.elimination_order, linearize(graph, states)
            You linearise once and solve the same system in each iteration. Call linearize with the current states inside the loop.
        H once: H, b = linearize(graph, states) => _, b = linearize(graph, states)
            free = graph.elimination_order => free, (H, _) = graph.elimination_order, linearize(graph, states)
            You recompute b in each iteration, but H only once. Both depend on the states, so call linearize inside the loop.
        NumPy's solve: splu(H[free][:, free], "NATURAL", **SYMMETRIC).solve(b[free]) => np.linalg.solve(H[free][:, free], b[free])
            np.linalg.solve does not accept a sparse matrix. Use splu(...).solve(...), as in lesson 08.
        all states moved: states[free] -= => states -=
            If splu asks for a square matrix: H[3:][3:] removes six rows and no columns. Write H[3:, 3:]. If shapes do not fit: the step has three numbers fewer than the states, because the first pose does not move. Add it to states[3:], or to states[free].
        the last pose left: free = graph.elimination_order => free = np.arange(3, graph.size)
            states[free] -= => states[:-3] -=
            You add the step to all but the last three numbers. The first pose is fixed, so it belongs to states[3:].
        order forgotten: states[free] -= => states[3:] -=
            You solve for states[free] but add the step to states[3:], which has another order. A step that was solved with b[free] belongs to states[free].
        never uphill: H, b = linearize(graph, states) => H, b = linearize(graph, before := states.copy())
            history.append(graph => history.append(graph
            + if history[-1] > history[-2]: states, history[-1] = before, history[-2]
            You refuse a step that increases chi2. This is good practice, but gauss_newton should take every step here, because you will study a step that increases chi2.
        stops early: states[free] -= splu => step = splu
            + if np.abs(step).max() < 1e-9: break
            + states[free] -= step
            You stop when the states no longer move. This is good practice, but gauss_newton should take all `iterations` steps, and its history should have a number for each.
        chi2 too early: np.array(history) => np.array(history[:1] + history[:-1])
            You compute chi2 before the states have moved, so your history contains the first number twice and lacks the last one. Append it after the step.
        nothing held: states[free] -= splu(H[free][:, free], "NATURAL", **SYMMETRIC).solve(b[free]) => states -= np.linalg.lstsq(H.toarray(), b)[0]
            Your first pose moves. H alone is singular, because the whole map can be shifted and turned. Solve without the three rows and columns of the first pose, and leave that pose unchanged.
        last pose held: graph.elimination_order => np.arange(graph.size - 3)
            You fix the last three numbers. Fix the first pose: solve for the rows and columns from 3 on.
        two of three held: graph.elimination_order => np.arange(2, graph.size)
            splu(H[free][:, free], "NATURAL", **SYMMETRIC).solve(b[free]) => np.linalg.lstsq(H[free][:, free].toarray(), b[free])[0]
            You fix two numbers of the first pose. It has three: x, y and the heading.
        one step: range(iterations) => range(min(iterations, 1))
            You take one step, whatever `iterations` is. Is there a return inside the loop?
        one step more: range(iterations) => range(iterations + 1)
            You take one step too many. The history has 1 + iterations numbers, and the first one belongs to the initial states.
        one step more, and chi2 before each: range(iterations) => range(iterations + 1)
            np.array(history) => np.array(history[:-1])
            You take one step too many, because you compute chi2 before each step. Compute the first chi2 before the loop, take `iterations` steps, and append chi2 after each step.
        damped: H, b = linearize(graph, states) => H, b = linearize(graph, states)
            + H += csc_array(np.diag(1e-3 * H.diagonal()))
            You add something to the diagonal of H. This is the idea of Levenberg and Marquardt, but gauss_newton should take the plain step here.
        composed: states[free] -= splu => step = splu
            + poses, delta = slice(0, 3 * graph.poses), np.zeros(graph.size)
            + delta[free] = step
            + x, y, theta = delta[poses][0::3], delta[poses][1::3], states[poses][2::3]
            + x[:], y[:] = np.cos(theta) * x - np.sin(theta) * y, np.sin(theta) * x + np.cos(theta) * y
            + states -= delta
            You rotate the step by the heading of each pose. The Jacobians are by x, y and theta in the map frame, so add the step directly.
        everything wrapped: return states => return wrap_angle(states)
            You wrap all states to (-pi, pi]. This changes x and y, too, which are metres.
        history without its begin: np.array(history) => np.array(history[1:])
            Your history lacks chi2 before the first step.
        history without its end: np.array(history) => np.array(history[:-1])
            Your history lacks chi2 after the last step.
        last chi2 only: np.array(history) => history[-1]
            Your states are correct. Return the whole history of chi2 with them: before the first step, and after each step.
        half chi2: np.array(history) => np.array(history) / 2
            Your chi2 is half as large as it should be. It is the sum of eᵀ Omega e, without the factor 1/2 of some books.
        chi2 without weights: + plain = replace(graph, information=np.sign(graph.information) * np.eye(3))
            graph.squared_errors =>> plain.squared_errors
            Your states are correct. But your chi2 is a sum of squares without the information; it should be the sum of eᵀ Omega e.
        history first: return states, np.array(history) => return np.array(history), states
            The order is wrong. Return the states first and the history second.
        no history: return states, np.array(history) => return states
            You return only the states. Return two things: the states and the history of chi2.
        in place: states = states.copy() =>
            You changed the states that were given to your function. Begin with a copy: states = states.copy().
    """),
    alternatives={
        "an anchor on the first pose": _steps(_step_anchored),
        "Cholesky": _steps(_step_cholesky),
        "headings wrapped": _steps(_step_wrapped),
    },
)


# --- 9.7 marginal_covariances ---
def _blocks_solved(H: Any, indices: Sequence[Any]) -> Any:
    """Solve for all columns of all blocks at once."""
    every = np.unique(np.concatenate(indices))
    unit = np.zeros((H.shape[0], len(every)))
    unit[every, np.arange(len(every))] = 1
    columns = scipy.sparse.linalg.splu(H.tocsc()).solve(unit)
    return [columns[np.ix_(each, np.searchsorted(every, each))] for each in indices]


def _blocks_eliminated(H: Any, indices: Sequence[Any]) -> Any:
    """Invert the remainder of lesson 08's marginalisation."""
    found, H = [], H.tocsr()
    for each in indices:
        gone = np.setdiff1d(np.arange(H.shape[0]), each)
        between = H[gone][:, each].toarray()
        share = scipy.sparse.linalg.splu(H[gone][:, gone].tocsc(), permc_spec="MMD_AT_PLUS_A").solve(between)
        found.append(np.linalg.inv(H[each][:, each].toarray() - between.T @ share))
    return found


def _blocks_one_by_one(H: Any, indices: Sequence[Any]) -> Any:
    solve, rows = scipy.sparse.linalg.factorized(H.tocsc()), np.arange(H.shape[0])
    return [np.array([solve(1.0 * (rows == row))[each] for row in each]) for each in indices]


def _information(graph: Graph, states: Array) -> scipy.sparse.csc_array:
    """Return H without the first pose."""
    return scipy.sparse.csc_array(_system(graph, states)[0][3:, 3:])


def _of_poses(numbers: Sequence[int]) -> list[Any]:
    """Return the rows of some poses in an H without the first pose."""
    return [3 * (number - 1) + np.arange(3) for number in numbers]


def _blocks_public() -> list[Case]:
    square, walk, drive = loop(1, side=2), building(4, 500), field_drive(3, 6)
    graph = _held_landmarks(drive)
    begin = 3 * graph.poses - 3
    two = scipy.sparse.csc_array([[2.0, -1.0], [-1.0, 1.0]])
    mixed = [begin + np.array([0, 1]), begin + np.array([7, 6]), np.array([4])]
    return [
        Case((two, [np.array([0]), np.array([1])]), "two variables"),
        Case(
            (
                _information(square.graph, square.truth),
                [*_of_poses([1, 4, 8]), np.concatenate(_of_poses([2, 7]))],
            ),
            "three poses of a loop, and a pair",
        ),
        Case((_information(graph, drive.truth), mixed), "landmarks, one of them with y before x, and one y"),
        Case((_information(walk.graph, walk.truth), _of_poses([250, 499])), "1,497 variables"),
    ]


def _blocks_hidden(rng: np.random.Generator) -> list[Case]:
    walk = building(int(rng.integers(1000)), 3000, size=(12, 12))
    square = loop(int(rng.integers(1000)), side=4)
    some = np.sort(rng.choice(np.arange(1, 3000), 12, replace=False)).tolist()
    mixed = [rng.permutation(45)[:6], rng.permutation(45)[:2], np.array([44])]
    return [
        Case((_information(walk.graph, walk.truth), _of_poses(some))),
        Case((_information(square.graph, square.truth), mixed)),
        Case((_information(square.graph, square.truth).tocsr(), _of_poses([1, 5, 16]))),
    ]


MARGINAL_COVARIANCES = Exercise(
    name="marginal_covariances",
    points=4,
    stars=3,
    public=_blocks_public,
    hidden=_blocks_hidden,
    comparison=Close(rtol=1e-7, atol=1e-11),
    driver=BLOCKS,
    hints=(
        "Column k of the inverse is the solution x of H x = e_k, where e_k is a unit vector. Which columns does a block need?",
        "Factorise H once with splu. For each block, solve for an (n, k) array of unit vectors, and keep the rows of the block from the result.",
    ),
    sibling=Sibling(
        "A column of an inverse is the solution for a unit vector, so some columns need no inverse: here the amounts that a factory makes to deliver one unit of product 1 or of product 3.",
        """
        import numpy as np

        uses = np.array([[0, 0.2, 0, 0.1], [0.3, 0, 0.1, 0], [0, 0.4, 0, 0], [0.1, 0, 0.2, 0]])
        wanted = [1, 3]
        orders = np.eye(4)[:, wanted]  # (4, 2), one unit vector for each product
        made = np.linalg.solve(np.eye(4) - uses, orders)
        print(made.round(3))
        print(np.allclose(made, np.linalg.inv(np.eye(4) - uses)[:, wanted]))
        """,
        """
        [[0.234 0.108]
         [1.115 0.034]
         [0.446 0.014]
         [0.113 1.014]]
        True
        """,
    ),
    mistakes=catalogue("""
        conditional: factor.solve(units)[index] => np.linalg.inv(H.tocsr()[index][:, index].toarray())
            You invert the block of H. This is the covariance if all other variables were known exactly, so it is too small. Take the block of the inverse of the whole matrix.
        information: factor.solve(units)[index] => H.tocsr()[index][:, index].toarray()
            You return blocks of H, which are information. Return blocks of its inverse.
        inverted once more: factor.solve(units)[index] => np.linalg.inv(factor.solve(units)[index])
            You invert the blocks of the inverse, as lesson 08's marginalize does. The covariance is the block itself.
        diagonal: factor.solve(units)[index] => np.diag(factor.solve(units)[index])
            You return only the variances. A block also contains the covariances, so its shape is (k, k).
        deviations: factor.solve(units)[index] => np.sqrt(np.abs(factor.solve(units)[index]))
            You take square roots. The entries of a covariance are in m^2 and rad^2.
        a single right side: np.zeros((H.shape[0], len(index))) => np.zeros(H.shape[0])
            units[index, np.arange(len(index))] => units[index]
            You solve for one vector with a 1 in every row of the block, which gives the sum of k columns of the inverse. Solve for k unit vectors, an array (n, k) with one 1 in each column.
        rows of ones: units[index, np.arange(len(index))] => units[index]
            units[index] = 1 sets whole rows, so each of your columns has k ones. A unit vector has one: set units[index, np.arange(len(index))].
        always the first rows: in indices: => in map(np.arange, map(len, indices)):
            You return the upper left corner of the inverse for every block. Use the rows given in `indices`.
        the first rows of the columns: (units)[index] => (units)[: len(index)]
            You solve for the right columns of the inverse but keep their first k rows. Keep the rows of the block: [index].
        rows in sequence: (units)[index] => (units)[index[0] : index[0] + len(index)]
            You keep k consecutive rows, beginning with the first index. The rows of a block may be anywhere and in any order: keep [index].
        whole columns: (units)[index] => (units)
            You return whole columns of the inverse. Keep only the rows of the block.
        sorted: in indices: => in map(np.sort, indices):
            You sort the indices. The rows and columns of a block must be in the given order.
        one matrix: in indices: => in [np.concatenate(indices)]:
            return blocks => return blocks[0]
            You return one matrix for all indices. Return a list with one block for each element of `indices`.
        first only: return blocks => return blocks[0]
            You return only the first block. Is there a return inside the loop?
        NumPy's inverse: + P = np.linalg.inv(H)
            + return [P[np.ix_(each, each)] for each in indices]
            np.linalg.inv does not accept a sparse matrix, and the whole inverse would be too large. Solve for the columns that a block needs, with splu.
        dense inverse: + P = np.linalg.inv(H.toarray())
            + return [P[np.ix_(each, each)] for each in indices]
            You make H dense, which takes 650 MB for 3,000 poses. Keep H sparse, because you only need a few columns of its inverse.
    """),
    alternatives={
        "all columns at once": _blocks_solved,
        "eliminating the others": _blocks_eliminated,
        "row by row": _blocks_one_by_one,
    },
)


# --- 9.8 reweight ---
def _reweighted_by_hand(graph: Graph, states: Any, width: float) -> Any:
    """Return a graph that is reweighted edge by edge."""
    information = graph.information.copy()
    for k, square in enumerate(graph.squared_errors(states, _pose, _landmark)):
        information[k] *= width**2 / (width**2 + square)
    return Graph(graph.edges, graph.measurements, information, graph.kinds, graph.ids)


def _reweighted_float32(graph: Graph, states: Any, width: float) -> Any:
    weights = 1 / (1 + graph.squared_errors(states, _pose, _landmark).astype(np.float32) / width**2)
    return dataclasses.replace(graph, information=(graph.information.T * weights).T)


def _reweighted_by_roots(graph: Graph, states: Any, width: float) -> Any:
    lengths = np.sqrt(graph.squared_errors(states, _pose, _landmark))
    roots = np.cos(np.arctan(lengths / width))[:, None, None]
    return dataclasses.replace(graph, information=roots * graph.information * roots)


def _reweight_public() -> list[Case]:
    rng = np.random.default_rng(98)
    square = with_false_closures(building(2, 40, size=(2, 2)), 0)
    return [
        Case((*_two(rng), 2.0), "one edge"),
        Case((square.graph, square.truth, 3.0), "the truth, where the weights are nearly 1"),
        Case((*_small_graph(rng), 5.0), "poses and landmarks that fit badly"),
        Case((*_small_graph(rng, 4, 1), 0.1), "a kernel so narrow that all weights are small"),
    ]


def _reweight_hidden(rng: np.random.Generator) -> list[Case]:
    walk = with_false_closures(building(int(rng.integers(1000)), 80), 3, 1)
    return [
        Case((*_small_graph(rng), 0.1)),
        Case((*_small_graph(rng, 5, 2), 8.0)),
        Case((walk.graph, walk.odometry, 3.0)),
        Case((walk.graph, walk.truth, float(rng.uniform(1, 4)))),
    ]


REWEIGHT = Exercise(
    name="reweight",
    points=2,
    stars=3,
    public=_reweight_public,
    hidden=_reweight_hidden,
    comparison=Close(rtol=1e-5, atol=1e-9),
    uses=RESIDUALS,
    hints=(
        "graph.squared_errors gives chi2 of every edge, (E,). The weight of each is equation 9.6; the information of each edge is multiplied by it.",
        "weights[:, None, None] multiplies (E, 3, 3) edge by edge; dataclasses.replace(graph, information=...) is the same graph with other information matrices.",
    ),
    sibling=Sibling(
        "Each value gets a weight that depends on its own error, and new axes let one weight for each item multiply a whole matrix.",
        """
        import numpy as np

        values = np.array([1.0, 1.2, 0.9, 9.0])
        weights = 1 / np.maximum(1, np.abs(values - 1.1) / 0.5)  # less than 1 beyond 0.5
        print(weights.round(3), round(np.average(values, weights=weights), 2), values.mean().round(2))
        pictures = np.ones((4, 2, 2))
        print((pictures * weights.reshape(-1, 1, 1))[:, 1, 1].round(3))
        """,
        """
        [1.    1.    1.    0.063] 1.2 3.02
        [1.    1.    1.    0.063]
        """,
    ),
    mistakes=catalogue("""
        functions exchanged: pose_residual, landmark_residual) => landmark_residual, pose_residual)
            You pass the two functions in the wrong order: squared_errors(states, pose_residual, landmark_residual).
        width not squared: width**2 => width
            You forgot to square the width: q is a squared error, so divide it by width^2.
        the kernel itself: 1 / (1 + squares / width**2) => width**2 * np.log1p(squares / width**2)
            You multiply by the kernel, c^2 ln(1 + q / c^2). The weight is its derivative rho'(q), equation 9.6.
        the kernel over q: 1 / (1 + squares / width**2) => np.log1p(squares / width**2) / (squares / width**2)
            You use the kernel divided by q as the weight. With it chi2 has the right value, but its derivative is wrong. The weight is rho'(q), equation 9.6.
        in place: return replace(graph, information=graph.information * weights[:, None, None]) => graph.information[:] *= weights[:, None, None]
            + return graph
            You change the graph that was given to your function, so the next call would reweight it again. Make a new array with graph.information * weights and a new graph with replace(graph, information=...).
        assigned
            return replace(graph, information=graph.information * weights[:, None, None]) => graph.information = graph.information * weights[:, None, None]
            + return graph
            You assign to an attribute of the graph, which is not possible. replace(graph, information=...) returns a copy with other information matrices.
        square of the ratio: squares / width**2 => (squares / width) ** 2
            You square q / c. q is a squared error already, so only the width is squared: q / c^2.
        root of the weight: 1 / (1 + squares / width**2) => 1 / np.sqrt(1 + squares / width**2)
            You return the square root of the weight, by which a residual would be multiplied. The information is multiplied by the weight itself.
        width left out: squares / width**2 => squares
            You forgot the width: divide the squared error by width^2.
        the other way round: 1 / (1 + squares / width**2) => 1 + squares / width**2
            Your weights increase with the error, so the worst edges get the largest weight. Use the reciprocal.
        square: (1 + squares / width**2) => (1 + squares / width**2) ** 2
            Your weight is squared. This is the kernel of Geman and McClure, which is also used in practice; return Cauchy's weight, equation 9.6.
        cut off: 1 / (1 + squares / width**2) => np.where(squares > width**2, 0, 1)
            You remove edges whose error is larger than the width. Cauchy's kernel only reduces their weight, so that they can recover if they fit later.
        small weights removed: weights = 1 / (1 + squares / width**2) => weights = 1 / (1 + squares / width**2)
            + weights[weights < 1e-3] = 0
            You set small weights to 0. Cauchy's weight never becomes 0, so an edge can recover if it fits later. Return it as it is.
        Huber: 1 / (1 + squares / width**2) => np.minimum(1, width / np.sqrt(squares))
            This is Huber's kernel, with which a false closure keeps a constant pull. Return Cauchy's weight, equation 9.6.
        the error, not its square: squares / width**2 => np.sqrt(squares) / width
            You divide the root of the squared error by the width. Equation 9.6 has the squared error divided by width^2.
        closures only: 1 / (1 + squares / width**2) => np.where(graph.edges[:, 1] == graph.edges[:, 0] + 1, 1, 1 / (1 + squares / width**2))
            You leave the odometry's edges unchanged. This is a sensible idea, but reweight should treat all edges in the same way.
        one weight for all: pose_residual, landmark_residual) => pose_residual, landmark_residual).sum(keepdims=True)
            You use one weight for all edges, computed from the sum of all squared errors. Each edge has a weight of its own.
        without information: graph.squared_errors => replace(graph, information=np.sign(graph.information) * np.eye(3)).squared_errors
            You use the squared length of the residual without its information. The squared error is eᵀ Omega e.
        the 1 left out: 1 / (1 + squares / width**2) => width**2 / squares
            Your weight is c^2 / q. The 1 is missing: with 1 / (1 + q / c^2) an edge that fits well keeps its weight.
        without information, poses only: + poses, at = graph.split(states)[0], graph.pose_edges
            + squares = (pose_residual(poses[at.first], poses[at.second], at.z) ** 2).sum(axis=1)
            + return replace(graph, information=graph.information / (1 + squares / width**2)[:, None, None])
            You compute eᵀ e, and only for edges between poses. The squared error is eᵀ Omega e; graph.squared_errors returns it for all edges.
        poses only: + poses, at = graph.split(states)[0], graph.pose_edges
            + e = pose_residual(poses[at.first], poses[at.second], at.z)[:, :, None]
            + squares = (e.mT @ at.information @ e)[:, 0, 0]
            + return replace(graph, information=graph.information / (1 + squares / width**2)[:, None, None])
            Your function is correct for edges between poses, but a graph may have landmarks, too. graph.squared_errors returns eᵀ Omega e of all edges.
        information only: replace(graph, information=graph.information * weights[:, None, None]) => graph.information * weights[:, None, None]
            You return the information matrices. Return a graph that has them: replace(graph, information=...).
        weights only: replace(graph, information=graph.information * weights[:, None, None]) => weights
            You return the weights. Return a graph whose information is multiplied by them.
        weights without axes: weights[:, None, None] => weights
            Your weights are (E,) and the information is (E, 3, 3), so they do not fit together. weights[:, None, None] is (E, 1, 1) and multiplies each edge's matrix by its own weight.
        measurements weighted: information=graph.information * weights[:, None, None] => measurements=graph.measurements * weights[:, None]
            You multiply the measurements, so a metre becomes half a metre. Multiply the information.
        information lost: graph.information * weights => np.eye(3) * weights
            You replace the information by the weights. Multiply the two, so that precise measurements keep more weight than others.
    """),
    alternatives={
        "edge by edge": _reweighted_by_hand,
        "float32": _reweighted_float32,
        "roots, as cosines": _reweighted_by_roots,
    },
)


PLAN = LessonPlan(
    exercises=[
        LANDMARK_RESIDUAL,
        LANDMARK_RESIDUAL_JACOBIANS,
        POSE_RESIDUAL,
        POSE_RESIDUAL_JACOBIANS,
        LINEARIZE,
        GAUSS_NEWTON,
        MARGINAL_COVARIANCES,
        REWEIGHT,
    ],
    questions=[
        Question(
            "which_frame",
            "You shift a whole map by 5 m and turn it by 30 degrees: all poses and all landmarks together. Which residuals change?",
            {
                "All of them, because all poses have changed.": "The poses have changed, but a residual depends only on one pose as seen from another, and that is as before.",
                "Only the residuals of the first pose, because it is fixed.": "An edge of the first pose also contains only the position of the other end as seen from it.",
                "None.": "Right: each residual is expressed in a frame that moves with the map. So no measurement determines where the map is, and something must fix it.",
            },
            "None.",
        ),
        Question(
            "conditional",
            "You invert the 3 by 3 block of H that belongs to a pose. What do you get?",
            {
                "The covariance of that pose.": "The covariance is a block of the inverse. The inverse of a block is a different matrix.",
                "The covariance that it would have if all other poses were known exactly.": "Right: the block contains only the pose's own edges, so its inverse is smaller than the pose's covariance.",
                "Nothing that has a meaning.": "It has a meaning: it is the uncertainty that remains if all other poses are known exactly. But in a map they are not.",
            },
            "The covariance that it would have if all other poses were known exactly.",
        ),
    ],
    written=[
        Written(
            "explain_headings",
            points=2,
            question="Why do wrong headings in the initial estimate make Gauss-Newton fail, while wrong positions do not?",
            rubric="1 point: for given headings the residuals are linear in the positions (x and y are only subtracted and rotated by fixed angles), so one step finds the right positions from any initial estimate. 1 point: headings appear in sines and cosines. A linearisation approximates an arc only for a small angle, so from far away a step leads to a wrong place, and the steps can end in a local minimum or in none.",
        )
    ],
)
