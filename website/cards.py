"""The cards of the first page: a part of each lesson's opening figure that can be read at a card's size."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from PIL import Image

from website.lessons import Lesson

__all__ = ["SIZE", "cards"]

SIZE = (640, 480)  # pixels: twice the width of a card, for screens with small pixels
JPEG_STEPS = 12  # of 255: by how much one colour differs within a photograph's file


def cards(lessons: Sequence[Lesson], folder: Path) -> str:
    """Return the cards of lessons as Markdown, and save their pictures into a folder.

    A lesson that opens with no figure has a card without a picture. The folder is made beside ``lessons``, whose
    ``images`` hold the figures. A part outside its figure raises a ValueError.
    """
    folder.mkdir()
    found = []
    for lesson in lessons:
        picture = ""
        if lesson.picture:
            figure = folder.parent / "lessons" / lesson.figure
            name = f"{lesson.number}.webp"
            _shrunk(figure, lesson.about["card"]).save(folder / name, quality=75)
            picture = f"![{lesson.about['card_shows']}]({folder.name}/{name})\n\n"
        title = f"[{lesson.number} {lesson.title}](lessons/{lesson.name}.ipynb)"
        text = f"{_without_opening(lesson.goal)} *{lesson.minutes + lesson.later} minutes*"
        found.append(f":::{{container}} lesson\n{picture}**{title}**\n\n{text}\n:::")
    return "\n\n".join(["::::{container} lessons", *found, "::::"])


def _without_opening(goal: str) -> str:
    """Return what each lesson's goal says behind the words with which all of them open."""
    rest = goal.removeprefix("At the end of this lesson ")
    return rest[0].upper() + rest[1:]


def _shrunk(figure: Path, part: Sequence[float]) -> Image.Image:
    """Return a part (left, top, right, bottom; fractions) of a figure on a card of the part's own background."""
    left, top, right, bottom = part
    if not (0 <= left < right <= 1 and 0 <= top < bottom <= 1):
        raise ValueError(
            f"{figure.name}: the part {list(part)} of a card must be fractions: left, top, right, bottom"
        )
    with Image.open(figure) as opened:
        whole = Image.new("RGB", opened.size, "white")
        whole.paste(opened, mask=opened.getchannel("A") if opened.mode == "RGBA" else None)
    width, height = whole.size
    piece = whole.crop(
        (round(left * width), round(top * height), round(right * width), round(bottom * height))
    )
    scale = min(SIZE[0] / piece.width, SIZE[1] / piece.height)
    piece = piece.resize((round(scale * piece.width), round(scale * piece.height)), Image.Resampling.LANCZOS)
    card = Image.new("RGB", SIZE, _background(piece))
    card.paste(piece, ((SIZE[0] - piece.width) // 2, (SIZE[1] - piece.height) // 2))
    return card


def _background(piece: Image.Image) -> tuple[int, ...]:
    """Return the colour of all four corners, as of a map's carpet, or white where they differ."""
    right, bottom = piece.width - 1, piece.height - 1
    corners = np.array([piece.getpixel((x, y)) for x in (0, right) for y in (0, bottom)])
    is_one = (np.ptp(corners, axis=0) <= JPEG_STEPS).all()
    return tuple(int(each) for each in corners.mean(axis=0)) if is_one else (255, 255, 255)
