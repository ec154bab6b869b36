"""What a lesson's student notebook says of it: its title, its goal, how long it takes, what its parts are worth."""

import json
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from nao_course.instructor.authoring.course import ABOUT
from website import ROOT

__all__ = ["Lesson", "read_lesson"]

_KEYS = ("does", "can", "left_out")
_CARD_KEYS = ("card", "card_shows")  # of a lesson that opens with a figure


@dataclass(frozen=True)
class Lesson:
    """A lesson, such as ``01_hsl_filtering``, as its student copy describes it.

    Its goal is the paragraph below the title, its picture the figure that it opens with if there is one, and `needs`
    its prerequisites, all in Markdown. `minutes` are for the first part and `later` for the second, 0 without one;
    `points` are of all its checks and written answers, `written` of the latter, and `takes` are the numbers of lessons
    whose functions it uses. `about` is its part of `solutions/lessons.toml`.
    """

    name: str
    title: str
    goal: str
    picture: str
    needs: str
    minutes: int
    later: int
    points: float
    written: float
    takes: tuple[str, ...]
    about: Mapping[str, Any] = field(default_factory=dict, hash=False)

    @property
    def figure(self) -> str:
        """Path of the figure that it opens with, from its notebook."""
        return self.picture.rpartition("](")[2].rstrip(")")

    @property
    def number(self) -> str:
        """Its number, two digits."""
        return self.name.split("_")[0]


def read_lesson(path: Path) -> Lesson:
    """Read a lesson's student copy, and what the course says about it.

    Raise a ValueError if the copy lacks a title, a goal, prerequisites or its time, or the course says nothing.
    """
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    text, code = (_joined(cells, kind) for kind in ("markdown", "code"))
    said = {
        "title": r"^# (.+)$",
        "goal": r"^# .+\n+((?:.+\n?)+)",
        "needs": r"\*\*Before you start\*\* you need (.+?)\.(?= [A-Z*])",
        "minutes": r"\*\*Time:\*\* (\d+) minutes",
    }
    second = re.search(r"\*\*Time:\*\* \d+ minutes up to .+?, and (\d+) minutes for the ", text)
    found = {key: re.search(pattern, text, re.MULTILINE) for key, pattern in said.items()}
    missing = [key for key, match in found.items() if match is None]
    if missing:
        raise ValueError(f"{path.name} does not say its {', '.join(missing)}")
    words = {key: match[1] for key, match in found.items() if match is not None}
    picture = re.search(r"^!\[[^]]+\]\(images/\d\d_payoff\.\w+\)$", text, re.MULTILINE)
    return Lesson(
        path.stem,
        words["title"],
        " ".join(words["goal"].split()),
        picture[0] if picture else "",
        words["needs"],
        int(words["minutes"]),
        int(second[1]) if second else 0,
        points=sum(map(_points, cells)),
        written=sum(_points(cell) for cell in cells if cell["cell_type"] == "markdown"),
        takes=tuple(sorted(set(re.findall(r'\bearlier\("(\d\d):', code)))),
        about=_about(path.stem.split("_")[0], (*_KEYS, *_CARD_KEYS * bool(picture))),
    )


def _about(number: str, keys: Sequence[str] = _KEYS) -> dict[str, Any]:
    """Return what the course says about a lesson; a lesson that is new has TODO in it."""
    file = ROOT / "solutions" / ABOUT
    found: dict[str, Any] = tomllib.loads(file.read_text(encoding="utf-8")).get(number, {})
    missing = [key for key in keys if key not in found]
    if missing:
        raise ValueError(f'solutions/{ABOUT} does not say {", ".join(missing)} under ["{number}"]')
    return found


def _joined(cells: list[dict[str, Any]], kind: str) -> str:
    return "\n\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == kind)


def _points(cell: dict[str, Any]) -> float:
    """Return the points that nbgrader counts for a cell."""
    return float(cell["metadata"].get("nbgrader", {}).get("points", 0))
