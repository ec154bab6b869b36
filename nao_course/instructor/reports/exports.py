"""Grades for other systems: a table for any gradebook, and results and an autograder for Gradescope."""

import json
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from nao_course._internal.counts import say_count
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import ExerciseResult, Mark, Override, WrittenAnswer
from nao_course.instructor.gradebook.scores import Score, all_scores
from nao_course.instructor.reports.feedback import said_of
from nao_course.instructor.reports.html import number, visible, write_whole
from nao_course.instructor.reports.platforms import PLATFORMS
from nao_course.instructor.reports.spreadsheets import table

FORMATS = ("csv", "json", "gradescope", *PLATFORMS)
FOLDER = "exports"  # in GRADES
_MISSING = "not handed in"
_WHO = ("name", "email", "login", "section")  # of a student of the roster
_ABOUT = ("points", "out of", "status", "handed in", "late", "deducted", "notes")  # columns of each lesson


class ExportError(ValueError):
    """An export that is not there; the message says which are."""


def check_format(name: str) -> str:
    """Return the name of a format; raise an ExportError if there is none of that name."""
    if name in FORMATS:
        return name
    later = " nbgrader's gradebook comes in a later version." if name == "nbgrader" else ""
    raise ExportError(f"there is no format {name!r}; there are {', '.join(FORMATS)}.{later}")


# --- a table ---


def csv_table(made: Sequence[Score], roster: Roster | None = None) -> bytes:
    """Make a table with a row for each student and, lesson after lesson, a column for each exercise and question.

    The roster has the students' names, e-mail addresses, logins and sections. A written answer that nobody has
    marked is an empty cell. A name that a spreadsheet would take for a formula has an apostrophe before it. It is
    CSV by RFC 4180.
    """
    lessons = sorted({each.result.lesson for each in made})
    students = sorted({each.result.student for each in made})
    by_key = {(each.result.student, each.result.lesson): each for each in made}
    columns = {
        lesson: _columns([each for each in made if each.result.lesson == lesson]) for lesson in lessons
    }
    header = ["student", *_WHO]
    for lesson in lessons:
        header += [f"{number} {name}".strip() for number, name in columns[lesson]]
        header += [f"{lesson} {what}" for what in _ABOUT]
    rows: list[list[str | float | None]] = [[*header, "total"]]
    for student in students:
        theirs = [by_key.get((student, lesson)) for lesson in lessons]
        cells = [_cells(score, columns[lesson]) for score, lesson in zip(theirs, lessons, strict=True)]
        total = sum(each.earned for each in theirs if each)
        rows.append(
            [student, *_who(student, roster).values(), *(cell for part in cells for cell in part), total]
        )
    return table(rows)


def _who(student: str, roster: Roster | None) -> dict[str, str]:
    """Return what the roster says of a student."""
    known = roster.students.get(student) if roster else None
    return {each: getattr(known, each) if known else "" for each in _WHO}


def json_text(made: Sequence[Score], roster: Roster) -> str:
    """Make the content of grades.json: a list of students, each with all lessons, for scripts.

    A written answer that nobody has marked has null points.
    """
    students: dict[str, dict[str, Any]] = {}
    for score in made:
        result = score.result
        student = students.setdefault(
            result.student,
            {"student": result.student, **_who(result.student, roster), "total": 0.0, "lessons": {}},
        )
        student["total"] = round(student["total"] + score.earned, 6)
        student["lessons"][result.lesson] = {
            "points": round(score.earned, 6),
            "out_of": score.points,
            "status": result.status,
            "handed_in": result.handed_in,
            "late": score.is_late,
            "deducted": round(score.deducted, 6),
            "notes": _notes(score),
            "exercises": [
                {**_item(each), "points": score.of(each), "state": each.state} for each in result.exercises
            ],
            "questions": [{**_item(each), "points": score.of_answer(each)} for each in result.written],
        }
    return json.dumps(list(students.values()), indent=1, ensure_ascii=True) + "\n"


def _item(item: ExerciseResult | WrittenAnswer) -> dict[str, Any]:
    return {"name": item.name, "number": item.number, "out_of": item.points}


def _columns(made: Iterable[Score]) -> list[tuple[str, str]]:
    """Return numbers and names of all exercises and then all questions of a lesson, in its order."""
    both: tuple[dict[tuple[str, str], None], dict[tuple[str, str], None]] = ({}, {})
    for score in made:
        both[0].update(dict.fromkeys((each.number, each.name) for each in score.result.exercises))
        both[1].update(dict.fromkeys((each.number, each.name) for each in score.result.written))
    return [*both[0], *both[1]]


def _cells(score: Score | None, columns: Sequence[tuple[str, str]]) -> list[str | float | None]:
    if score is None:
        return [*(None for _ in columns), None, None, _MISSING, "", "", None, ""]
    given: dict[tuple[str, str], float | None] = {
        (each.number, each.name): score.of(each) for each in score.result.exercises
    }
    given |= {(each.number, each.name): score.of_answer(each) for each in score.result.written}
    return [
        *(given.get(column) for column in columns),
        score.earned,
        score.points,
        score.result.status,
        score.result.handed_in,
        "yes" if score.is_late else "",
        score.deducted or None,
        "; ".join(_notes(score)),
    ]


def _notes(score: Score) -> list[str]:
    notes = [score.result.reason] if score.result.reason else []
    if score.lateness and score.lateness.is_unmeasured:
        notes.append("late by the platform, but not by how much: nothing was deducted")
    if score.waiting:
        notes.append(f"{say_count(len(score.waiting), 'written answer')} not marked yet")
    notes += [
        f"{name} set to {number(each.points)}{f' by {each.given_by}' if each.given_by else ''}: {each.reason}"
        for name, each in score.overrides.items()
    ]
    earlier: tuple[Override | Mark, ...] = (*score.earlier_overrides.values(), *score.earlier_marks.values())
    notes += [
        f"{each.item}: {number(each.points)} points were for an earlier answer and do not count"
        for each in earlier
    ]
    return [*notes, *score.result.notes]


# --- Gradescope ---


def gradescope_results(score: Score) -> dict[str, Any]:
    """Make the content of Gradescope's results.json, as its autograder documentation specifies it.

    A written answer is a test once it is marked.
    """
    result = score.result
    tests = [_exercise_test(score, each) for each in result.exercises]
    tests += [_written_test(score, each) for each in result.written if each not in score.waiting]
    return {
        "score": round(score.earned, 6),
        "output": visible("\n".join(_output(score))),
        "output_format": "text",
        "test_output_format": "text",
        "test_name_format": "text",
        "visibility": "visible",
        "stdout_visibility": "hidden",
        "extra_data": {
            name: visible(getattr(result, name)) for name in ("lesson", "submission", "assignment", "level")
        },
        "tests": tests,
    }


def _output(score: Score) -> list[str]:
    lines = [f"Refused: {score.result.reason}"] if score.result.status == "refused" else []
    if score.waiting:
        lines.append(f"{say_count(len(score.waiting), 'written answer')} to be marked by a person.")
    return lines


def _exercise_test(score: Score, exercise: ExerciseResult) -> dict[str, Any]:
    parts = said_of(score, exercise) if score.result.status == "graded" else ()
    lines = [f"{each.title}\n{each.text}" if each.title else each.text for each in parts]
    output = "\n".join(line.strip() for line in lines)
    right = exercise.state == "right" if exercise.points == 0 else score.of(exercise) >= exercise.points
    return _test(exercise, score.of(exercise), right, output)


def _written_test(score: Score, answer: WrittenAnswer) -> dict[str, Any]:
    mark = score.marks.get(answer.name)
    points = score.of_answer(answer) or 0.0
    return _test(answer, points, points >= answer.points, mark.comment if mark else "There is no answer.")


def _test(item: ExerciseResult | WrittenAnswer, points: float, right: bool, output: str) -> dict[str, Any]:
    return {
        "name": visible(item.name),
        "number": item.number,
        "score": round(points, 6),
        "max_score": round(item.points, 6),
        "status": "passed" if right else "failed",
        "output": visible(output),
        "output_format": "text",
        "visibility": "visible",
    }


def last_exports(folder: Path, lessons: Iterable[str]) -> dict[str, str]:
    """Return when each lesson was last exported, in UTC as in the journal; a table of grades is of all lessons."""
    found = [(each.name, each.stat().st_mtime) for each in folder.glob("*") if each.is_file()]
    times = {
        lesson: max(
            (time for name, time in found if lesson in name or name.startswith("grades.")), default=None
        )
        for lesson in lessons
    }
    return {
        lesson: datetime.fromtimestamp(time, UTC).isoformat(timespec="seconds")
        for lesson, time in times.items()
        if time is not None
    }


def write_csv(journal: Journal, folder: Path, lesson: str | None = None) -> Path:
    """Write grades.csv into GRADES/exports."""
    return write_whole(folder / "grades.csv", csv_table(all_scores(journal, lesson), journal.roster()))


def write_json(journal: Journal, folder: Path, lesson: str | None = None) -> Path:
    """Write grades.json into GRADES/exports."""
    return write_whole(folder / "grades.json", json_text(all_scores(journal, lesson), journal.roster()))


def write_gradescope(journal: Journal, folder: Path, lesson: str | None = None) -> list[Path]:
    """Write each student's results.json into LESSON/STUDENT of a folder."""
    written = []
    for each in all_scores(journal, lesson):
        with journal.for_one(each.result.student, each.result.lesson, "results.json was not written"):
            path = folder / each.result.lesson / safe_name(each.result.student) / "results.json"
            written.append(write_whole(path, as_text(gradescope_results(each))))
    return written


def as_text(results: dict[str, Any]) -> str:
    """Return a results.json's text, the same each time."""
    return json.dumps(results, indent=1, ensure_ascii=True) + "\n"
