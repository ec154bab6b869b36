"""What has to be true after a run over a catalogue, of each attack and of the run as a whole."""

import re
import unicodedata
from collections.abc import Sequence
from html.parser import HTMLParser

from nao_course.instructor.autograding import tries
from nao_course.instructor.sandbox.protocol import MOST_WAITING, SECONDS_IN_ALL
from tests.attacks.range import Attack, Graded, Range, hidden_numbers, honest, honest_points, points, told

MOST_MEMORY = 1000 * 2**20  # bytes, of the grader's own process with two jobs
# Of running and sleeping for each purpose; on a busy machine a worker waits in addition
MOST_SECONDS = (
    SECONDS_IN_ALL + tries.SECONDS_ONCE_MORE + tries.SECONDS_OF_REFERENCES + tries.SECONDS_OF_RECORDED
) * (1 + MOST_WAITING)
_NEUTRAL = "student"


def hold(graded: Graded, attack: Attack, alone: Graded, hidden: set[str]) -> None:
    """All that has to be true of one attack."""
    gained_nothing(graded, attack)
    page_is_safe(graded, attack, hidden)
    neighbours_are_undisturbed(graded, attack, alone)


def is_no_better_off(graded: Graded, attack: Attack) -> None:
    """No exercise earns more than its honest score, in time; an attack that is not graded has a reason."""
    result = graded.results[student_of(graded, attack)]
    said = told(result)
    assert not [name for name, earned in points(result).items() if earned > attack.honest.get(name, 0.0)], (
        said
    )
    assert result.seconds < MOST_SECONDS, said
    assert result.status == "graded" or result.reason, said


def gained_nothing(graded: Graded, attack: Attack) -> None:
    """The attack has exactly the honest score, stated beforehand, in time, and says what it has to say."""
    student = student_of(graded, attack)
    result = graded.results[student]
    said = told(result)
    if attack.races:
        is_no_better_off(graded, attack)
    else:
        assert points(result) == dict(attack.honest), said
    assert result.status == ("refused" if attack.refused else "graded"), said
    assert bool(result.reason) == attack.refused, said
    assert result.seconds < MOST_SECONDS, said
    assert attack.says in said, said
    assert not any(_tricks(note) for note in result.notes), said


def neighbours_are_undisturbed(graded: Graded, attack: Attack, alone: Graded) -> None:
    """The honest students before and after it have their points and, word for word, their pages."""
    neighbours = neighbours_of(graded, attack)
    assert neighbours.keys() == {"right", "half"}
    for kind, student in neighbours.items():
        result = graded.results[student]
        assert points(result) == honest_points(attack, kind), told(result)
        assert result.notes == (), told(result)
        undisturbed = next(
            name
            for name in alone.pages
            if name.endswith(f"-{kind}") and _lesson(alone, name) == attack.lesson
        )
        assert _neutral(graded.pages[student], student) == _neutral(alone.pages[undisturbed], undisturbed)


def page_is_safe(graded: Graded, attack: Attack, hidden: set[str]) -> None:
    """The student's page holds no hidden number, no element of an attacker's and no characters that play tricks."""
    student = student_of(graded, attack)
    page = graded.pages[student]
    assert page.rstrip().endswith("</html>")
    numbers = set(re.findall(r"\d+\.\d+", page))
    assert not [each for each in hidden if any(number.startswith(each) for number in numbers)]
    for text in attack.hides:
        assert text not in page
    assert not _tricks(page)
    parser = Elements()
    parser.feed(page)
    assert "nao_attack" not in parser.seen


def nothing_is_left(graded: Graded, status: int = 0) -> None:
    """The run ended well, each student has one row, and nothing but the grades has changed."""
    assert graded.status == status, graded.output[-3000:]
    assert graded.students == sorted(graded.expected)
    assert graded.again == 0
    assert graded.processes == []
    assert graded.changed == []
    assert graded.heard == []
    assert not _tricks(graded.output), "a terminal would obey it"
    assert graded.peak < MOST_MEMORY, f"the grader itself held {graded.peak / 2**20:.0f} MB"


def alone(field: Range, attacks: Sequence[Attack]) -> Graded:
    """An undisturbed run: honest students only, of each lesson that the attacks are of."""
    lessons = {attack.lesson: honest(attack, "right") for attack in attacks}
    return field.run(list(lessons.values()))


def hidden(field: Range) -> set[str]:
    """Numbers that no page may hold."""
    return hidden_numbers(field.assignment)


def student_of(graded: Graded, attack: Attack) -> str:
    """The student's name of an attack."""
    return next(name for name in graded.expected if name.partition("-")[2] == attack.name)


def neighbours_of(graded: Graded, attack: Attack) -> dict[str, str]:
    """The names of the honest students beside an attack, by how much of their work is right."""
    place = graded.expected.index(student_of(graded, attack))
    return {name.partition("-")[2]: name for name in (graded.expected[place - 1], graded.expected[place + 1])}


def _tricks(text: str) -> set[str]:
    """Characters that control a terminal or turn the direction of a text."""
    return {each for each in text if unicodedata.category(each) in ("Cc", "Cs") and each not in "\n\t"} | (
        set(text) & set("\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
    )


def _lesson(graded: Graded, student: str) -> str:
    return graded.results[student].lesson


def _neutral(page: str, student: str) -> str:
    return page.replace(student, _NEUTRAL)


class Elements(HTMLParser):
    """Collects all that a browser would take for elements and attributes."""

    def __init__(self) -> None:
        super().__init__()
        self.seen = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.seen += f" {tag} {attrs}"

    def handle_comment(self, data: str) -> None:
        self.seen += data
