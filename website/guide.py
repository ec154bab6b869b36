"""``python -m website.guide`` writes the tables of lessons in the README, the instructors' guide and the syllabus."""

import re
from collections.abc import Iterable, Sequence

from nao_course.instructor.authoring.course import load_course
from website import ROOT
from website.lessons import Lesson, read_lesson

__all__ = ["guide_with_lessons", "readme_with_lessons", "syllabus_with_lessons"]

WEEKS, SHORTER = "| week | lesson |", "| course | lessons |"  # heads of the guide's tables
README = "| lesson | what you do |"  # of the README's
SYLLABUS = "| week | lesson | after this week, students can |"  # of the syllabus's


def guide_with_lessons(guide: str, lessons: Iterable[Lesson]) -> str:
    """Return docs/teach_the_course.md with a row for each lesson, and the minutes of the shorter courses."""
    there = {lesson.number: lesson for lesson in lessons}
    weeks = [
        [
            *(str(week), f"{each.number} {each.title}", str(each.minutes), str(each.later or "-")),
            *(_points(each), ", ".join(each.takes) or "-", each.needs, each.about["left_out"]),
        ]
        for week, each in enumerate(there.values(), start=1)
    ]
    shorter = [
        [name, given, *_course([there[each] for each in re.findall(r"\d\d", given) if each in there])]
        for name, given, *_ in _rows(guide, SHORTER)
    ]
    return _with_rows(_with_rows(guide, WEEKS, weeks), SHORTER, shorter)


def readme_with_lessons(readme: str, lessons: Iterable[Lesson]) -> str:
    """Return README.md with a row for each lesson."""
    rows = [
        (
            f"[{each.number} {each.title}](notebooks/{each.name}.ipynb)",
            each.about["does"],
            str(each.minutes + each.later),
        )
        for each in lessons
    ]
    return _with_rows(readme, README, rows)


def syllabus_with_lessons(syllabus: str, lessons: Iterable[Lesson]) -> str:
    """Return docs/syllabus.md with a row for each lesson; weeks and order stay, and a new lesson is optional."""
    there = {lesson.number: lesson for lesson in lessons}
    weeks = {lesson[:2]: week for week, lesson, *_ in _rows(syllabus, SYLLABUS) if lesson[:2] in there}
    weeks = weeks | {number: "optional" for number in there if number not in weeks}
    rows = [
        (week, f"{number} {there[number].title}", there[number].about["can"])
        for number, week in weeks.items()
    ]
    return _with_rows(syllabus, SYLLABUS, rows)


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
    """Rewrite the files, and print which of them have changed."""
    course = load_course(ROOT)
    drafts = course.drafts()
    lessons = [
        read_lesson(ROOT / "notebooks" / f"{name}.ipynb") for name in course.names() if name not in drafts
    ]
    for file, written in (
        ("docs/teach_the_course.md", guide_with_lessons),
        ("docs/syllabus.md", syllabus_with_lessons),
        ("README.md", readme_with_lessons),
    ):
        text = (ROOT / file).read_text(encoding="utf-8")
        new = written(text, lessons)
        (ROOT / file).write_text(new, encoding="utf-8")
        print(f"{file}: {'nothing has changed' if new == text else 'written'}")  # noqa: T201 - a command


if __name__ == "__main__":
    main()
