"""Names of lessons, such as 01_hsl_filtering: in what a person typed, and in the names of files and their copies."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence

PATTERN = "[0-9][0-9]_*"  # of a lesson's files, before their suffix
LONGEST_FILE = (
    1000  # characters of a file's name in which a lesson is looked for: more than file systems allow
)
# What browsers, Jupyter and people put behind a name. Possessive: a name of any length costs one pass.
_COPY = re.compile(
    r"(?:[ _-]*+(?:\(\d++\)|(?:copy|kopie|copie|copia|kopia|kopi|version|v|final)(?: ?\d++)?+(?![^\W\d_])|\d++))*+",
    re.IGNORECASE,
)
# What Google Drive and file managers put before a name.
_COPY_OF = re.compile(
    r"(?:(?:copy|copie|copia|cópia|kopie|kopia|kopi)(?: \(\d++\))? (?:of|von|van|de|di|av|af) )++$",
    re.IGNORECASE,
)


def number_of(lesson: str) -> str:
    """Return the number in a lesson's name.

    >>> number_of("01_hsl_filtering")
    '01'
    """
    return lesson.split("_")[0]


def meant(word: str, lessons: Iterable[str]) -> list[str]:
    """Return the lessons that a number or name refers to, in their order.

    >>> meant("1", ["00_meet_the_nao", "01_hsl_filtering"])
    ['01_hsl_filtering']
    """
    return [each for each in lessons if word == each or (word and word.zfill(2) == number_of(each))]


# --- in the names of files ---


def with_plain_signs(name: str) -> str:
    """Return a name with ordinary spaces and digits."""
    if name.isascii() and name.isprintable():
        return name
    return "".join(
        " " if each.isspace() else str(unicodedata.decimal(each)) if each.isdecimal() else each
        for each in name
    )


def found_in(file: str, lessons: Sequence[str]) -> Iterator[tuple[str, str, str]]:
    """Yield each lesson in a file's name with the text before it and the text after it.

    The marks of copies do not count: `Copy of` before the lesson's name, `(1)`, `-Copy1` or `v2` behind it.

    >>> list(found_in("Ben - Copy of 01_HSL_filtering (1).ipynb", ["01_hsl_filtering"]))
    [('01_hsl_filtering', 'Ben - ', '')]
    """
    stem = with_plain_signs((file.rpartition(".")[0] or file)[:LONGEST_FILE])
    by_name = {_plain(each): each for each in lessons}
    names = "|".join(re.escape(each).replace("_", "[ _-]") for each in by_name)
    for found in re.finditer(names, stem, re.IGNORECASE) if names else ():
        after = stem[_COPY.match(stem, found.end()).end() :]  # type: ignore[union-attr]
        yield (
            by_name[_plain(found[0])],
            _COPY_OF.sub("", stem[: found.start()]),
            after if after.strip("_- ") else "",
        )


def lesson_of(file: str, lessons: Sequence[str]) -> str:
    """Return the lesson that a file is named after, or an empty string.

    >>> lesson_of("my 01_HSL_filtering final v2 (3)-Copy1.ipynb", ["01_hsl_filtering"])
    '01_hsl_filtering'
    """
    for lesson, before, after in found_in(file, lessons):
        if not after and before[-1:] in ("", "_", " ", "-"):
            return lesson
    return ""


def lesson_and_more(file: str, lessons: Sequence[str]) -> tuple[str, str]:
    """Return the lesson that a file's name begins with and the other words behind it, or two empty strings.

    >>> lesson_and_more("01_hsl_filtering_ada (1).ipynb", ["01_hsl_filtering"])
    ('01_hsl_filtering', 'ada (1)')
    """
    for lesson, before, after in found_in(file, lessons):
        if not before and not after[:1].isalnum() and (more := after.strip("_- ")):
            return lesson, more
    return "", ""


def _plain(lesson: str) -> str:
    return re.sub("[ -]", "_", lesson.casefold())
