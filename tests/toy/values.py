"""A course of one lesson whose exercises hand over every kind of value, and compare it in every way."""

from pathlib import Path

import numpy as np

from nao_course.exercises import register
from nao_course.instructor.authoring.course import Course
from tests.toy import chain

LESSON = "92_values"
SETUP = """
import numpy as np
from nao_course.geometry import Pose
from nao_course.slam import Measurement
"""
DECLARATION = """
import numpy as np
from scipy import sparse
from nao_course.exercises import Between, Case, Close, Each, Exact, Exercise, LessonPlan, Mistake, Property, Sampled
from nao_course.exercises import All, Unordered
from nao_course.geometry import Pose, rotation_2d, wrap_angle
from nao_course.sim import CameraView, Landmark
from nao_course.slam import Motion
from tests.toy.values import solves

def exercise(name, comparison, cases, driver=""):
    wrong = [Mistake("none", lambda *_: 0.0, f"That is always zero in {name}.")]
    draw = lambda rng: cases(rng) + cases(rng)
    public = lambda: cases(np.random.default_rng(1))
    return Exercise(name, 1, public, draw, ("a", "b"), wrong, {}, comparison, driver=driver)

def poses(rng):
    return [Case(({int(i): Pose(*rng.normal(size=3)) for i in rng.permutation(40)[:3]}, Motion(rng.normal(), 3.0)))]

def matrices(rng):
    dense = rng.normal(size=(5, 4)) * (rng.uniform(size=(5, 4)) < 0.5)
    return [Case((sparse.csc_array(dense), 2.0)), Case((sparse.coo_matrix(dense), 3.0))]

def seen(rng):
    view = CameraView((64, 48), 1.0, 0.8, 0.5, 0.3)
    marks = [Landmark(float(x), float(y), "corner", "L") for x, y in rng.uniform(1, 3, (4, 2))]
    return [Case((view, marks)), Case((view, []))]

def solvable(rng):
    return [Case((np.eye(3) * rng.uniform(1, 2), rng.normal(size=3)), "a system")]

def roots(rng):
    return [Case((1.0, 2.0, float(rng.uniform(3, 9)))), Case((0.0, 1.0, 1.0), "no square", raises="ValueError")]

def tables(rng):
    table = {"wrap": wrap_angle, "turn": rotation_2d}
    return [Case((table, np.str_(name), float(rng.uniform(4, 9)))) for name in table]

PLAN = LessonPlan([
    exercise("move", Close(period=(0.0, 0.0, 2 * np.pi)), poses),
    exercise("scale", Close(mask="upper"), matrices),
    exercise("see", Each((Unordered(Close(atol=(0.01, 0.1), period=(2 * np.pi, 0.0))), Exact())), seen),
    exercise("step", All((Close(rtol=10.0), Property(solves))), solvable),
    exercise("roots", Unordered(Close()), roots),
    exercise("look_up", Close(), tables),
    exercise("draw", Sampled(), lambda rng: [Case((rng.uniform(0, 9, 30), 5, 60))], "each_seed"),
])
"""
RIGHT = {
    "move": "def move(poses, motion):\n    return {key: pose @ motion.as_pose() for key, pose in poses.items()}",
    "scale": "def scale(matrix, factor):\n    return (factor * matrix).tolil()",
    "see": """
def see(view, marks):
    found = [Measurement(np.arctan2(each.y, each.x) + view.yaw, np.hypot(each.x, each.y)) for each in marks]
    return found[::-1], np.array([[each.x, each.y] for each in marks]).reshape(-1, 2)""",
    "step": "def step(information, b):\n    return np.linalg.solve(information, -b)",
    "roots": """
def roots(a, b, c):
    if a == 0:
        raise ValueError(f"a must not be 0, got {a}")
    root = np.sqrt(complex(b**2 - 4 * a * c))
    return [(-b + root) / (2 * a), (-b - root) / (2 * a)]""",
    "look_up": "def look_up(table, name, value):\n    return table[name](value)",
    "draw": "def draw(values, n, rng):\n    return rng.choice(values, n).mean()",
}
WRONG = {
    "move": "def move(poses, motion):\n    return {str(key): pose for key, pose in poses.items()}",
    "scale": "def scale(matrix, factor):\n    return matrix",
    "see": "def see(view, marks):\n    return [], np.zeros((len(marks), 2))",
    "step": "def step(information, b):\n    return np.linalg.solve(information, b)",
    "roots": "def roots(a, b, c):\n    return [0j, 0j]",
    "look_up": "def look_up(table, name, value):\n    return table[name]",
    "draw": "def draw(values, n, rng):\n    return values.mean()",
}


@register
def solves(args, kwargs, answer):
    """Say where H delta is not -b."""
    information, b = args
    off = float(np.abs(information @ answer + b).max())
    return "" if off < 1e-6 else f"H delta is not -b: it is off by {off:.2g}"


def notebook(functions: dict[str, str] | None = None) -> bytes:
    """The lesson with some functions; the others are right."""
    return chain.as_notebook(LESSON, chain.solutions(SETUP, RIGHT | (functions or {})))


def make_course(root: Path) -> Course:
    """Lay the course out in a folder."""
    return chain.lay_out(root, LESSON, DECLARATION, notebook(), notebook())
