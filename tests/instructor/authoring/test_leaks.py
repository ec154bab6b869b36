"""Code of a solution is found in what students get, wherever it stands and whatever its names are."""

import textwrap

import nbformat
import pytest

from nao_course.instructor.authoring import lesson_text, release
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.leaks import SMALLEST, find_leaks, fingerprints
from tests.paths import PROJECT

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


def secret_pieces():
    """A piece of each kind of secret: lines of a solution, of a mistake or alternative, and of hidden cases."""
    notebook = lesson_text.read_notebook(COURSE.solutions / "01_hsl_filtering.ipynb")
    cell = next(cell for cell in notebook.cells if "def rgb_to_hsl" in cell.source)
    solution = cell.source.split("### BEGIN SOLUTION\n")[1].split("    ### END SOLUTION")[0]
    declared = (COURSE.solutions / "exercises" / "01_hsl_filtering.py").read_text(encoding="utf-8")
    helper = declared[declared.index("def picture(") : declared.index("def primaries(")]
    alternative = declared[declared.index("def _labels_loop(") : declared.index("def _labels_select(")]
    mistakes = {each.name: each for each in COURSE.plan("01_hsl_filtering").exercises[-1].mistakes}
    inserted = mistakes["about the mean direction"].function.inserted
    return {
        "solution": f"def f(picture):\n{solution}",
        "hidden": helper,
        "alternative": alternative,
        "mistake": f"def f(hue, saturation, epsilon):\n{textwrap.indent(inserted, '    ')}",
        "hidden under other names": helper.replace("rng", "r")
        .replace("colours", "c")
        .replace("kinds", "which"),
        "solution under other names": f"def g(p):\n{solution}".replace("picture", "p").replace(
            "spread", "width"
        ),
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


def test_what_is_alike_by_accident_has_no_fingerprint():
    assert SMALLEST > 6
    for common in (
        "height, width = picture.shape[:2]",
        "return np.array(points)",
        "import numpy as np",
        "x = 1",
    ):
        assert list(fingerprints(common)) == []


def test_naming_the_same_earlier_exercises_is_no_leak():
    names = ("predict", "update_landmarks", "add_landmark")
    setup = "\n".join(f'{name} = earlier("07:{name}")' for name in names)
    assert list(fingerprints(setup)) == []
    assert list(fingerprints(setup.replace("earlier", "later")))
