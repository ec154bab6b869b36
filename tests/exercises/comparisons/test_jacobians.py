"""A derivative that a student worked out is held against their own model, and the slip is named."""

import numpy as np
import pytest
import sympy
from sympy import Matrix, Mod, atan, atan2, cos, pi, sin, sqrt

from nao_course.codec import decode, encode
from nao_course.exercises import Case, Derivative, Exercise, Mistake, call, judging
from nao_course.exercises.checking import grade_public
from nao_course.exercises.comparisons.jacobians import evaluated, jacobian
from nao_course.instructor.authoring.plans import publish_exercise

x, y, theta, d = sympy.symbols("x y theta d")
BY = ["x", "y", "theta"]
MODEL = Matrix([x + d * cos(theta), y + d * sin(theta) + x * y, theta**2 / 2])
RIGHT = MODEL.jacobian([x, y, theta])
LAW = Derivative(tuple(BY))


def points(seed=3):
    rng = np.random.default_rng(seed)
    values = {name: rng.normal(0, 2, 8) for name in ("x", "y", "theta", "d")}
    values["theta"][:4] = [np.pi, -np.pi, np.pi - 1e-9, 1e-9 - np.pi]
    return values


def sent(model, derived):
    """What comes from a student's process."""
    return decode(encode(jacobian(lambda: (model, derived), list(points()), BY)))


def answer(model, derived):
    return evaluated(sent(model, derived), points(), BY)


def verdict(model, derived):
    return LAW.compare(answer(MODEL, RIGHT), answer(model, derived))


def changed(row, column, entry):
    other = RIGHT.copy()
    other[row, column] = entry
    return other


def test_the_right_one_is_right_and_wrong_entries_are_named_in_reading_order():
    assert verdict(MODEL, RIGHT)
    assert verdict(list(MODEL), RIGHT.tolist())
    other = changed(0, 2, d * cos(theta + pi / 2))
    assert verdict(MODEL, other)
    real = {each: sympy.Symbol(each.name, real=True) for each in (x, y, theta, d)}
    assert verdict(MODEL.subs(real), RIGHT)
    both = changed(0, 2, d * sin(theta))
    both[2, 2] = 2 * theta
    faults = {(0, 2): "its sign is wrong", (2, 2): "it is 2 times as large as it should be"}
    assert LAW.faults(answer(MODEL, both)) == faults
    assert LAW.faults(answer(MODEL, RIGHT)) == {}
    with pytest.raises(ValueError, match="model's shape"):
        LAW.faults(answer(MODEL, RIGHT[:, :2]))


def test_the_wrong_entry_and_the_likely_slip_are_named():
    for derived, text in [
        (changed(0, 2, d * sin(theta)), "row 1, column 3 (by theta) of your Jacobian is not the derivative"),
        (changed(0, 2, d * sin(theta)), "of your own model: its sign"),
        (changed(0, 2, 0), "it is zero, but your model does change"),
        (changed(0, 2, cos(theta)), "a small change of that variable"),
        (changed(2, 0, 1), "your model does not change with that variable"),
        (changed(2, 2, 2 * theta), "it is 2 times as large"),
        (changed(1, 1, x), "the derivative of one term is missing"),
        (changed(1, 1, 1 - x), "the sign of one term"),
        (changed(0, 0, sympy.zoo), "row 1, column 1"),
        (RIGHT.T, "transposed: rows belong to the model"),
        (RIGHT[:2, :], "is 2x3; expected 3x3 for your model"),
    ]:
        found = verdict(MODEL, derived)
        assert not found
        assert text in found.text


def test_a_wrong_model_is_named_and_a_mistake_is_told_by_its_jacobian_and_the_model_beside_it():
    assert "is it transposed?" in verdict(MODEL[:2], RIGHT[:2, :].T).text
    other = MODEL.subs(theta, theta + pi / 2)
    assert "your model is not the model of the exercise" in verdict(other, other.jacobian([x, y, theta])).text
    assert "not a number" in verdict(MODEL + Matrix([sqrt(-1 - x**2), 0, 0]), RIGHT).text
    with pytest.raises(ValueError, match="contain the symbols phi; expected only x, y, theta, d"):
        answer(MODEL + Matrix([sympy.Symbol("phi"), 0, 0]), RIGHT)
    assert "the model first" in LAW.compare(answer(MODEL, RIGHT), gathered(RIGHT, MODEL)).text
    other = MODEL.subs(theta, theta + pi / 2)
    slip = answer(MODEL, other.jacobian([x, y, theta]))
    assert LAW.alike(slip, slip)
    assert not LAW.alike(slip, answer(other, other.jacobian([x, y, theta])))
    assert not LAW.alike(slip, {})


def test_a_model_that_goes_once_round_has_the_same_derivative_and_one_to_the_other_side_other_values():
    bearing = Matrix([atan2(sin(theta), cos(theta)), x, y])
    slope = Matrix([[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    own = answer(bearing, slope)
    assert LAW.compare(own, own)
    wrapped = Matrix([Mod(theta + pi, 2 * pi) - pi, x, y])
    assert LAW.compare(own, answer(wrapped, slope))
    strict, loose = Derivative(tuple(BY), period=(2 * np.pi, 0, 0)), LAW
    right = Matrix([atan2(y, x), theta, x])
    slopes = right.jacobian([x, y, theta])
    wanted = answer(right, slopes)
    for model in (Matrix([atan2(-y, -x), theta, x]), Matrix([atan(y / x), theta, x])):
        got = answer(model, model.jacobian([x, y, theta]))
        assert loose.compare(wanted, got) and loose.alike(wanted, got)
        assert "your model is not the model of the exercise" in strict.compare(wanted, got).text
        assert not strict.alike(wanted, got) and strict.alike(got, got)
    round_once = answer(right + Matrix([2 * pi, 0, 0]), slopes)
    assert strict.compare(wanted, round_once) and strict.alike(wanted, round_once)
    assert not strict.compare(wanted, answer(right + Matrix([0, 2 * pi, 0]), slopes)), "a length has no turns"
    for rounding in (1e-9, -1e-9):
        assert strict.compare(wanted, {**wanted, "model": wanted["model"] + rounding})
    assert not strict.compare(wanted, {**round_once, "model": None})
    assert strict.compare(wanted, answer(right.T, slopes)), "a row of expressions is a model, too"


def of_zeros(shape, terms):
    return {"jacobian": np.zeros(shape), "differences": np.zeros(shape), "terms": terms}


def test_what_a_stranger_sends_is_wrong_and_nothing_worse():
    for got in [
        None,
        {"jacobian": 1, "differences": 2, "terms": 3},
        of_zeros((1, 3, 3), [np.zeros((1, 1))]),
        of_zeros((1, 1, 9), [np.zeros((1, 1))] * 9),
        of_zeros((0, 3, 3), [np.zeros((1, 0))] * 9),
        of_zeros((1, 3, 3), [np.zeros((1, 1))] * 9),
    ]:
        assert not LAW.compare(answer(MODEL, RIGHT), got)


def test_the_points_stay_where_the_judging_is_and_numbers_are_no_expressions():
    case = Case((points(), BY), "eight points")
    (asked,) = LAW.calls(case)
    assert asked.args == (["x", "y", "theta", "d"], BY)
    outcome = judging.answer(LAW, lambda each: call(lambda: (MODEL, RIGHT), each, "jacobian"), case)
    assert LAW.judge(Case((), expected=answer(MODEL, RIGHT)), outcome.value)
    wanted = answer(MODEL, RIGHT)
    for forged in (wanted, {**wanted, "steps": []}, {**sent(MODEL, RIGHT), "jacobian": wanted["jacobian"]}):
        assert LAW.gather(Case((points(), BY)), [forged]) == {}
    for forged in ({"jacobian": [[0] * 200] * 200}, {"terms": [[0] * 2000] * 9}, {"model": [0] * 2000}):
        got = LAW.gather(Case((points(), BY)), [RAW | forged])
        assert not LAW.compare(answer(MODEL, RIGHT), got) or "terms" in forged


RAW = sent(MODEL, RIGHT)
END = len(RAW["steps"])
FORGED_STEPS = [
    *(("sin", place) for place in (END, END + 5, -1, True)),
    *(("system", 0), ("__class__",), ("symbol", "l"), ("constant", "tau"), np.ones(3), None),
    *(("number", "1"), ("number", np.ones(3))),
    *(("ratio", *pair) for pair in ((1, 0), (1.0, 2), (2**60, 1), (True, 1))),
]


@pytest.mark.parametrize(
    "forged",
    [
        *({"steps": [*RAW["steps"], step]} for step in FORGED_STEPS),
        {"steps": [("symbol", "x")] * 20_001},
        *({"model": model} for model in ([END] * 3, ["x"] * 3, [[0]] * 3, [])),
        *({"jacobian": jacobian} for jacobian in ([[]], [[0, 1], [0]], [[None]])),
        *({"terms": terms} for terms in ([[]] * 9, [3] * 9)),
    ],
    ids=lambda forged: str(forged)[-60:],
)
def test_steps_that_make_no_sense_are_no_answer(forged):
    assert LAW.gather(Case((points(), BY)), [RAW]) != {}
    assert LAW.gather(Case((points(), BY)), [RAW | forged]) == {}


def test_an_exercise_of_it_recognises_its_mistakes_and_says_nothing_else():
    def mistake(name, derived, message):
        return Mistake(name, lambda: (MODEL, derived), message)

    exercise = Exercise(
        "toy_jacobian",
        1,
        lambda: [Case((points(), BY), "eight points")],
        lambda rng: [Case((points(int(rng.integers(99))), BY))],
        ("a", "b"),
        [
            mistake("heading", changed(0, 2, d * sin(theta)), "The slope is minus the sine."),
            mistake("transposed", RIGHT.T, "Rows first."),
            mistake("other model", RIGHT, "not told"),
        ],
        {},
        comparison=LAW,
        driver="jacobian",
    )
    public = publish_exercise("5.1", exercise, lambda: (MODEL, RIGHT))
    assert grade_public(public, lambda: (MODEL, RIGHT))
    report = grade_public(public, lambda: (MODEL, changed(0, 2, d * sin(theta))))
    assert report.lines[-1] == "The slope is minus the sine."
    assert "Rows first." in grade_public(public, lambda: (MODEL, RIGHT.T)).lines

    def blank():
        raise NotImplementedError

    assert grade_public(public, blank).state == "not attempted"
    assert call(lambda: (MODEL, "no matrix"), Case((points(), BY)), "jacobian").status == "raised"
    for other, said in ((None, "your answer is None"), (3, "return (model, jacobian)"), (RIGHT, "return (")):
        assert said in repr(grade_public(public, lambda other=other: other))


@pytest.mark.filterwarnings("error")
def test_a_model_that_divides_by_0_is_wrong_and_warns_of_nothing():
    with np.errstate(all="warn"):
        got = evaluated(sent(Matrix([x / d, y, theta]), RIGHT), {**points(), "d": np.zeros(8)}, BY)
    assert not LAW.compare(answer(MODEL, RIGHT), got)


def gathered(model, derived):
    """What the judge makes of an answer, with the test for difference quotients."""
    return LAW.gather(Case((points(), BY)), [sent(model, derived)])


def quotients(model, h, weights=None):
    """A "derivative" from central differences, or from more differences with these weights."""
    weights = weights or {1: sympy.Rational(1, 2)}

    def column(v):
        parts = ((model.subs(v, v + n * h) - model.subs(v, v - n * h)) * w / h for n, w in weights.items())
        return sum(parts, sympy.zeros(3, 1))

    return Matrix.hstack(*map(column, (x, y, theta)))


def small(step, weights=None):
    """The right Jacobian with one entry from differences of any step, in which no value is large."""
    weights = weights or {1: sympy.Rational(1, 2)}
    ends = [(d * (cos(theta + n * step) - cos(theta - n * step)), w * 2) for n, w in weights.items()]
    logs = [(difference, w, sympy.log(sympy.Abs(difference)) - sympy.log(2 * step)) for difference, w in ends]
    terms = (sympy.sign(each) * w * (sympy.cosh(size) + sympy.sinh(size)) for each, w, size in logs)
    return changed(0, 2, sum(terms))


# 0 in floats, 1 with 300 digits; and a number of the size of a rounding error
PRECISE = sympy.Heaviside(sympy.log(1 + sympy.exp(-100 - d**2)), 0)
EPSILON = sympy.Abs(sympy.cosh(d) ** 2 - sympy.sinh(d) ** 2 - 1) + sympy.exp(-28) * (1 - PRECISE)
BY_PRECISION = sympy.exp(-12 - 218 * PRECISE)  # about 1e-5 and 1e-100
GRID = {each: sympy.floor(each * 10**7) / 10**7 for each in (x, y, theta)}
WIDE = {n: sympy.Rational(*each) for n, each in enumerate(((4, 5), (-1, 5), (4, 105), (-1, 280)), start=1)}


@pytest.mark.parametrize(
    "derived",
    [
        quotients(MODEL, 1e-6),
        quotients(MODEL, sympy.Rational(1, 10**5)),
        quotients(MODEL, sympy.Rational(1, 100), WIDE),  # its error is 1e-17, less than that of a float
        changed(0, 2, -0.9999999999 * d * sin(theta)),
        changed(0, 2, d * sympy.im(cos(theta + sympy.I * sympy.Rational(1, 10**6))) * 10**6),
    ],
    ids=["float step", "exact step", "eighth order", "rounded", "complex step"],
)
def test_a_difference_quotient_is_not_a_derivative(derived):
    assert verdict(MODEL, derived), "with floats it is as good as the derivative"
    said = LAW.compare(answer(MODEL, RIGHT), gathered(MODEL, derived))
    assert not said and "A difference quotient is not a derivative" in said.text


GRIDDED = quotients(MODEL, 1e-6).subs(GRID)


@pytest.mark.parametrize(
    ("model", "derived"),
    [
        (MODEL, small(BY_PRECISION)),
        (MODEL, small(sympy.cbrt(EPSILON))),
        (MODEL, small(sympy.Pow(EPSILON, sympy.Rational(1, 9)) / 10, WIDE)),
        (MODEL * (1 - PRECISE), quotients(MODEL, 1e-5) * (1 - PRECISE)),
        (MODEL.subs(GRID) + GRIDDED * Matrix([each - GRID[each] for each in GRID]), GRIDDED),
    ],
    ids=["two steps", "step of the precision", "of eighth order", "two models", "on a grid"],
)
def test_an_answer_gains_nothing_by_the_precision_that_it_is_computed_with(model, derived):
    assert not gathered(model, derived)["exact"].all()


EXP = Matrix([0, 0, sympy.exp(x / 7)])


@pytest.mark.parametrize(
    ("model", "derived"),
    [
        (MODEL, RIGHT),
        (MODEL, changed(0, 2, -d * sqrt(1 - cos(theta) ** 2) * sympy.sign(sin(theta)))),
        (MODEL, changed(0, 2, d * cos(theta + pi / 2))),
        (MODEL, changed(0, 2, d * sympy.Add(cos(theta), -sin(theta) - cos(theta), evaluate=False))),
        (MODEL + EXP, (MODEL + EXP).jacobian([x, y, theta])),
        (MODEL + Matrix([0, 0, sympy.Max(x, -9)]), RIGHT + Matrix([[0, 0, 0], [0, 0, 0], [1, 0, 0]])),
    ],
)
def test_a_derivative_is_exact_in_whatever_form_it_is_written(model, derived):
    assert gathered(model, derived)["exact"].all()


@pytest.mark.slow
def test_what_is_too_long_or_too_large_is_not_exact():
    assert not gathered(MODEL + Matrix([0, 0, sympy.exp(40)]), RIGHT)["exact"].any()
    padding = Matrix([0, 0, sympy.Add(*(cos(n * x) / n for n in range(1, 900)))])
    assert not gathered(MODEL + padding, RIGHT + padding.jacobian([x, y, theta]))["exact"].any()
