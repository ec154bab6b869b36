"""``python -m website.guide`` writes into the guide and the README what the lessons say of themselves."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from nao_course.instructor.authoring.course import load_course
from website import ROOT
from website.lessons import Lesson, read_lesson

__all__ = ["guide_with_facts", "readme_with_minutes"]

WEEKS, SHORTER = "| week | lesson |", "| course | lessons |"  # heads of the guide's tables
OPEN = ["TODO", "TODO"]  # of a new lesson: its prerequisites, and what is missing without it


def guide_with_facts(guide: str, lessons: Iterable[Lesson]) -> str:
    """Return docs/teach_the_course.md with each lesson's minutes, points and uses.

    Prerequisites and the last column stay; a new lesson has TODO there.
    """
    there = {lesson.number: lesson for lesson in lessons}
    kept = {row[1][:2]: row[5:] for row in _rows(guide, WEEKS)}
    weeks = [
        [
            *(str(week), f"{each.number} {each.title}", str(each.minutes), _points(each)),
            *(", ".join(each.takes) or "-", *kept.get(each.number, OPEN)),
        ]
        for week, each in enumerate(there.values(), start=1)
    ]
    shorter = [
        [name, given, *_course([there[each] for each in re.findall(r"\d\d", given) if each in there])]
        for name, given, *_ in _rows(guide, SHORTER)
    ]
    return _with_rows(_with_rows(guide, WEEKS, weeks), SHORTER, shorter)


def readme_with_minutes(readme: str, lessons: Iterable[Lesson]) -> str:
    """Return README.md with the minutes of each lesson that its table lists."""
    for each in lessons:
        row = rf"^(\| \[{each.number} .* \|) \d+ \|$"
        readme = re.sub(row, rf"\g<1> {each.minutes + each.later} |", readme, flags=re.MULTILINE)
    return readme


def _points(lesson: Lesson) -> str:
    return f"{lesson.points:g} ({lesson.written:g})" if lesson.written else f"{lesson.points:g}"


def _course(lessons: Sequence[Lesson]) -> list[str]:
    """Return the minutes of a shorter course, and the lessons whose functions it lacks."""
    lacking = {number for each in lessons for number in each.takes} - {each.number for each in lessons}
    return [str(sum(each.minutes for each in lessons)), ", ".join(sorted(lacking)) or "-"]


def _rows(text: str, head: str) -> list[list[str]]:
    """Return the cells of the table that begins with a head, without its head and rule."""
    table = text.split(head, 1)[1].split("\n\n", 1)[0]
    return [[cell.strip() for cell in line.strip("| ").split(" | ")] for line in table.splitlines()[2:]]


def _with_rows(text: str, head: str, rows: Iterable[Sequence[str]]) -> str:
    """Return a text with other rows in the table that begins with a head."""
    before, after = text.split(head, 1)
    table, rest = after.split("\n\n", 1)
    lines = [*table.splitlines()[:2], *(f"| {' | '.join(row)} |" for row in rows)]
    return f"{before}{head}{chr(10).join(lines)}\n\n{rest}"


def main() -> None:
    """Rewrite both files, and print which of them has changed."""
    course = load_course(ROOT)
    drafts = course.drafts()
    lessons = [
        read_lesson(ROOT / "notebooks" / f"{name}.ipynb") for name in course.names() if name not in drafts
    ]
    for file, written in (("docs/teach_the_course.md", guide_with_facts), ("README.md", readme_with_minutes)):
        text = (ROOT / file).read_text(encoding="utf-8")
        new = written(text, lessons)
        (ROOT / file).write_text(new, encoding="utf-8")
        print(f"{file}: {'nothing has changed' if new == text else 'written'}")  # noqa: T201 - a command


if __name__ == "__main__":
    main()
