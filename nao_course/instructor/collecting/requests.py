"""What students ask to be looked at again: a small text file that they hand in beside their notebooks."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path

from nao_course.homework import REQUEST
from nao_course.instructor.collecting.archives import LARGEST_ZIP, Item, Refused, in_folder, in_zip
from nao_course.instructor.collecting.names import clean_name, name_file
from nao_course.instructor.collecting.wrappers import unwrap

LARGEST = 20_000  # bytes of a file
_BEGINS = re.compile(r"\s*([A-Za-z_]\w*)\s*:(.*)", re.ASCII)


def request_files(
    path: Path, scratch: Path, lessons: Sequence[str], known: Collection[str]
) -> tuple[dict[str, str], list[str]]:
    """Find the request files in a folder or zip of submissions.

    Parameters
    ----------
    path : Path
        What `nao-course grade` takes.
    scratch : Path
        A folder of the caller's.
    lessons : sequence of str
        Names of the lessons that there are.
    known : collection of str
        Students who have a result.

    Returns
    -------
    texts : dict of str to str
        Text of the file by student.
    problems : list of str
        Files that cannot be read, with the reason.

    Raises
    ------
    ValueError
        If the path is neither a folder nor a zip.
    """
    try:
        items = list(in_folder(path)) if path.is_dir() else in_zip(path, students=False)
    except Refused as refused:
        raise ValueError(f"{path} is not a folder of submissions or a zip of them; {refused}") from None
    texts, problems = dict[str, str](), list[str]()
    for item in unwrap(items, lessons, known).items:
        name = name_file(item.parts, lessons)
        if name is None or item.ignored:
            continue
        student = clean_name(name.student)
        try:
            for each in _inside(item, scratch):
                if each.parts[-1] == REQUEST:
                    texts[student] = each.content(LARGEST).decode("utf-8", "replace")
        except Refused as refused:
            problems.append(f"{student}: {clean_name('/'.join(item.parts))}: {refused}")
    return texts, problems


def _inside(item: Item, scratch: Path) -> Iterator[Item]:
    """Yield a file, or the files of a student's zip."""
    if not item.parts[-1].lower().endswith(".zip"):
        yield item
        return
    path = item.source
    if item.entry is not None:
        path = scratch / "handed_in.zip"
        path.write_bytes(item.content(LARGEST_ZIP))
    yield from in_zip(path, students=True)


def requests_in(text: str, exercises: Collection[str]) -> tuple[dict[str, str], list[str]]:
    r"""Return the requests of a file by exercise, and the lines before the first one.

    Examples
    --------
    >>> requests_in("hue_mask: red is right,\nsee page 3\nhue: no", ["hue_mask"])
    ({'hue_mask': 'red is right,\nsee page 3\nhue: no'}, [])
    >>> requests_in("Please!", ["hue_mask"])
    ({}, ['Please!'])
    """
    found: dict[str, list[str]] = {}
    lost = []
    name = ""
    for line in text.splitlines():
        begins = _BEGINS.fullmatch(line)
        if begins and begins[1] in exercises:
            name, line = begins[1], begins[2]
        if name:
            found.setdefault(name, []).append(line.strip())
        elif line.strip():
            lost.append(line.strip()[:80])
    return {name: "\n".join(lines).strip() for name, lines in found.items()}, lost
