"""A new lesson and a new exercise build at once, and cannot be released unfinished."""

import inspect
import re
import shutil
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from nao_course.exercises.checking import unpack
from nao_course.instructor.authoring import release
from nao_course.instructor.authoring.mutation import mutate
from nao_course.instructor.authoring.scaffold import add_lesson
from tests.lessons import every, test_built, test_exercises, test_lessons
from tests.paths import PROJECT
from tests.toy.course import contents, run, write
from website import lessons


@pytest.mark.slow
def test_a_new_lesson_and_a_new_exercise_build_and_cannot_be_released_unfinished(built):
    assert run("new", "lesson", "07", "ekf_slam").exit_code == 0
    for name in ("predict_it", "update_it"):
        result = run("new", "exercise", "07", name)
        assert result.exit_code == 0, result.output
    assert run("new", "exercise", "01", "treble").exit_code == 0
    result = run("build")
    assert result.exit_code == 0, result.output
    shown = Path("notebooks/07_ekf_slam.ipynb").read_text()
    assert shown.index("predict_it") < shown.index("update_it") < shown.index("References")
    for name in (*release.AS_THEY_ARE, *release.PAGES.values()):
        (built.root / name).parent.mkdir(exist_ok=True)
        shutil.copy(PROJECT / name, built.root / name)
    result = run("release", "--out", "dist")
    assert result.exit_code == 1 and "07_ekf_slam.ipynb says TODO" in result.output
    assert not Path("dist").exists()


def test_a_new_lesson_begins_what_the_course_says_about_it_and_keeps_the_others(course, monkeypatch):
    for number, name in (("07", "ekf_slam"), ("08", "graph_slam")):
        assert run("new", "lesson", number, name).exit_code == 0
    monkeypatch.setattr(lessons, "ROOT", course.root)
    assert all(lessons._about(number)["does"].startswith("TODO") for number in ("07", "08"))


@pytest.mark.parametrize("short", [True, False])
@pytest.mark.parametrize("name", ["toy", "complementary_filters_and_balance"])
def test_the_files_of_a_new_lesson_are_formatted_and_their_lines_fit_whatever_its_name(course, name, short):
    add_lesson(course, "07", name, short=short)
    shutil.copy(PROJECT / "pyproject.toml", course.root)
    made = [f"solutions/exercises/07_{name}.py", f"tests/lessons/test_07_{name}.py"]
    command = [sys.executable, "-m", "ruff", "format", "--check", "--no-cache", *made]
    done = subprocess.run(command, capture_output=True, text=True, cwd=course.root)
    assert done.returncode == 0, done.stdout
    text = (course.root / f"solutions/07_{name}.md").read_text(encoding="utf-8")
    cells = re.findall(r"^```\{code-cell\}.*?^```", text, re.MULTILINE | re.DOTALL)
    assert len(cells) >= 5 and max(len(line) for cell in cells for line in cell.splitlines()) <= 120


def test_a_class_and_a_function_with_the_stars_of_the_last_exercise_are_begun_in_any_lesson(course):
    write(course.declaration("01_toy"), "points=1,", "points=1, stars=2,")
    for words in (("Tracker", "--class"), ("after_it",)):
        result = run("new", "exercise", "01", *words)
        assert result.exit_code == 0, result.output
    result = run("build", "--no-execute")
    assert result.exit_code == 0, result.output
    text = course.text("01_toy").read_text()
    assert "### Exercise 1.2 (two stars)" in text and "### Exercise 1.3 (two stars)" in text
    assert [each.stars for each in course.plan("01_toy").exercises] == [2, 2, 2]
    blank = Path("notebooks/01_toy.ipynb").read_text()
    assert blank.count("raise NotImplementedError") == 5 and "self.place" not in blank


def test_a_scaffold_that_cannot_be_is_refused(course):
    before = contents(course.root)
    for words, said in {
        "lesson 01 again": "lesson 01 is there already: 01_toy",
        "lesson 7 ekf": "a lesson is two digits and a name",
        "exercise 01 double": "lesson 01_toy has an exercise double already",
        "exercise 01 Double": "an exercise is named like a function",
        "exercise 01 double_it --class": "a class is named like 'EkfSlam'",
        "exercise 05 x": "there is no lesson 05",
    }.items():
        result = run("new", *words.split())
        assert result.exit_code == 1 and said in result.output
    assert contents(course.root) == before


NAME = "90_toy_lesson"
MODULES = (test_lessons, test_exercises, test_built)
RULES = {
    name: rule for each in MODULES for name, rule in vars(each).items() if name.startswith("test_rubric")
}
NEED_OUTPUTS = {name for name, rule in RULES.items() if "executed(" in inspect.getsource(rule)}
OF_THE_COURSE = {"test_rubric_16_built_notebooks_are_clean"}


def is_slow(rule):
    return any(mark.name == "slow" for mark in getattr(rule, "pytestmark", ()))


@pytest.fixture(params=["a lesson", "a short lesson"])
def new_lesson(request, course, monkeypatch):
    """A course with a new lesson, which is judged as one of this course's is."""
    add_lesson(course, "90", "toy_lesson", short=request.param == "a short lesson")
    course.text("01_toy").unlink()
    course.declaration("01_toy").unlink()

    def read_public(name):
        return unpack((course.root / "nao_course" / "exercises" / "checks" / f"{name}.bin").read_bytes())

    instead = {"COURSE": course, "PROJECT": course.root, "NAMES": [NAME], "read_public": read_public}
    for module in (every, *MODULES):
        for name in instead.keys() & vars(module).keys():
            monkeypatch.setattr(module, name, instead[name])
    forget_what_was_read()
    yield course
    forget_what_was_read()


def forget_what_was_read():
    """What rules keep of the course that they judged before, in this process, says nothing of another course."""
    kept = [
        each for module in (every, *MODULES) for each in vars(module).values() if hasattr(each, "cache_clear")
    ]
    assert {test_lessons.asserted_equations, every.solved} <= set(kept)
    for each in kept:
        each.cache_clear()


def test_a_short_lesson_has_one_function_and_one_question_and_waives_what_this_breaks(course):
    assert run("new", "lesson", "90", "toy_lesson", "--short").exit_code == 0
    plan = course.plan(NAME)
    assert (len(plan.exercises), len(plan.questions)) == (1, 1)
    assert set(plan.waived) == {"2", "3", "5", "11", "12"}
    assert "LIMITS" not in course.declaration(NAME).read_text(encoding="utf-8")
    text = course.text(NAME).read_text(encoding="utf-8")
    assert "payoff" not in text and "my_nao" not in text and "_second" not in text
    assert "card" not in (course.solutions / "lessons.toml").read_text(encoding="utf-8")


def judge(course, names):
    for name in names:
        rule = RULES[name]
        if every.waiver(name, every.waived(NAME)):
            continue
        with suppress(pytest.skip.Exception):  # a rule about a part that a new lesson has not
            if "exercise" in inspect.signature(rule).parameters:
                for exercise in course.plan(NAME).exercises:
                    rule(NAME, exercise)
            elif name not in OF_THE_COURSE:
                rule(NAME)


def ruff(root):
    """What this project's rules of style say of another course."""
    shutil.copy(PROJECT / "pyproject.toml", root)
    shutil.copy(PROJECT / "tests" / "paths.py", root / "tests")  # so that ruff knows whose `tests` is
    command = [sys.executable, "-m", "ruff", "check", "--no-cache", "notebooks", "tests", "solutions"]
    return subprocess.run(command, capture_output=True, text=True, cwd=root)


def test_a_new_lesson_begins_with_all_that_the_rules_ask_of_its_text(new_lesson):
    result = run("build", "--no-execute")
    assert result.exit_code == 0, result.output
    quick = [name for name, rule in RULES.items() if not is_slow(rule) and name not in NEED_OUTPUTS]
    assert len(quick) >= 14
    judge(new_lesson, quick)
    clean = ruff(new_lesson.root)
    assert clean.returncode == 0, clean.stdout


@pytest.mark.slow
def test_a_new_lesson_whose_todos_are_done_gives_nothing_of_its_solution_away(new_lesson):
    for path in (new_lesson.text(NAME), new_lesson.declaration(NAME)):
        path.write_text(path.read_text().replace("TODO", "done"))
    assert run("build", "--no-execute").exit_code == 0
    for each in (*release.AS_THEY_ARE, *release.PAGES.values()):
        (new_lesson.root / each).parent.mkdir(exist_ok=True)
        shutil.copy(PROJECT / each, new_lesson.root / each)
    files = release.contents(new_lesson, [NAME])
    lessons = {name: content for name, content in files.items() if NAME in name}
    assert len(lessons) == 3 and release.release_problems(new_lesson, lessons) == []


@pytest.mark.slow
def test_a_new_lesson_keeps_every_rule_and_its_own_test_passes(new_lesson, kernel, tmp_path):
    result = run("build")
    assert result.exit_code == 0, result.output
    judge(new_lesson, [name for name, rule in RULES.items() if not is_slow(rule)])
    for file in ("paths.py", "conftest.py", "order.py"):
        shutil.copy(PROJECT / "tests" / file, new_lesson.root / "tests")
    shutil.copy(PROJECT / "pyproject.toml", new_lesson.root)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/lessons"]
    ran = subprocess.run(command, capture_output=True, text=True, cwd=new_lesson.root)
    assert ran.returncode == 0 and "1 passed" in ran.stdout, ran.stdout
    report = mutate("90", jobs=2, solutions=new_lesson.solutions)
    hidden, public, total = report.caught()
    exercises = len(new_lesson.plan(NAME).exercises)
    assert (
        total >= test_exercises.FEWEST_MUTANTS * exercises
        and hidden / total >= 0.97
        and public / total >= 0.85
    )
