"""The student's best score so far: a small JSON file beside the notebook."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.challenges.declaration import Challenge

SUFFIX = ".challenge.json"
LARGEST = 100_000  # bytes; what is written here has some hundred


class BrokenFileError(ValueError):
    """The file does not hold a best score; the message says why."""


@dataclass(frozen=True)
class Best:
    """A best score.

    Parameters
    ----------
    score : float
        Of all cases.
    worst : float
        Of the worst case.
    columns : mapping of str to float
        The other numbers.
    """

    score: float
    worst: float
    columns: Mapping[str, float]


class BestFile:
    """Where a challenge's best score is kept.

    Parameters
    ----------
    challenge : Challenge
        Whose.
    folder : Path, optional
        Where it is; by default the working folder, which is the notebook's.
    """

    def __init__(self, challenge: Challenge, folder: Path | None = None) -> None:
        """Look at nothing yet."""
        self.challenge = challenge
        self.path = (folder or Path.cwd()) / f"{challenge.lesson}{SUFFIX}"

    def read(self) -> tuple[Best | None, str]:
        """Return the best so far and a remark.

        Returns
        -------
        Best or None, str
            None where there is none. A file that cannot be read gets another name, and the remark says so.
        """
        if not os.path.lexists(self.path):
            return None, ""
        try:
            return self._parsed(), ""
        except (BrokenFileError, OSError) as error:
            return None, self._set_aside(str(error))

    def keep(self, best: Best) -> str:
        """Keep a score if it is the best; return a remark if it could not be kept."""
        before, remark = self.read()
        if before is not None and not self.challenge.beats(best.score, before.score):
            return remark
        if os.path.lexists(self.path) and before is None:
            return remark  # neither readable nor movable: it stays as it is
        text = json.dumps({"score": best.score, "worst": best.worst, "columns": dict(best.columns)}, indent=1)
        beside = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        try:
            beside.write_text(text + "\n", encoding="utf-8")
            os.replace(beside, self.path)
        except OSError as error:
            beside.unlink(missing_ok=True)
            return f"{remark} Your score could not be kept in {self.path.name}: {error.strerror}.".strip()
        return remark

    def _parsed(self) -> Best:
        if not self.path.is_file():  # a folder, or a pipe that nobody writes to
            raise BrokenFileError("it is no file")
        if self.path.stat().st_size > LARGEST:
            raise BrokenFileError(f"it has more than {LARGEST // 1000} kB")
        try:
            held = json.loads(self.path.read_bytes())
        except (ValueError, RecursionError) as error:
            raise BrokenFileError("it is not JSON") from error
        if not isinstance(held, dict) or not isinstance(held.get("columns"), dict):
            raise BrokenFileError("it holds no score")
        names = {column.name for column in self.challenge.columns}
        columns = {name: _number(value) for name, value in held["columns"].items() if name in names}
        return Best(_number(held.get("score")), _number(held.get("worst")), columns)

    def _set_aside(self, why: str) -> str:
        number = 1
        while os.path.lexists(aside := self.path.with_name(f"{self.path.name}.broken-{number}")):
            number += 1
        try:
            os.rename(self.path, aside)
        except OSError:
            return f"{self.path.name} cannot be read ({why}), and not be moved either: it stays as it is."
        return f"{self.path.name} could not be read ({why}). It is kept as {aside.name}, and your best begins anew."


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BrokenFileError("it holds no score")
    try:
        number = float(value)
    except OverflowError as error:
        raise BrokenFileError("its score is no number") from error
    if not np.isfinite(number):
        raise BrokenFileError("its score is no number")
    return number
