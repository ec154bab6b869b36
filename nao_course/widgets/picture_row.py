"""A row of pictures on a page, each with a caption and with widgets over it."""

from __future__ import annotations

import html
from collections.abc import Container, Mapping, Sequence
from typing import Any

import numpy as np

from nao_course.widgets.parts import LabelledImage, box, html_line
from nao_course.widgets.shown import encoded

TALLEST = 430  # px of a picture on the page: the panel fits on a laptop's screen


class Place:
    """One picture of a row, with its caption."""

    def __init__(self) -> None:
        """Build the widgets of an empty place."""
        self.image = LabelledImage()
        self.caption = html_line("", "nao-caption")
        self.frame = box("", "nao-frame", self.image)
        self.column = box("V", "nao-column", self.caption, self.frame)
        self._sent: tuple[str, Any] = ("", None)

    def fill(self, title: str, pixels: Any, alt: str, note: str, *, is_figure: bool) -> None:
        """Show a picture; it is sent to the page only if it has changed."""
        before, sent = self._sent
        if sent is not None and title == before and np.array_equal(pixels, sent):
            return
        self._sent = (title, pixels)
        image, caption, column = self.image, self.caption, self.column
        image.format, image.value = encoded(pixels, is_figure)
        image.alt = image.description = image.tooltip = f"{title.strip() or alt}{note}"
        caption.layout.display = "" if title.strip() else "none"
        caption.value = f"<b>{html.escape(title.strip())}</b>{note}"
        height, width = pixels.shape[:2]
        most = width if is_figure else max(width, 322)
        column.layout.max_width = f"{min(most, TALLEST * width // height)}px"
        column.layout.flex = f"{width / height:.3f} 1 {'340px' if is_figure else '0'}"
        for name, holds in (("nao-photo", not is_figure), ("nao-small", width <= 64)):
            (column.add_class if holds else column.remove_class)(name)


class PictureRow:
    """A row of pictures.

    Parameters
    ----------
    alt : str
        Text alternative of a picture without a title.

    Attributes
    ----------
    widget : ipywidgets.Widget
        The row.
    places : list of Place
        The places so far; the last ones may be hidden.
    """

    def __init__(self, alt: str) -> None:
        """Begin without pictures."""
        self._alt = alt
        self.widget = box("H", "nao-pictures")
        self.places: list[Place] = []

    def show(
        self,
        pictures: Mapping[str, Any],
        figures: Container[str] = (),
        missing: Mapping[str, Any] | None = None,
    ) -> None:
        """Show pictures under their titles.

        Parameters
        ----------
        pictures : mapping of str to ndarray
            Pixels by title.
        figures : container of str
            Titles of the figures among the pictures.
        missing : mapping of str to ndarray, optional
            Substitutes for pictures that could not be made, by title.
        """
        missing = missing or {}
        every = {**pictures, **missing}
        self.places += [Place() for _ in range(len(every) - len(self.places))]
        for place, (title, pixels) in zip(self.places, every.items(), strict=False):
            note = " (nothing yet)" if title in missing else ""
            place.fill(title, pixels, self._alt, note, is_figure=title in figures)
        columns = tuple(place.column for place in self.places[: len(every)])
        if self.widget.children != columns:
            self.widget.children = columns

    def lay_over(self, widgets: Sequence[Sequence[Any]]) -> None:
        """Lay widgets over the pictures: one sequence of widgets for each picture, in order."""
        for place, over in zip(self.places, widgets, strict=False):
            if place.frame.children != (children := (place.image, *over)):
                place.frame.children = children
