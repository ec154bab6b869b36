"""A student's work is found in a notebook that was copied, merged, split, retyped or stripped of its metadata."""

import json
from copy import deepcopy
from functools import cache
from itertools import chain, zip_longest

import pytest

from nao_course.exercises.cells import is_solution, source_of
from nao_course.exercises.definitions import load_definitions
from nao_course.exercises.notebook_text import read_notebook, without_outputs
from nao_course.exercises.outline import outline_bytes, read_outline
from tests.lessons.every import COURSE

QUICK = ("01_hsl_filtering", "11_slam_on_the_field")  # functions, and classes
TEXTS = {"markdown": "Markdown", "raw": "Raw"}


@cache
def cells_of(folder, lesson):
    return json.loads((COURSE.root / folder / f"{lesson}.ipynb").read_text(encoding="utf-8"))["cells"]


def code(source, **metadata):
    return {"cell_type": "code", "id": "own", "metadata": metadata, "source": source}


def text(source):
    return {"cell_type": "markdown", "id": "own", "metadata": {}, "source": source}


def without(*keys):
    """Leave out keys of every cell; its metadata are only emptied."""

    def changed(own, blank, rng):
        kept = [{key: value for key, value in cell.items() if key not in keys or key != "id"} for cell in own]
        return [cell | ({"metadata": {}} if "metadata" in keys else {}) for cell in kept]

    return changed


def one_without_metadata(own, blank, rng):
    chosen = int(rng.integers(len(own)))
    return [{**cell, "metadata": {}} if at == chosen else cell for at, cell in enumerate(own)]


def split(own, blank, rng):
    """Put each top-level statement of an exercise into a cell of its own; the last one keeps the metadata."""
    parts = []
    for cell in own:
        pieces = source_of(cell).split("\n\n\n") if is_solution(cell) else [source_of(cell)]
        parts += [*map(code, pieces[:-1]), {**cell, "source": pieces[-1]}]
    return parts


def merged(own, blank, rng):
    """Put each exercise and its check into one cell."""
    parts = []
    for cell in own:
        if source_of(cell).startswith("check(") and parts and "def " in source_of(parts[-1]):
            parts[-1] = {**parts[-1], "source": f"{source_of(parts[-1])}\n{source_of(cell)}"}
        else:
            parts.append(cell)
    return parts


def as_a_script(own, blank, rng):
    """Put all of it into one cell, as VS Code exports it."""
    parts = []
    for cell in own:
        text = source_of(cell)
        if cell["cell_type"] == "code":
            parts.append(f"# %%\n{text}\n")
        else:
            parts.append("# %% [markdown]\n" + "".join(f"# {line}\n" for line in text.splitlines()))
    return [code("\n".join(parts))]


def names_used_again(own, blank, rng):
    names = sorted({cell["metadata"].get("nbgrader", {}).get("grade_id", "") for cell in own} - {""})
    uses = ("{} = 3", "for {} in range(2): pass", "import math as {}", "del {}")
    return own + [code(rng.choice(uses).format(name)) for name in names]


MESS = {
    "a blank copy after it": lambda own, blank, rng: own + blank,
    "a blank copy before it": lambda own, blank, rng: blank + own,
    "a blank copy between": lambda own, blank, rng: [*chain(*zip_longest(own, blank[: len(own)]))],
    "itself twice": lambda own, blank, rng: own + own,
    "no metadata": without("metadata"),
    "no ids": without("id"),
    "no metadata and no ids": without("metadata", "id"),
    "one cell without metadata": one_without_metadata,
    "split cells": split,
    "merged cells": merged,
    "one cell with a script": as_a_script,
    "names used again": names_used_again,
    "a blank copy and no metadata": lambda own, blank, rng: without("metadata")(own + blank, blank, rng),
}


@pytest.fixture
def read(tmp_path):
    def read(lesson, cells):
        path = tmp_path / f"{lesson}.ipynb"
        path.write_text(json.dumps({"nbformat": 4, "metadata": {}, "cells": cells}), encoding="utf-8")
        short = tmp_path / f"{lesson} (short).ipynb"
        short.write_bytes(without_outputs(path.name, path.read_bytes()))
        outline = read_outline(lesson)
        assert read_notebook(short, outline) == read_notebook(path, outline)
        return load_definitions(path, released=outline)

    return read


def fingerprint(thing):
    """Return what a function or the methods of a class do, without their places in the notebook."""
    parts = (thing, *getattr(thing, "__dict__", {}).values())
    codes = [(each.__qualname__, each.__code__) for each in parts if hasattr(each, "__code__")]
    return [(name, code.co_code, code.co_names) for name, code in codes]


@pytest.mark.parametrize("mess", MESS)
@pytest.mark.parametrize(
    "lesson", [pytest.param(name, marks=() if name in QUICK else pytest.mark.slow) for name in COURSE.names()]
)
def test_the_same_answers_are_found_in_a_mess(lesson, mess, read, rng):
    own, blank = (deepcopy(cells_of(folder, lesson)) for folder in ("solutions", "notebooks"))
    plain, odd = read(lesson, own), read(lesson, MESS[mess](own, blank, rng))
    names = read_outline(lesson).exercises
    assert all(fingerprint(odd[name]) == fingerprint(plain[name]) for name in names)
    assert odd.text.written == plain.text.written
    assert {each.reason for each in odd.skipped} <= {"not a definition"}


@pytest.mark.parametrize("lesson", COURSE.names())
def test_the_outline_is_that_of_the_released_notebook(lesson):
    file = COURSE.root / "nao_course" / "exercises" / "outlines" / f"{lesson}.json"
    assert file.read_bytes() == outline_bytes(cells_of("notebooks", lesson))


LESSON, EXERCISE, QUESTION = "01_hsl_filtering", "hue_mask", "explain_stray_pixel"


def changed(name, **changes):
    """Return the cells of lesson 01's solution, with a change of one cell; None deletes it."""
    cells = deepcopy(cells_of("solutions", LESSON))
    (at,) = (at for at, cell in enumerate(cells) if cell.get("id") == f"lesson01-{name}")
    cells[at : at + 1] = [cells[at] | changes] if changes else []
    return cells, at


@pytest.mark.parametrize("metadata", [{}, None])
@pytest.mark.parametrize("kind", ["markdown", "raw"])
def test_a_definition_in_a_text_cell_is_named(kind, metadata, read):
    cells, _ = changed(EXERCISE, cell_type=kind, **({} if metadata is None else {"metadata": metadata}))
    found = read(LESSON, cells)
    assert EXERCISE not in found
    assert f"{TEXTS[kind]} cell" in found.remarks[EXERCISE][0]


def own_text():
    cells, at = changed(EXERCISE, role="")
    return source_of(cells[at])


@pytest.mark.parametrize("magic", ["%%writefile f.py", "%%debug", "%%python3", "%%html", "%%script bash"])
def test_a_definition_under_another_magic_is_named(magic, read):
    own = own_text()
    found = read(LESSON, changed(EXERCISE, source=f"{magic}\n{own}")[0])
    assert EXERCISE not in found
    assert magic.split()[0] in found.remarks[EXERCISE][0]


ANSWER = "It is one pixel."
BLANK = "*Write your answer here: double-click this text.*"
OWN = {
    "in a string": code(f'"""{ANSWER}"""'),
    "in a print": code(f'print("{ANSWER}")'),
    "in a variable": code(f'answer = "{ANSWER}"'),
    "in a cell": text(ANSWER),
}


def answered(how):
    match how:
        case "in a raw cell" | "in a code cell":
            return changed(QUESTION, cell_type=how.split()[2], source=ANSWER)[0]
        case "in a code cell without metadata":
            return changed(QUESTION, cell_type="code", source=ANSWER, metadata={})[0]
        case "with the blank sentence":
            return changed(QUESTION, source=f"{ANSWER}\n\n{BLANK}")[0]
        case "in place of a deleted cell":
            cells, at = changed(QUESTION)
            return [*cells[:at], text(ANSWER), *cells[at:]]
        case "below the question":
            cells, at = changed(QUESTION, source=BLANK)
            cells[at - 1] = cells[at - 1] | {"source": source_of(cells[at - 1]) + f"\n\n{ANSWER}"}
            return cells
    cells, at = changed(QUESTION, source=BLANK)
    own, place = how.rsplit(" ", 1)
    at += place == "below"
    return [*cells[:at], OWN[own], *cells[at:]]


@pytest.mark.parametrize(
    "how",
    [
        *("in a raw cell", "in a code cell", "in a code cell without metadata", "with the blank sentence"),
        *("in place of a deleted cell", "below the question", "in a cell above"),
        *(f"{own} below" for own in OWN),
    ],
)
def test_a_written_answer_is_found(how, read):
    given = read(LESSON, answered(how)).text.written[QUESTION]
    assert ANSWER in given and "double-click" not in given


def test_text_elsewhere_is_no_answer_and_a_doubled_text_counts_or_is_named(read):
    for notes in [text("My notes."), code("# My notes."), code("print('My notes.')")]:
        cells, _ = changed(QUESTION, source=BLANK)
        found = read(LESSON, [notes, *cells])
        assert not found.text.written[QUESTION]
        assert "none at this question" in found.remarks[QUESTION][0]
        assert not read(LESSON, cells).remarks
    for between in ["", " ", "\n"]:
        own = own_text()
        found = read(LESSON, changed(EXERCISE, source=own + between + own)[0])
        assert EXERCISE in found or "contains its text twice" in found.skipped[-1].reason


DEPENDS = {
    "while": "limits = []\nwhile len(limits) < 3:\n    limits.append(len(limits))",
    "sort": "limits = [2, 0, 1]\nlimits.sort()",
    "del": "limits = [0, 1, 2, 3]\ndel limits[3]",
    "own function": "limits = []\ndef fill(it):\n    it.extend(range(3))\nfill(limits)",
    "own function with a global": "limits = []\n"
    "def fill():\n    for i in range(3): limits.append(i)\ndef both(): fill()\nboth()",
    "own method": "limits = []\nclass Maker:\n    def make(self): limits.extend(range(3))\nMaker().make()",
    "library": "import heapq\nlimits = [0, 1]\nheapq.heappush(limits, 2)",
    "nested in a print": "limits = [0, 1, 2, 3]\nprint(limits.pop())",
    "main": "if __name__ == '__main__':\n    limits = [0, 1, 2]",
    "by way of another name": "first = [3, 2]\nfirst.reverse()\nlimits = [0, 1, first[0]]",
    "globals": "globals().update(limits=[0, 1, 2])",
    "assert": "limits = [0, 1, 2, 3]\nassert limits.pop() == 3",
}


@pytest.mark.parametrize("cell", DEPENDS.values(), ids=DEPENDS)
def test_whatever_an_exercise_depends_on_runs(cell, read):
    cells, at = changed(EXERCISE, source=f"def {EXERCISE}(hue):\n    return limits")
    shown = code("print(hue_mask(1))\nhue = []\nhue.sort(key=1 / 0)")
    found = read(LESSON, [*cells[:at], code(cell), *cells[at:], shown])
    assert found[EXERCISE](0) == [0, 1, 2]


def test_a_value_counts_as_it_is_at_the_check(read):
    for before, after, value in [
        *(("limit = 1", "limit = 2", 1), ("limit = 1", "del limit", 1), ("limit = None", "del limit", None)),
        *(("def limit(): return 1\nlimit = limit()", "", 1), ("", "limit = 2", 2)),
        ("limit = 1", "limit = []\nlimit.append(1)", 1),
    ]:
        cells, at = changed(EXERCISE, source=f"def {EXERCISE}(hue):\n    return limit")
        found = read(LESSON, [*cells[:at], code(before), *cells[at : at + 2], code(after), *cells[at + 2 :]])
        assert found[EXERCISE](0) == value
        assert bool(found.remarks.get(EXERCISE)) == bool(after)


def test_a_later_function_counts_and_a_check_above_what_its_exercise_uses_is_named(read):
    own, _ = changed("white_threshold", source="def white_threshold(x):\n    return 1")
    found = read(LESSON, [*own, code("faster = lambda x: 2\nwhite_threshold = faster")])
    assert found["white_threshold"](0) == 2
    found = read(LESSON, [*own, code("def white_threshold(x):\n    return 3")])
    assert found["white_threshold"](0) == 3
    assert "The definition in code cell" in found.remarks["white_threshold"][0]
    for is_late in [True, False]:
        cells, at = changed(EXERCISE, source=f"def {EXERCISE}(hue):\n    return helper(hue)")
        where = at + 2 if is_late else at
        found = read(LESSON, [*cells[:where], code("def helper(x):\n    return x"), *cells[where:]])
        assert found[EXERCISE](3) == 3
        assert any("defines helper" in each for each in found.remarks.get(EXERCISE, ())) is is_late


@pytest.mark.parametrize("other", [False, True])
@pytest.mark.parametrize("helpers", ["def helper(x): return x", "def helper(x): return inner(x, y=0)"])
def test_an_exercise_is_graded_with_its_helpers_as_they_were_at_its_check(other, helpers, read):
    uses = "global CALLS\n    CALLS += 1\n    return helper(hue) + add, white_threshold"
    body = f"def {EXERCISE}(hue, *, add=0):\n    {uses}"
    cells, at = changed(EXERCISE, source=body)
    inner = "CALLS = 0\ndef inner(x, *, y=1):\n    return x + y"
    one = code(f"{inner}\n{helpers}")
    two = code("def helper(x):\n    return 0\n\ndef inner(x, *, y=1):\n    return 0")
    found = read(LESSON, [*cells[:at], one, *cells[at : at + 2], two if other else one, *cells[at + 2 :]])
    answer, used = found[EXERCISE](3, add=1)
    assert answer == 4 and used is found["white_threshold"] and found["helper"](3) == (0 if other else 3)
    found.namespace["white_threshold"] = "a stand-in"
    assert found[EXERCISE](3)[1] == "a stand-in"
    said = found.remarks.get(EXERCISE, ())
    assert any("helper as it was at the check" in each for each in said) is other
    # Without a check after it, the function is graded as the notebook ends.
    last = [code(body), two if other else one, *cells[at + 2 :]]
    found = read(LESSON, [*cells[:at], one, cells[at + 1], *last])
    assert found[EXERCISE](3)[0] == (0 if other else 3)


def test_a_name_that_a_deleted_cell_defined_is_named_and_what_a_changed_demonstration_defines_runs(read):
    for body, missing in [
        *(("math.pi", ["`import math`"]), ("plt.figure()", ["`import matplotlib.pyplot as plt`"])),
        *(("helper(hue)", ["name factor"]), ("[deque(x) for x in hue]", ["name deque"])),
        *(("abs(np.pi) + white_threshold(0)", []), ("globals()['later']", [])),
    ]:
        cells, at = changed(EXERCISE, source=f"def {EXERCISE}(hue):\n    later = 3\n    return {body}, later")
        found = read(LESSON, [*cells[:at], code("def helper(x):\n    return factor * x"), *cells[at:]])
        said = [each for each in found.remarks.get(EXERCISE, ()) if "no cell that the grader runs" in each]
        assert len(said) == len(missing) and all(
            name in each for each, name in zip(said, missing, strict=True)
        )
    for role in ["display", "check", "setup"]:
        cells, at = changed(EXERCISE, source=f"def {EXERCISE}(hue):\n    return mine")
        own = code("shown = 1 / 0\nmine = 5", nao_course={"role": role}, nbgrader={"grade": role == "check"})
        found = read(LESSON, [*cells[:at], own, *cells[at:]])
        assert found[EXERCISE](0) == 5


@pytest.mark.parametrize("later", ["len = None", "def len(x):\n    return 0", ""])
def test_a_builtin_that_a_later_cell_replaces_is_the_builtin_at_the_check(later, read):
    cells, at = changed(EXERCISE, source=f"def {EXERCISE}(hue):\n    return len(hue)")
    found = read(LESSON, [*cells[: at + 2], code(later), *cells[at + 2 :]])
    assert found[EXERCISE]([1, 2]) == 2
    assert bool(found.remarks.get(EXERCISE)) is bool(later)
    found = read(LESSON, [*cells, code(f"from numpy import sin as {EXERCISE}")])
    assert found[EXERCISE]([1, 2]) == 2, "a library's function does not replace an exercise"
