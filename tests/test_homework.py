"""What a student hands in, and what a newer release does to their notebooks: nothing of theirs is ever lost."""

import hashlib
import json
import zipfile
from pathlib import Path

import pytest

from nao_course import homework
from tests.toy import toy

NAME = "90_toy.ipynb"


def cell(name, source, exercise=False, kind="code"):
    """One cell; an exercise's is known by its nbgrader name, any other by its id."""
    metadata = {"nbgrader": {"grade_id": name, "solution": True}} if exercise else {}
    more = {"outputs": [], "execution_count": None} if kind == "code" else {}
    return {"id": name, "cell_type": kind, "metadata": metadata, "source": source} | more


GIVEN = [
    cell("words", "Read this.", kind="markdown"),
    cell("clamp", "def clamp(x):\n    raise NotImplementedError", exercise=True),
    cell("demo", "clamp(3)"),
    cell("why", "*Your answer*", exercise=True, kind="markdown"),
]
NEWER = [cell("words", "Read this, it is new.", kind="markdown"), *GIVEN[1:], cell("more", "clamp(4)")]


def save(path: Path, cells, version="1") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    stamp = {"nao_course": {"lesson": path.stem, "version": version}}
    path.write_text(json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": stamp, "cells": cells}))
    return path


def changed(cells, **sources):
    return [each | {"source": sources.get(each["id"], each["source"])} for each in cells]


def sources(path: Path) -> dict[str, str]:
    return {each["id"]: each["source"] for each in json.loads(path.read_text())["cells"]}


@pytest.fixture
def root(tmp_path):
    """A course's folder in which the first release was laid out."""
    save(tmp_path / "release" / "notebooks" / NAME, GIVEN)
    assert [str(each) for each in homework.renew(tmp_path)] == [f"{NAME}: as released"]
    return tmp_path


@pytest.fixture
def mine(root):
    return root / "notebooks" / NAME


def release(root, cells):
    save(root / "release" / "notebooks" / NAME, cells, version="2")
    return homework.renew(root)


def test_the_same_release_again_touches_nothing(root, mine):
    save(mine, changed(GIVEN, clamp="def clamp(x):\n    return x"))
    before = mine.read_bytes()
    assert homework.renew(root) == []
    assert mine.read_bytes() == before


def test_an_answer_stays_where_a_newer_release_changes_the_text_around_it(root, mine):
    answers = {"clamp": "def clamp(x):\n    return x", "why": "Because."}
    as_it_was = save(mine, changed(GIVEN, **answers)).read_bytes()
    (renewal,) = release(root, NEWER)
    given = {"words": "Read this, it is new.", "demo": "clamp(3)", "more": "clamp(4)"}
    assert sources(mine) == given | answers
    assert (renewal.carried, renewal.lost) == (2, ())
    assert (root / renewal.kept).read_bytes() == as_it_was
    assert str(renewal) == f"{NAME}: renewed with 2 of your cells; your old notebook is in {renewal.kept}"


def test_an_untouched_notebook_that_was_run_is_replaced_and_not_kept(root, mine):
    run = [
        each | {"outputs": [{"output_type": "stream"}]} if each["id"] == "demo" else each for each in GIVEN
    ]
    save(mine, run)
    (renewal,) = release(root, NEWER)
    assert renewal.kept is None and not (mine.parent / "kept").exists()
    assert mine.read_bytes() == (root / "release" / "notebooks" / NAME).read_bytes()


def test_a_cell_of_the_students_own_stands_behind_the_one_it_stood_behind_also_without_metadata(root, mine):
    bare = cell("bare", "print('bare')")
    del bare["metadata"]
    save(mine, [*GIVEN[:2], cell("mine", "print('mine')"), *GIVEN[2:], bare])
    (renewal,) = release(root, NEWER)
    assert list(sources(mine)) == ["words", "clamp", "mine", "demo", "why", "bare", "more"]
    assert renewal.carried == 2


def test_names_of_an_older_release_are_replaced_in_the_students_code_but_not_in_text(root, mine):
    code, text = "noise = FieldOdometry()\nx = seen.about(r)", "I took FieldOdometry."
    save(mine, [*changed(GIVEN, clamp=code, why=text), cell("mine", "FieldOdometry()")])
    release(root, NEWER)
    now = sources(mine)
    assert now["clamp"] == "noise = OdometryNoisePerMove()\nx = seen.linearised_at(r)"
    assert (now["mine"], now["why"]) == ("OdometryNoisePerMove()", text)


def test_a_locked_cell_that_the_student_changed_is_as_in_the_release(root, mine):
    locked = cell("check", "check(clamp)")
    locked["metadata"] = {"nbgrader": {"grade_id": "check", "solution": False, "locked": True}}
    cells = [*GIVEN, locked]
    release(root, cells)
    save(mine, changed(cells, check="pass", clamp="def clamp(x):\n    return x"))
    (renewal,) = release(root, [*cells, cell("more", "clamp(4)")])
    assert sources(mine)["check"] == "check(clamp)"
    assert (renewal.carried, renewal.lost) == (1, ())


def test_an_answer_without_a_place_is_named_and_stands_in_the_kept_notebook(root, mine):
    save(mine, changed(GIVEN, clamp="def clamp(x):\n    return x"))
    (renewal,) = release(root, [each for each in NEWER if each["id"] != "clamp"])
    assert renewal.lost == ("def clamp(x):",)
    assert str(renewal).endswith("Not carried over: 'def clamp(x):'")
    assert sources(root / renewal.kept)["clamp"] == "def clamp(x):\n    return x"


def test_each_renewal_keeps_what_was_there_under_a_name_of_its_own(root, mine):
    kept = []
    for number in range(3):
        save(mine, changed(GIVEN, why=f"answer {number}"))
        (renewal,) = release(root, changed(NEWER, words=f"text {number}"))
        kept.append(renewal.kept)
    (mine.parent / ".given" / NAME).unlink()  # what was given is forgotten
    (renewal,) = release(root, NEWER)
    assert sources(mine)["why"] == "answer 2" and sources(root / renewal.kept)["why"] == "answer 2"
    assert len({*kept, renewal.kept}) == 4
    assert [sources(root / each)["why"] for each in kept] == ["answer 0", "answer 1", "answer 2"]


@pytest.mark.parametrize("content", [b"{ half of it", b"", b"\xff\xfe", b'{"cells": [1]}', b'{"cells": {}}'])
def test_a_notebook_that_cannot_be_read_is_kept_as_it_is(root, mine, content):
    mine.write_bytes(content)
    (renewal,) = release(root, NEWER)
    assert (root / renewal.kept).read_bytes() == content
    assert sources(mine) == {each["id"]: each["source"] for each in NEWER}


@pytest.mark.parametrize("why", ["", "Because."])
def test_a_broken_release_touches_no_notebook_and_says_which_file_it_is(root, mine, why):
    before = save(mine, changed(GIVEN, why=why)).read_bytes() if why else mine.read_bytes()
    (root / "release" / "notebooks" / NAME).write_text("{ half of it")
    with pytest.raises(ValueError, match=f"{NAME} is not a notebook"):
        homework.renew(root)
    assert mine.read_bytes() == before


def test_a_submission_holds_notebooks_helpers_and_a_receipt_of_their_bytes(tmp_path):
    work = tmp_path / "work"
    work.mkdir()
    toy.write(work / NAME, *toy.SOLUTION)
    (work / "helper.py").write_text("x = 1\n")
    (work / homework.REQUEST).write_text("hue_mask: why 0?\n")
    for other in ("notes.ipynb", "data.csv", "kept.txt"):
        (work / other).write_text("{}")
    (work / "link.py").symlink_to(work / "helper.py")
    receipt = homework.submit(work, tmp_path / "out")
    with zipfile.ZipFile(receipt.path) as packed:
        files = {name: packed.read(name) for name in packed.namelist()}
    told = json.loads(files.pop("receipt.json"))
    assert files == {name: (work / name).read_bytes() for name in (NAME, "helper.py", homework.REQUEST)}
    digests = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
    assert receipt.files == told["files"] == digests
    stated = json.dumps({key: told[key] for key in ("time", "files", "versions")}, sort_keys=True)
    assert told["code"] == receipt.code == hashlib.sha256(stated.encode()).hexdigest()
    assert told["time"] == receipt.time
    save(tmp_path / NAME, GIVEN, version="2.1")
    assert homework.submit(tmp_path, tmp_path / "out").versions["release"] == "2.1"


@pytest.mark.parametrize(
    ("files", "said"),
    [
        ({}, "no notebook of a lesson, such as 01_hsl_filtering.ipynb"),
        ({"mine.ipynb": "{}", "helper.py": ""}, "no notebook of a lesson"),
        ({NAME: "{ half of it"}, f"{NAME} is not a notebook"),
        ({NAME: '{"cells": []}', "91_b.ipynb": ""}, "91_b.ipynb is not a notebook"),
        ({NAME: '{"cells": []}', "big.py": "#" * (2**20 + 1)}, "big.py has 1.0 MB, but .* at most 1 MB"),
        ({NAME: '{"cells": []}'} | {f"m{n}.py": "" for n in range(21)}, "21 Python files .* at most 20 are"),
    ],
)
def test_what_cannot_be_handed_in_is_said_and_no_zip_is_written(tmp_path, files, said):
    work = tmp_path / "work"
    work.mkdir()
    for name, content in files.items():
        (work / name).write_text(content)
    with pytest.raises(ValueError, match=said):
        homework.submit(work, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_folder_that_is_none_and_a_notebook_that_is_too_large_are_said(tmp_path, monkeypatch):
    with pytest.raises(ValueError, match="is not a folder: give submit the folder of your notebooks"):
        homework.submit(tmp_path / "nowhere", tmp_path)
    toy.write(tmp_path / NAME, *toy.SOLUTION)
    monkeypatch.setattr(homework, "MOST_BYTES", 100)
    with pytest.raises(ValueError, match="Clear Outputs of All Cells"):
        homework.submit(tmp_path, tmp_path)
