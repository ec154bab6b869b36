"""Two small lessons with all that later lessons need: classes, earlier functions, matrices."""

import re
import shutil
from pathlib import Path

from nao_course.instructor.authoring import lesson_text, release
from tests.paths import PROJECT

COLOURS, SMALL = "01_colours", "04_small"


def _cell(option: str, source: str) -> str:
    return f"```{{code-cell}} ipython3\n:{option}\n\n{source.strip()}\n```\n"


def _text(title: str, setup: str, *sources: str) -> str:
    """Return a lesson's text: its set-up cell, and the cells of each exercise and of its check."""
    parts = [f"\n# {title}\n", _cell("role: setup", setup)]
    for source in sources:
        name = re.findall(r"(?:def|class) (\w+)", source)[0]
        parts += [_cell(f"exercise: {name}", source), _cell(f"check: {name}", f'check("{name}", {name})')]
    return "\n".join(parts)


COLOURS_TEXT = _text(
    "Colours",
    """
import numpy as np

from nao_course.exercises import lesson

check, hint = lesson("01_colours")
""",
    '''
def color_labels(picture: np.ndarray) -> np.ndarray:
    """Label 1 where green is the largest channel, else 0."""
    ### BEGIN SOLUTION
    return (np.argmax(picture, axis=2) == 1).astype(np.uint8)
    ### END SOLUTION
''',
)

COLOURS_PLAN = """
import numpy as np
from nao_course.exercises import Case, Exact, Exercise, LessonPlan, Mistake


def _pictures(rng, many):
    return [Case((rng.integers(0, 256, (6, 8, 3)).astype(np.uint8),)) for _ in range(many)]


PLAN = LessonPlan([Exercise(
    "color_labels", 1, lambda: _pictures(np.random.default_rng(0), 2), lambda rng: _pictures(rng, 3),
    ("Which channel is the largest?", "np.argmax with axis=2."),
    [Mistake("red", lambda p: (np.argmax(p, axis=2) == 0).astype(np.uint8), "Channel 0 is red.")],
    {"a wider type": lambda p: (np.argmax(p, axis=2) == 1).astype(np.int64)}, Exact(),
)], waived={"8": "a lesson of the tests"})
"""

SMALL_TEXT = _text(
    "Distance, small",
    """
import numpy as np

from nao_course.exercises import lesson
from nao_course.geometry import Pose
from nao_course.slam import Motion
from nao_course.student import earlier

check, hint = lesson("04_small")
color_labels = earlier("01:color_labels")
""",
    '''
def green_by_row(picture: np.ndarray) -> dict[int, int]:
    """How many green pixels each row has that has any, by the row's number."""
    ### BEGIN SOLUTION
    counts = (color_labels(picture) == 1).sum(axis=1)
    return {int(row): int(counts[row]) for row in np.flatnonzero(counts)}
    ### END SOLUTION
''',
    '''
class Odometer:
    """Adds up motions from a pose, and remembers what it sees."""

    def __init__(self, start: Pose) -> None:
        ### BEGIN SOLUTION
        self.pose_now, self.seen = start, []
        ### END SOLUTION

    def move(self, motion: Motion) -> None:
        """Take in a motion."""
        ### BEGIN SOLUTION
        self.pose_now = self.pose_now @ motion.as_pose()
        ### END SOLUTION

    def pose(self) -> Pose:
        """Where it is now."""
        ### BEGIN SOLUTION
        return self.pose_now
        ### END SOLUTION
''',
    '''
def length_of_way(motions: list[Motion]) -> float:
    """Length in metres of the way that an Odometer from zero makes, from its poses."""
    ### BEGIN SOLUTION
    odometer, length = Odometer(Pose()), 0.0
    for motion in motions:
        before = odometer.pose()
        odometer.move(motion)
        after = odometer.pose()
        length += float(np.hypot(after.x - before.x, after.y - before.y))
    return length
    ### END SOLUTION
''',
    '''
def smoothing(size: int) -> np.ndarray:
    """Covariance (size, size) with entries exp(-|i - j| / 5)."""
    ### BEGIN SOLUTION
    i = np.arange(size)
    return np.exp(-np.abs(i[:, None] - i[None]) / 5)
    ### END SOLUTION
''',
)
LAWS = '''"""What a small lesson's own answers have to be."""

import numpy as np

from nao_course.exercises import register


@register
def is_covariance(args, kwargs, answer):
    """Say why a matrix is no covariance; nothing where it is one."""
    if not np.allclose(answer, answer.T):
        return "your matrix is not symmetric"
    return "" if np.linalg.eigvalsh(answer).min() > -1e-9 else "your matrix has a negative eigenvalue"
'''

SMALL_PLAN = """
from dataclasses import replace

import numpy as np
from nao_course.exercises import All, Case, Close, Exact, Exercise, LessonPlan, Methods, Mistake, Property, calls
from nao_course.geometry import Pose
from nao_course.lessons.small.laws import is_covariance
from nao_course.slam import Motion
from nao_course.student import earlier

color_labels = earlier("01:color_labels")


def _exercise(name, public, hidden, slips, alternatives, **more):
    mistakes = [Mistake(title, function, f"That is {title}.") for title, function in slips.items()]
    hints = ("Where to look.", "Nearly how.")
    return Exercise(name, 1, public, hidden, hints, mistakes, alternatives, **more)


def _pictures(rng, many):
    return [Case((rng.integers(0, 256, (5, 8, 3)).astype(np.uint8),)) for _ in range(many)]


def _counted(picture, value=1):
    counts = (color_labels(picture) == value).sum(axis=1)
    return {row: int(count) for row, count in enumerate(counts) if count}


GREEN_BY_ROW = _exercise(
    "green_by_row",
    lambda: [*_pictures(np.random.default_rng(1), 2), Case((np.zeros((3, 2, 3), np.uint8),), "all black")],
    lambda rng: [*_pictures(rng, 3), Case((np.zeros((2, 2, 3), np.uint8),))],
    {"what is not green": lambda picture: _counted(picture, 0)},
    {"backwards": lambda picture: {np.int64(k): np.int32(v) for k, v in reversed(_counted(picture).items())}},
    comparison=Exact(),
    uses=("01:color_labels",),
)


class Added:
    def __init__(self, start):
        self.x, self.y, self.theta = start.as_array()

    def move(self, motion):
        self.x += motion.distance * np.cos(self.theta)
        self.y += motion.distance * np.sin(self.theta)
        self.theta += motion.turn

    def pose(self):
        return Pose(self.x, self.y, self.theta)


class TurnsFirst(Added):
    def move(self, motion):
        self.theta += motion.turn
        super().move(replace(motion, turn=0.0))


class Late(Added):
    def __init__(self, start):
        self.start, self.motions = start, []

    def move(self, motion):
        self.motions.append(motion)

    def pose(self):
        super().__init__(self.start)
        for motion in self.motions:
            super().move(motion)
        return super().pose()


def _walk(rng):
    turns = [("move", Motion(*rng.normal(0, 1, 2))) for _ in range(4)]
    return calls("pose", *turns[:2], "pose", *turns[2:], "pose", given=(Pose(*rng.normal(0, 2, 3)),))


ODOMETER = _exercise(
    "Odometer",
    lambda: [
        calls(("move", Motion(1.0, 0.5)), "pose", ("move", Motion(2.0, 0.0)), "pose",
              given=(Pose(1.0, 2.0, 0.3),), name="two steps"),
    ],
    lambda rng: [_walk(rng) for _ in range(3)],
    {"turning first": TurnsFirst},
    {"late": Late},
    driver="methods",
    comparison=Methods({"pose": Close(atol=1e-6, period=(0.0, 0.0, 2 * np.pi))}),
)
LENGTH_OF_WAY = _exercise(
    "length_of_way",
    lambda: [Case(([Motion(1.0, 0.5), Motion(-2.0, 0.0)],), "there and back"), Case(([],), "nowhere")],
    lambda rng: [Case(([Motion(*rng.normal(0, 1, 2)) for _ in range(5)],)) for _ in range(3)] + [Case(([],))],
    {"with its sign": lambda motions: float(sum(each.distance for each in motions))},
    {"NumPy": lambda motions: np.abs([each.distance for each in motions]).sum()},
    uses=("Odometer",),
)


def _exponential(size, scale=5.0):
    i = np.arange(size)
    return np.exp(-np.abs(i[:, None] - i[None]) / scale)


SMOOTHING = _exercise(
    "smoothing",
    lambda: [Case((60,), "sixty"), Case((1,), "one")],
    lambda rng: [Case((int(size),)) for size in rng.integers(2, 80, 3)],
    {"another scale": lambda size: _exponential(size, 4.0)},
    {"a list": lambda size: _exponential(size).tolist()},
    comparison=All((Close(mask="upper"), Property(is_covariance))),
)
PLAN = LessonPlan([GREEN_BY_ROW, ODOMETER, LENGTH_OF_WAY, SMOOTHING], waived={"8": "a lesson of the tests"})
"""


def lay_out(root: Path) -> Path:
    """Write the course, with a library of its own in which the second lesson has a folder; nothing of it is built."""
    ignored = shutil.ignore_patterns("*.bin", "__pycache__")
    shutil.copytree(PROJECT / "nao_course", root / "nao_course", ignore=ignored)
    own = root / "nao_course" / "lessons" / "small"
    own.mkdir()
    (own / "__init__.py").write_text('"""A small lesson."""\n')
    (own / "laws.py").write_text(LAWS)
    (root / "solutions" / "exercises").mkdir(parents=True)
    for name, text, plan in ((COLOURS, COLOURS_TEXT, COLOURS_PLAN), (SMALL, SMALL_TEXT, SMALL_PLAN)):
        (root / "solutions" / f"{name}.md").write_text(lesson_text.HEADER + text)
        (root / "solutions" / "exercises" / f"{name}.py").write_text(plan)
    (root / "course.toml").write_text('title = "Small"\nversion = "1"\n')
    for name in (*release.AS_THEY_ARE, *release.PAGES.values()):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(PROJECT / name, root / name)
    return root
