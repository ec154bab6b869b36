"""Names of lessons, such as 01_hsl_filtering, and the lessons that a typed word refers to."""

from __future__ import annotations

from collections.abc import Iterable

PATTERN = "[0-9][0-9]_*"  # of a lesson's files, before their suffix


def number_of(lesson: str) -> str:
    """Return the number in a lesson's name.

    Examples
    --------
    >>> number_of("01_hsl_filtering")
    '01'
    """
    return lesson.split("_")[0]


def meant(word: str, lessons: Iterable[str]) -> list[str]:
    """Return the lessons that a number or name refers to, in their order.

    Parameters
    ----------
    word : str
        The text that a person typed.
    lessons : iterable of str
        Names of all lessons.

    Examples
    --------
    >>> meant("1", ["00_meet_the_nao", "01_hsl_filtering"])
    ['01_hsl_filtering']
    """
    return [each for each in lessons if word == each or (word and word.zfill(2) == number_of(each))]
