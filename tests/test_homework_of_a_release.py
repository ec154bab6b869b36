"""What a student works in: no work is lost to a newer release, and a receipt says what was handed in."""

import hashlib
import json
import shutil
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


def test_laying_out_again_changes_nothing(unpacked):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"
    edit(mine, lambda cells: cells.pop(-1))
    before = mine.read_bytes()
    assert homework.renew(unpacked) == []
    assert mine.read_bytes() == before


def test_an_untouched_notebook_is_replaced_even_when_it_was_run(unpacked, files):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"

    def ran(cells):
        cell = cell_with(cells, "def hue_mask")
        cell.execution_count, cell.outputs = 7, [nbformat.v4.new_output("stream", text="x")]

    edit(mine, ran)
    unpack(newer(files), unpacked)
    assert [str(each) for each in homework.renew(unpacked)] == ["01_hsl_filtering.ipynb: as released"]
    assert mine.read_bytes() == newer(files)[NOTEBOOK]
    assert not (unpacked / "notebooks" / "kept").exists()


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


def test_work_survives_a_second_renewal_and_a_missing_memory_of_what_was_given(unpacked, files):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"
    answer = "def hue_mask(hue, low, high):\n    return hue > low"

    def work(cells):
        cell_with(cells, "def hue_mask").source = answer

    edit(mine, work)
    for release_files in (newer(files), files):
        unpack(release_files, unpacked)
        (renewal,) = homework.renew(unpacked)
        assert renewal.carried == 1
    shutil.rmtree(unpacked / "notebooks" / ".given")
    (renewal,) = [each for each in homework.renew(unpacked) if each.kept]
    assert answer in [cell.source for cell in nbformat.read(mine, as_version=4).cells]
    assert len(list((unpacked / "notebooks" / "kept").iterdir())) == 3


def test_a_broken_notebook_is_kept_and_a_new_one_stands_in_its_place(unpacked, files):
    mine = unpacked / "notebooks" / "01_hsl_filtering.ipynb"
    mine.write_text("{ half of it")
    unpack(newer(files), unpacked)
    (renewal,) = homework.renew(unpacked)
    assert (unpacked / renewal.kept).read_text() == "{ half of it"
    nbformat.validate(nbformat.read(mine, as_version=4))


# --- handing in ---


def test_a_submission_holds_the_notebooks_helpers_and_a_receipt(unpacked, tmp_path):
    folder = unpacked / "notebooks"
    (folder / "my_helpers.py").write_text("x = 1\n")
    (folder / "notes.ipynb").write_text("not of the course")
    receipt = homework.submit(folder, tmp_path / "out")
    with zipfile.ZipFile(receipt.path) as archive:
        names = set(archive.namelist())
        kept = json.loads(archive.read("receipt.json"))
        content = archive.read("my_helpers.py")
    assert names == {"00_meet_the_nao.ipynb", "01_hsl_filtering.ipynb", "my_helpers.py", "receipt.json"} | {
        f"{name}.ipynb" for name in COURSE.names()
    }
    assert kept["files"]["my_helpers.py"] == hashlib.sha256(content).hexdigest()
    assert kept["versions"]["release"] == COURSE.version
    told = {key: kept[key] for key in ("time", "files", "versions")}
    assert (
        kept["code"] == receipt.code == hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()
    )


def test_what_cannot_be_handed_in_is_said(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match=r"contains no notebook of a lesson, such as 01_hsl_filtering.ipynb"):
        homework.submit(tmp_path, tmp_path)
    (tmp_path / "01_hsl_filtering.ipynb").write_text("{}")
    with pytest.raises(ValueError, match="01_hsl_filtering.ipynb is not a notebook"):
        homework.submit(tmp_path, tmp_path)
    shutil.copy(PROJECT / "notebooks" / "01_hsl_filtering.ipynb", tmp_path)
    monkeypatch.setattr(homework, "MOST_BYTES", 1000)
    with pytest.raises(ValueError, match="Clear Outputs of All Cells"):
        homework.submit(tmp_path, tmp_path)


def test_a_release_that_all_students_share_can_be_elsewhere(unpacked, tmp_path_factory):
    """On a JupyterHub, each student's folder has no release of its own."""
    home = tmp_path_factory.mktemp("home")
    given = [str(each) for each in homework.renew(home, unpacked / "release")]
    assert given == [f"{name}.ipynb: as released" for name in COURSE.names()]
    assert (home / "notebooks" / "images").is_dir() and not (home / "release").exists()
    assert homework.renew(home, unpacked / "release") == []
