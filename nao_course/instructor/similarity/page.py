"""A page with pairs of similar notebooks: their code side by side, with what both contain marked."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence

from nao_course._internal.counts import say_count
from nao_course.instructor.reports.html import Markup, element, join, lesson_title, page
from nao_course.instructor.similarity.comparing import LENGTH, SimilarPair

MOST_SHOWN = 100  # pairs of a lesson whose code is on the page
NEAR = 4  # lines before and after a marked passage
_MEANING = (
    "This page shows that code is alike, not why. Before you accuse anybody, read both sides, look for what only a "
    "copy explains (the same error, the same odd detour), and talk to both students: they may have worked together as "
    "you allowed, or both may have copied from a third source. The page does not show who copied from whom."
)
_MEASURE = (
    f"A fingerprint is a run of {LENGTH} characters of the code, without comments and white space, and with every name "
    "replaced by the same letter. What the release gives, what the known right answers contain, and what many of the "
    "notebooks contain is taken out. The share refers to the notebook with fewer fingerprints left. Passages that "
    "both have are marked, and other lines are shown near them only."
)


def similar_page(
    pairs: Mapping[str, Sequence[SimilarPair]], compared: Mapping[str, int], left_out: Sequence[str]
) -> str:
    """Make the page.

    Parameters
    ----------
    pairs : mapping of str to sequence of SimilarPair
        By lesson, the most similar pair first.
    compared : mapping of str to int
        Number of notebooks that were compared, by lesson.
    left_out : sequence of str
        What was not compared, with the reasons.

    Returns
    -------
    str
        HTML without scripts or links to other files.
    """
    many = sum(map(len, pairs.values()))
    return page(
        "Similar notebooks",
        element("h1", say_count(many, "pair") + " of similar notebooks"),
        element("div", element("p", _MEANING), class_="box warn"),
        element("p", _MEASURE, class_="soft small"),
        *(_lesson(lesson, pairs.get(lesson, ()), number) for lesson, number in sorted(compared.items())),
        _left_out(left_out),
        wide=True,
    )


def _lesson(lesson: str, pairs: Sequence[SimilarPair], compared: int) -> Markup:
    title = element("h2", lesson_title(lesson))
    if not pairs:
        return join(title, element("p", f"{say_count(compared, 'notebook')} compared, no similar pair."))
    heads = [element("th", each, scope="col") for each in ("Students", "Group of")]
    heads += [element("th", each, class_="number", scope="col") for each in ("Share", "Fingerprints")]
    sizes = _group_sizes(pairs)
    rows = [
        element(
            "tr",
            element("td", _names(each, _anchor(lesson, number) if number < MOST_SHOWN else "")),
            element("td", f"{sizes[each.first.student]} students"),
            element("td", f"{100 * each.share:.0f} %", class_="number"),
            element("td", str(each.shared), class_="number"),
        )
        for number, each in enumerate(pairs)
    ]
    return join(
        title,
        element("p", f"{say_count(compared, 'notebook')} compared."),
        element("table", element("thead", element("tr", *heads)), element("tbody", *rows)),
        *(_pair(each, _anchor(lesson, number)) for number, each in enumerate(pairs[:MOST_SHOWN])),
        element("p", f"The code of the first {MOST_SHOWN} pairs is shown.")
        if len(pairs) > MOST_SHOWN
        else None,
    )


def _group_sizes(pairs: Sequence[SimilarPair]) -> dict[str, int]:
    """Return how many students are connected to each student by similar pairs."""
    groups: dict[str, set[str]] = defaultdict(set)
    for each in pairs:
        names = {each.first.student, each.second.student}
        joined = names.union(*(groups[name] for name in names))
        for name in joined:
            groups[name] = joined
    return {name: len(group) for name, group in groups.items()}


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
    said = f"{100 * pair.share:.0f} % of the smaller notebook, {say_count(pair.shared, 'fingerprint')}"
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
