"""What the tests of pages share: a page as its elements and words, results of any kind, hostile content."""

from html.parser import HTMLParser
from typing import get_args

from hypothesis import strategies as st

from nao_course.instructor.gradebook.records import (
    ExerciseResult,
    Mark,
    State,
    SubmissionResult,
    WrittenAnswer,
    fingerprint,
)

RUBRIC, MISTAKE, FOR_ASSISTANTS = "Rubric-7f3a", "Mistake-7f3a", "Assistant-7f3a"
HOSTILE = (
    "<script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "'/><svg onload=alert(1)>",
    "</pre></code></main></body></html><script>alert(1)</script>",
    "<!--",
    "-->",
    "]]>",
    "</style><style>*{display:none}",
    "</title><base href=//evil.example>",
    "&lt;script&gt;",
    "javascript:alert(1)",
    '<meta http-equiv="refresh" content="0;url=//evil.example">',
    "\x00\x08\x1b[31m\x7f",
    "a\u202egnp.exe\u2066",
    "half \ud83d of a character",
    "x\u0300" + "\u0301" * 60,
    "=cmd|' /C calc'!A0",
    "\ufeff\u200b",
)
OURS = {
    *("html", "head", "meta", "title", "style", "body", "main", "header", "footer", "article", "section"),
    *("div", "p", "h1", "h2", "h3", "ul", "ol", "li", "dl", "dt", "dd", "span", "bdi", "code", "pre"),
    *("mark", "strong", "svg", "rect", "table", "caption", "thead", "tbody", "tr", "th", "td", "figure"),
    *("figcaption", "img", "nav", "a"),
}
ATTRIBUTES = {
    *("lang", "charset", "http-equiv", "content", "name", "class", "dir", "x", "width", "height"),
    *("viewbox", "preserveaspectratio", "aria-hidden", "scope", "src", "alt", "id", "href", "tabindex"),
    *("role", "aria-label"),
}


class Page(HTMLParser):
    """A page that was read: its elements in order, and its words."""

    def __init__(self, text):
        super().__init__()
        self.elements, self.words, self.comments = [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.elements.append((tag, dict(attrs)))

    def handle_data(self, data):
        if self.elements and self.tags[-1] != "style":
            self.words.append(data)

    def handle_comment(self, data):
        self.comments.append(data)

    @property
    def tags(self):
        return [tag for tag, _ in self.elements]

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())

    def offences(self):
        """What no page of ours may hold."""
        found = [tag for tag in self.tags if tag not in OURS] + self.comments
        for tag, attributes in self.elements:
            found += [f"{tag} {name}" for name in attributes if name not in ATTRIBUTES]
            address = attributes.get("src") or attributes.get("href") or "#"
            if not address.startswith(("data:image/", "#")):
                found.append(f"{tag} {address}")
        return found


def words():
    return st.one_of(st.sampled_from(HOSTILE), st.text(max_size=30))


def exercises():
    return st.builds(
        ExerciseResult,
        name=words(),
        number=st.sampled_from(["", "1.1", "1.10"]),
        points=st.integers(0, 40).map(lambda quarters: quarters / 4),
        earned=st.integers(0, 40).map(lambda quarters: quarters / 4),
        state=st.sampled_from(get_args(State)),
        passed=st.integers(0, 5),
        cases=st.integers(0, 5),
        text=words(),
        line=words(),
        public=st.lists(words(), max_size=2).map(tuple),
        hint=words(),
        mistake=words().map(MISTAKE.__add__),
        with_reference=st.booleans(),
        notes=st.lists(words(), max_size=2).map(tuple),
    )


def answers():
    return st.builds(
        WrittenAnswer,
        name=words(),
        number=st.just("1.W1"),
        points=st.integers(0, 40).map(lambda quarters: quarters / 4),
        question=words(),
        rubric=words().map(RUBRIC.__add__),
        text=words(),
    )


def results():
    return st.builds(
        SubmissionResult,
        student=words().filter(bool),
        lesson=st.sampled_from(["01_hsl_filtering", "02_goal_posts"]),
        status=st.sampled_from(["graded", "refused"]),
        reason=words(),
        file=words(),
        submission=words(),
        assignment=words(),
        exercises=st.lists(exercises(), max_size=3).map(tuple),
        written=st.lists(answers(), max_size=2).map(tuple),
        notes=st.lists(words().map(FOR_ASSISTANTS.__add__), max_size=2).map(tuple),
        level=words(),
    )


def exercise(state="right", **changed):
    """One exercise as it comes out of the grader."""
    right = state == "right"
    values = {"name": "rgb_to_hsl", "number": "1.1", "points": 2.0, "earned": 2.0 if right else 0.0}
    return ExerciseResult(**{**values, "state": state, "passed": 5 if right else 0, "cases": 5, **changed})


def answer(**changed):
    values = {"name": "why_hsl", "number": "1.W1", "points": 2.0, "question": "Why HSL?", "rubric": RUBRIC}
    return WrittenAnswer(**{**values, "text": "Because of the shadows.", **changed})


def mark(points=1.5, comment="", *, text="Because of the shadows.", **changed):
    """A mark of `answer(text=text)`."""
    values = {"student": "ada", "lesson": "01_hsl_filtering", "question": "why_hsl", "time": "2026-01-01"}
    return Mark(
        **{**values, "points": points, "comment": comment, "decided_on": fingerprint(text), **changed}
    )


def result(student="ada", *parts, **changed):
    """A submission with exercises and written answers."""
    values = {"lesson": "01_hsl_filtering", "status": "graded", "file": "01_hsl_filtering.ipynb"}
    values["exercises"] = tuple(each for each in parts if isinstance(each, ExerciseResult))
    values["written"] = tuple(each for each in parts if isinstance(each, WrittenAnswer))
    return SubmissionResult(**{"student": student, **values, **changed})
