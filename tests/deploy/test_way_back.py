"""A student's work comes along to a newer release on the hub, and back."""

import json

import pytest

from nao_course.homework import renew

LESSON = "01_toy.ipynb"
BLANK = "def double(value):\n    raise NotImplementedError"


def notebook(version, words, answer):
    solution = {"nbgrader": {"grade_id": "double", "solution": True, "grade": False, "locked": False}}
    cells = [
        {"cell_type": "markdown", "id": "words", "metadata": {"editable": False}, "source": words},
        {"cell_type": "code", "id": "double", "metadata": solution, "source": answer, "outputs": []},
    ]
    for cell in cells[1:]:
        cell["execution_count"] = None
    metadata = {"nao_course": {"lesson": "01_toy", "version": version}}
    return json.dumps({"cells": cells, "metadata": metadata, "nbformat": 4, "nbformat_minor": 5})


@pytest.fixture
def releases(tmp_path):
    """Return the folders of two releases, the first of which a student has."""
    folders = [tmp_path / version for version in ("0.1.0", "0.1.1")]
    for folder in folders:
        (folder / "notebooks").mkdir(parents=True)
        (folder / "notebooks" / LESSON).write_text(notebook(folder.name, f"Words of {folder.name}.", BLANK))
    return folders


def test_the_answers_come_along_to_a_newer_release_and_back_to_the_one_before(releases, tmp_path):
    old, new = releases
    home = tmp_path / "home"
    home.mkdir()
    renew(home, old)
    mine = home / "notebooks" / LESSON
    answer = BLANK.replace("raise NotImplementedError", "return 2 * value")
    mine.write_text(notebook("0.1.0", "Words of 0.1.0.", answer))
    for release in (new, old):
        renew(home, release)
        words, double = json.loads(mine.read_text())["cells"]
        assert "".join(words["source"]) == f"Words of {release.name}."
        assert "".join(double["source"]) == answer
    assert len(list((home / "notebooks" / "kept").glob("*.ipynb"))) == 2
