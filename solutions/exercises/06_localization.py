"""Lesson 06, localization: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises import Case, Close, Each, Exercise, LessonPlan, Mistake, Question, Written
from nao_course.geometry import Pose, rotation_2d

Array = npt.NDArray[Any]
TURN = 2 * np.pi


def spread(rng: np.random.Generator, size: int, *, scale: float = 1.0) -> Array:
    """A covariance (size, size) whose values are correlated, with standard deviations around `scale`."""
    root = rng.normal(0.0, 0.5, (size, size)) + np.eye(size) * rng.uniform(0.6, 1.2, size)
    return scale**2 * (root @ root.T)


def wrapped(angle: Any) -> Any:
    """An angle in [-pi, pi)."""
    return (angle + np.pi) % TURN - np.pi


# --- 6.1 fuse ---


def _fused(weight_of: Callable[[float, float], float], variance_of: Callable[[float, float], float]) -> Any:
    def function(mean_a: float, variance_a: float, mean_b: float, variance_b: float) -> tuple[float, float]:
        weight = weight_of(variance_a, variance_b)
        return mean_a + weight * (mean_b - mean_a), variance_of(variance_a, variance_b)

    return function


def _carried_on(weight_of: Callable[[float, float], float]) -> Any:
    """A wrong weight, with which the second line is right: (1 - w) variance_a."""
    return _fused(weight_of, lambda a, b: (1 - weight_of(a, b)) * a)


def _right_weight(a: float, b: float) -> float:
    return a / (a + b)


def _right_variance(a: float, b: float) -> float:
    return a * b / (a + b)


def _by_information(
    mean_a: float, variance_a: float, mean_b: float, variance_b: float
) -> tuple[float, float]:
    information = 1 / variance_a + 1 / variance_b
    return (mean_a / variance_a + mean_b / variance_b) / information, 1 / information


def _by_average(mean_a: float, variance_a: float, mean_b: float, variance_b: float) -> Any:
    weights = np.array([variance_b, variance_a], dtype=np.float32)
    mean = np.average([mean_a, mean_b], weights=weights)
    return np.array([mean, np.prod(weights) / weights.sum()])


def _by_gain(mean_a: float, variance_a: float, mean_b: float, variance_b: float) -> list[float]:
    gain = variance_a / (variance_a + variance_b)
    return [mean_a - gain * (mean_a - mean_b), gain * variance_b]


def _fuse_public() -> list[Case]:
    return [
        Case((2.0, 0.04, 3.0, 0.01), "a prediction of 2 m and a measurement of 3 m, twice as sure"),
        Case((1.0, 0.25, 1.0, 0.25), "two beliefs that agree"),
        Case((-1.0, 0.01, 2.0, 0.09), "a prediction that is three times as sure"),
        Case((4.0, 4.0, 1.0, 9.0), "variances above one"),
    ]


def _fuse_hidden(rng: np.random.Generator) -> list[Case]:
    draws = zip(rng.uniform(-5, 5, (8, 2)), rng.uniform(0.02, 3, (8, 2)), strict=True)
    return [Case((float(a), float(va), float(b), float(vb))) for (a, b), (va, vb) in draws]


FUSE = Exercise(
    name="fuse",
    points=2,
    stars=1,
    public=_fuse_public,
    hidden=_fuse_hidden,
    comparison=Close(atol=1e-9, names=("your mean", "your variance")),
    hints=(
        "The weight of the second belief is large where the first one is poor: its own variance stands in the numerator.",
        "weight = variance_a / (variance_a + variance_b); the mean goes that part of the way from a to b, and of variance_a the part 1 - weight is left.",
    ),
    mistakes=[
        Mistake(
            "weights exchanged",
            _fused(lambda a, b: b / (a + b), _right_variance),
            "Your mean lies nearer to the poorer of both. The weight of b is variance_a over the sum: the poorer a is, the more b counts.",
        ),
        Mistake(
            "weights exchanged in both lines",
            _carried_on(lambda a, b: b / (a + b)),
            "Your mean lies nearer to the poorer of both. The weight of b is variance_a over the sum: the poorer a is, the more b counts. Both lines need it.",
        ),
        Mistake(
            "standard deviations",
            _fused(lambda a, b: a**0.5 / (a**0.5 + b**0.5), _right_variance),
            "You weigh by standard deviations. It is the variances that stand in the weight: twice the standard deviation is a quarter of the weight.",
        ),
        Mistake(
            "standard deviations in both lines",
            _carried_on(lambda a, b: a**0.5 / (a**0.5 + b**0.5)),
            "You weigh by standard deviations. It is the variances that stand in the weight: twice the standard deviation is a quarter of the weight. Both lines need it.",
        ),
        Mistake(
            "variances squared",
            _carried_on(lambda a, b: a**2 / (a**2 + b**2)),
            "You square the variances. What comes in is sigma squared already: equation 6.2 has no more squares to take.",
        ),
        Mistake(
            "taken for standard deviations",
            _fused(lambda a, b: a**2 / (a**2 + b**2), lambda a, b: a**2 * b**2 / (a**2 + b**2)),
            "You square the variances. What comes in is sigma squared already: equation 6.2 has no more squares to take. Both lines need it.",
        ),
        Mistake(
            "the other part of the variance",
            _fused(_right_weight, lambda a, b: a / (a + b) * a),
            "Your variance is w times variance_a. What is left of it is the other part, (1 - w) variance_a: the more b counts, the less is left of a's doubt.",
        ),
        Mistake(
            "the smaller variance",
            _fused(_right_weight, min),
            "Your variance is that of the surer one. The other one helps, too: both together are surer than either.",
        ),
        Mistake(
            "plain average",
            _fused(lambda a, b: 0.5, _right_variance),
            "Your mean lies in the middle, whoever is surer. Weigh both by their variances.",
        ),
        Mistake(
            "plain average in both lines",
            _fused(lambda a, b: 0.5, lambda a, b: (a + b) / 4),
            "Your mean lies in the middle, whoever is surer. Weigh both by their variances. Both lines need it.",
        ),
        Mistake(
            "away from b",
            _fused(lambda a, b: -a / (a + b), _right_variance),
            "Your mean goes away from b: the difference in equation 6.1 is b - a.",
        ),
        Mistake(
            "variances added",
            _fused(_right_weight, lambda a, b: a + b),
            "Your variance is the sum, larger than either: that is the variance of a difference. Two beliefs together are surer than each alone.",
        ),
        Mistake(
            "averaged variance",
            _fused(_right_weight, lambda a, b: (a + b) / 2),
            "Your variance lies between the two. Two beliefs together are surer than each alone: it has to be below both.",
        ),
        Mistake(
            "weighted variance",
            _fused(_right_weight, lambda a, b: a + a / (a + b) * (b - a)),
            "You weigh the variances like the means. The derivation says (1 - w)^2 variance_a + w^2 variance_b: the weights are squared.",
        ),
        Mistake(
            "standard deviation returned",
            _fused(_right_weight, lambda a, b: (a * b / (a + b)) ** 0.5),
            "You return the standard deviation; the variance is wanted.",
        ),
    ],
    alternatives={
        "information adds up": _by_information,
        "np.average, an array": _by_average,
        "a gain, a list": _by_gain,
    },
)


# --- 6.2 innovation ---


def _innovation(expected: Any, measured: Any) -> Array:
    expected, measured = np.asarray(expected), np.asarray(measured)
    return np.array([wrapped(measured[0] - expected[0]), measured[1] - expected[1]])


def _arctan(expected: Any, measured: Any) -> Array:
    difference = np.subtract(measured, expected)
    return np.array([np.arctan2(np.sin(difference[0]), np.cos(difference[0])), difference[1]])


def _with_a_loop(expected: Any, measured: Any) -> list[float]:
    bearing = float(measured[0]) - float(expected[0])
    while bearing > np.pi:
        bearing -= TURN
    while bearing < -np.pi:
        bearing += TURN
    return [bearing, float(measured[1]) - float(expected[1])]


def _complex(expected: Any, measured: Any) -> Array:
    difference = np.asarray(measured, dtype=float) - np.asarray(expected, dtype=float)
    difference[0] = np.angle(np.exp(1j * difference[0]))
    return difference


def _both_wrapped(expected: Any, measured: Any) -> Array:
    return wrapped(np.subtract(measured, expected))


def _innovation_public() -> list[Case]:
    pairs = {
        "a bearing a little to the left": ((0.3, 2.0), (0.35, 1.9)),
        "a landmark behind: 170 degrees expected, -175 measured": ((2.967, 1.5), (-3.054, 1.6)),
        "a landmark behind, the other way round": ((-3.0, 2.5), (3.1, 2.0)),
        "the same": ((-1.2, 0.8), (-1.2, 0.8)),
        "a landmark 5 m farther than expected": ((0.0, 1.0), (-0.1, 6.0)),
        "126 degrees to the right of what is expected": ((1.0, 1.5), (-1.2, 1.5)),
        "115 degrees to the left of what is expected": ((-0.5, 1.5), (1.5, 1.2)),
    }
    return [Case((np.array(a), np.array(b)), name) for name, (a, b) in pairs.items()]


def _innovation_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for _ in range(8):
        bearing, error = rng.uniform(-np.pi, np.pi), rng.uniform(-2.5, 2.5)
        expected = np.array([bearing, rng.uniform(0.3, 3)])
        cases.append(Case((expected, np.array([wrapped(bearing + error), rng.uniform(3.5, 9)]))))
    for bearing in (3.0, -3.0):
        cases.append(Case((np.array([bearing, 1.0]), np.array([-bearing + rng.uniform(-0.05, 0.05), 5.0]))))
    return cases


INNOVATION = Exercise(
    name="innovation",
    points=2,
    stars=1,
    public=_innovation_public,
    hidden=_innovation_hidden,
    comparison=Close(atol=1e-9, names=("the bearing", "the range")),
    hints=(
        "Measured less expected, then bring the bearing alone into one turn around zero. The range is a length: leave it.",
        "(angle + np.pi) % (2 * np.pi) - np.pi brings an angle into [-pi, pi). Build the answer anew with np.array([bearing, range]).",
    ),
    mistakes=[
        Mistake(
            "sign",
            lambda expected, measured: -_innovation(expected, measured),
            "You have expected less measured. An innovation is what the measurement adds: measured less expected.",
        ),
        Mistake(
            "not wrapped",
            lambda expected, measured: np.subtract(measured, expected),
            "Right, except where the landmark is behind: from 170 to -175 degrees it is 15 degrees, not -345. Wrap the bearing's difference.",
        ),
        Mistake(
            "range wrapped",
            _both_wrapped,
            "You wrap both values. The range is in metres: 5 m stay 5 m.",
        ),
        Mistake(
            "degrees",
            lambda expected, measured: (
                (np.subtract(measured, expected) + (180.0, 0.0)) % (360.0, np.inf) - (180.0, 0.0)
            ),
            "You wrap at 180 as if the bearing were in degrees. It is in radians: the half turn is np.pi.",
        ),
        Mistake(
            "0 to a full turn",
            lambda expected, measured: np.array(
                [(measured[0] - expected[0]) % TURN, measured[1] - expected[1]]
            ),
            "Your bearings are 0 to 2 pi: a little to the right becomes nearly a full turn to the left. Around zero is wanted.",
        ),
        Mistake(
            "half a turn",
            lambda expected, measured: np.array(
                [
                    (measured[0] - expected[0] + np.pi / 2) % np.pi - np.pi / 2,
                    measured[1] - expected[1],
                ]
            ),
            "You take off half turns, as the arctangent of a tangent does: two directions that are opposite become the same. A whole turn is 2 pi.",
        ),
        Mistake(
            "arcsin",
            lambda expected, measured: np.array(
                [np.arcsin(np.sin(measured[0] - expected[0])), measured[1] - expected[1]]
            ),
            "The arcsine of a sine knows angles up to 90 degrees only: 126 degrees come back as 54. np.arctan2 of sine and cosine knows all.",
        ),
        Mistake(
            "one side only",
            lambda expected, measured: np.array(
                [
                    (measured[0] - expected[0]) - TURN * (measured[0] - expected[0] > np.pi),
                    measured[1] - expected[1],
                ]
            ),
            "You take a turn off where the difference is too large; where it is below -pi, one has to be added.",
        ),
        Mistake(
            "no sign left",
            lambda expected, measured: np.abs(_innovation(expected, measured)),
            "Your answer has lost its signs: too far to the left and too far to the right are different surprises.",
        ),
    ],
    alternatives={"arctan2": _arctan, "a loop, a list": _with_a_loop, "complex numbers": _complex},
    equivalents={
        "return np.array([(bearing - np.pi) % (2 * np.pi) - np.pi, distance])": "a full turn less, which the remainder takes out",
        "return [(bearing + np.pi) % (2 * np.pi) - np.pi, distance]": "a list of the same numbers",
    },
)


# --- 6.3 nees, 6.4 nis ---


def _root_of(error: Any, covariance: Any) -> float:
    return float(np.sqrt(error @ np.linalg.inv(covariance) @ error))


def _over_each_entry(error: Any, covariance: Any) -> float:
    with np.errstate(all="ignore"):
        return float(error @ (1 / np.asarray(covariance)) @ error)


def _by_cholesky(error: Any, covariance: Any) -> float:
    return float(np.sum(np.linalg.solve(np.linalg.cholesky(covariance), error) ** 2))


def _by_eigenvalues(error: Any, covariance: Any) -> float:
    values, vectors = np.linalg.eigh(covariance)
    return float((((vectors.T @ error) ** 2) / values).sum())


def _by_inverse(error: Any, covariance: Any) -> Any:
    column = np.asarray(error).reshape(-1, 1)
    return (column.T @ np.linalg.inv(covariance) @ column).item()


def _by_lists(error: Any, covariance: Any) -> float:
    inverse = np.linalg.pinv(covariance)
    return sum(error[i] * inverse[i, j] * error[j] for i in range(len(error)) for j in range(len(error)))


def _nees_public() -> list[Case]:
    return [
        Case((np.array([0.2, 0.0]), np.diag([0.04, 0.01])), "20 cm off along x, where sigma is 20 cm"),
        Case((np.array([0.0, 0.2]), np.diag([0.04, 0.01])), "20 cm off along y, where sigma is 10 cm"),
        Case(
            (np.array([0.3, 0.3]), np.array([[0.09, 0.06], [0.06, 0.09]])),
            "off along the long axis of an ellipse",
        ),
        Case((np.array([0.3, -0.3]), np.array([[0.09, 0.06], [0.06, 0.09]])), "just as far off, across it"),
        Case((np.array([0.1, -0.2, 0.05]), spread(np.random.default_rng(61), 3, scale=0.3)), "a pose"),
        Case((np.array([2.0, 1.0, -3.0]), spread(np.random.default_rng(62), 3, scale=2.0)), "a pose far off"),
    ]


def _nees_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case((rng.normal(0, 1.5, size), spread(rng, size, scale=float(rng.uniform(0.4, 2)))))
        for size in (1, 2, 2, 3, 3, 4)
    ]


def _squares(which: str) -> list[Mistake]:
    """Mistakes of both exercises; `which` is what is weighed."""
    return [
        Mistake(
            "no inverse",
            lambda error, covariance: float(error @ covariance @ error),
            f"You multiply by the covariance. The {which} is divided by it: multiply by its inverse, or solve.",
        ),
        Mistake(
            "root",
            _root_of,
            "That is its root, the Mahalanobis distance. The square itself is wanted: it has a chi-square distribution.",
        ),
        Mistake(
            "divided by the degrees",
            lambda error, covariance: float(error @ np.linalg.solve(covariance, error)) / len(error),
            f"You divide by the number of values. The bands are for the sum: a healthy {which} of n values has n on average.",
        ),
        Mistake(
            "diagonal only",
            lambda error, covariance: float(np.sum(error**2 / np.diag(covariance))),
            "Right where nothing is correlated. You use the variances alone: the covariance's other entries count, too.",
        ),
        Mistake(
            "each entry's inverse",
            _over_each_entry,
            "You take one over each entry. The inverse of a matrix is another matrix: np.linalg.inv, or np.linalg.solve(covariance, error).",
        ),
        Mistake(
            "still a matrix",
            lambda error, covariance: error.reshape(1, -1) @ np.linalg.inv(covariance) @ error.reshape(-1, 1),
            "The number is there, but in a matrix of one row and one column: vectors of shape (n,) are enough, error @ ... @ error is a number then.",
        ),
        Mistake(
            "* for @",
            lambda error, covariance: error * np.linalg.inv(covariance) * error,
            "* multiplies entry by entry, so a matrix is left. The matrix product is @, and vector @ matrix @ vector is a number.",
        ),
        Mistake(
            "standard deviations for variances",
            lambda error, covariance: float(np.sum((error / np.diag(covariance)) ** 2)),
            "You square the error over the variance. The diagonal has variances already: the square of the error stands over the variance itself.",
        ),
        Mistake(
            "no covariance",
            lambda error, covariance: float(error @ error),
            "That is the plain length squared: the covariance does not enter. Is 20 cm much? That depends on it.",
        ),
    ]


NEES = Exercise(
    name="nees",
    points=2,
    stars=1,
    public=_nees_public,
    hidden=_nees_hidden,
    comparison=Close(atol=1e-9),
    hints=(
        "For one number it is the square of error over standard deviation. For several the covariance takes the place of the variance: divide by a matrix.",
        "np.linalg.solve(covariance, error) is the inverse times the error. One more product with the error makes a number of it.",
    ),
    mistakes=_squares("error"),
    alternatives={
        "Cholesky": _by_cholesky,
        "along the eigenvectors": _by_eigenvalues,
        "columns and an inverse": _by_inverse,
    },
    equivalents={
        "return error @ np.linalg.solve(covariance, error)": "NumPy's number is a number",
        "return float(np.linalg.solve(covariance, error) @ error)": "a product of two vectors has no order",
    },
)


def _nis_public() -> list[Case]:
    return [
        Case((np.array([0.03, 0.1]), np.diag([0.0009, 0.01])), "one sigma off in both"),
        Case(
            (np.array([0.06, -0.2]), np.array([[0.002, 0.003], [0.003, 0.02]])),
            "bearing and range correlated",
        ),
        Case(
            (np.array([0.02, 0.3, -0.05, 0.1]), spread(np.random.default_rng(63), 4, scale=0.4)),
            "two landmarks at once",
        ),
    ]


def _nis_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case((rng.normal(0, 0.8, size), spread(rng, size, scale=float(rng.uniform(0.3, 1.5)))))
        for size in (2, 2, 2, 4, 6)
    ]


NIS = Exercise(
    name="nis",
    points=1,
    stars=1,
    uses=("nees",),
    public=_nis_public,
    hidden=_nis_hidden,
    comparison=Close(atol=1e-9),
    hints=(
        "The same weighing as in 6.3, of another vector by another matrix.",
        "Call nees with the innovation in the error's place, and S in the covariance's.",
    ),
    mistakes=_squares("innovation"),
    alternatives={
        "Cholesky": _by_cholesky,
        "columns and an inverse": _by_inverse,
        "a sum over both indices": _by_lists,
    },
)


# --- 6.5 covariance_ellipse ---


def _ellipse(covariance: Any, probability: float, **changed: Any) -> tuple[Array, float]:
    values, vectors = np.linalg.eigh(covariance)
    radius = {
        "one sigma": 1.0,
        "one dimension": _normal_quantile(probability),
        "half": np.sqrt(-np.log(1 - probability)),
        "inside": np.sqrt(-2 * np.log(probability)),
        "squared": -2 * np.log(1 - probability),
    }.get(changed.get("radius", ""), np.sqrt(-2 * np.log(1 - probability)))
    axes = radius * (values if changed.get("no_root") else np.sqrt(values))[::-1] * changed.get("factor", 1.0)
    direction = vectors[:, 0 if changed.get("minor") else 1]
    angle = (
        np.arctan2(direction[0], direction[1])
        if changed.get("swapped")
        else np.arctan2(direction[1], direction[0])
    )
    if changed.get("degrees"):
        angle = np.degrees(angle)
    return (axes[::-1] if changed.get("small_first") else axes), angle


def _normal_quantile(probability: float) -> float:
    from scipy.stats import norm

    return float(norm.ppf((1 + probability) / 2))


def _changed_ellipse(**changed: Any) -> Any:
    return lambda covariance, probability: _ellipse(covariance, probability, **changed)


def _closed_form(covariance: Any, probability: float) -> tuple[list[float], float]:
    (a, b), (_, d) = np.asarray(covariance).tolist()
    middle, reach = (a + d) / 2, np.hypot((a - d) / 2, b)
    scale = -2 * np.log1p(-probability)
    return [
        float(np.sqrt(scale * (middle + reach))),
        float(np.sqrt(scale * max(middle - reach, 0.0))),
    ], float(np.arctan2(2 * b, a - d) / 2)


def _by_svd(covariance: Any, probability: float) -> Any:
    from scipy.stats import chi2

    left, values, _ = np.linalg.svd(covariance)
    return np.sqrt(values * chi2.ppf(probability, 2)), float(np.arctan2(-left[1, 0], -left[0, 0]))


def _by_eig(covariance: Any, probability: float) -> Any:
    values, vectors = np.linalg.eig(covariance)
    order = np.argsort(-values)
    axes = np.sqrt(values[order]) * np.sqrt(2 * np.log(1 / (1 - probability)))
    x, y = vectors[:, order[0]]
    return tuple(axes), np.arctan(y / x) if x else np.pi / 2


def _ellipse_public() -> list[Case]:
    return [
        Case((np.diag([0.09, 0.01]), 0.95), "long along x"),
        Case((np.diag([0.01, 0.04]), 0.95), "long along y"),
        Case((np.array([[0.05, 0.03], [0.03, 0.05]]), 0.95), "long along the diagonal"),
        Case((np.array([[0.3, -0.2], [-0.2, 0.6]]), 0.5), "falling to the right, half of the probability"),
        Case((np.array([[2.0, 0.9], [0.9, 0.7]]), 0.3935), "the one-sigma ellipse"),
    ]


def _ellipse_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for probability in (0.2, 0.5, 0.9, 0.95, 0.99, 0.6):
        angle, (short, long) = (
            rng.uniform(0.15, 1.4) + np.pi / 2 * rng.integers(0, 2),
            np.array([0.1, 0.5]) * rng.uniform(0.7, 1.4, 2),
        )
        turned = rotation_2d(angle)
        cases.append(Case((turned @ np.diag([long**2, short**2]) @ turned.T, probability)))
    return cases


COVARIANCE_ELLIPSE = Exercise(
    name="covariance_ellipse",
    points=3,
    stars=2,
    public=_ellipse_public,
    hidden=_ellipse_hidden,
    comparison=Each((Close(atol=1e-9), Close(atol=1e-6, period=np.pi))),
    hints=(
        "np.linalg.eigh gives eigenvalues from the smallest to the largest, and eigenvectors as columns. Eigenvalues are variances along the axes.",
        "The semi-axes are the roots of the eigenvalues times the root of -2 ln(1 - probability), the larger first; the angle is np.arctan2(y, x) of vectors[:, 1].",
    ),
    mistakes=[
        Mistake(
            "root forgotten",
            _changed_ellipse(no_root=True),
            "Your axes are in m^2: an eigenvalue is a variance. Its root is a length.",
        ),
        Mistake(
            "one sigma always",
            _changed_ellipse(radius="one sigma"),
            "Your ellipse is the same for each probability. How far it reaches follows from the probability.",
        ),
        Mistake(
            "one dimension",
            _changed_ellipse(radius="one dimension"),
            "That is how far one goes on a line: 1.96 for 95 %. In the plane two values may be off, and 95 % take 2.45.",
        ),
        Mistake(
            "the 2 forgotten",
            _changed_ellipse(radius="half"),
            "Your axes are too short by the root of 2: it is -2 ln(1 - p).",
        ),
        Mistake(
            "outside for inside",
            _changed_ellipse(radius="inside"),
            "The more probability you want inside, the smaller your ellipse: it is ln(1 - p), not ln(p).",
        ),
        Mistake(
            "radius squared",
            _changed_ellipse(radius="squared"),
            "-2 ln(1 - p) is the square of how many standard deviations: take its root, too.",
        ),
        Mistake(
            "small axis first",
            _changed_ellipse(small_first=True),
            "Your smaller semi-axis comes first. eigh sorts from the smallest on; the larger one is wanted first.",
        ),
        Mistake(
            "diameters",
            _changed_ellipse(factor=2.0),
            "Your axes are twice too long: semi-axes reach from the middle to the edge.",
        ),
        Mistake(
            "the minor axis's angle",
            _changed_ellipse(minor=True),
            "Your angle is that of the short axis. That of the long one is wanted: the last eigenvector of eigh.",
        ),
        Mistake(
            "x and y exchanged",
            _changed_ellipse(swapped=True),
            "Your angle is measured from the y axis: np.arctan2 takes y first.",
        ),
        Mistake(
            "degrees",
            _changed_ellipse(degrees=True),
            "Your angle is in degrees; radians are wanted.",
        ),
    ],
    alternatives={"closed form": _closed_form, "svd and chi2": _by_svd, "eig, sorted": _by_eig},
    equivalents={
        "x, y = directions[1, :]": "two by two, eigh's eigenvectors have the same rows as columns, up to signs that turn an axis by half a turn",
    },
)


# --- 6.6 kalman_update ---


def _update(
    mean: Any, covariance: Any, innovation: Any, H: Any, R: Any, **changed: Any
) -> tuple[Array, Array]:
    """The update with one thing done in another way."""
    P = np.asarray(covariance)
    S = H @ P @ H.T + (0 if changed.get("no_R") else R)
    K = P @ H.T @ (S if changed.get("no_inverse") else np.linalg.inv(S))
    if changed.get("gain_transposed"):
        K = np.linalg.inv(S) @ H @ P
    if changed.get("one"):
        K = H.T @ np.linalg.inv(S)
    if changed.get("over_R"):
        K = P @ H.T @ np.linalg.inv(R)
    step = K @ innovation
    left = np.eye(len(P)) - K @ H
    new = {
        "same": P,
        "left": left,
        "added": (np.eye(len(P)) + K @ H) @ P,
        "behind": P @ left,
        "no_noise": left @ P @ left.T,
        "not_transposed": left @ P @ left + K @ np.asarray(R) @ K.T,
        "ones": (1 - K @ H) @ P,
    }.get(changed.get("after", ""), left @ P)
    return (mean - step if changed.get("minus") else mean + step), new


def _changed_update(**changed: Any) -> Any:
    def function(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> tuple[Array, Array]:
        return _update(mean, covariance, innovation, H, R, **changed)

    return function


def _kept_mean(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    return np.array(mean), _update(mean, covariance, innovation, H, R)[1]


def _wrapped_heading(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    new, left = _update(mean, covariance, innovation, H, R)
    if len(new) > 2:
        new[2] = wrapped(new[2])
    return new, left


def _wrapped_mean(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    new, left = _update(mean, covariance, innovation, H, R)
    return wrapped(new), left


def _wrapped_bearing(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    return _update(mean, covariance, np.append(wrapped(innovation[0]), innovation[1:]), H, R)


def _wrapped_innovation(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    return _update(mean, covariance, wrapped(innovation), H, R)


def _hph(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    S = H @ covariance @ H + R
    K = covariance @ H.T @ np.linalg.inv(S)
    return mean + K @ innovation, (np.eye(len(mean)) - K @ H) @ covariance


def _times(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    K = covariance @ H.T @ np.linalg.inv(H @ covariance @ H.T + R)
    return mean + K * innovation, (np.eye(len(mean)) - K @ H) @ covariance


def _symmetrised(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    new_mean, short = _update(mean, covariance, innovation, H, R)
    return new_mean, (short + short.T) / 2


def _less_what_is_known(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    cross = covariance @ H.T
    S = H @ cross + R
    return mean + cross @ np.linalg.solve(S, innovation), covariance - cross @ np.linalg.solve(S, cross.T)


def _information(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    weight = H.T @ np.linalg.inv(R)
    new = np.linalg.inv(np.linalg.inv(covariance) + weight @ H)
    return [mean + new @ weight @ innovation, new]


def _as_lists(mean: Any, covariance: Any, innovation: Any, H: Any, R: Any) -> Any:
    new_mean, new = _update(mean, covariance, innovation, H, R)
    return new_mean.tolist(), new.tolist()


def _update_public() -> list[Case]:
    rng = np.random.default_rng(66)
    return [
        Case(
            (np.array([2.0]), np.array([[0.04]]), np.array([1.0]), np.array([[1.0]]), np.array([[0.01]])),
            "the one dimension of exercise 6.1",
        ),
        Case(
            (
                np.array([2.0, 1.0]),
                np.array([[0.3, 0.1], [0.1, 0.2]]),
                np.array([0.5]),
                np.array([[1.0, 0.0]]),
                np.array([[0.1]]),
            ),
            "a position of which x is measured",
        ),
        Case(
            (
                rng.normal(size=2),
                spread(rng, 2),
                rng.normal(size=2),
                np.array([[0.0, 2.0], [1.0, 0.5]]),
                spread(rng, 2, scale=0.5),
            ),
            "two values, two measurements",
        ),
        Case(
            (
                rng.normal(size=3),
                spread(rng, 3),
                rng.normal(size=2),
                rng.normal(size=(2, 3)),
                spread(rng, 2, scale=0.7),
            ),
            "a pose, bearing and range",
        ),
        _turning_on(np.random.default_rng(67), "a state that passes 180 degrees"),
        _far_off(np.random.default_rng(68), "an innovation of 5 m"),
    ]


def _turning_on(rng: np.random.Generator, name: str = "") -> Case:
    """A third value of nearly half a turn, which the measurement raises."""
    H = np.array([[0.0, 0.0, 1.0], [1.0, rng.uniform(-0.5, 0.5), 0.0]])
    mean = np.array([*rng.normal(size=2), rng.uniform(3.0, 3.1)])
    return Case((mean, spread(rng, 3), np.array([rng.uniform(1.0, 1.5), 0.1]), H, np.eye(2) * 0.2), name)


def _far_off(rng: np.random.Generator, name: str = "") -> Case:
    """Innovations that would be no angles."""
    return Case(
        (rng.normal(size=3), spread(rng, 3), np.array([5.0, -4.5]), rng.normal(size=(2, 3)), np.eye(2) * 0.3),
        name,
    )


def _update_hidden(rng: np.random.Generator) -> list[Case]:
    return [_turning_on(rng), _far_off(rng)] + [
        Case(
            (
                rng.normal(size=n),
                spread(rng, n),
                rng.normal(size=m),
                rng.normal(size=(m, n)),
                spread(rng, m, scale=float(rng.uniform(0.4, 1.2))),
            )
        )
        for n, m in ((1, 1), (2, 1), (2, 2), (3, 2), (3, 2), (3, 4), (5, 2))
    ]


KALMAN_UPDATE = Exercise(
    name="kalman_update",
    points=4,
    stars=2,
    public=_update_public,
    hidden=_update_hidden,
    comparison=Each((Close(atol=1e-8), Close(atol=1e-8))),
    hints=(
        "Write S, then K, then the mean, then the covariance: one line each. Check shapes: H is (m, n), S (m, m), K (n, m).",
        "S = H P Hᵀ + R; K = P Hᵀ S^-1; the new mean is mean + K @ innovation, the new covariance (I - K H) P, or the longer form of equation 6.8.",
    ),
    mistakes=[
        Mistake(
            "S without R",
            _changed_update(no_R=True),
            "R is missing in S: you take the measurement for exact. Where it has as many values as the state, nothing is left of the prediction.",
        ),
        Mistake(
            "gain over R",
            _changed_update(over_R=True),
            "You divide by R alone. The innovation is uncertain by both, S = H P Hᵀ + R.",
        ),
        Mistake(
            "no inverse",
            _changed_update(no_inverse=True),
            "You multiply by S; the gain divides by it: K = P Hᵀ S^-1.",
        ),
        Mistake(
            "P left out of the gain",
            _changed_update(one=True),
            "P is missing in the gain: K = P Hᵀ S^-1. What is known poorly has to move farther.",
        ),
        Mistake(
            "gain transposed",
            _changed_update(gain_transposed=True),
            "Your gain is transposed: S^-1 H P is Kᵀ. K has a row for each value of the state and a column for each measurement.",
        ),
        Mistake(
            "H P H",
            _hph,
            "It is H P Hᵀ, with the second H transposed: S has as many rows and columns as there are measurements. Where all shapes are alike, Python says nothing.",
        ),
        Mistake(
            "innovation's sign",
            _changed_update(minus=True),
            "You go the wrong way: the mean moves by plus K times the innovation, which is measured less expected.",
        ),
        Mistake(
            "* for @",
            _times,
            "K * innovation multiplies entry by entry. The matrix product is @.",
        ),
        Mistake(
            "covariance not updated",
            _changed_update(after="same"),
            "The mean is right, the covariance is the old one: after a measurement the robot is surer.",
        ),
        Mistake(
            "mean not updated",
            _kept_mean,
            "The covariance is right, the mean is the old one: it moves by K times the innovation.",
        ),
        Mistake(
            "heading wrapped here",
            _wrapped_heading,
            "You wrap the third value. This function does not know that it is an angle: in lesson 07 a landmark may stand there. localize wraps.",
        ),
        Mistake(
            "mean wrapped",
            _wrapped_mean,
            "You wrap the mean, as if all its values were angles. This function does not know which are: localize wraps the heading.",
        ),
        Mistake(
            "innovation wrapped here",
            _wrapped_innovation,
            "You wrap the innovation, as if all its values were angles. It comes in as it is to be taken; 5 m stay 5 m.",
        ),
        Mistake(
            "bearing wrapped here",
            _wrapped_bearing,
            "You wrap the innovation's first value. This function does not know that it is an angle: it comes in as it is to be taken.",
        ),
        Mistake(
            "1 for I",
            _changed_update(after="ones"),
            "1 - K @ H takes every entry of K H from 1. The matrix I has ones on the diagonal only: np.eye(len(mean)).",
        ),
        Mistake(
            "Joseph's form without a transpose",
            _changed_update(after="not_transposed"),
            "In Joseph's form the second I - K H is transposed: (I - K H) P (I - K H)ᵀ. Without it the matrix is not even symmetric.",
        ),
        Mistake(
            "P forgotten behind",
            _changed_update(after="left"),
            "You return I - K H: it is the factor by which P shrinks, (I - K H) P.",
        ),
        Mistake(
            "plus for minus",
            _changed_update(after="added"),
            "Your covariance grows by the measurement: it is I - K H.",
        ),
        Mistake(
            "wrong side",
            _changed_update(after="behind"),
            "You multiply from the other side: (I - K H) P, not P (I - K H). Your matrix is not even symmetric.",
        ),
        Mistake(
            "half of Joseph's form",
            _changed_update(after="no_noise"),
            "(I - K H) P (I - K H)ᵀ alone forgets that the measurement has noise: K R Kᵀ belongs to it.",
        ),
    ],
    alternatives={
        "symmetrised": _symmetrised,
        "what is known is taken off": _less_what_is_known,
        "information form": _information,
        "the short form, as lists": _as_lists,
    },
    equivalents={
        "left = K @ H - np.eye(len(mean))": "it stands there twice, so its sign does not matter",
    },
)


# --- 6.7 localize ---


def _bearing_range(pose: Any, landmark: Any) -> Array:
    (x, y), *_ = Pose(*pose).to_local(landmark)
    return np.array([np.arctan2(y, x), np.hypot(x, y)])


def _slopes(pose: Any, landmark: Any) -> Array:
    """How bearing and range change with the pose, by central differences."""
    columns = []
    for step in 1e-6 * np.eye(3):
        change = _bearing_range(np.add(pose, step), landmark) - _bearing_range(
            np.subtract(pose, step), landmark
        )
        change[0] = wrapped(change[0])
        columns.append(change / 2e-6)
    return np.column_stack(columns)


def _heading_by(rule: Callable[[float], float]) -> Callable[[Array], Array]:
    return lambda pose: np.array([pose[0], pose[1], rule(pose[2])])


_HEADINGS: dict[str, Callable[[Array], Array]] = {
    "right": _heading_by(wrapped),
    "as it is": _heading_by(float),
    "0 to a turn": _heading_by(lambda angle: angle % TURN),
    "too large only": _heading_by(lambda angle: angle - TURN * (angle > np.pi)),
    "too small only": _heading_by(lambda angle: angle + TURN * (angle < -np.pi)),
    "all": lambda pose: np.asarray(wrapped(pose)),
}


def _localized(pose: Any, covariance: Any, measurement: Any, landmark: Any, R: Any, **changed: Any) -> Any:
    """One look with one thing done in another way."""
    expected = _bearing_range(pose, landmark)
    if changed.get("degrees"):
        expected[0] = np.degrees(expected[0])
    difference = np.asarray(measurement) - expected
    if changed.get("minus"):
        difference = -difference
    if not changed.get("unwrapped"):
        difference[0] = wrapped(difference[0])
    H = _slopes(pose, landmark)
    if changed.get("of_landmark"):
        H = np.column_stack([-H[:, :2], np.zeros(2)])
    if changed.get("no_heading"):
        H = H * (1.0, 1.0, 0.0)
    if changed.get("rows"):
        H = H[::-1]
    noise = np.sqrt(R) if changed.get("roots") else R
    new, left = _update(pose, covariance, difference, H, noise)
    new = _HEADINGS[changed.get("heading", "right")](new)
    return new, (covariance if changed.get("same") else left)


def _changed_look(**changed: Any) -> Any:
    def function(pose: Any, covariance: Any, measurement: Any, landmark: Any, R: Any) -> Any:
        return _localized(pose, covariance, measurement, landmark, R, **changed)

    return function


def _twice(pose: Any, covariance: Any, measurement: Any, landmark: Any, R: Any) -> Any:
    return _localized(*_localized(pose, covariance, measurement, landmark, R), measurement, landmark, R)


def _bearing_alone(pose: Any, covariance: Any, measurement: Any, landmark: Any, R: Any) -> Any:
    difference = wrapped(np.asarray(measurement) - _bearing_range(pose, landmark))
    new, left = _update(pose, covariance, difference[:1], _slopes(pose, landmark)[:1], R[:1, :1])
    return _HEADINGS["right"](new), left


def _nothing_behind(pose: Any, covariance: Any, measurement: Any, landmark: Any, R: Any) -> Any:
    if abs(measurement[0]) > np.pi / 2:
        return pose, covariance
    return _localized(pose, covariance, measurement, landmark, R)


def _one_by_one(pose: Any, covariance: Any, measurement: Any, landmark: Any, R: Any) -> Any:
    """Bearing and range after each other, both linearised where the first one was; R is diagonal."""
    difference = np.asarray(measurement) - _bearing_range(pose, landmark)
    difference[0] = wrapped(difference[0])
    slopes, new, left = _slopes(pose, landmark), np.array(pose, dtype=float), covariance
    for row in range(2):
        H = slopes[row : row + 1]
        still = difference[row : row + 1] - H @ (new - pose)
        new, left = _update(new, left, still, H, R[row : row + 1, row : row + 1])
    new[2] = np.arctan2(np.sin(new[2]), np.cos(new[2]))
    return new, left


def _with_information(pose: Any, covariance: Any, measurement: Any, landmark: Any, R: Any) -> Any:
    H = _slopes(pose, landmark)
    difference = np.asarray(measurement) - _bearing_range(pose, landmark)
    difference[0] = np.angle(np.exp(1j * difference[0]))
    new, left = _information(np.asarray(pose), covariance, difference, H, R)
    return [[new[0], new[1], np.angle(np.exp(1j * new[2]))], left]


def _less(pose: Any, covariance: Any, measurement: Any, landmark: Any, R: Any) -> Any:
    """What is known is taken off."""
    difference = np.asarray(measurement) - _bearing_range(pose, landmark)
    difference[0] = wrapped(difference[0])
    new, left = _less_what_is_known(np.asarray(pose), covariance, difference, _slopes(pose, landmark), R)
    while abs(new[2]) > np.pi:
        new[2] -= np.sign(new[2]) * TURN
    return new, left


def _look(
    pose: Any, landmark: Any, error: Any, sigmas: tuple[float, float], covariance: Array, name: str = ""
) -> Case:
    measured = _bearing_range(pose, landmark) + error
    measured[0] = wrapped(measured[0])
    return Case(
        (
            np.array(pose, dtype=float),
            covariance,
            measured,
            np.array(landmark, dtype=float),
            np.diag(sigmas) ** 2,
        ),
        name,
    )


def _localize_public() -> list[Case]:
    wide = np.diag([0.09, 0.09, 0.03])
    tight = np.array([[0.02, 0.005, 0.001], [0.005, 0.03, -0.002], [0.001, -0.002, 0.004]])
    return [
        _look((0.0, 0.0, 0.0), (2.0, 0.0), (0.1, -0.2), (0.05, 0.1), wide, "a landmark straight ahead"),
        _look((1.2, 0.3, 0.15), (3.0, 0.7), (-0.05, 0.15), (0.03, 0.09), wide, "a goal post"),
        _look(
            (1.5, 1.0, -0.63), (0.0, 2.0), (-0.5, 0.1), (0.03, 0.09), wide, "a corner behind, at 179 degrees"
        ),
        _look(
            (2.0, -1.0, 2.4),
            (2.4, -1.1),
            (0.08, 0.05),
            (0.04, 0.05),
            tight,
            "a corner near by, correlated doubts",
        ),
        _look((0.5, 0.0, -1.0), (3.0, 2.0), (0.0, 0.0), (0.03, 0.1), tight, "a measurement just as expected"),
        _look(
            (2.2, 0.4, 3.1), (0.0, 2.0), (-0.2, 0.1), (0.03, 0.1), wide, "a heading that passes 180 degrees"
        ),
        _look((2.2, -0.4, -3.1), (0.0, -2.0), (0.2, 0.1), (0.03, 0.1), wide, "and one that passes -180"),
        _look(
            (3.4, 0.2, 3.0),
            (2.4, 1.1),
            (0.05, 0.1),
            (0.03, 0.05),
            tight,
            "a robot behind the goal line, x = 3.4",
        ),
    ]


def _localize_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for _ in range(7):
        pose = (rng.uniform(0, 2), rng.uniform(-1.5, 1.5), rng.uniform(-3, 3))
        away, direction = rng.uniform(0.6, 3.0), rng.uniform(-np.pi, np.pi)
        landmark = (pose[0] + away * np.cos(direction), pose[1] + away * np.sin(direction))
        error = rng.normal(0, 1, 2) * (0.1, 0.2)
        cases.append(
            _look(
                pose,
                landmark,
                error,
                (float(rng.uniform(0.02, 0.1)), float(rng.uniform(0.05, 0.2))),
                spread(rng, 3, scale=0.25),
            )
        )
    for turn in (0.2, -0.2):  # just behind the robot
        pose = (1.0, float(rng.uniform(-0.5, 0.5)), 0.0)
        cases.append(
            _look(pose, (-1.0, pose[1] + 0.1 * turn), (turn, 0.1), (0.05, 0.1), spread(rng, 3, scale=0.3))
        )
    doubt = np.diag([0.04, 0.04, 0.2])
    for side in (1.0, -1.0):  # the heading passes half a turn, on the field and beside it
        for x in (rng.uniform(0.5, 2.0), rng.uniform(3.5, 4.0)):
            pose = (x, rng.uniform(-1.0, 1.0), side * rng.uniform(3.06, 3.12))
            away = (x - 2.0, rng.uniform(-1.0, 1.0))
            cases.append(_look(pose, away, (-0.3 * side, 0.1), (0.03, 0.1), doubt))
    return cases


LOCALIZE = Exercise(
    name="localize",
    points=5,
    stars=3,
    uses=("innovation", "kalman_update", "05:expected_measurement", "05:measurement_jacobian_pose"),
    public=_localize_public,
    hidden=_localize_hidden,
    comparison=Each((Close(atol=1e-7), Close(atol=1e-8))),
    hints=(
        "What do you expect to see from where you believe to be? How does that change with the pose? Two functions of lesson 05 say so, two of this lesson do the rest.",
        "Four lines: the innovation of expected_measurement(pose, landmark) and the measurement; H = measurement_jacobian_pose(pose, landmark); kalman_update with both; wrap the heading.",
    ),
    mistakes=[
        Mistake(
            "innovation unwrapped",
            _changed_look(unwrapped=True),
            "Right until the landmark is behind the robot: there a bearing of 179 degrees is expected and -152 measured, and your estimate leaps. Wrap the innovation.",
        ),
        Mistake(
            "innovation's sign",
            _changed_look(minus=True),
            "You correct the wrong way: the innovation is measured less expected (innovation takes the expected one first), and H has the sign of equation 6.5.",
        ),
        Mistake(
            "Jacobian by the landmark",
            _changed_look(of_landmark=True),
            "Your H is that by the landmark's position. The landmark is known; it is the pose that moves: three columns, and -1 for the heading.",
        ),
        Mistake(
            "heading not wrapped",
            _changed_look(heading="as it is"),
            "Right, except where the heading passes half a turn: wrap the new pose's heading, too. It comes back between -pi and pi.",
        ),
        Mistake(
            "heading 0 to a full turn",
            _changed_look(heading="0 to a turn"),
            "Your heading is between 0 and 2 pi; between -pi and pi is wanted: (angle + np.pi) % (2 * np.pi) - np.pi.",
        ),
        Mistake(
            "heading wrapped from above only",
            _changed_look(heading="too large only"),
            "You take a turn off where the heading is above pi. Where it is below -pi, one has to be added.",
        ),
        Mistake(
            "heading wrapped from below only",
            _changed_look(heading="too small only"),
            "You add a turn where the heading is below -pi. Where it is above pi, one has to be taken off.",
        ),
        Mistake(
            "pose wrapped",
            _changed_look(heading="all"),
            "You wrap all of the pose. x and y are metres: at x = 3.4 your robot leaps to the other side of the field. Wrap the heading alone.",
        ),
        Mistake(
            "heading left out",
            _changed_look(no_heading=True),
            "Your heading never changes: the third column of H is (-1, 0), for a turn to the left brings the landmark to the right.",
        ),
        Mistake(
            "rows exchanged",
            _changed_look(rows=True),
            "The rows of H are exchanged: bearing first, then range, as in the measurement.",
        ),
        Mistake(
            "taken in twice",
            _twice,
            "You take the measurement in twice. It tells something new only once: the second time your covariance is too small.",
        ),
        Mistake(
            "bearing alone",
            _bearing_alone,
            "You use the bearing alone: the range tells how far away the robot is. Hand both rows on.",
        ),
        Mistake(
            "nothing behind",
            _nothing_behind,
            "You leave out what is behind the robot. A landmark there tells as much as any other.",
        ),
        Mistake(
            "R as standard deviations",
            _changed_look(roots=True),
            "You take the root of R. It holds variances already, and S adds variances.",
        ),
        Mistake(
            "covariance kept",
            _changed_look(same=True),
            "The pose is right, the covariance is the old one: return that of kalman_update.",
        ),
        Mistake(
            "degrees",
            _changed_look(degrees=True),
            "You mix degrees and radians: the expected bearing is in radians, like the measured one.",
        ),
    ],
    alternatives={
        "bearing, then range": _one_by_one,
        "information form": _with_information,
        "what is known is taken off": _less,
    },
    equivalents={
        "return ([x, y, np.arctan2(np.sin(theta), np.cos(theta))], covariance)": "a list of the same numbers",
    },
)


PLAN = LessonPlan(
    exercises=[FUSE, INNOVATION, NEES, NIS, COVARIANCE_ELLIPSE, KALMAN_UPDATE, LOCALIZE],
    questions=[
        Question(
            "how_much_weight",
            "The measurement's standard deviation is three times that of the prediction. Which weight does the measurement get?",
            {
                "0: the prediction is better.": "The better one is not all that counts. Even a poor measurement makes the result surer than the "
                "prediction alone.",
                "1/4": "That is the weight by standard deviations, 1 / (1 + 3). The variances are what counts.",
                "1/10": "Its variance is nine times as large: 1 / (1 + 9).",
                "1/3": "Weights add up to one: with 1/3 the prediction would get 2/3, twice as much. How many times larger is the variance?",
            },
            "1/10",
        ),
        Question(
            "near_or_far",
            "A robot knows its position to 5 cm, but its heading only to 20 degrees. Which landmark should it look at?",
            {
                "The nearest: it is measured best.": "Its range is, but the position is known already. Seen from 5 cm beside, a landmark half a metre away "
                "is 6 degrees off: so much is left of the heading's doubt.",
                "The farthest it can see.": "From 5 cm beside, a landmark 4 m away is 0.7 degrees off: little beside the bearing's own noise. The heading is "
                "then known to 1.7 degrees.",
                "It makes no difference: a bearing is a bearing.": "The bearing's noise is the same. But the direction in which a landmark should lie "
                "depends on where the robot is, the more so the nearer it is.",
            },
            "The farthest it can see.",
        ),
        Question(
            "without_truth",
            "On a real field nobody knows the true pose: there is no NEES. Which fault of the table would you not find there?",
            {
                "Q is forgotten": "NIS climbs from 3 to 28 times its healthy value: the robot itself can see that.",
                "R is left out of S": "NIS is nearly twice its healthy value from the first steps on: little beside a NEES of a million, but enough to be seen in "
                "twenty drives.",
                "each measurement is used twice": "Residuals are right, and NIS is within a tenth of its healthy value. Only the truth shows that the ellipse is too "
                "small. The same happens where two measurements share one error, as the landmarks of one tilted picture do.",
                "ranges 15 % too long": "The range's residuals lie 1.6 standard deviations off zero, all on one side.",
            },
            "each measurement is used twice",
        ),
    ],
    written=[
        Written(
            "explain_band",
            points=2,
            question="Why does the 95 % band hold for one step over many drives, and not for one drive over its steps?",
            rubric="1 point: the band is that of a mean of independent values; different drives are independent. 1 point: errors of neighbouring steps of one drive "
            "are nearly the same (the pose carries over from step to step), so a drive has far fewer independent values than steps, and its mean spreads more "
            "widely.",
        )
    ],
)
