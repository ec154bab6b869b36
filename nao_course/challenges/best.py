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
LARGEST = 100_000  # bytes; a usual file has a few hundred


class BrokenFileError(ValueError):
    """Raised for a file whose best score cannot be used; the message explains why."""


@dataclass(frozen=True)
class Best:
    """A best total score, with the score of the worst case and the values of the other columns."""

    score: float
    worst: float
    columns: Mapping[str, float]


class BestFile:
    """The file that stores a challenge's best score, by default in the working folder, which is the notebook's."""

    def __init__(self, challenge: Challenge, folder: Path | None = None) -> None:
        """Store the path; the file is read later."""
        self.challenge = challenge
        self.path = (folder or Path.cwd()) / f"{challenge.lesson}{SUFFIX}"
        # Repeated whenever the board is shown, because a notebook first requests the text and then shows the HTML.
        self._remark = ""

    def read(self) -> tuple[Best | None, str]:
        """Return the best score so far, or None, and a remark, such as that an unusable file was renamed."""
        if not os.path.lexists(self.path):
            return None, self._remark
        try:
            return self._parsed(), self._remark
        except (BrokenFileError, OSError) as error:
            self._remark = self._set_aside(str(error))
            return None, self._remark

    def keep(self, best: Best) -> str:
        """Store a score if it is the best; return a remark if it could not be stored."""
        before, remark = self.read()
        if before is not None and not self.challenge.beats(best.score, before.score):
            return remark
        if os.path.lexists(self.path) and before is None:
            return remark  # neither readable nor movable, so it stays unchanged
        held = {"score": best.score, "worst": best.worst, "columns": dict(best.columns)}
        text = json.dumps(held | {"version": self.challenge.version}, indent=1)
        beside = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        try:
            beside.write_text(text + "\n", encoding="utf-8")
            os.replace(beside, self.path)
        except OSError as error:
            beside.unlink(missing_ok=True)
            return f"{remark} Your score could not be stored in {self.path.name}: {error.strerror}.".strip()
        return remark

    def _parsed(self) -> Best:
        if not self.path.is_file():  # a folder, or a pipe without a writer
            raise BrokenFileError("it is not a file")
        if self.path.stat().st_size > LARGEST:
            raise BrokenFileError(f"it has more than {LARGEST // 1000} kB")
        try:
            held = json.loads(self.path.read_bytes())
        except (ValueError, RecursionError) as error:
            raise BrokenFileError("it is not JSON") from error
        if not isinstance(held, dict) or not isinstance(held.get("columns"), dict):
            raise BrokenFileError("it contains no score")
        if held.get("version", 1) != self.challenge.version:
            raise BrokenFileError("the challenge is now scored differently")
        names = {column.name for column in self.challenge.columns}
        columns = {name: _number(value) for name, value in held["columns"].items() if name in names}
        return Best(_number(held.get("score")), _number(held.get("worst")), columns)

    def _set_aside(self, why: str) -> str:
        number = 1
        while os.path.lexists(aside := self.path.with_name(f"{self.path.name}.old-{number}")):
            number += 1
        try:
            os.rename(self.path, aside)
        except OSError:
            return f"{self.path.name} cannot be used ({why}) and cannot be renamed, so it stays unchanged."
        outcome = f"It was renamed to {aside.name}, and your best score starts again."
        return f"{self.path.name} cannot be used ({why}). {outcome}"


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise BrokenFileError("it contains no score")
    try:
        number = float(value)
    except OverflowError as error:
        raise BrokenFileError("its score is not a number") from error
    if not np.isfinite(number):
        raise BrokenFileError("its score is not a number")
    return number
