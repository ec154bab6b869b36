"""A student's personal world: seeds and parameters that follow from the student's name."""

from __future__ import annotations

import hashlib
import json
import os
import unicodedata
from dataclasses import dataclass
from pathlib import Path

import numpy as np

STAMP = "student.json"  # in the folder `release` of a student's copy
FOLDER = "release"
_HUB_USER = "JUPYTERHUB_USER"  # environment variable of a JupyterHub
_PARENTS = 3  # folders above the notebooks in which the stamp is looked for
EXAMPLE = "the course's example"


@dataclass(frozen=True)
class PersonalWorld:
    """The source of a student's own data.

    Its name is as in the gradebook, and empty for the example world of the course.
    """

    student: str = ""

    def seed(self, purpose: str) -> int:
        """Return a seed that depends on the student and the purpose, 0 to 2**32 - 1.

        Upper and lower case, accents' encodings and spaces around the name make no difference.

        >>> PersonalWorld("ada").seed("drives") == PersonalWorld(" Ada").seed("drives")
        True
        """
        name = unicodedata.normalize("NFKC", self.student).casefold().strip()
        return int.from_bytes(hashlib.sha256(f"{name}\0{purpose}".encode()).digest()[:4], "little")

    def rng(self, purpose: str) -> np.random.Generator:
        """Return a random generator that depends on the student and the purpose."""
        return np.random.default_rng(self.seed(purpose))

    def __str__(self) -> str:
        """Return the student's name, or what stands for it in the example world."""
        return self.student.strip() or EXAMPLE


def personal_world(folder: str | Path | None = None) -> PersonalWorld:
    """Return the world of the student to whom this copy of the course belongs.

    The name is in the file ``release/student.json`` of the student's copy (see ``nao-course release --students``). On a
    JupyterHub it is the user's name. A copy without a name has the example world.

    Parameters
    ----------
    folder : path, optional
        Folder of the notebooks; by default the current folder.

    Raises
    ------
    ValueError
        If the file with the name is damaged.
    """
    start = Path.cwd() if folder is None else Path(folder).resolve()
    for parent in (start, *start.parents[:_PARENTS]):
        path = parent / FOLDER / STAMP
        if path.is_file():
            return PersonalWorld(_name_in(path))
    return PersonalWorld(os.environ.get(_HUB_USER, ""))


def stamp_of(student: str) -> bytes:
    """Return the content of the file that names the student."""
    return (json.dumps({"student": student}, ensure_ascii=False) + "\n").encode()


def _name_in(path: Path) -> str:
    try:
        name = json.loads(path.read_bytes())["student"]
    except (OSError, ValueError, KeyError, TypeError):
        name = None
    if not isinstance(name, str) or not name.strip():
        raise ValueError(
            f'{path} must contain {{"student": "your name"}}, but it does not. '
            "Unpack your copy of the course again: your notebooks are not changed by that"
        )
    return name
