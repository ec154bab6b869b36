"""The beginning of a lesson or an exercise: it builds, and says TODO where work is needed."""

import ast
import re
from collections.abc import Sequence
from importlib import resources
from pathlib import Path

import nbformat
from nbformat import NotebookNode

from nao_course.exercises import lesson_names
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import ABOUT, Course, LessonError

# The exercise that a scaffold declares doubles a number: all its parts are there, and each is to be replaced.
_DECLARATION = '''def _{name}_public() -> list[Case]:
    # TODO: inputs for which every mistake gives a wrong answer; the same at each call
    return [Case((2.0,), "TODO what it is about"), Case((0.0,), "zero"), Case((-1.5,), "a negative number")]


def _{name}_hidden(rng: np.random.Generator) -> list[Case]:
    # TODO: other inputs, drawn from rng
    return [Case((float(value),)) for value in rng.uniform(-10, 10, 6)]


{constant} = Exercise(
    name="{name}",
    points=1,
    public=_{name}_public,
    hidden=_{name}_hidden,
    comparison=Close(),  # TODO: Close, Exact, Points or Between
    hints=("TODO: where to look.", "TODO: nearly how."),
    mistakes=catalogue(  # TODO: how students change the solution by mistake, and what helps them
        """
        not doubled: 2.0 * value => value
            TODO: what comes out is what went in.
        squared: 2.0 * value => value**2
            TODO: doubling is not squaring.
        sign lost: 2.0 * value => abs(2.0 * value)
            TODO: a negative number stays negative.
        """
    ),
    alternatives={{  # TODO: correct solutions of another form
        "a sum": lambda value: value + value,
        "a sum of two": lambda value: sum([value, value]),
        "NumPy": lambda value: np.multiply(value, 2.0),
    }},
    stars={stars},
)


'''
_SOLVED = '''def {name}(value: float) -> float:
    """Return TODO: what it returns.

    value: TODO unit, shape, frame.
    Returns TODO. Example: {name}(2.0) is 4.0.
    """
    ### BEGIN SOLUTION
    return 2.0 * value
    ### END SOLUTION'''
# The class that a scaffold declares is a place on a line that can be moved and asked for.
_CLASS_DECLARATION = '''def _{lower}_public() -> list[Case]:
    # TODO: calls for which every mistake gives a wrong answer; the same at each call
    return [
        calls(("move", 1.5), "estimate", ("move", -4.0), "estimate", given=(2.0,), name="TODO what it is about"),
        calls("estimate", given=(-1.0,), name="never moved"),
    ]


def _{lower}_hidden(rng: np.random.Generator) -> list[Case]:
    # TODO: other calls, drawn from rng
    starts, ways = rng.uniform(-5, 5, 3).tolist(), rng.uniform(-5, 5, (3, 4)).tolist()
    turns = [[turn for way in each for turn in (("move", way), "estimate")] for each in ways]
    return [calls(*each, given=(start,)) for start, each in zip(starts, turns, strict=True)]


class _{name}Adds:  # TODO: correct solutions of another form
    def __init__(self, start: float) -> None:
        self.place = start

    def estimate(self) -> float:
        return self.place

    def move(self, by: float) -> None:
        self.place = sum([self.place, by])


class _{name}Remembers:
    def __init__(self, start: float) -> None:
        self.all = [start]

    def move(self, by: float) -> None:
        self.all.append(by)

    def estimate(self) -> float:
        return sum(self.all)


class _{name}NumPy(_{name}Adds):
    def __init__(self, start: float) -> None:
        self.place = np.float32(start)

    def move(self, by: float) -> None:
        self.place = np.add(self.place, by)


{constant} = Exercise(
    name="{name}",
    points=1,
    public=_{lower}_public,
    hidden=_{lower}_hidden,
    comparison=Methods(),  # TODO: Methods({{"estimate": Close(rtol=0.01)}}) where a method wants another comparison
    driver="methods",
    hints=("TODO: where to look.", "TODO: nearly how."),
    mistakes=catalogue(
        """
        stays: self.place += by => pass
            TODO: it stays where it is.
        backwards: self.place += by => self.place -= by
            TODO: it moves the other way.
        forgets: self.place += by => self.place = by
            TODO: it forgets where it was.
        """
    ),
    alternatives={{"a sum": _{name}Adds, "a list": _{name}Remembers, "NumPy": _{name}NumPy}},
    stars={stars},
)


'''
_CLASS_SOLVED = '''class {name}:
    """TODO: what it is.

    start: TODO unit, frame. estimate() returns TODO.
    Example: after {name}(1.0) and move(2.0), estimate() is 3.0.
    """

    def __init__(self, start: float) -> None:
        """TODO: begin at start."""
        ### BEGIN SOLUTION
        self.place = start
        ### END SOLUTION

    def move(self, by: float) -> None:
        """TODO: move by so much."""
        ### BEGIN SOLUTION
        self.place += by
        ### END SOLUTION

    def estimate(self) -> float:
        """TODO: return where it is."""
        ### BEGIN SOLUTION
        return self.place
        ### END SOLUTION'''
_STARS = {1: "one star", 2: "two stars", 3: "three stars"}
_IMPORTS = {  # what the declaration uses
    "np": "import numpy as np",
    **{name: f"from nao_course.exercises import {name}" for name in ("Case", "Close", "Exercise")},
    "catalogue": "from nao_course.instructor.authoring.mistakes import catalogue",
}
_CLASS_IMPORTS = {name: f"from nao_course.exercises import {name}" for name in ("Methods", "calls")}
_PLAN = '''"""Lesson {number}, {title}: its exercises, students' mistakes, other right ways to write them."""

from __future__ import annotations

import numpy as np

from nao_course.exercises import Case, Close, Exercise, LessonPlan, Question
from nao_course.instructor.authoring.mistakes import catalogue


{declarations}{questions}PLAN = {plan}
'''
_WHY = """WHY = Question(
    name="{name}_why",
    text="TODO: a question about the idea?",
    choices={{
        "TODO: the right choice": "TODO: why it is right.",
        "TODO: a wrong choice": "TODO: why a student might choose it, and why it is wrong.",
        "TODO: another wrong choice": "TODO: another reply.",
    }},
    right="TODO: the right choice",
)

"""
_LIMITS = """LIMITS = Question(
    name="{name}_limits",
    text="TODO: what happens if an assumption does not hold?",
    choices={{
        "TODO: a wrong choice": "TODO: why a student might choose it, and why it is wrong.",
        "TODO: the right choice": "TODO: why it is right, and how one notices.",
        "TODO: another wrong choice": "TODO: another reply.",
    }},
    right="TODO: the right choice",
)

"""
# The rules that a lesson of one function and one question does not keep: docs/write_a_lesson.md
_WAIVED = 'dict.fromkeys(["2", "3", "5", "11", "12"], "a short lesson")'
_TEST = '''"""The equations of lesson {number}, each held against the solution that the lesson builds on it."""

import numpy as np
import pytest

from nao_course.exercises import load_definitions
from tests.paths import SOLUTIONS


@pytest.fixture(scope="module")
def solution():
    return load_definitions(SOLUTIONS / "{stem}.ipynb")


@pytest.mark.asserts("eq-{n}-1")
def test_twice_a_number_is_the_number_and_itself(solution, rng):
    # TODO: the law that equation {n}.1 states
    for value in rng.uniform(-10, 10, 20):
        assert np.isclose(solution["{first}"](value), value + value)
'''
_ABOUT = """
["{number}"]
does = "TODO: what a student does, for the README"
can = "TODO: what a student can do afterwards"
left_out = "TODO: what happens without the lesson"
"""
_CARD = """card = [0.0, 0.0, 1.0, 1.0]  # TODO: a part of the opening figure: left, top, right, bottom
card_shows = "TODO: what is seen there, for who cannot see it"
"""
LINE_LENGTH = 110  # of the formatter, as in pyproject.toml
# The panel of a new lesson, and what its set-up imports for it.
PANEL_IMPORT = "from nao_course.widgets import FunctionPanel, Slider"
PANEL = """\
def show(values, student):
    \"\"\"Yield TODO: what the control changes in the answer.\"\"\"
    yield f"TODO: the answer to {{values.value:g}} is {{student.{first}(values.value):g}}"


controls = [Slider("value", "Value", 0, 10, 1, 3)]
functions = {{"{first}": {first}}}
FunctionPanel("TODO: what it shows", show, controls, student=functions)"""
TEXT = "scaffold.md"  # beside this module: the text of a new lesson
SHORT_TEXT = "scaffold.short.md"  # the text of a new lesson of one function and one question


def add_lesson(course: Course, number: str, name: str, *, short: bool = False) -> list[Path]:
    """Begin a lesson with two digits that no lesson has, and a name of lower-case words with underscores.

    A short lesson has one function, one question and no figure, and waives the rules that this breaks. Return the text,
    the declaration, the test of its equations, and the file of what the course says about lessons, which gets a part.
    Raise a LessonError if number or name cannot be used.
    """
    if not re.fullmatch(r"\d\d", number) or not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise LessonError(
            f"a lesson is two digits and a name such as 'ekf_derivations', got {number!r} {name!r}"
        )
    taken = lesson_names.meant(number, course.names())
    if taken:
        raise LessonError(f"lesson {number} is there already: {taken[0]}")
    words = _words(number, name, short)
    stem = words["stem"]
    text = (resources.files(__package__) / (SHORT_TEXT if short else TEXT)).read_text(encoding="utf-8")
    about = course.solutions / ABOUT
    said = about.read_text(encoding="utf-8") if about.is_file() else ""
    made = {
        course.text(stem): lesson_text.HEADER + text.format_map(words),
        course.declaration(stem): _PLAN.format_map(words),
        course.root / "tests" / "lessons" / f"test_{stem}.py": _TEST.format_map(words),
        about: said + (_ABOUT + _CARD * (not short)).format_map(words),
    }
    for path, content in made.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    return list(made)


def _words(number: str, name: str, short: bool) -> dict[str, str]:
    """Return the replacements for placeholders in the texts of a new lesson."""
    exercises = {each: f"{name}_{each}" for each in ("first", "second", "third")[: 1 if short else 3]}
    declared = [_DECLARATION.format(name=each, constant=each.upper(), stars=1) for each in exercises.values()]
    return {
        "number": number,
        "n": str(int(number)),
        "name": name,
        "stem": f"{number}_{name}",
        "title": name.replace("_", " ").capitalize(),
        "questions": (_WHY + _LIMITS * (not short)).format(name=name),
        "panel": PANEL.format_map(exercises),
        "panel_import": PANEL_IMPORT,
        "declarations": "".join(declared),
        "plan": _plan([each.upper() for each in exercises.values()], short),
        **exercises,
        **{f"{each}_solved": _SOLVED.format(name=exercise) for each, exercise in exercises.items()},
    }


def _plan(constants: Sequence[str], short: bool) -> str:
    """Return the plan's call in as many lines as the formatter would give it."""
    if short:
        return f"LessonPlan(\n    exercises=[{constants[0]}],\n    questions=[WHY],\n    waived={_WAIVED},\n)"
    exercises, questions = ", ".join(constants), "questions=[WHY, LIMITS]"
    inside = f"exercises=[{exercises}], {questions}"
    if len(f"PLAN = LessonPlan({inside})") <= LINE_LENGTH:
        return f"LessonPlan({inside})"
    if len(inside) + 4 <= LINE_LENGTH:
        return f"LessonPlan(\n    {inside}\n)"
    if len(exercises) + 17 > LINE_LENGTH:
        exercises = "".join(f"\n        {each}," for each in constants) + "\n    "
    return f"LessonPlan(\n    exercises=[{exercises}],\n    {questions},\n)"


def add_exercise(course: Course, lesson: str, name: str, *, a_class: bool = False) -> list[Path]:
    """Add an exercise to a lesson: its declaration as the last, and its cells behind the last check.

    The name, of a function or class, is unique in the course. Return the two files that changed. Raise a LessonError if
    the name cannot be used, or the declaration has no list to add it to.
    """
    (stem,) = course.names([lesson])
    if a_class and not re.fullmatch(r"[A-Z][A-Za-z0-9]*", name):
        raise LessonError(f"a class is named like 'EkfSlam', got {name!r}")
    if not a_class and (not name.isidentifier() or name != name.lower()):
        raise LessonError(
            f"an exercise is named like a function, such as 'hue_mask', got {name!r}; for a class say --class"
        )
    for other in course.names():
        if name in {each.name for each in course.plan(other).exercises}:
            raise LessonError(
                f"lesson {other} has an exercise {name} already; names are unique in the course"
            )
    text, plan = course.text(stem), course.declaration(stem)
    exercises = course.plan(stem).exercises
    stars = exercises[-1].stars if exercises else 1  # difficulty never falls
    declared = _with_declaration(plan, name, stars, a_class)
    notebook = lesson_text.read_lesson(text)
    number = len(exercises) + 1
    checks = lesson_text.code_cells(notebook, "check") or lesson_text.code_cells(notebook, "setup")
    place = checks[-1][0] + 1
    notebook.cells[place:place] = _cells(
        f"{int(lesson_names.number_of(stem))}.{number}", name, stars, a_class
    )
    text.write_text(lesson_text.write_lesson(notebook), encoding="utf-8")
    plan.write_text(declared, encoding="utf-8")
    return [text, plan]


def _cells(number: str, name: str, stars: int, a_class: bool) -> list[NotebookNode]:
    solved = (_CLASS_SOLVED if a_class else _SOLVED).format(name=name)
    title = f"### Exercise {number} ({_STARS[stars]})\n\nTODO: what `{name}` is for, and a worked example."
    return [
        nbformat.v4.new_markdown_cell(title),
        nbformat.v4.new_code_cell(solved, metadata={"exercise": name}),
        nbformat.v4.new_code_cell(f'check("{name}", {name})', metadata={"check": name}),
    ]


def _with_declaration(plan: Path, name: str, stars: int, a_class: bool) -> str:
    """Write a new exercise before PLAN, its name at the end of PLAN's list, and what it imports."""
    source = plan.read_text(encoding="utf-8")
    tree = ast.parse(source)
    for statement in tree.body:
        if isinstance(statement, ast.Assign) and ast.unparse(statement.targets[0]) == "PLAN":
            break
    else:
        raise LessonError(f"{plan.name}: it gives nothing the name PLAN")
    lists = [
        keyword.value
        for keyword in getattr(statement.value, "keywords", ())
        if keyword.arg == "exercises" and isinstance(keyword.value, ast.List)
    ]
    if not lists:
        raise LessonError(
            f"{plan.name}: PLAN = LessonPlan(exercises=[...]) is missing, so {name} cannot be added to its list"
        )
    constant = name.upper()
    entries = lists[0].elts
    lines = source.splitlines(keepends=True)
    if entries:
        row, column = entries[-1].end_lineno, entries[-1].end_col_offset
        added = f", {constant}"
    else:
        row, column = lists[0].lineno, lists[0].col_offset + 1
        added = constant
    assert row is not None and column is not None  # ast.parse knows where everything ends
    line = lines[row - 1].encode()  # ast counts bytes
    lines[row - 1] = (line[:column] + added.encode() + line[column:]).decode()
    declaration = _CLASS_DECLARATION if a_class else _DECLARATION
    words = {"name": name, "lower": name.lower(), "constant": constant, "stars": stars}
    lines.insert(statement.lineno - 1, declaration.format_map(words))
    imports = [each for each in tree.body if isinstance(each, ast.Import | ast.ImportFrom)]
    there = {alias.asname or alias.name for each in imports for alias in each.names}
    wanted = _IMPORTS | (_CLASS_IMPORTS if a_class else {})
    missing = [f"{line}\n" for imported, line in wanted.items() if imported not in there]
    lines.insert((imports[-1].end_lineno or 0) if imports else 0, "".join(missing))
    return "".join(lines)
