"""A course of two small lessons: the second uses a function and a class of the first, and has a class of its own."""

import re
from pathlib import Path

from nao_course.instructor.authoring.course import Course, load_course
from tests.toy import chain, toy

FIRST, SECOND = "80_first", "81_second"
SECRET = b"a secret of sixteen bytes, or more"
_HEAD = """
from nao_course.exercises import Case, Close, Exercise, LessonPlan, Methods, Mistake, calls

def exercise(name, points, public, hidden, **more):
    wrong = [Mistake("slip", more.pop("slip", lambda *_: 0.0), f"That is the slip in {name}.")]
    return Exercise(name, points, lambda: public, hidden, ("a", "b"), wrong, {}, **more)

def numbers(rng):
    return [Case((float(each),)) for each in rng.uniform(10, 1000, 3)]
"""
DECLARATIONS = {
    FIRST: _HEAD
    + """
class Nothing:
    def add(self, value): pass
    def total(self): return 0.0

def totals(rng):
    return [calls(("add", float(rng.normal())), "total") for _ in range(2)]

PLAN = LessonPlan([
    exercise("double", 1, [Case((1.5,)), Case((4.0,))], numbers),
    exercise("Counter", 1, [calls(("add", 1.5), ("add", 2.0), "total")], totals, slip=Nothing, driver="methods",
             comparison=Methods(), uses=("double",)),
])
""",
    SECOND: _HEAD
    + """
class Stays:
    def __init__(self, start): self.at = start
    def move(self, by): pass
    def estimate(self): return self.at

def walks(rng):
    return [calls(("move", float(rng.uniform(1, 9))), "estimate", given=(float(rng.normal()),)) for _ in range(2)]

PLAN = LessonPlan([
    exercise("quadruple", 1, [Case((1.5,)), Case((-3.0,))], numbers, uses=("80:double",)),
    exercise("Walker", 2, [calls(("move", 1.5), "estimate", given=(2.0,))], walks, slip=Stays, driver="methods",
             comparison=Methods({"estimate": Close()}), uses=("quadruple",)),
    exercise("walk", 4, [Case((2.0,))], numbers, uses=("Walker", "quadruple"), with_reference=0.5),
    exercise("tally", 8, [Case((2.0,))], numbers, uses=("80:Counter",)),
    exercise("alone", 16, [Case((2.0,))], numbers),
])
""",
}
SETUP = {
    FIRST: "import numpy as np",
    SECOND: "import numpy as np\nfrom nao_course.student import earlier\n\n"
    'double = earlier("80:double")\nCounter = earlier("80:Counter")',
}
RIGHT = {
    FIRST: {
        "double": "def double(x):\n    return 2 * x",
        "Counter": "class Counter:\n    def __init__(self):\n        self.sum = 0.0\n"
        "    def add(self, value):\n        self.sum += double(value)\n"
        "    def total(self):\n        return self.sum / 2",
    },
    SECOND: {
        "quadruple": "def quadruple(x):\n    return double(double(x))",
        "Walker": "class Walker:\n    def __init__(self, start):\n        self.at = start\n"
        "    def move(self, by):\n        self.at += quadruple(by) / 4\n"
        "    def estimate(self):\n        return self.at",
        "walk": "def walk(x):\n    walker = Walker(x)\n    walker.move(1.0)\n"
        "    return walker.estimate() + quadruple(x)",
        "tally": "def tally(x):\n    counter = Counter()\n    counter.add(x)\n    counter.add(1.0)\n"
        "    return counter.total()",
        "alone": "def alone(x):\n    return x + 1",
    },
}
_BODY = re.compile(r"^( +)(?!def|\s).*", re.M)
BLANK = {
    lesson: {name: _BODY.sub(r"\1raise NotImplementedError", source) for name, source in functions.items()}
    for lesson, functions in RIGHT.items()
}
POINTS = {"quadruple": 1, "Walker": 2, "walk": 4, "tally": 8, "alone": 16}


def write(path: Path, lesson: str, functions: dict[str, str] | None = None, before: str = "") -> Path:
    """Write a lesson's notebook with some functions; the others are right."""
    cells = [("setup", SETUP[lesson]), ("student", before or "# nothing")]
    cells += [("solution", source) for source in (RIGHT[lesson] | (functions or {})).values()]
    path.parent.mkdir(parents=True, exist_ok=True)
    return toy.write(path, *cells)


def make_course(root: Path) -> Course:
    """Lay the course out in a folder, ready to be graded."""
    (root / "solutions" / "exercises").mkdir(parents=True)
    (root / "course.toml").write_text('title = "Pair"\nversion = "1"\n')
    for lesson in (FIRST, SECOND):
        (root / "solutions" / f"{lesson}.md").write_text(f"# {lesson}\n")
        (root / "solutions" / "exercises" / f"{lesson}.py").write_text(DECLARATIONS[lesson])
        write(root / "solutions" / f"{lesson}.ipynb", lesson)
        write(root / "notebooks" / f"{lesson}.ipynb", lesson, BLANK[lesson])
    course = load_course(root)
    for lesson in (FIRST, SECOND):
        chain.stamp(course, lesson)
    return course
