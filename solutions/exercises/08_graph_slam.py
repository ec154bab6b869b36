"""Exercises of lesson 08, Graph SLAM, with typical mistakes and alternative solutions."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.linalg
import scipy.sparse
import scipy.sparse.csgraph
import scipy.sparse.linalg

from nao_course.exercises import Case, Close, Exercise, LessonPlan, Mistake, Question, Sibling, Written
from nao_course.instructor.authoring.mistakes import Change, catalogue
from nao_course.lessons.graph_slam.drivers import SolvedOrNamed

Array = npt.NDArray[Any]
Pair = tuple[Array, Array]
DRIVER = "nao_course.lessons.graph_slam.drivers:solution_or_unheld"
BOTH = Close(rtol=1e-6, atol=1e-9, names=("your omega", "your xi"))


# --- systems to try things on ---
def linked(size: int, links: Iterable[tuple[int, int, float, float]], starts: dict[int, float]) -> Pair:
    """Return the system of links (first, second, difference, epsilon) and starts (variable: position)."""
    omega, xi = np.zeros((size, size)), np.zeros(size)
    for variable, position in starts.items():
        omega[variable, variable] += 1.0
        xi[variable] += position
    for first, second, difference, epsilon in links:
        omega, xi = _link_outer(omega, xi, first, second, difference, epsilon)
    return omega, xi


def any_system(rng: np.random.Generator, size: int) -> Pair:
    """Return a system with random entries, as if constraints had been added already."""
    half = rng.normal(0.0, 2.0, (size, size))
    return half + half.T, rng.normal(0.0, 5.0, size)


def a_drive(
    rng: np.random.Generator, poses: int, landmarks: int, epsilons: tuple[float, float] = (0.25, 4.0)
) -> list[tuple[int, int, float, float]]:
    """Return the links of a drive along an axis: motions, and landmarks that are measured from some poses."""
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
    """Return the system of a drive with a start."""
    return linked(poses + landmarks, a_drive(rng, poses, landmarks), {0: float(rng.normal(0, 3))})


# --- 8.1 add_initial_position ---
def _start_outer(omega: Any, xi: Any, index: int, position: float) -> Pair:
    row = np.eye(len(xi))[index]
    return omega + np.outer(row, row), xi + row * position


def _start_where(omega: Array, xi: Array, index: int, position: float) -> Any:
    here = np.arange(len(xi)) == index
    return [np.where(here & here[:, None], omega + 1, omega), np.where(here, xi + position, xi)]


def _start_lists(omega: Array, xi: Array, index: int, position: float) -> Any:
    rows, right = omega.tolist(), xi.tolist()
    rows[index][index] += 1
    right[index] += position
    return rows, right


def _start_public() -> list[Case]:
    rng = np.random.default_rng(81)
    return [
        Case((np.zeros((3, 3)), np.zeros(3), 0, 2.5), "an empty system"),
        Case((*any_system(rng, 4), 2, -3.0), "a system with earlier constraints"),
        Case((*any_system(rng, 3), 1, 0.0), "a start at 0"),
    ]


def _start_hidden(rng: np.random.Generator) -> list[Case]:
    drawn = [(*any_system(rng, n), int(rng.integers(n)), float(rng.normal(0, 5))) for n in (1, 3, 5, 8)]
    return [Case(each) for each in drawn]


ADD_INITIAL_POSITION = Exercise(
    name="add_initial_position",
    points=1,
    public=_start_public,
    hidden=_start_hidden,
    comparison=BOTH,
    hints=(
        "A start says x = position, so its row has one entry, on the diagonal. Copy both arrays; two more lines are enough.",
        "Begin with omega.copy() and xi.copy(). Then add something to omega[index, index] and something to xi[index].",
    ),
    sibling=Sibling(
        "A function adds to copies of its arguments, so that the old sums stay as they are: here a count and a sum for each of three people.",
        """
        import numpy as np


        def add_grade(counts, sums, person, grade):
            counts, sums = counts.copy(), sums.copy()
            counts[person] += 2  # this exam counts twice
            sums[person] += 2 * grade
            return counts, sums


        empty = np.zeros(3)
        print(*add_grade(*add_grade(empty, empty, 1, 4.0), 1, 3.0), empty)
        """,
        "[0. 4. 0.] [ 0. 14.  0.] [0. 0. 0.]",
    ),
    mistakes=catalogue("""
        = for +=: += =>> =
            You assign with = where you should add. The entries that other constraints put into this row are lost. Use += in both places.
        = for += in xi: xi[index] += => xi[index] =
            In xi you assign the position, and lose the entry that was there. Use +=.
        = for += in omega: omega[index, index] += 1 => omega[index, index] = 1
            In Omega you assign with = where you should add, so the entry that was there is lost. Use +=.
        = and the sign of xi: += =>> =
            xi[index] = position => xi[index] = -position
            There are two errors. You assign with = where you should add, so the entries that other constraints put into this row are lost. And in xi the position has the wrong sign: add it.
        new arrays: omega, xi = omega.copy(), xi.copy() => omega, xi = np.zeros_like(omega), np.zeros_like(xi)
            You start with arrays of zeros, so all earlier constraints are lost. Start with omega.copy() and xi.copy().
        numbered from 1: + index = (index + 1) % len(xi)
            You change variable index + 1. The variables are numbered from 0, as the rows are, so use `index` as it is.
        one too small: + index = index - 1
            You change variable index - 1. The variables are numbered from 0, as the rows are, so use `index` as it is.
        whole numbers: omega, xi = omega.copy(), xi.copy() => omega, xi = omega.astype(int), xi.astype(int)
            You convert the arrays to whole numbers, which cuts off all decimals. Begin with omega.copy() and xi.copy().
        sign of xi: xi[index] += => xi[index] -=
            You subtract the position from xi, so your map starts at minus the position. Add it.
        a whole row: omega[index, index] => omega[index]
            omega[index] is a whole row, so you also change the entries of other variables. A start involves one variable only: add 1 to omega[index, index].
        the position in omega: omega[index, index] += 1 => omega[index, index] += position
            You add the position to Omega. Omega gets the weight, which is 1, and only xi gets the position.
        all of xi: xi[index] += position => xi += position
            In xi you add the position to every entry. Only the row of the variable changes: xi[index] += position.
        always the first: + index = 0
            You always change variable 0. The start belongs to the variable `index`.
        the weight in xi: xi[index] += position => xi[index] += 1
            In xi you add the weight alone; add the weight times the position, which is the position.
        every variable: omega[index, index] += 1 => omega += np.eye(len(xi))
            You add 1 to the whole diagonal, which gives every variable a known position. Only the variable `index` has one.
        xi first: return omega, xi => return xi, omega
            You return xi first. Return omega, then xi.
        in place: omega, xi = omega.copy(), xi.copy() => pass
            You changed the arrays that you were given, because += works in place. Begin with omega, xi = omega.copy(), xi.copy().
    """),
    alternatives={"an outer product": _start_outer, "np.where": _start_where, "lists": _start_lists},
)


# --- 8.2 add_relative_motion and 8.3 add_relative_measurement ---
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


_LINK = """\
+ omega, xi = omega.copy(), xi.copy()
+ weight = 1 / epsilon
+ omega[FIRST, FIRST] += weight
+ omega[SECOND, SECOND] += weight
+ omega[FIRST, SECOND] -= weight
+ omega[SECOND, FIRST] -= weight
+ xi[FIRST] -= weight * VALUE
+ xi[SECOND] += weight * VALUE
+ return omega, xi"""
_LINK_MISTAKES = """
sign of xi: xi[FIRST] -= weight * VALUE => xi[FIRST] += weight * VALUE
    xi[SECOND] += weight * VALUE => xi[SECOND] -= weight * VALUE
    Both signs in xi are reversed. Subtract the weighted VALUE from xi[FIRST], and add it to xi[SECOND].
only one row of xi: xi[FIRST] -= weight * VALUE => pass
    You change xi[SECOND] only. The derivative with respect to FIRST also contains the VALUE, with a minus: subtract it from xi[FIRST].
both plus in xi: xi[FIRST] -= => xi[FIRST] +=
    You add the VALUE in both rows of xi. In the row of FIRST it has a minus.
= for +=: += =>> =
    -= weight =>> = -weight
    You assign with = where you should add. A variable has many constraints, and all but the last are lost. Use += and -= everywhere.
= for += in xi: xi[FIRST] -= weight * VALUE => xi[FIRST] = -weight * VALUE
    xi[SECOND] += => xi[SECOND] =
    In xi you assign, and lose the entries that were there. Use += and -=.
= off the diagonal: omega[FIRST, SECOND] -= weight => omega[FIRST, SECOND] = -weight
    omega[SECOND, FIRST] -= weight => omega[SECOND, FIRST] = -weight
    Off the diagonal you assign. The same two variables may already be linked, so use -= there, too.
plus off the diagonal: omega[FIRST, SECOND] -= weight => omega[FIRST, SECOND] += weight
    omega[SECOND, FIRST] -= weight => omega[SECOND, FIRST] += weight
    The entries off the diagonal have the wrong sign. The product of both variables in the square has a minus: subtract the weight there.
a copy of a block: omega[FIRST, FIRST] += weight => omega[[FIRST, SECOND]][:, [FIRST, SECOND]] += weight
    omega[SECOND, SECOND] += weight => pass
    omega[FIRST, SECOND] -= weight => pass
    omega[SECOND, FIRST] -= weight => pass
    Your xi is right, but your Omega stays as it was. omega[rows][:, columns] is a copy, so += changes nothing in omega. Change the four entries one by one, or use omega[np.ix_(ij, ij)] with ij = [FIRST, SECOND].
= on the diagonal: omega[FIRST, FIRST] += => omega[FIRST, FIRST] =
    omega[SECOND, SECOND] += => omega[SECOND, SECOND] =
    On the diagonal you assign with =, so the entries of earlier constraints are lost. Use += there.
= in all of omega: omega[FIRST, FIRST] += => omega[FIRST, FIRST] =
    omega[SECOND, SECOND] += => omega[SECOND, SECOND] =
    omega[FIRST, SECOND] -= => omega[FIRST, SECOND] = -
    omega[SECOND, FIRST] -= => omega[SECOND, FIRST] = -
    Your xi is right, but in Omega you assign with =, so the entries of earlier constraints are lost. Use += and -= there, too.
one entry off the diagonal: omega[SECOND, FIRST] -= weight => pass
    Omega must be symmetric. You change omega[FIRST, SECOND] but not omega[SECOND, FIRST].
nothing on one diagonal: omega[FIRST, FIRST] += weight => pass
    You do not change omega[FIRST, FIRST]. The square contains FIRST as well as SECOND, so both diagonal entries get the weight.
a block by pairs: omega[FIRST, FIRST] += weight => omega[[FIRST, SECOND], [FIRST, SECOND]] += weight * np.array([[1, -1], [-1, 1]])
    With two lists, omega[[FIRST, SECOND], [FIRST, SECOND]] selects two entries of the diagonal. The block of four entries is omega[np.ix_([FIRST, SECOND], [FIRST, SECOND])].
twice on a diagonal: omega[FIRST, FIRST] += weight => omega[FIRST, FIRST] += 2 * weight
    You add twice the weight to omega[FIRST, FIRST]. Each of the two diagonal entries gets the weight once.
one equation of two: omega[FIRST, FIRST] += weight => pass
    omega[FIRST, SECOND] -= weight => pass
    xi[FIRST] -= weight * VALUE => pass
    You add one equation, to the row of SECOND. The derivative with respect to FIRST is 0, too: add the negative of this equation to the row of FIRST.
one equation without its weight: omega[FIRST, FIRST] += weight => pass
    omega[FIRST, SECOND] -= weight => pass
    xi[FIRST] -= weight * VALUE => pass
    xi[SECOND] += weight * VALUE => xi[SECOND] += VALUE
    There are two errors. You add one equation only, to the row of SECOND; add its negative to the row of FIRST. And xi needs the weight 1 / epsilon, too.
new arrays: omega, xi = omega.copy(), xi.copy() => omega, xi = np.zeros_like(omega), np.zeros_like(xi)
    You start with arrays of zeros, so all earlier constraints are lost. Start with omega.copy() and xi.copy().
the smaller number first: weight = 1 / epsilon => weight, FIRST, SECOND = 1 / epsilon, *sorted((FIRST, SECOND))
    You sort the two numbers. The VALUE leads from FIRST to SECOND, whichever number is larger.
forwards only: weight = 1 / epsilon => weight, VALUE = 1 / epsilon, abs(VALUE)
    You use the absolute value of the VALUE. Its sign matters: it is negative backwards.
epsilon for 1/epsilon: 1 / epsilon => epsilon
    You multiply by epsilon, so the least precise values count most. The weight is 1 / epsilon.
1/epsilon squared: 1 / epsilon => 1 / epsilon**2
    You square epsilon. It is a variance, so it is squared already: the weight is 1 / epsilon.
1/root of epsilon: 1 / epsilon => 1 / np.sqrt(epsilon)
    You take the root of epsilon. Equation 8.1 divides the square by the variance itself: the weight is 1 / epsilon.
xi without its weight: weight * VALUE =>> VALUE
    In xi you forgot the weight: multiply the VALUE by 1 / epsilon, because both sides of the equation are multiplied by it.
sign and weight of xi: xi[FIRST] -= weight * VALUE => xi[FIRST] += VALUE
    xi[SECOND] += weight * VALUE => xi[SECOND] -= VALUE
    There are two errors in xi. Its signs are reversed: subtract in the row of FIRST, and add in the row of SECOND. And the VALUE needs the weight 1 / epsilon.
omega without its weight: omega[FIRST, FIRST] += weight => omega[FIRST, FIRST] += 1
    omega[SECOND, SECOND] += weight => omega[SECOND, SECOND] += 1
    omega[FIRST, SECOND] -= weight => omega[FIRST, SECOND] -= 1
    omega[SECOND, FIRST] -= weight => omega[SECOND, FIRST] -= 1
    In Omega you add 1 and -1 without the weight: add 1 / epsilon and -1 / epsilon.
all of it divided: weight = 1 / epsilon => weight = 1.0
    return omega, xi => return omega / epsilon, xi / epsilon
    You divide all of Omega and xi by epsilon, and with them the entries of earlier constraints. Divide only what this constraint adds.
the same equation twice: omega[FIRST, FIRST] += weight => omega[FIRST, FIRST] -= weight
    omega[FIRST, SECOND] -= weight => omega[FIRST, SECOND] += weight
    xi[FIRST] -= weight * VALUE => xi[FIRST] += weight * VALUE
    You add the same equation to both rows. The row of FIRST gets it times -1: its diagonal entry is positive, too.
root of the weight in xi: xi[FIRST] -= weight * VALUE => xi[FIRST] -= np.sqrt(weight) * VALUE
    xi[SECOND] += weight * VALUE => xi[SECOND] += np.sqrt(weight) * VALUE
    In xi your weight is 1 / sqrt(epsilon). If you divide a row by sqrt(epsilon), divide its VALUE by it, too. The product of both then has the weight 1 / epsilon.
whole numbers: 1 / epsilon => 1 // epsilon
    You use //, which rounds 1 / epsilon down to a whole number. Use /.
epsilon not used: 1 / epsilon => 1.0
    You do not use epsilon, so the result is right only for epsilon = 1. Everything that you add has the factor 1 / epsilon.
sign of xi and epsilon: 1 / epsilon => epsilon
    xi[FIRST] -= weight * VALUE => xi[FIRST] += weight * VALUE
    xi[SECOND] += weight * VALUE => xi[SECOND] -= weight * VALUE
    There are two errors. The signs in xi are reversed: subtract from xi[FIRST], and add to xi[SECOND]. And the weight is 1 / epsilon, not epsilon.
xi first: return omega, xi => return xi, omega
    You return xi first. Return omega, then xi.
in place: omega, xi = omega.copy(), xi.copy() => pass
    You changed the arrays that you were given. Work on omega.copy() and xi.copy().
"""


def _link_mistakes(value: str, first: str, second: str, *, written_out: bool) -> list[Mistake]:
    """Return the mistakes of both kinds of link; `written_out` replaces the solution first, where it is a single call."""

    def named(text: str) -> str:
        return text.replace("VALUE", value).replace("FIRST", first).replace("SECOND", second)

    lines = tuple(named(_LINK).splitlines()) if written_out else ()
    return [
        Mistake(each.name, Change((*lines, *each.function.lines)), each.message)
        for each in catalogue(named(_LINK_MISTAKES))
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
        Case((*any_system(rng, 4), 1, 2, 5.0, 0.25), "a system with earlier constraints"),
        Case((*any_system(rng, 4), 0, 3, -2.0, 4.0), "backwards, and not to the next variable"),
        Case((*any_system(rng, 3), 2, 0, 1.5, 0.5), "the later pose has the smaller number"),
    ]


def _link_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for size in (2, 4, 6, 9):
        first, second = rng.choice(size, 2, replace=False).tolist()
        given = (first, second, float(rng.normal(0, 4)), float(rng.uniform(0.1, 0.7)))
        cases.append(Case((*any_system(rng, size), *given)))
    cases.append(Case((*any_system(rng, 3), 0, 2, float(rng.normal(0, 4)))))
    cases.append(Case((*any_system(rng, 5), 3, 1, float(rng.normal(0, 4)), float(rng.uniform(2, 9)))))
    return cases


ADD_RELATIVE_MOTION = Exercise(
    name="add_relative_motion",
    points=2,
    public=_motion_public,
    hidden=_link_hidden,
    comparison=BOTH,
    hints=(
        "Translate equation 8.2 entry by entry. It changes four entries of omega and two of xi. Compute weight = 1 / epsilon first.",
        "Add the weight to omega[before, before] and omega[after, after], and subtract it from omega[before, after] and omega[after, before]. Subtract weight * motion from xi[before], and add it to xi[after].",
    ),
    sibling=Sibling(
        "Expand the square of an equation's residual: here two bags weigh s together, (x_0 + x_1 - s)**2 / variance, and its derivatives give the entries, all with the same sign.",
        """
        import numpy as np

        A, b = np.zeros((2, 2)), np.zeros(2)
        for i, j, s, variance in ((0, 1, 5.0, 0.5), (1, 1, 4.0, 2.0)):  # both bags, then two bags like bag 1
            w = 1 / variance
            row = np.bincount([i, j], minlength=2)  # how often x_0 and x_1 are in the equation
            A += w * row[:, None] * row
            b += w * s * row
        print(A.tolist(), b.tolist(), np.linalg.solve(A, b).tolist())
        """,
        "[[2.0, 2.0], [2.0, 4.0]] [10.0, 14.0] [3.0, 2.0]",
    ),
    mistakes=[
        *_link_mistakes("motion", "before", "after", written_out=False),
        *catalogue("""
            the next variable: + after = before + 1
                You use the variable before + 1. The motion leads to the variable `after`, whatever its number.
            a slice: + omega, xi = omega.copy(), xi.copy()
                + omega[before : after + 1, before : after + 1] += np.array([[1, -1], [-1, 1]]) / epsilon
                + xi[before] -= motion / epsilon
                + xi[after] += motion / epsilon
                + return omega, xi
                The slice before : after + 1 contains two rows only if `after` is before + 1. Change the four entries one by one, such as omega[before, after], or select them with np.ix_.
        """),
    ],
    alternatives=_LINK_ALTERNATIVES,
)


def _measurement_public() -> list[Case]:
    rng = np.random.default_rng(83)
    return [
        Case((np.zeros((3, 3)), np.zeros(3), 0, 2, 9.0), "the landmark nine steps ahead, no epsilon given"),
        Case((*any_system(rng, 5), 1, 4, -5.0, 0.25), "a landmark behind the robot"),
        Case((*any_system(rng, 5), 2, 3, 2.0, 4.0), "a system with earlier constraints"),
        Case((*any_system(rng, 4), 3, 0, 1.5, 0.5), "the landmark has the smaller number"),
    ]


ADD_RELATIVE_MEASUREMENT = Exercise(
    name="add_relative_measurement",
    points=2,
    uses=("add_relative_motion",),
    public=_measurement_public,
    hidden=_link_hidden,
    comparison=BOTH,
    hints=(
        "Which equation does the measurement give? Have you written this equation before, with other names?",
        "It is landmark - pose = offset. A motion of `offset` from the pose would end at the landmark, so one call is enough.",
    ),
    sibling=Sibling(
        "If two actions change the numbers in the same way, only with other names, one function calls the other: a customer who buys something sends money to a shop.",
        """
        def send(money, giver, receiver, amount):
            return money | {giver: money[giver] - amount, receiver: money[receiver] + amount}


        def buy(money, customer, shop, price):
            return send(money, customer, shop, price)


        print(buy({"Ann": 50, "baker": 10}, "Ann", "baker", 4))
        """,
        "{'Ann': 46, 'baker': 14}",
    ),
    mistakes=[
        *_link_mistakes("offset", "pose", "landmark", written_out=True),
        *catalogue("""
            a start besides
                return add_relative_motion(omega, xi, pose, landmark, offset, epsilon) => omega, xi = add_relative_motion(omega, xi, pose, landmark, offset, epsilon)
                + return add_initial_position(omega, xi, landmark, offset)
                The edge is right. In addition you give the landmark the position `offset`, but `offset` is relative to the pose. Leave the second call out.
            the next variable: + landmark = (pose + 1) % len(xi)
                You use the variable pose + 1. The measurement leads to the variable `landmark`, whatever its number.
            a start of the pose besides
                return add_relative_motion(omega, xi, pose, landmark, offset, epsilon) => omega, xi = add_relative_motion(omega, xi, pose, landmark, offset, epsilon)
                + return add_initial_position(omega, xi, pose, 0.0)
                The edge is right. In addition you give the pose the position 0. A measurement says nothing about the position of the pose: leave the second call out.
            a start: + return add_initial_position(omega, xi, landmark, offset)
                You use `offset` as the position of the landmark, with the weight 1. It is relative to the pose, so the row and the column of the pose change, too.
            a position: + omega, xi = omega.copy(), xi.copy()
                + omega[landmark, landmark] += 1 / epsilon
                + xi[landmark] += offset / epsilon
                + return omega, xi
                You use `offset` as the position of the landmark. It is relative to the pose, so the row and the column of the pose change, too.
            from the landmark and without epsilon
                return add_relative_motion(omega, xi, pose, landmark, offset, epsilon) => return add_relative_motion(omega, xi, landmark, pose, offset)
                Your function has two errors. The offset leads from the pose to the landmark, so the pose comes first. And epsilon is missing, so the result is right only for epsilon = 1.
        """),
    ],
    alternatives=_LINK_ALTERNATIVES,
)


# --- 8.4 solve ---
def unheld(omega: Any) -> list[int]:
    """Return the variables that are connected to no start."""
    links = scipy.sparse.csr_array(omega)
    count, part = scipy.sparse.csgraph.connected_components(links, directed=False)
    weight = np.bincount(part, np.asarray(links.sum(axis=1)).ravel(), count)
    diagonal = np.bincount(part, links.diagonal(), count)
    return [int(each) for each in np.flatnonzero((weight <= 1e-13 * diagonal)[part])]


def _refuse(numbers: Iterable[int]) -> None:
    if named := ", ".join(map(str, numbers)):
        raise ValueError(f"nothing holds {named}")


def _solve_parts(omega: Array, xi: Array) -> Any:
    _refuse(unheld(omega))
    return np.linalg.inv(omega) @ xi


def _solve_svd(omega: Array, xi: Array) -> Any:
    u, s, vt = np.linalg.svd(omega)
    free = vt[s <= 1e-12 * s.max(initial=0.0)]
    _refuse(np.flatnonzero(np.linalg.norm(free, axis=0) > 1e-5))
    return (vt.T @ ((u.T @ xi) / s)).tolist()


def _solve_walking(omega: Array, xi: Array) -> Any:
    """Solve by a walk from the variables with a start to all that are connected to them."""
    reached = np.abs(omega.sum(axis=1)) > 1e-11 * np.abs(omega).max()
    for _ in range(len(xi)):
        reached = reached | (omega[:, reached] != 0).any(axis=1)
    _refuse(np.flatnonzero(~reached))
    return scipy.linalg.cho_solve(scipy.linalg.cho_factor(omega), xi).astype(np.float32)


PAPER = linked(3, [(0, 1, 5.0, 1.0), (0, 2, 9.0, 1.0), (1, 2, 3.0, 1.0)], {0: 0.0})


def _solve_public() -> list[Case]:
    rng = np.random.default_rng(84)
    parts = [(0, 1, 2.0, 1.0), (1, 4, 3.0, 0.5), (2, 3, 1.0, 2.0), (3, 5, 1.0, 1.0)]
    unseen = [(0, 1, 2.0, 1.0), (0, 2, 4.0, 0.5)]
    return [
        Case(PAPER, "the example of the text"),
        Case(a_solved_drive(rng, 5, 3), "a drive of five poses"),
        Case(linked(3, [(0, 1, 10.0, 1.0), (1, 2, 5.0, 2.0)], {}), "no start at all"),
        Case(linked(4, unseen, {0: 1.0}), "a landmark that was never measured"),
        Case(linked(6, parts, {0: -4.0}), "two parts, one of them with a start"),
        Case(linked(8, a_drive(rng, 6, 2, (2e4, 4e5)), {0: 100.0}), "a drive measured in millimetres"),
        # rounding leaves something here: no pivot, and no sum, is exactly 0
        Case(linked(9, a_drive(np.random.default_rng(841), 6, 3), {}), "a drive without a start"),
        Case(_fine(rng), "measured to a tenth of a millimetre, without a start"),
        Case((np.zeros((2, 2)), np.zeros(2)), "no constraint yet: Omega is all zeros"),
        Case(linked(40, a_drive(np.random.default_rng(842), 30, 10), {}), "40 variables without a start"),
        Case(_precise(np.random.default_rng(843)), "weights of 1e8, and five parts without a start"),
        Case(_in_parts(np.random.default_rng(844), 9), "two parts of nine, in mixed order"),
        Case(_held(np.random.default_rng(845)), "25 steps known to 0.1 mm, in metres, and a start"),
        Case(_long(np.random.default_rng(846)), "40 steps of the odometry, in millimetres, and a start"),
    ]


def _in_parts(rng: np.random.Generator, size: int, parts: int = 2, *, mixed: bool = True) -> Pair:
    """Return drives without links between them, of which one has a start; their variables mixed, or drive by drive."""
    order = (rng.permutation(parts * size) if mixed else np.arange(parts * size)).tolist()
    links = [
        (order[part * size + i], order[part * size + j], difference, epsilon)
        for part in range(parts)
        for i, j, difference, epsilon in a_drive(rng, size - 2, 2)
    ]
    return linked(parts * size, links, {order[0]: float(rng.normal(0, 3))})


def _fine(rng: np.random.Generator) -> Pair:
    """Return a drive without a start, with variances of about (0.1 mm)^2 in m^2."""
    return linked(8, a_drive(rng, 6, 2, (1e-8, 1e-7)), {})


def _precise(rng: np.random.Generator, parts: int = 5) -> Pair:
    """Return walks without a start, with weights of about 1e8: rounding leaves eigenvalues of both signs."""
    links = [
        (4 * part + i, 4 * part + i + 1, float(rng.normal(1, 0.3)), float(rng.uniform(0.5e-8, 2e-8)))
        for part in range(parts)
        for i in range(3)
    ]
    return linked(4 * parts, links, {})


def _held(rng: np.random.Generator, steps: int = 25, *, at_zero: bool = False) -> Pair:
    """Return a walk in metres that a start holds: its smallest eigenvalue is about 1e-10 of its largest one.

    at_zero: everything is at 0, so that an iterative solver is exact, too.
    """
    variances, size = rng.uniform(0.8e-8, 1.2e-8, steps), 0.0 if at_zero else 0.05
    links = [(i, i + 1, size, float(variance)) for i, variance in enumerate(variances)]
    return linked(steps + 1, links, {0: 40 * size})


def _long(rng: np.random.Generator) -> Pair:
    """Return a walk in millimetres that a start holds: its smallest eigenvalue is about 1e-9."""
    links = [(i, i + 1, 300.0, float(variance)) for i, variance in enumerate(rng.uniform(5e5, 9e5, 40))]
    return linked(41, links, {0: 100.0})


def _coarse(rng: np.random.Generator) -> Pair:
    """Return a drive in millimetres."""
    return linked(8, a_drive(rng, 6, 2, (2e4, 4e5)), {0: float(rng.normal(0, 100))})


def _solve_hidden(rng: np.random.Generator) -> list[Case]:
    systems = [
        *(a_solved_drive(rng, poses, marks) for poses, marks in ((1, 1), (4, 3), (12, 6), (40, 15))),
        linked(18, a_drive(rng, 12, 6, (1e-3, 1e2)), {0: 1.0, 3: 2.0}),
        *(_in_parts(rng, size) for size in (3, 5, 9)),
        linked(int(rng.integers(3, 7)), [], {}),
        linked(8, a_drive(rng, 4, 3), {0: float(rng.normal(0, 2))}),
        linked(9, a_drive(rng, 6, 3, (5e-4, 1e-3)), {}),
        *(_coarse(rng) for _ in range(2)),
        _long(rng),
        *(_fine(rng) for _ in range(2)),
        _in_parts(rng, 7, 4, mixed=False),
        linked(60, a_drive(rng, 50, 10), {}),
        *(_precise(rng, parts) for parts in (5, 6)),
        *(_held(rng, steps) for steps in (15, 25)),
    ]
    return [Case(system) for system in systems]


SOLVE = Exercise(
    name="solve",
    points=3,
    stars=2,
    public=_solve_public,
    hidden=_solve_hidden,
    comparison=SolvedOrNamed(),
    driver=DRIVER,
    hints=(
        "np.linalg.solve does the first part. For the second part, np.linalg.eigh(omega) returns eigenvalues and, in the columns of a matrix, their eigenvectors. Which columns matter, and what does a nonzero entry of such a column mean for its variable?",
        "With values, vectors = np.linalg.eigh(omega), the columns with an eigenvalue of at most 1e-12 of the largest one are the free directions. Use <= for this comparison, because the largest may be 0 itself. Every variable with a nonzero entry in a free direction can be moved: raise a ValueError with all their numbers.",
    ),
    sibling=Sibling(
        "A free direction is a change of the unknowns that changes no equation, and all unknowns with an entry in it are undetermined: here only x_2 and x_3 are known.",
        """
        import numpy as np

        A = np.array([[1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, -1.0], [0.0, 0.0, 0.0, 2.0]])
        _, sizes, directions = np.linalg.svd(A)  # the directions are rows
        rank = np.sum(sizes > 1e-12 * sizes[0])
        free = directions[rank:]
        print(np.abs(free).round(3), np.flatnonzero(np.abs(free).max(axis=0) > 1e-6))
        """,
        "[[0.707 0.707 0.    0.   ]] [0 1]",
    ),
    mistakes=catalogue("""
        names nothing: f"nothing holds {', '.join(map(str, loose))}" => "the system is singular"
            Your solutions are right. But if the system is singular, your message names no variable. Find the variables that can be moved freely, and put their numbers into the message of a ValueError.
        another error: ValueError => RuntimeError
            You notice that the system is singular, but you raise another kind of error. Raise a ValueError: the functions that call solve handle this one.
        least squares: + return np.linalg.pinv(omega) @ xi
            lstsq and pinv return a solution even if the system is singular: of all solutions, the one with the smallest norm. Here this must be an error.
        a little on the diagonal: + return np.linalg.solve(omega + 1e-6 * np.eye(len(xi)), xi)
            You add something to the diagonal to make the matrix invertible. This pulls every variable slightly towards 0 and hides the missing constraint. Raise a ValueError instead.
        only what NumPy notices: + try:
            +     return np.linalg.solve(omega, xi)
            + except np.linalg.LinAlgError:
            +     pass
            You rely on NumPy's LinAlgError. Because of rounding, a singular matrix often has a pivot of 1e-16 instead of 0, so NumPy raises nothing and returns a meaningless x. Before you solve, compare the eigenvalues with a small fraction of the largest one.
        NumPy's solve alone: + return np.linalg.solve(omega, xi)
            Your solutions are right. If the system is singular, NumPy names no variable, and rounding often hides the problem from it. Before you solve, look for eigenvalues of nearly 0, and raise a ValueError with the numbers of the variables that can be moved freely; to print them is not enough.
        a returned error: raise ValueError => return ValueError
            You return the ValueError. An error has to be raised: raise ValueError(...).
        a condition number: + if np.linalg.cond(omega) > 1e8:
            +     raise ValueError("the system is singular")
            + return np.linalg.solve(omega, xi)
            A large condition number shows that the system is nearly singular, but it names no variable. The eigenvectors with an eigenvalue of nearly 0 show which variables can be moved freely.
        a determinant: + if abs(np.linalg.det(omega)) < 1e-9:
            +     raise ValueError("the system is singular")
            + return np.linalg.solve(omega, xi)
            A small determinant does not show that a system is singular: with the units of the weights it can take any size. It also names no variable. Compare the eigenvalues with a small fraction of the largest one, and name the variables that can be moved freely.
        all, if NumPy notices: + try:
            +     return np.linalg.solve(omega, xi)
            + except np.linalg.LinAlgError:
            +     raise ValueError(f"nothing holds {list(range(len(xi)))}")
            There are two errors. Because of rounding, NumPy does not notice every singular matrix: compare the eigenvalues with a small fraction of the largest one. And name only the variables that can be moved freely, not all.
        row sums: + if np.linalg.matrix_rank(omega) == len(xi):
            +     return np.linalg.solve(omega, xi)
            + raise ValueError(f"nothing holds {np.flatnonzero(omega.sum(axis=1) == 0).tolist()}")
            You name the variables whose rows add up to 0. Such a variable has no start of its own, but edges can hold it. Name the variables with an entry in a free direction: use the eigenvectors.
        row sums of nearly 0: + if np.linalg.matrix_rank(omega) == len(xi):
            +     return np.linalg.solve(omega, xi)
            + raise ValueError(f"nothing holds {np.flatnonzero(np.isclose(omega.sum(axis=1), 0)).tolist()}")
            You name the variables whose rows add up to nearly 0. That says only that they have no start of their own, and edges can hold them. Name the variables with an entry in a free direction: use the eigenvectors.
        every row sum of nearly 0: loose = np.flatnonzero(np.linalg.norm(free, axis=1) > 1e-6) => loose = np.flatnonzero(np.isclose(omega.sum(axis=1), 0))
            You refuse systems that have a solution, because you name each variable whose row adds up to 0. Such a variable has no start of its own, but edges can hold it: use the eigenvectors.
        exactly 0: values <= 1e-12 * values.max() => values == 0
            You find only variables without any constraint. If a group of linked variables has no start, rounding leaves an eigenvalue of about 1e-16 of the largest one, so neither == 0 nor NumPy's LinAlgError finds it every time. Compare the eigenvalues with a small fraction of the largest one, and name all variables of the group.
        one direction: values <= 1e-12 * values.max()] => values <= 1e-12 * values.max()][:, :1]
            You use one free direction. There can be several, one for each part without a start: use all columns with an eigenvalue of nearly 0.
        named from 1: str, loose => str, loose + 1
            Your numbers are too large by 1. The variables are numbered from 0, as the rows are.
        numbers of directions: np.linalg.norm(free, axis=1) => np.linalg.norm(free, axis=0)
            You name the numbers of the free directions, which are columns. Name the variables, which are rows: a variable can be moved if its row contains a nonzero entry.
        a fixed limit for 0: 1e-12 * values.max() => 1e-6
            Your limit for an eigenvalue of 0 is too large. In millimetres the weights of the measurements are a millionth of the weight of the start, and their eigenvalues are not 0. Compare with a very small fraction of the largest eigenvalue, such as 1e-12.
        too large a fraction: 1e-12 * values.max() => 1e-3 * values.max()
            Your fraction of the largest eigenvalue is too large. Rounding leaves about 1e-16 of it, and an eigenvalue of a millionth of it need not be 0: use a fraction such as 1e-12.
        too large a fraction for precise steps: 1e-12 * values.max() => 1e-8 * values.max()
            Your fraction of the largest eigenvalue is too large. Steps known to 0.1 mm have weights of 1e8, and a start of weight 1 still holds them: the smallest eigenvalue is then 1e-10 of the largest one, but not 0. Use a fraction such as 1e-12.
        a ten-billionth: 1e-12 * values.max() => 1e-10 * values.max()
            Your limit is too large a fraction of the largest eigenvalue. Steps known to 0.1 mm have weights of 1e8 beside a start of 1. Rounding leaves about 1e-16, so use a fraction such as 1e-12.
        a millionth: 1e-12 * values.max() => 1e-6 * values.max()
            Your limit is too large a fraction of the largest eigenvalue. Steps known to 0.1 mm have weights of 1e8 beside a start of 1. Rounding leaves about 1e-16, so use a fraction such as 1e-12. A millionth is far too large.
        large entries only: axis=1) > 1e-6 => axis=1) > 0.3
            You do not find that 40 linked variables can be moved. One of your limits is the reason. With 40 variables, rounding leaves more than 1e-16 of the largest eigenvalue: use a fraction such as 1e-12. And if 40 variables move together, each entry of the free direction is only 0.16: compare with a number such as 1e-6.
        entries above 0 only: np.linalg.norm(free, axis=1) > 1e-6 => (free > 1e-6).any(axis=1)
            You look for positive entries only. A free direction may have either sign, so compare the absolute value of its entries.
        a fixed limit: values <= 1e-12 * values.max() => np.abs(values) <= 1e-12
            Your limit for an eigenvalue of 0 is a fixed number. With weights of 1e8, rounding errors alone are larger than it. Compare with a small fraction of the largest eigenvalue.
        isclose: values <= 1e-12 * values.max() => np.isclose(values, 0)
            np.isclose(values, 0) has a fixed limit of 1e-8. Rounding errors are larger than it if the weights are 1e8, and the eigenvalue of a long walk in millimetres is smaller, but not 0. Compare with a small fraction of the largest eigenvalue, such as 1e-12.
        a small fixed limit: 1e-12 * values.max() => 1e-7
            Your limit for an eigenvalue of 0 is a fixed number. The smallest eigenvalue of 40 steps in millimetres is 1e-9, although a start holds them. Compare with a small fraction of the largest eigenvalue, such as 1e-12.
        entries that are not exactly 0: > 1e-6 => != 0
            You name every variable whose entry in a free direction is not exactly 0. Rounding leaves about 1e-17 in the entries of held variables: compare with a number such as 1e-6.
        rows for columns: vectors[:, => vectors.T[:,
            You take rows of the matrix of eigenvectors. np.linalg.eigh returns the eigenvectors in its columns: vectors[:, number].
        less than a part of nothing: <= 1e-12 => < 1e-9
            There are two errors. Without any constraint omega is all zeros, so the largest eigenvalue is 0, too, and a comparison with < (or a division by it) finds no free direction: use values <= limit * largest. And with steps known to 0.1 mm, 1e-9 or 1e-10 is too large a fraction: use one such as 1e-12.
        strictly less: values <= 1e-12 => values < 1e-12
            Without any constraint omega is all zeros, so the largest eigenvalue is 0, too, and a comparison with < (or a division by it) finds no free direction. Use values <= limit * largest.
        only those without a constraint: loose = np.flatnonzero(np.linalg.norm(free, axis=1) > 1e-6) => loose = np.flatnonzero(np.diag(omega) == 0)
            + if free.size and not len(loose):
            +     raise ValueError("the system is singular")
            You name only the variables without any constraint. A group of variables that edges connect, but without a start, can also be moved: name all of its variables.
        all variables: str, loose => str, range(len(xi))
            You name every variable. Name only the variables that can be moved freely.
        one of them: str, loose => str, loose[:1]
            You name one variable. A group without a start moves as a whole: name all of its variables.
        held variables: str, loose => str, sorted(set(range(len(xi))) - set(loose))
            You name the variables that are held. Name the others.
        a product: + return omega @ xi
            You return omega @ xi. Find the x with omega @ x = xi.
        only the diagonal: + return xi / np.where(np.diag(omega) == 0, 1, np.diag(omega))
            You divide by the diagonal, as if there were no edges between the variables. Solve the whole system at once.
        the first at 0: + return np.concatenate([[0.0], np.linalg.lstsq(omega[1:, 1:], xi[1:], rcond=None)[0]])
            You set the first variable to 0. Its position is already in omega and xi, and it need not be 0.
    """),
    alternatives={
        "connected parts, and the inverse": _solve_parts,
        "singular values": _solve_svd,
        "a walk from the starts, and Cholesky, float32": _solve_walking,
    },
    equivalents={
        "loose = np.flatnonzero(np.linalg.norm(free, axis=1) >= 1e-06)": "no entry equals the limit exactly"
    },
)


# --- 8.5 marginalize ---
def _one_by_one(omega: Array, xi: Array, keep: list[int]) -> Any:
    for removed in set(range(len(xi))) - set(keep):
        share = omega[:, removed] / omega[removed, removed]
        omega, xi = omega - np.outer(share, omega[removed]), xi - share * xi[removed]
    return [omega[np.ix_(keep, keep)], xi[keep]]


def _by_solving(omega: Array, xi: Array, keep: list[int]) -> Pair:
    removed, both = np.setdiff1d(np.arange(len(xi)), keep), np.column_stack([omega, xi])
    rest = both[keep] - omega[np.ix_(keep, removed)] @ np.linalg.solve(
        omega[np.ix_(removed, removed)], both[removed]
    )
    return rest[:, keep], rest[:, -1]


def _by_a_factor(omega: Array, xi: Array, keep: list[int]) -> Pair:
    """Remove variables by the Cholesky factor of their block."""
    removed = np.setdiff1d(np.arange(len(xi)), keep)
    half = np.linalg.cholesky(omega[np.ix_(removed, removed)])
    across, right = (np.linalg.solve(half, each) for each in (omega[np.ix_(removed, keep)], xi[removed]))
    return omega[np.ix_(keep, keep)] - across.T @ across, xi[keep] - across.T @ right


def _marginal_public() -> list[Case]:
    rng = np.random.default_rng(85)
    loose = linked(4, [(0, 1, 5.0, 1.0), (0, 2, 9.0, 1.0), (1, 2, 3.0, 1.0), (2, 3, 1.0, 1.0)], {})
    return [
        Case((*PAPER, [0, 2]), "the example of the text without x1"),
        Case((*a_solved_drive(rng, 4, 3), [4, 5, 6]), "only the landmarks"),
        Case((*a_solved_drive(rng, 5, 2), [6, 0, 4]), "in another order"),
        Case((*a_solved_drive(rng, 3, 1), [0, 1, 2, 3]), "all of them"),
        Case((*loose, [0, 3]), "no start yet: differences only"),
    ]


def _marginal_hidden(rng: np.random.Generator) -> list[Case]:
    def case(system: Pair, kept: int) -> Case:
        return Case((*system, rng.choice(len(system[1]), kept, replace=False).tolist()))

    sizes = ((4, 3, 2), (6, 4, 4), (12, 6, 5), (3, 1, 1), (30, 10, 10), (5, 5, 9))
    return [
        *(case(a_solved_drive(rng, poses, marks), kept) for poses, marks, kept in sizes),
        *(case(linked(poses + 3, a_drive(rng, poses, 3), {}), 3) for poses in (3, 8)),
        case(a_solved_drive(rng, 3, 2), 5),
    ]


MARGINALIZE = Exercise(
    name="marginalize",
    points=4,
    stars=2,
    public=_marginal_public,
    hidden=_marginal_hidden,
    comparison=Close(rtol=1e-5, atol=1e-7, names=("your omega", "your xi")),
    hints=(
        "Cut the system into blocks: omega[np.ix_(rows, columns)] selects one. Equation 8.5 needs three blocks of omega and two of xi. Begin with a list of the variables that are not in keep.",
        "Let `removed` be the numbers that are not in keep, A the block (keep, keep) of omega, B the block (keep, removed), and C the block (removed, removed). Return A - B C^-1 Bᵀ and xi[keep] - B C^-1 xi[removed]. np.linalg.solve(C, ...) is more accurate than an inverse.",
    ),
    sibling=Sibling(
        "If you put the best y for each x into a quadratic function, a function of x alone remains; if x and y are several variables, a, b and c are blocks of a matrix, and np.ix_ selects a block.",
        """
        import numpy as np

        a, b, c = 5.0, 2.0, 4.0  # f(x, y) = a x**2 + 2 b x y + c y**2, smallest at y = -b x / c
        x, y = 3.0, np.linspace(-5, 5, 10001)
        smallest = np.min(a * x**2 + 2 * b * x * y + c * y**2)
        print(f"{smallest:.3f} and {(a - b * b / c) * x**2:.3f}")
        table = np.arange(16).reshape(4, 4)
        print(table[np.ix_([3, 0], [1, 2])])  # rows 3 and 0, and of these the columns 1 and 2
        """,
        """
        36.000 and 36.000
        [[13 14]
         [ 1  2]]
        """,
    ),
    mistakes=catalogue("""
        only cut out: - share @ between.T, xi[keep] - share @ xi[removed] => , xi[keep]
            You delete rows and columns. This treats the removed variables as known to be 0, and their information about the others is lost. Subtract the second terms of equation 8.5.
        cut out in the order of the numbers: + keep = sorted(keep)
            - share @ between.T, xi[keep] - share @ xi[removed] => , xi[keep]
            There are two errors. You delete rows and columns (as np.delete does), and with them the information about the others: subtract the second terms of equation 8.5. And `keep` gives the order of the result.
        omega alone: , xi[keep] - share @ xi[removed] =>
            You return the smaller omega only. Return the smaller xi, too.
        cut out of the inverse: + covariance = np.linalg.inv(omega)
            + return covariance[np.ix_(keep, keep)], (covariance @ xi)[keep]
            You return the covariance and the solution of the kept variables. Return the omega and the xi of the smaller system.
        single entries: + return omega[keep, keep], xi[keep]
            omega[keep, keep] selects single entries of the diagonal. A block is omega[np.ix_(keep, keep)]. After that, the second terms of equation 8.5 are missing.
        both blocks by pairs: between = omega[np.ix_(keep, removed)] => between = omega[keep, removed]
            omega[np.ix_(removed, removed)] => omega[removed, removed]
            omega[keep, removed] and omega[removed, removed] do not select blocks: NumPy pairs the two lists, number by number. Write omega[np.ix_(keep, removed)], and likewise for every other block.
        rows, then rows again: between = omega[np.ix_(keep, removed)] => between = omega[keep][removed]
            omega[keep][removed] selects rows, and then rows of the result. A block of rows and columns is omega[np.ix_(keep, removed)].
        rows of rows in both blocks: between = omega[np.ix_(keep, removed)] => between = omega[keep][removed]
            omega[np.ix_(removed, removed)] => omega[removed][removed]
            omega[removed][removed] and omega[keep][removed] select rows twice and no columns. Write omega[np.ix_(removed, removed)], and likewise for the other blocks.
        kept block by pairs: omega[np.ix_(keep, keep)] => omega[keep, keep]
            omega[keep, keep] selects entries of the diagonal and not the block of the kept variables. The block is omega[np.ix_(keep, keep)].
        x of the removed variables: + removed = [number for number in range(len(xi)) if number not in keep]
            + x = np.linalg.solve(omega[np.ix_(removed, removed)], xi[removed])
            + return omega[np.ix_(keep, keep)], xi[keep] - omega[np.ix_(keep, removed)] @ x
            You solve for the removed variables as if the kept ones were 0. Their values depend on the kept variables, so omega changes, too: subtract the second term of equation 8.5 there.
        pairs of numbers: between = omega[np.ix_(keep, removed)] => between = omega[keep, removed]
            omega[keep, removed] does not select a block: NumPy pairs the two lists, number by number. A block is omega[np.ix_(keep, removed)], and likewise for the other blocks.
        the removed block by pairs: omega[np.ix_(removed, removed)] => omega[removed, removed]
            omega[removed, removed] selects entries of the diagonal and not the block of the removed variables. The block is omega[np.ix_(removed, removed)].
        no transpose: - share @ between.T => - share @ between
            The last factor must be transposed: the product is B C^-1 Bᵀ, where B is omega[np.ix_(keep, removed)].
        the answer for xi: xi[keep] - share @ xi[removed] => np.linalg.solve(omega, xi)[keep]
            For xi you return the solution x of the kept variables. xi is the right side of their system, as in equation 8.5.
        by way of the covariance: + covariance = np.linalg.inv(omega)
            + left = np.linalg.inv(covariance[np.ix_(keep, keep)])
            + return left, left @ (covariance @ xi)[keep]
            You invert all of omega. Without a start it has no inverse, but variables can still be removed. Invert only the block of the removed variables.
        by way of a pseudo-inverse: + covariance = np.linalg.pinv(omega)
            + left = np.linalg.pinv(covariance[np.ix_(keep, keep)])
            + return left, left @ (covariance @ xi)[keep]
            With a start your result is right. Without one, pinv of all of omega adds information that no constraint gave. Invert only the block of the removed variables.
        the first ones: + keep = list(range(len(keep)))
            You keep the first variables. `keep` may contain any numbers, in any order: use np.ix_(keep, removed).
        each entry inverted: np.linalg.solve(omega[np.ix_(removed, removed)], between.T).T => between @ (1 / omega[np.ix_(removed, removed)])
            1 / block takes the reciprocal of each entry, and most entries are 0. Use np.linalg.solve, or np.linalg.inv.
        * for @: np.linalg.solve(omega[np.ix_(removed, removed)], between.T).T => between * np.linalg.inv(omega[np.ix_(removed, removed)])
            - share @ between.T, xi[keep] - share @ xi[removed] => - share * between.T, xi[keep] - share * xi[removed]
            You multiply with *, which multiplies entry by entry. The product of matrices is @.
        * for @ in omega: - share @ between.T, xi[keep] => - between * np.linalg.inv(omega[np.ix_(removed, removed)]) * between.T, xi[keep]
            In omega you multiply with *, entry by entry. The product of matrices is @: B @ C^-1 @ Bᵀ.
        * for @ in xi: xi[keep] - share @ xi[removed] => xi[keep] - share * xi[removed]
            In xi you multiply with *, entry by entry. The product of a matrix and a vector is @, too.
        B missing: np.linalg.solve(omega[np.ix_(removed, removed)], between.T).T => np.linalg.inv(omega[np.ix_(removed, removed)])
            In equation 8.5 the block B = omega[np.ix_(keep, removed)] stands before the inverse: B C^-1 Bᵀ in omega and B C^-1 xi[removed] in xi. You left it out.
        B missing in omega: - share @ between.T => - np.linalg.inv(omega[np.ix_(removed, removed)]) @ between.T
            In omega the first block of the second term is missing: B C^-1 Bᵀ, where B is omega[np.ix_(keep, removed)].
        B missing in xi: xi[keep] - share @ xi[removed] => xi[keep] - np.linalg.inv(omega[np.ix_(removed, removed)]) @ xi[removed]
            In xi the first block of the second term is missing: B C^-1 xi[removed], where B is omega[np.ix_(keep, removed)].
        the last block missing: - share @ between.T => - share
            In omega the last block of the second term is missing: B C^-1 Bᵀ, where Bᵀ is omega[np.ix_(removed, keep)].
        plus in omega: - share @ between.T => + share @ between.T
            In omega you add the second term of equation 8.5. Subtract it.
        plus: share = np.linalg.solve => share = -np.linalg.solve
            You add the second terms of equation 8.5. Subtract them, in omega and in xi.
        plus, sorted: + keep = sorted(keep)
            share = np.linalg.solve => share = -np.linalg.solve
            There are two errors. You add the second terms of equation 8.5: subtract them. And you return the variables sorted, but `keep` gives their order.
        plus in omega and xi only cut out: - share @ between.T => + share @ between.T
            xi[keep] - share @ xi[removed] => xi[keep]
            Your function has two errors. In omega you add the second term of equation 8.5; subtract it. And in xi the second term is missing.
        xi only cut out: xi[keep] - share @ xi[removed] => xi[keep]
            In xi the second term of equation 8.5 is missing: the removed variables have entries on the right side, too.
        plus in xi: xi[keep] - share => xi[keep] + share
            In xi you add the second term of equation 8.5. Subtract it.
        no inverse: np.linalg.solve(omega[np.ix_(removed, removed)], between.T).T => between
            You compute B Bᵀ. The inverse of the block of the removed variables is missing: B C^-1 Bᵀ.
        C for its inverse: np.linalg.solve(omega[np.ix_(removed, removed)], between.T).T => between @ omega[np.ix_(removed, removed)]
            You multiply by the block of the removed variables. Multiply by its inverse instead, with np.linalg.solve.
        C for its inverse in omega: - share @ between.T => - between @ omega[np.ix_(removed, removed)] @ between.T
            In omega you multiply by the block of the removed variables. Multiply by its inverse instead: B C^-1 Bᵀ.
        no inverse in xi: xi[keep] - share @ xi[removed] => xi[keep] - between @ xi[removed]
            In xi the inverse of the block of the removed variables is missing: subtract B C^-1 xi[removed].
        sorted, and xi only cut out: + keep = sorted(keep)
            xi[keep] - share @ xi[removed] => xi[keep]
            There are two errors. In xi the second term of equation 8.5 is missing. And you return the variables sorted (as a boolean mask does), but `keep` gives their order.
        only the diagonal: np.linalg.solve(omega[np.ix_(removed, removed)], between.T).T => between / np.diag(omega[np.ix_(removed, removed)])
            You invert only the diagonal of the block. The removed variables are linked with each other, so invert the whole block.
        sorted: + keep = sorted(keep)
            You return the variables sorted. Return them in the order of `keep`.
        keep and removed exchanged: + keep = [number for number in range(len(xi)) if number not in keep]
            You removed the variables in `keep`. Keep them, and remove the others.
        in place: return omega => answer = omega
            + omega[:], xi[:] = 0.0, 0.0
            + return answer
            You changed the arrays that you were given. Return new arrays.
    """),
    alternatives={
        "both sides solved at once": _by_solving,
        "one variable after the other": _one_by_one,
        "a Cholesky factor": _by_a_factor,
    },
)


# --- 8.6 solve_sparse ---
def _network(
    rng: np.random.Generator,
    poses: int,
    every: int,
    form: str,
    starts: int = 1,
    *,
    shuffled: bool = True,
    at_zero: bool = False,
) -> tuple[Any, Array]:
    """Return a long corridor with a landmark every few poses, its variables in mixed order or poses first.

    at_zero: everything is at 0 and measured without noise. Then the answers of all mistakes are 0, too, and the check
    data of a large public case stays small.
    """
    marks = np.arange(poses // every)
    seen_from = [np.minimum(every * marks + away * every // 2, poses - 1) for away in range(1, 5)]
    i = np.concatenate([np.arange(poses - 1), *seen_from])
    j = np.concatenate([np.arange(1, poses), *[poses + marks] * 4])
    size, weight = poses + len(marks), 1 / rng.uniform(0.25, 4.0, len(i)).round(1)
    order = rng.permutation(size) if shuffled else np.arange(size)
    i, j = order[i], order[j]
    truth, noise = rng.normal(0.0, 5.0, size), rng.normal(0.0, 0.1, len(i))
    if at_zero:
        weight, truth, noise = np.ones(len(i)), 0 * truth, 0 * noise
    right = weight * (truth[j] - truth[i] + noise)
    held = order[rng.choice(poses, starts, replace=False)]
    places = np.concatenate([i, j, i, j, held]), np.concatenate([i, j, j, i, held])
    values = np.concatenate([weight, weight, -weight, -weight, np.ones(starts)])
    omega = scipy.sparse.coo_array((values, places), shape=(size, size)).asformat(form)
    xi = np.bincount(j, right, size) - np.bincount(i, right, size)
    xi[held] += truth[held]
    return omega, xi


def _walk(rng: np.random.Generator, poses: int) -> tuple[Any, Array]:
    """Return motions without a start."""
    weight = 1 / rng.uniform(0.25, 4.0, poses - 1).round(1)
    own = np.append(weight, 0.0) + np.append(0.0, weight)
    omega = scipy.sparse.diags_array([own, -weight, -weight], offsets=[0, 1, -1], format="csr")
    return omega, np.append(-weight, 0.0) + np.append(0.0, weight)


def _sparse(pair: Pair, form: str) -> tuple[Any, Array]:
    return scipy.sparse.csr_array(pair[0]).asformat(form), pair[1]


def _sparse_public() -> list[Case]:
    rng = np.random.default_rng(86)
    parts = [(0, 1, 2.0, 1.0), (1, 4, 3.0, 0.5), (2, 3, 1.0, 2.0)]
    return [
        Case(_sparse(PAPER, "csc"), "the example of the text"),
        Case(_sparse(a_solved_drive(rng, 8, 4), "csr"), "a drive, as csr"),
        Case(_sparse(linked(3, [(0, 1, 10.0, 1.0), (1, 2, 5.0, 2.0)], {}), "csc"), "no start at all"),
        Case(
            _sparse(linked(6, parts, {0: -4.0}), "csr"), "two parts, and a landmark that was never measured"
        ),
        Case(_network(rng, 1000, 5, "csr", 20), "1200 variables in mixed order"),
        Case(_walk(rng, 1100), "a walk of 1100 poses without a start"),
        Case(
            _network(np.random.default_rng(87), 6000, 1, "csc", 60, shuffled=False, at_zero=True),
            "12,000 variables, poses first: a poor order takes a minute",
        ),
        Case(
            _sparse(linked(8, a_drive(np.random.default_rng(870), 6, 2, (0.0008, 0.001)), {0: 1.0}), "csc"),
            "a drive in metres, measured to 3 cm",
        ),
        Case(
            _sparse(_precise(np.random.default_rng(843)), "csr"),
            "weights of 1e8, and five parts without a start",
        ),
        Case(
            _sparse(_held(np.random.default_rng(845), at_zero=True), "csc"),
            "25 steps known to 0.1 mm, in metres, and a start",
        ),
    ]


def _sparse_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case(_network(rng, 30_000, 5, "csr", 300)),
        Case(_network(rng, 16_000, 2, "csc", 160, shuffled=False)),  # as numbered, its factor is nearly full
        Case(_network(rng, 2_000, 4, "csc", 20)),
        Case(_network(rng, 300, 3, "coo")),
        Case(_walk(rng, 1500)),
        Case(_sparse(_coarse(rng), "csc")),
        Case(_sparse(_fine(rng), "csr")),
        Case(_sparse(_precise(rng), "csc")),
        Case(_sparse(_held(rng, at_zero=True), "csr")),
        Case(_sparse(linked(9, a_drive(rng, 6, 3, (0.0008, 0.001)), {2: float(rng.normal())}), "csr")),
        Case(_sparse(a_solved_drive(rng, 12, 5), "csc")),
        *(Case(_sparse(_in_parts(rng, size), "csr")) for size in (3, 6)),
        Case(_sparse(linked(12, a_drive(rng, 6, 4), {0: float(rng.normal())}), "csc")),
        Case(_sparse(linked(30, a_drive(rng, 24, 6), {}), "csc")),
    ]


def _spsolve(omega: Any, xi: Array) -> Any:
    _refuse(unheld(omega))
    return scipy.sparse.linalg.spsolve(omega.tocsc(), xi)


def _banded(omega: Any, xi: Array) -> Array:
    _refuse(unheld(omega))
    order = scipy.sparse.csgraph.reverse_cuthill_mckee(omega.tocsr(), symmetric_mode=True)
    near = scipy.sparse.tril(omega.tocsr()[order][:, order]).tocoo()
    below = near.row - near.col
    bands = np.zeros((int(below.max(initial=0)) + 1, len(xi)))
    bands[below, near.col] = near.data
    x = np.empty(len(xi))
    x[order] = scipy.linalg.solveh_banded(bands, xi[order], lower=True)
    return x


def _gradients(omega: Any, xi: Any) -> Any:
    _refuse(unheld(omega))
    scale = scipy.sparse.diags_array(1 / omega.diagonal())
    x, _ = scipy.sparse.linalg.cg(omega, xi, rtol=1e-12, atol=0.0, maxiter=20 * len(xi), M=scale)
    return x.tolist()


SOLVE_SPARSE = Exercise(
    name="solve_sparse",
    points=4,
    stars=3,
    public=_sparse_public,
    hidden=_sparse_hidden,
    comparison=SolvedOrNamed(),
    driver=DRIVER,
    seconds=10.0,  # a poor order takes a minute, a good one milliseconds
    hints=(
        "connected_components returns the number of groups and, for each variable, the number of its group. np.bincount with weights adds up the row sums of omega in each group. What is this total without a start, and what with one?",
        'An edge adds 0 to the sum of a row, and a start adds 1. So a group is held if the sums of its rows add up to more than rounding errors. For the order, splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A") applies minimum degree to the pattern of omega + omega.T.',
    ),
    sibling=Sibling(
        "The numbers of each group are added up with np.bincount, and the result is brought back to the members with the group's number as the index: here the villages without a doctor on their island.",
        """
        import numpy as np

        island = np.array([0, 0, 1, 2, 1])  # of each village
        doctors = np.array([0.1 + 0.2 - 0.3, 0.0, 1.0, 0.0, 0.0])  # the first is 0 up to rounding
        on_island = np.bincount(island, doctors)
        print(on_island.round(3), on_island[island] < 0.5)
        print(np.flatnonzero(on_island[island] < 0.5))
        """,
        """
        [0. 1. 0.] [ True  True False  True False]
        [0 1 3]
        """,
    ),
    mistakes=catalogue("""
        in the order of the numbers: permc_spec="MMD_AT_PLUS_A" => permc_spec="NATURAL"
            permc_spec="NATURAL" eliminates the variables in the order of their numbers. If the poses come first, this links nearly all landmarks with each other, as in the middle picture above. Leave the order to splu, or choose an order with little fill-in.
        dense: + omega = omega.toarray()
            return scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi) => return np.linalg.solve(omega, xi)
            You make the sparse matrix dense. This works for a hundred variables, but 30,000 variables need 7 GB. Keep it sparse, and use the solvers in scipy.sparse.linalg.
        dense, and names nothing: + return np.linalg.solve(omega.toarray(), xi)
            There are two errors. You make the matrix dense, which works only for a few thousand variables. And if nothing holds a part, you must name its variables in a ValueError.
        NumPy's solve: + return np.linalg.solve(omega, xi)
            np.linalg.solve does not accept sparse matrices. Use a solver of scipy.sparse.linalg.
        spsolve alone: + import warnings
            + with warnings.catch_warnings(action="ignore"):
            +     return scipy.sparse.linalg.spsolve(omega.tocsc(), xi)
            Your solutions are right. But if the system is singular, spsolve only warns and returns NaN. Check before you solve, and raise a ValueError with the numbers of the variables.
        names nothing: f"nothing holds {', '.join(map(str, loose))}" => "the factor is exactly singular"
            Your solutions are right. If nothing holds a part, the message of the ValueError must contain the numbers of its variables, as in solve.
        only those without a constraint: starts[part] < 0.5 => omega.diagonal() == 0
            + if starts.min() < 0.5 and not len(loose):
            +     raise ValueError("the factor is exactly singular")
            You name the variables without any constraint. A group of linked variables without a start can also be moved: name its variables, too.
        all variables: str, loose => str, range(len(xi))
            You name all variables. Leave out the variables that are connected to a start.
        all but one part: str, loose => str, np.flatnonzero(part != part[0])
            You treat one part as held, either the part of variable 0 or the largest part. A part is held if it contains a start, and there may be none.
        all parts but the first: starts[part] < 0.5 => part != part[0]
            You treat the part of variable 0 as held. A part is held only if it contains a start, and the first part may have none.
        all, if splu notices: + try:
            +     return scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi)
            + except RuntimeError as error:
            +     raise ValueError(f"nothing holds {list(range(len(xi)))}") from error
            There are two errors. Because of rounding, splu does not notice every singular matrix. And you name all variables: leave out the variables that are connected to a start.
        a large sum only: starts[part] < 0.5 => starts[part] < 1e-3 * omega.diagonal().max()
            Your limit for the sum of the rows is too large. A start adds 1, and measurements of 3 cm add weights of 1,000 to the diagonal. Compare with a much smaller fraction of the weights.
        too large a fraction: starts[part] < 0.5 => starts[part] < 1e-6 * omega.diagonal().max()
            Your limit for the sum of the rows is too large a fraction of the weights. Steps known to 0.1 mm have weights of 1e8, and a start still adds 1. Rounding leaves about 1e-16 of the weights, so use a fraction such as 1e-12.
        a fixed limit: starts[part] < 0.5 => starts[part] < 1e-9
            Your limit for the sum of the rows is a fixed number that is too small. With weights of 1e8, rounding errors alone are larger. Compare with a small fraction of the weights.
        a sum that is exactly 0: starts[part] < 0.5 => starts[part] == 0
            + import warnings
            return scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi) => with warnings.catch_warnings(action="ignore"):
            +     return scipy.sparse.linalg.spsolve(omega.tocsc(), xi)
            You compare a sum of floats with exactly 0 (== 0, > 0 or < 0). Rounding leaves about 1e-16 of the weights. Compare with a small fraction of the weights instead.
        numbers left out: {', '.join(map(str, loose))} => {loose}
            NumPy prints a long array with ... in its middle, so your message lacks most of the numbers. Use a list: array.tolist().
        what splu notices: + try:
            +     return scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi)
            + except RuntimeError as error:
            +     raise ValueError(str(error)) from error
            You rely on splu's RuntimeError. It names no variable, and because of rounding splu does not notice every singular matrix. Check the connected parts before you solve, and name the variables.
        in the order of the numbers, and names nothing: + try:
            +     return scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="NATURAL").solve(xi)
            + except RuntimeError as error:
            +     raise ValueError(str(error)) from error
            There are two errors. permc_spec="NATURAL" keeps the order of the numbers, which fills the factor: choose another one. And splu's error names no variable: check the connected parts before you solve.
        what splu raises: + return scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi)
            Your solutions are right. If nothing holds a part, splu raises a RuntimeError without any numbers. Check before you solve, and raise a ValueError with the numbers of the variables.
        not sorted back
            return scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi) => order = scipy.sparse.csgraph.reverse_cuthill_mckee(omega.tocsr(), symmetric_mode=True)
            + omega = omega.tocsc()[order][:, order]
            + return scipy.sparse.linalg.spsolve(omega, xi[order], permc_spec="NATURAL")
            You reorder the rows, the columns and xi before you solve, so x has the new order, too. Undo it with x[order] = ...
        stopped early: scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi) => scipy.sparse.linalg.cg(omega, xi, rtol=1e-3)[0]
            Your solutions are close but not exact. An iterative solver stops at a tolerance, and its default is coarse: set a smaller one, or use a direct solver.
        the default tolerance: scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi) => scipy.sparse.linalg.cg(omega, xi)[0]
            Your iterative solver stopped before x was exact: at its tolerance, which is too coarse by default, or after its largest number of iterations. Set both (cg: rtol=1e-12 and maxiter; lsqr: atol, btol and iter_lim), or use a direct solver such as splu.
        lsqr: scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi) => scipy.sparse.linalg.lsqr(omega, xi)[0]
            lsqr stopped before x was exact: it squares the condition number, and its default tolerances are coarse. Use a direct solver such as splu.
        a method: .solve(xi) => .solve
            You return the method `solve` of the factor. Call it with xi.
        each variable alone, exactly: starts[part] < 0.5 => omega.sum(axis=1) == 0
            You demand a start of every variable. A variable is also held if edges connect it to a start: find the connected parts, and add up the sums of the rows in each part.
        each variable alone, by a fraction: starts[part] < 0.5 => abs(omega.sum(axis=1)) <= 1e-12 * abs(omega).max()
            You demand a start of every variable. A variable is also held if edges connect it to a start: find the connected parts, and add up the sums of the rows in each part. A limit that is a fraction does not change this.
        numbers of groups: starts[part] < 0.5 => starts < 0.5
            You name the numbers of the groups. Name the variables in them: np.flatnonzero(bad[labels]), where bad says for each group whether it lacks a start, and labels holds the group of each variable.
        strictly less than a part of nothing: starts[part] < 0.5 => (starts < 1e-12 * np.bincount(part, omega.diagonal(), count))[part]
            You miss the variable without any constraint. Its weights are 0, and 0 < limit * 0 is false. Use <=.
        less than one start: starts[part] < 0.5 => starts[part] < 1
            A start adds 1 only up to rounding, so the sum of a part that is held can be a little less than 1. Ask whether the sum is more than rounding errors.
        less than one start, by NumPy's sum: starts[part] < 0.5 => np.bincount(part, omega.sum(axis=1), count)[part] < 1
            A start adds 1 only up to rounding, so the sum of a part that is held can be a little less than 1. Ask whether the sum is more than rounding errors. This is so however you add up the rows.
        exactly one start: starts[part] < 0.5 => starts[part] != 1
            A start adds 1 only up to rounding, and a part may have several starts. Ask whether the sum is more than rounding errors.
        close to one start: starts[part] < 0.5 => ~np.isclose(starts, 1)[part]
            A part may have several starts, each of which adds 1. Ask whether the sum is more than rounding errors.
        no entry on the diagonal: starts[part] < 0.5 => omega.diagonal() == 0
            You find only variables without any constraint. A group of linked variables may have no start either: find the connected parts, and add up the sums of the rows in each part.
        each variable alone: starts[part] < 0.5 => np.abs(omega @ np.ones(len(xi))) < 1e-9
            You demand a start of every variable. A variable is also held if edges connect it to a start: find the connected parts, and add up the sums of the rows in each part. The size of the limit does not change this.
        cg, and names nothing: + return scipy.sparse.linalg.cg(omega, xi)[0]
            There are two errors. cg stops at its tolerance, which is too coarse by default: set rtol=1e-12 and maxiter, or use splu. And it does not notice that nothing holds a part: find these parts before you solve, and name their variables.
        cg alone: + return scipy.sparse.linalg.cg(omega, xi, rtol=1e-12, maxiter=100 * len(xi))[0]
            Your solutions are right. But if nothing holds a part, cg returns one of many solutions. Find these parts before you solve, and name their variables in a ValueError.
        the solver's report, too: scipy.sparse.linalg.splu(omega.tocsc(), permc_spec="MMD_AT_PLUS_A").solve(xi) => scipy.sparse.linalg.cg(omega, xi)
            cg returns x and a status code. Return x only, and set rtol to 1e-12, because the default is too coarse.
        a little on the diagonal: + return scipy.sparse.linalg.spsolve((omega + 1e-6 * scipy.sparse.eye_array(len(xi))).tocsc(), xi)
            You add something to the diagonal to make the matrix invertible. This pulls every variable towards 0 and hides the missing start. Raise a ValueError instead.
    """),
    alternatives={"spsolve": _spsolve, "a narrow band": _banded, "conjugate gradients": _gradients},
    equivalents={
        "return scipy.sparse.linalg.splu(omega.tocsc()).solve(xi)": "SciPy's default order, COLAMD, also has little fill-in here",
        "return scipy.sparse.linalg.splu(omega, permc_spec='MMD_AT_PLUS_A').solve(xi)": "splu converts the matrix to csc itself, with a warning",
        "loose = np.flatnonzero(starts[part] <= 0.5)": "the number of starts is an integer, up to rounding",
        "starts = np.bincount(part, np.ones(len(xi)) @ omega, count)": "omega is symmetric",
    },
)


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
            "Suppose that you leave out both -1: for a motion of 10 steps you add only 1 to both diagonal entries of Omega, and -10 and 10 to xi. What do the two rows then say?",
            {
                "The same as before, with a larger variance.": "A larger variance makes all entries smaller, but it does not remove any. Write out both rows.",
                "That the first variable is -10 and the second is 10.": "Without the -1 each row contains one variable only, like a start. Only the entries off the diagonal say that the two positions depend on each other.",
                "Nothing, because Omega then has no inverse.": "It is the other way round: this Omega can be inverted. With the -1, the rows that a motion adds sum to 0, so without a start Omega has no inverse.",
            },
            "That the first variable is -10 and the second is 10.",
        ),
        Question(
            "weight_of_the_start",
            "add_initial_position has the weight 1. What happens to the solution x if you give the only start the weight 100 instead?",
            {
                "The poses near the start move a little towards it.": "They would if another constraint pulled the start away. But no other constraint depends on where the map is, so the residual of the start is 0 with any weight.",
                "Nothing.": "All other constraints are about differences, so the whole map can be shifted until the residual of the start is 0. The covariance does change: with the weight 1, the standard deviation of the whole map's position is one unit.",
                "The map becomes smaller.": "The size of the map depends on differences only, and the start is not a difference.",
            },
            "Nothing.",
        ),
        Question(
            "zero_in_omega",
            "The entry of two landmarks in Omega is 0, but the inverse of Omega gives them a correlation of 0.8. Is one of these numbers wrong?",
            {
                "Yes: a 0 means that they are independent, so the correlation must be 0.": "The 0 means that they are independent once all other variables are known. But the poses are not known, and both landmarks were measured from them.",
                "No: no constraint links them directly, but both were measured from the same poses.": "Omega contains the edges, and its inverse combines all paths from one variable to the other.",
                "You need the measured values to decide.": "Omega and its inverse depend only on which measurements there are and on their variances. The measured values appear in xi only.",
            },
            "No: no constraint links them directly, but both were measured from the same poses.",
        ),
    ],
    written=[
        Written(
            "explain_filling",
            points=2,
            question="Why does removing the poses fill the landmarks' block, and what does this have to do with the filter of lesson 07?",
            rubric="1 point: removing a pose links all landmarks that were measured from it, and, through the motions, landmarks of different poses, so in the end all landmarks are linked with each other. 1 point: the filter keeps only the last pose and the landmarks, so it removes every older pose. Its matrix is therefore full, and the cost of each update grows with the square of the number of landmarks.",
        )
    ],
)
