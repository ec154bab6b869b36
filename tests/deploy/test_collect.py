"""What collects a hub's notebooks trusts no student's files, and names folders as the exports need them."""

import os
from datetime import UTC, datetime, timedelta
from itertools import count

import pytest

from nao_course.exercises.notebook_text import MOST_BYTES
from nao_course.instructor.collecting.roster import Roster
from nao_course.instructor.collecting.sheets import read_sheet
from nao_course.instructor.collecting.submissions import gather
from nao_course.instructor.reports.platforms import fill_sheet

LESSON = "01_hsl_filtering.ipynb"
ADA, BEN = "ada@uni.example", "ben@uni.example"
MOODLE = (
    "Identifier,Full name,Email address,Status,Grade,Maximum Grade\n"
    f"Participant 11,Ada Lovelace,{ADA},,,15\nParticipant 22,Ben O_Neil/x,{BEN},,,15\n"
)
CANVAS = f"Student,ID,SIS Login ID,Section\nPoints Possible,,,\nLovelace Ada,11,{ADA},A\nBen,22,{BEN},A\n"


@pytest.fixture
def tools(hub_program):
    return hub_program("collect"), hub_program("names").system_name


@pytest.fixture
def hub(tools, tmp_path):
    """Homes of Ada and Ben, and a function that collects them into a new folder."""
    collect, system_name = tools
    homes, runs = tmp_path / "homes", count()

    def run(sheet=b"", *words):
        out = run.out = tmp_path / f"out-{next(runs)}"
        arguments = [str(out), "--homes", str(homes), *words]
        if sheet:
            (tmp_path / "sheet.csv").write_bytes(sheet)
            arguments += ["--sheet", str(tmp_path / "sheet.csv")]
        status = collect.main(arguments)
        files = [path for path in out.rglob("*") if path.is_file()]
        return status, {str(path.relative_to(out)): path.read_text() for path in files}

    run.ada, run.ben = (homes / system_name(claim) / "notebooks" for claim in (ADA, BEN))
    teacher = homes / "teacher" / "notebooks"
    for folder, text in ((run.ada, ADA), (run.ben, BEN), (teacher, "the solution")):
        folder.mkdir(parents=True)
        (folder / LESSON).write_text(text)
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


@pytest.mark.parametrize(("sheet", "name"), [(MOODLE, "Ada Lovelace"), (CANVAS, "Lovelace Ada")])
def test_with_the_platforms_sheet_a_folder_has_the_students_name_and_number(hub, sheet, name):
    status, found = hub(sheet.encode())
    worlds = found.pop("worlds.csv").splitlines()
    folders = {name.split("/")[0]: content for name, content in found.items()}
    assert status == 0
    assert {name.rpartition("_")[2]: content for name, content in folders.items()} == {"11": ADA, "22": BEN}
    assert f"{name}_11" in folders and all(len(name.split("/")) == 2 for name in found)
    ada, ben = sorted(folders, key=lambda name: name[-2:])
    accounts = {f"{ada},{hub.ada.parent.name}", f"{ben},{hub.ben.parent.name}"}
    assert worlds[0] == "student,world" and set(worlds[1:]) == accounts
    for encoding in ("utf-16", "cp1252"):  # read as by the exports
        assert f"{name}_11/{LESSON}" in hub(sheet.replace(",", ";").encode(encoding))[1]
    assert hub(b"\n")[0] == 0 and hub(b"name,email\n")[0] == 1, "an empty sheet is refused"


def test_what_was_collected_is_graded_under_the_names_that_the_sheet_has(hub, tmp_path):
    hub(MOODLE.encode())
    gathered = gather(hub.out, tmp_path, ["01_hsl_filtering"])
    students = [each.student for each in (*gathered.submissions, *gathered.refused)]
    assert students == ["Ada Lovelace_11", "Ben O Neil x_22"]
    filled = fill_sheet("moodle", tmp_path / "sheet.csv", [])
    assert filled.without_grade == ("Ada Lovelace", "Ben O_Neil/x")


def test_what_was_collected_at_the_deadline_stays_as_it_was(hub, tools, capsys):
    _, before = hub()
    (hub.ada / LESSON).write_text("a week later")
    assert tools[0].main([str(hub.out), "--homes", str(hub.ada.parent.parent)]) == 1
    assert "is not empty" in capsys.readouterr().err
    assert {str(each.relative_to(hub.out)): each.read_text() for each in hub.out.rglob("*.ipynb")} == before


@pytest.mark.parametrize("who", ["address", "account"])
def test_one_student_is_collected_alone(hub, who, capsys):
    ada = hub.ada.parent.name
    assert hub(b"", "--student", ADA.upper() if who == "address" else ada) == (0, {f"{ada}/{LESSON}": ADA})
    status, found = hub(b"", "--student", "eve@uni.example")
    assert status == 1 and found == {} and "there is no such account" in capsys.readouterr().err


def test_a_notebooks_time_is_when_the_system_noticed_its_last_change_and_not_what_the_student_set(
    hub, tmp_path
):
    before = datetime.now(UTC) - timedelta(minutes=1)  # times are read to the minute
    os.utime(hub.ada / LESSON, (0, 0))  # as by `touch --date=1970-01-01`
    (hub.ben / LESSON).rename(hub.ben / "02_goalposts.ipynb")
    status, found = hub(MOODLE.encode(), "--lesson", "01")
    assert status == 0 and "handed_in.csv" in found
    sheet = read_sheet(hub.out / "handed_in.csv", "01_hsl_filtering")
    of_moodle = Roster().with_sheet(read_sheet(tmp_path / "sheet.csv", "01_hsl_filtering").rows)[0]
    assert of_moodle.with_sheet(sheet.rows)[0].students.keys() == of_moodle.students.keys(), (
        "nobody is two people"
    )
    times = sheet.times
    assert list(times) == ["Ada Lovelace_11"], "Ben has no notebook of lesson 01"
    assert before <= datetime.fromisoformat(times["Ada Lovelace_11"]) <= datetime.now(UTC)
    gathered = gather(hub.out, tmp_path, ["01_hsl_filtering", "02_goalposts"])
    assert not gathered.unknown, "grade ignores the tables of the collection"


def test_a_name_that_two_rows_claim_is_nobodys(hub):
    """A student who calls themselves by Ada's address gets no folder with Ada's work."""
    _, found = hub((MOODLE + f"Participant 33,{ADA},eve@uni.example,,,15\n").encode())
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


def test_a_student_may_collect_a_limited_number_of_files_and_bytes(hub, tools, monkeypatch):
    assert tools[0].LARGEST == MOST_BYTES
    with (hub.ada / LESSON).open("wb") as file:
        file.truncate(2**40)  # no space on the disk
    status, found = hub()
    assert status == 1 and list(found) == [f"{hub.ben.parent.name}/{LESSON}"]
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


def test_a_name_depends_on_all_of_a_claim_and_not_on_its_case(tools):
    _, system_name = tools
    claims = ["ada@a.example", "ada@b.example", "a.da@a.example", "Ada Lovelace"]
    claims += ["", "../../etc", "ä" * 300, "0"]
    made = [system_name(each) for each in claims]
    assert len(set(made)) == len(claims)
    assert all(len(each) <= 27 and each.replace("-", "").isalnum() and each.isascii() for each in made)
    assert system_name(" ADA@a.example") == made[0]
