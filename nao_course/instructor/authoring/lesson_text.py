"""A lesson's text and its notebook: one is made from the other, and nothing is lost on the way."""

import ast
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import jupytext
import nbformat
from IPython.core.inputtransformer2 import TransformerManager
from nbformat import NotebookNode

from nao_course.exercises import lesson_names
from nao_course.exercises.cells import SHOWN, grade_id, metadata
from nao_course.instructor.authoring.course import LessonError
from nao_course.instructor.authoring.stamps import VOLATILE

HEADER = """---
jupytext:
  text_representation:
    extension: .md
    format_name: myst
kernelspec:
  display_name: Python 3
  language: python
  name: python3
---
"""
KERNEL = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}
BEGIN, END = "### BEGIN SOLUTION", "### END SOLUTION"
ROLES = ("setup", *SHOWN)
FOLDED = {"source_hidden": True}  # JupyterLab's: a bar stands where the code is, and its output below it
OPTIONS = ("exercise", "check", "role")  # a code cell of the text has exactly one of them
WRITTEN = "written"  # the option of a text cell that holds the answer to a written question


# --- text -> notebook ---


def read_lesson(path: Path, text: str | None = None) -> NotebookNode:
    """Make a lesson's notebook, with its solutions and without outputs, from its text, by default the file's.

    The options of its cells are nbgrader's metadata, and cell ids are made from lesson and grade_id or ordinal. A
    LessonError is raised if a code cell's options are not understood, or the header differs from this course's.
    """
    notebook = jupytext.reads(path.read_text(encoding="utf-8") if text is None else text, fmt="md:myst")
    problems = [
        f"{path.name}: the header's {key!r} would be lost in the notebook; take it out"
        for key in notebook.metadata.keys() - {"jupytext", "kernelspec"}
    ]
    for ordinal, cell in enumerate(notebook.cells):
        if WRITTEN in cell.metadata and cell.cell_type == "markdown":
            cell["metadata"] = _with_marking(dict(cell.metadata))
        elif cell.cell_type == "code":
            cell["outputs"], cell["execution_count"] = [], None
            try:
                cell["metadata"] = _with_grading(dict(cell.metadata))
            except LessonError as error:
                problems.append(f"{place(path.name, notebook, ordinal)}: {error}")
        cell["id"] = f"lesson{lesson_names.number_of(path.stem)}-{grade_id(cell) or f'{ordinal:03d}'}"
    if problems:
        raise LessonError("\n".join(problems))
    notebook.metadata = nbformat.from_dict(KERNEL | {"nao_course": {"lesson": path.stem}})
    notebook.nbformat, notebook.nbformat_minor = 4, 5
    return notebook


def _with_grading(options: dict[str, Any]) -> NotebookNode:
    """Turn a code cell's options in the text into a notebook's metadata; points are the plan's."""
    given = [name for name in OPTIONS if name in options]
    if len(given) != 1:
        raise LessonError(
            f"a code cell needs one of :exercise: NAME, :check: NAME and :role: {' or '.join(ROLES)}; "
            f"it has {given or 'none'}"
        )
    option = given[0]
    value = str(options.pop(option))
    metadata: dict[str, Any] = {"nao_course": {"role": value if option == "role" else option}, **options}
    if option == "exercise":
        metadata["nbgrader"] = _nbgrader(value, solution=True)
    elif option == "check":
        metadata["nbgrader"] = _nbgrader(f"check_{value}", grade=True, locked=True) | {"points": 0.0}
    elif value == "setup":
        metadata["nbgrader"] = _nbgrader("setup", locked=True)
        metadata["jupyter"] = FOLDED
    elif value not in ROLES:
        raise LessonError(f"there is no role {value!r}; there are {' and '.join(ROLES)}")
    elif value == "display":
        metadata["jupyter"] = FOLDED
    return nbformat.from_dict(metadata)


def _with_marking(options: dict[str, Any]) -> NotebookNode:
    """Turn the option of a written answer's text cell into a notebook's metadata."""
    name = str(options.pop(WRITTEN))
    grading = _nbgrader(name, grade=True, solution=True) | {"points": 0.0}
    return nbformat.from_dict({"nao_course": {"role": WRITTEN}, "nbgrader": grading, **options})


def _nbgrader(
    name: str, *, grade: bool = False, solution: bool = False, locked: bool = False
) -> dict[str, Any]:
    """Return the metadata of nbgrader's schema 3; nbgrader refuses additional keys."""
    return {
        "schema_version": 3,
        "grade_id": name,
        "grade": grade,
        "solution": solution,
        "locked": locked,
        "task": False,
    }


# --- what cells are ---


def role(cell: NotebookNode) -> str:
    """Return exercise, check or one of `ROLES` of a code cell, written of an answer; of any other, nothing."""
    return str(metadata(cell, "nao_course").get("role", ""))


def exercise_name(cell: NotebookNode) -> str:
    """Return the exercise that an exercise's or check's cell is about."""
    return grade_id(cell).removeprefix("check_") if role(cell) == "check" else grade_id(cell)


def code_cells(notebook: NotebookNode, *roles: str) -> list[tuple[int, NotebookNode]]:
    """Return the code cells of some roles, each with its place among all cells."""
    return [
        (ordinal, cell)
        for ordinal, cell in enumerate(notebook.cells)
        if cell.cell_type == "code" and (not roles or role(cell) in roles)
    ]


def written_cells(notebook: NotebookNode) -> list[tuple[int, NotebookNode]]:
    """Return the text cells of written answers, each with its place among all cells."""
    return [(ordinal, cell) for ordinal, cell in enumerate(notebook.cells) if role(cell) == WRITTEN]


def python(cell: NotebookNode) -> str:
    """Return a code cell's source with IPython's own lines turned into Python."""
    return str(TransformerManager().transform_cell(cell.source))


def solution_lines(cell: NotebookNode) -> set[int]:
    """Return the numbers of the lines between the delimiters of a cell's solution, from 1."""
    lines: set[int] = set()
    within = False
    for number, line in enumerate(cell.source.splitlines(), start=1):
        stripped = line.strip()
        if within and stripped != END:
            lines.add(number)
        within = stripped == BEGIN or (within and stripped != END)
    return lines


def place(file: str, notebook: NotebookNode, ordinal: int) -> str:
    """Name a cell for someone who looks for it: the file, the cell's number from 1, its first line."""
    lines = notebook.cells[ordinal].source.strip().splitlines()
    return f"{file}, cell {ordinal + 1} ({lines[0][:50]!r})" if lines else f"{file}, cell {ordinal + 1}"


# --- what may not be wrong with a lesson ---


def lesson_problems(
    notebook: NotebookNode, declared: Collection[str], written: Collection[str] = ()
) -> Iterator[str]:
    """Yield what is wrong with a lesson from `read_lesson`, where in it, and what to do.

    `declared` are the exercises, and `written` the questions, that its plan declares.
    """
    name = notebook.metadata.nao_course.lesson
    file = f"{name}.md"
    for ordinal, cell in code_cells(notebook):
        try:
            tree = ast.parse(python(cell))
        except SyntaxError as error:
            yield f"{place(file, notebook, ordinal)}: line {error.lineno} is not Python: {error.msg}"
            continue
        yield from (
            f"{place(file, notebook, ordinal)}: {problem}" for problem in _cell_problems(cell, tree, declared)
        )
    setups = code_cells(notebook, "setup")
    if len(setups) != 1:
        yield f"{file}: there are {len(setups)} cells with :role: setup; a lesson needs exactly one"
    elif f'lesson("{name}")' not in setups[0][1].source:
        ordinal = setups[0][0]
        yield f'{place(file, notebook, ordinal)}: the set-up says check, hint = lesson("{name}")'
    if len(code_cells(notebook, "payoff")) > 1:
        yield f"{file}: only one cell may have :role: payoff; the lesson opens with its picture"
    exercises = Counter(exercise_name(cell) for _, cell in code_cells(notebook, "exercise"))
    checks = Counter(exercise_name(cell) for _, cell in code_cells(notebook, "check"))
    for what, names in (("exercise", exercises), ("check", checks)):
        for each, count in names.items():
            if count > 1:
                yield f"{file}: {count} cells say :{what}: {each}; a name stands for one"
    for each in declared:
        if not exercises[each]:
            yield f"{file}: exercise {each} is declared but no cell says :exercise: {each}"
        if not checks[each]:
            yield f"{file}: exercise {each} is declared but no cell says :check: {each}"
    answered = [grade_id(cell) for _, cell in written_cells(notebook)]
    if sorted(answered) != sorted(written):
        yield f'{file}: text cells begin with +++ {{"written": NAME}} for {answered}; the plan declares {list(written)}'


def _cell_problems(cell: NotebookNode, tree: ast.Module, declared: Collection[str]) -> Iterator[str]:
    what, name = role(cell), exercise_name(cell)
    if what in ("exercise", "check") and name not in declared:
        yield f"{what} {name} is not declared in solutions/exercises; there are {sorted(declared)}"
    if what == "check" and cell.source != f'check("{name}", {name})':
        yield f'the cell of a check is exactly: check("{name}", {name})'
    delimiters = [line.strip() for line in cell.source.splitlines() if line.strip() in (BEGIN, END)]
    if delimiters != [BEGIN, END] * (len(delimiters) // 2):
        yield f"{BEGIN} and {END} take turns, each alone in its line"
    elif delimiters and what != "exercise":
        yield "a solution stands outside an exercise: say :exercise: NAME"
    elif what == "exercise":
        if not delimiters:
            yield f"an exercise needs its solution between {BEGIN} and {END}"
        if name not in {getattr(statement, "name", "") for statement in tree.body}:
            yield f"exercise {name} defines no function or class of that name"


# --- notebook -> text ---


def write_lesson(notebook: NotebookNode) -> str:
    """Turn a notebook that was edited in JupyterLab into MyST text from which `read_lesson` makes the same cells.

    Outputs do not matter. A LessonError is raised for attachments, metadata of nbgrader's that the course has no word
    for, and lines that MyST would read as something else.
    """
    file = f"{metadata(notebook, 'nao_course').get('lesson', 'lesson')}.ipynb"
    plain = nbformat.v4.new_notebook(metadata=KERNEL | {"jupytext": {"default_lexer": "ipython3"}})
    for ordinal, cell in enumerate(notebook.cells):
        if not cell.source.strip():  # JupyterLab leaves an empty one at the end
            continue
        if cell.get("attachments"):
            raise LessonError(
                f"{place(file, notebook, ordinal)}: a picture was pasted into the cell, which text cannot hold; "
                "save it as solutions/images/NAME.png and write ![what it shows](images/NAME.png)"
            )
        copy = {"cell_type": cell.cell_type, "source": cell.source.strip("\n"), "id": f"cell-{ordinal}"}
        if cell.cell_type == "code":
            copy |= {"outputs": [], "execution_count": None}
        try:
            options = _options(cell)
        except LessonError as error:
            raise LessonError(f"{place(file, notebook, ordinal)}: {error}") from None
        plain.cells.append(nbformat.from_dict(copy | {"metadata": options}))
    body = jupytext.writes(plain, fmt="md:myst").split("---\n", 2)[2]
    again = jupytext.reads(HEADER + body, fmt="md:myst")
    for ordinal, cell in enumerate(plain.cells):
        back = again.cells[ordinal] if ordinal < len(again.cells) else None
        if back is None or any(cell[key] != back[key] for key in ("cell_type", "source", "metadata")):
            raise LessonError(
                f"{place(file, plain, ordinal)}: MyST would read it as another cell; a line of only '+++' or '%%', "
                "an empty text cell or blanks at a line's end may be the reason"
            )
    if len(again.cells) != len(plain.cells):
        raise LessonError(f"{file}: MyST would read {len(again.cells)} cells, it has {len(plain.cells)}")
    return HEADER + body


def _options(cell: NotebookNode) -> dict[str, Any]:
    """Turn a notebook cell's metadata into options of the text; a new code cell is a demonstration."""
    kept = {key: value for key, value in cell.metadata.items() if key not in VOLATILE}
    grading, course = kept.pop("nbgrader", {}), kept.pop("nao_course", {})
    if cell.cell_type != "code":
        if grading.get("grade") and grading.get("solution"):
            return {WRITTEN: grading["grade_id"], **kept}
        if grading.get("grade") or grading.get("solution") or grading.get("task"):
            raise LessonError("a graded text cell is a written answer: nbgrader's manually graded answer")
        return kept
    if any(name in kept for name in OPTIONS):  # written into the cell's metadata by hand
        return kept
    if grading.get("solution") and (grading.get("grade") or grading.get("task")):
        raise LessonError("a cell is an exercise or a check, not both")
    if grading.get("solution"):
        return {"exercise": grading["grade_id"], **kept}
    if grading.get("grade"):
        return {"check": grading["grade_id"].removeprefix("check_"), **kept}
    return {"role": course.get("role", "setup" if grading.get("locked") else "display"), **kept}


def read_notebook(path: Path) -> NotebookNode:
    """Read a notebook; raise a LessonError if the file is not one."""
    try:
        return nbformat.read(path, as_version=4)
    except (ValueError, KeyError, AttributeError, OSError) as error:
        raise LessonError(f"{path.name}: not a notebook ({type(error).__name__}: {error})") from None


def notebook_bytes(notebook: NotebookNode) -> bytes:
    """Return a notebook as the bytes of its file, the same for the same notebook."""
    nbformat.validate(notebook)
    return (nbformat.writes(notebook) + "\n").encode()


def set_points(notebook: NotebookNode, points: Mapping[str, float]) -> None:
    """Write what each exercise and written answer is worth into its cell."""
    for _, cell in [*code_cells(notebook, "check"), *written_cells(notebook)]:
        cell.metadata.nbgrader["points"] = float(points[exercise_name(cell)])
