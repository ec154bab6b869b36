"""What Python 3.14 makes of students' code and of the codec, printed as JSON for test_python_3_14.py."""

import json
import sys
from pathlib import Path

from tests.versions import stand_ins

CELLS = {
    "constants": "type Point = tuple[float, float]\nsize: int = 3\nname = 'nao'\nwords = 'a', 'b'",
    "late": "def late(x: NotThereYet) -> Neither: return x",
    "first": "def first[T](values: list[T]) -> T: return values[0]",
    "guarded": "def guarded(text):\n  try: return int(text)\n  except ValueError, TypeError: return size",
    "template": "def template(): return t'I am {name}'.interpolations[0].value",
    "nested": "def nested(): return f'{', '.join(words)} {f'{size}'}'",
    "boxes": "class Box[T]:\n    value: T\n    other: NotThere = None",
    "broken": "def broken(: pass",
}
CALLS = {"late": [1], "first": [[5]], "guarded": ["x"], "template": [], "nested": []}


def load(version):
    """Return names, results and reasons of a notebook that states a version of Python."""
    from nao_course.exercises import load_definitions

    cells = [
        {
            "cell_type": "code",
            "id": key,
            "metadata": {},
            "execution_count": None,
            "outputs": [],
            "source": source,
        }
        for key, source in CELLS.items()
    ]
    metadata = {"language_info": {"name": "python", "version": version}}
    path = Path("/tmp/own.ipynb")
    path.write_text(json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": metadata, "cells": cells}))
    found = load_definitions(path)
    results = {name: found[name](*values) for name, values in CALLS.items() if name in found}
    return {"names": sorted(found), "results": results, "skipped": [each.reason for each in found.skipped]}


def codec_works():
    """Return whether plain values are the same after they have been sent."""
    from nao_course.codec import decode, encode

    values = {"a": [1, 2.5, True, None, "é"], "b": 10**30}, {(1, "x"): (1, (2,)), 3: 1 + 2j, "c": b"\0\1"}
    return all(decode(encode(value)) == value for value in values)


if __name__ == "__main__":
    stand_ins.install()
    loaded = {version: load(version) for version in ("3.14.2", "3.13.1", "")}
    print(json.dumps({"python": sys.version_info[:2], "codec": codec_works(), "loaded": loaded}))
