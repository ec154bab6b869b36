"""A notebook's definitions are found wherever they stand, and nothing else of it runs."""

import gzip
import json
import math
import sys
import traceback
from unittest.mock import MagicMock

import pytest

from nao_course.exercises import load_definitions
from nao_course.exercises.definitions import demonstrated
from nao_course.exercises.notebook_text import LARGEST_CODE, MOST_BYTES, read_notebook, without_outputs
from nao_course.exercises.outline import UNKNOWN, read_outline
from tests.lessons.every import COURSE
from tests.toy import toy


@pytest.fixture
def load(tmp_path):
    return lambda *cells: load_definitions(toy.write(tmp_path / "own.ipynb", *cells))


RUN = """
from math import pi
import math as m
SCALE = 2
SCALE += 1
first, *rest = 1, 2, 3
table = {}
table["a"] = 5
count: int = 4
if SCALE == 3:
    def by_if(): return SCALE
for k in range(3):
    last = k
try:
    import no_such_module
except ImportError:
    def by_try(): return last
try:
    raise ExceptionGroup("g", [ValueError()])
except* ValueError:
    def by_group(): return 1
(by_walrus := lambda: SCALE)
with open(m.__name__ + ".txt", "w") if False else memoryview(b""):
    def by_with(): return pi
async def later(): return 1
class Thing:
    size = count
def uses(): return SCALE + first + len(rest) + table["a"] + Thing.size
"""


def test_every_kind_of_definition_runs_and_nothing_else(load):
    found = load(RUN)
    assert found.skipped == ()
    assert list(found) == ["by_if", "by_try", "by_group", "by_walrus", "by_with", "later", "Thing", "uses"]
    assert found["uses"]() == 3 + 1 + 2 + 5 + 4
    assert (found["by_if"](), found["by_try"](), found["by_with"]()) == (3, 2, math.pi)
    found = load(
        "import sys",
        "sys.modules['ran'] = 1",  # an assignment does run
        "sys.modules.pop('ran')\nprint('x')\n1 / 0\nassert False\nraise SystemExit\nwhile True: pass",
        "'only a text'\n...",
    )
    assert sys.modules.pop("ran") == 1
    assert [(each.cell, each.line) for each in found.skipped] == [(3, line) for line in range(1, 7)]
    assert {each.reason for each in found.skipped} == {"not a definition"}


def test_of_demonstrations_and_the_set_up_only_imports_run_and_their_names_are_listed(load):
    found = load(
        ("setup", "import math\ncheck = 1 / 0\ndef given(): pass"),
        ("check", "def cheat(): pass"),
        ("display", "def shown(): pass"),
        ("solution", "def f(): return math.pi"),
        ("student", "def g(): return f()"),
    )
    assert set(found) == {"f", "g"}
    assert found["g"]() == math.pi
    assert found.skipped == ()
    cells = [
        ("setup", 'import numpy\nnao = 1\ndouble = earlier("01:double")\nfor i in range(3):\n    j = i'),
        ("display", "mean: float = 3\na, (b, *c) = 1, (2, 3)\ndef shown(x):\n    inside = 1"),
        ("payoff", "%matplotlib inline\nwith open('x') as file:\n    !ls\n    pass"),
        ("solution", "def mean(x):\n    return x"),
        ("student", "nao = 2"),
    ]
    assert demonstrated(cells) == ["a", "b", "c", "file", "i", "j", "shown"]


def test_the_last_definition_wins_and_lambdas_partials_classes_and_decorated_functions_count(load):
    found = load("def f(): return 1\ndef g(): return f()", ("solution", "def f(): return 2"), "f2 = f")
    assert found["f"]() == found["g"]() == found["f2"]() == 2
    assert list(load("def f(): return 1", "f = 3")) == []
    found = load(
        "import functools\n"
        "double = lambda x: 2 * x\n"
        "add_one = functools.partial(lambda a, b: a + b, 1)\n"
        "@functools.lru_cache\ndef cached(x): return x\n"
        "class Callable:\n    def __call__(self, x): return -x\n"
        "instance = Callable()\n"
        "number = 3\n"
    )
    assert list(found) == ["double", "add_one", "cached", "Callable", "instance"]
    assert [found[name](2) for name in ("double", "add_one", "cached", "instance")] == [4, 3, 2, -2]


def test_what_exec_defines_counts_and_what_is_imported_from_beside(load, tmp_path, monkeypatch):
    found = load("exec('def f(): return 1')\nexec('def g() return 2')\nexec('x = 5; h = lambda: x')")
    assert (list(found), found["f"](), found["h"]()) == (["f", "h"], 1, 5)
    assert [(each.line, each.reason[:11]) for each in found.skipped] == [(2, "SyntaxError")]
    (tmp_path / "my_own_helpers.py").write_text("def helper(): return 7\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    found = load("from math import sin as predict\nfrom my_own_helpers import helper")
    assert list(found) == ["helper"]
    assert found["helper"]() == 7
    found = load("if __name__ == '__main__':\n    T = 1\nif __name__ == '__main__': 1 / 0\ndef f(): return T")
    assert found["f"]() == 1
    assert [(each.line, each.reason) for each in found.skipped] == [(3, "not a definition")]


def test_a_magic_of_a_whole_cell_and_an_indented_or_copied_cell_are_read_as_ipython_reads_them(load):
    found = load("%%time\ndef f(x):\n    return (x\n            % 3)")
    assert found["f"](5) == 2 and found["f"].__code__.co_firstlineno == 2
    assert list(load("%%writefile f.py\ndef f():\n    return 1")) == []
    for source in [
        "    def f(x):\n        return x\n    y = 1",
        "\n\n  def f(x):\n    return x",
        ">>> def f(x):\n...     return x",
        "In [1]: def f(x):\n   ...:     return x",
        "\n \n%matplotlib inline\ndef f(x):\n    return x",
    ]:
        f = load(source)["f"]
        assert f(5) == 5
        assert "def f" in source.split("\n")[f.__code__.co_firstlineno - 1]


PIECES = (
    *("def f{n}(x):\n    return x % {n}\n", "if x:  # why?\n    y = 1\n# really?\nelse:\n    y = 2\n"),
    *("%timeit sum([1])\nt = %timeit -o 1\n", "files = !ls\n", "len?\n?len\n", "z = (3\n % 2)\n"),
    *("s = '''\n%x\nwhat?\n'''\n", "for i in range(2):\n    %time i\n    !ls\n"),
)


def test_whatever_stands_beside_a_magic_is_read_as_ipython_reads_it(load, rng):
    from IPython.core.inputtransformer2 import TransformerManager

    for _ in range(30):
        chosen = rng.integers(len(PIECES), size=6)
        pieces = (PIECES[piece].replace("{n}", str(n + 1)) for n, piece in enumerate(chosen))
        source = "x = 1\n!ls\n" + "".join(pieces)
        namespace = {"get_ipython": MagicMock()}
        exec(TransformerManager().transform_cell(source), namespace)
        found = load(source)
        assert list(found) == [name for name in namespace if name[0] == "f" and name != "files"]
        assert [found.namespace.get(name) for name in "xyzs"] == [namespace.get(name) for name in "xyzs"]


def test_a_cell_or_statement_that_fails_costs_itself_alone(load):
    for source, reason in [
        ("def broken(:", "SyntaxError"),
        ("x = '\0'", "null"),
        ("x = " + "-" * 100_000 + "1", "Error"),
        ("x = '\ud800'", "UnicodeEncodeError"),
    ]:
        found = load("def f(): return 1", source, "def g(): return 2")
        assert list(found) == ["f", "g"]
        assert found.skipped[0].cell == 2 and reason in found.skipped[0].reason
    for statement, reason in [
        ("x = 1 / 0", "ZeroDivisionError: division by zero"),
        ("import sys\nx = sys.exit(3)", "SystemExit: 3"),
        ("def recurse(): return recurse()\nx = recurse()", "RecursionError"),
        ("for k in range(3):\n    raise GeneratorExit", "GeneratorExit"),
        ("class Odd(Exception):\n    def __str__(self): raise self\nif True: raise Odd()", "Odd"),
        ("if True: raise KeyError('half \\ud800')", "KeyError"),
    ]:
        found = load(f"def f(): return 1\n{statement}\ndef g(): return 2")
        assert {"f", "g"} <= set(found)
        assert reason in found.skipped[0].reason
        found.skipped[0].reason.encode()


def test_annotations_of_the_future_hold_for_the_cells_that_follow(load):
    late = "def f(x: NotThereYet): return x"
    assert list(load("from __future__ import annotations", late)) == ["f"]
    assert "NameError" in load(late).skipped[0].reason
    found = load(
        "from __future__ import annotations\nfrom dataclasses import dataclass, field\nfrom typing import NamedTuple",
        "@dataclass\nclass Box:\n    size: int\n    rest: list = field(default_factory=list)",
        "class Pair(NamedTuple):\n    x: float",
    )
    assert found.skipped == ()
    assert found["Box"](3).size == 3


def test_what_python_3_14_makes_of_an_annotated_constant_is_no_function_of_the_notebook(load):
    found = load(
        "size: int = 3\ndef __annotate__(form): return {}", "def area(side: float): return size * side"
    )
    assert set(found) == {"area"} and found["area"](2.0) == 6


def test_a_traceback_shows_the_students_line_and_an_interrupt_goes_through(load, tmp_path, recwarn):
    with pytest.raises(ZeroDivisionError) as caught:
        load("def f():\n    return 1 / 0  # here")["f"]()
    last = traceback.extract_tb(caught.value.__traceback__)[-1]
    assert (last.lineno, last.line) == (2, "return 1 / 0  # here")
    path = toy.write(tmp_path / "own.ipynb", "def f(): return 1\nx = 1 / 0", "def g(): return 2")
    seen = []
    found = load_definitions(path, lambda cell, line: seen.append((cell, line)) or line == 1)
    assert seen == [(1, 1), (1, 2), (2, 1)]
    assert found.skipped[0].reason == "left out"
    with pytest.raises(KeyboardInterrupt):
        load("if True: raise KeyboardInterrupt")
    assert list(load("def f(): return '\\d'\nx = 1 is 1")) == ["f"]
    assert not recwarn.list


def written(path, data):
    path.write_bytes(data)
    return path


def test_a_refused_notebook_has_a_reason_without_pythons_words(tmp_path):
    for data, reason in [
        (b'{"cells": [', "it is incomplete: it breaks off in line 1"),
        (b'{"cells":\n ["import num', "it is incomplete: it breaks off in line 2"),
        (b" ", "it is empty"),
        (b'{"cells": [{"cell_type": "code", "source": 1}]}', "none of its cells has a type and a source"),
        (b"{}", "it has no list of cells"),
        (b"[]", "it contains other data than a notebook"),
        (b'{"cells": [], "nbformat": 3}', "its format is 3"),
        (b"PK", "line 1 is not JSON"),
        (b'{"cells": ' + b"[" * 200_000, r"format 4 \(it is nested too deeply\)$"),
        (b"caf\x81", "it is not text .* Save it as UTF-8"),
        (gzip.compress(b'{"cells": []}', mtime=0), "it is compressed with gzip"),
    ]:
        with pytest.raises(ValueError, match=reason) as said:
            load_definitions(written(tmp_path / "bad.ipynb", data))
        assert "Error" not in str(said.value)
        with pytest.raises(ValueError, match=reason) as short:
            without_outputs("bad.ipynb", data)
        assert str(short.value) == str(said.value)


def test_a_broken_cell_costs_no_other(tmp_path):
    for cell in [
        5,
        {"cell_type": "code"},
        {"cell_type": ["code"], "source": "def g(): return 1"},
        {"cell_type": "code", "source": "", "metadata": [5]},
        {"cell_type": "code", "source": "", "metadata": {"nbgrader": 5, "nao_course": []}},
        {"cell_type": "markdown", "metadata": {"nbgrader": {"solution": 1, "grade_id": "\ud800"}}},
        {"cell_type": "code", "source": "x = '\ud800'"},
    ]:
        whole = {"cell_type": "code", "metadata": None, "source": "def f(): return 1"}
        text = {"cells": [cell, whole], "metadata": {"nao_course": {"lesson": "\udfff", "version": 5}}}
        found = load_definitions(written(tmp_path / "own.ipynb", json.dumps(text).encode()))
        assert list(found) == ["f"]
        reasons = [each.reason for each in found.skipped]
        for said in (found.text.lesson, found.text.version, *found.text.written, *reasons):
            said.encode()


def test_a_notebook_in_another_language_is_refused_and_python_under_another_kernel_is_not(tmp_path):
    def read(source):
        cell = {"cell_type": "code", "metadata": {}, "source": source}
        text = {"cells": [cell], "metadata": {"kernelspec": {"language": "R"}}}
        return load_definitions(written(tmp_path / "own.ipynb", json.dumps(text).encode()))

    with pytest.raises(ValueError, match="in Python, got R"):
        read("f <- function(x) x")
    assert list(read("def f(): return 1")) == ["f"]


def test_a_folder_a_missing_file_and_a_huge_one_are_refused(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match="not a file"):
        load_definitions(tmp_path)
    with pytest.raises(FileNotFoundError):
        load_definitions(tmp_path / "missing.ipynb")
    with (tmp_path / "huge.ipynb").open("wb") as file:
        file.truncate(MOST_BYTES + 1)
    with pytest.raises(ValueError, match="at most 50 MB"):
        load_definitions(tmp_path / "huge.ipynb")
    notebook = toy.write(tmp_path / "own.ipynb", f"data = '{'x' * LARGEST_CODE}'")
    with pytest.raises(ValueError, match="^own.ipynb: its code and texts may have at most 12 MB$"):
        without_outputs(notebook.name, notebook.read_bytes())

    def greedy(*_, **__):
        raise MemoryError

    monkeypatch.setattr("nao_course.exercises.notebook_text.json.loads", greedy)
    with pytest.raises(ValueError, match="it is too large to be read; clear all outputs"):
        load_definitions(written(tmp_path / "large.ipynb", b"{}"))


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_a_notebook_in_another_encoding_and_with_lists_of_lines_is_read(tmp_path, encoding):
    cell = {"cell_type": "code", "metadata": {}, "source": ["def f():\n", "    return 'ü'"]}
    text = {"cells": [{"cell_type": "markdown", "source": "# Title"}, cell]}
    path = written(tmp_path / "own.ipynb", json.dumps(text, ensure_ascii=False).encode(encoding))
    assert load_definitions(path)["f"]() == "ü"


@pytest.mark.parametrize("name", COURSE.names())
def test_a_notebook_without_its_outputs_has_the_same_contents_and_a_fifth_of_the_size(name, tmp_path):
    whole = COURSE.solutions / f"{name}.ipynb"
    short = tmp_path / whole.name
    short.write_bytes(without_outputs(whole.name, whole.read_bytes()))
    for outline in (UNKNOWN, read_outline(name)):
        assert read_notebook(short, outline) == read_notebook(whole, outline)
    assert 5 * short.stat().st_size < whole.stat().st_size
