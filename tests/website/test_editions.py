"""What each edition holds: a student's has no page of an instructor's, and no page links out of its edition."""

import json
import re
from types import SimpleNamespace

import pytest
from PIL import Image

from tests.paths import PROJECT
from website.editions import EDITIONS, gather

FOR_INSTRUCTORS = {"solutions", "teach_the_course", "grade_a_class", "what_is_protected", "design", "setup"}


def test_students_get_no_page_for_instructors_and_these_get_every_page():
    student = EDITIONS["student"]
    assert student.lessons == "notebooks"
    assert not FOR_INSTRUCTORS & {*student.docs}
    assert not [page for page in student.docs if page.startswith("write_")]
    there = {path.stem for path in (PROJECT / "docs").glob("*.md")}
    assert sorted(EDITIONS["instructor"].docs) == sorted(there)


@pytest.mark.parametrize("edition", EDITIONS.values(), ids=list(EDITIONS))
def test_a_page_links_to_pages_of_its_own_edition_only(edition):
    for page in edition.docs:
        text = (PROJECT / "docs" / f"{page}.md").read_text(encoding="utf-8")
        assert {*re.findall(r"\]\((\w+)\.md", text)} <= {*edition.docs}, page


def texts_of(path):
    """A page's Markdown without its code; a notebook's in its cells."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".ipynb":
        cells = json.loads(text)["cells"]
        text = "\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")
    return re.sub(r"^(````?).*?^\1$|`[^`\n]+`", "", text, flags=re.DOTALL | re.MULTILINE)


@pytest.mark.parametrize("edition", EDITIONS.values(), ids=list(EDITIONS))
def test_what_sphinx_would_read_links_and_shows_only_what_lies_beside_it(edition, tmp_path, monkeypatch):
    # Rubrics, and pictures with fewer colours, take time
    monkeypatch.setattr(Image.Image, "quantize", lambda picture, *given: picture)
    monkeypatch.setattr(Image.Image, "save", lambda picture, path, **given: path.touch())
    course = SimpleNamespace(title="Toy", plan=lambda name: SimpleNamespace(written=()))
    names = sorted(path.stem for path in (PROJECT / edition.lessons).glob("[0-9][0-9]_*.ipynb"))
    gather(edition, course, names, tmp_path / "sources")
    pages = [path for kind in ("md", "ipynb") for path in (tmp_path / "sources").rglob(f"*.{kind}")]
    assert len(pages) == len(names) + len(edition.docs) + 1 + edition.has_solutions
    lost = [
        f"{path.name}: {target}"
        for path in pages
        for target in re.findall(r"\]\(([^)\s#]+)(?:#[^)\s]*)?\)", texts_of(path))
        if "://" not in target and not (path.parent / target).is_file()
    ]
    assert lost == []
