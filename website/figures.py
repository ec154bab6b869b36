"""Figures of the solutions and films, which a lesson's page shows because it does not run code."""

import re
from base64 import b64decode
from collections.abc import Mapping
from hashlib import sha256
from html import escape
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
_OPENING = re.compile(r"^!\[([^]]+)\]\(images/([\w.]+\.(?:png|jpeg))\)$", re.MULTILINE)
PHOTO_QUALITY = 72  # of 100: a photograph of 320 x 240 pixels cannot be distinguished from the notebook's
COLOURS = (
    64  # of a drawing: each of its 256 colours changes by less than a tenth of the range, and most by nothing
)
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


def save_pictures(notebook: dict[str, Any], images: Path, folder: Path) -> None:
    """Save the pictures of a notebook's outputs and texts into a folder beside its page.

    The notebook is changed. Drawings keep every pixel, but fewer colours; photographs are compressed. A browser loads
    each when it comes into view. A figure that is also the lesson's opening picture, a file of `images`, is saved once.
    """
    files = {path.name: path.read_bytes() for path in images.iterdir()}
    names = {content: name for name, content in files.items()}

    def saved(content: bytes, kind: str) -> str:
        return _saved(content, names.get(content) or sha256(content).hexdigest()[:16], kind, folder)

    def opening(found: re.Match[str]) -> str:
        source = saved(files[found[2]], found[2].rpartition(".")[2])
        return f'<p><img alt="{escape(found[1])}" {source}></p>'

    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            cell["source"] = _OPENING.sub(opening, "".join(cell["source"]))
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            if "text/html" in data:
                data["text/html"] = _DATA.sub(
                    lambda found: saved(b64decode(found[2]), found[1]), "".join(data["text/html"])
                )


def _saved(content: bytes, name: str, kind: str, folder: Path) -> str:
    """Save a picture, "png" or "jpeg", under a name, and return the attributes that show it."""
    path = folder / f"{name}.webp"
    if not path.exists():
        with Image.open(BytesIO(content)) as picture:
            if kind == "png":
                fewer = picture.convert("RGB").quantize(COLOURS, Image.Quantize.MAXCOVERAGE)
                fewer.save(path, lossless=True)
            else:
                picture.save(path, quality=PHOTO_QUALITY)
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
