"""A student's page of a lesson: what works, what does not and in which way, and never what is hidden."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Literal

from nao_course._internal.counts import say_count
from nao_course.exercises.versions import in_words
from nao_course.homework import REQUEST
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.gradebook.late import Lateness, LatePolicy
from nao_course.instructor.gradebook.records import (
    ExerciseResult,
    Mark,
    Override,
    Request,
    State,
    SubmissionResult,
    WrittenAnswer,
)
from nao_course.instructor.gradebook.scores import Comments, Score, score
from nao_course.instructor.reports.html import (
    Markup,
    bar,
    card,
    element,
    join,
    lesson_title,
    markdown,
    number,
    page,
    prose,
    write_whole,
)

LONGEST = 20_000  # characters of one text that are shown
_STATES: dict[State, tuple[str, str, str]] = {  # its colour, in short, and what it means
    "right": ("good", "Right", ""),
    "wrong": ("warn", "Not right yet", "Your function runs, but its answer is wrong for some inputs."),
    "raised": ("warn", "It stops with an error", "An error is raised before there is an answer."),
    "timed out": (
        "warn",
        "It takes too long",
        "There was no answer in time. Is there a loop that never ends, or one over single pixels "
        "where NumPy could do all of them at once?",
    ),
    "not run": (
        "warn",
        "Not run",
        "The time of your submission was used up before this exercise could be run.",
    ),
    "died": (
        "bad",
        "It ends Python",
        "The whole process ended before there was an answer. Look for `exit()`, for a recursion that never ends, "
        "and for arrays that are far too large.",
    ),
    "no usable answer": (
        "warn",
        "Its answer cannot be used",
        "What it returns is of a kind that cannot be compared. Return plain numbers, arrays, lists or tuples.",
    ),
    "changes its input": (
        "warn",
        "It changes its input",
        "The answers are right, but the array that the function is given is another one afterwards. "
        "Work on a copy: `array.copy()`.",
    ),
    "not attempted": (
        "calm",
        "Not written yet",
        "Here the function still raises `NotImplementedError`, as in the blank notebook.",
    ),
    "not found": (
        "bad",
        "Not found",
        "Your notebook does not define it. Was it renamed or deleted, or does its cell fail before the def? "
        "Restart the kernel, run all cells from the top and look where it stops.",
    ),
    "undecided": (
        "calm",
        "A person decides",
        "A person decides about the points, and changes them on this page.",
    ),
}


# States of which the grader's words say it better.
_TOLD_BY_TEXT = ("wrong", "raised", "changes its input", "not found")


@dataclass(frozen=True)
class Said:
    """A remark on an exercise, untrusted: a state in a few words, plain text, code, or a box that stands out.

    The title is above code or in a box; the colour of a state or box is good, warn, bad or calm.
    """

    kind: Literal["state", "text", "code", "box"]
    text: str
    title: str = ""
    colour: str = ""


def write(
    result: SubmissionResult,
    folder: Path,
    overrides: Iterable[Override] = (),
    marks: Iterable[Mark] = (),
    policy: LatePolicy | None = None,
    comments: Comments | None = None,
    requests: Iterable[Request] = (),
) -> Path:
    """Write a student's page, GRADES/feedback/STUDENT/NN_name.html, and return its path.

    Only overrides, marks and requests of this student and lesson count; comments are by lesson, exercise and kind of
    the wrong answer.
    """
    path = folder / safe_name(result.student) / f"{safe_name(result.lesson)}.html"
    return write_whole(path, feedback_page(score(result, overrides, marks, policy, comments, requests)))


def feedback_page(score: Score) -> str:
    """Return a student's page: the same bytes for the same score."""
    result = score.result
    return page(
        f"{lesson_title(result.lesson)}: your feedback",
        element(
            "header",
            element("p", "Feedback for ", element("bdi", result.student), class_="soft small"),
            element("h1", lesson_title(result.lesson)),
            *_score(score),
        ),
        *(_refused(result) if result.status == "refused" else _exercises(score)),
        *_written(score),
        *_unread_request(score),
        *_left_out(result),
        _footer(result),
    )


def _score(score: Score) -> Iterator[Markup]:
    """Return the total score, the bar, and a sentence that explains them."""
    if score.points == 0 and score.result.status == "graded":
        yield element("p", "This lesson gives no points: it is there to try things out.")
        return
    waiting = sum(each.points for each in score.waiting)
    of = f" of {_points(score.points)}{' so far' if waiting else ''}"
    yield element("p", number(score.earned), element("span", of), class_="score")
    yield bar(score.earned, waiting, score.points)
    if score.lateness:
        yield from _deadline(score.lateness, score.deducted)
    exercises = score.result.exercises
    if score.result.status == "graded" and exercises:
        right = sum(_whole(score, each) for each in exercises)
        text = f"{right} of {say_count(len(exercises), 'exercise')} {'has' if right == 1 else 'have'} all points."
        if right == len(exercises):
            text = "Every exercise has all its points. Well done!"
        yield element("p", text)
    if waiting:
        answers = "A written answer" if len(score.waiting) == 1 else f"{len(score.waiting)} written answers"
        verb = "waits" if len(score.waiting) == 1 else "wait"
        yield element("p", f"{answers} ({_points(waiting)}) {verb} for a person's mark.")


def _deadline(lateness: Lateness, deducted: float) -> Iterator[Markup]:
    """Return a box about an extension or a late submission."""
    lines = []
    if lateness.extended:
        lines.append(f"Your deadline was extended to {_time(lateness.due)}.")
    if lateness.is_unmeasured:
        lines.append(
            f"The deadline was {_time(lateness.due)}. The platform marks your submission as late, but does not say by "
            "how much, so nothing was deducted."
        )
    elif lateness.late and lateness.handed_in:
        start = "" if lateness.extended else f"The deadline was {_time(lateness.due)}. "
        days = say_count(lateness.days, "day")
        lines.append(
            f"{start}You handed in at {_time(lateness.handed_in)}, and every day begun after the deadline counts: "
            f"{days}. This costs {100 * lateness.share:.0f} % of your points: {_points(deducted)}."
        )
    if lines:
        yield _box("warn" if lateness.late else "calm", "Deadline", "\n".join(lines))


def _time(time: datetime) -> str:
    return time.isoformat(" ", "minutes")


def _whole(score: Score, exercise: ExerciseResult) -> bool:
    return score.of(exercise) >= exercise.points and (
        exercise.state == "right" or exercise.name in score.overrides
    )


def _exercises(score: Score) -> Iterator[Markup]:
    """Return blocks for solved exercises (short), failed exercises, and unwritten exercises (short)."""
    plain = [each for each in score.result.exercises if _is_plain(score, each, "right")]
    unwritten = [each for each in score.result.exercises if _is_plain(score, each, "not attempted")]
    others = [each for each in score.result.exercises if each not in plain and each not in unwritten]
    if plain:
        yield element("h2", "What works")
        yield _short_list(plain, "good", "✔ ")
    if others:
        yield element("h2", "What to look at" if plain else "Your exercises")
        for each in others:
            yield element("article", *_exercise(score, each), class_="card")
    if unwritten:
        _, short, meaning = _STATES["not attempted"]
        yield element("h2", short)
        yield element("p", prose(meaning), class_="soft")
        yield _short_list(unwritten, "calm", "○ ")


def _is_plain(score: Score, exercise: ExerciseResult, state: State) -> bool:
    """Return True if an exercise needs no details beyond its state and points."""
    by_people = {*score.overrides, *score.requests}
    by_people |= {name for name, each in score.earlier_overrides.items() if each.points != exercise.earned}
    return exercise.state == state and not exercise.with_reference and exercise.name not in by_people


def _short_list(exercises: Iterable[ExerciseResult], colour: str, sign: str) -> Markup:
    rows = [
        element(
            "li",
            element("span", element("span", sign, class_=colour, aria_hidden="true"), *_title(each)),
            element("span", _earned(each), class_="points"),
            *(element("p", "One thing: ", prose(note), class_="small soft") for note in each.notes),
        )
        for each in exercises
    ]
    return element("ul", *rows, class_="right")


def _earned(exercise: ExerciseResult) -> str:
    if exercise.state == "right":
        return _points(exercise.earned)
    return f"{number(exercise.earned)} of {_points(exercise.points)}"


def _exercise(score: Score, exercise: ExerciseResult) -> Iterator[Markup]:
    """Return one exercise: its points, its result, the place of the error, the public report, and advice."""
    points = f"{number(score.of(exercise))} of {_points(exercise.points)}"
    yield element(
        "div", element("h3", *_title(exercise)), element("span", points, class_="points"), class_="top"
    )
    for each in said_of(score, exercise):
        match each.kind:
            case "state":
                yield element("p", each.text, class_=f"state {each.colour}")
            case "code":
                yield element("p", each.title, class_="label")
                yield element("pre", element("code", _cut(each.text)))
            case "box":
                yield _box(each.colour, each.title, each.text)
            case _:
                yield element("p", prose(_cut(each.text)))


def said_of(score: Score, exercise: ExerciseResult) -> Iterator[Said]:
    """Return the result of an exercise in parts; the page and other exports show the same."""
    colour, short, meaning = _STATES[exercise.state]
    if exercise.with_reference and exercise.earned > 0:
        colour, short, meaning = "good", "Right, with our earlier functions", ""
    yield Said("state", short, colour=colour)
    if meaning and not (exercise.text and exercise.state in _TOLD_BY_TEXT):
        yield Said("text", meaning)
    if exercise.text:
        yield Said("text", exercise.text)
    if 0 < exercise.passed < exercise.cases:
        yield Said("text", f"It is right in {exercise.passed} of {exercise.cases} hidden cases.")
    if exercise.line:
        yield Said("code", exercise.line, "Your own line where it happened:")
    lines = [line for line in exercise.public if line != exercise.hint]
    if lines and exercise.state != "not attempted":  # there it says the same
        yield Said("code", "\n".join(lines), "The public check, check(…) in your notebook, says:")
    if exercise.hint:
        yield Said("box", exercise.hint, "Hint", "calm")
    yield from _remarks(exercise)
    if comment := score.comments.get(exercise.name):
        yield Said("box", comment, "A person's comment", "calm")
    if request := score.requests.get(exercise.name):
        answer = f"Answer: {request.answer}" if request.answer else "A person has still to answer."
        same = not request.answer or score.result.has_answer(exercise.name, request.decided_on)
        of = "" if same else " (for an earlier version of your answer)"
        yield Said("box", f"{request.text}\n{answer}", f"You asked to have this checked{of}", "calm")
    if override := score.overrides.get(exercise.name):
        given = f"The grader gave {number(exercise.earned)}, a person {_points(override.points)}."
        yield Said("box", f"{given}\n{override.reason}", "A person looked at this", "calm")
    elif earlier := score.earlier_overrides.get(exercise.name):
        given = (
            f"{_points(earlier.points)} from a person were for an earlier answer, to which the grader gave "
            f"{number(earlier.earned)}. Now the {_points(exercise.earned)} of the grader count. If you think that the "
            "person's reason still holds, ask to have it checked."
        )
        yield Said("box", f"{given}\n{earlier.reason}", "A person looked at an earlier answer", "calm")


def _remarks(exercise: ExerciseResult) -> Iterator[Said]:
    """Return notes, also that an earlier mistake was not counted twice."""
    notes = "\n".join(exercise.notes)
    if exercise.with_reference and exercise.earned > 0:
        text = f"It does not work with your own earlier functions; with ours it does: {_points(exercise.earned)}."
        whole = exercise.earned >= exercise.points
        title = (
            "An earlier mistake is not counted twice" if whole else "An earlier mistake costs a part of it"
        )
        yield Said("box", f"{text}\n{notes}", title, "good")
        return
    if exercise.with_reference:
        yield Said(
            "text", "We ran it with our own earlier functions, too: it does not work with those either."
        )
    if notes:
        yield Said("box", notes, "One thing", "calm")


def _written(score: Score) -> Iterator[Markup]:
    """Return written answers with their marks, without the rubrics."""
    if score.result.written:
        yield element("h2", "Your answers in words")
    for answer in score.result.written:
        yield element("article", *_answer(score, answer), class_="card")


def _answer(score: Score, answer: WrittenAnswer) -> Iterator[Markup]:
    given = score.of_answer(answer)
    points = f"{number(given)} of {_points(answer.points)}" if given is not None else _points(answer.points)
    title = element("h3", answer.number, " " if answer.number else "", "In your own words")
    yield element("div", title, element("span", points, class_="points"), class_="top")
    yield element("p", markdown(_cut(answer.question)))
    if answer.text.strip():
        yield element("p", "You wrote:", class_="label")
        yield element("div", _cut(answer.text.strip()), class_="said", dir="auto")
    else:
        yield element("p", "Your notebook has no text of yours at this question.", class_="soft")
    if answer.note:
        yield element("p", answer.note, class_="soft")
    mark = score.marks.get(answer.name)
    if mark is None and given is None and (earlier := score.earlier_marks.get(answer.name)):
        said = f"{_points(earlier.points)} for an earlier answer. A person marks your new answer."
        yield element("p", said, class_="state calm soft")
        if earlier.comment.strip():
            yield _box("calm", "What the person who marked your earlier answer said", earlier.comment)
    elif mark is None and given is None:
        yield element("p", "A person marks this.", class_="state calm")
    elif mark is not None and mark.comment.strip():
        yield _box("calm", "What the person who marked it says", mark.comment)


# --- a submission that could not be graded ---

_ADVICE = {  # words of a reason, and what helps
    (
        "larger",
        "too large",
        "too big",
    ): "Clear all outputs (Edit, Clear Outputs of All Cells) and save: pictures in them make a file large.",
    (
        "empty",
    ): "The file has nothing in it. Look at it on your own computer: an upload may have been cut off.",
    ("zip", "archive"): "Make the zip with `nao-course submit`, and hand in that file as it is.",
    (
        "link",
        "folder",
        "directory",
        "not a file",
    ): "Hand in the notebook itself, no folder and no link to it.",
    ("release", "version", "stamp"): "Work in the notebook that you were given, in its newest version: "
    "`nao-course renew` brings it and keeps what you wrote.",
}
_STEPS = (
    "Open the notebook in JupyterLab. If it does not open there, look for an earlier copy: your last zip, or File, "
    "Revert Notebook to Checkpoint.",
    "Restart the kernel, run all cells and save.",
    "Make the file to hand in with `nao-course submit`.",
    "Hand it in again, and tell your assistant that you did.",
)


def _refused(result: SubmissionResult) -> Iterator[Markup]:
    """Say why, and what to do now."""
    reason = result.reason.lower()
    advice = [text for words, text in _ADVICE.items() if any(word in reason for word in words)]
    yield element("h2", "It could not be graded")
    yield _box("bad", "Why", result.reason or "The reason was not recorded: please ask.")
    yield element("h2", "What to do now")
    yield element("ol", *(element("li", prose(step)) for step in (*advice, *_STEPS)))


def _unread_request(score: Score) -> Iterator[Markup]:
    """Quote what could not be read of the student's file of requests, and how to write it."""
    if unread := score.requests.get(""):
        yield _box("warn", "A request that could not be read", f"{unread.text}\n{unread.answer}")


def _left_out(result: SubmissionResult) -> Iterator[Markup]:
    """Name the student's files that did not count or have another name, each with the reason."""
    if result.left_out:
        yield _box("warn", "Notes on your files", "\n".join(result.left_out))


def _footer(result: SubmissionResult) -> Markup:
    parts = [f"Graded from {result.file}"] if result.file else []
    if result.submission:
        parts.append(f"its fingerprint begins with {result.submission[:16]}")
    said = f"{', '.join(parts)}. " if parts else ""
    if result.graded_with and result.status == "graded":
        written = in_words(result.versions)
        said += f"{f'Written with {written}; graded' if written else 'Graded'} with {in_words(result.graded_with)}. "
    hidden = "Hidden cases have other inputs than the public check. " if result.status == "graded" else ""
    return element(
        "footer",
        f"{said}{hidden}You think that something here is wrong? Write a file {REQUEST} beside your notebooks, with the "
        "name of the exercise, a colon and your reason, and hand it in as you hand in a notebook. A person answers it "
        "on this page.",
    )


# --- small parts ---


def _title(exercise: ExerciseResult) -> tuple[Markup, ...]:
    return (join(exercise.number, " " if exercise.number else ""), element("code", exercise.name))


def _box(colour: str, title: str, text: str) -> Markup:
    lines = [element("p", prose(line)) for line in _cut(text).split("\n") if line.strip()]
    return card(element("p", element("strong", title)), *lines, class_=f"box {colour}")


def _points(value: float) -> str:
    return f"{number(value)} point" if value == 1 else f"{number(value)} points"


def _cut(text: str) -> str:
    """Return the text, or its beginning and how much is left out."""
    if len(text) <= LONGEST:
        return text
    return f"{text[:LONGEST]}\n… ({len(text) - LONGEST} more characters are not shown here)"
