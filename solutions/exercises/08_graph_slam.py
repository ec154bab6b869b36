"""Lesson 08, Graph SLAM: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg
import scipy.sparse
import scipy.sparse.csgraph
import scipy.sparse.linalg

from nao_course.exercises import Case, Close, Exercise, LessonPlan, Mistake, Question, Written
from nao_course.lessons.graph_slam.drivers import SolvedOrNamed

Array = npt.NDArray[Any]
Pair = tuple[Array, Array]
DRIVER = "nao_course.lessons.graph_slam.drivers:solution_or_unheld"
BOTH = Close(rtol=1e-6, atol=1e-9, names=("your omega", "your xi"))


# --- systems to try things on ---


def linked(size: int, links: Sequence[tuple[int, int, float, float]], starts: dict[int, float]) -> Pair:
    """A system of links (first, second, difference, epsilon) and starts (variable: position)."""
    omega = np.zeros((size, size))
    xi = omega.sum(axis=0)
    for variable, position in starts.items():
        omega[variable, variable] += 1.0
        xi[variable] += position
    for first, second, difference, epsilon in links:
        row = np.zeros(size)
        row[first], row[second] = -1.0, 1.0
        omega += np.outer(row, row) / epsilon
        xi += row * difference / epsilon
    return omega, xi


def any_system(rng: np.random.Generator, size: int) -> Pair:
    """A system that something has been added to already: every entry counts."""
    half = rng.normal(0.0, 2.0, (size, size))
    return half + half.T, rng.normal(0.0, 5.0, size)


def a_drive(
    rng: np.random.Generator, poses: int, landmarks: int, epsilons: tuple[float, float] = (0.25, 4.0)
) -> list[tuple[int, int, float, float]]:
    """Links of a drive along an axis: motions, and landmarks each seen from some poses."""
    at = np.cumsum(rng.normal(1.0, 0.7, poses))
    places = rng.uniform(at.min(), at.max(), landmarks)
    everything = np.concatenate([at, places])
    pairs = [(step - 1, step) for step in range(1, poses)]
    for number in range(landmarks):
        seen_from = rng.choice(poses, size=int(rng.integers(1, min(poses, 4) + 1)), replace=False)
        pairs += [(int(pose), poses + number) for pose in seen_from]
    return [
        (i, j, float(everything[j] - everything[i] + rng.normal(0, 0.3)), float(rng.uniform(*epsilons)))
        for i, j in pairs
    ]


def a_solved_drive(rng: np.random.Generator, poses: int, landmarks: int) -> Pair:
    """The system of a drive whose start is held."""
    return linked(poses + landmarks, a_drive(rng, poses, landmarks), {0: float(rng.normal(0, 3))})


# --- 8.1 add_initial_position ---


def _start(weight: float = 1.0, sign: float = 1.0) -> Callable[..., Pair]:
    def function(omega: Any, xi: Any, index: int, position: float) -> Pair:
        omega, xi = (np.array(each, dtype=float) for each in (omega, xi))
        omega[index, index] += weight
        xi[index] += sign * position
        return omega, xi

    return function


def _start_assigned(omega: Any, xi: Any, index: int, position: float) -> Pair:
    omega, xi = np.array(omega), np.array(xi)
    omega[index, index] = 1
    xi[index] = position
    return omega, xi


def _start_assigned_xi(omega: Any, xi: Any, index: int, position: float) -> Pair:
    omega, xi = np.array(omega), np.array(xi)
    omega[index, index] += 1
    xi[index] = position
    return omega, xi


def _start_row(omega: Any, xi: Any, index: int, position: float) -> Pair:
    omega, xi = np.array(omega), np.array(xi)
    omega[index] += 1
    xi[index] += position
    return omega, xi


def _start_position_twice(omega: Any, xi: Any, index: int, position: float) -> Pair:
    omega, xi = np.array(omega), np.array(xi)
    omega[index, index] += position
    xi[index] += position
    return omega, xi


def _start_first(omega: Any, xi: Any, index: int, position: float) -> Pair:
    return _start()(omega, xi, 0, position)


def _start_weight_in_xi(omega: Any, xi: Any, index: int, position: float) -> Pair:
    return _start()(omega, xi, index, position)[0], _start()(omega, xi, index, 1.0)[1]


def _start_everywhere(omega: Any, xi: Any, index: int, position: float) -> Pair:
    return omega + np.eye(len(xi)), _start()(omega, xi, index, position)[1]


def _start_swapped(omega: Any, xi: Any, index: int, position: float) -> Any:
    return _start()(omega, xi, index, position)[::-1]


def _start_in_place(omega: Any, xi: Any, index: int, position: float) -> Pair:
    omega[index, index] += 1
    xi[index] += position
    return omega, xi


def _start_outer(omega: Any, xi: Any, index: int, position: float) -> Pair:
    row = np.eye(len(xi))[index]
    return omega + np.outer(row, row), xi + row * position


def _start_where(omega: Any, xi: Any, index: int, position: float) -> Any:
    here = np.arange(len(xi)) == index
    return [
        np.where(here & here[:, None], np.asarray(omega) + 1, omega),
        np.where(here, np.asarray(xi) + position, xi),
    ]


def _start_lists(omega: Any, xi: Any, index: int, position: float) -> Any:
    rows, right = np.asarray(omega).tolist(), list(xi)
    rows[index][index] += 1
    right[index] += position
    return np.array(rows, dtype=np.float64), np.array(right)


def _start_public() -> list[Case]:
    rng = np.random.default_rng(81)
    return [
        Case((np.zeros((3, 3)), np.zeros(3), 0, 2.5), "an empty system"),
        Case((*any_system(rng, 4), 2, -3.0), "a system that holds something already"),
        Case((*any_system(rng, 3), 1, 0.0), "a start at 0"),
    ]


def _start_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case((*any_system(rng, size), int(rng.integers(size)), float(rng.normal(0, 5))))
        for size in (1, 3, 5, 8)
    ]


ADD_INITIAL_POSITION = Exercise(
    name="add_initial_position",
    points=1,
    stars=1,
    public=_start_public,
    hidden=_start_hidden,
    comparison=BOTH,
    in_place=True,
    hints=(
        "A start says x = position: its row has one entry, on the diagonal. Two lines, after a copy of both arrays.",
        "omega.copy() and xi.copy() first; then omega[index, index] and xi[index] each get something added.",
    ),
    mistakes=[
        Mistake(
            "= for +=",
            _start_assigned,
            "You assign where you should add: what other constraints have put into this row is lost. It is += in both places.",
        ),
        Mistake(
            "= for += in xi",
            _start_assigned_xi,
            "Omega is right. In xi you assign the position and lose what is there: add it.",
        ),
        Mistake(
            "sign of xi",
            _start(sign=-1.0),
            "Your map starts at minus the position: xi gets plus the position.",
        ),
        Mistake(
            "a whole row",
            _start_row,
            "omega[index] is a whole row. A start knows nothing of other variables: only omega[index, index] gets 1.",
        ),
        Mistake(
            "the position in omega",
            _start_position_twice,
            "Omega gets the weight, which is 1. The position belongs into xi only.",
        ),
        Mistake(
            "always the first",
            _start_first,
            "The start is that of the variable `index`, which need not be 0.",
        ),
        Mistake(
            "the weight in xi",
            _start_weight_in_xi,
            "Omega is right. xi gets the position, times the weight 1; you add the weight alone.",
        ),
        Mistake(
            "every variable",
            _start_everywhere,
            "You hold every variable. Only the one with the number `index` has a known position.",
        ),
        Mistake("xi first", _start_swapped, "Return omega first, then xi."),
        Mistake(
            "in place",
            _start_in_place,
            "+= wrote into the arrays that you were given. Begin with omega, xi = omega.copy(), xi.copy().",
        ),
    ],
    alternatives={"an outer product": _start_outer, "np.where": _start_where, "lists": _start_lists},
)


# --- 8.2 add_relative_motion and 8.3 add_relative_measurement ---


def _link(**changed: Any) -> Callable[..., Pair]:
    """The four additions and the two, with something changed."""

    def function(omega: Any, xi: Any, first: int, second: int, value: float, epsilon: float = 1.0) -> Pair:
        omega, xi = (np.array(each, dtype=float) for each in (omega, xi))
        if changed.get("sorted") and first > second:
            first, second = second, first
        if changed.get("next"):
            second = first + 1
        if changed.get("forwards"):
            value = abs(value)
        weight = changed.get("weight", lambda each: 1 / each)(epsilon)
        of_xi = changed.get("weight_of_xi", lambda each: weight)(epsilon)
        off = changed.get("off", -1.0) * weight
        if changed.get("assigned"):
            omega[first, first] = omega[second, second] = weight
            omega[first, second] = omega[second, first] = off
            xi[first], xi[second] = -of_xi * value, of_xi * value
            return omega, xi
        omega[first, first] += weight * changed.get("diagonal_first", 1.0)
        omega[second, second] += weight
        omega[first, second] += off * changed.get("upper", 1.0)
        omega[second, first] += off * changed.get("lower", 1.0)
        signs = changed.get("signs", (-1.0, 1.0))
        if changed.get("xi_assigned"):
            xi[first], xi[second] = -of_xi * value, of_xi * value
            return omega, xi
        xi[first] += signs[0] * of_xi * value
        xi[second] += signs[1] * of_xi * value
        return omega, xi

    return function


def _link_off_assigned(
    omega: Any, xi: Any, first: int, second: int, value: float, epsilon: float = 1.0
) -> Pair:
    after, right = _link()(omega, xi, first, second, value, epsilon)
    after[first, second] = after[second, first] = -1 / epsilon
    return after, right


def _link_in_place(omega: Any, xi: Any, first: int, second: int, value: float, epsilon: float = 1.0) -> Pair:
    omega[:], xi[:] = _link()(omega, xi, first, second, value, epsilon)
    return omega, xi


def _link_swapped_answer(
    omega: Any, xi: Any, first: int, second: int, value: float, epsilon: float = 1.0
) -> Any:
    return _link()(omega, xi, first, second, value, epsilon)[::-1]


def _link_outer(omega: Any, xi: Any, first: int, second: int, value: float, epsilon: float = 1.0) -> Pair:
    row = np.eye(len(xi))[second] - np.eye(len(xi))[first]
    return omega + np.outer(row, row) / epsilon, xi + row * value / epsilon


def _link_blocks(omega: Any, xi: Any, first: int, second: int, value: float, epsilon: float = 1.0) -> Any:
    omega, xi, both = np.array(omega), np.array(xi), np.array([first, second])
    omega[np.ix_(both, both)] += np.array([[1, -1], [-1, 1]]) / epsilon
    xi[both] += np.array([-value, value]) / epsilon
    return [omega, xi]


def _link_whitened(omega: Any, xi: Any, first: int, second: int, value: float, epsilon: float = 1.0) -> Pair:
    row = np.zeros((1, len(xi)))
    row[0, [first, second]] = np.array([-1, 1]) / np.sqrt(epsilon)
    return omega + row.T @ row, xi + (row.T * (value / np.sqrt(epsilon)))[:, 0]


def _link_mistakes(value: str, first: str, second: str) -> list[Mistake]:
    """What both kinds of link have in common, in each one's own words."""
    return [
        Mistake(
            "sign of xi",
            _link(signs=(1.0, -1.0)),
            f"Omega is right and xi has the wrong signs: xi[{first}] loses the {value}, xi[{second}] gets it.",
        ),
        Mistake(
            "only one row of xi",
            _link(signs=(0.0, 1.0)),
            f"Both rows of xi get something: the paper's second equation, with the minus, belongs to xi[{first}].",
        ),
        Mistake(
            "both plus in xi",
            _link(signs=(1.0, 1.0)),
            f"Both of your entries of xi have a plus. In the row of {first} the {value} has a minus.",
        ),
        Mistake(
            "= for +=",
            _link(assigned=True),
            "You assign where you should add: a variable has many constraints, and all but the last are lost. It is += "
            "and -= everywhere.",
        ),
        Mistake(
            "= for += in xi",
            _link(xi_assigned=True),
            "Omega is right. In xi you assign and lose what is there: add.",
        ),
        Mistake(
            "= off the diagonal",
            _link_off_assigned,
            "On the diagonal you add, off it you assign: the same two variables may be linked a second time.",
        ),
        Mistake(
            "plus off the diagonal",
            _link(off=1.0),
            "Off the diagonal it is minus: the mixed term of the square has the other sign.",
        ),
        Mistake(
            "one entry off the diagonal",
            _link(lower=0.0),
            f"Omega must be symmetric: you add to omega[{first}, {second}] and not to omega[{second}, {first}].",
        ),
        Mistake(
            "nothing on one diagonal",
            _link(diagonal_first=0.0),
            f"omega[{first}, {first}] gets something, too: the square holds {first} as well as {second}.",
        ),
        Mistake(
            "one equation of two",
            _link(diagonal_first=0.0, upper=0.0, signs=(0.0, 1.0)),
            f"You add one equation, to the row of {second}. Its negative belongs to the row of {first}: both derivatives are 0.",
        ),
        Mistake(
            "the smaller number first",
            _link(sorted=True),
            f"You put the smaller number first. The {value} leads from {first} to {second}, whichever number is larger.",
        ),
        Mistake(
            "forwards only",
            _link(forwards=True),
            f"You take the size of the {value} and lose its sign: backwards it is negative.",
        ),
        Mistake(
            "epsilon for 1/epsilon",
            _link(weight=lambda each: each),
            "You multiply by epsilon: your worst values count most. The weight is 1 / epsilon.",
        ),
        Mistake(
            "1/epsilon squared",
            _link(weight=lambda each: 1 / each**2),
            "The weight is 1 / epsilon: epsilon is a variance, a square already. You square it once more.",
        ),
        Mistake(
            "1/root of epsilon",
            _link(weight=lambda each: 1 / np.sqrt(each)),
            "The weight is 1 / epsilon itself: epsilon is a variance, and no root of it is taken.",
        ),
        Mistake(
            "xi without its weight",
            _link(weight_of_xi=lambda each: 1.0),
            f"Omega is right. In xi the {value} needs the same weight, 1 / epsilon: both sides of an equation are multiplied.",
        ),
        Mistake(
            "epsilon not used",
            _link(weight=lambda each: 1.0),
            "Right for epsilon = 1, and the same for every other: all that you add has the factor 1 / epsilon.",
        ),
        Mistake(
            "sign of xi and epsilon",
            _link(weight=lambda each: each, signs=(1.0, -1.0)),
            f"Two things. The signs of xi are exchanged: xi[{first}] loses the {value}, xi[{second}] gets it. And the weight is "
            "1 / epsilon, not epsilon.",
        ),
        Mistake("xi first", _link_swapped_answer, "Return omega first, and xi behind it."),
        Mistake(
            "in place",
            _link_in_place,
            "You wrote into the arrays that you were given. Work on omega.copy() and xi.copy().",
        ),
    ]


_LINK_ALTERNATIVES = {
    "a row and its outer product": _link_outer,
    "a block of two by two": _link_blocks,
    "a row divided by the deviation": _link_whitened,
}


def _motion_public() -> list[Case]:
    rng = np.random.default_rng(82)
    return [
        Case((np.zeros((3, 3)), np.zeros(3), 0, 1, 10.0), "the paper's ten steps, no epsilon given"),
        Case((*any_system(rng, 4), 1, 2, 5.0, 0.25), "a system that holds something already"),
        Case((*any_system(rng, 4), 0, 3, -2.0, 4.0), "backwards, and not to the next variable"),
        Case((*any_system(rng, 3), 2, 0, 1.5, 0.5), "the later pose stands first"),
    ]


def _link_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for size in (2, 4, 6, 9):
        first, second = (int(each) for each in rng.choice(size, 2, replace=False))
        given = (first, second, float(rng.normal(0, 4)), float(rng.uniform(0.1, 0.7)))
        cases.append(Case((*any_system(rng, size), *given)))
    cases.append(Case((*any_system(rng, 3), 0, 2, float(rng.normal(0, 4)))))
    cases.append(Case((*any_system(rng, 5), 3, 1, float(rng.normal(0, 4)), float(rng.uniform(2, 9)))))
    return cases


ADD_RELATIVE_MOTION = Exercise(
    name="add_relative_motion",
    points=2,
    stars=1,
    public=_motion_public,
    hidden=_link_hidden,
    comparison=BOTH,
    in_place=True,
    hints=(
        "Equation 8.2, entry by entry: four places in a copy of omega and two in a copy of xi. Take weight = 1 / epsilon first.",
        "Diagonal: omega[before, before] and omega[after, after] get the weight. Off it, omega[before, after] and omega[after, before] "
        "lose it. xi[before] loses weight * motion, xi[after] gets it.",
    ),
    mistakes=[
        *_link_mistakes("motion", "before", "after"),
        Mistake(
            "the next variable",
            _link(next=True),
            "You take the variable behind `before`. The pose afterwards is `after`, whatever its number.",
        ),
    ],
    alternatives=_LINK_ALTERNATIVES,
)


def _measured_position(
    omega: Any, xi: Any, pose: int, landmark: int, offset: float, epsilon: float = 1.0
) -> Pair:
    omega, xi = np.array(omega), np.array(xi)
    omega[landmark, landmark] += 1 / epsilon
    xi[landmark] += offset / epsilon
    return omega, xi


def _measured_and_held(
    omega: Any, xi: Any, pose: int, landmark: int, offset: float, epsilon: float = 1.0
) -> Pair:
    return _start()(*_link()(omega, xi, pose, landmark, offset, epsilon), landmark, offset)


def _measurement_public() -> list[Case]:
    rng = np.random.default_rng(83)
    return [
        Case((np.zeros((3, 3)), np.zeros(3), 0, 2, 9.0), "the landmark nine steps ahead, no epsilon given"),
        Case((*any_system(rng, 5), 1, 4, -5.0, 0.25), "a landmark behind the robot"),
        Case((*any_system(rng, 5), 2, 3, 2.0, 4.0), "a system that holds something already"),
        Case((*any_system(rng, 4), 3, 0, 1.5, 0.5), "the landmark stands first"),
    ]


ADD_RELATIVE_MEASUREMENT = Exercise(
    name="add_relative_measurement",
    points=2,
    stars=1,
    uses=("add_relative_motion",),
    public=_measurement_public,
    hidden=_link_hidden,
    comparison=BOTH,
    in_place=True,
    hints=(
        "Which equation does the measurement give? landmark - pose = offset. Have you written that one before, with other names?",
        "The pose is where you are before, the landmark where you would be after a motion of `offset`: one call is enough.",
    ),
    mistakes=[
        *_link_mistakes("offset", "pose", "landmark"),
        Mistake(
            "a start besides",
            _measured_and_held,
            "The link is right. Besides, you hold the landmark at `offset`, as if that were its position: leave that out.",
        ),
        Mistake(
            "a position",
            _measured_position,
            "You say that the landmark is at `offset`. It is `offset` from the pose, so the pose's row and column get something, too.",
        ),
    ],
    alternatives=_LINK_ALTERNATIVES,
)


# --- 8.4 solve ---


def unheld(omega: Any) -> list[int]:
    """Variables that hang together with no start."""
    links = scipy.sparse.csr_array(omega)
    count, part = scipy.sparse.csgraph.connected_components(links, directed=False)
    weight = np.bincount(part, np.asarray(links.sum(axis=1)).ravel(), count)
    diagonal = np.bincount(part, links.diagonal(), count)
    return [int(each) for each in np.flatnonzero((weight <= 1e-9 * diagonal)[part])]


def _refuse(numbers: Sequence[int]) -> None:
    if len(numbers):
        raise ValueError(f"nothing holds {', '.join(str(each) for each in numbers)}")


def _solve_parts(omega: Any, xi: Any) -> Array:
    _refuse(unheld(omega))
    return np.linalg.inv(omega) @ xi


def _solve_svd(omega: Any, xi: Any) -> Any:
    u, s, vt = np.linalg.svd(omega)
    free = s <= 1e-10 * s.max(initial=0.0)
    _refuse([number for number in range(len(xi)) if np.linalg.norm(vt[free, number]) > 1e-5])
    return (vt.T @ ((u.T @ xi) / s)).tolist()


def _solve_walking(omega: Any, xi: Any) -> Array:
    """From the variables with a start to all that they are linked with."""
    rows = np.abs(np.sum(omega, axis=1)) > 1e-9 * np.abs(omega).max()
    reached = rows
    for _ in range(len(xi)):
        reached = reached | (np.asarray(omega)[:, reached] != 0).any(axis=1)
    _refuse(np.flatnonzero(~reached).tolist())
    return np.asarray(scipy.linalg.cho_solve(scipy.linalg.cho_factor(omega), xi), dtype=np.float32)


def _solve_named_by(choose: Callable[[Any], Sequence[int]]) -> Callable[..., Any]:
    """Right where it can be solved; elsewhere it names what is chosen."""

    def function(omega: Any, xi: Any) -> Any:
        if unheld(omega):
            _refuse(choose(np.asarray(omega)))
            raise ValueError("the system is singular")
        return np.linalg.solve(omega, xi)

    return function


def _solve_with_another_error(omega: Any, xi: Any) -> Array:
    if loose := unheld(omega):
        raise RuntimeError(f"nothing holds {loose}")
    return np.linalg.solve(omega, xi)


def _solve_by_eigenvalues(is_zero: Callable[[Any], Any]) -> Callable[..., Array]:
    """Names what can move along the eigenvectors whose values are called 0."""

    def function(omega: Any, xi: Any) -> Array:
        values, vectors = np.linalg.eigh(omega)
        free = vectors[:, is_zero(values)]
        _refuse(np.flatnonzero(np.abs(free).max(axis=1, initial=0.0) > 1e-6).tolist())
        with np.errstate(divide="ignore", invalid="ignore"):  # where what is 0 was not called so
            return np.asarray(vectors @ (vectors.T @ xi / values))

    return function


def _solve_until_numpy_complains(omega: Any, xi: Any) -> Array:
    try:
        return np.linalg.solve(omega, xi)
    except np.linalg.LinAlgError:
        _refuse(unheld(omega))
        raise


def _summing_to_0(omega: Any) -> list[int]:
    """Parts whose entries sum to exactly 0."""
    count, part = scipy.sparse.csgraph.connected_components(scipy.sparse.csr_array(omega), directed=False)
    sums = np.bincount(part, np.asarray(omega.sum(axis=1)).ravel(), count)
    return [int(each) for each in np.flatnonzero((sums == 0)[part])]


def _without_constraint(omega: Any) -> list[int]:
    return [int(each) for each in np.flatnonzero(np.diag(omega) == 0)]


def _first_held(omega: Any, xi: Any) -> Array:
    """As if the first variable were 0, whatever the start says."""
    inner = np.linalg.lstsq(omega[1:, 1:], xi[1:], rcond=None)[0]
    return np.concatenate([[0.0], inner])


PAPER = linked(3, [(0, 1, 5.0, 1.0), (0, 2, 9.0, 1.0), (1, 2, 3.0, 1.0)], {0: 0.0})


def _solve_public() -> list[Case]:
    rng = np.random.default_rng(84)
    return [
        Case(PAPER, "the example of the text"),
        Case(a_solved_drive(rng, 5, 3), "a drive of five poses"),
        Case(linked(3, [(0, 1, 10.0, 1.0), (1, 2, 5.0, 2.0)], {}), "no start at all"),
        Case(linked(4, [(0, 1, 2.0, 1.0), (0, 2, 4.0, 0.5)], {0: 1.0}), "a landmark that nobody has seen"),
        Case(
            linked(6, [(0, 1, 2.0, 1.0), (1, 4, 3.0, 0.5), (2, 3, 1.0, 2.0), (3, 5, 1.0, 1.0)], {0: -4.0}),
            "two parts, one of them held",
        ),
        Case(linked(8, a_drive(rng, 6, 2, (2e4, 4e5)), {0: 100.0}), "a drive measured in millimetres"),
        # rounding leaves something here: no pivot, and no sum, is exactly 0
        Case(linked(9, a_drive(np.random.default_rng(841), 6, 3), {}), "a drive without a start"),
        Case(
            linked(8, a_drive(rng, 6, 2, (1e-8, 1e-7)), {}),
            "measured to a tenth of a millimetre, without a start",
        ),
        Case((np.zeros((2, 2)), np.zeros(2)), "nothing is known yet"),
    ]


def _in_parts(rng: np.random.Generator, size: int) -> Pair:
    """Two drives that know nothing of each other, of which one is held, with their variables mixed."""
    order = rng.permutation(2 * size)
    links = []
    for part in range(2):
        for i, j, difference, epsilon in a_drive(rng, size - 2, 2):
            links.append((int(order[part * size + i]), int(order[part * size + j]), difference, epsilon))
    return linked(2 * size, links, {int(order[0]): float(rng.normal(0, 3))})


def _apart(rng: np.random.Generator, parts: int) -> Pair:
    """Several drives that know nothing of each other, the first of which is held."""
    links = []
    for part in range(parts):
        for i, j, difference, epsilon in a_drive(rng, 5, 2):
            links.append((7 * part + i, 7 * part + j, difference, epsilon))
    return linked(7 * parts, links, {0: float(rng.normal(0, 3))})


def _solve_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        *(
            Case(a_solved_drive(rng, poses, landmarks))
            for poses, landmarks in ((1, 1), (4, 3), (12, 6), (40, 15))
        ),
        Case(linked(18, a_drive(rng, 12, 6, (1e-3, 1e2)), {0: 1.0, 3: 2.0})),
        *(Case(_in_parts(rng, size)) for size in (3, 5, 9)),
        Case(linked(int(rng.integers(3, 7)), [], {})),
        Case(linked(8, a_drive(rng, 4, 3), {0: float(rng.normal(0, 2))})),
        Case(linked(9, a_drive(rng, 6, 3, (5e-4, 1e-3)), {})),
        *(Case(linked(8, a_drive(rng, 6, 2, (2e4, 4e5)), {0: float(rng.normal(0, 100))})) for _ in range(2)),
        *(Case(linked(8, a_drive(rng, 6, 2, (1e-8, 1e-7)), {})) for _ in range(2)),
        Case(_apart(rng, 4)),
        Case(linked(60, a_drive(rng, 50, 10), {})),
    ]


_SOLVE_HINTS = (
    "np.linalg.solve does the first part. For the second, np.linalg.eigh(omega) gives eigenvalues, and a direction in each column of its second "
    "answer. Which columns count, and what does an entry of such a column say of its variable?",
    "values, vectors = np.linalg.eigh(omega): columns whose value is nearly 0 against the largest one (<=, for the largest may be 0 itself) are such "
    "directions. Each variable with an entry in one of them can be moved freely: name all of these, and raise ValueError.",
)

SOLVE = Exercise(
    name="solve",
    points=3,
    stars=2,
    public=_solve_public,
    hidden=_solve_hidden,
    comparison=SolvedOrNamed(),
    driver=DRIVER,
    hints=_SOLVE_HINTS,
    mistakes=[
        Mistake(
            "names nothing",
            _solve_named_by(lambda omega: []),
            'What can be solved is right. Where it cannot, the message names no variable: NumPy\'s "Singular matrix" does not say '
            "which ones. Find them, and put their numbers into the message of a ValueError.",
        ),
        Mistake(
            "another error",
            _solve_with_another_error,
            "You find out that the system cannot be solved. The error has to be a ValueError: whoever calls solve waits for that one.",
        ),
        Mistake(
            "least squares",
            lambda omega, xi: np.linalg.pinv(omega) @ xi,
            "lstsq and pinv answer even where nothing holds the map: they take the one of all answers that is shortest. Here that must be "
            "an error.",
        ),
        Mistake(
            "a little on the diagonal",
            lambda omega, xi: np.linalg.solve(omega + 1e-6 * np.eye(len(xi)), xi),
            "You make the matrix solvable by adding to its diagonal. That holds every variable at 0, a little, and hides what is missing.",
        ),
        Mistake(
            "only what NumPy notices",
            _solve_until_numpy_complains,
            "Here rounding leaves some 1e-16 where 0 should be, so neither NumPy's LinAlgError nor == 0 finds it, and x is one of all maps, wherever "
            "rounding put it. Before you solve, compare with a small part of the weights.",
        ),
        Mistake(
            "a fixed limit for 0",
            _solve_by_eigenvalues(lambda values: values < 1e-6),
            "You take for 0 what is below a fixed number. In millimetres all weights are as small as that: compare with the largest one.",
        ),
        Mistake(
            "a smaller fixed limit",
            _solve_by_eigenvalues(lambda values: np.abs(values) < 1e-12),
            "Your limit for 0 is a fixed number. With weights of 1e8 rounding alone is larger: compare with the largest one.",
        ),
        Mistake(
            "less than a part of nothing",
            _solve_by_eigenvalues(lambda values: values < 1e-9 * values.max()),
            "Where nothing is known yet, all of omega is 0, the largest eigenvalue as well, and none is less than a part of it: <= finds them.",
        ),
        Mistake(
            "only those without a constraint",
            _solve_named_by(_without_constraint),
            "You name the variables that have no constraint at all. A part that is linked in itself and has no start is loose as a whole: "
            "name all of it.",
        ),
        Mistake(
            "all variables",
            _solve_named_by(lambda omega: range(len(omega))),
            "You name every variable. Some are held: name those only that can be moved freely.",
        ),
        Mistake(
            "one of them",
            _solve_named_by(lambda omega: unheld(omega)[:1]),
            "You name one variable. A loose part moves as a whole: name all of its variables.",
        ),
        Mistake(
            "those that are held",
            _solve_named_by(lambda omega: sorted(set(range(len(omega))) - set(unheld(omega)))),
            "You name the variables that are held. The others are wanted.",
        ),
        Mistake(
            "a product",
            lambda omega, xi: omega @ xi,
            "That is omega @ xi. You look for the x with omega @ x = xi.",
        ),
        Mistake(
            "only the diagonal",
            lambda omega, xi: xi / np.where(np.diag(omega) == 0, 1, np.diag(omega)),
            "You divide by the diagonal, as if every variable stood alone. The rows belong together: solve the whole system.",
        ),
        Mistake(
            "the first at 0",
            _first_held,
            "You put the first variable at 0. Where the map starts is in omega and xi already, and need not be 0.",
        ),
    ],
    alternatives={
        "parts that hang together, and the inverse": _solve_parts,
        "singular values": _solve_svd,
        "a walk from the starts, and Cholesky, float32": _solve_walking,
    },
    equivalents={
        "loose = np.flatnonzero(np.linalg.norm(free, axis=1) >= 1e-06)": "no entry is exactly as large",
    },
)


# --- 8.5 marginalize ---


def _schur(**changed: Any) -> Callable[..., Pair]:
    """What is left of a system, with something done in another way."""

    def function(omega: Any, xi: Any, keep: Any) -> Pair:
        omega, xi = (np.array(each, dtype=float) for each in (omega, xi))
        kept = np.asarray(changed.get("order", lambda each: each)(list(keep)), dtype=int)
        gone = np.array([number for number in range(len(xi)) if number not in set(keep)], dtype=int)
        if changed.get("others"):
            kept, gone = gone, kept
        inside, between = omega[np.ix_(gone, gone)], omega[np.ix_(kept, gone)]
        inverse = changed.get("inverse", np.linalg.inv)(inside)
        sign, sign_of_xi = changed.get("signs", (-1.0, -1.0))
        return (
            omega[np.ix_(kept, kept)] + sign * between @ inverse @ between.T,
            xi[kept] + sign_of_xi * between @ inverse @ xi[gone],
        )

    return function


def _each_inverted(omega: Any, xi: Any, keep: Any) -> Pair:
    with np.errstate(all="ignore"):
        return _schur(inverse=lambda inside: 1 / inside)(omega, xi, keep)


def _schur_untransposed(omega: Any, xi: Any, keep: Any) -> Pair:
    gone = [number for number in range(len(xi)) if number not in keep]
    between, inverse = omega[np.ix_(keep, gone)], np.linalg.inv(omega[np.ix_(gone, gone)])
    return omega[np.ix_(keep, keep)] - between @ inverse @ between, xi[keep] - between @ inverse @ xi[gone]


def _cut_of_covariance(omega: Any, xi: Any, keep: Any) -> Pair:
    covariance = np.linalg.inv(omega)
    keep = list(keep)
    return covariance[np.ix_(keep, keep)], (covariance @ xi)[keep]


def _by_covariance(omega: Any, xi: Any, keep: Any) -> Pair:
    covariance, keep = np.linalg.inv(omega), list(keep)
    left = np.linalg.inv(covariance[np.ix_(keep, keep)])
    return left, left @ (covariance @ xi)[keep]


def _by_pseudo_inverse(omega: Any, xi: Any, keep: Any) -> Pair:
    covariance, keep = np.linalg.pinv(omega), list(keep)
    left = np.linalg.pinv(covariance[np.ix_(keep, keep)])
    return left, left @ (covariance @ xi)[keep]


def _one_by_one(omega: Any, xi: Any, keep: Any) -> Any:
    omega, xi = (np.array(each, dtype=float) for each in (omega, xi))
    for gone in sorted(set(range(len(xi))) - {int(each) for each in keep}):
        column, value, pivot = omega[:, gone].copy(), xi[gone], omega[gone, gone]
        omega -= np.outer(column, column) / pivot
        xi -= column * value / pivot
        omega[gone], omega[:, gone] = 0.0, 0.0
    keep = list(keep)
    return [omega[keep][:, keep], xi[keep]]


def _by_solving(omega: Any, xi: Any, keep: Any) -> Pair:
    omega, xi = np.asarray(omega), np.asarray(xi)
    gone = np.setdiff1d(np.arange(len(xi)), keep)
    rows = np.column_stack([omega[gone][:, keep], xi[gone]])
    rest = np.column_stack([omega[keep][:, keep], xi[keep]]) - omega[keep][:, gone] @ np.linalg.solve(
        omega[gone][:, gone], rows
    )
    return rest[:, :-1], rest[:, -1]


def _by_a_factor(omega: Any, xi: Any, keep: Any) -> Pair:
    """Half of the block, by Cholesky, on either side."""
    gone = [number for number in range(len(xi)) if number not in set(keep)]
    keep = list(keep)
    if not gone:
        return omega[np.ix_(keep, keep)], xi[keep]
    half = np.linalg.cholesky(omega[np.ix_(gone, gone)])
    across = np.linalg.solve(half, omega[np.ix_(gone, keep)])
    right = np.linalg.solve(half, xi[gone])
    return omega[np.ix_(keep, keep)] - across.T @ across, xi[keep] - across.T @ right


def _marginal_in_place(omega: Any, xi: Any, keep: Any) -> Pair:
    left, right = _schur()(omega, xi, keep)
    omega[:], xi[:] = 0.0, 0.0
    return left, right


def _in_order(rng: np.random.Generator, size: int, count: int) -> list[int]:
    return [int(each) for each in rng.choice(size, count, replace=False)]


def _marginal_public() -> list[Case]:
    rng = np.random.default_rng(85)
    return [
        Case((*PAPER, [0, 2]), "the example of the text without x1"),
        Case((*a_solved_drive(rng, 4, 3), [4, 5, 6]), "only the landmarks"),
        Case((*a_solved_drive(rng, 5, 2), [6, 0, 4]), "in another order"),
        Case((*a_solved_drive(rng, 3, 1), [0, 1, 2, 3]), "all of them"),
        Case(
            (
                *linked(4, [(0, 1, 5.0, 1.0), (0, 2, 9.0, 1.0), (1, 2, 3.0, 1.0), (2, 3, 1.0, 1.0)], {}),
                [0, 3],
            ),
            "no start yet: differences only",
        ),
    ]


def _marginal_hidden(rng: np.random.Generator) -> list[Case]:
    sizes = ((4, 3, 2), (6, 4, 4), (12, 6, 5), (3, 1, 1), (30, 10, 10), (5, 5, 9))
    cases = [
        Case((*a_solved_drive(rng, poses, marks), _in_order(rng, poses + marks, kept)))
        for poses, marks, kept in sizes
    ]
    loose = [
        Case((*linked(poses + 3, a_drive(rng, poses, 3), {}), _in_order(rng, poses + 3, 3)))
        for poses in (3, 8)
    ]
    return [*cases, *loose, Case((*a_solved_drive(rng, 3, 2), _in_order(rng, 5, 5)))]


MARGINALIZE = Exercise(
    name="marginalize",
    points=4,
    stars=3,
    public=_marginal_public,
    hidden=_marginal_hidden,
    comparison=Close(rtol=1e-5, atol=1e-7, names=("your omega", "your xi")),
    in_place=True,
    hints=(
        "Cut the system into blocks: np.ix_(keep, gone) picks rows and columns. Solve the lower block row for the variables that go, and put "
        "that into the upper one.",
        "gone has all numbers that are not in keep. With A = omega[keep, keep], B = omega[keep, gone], C = omega[gone, gone]: what is left is "
        "A - B C^-1 Bᵀ and xi[keep] - B C^-1 xi[gone]; np.linalg.solve(C, ...) is better than an inverse.",
    ),
    mistakes=[
        Mistake(
            "only cut out",
            _schur(signs=(0.0, 0.0)),
            "You cut rows and columns out and throw the rest away. That says that the variables which go are known to be 0; what they told about "
            "the others is lost.",
        ),
        Mistake(
            "cut out of the inverse",
            _cut_of_covariance,
            "That is the covariance and the answer of the variables that stay. Wanted is a system with that answer: omega and xi.",
        ),
        Mistake(
            "single entries",
            lambda omega, xi, keep: (omega[keep, keep], xi[keep]),
            "omega[keep, keep] picks single entries, those on the diagonal. A block is omega[np.ix_(keep, keep)]; and what the others told "
            "must be taken along.",
        ),
        Mistake(
            "no transpose",
            _schur_untransposed,
            "The last factor has the shape of the first, and must have the other one: transpose it. A - B C^-1 Bᵀ, where B is "
            "omega[np.ix_(keep, gone)].",
        ),
        Mistake(
            "the answer for xi",
            lambda omega, xi, keep: (_schur()(omega, xi, keep)[0], np.linalg.solve(omega, xi)[keep]),
            "Omega is right. What you return for xi is the answer x of the variables that stay; xi is the right side of their system.",
        ),
        Mistake(
            "by way of the covariance",
            _by_covariance,
            "You invert all of omega. That works where something holds every variable. Without a start omega has no inverse, and the differences "
            "can be handed on all the same: only the block of those that go is inverted.",
        ),
        Mistake(
            "by way of a pseudo-inverse",
            _by_pseudo_inverse,
            "Where something holds every variable yours is right. pinv of all of omega brings in a start that nobody gave: only the block of those "
            "that go is inverted.",
        ),
        Mistake(
            "the first ones",
            lambda omega, xi, keep: _schur()(omega, xi, list(range(len(keep)))),
            "You keep the first variables. `keep` may name any, in any order: np.ix_(keep, gone).",
        ),
        Mistake(
            "each entry inverted",
            _each_inverted,
            "1 / block divides by each entry, and most are 0. The inverse of a matrix is np.linalg.inv, or better np.linalg.solve.",
        ),
        Mistake(
            "plus in omega",
            _schur(signs=(1.0, -1.0)),
            "xi is right. In omega what you compute must be subtracted, too: whoever goes leaves less behind.",
        ),
        Mistake(
            "plus",
            _schur(signs=(1.0, 1.0)),
            "What you compute is added, and must be subtracted, in omega and in xi.",
        ),
        Mistake(
            "xi only cut out",
            _schur(signs=(-1.0, 0.0)),
            "Omega is right. xi loses something as well: those that go stand on the right side, too.",
        ),
        Mistake("plus in xi", _schur(signs=(-1.0, 1.0)), "Omega is right. In xi the sign is minus, too."),
        Mistake(
            "no inverse",
            _schur(inverse=lambda inside: np.eye(len(inside))),
            "The block between the variables that go is missing: it is B C^-1 Bᵀ, not B Bᵀ.",
        ),
        Mistake(
            "C for its inverse",
            _schur(inverse=lambda inside: inside),
            "You multiply by the block of the variables that go. It must be divided by: its inverse, or np.linalg.solve.",
        ),
        Mistake(
            "only the diagonal",
            _schur(inverse=lambda inside: np.diag(1 / np.diag(inside))),
            "You invert the diagonal of the block only. Variables that go are linked with each other: invert the whole block.",
        ),
        Mistake(
            "sorted",
            _schur(order=sorted),
            "The variables come back in the order of `keep`, and yours are sorted.",
        ),
        Mistake(
            "those that go", _schur(others=True), "`keep` are the variables that stay. You removed them."
        ),
        Mistake(
            "in place",
            _marginal_in_place,
            "The arrays that you were given have changed. Return new ones and leave them alone.",
        ),
    ],
    alternatives={
        "both sides solved at once": _by_solving,
        "one variable after the other": _one_by_one,
        "a Cholesky factor": _by_a_factor,
    },
)


# --- 8.6 solve_sparse ---


def _network(
    rng: np.random.Generator, poses: int, every: int, form: str, starts: int = 1, *, shuffled: bool = True
) -> tuple[Any, Array]:
    """A long corridor with a landmark every few poses, each seen from near by; its variables in any order, or poses first."""
    landmarks = poses // every
    first, second = [np.arange(poses - 1)], [np.arange(1, poses)]
    for away in range(1, 5):
        number = np.arange(landmarks)
        first.append(np.minimum(every * number + away * every // 2, poses - 1))
        second.append(poses + number)
    i, j = np.concatenate(first), np.concatenate(second)
    size, weight = poses + landmarks, 1 / rng.uniform(0.25, 4.0, len(i))
    order = rng.permutation(size) if shuffled else np.arange(size)
    i, j = order[i], order[j]
    truth = rng.normal(0.0, 5.0, size)
    right = weight * (truth[j] - truth[i] + rng.normal(0.0, 0.1, len(i)))
    held = order[rng.choice(poses, starts, replace=False)]
    rows = np.concatenate([i, j, i, j, held])
    columns = np.concatenate([i, j, j, i, held])
    values = np.concatenate([weight, weight, -weight, -weight, np.ones(starts)])
    omega = scipy.sparse.coo_array((values, (rows, columns)), shape=(size, size)).asformat(form)
    xi = np.bincount(j, right, size) - np.bincount(i, right, size)
    xi[held] += truth[held]
    return omega, xi


def _walk(rng: np.random.Generator, poses: int) -> tuple[Any, Array]:
    """Motions only, of which nothing is held."""
    weight = 1 / rng.uniform(0.25, 4.0, poses - 1)
    own = np.append(weight, 0.0) + np.append(0.0, weight)
    omega = scipy.sparse.diags_array([own, -weight, -weight], offsets=[0, 1, -1], format="csr")
    return omega, np.append(-weight, 0.0) + np.append(0.0, weight)


def _sparse(pair: Pair, form: str) -> tuple[Any, Array]:
    return scipy.sparse.csr_array(pair[0]).asformat(form), pair[1]


def _sparse_public() -> list[Case]:
    rng = np.random.default_rng(86)
    return [
        Case(_sparse(PAPER, "csc"), "the example of the text"),
        Case(_sparse(a_solved_drive(rng, 8, 4), "csr"), "a drive, as csr"),
        Case(_sparse(linked(3, [(0, 1, 10.0, 1.0), (1, 2, 5.0, 2.0)], {}), "csc"), "no start at all"),
        Case(
            _sparse(linked(6, [(0, 1, 2.0, 1.0), (1, 4, 3.0, 0.5), (2, 3, 1.0, 2.0)], {0: -4.0}), "csr"),
            "two parts, and a landmark that nobody has seen",
        ),
        Case(_network(rng, 1500, 5, "csr", 20), "1800 variables in any order"),
        Case(_walk(rng, 1100), "a walk of 1100 poses without a start"),
    ]


def _sparse_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case(_network(rng, 30_000, 5, "csr", 300)),
        Case(_network(rng, 16_000, 2, "csc", 160, shuffled=False)),  # as numbered, its factor is nearly full
        Case(_network(rng, 2_000, 4, "csc", 20)),
        Case(_network(rng, 300, 3, "coo")),
        Case(_walk(rng, 1500)),
        Case(_sparse(linked(8, a_drive(rng, 6, 2, (2e4, 4e5)), {0: float(rng.normal(0, 100))}), "csc")),
        Case(_sparse(linked(8, a_drive(rng, 6, 2, (1e-8, 1e-7)), {}), "csr")),
        Case(_sparse(a_solved_drive(rng, 12, 5), "csc")),
        *(Case(_sparse(_in_parts(rng, size), "csr")) for size in (3, 6)),
        Case(_sparse(linked(12, a_drive(rng, 6, 4), {0: float(rng.normal())}), "csc")),
        Case(_sparse(linked(30, a_drive(rng, 24, 6), {}), "csc")),
    ]


def _splu_naturally_named(omega: Any, xi: Any) -> Array:
    _refuse(unheld(omega))
    return np.asarray(scipy.sparse.linalg.spsolve(omega.tocsc(), xi))


def _banded(omega: Any, xi: Any) -> Array:
    _refuse(unheld(omega))
    omega = omega.tocsr()
    order = scipy.sparse.csgraph.reverse_cuthill_mckee(omega, symmetric_mode=True)
    near = omega[order][:, order].tocoo()
    width = int(np.abs(near.row - near.col).max(initial=0))
    bands = np.zeros((width + 1, len(xi)))
    lower = near.row >= near.col
    bands[near.row[lower] - near.col[lower], near.col[lower]] = near.data[lower]
    x = np.empty(len(xi))
    x[order] = scipy.linalg.solveh_banded(bands, xi[order], lower=True)
    return x


def _gradients(omega: Any, xi: Any) -> Any:
    _refuse(unheld(omega))
    scale = scipy.sparse.diags_array(1 / omega.diagonal())
    x, _ = scipy.sparse.linalg.cg(omega, xi, rtol=1e-12, atol=0.0, maxiter=20 * len(xi), M=scale)
    return x.tolist()


def _spsolve(omega: Any, xi: Any) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return scipy.sparse.linalg.spsolve(omega.tocsc(), xi)


def _dense(omega: Any, xi: Any) -> Any:
    return _solve_parts(omega.toarray(), xi)


def _early(omega: Any, xi: Any) -> Any:
    _refuse(unheld(omega))
    return scipy.sparse.linalg.cg(omega, xi, rtol=1e-3)[0]


def _with_info(omega: Any, xi: Any) -> Any:
    _refuse(unheld(omega))
    return scipy.sparse.linalg.cg(omega, xi, rtol=1e-10)


def _sparse_where_a_sum_is_0(omega: Any, xi: Any) -> Any:
    _refuse(_summing_to_0(omega))
    return _spsolve(omega, xi)


def _named_by_an_array(omega: Any, xi: Any) -> Any:
    if loose := unheld(omega):
        raise ValueError(f"nothing holds {np.array(loose)}")
    return _spsolve(omega, xi)


def _factored(omega: Any, xi: Any) -> Any:
    return scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi)


def _banded_unsorted(omega: Any, xi: Any) -> Any:
    _refuse(unheld(omega))
    omega = omega.tocsc()
    order = scipy.sparse.csgraph.reverse_cuthill_mckee(omega, symmetric_mode=True)
    return scipy.sparse.linalg.spsolve(omega[order][:, order], xi[order], permc_spec="NATURAL")


def _sparse_named_by(choose: Callable[[Any], Sequence[int]]) -> Callable[..., Any]:
    def function(omega: Any, xi: Any) -> Any:
        if unheld(omega):
            _refuse(choose(omega))
            raise ValueError("the factor is exactly singular")
        return scipy.sparse.linalg.spsolve(omega.tocsc(), xi)

    return function


SOLVE_SPARSE = Exercise(
    name="solve_sparse",
    points=4,
    stars=3,
    public=_sparse_public,
    hidden=_sparse_hidden,
    comparison=SolvedOrNamed(),
    driver=DRIVER,
    seconds=20.0,
    hints=(
        "Two parts. Solving: scipy.sparse.linalg.splu factors a csc matrix, and its permc_spec chooses the order; the documentation says which "
        "one is meant for symmetric patterns. Naming: which variables hang together? scipy.sparse.csgraph.connected_components knows.",
        "A link adds 0 to the sum of a row, a start adds 1. So a part that hangs together is held where its rows, all together, sum to more "
        'than rounding. For the order: splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A") works on the pattern of omega + omega\'.',
    ),
    mistakes=[
        Mistake(
            "dense",
            _dense,
            "You turn the sparse matrix into a dense one. That works for a hundred variables; 30,000 of them are 7 GB of zeros. Keep it sparse, "
            "and use what is in scipy.sparse.linalg.",
        ),
        Mistake(
            "dense, and names nothing",
            lambda omega, xi: np.linalg.solve(omega.toarray(), xi),
            "Two things. You make the matrix dense, which ends at a few thousand variables; and where nothing holds a part, its variables have to "
            "be named.",
        ),
        Mistake(
            "NumPy's solve",
            lambda omega, xi: np.linalg.solve(omega, xi),
            "np.linalg.solve does not know sparse matrices: to NumPy this one is a single object. Use what is in scipy.sparse.linalg.",
        ),
        Mistake(
            "spsolve alone",
            _spsolve,
            "What can be solved is right. Where it cannot, spsolve warns and gives NaN: find that out before, and raise a ValueError that names the "
            "variables.",
        ),
        Mistake(
            "names nothing",
            _sparse_named_by(lambda omega: []),
            "What can be solved is right. Where nothing holds a part, a ValueError has to name its variables, as in solve.",
        ),
        Mistake(
            "only those without a constraint",
            _sparse_named_by(lambda omega: [int(each) for each in np.flatnonzero(omega.diagonal() == 0)]),
            "You name variables without any constraint. A part that is linked in itself and has no start is loose, too.",
        ),
        Mistake(
            "all variables",
            _sparse_named_by(lambda omega: range(omega.shape[0])),
            "You name all variables. Those that hang together with a start are held.",
        ),
        Mistake(
            "all but one part",
            _sparse_named_by(lambda omega: _not_with_the_first(omega)),
            "You take one part for held, that of variable 0 or the largest. Held is what hangs together with a start, and there may be none.",
        ),
        Mistake(
            "a sum that is exactly 0",
            _sparse_where_a_sum_is_0,
            "You ask whether a sum of decimals == 0. Weights leave some 1e-16: compare with a small part of the weights.",
        ),
        Mistake(
            "numbers left out",
            _named_by_an_array,
            "NumPy writes a long array with ... in its middle, so your message lacks most of the numbers. Write a list: array.tolist().",
        ),
        Mistake(
            "what splu raises",
            _factored,
            "What can be solved is right. Where nothing holds a part, splu raises a RuntimeError that names nothing: find that out before, and "
            "raise a ValueError with the numbers.",
        ),
        Mistake(
            "not sorted back",
            _banded_unsorted,
            "You sort rows and columns for solving, and xi with them. x comes out in that order, too: x[order] = ... sorts it back.",
        ),
        Mistake(
            "stopped early",
            _early,
            "Your answers are near and not exact: an iterative solver stops at a tolerance, and its default is coarse.",
        ),
        Mistake(
            "the solver's report, too",
            _with_info,
            "cg returns two things, x and whether it came to an end. Return x only.",
        ),
        Mistake(
            "a little on the diagonal",
            lambda omega, xi: scipy.sparse.linalg.spsolve(
                (omega + 1e-6 * scipy.sparse.eye_array(len(xi))).tocsc(), xi
            ),
            "You add a little to the diagonal so that it can be solved. That holds every variable at 0 and hides what is missing.",
        ),
    ],
    alternatives={
        "spsolve": _splu_naturally_named,
        "a narrow band": _banded,
        "conjugate gradients": _gradients,
    },
    equivalents={
        "return scipy.sparse.linalg.splu(omega.tocsc()).solve(xi)": "scipy's own order is a good one, too",
        "return scipy.sparse.linalg.splu(omega, permc_spec='MMD_AT_PLUS_A').solve(xi)": "splu makes a csc matrix itself, and warns",
        "loose = np.flatnonzero(starts[part] <= 0.5)": "a number of starts is whole, but for rounding",
        "starts = np.bincount(part, np.ones(len(xi)) @ omega, count)": "omega is symmetric",
    },
)


def _not_with_the_first(omega: Any) -> list[int]:
    _, part = scipy.sparse.csgraph.connected_components(omega, directed=False)
    return [int(each) for each in np.flatnonzero(part != part[0])]


PLAN = LessonPlan(
    exercises=[
        ADD_INITIAL_POSITION,
        ADD_RELATIVE_MOTION,
        ADD_RELATIVE_MEASUREMENT,
        SOLVE,
        MARGINALIZE,
        SOLVE_SPARSE,
    ],
    questions=[
        Question(
            "why_minus",
            "Why does a motion put -1 at both places off the diagonal, and not only +10 and -10 into xi?",
            {
                "Because the robot could also walk backwards.": "A walk backwards is a negative motion: its sign stands in xi. The entries of "
                "Omega are the same for every motion.",
                "Because squaring the difference leaves a mixed term, and its derivative stands in both rows.": "Yes: the square of "
                "(after - before - motion) contains -2 after before. Its derivative by either pose holds the other one, with a minus.",
                "So that Omega can be inverted.": "It is the other way round: with the -1, each link's rows sum to 0, and without a start "
                "nothing can be inverted. Shifting the whole map changes no difference.",
            },
            "Because squaring the difference leaves a mixed term, and its derivative stands in both rows.",
        ),
        Question(
            "weight_of_the_start",
            "add_initial_position has the weight 1. What happens to the answer x if you give the only start the weight 100 instead?",
            {
                "The poses near the start move a little towards it.": "They would, if something pulled the start away. But nothing else says where "
                "the map is, so the start's own error is 0 with any weight.",
                "Nothing.": "All other constraints speak of differences, so the whole map can be shifted until the start's error is 0. "
                "The covariance does change: with the weight 1 the whole map is only known to one unit.",
                "The map becomes smaller.": "Sizes are made of differences, and the start says nothing about those.",
            },
            "Nothing.",
        ),
        Question(
            "zero_in_omega",
            "Two landmarks have a 0 in Omega, and a correlation of 0.8 in its inverse. Is one of them wrong?",
            {
                "Yes: a 0 means that they are independent, so the correlation must be 0.": "The 0 says that they are independent once all other "
                "variables are known. Nobody knows the poses, and both landmarks were measured from them.",
                "No: no constraint links them, but both hang on the same poses.": "Omega lists direct links; the inverse counts every way "
                "from one to the other.",
                "It cannot be told without the measurements.": "Omega holds all that the measurements say about that. The values are not needed.",
            },
            "No: no constraint links them, but both hang on the same poses.",
        ),
    ],
    written=[
        Written(
            "explain_filling",
            points=2,
            question="Why does removing the poses fill the landmarks' block, and what has that to do with the filter of lesson 07?",
            rubric="1 point: a pose that is removed leaves links between all landmarks that were measured from it, and along the motions also "
            "between those of different poses, so at the end everything is linked with everything. 1 point: the filter keeps only the last pose and "
            "the landmarks, so it removes every older pose; its matrix is therefore full, and each of its updates costs the square of their number.",
        )
    ],
)
