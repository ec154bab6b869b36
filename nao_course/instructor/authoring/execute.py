"""Running a lesson from top to bottom, so that its outputs are the same each time."""

import asyncio
import hashlib
import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import version
from pathlib import Path
from subprocess import DEVNULL

import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError, CellTimeoutError
from nbformat import NotebookNode

from nao_course._internal.single_threaded import SINGLE_THREADED
from nao_course.exercises import lesson_names
from nao_course.exercises.notebook_text import read_cells
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import LessonError
from nao_course.instructor.authoring.plans import CHECKS, OUTLINES

LARGEST = 1_000_000  # bytes of an executed notebook
TRIES = 3  # to start a kernel
LONGEST = 60  # seconds that a whole lesson may run; a single cell gets as much
_RUN = ("ipykernel", "ipywidgets", "matplotlib", "numpy", "opencv-python-headless", "scipy", "sympy")
_ADDRESS = re.compile(r"0x[0-9a-f]{7,16}\b")
_WIDGET = "application/vnd.jupyter.widget-view+json"

Tell = Callable[[str, str], None]


def execute_all(
    solved: Mapping[str, NotebookNode], stage: Path, tell: Tell
) -> Iterator[tuple[str, NotebookNode]]:
    """Run all lessons, a few at a time, and report all their errors at the end."""

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
    """Return a lesson with outputs, run from top to bottom in `solutions` under the root of the library it imports.

    The outputs are the same at each run on one machine: what differs from run to run is left out. A LessonError is
    raised if a cell fails, warns, takes too long, or shows what will differ next time.
    """
    notebook = nbformat.from_dict(solved)
    file = f"{solved.metadata.nao_course.lesson}.md"
    _run(notebook, file, root)
    notebook.metadata = solved.metadata
    problems: list[str] = []
    for ordinal, cell in lesson_text.code_cells(notebook):
        where = lesson_text.place(file, notebook, ordinal)
        cell["outputs"] = [kept for output in cell.outputs if (kept := _tidy(output))]
        problems += [
            f"{where}: {problem}" for output in cell.outputs for problem in _output_problems(output, root)
        ]
    size = len(lesson_text.notebook_bytes(notebook))
    if size > LARGEST:
        problems.append(f"{file}: {size / 1e6:.1f} MB when it has run; {LARGEST / 1e6:.0f} MB is the most")
    if problems:
        raise LessonError("\n".join(problems))
    return notebook


def runs_with(name: str, root: Path) -> str:
    """Hash all that the outputs of a lesson depend on besides its own cells, under the root of the library it imports.

    These are the library and the check data, without what belongs to later lessons; the code of the lessons
    before it; and the versions of Python and of what computes and draws.
    """
    solutions = sorted((root / "solutions").glob(f"{lesson_names.PATTERN}.ipynb"))
    later = [path.stem for path in solutions if path.stem > name]
    apart = [OUTLINES, Path("nao_course", "instructor")]
    apart += [CHECKS / f"{each}.bin" for each in later]
    apart += [Path("nao_course", "lessons", each.partition("_")[2]) for each in later]
    files = (
        path for path in sorted((root / "nao_course").rglob("*")) if path.is_file() and path.suffix != ".pyc"
    )
    library = {path.relative_to(root): path for path in files}
    parts = {
        "library": {
            each.as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
            for each, path in library.items()
            if not any(each.is_relative_to(folder) for folder in apart)
        },
        "solutions": {path.stem: read_cells(path) for path in solutions if path.stem < name},
        "versions": [sys.version, *map(version, _RUN)],
    }
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def _run(notebook: NotebookNode, file: str, root: Path) -> None:
    """Run all cells in a kernel of their own; what stops them is said with its cell."""
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
        run_all_cells(client, environment(root))
    except CellTimeoutError:
        raise LessonError(f"{file}: a cell ran for more than {LONGEST} s") from None
    except CellExecutionError as error:
        where = lesson_text.place(file, notebook, _failed_cell(notebook))
        raise LessonError(f"{where}: {error.ename}: {error.evalue}") from None


def run_all_cells(client: NotebookClient, variables: Mapping[str, str]) -> None:
    """Run a client's notebook with this environment; `NotebookClient.execute` would leave its event loop open."""
    with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:
        for tries_left in reversed(range(TRIES)):
            try:
                # The kernel's own log goes nowhere; what a cell writes is an output.
                runner.run(client.async_execute(env=dict(variables), stderr=DEVNULL))
                return
            except RuntimeError as problem:
                # Another program may have taken one of the ports that were free when the kernel began.
                if not (tries_left and "before replying to kernel_info" in str(problem)):
                    raise


def _failed_cell(notebook: NotebookNode) -> int:
    """Return the place of the cell that shows an error."""
    return next(
        ordinal
        for ordinal, cell in enumerate(notebook.cells)
        if any(output.output_type == "error" for output in cell.get("outputs", ()))
    )


def environment(root: Path) -> dict[str, str]:
    """Return the environment in which a lesson's checks are strict and its numbers the same each time."""
    return {
        **os.environ,
        "PYTHONPATH": str(root),
        "PYTHONHASHSEED": "0",
        "MPLBACKEND": "module://matplotlib_inline.backend_inline",
        "NAO_COURSE_STRICT": "1",
        "NAO_COURSE_NOTEBOOKS": str(root / "solutions"),
        "NAO_COURSE_DATA": "none",  # a lesson is built without recorded data, on every machine
        **SINGLE_THREADED,
    }


def _tidy(output: NotebookNode) -> NotebookNode | None:
    """Take a widget's identity out of an output; nothing may be left of it."""
    if "data" in output:
        output["data"].pop(_WIDGET, None)
        if not output["data"]:
            return None
    return output


def _output_problems(output: NotebookNode, root: Path) -> Iterator[str]:
    """Return the part of an output that would be red, or would differ at the next run."""
    if output.get("name") == "stderr":
        yield f"it warns: {output.text.strip().splitlines()[-1][:200]}"
    shown = [output.get("text", ""), *(str(each) for each in output.get("data", {}).values())]
    text = "\n".join(each for each in shown if len(each) < 100_000)
    if match := _ADDRESS.search(text):
        yield f"it shows an address, {match.group()}, which differs at each run; end the last line with a semicolon"
    if any(str(path) in text for path in (root, Path.home(), Path(sys.prefix))):
        yield "it shows a path of this machine"
