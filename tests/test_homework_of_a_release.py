"""What a student works in: no work is lost to a newer release, and a receipt says what was handed in."""

import json
import zipfile

import nbformat
import pytest

from nao_course import homework
from nao_course.instructor.authoring import release
from nao_course.instructor.authoring.course import load_course
from tests.paths import PROJECT

COURSE = load_course(PROJECT)
NOTEBOOK = "release/notebooks/01_hsl_filtering.ipynb"


@pytest.fixture(scope="module")
def files():
    return release.contents(COURSE, COURSE.names())


@pytest.fixture
def unpacked(files, tmp_path):
    """A student's folder, in which the release was unpacked and the lessons were laid out once."""
    unpack(files, tmp_path)
    assert [str(each) for each in homework.renew(tmp_path)] == [
        f"{name}.ipynb: as released" for name in COURSE.names()
    ]
    return tmp_path


def unpack(files, folder):
    for name, content in files.items():
        if name.startswith("release/"):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)


def edit(path, change):
    notebook = nbformat.read(path, as_version=4)
    change(notebook.cells)
    nbformat.write(notebook, path)


def cell_with(cells, text):
    return next(cell for cell in cells if text in cell.source)


def newer(files):
    """A release in which lesson 01 has another first line, one more cell, and another text before exercise 1.2."""
    notebook = nbformat.reads(files[NOTEBOOK].decode(), as_version=4)
    notebook.cells[0].source += "\n\nNew in this release."
    notebook.cells.insert(2, nbformat.v4.new_markdown_cell("A new cell.", id="lesson01-999"))
    cell_with(notebook.cells, "def hue_mask").source += "\n    # a better stub"
    return {**files, NOTEBOOK: nbformat.writes(notebook).encode()}


def test_a_newer_release_keeps_a_students_work(unpacked, files):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"

    def work(cells):
        cell_with(cells, "def hue_mask").source = "def hue_mask(hue, low, high):\n    return hue > low"
        cell_with(cells, "**Predict:**").source += "\n\nI say 7 %."
        cells[0].source += "\n\nmy note"  # where the release has a new text, too
        place = cells.index(cell_with(cells, 'check("hue_mask"'))
        cells.insert(place + 1, nbformat.v4.new_code_cell('hint("hue_mask")'))
        cells.remove(cell_with(cells, "## References"))
        cell_with(cells, 'check("rgb_to_hsl"').source = "passed = True"

    edit(mine, work)
    as_it_was = mine.read_bytes()
    unpack(newer(files), unpacked)
    (renewal,) = homework.renew(unpacked)
    assert renewal.carried == 3
    assert renewal.lost == ("# HSL filtering",)
    assert (unpacked / renewal.kept).read_bytes() == as_it_was
    notebook = nbformat.read(mine, as_version=4)
    nbformat.validate(notebook)
    sources = [cell.source for cell in notebook.cells]
    assert "def hue_mask(hue, low, high):\n    return hue > low" in sources
    assert any(source.endswith("I say 7 %.") for source in sources)
    assert sources[sources.index('check("hue_mask", hue_mask)') + 1] == 'hint("hue_mask")'
    assert sources[0].endswith("New in this release.") and "A new cell." in sources
    assert 'check("rgb_to_hsl", rgb_to_hsl)' in sources and "passed = True" not in sources
    assert homework.renew(unpacked) == []


def test_a_submission_holds_the_lessons_notebooks_and_the_releases_version(unpacked, tmp_path):
    folder = unpacked / "notebooks"
    (folder / "notes.ipynb").write_text("not of the course")
    with zipfile.ZipFile(homework.submit(folder, tmp_path / "out").path) as archive:
        names, kept = set(archive.namelist()), json.loads(archive.read("receipt.json"))
    assert names == {"receipt.json"} | {f"{name}.ipynb" for name in COURSE.names()}
    assert kept["versions"]["release"] == COURSE.version


def test_a_release_that_all_students_share_can_be_elsewhere(unpacked, tmp_path_factory):
    """On a JupyterHub, each student's folder has no release of its own."""
    home = tmp_path_factory.mktemp("home")
    given = [str(each) for each in homework.renew(home, unpacked / "release")]
    assert given == [f"{name}.ipynb: as released" for name in COURSE.names()]
    assert (home / "notebooks" / "images").is_dir() and not (home / "release").exists()
    assert homework.renew(home, unpacked / "release") == []
