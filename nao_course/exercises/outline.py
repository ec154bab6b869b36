"""The cells of a lesson's notebook as it was released, by which a student's copy is read without its metadata."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from importlib import resources
from importlib.resources.abc import Traversable
from typing import Any, NamedTuple

from nao_course.exercises.cells import grade_id, source_of, stated_role

FOLDER = "outlines"
_NAME = re.compile(r"\d\d_\w+", re.ASCII)


class ReleasedCell(NamedTuple):
    """A cell of the released notebook: its type, role and name, its id, and the digest of its text."""

    kind: str
    role: str
    name: str
    id: str
    digest: str


@dataclass(frozen=True)
class Outline:
    """The cells of a released notebook in their order; of an unknown lesson there are none."""

    cells: tuple[ReleasedCell, ...] = ()

    @cached_property
    def exercises(self) -> frozenset[str]:
        """The names of the exercises."""
        return frozenset(each.name for each in self.cells if each.role == "solution")

    @cached_property
    def questions(self) -> dict[str, int]:
        """The indices of the cells for written answers, by the name of the question."""
        return {each.name: at for at, each in enumerate(self.cells) if each.role == "written"}

    @cached_property
    def _by_name(self) -> dict[str, int]:
        return {each.name: at for at, each in enumerate(self.cells) if each.name}

    @cached_property
    def _by_id(self) -> dict[str, int]:
        return {each.id: at for at, each in enumerate(self.cells)}

    @cached_property
    def _by_digest(self) -> dict[str, list[int]]:
        found: dict[str, list[int]] = {}
        for at, each in enumerate(self.cells):
            found.setdefault(each.digest, []).append(at)
        return found

    def places(self, cells: Iterable[Mapping[str, Any]]) -> list[int]:
        """Return the index of the released cell that each cell of a notebook was; -1 for a cell that was added.

        A cell is found by its name for nbgrader, by its id, or by its text. Of several released cells with the same
        text, it is the next one in the notebook's order.
        """
        found, last = list[int](), -1
        for cell in cells:
            at = self._by_name.get(grade_id(cell), self._by_id.get(str(cell.get("id")), -1))
            if at < 0 and (text := source_of(cell)) and (same := self._by_digest.get(digest(text))):
                at = next((each for each in same if each > last), same[0])
            found.append(at)
            last = at if at >= 0 else last
        return found

    def is_released(self, text: str) -> bool:
        """Return whether a cell of the released notebook has this text."""
        return digest(text) in self._by_digest

    def role(self, cell: Mapping[str, Any], at: int) -> str:
        """Return the role of a code cell that was the released cell at an index, or was added, at -1.

        It is "solution", "student" for a cell that was added, or one of `cells.GIVEN`. A cell that was released with
        one of these and has another text now is "edited".
        """
        role = stated_role(cell) or (self.cells[at].role if at >= 0 else "") or "student"
        keeps = role in ("solution", "student", "written") or not self.cells
        return role if keeps or self.is_released(source_of(cell)) else "edited"


def digest(text: str) -> str:
    """Return the digest of a cell's text, which does not depend on its blanks and line ends."""
    return hashlib.sha256(" ".join(text.split()).encode("utf-8", "replace")).hexdigest()[:16]


def outline_bytes(cells: Sequence[Mapping[str, Any]]) -> bytes:
    """Return the bytes of the file that describes a released notebook's cells."""
    rows = (
        json.dumps(
            [
                cell["cell_type"],
                stated_role(cell),
                grade_id(cell),
                str(cell.get("id", "")),
                digest(source_of(cell)),
            ]
        )
        for cell in cells
    )
    return ("[\n" + ",\n".join(rows) + "\n]\n").encode()


UNKNOWN = Outline()  # of a lesson that is not known


@lru_cache(maxsize=32)
def read_outline(name: str) -> Outline:
    """Return the outline of the lesson that a notebook's name begins with; of an unknown lesson it is empty.

    >>> len(read_outline("01_hsl_filtering (1)").exercises), len(read_outline("notes").exercises)
    (6, 0)
    """
    lesson = _NAME.match(name)
    file = _folder() / f"{lesson[0] if lesson else ''}.json"
    if not file.is_file():
        return UNKNOWN
    return Outline(tuple(ReleasedCell(*row) for row in json.loads(file.read_text(encoding="utf-8"))))


def read_all_outlines() -> None:
    """Read the outlines of all lessons, so that processes that are forked need not do it."""
    for file in _folder().iterdir():
        read_outline(file.name.removesuffix(".json"))


def _folder() -> Traversable:
    return resources.files("nao_course.exercises") / FOLDER
