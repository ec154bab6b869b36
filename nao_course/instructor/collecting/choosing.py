"""Which notebooks of one student and lesson can be read, and which of them are answered."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from nao_course.exercises.answered import count_answers, sources
from nao_course.exercises.notebook_text import MOST_BYTES
from nao_course.instructor.collecting.archives import LARGEST_READ, Item, Refused
from nao_course.instructor.sandbox.large_notebooks import without_outputs
from nao_course.instructor.sandbox.layers import SandboxError
from nao_course.instructor.sandbox.protocol import Allowance, Ended, ServerEnded

BLANK = "nothing in it is answered"


@dataclass(frozen=True)
class Inspection:
    """Whether a notebook can be read, and how much of it is answered.

    Parameters
    ----------
    problem : str
        Why it cannot be read, or that nothing in it is answered; empty for an answered notebook.
    answers : int
        Number of cells that answer an exercise or a question; -1 if the notebook cannot be read.
    digest : str
        SHA-256 of the content, so that equal notebooks are recognised whatever they are called.
    """

    problem: str = ""
    answers: int = 0
    digest: str = ""

    @property
    def rank(self) -> int:
        """0 for an unreadable notebook, 1 for one without an answer, 2 for any other."""
        return 0 if self.answers < 0 else 1 if self.answers == 0 else 2


NOT_INSPECTED = Inspection("", 1)


def inspect_notebook(item: Item, lesson: str, released: Path | None) -> Inspection:
    """Read a notebook of a student and count its answers; none of its code runs.

    A large notebook is parsed by a process of its own, because that takes several times its size in memory.

    Parameters
    ----------
    item : Item
        The notebook.
    lesson : str
        Name of the lesson.
    released : Path, optional
        Folder of the released notebooks.
    """
    file = f"{lesson}.ipynb"
    try:
        content = item.content(MOST_BYTES)
        short = content if len(content) <= LARGEST_READ else _shortened(file, content)
        answers = count_answers(file, short, _released(released / file) if released else ())
    except (Refused, ValueError) as error:
        return Inspection(str(error), -1)
    return Inspection("" if answers else BLANK, answers, hashlib.sha256(content).hexdigest())


@cache
def _released(path: Path) -> frozenset[str]:
    """Return the texts of the cells of a released notebook; nothing without a notebook."""
    return sources(path.name, path.read_bytes()) if path.is_file() else frozenset()


def _shortened(file: str, content: bytes) -> bytes:
    """Return a large notebook without its outputs."""

    def parts() -> Iterator[bytes]:
        for start in range(0, len(content), 2**20):
            yield content[start : start + 2**20]

    try:
        return without_outputs(file, len(content), parts(), None, Allowance())
    except Ended as ended:
        raise Refused(ended.outcome.text) from None
    except (SandboxError, ServerEnded) as error:
        raise Refused(str(error)) from None
