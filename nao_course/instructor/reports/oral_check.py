"""Questions for five minutes with a student about the student's own submission: changed lines, a result, a reason."""

import ast
import json
import random
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from nao_course.exercises.cells import SHOWN, source_of, stated_role
from nao_course.exercises.exercise import Question
from nao_course.instructor.authoring.mutation import make_mutants
from nao_course.instructor.gradebook.records import SubmissionResult, WrittenAnswer
from nao_course.instructor.reports.html import Markup, element, join, lesson_title, markdown, page, prose

FOLDER = "oral"  # in GRADES
CHANGED = 2  # exercises of which a line is changed
MOST_CODE = 6000  # characters of a function of which a line is changed
MOST_SHOWN = 400  # characters of a result
# Changes after which most functions still return something, so that "what happens?" takes some thought.
_OPERATORS = re.compile(
    r"(terms|first two) swapped|not transposed|other axis|.* for .*"
    r"|ReplaceBinaryOperator_(Add_Sub|Sub_Add|Mul_Div|Div_Mul)|ReplaceUnaryOperator_Delete_(USub|Not)"
    r"|ReplaceComparisonOperator_(Lt_LtE|LtE_Lt|Gt_GtE|GtE_Gt|Eq_NotEq)"
)
_DRAWING = re.compile(r"Drawing\((.*)\)", re.DOTALL)
_ABOUT = (
    "For the person who asks; students must not see this page. There is no list of right answers, because the "
    "questions are about the student's own code: perhaps nothing happens. To find out, make the change in the notebook "
    "and run the check below it. The answers show whether a student understands the code, and not who wrote it."
)


@dataclass(frozen=True)
class ChangedLine:
    """A line of a student's code for an exercise, and what is to be imagined in its place.

    It may be written in several lines, which are numbered from 1.
    """

    exercise: str
    code: str
    first: int
    last: int
    after: str


@dataclass(frozen=True)
class OralCheck:
    """What a student is asked: changed lines, a result in the notebook, and why something is so.

    The reason is asked about the student's written answer, or else about a question of the lesson. What the submission
    does not have is None or empty.
    """

    student: str
    changed: tuple[ChangedLine, ...] = ()
    shown: str = ""
    written: WrittenAnswer | None = None
    question: Question | None = None

    @property
    def count(self) -> int:
        """How many questions there are."""
        return len(self.changed) + bool(self.shown) + bool(self.written or self.question)


def oral_check(
    result: SubmissionResult, code_of: Callable[[str], str], notebook: bytes, questions: Sequence[Question]
) -> OralCheck:
    """Return what to ask a student, the same each time for the same submission.

    `code_of` returns the student's code for an exercise, or an empty text, `notebook` is the file that was handed in,
    and `questions` are the lesson's. Exercises with the most points come first.
    """
    choice = random.Random(f"{result.student} {result.lesson} {result.submission}")
    names = [each.name for each in result.exercises]
    ranked = sorted(result.exercises, key=lambda each: (-each.earned, choice.random()))
    found = (changed_line(each.name, code_of(each.name), choice) for each in ranked)
    changed = [each for each in found if each is not None]
    shown = results_shown(notebook, [each.name for each in result.exercises if each.earned] or names)
    written = [each for each in result.written if each.text.strip()]
    return OralCheck(
        result.student,
        tuple(changed[:CHANGED]),
        choice.choice(shown) if shown else "",
        choice.choice(written) if written else None,
        choice.choice(questions) if questions and not written else None,
    )


def changed_line(exercise: str, code: str, choice: random.Random) -> ChangedLine | None:
    """Change one line of a function or class; return None for code in which no line can be changed."""
    if not code or len(code) > MOST_CODE:
        return None
    try:
        tree = ast.parse(code)
        mutants = make_mutants(exercise, code, _OPERATORS)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return None
    places = {
        ast.unparse(node).splitlines()[0]: _lines(node)
        for node in ast.walk(tree)
        if isinstance(node, ast.stmt)
    }
    found = list[ChangedLine]()
    for mutant in mutants:
        before = {line.strip() for line in mutant.original.splitlines()} - {
            line.strip() for line in mutant.source.splitlines()
        }
        if len(before) == len(mutant.lines) == 1 and (place := places.get(*before)):
            found.append(ChangedLine(exercise, code, *place, *mutant.lines))
    return choice.choice(found) if found else None


def _lines(node: ast.stmt) -> tuple[int, int]:
    """Return the first and the last line of a statement without the statements in it."""
    body = getattr(node, "body", [])
    end = body[0].lineno - 1 if body else node.end_lineno or node.lineno
    return node.lineno, max(end, node.lineno)


def results_shown(notebook: bytes, names: Sequence[str]) -> list[str]:
    """Return the results with a number that a notebook shows below cells that use one of these functions."""
    try:
        cells = json.loads(notebook)["cells"]
        used = re.compile(rf"\b({'|'.join(map(re.escape, names))})\b") if names else None
        return [
            text
            for cell in cells
            if used and stated_role(cell) in SHOWN and used.search(source_of(cell))
            for text in _texts(cell)
            if re.search(r"\d", text)
        ]
    except (ValueError, TypeError, KeyError, AttributeError, SyntaxError, RecursionError, MemoryError):
        return []


def _texts(cell: dict[str, object]) -> Iterator[str]:
    """Yield what a cell printed or returned; of a figure, its description."""
    for output in cell.get("outputs", []):  # type: ignore[attr-defined]
        data = output.get("data", {})
        text = "".join(output.get("text", data.get("text/plain", ""))).strip()
        if (drawing := _DRAWING.fullmatch(text)) and drawing[1][:1] in "'\"":
            text = str(ast.literal_eval(drawing[1]))
        if output.get("output_type") in ("stream", "execute_result") and text:
            yield text if len(text) <= MOST_SHOWN else f"{text[:MOST_SHOWN]} [...]"


# --- the page ---


def oral_page(lesson: str, checks: Sequence[OralCheck]) -> str:
    """Return the page of a lesson, with the questions for each student."""
    return page(
        f"Oral check: {lesson}",
        element("p", lesson_title(lesson), class_="soft small"),
        element("h1", "Five minutes about your own work"),
        element("div", element("p", _ABOUT), class_="box warn"),
        *(_student(each) for each in checks),
    )


def _student(check: OralCheck) -> Markup:
    questions = [*map(_changed, check.changed)]
    if check.shown:
        questions.append(
            join(
                element("p", "Your notebook shows this result:"),
                element("pre", check.shown),
                element(
                    "p",
                    "Which of your functions is it computed with, and what would make it larger or smaller?",
                ),
            )
        )
    if check.written:
        questions.append(
            join(
                element("p", markdown(check.written.question)),
                element("p", "You wrote:", class_="label"),
                element("p", check.written.text, class_="said"),
                element("p", "Explain it with a sketch or an example. When would it be otherwise?"),
                element(
                    "p", "For you, the rubric: ", markdown(check.written.rubric.strip()), class_="soft small"
                ),
            )
        )
    elif check.question:
        right = check.question.right
        questions.append(
            join(
                element("p", prose(check.question.text), " Why?"),
                element(
                    "p", "For you: ", prose(f"{right} {check.question.choices[right]}"), class_="soft small"
                ),
            )
        )
    return element(
        "section",
        element("h2", element("bdi", check.student)),
        element("ol", *(element("li", each) for each in questions))
        if questions
        else element("p", "The submission has nothing to ask about."),
    )


def _changed(changed: ChangedLine) -> Markup:
    before, line, after = _around(changed)
    return join(
        element("p", "This is your ", element("code", changed.exercise), ":"),
        element("pre", before, element("mark", line), after),
        element("p", "The marked line becomes"),
        element("pre", changed.after),
        element("p", "What happens, and for which inputs?"),
    )


def _around(changed: ChangedLine) -> tuple[str, str, str]:
    """Divide the code into what is before the changed line, the line without its indent, and what is after it."""
    lines = [f"{line}\n" for line in changed.code.split("\n")]
    first, last = changed.first - 1, changed.last
    changed_text = "".join(lines[first:last]).lstrip(" ")
    indent = " " * (len(lines[first]) - len(lines[first].lstrip(" ")))
    return "".join(lines[:first]) + indent, changed_text, "".join(lines[last:])
