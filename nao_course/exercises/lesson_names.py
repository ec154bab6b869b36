"""The name of a lesson, such as 01_hsl_filtering, and which lessons a word means."""

from __future__ import annotations

from collections.abc import Iterable

PATTERN = "[0-9][0-9]_*"  # of a lesson's files, before their suffix


def number_of(lesson: str) -> str:
    """Return the number of a lesson, as it stands in its name.

    Examples
    --------
    >>> number_of("01_hsl_filtering")
    '01'
    """
    return lesson.split("_")[0]


def meant(word: str, lessons: Iterable[str]) -> list[str]:
    """Return the lessons that a number or name means, in their order.

    Parameters
    ----------
    word : str
        What somebody typed.
    lessons : iterable of str
        Names of the lessons that there are.

    Examples
    --------
    >>> meant("1", ["00_meet_the_nao", "01_hsl_filtering"])
    ['01_hsl_filtering']
    """
    return [each for each in lessons if word == each or (word and word.zfill(2) == number_of(each))]
