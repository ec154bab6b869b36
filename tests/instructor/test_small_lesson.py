"""From declaration to grade: a small lesson with an earlier function, a class and a matrix."""

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile

import nbformat
import pytest

from nao_course.instructor.gradebook.journal import Journal
from tests.toy import small

pytestmark = pytest.mark.slow
NAMES = ("green_by_row", "Odometer", "length_of_way", "smoothing")


def run(root, *words):
    """Run a command with the library of a folder; what it printed, which must have come well."""
    environment = {**os.environ, "PYTHONPATH": str(root), "COLUMNS": "200"}
    command = [sys.executable, "-m", "nao_course.cli", *map(str, words)]
    done = subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    root = small.lay_out(tmp_path_factory.mktemp("small"))
    run(root, "build")
    return root


def handed_in(root, folder, lesson, **cells):
    """The solution as a student's notebook, some exercises written otherwise."""
    notebook = nbformat.read(root / "solutions" / f"{lesson}.ipynb", as_version=4)
    for cell in notebook.cells:
        name = cell.metadata.get("nbgrader", {}).get("grade_id")
        if name in cells:
            cell.source = cells[name]
    folder.mkdir(parents=True, exist_ok=True)
    nbformat.write(notebook, folder / f"{lesson}.ipynb")


WRONG_LABELS = "def color_labels(picture):\n    return np.zeros(picture.shape[:2], np.uint8)"
STANDS = "class Odometer:\n    def __init__(self, start): self.at = start\n    def move(self, motion): pass\n"
STANDS += "    def pose(self): return self.at"
TWICE_ROUND = "def smoothing(size):\n    i = np.arange(size)\n    return np.exp((i[None] - i[:, None]) / 5)"


def test_the_solution_earns_all_and_what_an_own_mistake_costs_is_that_exercise_alone(built, tmp_path):
    handed = tmp_path / "in"
    handed_in(built, handed / "ada", small.COLOURS)
    wrong = {"cleo": {"Odometer": STANDS}, "dan": {"smoothing": TWICE_ROUND}}
    for student in ("ada", "bob", "cleo", "dan"):
        handed_in(built, handed / student, small.SMALL, **wrong.get(student, {}))
    handed_in(built, handed / "bob", small.COLOURS, color_labels=WRONG_LABELS)
    (handed / "eve").mkdir()
    shutil.copy(built / "notebooks" / f"{small.SMALL}.ipynb", handed / "eve")
    run(built, "grade", handed, "--out", tmp_path / "grades", "--lesson", "04", "--jobs", "1")
    with Journal(tmp_path / "grades", make=False) as journal:
        results = {each.student: each.exercises for each in journal.results(small.SMALL)}
    right = {who: tuple(e.name for e in made if e.earned == e.points) for who, made in results.items()}
    again = {who: {e.name for e in made if e.with_reference} for who, made in results.items()}
    assert right["ada"] == right["bob"] == NAMES  # bob's own labels of lesson 01 are wrong: ours were used
    assert right["cleo"] == tuple(name for name in NAMES if name != "Odometer")
    assert right["dan"] == NAMES[:-1] and right["eve"] == ()
    assert again["ada"] == set() and again["bob"] == {"green_by_row"}
    assert again["cleo"] == {"green_by_row", "length_of_way"}  # cleo handed in no lesson 01


def test_its_hidden_cases_catch_what_is_changed_in_its_solution(built):
    said = run(built, "mutate", "04")
    shares = {name: int(re.search(rf"{name} .*?\((\d+)%\).*?\(\d+%\)", said)[1]) for name in (*NAMES, "all")}
    assert min(shares.values()) >= 80 and shares["all"] >= 90, said


def test_a_student_checks_it_with_an_earlier_lesson_that_is_right_wrong_or_missing(built, tmp_path):
    run(built, "release", "--out", tmp_path / "dist")
    (archive,) = (tmp_path / "dist").glob("*.zip")
    zipfile.ZipFile(archive).extractall(tmp_path)
    (root,) = (each for each in tmp_path.iterdir() if (each / "nao_course").is_dir())
    assert not list(root.rglob("instructor")) and (root / "nao_course" / "lessons" / "small").is_dir()
    handed_in(built, root / "notebooks", small.SMALL)
    for labels, said in ((None, "not usable yet"), (WRONG_LABELS, "not usable yet"), ("", "")):
        if labels is not None:
            handed_in(
                built, root / "notebooks", small.COLOURS, **({"color_labels": labels} if labels else {})
            )
        told = run(root, "check", "04")
        assert told.count("✔") >= len(NAMES), told
        assert (said in told) if said else "not usable" not in told
    run(root, "submit")


def test_its_check_data_are_small_though_a_matrix_of_60_by_60_is_in_them(built):
    data = built / "nao_course" / "exercises" / "checks" / f"{small.SMALL}.bin"
    assert data.stat().st_size < 200_000
    notebook = json.loads((built / "notebooks" / f"{small.SMALL}.ipynb").read_text())
    assert "np.exp" not in json.dumps(notebook)
