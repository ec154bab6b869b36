"""The figures of the lessons for slides: 16:9 in large type, and their captions in one Markdown file per lesson.

The lessons' own cells draw them: each solution is run, and what it shows is laid out again for a slide.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import nbformat
import numpy as np
from IPython.core.getipython import get_ipython
from nbclient import NotebookClient
from PIL import Image, ImageOps

from nao_course.instructor.authoring.course import Course
from nao_course.instructor.authoring.execute import environment, run_all_cells
from nao_course.plotting import Drawing, course_style

FOLDER = Path("build", "slides")
MOST = 6  # figures of a lesson, spread evenly over it
PIXELS = (1920, 1080)
# Inches: the smaller a figure is laid out, the larger is its type on the slide. A figure of many panels needs more.
HEIGHTS, SHRUNK = (4.6, 6.4), 0.8
LONGEST = 300  # s, of one cell


def slides_of(course: Course, name: str) -> dict[Path, bytes]:
    """Run the solution of a lesson, and return its slides and captions by their paths under the course's folder."""
    notebook = nbformat.read(course.solutions / f"{name}.ipynb", as_version=4)
    with TemporaryDirectory() as folder:
        first = f"from images.slides import keep_drawings; keep_drawings({folder!r})"
        run = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(first), *notebook.cells])
        where = {"metadata": {"path": str(course.solutions)}}
        client = NotebookClient(run, timeout=LONGEST, kernel_name="python3", resources=where)
        run_all_cells(client, environment(course.root))
        kept = sorted(
            Path(folder).glob("*.png"), key=lambda path: [int(part) for part in path.stem.split("_")]
        )
        chosen = spread(kept)
        files, lines = {}, [f"# {_title(notebook)}"]
        headings = headings_of(notebook)
        for number, path in enumerate(chosen, start=1):
            alt = json.loads(path.with_suffix(".json").read_text(encoding="utf-8"))
            slide = f"{name[:2]}_{number}.png"
            files[FOLDER / slide] = path.read_bytes()
            # The cell that keeps the drawings was the first one.
            heading = headings[int(path.stem.split("_")[0]) - 2]
            lines += [f"## {heading}", f"![{alt}]({slide})", alt]
    files[FOLDER / f"{name}.md"] = ("\n\n".join(lines) + "\n").encode()
    return files


def spread(paths: Sequence[Path], most: int = MOST) -> list[Path]:
    """Return at most `most` of some paths: the first, the last, and others evenly between them."""
    if len(paths) <= most:
        return list(paths)
    return [paths[i] for i in np.rint(np.linspace(0, len(paths) - 1, most)).astype(int)]


def headings_of(notebook: Mapping[str, Any]) -> list[str]:
    """Return for each code cell of a notebook the last heading above it."""
    heading, found = "", []
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            found.append(heading)
            continue
        heading = next(
            (line.lstrip("# ") for line in reversed(cell["source"].splitlines()) if line.startswith("#")),
            heading,
        )
    return found


def _title(notebook: Mapping[str, Any]) -> str:
    texts = (cell["source"] for cell in notebook["cells"] if cell["cell_type"] == "markdown")
    return next(line[2:] for text in texts for line in text.splitlines() if line.startswith("# "))


# --- in the lesson's kernel ---


def keep_drawings(folder: str) -> None:
    """Write each drawing that a cell shows from now on into a folder, as a slide and with its alt text."""
    shown = Drawing._repr_html_
    numbers: dict[int, int] = {}

    def keep(drawing: Drawing) -> str:
        html = shown(drawing)  # before the layout changes
        shell: Any = get_ipython()
        cell = len(shell.user_ns["In"]) - 1
        numbers[cell] = numbers.get(cell, 0) + 1
        path = Path(folder, f"{cell}_{numbers[cell]}")
        path.with_suffix(".png").write_bytes(as_slide(drawing))
        path.with_suffix(".json").write_text(json.dumps(drawing.alt), encoding="utf-8")
        return html

    Drawing._repr_html_ = keep  # type: ignore[method-assign, assignment]


def as_slide(drawing: Drawing) -> bytes:
    """Return a drawing as a PNG of `PIXELS`; its figure keeps the slide's layout."""
    figure, (width, height) = drawing.figure, PIXELS
    inches = float(np.clip(np.sqrt(SHRUNK * np.prod(figure.get_size_inches()) * height / width), *HEIGHTS))
    buffer = io.BytesIO()
    with course_style():
        figure.set_size_inches(inches * width / height, inches)
        figure.set_layout_engine("constrained")
        # A title may be wider than its axes, so the page is fitted to what is drawn.
        figure.savefig(buffer, format="png", dpi=height / inches, bbox_inches="tight")
    with Image.open(buffer) as drawn:
        fitted = ImageOps.pad(drawn.convert("RGB"), PIXELS, color="white")
    buffer = io.BytesIO()
    fitted.save(buffer, "png")
    return buffer.getvalue()
