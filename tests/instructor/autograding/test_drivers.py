"""Who replaces the driver beside their function gains nothing: it brings back raw answers, and the grader computes."""

import numpy as np
import pytest
import sympy

from nao_course.exercises import Case, Derivative, Exercise, Mistake
from nao_course.instructor.authoring.plans import hidden_cases, publish_exercise
from nao_course.instructor.autograding.assignment import Assignment, Task
from nao_course.instructor.autograding.grader import grade
from nao_course.instructor.collecting.submissions import Submission
from tests.toy import toy

MODEL = """
import sympy
x, y = sympy.symbols("x y")
model = sympy.Matrix([sympy.sin(x) * y, x + y**2])
"""
RIGHT = (
    MODEL + "def derive():\n    return model, sympy.Matrix([[y * sympy.cos(x), sympy.sin(x)], [1, 2 * y]])"
)
WRONG = MODEL + "def derive():\n    return model, sympy.Matrix([[y, 1], [1, 2]])"
# What the driver once made beside the student's code, by differences: the slopes without a derivation.
FORGED = """
import sys
import numpy as np
from nao_course.exercises import running

def slopes(points):
    def model(x, y): return np.stack([np.sin(x) * y, x + y**2], axis=1)
    at = points["x"], points["y"]
    moved = [[model(*(each + 1e-6 * sign * (i == k) for i, each in enumerate(at))) for sign in (1, -1)] for k in (0, 1)]
    both = np.stack([(more - less) / 2e-6 for more, less in moved], axis=2)
    return {"jacobian": both, "differences": both, "model": model(*at), "terms": [np.zeros((1, len(at[0])))] * 4}

def forge(function, points, by):
    if not isinstance(points, dict):
        points = {name: np.linspace(-1.0, 1.0, 5) for name in points}
    return slopes(points)

running._DRIVERS["jacobian"] = forge
def derive(): return None
"""
NUMBERS = FORGED.replace(
    "return slopes(points)",
    "made = slopes(points)\n    steps = [('number', float(each)) for each in made['jacobian'][0].ravel()]\n"
    "    return {'steps': steps, 'model': [0, 1], 'jacobian': [[0, 1], [2, 3]], 'terms': [[0]] * 4}",
)


def points(rng):
    return Case(({name: rng.normal(0, 1, 5) for name in ("x", "y")}, ["x", "y"]))


@pytest.fixture(scope="module")
def assignment():
    namespace = {}
    exec(RIGHT, namespace)
    x, y = sympy.symbols("x y")
    wrong = namespace["model"], sympy.Matrix([[-y * sympy.cos(x), sympy.sin(x)], [1, 2 * y]])
    exercise = Exercise(
        "derive",
        1,
        driver="jacobian",
        comparison=Derivative(("x", "y")),
        public=lambda: [points(np.random.default_rng(1))],
        hidden=lambda rng: [points(rng)],
        hints=("a", "b"),
        mistakes=[Mistake("sign", lambda: wrong, "The sign.")],
        alternatives={},
    )
    public = publish_exercise("5.1", exercise, namespace["derive"])
    task = Task(public, tuple(hidden_cases(exercise, namespace["derive"], 7)))
    return Assignment("95_derive", (task,), seconds=60.0)


@pytest.mark.parametrize(
    ("source", "earned"), [(RIGHT, 1.0), (WRONG, 0.0), (FORGED, 0.0), (NUMBERS, 0.0)], ids="rwfn"
)
def test_only_a_derivation_earns_the_points_of_one(assignment, warm_server, tmp_path, source, earned):
    path = toy.write(tmp_path / "95_derive.ipynb", source)
    result = grade(Submission("ada", "95_derive", path), assignment, warm_server)
    assert result.earned == earned, result.exercises
