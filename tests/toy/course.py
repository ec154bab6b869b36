"""A course in a folder of its own, as an author has it: one small lesson, or the first ones of the real course."""

import json
import shutil
from pathlib import Path

from click.testing import Result
from typer.testing import CliRunner

from nao_course import cli
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import Course, load_course
from tests.paths import PROJECT

TEXT = """
# A toy

```{code-cell} ipython3
:role: setup

from nao_course.exercises import lesson

check, hint = lesson("01_toy")
```

+++ {"slideshow": {"slide_type": "slide"}}

Words with $x^2$ and `code`.

```{code-cell} ipython3
:exercise: double

def double(value: float) -> float:
    \"\"\"Double a number. Example: double(2.0) is 4.0.\"\"\"
    ### BEGIN SOLUTION
    return 2.0 * value
    ### END SOLUTION
```

```{code-cell} ipython3
:check: double

check("double", double)
```

```{raw-cell}
:format: html

<b>raw</b>
```

```{code-cell} ipython3
:role: display
:tags: [wide]

print("shown")
```
"""
PLAN = """from nao_course.exercises import Case, Exercise, LessonPlan, Mistake

DOUBLE = Exercise(
    name="double",
    points=1,
    public=lambda: [Case((2.0,)), Case((0.0,)), Case((-1.5,))],
    hidden=lambda rng: [Case((float(value),)) for value in rng.uniform(-10, 10, 6)],
    hints=("Look.", "Nearly."),
    mistakes=[
        Mistake("not doubled", lambda value: value, "It is what went in."),
        Mistake("squared", lambda value: value**2, "Doubling is not squaring."),
        Mistake("sign lost", lambda value: abs(2 * value), "A negative number stays negative."),
    ],
    alternatives={
        "a sum": lambda value: value + value,
        "sum": lambda value: sum([value, value]),
        "a shift": lambda value: value - -value,
    },
)
PLAN = LessonPlan(exercises=[DOUBLE])
"""


def lay_out(root: Path) -> Path:
    """Write the course, with a library of its own without the real lessons' folders; nothing of it is built."""
    lessons = (path.name for path in (PROJECT / "nao_course" / "lessons").glob("*/"))
    ignored = shutil.ignore_patterns("*.bin", "__pycache__", *lessons)
    shutil.copytree(PROJECT / "nao_course", root / "nao_course", ignore=ignored)
    (root / "solutions" / "exercises").mkdir(parents=True)
    (root / "solutions" / "01_toy.md").write_text(lesson_text.HEADER + TEXT)
    (root / "solutions" / "exercises" / "01_toy.py").write_text(PLAN)
    (root / "course.toml").write_text('title = "Toy"\nversion = "1"\n[points]\n')
    return root


def lay_out_first_lessons(root: Path) -> list[str]:
    """Copy the real course with its lessons 00 and 01, as they are built, and name them: to build all takes minutes.

    The later lessons' modules are left out, too: the committed proof of lesson 01 does not rest on them. Of course.toml
    only what the notebooks are built with is copied, because other settings may name the later lessons.
    """
    names = sorted(path.stem for path in (PROJECT / "solutions").glob("*.ipynb"))
    later = [f"{name[:2]}_*.*" for name in names[2:]]
    packages = [part for name in names[2:] for part in (name.partition("_")[2], f"{name}.bin")]
    for folder, left_out in (("solutions", later), ("notebooks", later), ("nao_course", packages)):
        ignored = shutil.ignore_patterns("__pycache__", *left_out)
        shutil.copytree(PROJECT / folder, root / folder, ignore=ignored)
    course = load_course(PROJECT)
    declared = {each for name in names[:2] for each in course.plan(name).points}
    points = [f"{name} = {course.points[name]}\n" for name in sorted(course.points.keys() & declared)]
    (root / "course.toml").write_text(
        f"title = {json.dumps(course.title)}\nversion = {json.dumps(course.version)}\n[points]\n{''.join(points)}"
    )
    return names[:2]


def run(*words: str) -> Result:
    """Run a command in the working folder."""
    return CliRunner().invoke(cli.app, list(words))


def contents(root: Path) -> dict[Path, bytes]:
    """All files of a folder but the proofs that are kept there."""
    return {
        path: path.read_bytes()
        for path in sorted(root.rglob("*"))
        if path.is_file() and not {"__pycache__", "proofs"} & set(path.parts)
    }


def write(path: Path, old: str, new: str) -> None:
    """Put one text in another one's place, which has to be there."""
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def with_a_written_question(course: Course) -> None:
    """Add a question that a person marks."""
    question = '+++ {"written": "say_why"}\n\nBecause two times one is two.\n\n'
    write(course.text("01_toy"), "```{raw-cell}", question + "```{raw-cell}")
    plan = course.solutions / "exercises" / "01_toy.py"
    write(plan, "import Case, Exercise,", "import Written, Case, Exercise,")
    written = 'Written("say_why", 2, "Why is it two?", "one point for each two")'
    write(plan, "LessonPlan(exercises=[DOUBLE])", f"LessonPlan([DOUBLE], written=[{written}])")
