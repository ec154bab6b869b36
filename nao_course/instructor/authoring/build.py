"""Build the course: from each lesson's text the student copy, the executed solution and the data of its checks."""

from __future__ import annotations

import os
import re
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from subprocess import DEVNULL
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError
from nbformat import NotebookNode
from nbgrader.preprocessors import ClearOutput, ClearSolutions, ComputeChecksums, LockCells

from nao_course.exercises import LessonPlan
from nao_course.exercises.checking import pack
from nao_course.exercises.definitions import load_definitions
from nao_course.exercises.exercise import ANSWER_HERE
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import NUMBERED, Course, LessonError
from nao_course.instructor.authoring.plans import PlanError, check_plan, publish

CHECKS = Path("nao_course", "exercises", "checks")
LARGEST = 1_000_000  # bytes of an executed notebook
LONGEST = 60  # seconds that a whole lesson may run; a single cell gets as much
_ADDRESS = re.compile(r"0x[0-9a-f]{7,16}\b")
_IMAGE = re.compile(r"!\[[^\]]*\]\(([^)\s]+)|<img[^>]*\ssrc=[\"']([^\"']+)")
_WIDGET = "application/vnd.jupyter.widget-view+json"

Tell = Callable[[str, str], None]


# --- build ---


@dataclass(frozen=True)
class Built:
    """What a build made, not yet written.

    Parameters
    ----------
    course : Course
        Of which course.
    files : mapping of Path to bytes
        Contents by the path under the course's root.
    stale : tuple of Path
        Generated files of lessons that are gone.
    """

    course: Course
    files: Mapping[Path, bytes]
    stale: tuple[Path, ...] = ()

    def changes(self) -> list[Path]:
        """Return what differs from what is there."""
        changed = [path for path, content in self.files.items() if _bytes(self.course.root / path) != content]
        return [*changed, *self.stale]

    def write(self) -> list[Path]:
        """Write what differs, take away what is stale, and return both."""
        changes = self.changes()
        for path in changes:
            target = self.course.root / path
            if path in self.stale:
                target.unlink()
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            temporary = target.with_name(f".{target.name}.new")
            temporary.write_bytes(self.files[path])
            temporary.replace(target)
        return changes


def _bytes(path: Path) -> bytes | None:
    return path.read_bytes() if path.is_file() else None


def build(
    course: Course,
    wanted: Sequence[str] = (),
    *,
    texts: Mapping[str, str] | None = None,
    execute: bool = True,
    tell: Tell = lambda lesson, step: None,
) -> Built:
    """Build lessons in memory and a temporary folder; nothing of the course changes until the result is written.

    Parameters
    ----------
    course : Course
        The course.
    wanted : sequence of str
        Numbers or names of lessons; all by default.
    texts : mapping of str to str, optional
        Texts that are not those of the files, by the lesson's name; they become part of the result.
    execute : bool
        Whether the solutions are run and part of the result.
    tell : callable
        Called with a lesson's name and what is done to it.

    Returns
    -------
    Built
        To be compared or written.

    Raises
    ------
    LessonError
        If something is wrong with a lesson: one line for each thing, with file and cell.
    """
    texts = texts or {}
    names = course.names(wanted)
    plans = {name: course.plan(name) for name in course.names()}
    sources = {
        name: texts[name] if name in texts else course.text(name).read_text(encoding="utf-8")
        for name in names
    }
    solved = _read_all(course, sources, plans)
    files: dict[Path, bytes] = {
        course.text(name).relative_to(course.root): texts[name].encode() for name in texts
    }
    with TemporaryDirectory(prefix="nao_course_") as folder:
        stage = _stage(course, Path(folder), solved)
        files |= _check_data(solved, plans, stage, tell)
        for name, notebook in solved.items():
            tell(name, "student copy")
            files[Path("notebooks", f"{name}.ipynb")] = _dump(student_copy(notebook))
            files |= _images(course, name, notebook)
        if execute:
            stamps = {name: _stamp(sources[name], solved[name]) for name in names}
            for name, notebook in _execute_all(solved, stage, tell):
                notebook.metadata.nao_course.update(stamps[name])
                files[Path("solutions", f"{name}.ipynb")] = _dump(notebook)
    return Built(course, files, () if wanted else _stale(course))


def _stamp(text: str, notebook: NotebookNode) -> dict[str, str]:
    """What tells later whether text or notebook was edited since."""
    return {"text": lesson_text.text_hash(text), "cells": lesson_text.fingerprint(notebook)}


def _read_all(
    course: Course, sources: Mapping[str, str], plans: Mapping[str, LessonPlan]
) -> dict[str, NotebookNode]:
    """Read lessons, with points and version; all that is wrong with any of them is said at once."""
    solved: dict[str, NotebookNode] = {}
    problems: list[str] = []
    declared = {each for plan in plans.values() for each in plan.points}
    problems += [
        f"course.toml: points for {name}, which no lesson declares"
        for name in course.points.keys() - declared
    ]
    for name, text in sources.items():
        plan = plans[name]
        try:
            notebook = lesson_text.read_lesson(course.text(name), text)
        except LessonError as error:
            problems += str(error).splitlines()
            continue
        exercises, written = ([each.name for each in kind] for kind in (plan.exercises, plan.written))
        wrong = list(lesson_text.lesson_problems(notebook, exercises, written))
        problems += wrong
        if not wrong:
            lesson_text.set_points(notebook, plan.points)
            notebook.metadata.nao_course["version"] = course.version
            solved[name] = notebook
    if problems:
        raise LessonError("\n".join(problems))
    return solved


def _stage(course: Course, stage: Path, solved: Mapping[str, NotebookNode]) -> Path:
    """Lay out a copy of the library and the solutions, where the lessons run before anything is replaced."""
    shutil.copytree(course.root / "nao_course", stage / "nao_course")
    (stage / CHECKS).mkdir(exist_ok=True)
    (stage / "solutions").mkdir()
    for path in course.solutions.glob(f"{NUMBERED}.ipynb"):  # of lessons that are not built this time
        shutil.copy2(path, stage / "solutions")
    if (course.solutions / "images").is_dir():
        shutil.copytree(course.solutions / "images", stage / "solutions" / "images")
    for name, notebook in solved.items():
        (stage / "solutions" / f"{name}.ipynb").write_bytes(_dump(notebook))
    return stage


def _check_data(
    solved: Mapping[str, NotebookNode], plans: Mapping[str, LessonPlan], stage: Path, tell: Tell
) -> dict[Path, bytes]:
    """Make the data of all lessons' checks, on the stage too; what is wrong with any plan is said at once."""
    files: dict[Path, bytes] = {}
    problems: list[str] = []
    for name, notebook in solved.items():
        tell(name, "exercises")
        data = CHECKS / f"{name}.bin"
        try:
            files[data] = _checks(name, plans, stage)
        except PlanError as error:
            problems += [_with_place(notebook, line) for line in str(error).splitlines()]
            continue
        (stage / data).write_bytes(files[data])
    if problems:
        raise LessonError("\n".join(problems))
    return files


def _with_place(notebook: NotebookNode, problem: str) -> str:
    """Say in which declaration, and with which cell, "LESSON: EXERCISE: what is wrong" is."""
    name = notebook.metadata.nao_course.lesson
    problem = problem.removeprefix(f"{name}: ")
    where = [f"solutions/exercises/{name}.py"]
    where += [
        lesson_text.place(f"{name}.md", notebook, ordinal)
        for ordinal, cell in lesson_text.code_cells(notebook, "exercise")
        if lesson_text.exercise_name(cell) == problem.split(":")[0]
    ]
    return f"{', '.join(where)}: {problem}"


def _checks(name: str, plans: Mapping[str, LessonPlan], stage: Path) -> bytes:
    """Prove a lesson's plan against its solution and pack what its checks need."""
    plan = plans[name]
    reference = load_definitions(stage / "solutions" / f"{name}.ipynb")
    taken = {each.name for other in plans if other != name for each in plans[other].exercises}
    check_plan(name, plan, reference, taken)
    return pack(publish(name, plan, reference))


def student_copy(solved: NotebookNode) -> NotebookNode:
    """Make the student copy of a lesson with nbgrader's own preprocessors.

    Parameters
    ----------
    solved : NotebookNode
        The lesson with its solutions; it stays as it was.

    Returns
    -------
    NotebookNode
        Without solutions and outputs; what a student may not change is locked, and its checksum noted.
    """
    notebook = nbformat.from_dict(solved)
    stub = {"python": "raise NotImplementedError"}
    resources: dict[str, Any] = {}
    clear = ClearSolutions(code_stub=stub, text_stub=ANSWER_HERE)
    for preprocessor in (clear, LockCells(), ClearOutput(), ComputeChecksums()):
        notebook, resources = preprocessor.preprocess(notebook, resources)
    return notebook


def _images(course: Course, name: str, notebook: NotebookNode) -> dict[Path, bytes]:
    """Pictures that a lesson's text shows, for the folder of the student copies.

    Raises
    ------
    LessonError
        If one is missing or stands elsewhere.
    """
    found: dict[Path, bytes] = {}
    for ordinal, cell in enumerate(notebook.cells):
        if cell.cell_type != "markdown":
            continue
        for match in _IMAGE.finditer(cell.source):
            image = match[1] or match[2]
            where = lesson_text.place(f"{name}.md", notebook, ordinal)
            if "://" in image or not image.startswith("images/"):
                raise LessonError(f"{where}: {image} must be a file in solutions/images/, named images/NAME")
            if not (course.solutions / image).is_file():
                raise LessonError(f"{where}: solutions/{image} does not exist")
            found[Path("notebooks", image)] = (course.solutions / image).read_bytes()
    return found


def _dump(notebook: NotebookNode) -> bytes:
    nbformat.validate(notebook)
    return (nbformat.writes(notebook) + "\n").encode()


def _stale(course: Course) -> tuple[Path, ...]:
    """Generated files of lessons that have no text any more."""
    names = set(course.names())
    folders = ((Path("notebooks"), ".ipynb"), (Path("solutions"), ".ipynb"), (CHECKS, ".bin"))
    return tuple(
        path.relative_to(course.root)
        for folder, suffix in folders
        for path in sorted((course.root / folder).glob(f"{NUMBERED}{suffix}"))
        if path.stem not in names
    )


# --- execution ---


def _execute_all(
    solved: Mapping[str, NotebookNode], stage: Path, tell: Tell
) -> Iterator[tuple[str, NotebookNode]]:
    """Run all lessons, a few at a time; what is wrong with any of them is said at the end."""

    def run(name: str) -> NotebookNode:
        tell(name, "running")
        executed = execute(solved[name], stage)
        tell(name, "done")
        return executed

    problems: list[str] = []
    with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
        for name, running in [(name, pool.submit(run, name)) for name in solved]:
            try:
                yield name, running.result()
            except LessonError as error:
                problems.append(str(error))
    if problems:
        raise LessonError("\n".join(problems))


def execute(solved: NotebookNode, root: Path) -> NotebookNode:
    """Run a lesson from top to bottom; its outputs are the same at each run on one machine.

    Parameters
    ----------
    solved : NotebookNode
        The lesson; it stays as it was.
    root : Path
        Folder of the library that it imports; it runs in `solutions` there.

    Returns
    -------
    NotebookNode
        With outputs, and without what differs from run to run.

    Raises
    ------
    LessonError
        If a cell fails, warns, takes too long, or shows what will differ next time.
    """
    notebook = nbformat.from_dict(solved)
    file = f"{solved.metadata.nao_course.lesson}.md"
    client = NotebookClient(
        notebook,
        timeout=LONGEST,
        kernel_name="python3",
        record_timing=False,
        store_widget_state=False,
        coalesce_streams=True,
        resources={"metadata": {"path": str(root / "solutions")}},
    )
    try:
        client.execute(env=environment(root), stderr=DEVNULL)  # the kernel's own log; a cell's is an output
    except CellTimeoutError:
        raise LessonError(f"{file}: a cell ran for more than {LONGEST} s") from None
    except CellExecutionError as error:
        ordinal = next(
            i
            for i, cell in enumerate(notebook.cells)
            if any(o.output_type == "error" for o in _outputs(cell))
        )
        what = f"{error.ename}: {error.evalue}"
        raise LessonError(f"{lesson_text.place(file, notebook, ordinal)}: {what}") from None
    notebook.metadata = solved.metadata
    problems: list[str] = []
    for ordinal, cell in lesson_text.code_cells(notebook):
        where = lesson_text.place(file, notebook, ordinal)
        cell["outputs"] = [kept for output in cell.outputs if (kept := _tidy(output))]
        problems += [
            f"{where}: {problem}" for output in cell.outputs for problem in _output_problems(output, root)
        ]
    size = len(_dump(notebook))
    if size > LARGEST:
        problems.append(f"{file}: {size / 1e6:.1f} MB when it has run; {LARGEST / 1e6:.0f} MB is the most")
    if problems:
        raise LessonError("\n".join(problems))
    return notebook


def environment(root: Path) -> dict[str, str]:
    """Environment in which a lesson's checks are strict and its numbers the same each time."""
    return {
        **os.environ,
        "PYTHONPATH": str(root),
        "PYTHONHASHSEED": "0",
        "MPLBACKEND": "module://matplotlib_inline.backend_inline",
        "NAO_COURSE_STRICT": "1",
        "NAO_COURSE_NOTEBOOKS": str(root / "solutions"),
        "NAO_COURSE_DATA": "none",  # a lesson is built without recorded data, on every machine
        "OMP_NUM_THREADS": "1",
        "OPENBLAS_NUM_THREADS": "1",
    }


def _outputs(cell: NotebookNode) -> list[NotebookNode]:
    return list(cell.get("outputs", ()))


def _tidy(output: NotebookNode) -> NotebookNode | None:
    """Take a widget's identity out of an output; nothing may be left of it."""
    if "data" in output:
        output["data"].pop(_WIDGET, None)
        if not output["data"]:
            return None
    return output


def _output_problems(output: NotebookNode, root: Path) -> Iterator[str]:
    """What of an output would be red, or differ at the next run."""
    if output.get("name") == "stderr":
        yield f"it warns: {output.text.strip().splitlines()[-1][:200]}"
    shown = [output.get("text", ""), *(str(each) for each in output.get("data", {}).values())]
    text = "\n".join(each for each in shown if len(each) < 100_000)
    if match := _ADDRESS.search(text):
        yield f"it shows an address, {match.group()}, which differs at each run; end the last line with a semicolon"
    if any(str(path) in text for path in (root, Path.home(), Path(sys.prefix))):
        yield "it shows a path of this machine"


# --- a solution that was edited in JupyterLab ---


def edited(course: Course, name: str) -> tuple[bool, bool]:
    """Return whether a lesson's text and its solution notebook were edited since the notebook was built."""
    path = course.solutions / f"{name}.ipynb"
    if not path.is_file():
        return True, False
    notebook = read_notebook(path)
    stamp = notebook.metadata.get("nao_course", {})
    text = course.text(name).read_text(encoding="utf-8")
    return stamp.get("text") != lesson_text.text_hash(text), stamp.get("cells") != lesson_text.fingerprint(
        notebook
    )


def read_notebook(path: Path) -> NotebookNode:
    """Read a notebook.

    Raises
    ------
    LessonError
        If it is none.
    """
    try:
        return nbformat.read(path, as_version=4)
    except (ValueError, KeyError, AttributeError, OSError) as error:
        raise LessonError(f"{path.name}: not a notebook ({type(error).__name__}: {error})") from None


def text_from_notebook(course: Course, name: str) -> str:
    """Return the text of a lesson whose solution notebook was edited.

    Raises
    ------
    LessonError
        If there is nothing to bring back, the text was edited too, or it does not fit into text.
    """
    text_edited, notebook_edited = edited(course, name)
    file = f"solutions/{name}.ipynb"
    if not notebook_edited:
        raise LessonError(
            f"{file}: nothing in it differs from what was built; there is nothing to bring back"
        )
    if text_edited:
        raise LessonError(
            f"{file} and solutions/{name}.md were both edited since the last build; nothing is written. Keep one: "
            f"`git checkout solutions/{name}.md` keeps the notebook, deleting {file} keeps the text"
        )
    notebook = read_notebook(course.solutions / f"{name}.ipynb")
    points = course.plan(name).points
    for _, cell in (*lesson_text.code_cells(notebook, "check"), *lesson_text.written_cells(notebook)):
        exercise = lesson_text.exercise_name(cell)
        if cell.metadata.nbgrader.get("points") != points.get(exercise):
            raise LessonError(
                f"{file}: the points of {exercise} were changed in the notebook; they are declared in "
                f"solutions/exercises/{name}.py, and for one course in course.toml"
            )
    return lesson_text.write_lesson(notebook)


def refuse_to_lose_edits(course: Course, names: Sequence[str]) -> None:
    """Refuse to build over solution notebooks that were edited in JupyterLab.

    Raises
    ------
    LessonError
        If there is one.
    """
    lost = [name for name in names if edited(course, name)[1]]
    if lost:
        raise LessonError(
            "\n".join(
                f"solutions/{name}.ipynb was edited since it was built: bring that back into the text with "
                f"`nao-course build --from-notebook {name[:2]}`, or delete the notebook"
                for name in lost
            )
        )
