"""Figures of the solutions and films, which a lesson's page shows because it does not run code."""

from __future__ import annotations

import re
from base64 import b64decode
from collections.abc import Mapping
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from typing import Any

from PIL import Image

from nao_course.films import film_html, recorded_film

__all__ = ["add_figures", "add_films", "save_pictures"]

SHOWN = ("display", "example", "payoff")  # roles of the cells that draw something and hold no solution
_IMAGE = (
    r'<img(?: class="[\w -]+")? alt="[^"<>]*"[^<>]* src="data:image/(?:png|jpeg);base64,[A-Za-z0-9+/=]+">'
)
# On a dark page, what is around the photographs of a figure is inverted.
_AROUND = r'<span class="nao-around" style="clip-path: polygon\([a-z0-9.,% ]+\)"></span>'
_PICTURE = re.compile(rf'<div class="nao-photos">{_IMAGE}{_AROUND}</div>|{_IMAGE}')
_DATA = re.compile(r'src="data:image/(png|jpeg);base64,([A-Za-z0-9+/=]+)"')
PHOTO_QUALITY = 82  # of 100: a photograph of 320 x 240 pixels is not to be told apart from the notebook's
# The film of a lesson stands below the figure, if there is one, of the first cell with this line.
FILMS: Mapping[str, Mapping[str, str]] = {
    "07_ekf_slam": {"tools.FilmPanel(init_landmarks, predict, update)": "07_ekf_slam"},
    "08_graph_slam": {
        "tools.GraphPanel(add_initial_position, add_relative_motion, add_relative_measurement, solve)": "08_graph_slam"
    },
    "09_pose_graphs": {"tools.RelaxPanel()": "09_pose_graphs"},
    "11_slam_on_the_field": {
        "check.payoff(tools.draw_drives, measure=measure, EkfSlam=EkfSlam, GraphSlam=GraphSlam)": "11_slam_on_the_field"
    },
    "12_beyond": {
        "tools.ExplorePanel(find_frontiers, travel_steps)": "12_beyond",
        'try_out(lambda: tools.draw_finding(weigh, resample), "Finish exercises 12.1 and 12.2 to see it.")': (
            "12_particles"
        ),
    },
}


def add_figures(student: dict[str, Any], solved: Mapping[str, Any]) -> None:
    """Show in a student copy the figures that the solution notebook's cells have drawn.

    Only pictures are taken, and only from cells that are the same in both notebooks: nothing else of a solution's
    outputs reaches the page.
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
    for line, name in FILMS.get(lesson, {}).items():
        found = [cell for cell in notebook["cells"] if line in "".join(cell["source"]).splitlines()]
        if not found:
            raise ValueError(
                f"{lesson} has no cell with the line {line!r}, where the film {name} should stand"
            )
        kept = [] if "Panel(" in line else found[0]["outputs"]  # a film replaces the picture of a panel
        found[0]["outputs"] = [*kept, _html(film_html(recorded_film(name)))]


def save_pictures(notebook: dict[str, Any], folder: Path) -> None:
    """Save the pictures that a notebook's outputs hold as text into a folder beside its page.

    The notebook is changed. Drawings keep every pixel, photographs are compressed; a browser loads each when it comes
    into view.
    """
    for cell in notebook["cells"]:
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            if "text/html" in data:
                data["text/html"] = _DATA.sub(lambda found: _saved(found, folder), "".join(data["text/html"]))


def _saved(found: re.Match[str], folder: Path) -> str:
    """Save a picture under the name of its bytes, and return the attribute that shows it."""
    content = b64decode(found[2])
    path = folder / f"{sha256(content).hexdigest()[:16]}.webp"
    if not path.exists():
        with Image.open(BytesIO(content)) as picture:
            picture.save(path, lossless=found[1] == "png", quality=PHOTO_QUALITY)
    return f'loading="lazy" src="{folder.name}/{path.name}"'


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
