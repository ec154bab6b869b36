"""What each edition of the pages holds: the lessons and docs for students, or solutions and docs for instructors."""

import inspect
import json
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from nao_course.films import film_html, recorded_film
from nao_course.instructor.authoring.course import Course
from website import ROOT
from website.cards import cards
from website.figures import add_figures, add_films, save_pictures
from website.lessons import Lesson, read_lesson
from website.rubrics import rubrics_page

__all__ = ["EDITIONS", "PACKAGES", "Edition", "gather"]

# What the reference describes, in the order in which one meets it.
PACKAGES = (
    "student",
    "sim",
    "plotting",
    "widgets",
    "exercises",
    "geometry",
    "slam",
    "datasets",
    "challenges",
)

BESIDE = "beside"  # the folder of files that Sphinx lays beside the pages as they are
# The first page plays the demo's film where odometry drifts from 0.64 to 1.1 m and both estimates stay within 3 cm.
TELLING = {"start": 78, "plays": True, "pace": 8}
RUBRICS = "rubrics"  # the page that is made from the declarations
PITCH = (
    "A NAO robot stands somewhere on half a football field, with a camera, a record of its steps and no map. "
    "In these notebooks you write the code that finds the lines and goal posts in its pictures, estimates "
    "where it is, and draws the map."
)


@dataclass(frozen=True)
class Edition:
    """The sources of one kind of reader's pages: the folder of its notebooks, its pages of docs/, and a welcome."""

    name: str
    lessons: str
    docs: tuple[str, ...]
    welcome: str

    @property
    def has_solutions(self) -> bool:
        """Whether it is for instructors only."""
        return self.lessons == "solutions"


EDITIONS = {
    each.name: each
    for each in (
        Edition(
            "student",
            "notebooks",
            ("for_students", "for_language_models", "accessibility", "notation", "real_data", "pictures"),
            "Read the lessons here, and work on them in JupyterLab: [how to start](docs/for_students.md).",
        ),
        Edition(
            "instructor",
            "solutions",
            (
                "teach_the_course",
                "syllabus",
                "grade_a_class",
                "what_is_protected",
                "write_a_lesson",
                "write_an_exercise",
                "write_a_panel",
                "write_a_challenge",
                "notation",
                "for_students",
                "for_language_models",
                "accessibility",
                "setup",
                "run_a_hub",
                "design",
                "own_field",
                "real_robot",
                "real_data",
                "pictures",
                "dependencies",
                "performance",
                "results",
            ),
            "**With all solutions: for instructors only.** Begin with [the guide](docs/teach_the_course.md).",
        ),
    )
}


def gather(edition: Edition, course: Course, names: Sequence[str], folder: Path) -> None:
    """Write an edition's sources into a folder that does not exist yet, as Sphinx reads them."""
    lessons = folder / "lessons"
    pictures = folder / BESIDE / "lessons" / "figures"
    pictures.mkdir(parents=True)
    shutil.copytree(ROOT / edition.lessons / "images", lessons / "images")
    for name in names:
        notebook = _read(ROOT / edition.lessons / f"{name}.ipynb")
        if not edition.has_solutions:
            add_figures(notebook, _read(ROOT / "solutions" / f"{name}.ipynb"))
        add_films(notebook, name)
        save_pictures(notebook, lessons / "images", pictures)
        _fold(notebook)
        (lessons / f"{name}.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
    shutil.copytree(ROOT / "images", folder / "images", ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    (folder / "docs").mkdir()
    for page in edition.docs:
        text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
        text = text.replace("](../solutions/images/", "](../lessons/images/")  # where an edition has them
        (folder / "docs" / f"{page}.md").write_text(text, encoding="utf-8")
    (folder / "reference").mkdir()
    for package in PACKAGES:
        (folder / "reference" / f"{package}.rst").write_text(_reference(package), encoding="utf-8")
    read = [read_lesson(ROOT / "notebooks" / f"{name}.ipynb") for name in names]
    index = _index(edition, read, course.title, cards(read, folder / "cards"))
    (folder / "index.md").write_text(index, encoding="utf-8")
    if edition.has_solutions:
        questions = ((lesson, each) for lesson in read for each in course.plan(lesson.name).written)
        (folder / "docs" / f"{RUBRICS}.md").write_text(rubrics_page(questions), encoding="utf-8")


def _read(path: Path) -> dict[str, Any]:
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return notebook


def _fold(notebook: dict[str, Any]) -> None:
    """Fold on the page the cells that are folded in JupyterLab."""
    for cell in notebook["cells"]:
        if cell["metadata"].get("jupyter", {}).get("source_hidden"):
            cell["metadata"].setdefault("tags", []).append("hide-input")


def _index(edition: Edition, lessons: Sequence[Lesson], title: str, shown: str) -> str:
    """Return the first page: the title, what the course is, the film of the demo, the cards, and the menu."""
    shelves = {
        "Lessons": [f"{each.number} {each.title} <lessons/{each.name}>" for each in lessons],
        "Read": [f"docs/{page}" for page in (*edition.docs, *[RUBRICS] * edition.has_solutions)],
        "Reference": [f"reference/{package}" for package in PACKAGES],
    }
    menus = [
        "\n".join(["```{toctree}", ":hidden:", f":caption: {shelf}", "", *pages, "```"])
        for shelf, pages in shelves.items()
    ]
    film = film_html(recorded_film("demo") | TELLING)
    return "\n\n".join([f"# {title}", PITCH, edition.welcome, film, shown, *menus]) + "\n"


def _reference(package: str) -> str:
    """The page of a package: a table of what it offers, its constants by name, then each in full."""
    name = f"nao_course.{package}"
    module = import_module(name)
    directives = {each: _directive(each, getattr(module, each)) for each in module.__all__}
    constants = ", ".join(f"``{each}``" for each, directive in directives.items() if not directive)
    documented = {each: directive for each, directive in directives.items() if directive}
    return "\n".join(
        [
            *(name, "=" * len(name), "", f".. automodule:: {name}", "   :no-members:", ""),
            *(f".. currentmodule:: {name}", "", ".. autosummary::", "   :nosignatures:", ""),
            *(f"   {each}" for each in documented),
            *(["", f"Constants and types: {constants}."] if constants else []),
            *documented.values(),
        ]
    )


def _directive(name: str, value: object) -> str:
    """What makes autodoc describe a public name; nothing for a constant, which has no docstring of its own."""
    if inspect.isclass(value):
        return f"\n.. autoclass:: {name}\n   :members:"
    return f"\n.. autofunction:: {name}" if inspect.isroutine(value) else ""
