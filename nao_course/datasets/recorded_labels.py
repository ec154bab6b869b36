"""Recorded labels of a lesson's pictures, for students whose lesson 01 is not finished."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, wraps
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.exercises.trying import Message

Pixels = npt.NDArray[np.uint8]
_COLUMNS, _ROWS = 8, 6  # size of the thumbnails by which pictures are recognised
_SAME = 1.0  # largest mean difference of two thumbnails of the same picture
_SHIFTS = np.arange(4, dtype=np.uint8) * 2  # four labels in a byte


@dataclass(frozen=True, eq=False)
class RecordedLabels:
    """Labels of a lesson's pictures in a file, with a note that the student sees at the first recorded answer.

    `pictures` returns all pictures of the lesson that are recorded, each (H, W, 3).
    """

    path: Path
    pictures: Callable[[], Sequence[Pixels]]
    note: str

    def record(self, label: Callable[[Any], Any]) -> None:
        """Write the labels of all pictures: ``label(pixels)`` returns labels (H, W), 0 to 3."""
        pictures = self.pictures()
        labels = np.array([label(picture) for picture in pictures], dtype=np.uint8)
        quarters = labels.reshape(*labels.shape[:2], -1, 4) << _SHIFTS
        np.savez_compressed(
            self.path,
            thumbnails=np.array([_thumbnail(each) for each in pictures]),
            labels=quarters.sum(3, np.uint8),
        )

    def find(self, picture: npt.ArrayLike) -> Pixels | None:
        """Return the recorded labels (H, W) of a picture; None if it is not among the recorded pictures."""
        thumbnails, labels = self._read
        pixels = np.asarray(picture)
        if pixels.shape != (labels.shape[1], 4 * labels.shape[2], 3) or pixels.dtype != np.uint8:
            return None
        differences = np.abs(thumbnails.astype(float) - _thumbnail(pixels)).mean(axis=(1, 2, 3))
        best = int(differences.argmin())
        if differences[best] > _SAME:
            return None
        return (labels[best][..., None] >> _SHIFTS & 3).reshape(pixels.shape[:2])

    @cached_property
    def _read(self) -> tuple[Pixels, Pixels]:
        """The pictures' thumbnails, and their labels, four in a byte."""
        with np.load(self.path) as file:
            return file["thumbnails"], file["labels"]

    def or_recorded(self, label: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function like `label` that uses recorded labels if a function of lesson 01 is not usable.

        ``label(pixels, ...)`` returns labels (H, W), and may call functions of lesson 01.
        """
        noted: list[bool] = []

        @wraps(label)
        def labels_of(picture: Any, *values: Any, **named: Any) -> Any:
            try:
                return label(picture, *values, **named)
            except EarlierNotUsable as reason:
                labels = self.find(picture)
                if labels is None:
                    raise EarlierNotUsable(
                        f"{reason} There are no recorded labels for this picture."
                    ) from None
                if not noted:
                    noted.append(True)
                    _show(self.note)
                return labels

        return labels_of


def _thumbnail(picture: npt.NDArray[Any]) -> Pixels:
    """Return a picture at 8 x 6 pixels, in which rounding errors of single pixels do not matter."""
    return np.asarray(cv2.resize(picture, (_COLUMNS, _ROWS), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _show(note: str) -> None:
    from IPython.display import display  # takes long to import

    display(Message(note))
