"""Lesson 06, localization: its exercises, the mistakes that students make, and alternative correct solutions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.stats import chi2

from nao_course.exercises import Case, Close, Each, Exercise, LessonPlan, Question, Sibling, Written
from nao_course.geometry import rotation_2d, wrap_angle
from nao_course.instructor.authoring.mistakes import catalogue
from nao_course.lessons.ekf_derivations.mistakes import jacobian_at
from nao_course.lessons.localization import personal_numbers
from nao_course.slam import range_and_bearing

Array = npt.NDArray[Any]


def random_covariance(rng: np.random.Generator, size: int, *, scale: float = 1.0) -> Array:
    """Return a covariance (size, size) with correlations and standard deviations around `scale`."""
    root = rng.normal(0.0, 0.5, (size, size)) + np.eye(size) * rng.uniform(0.6, 1.2, size)
    return scale**2 * (root @ root.T)


def errors(
    rng: np.random.Generator, sizes: tuple[int, ...], sigma: float, low: float, high: float
) -> list[Case]:
    """Return cases of errors or innovations of these sizes, each with a covariance."""
    return [
        Case((rng.normal(0, sigma, size), random_covariance(rng, size, scale=float(rng.uniform(low, high)))))
        for size in sizes
    ]


# --- 6.1 fuse ---
FUSE = Exercise(
    name="fuse",
    points=2,
    public=lambda: [
        Case(
            (2.0, 0.04, 3.0, 0.01),
            "a prediction of 2 m, and a measurement of 3 m with half its standard deviation",
        ),
        Case((1.0, 0.25, 1.0, 0.25), "two estimates that agree"),
        Case((-1.0, 0.01, 2.0, 0.09), "a measurement with three times the prediction's standard deviation"),
        Case((4.0, 4.0, 1.0, 9.0), "variances above one"),
    ],
    hidden=lambda rng: [
        Case((float(a), float(va), float(b), float(vb)))
        for (a, b), (va, vb) in zip(rng.uniform(-5, 5, (8, 2)), rng.uniform(0.02, 3, (8, 2)), strict=True)
    ],
    comparison=Close(atol=1e-9, names=("your mean", "your variance")),
    hints=(
        "Set the derivative of v(w) to zero and solve for w. Check the result: if variance_a is much larger than variance_b, w should be close to 1.",
        "weight = variance_a / (variance_a + variance_b). The mean moves this fraction of the way from a to b, and v(w) simplifies to (1 - weight) * variance_a.",
    ),
    sibling=Sibling(
        "The heat in two parallel wires depends on w and 1 - w as the variance of a weighted mean does, and it is smallest where its derivative is zero.",
        """
        one, two = 2.0, 6.0  # ohm; one carries the part w of the current, two the rest


        def heat(w):
            return one * w**2 + two * (1 - w) ** 2


        w = two / (one + two)  # 2 one w - 2 two (1 - w) = 0
        print(w, heat(w), heat(w - 0.01) > heat(w) < heat(w + 0.01))
        """,
        "0.75 1.5 True",
    ),
    mistakes=catalogue("""
        weights exchanged: mean_a + weight => mean_a + (1 - weight)
            Your mean is closer to the less precise estimate. The larger variance_a is, the more weight b should get, so the weight of b is variance_a divided by the sum.
        weights exchanged in both lines: mean_a + weight => mean_a + (1 - weight)
            (1 - weight) * variance_a => weight * variance_a
            Your mean is closer to the less precise estimate, and your variance uses the same exchanged weight. The larger variance_a is, the more weight b should get, so the weight of b is variance_a divided by the sum.
        standard deviations: mean_a + weight => mean_a + variance_a**0.5 / (variance_a**0.5 + variance_b**0.5)
            Your mean uses standard deviations as weights. The derivation gives variances, so leave out the square roots.
        standard deviations in both lines: mean_a + weight => mean_a + variance_a**0.5 / (variance_a**0.5 + variance_b**0.5)
            (1 - weight) * variance_a => variance_b**0.5 / (variance_a**0.5 + variance_b**0.5) * variance_a
            Your mean and your variance use standard deviations as weights. The derivation gives variances, so leave out the square roots.
        weights exchanged in v(w): mean_a + weight => mean_a + (1 - weight)
            (1 - weight) * variance_a => weight**2 * variance_a + (1 - weight) ** 2 * variance_b
            Your formulas for the mean and v(w) are right, but your w is the weight of a. The larger variance_a is, the more weight b should get, so w is variance_a divided by the sum.
        standard deviations in v(w): mean_a + weight => mean_a + variance_a**0.5 / (variance_a**0.5 + variance_b**0.5)
            (1 - weight) * variance_a => 2 * variance_a * variance_b / (variance_a**0.5 + variance_b**0.5) ** 2
            Your formulas for the mean and v(w) are right, but your w is computed from standard deviations. The derivation gives variances, so leave out the square roots.
        variances squared: variance_a / (variance_a + variance_b) => variance_a**2 / (variance_a**2 + variance_b**2)
            Your weight squares the variances. The arguments are variances, sigma squared, already, so use them as they are.
        variances squared in v(w): variance_a / (variance_a + variance_b) => variance_a**2 / (variance_a**2 + variance_b**2)
            (1 - weight) * variance_a => (1 - weight) ** 2 * variance_a + weight**2 * variance_b
            Your formulas for the mean and v(w) are right, but your w squares the variances. They are sigma squared already, so use them as they are.
        parentheses forgotten: variance_a / (variance_a + variance_b) => variance_a / variance_a + variance_b
            Your weight is 1 + variance_b, because division comes before addition. Put the sum in parentheses.
        variance first: return mean, (1 - weight) * variance_a => return (1 - weight) * variance_a, mean
            You return (variance, mean). Return the mean first.
        taken for standard deviations: + variance_a, variance_b = variance_a**2, variance_b**2
            You square the arguments. They are variances, sigma squared, already, so use them as they are in both results.
        the other part of the variance: (1 - weight) => weight
            Your variance is w * variance_a. Insert your w into v(w) again: it simplifies to (1 - w) * variance_a.
        the smaller variance: (1 - weight) * variance_a => min(variance_a, variance_b)
            Your variance is the smaller one of the two. The less precise estimate also contains information, so the fused variance is below both.
        plain average: mean_a + weight => mean_a + 0.5
            Your mean is always halfway between the two estimates. The more precise one needs a larger weight.
        plain average in both lines: mean_a + weight => mean_a + 0.5
            (1 - weight) * variance_a => (variance_a + variance_b) / 4
            You use w = 0.5 in both results. Derive the w for which v(w) is smallest: it depends on the variances.
        away from b: mean_a + weight => mean_a - weight
            Your mean moves away from b. Equation 6.1 adds w * (b - a) to a.
        inverses added: (1 - weight) * variance_a => 1 / variance_a + 1 / variance_b
            Your variance is 1 / variance_a + 1 / variance_b. That is the inverse of the fused variance, so divide 1 by it.
        variances added: (1 - weight) * variance_a => variance_a + variance_b
            Your variance is the sum of both, which is the variance of the difference b - a. The fused estimate is more precise than either, so its variance is below both.
        averaged variance: (1 - weight) * variance_a => (variance_a + variance_b) / 2
            Your variance is between the two. The fused estimate is more precise than either, so its variance is below both.
        weighted variance: (1 - weight) * variance_a => variance_a + weight * (variance_b - variance_a)
            You average the variances with the weights of the means. In v(w) the weights are squared: (1 - w)^2 variance_a + w^2 variance_b.
        one weight not squared: (1 - weight) * variance_a => (1 - weight) ** 2 * variance_a + weight * variance_b
            You square only the first weight of v(w). It is (1 - w)^2 variance_a + w^2 variance_b.
        half of the variance: (1 - weight) * variance_a => (1 - weight) ** 2 * variance_a
            Your variance is only the first term of v(w). Add the second one, w^2 variance_b.
        standard deviation returned: (1 - weight) * variance_a => ((1 - weight) * variance_a) ** 0.5
            Your second value is the standard deviation. Return the variance: leave out the square root.
    """),
    alternatives={
        "information adds up": lambda a, v, b, w: ((a / v + b / w) / (1 / v + 1 / w), 1 / (1 / v + 1 / w)),
        "float32": lambda a, v, b, w: np.float32([np.average([a, b], weights=[w, v]), v * w / (v + w)]),
        "a gain, a list": lambda a, v, b, w: [a - v / (v + w) * (a - b), v / (v + w) * w],
    },
)


# --- 6.2 innovation ---
_BEHIND = "a landmark behind: 170 degrees expected, -175 measured"


def _innovation_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for _ in range(8):
        bearing, error = rng.uniform(-np.pi, np.pi), rng.uniform(-2.5, 2.5)
        expected = np.array([bearing, rng.uniform(0.3, 3)])
        cases.append(Case((expected, np.array([wrap_angle(bearing + error), rng.uniform(3.5, 9)]))))
    for bearing in (3.0, -3.0):
        cases.append(Case((np.array([bearing, 1.0]), np.array([-bearing + rng.uniform(-0.05, 0.05), 5.0]))))
    return cases


def _with_a_loop(expected: Array, measured: Array) -> list[float]:
    bearing, distance = measured - expected
    while abs(bearing) > np.pi:
        bearing -= 2 * np.pi * np.sign(bearing)
    return [bearing, distance]


INNOVATION = Exercise(
    name="innovation",
    points=2,
    public=lambda: [
        Case((np.array([0.3, 2.0]), np.array([0.35, 1.9])), "a bearing a little to the left"),
        Case((np.array([2.967, 1.5]), np.array([-3.054, 1.6])), _BEHIND),
        Case(
            (np.array([-3.0, 2.5]), np.array([3.1, 2.0])),
            "a landmark behind: -172 degrees expected, 178 measured",
        ),
        Case((np.array([-1.2, 0.8]), np.array([-1.2, 0.8])), "exactly as expected"),
        Case((np.array([0.0, 1.0]), np.array([-0.1, 6.0])), "a landmark 5 m farther away than expected"),
        Case(
            (np.array([1.0, 1.5]), np.array([-1.2, 1.5])), "126 degrees to the right of the expected bearing"
        ),
        Case(
            (np.array([-0.5, 1.5]), np.array([1.5, 1.2])), "115 degrees to the left of the expected bearing"
        ),
    ],
    hidden=_innovation_hidden,
    comparison=Close(atol=1e-9, names=("the bearing", "the range")),
    hints=(
        "Subtract expected from measured. Then change only the bearing: if it is above pi or below -pi, add or subtract full turns. The range is a length and stays as it is.",
        "(angle + np.pi) % (2 * np.pi) - np.pi maps an angle to [-pi, pi). Return a new array, np.array([bearing, range]).",
    ),
    sibling=Sibling(
        "Of two differences only the one on a circle is wrapped: a train at minute 58 instead of minute 3 is 5 minutes early, but the price is not periodic.",
        """
        import numpy as np

        planned, real = np.array([3.0, 40.0]), np.array([58.0, 75.0])  # minute and price
        minutes, price = real - planned
        minutes = (minutes + 30) % 60 - 30
        print(minutes, price)
        """,
        "-5.0 35.0",
    ),
    mistakes=catalogue("""
        sign: return => return -
            Your innovation is expected minus measured. Subtract the other way round, measured minus expected, so that the filter moves towards the measurement.
        not wrapped: (bearing + np.pi) % (2 * np.pi) - np.pi => bearing
            Your innovation is right, except that the bearing can be off by a full turn: from 170 to -175 degrees you get -345, but it is 15. Reduce the bearing's difference to the range from -pi to pi; if you wrap at 180, remember that it is in radians.
        the wrong remainder: (bearing + np.pi) % (2 * np.pi) - np.pi => (bearing + np.pi) % 2 * np.pi - np.pi
            % and * are evaluated from left to right, so ... % 2 * np.pi is a remainder by 2, times pi. Write % (2 * np.pi).
        arctan2 of cosine and sine: (bearing + np.pi) % (2 * np.pi) - np.pi => np.arctan2(np.cos(bearing), np.sin(bearing))
            np.arctan2 takes the sine first, then the cosine.
        always down: (bearing + np.pi) % (2 * np.pi) - np.pi => bearing - 2 * np.pi * (abs(bearing) > np.pi)
            You subtract a full turn if the difference is above pi, which is right, but also if it is below -pi. There, add a full turn.
        always half a turn down: (bearing + np.pi) % (2 * np.pi) - np.pi => bearing - np.pi * (abs(bearing) > np.pi)
            There are two errors: a full turn is 2 * np.pi; and if the difference is below -pi, add a full turn.
        range wrapped: distance]) => (distance + np.pi) % (2 * np.pi) - np.pi])
            You wrap the range, too. It is in metres, so a difference of 5 m must stay 5 m. Wrap the bearing only.
        both from 0: (bearing + np.pi) % (2 * np.pi) - np.pi, distance => bearing % (2 * np.pi), distance % (2 * np.pi)
            You take the remainder by 2 pi of both values. The range is in metres, so leave it as it is, and the bearing's difference must lie between -pi and pi, because a small difference to the right is negative.
        0 to a full turn: (bearing + np.pi) % (2 * np.pi) - np.pi => bearing % (2 * np.pi)
            Your bearings are between 0 and 2 pi, so a small difference to the right becomes nearly a full turn to the left. Use the range from -pi to pi.
        half a turn: (bearing + np.pi) % (2 * np.pi) - np.pi => (bearing + np.pi / 2) % np.pi - np.pi / 2
            You subtract half turns, so opposite directions become the same. A full turn is 2 pi. The arctangent of a tangent has this problem, too.
        half a turn for a full one: (bearing + np.pi) % (2 * np.pi) - np.pi => bearing - np.pi * (bearing > np.pi) + np.pi * (bearing < -np.pi)
            You add or subtract pi, which is half a turn. A full turn is 2 * np.pi.
        0 to half a turn: (bearing + np.pi) % (2 * np.pi) - np.pi => bearing % np.pi
            You take the remainder by half a turn, so the difference is never negative and opposite directions become the same. Use the range from -pi to pi, and full turns of 2 * np.pi.
        arcsin: (bearing + np.pi) % (2 * np.pi) - np.pi => np.arcsin(np.sin(bearing))
            The arcsine of a sine is between -90 and 90 degrees, so 126 degrees become 54. Use np.arctan2 of sine and cosine, or the remainder operator %.
        one side only: (bearing + np.pi) % (2 * np.pi) - np.pi => bearing - 2 * np.pi * (bearing > np.pi)
            You subtract a full turn if the difference is above pi, which is right. If it is below -pi, add a full turn.
        the other side only: (bearing + np.pi) % (2 * np.pi) - np.pi => bearing + 2 * np.pi * (bearing < -np.pi)
            You add a full turn if the difference is below -pi, which is right. If it is above pi, subtract a full turn.
        bearing without sign: (bearing + np.pi) % (2 * np.pi) - np.pi => abs((bearing + np.pi) % (2 * np.pi) - np.pi)
            Your bearing's difference is never negative. Its sign says whether the landmark is farther to the left or to the right than expected, so leave out the absolute value.
        no sign left: np.array => np.abs
            Your innovation has lost its sign. The filter needs it to know in which direction to correct, so leave out the absolute value.
    """),
    alternatives={
        "wrap_angle": lambda e, m: np.append(wrap_angle(m[0] - e[0]), m[1] - e[1]),
        "a loop, a list": _with_a_loop,
        "complex numbers": lambda e, m: np.array([np.angle(np.exp(1j * (m[0] - e[0]))), m[1] - e[1]]),
    },
    equivalents={
        "return np.array([(bearing - np.pi) % (2 * np.pi) - np.pi, distance])": "a full turn less, which the remainder removes",
        "return [(bearing + np.pi) % (2 * np.pi) - np.pi, distance]": "a list of the same numbers",
    },
)


# --- 6.3 nees ---
def _nees_public() -> list[Case]:
    correlated = np.array([[0.09, 0.06], [0.06, 0.09]])
    return [
        Case((np.array([0.2, 0.0]), np.diag([0.04, 0.01])), "20 cm off along x, where sigma is 20 cm"),
        Case((np.array([0.0, 0.2]), np.diag([0.04, 0.01])), "20 cm off along y, where sigma is 10 cm"),
        Case((np.array([0.3, 0.3]), correlated), "an error along the long axis of the ellipse"),
        Case((np.array([0.3, -0.3]), correlated), "an equally long error across it"),
        Case(
            (np.array([0.1, -0.2, 0.05]), random_covariance(np.random.default_rng(61), 3, scale=0.3)),
            "a pose",
        ),
        Case(
            (np.array([2.0, 1.0, -3.0]), random_covariance(np.random.default_rng(62), 3, scale=2.0)),
            "a pose with a large error",
        ),
        Case(
            (np.array([0.06, -0.2]), np.array([[2, 3], [3, 20]]) / 1000),
            "an innovation, bearing and range correlated",
        ),
    ]


_SQUARES: dict[str, Any] = {
    "Cholesky": lambda e, C: np.sum(np.linalg.solve(np.linalg.cholesky(C), e) ** 2),
    "eigenvectors": lambda e, C: (np.linalg.eigh(C)[1].T @ e) ** 2 @ (1 / np.linalg.eigh(C)[0]),
    "columns and an inverse": lambda e, C: (e[None] @ np.linalg.inv(C) @ e[:, None]).item(),
}


_SQUARE_MISTAKES = catalogue("""
    no inverse: np.linalg.solve(covariance, error) => covariance @ error
        You multiply by the covariance. A larger covariance must give a smaller result, so multiply by its inverse or use np.linalg.solve.
    root: float( => np.sqrt(
        You return the square root, which is the Mahalanobis distance. Return the square itself, because it has the chi-square distribution.
    divided by the degrees: error)) => error)) / len(error)
        You divide by the number of components n. Leave that out: the chi-square distribution with n degrees of freedom describes the sum, whose average is n.
    diagonal only: np.linalg.solve(covariance, error) => (error / np.diag(covariance))
        Your result is right if the values are uncorrelated, because you use only the diagonal. Use the whole matrix: its inverse, or np.linalg.solve.
    each entry's inverse: + return error @ (1 / covariance) @ error
        You invert each entry of the matrix. The inverse of a matrix is a different one: use np.linalg.inv, or
        np.linalg.solve.
    divided entry by entry: + return error**2 / covariance
        You divide by each entry of the matrix, so the result is a matrix. Dividing by a matrix means multiplying by its inverse: vector @ inverse @ vector is a number.
    length divided: + return error @ error / covariance
        You divide the squared length by each entry of the matrix, so the result is a matrix. The inverse of the covariance belongs between the two vectors: vector @ inverse @ vector.
    solve exchanged: np.linalg.solve(covariance, error) => np.linalg.solve(error, covariance)
        The arguments of np.linalg.solve are exchanged. The matrix comes first: np.linalg.solve(covariance, error).
    still a matrix: + return error[None] @ np.linalg.inv(covariance) @ error[:, None]
        Your result is a matrix with one row and one column. Keep error as a vector of shape (n,); then
        vector @ matrix @ vector is a number.
    * for @: + return error * np.linalg.inv(covariance) * error
        You multiply entry by entry with *, so the result is a matrix. Use the matrix product @: vector @ matrix @ vector is a number.
    * for @, added up: + return np.sum(error * np.linalg.inv(covariance) * error)
        You multiply entry by entry with * and add up the entries. Use the matrix product @: vector @ matrix @ vector is a number.
    standard deviations for variances: + return np.sum((error / np.diag(covariance)) ** 2)
        You divide by the diagonal and then square. The diagonal has variances already, and the other entries are missing:
        use the inverse of the whole matrix.
    squared covariance: np.linalg.solve(covariance, error) => np.linalg.solve(covariance**2, error)
        You square the covariance. It contains variances, which are squared already, so use it as it is.
    a vector: + return np.linalg.solve(covariance, error)
        You return the inverse covariance times the error, which is a vector. Multiply it by the error once more, using @.
    no covariance: np.linalg.solve(covariance, error) => error
        You return the squared length, so the covariance has no influence. Divide by the covariance: multiply by its inverse.
""")


NEES = Exercise(
    name="nees",
    points=2,
    public=_nees_public,
    hidden=lambda rng: errors(rng, (1, 2, 2, 3, 3, 4, 6), 1.5, 0.4, 2),
    comparison=Close(atol=1e-9),
    hints=(
        "For one number it is error**2 / variance. For a vector the covariance matrix replaces the variance, so dividing becomes multiplying by the inverse matrix.",
        "np.linalg.solve(covariance, error) is the inverse times the error. Multiply the error with it, using @.",
    ),
    sibling=Sibling(
        "With a matrix, a division becomes a linear system: the energy of one spring is force**2 / (2 stiffness), and here two springs are coupled.",
        """
        import numpy as np

        stiffness = np.array([[5.0, 2.0], [2.0, 3.0]])
        force = np.array([1.0, -2.0])
        stretch = np.linalg.solve(stiffness, force)  # not force / stiffness, which divides entry by entry
        print(round(float(force @ stretch) / 2, 4))
        """,
        "1.4091",
    ),
    mistakes=_SQUARE_MISTAKES,
    alternatives=_SQUARES,
    equivalents={
        "return error @ np.linalg.solve(covariance, error)": "a NumPy number is a number",
        "return float(np.linalg.solve(covariance, error) @ error)": "the product of two vectors does not depend on their order",
    },
)


# --- 6.4 covariance_ellipse ---
def _closed_form(covariance: Array, probability: float) -> Any:
    (a, b), (_, d) = covariance.tolist()
    mean, radius = (a + d) / 2, np.hypot((a - d) / 2, b)  # Mohr's circle
    axes = np.sqrt(-2 * np.log1p(-probability) * np.array([mean + radius, max(mean - radius, 0.0)]))
    return axes.tolist(), float(np.arctan2(2 * b, a - d) / 2)


def _by_svd(covariance: Array, probability: float) -> Any:
    left, values, _ = np.linalg.svd(covariance)
    return np.sqrt(values * chi2.ppf(probability, 2)), float(np.arctan2(-left[1, 0], -left[0, 0]))


def _by_eig(covariance: Array, probability: float) -> Any:
    values, vectors = map(np.real, np.linalg.eig(covariance))  # complex since NumPy 2.5
    (x, y), axes = vectors[:, values.argmax()], np.sqrt(values * 2 * np.log(1 / (1 - probability)))
    return (max(axes), min(axes)), np.arctan(y / x) if x else np.pi / 2


def _ellipse_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for probability in (0.2, 0.5, 0.9, 0.95, 0.99, 0.6):
        turned = rotation_2d(rng.uniform(0.15, 1.4) + np.pi / 2 * rng.integers(0, 2))
        short, long = np.array([0.1, 0.5]) * rng.uniform(0.7, 1.4, 2)
        cases.append(Case((turned @ np.diag([long**2, short**2]) @ turned.T, probability)))
    return cases


COVARIANCE_ELLIPSE = Exercise(
    name="covariance_ellipse",
    points=3,
    stars=2,
    public=lambda: [
        Case((np.diag([0.09, 0.01]), 0.95), "long along x"),
        Case((np.diag([0.01, 0.04]), 0.95), "long along y"),
        Case((np.array([[0.05, 0.03], [0.03, 0.05]]), 0.95), "long along the diagonal"),
        Case((np.array([[0.3, -0.2], [-0.2, 0.6]]), 0.5), "long axis falling to the right, 50 %"),
        Case((np.array([[2.0, 0.9], [0.9, 0.7]]), 0.3935), "the one-sigma ellipse"),
    ],
    hidden=_ellipse_hidden,
    comparison=Each((Close(atol=1e-9), Close(atol=1e-6, period=np.pi)), names=("semi_axes", "the angle")),
    hints=(
        "np.linalg.eigh returns eigenvalues in ascending order and eigenvectors as columns. Each eigenvalue is the variance along its eigenvector, so equation 6.6 gives both semi-axes.",
        "The semi-axes are the square roots of the eigenvalues times np.sqrt(-2 * np.log(1 - probability)), the larger first. The angle is np.arctan2(y, x) of the last column, vectors[:, 1].",
    ),
    sibling=Sibling(
        "np.linalg.eigh returns the largest eigenvalue last, and its direction is the last column, not the last row: here the direction in which a block of rubber is stretched most.",
        """
        import numpy as np

        stretching = np.array([[3.0, 1.0, 0.0], [1.0, 2.0, 1.0], [0.0, 1.0, 5.0]])
        factors, directions = np.linalg.eigh(stretching)
        v = directions[:, -1]
        print(factors.round(2), np.allclose(stretching @ v, factors[-1] * v))
        print(np.allclose(stretching @ directions[-1], factors[-1] * directions[-1]))  # a row is wrong
        """,
        """
        [1.19 3.47 5.34] True
        False
        """,
    ),
    mistakes=catalogue("""
        root forgotten: np.sqrt(variances[::-1]) => variances[::-1]
            Your semi-axes use the eigenvalues, which are variances in m^2. Take their square roots.
        one sigma always: np.sqrt(-2 * np.log(1 - probability)) => 1.0
            Your ellipse does not depend on the probability. Multiply by the factor of equation 6.6.
        one dimension: + from scipy.stats import norm
            np.sqrt(-2 * np.log(1 - probability)) => norm.ppf((1 + probability) / 2)
            You use the factor for one dimension, 1.96 for 95 %. In the plane two values vary, and 95 % need 2.45: use equation 6.6.
        the rounded factor of one dimension: np.sqrt(-2 * np.log(1 - probability)) => 1.96
            You multiply by 1.96, the factor for 95 % in one dimension. In the plane it is 2.45 for 95 %, and it must depend on the argument probability: use equation 6.6.
        decimal logarithm: np.log(1 - probability) => np.log10(1 - probability)
            You use the decimal logarithm. Equation 6.6 has the natural logarithm, np.log.
        the 2 forgotten: -2 * np.log => -np.log
            Your semi-axes are too short by a factor of sqrt(2). Equation 6.6 has -2 ln(1 - p).
        outside for inside: 1 - probability => probability
            Your ellipse becomes smaller as the probability grows. Use ln(1 - p), not ln(p).
        radius squared: np.sqrt(-2 * np.log(1 - probability)) => -2 * np.log(1 - probability)
            You multiply by -2 ln(1 - p), which is a squared distance. Take its square root, too.
        both axes exchanged: variances[::-1] => variances
            directions[:, 1] => directions[:, 0]
            Your smaller semi-axis comes first, and your angle belongs to it. eigh sorts in ascending order, so the larger eigenvalue and its eigenvector are the last ones.
        small axis first: variances[::-1] => variances
            Your smaller semi-axis comes first. eigh sorts in ascending order, so reverse the eigenvalues.
        the minor axis's angle: directions[:, 1] => directions[:, 0]
            Your angle belongs to the shorter axis. Use the last eigenvector of eigh, which belongs to the largest eigenvalue.
        both axes and x and y exchanged: variances[::-1] => variances
            np.arctan2(y, x) => np.arctan2(x, y)
            Your smaller semi-axis comes first, and your angle is measured from the y axis. Reverse the eigenvalues of eigh, and call np.arctan2 with y first.
        not sorted: np.linalg.eigh(covariance) => map(np.real, np.linalg.eig(covariance))
            variances[::-1] => variances
            directions[:, 1] => directions[:, 0]
            You rely on the order of np.linalg.eig, which does not sort. Use np.linalg.eigh, which sorts in ascending order, and take its last eigenvalue and eigenvector for the long axis.
        not sorted, reversed: np.linalg.eigh(covariance) => map(np.real, np.linalg.eig(covariance))
            You rely on the order of np.linalg.eig, which does not sort. Use np.linalg.eigh, which sorts in ascending order, and take its last eigenvalue and eigenvector for the long axis. Reversing what is not sorted does not sort it.
        the eigenvector for the angle: np.arctan2(y, x) => directions[:, 1]
            You return the eigenvector. The angle is np.arctan2 of its y and x.
        probability in percent: np.log(1 - probability) => np.log(1 - probability / 100)
            You divide by 100, but probability is a fraction already, 0.95 and not 95.
        diameters: return sigmas => return 2 * sigmas
            Your axes are twice too long. A semi-axis reaches from the centre to the edge.
        two standard deviations: np.sqrt(-2 * np.log(1 - probability)) => 2.0
            Your semi-axes are two standard deviations for every probability. In the plane that ellipse contains 86 %. Compute the factor from the probability, with equation 6.6.
        the factor of 95 %: np.sqrt(-2 * np.log(1 - probability)) => np.sqrt(-2 * np.log(1 - 0.95))
            Your ellipse always contains 95 %. The factor must depend on the argument probability: use equation 6.6.
        the rounded factor of 95 %: np.sqrt(-2 * np.log(1 - probability)) => 2.448
            You multiply by 2.448, which is rounded, and right only for 95 %. The factor must depend on the argument probability: use equation 6.6.
        diagonal for eigenvalues: variances[::-1] => np.diag(covariance)
            Your semi-axes are computed from the diagonal of the covariance, which has the variances along x and y. The axes of the ellipse point along the eigenvectors, so use the eigenvalues.
        sorted diagonal for eigenvalues: variances[::-1] => np.sort(np.diag(covariance))[::-1]
            Your semi-axes are computed from the sorted diagonal of the covariance, which has the variances along x and y. The axes of the ellipse point along the eigenvectors, so use the eigenvalues.
        x and y exchanged: np.arctan2(y, x) => np.arctan2(x, y)
            Your angle is measured from the y axis. The first argument of np.arctan2 is y.
        degrees: np.arctan2(y, x) => np.degrees(np.arctan2(y, x))
            Your angle is in degrees. Return radians.
    """),
    alternatives={"closed form": _closed_form, "svd and chi2": _by_svd, "eig, sorted": _by_eig},
    equivalents={
        "x, y = directions[1, :]": "the eigenvectors of a 2 x 2 matrix have the same rows as columns, up to a sign, which turns an axis by half a turn"
    },
)


# --- 6.5 kalman_update ---
def _subtracted(mean: Array, covariance: Array, innovation: Array, H: Array, R: Array) -> Any:
    cross = covariance @ H.T
    S = H @ cross + R
    return mean + cross @ np.linalg.solve(S, innovation), covariance - cross @ np.linalg.solve(S, cross.T)


def _information(mean: Array, covariance: Array, innovation: Array, H: Array, R: Array) -> Any:
    weight = H.T @ np.linalg.inv(R)
    new = np.linalg.inv(np.linalg.inv(covariance) + weight @ H)
    return [mean + new @ weight @ innovation, new]


def _one_by_one(mean: Array, covariance: Array, innovation: Array, H: Array, R: Array) -> Any:
    """Update with one number after the other, in the axes in which their noise is independent; return lists."""
    variances, axes = np.linalg.eigh(R)
    new = mean
    for h, difference, variance in zip(axes.T @ H, axes.T @ innovation, variances, strict=True):
        gain = covariance @ h / (h @ covariance @ h + variance)
        new = new + gain * (difference - h @ (new - mean))
        covariance = covariance - np.outer(gain, h @ covariance)
    return new.tolist(), covariance.tolist()


def _update_public() -> list[Case]:
    rng = np.random.default_rng(66)
    one = np.array([2.0]), np.array([[0.04]]), np.array([1.0]), np.array([[1.0]]), np.array([[0.01]])
    position = np.array([2.0, 1.0]), np.array([[0.3, 0.1], [0.1, 0.2]])
    of_x = np.array([0.5]), np.array([[1.0, 0.0]]), np.array([[0.1]])
    two = (
        rng.normal(size=2),
        random_covariance(rng, 2),
        rng.normal(size=2),
        np.array([[0.0, 2.0], [1.0, 0.5]]),
    )
    return [
        Case(one, "one dimension, as in exercise 6.1"),
        Case((*position, *of_x), "a position, x is measured"),
        Case((*two, random_covariance(rng, 2, scale=0.5)), "two values, two measurements"),
        _anything(rng, 3, 2, 0.7, "a pose, bearing and range"),
        _turning_on(np.random.default_rng(67), "a third value that passes pi"),
        _far_off(np.random.default_rng(68), "innovations of 5 and -4.5"),
    ]


def _anything(rng: np.random.Generator, n: int, m: int, scale: float | None = None, name: str = "") -> Case:
    """Return a case of n values, updated with m measurements."""
    given = rng.normal(size=n), random_covariance(rng, n), rng.normal(size=m), rng.normal(size=(m, n))
    return Case((*given, random_covariance(rng, m, scale=scale or float(rng.uniform(0.4, 1.2)))), name)


def _turning_on(rng: np.random.Generator, name: str = "") -> Case:
    """Return a case whose third value is nearly half a turn and increases by the update."""
    H = np.array([[0.0, 0.0, 1.0], [1.0, rng.uniform(-0.5, 0.5), 0.0]])
    mean = np.array([*rng.normal(size=2), rng.uniform(3.0, 3.1)])
    return Case(
        (mean, random_covariance(rng, 3), np.array([rng.uniform(1.0, 1.5), 0.1]), H, np.eye(2) * 0.2), name
    )


def _far_off(rng: np.random.Generator, name: str = "") -> Case:
    """Return a case with innovations outside the range of a wrapped angle."""
    given = rng.normal(size=3), random_covariance(rng, 3), np.array([5.0, -4.5]), rng.normal(size=(2, 3))
    return Case((*given, np.eye(2) * 0.3), name)


def _update_hidden(rng: np.random.Generator) -> list[Case]:
    sizes = ((1, 1), (2, 1), (2, 2), (3, 2), (3, 2), (3, 4), (5, 2))
    return [_turning_on(rng), _far_off(rng), *(_anything(rng, n, m) for n, m in sizes)]


KALMAN_UPDATE = Exercise(
    name="kalman_update",
    points=4,
    stars=2,
    public=_update_public,
    hidden=_update_hidden,
    comparison=Close(atol=1e-8, names=("your mean", "your covariance")),
    hints=(
        "Compute S, then K, then the mean and the covariance of equation 6.7, one line each. In one dimension K is P / S. For matrices, choose the order and the transpose so that K is (n, m): P is (n, n), H is (m, n) and S is (m, m).",
        "K = P Hᵀ S^-1 with S = H P Hᵀ + R. The new mean is mean + K @ innovation; the new covariance is equation 6.7, or (I - K H) P, which is the same for this gain.",
    ),
    sibling=Sibling(
        "Three sensors correct two unknowns, so the gain has a row for each unknown and a column for each sensor, and the covariance of the sensors is inverted, on the right.",
        """
        import numpy as np

        C_ys = np.array([[0.8, 0.2, 0.0], [0.1, 0.5, 0.3]])  # two unknowns with three sensors
        C_ss = np.array([[1.0, 0.2, 0.0], [0.2, 1.0, 0.1], [0.0, 0.1, 2.0]])
        C_yy = np.array([[1.0, 0.1], [0.1, 0.9]])
        gain = np.linalg.solve(C_ss, C_ys.T).T  # C_ys times the inverse of C_ss: (2, 3)
        readings = np.array([0.5, -0.2, 1.0])  # minus their means
        print((gain @ readings).round(3))
        print((C_yy - gain @ C_ys.T).round(3))
        """,
        """
        [0.385 0.03 ]
        [[0.358 0.001]
         [0.001 0.619]]
        """,
    ),
    mistakes=catalogue("""
        S without R: H.T + R => H.T
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            R is missing in your S, so you treat the measurement as exact. The innovation has both sources of uncertainty: S = H P Hᵀ + R.
        S without P: H @ covariance @ H.T + R => H @ H.T + R
            np.linalg.solve(S, H @ covariance).T => covariance @ H.T @ np.linalg.inv(S)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            P is missing in your S. The innovation has both sources of uncertainty: S = H P Hᵀ + R.
        R squared: H.T + R => H.T + R @ R
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            Your S contains R @ R. R already is a covariance, with squared units, so add it as it is.
        innovation subtracted again: K @ innovation => K @ (innovation - H @ mean)
            You subtract H @ mean from the innovation. The innovation already is measured minus expected, so use K @ innovation.
        one by one with the old innovation: + for h, difference, variance in zip(H, innovation, np.diag(R), strict=True):
            +     gain = covariance @ h / (h @ covariance @ h + variance)
            +     mean = mean + gain * difference
            +     covariance = covariance - np.outer(gain, h @ covariance)
            + return mean, covariance
            You update with one measured value after the other, but all innovations belong to the old mean. After the first value the mean has moved, so the others are wrong. R may also have entries off its diagonal. Update with all values at once: S, K and one product K @ innovation.
        variances only, of R: H.T + R => H.T + np.diag(np.diag(R))
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            You use only the diagonal of R. The noise of two measured values may be correlated, so use the whole matrix, and update with all values at once.
        gain over R: np.linalg.solve(S, H @ covariance).T => covariance @ H.T @ np.linalg.inv(R)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            Your gain uses the inverse of R alone. The innovation has both sources of uncertainty: use the inverse of S = H P Hᵀ + R.
        no inverse: np.linalg.solve(S, H @ covariance).T => covariance @ H.T @ S
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            Your gain multiplies by S. A more uncertain innovation must get a smaller weight, so multiply by the inverse of S.
        divided entry by entry: np.linalg.solve(S, H @ covariance).T => covariance @ H.T / S
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            You divide by S entry by entry. For matrices, multiply by the inverse: np.linalg.inv(S), or np.linalg.solve.
        P left out of the gain: np.linalg.solve(S, H @ covariance).T => H.T @ np.linalg.inv(S)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            P is missing in your gain. A more uncertain estimate must move farther: in one dimension the gain is P / S.
        inverse on the left: np.linalg.solve(S, H @ covariance).T => np.linalg.inv(S) @ covariance @ H.T
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            The inverse of S is on the wrong side of your gain. K has n rows and m columns, so the factor of shape (n, n) comes first and the inverse of S, which is (m, m), comes last.
        H not transposed in the gain: np.linalg.solve(S, H @ covariance).T => covariance @ H @ np.linalg.inv(S)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            H is not transposed in your gain. P is (n, n) and H is (m, n), so P can be multiplied only by the transpose of H, which is (n, m).
        R outside of the inverse: np.linalg.solve(S, H @ covariance).T => covariance @ H.T @ np.linalg.inv(H @ covariance @ H.T) + R
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            You add R after the inverse. R belongs to S, so compute S first: S = H P Hᵀ + R, and then its inverse.
        entries of S inverted: np.linalg.solve(S, H @ covariance).T => covariance @ H.T @ (1 / S)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            You invert each entry of S, which is also what S**-1 does. For the inverse of a matrix use np.linalg.inv(S).
        first H transposed: H @ covariance @ H.T + R => H.T @ covariance @ H + R
            np.linalg.solve(S, H @ covariance).T => covariance @ H.T @ np.linalg.inv(S)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            Your S has the wrong H transposed. S is (m, m), so it is H P Hᵀ + R, because H is (m, n).
        H left out: np.linalg.solve(S, H @ covariance).T => covariance / (covariance + R)
            left @ covariance @ left.T + K @ R @ K.T => (np.eye(len(mean)) - K) @ covariance
            You use the formulas of one dimension, where H is 1. With matrices, S = H P Hᵀ + R, and H or its transpose is also a factor of the gain and of the covariance.
        H left out, entry by entry: + gain = covariance / (covariance + R)
            + return mean + gain * innovation, (1 - gain) * covariance
            You use the formula for one number. With H it becomes a matrix product: see the shapes above.
        H left out of the gain: np.linalg.solve(S, H @ covariance).T => covariance / (covariance + R)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            Your gain is the formula for one number. With H it becomes a matrix product: see the shapes above.
        gain transposed: covariance).T => covariance)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            Your gain is transposed: S^-1 H P is Kᵀ. K has a row for each value of the state and a column for each measurement.
        H P H: H @ covariance @ H.T + R => H @ covariance @ H + R
            np.linalg.solve(S, H @ covariance).T => covariance @ H.T @ np.linalg.inv(S)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            Your S has H P H. The second H must be transposed: S = H P Hᵀ + R. If n equals m, Python raises no error.
        innovation's sign: mean + K => mean - K
            Your mean moves in the wrong direction. Add K @ innovation, because the innovation is measured minus expected.
        * for @: K @ innovation => K * innovation
            K * innovation multiplies entry by entry. Use the matrix product K @ innovation.
        covariance not updated: left @ covariance @ left.T + K @ R @ K.T => covariance
            Your mean is right, but you return the old covariance. A measurement reduces it: see equation 6.7.
        mean not updated: mean + K @ innovation => mean
            Your covariance is right, but you return the old mean. Add K @ innovation.
        heading wrapped here: return mean + K @ innovation => return moved
            - K @ H => - K @ H
            + moved = mean + K @ innovation
            + moved[2:3] = (moved[2:3] + np.pi) % (2 * np.pi) - np.pi
            You wrap the third value of the mean. This function works for any state, and in lesson 07 the third value is not always an angle. Wrap the heading in localize instead.
        third value wrapped: return mean + K @ innovation => return moved
            - K @ H => - K @ H
            + moved = mean + K @ innovation
            + moved[2] = (moved[2] + np.pi) % (2 * np.pi) - np.pi
            You wrap the third value of the mean. Angles are not wrapped here, and the state may have one value only. Wrap the heading in localize instead.
        bearing wrapped here: + innovation = np.append((innovation[0] + np.pi) % (2 * np.pi) - np.pi, innovation[1:])
            You wrap the first value of the innovation. This function works for any measurement, and the first value is not always an angle. The function innovation has wrapped it already.
        1 for I: np.eye(len(mean)) => 1
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            1 - K @ H subtracts each entry of K H from 1. The matrix I has ones on its diagonal only: use np.eye(len(mean)).
        I of a pose: np.eye(len(mean)) => np.eye(3)
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            You use np.eye(3), which fits only a state of three values. The state may have any number n of values: use np.eye(len(mean)).
        H K for K H: - K @ H => - H @ K
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            You compute I - H K. It is I - K H: K H is (n, n) like P, while H K is (m, m), so the two fit together only if n equals m.
        H K for K H in the Joseph form: - K @ H => - H @ K
            You compute I - H K, but it is I - K H: K H is (n, n) like P, while H K is (m, m). If you use the Joseph form, exchange H and K in both of its factors.
        I of the measurement's size: np.eye(len(mean)) - K @ H => np.eye(len(innovation)) - K @ H
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            Your I has as many rows as there are measurements. K H is (n, n), so I needs a row for each value of the state: np.eye(len(mean)).
        the Joseph form without a transpose: left.T => left
            The second I - K H of equation 6.7 must be transposed: (I - K H) P (I - K H)ᵀ. Your matrix is not symmetric.
        P left out in the difference: left @ covariance @ left.T + K @ R @ K.T => covariance - K @ H
            P is missing behind K H: (I - K H) P is P - K H P.
        S in the Joseph form: K @ R @ K.T => K @ S @ K.T
            The last term of equation 6.7 is K R Kᵀ. S contains R, but also P, which is in the first term already.
        R left out of the difference: left @ covariance @ left.T + K @ R @ K.T => covariance - K @ (S - R) @ K.T
            Your S in the covariance lacks R. P - K S Kᵀ needs the same S as the gain, H P Hᵀ + R.
        P multiplied entry by entry: left @ covariance @ left.T + K @ R @ K.T => left * covariance
            You multiply I - K H and P entry by entry with *. Use the matrix product: (I - K H) @ P.
        second K of the Joseph form not transposed: K @ R @ K.T => K @ R @ K
            The second K of K R Kᵀ must be transposed: K is (n, m) and R is (m, m).
        P forgotten behind: left @ covariance @ left.T + K @ R @ K.T => left
            You return I - K H without P. It is the factor by which P becomes smaller: multiply it by P.
        plus for minus: len(mean)) - K => len(mean)) + K
            left @ covariance @ left.T + K @ R @ K.T => left @ covariance
            Your covariance grows with the measurement, because you have I + K H. Use I - K H.
        wrong side: left @ covariance @ left.T + K @ R @ K.T => covariance @ left
            You compute P (I - K H), and the result is not symmetric. Multiply from the other side: (I - K H) P.
        half of the Joseph form: left.T + K @ R @ K.T => left.T
            Your covariance is (I - K H) P (I - K H)ᵀ alone, which leaves out the measurement noise. Add K R Kᵀ.
        the Joseph form transposed: left @ covariance @ left.T => left.T @ covariance @ left
            In your Joseph form the first I - K H is transposed. It is the second one: (I - K H) P (I - K H)ᵀ.
        minus in the Joseph form: left.T + K @ R => left.T - K @ R
            You subtract K R Kᵀ. The measurement noise makes the covariance larger, so add it.
    """),
    alternatives={"subtraction": _subtracted, "information form": _information, "one by one": _one_by_one},
    equivalents={"left = K @ H - np.eye(len(mean))": "it occurs twice, so its sign does not matter"},
)


# --- 6.6 localize ---
def _localized_by(update: Callable[..., Any]) -> Callable[..., Any]:
    """Return a `localize` that uses this Kalman update."""

    def localize(pose: Array, covariance: Array, measurement: Array, landmark: Array, R: Array) -> Any:
        difference = measurement - range_and_bearing(pose, landmark)
        difference[0] = np.angle(np.exp(1j * difference[0]))
        new, new_covariance = update(pose, covariance, difference, jacobian_at(pose, landmark)[:, :3], R)
        return [*new[:2], wrap_angle(new[2])], new_covariance

    return localize


def _measured(
    pose: Any, landmark: Any, error: Any, sigmas: tuple[float, float], covariance: Array, name: str = ""
) -> Case:
    """Return a case with a landmark measured from a pose with this error."""
    at, there = (np.array(each, dtype=float) for each in (pose, landmark))
    bearing, distance = range_and_bearing(at, there) + error
    measured = np.array([float(wrap_angle(bearing)), distance])
    return Case((at, covariance, measured, there, np.diag(sigmas) ** 2), name)


def _localize_public() -> list[Case]:
    wide = np.diag([0.09, 0.09, 0.03])
    tight = np.array([[0.02, 0.005, 0.001], [0.005, 0.03, -0.002], [0.001, -0.002, 0.004]])
    near, behind = "a near corner, correlated covariance", "a corner behind, at 179 degrees"
    high, goal = "a heading that passes 180 degrees", "a robot behind the goal line, x = 3.4"
    return [
        _measured((0.0, 0.0, 0.0), (2.0, 0.0), (0.1, -0.2), (0.05, 0.1), wide, "a landmark straight ahead"),
        _measured((1.2, 0.3, 0.15), (3.0, 0.7), (-0.05, 0.15), (0.03, 0.09), wide, "a goal post"),
        _measured((1.5, 1.0, -0.63), (0.0, 2.0), (-0.5, 0.1), (0.03, 0.09), wide, behind),
        _measured((2.0, -1.0, 2.4), (2.4, -1.1), (0.08, 0.05), (0.04, 0.05), tight, near),
        _measured(
            (0.5, 0.0, -1.0), (3.0, 2.0), (0.0, 0.0), (0.03, 0.1), tight, "a measurement exactly as expected"
        ),
        _measured((2.2, 0.4, 3.1), (0.0, 2.0), (-0.2, 0.1), (0.03, 0.1), wide, high),
        _measured(
            (2.2, -0.4, -3.1),
            (0.0, -2.0),
            (0.2, 0.1),
            (0.03, 0.1),
            wide,
            "a heading that passes -180 degrees",
        ),
        _measured((3.4, 0.2, 3.0), (2.4, 1.1), (0.05, 0.1), (0.03, 0.05), tight, goal),
        _measured(
            (2.4, 0.3, 0.2),
            (3.0, 0.7),
            (0.1, 4.0),
            (0.03, 0.1),
            wide,
            "a post 4 m farther away than expected",
        ),
    ]


def _localize_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for _ in range(7):
        pose = (rng.uniform(0, 2), rng.uniform(-1.5, 1.5), rng.uniform(-3, 3))
        away, direction = rng.uniform(0.6, 3.0), rng.uniform(-np.pi, np.pi)
        landmark = (pose[0] + away * np.cos(direction), pose[1] + away * np.sin(direction))
        error = rng.normal(0, 1, 2) * (0.1, 0.2)
        sigmas = (float(rng.uniform(0.02, 0.1)), float(rng.uniform(0.05, 0.2)))
        cases.append(_measured(pose, landmark, error, sigmas, random_covariance(rng, 3, scale=0.25)))
    for turn in (0.2, -0.2):  # just behind the robot
        y = float(rng.uniform(-0.5, 0.5))
        landmark, wide = (-1.0, y + 0.1 * turn), random_covariance(rng, 3, scale=0.3)
        cases.append(_measured((1.0, y, 0.0), landmark, (turn, 0.1), (0.05, 0.1), wide))
    far = (0.1, float(rng.uniform(3.6, 4.5)))  # a robot that has been carried away
    cases.append(
        _measured(
            (2.4, rng.uniform(-0.5, 0.5), 0.2), (3.0, 0.7), far, (0.03, 0.1), np.diag([0.09, 0.09, 0.03])
        )
    )
    uncertain = np.diag([0.04, 0.04, 0.2])
    for side in (1.0, -1.0):  # the heading passes half a turn, on the field and beside it
        for x in (rng.uniform(0.5, 2.0), rng.uniform(3.5, 4.0)):
            pose = (x, rng.uniform(-1.0, 1.0), side * rng.uniform(3.06, 3.12))
            away = (x - 2.0, rng.uniform(-1.0, 1.0))
            cases.append(_measured(pose, away, (-0.3 * side, 0.1), (0.03, 0.1), uncertain))
    return cases


LOCALIZE = Exercise(
    name="localize",
    points=6,
    stars=3,
    uses=("innovation", "kalman_update", "05:expected_measurement", "05:measurement_jacobian_pose"),
    public=_localize_public,
    hidden=_localize_hidden,
    comparison=Close(atol=1e-7, names=("your pose", "your covariance")),
    hints=(
        "Which measurement do you expect at the estimated pose, and how does it change with the pose? Lesson 05 has a function for each; innovation and kalman_update do the rest.",
        "The difference needs your innovation, with the expected measurement first. H is the Jacobian with respect to the pose, at the estimated pose. After the update, wrap only the heading.",
    ),
    sibling=Sibling(
        "An angle is wrapped twice: first the difference, so that the correction goes the short way, and then the corrected angle.",
        """
        def wrapped(degrees):
            return (degrees + 180) % 360 - 180


        wind, gain = 175.0, 0.5
        difference = wrapped(-165.0 - wind)  # 20 and not -340
        print(wrapped(wind + gain * difference))
        """,
        "-175.0",
    ),
    mistakes=catalogue("""
        innovation unwrapped: innovation(expected_measurement(pose, landmark), measurement) => measurement - expected_measurement(pose, landmark)
            Your estimate jumps if the landmark is behind the robot: 179 degrees are expected and -152 measured, and you use -331 degrees. Compute the difference with your function innovation, which wraps it.
        innovation's sign: difference, jacobian => -difference, jacobian
            Your correction has the wrong direction. The innovation is measured minus expected: the expected measurement is the first argument of innovation, and H is the Jacobian of the expected measurement.
        Jacobian by the landmark: jacobian, R => jacobian * [-1, -1, 0], R
            Your H is the Jacobian with respect to the landmark's position. The landmark is known; you estimate the pose, so use measurement_jacobian_pose, which is (2, 3).
        landmark for expected measurement: innovation(expected_measurement(pose, landmark), measurement) => innovation(landmark, measurement)
            You compare the measurement with the landmark's position. The expected measurement is the bearing and range at which the estimated pose should see that landmark: expected_measurement(pose, landmark).
        measurement for innovation: innovation(expected_measurement(pose, landmark), measurement) => measurement
            You use the measurement itself as the innovation. Subtract the expected measurement from it, with your function innovation.
        range wrapped: innovation(expected_measurement(pose, landmark), measurement) => (measurement - expected_measurement(pose, landmark) + np.pi) % (2 * np.pi) - np.pi
            You wrap the innovation of the range, too. It is in metres, so a difference of 4 m must stay 4 m. Wrap the bearing only, as your function innovation does.
        heading not wrapped: np.arctan2(np.sin(theta), np.cos(theta)) => theta
            Your result is right until the new heading passes pi or -pi. Wrap the heading after the update, in radians.
        heading 0 to a full turn: np.arctan2(np.sin(theta), np.cos(theta)) => theta % (2 * np.pi)
            Your heading is between 0 and 2 pi. Return it between -pi and pi: (angle + np.pi) % (2 * np.pi) - np.pi.
        heading wrapped from above only: np.arctan2(np.sin(theta), np.cos(theta)) => theta - 2 * np.pi * (theta > np.pi)
            You subtract a full turn if the heading is above pi, which is right. If it is below -pi, add a full turn.
        heading wrapped from below only: np.arctan2(np.sin(theta), np.cos(theta)) => theta + 2 * np.pi * (theta < -np.pi)
            You add a full turn if the heading is below -pi, which is right. If it is above pi, subtract a full turn.
        pose wrapped: np.array([x, y, np.arctan2(np.sin(theta), np.cos(theta))]) => (np.array([x, y, theta]) + np.pi) % (2 * np.pi) - np.pi
            You wrap the whole pose. x and y are in metres, so at x = 3.4 your robot jumps to the other side of the field. Wrap the heading only.
        heading left out: jacobian, R => jacobian * [1, 1, 0], R
            Your heading is never corrected, because the third column of your H is 0. It is (-1, 0): if the robot turns to the left, the bearing of the landmark becomes smaller.
        rows exchanged: jacobian, R => jacobian[::-1], R
            The rows of your H are exchanged. The bearing comes first, then the range, as in the measurement.
        used twice: jacobian, R) => jacobian, R)
            + difference = innovation(expected_measurement((x, y, theta), landmark), measurement)
            + jacobian = measurement_jacobian_pose((x, y, theta), landmark)
            + (x, y, theta), covariance = kalman_update(np.array([x, y, theta]), covariance, difference, jacobian, R)
            You update twice with the same measurement. The second time it contains no new information, so your covariance becomes too small. Update once.
        iterated: (x, y, theta), covariance => (x, y, theta), _
            + again = np.array([x, y, theta])
            + jacobian = measurement_jacobian_pose(again, landmark)
            + difference = innovation(expected_measurement(again, landmark), measurement) - jacobian @ (pose - again)
            + (x, y, theta), covariance = kalman_update(pose, covariance, difference, jacobian, R)
            You linearise again at the corrected pose. That is a better filter, and useful in the challenge; here linearise once, at the estimated pose.
        bearing alone: difference, jacobian, R => difference[:1], jacobian[:1], R[:1, :1]
            You update with the bearing only. The range contains information about the distance, so use both rows.
        R squared: jacobian, R => jacobian, R**2
            You square R. It has variances already, so use it as it is.
        expected at the measurement: expected_measurement(pose, landmark) => expected_measurement(pose, measurement)
            You call expected_measurement with the measurement. Its second argument is the landmark's position: expected_measurement(pose, landmark).
        Jacobian at the measurement: measurement_jacobian_pose(pose, landmark) => measurement_jacobian_pose(pose, measurement)
            You call measurement_jacobian_pose with the measurement. Its second argument is the landmark's position.
        R as standard deviations: jacobian, R => jacobian, np.sqrt(R)
            You take the square root of R. R has variances already, and S adds variances, so use R as it is.
        covariance kept: (x, y, theta), covariance => (x, y, theta), _
            Your pose is right, but you return the old covariance. Return the one from kalman_update.
        degrees: expected_measurement(pose, landmark) => expected_measurement(pose, landmark) * [180 / np.pi, 1]
            Your expected bearing is in degrees, but the measured one is in radians. Use radians for both.
        innovation in degrees: difference, jacobian, R => difference * [180 / np.pi, 1], jacobian, R
            Your innovation of the bearing is in degrees. H and R are in radians, so the innovation must be in radians, too.
        heading in degrees: np.arctan2(np.sin(theta), np.cos(theta)) => np.degrees(np.arctan2(np.sin(theta), np.cos(theta)))
            Your heading is in degrees. Return it in radians.
        measurement exchanged: landmark), measurement) => landmark), measurement[::-1])
            You use the measurement as (range, bearing). It is (bearing, range).
    """),
    alternatives={
        "bearing, then range": _localized_by(_one_by_one),
        "information form": _localized_by(_information),
        "subtraction": _localized_by(_subtracted),
    },
    equivalents={
        "return ([x, y, np.arctan2(np.sin(theta), np.cos(theta))], covariance)": "a list of the same numbers"
    },
)


PLAN = LessonPlan(
    exercises=[FUSE, INNOVATION, NEES, COVARIANCE_ELLIPSE, KALMAN_UPDATE, LOCALIZE],
    questions=[
        Question(
            "how_much_weight",
            "The measurement has three times the standard deviation of the prediction. Which weight does the measurement get?",
            {
                "0, because the prediction is better": "Even an imprecise measurement contains information: with a weight above 0 the result is more precise than the prediction alone.",
                "1/4": "1 / (1 + 3) is the weight computed from standard deviations. Use the variances.",
                "1/10": "Its variance is nine times as large, so the weight is 1 / (1 + 9).",
                "1/3": "The weights sum to one, so the prediction would get 2/3, only twice as much. By which factor do the variances differ?",
            },
            "1/10",
        ),
        Question(
            "near_or_far",
            "A robot knows its position to 5 cm, but its heading only to 20 degrees. Which landmark should it measure to improve its heading?",
            {
                "The nearest, because it is measured most precisely": "Its range is, but the position is already known. A position error of 5 cm changes the bearing of a landmark at half a metre by 6 degrees, so the heading keeps that much uncertainty.",
                "The farthest that it can see": "A position error of 5 cm changes the bearing of a landmark at 4 m by 0.7 degrees, which is less than the bearing's own noise. The heading is then known to 1.7 degrees.",
                "It makes no difference, because the bearing noise is the same": "The noise is the same. But the expected bearing also depends on the uncertain position, and for a near landmark more than for a far one.",
            },
            "The farthest that it can see",
        ),
        Question(
            "without_truth",
            "On a real field the true pose is unknown, so there is no NEES. Which of these faults would you not find there?",
            {
                "Q is missing": "Its NIS grows from 3 to 28 times the expected value, so the robot can detect this fault by itself.",
                "R is missing in S": "Its NIS is nearly twice the expected value from the first steps on. That is small beside a NEES of a million, but the many measurements of one drive are enough to notice it.",
                "each measurement is used twice": "Its normalised innovations look right, and its NIS is within a tenth of the expected value. Only the truth shows that the ellipse is too small. The same happens if two measurements share an error, like the landmarks in one picture of a tilted robot.",
                "ranges 15 % too long": "Its innovations of the range have a median of 1.6 standard deviations, all on one side, so the robot can detect this fault by itself.",
            },
            "each measurement is used twice",
        ),
    ],
    written=[
        Written(
            "explain_band",
            points=2,
            question="Why does the 95 % band hold for one step over many drives, but not for one drive over its steps? Give the three numbers of your own drives.",
            rubric="1 point: the band holds for the mean of independent values, and different drives are independent. 1 point: the errors of neighbouring steps of one drive are correlated, because the error of a pose carries over from step to step; so a drive has far fewer independent values than steps, and its mean varies more. Subtract half a point if the three numbers of the personal world are missing.",
            numbers=personal_numbers,
        )
    ],
)
