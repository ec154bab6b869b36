"""Notebooks that are odd but legitimate: a lesson's solution with one change of a kind that students make."""

import ast
import json
import re
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, field
from itertools import cycle
from pathlib import Path
from typing import Any

from nao_course.exercises.cells import grade_id, is_solution, metadata, source_of
from tests.paths import PROJECT

Cell = dict[str, Any]


@dataclass
class Notebook:
    """A solution that a change is made to, in which one exercise is looked at."""

    lesson: str
    exercise: str
    cells: list[Cell]
    metadata: dict[str, Any]
    helpers: dict[str, str] = field(default_factory=dict)

    @property
    def at(self) -> int:
        """Index of the exercise's cell."""
        return next(i for i, cell in enumerate(self.cells) if grade_id(cell) == self.exercise)

    @property
    def source(self) -> str:
        return source_of(self.cells[self.at])

    @source.setter
    def source(self, text: str) -> None:
        self.cells[self.at]["source"] = text

    def insert(self, source: str, after: bool = False) -> None:
        """Put a code cell of the student's own before the exercise's cell, or behind its check."""
        self.cells.insert(self.at + 2 * after, code(source))

    def blank(self) -> Cell:
        return next(cell for cell in blank_of(self.lesson) if grade_id(cell) == self.exercise)

    def write(self, folder: Path) -> Path:
        """Write it and its helpers as JupyterLab does."""
        folder.mkdir(parents=True, exist_ok=True)
        for name, text in self.helpers.items():
            (folder / name).write_text(text, encoding="utf-8")
        made = {"nbformat": 4, "nbformat_minor": 5, "metadata": self.metadata, "cells": self.cells}
        path = folder / f"{self.lesson}.ipynb"
        path.write_text(json.dumps(made), encoding="utf-8")
        return path


Change = Callable[[Notebook], object]


@dataclass(frozen=True)
class Odd:
    """A change with its name."""

    name: str
    change: Change


def code(source: str) -> Cell:
    return {"cell_type": "code", "id": f"x{abs(hash(source)) % 10**9}", "metadata": {}, "source": source} | {
        "outputs": [],
        "execution_count": None,
    }


def read(path: Path) -> tuple[list[Cell], dict[str, Any]]:
    held = json.loads(path.read_text(encoding="utf-8"))
    for cell in held["cells"]:
        if cell["cell_type"] == "code":
            cell["outputs"] = []
    return held["cells"], held["metadata"]


def blank_of(lesson: str) -> list[Cell]:
    return read(PROJECT / "notebooks" / f"{lesson}.ipynb")[0]


def exercises_of(lesson: str) -> list[str]:
    """Return the exercises of a lesson that are functions."""
    cells, _ = read(PROJECT / "solutions" / f"{lesson}.ipynb")
    named = [(grade_id(cell), source_of(cell)) for cell in cells if is_solution(cell)]
    return [name for name, source in named if re.search(rf"^def {name}\(", source, re.MULTILINE)]


def solved(lesson: str, exercise: str) -> Notebook:
    return Notebook(lesson, exercise, *read(PROJECT / "solutions" / f"{lesson}.ipynb"))


# --- what stands before, in and after an exercise; NAME is its name ---


def inside(source: str, name: str, text: str) -> str:
    """Put statements at the beginning of a function's body."""
    lines = source.splitlines()
    function = next(each for each in ast.parse(source).body if getattr(each, "name", "") == name)
    first = function.body[1 if ast.get_docstring(function) and len(function.body) > 1 else 0]
    indent = " " * first.col_offset
    return "\n".join(
        [
            *lines[: first.lineno - 1],
            *(indent + line for line in text.splitlines()),
            *lines[first.lineno - 1 :],
        ]
    )


def written(
    before: str = "", prefix: str = "", within: str = "", suffix: str = "", after: str = "", **helpers: str
) -> Change:
    """Return a change that puts cells before and behind the exercise, and text into its own cell."""

    def change(notebook: Notebook) -> None:
        name = notebook.exercise
        before_, prefix_, within_, suffix_, after_ = (
            text.replace("NAME", name) for text in (before, prefix, within, suffix, after)
        )
        source = inside(notebook.source, name, within_) if within_ else notebook.source
        notebook.source = "\n\n".join(filter(None, [prefix_, source, suffix_]))
        if before_:
            notebook.insert(before_)
        if after_:
            notebook.insert(after_, after=True)
        notebook.helpers |= {f"{each}.py": text for each, text in helpers.items()}

    return change


CONSTANTS = {  # statements that make K, and what K is then
    "while": ("K = []\nwhile len(K) < 3:\n    K.append(len(K))", "[0, 1, 2]"),
    "sort": ("K = [2, 0, 1]\nK.sort()", "[0, 1, 2]"),
    "reverse": ("K = [2, 1]\nK.reverse()", "[1, 2]"),
    "del of an item": ("K = {'a': 1, 'b': 2}\ndel K['b']", "{'a': 1}"),
    "del of a name": ("K = i = 3\ndel i", "3"),
    "own call": ("def fill(k):\n    k.append(1)\n\nK = []\nfill(K)", "[1]"),
    "clear": ("K = [1]\nK.clear()", "[]"),
    "main": ("if __name__ == '__main__':\n    K = 3", "3"),
    "for": ("K = []\nfor i in range(3):\n    K.append(i)", "[0, 1, 2]"),
    "for else": ("for K in range(3):\n    pass\nelse:\n    K = 7", "7"),
    "comprehension": ("K = []\n[K.append(i) for i in range(2)]", "[0, 1]"),
    "try": ("try:\n    K = no_such_name\nexcept NameError:\n    K = 5\nfinally:\n    K += 1", "6"),
    "with": ("import contextlib\nwith contextlib.suppress(KeyError):\n    K = 3", "3"),
    "match": ("match 3:\n    case 3:\n        K = 4", "4"),
    "exec": ("exec('K = 3')", "3"),
    "globals": ("globals()['K'] = 3", "3"),
    "walrus": ("(K := 3)", "3"),
    "if walrus": ("if (K := 3) > 2:\n    K += 1", "4"),
    "star": ("K, *L = 1, 2, 3", "1"),
    "swap": ("K, L = 1, 2\nK, L = L, K", "2"),
    "slice": ("import numpy\nK = numpy.zeros(2)\nK[:] = 1\nK = K.tolist()", "[1.0, 1.0]"),
    "fill": ("import numpy\nK = numpy.zeros(2)\nK.fill(1)\nK = K.tolist()", "[1.0, 1.0]"),
    "setattr": ("class C:\n    pass\n\nsetattr(C, 'k', 3)\nK = C.k", "3"),
    "attribute": ("class C:\n    pass\n\nC.k = 3\nK = C.k", "3"),
    "map": ("K = list(map(lambda i: 2 * i, range(3)))", "[0, 2, 4]"),
    "pop": ("K = [1, 2, 3]\nK.pop()", "[1, 2]"),
    "chained call": ("K = {'a': []}\nK['a'].append(3)", "{'a': [3]}"),
    "dict update": ("K = {}\nK.update(a=1)\nK |= {'b': 2}", "{'a': 1, 'b': 2}"),
    "annotation": ("K: int = 3", "3"),
    "assert": ("K = 3\nassert K == 3", "3"),
    "global": ("def make():\n    global K\n    K = 3\n\nmake()", "3"),
    "semicolons": ("K = 1; K += 2; print(K)", "3"),
    "shuffle": (
        "import random\nK = [1, 2, 3]\nrandom.seed(1)\nrandom.shuffle(K)\nK = sorted(K)",
        "[1, 2, 3]",
    ),
    "lambda": ("add = lambda k: k.append(3)\nK = []\nadd(K)", "[3]"),
    "decorator that registers": (
        "K = []\n\ndef keep(f):\n    K.append(f.__name__)\n    return f\n\n@keep\ndef a(): ...",
        "['a']",
    ),
    "await": ("import asyncio\n\nasync def three():\n    return 3\n\nK = await three()", "3"),
    "await alone": ("import asyncio\nK = []\n\nasync def fill():\n    K.append(3)\n\nawait fill()", "[3]"),
    "line magic": ("%precision 3\nK = 3", "3"),
    "time magic": ("%time K = 3", "3"),
    "cell time": ("%%time\nK = 3", "3"),
    "capture": ("%%capture\nK = 3\nprint(K)", "3"),
    "shell": ("!true\nK = 3", "3"),
    "help": ("K = 3\nK?", "3"),
    "autoreload": ("%load_ext autoreload\n%autoreload 2\nK = 3", "3"),
    "indented magic": ("if True:\n    %time pass\n    K = 3", "3"),
    "prompt": (">>> K = 3", "3"),
    "underscore": ("3\nK = 3\nK", "3"),
    "math star": ("from math import *\nK = floor(3.5)", "3"),
    "numpy star": ("from numpy import *\nK = int(sum([1, 2]))", "3"),
    "several cells": ("K = []", "[]"),
}
HALF = "def half(x):\n    return x / 2\n"
VARIANTS = {  # ways to write an exercise and what belongs to it; each passes
    "helper before": written(before=HALF, within="half(3)"),
    "helper behind the check": written(within="globals().get('half', abs)(3)", after=HALF),
    "helper defined again": written(
        before=HALF, within="assert half(3) == 1.5", after="def half(x):\n    return 0"
    ),
    "helper's helper defined again": written(
        before="def two():\n    return 2\n\ndef half(x):\n    return x / two()",
        within="assert half(3) == 1.5",
        after="def two():\n    return 3",
    ),
    "helper in its cell": written(prefix=HALF, within="half(3)"),
    "constant behind it in its cell": written(within="assert LIMIT == 3", suffix="LIMIT = 3"),
    "helper file": written(prefix="from mine import half", within="half(3)", mine=HALF),
    "helper file of two": written(
        prefix="import mine",
        within="mine.half(3)",
        mine="from other import two\ndef half(x):\n    return x / two\n",
        other="two = 2\n",
    ),
    "star of a helper file": written(prefix="from mine import *", within="half(3)", mine=HALF),
    "%run": written(before="%run mine.py", within="half(3)", mine=HALF),
    "global cache": written(before="cache = {}", within="cache[len(cache)] = 1"),
    "recursion": written(
        before="def fac(n):\n    return 1 if n < 2 else n * fac(n - 1)", within="assert fac(5) == 120"
    ),
    "dataclass": written(
        before="from dataclasses import *\n@dataclass\nclass P:\n  x: int\n  y: list = field(default_factory=list)",
        within="assert P(1).y == []",
    ),
    "typing": written(
        before="from typing import NamedTuple, TypeVar\nT = TypeVar('T')\n\nclass P(NamedTuple):\n    x: float = 1",
        within="assert P().x == 1",
    ),
    "enum": written(
        before="from enum import Enum, auto\n\nclass Colour(Enum):\n    RED = auto()",
        within="assert Colour.RED.value == 1",
    ),
    "classes over cells": written(
        before="class A:\n    def f(self):\n        return 1",
        prefix="class B(A):\n    def f(self):\n        return super().f() + 1",
        within="assert B().f() == 2",
    ),
    "class that is extended": written(
        before="class A:\n    x = 1",
        prefix="def f(self):\n    return self.x\n\nA.f = f",
        within="assert A().f() == 1",
    ),
    "global counter": written(before="calls = 0", within="global calls\ncalls += 1"),
    "nested functions": written(within="def inner(y):\n    return y\n\ninner(3)"),
    "generator": written(
        before="def gen():\n    yield from range(3)", within="assert list(gen()) == [0, 1, 2]"
    ),
    "unicode": written(before="größe = 3\nα = 2\nπ = 3.14", within="assert größe + α == 5  # 🤖"),
    "alias import": written(prefix="import numpy as xp, cv2 as cv", within="xp.zeros(3), cv.COLOR_BGR2GRAY"),
    "import inside": written(within="import math, itertools\nfrom collections import defaultdict"),
    "future": written(prefix="from __future__ import annotations", within="pass"),
    "lru_cache": written(
        before="from functools import lru_cache\n\n@lru_cache(maxsize=None)\ndef f(n):\n    return n",
        within="f(3)",
    ),
    "own decorator": written(
        suffix="import functools as t\ntimed = lambda f: t.wraps(f)(lambda *a, **k: f(*a, **k))\n\nNAME = timed(NAME)"
    ),
    "decorator without wraps": written(
        suffix="def timed(f):\n    return lambda *a, **k: f(*a, **k)\n\nNAME = timed(NAME)"
    ),
    "alias": written(suffix="first_try = NAME\nNAME = first_try"),
    "lambda": written(suffix="mine = NAME\nNAME = lambda *a, **k: mine(*a, **k)"),
    "partial": written(suffix="from functools import partial\nNAME = partial(NAME)"),
    "callable object": written(
        suffix="f = NAME\nclass Call:\n  def __call__(self, *a, **k):\n    return f(*a, **k)\n\nNAME = Call()"
    ),
    "print": written(within="print('here', end='\\r')"),
    "logging": written(within="import logging\nlogging.warning('here')"),
    "warning": written(within="import warnings\nwarnings.warn('here')"),
    "progress bar": written(within="import sys\nsys.stderr.write('\\r 3%')"),
    "comments": written(prefix="# TODO\n\n\n# my solution:", suffix="# done"),
    "docstring before": written(prefix='"""What I did."""'),
    "old attempt above": written(before="def NAME(*args):\n    return 3"),
    "error in another cell": written(before="1 / 0", after="no_such_name"),
    "error below it in its cell": written(suffix="1 / 0"),
    "syntax error in another cell": written(before="def (", after="x ="),
    "call below it": written(suffix="try:\n    NAME()\nexcept TypeError:\n    print('expected')"),
    "input at the top": written(before="name = input('Your name? ')"),
    "exit at the top": written(after="exit()"),
    "sys.exit at the top": written(after="import sys\nsys.exit()"),
    "breakpoint at the top": written(before="# breakpoint()\npass"),
    "seed": written(before="import numpy as np, random\nnp.random.seed(3)\nrandom.seed(3)"),
    "print options": written(before="import numpy as np\nnp.set_printoptions(precision=2, suppress=True)"),
    "recursion limit": written(before="import sys\nsys.setrecursionlimit(5000)"),
    "chdir": written(after="import os\nos.makedirs('figures', exist_ok=True)\nos.chdir('figures')"),
    "environment": written(
        before="import os\nos.environ['MY_FLAG'] = '1'", within="assert os.environ['MY_FLAG'] == '1'"
    ),
    "plot": written(after="import matplotlib.pyplot as plt\nplt.figure()\nplt.plot([1, 2])\nplt.show()"),
    "type alias": written(
        before="from numpy.typing import NDArray\nimport numpy as np\nNumbers = NDArray[np.float64]"
    ),
    "builtins used again": written(after="list = [1]\nsum = 3\nprint('later')\nstr = 'a'\nlen = None"),
    "module in a function": written(within="from types import SimpleNamespace as S\nS(a=1)"),
    "async helper": written(before="import asyncio\n\nasync def f():\n    return 3\n\nx = await f()"),
    "walrus inside": written(within="if (n := 10) > 5:\n    pass"),
    "star args": written(
        before="def add(*numbers, **named):\n    return sum(numbers)", within="assert add(1, 2, a=3) == 3"
    ),
    "global list that grows": written(before="log = []", within="log.append(1)"),
    "nonlocal": written(within="n = 0\ndef up():\n    nonlocal n\n    n += 1\nup()"),
    "try finally": written(within="try:\n    pass\nfinally:\n    pass"),
    "tabs": written(within="if True:\n\tpass"),
}
INTERACTIVE = {  # statements inside a function, and whether it passes
    "imshow": (
        "import cv2\ncv2.imshow('m', None)\nassert cv2.waitKey(0) == -1\ncv2.destroyAllWindows()",
        True,
    ),
    "plt.show": ("import matplotlib.pyplot as plt\nplt.show()\nplt.close('all')", True),
    "display": ("display(3)", True),
    "imported display": ("from IPython.display import display\ndisplay(3)", True),
    "Colab's imshow": ("from google.colab.patches import cv2_imshow\ncv2_imshow(None)", True),
    "get_ipython": ("get_ipython().run_line_magic('precision', '3')", True),
    "input": ("input('go on?')", False),
    "breakpoint": ("breakpoint()", False),
    "pdb": ("import pdb\npdb.set_trace()", False),
    "quit": ("quit()", False),
    "exit": ("exit()", False),
    "sys.exit": ("import sys\nsys.exit(0)", False),
    "getpass": ("from getpass import getpass\ngetpass()", False),
    "stdin": ("import sys\nassert sys.stdin.readline()", False),
    "wait for a click": ("import cv2\ncv2.selectROI(None)", False),
}
FAILING = {  # a definition that fails, and so passes nowhere
    "annotation": lambda source: re.sub(r"\) ->.*:|\):", ") -> NoSuchType:", source, count=1),
    "decorator": lambda source: f"@no_such_decorator\n{source}",
    "default": lambda source: re.sub(r"\) ->", ", *, k=no_such_name) ->", source, count=1),
    "syntax": lambda source: f"{source}\n    return (",
    "indentation": lambda source: f"{source}\n  return 3",
    "name": lambda source: source.replace("def ", "def not_", 1),
    "not written": lambda source: (
        f"{source.splitlines()[0].split('(')[0]}(*args, **kwargs):\n    raise NotImplementedError"
    ),
    "wrong": lambda source: f"{source.splitlines()[0].split('(')[0]}(*args, **kwargs):\n    return 'wrong'",
    "returns nothing": lambda source: f"{source.splitlines()[0].split('(')[0]}(*args, **kwargs):\n    pass",
    "own error": lambda source: (
        f"{source.splitlines()[0].split('(')[0]}(*args, **kwargs):\n    raise ValueError('no')"
    ),
    "commented out": lambda source: "\n".join(f"# {line}" for line in source.splitlines()),
    "in quotes": lambda source: (
        f"'''\n{source}\n'''" if "'''" not in source else f"# {source.splitlines()[0]}"
    ),
    "under if False": lambda source: "if False:\n" + "\n".join(f"    {line}" for line in source.splitlines()),
}
REUSED = {  # statements in a later cell that use the name of the exercise, or of a module in it, for a value
    "assigned": "NAME = 3",
    "array": "import numpy as np\nNAME = np.zeros(3) > 1",
    "loop": "for NAME in range(3):\n    pass",
    "with": "import io\nwith io.StringIO() as NAME:\n    pass",
    "except": "try:\n    1 / 0\nexcept ZeroDivisionError as NAME:\n    pass",
    "walrus": "(NAME := 3)",
    "import": "import math as NAME",
    "unpacked": "NAME, other = 1, 2",
    "deleted": "del NAME",
    "comprehension": "[NAME for NAME in range(3)]",
    "annotated": "NAME: int = 3",
    "global": "def f():\n    global NAME\n    NAME = 3\n\nf()",
}


# --- cells that are repeated, split, merged, moved and stripped ---


def doubled(order: Callable[[Notebook, Cell], list[Cell]]) -> Change:
    """Return a change that puts other cells in place of the exercise's."""

    def change(notebook: Notebook) -> None:
        at = notebook.at
        notebook.cells[at : at + 1] = order(notebook, notebook.cells[at])

    return change


def wrong(notebook: Notebook) -> str:
    return f"def {notebook.exercise}(*args, **kwargs):\n    return 'an earlier attempt'"


def whole(cells: Callable[[list[Cell], list[Cell]], list[Cell]]) -> Change:
    """Return a change of a notebook's cells that gets the solution's and the release's."""

    def change(notebook: Notebook) -> None:
        notebook.cells = cells(notebook.cells, deepcopy(blank_of(notebook.lesson)))

    return change


def each_cell(edit: Callable[[Cell], object]) -> Change:
    return lambda notebook: [edit(cell) for cell in notebook.cells]


def its_cell(edit: Callable[[Cell], object]) -> Change:
    return lambda notebook: edit(notebook.cells[notebook.at])


def text_of(edit: Callable[[str], Any]) -> Callable[[Cell], object]:
    return lambda cell: cell.update(source=edit(source_of(cell)))


def merged(notebook: Notebook) -> None:
    at = notebook.at
    notebook.cells[at]["source"] = f"{notebook.source}\n\n{source_of(notebook.cells[at + 1])}"
    del notebook.cells[at + 1]


def merged_with_the_next_exercise(notebook: Notebook) -> None:
    rest = [
        i
        for i, cell in enumerate(notebook.cells)
        if i > notebook.at and is_solution(cell) and cell["cell_type"] == "code"
    ]
    for other in rest[:1]:
        notebook.source += "\n\n\n" + source_of(notebook.cells[other])
        del notebook.cells[other]


def split(notebook: Notebook) -> None:
    notebook.source = "\n\n\n".join([*_imports(notebook.source), notebook.source])
    first, _, rest = notebook.source.partition("\n\n\n")
    if rest:
        notebook.source = rest
        notebook.insert(first)


def _imports(source: str) -> list[str]:
    return ["import numpy as np"] if "np." in source else []


def moved(to: int) -> Change:
    def change(notebook: Notebook) -> None:
        at = notebook.at
        pair = notebook.cells[at : at + 2]
        del notebook.cells[at : at + 2]
        notebook.cells[to if to >= 0 else len(notebook.cells) :] = (
            pair + notebook.cells[to if to >= 0 else len(notebook.cells) :]
        )

    return change


def stamped(**values: Any) -> Change:
    return lambda notebook: notebook.metadata.update(values)


def interleaved(one: list[Cell], other: list[Cell]) -> list[Cell]:
    return [cell for pair in zip(one, other, strict=False) for cell in pair]


CELLS: dict[str, Change] = {
    "pasted twice": doubled(lambda notebook, cell: [cell, deepcopy(cell)]),
    "blank behind": doubled(lambda notebook, cell: [cell, notebook.blank()]),
    "blank before": doubled(lambda notebook, cell: [notebook.blank(), cell]),
    "blank kept without metadata": doubled(lambda notebook, cell: [code(source_of(notebook.blank())), cell]),
    "answer below the blank cell": doubled(lambda notebook, cell: [notebook.blank(), code(source_of(cell))]),
    "earlier attempt before": doubled(lambda notebook, cell: [code(wrong(notebook)), cell]),
    "its text in two cells": split,
    "merged with its check": merged,
    "merged with the next exercise": merged_with_the_next_exercise,
    "moved to the end": moved(-1),
    "moved up": moved(4),
    "whole twice": whole(lambda mine, blank: [*mine, *deepcopy(mine)]),
    "whole, blank behind": whole(lambda mine, blank: [*mine, *blank]),
    "whole, blank before": whole(lambda mine, blank: [*blank, *mine]),
    "whole, interleaved": whole(interleaved),
    "whole, interleaved the other way": whole(lambda mine, blank: interleaved(blank, mine)),
    "without metadata": each_cell(lambda cell: cell.update(metadata={})),
    "without its metadata": its_cell(lambda cell: cell.update(metadata={})),
    "without roles": each_cell(lambda cell: cell["metadata"].pop("nao_course", None)),
    "without grade ids": each_cell(lambda cell: cell["metadata"].pop("nbgrader", None)),
    "without ids": each_cell(lambda cell: cell.pop("id", None)),
    "without the notebook's metadata": lambda notebook: notebook.metadata.clear(),
    "lines": each_cell(text_of(lambda text: text.splitlines(keepends=True))),
    "CRLF": each_cell(text_of(lambda text: text.replace("\n", "\r\n"))),
    "retyped with other blanks": its_cell(
        text_of(lambda text: text.replace("    ", "  ").rstrip() + "\n\n\n")
    ),
    "old release": stamped(nao_course={"lesson": "", "version": "0.0.1"}),
    "Colab": stamped(colab={"provenance": []}, kernelspec={"name": "python3", "display_name": "Python 3"}),
    "conda": stamped(
        kernelspec={
            "name": "conda-env-lab-py",
            "display_name": "Python [conda env:lab]",
            "language": "python",
        }
    ),
    "no other cells": lambda notebook: notebook.cells.__setitem__(
        slice(None),
        [
            cell
            for cell in notebook.cells
            if cell["cell_type"] == "code"
            and metadata(cell, "nao_course").get("role") not in ("display", "payoff", "example")
        ],
    ),
    "set-up with more": lambda notebook: text_of(lambda text: f"{text}\nimport itertools\n")(
        notebook.cells[_setup(notebook)]
    ),
    "set-up twice": lambda notebook: notebook.cells.insert(0, deepcopy(notebook.cells[_setup(notebook)])),
    "in Markdown": its_cell(lambda cell: (cell.update(cell_type="markdown"), cell.pop("outputs"))),
    "raw": its_cell(lambda cell: (cell.update(cell_type="raw"), cell.pop("outputs"))),
    "written to a file": its_cell(text_of(lambda text: f"%%writefile mine.py\n{text}")),
    "as a script": its_cell(text_of(lambda text: f"%%bash\n{text}")),
    "deleted": lambda notebook: notebook.cells.pop(notebook.at),
    "without a check": lambda notebook: notebook.cells.pop(notebook.at + 1),
}


def _setup(notebook: Notebook) -> int:
    return next(
        i for i, cell in enumerate(notebook.cells) if metadata(cell, "nao_course").get("role") == "setup"
    )


def every() -> Iterator[Odd]:
    """Return all changes."""
    yield from (Odd(name, change) for name, change in CELLS.items())
    yield from (
        Odd(f"constant by {name}", written(before=text, within=f"assert K == {value}"))
        for name, (text, value) in CONSTANTS.items()
    )
    yield from (Odd(name, change) for name, change in VARIANTS.items())
    yield from (Odd(f"{name} inside", written(within=text)) for name, (text, _) in INTERACTIVE.items())
    yield from (Odd(f"fails: {name}", its_cell(text_of(edit))) for name, edit in FAILING.items())
    yield from (Odd(f"name reused: {name}", written(after=text)) for name, text in REUSED.items())


def corpus(lessons: Mapping[str, Any] | list[str]) -> list[tuple[Odd, str, str]]:
    """Return each change with a lesson and an exercise, in turn."""
    turns = {lesson: cycle(exercises_of(lesson)) for lesson in lessons}
    return [(odd, lesson, next(turns[lesson])) for odd, lesson in zip(every(), cycle(lessons), strict=False)]
