"""Marking sheets: written answers go out to people as tables and pages, and come back as marks."""

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from nao_course._internal.counts import say_count
from nao_course._internal.personal_world import EXAMPLE
from nao_course._internal.tables import Row, TableError, plain_number, read_table
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Mark, WrittenAnswer
from nao_course.instructor.gradebook.scores import Score, each_journal_score
from nao_course.instructor.reports.answer_numbers import compare_numbers
from nao_course.instructor.reports.html import (
    Markup,
    element,
    lesson_title,
    markdown,
    number,
    page,
    visible,
    write_whole,
)
from nao_course.instructor.reports.spreadsheets import fitting, table

FOLDER = "marking"  # in GRADES
HEADER = ("student", "lesson", "question", "answer", "points", "comment", "max points")
# The answer that a mark belongs to; an earlier answer with its mark, if the student has changed it since; who gave the
# points that were there when the sheet was written; whether these are a second person's marks; and other students who
# wrote the same, one in a line, and get the same mark.
MORE = (
    *("answer id", "earlier answer", "earlier points", "earlier comment"),
    *("marked by", "marking", "same answer"),
)
SECOND = "second"  # marking, in the column of that name
MOST_SAID = 20  # problems of a file that are listed
_CODE = re.compile(r"student-[0-9a-f]{10}")

Code = Callable[[str], str]
Numbers = Callable[[str, str, str], Mapping[str, float]]  # of a lesson's question and a student
Key = tuple[str, str, str]  # student, lesson, question; as a table shows them


class MarksError(ValueError):
    """Marks that cannot be taken; the message names each row and what is wrong with it."""


@dataclass(frozen=True)
class Sheet:
    """A table to fill in, and a page to read, of the answers to one question, and how many of them nobody has marked.

    Empty answers do not count: they have 0 points and no row.
    """

    table: Path
    page: Path
    answers: int
    open: int


@dataclass(frozen=True)
class Taken:
    """The number of marks in a file, the marks that are new or changed, and the answers that nobody has marked yet.

    `open` has student, as the file names students, and question. `replaced` are lines about marks that took the place
    of others, and `differing` about second marks that differ from the first ones.
    """

    read: int
    changed: tuple[Mark, ...]
    open: tuple[tuple[str, str], ...]
    replaced: tuple[str, ...] = ()
    differing: tuple[str, ...] = ()


@dataclass(frozen=True)
class _Answer:
    """A student's answer to a question, with its first or second mark where there is one."""

    score: Score
    answer: WrittenAnswer
    code: str  # instead of the student's name, where marking is anonymous
    marks: tuple[Mark, ...]  # on all answers that the student has given to the question
    texts: Callable[[], Mapping[str, str]]  # of these answers, by fingerprint
    is_second: bool = False

    @property
    def key(self) -> Key:
        return (fitting(self.score.result.student), self.score.result.lesson, self.answer.name)

    @property
    def mark(self) -> Mark | None:
        return (self.score.second_marks if self.is_second else self.score.marks).get(self.answer.name)

    @property
    def earlier(self) -> Mark | None:
        """Return the mark of an earlier answer, if this one is not marked: a proposal."""
        return None if self.is_second else self.score.earlier_marks.get(self.answer.name)

    @property
    def is_open(self) -> bool:
        return self.mark is None and bool(self.answer.text.strip())

    @property
    def has_a_row(self) -> bool:
        """Return whether there is something to mark: an empty answer already has its 0 points."""
        return bool(self.answer.text.strip()) or self.mark is not None

    def named(self, anonymous: bool) -> str:
        """Return the student's name, or the code instead of it."""
        return self.code if anonymous else self.score.result.student


def no_numbers(lesson: str, question: str, student: str) -> Mapping[str, float]:
    """Return no numbers, as for a question that asks for none."""
    return {}


def write_sheets(
    journal: Journal,
    folder: Path,
    code: Code,
    *,
    anonymous: bool = False,
    numbers: Numbers = no_numbers,
    parts: int = 1,
    double: bool = False,
    lesson: str | None = None,
) -> list[Sheet]:
    """Write a table and a page for each written question, in the order of lessons and questions, with the marks so far.

    Only the questions of a `lesson` are written if one is given.

    `folder` is GRADES/marking, and `code` returns a student's code, such as `secret.student_code` with the instructor's
    secret. With `anonymous`, students are named by their codes, and ordered by them; `read_marks` finds the students.
    ``numbers(lesson, question, student)`` returns the numbers of the student's personal world by what they are, and
    with an empty name the numbers of the course's example; the page shows whether they are in the answer. The answers
    are divided into `parts`, each with a table and a page; with `double`, each part has another table and page for a
    second person, and neither shows the other's marks. If a table has marks that were not read in, nothing is written
    and a MarksError is raised.
    """
    known = {each: _answers(journal, code, is_second=each, lesson=lesson) for each in (False, True)}
    there = {each.key[1:] for each in known[False]}
    paths = {question: folder / safe_name("_".join(question)) for question in sorted(there)}
    before = [path for each in paths.values() for path in sorted(folder.glob(f"{each.name}.*csv"))]
    by_key = {is_second: _by_key(answers) for is_second, answers in known.items()}
    for path in before:
        _refuse_to_lose(path, by_key)
    written = []
    for question, path in paths.items():
        for is_second in (False, True) if double else (False,):
            answers = [each for each in known[is_second] if each.key[1:] == question]
            groups = _groups(answers, anonymous)
            missing = [each for each in answers if not each.has_a_row]
            for part in range(parts):
                said = _Said(
                    anonymous, numbers, is_second, alone=double, part=f"{part + 1} of {parts}" * (parts > 1)
                )
                name = path.name + f".{part + 1}of{parts}" * (parts > 1) + f".{SECOND}" * is_second
                if part == 0 or groups[part::parts]:
                    mine = missing if part == 0 else ()
                    written.append(_write_sheet(path.with_name(name), groups[part::parts], mine, said))
    for path in {*before} - {each.table for each in written}:
        path.unlink()
        path.with_suffix(".html").unlink(missing_ok=True)
    return written


@dataclass(frozen=True)
class _Said:
    """What a sheet shows: codes for names, numbers of personal worlds, whose marks, and only them if `alone`."""

    anonymous: bool
    numbers: Numbers
    is_second: bool
    alone: bool
    part: str  # such as "1 of 2", or empty


def _answers(journal: Journal, code: Code, *, is_second: bool, lesson: str | None = None) -> list[_Answer]:
    marks: dict[Key, list[Mark]] = defaultdict(list)
    for mark in journal.marks():
        if bool(mark.is_second) == is_second:
            marks[mark.student, mark.lesson, mark.question].append(mark)
    answers = []
    for score in each_journal_score(journal, lesson):
        key = (score.result.student, score.result.lesson)
        written = {each.name: tuple(marks[*key, each.name]) for each in score.result.written}
        for answer in score.result.written:
            texts = partial(_texts, journal, score, answer.name)
            answers.append(_Answer(score, answer, code(key[0]), written[answer.name], texts, is_second))
    return answers


def _groups(answers: Iterable[_Answer], anonymous: bool) -> list[list[_Answer]]:
    """Return the answers that have a row, together where students wrote the same words and have the same mark."""
    if anonymous:
        answers = sorted(answers, key=lambda each: each.code)
    found: dict[tuple[object, ...], list[_Answer]] = {}
    for each in answers:
        if each.has_a_row:
            mark = each.mark or each.earlier
            has = (mark.points, mark.comment, mark.given_by, mark is each.mark) if mark else ()
            found.setdefault((_words(each.answer.text), *has), []).append(each)
    return list(found.values())


def _words(text: str) -> str:
    """Return the words of an answer, which are the same in copies of it."""
    return " ".join(text.casefold().split())


def _texts(journal: Journal, score: Score, question: str) -> dict[str, str]:
    """Return all answers that a student has given to a question, by their fingerprints."""
    results = (*journal.history(score.result.student, score.result.lesson), score.result)
    return {
        each.fingerprint: each.text for result in results for each in result.written if each.name == question
    }


def _by_key(answers: Iterable[_Answer]) -> dict[Key, _Answer]:
    """Return the answers by the keys that a sheet may have for them: with the student's name or with the code."""
    answers = list(answers)
    return {(each.code, *each.key[1:]): each for each in answers} | {each.key: each for each in answers}


def _write_sheet(
    path: Path, groups: Sequence[Sequence[_Answer]], missing: Sequence[_Answer], said: _Said
) -> Sheet:
    rows = [
        (
            each.named(said.anonymous),
            each.score.result.lesson,
            each.answer.name,
            each.answer.text,
            each.mark.points if each.mark else None,
            each.mark.comment if each.mark else "",
            each.answer.points,
            each.answer.fingerprint,
            *_earlier(each),
            each.mark.given_by if each.mark else "",
            SECOND if said.is_second else "",
            "\n".join(other.named(said.anonymous) for other in others),
        )
        for each, *others in groups
    ]
    answers = [each for group in groups for each in group]
    return Sheet(
        write_whole(path.with_name(f"{path.name}.csv"), table([(*HEADER, *MORE), *rows])),
        write_whole(path.with_name(f"{path.name}.html"), _page(groups, missing, said)),
        len(answers),
        sum(each.is_open for each in answers),
    )


def _earlier(each: _Answer) -> tuple[str, float | None, str]:
    """Return the cells about a mark on an earlier answer."""
    if each.earlier is None:
        return "", None, ""
    return each.texts().get(each.earlier.decided_on, ""), each.earlier.points, each.earlier.comment


def _refuse_to_lose(path: Path, known: Mapping[bool, Mapping[Key, _Answer]]) -> None:
    """Refuse to overwrite marks that were typed in but not yet read."""
    say = f"run `nao-course marks {path.parent.parent} {path}` first, or move it away"
    try:
        rows = read_table(path, HEADER, MORE)
    except TableError as error:
        raise MarksError(f"{error}\nIt may hold marks, so nothing is written: {say}") from None
    for row in rows:
        answer = _found(_key(row), known[row["marking"] == SECOND])
        have = {(number(each.points), _comment(each.comment)) for each in (answer.marks if answer else ())}
        points = plain_number(row["points"])
        given = (row["points"].strip() if points is None else number(points), _comment(row["comment"]))
        if given not in have | {("", "")}:
            raise MarksError(f"{path}, row {row.number}, has a mark that was not read in: {say}")


# --- back in ---


def read_marks(journal: Journal, path: Path, code: Code, given_by: str = "") -> Taken:
    """Read a table's marks, which a person gave, into the journal, all or none of them.

    An answer without points stays as it is, and a row may have the code, as in `write_sheets`, instead of the name. If
    anything is wrong, also if another person has marked an answer since the table was written, a MarksError or
    TableError names the rows.
    """
    if not path.is_file():
        raise MarksError(
            f"there is no {path}: `nao-course marks GRADES` writes the sheets to GRADES/{FOLDER}/"
        )
    answers = _answers(journal, code, is_second=False)
    rows = read_table(path, HEADER, MORE)
    if is_second := any(row["marking"] == SECOND for row in rows):
        answers = _answers(journal, code, is_second=True)
    known = _by_key(answers)
    marks: dict[Key, tuple[int, Mark]] = {}
    problems = [problem for row in rows for problem in _take(row, known, marks, given_by)]
    if problems:
        more = len(problems) - MOST_SAID
        rest = [f"and {more} more"] if more > 0 else []
        raise MarksError("\n".join([f"{path.name}: nothing was read in", *problems[:MOST_SAID], *rest]))
    changed = {
        key: mark
        for key, (_, mark) in marks.items()
        if not any(_same(mark, other) and mark.decided_on == other.decided_on for other in known[key].marks)
    }
    if changed:
        journal.mark(changed.values())
    questions = {_key(row)[1:] for row in rows}
    anonymous = any(known[key].code == row["student"] for row in rows if (key := _key(row)) in known)
    after = [each for each in _answers(journal, code, is_second=is_second) if each.key[1:] in questions]
    return Taken(
        len(marks),
        tuple(changed.values()),
        tuple((each.named(anonymous), each.answer.name) for each in after if each.is_open),
        tuple(
            f"{known[key].named(anonymous)}: {_in_words(before)} before, now {_in_words(mark)}"
            for key, mark in changed.items()
            if (before := known[key].mark)
        ),
        tuple(
            f"{each.named(anonymous)}, {each.answer.name}: {_in_words(first)}, {_in_words(second)}"
            for each in after
            for first, second in each.score.differing
            if first.question == each.answer.name
        ),
    )


def _in_words(mark: Mark) -> str:
    return f"{number(mark.points)}{f' by {mark.given_by}' if mark.given_by else ''}"


def _take(
    row: Row, known: Mapping[Key, _Answer], marks: dict[Key, tuple[int, Mark]], given_by: str
) -> Iterator[str]:
    """Add a row's mark for all students in it, or say what is wrong with it."""
    key = _key(row)
    answer = _found(key, known)
    if answer is None:
        yield f"row {row.number}: {_unknown(key, known)}"
        return
    if not row["points"].strip():
        return
    most, own = answer.answer.points, answer.answer.fingerprint
    points = plain_number(row["points"])
    if points is None:
        given = row["points"].strip()[:40]
        yield f"row {row.number}: points are {given!r}; they must be a number from 0 to {number(most)}"
    elif points > most + 1e-9:
        yield f"row {row.number}: {number(points)} points; the question is worth {number(most)}"
    elif (read := row["answer id"].strip() or own) != own and read not in answer.texts():
        yield f"row {row.number}: the answer id {read[:40]!r} must stay as it was written: it says what was marked"
    else:
        text = answer.answer.text if read == own else answer.texts()[read]
        of = [(key[0], answer, read)]
        for name in filter(None, map(str.strip, row["same answer"].splitlines())):
            other = _found((name, *key[1:]), known)
            if other is None:
                yield f"row {row.number}: {_unknown((name, *key[1:]), known)}"
            else:
                same = [each for each, words in other.texts().items() if _words(words) == _words(text)]
                of += [(name, other, each) for each in same[-1:]]
        for name, each, decided_on in of:
            mark = Mark(
                each.score.result.student,
                *key[1:],
                points,
                _comment(row["comment"]),
                decided_on=decided_on,
                given_by=given_by,
                is_second=each.is_second,
            )
            yield from _refusal(row, name, each, mark)
            before, other_mark = marks.setdefault(each.key, (row.number, mark))
            if not _same(mark, other_mark):
                yield f"row {row.number}: {name!r} has another mark in row {before}"


def _refusal(row: Row, name: str, answer: _Answer, mark: Mark) -> Iterator[str]:
    """Say why a mark may not be taken although it is a number: because of what another person, or the same, gave."""
    first = answer.score.marks.get(answer.answer.name)
    if answer.is_second and first and first.given_by == mark.given_by != "":
        yield (
            f"row {row.number}: {mark.given_by} gave {name!r} the first mark, too; a second mark is another person's, "
            "named with --by"
        )
    there = answer.mark
    if (
        there
        and not _same(mark, there)
        and there.given_by not in ("", mark.given_by, row["marked by"].strip())
    ):
        yield (
            f"row {row.number}: {name!r} has {_in_words(there)} since this sheet was written. Leave the points empty "
            "to keep that mark, or say nao-course regrade GRADES --student NAME --set "
            f"{mark.question}={number(mark.points)} --reason TEXT"
        )


def _found(key: Key, known: Mapping[Key, _Answer]) -> _Answer | None:
    return known.get(key) or _without_zeros(key, known)


def _without_zeros(key: Key, known: Mapping[Key, _Answer]) -> _Answer | None:
    """Return the answer of a student whose number lost its leading zeros in a spreadsheet; None if ambiguous."""
    if not (key[0].isdigit() and key[0].isascii()):
        return None
    meant = [
        each for each in known if each[1:] == key[1:] and each[0].isdigit() and each[0].lstrip("0") == key[0]
    ]
    return known[meant[0]] if len(meant) == 1 else None


def _unknown(key: Key, known: Iterable[Key]) -> str:
    """Say which part of a key nobody knows."""
    student, lesson, question = key
    known = set(known)
    if (lesson, question) not in {each[1:] for each in known}:
        there = sorted({f"{each[1]} {each[2]}" for each in known})
        return (
            f"there is no question {question!r} in lesson {lesson!r}; there are {', '.join(there) or 'none'}"
        )
    hint = (
        " (save as CSV UTF-8: the name's letters were lost)" if "?" in student or "\ufffd" in student else ""
    )
    if _CODE.fullmatch(student):
        hint = " with this secret: read an anonymous sheet on the machine that wrote it, or copy its secret"
    return f"no student {student!r} was graded in {lesson}{hint}"


def _key(row: Row) -> Key:
    return (row["student"], row["lesson"].strip(), row["question"].strip())


def _comment(text: str) -> str:
    return visible(text).strip()


def _same(mark: Mark, other: Mark | None) -> bool:
    return other is not None and (mark.points, mark.comment) == (other.points, other.comment)


# --- the page ---


def _page(groups: Sequence[Sequence[_Answer]], missing: Sequence[_Answer], said: _Said) -> str:
    """Return the page of a question: what it is marked by on top, all answers below."""
    given = [each for group in groups for each in group]
    some = [*given, *missing]
    last = some[-1].answer  # of several versions of the question
    worth = f"{number(last.points)} {'point' if last.points == 1 else 'points'}"
    left = sum(each.is_open for each in given)
    worlds = _worlds(given, said.anonymous, said.numbers)
    titles = ["Second marks" if said.is_second else "", f"part {said.part}" if said.part else ""]
    kind = ", ".join(filter(None, [lesson_title(some[0].score.result.lesson), *titles]))
    nothing = ", ".join(each.named(said.anonymous) for each in missing)
    return page(
        f"To mark: {last.name}",
        element(
            "header",
            element("p", kind, class_="soft small"),
            element("h1", last.number, " " if last.number else "", element("code", last.name)),
            element("p", markdown(last.question)),
        ),
        element(
            "div",
            element("h2", f"What to mark by: {worth}"),
            element("p", markdown(last.rubric.strip() or "No rubric was written."), class_="kept"),
            class_="box calm",
        ),
        element("h2", f"{say_count(len(given), 'answer')}, {left} to mark"),
        *(
            element("article", *_shown(group, said, worlds, _otherwise(group, groups, said)), class_="card")
            for group in groups
        ),
        element("h2", "No answer: 0 points") if missing else None,
        element("p", nothing) if missing else None,
    )


def _worlds(given: Sequence[_Answer], anonymous: bool, numbers: Numbers) -> dict[str, Mapping[str, float]]:
    """Return the numbers of the personal worlds of all who answered, by their names, and of the example."""
    if not given:
        return {}
    _, lesson, question = given[0].key
    found = {each.named(anonymous): numbers(lesson, question, each.score.result.student) for each in given}
    found[EXAMPLE] = numbers(lesson, question, "")
    return {name: of for name, of in found.items() if of}


def _otherwise(group: Sequence[_Answer], groups: Iterable[Sequence[_Answer]], said: _Said) -> str:
    """Return who wrote the same words as a group and has another mark, or none."""
    alike = [
        each
        for each in groups
        if each is not group and _words(each[0].answer.text) == _words(group[0].answer.text)
    ]
    return "; ".join(
        f"{', '.join(one.named(said.anonymous) for one in each)} "
        f"({_in_words(each[0].mark) if each[0].mark else 'to mark'})"
        for each in alike
    )


def _shown(
    group: Sequence[_Answer], said: _Said, worlds: Mapping[str, Mapping[str, float]], otherwise: str
) -> Iterator[Markup]:
    each, *others = group
    mark = each.mark
    state = "to mark"
    if mark:
        by = f" by {mark.given_by}" if mark.given_by else ""
        state = f"{number(mark.points)} of {number(each.answer.points)}{by}"
    if each.earlier:
        state = f"to mark again ({number(each.earlier.points)} for an earlier answer)"
    name = element("h3", element("bdi", each.named(said.anonymous)))
    yield element("div", name, element("span", state, class_="points"), class_="top")
    if others:
        names = ", ".join(other.named(said.anonymous) for other in others)
        yield element("p", "The same words, marked once for all: ", names, class_="small warn")
    if otherwise:
        yield element("p", "The same words, in another row: ", otherwise, class_="small warn")
    yield element("div", each.answer.text.strip(), class_="said", dir="auto")
    for one in group:
        if one.answer.note:
            yield element("p", one.answer.note, class_="soft small")
        for line in compare_numbers(one.answer.text, one.named(said.anonymous), worlds):
            who = f"{one.named(said.anonymous)}: " if others else ""
            yield element("p", who, line, class_="soft small")
        for first, second in one.score.differing if not said.alone else ():
            if first.question == one.answer.name:
                both = f"{one.named(said.anonymous)} has two marks: {_in_words(first)}, {_in_words(second)}"
                yield element("p", both, class_="small warn")
    if mark and mark.comment:
        yield element("p", "Comment: ", mark.comment, class_="soft small kept")
    if each.earlier:
        text, points, comment = _earlier(each)
        yield element("p", f"The earlier answer, which got {number(points or 0)}:", class_="soft small")
        yield element("div", text.strip(), class_="said soft", dir="auto")
        if comment:
            yield element("p", "Comment: ", comment, class_="soft small kept")
