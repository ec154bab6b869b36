"""Contact sheets of all panels of the lessons and of `my_nao()`, on pages of the sizes that students have."""

from __future__ import annotations

import io
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from PIL import Image, ImageDraw

from benchmarks import chromium
from tests.browser.lab import LAPTOP, browser_page, jupyter_lab
from tests.browser.lesson_panels import PanelPage

COLUMNS, WIDTH, LABEL, GAP = 3, 760, 26, 20  # px of a panel on the sheet, and of the line above it
BARS = 134  # px of a laptop's screen that browser and JupyterLab take
# Width of the page in px, enlargement and theme; a page of 1280 px at 125 % is one of 1024 px.
PAGES = {
    "1280": (1280, 1.0, "Light"),
    "1280_at_125_percent": (1024, 1.25, "Light"),
    "900": (900, 1.0, "Light"),
    "1280_dark": (1280, 1.0, "Dark"),
}


def contact_sheets() -> Iterator[tuple[str, bytes]]:
    """Yield (name, PNG) for each kind of page: all panels with their sizes, and a red line where a laptop ends."""
    with tempfile.TemporaryDirectory() as folder:
        notebooks, settings = (Path(folder, name) for name in ("notebooks", "settings"))
        notebooks.mkdir()
        with jupyter_lab(notebooks, settings) as lab, browser_page(chromium()) as opened:
            page = PanelPage(lab, opened)
            for name, (width, enlarged, theme) in PAGES.items():
                page.choose(theme)
                shots = [(each, page.photograph(at, width)) for at, each in enumerate(page.labels)]
                yield name, _sheet(shots, round(LAPTOP["height"] / enlarged) - BARS)


def _sheet(shots: Sequence[tuple[str, bytes]], end: int) -> bytes:
    """Lay pictures out in columns, each in the column that is shortest so far, with a line at the height `end`, px."""
    placed, heights = [], [0] * COLUMNS
    for label, shot in shots:
        picture = Image.open(io.BytesIO(shot)).convert("RGB")
        ImageDraw.Draw(picture).line([(0, end), (picture.width, end)], (220, 0, 0), 2)
        size = f"{label}: {picture.width} x {picture.height} px"
        picture.thumbnail((WIDTH, picture.height), Image.Resampling.LANCZOS)
        column = heights.index(min(heights))
        placed.append((column * (WIDTH + GAP), heights[column], size, picture))
        heights[column] += picture.height + LABEL + GAP
    sheet = Image.new("RGB", (COLUMNS * (WIDTH + GAP), max(heights)), "white")
    for x, y, size, picture in placed:
        ImageDraw.Draw(sheet).text((x, y + 6), size, (0, 0, 0), font_size=15)
        sheet.paste(picture, (x, y + LABEL))
    made = io.BytesIO()
    sheet.save(made, "PNG", optimize=True)
    return made.getvalue()
