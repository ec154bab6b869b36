"""Folders and zips of submissions, and what was found in them."""

import json
import sys
import zipfile
from pathlib import Path

import pytest

LESSONS = ["00_meet_the_nao", "01_hsl_filtering", "02_goal_posts"]
HSL = "01_hsl_filtering.ipynb"
NOTEBOOK = b'{"cells": [], "metadata": {}, "nbformat": 4, "nbformat_minor": 5}'


def answered(answers: int) -> bytes:
    """Return a notebook with this many exercises that are answered; with 0 it has one that is not."""
    bodies = [f"def f{number}():\n    return {number}" for number in range(answers)]
    bodies = bodies or ["def f():\n    raise NotImplementedError"]
    cells = [
        {
            "cell_type": "code",
            "metadata": {"nbgrader": {"grade_id": f"f{number}", "solution": True}},
            "source": body,
            "outputs": [],
            "execution_count": None,
        }
        for number, body in enumerate(bodies)
    ]
    return json.dumps({"cells": cells, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}).encode()


posix = pytest.mark.skipif(sys.platform == "win32", reason="links, pipes and modes of POSIX")


def put(root: Path, *names: str, content: bytes = NOTEBOOK) -> Path:
    for name in names:
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    return root


def packed(path: Path, files: dict[str, bytes], **options) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            entry = zipfile.ZipInfo(name, options.get("date", (2026, 3, 1, 12, 0, 0)))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = options.get("mode", 0o100644) << 16
            archive.writestr(entry, content)
    return path


def who(found):
    return [(each.student, each.lesson) for each in found.submissions]


def reasons(found):
    return {(each.student, each.lesson): each.reason for each in found.refused}
