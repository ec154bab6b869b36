"""Declare the exercises of lesson 07, EKF SLAM, with common mistakes and correct alternatives."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag, expm
from scipy.spatial.distance import mahalanobis

from nao_course.exercises import (
    All,
    Case,
    Close,
    Each,
    Exact,
    Exercise,
    LessonPlan,
    Mistake,
    Property,
    Question,
    Sibling,
    Written,
)
from nao_course.geometry import Pose, rotation_2d, wrap_angle
from nao_course.instructor.authoring.mistakes import catalogue
from nao_course.lessons.ekf_slam.evaluation import personal_numbers
from nao_course.lessons.ekf_slam.filters.repeated_updates import stays_symmetric
from nao_course.lessons.ekf_slam.noise import in_one_turn, joint_noise
from nao_course.lessons.ekf_slam.rotation import keeps_rotation, rotation_direction

Array = npt.NDArray[Any]
TURN = 2 * np.pi
STATE = ("the state", "the covariance")


# --- shared by several exercises ---
def expected(pose: Any, landmark: Any) -> Array:
    """Return the expected bearing and range (2,) of a landmark."""
    dx, dy = landmark[0] - pose[0], landmark[1] - pose[1]
    return np.array([wrap_angle(np.arctan2(dy, dx) - pose[2]), np.hypot(dx, dy)])


def measurement_jacobians(pose: Any, landmark: Any) -> tuple[Array, Array]:
    """Return the Jacobians of bearing and range with respect to the pose (2, 3) and the landmark (2, 2)."""
    dx, dy = landmark - pose[:2]
    r = np.hypot(dx, dy)
    by_landmark = np.array([[-dy / r**2, dx / r**2], [dx / r, dy / r]])
    return np.column_stack([-by_landmark, [-1.0, 0.0]]), by_landmark


def motion_model_jacobians(pose: Any, control: Any) -> tuple[Array, Array]:
    """Return F (3, 3), with respect to the pose, and G (3, 3), with respect to the errors along, across and of the turn."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    F, G = np.eye(3), np.eye(3)
    F[:2, 2] = -control[0] * s, control[0] * c
    G[:2, :2] = [[c, -s], [s, c]]
    return F, G


def landmark_place(pose: Any, measurement: Any) -> tuple[Array, Array, Array]:
    """Return a landmark's position (2,) and its Jacobians with respect to pose (2, 3) and measurement (2, 2)."""
    bearing, r = measurement
    c, s = np.cos(pose[2] + bearing), np.sin(pose[2] + bearing)
    by_pose = np.array([[1.0, 0.0, -r * s], [0.0, 1.0, r * c]])
    return np.array([pose[0] + r * c, pose[1] + r * s]), by_pose, np.array([[-r * s, c], [r * c, s]])


def random_covariance(rng: np.random.Generator, size: int, *, scale: float = 0.2) -> Array:
    """Return a random full covariance (size, size) with standard deviations around `scale`."""
    root = rng.normal(0.0, 0.35, (size, size)) + np.eye(size) * rng.uniform(0.6, 1.2, size)
    return scale**2 * (root @ root.T)


def noise(rng: np.random.Generator, k: int, form: str) -> Array:
    """Return R in one of its three forms: "each" (2, 2), "own" (k, 2, 2) or "joint" (2k, 2k)."""
    if form == "own":
        return np.array([random_covariance(rng, 2, scale=0.06) for _ in range(k)])
    return (
        random_covariance(rng, 2, scale=0.06) if form == "each" else random_covariance(rng, 2 * k, scale=0.07)
    )


def shifted(state: Array, shift: Any) -> Array:
    """Return a state with a shift added and its heading wrapped."""
    new = state + shift
    new[2] = wrap_angle(new[2])
    return np.asarray(new)


def by_differences(function: Callable[[Array], Array], at: Array) -> Array:
    """Return the Jacobian of a function by central differences."""
    return np.column_stack([(function(at + e) - function(at - e)) / 2e-6 for e in 1e-6 * np.eye(len(at))])


def around(rng: np.random.Generator, pose: Array, k: int) -> Array:
    """Return k landmarks (k, 2) in all directions, 0.8 to 4 m from a pose."""
    r, direction = rng.uniform(0.8, 4, k), rng.uniform(-np.pi, np.pi, k)
    return pose[:2] + np.column_stack([r * np.cos(direction), r * np.sin(direction)])


def random_pose(rng: np.random.Generator) -> Array:
    """Return a pose (3,) within some metres of the origin."""
    return np.array([*rng.uniform(-3, 3, 2), rng.uniform(-3, 3)])


# --- 7.1 warp2pi ---


def _angles_public() -> list[Case]:
    return [
        Case((3.5,), "one angle, a little more than half a turn"),
        Case((-4.0,), "one angle to the right"),
        Case((0.3,), "an angle within the range already"),
        Case((np.array([0.5, 7.0, -7.0, 3.2]),), "four angles"),
        Case((np.array([20.0, -20.0, 200.0]),), "several turns"),
        Case((np.array([[1.0, 4.0], [-2.0, -5.0]]),), "a (2, 2) array of angles"),
    ]


def _angles_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        *(Case((float(angle),)) for angle in rng.uniform(-9, 9, 3)),
        Case((rng.uniform(3.3, 4.3) * rng.choice([-1.0, 1.0], 6),)),
        Case((rng.uniform(-40, 40, 5),)),
        Case((rng.uniform(-12, 12, (2, 3)),)),
    ]


WARP2PI = Exercise(
    name="warp2pi",
    points=1,
    public=_angles_public,
    hidden=_angles_hidden,
    comparison=All((Property(in_one_turn), Close(atol=1e-8, period=TURN))),
    hints=(
        "Remove all whole turns from the angle. The operator % returns the remainder, also for arrays, from 0 to a full turn.",
        "Add half a turn before you apply %, and subtract it afterwards.",
    ),
    sibling=Sibling(
        "A remainder begins at 0, so add half of the circle before you take it and subtract it again afterwards: here a tone's distance in semitones, from -6 to 5.",
        """
        import numpy as np

        semitones = np.array([7, -7, 12, 30])
        print(semitones % 12)
        print((semitones + 6) % 12 - 6)
        """,
        """
        [7 5 0 6]
        [-5  5  0 -6]
        """,
    ),
    mistakes=catalogue("""
        unchanged: + return np.asarray(angle)[()]
            Angles on both sides are still outside the range, so whole turns are left in them. Add pi, take the remainder with %, and subtract pi.
        0 to a full turn: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => np.asarray(angle) % (2 * np.pi)
            Your function leaves angles above pi, as if the range were 0 to 2 pi. Add pi before you take the remainder, and subtract it afterwards.
        one turn only: + angle = np.array(angle, dtype=float)
            + angle = np.where(angle > np.pi, angle - 2 * np.pi, angle)
            + return np.where(angle < -np.pi, angle + 2 * np.pi, angle)[()]
            Your function removes too few turns. 200 rad contain 32 turns, so remove as many as there are: the operator % does this in one step.
        degrees: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => (np.asarray(angle) + 180.0) % 360.0 - 180.0
            You wrap at 180, but the angles are in radians. Half a turn is np.pi.
        half turns: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => (np.asarray(angle) + np.pi / 2) % np.pi - np.pi / 2
            You remove half turns, so ahead and behind become the same angle. A whole turn is 2 pi.
        half turns, shifted: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => (np.asarray(angle) + np.pi) % np.pi - np.pi
            You take the remainder of a half turn. A whole turn is 2 pi, so use % (2 * np.pi).
        sign lost: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => np.arccos(np.cos(angle))
            Your angles are never negative, because arccos returns angles from 0 to pi only. Use np.arctan2(np.sin(angle), np.cos(angle)), or the operator %.
        3.14 for pi: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => (np.asarray(angle) + 3.14) % 6.28 - 3.14
            3.14 is too coarse for pi, and the error grows with each turn. Use np.pi.
        shift kept: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => (np.asarray(angle) + np.pi) % (2 * np.pi)
            You add pi but do not subtract it again, so straight ahead becomes half a turn.
        pi not added: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => np.asarray(angle) % (2 * np.pi) - np.pi
            You subtract pi but do not add it first, so every angle is off by half a turn. Add pi before you take the remainder.
        cut off: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => np.clip(angle, -np.pi, np.pi)
            You cut angles off at pi. An angle of 3.5 is the same direction as 3.5 - 2 pi, so remove whole turns instead.
        math for one number: + angle = float(angle)
            Your function works for one angle but raises for an array, because `float` and the functions of `math` accept a single number only. Use NumPy's functions, or the operator %.
        sine first: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => np.arctan2(np.cos(angle), np.sin(angle))
            You swap the arguments of arctan2. Its first argument is the sine: np.arctan2(np.sin(angle), np.cos(angle)).
        C's remainder: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => np.fmod(np.asarray(angle) + np.pi, 2 * np.pi) - np.pi
            Your function leaves angles below -pi. np.fmod keeps the sign of its first argument, and np.where(angle > np.pi, ...) changes only angles above pi. Use % or np.mod.
        rank of the operators: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => (np.asarray(angle) + np.pi) % 2 * np.pi - np.pi
            % and * have the same rank and are applied from left to right. Write % (2 * np.pi), in brackets.
        remainder of pi: (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi => np.asarray(angle) % np.pi
            Ahead and behind become the same angle. A whole turn is 2 pi: add pi, take % (2 * np.pi), and subtract pi.
        elements of a number: + if np.ndim(angle) == 0:
            +     raise TypeError
            A single number has no elements and no length, so your function works only for arrays. The operator % works for both.
        elements of a number, one turn: + if np.ndim(angle) == 0:
            +     raise TypeError
            + angle = np.where(angle > np.pi, angle - 2 * np.pi, angle)
            + return np.where(angle < -np.pi, angle + 2 * np.pi, angle)
            A single number has no elements, so your function works only for arrays, and it removes one turn at most. The operator % works for both and removes all turns.
        elements of a number, one side: + if np.ndim(angle) == 0:
            +     raise TypeError
            + return np.where(angle > np.pi, angle - 2 * np.pi, angle)
            A single number has no elements, so your function works only for arrays, and it leaves angles below -pi. The operator % works for both and on both sides.
        one side of one angle: + if np.ndim(angle):
            +     return (angle > np.pi) and angle
            + return angle - 2 * np.pi if angle > np.pi else angle
            Your function leaves angles below -pi, and it raises for an array, because `if` needs a single True or False. The operator % works on both sides and on each element.
        one angle only: + if np.ndim(angle):
            +     return (angle > np.pi) and angle
            Your function works for one angle but raises for an array, because `if` and `while` need a single True or False. The operator % works on each element.
    """),
    alternatives={
        "sine and cosine": lambda angle: np.arctan2(np.sin(angle), np.cos(angle)),
        "complex numbers": lambda angle: np.angle(np.exp(1j * np.asarray(angle))),
        "the library's": wrap_angle,
    },
    equivalents={
        "return (np.asarray(angle) - np.pi) % (2 * np.pi) - np.pi": "it differs by a full turn, which the remainder removes",
        "return (angle + np.pi) % (2 * np.pi) - np.pi": "both numbers and arrays support the addition",
    },
)


# --- 7.2 init_landmarks ---
def _initial_by_landmark(z: Array, R: Array, pose: Array, P: Array) -> Any:
    """Transform positions with `Pose` and rotate the covariances block by block."""
    k, R = len(z) // 2, joint_noise(R, len(z) // 2)
    in_robot = np.column_stack([z[1::2] * np.cos(z[::2]), z[1::2] * np.sin(z[::2])])
    J = [rotation_2d(pose[2] + z[i]) @ [[0, 1], [z[i + 1], 0]] for i in range(0, 2 * k, 2)]
    blocks = [[J[i] @ R[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] @ J[j].T for j in range(k)] for i in range(k)]
    return [k, Pose(*pose).to_parent(in_robot).ravel(), np.block(blocks)]


def _initial_by_differences(z: Array, R: Array, pose: Array, P: Array) -> Any:
    def places(flat: Array) -> Array:
        return np.concatenate([landmark_place(pose, pair)[0] for pair in flat.reshape(-1, 2)])

    G = by_differences(places, z)
    return len(z) // 2, places(z), G @ joint_noise(R, len(z) // 2) @ G.T


def _initial_by_roots(z: Array, R: Array, pose: Array, P: Array) -> Any:
    positions, _, by_z = zip(*(landmark_place(pose, pair) for pair in z.reshape(-1, 2)), strict=True)
    half = block_diag(*by_z) @ np.linalg.cholesky(joint_noise(R, len(by_z)))
    return len(by_z), np.concatenate(positions), half @ half.T


def _first_measurement_case(
    rng: np.random.Generator, k: int, form: str, name: str = "", pose: Any = None
) -> Case:
    z = np.column_stack([rng.uniform(-3, 3, k), rng.uniform(0.6, 5, k)]).ravel()
    at = random_pose(rng) if pose is None else np.array(pose, dtype=float)
    return Case((z, noise(rng, k, form), at, random_covariance(rng, 3, scale=0.1)), name)


def _first_measurement_public() -> list[Case]:
    rng = np.random.default_rng(72)
    R, P = np.diag([0.0004, 0.01]), np.diag([0.0004, 0.0004, 0.01])
    return [
        Case((np.array([0.0, 2.0, 1.2, 3.0]), R, np.zeros(3), P), "two landmarks, seen from the origin"),
        _first_measurement_case(rng, 1, "each", "one landmark", (1.0, 2.0, 0.7)),
        _first_measurement_case(rng, 3, "own", "three landmarks, each with its own R", (1.0, -2.0, 2.0)),
        _first_measurement_case(
            rng, 2, "joint", "two landmarks with correlated noise: R is (4, 4)", (-1.0, 0.5, -1.1)
        ),
        _first_measurement_case(rng, 8, "each", "eight landmarks", (0.5, 1.0, 0.4)),
    ]


def _first_measurement_hidden(rng: np.random.Generator) -> list[Case]:
    sizes = ((1, "each"), (2, "each"), (4, "own"), (3, "joint"), (9, "each"))
    return [_first_measurement_case(rng, k, form) for k, form in sizes]


INIT_LANDMARKS = Exercise(
    name="init_landmarks",
    points=2,
    uses=("05:landmark_position", "05:landmark_jacobians"),
    public=_first_measurement_public,
    hidden=_first_measurement_hidden,
    comparison=Each(
        (Exact(), Close(atol=1e-8), Close(atol=1e-8)), names=("k", "the landmark vector", "the covariance")
    ),
    hints=(
        "k is half the number of values. Landmark i has measurements[2 * i : 2 * i + 2], and its position has the same indices in the result.",
        "Start with a (2k, 2k) matrix of zeros and put the second matrix of landmark_jacobians for each landmark on its diagonal. Then one product is enough: blocks @ joint_noise(measurement_covariance, k) @ blocks.T.",
    ),
    sibling=Sibling(
        "Each item has its own block of the large matrix: item i has the rows from 2 i and the columns from 3 i, and one product with the whole matrix converts all covariances.",
        """
        import numpy as np

        boxes = np.array([[2.0, 3.0, 4.0], [1.0, 1.0, 5.0]])  # length, width, height
        J = np.zeros((4, 6))
        for i, (a, b, c) in enumerate(boxes):
            floor, volume = [b, a, 0], [b * c, a * c, a * b]  # derivatives of a b and of a b c
            J[2 * i : 2 * i + 2, 3 * i : 3 * i + 3] = [floor, volume]
        sigmas = np.tile([0.1, 0.1, 0.2], 2)
        print((J @ np.diag(sigmas**2) @ J.T).round(2))
        """,
        """
        [[0.13 0.52 0.   0.  ]
         [0.52 3.52 0.   0.  ]
         [0.   0.   0.02 0.1 ]
         [0.   0.   0.1  0.54]]
        """,
    ),
    mistakes=catalogue("""
        how many numbers: return k, => return 2 * k,
            Your k is the number of values. Each landmark has two, a bearing and a range, so k is half of it.
        raw R: jacobian @ joint_noise(measurement_covariance, k) @ jacobian.T => joint_noise(measurement_covariance, k)
            You return R, the covariance of bearing and range in rad^2 and m^2. The result must be the covariance of x and y: multiply R by J_z from the left and J_zᵀ from the right.
        Jacobian transposed: jacobian @ joint_noise(measurement_covariance, k) @ jacobian.T => jacobian.T @ joint_noise(measurement_covariance, k) @ jacobian
            You compute Jᵀ R J. The columns of J belong to bearing and range, so the product is J R Jᵀ.
        columns of J_z exchanged: landmark_jacobians(pose, measurements[i : i + 2])[1] => landmark_jacobians(pose, measurements[i : i + 2])[1][:, ::-1]
            The columns of your J_z are exchanged. The first column belongs to the bearing and the second to the range, in the order of the measurements, and landmark_jacobians returns J_z in this order.
        rows of J_z exchanged: landmark_jacobians(pose, measurements[i : i + 2])[1] => landmark_jacobians(pose, measurements[i : i + 2])[1][::-1]
            The rows of your J_z are exchanged. The first row belongs to x and the second to y, in the order of the landmarks.
        last factor not transposed: joint_noise(measurement_covariance, k) @ jacobian.T => joint_noise(measurement_covariance, k) @ jacobian
            You compute J R J. The last factor is Jᵀ: J R Jᵀ.
        last factor not transposed, block by block: jacobian @ joint_noise(measurement_covariance, k) @ jacobian.T => jacobian @ (joint_noise(measurement_covariance, k) * np.kron(np.eye(k), np.ones((2, 2)))) @ jacobian
            You compute J R J. The last factor is Jᵀ: J R Jᵀ. And if R is (2k, 2k), its blocks between different landmarks count, too.
        last factor not transposed, R as given: + if np.shape(measurement_covariance) != (2, 2):
            +     raise ValueError
            jacobian @ joint_noise(measurement_covariance, k) @ jacobian.T => jacobian @ np.kron(np.eye(k), measurement_covariance) @ jacobian
            You compute J R J. The last factor is Jᵀ: J R Jᵀ. And a single (2, 2) matrix is not enough for the other two forms of R: use joint_noise(measurement_covariance, k).
        one side only: jacobian @ joint_noise(measurement_covariance, k) @ jacobian.T => jacobian @ joint_noise(measurement_covariance, k)
            You compute J R, which is not symmetric. A covariance is multiplied from both sides: J R Jᵀ.
        the first one's Jacobian: landmark_jacobians(pose, measurements[i : i + 2]) => landmark_jacobians(pose, measurements[:2])
            You use the Jacobian of the first landmark for all landmarks. Compute it for each landmark from its own bearing and range.
        the pose's part, too
            return k, landmarks, jacobian @ joint_noise(measurement_covariance, k) @ jacobian.T => J = np.vstack([landmark_jacobians(pose, pair)[0] for pair in np.reshape(measurements, (k, 2))])
            + return k, landmarks, jacobian @ joint_noise(measurement_covariance, k) @ jacobian.T + J @ pose_covariance @ J.T
            You include the uncertainty of the pose, which is correct in general and the topic of exercise 7.7. Here you implement the homework's version: J_z R J_zᵀ alone.
        the pose's part in each block
            jacobian[i : i + 2, i : i + 2] = landmark_jacobians(pose, measurements[i : i + 2])[1] => J, jacobian[i : i + 2, i : i + 2] = landmark_jacobians(pose, measurements[i : i + 2])
            + added[i : i + 2, i : i + 2] = J @ pose_covariance @ J.T
            landmarks, jacobian = np.zeros(2 * k), np.zeros((2 * k, 2 * k)) => landmarks, jacobian, added = np.zeros(2 * k), np.zeros((2 * k, 2 * k)), np.zeros((2 * k, 2 * k))
            @ jacobian.T => @ jacobian.T + added
            You add the uncertainty of the pose to the block of each landmark but leave out the covariances between landmarks. The homework uses J_z R J_zᵀ alone; exercise 7.7 does it in full.
        heading forgotten: + pose = np.array([pose[0], pose[1], 0.0])
            You ignore the heading. A bearing is measured from the direction in which the robot looks, so heading and bearing add up.
        landmarks in the robot frame: landmark_position(pose, => landmark_position(np.zeros(3),
            Your covariances are correct, but your landmarks are in the robot's frame. The map needs them in the field frame: landmark_position(pose, measurement).
        J_p for J_z: landmark_jacobians(pose, measurements[i : i + 2])[1] => landmark_jacobians(pose, measurements[i : i + 2])[0]
            Two shapes do not fit. If the line calls landmark_position: the order is (pose, measurement). If it uses the Jacobians: landmark_jacobians(pose, measurement) returns two matrices, J_p (2, 3) and then J_z (2, 2). Here you need J_z.
        all x, then all y: return k, landmarks, => return k, np.concatenate([landmarks[::2], landmarks[1::2]]),
            You return all x and then all y. Return x and y of each landmark in turn.
        Jacobian without the heading: landmark_jacobians(pose, => landmark_jacobians(np.array([*pose[:2], 0.0]),
            Your landmarks are correct, but their covariances ignore the heading. Evaluate the Jacobian at the whole pose.
        six landmarks only: range(0, 2 * k, 2) => range(0, min(2 * k, 12), 2)
            Your function works for up to six landmarks and leaves zeros for the others. Compute k from the input: len(measurements) // 2.
        in the robot frame: + pose = np.zeros(3)
            Your landmarks are in the robot's frame. The map needs them in the field frame: landmark_position(pose, measurement).
        bearing's sign: + measurements = measurements * np.tile([-1.0, 1.0], len(measurements) // 2)
            You swap left and right. A bearing is positive to the left and is added to the heading.
        range, bearing: + measurements = measurements.reshape(-1, 2)[:, ::-1].ravel()
            You swap bearing and range. Their order is (bearing, range, bearing, range, ...).
        bearings, then ranges: + measurements = measurements.reshape(2, -1).T.ravel()
            You read the first half as bearings and the second half as ranges. Pairs are rows: measurements.reshape(-1, 2).
        rows of k: + if len(measurements) != 4:
            +     raise ValueError
            Your function works for two landmarks only, as with measurements.reshape(2, -1). Pairs are rows: measurements.reshape(-1, 2).
        R as given: + if np.shape(measurement_covariance) != (2, 2):
            +     raise ValueError
            You use measurement_covariance as it is, which works for a single (2, 2) matrix only. joint_noise(measurement_covariance, k) returns the full (2k, 2k) matrix for each of the three forms.
        R's blocks only: joint_noise(measurement_covariance, k) => joint_noise(measurement_covariance, k) * np.kron(np.eye(k), np.ones((2, 2)))
            You leave zeros between different landmarks. If R is a full matrix, their noise is correlated: put the Jacobians of all landmarks on the diagonal of one (2k, 2k) matrix and multiply all of joint_noise(measurement_covariance, k) by it.
        roots of R: joint_noise(measurement_covariance, k) => np.sqrt(np.abs(joint_noise(measurement_covariance, k)))
            You take the square root of R. R holds variances, and the result holds variances, too, so use R as it is.
        R squared: joint_noise(measurement_covariance, k) => joint_noise(measurement_covariance, k) ** 2
            You square R. R already holds variances, so use it as it is.
        one R repeated: joint_noise(measurement_covariance, k) => np.kron(np.eye(k), measurement_covariance)
            np.kron repeats a single (2, 2) matrix, so your function fails for the other two forms of R. joint_noise(measurement_covariance, k) returns the full (2k, 2k) matrix for each of the three forms.
        (k, 2): return k, landmarks => return k, landmarks.reshape(k, 2)
            Your landmarks have shape (k, 2). The state is one vector, so return them as (2k,): x and y of each landmark in turn.
    """),
    alternatives={
        "block by block": _initial_by_landmark,
        "central differences": _initial_by_differences,
        "a Cholesky factor": _initial_by_roots,
    },
    equivalents={
        "landmarks, jacobian = (np.ones(2 * k), np.zeros((2 * k, 2 * k)))": "all entries are overwritten",
        **{
            f"jacobian[i:i + 2, i:i + 2] = landmark_jacobians(pose, measurements[{longer}])[1]": "landmark_jacobians reads only the first two numbers"
            for longer in ("i:i + 3", "i:")
        },
    },
)


# --- 7.3 predict ---
def _predicted_whole(state: Array, P: Array, control: Array, Q: Array, k: int) -> Any:
    """Use the Jacobians of the whole state."""
    F, G = motion_model_jacobians(state, control)
    F, G = block_diag(F, np.eye(2 * k)), np.vstack([G, np.zeros((2 * k, 3))])
    shift = [*control[0] * rotation_2d(state[2])[:, 0], control[1], *np.zeros(2 * k)]
    return shifted(state, shift), F @ P @ F.T + G @ Q @ G.T


def _predicted_in_blocks(state: Array, P: Array, control: Array, Q: Array, k: int) -> Any:
    F, G = motion_model_jacobians(state, control)
    new = [*(Pose(*state[:3]) @ Pose(control[0], 0.0, control[1])).as_array(), *state[3:]]
    cross = F @ P[:3, 3:]
    return [new, np.block([[F @ P[:3, :3] @ F.T + G @ Q @ G.T, cross], [cross.T, P[3:, 3:]]])]


def _predicted_by_differences(state: Array, P: Array, control: Array, Q: Array, k: int) -> Any:
    def moved(values: Array) -> Array:
        along, across, turn = values[-3:] + (control[0], 0.0, control[1])
        return values[:-3] + [*rotation_2d(values[2]) @ (along, across), turn, *np.zeros(2 * k)]

    both = np.append(state, np.zeros(3))
    J = by_differences(moved, both)
    return shifted(moved(both), 0.0), J @ block_diag(P, Q) @ J.T


def _motion_case(
    rng: np.random.Generator,
    k: int,
    control: Any,
    name: str = "",
    heading: float | None = None,
    plain: bool = False,
) -> Case:
    pose = random_pose(rng)
    if heading is not None:
        pose[2] = heading
    state = np.concatenate([pose, around(rng, pose, k).ravel()])
    Q = np.diag([0.25, 0.1, 0.1]) ** 2 if plain else random_covariance(rng, 3, scale=0.1)
    return Case((state, random_covariance(rng, 3 + 2 * k), np.array(control, dtype=float), Q, k), name)


def _motion_public() -> list[Case]:
    rng = np.random.default_rng(73)
    return [
        _motion_case(rng, 0, (1.0, 1.5), "no landmark yet, and a turn past 180 degrees", 2.4, plain=True),
        _motion_case(rng, 1, (0.8, -0.3), "one landmark", 1.2, plain=True),
        _motion_case(rng, 2, (1.0, 0.5), "two landmarks", 2.0),
        _motion_case(rng, 3, (-0.5, 0.2), "backwards, three landmarks", -0.8),
        _motion_case(rng, 1, (0.0, 0.0), "standing still", -2.0),
        _motion_case(rng, 0, (0.6, -1.5), "no landmark yet, and a turn past -180 degrees", -2.4),
    ]


def _motion_hidden(rng: np.random.Generator) -> list[Case]:
    kinds = ((1, True), (2, False), (4, True), (3, False), (0, False))
    return [
        *(
            _motion_case(rng, k, (rng.uniform(0.3, 1.5), rng.uniform(-1, 1)), plain=plain)
            for k, plain in kinds
        ),
        *(_motion_case(rng, 2, (0.7, turn), heading=heading) for turn, heading in ((0.9, 2.9), (-0.9, -2.9))),
    ]


PREDICT = Exercise(
    name="predict",
    points=4,
    stars=2,
    uses=("warp2pi", "05:predict_pose", "05:motion_jacobians"),
    public=_motion_public,
    hidden=_motion_hidden,
    comparison=Each((Close(atol=1e-8), Close(rtol=1e-7, atol=1e-9)), names=STATE),
    hints=(
        "Copy both arrays. Compute F and G at the old pose, before you overwrite state[:3]. A motion changes the first three values of the state and all blocks of the covariance that have a p in their name.",
        "The error of the pose becomes F e_p + G n, and the errors of the landmarks stay as they are. Multiply the one by the other and take the mean: this gives the block covariance[:3, 3:]. The block covariance[3:, :3] is its transpose.",
    ),
    sibling=Sibling(
        "If one of two numbers is changed, as the pose is, and the other is not, as the landmarks are, their covariance gets the factor once, and the variance of the changed number gets it twice.",
        """
        import numpy as np

        rng = np.random.default_rng(2)
        pension = rng.normal(0, 1, 200000)
        euros = 0.5 * pension + rng.normal(0, 1, 200000)
        dollars = 1.2 * euros + rng.normal(0, 0.3, 200000)  # changed, with a new error
        before, after = np.cov(euros, pension), np.cov(dollars, pension)
        print(f"covariance: {after[0, 1] / before[0, 1]:.1f} times as large")
        print(f"variance: {after[0, 0]:.1f} is {1.2**2 * before[0, 0] + 0.3**2:.1f}")
        """,
        """
        covariance: 1.2 times as large
        variance: 1.9 is 1.9
        """,
    ),
    mistakes=catalogue("""
        cross-covariances left: covariance[3:, :3] = covariance[3:, :3] @ F.T => pass
            covariance[:3, 3:] = covariance[3:, :3].T => pass
            Your pose block is correct, but the blocks between pose and map stayed as they were: this is the second bug of the recorded filter. The motion multiplies the pose's error by F, so its covariance with the map must be multiplied, too. Use F e_p to derive it.
        P_lp times F: covariance[3:, :3] = covariance[3:, :3] @ F.T => covariance[:3, 3:] = F @ covariance[:3, 3:]
            covariance[:3, 3:] = covariance[3:, :3].T => covariance[3:, :3] = covariance[3:, :3] @ F
            Your block above the diagonal is correct, but below it you compute P_lp F. The transpose of F P_pl is P_lp Fᵀ.
        rows without columns: covariance[:3, 3:] = covariance[3:, :3].T => pass
            covariance[3:, :3] = covariance[3:, :3] @ F.T => covariance[:3, 3:] = F @ covariance[:3, 3:]
            You update the block above the diagonal but not the block P_lp below it, so your covariance is not symmetric. P_lp is the transpose of P_pl.
        F twice below the diagonal: covariance[3:, :3] = covariance[3:, :3] @ F.T => covariance[:3, 3:] = F @ covariance[:3, 3:]
            covariance[:3, 3:] = covariance[3:, :3].T => covariance[3:, :3] = covariance[:3, 3:].T @ F.T
            Below the diagonal you multiply by F twice, because P_pl has already changed when you transpose it. The new P_lp is the transpose of the new P_pl.
        columns without rows: covariance[:3, 3:] = covariance[3:, :3].T => pass
            You update the block below the diagonal but not the block P_pl above it, so your covariance is not symmetric. P_pl is the transpose of P_lp.
        P_lp times F alone: covariance[:3, 3:] = covariance[3:, :3].T => pass
            covariance[3:, :3] = covariance[3:, :3] @ F.T => covariance[3:, :3] = covariance[3:, :3] @ F
            You change only the block below the diagonal, and to P_lp F. Transpose F P_pl to get this block, and set both blocks.
        F on both sides of P_pl: covariance[3:, :3] @ F.T => F @ covariance[3:, :3] @ F.T
            Two shapes do not fit. If the line contains P_pl or P_lp, F is on the wrong side, or on both. P_pl has three rows: F P_pl. P_lp has three columns: P_lp Fᵀ. If the line contains Q: F, G and Q are (3, 3).
        F for the whole: + if k:
            +     raise ValueError
            Your function fails as soon as there is a landmark. F and predict_pose are for the three values of the pose: use covariance[:3, :3] and state[:3].
        F twice for the pose: F @ covariance[:3, :3] @ F.T => F @ F @ covariance[:3, :3] @ F.T @ F.T
            You multiply the pose's own block by F twice. covariance[:3] and covariance[:, :3] contain this block, too: change the blocks next to it with covariance[:3, 3:] and covariance[3:, :3].
        F twice for the pose and its noise: F @ covariance[:3, :3] @ F.T + G @ control_covariance @ G.T => F @ (F @ covariance[:3, :3] @ F.T + G @ control_covariance @ G.T) @ F.T
            You multiply the new block of the pose by F again, and with it the noise. covariance[:3] and covariance[:, :3] contain this block: use covariance[:3, 3:] and covariance[3:, :3] for the blocks next to it.
        F twice on the left: F @ covariance[:3, :3] @ F.T => F @ F @ covariance[:3, :3] @ F.T
            In the pose's own block there are two F on the left. covariance[:3] = F @ covariance[:3] changes this block, too: use covariance[:3, 3:] for the block next to it.
        F again on the left, with the noise: F @ covariance[:3, :3] @ F.T + G @ control_covariance @ G.T => F @ (F @ covariance[:3, :3] @ F.T + G @ control_covariance @ G.T)
            After the pose's own block is complete, you multiply it by F from the left once more. covariance[:3] = F @ covariance[:3] contains it: use covariance[:3, 3:] for the block next to it.
        F twice on the right: F @ covariance[:3, :3] @ F.T => F @ covariance[:3, :3] @ F.T @ F.T
            In the pose's own block there are two Fᵀ on the right. covariance[:, :3] = covariance[:, :3] @ F.T changes this block, too: use covariance[3:, :3] for the block below it.
        first F missing: F @ covariance[:3, :3] @ F.T => covariance[:3, :3] @ F.T
            In the pose's own block the first factor is missing: F P_pp Fᵀ. If you copied covariance[:3].T into the columns, it also replaced this block.
        last F not transposed: F @ covariance[:3, :3] @ F.T => F @ covariance[:3, :3] @ F
            In the pose's own block you compute F P F. The last factor is Fᵀ: F P_pp Fᵀ.
        last F missing: F @ covariance[:3, :3] @ F.T => F @ covariance[:3, :3]
            In the pose's own block the last factor is missing: F P_pp Fᵀ.
        F left out for the pose: F @ covariance[:3, :3] @ F.T => covariance[:3, :3]
            You add the noise to the old P_pp. The old error is multiplied by F: F P_pp Fᵀ + G Q Gᵀ.
        G, F: F, G = motion_jacobians => G, F = motion_jacobians
            You exchange F and G. motion_jacobians returns F first: F, G = motion_jacobians(pose, control).
        cross-covariances dropped: covariance[3:, :3] = covariance[3:, :3] @ F.T => covariance[3:, :3] = 0
            You set the covariance between pose and map to zero. A motion does not remove it: the landmarks' errors still come from earlier poses. Multiply P_pl by F instead.
        cross-covariances from the wrong side: covariance[3:, :3] @ F.T => covariance[3:, :3] @ F
            You multiply P_pl by Fᵀ. The pose's error becomes F e_p, so the block above the diagonal is F P_pl, and the block below it is P_lp Fᵀ.
        F transposed: F, G = motion_jacobians(state[:3], control) => F, G = motion_jacobians(state[:3], control)
            + F = F.T
            You use Fᵀ in place of F. The covariance of F e is F P Fᵀ, with F on the left.
        F transposed for the pose: F @ covariance[:3, :3] @ F.T => F.T @ covariance[:3, :3] @ F
            In the pose's own block you compute Fᵀ P F. The covariance of F e is F P Fᵀ, with F on the left.
        F left out: F, G = motion_jacobians(state[:3], control) => F, G = motion_jacobians(state[:3], control)
            + F = np.eye(3)
            You use no F. A heading error becomes a position error while the robot drives, and F describes this.
        noise in the world frame: G @ control_covariance @ G.T => control_covariance
            You add Q without rotating it. Q is along and across the robot, and G Q Gᵀ rotates it into the field frame.
        Gᵀ Q G: G @ control_covariance @ G.T => G.T @ control_covariance @ G
            You compute Gᵀ Q G, which rotates the noise in the wrong direction. Use G Q Gᵀ.
        last G missing: G @ control_covariance @ G.T => G @ control_covariance
            You compute G Q. The last factor is missing: G Q Gᵀ.
        no noise: F.T + G @ control_covariance @ G.T => F.T
            Your covariance lacks the noise of the motion. Add G Q Gᵀ to the pose's block.
        noise subtracted: F.T + G @ => F.T - G @
            You subtract the noise of the motion. A motion adds uncertainty: F P Fᵀ + G Q Gᵀ.
        noise on the landmarks: return state, covariance => covariance[3:, 3:] += np.kron(np.eye(k), (G @ control_covariance @ G.T)[:2, :2])
            + return state, covariance
            You add noise to the landmarks. They do not move, so P_ll stays as it is.
        unrotated noise on the landmarks: return state, covariance => covariance[3:, 3:] += np.kron(np.eye(k), control_covariance[:2, :2])
            + return state, covariance
            You add noise to the landmarks. They do not move, so P_ll stays as it is. What you add is also in the robot frame.
        common noise on the landmarks: return state, covariance => covariance[3:, 3:] += np.kron(np.ones((k, k)), (G @ control_covariance @ G.T)[:2, :2])
            + return state, covariance
            You add noise to the landmarks. They do not move, so P_ll stays as it is. You add the same noise to all of them.
        noise of the distance on the landmarks: return state, covariance => covariance[3:, 3:] += control_covariance[0, 0] * np.eye(2 * k)
            + return state, covariance
            You add noise to the landmarks. They do not move, so P_ll stays as it is. You add the noise of the distance.
        a little noise on the landmarks: return state, covariance => covariance[3:, 3:] += 1e-7 * np.eye(2 * k)
            + return state, covariance
            You add 1e-7 to the landmarks' variances. Landmarks do not move, so P_ll stays as it is; what you add in each step accumulates.
        a millionth of noise on the landmarks: return state, covariance => covariance[3:, 3:] += 1e-6 * np.eye(2 * k)
            + return state, covariance
            You add 1e-6 to the landmarks' variances. Landmarks do not move, so P_ll stays as it is; what you add in each step accumulates.
        Jacobians at the new pose: F, G = motion_jacobians(state[:3], control) => pass
            state[2] = warp2pi(state[2]) => state[2] = warp2pi(state[2])
            + F, G = motion_jacobians(state[:3], control)
            You evaluate F and G at the new pose. Evaluate them at the pose before the motion, before you overwrite state[:3].
        landmarks move along: state[:3] = predict_pose(state[:3], control) => moved = predict_pose(state[:3], control)
            + state[3:] += np.tile(moved[:2] - state[:2], k)
            + state[:3] = moved
            You move the landmarks along with the robot. Only the first three values of the state change.
        turned first: + turned = state[:3] + (0.0, 0.0, control[1])
            motion_jacobians(state[:3], control) => motion_jacobians(turned, control)
            predict_pose(state[:3], control) => predict_pose(turned, np.array([control[0], 0.0]))
            You turn before you drive. The robot drives along its old heading and turns afterwards, and F and G use the old heading, too.
        heading not wrapped: state[2] = warp2pi(state[2]) => pass
            Your heading can leave the range from -pi to pi. Apply warp2pi to state[2] after the motion.
        the whole state wrapped: state[2] = warp2pi(state[2]) => state[:] = warp2pi(state)
            You wrap the whole state, but all values except the heading are in metres. Apply warp2pi to state[2] only.
        map block lost: return state, covariance => covariance[3:, 3:] = 0
            + return state, covariance
            You return zeros in the map's block P_ll. Landmarks do not move, so this block stays as it is: begin with covariance.copy().
    """),
    alternatives={
        "Jacobians of the whole state": _predicted_whole,
        "np.block, a list": _predicted_in_blocks,
        "central differences": _predicted_by_differences,
    },
    equivalents={
        f"F, G = motion_jacobians(state[{longer}], control)": "motion_jacobians reads only the first three numbers"
        for longer in (":4", ":")
    },
)


# --- 7.4 update_landmarks, 7.5 update ---
def linearised(state: Array, indices: Any, z: Array) -> tuple[Array, Array]:
    """Return H (2m, n) and the innovation (2m,) of some landmarks."""
    H, nu = np.zeros((2 * len(indices), len(state))), z.copy()
    for j, i in enumerate(indices):
        rows, columns = slice(2 * j, 2 * j + 2), slice(3 + 2 * i, 5 + 2 * i)
        H[rows, :3], H[rows, columns] = measurement_jacobians(state[:3], state[columns])
        nu[rows] -= expected(state[:3], state[columns])
    nu[::2] = np.angle(np.exp(1j * nu[::2]))
    return H, nu


def _by_information(state: Array, P: Array, indices: Any, z: Array, R: Array) -> Any:
    """Update in information form."""
    H, nu = linearised(state, indices, z)
    weighted = H.T @ np.linalg.inv(joint_noise(R, len(indices)))
    P = np.linalg.inv(np.linalg.inv(P) + weighted @ H)
    P = (P + P.T) / 2
    return [shifted(state, P @ weighted @ nu), P]


def _by_roots(state: Array, P: Array, indices: Any, z: Array, R: Array) -> Any:
    """Subtract a symmetric product, by a Cholesky factor of S."""
    H, nu = linearised(state, indices, z)
    root = np.linalg.cholesky(H @ P @ H.T + joint_noise(R, len(indices)))
    W = np.linalg.solve(root, H @ P).T
    return shifted(state, W @ np.linalg.solve(root, nu)), P - W @ W.T


def _joseph(state: Array, P: Array, indices: Any, z: Array, R: Array) -> Any:
    H, nu = linearised(state, indices, z)
    R = joint_noise(R, len(indices))
    K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
    keep = np.eye(len(state)) - K @ H
    P = keep @ P @ keep.T + K @ R @ K.T
    return shifted(state, K @ nu), (P + P.T) / 2


def measurement_case(
    rng: np.random.Generator,
    k: int,
    indices: Sequence[int],
    form: str,
    name: str = "",
    *,
    heading: float | None = None,
    behind: float = 0.0,
    which: int = 0,
    farther: float = 0.0,
    turned: float = 0.0,
    scale: float = 1.0,
) -> Case:
    """Return a map of k landmarks with measurements of some.

    `behind` is the side of the half turn on which measurement number `which` is, 0 for none.
    """
    pose = random_pose(rng)
    if heading is not None:
        pose[2] = heading
    landmarks = around(rng, pose, k)
    if behind:  # where a bearing passes the half turn
        direction = pose[2] + behind * (np.pi - 0.03)
        landmarks[indices[which]] = pose[:2] + 2.0 * np.array([np.cos(direction), np.sin(direction)])
    state = np.concatenate([pose, landmarks.ravel()])
    z = np.concatenate([expected(pose, landmarks[i]) for i in indices])
    z += rng.normal(0, 0.08, len(z))
    if behind:
        z[2 * which] = behind * (np.pi - 0.03 + 0.12)
    z[::2] = wrap_angle(z[::2] - turned)
    z[1] += farther
    P, R = random_covariance(rng, 3 + 2 * k), noise(rng, len(indices), form)
    return Case((state, scale * P, list(indices), z, scale * R), name)


def many_updates(rng: np.random.Generator, name: str = "", updates: int = 60, k: int = 3) -> Case:
    """Return many updates far from the origin with an uncertain common heading, where rounding errors grow quickly."""
    pose = np.array([100.0, 60.0, 0.7])
    state = np.concatenate([pose, around(rng, pose, k).ravel()])
    states = state + rng.normal(0, 0.1, (updates, len(state)))
    indices = [[number % k] for number in range(updates)]
    seen = [expected(at, at[3 + 2 * i : 5 + 2 * i]) for at, [i] in zip(states, indices, strict=True)]
    P, z, R = common_error(rng, state), np.array(seen) + (0.02, 0.05), np.diag([0.02, 0.05]) ** 2
    return Case((states, P, indices, z, R), name)


def common_error(rng: np.random.Generator, state: Array) -> Array:
    """Return the covariance of a map with a common position error of 1 m and a common rotation error of 0.1 rad."""
    x, y = np.array([state[:2], *state[3:].reshape(-1, 2)]).T
    common = np.zeros((len(state), 3))
    common[2, 2] = 1.0
    at = np.array([0, *range(3, len(state), 2)])
    common[at, 0], common[at, 2] = 1.0, -y
    common[at + 1, 1], common[at + 1, 2] = 1.0, x
    common *= (1.0, 1.0, 0.1)
    return common @ common.T + random_covariance(rng, len(state), scale=0.05)


def _update_public() -> list[Case]:
    rng = np.random.default_rng(74)
    return [
        measurement_case(rng, 1, [0], "each", "the only landmark", heading=0.3),
        measurement_case(rng, 3, [1], "each", "the second of three", heading=-1.0),
        measurement_case(rng, 3, [0, 2], "each", "two of three at once", heading=2.0),
        measurement_case(rng, 3, [2, 0], "own", "in another order, each with its own R", heading=1.0),
        measurement_case(rng, 2, [0, 1], "joint", "with correlated noise: R is (4, 4)", heading=-0.5),
        measurement_case(rng, 1, [0], "each", "a landmark behind the robot", heading=0.5, behind=1.0),
        measurement_case(rng, 1, [0], "each", "a heading that passes 180 degrees", heading=3.12, turned=0.5),
        measurement_case(rng, 1, [0], "each", "a range 4 m longer than expected", heading=0.1, farther=4.0),
        measurement_case(rng, 1, [0], "each", "behind, on the other side", heading=0.5, behind=-1.0),
        measurement_case(
            rng, 1, [0], "each", "a heading that passes -180 degrees", heading=-3.12, turned=-0.5
        ),
        measurement_case(
            rng, 2, [0, 1], "each", "two, the second behind the robot", heading=0.5, behind=1.0, which=1
        ),
        measurement_case(rng, 2, [1], "each", "a map with errors of a millimetre", heading=0.8, scale=1e-5),
        many_updates(rng, "60 updates, one after the other"),
        measurement_case(np.random.default_rng(741), 2, [1, 0], "each", "both landmarks, the second first"),
    ]


def _update_hidden(rng: np.random.Generator) -> list[Case]:
    sizes = ((1, 1, "each"), (4, 2, "own"), (3, 3, "each"), (5, 2, "joint"), (3, 1, "each"), (4, 3, "joint"))
    return [
        *(measurement_case(rng, k, rng.permutation(k)[:m].tolist(), form) for k, m, form in sizes),
        *(measurement_case(rng, 2, [0], "each", behind=side) for side in (1.0, -1.0)),
        *(measurement_case(rng, 3, [2, 0], "each", behind=side, which=1) for side in (1.0, -1.0)),
        measurement_case(rng, 3, [1], "own", farther=4.0),
        measurement_case(rng, 3, [2, 0], "each", scale=1e-5),
        measurement_case(rng, 2, [0, 1], "each", heading=3.13, turned=0.5),
        measurement_case(rng, 2, [0, 1], "each", heading=-3.13, turned=-0.5),
        many_updates(rng),
    ]


def textbook(
    *,
    first: Callable[[int], int] = lambda i: 3 + 2 * i,
    pair: Callable[[int, int], float] = lambda j, i: j,
    landmark_of: Callable[[int, int], int] = lambda j, i: i,
    wrapped: slice = slice(0, None, 2),
    by_landmark: Callable[[Array], Array] = lambda H: H,
    noise_of: Callable[[Array, int], Array] = joint_noise,
    gain: Callable[[Array, Array, Array], Array] = lambda P, H, S: P @ H.T @ np.linalg.inv(S),
    corrected: slice = slice(None),
    in_place: bool = False,
    begins: int = 3,
    stride: int = 2,
    row: Callable[[int, int], int] = lambda j, i: j,
    kept: float = 1.0,
    reduced: Callable[[Array, Array, Array], Array] = lambda P, K, H: P - K @ H @ P,
) -> Callable[..., Any]:
    """Return the textbook's update with a symmetric covariance and with one slip.

    first(i) is the first column of landmark i in H, pair(j, i) the number of the pair of measurements that is used for
    it, and landmark_of(j, i) the landmark that is read from the state, where the first one `begins` and the next one is
    `stride` later. row(j, i) is the pair of rows of H. `wrapped` are the
    innovations that are wrapped, `corrected` the values of the state that are corrected, and `kept` times the old state is added to the correction.
    """

    def updated(state: Array, P: Array, indices: Any, z: Array, R: Array) -> Any:
        m, n = len(indices), len(state)
        H, nu = np.zeros((2 * m, n)), np.zeros(2 * m)
        for j, i in enumerate(indices):
            rows, begin, number = slice(2 * j, 2 * j + 2), begins + stride * landmark_of(j, i), pair(j, i)
            of_H = slice(2 * row(j, i), 2 * row(j, i) + 2)
            landmark = state[begin : begin + 2]
            H[of_H, :3], own = measurement_jacobians(state[:3], landmark)
            H[of_H, first(i) : first(i) + 2] = by_landmark(own)
            nu[rows] = z[int(2 * number) : int(2 * number) + 2] - expected(state[:3], landmark)
        nu[wrapped] = wrap_angle(nu[wrapped])
        K = gain(P, H, H @ P @ H.T + noise_of(R, m))
        new, P, shift = state.copy(), reduced(P, K, H), K @ nu
        if in_place:
            new += shift
        elif corrected == slice(None):
            new = kept * state + shift
        else:
            new[corrected] += shift[corrected]
        new[2] = wrap_angle(new[2])
        return new, (P + P.T) / 2

    return updated


TEXTBOOK_SLIPS = [
    Mistake(
        "state and H without the pose",
        textbook(begins=0, first=lambda i: 2 * i),
        "You put landmark i at 2 i, in the state and in the columns of H. The first three places belong to the pose, so landmark i has the places 3 + 2 i and 4 + 2 i.",
    ),
    Mistake(
        "state without the pose",
        textbook(begins=0),
        "You read landmark i from state[2 * i : 2 * i + 2]. The first three values of the state are the pose, so landmark i begins at 3 + 2 i.",
    ),
    Mistake(
        "the correction alone",
        textbook(kept=0.0),
        "Your new state is only the correction K ν. Add it to the old state: s' = s + K ν.",
    ),
    Mistake(
        "columns of H without the pose",
        textbook(first=lambda i: 2 * i),
        "In H you put the Jacobian with respect to landmark i in columns 2 i and 2 i + 1. The first three columns belong to the pose, so its columns are 3 + 2 i and 4 + 2 i.",
    ),
    Mistake(
        "columns of H one too early",
        textbook(first=lambda i: 2 + 2 * i),
        "In H you put the Jacobian with respect to landmark i one column too far to the left. The pose has three columns, 0 to 2, so landmark i has columns 3 + 2 i and 4 + 2 i.",
    ),
    Mistake(
        "columns of H with one number a landmark",
        textbook(first=lambda i: 3 + i),
        "In H you put the Jacobian with respect to landmark i in columns 3 + i and 4 + i. A landmark has two columns, x and y, so they are 3 + 2 i and 4 + 2 i.",
    ),
    Mistake(
        "state with one number a landmark",
        textbook(stride=1),
        "You read landmark i from state[3 + i : 5 + i]. A landmark has two values, x and y, so landmark i begins at state[3 + 2 * i].",
    ),
    Mistake(
        "rows of H by the landmark",
        textbook(row=lambda j, i: i),
        "You put the Jacobians in the rows 2 i and 2 i + 1 of H. Row j belongs to measurement j: its rows are 2 j and 2 j + 1, and i only gives the columns.",
    ),
    Mistake(
        "Joseph form without K R Kᵀ",
        textbook(reduced=lambda P, K, H: (np.eye(len(P)) - K @ H) @ P @ (np.eye(len(P)) - K @ H).T),
        "You return (I - K H) P (I - K H)ᵀ. Equation 7.4 has a second term: add K R Kᵀ.",
    ),
    Mistake(
        "Joseph form, not transposed",
        textbook(reduced=lambda P, K, H: (np.eye(len(P)) - K @ H) @ P @ (np.eye(len(P)) - K @ H + H.T @ K.T)),
        "In the Joseph form the factor behind P is transposed: (I - K H) P (I - K H)ᵀ + K R Kᵀ.",
    ),
    Mistake(
        "brackets of the mean",
        textbook(reduced=lambda P, K, H: 1.5 * (P - K @ H @ P)),
        "You compute P + P.T / 2, which halves only the second term. It needs brackets: (P + P.T) / 2.",
    ),
    Mistake(
        "measurements by the landmark",
        textbook(pair=lambda j, i: i),
        "You read the measurement at 2 i, where i is the number of the landmark. The measurements are in the order of `indices`, so pair j begins at measurements[2 * j] and belongs to landmark indices[j].",
    ),
    Mistake(
        "measurements one by one",
        textbook(pair=lambda j, i: j / 2),
        "You read measurement j from measurements[j : j + 2]. A measurement has two numbers, so it begins at measurements[2 * j].",
    ),
    Mistake(
        "ranges wrapped in place of bearings",
        textbook(wrapped=slice(1, None, 2)),
        "You wrap the ranges. The bearings have the even numbers: innovation[::2].",
    ),
    Mistake(
        "landmark's Jacobian transposed",
        textbook(by_landmark=lambda H: H.T),
        "You transpose the Jacobian with respect to the landmark. Its rows are bearing and range, as the rows of H are, so use it as it is.",
    ),
    Mistake(
        "R left out",
        textbook(noise_of=lambda R, m: np.zeros((2 * m, 2 * m))),
        "You leave R out of S. The innovation also contains the noise of the measurement: S = H P Hᵀ + R.",
    ),
    Mistake(
        "landmarks by the measurement",
        textbook(landmark_of=lambda j, i: j),
        "You read landmark j from the state. Measurement j belongs to landmark i = indices[j], so read state[3 + 2 * i : 5 + 2 * i].",
    ),
    Mistake(
        "R of all landmarks",
        lambda state, P, indices, z, R: textbook(noise_of=lambda R, m: joint_noise(R, (len(state) - 3) // 2))(
            state, P, indices, z, R
        ),
        "Your shapes do not fit if only some landmarks of the map are measured. R needs two rows for each measured landmark: joint_noise(measurement_covariance, len(indices)). H and the innovation have as many rows, in the order of the measurements, and H has a column for each value of the state.",
    ),
    Mistake(
        "R subtracted",
        textbook(noise_of=lambda R, m: -joint_noise(R, m)),
        "You subtract R in S. The noise of the measurement adds to the uncertainty of the innovation: S = H P Hᵀ + R.",
    ),
    Mistake(
        "the first R for all",
        textbook(noise_of=lambda R, m: np.kron(np.eye(m), joint_noise(R, m)[:2, :2])),
        "You use the R of the first landmark for all of them. joint_noise(measurement_covariance, len(indices)) returns the full matrix for each of the three forms.",
    ),
    Mistake(
        "each entry of S inverted",
        textbook(gain=lambda P, H, S: P @ H.T @ (1 / S)),
        "1 / S takes the reciprocal of each entry. The inverse of a matrix is a different matrix: use np.linalg.inv(S) or np.linalg.solve.",
    ),
    Mistake(
        "S for its inverse",
        textbook(gain=lambda P, H, S: P @ H.T @ S),
        "Your gain multiplies by S. Multiply by its inverse: K = P Hᵀ S⁻¹.",
    ),
    Mistake(
        "only the landmarks corrected",
        textbook(corrected=slice(3, None)),
        "You correct only the landmarks. K @ innovation has a value for each number of the state, so add it to the pose, too.",
    ),
    Mistake(
        "P forgotten, made symmetric",
        textbook(reduced=lambda P, K, H: np.eye(len(P)) - K @ H),
        "You return I - K H, made symmetric. Multiply it by P: P' = (I - K H) P.",
    ),
    Mistake(
        "one R repeated",
        textbook(noise_of=lambda R, m: np.kron(np.eye(m), R)),
        "np.kron repeats a single (2, 2) matrix, so your function fails for the other two forms of R. joint_noise(measurement_covariance, len(indices)) returns the full matrix for each of the three forms.",
    ),
    Mistake(
        "one R repeated, added in place",
        textbook(noise_of=lambda R, m: np.kron(np.eye(m), R), in_place=True),
        "np.kron repeats a single (2, 2) matrix. R has two other forms, for which your shapes do not fit: joint_noise(measurement_covariance, len(indices)) returns the full matrix for each.",
    ),
    Mistake(
        "only the pose corrected",
        textbook(corrected=slice(0, 3)),
        "You correct only the pose. K @ innovation has a value for each number of the state, so add it to the landmarks, too.",
    ),
    Mistake(
        "wrong side, made symmetric",
        textbook(reduced=lambda P, K, H: P @ (np.eye(len(P)) - K @ H)),
        "You compute P (I - K H) and make it symmetric. The order of the product matters: (I - K H) P.",
    ),
    Mistake(
        "K H for K H P",
        textbook(reduced=lambda P, K, H: P - K @ H),
        "You compute P - K H. The last factor is missing: P - K H P.",
    ),
]


UPDATE_LANDMARKS = Exercise(
    name="update_landmarks",
    points=5,
    stars=2,
    uses=(
        "warp2pi",
        "05:expected_measurement",
        "05:measurement_jacobian_pose",
        "05:measurement_jacobian_landmark",
    ),
    public=_update_public,
    hidden=_update_hidden,
    comparison=All((Property(stays_symmetric), Each((Close(atol=1e-7), Close(atol=1e-8)), names=STATE))),
    driver="nao_course.lessons.ekf_slam.filters.repeated_updates:repeated_updates",
    hints=(
        "First fill the innovation and H, two rows for each measured landmark: j is the number of the measurement and i = indices[j] the number of its landmark. Then wrap the bearings, compute S, and apply the gain of equation 7.5.",
        "Rows 2 j and 2 j + 1 of H: columns 0 to 2 are measurement_jacobian_pose, columns 3 + 2 i and 4 + 2 i are measurement_jacobian_landmark. Wrap innovation[::2] with warp2pi. S = H P Hᵀ + joint_noise(measurement_covariance, len(indices)).",
    ),
    sibling=Sibling(
        "Measurement j fills row j, and its entries stand in the columns of its points, which come in any order as your landmarks do: here differences of height are measured.",
        """
        import numpy as np

        pairs = [(2, 0), (0, 1), (2, 1)]  # each measures the height of the second minus the first
        measured = np.array([1.5, 0.8, 2.2])
        A = np.zeros((len(pairs), 3))
        for j, (low, high) in enumerate(pairs):
            A[j, low], A[j, high] = -1, 1
        print(A)
        heights = np.linalg.lstsq(A[:, :2], measured, rcond=None)[0]  # point 2 has the height 0
        print(heights.round(3))
        """,
        """
        [[ 1.  0. -1.]
         [-1.  1.  0.]
         [ 0.  1. -1.]]
        [1.467 2.233]
        """,
    ),
    mistakes=[
        *catalogue("""
        innovation unwrapped: innovation[::2] = warp2pi(innovation[::2]) => pass
            You do not wrap the innovation: this is the first bug of the recorded filter. For a landmark behind the robot, the difference of two bearings can be almost a full turn. Apply warp2pi to innovation[::2].
        first bearing only: innovation[::2] = warp2pi(innovation[::2]) => innovation[0] = warp2pi(innovation[0])
            You wrap only the first bearing. There is one bearing for each measured landmark, and innovation[::2] contains all of them.
        ranges wrapped, too: innovation[::2] = warp2pi(innovation[::2]) => innovation = warp2pi(innovation)
            You wrap ranges as well as bearings. Ranges are in metres, so wrap only innovation[::2].
        innovation's sign: innovation[::2] = warp2pi(innovation[::2]) => innovation = np.where(np.arange(2 * m) % 2, -innovation, -warp2pi(innovation))
            Your correction has the wrong sign, so it moves the state away from the measurement. The innovation is measured minus expected, and K times the innovation is added to the state.
        R's blocks only: joint_noise(measurement_covariance, m) => joint_noise(measurement_covariance, m) * np.kron(np.eye(m), np.ones((2, 2)))
            You use only the 2 x 2 blocks on the diagonal of R. A full R also holds the covariances between the noise of different landmarks; joint_noise(measurement_covariance, m) keeps them.
        R as given: joint_noise(measurement_covariance, m) => measurement_covariance
            You add measurement_covariance as it is, so the shapes do not fit when there are several landmarks. joint_noise(measurement_covariance, len(indices)) returns the full matrix for each of the three forms.
        R everywhere: joint_noise(measurement_covariance, m) => np.kron(np.ones((m, m)), joint_noise(measurement_covariance, m)[:2, :2])
            You repeat one R in every block, as if all measurements had the same error. Independent measurements have R on the diagonal and zeros elsewhere, which is what joint_noise returns.
        R as standard deviations: joint_noise(measurement_covariance, m) => np.sqrt(np.abs(joint_noise(measurement_covariance, m)))
            You take the square root of R. R already holds variances, so use it as it is.
        S without R: joint_noise(measurement_covariance, m) => 1e-9 * np.eye(2 * m)
            Your S lacks R, as if measurements had no noise. S = H P Hᵀ + R.
        one by one: + if len(indices) > 1:
            +     R = joint_noise(measurement_covariance, len(indices))
            +     for j, i in enumerate(indices):
            +         rows = slice(2 * j, 2 * j + 2)
            +         state, covariance = update_landmarks(state, covariance, [i], measurements[rows], R[rows, rows])
            +     return state, covariance
            You update with one landmark after the other, so each is linearised at a state that the previous one has changed. Stack all innovations and all rows of H at the state before the update, and update once.
        one by one with R as given: + if len(indices) > 1:
            +     for j, i in enumerate(indices):
            +         pair = measurements[2 * j : 2 * j + 2]
            +         state, covariance = update_landmarks(state, covariance, [i], pair, measurement_covariance)
            +     return state, covariance
            You update with one landmark after the other and give each the whole measurement_covariance. Stack all innovations and all rows of H at the state before the update, use joint_noise(measurement_covariance, len(indices)) as R, and update once.
        indices by size: + indices = sorted(indices)
            You sort the indices but not the measurements. The first pair of measurements belongs to landmark indices[0], the second to indices[1], and so on.
        pose forgotten in the index: *(3 + 2 * i + c => *(2 * i + c
            state[3 + 2 * i : 5 + 2 * i] => state[2 * i : 2 * i + 2]
            You read landmark i at index 2 i. The first three values of the state are the pose, so landmark i begins at 3 + 2 i.
        columns by the measurement: for i in indices for c in (0, 1) => for i in range(m) for c in (0, 1)
            You put the Jacobian with respect to the landmark in the columns of landmark j. Measurement j belongs to landmark i = indices[j], so use columns 3 + 2 i and 4 + 2 i.
        counted from 1: + indices = [i - 1 for i in indices]
            You count landmarks from 1. Index 0 is the first landmark, at state[3:5].
        H of the pose only: H[rows, 3 + 2 * j : 5 + 2 * j] = measurement_jacobian_landmark(pose, landmark) => pass
            Your H contains only the Jacobian with respect to the pose. The landmark is part of the state, too: put its Jacobian in columns 3 + 2 i and 4 + 2 i.
        H of the landmark only: H[rows, :3] = measurement_jacobian_pose(pose, landmark) => pass
            Your H contains only the Jacobian with respect to the landmark, as if the pose were exact. Put the Jacobian with respect to the pose in the first three columns.
        landmark's Jacobian with the wrong sign: = measurement_jacobian_landmark => = -measurement_jacobian_landmark
            Your Jacobian with respect to the landmark has the wrong sign: a landmark that is farther away has a longer range, so that derivative is positive. Use measurement_jacobian_landmark(pose, landmark) as it is, with the arguments in this order.
        pose's Jacobian with the wrong sign: = measurement_jacobian_pose => = -measurement_jacobian_pose
            Your Jacobian with respect to the pose has the wrong sign. Use measurement_jacobian_pose as it is: if the robot moves towards a landmark, the range becomes shorter, so that derivative is negative.
        only the measured landmarks: state, reduction = state + A.T @ (L_inverse @ innovation), A.T @ A => shift, reduction = A.T @ (L_inverse @ innovation), A.T @ A
            + shift[np.setdiff1d(np.arange(len(shift)), columns)] = 0
            + state = state + shift
            You correct only the pose and the measured landmarks. The other landmarks are correlated with the pose, so their rows of K are not zero: add all of K times the innovation.
        no covariance between pose and map: + covariance = covariance.copy()
            + covariance[:3, 3:], covariance[3:, :3] = 0, 0
            You ignore the covariance between pose and map. It is what carries a correction from one landmark to the others, so keep the whole matrix.
        blocks of P only: + group = np.array([0, 0, 0, *(1 + i // 2 for i in range(len(state) - 3))])
            + covariance = covariance * (group[:, None] == group)
            You use only the diagonal blocks of P, of the pose and of each landmark. Use the whole matrix: the other blocks are the correlations.
        gain transposed: A.T @ (L_inverse @ innovation) => A @ (L_inverse @ innovation)
            Two shapes do not fit. If the line calls a function of lesson 05: the order is (pose, landmark). If it fills H: H needs two rows for each measured landmark, (2m, 3 + 2k). If it computes the correction: use @ between K and the innovation. If it computes P': K H is (n, n); H K is not. K = P Hᵀ S⁻¹ has a row for each value of the state, and np.linalg.solve(S, H @ P) is its transpose.
        covariance kept: np.subtract(covariance, reduction, out=reduction) => covariance.copy()
            Your state is correct, but you return the old covariance. An update reduces it.
        sum not halved: np.subtract(covariance, reduction, out=reduction) => 2 * (covariance - reduction)
            You add P and its transpose but do not halve the sum, so all variances are twice as large. Return (P + P.T) / 2.
        plus for minus: np.subtract(covariance, reduction, out=reduction) => covariance + reduction
            Your covariance grows with an update. A measurement reduces uncertainty, so subtract K H P.
        wrong side: L_inverse = np.linalg.inv(np.linalg.cholesky( => S_inverse = np.linalg.inv((
            A = L_inverse @ HP => K = covariance[:, columns] @ H.T @ S_inverse
            state + A.T @ (L_inverse @ innovation), A.T @ A => state + K @ innovation, covariance @ K @ H @ np.eye(len(state))[columns]
            You compute P (I - K H). The order matters: (I - K H) P.
        P forgotten behind: L_inverse = np.linalg.inv(np.linalg.cholesky( => S_inverse = np.linalg.inv((
            A = L_inverse @ HP => K = covariance[:, columns] @ H.T @ S_inverse
            state + A.T @ (L_inverse @ innovation), A.T @ A => state + K @ innovation, K @ H @ np.eye(len(state))[columns]
            np.subtract(covariance, reduction, out=reduction) => np.eye(len(state)) - reduction
            You return I - K H. Multiply it by P: it is the factor by which P is reduced.
        heading not wrapped: state[2] = warp2pi(state[2]) => pass
            Your heading can leave the range from -pi to pi when it is corrected. Apply warp2pi to state[2] after the correction.
        only the block of the measured landmarks: L_inverse = np.linalg.inv(np.linalg.cholesky( => S_inverse = np.linalg.inv((
            A = L_inverse @ HP => K = covariance[:, columns] @ H.T @ S_inverse
            + measured = np.isin(np.arange(len(state)), columns)
            state + A.T @ (L_inverse @ innovation), A.T @ A => state + measured * (K @ innovation), K @ HP * measured * measured[:, None]
            You update only the pose, the measured landmarks and their block of P. All other landmarks are correlated with the pose, so use all rows of K and all of P - K H P.
        indices ignored: + indices = range(len(indices))
            You assume that the measurements belong to the first landmarks of the map. Measurement j belongs to landmark i = indices[j].
        one number a landmark: *(3 + 2 * i + c => *(3 + i + c
            state[3 + 2 * i : 5 + 2 * i] => state[3 + i : 5 + i]
            You use one column for each landmark. A landmark has two, x and y, so landmark i begins at 3 + 2 i.
        gain's sign: state + A.T @ (L_inverse => state - A.T @ (L_inverse
            np.subtract(covariance, reduction, out=reduction) => covariance + reduction
            Your gain has the wrong sign, so the state moves away from the measurement and P grows. Check the signs of the innovation and of K.
        small entries set to zero: return state, np.subtract(covariance, reduction, out=reduction) => covariance = covariance - reduction
            + covariance[np.abs(covariance) < 1e-6] = 0
            + return state, covariance
            You set small entries of P to zero. An entry of 1e-7 m^2 matters when landmarks are known to a third of a millimetre, so keep all entries.
        never made symmetric: return state, np.subtract(covariance, reduction, out=reduction) => whole = H @ np.eye(len(state))[columns]
            + K = covariance @ whole.T @ L_inverse.T @ L_inverse
            + return state, covariance - K @ whole @ covariance
            Your formula is correct, but you return a covariance that is not exactly symmetric. Each update amplifies the rounding errors, and after these 60 updates it is wrong by between 3 and 200 percent of its largest entry, depending on the form. Return (P + P.T) / 2, also with the Joseph form.
        Joseph form without K R Kᵀ, never made symmetric: return state, np.subtract(covariance, reduction, out=reduction) => whole = H @ np.eye(len(state))[columns]
            + keep = np.eye(len(state)) - covariance @ whole.T @ L_inverse.T @ L_inverse @ whole
            + return state, keep @ covariance @ keep.T
            You return (I - K H) P (I - K H)ᵀ. Equation 7.4 has a second term: add K R Kᵀ. Then return (P + P.T) / 2, because rounding errors make also this form asymmetric.
        unwrapped and never made symmetric: innovation[::2] = warp2pi(innovation[::2]) => pass
            return state, np.subtract(covariance, reduction, out=reduction) => whole = H @ np.eye(len(state))[columns]
            + K = covariance @ whole.T @ L_inverse.T @ L_inverse
            + return state, covariance - K @ whole @ covariance
            Your function has two errors. The innovation's bearings are not wrapped, which fails for landmarks behind the robot: apply warp2pi to innovation[::2]. And rounding errors make your covariance asymmetric over many updates: return (P + P.T) / 2.
        heading not wrapped and never made symmetric: state[2] = warp2pi(state[2]) => pass
            return state, np.subtract(covariance, reduction, out=reduction) => whole = H @ np.eye(len(state))[columns]
            + K = covariance @ whole.T @ L_inverse.T @ L_inverse
            + return state, covariance - K @ whole @ covariance
            Your function has two errors. The corrected heading can leave the range from -pi to pi: apply warp2pi to state[2]. And rounding errors make your covariance asymmetric over many updates: return (P + P.T) / 2.
        no angle wrapped and never made symmetric: innovation[::2] = warp2pi(innovation[::2]) => pass
            state[2] = warp2pi(state[2]) => pass
            return state, np.subtract(covariance, reduction, out=reduction) => whole = H @ np.eye(len(state))[columns]
            + K = covariance @ whole.T @ L_inverse.T @ L_inverse
            + return state, covariance - K @ whole @ covariance
            Your function has three errors. Neither the innovation's bearings nor the corrected heading are wrapped: apply warp2pi to both. And rounding errors make your covariance asymmetric over many updates: return (P + P.T) / 2.
        no angle wrapped: innovation[::2] = warp2pi(innovation[::2]) => pass
            state[2] = warp2pi(state[2]) => pass
            You wrap neither the innovation's bearings nor the corrected heading. Apply warp2pi to innovation[::2] before the update and to state[2] after it.
        one by one and never made symmetric: + if len(indices) > 1:
            +     R = joint_noise(measurement_covariance, len(indices))
            +     for j, i in enumerate(indices):
            +         rows = slice(2 * j, 2 * j + 2)
            +         state, covariance = update_landmarks(state, covariance, [i], measurements[rows], R[rows, rows])
            +     return state, covariance
            return state, np.subtract(covariance, reduction, out=reduction) => whole = H @ np.eye(len(state))[columns]
            + K = covariance @ whole.T @ L_inverse.T @ L_inverse
            + return state, covariance - K @ whole @ covariance
            Your function has two errors. You update with one landmark after the other; stack all innovations and rows of H at the state before the update, and update once. And rounding errors make your covariance asymmetric over many updates: return (P + P.T) / 2.
    """),
        *TEXTBOOK_SLIPS,
    ],
    alternatives={
        "information form": _by_information,
        "Cholesky factor": _by_roots,
        "Joseph form, made symmetric": _joseph,
    },
    equivalents={
        "innovation, H = (np.ones(2 * m), np.zeros((2 * m, 3 + 2 * m)))": "all entries are overwritten",
        **{
            f"rows, landmark = (slice(2 * j, 2 * j + 2), state[3 + 2 * i:{end}])": "of a longer piece the first two numbers are the landmark"
            for end in ("", "5 << 2 * i", "5 + 2 ** i", "5 + 2 << i", "6 + 2 * i", "5 + 3 * i")
        },
        "return (state, np.subtract(covariance, reduction))": "a new array has the same numbers",
    },
)


def _all_of(updated: Any) -> Any:
    return lambda state, P, z, R, k: updated(state, P, list(range(k)), z, R)


def _all_public() -> list[Case]:
    names = ("one landmark", "two", "three, each with its own R", "two with correlated noise")
    return _all_measured(np.random.default_rng(75), names)


def _all_measured(rng: np.random.Generator, names: Sequence[str] = ("",) * 4) -> list[Case]:
    cases = []
    for k, form, name in zip((1, 2, 3, 2), ("each", "each", "own", "joint"), names, strict=True):
        state, P, _, z, R = measurement_case(rng, k, range(k), form).args
        cases.append(Case((state, P, z, R, k), name))
    return cases


UPDATE = Exercise(
    name="update",
    points=1,
    stars=2,
    uses=("update_landmarks",),
    public=_all_public,
    hidden=_all_measured,
    comparison=Each((Close(atol=1e-7), Close(atol=1e-7)), names=STATE),
    hints=(
        "Call update_landmarks with all k landmarks as its indices.",
        "The indices of all k landmarks are range(k).",
    ),
    sibling=Sibling(
        "A function for some items does the work for all items if it gets all their numbers.",
        """
        def total(prices, chosen):
            return sum(prices[i] for i in chosen)


        prices = [4, 1, 7]
        print(total(prices, [2, 0]), total(prices, range(len(prices))))
        """,
        "11 12",
    ),
    mistakes=catalogue("""
        the first one only
            update_landmarks(state, covariance, list(range(k)), measurements, measurement_covariance) => update_landmarks(state, covariance, [0], measurements[:2], joint_noise(measurement_covariance, k)[:2, :2])
            You update with the first landmark only. All k landmarks are measured, in the order of the map.
        the last one forgotten
            update_landmarks(state, covariance, list(range(k)), measurements, measurement_covariance) => update_landmarks(state, covariance, range(k - 1), measurements[:-2], joint_noise(measurement_covariance, k)[:-2, :-2])
            You leave out the last landmark. range(k) already ends at k - 1.
        one by one: + for i in range(k):
            +     rows, R = slice(2 * i, 2 * i + 2), joint_noise(measurement_covariance, k)
            +     state, covariance = update_landmarks(state, covariance, [i], measurements[rows], R[rows, rows])
            + return state, covariance
            You call update_landmarks once for each landmark, so each is linearised at a state that the previous one has changed. Make one call with all indices.
        one by one with R as given: + for i in range(k):
            +     pair = measurements[2 * i : 2 * i + 2]
            +     state, covariance = update_landmarks(state, covariance, [i], pair, measurement_covariance)
            + return state, covariance
            You call update_landmarks once for each landmark and give each call the whole measurement_covariance. Make one call with all indices, all measurements and the whole measurement_covariance.
        a number for the indices: list(range(k)) => k
            You pass k, the number of landmarks. update_landmarks needs a list of their indices, from 0 to k - 1.
        backwards: list(range(k)) => list(range(k - 1, -1, -1))
            Your indices run backwards. The first pair of measurements belongs to landmark 0.
        indices from 1: list(range(k)) => list(range(1, k + 1))
            An index is too large. The landmarks are numbered from 0 to k - 1, so the indices are range(k).
        arguments that do not fit: + raise ValueError
            update_landmarks cannot use your arguments. The indices of all k landmarks are range(k), from 0 to k - 1. Pass the other arguments of update as they are, in the order of the first line of update_landmarks.
        no update: + return state, covariance
            You return the state and covariance unchanged. Call update_landmarks and return its result.
    """),
    alternatives={
        "information form": _all_of(_by_information),
        "Cholesky factor": _all_of(_by_roots),
        "Joseph form": _all_of(_joseph),
    },
    equivalents={
        "return update_landmarks(state, covariance, range(k), measurements, measurement_covariance)": "the same numbers"
    },
)


# --- 7.6 evaluate_landmarks ---
def _by_cholesky(estimates: Any, covariances: Any, truth: Any) -> Any:
    errors = np.subtract(estimates, truth)
    scaled = np.linalg.solve(np.linalg.cholesky(covariances), errors[..., None])[..., 0]
    return np.linalg.norm(errors, axis=1), np.linalg.norm(scaled, axis=1)


def _by_einsum(estimates: Array, covariances: Array, truth: Array) -> Any:
    errors = estimates - truth
    squares = np.einsum("ki,kij,kj->k", errors, np.linalg.inv(covariances), errors)
    return [np.sqrt((errors**2).sum(axis=1)), squares**0.5]


def _by_scipy(estimates: Array, covariances: Array, truth: Array) -> Any:
    weighed = [mahalanobis(*each) for each in zip(estimates, truth, np.linalg.inv(covariances), strict=True)]
    return list(map(math.dist, estimates, truth)), weighed


def _map_case(rng: np.random.Generator, k: int, name: str = "") -> Case:
    truth = rng.uniform(-4, 4, (k, 2))
    estimates = truth + rng.normal(0, 0.3, (k, 2))
    covariances = np.array([random_covariance(rng, 2, scale=float(rng.uniform(0.1, 0.4))) for _ in range(k)])
    return Case((estimates, covariances, truth), name)


def _maps_public() -> list[Case]:
    truth = np.array([[3.0, 6.0], [7.0, 8.0]])
    axes = (truth + [[0.2, 0.0], [0.0, 0.2]], np.array([np.diag([0.04, 0.01])] * 2), truth)
    along = np.array([[[0.09, 0.06], [0.06, 0.09]]] * 2)
    tilted = (np.array([[0.3, 0.3], [0.3, -0.3]]), along, np.zeros((2, 2)))
    return [
        Case(axes, "errors of 20 cm, with standard deviations of 20 cm and 10 cm"),
        Case(tilted, "the same error along an ellipse and across it"),
        _map_case(np.random.default_rng(76), 6, "six landmarks"),
    ]


EVALUATE_LANDMARKS = Exercise(
    name="evaluate_landmarks",
    points=1,
    stars=2,
    public=_maps_public,
    hidden=lambda rng: [_map_case(rng, k) for k in (1, 3, 6, 8)],
    comparison=Close(atol=1e-8, names=("your Euclidean distance", "your Mahalanobis distance")),
    hints=(
        "The square of the second distance is lesson 06's NEES, computed for each landmark with its own covariance.",
        "For one landmark it is the square root of error @ np.linalg.solve(covariance, error). Loop over the landmarks.",
    ),
    sibling=Sibling(
        "Each item has a matrix of its own, so the quadratic form is computed item by item, and a length is computed row by row: here the energy and the speed of three bodies.",
        """
        import numpy as np

        speeds = np.array([[1.0, 2.0], [0.0, 3.0], [2.0, -1.0]])
        masses = np.array([np.eye(2), [[2.0, 0.5], [0.5, 1.0]], np.diag([4.0, 1.0])])
        energies = [v @ M @ v / 2 for v, M in zip(speeds, masses)]
        print(np.round(energies, 2), np.linalg.norm(speeds, axis=1).round(2))
        """,
        "[2.5 4.5 8.5] [2.24 3.   2.24]",
    ),
    mistakes=catalogue("""
        the homework's: error @ np.linalg.solve(P, error) => error @ P @ error
            You multiply by the covariance, as the homework does: sqrt(dᵀ P d) grows when the filter is less certain. The Mahalanobis distance uses the inverse of P.
        the root of each entry of P: error @ np.linalg.solve(P, error) => np.sum(np.linalg.solve(np.sqrt(P), error) ** 2)
            np.sqrt(P) takes the root of each entry, which is not the root of the matrix. Use d @ np.linalg.solve(P, d), or L = np.linalg.cholesky(P) and np.linalg.solve(L, d).
        the root of each entry of the inverse: error @ np.linalg.solve(P, error) => np.sum((np.sqrt(np.linalg.inv(P)) @ error) ** 2)
            np.sqrt takes the root of each entry of the inverse, and negative entries have none. Take the root at the end: the square root of d @ np.linalg.inv(P) @ d.
        standard deviations in the quadratic form: error @ np.linalg.solve(P, error) => error @ np.linalg.solve(np.sqrt(P), error)
            You use np.sqrt(P) in dᵀ P⁻¹ d. The covariance itself is needed there; only the result gets a square root.
        L without its inverse: error @ np.linalg.solve(P, error) => np.sum((np.linalg.cholesky(P) @ error) ** 2)
            You multiply the error by L (or by roots of P), so the distance grows with the uncertainty. Solve instead: the distance is the length of np.linalg.solve(L, d), where P = L Lᵀ.
        L transposed: error @ np.linalg.solve(P, error) => np.sum(np.linalg.solve(np.linalg.cholesky(P).T, error) ** 2)
            You solve with Lᵀ. P = L Lᵀ, so the distance is the length of np.linalg.solve(L, d).
        the root of each entry for L: error @ np.linalg.solve(P, error) => np.sum((np.sqrt(P) @ error) ** 2)
            You multiply the error by np.sqrt(P), the roots of the entries of P. The Mahalanobis distance uses the inverse of the matrix P.
        no root: np.sqrt(squares) => np.array(squares)
            Your second distance is squared. Take its square root, so that 1 means one standard deviation.
        diagonal only: error @ np.linalg.solve(P, error) => np.sum(error**2 / np.diag(P))
            You use only the diagonal of the covariance. In a tilted ellipse an error along the long axis counts less than one across it, so use the whole matrix.
        standard deviations for variances: error @ np.linalg.solve(P, error) => np.sum((error / np.diag(P)) ** 2)
            You divide an error by its variance. Divide it by the standard deviation, which is the square root of the variance; better, use np.linalg.solve with the whole matrix.
        each entry's inverse: error @ np.linalg.solve(P, error) => abs(error @ (1 / np.where(P == 0, np.inf, P)) @ error)
            You invert each entry of P. The inverse of a matrix is a different matrix: use np.linalg.solve(P, d).
        each entry's inverse, also of 0: error @ np.linalg.solve(P, error) => error @ np.divide(1.0, P) @ error
            1 / P inverts each entry of P, and an entry of 0 becomes infinite. The inverse of a matrix is a different matrix: use np.linalg.solve(P, d).
        all errors as one matrix: squares = [error @ np.linalg.solve(P, error) for error, P in zip(errors, covariances, strict=True)] => squares = (errors * np.linalg.solve(covariances, errors)).sum(axis=1)
            np.linalg.solve(covariances, errors) treats the errors of all landmarks as one matrix. Solve for each landmark on its own, in a loop.
        each with each: squares = [error @ np.linalg.solve(P, error) for error, P in zip(errors, covariances, strict=True)] => squares = errors @ np.linalg.inv(covariances) @ errors.T
            You multiply the errors of all landmarks with each covariance, which gives (k, k, k) numbers. Compute d @ np.linalg.inv(P) @ d for one landmark at a time, in a loop.
        the diagonal of a stack: squares = [error @ np.linalg.solve(P, error) for error, P in zip(errors, covariances, strict=True)] => squares = np.diag(errors @ np.linalg.inv(covariances) @ errors.T)
            np.diag needs one matrix, but np.linalg.inv(covariances) is a stack of k matrices. Compute d @ np.linalg.inv(P) @ d for one landmark at a time, in a loop.
        matrices of one number: error @ np.linalg.solve(P, error) => error[None] @ np.linalg.solve(P, error[:, None])
            Each of your Mahalanobis distances is a matrix of one number, because you use d as a row and as a column. With a one-dimensional d, d @ np.linalg.solve(P, d) is a number.
        rows of one number: error @ np.linalg.solve(P, error) => error[None] @ np.linalg.solve(P, error)
            Each of your Mahalanobis distances is a row of one number. With a one-dimensional d, d @ np.linalg.solve(P, d) is a number.
        the first covariance for all: np.linalg.solve(P, error) => np.linalg.solve(covariances[0], error)
            You use the covariance of the first landmark for all of them. Each landmark has its own, covariances[i].
        truth added: errors = estimates - truth => errors = estimates + truth
            You add the truth. The error is the estimate minus the truth.
        means: np.hypot(errors[:, 0], errors[:, 1]), np.sqrt(squares) => np.hypot(errors[:, 0], errors[:, 1]).mean(), np.sqrt(squares).mean()
            You return means over the map. Return the two distances of each landmark.
        mean of the squares: np.hypot(errors[:, 0], errors[:, 1]) => np.sqrt((errors**2).mean(axis=1))
            You take the mean of the two squares. The Euclidean distance is the square root of their sum.
        unweighed: error @ np.linalg.solve(P, error) => error @ error
            Your two distances are equal, because the second does not use the covariance.
        squared metres: np.hypot(errors[:, 0], errors[:, 1]) => (errors**2).sum(axis=1)
            Your Euclidean distance is squared. Take its square root.
        sum of both axes: np.hypot(errors[:, 0], errors[:, 1]) => np.abs(errors).sum(axis=1)
            You add the absolute errors in x and y. The Euclidean distance is the square root of the sum of their squares.
        over the landmarks: np.hypot(errors[:, 0], errors[:, 1]) => np.sqrt((errors**2).sum(axis=0))
            You sum over the landmarks and return a value for x and one for y. Each landmark needs one distance, so sum along axis 1.
        one distance for the map: np.hypot(errors[:, 0], errors[:, 1]) => np.linalg.norm(errors)
            Your Euclidean distance is one number for the whole map. Each landmark needs its own: np.linalg.norm(errors, axis=1).
        one number for the map in both: np.hypot(errors[:, 0], errors[:, 1]), np.sqrt(squares) => np.linalg.norm(errors), np.sqrt(sum(squares))
            Both of your distances are one number for the whole map. Each landmark needs its own two: loop over the landmarks, or use np.linalg.norm(errors, axis=1) for the first.
        one norm repeated: np.hypot(errors[:, 0], errors[:, 1]) => np.full(len(errors), np.linalg.norm(errors))
            Your Euclidean distance is the same for all landmarks, because np.linalg.norm(errors) takes all entries of the matrix together. Use errors[i], or axis=1.
        swapped: np.hypot(errors[:, 0], errors[:, 1]), np.sqrt(squares) => np.sqrt(squares), np.hypot(errors[:, 0], errors[:, 1])
            You return the two results in the wrong order. The Euclidean distances come first.
    """),
    alternatives={"Cholesky": _by_cholesky, "np.einsum": _by_einsum, "SciPy's": _by_scipy},
    equivalents={
        "errors = truth - estimates": "the sign of the error does not matter",
        **{
            f"squares = [error @ np.linalg.solve(P, error) for error, P in zip(errors, covariances{strict})]": "both are equally long"
            for strict in ("", ", strict=False")
        },
        "squares = [np.linalg.solve(P, error) @ error for error, P in zip(errors, covariances, strict=True)]": "the scalar product is commutative",
        "return (np.hypot(errors[:, 1], errors[:, 0]), np.sqrt(squares))": "a sum of squares is commutative",
    },
)


# --- 7.7 add_landmark ---
def _added_by_one_jacobian(state: Array, P: Array, z: Array, R: Array) -> Any:
    n, (position, by_pose, by_z) = len(state), landmark_place(state, z)
    J = block_diag(np.eye(n), by_z)
    J[n:, :3] = by_pose
    return np.append(state, position), J @ block_diag(P, R) @ J.T


def _added_in_place(state: Array, P: Array, z: Array, R: Array) -> Any:
    n, (position, by_pose, by_z) = len(state), landmark_place(state, z)
    larger = np.pad(P, (0, 2))
    larger[n:] = by_pose @ larger[:3]
    larger[:, n:] = larger[:, :3] @ by_pose.T
    larger[n:, n:] += by_z @ R @ by_z.T
    return [[*state, *position], larger]


def _added_by_differences(state: Array, P: Array, z: Array, R: Array) -> Any:
    def grown(values: Array) -> Array:
        return np.append(values[:-2], landmark_place(values, values[-2:])[0])

    both = np.append(state, z)
    J = by_differences(grown, both)
    return grown(both), J @ block_diag(P, R) @ J.T


def _new_case(rng: np.random.Generator, k: int, name: str = "", pose: Any = None) -> Case:
    at = random_pose(rng) if pose is None else np.array(pose, dtype=float)
    state = np.concatenate([at, around(rng, at, k).ravel()])
    z = np.array([rng.uniform(-3, 3), rng.uniform(0.7, 4)])
    return Case((state, random_covariance(rng, 3 + 2 * k), z, random_covariance(rng, 2, scale=0.08)), name)


def _new_public() -> list[Case]:
    rng = np.random.default_rng(77)
    start = (np.zeros(3), np.zeros((3, 3)), np.array([0.5, 2.0]), np.diag([0.0007, 0.01]))
    simple = (np.zeros(3), np.diag([0.01, 0.02, 0.04]), np.array([0.0, 2.0]), np.diag([0.01, 0.09]))
    return [
        Case(start, "the first landmark, from the origin and without uncertainty"),
        Case(simple, "a landmark 2 m ahead of an uncertain pose"),
        _new_case(rng, 0, "the first landmark, from an uncertain pose elsewhere", (1.0, -1.0, 0.8)),
        _new_case(rng, 1, "a second landmark", (0.5, 2.0, -1.3)),
        _new_case(rng, 3, "a fourth landmark", (-1.0, 0.5, 2.2)),
    ]


ADD_LANDMARK = Exercise(
    name="add_landmark",
    points=5,
    stars=3,
    uses=("05:landmark_position", "05:landmark_jacobians"),
    public=_new_public,
    hidden=lambda rng: [_new_case(rng, k) for k in (0, 1, 2, 3, 5)],
    comparison=Each((Close(atol=1e-8), Close(atol=1e-8)), names=STATE),
    hints=(
        "Write the error of the new state as one matrix times the errors of the old state and of the measurement. Then propagate their covariance through this matrix, as in lesson 05.",
        "The error of the new landmark is J_p times the error of the pose plus J_z times the noise. The top rows of the matrix are an identity and zeros, because the old state does not change; the last two rows are J_p, zeros for the other landmarks, and J_z.",
    ),
    sibling=Sibling(
        "A new number that is computed from the old ones and a new error has a row in a matrix that keeps the old ones: one product gives its variance and all its covariances.",
        """
        import numpy as np

        P, reading = np.array([[0.04, 0.01], [0.01, 0.09]]), 0.02  # width and height
        T = np.array([
            [1.0, 0.0, 0.0],  # the width stays
            [0.0, 1.0, 0.0],  # the height stays
            [2.0, 2.0, 1.0],  # perimeter = 2 width + 2 height + an error of its own
        ])
        errors = np.zeros((3, 3))
        errors[:2, :2], errors[2, 2] = P, reading
        print((T @ errors @ T.T).round(3))
        """,
        """
        [[0.04 0.01 0.1 ]
         [0.01 0.09 0.2 ]
         [0.1  0.2  0.62]]
        """,
    ),
    mistakes=catalogue("""
        the homework's: cross = covariance[:, :3] @ by_pose.T => cross = np.zeros((len(state), 2))
            You use J_z R J_zᵀ and zeros beside it, as init_landmarks does. A landmark that is added from an uncertain pose inherits the error of the pose: include J_p in its own covariance and in the covariances with the rest of the state.
        no pose part
            own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T => own = by_measurement @ measurement_covariance @ by_measurement.T
            Your covariances with the old state are correct, but the landmark's own covariance is too small. It also contains the uncertainty of the pose, J_p P_pp J_pᵀ.
        no covariance with the rest
            own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T => own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T
            + cross = 0 * cross
            The landmark's own covariance is correct, but its covariances with the old state are zero. If the pose is wrong, the new landmark is wrong in the same way, so it is correlated with the pose and with everything that is correlated with the pose.
        with the pose only
            own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T => own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T
            + cross[3:] = 0
            You compute the covariance with the pose but leave zeros with the other landmarks. They are correlated with the pose, so they are correlated with the new landmark: use all rows of P[:, :3].
        without J_p beside the diagonal: by_pose @ cross[:3] => by_pose @ covariance[:3, :3] @ by_pose.T
            + cross = covariance[:, :2]
            You use the covariances of the pose's x and y with the old state. An error of the heading moves the landmark, too: multiply P[:, :3] by J_pᵀ.
        a large variance: own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T => own = 100 * np.eye(2)
            + cross = 0 * cross
            You give the landmark a large variance. Its covariance follows from the pose and the measurement: propagate both errors into x and y of the landmark.
        J_p and J_z exchanged: by_pose, by_measurement = landmark_jacobians => by_measurement, by_pose = landmark_jacobians
            Two shapes do not fit. Either a block is on the wrong side: in np.block([[P, A], [B, C]]) the block A has n rows and two columns, P[:, :3] J_pᵀ, and B = A.T has two rows, J_p P[:3]. Or you exchanged J_p (2, 3), which landmark_jacobians returns first, and J_z (2, 2).
        J_p on all of P: + if len(state) > 3:
            +     raise ValueError
            The shapes do not fit as soon as there is a landmark. J_p has three columns, for the pose's rows of P: use J_p P[:3] and P[:, :3] J_pᵀ, and J_p P[:3, :3] J_pᵀ in the landmark's own block.
        one Jacobian, not transposed: + n = len(state)
            + J, both = np.eye(n + 2), np.zeros((n + 2, n + 2))
            + J[n:, :3], J[n:, n:] = landmark_jacobians(state[:3], measurement)
            + both[:n, :n], both[n:, n:] = covariance, measurement_covariance
            + return np.append(state, landmark_position(state[:3], measurement)), J @ both @ J
            You multiply by J from the right. The last factor is Jᵀ.
        one Jacobian, transposed on the left: + n = len(state)
            + J, both = np.eye(n + 2), np.zeros((n + 2, n + 2))
            + J[n:, :3], J[n:, n:] = landmark_jacobians(state[:3], measurement)
            + both[:n, :n], both[n:, n:] = covariance, measurement_covariance
            + return np.append(state, landmark_position(state[:3], measurement)), J.T @ both @ J
            You transpose J on the left. The errors of the new state are J e, so their covariance is J P Jᵀ.
        not at the end: np.append(state, position) => np.concatenate([state[:3], position, state[3:]])
            You insert the landmark behind the pose. Append it at the end of the state.
        in front: np.append(state, position) => np.append(position, state)
            You put the new landmark in front of the pose. Append it at the end, so that all old values keep their places.
        in front, with its covariance: np.append(state, position) => np.append(position, state)
            np.block([[covariance, cross], [cross.T, own]]) => np.block([[own, cross.T], [cross, covariance]])
            You put the new landmark in front of the pose, in the state and in its covariance. Append it at the end of both, so that all old values keep their places.
        covariance kept: np.block([[covariance, cross], [cross.T, own]]) => covariance
            You return the old covariance. The new landmark needs two more rows and columns.
        only variances of the pose: cross = covariance[:, :3] @ by_pose.T => cross = covariance[:, :3] @ by_pose.T
            by_pose @ cross[:3] => by_pose @ np.diag(np.diag(covariance[:3, :3])) @ by_pose.T
            In the landmark's own covariance you use only the variances of the pose. Its x, y and heading are correlated, so use all of covariance[:3, :3].
        one side only: [cross.T, own] => [0 * cross.T, own]
            Your covariance is not symmetric. The block below the diagonal is the transpose of the block above it.
        below the diagonal only: [covariance, cross] => [covariance, 0 * cross]
            Your covariance is not symmetric: the last two columns of the old rows are still zero. They are the transpose of the block below the diagonal.
        sign
            own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T => own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T
            + cross = -cross
            Your covariances with the old state have the wrong sign. A pose that is too far to the left puts the landmark too far to the left.
        raw R: by_measurement @ measurement_covariance @ by_measurement.T => measurement_covariance
            You add R, the covariance of bearing and range. The covariance of x and y is J_z R J_zᵀ.
        J_z transposed: by_measurement @ measurement_covariance @ by_measurement.T => by_measurement.T @ measurement_covariance @ by_measurement
            You compute J_zᵀ R J_z. The columns of J_z belong to bearing and range, so the product is J_z R J_zᵀ.
        no noise: cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T => cross[:3]
            Your landmark's covariance lacks the noise of the measurement. Add J_z R J_zᵀ.
        no noise and zeros beside it: cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T => cross[:3]
            + cross = 0 * cross
            Two parts are missing. The landmark's own covariance lacks the noise of the measurement, J_z R J_zᵀ. And its covariances with the old state are not zero, because it inherits the error of the pose.
        heading left out
            by_pose, by_measurement = landmark_jacobians(state[:3], measurement) => by_pose, by_measurement = landmark_jacobians(state[:3], measurement)
            + by_pose = by_pose * (1, 1, 0)
            You leave out the uncertainty of the heading. At 3 m, an error of 5 degrees moves the landmark by 26 cm: use all three columns of J_p.
        noise beside the diagonal
            own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T => own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T
            + cross[:2] += by_measurement @ measurement_covariance @ by_measurement.T
            You add the measurement's noise to the covariances with the pose. The noise is independent of the pose's error, so it belongs to the landmark's own block only.
        in the robot frame: landmark_position(state[:3], => landmark_position(np.zeros(3),
            landmark_jacobians(state[:3], => landmark_jacobians(np.zeros(3),
            Your landmark is in the robot's frame. The map needs it in the field frame: landmark_position(pose, measurement).
        bearing and range kept: position = landmark_position(state[:3], measurement) => position = measurement
            You append bearing and range. The state contains x and y of each landmark, so use landmark_position.
    """),
    alternatives={
        "one Jacobian of all": _added_by_one_jacobian,
        "a larger matrix, filled": _added_in_place,
        "central differences": _added_by_differences,
    },
    equivalents={
        f"by_pose, by_measurement = landmark_jacobians(state[{longer}], measurement)": "landmark_jacobians reads only the first three numbers"
        for longer in (":4", ":")
    },
)


# --- 7.8 invariant_update ---
def _linear_update(state: Array, P: Array, indices: Sequence[int], z: Array, R: Array) -> tuple[Array, Array]:
    """Return the correction of a textbook's update, and its covariance."""
    pairs = [(i, measurement_jacobians(state[:3], state[3 + 2 * i : 5 + 2 * i])) for i in indices]
    H = np.zeros((2 * len(pairs), len(state)))
    for j, (i, (by_pose, by_landmark)) in enumerate(pairs):
        H[2 * j : 2 * j + 2, :3], H[2 * j : 2 * j + 2, 3 + 2 * i : 5 + 2 * i] = by_pose, by_landmark
    innovation = z - np.concatenate([expected(state[:3], state[3 + 2 * i : 5 + 2 * i]) for i in indices])
    innovation[::2] = wrap_angle(innovation[::2])
    gain = P @ H.T @ np.linalg.inv(H @ P @ H.T + joint_noise(R, len(pairs)))
    return gain @ innovation, P - gain @ H @ P


def _coordinates(state: Array) -> Array:
    """Return T, which converts an error on the group to the error of the state."""
    T = np.eye(len(state))
    T[:, 2] = rotation_direction(state)
    return T


def _invariant_by_exponential(state: Array, P: Array, indices: Any, z: Array, R: Array) -> Any:
    correction, P = _linear_update(state, P, indices, z, R)
    xi = np.linalg.solve(_coordinates(state), correction)
    size = 2 + (len(state) - 1) // 2
    algebra, element = np.zeros((size, size)), np.eye(size)
    algebra[:2, :2] = xi[2] * np.array([[0, -1], [1, 0]])
    algebra[:2, 2:] = np.delete(xi, 2).reshape(-1, 2).T
    element[:2, 2:] = np.delete(state, 2).reshape(-1, 2).T
    moved = np.insert((expm(algebra) @ element)[:2, 2:].T.ravel(), 2, wrap_angle(state[2] + xi[2]))
    back = np.linalg.inv(_coordinates(state))
    T = _coordinates(moved)
    covariance = T @ (back @ P @ back.T) @ T.T
    return moved, (covariance + covariance.T) / 2


def _invariant_by_matrices(state: Array, P: Array, indices: Any, z: Array, R: Array) -> Any:
    correction, P = _linear_update(state, P, indices, z, R)
    V = np.sinc(correction[2] / 2 / np.pi) * rotation_2d(correction[2] / 2)
    shifts = np.delete(correction, 2).reshape(-1, 2) @ V.T
    moved = shifted(state, np.insert(shifts.ravel(), 2, correction[2]))
    A = _coordinates(moved) @ np.linalg.inv(_coordinates(state))
    covariance = A @ P @ A.T
    return moved, (covariance + covariance.T) / 2


def _invariant_by_point(state: Array, P: Array, indices: Any, z: Array, R: Array) -> Any:
    correction, P = _linear_update(state, P, indices, z, R)
    turn = correction[2]
    a, b = np.sinc(turn / np.pi), turn / 2 * np.sinc(turn / 2 / np.pi) ** 2
    moved, A = shifted(state, correction), np.eye(len(state))
    for i in (0, *range(3, len(state), 2)):
        x, y = correction[i : i + 2]
        dx, dy = a * x - b * y, b * x + a * y
        moved[i : i + 2] = state[i] + dx, state[i + 1] + dy
        A[i : i + 2, 2] = -dy, dx
    covariance = A @ P @ A.T
    return moved, (covariance + covariance.T) / 2


def _turned_case(
    rng: np.random.Generator,
    k: int,
    indices: list[int],
    name: str = "",
    turn: float = 0.5,
    heading: float | None = None,
) -> Case:
    """Return a case whose update turns the heading by about `turn`, from a random heading if none is given."""
    pose = random_pose(rng)
    pose[2] = pose[2] if heading is None else heading
    state = np.concatenate([pose, around(rng, pose, k).ravel()])
    true = state + np.linalg.cholesky(P := random_covariance(rng, len(state))) @ rng.normal(
        0, 0.5, len(state)
    )
    true[2] = state[2] + turn
    seen = np.concatenate([expected(true[:3], true[3 + 2 * i : 5 + 2 * i]) for i in indices])
    return Case((state, P, indices, seen, random_covariance(rng, 2, scale=0.06)), name)


def _unmoved_case(pose: Array, distance: float, name: str = "") -> Case:
    """Return a case whose measurement is exactly as expected: the correction of the heading is 0."""
    state = np.append(pose, [pose[0] + distance, pose[1]])
    P = np.diag([0.01, 0.01, 0.04, 0.03, 0.01])
    return Case((state, P, [0], np.array([0.0, distance]), np.diag([0.01, 0.01])), name)


def _turned_public() -> list[Case]:
    rng = np.random.default_rng(78)
    ahead = (np.array([0.0, 0.0, 0.0, 2.0, 0.0]), np.diag([0.01, 0.01, 0.04, 0.03, 0.01]), [0])
    return [
        Case(
            (*ahead, np.array([0.6, 2.0]), np.diag([0.01, 0.01])),
            "a landmark 2 m ahead of a robot at the origin",
        ),
        _turned_case(rng, 1, [0], "one landmark, from elsewhere"),
        _turned_case(rng, 3, [2, 0], "two of three landmarks", -0.6),
        _turned_case(rng, 4, [1, 3, 2], "three of four landmarks", 0.8),
        _unmoved_case(np.zeros(3), 2.0, "a measurement as expected"),
    ]


def _turned_hidden(rng: np.random.Generator) -> list[Case]:
    drawn = ((1, [0], 0.5), (2, [1], -0.7), (3, [2, 0], 0.4), (5, [4, 1, 0], -0.5), (4, [0, 1, 2, 3], 0.8))
    cases = [_turned_case(rng, k, indices, turn=turn) for k, indices, turn in drawn]
    return [
        *cases,
        _turned_case(rng, 2, [0, 1], turn=0.7, heading=2.9),
        _unmoved_case(np.array([1.0, 2.0, 0.0]), 3.0),
    ]


INVARIANT_UPDATE = Exercise(
    name="invariant_update",
    points=0,
    stars=3,
    uses=("warp2pi", "update_landmarks"),
    public=_turned_public,
    hidden=_turned_hidden,
    comparison=All((Each((Close(atol=1e-7), Close(atol=1e-8)), names=STATE), Property(keeps_rotation))),
    hints=(
        "Call update_landmarks first. The difference of both states is the correction; wrap its heading, and leave the heading of the new state as it is. V turns the other corrections by half of the heading's correction and shortens them.",
        "A is the identity, but its third column also contains N at the new state minus N at the old state: (-dy, dx) for each point that moved by (dx, dy), and 0 for the heading.",
    ),
    sibling=Sibling(
        "A point on a turning wheel moves along an arc, so its first-order displacement has to be turned by half of the angle and shortened: here a point at a radius of 2 m.",
        """
        import numpy as np

        radius, angle = 2.0, 0.8
        tangent = radius * angle  # to first order the point moves straight up
        chord = tangent * np.sin(angle / 2) / (angle / 2)
        direction = np.pi / 2 + angle / 2
        print(np.round([radius + chord * np.cos(direction), chord * np.sin(direction)], 3))
        print(np.round([radius * np.cos(angle), radius * np.sin(angle)], 3))
        """,
        """
        [1.393 1.435]
        [1.393 1.435]
        """,
    ),
    mistakes=catalogue("""
        plain update: + return update_landmarks(state, covariance, indices, measurements, measurement_covariance)
            You return the result of update_landmarks, which is the usual filter. Apply its correction by equation 7.12, and move its covariance to the new state.
        heading not wrapped: warp2pi(updated[2] - state[2]) => updated[2] - state[2]
            Your correction of the heading is off by a full turn if the heading crosses pi. Wrap it with warp2pi.
        the covariance before: updated, covariance = update_landmarks => updated, _ = update_landmarks
            You move the covariance from before the update. A belongs on both sides of the covariance that update_landmarks returns.
        A of the plain update: (1j * shifts) => (1j * (shifts / (np.sinc(turn / (2 * np.pi)) * np.exp(0.5j * turn))))
            You evaluate T at the result of update_landmarks. Evaluate it at your own new state.
        heading kept: updated[points] = state[points] + shifts.view(float) => updated[points] = state[points] + shifts.view(float)
            + updated[2] = state[2]
            Your heading is not corrected. Only points are multiplied by V; the heading has the full correction.
        xi for delta: (updated - state)[points].view(complex) => ((updated - state)[points].view(complex) - 1j * turn * state[points].view(complex))
            You apply V to xi = T⁻¹ delta. In equation 7.12 it is applied to delta, the correction of update_landmarks.
        N of the pose alone: change[points] = (1j * shifts).view(float) => change[points] = (1j * shifts).view(float)
            + change[3:] = 0
            The third column of your T has no landmarks. N contains (-y, x) of the robot and of each landmark.
        covariance not moved: return updated, covariance + (added + added.T) => return updated, covariance
            Your state is right, but your covariance still belongs to the errors at the old state. Multiply it by A, and by the transpose of A. If you do, compute T(s) before you overwrite the state.
        points not turned: * np.exp(0.5j * turn) =>
            You shorten the corrections but do not turn them. V also rotates by half of the heading's correction.
        whole turn: np.exp(0.5j * turn) => np.exp(1j * turn)
            You turn the corrections by the heading's whole correction. V rotates by half of it.
        turned back: np.exp(0.5j * turn) => np.exp(-0.5j * turn)
            You turn the corrections in the wrong direction. A positive correction of the heading turns points to the left.
        not shortened: * np.sinc(turn / (2 * np.pi)) =>
            You turn the corrections but do not shorten them. A chord is shorter than its arc: multiply by sin(a / 2) / (a / 2).
        NumPy's sinc: np.sinc(turn / (2 * np.pi)) => np.sinc(turn / 2)
            You shorten the corrections too much. np.sinc(x) is sin(pi x) / (pi x), so divide its argument by pi.
        V left out: * np.sinc(turn / (2 * np.pi)) * np.exp(0.5j * turn) =>
            You move the points by the correction of update_landmarks. Multiply the correction of each point by V, because a point moves along an arc.
        change reversed: 1j * shifts => -1j * shifts
            The third column of A has the wrong sign. A point that moves by (dx, dy) changes N by (-dy, dx).
        one side only: covariance + (added + added.T) => covariance + np.outer(change, covariance[2])
            You multiply by A on one side only. The covariance of A e is A P Aᵀ.
        one side only, then symmetric: covariance + (added + added.T) => covariance + (np.outer(change, covariance[2]) + np.outer(covariance[2], change)) / 2
            You multiply by A on one side only, and the symmetric part of A P is not A P Aᵀ, the covariance of A e.
        A transposed: change[points] = (1j * shifts).view(float) => change[points] = (1j * shifts).view(float)
            + A = np.eye(len(state))
            + A[2] += change
            + return updated, A @ covariance @ A.T
            Your A is transposed. N is the third column of T, not its third row, and A is on the left: A P Aᵀ.
        A inverted on the right: change[points] = (1j * shifts).view(float) => change[points] = (1j * shifts).view(float)
            + A = np.eye(len(state))
            + A[:, 2] += change
            + covariance = A @ covariance @ np.linalg.inv(A)
            + return updated, (covariance + covariance.T) / 2
            You multiply by the inverse of A on the right. The covariance of A e is A P Aᵀ, with the transpose.
        T of the new state alone: change[points] = (1j * shifts).view(float) => change[points] = (1j * updated[points].view(complex)).view(float)
            Your A is T(s⁺) alone. First T(s)⁻¹ converts the error at the old state to ξ: A = T(s⁺) T(s)⁻¹.
        T of the old state alone: change[points] = (1j * shifts).view(float) => change[points] = (-1j * state[points].view(complex)).view(float)
            Your covariance is the covariance of ξ. T(s⁺) converts it to the error of the new state: A = T(s⁺) T(s)⁻¹.
        N of the map alone: change[points] = (1j * shifts).view(float) => change[points] = (1j * shifts).view(float)
            + change[:2] = 0
            The third column of your T has no (-y, x) of the robot. N contains them of the robot and of each landmark.
        N without the turn: (1j * shifts) => (-shifts.conj())
            The third column of your T contains (-x, y). N contains (-y, x) of each point.
        N from the robot: (1j * shifts) => (1j * (shifts - shifts[0]))
            Your N contains points relative to the robot. The map rotates about the origin of the map frame, so N contains (-y, x) of each point there.
        robot not turned: * np.exp(0.5j * turn) => * np.exp(0.5j * turn)
            + shifts[0] = complex(*(updated - state)[:2])
            Your robot's position has the correction of update_landmarks. It is a point, too: multiply its correction by V.
        map not turned: * np.exp(0.5j * turn) => * np.exp(0.5j * turn)
            + shifts[1:] = (updated - state)[3:].view(complex)
            Your landmarks have the correction of update_landmarks. Multiply the correction of each landmark by V, as the robot's.
        last landmark not turned: * np.exp(0.5j * turn) => * np.exp(0.5j * turn)
            + shifts[-1] = complex(*(updated - state)[-2:])
            Your last landmark has the correction of update_landmarks. range(3, len(state), 2) counts all landmarks.
        unseen landmarks not turned: * np.exp(0.5j * turn) => * np.exp(0.5j * turn)
            + unseen = np.delete(np.arange(len(shifts)), [0, *np.add(indices, 1)])
            + shifts[unseen] = (updated - state)[points].view(complex)[unseen]
            Your landmarks that were not measured have the correction of update_landmarks. Multiply the correction of every point of the state by V.
        map rotated twice: * np.exp(0.5j * turn) => * np.exp(0.5j * turn) + (np.exp(1j * turn) - 1) * state[points].view(complex)
            You rotate each point and add V delta. The rotation is already part of delta: add V delta to the point as it was.
        correction twice: * np.exp(0.5j * turn) => * np.exp(0.5j * turn) + (updated - state)[points].view(complex)
            You add V delta to the result of update_landmarks, which already contains delta. Add it to the state before the update.
        correction reversed: warp2pi(updated[2] - state[2]) => warp2pi(state[2] - updated[2])
            (updated - state)[points] => (state - updated)[points]
            Your delta has the wrong sign. It is the result of update_landmarks minus the state before.
        heading too large: updated[points] = state[points] + shifts.view(float) => updated[points] = state[points] + shifts.view(float)
            + updated[2] = state[2] + turn
            Your new heading is not between -pi and pi. Wrap it with warp2pi.
        V of the heading: warp2pi(updated[2] - state[2]) => state[2]
            You evaluate V at the robot's heading. Evaluate it at the correction of the heading.
        whole sine: np.sinc(turn / (2 * np.pi)) => np.sinc(turn / np.pi)
            Your factor is sin(a) / a. It contains half of the heading's correction: sin(a / 2) / (a / 2).
        half as long: np.sinc(turn / (2 * np.pi)) => np.sinc(turn / (2 * np.pi)) / 2
            Your corrections are half as long as they should be. Divide sin(a / 2) by a / 2, not by a.
        zero by zero: np.sinc(turn / (2 * np.pi)) => np.sin(turn / 2) / (turn / 2)
            Your factor is 0 / 0 if the heading has no correction. Its limit is 1: np.sinc(a / 2 / np.pi) computes it.
        variance of the heading left out: covariance[2] + covariance[2, 2] / 2 * change => covariance[2]
            Your covariance lacks the product of both changes. A P Aᵀ has four terms, and one of them contains the variance of the heading.
        variance of the heading twice: covariance[2, 2] / 2 * change => covariance[2, 2] * change
            You count the variance of the heading twice. In A P Aᵀ the product of both changes occurs once.
    """),
    alternatives={
        "the exponential of the group": _invariant_by_exponential,
        "matrices": _invariant_by_matrices,
        "point by point": _invariant_by_point,
    },
)


PLAN = LessonPlan(
    exercises=[
        WARP2PI,
        INIT_LANDMARKS,
        PREDICT,
        UPDATE_LANDMARKS,
        UPDATE,
        EVALUATE_LANDMARKS,
        ADD_LANDMARK,
        INVARIANT_UPDATE,
    ],
    questions=[
        Question(
            "which_block",
            "The filter with one bug computed its covariance after a motion of 1 m. Which part of it differs from the covariance of the samples?",
            {
                "The pose's own 3 x 3 block.": "Its largest difference is 0.02, and 20,000 samples scatter by that much. The filter treats the motion and its noise correctly here.",
                "The landmarks' block, everything but the first three rows and columns.": "Its largest difference is 0.02, and 20,000 samples scatter by that much. Landmarks do not move, and the filter leaves their block as it is.",
                "The first three rows and columns without the pose's own block: the covariance between pose and map.": "There the difference reaches 0.67, in units of both standard deviations. So the filter's prediction is wrong for the covariance between pose and map.",
                "All of it, a little.": "Small differences are everywhere, because 20,000 samples scatter by up to 0.02. Look for a part where the difference is much larger.",
            },
            "The first three rows and columns without the pose's own block: the covariance between pose and map.",
        ),
        Question(
            "why_correlated",
            "Two landmarks are on opposite sides of the field, and no measurement involves both. Why do their errors become correlated?",
            {
                "They are measured with the same sensor, so their noise is correlated.": "The noise of each measurement is independent: R has blocks on its diagonal and zeros elsewhere, and the correlations appear all the same.",
                "H is dense, so it mixes all landmarks.": "H is sparse. Each row has non-zero entries for the pose and for one landmark only.",
                "Both were measured from an uncertain pose, and an error of the pose shifts both.": "They share the error of the pose. An update with one landmark corrects the pose, and P_lp H_pᵀ in the gain then corrects the other landmark, too.",
                "A motion adds the same noise to both.": "A motion adds no noise to landmarks: P_ll stays as it is. It only changes the covariance between pose and map.",
            },
            "Both were measured from an uncertain pose, and an error of the pose shifts both.",
        ),
        Question(
            "constant_time",
            "A robot has mapped 1,000 landmarks and sees one of them. Which of the report's ideas makes the time of an update independent of the 1,000 without changing the result?",
            {
                "Update only what is in range.": "The landmark in view is correlated with all the others, so P - K H P changes all four million entries, even if only one landmark is in view.",
                "Forget landmarks that are uncertain or old.": "A smaller map is faster, but it also loses what the removed landmarks contributed. The result is different.",
                "Use local maps: update the neighbourhood, and update the rest once, when the robot leaves it.": "This is the compressed filter. It accumulates the matrix by which the rest must be multiplied and applies it once, so the result is the same up to rounding.",
                "Find matches with a KD-tree.": "A KD-tree makes the search for a match faster. The update itself takes as long as before.",
            },
            "Use local maps: update the neighbourhood, and update the rest once, when the robot leaves it.",
        ),
    ],
    written=[
        Written(
            "explain_inside",
            points=2,
            question="Every true landmark lies inside its ellipse. Why does it not follow that the covariances are correct? Give the two mean distances of your personal robot as an example.",
            rubric="1 point: an ellipse that is too large contains every true landmark, so this observation cannot exclude a covariance that is too large. 1 point: what a correct covariance would show: errors of the stated size, a mean Mahalanobis distance of about 1.25 (or a mean NEES of 2), about one landmark in twenty outside its 95 % ellipse; here the distance is about 0.07. Subtract half a point if the two numbers of the personal robot are missing.",
            numbers=personal_numbers,
        )
    ],
)
