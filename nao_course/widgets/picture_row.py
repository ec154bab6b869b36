"""A row of pictures on a page, each with a caption and with widgets over it."""

from __future__ import annotations

import html
from collections.abc import Container, Mapping, Sequence
from typing import Any

import numpy as np

from nao_course.plotting import Drawing
from nao_course.widgets.layout import switch
from nao_course.widgets.parts import LabelledImage, box, html_line
from nao_course.widgets.shown import encoded

# px, of a picture's height on the page. Pictures wrap into the next line where they would be lower than the first
# number; none is higher than the second one, nor than the layout of its panel allows.
LARGE, SMALL = (260, 510), (120, 220)
ENLARGED = 1.25  # times: figures become blurred if they are enlarged more than that
CSS = """
.nao-pictures { gap: 8px; flex-wrap: wrap; overflow: visible; margin: 0; }
.nao-pictures .nao-column { min-width: min(100%, 150px); overflow: visible; margin: 0; }
.nao-pictures .nao-frame { position: relative; overflow: visible; margin: 0; }
.nao-pictures .nao-frame > :first-child { width: 100%; margin: 0; overflow: visible; }
.nao-pictures img { display: block; width: 100%; height: auto; margin: 0; box-sizing: border-box; }
.nao-pictures .nao-photo img { border: 1px solid #888; }
.nao-pictures .nao-small img { image-rendering: pixelated; }
"""


class Place:
    """One picture of a row, with its caption."""

    def __init__(self, heights: tuple[int, int]) -> None:
        """Build the widgets of an empty place."""
        self._heights = heights
        self.image = LabelledImage()
        self.caption = html_line("", "nao-caption")
        self.frame = box("", "nao-frame", self.image)
        self.column = box("V", "nao-column", self.caption, self.frame)
        self._sent: tuple[str, Any] = ("", None)

    def fill(self, title: str, pixels: Any, alt: str, note: str, *, is_figure: bool) -> None:
        """Show a picture; it is sent to the page only if it has changed."""
        self.image.alt = f"{alt}{note}"
        before, sent = self._sent
        if sent is not None and title == before and np.array_equal(pixels, sent):
            return
        self._sent = (title, pixels)
        caption, column = self.caption, self.column
        with self.image.hold_sync():
            self.image.format, self.image.value = encoded(pixels, is_figure)
        caption.layout.display = "" if title.strip() else "none"
        caption.value = f"<b>{html.escape(title.strip())}</b>{note}"
        height, width = pixels.shape[:2]
        shortest, tallest = self._heights
        highest = min(tallest, ENLARGED * height) if is_figure else tallest
        widest = f"calc({width / height:.4f} * min({highest:.0f}px, var(--nao-tallest, 100vh)))"
        column.layout.width = column.layout.max_width = widest
        # Factors of growth whose sum is less than 1 would leave a part of the width empty.
        column.layout.flex = f"{100 * width / height:.0f} 1 {shortest * width / height:.0f}px"
        switch(column, "nao-photo", not is_figure)
        switch(column, "nao-small", width <= 64)


class PictureRow:
    """A row of pictures, whose name stands in their text alternatives.

    A picture beside others is at least the first of `heights` high, and at most the second, px. The last of the
    `places` may be hidden; `titles` are the titles of the pictures that are shown, and `ratio` is their width side by
    side, divided by their height.
    """

    def __init__(self, name: str, heights: tuple[int, int] = LARGE) -> None:
        """Begin without pictures."""
        self._name, self._heights = name, heights
        self.widget = box("H", "nao-pictures")
        self.places: list[Place] = []
        self.titles: tuple[str, ...] = ()
        self.ratio = 0.0

    def show(
        self,
        pictures: Mapping[str, Any],
        figures: Mapping[str, Drawing] | None = None,
        missing: Container[str] = (),
        drawn: Container[str] = (),
    ) -> None:
        """Show pictures under their titles.

        `figures` are the figures among them, `missing` the titles of pictures that replace others that could not be
        made, and `drawn` the titles of drawings that are not figures.
        """
        self.titles, figures = tuple(pictures), figures or {}
        self.ratio = sum(pixels.shape[1] / pixels.shape[0] for pixels in pictures.values())
        self.places += [Place(self._heights) for _ in range(len(pictures) - len(self.places))]
        for place, (title, pixels) in zip(self.places, pictures.items(), strict=False):
            note = " (nothing yet)" if title in missing else ""
            alt = figures[title].alt if title in figures else f"{self._name}: {title.strip() or 'picture'}"
            place.fill(title, pixels, alt, note, is_figure=title in figures)
            is_drawn = not figures[title].photo if title in figures else title in drawn
            switch(place.image, "nao-drawn", is_drawn)
        columns = tuple(place.column for place in self.places[: len(pictures)])
        if self.widget.children != columns:
            self.widget.children = columns

    def lay_over(self, widgets: Sequence[Sequence[Any]]) -> None:
        """Lay widgets over the pictures: one sequence of widgets for each picture, in order."""
        for place, over in zip(self.places, widgets, strict=False):
            if place.frame.children != (children := (place.image, *over)):
                place.frame.children = children
