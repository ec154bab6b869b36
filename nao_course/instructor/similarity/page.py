"""A page with pairs of similar notebooks: their code side by side, with what both contain marked."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from nao_course._internal.counts import say_count
from nao_course.instructor.reports.html import Markup, element, join, lesson_title, page
from nao_course.instructor.similarity.comparing import (
    COMMON,
    COMMON_SHARE,
    LENGTH,
    MOST_SHOWN,
    CommonCode,
    Comparison,
    SimilarPair,
)
from nao_course.instructor.similarity.course_answers import SAME, SAME_WORDS, CourseAnswers, SameWords

NEAR = 4  # lines before and after a marked passage
_MEANING = (
    "This page shows that code is alike, not why. Before you accuse anybody, read both sides, look for what only a "
    "copy explains (the same error, the same odd detour), and talk to both students: they may have worked together as "
    "you allowed, or both may have copied from a third source. The page does not show who copied from whom."
)
_MEASURE = (
    f"A fingerprint is a run of {LENGTH} characters of the code, without comments and white space, and with every name "
    "replaced by the same letter. What the release gives and what the known right answers contain is taken out, and so "
    f"is common code: what more than {COMMON} different notebooks, or {100 * COMMON_SHARE:.0f} % of a larger class, "
    "contain. Notebooks with much common code are listed below the pairs. A share is the part of a student's remaining "
    "fingerprints that the other student has too; if only one of the two shares is large, the other notebook contains "
    "much more. The members of a group are similar to each other, and not only to one of them. Passages that both have "
    "are marked, and other lines are shown near them only."
)
_COMMON = (
    "The percentage is the part of each notebook that is common code. It was taken out before the pairs were compared, "
    "so these notebooks may be copies of each other that are in no pair. A hint that you gave to all explains it too. "
    "The common code is marked in the first notebook:"
)

_COURSE_ANSWERS = (
    f"An exercise is counted if the notebook contains at least {100 * SAME:.0f} % of the fingerprints of the reference "
    "solution or of an alternative of the course, whatever the names and comments are. Short exercises are left out, "
    "because independent answers to them are equal. Students are listed from half of the other exercises on. The "
    "solutions may be public, so ask the student to explain the code."
)
_SAME_WORDS = (
    f"Answers are the same if they have {100 * SAME_WORDS:.0f} % of their runs of three words in common; capital "
    "letters and punctuation do not count. The first student's answer is shown."
)


@dataclass(frozen=True)
class Found:
    """What was found in a lesson."""

    comparison: Comparison
    course_answers: Sequence[CourseAnswers] = ()
    same_words: Sequence[SameWords] = ()


def similar_page(found: Mapping[str, Found], left_out: Sequence[str]) -> str:
    """Make the HTML page of similar notebooks by lesson, without scripts or links to other files.

    `left_out` says what was not compared, with the reasons.
    """
    many = sum(len(each.comparison.pairs) for each in found.values())
    return page(
        "Similar notebooks",
        element("h1", say_count(many, "pair") + " of similar notebooks"),
        element("div", element("p", _MEANING), class_="box warn"),
        element("p", _MEASURE, class_="soft small"),
        *(_lesson(lesson, each) for lesson, each in sorted(found.items())),
        _left_out(left_out),
        wide=True,
    )


def _lesson(lesson: str, of_lesson: Found) -> Markup:
    found = of_lesson.comparison
    pairs = found.pairs
    rows = [
        (
            _names(each, _anchor(lesson, number) if number < MOST_SHOWN else ""),
            f"{each.group} students",
            *map(_percent, each.shares),
            str(each.shared),
        )
        for number, each in enumerate(pairs)
    ]
    return join(
        element("h2", lesson_title(lesson)),
        element(
            "p", f"{say_count(found.compared, 'notebook')} compared, {say_count(len(pairs), 'similar pair')}."
        ),
        _table(("Students", "Group of", "Share of the first", "Share of the second", "Fingerprints"), rows),
        *_course_answers(of_lesson.course_answers),
        *_same_words(of_lesson.same_words),
        *(_common(each) for each in found.common),
        *(_pair(each, _anchor(lesson, number)) for number, each in enumerate(pairs[:MOST_SHOWN])),
        element("p", f"The code of the first {MOST_SHOWN} pairs is shown.")
        if len(pairs) > MOST_SHOWN
        else None,
    )


def _table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> Markup | None:
    """Return a table whose columns after the second are numbers."""
    if not rows:
        return None
    head = (
        element("th", each, class_="number" if at > 1 else "", scope="col") for at, each in enumerate(heads)
    )
    body = (
        element(
            "tr", *(element("td", each, class_="number" if at > 1 else "") for at, each in enumerate(row))
        )
        for row in rows
    )
    return element("table", element("thead", element("tr", *head)), element("tbody", *body))


def _common(common: CommonCode) -> Markup:
    """Return the notebooks that consist to a large part of the same common code, and this code once."""
    first = common.works[0]
    shares = zip(common.works, common.shares, strict=True)
    title = f"{say_count(len(common.works), 'notebook')} with the same common code"
    return element(
        "section",
        element("div", element("h3", title), class_="top"),
        element("p", "; ".join(f"{work.student} ({_percent(share)})" for work, share in shares)),
        element("p", _COMMON, class_="soft small"),
        element("p", first.student, class_="label"),
        element("pre", _marked(first.code, common.passages)),
        class_="card",
    )


def _course_answers(found: Sequence[CourseAnswers]) -> Iterator[Markup]:
    if found:
        yield element("h3", f"The course's own answers: {say_count(len(found), 'student')}")
        yield element("p", _COURSE_ANSWERS, class_="soft small")
        rows = [
            (each.student, ", ".join(each.exercises), f"{len(each.exercises)} of {each.of}") for each in found
        ]
        if table := _table(("Student", "Exercises", "Count"), rows):
            yield table


def _same_words(found: Sequence[SameWords]) -> Iterator[Markup]:
    if found:
        yield element("h3", f"The same words: {say_count(len(found), 'group')}")
        yield element("p", _SAME_WORDS, class_="soft small")
    for each in found:
        names = ", ".join([*each.students, *(["the course's model answer"] if each.is_model else [])])
        yield element(
            "div",
            element("p", element("code", each.question), " ", names),
            element("div", each.text.strip(), class_="said", dir="auto"),
            class_="card",
        )


def _percent(share: float) -> str:
    return f"{100 * share:.0f} %"


def _anchor(lesson: str, number: int) -> str:
    return f"pair-{lesson}-{number + 1}"


def _names(pair: SimilarPair, anchor: str = "") -> Markup:
    names = join(pair.first.student, " and ", pair.second.student)
    return element("a", names, href=f"#{anchor}") if anchor else names


def _pair(pair: SimilarPair, anchor: str) -> Markup:
    sides = [
        element(
            "div", element("p", work.student, class_="label"), element("pre", _marked(work.code, passages))
        )
        for work, passages in zip((pair.first, pair.second), pair.passages, strict=True)
    ]
    said = (
        f"{' and '.join(map(_percent, pair.shares))} of their code, {say_count(pair.shared, 'fingerprint')}"
    )
    return element(
        "section",
        element("div", element("h3", _names(pair)), element("span", said, class_="points"), class_="top"),
        element("div", *sides, class_="sides"),
        class_="card",
        id=anchor,
    )


def _marked(code: str, passages: Sequence[tuple[int, int]]) -> Markup:
    """Return a code with its passages marked, and the other lines only near them."""
    parts: list[str] = []
    at = 0
    for start, end in passages:
        parts += [_shortened(code[at:start], NEAR if at else 0, NEAR), element("mark", code[start:end])]
        at = end
    return join(*parts, _shortened(code[at:].rstrip(), NEAR, 0))


def _shortened(text: str, first: int, last: int) -> str:
    """Return the first and last lines of a text, with the number of the lines between them."""
    lines = text.splitlines(keepends=True)
    between = len(lines) - first - last
    if between < 2:
        return text
    return "".join([*lines[:first], f"[{between} other lines]\n", *lines[first + between :]])


def _left_out(lines: Sequence[str]) -> Markup | None:
    if not lines:
        return None
    return join(element("h2", "Not compared"), element("ul", *(element("li", each) for each in lines)))
