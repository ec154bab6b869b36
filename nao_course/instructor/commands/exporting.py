"""What the command that exports grades does and says."""

from collections.abc import Iterator
from pathlib import Path

from nao_course._internal.counts import say_count
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.secret import load_secret
from nao_course.instructor.commands.feedback_pages import FEEDBACK
from nao_course.instructor.commands.grading import refuse_edited_lessons
from nao_course.instructor.commands.looking_up import graded_lesson, list_problems, only_lesson
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.scores import all_scores
from nao_course.instructor.reports import exports, platforms
from nao_course.instructor.reports.feedback import feedback_page
from nao_course.instructor.reports.html import write_whole


def export(
    grades: Path,
    format_: str,
    lesson: str = "",
    sheet: Path | None = None,
    column: str = "",
    *,
    scale: bool = False,
) -> Iterator[str]:
    """Write grades of a lesson, or of all, for another system in one of `exports.FORMATS`; yield what to say about it.

    A platform's own sheet is filled in, with the points in its column, scaled to the sheet's maximum with `scale`.
    Raise a ValueError if there is no such format, journal, lesson or sheet.
    """
    if exports.check_format(format_) == "gradescope":
        yield from _gradescope(grades, lesson)
        return
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        if format_ in platforms.PLATFORMS:
            yield from _platform(journal, grades, format_, lesson, sheet, column, scale)
        else:
            write = exports.write_json if format_ == "json" else exports.write_csv
            yield f"wrote {write(journal, grades / exports.FOLDER, graded_lesson(journal, lesson))}"
        yield from list_problems(journal)


def _platform(
    journal: Journal, grades: Path, platform: str, lesson: str, sheet: Path | None, column: str, scale: bool
) -> Iterator[str]:
    """Fill in a platform's sheet and make the zip of feedback."""
    if sheet is None:
        raise exports.ExportError(
            f"{platforms.NAMES[platform]}'s own sheet is filled in: say --sheet THEIRS.csv"
        )
    name = graded_lesson(journal, lesson) or only_lesson(journal)
    made = all_scores(journal, name)
    roster = journal.roster()
    filled = platforms.fill_sheet(platform, sheet, made, column, roster=roster, scale=scale)
    folder = grades / exports.FOLDER
    path = write_whole(folder / f"{platform}_{name}.csv", filled.table)
    yield f"wrote {path}: {say_count(filled.filled, 'row')} filled in"
    without: tuple[str, ...] = ()
    if platform in platforms.UPLOADS:
        pages = []
        for each in made:
            with journal.for_one(each.result.student, name, "the feedback page is not in the zip"):
                pages.append((each.result, feedback_page(each).encode()))
        archive, without = platforms.feedback_zip(platform, pages, roster)
        path = write_whole(folder / f"{platform}_feedback_{name}.zip", archive)
        yield f"wrote {path}: for {platforms.UPLOADS[platform]}"
    else:
        yield f"the feedback pages are in {grades / FEEDBACK}: the platform takes no file with all of them"
    for said, who in (
        ("Graded, but in no row", filled.without_row),
        ("Not graded", filled.without_grade),
        ("Not in the zip of feedback, because the file's name is not the platform's", without),
    ):
        if who:
            yield f"{said}: {', '.join(who)}"


def _gradescope(grades: Path, lesson: str) -> Iterator[str]:
    from nao_course.instructor.commands.gradescope import write_autograder

    course, secret = load_course(), load_secret()
    wanted = course.names([lesson]) if lesson else []
    folder = grades / exports.FOLDER / "gradescope"
    with Journal(
        grades, policy=course.late_policy
    ) as journal:  # an autograder can be made before anything was graded
        graded = sorted({each.lesson for each in journal.each_result()})
        names = wanted or course.names(graded)
        refuse_edited_lessons(course, names)
        for name in names:
            written = exports.write_gradescope(journal, folder, name)
            yield f"wrote {say_count(len(written), 'result')} into {folder / name}"
            yield f"wrote {write_autograder(course, name, secret, folder)}"
    yield "An autograder's zip holds the solution: upload it to Gradescope, and give it to nobody."
    yield from list_problems(journal)
