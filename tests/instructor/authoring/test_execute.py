"""A lesson that fails, warns, or would show something else next time is refused, with the cell."""

import nbformat
import pytest

from nao_course.instructor.authoring import execute, lesson_text
from nao_course.instructor.authoring.course import LessonError
from tests.paths import PROJECT
from tests.toy.course import contents, run, write


@pytest.fixture
def stage(tmp_path):
    """Where a lesson runs, with a library beside it."""
    (tmp_path / "solutions").mkdir()
    (tmp_path / "nao_course").symlink_to(PROJECT / "nao_course")
    return tmp_path


def lesson(*sources):
    notebook = nbformat.v4.new_notebook(metadata=lesson_text.KERNEL | {"nao_course": {"lesson": "01_toy"}})
    notebook.cells = [nbformat.v4.new_code_cell(source, id=f"c{i}") for i, source in enumerate(sources)]
    return notebook


def test_all_that_would_be_red_or_too_large_or_differ_next_time_is_said_at_once(stage, kernel, monkeypatch):
    monkeypatch.setattr(execute, "LARGEST", 10)
    sources = ("'fine'", "import warnings\nwarnings.warn('old')", "object()", "import sys\nsys.prefix")
    with pytest.raises(LessonError) as refusal:
        execute.execute(lesson(*sources), stage)
    *said, large = str(refusal.value).splitlines()
    assert "MB when it has run" in large
    assert [each.split(": ")[0].split(" (")[0] for each in said] == [
        f"01_toy.md, cell {i}" for i in (2, 3, 4)
    ]
    for line, reason in zip(said, ("it warns", "shows an address", "a path of this machine"), strict=True):
        assert reason in line


def test_a_cell_that_raises_is_named_and_no_later_one_runs(stage, kernel):
    sources = ("x = 1", "1 / 0", f"open({str(stage / 'ran')!r}, 'w')")
    with pytest.raises(LessonError, match=r"01_toy.md, cell 2 \('1 / 0'\): ZeroDivisionError"):
        execute.execute(lesson(*sources), stage)
    assert not (stage / "ran").exists()


class Refusing:
    """A client whose kernels end before they answer, as when another program takes one of their ports."""

    def __init__(self, *problems):
        self.problems = list(problems)

    async def async_execute(self, **_):
        if self.problems:
            raise self.problems.pop(0)


def test_a_kernel_that_ends_before_it_answers_is_started_again():
    died = RuntimeError("Kernel died before replying to kernel_info")
    client = Refusing(died, died)
    execute.run_all_cells(client, {})
    assert not client.problems
    for problem in (died, RuntimeError("a cell's own")):
        client = Refusing(problem, died, died, died)
        with pytest.raises(RuntimeError, match=str(problem)):
            execute.run_all_cells(client, {})
        assert len(client.problems) == (1 if problem is died else 3)


@pytest.mark.slow
def test_a_cell_that_never_ends_is_stopped(stage, kernel, monkeypatch):
    monkeypatch.setattr(execute, "LONGEST", 1)
    with pytest.raises(LessonError, match="a cell ran for more than 1 s"):
        execute.execute(lesson("while True: pass"), stage)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("1 / 0", "ZeroDivisionError"),
        ("print(('x' * 99 + chr(10)) * 12_000)", "MB when it has run; 1 MB is the most"),
    ],
    ids=["raises", "large"],
)
def test_a_lesson_that_cannot_be_run_is_said_by_build_and_nothing_is_written(course, kernel, code, said):
    write(course.text("01_toy"), 'print("shown")', code)
    before = contents(course.root)
    result = run("build")
    assert result.exit_code == 1 and "01_toy.md" in result.output and said in result.output
    assert "Traceback" not in result.output and contents(course.root) == before
