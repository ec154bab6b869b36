"""What collects a hub's notebooks trusts no student's files, and names folders as the exports need them."""

from __future__ import annotations

import os
import sys

import pytest

from nao_course.exercises.notebook_text import MOST_BYTES
from nao_course.instructor.collecting.submissions import gather
from nao_course.instructor.reports.platforms import fill_sheet
from tests.paths import PROJECT

LESSON = "01_hsl_filtering.ipynb"
ADA, BEN = "ada@uni.example", "ben@uni.example"
MOODLE = (
    "Identifier,Full name,Email address,Status,Grade,Maximum Grade\n"
    f"Participant 11,Ada Lovelace,{ADA},,,15\nParticipant 22,Ben O_Neil/x,{BEN},,,15\n"
)
CANVAS = f"Student,ID,SIS Login ID,Section\nPoints Possible,,,\nLovelace Ada,11,{ADA},A\nBen,22,{BEN},A\n"


@pytest.fixture
def tools(monkeypatch):
    monkeypatch.syspath_prepend(str(PROJECT / "deploy" / "hub"))
    import collect
    import names

    yield collect, names.system_name
    for name in ("collect", "names"):
        sys.modules.pop(name)


@pytest.fixture
def hub(tools, tmp_path):
    """Homes of Ada and Ben, and a function that collects them."""
    collect, system_name = tools
    for claim in (ADA, BEN):
        folder = tmp_path / "homes" / system_name(claim) / "notebooks"
        folder.mkdir(parents=True)
        (folder / LESSON).write_text(claim)
    (tmp_path / "homes" / "teacher" / "notebooks").mkdir(parents=True)
    (tmp_path / "homes" / "teacher" / "notebooks" / LESSON).write_text("the solution")

    def run(sheet=""):
        arguments = [str(tmp_path / "out"), "--homes", str(tmp_path / "homes")]
        if sheet != "":
            if sheet is not None:  # else it is there
                (tmp_path / "sheet.csv").write_text(sheet)
            arguments += ["--sheet", str(tmp_path / "sheet.csv")]
        status = collect.main(arguments)
        found = {
            str(path.relative_to(tmp_path / "out")): path.read_text()
            for path in (tmp_path / "out").rglob("*")
            if path.is_file()
        }
        return status, found

    run.ada, run.ben = (tmp_path / "homes" / system_name(claim) / "notebooks" for claim in (ADA, BEN))
    run.out = tmp_path / "out"
    return run


def test_every_students_notebooks_are_copied_and_nobody_elses(hub):
    (hub.ada / "helper.py").write_text("x = 1")
    (hub.ada / "holiday.jpg").write_text("no")
    (hub.ada / "kept").mkdir()
    (hub.ada / "kept" / "01_hsl_filtering-1.ipynb").write_text("old")
    status, found = hub()
    ada, ben = hub.ada.parent.name, hub.ben.parent.name
    assert status == 0
    assert found == {f"{ada}/{LESSON}": ADA, f"{ada}/helper.py": "x = 1", f"{ben}/{LESSON}": BEN}


@pytest.mark.parametrize("sheet", [MOODLE, CANVAS], ids=["moodle", "canvas"])
def test_with_the_platforms_sheet_a_folder_has_the_students_name_and_number(hub, sheet):
    status, found = hub(sheet)
    worlds = found.pop("worlds.csv").splitlines()
    folders = {name.split("/")[0]: content for name, content in found.items()}
    assert status == 0
    assert {name.rpartition("_")[2]: content for name, content in folders.items()} == {"11": ADA, "22": BEN}
    assert all(len(name.split("/")) == 2 for name in found)
    assert next(name for name in folders if name.endswith("_11")) in ("Ada Lovelace_11", "Lovelace Ada_11")
    accounts = {
        f"{name},{hub_of.parent.name}"
        for name, hub_of in zip(sorted(folders, key=lambda name: name[-2:]), (hub.ada, hub.ben), strict=True)
    }
    assert worlds[0] == "student,world" and set(worlds[1:]) == accounts


def test_what_was_collected_is_graded_under_the_names_that_the_sheet_has(hub, tmp_path):
    hub(MOODLE)
    gathered = gather(hub.out, tmp_path, ["01_hsl_filtering"])
    students = [each.student for each in (*gathered.submissions, *gathered.refused)]
    assert students == ["Ada Lovelace_11", "Ben O Neil x_22"]
    filled = fill_sheet("moodle", tmp_path / "sheet.csv", [])
    assert filled.without_grade == ("Participant 11", "Participant 22")


def test_a_name_that_two_rows_claim_is_nobodys(hub):
    """A student who calls themselves by Ada's address gets no folder with Ada's work."""
    _, found = hub(MOODLE + f"Participant 33,{ADA},eve@uni.example,,,15\n")
    assert found[f"{hub.ada.parent.name}/{LESSON}"] == ADA
    assert not any(name.startswith(f"{ADA}_33") for name in found)


def test_links_pipes_and_second_names_are_refused(hub, tmp_path):
    secret = tmp_path / "secret"
    secret.write_text("secret")
    hub.ada.joinpath(LESSON).unlink()
    hub.ada.joinpath(LESSON).symlink_to(secret)
    os.mkfifo(hub.ada / "02_goalposts.ipynb")
    os.link(secret, hub.ada / "03_hough_corners.ipynb")
    (hub.ada / "04_distance.ipynb").mkdir()
    status, found = hub()
    assert status == 1 and found == {f"{hub.ben.parent.name}/{LESSON}": BEN}


@pytest.mark.parametrize("which", ["notebooks", "home"])
def test_a_folder_that_is_a_link_to_a_classmates_is_refused(hub, which):
    (hub.ada / LESSON).unlink()
    hub.ada.rmdir()
    if which == "home":
        hub.ada.parent.rmdir()
        hub.ada.parent.symlink_to(hub.ben.parent)
    else:
        hub.ada.symlink_to(hub.ben)
    status, found = hub()
    assert status == 1 and found == {f"{hub.ben.parent.name}/{LESSON}": BEN}


@pytest.mark.skipif(os.name != "posix" or os.geteuid() != 0, reason="only root can give files away")
def test_a_file_of_somebody_else_is_refused(hub):
    os.chown(hub.ada / LESSON, 12345, 12345)
    status, found = hub()
    assert status == 1 and list(found) == [f"{hub.ben.parent.name}/{LESSON}"]


def test_a_file_of_any_size_costs_no_more_than_the_largest_that_is_graded(hub, tools):
    assert tools[0].LARGEST == MOST_BYTES
    with (hub.ada / LESSON).open("wb") as file:
        file.truncate(2**40)  # no space on the disk
    status, found = hub()
    assert status == 1 and list(found) == [f"{hub.ben.parent.name}/{LESSON}"]


def test_a_student_may_collect_a_limited_number_of_files_and_bytes_and_holes_stay_holes(
    hub, tools, monkeypatch
):
    monkeypatch.setattr(tools[0], "MOST_FILES", 3)
    monkeypatch.setattr(tools[0], "MOST_BYTES", 2**20 + 100)
    (hub.ada / LESSON).unlink()
    with (hub.ada / "a.py").open("wb") as file:
        file.truncate(2**20)
        file.seek(2**19)
        file.write(b"x = 1")
    for name, size in (("b", 60), ("c", 60), ("d", 10)):  # too many bytes with c, too many files with d
        (hub.ada / f"{name}.py").write_bytes(b"y" * size)
    status, found = hub()
    ada, ben = hub.ada.parent.name, hub.ben.parent.name
    assert status == 1 and set(found) == {f"{ada}/a.py", f"{ada}/b.py", f"{ben}/{LESSON}"}
    assert (hub.out / ada / "a.py").read_bytes() == (hub.ada / "a.py").read_bytes()
    assert (hub.out / ada / "a.py").stat().st_blocks * 512 < 2**19


@pytest.mark.parametrize("encoding", ["utf-16", "cp1252"])
def test_the_sheet_is_read_as_by_the_exports_and_an_empty_one_is_refused(hub, tmp_path, encoding):
    (tmp_path / "sheet.csv").write_bytes(MOODLE.replace(",", ";").encode(encoding))
    status, found = hub(sheet=None)
    assert status == 0 and f"Ada Lovelace_11/{LESSON}" in found
    assert hub("\n")[0] == 0 and hub("name,email\n")[0] == 1


def test_a_name_depends_on_all_of_a_claim_and_not_on_its_case(tools):
    _, system_name = tools
    claims = [
        "ada@a.example",
        "ada@b.example",
        "a.da@a.example",
        "Ada Lovelace",
        "",
        "../../etc",
        "ä" * 300,
        "0",
    ]
    made = [system_name(each) for each in claims]
    assert len(set(made)) == len(claims)
    assert all(len(each) <= 27 and each.replace("-", "").isalnum() and each.isascii() for each in made)
    assert system_name(" ADA@a.example") == made[0]
