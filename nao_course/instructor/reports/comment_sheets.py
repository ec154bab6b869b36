"""Wrong answers by exercise and kind: a page to read, and a table of comments that each count for a whole kind."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from nao_course._internal.counts import say_count
from nao_course._internal.tables import Row, read_rows, read_table
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Comment, ExerciseResult, SubmissionResult, fingerprint
from nao_course.instructor.reports.html import Markup, element, join, lesson_title, page, visible, write_whole
from nao_course.instructor.reports.spreadsheets import fitting, table

FOLDER = "comments"  # in GRADES
HEADER = ("lesson", "exercise", "kind", "students", "comment")
MOST_CODE = 6000  # characters of one student's code that are shown
MOST_SAID = 20  # problems of a file that are listed

Kind = tuple[str, str, str]  # lesson, exercise, kind
Wrong = Mapping[Kind, Sequence[tuple[SubmissionResult, ExerciseResult]]]
CodeOf = Callable[[SubmissionResult, str], str]


class CommentsError(ValueError):
    """Comments that cannot be taken; the message names each row and what is wrong with it."""


def wrong_answers(results: Iterable[SubmissionResult]) -> Wrong:
    """Return the wrong answers by lesson, exercise and kind, in the lessons' order, the most frequent kind first."""
    found: dict[tuple[str, str], dict[Kind, list[tuple[SubmissionResult, ExerciseResult]]]] = {}
    for result in sorted(results, key=lambda each: (each.lesson, each.student)):
        for each in result.exercises:
            kinds = found.setdefault((result.lesson, each.name), defaultdict(list))
            if each.kind and result.status == "graded":
                kinds[result.lesson, each.name, each.kind].append((result, each))
    return {
        kind: found[exercise][kind]
        for exercise in found
        for kind in sorted(found[exercise], key=lambda each: (-len(found[exercise][each]), each))
    }


def write_comment_sheets(
    journal: Journal, folder: Path, code_of: CodeOf, named: Callable[[str], str], lesson: str | None = None
) -> list[tuple[Path, int, int]]:
    """Write a page and a table for each exercise with wrong answers, with the comments that the journal has already.

    `folder` is GRADES/comments; `code_of` returns a student's code for an exercise, or an empty text, and `named` how
    pages name a student. Return the tables, with the number of kinds and of wrong answers in each. If a table has
    comments that were not read in, nothing is written and a CommentsError is raised.
    """
    wrong = wrong_answers(journal.each_result(lesson))
    every = journal.comments()
    comments = {kind: every[kind].text for kind in wrong if kind in every and _fits(every[kind], wrong)}
    earlier = {kind: every[kind].text for kind in wrong if kind in every and kind not in comments}
    exercises: dict[tuple[str, str], list[Kind]] = defaultdict(list)
    for kind in wrong:
        exercises[kind[:2]].append(kind)
    paths = {exercise: folder / safe_name("_".join(exercise)) for exercise in exercises}
    for path in paths.values():
        _refuse_to_lose(path.with_name(f"{path.name}.csv"), comments | earlier)
    written = []
    for exercise, kinds in exercises.items():
        rows = [(*map(fitting, kind), str(len(wrong[kind])), comments.get(kind, "")) for kind in kinds]
        path = write_whole(paths[exercise].with_name(f"{paths[exercise].name}.csv"), table([HEADER, *rows]))
        write_whole(
            path.with_suffix(".html"), _page(exercise, kinds, wrong, comments, earlier, code_of, named)
        )
        written.append((path, len(kinds), sum(len(wrong[kind]) for kind in kinds)))
    return written


def _fits(comment: Comment, wrong: Wrong) -> bool:
    """Return whether the check still says of a kind what it said when the comment was written."""
    hint = wrong[comment.lesson, comment.exercise, comment.kind][0][1].hint
    return comment.decided_on == fingerprint(hint)


def _refuse_to_lose(path: Path, comments: Mapping[Kind, str]) -> None:
    """Refuse to overwrite comments that were typed in but not yet read."""
    for row in read_table(path, HEADER) if path.is_file() else ():
        if row["comment"].strip() not in ("", comments.get(_kind(row), "")):
            raise CommentsError(
                f"{path}, row {row.number}, has a comment that was not read in: "
                f"run `nao-course marks {path.parent.parent} {path}` first, or move it away"
            )


def is_comment_sheet(path: Path) -> bool:
    """Return whether a file is a table of comments, by its first row."""
    if not path.is_file():
        return False
    first = next(iter(read_rows(path)), [])
    return {"kind", "comment"} <= {cell.strip().casefold() for cell in first}


def read_comments(journal: Journal, path: Path, given_by: str = "") -> list[Comment]:
    """Read a table's comments into the journal, all or none of them; return what is new or changed.

    `given_by` is the person. A row without a comment takes an earlier comment back. If anything is wrong, a
    CommentsError or TableError names the rows.
    """
    wrong = wrong_answers(journal.each_result())
    known = {(fitting(kind[0]), fitting(kind[1]), fitting(kind[2])): kind for kind in wrong}
    before = {
        kind: each.text for kind, each in journal.comments().items() if kind in wrong and _fits(each, wrong)
    }
    changed: dict[Kind, Comment] = {}
    problems = []
    for row in read_table(path, HEADER):
        kind = known.get(_kind(row))
        text = visible(row["comment"]).strip()
        if kind is None:
            lesson, exercise, _ = _kind(row)
            problems.append(
                f"row {row.number}: {exercise!r} in lesson {lesson!r} has no wrong answer of this kind"
            )
        elif kind in changed and changed[kind].text != text:
            problems.append(f"row {row.number}: this kind has another comment in an earlier row")
        elif text != before.get(kind, ""):
            changed[kind] = Comment(
                *kind, text, decided_on=fingerprint(wrong[kind][0][1].hint), given_by=given_by
            )
    if problems:
        more = [f"and {len(problems) - MOST_SAID} more"] if len(problems) > MOST_SAID else []
        raise CommentsError("\n".join([f"{path.name}: nothing was read in", *problems[:MOST_SAID], *more]))
    journal.comment(changed.values())
    return list(changed.values())


def _kind(row: Row) -> Kind:
    return (row["lesson"].strip(), row["exercise"].strip(), row["kind"].strip())


# --- the page ---


def _page(
    exercise: tuple[str, str],
    kinds: Sequence[Kind],
    wrong: Wrong,
    comments: Mapping[Kind, str],
    earlier: Mapping[Kind, str],
    code_of: CodeOf,
    named: Callable[[str], str],
) -> str:
    lesson, name = exercise
    many = sum(len(wrong[kind]) for kind in kinds)
    return page(
        f"Wrong answers: {name}",
        element("p", lesson_title(lesson), class_="soft small"),
        element("h1", element("code", name)),
        element("p", f"{say_count(many, 'wrong answer')} of {say_count(len(kinds), 'kind')}."),
        *(
            part
            for kind in kinds
            for part in _kind_shown(
                kind, wrong[kind], comments.get(kind, ""), earlier.get(kind, ""), code_of, named
            )
        ),
        wide=True,
    )


def _kind_shown(
    kind: Kind,
    answers: Sequence[tuple[SubmissionResult, ExerciseResult]],
    comment: str,
    earlier: str,
    code_of: CodeOf,
    named: Callable[[str], str],
) -> Iterator[Markup]:
    """Return one kind: the message of the check, the comment if there is one, and each student's code."""
    yield element("h2", kind[2], element("span", f" ({say_count(len(answers), 'student')})", class_="soft"))
    hint = answers[0][1].hint
    if hint:
        yield element("p", "The check says: ", hint, class_="soft")
    if comment:
        yield element("div", element("p", "Your comment: ", comment), class_="box calm")
    if earlier:
        said = "Your comment when the check said something else. No student sees it now: "
        yield element("p", said, earlier, class_="soft")
    for result, each in answers:
        code = code_of(result, each.name)
        yield element(
            "article",
            element("h3", element("bdi", named(result.student))),
            element("p", "In this line: ", element("code", each.line), class_="small") if each.line else None,
            element("pre", join(code[:MOST_CODE], "\n[...]" if len(code) > MOST_CODE else ""))
            if code
            else element("p", "The code was not found in the folders of the earlier runs.", class_="soft"),
            class_="card",
        )
