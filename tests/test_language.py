"""The language of the course: the field's words, plain sentences, and docstrings that begin with a verb."""

import pytest

from tests import language
from tests.language import in_markdown, in_prose, in_python


def said(offences):
    return [each.text for each in offences]


def test_no_file_breaks_a_rule():
    found = {file: len(each) for file in language.files() if (each := language.offences(file))}
    assert found == {}, f"list them with `python -m tests.language {' '.join(found)}`"


@pytest.mark.parametrize(
    ("sentence", "offence"),
    [
        ("The slopes of h are in H.", "slopes"),
        ("It tells how surely it stands there.", "how surely"),
        ("Each look shrinks the ellipse.", "Each look"),
        ("The body leans forwards.", "leans"),
        ("The reference is lent to you.", "lent"),
        ("Take the\none that is nearer.", "one that"),
        ("is none, and goes before the doubles do", "is none"),
        ("Most of what is white and no line stands behind the field.", "what is white and no"),
        ("A wall has not, and is.", "has not, and is"),
        ("all corners but for the last", "but for"),
    ],
)
def test_a_riddle_is_found(sentence, offence):
    assert offence in said(in_prose(1, sentence))


@pytest.mark.parametrize(
    "sentence",
    [
        "The slope of the line is its direction.",
        "Does this surprise you? It surprised us.",
        "Take a look at the figure. Each looks the same.",
        "Colour tells the two goals apart, and the message tells you why.",
        "There is no such function, and it is no longer used.",
        "Pass `lent` or `slopes` to it, see [there](slopes.md), $what is left$.",
    ],
)
def test_plain_english_is_allowed(sentence):
    assert said(in_prose(1, sentence)) == []


def test_every_allowance_has_a_reason_and_the_offences_of_a_file_are_listed(tmp_path, capsys):
    reasons = [reason for each in language.PROSE for reason in each.allowed.values()]
    assert all(reason.strip() for reason in (*reasons, *language.ALLOWED_NAMES.values()))
    assert all(each.say for each in language.PROSE)
    path = tmp_path / "notes.md"
    path.write_text("Fine.\n\nAn honest\ndoubt.\n")
    assert language.main([str(path)]) == 1
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(" -> ")[0] for line in lines] == [f"{path}:3: honest", f"{path}:4: doubt"]


def test_comments_texts_names_and_docstrings_are_read_where_they_stand():
    source = '''"""A module, a noun phrase."""

SLOPES = {"slopes": 1}  # the doubt


class Lean:
    """A body's tilt."""

    @property
    def size(self) -> float:
        """The size in metres."""

    def far(self, told: bool) -> bool:
        """Whether it is far."""
        raise ValueError(f"the {told} look is "
                         "wrong")
'''
    assert [(each.line, each.text) for each in in_python(source)] == [
        (3, "doubt"),
        (3, "the name SLOPES"),
        (6, "the name Lean"),
        (13, "the name told"),
        (14, "docstring 'Whether it is far.'"),
    ]
    cell = "# Slopes\n\n```{code-cell}\n:role: setup\n\nsurprise = 1  # a doubt\n```\n\n```text\nslopes\n```\nslopes\n"
    found = [(each.line, each.text) for each in in_markdown(cell)]
    assert found == [(1, "Slopes"), (6, "doubt"), (6, "the name surprise"), (12, "slopes")]


def test_a_function_says_what_it_does():
    right = "Return the sum.", "Draw, and show, it."
    for docstring in (*right, "Whether it is so.", "Hash of a file.", "The sum."):
        assert language.begins_with_a_verb(docstring) == (docstring in right)
