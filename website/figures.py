"""Figures of the solutions and films, which a lesson's page shows because it does not run code."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from nao_course.films import film_html, recorded_film

__all__ = ["add_figures", "add_films"]

SHOWN = ("display", "example", "payoff")  # roles of the cells that draw something and hold no solution
_PICTURE = re.compile(r'<img alt="[^"<>]*"[^<>]* src="data:image/(?:png|jpeg);base64,[A-Za-z0-9+/=]+">')
# Where the film of a lesson stands: below its opening picture, or in the output of the cell that begins so.
OPENING = "opening"
FILMS: Mapping[str, Mapping[str, str]] = {
    "07_ekf_slam": {OPENING: "07_ekf_slam", "FilmPanel(": "07_ekf_slam"},
    "08_graph_slam": {OPENING: "08_graph_slam"},
    "09_pose_graphs": {OPENING: "09_pose_graphs"},
    "11_slam_on_the_field": {OPENING: "11_slam_on_the_field"},
    "12_beyond": {"ExplorePanel(": "12_beyond", "try_out(lambda: draw_finding(": "12_particles"},
}


def add_figures(student: dict[str, Any], solved: Mapping[str, Any]) -> None:
    """Show in a student copy the figures that the solution notebook's cells have drawn.

    Only pictures are taken, and only from cells that are the same in both notebooks: nothing else of a solution's
    outputs reaches the page.

    Parameters
    ----------
    student : dict
        The student copy, a notebook without outputs; it is changed.
    solved : mapping
        The executed solution notebook of the same lesson.
    """
    drawn = {cell["id"]: cell for cell in solved["cells"] if cell["cell_type"] == "code"}
    for cell in student["cells"]:
        other = drawn.get(cell["id"])
        if other is None or not _draws(cell) or "".join(cell["source"]) != "".join(other["source"]):
            continue
        pictures = [picture for output in other["outputs"] for picture in _pictures(output)]
        if pictures:
            cell["outputs"] = [_html("".join(pictures))]


def add_films(notebook: dict[str, Any], lesson: str) -> None:
    """Put the recorded films of a lesson into its notebook, which is changed."""
    for where, name in FILMS.get(lesson, {}).items():
        film = film_html(recorded_film(name))
        if where == OPENING:
            cell, line = _opening(notebook, lesson)
            replaces = film.replace('class="', 'class="nao-film-replaces ', 1)
            cell["source"] = "".join(cell["source"]).replace(line, f"{line}\n\n{replaces}", 1)
            continue
        found = [cell for cell in notebook["cells"] if "".join(cell["source"]).startswith(where)]
        if not found:
            raise ValueError(
                f"{lesson} has no cell that begins with {where!r}, where the film {name} should stand"
            )
        found[-1]["outputs"] = [_html(film)]


def _draws(cell: Mapping[str, Any]) -> bool:
    metadata = cell["metadata"]
    has_solution = metadata.get("nbgrader", {}).get("solution", False)
    return (
        cell["cell_type"] == "code"
        and metadata.get("nao_course", {}).get("role") in SHOWN
        and not has_solution
    )


def _pictures(output: Mapping[str, Any]) -> list[str]:
    return _PICTURE.findall("".join(output.get("data", {}).get("text/html", "")))


def _html(text: str) -> dict[str, Any]:
    return {"output_type": "display_data", "data": {"text/html": text}, "metadata": {}}


def _opening(notebook: Mapping[str, Any], lesson: str) -> tuple[dict[str, Any], str]:
    """Return the cell and the line of a lesson's opening picture."""
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            for line in "".join(cell["source"]).splitlines():
                if f"](images/{lesson[:2]}_payoff." in line:
                    return cell, line
    raise ValueError(f"{lesson} has no opening picture, below which its film should stand")
