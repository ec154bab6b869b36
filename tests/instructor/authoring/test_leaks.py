"""Code of a solution is found in what students get, wherever it stands and whatever its names are."""

import textwrap

import nbformat
import pytest

from nao_course.instructor.authoring import lesson_text, release
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.leaks import SMALLEST, WAY_OUT, find_leaks, fingerprints
from tests.paths import PROJECT

pytestmark = pytest.mark.slow

COURSE = load_course(PROJECT)
NOTEBOOK = "release/notebooks/01_hsl_filtering.ipynb"


def notebook_with(source, kind="code"):
    """The student copy of a lesson with one cell more, as a release holds it."""
    notebook = nbformat.read(PROJECT / "notebooks" / "01_hsl_filtering.ipynb", as_version=4)
    made = {"code": nbformat.v4.new_code_cell, "markdown": nbformat.v4.new_markdown_cell}[kind](source)
    notebook.cells.insert(5, made)
    return {NOTEBOOK: nbformat.writes(notebook).encode()}


@pytest.fixture(scope="module")
def secrets():
    return release.secrets(COURSE)


def test_what_is_public_today_is_no_leak(secrets):
    assert find_leaks(notebook_with("x = 1"), secrets) == []


def test_what_is_alike_by_accident_or_names_the_same_earlier_exercises_has_no_fingerprint():
    assert SMALLEST > 6
    alike = ("height, width = picture.shape[:2]", "return np.array(points)", "import numpy as np", "x = 1")
    names = ("predict", "update_landmarks", "add_landmark")
    setup = "\n".join(f'{name} = earlier("07:{name}")' for name in names)
    assert [common for common in (*alike, setup) if list(fingerprints(common))] == []
    assert list(fingerprints(setup.replace("earlier", "later")))


def secret_pieces():
    """A piece of each kind of secret: lines of a solution, of a mistake or alternative, and of hidden cases."""
    notebook = lesson_text.read_notebook(COURSE.solutions / "01_hsl_filtering.ipynb")
    cell = next(cell for cell in notebook.cells if "def rgb_to_hsl" in cell.source)
    solution = cell.source.split("### BEGIN SOLUTION\n")[1].split("    ### END SOLUTION")[0]
    declared = (COURSE.solutions / "exercises" / "01_hsl_filtering.py").read_text(encoding="utf-8")
    helper = declared[declared.index("def picture(") : declared.index("def primaries(")]
    alternative = declared[declared.index("def _labels_loop(") : declared.index("def _labels_select(")]
    mistakes = {each.name: each for each in COURSE.plan("01_hsl_filtering").exercises[-1].mistakes}
    inserted = textwrap.indent(mistakes["about the mean direction"].function.inserted, "    ")
    renamed = f"def g(p):\n{solution}".replace("picture", "p").replace("spread", "width")
    return {
        "solution": f"def f(picture):\n{solution}",
        "hidden": helper,
        "alternative": alternative,
        "mistake": f"def f(hue, saturation, epsilon):\n{inserted}",
        "hidden under other names": helper.replace("rng", "r").replace("colours", "c").replace("kinds", "of"),
        "solution under other names": renamed,
        "solution with comments": f'def f(picture):\n    "Mine."\n    # well\n{solution}',
    }


@pytest.mark.parametrize("piece", secret_pieces())
@pytest.mark.parametrize("where", ["module", "cell", "fence", "string"])
def test_a_planted_secret_is_found_wherever_it_stands(secrets, piece, where):
    source = secret_pieces()[piece]
    planted = {
        "module": {"nao_course/sim/extra.py": f"import numpy as np\n\n\n{source}".encode()},
        "cell": notebook_with(f"%matplotlib inline\n{source}"),
        "string": notebook_with(f"exec({source!r})"),
        "fence": notebook_with(f"Look:\n\n```python\n{source}\n```\n", "markdown"),
    }[where]
    problems = [str(leak) for leak in find_leaks(planted, secrets)]
    place = "extra.py" if where == "module" else "cell 6"
    assert problems and all(place in problem for problem in problems)


# Code that the library of the toy course holds in a module and in a string
HELD = [
    "total = np.sqrt(value**2 + 1.0) + 3.0 * value",
    "total = np.hypot(value, 4.0) - 5.0 * value + value**4",
]


@pytest.fixture
def toy_library(course):
    """Return a course whose mistakes have two lines that its library held already and one line of their own."""
    (course.root / "nao_course").mkdir(exist_ok=True)
    library = f"def old(value):\n    {HELD[0]}\n    return total\n\n\nEXAMPLE = {HELD[1]!r}\n"
    (course.root / "nao_course" / "old.py").write_text(library)
    own = "total = np.exp(value * 2.0) - 7.0 * value + value**3"
    lines = enumerate([*HELD, own])
    changes = "".join(f"        line {i}: + {line}\n            It is wrong.\n" for i, line in lines)
    plan = course.declaration("01_toy")
    text = plan.read_text().replace("mistakes=[", f'mistakes=[\n    *catalogue("""\n{changes}    """),', 1)
    plan.write_text(f"from nao_course.instructor.authoring.mistakes import catalogue\n{text}")
    return course, library, own


def test_a_mistakes_line_that_the_library_held_already_is_no_leak(toy_library):
    course, library, own = toy_library
    files = {"nao_course/old.py": library.encode(), "nao_course/new.py": own.encode()}
    leaks = find_leaks(files, release.secrets(course))
    assert [leak.where for leak in leaks] == ["nao_course/new.py, line 1"]


def test_a_refusal_names_the_exercise_and_what_to_do(toy_library):
    course, _, own = toy_library
    plan = course.declaration("01_toy")
    helper = "def _start(value):\n    return np.log(value * 2.0) - 7.0 * value + value**5\n\n\n"
    text = plan.read_text().replace("DOUBLE = Exercise(", f"{helper}DOUBLE = Exercise(")
    plan.write_text(text.replace("rng.uniform(-10, 10, 6)", "map(_start, (1.0, 2.0))"))
    line = 1 + plan.read_text().split("return np.log")[0].count("\n")
    files = {"a.py": own.encode(), "b.py": b"start = np.log(value * 2.0) - 7.0 * value + value**5"}
    said = [str(leak) for leak in find_leaks(files, release.secrets(course))]
    assert said == [
        f"a.py, line 1 holds code of 01_toy.py, double: mistake 'line 2'; {WAY_OUT}",
        f"b.py, line 1 holds code of 01_toy.py, double: line {line}; {WAY_OUT}",
    ]


def test_a_solution_or_a_todo_that_was_left_in_is_found(monkeypatch):
    monkeypatch.setattr(release, "secrets", lambda course: {})
    left = release.release_problems(COURSE, notebook_with("### BEGIN SOLUTION\n### END SOLUTION"))
    assert [problem.split("says ")[1] for problem in left] == ["### BEGIN SOLUTION", "### END SOLUTION"]
    assert "TODO" in release.release_problems(COURSE, notebook_with("TODO", "markdown"))[0]


def test_a_fingerprint_sees_through_names_docstrings_wrapping_and_the_way_numbers_are_written():
    first = 'def f(a, b):\n    """One."""\n    c = a * 2 + np.sqrt(b ** 2 + 1)\n    return c'
    second = "def g(x, y):\n    return x * 2.0 + np.sqrt(y**2 + 1.0)  # two"
    third = "h = lambda u, v: u * 2 + np.sqrt(v ** 2 + 1)"
    marks = [{mark for mark, _ in fingerprints(source)} for source in (first, second, third)]
    assert marks[0] & marks[1] & marks[2]
    other = "def g(x, y):\n    return x * 2.0 + np.sqrt(x**2 + 1.0)"
    assert not marks[0] & {mark for mark, _ in fingerprints(other)}
