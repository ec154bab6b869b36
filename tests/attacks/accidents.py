"""Accidents and odd but honest work: broken files, and notebooks in every shape that students write them in."""

from __future__ import annotations

import importlib.util
import io
import json
import os
import stat
import warnings
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from tests.attacks.range import BLANK, LESSON, RIGHT, Attack, all_but, cell, notebook

FILE = f"{LESSON}.ipynb"
FORMAT = "not a notebook of format 4"
HONEST = notebook(Attack("honest", "honest"))
TEXT = json.dumps(HONEST, indent=1)


def broken(name: str, content: bytes | str, says: str = FORMAT, row: str = "broken") -> Attack:
    """A file that is no notebook: refused with a reason."""
    return Attack(name, row, files={FILE: content}, says=says, refused=True)


def readable(name: str, content: bytes | str, row: str = "broken") -> Attack:
    """A file that is odd, but says clearly what the student wrote: full points."""
    return Attack(name, row, all_but(), files={FILE: content})


def edited(
    name: str, edit: Callable[[dict[str, Any]], object], *lost: str, row: str = "broken", says: str = ""
) -> Attack:
    """A notebook that is odd in one place, which costs no more than what stands there."""
    return Attack(name, row, all_but(*lost), edit=edit, says=says)


def style(name: str, function: str, source: str, *, row: str = "styles", **more: Any) -> Attack:
    """One exercise written in another way: full points."""
    return Attack(name, row, more.pop("honest", all_but()), {function: source}, **more)


def put(name: str, honest: Mapping[str, float], make: Callable[[Path], object], says: str = "") -> Attack:
    """What is no plain file; refused where nothing can be earned."""
    return Attack(name, "broken", honest, make=make, says=says, refused=not honest)


# --- files that are no notebooks ---

R_CELLS = "clamp <- function(x, low, high) {\n  max(low, min(high, x))\n}"
JULIA_CELLS = "function clamp(x, low, high)\n    max(low, min(high, x))\nend"


def foreign(source: str, name: str) -> str:
    """The notebook in another language."""
    cells = [cell(source, each) for each in RIGHT]
    kernel = {"kernelspec": {"name": name, "language": name, "display_name": name}}
    return json.dumps(HONEST | {"cells": cells, "metadata": HONEST["metadata"] | kernel})


OLD_FORMAT = json.dumps(
    {
        "nbformat": 3,
        "metadata": {},
        "worksheets": [
            {"cells": [{"cell_type": "code", "language": "python", "input": each} for each in RIGHT.values()]}
        ],
    }
)
CONFLICT = TEXT.replace(
    '  "cell_type": "code",',
    '<<<<<<< HEAD\n  "cell_type": "code",\n=======\n  "cell_type": "raw",\n>>>>>>> mine',
    1,
)
NO_NOTEBOOKS = (
    broken("json_truncated", TEXT[:-300]),
    broken("json_binary", bytes(range(256)) * 40),
    broken("json_list", "[]"),
    broken("json_number", "7"),
    broken("json_null", "null"),
    broken("json_text", '"cells"'),
    broken("json_empty_dict", "{}"),
    broken("json_cells_a_dict", '{"nbformat": 4, "cells": {"cell_type": "code"}}'),
    broken("json_key_nan", '{NaN: 1, "nbformat": 4, "cells": []}'),
    broken("json_two_documents", TEXT + TEXT),
    broken("empty", b"", "it is empty"),
    broken("blank", b" \n\t\r\n" * 100, "it is empty"),
    broken("format_3", OLD_FORMAT),
    broken("format_5", json.dumps(HONEST | {"nbformat": 5})),
    broken("language_r", foreign(R_CELLS, "R"), "in Python, got R"),
    broken("language_julia", foreign(JULIA_CELLS, "julia"), "in Python, got julia"),
    broken("conflict_in_file", CONFLICT),
    broken("html", "<!doctype html><title>nao_attack</title><p>Log in to download"),
    broken("python_script", "\n\n".join(RIGHT.values())),
    broken("nested", '{"nbformat": 4, "cells": ' + "[" * 100_000 + "]" * 100_000 + "}", row="large"),
    broken(
        "nested_dicts", '{"nbformat": 4, "cells": ' + '{"a":' * 100_000 + "1" + "}" * 100_001, row="large"
    ),
    broken("zip_named_ipynb", b"PK\3\4" + bytes(200)),
)


# --- notebooks that are odd in one place ---


def into(index: int, **changes: Any) -> Callable[[dict[str, Any]], None]:
    """Change a code cell; 1 is that of `clamp`."""
    return lambda made: made["cells"][index].update(changes)


def without(index: int, key: str) -> Callable[[dict[str, Any]], None]:
    return lambda made: made["cells"][index].pop(key)


def adding(*cells: Any) -> Callable[[dict[str, Any]], None]:
    return lambda made: made["cells"].extend(cells)


def of_notebook(**changes: Any) -> Callable[[dict[str, Any]], None]:
    return lambda made: made.update(changes)


def markdown(source: str, **more: Any) -> dict[str, Any]:
    return {"cell_type": "markdown", "metadata": {}, "source": source} | more


def as_lists(made: dict[str, Any]) -> None:
    """Sources as Jupyter itself writes them."""
    for each in made["cells"]:
        each["source"] = each["source"].splitlines(keepends=True)


def chatty(size: int) -> Callable[[dict[str, Any]], None]:
    output = {"output_type": "stream", "name": "stdout", "text": "x" * size}
    return into(2, outputs=[output])


WRITTEN = {"nbgrader": {"grade_id": "why", "grade": True, "solution": True, "points": 2}}
CONFLICT_IN_CELL = f"<<<<<<< HEAD\n{RIGHT['clamp']}\n=======\n{BLANK['clamp']}\n>>>>>>> mine"
ODD_NOTEBOOKS = (
    readable("utf_8_bom", TEXT.encode("utf-8-sig")),
    readable("utf_32", TEXT.encode("utf-32")),
    readable("utf_16", TEXT.encode("utf-16")),
    readable("latin_1", TEXT.replace("return", "# é\\n    return").encode("latin-1")),
    readable("windows_lines", TEXT.replace("\n", "\r\n")),
    readable("keys_twice", TEXT.replace('"cells"', '"cells": [], "cells"', 1)),
    readable("constants_nan", TEXT.replace('"metadata": {', '"metadata": {"nan": NaN, "inf": -Infinity,')),
    readable("minor_99", TEXT.replace('"nbformat_minor": 5', '"nbformat_minor": 99')),
    edited("no_format", lambda made: made.pop("nbformat")),
    edited("no_metadata", lambda made: made.pop("metadata")),
    edited("no_ids", lambda made: [each.pop("id") for each in made["cells"]]),
    edited("lists_of_lines", as_lists),
    edited("metadata_a_list", of_notebook(metadata=[])),
    edited(
        "metadata_of_odd_types",
        of_notebook(metadata={"kernelspec": 7, "nao_course": "x", "language_info": []}),
    ),
    edited("cell_metadata_a_list", into(1, metadata=[])),
    edited("cell_metadata_null", into(1, metadata=None)),
    edited("cell_metadata_of_odd_types", into(1, metadata={"nbgrader": [1], "nao_course": 5})),
    edited("cell_without_source", without(1, "source"), "clamp"),
    edited("cell_source_null", into(1, source=None), "clamp"),
    edited("cell_source_numbers", into(1, source=[1, None, {}]), "clamp"),
    edited("cell_without_type", without(1, "cell_type"), "clamp"),
    edited("cell_of_unknown_type", into(1, cell_type="raw2"), "clamp"),
    edited("cell_type_a_list", into(1, cell_type=[]), "clamp"),
    edited("cells_that_are_none", adding(None, 7, "text", [], {})),
    edited("half_a_character", into(1, source=RIGHT["clamp"] + "  # \ud800"), "clamp"),
    edited("half_a_character_in_words", adding(markdown("Because \ud83e.", metadata=WRITTEN))),
    edited(
        "half_a_character_in_stamp",
        of_notebook(metadata={"nao_course": {"lesson": "\ud800", "version": "\udfff"}}),
    ),
    edited("null_character", into(1, source=RIGHT["clamp"] + "\0"), "clamp"),
    edited("form_feed_and_nel", into(1, source="\f\n# \x85 \u2028\n" + RIGHT["clamp"])),
    edited("conflict_in_cell", into(1, source=CONFLICT_IN_CELL), "clamp", says="SyntaxError"),
    edited(
        "attachments", adding(markdown("![](attachment:a.png)", attachments={"a.png": {"image/png": "aGk="}}))
    ),
    edited(
        "wrong_kernel_python_cells", of_notebook(metadata={"kernelspec": {"name": "ir", "language": "R"}})
    ),
    edited(
        "kernel_of_colab", of_notebook(metadata={"kernelspec": {"name": "python3"}, "accelerator": "GPU"})
    ),
    edited("outputs_of_45_mb", chatty(45 * 2**20), row="large"),
    edited("a_line_of_5_mb", into(1, source=RIGHT["clamp"] + "  #" + "x" * 5 * 2**20), row="large"),
    edited("blanks_of_1_mb", into(1, source=RIGHT["clamp"] + "\n%time 1\n" + " " * 2**20 + "#"), row="large"),
    edited("blank_lines_of_1_mb", into(1, source="%time 1\n" + "\n" * 2**20 + RIGHT["clamp"]), row="large"),
    edited("empty_cells_100_000", lambda made: made["cells"].extend([cell("")] * 100_000), row="large"),
    edited("written_cells_10_000", adding(*[markdown("x" * 100, metadata=WRITTEN)] * 10_000), row="large"),
    edited(
        "expression_too_deep",
        into(1, source="x = " + "(" * 5000 + ")" * 5000 + "\n" + RIGHT["clamp"]),
        "clamp",
        row="large",
    ),
    broken(
        "outputs_of_51_mb",
        TEXT.replace('"outputs": []', f'"outputs": ["{"x" * 51 * 2**20}"]', 1),
        "larger than 50 MB",
        "large",
    ),
)


# --- what is no plain file, and zips ---


def sparse(folder: Path) -> None:
    with (folder / FILE).open("wb") as file:
        file.truncate(200 * 2**20)


def unreadable(folder: Path) -> None:
    (folder / FILE).write_text(TEXT)
    (folder / FILE).chmod(0)


def link(folder: Path) -> None:
    other = next(path for path in folder.parent.rglob(FILE))
    (folder / FILE).symlink_to(other)


def helper_link(folder: Path) -> None:
    (folder / FILE).write_text(TEXT)
    (folder / "mine.py").symlink_to("/etc/passwd")


def packed(*entries: tuple[str, bytes | str], method: int = zipfile.ZIP_DEFLATED, mode: int = 0) -> bytes:
    """A zip of entries, in which a name may stand twice."""
    made = io.BytesIO()
    with warnings.catch_warnings(), zipfile.ZipFile(made, "w", method) as archive:
        warnings.simplefilter("ignore")
        for name, content in entries:
            entry = zipfile.ZipInfo(name, (2026, 3, 1, 12, 0, 0))
            entry.compress_type, entry.external_attr = method, mode << 16
            archive.writestr(entry, content)
    return made.getvalue()


def encrypted(data: bytes) -> bytes:
    """A zip whose entries say that they are."""
    changed = bytearray(data)
    for mark, offset in ((b"PK\1\2", 8), (b"PK\3\4", 6)):
        changed[changed.find(mark) + offset] |= 1
    return bytes(changed)


def zipped(name: str, data: bytes, says: str = "", file: str = f"{LESSON}.zip") -> Attack:
    """A zip that is handed in: refused where it says why."""
    return put(name, {} if says else all_but(), lambda folder: (folder / file).write_bytes(data), says)


BLANK_TEXT = json.dumps(notebook(Attack("blank", "honest", functions=BLANK)))
BOMB = packed((FILE, bytes(49 * 2**20)))
HONEST_ZIP = packed((FILE, TEXT))
ROOT_READS = hasattr(os, "geteuid") and os.geteuid() == 0
NO_FILES = (
    put("a_200_mb_notebook", {}, sparse, "larger than 50 MB"),
    put("a_folder", {}, lambda folder: (folder / FILE).mkdir(), "it is a folder"),
    put("a_link_to_passwd", {}, lambda folder: (folder / FILE).symlink_to("/etc/passwd"), "symbolic link"),
    put("a_link_to_a_neighbour", {}, link, "symbolic link"),
    put("a_link_to_itself", {}, lambda folder: (folder / FILE).symlink_to(FILE), "symbolic link"),
    put("a_link_to_zeros", {}, lambda folder: (folder / FILE).symlink_to("/dev/zero"), "symbolic link"),
    put("a_pipe", {}, lambda folder: os.mkfifo(folder / FILE), "device or pipe"),
    put("unreadable", all_but() if ROOT_READS else {}, unreadable, "" if ROOT_READS else "cannot be read"),
    put("a_helper_that_is_a_link", all_but(), helper_link, "mine.py does not come along"),
    zipped("zip", HONEST_ZIP),
    zipped("zip_with_windows_names", packed((f"work\\{FILE}", TEXT))),
    zipped("zip_bomb", BOMB, "zip bomb"),
    zipped("zip_parent", packed((f"../{FILE}", TEXT)), "leads outside"),
    zipped("zip_absolute", packed((f"/tmp/nao_attack/{FILE}", TEXT)), "leads outside"),
    zipped("zip_drive", packed((f"C:\\{FILE}", TEXT)), "leads outside"),
    zipped("zip_link", packed((FILE, "/etc/passwd"), mode=stat.S_IFLNK | 0o777), "symbolic link"),
    zipped("zip_encrypted", encrypted(HONEST_ZIP), "encrypted"),
    zipped("zip_lzma", packed((FILE, TEXT), method=zipfile.ZIP_LZMA), "unusual compression"),
    zipped("zip_corrupt", HONEST_ZIP[:200] + b"x" * 40 + HONEST_ZIP[240:], "damaged"),
    zipped("zip_truncated", HONEST_ZIP[:-60], "no zip"),
    zipped("zip_empty", b"", "no zip"),
    zipped("zip_names_twice", packed((FILE, BLANK_TEXT), (FILE, TEXT))),
    zipped("zip_of_an_empty_notebook", packed((FILE, "")), "it is empty"),
    zipped("zip_and_a_zip_in_it", packed((FILE, TEXT), ("old.zip", BOMB), ("__MACOSX/._" + FILE, "x"))),
)

# What names no student and lesson, or is no notebook: by file name in the student's folder, with what is said of it.
UNKNOWN: Mapping[str, tuple[bytes, str]] = {
    f"{FILE}.txt": (TEXT.encode(), "it is no notebook"),
    f"{LESSON}.not-python": (TEXT.encode(), "it is no notebook"),
    "my_solution.ipynb": (TEXT.encode(), "named after no lesson"),
    "11_other_course.ipynb": (TEXT.encode(), "named after no lesson"),
    "nested.zip": (packed(("inner.zip", HONEST_ZIP)), "a zip within a zip is not opened"),
    "nested_bomb.zip": (
        packed(("inner.zip", packed(("inner.zip", BOMB)))),
        "a zip within a zip is not opened",
    ),
    "corrupt.zip": (HONEST_ZIP[:-60], "it is no zip"),
    "not_really.zip": (b"%PDF-1.7", "it is no zip"),
    f"{LESSON}.docx": (b"PK\3\4", "it is no notebook"),
    "report.pdf": (b"%PDF-1.7", "it is no notebook"),
}

# Names of students in a learning platform's zip: all must get a row, a page and their points, and none another's.
NAMES = (
    "Ada",
    "ada",
    "ADA",
    "Ada Lovelace",
    "Müller, Jürgen",
    "Mu\u0308ller",
    "李小龙",
    "<script>nao_attack</script>",
    "ada\x1b[2Jnao_attack",
    "ada\nnao_attack",
    "\u202eada",
    "=HYPERLINK(1)",
    "con",
    "nul.txt",
    "a" * 300,
    "a" * 299 + "b",
    "[bold]ada[/bold]",
    "[/]",
    "ada'; DROP TABLE results; --",
    "100%",
    "🤖",
)


# --- exercises written in every way ---

CLAMP, SCALED, DRAWN, MIDDLE = (RIGHT[name] for name in ("clamp", "scaled", "drawn", "middle"))
STYLES = (
    style("twice", "clamp", f"{BLANK['clamp']}\n\n{CLAMP}"),
    Attack("twice_in_two_cells", "styles", all_but(), functions={"clamp": BLANK["clamp"]}, after=CLAMP),
    Attack("twice_and_the_last_is_blank", "styles", all_but(), after=BLANK["clamp"]),
    style(
        "defaults",
        "clamp",
        """\
def clamp(x, low=0.0, high=1.0, *, strict=True, **more):
    return max(low, min(high, x))""",
    ),
    style("other_argument_names", "scaled", "def scaled(a, /):\n    return (a - a.min()) / np.ptp(a)"),
    style(
        "any_arguments",
        "clamp",
        """\
def clamp(*args):
    x, low, high = args
    return sorted((low, x, high))[1]""",
    ),
    style("lambda", "clamp", "clamp = lambda x, low, high: max(low, min(high, x))"),
    style("library_function", "clamp", "clamp = np.clip"),
    style(
        "callable_object",
        "clamp",
        """\
class Clamp:
    def __call__(self, x, low, high):
        return max(low, min(high, x))
clamp = Clamp()""",
    ),
    style(
        "static_method",
        "clamp",
        """\
class Tools:
    @staticmethod
    def clamp(x, low, high):
        return max(low, min(high, x))
clamp = Tools.clamp""",
    ),
    style(
        "bound_method",
        "clamp",
        """\
class Tools:
    def clamp(self, x, low, high):
        return max(low, min(high, x))
clamp = Tools().clamp""",
    ),
    style(
        "class_that_is_a_float",
        "clamp",
        """\
class clamp(float):
    def __new__(cls, x, low, high):
        return float.__new__(float, max(low, min(high, x)))""",
    ),
    style(
        "partial",
        "clamp",
        """\
from functools import partial
def limit(strict, x, low, high):
    return max(low, min(high, x))
clamp = partial(limit, True)""",
    ),
    style("cached", "clamp", f"from functools import lru_cache\n@lru_cache(maxsize=None)\n{CLAMP}"),
    style(
        "decorated",
        "scaled",
        f"""\
def told(function):
    def inner(*args):
        print('called', args)
        return function(*args)
    return inner

@told
{SCALED}""",
    ),
    style(
        "wrapped_decorator",
        "scaled",
        f"""\
import functools, time
def timed(function):
    @functools.wraps(function)
    def inner(*args, **more):
        start = time.perf_counter()
        try:
            return function(*args, **more)
        finally:
            print(time.perf_counter() - start)
    return inner

@timed
{SCALED}""",
    ),
    style("vectorized", "clamp", f"@np.vectorize\n{CLAMP}"),
    style(
        "generator",
        "scaled",
        """\
def rows(values):
    for row in values:
        yield (row - values.min()) / np.ptp(values)

def scaled(values):
    return np.array(list(rows(values)))""",
    ),
    style(
        "nested_functions",
        "scaled",
        """\
def scaled(values):
    low = values.min()
    def shift(x):
        def scale(y):
            return y / np.ptp(values)
        return scale(x - low)
    return shift(values)""",
    ),
    style(
        "loops",
        "scaled",
        """\
def scaled(values):
    low = high = values[0][0]
    for row in values:
        for v in row:
            low, high = min(low, v), max(high, v)
    out = np.zeros_like(values)
    for i in range(len(values)):
        for j in range(len(values[i])):
            out[i, j] = (values[i, j] - low) / (high - low)
    return out""",
    ),
    style(
        "recursion",
        "middle",
        """\
def middle(values):
    def ordered(v):
        if len(v) < 2:
            return v
        return ordered([x for x in v[1:] if x < v[0]]) + [v[0]] + ordered([x for x in v[1:] if x >= v[0]])
    v = ordered(list(scaled(values).ravel()))
    return (v[(len(v) - 1) // 2] + v[len(v) // 2]) / 2""",
    ),
    style(
        "recursion_800_deep",
        "clamp",
        """\
def deep(n):
    return 0 if n == 0 else 1 + deep(n - 1)

def clamp(x, low, high):
    deep(800)
    return max(low, min(high, x))""",
    ),
    style(
        "annotations",
        "scaled",
        """\
from __future__ import annotations
import numpy.typing as npt
from typing import TypeAlias
Vector: TypeAlias = 'npt.NDArray[np.float64]'

def scaled(values: Vector | Unknown) -> Vector:
    return (values - values.min()) / np.ptp(values)""",
    ),
    style(
        "dataclass",
        "scaled",
        """\
from dataclasses import dataclass

@dataclass(frozen=True)
class Range:
    low: float
    size: float

def scaled(values):
    r = Range(values.min(), np.ptp(values))
    return (values - r.low) / r.size""",
    ),
    style(
        "named_tuple_and_enum",
        "clamp",
        """\
from enum import Enum
from typing import NamedTuple
class Side(Enum):
    LOW = 1
    HIGH = 2
class Limits(NamedTuple):
    low: float
    high: float

def clamp(x, low, high):
    limits = Limits(low, high)
    side = Side.LOW if x < limits.low else Side.HIGH if x > limits.high else None
    return {Side.LOW: low, Side.HIGH: high, None: x}[side]""",
    ),
    style(
        "walrus_and_match",
        "clamp",
        """\
def clamp(x, low, high):
    match (x < low, x > high):
        case (True, _):
            return low
        case (_, True):
            return high
    if (y := x) is not None:
        return y""",
    ),
    style(
        "constants",
        "scaled",
        """\
EPS = 0.0
A, (B, *C) = 1, (2, 3)
N: int = 4
N += 1

def scaled(values):
    return (values - values.min()) / (np.ptp(values) + EPS) * (N - 4)""",
    ),
    # After these imports, `max` is NumPy's, which does not compare two numbers.
    style(
        "star_imports",
        "scaled",
        """\
from math import *
from numpy import *

def scaled(values):
    return (values - amin(values)) / ptp(values)""",
        honest=all_but("clamp"),
        says="TypeError",
    ),
    style("star_import_of_math", "scaled", f"from math import *\n\n{SCALED}"),
    style(
        "try_import",
        "clamp",
        f"""\
try:
    import no_such_module
except ImportError:
    no_such_module = None

{CLAMP}""",
    ),
    style(
        "defined_if",
        "clamp",
        """\
if True:
    def clamp(x, low, high):
        return max(low, min(high, x))
else:
    clamp = None""",
    ),
    style(
        "inner_import",
        "scaled",
        """\
def scaled(values):
    import numpy
    from scipy import stats
    return (values - numpy.min(values)) / numpy.ptp(values)""",
    ),
    style(
        "global_counter",
        "clamp",
        """\
calls = 0
def clamp(x, low, high):
    global calls
    calls += 1
    return max(low, min(high, x))""",
    ),
    style(
        "mutable_default",
        "clamp",
        """\
def clamp(x, low, high, seen=[]):
    seen.append(x)
    return max(low, min(high, seen[-1]))""",
    ),
    style(
        "umlauts",
        "clamp",
        '''\
def clamp(größe, unten, oben):
    """Begrenzt – „so“ 🤖."""
    return max(unten, min(oben, größe))''',
    ),
    style("tabs", "clamp", "def clamp(x, low, high):\n\treturn max(low, min(high, x))"),
    style(
        "main_guard",
        "clamp",
        f"""\
{CLAMP}

if __name__ == '__main__':
    print(clamp(1, 2, 3))
    raise SystemExit""",
    ),
    Attack(
        "helper_in_a_later_cell",
        "styles",
        all_but(),
        {
            "clamp": """\
def clamp(x, low, high):
    return limit(x, low, high)"""
        },
        after="""\
def limit(x, low, high):
    return max(low, min(high, x))""",
    ),
    Attack(
        "helper_file",
        "styles",
        all_but(),
        {
            "clamp": """\
def clamp(x, low, high):
    return mine.limit(x, low, high)"""
        },
        before="import mine",
        files={
            "mine.py": """\
def limit(x, low, high):
    return max(low, min(high, x))
"""
        },
    ),
    Attack(
        "helper_file_that_imports_another",
        "styles",
        all_but(),
        {"clamp": "from first import clamp"},
        files={
            "first.py": """\
from second import *
import numpy as np
""",
            "second.py": CLAMP,
        },
    ),
    Attack(
        "helper_file_that_is_missing",
        "styles",
        all_but("clamp"),
        {
            "clamp": """\
def clamp(x, low, high):
    return mine.limit(x, low, high)"""
        },
        before="import mine",
        says="No module named 'mine'",
    ),
    Attack(
        "helper_file_named_as_the_library",
        "styles",
        all_but(),
        files={"numpy.py": "raise ValueError('nao_attack')", "random.py": "x = 1"},
    ),
    Attack(
        "helper_file_with_an_error",
        "styles",
        all_but(),
        before="import mine",
        files={"mine.py": "def f(:"},
        says="SyntaxError",
    ),
    Attack(
        "all_in_one_cell", "styles", all_but(), dict.fromkeys(RIGHT, ""), after="\n\n".join(RIGHT.values())
    ),
    Attack(
        "all_in_one_cell_at_the_top",
        "styles",
        all_but(),
        dict.fromkeys(RIGHT, ""),
        before="\n\n".join(RIGHT.values()),
    ),
    edited(
        "exercise_cells_renamed",
        lambda made: [
            each["metadata"]["nbgrader"].update(grade_id=f"x{at}")
            for at, each in enumerate(made["cells"])
            if "nbgrader" in each["metadata"]
        ],
        row="styles",
    ),
    edited(
        "check_cells_deleted",
        lambda made: made.update(
            cells=[each for each in made["cells"] if not each["source"].startswith("check")]
        ),
        row="styles",
    ),
    edited("cells_reversed", lambda made: made["cells"].reverse(), row="styles"),
    edited("setup_cell_deleted", lambda made: made["cells"].pop(0), row="styles"),
    edited(
        "all_metadata_lost", lambda made: [each.update(metadata={}) for each in made["cells"]], row="styles"
    ),
    edited(
        "copy_of_another_release",
        of_notebook(metadata={"nao_course": {"lesson": LESSON, "version": "0.9"}}),
        row="styles",
        says="made from release '0.9'",
    ),
    style(
        "syntax_error",
        "clamp",
        """\
def clamp(x, low, high)
    return x""",
        honest=all_but("clamp"),
        says="SyntaxError",
    ),
    style(
        "indentation_error",
        "scaled",
        """\
def scaled(values):
return values""",
        honest=all_but("scaled", middle=4.0),
        says="IndentationError",
    ),
    style(
        "wrong_name",
        "clamp",
        """\
def Clamp(x, low, high):
    return max(low, min(high, x))""",
        honest=all_but("clamp"),
    ),
    style("deleted", "clamp", "", honest=all_but("clamp")),
    style(
        "too_few_arguments", "clamp", "def clamp(x):\n    return x", honest=all_but("clamp"), says="TypeError"
    ),
    style("coroutine", "clamp", f"async {CLAMP}", honest=all_but("clamp")),
    style(
        "generator_answer",
        "scaled",
        """\
def scaled(values):
    yield from (values - values.min()) / np.ptp(values)""",
        honest=all_but("scaled", middle=4.0),
    ),
    style(
        "forgotten_return",
        "clamp",
        """\
def clamp(x, low, high):
    y = max(low, min(high, x))
    print(y)""",
        honest=all_but("clamp"),
        says="return",
    ),
    style(
        "variable_of_a_display_cell",
        "clamp",
        """\
def clamp(x, low, high):
    return max(low, min(high, x)) * FACTOR""",
        honest=all_but("clamp"),
        edit=adding(cell("FACTOR = 1", role="display")),
        says="name 'FACTOR' is not defined",
    ),
)
if importlib.util.find_spec("numba"):
    STYLES += (style("numba", "scaled", f"from numba import njit\n\n@njit\n{SCALED}"),)


# --- honest work that prints, warns, is slow, or answers in another type ---


def answer(name: str, source: str, lines: str = "", lost: str = "") -> Attack:
    """`scaled` with an answer of another type: `made` is the right one; `middle` works on with it."""
    made = "def scaled(values):\n    made = (values - values.min()) / np.ptp(values)\n"
    return style(name, "scaled", f"{lines}\n{made}    return {source}", row="honest", honest=all_but(lost))


def beside(name: str, lines: str, before: str = "", **more: Any) -> Attack:
    """`clamp` that does something else as well."""
    body = "\n".join(f"    {line}" for line in lines.split("\n"))
    source = f"def clamp(x, low, high):\n{body}\n    return max(low, min(high, x))"
    return style(name, "clamp", source, row="honest", before=before, **more)


def top(name: str, source: str, honest: Mapping[str, float] | None = None, **more: Any) -> Attack:
    """A cell of the student's own."""
    return Attack(name, "honest", all_but() if honest is None else honest, before=source, **more)


HONEST_WORK = (
    answer("float32", "made.astype(np.float32)"),
    answer("longdouble", "made.astype(np.longdouble)"),
    answer("big_endian", "made.astype('>f8')"),
    answer("lists", "made.tolist()"),
    answer("tuples", "tuple(map(tuple, made))"),
    answer("list_of_arrays", "list(made)"),
    answer("numpy_numbers_in_lists", "[[np.float64(x) for x in row] for row in made]"),
    answer("read_only", "(made.setflags(write=False), made)[1]"),
    answer("fortran_order", "np.asfortranarray(made)"),
    answer("a_view", "np.repeat(np.repeat(made, 2, 0), 2, 1)[::2, ::2]"),
    answer("negative_strides", "made[::-1, ::-1].copy()[::-1, ::-1]"),
    answer(
        "memory_map",
        "mapped(made)",
        """\
def mapped(a):
    b = np.memmap('scratch.bin', float, 'w+', shape=a.shape)
    b[:] = a
    return b""",
    ),
    answer("masked_array", "np.ma.masked_array(made)"),
    # The median of a masked array is a different one, because it leaves out masked values.
    answer("masked_array_with_a_mask", "np.ma.masked_greater(made, 0.9)", lost="middle"),
    answer("matrix", "np.asmatrix(made)", lost="middle"),  # whose median is a matrix
    answer("record_array_view", "made.view(np.recarray)"),
    answer("subclass", "made.view(Mine)", "class Mine(np.ndarray):\n    pass"),
    answer("complex_without_imaginary_part", "made.astype(np.float16).astype(float) * 0 + made"),
    style(
        "zero_dimensional",
        "clamp",
        """\
def clamp(x, low, high):
    return np.array(max(low, min(high, x)))""",
        row="honest",
    ),
    style(
        "numpy_number",
        "clamp",
        """\
def clamp(x, low, high):
    return np.float64(max(low, min(high, x)))""",
        row="honest",
    ),
    style(
        "float32_number",
        "clamp",
        """\
def clamp(x, low, high):
    return np.float32(max(low, min(high, x)))""",
        row="honest",
    ),
    style(
        "whole_numbers_of_python",
        "clamp",
        """\
def clamp(x, low, high):
    y = max(low, min(high, x))
    return int(y) if y == int(y) else y""",
        row="honest",
    ),
    beside(
        "warns",
        """\
np.log(np.array([0.0, -1.0]))
np.array([1.0]) / 0
import warnings
warnings.warn('old', DeprecationWarning)
warnings.warn('odd', RuntimeWarning)""",
    ),
    beside("invalid_escapes", "'\\d \\w'\nx is 5"),
    beside("prints_a_lot", "for _ in range(20000): print('x' * 100)"),
    beside(
        "progress_bar",
        """\
import sys
for i in range(500): print(f'\\r{i}%|' + chr(9608) * 20, end='', file=sys.stderr, flush=True)""",
    ),
    beside("prints_odd_characters", "print('\\x1b[31m', '\\0', chr(0xd800), '<b>nao_attack</b>')"),
    beside(
        "writes_to_the_buffer",
        """\
import sys
sys.stdout.write('x')
sys.stdout.buffer.write(b'x')
sys.stdout.flush()
sys.stdout.isatty()""",
    ),
    beside(
        "redirects_output",
        """\
import contextlib, io
with contextlib.redirect_stdout(io.StringIO()): print('x')""",
    ),
    beside(
        "logs",
        """\
import logging
logging.basicConfig(level=10)
logging.warning('x')
logging.getLogger('a').debug('y')""",
    ),
    beside("slow", "import time\ntime.sleep(0.4)"),
    beside("busy", "sum(i * i for i in range(2_000_000))"),
    beside("takes_500_mb", "np.ones(500 * 2**17)"),
    beside("random_seed", "np.random.seed(0)\nimport random\nrandom.seed(0)\nnp.random.rand()"),
    beside("errors_raised", "np.seterr(all='raise')"),
    beside("errors_called", "np.seterr(all='call')\nnp.seterrcall(print)"),
    beside("warnings_raised", "import warnings\nwarnings.simplefilter('error')"),
    beside("warnings_reset", "import warnings\nwarnings.resetwarnings()"),
    beside("print_options", "np.set_printoptions(precision=1, suppress=True)"),
    beside("environment", "import os\nos.environ['OMP_NUM_THREADS'] = '64'\nos.environ.clear()"),
    beside("working_folder", "import os, tempfile\nos.chdir(tempfile.mkdtemp())"),
    beside("temporary_file", "import tempfile\nwith tempfile.TemporaryFile() as file: file.write(b'x')"),
    beside("own_file", "with open('notes.txt', 'a') as file: file.write('x')\nopen('notes.txt').read()"),
    beside(
        "figures",
        """\
import matplotlib.pyplot as plt
for _ in range(3): plt.figure()
plt.plot([1, 2])
plt.show()""",
    ),
    beside("recursion_limit", "import sys\nsys.setrecursionlimit(10**5)"),
    beside(
        "threads",
        """\
from concurrent.futures import ThreadPoolExecutor
with ThreadPoolExecutor(4) as pool: x = list(pool.map(lambda v: v, [x]))[0]""",
    ),
    beside(
        "asynchronous",
        """\
import asyncio
async def same(v):
    await asyncio.sleep(0)
    return v
x = asyncio.run(same(x))""",
    ),
    beside(
        "processes",
        """\
import multiprocessing as mp
with mp.get_context('fork').Pool(2) as pool: x = pool.map(abs, [-abs(x)])[0] * (1 if x > 0 else -1)""",
        honest=all_but("clamp"),
        says="FileNotFoundError",
    ),
    beside(
        "program",
        """\
import subprocess, sys
done = subprocess.run([sys.executable, '-c', f'print({x!r})'], capture_output=True, text=True, check=True)
x = float(done.stdout)""",
        honest=all_but("clamp"),
        says="FileNotFoundError",
    ),
    beside("collects_garbage", "import gc\ngc.collect()\ngc.disable()"),
    beside("alarm", "import signal\nsignal.signal(signal.SIGALRM, signal.SIG_DFL)\nsignal.alarm(0)"),
    beside(
        "open_cv_threads",
        """\
import cv2
cv2.setNumThreads(8)
cv2.GaussianBlur(np.zeros((99, 99)), (5, 5), 0)""",
    ),
    beside("displays", "from IPython.display import display\ndisplay(x)"),
    style(
        "changes_its_input",
        "scaled",
        """\
def scaled(values):
    values -= values.min()
    values /= np.ptp(values)
    return values""",
        row="honest",
        says="changes its input",
    ),
    style(
        "ignores_rng",
        "drawn",
        """\
def drawn(rng, n):
    return np.random.normal(size=n).cumsum()""",
        row="honest",
        honest=all_but("drawn"),
    ),
    style(
        "own_generator",
        "drawn",
        """\
def drawn(rng, n):
    rng = np.random.default_rng(0)
    return rng.normal(size=n).cumsum()""",
        row="honest",
        honest=all_but("drawn"),
    ),
    style(
        "random_one_by_one",
        "drawn",
        """\
def drawn(rng, n):
    total, out = 0.0, []
    for _ in range(n):
        total += rng.normal()
        out.append(total)
    return out""",
        row="honest",
    ),
    style(
        "asks",
        "clamp",
        """\
def clamp(x, low, high):
    return float(input('x?'))""",
        row="honest",
        honest=all_but("clamp"),
        says="It waits for a person",
    ),
    top("asks_at_the_top", "name = input('Your name?')"),
    top(
        "magics",
        """\
%matplotlib inline
%timeit sum([1])
!ls
?help
np.sum?
files = !ls
x = %sql 1
%%time
y = 2""",
    ),
    top("cell_magic", "%%bash\nfor i in 1 2; do echo $i; done"),
    style(
        "magic_with_a_function",
        "clamp",
        f"""\
%matplotlib inline
!pip install numpy
{CLAMP}

clamp?
%time clamp(1, 2, 3)""",
        row="honest",
    ),
    style("cell_magic_with_a_function", "clamp", f"%%time\n{CLAMP}", row="honest"),
    top("raises", "raise ValueError('stop here')"),
    top("asserts", "assert 1 == 2, 'not yet'"),
    style(
        "asserts_after_a_function",
        "clamp",
        f"""\
{CLAMP}

assert clamp(1, 2, 3) == 5
clamp('a')
1 / 0""",
        row="honest",
    ),
    Attack(
        "table_filled_by_append",
        "honest",
        all_but(),
        {
            "clamp": "TABLE = []\nTABLE.append(1.0)\nNAMES = {}\nNAMES.update(one=TABLE[0])\n"
            "def clamp(x, low, high):\n    return max(low, min(high, x)) * NAMES['one']"
        },
    ),
    top("awaits", "import asyncio\nx = await asyncio.sleep(0)"),
    top("exits", "import sys\nx = sys.exit(1)"),
    top("exits_in_if", "if 1:\n    import os\n    os._exit(0)"),
    top("endless_while", "while True:\n    pass"),
    top("endless_for", "import itertools\nfor i in itertools.count():\n    pass"),
    top("sleeps_at_the_top", "import time\nx = time.sleep(60)"),
    Attack(
        "endless_display_cell",
        "honest",
        all_but(),
        edit=adding(cell("for i in iter(int, 1): pass", role="display")),
    ),
    Attack(
        "interrupted_output",
        "honest",
        all_but(),
        edit=into(
            1,
            outputs=[{"output_type": "error", "ename": "KeyboardInterrupt", "evalue": "", "traceback": []}],
            execution_count=7,
        ),
    ),
    top("plots", "import matplotlib.pyplot as plt\nfig, ax = plt.subplots()\nax.plot([1])\nplt.show()"),
    top("widgets", "import ipywidgets\nslider = ipywidgets.IntSlider()"),
    top("shadows_builtins", "list = [1, 2]\nstr = 'x'\nint = 5\nlen = 3"),
    top(
        "shadows_numpy",
        """\
numpy = None
np_ = 5
from types import SimpleNamespace
json = struct = SimpleNamespace()""",
    ),
    top(
        "last_matplotlib_backend",
        """\
import matplotlib
matplotlib.use = None
backend = matplotlib.rcParams['backend']""",
    ),
    top(
        "data_file_that_is_not_there",
        """\
import numpy as np
data = np.load('../data/own.npy')""",
        says="FileNotFoundError",
    ),
    top("thousand_functions", "\n".join(f"def f{i}(): return {i}" for i in range(1000))),
    top("thousand_statements", "\n".join(f"x{i} = {i}" for i in range(3000))),
)

ATTACKS: tuple[Attack, ...] = (*NO_NOTEBOOKS, *ODD_NOTEBOOKS, *NO_FILES, *STYLES, *HONEST_WORK)
