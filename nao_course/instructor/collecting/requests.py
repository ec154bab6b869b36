"""What students ask to be looked at again: a small text file that they hand in beside their notebooks."""

import difflib
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from nao_course._internal.text_encodings import NotTextError, decode_text
from nao_course.exercises.lesson_names import number_of
from nao_course.instructor.collecting.archives import LARGEST_ZIP, Item, Refused, in_zip
from nao_course.instructor.collecting.layouts import HandedIn, is_request
from nao_course.instructor.collecting.names import clean_name
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.collecting.submissions import open_download

LARGEST = 20_000  # bytes of a file
LONGEST_LINE = 80  # characters of a line that is quoted
# Bullets, quotation marks and Markdown.
_SIGNS = r"""[\s>*+#\u2022\u00b7\u2013\u2014`'"\u201c\u201d\u201e\u00ab\u00bb_-]*+"""
_COLON = r"[:\uff1a\ufe55](?!//)"
_NUMBER = rf"{_SIGNS}(?:(?:lesson|exercise)\s++)?(?P<number>\d{{1,2}}(?:\.\d{{1,2}})?)"
_BY_NAME = re.compile(
    rf"(?:{_NUMBER}[.):\uff1a\s]*+)?{_SIGNS}(?P<name>[^\W\d_]\w*+(?:[ -]\w++){{0,4}})(?:\(\))?{_SIGNS}{_COLON}"
    r"(?P<text>.*)",
    re.IGNORECASE,
)
_BY_NUMBER = re.compile(rf"{_NUMBER}{_SIGNS}{_COLON}(?P<text>.*)", re.IGNORECASE)


class AskedAbout(NamedTuple):
    """An exercise that a student may ask about: its lesson, its number in the lesson ("1.4") and its name."""

    lesson: str
    number: str
    name: str


def request_files(
    path: Path, scratch: Path, lessons: Sequence[str], known: Roster | None = None
) -> tuple[dict[str, str], list[tuple[str, str]]]:
    """Find the request files in a folder or zip of submissions; `known` are the students of the class.

    Return the text of the newest file by student, and the student, or an empty string, with the reason for each file
    that cannot be read. `scratch` is a folder of the caller's. Raise a ValueError if the path is neither a folder nor a
    zip.
    """
    unwrapped, students = open_download(path, lessons, known)
    found: dict[str, tuple[tuple[object, ...], str]] = {}
    problems = list[tuple[str, str]]()
    for item in unwrapped.items:
        name = students.of(item.parts)
        if item.ignored:
            continue
        shown = clean_name("/".join(item.parts))
        student = clean_name(name.student) if name and not name.problem else ""
        try:
            for each in _requests_of(item, name, scratch):
                if problem := (name.problem if name else "it names no student") or unwrapped.refused.get(
                    item.parts[0]
                ):
                    problems.append(("", f"{shown}: {problem}"))
                elif unwrapped.wrapper and not (known and known.is_listed):
                    problems.append(("", f"{shown}: {_may_be_a_students(clean_name(unwrapped.wrapper))}"))
                else:
                    text = (getattr(name, "order", ()), each.time), decode_text(each.content(LARGEST))
                    found[student] = max(found.get(student, text), text)
        except (Refused, NotTextError) as error:
            problems.append((student, f"{shown}: {error}"))
        except Exception as error:  # noqa: BLE001 - whatever is in a stranger's file, the next one is read
            problems.append((student, f"{shown}: it cannot be read ({type(error).__name__})"))
    return {student: text for student, (_, text) in found.items()}, problems


def _may_be_a_students(wrapper: str) -> str:
    return (
        f"the folder {wrapper} around this request may be a student's. If it is not, give that folder itself (unpack a "
        "zip first)"
    )


def _requests_of(item: Item, name: HandedIn | None, scratch: Path) -> Iterator[Item]:
    """Yield the request files among a file and, if it is a student's zip, the files in it."""
    if not item.parts[-1].lower().endswith(".zip"):
        if is_request(name.file if name else item.parts[-1]):
            yield item
        return
    path = item.source
    if item.entry is not None:
        path = scratch / "handed_in.zip"
        path.write_bytes(item.content(LARGEST_ZIP))
    yield from (
        each for each in in_zip(path, students=True) if is_request(each.parts[-1]) and not each.ignored
    )


def requests_in(text: str, exercises: Sequence[AskedAbout]) -> tuple[dict[tuple[str, str], str], list[str]]:
    r"""Return the requests of a file by lesson and exercise, and what could not be read.

    >>> exercises = [AskedAbout("01_hsl_filtering", "1.4", "hue_mask")]
    >>> requests_in("* Hue_Mask: red is right,\nsee page 3: it says so\nhue_mas: no", exercises)
    ({('01_hsl_filtering', 'hue_mask'): 'red is right,\nsee page 3: it says so'}, ["'hue_mas: no' (is it hue_mask?)"])
    """
    found: dict[tuple[str, str], list[str]] = {}
    lost = list[str]()
    reason: list[str] | None = None  # where the next lines belong
    for line in text.splitlines():
        meant, said, name = _beginning(line, exercises)
        if len(meant) == 1:
            reason = found.setdefault((meant[0].lesson, meant[0].name), [])
            reason.append(said.strip())
        elif meant or name:
            near = _near(name, exercises)
            hint = (
                "say of which lesson"
                if meant
                else f"is it {near[0]}?"
                if near
                else "no exercise has this name"
            )
            lost.append(f"{line.strip()[:LONGEST_LINE]!r} ({hint})")
            reason = []
        elif reason is not None:
            reason.append(line.strip())
        elif line.strip():
            lost.append(f"{line.strip()[:LONGEST_LINE]!r} (no exercise is named before it)")
    return {key: "\n".join(lines).strip() for key, lines in found.items()}, lost


def _beginning(line: str, exercises: Sequence[AskedAbout]) -> tuple[list[AskedAbout], str, str]:
    """Return the exercises that the beginning of a line may mean, the rest of the line, and the name in the line.

    The name is empty if the line only goes on with a reason: "see page 3: it says so" names no exercise.
    """
    by_name, by_number = _BY_NAME.fullmatch(line), _BY_NUMBER.fullmatch(line)
    if by_name:
        name, number = by_name["name"], by_name["number"] or ""
        there = [each for each in exercises if _plain(each.name) == _plain(name)]
        exact = [each for each in there if number in (each.number, each.number.partition(".")[0])]
        exact = exact or [each for each in there if number.zfill(2) == number_of(each.lesson)]
        if there:
            return (exact or there), by_name["text"], name
    if by_number and "." in (number := by_number["number"]):
        return [each for each in exercises if each.number == number], by_number["text"], number
    if by_name:
        is_one_word = not re.search(r"[\s-]", name) and (name[0].islower() or "_" in name)
        return [], "", name if is_one_word or _near(name, exercises) else ""
    return [], "", ""


def _near(name: str, exercises: Sequence[AskedAbout]) -> list[str]:
    return difflib.get_close_matches(_plain(name), [each.name for each in exercises], 1, 0.75)


def _plain(name: str) -> str:
    return re.sub(r"[\s-]+", "_", name.casefold())
