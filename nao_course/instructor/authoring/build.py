"""Build the course: from each lesson's text the student copy, the executed solution and the data of its checks."""

import ast
import hashlib
import json
import re
import shutil
from base64 import b64decode
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
from nbformat import NotebookNode
from nbgrader.preprocessors import ClearOutput, ClearSolutions, ComputeChecksums, LockCells

from nao_course.exercises import LessonPlan, lesson_names
from nao_course.exercises.exercise import ANSWER_HERE
from nao_course.exercises.outline import outline_bytes
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import Course, LessonError
from nao_course.instructor.authoring.execute import Tell, execute_all, runs_with
from nao_course.instructor.authoring.plan_checks import plan_warnings, use_problems
from nao_course.instructor.authoring.plans import CHECKS, OUTLINES, PlanError
from nao_course.instructor.authoring.proofs import MANIFEST, Proofs
from nao_course.instructor.authoring.rounding_errors import same_but_for_rounding
from nao_course.instructor.authoring.stamps import differs_in_version_alone, edited, stamp

# Ends of the names of the functions and classes that make a panel
_PANELS = ("Panel", "Lab", "Dial", "my_nao", "show_film")
RUNS = Path("build", "runs.json")  # git ignores it
CODE_STUB = {"python": "raise NotImplementedError"}
_DRAWN = re.compile(r"<img[^>]*src=\"data:image/(\w+);base64,([^\"]+)")
_IMAGE = re.compile(r"!\[[^\]]*\]\(([^)\s]+)|<img[^>]*\ssrc=[\"']([^\"']+)|\[[^\]]*\]\((images/[^)\s]+)")


@dataclass(frozen=True)
class Built:
    """What a build made, not yet written.

    `files` are contents by the path under the course's root, `stale` are generated files of lessons that no longer
    exist, and `warnings` say what an author may want to add to a declaration, one line each, with its file. `ran` has
    a hash of all that the outputs of a lesson depend on.
    """

    course: Course
    files: Mapping[Path, bytes]
    stale: tuple[Path, ...] = ()
    warnings: tuple[str, ...] = ()
    ran: Mapping[str, str] = field(default_factory=dict)

    def changes(self) -> list[Path]:
        """Return the files that have changed by more than the rounding errors of another processor."""
        changed = [path for path, content in self.files.items() if not self._is_there(path, content)]
        # The picture that a lesson opens with is also in its notebook: both are of one build.
        lessons = {lesson_names.number_of(path.stem) for path in changed if path.suffix == ".ipynb"}
        openings = [path for path in self.files if _payoff_of(path) in lessons and path not in changed]
        changed += [path for path in openings if _bytes(self.course.root / path) != self.files[path]]
        return [*changed, *self.stale]

    def _is_there(self, path: Path, content: bytes) -> bool:
        file = self.course.root / path
        return file.is_file() and same_but_for_rounding(path.suffix, file.read_bytes(), content)

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
        if self.ran:
            solutions, file = self.course.solutions, self.course.root / RUNS
            runs = {name: [with_, _hash(solutions / f"{name}.ipynb")] for name, with_ in self.ran.items()}
            file.parent.mkdir(exist_ok=True)
            file.write_text(json.dumps(_runs(self.course.root) | runs), encoding="utf-8")
        return changes


def _bytes(path: Path) -> bytes | None:
    return path.read_bytes() if path.is_file() else None


def build(
    course: Course,
    wanted: Sequence[str] = (),
    *,
    texts: Mapping[str, str] | None = None,
    execute: bool = True,
    solutions: bool = True,
    prove: bool = False,
    tell: Tell = lambda lesson, step: None,
) -> Built:
    """Build lessons in memory and a temporary folder; nothing of the course changes until the result is written.

    Without `wanted`, the course's chosen lessons are built. A notebook runs again unless only the release has another
    version. Only proofs of declarations are kept at once, in the course's folder build/, also where something else is
    wrong. `texts` replace the files' texts, by the lesson's name, and become part of the result. Without `execute`, the
    solution notebooks have no outputs; with `prove`, declarations are proven again although they have not changed.
    `tell` is called with a lesson's name and what is done to it. A LessonError has one line for each thing that is
    wrong, with file and cell.
    """
    texts = texts or {}
    names = course.names(wanted or course.chosen)
    plans = _plans(course)
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
        declarations = {name: course.declaration(name) for name in plans}
        proofs = Proofs(course.root, declarations, plans, stage / "solutions", anew=prove)
        proven = _check_data(course, solved, proofs, stage, tell)
        files |= {CHECKS / f"{name}.bin": data for name, data in proven.items()}
        files[MANIFEST] = proofs.manifest(proven)
        for name, notebook in solved.items():
            tell(name, "student copy")
            released = student_copy(notebook)
            files[Path("notebooks", f"{name}.ipynb")] = lesson_text.notebook_bytes(released)
            files[OUTLINES / f"{name}.json"] = outline_bytes(released.cells)
            files |= _images(course, name, notebook, to_come=solutions)
        conditions = {name: runs_with(name, stage) for name in solved if execute and solutions}
        ran = _with_outputs(course, solved, conditions, stage, tell) if execute else solved.items()
        for name, notebook in ran if solutions else ():
            files |= payoff_files(notebook) if execute else {}
            kept = stamp(course, name, sources[name], solved[name], executed=execute)
            notebook.metadata.nao_course.update(kept)
            files[Path("solutions", f"{name}.ipynb")] = lesson_text.notebook_bytes(notebook)
            tell(name, "done")
    warnings = (
        f"solutions/exercises/{name}.py: {each}" for name in names for each in plan_warnings(plans[name])
    )
    return Built(course, files, () if wanted else _stale(course), tuple(warnings), conditions)


def _with_outputs(
    course: Course, solved: Mapping[str, NotebookNode], conditions: Mapping[str, str], stage: Path, tell: Tell
) -> Iterator[tuple[str, NotebookNode]]:
    """Yield the solution notebooks: run, or with their former outputs if only the release has another version."""
    to_run, runs = dict(solved), _runs(course.root)
    for name, notebook in solved.items():
        file = course.solutions / f"{name}.ipynb"
        is_kept = runs.get(name) == [conditions[name], _hash(file)]
        if is_kept and differs_in_version_alone(course, name, notebook):
            former = lesson_text.read_notebook(file)
            former.metadata = to_run.pop(name).metadata
            yield name, former
    yield from execute_all(to_run, stage, tell)


def _runs(root: Path) -> dict[str, Any]:
    """Return what was run here: by the lesson, all that its outputs depend on, and its notebook, as hashes."""
    try:
        found = json.loads((root / RUNS).read_bytes())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _hash(file: Path) -> str:
    return hashlib.sha256(_bytes(file) or b"").hexdigest()


def _plans(course: Course) -> dict[str, LessonPlan]:
    """Load the plans of all lessons, and report all their errors together."""
    plans: dict[str, LessonPlan] = {}
    problems: list[str] = []
    for name in course.names():
        try:
            plans[name] = course.plan(name)
        except PlanError as error:
            problems += [f"solutions/exercises/{line}" for line in str(error).splitlines()]
    if problems:
        raise LessonError("\n".join(problems))
    return plans


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
        problems += [f"solutions/exercises/{name}.py: {each}" for each in use_problems(name, plans)]
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
    # of lessons that are not built this time
    for path in course.solutions.glob(f"{lesson_names.PATTERN}.ipynb"):
        shutil.copy2(path, stage / "solutions")
    if (course.solutions / "images").is_dir():
        shutil.copytree(course.solutions / "images", stage / "solutions" / "images")
    for name, notebook in solved.items():
        (stage / "solutions" / f"{name}.ipynb").write_bytes(lesson_text.notebook_bytes(notebook))
    return stage


def _check_data(
    course: Course, solved: Mapping[str, NotebookNode], proofs: Proofs, stage: Path, tell: Tell
) -> dict[str, bytes]:
    """Make the data of all lessons' checks, on the stage too; what is wrong with any plan is said at once."""
    proven: dict[str, bytes] = {}
    problems: list[str] = []
    for name, notebook in solved.items():
        tell(name, "exercises")
        try:
            data = proofs.check_data(name)
        except PlanError as error:
            problems += [_with_place(notebook, line) for line in str(error).splitlines()]
            continue
        there = _bytes(course.check_data(name))
        is_there = there is not None and same_but_for_rounding(".bin", there, data)
        proven[name] = there if there is not None and is_there else data
        (stage / CHECKS / f"{name}.bin").write_bytes(proven[name])
    if problems:
        raise LessonError("\n".join(problems))
    return proven


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


def student_copy(solved: NotebookNode) -> NotebookNode:
    """Make the student copy of a lesson with nbgrader's own preprocessors; the solved notebook stays as it was.

    The copy has no solutions and outputs; what a student may not change is locked, and its checksum is noted. A cell
    that shows a panel cannot be deleted either: one key beside the panel that drives the robot would be enough.
    """
    notebook = nbformat.from_dict(solved)
    resources: dict[str, Any] = {}
    clear = ClearSolutions(code_stub=CODE_STUB, text_stub=ANSWER_HERE)
    for preprocessor in (clear, LockCells(), ClearOutput(), ComputeChecksums()):
        notebook, resources = preprocessor.preprocess(notebook, resources)
    for _, cell in lesson_text.code_cells(notebook):
        if _shows_panel(cell):
            cell.metadata["deletable"] = False
    return notebook


def _shows_panel(cell: NotebookNode) -> bool:
    """Return whether a code cell ends with a panel or a film: with ``panel``, or with the call that makes one."""
    *_, last = None, *ast.parse(lesson_text.python(cell)).body
    shown = last.value if isinstance(last, ast.Expr) else None
    made = shown.func if isinstance(shown, ast.Call) else shown
    name = str(getattr(made, "id", getattr(made, "attr", "")))
    return name.endswith(_PANELS) if made is not shown else name == "panel"


def payoff_files(ran: NotebookNode) -> dict[Path, bytes]:
    """Return the picture that a lesson opens with, drawn by its payoff cell, for both notebooks; none without one.

    Raise a LessonError if the cell shows no picture, or the text does not open with it.
    """
    name = ran.metadata.nao_course.lesson
    for ordinal, cell in lesson_text.code_cells(ran, "payoff"):
        where = lesson_text.place(f"{name}.md", ran, ordinal)
        shown = "".join(str(output.get("data", {}).get("text/html", "")) for output in cell.outputs)
        pictures = _DRAWN.findall(shown)
        if len(pictures) != 1:
            raise LessonError(f"{where}: a payoff shows one picture, this one shows {len(pictures)}")
        kind, data = pictures[0]
        image = f"{payoff_image(name)}.{kind}"
        if f"]({image})" not in "".join(cell.source for cell in ran.cells[:2]):
            raise LessonError(
                f"{where}: the lesson does not open with its picture: ![what it shows]({image})"
            )
        return {Path(folder, image): b64decode(data) for folder in ("notebooks", "solutions")}
    return {}


def _payoff_of(path: Path) -> str:
    """Return the number of the lesson that opens with this picture; empty if the file is anything else."""
    return path.stem[:2] if path.stem.endswith("_payoff") else ""


def payoff_image(name: str) -> str:
    """Return how a lesson's text calls the picture that it opens with, without the suffix."""
    return f"images/{lesson_names.number_of(name)}_payoff"


def _images(course: Course, name: str, notebook: NotebookNode, *, to_come: bool) -> dict[Path, bytes]:
    """Find the pictures of a text for the folder of the student copies; with `to_come` also pictures not drawn yet.

    Raise a LessonError if one is missing or is in another folder.
    """
    found: dict[Path, bytes] = {}
    for ordinal, cell in enumerate(notebook.cells):
        if cell.cell_type != "markdown":
            continue
        for match in _IMAGE.finditer(cell.source):
            image = match[1] or match[2] or match[3]
            where = lesson_text.place(f"{name}.md", notebook, ordinal)
            if "://" in image or not image.startswith("images/"):
                raise LessonError(f"{where}: {image} must be a file in solutions/images/, named images/NAME")
            if not (course.solutions / image).is_file():
                if to_come and image.startswith(payoff_image(name)):
                    continue
                raise LessonError(f"{where}: solutions/{image} does not exist")
            found[Path("notebooks", image)] = (course.solutions / image).read_bytes()
    return found


def _stale(course: Course) -> tuple[Path, ...]:
    """List the generated files of lessons that have no text any more."""
    names = set(course.names())
    folders = (
        (Path("notebooks"), ".ipynb"),
        (Path("solutions"), ".ipynb"),
        (CHECKS, ".bin"),
        (OUTLINES, ".json"),
    )
    made = [
        path.relative_to(course.root)
        for folder, suffix in folders
        for path in sorted((course.root / folder).glob(f"{lesson_names.PATTERN}{suffix}"))
        if path.stem not in names
    ]
    openings = {payoff_image(name) for name in names}
    made += [
        path.relative_to(course.root)
        for folder in ("notebooks", "solutions")
        for path in sorted((course.root / folder).glob("images/[0-9][0-9]_payoff.*"))
        if f"images/{path.stem}" not in openings
    ]
    return tuple(made)


def text_from_notebook(course: Course, name: str) -> str:
    """Return the text of a lesson whose solution notebook was edited.

    Raise a LessonError if the notebook was not edited, the text was edited too, or the edit does not fit into text.
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
    notebook = lesson_text.read_notebook(course.solutions / f"{name}.ipynb")
    points = course.plan(name).points
    for _, cell in (*lesson_text.code_cells(notebook, "check"), *lesson_text.written_cells(notebook)):
        exercise = lesson_text.exercise_name(cell)
        if cell.metadata.nbgrader.get("points") != points.get(exercise):
            raise LessonError(
                f"{file}: the points of {exercise} were changed in the notebook; they are declared in "
                f"solutions/exercises/{name}.py, and for one course in course.toml"
            )
    return lesson_text.write_lesson(notebook)
