"""Accidents and odd but honest work: broken files, and notebooks in every shape that students write them in.

An entry stands for one thing that a reader of files, the loader of definitions or the codec treats in a way of its own.
What only changes the inside of a function is another student's notebook (`tests/real_life`), not an entry here.
"""

import copy
import gzip
import importlib.util
import io
import json
import os
import random
import stat
import struct
import sys
import textwrap
import warnings
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from tests.attacks.range import BLANK, LESSON, RIGHT, Attack, all_but, cell, notebook

FILE = f"{LESSON}.ipynb"
FORMAT = "not a notebook of format 4"
HONEST = notebook(Attack("honest", "honest"))
TEXT = json.dumps(HONEST, indent=1)
BLANK_TEXT = json.dumps(notebook(Attack("blank", "honest", functions=BLANK)))
CLAMP, SCALED = RIGHT["clamp"], RIGHT["scaled"]
Edit = Callable[[dict[str, Any]], object]


# --- how an entry is made ---


def broken(name: str, content: bytes | str, says: str = FORMAT, row: str = "broken") -> Attack:
    """A file that is no notebook: refused with a reason."""
    return Attack(name, row, files={FILE: content}, says=says, refused=True)


def readable(name: str, content: bytes | str, row: str = "broken") -> Attack:
    """A file that is odd, but says clearly what the student wrote: full points."""
    return Attack(name, row, all_but(), files={FILE: content})


def edited(name: str, edit: Edit, *lost: str, row: str = "broken", says: str = "") -> Attack:
    """A notebook that is odd in one place, which costs no more than what stands there."""
    return Attack(name, row, all_but(*lost), edit=edit, says=says)


def put(name: str, honest: Mapping[str, float], make: Callable[[Path], object], says: str = "") -> Attack:
    """What is no plain file; refused where nothing can be earned."""
    return Attack(name, "broken", honest, make=make, says=says, refused=not honest)


def named(name: str, *files: tuple[str, bytes | str]) -> Attack:
    """Files in the student's folder, each later than the one before, with full points."""

    def make(folder: Path) -> None:
        for number, (file, content) in enumerate(files):
            (folder / file).write_bytes(content.encode() if isinstance(content, str) else content)
            os.utime(folder / file, (1.8e9 + number, 1.8e9 + number))

    return put(name, all_but(), make)


def zipped(name: str, data: bytes, says: str = "") -> Attack:
    """A zip that is handed in: refused where it says why."""
    return put(name, {} if says else all_but(), lambda to: (to / f"{LESSON}.zip").write_bytes(data), says)


def large(
    name: str,
    edit: Edit = lambda made: None,
    text: Callable[[str], str | bytes] = lambda made: made,
    honest: Mapping[str, float] | None = None,
    says: str = "",
) -> Attack:
    """A notebook with three megabytes of output, which a confined process reads first, that is odd in one place."""

    def make(folder: Path) -> None:
        made = copy.deepcopy(HONEST)
        padded(made)
        edit(made)
        content = text(json.dumps(made))
        (folder / FILE).write_bytes(content if isinstance(content, bytes) else content.encode())

    return replace(put(f"large_{name}", all_but() if honest is None else honest, make, says), row="large")


def style(name: str, source: str, function: str = "clamp", *, row: str = "styles", **more: Any) -> Attack:
    """One exercise written in another way: full points, unless others are stated."""
    return Attack(name, row, more.pop("honest", all_but()), {function: source}, **more)


def answer(name: str, source: str, lost: str = "") -> Attack:
    """`scaled` with an answer of another type: `made` is the right one; `middle` works on with it."""
    made = "def scaled(values):\n    made = (values - values.min()) / np.ptp(values)\n"
    return style(name, f"{made}    return {source}", "scaled", row="honest", honest=all_but(lost))


def beside(name: str, lines: str, *lost: str, says: str = "") -> Attack:
    """`clamp` that does something else as well."""
    body = textwrap.indent(textwrap.dedent(lines).strip(), "    ")
    source = f"def clamp(x, low, high):\n{body}\n    return max(low, min(high, x))"
    return style(name, source, row="honest", honest=all_but(*lost), says=says)


def top(name: str, source: str, says: str = "") -> Attack:
    """A cell of the student's own, which costs nothing."""
    return Attack(name, "honest", all_but(), before=source, says=says)


# --- files ---


def foreign(source: str, name: str) -> str:
    """The notebook in another language."""
    kernel = {"kernelspec": {"name": name, "language": name, "display_name": name}}
    cells = [cell(source, each) for each in RIGHT]
    return json.dumps(HONEST | {"cells": cells, "metadata": HONEST["metadata"] | kernel})


TRICKS = {"kernelspec": {"name": "x", "language": "\x1b[2J\u202eR<b id=nao_attack>\ud800"}}
TRICKY = json.dumps(json.loads(foreign("x <- 1", "R")) | {"metadata": TRICKS})
OLD_CELLS = [{"cell_type": "code", "language": "python", "input": each} for each in RIGHT.values()]
CONFLICT = "<<<<<<< HEAD\n{}\n=======\n{}\n>>>>>>> mine"
NO_NOTEBOOKS = (
    broken("json_truncated", TEXT[:-300]),
    broken("json_binary", bytes(range(256)) * 40),
    broken("json_list", "[]"),
    broken("json_empty_dict", "{}"),
    broken("json_cells_a_dict", '{"nbformat": 4, "cells": {"cell_type": "code"}}'),
    broken("json_key_nan", '{NaN: 1, "nbformat": 4, "cells": []}'),
    broken("empty", b"", "it is empty"),
    broken("blank", b" \n\t\r\n" * 100, "it is empty"),
    broken("format_3", json.dumps({"nbformat": 3, "metadata": {}, "worksheets": [{"cells": OLD_CELLS}]})),
    broken("format_5", json.dumps(HONEST | {"nbformat": 5})),
    broken("language_r", foreign("clamp <- function(x, low, high) max(low, min(high, x))", "R"), "in Python, got R"),
    broken("language_that_plays_tricks", TRICKY, "in Python, got"),
    broken("conflict_in_file", TEXT.replace('"cell_type": "code",', CONFLICT.format('"cell_type": "code",', ""), 1)),
    broken("html", "<!doctype html><title>nao_attack</title><p>Log in to download"),
    broken("zip_named_ipynb", b"PK\3\4" + bytes(200)),
    broken("nested", '{"nbformat": 4, "cells": ' + "[" * 100_000 + "]" * 100_000 + "}", row="large"),
    broken("nested_in_outputs", TEXT.replace('"outputs": []', '"outputs": ' + "[" * 10**5 + "]" * 10**5, 1)),
    broken("outputs_of_51_mb", TEXT.replace('"outputs": []', f'"outputs": ["{"x" * 51 * 2**20}"]', 1),
           "larger than 50 MB", "large"),
)  # fmt: skip


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


def raw_zip(
    *entries: tuple[bytes, bytes], size: int | None = None, before: bytes = b"", comment: bytes = b""
) -> bytes:
    """A zip of stored entries with names of any bytes, and any size said of them."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w") as archive:
        for at, (name, content) in enumerate(entries):
            archive.writestr(f"{at}".rjust(len(name), "n"), content)
        archive.comment = comment
    data = made.getvalue()
    for at, (name, content) in enumerate(entries):
        data = data.replace(f"{at}".rjust(len(name), "n").encode(), name)
        if size is not None:
            data = data.replace(len(content).to_bytes(4, "little"), size.to_bytes(4, "little"))
    return before + data


def directory(offset: int, value: bytes, times: int = 1) -> bytes:
    """The notebook's zip with bytes of its table of contents changed, and the only entry of it some times."""
    data = bytearray(raw_zip(ENTRY))
    start, end = data.index(b"PK\1\2"), data.rindex(b"PK\5\6")
    data[start + offset : start + offset + len(value)] = value
    entries = bytes(data[start:end]) * times
    tail = struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, times, times, len(entries), start, 0)
    return bytes(data[:start]) + entries + tail


def encrypted(data: bytes) -> bytes:
    """A zip whose entries say that they are."""
    changed = bytearray(data)
    for mark, offset in ((b"PK\1\2", 8), (b"PK\3\4", 6)):
        changed[changed.find(mark) + offset] |= 1
    return bytes(changed)


def sparse(folder: Path) -> None:
    with (folder / FILE).open("wb") as file:
        file.truncate(200 * 2**20)


def linked(target: str | Path) -> Callable[[Path], object]:
    return lambda folder: (folder / FILE).symlink_to(target)


def with_file(make: Callable[[Path], object]) -> Callable[[Path], object]:
    """The honest notebook, and something else in its folder."""
    return lambda folder: ((folder / FILE).write_text(TEXT), make(folder))


ENTRY = (FILE.encode(), TEXT.encode())
BOMB = packed((FILE, bytes(49 * 2**20)))
HONEST_ZIP = packed((FILE, TEXT))
FOLDER = "work/" + FILE
ROOT_READS = hasattr(os, "geteuid") and os.geteuid() == 0
TEXTS = tuple((f"{at:04}.txt".encode(), b"x") for at in range(2001))
LIBRARIES = (
    *("numpy", "nao_course", "json", "sitecustomize", "IPython"),
    *("encodings", "conftest", "__init__", "__main__"),
)
FILES = (
    put("a_200_mb_notebook", {}, sparse, "larger than 50 MB"),
    put("a_folder", {}, lambda folder: (folder / FILE).mkdir(), "it is a folder"),
    put("a_link_to_passwd", {}, linked("/etc/passwd"), "symbolic link"),
    put("a_link_to_a_neighbour", {}, lambda folder: linked(next(folder.parent.rglob(FILE)))(folder), "symbolic link"),
    put("a_link_to_itself", {}, linked(FILE), "symbolic link"),
    put("a_link_that_is_hard", all_but(),
        lambda folder: os.link(next(folder.parent.glob(f"*-right/{FILE}")), folder / FILE)),
    put("a_pipe", {}, lambda folder: os.mkfifo(folder / FILE), "device or pipe"),
    put("unreadable", all_but() if ROOT_READS else {}, with_file(lambda folder: (folder / FILE).chmod(0)),
        "" if ROOT_READS else "cannot be read"),
    put("a_helper_that_is_a_link", all_but(), with_file(lambda folder: (folder / "mine.py").symlink_to("/etc/passwd")),
        "mine.py does not come along"),
    put("a_helper_that_is_a_pipe", all_but(), with_file(lambda folder: os.mkfifo(folder / "pipe.py"))),
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
    zipped("zip_behind_a_picture", raw_zip(ENTRY, before=b"\x89PNG\r\n" * 999)),
    zipped("zip_with_a_zips_end_in_its_comment", raw_zip(ENTRY, comment=b"PK\5\6"), "no zip"),
    zipped("zip_that_says_4_gb", raw_zip(ENTRY, size=0xFFFFFFF0), "50 MB are the most"),
    zipped("zip_with_names_that_play_tricks", raw_zip((b"\x1b[2J\n\xe2\x80\xae/" + ENTRY[0], ENTRY[1]))),
    zipped("zip_with_a_name_of_60000_bytes", raw_zip((b"d" * 60_000 + b"/" + ENTRY[0], ENTRY[1]))),
    zipped("zip_of_1900_files", raw_zip(ENTRY, *TEXTS[:1900])),
    zipped("zip_of_2001_files", raw_zip(ENTRY, *TEXTS), "more than 2000 files"),
    zipped("zip_of_entries_that_overlap", directory(12, b"", 500)),
    zipped("zip_of_a_notebook_of_20_mb", packed((FOLDER, TEXT.replace(
        '"outputs": []', f'"outputs": ["{random.Random(0).randbytes(10**7).hex()}"]', 1)))),
    named("two_notebooks_of_one_lesson", (f"{LESSON} (1).ipynb", BLANK_TEXT), (FILE, TEXT)),
    Attack("two_notebooks_and_the_later_is_blank", "broken", all_but(), files={f"{LESSON}-Copy1.ipynb": BLANK_TEXT}),
    named("name_of_255_bytes", (f"{LESSON}{' ' * (255 - len(LESSON) - 6)}.ipynb", TEXT)),
    named("name_with_upper_case", (f"{LESSON.upper()}.IPYNB", TEXT)),
    named("name_that_a_browser_and_a_person_made", (f"my {LESSON} final v2 (3)-Copy1.ipynb", TEXT)),
    named("helpers_named_as_libraries", (FILE, TEXT), *((f"{each}.py", "raise SystemExit") for each in LIBRARIES)),
    named("helper_that_imports_in_a_circle", (FILE, TEXT), ("one.py", "import two"), ("two.py", "import one")),
)  # fmt: skip

# What names no student and lesson, or is no notebook: by file name in the student's folder, with what is said of it.
IN_A_ZIP = "a zip within a zip is not opened"
UNKNOWN: Mapping[str, tuple[bytes, str]] = {
    f"{FILE}.txt": (TEXT.encode(), "it is no notebook"),
    "my_solution.ipynb": (TEXT.encode(), "named after no lesson"),
    "11_other_course.ipynb": (TEXT.encode(), "named after no lesson"),
    "nested.zip": (packed(("inner.zip", HONEST_ZIP)), IN_A_ZIP),
    "nested_bomb.zip": (packed(("inner.zip", packed(("inner.zip", BOMB)))), IN_A_ZIP),
    "corrupt.zip": (HONEST_ZIP[:-60], "it is no zip"),
    f"{LESSON}.docx": (b"PK\3\4", "it is no notebook"),
}

# Names of students in a learning platform's zip: all must get a row, a page and their points, and none another's.
NAMES = (
    *("Ada", "ada", "ADA", "Ada Lovelace", "Müller, Jürgen", "Mu\u0308ller", "李小龙", "🤖", "\u202eada"),
    *("[bold]ada[/bold]", "[/]", "100%", "=HYPERLINK(1)", "con", "nul.txt", "a" * 300, "a" * 299 + "b"),
    *("<script>nao_attack</script>", "ada\x1b[2Jnao_attack", "ada\nnao_attack", "a'; DROP TABLE results;"),
)

# --- notebooks that are odd in one place ---


def into(index: int, **changes: Any) -> Edit:
    """Change a code cell; 1 is that of `clamp`, and 2 its check."""
    return lambda made: made["cells"][index].update(changes)


def without(index: int, key: str) -> Edit:
    return lambda made: made["cells"][index].pop(key)


def adding(*cells: Any) -> Edit:
    return lambda made: made["cells"].extend(cells)


def of_notebook(**changes: Any) -> Edit:
    return lambda made: made.update(changes)


def outputs(*values: Any, count: int = 1) -> Edit:
    return into(2, outputs=[*values] * count)


def raw(content: Callable[[], str]) -> Callable[[str], str]:
    """Replace the first outputs with JSON text."""
    return lambda text: text.replace('"outputs": []', f'"outputs": [{content()}]', 1)


def markdown(source: str, **more: Any) -> dict[str, Any]:
    return {"cell_type": "markdown", "metadata": {}, "source": source} | more


def as_lists(made: dict[str, Any]) -> None:
    """Sources as Jupyter itself writes them."""
    for each in made["cells"]:
        each["source"] = each["source"].splitlines(keepends=True)


def padded(made: dict[str, Any]) -> None:
    """Add three megabytes of output to the first check."""
    made["cells"][2]["outputs"] = [PRINTED | {"text": MUCH}]


def deep(depth: int) -> Any:
    value: Any = []
    for _ in range(depth):
        value = [value]
    return value


def of_another(made: dict[str, Any]) -> None:
    """Every cell says that it is another exercise's."""
    names = [*RIGHT, "clamp"]
    for each in made["cells"]:
        grading = each["metadata"].get("nbgrader")
        if grading and grading["grade_id"] in RIGHT:
            grading["grade_id"] = names[names.index(grading["grade_id"]) + 1]


def renamed(made: dict[str, Any]) -> None:
    for at, each in enumerate(made["cells"]):
        if "nbgrader" in each["metadata"]:
            each["metadata"]["nbgrader"].update(grade_id=f"x{at}")


def split(made: dict[str, Any]) -> None:
    """Leave an import in the exercise's cell; the function follows in a cell of its own."""
    made["cells"][1]["source"] = "import math"
    made["cells"].insert(2, cell(CLAMP))


def merged(made: dict[str, Any]) -> None:
    """Put two exercises into one cell."""
    made["cells"][1]["source"] += "\n\n\n" + SCALED
    del made["cells"][3]


def saved_by(metadata: dict[str, Any], **of_cells: Any) -> Edit:
    """Add the metadata that another program writes."""

    def edit(made: dict[str, Any]) -> None:
        made["metadata"] |= metadata
        for each in made["cells"]:
            each["metadata"] |= of_cells

    return edit


def of_each(**changes: Any) -> Edit:
    return lambda made: [each.update(changes) for each in made["cells"]]


MUCH = "x" * (3 * 2**20)
PRINTED = {"output_type": "stream", "name": "stdout", "text": "x"}
WRITTEN = {"nbgrader": {"grade_id": "why", "grade": True, "solution": True, "points": 2}}
COMMANDS = "%cd /\n!rm -rf *\n%run /etc/passwd\n%load_ext nao\nget_ipython().system('id')\n%reset -f\nx = 1"
INTERRUPTED = {"output_type": "error", "ename": "KeyboardInterrupt", "evalue": "", "traceback": []}
HALF = {"lesson": "\ud800", "version": "\udfff"}
ODD_FILES = (
    readable("utf_8_bom", TEXT.encode("utf-8-sig")),
    readable("utf_32", TEXT.encode("utf-32")),
    readable("utf_16", TEXT.encode("utf-16")),
    readable("latin_1", TEXT.replace("return", "# é\\n    return").encode("latin-1")),
    readable("windows_lines", TEXT.replace("\n", "\r\n")),
    readable("keys_twice", TEXT.replace('"cells"', '"cells": [], "cells"', 1)),
    readable("constants_nan", TEXT.replace('"metadata": {', '"metadata": {"nan": NaN, "inf": -Infinity,')),
    readable("number_of_5000_digits", TEXT.replace('"nbformat_minor": 5', '"nbformat_minor": ' + "9" * 5000)),
    *(readable(f"metadata_{depth}_deep_in_a_cell", json.dumps(HONEST).replace(
        '"grade_id": "clamp"', '"grade_id": "clamp", "x": ' + "[" * depth + "]" * depth, 1), "large")
      for depth in (900, 930)),
    Attack("key_source_twice", "broken", all_but("clamp"), files={FILE: json.dumps(HONEST).replace(
        json.dumps(CLAMP), json.dumps(CLAMP) + ', "source": ' + json.dumps(BLANK["clamp"]))}),
)  # fmt: skip
ODD_NOTEBOOKS = (
    edited("no_format", lambda made: made.pop("nbformat")),
    edited("no_metadata", lambda made: made.pop("metadata")),
    edited("lists_of_lines", as_lists),
    edited("metadata_a_list", of_notebook(metadata=[])),
    edited("metadata_of_odd_types", of_notebook(metadata={"kernelspec": 7, "nao_course": "x", "language_info": []})),
    edited("metadata_800_deep", of_notebook(metadata=deep(800))),
    edited("cell_metadata_null", into(1, metadata=None)),
    edited("cell_metadata_of_odd_types", into(1, metadata={"nbgrader": [1], "nao_course": 5})),
    edited("cell_without_source", without(1, "source"), "clamp"),
    edited("cell_source_numbers", into(1, source=[1, None, {}]), "clamp"),
    edited("cell_without_type", without(1, "cell_type"), "clamp"),
    edited("cells_that_are_none", adding(None, 7, "text", [], {})),
    edited("cell_of_single_characters", into(1, source=list(CLAMP))),
    edited("cells_that_say_they_are_another_exercise", of_another),
    edited("half_a_character", into(1, source=CLAMP + "  # \ud800"), "clamp"),
    edited("half_a_character_in_words", adding(markdown("Because \ud83e.", metadata=WRITTEN))),
    edited("half_a_character_in_stamp", of_notebook(metadata={"nao_course": HALF})),
    edited("half_a_character_in_keys", of_notebook(**{"\ud800": {"\udfff": "\ud83d"}})),
    edited("null_character", into(1, source=CLAMP + "\0"), "clamp"),
    edited("form_feed_and_nel", into(1, source="\f\n# \x85 \u2028\n" + CLAMP)),
    edited("conflict_in_cell", into(1, source=CONFLICT.format(CLAMP, BLANK["clamp"])), "clamp", says="SyntaxError"),
    edited("cell_that_is_indented", into(1, source=textwrap.indent(CLAMP, "    "))),
    edited("cell_copied_with_its_prompts", into(1, source=">>> " + CLAMP.replace("\n", "\n... "))),
    edited("source_of_another_encoding", into(1, source="# -*- coding: rot13 -*-\n" + CLAMP)),
    edited("attachments_of_odd_types", adding(
        markdown("x", attachments={"a": 5, "b": {"image/png": 7}, "c": [], "d": deep(50)}))),
    edited("outputs_that_are_pages", outputs(
        {"output_type": "display_data", "data": {"text/html": "<script id=nao_attack>"}, "metadata": {}},
        {"output_type": "no such", "data": 5}, None)),
    edited("interrupted_output", into(1, outputs=[INTERRUPTED], execution_count=7)),
    edited("wrong_kernel_python_cells", of_notebook(metadata={"kernelspec": {"name": "ir", "language": "R"}})),
    edited("commands_of_every_kind", adding(cell(COMMANDS), *(
        cell(f"%%{name} file.txt\nx = 1") for name in ("writefile", "javascript", "bash", "html", "python2")))),
    edited("outputs_of_45_mb", outputs(PRINTED | {"text": "x" * 45 * 2**20}), row="large"),
    edited("line_of_10_mb", adding(cell("x = '" + "y" * 10 * 2**20 + "'")), row="large"),
    edited("blanks_of_1_mb", into(1, source=CLAMP + "\n%time 1\n" + " " * 2**20 + "#"), row="large"),
    edited("blank_lines_of_1_mb", into(1, source="%time 1\n" + "\n" * 2**20 + CLAMP), row="large"),
    edited("empty_cells_100_000", adding(*[cell("")] * 100_000), row="large"),
    edited("written_cells_10_000", adding(*[markdown("x" * 100, metadata=WRITTEN)] * 10_000), row="large"),
    edited("expression_too_deep", into(1, source=f"x = {'(' * 5000}{')' * 5000}\n" + CLAMP), "clamp", row="large"),
)  # fmt: skip

# --- notebooks of more than 2 MB, which a confined process reads first ---

FALSE_CELL = cell("def clamp(x, low, high):\n    return -1e6", "clamp")
PICTURE = {"output_type": "display_data", "data": {"image/png": "iVBORw0KGgo" * 10**6}, "metadata": {}}
# What costs a small notebook nothing, or costs it one exercise, does the same to a large one.
ALSO_LARGE = {
    *("no_metadata", "lists_of_lines", "metadata_a_list", "metadata_800_deep", "cell_metadata_of_odd_types"),
    *("cell_source_numbers", "cell_without_type", "cells_that_are_none", "half_a_character_in_words"),
    *("half_a_character_in_keys", "null_character", "attachments_of_odd_types", "empty_cells_100_000"),
}
REFUSED: dict[str, Callable[[str], str | bytes] | tuple[Callable[[str], str | bytes], str]] = {
    "truncated": lambda text: text[:-200],
    "truncated_in_an_output": lambda text: text[: 2 * 2**20 + 100_000],
    "two_documents": lambda text: text + text,
    "zeros_only": lambda _: bytes(3 * 2**20),
    "comments": lambda text: "// notes\n" + text,
    "line_ends_in_texts": raw(lambda: '"a\nb"'),
    "gzip": lambda text: gzip.compress(text.encode(), 0),
    "page_of_the_web": lambda _: "<!doctype html><title>nao_attack</title>" + MUCH,
    "list": lambda text: f"[{text}]",
    "nested_without_an_end": raw(lambda: "[" * 4_000_000),
    "nested_four_million_deep": raw(lambda: "[" * 2_000_000 + "]" * 2_000_000),
    "text_without_an_end": raw(lambda: '"' + "y" * 10**6),
    "format_3": lambda text: text.replace('"nbformat": 4', '"nbformat": 3'),
    "format_of_many_digits": lambda text: text.replace('"nbformat": 4', '"nbformat": 4' + "0" * 10**6),
    "format_infinite": lambda text: text.replace('"nbformat": 4', '"nbformat": Infinity'),
    "language_tricks": (lambda _: TRICKY.replace('"metadata"', f'"x": "{MUCH}", "metadata"', 1), "in Python, got"),
    "metadata_that_count_as_code": (lambda text: text.replace(
        '"version": "1"', f'"version": "{"1" * 13 * 2**20}"', 1), "its code and texts may have at most 12 MB"),
    "code_of_13_mb": (lambda text: text.replace(
        json.dumps(CLAMP), json.dumps(CLAMP + "\n#" + "x" * 13 * 2**20)), "may have at most 12 MB"),
    "blank": (lambda _: " \n" * 2_000_000, "it is empty"),
}  # fmt: skip
LARGE = (
    *(large(each.name, each.edit, honest=each.honest)
      for each in ODD_NOTEBOOKS if each.edit and each.name in ALSO_LARGE),
    *(large(name, text=each[0], honest={}, says=each[1]) if isinstance(each, tuple)
      else large(name, text=each, honest={}, says=FORMAT) for name, each in REFUSED.items()),
    large("zeros_at_the_end", text=lambda text: text + "\0" * 10**6),
    large("utf_8_bom", text=lambda text: text.encode("utf-8-sig")),
    large("old_mac_lines", text=lambda text: json.dumps(json.loads(text), indent=1).replace("\n", "\r")),
    large("constants", text=raw(lambda: "NaN, Infinity, -Infinity, -0, 1e999, 1E-999, -0.0")),
    large("outputs_twice", text=lambda text: text.replace('"outputs": []', '"outputs": [], "outputs": [1]')),
    large("outputs_by_escapes", text=lambda text: text.replace('"outputs"', '"outp\\u0075ts"')),
    large("source_by_escapes", text=lambda text: text.replace('"source"', '"\\u0073ource"')),
    large("number_of_a_million_digits", text=raw(lambda: "9" * 10**6)),
    large("outputs_40_mb_of_empty_lists", text=raw(lambda: ",".join(["[]"] * 13_000_000))),
    large("outputs_of_a_million_keys", outputs({f"k{n}": n for n in range(10**6)})),
    large("outputs_of_half_characters", text=raw(lambda: '"' + "\\ud83d" * 10**6 + '"')),
    large("outputs_500_deep", outputs(deep(500))),
    large("outputs_that_look_like_cells", outputs(FALSE_CELL, {"cells": [FALSE_CELL]})),
    large("outputs_that_are_none", into(2, outputs=None)),
    large("outputs_that_are_a_dict", into(2, outputs={"cells": [FALSE_CELL], "source": "x"})),
    large("outputs_of_pictures_of_33_mb", outputs(PICTURE, count=3)),
    large("metadata_of_a_cell_of_10_mb", into(1, metadata=HONEST["cells"][1]["metadata"] | {"x": "y" * 10**7})),
    large("blanks_of_20_mb", text=lambda text: text.replace('"cells":', '"cells":' + " \n" * 10**7, 1)),
    large("source_that_speaks_of_outputs", into(1, source=CLAMP + '\nx = \'"outputs": [], "source": ""\'')),
    large("source_of_single_characters", into(1, source=list(CLAMP + "\n# " + "x" * 10**6))),
    large("outputs_in_words", adding(markdown("x", outputs=[MUCH], execution_count=1))),
    large("cell_of_a_cell", into(2, cells=[FALSE_CELL], outputs=[MUCH])),
    large("last_source_counts", text=lambda text: text.replace(
        json.dumps(CLAMP), json.dumps(CLAMP) + ', "source": ' + json.dumps(BLANK["clamp"])), honest=all_but("clamp")),
    large("clamp_in_an_output_only", into(1, source="", outputs=[CLAMP]), honest=all_but("clamp")),
    large("syntax_error", into(1, source="def clamp("), honest=all_but("clamp"), says="SyntaxError"),
    named("large_and_an_older_blank_one", (f"{LESSON} (1).ipynb", BLANK_TEXT), (FILE, raw(lambda: f'"{MUCH}"')(TEXT))),
    named("older_one_large_and_blank", (f"{LESSON} (1).ipynb", raw(lambda: f'"{MUCH}"')(BLANK_TEXT)), (FILE, TEXT)),
)  # fmt: skip

# --- exercises written in every way ---

LIMIT = "def limit(x, low, high):\n    return max(low, min(high, x))"
STYLES = (
    style("twice", f"{BLANK['clamp']}\n\n{CLAMP}"),
    Attack("twice_in_two_cells", "styles", all_but(), functions={"clamp": BLANK["clamp"]}, after=CLAMP),
    Attack("twice_and_the_last_is_blank", "styles", all_but(), after=BLANK["clamp"]),
    style("defined_and_deleted_and_defined", f"{BLANK['clamp']}\n\ndel clamp\n\n{CLAMP}"),
    style("lambda", "clamp = lambda x, low, high: max(low, min(high, x))"),
    style("library_function", "clamp = np.clip"),
    style("callable_object", "class Clamp:\n    def __call__(self, x, low, high):\n"
          "        return max(low, min(high, x))\nclamp = Clamp()"),
    style("method_of_a_class", "class Limits:\n    @classmethod\n    def clamp(cls, x, low, high):\n"
          "        return max(low, min(high, x))\n\nclamp = Limits.clamp"),
    style("class_that_makes_a_number", "class clamp:\n    def __new__(cls, x, low, high):\n"
          "        return max(low, min(high, x))"),
    style("partial", "from functools import partial\ndef limit(strict, x, low, high):\n"
          "    return max(low, min(high, x))\nclamp = partial(limit, True)"),
    style("decorated", "import functools\ndef told(function):\n    @functools.wraps(function)\n    def inner(*args):\n"
          f"        print(args)\n        return function(*args)\n    return inner\n\n@told\n{SCALED}", "scaled"),
    style("made_by_exec", f"exec({CLAMP!r})"),
    style("put_among_the_globals", "globals()['clamp'] = lambda x, low, high: max(low, min(high, x))"),
    style("recursion_800_deep", "def deep(n):\n    return 0 if n == 0 else 1 + deep(n - 1)\n\n"
          "def clamp(x, low, high):\n    deep(800)\n    return max(low, min(high, x))"),
    style("annotations", "from __future__ import annotations\nimport numpy.typing as npt\n"
          "Vector: TypeAlias = 'npt.NDArray[np.float64]'\n\n"
          + SCALED.replace("values)", "values: Vector | Unknown) -> Vector", 1), "scaled"),
    style("type_parameters", "def clamp[T: float](x: T, low: T, high: T) -> T:\n    return max(low, min(high, x))",
          honest=all_but(*(["clamp"] if sys.version_info < (3, 12) else []))),
    style("constants", "EPS = 0.0\nA, (B, *C) = 1, (2, 3)\nN: int = 4\nN += 1\n\ndef scaled(values):\n"
          "    return (values - values.min()) / (np.ptp(values) + EPS) * (N - 4)", "scaled"),
    style("table_filled_by_append", "TABLE = []\nTABLE.append(1.0)\nNAMES = {}\nNAMES.update(one=TABLE[0])\n"
          "def clamp(x, low, high):\n    return max(low, min(high, x)) * NAMES['one']"),
    # After these imports, `max` is NumPy's, which does not compare two numbers.
    style("star_imports", "from math import *\nfrom numpy import *\n\ndef scaled(values):\n"
          "    return (values - amin(values)) / ptp(values)", "scaled", honest=all_but("clamp"), says="TypeError"),
    style("try_import", f"try:\n    import no_such_module\nexcept ImportError:\n    no_such_module = None\n\n{CLAMP}"),
    style("defined_if", f"if True:\n{textwrap.indent(CLAMP, '    ')}\nelse:\n    clamp = None"),
    style("tabs", CLAMP.replace("    ", "\t")),
    style("old_mac_line_ends", CLAMP.replace("\n", "\r")),
    style("windows_line_ends_in_a_cell", CLAMP.replace("\n", "\r\n")),
    style("no_break_spaces", CLAMP.replace("    ", "\u00a0" * 4), honest=all_but("clamp")),
    style("mark_of_bytes_in_a_cell", "\ufeff" + CLAMP, honest=all_but("clamp")),
    style("main_guard", f"{CLAMP}\n\nif __name__ == '__main__':\n    print(clamp(1, 2, 3))\n    raise SystemExit"),
    Attack("helper_in_a_later_cell", "styles", all_but(),
           {"clamp": "def clamp(x, low, high):\n    return limit(x, low, high)"}, after=LIMIT),
    Attack("helper_file_that_imports_another", "styles", all_but(), {"clamp": "from first import clamp"},
           files={"first.py": "from second import *\nimport numpy as np\n", "second.py": CLAMP}),
    Attack("helper_file_that_is_missing", "styles", all_but("clamp"),
           {"clamp": "def clamp(x, low, high):\n    return mine.limit(x, low, high)"}, before="import mine",
           says="No module named 'mine'"),
    Attack("helper_file_with_an_error", "styles", all_but(), before="import mine", files={"mine.py": "def f(:"},
           says="SyntaxError"),
    Attack("all_in_one_cell_before", "styles", all_but(), dict.fromkeys(RIGHT, ""), before="\n\n".join(RIGHT.values())),
    Attack("all_in_one_cell_after", "styles", all_but(), dict.fromkeys(RIGHT, ""), after="\n\n".join(RIGHT.values())),
    edited("exercise_cells_renamed", renamed, row="styles"),
    edited("check_cells_deleted", lambda made: made.update(
        cells=[each for each in made["cells"] if not each["source"].startswith("check")]), row="styles"),
    edited("check_cells_with_other_code", into(2, source="check('clamp', print)\nclamp = None"), row="styles"),
    edited("setup_cell_deleted", lambda made: made["cells"].pop(0), row="styles"),
    edited("all_metadata_lost", of_each(metadata={}), row="styles"),
    edited("ids_that_are_one", of_each(id="same"), row="styles"),
    edited("cell_split", split, row="styles"),
    edited("cells_merged", merged, row="styles"),
    edited("notebook_twice_in_itself", lambda made: made["cells"].extend(copy.copy(made["cells"])), row="styles"),
    edited("cells_of_another_lesson", adding(cell("def rgb_to_hsl(x):\n    return x", "rgb_to_hsl")), row="styles"),
    edited("exercise_as_words", into(1, cell_type="markdown"), "clamp", row="styles"),
    edited("words_with_a_function", adding(markdown(f"```python\n{BLANK['clamp']}\n```")), row="styles"),
    edited("copy_of_another_release", of_notebook(metadata={"nao_course": {"lesson": LESSON, "version": "0.9"}}),
           row="styles", says="made from release '0.9'"),
    edited("saved_by_colab", saved_by({"colab": {"provenance": []}, "accelerator": "TPU"}, id="aBcD", outputId="x",
           colab={"base_uri": "https://localhost:8080/", "height": 35}, cellView="form"), row="styles"),
    edited("saved_by_jupyterlab", saved_by({"toc-showtags": True, "widgets": {}}, tags=["hide-input"], trusted=True,
           collapsed=True, jupyter={"source_hidden": True, "outputs_hidden": True}, scrolled="auto"), row="styles"),
    style("syntax_error", "def clamp(x, low, high)\n    return x", honest=all_but("clamp"), says="SyntaxError"),
    style("indentation_error", "def scaled(values):\nreturn values", "scaled", honest=all_but("scaled", middle=4.0),
          says="IndentationError"),
    style("wrong_name", CLAMP.replace("clamp", "Clamp"), honest=all_but("clamp")),
    style("deleted", "", honest=all_but("clamp")),
    style("too_few_arguments", "def clamp(x):\n    return x", honest=all_but("clamp"), says="TypeError"),
    style("coroutine", f"async {CLAMP}", honest=all_but("clamp")),
    style("generator_answer", "def scaled(values):\n    yield from (values - values.min()) / np.ptp(values)", "scaled",
          honest=all_but("scaled", middle=4.0)),
    style("forgotten_return", "def clamp(x, low, high):\n    y = max(low, min(high, x))\n    print(y)",
          honest=all_but("clamp"), says="return"),
    style("variable_of_a_display_cell", CLAMP + " * FACTOR", honest=all_but("clamp"),
          edit=adding(cell("FACTOR = 1", role="display")), says="name 'FACTOR' is not defined"),
)  # fmt: skip
if importlib.util.find_spec("numba"):
    STYLES += (style("numba", f"from numba import njit\n\n@njit\n{SCALED}", "scaled"),)

# --- honest work that prints, warns, is slow, or answers in another type ---

NUMBERS = {
    "zero_dimensional": "np.array(y)",
    "numpy_number": "np.float64(y)",
    "float32_number": "np.float32(y)",
    "whole_numbers_of_python": "int(y) if y == int(y) else y",
}
ARRAYS = {
    "float32": "made.astype(np.float32)",
    "longdouble": "made.astype(np.longdouble)",
    "lists": "made.tolist()",
    "list_of_arrays": "list(made)",
    "numpy_numbers_in_lists": "[[np.float64(x) for x in row] for row in made]",
    "turned_and_big_endian": "np.asfortranarray(made[::-1]).astype('>f8')[::-1]",
    "read_only": "(made.setflags(write=False), made)[1]",
    "memory_map": "(m := np.memmap('scratch.bin', float, 'w+', shape=made.shape), m.__setitem__(..., made))[0]",
    "masked_array": "np.ma.masked_array(made)",
    "record_array_view": "made.view(np.recarray)",
    "subclass": "made.view(type('Mine', (np.ndarray,), {}))",
}
BESIDE = {
    "warns": """
        np.log(np.array([0.0, -1.0]))
        import warnings
        warnings.warn('old', DeprecationWarning)""",
    "prints_50_mb": "for _ in range(50): print('y' * 2**20, end='\\r')",
    "prints_odd_characters": "print('\\x1b[31m', '\\0', chr(0xd800), '<b>nao_attack</b>')",
    "slow": "import time\ntime.sleep(0.4)",
    "takes_500_mb": "np.ones(500 * 2**17)",
    "warnings_and_errors_raised": "np.seterr(all='raise')\nimport warnings\nwarnings.simplefilter('error')",
    "working_folder": "import os, tempfile\nos.chdir(tempfile.mkdtemp())",
    "own_file": "with open('notes.txt', 'a') as file: file.write('x')\nopen('notes.txt').read()",
    "threads": """
        from concurrent.futures import ThreadPoolExecutor
        with ThreadPoolExecutor(4) as pool: x = list(pool.map(lambda v: v, [x]))[0]""",
    "counts_its_calls": "clamp.calls = getattr(clamp, 'calls', 0) + 1",
    "displays": "from IPython.display import clear_output, display\nclear_output(wait=True)\ndisplay(x)",
}
TOP = {
    "asks_at_the_top": "name = input('Your name?')",
    "magics": "%matplotlib inline\n%timeit sum([1])\n!ls\n?help\nnp.sum?\nfiles = !ls\nx = %sql 1\n%%time\ny = 2",
    "cell_magic": "%%bash\nfor i in 1 2; do echo $i; done",
    "installs_a_library": "!pip install -q tqdm\n%pip install rich\nimport sys\n!{sys.executable} -m pip list",
    "raises": "raise ValueError('stop here')",
    "exits_in_if": "if 1:\n    import os\n    os._exit(0)",
    "endless_while": "while True:\n    pass",
    "shadows_builtins": "list = [1, 2]\nstr = 'x'\nint = 5\nlen = 3",
    "shadows_numpy": "numpy = None\nnp_ = 5\nfrom types import SimpleNamespace\njson = struct = SimpleNamespace()",
    "thousand_functions": "\n".join(f"def f{i}(): return {i}" for i in range(1000)),
    "thousand_statements": "\n".join(f"x{i} = {i}" for i in range(3000)),
}
NO_PROGRAMS = {
    "processes": """
        import multiprocessing as mp
        with mp.get_context('fork').Pool(2) as pool: x = pool.map(abs, [-abs(x)])[0] * (1 if x > 0 else -1)""",
    "program": """
        import subprocess, sys
        done = subprocess.run([sys.executable, '-c', f'print({x!r})'], capture_output=True, text=True, check=True)
        x = float(done.stdout)""",
}
HONEST_WORK = (
    *(answer(name, each) for name, each in ARRAYS.items()),
    # The median of a masked array leaves out masked values, and the median of a matrix is a matrix.
    answer("masked_array_with_a_mask", "np.ma.masked_greater(made, 0.9)", lost="middle"),
    answer("matrix", "np.asmatrix(made)", lost="middle"),
    *(style(name, f"{CLAMP.replace('return', 'y =')}\n    return {each}", row="honest")
      for name, each in NUMBERS.items()),
    *(beside(name, each) for name, each in BESIDE.items()),
    *(beside(name, each, "clamp", says="FileNotFoundError") for name, each in NO_PROGRAMS.items()),
    *(top(name, each) for name, each in TOP.items()),
    top("data_file_that_is_not_there", "import numpy as np\ndata = np.load('../data/own.npy')", "FileNotFoundError"),
    edited("endless_display_cell", adding(cell("for i in iter(int, 1): pass", role="display")), row="honest"),
    style("changes_its_input", "def scaled(values):\n    values -= values.min()\n    values /= np.ptp(values)\n"
          "    return values", "scaled", row="honest", honest=all_but("scaled", middle=4.0), says="changes its input"),
    style("ignores_rng", "def drawn(rng, n):\n    return np.random.normal(size=n).cumsum()", "drawn", row="honest",
          honest=all_but("drawn")),
    style("asks", "def clamp(x, low, high):\n    return float(input('x?'))", row="honest", honest=all_but("clamp"),
          says="It waits for a person"),
    style("magic_with_a_function", f"!pip install numpy\n{CLAMP}\n\nclamp?\n%time clamp(1, 2, 3)", row="honest"),
    style("cell_magic_with_a_function", f"%%time\n{CLAMP}", row="honest"),
    style("capture_above_a_function", f"%%capture out\n{CLAMP}", row="honest"),
    style("asserts_after_a_function", f"{CLAMP}\n\nassert clamp(1, 2, 3) == 5\nclamp('a')\n1 / 0", row="honest"),
)  # fmt: skip

ATTACKS = (*NO_NOTEBOOKS, *FILES, *ODD_FILES, *ODD_NOTEBOOKS, *LARGE, *STYLES, *HONEST_WORK)
